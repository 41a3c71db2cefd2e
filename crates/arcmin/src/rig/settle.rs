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

/// Balance after a slow change of load from the balance `from`; friction opposes the change.
pub(super) fn creep(
    model: &BearingJoints,
    regularisation_speed: f64,
    from: &[f64],
) -> Result<Vec<f64>, RigError> {
    let motion = Motion::Creeping { from, interval: PRESLIDING / regularisation_speed };
    Ok(solve_equilibrium(&Slow { model, motion }, 0.0, from, control())?.position)
}

/// Balance in steady running with the given velocities, near `start`.
pub(super) fn run(model: &BearingJoints, start: &[f64], velocity: Vec<f64>) -> Result<Vec<f64>, RigError> {
    Ok(solve_equilibrium(&Slow { model, motion: Motion::Running(velocity) }, 0.0, start, control())?.position)
}

/// dq/dT per unit of applied torque at the output: the tangent motion of the whole machine, friction left
/// aside.
pub(super) fn tangent(model: &BearingJoints, position: &[f64]) -> Result<Vec<f64>, RigError> {
    model.motion_per_torque(position).ok_or(RigError::Loose)
}
