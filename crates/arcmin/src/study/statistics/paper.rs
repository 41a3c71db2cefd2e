use super::weibull::Life;
use super::yields::beta_quantile;
use super::{StudyError, mean, require, require_share, variance};
use crate::study::distribution::{standard_normal, standard_normal_share};

/// Distribution that is a straight line on the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PaperScale {
    /// ln(−ln(1 − F)) over ln t.
    Weibull,
    /// Φ⁻¹(F) over the value.
    Normal,
}

impl PaperScale {
    /// Height of a share on the paper.
    pub fn height(self, share: f64) -> f64 {
        match self {
            PaperScale::Weibull => (-(-share).ln_1p()).ln(),
            PaperScale::Normal => standard_normal(share),
        }
    }

    /// Place of a value on the paper.
    pub fn place(self, value: f64) -> f64 {
        match self {
            PaperScale::Weibull => value.ln(),
            PaperScale::Normal => value,
        }
    }
}

/// One value on probability paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperPoint {
    /// Value that ended.
    pub value: f64,
    /// Median rank: median of the share below this value over all series.
    pub share: f64,
    /// Lower end of the rank's own interval.
    pub low: f64,
    /// Upper end of the rank's own interval.
    pub high: f64,
}

/// Values that ended on probability paper, with exact median ranks Beta⁻¹(½; j, n − j + 1) and the rank's
/// interval. Among censored ones the order numbers are adjusted: each that ended adds (n + 1 − j)/(1 + left)
/// (Johnson 1964).
///
/// # Errors
/// [`StudyError::Statistic`] if there are none, one is not finite, or the confidence lies outside (0, 1).
pub fn probability_paper(lives: &[Life], confidence: f64) -> Result<Vec<PaperPoint>, StudyError> {
    require_share(confidence)?;
    require(!lives.is_empty(), "there are no values")?;
    require(lives.iter().all(|life| life.hours.is_finite()), "a value is not finite")?;
    let mut sorted = lives.to_vec();
    // Censored lives count as longer than those that ended at the same hour.
    sorted.sort_by(|a, b| a.hours.total_cmp(&b.hours).then(b.ended.cmp(&a.ended)));
    let (n, tail) = (sorted.len() as f64, 0.5 * (1.0 - confidence));
    let mut order = 0.0;
    let mut points = Vec::new();
    for (index, life) in sorted.iter().enumerate().filter(|(_, life)| life.ended) {
        order += (n + 1.0 - order) / (1.0 + n - index as f64);
        let rank = |share: f64| beta_quantile(order, n - order + 1.0, share);
        points.push(PaperPoint {
            value: life.hours,
            share: rank(0.5)?,
            low: rank(tail)?,
            high: rank(1.0 - tail)?,
        });
    }
    Ok(points)
}

/// Test of Anderson & Darling (1952) for a normal distribution whose mean and deviation come from the values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normality {
    /// A²
    pub statistic: f64,
    /// Probability of so large a value if they were normal (D'Agostino & Stephens 1986, table 4.9).
    pub p_value: f64,
}

