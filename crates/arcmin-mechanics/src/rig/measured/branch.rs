//! One branch of a measured loop: steps condensed to their means, noise replaced by lines.

use std::ops::Range;

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

use super::series::{Course, Lines, held, is_monotonic, mean, noise, one_way};
use crate::rig::{Branch, LoopPoint};

/// Largest number of rows of a branch; longer ones are averaged in groups.
const MOST_ROWS: usize = 4_000;
/// Largest reversal within a branch that is not yet noise: of the torque as a share of the rated one, of the
/// angle as a share of its range.
const MONOTONIC_WITHIN: (f64, f64) = (2e-4, 1e-3);

/// A whole branch of rows in the order of the test.
#[derive(Debug, Clone)]
pub(super) struct Sweep {
    /// Rows in the file.
    pub at: Range<usize>,
    pub branch: Branch,
    pub torque: Vec<f64>,
    pub angle: Vec<f64>,
    /// Number of each row, from 0.
    pub order: Vec<f64>,
}

/// A branch ready for evaluation.
pub(super) struct Cleaned {
    pub branch: Branch,
    pub torque: Vec<f64>,
    pub angle: Vec<f64>,
    pub order: Vec<f64>,
    /// Lines through torque and angle, where these are noisy.
    pub torque_lines: Option<Lines>,
    pub angle_lines: Option<Lines>,
    /// Torque and angle on lines of half the length.
    pub halved: (Vec<f64>, Vec<f64>),
    /// Standard deviation in rad of each angle that is not smoothed.
    pub scatter: Vec<f64>,
    /// Number of torque steps; `None` if the torque was not held.
    pub steps: Option<usize>,
}

impl Cleaned {
    pub fn new(sweep: &Sweep, rated: f64) -> Cleaned {
        let rising = sweep.branch == Branch::Rising;
        let every = sweep.torque.len().div_ceil(MOST_ROWS);
        let thinned = |values: &[f64]| -> Vec<f64> { values.chunks(every).map(mean).collect() };
        let [mut torque, mut angle, mut order] =
            [&sweep.torque, &sweep.angle, &sweep.order].map(|v| thinned(v));
        let held = held_rows(&torque, &angle, rising);
        if let Some(held) = &held {
            for values in [&mut torque, &mut angle, &mut order] {
                // In the second half of a step the transients have decayed.
                *values =
                    held.iter().map(|rows| mean(&values[rows.start + rows.len() / 2..rows.end])).collect();
            }
        }
        if held.is_none() && !is_monotonic(&torque, rising, MONOTONIC_WITHIN.0 * rated) {
            // At a reversal of the torque, noise hides the exact row: rows of the next branch may be included.
            let within = without_corners(&torque, rising);
            for values in [&mut torque, &mut angle, &mut order] {
                *values = values[within.clone()].to_vec();
            }
        }
        let span = angle.iter().fold(f64::NEG_INFINITY, |m: f64, a| m.max(*a))
            - angle.iter().fold(f64::INFINITY, |m: f64, a| m.min(*a));
        let torque_is_monotonic = is_monotonic(&torque, rising, MONOTONIC_WITHIN.0 * rated);
        let angle_is_monotonic = is_monotonic(&angle, rising, MONOTONIC_WITHIN.1 * span);
        let rows: Vec<f64> = (0..torque.len()).map(|row| row as f64).collect();
        // Without noise the torque is the abscissa of the lines of the angle; with noise, the number of the row
        // is.
        let angle_lines = (!angle_is_monotonic).then(|| {
            Lines::through(if torque_is_monotonic { &torque } else { &rows }, &angle, Course::Answer)
        });
        let torque_lines = (!torque_is_monotonic).then(|| Lines::through(&rows, &torque, Course::Set));
        let scatter = match (&torque_lines, &angle_lines) {
            (None, None) => scatter(&torque, &angle),
            _ => vec![0.0; angle.len()],
        };
        let halved = |lines: &Option<Lines>, values: &[f64]| {
            lines.as_ref().map_or(values.to_vec(), |lines| lines.halved(values))
        };
        let halved = (halved(&torque_lines, &torque), halved(&angle_lines, &angle));
        let mut cleaned = Cleaned {
            branch: sweep.branch,
            halved: (Vec::new(), Vec::new()),
            torque: torque_lines.as_ref().map_or(torque, |lines| lines.values.clone()),
            angle: angle_lines.as_ref().map_or(angle, |lines| lines.values.clone()),
            order,
            torque_lines,
            angle_lines,
            scatter,
            steps: held.map(|held| held.len()),
        };
        cleaned.halved = cleaned.one_way(halved.0, halved.1);
        (cleaned.torque, cleaned.angle) = cleaned.one_way(cleaned.torque.clone(), cleaned.angle.clone());
        cleaned
    }

    /// Lines through noise may still have small reversals, which are removed; measured values are kept.
    fn one_way(&self, torque: Vec<f64>, angle: Vec<f64>) -> (Vec<f64>, Vec<f64>) {
        let rising = self.branch == Branch::Rising;
        let smooth = |lines: &Option<Lines>, values: Vec<f64>| match lines {
            Some(_) => one_way(&values, rising),
            None => values,
        };
        (smooth(&self.torque_lines, torque), smooth(&self.angle_lines, angle))
    }

    pub fn points(&self, torque: &[f64], angle: &[f64]) -> Vec<LoopPoint> {
        let point =
            |(torque, angle): (&f64, &f64)| LoopPoint { torque: *torque, angle: *angle, branch: self.branch };
        torque.iter().zip(angle).map(point).collect()
    }

