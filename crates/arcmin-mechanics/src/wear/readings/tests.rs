use super::*;
use crate::wear::Target;

/// A growth equal to the exposure: p = k t, and S is a parabola in k.
fn straight(readings: &Readings) -> Growth {
    let points: Vec<(f64, f64, f64)> = (0..=40_000).map(|i| f64::from(i) * 1e-3).map(|x| (x, x, x)).collect();
    Growth::of(&points, &readings.targets())
}

fn reading(time: f64, value: f64) -> Reading {
    Reading { time, measured: Measured::Increase, value, scale: 1.0 }
}

fn since_new(all: &[Reading]) -> Readings {
    Readings { all: all.to_vec(), new: Vec::new() }
}

/// Readings of the lost motion of one machine, which may also be known when new.
fn as_read(points: &[(f64, f64)], new: Option<New>) -> Readings {
    let one = |(time, value): &(f64, f64)| Reading {
        time: *time,
        measured: Measured::LostMotion(0),
        value: *value,
        scale: 1.0,
    };
    Readings { all: points.iter().map(one).collect(), new: vec![new] }
}

fn fit(readings: &Readings, running_in: RunningInFit, error: Option<f64>) -> Fit {
    let growth = straight(readings);
    fit_readings(&Model::new(&growth, readings), running_in, error)
}

const KEPT: RunningInFit = RunningInFit::Kept(None);

/// Regression through the origin: k = Σ t r/Σ t², with the band k ± t s/√Σ t².
#[test]
fn a_straight_growth_is_the_regression_through_the_origin() {
    let readings = [reading(1.0, 1.1), reading(2.0, 1.9), reading(3.0, 3.2), reading(4.0, 3.9)];
    let sum = |of: fn(&Reading) -> f64| readings.iter().map(of).sum::<f64>();
    let k = sum(|r| r.time * r.value) / sum(|r| r.time * r.time);
    let found = fit(&since_new(&readings), KEPT, None);
    assert!((found.law.coefficient / k - 1.0).abs() < 1e-6, "{} {k}", found.law.coefficient);
    let left: f64 = readings.iter().map(|r| (k * r.time - r.value).powi(2)).sum();
    // Student's t for 3 degrees of freedom, 95 %: 3.1824 (table).
    let half = 3.182_446 * (left / 3.0 / sum(|r| r.time * r.time)).sqrt();
    let estimate = found.estimates[0];
    assert!((estimate.low.unwrap() / (k - half) - 1.0).abs() < 1e-5, "{estimate:?} {k} {half}");
    assert!((estimate.high.unwrap() / (k + half) - 1.0).abs() < 1e-5, "{estimate:?} {k} {half}");
    assert!(found.untold().is_empty());
    // A known error of 0.1: the normal quantile 1.95996 applies, independent of the residuals.
    let known = fit(&since_new(&readings), KEPT, Some(0.1));
    let half = 0.195_996_4 / sum(|r| r.time * r.time).sqrt();
    assert!((known.estimates[0].high.unwrap() / (k + half) - 1.0).abs() < 1e-5);
}

#[test]
fn one_reading_gives_a_coefficient_without_a_band() {
    let found = fit(&since_new(&[reading(2.0, 5.0)]), KEPT, None);
    assert!((found.law.coefficient - 2.5).abs() < 1e-6 && !found.has_band);
    assert!(found.band(|truth| truth.law.coefficient).is_none());
    assert_eq!(found.untold().len(), 1);
}

