use crate::machine::Machine;

/// A crankshaft on two supports: bending and shear between them, as the stiffness of how far it departs from the
/// straight line through its supports.
///
/// Deflection d_j = u_j − (1 − z_j/L) u_A − (z_j/L) u_B at disc j, U = ½ dᵀ K d with K the inverse of the influence
/// numbers of a simply supported beam (Timoshenko: bending and shear, shear coefficient 0.9 of a round section),
/// ∫ M_i M_j/(E I) + V_i V_j/(κ G A) dz over a stepped shaft: eccentrics as wide as the discs and as thick as the
/// inner raceways of their bearings, if that is thicker than the shaft. The discs lie side by side, centred between
/// the supports, one tenth of a face width apart. The eccentricity is left out of the sections: their axes count as
/// one.
///
/// Where bearings hold the shaft against leaning as well, its sections' slopes σ against that line,
/// σ_s − (u_B − u_A)/L at all stations, are further entries of d, and couples their loads.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaft {
    /// Stations: both supports, then the discs.
    pub stations: usize,
    /// d over the places u and, where they count, the slopes σ of the stations, row by row.
    pub departures: Vec<f64>,
    /// K in N/m, N and N·m, row by row.
    pub stiffness: Vec<f64>,
    /// Torsional stiffness between planet and the middle of the discs in N·m/rad.
    pub torsion: f64,
}

/// What bends the shaft, at a distance from the first support.
#[derive(Clone, Copy)]
enum Load {
    Force(f64),
    Couple(f64),
}

impl Load {
    /// Bending moment at z and shear force of a unit load on a shaft of length `span`; `at` is a place next to z
    /// that says which side of the load is meant.
    fn section(self, z: f64, at: f64, span: f64) -> [f64; 2] {
        match self {
            Load::Force(a) if at < a => [(1.0 - a / span) * z, 1.0 - a / span],
            Load::Force(a) => [a * (1.0 - z / span), -a / span],
            Load::Couple(a) if at < a => [-z / span, -1.0 / span],
            Load::Couple(_) => [1.0 - z / span, -1.0 / span],
        }
    }
}

/// A piece of the shaft of one diameter, all in m.
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

/// Pieces from support to support, cut at the places of the discs as well.
fn steps(machine: &Machine, places: &[f64]) -> Vec<Step> {
    let span = machine.bearings.crank_support_span;
    let shaft = machine.crankshafts.shaft_diameter;
    let arm = &machine.bearings.turning_arm;
    let eccentric = (arm.pitch_diameter - arm.roller_diameter).max(shaft);
    let half = 0.5 * machine.disc.width;
    let mut cuts = vec![0.0, 0.5 * span, span];
    cuts.extend(places.iter().flat_map(|z| [z - half, *z, z + half]).filter(|z| *z > 0.0 && *z < span));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let step = |pair: &[f64]| {
        let middle = 0.5 * (pair[0] + pair[1]);
        let on_eccentric = places.iter().any(|z| (middle - z).abs() < half);
        Step { from: pair[0], to: pair[1], diameter: if on_eccentric { eccentric } else { shaft } }
    };
    cuts.windows(2).map(step).collect()
}

/// Places of the discs between the supports.
fn places(machine: &Machine) -> Vec<f64> {
    let span = machine.bearings.crank_support_span;
    let count = machine.disc_count;
    // Wide discs on a short span still sit between the supports.
    let pitch = (1.1 * machine.disc.width).min(span / (count as f64 + 1.0));
    (0..count).map(|j| 0.5 * span + (j as f64 - 0.5 * (count as f64 - 1.0)) * pitch).collect()
}

