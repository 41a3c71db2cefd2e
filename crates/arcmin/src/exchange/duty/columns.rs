//! Columns of a log, and the side of the reducer to which they belong.

use super::JointRating;
use super::clock;
use super::{DutyImportOptions, ExchangeError};
use crate::report::compact;
use crate::tables::{Column, Form, Table, TableError};
use crate::units::{DEG, RPM};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Output,
    Motor,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Torque,
    Current,
    Speed,
    Angle,
}

/// A column of the log in SI units, for its own side.
#[derive(Debug, Clone)]
pub(super) struct Signal {
    pub name: &'static str,
    pub kind: Kind,
    pub side: Side,
    /// Whether the name in the file contains the side, output or motor.
    pub has_side: bool,
    pub values: Vec<f64>,
}

/// Readings of a log: times from 0, torque or current, speed or angle.
pub(super) struct Readings {
    pub time: Vec<f64>,
    pub load: Signal,
    pub motion: Signal,
    pub notes: Vec<String>,
}

const LOADS: [(&str, Kind, Side); 3] = [
    ("torque_n_m", Kind::Torque, Side::Output),
    ("input_torque_n_m", Kind::Torque, Side::Motor),
    ("current_a", Kind::Current, Side::Motor),
];
const SPEEDS: [(&str, Kind, Side); 2] =
    [("speed_rad_s", Kind::Speed, Side::Output), ("input_speed_rad_s", Kind::Speed, Side::Motor)];
const ANGLES: [(&str, Kind, Side); 2] =
    [("angle_rad", Kind::Angle, Side::Output), ("input_angle_rad", Kind::Angle, Side::Motor)];

fn form(options: &DutyImportOptions) -> Form {
    let column =
        |name: &'static str, reach: f64| Column::number(name).optional().with_gaps().within(-reach, reach);
    Form::new(&[
        Column::stamps("time_s").also(&["t", "timestamp", "zeit", "date", "datetime"]).not_falling(),
        column("torque_n_m", 1e7).also(&["output_torque", "joint_torque", "drehmoment", "moment"]),
        column("input_torque_n_m", 1e7).also(&["motor_torque", "motormoment"]),
        column("current_a", 1e6).also(&["motor_current", "motorstrom", "strom"]),
        column("speed_rad_s", 1e4).also(&[
            "output_speed",
            "joint_speed",
            "velocity",
            "joint_velocity",
            "output_velocity",
            "drehzahl",
        ]),
        column("input_speed_rad_s", 1e5).also(&["motor_speed", "motor_velocity", "motordrehzahl"]),
        column("angle_rad", 1e9).also(&[
            "output_angle",
            "joint_angle",
            "position",
            "joint_position",
            "output_position",
            "winkel",
        ]),
        column("input_angle_rad", 1e9).also(&["motor_angle", "motor_position", "motorwinkel"]),
    ])
    .with_others()
    .naming(&options.naming)
}

/// Reads a log.
pub(super) fn read(
    joint: JointRating,
    bytes: &[u8],
    file: &str,
    options: &DutyImportOptions,
) -> Result<Readings, ExchangeError> {
    let table = form(options).read(bytes, file)?;
    let load = one_of(&table, &LOADS, "torque or current")?;
    // If a log has both, the speed is used.
    let motion = match SPEEDS.iter().any(|(name, _, _)| table.has(name)) {
        true => one_of(&table, &SPEEDS, "speed")?,
        false => one_of(&table, &ANGLES, "speed or angle")?,
    };
    if load.1 == Kind::Current && options.torque_constant.is_none() {
        return Err(header(
            &table,
            "the log contains the current instead of the torque",
            "give --torque-constant in N·m/A",
        )
        .into());
    }
    let stamps = table.numbers("time_s")?;
    let (loads, mut motions) = (table.gaps(load.0)?, table.gaps(motion.0)?);
    let mut notes = table.notes().to_vec();
    if motion.1 == Kind::Angle {
        notes.extend(join_angles(&table, motion.0, &mut motions)?);
    }
    // An empty field means that the last value has not changed.
    let begin = (0..table.len()).find(|row| {
        loads[..=*row].iter().any(Option::is_some) && motions[..=*row].iter().any(Option::is_some)
    });
    let Some(begin) = begin else {
        return Err(header(&table, "no row has torque and motion", "check the file for empty columns").into());
    };
    let load = signal(&table, load, held(&loads, begin));
    let motion = match motion.1 {
        Kind::Angle => signal(&table, motion, between(stamps, &motions, begin)),
        _ => signal(&table, motion, held(&motions, begin)),
    };
    let mut readings = Readings {
        time: stamps[begin..].iter().map(|stamp| stamp - stamps[begin]).collect(),
        load,
        motion,
        notes: Vec::new(),
    };
    if readings.time.len() < 2 || readings.time[readings.time.len() - 1] <= 0.0 {
        return Err(table.wrong(0, "all readings have the same time", "record at least two times").into());
    }
    readings.mend_clock(&mut notes);
    readings.check_sides(joint, &table, options, &mut notes)?;
    readings.notes = notes;
    Ok(readings)
}