    /// Largest deviation in rad of the angle at a torque from the straight line between the two neighbouring
    /// rows; 0 where the branch is read from lines.
    ///
    /// For a curve of one sign of curvature the angle is between the line and the extrapolations from the rows
    /// on either side, and the smaller one of these is used; where the curvature changes its sign, the larger
    /// one. The deviation is limited to 2 s (1 − s) w b, with the interval w, the share s of it up to the
    /// torque, and the larger change of slope b at both rows.
    pub fn between_rows(&self, torque: f64) -> f64 {
        if self.torque_lines.is_some() || self.angle_lines.is_some() {
            return 0.0;
        }
        let (t, a) = (&self.torque, &self.angle);
        let Some(row) = t
            .windows(2)
            .position(|pair| (pair[0] - torque) * (pair[1] - torque) <= 0.0 && pair[0] != pair[1])
        else {
            return 0.0;
        };
        let slope = |row: usize| -> Option<f64> {
            let slope = (a.get(row + 1)? - a[row]) / (t[row + 1] - t[row]);
            slope.is_finite().then_some(slope)
        };
        // Change of slope at a row.
        let bend = |row: Option<usize>| -> f64 {
            let bend = |row: usize| Some(slope(row)? - slope(row.checked_sub(1)?)?);
            row.and_then(bend).unwrap_or(0.0)
        };
        let (before, behind) = (bend(Some(row)), bend(Some(row + 1)));
        let predicted = before * (torque - t[row]);
        let backwards = behind * (t[row + 1] - torque);
        let turns = |near: f64, far: f64| near * far < 0.0 && near.abs() < far.abs();
        let one_way = before * behind > 0.0
            && !turns(before, bend(row.checked_sub(1)))
            && !turns(behind, bend(Some(row + 2)));
        let off =
            if one_way { predicted.abs().min(backwards.abs()) } else { predicted.abs().max(backwards.abs()) };
        let change = (t[row + 1] - t[row]).abs();
        let share = (torque - t[row]).abs() / change;
        off.min(2.0 * share * (1.0 - share) * change * before.abs().max(behind.abs()))
    }

    /// The branch with another sample of the same noise.
    pub fn repeated(&self, random: &mut Pcg64Mcg) -> Vec<LoopPoint> {
        let mut again = |lines: &Option<Lines>, values: &[f64]| -> Vec<f64> {
            let Some(lines) = lines else { return values.to_vec() };
            lines.of(&values.iter().map(|value| value + lines.noise * normal(random)).collect::<Vec<_>>())
        };
        let torque = again(&self.torque_lines, &self.torque);
        let mut angle = again(&self.angle_lines, &self.angle);
        angle.iter_mut().zip(&self.scatter).for_each(|(angle, scatter)| *angle += scatter * normal(random));
        let (torque, angle) = self.one_way(torque, angle);
        self.points(&torque, &angle)
    }
}

fn normal(random: &mut Pcg64Mcg) -> f64 {
    StandardNormal.sample(random)
}

/// Ranges of rows at which the torque is held. Where its noise hides the steps, they are found from the angle.
fn held_rows(torque: &[f64], angle: &[f64], rising: bool) -> Option<Vec<Range<usize>>> {
    if let Some(rows) = held(torque, rising) {
        return Some(rows);
    }
    let rows = held(angle, rising)?;
    let within: f64 = rows.iter().map(|rows| torque[rows.end - 1] - torque[rows.start]).sum();
    let whole = torque[torque.len() - 1] - torque[0];
    // Within a clearance the angle changes at constant torque; such ranges are not steps, since the torque
    // changes within those at constant angle.
    (within.abs() <= 0.15 * whole.abs()).then_some(rows)
}

/// Rows of a noisy branch whose torque differs from that of both ends by more than the noise.
fn without_corners(torque: &[f64], rising: bool) -> Range<usize> {
    let rows: Vec<f64> = (0..torque.len()).map(|row| row as f64).collect();
    let clear = 3.0 * noise(&rows, torque);
    let sign = if rising { 1.0 } else { -1.0 };
    let (first, last) = (sign * torque[0], sign * torque[torque.len() - 1]);
    let start = torque.iter().position(|t| sign * t > first + clear).unwrap_or(0);
    let end = torque.iter().rposition(|t| sign * t < last - clear).map_or(torque.len(), |row| row + 1);
    if start + 8 < end { start..end } else { 0..torque.len() }
}

/// Standard deviation of each angle, from its distance from the lines through its two neighbours on either
/// side: the smaller one of both, so that a corner has little influence, then the median of three rows.
fn scatter(torque: &[f64], angle: &[f64]) -> Vec<f64> {
    let last = angle.len() as isize - 1;
    let off = |at: isize, step: isize| -> f64 {
        let (near, far) = (at + step, at + 2 * step);
        if far < 0 || far > last {
            return f64::INFINITY;
        }
        let [at, near, far] = [at, near, far].map(|row| row as usize);
        let share = (torque[at] - torque[near]) / (torque[far] - torque[near]);
        if !share.is_finite() {
            return f64::INFINITY;
        }
        let line = angle[near] + share * (angle[far] - angle[near]);
        (angle[at] - line).abs() / (1.0 + share * share + (1.0 - share) * (1.0 - share)).sqrt()
    };
    let own: Vec<f64> = (0..=last)
        .map(|at| off(at, 1).min(off(at, -1)))
        .map(|off| if off.is_finite() { off } else { 0.0 })
        .collect();
    (0..own.len())
        .map(|at| {
            let mut near = own[at.saturating_sub(1)..(at + 2).min(own.len())].to_vec();
            near.sort_by(f64::total_cmp);
            near[near.len() / 2]
        })
        .collect()
}
