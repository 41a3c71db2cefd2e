//! Sensitivity of the answer.
//!
//! Screening by elementary effects ([`morris`]), shares of the variance ([`sobol`]), shares by a linear fit for other
//! samples ([`regression`]), and gains of tightening each tolerance on the same machines ([`tighten`]). Failed rows
//! are `None`; their groups are omitted and counted.

pub mod morris;
pub mod regression;
pub mod sobol;
pub mod tighten;

use super::StudyError;
use super::statistics::Interval;

/// A number with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Value from the samples.
    pub value: f64,
    /// Range that contains the true value with the given confidence.
    pub interval: Interval,
}

fn require(holds: bool, reason: &'static str) -> Result<(), StudyError> {
    if holds { Ok(()) } else { Err(StudyError::Statistic { reason }) }
}
