//! The search for the best design as a study: stages of rows that are sharded like any others.
//!
//! The stages are the given design, one generation after the other, and a final check on new machines. A stage
//! depends only on the rows of the previous stages. The state of a search is therefore known from its parts, and
//! it continues after any interruption and on any engine.

mod goal;
#[cfg(test)]
mod tests;

use std::sync::Arc;

pub use goal::{Bound, Goal};

use super::collect::{Rows, collect};
use super::optimise::{CmaEs, Nsga2, Outcome};
use super::plan::{Factor, Kept, Plan};
use super::run::Store;
use super::sampling::Layout;
use super::stream::{Purpose, Stream};
use super::{Distribution, StudyError};

/// Space and method of a search.
#[derive(Debug, Clone)]
pub struct Search {
    /// One goal for CMA-ES, two for NSGA-II.
    pub goals: Vec<Goal>,
    /// Conditions that a design must keep.
    pub bounds: Vec<Bound>,
    /// Factors that are searched; the others scatter from machine to machine.
    pub searched: Vec<usize>,
    /// Position of the given design, in the unit interval of every searched factor.
    pub start: Vec<f64>,
    /// Number of machines for each design; the same machines for all designs, so that the selection does not depend
    /// on chance.
    pub machines: u64,
    /// Number of new machines for the final check.
    pub check_machines: u64,
    /// Generations after the given design.
    pub generations: u64,
    /// Designs of a generation; `None` for the rule of the method.
    pub population: Option<usize>,
    /// First step of CMA-ES in the unit interval of every factor.
    pub step: f64,
    /// Seed of designs and machines.
    pub seed: u64,
    /// Factors of designs and machines, in the order of the columns.
    pub factors: Vec<Factor>,
    /// Results that every row keeps.
    pub kept: Vec<Kept>,
    /// Identity of the computation.
    pub what: String,
    /// Rows of a part; `None` for the usual number.
    pub samples_per_part: Option<u64>,
}

/// Stage of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// The given design.
    Start,
    /// Counted from 1.
    Generation(u64),
    /// The given design and the best ones on new machines; with one goal the best of these is the winner.
    Check,
}

impl Stage {
    /// Words for progress and tables.
    pub fn name(self) -> String {
        match self {
            Stage::Start => "start".to_owned(),
            Stage::Generation(number) => format!("generation {number}"),
            Stage::Check => "check".to_owned(),
        }
    }
}

/// Rows to compute together.
#[derive(Debug, Clone)]
pub struct StagePlan {
    /// Stage that these rows are.
    pub stage: Stage,
    /// Rows to compute.
    pub plan: Plan,
    /// Points of its designs; each has one row per machine, in sequence.
    pub designs: Vec<Vec<f64>>,
    /// Machines of every design.
    pub machines: u64,
}

/// A stage with all rows.
#[derive(Debug, Clone)]
pub struct DoneStage {
    /// Stage that these rows are.
    pub stage: Stage,
    /// Places of its designs in the unit interval of every searched factor.
    pub designs: Vec<Vec<f64>>,
    /// Machines of every design.
    pub machines: u64,
    /// Goals and constraints of the designs, in their order.
    pub outcomes: Vec<Outcome>,
    /// Rows, design after design.
    pub rows: Rows,
    /// Plan of these rows.
    pub plan: Plan,
}

impl DoneStage {
    /// The best of its designs that are `wanted`.
    fn best(&self, wanted: impl Fn(&Outcome) -> bool) -> Option<(Vec<f64>, Outcome)> {
        let all = self.designs.iter().zip(&self.outcomes).filter(|(_, outcome)| wanted(outcome));
        all.min_by(|a, b| a.1.compare(b.1)).map(|(place, outcome)| (place.clone(), outcome.clone()))
    }
}

/// State of a search.
#[derive(Debug, Clone)]
pub struct Standing {
    /// Complete stages.
    pub done: Vec<DoneStage>,
    /// The incomplete stage with its available rows; `None` at the end.
    pub next: Option<(StagePlan, Rows)>,
    /// Best designs so far: one for one goal, the Pareto front for two.
    pub best: Vec<(Vec<f64>, Outcome)>,
    /// Whether the best keeps all bounds.
    pub feasible: bool,
    /// Names of parts that cannot be used, with the reason.
    pub unusable: Vec<(String, String)>,
}

