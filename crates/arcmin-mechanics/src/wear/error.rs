use crate::load::LoadError;
use crate::load::closed_form::ClosedFormError;

/// Why wear could not be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WearError {
    #[error("wear: {0}")]
    Load(#[from] LoadError),
    #[error("wear: {0}")]
    ClosedForm(#[from] ClosedFormError),
    #[error(
        "nothing wears: the duty has no torque, no speed, the wear coefficient is zero, or no pressure exceeds the threshold of the wear law"
    )]
    NoWear,
    #[error("the wear law depends on time, but it is not told which time belongs to an exposure")]
    NoClock,
    #[error(
        "a running-in cannot be fitted to a wear law that depends on time itself; leave one of the two out"
    )]
    RunningInOfTimeLaw,
    #[error(
        "the target is not reached: {reached_um:.2} µm after an exposure of {exposure:.3e} s/Pa; the flank wears too slowly there, give a shallower depth"
    )]
    TargetNotReached { reached_um: f64, exposure: f64 },
    #[error(
        "no wear coefficient was found that agrees with its own course in time: the last, {coefficient:.3e} 1/Pa, misses by {misfit_percent:.1} %"
    )]
    CoefficientNotFound { coefficient: f64, misfit_percent: f64 },
    #[error(
        "wear runs away: after an exposure of {exposure:.3e} s/Pa flank or pin have lost {depth_um:.0} µm, and nothing is left that the model could follow"
    )]
    RunsAway { exposure: f64, depth_um: f64 },
    #[error(
        "wear runs away: after {hours:.4} h flank or pin have lost {depth_um:.0} µm, and nothing is left that the model could follow"
    )]
    RunsAwayAt { hours: f64, depth_um: f64 },
    #[error("stopped")]
    Stopped,
}
