use statrs::distribution::{Beta, Continuous, ContinuousCDF};

use super::{StudyError, require, require_share};

/// Share of machines that keep their limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Yield {
    /// Machines that keep the limits.
    pub kept: u64,
    /// Machines judged.
    pub of: u64,
    /// `kept` over `of`.
    pub share: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// Share `kept` of `of` with its interval of Clopper & Pearson (1934), which covers the true share with at
/// least `confidence`: low = Beta⁻¹(α/2; k, n − k + 1), high = Beta⁻¹(1 − α/2; k + 1, n − k).
///
/// # Errors
/// [`StudyError::Statistic`] if there are none, more kept than there are, or a confidence outside (0, 1).
pub fn clopper_pearson(kept: u64, of: u64, confidence: f64) -> Result<Yield, StudyError> {
    clopper_pearson_of(kept, of, of as f64, confidence)
}

/// The same interval if `of` machines are equivalent to `effective` independent ones.
pub(super) fn clopper_pearson_of(
    kept: u64,
    of: u64,
    effective: f64,
    confidence: f64,
) -> Result<Yield, StudyError> {
    require(of > 0, "there are no values")?;
    require(kept <= of, "more are kept than there are")?;
    require_share(confidence)?;
    let share = kept as f64 / of as f64;
    let (n, tail) = (effective, 0.5 * (1.0 - confidence));
    let k = if effective == of as f64 { kept as f64 } else { share * n };
    let low = if kept == 0 { 0.0 } else { beta_quantile(k, n - k + 1.0, tail)? };
    let high = if kept == of { 1.0 } else { beta_quantile(k + 1.0, n - k, 1.0 - tail)? };
    Ok(Yield { kept, of, share, low, high })
}

pub(super) fn beta_quantile(a: f64, b: f64, share: f64) -> Result<f64, StudyError> {
    let beta = Beta::new(a, b).map_err(|_| StudyError::Statistic { reason: "there are too few values" })?;
    // The inverse of the library (AS 109) has about eight digits only; its distribution function is exact.
    let mut x = beta.inverse_cdf(share);
    for _ in 0..4 {
        let (low, high) = (0.5 * x, 0.5 * (1.0 + x));
        let step = (beta.cdf(x) - share) / beta.pdf(x);
        if !step.is_finite() {
            break;
        }
        x = (x - step).clamp(low, high);
    }
    Ok(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_by_closed_form() {
        // None kept: high = 1 − (α/2)^(1/n); all kept: low = (α/2)^(1/n).
        for n in [1_u64, 10, 59, 10_000] {
            let end = 0.025_f64.powf(1.0 / n as f64);
            let (none, all) = (clopper_pearson(0, n, 0.95).unwrap(), clopper_pearson(n, n, 0.95).unwrap());
            assert!(
                (none.high - (1.0 - end)).abs() < 1e-12 && none.low == 0.0,
                "{} {}",
                none.high,
                1.0 - end
            );
            assert!((all.low - end).abs() < 1e-12 && all.high == 1.0);
        }
        assert!(clopper_pearson(1, 0, 0.95).is_err() && clopper_pearson(3, 2, 0.95).is_err());
        assert!(clopper_pearson(1, 2, 1.0).is_err());
    }

    /// The definition: at the ends the tails of the binomial distribution hold α/2.
    #[test]
    fn ends_hold_half_of_the_risk() {
        use statrs::distribution::{Binomial, DiscreteCDF};
        for (k, n) in [(1, 7), (5, 10), (95, 100), (999, 1000), (9_720, 10_000)] {
            let y = clopper_pearson(k, n, 0.9).unwrap();
            let at_least = 1.0 - Binomial::new(y.low, n).unwrap().cdf(k - 1);
            let at_most = Binomial::new(y.high, n).unwrap().cdf(k);
            assert!((at_least - 0.05).abs() < 1e-9 && (at_most - 0.05).abs() < 1e-9, "{k} of {n}: {y:?}");
        }
    }
}
