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
    /// Transmission error in rad.
    pub error: f64,
    /// Direction in the file: its sign is the sense of rotation.
    pub direction: Option<f64>,
    /// Torque in N·m in the file.
    pub torque: Option<f64>,
}

/// A measured transmission error and its values.
#[derive(Debug, Clone)]
pub struct MeasuredCurve {
    /// The curve with monotonic angles, without drift; closed if it covers a turn.
    pub curve: ErrorCurve,
    /// Peak-to-peak value in rad; without noise where noise and error can be separated.
    pub peak_to_peak: f64,
    /// Half width of the 95 % interval of the mean, rad.
    pub mean_uncertainty: f64,
    /// Half width of the 95 % interval of the peak-to-peak value, rad.
    pub peak_to_peak_uncertainty: f64,
    /// Spectrum if the curve covers a turn.
    pub spectrum: Option<TurnSpectrum>,
}

/// Orders of a measured turn.
#[derive(Debug, Clone)]
pub struct TurnSpectrum {
    /// Lines by orders of the output turn.
    pub lines: Vec<SpectrumLine>,
    /// Half width of the 95 % interval of each amplitude, rad.
    pub uncertainty: Vec<f64>,
    /// Number of positions of the turn.
    pub places: usize,
}

/// Torques within this share of the rated one belong to one curve.
const SAME_TORQUE: f64 = 0.05;
/// A curve reverses where its angle goes back by this share of its range.
const TURNED: f64 = 0.1;
/// Positions closer than this part of their median distance are merged.
const TOO_CLOSE: f64 = 0.2;
/// A turn counts as whole if at most this many of its last positions are missing.
const MISSING: f64 = 2.5;
/// Largest gap, as a part of a turn, over which the orders are interpolated.
const GAP: f64 = 0.03;

/// Reads the transmission errors of a file from rows in the order of the test; `rated` torque in N·m.
///
/// A new curve begins where the direction or the torque changes, or the angle reverses. Jumps of a full turn
/// are removed. Where an angle repeats, its errors are averaged; noisy angles are smoothed by straight lines
/// over the rows. A turn with at most its last two positions missing is whole.
///
/// # Errors
/// [`Unusable`]: rows whose angles are not monotonic.
pub fn read_turns(rows: &[TurnRow], rated: f64) -> Result<(Vec<MeasuredCurve>, Vec<Remark>), Unusable> {
    let (mut curves, mut remarks) = (Vec::new(), Vec::new());
    let mut start = 0;
    let mut torque = Mean::default();
    for row in 0..=rows.len() {
        let continues = rows.get(row).is_some_and(|here| {
            here.direction == rows[start].direction
                && here
                    .torque
                    .zip(torque.value())
                    .is_none_or(|(t, mean)| (t - mean).abs() <= SAME_TORQUE * rated)
        });
        if !continues && row > start {
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

/// A mean that keeps equal values exactly.
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
        let remedy = "give the angle of the output and the error at every position of the turn";
        return Err(Unusable::at(
            group.start,
            "the angle of the output does not change over these rows",
            remedy,
        ));
    }
    let turns = turning_points(&angles, TURNED * range(&angles));
    let mut sweeps: Vec<Range<usize>> = Vec::new();
    let mut start = 0;
    for turn in &turns[1..] {
        // Noise at the first position is not a reversal.
        if (angles[*turn] - angles[start]).abs() > 0.02 * range(&angles) {
            sweeps.push(start..turn + 1);
            start = turn + 1;
        }
    }
    let longest = sweeps.iter().map(|sweep| range(&angles[sweep.clone()])).fold(0.0, f64::max);
    for sweep in sweeps {
        let at = group.start + sweep.start..group.start + sweep.end;
        if range(&angles[sweep.clone()]) < 0.5 * longest {
            remarks.push(Remark::of_rows(
                at,
                "these rows cover less than half of the range of the longest curve: left out",
            ));
            continue;
        }
        let errors: Vec<f64> = rows[at.clone()].iter().map(|row| row.error).collect();
        let said = rows[at.start].direction;
        curves.push(read_curve(&angles[sweep], &errors, (said, torque), at, remarks)?);
    }
    Ok(())
}

/// Angles without the jumps of a full turn where an encoder restarts.
fn counted_on(rows: &[TurnRow]) -> Vec<f64> {
    let mut turns = 0.0;
    let mut angles: Vec<f64> = Vec::with_capacity(rows.len());
    for (index, row) in rows.iter().enumerate() {
        if index > 0 {
            let step = row.angle - rows[index - 1].angle;
            // A difference of about a turn is a restart of the encoder.
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
        let remedy = "give angles that rise or fall over eight positions or more, with the error at each";
        Err(Unusable::at(at.start, what, remedy))
    };
    let rising = angles[angles.len() - 1] >= angles[0];
    let mut direction = if rising { 1.0 } else { -1.0 };
    let mut points = proceeding(angles, errors, rising, &at, remarks);
    if points.len() < 8 {
        return wrong(format!("the curve that begins here has {} positions", points.len()));
    }
    if said.is_some_and(|said| said * direction < 0.0) {
        remarks.push(Remark::of_rows(
            at.clone(),
            "the sense of the angle contradicts the direction given: the sign of the angle is reversed",
        ));
        direction = -direction;
        points.iter_mut().for_each(|point| point.0 = -point.0);
    }
    let mut steps: Vec<f64> = points.windows(2).map(|pair| (pair[1].0 - pair[0].0).abs()).collect();
    let usual = *steps.select_nth_unstable_by(points.len() / 2 - 1, f64::total_cmp).1;
    let gap = steps.iter().fold(0.0, |m: f64, step| m.max(*step));
    let covered = (points[points.len() - 1].0 - points[0].0).abs();
    let whole = covered >= TAU - MISSING * usual;
    subtract_drift(&mut points, covered, whole, &at, remarks);
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
        true => format!("the turn has a gap of {:.1}° without positions: no spectrum", gap / DEG),
        false => format!("the curve covers {:.1}°, less than a whole turn: no spectrum", covered / DEG),
    };
    remarks.push(Remark::of_rows(at, said));
    let (places, errors): (Vec<f64>, Vec<f64>) = curve.points.iter().copied().unzip();
    let lines = Lines::through(&places, &errors, Course::Answer);
    let (low, high) =
        lines.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), e| (l.min(*e), h.max(*e)));
    Ok(MeasuredCurve {
        peak_to_peak: high - low,
        mean_uncertainty: 2.0 * lines.noise / (curve.points.len() as f64).sqrt(),
        // The lines remove most of the noise; the rest is uncertainty.
        peak_to_peak_uncertainty: (0.5 * (raw - (high - low))).max(0.0),
        spectrum: None,
        curve,
    })
}

