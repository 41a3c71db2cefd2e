//! Hysteresis loops.

use std::ops::Range;

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::branch::{Cleaned, Sweep};
use super::series::{Lines, mean, turning_points};
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
    /// Points that the figures are read from: the rows, or lines through them.
    pub points: Vec<LoopPoint>,
    /// Lost motion, backlash and stiffnesses of this loop.
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
    /// Uncertainty of lost motion and backlash by the distance of the rows, rad; where it is much.
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
/// Part of the lost motion that the distance of the rows may leave uncertain without a word.
const TOO_COARSE: f64 = 0.1;
/// Repetitions with other noise, from which the uncertainty is taken.
const REPETITIONS: usize = 50;
/// Standard deviations of a 95 % interval.
const COVERAGE: f64 = 2.0;

/// Reads the loops of one crank position from rows in the order of the test; `rated` torque in N·m.
///
/// Branches are found from the order of the torque. What is before the first whole branch and behind the last
/// one is left out; whole branches are taken in pairs, each a loop. Where torque or angle go to and fro
/// within a branch, straight lines are laid through their rows (`Lines`) and the loop is read from these.
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
        // Where the file goes back to another beginning there are no rows on the way; noise before the first
        // step gets nowhere.
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
        let remedy = format!("cycle the torque from + rated ({rated} N·m) to − rated and back");
        Unusable::at(first_row, error.to_string(), remedy)
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
    // Differences between rows are alike on both branches: they add up.
    let between = |torque: f64| cleaned.iter().map(|one| one.between_rows(torque)).sum::<f64>();
    let reading = LOST_MOTION_SHARE * rated;
    let (coarse, coarse_at_zero) = (0.5 * (between(reading) + between(-reading)), between(0.0));
    uncertainty.lost_motion = uncertainty.lost_motion.hypot(coarse);
    uncertainty.backlash = uncertainty.backlash.hypot(drift).hypot(coarse_at_zero);
    // Lines that are too long for a bend are off by the square of their length: halved ones by a quarter of
    // that.
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
/// The loop of a machine is as wide at + T as at − T. With a drift it is not: the branches pass one of the
/// two soon after each other and the other at the ends of the test.
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
        say("the rising branch lies above the falling one, as if the loop gave work: the rows are taken in \
             reverse"
            .into());
    }
    let drifts = all(|how| how.drift);
    if !drifts.is_empty() {
        say(format!(
            "the angle drifts by {:.3} arcmin a loop (the loop is wider at one end than at the other): an even \
             drift is taken out",
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
                "the {what} scatters by {} {unit} (one standard deviation): it is read from straight lines through up \
                 to {longest} rows",
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
