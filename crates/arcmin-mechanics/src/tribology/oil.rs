//! Lubricating oil against temperature, and the friction of a lubricated line contact.

use super::film::boundary_share;
use super::{Lubrication, film_ratio};

/// An oil (or the base oil of a grease) by its ISO VG grade.
///
/// Kinematic viscosity by Walther's equation (ASTM D341): lg lg(ν + 0.7) = A − B lg T, ν in mm²/s and T in K,
/// through ν at 40 °C, the grade, and at 100 °C. Where the latter is not known, that of mineral oils with a
/// viscosity index of 95: ν₁₀₀ = 0.550 ν₄₀^0.659, within 2 % of their tables from VG 32 to VG 460. Valid from
/// −20 °C (above the pour point) to 120 °C.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oil {
    /// ν at 40 °C in m²/s.
    pub at_40c: f64,
    /// ν at 100 °C in m²/s.
    pub at_100c: f64,
    /// Density at 15 °C in kg/m³; it falls by 0.65 kg/m³ per kelvin (ISO 91 for this range).
    pub density: f64,
}

const KELVIN: f64 = 273.15;
const MM2_S: f64 = 1e-6;

impl Oil {
    /// A mineral oil of a grade in mm²/s.
    pub fn grade(iso_vg: f64) -> Oil {
        let at_100c = 0.550 * iso_vg.powf(0.6592);
        Oil { at_40c: iso_vg * MM2_S, at_100c: at_100c * MM2_S, density: 880.0 }
    }

    /// ν in m²/s at a temperature in °C.
    pub fn kinematic_viscosity(&self, celsius: f64) -> f64 {
        let height = |viscosity: f64| (viscosity / MM2_S + 0.7).log10().log10();
        let place = |celsius: f64| (celsius + KELVIN).log10();
        let (low, high) = (height(self.at_40c), height(self.at_100c));
        let slope = (high - low) / (place(100.0) - place(40.0));
        let at = low + slope * (place(celsius) - place(40.0));
        (10f64.powf(10f64.powf(at)) - 0.7) * MM2_S
    }

    /// η in Pa·s at a temperature in °C.
    pub fn viscosity(&self, celsius: f64) -> f64 {
        self.kinematic_viscosity(celsius) * (self.density - 0.65 * (celsius - 15.0))
    }
}

/// A line contact that rolls and slides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RubbingContact {
    /// E* in Pa.
    pub effective_modulus: f64,
    /// R_eq in m.
    pub radius: f64,
    /// F/B in N/m.
    pub line_load: f64,
    /// Mean of both surface speeds relative to the contact, m/s.
    pub entrainment: f64,
    /// Difference of both surface speeds, m/s.
    pub sliding: f64,
}

/// Eyring stress of mineral oils in Pa (5 MPa), and the largest traction coefficient of a film (0.06): the
/// limiting shear stress of mineral oils over the pressure (Evans & Johnson 1986).
const EYRING: f64 = 5e6;
const LIMITING: f64 = 0.06;

impl RubbingContact {
    /// Mean Hertz pressure π/4 p₀ in Pa.
    fn pressure(&self) -> f64 {
        let half_width =
            (4.0 * self.line_load * self.radius / (std::f64::consts::PI * self.effective_modulus)).sqrt();
        self.line_load / (2.0 * half_width)
    }

    /// Friction coefficient from boundary to full film: μ = μ_f + (μ_b − μ_f)/(1 + λ)² (Olver & Spikes 1998).
    /// μ_f = τ₀/p asinh(η e^(αp) v_s/(h τ₀)) of the film (Johnson & Tevaarwerk 1977, Barus), 0.06 at most.
    /// Returns μ and λ.
    pub fn friction(&self, lubrication: &Lubrication, boundary: f64) -> (f64, f64) {
        if !(self.line_load > 0.0) || !(self.entrainment > 0.0) {
            return (boundary, 0.0);
        }
        let ratio =
            film_ratio(lubrication, self.effective_modulus, self.radius, self.line_load, self.entrainment);
        let film = self.film_friction(lubrication, ratio * lubrication.roughness);
        (film + (boundary - film) * boundary_share(ratio), ratio)
    }

