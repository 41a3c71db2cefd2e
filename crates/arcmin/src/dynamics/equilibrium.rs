use super::descent::descend;
use super::haste::hasten;
use super::{DynamicsError, Linearisation, System, Weights};

/// A state of rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// Coordinates in m or rad.
    pub position: Vec<f64>,
    /// Largest |Q_i| left, in N or N·m; what is foretold, where the last step was so short that nobody looked.
    pub residual: f64,
    pub iterations: usize,
}

/// Limits of the static solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EquilibriumControl {
    /// Converged when a Newton step moves no coordinate by more than this multiple of its scale…
    pub tolerance: f64,
    /// …or the largest force is below this, in N or N·m.
    pub force_tolerance: f64,
    pub largest_iteration_count: usize,
    /// Longest step of one iteration in units of the system's scale.
    pub trust: f64,
    /// Where forces jump, no place balances them: a pin at the root of a worn flank touches on one side or
    /// the other. A place on whose two sides the balance lies, closer together than `tolerance`, is accepted
    /// when the work of its forces along one unit of scale is below this, in J; so is a place from which
    /// steps no longer lead on. The residual says what is left.
    pub jump_tolerance: f64,
    /// A coordinate that does not move, whatever pulls at it.
    pub held: Option<usize>,
    /// Whether the start is so far off that other contacts may press where the balance is: then the first steps look
    /// which ones they meet, which costs as much as an evaluation or two.
    pub from_afar: bool,
    /// Whether the start may be so good that a few steps of Newton's method by itself lead to the balance.
    pub haste: bool,
    /// Descent in energy where Newton's method fails: sure, but long. Whoever knows other places to start from
    /// tries those first.
    pub descent: bool,
}

impl Default for EquilibriumControl {
    fn default() -> Self {
        EquilibriumControl {
            tolerance: 1e-10,
            force_tolerance: 1e-9,
            largest_iteration_count: 400,
            trust: 1.0,
            jump_tolerance: 0.0,
            held: None,
            from_afar: false,
            haste: true,
            descent: true,
        }
    }
}

/// A full Newton step from a place accepted at a jump is shorter than this, in units of the system's scale.
const NEAR_JUMP: f64 = 1e-2;
/// Share of the elastic energy that a jump may leave as work along one unit of scale.
pub(super) const JUMP_OF_STORED: f64 = 2e-3;
/// Where several contacts jump, Newton's method creeps along their edges: so many iterations without halving
/// the forces are enough.
const CREEPING: usize = 60;

/// Finds q with Q(q, 0, t) = 0 near `start`.
///
/// Newton's method with a mass term that vanishes as the forces do (pseudo-transient continuation): (μ M + K)
/// Δq = Q. Bodies that hang free in a clearance have no stiffness; the mass term then drives them along the
/// force until a contact stops them. A state whose forces vanish already is an equilibrium, wherever in the
/// clearance it is. Where the start is so good that a few steps of Newton's method by itself do, these are all;
/// where the mass term does not get there, descent in energy starts anew: slower, but sure wherever the forces
/// derive from an energy.
///
/// # Errors
/// [`DynamicsError::NoEquilibrium`] with the residual reached if the iterations are used up.
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
    if control.haste
        && let Some(found) = hasten(system, time, start, control)
    {
        return Ok(found);
    }
    let failure = match newton(system, time, start, control, cancelled) {
        Err(failure @ DynamicsError::NoEquilibrium { .. }) if control.descent => failure,
        result => return result,
    };
    let patient =
        EquilibriumControl { largest_iteration_count: PATIENCE * control.largest_iteration_count, ..control };
    match descend(system, time, start, patient, cancelled) {
        Some(found) => Ok(found),
        None if cancelled() => Err(DynamicsError::Cancelled { time }),
        None => Err(failure),
    }
}

/// The μ with which μ M by itself would move no coordinate by more than one unit of the system's scale.
pub(super) fn mass_term<S: System>(system: &S, force: &[f64]) -> f64 {
    let units = system.mass().iter().zip(system.scale());
    force.iter().zip(units).fold(0.0, |most: f64, (f, (mass, scale))| most.max(f.abs() / (mass * scale)))
}

/// Times as many iterations of the descent.
const PATIENCE: usize = 5;

