mod dense;
mod evaluation;

pub use dense::DenseLinearisation;
pub use evaluation::{Columns, Contact, Contacts, ElasticCoordinates, Evaluation, FlankPlace, RoundSupport};
use serde::{Deserialize, Serialize};

/// A mechanical system in second-order form, M q̈ = Q(q, q̇, t) with a constant diagonal mass matrix M.
///
/// All force laws of a model are behind this trait; the time [`Integrator`](super::Integrator) and the static
/// solver ([`solve_equilibrium`](super::statics::solve_equilibrium), q̇ = 0) use the same ones. Coordinates may
/// be in metres and radians.
pub trait System {
    /// A linearisation of the right size, zero.
    fn linearisation(&self) -> DenseLinearisation;

    /// One for a static search, which does not need damping; systems may omit it.
    fn linearisation_at_rest(&self) -> DenseLinearisation {
        self.linearisation()
    }

    /// Diagonal of M in kg or kg·m², one entry per coordinate.
    fn mass(&self) -> &[f64];

    /// Change of each coordinate (m or rad) that counts as one unit of error; unit of tolerances.
    fn scale(&self) -> &[f64];

    /// Generalised forces Q (N or N·m) at time t (s), positions q and velocities v, with their linearisation
    /// and powers.
    fn evaluate(
        &self,
        time: f64,
        position: &[f64],
        velocity: &[f64],
        force: &mut [f64],
        linearisation: &mut DenseLinearisation,
    ) -> Balance;

    /// The forces alone, for a search with a sufficiently accurate tangent; the balance is that of
    /// [`System::evaluate`].
    fn evaluate_forces(&self, time: f64, position: &[f64], velocity: &[f64], force: &mut [f64]) -> Balance {
        self.evaluate(time, position, velocity, force, &mut self.linearisation_at_rest())
    }

    /// Forces, tangent and single contacts at rest at one position, as needed by the static solver. The default
    /// is a system without contacts.
    fn evaluate_statics(&self, time: f64, position: &[f64], _reach: f64, evaluation: &mut Evaluation) {
        evaluation.contacts.clear();
        let (rest, mut tangent) = (vec![0.0; position.len()], self.linearisation_at_rest());
        self.evaluate(time, position, &rest, &mut evaluation.force, &mut tangent);
        evaluation.smooth.take_rows(&tangent, evaluation.columns.searched());
    }

    /// Coordinates that have a constant stiffness of their own and interact with others only through contacts,
    /// if any.
    fn elastic(&self) -> Option<&ElasticCoordinates> {
        None
    }

    /// Displacement (m) of one contact on an elastic flank against another one's force (N) on it, in m/N.
    fn flank_compliance(&self, _of: &FlankPlace, _force: &FlankPlace) -> f64 {
        0.0
    }

    /// The first time after `time` at which the prescribed motion or load has a jump or a kink, where steps
    /// end.
    fn next_breakpoint(&self, _time: f64) -> Option<f64> {
        None
    }

    /// Angle of the crankshafts in rad, for error messages.
    fn crank_angle(&self, position: &[f64]) -> f64;

    /// Number of coordinates q.
    fn size(&self) -> usize {
        self.mass().len()
    }
}

/// Factors of mass, damping and stiffness in the matrix of an implicit step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Weights {
    /// Factor of M.
    pub mass: f64,
    /// Factor of −∂Q/∂q̇.
    pub damping: f64,
    /// Factor of −∂Q/∂q.
    pub stiffness: f64,
}

/// The matrix is singular.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("singular matrix")]
pub struct Singular;

/// Powers, stored energy and torques at the flanges at one state, for the energy balance.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Balance {
    /// Power supplied by the drive in W.
    pub input_power: f64,
    /// Power delivered to the load in W.
    pub load_power: f64,
    /// Power lost in dampers and friction in W, never negative.
    pub dissipation: f64,
    /// Elastic energy in J.
    pub stored: f64,
    /// Torque of the drive at the input, in N·m.
    pub input_torque: f64,
    /// Torque transmitted by the output, in N·m; positive against positive motion.
    pub load_torque: f64,
    /// 1/s: the largest ratio of closing speed to gap (plus a tolerable depth) of open contacts. The step is
    /// kept below its inverse, so that no contact closes by more than the tolerable penetration within one
    /// step. 0 if no contact is closing.
    pub onset_rate: f64,
}
