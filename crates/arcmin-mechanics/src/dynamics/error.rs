use crate::load::LoadError;
use crate::machine::CrankAngle;

/// Reasons why a motion or an equilibrium could not be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DynamicsError {
    /// The implicit step did not converge or meet the tolerance even at the smallest allowed size.
    #[error(
        "the step at t = {time:.9} s (crank angle {crank_angle_deg:.4}°) does not converge: step {step:.3e} s, residual {residual:.3e} \
         (largest force imbalance in N or N·m) after {steps} accepted steps"
    )]
    StepFailed {
        /// Time at the beginning of the step, s.
        time: f64,
        /// Crank angle there, degrees.
        crank_angle_deg: f64,
        /// Last step size tried, s.
        step: f64,
        /// Largest residual force (N) or torque (N·m).
        residual: f64,
        /// Steps accepted before.
        steps: usize,
    },
    /// No static equilibrium was found.
    #[error(
        "no static equilibrium at t = {time:.9} s (crank angle {crank_angle_deg:.4}°): residual {residual:.3e} (largest force imbalance in N or N·m) \
         after {iterations} iterations"
    )]
    NoEquilibrium {
        /// Time at which drives and loads are evaluated, s.
        time: f64,
        /// Crank angle, degrees.
        crank_angle_deg: f64,
        /// Largest residual force (N) or torque (N·m).
        residual: f64,
        /// Iterations done.
        iterations: usize,
    },
    /// A value outside of its range.
    #[error("{name} = {value} {unit}: {requirement}")]
    InvalidValue {
        /// Quantity, in words for the message.
        name: &'static str,
        /// Value given, in `unit`.
        value: f64,
        /// Unit of the value; empty for numbers without one.
        unit: &'static str,
        /// Condition that it violates, in words for the message.
        requirement: &'static str,
    },
    /// A time table whose times do not increase.
    #[error("{table}: time {time} s in row {row} is not later than {previous} s in the row before")]
    TableRunsBackwards {
        /// Table, in words for the message.
        table: &'static str,
        /// Row as counted in an editor, the header being row 1.
        row: usize,
        /// Time in this row, s.
        time: f64,
        /// Time in the previous row, s.
        previous: f64,
    },
    /// A time table without rows, or with values that are not finite.
    #[error("{table}: {message}")]
    BadTable {
        /// Table, in words for the message.
        table: &'static str,
        /// Fault, in words for the message.
        message: &'static str,
    },
    /// Mesh, modes or reduction of an elastic body failed.
    #[error("elastic disc: {0}")]
    ElasticDisc(#[from] crate::fem::FemError),
    /// The caller stopped the simulation.
    #[error("the simulation was stopped at t = {time:.6} s")]
    Cancelled {
        /// Time reached, s.
        time: f64,
    },
    /// An external input that is not valid for this model.
    #[error("this input cannot be set: {reason}")]
    WrongInput {
        /// Reason, in words for the message.
        reason: &'static str,
    },
    /// A checkpoint that belongs to another model.
    #[error("the checkpoint does not fit this run: {reason}")]
    ForeignCheckpoint {
        /// Difference between the two, in words for the message.
        reason: &'static str,
    },
}

impl DynamicsError {
    /// The failed search for a static equilibrium, as the error of a load sharing at a crank angle under a torque (N·m).
    pub(super) fn of_load_sharing(self, crank: CrankAngle, torque: f64) -> LoadError {
        let (residual, iterations) = match self {
            DynamicsError::NoEquilibrium { residual, iterations, .. } => (residual, iterations),
            // The static solver has no other error.
            _ => (f64::NAN, 0),
        };
        LoadError::NotConverged { crank_angle_deg: crank.degrees(), torque, residual, iterations }
    }

    pub(crate) fn require(
        holds: bool,
        name: &'static str,
        value: f64,
        unit: &'static str,
        requirement: &'static str,
    ) -> Result<(), DynamicsError> {
        // A comparison with NaN is false, so NaN never passes.
        if holds { Ok(()) } else { Err(DynamicsError::InvalidValue { name, value, unit, requirement }) }
    }
}
