//! Transmission errors.

use std::f64::consts::TAU;
use std::ops::Range;

use super::series::{Course, Lines, held, mean, noise, one_way, turning_points};
use super::{FINEST, Remark, Unusable};
use crate::dynamics::{OrderWaves, SpectrumLine};
use crate::rig::ErrorCurve;
use crate::units::{ARCMIN, DEG};

/// A row of a measured transmission error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurnRow {
    /// Angle of the output in rad.
    pub angle: f64,
    /// rad.
    pub error: f64,
    /// As the file gives it: its sign is the sense of rotation.
    pub direction: Option<f64>,
    /// N·m, as the file gives it.
    pub torque: Option<f64>,
}

/// A measured transmission error and what is read from it.
#[derive(Debug, Clone)]
pub struct MeasuredCurve {
    /// Angles that proceed, without drift; the turn is closed where one is whole.
    pub curve: ErrorCurve,
    /// rad; without noise where it can be told from the error.
    pub peak_to_peak: f64,
    /// Half width of the 95 % interval of the mean, rad.
    pub mean_uncertainty: f64,
    /// Half width of the 95 % interval of the peak-to-peak value, rad.
    pub peak_to_peak_uncertainty: f64,
    /// Where a turn is covered.
    pub spectrum: Option<TurnSpectrum>,
}

/// Orders of a measured turn.
#[derive(Debug, Clone)]
pub struct TurnSpectrum {
    /// Lines by orders of the output turn.
    pub lines: Vec<SpectrumLine>,
    /// Half width of the 95 % interval of each amplitude, rad.
    pub uncertainty: Vec<f64>,
    /// Places in which a turn was measured.
    pub places: usize,
}

/// Torques within this share of the rated one belong to one curve.
const SAME_TORQUE: f64 = 0.05;
/// A curve turns back where its angle comes back by this share of its range.
const TURNED: f64 = 0.1;
/// Places closer than this part of their usual distance become one.
const TOO_CLOSE: f64 = 0.2;
/// The last places of a turn may be missing, so many.
const MISSING: f64 = 2.5;
/// Part of a turn without places over which no wave is interpolated.
const GAP: f64 = 0.03;

/// Reads the transmission errors of a file from rows in the order of the test; `rated` torque in N·m.
///
/// A new curve begins where the direction or the torque changes, or the angle turns back. Angles that wrap
/// are counted on. Where an angle repeats, its errors are averaged; where it jitters, it is read from
/// straight lines over the rows. A turn of which no more than the last two places are missing is whole.
///
/// # Errors
/// [`Unusable`]: rows whose angles do not proceed.
pub fn read_turns(rows: &[TurnRow], rated: f64) -> Result<(Vec<MeasuredCurve>, Vec<Remark>), Unusable> {
    let (mut curves, mut remarks) = (Vec::new(), Vec::new());
    let mut start = 0;
    let mut torque = Mean::default();
    for row in 0..=rows.len() {
        let goes_on = rows.get(row).is_some_and(|here| {
            here.direction == rows[start].direction
                && here
                    .torque
                    .zip(torque.value())
                    .is_none_or(|(t, mean)| (t - mean).abs() <= SAME_TORQUE * rated)
        });
        if !goes_on && row > start {
            read_group(rows, start..row, torque.value().unwrap_or(0.0), &mut curves, &mut remarks)?;
            start = row;
            torque = Mean::default();
        }
        if let Some(value) = rows.get(row).and_then(|here| here.torque) {
            torque.add(value);
        }
    }
    Ok((curves, remarks))
}

/// A mean that leaves equal values as they are.
#[derive(Default)]
struct Mean {
    count: f64,
    mean: f64,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.count += 1.0;
        self.mean += (value - self.mean) / self.count;
    }

    fn value(&self) -> Option<f64> {
        (self.count > 0.0).then_some(self.mean)
    }
}

