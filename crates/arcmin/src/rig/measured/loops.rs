//! Hysteresis loops.

use std::ops::Range;

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

use super::series::{Lines, goes_one_way, held, mean, noise, one_way, turning_points};
use super::{Remark, Unusable};
use crate::rig::hysteresis::angle_at;
use crate::rig::{Branch, LOST_MOTION_SHARE, LoopFigures, LoopPoint, evaluate_loop};
use crate::units::ARCMIN;

/// A row of a measured loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopRow {
    /// N·m.
    pub torque: f64,
    /// rad.
    pub angle: f64,
    /// As the file names it.
    pub branch: Option<Branch>,
}

/// A measured loop and what is read from it.
#[derive(Debug, Clone)]
pub struct MeasuredLoop {
    /// Number of the crank position in its file: cycles at one position are repetitions.
    pub position: usize,
    /// As measured, in the order of the test and in our senses.
    pub rows: Vec<LoopPoint>,
    /// What the figures are read from: the rows, or lines through them.
    pub points: Vec<LoopPoint>,
    pub figures: LoopFigures,
    /// Half widths of the 95 % intervals of the figures.
    pub uncertainty: LoopFigures,
    how: How,
}

/// How a loop was read.
#[derive(Debug, Clone, Default)]
struct How {
    /// Even drift over the loop that was taken out, rad.
    drift: Option<f64>,
    reversed: bool,
    /// What the distance of the rows leaves uncertain of lost motion and backlash, rad; where it is much.
    coarse: Option<f64>,
    /// Steps of a branch.
    steps: Option<usize>,
    /// Standard deviation and rows of the longest line of torque (N·m) and angle (rad).
    torque: Option<(f64, usize)>,
    angle: Option<(f64, usize)>,
}

/// Part of the range of torque by which it must come back to have turned.
const TURNED: f64 = 0.3;
/// Part of the range of torque that a branch must cover to be whole.
const WHOLE: f64 = 0.75;
/// Rows of a branch; longer ones are averaged to so many.
const MOST_ROWS: usize = 10_000;
/// Torque may come back by this share of the rated one without being noisy, the angle by this share of its range.
const STILL_ONE_WAY: (f64, f64) = (2e-4, 1e-3);
/// Part of the lost motion that the distance of the rows may leave uncertain without a word.
const TOO_COARSE: f64 = 0.1;
/// Repetitions with other noise, from which the uncertainty is taken.
const REPETITIONS: usize = 100;
/// Standard deviations of a 95 % interval.
const COVERAGE: f64 = 2.0;

/// Reads the loops of one crank position from rows in the order of the test; `rated` torque in N·m.
///
/// Branches are found from the order of the torque. What is before the first whole branch and behind the last
/// one is left out; whole branches are taken in pairs, each a loop. Where torque or angle go to and fro within
/// a branch, straight lines are laid through their rows ([`Lines`]) and the loop is read from these.
///
/// # Errors
/// [`Unusable`]: rows without a falling and a rising branch between ± rated torque.
pub fn read_loops(rows: &[LoopRow], rated: f64) -> Result<(Vec<MeasuredLoop>, Vec<Remark>), Unusable> {
    let mut remarks = Vec::new();
    let rows = in_our_sense(rows, &mut remarks);
    let branches = branches(&rows, rated, &mut remarks)?;
    let mut loops = Vec::new();
    for pair in branches.chunks_exact(2) {
        loops.push(read_pair(pair, rated)?);
    }
    if let [single] = branches.chunks_exact(2).remainder() {
        remarks.push(Remark::of_rows(single.at.clone(), "a branch without its counterpart is left out"));
    }
    say_how(&loops, &mut remarks);
    Ok((loops, remarks))
}

/// The output turns the way that the torque drives it.
fn in_our_sense(rows: &[LoopRow], remarks: &mut Vec<Remark>) -> Vec<LoopRow> {
    let of = |value: fn(&LoopRow) -> f64| mean(&rows.iter().map(value).collect::<Vec<_>>());
    let (torque, angle) = (of(|row| row.torque), of(|row| row.angle));
    let together: f64 = rows.iter().map(|row| (row.torque - torque) * (row.angle - angle)).sum();
    if together >= 0.0 {
        return rows.to_vec();
    }
    remarks
        .push(Remark::of_all("torque and angle are counted in opposite senses: the angle is turned round"));
    rows.iter().map(|row| LoopRow { angle: -row.angle, ..*row }).collect()
}

