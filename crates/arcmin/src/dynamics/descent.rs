//! The safe way to a state of rest, for where Newton's method does not lead there.

use super::equilibrium::{Equilibrium, EquilibriumControl, JUMP_OF_STORED};
use super::{Linearisation, System, Weights};

/// A line search ends when the work along the step has fallen to this share of what it was at its beginning.
const ENOUGH: f64 = 0.2;
const LINE_SEARCHES: usize = 25;
/// So many steps without halving the forces mean that what is left may be a jump…
const STUCK: usize = 80;
/// Half of the width of a jump, in units of scale: 1e-3' of angles, some 0.01 µm of places.
pub(crate) const JUMP_WIDTH: f64 = 1e-3;
/// …and so many that there is no way on: bodies cross a clearance under a force that stays as it is.
const HOPELESS: usize = 600;

/// Finds q with Q(q, 0, t) = 0 by descent in energy: (K + μ D) Δq = Q with D = 1/scale², and along every step
/// the place where the forces no longer do work.
///
/// Clearances, springs and contacts store energy, the load does work; rest is where the sum is least. Along
/// Δq the work Q·Δq falls from its first value through zero at the lowest place, so its sign says on which
/// side of that place a trial is, however the forces change on the way: a body that flies through its
/// clearance into a contact is stopped where it turns back. Slow friction only adds to the fall. μ grows until
/// the step is downhill and no longer than the trust length, and goes with the forces, so that the last steps
/// are Newton's. Where forces jump (a pin in the root of a worn flank goes over to the other side), no place
/// balances them; the lowest place is accepted when the work that is left along one unit of scale is a small
/// share of the energy stored, as in [`EquilibriumControl::jump_tolerance`], and it is shown to be a jump: the
/// place has not moved by more than [`JUMP_WIDTH`] since, and so far along the forces left, the forces turn
/// back. A place that merely creeps downhill is not accepted.
///
/// `None` where it does not get there, or is cancelled.
pub(super) fn descend<S: System>(
    system: &S,
    time: f64,
    start: &[f64],
    control: EquilibriumControl,
    cancelled: &dyn Fn() -> bool,
) -> Option<Equilibrium> {
    let n = system.size();
    let scale = system.scale();
    let metric: Vec<f64> = scale.iter().map(|scale| 1.0 / (scale * scale)).collect();
    let rest = vec![0.0; n];
    let mut lin = system.linearisation_at_rest();
    let mut position = start.to_vec();
    let mut force = vec![0.0; n];
    let (mut trial, mut trial_force, mut step) = (position.clone(), force.clone(), force.clone());
    let evaluate = |position: &[f64], force: &mut [f64], lin: &mut S::Linearisation| {
        let balance = system.evaluate(time, position, &rest, force, lin);
        if let Some(held) = control.held {
            force[held] = 0.0;
            lin.hold(held);
        }
        balance
    };
    let work = |f: &[f64]| f.iter().zip(scale).map(|(f, s)| (f * s).powi(2)).sum::<f64>().sqrt();
    let largest = |f: &[f64]| f.iter().fold(0.0, |m: f64, x| if x.abs() <= m { m } else { x.abs() });
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut balance = evaluate(&position, &mut force, &mut lin);
    let (mut trust, mut mu) = (control.trust, 0.0);
    let mut halved = (f64::INFINITY, 0);
    let mut place_then = start.to_vec();
    for iteration in 0..control.largest_iteration_count {
        let size = work(&force);
        if !size.is_finite() || cancelled() {
            return None;
        }
        if size < 0.5 * halved.0 {
            halved = (size, iteration);
            place_then.copy_from_slice(&position);
        }
        let jump = control.jump_tolerance.max(JUMP_OF_STORED * balance.stored);
        if largest(&force) <= control.force_tolerance {
            return Some(Equilibrium { residual: largest(&force), position, iterations: iteration });
        }
        if size <= jump && iteration > halved.1 + STUCK && (iteration - halved.1) % STUCK == 1 {
            let moved = position.iter().zip(&place_then).zip(scale);
            let stays = moved.fold(0.0, |m: f64, ((q, then), s)| m.max((q - then).abs() / s)) <= JUMP_WIDTH;
            place_then.copy_from_slice(&position);
            for i in 0..n {
                step[i] = JUMP_WIDTH * scale[i] * (scale[i] * force[i]) / size;
                trial[i] = position[i] + step[i];
            }
            if stays {
                evaluate(&trial, &mut trial_force, &mut lin);
                let turns_back = dot(&trial_force, &step) <= 0.0;
                evaluate(&position, &mut force, &mut lin);
                if turns_back {
                    return Some(Equilibrium { residual: largest(&force), position, iterations: iteration });
                }
            }
        }
        if iteration > halved.1 + HOPELESS {
            return None;
        }
        // Along the forces alone a step of one trust length.
        let natural = size / trust;
        let mut length = f64::INFINITY;
        let mut downhill = false;
        for _ in 0..40 {
            step.copy_from_slice(&force);
            let solved = lin.solve(&metric, Weights { mass: mu, damping: 0.0, stiffness: 1.0 }, &mut step);
            length = step.iter().zip(scale).fold(0.0, |m: f64, (x, s)| m.max(x.abs() / s));
            downhill = solved.is_ok() && length.is_finite() && dot(&step, &force) > 0.0;
            if downhill && length <= 2.0 * trust {
                break;
            }
            mu = if mu < 1e-6 * natural { 1e-6 * natural } else { 5.0 * mu };
        }
        if !downhill {
            return None;
        }
        let shortening = (trust / length).min(1.0);
        step.iter_mut().for_each(|x| *x *= shortening);
        let length = shortening * length;
        let first = dot(&force, &step);
        // The step's share tried, and the shares known to lie before and behind the lowest place, with the
        // work there.
        let (mut share, mut before, mut behind) = (1.0, (0.0, first), None::<(f64, f64)>);
        let mut searches = 0;
        loop {
            for i in 0..n {
                trial[i] = position[i] + share * step[i];
            }
            balance = evaluate(&trial, &mut trial_force, &mut lin);
            let along = dot(&trial_force, &step);
            searches += 1;
            let low = along.is_finite() && along >= -ENOUGH * first;
            if low && (share == 1.0 || along <= ENOUGH * first || searches >= LINE_SEARCHES) {
                break;
            }
            if low {
                before = (share, along);
            } else {
                behind = Some((share, if along.is_finite() { along } else { f64::INFINITY }));
            }
            let (far, at_far) = behind.unwrap_or((1.0, -first));
            let secant = before.0 + (far - before.0) * before.1 / (before.1 - at_far);
            let width = far - before.0;
            // Every other time the middle, so that neither end stays.
            share = if at_far.is_finite() && searches % 2 == 1 {
                secant.clamp(before.0 + 0.05 * width, far - 0.05 * width)
            } else {
                before.0 + 0.5 * width
            };
            if searches > 2 * LINE_SEARCHES {
                break;
            }
        }
        let whole = share == 1.0 && shortening == 1.0;
        std::mem::swap(&mut position, &mut trial);
        std::mem::swap(&mut force, &mut trial_force);
        if whole && length <= control.tolerance && mu <= 1e-3 * natural {
            return Some(Equilibrium { residual: largest(&force), position, iterations: iteration + 1 });
        }
        let falls = (work(&force) / size).clamp(0.0, 1.0);
        if share == 1.0 {
            trust = (2.0 * trust).min(control.trust);
            mu *= 0.2 * falls;
        } else {
            trust = (4.0 * share * length).clamp(control.tolerance, control.trust);
            mu *= falls;
        }
        if mu < 1e-9 * natural {
            mu = 0.0;
        }
    }
    None
}
