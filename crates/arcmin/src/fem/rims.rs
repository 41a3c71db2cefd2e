//! The rims of a disc's bores under rollers: they go out of round, where the disc's own reduction keeps them
//! round.

use super::body::{Body, Compliance, NodalLoad, Seat, Traction};
use super::carrier::{SEAT_COORDINATES, rim_tractions, translations};
use super::{Boundary, FemError, Mesh, PlaneDomain, PlaneMesh, RoundHole};
use crate::geometry::{Sector, Vec2, unit};
use crate::machine::{Kinematics, Machine};
use crate::materials::Material;

/// What the finite element model of the rims is made from: a disc with its teeth cut off at the mean radius
/// of the flank, in the frame of the carrier.
#[derive(Debug, Clone, PartialEq)]
pub struct RimShape {
    pub bores: Vec<RoundHole>,
    pub holes: Vec<RoundHole>,
    pub windows: Vec<Sector>,
    /// R_p − r_p in m.
    pub outer_radius: f64,
    pub width: f64,
    pub material: Material,
    /// Edge length in m.
    pub size: f64,
}

const EDGE: usize = 0;
const BORES: usize = 1;
/// Layers of elements across half the width; with one across all of it rims are 0.6 % stiffer.
const LAYERS: usize = 1;

impl RimShape {
    /// The discs of a machine, edges 0.035 R_p long.
    pub fn of(machine: &Machine) -> RimShape {
        let (disc, cranks) = (&machine.disc, &machine.crankshafts);
        let bore = |k| RoundHole {
            centre: machine.gear_stage.centre_distance()
                * unit(Kinematics::crankshaft_angle(cranks.first_angle, k, cranks.count)),
            radius: disc.crank_bore_radius,
        };
        let centre = (disc.centre_hole_radius > 0.0)
            .then(|| RoundHole { centre: Vec2::zeros(), radius: disc.centre_hole_radius });
        let holes = disc.holes.iter().map(|hole| RoundHole {
            centre: hole.centre_radius * unit(hole.centre_angle),
            radius: hole.radius,
        });
        RimShape {
            bores: (0..cranks.count).map(bore).collect(),
            holes: centre.into_iter().chain(holes).collect(),
            windows: disc.windows.clone(),
            outer_radius: machine.ring.pin_circle_radius - machine.ring.pin_radius,
            width: disc.width,
            material: disc.material.clone(),
            size: 0.035 * machine.ring.pin_circle_radius,
        }
    }

    /// Meshes and factorises half the width, its middle plane held to itself as loads that are even across the width leave
    /// it, and held at three places of the edge against rigid motions alone.
    ///
    /// # Errors
    /// [`FemError`] if outlines cross each other.
    pub fn body(&self) -> Result<Body, FemError> {
        let circle = |hole: &RoundHole| Boundary::Circle { centre: hole.centre, radius: hole.radius };
        let edge = Boundary::Circle { centre: Vec2::zeros(), radius: self.outer_radius };
        let mut boundaries = vec![(edge, self.size, 0)];
        boundaries.extend(self.bores.iter().chain(&self.holes).map(|hole| (circle(hole), self.size, 0)));
        boundaries
            .extend(self.windows.iter().map(|window| (Boundary::Outline(window.outline()), self.size, 0)));
        let domain = PlaneDomain { boundaries, interior_size: self.size };
        let (plane, regions) = PlaneMesh::triangulate_regions(&domain, |bits| bits == 1 << EDGE)?;
        let cuts: Vec<f64> = (0..=LAYERS).map(|k| 0.5 * self.width * k as f64 / LAYERS as f64).collect();
        let mesh = Mesh::layered(plane, &cuts, |_, _| true);
        mesh.check()?;
        let near = |place: Vec2| {
            let distance = |node: &usize| (mesh.plane.nodes[*node] - place).norm();
            (0..mesh.plane.corner_count).min_by(|m, n| distance(m).total_cmp(&distance(n))).unwrap_or(0)
        };
        let mut held = vec![[false; 3]; mesh.nodes.len()];
        held[..mesh.plane.nodes.len()].fill([false, false, true]);
        let r = self.outer_radius;
        held[near(Vec2::new(r, 0.0))] = [false, true, true];
        held[near(Vec2::new(-r, 0.0))] = [false, true, true];
        held[near(Vec2::new(0.0, r))] = [true, false, true];
        Body::new(mesh, regions, self.material.clone(), &held)
    }

