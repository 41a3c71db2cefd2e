//! Distributions of keys, and their values at places of the unit cube.

use std::f64::consts::SQRT_2;

use super::StudyError;
use super::stream::mix;

/// Distribution of one variable. Values follow from u in (0, 1) by the inverse of the distribution function, so that
/// every sampling of the unit cube can be used with every distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Distribution {
    /// Uniform between the bounds.
    Uniform {
        /// Lower bound in the unit of the key.
        low: f64,
        /// Upper bound in the unit of the key.
        high: f64,
    },
    /// Log-uniform: for quantities known only to a factor.
    LogUniform {
        /// Lower bound in the unit of the key, positive.
        low: f64,
        /// Upper bound in the unit of the key.
        high: f64,
    },
    /// Normal; with `limit`, values further than so many standard deviations from the mean do not
    /// occur (the tails are cut off, as by inspection).
    Normal {
        /// Mean in the unit of the key.
        mean: f64,
        /// Standard deviation in the unit of the key.
        deviation: f64,
        /// Distance of the cut from the mean in standard deviations.
        limit: Option<f64>,
    },
    /// One of several entries with equal probability.
    List {
        /// Number of entries.
        count: usize,
    },
    /// A machine drawn from its tolerances: the value is the seed of the draw.
    Drawn,
    /// A tolerance from which machines are drawn: constant until it is tightened.
    Tolerance {
        /// Width in the unit of the key.
        width: f64,
    },
}

/// A value of a [`Distribution`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// Number in the unit of the key.
    Number(f64),
    /// Index of the entry of a list.
    Entry(usize),
    /// Seed of a draw, below 2⁵³ so that every format of numbers holds it.
    Seed(u64),
}

/// Φ⁻¹(u), the standard normal deviate below which a share `u` lies; infinite at 0 and 1.
pub fn standard_normal(u: f64) -> f64 {
    -SQRT_2 * statrs::function::erf::erfc_inv(2.0 * u)
}

/// Φ(z), the share below a standard normal deviate.
pub(super) fn standard_normal_share(z: f64) -> f64 {
    0.5 * statrs::function::erf::erfc(-z / SQRT_2)
}

impl Distribution {
    /// # Errors
    /// [`StudyError::Distribution`] with the reason: bounds that are not finite or not in order, log-uniform bounds that are
    /// not positive, a deviation or limit that is not positive, an empty list.
    pub fn validate(&self) -> Result<(), StudyError> {
        let wrong = |reason: &'static str| Err(StudyError::Distribution { reason });
        match *self {
            Distribution::Uniform { low, high } | Distribution::LogUniform { low, high }
                if !(low.is_finite() && high.is_finite()) =>
            {
                wrong("a bound is not a finite number")
            }
            Distribution::Uniform { low, high } | Distribution::LogUniform { low, high } if !(low < high) => {
                wrong("`low` must be less than `high`")
            }
            // The difference of two finite bounds may overflow.
            Distribution::Uniform { low, high } if !(high - low).is_finite() => {
                wrong("the difference of the bounds is too large for a number")
            }
            Distribution::LogUniform { low, .. } if !(low > 0.0) => {
                wrong("a log-uniform range needs positive bounds")
            }
            Distribution::LogUniform { low, high } if !(high / low).is_finite() => {
                wrong("the difference of the bounds is too large for a number")
            }
            Distribution::Normal { mean, deviation, .. } if !(mean.is_finite() && deviation.is_finite()) => {
                wrong("mean or deviation is not a finite number")
            }
            Distribution::Normal { deviation, .. } if !(deviation > 0.0) => {
                wrong("a standard deviation must be positive")
            }
            Distribution::Normal { limit: Some(limit), .. } if !(limit > 0.0 && limit.is_finite()) => {
                wrong("the limit in standard deviations must be positive")
            }
            Distribution::Tolerance { width } if !(width > 0.0 && width.is_finite()) => {
                wrong("a tolerance must be positive")
            }
            Distribution::List { count: 0 } => wrong("a list needs an entry"),
            _ => Ok(()),
        }
    }

    /// The value at place `u` of the unit interval, for `u` within [0, 1]; a normal distribution without
    /// limit is infinite at its ends.
    pub fn at(&self, u: f64) -> Value {
        match *self {
            // Rounding must not exceed the given bounds.
            Distribution::Uniform { low, high } => Value::Number((low + u * (high - low)).clamp(low, high)),
            Distribution::LogUniform { low, high } => {
                Value::Number((low * (high / low).powf(u)).clamp(low, high))
            }
            Distribution::Normal { mean, deviation, limit } => {
                let u = match limit {
                    None => u,
                    Some(limit) => {
                        let tail = standard_normal_share(-limit);
                        tail + u * (1.0 - 2.0 * tail)
                    }
                };
                Value::Number(mean + deviation * standard_normal(u))
            }
            Distribution::List { count } => Value::Entry(((u * count as f64) as usize).min(count - 1)),
            Distribution::Tolerance { width } => Value::Number(width),
            Distribution::Drawn => Value::Seed(mix(u.to_bits()) >> 11),
        }
    }

    /// The median; `None` for lists and drawn machines.
    pub fn middle(&self) -> Option<f64> {
        match self.at(0.5) {
            _ if matches!(self, Distribution::Tolerance { .. }) => Some(0.0),
            Value::Number(middle) => Some(middle),
            Value::Entry(_) | Value::Seed(_) => None,
        }
    }

