//! Limits of the machines of a study: those of the study, and those of the design that the kept results can judge.

use serde_json::{Map, Value as Json, json};

use super::collect::Rows;
use super::plan::{Kept, Kind, Plan};
use super::statistics::{Batched, Limits, Yield, clopper_pearson};
use super::{Factor, StudyError};
use crate::analyses::Analysis;
use crate::analyses::life::LimitKind;
use crate::analyses::stage::AnyDesign;
use crate::design::Value;
use crate::results::Declared;

/// A limit with the result that judges it.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyLimit {
    /// Name for texts.
    pub name: String,
    /// Key of the result.
    pub result: String,
    /// Allowed range of the result.
    pub limits: Limits,
    /// Whether it is a limit of the design.
    pub of_design: bool,
}

/// All limits, and those of the design that the kept results cannot judge, with the missing result.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StudyLimits {
    /// Limits that the results can judge.
    pub each: Vec<StudyLimit>,
    /// Limits of the design that they cannot judge, each with a sentence about the missing result.
    pub unjudged: Vec<(String, String)>,
}

/// A limit of the design, the key that sets it, and the results of any analysis but `life` that it bounds.
struct Rule {
    kind: LimitKind,
    key: &'static str,
    /// Whether results must not be below it; otherwise not above.
    is_least: bool,
    results: &'static [&'static str],
}

const fn rule(kind: LimitKind, key: &'static str, results: &'static [&'static str]) -> Rule {
    Rule { kind, key, is_least: matches!(kind, LimitKind::BearingLife), results }
}

const RULES: &[Rule] = &[
    rule(LimitKind::LostMotion, "limits.lost_motion_arcmin", &["lost_motion_arcmin"]),
    rule(LimitKind::ContactPressure, "limits.contact_pressure_mpa", &["max_pressure_mpa"]),
    rule(LimitKind::BearingLife, "limits.service_life_h", &["shortest_bearing_life_h"]),
    rule(
        LimitKind::TransmissionError,
        "limits.transmission_error_arcmin",
        &["te_rated_peak_to_peak_arcmin", "te_loaded_peak_to_peak_arcmin"],
    ),
    rule(LimitKind::Backlash, "limits.backlash_arcmin", &["backlash_arcmin", "free_travel_arcmin"]),
    rule(LimitKind::StartStopTorque, "limits.start_stop_torque_n_m", &[]),
    rule(LimitKind::EmergencyTorque, "limits.emergency_torque_n_m", &[]),
    rule(LimitKind::OutputSpeed, "limits.output_speed_rpm", &[]),
    rule(LimitKind::CatalogueLife, "limits.catalogue_life_h", &[]),
    rule(LimitKind::ContactFatigue, "limits.contact_endurance_mpa", &[]),
];

/// Limits that end a life without a limit of their own in the design.
const WITHOUT_KEY: [LimitKind; 2] = [LimitKind::Wear, LimitKind::Findings];

/// Prefix of the results for one limit in the verdict of a life.
const OF_VERDICT: &str = "verdict.kept";

/// Whether a result is about one limit in the verdict of a life.
pub(super) fn is_flag(key: &str) -> bool {
    key.strip_prefix(OF_VERDICT).is_some_and(|rest| rest.starts_with('.'))
}

/// For each kind of limit whether it is kept for the service life, in the form that a study keeps. A kind that is not
/// in the list counts as kept.
pub(super) fn judged_limits(summary: &mut Map<String, Json>) {
    let service = summary.get("service_life_h").and_then(Json::as_f64).unwrap_or(0.0);
    let Some(Json::Object(verdict)) = summary.get_mut("verdict") else { return };
    let Some(Json::Array(limits)) = verdict.get("limits") else { return };
    let broken = |kind: &LimitKind| {
        let own = limits.iter().filter(|limit| limit["limit"] == kind.key());
        own.filter_map(|limit| limit["hours"].as_f64()).any(|hours| hours < service * (1.0 - 1e-9))
    };
    let kinds = RULES.iter().map(|rule| rule.kind).chain(WITHOUT_KEY);
    let kept: Map<String, Json> = kinds.map(|kind| (kind.key().to_owned(), json!(!broken(&kind)))).collect();
    verdict.insert("kept".to_owned(), Json::Object(kept));
}

/// Further results that a study of this analysis keeps, since they judge limits at no cost.
pub(super) fn kept_besides(analysis: &Analysis, design: &AnyDesign) -> Vec<Kept> {
    if analysis.name != "life" {
        return Vec::new();
    }
    let set = RULES.iter().filter(|rule| is_set(design, rule.key)).map(|rule| rule.kind);
    let key = |kind: LimitKind| format!("{OF_VERDICT}.{}", kind.key());
    set.chain(WITHOUT_KEY).map(|kind| Kept { key: key(kind), kind: Kind::Number }).collect()
}

fn is_set(design: &AnyDesign, key: &str) -> bool {
    design.get(key).is_ok_and(|value| value != Value::LeftOut)
}

impl StudyLimits {
    /// The limits of the study, and those of the design that the kept results can judge. A limit of the study takes
    /// precedence over that of the design; a varied limit is not judged.
    pub(super) fn of(
        own: &[(String, Limits)],
        analysis: &Analysis,
        declared: &Declared,
        design: &AnyDesign,
        kept: &[Kept],
        factors: &[Factor],
    ) -> StudyLimits {
        let each = own.iter().map(|(result, limits)| StudyLimit {
            name: super::page::words_of(result),
            result: result.clone(),
            limits: *limits,
            of_design: false,
        });
        let mut all = StudyLimits { each: each.collect(), unjudged: Vec::new() };
        if analysis.name == "life" {
            for flag in kept.iter().filter(|kept| is_flag(&kept.key)) {
                let word = flag.key.rsplit('.').next().unwrap_or_default();
                let kinds = RULES.iter().map(|rule| rule.kind).chain(WITHOUT_KEY);
                let known = kinds.into_iter().find(|kind| kind.key() == word);
                let name = known.map_or(word.to_owned(), |kind| kind.name().to_owned());
                all.each.push(StudyLimit {
                    name,
                    result: flag.key.clone(),
                    limits: Limits { low: Some(0.5), high: None },
                    of_design: true,
                });
            }
            return all;
        }
        for rule in RULES.iter().filter(|rule| is_set(design, rule.key)) {
            let name = rule.kind.name().to_owned();
            if factors.iter().any(|factor| factor.path == rule.key) {
                all.unjudged.push((name, format!("`{}` varies itself", rule.key)));
                continue;
            }
            let judges = |result: &&&str| kept.iter().any(|kept| kept.key == ***result);
            let offered = |result: &&&str| declared.summary.iter().any(|one| one.key == **result);
            match (rule.results.iter().find(judges), rule.results.iter().find(offered)) {
                (Some(result), _) if own.iter().any(|(key, _)| key == result) => {}
                (Some(result), _) => {
                    let bound = design.get(rule.key).ok().and_then(|value| value.as_number());
                    let (low, high) = if rule.is_least { (bound, None) } else { (None, bound) };
                    let limits = Limits { low, high };
                    let result = (*result).to_owned();
                    all.each.push(StudyLimit { name, result, limits, of_design: true });
                }
                (None, Some(result)) => all.unjudged.push((name, format!("add `{result}` to the results"))),
                (None, None) => all.unjudged.push((name, "use a study of `life`".to_owned())),
            }
        }
        all
    }

    /// Allowed values of a result.
    pub(super) fn of_result(&self, key: &str) -> Limits {
        let own = self.each.iter().find(|limit| limit.result == key);
        own.map_or(Limits { low: None, high: None }, |limit| limit.limits)
    }
}

/// Number of machines that keep a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeptBy {
    /// Machines that keep it.
    pub kept: usize,
    /// Machines judged, failed ones included.
    pub of: usize,
    /// Share with its interval, if the rows are draws.
    pub share: Option<Yield>,
}

