//! Curves with more points than a figure can show.

/// Largest number of points of a figure; the lowest and highest of each group are kept so that no peak is lost.
const FIGURE_POINTS: usize = 4000;

/// The curve with fewer points, lowest and highest of each group kept.
pub fn thinned(time: &[f64], value: &[f64]) -> Vec<(f64, f64)> {
    let count = time.len().min(value.len());
    if count <= FIGURE_POINTS {
        return time.iter().copied().zip(value.iter().copied()).collect();
    }
    let group = count.div_ceil(FIGURE_POINTS / 2);
    let mut points = Vec::with_capacity(FIGURE_POINTS);
    for start in (0..count).step_by(group) {
        let end = (start + group).min(count);
        let lowest = (start..end).min_by(|a, b| value[*a].total_cmp(&value[*b])).unwrap_or(start);
        let highest = (start..end).max_by(|a, b| value[*a].total_cmp(&value[*b])).unwrap_or(start);
        let (first, second) = (lowest.min(highest), lowest.max(highest));
        points.push((time[first], value[first]));
        if second != first {
            points.push((time[second], value[second]));
        }
    }
    points
}

/// The largest value in each step of `width`, at the middle of the step: the envelope of many passes. Steps without a
/// point are omitted.
pub fn envelope(points: impl IntoIterator<Item = (f64, f64)>, width: f64) -> Vec<(f64, f64)> {
    let mut steps: std::collections::BTreeMap<i64, f64> = std::collections::BTreeMap::new();
    for (x, y) in points {
        let largest = steps.entry((x / width).floor() as i64).or_insert(f64::NEG_INFINITY);
        *largest = largest.max(y);
    }
    steps.into_iter().map(|(step, largest)| ((step as f64 + 0.5) * width, largest)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_envelope_is_never_below_its_points() {
        let points: Vec<(f64, f64)> =
            (0..1000).map(|i| (0.1 * f64::from(i), (0.37 * f64::from(i)).sin())).collect();
        let found = envelope(points.iter().copied(), 2.0);
        assert_eq!(found.len(), 50);
        for (x, y) in points {
            let step = found.iter().find(|(at, _)| (at - x).abs() <= 1.0 + 1e-9).unwrap();
            assert!(step.1 >= y || found.iter().any(|(at, top)| (at - x).abs() <= 1.0 + 1e-9 && *top >= y));
        }
    }
}
