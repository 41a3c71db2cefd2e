//! Robots whose reducers are drawn at random from the tolerances of their designs: a study with one robot for
//! each row.

use rayon::prelude::*;
use serde_json::{Value as Json, json};

use super::figures::{Figures, Sorted, Tool};
use super::joint::JointModel;
use super::life::Measured;
use super::loaded::Loaded;
use super::models::{ages_of, ages_of_table, life_of, measured, model_of};
use super::read::Reducer;
use super::tool::{Field, Places};
use crate::analyses::{AnalysisError, Host, Quiet};
use crate::design::OptionSet;
use crate::fidelity::FidelityOptions;
use crate::progress::Counter;
use crate::study::sampling::Layout;
use crate::study::statistics::quantile;
use crate::study::{
    Cell, Done, Factor, Kept, Kind, Plan, Purpose, Row, RowError, Setting, Shard, Store, Watch, collect,
    hash, run,
};

/// All robots, new and at the planned hours.
#[derive(Debug, Clone)]
pub struct Population {
    pub seed: u64,
    /// Results in order, or the reason why there are none.
    pub robots: Vec<Result<[Figures; 2], String>>,
    /// Axes whose design has no tolerances, or whose reducer is a table: equal in all robots.
    pub alike: Vec<String>,
}

/// Number of crank positions for drawn joints; smaller than usual, because results are statistics over many
/// robots (20 by default).
const POSITIONS: usize = 3;
const ERROR_POSITIONS: usize = 256;
/// Robots per part: each takes a minute or more.
const ROBOTS_PER_PART: u64 = 1;
/// Results of a row: the figures of the new robot, and those at the planned hours.
const RESULTS: [&str; 2] = ["new", "worn"];