    /// Per bore [`SEAT_COORDINATES`]. Between rims: the compliance. Between a bore's x, y and a rim: the way
    /// of the bore, seen from the mean motion of the disc's edge, that a load on the rim brings; such loads
    /// are in equilibrium by themselves. Between x, y and x, y: 0, for these ways are in the disc's
    /// reduction.
    ///
    /// # Errors
    /// As [`RimShape::body`].
    pub fn compliance(&self) -> Result<Compliance, FemError> {
        let body = self.body()?;
        let mut loads: Vec<NodalLoad> = Vec::new();
        for (k, bore) in self.bores.iter().enumerate() {
            let seat = Seat::around(BORES + k, 0..LAYERS, bore.centre, bore.radius);
            loads.extend(rim_tractions().map(|traction| body.load(&seat, traction)));
        }
        let count = loads.len();
        let edge = Seat::around(EDGE, 0..LAYERS, Vec2::zeros(), self.outer_radius);
        loads.extend(translations().chain([Traction::Twist]).map(|traction| body.load(&edge, traction)));
        let is_rim = |k: usize| k % SEAT_COORDINATES > 1;
        let rims: Vec<usize> = (0..count).filter(|k| is_rim(*k)).collect();
        let mut values = vec![0.0; count * count];
        for (row, under) in body.rows(&loads, &rims).iter().zip(&rims) {
            let turn = row[count + 2];
            for to in 0..count {
                let (centre, axis) = (self.bores[to / SEAT_COORDINATES].centre, to % SEAT_COORDINATES);
                let rigid = match axis {
                    0 => row[count] - turn * centre.y,
                    1 => row[count + 1] + turn * centre.x,
                    _ => 0.0,
                };
                // Half the width under a unit load: the whole goes half as far.
                let value = 0.5 * (row[to] - rigid);
                if is_rim(to) {
                    values[under * count + to] += 0.5 * value;
                    values[to * count + under] += 0.5 * value;
                } else {
                    values[under * count + to] = value;
                    values[to * count + under] = value;
                }
            }
        }
        Ok(Compliance { count, values })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::materials::Material;

    /// One bore in the middle of a round disc. A pressure p cos 2φ on it, the edge free (Michell: Airy's
    /// function (A/r² + B + C r² + D r⁴) cos 2φ, no shear on either circle): E u = 2A (1 + ν)/r³ + 4B/r
    /// − 2C (1 + ν) r − 4ν D r³; p r (5 − ν)/3 in an infinite sheet. Expansion is Lamé's, and by symmetry the bore
    /// stays where it is.
    #[test]
    fn val_a_hole_in_a_plate() {
        let steel = Material::by_name("GCr15").unwrap();
        let (radius, width) = (5e-3, 4e-3);
        let shape = RimShape {
            bores: vec![RoundHole { centre: Vec2::zeros(), radius }],
            holes: Vec::new(),
            windows: Vec::new(),
            outer_radius: 40e-3,
            width,
            material: steel.clone(),
            size: 2.5e-3,
        };
        let c = shape.compliance().unwrap();
        let (e, nu) = (steel.youngs_modulus, steel.poisson_ratio);
        let pressure = 1.0 / (std::f64::consts::PI * radius * width);
        // In units of the bore's radius.
        let ratio = shape.outer_radius / radius;
        let radial = |r: f64| [-6.0 / r.powi(4), -4.0 / (r * r), -2.0, 0.0];
        let shear = |r: f64| [-6.0 / r.powi(4), -2.0 / (r * r), 2.0, 6.0 * r * r];
        let rows = [radial(1.0), shear(1.0), radial(ratio), shear(ratio)].concat();
        let airy = nalgebra::Matrix4::from_row_slice(&rows)
            .lu()
            .solve(&nalgebra::Vector4::new(-pressure, 0.0, 0.0, 0.0))
            .unwrap();
        let oval = radius / e
            * (2.0 * (1.0 + nu) * airy[0] + 4.0 * airy[1] - 2.0 * (1.0 + nu) * airy[2] - 4.0 * nu * airy[3]);
        let sheet = pressure * radius * (5.0 - nu) / (3.0 * e);
        assert!(oval > sheet && oval < 1.15 * sheet, "{oval:e} {sheet:e}");
        assert!((c.at(3, 3) / oval - 1.0).abs() < 0.01, "{:e} {oval:e}", c.at(3, 3));
        assert!((c.at(4, 4) / c.at(3, 3) - 1.0).abs() < 0.01);
        let square = ratio * ratio;
        let lame = 0.5 * pressure * radius / e * ((square + 1.0) / (square - 1.0) + nu);
        assert!((c.at(2, 2) / lame - 1.0).abs() < 0.01, "{:e} {lame:e}", c.at(2, 2));
        assert!(c.at(0, 3).abs() < 0.02 * c.at(3, 3) && c.at(0, 0) == 0.0);
    }

    /// Reciprocity between the rims of the shipped disc, and its two bores alike.
    #[test]
    fn rims_of_the_shipped_disc() {
        let mut machine = crate::templates::tao2024();
        machine.disc.windows = machine.solids.windows.clone();
        let shape = RimShape::of(&machine);
        let c = shape.compliance().unwrap();
        let n = SEAT_COORDINATES;
        assert_eq!(c.count, 2 * n);
        for k in 2..n {
            let (first, second) = (c.at(k, k), c.at(n + k, n + k));
            assert!((first / second - 1.0).abs() < 0.02, "{k}: {first:e} {second:e}");
        }
        // The web to the root circle is thinner than the metal on the other side: the bore moves out with
        // its rim by much of what the rim gives.
        assert!(c.at(1, 3).abs() > 0.1 * c.at(3, 3), "{:e} {:e}", c.at(1, 3), c.at(3, 3));
    }
}
