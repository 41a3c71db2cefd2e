//! Clocks of loggers: stamps that repeat, or are coarser than the readings are apart.

/// Mends stamps that do not fall, in s, and returns what was done; `same(i)` tells whether reading i repeats
/// the one before in everything else. Readings to leave out come back as the second value, in order.
///
/// * Stamps on a grid that readings at equal distances explain to within the grid's step are replaced by
///   those readings' times: a clock of 10 ms makes 10, 10, 20 and 10 ms of steps of 12 ms.
/// * A reading that repeats stamp and values is the same reading, sent twice.
/// * Other readings with one stamp are spread evenly up to the next.
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
    // Where most stamps repeat, the clock is coarse, and equal readings are readings all the same.
    let coarse = 5 * repeats > time.len();
    let left_out = if coarse { Vec::new() } else { twice };
    spread(time, &left_out);
    let note = match (left_out.len(), repeats - left_out.len()) {
        (twice, 0) => format!("{twice} readings stand twice and are taken once"),
        (0, spread) => format!("{spread} readings repeat the stamp before and are spread up to the next"),
        (twice, spread) => format!(
            "{twice} readings stand twice and are taken once, {spread} repeat the stamp before and are spread up \
             to the next"
        ),
    };
    (Some(note), left_out)
}

/// Replaces stamps on a coarse grid by even ones, stretch by stretch; how many changed, `None` if even ones
/// do not explain them.
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

/// Spreads readings with one stamp evenly, no farther apart than is usual.
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
        // The recording may begin in the middle of the first count of the clock.
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

/// The value below which this share of all lies; 0 of none.
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
                // The floor of a stamp is half a tick early on average.
                assert!((mended + 0.5 * tick - right).abs() < 0.2 * tick, "{step}: {mended} for {right}");
            }
            let even = (time[999] - time[0]) / (truth[999] - truth[0]);
            assert!((even - 1.0).abs() < 0.02, "{even}");
        }
    }

    #[test]
    fn readings_sent_twice_are_one() {
        let mut time = vec![0.0, 0.011, 0.011, 0.019, 0.03, 0.0417, 0.05, 0.06];
        let (note, left_out) = mend(&mut time, |i| i == 2);
        assert_eq!(
            (left_out, note.unwrap()),
            (vec![2], "1 readings stand twice and are taken once".to_owned())
        );
        let mut time = vec![0.0, 0.011, 0.011, 0.019, 0.03, 0.0417, 0.05, 0.06];
        let (_, left_out) = mend(&mut time, |_| false);
        assert!(left_out.is_empty() && time.windows(2).all(|pair| pair[1] > pair[0]), "{time:?}");
        let mut time = vec![0.0, 0.01, 0.02, 0.035];
        assert_eq!(mend(&mut time, |_| true), (None, Vec::new()));
        assert_eq!(time, [0.0, 0.01, 0.02, 0.035]);
    }
}
