use super::*;

/// A growth that is the exposure itself: p = k t, S is a parabola in k.
fn straight(readings: &[Reading]) -> Growth {
    let points: Vec<(f64, f64, f64)> = (0..=40_000).map(|i| f64::from(i) * 1e-3).map(|x| (x, x, x)).collect();
    Growth::of(&points, readings)
}

fn reading(time: f64, value: f64) -> Reading {
    Reading { time, measured: Measured::Increase, value, scale: 1.0 }
}

/// The line through the origin: k = Σ t r/Σ t², and its band is k ± t s/√Σ t².
#[test]
fn a_straight_growth_is_the_regression_through_the_origin() {
    let readings = [reading(1.0, 1.1), reading(2.0, 1.9), reading(3.0, 3.2), reading(4.0, 3.9)];
    let sum = |of: fn(&Reading) -> f64| readings.iter().map(of).sum::<f64>();
    let k = sum(|r| r.time * r.value) / sum(|r| r.time * r.time);
    let fit = fit_readings(&straight(&readings), &readings, RunningInFit::Kept(None), None);
    assert!((fit.law.coefficient / k - 1.0).abs() < 1e-6, "{} {k}", fit.law.coefficient);
    let left: f64 = readings.iter().map(|r| (k * r.time - r.value).powi(2)).sum();
    // Student's t for 3 degrees of freedom, 95 %: 3.1824 (table).
    let half = 3.182_446 * (left / 3.0 / sum(|r| r.time * r.time)).sqrt();
    let estimate = fit.estimates[0];
    assert!((estimate.low.unwrap() / (k - half) - 1.0).abs() < 1e-5, "{estimate:?} {k} {half}");
    assert!((estimate.high.unwrap() / (k + half) - 1.0).abs() < 1e-5, "{estimate:?} {k} {half}");
    assert!(fit.untold().is_empty());
    // A known error of 0.1: the normal quantile, 1.95996, whatever the residuals are.
    let known = fit_readings(&straight(&readings), &readings, RunningInFit::Kept(None), Some(0.1));
    let half = 0.195_996_4 / sum(|r| r.time * r.time).sqrt();
    assert!((known.estimates[0].high.unwrap() / (k + half) - 1.0).abs() < 1e-5);
}

#[test]
fn one_reading_says_how_much_and_not_how_sure() {
    let readings = [reading(2.0, 5.0)];
    let fit = fit_readings(&straight(&readings), &readings, RunningInFit::Kept(None), None);
    assert!(
        (fit.law.coefficient - 2.5).abs() < 1e-6
            && !fit.has_band
            && fit.band(|law| law.coefficient).is_none()
    );
    assert_eq!(fit.untold().len(), 1);
}

/// Readings made with k = 1, f = 6 and T = 2 give them back; those that end long before T cannot.
#[test]
fn a_running_in_is_found_where_the_readings_reach_beyond_it() {
    let truth = Exposure { coefficient: 1.0, running_in: Some(RunningIn { factor: 6.0, duration: 2.0 }) };
    let made = |times: &[f64]| times.iter().map(|t| reading(*t, truth.at(*t))).collect::<Vec<_>>();
    let long = made(&[0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 16.0]);
    let fit = fit_readings(&straight(&long), &long, RunningInFit::Both, Some(0.02));
    let found: Vec<f64> = fit.estimates.iter().map(|e| e.value).collect();
    for (found, truth) in found.iter().zip([1.0, 6.0, 2.0]) {
        assert!((found / truth - 1.0).abs() < 2e-3, "{found} {truth}");
    }
    assert!(fit.estimates.iter().all(|e| e.low.unwrap() < e.value && e.value < e.high.unwrap()), "{fit:?}");
    let short = made(&[0.02, 0.05, 0.1, 0.15, 0.2]);
    let fit = fit_readings(&straight(&short), &short, RunningInFit::Both, Some(0.02));
    let untold = fit.untold().join("; ");
    assert!(
        untold.contains("bound to the duration of the running-in") || untold.contains("not told apart"),
        "{untold}"
    );
}

/// Readings since a first one, and increases since new of the same growth, say the same.
#[test]
fn absolute_readings_are_taken_against_their_first() {
    let k = 1.7;
    let since = [(3.0, 1.0), (6.0, 1.0), (9.0, 4.0)].map(|(time, first)| Reading {
        measured: Measured::Since(first),
        ..reading(time, k * (time - first))
    });
    let fit = fit_readings(&straight(&since), &since, RunningInFit::Kept(None), Some(0.1));
    assert!((fit.law.coefficient / k - 1.0).abs() < 1e-6, "{}", fit.law.coefficient);
}
