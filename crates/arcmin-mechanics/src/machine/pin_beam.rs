//! Output pins as beams: deflection and largest stresses.

use std::f64::consts::PI;

use crate::geometry::Vec2;
use crate::materials::Material;

/// A round pin, clamped in one plate or between two, with a force from every disc.
///
/// A disc's force acts at one point, the middle of its width. A roller on the pin does not contribute to its
/// bending stiffness.
#[derive(Debug, Clone, PartialEq)]
pub struct PinBeam {
    /// m.
    pub radius: f64,
    /// Distance of every disc from the plate that holds the pin, m.
    pub places: Vec<f64>,
    /// Distance of the other plate, m; `None` where the end is free.
    pub span: Option<f64>,
    /// Elastic constants and yield strength of the pin.
    pub material: Material,
}

/// Largest stresses in a pin, Pa.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PinStress {
    /// Bending stress at a clamped end.
    pub bending: f64,
    /// Shear stress there, 4/3 of its mean over the section.
    pub shear: f64,
}

/// Shear coefficient of a round section (Cowper 1966 for ν = 0.3).
const SHEAR: f64 = 0.9;

impl PinBeam {
    fn area(&self) -> f64 {
        PI * self.radius.powi(2)
    }

    /// Deflection per force at a disc in m/N, as a Timoshenko beam: bending and shear.
    pub fn compliance(&self, disc: usize) -> f64 {
        let (a, material) = (self.places[disc], &self.material);
        let bending = material.youngs_modulus * 0.25 * PI * self.radius.powi(4);
        let shear = SHEAR * self.area() * material.youngs_modulus / (2.0 * (1.0 + material.poisson_ratio));
        match self.span {
            None => a.powi(3) / (3.0 * bending) + a / shear,
            Some(span) => {
                let b = span - a;
                (a * b).powi(3) / (3.0 * bending * span.powi(3)) + a * b / (span * shear)
            }
        }
    }

    /// Largest stresses under the forces (N) of all discs: bending 4 M/(π r³) and shear 4 Q/(3 π r²) at the
    /// clamped ends. For a pin clamped at both ends, a force F at the distances a, b from them causes the end
    /// moments F a b²/l² and F a² b/l²; the moment under the force is smaller.
    pub fn stress(&self, forces: &[Vec2]) -> PinStress {
        let mut ends = [(Vec2::zeros(), Vec2::zeros()); 2];
        for (force, a) in forces.iter().zip(&self.places) {
            let shares = match self.span {
                None => [(*a, 1.0), (0.0, 0.0)],
                Some(span) => {
                    let b = span - a;
                    let (near, far) = (a * b * b / (span * span), a * a * b / (span * span));
                    [
                        (near, b * b * (3.0 * a + b) / span.powi(3)),
                        (far, a * a * (a + 3.0 * b) / span.powi(3)),
                    ]
                }
            };
            for ((moment, shear), (arm, share)) in ends.iter_mut().zip(shares) {
                *moment += arm * force;
                *shear += share * force;
            }
        }
        let largest = |of: fn(&(Vec2, Vec2)) -> f64| ends.iter().map(of).fold(0.0, f64::max);
        PinStress {
            bending: largest(|(moment, _)| moment.norm()) * 4.0 / (PI * self.radius.powi(3)),
            shear: largest(|(_, shear)| shear.norm()) * 4.0 / (3.0 * self.area()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn beam(span: Option<f64>) -> PinBeam {
        let material = Material::by_name("100Cr6").unwrap();
        PinBeam { radius: 1.5e-3, places: vec![2.5e-3, 7.5e-3], span, material }
    }

    /// A cantilever has the moment F a at its clamped end. A pin clamped at both ends and loaded in the middle
    /// has F l/8 there, and half of the force as shear. Opposite forces on two discs bend a cantilever by their
    /// couple.
    #[test]
    fn beams_have_their_closed_forms() {
        let section = 4.0 / (PI * 1.5e-3_f64.powi(3));
        let (f, none) = (Vec2::new(0.0, 100.0), Vec2::zeros());
        let cantilever = beam(None).stress(&[none, f]);
        assert!((cantilever.bending / (100.0 * 7.5e-3 * section) - 1.0).abs() < 1e-12);
        assert!((cantilever.shear / (4.0 * 100.0 / (3.0 * PI * 1.5e-3 * 1.5e-3)) - 1.0).abs() < 1e-12);
        let couple = beam(None).stress(&[-f, f]).bending;
        assert!((couple / (100.0 * 5e-3 * section) - 1.0).abs() < 1e-12);
        let middle = beam(Some(5e-3)).stress(&[f, none]);
        assert!((middle.bending / (100.0 * 5e-3 / 8.0 * section) - 1.0).abs() < 1e-12);
        assert!((middle.shear / (0.5 * cantilever.shear) - 1.0).abs() < 1e-12);
    }

    /// The end moment compared with the differential equation of the beam, integrated with unknown end moment
    /// and shear force for zero slope and deflection at both ends.
    #[test]
    fn end_moments_follow_from_the_differential_equation() {
        let [a, l, force]: [f64; 3] = [2.5e-3, 10e-3, 80.0];
        // EI w'' = −M0 + Q0 x − F ⟨x − a⟩; w'(l) = w(l) = 0 gives two equations for M0 and Q0.
        let b = l - a;
        let (slope, deflection) = (force * b * b / 2.0, force * b.powi(3) / 6.0);
        // −M0 l + Q0 l²/2 = slope; −M0 l²/2 + Q0 l³/6 = deflection.
        let q0 = (deflection - slope * l / 2.0) / (l.powi(3) / 6.0 - l.powi(3) / 4.0);
        let m0 = (q0 * l * l / 2.0 - slope) / l;
        let pin = PinBeam { places: vec![a], ..beam(Some(l)) };
        let stress = pin.stress(&[Vec2::new(force, 0.0)]);
        assert!((stress.bending / (m0 * 4.0 / (PI * 1.5e-3_f64.powi(3))) - 1.0).abs() < 1e-9);
        assert!((stress.shear / (q0 * 4.0 / (3.0 * pin.area())) - 1.0).abs() < 1e-9);
    }

    /// The deflection of a cantilever is a³/(3 EI) plus shear, which is below one per cent where the pin is
    /// long.
    #[test]
    fn compliance_is_that_of_a_timoshenko_beam() {
        let pin = PinBeam { places: vec![30e-3], ..beam(None) };
        let bending = 30e-3_f64.powi(3) / (3.0 * 210e9 * 0.25 * PI * 1.5e-3_f64.powi(4));
        let all = pin.compliance(0);
        assert!(all > bending && all < 1.01 * bending, "{all:e} {bending:e}");
    }
}
