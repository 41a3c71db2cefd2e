use super::{ContactForce, LineContact};

/// Height (m) of the upper of the two slices that represent a contact line of this length (m), above the middle of
/// the line; the lower slice lies as far below. They are the points of Gauss's rule of two points.
pub(crate) fn slice_height(length: f64) -> f64 {
    length / 12.0_f64.sqrt()
}

/// Line contact of a pin with a disc that may tilt, represented by the mean of two slices.
///
/// A disc of width B tilted by σ (rad) has the approach δ + σ z at the height z above its middle. The force of the
/// whole line is the mean of the law at δ ± ε, ε = σ B/√12 (`slice_height`), correct to second order in σ. Forces and
/// energies are those of the whole line, approaches those of its middle.
#[derive(Debug, Clone, Copy)]
pub struct TiltedLine<'a> {
    /// Force law of the whole face width.
    pub law: &'a LineContact,
    /// R_eq in m.
    pub equivalent_radius: f64,
    /// ε in m; 0 for a disc that is not tilted.
    pub skew: f64,
}

/// Largest number of Newton steps in the inversion of the force; the law is smooth except where one slice opens.
const STEPS: usize = 60;

impl TiltedLine<'_> {
    /// Force in N and stiffness dF/dδ in N/m of either slice, scaled to the whole line.
    #[inline]
    fn slices(&self, approach: f64) -> [(f64, f64); 2] {
        [self.skew, -self.skew].map(|skew| self.law.force(approach + skew, self.equivalent_radius))
    }

    /// Force in N and stiffness dF/dδ in N/m at approach δ (m).
    #[inline]
    pub fn force(&self, approach: f64) -> (f64, f64) {
        if self.skew == 0.0 {
            return self.law.force(approach, self.equivalent_radius);
        }
        let [far, near] = self.slices(approach);
        (0.5 * (far.0 + near.0), 0.5 * (far.1 + near.1))
    }

    /// ∂U/∂ε in N at the approach δ (m), which is the couple of the line divided by B/√12, and ∂²U/∂ε² in N/m.
    pub fn couple(&self, approach: f64) -> (f64, f64) {
        let [far, near] = self.slices(approach);
        (0.5 * (far.0 - near.0), 0.5 * (far.1 + near.1))
    }

    /// ∂F/∂ε = ∂²U/∂ε∂δ in N/m: derivative of the force by ε and of the couple by the approach.
    pub fn cross(&self, approach: f64) -> f64 {
        let [far, near] = self.slices(approach);
        0.5 * (far.1 - near.1)
    }

    /// Approach in m of the middle at which the line touches at one of its ends.
    pub fn touch(&self) -> f64 {
        -self.skew.abs()
    }

    /// Approach in m under the force F (N): the inverse of [`TiltedLine::force`].
    pub fn approach(&self, force: f64) -> f64 {
        if force <= 0.0 {
            return self.touch();
        }
        let straight = self.law.approach(force, self.equivalent_radius);
        if self.skew == 0.0 {
            return straight;
        }
        // Upper bound: where the slice of smaller load alone has the force of the untilted line, the mean of both is
        // larger.
        let (mut low, mut high) = (self.touch(), straight - self.touch());
        let mut place = straight;
        for _ in 0..STEPS {
            let (found, stiffness) = self.force(place);
            if found > force {
                high = place
            } else {
                low = place
            }
            let next = place + (force - found) / stiffness;
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            let step = (next - place).abs();
            place = next;
            if step <= 1e-15 * high.abs() {
                break;
            }
        }
        place
    }

    /// Elastic energy ∫F dδ in J at approach δ (m).
    pub fn energy(&self, approach: f64) -> f64 {
        let of_slice = |approach: f64| {
            let force = self.law.force(approach, self.equivalent_radius).0;
            self.law.energy(approach, force, self.equivalent_radius)
        };
        0.5 * (of_slice(approach + self.skew) + of_slice(approach - self.skew))
    }

    /// Contact force with damping at approach δ in m and rate δ̇ in m/s of the middle.
    #[inline]
    pub fn damped_force(&self, approach: f64, rate: f64) -> ContactForce {
        if self.skew == 0.0 {
            return self.law.damped_force(approach, rate, self.equivalent_radius);
        }
        let [far, near] = [self.skew, -self.skew]
            .map(|e| self.law.damped_force(approach + e, rate, self.equivalent_radius));
        let mean = |of: fn(&ContactForce) -> f64| 0.5 * (of(&far) + of(&near));
        ContactForce {
            force: mean(|slice| slice.force),
            stiffness: mean(|slice| slice.stiffness),
            damping: mean(|slice| slice.damping),
            elastic: mean(|slice| slice.elastic),
            stored: mean(|slice| slice.stored),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::ContactLaw;
    use crate::materials::Material;

    /// Forces are derivatives of the energy by approach and tilt, the stiffness is the derivative of the force, and
    /// the approach is the inverse of the force, also where one slice is open. Compared with forty slices of the same
    /// line, the force of two slices is correct to 1e-3 and the couple to a few per cent as long as both ends touch.
    #[test]
    fn two_slices_represent_a_tilted_line() {
        let steel = Material::by_name("GCr15").unwrap();
        for law in [ContactLaw::LineHertz, ContactLaw::Palmgren, ContactLaw::Linear { stiffness: 2.85e8 }] {
            let law = LineContact::new(law, &steel, &steel, 8.75e-3, 3e-3);
            let line = |skew: f64| TiltedLine { law: &law, equivalent_radius: 4e-3, skew };
            for (approach, tilt) in [(4e-6, 1e-6), (4e-6, -2e-6), (1e-6, 3e-6), (3e-6, 0.0)] {
                let (force, stiffness) = line(tilt).force(approach);
                let (couple, across) = line(tilt).couple(approach);
                let h = 1e-10;
                let energy = |d: f64, e: f64| line(tilt + e).energy(approach + d);
                let slope = (energy(h, 0.0) - energy(-h, 0.0)) / (2.0 * h);
                assert!((slope / force - 1.0).abs() < 1e-5, "{slope} {force}");
                let slope = (energy(0.0, h) - energy(0.0, -h)) / (2.0 * h);
                assert!((slope - couple).abs() < 1e-5 * force, "{slope} {couple}");
                let slope = (line(tilt).force(approach + h).0 - line(tilt).force(approach - h).0) / (2.0 * h);
                assert!((slope / stiffness - 1.0).abs() < 1e-5);
                assert!((line(tilt).approach(force) / approach - 1.0).abs() < 1e-9);
                assert!(across >= 0.0 && line(tilt).damped_force(approach, 0.0).force == force);
                // The ends of the line are √3 times as far from the middle as the slices.
                if 3f64.sqrt() * tilt.abs() < approach {
                    let end = 3f64.sqrt() * tilt;
                    let slices = 40;
                    let (mut whole, mut moment) = (0.0, 0.0);
                    for i in 0..slices {
                        let x = (2.0 * f64::from(i) + 1.0) / f64::from(slices) - 1.0;
                        let slice = law.force(approach + x * end, 4e-3).0 / f64::from(slices);
                        whole += slice;
                        moment += 3f64.sqrt() * x * slice;
                    }
                    assert!((force / whole - 1.0).abs() < 1e-3, "{force} {whole}");
                    assert!(
                        (couple - moment).abs() <= 0.03 * moment.abs() + 1e-9 * force,
                        "{couple} {moment}"
                    );
                }
            }
        }
    }
}