/// Curves of rows with one direction and torque.
fn read_group(
    rows: &[TurnRow],
    group: Range<usize>,
    torque: f64,
    curves: &mut Vec<MeasuredCurve>,
    remarks: &mut Vec<Remark>,
) -> Result<(), Unusable> {
    let angles = counted_on(&rows[group.clone()]);
    let range = |angles: &[f64]| {
        let (low, high) =
            angles.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), a| (l.min(*a), h.max(*a)));
        high - low
    };
    if !(range(&angles) > 0.0) {
        let remedy = "give the angle of the output at every place of the turn, and the error there";
        return Err(Unusable::at(
            group.start,
            "the angle of the output does not change over these places",
            remedy,
        ));
    }
    let turns = turning_points(&angles, TURNED * range(&angles));
    let mut sweeps: Vec<Range<usize>> = Vec::new();
    let mut start = 0;
    for turn in &turns[1..] {
        // Noise at the first place gets nowhere.
        if (angles[*turn] - angles[start]).abs() > 0.02 * range(&angles) {
            sweeps.push(start..turn + 1);
            start = turn + 1;
        }
    }
    let longest = sweeps.iter().map(|sweep| range(&angles[sweep.clone()])).fold(0.0, f64::max);
    for sweep in sweeps {
        let at = group.start + sweep.start..group.start + sweep.end;
        if range(&angles[sweep.clone()]) < 0.5 * longest {
            remarks
                .push(Remark::of_rows(at, "the output turns on or back by less than half a curve: left out"));
            continue;
        }
        let errors: Vec<f64> = rows[at.clone()].iter().map(|row| row.error).collect();
        let said = rows[at.start].direction;
        curves.push(read_curve(&angles[sweep], &errors, (said, torque), at, remarks)?);
    }
    Ok(())
}

/// Angles without the jumps of a full turn by which an encoder begins anew.
fn counted_on(rows: &[TurnRow]) -> Vec<f64> {
    let mut turns = 0.0;
    let mut angles: Vec<f64> = Vec::with_capacity(rows.len());
    for (index, row) in rows.iter().enumerate() {
        if index > 0 {
            let step = row.angle - rows[index - 1].angle;
            // A step of about a turn is no step.
            if (step.abs() - TAU).abs() < 30.0 * DEG {
                turns -= step.signum();
            }
        }
        angles.push(row.angle + turns * TAU);
    }
    angles
}

fn read_curve(
    angles: &[f64],
    errors: &[f64],
    (said, torque): (Option<f64>, f64),
    at: Range<usize>,
    remarks: &mut Vec<Remark>,
) -> Result<MeasuredCurve, Unusable> {
    let wrong = |what: String| {
        let remedy = "give angles that rise or fall over eight places or more, with the error at each";
        Err(Unusable::at(at.start, what, remedy))
    };
    let rising = angles[angles.len() - 1] >= angles[0];
    let mut direction = if rising { 1.0 } else { -1.0 };
    let mut points = proceeding(angles, errors, rising, &at, remarks);
    if points.len() < 8 {
        return wrong(format!("the curve that begins here has {} places", points.len()));
    }
    if said.is_some_and(|said| said * direction < 0.0) {
        remarks.push(Remark::of_rows(
            at.clone(),
            "the angle is counted against the direction given, which counts: it is turned round",
        ));
        direction = -direction;
        points.iter_mut().for_each(|point| point.0 = -point.0);
    }
    let mut steps: Vec<f64> = points.windows(2).map(|pair| (pair[1].0 - pair[0].0).abs()).collect();
    let usual = *steps.select_nth_unstable_by(points.len() / 2 - 1, f64::total_cmp).1;
    let gap = steps.iter().fold(0.0, |m: f64, step| m.max(*step));
    let covered = (points[points.len() - 1].0 - points[0].0).abs();
    let whole = covered >= TAU - MISSING * usual;
    take_drift_out(&mut points, covered, whole, &at, remarks);
    if whole && covered < TAU * (1.0 - 1e-9) {
        close(&mut points, direction, usual);
    }
    let curve = ErrorCurve { direction, torque, points, pins: None };
    let raw = curve.peak_to_peak();
    if whole
        && gap <= GAP * TAU
        && let Some(waves) = OrderWaves::of(&curve.points)
    {
        return Ok(read_waves(curve, &waves, usual));
    }
    let said = match whole {
        true => format!("no place lies within {:.1}° of the turn: no spectrum", gap / DEG),
        false => format!("the curve covers {:.1}° and no whole turn: no spectrum", covered / DEG),
    };
    remarks.push(Remark::of_rows(at, said));
    let (places, errors): (Vec<f64>, Vec<f64>) = curve.points.iter().copied().unzip();
    let lines = Lines::through(&places, &errors, Course::Answer);
    let (low, high) =
        lines.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| (l.min(*e), h.max(*e)));
    Ok(MeasuredCurve {
        peak_to_peak: high - low,
        mean_uncertainty: 2.0 * lines.noise / (curve.points.len() as f64).sqrt(),
        // The lines remove the noise but for a part of it.
        peak_to_peak_uncertainty: (0.5 * (raw - (high - low))).max(0.0),
        spectrum: None,
        curve,
    })
}

