//! Accuracy of a drive of eccentrics over its hours, and the limit that ends its life.

use std::ops::Deref;

use super::bearings::bearing_lives;
use super::keys::main_of;
use super::made::{HasStageFidelity, Made, MadeOptions, StageFidelity, fidelity_entries};
use super::meshing::{courses, to_look_at};
use super::wear::physics;
use super::worn::{self, HasWorn};
use super::{EccentricDrive, Facts, StageBodies, StageJoints, band};
use crate::analyses::life::{
    self, Demands, DriveLife, LifeVerdict, Limit, LimitKind, OF_BANDS, Record, Row, banded, no_band,
};
use crate::analyses::wear::{WEAR_TABLE, places, stations};
use crate::analyses::{AnalysisError, Host, Outcome, Said};
use crate::design::{default, default_word, optional, options};
use crate::dynamics::StageMeshing;
use crate::geometry::Profile;
use crate::life::{Accuracy, LifeOptions, LifePoint, Prediction, Rings, WornState, predict_courses};
use crate::load::ShareLoad;
use crate::report::{
    Axis, Block, KeyFigure, Page, Plot, Provenance, Section, Series, SolidState, Solids, Verdict, compact,
    depths, positions, significant,
};
use crate::results::{Column, DeclaredTable, Summary, SummaryOf, Table, TableOf};
use crate::scene::Scene;
use crate::units::{ARCMIN, HOUR, MPA, UM};
use crate::wear::{CoupledOptions, depth_past_use};

pub(crate) const ABOUT: &str = "Predict accuracy over the hours of service and the limit that ends the life";

options! {
    /// Options of `life` for a single stage.
    pub struct Options {
        [made: MadeOptions]
        /// Joints.
        joints: StageJoints => default_word("bearings"),
        /// Bodies.
        bodies: StageBodies => default_word("rigid"),
        /// Number of times between new and the end of the service life.
        points: usize => default(30.0, 4.0, 1000.0),
        /// Single stages have no multibody runs, so nothing is left out.
        quasi_static: bool => optional(0.0, 0.0),
    }
}

/// The life of a drive of eccentrics.
#[derive(Debug, Clone)]
pub struct StageLife {
    /// Results of the ring whose keys have no prefix; results beside its flanks and pins are those of the whole
    /// drive.
    drive: DriveLife,
    /// Ring by ring with the flank as cut.
    pub rings: Vec<(Profile, Prediction)>,
    /// The rings for evaluation in states of wear.
    whole: Rings<StageMeshing>,
    scene: Scene,
    /// For the report.
    pictures: Vec<SolidState>,
    facts: Facts,
    design_text: String,
    declared: (SummaryOf<StageLife>, TableOf<At>),
    made: StageFidelity,
}

impl HasStageFidelity for StageLife {
    fn fidelity(&self) -> StageFidelity {
        self.made
    }
}

impl Deref for StageLife {
    type Target = DriveLife;

    fn deref(&self) -> &DriveLife {
        &self.drive
    }
}

impl HasWorn for StageLife {
    fn state(&self, stage: usize) -> &WornState {
        &self.last_of(stage).state
    }

    fn accuracy(&self, stage: usize) -> &Accuracy {
        &self.last_of(stage).accuracy
    }

    fn largest(&self, stage: usize, of: fn(&Accuracy) -> f64) -> f64 {
        let points = self.rings[stage].1.points.iter();
        points.map(|point| of(&point.accuracy)).fold(0.0, f64::max)
    }
}

/// All rings at one time.
#[derive(Debug, Clone)]
struct At {
    /// Of the ring whose keys have no prefix.
    row: Row,
    rings: Vec<LifePoint>,
}

impl HasWorn for At {
    fn state(&self, stage: usize) -> &WornState {
        &self.rings[stage].state
    }

    fn accuracy(&self, stage: usize) -> &Accuracy {
        &self.rings[stage].accuracy
    }
}

fn entries<D: EccentricDrive>() -> Vec<Column<StageLife>> {
    let mut entries = life::entries();
    entries.extend(worn::columns::<StageLife, D>(true));
    entries.extend(fidelity_entries::<StageLife>());
    entries
}

pub(crate) fn summary<D: EccentricDrive>() -> SummaryOf<StageLife> {
    SummaryOf { entries: entries::<D> }
}

