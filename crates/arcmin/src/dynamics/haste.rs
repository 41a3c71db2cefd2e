//! The short way to a state of rest, from a start that is nearly one.

use super::equilibrium::{Equilibrium, EquilibriumControl};
use super::{Linearisation, System, Weights};

/// Steps after which the start was not so good.
const STEPS: usize = 12;
/// A step this short, in units of the system's scale, may be the last by what the one before it tells.
const SHORT: f64 = 1e-3;
/// Share of the work along a step that may be left at its end when it is taken for one of quadratic convergence.
const LEFT: f64 = 1e-3;
/// Work against a step over that along it from which on the step is blocked; two such steps are enough.
const BLOCKED: f64 = 100.0;

/// Newton's method without a safety net: `None` where it does not converge within a dozen steps from `start`.
///
/// From a balance of neighbouring loads or surfaces it takes fewer steps than a search that looks after itself.
/// Contacts that close on the way stiffen the machine, so a step may go far past the balance; where the work
/// against it exceeds the work along it, it is cut where the straight line between both vanishes. Steps shrink
/// quadratically near the balance: the one after a step s is about s² over the one before it, and a step after
/// which that is less than a tenth of the tolerance is the last.
pub(super) fn hasten<S: System>(
    system: &S,
    time: f64,
    start: &[f64],
    control: EquilibriumControl,
) -> Option<Equilibrium> {
    let n = system.size();
    let (mass, scale) = (system.mass(), system.scale());
    let rest = vec![0.0; n];
    let mut lin = system.linearisation_at_rest();
    let mut position = start.to_vec();
    let (mut force, mut step, mut trial) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let largest = |f: &[f64]| f.iter().fold(0.0, |m: f64, x| if x.abs() <= m { m } else { x.abs() });
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let evaluate = |position: &[f64], force: &mut [f64], lin: &mut S::Linearisation| {
        let balance = system.evaluate(time, position, &rest, force, lin);
        if let Some(held) = control.held {
            force[held] = 0.0;
            lin.hold(held);
        }
        balance
    };
    let mut balance = evaluate(&position, &mut force, &mut lin);
    let mut before = 0.0;
    let mut blocked = false;
    for iterations in 0..STEPS {
        let residual = largest(&force);
        if residual <= control.force_tolerance {
            return Some(Equilibrium { residual, position, balance, iterations });
        }
        step.copy_from_slice(&force);
        lin.solve(mass, Weights { mass: 0.0, damping: 0.0, stiffness: 1.0 }, &mut step).ok()?;
        let length = step.iter().zip(scale).fold(0.0, |m: f64, (x, s)| m.max(x.abs() / s));
        if !length.is_finite() || dot(&step, &force) <= 0.0 {
            return None;
        }
        let shortening = (control.trust / length).min(1.0);
        step.iter_mut().for_each(|x| *x *= shortening);
        let first = dot(&force, &step);
        trial.iter_mut().zip(position.iter().zip(&step)).for_each(|(t, (q, x))| *t = q + x);
        balance = evaluate(&trial, &mut force, &mut lin);
        let along = dot(&force, &step);
        if !along.is_finite() {
            return None;
        }
        let next = length * length / before;
        let shrinks = length <= SHORT && next <= 0.1 * control.tolerance && along.abs() <= LEFT * first;
        if length <= control.tolerance || shrinks {
            let residual = largest(&force);
            return Some(Equilibrium { residual, position: trial, balance, iterations: iterations + 1 });
        }
        before = length;
        // The secant leaves next to nothing of a step that runs into a contact on its way, and of the next.
        if along < -BLOCKED * first {
            if blocked {
                return None;
            }
            blocked = true;
        }
        if along < -first {
            let share = first / (first - along);
            trial.iter_mut().zip(position.iter().zip(&step)).for_each(|(t, (q, x))| *t = q + share * x);
            balance = evaluate(&trial, &mut force, &mut lin);
            // What follows a cut step says nothing about convergence.
            before = 0.0;
        }
        std::mem::swap(&mut position, &mut trial);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{BearingJoints, JointSettings, solve_equilibrium};

    /// From the balance under a tenth less load the short way ends where the long one from the nominal place
    /// does, within the tolerance; from a start that is no good it gives up.
    #[test]
    fn the_short_way_ends_where_the_long_one_does() {
        let machine = crate::templates::rv_40e_81();
        let mut model = BearingJoints::held(&machine, &JointSettings::default()).unwrap();
        let control = EquilibriumControl { tolerance: 1e-7, force_tolerance: 1e-6, ..Default::default() };
        for sun in [0.0, 3.3, 17.0] {
            model.hold_sun(sun, 0.0);
            model.set_load(0.9 * machine.rated.torque);
            let near = solve_equilibrium(&model, 0.0, &model.nominal_position_at(sun), control).unwrap();
            model.set_load(machine.rated.torque);
            let short = hasten(&model, 0.0, &near.position, control).unwrap();
            let exact = EquilibriumControl { tolerance: 1e-11, ..control };
            let long = solve_equilibrium(&model, 0.0, &near.position, exact).unwrap();
            assert!(short.iterations <= 6, "{}", short.iterations);
            for ((a, b), scale) in short.position.iter().zip(&long.position).zip(model.scale()) {
                assert!((a - b).abs() < 1e-7 * scale, "{sun}: {a} {b}");
            }
        }
        // Every body turned by a degree: nothing can be read from the forces there.
        let lost: Vec<f64> = model.nominal_position_at(0.0).iter().map(|q| q + 0.02).collect();
        assert!(hasten(&model, 0.0, &lost, control).is_none());
    }
}