    fn film_friction(&self, lubrication: &Lubrication, height: f64) -> f64 {
        let pressure = self.pressure();
        let rate = self.sliding.abs() / height / EYRING;
        // asinh of e^x: beyond x of 700 the exponential itself would overflow, and the limit has long come.
        let exponent = (lubrication.pressure_viscosity * pressure).min(500.0);
        let stress = EYRING * (lubrication.viscosity * rate * exponent.exp()).asinh();
        (stress / pressure).min(LIMITING)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ISO VG 150 with ν₁₀₀ of its tables, 15 mm²/s; at 20 °C 530 to 560 mm²/s and at 80 °C 26 to 28 (viscosity
    /// charts of VI 95 oils); the grade itself at 40 °C.
    #[test]
    fn val_vg_150_against_charts() {
        let oil = Oil::grade(150.0);
        let nu = |celsius: f64| oil.kinematic_viscosity(celsius) / MM2_S;
        assert!((nu(40.0) / 150.0 - 1.0).abs() < 1e-12 && (nu(100.0) / 15.0 - 1.0).abs() < 0.01);
        assert!(nu(20.0) > 480.0 && nu(20.0) < 600.0, "{}", nu(20.0));
        assert!(nu(80.0) > 25.0 && nu(80.0) < 29.0, "{}", nu(80.0));
        // A straight line in Walther's coordinates.
        let y = |celsius: f64| (nu(celsius) + 0.7).log10().log10();
        let x = |celsius: f64| (celsius + 273.15).log10();
        let slope = |a: f64, b: f64| (y(b) - y(a)) / (x(b) - x(a));
        assert!((slope(0.0, 50.0) / slope(50.0, 110.0) - 1.0).abs() < 1e-9);
        for (grade, at_100c) in [(32.0, 5.4), (68.0, 8.7), (220.0, 19.4), (460.0, 31.3)] {
            assert!((Oil::grade(grade).at_100c / MM2_S / at_100c - 1.0).abs() < 0.025, "{grade}");
        }
    }

    /// Without film boundary friction, with a thick film the film's own; falling with speed in between, and
    /// Newton's ηv/(hp) where the film is sheared slowly.
    #[test]
    fn friction_goes_from_boundary_to_film() {
        let oil = Lubrication { viscosity: 0.1, pressure_viscosity: 2e-8, roughness: 0.4e-6 };
        let contact = |speed: f64| RubbingContact {
            effective_modulus: 1.2e11,
            radius: 3e-3,
            line_load: 3e4,
            entrainment: speed,
            sliding: 0.5 * speed,
        };
        assert_eq!(contact(0.0).friction(&oil, 0.11), (0.11, 0.0));
        let (slow, ratio) = contact(1e-6).friction(&oil, 0.11);
        assert!(ratio < 1e-2 && (slow / 0.11 - 1.0).abs() < 0.02, "{slow} {ratio}");
        let course: Vec<(f64, f64)> =
            [1e-3, 1e-2, 0.1, 1.0, 10.0].map(|speed| contact(speed).friction(&oil, 0.11)).to_vec();
        assert!(course.windows(2).all(|pair| pair[1].0 < pair[0].0 && pair[1].1 > pair[0].1), "{course:?}");
        let creeping = RubbingContact { sliding: 1e-12, ..contact(1.0) };
        let (_, ratio) = creeping.friction(&oil, 0.11);
        let height = ratio * oil.roughness;
        let p = creeping.pressure();
        let newton = 0.1 * (2e-8 * p).exp() * 1e-12 / (height * p);
        assert!((creeping.film_friction(&oil, height) / newton - 1.0).abs() < 1e-3);
        // 30 N/mm on 3 mm: p₀ = √(F E*/(π R B)) = 618 MPa, the mean π/4 of it.
        assert!((p / (0.25 * std::f64::consts::PI * 618.0e6) - 1.0).abs() < 0.001, "{p:e}");
        assert!(contact(1.0).film_friction(&oil, 1e-9) <= LIMITING);
    }
}
