//! Static equilibrium by a prox-linear method: linearised gaps, exact force laws.

mod compliance;
mod model;

use std::cell::Cell;

use super::system::Evaluation;
use super::{DynamicsError, System};
use model::Model;

/// A static equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// Coordinates in m or rad.
    pub position: Vec<f64>,
    /// Largest residual |Q_i| in N or N·m; that of the last step's model, if that step was within the
    /// tolerance.
    pub residual: f64,
    /// Number of evaluations of the system.
    pub iterations: usize,
}

/// Convergence criteria of the search for static equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EquilibriumControl {
    /// Converged if a step moves no coordinate by more than this multiple of its scale…
    pub tolerance: f64,
    /// …or if the largest force is below this, in N or N·m.
    pub force_tolerance: f64,
    /// Coordinate that is held, whatever force acts on it.
    pub held: Option<usize>,
}

impl Default for EquilibriumControl {
    fn default() -> Self {
        EquilibriumControl { tolerance: 1e-10, force_tolerance: 1e-9, held: None }
    }
}

/// Tolerance of static equilibria for wear: forces with an error of 1e-5 are sufficient.
pub(super) const WEAR_TOLERANCE: f64 = 1e-5;
/// Limit of the evaluations of the system; from any position within the clearances about five are needed.
const EVALUATIONS: usize = 100;
/// Initial trust region, in units of scale: displacement within which gaps are linearised, 4' at the output.
/// For an RV reducer the error of the linearised gaps is 1 % of the displacement there.
const REACH: f64 = 4.0;
/// Initial displacement within which contacts are searched: smaller, because steps from a close start are
/// short.
const NEAR: f64 = 0.1;
/// Factor on this range if a step exceeds it.
const WIDER: f64 = 10.0;
/// Least ratio of actual to predicted work at which a step is accepted, as in any trust-region method…
const LEAST_GAIN: f64 = 0.1;
/// …and the ratio from which on the trust region grows.
const GOOD_GAIN: f64 = 0.7;
/// Trust region of the second-order correction relative to the rejected step: a hundredth of the second-order
/// error remains.
const CORRECTION: f64 = 0.1;
/// Part of the tolerance below which the estimated remaining error must be.
const ESTIMATED: f64 = 0.1;
/// Factor on the trust region after a rejected step.
const SHRINK: f64 = 0.25;

/// Finds q with Q(q, 0, t) = 0 from `start`.
///
/// 1. Evaluate at q the forces Q, the tangent K_s without the contact stiffness along the gaps, and the contacts (gap g,
///    gradient G, law F).
/// 2. Minimise the model (`statics/model.rs`) in d with this linearised geometry: Q(q + d) ≈ Q − K_s d +
///    Σ G (F(−g − G d) − F(−g)) − P d. For convex laws and K_s ≥ 0 this is the gradient of a convex function.
/// 3. Accept q + d if the work of the true forces along d, by the trapezoidal rule, is at least a tenth of that of the
///    model, if necessary after a second-order correction; otherwise shrink the trust region.
///
/// The search ends with a step or with forces below the tolerance. Coordinates without stiffness are kept near
/// their position by the proximal term P.
///
/// Source of the method: Burke 1985 (Math. Programming 33, 260); Drusvyatskiy and Paquette 2019 (Math.
/// Programming 178, 503).
///
/// # Errors
/// [`DynamicsError::NoEquilibrium`] with the residual of the last accepted step.
pub fn solve_equilibrium<S: System>(
    system: &S,
    time: f64,
    start: &[f64],
    control: EquilibriumControl,
) -> Result<Equilibrium, DynamicsError> {
    solve_equilibrium_unless(system, time, start, control, &|| false)
}

/// [`solve_equilibrium`] that polls `cancelled` before every iteration.
///
/// # Errors
/// As there, and [`DynamicsError::Cancelled`].
pub fn solve_equilibrium_unless<S: System>(
    system: &S,
    time: f64,
    start: &[f64],
    control: EquilibriumControl,
    cancelled: &dyn Fn() -> bool,
) -> Result<Equilibrium, DynamicsError> {
    let mut memory = MEMORY.take().unwrap_or_default();
    let found = search(system, time, start, control, cancelled, &mut memory);
    MEMORY.set(Some(memory));
    found
}

/// Memory reused from one search to the next: a test bench needs thousands of them.
#[derive(Default)]
struct Memory {
    here: Evaluation,
    there: Evaluation,
    model: Model,
}

thread_local! {
    static MEMORY: Cell<Option<Box<Memory>>> = const { Cell::new(None) };
}

