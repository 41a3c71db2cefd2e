//! Readings: absolute or since new, of one machine or several, from a file or from options.

use super::shorthand;
use crate::analyses::{AnalysisError, Host, inputs};
use crate::design::InputFile;
use crate::report::{compact, significant};
use crate::tables::{Column, Form, Table};
use crate::units::{ARCMIN, HOUR, UM};
use crate::wear::{Measured, New, Reading, Readings};

/// A reading and the machine that it is of.
#[derive(Debug, Clone, PartialEq)]
pub struct Observed {
    /// Name in the file; empty if the file does not distinguish machines.
    pub machine: String,
    /// Time, quantity and value.
    pub reading: Reading,
}

/// Source of the lost motion of a machine when new.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NewIs {
    /// Fitted, since the machine has several readings.
    Fitted,
    /// Given by the caller.
    Given,
    /// Value of the design, since there is a single reading.
    Assumed,
}

/// One measured machine.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MachineReadings {
    pub name: String,
    /// Time of its last reading in s.
    pub last: f64,
    pub new: NewIs,
    /// Largest growth of its lost motion in rad.
    pub scale: f64,
}

/// All readings of a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Observations {
    /// In the order of time.
    pub readings: Vec<Observed>,
    /// In the order of the file; [`Measured::LostMotion`] counts them.
    pub machines: Vec<MachineReadings>,
    /// Readings that were not used, with reasons.
    pub notes: Vec<String>,
}

const DEPTH: Column = Column::number("depth_um").optional().with_gaps().within(0.0, 1e4);
const INCREASE: Column =
    Column::number("lost_motion_increase_arcmin").optional().with_gaps().within(0.0, 600.0);
const ABSOLUTE: Column = Column::number("lost_motion_arcmin").optional().with_gaps().within(-600.0, 600.0);
/// Least value of a reading in the unit of its column; smaller ones are not measurements.
const LEAST: f64 = 1e-6;
/// Relative standard deviation of an assumed lost motion when new: the scatter of machines of one design whose
/// clearances are known by their class only.
pub(super) const ASSUMED_NEW: f64 = 0.2;
/// Standard deviation of one reading if nothing else is known: 3″ of lost motion (a dial gauge of 1 µm on an arm of
/// about 100 mm), 5 % of a depth or an increase.
pub(super) const ASSUMED_READING_ARCMIN: f64 = 0.05;
pub(super) const ASSUMED_SHARE: f64 = 0.05;

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
            Measured::LostMotion(_) => ("lost_motion_arcmin", ARCMIN),
        }
    }
}

/// Reads the file of readings, if there is one, and the readings given as options.
///
/// # Errors
/// [`AnalysisError`]: an invalid file, readings without information.
pub(super) fn read(
    file: Option<&InputFile>,
    shorthand: &[String],
    new: Option<f64>,
    host: &dyn Host,
) -> Result<Observations, AnalysisError> {
    let mut all = Observations { readings: Vec::new(), machines: Vec::new(), notes: Vec::new() };
    if let Some(file) = file {
        from_file(file, new, &mut all, host)?;
    }
    for text in shorthand {
        let machine = all.machine("", 0.0);
        let reading = shorthand::reading(text, machine)?;
        all.machines[machine].last = all.machines[machine].last.max(reading.time);
        all.readings.push(Observed { machine: String::new(), reading });
    }
    if all.readings.is_empty() {
        let why = if all.notes.is_empty() { String::new() } else { format!(": {}", all.notes.join("; ")) };
        let what = file
            .map_or("there is no reading to fit, neither a file (data) nor one reading".to_owned(), |file| {
                format!("{}: there is no reading to fit{why}", file.0)
            });
        return Err(AnalysisError::usage(
            what,
            "give a file (data) with hours and a column depth_um, lost_motion_increase_arcmin (since new) or \
             lost_motion_arcmin (as read), or one reading itself: reading = \"5200h=1.4arcmin\"",
        ));
    }
    all.readings.sort_by(|a, b| a.reading.time.total_cmp(&b.reading.time));
    for machine in 0..all.machines.len() {
        let of = Measured::LostMotion(machine);
        let own = all.readings.iter().filter(|observed| observed.reading.measured == of);
        let times: Vec<f64> = own.map(|observed| observed.reading.time).collect();
        let grew = times.iter().any(|time| *time > times[0]);
        all.machines[machine].new = match (new, grew) {
            (Some(_), _) => NewIs::Given,
            (None, true) => NewIs::Fitted,
            (None, false) => NewIs::Assumed,
        };
    }
    Ok(all)
}

