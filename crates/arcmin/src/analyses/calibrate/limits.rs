//! Remaining hours of a measured machine to each of its limits.

use super::drive::CalibratedDrive;
use crate::analyses::life::{LifeVerdict, Limit, LimitKind, WEIBULL_SLOPE};
use crate::analyses::stage::AnyDesign;
use crate::analyses::{AnalysisError, Host};
use crate::design::Value;
use crate::report::{compact, significant};
use crate::wear::CONFIDENCE;

/// One limit of one machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Remaining {
    /// The limit.
    pub kind: LimitKind,
    /// Which part, where there are several.
    pub place: Option<String>,
    /// Name in the file; `None` for the prediction of the design.
    pub machine: Option<String>,
    /// In the unit of the kind.
    pub allowed: f64,
    /// Hours of the last reading, from which the remaining hours are counted.
    pub now_h: f64,
    /// Hours since new up to which it was searched.
    pub searched_h: f64,
    /// Hours at which it is reached, with their band.
    pub end: End,
}

/// When a limit is reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// Hours since new with the ends of their band; `None` beyond the computed hours.
    At {
        /// Hours at the best fit.
        hours: Option<f64>,
        /// Lower end of the 95 % band.
        low: Option<f64>,
        /// Upper end of the 95 % band.
        high: Option<f64>,
    },
    /// A rating life in h, which 90 % reach.
    Rated(f64),
}

/// Share of parts that reach their rating life.
const RATED: f64 = 0.9;

/// Share of parts with this rating life that still run after these hours: R = 0.9^((t/L10)^e).
pub fn survival(life_h: f64, hours: f64) -> f64 {
    RATED.powf((hours / life_h).powf(WEIBULL_SLOPE))
}

/// Hours since new after which `share` of the parts still run that run after `now` hours: R(t)/R(now) = share, so
/// t^e = now^e + L10^e ln(share)/ln(0.9).
pub fn conditional_life(life_h: f64, now: f64, share: f64) -> f64 {
    let beyond = life_h.powf(WEIBULL_SLOPE) * share.ln() / RATED.ln();
    (now.powf(WEIBULL_SLOPE) + beyond).powf(1.0 / WEIBULL_SLOPE)
}

impl Remaining {
    /// Hours since new at which it is reached; of a rating life the hours that 90 % of those running now reach.
    pub fn hours(&self) -> Option<f64> {
        match self.end {
            End::At { hours, .. } => hours,
            End::Rated(life_h) => Some(conditional_life(life_h, self.now_h, RATED)),
        }
    }

    /// Remaining hours; 0 if the limit is exceeded, `None` if its end is beyond the computed hours.
    pub fn left(&self) -> Option<f64> {
        self.hours().map(|hours| (hours - self.now_h).max(0.0))
    }

    /// Ends of the 95 % band of the remaining hours; an end is `None` if unbounded.
    pub fn band(&self) -> (Option<f64>, Option<f64>) {
        let left = |hours: f64| (hours - self.now_h).max(0.0);
        match self.end {
            End::At { low, high, .. } => (low.map(left), high.map(left)),
            End::Rated(life_h) => {
                let tail = 0.5 * (1.0 - CONFIDENCE);
                let at = |share: f64| Some(left(conditional_life(life_h, self.now_h, share)));
                (at(1.0 - tail), at(tail))
            }
        }
    }

    /// Rating life in h of a new part, if the limit is a rating life.
    pub fn rated(&self) -> Option<f64> {
        match self.end {
            End::Rated(life_h) => Some(life_h),
            End::At { .. } => None,
        }
    }

    /// Share of such parts that run up to the last reading.
    pub fn survived_share(&self) -> Option<f64> {
        self.rated().map(|life_h| survival(life_h, self.now_h))
    }

    /// Whether it was reached before the last reading.
    pub fn is_over(&self) -> bool {
        matches!(self.end, End::At { hours: Some(hours), .. } if hours <= self.now_h)
    }

    /// A sentence: since when the limit is exceeded, or how long it is still kept.
    pub fn sentence(&self) -> String {
        let name = match &self.place {
            Some(place) => format!("{} ({place})", self.kind.name()),
            None => self.kind.name().to_owned(),
        };
        let unit = self.kind.unit();
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let allowed = format!("{}{unit}", compact(self.allowed, 4));
        let range = match self.band() {
            (Some(low), Some(high)) => format!(" (95 % band {} to {} h)", rounded(low), rounded(high)),
            (Some(low), None) => format!(" ({} h at least)", rounded(low)),
            _ => String::new(),
        };
        match self.end {
            End::Rated(life_h) => self.survived(&name, life_h),
            End::At { hours: None, .. } => {
                let at_least = (self.searched_h - self.now_h).max(0.0);
                format!("{name} stays within {allowed} for {} h more at least", rounded(at_least))
            }
            End::At { hours: Some(hours), .. } if hours <= 0.0 => {
                format!("{name}: {allowed} passed since new")
            }
            End::At { hours: Some(hours), low, high, .. } if self.is_over() => {
                let band = match (low, high) {
                    (Some(low), Some(high)) => {
                        format!(" (95 % band {} to {} h)", rounded(low), rounded(high))
                    }
                    _ => String::new(),
                };
                format!("{name}: {allowed} passed since {} h of running{band}", rounded(hours))
            }
            End::At { hours: Some(hours), .. } => format!(
                "{name} reaches {allowed} in {} h{range}, {} h after new",
                rounded(hours - self.now_h),
                rounded(hours)
            ),
        }
    }

