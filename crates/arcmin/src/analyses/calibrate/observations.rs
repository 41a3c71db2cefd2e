//! Readings as they come: absolute or since new, of one machine or of several.

use crate::analyses::{AnalysisError, Host, inputs};
use crate::design::InputFile;
use crate::tables::{Column, Form, Table};
use crate::units::{ARCMIN, HOUR, UM};
use crate::wear::{Measured, Reading};

/// A reading and the machine that it is of.
#[derive(Debug, Clone, PartialEq)]
pub struct Observed {
    /// As the file calls it; empty where it does not tell machines apart.
    pub machine: String,
    pub reading: Reading,
}

/// What a file says of one machine.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MachineReadings {
    pub name: String,
    /// Time in s and value in rad of its first reading of the lost motion itself.
    pub first: Option<(f64, f64)>,
    /// Time of its last reading in s.
    pub last: f64,
}

/// All readings of a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Observations {
    /// In the order of time.
    pub readings: Vec<Observed>,
    /// In the order of the file.
    pub machines: Vec<MachineReadings>,
    /// What could not be used, and why.
    pub notes: Vec<String>,
}

const DEPTH: Column = Column::number("depth_um").optional().with_gaps().within(0.0, 1e4);
const INCREASE: Column =
    Column::number("lost_motion_increase_arcmin").optional().with_gaps().within(0.0, 600.0);
const ABSOLUTE: Column = Column::number("lost_motion_arcmin").optional().with_gaps().within(-600.0, 600.0);
/// Readings smaller than these, in the unit of their column, are no measurement.
const LEAST: f64 = 1e-6;

impl MachineReadings {
    pub fn shown_name(&self) -> String {
        if self.name.is_empty() { "the machine measured".to_owned() } else { self.name.clone() }
    }
}

impl Observed {
    /// Column of the reading, and its unit in SI.
    pub fn column(&self) -> (&'static str, f64) {
        match self.reading.measured {
            Measured::Depth => ("depth_um", UM),
            Measured::Increase => ("lost_motion_increase_arcmin", ARCMIN),
            Measured::Since(_) => ("lost_motion_since_first_arcmin", ARCMIN),
        }
    }
}

/// Reads a file of readings.
///
/// # Errors
/// [`AnalysisError`]: a file that cannot be used, readings that say nothing.
pub(super) fn read(file: &InputFile, host: &dyn Host) -> Result<Observations, AnalysisError> {
    let hours = Column::number("hours").within(0.0, 1e7);
    let machine = Column::words("machine").optional();
    let table = inputs::table(file, &Form::new(&[hours, machine, DEPTH, INCREASE, ABSOLUTE]), host)?;
    let hours = table.numbers("hours")?;
    let names: &[String] = if table.has("machine") { table.words("machine")? } else { &[] };
    let name = |row: usize| names.get(row).map_or(String::new(), |name| name.trim().to_owned());
    let mut machines: Vec<MachineReadings> = Vec::new();
    for row in 0..table.len() {
        let (name, time) = (name(row), hours[row] * HOUR);
        match machines.iter_mut().find(|machine| machine.name == name) {
            Some(machine) => machine.last = machine.last.max(time),
            None => machines.push(MachineReadings { name, first: None, last: time }),
        }
    }
    let mut all = Observations { readings: Vec::new(), machines, notes: Vec::new() };
    for (column, measured, unit) in
        [(DEPTH.name(), Measured::Depth, UM), (INCREASE.name(), Measured::Increase, ARCMIN)]
    {
        if table.has(column) {
            since_new(&table, column, measured, unit, &name, &mut all)?;
        }
    }
    if table.has(ABSOLUTE.name()) {
        absolute(&table, &name, &mut all)?;
    }
    if all.readings.is_empty() {
        let why = if all.notes.is_empty() { String::new() } else { format!(": {}", all.notes.join("; ")) };
        return Err(AnalysisError::usage(
            format!("{}: there is no reading to fit{why}", file.0),
            "give a column depth_um, lost_motion_increase_arcmin (since new) or lost_motion_arcmin (as read, \
             twice at least)",
        ));
    }
    all.readings.sort_by(|a, b| a.reading.time.total_cmp(&b.reading.time));
    Ok(all)
}

/// Depths and increases: their own scale, and nothing when new.
fn since_new(
    table: &Table,
    column: &str,
    measured: Measured,
    unit: f64,
    name: &dyn Fn(usize) -> String,
    all: &mut Observations,
) -> Result<(), AnalysisError> {
    let (hours, values) = (table.numbers("hours")?, table.gaps(column)?);
    for (row, value) in values.into_iter().enumerate() {
        let Some(value) = value else { continue };
        // That the new machine has lost nothing says nothing.
        if hours[row] == 0.0 && value == 0.0 {
            continue;
        }
        if hours[row] == 0.0 {
            let wrong = format!("{column} counts from new, but is {value} at 0 hours");
            return Err(table
                .wrong(row, wrong, "write lost_motion_arcmin for the lost motion as it was read")
                .into());
        }
        if value < LEAST {
            let wrong = format!("{column} is {value} after {} h, which no coefficient makes", hours[row]);
            return Err(table
                .wrong(row, wrong, "check the unit in the column's name; readings that may also fall go into lost_motion_arcmin")
                .into());
        }
        let reading = Reading { time: hours[row] * HOUR, measured, value: value * unit, scale: value * unit };
        all.readings.push(Observed { machine: name(row), reading });
    }
    Ok(())
}

/// Lost motion as it was read: counted from the first reading of its machine.
fn absolute(
    table: &Table,
    name: &dyn Fn(usize) -> String,
    all: &mut Observations,
) -> Result<(), AnalysisError> {
    let (hours, values) = (table.numbers("hours")?, table.gaps(ABSOLUTE.name())?);
    for machine in &mut all.machines {
        let own: Vec<(usize, f64, f64)> = values
            .iter()
            .enumerate()
            .filter(|(row, _)| name(*row) == machine.name)
            .filter_map(|(row, value)| Some((row, hours[row] * HOUR, (*value)? * ARCMIN)))
            .collect();
        let start = own.iter().map(|(_, time, _)| *time).fold(f64::INFINITY, f64::min);
        // Readings at the same first time are one: their mean.
        let at_start: Vec<f64> =
            own.iter().filter(|(_, time, _)| *time == start).map(|(_, _, value)| *value).collect();
        if own.len() <= at_start.len() {
            if !own.is_empty() {
                let name = machine.shown_name();
                all.notes.push(format!("{name} was read at one time only: there is nothing it grew from"));
            }
            continue;
        }
        let first = at_start.iter().sum::<f64>() / at_start.len() as f64;
        let later = || own.iter().filter(|(_, time, _)| *time > start);
        let scale = later().map(|(_, _, value)| (value - first).abs()).fold(0.0, f64::max);
        if later().all(|(_, _, value)| value - first <= LEAST * ARCMIN) {
            let row = own.iter().map(|(row, _, _)| *row).max().unwrap_or(0);
            let wrong =
                format!("the lost motion of {} has not grown since its first reading", machine.shown_name());
            return Err(table.wrong(row, wrong, "there is no wear to fit; give later readings").into());
        }
        machine.first = Some((start, first));
        for (_, time, value) in later() {
            let reading =
                Reading { time: *time, measured: Measured::Since(start), value: value - first, scale };
            all.readings.push(Observed { machine: machine.name.clone(), reading });
        }
    }
    Ok(())
}