impl Observations {
    /// Number of a machine, which was running at this time in s.
    fn machine(&mut self, name: &str, time: f64) -> usize {
        let known = self.machines.iter().position(|machine| machine.name == name);
        let number = known.unwrap_or_else(|| {
            self.machines.push(MachineReadings {
                name: name.to_owned(),
                last: 0.0,
                new: NewIs::Fitted,
                scale: 1.0,
            });
            self.machines.len() - 1
        });
        self.machines[number].last = self.machines[number].last.max(time);
        number
    }

    /// Readings of the lost motion itself, of these machines.
    pub fn of(&self, machine: usize) -> impl Iterator<Item = &Reading> {
        let of = Measured::LostMotion(machine);
        self.readings.iter().map(|observed| &observed.reading).filter(move |reading| reading.measured == of)
    }

    /// Lost motion of the new machines in rad, given or assumed, and the scales of their readings, which follow from
    /// it.
    ///
    /// # Errors
    /// A machine whose lost motion has not increased since new.
    pub fn settle(&mut self, given: Option<f64>, predicted: f64) -> Result<Vec<Option<New>>, AnalysisError> {
        let mut known = Vec::new();
        for machine in 0..self.machines.len() {
            let new = match self.machines[machine].new {
                NewIs::Fitted => None,
                NewIs::Given => given,
                NewIs::Assumed => Some(predicted),
            };
            if self.of(machine).next().is_none() {
                known.push(None);
                continue;
            }
            let all: Vec<Reading> = self.of(machine).copied().collect();
            let base = new.unwrap_or_else(|| {
                let at_first: Vec<f64> =
                    all.iter().filter(|r| r.time == all[0].time).map(|r| r.value).collect();
                at_first.iter().sum::<f64>() / at_first.len() as f64
            });
            let scale = all.iter().map(|reading| (reading.value - base).abs()).fold(0.0, f64::max);
            // Without growth the scale of a residual is its error.
            let scale = if scale > LEAST * ARCMIN { scale } else { ASSUMED_READING_ARCMIN * ARCMIN };
            let mut later = all.iter().filter(|reading| reading.time > 0.0).peekable();
            if let (Some(new), Some(_)) = (new, later.peek())
                && later.all(|reading| reading.value - new <= LEAST * ARCMIN)
            {
                return Err(self.not_grown(machine, new));
            }
            let of = Measured::LostMotion(machine);
            for observed in self.readings.iter_mut().filter(|observed| observed.reading.measured == of) {
                observed.reading.scale = scale;
            }
            self.machines[machine].scale = scale;
            known.push(new.map(|value| New { value, error: 1.0 }));
        }
        Ok(known)
    }

    fn not_grown(&self, machine: usize, new: f64) -> AnalysisError {
        let largest = self.of(machine).map(|reading| reading.value).fold(f64::NEG_INFINITY, f64::max);
        let last = self.machines[machine].last / HOUR;
        let (source, help) = match self.machines[machine].new {
            NewIs::Assumed => (
                "which is what the design predicts",
                "give the lost motion that the machine had when new (new_arcmin), or a later reading; where \
                 the design predicts too much, its clearances are not those of the machine",
            ),
            _ => ("as given", "check new_arcmin and the unit of the reading; give later readings"),
        };
        AnalysisError::usage(
            format!(
                "{}: {} arcmin after {last:.0} h do not exceed the {} arcmin when new, {source}: there is \
                 no wear to fit",
                self.machines[machine].shown_name(),
                significant(largest / ARCMIN, 3),
                significant(new / ARCMIN, 3),
            ),
            help,
        )
    }
}

