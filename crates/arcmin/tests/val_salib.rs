//! Statistics of studies against SALib 1.6 and scipy 1.17 on the same numbers:
//! `validation/SALib2025/make_reference.py` made the reference.

use arcmin::study::sensitivity::{morris::morris, sobol::sobol};
use arcmin::study::statistics::{Bootstrap, Life, clopper_pearson, fit_weibull, normality};
use serde_json::Value;

const REFERENCE: &str = include_str!("../../../validation/SALib2025/reference.json");
/// The same sums in another order; results of about a thousand with a deviation of three lose four digits by
/// their mean.
const SAME_FORMULA: f64 = 1e-9;

fn cases(kind: &str) -> Vec<Value> {
    let all: Value = serde_json::from_str(REFERENCE).unwrap();
    all[kind].as_array().unwrap().clone()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn results(case: &Value) -> Vec<Option<f64>> {
    numbers(&case["results"]).into_iter().map(Some).collect()
}

fn agree(what: &str, ours: impl IntoIterator<Item = f64>, theirs: &Value) {
    let ours: Vec<f64> = ours.into_iter().collect();
    let theirs = numbers(theirs);
    assert_eq!(ours.len(), theirs.len(), "{what}");
    let largest = theirs.iter().fold(0.0_f64, |all, x| all.max(x.abs()));
    for (a, b) in ours.iter().zip(&theirs) {
        assert!((a - b).abs() <= SAME_FORMULA * largest.max(1.0), "{what}: {a:e}, reference {b:e}");
    }
}

/// The widths of bootstrap intervals depend on the draws; both programs use 100 to 1000 of them.
fn agree_in_width<'a>(
    what: &str,
    ours: impl IntoIterator<Item = &'a arcmin::study::sensitivity::Estimate>,
    theirs: &Value,
) {
    let theirs = numbers(theirs);
    let largest = theirs.iter().fold(0.0_f64, |all, x| all.max(*x));
    for (ours, theirs) in ours.into_iter().zip(theirs) {
        let half = 0.5 * (ours.interval.high.unwrap() - ours.interval.low.unwrap());
        assert!(
            (half - theirs).abs() < 0.3 * theirs + 0.02 * largest,
            "{what}: ± {half}, reference ± {theirs}"
        );
    }
}

#[test]
fn val_salib_sobol() {
    for case in cases("sobol") {
        let name = case["name"].as_str().unwrap();
        let dimensions = case["dimensions"].as_u64().unwrap() as usize;
        let second_order = case["second_order"].as_bool().unwrap();
        let indices = sobol(&results(&case), dimensions, second_order, Bootstrap::default()).unwrap();
        agree(name, indices.first.iter().map(|s| s.value), &case["first"]);
        agree(name, indices.total.iter().map(|s| s.value), &case["total"]);
        if second_order {
            agree(name, indices.second.iter().map(|(.., s)| s.value), &case["second"]);
        }
        agree_in_width(name, &indices.first, &case["first_half_width"]);
        agree_in_width(name, &indices.total, &case["total_half_width"]);
    }
}

#[test]
fn val_salib_morris() {
    for case in cases("morris") {
        let name = case["name"].as_str().unwrap();
        let units: Vec<Vec<f64>> = case["units"].as_array().unwrap().iter().map(numbers).collect();
        let levels = case["levels"].as_u64().unwrap() as usize;
        // SALib's places come back from trade units with a last digit of their own.
        let step = 1.0 / (levels as f64 - 1.0);
        let units: Vec<Vec<f64>> =
            units.iter().map(|row| row.iter().map(|u| (u / step).round() * step).collect()).collect();
        let effects = morris(&units, &results(&case), levels, Bootstrap::default()).unwrap();
        agree(name, effects.iter().map(|e| e.mu), &case["mu"]);
        agree(name, effects.iter().map(|e| e.mu_star.value), &case["mu_star"]);
        agree(name, effects.iter().map(|e| e.sigma), &case["sigma"]);
        let stars: Vec<_> = effects.iter().map(|e| e.mu_star).collect();
        agree_in_width(name, &stars, &case["mu_star_half_width"]);
    }
}

#[test]
fn val_scipy_clopper_pearson() {
    for case in cases("clopper_pearson") {
        let number = |key: &str| case[key].as_f64().unwrap();
        let (kept, of) = (case["kept"].as_u64().unwrap(), case["of"].as_u64().unwrap());
        let ours = clopper_pearson(kept, of, number("confidence")).unwrap();
        let close = (ours.low - number("low")).abs() < 1e-10 && (ours.high - number("high")).abs() < 1e-10;
        assert!(close, "{ours:?} {case}");
    }
}

/// scipy's optimisers stop where the likelihood no longer changes in its last digits, 1e-7 of a parameter
/// away.
#[test]
fn val_scipy_weibull() {
    for case in cases("weibull") {
        let hours = numbers(&case["hours"]);
        let ended = case["ended"].as_array().unwrap().iter().map(|e| e.as_bool().unwrap());
        let lives: Vec<Life> =
            hours.into_iter().zip(ended).map(|(hours, ended)| Life { hours, ended }).collect();
        let fit = fit_weibull(&lives).unwrap();
        let same = |ours: f64, theirs: &Value, tolerance: f64| {
            let theirs = theirs.as_f64().unwrap();
            assert!((ours / theirs - 1.0).abs() < tolerance, "{ours} {theirs}");
        };
        same(fit.shape, &case["shape"], 1e-6);
        same(fit.scale, &case["scale"], 1e-6);
        same(fit.log_likelihood, &case["log_likelihood"], 1e-10);
        for life in case["lives"].as_array().unwrap() {
            let share = life["share"].as_f64().unwrap();
            same(fit.life(share), &life["life"], 1e-6);
            let interval = fit.life_interval(share, 0.95).unwrap();
            same(interval.low.unwrap(), &life["low"], 1e-6);
            same(interval.high.unwrap(), &life["high"], 1e-6);
        }
    }
}

#[test]
fn val_scipy_anderson_darling() {
    for case in cases("anderson_darling") {
        let ours = normality(&numbers(&case["values"])).unwrap();
        assert!((ours.statistic - case["statistic"].as_f64().unwrap()).abs() < 1e-9, "{ours:?}");
    }
}
