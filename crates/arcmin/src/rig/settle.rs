use std::borrow::Cow;

use super::RigError;
use crate::dynamics::{
    Balance, BearingJoints, DenseLinearisation, EquilibriumControl, Gap, JUMP, System, solve_equilibrium,
};
use crate::load::LOST_MOTION_SHARE;
use crate::units::ARCMIN;

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

impl Slow<'_> {
    fn velocity(&self, position: &[f64]) -> Cow<'_, [f64]> {
        match &self.motion {
            Motion::Running(velocity) => Cow::Borrowed(velocity),
            Motion::Creeping { from, interval } => {
                position.iter().zip(*from).map(|(q, q0)| (q - q0) / interval).collect()
            }
        }
    }
}

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

impl System for Slow<'_> {
    type Linearisation = DenseLinearisation;

    fn linearisation(&self) -> DenseLinearisation {
        self.model.linearisation()
    }

    fn linearisation_at_rest(&self) -> DenseLinearisation {
        match self.motion {
            Motion::Running(_) => self.model.linearisation_at_rest(),
            // Velocities follow the coordinates.
            Motion::Creeping { .. } => self.linearisation(),
        }
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
        let balance = self.model.evaluate(time, position, &self.velocity(position), force, linearisation);
        if let Motion::Creeping { interval, .. } = self.motion {
            linearisation.fold_damping(1.0 / interval);
        }
        balance
    }

    fn evaluate_forces(&self, time: f64, position: &[f64], _: &[f64], force: &mut [f64]) -> Balance {
        self.model.evaluate_forces(time, position, &self.velocity(position), force)
    }

    fn gaps(&self, time: f64, position: &[f64], reach: f64, see: &mut dyn FnMut(&Gap<'_>)) {
        self.model.gaps(time, position, reach, see);
    }

    fn crank_angle(&self, position: &[f64]) -> f64 {
        self.model.crank_angle(position)
    }
}

/// What a balance must meet; `jump` is the share of the rated torque that a jump may leave.
fn control(model: &BearingJoints, jump: f64) -> EquilibriumControl {
    EquilibriumControl {
        tolerance: TOLERANCE,
        force_tolerance: FORCE_TOLERANCE,
        jump_tolerance: jump * model.rated_torque() * ARCMIN,
        ..EquilibriumControl::default()
    }
}

/// Shares of the friction by way of which it is brought in.
const FRICTION: [f64; 5] = [0.0, 0.1, 0.3, 0.6, 1.0];
/// Share of the rated torque that is as good as none.
const NO_LOAD: f64 = 2e-3;
/// From a larger torque to the next, at first and at least.
const FALL: (f64, f64) = (3.0, 1.1);

/// The balance of one motion near `start`; where none is found that is met exactly, one at which contact forces
/// jump.
fn settle<'a>(
    model: &BearingJoints,
    start: &[f64],
    motion: impl Fn() -> Motion<'a>,
) -> Result<Vec<f64>, RigError> {
    let within = |jump| Settling { motion: &motion, jump }.settle(model, start);
    within(0.0).or_else(|failure| within(JUMP).map_err(|_| failure))
}

/// A search for a balance.
struct Settling<'m, M> {
    motion: &'m M,
    /// Share of the rated torque that a jump may leave.
    jump: f64,
}

