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
    /// Torque in N·m.
    pub torque: f64,
    /// Angle in rad.
    pub angle: f64,
    /// Branch in the file.
    pub branch: Option<Branch>,
}

/// A measured loop and its values.
#[derive(Debug, Clone)]
pub struct MeasuredLoop {
    /// Number of the crank position in its file: cycles at one position are repetitions.
    pub position: usize,
    /// Rows as measured, in the order of the test and with our signs.
    pub rows: Vec<LoopPoint>,
    /// Points from which the values are read: the rows, or lines through them.
    pub points: Vec<LoopPoint>,
    /// Lost motion, backlash and stiffnesses of this loop.
    pub figures: LoopFigures,
    /// Half widths of the 95 % intervals of the figures.
    pub uncertainty: LoopFigures,
    corrections: Corrections,
}

/// Corrections applied to a loop.
#[derive(Debug, Clone, Default)]
struct Corrections {
    /// Linear drift over the loop that was subtracted, rad.
    drift: Option<f64>,
    reversed: bool,
    /// Uncertainty of lost motion and backlash by the distance of the rows, rad; `None` where it is small.
    coarse: Option<f64>,
    /// Number of torque steps of a branch.
    steps: Option<usize>,
    /// Standard deviation and number of rows of the longest line, for torque (N·m) and angle (rad).
    torque: Option<(f64, usize)>,
    angle: Option<(f64, usize)>,
}

/// Part of the range of torque by which the torque must go back for a reversal.
const TURNED: f64 = 0.3;
/// Part of the range of torque that a branch must cover to be whole.
const WHOLE: f64 = 0.75;
/// Part of the lost motion above which the uncertainty by the distance of the rows is reported.
const TOO_COARSE: f64 = 0.1;
/// Number of repetitions with simulated noise for the uncertainty.
const REPETITIONS: usize = 50;
/// Standard deviations in the half width of a 95 % interval.
const COVERAGE: f64 = 2.0;

/// Reads the loops of one crank position from rows in the order of the test; `rated` torque in N·m.
///
/// Branches are found from the order of the torque. Rows before the first whole branch and after the last one
/// are left out; whole branches are taken in pairs, each a loop. Where torque or angle is noisy within a
/// branch, straight lines are fitted through the rows (`Lines`) and the loop is read from these.
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
    report_corrections(&loops, &mut remarks);
    Ok((loops, remarks))
}

/// Changes the sign of the angle if the angle falls while the torque rises.
fn in_our_sense(rows: &[LoopRow], remarks: &mut Vec<Remark>) -> Vec<LoopRow> {
    let of = |value: fn(&LoopRow) -> f64| mean(&rows.iter().map(value).collect::<Vec<_>>());
    let (torque, angle) = (of(|row| row.torque), of(|row| row.angle));
    let together: f64 = rows.iter().map(|row| (row.torque - torque) * (row.angle - angle)).sum();
    if together >= 0.0 {
        return rows.to_vec();
    }
    remarks.push(Remark::of_all("torque and angle have opposite senses: the sign of the angle is reversed"));
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
        return Err(Unusable::at(0, "these rows are not a loop: the torque does not change", remedy()));
    }
    let turns = turning_points(&torques, TURNED * range);
    let mut ranges: Vec<Range<usize>> = Vec::new();
    let mut start = 0;
    for turn in &turns[1..] {
        // Between two cycles that begin at the same torque the file has no rows of the return; noise before the
        // first step is not a reversal.
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
        let by_torque = if to > from { Branch::Rising } else { Branch::Falling };
        sweeps.push((at.clone(), by_torque, named(&rows[at.clone()])));
    }
    let course = || {
        let places: Vec<String> = turns.iter().take(6).map(|turn| format!("{:.0}", torques[*turn])).collect();
        format!("{} N·m", places.join(" → "))
    };
    // The rows are sorted by torque within named branches.
    let sorted = sweeps.windows(2).any(|pair| pair[0].1 == pair[1].1);
    let contrary = sweeps.iter().all(|(_, by_torque, name)| name.is_some_and(|name| name != *by_torque));
    if sorted && !sweeps.iter().all(|(_, _, name)| name.is_some()) || sweeps.len() < 2 {
        let what = format!("a falling or a rising branch is missing: the torque goes {}", course());
        return Err(Unusable::at(0, what, remedy()));
    }
    if sorted {
        remarks.push(Remark::of_all("the rows are sorted by torque: the names of the branches are used"));
    } else if contrary {
        remarks.push(Remark::of_all(
            "the names of the branches contradict the order of the torque: the order is used",
        ));
    }
    let mut branches: Vec<Sweep> = sweeps
        .into_iter()
        .map(|(at, by_torque, name)| {
            let branch = if sorted { name.unwrap_or(by_torque) } else { by_torque };
            let mut order: Vec<usize> = at.clone().collect();
            if branch != by_torque {
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
        // All cycles of one branch may precede those of the other.
        let (falling, rising): (Vec<Sweep>, Vec<Sweep>) =
            branches.into_iter().partition(|sweep| sweep.branch == Branch::Falling);
        if falling.is_empty() || rising.is_empty() {
            let what = format!("one of the two branches is missing: the torque goes {}", course());
            return Err(Unusable::at(0, what, remedy()));
        }
        branches = falling.into_iter().zip(rising).flat_map(|(falling, rising)| [falling, rising]).collect();
    }
    Ok(branches)
}

/// The name of most rows.
fn named(rows: &[LoopRow]) -> Option<Branch> {
    let count = |branch| rows.iter().filter(|row| row.branch == Some(branch)).count();
    let (falling, rising) = (count(Branch::Falling), count(Branch::Rising));
    (falling + rising > 0).then_some(if falling > rising { Branch::Falling } else { Branch::Rising })
}

fn read_pair(pair: &[Sweep], rated: f64) -> Result<MeasuredLoop, Unusable> {
    let first_row = pair[0].at.start;
    let mut cleaned: Vec<Cleaned> = pair.iter().map(|sweep| Cleaned::new(sweep, rated)).collect();
    let mut corrections = Corrections::default();
    let drift = subtract_drift(&mut cleaned, &mut corrections);
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
    // Interpolation errors are alike on both branches: they are added.
    let between = |torque: f64| cleaned.iter().map(|one| one.between_rows(torque)).sum::<f64>();
    let reading = LOST_MOTION_SHARE * rated;
    let (coarse, coarse_at_zero) = (0.5 * (between(reading) + between(-reading)), between(0.0));
    uncertainty.lost_motion = uncertainty.lost_motion.hypot(coarse);
    uncertainty.backlash = uncertainty.backlash.hypot(drift).hypot(coarse_at_zero);
    // Lines too long for a curvature have an error proportional to the square of their length: lines of half
    // the length have a quarter of it.
    let shorter: Vec<LoopPoint> =
        cleaned.iter().flat_map(|one| one.points(&one.halved.0, &one.halved.1)).collect();
    if let Ok(shorter) = evaluate(&shorter) {
        let (own, other) = (figures.all(), shorter.all());
        let widths = uncertainty.all();
        uncertainty =
            LoopFigures::from_all(std::array::from_fn(|k| widths[k].hypot(COVERAGE * (own[k] - other[k]))));
    }
    corrections.coarse =
        Some(coarse.max(coarse_at_zero)).filter(|off| *off > TOO_COARSE * figures.lost_motion.abs());
    // Friction dissipates energy: the branch with falling torque has the larger angle.
    if figures.backlash < -2.0 * uncertainty.backlash && figures.backlash < -0.01 * span(&all) {
        corrections.reversed = true;
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
    corrections.steps = cleaned.iter().filter_map(|one| one.steps).max();
    let most = |lines: fn(&Cleaned) -> &Option<Lines>| {
        let lines = cleaned.iter().filter_map(|one| lines(one).as_ref());
        lines.map(|lines| (lines.noise, lines.longest())).reduce(|a, b| (a.0.max(b.0), a.1.max(b.1)))
    };
    corrections.torque = most(|one| &one.torque_lines);
    corrections.angle = most(|one| &one.angle_lines);
    let rows = pair
        .iter()
        .flat_map(|sweep| sweep.torque.iter().zip(&sweep.angle).map(|(t, a)| (*t, *a, sweep.branch)))
        .map(|(torque, angle, branch)| LoopPoint { torque, angle, branch })
        .collect();
    Ok(MeasuredLoop { position: 0, rows, points: all, figures, uncertainty, corrections })
}

fn span(points: &[LoopPoint]) -> f64 {
    let (low, high) = points
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.angle), high.max(p.angle)));
    high - low
}

