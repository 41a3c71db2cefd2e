//! The carrier as an elastic body: plates, pillars, crank bores, held at its output face.

use super::body::{Body, Compliance, NodalLoad, Seat, Traction};
use super::symmetry::{Mirrors, Symmetric, SymmetricPart, reflected, reflection_sign};
use super::{Boundary, FemError, Mesh, PlaneDomain, PlaneMesh};
use crate::geometry::{Sector, Vec2, unit};
use crate::machine::{CarrierSolid, Hold, Kinematics, Machine};
use crate::materials::Material;

/// Highest order of ovalisation of the rim of a crank seat. The outer ring distributes the force of a roller, so that
/// higher orders do not reach the seat.
pub const RIM_ORDER: usize = 4;
/// Coordinates of one crank seat: x, y, expansion, and cosine and sine of the orders 2 to [`RIM_ORDER`].
pub const SEAT_COORDINATES: usize = 3 + 2 * (RIM_ORDER - 1);

/// Number of these coordinates that describe the ovalisation.
pub const RIM_COORDINATES: usize = SEAT_COORDINATES - 2;

/// Geometry of the finite element model of a carrier. x, y of the carrier's own frame, z from its input end
/// to the output face.
#[derive(Debug, Clone, PartialEq)]
pub struct CarrierShape {
    /// Dimensions of plates, pillars and bores.
    pub solid: CarrierSolid,
    /// Axes of the crankshafts in m.
    pub cranks: Vec<Vec2>,
    /// Elastic constants and density.
    pub material: Material,
    /// Edge length in m.
    pub size: f64,
    /// Layers of elements through each plate and through the gap.
    pub layers: [usize; 2],
}

/// Curves of the section, in this order.
const PLATE: usize = 0;
const CENTRE: usize = 1;
const CRANKS: usize = 2;

impl CarrierShape {
    /// The carrier of a machine, edges 0.075 R_p long, four layers through a plate (with two the seat at the
    /// held end is 3 % too stiff, with three 1.1 %) and three through the gap.
    pub fn of(machine: &Machine) -> CarrierShape {
        let cranks = &machine.crankshafts;
        let place = |k| {
            machine.gear_stage.centre_distance()
                * unit(Kinematics::crankshaft_angle(cranks.first_angle, k, cranks.count))
        };
        CarrierShape {
            solid: machine.solids.carrier.clone(),
            cranks: (0..cranks.count).map(place).collect(),
            material: machine.carrier.material.clone(),
            size: 0.075 * machine.ring.pin_circle_radius,
            layers: [4, 3],
        }
    }

    fn domain(&self) -> PlaneDomain {
        let solid = &self.solid;
        let circle = |centre: Vec2, radius: f64| Boundary::Circle { centre, radius };
        let mut boundaries = vec![
            (circle(Vec2::zeros(), solid.plate_radius), self.size, 0),
            (circle(Vec2::zeros(), solid.centre_bore_radius), self.size, 0),
        ];
        boundaries
            .extend(self.cranks.iter().map(|place| (circle(*place, solid.crank_seat_radius), self.size, 0)));
        let pillars = solid.pillars.iter().map(|pillar| Boundary::Outline(pillar.outline()));
        boundaries.extend(pillars.map(|outline| (outline, self.size, 0)));
        PlaneDomain { boundaries, interior_size: self.size }
    }

    fn pillar_bits(&self) -> u64 {
        let first = CRANKS + self.cranks.len();
        (first..first + self.solid.pillars.len()).map(|k| 1 << k).sum()
    }

    fn is_plate(&self, bits: u64) -> bool {
        let bores: u64 = (CENTRE..CRANKS + self.cranks.len()).map(|k| 1 << k).sum();
        bits & (1 << PLATE) != 0 && bits & bores == 0
    }

    /// Heights between layers of elements.
    fn cuts(&self) -> Vec<f64> {
        let CarrierSolid { plate_thickness: t, gap, .. } = self.solid;
        let [plate, between] = self.layers.map(|layers| layers.max(1));
        let split = |from: f64, height: f64, layers: usize| {
            (0..layers).map(move |k| from + height * k as f64 / layers as f64)
        };
        let lower = split(0.0, t, plate).chain(split(t, gap, between));
        lower.chain(split(t + gap, t, plate)).chain([2.0 * t + gap]).collect()
    }

    /// Layers of the plates at either end.
    fn ends(&self) -> [std::ops::Range<usize>; 2] {
        let [plate, between] = self.layers.map(|layers| layers.max(1));
        [0..plate, plate + between..2 * plate + between]
    }

    /// The crankshaft at a position.
    fn crank_at(&self, place: Vec2) -> Option<usize> {
        self.cranks.iter().position(|crank| (crank - place).norm() < 1e-9 * self.solid.plate_radius)
    }

    /// Index of the first coordinate of a crank seat; `end` is 0 at the input.
    pub fn seat(&self, crankshaft: usize, end: usize) -> usize {
        (2 * crankshaft + end) * SEAT_COORDINATES
    }

    /// Index of x of a main bearing's seat.
    pub fn main_seat(&self, end: usize) -> usize {
        2 * self.cranks.len() * SEAT_COORDINATES + 2 * end
    }

    /// Compliance of all interface coordinates: per crankshaft and end (input, output) [`SEAT_COORDINATES`], then x and
    /// y of the main bearing's seat on the plate at either end.
    ///
    /// # Errors
    /// [`FemError`] if outlines cross each other or a pillar's sides do not fit its corners.
    pub fn compliance(&self) -> Result<Compliance, FemError> {
        self.compliance_of(self.mirrors())
    }
}

