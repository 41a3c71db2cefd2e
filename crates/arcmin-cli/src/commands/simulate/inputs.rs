//! What drives and loads the machine, from the options.

use std::path::Path;

use arcmin::contact::ContactLaw;
use arcmin::dynamics::{Drive, OutputLoad, TimeTable};
use arcmin::machine::Machine;

use super::{DriveKind, Law, LoadKind, Options};
use crate::failure::Failure;

/// Stiffness of one pin of the RV-40E-81 at half its rated torque, as published comparisons use it, in N/m.
const LINEAR_STIFFNESS: f64 = 2.85e8;

pub(super) fn contact_law(options: &Options) -> Result<Option<ContactLaw>, Failure> {
    let stiffness = || {
        options.contact_stiffness.ok_or_else(|| Failure::Usage {
            message: "this contact law has no stiffness of its own".to_owned(),
            help: "give it with --contact-stiffness, e.g. --contact linear --contact-stiffness 2.85e8"
                .to_owned(),
        })
    };
    Ok(match options.contact {
        None => None,
        Some(Law::LineHertz) => Some(ContactLaw::LineHertz),
        Some(Law::Palmgren) => Some(ContactLaw::Palmgren),
        Some(Law::Tao2024) => Some(ContactLaw::Tao2024),
        Some(Law::Linear) => {
            Some(ContactLaw::Linear { stiffness: options.contact_stiffness.unwrap_or(LINEAR_STIFFNESS) })
        }
        Some(Law::Impact) => {
            Some(ContactLaw::Impact { stiffness: stiffness()?, exponent: options.contact_exponent })
        }
    })
}

pub(super) fn drive(options: &Options, machine: &Machine) -> Result<Drive, Failure> {
    let speed = options.speed_rpm.map_or(machine.rated.input_speed, |rpm| rpm * arcmin::units::RPM);
    let rise_time = options.rise_s;
    let table = |unit: f64| read_rows(options.drive_file.as_deref(), "the drive", unit);
    let checked = |rows: Vec<(f64, f64)>| {
        TimeTable::new("drive table", &rows).map_err(Failure::compute("read the drive"))
    };
    Ok(match options.drive {
        DriveKind::Speed => Drive::SpeedLaw { speed, rise_time },
        DriveKind::Angle => Drive::AngleLaw { speed, rise_time },
        DriveKind::SpeedTable => Drive::SpeedTable(checked(table(arcmin::units::RPM)?)?),
        DriveKind::TorqueTable => Drive::TorqueTable(checked(table(1.0)?)?),
        DriveKind::Governed => Drive::Governed { speed, rise_time, gain: options.gain },
    })
}

pub(super) fn load(options: &Options, machine: &Machine) -> Result<OutputLoad, Failure> {
    let torque = options.torque_nm.unwrap_or(machine.rated.torque);
    let rows = || read_rows(options.load_file.as_deref(), "the load", 1.0);
    Ok(match options.load {
        LoadKind::None => OutputLoad::None,
        LoadKind::Constant => OutputLoad::Constant { torque },
        LoadKind::Sine => OutputLoad::Sine { amplitude: torque, period: options.period_s },
        LoadKind::Table => OutputLoad::Table(
            TimeTable::new("load table", &rows()?).map_err(Failure::compute("read the load"))?,
        ),
        LoadKind::Stepped => OutputLoad::Stepped(rows()?),
        LoadKind::DutyCycle => OutputLoad::DutyCycle(rows()?),
    })
}

/// Reads two columns of numbers under one header row; the second is multiplied by `unit`.
fn read_rows(path: Option<&Path>, what: &str, unit: f64) -> Result<Vec<(f64, f64)>, Failure> {
    let Some(path) = path else {
        return Err(Failure::Usage {
            message: format!("{what} needs a file"),
            help: "see --load-file and --drive-file".to_owned(),
        });
    };
    let text =
        std::fs::read_to_string(path).map_err(|cause| Failure::Read { path: path.to_owned(), cause })?;
    let mut rows = Vec::new();
    for (index, line) in text.lines().enumerate().skip(1).filter(|(_, line)| !line.trim().is_empty()) {
        let mut fields = line.split(',').map(|field| field.trim().parse::<f64>());
        match (fields.next(), fields.next()) {
            (Some(Ok(time)), Some(Ok(value))) => rows.push((time, value * unit)),
            _ => {
                return Err(Failure::Usage {
                    message: format!(
                        "{}, line {}: \"{line}\" does not hold two numbers",
                        path.display(),
                        index + 1
                    ),
                    help: "a header line, then lines such as 0.1,412".to_owned(),
                });
            }
        }
    }
    Ok(rows)
}