/// Number of designs of a front that are checked on new machines.
const CHECKED: usize = 5;
/// The best design on few machines is biased. With one goal the designs are checked that are best with these margins
/// to all bounds, as shares of their size.
const DISTANCES: [f64; CHECKED] = [0.0, 0.01, 0.02, 0.04, 0.08];
/// Standard deviation below which a search has converged.
const SETTLED: f64 = 1e-4;

enum Optimiser {
    One(Box<CmaEs>),
    Two(Nsga2),
}

impl Optimiser {
    fn ask(&self) -> Vec<Vec<f64>> {
        match self {
            Optimiser::One(cma) => cma.ask(),
            Optimiser::Two(nsga) => nsga.ask(),
        }
    }

    fn tell(&mut self, outcomes: &[Outcome]) -> Result<(), StudyError> {
        match self {
            Optimiser::One(cma) => cma.tell(outcomes),
            Optimiser::Two(nsga) => nsga.tell(outcomes),
        }
    }

    fn has_settled(&self) -> bool {
        matches!(self, Optimiser::One(cma) if cma.spread() < SETTLED)
    }

    fn best(&self) -> Vec<(Vec<f64>, Outcome)> {
        match self {
            Optimiser::One(cma) => {
                cma.best().map(|(place, outcome)| (place.to_vec(), outcome.clone())).into_iter().collect()
            }
            Optimiser::Two(nsga) => {
                nsga.front().into_iter().map(|(place, outcome)| (place.to_vec(), outcome.clone())).collect()
            }
        }
    }
}

/// The machines of the check differ from those of the search.
const FRESH: u64 = 1 << 32;

impl Search {
    /// [`StudyError`] for an invalid search: no searched key, or a population that is too small.
    pub fn validate(&self) -> Result<(), StudyError> {
        let no = |reason: &str| Err(StudyError::Search { reason: reason.to_owned() });
        if self.searched.is_empty() {
            return no("no key has a range to search in");
        }
        if self.goals.is_empty() || self.goals.len() > 2 {
            return no("there must be one goal or two");
        }
        self.optimiser()?;
        self.plan(Stage::Start, std::slice::from_ref(&self.start), self.machines).map(|_| ())
    }

    fn optimiser(&self) -> Result<Optimiser, StudyError> {
        Ok(if self.goals.len() == 1 {
            Optimiser::One(Box::new(CmaEs::new(&self.start, self.step, self.population, self.seed)?))
        } else {
            let population = self.population.unwrap_or(2 * (8 + self.searched.len()));
            Optimiser::Two(Nsga2::new(self.searched.len(), population, self.seed)?)
        })
    }

    /// Rows of the first stage, known before any computation.
    ///
    /// # Errors
    /// [`StudyError`] as of [`Search::validate`].
    pub fn first(&self) -> Result<Plan, StudyError> {
        Ok(self.plan(Stage::Start, std::slice::from_ref(&self.start), self.machines)?.plan)
    }

    fn plan(&self, stage: Stage, designs: &[Vec<f64>], machines: u64) -> Result<StagePlan, StudyError> {
        let first = if stage == Stage::Check { FRESH } else { 0 };
        let scattered: Vec<usize> = (0..self.factors.len()).filter(|f| !self.searched.contains(f)).collect();
        let mut points = Vec::with_capacity(designs.len() * machines as usize);
        for design in designs {
            for machine in 0..machines {
                let mut unit = vec![0.0; self.factors.len()];
                let mut stream = Stream::new(self.seed, Purpose::Machines, first + machine);
                scattered.iter().for_each(|factor| unit[*factor] = stream.unit());
                self.searched.iter().zip(design).for_each(|(factor, place)| unit[*factor] = *place);
                points.push(unit);
            }
        }
        let name = match stage {
            Stage::Start => "start".to_owned(),
            Stage::Generation(number) => format!("g{number:05}"),
            Stage::Check => "check".to_owned(),
        };
        let plan = self.over(points)?.named(name);
        Ok(StagePlan { stage, plan, designs: designs.to_vec(), machines })
    }

    /// A plan of given points.
    fn over(&self, points: Vec<Vec<f64>>) -> Result<Plan, StudyError> {
        let count = points.len() as u64;
        let layout = Layout::Points(Arc::new(points));
        let (factors, kept) = (self.factors.clone(), self.kept.clone());
        let plan = Plan::new(&self.what, factors, layout, count, self.seed, kept)?;
        Ok(match self.samples_per_part {
            Some(samples) => plan.with_samples_per_part(samples),
            None => plan,
        })
    }