/// Columns of an RV reducer, and the wear of the other parts.
fn table<D: EccentricDrive>() -> TableOf<At> {
    TableOf {
        name: life::LIFE.name,
        what: "One row per time of the life; STE and DTE are not computed",
        columns: || {
            let main = (life::LIFE.columns)().into_iter().enumerate();
            let mut columns: Vec<Column<At>> = main
                .map(|(number, column)| {
                    Column::numbered(column.quantity, number, |at: &At, number| {
                        (life::LIFE.columns)()[number].value(&at.row)
                    })
                })
                .collect();
            columns.extend(worn::columns::<At, D>(true));
            columns
        },
    }
}

pub(crate) fn tables<D: EccentricDrive>() -> Vec<DeclaredTable> {
    let places = D::STAGES.iter().map(|stage| TableOf { name: stage.wear, ..WEAR_TABLE }.into());
    [table::<D>().into()].into_iter().chain(places).chain([life::BEARINGS.into()]).collect()
}

/// Predicts the life.
///
/// # Errors
/// [`AnalysisError`] where the design gives no wear, no load sharing is found, or the host stops it.
pub fn run<D: EccentricDrive>(
    design: &D,
    options: &Options,
    host: &dyn Host,
) -> Result<StageLife, AnalysisError> {
    let mut clock = life::Clock::new(host);
    let as_made = design.as_made(&options.made, host)?;
    let Made { design, discs, fidelity: made } = &as_made;
    let mut findings = design.findings();
    clock.stage("check");
    let courses = courses(design, discs, CoupledOptions::default())?;
    let rings = design.wearing_rings(discs)?;
    let (main, passes) = (main_of(D::STAGES), rings.iter().map(|ring| ring.passes).collect::<Vec<_>>());
    let whole = to_look_at(rings);
    let settings = LifeOptions { intervals: options.points, causes: false, ..LifeOptions::default() };
    let predictions = predict_courses(courses, &whole, settings, host, |states| host.reached(&states[main]))?;
    clock.stage("prediction");
    let past_use = whole.cases[predictions[main].runs_away.map_or(main, |end| end.ring)].clone();
    let demands = |passes_per_turn: f64| Demands {
        limits: design.limits(),
        rated_torque: design.rated().torque,
        duty: design.duty_points(),
        output_per_input: 1.0 / design.ratio(),
        passes_per_turn,
        past_use: depth_past_use(&past_use),
    };
    let bearings = bearing_lives(design, discs)?;
    clock.stage("bearings");
    let wanted = OF_BANDS.iter().any(|result| host.wants(result)) && !design.any().unknowns().is_empty();
    let inputs =
        match wanted.then(|| band::inputs_of(&as_made, &options.made, &predictions, host)).transpose() {
            Err(AnalysisError::Stopped) => return Err(AnalysisError::Stopped),
            Err(error) => {
                findings.push(no_band(&error));
                None
            }
            Ok(inputs) => inputs,
        };
    let records: Vec<Record> = (predictions.iter().zip(&passes))
        .map(|(prediction, passes)| Record::of(demands(*passes), prediction, &bearings, &findings, None))
        .collect();
    let (limits, band) = banded(&records, &worst_of::<D>, inputs.as_ref());
    clock.stage("bands");
    let demands = demands(passes[main]);
    let verdict = LifeVerdict {
        limits,
        service_h: demands.limits.service_life / HOUR,
        searched_h: predictions[main].searched_hours,
        band,
        undecided: Vec::new(),
    };
    let profiles = whole.cases.iter().map(|case| case.profile.clone());
    let rings: Vec<(Profile, Prediction)> = profiles.zip(predictions).collect();
    let drive = DriveLife {
        ratio: design.ratio(),
        profile: rings[main].0.clone(),
        demands,
        prediction: rings[main].1.clone(),
        bearings,
        findings,
        verdict,
        stages: clock.stages,
    };
    let mut life = StageLife {
        drive,
        rings,
        whole,
        scene: design.scene(),
        pictures: Vec::new(),
        facts: Facts::of(design),
        design_text: design.text().to_owned(),
        declared: (summary::<D>(), table::<D>()),
        made: *made,
    };
    if host.wants("report") {
        let last = life.prediction.points.len() - 1;
        life.pictures =
            [0, last].iter().filter_map(|time| life.pictured(*time, settings.crank_positions)).collect();
    }
    Ok(life)
}

