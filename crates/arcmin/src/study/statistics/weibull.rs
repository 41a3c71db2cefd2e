use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::{Interval, StudyError, require, require_share};

/// Observed life of one machine, ended or censored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Life {
    /// Time that the machine was followed, h.
    pub hours: f64,
    /// Whether its life ended then; otherwise it is censored.
    pub ended: bool,
}

/// Two-parameter Weibull distribution F(t) = 1 − exp(−(t/η)^β), fitted by maximum likelihood to lives of
/// which some are censored on the right.
#[derive(Debug, Clone, PartialEq)]
pub struct Weibull {
    /// β
    pub shape: f64,
    /// η, the life that 63.2 % do not exceed; in the unit of the lives.
    pub scale: f64,
    /// Lives that ended.
    pub ended: usize,
    /// Censored lives.
    pub survived: usize,
    /// Logarithm of the likelihood at the fit.
    pub log_likelihood: f64,
    lives: Vec<Life>,
}

/// Maximum likelihood. With r lives ended of all, β solves Σ t^β ln t / Σ t^β − 1/β − (1/r) Σ_ended ln t = 0
/// (rising in β, so there is one root) and η^β = Σ t^β / r (Lawless 2003, § 5.2).
///
/// # Errors
/// [`StudyError::Statistic`] if fewer than two lives have ended, all that ended are equal and none went
/// beyond, or a life is not a positive finite number.
pub fn fit_weibull(lives: &[Life]) -> Result<Weibull, StudyError> {
    require(lives.iter().all(|life| life.hours > 0.0 && life.hours.is_finite()), "a life is not positive")?;
    let ended: Vec<f64> = lives.iter().filter(|life| life.ended).map(|life| life.hours.ln()).collect();
    require(ended.len() >= 2, "fewer than two lives have ended")?;
    let logs: Vec<f64> = lives.iter().map(|life| life.hours.ln()).collect();
    let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mean_ended = super::mean(&ended);
    // Equal lives differ by rounding of their mean.
    require(largest - mean_ended > 1e-12 * largest.abs().max(1.0), "all lives that ended are equal")?;
    // Scaled by the longest life, so that no power overflows.
    let score = |shape: f64| {
        let (mut weights, mut weighted) = (0.0, 0.0);
        for log in &logs {
            let weight = (shape * (log - largest)).exp();
            weights += weight;
            weighted += weight * (log - largest);
        }
        weighted / weights - 1.0 / shape - (mean_ended - largest)
    };
    let shape = rising_root(score, 1.0).ok_or(StudyError::Statistic { reason: "no shape fits the lives" })?;
    let sum: f64 = logs.iter().map(|log| (shape * (log - largest)).exp()).sum();
    let scale = (largest + (sum / ended.len() as f64).ln() / shape).exp();
    let mut fit = Weibull {
        shape,
        scale,
        ended: ended.len(),
        survived: lives.len() - ended.len(),
        log_likelihood: 0.0,
        lives: lives.to_vec(),
    };
    fit.log_likelihood = fit.log_likelihood_of(shape, scale);
    Ok(fit)
}

/// Root of a rising function of a positive number: brackets by factors, then bisects the logarithm to the
/// last digits.
fn rising_root(f: impl Fn(f64) -> f64, start: f64) -> Option<f64> {
    let (mut low, mut high) = (start, start);
    let mut steps = 0;
    while f(low) > 0.0 {
        low /= 4.0;
        steps += 1;
        if steps > 200 {
            return None;
        }
    }
    while !(f(high) >= 0.0) {
        high *= 4.0;
        steps += 1;
        if steps > 400 {
            return None;
        }
    }
    for _ in 0..200 {
        let middle = (low * high).sqrt();
        if !(middle > low && middle < high) {
            break;
        }
        if f(middle) > 0.0 { high = middle } else { low = middle }
    }
    Some(0.5 * (low + high))
}

impl Weibull {
    /// Life that a share `share` of machines does not reach: B10 for 0.1.
    pub fn life(&self, share: f64) -> f64 {
        self.scale * (-(-share).ln_1p()).powf(1.0 / self.shape)
    }

    /// Share of machines whose life has ended.
    pub fn share(&self, hours: f64) -> f64 {
        -(-(hours / self.scale).powf(self.shape)).exp_m1()
    }

    /// The lives that were fitted.
    pub fn lives(&self) -> &[Life] {
        &self.lives
    }

    fn log_likelihood_of(&self, shape: f64, scale: f64) -> f64 {
        self.lives
            .iter()
            .map(|life| {
                let log = (life.hours / scale).ln();
                let ended = if life.ended { shape.ln() - life.hours.ln() + shape * log } else { 0.0 };
                ended - (shape * log).exp()
            })
            .sum()
    }

    /// Interval of β by the likelihood ratio, η being the best for each β.
    ///
    /// # Errors
    /// [`StudyError::Statistic`] for a confidence outside (0, 1).
    pub fn shape_interval(&self, confidence: f64) -> Result<Interval, StudyError> {
        let profile = |shape: f64| {
            let largest = self.lives.iter().map(|life| life.hours).fold(0.0, f64::max);
            let sum: f64 = self.lives.iter().map(|life| (life.hours / largest).powf(shape)).sum();
            let scale = largest * (sum / self.ended as f64).powf(1.0 / shape);
            self.log_likelihood_of(shape, scale)
        };
        self.where_likely(self.shape, profile, confidence)
    }

