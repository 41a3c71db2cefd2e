use statrs::distribution::{Binomial, DiscreteCDF};

use super::{Interval, StudyError, require, require_share};

/// A quantile with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantile {
    /// Share of all machines below it.
    pub share: f64,
    /// Between order statistics by straight lines (the default of R and NumPy, type 7).
    pub estimate: f64,
    /// Two order statistics that enclose the quantile with the required confidence, for any distribution.
    pub interval: Interval,
}

/// Values in order, infinite ones (never) at their end.
///
/// # Errors
/// [`StudyError::Statistic`] if there are none, or one is not a number.
pub fn sorted_finite_or_infinite(values: &[f64]) -> Result<Vec<f64>, StudyError> {
    require(!values.is_empty(), "there are no values")?;
    require(!values.iter().any(|x| x.is_nan()), "a value is not a number")?;
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    Ok(sorted)
}

/// The quantile below which a share of all machines lies, from values in order.
///
/// P(X₍ₗ₎ ≤ ξ_p ≤ X₍ᵤ₎) ≥ confidence with binomial tails of at most (1 − confidence)/2 each: l the largest
/// rank with P(B < l) ≤ α/2, u the smallest with P(B ≥ u) ≤ α/2, B ~ Bin(n, p) (David & Nagaraja 2003, §
/// 7.1). An end without such a rank is `None`: 95 % of the machines need 72 of them for a two-sided 95 %
/// interval.
///
/// # Errors
/// [`StudyError::Statistic`] for an empty slice, a share or a confidence outside (0, 1).
pub fn quantile(sorted: &[f64], share: f64, confidence: f64) -> Result<Quantile, StudyError> {
    require(!sorted.is_empty(), "there are no values")?;
    require_share(share)?;
    require_share(confidence)?;
    let n = sorted.len();
    let place = share * (n - 1) as f64;
    let below = (place.floor() as usize).min(n - 1);
    let (a, b, t) = (sorted[below], sorted[(below + 1).min(n - 1)], place - below as f64);
    // There is no interpolation between a finite and an infinite life.
    let estimate = if t == 0.0 || a == b { a } else { a + t * (b - a) };
    let (low, high) = ranks(n, share, confidence);
    let interval =
        Interval { low: low.map(|rank| sorted[rank - 1]), high: high.map(|rank| sorted[rank - 1]) };
    Ok(Quantile { share, estimate, interval })
}

/// Ranks, from 1, of the two ends.
fn ranks(n: usize, share: f64, confidence: f64) -> (Option<usize>, Option<usize>) {
    let Ok(binomial) = Binomial::new(share, n as u64) else { return (None, None) };
    let tail = 0.5 * (1.0 - confidence);
    // P(B ≤ k), rising in k: both ends are found by bisection.
    let low = partition(n, |rank| binomial.cdf(rank as u64 - 1) <= tail);
    let high = 1 + partition(n, |rank| binomial.sf(rank as u64 - 1) > tail);
    ((low >= 1).then_some(low), (high <= n).then_some(high))
}

/// Largest rank 0 … n for which `holds`, where it holds for all smaller ones.
fn partition(n: usize, holds: impl Fn(usize) -> bool) -> usize {
    let (mut below, mut above) = (0, n + 1);
    while above - below > 1 {
        let middle = below + (above - below) / 2;
        if holds(middle) { below = middle } else { above = middle }
    }
    below
}

/// Share of machines at or below each value, from values in order: (value, share), one step for each
/// different value.
pub fn ecdf(sorted: &[f64]) -> Vec<(f64, f64)> {
    let n = sorted.len() as f64;
    let mut steps: Vec<(f64, f64)> = Vec::new();
    for (k, value) in sorted.iter().enumerate() {
        let share = (k + 1) as f64 / n;
        match steps.last_mut() {
            Some(last) if last.0 == *value => last.1 = share,
            _ => steps.push((*value, share)),
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{Purpose, Stream};

    #[test]
    fn ranks_as_tabulated() {
        // Conover (1999), table of binomial confidence limits: median of 20 at 95 %: 6th and 15th value.
        assert_eq!(ranks(20, 0.5, 0.95), (Some(6), Some(15)));
        assert_eq!(ranks(10, 0.5, 0.95), (Some(2), Some(9)));
        // 0.975 ≤ 1 − 0.95ⁿ needs n ≥ ln 0.025/ln 0.95 = 71.9.
        assert_eq!(ranks(71, 0.95, 0.95).1, None);
        assert_eq!(ranks(72, 0.95, 0.95).1, Some(72));
        assert_eq!(ranks(5, 0.5, 0.95), (None, None));
    }

    #[test]
    fn quantiles_by_hand() {
        let sorted = sorted_finite_or_infinite(&[3.0, 1.0, 2.0]).unwrap();
        let q = quantile(&sorted, 0.1, 0.95).unwrap();
        assert!((q.estimate - 1.2).abs() < 1e-15 && q.interval.low.is_none());
        let never = [1.0, 2.0, f64::INFINITY, f64::INFINITY];
        assert_eq!(quantile(&never, 0.9, 0.5).unwrap().estimate, f64::INFINITY);
        let between = quantile(&never, 0.5, 0.5).unwrap();
        assert_eq!(between.estimate, f64::INFINITY);
        assert!(quantile(&[], 0.5, 0.9).is_err() && quantile(&never, 1.0, 0.9).is_err());
        assert!(sorted_finite_or_infinite(&[f64::NAN]).is_err());
        assert_eq!(ecdf(&[1.0, 1.0, 4.0, 9.0]), [(1.0, 0.5), (4.0, 0.75), (9.0, 1.0)]);
    }

    /// In 2000 studies of 150 machines with a skewed distribution the interval of the 90 % quantile must hold
    /// it in at least 95 % (five standard errors below: 92.6 %), and not in all.
    #[test]
    fn intervals_cover_what_they_promise() {
        let truth = -(0.1_f64.ln());
        let covered = (0..2000)
            .filter(|study| {
                let mut stream = Stream::new(5, Purpose::Resamples, *study);
                let mut values: Vec<f64> = (0..150).map(|_| -stream.unit().ln()).collect();
                values.sort_by(f64::total_cmp);
                quantile(&values, 0.9, 0.95).unwrap().interval.contains(truth)
            })
            .count();
        assert!((1852..1990).contains(&covered), "{covered}");
    }
}