/// Limits of all rings. They differ in the limits of flanks and pins only; of these the ring with the shortest life
/// is used, with its name.
fn worst_of<D: EccentricDrive>(records: &[Record]) -> Vec<Limit> {
    let several = records.len() > 1;
    let of_flanks = |kind: LimitKind| {
        matches!(kind, LimitKind::ContactPressure | LimitKind::ContactFatigue | LimitKind::EmergencyTorque)
    };
    let mut worst: Vec<Limit> = Vec::new();
    for (record, stage) in records.iter().zip(D::STAGES) {
        for (index, mut limit) in record.limits().into_iter().enumerate() {
            if several && of_flanks(limit.kind) {
                limit.place = Some(stage.name.to_owned());
            }
            let order = |limit: &Limit| (limit.hours.unwrap_or(f64::INFINITY), -limit.value / limit.allowed);
            match worst.get_mut(index) {
                None => worst.push(limit),
                Some(known) if of_flanks(limit.kind) && order(&limit) < order(known) => *known = limit,
                Some(_) => {}
            }
        }
    }
    worst
}

impl StageLife {
    /// A ring at the end of the service life.
    fn last_of(&self, stage: usize) -> &LifePoint {
        let points = &self.rings[stage].1.points;
        // A prediction has the new drive at least.
        &points[points.len() - 1]
    }

    /// The drive at one time for drawing: flanks, and forces at several positions over one pin pitch of each ring.
    /// `None` if the load sharing has no solution.
    pub fn pictured(&self, time: usize, count: usize) -> Option<SolidState> {
        let states: Vec<WornState> =
            self.rings.iter().map(|(_, prediction)| prediction.points[time].state.clone()).collect();
        let mut whole = self.whole.clone();
        whole.put_on(&states);
        let rings = whole.cases.iter().zip(&mut whole.meshings).map(|(case, meshing)| {
            Some(positions(&meshing.pitch_cycle(case.rated_torque, count).ok()?, case.contact))
        });
        Some(SolidState {
            label: if time == 0 { "new".to_owned() } else { format!("{} h", compact(states[0].hours, 4)) },
            rings: rings.collect::<Option<_>>()?,
            depth_um: states.iter().map(|state| depths(state.surfaces.flank())).collect(),
        })
    }

    /// Time by time.
    fn times(&self) -> Vec<At> {
        let at = |(time, point): (usize, &LifePoint)| At {
            row: Row::new(point, None),
            rings: self.rings.iter().map(|(_, prediction)| prediction.points[time].clone()).collect(),
        };
        self.prediction.points.iter().enumerate().map(at).collect()
    }

    fn title(&self, stage: usize) -> &'static str {
        self.facts.stages[stage].name
    }
}

const COLUMNS: &[&str] = &[
    "hours",
    "max_depth_um",
    "play_arcmin",
    "lost_motion_arcmin",
    "te_loaded_arcmin",
    "max_force_n",
    "max_pressure_mpa",
];

impl Outcome for StageLife {
    fn summary(&self) -> Summary {
        self.declared.0.fill(self)
    }

    fn tables(&self) -> Vec<Table> {
        let places = self.facts.stages.iter().zip(&self.rings).map(|(stage, (profile, prediction))| {
            let points = prediction.points.iter();
            let places = points.flat_map(|point| places(profile, &point.state, &point.accuracy));
            TableOf { name: stage.wear, ..WEAR_TABLE }.fill(&places.collect::<Vec<_>>())
        });
        let life = self.declared.1.fill(&self.times());
        let bearings = life::BEARINGS.fill(&self.bearings.bearings);
        [life].into_iter().chain(places).chain([bearings]).collect()
    }

    fn said(&self) -> Vec<Said> {
        let verdict = &self.verdict;
        let table = self.declared.1.fill(&self.times());
        let columns: Vec<&str> =
            COLUMNS.iter().copied().chain(worn::shown(self.facts.stages, self)).collect();
        let mut said: Vec<Said> = self.made.said().into_iter().collect();
        said.extend([
            Said::line(format!(
                "{}: {}",
                self.facts.name,
                physics(self.facts.stages, self.facts.ring, self.made)
            )),
            Said::line(format!("{} {}", verdict.mark(), verdict.headline())),
            Said::Table(life::limits::text(verdict, None)),
            Said::line(""),
            Said::columns(&table, &columns, stations(table.rows(), 7)),
        ]);
        said
    }

