//! States of rest by a prox-linear method: gaps to first order, force laws exact.

mod compliance;
mod model;

use std::cell::Cell;

use super::system::Look;
use super::{DynamicsError, System};
use model::Model;

/// A state of rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// Coordinates in m or rad.
    pub position: Vec<f64>,
    /// Largest |Q_i| left, in N or N·m; what the model of the last step leaves, where that step was within the
    /// tolerance.
    pub residual: f64,
    /// Places at which the system was evaluated.
    pub iterations: usize,
}

/// When a search for a state of rest ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EquilibriumControl {
    /// A step that moves no coordinate by more than this multiple of its scale is the last…
    pub tolerance: f64,
    /// …and a place is a state of rest where the largest force is below this, in N or N·m.
    pub force_tolerance: f64,
    /// A coordinate that does not move, whatever pulls at it.
    pub held: Option<usize>,
}

impl Default for EquilibriumControl {
    fn default() -> Self {
        EquilibriumControl { tolerance: 1e-10, force_tolerance: 1e-9, held: None }
    }
}

/// Evaluations of the system after which the search gives up; from anywhere in the clearances it needs about five.
const EVALUATIONS: usize = 100;
/// Displacement, in units of scale, within which gaps are taken as linear at first: 4' at the output. The gaps of an RV
/// reducer depart from their tangents by 1 % of the displacement there.
const REACH: f64 = 4.0;
/// Displacement within which contacts are looked for at first: from a near start steps are shorter.
const NEAR: f64 = 0.1;
/// How much farther they are looked for where a step goes beyond.
const WIDER: f64 = 10.0;
/// Share of the work promised by the model that a step must do, as in any trust-region method…
const LEAST_GAIN: f64 = 0.1;
/// …and the share from which on the model is trusted further.
const GOOD_GAIN: f64 = 0.7;
/// Reach of the correction of a poor step, as a share of that step: it leaves a hundredth of what second order did.
const CORRECTION: f64 = 0.1;
/// Share of the tolerance within which an estimate of what a step leaves must be.
const ESTIMATED: f64 = 0.1;
/// Factor on the reach after a step that is not accepted.
const SHRINK: f64 = 0.25;

/// Finds q with Q(q, 0, t) = 0 from `start`.
///
/// 1. Evaluate forces Q, the tangent K_s without the stiffness of contacts along their gaps, and the contacts (gap g,
///    gradient G, law F) at q.
/// 2. Minimise the model (`statics/model.rs`) in d without looking at the geometry again: Q(q + d) ≈ Q − K_s d +
///    Σ G (F(−g − G d) − F(−g)) − P d. With convex laws and K_s ≥ 0 this is the gradient of a convex function.
/// 3. Go to q + d if the work of the true forces along d, by the trapezoidal rule, is at least a tenth of what the
///    model promises, if need be after a second-order correction; else shorten the reach of the model.
///
/// A search ends with a step that is below the tolerance, or when the forces are. Coordinates that nothing holds are
/// kept near their place by the proximal term P.
///
/// Source of the method: Burke 1985 (Math. Programming 33, 260); Drusvyatskiy and Paquette 2019 (Math. Programming 178,
/// 503).
///
/// # Errors
/// [`DynamicsError::NoEquilibrium`] with the residual reached.
pub fn solve_equilibrium<S: System>(
    system: &S,
    time: f64,
    start: &[f64],
    control: EquilibriumControl,
) -> Result<Equilibrium, DynamicsError> {
    solve_equilibrium_unless(system, time, start, control, &|| false)
}

/// [`solve_equilibrium`] that asks before every iteration whether it is still wanted.
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

/// Memory reused from one search to the next: a bench asks for thousands.
#[derive(Default)]
struct Memory {
    here: Look,
    there: Look,
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
    let evaluate = |position: &[f64], sight: f64, look: &mut Look| {
        // A gap moves by the displacements of two bodies.
        system.look(time, position, 2.0 * sight * unit, look);
        if let Some(held) = control.held {
            look.force[held] = 0.0;
        }
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let Memory { here, there, model } = memory;
    here.fit(system, control.held);
    there.fit(system, control.held);
    model.fit(system, here);
    let (mut position, mut trial, mut step) = (start.to_vec(), vec![0.0; n], vec![0.0; n]);
    let (mut reach, mut sight, mut last) = (REACH, NEAR, None::<(f64, usize)>);
    evaluate(&position, sight, here);
    let mut iterations = 1;
    while iterations < EVALUATIONS {
        if cancelled() {
            return Err(DynamicsError::Cancelled { time });
        }
        if largest(&here.force) <= control.force_tolerance {
            return Ok(Equilibrium { residual: largest(&here.force), position, iterations });
        }
        let Some(solution) = model.solve(system, here, (reach, sight), &mut step) else { break };
        let length = length_of(&step);
        if !length.is_finite() {
            break;
        }
        if !solution.is_inside && sight < reach {
            // The step goes beyond the contacts that were looked for.
            sight = reach.min(WIDER * sight);
            evaluate(&position, sight, here);
            continue;
        }
        trial.iter_mut().zip(position.iter().zip(&step)).for_each(|(t, (q, d))| *t = q + d);
        // While no contact opens or closes, steps shrink as the squares of those before; in proportion where friction follows
        // the forces, and where elastic bodies give way, along whose coordinates gaps do not bend in the model.
        let pressed = here.contacts.pressed();
        let before = last.filter(|(_, others)| *others == pressed && solution.pressed == pressed);
        let shrunk = before.map_or(1.0, |(before, _)| (length / before).min(1.0));
        let is_exact = !here.contacts.has_friction && here.contacts.places.is_empty();
        let left = if is_exact { shrunk * shrunk } else { shrunk } + solution.inexactness;
        let is_small = length <= control.tolerance || left * length <= ESTIMATED * control.tolerance;
        if solution.is_inside && is_small {
            return Ok(Equilibrium { residual: solution.residual, position: trial, iterations });
        }
        // Inside the reach the next step is shorter than this one.
        sight = if solution.is_inside { length } else { 2.0 * length };
        evaluate(&trial, sight, there);
        iterations += 1;
        // Along a step to the model's minimum its force falls to zero: it promises half of `before`.
        let before = dot(&here.force, &step);
        let mut gain = (before + dot(&there.force, &step)) / before;
        if !(gain >= LEAST_GAIN) {
            // Contacts are led along curves: what the step went off them is made up for before it is judged.
            let mut correction = vec![0.0; n];
            let within = CORRECTION * length;
            if model.solve(system, there, (within, within), &mut correction).is_some() {
                step.iter_mut().zip(&correction).for_each(|(d, more)| *d += more);
                trial.iter_mut().zip(&correction).for_each(|(t, more)| *t += more);
                evaluate(&trial, sight, there);
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

/// The state of rest under a load by way of larger ones, under which more contacts hold the bodies: the continuation for
/// where the search from a start does not end. It begins with the rated load, or the next larger one under which the search
/// ends. `solve` finds the state under a load near a start.
///
/// # Errors
/// That of `solve` where it finds none on the way.
pub(crate) fn by_larger_loads<E>(
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

/// From one load of a continuation to the next.
const FALL: f64 = 3.0;
/// Largest load of a continuation over the rated one.
const MOST_LOAD: f64 = 100.0;
/// Share of the rated load that is as good as none.
const LEAST_LOAD: f64 = 1e-4;

#[cfg(test)]
mod tests;
