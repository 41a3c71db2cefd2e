//! Wear of the flanks and ring pins of a single stage over the hours.

use std::ops::Deref;

use super::meshing::course;
use super::{HasPartWear, StageBodies, StageJoints, part_wear_columns};
use crate::analyses::wear::{self, Station, WearOverHours};
use crate::analyses::{AnalysisError, Host, Outcome, Said};
use crate::design::{Choice, StageDesign, default, default_word, optional, options};
use crate::machine::PartWear;
use crate::report::Page;
use crate::results::{DeclaredTable, Summary, SummaryOf, Table, TableOf};
use crate::units::{HOUR, UM};
use crate::wear::CoupledOptions;

pub const ABOUT: &str = "Compute the wear of the flanks over the hours of service";

options! {
    /// Options of `wear` for a single stage.
    pub struct Options {
        /// Joints.
        joints: StageJoints => default_word("bearings"),
        /// Bodies.
        bodies: StageBodies => default_word("rigid"),
        /// Wear model.
        mode: StageMode => default_word("coupled"),
        /// Hours to compute. Left out: the service life of the design.
        hours: Option<f64> => optional(0.0, 1e7),
        /// Number of times at which results are written, between new and the end.
        points: usize => default(30.0, 1.0, 10_000.0),
        /// Largest wear depth between two updates of the flank.
        increment_um: f64 => default(0.8, 1e-3, 10.0),
    }
}

/// How wear and load are coupled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StageMode {
    Coupled,
}

impl Choice for StageMode {
    const WORDS: &'static [(&'static str, &'static str)] =
        &[("coupled", "wear and load sharing change each other; single stages have no other model")];
    const VALUES: &'static [StageMode] = &[StageMode::Coupled];
}

/// Wear of a single stage.
#[derive(Debug, Clone)]
pub struct StageWear(WearOverHours);

impl Deref for StageWear {
    type Target = WearOverHours;

    fn deref(&self) -> &WearOverHours {
        &self.0
    }
}

impl HasPartWear for Station {
    fn part_wear(&self) -> &PartWear {
        &self.state.part_wear
    }
}

impl HasPartWear for StageWear {
    fn part_wear(&self) -> &PartWear {
        self.last().part_wear()
    }
}

pub const SUMMARY: SummaryOf<StageWear> = SummaryOf {
    entries: || {
        let mut entries = wear::entries();
        entries.extend(part_wear_columns());
        entries
    },
};

/// That of an RV reducer, and what has worn beside flanks and ring pins.
const HISTORY: TableOf<Station> = TableOf {
    name: wear::HISTORY.name,
    what: wear::HISTORY.what,
    columns: || {
        let mut columns = (wear::HISTORY.columns)();
        columns.extend(part_wear_columns());
        columns
    },
};

/// The tables of an RV reducer that do not need its manufacturing errors.
pub fn tables() -> Vec<DeclaredTable> {
    let own = |table: DeclaredTable| if table.name == HISTORY.name { HISTORY.into() } else { table };
    wear::tables().into_iter().filter(|table| table.name.starts_with("wear")).map(own).collect()
}

/// What the model contains.
pub(super) const PHYSICS: &str = "joints of the whole drive with their clearances, bodies rigid but for their contacts and \
                                  output pins; flanks, pins and holes wear, bearings where the design says how fast";

/// Wears the drive.
///
/// # Errors
/// [`AnalysisError`] where the design gives no wear, or no load sharing is found.
pub fn run(design: &StageDesign, options: &Options, host: &dyn Host) -> Result<StageWear, AnalysisError> {
    let end = options.hours.unwrap_or(design.limits().service_life / HOUR);
    let increment = options.increment_um * UM;
    let settings = CoupledOptions { depth_increment: increment, ..CoupledOptions::default() };
    let course = course(design, settings)?;
    let drive = (design.name.value.clone(), design.stage().profile.clone());
    wear::over_hours(course, drive, (end, options.points), increment, host).map(StageWear)
}

impl Outcome for StageWear {
    fn summary(&self) -> Summary {
        SUMMARY.fill(self)
    }

    fn tables(&self) -> Vec<Table> {
        let own =
            |table: Table| if table.name == HISTORY.name { HISTORY.fill(&self.stations) } else { table };
        wear::tables_of(self).into_iter().map(own).collect()
    }

    fn said(&self) -> Vec<Said> {
        wear::said_of(self, PHYSICS)
    }

    fn page(&self) -> Page {
        wear::page_of(self, PHYSICS)
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
