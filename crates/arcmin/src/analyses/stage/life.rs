//! Accuracy of a drive of eccentrics over its hours, and the limit that ends its life.

mod page;
#[cfg(test)]
mod tests;

use std::ops::Deref;

use super::bearings::bearing_lives;
use super::keys::main_of;
use super::made::{HasStageFidelity, Made, MadeOptions, StageFidelity, fidelity_entries};
use super::meshing::{courses, for_evaluation};
use super::worn::{self, HasWorn};
use super::{EccentricDrive, Facts, StageBodies, StageJoints, band};
use crate::analyses::life::{
    self, BearingLives, Demands, DriveLife, LifeVerdict, Limit, LimitKind, OF_BANDS, Record, Row, banded,
    no_band,
};
use crate::analyses::wear::{WEAR_TABLE, places};
use crate::analyses::{AnalysisError, Host, Outcome, TextBlock};
use crate::checks::Finding;
use crate::design::{default, default_word, optional, options};
use crate::dynamics::StageMeshing;
use crate::fidelity::DiscBodies;
use crate::geometry::Profile;
use crate::life::{Accuracy, LifeOptions, LifePoint, Prediction, Rings, Travel, WornState, predict_courses};
use crate::load::ShareLoad;
use crate::report::{Page, SolidState, compact, depths, positions, significant};
use crate::results::{Column, DeclaredTable, Summary, SummaryOf, Table, TableOf};
use crate::scene::Scene;
use crate::units::HOUR;
use crate::wear::depth_past_use;

pub(crate) const ABOUT: &str = "Predict accuracy over the hours of service and the limit that ends the life";