impl<'a, M: Fn() -> Motion<'a>> Settling<'_, M> {
    fn solve(&self, model: &BearingJoints, start: &[f64]) -> Result<Vec<f64>, RigError> {
        let slow = Slow { model, motion: (self.motion)() };
        // Places of a turn that follow each other lie far apart; loads that change slowly do not.
        let from_afar = matches!(slow.motion, Motion::Running(_));
        let control = EquilibriumControl { from_afar, ..control(model, self.jump) };
        Ok(solve_equilibrium(&slow, 0.0, start, control)?.position)
    }

    /// Where the balance is not found at once, the frictionless machine is solved first, whose forces derive from an
    /// energy; then friction comes in by and by. Where that leads nowhere either, by way of larger torques, under
    /// which more contacts hold the bodies. Bodies that hardly anything presses may hang by friction so that nothing
    /// balances them: then the balance under the least torque that leaves one, if that is as good as none.
    fn settle(&self, model: &BearingJoints, start: &[f64]) -> Result<Vec<f64>, RigError> {
        let failure = match self.solve(model, start) {
            Ok(found) => return Ok(found),
            Err(failure) => failure,
        };
        let smooth = model.with_friction(FRICTION[0]);
        self.solve(&smooth, start)
            .or_else(|_| self.by_larger_torques(&smooth, start))
            .and_then(|place| {
                let mut rougher = FRICTION[1..].iter().map(|share| model.with_friction(*share));
                rougher.try_fold(place, |place, model| self.solve(&model, &place))
            })
            .or_else(|_| self.by_larger_torques(model, start))
            .map_err(|_| failure)
    }

    /// From the balance under rated torque down to the one that is asked for.
    fn by_larger_torques(&self, model: &BearingJoints, start: &[f64]) -> Result<Vec<f64>, RigError> {
        let torque = model.constant_load();
        let mut larger = model.clone();
        let mut load = model.rated_torque().max(FALL.0 * torque.abs());
        larger.set_load(load.copysign(torque));
        let mut place = self.solve(&larger, start)?;
        let mut fall = FALL.0;
        while load > torque.abs() {
            let next = (load / fall).max(torque.abs());
            larger.set_load(next.copysign(torque));
            match self.solve(&larger, &place) {
                Ok(found) => (place, load) = (found, next),
                Err(_) if fall > FALL.1 => fall = fall.sqrt(),
                Err(_) if load <= NO_LOAD * model.rated_torque() => return Ok(place),
                Err(failure) => return Err(failure),
            }
            // At no load the way down would not end.
            if next <= 1e-9 * model.rated_torque() {
                break;
            }
        }
        Ok(place)
    }
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

/// A load that goes on as before, by at most so many times the last change, leads where the machine was going, to this
/// share of the way.
const GOES_ON: f64 = 10.0;
const FORETOLD: f64 = 1.0;

/// A machine whose load changes slowly, from balance to balance. Friction remembers the way.
pub(super) struct SlowLoad {
    pub model: BearingJoints,
    regularisation_speed: f64,
    pub place: Vec<f64>,
    /// The last change of the load (N·m) and of the place.
    last: (f64, Vec<f64>),
}

impl SlowLoad {
    /// From a balance, or a place near one.
    pub fn new(model: BearingJoints, regularisation_speed: f64, place: Vec<f64>) -> SlowLoad {
        SlowLoad { last: (0.0, vec![0.0; place.len()]), model, regularisation_speed, place }
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
        let (from, interval) = (&self.place, PRESLIDING / self.regularisation_speed);
        let share = (torque - before) / self.last.0;
        let pressed = LOST_MOTION_SHARE * self.model.rated_torque() * torque.signum();
        let presses = [before - self.last.0, torque].iter().all(|load| load / pressed >= 1.0);
        let goes_on = (presses && share > 0.0 && share <= GOES_ON).then(|| -> Option<Vec<f64>> {
            let ahead: Vec<f64> = from.iter().zip(&self.last.1).map(|(q, way)| q + share * way).collect();
            let motion = || Motion::Creeping { from, interval };
            let found = Settling { motion: &motion, jump: 0.0 }.solve(&self.model, &ahead).ok()?;
            // Bodies that hang in their clearances have several balances: the one that is reached lies on the way.
            let way = |a: &[f64], b: &[f64]| {
                let ways = a.iter().zip(b).zip(self.model.scale());
                ways.fold(0.0, |most: f64, ((a, b), scale)| most.max((a - b).abs() / scale))
            };
            (way(&found, &ahead) <= FORETOLD * way(&ahead, from)).then_some(found)
        });
        let found = match goes_on.flatten() {
            Some(found) => found,
            None => match creep(&self.model, self.regularisation_speed, from) {
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
    settle(model, start, || Motion::Running(velocity.clone()))
}

/// dq/dT per unit of applied torque at the output: the tangent motion of the whole machine, friction left
/// aside.
pub(super) fn tangent(model: &BearingJoints, position: &[f64]) -> Result<Vec<f64>, RigError> {
    model.motion_per_torque(position).ok_or(RigError::Loose)
}