fn newton<S: System>(
    system: &S,
    time: f64,
    start: &[f64],
    control: EquilibriumControl,
    cancelled: &dyn Fn() -> bool,
) -> Result<Equilibrium, DynamicsError> {
    let n = system.size();
    let (mass, scale) = (system.mass(), system.scale());
    let rest = vec![0.0; n];
    let mut lin = system.linearisation_at_rest();
    let mut trial_lin = system.linearisation_at_rest();
    let mut position = start.to_vec();
    let mut force = vec![0.0; n];
    let mut trial = vec![0.0; n];
    let mut trial_force = vec![0.0; n];
    let mut step = vec![0.0; n];
    // Forces of different kinds are compared through the work they do along one unit of error.
    let work = |f: &[f64]| f.iter().zip(scale).map(|(f, s)| (f * s).powi(2)).sum::<f64>().sqrt();
    let largest = |f: &[f64]| f.iter().fold(0.0, |m: f64, x| if x.abs() <= m { m } else { x.abs() });
    let evaluate = |position: &[f64], force: &mut [f64], lin: &mut S::Linearisation| {
        let balance = system.evaluate(time, position, &rest, force, lin);
        if let Some(held) = control.held {
            force[held] = 0.0;
            lin.hold(held);
        }
        balance
    };
    let mut balance = evaluate(&position, &mut force, &mut lin);
    let mut mu = 0.0;
    let mut trust = control.trust;
    // Size of the forces that was halved last, and when.
    let mut halved = (f64::INFINITY, 0);
    for iteration in 0..control.largest_iteration_count {
        if cancelled() {
            return Err(DynamicsError::Cancelled { time });
        }
        let size = work(&force);
        if !size.is_finite() {
            break;
        }
        if size < 0.5 * halved.0 {
            halved = (size, iteration);
        }
        // A machine under preload has larger forces to jump than its load tells.
        let jump = if control.jump_tolerance > 0.0 {
            control.jump_tolerance.max(JUMP_OF_STORED * balance.stored)
        } else {
            0.0
        };
        let creeps = iteration > halved.1 + CREEPING && size <= jump;
        if creeps || largest(&force) <= control.force_tolerance {
            return Ok(Equilibrium { residual: largest(&force), position, iterations: iteration });
        }
        step.copy_from_slice(&force);
        let solved = lin.solve(mass, Weights { mass: mu, damping: 0.0, stiffness: 1.0 }, &mut step);
        let length = step.iter().zip(scale).fold(0.0, |m: f64, (x, s)| m.max(x.abs() / s));
        // A mass term that by itself would move the coordinates by about one trust length.
        let natural = mass_term(system, &force) / trust;
        let uphill = step.iter().zip(&force).map(|(x, f)| x * f).sum::<f64>() <= 0.0;
        if solved.is_err() || !length.is_finite() || (uphill && mu < 1e12 * natural) {
            mu = if mu == 0.0 { 1e-3 * natural } else { 8.0 * mu };
            continue;
        }
        // A step that counts as converged is taken whole: rounding of stiff springs can shrink the trust
        // length to nothing there.
        let shortening = if length > trust && length > control.tolerance { trust / length } else { 1.0 };
        for i in 0..n {
            trial[i] = position[i] + shortening * step[i];
        }
        let trial_balance = evaluate(&trial, &mut trial_force, &mut trial_lin);
        let trial_size = work(&trial_force);
        // In a clearance the force stays as it is; deep in a contact that was jumped into it grows. Work done
        // against the new force says whether the step went past the balance.
        let overshoot = trial_force.iter().zip(&step).map(|(f, x)| f * x).sum::<f64>()
            < -0.5 * force.iter().zip(&step).map(|(f, x)| f * x).sum::<f64>();
        // Where a contact sets in, the stiffness jumps, and full steps could go to and fro across that place
        // for ever.
        let to_and_fro = overshoot && trial_size > 0.9 * size && length > control.tolerance;
        let accepted = (trial_size <= 1.000_001 * size && !to_and_fro)
            || (!overshoot && trial_size < 2.0 * size && length > control.tolerance);
        let converged = shortening == 1.0 && length <= control.tolerance && mu * natural.recip() < 1e-3;
        if accepted || (converged && trial_size.is_finite()) {
            std::mem::swap(&mut position, &mut trial);
            std::mem::swap(&mut force, &mut trial_force);
            std::mem::swap(&mut lin, &mut trial_lin);
            balance = trial_balance;
            if converged {
                return Ok(Equilibrium { residual: largest(&force), position, iterations: iteration + 1 });
            }
            mu *= (trial_size / size).clamp(0.0, 0.5);
            if mu < 1e-9 * natural {
                mu = 0.0;
            }
            trust = (2.0 * trust).min(control.trust);
        } else {
            trust = 0.25 * length.min(trust);
            if trust < control.tolerance && length < NEAR_JUMP && size <= jump {
                return Ok(Equilibrium { residual: largest(&force), position, iterations: iteration + 1 });
            }
            mu = match mu {
                // One body that hangs nearly free makes the Newton step long for all: the mass term holds it
                // back alone.
                0.0 if length > trust => 1e-3 * natural,
                mu => 2.0 * mu,
            };
        }
    }
    Err(DynamicsError::NoEquilibrium {
        time,
        crank_angle_deg: system.crank_angle(&position) / crate::units::DEG,
        residual: largest(&force),
        iterations: control.largest_iteration_count,
    })
}