    /// A sentence about a part with a rating life that still runs.
    fn survived(&self, name: &str, life_h: f64) -> String {
        let left = rounded(conditional_life(life_h, self.now_h, RATED) - self.now_h);
        let kept = survival(life_h, self.now_h);
        let rated = if life_h <= self.now_h {
            format!("rated {life_h:.0} h (L10), passed since {life_h:.0} h of running")
        } else {
            format!("rated {life_h:.0} h (L10)")
        };
        format!(
            "{name}: {rated}; {} % of such parts run for {:.0} h, and nine of ten of these run {left} h more",
            significant(100.0 * kept, 2),
            self.now_h
        )
    }
}

/// Hours rounded to their accuracy.
pub(super) fn rounded(hours: f64) -> String {
    if hours.abs() < 1000.0 { format!("{hours:.0}") } else { format!("{:.0}", (hours / 10.0).round() * 10.0) }
}

/// Limits predicted for the design with the fitted coefficient.
///
/// # Errors
/// [`AnalysisError`] of the prediction.
pub(super) fn judged(
    calibrated: &AnyDesign,
    drive: &impl CalibratedDrive,
    hours: f64,
    host: &dyn Host,
) -> Result<LifeVerdict, AnalysisError> {
    let service = calibrated.limits().service_life / crate::units::HOUR;
    // Beyond the last reading, so that the limits after it are found.
    let design = calibrated.with("limits.service_life_h", Value::Number(service.max(1.5 * hours)))?;
    drive.verdict(&design, host)
}

/// A limit of the verdict at the last reading of a machine, with the planned and the searched hours. `again` converts
/// hours at the fitted coefficient into hours at the ends of its band.
pub(super) fn remaining(
    limit: &Limit,
    machine: Option<String>,
    (now_h, service_h, searched_h): (f64, f64, f64),
    again: impl Fn(f64) -> Option<(Option<f64>, Option<f64>)>,
) -> Remaining {
    let end = match limit.kind {
        LimitKind::BearingLife | LimitKind::CatalogueLife => End::Rated(limit.value),
        _ => {
            let band = limit.hours.and_then(again);
            End::At {
                hours: limit.hours,
                low: band.and_then(|(low, _)| low),
                high: band.and_then(|(_, high)| high),
            }
        }
    };
    let allowed = if matches!(end, End::Rated(_)) { service_h } else { limit.allowed };
    Remaining { kind: limit.kind, place: limit.place.clone(), machine, allowed, now_h, searched_h, end }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// New parts: the rating life itself. Parts that run: by the definition R(t)/R(now) = 0.9; the exponential law
    /// would leave the rating life again whatever the age, a slope of 9/8 a little less.
    #[test]
    fn survival_is_conditional() {
        assert!((conditional_life(4885.0, 0.0, RATED) - 4885.0).abs() < 1e-9);
        for now in [100.0, 5200.0, 50_000.0] {
            let t = conditional_life(4885.0, now, RATED);
            assert!((survival(4885.0, t) / survival(4885.0, now) - RATED).abs() < 1e-12, "{now}");
            assert!(t - now < 4885.0 && t > now, "{now} {t}");
        }
        let end = |end: End| Remaining {
            kind: LimitKind::BearingLife,
            place: Some("turning arm".into()),
            machine: None,
            allowed: 7500.0,
            now_h: 5200.0,
            searched_h: 7500.0,
            end,
        };
        let rated = end(End::Rated(4885.0));
        let (low, high) = rated.band();
        assert!(low.unwrap() < rated.left().unwrap() && rated.left().unwrap() < high.unwrap());
        assert!(!rated.is_over() && rated.sentence().contains("passed since 4885 h"), "{}", rated.sentence());
    }

    /// Drawn lives that outlast a time: nine of ten outlast the conditional life (20 000 draws, five deviations).
    #[test]
    fn nine_of_ten_survivors_reach_the_conditional_life() {
        let (life_h, now) = (4885.0, 5200.0);
        let end = conditional_life(life_h, now, RATED);
        let (mut running, mut reached) = (0_u32, 0_u32);
        for index in 0..60_000 {
            // The inverse of R at an even sequence.
            let share = (f64::from(index) + 0.5) / 60_000.0;
            let drawn = life_h * (share.ln() / RATED.ln()).powf(1.0 / WEIBULL_SLOPE);
            running += u32::from(drawn > now);
            reached += u32::from(drawn > end);
        }
        assert!((f64::from(reached) / f64::from(running) - RATED).abs() < 1e-3, "{reached} of {running}");
    }
}
