//! What drives and loads the machine, from the options.

use super::{DriveKind, LoadKind, Options};
use crate::analyses::{AnalysisError, Host, inputs::table};
use crate::contact::ContactLaw;
use crate::design::{Choice, InputFile};
use crate::dynamics::{Drive, OutputLoad, TimeTable};
use crate::machine::Machine;
use crate::tables::{Column, Form};
use crate::units::RPM;

choice! {
    /// Law of the contacts between flank and pins.
    Law {
        /// Hertzian line contact (Johnson)
        LineHertz = "line-hertz",
        /// force in proportion to approach
        Linear = "linear",
        /// approach in proportion to force^0.9 (Palmgren)
        Palmgren = "palmgren",
        /// eq. (6) of Tao2024
        Tao2024 = "tao2024",
        /// F = k δ^e with step-wise damping
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
                    "this contact law has no stiffness of its own",
                    "give it as contact_stiffness, in N/m^e",
                )
            })?;
            Some(ContactLaw::Impact { stiffness, exponent: options.contact_exponent })
        }
    })
}

pub(super) fn drive(options: &Options, machine: &Machine, host: &dyn Host) -> Result<Drive, AnalysisError> {
    let speed = options.speed_rpm.map_or(machine.rated.input_speed, |rpm| rpm * RPM);
    let rise_time = options.rise_s;
    let rows = |column: &'static str, unit: f64| {
        let file = needed(&options.drive_file, "this drive needs a file", "drive_file")?;
        let rows = pairs(file, Column::number("time_s").rising(), column, unit, host)?;
        TimeTable::new("drive table", &rows).map_err(AnalysisError::compute("read the drive"))
    };
    if !matches!(options.drive, DriveKind::SpeedTable | DriveKind::TorqueTable) {
        unread(&options.drive_file, "drive_file", "drive = speed-table or torque-table")?;
    }
    Ok(match options.drive {
        DriveKind::Speed => Drive::SpeedLaw { speed, rise_time },
        DriveKind::Angle => Drive::AngleLaw { speed, rise_time },
        DriveKind::SpeedTable => Drive::SpeedTable(rows("speed_rpm", RPM)?),
        DriveKind::TorqueTable => Drive::TorqueTable(rows("torque_n_m", 1.0)?),
        DriveKind::Governed => Drive::Governed { speed, rise_time, gain: options.gain },
    })
}

pub(super) fn load(
    options: &Options,
    machine: &Machine,
    host: &dyn Host,
) -> Result<OutputLoad, AnalysisError> {
    let torque = options.torque_nm.unwrap_or(machine.rated.torque);
    let rows = |first: Column| {
        let file = needed(&options.load_file, "this load needs a file", "load_file")?;
        pairs(file, first, "torque_n_m", 1.0, host)
    };
    let time = || Column::number("time_s").rising();
    if !matches!(options.load, LoadKind::Table | LoadKind::Stepped | LoadKind::DutyCycle) {
        unread(&options.load_file, "load_file", "load = table, stepped or duty-cycle")?;
    }
    if options.load == LoadKind::None && options.torque_nm.is_some() {
        return Err(AnalysisError::usage(
            "a torque loads nothing here (torque_nm)",
            "it goes with load = constant or sine",
        ));
    }
    Ok(match options.load {
        LoadKind::None => OutputLoad::None,
        LoadKind::Constant => OutputLoad::Constant { torque },
        LoadKind::Sine => OutputLoad::Sine { amplitude: torque, period: options.period_s },
        LoadKind::Table => {
            let table = TimeTable::new("load table", &rows(time())?);
            OutputLoad::Table(table.map_err(AnalysisError::compute("read the load"))?)
        }
        LoadKind::Stepped => OutputLoad::Stepped(rows(time())?),
        LoadKind::DutyCycle => OutputLoad::DutyCycle(rows(Column::number("duration_s").within(1e-9, 1e9))?),
    })
}

fn needed<'a>(
    file: &'a Option<InputFile>,
    message: &str,
    option: &str,
) -> Result<&'a InputFile, AnalysisError> {
    file.as_ref().ok_or_else(|| AnalysisError::usage(message, format!("name it with {option}")))
}

/// A file that is named but would not be read is a mistake.
fn unread(file: &Option<InputFile>, option: &str, choice: &str) -> Result<(), AnalysisError> {
    file.as_ref().map_or(Ok(()), |file| {
        let message = format!("{} would not be read ({option})", file.0);
        Err(AnalysisError::usage(message, format!("it goes with {choice}")))
    })
}

/// Two columns of a file; the second is multiplied by `unit`.
fn pairs(
    file: &InputFile,
    first: Column,
    second: &'static str,
    unit: f64,
    host: &dyn Host,
) -> Result<Vec<(f64, f64)>, AnalysisError> {
    let name = first.name();
    let table = table(file, &Form::new(&[first, Column::number(second)]), host)?;
    let (times, values) = (table.numbers(name)?, table.numbers(second)?);
    Ok(times.iter().zip(values).map(|(time, value)| (*time, value * unit)).collect())
}
