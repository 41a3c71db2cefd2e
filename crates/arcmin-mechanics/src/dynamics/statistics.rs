use serde::{Deserialize, Serialize};

/// Time integrals of the transmission error over a window, in which steps of any length have the weight of
/// their duration.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ErrorIntegrals {
    duration: f64,
    sum: f64,
    absolute: f64,
    square: f64,
    range: Option<(f64, f64)>,
}

/// Statistics of the transmission error in rad.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorStatistics {
    /// Time mean.
    pub mean: f64,
    /// Time mean of the magnitude.
    pub mean_abs: f64,
    /// Largest magnitude.
    pub max_abs: f64,
    /// Largest minus smallest value.
    pub peak_to_peak: f64,
    /// Root of the time mean of the square.
    pub rms: f64,
    /// Smallest value.
    pub lowest: f64,
    /// Largest value.
    pub highest: f64,
    /// Length of the window in s.
    pub duration: f64,
}

impl ErrorIntegrals {
    /// Adds an interval of length `h` (s) with the error at its beginning, middle and end (Simpson's rule),
    /// rad.
    pub fn add(&mut self, h: f64, values: [f64; 3]) {
        let simpson = |f: fn(f64) -> f64| h / 6.0 * (f(values[0]) + 4.0 * f(values[1]) + f(values[2]));
        self.duration += h;
        self.sum += simpson(|x| x);
        self.absolute += simpson(f64::abs);
        self.square += simpson(|x| x * x);
        for x in values {
            let (low, high) = self.range.unwrap_or((x, x));
            self.range = Some((low.min(x), high.max(x)));
        }
    }

    /// `None` for an empty window.
    pub fn statistics(&self) -> Option<ErrorStatistics> {
        let (lowest, highest) = self.range?;
        if self.duration <= 0.0 {
            return None;
        }
        Some(ErrorStatistics {
            mean: self.sum / self.duration,
            mean_abs: self.absolute / self.duration,
            max_abs: lowest.abs().max(highest.abs()),
            peak_to_peak: highest - lowest,
            rms: (self.square / self.duration).sqrt(),
            lowest,
            highest,
            duration: self.duration,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nonuniform intervals over whole periods of 2 + sin: mean 2, RMS √4.5, peak to peak 2.
    #[test]
    fn interval_lengths_do_not_bias() {
        let mut integrals = ErrorIntegrals::default();
        let f = |t: f64| 2.0 + t.sin();
        let mut t = 0.0;
        let end = 4.0 * std::f64::consts::TAU;
        while t < end {
            let h = (0.01 + 0.009 * t.sin()).min(end - t);
            integrals.add(h, [f(t), f(t + 0.5 * h), f(t + h)]);
            t += h;
        }
        let found = integrals.statistics().unwrap();
        assert!((found.mean - 2.0).abs() < 1e-9 && (found.mean_abs - 2.0).abs() < 1e-9);
        assert!((found.rms - 4.5_f64.sqrt()).abs() < 1e-9);
        assert!((found.peak_to_peak - 2.0).abs() < 1e-4 && (found.max_abs - 3.0).abs() < 1e-4);
        assert!(ErrorIntegrals::default().statistics().is_none());
    }
}