/// Places with their errors whose angles proceed.
fn proceeding(
    angles: &[f64],
    errors: &[f64],
    rising: bool,
    at: &Range<usize>,
    remarks: &mut Vec<Remark>,
) -> Vec<(f64, f64)> {
    let sign = if rising { 1.0 } else { -1.0 };
    let as_given = || angles.iter().copied().zip(errors.iter().copied()).collect::<Vec<_>>();
    let mut points = if angles.windows(2).all(|pair| sign * (pair[1] - pair[0]) > 0.0) {
        as_given()
    } else if let Some(held) = held(angles, rising) {
        remarks.push(Remark::of_rows(
            at.clone(),
            format!("angles repeat: errors are averaged at each of {} angles", held.len()),
        ));
        held.into_iter().map(|rows| (mean(&angles[rows.clone()]), mean(&errors[rows]))).collect()
    } else {
        let rows: Vec<f64> = (0..angles.len()).map(|row| row as f64).collect();
        let lines = Lines::through(&rows, angles, Course::Set);
        remarks.push(Remark::of_rows(
            at.clone(),
            format!(
                "angles go to and fro by {:.3}° (one standard deviation): they are read from straight lines through up \
                 to {} rows",
                lines.noise / DEG,
                lines.longest()
            ),
        ));
        one_way(&lines.values, rising).into_iter().zip(errors.iter().copied()).collect()
    };
    // Waves are interpolated between places, which must not lie on each other.
    let usual = (points[points.len() - 1].0 - points[0].0).abs() / points.len() as f64;
    let mut merged: Vec<(f64, f64, f64)> = Vec::new();
    for (angle, error) in points.drain(..) {
        match merged.last_mut() {
            Some((sum, errors, count)) if sign * (angle - *sum / *count) < TOO_CLOSE * usual => {
                (*sum, *errors, *count) = (*sum + angle, *errors + error, *count + 1.0);
            }
            _ => merged.push((angle, error, 1.0)),
        }
    }
    merged.into_iter().map(|(angle, error, count)| (angle / count, error / count)).collect()
}

/// Takes an even drift of the error out, where the same place of another turn shows one.
fn take_drift_out(
    points: &mut [(f64, f64)],
    covered: f64,
    whole: bool,
    at: &Range<usize>,
    remarks: &mut Vec<Remark>,
) {
    if !whole {
        return;
    }
    let (places, errors): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
    let scatter = noise(&places, &errors);
    let last = points.len() - 1;
    let (low, high) =
        errors.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| (l.min(*e), h.max(*e)));
    let (drift, doubt) = if covered > 1.05 * TAU {
        // Every place that was met again a turn later.
        let sign = (places[last] - places[0]).signum();
        let mut before = 0;
        let differences: Vec<f64> = points
            .iter()
            .filter_map(|(place, error)| {
                let then = place - sign * TAU;
                if sign * (then - places[0]) < 0.0 {
                    return None;
                }
                while before + 2 < points.len() && sign * (places[before + 1] - then) < 0.0 {
                    before += 1;
                }
                let share = (then - places[before]) / (places[before + 1] - places[before]);
                Some(error - (errors[before] + share * (errors[before + 1] - errors[before])))
            })
            .collect();
        let drift = mean(&differences);
        let square = differences.iter().map(|one| (one - drift).powi(2)).sum::<f64>();
        (
            drift,
            (square / differences.len() as f64).sqrt() / (differences.len() as f64 / 10.0).max(1.0).sqrt(),
        )
    } else {
        // Both ends of the turn, each taken half of the way to the other.
        let lines = Lines::through(&places, &errors, Course::Answer).values;
        let half = 0.5 * (TAU - covered).max(0.0);
        let slope = |a: usize, b: usize| (lines[b] - lines[a]) / (places[b] - places[a]).abs();
        let end = lines[last] + half * slope(last - 1, last);
        let begin = lines[0] - half * slope(0, 1);
        // Lines at an end lean on one side alone.
        (end - begin, 2.0 * scatter)
    };
    if drift.abs() < 4.0 * doubt || drift.abs() < 0.05 * (high - low) {
        return;
    }
    remarks.push(Remark::of_rows(
        at.clone(),
        format!(
            "the error drifts by {:.3} arcmin a turn: this is taken out as an even drift",
            drift / ARCMIN
        ),
    ));
    let first = places[0];
    points.iter_mut().for_each(|(place, error)| *error -= drift * ((*place - first).abs() / TAU));
}

