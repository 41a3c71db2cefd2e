//! Drive and load of the machine, from the options.

use super::Options;
use super::motion::{DriveKind, LoadKind, MotionOptions};
use crate::analyses::{AnalysisError, Host, inputs::table};
use crate::contact::ContactLaw;
use crate::design::{Choice, InputFile};
use crate::dynamics::{Drive, OutputLoad, TimeTable};
use crate::machine::DutyPoint;
use crate::report::compact;
use crate::tables::{Column, Form, Naming};
use crate::units::RPM;

choice! {
    /// Law of the contacts between flank and pins.
    Law {
        /// Hertzian line contact (Johnson)
        LineHertz = "line-hertz",
        /// force proportional to approach
        Linear = "linear",
        /// approach proportional to force^0.9 (Palmgren)
        Palmgren = "palmgren",
        /// eq. (6) of Tao2024
        Tao2024 = "tao2024",
        /// F = k δ^e with a damping step
        Impact = "impact",
    }
}

/// Stiffness of one pin of the RV-40E-81 at half its rated torque, as published comparisons use it, in N/m.
const LINEAR_STIFFNESS: f64 = 2.85e8;

pub(super) fn contact_law(options: &Options) -> Result<Option<ContactLaw>, AnalysisError> {
    Ok(match options.contact {
        None => None,
        Some(Law::LineHertz) => Some(ContactLaw::LineHertz),
        Some(Law::Palmgren) => Some(ContactLaw::Palmgren),
        Some(Law::Tao2024) => Some(ContactLaw::Tao2024),
        Some(Law::Linear) => {
            Some(ContactLaw::Linear { stiffness: options.contact_stiffness.unwrap_or(LINEAR_STIFFNESS) })
        }
        Some(Law::Impact) => {
            let stiffness = options.contact_stiffness.ok_or_else(|| {
                AnalysisError::usage(
                    "this contact law needs a stiffness",
                    "give it as contact_stiffness, in N/m^e",
                )
            })?;
            Some(ContactLaw::Impact { stiffness, exponent: options.contact_exponent })
        }
    })
}

/// Drive and load, with notes about their files.
pub(crate) struct Inputs {
    pub drive: Drive,
    pub load: OutputLoad,
    pub notes: Vec<String>,
}

impl Inputs {
    /// By default speed and torque are the rated ones.
    pub fn read(options: &MotionOptions, rated: DutyPoint, host: &dyn Host) -> Result<Inputs, AnalysisError> {
        let (drive, load) = (drive(options, rated, host)?, load(options, rated, host)?);
        Ok(Inputs { drive: drive.value, load: load.value, notes: [drive.notes, load.notes].concat() })
    }
}

/// A drive or a load from the options, with notes about its file.
struct Given<T> {
    value: T,
    notes: Vec<String>,
}

fn drive(options: &MotionOptions, rated: DutyPoint, host: &dyn Host) -> Result<Given<Drive>, AnalysisError> {
    let speed = options.speed_rpm.map_or(rated.input_speed, |rpm| rpm * RPM);
    let rise_time = options.rise_s;
    let mut notes = Vec::new();
    let mut rows = |column: &'static str, unit: f64| {
        let file = needed(&options.drive_file, "this drive needs a file", "drive_file")?;
        let (mut rows, remarks) =
            pairs(file, Column::stamps("time_s").rising(), column, unit, options, host)?;
        notes = remarks;
        notes.extend(from_start(&mut rows, options, file, "value")?);
        TimeTable::new("drive table", &rows).map_err(AnalysisError::compute("read the drive"))
    };
    if !matches!(options.drive, DriveKind::SpeedTable | DriveKind::TorqueTable) {
        unread(&options.drive_file, "drive_file", "drive = speed-table or torque-table")?;
    }
    let value = match options.drive {
        DriveKind::Speed => Drive::SpeedLaw { speed, rise_time },
        DriveKind::Angle => Drive::AngleLaw { speed, rise_time },
        DriveKind::SpeedTable => Drive::SpeedTable(rows("speed_rpm", RPM)?),
        DriveKind::TorqueTable => Drive::TorqueTable(rows("torque_n_m", 1.0)?),
        DriveKind::Governed => Drive::Governed { speed, rise_time, gain: options.gain },
    };
    Ok(Given { value, notes })
}