impl Readings {
    fn mend_clock(&mut self, notes: &mut Vec<String>) {
        let (load, motion) = (&self.load.values, &self.motion.values);
        let same = |i: usize| load[i] == load[i - 1] && motion[i] == motion[i - 1];
        let (note, twice) = clock::mend(&mut self.time, same);
        notes.extend(note);
        if !twice.is_empty() {
            let kept: Vec<usize> = (0..self.time.len()).filter(|i| twice.binary_search(i).is_err()).collect();
            let pick = |values: &[f64]| kept.iter().map(|i| values[*i]).collect::<Vec<f64>>();
            self.time = pick(&self.time);
            self.load.values = pick(&self.load.values);
            self.motion.values = pick(&self.motion.values);
        }
        let start = self.time[0];
        self.time.iter_mut().for_each(|time| *time -= start);
    }

    /// Names without a side are taken as those of the output, unless their magnitudes contradict this.
    fn check_sides(
        &self,
        joint: JointRating,
        table: &Table,
        options: &DutyImportOptions,
        notes: &mut Vec<String>,
    ) -> Result<(), TableError> {
        let ratio = joint.ratio;
        let (load, motion) = (&self.load, &self.motion);
        if !motion.has_side {
            let rated = joint.input_speed / ratio.abs();
            let fast = self.usual_speed() / rated;
            if fast > 5.0 {
                let name = table.meant(motion.name);
                let message = format!(
                    "at the output, {name} would be {} rpm where it moves, {} times the rated {} rpm",
                    compact(fast * rated / RPM, 3),
                    compact(fast, 2),
                    compact(rated / RPM, 3)
                );
                return Err(header(table, message, &sides(table, motion.name)));
            }
        }
        let peak = load.values.iter().fold(0.0_f64, |peak, value| peak.max(value.abs()));
        let rated = joint.torque;
        if load.kind == Kind::Torque && !load.has_side {
            let like_motor = peak < 0.05 * rated && peak * ratio.abs() > 0.2 * rated;
            let name = table.meant(load.name);
            let sized = format!(
                "at the output, {name} would be {} N·m at most, {} % of the rated torque, but as the motor's it would \
                 be {} N·m there",
                compact(peak, 3),
                compact(100.0 * peak / rated, 2),
                compact(peak * ratio.abs(), 3)
            );
            if like_motor && motion.side == Side::Motor {
                return Err(header(table, sized, &sides(table, load.name)));
            }
            if like_motor {
                notes.push(format!("{sized}: name it motor_torque_n_m if it is"));
            } else if motion.side == Side::Motor {
                notes.push(format!("{name} is taken as the output's, though the motion is the motor's"));
            }
        }
        if load.side == Side::Motor {
            if options.gear_efficiency == 1.0 {
                notes.push("losses between motor and output are not subtracted (--efficiency)".to_owned());
            }
            if options.rotor_inertia == 0.0 {
                notes.push(
                    "the torque that accelerates the rotor is not subtracted (--rotor-inertia)".to_owned(),
                );
            }
        }
        Ok(())
    }

    /// rad/s; root mean square of the faster half of the nonzero speeds.
    fn usual_speed(&self) -> f64 {
        let mut sizes: Vec<f64> = match self.motion.kind {
            Kind::Angle => (1..self.time.len())
                .map(|i| {
                    let step = self.time[i] - self.time[i - 1];
                    ((self.motion.values[i] - self.motion.values[i - 1]) / step).abs()
                })
                .collect(),
            _ => self.motion.values.iter().map(|value| value.abs()).collect(),
        };
        let most = clock::quantile(&sizes, 0.999);
        sizes.retain(|size| *size > 0.01 * most && *size <= most);
        clock::median(&sizes)
    }
}