/// Readings computed with k = 1, f = 6 and T = 2 reproduce these values; those that end long before T do not
/// determine them.
#[test]
fn a_running_in_is_found_if_the_readings_extend_beyond_it() {
    let truth = Exposure { coefficient: 1.0, running_in: Some(RunningIn { factor: 6.0, duration: 2.0 }) };
    let made =
        |times: &[f64]| since_new(&times.iter().map(|t| reading(*t, truth.at(*t))).collect::<Vec<_>>());
    let found = fit(&made(&[0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 16.0]), RunningInFit::Both, Some(0.02));
    let values: Vec<f64> = found.estimates.iter().map(|e| e.value).collect();
    for (value, truth) in values.iter().zip([1.0, 6.0, 2.0]) {
        assert!((value / truth - 1.0).abs() < 2e-3, "{value} {truth}");
    }
    assert!(
        found.estimates.iter().all(|e| e.low.unwrap() < e.value && e.value < e.high.unwrap()),
        "{found:?}"
    );
    let untold =
        fit(&made(&[0.02, 0.05, 0.1, 0.15, 0.2]), RunningInFit::Both, Some(0.02)).untold().join("; ");
    assert!(
        untold.contains("bound to the duration of the running-in")
            || untold.contains("cannot be distinguished"),
        "{untold}"
    );
}

