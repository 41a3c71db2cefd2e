use statrs::distribution::{Binomial, DiscreteCDF};

use super::{StudyError, require, require_share};

/// Whether a band has one end or two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sides {
    /// One end: values below or above are outside.
    One,
    /// Two ends, with as many values outside of each.
    Two,
}

/// Limits that hold for a share of all machines, from order statistics alone (Wilks 1941).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToleranceLimits {
    /// Share of all machines within the limits …
    pub coverage: f64,
    /// … with at least this confidence, for the ranks taken.
    pub confidence: f64,
    /// Lower limit; `None` for the open side of a one-sided limit.
    pub low: Option<f64>,
    /// Upper limit; `None` for the open side of a one-sided limit.
    pub high: Option<f64>,
    /// Values left outside at each closed end.
    pub discarded: usize,
}

/// Number of samples whose extreme values bound a share `coverage` of all machines with `confidence`, when
/// `discarded` values are left out at each closed end: the smallest n with P(B ≤ n − s) ≥ confidence, B ~
/// Bin(n, coverage), where s = discarded + 1 for one side and 2 (discarded + 1) for two. 59 and 93 for 95 %/95
/// %; 29 and 46 for 90 %/95 %.
///
/// # Errors
/// [`StudyError::Statistic`] for shares outside (0, 1), or where more than 10⁹ samples are needed.
pub fn samples_for_limits(
    coverage: f64,
    confidence: f64,
    sides: Sides,
    discarded: usize,
) -> Result<u64, StudyError> {
    require_share(coverage)?;
    require_share(confidence)?;
    let outside = outside(sides, discarded);
    let enough = |n: u64| attained(n, coverage, outside) >= confidence;
    let mut high = outside.max(2);
    while !enough(high) {
        high *= 2;
        require(high < 2_000_000_000, "more samples are needed than can be counted")?;
    }
    let mut low = outside.saturating_sub(1);
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if enough(middle) { high = middle } else { low = middle }
    }
    Ok(high)
}

fn outside(sides: Sides, discarded: usize) -> u64 {
    (discarded as u64 + 1) * if sides == Sides::One { 1 } else { 2 }
}

/// Confidence that at least a share `coverage` lies between the order statistics that leave out `outside` of
/// the n + 1 gaps: P(B ≤ n − outside).
fn attained(n: u64, coverage: f64, outside: u64) -> f64 {
    if n < outside {
        return 0.0;
    }
    Binomial::new(coverage, n).map_or(0.0, |binomial| binomial.cdf(n - outside))
}

/// Confidence that the smallest and the largest of `samples` values enclose a share `coverage` of all; 0 for
/// fewer than two.
pub fn attained_confidence(samples: usize, coverage: f64) -> f64 {
    attained(samples as u64, coverage, 2)
}

/// Limits for a share `coverage` of all machines with `confidence`, leaving out as many extreme values as the
/// number of samples allows; one-sided ones are upper limits (negate the values for a lower one). `None` if
/// there are too few.
///
/// # Errors
/// [`StudyError::Statistic`] for an empty slice or shares outside (0, 1).
pub fn tolerance_limits(
    sorted: &[f64],
    coverage: f64,
    confidence: f64,
    sides: Sides,
) -> Result<Option<ToleranceLimits>, StudyError> {
    require(!sorted.is_empty(), "there are no values")?;
    require_share(coverage)?;
    require_share(confidence)?;
    let n = sorted.len();
    let holds = |discarded: usize| attained(n as u64, coverage, outside(sides, discarded)) >= confidence;
    if !holds(0) {
        return Ok(None);
    }
    let (mut most, mut too_many) = (0, n);
    while too_many - most > 1 {
        let middle = most + (too_many - most) / 2;
        if holds(middle) { most = middle } else { too_many = middle }
    }
    Ok(Some(ToleranceLimits {
        coverage,
        confidence: attained(n as u64, coverage, outside(sides, most)),
        low: (sides == Sides::Two).then(|| sorted[most]),
        high: Some(sorted[n - 1 - most]),
        discarded: most,
    }))
}

/// The share of all machines that lies within the extreme values of `n` samples, with `confidence`.
pub fn attained_coverage(n: u64, confidence: f64, sides: Sides) -> Result<f64, StudyError> {
    require_share(confidence)?;
    let outside = outside(sides, 0) as f64;
    require(n as f64 >= outside, "there are too few values")?;
    // The coverage is Beta(n + 1 − s, s).
    super::yields::beta_quantile(n as f64 + 1.0 - outside, outside, 1.0 - confidence)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilks_numbers_as_published() {
        // Wilks 1941; Glaeser 2008, table 2 (first to third order at 95 %/95 %).
        let n = |coverage, confidence, sides, discarded| {
            samples_for_limits(coverage, confidence, sides, discarded).unwrap()
        };
        assert_eq!(n(0.95, 0.95, Sides::One, 0), 59);
        assert_eq!(n(0.95, 0.95, Sides::Two, 0), 93);
        assert_eq!(n(0.90, 0.95, Sides::One, 0), 29);
        assert_eq!(n(0.90, 0.95, Sides::Two, 0), 46);
        assert_eq!([1, 2, 3].map(|r| n(0.95, 0.95, Sides::One, r)), [93, 124, 153]);
        assert_eq!(n(0.99, 0.99, Sides::One, 0), 459);
        assert_eq!(n(0.5, 0.49, Sides::One, 0), 1);
    }

    #[test]
    fn closed_forms_agree() {
        // One side: 1 − pⁿ; two: 1 − n pⁿ⁻¹ + (n − 1) pⁿ.
        for n in [2_u64, 10, 59, 93, 400] {
            for p in [0.5_f64, 0.9, 0.95] {
                let m = n as f64;
                assert!((attained(n, p, 1) - (1.0 - p.powf(m))).abs() < 1e-12);
                let two = 1.0 - m * p.powf(m - 1.0) + (m - 1.0) * p.powf(m);
                assert!((attained(n, p, 2) - two).abs() < 1e-12);
            }
        }
        assert!((attained_coverage(59, 0.95, Sides::One).unwrap() - 0.05_f64.powf(1.0 / 59.0)).abs() < 1e-12);
    }

    #[test]
    fn limits_discard_the_permitted_extremes() {
        let values: Vec<f64> = (1..=93).map(f64::from).collect();
        let two = tolerance_limits(&values, 0.95, 0.95, Sides::Two).unwrap().unwrap();
        assert_eq!((two.low, two.high, two.discarded), (Some(1.0), Some(93.0), 0));
        let one = tolerance_limits(&values, 0.95, 0.95, Sides::One).unwrap().unwrap();
        assert_eq!((one.low, one.high, one.discarded), (None, Some(92.0), 1));
        assert!(one.confidence >= 0.95);
        assert!(tolerance_limits(&values[..92], 0.95, 0.95, Sides::Two).unwrap().is_none());
    }
}
