//! Statistics of rows with confidence intervals.
//!
//! No distribution is assumed for quantiles, tolerance limits and yields; lives may be Weibull, and capability
//! indices assume a normal distribution, which is tested.

mod batches;
mod bootstrap;
mod capability;
mod paper;
mod quantile;
mod tolerance;
mod weibull;
mod yields;

pub use batches::{Batched, BetweenBatches};
pub use bootstrap::Bootstrap;
pub use capability::{Capability, Limits};
pub use paper::{Normality, PaperPoint, PaperScale, normality, probability_paper};
pub use quantile::{Quantile, ecdf, quantile, sorted_finite_or_infinite};
pub use tolerance::{
    Sides, ToleranceLimits, attained_confidence, attained_coverage, samples_for_limits, tolerance_limits,
};
pub use weibull::{Life, Weibull, fit_weibull};
use yields::clopper_pearson_of;
pub use yields::{Yield, clopper_pearson};

use super::StudyError;

/// A confidence interval; an end is `None` if there are too few samples for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

impl Interval {
    /// Whether a value is not beyond either end.
    pub fn contains(&self, x: f64) -> bool {
        self.low.is_none_or(|low| low <= x) && self.high.is_none_or(|high| x <= high)
    }
}

fn require(holds: bool, reason: &'static str) -> Result<(), StudyError> {
    if holds { Ok(()) } else { Err(StudyError::Statistic { reason }) }
}

fn require_share(share: f64) -> Result<(), StudyError> {
    require(share > 0.0 && share < 1.0, "a share or confidence must lie between 0 and 1")
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Σ (x − x̄)² / (n − 1).
fn variance(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0)
}
