use crate::machine::Machine;

/// A crankshaft on two supports: bending and shear between them, as stiffness of the deflections at the
/// discs.
///
/// Deflection d_j = u_j − (1 − z_j/L) u_A − (z_j/L) u_B of the shaft at disc j from the line between the
/// supports, U = ½ dᵀ K d with K the inverse of the influence numbers of a simply supported beam (Timoshenko:
/// bending and shear, shear coefficient 0.9 of a round section), ∫ M_i M_j/(E I) + V_i V_j/(κ G A) dz over a
/// stepped shaft: eccentrics as wide as the discs and as thick as the inner raceways of their bearings, if
/// that is thicker than the shaft. The discs lie side by side, centred between the supports, one tenth of a
/// face width apart. The eccentricity is left out of the sections: their axes count as one.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaft {
    /// z_j/L per disc.
    pub shares: Vec<f64>,
    /// K in N/m, row by row.
    pub stiffness: Vec<f64>,
    /// Torsional stiffness between planet and the middle of the discs in N·m/rad.
    pub torsion: f64,
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

impl Shaft {
    pub fn new(machine: &Machine, scale: f64) -> Shaft {
        let cranks = &machine.crankshafts;
        let count = machine.disc_count;
        let span = machine.bearings.crank_support_span;
        let modulus = cranks.material.youngs_modulus;
        let shear = modulus / (2.0 * (1.0 + cranks.material.poisson_ratio));
        // Wide discs on a short span still sit between the supports.
        let pitch = (1.1 * machine.disc.width).min(span / (count as f64 + 1.0));
        let places: Vec<f64> =
            (0..count).map(|j| 0.5 * span + (j as f64 - 0.5 * (count as f64 - 1.0)) * pitch).collect();
        let steps = steps(machine, &places);
        // Moment and shear force at z of a unit load at a; Simpson's rule is exact for their products.
        let moment = |z: f64, a: f64| if z <= a { (1.0 - a / span) * z } else { a * (1.0 - z / span) };
        let force = |z: f64, a: f64| if z <= a { 1.0 - a / span } else { -a / span };
        let influence = |a: f64, b: f64| -> f64 {
            let piece = |step: &Step| {
                let (length, middle) = (step.to - step.from, 0.5 * (step.from + step.to));
                let product = |z: f64| moment(z, a) * moment(z, b);
                let bent = (product(step.from) + 4.0 * product(middle) + product(step.to)) / 6.0;
                let sheared = force(middle, a) * force(middle, b) / (0.9 * shear * step.area());
                length * (bent / (modulus * step.moment_of_area()) + sheared)
            };
            steps.iter().map(piece).sum()
        };
        let flexibility = nalgebra::DMatrix::from_fn(count, count, |i, j| influence(places[i], places[j]));
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
            shares: places.iter().map(|z| z / span).collect(),
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
        let mut machine = crate::templates::rv_40e_81();
        machine.disc_count = 1;
        let shaft = Shaft::new(&machine, 1.0);
        let (l, d, e, nu) = (0.04f64, 0.018f64, 219e9, 0.3);
        let bending = 48.0 * e * std::f64::consts::PI * d.powi(4) / 64.0 / l.powi(3);
        let shear = 4.0 * 0.9 * e / (2.0 * (1.0 + nu)) * std::f64::consts::PI * d * d / 4.0 / l;
        let expected = 1.0 / (1.0 / bending + 1.0 / shear);
        assert!((shaft.stiffness[0] / expected - 1.0).abs() < 1e-12, "{} {expected}", shaft.stiffness[0]);
        assert!((shaft.shares[0] - 0.5).abs() < 1e-15);
        let torsion = e / (2.0 * (1.0 + nu)) * std::f64::consts::PI * d.powi(4) / 32.0 / (0.5 * l);
        assert!((shaft.torsion / torsion - 1.0).abs() < 1e-12);
    }

    /// A thick eccentric in the middle: 2 ∫ (z/2)²/(E I) in two pieces, shear and twist likewise in series.
    #[test]
    fn a_thick_eccentric_stiffens_the_middle() {
        let mut machine = crate::templates::rv_40e_81();
        machine.disc_count = 1;
        machine.bearings.turning_arm.pitch_diameter = 28.5e-3;
        let shaft = Shaft::new(&machine, 1.0);
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
}
