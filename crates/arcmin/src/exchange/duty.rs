//! From the log of a joint to a load spectrum.

mod merge;
mod spectrum;

use std::fmt::Write as _;

pub use merge::{DutyRow, Reduction};

use super::{ExchangeError, trimmed};
use crate::machine::Machine;
use crate::report::HeatMap;
use crate::tables::{Column, Form, Table, TableError};
use crate::units::RPM;
use merge::Sample;

/// How a log is read and reduced.
#[derive(Debug, Clone, PartialEq)]
pub struct DutyImportOptions {
    /// Torque of the motor per current in N·m/A, for logs of current.
    pub torque_constant: Option<f64>,
    /// Part of the motor's torque that arrives at the output.
    pub gear_efficiency: f64,
    /// Whether the log's torque is that of the surroundings on the joint. Otherwise it is what the joint
    /// exerts, which drives positive motion where it is positive and has the sign of the duty's torque.
    pub torque_is_outer: bool,
    /// Rows of the spectrum at most.
    pub rows: usize,
    /// Output speed in rad/s below which the joint is at rest; `None`: a thousandth of the largest.
    pub rest_speed: Option<f64>,
    /// Exponent m of wear ∝ |T|^m |ω| t; the engine's law is linear in the pin force.
    pub wear_exponent: f64,
}

impl Default for DutyImportOptions {
    fn default() -> DutyImportOptions {
        DutyImportOptions {
            torque_constant: None,
            gear_efficiency: 1.0,
            torque_is_outer: false,
            rows: 50,
            rest_speed: None,
            wear_exponent: 1.0,
        }
    }
}

/// What a log says.
#[derive(Debug, Clone, PartialEq)]
pub struct DutyImport {
    /// The spectrum while the joint moves; shares add up to 1.
    pub rows: Vec<DutyRow>,
    pub reduction: Reduction,
    /// s, gaps of the recording left out.
    pub duration: f64,
    /// s, of the duration.
    pub at_rest: f64,
    /// s, in which nothing was recorded.
    pub gaps: f64,
    /// Largest |torque| at the output in N·m, its sign kept, and when in s.
    pub peak_torque: (f64, f64),
    /// Largest |torque| while at rest in N·m: what only holds.
    pub holding_torque: f64,
    /// Largest |output speed| in rad/s, its sign kept, and when in s.
    pub peak_speed: (f64, f64),
    /// How often the joint sets off from rest.
    pub starts: usize,
    pub reversals: usize,
    /// Turns of the output in either direction.
    pub output_turns: f64,
    /// The rows as `[[duty]]` of a design.
    pub toml: String,
    pub picture: HeatMap,
}

/// Reads the log of a joint: `time_s`, then torque at the output (`torque_n_m`, `output_torque_n_m`,
/// `joint_torque_n_m`), at the motor (`input_torque_n_m`, `motor_torque_n_m`) or current (`current_a`), then
/// speed or angle of the output (`speed_rpm`, `output_speed_…`, `angle_deg`, …) or of the motor
/// (`input_speed_…`, `motor_speed_…`, `input_angle_…`). Any unit of these; other columns are passed over.
///
/// A reading holds for half the time to its neighbours. Steps in time more than twenty times the median are
/// gaps of the recording. Angles become speeds by central differences.
///
/// # Errors
/// A table that cannot be read, columns that are missing or given twice, a joint that never moves or never
/// carries a load, options out of range.
pub fn import_duty(
    machine: &Machine,
    bytes: &[u8],
    file: &str,
    options: &DutyImportOptions,
) -> Result<DutyImport, ExchangeError> {
    check(options)?;
    let table = form().read(bytes, file)?;
    let time = table.numbers("time_s")?;
    let ratio = machine.kinematics().ratio();
    let mut torque = output_torque(&table, options, ratio)?;
    if options.torque_is_outer {
        torque.iter_mut().for_each(|t| *t = -*t);
    }
    let speed = output_speed(&table, time, ratio)?;
    let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() {
        return Err(table.wrong(0, "one reading is no log", "record at least two").into());
    }
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    let longest = 20.0 * sorted[sorted.len() / 2];
    let gaps: f64 = steps.iter().filter(|step| **step > longest).sum();
    let weight = |i: usize| {
        let before = i.checked_sub(1).and_then(|j| steps.get(j));
        let half = |step: Option<&f64>| step.filter(|step| **step <= longest).map_or(0.0, |step| 0.5 * step);
        half(before) + half(steps.get(i))
    };
    let fastest = largest(&speed, |_| true);
    let rest = options.rest_speed.unwrap_or(1e-3 * fastest.0.abs());
    let moves = |i: usize| speed[i].abs() > rest;
    let samples: Vec<Sample> = (0..table.len())
        .filter(|i| moves(*i))
        .map(|i| Sample { torque: torque[i], speed: speed[i], time: weight(i) })
        .filter(|sample| sample.time > 0.0)
        .collect();
    let nothing =
        |message: &str, remedy: &str| ExchangeError::Fit { message: message.into(), remedy: remedy.into() };
    if samples.is_empty() {
        return Err(nothing(
            "the joint never moves in this log",
            "check the column of speed or angle and its unit",
        ));
    }
    if samples.iter().all(|sample| sample.torque == 0.0) {
        return Err(nothing(
            "the joint carries no torque while it moves",
            "check the column of torque or current",
        ));
    }
    let duration: f64 = (0..table.len()).map(weight).sum();
    let moving: f64 = samples.iter().map(|sample| sample.time).sum();
    let turned: f64 = samples.iter().map(|sample| sample.speed.abs() * sample.time).sum();
    let (rows, reduction) = merge::reduce(&samples, options.rows, options.wear_exponent, ratio);
    let picture = spectrum::picture(&samples, moving);
    let starts = (1..table.len()).filter(|i| moves(*i) && !moves(i - 1)).count();
    let mut direction = 0.0;
    let mut reversals = 0;
    for i in (0..table.len()).filter(|i| moves(*i)) {
        reversals += usize::from(direction * speed[i] < 0.0);
        direction = speed[i].signum();
    }
    let peak = largest(&torque, |_| true);
    let holding = largest(&torque, |i| !moves(i)).0.abs();
    let mut import = DutyImport {
        rows,
        reduction,
        duration,
        at_rest: duration - moving,
        gaps,
        peak_torque: (peak.0, time[peak.1]),
        holding_torque: holding,
        peak_speed: (fastest.0, time[fastest.1]),
        starts,
        reversals,
        output_turns: turned / std::f64::consts::TAU,
        toml: String::new(),
        picture,
    };
    import.toml = toml(&import);
    Ok(import)
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
    within("a speed of rest in rad/s", options.rest_speed.unwrap_or(0.0), 0.0, 1e4)?;
    within("an exponent of wear", options.wear_exponent, 0.1, 10.0)
}

