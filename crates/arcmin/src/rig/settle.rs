use super::RigError;
use crate::dynamics::{
    Balance, BearingJoints, DenseLinearisation, EquilibriumControl, System, solve_equilibrium,
};

/// What the friction sees while the machine is in balance without inertia.
enum Motion<'a> {
    /// Velocities as given: steady running.
    Running(Vec<f64>),
    /// (q − q_before)/Δt: a slow change of load from the state before.
    Creeping { from: &'a [f64], interval: f64 },
}

/// The model without inertia, moving slowly.
struct Slow<'a> {
    model: &'a BearingJoints,
    motion: Motion<'a>,
}

/// Sliding in m within one step below which regularised friction still grows. Real contacts give way by some
/// tenths of a micrometre before they slide.
const PRESLIDING: f64 = 2e-8;
/// Accuracy of the output angle in arcmin (and of all other coordinates likewise): far below the 1e-4' that
/// anybody reads.
const TOLERANCE: f64 = 1e-7;

/// In N or N·m. Angles of many turns (shaft 40 rad, sun 500 rad) are rounded to 1e-14 rad and more, which
/// times radius and stiffness of all contacts leaves some 1e-6 where bodies just touch. At the output this is
/// below 1e-5'.
const FORCE_TOLERANCE: f64 = 2e-5;

impl System for Slow<'_> {
    type Linearisation = DenseLinearisation;

    fn linearisation(&self) -> DenseLinearisation {
        self.model.linearisation()
    }

    fn mass(&self) -> &[f64] {
        self.model.mass()
    }

    fn scale(&self) -> &[f64] {
        self.model.scale()
    }

    fn evaluate(
        &self,
        time: f64,
        position: &[f64],
        _: &[f64],
        force: &mut [f64],
        linearisation: &mut DenseLinearisation,
    ) -> Balance {
        match &self.motion {
            Motion::Running(velocity) => self.model.evaluate(time, position, velocity, force, linearisation),
            Motion::Creeping { from, interval } => {
                let velocity: Vec<f64> =
                    position.iter().zip(*from).map(|(q, q0)| (q - q0) / interval).collect();
                let balance = self.model.evaluate(time, position, &velocity, force, linearisation);
                linearisation.fold_damping(1.0 / interval);
                balance
            }
        }
    }

    fn crank_angle(&self, position: &[f64]) -> f64 {
        self.model.crank_angle(position)
    }
}

fn control() -> EquilibriumControl {
    EquilibriumControl {
        tolerance: TOLERANCE,
        force_tolerance: FORCE_TOLERANCE,
        ..EquilibriumControl::default()
    }
}

/// Larger torques by way of which a balance is sought, largest first: more contacts hold the bodies there.
const LARGER: [f64; 4] = [30.0, 10.0, 4.0, 2.0];
/// Shares of the friction by way of which it is brought in.
const FRICTION: [f64; 5] = [0.0, 0.1, 0.3, 0.6, 1.0];

/// The balance of one motion near `start`. Where it is not found at once, the frictionless machine is solved
/// first, whose forces derive from an energy, by way of larger torques if need be; then friction comes in by
/// and by.
fn settle<'a>(
    model: &BearingJoints,
    start: &[f64],
    motion: impl Fn() -> Motion<'a>,
) -> Result<Vec<f64>, RigError> {
    let solve = |model: &BearingJoints, start: &[f64]| {
        Ok::<_, RigError>(
            solve_equilibrium(&Slow { model, motion: motion() }, 0.0, start, control())?.position,
        )
    };
    let failure = match solve(model, start) {
        Ok(found) => return Ok(found),
        Err(failure) => failure,
    };
    let smooth = model.with_friction(FRICTION[0]);
    let mut place = match solve(&smooth, start) {
        Ok(place) => place,
        Err(_) => {
            let torque = model.constant_load();
            let mut larger = smooth.clone();
            let mut place = start.to_vec();
            for factor in LARGER {
                larger.set_load(factor * torque);
                // A step that fails is left out.
                place = solve(&larger, &place).unwrap_or(place);
            }
            solve(&smooth, &place).map_err(|_| failure.clone())?
        }
    };
    for share in &FRICTION[1..] {
        place = solve(&model.with_friction(*share), &place).map_err(|_| failure.clone())?;
    }
    Ok(place)
}

/// Balance after a slow change of load from the balance `from`; friction opposes the change.
pub(super) fn creep(
    model: &BearingJoints,
    regularisation_speed: f64,
    from: &[f64],
) -> Result<Vec<f64>, RigError> {
    let interval = PRESLIDING / regularisation_speed;
    settle(model, from, || Motion::Creeping { from, interval })
}

/// Smallest step of the load as a share of the step asked for.
const SMALLEST_STEP: f64 = 1.0 / 64.0;

/// Balance after the load has gone slowly from what it is to `torque` (N·m), from the balance `from`. Friction
/// remembers the way: where one step leads to no balance, the load goes there in smaller ones.
pub(super) fn load_slowly(
    model: &mut BearingJoints,
    regularisation_speed: f64,
    from: &[f64],
    torque: f64,
) -> Result<Vec<f64>, RigError> {
    let before = model.constant_load();
    let mut place = from.to_vec();
    let (mut reached, mut step) = (0.0, 1.0_f64);
    while reached < 1.0 {
        // Halves add up without rounding: the last step ends at the torque itself.
        model.set_load(if reached + step == 1.0 {
            torque
        } else {
            before + (reached + step) * (torque - before)
        });
        match creep(model, regularisation_speed, &place) {
            Ok(found) => (place, reached) = (found, reached + step),
            Err(_) if step > SMALLEST_STEP => step *= 0.5,
            Err(failure) => return Err(failure),
        }
    }
    Ok(place)
}

/// Balance in steady running with the given velocities, near `start`.
pub(super) fn run(model: &BearingJoints, start: &[f64], velocity: Vec<f64>) -> Result<Vec<f64>, RigError> {
    settle(model, start, || Motion::Running(velocity.clone()))
}

/// dq/dT per unit of applied torque at the output: the tangent motion of the whole machine, friction left
/// aside.
pub(super) fn tangent(model: &BearingJoints, position: &[f64]) -> Result<Vec<f64>, RigError> {
    model.motion_per_torque(position).ok_or(RigError::Loose)
}
