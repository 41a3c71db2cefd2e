/// Why a motion or an equilibrium could not be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DynamicsError {
    /// The implicit step was halved down to the smallest allowed one and still did not converge or meet the
    /// tolerance.
    #[error(
        "the step at t = {time:.9} s (crank angle {crank_angle_deg:.4}°) does not converge: step {step:.3e} s, residual {residual:.3e} \
         (largest force imbalance in N or N·m) after {steps} accepted steps"
    )]
    StepFailed { time: f64, crank_angle_deg: f64, step: f64, residual: f64, steps: usize },
    /// No state of rest was found.
    #[error(
        "no static equilibrium at t = {time:.9} s (crank angle {crank_angle_deg:.4}°): residual {residual:.3e} (largest force imbalance in N or N·m) \
         after {iterations} iterations"
    )]
    NoEquilibrium { time: f64, crank_angle_deg: f64, residual: f64, iterations: usize },
    /// A number that has no meaning in its place.
    #[error("{name} = {value} {unit}: {requirement}")]
    InvalidValue { name: &'static str, value: f64, unit: &'static str, requirement: &'static str },
    /// A time table whose times do not rise.
    #[error("{table}: time {time} s in row {row} is not later than {previous} s in the row before")]
    TableRunsBackwards { table: &'static str, row: usize, time: f64, previous: f64 },
    #[error("{table}: {message}")]
    BadTable { table: &'static str, message: &'static str },
    #[error("elastic disc: {0}")]
    ElasticDisc(#[from] crate::fem::FemError),
    #[error("the simulation was stopped at t = {time:.6} s")]
    Cancelled { time: f64 },
    /// An input from outside that this model does not take.
    #[error("this input cannot be set: {reason}")]
    WrongInput { reason: &'static str },
    /// A checkpoint that belongs to another model.
    #[error("the checkpoint does not fit this run: {reason}")]
    ForeignCheckpoint { reason: &'static str },
}

impl DynamicsError {
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
