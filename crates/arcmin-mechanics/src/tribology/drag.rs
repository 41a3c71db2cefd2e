//! Losses that do not depend on the torque: lips of seals, lubricant and preload in rolling bearings.

use crate::units::RPM;

/// Friction of a lip seal per square of the diameter that it runs on, N·m/m².
///
/// A lip with the friction force f per length of its circumference has the moment M = π d f · d/2, so M/d² = π
/// f/2. Here f = 155 N/m: 4 N·m on 128 mm, a new, cold, greased lip. Published: 47 N/m (ISO/TR 14179-2, P =
/// 7.69·10⁻⁶ d² n), 72 N/m (DIN 3996, 11.78·10⁻⁶ d² n), 141 N/m (Linke at 20 °C with ISO VG 150); P in W, d in
/// mm, n in rpm. So the value is slightly above the largest of these.
const SEAL_DRAG: f64 = 4.0 / (0.128 * 0.128);

/// Drag torque in N·m of one lip seal at 20 °C that runs on `diameter` (m): 244 N/m · d². Assumed seals scale so.
pub fn seal_drag(diameter: f64) -> f64 {
    SEAL_DRAG * diameter * diameter
}

/// Drag of a lip seal at a temperature in °C relative to that at 20 °C, for an oil of ν₄₀ in m²/s.
///
/// Linke, Stirnradverzahnung (Hanser 2010): P = [145 − 1.6 ϑ + 350 lg lg(ν₄₀ + 0.8)] d² n · 10⁻⁷, ν in mm²/s.
/// Used from −20 to 120 °C; beyond, the value at the end of this range.
pub fn seal_share(celsius: f64, at_40c: f64) -> f64 {
    let grade = 350.0 * (at_40c * 1e6 + 0.8).max(1.1).log10().log10();
    let at = |celsius: f64| (145.0 - 1.6 * celsius.clamp(-20.0, 120.0) + grade).max(1.0);
    at(celsius) / at(20.0)
}

/// Palmgren's moment of a rolling bearing without load in N·m: M₀ = f₀ (ν n)^(2/3) d_m³ · 10⁻⁷ N·mm for ν n of 2000
/// and more, constant below (160·10⁻⁷ f₀ d_m³ as printed, which is 0.8 % more); ν in mm²/s, n in rpm, d_m in mm.
///
/// `viscosity` in m²/s (of a grease: that of its base oil), relative `speed` in rad/s, `pitch_diameter` in m. f₀ by
/// kind and lubrication: Harris, Rolling Bearing Analysis, table 10.3; SKF General Catalogue 4000. Valid for
/// bearings up to some hundred mm whose grease has settled; freshly filled ones drag some times more.
pub fn lubricant_moment(factor: f64, viscosity: f64, speed: f64, pitch_diameter: f64) -> f64 {
    let product = (viscosity * 1e6 * speed.abs() / RPM).max(2000.0);
    // 10⁻⁷ N·mm/mm³ are 0.1 N·m/m³.
    factor * product.powf(2.0 / 3.0) * 0.1 * pitch_diameter.powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: f₀ 2, 100 mm²/s, 1000 rpm, 50 mm: (1e5)^(2/3) = 2154.4, times 2 · 1.25e5 · 1e-7 = 53.86 N·mm.
    /// At low speed the constant of Palmgren applies, within his rounding.
    #[test]
    fn palmgren_by_hand() {
        let moment = lubricant_moment(2.0, 100e-6, 1000.0 * RPM, 50e-3);
        assert!((moment / 53.86e-3 - 1.0).abs() < 1e-4, "{moment}");
        let (slow, still) =
            (lubricant_moment(6.0, 100e-6, 10.0 * RPM, 26e-3), lubricant_moment(6.0, 100e-6, 0.0, 26e-3));
        assert_eq!(slow, still);
        assert!((still / (160e-7 * 6.0 * 26f64.powi(3) * 1e-3) - 1.0).abs() < 0.01, "{still}");
        assert_eq!(lubricant_moment(1.0, 1e-4, -100.0, 0.05), lubricant_moment(1.0, 1e-4, 100.0, 0.05));
    }

    /// The seal torque is proportional to the square of the diameter and larger than by the three published
    /// rules, within a factor of four: P/ω of P = c d² n is c · 60/2π · d².
    #[test]
    fn val_seals_against_published_rules() {
        assert!((seal_drag(0.128) - 4.0).abs() < 1e-12);
        assert!((seal_drag(0.3) / seal_drag(0.1) - 9.0).abs() < 1e-12);
        let torque = |c: f64, d_mm: f64| c * d_mm * d_mm / RPM;
        let linke = (145.0 - 1.6 * 20.0 + 350.0 * 150.8_f64.log10().log10()) * 1e-7;
        for (c, low, high) in [(7.69e-6, 3.0, 3.5), (11.78e-6, 2.0, 2.3), (linke, 1.0, 1.2)] {
            let ratio = seal_drag(0.128) / torque(c, 128.0);
            assert!(ratio > low && ratio < high, "{c:e}: {ratio}");
        }
    }

    /// A warm seal drags less: 28 % less at 60 °C (Linke with VG 150), 1 at 20 °C, never negative.
    #[test]
    fn warm_seals_drag_less() {
        assert_eq!(seal_share(20.0, 150e-6), 1.0);
        assert!((seal_share(60.0, 150e-6) - 0.723).abs() < 0.002, "{}", seal_share(60.0, 150e-6));
        for grade in [2.0, 32.0, 150.0, 3200.0] {
            let course: Vec<f64> =
                (-30..=220).step_by(10).map(|t| seal_share(f64::from(t), grade * 1e-6)).collect();
            assert!(
                course.windows(2).all(|pair| pair[1] <= pair[0]) && course.iter().all(|x| *x > 0.0),
                "{grade}"
            );
        }
    }
}