fn from_file(
    file: &InputFile,
    new: Option<f64>,
    all: &mut Observations,
    host: &dyn Host,
) -> Result<(), AnalysisError> {
    let hours = Column::number("hours").within(0.0, 1e7);
    let machine = Column::words("machine").optional();
    let table = inputs::table(file, &Form::new(&[hours, machine, DEPTH, INCREASE, ABSOLUTE]), host)?;
    let hours = table.numbers("hours")?;
    let names: &[String] = if table.has("machine") { table.words("machine")? } else { &[] };
    let name = |row: usize| names.get(row).map_or(String::new(), |name| name.trim().to_owned());
    let numbers: Vec<usize> =
        (0..table.len()).map(|row| all.machine(&name(row), hours[row] * HOUR)).collect();
    for (column, measured, unit) in
        [(DEPTH.name(), Measured::Depth, UM), (INCREASE.name(), Measured::Increase, ARCMIN)]
    {
        if table.has(column) {
            since_new(&table, column, measured, unit, &name, all)?;
        }
    }
    if table.has(ABSOLUTE.name()) {
        absolute(&table, new, &numbers, all)?;
    }
    Ok(())
}

/// Depths and increases: their scale is their value; they are zero when new.
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
        // A reading of zero at 0 h has no information.
        if hours[row] == 0.0 && value == 0.0 {
            continue;
        }
        if hours[row] == 0.0 {
            let wrong = format!("{column} counts from new, but is {value} at 0 hours");
            return Err(table.wrong(row, wrong, "use lost_motion_arcmin for the lost motion itself").into());
        }
        if value < LEAST {
            let small = compact(value, 3);
            let wrong = format!("{column} is {small} after {} h; wear cannot give such a value", hours[row]);
            return Err(table
                .wrong(
                    row,
                    wrong,
                    "check the unit in the name of the column; use lost_motion_arcmin for readings \
                     that may also decrease",
                )
                .into());
        }
        let reading = Reading { time: hours[row] * HOUR, measured, value: value * unit, scale: value * unit };
        all.readings.push(Observed { machine: name(row), reading });
    }
    Ok(())
}

/// Readings of the lost motion itself.
fn absolute(
    table: &Table,
    new: Option<f64>,
    numbers: &[usize],
    all: &mut Observations,
) -> Result<(), AnalysisError> {
    let (hours, values) = (table.numbers("hours")?, table.gaps(ABSOLUTE.name())?);
    for (number, machine) in all.machines.iter().enumerate() {
        let own: Vec<(usize, f64, f64)> = values
            .iter()
            .enumerate()
            .filter(|(row, _)| numbers[*row] == number)
            .filter_map(|(row, value)| Some((row, hours[row] * HOUR, (*value)? * ARCMIN)))
            .collect();
        let start = own.iter().map(|(_, time, _)| *time).fold(f64::INFINITY, f64::min);
        let at_start: Vec<f64> =
            own.iter().filter(|(_, time, _)| *time == start).map(|(_, _, value)| *value).collect();
        let first = at_start.iter().sum::<f64>() / at_start.len().max(1) as f64;
        let later = || own.iter().filter(|(_, time, _)| *time > start);
        let grown = later().any(|(_, _, value)| value - first > LEAST * ARCMIN);
        if new.is_none() && !grown && later().next().is_some() {
            let row = own.iter().map(|(row, _, _)| *row).max().unwrap_or(0);
            let wrong =
                format!("the lost motion of {} has not grown since its first reading", machine.shown_name());
            return Err(table.wrong(row, wrong, "there is no wear to fit; give later readings").into());
        }
        for (_, time, value) in own {
            let reading = Reading { time, measured: Measured::LostMotion(number), value, scale: 1.0 };
            all.readings.push(Observed { machine: machine.name.clone(), reading });
        }
    }
    Ok(())
}

impl Observed {
    /// Readings of the fit with the lost motion of their machines when new.
    pub(super) fn together(fitted: &[Observed], new: &[Option<New>]) -> Readings {
        Readings { all: fitted.iter().map(|observed| observed.reading).collect(), new: new.to_vec() }
    }
}
