use crate::fem::quadrature::LINE_4;
use crate::machine::{Machine, RollerBearing, RollerKind};

/// A crankshaft on two supports: bending and shear, as the stiffness against deviations from the straight line
/// through its supports.
///
/// Displacement u and slope σ of a station are those that act on the rollers there: the mean of the deflection
/// over their length l and its slope, ∫ (z − z_s) u dz 12/l³. Accordingly, a force on a station is distributed
/// uniformly over l, a couple as p = 12 (z − z_s)/l³; for zero length (balls) they are point loads. Deviations
/// are d_j = u_j − (1 − z_j/L) u_A − (z_j/L) u_B at disc j and, if bearings resist the tilt of the shaft, also
/// σ_s − (u_B − u_A)/L at all stations. U = ½ dᵀ K d, where K is the inverse of the compliance ∫
/// M_i M_j/(E I) + V_i V_j/(κ G A) dz (Timoshenko, κ = 0.9 for a round section) for the corresponding loads, including the
/// distributed reactions at both supports.
///
/// Rollers deform the section locally: a radial pressure q cos φ/(π a) around it, q the force per length, in
/// equilibrium with the uniform change of the shear force along the shaft, causes the hydrostatic stress q x/(π
/// a²), and the loaded surface is displaced by c q more than the section's mean, c = (1 + ν)(1 − 2ν)/(2π E) in
/// plane strain. The compliance under a force is therefore larger by c/l, under a couple by 12 c/l³, which is
/// as much as bending contributes under the discs. For a comparison with the crankshaft as a solid see
/// `val_crankshaft_is_that_of_calculix`.
///
/// The shaft is stepped: eccentrics with the width of the discs and the diameter of the inner raceways of their
/// bearings, if that is larger than the diameter of the shaft. The discs are side by side, centred between the
/// supports, at a distance of one tenth of a face width. The eccentricity of the sections is neglected: their
/// axes are taken as collinear.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaft {
    /// Stations: both supports, then the discs.
    pub stations: usize,
    /// d over the displacements u and, if included, the slopes σ of the stations, row by row.
    pub departures: Vec<f64>,
    /// K in N/m, N and N·m, row by row.
    pub stiffness: Vec<f64>,
    /// Torsional stiffness between planet and the middle of the discs in N·m/rad.
    pub torsion: f64,
}

/// A row of rollers on the shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Station {
    /// Distance from the first support in m.
    at: f64,
    /// Length of the rollers in m; 0 for balls.
    length: f64,
}

impl Station {
    fn new(at: f64, bearing: &RollerBearing) -> Station {
        let length = match bearing.kind {
            RollerKind::Ball => 0.0,
            RollerKind::Cylindrical | RollerKind::Tapered => bearing.roller_length,
        };
        Station { at, length }
    }

    fn ends(&self) -> [f64; 2] {
        [self.at - 0.5 * self.length, self.at + 0.5 * self.length]
    }

    /// Bending moment and shear force at z for a unit force, ∫ p (z − s) ds and ∫ p ds over s < z.
    fn force(&self, z: f64) -> [f64; 2] {
        let [first, last] = self.ends();
        if z >= last {
            [z - self.at, 1.0]
        } else if z <= first {
            [0.0, 0.0]
        } else {
            let x = z - first;
            [0.5 * x * x / self.length, x / self.length]
        }
    }

    /// The same for a unit couple, ∫ p s ds = 1.
    fn couple(&self, z: f64) -> [f64; 2] {
        let [first, last] = self.ends();
        if z >= last {
            [-1.0, 0.0]
        } else if z <= first {
            [0.0, 0.0]
        } else {
            // From −1 to 1 over the length.
            let x = 2.0 * (z - self.at) / self.length;
            [0.25 * (x * x * x - 3.0 * x - 2.0), 1.5 * (x * x - 1.0) / self.length]
        }
    }
}

impl Station {
    /// Additional mean displacement (for a couple, slope) of the loaded surface relative to the sections, for
    /// the local compliance `introduction` in m²/N. For balls the local deformation is included in their
    /// contact law.
    fn local(&self, couple: bool, introduction: f64) -> f64 {
        match (self.length > 0.0, couple) {
            (false, _) => 0.0,
            (true, false) => introduction / self.length,
            (true, true) => 12.0 * introduction / self.length.powi(3),
        }
    }
}