    /// Interval of the life [`Weibull::life`]`(share)` by the likelihood ratio: those lives B for which 2(ℓ_max −
    /// max_β ℓ(β, B)) ≤ χ²₁ (Meeker & Escobar 1998, § 8.3). For few lives its coverage is better than that of ±
    /// standard errors.
    ///
    /// # Errors
    /// [`StudyError::Statistic`] for a share or confidence outside (0, 1).
    pub fn life_interval(&self, share: f64, confidence: f64) -> Result<Interval, StudyError> {
        require_share(share)?;
        let hazard = -(-share).ln_1p();
        let ended: f64 = self.lives.iter().filter(|life| life.ended).map(|life| life.hours.ln()).sum();
        let profile = |life: f64| {
            // ∂ℓ/∂β falls in β.
            let slope = |shape: f64| {
                let worn: f64 = self
                    .lives
                    .iter()
                    .map(|one| {
                        let log = (one.hours / life).ln();
                        if log == 0.0 { 0.0 } else { (shape * log).exp() * log }
                    })
                    .sum();
                let r = self.ended as f64;
                -(r / shape - r * life.ln() + ended - hazard * worn)
            };
            rising_root(slope, self.shape).map_or(f64::NEG_INFINITY, |shape| {
                self.log_likelihood_of(shape, life / hazard.powf(1.0 / shape))
            })
        };
        self.where_likely(self.life(share), profile, confidence)
    }

    /// Ends of the interval around `best` in which a profile stays within half a χ² of its maximum; an end beyond a
    /// factor of 10¹² is `None`.
    fn where_likely(
        &self,
        best: f64,
        profile: impl Fn(f64) -> f64,
        confidence: f64,
    ) -> Result<Interval, StudyError> {
        require_share(confidence)?;
        let chi = ChiSquared::new(1.0).map_err(|_| StudyError::Statistic {
            reason: "a share or confidence must lie between 0 and 1",
        })?;
        let least = self.log_likelihood - 0.5 * chi.inverse_cdf(confidence);
        let end = |factor: f64| {
            let (mut inside, mut step) = (0.0, 0.01_f64);
            let at = |distance: f64| profile(best * factor.powf(distance)) >= least;
            let mut outside = step;
            while at(outside) {
                inside = outside;
                step *= 2.0;
                outside += step;
                if outside > 12.0 * std::f64::consts::LN_10 {
                    return None;
                }
            }
            for _ in 0..100 {
                let middle = 0.5 * (inside + outside);
                if outside - inside < 1e-13 {
                    break;
                }
                if at(middle) { inside = middle } else { outside = middle }
            }
            Some(best * factor.powf(inside))
        };
        Ok(Interval { low: end((-1.0_f64).exp()), high: end(std::f64::consts::E) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{Purpose, Stream};

    fn drawn(study: u64, count: usize, shape: f64, scale: f64, until: f64) -> Vec<Life> {
        let mut stream = Stream::new(11, Purpose::Resamples, study);
        (0..count)
            .map(|_| scale * (-stream.unit().ln()).powf(1.0 / shape))
            .map(|hours| Life { hours: hours.min(until), ended: hours < until })
            .collect()
    }

    #[test]
    fn quantities_of_the_distribution() {
        let fit = fit_weibull(&drawn(0, 30, 2.0, 1000.0, 2000.0)).unwrap();
        assert!((fit.share(fit.life(0.1)) - 0.1).abs() < 1e-14);
        assert!((fit.share(fit.scale) - (1.0 - (-1.0_f64).exp())).abs() < 1e-14);
        assert_eq!(fit.ended + fit.survived, 30);
    }

    /// With β known to be 1 the distribution is exponential; the fit must be stationary in both parameters.
    #[test]
    fn the_likelihood_is_at_its_top() {
        for (count, until) in [(10, 1e9), (200, 900.0), (25, 600.0)] {
            let fit = fit_weibull(&drawn(3, count, 1.7, 1000.0, until)).unwrap();
            let around = |a: f64, b: f64| fit.log_likelihood_of(fit.shape * a, fit.scale * b);
            for (a, b) in [(1.001, 1.0), (0.999, 1.0), (1.0, 1.001), (1.0, 0.999), (1.001, 1.001)] {
                assert!(around(a, b) < fit.log_likelihood);
            }
            let slope = (around(1.0 + 1e-5, 1.0) - around(1.0 - 1e-5, 1.0)) / 2e-5;
            assert!(slope.abs() < 1e-4 * count as f64, "{slope}");
        }
    }

    /// B10 of 150 series of 40 machines, a third of them censored: the 90 % interval contains the true value in
    /// 90 % ± 4 standard errors (2.4 %).
    #[test]
    fn intervals_cover_what_they_promise() {
        let truth = 1000.0 * (-(0.9_f64.ln())).powf(0.5);
        let (mut life, mut shape) = (0, 0);
        for study in 0..150 {
            let fit = fit_weibull(&drawn(study, 40, 2.0, 1000.0, 1050.0)).unwrap();
            life += usize::from(fit.life_interval(0.1, 0.9).unwrap().contains(truth));
            shape += usize::from(fit.shape_interval(0.9).unwrap().contains(2.0));
        }
        assert!((121..=149).contains(&life) && (121..=149).contains(&shape), "{life} {shape}");
    }

    #[test]
    fn invalid_fits_are_refused_with_a_reason() {
        let life = |hours, ended| Life { hours, ended };
        let reason = |lives: &[Life]| fit_weibull(lives).unwrap_err().to_string();
        assert!(reason(&[life(5.0, true), life(9.0, false)]).contains("fewer than two"));
        assert!(reason(&[life(5.0, true); 3]).contains("equal"));
        assert!(reason(&[life(5.0, true), life(0.0, true)]).contains("positive"));
        // Two equal ends and a machine that continued: a fit exists.
        fit_weibull(&[life(5.0, true), life(5.0, true), life(9.0, false)]).unwrap();
    }
}
