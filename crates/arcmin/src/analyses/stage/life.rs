//! Accuracy of a single stage over its hours, and the limit that ends its life.

use std::f64::consts::TAU;
use std::ops::Deref;

use super::meshing::{course, meshing};
use super::wear::PHYSICS;
use super::{HasPartWear, StageBodies, StageJoints, part_wear_columns};
use crate::analyses::life::{
    self, BearingLife, BearingLives, Demands, DriveLife, LifeVerdict, LimitKind, Record, system_life,
};
use crate::analyses::wear::stations;
use crate::analyses::{AnalysisError, Host, Outcome, Said};
use crate::design::{StageDesign, default, default_word, optional, options};
use crate::life::{LifeOptions, LifePoint, WholeStage, predict_course};
use crate::machine::PartWear;
use crate::report::{Axis, Block, KeyFigure, Page, Plot, Provenance, Section, Series, Verdict, significant};
use crate::results::{DeclaredTable, Summary, SummaryOf, Table};
use crate::rig::dynamic_load_rating;
use crate::units::{ARCMIN, HOUR, MPA, UM};
use crate::wear::{CoupledOptions, depth_past_use};

pub const ABOUT: &str = "Predict accuracy over the hours of service and the limit that ends the life";

options! {
    /// Options of `life` for a single stage.
    pub struct Options {
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

/// The life of a single stage.
#[derive(Debug, Clone)]
pub struct StageLife {
    drive: DriveLife,
    name: String,
    design_text: String,
}

impl Deref for StageLife {
    type Target = DriveLife;

    fn deref(&self) -> &DriveLife {
        &self.drive
    }
}

impl HasPartWear for StageLife {
    fn part_wear(&self) -> &PartWear {
        &self.last().state.part_wear
    }
}

pub const SUMMARY: SummaryOf<StageLife> = SummaryOf {
    entries: || {
        let mut entries = life::entries();
        entries.extend(part_wear_columns());
        entries
    },
};

const TABLES: [&str; 3] = ["life", "wear", "bearing_life"];

pub fn tables() -> Vec<DeclaredTable> {
    life::tables().into_iter().filter(|table| TABLES.contains(&table.name)).collect()
}

/// Predicts the life.
///
/// # Errors
/// [`AnalysisError`] where the design gives no wear, no load sharing is found, or the host stops it.
pub fn run(design: &StageDesign, options: &Options, host: &dyn Host) -> Result<StageLife, AnalysisError> {
    let mut clock = life::Clock::new(host);
    let findings = super::findings(design);
    clock.stage("check");
    let course = course(design, CoupledOptions::default())?;
    let demands = demands(design, depth_past_use(course.case()));
    let whole = WholeStage {
        designed: design.stage().relief.clone(),
        rated_torque: demands.rated_torque,
        meshing: meshing(design)?,
    };
    let settings = LifeOptions { intervals: options.points, causes: false, ..LifeOptions::default() };
    let prediction = predict_course(course, &whole, settings, host, |state| host.reached(state))?;
    clock.stage("prediction");
    let bearings = bearing_lives(design, &demands)?;
    clock.stage("bearings");
    let record = Record::of(demands.clone(), &prediction, &bearings, &findings, None);
    let verdict = LifeVerdict {
        limits: record.limits(),
        service_h: demands.limits.service_life / HOUR,
        searched_h: prediction.searched_hours,
        band: None,
        undecided: Vec::new(),
    };
    let drive = DriveLife {
        ratio: design.ratio(),
        profile: design.stage().profile.clone(),
        demands,
        prediction,
        bearings,
        findings,
        verdict,
        stages: clock.stages,
    };
    Ok(StageLife { drive, name: design.name.value.clone(), design_text: design.text().to_owned() })
}

fn demands(design: &StageDesign, past_use: f64) -> Demands {
    Demands {
        limits: design.limits(),
        rated_torque: design.rated().torque,
        duty: design.duty_points(),
        output_per_input: 1.0 / design.ratio(),
        passes_per_turn: design.eccentric_turns(),
        past_use,
    }
}

/// Positions over a turn of the input.
const POSITIONS: usize = 72;

/// Basic rating lives of the eccentric bearings by ISO 281 under their loads in states of rest over a turn of the input;
/// damages of the rows of the duty add up. Without friction.
fn bearing_lives(design: &StageDesign, demands: &Demands) -> Result<BearingLives, AnalysisError> {
    let bearing = &design.stage().eccentric;
    let (power, rating) = (bearing.kind.life_exponent(), dynamic_load_rating(bearing));
    let discs = design.stage().phases.len();
    let (mut damage, mut turns) = (vec![0.0; discs], 0.0);
    let mut meshing = meshing(design)?;
    for row in demands.duty.iter().filter(|row| row.wears()) {
        let per_hour = row.share * demands.passes_per_second(row) * HOUR;
        turns += per_hour;
        let mut start: Option<Vec<f64>> = None;
        for step in 0..POSITIONS {
            let angle = TAU * step as f64 / POSITIONS as f64;
            let (place, _) = meshing
                .rest(angle, row.torque, start.as_deref())
                .map_err(AnalysisError::compute("find the loads of the bearings"))?;
            for (disc, damage) in damage.iter_mut().enumerate() {
                let force = meshing.joints().eccentric_force(disc, &place);
                *damage += per_hour / POSITIONS as f64 * (force / rating).powf(power) / 1e6;
            }
            start = Some(meshing.deviation(angle, &place));
        }
    }
    let life = |(disc, damage): (usize, &f64)| BearingLife {
        name: format!("eccentric, disc {disc}"),
        equivalent: rating * (1e6 * damage / turns).powf(1.0 / power),
        rating,
        life_h: 1.0 / damage,
    };
    let bearings: Vec<BearingLife> =
        damage.iter().enumerate().filter(|(_, damage)| **damage > 0.0).map(life).collect();
    Ok(BearingLives { system_h: system_life(&bearings), bearings, assumed_friction: None })
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
        SUMMARY.fill(self)
    }

    fn tables(&self) -> Vec<Table> {
        life::tables_of(self, &[]).into()
    }

    fn said(&self) -> Vec<Said> {
        let verdict = &self.verdict;
        let table = &life::tables_of(self, &[])[0];
        vec![
            Said::line(format!("{}: {PHYSICS}", self.name)),
            Said::line(format!("{} {}", verdict.mark(), verdict.headline())),
            Said::Table(life::limits::text(verdict, None)),
            Said::line(""),
            Said::columns(table, COLUMNS, stations(table.rows(), 7)),
        ]
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
            KeyFigure::new(
                "Deepest wear",
                significant(last.accuracy.max_depth / UM, 3),
                "µm",
                "largest depth lost by a flank",
            ),
        ];
        words.answers.push(("Which physics".to_owned(), PHYSICS.to_owned()));
        let over = |title: &str, axis: Axis, value: fn(&LifePoint) -> f64, note: &str| {
            let points: Vec<(f64, f64)> =
                self.prediction.points.iter().map(|point| (point.hours(), value(point))).collect();
            let name = axis.label.to_lowercase();
            Block::Plot(
                Plot::new(title, Axis::new("Running time", "h"), axis)
                    .with(Series::line(name, points))
                    .noted(note)
                    .half(),
            )
        };
        let accuracy = vec![
            over(
                "Lost motion",
                Axis::new("Lost motion", "arcmin").from_zero(),
                |point| point.lost_motion.arcmin(),
                "At ±3 % of the rated torque, without friction.",
            ),
            over(
                "Play",
                Axis::new("Play", "arcmin"),
                |point| point.travel.map_or(0.0, |travel| travel.free_travel.arcmin()),
                "Two-sided, at the output, input held, no load.",
            ),
            over(
                "Largest pressure",
                Axis::new("Pressure", "MPa").from_zero(),
                |point| point.accuracy.max_pressure / MPA,
                "Of ring pins, at the largest torque of rating and duty.",
            ),
            over(
                "Deepest wear",
                Axis::new("Depth", "µm").from_zero(),
                |point| point.accuracy.max_depth / UM,
                "Largest depth lost by a flank.",
            ),
        ];
        let limits_table = life::limits::table(
            verdict,
            None,
            "Lost motion at the end of the planned life, pressure over all of it at the largest torque of rating and duty, \
             bearings by [ISO281] at the design's duty. Hours are rounded to two digits. Further limits can be set in \
             `[limits]`.",
        );
        let bearings = life::limits::bearings_table(
            &self.bearings,
            "Loads of the new drive over a turn of the input, without friction, rows of the duty by their damage [ISO281].",
        );
        let code = Block::Code { title: "Design".to_owned(), text: self.design_text.clone() };
        Page {
            title: self.name.clone(),
            subtitle: "Life of a single stage".to_owned(),
            provenance: Provenance::default(),
            verdict: words,
            sections: vec![
                Section::new("limits", "Limits", vec![limits_table, bearings]),
                Section::new("accuracy", "Accuracy over life", accuracy),
                life::findings_section(&self.findings),
                Section::new("design", "Design as used", vec![code]),
            ],
        }
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