impl Shaft {
    /// `scale` multiplies the stiffness; `leans` says whether slopes count.
    pub fn new(machine: &Machine, scale: f64, leans: bool) -> Shaft {
        let cranks = &machine.crankshafts;
        let span = machine.bearings.crank_support_span;
        let modulus = cranks.material.youngs_modulus;
        let shear = modulus / (2.0 * (1.0 + cranks.material.poisson_ratio));
        let places = places(machine);
        let steps = steps(machine, &places);
        let mut loads: Vec<Load> = places.iter().copied().map(Load::Force).collect();
        let stations: Vec<f64> = [0.0, span].into_iter().chain(places.iter().copied()).collect();
        if leans {
            loads.extend(stations.iter().copied().map(Load::Couple));
        }
        // Simpson's rule is exact for products of what is straight along a step.
        let influence = |a: Load, b: Load| -> f64 {
            let piece = |step: &Step| {
                let (length, middle) = (step.to - step.from, 0.5 * (step.from + step.to));
                let at = |z: f64| [a, b].map(|load| load.section(z, middle, span));
                let bent = |z: f64| at(z)[0][0] * at(z)[1][0];
                let bending = (bent(step.from) + 4.0 * bent(middle) + bent(step.to)) / 6.0;
                let [[_, v], [_, w]] = at(middle);
                let sheared = v * w / (0.9 * shear * step.area());
                length * (bending / (modulus * step.moment_of_area()) + sheared)
            };
            steps.iter().map(piece).sum()
        };
        let count = loads.len();
        let flexibility = nalgebra::DMatrix::from_fn(count, count, |i, j| influence(loads[i], loads[j]));
        let width = stations.len() * if leans { 2 } else { 1 };
        let mut departures = vec![0.0; count * width];
        for (i, (load, row)) in loads.iter().zip(departures.chunks_exact_mut(width)).enumerate() {
            match load {
                Load::Force(z) => {
                    (row[0], row[1]) = (z / span - 1.0, -z / span);
                    row[2 + i] = 1.0;
                }
                Load::Couple(_) => {
                    (row[0], row[1]) = (1.0 / span, -1.0 / span);
                    row[stations.len() + i - places.len()] = 1.0;
                }
            }
        }
        // A flexibility matrix of distinct places is positive definite.
        let bending = modulus * std::f64::consts::PI * cranks.shaft_diameter.powi(4) / 64.0;
        let stiffness = flexibility
            .try_inverse()
            .unwrap_or_else(|| nalgebra::DMatrix::identity(count, count) * (48.0 * bending / span.powi(3)));
        let twist: f64 = steps
            .iter()
            .filter(|step| step.to <= 0.5 * span)
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

    /// One disc at midspan: 48 E I/L³ in series with the shear stiffness 4 κ G A/L.
    #[test]
    fn one_disc_at_midspan_is_the_textbook_beam() {
        let mut machine = crate::templates::tao2024();
        machine.disc_count = 1;
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

    /// A thick eccentric in the middle: 2 ∫ (z/2)²/(E I) in two pieces, shear and twist likewise in series.
    #[test]
    fn a_thick_eccentric_stiffens_the_middle() {
        let mut machine = crate::templates::tao2024();
        machine.disc_count = 1;
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

    /// Free to lean at its stations, the shaft is as stiff as if slopes did not count: couples that vanish change
    /// nothing. Held against leaning at a support, a disc at midspan sees 768/7 E I/L³ of the beam clamped at one end
    /// and supported at the other, 192 E I/L³ if both ends are clamped; a body that turns bends it nowhere.
    #[test]
    fn slopes_held_and_free_are_the_textbook_beams() {
        let mut machine = crate::templates::tao2024();
        let both = Shaft::new(&machine, 1.0, false);
        let leaning = Shaft::new(&machine, 1.0, true);
        let matrix = |shaft: &Shaft, count| nalgebra::DMatrix::from_row_slice(count, count, &shaft.stiffness);
        let flexibility = matrix(&leaning, 6).try_inverse().unwrap();
        let free = flexibility.view((0, 0), (2, 2)).into_owned().try_inverse().unwrap();
        assert!((free - matrix(&both, 2)).abs().max() < 1e-9 * both.stiffness[0]);
        // Turned by 1: the places follow their heights.
        let span = machine.bearings.crank_support_span;
        let turned: Vec<f64> = [0.0, span].into_iter().chain(places(&machine)).chain([1.0; 4]).collect();
        for row in leaning.departures.chunks_exact(8) {
            let departure: f64 = row.iter().zip(&turned).map(|(share, q)| share * q).sum();
            assert!(departure.abs() < 1e-15, "{departure}");
        }

        // Slender, so that shear is next to nothing.
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
}
