//! Series of readings, and lines fitted to them.

use std::ops::Range;

/// Values in the order of the test, each replaced by the value of a straight line fitted to the rows around it.
///
/// The number of rows of the line is adapted to the curvature: starting with a single row it is increased until
/// the confidence intervals of all lengths have no common point any more (Goldenshluger and Nemirovski 1997;
/// Katkovnik, IEEE Trans. Signal Process. 47, 1999). So a linear ramp is averaged over hundreds of rows and a
/// curved part over few, and values without noise remain unchanged.
#[derive(Debug, Clone)]
pub(super) struct Lines {
    pub values: Vec<f64>,
    /// Standard deviation of a single row about the lines; increased if the residuals of neighbours are
    /// correlated, so that the uncertainty of means is right.
    pub noise: f64,
    /// Rows on either side that are in the line of each row.
    reach: Vec<usize>,
    /// Abscissa of the lines.
    over: Vec<f64>,
    course: Course,
}

/// Half width of the confidence intervals in standard deviations: lines of different length must agree within
/// it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Course {
    /// Values set by the bench, linear over long ranges: long lines.
    Set,
    /// Response of the machine, which is curved: shorter lines, which do not flatten the curvature.
    Answer,
}

impl Course {
    fn agreement(self) -> f64 {
        match self {
            Course::Set => 2.1,
            Course::Answer => 1.6,
        }
    }
}

impl Lines {
    /// Lines over the monotonic abscissa `over`: the number of the row, or the value set in the test.
    pub fn through(over: &[f64], values: &[f64], course: Course) -> Lines {
        let noise = noise(over, values);
        let mut reaches = vec![0_usize];
        while reaches[reaches.len() - 1] < values.len() {
            let last = reaches[reaches.len() - 1];
            reaches.push((last + 1).max(last * 7 / 5));
        }
        let sums = Sums::new(over, values);
        let reach: Vec<usize> = (0..values.len())
            .map(|at| {
                let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
                let mut best = 0;
                for reach in &reaches {
                    let (value, share) = sums.line(at, *reach);
                    let width = course.agreement() * noise * share.sqrt();
                    (low, high) = (low.max(value - width), high.min(value + width));
                    if low > high {
                        break;
                    }
                    best = *reach;
                }
                best
            })
            .collect();
        let values_on_lines = sums.lines(&reach);
        let rests: Vec<f64> = values.iter().zip(&values_on_lines).map(|(value, line)| value - line).collect();
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let next = rests.get(1..).unwrap_or_default();
        let alike = (product(&rests, next) / product(&rests, &rests)).clamp(0.0, 0.9);
        let noise = if alike > 0.0 { noise * ((1.0 + alike) / (1.0 - alike)).sqrt() } else { noise };
        Lines { values: values_on_lines, noise, reach, over: over.to_vec(), course }
    }

    /// Lines through other values over the same abscissa, with lengths of their own.
    pub fn of(&self, values: &[f64]) -> Vec<f64> {
        Lines::through(&self.over, values, self.course).values
    }

    /// Lines of half the length through the same values.
    pub fn halved(&self, values: &[f64]) -> Vec<f64> {
        let half: Vec<usize> = self.reach.iter().map(|reach| reach / 2).collect();
        Sums::new(&self.over, values).lines(&half)
    }

    /// Rows of the longest line.
    pub fn longest(&self) -> usize {
        (2 * self.reach.iter().max().copied().unwrap_or(0) + 1).min(self.reach.len())
    }
}

/// Standard deviation of a single value, from the distances of values from the line between their neighbours:
/// the 68 % quantile of these, so that curved parts have little influence.
pub(super) fn noise(over: &[f64], values: &[f64]) -> f64 {
    let mut off: Vec<f64> = over
        .windows(3)
        .zip(values.windows(3))
        .map(|(x, y)| {
            let share = if x[2] == x[0] { 0.5 } else { (x[1] - x[0]) / (x[2] - x[0]) };
            let line = y[0] + share * (y[2] - y[0]);
            (y[1] - line).abs() / (1.0 + share * share + (1.0 - share) * (1.0 - share)).sqrt()
        })
        .collect();
    if off.is_empty() {
        return 0.0;
    }
    let at = ((0.6827 * off.len() as f64) as usize).min(off.len() - 1);
    *off.select_nth_unstable_by(at, f64::total_cmp).1
}

/// Cumulative sums over the rows, from which any line is computed directly.
struct Sums<'a> {
    over: &'a [f64],
    values: &'a [f64],
    /// Sums of x, y, x², x y, both relative to the middle row to reduce the rounding error.
    sums: Vec<[f64; 4]>,
    zero: (f64, f64),
}