/// A section of the shaft with constant diameter, all in m.
struct Step {
    from: f64,
    to: f64,
    diameter: f64,
}

impl Step {
    fn moment_of_area(&self) -> f64 {
        std::f64::consts::PI * self.diameter.powi(4) / 64.0
    }

    fn area(&self) -> f64 {
        0.25 * std::f64::consts::PI * self.diameter * self.diameter
    }
}

/// Sections from end to end, divided wherever diameters or loads change.
fn steps(machine: &Machine, stations: &[Station]) -> Vec<Step> {
    let shaft = machine.crankshafts.shaft_diameter;
    let arm = &machine.bearings.turning_arm;
    let eccentric = (arm.pitch_diameter - arm.roller_diameter).max(shaft);
    let half = 0.5 * machine.disc.width;
    let (supports, discs) = stations.split_at(2);
    let [from, _] = supports[0].ends();
    let [_, to] = supports[1].ends();
    let mut cuts = vec![0.0, 0.5 * supports[1].at, supports[1].at];
    cuts.extend(stations.iter().flat_map(|station| station.ends()));
    cuts.extend(discs.iter().flat_map(|disc| [disc.at - half, disc.at, disc.at + half]));
    cuts.retain(|z| *z >= from && *z <= to);
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let step = |pair: &[f64]| {
        let middle = 0.5 * (pair[0] + pair[1]);
        let on_eccentric = discs.iter().any(|disc| (middle - disc.at).abs() < half);
        Step { from: pair[0], to: pair[1], diameter: if on_eccentric { eccentric } else { shaft } }
    };
    cuts.windows(2).map(step).collect()
}

/// Both supports, then the discs between them.
fn stations(machine: &Machine) -> Vec<Station> {
    let bearings = &machine.bearings;
    let span = bearings.crank_support_span;
    let count = machine.disc_count;
    // Wide discs on a short span are still placed between the supports.
    let pitch = (1.1 * machine.disc.width).min(span / (count as f64 + 1.0));
    let supports = [0.0, span].map(|z| Station::new(z, &bearings.crank_support));
    let place = |j: usize| 0.5 * span + (j as f64 - 0.5 * (count as f64 - 1.0)) * pitch;
    let discs = (0..count).map(|j| Station::new(place(j), &bearings.turning_arm));
    supports.into_iter().chain(discs).collect()
}

/// d over displacements and, if included, slopes of the stations, row by row. A row also contains the forces
/// and couples on the stations of the corresponding load.
fn departures(stations: &[Station], tilts: bool) -> Vec<f64> {
    let (count, span) = (stations.len(), stations[1].at);
    let width = count * if tilts { 2 } else { 1 };
    let mut rows = vec![0.0; (width - 2) * width];
    for (i, row) in rows.chunks_exact_mut(width).enumerate() {
        // The deviation of both supports from the line through them is zero.
        row[2 + i] = 1.0;
        (row[0], row[1]) = match stations.get(2 + i) {
            Some(disc) => (disc.at / span - 1.0, -disc.at / span),
            None => (1.0 / span, -1.0 / span),
        };
    }
    rows
}

