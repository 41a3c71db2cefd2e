//! Load spectrum from the log of a joint.

mod angle;
mod clock;
mod columns;
mod holding;
mod merge;
mod motor;
mod rest;
mod spectrum;

use std::fmt::Write as _;

pub use merge::{DutyRow, Reduction};

use super::{ExchangeError, trimmed};
use crate::machine::{DutyPoint, Machine};
use crate::report::{HeatMap, compact};
use crate::tables::Naming;
use crate::units::RPM;
use columns::{Kind, Readings, Side};
use merge::Sample;

/// Options for reading and reduction of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct DutyImportOptions {
    /// Torque of the motor per current in N·m/A, for logs of current.
    pub torque_constant: Option<f64>,
    /// Efficiency of the power transmission in either direction: for a motor torque τ the output torque is τ i
    /// η if the motor drives and τ i/η if the load drives.
    pub gear_efficiency: f64,
    /// Moment of inertia of the motor's rotor in kg·m², for torques and currents of the motor: the torque that
    /// accelerates the rotor is subtracted.
    pub rotor_inertia: f64,
    /// Whether the log's torque is that of the surroundings on the joint. Otherwise it is the torque of the
    /// joint, positive if it drives positive motion, with the sign of the duty's torque.
    pub torque_is_outer: bool,
    /// Largest number of rows of the spectrum.
    pub rows: usize,
    /// Output speed in rad/s below which the joint counts as at rest; `None`: from the noise of the log.
    pub rest_speed: Option<f64>,
    /// Longest step in s for which a reading remains valid, longer ones are gaps; `None`: twenty times the
    /// median of the steps, and at least an hour if the log seems to be recorded on change.
    pub largest_gap: Option<f64>,
    /// Names of columns given by the user.
    pub naming: Naming,
    /// Exponent m of wear ∝ |T|^m |ω| t; the wear law of this library is linear in the pin force.
    pub wear_exponent: f64,
}

impl Default for DutyImportOptions {
    fn default() -> DutyImportOptions {
        DutyImportOptions {
            torque_constant: None,
            gear_efficiency: 1.0,
            rotor_inertia: 0.0,
            torque_is_outer: false,
            rows: 50,
            rest_speed: None,
            largest_gap: None,
            naming: Naming::default(),
            wear_exponent: 1.0,
        }
    }
}

/// Rated values of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointRating {
    /// Turns of the input per turn of the output.
    pub ratio: f64,
    /// Torque at the output, N·m, magnitude.
    pub torque: f64,
    /// Speed of the input, rad/s, magnitude.
    pub input_speed: f64,
}

impl From<&Machine> for JointRating {
    fn from(machine: &Machine) -> JointRating {
        let DutyPoint { torque, input_speed, .. } = machine.rated;
        JointRating {
            ratio: machine.kinematics().ratio(),
            torque: torque.abs(),
            input_speed: input_speed.abs(),
        }
    }
}

/// Result of the import of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct DutyImport {
    /// The spectrum during motion; shares add up to 1.
    pub rows: Vec<DutyRow>,
    /// Deviations of these rows from all readings.
    pub reduction: Reduction,
    /// Number of readings in the log.
    pub readings: usize,
    /// Duration in s, without gaps of the recording.
    pub duration: f64,
    /// Time at rest in s, part of the duration.
    pub at_rest: f64,
    /// Output speed in rad/s below which the joint is taken to rest.
    pub rest_speed: f64,
    /// Total length of gaps in the recording, s.
    pub gaps: f64,
    /// Longest step in s for which a reading remains valid; longer ones are gaps.
    pub longest_held: f64,
    /// Output torque of largest magnitude in N·m, signed, and its time in s.
    pub peak_torque: (f64, f64),
    /// Largest |torque| at rest in N·m: the holding torque.
    pub holding_torque: f64,
    /// Output speed of largest magnitude in rad/s, signed, and its time in s.
    pub peak_speed: (f64, f64),
    /// Number of starts from rest.
    pub starts: usize,
    /// Number of reversals of the output.
    pub reversals: usize,
    /// Turns of the output in either direction.
    pub output_turns: f64,
    /// Values that were changed, assumed or ignored, as sentences.
    pub notes: Vec<String>,
    /// The rows as `[[duty]]` of a design.
    pub toml: String,
    /// Share of the time as a function of torque and speed.
    pub picture: HeatMap,
}