impl Symmetric for CarrierShape {
    /// Common symmetry planes of crankshafts and pillars through the axis.
    fn mirrors(&self) -> Mirrors {
        let near = 1e-9 * self.solid.plate_radius;
        let is_mirror_symmetric = |mirror: usize| {
            let cranks = self.cranks.iter().all(|place| self.crank_at(reflected(*place, mirror)).is_some());
            let pillars = self.solid.pillars.iter().all(|pillar| {
                let shown = reflected(pillar.outer_radius * unit(pillar.centre_angle), mirror);
                self.solid.pillars.iter().any(|other| {
                    let as_large = Sector { centre_angle: pillar.centre_angle, ..*other } == *pillar;
                    as_large && (other.outer_radius * unit(other.centre_angle) - shown).norm() < near
                })
            });
            cranks && pillars
        };
        Mirrors::of(is_mirror_symmetric(0), is_mirror_symmetric(1))
    }

    fn material(&self) -> &Material {
        &self.material
    }

    fn mesh_part(&self, mirrors: Mirrors) -> Result<SymmetricPart, FemError> {
        if let Some(pillar) = self.solid.pillars.iter().find(|pillar| !pillar.is_sound()) {
            return Err(FemError::Mesh {
                reason: format!(
                    "no pillar between {pillar:?}: radii, width and corners contradict each other"
                ),
            });
        }
        let (plane, regions) =
            PlaneMesh::triangulate_part(&self.domain(), mirrors, |bits| self.is_plate(bits))?;
        let (ends, pillars) = (self.ends(), self.pillar_bits());
        let mesh = Mesh::layered(plane, &self.cuts(), |layer, triangle| {
            ends.iter().any(|plate| plate.contains(&layer)) || regions[triangle] & pillars != 0
        });
        mesh.check()?;
        let per_level = mesh.plane.nodes.len();
        let top = mesh.nodes.len() - per_level;
        // Junction of pillar and plate, and the edge of the held face over a pillar.
        let feet = [ends[0].end, ends[1].start].map(|layer| 2 * layer * per_level);
        let rim = (self.solid.hold != Hold::Face).then_some(top);
        let mut sharp = vec![false; mesh.nodes.len()];
        for first in feet.into_iter().chain(rim) {
            for pillar in 0..self.solid.pillars.len() {
                let outline = mesh.plane.nodes_of(CRANKS + self.cranks.len() + pillar);
                outline.into_iter().for_each(|node| sharp[first + node] = true);
            }
        }
        let mesh = mesh.drawn_towards(&sharp);
        let mut held = vec![[false; 3]; mesh.nodes.len()];
        for (triangle, bits) in mesh.plane.triangles.iter().zip(&regions) {
            if self.solid.hold == Hold::Face || bits & pillars != 0 {
                triangle.iter().for_each(|node| held[top + node] = [true; 3]);
            }
        }
        Ok(SymmetricPart { mesh, regions, held })
    }

    fn loads(&self, body: &Body) -> Vec<NodalLoad> {
        let ends = self.ends();
        let mut loads = Vec::new();
        for (k, centre) in self.cranks.iter().enumerate() {
            for layers in &ends {
                let seat = Seat::around(CRANKS + k, layers.clone(), *centre, self.solid.crank_seat_radius);
                loads.extend(rim_tractions().map(|traction| body.load(&seat, traction)));
            }
        }
        for layers in &ends {
            let seat = Seat::around(PLATE, layers.clone(), Vec2::zeros(), self.solid.plate_radius);
            loads.extend(translations().map(|traction| body.load(&seat, traction)));
        }
        loads
    }

    /// φ goes to −φ in y = 0, to π − φ in x = 0.
    fn reflected(&self, coordinate: usize, mirror: usize) -> (usize, f64) {
        let main = self.main_seat(0);
        if coordinate >= main {
            return (coordinate, reflection_sign((coordinate - main) % 2, mirror));
        }
        let (seat, component) = (coordinate / SEAT_COORDINATES, coordinate % SEAT_COORDINATES);
        let (crank, end) = (seat / 2, seat % 2);
        let to = self.crank_at(reflected(self.cranks[crank], mirror)).unwrap_or(crank);
        // x, y, expansion, and pairs of cosine and sine of the orders from 2 on.
        let (order, sine) = match component {
            0 | 1 => (1, component == 1),
            2 => (0, false),
            _ => (2 + (component - 3) / 2, component % 2 == 0),
        };
        let turns = match mirror {
            0 => (order + usize::from(sine)) % 2 == 1,
            _ => sine,
        };
        (self.seat(to, end) + component, if turns { -1.0 } else { 1.0 })
    }
}

/// Unit forces along x and y.
pub(super) fn translations() -> impl Iterator<Item = Traction> {
    [0.0, std::f64::consts::FRAC_PI_2].into_iter().map(|from| Traction::Radial { order: 1, from })
}

/// All coordinates of a rim under rollers.
pub(super) fn rim_tractions() -> impl Iterator<Item = Traction> {
    let quarter = |order: usize| std::f64::consts::FRAC_PI_2 / order as f64;
    let pair =
        move |order| [0.0, quarter(order)].into_iter().map(move |from| Traction::Radial { order, from });
    translations().chain([Traction::Expansion]).chain((2..=RIM_ORDER).flat_map(pair))
}
