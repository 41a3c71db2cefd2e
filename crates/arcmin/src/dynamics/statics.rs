//! States of rest by a prox-linear method: gaps to first order, force laws exact.
//!
//! It runs beside [`solve_equilibrium`](super::solve_equilibrium), which the analyses still use; the example
//! `states_of_rest` compares both on random machines.

mod model;

use super::{DynamicsError, Equilibrium, EquilibriumControl, System};
use model::Model;

/// Evaluations of the machine after which the search gives up; from anywhere in the clearances it needs about five.
const EVALUATIONS: usize = 60;
/// Largest displacement, in units of scale, for which a gap is taken as linear: 4' at the output. The gaps of an
/// RV reducer depart from their tangents by 1 % of the displacement there.
const REACH: f64 = 4.0;
/// Share of the work promised by the model that a step must do, as in any trust-region method…
const LEAST_GAIN: f64 = 0.1;
/// …and the share from which on the model is trusted further.
const GOOD_GAIN: f64 = 0.7;
/// Factor on the reach after a step that is not accepted.
const SHRINK: f64 = 0.25;

/// Finds q with Q(q, 0, t) = 0 from `start`.
///
/// 1. Evaluate forces Q, tangent K and contacts (gap g, gradient G, law F) at q.
/// 2. Minimise the model (`model.rs`) in d without looking at the geometry again: Q(q + d) ≈ Q − K_s d + Σ G (F(−g − G d)
///    − F(−g)) − P d, where K_s is K without the stiffness of the contacts along their gaps. With convex laws and K_s ≥ 0
///    this is the gradient of a convex function.
/// 3. Go to q + d if the work of the true forces along d, by the trapezoidal rule, is at least a tenth of what the
///    model promises; else shorten the reach of the model. What the model left out along a poor step is added to it by a
///    symmetric rank-one update.
///
/// A search ends when a whole step is below the tolerance, or when the forces are. Coordinates that nothing holds are
/// kept near their place by the proximal term P.
///
/// Source of the method: Burke 1985 (Math. Programming 33, 260); Drusvyatskiy and Paquette 2019 (Math. Programming 178,
/// 503).
///
/// # Errors
/// [`DynamicsError::NoEquilibrium`] with the residual reached, [`DynamicsError::Cancelled`].
pub fn rest<S: System>(
    system: &S,
    time: f64,
    start: &[f64],
    control: EquilibriumControl,
    cancelled: &dyn Fn() -> bool,
) -> Result<Equilibrium, DynamicsError> {
    let (n, scale) = (system.size(), system.scale());
    let zero = vec![0.0; n];
    let largest = |f: &[f64]| f.iter().fold(0.0, |m: f64, x| if x.abs() <= m { m } else { x.abs() });
    let length_of = |d: &[f64]| d.iter().zip(scale).fold(0.0, |m: f64, (x, s)| m.max(x.abs() / s));
    let evaluate = |position: &[f64], force: &mut [f64], tangent: &mut S::Linearisation| {
        system.evaluate(time, position, &zero, force, tangent);
        if let Some(held) = control.held {
            force[held] = 0.0;
        }
    };
    let mut model = Model::new(system, control.held);
    let (mut position, mut force, mut tangent) =
        (start.to_vec(), vec![0.0; n], system.linearisation_at_rest());
    let (mut trial, mut trial_force, mut trial_tangent) =
        (vec![0.0; n], vec![0.0; n], system.linearisation_at_rest());
    let mut step = vec![0.0; n];
    evaluate(&position, &mut force, &mut tangent);
    model.take(system, time, &position, &force, &tangent, REACH);
    let mut reach = REACH;
    for iterations in 1..EVALUATIONS {
        if cancelled() {
            return Err(DynamicsError::Cancelled { time });
        }
        if largest(&force) <= control.force_tolerance {
            return Ok(Equilibrium { residual: largest(&force), position, iterations });
        }
        let Some(is_whole) = model.solve(system, reach, &mut step) else { break };
        let length = length_of(&step);
        if !length.is_finite() {
            break;
        }
        let is_last = is_whole && length <= control.tolerance;
        trial.iter_mut().zip(position.iter().zip(&step)).for_each(|(t, (q, d))| *t = q + d);
        evaluate(&trial, &mut trial_force, &mut trial_tangent);
        let before: f64 = force.iter().zip(&step).map(|(f, d)| f * d).sum();
        let behind: f64 = trial_force.iter().zip(&step).map(|(f, d)| f * d).sum();
        // Along a step to the model's minimum its force falls to zero: it promises half of `before`.
        let gain = if before > 0.0 { (before + behind) / before } else { f64::NAN };
        let misfit = if gain >= GOOD_GAIN && is_whole { None } else { model.misfit(&step, &trial_force) };
        if gain >= LEAST_GAIN {
            std::mem::swap(&mut position, &mut trial);
            std::mem::swap(&mut force, &mut trial_force);
            std::mem::swap(&mut tangent, &mut trial_tangent);
            if gain >= GOOD_GAIN {
                reach = reach.max((2.0 * length).min(REACH));
            }
            model.take(system, time, &position, &force, &tangent, REACH);
        } else {
            reach = SHRINK * reach.min(length);
        }
        if is_last {
            // A last step that does no work is hidden by rounding.
            return Ok(Equilibrium { residual: largest(&force), position, iterations });
        }
        if let Some((misfit, work)) = misfit {
            model.correct(&misfit, work);
        }
        if reach < control.tolerance {
            break;
        }
    }
    Err(DynamicsError::NoEquilibrium {
        time,
        crank_angle_deg: system.crank_angle(&position) / crate::units::DEG,
        residual: largest(&force),
        iterations: EVALUATIONS,
    })
}

#[cfg(test)]
mod tests;