/// Reads the log of a joint: `time_s`, then torque at the output (`torque_n_m`, `output_torque_n_m`,
/// `joint_torque_n_m`), at the motor (`input_torque_n_m`, `motor_torque_n_m`) or current (`current_a`), then
/// speed or angle of the output (`speed_rpm`, `output_speed_…`, `angle_deg`, …) or of the motor
/// (`input_speed_…`, `motor_speed_…`, `input_angle_…`), in any of the units. Other columns are ignored.
///
/// A reading is valid until the next one; steps longer than [`DutyImportOptions::largest_gap`] are gaps. Empty
/// fields repeat the previous value. Angles that restart after whole turns are unwrapped and differentiated
/// over one step, or over as many as their noise requires. A column whose name does not contain its side is
/// taken as that of the output, unless its magnitude contradicts this, which causes an error or a note.
///
/// # Errors
/// A table that cannot be read, columns that are missing or given twice, a log without motion or without load,
/// options out of range.
pub fn import_duty(
    joint: impl Into<JointRating>,
    bytes: &[u8],
    file: &str,
    options: &DutyImportOptions,
) -> Result<DutyImport, ExchangeError> {
    check(options)?;
    let joint = joint.into();
    let ratio = joint.ratio;
    let Readings { time, load, motion, mut notes, .. } = columns::read(joint, bytes, file, options)?;
    let count = time.len();
    let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let holding = holding::of(&time, [&load.values, &motion.values], options.largest_gap);
    let connected: Vec<bool> = (0..count).map(|i| i > 0 && steps[i - 1] <= holding.longest).collect();
    let long: Vec<f64> = steps.iter().copied().filter(|step| *step > holding.longest).collect();
    let gaps = long.iter().fold(0.0, |sum, step| sum + step);
    notes.extend(held_note(&steps, &long, holding));

    let own_side = if motion.side == Side::Motor { 1.0 / ratio } else { 1.0 };
    let angle::Speeds { mut speeds, blurred, noise } = match motion.kind {
        Kind::Angle => angle::speeds(&time, &motion.values, &|i| connected[i]),
        _ => angle::Speeds { speeds: motion.values, blurred: 1, noise: 0.0 },
    };
    speeds.iter_mut().for_each(|speed| *speed *= own_side);
    let (speed, noise) = (speeds, noise * own_side.abs());
    let split = rest::Motion { time: &time, speed: &speed, connected: &connected, blurred, noise };
    let split = split.split(options.rest_speed);
    let mut torque = match load.side {
        Side::Output => load.values,
        Side::Motor => motor::output_torque(&motor::Shaft {
            time: &time,
            torque: match (load.kind, options.torque_constant) {
                (Kind::Current, Some(constant)) => {
                    load.values.iter().map(|current| current * constant).collect()
                }
                _ => load.values,
            },
            speed: &speed,
            connected: &connected,
            moves: &split.moves,
            ratio,
            efficiency: options.gear_efficiency,
            rotor_inertia: options.rotor_inertia,
        }),
    };
    if options.torque_is_outer {
        torque.iter_mut().for_each(|t| *t = -*t);
    }

    let weight = |i: usize| if i + 1 < count && connected[i + 1] { steps[i] } else { 0.0 };
    let samples: Vec<Sample> = (0..count)
        .filter(|i| split.moves[*i])
        .map(|i| Sample { torque: torque[i], speed: speed[i], time: weight(i) })
        .filter(|sample| sample.time > 0.0)
        .collect();
    let nothing =
        |message: &str, remedy: &str| ExchangeError::Fit { message: message.into(), remedy: remedy.into() };
    if samples.is_empty() || samples.iter().all(|sample| sample.speed == 0.0) {
        return Err(nothing(
            "this log contains no motion of the joint",
            "check the column of speed or angle and its unit, and --rest-speed if it is given",
        ));
    }
    if samples.iter().all(|sample| sample.torque == 0.0) {
        return Err(nothing(
            "the torque is zero whenever the joint moves",
            "check the column of torque or current",
        ));
    }
    let duration: f64 = (0..count).map(weight).sum();
    let moving: f64 = samples.iter().map(|sample| sample.time).sum();
    let turned: f64 = samples.iter().map(|sample| sample.speed.abs() * sample.time).sum();
    let (rows, reduction) = merge::reduce(&samples, options.rows, options.wear_exponent, ratio);
    let picture = spectrum::picture(&samples, moving);
    let peak = largest(&torque, |_| true);
    let fastest = largest(&speed, |i| split.moves[i]);
    let mut import = DutyImport {
        rows,
        reduction,
        readings: count,
        duration,
        at_rest: duration - moving,
        rest_speed: split.speed,
        gaps,
        longest_held: holding.longest.min(steps.iter().copied().fold(0.0, f64::max)),
        peak_torque: (peak.0, time[peak.1]),
        holding_torque: largest(&torque, |i| !split.moves[i]).0.abs(),
        peak_speed: (fastest.0, time[fastest.1]),
        starts: split.starts,
        reversals: split.reversals,
        output_turns: turned / std::f64::consts::TAU,
        notes,
        toml: String::new(),
        picture,
    };
    import.toml = toml(&import);
    Ok(import)
}

