use crate::machine::Machine;

/// A crankshaft on two supports: bending and shear between them, as stiffness of the deflections at the
/// discs.
///
/// Deflection d_j = u_j − (1 − z_j/L) u_A − (z_j/L) u_B of the shaft at disc j from the line between the
/// supports, U = ½ dᵀ K d with K the inverse of the influence numbers of a simply supported beam (Timoshenko:
/// bending and shear, shear coefficient 0.9 of a round section). The discs lie side by side, centred between
/// the supports, one tenth of a face width apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaft {
    /// z_j/L per disc.
    pub shares: Vec<f64>,
    /// K in N/m, row by row.
    pub stiffness: Vec<f64>,
    /// Torsional stiffness between planet and the middle of the discs in N·m/rad.
    pub torsion: f64,
}

impl Shaft {
    pub fn new(machine: &Machine, scale: f64) -> Shaft {
        let cranks = &machine.crankshafts;
        let count = machine.disc_count;
        let span = machine.bearings.crank_support_span;
        let d = cranks.shaft_diameter;
        let modulus = cranks.material.youngs_modulus;
        let shear = modulus / (2.0 * (1.0 + cranks.material.poisson_ratio));
        let bending = modulus * std::f64::consts::PI * d.powi(4) / 64.0;
        let shearing = 0.9 * shear * std::f64::consts::PI * d * d / 4.0;
        // Wide discs on a short span still sit between the supports.
        let pitch = (1.1 * machine.disc.width).min(span / (count as f64 + 1.0));
        let places: Vec<f64> =
            (0..count).map(|j| 0.5 * span + (j as f64 - 0.5 * (count as f64 - 1.0)) * pitch).collect();
        let influence = |x: f64, a: f64| {
            let (x, a) = if x <= a { (x, a) } else { (a, x) };
            let b = span - a;
            b * x * (span * span - b * b - x * x) / (6.0 * span * bending) + x * b / (span * shearing)
        };
        let flexibility = nalgebra::DMatrix::from_fn(count, count, |i, j| influence(places[i], places[j]));
        // A flexibility matrix of distinct places is positive definite.
        let stiffness = flexibility
            .try_inverse()
            .unwrap_or_else(|| nalgebra::DMatrix::identity(count, count) * (48.0 * bending / span.powi(3)));
        Shaft {
            shares: places.iter().map(|z| z / span).collect(),
            stiffness: stiffness.iter().map(|k| scale * k).collect(),
            torsion: scale * shear * std::f64::consts::PI * d.powi(4) / 32.0 / (0.5 * span),
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
    }
}
