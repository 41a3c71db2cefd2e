use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::{Interval, StudyError, mean, require, require_share, variance};
use crate::study::distribution::standard_normal;

/// Allowed range of a value; at least one end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Least value allowed.
    pub low: Option<f64>,
    /// Largest value allowed.
    pub high: Option<f64>,
}

/// Process capability: width of the limits relative to the spread. It is meaningful for nearly normal values only;
/// the yield does not need this.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capability {
    /// Mean of the sample.
    pub mean: f64,
    /// Standard deviation of the sample (n − 1).
    pub deviation: f64,
    /// (high − low)/6σ and its exact interval; `None` with one limit.
    pub cp: Option<(f64, Interval)>,
    /// Distance of the mean from the closer limit over 3σ.
    pub cpk: f64,
    /// Bissell's (1990), of normal values and large numbers: ± z √(1/(9n) + C²/(2(n − 1))).
    pub cpk_interval: Interval,
}

impl Capability {
    /// # Errors
    /// [`StudyError::Statistic`] if there are fewer than two finite values, no spread, no limit, limits out
    /// of order, or a confidence outside (0, 1).
    pub fn of(values: &[f64], limits: Limits, confidence: f64) -> Result<Capability, StudyError> {
        require_share(confidence)?;
        require(values.len() >= 2, "there are fewer than two values")?;
        require(values.iter().all(|x| x.is_finite()), "a value is not finite")?;
        require(limits.low.is_some() || limits.high.is_some(), "there is no limit")?;
        if let (Some(low), Some(high)) = (limits.low, limits.high) {
            require(low < high, "the limits are not in order")?;
        }
        let (mean, deviation) = (mean(values), variance(values).sqrt());
        require(deviation > 0.0, "all values are the same")?;
        let n = values.len() as f64;
        let tail = 0.5 * (1.0 - confidence);
        let cp = match (limits.low, limits.high) {
            (Some(low), Some(high)) => {
                let cp = (high - low) / (6.0 * deviation);
                let chi = ChiSquared::new(n - 1.0)
                    .map_err(|_| StudyError::Statistic { reason: "there are fewer than two values" })?;
                let end = |share: f64| Some(cp * (chi.inverse_cdf(share) / (n - 1.0)).sqrt());
                Some((cp, Interval { low: end(tail), high: end(1.0 - tail) }))
            }
            _ => None,
        };
        let room = |distance: f64| distance / (3.0 * deviation);
        let upper = limits.high.map_or(f64::INFINITY, |high| room(high - mean));
        let lower = limits.low.map_or(f64::INFINITY, |low| room(mean - low));
        let cpk = upper.min(lower);
        let error = standard_normal(1.0 - tail) * (1.0 / (9.0 * n) + cpk * cpk / (2.0 * (n - 1.0))).sqrt();
        let cpk_interval = Interval { low: Some(cpk - error), high: Some(cpk + error) };
        Ok(Capability { mean, deviation, cp, cpk, cpk_interval })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{Purpose, Stream};

    #[test]
    fn indices_by_hand() {
        // Mean 10, variance 10/4.
        let values = [8.0, 9.0, 10.0, 11.0, 12.0];
        let limits = Limits { low: Some(4.0), high: Some(13.0) };
        let c = Capability::of(&values, limits, 0.95).unwrap();
        let deviation = 2.5_f64.sqrt();
        assert!((c.cp.unwrap().0 - 9.0 / (6.0 * deviation)).abs() < 1e-15);
        assert!((c.cpk - 3.0 / (3.0 * deviation)).abs() < 1e-15);
        // χ²₄ at 2.5 %: 0.484419 (tables).
        let low = c.cp.unwrap().1.low.unwrap();
        assert!((low / c.cp.unwrap().0 - (0.484_418_6_f64 / 4.0).sqrt()).abs() < 1e-6);
        let one = Capability::of(&values, Limits { low: None, high: Some(13.0) }, 0.95).unwrap();
        assert!(one.cp.is_none() && one.cpk == c.cpk);
        assert!(Capability::of(&[1.0, 1.0], limits, 0.95).is_err());
        assert!(Capability::of(&values, Limits { low: None, high: None }, 0.95).is_err());
    }

    /// Of 2000 samples of 50 normal values both intervals hold the truth in 95 % ± 5 standard errors (0.5 %).
    #[test]
    fn intervals_cover_what_they_promise() {
        let limits = Limits { low: Some(-5.0), high: Some(4.0) };
        let (mut cp, mut cpk) = (0, 0);
        for study in 0..2000 {
            let mut stream = Stream::new(9, Purpose::Resamples, study);
            let values: Vec<f64> = (0..50).map(|_| stream.normal()).collect();
            let c = Capability::of(&values, limits, 0.95).unwrap();
            cp += usize::from(c.cp.unwrap().1.contains(1.5));
            cpk += usize::from(c.cpk_interval.contains(4.0 / 3.0));
        }
        assert!((1851..=1949).contains(&cp) && (1851..=1949).contains(&cpk), "{cp} {cpk}");
    }
}