/// Limits singly and together.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JudgedLimits {
    /// Limits with the machines that keep each.
    pub each: Vec<(StudyLimit, KeptBy)>,
    /// All of them; `None` where there are none.
    pub together: Option<KeptBy>,
    /// Limits of the design that the results cannot judge, each with a sentence about the missing result.
    pub unjudged: Vec<(String, String)>,
}

/// Counts the rows that keep each limit and all of them. A machine that failed, or has no value, keeps none.
///
/// # Errors
/// [`StudyError::Statistic`] as of [`clopper_pearson`].
pub(super) fn judge_limits(
    plan: &Plan,
    rows: &Rows,
    limits: &StudyLimits,
    tried: &[usize],
    confidence: f64,
    batch: Option<&dyn Fn(u64) -> u64>,
) -> Result<JudgedLimits, StudyError> {
    let are_draws = tried.iter().any(|index| plan.sampling().is_sample(rows.records[*index].number));
    let count = |keeps: &[bool]| -> Result<KeptBy, StudyError> {
        let kept = keeps.iter().filter(|kept| **kept).count();
        let share = match batch {
            _ if !are_draws => None,
            Some(batch) => {
                let flag = |(index, kept): (&usize, &bool)| {
                    (batch(rows.records[*index].number), f64::from(u8::from(*kept)))
                };
                let batched = Batched::of(tried.iter().zip(keeps).map(flag));
                Some(batched.kept(Limits { low: Some(0.5), high: None }, confidence)?)
            }
            None => Some(clopper_pearson(kept as u64, tried.len() as u64, confidence)?),
        };
        Ok(KeptBy { kept, of: tried.len(), share })
    };
    let mut all = vec![true; tried.len()];
    let mut each = Vec::new();
    for limit in &limits.each {
        let Some(values) = rows.numbers(plan, &limit.result) else { continue };
        let Limits { low, high } = limit.limits;
        let keeps: Vec<bool> = tried
            .iter()
            .map(|index| {
                values[*index].is_some_and(|value| {
                    low.is_none_or(|low| value >= low) && high.is_none_or(|high| value <= high)
                })
            })
            .collect();
        all.iter_mut().zip(&keeps).for_each(|(all, kept)| *all &= kept);
        each.push((limit.clone(), count(&keeps)?));
    }
    let together = if each.is_empty() { None } else { Some(count(&all)?) };
    Ok(JudgedLimits { each, together, unjudged: limits.unjudged.clone() })
}

