//! Time stamps of loggers: repeated ones, and ones coarser than the intervals of the readings.

/// Corrects non-decreasing time stamps, in s, and returns a description of the corrections; `same(i)` is
/// whether reading i repeats all other values of the previous one. The second result contains the readings to
/// be omitted, in order.
///
/// * Stamps on a grid that agree with constant intervals within one step of the grid are replaced by constant intervals: a
///   clock of 10 ms records steps of 12 ms as 10, 10, 20 and 10 ms.
/// * A reading that repeats stamp and values of the previous one is a duplicate.
/// * Other readings with equal stamps are distributed uniformly up to the next stamp.
pub(super) fn mend(time: &mut [f64], same: impl Fn(usize) -> bool) -> (Option<String>, Vec<usize>) {
    let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let Some(tick) = steps.iter().copied().filter(|step| *step > 0.0).min_by(f64::total_cmp) else {
        return (None, Vec::new());
    };
    let repeats = steps.iter().filter(|step| **step == 0.0).count();
    if let Some(changed) = regular(time, &steps, tick) {
        let note = format!(
            "the clock counts in steps of {} s, which are too coarse: {changed} readings are taken as evenly spaced",
            crate::report::compact(tick, 6)
        );
        return ((changed > 0).then_some(note), Vec::new());
    }
    if repeats == 0 {
        return (None, Vec::new());
    }
    let twice: Vec<usize> = (1..time.len()).filter(|i| steps[i - 1] == 0.0 && same(*i)).collect();
    // If most stamps repeat, the clock is coarse, and equal readings are not duplicates.
    let coarse = 5 * repeats > time.len();
    let left_out = if coarse { Vec::new() } else { twice };
    spread(time, &left_out);
    let note = match (left_out.len(), repeats - left_out.len()) {
        (twice, 0) => format!("{twice} duplicate readings were removed"),
        (0, spread) => {
            format!("{spread} readings with repeated time stamps were distributed up to the next stamp")
        }
        (twice, spread) => format!(
            "{twice} duplicate readings were removed, {spread} readings with repeated time stamps were distributed up \
             to the next"
        ),
    };
    (Some(note), left_out)
}

/// Replaces stamps on a coarse grid by equidistant ones, interval by interval; returns the number of changes,
/// or `None` if equidistant ones do not agree with them.
fn regular(time: &mut [f64], steps: &[f64], tick: f64) -> Option<usize> {
    let on_grid = steps.iter().filter(|step| {
        let ticks = **step / tick;
        (ticks - ticks.round()).abs() < 0.02
    });
    let mean = (time[time.len() - 1] - time[0]) / steps.len() as f64;
    let uneven = steps.iter().any(|step| (step - steps[0]).abs() > 0.02 * tick);
    if !uneven || on_grid.count() * 100 < steps.len() * 99 || tick < 0.05 * mean.min(median(steps)) {
        return None;
    }
    let usual = 10.0 * tick.max(median(steps));
    let mut fitted = time.to_vec();
    let mut from = 0;
    for to in 1..=time.len() {
        if to < time.len() && steps[to - 1] <= usual {
            continue;
        }
        let (start, step) = line(&time[from..to]);
        let even = |i: usize| start + step * (i - from) as f64;
        if (from..to).any(|i| (time[i] - even(i)).abs() > 0.8 * tick) {
            return None;
        }
        (from..to).for_each(|i| fitted[i] = even(i));
        from = to;
    }
    if fitted.windows(2).any(|pair| !(pair[1] > pair[0])) {
        return None;
    }
    let changed = time.iter().zip(&fitted).filter(|(old, new)| (*old - *new).abs() > 0.02 * tick).count();
    time.copy_from_slice(&fitted);
    Some(changed)
}