/// A² = −n − (1/n) Σ (2i − 1)(ln Φ(zᵢ) + ln(1 − Φ(zₙ₊₁₋ᵢ))).
///
/// # Errors
/// [`StudyError::Statistic`] if there are fewer than eight finite values, or no spread.
pub fn normality(values: &[f64]) -> Result<Normality, StudyError> {
    require(values.len() >= 8, "there are fewer than eight values")?;
    require(values.iter().all(|x| x.is_finite()), "a value is not finite")?;
    let (mean, deviation) = (mean(values), variance(values).sqrt());
    require(deviation > 0.0, "all values are the same")?;
    let mut z: Vec<f64> = values.iter().map(|x| (x - mean) / deviation).collect();
    z.sort_by(f64::total_cmp);
    let n = z.len() as f64;
    // The smallest positive number in place of 0: distant values do not get zero probability.
    let log = |share: f64| share.max(f64::MIN_POSITIVE).ln();
    let sum: f64 = z
        .iter()
        .zip(z.iter().rev())
        .enumerate()
        .map(|(i, (low, high))| {
            (2.0 * i as f64 + 1.0) * (log(standard_normal_share(*low)) + log(standard_normal_share(-high)))
        })
        .sum();
    let statistic = -n - sum / n;
    let a = statistic * (1.0 + 0.75 / n + 2.25 / (n * n));
    let p_value = if a < 0.2 {
        1.0 - (-13.436 + 101.14 * a - 223.73 * a * a).exp()
    } else if a < 0.34 {
        1.0 - (-8.318 + 42.796 * a - 59.938 * a * a).exp()
    } else if a < 0.6 {
        (0.9177 - 4.279 * a - 1.38 * a * a).exp()
    } else if a < 10.0 {
        (1.2937 - 5.709 * a + 0.0186 * a * a).exp()
    } else {
        // Beyond the table: smaller than its last value.
        3.7e-24
    };
    Ok(Normality { statistic, p_value })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{Purpose, Stream};

    fn life(hours: f64, ended: bool) -> Life {
        Life { hours, ended }
    }

    #[test]
    fn median_ranks_as_tabulated() {
        // Median ranks of five: 12.94, 31.38, 50.00, 68.62, 87.06 % (Abernethy's table).
        let lives: Vec<Life> = (1..=5).map(|k| life(f64::from(k), true)).collect();
        let points = probability_paper(&lives, 0.9).unwrap();
        for (point, percent) in points.iter().zip([12.94, 31.38, 50.0, 68.62, 87.06]) {
            assert!((100.0 * point.share - percent).abs() < 0.006, "{point:?}");
            assert!(point.low < point.share && point.share < point.high);
        }
        // 5 % and 95 % ranks of the first of five: 1 − 0.95^(1/5), 1 − 0.05^(1/5).
        assert!((points[0].low - (1.0 - 0.95_f64.powf(0.2))).abs() < 1e-12);
        assert!((points[0].high - (1.0 - 0.05_f64.powf(0.2))).abs() < 1e-12);
    }

    #[test]
    fn order_numbers_among_censored_lives() {
        // F, S, F, S, F: increments 1, 5/4, 15/8 (Johnson by hand): orders 1, 2.25, 4.125.
        let lives = [(1.0, true), (2.0, false), (3.0, true), (4.0, false), (5.0, true)];
        let lives: Vec<Life> = lives.into_iter().map(|(hours, ended)| life(hours, ended)).collect();
        let points = probability_paper(&lives, 0.9).unwrap();
        let expected = [1.0, 2.25, 4.125].map(|j| beta_quantile(j, 6.0 - j, 0.5).unwrap());
        assert_eq!(points.iter().map(|p| p.share).collect::<Vec<_>>(), expected);
    }

    #[test]
    fn papers_make_their_distribution_straight() {
        let fit = |share: f64| 1000.0 * (-(-share).ln_1p()).powf(0.5);
        for share in [0.01, 0.1, 0.5, 0.99] {
            let (x, y) = (PaperScale::Weibull.place(fit(share) / 1000.0), PaperScale::Weibull.height(share));
            assert!((y - 2.0 * x).abs() < 1e-12);
        }
        assert!(PaperScale::Normal.height(0.5).abs() < 1e-15);
    }

    /// Normal samples are called not normal at 5 % in 5 % ± 5 standard errors of 1000 cases, uniform ones of
    /// 100 values nearly always.
    #[test]
    fn normality_is_judged_at_its_level() {
        let count = |draw: fn(&mut Stream) -> f64| {
            (0..1000)
                .filter(|study| {
                    let mut stream = Stream::new(4, Purpose::Resamples, *study);
                    let values: Vec<f64> = (0..100).map(|_| draw(&mut stream)).collect();
                    normality(&values).unwrap().p_value < 0.05
                })
                .count()
        };
        let normal = count(Stream::normal);
        assert!((16..=84).contains(&normal), "{normal}");
        assert!(count(Stream::unit) > 900);
    }
}
