//! Time for which a reading remains valid.

use super::clock::median;

/// Longest step for which readings remain valid, and its reason.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Holding {
    /// Longest step in s; longer ones are gaps of the recording.
    pub longest: f64,
    /// Whether the log seems to be recorded on change of values.
    pub on_change: bool,
}

/// Ratio to the median step above which a step of a log recorded at constant intervals is a gap.
const GAP: f64 = 20.0;
/// s; validity of a value in a log recorded on change.
const HOUR: f64 = 3600.0;

/// A log recorded at constant intervals repeats its values if nothing changes, or has noise whose direction
/// changes from reading to reading; one recorded on change has neither.
pub(super) fn of(time: &[f64], signals: [&[f64]; 2], given: Option<f64>) -> Holding {
    let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual = median(&steps);
    if let Some(longest) = given {
        return Holding { longest, on_change: false };
    }
    let short: Vec<usize> = (0..steps.len()).filter(|i| steps[*i] <= 3.0 * usual).collect();
    let equal = short.iter().filter(|i| signals.iter().all(|values| values[**i + 1] == values[**i])).count();
    let noisy = signals.iter().any(|values| {
        let change = |i: usize| values[i + 1] - values[i];
        let pairs = || {
            short
                .windows(2)
                .filter(|pair| pair[1] == pair[0] + 1)
                .map(|pair| change(pair[0]) * change(pair[1]))
        };
        let turns = pairs().filter(|product| *product < 0.0).count();
        let moving = pairs().filter(|product| *product != 0.0).count();
        turns > 5 && 3 * turns > moving
    });
    let on_change = 50 * equal < short.len() && !noisy;
    Holding { longest: if on_change { HOUR.max(GAP * usual) } else { GAP * usual }, on_change }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logs_recorded_on_change_hold() {
        // Ramps in steps of 10 ms, with a value that remains valid for minutes between them.
        let (mut time, mut speed, mut now) = (Vec::new(), Vec::new(), 0.0);
        for cycle in 0..20 {
            for i in 0..40 {
                time.push(now);
                speed.push(if cycle % 2 == 0 { f64::from(i) } else { f64::from(40 - i) });
                now += 0.01;
            }
            now += 120.0;
        }
        let torque: Vec<f64> = speed.iter().map(|v| 3.0 * v).collect();
        let found = of(&time, [&torque, &speed], None);
        assert!(found.on_change && found.longest == 3600.0);
        assert_eq!(of(&time, [&torque, &speed], Some(60.0)).longest, 60.0);
        // The same at constant intervals, with values that repeat, or with noise.
        let even: Vec<f64> = (0..4000).map(|i| 0.01 * f64::from(i)).collect();
        let steady: Vec<f64> = even.iter().map(|t| (t % 2.0).min(1.0)).collect();
        assert!(!of(&even, [&steady, &steady], None).on_change);
        let noisy: Vec<f64> = (0..4000).map(|i| f64::from((i * 7919) % 1013)).collect();
        let found = of(&even, [&noisy, &even], None);
        assert!(!found.on_change && (found.longest - 0.2).abs() < 1e-9);
    }
}