fn load(
    options: &MotionOptions,
    rated: DutyPoint,
    host: &dyn Host,
) -> Result<Given<OutputLoad>, AnalysisError> {
    let torque = options.torque_nm.unwrap_or(rated.torque);
    let mut notes = Vec::new();
    let mut rows = |first: Column, outside: Option<&str>| {
        let file = needed(&options.load_file, "this load needs a file", "load_file")?;
        let (mut rows, remarks) = pairs(file, first, "torque_n_m", 1.0, options, host)?;
        notes = remarks;
        if let Some(outside) = outside {
            notes.extend(from_start(&mut rows, options, file, outside)?);
        }
        Ok::<_, AnalysisError>(rows)
    };
    let time = || Column::stamps("time_s");
    if !matches!(options.load, LoadKind::Table | LoadKind::Stepped | LoadKind::DutyCycle) {
        unread(&options.load_file, "load_file", "load = table, stepped or duty-cycle")?;
    }
    if options.load == LoadKind::None && options.torque_nm.is_some() {
        return Err(AnalysisError::usage(
            "a torque without a load (torque_nm)",
            "add load = constant or sine",
        ));
    }
    let value = match options.load {
        LoadKind::None => OutputLoad::None,
        LoadKind::Constant => OutputLoad::Constant { torque },
        LoadKind::Sine => OutputLoad::Sine { amplitude: torque, period: options.period_s },
        LoadKind::Table => {
            let table = TimeTable::with_jumps("load table", &rows(time().not_falling(), Some("torque"))?);
            OutputLoad::Table(table.map_err(AnalysisError::compute("read the load"))?)
        }
        LoadKind::Stepped => OutputLoad::Stepped(rows(time().rising(), Some("torque"))?),
        LoadKind::DutyCycle => {
            OutputLoad::DutyCycle(rows(Column::number("duration_s").within(1e-9, 1e9), None)?)
        }
    };
    Ok(Given { value, notes })
}

/// s; larger times are clock times.
const CLOCK: f64 = 1e7;

/// Shifts clock times to begin with the first row, and reports parts of the run that the rows do not cover.
fn from_start(
    rows: &mut [(f64, f64)],
    options: &MotionOptions,
    file: &InputFile,
    what: &str,
) -> Result<Vec<String>, AnalysisError> {
    let mut notes = Vec::new();
    let (Some(first), Some(last)) = (rows.first().copied(), rows.last().copied()) else { return Ok(notes) };
    let (file, end) = (&file.0, options.end_s);
    let shift = if first.0 > CLOCK.max(end) { first.0 } else { 0.0 };
    rows.iter_mut().for_each(|row| row.0 -= shift);
    let (from, to) = (first.0 - shift, last.0 - shift);
    if shift > 0.0 {
        notes.push(format!("{file}: its times are clock times, counted from its first row"));
    }
    if from > end || to < 0.0 {
        return Err(AnalysisError::usage(
            format!(
                "{file} covers {} s to {} s, outside the run from 0 to {end} s",
                compact(from, 4),
                compact(to, 4)
            ),
            "shift its times to the run, or set end_s",
        ));
    }
    if from > 0.0 {
        let before = if options.load == LoadKind::Stepped && what == "torque" {
            "there is none before".to_owned()
        } else {
            format!("its first {what} holds before")
        };
        notes.push(format!("{file}: begins at {} s of the run; {before}", compact(from, 4)));
    }
    if to < end {
        notes.push(format!(
            "{file}: ends at {} s of {} s of the run; its last {what} applies to the end",
            compact(to, 4),
            compact(end, 4)
        ));
    }
    Ok(notes)
}

fn needed<'a>(
    file: &'a Option<InputFile>,
    message: &str,
    option: &str,
) -> Result<&'a InputFile, AnalysisError> {
    file.as_ref().ok_or_else(|| AnalysisError::usage(message, format!("name it with {option}")))
}

/// A named file that these options do not read is an error.
fn unread(file: &Option<InputFile>, option: &str, choice: &str) -> Result<(), AnalysisError> {
    file.as_ref().map_or(Ok(()), |file| {
        let message = format!("{} is not used by these options ({option})", file.0);
        Err(AnalysisError::usage(message, format!("add {choice}")))
    })
}

/// Rows of time and value.
type Rows = Vec<(f64, f64)>;

/// Two columns of a file, the second multiplied by `unit`, and notes of the reader.
fn pairs(
    file: &InputFile,
    first: Column,
    second: &'static str,
    unit: f64,
    options: &MotionOptions,
    host: &dyn Host,
) -> Result<(Rows, Vec<String>), AnalysisError> {
    let name = first.name();
    let naming = Naming::parse(&options.columns)
        .map_err(|what| AnalysisError::usage(what, "write columns = HEADING=time_s,HEADING=torque_n_m"))?
        .skipping(options.skip_lines);
    let table = table(file, &Form::new(&[first, Column::number(second)]).naming(&naming), host)?;
    let (times, values) = (table.numbers(name)?, table.numbers(second)?);
    if let Some(row) = (2..times.len()).find(|row| times[*row] == times[row - 2]) {
        let remedy = "two rows at one time are a step; keep the first and the last of them";
        return Err(table.wrong(row, "three rows at one time", remedy).into());
    }
    let rows = times.iter().zip(values).map(|(time, value)| (*time, value * unit)).collect();
    Ok((rows, table.notes().iter().map(|note| format!("{}: {note}", file.0)).collect()))
}
