//! Coupled forces where Newton's method on the approaches cycles.
//!
//! A disc with windows deflects so much that contacts open and close alternately. The forces are the minimum of a
//! convex energy, E(F) = Σ (F_i δ(F_i) − W_i) + ½ Fᵀ C F − sᵀ F over F ≥ 0, since C is positive definite and the law
//! increases; a descent method therefore converges to it.

use super::{CoupledContact, CoupledForces, TOLERANCE};
use crate::contact::LineContact;

/// Upper limit of the steps; a projected Newton method needs a dozen at most.
const STEPS: usize = 100;
/// Share of the largest force below which a decreasing force is set to zero.
const NOTHING: f64 = 1e-9;
/// Armijo's fraction of the descent predicted by the slope.
const SHARE: f64 = 1e-4;
/// Largest number of halvings of one step.
const HALVINGS: usize = 40;

impl CoupledForces {
    /// Minimises E by a projected Newton method (Bertsekas 1982) from the present forces. Returns whether it
    /// converged; forces, approaches and factor are those of the last step.
    pub(super) fn descend(&mut self, law: &LineContact, contacts: &[CoupledContact]) -> bool {
        let n = contacts.len();
        if self.force.iter().any(|force| !force.is_finite()) {
            self.force.fill(0.0);
        }
        let mut step = vec![0.0; n];
        let mut slope = vec![0.0; n];
        for _ in 0..STEPS {
            let (largest, residual) = self.evaluate(law, contacts, &mut step);
            if residual <= TOLERANCE * largest {
                self.factorise(n);
                return true;
            }
            self.active.clear();
            for i in 0..n {
                let contact = &contacts[i];
                let line = contact.line(law);
                let own = line.approach(self.force[i]);
                slope[i] = own - self.local[i];
                if slope[i] >= 0.0 && self.force[i] <= NOTHING * largest {
                    step[i] = -self.force[i];
                    continue;
                }
                // For a force that increases from zero: the stiffness at half the force it has without the
                // others.
                let place = own.max(0.5 * (self.local[i] + line.touch()));
                self.local_stiffness[i] = line.force(place).1;
                self.active.push(i);
            }
            if self.active.iter().any(|i| !(self.local_stiffness[*i] > 0.0)) {
                return false;
            }
            self.factorise(n);
            let mut rhs: Vec<f64> = self.active.iter().map(|i| -slope[*i]).collect();
            self.back_substitute(&mut rhs);
            self.active.iter().zip(&rhs).for_each(|(i, value)| step[*i] = *value);
            if !self.line_search(law, contacts, &step, &slope) {
                // E is constant to rounding here, and the forces are exact to half of the digits. Newton's method
                // continues from here.
                return self.newton(law, contacts);
            }
        }
        self.evaluate(law, contacts, &mut step);
        self.factorise(n);
        false
    }

    /// Line search along `step` with sufficient descent of E and non-negative forces. Returns whether it made
    /// progress.
    fn line_search(
        &mut self,
        law: &LineContact,
        contacts: &[CoupledContact],
        step: &[f64],
        slope: &[f64],
    ) -> bool {
        let from = self.force.clone();
        let start = self.energy(law, contacts);
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            let mut promised = 0.0;
            for (i, force) in self.force.iter_mut().enumerate() {
                *force = (from[i] + share * step[i]).max(0.0);
                promised += slope[i] * (*force - from[i]);
            }
            if promised < 0.0 && self.energy(law, contacts) <= start + SHARE * promised {
                return true;
            }
            share *= 0.5;
        }
        self.force = from;
        false
    }

    /// E in J.
    fn energy(&self, law: &LineContact, contacts: &[CoupledContact]) -> f64 {
        let of_contact = |(i, contact): (usize, &CoupledContact)| {
            let force = self.force[i];
            let line = contact.line(law);
            let own = line.approach(force);
            force * (own + 0.5 * self.bent(i) - contact.approach) - line.energy(own)
        };
        contacts.iter().enumerate().map(of_contact).sum()
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::contact::ContactLaw;
    use crate::fem::flank::Stencil;
    use crate::templates::tao2024;

    /// Strongly coupled contacts, for some of which Newton's method on the approaches cycles: the descent
    /// always converges to F = f(s − C F) for any law, and to the result of Newton's method where that
    /// converges.
    #[test]
    fn descent_finds_the_forces_that_newton_may_miss() {
        let machine = tao2024();
        let mut random = Pcg64::seed_from_u64(3);
        let mut missed = 0;
        for case in 0..200 {
            let law = [ContactLaw::LineHertz, ContactLaw::Palmgren, ContactLaw::Linear { stiffness: 3e8 }]
                [case % 3];
            let (disc, pin) = (&machine.disc.material, &machine.ring.material);
            let law = LineContact::new(law, disc, pin, machine.disc.width, machine.ring.pin_radius);
            let n = random.random_range(2..24);
            let modes = random.random_range(1..6);
            let shapes: Vec<f64> = (0..n * modes).map(|_| random.random_range(-1.0..1.0)).collect();
            let soft = 10f64.powf(random.random_range(-9.0..-6.5));
            let compliance: Vec<f64> = (0..n * n)
                .map(|k| {
                    let (i, j) = (k / n, k % n);
                    let coupled: f64 =
                        (0..modes).map(|m| shapes[i * modes + m] * shapes[j * modes + m]).sum();
                    soft * coupled + if i == j { 1e-9 } else { 0.0 }
                })
                .collect();
            let contacts: Vec<CoupledContact> = (0..n)
                .map(|_| CoupledContact {
                    place: Stencil { stations: [(0, 0.0); 4], lobe: [(0, 0.0); 4] },
                    approach: random.random_range(-10e-6..30e-6),
                    equivalent_radius: random.random_range(2e-3..2e-2),
                    skew: if case % 2 == 0 { 0.0 } else { random.random_range(-2e-6..2e-6) },
                })
                .collect();
            let fresh = || {
                let mut forces = CoupledForces { compliance: compliance.clone(), ..CoupledForces::default() };
                forces.seed(&law, &contacts);
                forces
            };
            let mut found = fresh();
            assert!(found.descend(&law, &contacts), "case {case}");
            let largest = found.force.iter().fold(0.0_f64, |most, force| most.max(*force));
            for (i, contact) in contacts.iter().enumerate() {
                let force = contact.line(&law).force(contact.approach - found.bent(i)).0;
                assert!((force - found.force[i]).abs() <= 1e-8 * largest, "case {case}, {i}");
            }
            let mut newton = fresh();
            if newton.newton(&law, &contacts) {
                for (a, b) in newton.force.iter().zip(&found.force) {
                    assert!((a - b).abs() <= 1e-8 * largest, "case {case}: {a} {b}");
                }
            } else {
                missed += 1;
            }
        }
        assert!(missed > 0, "no case is hard");
    }
}