/// Rows of a duty from readings of a joint in motion: torque in N·m (positive drives positive motion), speed of
/// the output in rad/s, and the time in s that each reading represents.
pub fn reduce_duty(
    readings: &[[f64; 3]],
    rows: usize,
    wear_exponent: f64,
    ratio: f64,
) -> (Vec<DutyRow>, Reduction) {
    let samples: Vec<Sample> = readings
        .iter()
        .map(|[torque, speed, time]| Sample { torque: *torque, speed: *speed, time: *time })
        .collect();
    merge::reduce(&samples, rows, wear_exponent, ratio)
}

/// Note about steps that are much longer than the others.
fn held_note(steps: &[f64], gaps: &[f64], holding: holding::Holding) -> Option<String> {
    let longest = steps.iter().copied().filter(|step| *step <= holding.longest).fold(0.0, f64::max);
    let usual = clock::median(steps);
    let mut note = String::new();
    if longest > 20.0 * usual {
        let why = if holding.on_change { "recorded where values change: " } else { "" };
        let _ = write!(note, "{why}each reading is valid until the next, {} s at most", compact(longest, 4));
    }
    if !gaps.is_empty() {
        let _ = write!(
            note,
            "{}{} steps longer than {} s, {} h in all, are gaps (--largest-gap)",
            if note.is_empty() { "" } else { "; " },
            gaps.len(),
            compact(holding.longest, 4),
            compact(gaps.iter().sum::<f64>() / 3600.0, 4)
        );
    }
    (!note.is_empty()).then_some(note)
}

fn check(options: &DutyImportOptions) -> Result<(), ExchangeError> {
    let within = |what, value: f64, low: f64, high: f64| {
        if (low..=high).contains(&value) {
            Ok(())
        } else {
            Err(ExchangeError::Option { what, value, low, high })
        }
    };
    within("a torque constant in N·m/A", options.torque_constant.unwrap_or(1.0), 1e-6, 1e4)?;
    within("an efficiency", options.gear_efficiency, 0.01, 1.0)?;
    within("a number of rows", options.rows as f64, 8.0, 1000.0)?;
    within("a rotor's moment of inertia in kg·m²", options.rotor_inertia, 0.0, 100.0)?;
    within("a speed of rest in rad/s", options.rest_speed.unwrap_or(0.0), 0.0, 1e4)?;
    within("a largest gap in s", options.largest_gap.unwrap_or(1.0), 1e-6, 1e9)?;
    within("an exponent of wear", options.wear_exponent, 0.1, 10.0)
}

impl DutyImport {
    /// Running time by the clock for a thousand hours in motion, as text.
    pub fn clock_hours(&self) -> String {
        trimmed(1000.0 * self.duration / (self.duration - self.at_rest), 0)
    }
}

/// The value of largest magnitude among the selected indices, and its index; zero if there is none.
fn largest(values: &[f64], counts: impl Fn(usize) -> bool) -> (f64, usize) {
    let best =
        (0..values.len()).filter(|i| counts(*i)).max_by(|a, b| values[*a].abs().total_cmp(&values[*b].abs()));
    best.map_or((0.0, 0), |i| (values[i], i))
}

fn toml(import: &DutyImport) -> String {
    let r = &import.reduction;
    let mut text = String::new();
    let hours = |seconds: f64| trimmed(seconds / 3600.0, 4);
    let _ = writeln!(
        text,
        "# From a log of {} h, of which {} h at rest (below {} rpm at the output) and {} h in motion:",
        hours(import.duration),
        hours(import.at_rest),
        trimmed(import.rest_speed / RPM, 4),
        hours(import.duration - import.at_rest)
    );
    let _ = writeln!(
        text,
        "# 1000 h in motion, as the program counts, are {} h by the clock.",
        import.clock_hours()
    );
    let _ = writeln!(
        text,
        "# {} readings reduced to {} rows; deviations from the log: {} % (wear), {} % (bearing load), {} % (life).",
        r.samples,
        import.rows.len(),
        trimmed(100.0 * r.wear_error, 4),
        trimmed(100.0 * r.bearing_load_error, 4),
        trimmed(100.0 * r.life_error, 4)
    );
    let _ = writeln!(
        text,
        "# Peak {} N m, {} starts, {} reversals. Shares are of the time in motion.",
        trimmed(import.peak_torque.0, 2),
        import.starts,
        import.reversals
    );
    for note in &import.notes {
        let _ = writeln!(text, "# {}", crate::report::printable(note));
    }
    for row in &import.rows {
        let _ = writeln!(
            text,
            "\n[[duty]]\ntorque_n_m = {}\ninput_speed_rpm = {}\nshare = {}",
            trimmed(row.torque, 6),
            trimmed(row.input_speed / RPM, 6),
            trimmed(row.share, 12)
        );
    }
    text
}
