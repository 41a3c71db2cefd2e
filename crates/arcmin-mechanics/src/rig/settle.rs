use super::RigError;
use crate::dynamics::mechanism::Mechanism;
use crate::dynamics::{
    BearingJoints, EquilibriumControl, Motion, QuasiStatic, System, by_larger_loads, solve_equilibrium,
};
use crate::load::LOST_MOTION_SHARE;

/// Sliding in m within one step below which regularised friction still grows. Real contacts give way by some
/// tenths of a micrometre before they slide.
const PRESLIDING: f64 = 2e-8;
/// Accuracy of the output angle in arcmin (and of all other coordinates likewise): far below the 1e-4' that
/// anybody reads.
const TOLERANCE: f64 = 1e-6;

/// In N or N·m. Angles of many turns (shaft 40 rad, sun 500 rad) are rounded to 1e-14 rad and more, which
/// times radius and stiffness of all contacts leaves some 1e-6 where bodies just touch. At the output this is
/// below 1e-5'.
const FORCE_TOLERANCE: f64 = 2e-5;

/// Of a machine with bearings.
pub(super) const CONTROL: EquilibriumControl =
    EquilibriumControl { tolerance: TOLERANCE, force_tolerance: FORCE_TOLERANCE, held: None };

/// The balance of one motion near `start`; where none is found from there, by way of larger torques.
fn settle<'a>(
    (mechanism, rated, control): (&Mechanism, f64, EquilibriumControl),
    start: &[f64],
    motion: impl Fn() -> Motion<'a>,
) -> Result<Vec<f64>, RigError> {
    let solve = |mechanism: &Mechanism, start: &[f64]| -> Result<Vec<f64>, RigError> {
        let system = QuasiStatic { mechanism, motion: motion() };
        Ok(solve_equilibrium(&system, 0.0, start, control)?.position)
    };
    solve(mechanism, start).or_else(|failure| {
        let mut loaded = mechanism.clone();
        by_larger_loads(mechanism.constant_load(), rated, |load, place| {
            loaded.set_load(load);
            solve(&loaded, place.unwrap_or(start))
        })
        .map_err(|_: RigError| failure)
    })
}

/// Balance after a slow change of load from the balance `from`; friction opposes the change.
pub(super) fn creep(
    model: &BearingJoints,
    regularisation_speed: f64,
    from: &[f64],
) -> Result<Vec<f64>, RigError> {
    let interval = PRESLIDING / regularisation_speed;
    settle((model, model.rated_torque(), CONTROL), from, || Motion::Creeping { from, interval })
}

/// Smallest step of the load as a share of the full step.
const SMALLEST_STEP: f64 = 1.0 / 64.0;

/// A load that goes on as before, by at most so many times the last change, leads where the machine was going, to this
/// share of the way.
const GOES_ON: f64 = 10.0;
const FORETOLD: f64 = 1.0;

/// A machine whose load changes slowly, from balance to balance. Friction remembers the way.
pub(super) struct SlowLoad {
    pub model: Mechanism,
    /// N·m.
    rated: f64,
    control: EquilibriumControl,
    regularisation_speed: f64,
    pub place: Vec<f64>,
    /// The last change of the load (N·m) and of the place.
    last: (f64, Vec<f64>),
}

impl SlowLoad {
    /// A machine, its rated torque (N·m) and how exact its balances are, from a balance, or a place near one.
    pub fn new(
        (model, rated, control): (Mechanism, f64, EquilibriumControl),
        regularisation_speed: f64,
        place: Vec<f64>,
    ) -> SlowLoad {
        SlowLoad { last: (0.0, vec![0.0; place.len()]), model, rated, control, regularisation_speed, place }
    }

    /// Time in s over which displacements make the velocities that friction sees.
    pub fn interval(&self) -> f64 {
        PRESLIDING / self.regularisation_speed
    }

    /// The balance near `start` after a slow change of load from the present place.
    fn balance(&self, start: &[f64]) -> Result<Vec<f64>, RigError> {
        let (from, interval) = (&self.place, self.interval());
        settle((&self.model, self.rated, self.control), start, || Motion::Creeping { from, interval })
    }

    /// The load goes to `torque` (N·m); where one step leads to no balance, in smaller ones.
    pub fn change_to(&mut self, torque: f64) -> Result<(), RigError> {
        let before = self.model.constant_load();
        let (mut reached, mut step) = (0.0, 1.0_f64);
        while reached < 1.0 {
            // Halves add up without rounding: the last step ends at the torque itself.
            let next =
                if reached + step == 1.0 { torque } else { before + (reached + step) * (torque - before) };
            match self.step_to(next) {
                Ok(()) => reached += step,
                Err(_) if step > SMALLEST_STEP => step *= 0.5,
                Err(failure) => return Err(failure),
            }
        }
        Ok(())
    }

    /// The balance under a load from the present one. As long as the load goes on as before, so at first sight does the
    /// machine, beyond the torques of the lost motion, under which bodies cross their clearances.
    fn step_to(&mut self, torque: f64) -> Result<(), RigError> {
        let before = self.model.constant_load();
        self.model.set_load(torque);
        let from = &self.place;
        let share = (torque - before) / self.last.0;
        let pressed = LOST_MOTION_SHARE * self.rated * torque.signum();
        let presses = [before - self.last.0, torque].iter().all(|load| load / pressed >= 1.0);
        let goes_on = (presses && share > 0.0 && share <= GOES_ON).then(|| -> Option<Vec<f64>> {
            let ahead: Vec<f64> = from.iter().zip(&self.last.1).map(|(q, way)| q + share * way).collect();
            let found = self.balance(&ahead).ok()?;
            // Bodies that hang in their clearances have several balances: the one that is reached lies on the way.
            let way = |a: &[f64], b: &[f64]| {
                let ways = a.iter().zip(b).zip(self.model.scale());
                ways.fold(0.0, |most: f64, ((a, b), scale)| most.max((a - b).abs() / scale))
            };
            (way(&found, &ahead) <= FORETOLD * way(&ahead, from)).then_some(found)
        });
        let found = match goes_on.flatten() {
            Some(found) => found,
            None => match self.balance(from) {
                Ok(found) => found,
                Err(failure) => {
                    self.model.set_load(before);
                    return Err(failure);
                }
            },
        };
        self.last = (torque - before, found.iter().zip(from).map(|(q, q0)| q - q0).collect());
        self.place = found;
        Ok(())
    }
}

/// Balance in steady running with the given velocities, near `start`.
pub(super) fn run(model: &BearingJoints, start: &[f64], velocity: Vec<f64>) -> Result<Vec<f64>, RigError> {
    settle((model, model.rated_torque(), CONTROL), start, || Motion::Running(velocity.clone()))
}

/// dq/dT per unit of applied torque at the output: the tangent motion of the whole machine, friction left
/// aside.
pub(super) fn tangent(model: &Mechanism, position: &[f64]) -> Result<Vec<f64>, RigError> {
    model.motion_per_torque(position).ok_or(RigError::Loose)
}