options! {
    /// Options of `life` for a single stage.
    pub struct Options {
        [made: MadeOptions, discs = "elastic"]
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
    /// Results of the ring whose keys have no prefix; results other than those of its flanks and pins are those
    /// of the whole drive.
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
    /// By how much the stiffness is off with rigid discs, if they were chosen.
    about_discs: Option<String>,
}

impl HasStageFidelity for StageLife {
    fn fidelity(&self) -> &StageFidelity {
        &self.made
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
    /// Row of the ring whose keys have no prefix.
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
    let mut findings = as_made.design.findings();
    findings.extend(as_made.fidelity.no_room.clone());
    clock.stage("check");
    let settings = LifeOptions {
        intervals: options.points,
        causes: false,
        waves_beyond: true,
        ..LifeOptions::default()
    };
    let main = main_of(D::STAGES);
    let found = Predicted::of(&as_made, settings, host, |states| host.reached(&states[main]))?;
    clock.stage("prediction_and_bearings");
    let wanted = OF_BANDS.iter().any(|result| host.needs(result)) && !design.any().unknowns().is_empty();
    let inputs = match wanted
        .then(|| band::inputs_of(&as_made, &options.made, &found.predictions, host))
        .transpose()
    {
        Err(AnalysisError::Stopped) => return Err(AnalysisError::Stopped),
        Err(error) => {
            findings.push(no_band(&error));
            None
        }
        Ok(inputs) => inputs,
    };
    let (limits, band) = banded(&found.records(&as_made.design, &findings), &worst_of::<D>, inputs.as_ref());
    clock.stage("bands");
    let about_discs = (options.made.rigid_by_choice::<D>() && host.needs("report"))
        .then(|| about_rigid_discs(design, &options.made, &found, host))
        .transpose()?;
    let design = &as_made.design;
    let demands = found.demands(design, found.passes[main]);
    let service_h = demands.limits.service_life / HOUR;
    let Predicted { whole, predictions, bearings, .. } = found;
    let verdict = LifeVerdict {
        limits,
        service_h,
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
        made: as_made.fidelity,
        about_discs,
    };
    if host.needs("report") {
        let last = life.prediction.points.len() - 1;
        life.pictures =
            [0, last].iter().filter_map(|time| life.pictured(*time, settings.crank_positions)).collect();
    }
    Ok(life)
}

/// Prediction of all rings of a drive, and the lives of its bearings.
struct Predicted {
    whole: Rings<StageMeshing>,
    predictions: Vec<Prediction>,
    /// Passes of a place of the flank through its contact per turn of the output, ring by ring.
    passes: Vec<f64>,
    bearings: BearingLives,
}

impl Predicted {
    fn of<D: EccentricDrive>(
        Made { design, discs, .. }: &Made<D>,
        settings: LifeOptions,
        host: &dyn Host,
        reached: impl FnMut(&[WornState]),
    ) -> Result<Predicted, AnalysisError> {
        let courses = courses(design, discs, settings.wear)?;
        let rings = design.wearing_rings(discs)?;
        let passes = rings.iter().map(|ring| ring.passes).collect();
        let whole = for_evaluation(rings);
        let predictions = predict_courses(courses, &whole, settings, host, reached)?;
        Ok(Predicted { whole, predictions, passes, bearings: bearing_lives(design, discs)? })
    }

    fn demands<D: EccentricDrive>(&self, design: &D, passes_per_turn: f64) -> Demands {
        let end = self.predictions[main_of(D::STAGES)].runs_away;
        let past_use = &self.whole.cases[end.map_or(main_of(D::STAGES), |end| end.ring)];
        Demands {
            limits: design.limits(),
            rated_torque: design.rated().torque,
            duty: design.duty_points(),
            output_per_input: 1.0 / design.ratio(),
            passes_per_turn,
            past_use: depth_past_use(past_use),
        }
    }

    fn records<D: EccentricDrive>(&self, design: &D, findings: &[Finding]) -> Vec<Record> {
        let rings = self.predictions.iter().zip(&self.passes);
        rings
            .map(|(prediction, passes)| {
                Record::of(self.demands(design, *passes), prediction, &self.bearings, findings, None)
            })
            .collect()
    }
}

/// Deflection of the new drive at rated torque beyond its play, with rigid and with elastic discs, in a sentence.
///
/// # Errors
/// [`AnalysisError::Stopped`] where the host stops the run; the results with rigid discs do not depend on this one.
fn about_rigid_discs<D: EccentricDrive>(
    design: &D,
    options: &MadeOptions,
    rigid: &Predicted,
    host: &dyn Host,
) -> Result<String, AnalysisError> {
    let main = main_of(D::STAGES);
    let beyond_play = |accuracy: &Accuracy, travel: &Option<Travel>| {
        let play = travel.map_or(0.0, |travel| travel.no_load_error.arcmin());
        (accuracy.loaded_error.arcmin() - play).abs()
    };
    let elastic = || -> Result<f64, AnalysisError> {
        let made = design.as_made(&options.with_discs(DiscBodies::Elastic), host)?;
        let mut whole = for_evaluation(made.design.wearing_rings(&made.discs)?);
        let new = vec![WornState::new(); whole.cases.len()];
        let found = whole
            .evaluate(&new, LifeOptions::default().crank_positions, true)
            .map_err(AnalysisError::wear("share the load with elastic discs"))?;
        Ok(beyond_play(&found[main].0, &found[main].1))
    };
    let new = &rigid.predictions[main].points[0];
    let rigid = beyond_play(&new.accuracy, &new.travel);
    match elastic() {
        Err(AnalysisError::Stopped) => Err(AnalysisError::Stopped),
        Err(error) => Ok(format!("rigid discs were chosen. No result with elastic discs: {error}.")),
        Ok(elastic) => Ok(format!(
            "rigid discs were chosen: at rated torque the output of the new drive deflects beyond its play by {} arcmin with \
             them and by {} arcmin with elastic discs, {} times as much. Real discs are elastic; without --discs they are \
             elastic here too.",
            significant(rigid, 3),
            significant(elastic, 3),
            significant(elastic / rigid, 2)
        )),
    }
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
        whole.set_states(&states);
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

    fn text_blocks(&self) -> Vec<TextBlock> {
        page::text_blocks(self)
    }

    fn page(&self) -> Page {
        page::page(self)
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