/// Readings of the lost motion are the regression with an intercept, N + k t.
#[test]
fn readings_as_read_are_the_regression_with_an_intercept() {
    let points = [(1.0, 4.2), (2.0, 5.9), (4.0, 9.3), (7.0, 14.1), (9.0, 17.6)];
    let n = points.len() as f64;
    let (mean_t, mean_r) =
        (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let squares: f64 = points.iter().map(|p| (p.0 - mean_t).powi(2)).sum();
    let k = points.iter().map(|p| (p.0 - mean_t) * (p.1 - mean_r)).sum::<f64>() / squares;
    let readings = as_read(&points, None);
    let growth = straight(&readings);
    let model = Model::new(&growth, &readings);
    let found = fit_readings(&model, KEPT, None);
    assert!((found.law.coefficient / k - 1.0).abs() < 1e-6, "{} {k}", found.law.coefficient);
    let new = model.new_of(0, &Truth::best(found.law));
    assert!((new - (mean_r - k * mean_t)).abs() < 1e-5, "{new}");
    // Three degrees of freedom: t = 3.1824.
    let left: f64 = points.iter().map(|p| (mean_r + k * (p.0 - mean_t) - p.1).powi(2)).sum();
    let half = 3.182_446 * (left / 3.0 / squares).sqrt();
    let estimate = found.estimates[0];
    assert!(
        (estimate.high.unwrap() - estimate.low.unwrap() - 2.0 * half).abs() < 1e-4 * half,
        "{estimate:?}"
    );
}

/// Time at which N + k t reaches L: Fieller's interval, all t with (N + k t − L)² ≤ z² s² (1/n + (t − t̄)²/Σ(t
/// − t̄)²).
#[test]
fn the_band_of_the_hours_is_that_of_fieller() {
    let points = [(1.0, 1.1), (2.0, 1.3), (4.0, 1.65), (7.0, 2.2), (9.0, 2.6)];
    let (limit, error) = (4.0, 0.1);
    let readings = as_read(&points, None);
    let growth = straight(&readings);
    let model = Model::new(&growth, &readings);
    let found = fit_readings(&model, KEPT, Some(error));
    let hours = |truth: &Truth| (limit - model.new_of(0, truth)) / truth.law.coefficient;
    let (low, high) = found.band(hours).unwrap();
    let (k, new) = (found.law.coefficient, model.new_of(0, &Truth::best(found.law)));
    let n = points.len() as f64;
    let mean: f64 = points.iter().map(|p| p.0).sum::<f64>() / n;
    let squares: f64 = points.iter().map(|p| (p.0 - mean).powi(2)).sum();
    let edge = |t: f64| {
        (new + k * t - limit).powi(2) - (1.959_964 * error).powi(2) * (1.0 / n + (t - mean).powi(2) / squares)
    };
    let root = |mut inside: f64, mut outside: f64| {
        for _ in 0..100 {
            let middle = 0.5 * (inside + outside);
            if edge(middle) < 0.0 { inside = middle } else { outside = middle }
        }
        inside
    };
    let best = (limit - new) / k;
    let (exact_low, exact_high) = (root(best, 0.0), root(best, 10.0 * best));
    let width = exact_high - exact_low;
    // The directions underestimate the width by half a percent at most.
    assert!(
        (low - exact_low).abs() < 0.01 * width && (high - exact_high).abs() < 0.01 * width,
        "{low} {high} {exact_low} {exact_high}"
    );
}

/// One reading and the value of the new machine, each with its error: k = (r − N)/t with the standard deviation
/// √(σ_r² + σ_N²)/t.
#[test]
fn one_reading_with_the_value_when_new_is_enough() {
    let new = New { value: 0.5, error: 3.0 };
    let found = fit(&as_read(&[(4.0, 2.5)], Some(new)), KEPT, Some(0.05));
    assert!((found.law.coefficient / 0.5 - 1.0).abs() < 1e-6, "{}", found.law.coefficient);
    let half = 1.959_964 * 0.05 * (1.0_f64 + 9.0).sqrt() / 4.0;
    let estimate = found.estimates[0];
    assert!(
        (estimate.low.unwrap() - (0.5 - half)).abs() < 1e-5
            && (estimate.high.unwrap() - (0.5 + half)).abs() < 1e-5,
        "{estimate:?}"
    );
}

/// Random coefficients with noisy readings: 95 % of the bands contain the coefficient, and as many the hours to
/// the limit, both with a known error and with one estimated from the residuals (400 draws each; three standard
/// deviations are 3.3 %).
#[test]
fn bands_contain_the_true_value_at_their_confidence_level() {
    // xorshift64*
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut unit = move || {
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        ((state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    };
    for (known, absolute) in [(true, true), (false, true), (false, false)] {
        let (mut of_k, mut of_hours, trials) = (0, 0, 400);
        for _ in 0..trials {
            let k = 0.5 + unit();
            let (new, limit, error) = (0.3 + 0.4 * unit(), 12.0, 0.3);
            let count = 3 + (5.0 * unit()) as usize;
            let times: Vec<f64> = (0..count).map(|i| 1.0 + 7.0 * i as f64 / (count - 1) as f64).collect();
            let mut noisy = |t: f64, from: f64| from + k * t + error * Normal::standard().inverse_cdf(unit());
            let readings = if absolute {
                as_read(&times.iter().map(|t| (*t, noisy(*t, new))).collect::<Vec<_>>(), None)
            } else {
                since_new(&times.iter().map(|t| reading(*t, noisy(*t, 0.0))).collect::<Vec<_>>())
            };
            let growth = straight(&readings);
            let model = Model::new(&growth, &readings);
            let found = fit_readings(&model, KEPT, known.then_some(error));
            let estimate = found.estimates[0];
            of_k += i32::from(
                estimate.low.is_none_or(|low| low <= k) && estimate.high.is_none_or(|high| k <= high),
            );
            let new_of = |truth: &Truth| if absolute { model.new_of(0, truth) } else { 0.0 };
            let hours = |truth: &Truth| (limit - new_of(truth)) / truth.law.coefficient;
            let truth = (limit - if absolute { new } else { 0.0 }) / k;
            of_hours += i32::from(found.band(hours).is_none_or(|(low, high)| low <= truth && truth <= high));
        }
        for (what, held) in [("coefficient", of_k), ("hours", of_hours)] {
            let share = f64::from(held) / f64::from(trials);
            assert!((share - 0.95).abs() < 0.035, "{what}, known {known}, absolute {absolute}: {share}");
        }
    }
}

/// Predictions end where the computed growth ends; the first reading of a machine is the start of each target.
#[test]
fn targets_count_from_the_first_reading_of_their_machine() {
    let readings = as_read(&[(2.0, 1.0), (2.0, 1.2), (6.0, 3.1)], None);
    assert_eq!(readings.first(0), Some((2.0, 1.1)));
    let targets: Vec<Target> = readings.targets();
    assert_eq!(targets.len(), 1);
    assert!((targets[0].value - 2.0).abs() < 1e-12 && targets[0].since == 2.0);
    let growth = straight(&readings);
    assert!(growth.covers(growth.last()) && !growth.covers(1.01 * growth.last()));
}
