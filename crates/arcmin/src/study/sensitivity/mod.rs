//! Sensitivity of the answer.
//!
//! Screening by elementary effects ([`morris`]), shares of the variance ([`sobol`]), shares by a straight fit
//! where samples were not laid out for either ([`regression`]), and what tightening each spread would gain on
//! the same machines ([`tighten`]). Rows that failed are `None`; what they belonged to is left out and
//! counted.

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
    /// Range that holds the true value with the confidence asked for.
    pub interval: Interval,
}

fn require(holds: bool, reason: &'static str) -> Result<(), StudyError> {
    if holds { Ok(()) } else { Err(StudyError::Statistic { reason }) }
}