    /// A value closer to the median: its distance (of logarithms for log-uniform) times 1 − `share`. Unchanged
    /// without a width.
    pub fn tightened(&self, value: Value, share: f64) -> Value {
        let (Value::Number(number), Some(middle)) = (value, self.middle()) else { return value };
        Value::Number(match self {
            Distribution::LogUniform { .. } => middle * (number / middle).powf(1.0 - share),
            _ => middle + (1.0 - share) * (number - middle),
        })
    }

    /// Half of the range, or the tolerance of a normal distribution: three standard deviations, or its
    /// limit. The width used for tightening. `None` without a width in units of the value.
    pub fn half_width(&self) -> Option<f64> {
        match *self {
            Distribution::Uniform { low, high } => Some(0.5 * (high - low)),
            Distribution::Normal { deviation, limit, .. } => Some(deviation * limit.unwrap_or(3.0)),
            Distribution::Tolerance { width } => Some(width),
            _ => None,
        }
    }

    /// The place of level `index` of `levels` on a grid: ranges from end to end, normal distributions at the
    /// middles of equally likely parts, lists entry by entry.
    pub(super) fn level(&self, index: usize, levels: usize) -> f64 {
        let (index, levels) = (index as f64, levels as f64);
        match self {
            Distribution::Uniform { .. } | Distribution::LogUniform { .. } if levels > 1.0 => {
                index / (levels - 1.0)
            }
            _ => (index + 0.5) / levels,
        }
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    fn number(value: Value) -> f64 {
        match value {
            Value::Number(x) => x,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn quantiles_by_hand() {
        let uniform = Distribution::Uniform { low: -2.0, high: 6.0 };
        assert_eq!([0.0, 0.25, 1.0].map(|u| number(uniform.at(u))), [-2.0, 0.0, 6.0]);
        let log = Distribution::LogUniform { low: 1e-3, high: 10.0 };
        assert_relative_eq!(number(log.at(0.5)), 0.1, max_relative = 1e-14);
        assert_eq!([log.at(0.0), log.at(1.0)].map(number), [1e-3, 10.0]);
        // Φ⁻¹(0.975) and Φ⁻¹(1e-6) as tabulated.
        assert_relative_eq!(standard_normal(0.975), 1.959_963_984_540_054, max_relative = 1e-13);
        assert_relative_eq!(standard_normal(1e-6), -4.753_424_308_822_899, max_relative = 1e-12);
        let normal = Distribution::Normal { mean: 8.75, deviation: 0.05, limit: None };
        assert_relative_eq!(number(normal.at(0.975)), 8.75 + 0.05 * 1.959_963_984_540_054);
        let list = Distribution::List { count: 3 };
        assert_eq!([0.0, 0.3, 0.34, 0.99, 1.0].map(|u| list.at(u)), [0, 0, 1, 2, 2].map(Value::Entry));
        assert_ne!(Distribution::Drawn.at(0.1), Distribution::Drawn.at(0.2));
    }

    #[test]
    fn cut_tails_stay_within_their_limit() {
        let cut = Distribution::Normal { mean: 0.0, deviation: 2.0, limit: Some(1.5) };
        // Φ and its inverse agree to ten digits.
        assert_relative_eq!(number(cut.at(0.0)), -3.0, max_relative = 1e-10);
        assert_relative_eq!(number(cut.at(1.0)), 3.0, max_relative = 1e-10);
        assert_relative_eq!(number(cut.at(0.5)), 0.0, epsilon = 1e-15);
        // Density at the middle: that of the whole distribution over the share that is left.
        let slope = (number(cut.at(0.501)) - number(cut.at(0.499))) / 0.002;
        let share = standard_normal_share(1.5) - standard_normal_share(-1.5);
        assert_relative_eq!(slope, 2.0 * share * std::f64::consts::TAU.sqrt(), max_relative = 1e-5);
    }

    #[test]
    fn tightening_halves_the_distance_to_the_middle() {
        let uniform = Distribution::Uniform { low: 0.0, high: 10.0 };
        assert_eq!(uniform.tightened(Value::Number(9.0), 0.5), Value::Number(7.0));
        assert_eq!(uniform.half_width(), Some(5.0));
        let log = Distribution::LogUniform { low: 1.0, high: 100.0 };
        assert_relative_eq!(
            number(log.tightened(Value::Number(100.0), 0.5)),
            10f64.powf(1.5),
            max_relative = 1e-14
        );
        assert_eq!(Distribution::Drawn.tightened(Value::Seed(5), 0.5), Value::Seed(5));
        let width = Distribution::Tolerance { width: 4.0 };
        assert_eq!((width.at(0.9), width.half_width()), (Value::Number(4.0), Some(4.0)));
        assert_eq!(width.tightened(width.at(0.1), 0.25), Value::Number(3.0));
    }

    #[test]
    fn nonsense_is_refused() {
        for (wrong, word) in [
            (Distribution::Uniform { low: 1.0, high: 1.0 }, "less"),
            (Distribution::Uniform { low: 0.0, high: f64::NAN }, "finite"),
            (Distribution::Uniform { low: -1e308, high: 1e308 }, "too large"),
            (Distribution::LogUniform { low: 0.0, high: 1.0 }, "positive"),
            (Distribution::Normal { mean: 0.0, deviation: -1.0, limit: None }, "deviation"),
            (Distribution::Normal { mean: 0.0, deviation: 1.0, limit: Some(0.0) }, "limit"),
            (Distribution::List { count: 0 }, "entry"),
        ] {
            let message = wrong.validate().unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
        Distribution::Normal { mean: 0.0, deviation: 1.0, limit: Some(3.0) }.validate().unwrap();
    }
}
