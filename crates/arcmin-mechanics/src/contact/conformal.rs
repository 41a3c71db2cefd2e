//! Conformal contact in the plane: a pin in a cylindrical groove of slightly larger radius (Persson 1964).

use std::f64::consts::PI;

use crate::materials::{Material, effective_modulus};

/// A cylinder in a cylindrical groove of slightly larger radius, pressed into the bottom by a line load q in N/m.
///
/// Plane strain, no friction, bodies of similar elasticity (exact for one material, where Dundurs' constants vanish;
/// steel in cast iron is close to it). With b = tan(ε/2) of the half angle ε of contact, B = b² and N = 2 − ln(1 + B)
/// − 2 B²: q = 2π E* ΔR B (1 + B)/N (Persson, *On the stress distribution of cylindrical elastic bodies in contact*,
/// Chalmers 1964; Ciavarella & Decuzzi, Int. J. Solids Struct. 38 (2001) 4507). The approach δ of the pin follows
/// from the same integral equation: 1 + δ/ΔR = (2 − 2B (1 + B) ln(B/(1 + B)) − 2B + B/(1 + B))/N. Displacements of
/// first order in the angle, by which the load reaches the supports, are left out, because they belong to the
/// deformation of the bodies. The half angle of contact is at most 84.8° (N = 0); if ΔR = 0 it has this value at any
/// load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConformalSeat {
    /// ΔR, radius of the groove less that of the pin, in m.
    pub radial_clearance: f64,
    /// E* in Pa, 1/E* = Σ (1 − ν²)/E.
    pub effective_modulus: f64,
}

/// B at N = 0, where the contact angle is largest.
const WIDEST: f64 = 0.834_615;
/// E* δ/q for ΔR = 0 under the cosine pressure (2q/πR) cos θ over the whole groove, where δ is the mean displacement
/// weighted with that pressure: (8/π³) (1 + Σ 4n/(n² − 1)³) over even n. Finite elements of the groove have this
/// displacement under that load.
const COSINE: f64 = 0.335_87;

fn load_shape(b: f64) -> f64 {
    2.0 - b.ln_1p() - 2.0 * b * b
}

impl ConformalSeat {
    /// A pin in a groove whose radius is larger by `radial_clearance` (m); E* is that of the two materials.
    pub fn new(radial_clearance: f64, pin: &Material, groove: &Material) -> ConformalSeat {
        ConformalSeat { radial_clearance, effective_modulus: effective_modulus(pin, groove) }
    }

    /// B at a line load in N/m, by bisection: q increases monotonically with B.
    fn half_angle_parameter(&self, load: f64) -> f64 {
        let wanted = load / (2.0 * PI * self.effective_modulus * self.radial_clearance);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..80 {
            let b = 0.5 * (low + high);
            let shape = load_shape(b);
            if shape > 0.0 && b * (1.0 + b) < wanted * shape {
                low = b;
            } else {
                high = b;
            }
        }
        0.5 * (low + high)
    }

    /// Half angle ε of contact in rad; 0 without load.
    pub fn half_angle(&self, load: f64) -> f64 {
        let b = match (load > 0.0, self.radial_clearance > 0.0) {
            (false, _) => 0.0,
            (true, true) => self.half_angle_parameter(load),
            (true, false) => WIDEST,
        };
        2.0 * b.sqrt().atan()
    }

    /// Approach δ of pin and groove in m at a line load in N/m, zero at first touch.
    pub fn approach(&self, load: f64) -> f64 {
        if load <= 0.0 {
            return 0.0;
        }
        let way = |b: f64| 2.0 - 2.0 * b * (1.0 + b) * (b / (1.0 + b)).ln() - 2.0 * b + b / (1.0 + b);
        let b = if self.radial_clearance > 0.0 { self.half_angle_parameter(load) } else { WIDEST };
        // δ = (way − N) ΔR/N with ΔR/N from the load, which is finite for ΔR = 0.
        let excess = way(b) - if self.radial_clearance > 0.0 { load_shape(b) } else { 0.0 };
        excess * load / (2.0 * PI * self.effective_modulus * b * (1.0 + b))
    }