    /// State of the search from the available parts.
    ///
    /// # Errors
    /// A part cannot be read or the search cannot continue; with a sentence.
    pub fn standing(&self, store: &dyn Store) -> Result<Standing, String> {
        let text = |error: StudyError| error.to_string();
        let mut optimiser = self.optimiser().map_err(text)?;
        let mut standing = Standing {
            done: Vec::new(),
            next: None,
            best: Vec::new(),
            feasible: false,
            unusable: Vec::new(),
        };
        let start =
            self.plan(Stage::Start, std::slice::from_ref(&self.start), self.machines).map_err(text)?;
        if self.missing(start, &mut standing, store)? {
            return Ok(standing);
        }
        for generation in 1..=self.generations {
            let stage = Stage::Generation(generation);
            let plan = self.plan(stage, &optimiser.ask(), self.machines).map_err(text)?;
            let missing = self.missing(plan, &mut standing, store)?;
            if let (false, Some(done)) = (missing, standing.done.last()) {
                optimiser.tell(&done.outcomes).map_err(text)?;
            }
            standing.best = self.best(&optimiser, &standing.done);
            standing.feasible = standing.best.iter().any(|(_, outcome)| outcome.is_feasible());
            if missing {
                return Ok(standing);
            }
            if optimiser.has_settled() {
                break;
            }
        }
        if self.check_machines > 0 {
            let mut designs = vec![self.start.clone()];
            designs.extend(self.finalists(&standing).into_iter().filter(|place| *place != self.start));
            let check = self.plan(Stage::Check, &designs, self.check_machines).map_err(text)?;
            let missing = self.missing(check, &mut standing, store)?;
            if let (false, 1, Some(check)) = (missing, self.goals.len(), standing.done.last()) {
                standing.best = check.best(|_| true).into_iter().collect();
                standing.feasible = standing.best.iter().any(|(_, outcome)| outcome.is_feasible());
            }
        }
        Ok(standing)
    }

    /// Designs for the check: a part of a front; with one goal the best at each of the [`DISTANCES`] from all
    /// bounds, and the best one.
    fn finalists(&self, standing: &Standing) -> Vec<Vec<f64>> {
        if self.goals.len() > 1 {
            return self.chosen(&standing.best);
        }
        let mut finalists: Vec<Vec<f64>> = standing.best.iter().map(|(place, _)| place.clone()).collect();
        for distance in DISTANCES {
            let far = |outcome: &Outcome| {
                outcome.is_feasible() && outcome.constraints.iter().all(|exceeded| *exceeded <= -distance)
            };
            let found = standing.done.iter().filter_map(|stage| stage.best(far));
            let found = found.min_by(|a, b| a.1.compare(&b.1));
            finalists.extend(found.map(|(place, _)| place).filter(|place| !finalists.contains(place)));
        }
        finalists
    }

    /// The given design is one of the candidates.
    fn best(&self, optimiser: &Optimiser, done: &[DoneStage]) -> Vec<(Vec<f64>, Outcome)> {
        let mut best = optimiser.best();
        let start = done.first().and_then(|start| Some((start.designs.first()?, start.outcomes.first()?)));
        if let (1, Some((place, outcome))) = (self.goals.len(), start)
            && !best.iter().any(|found| found.1.compare(outcome).is_lt())
        {
            best = vec![(place.clone(), outcome.clone())];
        }
        best
    }

    /// Designs of a front for the check: evenly distributed, including both ends.
    pub fn chosen(&self, best: &[(Vec<f64>, Outcome)]) -> Vec<Vec<f64>> {
        let mut sorted: Vec<&(Vec<f64>, Outcome)> = best.iter().collect();
        sorted.sort_by(|a, b| a.1.goals.partial_cmp(&b.1.goals).unwrap_or(std::cmp::Ordering::Equal));
        let last = sorted.len().saturating_sub(1);
        let count = sorted.len().min(CHECKED);
        (0..count).map(|k| sorted[k * last / (count - 1).max(1)].0.clone()).collect()
    }

