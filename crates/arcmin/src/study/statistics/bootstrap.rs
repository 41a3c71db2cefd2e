use super::{Interval, StudyError, require, require_share};
use crate::study::stream::{Purpose, Stream};

/// Resampling with replacement (Efron 1979); resample r depends on (seed, r) alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bootstrap {
    /// Number of resamples.
    pub resamples: usize,
    /// Confidence of the intervals, between 0 and 1.
    pub confidence: f64,
    /// Seed of the resamples.
    pub seed: u64,
}

impl Default for Bootstrap {
    fn default() -> Bootstrap {
        Bootstrap { resamples: 1000, confidence: 0.95, seed: 0 }
    }
}

impl Bootstrap {
    /// Percentile intervals of several numbers that are computed together from samples `0 … samples` by their
    /// indices. Resamples for which a number cannot be computed (not finite) are left out of its interval.
    ///
    /// # Errors
    /// [`StudyError::Statistic`] without samples or resamples, or with a confidence outside (0, 1).
    pub fn intervals(
        &self,
        samples: usize,
        mut numbers: impl FnMut(&[usize]) -> Vec<f64>,
    ) -> Result<Vec<Interval>, StudyError> {
        require_share(self.confidence)?;
        require(samples > 0 && self.resamples > 1, "there are no values to draw again")?;
        let mut indices = vec![0; samples];
        let mut drawn: Vec<Vec<f64>> = Vec::new();
        for resample in 0..self.resamples {
            let mut stream = Stream::new(self.seed, Purpose::Resamples, resample as u64);
            indices.iter_mut().for_each(|index| *index = stream.below(samples));
            let numbers = numbers(&indices);
            drawn.resize(numbers.len(), Vec::new());
            for (all, number) in drawn.iter_mut().zip(numbers) {
                if number.is_finite() {
                    all.push(number);
                }
            }
        }
        Ok(drawn.into_iter().map(|values| self.percentiles(values)).collect())
    }

    fn percentiles(&self, mut values: Vec<f64>) -> Interval {
        if values.len() < 2 {
            return Interval { low: None, high: None };
        }
        values.sort_by(f64::total_cmp);
        let tail = 0.5 * (1.0 - self.confidence);
        let at = |share: f64| {
            let place = share * (values.len() - 1) as f64;
            let below = place.floor() as usize;
            let above = (below + 1).min(values.len() - 1);
            values[below] + (place - below as f64) * (values[above] - values[below])
        };
        Interval { low: Some(at(tail)), high: Some(at(1.0 - tail)) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::mean;
    use super::*;

    /// The interval of a mean is that of the central limit theorem: x̄ ± 1.96 s/√n within a twentieth of its
    /// width.
    #[test]
    fn the_interval_of_a_mean() {
        let mut stream = Stream::new(2, Purpose::Points, 0);
        let values: Vec<f64> = (0..400).map(|_| stream.unit()).collect();
        let bootstrap = Bootstrap { resamples: 4000, ..Bootstrap::default() };
        let of = |indices: &[usize]| vec![mean(&indices.iter().map(|k| values[*k]).collect::<Vec<_>>())];
        let interval = bootstrap.intervals(values.len(), of).unwrap()[0];
        let half = 1.96 * (super::super::variance(&values) / 400.0).sqrt();
        assert!((interval.low.unwrap() - (mean(&values) - half)).abs() < 0.1 * half);
        assert!((interval.high.unwrap() - (mean(&values) + half)).abs() < 0.1 * half);
        assert_eq!(interval, bootstrap.intervals(values.len(), of).unwrap()[0]);
        assert!(bootstrap.intervals(0, of).is_err());
    }
}
