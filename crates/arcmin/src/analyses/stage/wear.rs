//! Wear of the flanks and ring pins of a drive of eccentrics over the hours.

use std::ops::Deref;

use super::keys::{StageKeys, has_output_pins, main_of};
use super::made::{HasStageFidelity, Made, MadeOptions, StageFidelity, fidelity_entries};
use super::meshing::courses;
use super::worn::{self, HasWorn};
use super::{EccentricDrive, Facts, StageBodies, StageJoints};
use crate::analyses::wear::{self, Station, WearOverHours, stations};
use crate::analyses::{AnalysisError, Host, Outcome, TextBlock};
use crate::design::{Choice, default, default_word, optional, options};
use crate::life::{Accuracy, WornState};
use crate::machine::RingPartner;
use crate::report::{Block, KeyFigure, Page, significant};
use crate::results::{Column, DeclaredTable, Summary, SummaryOf, Table, TableOf};
use crate::units::{HOUR, UM};
use crate::wear::CoupledOptions;

pub(crate) const ABOUT: &str = "Compute the wear of the flanks over the hours of service";

options! {
    /// Options of `wear` for a single stage.
    pub struct Options {
        [made: MadeOptions, discs = "elastic"]
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
    /// The worn flank changes the load sharing.
    Coupled,
}

impl Choice for StageMode {
    const WORDS: &'static [(&'static str, &'static str)] =
        &[("coupled", "wear and load sharing change each other; single stages have no other model")];
    const VALUES: &'static [StageMode] = &[StageMode::Coupled];
}

/// Wear of a drive, ring by ring.
#[derive(Debug, Clone)]
pub struct StageWear {
    /// Wear of each ring.
    pub rings: Vec<WearOverHours>,
    facts: Facts,
    declared: (SummaryOf<StageWear>, TableOf<Stations>),
    made: StageFidelity,
}

impl HasStageFidelity for StageWear {
    fn fidelity(&self) -> &StageFidelity {
        &self.made
    }
}

impl Deref for StageWear {
    type Target = WearOverHours;

    /// The ring whose keys have no prefix.
    fn deref(&self) -> &WearOverHours {
        &self.rings[main_of(self.facts.stages)]
    }
}

impl HasWorn for StageWear {
    fn state(&self, stage: usize) -> &WornState {
        &self.rings[stage].last().state
    }

    fn accuracy(&self, stage: usize) -> &Accuracy {
        &self.rings[stage].last().accuracy
    }
}

/// All rings at one time.
#[derive(Debug, Clone)]
struct Stations {
    main: usize,
    rings: Vec<Station>,
}

impl HasWorn for Stations {
    fn state(&self, stage: usize) -> &WornState {
        &self.rings[stage].state
    }

    fn accuracy(&self, stage: usize) -> &Accuracy {
        &self.rings[stage].accuracy
    }
}

fn entries<D: EccentricDrive>() -> Vec<Column<StageWear>> {
    let mut entries = wear::entries();
    entries.extend(worn::columns::<StageWear, D>(false));
    entries.extend(fidelity_entries::<StageWear>());
    entries
}

pub(crate) fn summary<D: EccentricDrive>() -> SummaryOf<StageWear> {
    SummaryOf { entries: entries::<D> }
}

/// Columns of an RV reducer, and the wear of the other parts.
fn history<D: EccentricDrive>() -> TableOf<Stations> {
    TableOf {
        name: wear::HISTORY.name,
        what: "One row per time: the drive",
        columns: || {
            let main = (wear::HISTORY.columns)().into_iter().enumerate();
            let mut columns: Vec<Column<Stations>> = main
                .map(|(number, column)| {
                    Column::numbered(column.quantity, number, |stations: &Stations, number| {
                        (wear::HISTORY.columns)()[number].value(&stations.rings[stations.main])
                    })
                })
                .collect();
            columns.extend(worn::columns::<Stations, D>(false));
            columns
        },
    }
}

pub(crate) fn tables<D: EccentricDrive>() -> Vec<DeclaredTable> {
    let places = D::STAGES.iter().map(|stage| TableOf { name: stage.wear, ..wear::WEAR_TABLE }.into());
    places.chain([history::<D>().into()]).collect()
}

/// Contents of the model.
pub(super) fn physics(stages: &[StageKeys], ring: RingPartner, made: &StageFidelity) -> String {
    let (model, has_pins) = (made.model(stages), has_output_pins(stages));
    let wears = match (has_pins, ring) {
        (true, RingPartner::Pins) => ", pins and holes".to_owned(),
        (true, ring) => format!(", {}, output pins and holes", ring.several()),
        (false, ring) => format!(" and {}", ring.several()),
    };
    format!("{model}; flanks{wears} wear, bearings if the design gives their wear coefficients")
}

/// Computes the wear of the drive over the hours.
///
/// # Errors
/// [`AnalysisError`] where the design gives no wear, or no load sharing is found.
pub fn run<D: EccentricDrive>(
    design: &D,
    options: &Options,
    host: &dyn Host,
) -> Result<StageWear, AnalysisError> {
    let end = options.hours.unwrap_or(design.limits().service_life / HOUR);
    let increment = options.increment_um * UM;
    let settings = CoupledOptions { depth_increment: increment, ..CoupledOptions::default() };
    let Made { design, discs, fidelity: made } = &design.as_made(&options.made, host)?;
    let courses = courses(design, discs, settings)?;
    let name = design.name().to_owned();
    Ok(StageWear {
        rings: wear::over_hours(courses, name, (end, options.points), increment, host)?,
        facts: Facts::of(design),
        declared: (summary::<D>(), history::<D>()),
        made: made.clone(),
    })
}

impl StageWear {
    /// Largest depth in words, of several rings each.
    fn depths(&self) -> String {
        let several = self.rings.len() > 1;
        let of_ring = |(stage, ring): (&StageKeys, &WearOverHours)| match several {
            true => format!("{} {}", stage.name, wear::depth_of(ring)),
            false => wear::depth_of(ring),
        };
        self.facts.stages.iter().zip(&self.rings).map(of_ring).collect::<Vec<_>>().join(", ")
    }

    fn physics(&self) -> String {
        physics(self.facts.stages, self.facts.ring, &self.made)
    }

    /// Time by time.
    fn times(&self) -> Vec<Stations> {
        let main = main_of(self.facts.stages);
        let at = |time: usize| {
            let rings = self.rings.iter().map(|ring| ring.stations[time].clone()).collect();
            Stations { main, rings }
        };
        (0..self.stations.len()).map(at).collect()
    }
}

impl Outcome for StageWear {
    fn summary(&self) -> Summary {
        self.declared.0.fill(self)
    }

    fn tables(&self) -> Vec<Table> {
        let places = self.facts.stages.iter().zip(&self.rings).map(|(stage, ring)| {
            let places = ring.stations.iter();
            let places =
                places.flat_map(|station| wear::places(&ring.profile, &station.state, &station.accuracy));
            TableOf { name: stage.wear, ..wear::WEAR_TABLE }.fill(&places.collect::<Vec<_>>())
        });
        places.chain([self.declared.1.fill(&self.times())]).collect()
    }

    fn text_blocks(&self) -> Vec<TextBlock> {
        let table = self.declared.1.fill(&self.times());
        let columns: Vec<&str> =
            wear::COLUMNS.iter().copied().chain(worn::shown(self.facts.stages, self)).collect();
        let shown = TextBlock::columns(&table, &columns, stations(table.rows(), 7));
        let blocks = wear::text_blocks_of(self, (&self.physics(), self.facts.ring), &self.depths(), shown);
        self.made.text_blocks().into_iter().chain(blocks).collect()
    }

    /// If there are several rings, each has a section, and the verdict names all of them.
    fn page(&self) -> Page {
        let mut page = wear::page_of(self, (&self.physics(), self.facts.ring), &self.depths());
        if self.rings.len() > 1 {
            let rings = || self.facts.stages.iter().zip(&self.rings);
            let figure = |(stage, ring): (&StageKeys, &WearOverHours)| {
                let depth = significant(ring.last().accuracy.max_depth / UM, 3);
                KeyFigure::new("Deepest wear", depth, "µm", format!("of a flank, {}", stage.name))
            };
            page.verdict.figures = rings().map(figure).chain(page.verdict.figures.drain(1..2)).collect();
            let section = |(k, (stage, ring)): (usize, (&StageKeys, &WearOverHours))| {
                let of_ring = ("", self.facts.rings[k]);
                let mut section = wear::page_of(ring, of_ring, "").sections.swap_remove(0);
                section.id = stage.wear.to_owned();
                section.title = format!("Wear, {}", stage.name);
                // The play is that of the drive.
                let is_play = |block: &Block| matches!(block, Block::Plot(plot) if plot.title == "Play");
                section.blocks.retain(|block| k == 0 || !is_play(block));
                section
            };
            page.sections = rings().enumerate().map(section).collect();
        }
        let parts = worn::parts_plot(&self.facts, &self.times());
        if let Some(section) = page.sections.last_mut() {
            section.blocks.extend(parts);
        }
        page
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
