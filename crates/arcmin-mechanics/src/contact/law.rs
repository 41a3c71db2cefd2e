use std::f64::consts::PI;

use crate::materials::{Material, effective_modulus};
use crate::named::named_laws;

named_laws! {
    /// Elastic law of one tooth contact: force from approach.
    #[derive(Default)]
    pub enum ContactLaw;
    /// Contact laws by name.
    pub enum ContactLawName, "contact law";

    /// F = δ/(α − β ln F R_eq), approach of points at depth 2 r_p in each body (Johnson 1985, §4.6 and §5.6).
    #[default]
    "line-hertz", "two cylinders, approach of points two pin radii deep (Johnson)": LineHertz,
    /// F = k δ.
    "linear", "force proportional to approach; needs `stiffness_n_per_um`": Linear {
        /// k per pin in N/m.
        stiffness: "stiffness_n_per_um" => |p| p[0] * 1e6,
    },
    /// δ = 3.84e-5 Q^0.9 / l^0.8 (mm, N): Palmgren's line contact of steel bodies.
    "palmgren", "Palmgren's line contact, approach ∝ force^0.9": Palmgren,
    /// Eq. (6) of Tao2024 with the Hertz half-width; both lengths under the logarithm and R_eq equal to the
    /// pin radius.
    "tao2024", "eq. (6) of Tao2024 with the Hertz half-width": Tao2024,
    /// F = k δ^e: the elastic part of the impact function of Tao2024's multibody model.
    "impact", "the elastic part of the impact function; needs `impact_stiffness_n_per_mm_e` and `impact_exponent`":
        Impact {
            /// k in N/m^e.
            stiffness: "impact_stiffness_n_per_mm_e" => |p| p[0] * 1e3f64.powf(p[1]),
            /// e.
            exponent: "impact_exponent" => |p| p[1],
        },
}

/// Damping of one contact: c STEP(δ, 0, 0, d, 1) δ̇, where the cubic step function raises the coefficient from zero
/// to c over the depth d.
///
/// The sum of elastic and damping force is limited to zero or more: contacts do not pull.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Damping {
    /// c in N·s/m.
    pub coefficient: f64,
    /// d in m.
    pub ramp_depth: f64,
}

/// Force of one contact with its tangents and energy.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ContactForce {
    /// Elastic and damping force together in N, never negative.
    pub force: f64,
    /// ∂F/∂δ in N/m.
    pub stiffness: f64,
    /// ∂F/∂δ̇ in N·s/m.
    pub damping: f64,
    /// Elastic force in N.
    pub elastic: f64,
    /// Elastic energy in J.
    pub stored: f64,
}

/// Mathematical forms of the contact laws.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    /// δ = F (α − β ln(F R)), with R = R_eq or 1.
    Logarithmic { by_radius: bool },
    /// F = k δ with k in N/m.
    Linear { stiffness: f64 },
    /// δ = C F^p in m and N. C is computed once, because a power function takes as long as the rest of a contact.
    Power { coefficient: f64, power: f64 },
}

/// A [`ContactLaw`] bound to the two materials, the face width and the pin radius of one ring.
///
/// For the line-contact laws the approach is δ(F) = F (α − β ln(F R_eq)) with constants of the pairing, from
/// δ = Σ_m F (1−ν_m²)/(π B E_m) [2 ln(2 h_m/b) − ν_m/(1−ν_m)] and b² = 4 F R_eq/(π B E*).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineContact {
    law: ContactLaw,
    shape: Shape,
    /// α in m/N (for R_eq F in N·m) and β in m/N.
    alpha: f64,
    beta: f64,
    /// Face width B in m.
    pub width: f64,
    /// E* in Pa.
    pub effective_modulus: f64,
    /// Installed pin radius in m.
    pub pin_radius: f64,
    /// Damping of the normal force by the rate of approach; `None` for an undamped contact.
    pub damping: Option<Damping>,
    /// Compliance of the pin's seat in series, m/N.
    seat: f64,
}