/// A whole branch of rows in the order of the test.
#[derive(Debug, Clone)]
struct Sweep {
    /// Where in the file.
    at: Range<usize>,
    branch: Branch,
    torque: Vec<f64>,
    angle: Vec<f64>,
    /// Number of the row, from 0 on.
    order: Vec<f64>,
}

fn branches(rows: &[LoopRow], rated: f64, remarks: &mut Vec<Remark>) -> Result<Vec<Sweep>, Unusable> {
    let torques: Vec<f64> = rows.iter().map(|row| row.torque).collect();
    let (low, high) =
        torques.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(*t), h.max(*t)));
    let range = high - low;
    let remedy = || {
        format!(
            "record output torque and angle, input locked, while the torque goes from + rated ({rated} N·m) to − rated and back"
        )
    };
    if rows.len() < 8 || !(range > 0.0) {
        return Err(Unusable::at(0, "these rows are no loop: the torque does not change", remedy()));
    }
    let turns = turning_points(&torques, TURNED * range);
    let mut ranges: Vec<Range<usize>> = Vec::new();
    let mut start = 0;
    for turn in &turns[1..] {
        // Where the file goes back to another beginning there are no rows on the way; noise before the first step
        // gets nowhere.
        if turn + 1 - start > 2 && (torques[*turn] - torques[start]).abs() > 0.05 * range {
            ranges.push(start..turn + 1);
            start = turn + 1;
        }
    }
    let whole = |at: &Range<usize>| (torques[at.end - 1] - torques[at.start]).abs() >= WHOLE * range;
    let first = ranges.iter().position(whole).unwrap_or(ranges.len());
    let mut sweeps = Vec::new();
    for (index, at) in ranges.iter().enumerate() {
        let (from, to) = (torques[at.start], torques[at.end - 1]);
        if !whole(at) {
            let what = if index < first { "the first loading" } else { "a part of a branch" };
            remarks
                .push(Remark::of_rows(at.clone(), format!("{what} ({from:.0} to {to:.0} N·m) is left out")));
            continue;
        }
        let way = if to > from { Branch::Rising } else { Branch::Falling };
        sweeps.push((at.clone(), way, named(&rows[at.clone()])));
    }
    let course = || {
        let places: Vec<String> = turns.iter().take(6).map(|turn| format!("{:.0}", torques[*turn])).collect();
        format!("{} N·m", places.join(" → "))
    };
    // Rows sorted by torque within branches that have names.
    let sorted = sweeps.windows(2).any(|pair| pair[0].1 == pair[1].1);
    let contrary = sweeps.iter().all(|(_, way, name)| name.is_some_and(|name| name != *way));
    if sorted && !sweeps.iter().all(|(_, _, name)| name.is_some()) || sweeps.len() < 2 {
        let what = format!("a falling and a rising branch are not both here: the torque goes {}", course());
        return Err(Unusable::at(0, what, remedy()));
    }
    if sorted {
        remarks.push(Remark::of_all("the rows are sorted by torque: the names of the branches count"));
    } else if contrary {
        remarks.push(Remark::of_all("branches are named against the course of the torque, which counts"));
    }
    let mut branches: Vec<Sweep> = sweeps
        .into_iter()
        .map(|(at, way, name)| {
            let branch = if sorted { name.unwrap_or(way) } else { way };
            let mut order: Vec<usize> = at.clone().collect();
            if branch != way {
                order.reverse();
            }
            Sweep {
                branch,
                torque: order.iter().map(|row| rows[*row].torque).collect(),
                angle: order.iter().map(|row| rows[*row].angle).collect(),
                order: at.clone().map(|row| row as f64).collect(),
                at,
            }
        })
        .collect();
    if sorted {
        // All cycles of one branch may stand before those of the other.
        let (falling, rising): (Vec<Sweep>, Vec<Sweep>) =
            branches.into_iter().partition(|sweep| sweep.branch == Branch::Falling);
        if falling.is_empty() || rising.is_empty() {
            let what = format!("one branch alone is here: the torque goes {}", course());
            return Err(Unusable::at(0, what, remedy()));
        }
        branches = falling.into_iter().zip(rising).flat_map(|(falling, rising)| [falling, rising]).collect();
    }
    Ok(branches)
}