impl Shaft {
    /// `scale` multiplies the stiffness; `tilts`: whether slopes are included.
    pub fn new(machine: &Machine, scale: f64, tilts: bool) -> Shaft {
        let cranks = &machine.crankshafts;
        let span = machine.bearings.crank_support_span;
        let modulus = cranks.material.youngs_modulus;
        let shear = modulus / (2.0 * (1.0 + cranks.material.poisson_ratio));
        let stations = stations(machine);
        let steps = steps(machine, &stations);
        let departures = departures(&stations, tilts);
        let width = stations.len() * if tilts { 2 } else { 1 };
        let count = width - 2;
        let mut flexibility = nalgebra::DMatrix::zeros(count, count);
        for step in &steps {
            // Moments of distributed couples are cubic: four points are exact for their products.
            for (share, weight) in LINE_4 {
                let z = step.from + share * (step.to - step.from);
                let units: Vec<[f64; 2]> = (0..width)
                    .map(|c| match stations.get(c) {
                        Some(station) => station.force(z),
                        None => stations[c - stations.len()].couple(z),
                    })
                    .collect();
                let sections: Vec<[f64; 2]> = departures
                    .chunks_exact(width)
                    .map(|row| [0, 1].map(|part| row.iter().zip(&units).map(|(d, u)| d * u[part]).sum()))
                    .collect();
                let length = weight * (step.to - step.from);
                let bending = length / (modulus * step.moment_of_area());
                let sheared = length / (0.9 * shear * step.area());
                for i in 0..count {
                    for j in 0..count {
                        let ([m, v], [n, w]) = (sections[i], sections[j]);
                        flexibility[(i, j)] += bending * m * n + sheared * v * w;
                    }
                }
            }
        }
        let introduction = (1.0 + cranks.material.poisson_ratio)
            * (1.0 - 2.0 * cranks.material.poisson_ratio)
            / (std::f64::consts::TAU * modulus);
        for c in 0..width {
            let local = stations[c % stations.len()].local(c >= stations.len(), introduction);
            for i in 0..count {
                for j in 0..count {
                    flexibility[(i, j)] += departures[i * width + c] * local * departures[j * width + c];
                }
            }
        }
        // The compliance matrix of different positions is positive definite.
        let bending = modulus * std::f64::consts::PI * cranks.shaft_diameter.powi(4) / 64.0;
        let stiffness = flexibility
            .try_inverse()
            .unwrap_or_else(|| nalgebra::DMatrix::identity(count, count) * (48.0 * bending / span.powi(3)));
        let twist: f64 = steps
            .iter()
            .filter(|step| step.from >= 0.0 && step.to <= 0.5 * span)
            .map(|step| (step.to - step.from) / (2.0 * shear * step.moment_of_area()))
            .sum();
        Shaft {
            stations: stations.len(),
            departures,
            stiffness: stiffness.iter().map(|k| scale * k).collect(),
            torsion: scale / twist,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The shipped machine with a number of discs, its shaft under point loads.
    fn pointed(discs: usize) -> Machine {
        let mut machine = crate::templates::tao2024();
        machine.disc_count = discs;
        machine.bearings.crank_support.roller_length = 0.0;
        machine.bearings.turning_arm.roller_length = 0.0;
        machine
    }

    /// One disc at midspan: 48 E I/L³ in series with the shear stiffness 4 κ G A/L.
    #[test]
    fn one_disc_at_midspan_is_the_textbook_beam() {
        let machine = pointed(1);
        let shaft = Shaft::new(&machine, 1.0, false);
        let (l, d, e, nu) = (0.04f64, 0.018f64, 219e9, 0.3);
        let bending = 48.0 * e * std::f64::consts::PI * d.powi(4) / 64.0 / l.powi(3);
        let shear = 4.0 * 0.9 * e / (2.0 * (1.0 + nu)) * std::f64::consts::PI * d * d / 4.0 / l;
        let expected = 1.0 / (1.0 / bending + 1.0 / shear);
        assert!((shaft.stiffness[0] / expected - 1.0).abs() < 1e-12, "{} {expected}", shaft.stiffness[0]);
        assert_eq!(shaft.departures, [-0.5, -0.5, 1.0]);
        let torsion = e / (2.0 * (1.0 + nu)) * std::f64::consts::PI * d.powi(4) / 32.0 / (0.5 * l);
        assert!((shaft.torsion / torsion - 1.0).abs() < 1e-12);
    }

    /// A thick eccentric in the middle: 2 ∫ (z/2)²/(E I) in two sections; shear and torsion correspondingly in
    /// series.
    #[test]
    fn a_thick_eccentric_stiffens_the_middle() {
        let mut machine = pointed(1);
        machine.bearings.turning_arm.pitch_diameter = 28.5e-3;
        let shaft = Shaft::new(&machine, 1.0, false);
        let (l, w, e, nu) = (0.04f64, 8.75e-3, 219e9, 0.3);
        let g = e / (2.0 * (1.0 + nu));
        let area = |d: f64| std::f64::consts::PI * d * d / 4.0;
        let inertia = |d: f64| std::f64::consts::PI * d.powi(4) / 64.0;
        let (thin, thick) = (18e-3, 24e-3);
        let c = 0.5 * (l - w);
        let bent = (c.powi(3) / inertia(thin) + ((0.5 * l).powi(3) - c.powi(3)) / inertia(thick)) / (6.0 * e);
        let sheared = 0.5 * (c / area(thin) + 0.5 * w / area(thick)) / (0.9 * g);
        let expected = 1.0 / (bent + sheared);
        assert!((shaft.stiffness[0] / expected - 1.0).abs() < 1e-12, "{} {expected}", shaft.stiffness[0]);
        let twist = (c / inertia(thin) + 0.5 * w / inertia(thick)) / (2.0 * g);
        assert!((shaft.torsion * twist - 1.0).abs() < 1e-12);
    }

    /// With free slopes at its stations the shaft has the same stiffness as without slopes as coordinates,
    /// because couples are zero. With the slope held at a support, a disc at midspan has 768/7 E I/L³ of the
    /// beam clamped at one end and supported at the other, and 192 E I/L³ if both are held; a rigid rotation
    /// causes no bending.
    #[test]
    fn slopes_held_and_free_are_the_textbook_beams() {
        let mut machine = pointed(2);
        let both = Shaft::new(&machine, 1.0, false);
        let tilting = Shaft::new(&machine, 1.0, true);
        let matrix = |shaft: &Shaft, count| nalgebra::DMatrix::from_row_slice(count, count, &shaft.stiffness);
        let flexibility = matrix(&tilting, 6).try_inverse().unwrap();
        let free = flexibility.view((0, 0), (2, 2)).into_owned().try_inverse().unwrap();
        assert!((free - matrix(&both, 2)).abs().max() < 1e-9 * both.stiffness[0]);
        // Rotated by 1: the displacements equal the heights.
        let turned: Vec<f64> = stations(&machine).iter().map(|station| station.at).chain([1.0; 4]).collect();
        for row in tilting.departures.chunks_exact(8) {
            let departure: f64 = row.iter().zip(&turned).map(|(share, q)| share * q).sum();
            assert!(departure.abs() < 1e-15, "{departure}");
        }

        // Slender, so that shear is negligible.
        machine.disc_count = 1;
        machine.crankshafts.shaft_diameter = 1e-4;
        machine.bearings.turning_arm.pitch_diameter = 1e-4;
        machine.bearings.turning_arm.roller_diameter = 1e-5;
        let shaft = Shaft::new(&machine, 1.0, true);
        let (l, e) = (machine.bearings.crank_support_span, machine.crankshafts.material.youngs_modulus);
        let inertia = std::f64::consts::PI * 1e-4f64.powi(4) / 64.0;
        let flexibility = matrix(&shaft, 4).try_inverse().unwrap();
        let midspan = |held: &[usize]| {
            let kept: Vec<usize> = (0..4).filter(|i| *i == 0 || held.contains(i)).collect();
            let part =
                nalgebra::DMatrix::from_fn(kept.len(), kept.len(), |i, j| flexibility[(kept[i], kept[j])]);
            part.try_inverse().unwrap()[(0, 0)] * l.powi(3) / (e * inertia)
        };
        for (held, expected) in [(&[][..], 48.0), (&[1], 768.0 / 7.0), (&[1, 2], 192.0)] {
            let found = midspan(held);
            assert!((found / expected - 1.0).abs() < 1e-4, "{held:?}: {found}");
        }
    }

    /// Under forces and couples distributed over the rollers, deviations agree with the superposition of point
    /// loads: ∬ p_c(s) G(s, t) p_d(t) ds dt, with G of the same uniform shaft clamped at its end, x²(3y − x)/(6
    /// E I) + x/(κ G A), x being the smaller of the two distances from there.
    #[test]
    fn loads_spread_over_the_rollers_are_superposed_point_loads() {
        let machine = crate::templates::tao2024();
        let stations = stations(&machine);
        assert!((stations[0].length - 9e-3).abs() < 1e-12);
        let rows = departures(&stations, true);
        let (d, e) = (machine.crankshafts.shaft_diameter, machine.crankshafts.material.youngs_modulus);
        let (pi, nu) = (std::f64::consts::PI, machine.crankshafts.material.poisson_ratio);
        let bending = e * pi * d.powi(4) / 64.0;
        let sheared = 0.9 * e / (2.0 * (1.0 + nu)) * pi * d * d / 4.0;
        let [from, _] = stations[0].ends();
        let green = |s: f64, t: f64| {
            let (x, y) = ((s - from).min(t - from), (s - from).max(t - from));
            x * x * (3.0 * y - x) / (6.0 * bending) + x / sheared
        };
        const POINTS: usize = 400;
        // Positions and weights of a force, then of a couple, on a station.
        let spread = |c: usize| -> Vec<(f64, f64)> {
            let Station { at, length } = stations[c % stations.len()];
            let place = |k: usize| ((k as f64 + 0.5) / POINTS as f64 - 0.5) * length;
            let weight = |x: f64| if c < stations.len() { 1.0 } else { 12.0 * x / (length * length) };
            (0..POINTS).map(|k| (at + place(k), weight(place(k)) / POINTS as f64)).collect()
        };
        let width = 2 * stations.len();
        let loads: Vec<_> = (0..width).map(spread).collect();
        let between = nalgebra::DMatrix::from_fn(width, width, |c, d| {
            let along =
                |(s, p): &(f64, f64)| loads[d].iter().map(|(t, q)| p * q * green(*s, *t)).sum::<f64>();
            loads[c].iter().map(along).sum::<f64>()
        });
        let introduction = (1.0 + nu) * (1.0 - 2.0 * nu) / (2.0 * pi * e);
        let local = nalgebra::DMatrix::from_fn(width, width, |c, d| {
            let station = &stations[c % stations.len()];
            if c == d { station.local(c >= stations.len(), introduction) } else { 0.0 }
        });
        let rows = nalgebra::DMatrix::from_row_slice(width - 2, width, &rows);
        let expected = &rows * (between + local) * rows.transpose();
        let shaft = Shaft::new(&machine, 1.0, true);
        let found =
            nalgebra::DMatrix::from_row_slice(width - 2, width - 2, &shaft.stiffness).try_inverse().unwrap();
        for i in 0..width - 2 {
            for j in 0..width - 2 {
                let size = (expected[(i, i)] * expected[(j, j)]).sqrt();
                let apart = (found[(i, j)] - expected[(i, j)]).abs() / size;
                assert!(apart < 1e-4, "{i} {j}: {:e} {:e}", found[(i, j)], expected[(i, j)]);
            }
        }
    }

    /// The crankshaft of the shipped machine as a solid of 5101 C3D10 elements with its eccentrics in their
    /// positions, under the same loads (`machine_bodies.py`): its compliance along the eccentricity, where
    /// sections overlap less, is up to a tenth larger than perpendicular to it. The beam has no preferred
    /// direction and is close to the mean of both.
    #[test]
    fn val_crankshaft_is_that_of_calculix() {
        let rows = include_str!("../../../../../validation/CalculiX/crankshaft.csv");
        let record = |name: &str| -> f64 {
            let mut all = rows.lines().map(|line| line.split(',').collect::<Vec<_>>());
            all.find(|row| row[0] == name).unwrap()[1].parse().unwrap()
        };
        let shaft = Shaft::new(&crate::templates::tao2024(), 1.0, true);
        let found = nalgebra::DMatrix::from_row_slice(6, 6, &shaft.stiffness).try_inverse().unwrap();
        let names = ["disc0", "disc1", "slope_support0", "slope_support1", "slope_disc0", "slope_disc1"];
        let mut apart = 0.0_f64;
        for i in 0..6 {
            for j in 0..6 {
                let [along, across] =
                    ["along", "across"].map(|way| record(&format!("{way}_{}_{}", names[i], names[j])));
                let share = (found[(i, j)] - 0.5 * (along + across)) / (found[(i, i)] * found[(j, j)]).sqrt();
                println!("{} {}: {share:+.3}", names[i], names[j]);
                apart = apart.max(share.abs());
            }
        }
        assert!(apart < 0.08, "{apart}");
    }
}