fn search<S: System>(
    system: &S,
    time: f64,
    start: &[f64],
    control: EquilibriumControl,
    cancelled: &dyn Fn() -> bool,
    memory: &mut Memory,
) -> Result<Equilibrium, DynamicsError> {
    let (n, scale) = (system.size(), system.scale());
    let largest = |f: &[f64]| f.iter().fold(0.0, |m: f64, x| if x.abs() <= m { m } else { x.abs() });
    let length_of = |d: &[f64]| d.iter().zip(scale).fold(0.0, |m: f64, (x, s)| m.max(x.abs() / s));
    let unit = scale.iter().copied().fold(f64::INFINITY, f64::min);
    let evaluate = |position: &[f64], range: f64, evaluation: &mut Evaluation| {
        // A gap changes by the displacements of two bodies.
        system.evaluate_statics(time, position, 2.0 * range * unit, evaluation);
        if let Some(held) = control.held {
            evaluation.force[held] = 0.0;
        }
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let Memory { here, there, model } = memory;
    here.fit(system, control.held);
    there.fit(system, control.held);
    model.fit(system, here);
    let (mut position, mut trial, mut step) = (start.to_vec(), vec![0.0; n], vec![0.0; n]);
    let (mut reach, mut range, mut last) = (REACH, NEAR, None::<(f64, usize)>);
    evaluate(&position, range, here);
    let mut iterations = 1;
    while iterations < EVALUATIONS {
        if cancelled() {
            return Err(DynamicsError::Cancelled { time });
        }
        if largest(&here.force) <= control.force_tolerance {
            return Ok(Equilibrium { residual: largest(&here.force), position, iterations });
        }
        let Some(solution) = model.solve(system, here, (reach, range), &mut step) else { break };
        let length = length_of(&step);
        if !length.is_finite() {
            break;
        }
        if !solution.is_inside && range < reach {
            // The step exceeds the range in which contacts were searched.
            range = reach.min(WIDER * range);
            evaluate(&position, range, here);
            continue;
        }
        trial.iter_mut().zip(position.iter().zip(&step)).for_each(|(t, (q, d))| *t = q + d);
        // If no contact opens or closes, step lengths decrease quadratically. They decrease linearly with
        // friction, which follows the normal forces, and with elastic bodies, along whose coordinates the model
        // has no second derivative of the gaps.
        let pressed = here.contacts.pressed();
        let before = last.filter(|(_, others)| *others == pressed && solution.pressed == pressed);
        let shrunk = before.map_or(1.0, |(before, _)| (length / before).min(1.0));
        let is_exact = !here.contacts.has_friction && here.contacts.places.is_empty();
        let left = if is_exact { shrunk * shrunk } else { shrunk } + solution.inexactness;
        let is_small = length <= control.tolerance || left * length <= ESTIMATED * control.tolerance;
        if solution.is_inside && is_small {
            return Ok(Equilibrium { residual: solution.residual, position: trial, iterations });
        }
        // Within the trust region the next step is shorter than this one.
        range = if solution.is_inside { length } else { 2.0 * length };
        evaluate(&trial, range, there);
        iterations += 1;
        // Along a step to the model's minimum its force decreases to zero: the predicted work is half of
        // `before`.
        let before = dot(&here.force, &step);
        let mut gain = (before + dot(&there.force, &step)) / before;
        if !(gain >= LEAST_GAIN) {
            // Contacts follow curved gaps: a second-order correction returns the step to them before the ratio
            // is evaluated.
            let mut correction = vec![0.0; n];
            let within = CORRECTION * length;
            if model.solve(system, there, (within, within), &mut correction).is_some() {
                step.iter_mut().zip(&correction).for_each(|(d, more)| *d += more);
                trial.iter_mut().zip(&correction).for_each(|(t, more)| *t += more);
                evaluate(&trial, range, there);
                iterations += 1;
                let before = dot(&here.force, &step);
                gain = (before + dot(&there.force, &step)) / before;
            }
        }
        last = (solution.is_inside && gain >= GOOD_GAIN).then_some((length, solution.pressed));
        if gain >= LEAST_GAIN {
            std::mem::swap(&mut position, &mut trial);
            std::mem::swap(here, there);
            if gain >= GOOD_GAIN {
                reach = reach.max(2.0 * length);
            }
        } else {
            reach = SHRINK * reach.min(length);
        }
        if reach < control.tolerance {
            break;
        }
    }
    Err(DynamicsError::NoEquilibrium {
        time,
        crank_angle_deg: system.crank_angle(&position) / crate::units::DEG,
        residual: largest(&here.force),
        iterations,
    })
}

/// Static equilibrium under a load by continuation from larger loads, under which more contacts constrain the
/// bodies; used where the search from a start fails. It begins with the rated load, or the next larger one for
/// which the search converges. `solve` finds the equilibrium under a load near a start.
///
/// # Errors
/// The error of `solve` if it fails on the way.
pub(crate) fn continue_from_larger_loads<E>(
    load: f64,
    rated: f64,
    mut solve: impl FnMut(f64, Option<&[f64]>) -> Result<Vec<f64>, E>,
) -> Result<Vec<f64>, E> {
    let most = MOST_LOAD * rated.max(load.abs());
    let mut larger = rated.max(FALL * load.abs());
    let mut place = loop {
        match solve(larger.copysign(load), None) {
            Err(_) if FALL * larger < most => larger *= FALL,
            found => break found?,
        }
    };
    while larger > FALL * load.abs().max(LEAST_LOAD * rated) {
        larger /= FALL;
        place = solve(larger.copysign(load), Some(&place))?;
    }
    solve(load, Some(&place))
}

/// Ratio of successive loads of a continuation.
const FALL: f64 = 3.0;
/// Largest load of a continuation relative to the rated one.
const MOST_LOAD: f64 = 100.0;
/// Load relative to the rated one that counts as zero.
const LEAST_LOAD: f64 = 1e-4;

#[cfg(test)]
mod tests;
