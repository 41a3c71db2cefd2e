//! Findings from the rows of a study: limits kept, spread, lives, sensitivities.

use serde_json::{Value as Json, json};

use super::collect::Rows;
use super::limits::{JudgedLimits, StudyLimits, is_flag, judge_limits};
use super::plan::{Kind, Plan};
use super::sampling::Layout;
use super::sensitivity::morris::{Effects, morris};
use super::sensitivity::regression::{Linear, linear};
use super::sensitivity::sobol::{Indices, sobol};
use super::sensitivity::tighten::{Gains, tighten};
use super::statistics::{
    Batched, BetweenBatches, Bootstrap, Capability, Interval, Life, Limits, Normality, Quantile, Sides,
    ToleranceLimits, Weibull, Yield, clopper_pearson, fit_weibull, normality, quantile,
    sorted_finite_or_infinite, tolerance_limits,
};
use super::{Distribution, StudyError};

/// Shares whose quantiles are reported.
pub const SHARES: [f64; 5] = [0.05, 0.1, 0.5, 0.9, 0.95];
/// The quantile for the gain of tightening.
pub const TIGHTEN_SHARE: f64 = 0.95;

/// Findings of a study from its available rows.
#[derive(Debug, Clone)]
pub struct Judged {
    /// Rows that are there.
    pub rows: usize,
    /// Rows of the plan.
    pub of: u64,
    /// Share of draws that cannot be assembled, jam or cannot be computed.
    pub failed: Yield,
    /// Reasons with their numbers, the most frequent first.
    pub reasons: Vec<(String, usize)>,
    /// Share of draws with a negative mean play (preloaded or jammed), if the play is kept.
    pub tight: Option<Yield>,
    /// Confidence of all intervals, between 0 and 1.
    pub confidence: f64,
    /// Machines that keep the limits.
    pub limits: JudgedLimits,
    /// Findings result by result.
    pub results: Vec<JudgedResult>,
}

/// Findings of a study about one result.
#[derive(Debug, Clone)]
pub struct JudgedResult {
    /// Key of the result.
    pub key: String,
    /// Rows with a value.
    pub count: usize,
    /// Rows without a value although they did not fail.
    pub absent: usize,
    /// Least and largest value.
    pub range: [f64; 2],
    /// Spread of samples of the distribution; `None` for other layouts (grid, trajectories).
    pub spread: Option<Spread>,
    /// Allowed range; open without a limit.
    pub limits: Limits,
    /// Share of all draws that keep the limits; failed ones do not.
    pub kept: Option<Yield>,
    /// Capability; `None` without limits or without samples of the distribution.
    pub capability: Option<Capability>,
    /// Lives, where the result is one.
    pub weibull: Option<Weibull>,
    /// Which keys the result depends on.
    pub sensitivity: Sensitivity,
    /// Share of the variance between batches, if there are batches.
    pub batches: Option<BetweenBatches>,
}

/// How a result is spread.
#[derive(Debug, Clone)]
pub struct Spread {
    /// Mean of the values.
    pub mean: f64,
    /// Standard deviation (n − 1).
    pub deviation: f64,
    /// Quantiles with their intervals.
    pub quantiles: Vec<Quantile>,
    /// Band for 95 % of all machines, if there are enough.
    pub band: Option<ToleranceLimits>,
    /// Test against a normal distribution; `None` for too few values.
    pub normality: Option<Normality>,
}

/// Sensitivity of a result, by the method that the rows allow.
#[derive(Debug, Clone)]
pub enum Sensitivity {
    /// Elementary effects, key by key.
    Morris(Vec<Effects>),
    /// First and total shares of the variance.
    Sobol(Indices),
    /// Effect of tightening each tolerance.
    Tighten(Gains),
    /// Shares of the variance by a linear fit.
    Linear(Linear),
    /// Not known, with the reason.
    None(String),
}