impl LineContact {
    /// Binds `law` to disc and pin materials, face width B and pin radius r_p; the reference depth is h = 2
    /// r_p in both bodies.
    pub fn new(law: ContactLaw, disc: &Material, pin: &Material, width: f64, pin_radius: f64) -> LineContact {
        let effective_modulus = effective_modulus(disc, pin);
        let b2_per_fr = 4.0 / (PI * width * effective_modulus);
        let (mut alpha, mut beta) = (0.0, 0.0);
        let depth = 2.0 * pin_radius;
        for material in [disc, pin] {
            let a = material.plane_strain_compliance() / (PI * width);
            let nu = material.poisson_ratio;
            match law {
                // 2F a (1/3 + ln(4 r/b)) = F a (2/3 + ln(16 r²) − ln b²), R_eq = r.
                ContactLaw::Tao2024 => alpha += a * (2.0 / 3.0 + (16.0 * pin_radius / b2_per_fr).ln()),
                _ => alpha += a * ((4.0 * depth * depth / b2_per_fr).ln() - nu / (1.0 - nu)),
            }
            beta += a;
        }
        let shape = match law {
            ContactLaw::LineHertz => Shape::Logarithmic { by_radius: true },
            ContactLaw::Tao2024 => Shape::Logarithmic { by_radius: false },
            ContactLaw::Linear { stiffness } => Shape::Linear { stiffness },
            // δ[mm] = 3.84e-5 Q^0.9 l[mm]^-0.8
            ContactLaw::Palmgren => {
                Shape::Power { coefficient: 3.84e-8 * (width * 1e3).powf(-0.8), power: 0.9 }
            }
            ContactLaw::Impact { stiffness, exponent } => {
                Shape::Power { coefficient: stiffness.powf(-1.0 / exponent), power: 1.0 / exponent }
            }
        };
        LineContact {
            law,
            shape,
            alpha,
            beta,
            width,
            effective_modulus,
            pin_radius,
            damping: None,
            seat: 0.0,
        }
    }

    /// The same law with the approach of the disc read at another depth (m) than that of [`LineContact::new`]: the depth at
    /// which the displacement of an elastic disc is added, so that nothing is counted twice.
    #[must_use]
    pub fn at_disc_depth(self, disc: &Material, depth: f64) -> LineContact {
        LineContact { alpha: self.alpha + self.compliance_to_depth(disc, depth), ..self }
    }

    /// Compliance (m/N) of the disc between the depth of [`LineContact::new`] and another one (m): 2 (1−ν²)/(π B E) ln(h/2r_p).
    /// It is 0 for laws without a reference depth.
    pub fn compliance_to_depth(&self, disc: &Material, depth: f64) -> f64 {
        match self.law {
            ContactLaw::LineHertz => {
                2.0 * disc.plane_strain_compliance() / (PI * self.width)
                    * (0.5 * depth / self.pin_radius).ln()
            }
            _ => 0.0,
        }
    }

    /// Force law with its parameters.
    pub fn law(&self) -> ContactLaw {
        self.law
    }

    /// Adds a linear compliance (m/N), that of the pin's seat, in series with the contact.
    pub fn with_seat_compliance(mut self, compliance: f64) -> LineContact {
        // For the laws δ = F (α − β ln F) it is added to α.
        self.alpha += compliance - self.seat;
        self.seat = compliance;
        self
    }

    /// Compliance in series, m/N.
    pub fn seat_compliance(&self) -> f64 {
        self.seat
    }

    /// A power law δ = C F^p in series with the seat: Newton's method on the concave δ(F), from below.
    fn power_with_seat(&self, coefficient: f64, power: f64, approach: f64) -> (f64, f64) {
        let mut force =
            (approach / coefficient).powf(1.0 / power).min(approach / self.seat.max(f64::MIN_POSITIVE));
        for _ in 0..50 {
            let contact = coefficient * force.powf(power);
            let slope = power * contact / force + self.seat;
            let step = (approach - contact - self.seat * force) / slope;
            force = (force + step).max(0.1 * force);
            if step.abs() <= 1e-12 * force {
                break;
            }
        }
        (force, 1.0 / (power * coefficient * force.powf(power - 1.0) + self.seat))
    }

