//! Speeds from recorded angles.

use std::f64::consts::TAU;

use super::clock::{median, quantile};

/// Position at which angles cannot be unwrapped from one reading to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lost {
    /// Index of the second of the two readings.
    pub at: usize,
    pub period: f64,
}

/// Unwraps angles in rad that restart after a period (0 to 360°, ±180°, some whole turns), and returns the
/// period and the number of corrections.
///
/// A log of such angles covers one period and contains jumps over most of it. A jump is then a small step in
/// the opposite direction, which must be less than 0.4 of the period; for larger ones the direction is
/// ambiguous.
pub(super) fn join(angles: &mut [f64]) -> Result<Option<(f64, usize)>, Lost> {
    let (low, high) =
        angles.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), a| (l.min(*a), h.max(*a)));
    let range = high - low;
    let turns = (range / TAU - 1e-6).ceil().max(1.0);
    let period = turns * TAU;
    let steps: Vec<f64> = angles.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if range < 0.5 * period || steps.iter().all(|step| step.abs() <= 0.5 * period) {
        return Ok(None);
    }
    let short = |step: f64| step - period * (step / period).round();
    let longest = steps.iter().map(|step| short(*step).abs()).fold(0.0, f64::max);
    // Angles over several turns restart only after the whole period is covered.
    if turns > 1.0 && period - range > 3.0 * longest {
        return Ok(None);
    }
    if let Some(at) = steps.iter().position(|step| short(*step).abs() > 0.4 * period) {
        return Err(Lost { at: at + 1, period });
    }
    let mut joined = angles[0];
    let mut jumps = 0;
    for (angle, step) in angles[1..].iter_mut().zip(&steps) {
        jumps += usize::from(step.abs() > 0.5 * period);
        joined += short(*step);
        *angle = joined;
    }
    Ok(Some((period, jumps)))
}

/// Speeds from angles.
pub(super) struct Speeds {
    /// rad/s, each over the step that follows the reading.
    pub speeds: Vec<f64>,
    /// Number of readings over which they are averaged: more than one if the angles are too coarse or noisy for
    /// single steps.
    pub blurred: usize,
    /// Standard deviation in rad/s due to the noise of the angles.
    pub noise: f64,
}

/// `connected(i)`: whether reading i follows the previous one without a gap.
pub(super) fn speeds(time: &[f64], angles: &[f64], connected: &dyn Fn(usize) -> bool) -> Speeds {
    let last = angles.len() - 1;
    let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let step = median(&steps);
    let single: Vec<f64> = (0..last).map(|i| ((angles[i + 1] - angles[i]) / steps[i]).abs()).collect();
    let peak = quantile(&single, 0.99);
    let (noise, grid) = noise(angles, &steps, step);
    // Averages over h readings at a distance of h readings have the noise √(2/h) σ/(h Δt) in the speed. The
    // error of a grid q is not random from reading to reading, and causes √(2/12) q/(h Δt). The aim is a
    // hundredth of the peak, within a twentieth of a second.
    let within = ((0.05 / step) as usize).clamp(1, 200);
    let left =
        |h: usize| ((2.0 / h as f64).sqrt() * noise).max((1.0_f64 / 6.0).sqrt() * grid) / (h as f64 * step);
    let half = (1..=within).find(|h| left(*h) <= 0.01 * peak).unwrap_or(within);
    let mean = |values: &[f64], from: usize, to: usize| {
        values[from..to].iter().map(|value| value - values[from]).sum::<f64>() / (to - from) as f64
            + values[from]
    };
    let mut speeds = vec![0.0; angles.len()];
    for i in 0..last {
        if !connected(i + 1) {
            continue;
        }
        let mut h = 1;
        while h < half
            && i + 1 > h
            && i + h < last
            && connected(i + 1 - h)
            && connected(i + 1 + h)
            && steps[i - h] < 3.0 * step
            && steps[i + h] < 3.0 * step
        {
            h += 1;
        }
        let (before, after) = ((i + 1 - h, i + 1), (i + 1, i + 1 + h));
        let turned = mean(angles, after.0, after.1) - mean(angles, before.0, before.1);
        speeds[i] = turned / (mean(time, after.0, after.1) - mean(time, before.0, before.1));
    }
    Speeds { speeds, blurred: half, noise: left(half) }
}