/// The name that most of the rows have.
fn named(rows: &[LoopRow]) -> Option<Branch> {
    let count = |branch| rows.iter().filter(|row| row.branch == Some(branch)).count();
    let (falling, rising) = (count(Branch::Falling), count(Branch::Rising));
    (falling + rising > 0).then_some(if falling > rising { Branch::Falling } else { Branch::Rising })
}

/// A branch ready to be read.
struct Cleaned {
    branch: Branch,
    torque: Vec<f64>,
    angle: Vec<f64>,
    order: Vec<f64>,
    /// Lines through torque and angle, where they were needed.
    torque_lines: Option<Lines>,
    angle_lines: Option<Lines>,
    /// Torque and angle on lines of half the length.
    halved: (Vec<f64>, Vec<f64>),
    /// Standard deviation of each angle where it is read as measured, rad.
    scatter: Vec<f64>,
    /// Number of steps at which the torque was held, and whether it was.
    steps: Option<usize>,
}

impl Cleaned {
    fn new(sweep: &Sweep, rated: f64) -> Cleaned {
        let rising = sweep.branch == Branch::Rising;
        let every = sweep.torque.len().div_ceil(MOST_ROWS);
        let thinned = |values: &[f64]| -> Vec<f64> { values.chunks(every).map(mean).collect() };
        let [mut torque, mut angle, mut order] =
            [&sweep.torque, &sweep.angle, &sweep.order].map(|v| thinned(v));
        let held = held_rows(&torque, &angle, rising);
        if let Some(held) = &held {
            for values in [&mut torque, &mut angle, &mut order] {
                // By the second half of a step everything has settled.
                *values =
                    held.iter().map(|rows| mean(&values[rows.start + rows.len() / 2..rows.end])).collect();
            }
        }
        if held.is_none() && !goes_one_way(&torque, rising, STILL_ONE_WAY.0 * rated) {
            // Where the torque turns, noise hides the row at which it does: rows of the next branch may be here.
            let within = without_corners(&torque, rising);
            for values in [&mut torque, &mut angle, &mut order] {
                *values = values[within.clone()].to_vec();
            }
        }
        let span = angle.iter().fold(f64::NEG_INFINITY, |m: f64, a| m.max(*a))
            - angle.iter().fold(f64::INFINITY, |m: f64, a| m.min(*a));
        let torque_goes = goes_one_way(&torque, rising, STILL_ONE_WAY.0 * rated);
        let angle_goes = goes_one_way(&angle, rising, STILL_ONE_WAY.1 * span);
        let rows: Vec<f64> = (0..torque.len()).map(|row| row as f64).collect();
        // Torque without noise is what the angle is a line over; with noise, only the order of the rows is sure.
        let angle_lines =
            (!angle_goes).then(|| Lines::through(if torque_goes { &torque } else { &rows }, &angle));
        let torque_lines = (!torque_goes).then(|| Lines::through(&rows, &torque));
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

    /// Lines through noise may still turn back a little; what was read as measured may not.
    fn one_way(&self, torque: Vec<f64>, angle: Vec<f64>) -> (Vec<f64>, Vec<f64>) {
        let rising = self.branch == Branch::Rising;
        let smooth = |lines: &Option<Lines>, values: Vec<f64>| match lines {
            Some(_) => one_way(&values, rising),
            None => values,
        };
        (smooth(&self.torque_lines, torque), smooth(&self.angle_lines, angle))
    }

    fn points(&self, torque: &[f64], angle: &[f64]) -> Vec<LoopPoint> {
        let point =
            |(torque, angle): (&f64, &f64)| LoopPoint { torque: *torque, angle: *angle, branch: self.branch };
        torque.iter().zip(angle).map(point).collect()
    }

    /// How far the angle at a torque may lie off the straight line between the rows next to it, rad; nothing where it
    /// is read from lines.
    ///
    /// Of a curve that bends one way over these and the next rows the angle lies between the line and what the
    /// rows on either side foretell, the nearer of both. Where it bends both ways, it may go as far as the farther.
    fn between_rows(&self, torque: f64) -> f64 {
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
        // Change of the slope at a row.
        let bend = |row: Option<usize>| -> f64 {
            let bend = |row: usize| Some(slope(row)? - slope(row.checked_sub(1)?)?);
            row.and_then(bend).unwrap_or(0.0)
        };
        let (before, behind) = (bend(Some(row)), bend(Some(row + 1)));
        let foretold = before * (torque - t[row]);
        let backwards = behind * (t[row + 1] - torque);
        let turns = |near: f64, far: f64| near * far < 0.0 && near.abs() < far.abs();
        let one_way = before * behind > 0.0
            && !turns(before, bend(row.checked_sub(1)))
            && !turns(behind, bend(Some(row + 2)));
        if one_way { foretold.abs().min(backwards.abs()) } else { foretold.abs().max(backwards.abs()) }
    }

    /// The branch as another test with as much noise would have given it.
    fn repeated(&self, random: &mut Pcg64Mcg) -> Vec<LoopPoint> {
        let mut again = |lines: &Option<Lines>, values: &[f64]| -> Vec<f64> {
            let Some(lines) = lines else { return values.to_vec() };
            let noise: Vec<f64> = values.iter().map(|_| lines.noise * normal(random)).collect();
            lines.of(&noise).iter().zip(values).map(|(noise, value)| value + noise).collect()
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

/// Rows of the steps at which the torque is held. Where its noise hides them, the angle still shows them.
fn held_rows(torque: &[f64], angle: &[f64], rising: bool) -> Option<Vec<Range<usize>>> {
    if let Some(rows) = held(torque, rising) {
        return Some(rows);
    }
    let rows = held(angle, rising)?;
    let within: f64 = rows.iter().map(|rows| torque[rows.end - 1] - torque[rows.start]).sum();
    let whole = torque[torque.len() - 1] - torque[0];
    // At a clearance the angle moves alone: there the torque goes on where the angle rests.
    (within.abs() <= 0.15 * whole.abs()).then_some(rows)
}

/// Rows of a noisy branch whose torque is clear of both of its ends.
fn without_corners(torque: &[f64], rising: bool) -> Range<usize> {
    let rows: Vec<f64> = (0..torque.len()).map(|row| row as f64).collect();
    let clear = 3.0 * noise(&rows, torque);
    let sign = if rising { 1.0 } else { -1.0 };
    let (first, last) = (sign * torque[0], sign * torque[torque.len() - 1]);
    let start = torque.iter().position(|t| sign * t > first + clear).unwrap_or(0);
    let end = torque.iter().rposition(|t| sign * t < last - clear).map_or(torque.len(), |row| row + 1);
    if start + 8 < end { start..end } else { 0..torque.len() }
}

/// Standard deviation of each angle, from how far it lies off the lines through its two neighbours on either
/// side: the better of both, so that a corner counts little, and the middle one of three rows.
fn scatter(torque: &[f64], angle: &[f64]) -> Vec<f64> {
    let last = angle.len() as isize - 1;
    let off = |at: isize, way: isize| -> f64 {
        let (near, far) = (at + way, at + 2 * way);
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

fn read_pair(pair: &[Sweep], rated: f64) -> Result<MeasuredLoop, Unusable> {
    let first_row = pair[0].at.start;
    let mut cleaned: Vec<Cleaned> = pair.iter().map(|sweep| Cleaned::new(sweep, rated)).collect();
    let mut how = How::default();
    let drift = take_drift_out(&mut cleaned, &mut how);
    let evaluate = |points: &[LoopPoint]| evaluate_loop(points, rated);
    let points = |cleaned: &[Cleaned]| -> Vec<LoopPoint> {
        cleaned.iter().flat_map(|one| one.points(&one.torque, &one.angle)).collect()
    };
    let bad = |error: crate::rig::RigError| {
        Unusable::at(
            first_row,
            error.to_string(),
            format!(
                "cycle the torque to ± rated ({rated} N·m), with ten rows or more between 50 % and 100 %"
            ),
        )
    };
    let mut all = points(&cleaned);
    let mut figures = evaluate(&all).map_err(bad)?;
    let mut random = Pcg64Mcg::seed_from_u64(0x10_0b5);
    let mut repeated: Vec<[f64; 6]> = Vec::new();
    for _ in 0..REPETITIONS {
        let points: Vec<LoopPoint> = cleaned.iter().flat_map(|one| one.repeated(&mut random)).collect();
        repeated.extend(evaluate(&points).ok().map(|figures| figures.all()));
    }
    let own = figures.all();
    let width = |index: usize| {
        let square: f64 = repeated.iter().map(|again| (again[index] - own[index]).powi(2)).sum();
        COVERAGE * (square / repeated.len().max(1) as f64).sqrt()
    };
    let mut uncertainty = LoopFigures::from_all(std::array::from_fn(width));
    // What lies between rows is alike on both branches: it adds up.
    let between = |torque: f64| cleaned.iter().map(|one| one.between_rows(torque)).sum::<f64>();
    let reading = LOST_MOTION_SHARE * rated;
    let (coarse, coarse_at_zero) = (0.5 * (between(reading) + between(-reading)), between(0.0));
    uncertainty.lost_motion = uncertainty.lost_motion.hypot(coarse);
    uncertainty.backlash = uncertainty.backlash.hypot(drift).hypot(coarse_at_zero);
    // Lines that are too long for a bend are off by the square of their length: halved ones by a quarter of that.
    let shorter: Vec<LoopPoint> =
        cleaned.iter().flat_map(|one| one.points(&one.halved.0, &one.halved.1)).collect();
    if let Ok(shorter) = evaluate(&shorter) {
        let (own, other) = (figures.all(), shorter.all());
        let widths = uncertainty.all();
        uncertainty =
            LoopFigures::from_all(std::array::from_fn(|k| widths[k].hypot(COVERAGE * (own[k] - other[k]))));
    }
    how.coarse = Some(coarse.max(coarse_at_zero)).filter(|off| *off > TOO_COARSE * figures.lost_motion.abs());
    // Friction takes work: the branch on which the torque falls is the one with the larger angle.
    if figures.backlash < -2.0 * uncertainty.backlash && figures.backlash < -0.01 * span(&all) {
        how.reversed = true;
        cleaned.reverse();
        for one in &mut cleaned {
            one.branch = match one.branch {
                Branch::Falling => Branch::Rising,
                Branch::Rising => Branch::Falling,
            };
            one.torque.reverse();
            one.angle.reverse();
        }
        all = points(&cleaned);
        figures = evaluate(&all).map_err(bad)?;
    }
    how.steps = cleaned.iter().filter_map(|one| one.steps).max();
    let most = |lines: fn(&Cleaned) -> &Option<Lines>| {
        let lines = cleaned.iter().filter_map(|one| lines(one).as_ref());
        lines.map(|lines| (lines.noise, lines.longest())).reduce(|a, b| (a.0.max(b.0), a.1.max(b.1)))
    };
    how.torque = most(|one| &one.torque_lines);
    how.angle = most(|one| &one.angle_lines);
    let rows = pair
        .iter()
        .flat_map(|sweep| sweep.torque.iter().zip(&sweep.angle).map(|(t, a)| (*t, *a, sweep.branch)))
        .map(|(torque, angle, branch)| LoopPoint { torque, angle, branch })
        .collect();
    Ok(MeasuredLoop { position: 0, rows, points: all, figures, uncertainty, how })
}

fn span(points: &[LoopPoint]) -> f64 {
    let (low, high) = points
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.angle), high.max(p.angle)));
    high - low
}

/// Takes out a drift of the angle that is even over the loop, and gives what the backlash is uncertain by for
/// it, rad.
///
/// The loop of a machine is as wide at + T as at − T. With a drift it is not: the branches pass one of the two
/// soon after each other and the other at the ends of the test.
fn take_drift_out(branches: &mut [Cleaned], how: &mut How) -> f64 {
    let [one, two] = &branches[..] else { return 0.0 };
    let angles = [one, two].map(|branch| branch.points(&branch.torque, &branch.angle));
    let orders = [one, two].map(|branch| branch.points(&branch.torque, &branch.order));
    let reach = angles
        .iter()
        .flat_map(|branch| {
            [1.0, -1.0].map(|sign| branch.iter().fold(0.0, |m: f64, p| m.max(sign * p.torque)))
        })
        .fold(f64::INFINITY, f64::min);
    let (first, last) = (one.order[0], two.order[two.order.len() - 1]);
    let between = |branches: &[Vec<LoopPoint>; 2], torque: f64| -> Option<f64> {
        Some(angle_at(&branches[0], torque)? - angle_at(&branches[1], torque)?)
    };
    let drifts: Vec<f64> = (0..10)
        .filter_map(|step| {
            let torque = (0.5 + 0.05 * f64::from(step)) * reach;
            let wider = between(&angles, torque)? - between(&angles, -torque)?;
            let later = between(&orders, torque)? - between(&orders, -torque)?;
            Some(wider / later * (last - first)).filter(|drift| drift.is_finite())
        })
        .collect();
    if drifts.len() < 5 {
        return 0.0;
    }
    let drift = mean(&drifts);
    let deviation = mean(&drifts.iter().map(|one| (one - drift).powi(2)).collect::<Vec<_>>()).sqrt();
    let all: Vec<LoopPoint> = angles.into_iter().flatten().collect();
    if drift.abs() < 3.0 * deviation || drift.abs() < 0.01 * span(&all) {
        return 0.5 * drift.abs();
    }
    how.drift = Some(drift);
    for branch in branches {
        for (row, order) in branch.order.iter().enumerate() {
            let drifted = drift * ((order - first) / (last - first) - 0.5);
            branch.angle[row] -= drifted;
            branch.halved.1[row] -= drifted;
        }
    }
    0.1 * drift.abs()
}

/// How the loops were read, each thing once for all of them.
fn say_how(loops: &[MeasuredLoop], remarks: &mut Vec<Remark>) {
    let mut say = |text: String| remarks.push(Remark::of_all(text));
    let all =
        |of: fn(&How) -> Option<f64>| -> Vec<f64> { loops.iter().filter_map(|one| of(&one.how)).collect() };
    if loops.iter().any(|one| one.how.reversed) {
        say("the rising branch lies above the falling one, as if the loop gave work: the rows are taken in reverse".into());
    }
    let drifts = all(|how| how.drift);
    if !drifts.is_empty() {
        say(format!(
            "the angle drifts by {:.3} arcmin a loop (the loop is wider at one end than at the other): an even drift is taken out",
            mean(&drifts) / ARCMIN
        ));
    }
    if let Some(steps) = loops.iter().filter_map(|one| one.how.steps).max() {
        say(format!(
            "the torque is held at steps ({steps} on a branch): each is read as the mean of its second half"
        ));
    }
    let lines = |of: fn(&How) -> Option<(f64, usize)>| {
        loops.iter().filter_map(|one| of(&one.how)).reduce(|a, b| (a.0.max(b.0), a.1.max(b.1)))
    };
    for (what, unit, scale, lines) in
        [("torque", "N·m", 1.0, lines(|how| how.torque)), ("angle", "arcmin", ARCMIN, lines(|how| how.angle))]
    {
        if let Some((noise, longest)) = lines.filter(|(noise, _)| *noise > 0.0) {
            say(format!(
                "the {what} scatters by {} {unit} (one standard deviation): it is read from straight lines through up to {longest} rows",
                two_digits(noise / scale)
            ));
        }
    }
    let coarse = all(|how| how.coarse).into_iter().fold(0.0, f64::max);
    if coarse > 0.0 {
        say(format!(
            "rows are far apart where the angle goes fast, so that lost motion and backlash are known to {} arcmin alone: \
             measure every 1 % of the rated torque between −5 % and +5 %",
            two_digits(coarse / ARCMIN)
        ));
    }
}

/// Two significant digits.
fn two_digits(value: f64) -> String {
    let decimals = (1.0 - value.abs().log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$}")
}