    /// Elastic force in N and stiffness dF/dδ in N/m at approach δ (m, positive) for the equivalent radius
    /// R_eq in m.
    #[inline]
    pub fn force(&self, approach: f64, equivalent_radius: f64) -> (f64, f64) {
        if approach <= 0.0 {
            return (0.0, 0.0);
        }
        match self.shape {
            Shape::Logarithmic { by_radius } => {
                self.line_force(approach, if by_radius { equivalent_radius } else { 1.0 })
            }
            Shape::Linear { stiffness } => {
                let stiffness = stiffness / (1.0 + stiffness * self.seat);
                (stiffness * approach, stiffness)
            }
            Shape::Power { coefficient, power } if self.seat > 0.0 => {
                self.power_with_seat(coefficient, power, approach)
            }
            Shape::Power { coefficient, power } => {
                let force = (approach / coefficient).powf(1.0 / power);
                (force, force / (power * approach))
            }
        }
    }

    /// Approach in m under the force F (N) for the equivalent radius R_eq (m): the inverse of
    /// [`LineContact::force`].
    pub fn approach(&self, force: f64, equivalent_radius: f64) -> f64 {
        if force <= 0.0 {
            return 0.0;
        }
        match self.shape {
            Shape::Logarithmic { by_radius } => {
                self.line_approach(force, if by_radius { equivalent_radius } else { 1.0 })
            }
            Shape::Linear { stiffness } => force / stiffness + self.seat * force,
            Shape::Power { coefficient, power } => coefficient * force.powf(power) + self.seat * force,
        }
    }

    /// Solves δ = F (α − β ln(F R)) for F; returns (F, dF/dδ). R is 1 for a law without radius.
    ///
    /// With c defined by δ/F = β c the equation is c − ln c = a, a = (α − β ln(R δ) + β ln β)/β; a is typically 12.
    /// δ(F) increases until c = 1, where the half-width equals the reference depth and the formula is no longer
    /// valid. Below c = 3 (half-width h/e, far above the strength of any steel) the law is continued with constant
    /// stiffness.
    #[inline]
    fn line_force(&self, approach: f64, radius: f64) -> (f64, f64) {
        const LIMIT: f64 = 3.0;
        let beta = self.beta;
        let a = self.alpha / beta - (radius * approach / beta).ln();
        // 3 − ln 3.
        if a <= 1.901_387_711_331_89 {
            let limit = self.limit_force(radius);
            let stiffness = 1.0 / ((LIMIT - 1.0) * beta);
            return (limit + stiffness * (approach - LIMIT * beta * limit), stiffness);
        }
        let c = if a > 5.0 && a < 45.0 {
            // The first guess is within 8e-4 of the solution; one step of Halley's method reduces the error to 3e-11,
            // one of Newton's to rounding. The argument of the second logarithm is a ratio near 1, so that a series
            // is sufficient.
            let guess = (0.682_645_5 + a * (1.497_953 + a * 0.133_548_4)) / (1.0 + 0.131_618_1 * a);
            let log = guess.ln();
            let inverse = 1.0 / guess;
            let slope = 1.0 - inverse;
            let value = guess - a - log;
            let halley = guess - value * slope / (slope * slope - 0.5 * value * inverse * inverse);
            let x = (halley - guess) * inverse;
            let log = log + x * (1.0 - x * (0.5 - x * (1.0 / 3.0 - x * 0.25)));
            halley - (halley - a - log) / slope
        } else {
            let mut c = a + 1.7;
            for _ in 0..20 {
                let step = (c - a - c.ln()) / (1.0 - 1.0 / c);
                c -= step;
                // The remaining error is the square of the step over 2 c².
                if step.abs() <= 1e-6 * c {
                    break;
                }
            }
            c
        };
        (approach / (beta * c), 1.0 / (beta * (c - 1.0)))
    }

    /// Inverse of [`LineContact::line_force`], including its continuation with constant stiffness.
    fn line_approach(&self, force: f64, radius: f64) -> f64 {
        let compliance = self.alpha - self.beta * (radius * force).ln();
        if compliance >= 3.0 * self.beta {
            return force * compliance;
        }
        let limit = self.limit_force(radius);
        self.beta * (3.0 * limit + 2.0 * (force - limit))
    }

    /// Force at which the compliance has fallen to 3 β.
    fn limit_force(&self, radius: f64) -> f64 {
        (self.alpha / self.beta - 3.0).exp() / radius
    }