/// Judges all results that are numbers, and the limits; `batch` gives the batch of a row, if there are batches.
///
/// # Errors
/// [`StudyError::Statistic`] if there are no rows, or for a confidence outside (0, 1).
pub fn judge(
    plan: &Plan,
    rows: &Rows,
    limits: &StudyLimits,
    confidence: f64,
    batch: Option<&dyn Fn(u64) -> u64>,
) -> Result<Judged, StudyError> {
    let drawn: Vec<usize> = (0..rows.records.len())
        .filter(|index| plan.sampling().is_sample(rows.records[*index].number))
        .collect();
    // Grids and trajectories are no draws, but all of them may fail.
    let tried: Vec<usize> = if drawn.is_empty() { (0..rows.records.len()).collect() } else { drawn.clone() };
    let failures = tried.iter().filter(|index| rows.records[**index].failed.is_some()).count();
    let failed = clopper_pearson(failures as u64, tried.len() as u64, confidence)?;
    let mut reasons: Vec<(String, usize)> = Vec::new();
    // Reasons that differ only in their numbers are grouped; the first is shown.
    let kind =
        |reason: &str| reason.replace(|c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '−'), "");
    for reason in tried.iter().filter_map(|index| rows.records[*index].failed.as_ref()) {
        match reasons.iter_mut().find(|(known, _)| kind(known) == kind(reason)) {
            Some((_, count)) => *count += 1,
            None => reasons.push((reason.clone(), 1)),
        }
    }
    reasons.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    let play = rows.numbers(plan, PLAY).filter(|_| !drawn.is_empty());
    let tight = play.map(|play| {
        let plays: Vec<f64> = drawn.iter().filter_map(|index| play[*index]).collect();
        // A flank without modification has zero play up to rounding and does not count as tight.
        let tight = plays.iter().filter(|play| **play < -NO_PLAY_ARCMIN).count();
        clopper_pearson(tight as u64, plays.len() as u64, confidence)
    });
    let batch_of = |index: usize| batch.map(|batch| batch(rows.records[index].number));
    let searched = rows.numbers(plan, super::file::SEARCHED);
    let mut results = Vec::new();
    for kept in plan.kept().iter().filter(|kept| kept.kind != Kind::Curve && !is_flag(&kept.key)) {
        let Some(mut values) = rows.numbers(plan, &kept.key) else { continue };
        let found = values.clone();
        if let Some(searched) = searched.as_ref().filter(|_| is_life(&kept.key)) {
            // A life that did not end is longer than any that did.
            for ((value, searched), record) in values.iter_mut().zip(searched).zip(&rows.records) {
                if value.is_none() && searched.is_some() && record.failed.is_none() {
                    *value = Some(f64::INFINITY);
                }
            }
        }
        let all: Vec<f64> = found.iter().flatten().copied().collect();
        let sampled: Vec<f64> = drawn.iter().filter_map(|index| values[*index]).collect();
        if all.is_empty() {
            continue;
        }
        let limits = limits.of_result(&kept.key);
        // A machine that failed has no value, and keeps no limit.
        let batched = batch.map(|_| {
            let value = |index: &usize| Some((batch_of(*index)?, values[*index].unwrap_or(f64::NAN)));
            Batched::of(drawn.iter().filter_map(value))
        });
        let complete = batched.as_ref().map(|batched| {
            let some = |batch: &Vec<f64>| batch.iter().copied().filter(|x| !x.is_nan()).collect();
            Batched(batched.0.iter().map(some).filter(|batch: &Vec<f64>| !batch.is_empty()).collect())
        });
        let limited = limits.low.is_some() || limits.high.is_some();
        let keeps = |value: &&f64| {
            limits.low.is_none_or(|low| **value >= low) && limits.high.is_none_or(|high| **value <= high)
        };
        let yield_of = |kept: usize| clopper_pearson(kept as u64, drawn.len() as u64, confidence);
        let lives = searched.as_ref().filter(|_| is_life(&kept.key)).map(|searched| {
            drawn
                .iter()
                .filter(|index| rows.records[**index].failed.is_none())
                .filter_map(|index| match (found[*index], searched[*index]) {
                    (Some(hours), _) => Some(Life { hours, ended: true }),
                    (None, Some(hours)) => Some(Life { hours, ended: false }),
                    (None, None) => None,
                })
                .collect::<Vec<_>>()
        });
        results.push(JudgedResult {
            key: kept.key.clone(),
            count: all.len(),
            absent: rows.records.len() - rows.failed() - all.len(),
            range: all
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)]),
            spread: if sampled.len() < 2 {
                None
            } else {
                Some(spread(&sampled, complete.as_ref(), confidence)?)
            },
            limits,
            kept: match &batched {
                _ if !limited || drawn.is_empty() => None,
                Some(batched) => Some(batched.kept(limits, confidence)?),
                None => Some(yield_of(sampled.iter().filter(keeps).count())?),
            },
            // The intervals of capability assume independent machines.
            capability: (limited && batch.is_none())
                .then(|| Capability::of(&sampled, limits, confidence).ok())
                .flatten(),
            weibull: lives.and_then(|lives| fit_weibull(&lives).ok()),
            sensitivity: sensitivity(plan, rows, &kept.key, confidence)
                .unwrap_or_else(|error| Sensitivity::None(error.to_string())),
            batches: complete.and_then(|complete| complete.between(again(confidence)).ok()),
        });
    }
    Ok(Judged {
        rows: rows.records.len(),
        of: rows.of,
        failed,
        reasons,
        tight: tight.and_then(Result::ok),
        confidence,
        limits: judge_limits(plan, rows, limits, &tried, confidence, batch)?,
        results,
    })
}