/// Subtracts a linear drift of the angle over the loop, and returns the uncertainty of the backlash due to it,
/// rad.
///
/// The loop of a machine has the same width at + T and − T. With a drift it has not: at one of them the
/// branches pass within a short time, at the other one they are the start and the end of the test.
fn subtract_drift(branches: &mut [Cleaned], corrections: &mut Corrections) -> f64 {
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
    corrections.drift = Some(drift);
    for branch in branches {
        for (row, order) in branch.order.iter().enumerate() {
            let drifted = drift * ((order - first) / (last - first) - 0.5);
            branch.angle[row] -= drifted;
            branch.halved.1[row] -= drifted;
        }
    }
    0.1 * drift.abs()
}

/// Reports the corrections of the loops, each once for all of them.
fn report_corrections(loops: &[MeasuredLoop], remarks: &mut Vec<Remark>) {
    let mut report = |text: String| remarks.push(Remark::of_all(text));
    let all = |of: fn(&Corrections) -> Option<f64>| -> Vec<f64> {
        loops.iter().filter_map(|one| of(&one.corrections)).collect()
    };
    if loops.iter().any(|one| one.corrections.reversed) {
        report("the rising branch lies above the falling one, which would be a gain of energy: the order of the rows is \
             reversed"
            .into());
    }
    let drifts = all(|corrections| corrections.drift);
    if !drifts.is_empty() {
        report(format!(
            "the angle drifts by {:.3} arcmin per loop (the loop is wider at one end than at the other): a linear \
             drift is subtracted",
            mean(&drifts) / ARCMIN
        ));
    }
    if let Some(steps) = loops.iter().filter_map(|one| one.corrections.steps).max() {
        report(format!(
            "the torque is held at steps ({steps} on a branch): each is replaced by the mean of its second half"
        ));
    }
    let lines = |of: fn(&Corrections) -> Option<(f64, usize)>| {
        loops.iter().filter_map(|one| of(&one.corrections)).reduce(|a, b| (a.0.max(b.0), a.1.max(b.1)))
    };
    for (what, unit, scale, lines) in [
        ("torque", "N·m", 1.0, lines(|corrections| corrections.torque)),
        ("angle", "arcmin", ARCMIN, lines(|corrections| corrections.angle)),
    ] {
        if let Some((noise, longest)) = lines.filter(|(noise, _)| *noise > 0.0) {
            report(format!(
                "the {what} has noise of {} {unit} (standard deviation): it is smoothed by straight lines through up to \
                 {longest} rows",
                two_digits(noise / scale)
            ));
        }
    }
    let coarse = all(|corrections| corrections.coarse).into_iter().fold(0.0, f64::max);
    if coarse > 0.0 {
        report(format!(
            "the rows are far apart where the angle changes fast, so that lost motion and backlash have an uncertainty of {} arcmin: \
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