impl KeptBy {
    fn to_json(self) -> Json {
        let share = self.share.map(|share| json!([share.low, share.high]));
        json!({
            "kept": self.kept, "of": self.of, "share": self.kept as f64 / self.of.max(1) as f64, "interval": share,
        })
    }
}

impl JudgedLimits {
    pub(super) fn to_json(&self) -> Json {
        let one = |(limit, kept): &(StudyLimit, KeptBy)| {
            let mut entry = kept.to_json();
            entry["limit"] = json!(limit.name);
            entry["result"] = json!(limit.result);
            if !is_flag(&limit.result) {
                entry["low"] = json!(limit.limits.low);
                entry["high"] = json!(limit.limits.high);
            }
            entry["from"] = json!(if limit.of_design { "design" } else { "study" });
            entry
        };
        let unjudged: Vec<Json> =
            self.unjudged.iter().map(|(limit, how)| json!({ "limit": limit, "how": how })).collect();
        json!({
            "each": self.each.iter().map(one).collect::<Vec<_>>(),
            "together": self.together.map(KeptBy::to_json),
            "not_judged": unjudged,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A limit reached before the service life is broken; one that is kept as long as was computed, one reached
    /// later, and one that the design has not, are kept.
    #[test]
    fn a_verdict_lists_its_limits() {
        let mut summary = json!({
            "service_life_h": 7500.0,
            "verdict": { "ok": false, "limits": [
                { "limit": "lost_motion", "hours": 9000.0 },
                { "limit": "contact_pressure", "hours": null },
                { "limit": "bearing_life", "hours": 4885.0 },
            ] },
        });
        let Json::Object(map) = &mut summary else { panic!() };
        judged_limits(map);
        let kept = &summary["verdict"]["kept"];
        for (key, expected) in [
            ("lost_motion", true),
            ("contact_pressure", true),
            ("bearing_life", false),
            ("backlash", true),
            ("findings", true),
        ] {
            assert_eq!(kept[key], expected, "{key}");
        }
    }

    /// Machines with two results, some failed: each limit and both together are counted as a hand would, and the
    /// interval of the share holds the truth that they were drawn from (95 %, two hundred studies of 40 machines).
    #[test]
    fn limits_are_counted_singly_and_together() {
        use crate::study::part::{Cell, Record};
        use crate::study::sampling::Layout;
        use crate::study::{Distribution, Purpose, Stream};
        let kept = ["a", "b"].map(|key| Kept { key: key.to_owned(), kind: Kind::Number }).to_vec();
        let factors = vec![Factor::number("x", "", Distribution::Uniform { low: 0.0, high: 1.0 })];
        let plan = Plan::new("test", factors, Layout::Random, 40, 1, kept).unwrap();
        let limit = |result: &str, low, high| StudyLimit {
            name: result.to_owned(),
            result: result.to_owned(),
            limits: Limits { low, high },
            of_design: true,
        };
        let limits = StudyLimits {
            each: vec![limit("a", None, Some(0.9)), limit("b", Some(0.2), None)],
            unjudged: Vec::new(),
        };
        let truth = 0.9 * 0.8 * 0.95;
        let mut held = 0;
        for trial in 0..200 {
            let mut stream = Stream::new(5, Purpose::Resamples, trial);
            let record = |number: u64| {
                let (a, b, fails) = (stream.unit(), stream.unit(), stream.unit() < 0.05);
                let value = |x: f64| if fails { Cell::Absent } else { Cell::Number(x) };
                let cells = vec![Cell::Number(0.5), value(a), value(b)];
                (Record { number, cells, failed: fails.then(|| "jams".to_owned()) }, (a, b, fails))
            };
            let (records, drawn): (Vec<Record>, Vec<(f64, f64, bool)>) = (0..40).map(record).unzip();
            let rows = Rows { records, of: 40, unusable: Vec::new() };
            let tried: Vec<usize> = (0..40).collect();
            let judged = judge_limits(&plan, &rows, &limits, &tried, 0.95, None).unwrap();
            let count = |keeps: fn(&(f64, f64, bool)) -> bool| drawn.iter().filter(|one| keeps(one)).count();
            assert_eq!(judged.each[0].1.kept, count(|(a, _, fails)| *a <= 0.9 && !fails));
            assert_eq!(judged.each[1].1.kept, count(|(_, b, fails)| *b >= 0.2 && !fails));
            let together = judged.together.unwrap();
            assert_eq!(together.kept, count(|(a, b, fails)| *a <= 0.9 && *b >= 0.2 && !fails));
            held += u32::from(together.share.is_some_and(|share| share.low <= truth && truth <= share.high));
        }
        // Clopper and Pearson's interval contains the true value at least with its confidence: 190 less three deviations of 3.1.
        assert!(held >= 181, "{held} of 200");
    }
}