    /// ∂U/∂(ln R) at constant approach: ½ β F² in J; zero for laws without radius.
    ///
    /// From δ = F (α − β ln(F R)) at constant δ: dF/F = β/(C − β) d(ln R) with C = δ/F, and U = F (δ/2 − β
    /// F/4).
    #[inline]
    pub fn energy_by_log_radius(&self, elastic_force: f64) -> f64 {
        match self.shape {
            Shape::Logarithmic { by_radius: true } => 0.5 * self.beta * elastic_force * elastic_force,
            _ => 0.0,
        }
    }

    /// Elastic energy ∫F dδ in J at approach δ (m) with the force F (N) that [`LineContact::force`] gives
    /// there.
    ///
    /// From δ = F (α′ − β ln F): U = F (δ/2 − β F/4); power laws F ∝ δ^e: U = F δ/(e + 1).
    #[inline]
    pub fn energy(&self, approach: f64, force: f64, equivalent_radius: f64) -> f64 {
        if approach <= 0.0 {
            return 0.0;
        }
        match self.shape {
            Shape::Logarithmic { by_radius } => {
                self.line_energy(approach, force, if by_radius { equivalent_radius } else { 1.0 })
            }
            Shape::Linear { .. } => 0.5 * force * approach,
            Shape::Power { power, .. } => self.power_energy(approach, force, 1.0 / power),
        }
    }

    /// F ∝ δ_contact^e with the seat's ½ c F² in series.
    fn power_energy(&self, approach: f64, force: f64, exponent: f64) -> f64 {
        let seat = self.seat * force;
        force * (approach - seat) / (1.0 + exponent) + 0.5 * seat * force
    }

    fn line_energy(&self, approach: f64, force: f64, radius: f64) -> f64 {
        // Compliance above 3 β: the logarithmic law applies.
        if approach >= 3.0 * self.beta * force {
            return force * (0.5 * approach - 0.25 * self.beta * force);
        }
        let limit = self.limit_force(radius);
        let limit_approach = 3.0 * self.beta * limit;
        limit * (0.5 * limit_approach - 0.25 * self.beta * limit)
            + 0.5 * (limit + force) * (approach - limit_approach)
    }

    /// Contact force with damping at approach δ in m and rate δ̇ in m/s.
    #[inline]
    pub fn damped_force(&self, approach: f64, rate: f64, equivalent_radius: f64) -> ContactForce {
        if approach <= 0.0 {
            return ContactForce::default();
        }
        let (elastic, stiffness) = self.force(approach, equivalent_radius);
        let stored = self.energy(approach, elastic, equivalent_radius);
        let Some(Damping { coefficient, ramp_depth }) = self.damping else {
            return ContactForce { force: elastic, stiffness, damping: 0.0, elastic, stored };
        };
        let x = (approach / ramp_depth).min(1.0);
        let damping = coefficient * x * x * (3.0 - 2.0 * x);
        let damping_slope = if x < 1.0 { coefficient * 6.0 * x * (1.0 - x) / ramp_depth } else { 0.0 };
        let force = elastic + damping * rate;
        if force > 0.0 {
            ContactForce { force, stiffness: stiffness + damping_slope * rate, damping, elastic, stored }
        } else {
            ContactForce { elastic, stored, ..ContactForce::default() }
        }
    }

    /// Hertz half-width b = √(4 F R_eq/(π B E*)) in m.
    pub fn half_width(&self, force: f64, equivalent_radius: f64) -> f64 {
        (4.0 * force.max(0.0) * equivalent_radius / (PI * self.width * self.effective_modulus)).sqrt()
    }