impl Loaded<'_> {
    /// The rows of the population; `None` if there is none.
    ///
    /// # Errors
    /// Designs that the duties do not fit.
    pub fn population_plan(&self) -> Result<Option<Plan>, AnalysisError> {
        let Some(section) = &*self.file.population else { return Ok(None) };
        // The robots depend neither on their number nor on the requested results.
        let canonical = self.file.canonical();
        let counts = |line: &&str| {
            !["name", "limits", "population", "variant"].iter().any(|key| line.starts_with(key))
        };
        let mut what = format!("robots 1 {}\n", env!("CARGO_PKG_VERSION"));
        what.extend(canonical.lines().filter(counts).flat_map(|line| [line, "\n"]));
        // Contents of other files.
        what.push_str(&format!("{:?}{:?}", self.arm, self.programs));
        for joint in &self.before {
            match joint.design() {
                Some(design) => what.push_str(&design.canonical()),
                None => what.push_str(&format!("{:?}", joint.reducer)),
            }
        }
        let kept = RESULTS.map(|key| Kept { key: key.to_owned(), kind: Kind::Curve }).to_vec();
        let (robots, seed) = (*section.robots as u64, *section.seed as u64);
        let plan = Plan::new(&what, vec![Factor::drawn()], Layout::Random, robots, seed, kept)
            .map_err(AnalysisError::compute("plan the drawn robots"))?;
        Ok(Some(plan.with_samples_per_part(ROBOTS_PER_PART).named("robots".to_owned())))
    }

    /// Computes the missing robots of a shard and stores them.
    ///
    /// # Errors
    /// [`AnalysisError::Stopped`]; failures of joints that are not drawn; parts that cannot be read or stored.
    pub fn draw(
        &self,
        plan: &Plan,
        shard: Shard,
        parts: &dyn Store,
        host: &dyn Host,
    ) -> Result<Done, AnalysisError> {
        let places = self.places();
        let sorted = Sorted::of(&places);
        let alike = (0..self.before.len())
            .map(|axis| match self.before[axis].is_drawn() {
                true => Ok(None),
                false => self.joint(axis, &measured(self.file)?, host).map(Some),
            })
            .collect::<Result<Vec<_>, AnalysisError>>()?;
        let compute = |row: &Row| self.figures_of(row, &alike, (&places, &sorted), &Quiet(host));
        let all: u64 = shard.parts(plan).map(|part| plan.rows_of(part).count() as u64).sum();
        let done = Counter::new("drawn robots", all as usize, host);
        let watch = Watch {
            begun: &|found| (0..found).for_each(|_| done.one_more()),
            finished: &|_| done.one_more(),
        };
        let done = run(plan, shard, parts, &compute, &watch).map_err(of_parts)?;
        if done.cancelled { Err(AnalysisError::Stopped) } else { Ok(done) }
    }

    /// All stored robots.
    ///
    /// # Errors
    /// Parts that cannot be read, or no robot with results.
    pub(super) fn population(&self, plan: &Plan, parts: &dyn Store) -> Result<Population, AnalysisError> {
        let rows = collect(plan, parts).map_err(of_parts)?;
        let figures = |cell: Option<&Cell>| match cell {
            Some(Cell::Curve(numbers)) => Figures::of_numbers(numbers),
            _ => None,
        };
        let robots: Vec<Result<[Figures; 2], String>> = rows
            .records
            .into_iter()
            .map(|record| {
                // Behind the seed.
                match (figures(record.cells.get(1)), figures(record.cells.get(2))) {
                    (Some(new), Some(worn)) => Ok([new, worn]),
                    _ => Err(record.failed.unwrap_or_default()),
                }
            })
            .collect();
        if let Some(Err(why)) = robots.first().filter(|_| robots.iter().all(Result::is_err)) {
            return Err(AnalysisError::usage(
                format!("none of the {} drawn robots can be computed: {why}", robots.len()),
                "check the [tolerances] of the designs with `arcmin check`",
            ));
        }
        let alike = self.before.iter().zip(&self.arm.axes).filter(|(joint, _)| !joint.is_drawn());
        Ok(Population {
            seed: plan.sampling().seed(),
            robots,
            alike: alike.map(|(_, axis)| axis.name.clone()).collect(),
        })
    }

    /// The joint of an axis over its life.
    fn joint(&self, axis: usize, measured: &Measured, host: &dyn Host) -> Result<JointModel, AnalysisError> {
        let (joint, name) = (&self.before[axis], &self.arm.axes[axis].name);
        let (ages, motor) = match &joint.reducer {
            Reducer::Design(design) => {
                let export = life_of(self.file, joint, design, name, measured, host)?.export;
                (ages_of(name, &export)?, export.inertia.motor_kg_m2)
            }
            Reducer::Table(export) => {
                (ages_of_table(joint, export, name, *self.file.planned_hours)?, export.inertia.motor_kg_m2)
            }
        };
        Ok(model_of(joint, name, ages, motor)?.0)
    }

    fn figures_of(
        &self,
        row: &Row,
        alike: &[Option<JointModel>],
        (places, sorted): (&Places, &Sorted),
        host: &dyn Host,
    ) -> Result<Json, RowError> {
        let Some(Setting::Seed(seed)) = row.settings.first() else { unreachable!("robots are drawn") };
        let joints: Vec<JointModel> = alike
            .par_iter()
            .enumerate()
            .map(|(axis, alike)| match alike {
                Some(joint) => Ok(joint.clone()),
                None => self.joint(axis, &self.drawing(*seed, axis)?, host),
            })
            .collect::<Result<_, _>>()
            .map_err(|error: AnalysisError| match error {
                AnalysisError::Stopped | AnalysisError::Interrupted { .. } => RowError::Cancelled,
                error => RowError::Failed(error.to_string()),
            })?;
        let moving = self.moving();
        let field = Field::of(places, &joints, &moving, *self.file.controller.compensates);
        let tool = Tool { places, sorted, field: &field };
        let [new, worn] =
            [0.0, *self.file.planned_hours].map(|hours| tool.figures(&vec![hours; joints.len()]).numbers());
        Ok(json!({ RESULTS[0]: new, RESULTS[1]: worn }))
    }

    /// Draw and parameters of the reducer of an axis.
    fn drawing(&self, seed: u64, axis: usize) -> Result<Measured, AnalysisError> {
        let words = measured(self.file)?.fidelity.canonical();
        let others = words.lines().filter(|line| !line.starts_with("errors") && !line.starts_with("seed"));
        let drawing = format!(
            "{}\nerrors = \"drawn\"\nseed = {}\n",
            others.collect::<Vec<_>>().join("\n"),
            hash(&[seed, Purpose::Reducers as u64, axis as u64]) >> 11
        );
        Ok(Measured {
            fidelity: FidelityOptions::parse(&drawing, "the section [population]")?,
            ages: 2,
            positions: POSITIONS,
            error_positions: ERROR_POSITIONS,
        })
    }
}

fn of_parts(cause: String) -> AnalysisError {
    AnalysisError::usage(cause, "choose another directory with --out")
}

impl Population {
    /// Quantile: the value below which the fraction `share` of the robots is.
    pub fn quantile(&self, age: usize, share: f64, of: fn(&Figures) -> f64) -> f64 {
        let mut values: Vec<f64> = self.robots.iter().flatten().map(|robot| of(&robot[age])).collect();
        values.sort_by(f64::total_cmp);
        // There is at least one robot, so that the quantile exists.
        quantile(&values, share, 0.95).map_or(f64::NAN, |found| found.estimate)
    }

    /// Notes as sentences.
    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if !self.alike.is_empty() {
            let alike = self.alike.join(", ");
            notes.push(format!(
                "drawn robots all have the same reducers in {alike}: no tolerances to draw from"
            ));
        }
        let failed: Vec<&String> = self.robots.iter().filter_map(|robot| robot.as_ref().err()).collect();
        if let Some(why) = failed.first() {
            let (count, all) = (failed.len(), self.robots.len());
            notes.push(format!("{count} of {all} drawn robots cannot be computed and are left out: {why}"));
        }
        notes
    }
}