/// Unwraps the angles of the file, and returns a note about it.
fn join_angles(table: &Table, name: &str, values: &mut [Option<f64>]) -> Result<Option<String>, TableError> {
    let rows: Vec<usize> = (0..values.len()).filter(|row| values[*row].is_some()).collect();
    let mut given: Vec<f64> = values.iter().flatten().copied().collect();
    if given.is_empty() {
        return Ok(None);
    }
    let written = table.written(name);
    let degrees = |period: f64| compact(period / DEG, 6);
    let joined = super::angle::join(&mut given).map_err(|lost| {
        let message = format!(
            "{written} restarts every {}° and jumps by about half of that here, so that the direction is ambiguous",
            degrees(lost.period)
        );
        let remedy = "record faster, or record the speed or an angle that counts turns";
        table.wrong(rows[lost.at], message, remedy)
    })?;
    rows.iter().zip(given).for_each(|(row, angle)| values[*row] = Some(angle));
    Ok(joined.map(|(period, jumps)| {
        format!(
            "{written} starts anew every {}°, {jumps} times in the log: joined to one angle",
            degrees(period)
        )
    }))
}

/// Torque and speed repeat the previous value; the first field may be empty.
fn held(values: &[Option<f64>], begin: usize) -> Vec<f64> {
    let mut last = values[..=begin].iter().rev().flatten().next().copied().unwrap_or(0.0);
    let hold = |value: &Option<f64>| {
        last = value.unwrap_or(last);
        last
    };
    values[begin..].iter().map(hold).collect()
}

/// Angles are interpolated linearly between the rows that contain them.
fn between(time: &[f64], values: &[Option<f64>], begin: usize) -> Vec<f64> {
    let given: Vec<(f64, f64)> =
        time.iter().zip(values).filter_map(|(time, value)| Some((*time, (*value)?))).collect();
    let mut next = 0;
    let value = |(time, value): (&f64, &Option<f64>)| {
        if let Some(value) = value {
            return *value;
        }
        while next < given.len() && given[next].0 <= *time {
            next += 1;
        }
        match (next.checked_sub(1).map(|before| given[before]), given.get(next)) {
            (Some((from, a)), Some((to, b))) => a + (b - a) * (time - from) / (to - from),
            (Some((_, a)), None) => a,
            (None, after) => after.map_or(0.0, |after| after.1),
        }
    };
    time.iter().zip(values).skip(begin).map(value).collect()
}

fn signal(table: &Table, (name, kind, side): (&'static str, Kind, Side), values: Vec<f64>) -> Signal {
    let meant = table.meant(name).to_lowercase();
    let has_side = ["output", "joint", "load", "motor", "input"].iter().any(|word| meant.contains(word))
        || kind == Kind::Current;
    Signal { name, kind, side, has_side, values }
}

/// Remedy if the side of a column is ambiguous.
fn sides(table: &Table, name: &str) -> String {
    let written = table.written(name);
    let (quantity, unit) = match name {
        "torque_n_m" => ("torque", "n_m"),
        "angle_rad" => ("angle", "deg"),
        _ => ("speed", "rpm"),
    };
    // The unit of the file is kept if its name contains one.
    let ending =
        written.split_once('_').filter(|(first, _)| *first == quantity).map_or(unit, |(_, ending)| ending);
    format!(
        "assign the side with --columns \"{written}=motor_{quantity}_{ending}\" or \
         \"{written}=output_{quantity}_{ending}\""
    )
}

/// The only one of several possible columns that the file contains.
fn one_of<const N: usize>(
    table: &Table,
    columns: &[(&'static str, Kind, Side); N],
    what: &str,
) -> Result<(&'static str, Kind, Side), TableError> {
    let found: Vec<_> = columns.iter().copied().filter(|column| table.has(column.0)).collect();
    match found[..] {
        [one] => Ok(one),
        [] => {
            let names: Vec<&str> = columns.iter().map(|column| column.0).collect();
            let mut remedy = format!("the file has {}; name one of {}", table.names(), names.join(", "));
            if !table.proposal().is_empty() {
                remedy += &format!(
                    ", or assign the columns, such as --columns \"{}\" (motor_… where it is the motor's)",
                    table.proposal()
                );
            }
            Err(header(table, format!("there is no column of {what}"), &remedy))
        }
        _ => {
            let written: Vec<&str> = found.iter().map(|column| table.written(column.0)).collect();
            let message = format!("{what} is given more than once: {}", written.join(", "));
            let remedy = format!("ignore one of them with --columns \"{}=-\"", written[1]);
            Err(header(table, message, &remedy))
        }
    }
}

fn header(table: &Table, message: impl Into<String>, remedy: &str) -> TableError {
    // The row number is beyond the last row, so that the error refers to the header.
    table.wrong(usize::MAX, message, remedy)
}