/// Standard deviation of the angles from a smooth curve, by second differences at constant intervals, and the
/// grid on which they lie, if any.
fn noise(angles: &[f64], steps: &[f64], step: f64) -> (f64, f64) {
    let even = |i: usize| (steps[i] - steps[i + 1]).abs() < 0.1 * step && steps[i] < 3.0 * step;
    let bends: Vec<f64> = (0..steps.len().saturating_sub(1))
        .filter(|i| even(*i))
        .map(|i| (angles[i + 2] - 2.0 * angles[i + 1] + angles[i]).abs())
        .collect();
    let changes: Vec<f64> = angles.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let moving: Vec<f64> = changes.iter().copied().filter(|change| *change > 0.0).collect();
    let least = moving.iter().copied().fold(f64::INFINITY, f64::min);
    let on_grid = angles.iter().filter(|angle| {
        let counts = (*angle - angles[0]) / least;
        (counts - counts.round()).abs() < 0.05
    });
    // Equal steps are a constant speed.
    let steady = changes.iter().all(|change| (change / least - 1.0).abs() < 0.05);
    // If decimals hide a grid, angles still repeat for one or two readings while the joint moves.
    let moves = |i: usize| changes[i] > 0.0;
    let stands = (2..changes.len().saturating_sub(2))
        .filter(|i| !moves(*i) && (moves(i - 1) || moves(i - 2)) && (moves(i + 1) || moves(i + 2)))
        .count();
    let grid = match on_grid.count() * 100 > angles.len() * 99 {
        true if !steady => least,
        false if stands > 4 => quantile(&moving, 0.05),
        _ => 0.0,
    };
    // For normal noise the median magnitude is 0.6745 σ, and second differences have √6 σ.
    (median(&bends) / (0.6745 * 6_f64.sqrt()), grid)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_unwrapped_for_any_period() {
        let truth: Vec<f64> =
            (0..4000).map(|i| 9.0 * (f64::from(i) * 2e-3).sin() + 0.01 * f64::from(i)).collect();
        for (turns, low) in [(1.0, 0.0), (1.0, -0.5), (2.0, -1.0), (3.0, 0.0)] {
            let period = turns * TAU;
            let mut angles: Vec<f64> =
                truth.iter().map(|a| a - period * (a / period - low / turns).floor()).collect();
            let found = join(&mut angles).unwrap();
            assert_eq!(found.unwrap().0, period, "{turns} {low}");
            for (angle, right) in angles.iter().zip(&truth) {
                assert!((angle - angles[0] - (right - truth[0])).abs() < 1e-9, "{turns} {low}");
            }
        }
        // Angles that do not restart are not changed.
        let mut angles = truth.clone();
        assert_eq!(join(&mut angles), Ok(None));
        assert_eq!(angles, truth);
        // Half a turn between readings: the direction is ambiguous.
        let mut fast: Vec<f64> = (0..50).map(|i| (f64::from(i) * 2.9) % TAU).collect();
        assert!(join(&mut fast).is_err());
    }

    #[test]
    fn coarse_angles_give_the_true_speed() {
        let step = 1e-3;
        let time: Vec<f64> = (0..3000).map(|i| step * f64::from(i)).collect();
        let course = |t: f64| 0.5 * (1.5 * t).sin();
        let exact: Vec<f64> = time.iter().map(|t| course(*t)).collect();
        let of_exact = speeds(&time, &exact, &|_| true);
        assert!(of_exact.blurred <= 2);
        let grid = 1e-4;
        let coarse: Vec<f64> = exact.iter().map(|angle| (angle / grid).round() * grid).collect();
        let of_coarse = speeds(&time, &coarse, &|_| true);
        assert!(of_coarse.blurred > 2);
        for i in 100..2900 {
            let right = 0.75 * (1.5 * (time[i] + 0.5 * step)).cos();
            assert!((of_exact.speeds[i] - right).abs() < 1e-3, "{i}");
            assert!(
                (of_coarse.speeds[i] - right).abs() < 0.02 * 0.75,
                "{i}: {} {right}",
                of_coarse.speeds[i]
            );
        }
    }
}