/// Whether a result is a life, which may end beyond the search.
pub(super) fn is_life(key: &str) -> bool {
    key.starts_with("hours_to")
}

/// Result that shows whether a machine is free.
const PLAY: &str = "play_arcmin";
/// Below any measurement.
const NO_PLAY_ARCMIN: f64 = 1e-3;

fn again(confidence: f64) -> Bootstrap {
    Bootstrap { resamples: 400, confidence, seed: 0 }
}

fn spread(values: &[f64], batches: Option<&Batched>, confidence: f64) -> Result<Spread, StudyError> {
    let sorted = sorted_finite_or_infinite(values)?;
    let n = sorted.len() as f64;
    let mean = sorted.iter().sum::<f64>() / n;
    let deviation = (sorted.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let mut quantiles: Vec<Quantile> =
        SHARES.iter().map(|share| quantile(&sorted, *share, confidence)).collect::<Result<_, _>>()?;
    if let Some(batches) = batches {
        let intervals = batches.quantiles(&SHARES, again(confidence))?;
        quantiles.iter_mut().zip(intervals).for_each(|(quantile, interval)| quantile.interval = interval);
    }
    // Order statistics assume independent machines.
    let band = match batches {
        Some(_) => None,
        None => tolerance_limits(&sorted, 0.95, confidence, Sides::Two)?,
    };
    Ok(Spread { mean, deviation, quantiles, band, normality: normality(&sorted).ok() })
}

fn sensitivity(plan: &Plan, rows: &Rows, key: &str, confidence: f64) -> Result<Sensitivity, StudyError> {
    let bootstrap = again(confidence);
    let none = || StudyError::Statistic { reason: "there is no such result" };
    let in_place = || rows.in_place(plan, key).ok_or_else(none);
    let dimensions = plan.factors().len();
    Ok(match plan.sampling().layout() {
        Layout::Morris { levels } => {
            let units: Vec<Vec<f64>> = (0..plan.rows()).map(|row| plan.sampling().point(row).unit).collect();
            Sensitivity::Morris(morris(&units, &in_place()?, *levels, bootstrap)?)
        }
        Layout::Saltelli { second_order } => {
            Sensitivity::Sobol(sobol(&in_place()?, dimensions, *second_order, bootstrap)?)
        }
        Layout::Tighten { .. } => {
            Sensitivity::Tighten(tighten(&in_place()?, dimensions, TIGHTEN_SHARE, bootstrap)?)
        }
        _ => {
            // Uses places in the unit interval for values, which are also uniform for logarithms; drawn machines and
            // words have no direction.
            let ordered: Vec<usize> = (0..dimensions)
                .filter(|d| {
                    let distribution = plan.factors()[*d].distribution;
                    !matches!(distribution, Distribution::Drawn | Distribution::List { .. })
                })
                .collect();
            if ordered.is_empty() {
                return Err(StudyError::Statistic { reason: "nothing varies that has a direction" });
            }
            let inputs: Vec<Vec<f64>> = rows
                .records
                .iter()
                .map(|record| {
                    let unit = plan.sampling().point(record.number).unit;
                    (0..dimensions).map(|d| if ordered.contains(&d) { unit[d] } else { 0.0 }).collect()
                })
                .collect();
            Sensitivity::Linear(linear(&inputs, &rows.numbers(plan, key).ok_or_else(none)?, bootstrap)?)
        }
    })
}

impl Judged {
    /// As JSON, by the key of the result: content of `summary.json` of a study.
    pub fn to_json(&self, plan: &Plan) -> Json {
        let ends = |interval: &Interval| json!([interval.low, interval.high]);
        let names: Vec<&str> = plan.factors().iter().map(|factor| factor.path.as_str()).collect();
        let result = |r: &JudgedResult| {
            let mut entry = json!({
                "count": r.count, "absent": r.absent, "min": r.range[0], "max": r.range[1],
            });
            if let Some(spread) = &r.spread {
                entry["mean"] = json!(spread.mean);
                entry["deviation"] = json!(spread.deviation);
                let quantiles = spread
                    .quantiles
                    .iter()
                    .map(|q| json!({ "share": q.share, "value": q.estimate, "interval": ends(&q.interval) }));
                entry["quantiles"] = quantiles.collect();
                entry["band"] = spread.band.as_ref().map_or(Json::Null, |band| {
                    json!({
                        "coverage": band.coverage, "confidence": band.confidence,
                        "low": band.low, "high": band.high,
                    })
                });
                entry["normality_p"] = json!(spread.normality.map(|n| n.p_value));
            }
            if let Some(kept) = &r.kept {
                entry["yield"] = json!({
                    "kept": kept.kept, "of": kept.of, "share": kept.share, "interval": [kept.low, kept.high],
                });
            }
            if let Some(c) = &r.capability {
                entry["cp"] = json!(c.cp.map(|(cp, _)| cp));
                entry["cp_interval"] = c.cp.map_or(Json::Null, |(_, interval)| ends(&interval));
                entry["cpk"] = json!(c.cpk);
                entry["cpk_interval"] = ends(&c.cpk_interval);
            }
            if let Some(w) = &r.weibull {
                let life = |share: f64| {
                    let interval = w.life_interval(share, self.confidence).ok();
                    json!({ "hours": w.life(share), "interval": interval.as_ref().map_or(Json::Null, ends) })
                };
                entry["weibull"] = json!({
                    "shape": w.shape, "scale": w.scale, "ended": w.ended, "survived": w.survived,
                    "b10": life(0.1), "b50": life(0.5),
                });
            }
            if let Some(batches) = &r.batches {
                entry["batches"] = json!({
                    "batches": batches.batches, "share_between": batches.share,
                    "interval": ends(&batches.interval), "effective_machines": batches.effective,
                });
            }
            entry["sensitivity"] = r.sensitivity.to_json(&names);
            (r.key.clone(), entry)
        };
        let reason = |(why, count): &(String, usize)| json!({ "reason": why, "count": count });
        let reasons: Vec<Json> = self.reasons.iter().map(reason).collect();
        json!({
            "limits": self.limits.to_json(),
            "rows": self.rows, "of": self.of, "confidence": self.confidence,
            "failed": {
                "count": self.failed.kept, "of": self.failed.of, "share": self.failed.share,
                "interval": [self.failed.low, self.failed.high],
                "reasons": reasons,
            },
            "tight": self.tight.map(|tight| json!({
                "count": tight.kept, "of": tight.of, "share": tight.share,
                "interval": [tight.low, tight.high],
            })),
            "results": self.results.iter().map(result).collect::<serde_json::Map<_, _>>(),
        })
    }
}

impl Sensitivity {
    fn to_json(&self, names: &[&str]) -> Json {
        let ends = |interval: &Interval| json!([interval.low, interval.high]);
        match self {
            Sensitivity::Morris(effects) => {
                let one = |(name, e): (&&str, &Effects)| {
                    json!({
                        "key": name, "mu": e.mu, "mu_star": e.mu_star.value,
                        "mu_star_interval": ends(&e.mu_star.interval), "contains_zero": e.mu_star.interval.contains(0.0), "sigma": e.sigma,
                    })
                };
                json!({ "kind": "morris", "keys": names.iter().zip(effects).map(one).collect::<Vec<_>>() })
            }
            Sensitivity::Sobol(indices) => {
                let keys: Vec<Json> = names
                    .iter()
                    .zip(indices.first.iter().zip(&indices.total))
                    .map(|(name, (first, total))| {
                        json!({
                            "key": name, "first": first.value, "first_interval": ends(&first.interval),
                            "total": total.value, "total_interval": ends(&total.interval), "contains_zero": total.interval.contains(0.0),
                        })
                    })
                    .collect();
                let pairs: Vec<Json> = indices
                    .second
                    .iter()
                    .map(|(i, j, s)| {
                        json!({ "keys": [names[*i], names[*j]], "share": s.value, "interval": ends(&s.interval) })
                    })
                    .collect();
                json!({
                    "kind": "sobol", "keys": keys, "pairs": pairs, "used": indices.used, "left_out": indices.left_out,
                })
            }
            Sensitivity::Tighten(gains) => {
                let keys: Vec<Json> = gains
                    .gains
                    .iter()
                    .map(|gain| {
                        json!({
                            "key": names[gain.dimension], "quantile_gain": gain.quantile.value,
                            "quantile_gain_interval": ends(&gain.quantile.interval), "contains_zero": gain.quantile.interval.contains(0.0),
                            "mean_gain": gain.mean.value, "deviation_gain": gain.deviation.value,
                        })
                    })
                    .collect();
                json!({
                    "kind": "tighten", "quantile": TIGHTEN_SHARE, "value": gains.quantile, "keys": keys,
                    "used": gains.used, "left_out": gains.left_out,
                })
            }
            Sensitivity::Linear(fit) => {
                let keys: Vec<Json> = names
                    .iter()
                    .zip(fit.shares.iter().zip(&fit.coefficients))
                    .map(|(name, (share, coefficient))| {
                        json!({
                            "key": name, "share": share.value, "interval": ends(&share.interval), "contains_zero": share.interval.contains(0.0),
                            "coefficient": coefficient,
                        })
                    })
                    .collect();
                json!({ "kind": "linear", "r_squared": fit.r_squared, "keys": keys, "rows": fit.rows })
            }
            Sensitivity::None(why) => json!({ "kind": "none", "reason": why }),
        }
    }
}
