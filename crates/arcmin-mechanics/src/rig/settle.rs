use super::RigError;
use crate::dynamics::mechanism::Mechanism;
use crate::dynamics::{
    BearingJoints, EquilibriumControl, Motion, QuasiStatic, System, continue_from_larger_loads,
    solve_equilibrium,
};
use crate::load::LOST_MOTION_SHARE;

/// Sliding in m within one step below which the regularised friction force still increases (presliding). In
/// real contacts presliding is some tenths of a micrometre.
const PRESLIDING: f64 = 2e-8;
/// Tolerance of the output angle in arcmin (and of all other coordinates likewise): far below the 1e-4' that
/// results state.
const TOLERANCE: f64 = 1e-6;

/// Tolerance of the residual in N or N·m. Angles of many turns (shaft 40 rad, sun 500 rad) have a rounding
/// error of 1e-14 rad and more; times radius and stiffness of all contacts this is about 1e-6. At the output
/// the tolerance is below 1e-5'.
const FORCE_TOLERANCE: f64 = 2e-5;

/// Tolerances of a machine with bearings.
pub(super) const CONTROL: EquilibriumControl =
    EquilibriumControl { tolerance: TOLERANCE, force_tolerance: FORCE_TOLERANCE, held: None };

/// The equilibrium of one motion near `start`; if none is found from there, by continuation from larger
/// torques.
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
        continue_from_larger_loads(mechanism.constant_load(), rated, |load, place| {
            loaded.set_load(load);
            solve(&loaded, place.unwrap_or(start))
        })
        .map_err(|_: RigError| failure)
    })
}

/// Equilibrium after a slow change of load from the equilibrium `from`; friction opposes the change.
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

/// If the load changes further in the same direction, by at most this many times the last change, the
/// displacement is extrapolated linearly; the result is accepted if it deviates from the extrapolation by at
/// most `LARGEST_DEVIATION` times the extrapolated displacement.
const CONTINUATION_LIMIT: f64 = 10.0;
const LARGEST_DEVIATION: f64 = 1.0;

/// A machine under a slowly changing load, as a sequence of equilibria; friction makes them depend on the path.
pub(super) struct SlowLoad {
    pub model: Mechanism,
    /// Rated torque in N·m.
    rated: f64,
    control: EquilibriumControl,
    regularisation_speed: f64,
    pub place: Vec<f64>,
    /// The last change of the load (N·m) and of the position.
    last: (f64, Vec<f64>),
}

impl SlowLoad {
    /// A machine, its rated torque (N·m) and the tolerances of its equilibria, starting at or near an
    /// equilibrium.
    pub fn new(
        (model, rated, control): (Mechanism, f64, EquilibriumControl),
        regularisation_speed: f64,
        place: Vec<f64>,
    ) -> SlowLoad {
        SlowLoad { last: (0.0, vec![0.0; place.len()]), model, rated, control, regularisation_speed, place }
    }

    /// Time in s by which displacements are divided to get the speeds in the friction law.
    pub fn interval(&self) -> f64 {
        PRESLIDING / self.regularisation_speed
    }

    /// The equilibrium near `start` after a slow change of load from the present position.
    fn balance(&self, start: &[f64]) -> Result<Vec<f64>, RigError> {
        let (from, interval) = (&self.place, self.interval());
        settle((&self.model, self.rated, self.control), start, || Motion::Creeping { from, interval })
    }

    /// Changes the load to `torque` (N·m), in smaller steps where one step does not converge.
    pub fn change_to(&mut self, torque: f64) -> Result<(), RigError> {
        let before = self.model.constant_load();
        let (mut reached, mut step) = (0.0, 1.0_f64);
        while reached < 1.0 {
            // Sums of halves have no rounding error: the last step ends exactly at the torque.
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

    /// The equilibrium under a new load, starting from the present one. While the load changes in the same
    /// direction, the search starts at the linear extrapolation; not within the torques of the lost motion,
    /// where bodies cross their clearances.
    fn step_to(&mut self, torque: f64) -> Result<(), RigError> {
        let before = self.model.constant_load();
        self.model.set_load(torque);
        let from = &self.place;
        let share = (torque - before) / self.last.0;
        let pressed = LOST_MOTION_SHARE * self.rated * torque.signum();
        let presses = [before - self.last.0, torque].iter().all(|load| load / pressed >= 1.0);
        let continues =
            (presses && share > 0.0 && share <= CONTINUATION_LIMIT).then(|| -> Option<Vec<f64>> {
                let ahead: Vec<f64> =
                    from.iter().zip(&self.last.1).map(|(q, change)| q + share * change).collect();
                let found = self.balance(&ahead).ok()?;
                // Bodies within their clearances have several equilibria; one near the extrapolation is on the
                // path.
                let distance = |a: &[f64], b: &[f64]| {
                    let differences = a.iter().zip(b).zip(self.model.scale());
                    differences.fold(0.0, |most: f64, ((a, b), scale)| most.max((a - b).abs() / scale))
                };
                (distance(&found, &ahead) <= LARGEST_DEVIATION * distance(&ahead, from)).then_some(found)
            });
        let found = match continues.flatten() {
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

/// Equilibrium in steady running with the given velocities, near `start`.
pub(super) fn run(model: &BearingJoints, start: &[f64], velocity: Vec<f64>) -> Result<Vec<f64>, RigError> {
    settle((model, model.rated_torque(), CONTROL), start, || Motion::Running(velocity.clone()))
}

/// dq/dT per unit of applied torque at the output: the tangent displacement of the whole machine without
/// friction.
pub(super) fn tangent(model: &Mechanism, position: &[f64]) -> Result<Vec<f64>, RigError> {
    model.motion_per_torque(position).ok_or(RigError::Loose)
}