    fn page(&self) -> Page {
        let (verdict, limits) = (&self.verdict, &self.demands.limits);
        let mut words = Verdict::new(verdict.tone(), verdict.headline());
        let last = self.last();
        let is_kept =
            |kind: LimitKind| verdict.limit(kind).is_none_or(|limit| limit.is_kept(verdict.service_h));
        words.figures = vec![
            KeyFigure::new(
                "Lost motion",
                significant(last.lost_motion.arcmin(), 3),
                "arcmin",
                format!(
                    "after {:.0} h; new {}, limit {}",
                    last.hours(),
                    significant(self.first().lost_motion.arcmin(), 3),
                    significant(limits.lost_motion / ARCMIN, 3)
                ),
            )
            .kept(is_kept(LimitKind::LostMotion)),
            KeyFigure::new(
                "First limit",
                verdict.hours_to_limit().map_or("none".to_owned(), life::about),
                "h",
                verdict.limited_by().map_or("within what was computed", |limit| limit.kind.name()),
            )
            .kept(verdict.ok()),
        ];
        for stage in 0..self.rings.len() {
            let place = if self.rings.len() > 1 { format!(", {}", self.title(stage)) } else { String::new() };
            let depth = significant(self.accuracy(stage).max_depth / UM, 3);
            let note = format!("largest depth lost by a flank{place}");
            words.figures.push(KeyFigure::new("Deepest wear", depth, "µm", note));
        }
        words
            .answers
            .push(("Which physics".to_owned(), physics(self.facts.stages, self.facts.ring, self.made)));
        let over = |title: &str, axis: Axis, rings: &[usize], value: fn(&LifePoint) -> f64, note: &str| {
            let name = axis.label.to_lowercase();
            let mut plot = Plot::new(title, Axis::new("Running time", "h"), axis).noted(note).half();
            for ring in rings {
                let points = self.rings[*ring].1.points.iter();
                let points: Vec<(f64, f64)> = points.map(|point| (point.hours(), value(point))).collect();
                let name = if rings.len() > 1 { self.title(*ring).to_owned() } else { name.clone() };
                plot = plot.with(Series::line(name, points));
            }
            Block::Plot(plot)
        };
        let whole = &[main_of(self.facts.stages)][..];
        let every: Vec<usize> = (0..self.rings.len()).collect();
        let mut accuracy = vec![
            over(
                "Lost motion",
                Axis::new("Lost motion", "arcmin").from_zero(),
                whole,
                |point| point.lost_motion.arcmin(),
                "Lost motion at ±3 % of the rated torque, computed without friction.",
            ),
            over(
                "Play",
                Axis::new("Play", "arcmin"),
                whole,
                |point| point.travel.map_or(0.0, |travel| travel.free_travel.arcmin()),
                "Two-sided play at the output without load, input held.",
            ),
            over(
                "Transmission error",
                Axis::new("Error", "arcmin").from_zero(),
                whole,
                |point| point.accuracy.loaded_peak_to_peak.arcmin(),
                "Peak-to-peak transmission error at rated torque over one full period.",
            ),
            over(
                "Largest pressure",
                Axis::new("Pressure", "MPa").from_zero(),
                &every,
                |point| point.accuracy.max_pressure / MPA,
                &format!(
                    "Hertz pressure at {}, at the largest torque of rating and duty.",
                    self.facts.ring.all_of_ring()
                ),
            ),
            over(
                "Deepest wear",
                Axis::new("Depth", "µm").from_zero(),
                &every,
                |point| point.accuracy.max_depth / UM,
                "Largest depth lost by a flank.",
            ),
        ];
        accuracy.extend(worn::parts_plot(&self.facts, &self.times()));
        let limits_table = life::limits::table(
            verdict,
            None,
            "Lost motion at the end of the planned life, pressure over all of it at the largest torque of rating and duty, \
             bearings by [ISO281] at the design's duty. Hours are rounded to two digits; the band contains nine of ten drives \
             within `[unknowns]`, by first-order sensitivities. Further limits can be set in `[limits]`.",
        );
        let bearings = life::limits::bearings_table(
            &self.bearings,
            "Loads of the new drive over a turn of the input, without friction, rows of the duty by their damage [ISO281].",
        );
        let solids = Block::Solids(Solids {
            title: self.facts.name.clone(),
            note: format!(
                "Contact forces of states of rest at {} N·m; the arrows act on the discs, their lines of action meet in the pitch \
                 point of each ring. {}",
                compact(self.demands.rated_torque, 4),
                self.scene.assumed
            ),
            scene: self.scene.clone(),
            states: self.pictures.clone(),
            instead: None,
        });
        let code = Block::Code { title: "Design".to_owned(), text: self.design_text.clone() };
        Page {
            title: self.facts.name.clone(),
            subtitle: format!("Life of a {}", self.facts.family.drive()),
            provenance: Provenance::default(),
            verdict: words,
            sections: vec![
                Section::new("limits", "Limits", vec![limits_table, bearings]),
                Section::new("accuracy", "Accuracy over life", accuracy),
                Section::new("mechanism", "Mechanism and contact forces", vec![solids]),
                life::findings_section(&self.findings),
                Section::new("design", "Design as used", vec![code]),
            ],
        }
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