/// Start and step of the least-squares line through values at equal distances.
fn line(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    if values.len() < 2 {
        return (values[0], 0.0);
    }
    let centre = 0.5 * (n - 1.0);
    let mean = values.iter().map(|value| value - values[0]).sum::<f64>() / n;
    let (mut top, mut bottom) = (0.0, 0.0);
    for (i, value) in values.iter().enumerate() {
        let x = i as f64 - centre;
        top += x * (value - values[0] - mean);
        bottom += x * x;
    }
    let step = top / bottom;
    (values[0] + mean - step * centre, step)
}

/// Distributes readings with equal stamps uniformly, with at most the usual interval.
fn spread(time: &mut [f64], left_out: &[usize]) {
    let kept: Vec<usize> = (0..time.len()).filter(|i| left_out.binary_search(i).is_err()).collect();
    let mut groups: Vec<(usize, usize)> = Vec::new();
    for k in 0..kept.len() {
        match groups.last_mut() {
            Some(group) if time[kept[group.0]] == time[kept[k]] => group.1 = k + 1,
            _ => groups.push((k, k + 1)),
        }
    }
    let stamp = |group: &(usize, usize)| time[kept[group.0]];
    let spacing: Vec<f64> = groups
        .windows(2)
        .map(|pair| (stamp(&pair[1]) - stamp(&pair[0])) / (pair[0].1 - pair[0].0) as f64)
        .collect();
    let usual = median(&spacing);
    let stamps: Vec<f64> = groups.iter().map(stamp).collect();
    for (index, (from, to)) in groups.iter().copied().enumerate() {
        let step = spacing.get(index).copied().unwrap_or(usual).min(usual);
        // The recording may begin within a count of the clock.
        let start = match stamps.get(1) {
            Some(next) if index == 0 && to - from > 1 => next - step * (to - from) as f64,
            _ => stamps[index],
        };
        for k in from..to {
            time[kept[k]] = start + step * (k - from) as f64;
        }
    }
}

pub(super) fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// The value below which this fraction of all values is; 0 if there are none.
pub(super) fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = (share * sorted.len() as f64) as usize;
    sorted.get(at.min(sorted.len().saturating_sub(1))).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_readings_under_a_coarse_clock() {
        for (step, tick) in [(0.008, 0.01), (0.01, 1.0), (0.0004, 0.001)] {
            let truth: Vec<f64> = (0..1000).map(|i| 0.3 * tick + step * f64::from(i)).collect();
            let mut time: Vec<f64> = truth.iter().map(|t| (t / tick).floor() * tick).collect();
            let (note, left_out) = mend(&mut time, |_| true);
            assert!(note.is_some() && left_out.is_empty(), "{step}");
            for (mended, right) in time.iter().zip(&truth) {
                // The stamp, rounded down, is on average half a tick early.
                assert!((mended + 0.5 * tick - right).abs() < 0.2 * tick, "{step}: {mended} for {right}");
            }
            let even = (time[999] - time[0]) / (truth[999] - truth[0]);
            assert!((even - 1.0).abs() < 0.02, "{even}");
        }
    }

    #[test]
    fn duplicate_readings_are_removed() {
        let mut time = vec![0.0, 0.011, 0.011, 0.019, 0.03, 0.0417, 0.05, 0.06];
        let (note, left_out) = mend(&mut time, |i| i == 2);
        assert_eq!((left_out, note.unwrap()), (vec![2], "1 duplicate readings were removed".to_owned()));
        let mut time = vec![0.0, 0.011, 0.011, 0.019, 0.03, 0.0417, 0.05, 0.06];
        let (_, left_out) = mend(&mut time, |_| false);
        assert!(left_out.is_empty() && time.windows(2).all(|pair| pair[1] > pair[0]), "{time:?}");
        let mut time = vec![0.0, 0.01, 0.02, 0.035];
        assert_eq!(mend(&mut time, |_| true), (None, Vec::new()));
        assert_eq!(time, [0.0, 0.01, 0.02, 0.035]);
    }
}
