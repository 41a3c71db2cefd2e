//! Curves through the ends of steps.

/// The value at `at` of the cubic through points of rising `x` that is monotone wherever they are (Steffen, Astron.
/// Astrophys. 239 (1990) 443); beyond the last point that of the last.
pub(super) fn read(x: &[f64], y: &[f64], at: f64) -> f64 {
    let right = x.partition_point(|x| *x < at).clamp(1, x.len() - 1);
    let left = right - 1;
    let t = ((at - x[left]) / (x[right] - x[left])).min(1.0);
    let rise = y[right] - y[left];
    let [first, last] = [left, right].map(|i| slope(x, y, i) * (x[right] - x[left]));
    y[left] + t * t * (3.0 - 2.0 * t) * rise + t * (1.0 - t) * ((1.0 - t) * first - t * last)
}

/// Where the curve first reaches a value above that of its first point; `None` where it does not.
pub(super) fn place(x: &[f64], y: &[f64], value: f64) -> Option<f64> {
    let right = y.iter().position(|y| *y >= value)?.max(1);
    let (mut low, mut high) = (x[right - 1], x[right]);
    // To rounding.
    for _ in 0..f64::MANTISSA_DIGITS {
        let middle = 0.5 * (low + high);
        if read(x, y, middle) < value { low = middle } else { high = middle }
    }
    Some(high)
}

fn slope(x: &[f64], y: &[f64], i: usize) -> f64 {
    let width = |i: usize| x[i + 1] - x[i];
    let secant = |i: usize| (y[i + 1] - y[i]) / width(i);
    let last = x.len() - 2;
    if last == 0 {
        return secant(0);
    }
    if i == 0 || i > last {
        // At an end the parabola through the three nearest points.
        let (near, far) = if i == 0 { (0, 1) } else { (last, last - 1) };
        let share = width(near) / (width(near) + width(far));
        let parabola = secant(near) + share * (secant(near) - secant(far));
        let steepest = 2.0 * secant(near);
        return parabola.clamp(steepest.min(0.0), steepest.max(0.0));
    }
    let (before, after) = (secant(i - 1), secant(i));
    let parabola = (before * width(i) + after * width(i - 1)) / (width(i - 1) + width(i));
    (before.signum() + after.signum()) * before.abs().min(after.abs()).min(0.5 * parabola.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Straight lines and, away from the ends of a bend, parabolas to fourth order; no value beyond those beside it.
    #[test]
    fn curves_go_through_their_points_and_not_beyond() {
        let x: Vec<f64> = (0..20).map(|i| 0.1 * f64::from(i) + 0.02 * f64::from(i % 3)).collect();
        let of = |f: fn(f64) -> f64| x.iter().map(|x| f(*x)).collect::<Vec<f64>>();
        let (line, root) = (of(|x| 3.0 * x), of(|x| (1.0 + x).sqrt()));
        for i in 0..180 {
            let at = 0.01 * f64::from(i);
            assert!((read(&x, &line, at) - 3.0 * at).abs() < 1e-12);
            assert!((read(&x, &root, at) - (1.0 + at).sqrt()).abs() < 5e-5, "{at}");
            assert!((place(&x, &root, read(&x, &root, at).max(1.0 + 1e-9)).unwrap() - at).abs() < 1e-6);
        }
        let stairs: Vec<f64> = (0..20).map(|i| f64::from(i / 4)).collect();
        let values: Vec<f64> = (0..190).map(|i| read(&x, &stairs, 0.01 * f64::from(i))).collect();
        assert!(values.windows(2).all(|pair| pair[1] >= pair[0]));
        assert_eq!(read(&x, &line, 7.0), line[19]);
        assert_eq!(place(&x, &line, 7.0), None);
    }
}