/// Positions with their errors, with monotonic angles.
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
                "the angle has noise of {:.3}° (standard deviation): it is smoothed by straight lines through up to {} \
                 rows",
                lines.noise / DEG,
                lines.longest()
            ),
        ));
        one_way(&lines.values, rising).into_iter().zip(errors.iter().copied()).collect()
    };
    // The interpolation of the orders needs distinct positions.
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

/// Subtracts a linear drift of the error, if positions that occur in two turns show one.
fn subtract_drift(
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
        // All positions that occur again one turn later.
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
        // Both ends of the turn, each extrapolated over half of the gap between them.
        let lines = Lines::through(&places, &errors, Course::Answer).values;
        let half = 0.5 * (TAU - covered).max(0.0);
        let slope = |a: usize, b: usize| (lines[b] - lines[a]) / (places[b] - places[a]).abs();
        let end = lines[last] + half * slope(last - 1, last);
        let begin = lines[0] - half * slope(0, 1);
        // Lines at an end use rows on one side only.
        (end - begin, 2.0 * scatter)
    };
    if drift.abs() < 4.0 * doubt || drift.abs() < 0.05 * (high - low) {
        return;
    }
    remarks.push(Remark::of_rows(
        at.clone(),
        format!("the error drifts by {:.3} arcmin per turn: a linear drift is subtracted", drift / ARCMIN),
    ));
    let first = places[0];
    points.iter_mut().for_each(|(place, error)| *error -= drift * ((*place - first).abs() / TAU));
}

/// Closes a turn with its first position.
fn close(points: &mut Vec<(f64, f64)>, direction: f64, usual: f64) {
    let (first, last) = (points[0], points[points.len() - 1]);
    let end = first.0 + direction * TAU;
    let near = (end - last.0).abs() < 0.5 * usual;
    if near {
        points.pop();
    }
    points.push((end, if near { 0.5 * (first.1 + last.1) } else { first.1 }));
}

/// Peak-to-peak value and amplitudes of whole turns, with their uncertainty by noise.
///
/// White noise of the standard deviation σ over N positions gives every order an amplitude A with the mean
/// square 4 σ²/N, half of which is the variance of a measured amplitude; the median of A² of pure noise is ln 2
/// times this mean. So the noise is estimated from the median over the orders, which single strong orders do
/// not change.
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
    // Drift and slow changes raise the noise at low orders.
    let around = |order: usize| floor.max(noise_of(order.saturating_sub(10).max(1)..order + 11, order));
    let uncertainty: Vec<f64> =
        (0..lines.len()).map(|order| (2.0 * (0.5 * around(order)).sqrt()).max(FINEST * raw)).collect();
    let count = places as f64 * turns;
    let deviation = (0.25 * floor * count).sqrt();
    // With pure noise, one order of all exceeds this with a probability of 5 %.
    let significant = floor * (0.5 * places as f64 / 0.05).ln();
    let kept: Vec<usize> =
        (1..places / 2).filter(|order| *order < squares.len() && squares[*order] > significant).collect();
    // If the noise is negligible, the peak-to-peak value is that of the measured points.
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