fn form() -> Form {
    Form::new(&[
        Column::number("time_s").also(&["t", "timestamp"]).rising(),
        Column::number("torque_n_m").also(&["output_torque", "joint_torque"]).optional().within(-1e7, 1e7),
        Column::number("input_torque_n_m").also(&["motor_torque"]).optional().within(-1e7, 1e7),
        Column::number("current_a").also(&["motor_current"]).optional().within(-1e6, 1e6),
        Column::number("speed_rad_s")
            .also(&["output_speed", "joint_speed", "velocity"])
            .optional()
            .within(-1e4, 1e4),
        Column::number("input_speed_rad_s").also(&["motor_speed"]).optional().within(-1e5, 1e5),
        Column::number("angle_rad")
            .also(&["output_angle", "joint_angle", "position"])
            .optional()
            .within(-1e9, 1e9),
        Column::number("input_angle_rad").also(&["motor_angle"]).optional().within(-1e9, 1e9),
    ])
    .with_others()
}

/// The one column of several that the file has.
fn one_of<'a>(table: &Table, names: &[&'a str], what: &str) -> Result<&'a str, TableError> {
    let found: Vec<&str> = names.iter().copied().filter(|name| table.has(name)).collect();
    match found[..] {
        [one] => Ok(one),
        [] => Err(header(
            table,
            format!("there is no column of {what}"),
            format!("name one of {}", names.join(", ")),
        )),
        _ => Err(header(
            table,
            format!("{what} is given more than once: {}", found.join(", ")),
            "rename or delete all but one".to_owned(),
        )),
    }
}

fn header(table: &Table, message: String, remedy: String) -> TableError {
    // Rows end before this one, so the line is that of the header.
    table.wrong(usize::MAX, message, remedy)
}

fn output_torque(table: &Table, options: &DutyImportOptions, ratio: f64) -> Result<Vec<f64>, TableError> {
    let name = one_of(table, &["torque_n_m", "input_torque_n_m", "current_a"], "torque or current")?;
    let factor = match (name, options.torque_constant) {
        ("torque_n_m", _) => 1.0,
        ("input_torque_n_m", _) => ratio * options.gear_efficiency,
        (_, Some(constant)) => constant * ratio * options.gear_efficiency,
        (_, None) => {
            return Err(header(
                table,
                "current is no torque yet".to_owned(),
                "give the motor's torque constant in N·m/A".to_owned(),
            ));
        }
    };
    Ok(table.numbers(name)?.iter().map(|value| value * factor).collect())
}

fn output_speed(table: &Table, time: &[f64], ratio: f64) -> Result<Vec<f64>, TableError> {
    let names = ["speed_rad_s", "input_speed_rad_s", "angle_rad", "input_angle_rad"];
    // A log often has both; the speed is the better one.
    let name = match one_of(table, &names[..2], "speed") {
        Ok(name) => name,
        Err(_) if !table.has(names[0]) && !table.has(names[1]) => {
            one_of(table, &names[2..], "speed or angle")?
        }
        Err(error) => return Err(error),
    };
    let values = table.numbers(name)?;
    let factor = if name.starts_with("input") { 1.0 / ratio } else { 1.0 };
    if name.contains("speed") {
        return Ok(values.iter().map(|value| value * factor).collect());
    }
    let last = values.len() - 1;
    Ok((0..values.len())
        .map(|i| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
            if a == b { 0.0 } else { (values[b] - values[a]) / (time[b] - time[a]) * factor }
        })
        .collect())
}

/// The value of the largest size among the indices, and its index; zero if there is none.
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
        "# From a log of {} h, of which {} h at rest.",
        hours(import.duration),
        hours(import.at_rest)
    );
    let _ = writeln!(
        text,
        "# {} readings became {} rows; against the log they are off by {} % (wear), {} % (bearing load), {} % (life).",
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