    /// Approach in m of the pin less its displacement under the cosine pressure over the whole groove: to be added to
    /// the displacement that finite elements of the groove give under that pressure.
    pub fn beyond_full_contact(&self, load: f64) -> f64 {
        (self.approach(load) - COSINE * load.max(0.0) / self.effective_modulus).max(0.0)
    }

    /// d/dq of [`ConformalSeat::beyond_full_contact`] in m²/N, by a central difference of 1 % of the load.
    pub fn tangent_beyond_full_contact(&self, load: f64) -> f64 {
        if load <= 0.0 {
            return 0.0;
        }
        let step = 0.01 * load;
        (self.beyond_full_contact(load + step) - self.beyond_full_contact(load - step)) / (2.0 * step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seat(clearance: f64) -> ConformalSeat {
        ConformalSeat { radial_clearance: clearance, effective_modulus: 1e11 }
    }

    /// Narrow contact is Hertz's with R_eff = R²/ΔR: ε² = 4 q/(π E* ΔR).
    #[test]
    fn narrow_contact_is_hertzs() {
        let seat = seat(20e-6);
        for load in [10.0, 100.0, 1000.0] {
            let hertz = (4.0 * load / (PI * seat.effective_modulus * seat.radial_clearance)).sqrt();
            assert!((seat.half_angle(load) / hertz - 1.0).abs() < 0.01, "{} {hertz}", seat.half_angle(load));
        }
    }

    /// Comparison with the integral equation (R/E*) (p₀ + Σ 2n/(n² − 1) pₙ cos nφ) = (ΔR + δ) cos φ − ΔR over n ≥ 2,
    /// solved by another program with Chebyshev polynomials and a graded Gauss rule (it agrees with both closed forms
    /// to 1e-12): half angle in degrees, q/(2 E* ΔR) as E₁* ΔR/q with E₁* = 2 E*, and δ/ΔR, rounded.
    #[test]
    fn val_persson_against_the_integral_equation() {
        let seat = seat(5e-6);
        for (degrees, inverse_load, way) in [
            (15.0, 35.783_257_7, 0.072_530_61),
            (30.0, 7.943_539_7, 0.218_229_90),
            (45.0, 2.823_121_3, 0.444_722_36),
            (60.0, 1.067_202_4, 0.889_539_70),
            (75.0, 0.287_077_5, 2.615_364_0),
        ] {
            let load = 2.0 * seat.effective_modulus * seat.radial_clearance / inverse_load;
            let angle = seat.half_angle(load).to_degrees();
            assert!((angle / degrees - 1.0).abs() < 1e-5, "{angle} {degrees}");
            let found = seat.approach(load) / seat.radial_clearance;
            assert!((found / way - 1.0).abs() < 1e-7, "{found} {way}");
        }
    }

    /// For ΔR = 0 the contact is a linear spring with a half angle of 84.8° at any load, nearly as stiff as under the
    /// cosine pressure. With clearance it is softer; the difference decreases with the load.
    #[test]
    fn a_fitting_pin_is_linear() {
        assert!(load_shape(WIDEST).abs() < 1e-3, "{}", load_shape(WIDEST));
        let series: f64 = (1..50).map(|m| 2.0 * f64::from(m)).map(|n| 4.0 * n / (n * n - 1.0).powi(3)).sum();
        assert!((COSINE / (8.0 / PI.powi(3) * (1.0 + series)) - 1.0).abs() < 1e-4);
        let fits = seat(0.0);
        assert!((fits.approach(2e4) / fits.approach(1e4) - 2.0).abs() < 1e-12);
        assert!((fits.half_angle(1.0).to_degrees() - 84.8).abs() < 0.1);
        assert!((fits.approach(1e4) * 1e11 / 1e4 / COSINE - 1.0).abs() < 0.02);
        assert!((seat(1e-12).approach(1e4) / fits.approach(1e4) - 1.0).abs() < 1e-3);
        let loose = seat(5e-6);
        let mut last = f64::INFINITY;
        for load in [1e3, 1e4, 1e5] {
            let tangent = loose.tangent_beyond_full_contact(load);
            assert!(tangent > 0.0 && tangent < last, "{load}: {tangent}");
            last = tangent;
        }
    }
}