/// Ends a turn with the place at which it began.
fn close(points: &mut Vec<(f64, f64)>, direction: f64, usual: f64) {
    let (first, last) = (points[0], points[points.len() - 1]);
    let end = first.0 + direction * TAU;
    let near = (end - last.0).abs() < 0.5 * usual;
    if near {
        points.pop();
    }
    points.push((end, if near { 0.5 * (first.1 + last.1) } else { first.1 }));
}

/// Peak to peak and amplitudes of whole turns, with what the noise between the waves leaves uncertain.
///
/// White noise of the standard deviation σ over N places gives every wave an amplitude A with the mean of A²
/// of 4 σ²/N, and its half of that an uncertainty; half of all waves of noise alone are below ln 2 times this
/// mean. So the noise is known from the median of the waves, which single strong ones do not move.
fn read_waves(curve: ErrorCurve, waves: &OrderWaves, usual: f64) -> MeasuredCurve {
    let raw = curve.peak_to_peak();
    let covered = (curve.points[curve.points.len() - 1].0 - curve.points[0].0).abs();
    let places = ((TAU / usual).round() as usize).clamp(8, curve.points.len());
    let turns = (covered / TAU + 1e-9).floor().max(1.0);
    let lines = waves.lines();
    let squares: Vec<f64> = lines.iter().map(|line| line.amplitude.powi(2)).collect();
    let noise_of = |orders: Range<usize>, but: usize| -> f64 {
        let mut near: Vec<f64> = orders
            .filter(|order| order.abs_diff(but) > 1 && *order < squares.len())
            .map(|order| squares[order])
            .collect();
        if near.is_empty() {
            return 0.0;
        }
        let middle = near.len() / 2;
        *near.select_nth_unstable_by(middle, f64::total_cmp).1 / std::f64::consts::LN_2
    };
    let floor = noise_of(places / 8..3 * places / 8, 0);
    // Drift and slow changes raise it at low orders.
    let around = |order: usize| floor.max(noise_of(order.saturating_sub(10).max(1)..order + 11, order));
    let uncertainty: Vec<f64> =
        (0..lines.len()).map(|order| (2.0 * (0.5 * around(order)).sqrt()).max(FINEST * raw)).collect();
    let count = places as f64 * turns;
    let deviation = (0.25 * floor * count).sqrt();
    // Noise alone passes this in one wave of all with a probability of 5 %.
    let significant = floor * (0.5 * places as f64 / 0.05).ln();
    let kept: Vec<usize> =
        (1..places / 2).filter(|order| *order < squares.len() && squares[*order] > significant).collect();
    // Without noise worth the name the error is read as it is.
    let quiet = 6.0 * deviation < 0.01 * raw;
    let peak_to_peak = if quiet { raw } else { waves.peak_to_peak(&kept) };
    let pointwise = if quiet { deviation } else { (0.5 * floor * (kept.len() as f64 + 2.0)).sqrt() };
    MeasuredCurve {
        mean_uncertainty: (2.0 * deviation / count.sqrt()).max(FINEST * raw),
        peak_to_peak,
        peak_to_peak_uncertainty: (2.0 * 2.0_f64.sqrt() * pointwise).max(FINEST * raw),
        spectrum: Some(TurnSpectrum { lines, uncertainty, places }),
        curve,
    }
}