impl Sums<'_> {
    fn new<'a>(over: &'a [f64], values: &'a [f64]) -> Sums<'a> {
        let middle = values.len() / 2;
        let zero = (over.get(middle).copied().unwrap_or(0.0), values.get(middle).copied().unwrap_or(0.0));
        let mut sums = vec![[0.0; 4]];
        for (x, y) in over.iter().zip(values) {
            let (x, y) = (x - zero.0, y - zero.1);
            let [a, b, c, d] = sums[sums.len() - 1];
            sums.push([a + x, b + y, c + x * x, d + x * y]);
        }
        Sums { over, values, sums, zero }
    }

    /// Value of the fitted line at a row, and its variance relative to that of a single row.
    fn line(&self, at: usize, reach: usize) -> (f64, f64) {
        let (start, end) = (at.saturating_sub(reach), (at + reach + 1).min(self.values.len()));
        if end - start < 2 {
            return (self.values[at], 1.0);
        }
        let count = (end - start) as f64;
        let [x, y, xx, xy] = std::array::from_fn(|k| (self.sums[end][k] - self.sums[start][k]) / count);
        let (spread, both) = (xx - x * x, xy - x * y);
        let off = self.over[at] - self.zero.0 - x;
        // Rows with equal abscissa have a mean and no slope.
        let slope = if spread > 1e-12 * xx.max(off * off) { both / spread } else { 0.0 };
        let lever = if slope == 0.0 { 0.0 } else { off * off / spread };
        (self.zero.1 + y + slope * off, (1.0 + lever) / count)
    }

    fn lines(&self, reach: &[usize]) -> Vec<f64> {
        let line = |(at, reach): (usize, &usize)| match reach {
            0 => self.values[at],
            _ => self.line(at, *reach).0,
        };
        reach.iter().enumerate().map(line).collect()
    }
}

/// The monotonic values nearest to the given ones in the sense of least squares: neighbours in the wrong order
/// are replaced by their mean (isotonic regression).
pub(super) fn one_way(values: &[f64], rising: bool) -> Vec<f64> {
    let sign = if rising { 1.0 } else { -1.0 };
    let mut blocks: Vec<(f64, usize)> = Vec::new();
    for value in values {
        let mut block = (sign * value, 1);
        while let Some((mean, count)) = blocks.last().copied().filter(|(mean, _)| *mean > block.0) {
            let all = count + block.1;
            block = ((mean * count as f64 + block.0 * block.1 as f64) / all as f64, all);
            blocks.pop();
        }
        blocks.push(block);
    }
    blocks.into_iter().flat_map(|(mean, count)| std::iter::repeat_n(sign * mean, count)).collect()
}

/// Whether the values are monotonic within a tolerance.
pub(super) fn is_monotonic(values: &[f64], rising: bool, but: f64) -> bool {
    let sign = if rising { 1.0 } else { -1.0 };
    values.windows(2).all(|pair| sign * (pair[1] - pair[0]) >= -but)
}

/// Ranges of rows at which a value is held, if it is held, moved on, and held again; `None` if it moves all the
/// time.
///
/// Steps are the differences in the given direction that are clearly larger than any in the opposite one.
/// Within a range the value must not drift: a test with few rows around zero and many elsewhere has large
/// differences as well, but its value changes between these, too.
pub(super) fn held(values: &[f64], rising: bool) -> Option<Vec<Range<usize>>> {
    let sign = if rising { 1.0 } else { -1.0 };
    let moves: Vec<f64> = values.windows(2).map(|pair| sign * (pair[1] - pair[0])).collect();
    let back = moves.iter().fold(0.0, |most: f64, step| most.max(-step));
    let least = 1.3 * back;
    let steps = moves.iter().filter(|step| **step > least).count();
    let (net, size) = moves
        .iter()
        .filter(|step| **step <= least)
        .fold((0.0, 0.0), |(net, size), step| (net + step, size + step.abs()));
    let whole: f64 = moves.iter().sum();
    // At least two rows per step.
    let holds = steps > 0 && 2 * (steps + 1) <= values.len() && net <= 0.05 * whole && net <= 0.5 * size;
    let ranges = holds.then(|| between(&moves, |step| step > least))?;
    // Steps smaller than the noise are not distinguishable; a range within which the value drifts was not held.
    let within: Vec<f64> = moves.iter().copied().filter(|step| *step <= least).collect();
    let scatter =
        (within.iter().map(|step| step * step).sum::<f64>() / (2 * within.len().max(1)) as f64).sqrt();
    let rests = |rows: &Range<usize>| {
        let third = rows.len() / 3;
        let on = mean(&values[rows.end - third..rows.end]) - mean(&values[rows.start..rows.start + third]);
        third == 0 || sign * on <= 4.0 * scatter * (2.0 / third as f64).sqrt()
    };
    ranges.iter().all(rests).then_some(ranges)
}

/// Ranges of rows between steps.
fn between(moves: &[f64], is_step: impl Fn(f64) -> bool) -> Vec<Range<usize>> {
    let mut ranges = Vec::new();
    let mut start = 0;
    for (row, step) in moves.iter().enumerate() {
        if is_step(*step) {
            ranges.push(start..row + 1);
            start = row + 1;
        }
    }
    ranges.push(start..moves.len() + 1);
    ranges
}

pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Rows of the reversals: the first and the last row, and every maximum and minimum from which the values
/// return by `most` or more. Of equal values the first.
pub(super) fn turning_points(values: &[f64], most: f64) -> Vec<usize> {
    let mut points = vec![0];
    let (mut high, mut low, mut direction) = (0, 0, 0.0);
    for (row, value) in values.iter().enumerate() {
        if *value > values[high] {
            high = row;
        }
        if *value < values[low] {
            low = row;
        }
        let turn = if direction >= 0.0 && values[high] - value >= most {
            direction = -1.0;
            high
        } else if direction <= 0.0 && value - values[low] >= most {
            direction = 1.0;
            low
        } else {
            continue;
        };
        if turn > 0 {
            points.push(turn);
        }
        (high, low) = (row, row);
    }
    if values.len() > 1 {
        points.push(values.len() - 1);
    }
    points
}