    /// Reads a stage from the parts: complete stages are added; an incomplete one is next (true).
    fn missing(&self, stage: StagePlan, standing: &mut Standing, store: &dyn Store) -> Result<bool, String> {
        let mut rows = collect(&stage.plan, store)?;
        standing.unusable.append(&mut rows.unusable);
        if !rows.is_complete() {
            standing.next = Some((stage, rows));
            return Ok(true);
        }
        let outcomes = self.outcomes(&stage, &rows);
        let StagePlan { stage, plan, designs, machines } = stage;
        standing.done.push(DoneStage { stage, designs, machines, outcomes, rows, plan });
        Ok(false)
    }

    fn outcomes(&self, stage: &StagePlan, rows: &Rows) -> Vec<Outcome> {
        let column = |key: &str| rows.numbers(&stage.plan, key).unwrap_or_default();
        let machines = stage.machines as usize;
        // (values by row) of every goal and bound, the worst that can be where a machine failed.
        let values = |key: &str, largest: bool| -> Vec<f64> { self.values(rows, &column, key, largest) };
        let goals: Vec<Vec<f64>> = self.goals.iter().map(|goal| values(&goal.key, goal.largest)).collect();
        let bounds: Vec<[Vec<f64>; 2]> =
            self.bounds.iter().map(|bound| [true, false].map(|low| values(&bound.key, low))).collect();
        (0..stage.designs.len())
            .map(|design| {
                let of = design * machines..(design + 1) * machines;
                Outcome {
                    goals: self
                        .goals
                        .iter()
                        .zip(&goals)
                        .map(|(goal, values)| goal.of(values.get(of.clone()).unwrap_or_default()))
                        .collect(),
                    constraints: self
                        .bounds
                        .iter()
                        .zip(&bounds)
                        .flat_map(|(bound, values)| {
                            bound.exceeded(
                                values.each_ref().map(|side| side.get(of.clone()).unwrap_or_default()),
                            )
                        })
                        .collect(),
                }
            })
            .collect()
    }

    /// Values of a result by row. A life beyond the search counts as the searched hours; a failed machine counts as
    /// the worst value.
    fn values(
        &self,
        rows: &Rows,
        column: &dyn Fn(&str) -> Vec<Option<f64>>,
        key: &str,
        largest: bool,
    ) -> Vec<f64> {
        let worst = if largest { f64::NEG_INFINITY } else { f64::INFINITY };
        let searched = if key.starts_with("hours_to") { column(super::file::SEARCHED) } else { Vec::new() };
        column(key)
            .into_iter()
            .enumerate()
            .map(|(row, value)| {
                let failed = rows.records.get(row).is_none_or(|record| record.failed.is_some());
                let ongoing = || searched.get(row).copied().flatten();
                if failed { worst } else { value.or_else(ongoing).unwrap_or(worst) }
            })
            .collect()
    }

    /// All rows of the complete stages and the available rows of the next, as one table.
    ///
    /// # Errors
    /// [`StudyError`] of the plan.
    pub fn together(&self, standing: &Standing) -> Result<(Plan, Rows), StudyError> {
        let done = standing.done.iter().map(|stage| (&stage.plan, &stage.rows));
        let next = standing.next.iter().map(|(stage, rows)| (&stage.plan, rows));
        let (mut points, mut records) = (Vec::new(), Vec::new());
        for (plan, rows) in done.chain(next) {
            let first = points.len() as u64;
            points.extend((0..plan.rows()).map(|row| plan.sampling().point(row).unit));
            records.extend(rows.records.iter().cloned().map(|mut record| {
                record.number += first;
                record
            }));
        }
        let plan = self.over(points)?;
        let rows = Rows { of: plan.rows(), records, unusable: standing.unusable.clone() };
        Ok((plan, rows))
    }

    /// Number of the first row of a design in [`Search::together`].
    pub fn row_of(&self, standing: &Standing, place: &[f64]) -> Option<u64> {
        let mut first = 0;
        for stage in &standing.done {
            if let Some(index) = stage.designs.iter().position(|design| design == place) {
                return Some(first + index as u64 * stage.machines);
            }
            first += stage.plan.rows();
        }
        None
    }
}

/// Position of a value in a range; `None` outside.
pub(super) fn place_of(distribution: &Distribution, value: f64) -> Option<f64> {
    let place = match *distribution {
        Distribution::Uniform { low, high } => (value - low) / (high - low),
        Distribution::LogUniform { low, high } if value > 0.0 => (value / low).ln() / (high / low).ln(),
        _ => return None,
    };
    // A bound that equals the value of the design may differ by rounding.
    (-1e-9..=1.0 + 1e-9).contains(&place).then(|| place.clamp(0.0, 1.0))
}
