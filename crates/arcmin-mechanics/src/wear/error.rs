use crate::load::LoadError;
use crate::load::closed_form::ClosedFormError;

/// Reasons why wear could not be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WearError {
    /// No load sharing was found for the worn flank.
    #[error("wear: {0}")]
    Load(#[from] LoadError),
    /// The closed form of the load sharing has no solution.
    #[error("wear: {0}")]
    ClosedForm(#[from] ClosedFormError),
    /// The rate of wear is zero everywhere.
    #[error(
        "no wear: the duty has no torque or no speed, the wear coefficient is zero, or no pressure exceeds the threshold of the wear law"
    )]
    NoWear,
    /// The wear law depends on time, but the computation has exposure as its only variable.
    #[error("the wear law depends on time, but no time is given for an exposure")]
    NoClock,
    /// A running-in cannot be fitted to a law that depends on time.
    #[error(
        "a running-in cannot be fitted together with a wear law that depends on time; remove one of the two"
    )]
    RunningInOfTimeLaw,
    /// The growth ends below the target depth.
    #[error(
        "the target is not reached: {reached_um:.2} µm after an exposure of {exposure:.3e} s/Pa; the wear rate is too small there; give a smaller depth"
    )]
    TargetNotReached {
        /// Largest depth reached, µm.
        reached_um: f64,
        /// Exposure at the end, s/Pa.
        exposure: f64,
    },
    /// The iteration for the coefficient of a time-dependent law did not converge.
    #[error(
        "the iteration for the coefficient of a time-dependent wear law did not converge: the last value, {coefficient:.3e} 1/Pa, is {misfit_percent:.1} % off"
    )]
    CoefficientNotFound {
        /// Last coefficient tried, 1/Pa.
        coefficient: f64,
        /// Difference from the coefficient fitted with its own history, %.
        misfit_percent: f64,
    },
    /// The depth exceeds the range of the model, by exposure.
    #[error(
        "wear runs away: after an exposure of {exposure:.3e} s/Pa flank or pin have lost {depth_um:.0} µm, which is outside of the range of the model"
    )]
    RunsAway {
        /// Exposure reached, s/Pa.
        exposure: f64,
        /// Wear depth of flank or pin there, µm.
        depth_um: f64,
    },
    /// The depth exceeds the range of the model, by running time.
    #[error(
        "wear runs away: after {hours:.4} h flank or pin have lost {depth_um:.0} µm, which is outside of the range of the model"
    )]
    RunsAwayAt {
        /// Running time reached, h.
        hours: f64,
        /// Wear depth of flank or pin there, µm.
        depth_um: f64,
    },
    /// The readings require more wear than the model covers.
    #[error(
        "the readings require more wear than the model covers: flank or pin{place} have lost {depth_um:.0} µm and the lost motion has grown by {grown_arcmin:.3} arcmin before all readings are met; flanks and pins are followed to a quarter of the pin radius, or until they open ten times the limit of lost motion. Correct hours or values of the readings, or the limit"
    )]
    ReadingsBeyond {
        /// Words for the ring that has worn so far: " of ring 1 of 2 from the input"; empty for a drive of one ring.
        place: String,
        /// Depth lost by flank or pin there, µm.
        depth_um: f64,
        /// Growth of the lost motion of the drive until then, arcmin.
        grown_arcmin: f64,
    },
    /// The caller cancelled the computation.
    #[error("stopped")]
    Stopped,
}