    /// Largest Hertz pressure p0 = 2F/(π b B) in Pa.
    pub fn pressure(&self, force: f64, equivalent_radius: f64) -> f64 {
        if force <= 0.0 {
            0.0
        } else {
            2.0 * force / (PI * self.half_width(force, equivalent_radius) * self.width)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steel() -> Material {
        Material::by_name("GCr15").unwrap()
    }

    fn all_laws() -> [ContactLaw; 5] {
        [
            ContactLaw::LineHertz,
            ContactLaw::Linear { stiffness: 2.85e8 },
            ContactLaw::Palmgren,
            ContactLaw::Tao2024,
            ContactLaw::Impact { stiffness: 1e10, exponent: 1.2 },
        ]
    }

    #[test]
    fn force_and_approach_are_inverse_and_stiffness_is_the_derivative_for_every_law() {
        for law in all_laws() {
            let contact = LineContact::new(law, &steel(), &steel(), 8.75e-3, 3e-3);
            for force in [1e-3, 1.0, 50.0, 447.0, 5e3, 2e4] {
                for radius in [1e-3, 3e-3, 5e-2] {
                    let approach = contact.approach(force, radius);
                    let (back, stiffness) = contact.force(approach, radius);
                    assert!((back / force - 1.0).abs() < 1e-9, "{law:?} {force} {back}");
                    let h = 1e-6 * approach;
                    let slope = (contact.force(approach + h, radius).0
                        - contact.force(approach - h, radius).0)
                        / (2.0 * h);
                    assert!((slope / stiffness - 1.0).abs() < 1e-5, "{law:?}");
                }
            }
        }
    }

    /// Secant 2.99e8 N/m and exponent 1.099 at 447 N and the largest lever (cos φ = K1): computed by two
    /// other programs.
    #[test]
    fn val_secant_and_exponent_of_the_line_contact() {
        let profile = crate::geometry::Profile::new(40, 64e-3, 1.3e-3, 3e-3);
        let contact = LineContact::new(ContactLaw::LineHertz, &steel(), &steel(), 8.75e-3, 3e-3);
        let radius = 1.0 / profile.relative_curvature(profile.short_width_coefficient(), 3e-3);
        let approach = contact.approach(447.0, radius);
        let (force, stiffness) = contact.force(approach, radius);
        assert!((force / approach / 2.99e8 - 1.0).abs() < 2e-3, "{}", force / approach);
        assert!((stiffness * approach / force - 1.099).abs() < 1e-3);
    }

    #[test]
    fn energy_is_the_integral_of_the_force_for_every_law() {
        for law in all_laws() {
            let contact = LineContact::new(law, &steel(), &steel(), 8.75e-3, 3e-3);
            // 3e-3 m lies beyond the validity of the line contact, on its continuation with constant stiffness.
            for end in [1e-7, 2e-6, 3e-5, 3e-3] {
                let n = 40_000;
                // Midpoint rule with points concentrated near zero: δ = end u², dδ = 2 end u du.
                let sum: f64 = (0..n)
                    .map(|i| (i as f64 + 0.5) / n as f64)
                    .map(|u| contact.force(end * u * u, 2e-3).0 * 2.0 * end * u / n as f64)
                    .sum();
                let energy = contact.energy(end, contact.force(end, 2e-3).0, 2e-3);
                assert!((energy / sum - 1.0).abs() < 1e-6, "{law:?} {end}: {energy} {sum}");
            }
        }
    }

    #[test]
    fn energy_follows_the_radius_at_constant_approach() {
        let contact = LineContact::new(ContactLaw::LineHertz, &steel(), &steel(), 8.75e-3, 3e-3);
        for (approach, radius) in [(1e-6, 3e-3), (3e-7, 1e-3), (5e-6, 3e-2)] {
            let energy = |radius: f64| contact.energy(approach, contact.force(approach, radius).0, radius);
            let h = 1e-4;
            let slope = (energy(radius * (1.0 + h)) - energy(radius * (1.0 - h))) / (2.0 * h);
            let exact = contact.energy_by_log_radius(contact.force(approach, radius).0);
            assert!((slope / exact - 1.0).abs() < 1e-6, "{slope} {exact}");
        }
    }

    #[test]
    fn damping_forces_are_not_tensile() {
        let mut contact = LineContact::new(ContactLaw::LineHertz, &steel(), &steel(), 8.75e-3, 3e-3);
        contact.damping = Some(Damping { coefficient: 2e3, ramp_depth: 1e-6 });
        assert_eq!(contact.damped_force(1e-6, -10.0, 3e-3).force, 0.0);
        let force = contact.damped_force(1e-6, 1e-3, 3e-3).force;
        assert!(force > contact.force(1e-6, 3e-3).0);
    }

    #[test]
    fn far_beyond_validity_the_force_stays_finite_and_rising() {
        let contact = LineContact::new(ContactLaw::LineHertz, &steel(), &steel(), 8.75e-3, 3e-3);
        let mut last = 0.0;
        for i in 1..2000 {
            let force = contact.force(1e-5 * i as f64, 3e-3).0;
            assert!(force.is_finite() && force > last);
            last = force;
        }
    }
}
