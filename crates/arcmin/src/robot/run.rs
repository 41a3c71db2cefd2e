//! The complete computation from the robot file to the results.

use std::sync::OnceLock;

use super::answers::{End, Overhaul, OverhaulGain, ToolLimit, overhauls};
use super::arm::Arm;
use super::compensation::{Remaining, remaining};
use super::figures::{Figure, Figures, Sorted, Tool};
use super::file::Compensation;
use super::joint::JointModel;
use super::kept::KeptJoint;
use super::levers::{Lever, levers};
use super::life::{JointDuty, hash};
use super::loaded::{Before, Loaded};
use super::loads::Course;
use super::models::models;
use super::population::Population;
use super::reach::{Reach, reach};
use super::read::{Program, Reducer, RobotFile};
use super::tool::{Field, Places};
use super::variants::{VariantAnswer, variants};
use crate::analyses::{AnalysisError, Host};
use crate::design::InputFile;
use crate::scene::Solid;
use crate::study::{Shard, Store};
use crate::units::{DEG, HOUR, MM};

/// Options in addition to the robot file.
#[derive(Debug, Clone, Default)]
pub struct RobotOptions {
    /// Compute loads and duties only, without lives.
    pub loads: bool,
    /// `lives.json` of an earlier run, whose joints are used with scaled hours instead of a new computation.
    pub lives: Option<InputFile>,
}

/// A reducer of an axis, and its requirements by the programs.
#[derive(Debug, Clone)]
pub struct JointAnswer {
    pub axis: String,
    /// Name of its design.
    pub design_name: String,
    pub ratio: f64,
    /// Rated torque, N·m.
    pub rated: f64,
    pub duty: JointDuty,
    /// Torque at the motor's shaft in N·m, root mean square and largest; `None` without lives.
    pub motor: Option<(f64, f64)>,
    /// The design with the joint's duty, as text; `None` for a table.
    pub design_text: Option<String>,
    /// The bearing with the shortest life, and its L10 in hours of the robot.
    pub bearing: Option<(String, f64)>,
    /// Source of its life.
    pub source: Source,
}

/// Source of the life of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    Computed,
    Table,
    /// An earlier run, with scaled hours.
    Scaled,
}

impl Source {
    pub fn word(self) -> &'static str {
        match self {
            Source::Computed => "computed",
            Source::Table => "table",
            Source::Scaled => "scaled",
        }
    }
}

/// Results for the tool over the hours.
#[derive(Debug)]
pub struct ToolAnswer {
    pub joints: Vec<JointModel>,
    pub places: Places,
    pub sorted: Sorted,
    pub field: Field,
    /// Hours of the robot with the figures.
    pub figures: Vec<(f64, Figures)>,
    /// The first limit exceeded within the planned hours.
    pub end: Option<End>,
    pub overhauls: Vec<OverhaulGain>,
    /// The plan with the fewest overhauls, and whether it is certain that none has fewer; `None` if there is no
    /// plan.
    pub plan: Option<(Vec<Overhaul>, bool)>,
    pub levers: Vec<Lever>,
    pub remaining: Vec<Remaining>,
    pub variants: Vec<VariantAnswer>,
    pub reach: Reach,
    pub population: Option<Population>,
}

/// Results for a robot file.
#[derive(Debug)]
pub struct Robot {
    /// Name from the robot file.
    pub name: String,
    /// Text of the robot file.
    pub text: String,
    /// Hash of its values, independent of layout and comments.
    pub hash: String,
    /// Axes, links and tool.
    pub arm: Arm,
    /// Planned hours of the robot.
    pub planned: f64,
    /// Compensation by the controller for which the figures are valid.
    pub compensates: Compensation,
    /// Programs with their motion.
    pub programs: Vec<Program>,
    /// Postures and loads along every program.
    pub courses: Vec<Course>,
    /// Reducers with their duties, from the base.
    pub joints: Vec<JointAnswer>,
    /// Limits of the tool.
    pub limits: Vec<ToolLimit>,
    /// Results for the tool; `None` if only loads were requested.
    pub tool: Option<ToolAnswer>,
    /// The first limit exceeded within the planned hours.
    pub end: Option<End>,
    /// Assumptions, and inputs outside of the computed range, as sentences.
    pub notes: Vec<String>,
    /// Tables, filled when they are first used.
    pub(super) tables: OnceLock<Vec<crate::results::Table>>,
    /// Simple shapes of a URDF's links, beginning with the base; empty for a table of axes.
    pub(super) visuals: Vec<Vec<Solid>>,
    /// Joint lives for `lives.json`.
    pub(super) kept: Vec<KeptJoint>,
    /// Seeds of drawn robots; empty if there are none.
    pub seeds: Vec<u64>,
    /// Wall time of the stages in s.
    pub stages: Vec<(&'static str, f64)>,
}

/// Computes the results for a robot file. Drawn robots are stored in `parts`, which may contain those of shards
/// that ran elsewhere.
///
/// # Errors
/// [`AnalysisError`]: files that cannot be read, limits that programs violate, lives that cannot be computed.
pub fn run(
    file: &RobotFile,
    options: &RobotOptions,
    host: &dyn Host,
    parts: &dyn Store,
) -> Result<Robot, AnalysisError> {
    let mut stages = Stages { since: host.seconds(), all: Vec::new(), host };
    let loaded = Loaded::of(file, host)?;
    stages.end("loads");
    let planned = *file.planned_hours;
    let limits = limits(file);
    let mut joints: Vec<JointAnswer> = loaded
        .before
        .iter()
        .zip(&loaded.arm.axes)
        .map(|(joint, axis)| joint_answer(joint, &axis.name, (planned, *file.model.moments_in_wear)))
        .collect::<Result<_, _>>()?;
    let (mut tool, mut end, mut kept) = (None, None, Vec::new());
    if !options.loads {
        let models = models(&loaded, options, &mut joints, &mut kept, host)?;
        stages.end("lives");
        let answer = tool_answer(&loaded, models, &limits, parts, &mut stages)?;
        end = answer.end;
        tool = Some(answer);
    }
    let Loaded { arm, visuals, programs, courses, mut notes, .. } = loaded;
    let population = tool.as_ref().and_then(|tool| tool.population.as_ref());
    notes.extend(population.iter().flat_map(|drawn| drawn.notes()));
    Ok(Robot {
        name: file.name.value.clone(),
        text: file.text().to_owned(),
        hash: hash(&file.canonical()),
        arm,
        planned,
        compensates: *file.controller.compensates,
        programs,
        courses,
        joints,
        limits,
        seeds: population.map(|drawn| drawn.seed).into_iter().collect(),
        tool,
        end,
        notes,
        visuals,
        tables: OnceLock::new(),
        kept,
        stages: stages.all,
    })
}

/// Wall time of the stages in s.
struct Stages<'a> {
    since: f64,
    all: Vec<(&'static str, f64)>,
    host: &'a dyn Host,
}

impl Stages<'_> {
    fn end(&mut self, name: &'static str) {
        let now = self.host.seconds();
        self.all.push((name, now - self.since));
        self.since = now;
    }
}

fn tool_answer(
    loaded: &Loaded<'_>,
    models: Vec<JointModel>,
    limits: &[ToolLimit],
    parts: &dyn Store,
    stages: &mut Stages<'_>,
) -> Result<ToolAnswer, AnalysisError> {
    let (file, arm, host) = (loaded.file, &loaded.arm, stages.host);
    let (planned, compensates) = (*file.planned_hours, *file.controller.compensates);
    host.report("tool", 0.0);
    let moving = loaded.moving();
    let places = loaded.places();
    let sorted = Sorted::of(&places);
    let field = Field::of(&places, &models, &moving, compensates);
    let tool = Tool { places: &places, sorted: &sorted, field: &field };
    let count = *file.model.ages;
    let figures = (0..count)
        .map(|age| {
            let hours = planned * age as f64 / (count - 1) as f64;
            (hours, tool.figures(&vec![hours; arm.count()]))
        })
        .collect();
    stages.end("tool");
    host.report("answers", 0.0);
    let end = tool.end(limits, &[], (0.0, planned));
    let overhauls = overhauls(&tool, limits, (planned, end), &file.overhaul_h);
    let plan = tool.plan(limits, planned);
    let levers = levers(&tool, planned);
    let remaining = remaining(&places, &sorted, &models, &moving, planned);
    stages.end("answers");
    let approach = *file.controller.approach_mm * MM;
    let reach = reach(arm, &models, &moving, (compensates, approach), planned, &loaded.programs);
    stages.end("reach");
    let variants = variants(loaded, &models, limits, host)?;
    stages.end("variants");
    let population = match loaded.population_plan()? {
        Some(plan) => {
            loaded.draw(&plan, Shard::WHOLE, parts, host)?;
            Some(loaded.population(&plan, parts)?)
        }
        None => None,
    };
    stages.end("population");
    Ok(ToolAnswer {
        joints: models,
        places,
        sorted,
        field,
        figures,
        end,
        overhauls,
        plan,
        levers,
        remaining,
        variants,
        reach,
        population,
    })
}

fn limits(file: &RobotFile) -> Vec<ToolLimit> {
    let section = &file.limits;
    [
        (Figure::Position, section.position_mm.map(|x| x * MM)),
        (Figure::Orientation, section.orientation_deg.map(|x| x * DEG)),
        (Figure::Repeatability, section.repeatability_mm.map(|x| x * MM)),
        (Figure::Path, section.path_mm.map(|x| x * MM)),
    ]
    .into_iter()
    .filter_map(|(figure, allowed)| Some(ToolLimit { figure, allowed: allowed? }))
    .collect()
}

fn joint_answer(
    joint: &Before<'_>,
    axis: &str,
    (planned, moments): (f64, bool),
) -> Result<JointAnswer, AnalysisError> {
    let text = match joint.design() {
        Some(design) => Some(joint.on_duty(design, planned, moments)?.text().to_owned()),
        None => None,
    };
    Ok(JointAnswer {
        axis: axis.to_owned(),
        design_name: joint.design_name.clone(),
        ratio: joint.ratio,
        rated: joint.rated,
        duty: joint.duty.clone(),
        motor: None,
        design_text: text,
        bearing: None,
        source: match joint.reducer {
            Reducer::Table(_) => Source::Table,
            Reducer::Design(_) => Source::Computed,
        },
    })
}

impl Robot {
    /// Hours until the first limit is exceeded.
    pub fn hours_to_limit(&self) -> Option<f64> {
        self.end.map(|end| end.hours)
    }

    /// Fraction of the hours in which a program runs.
    pub fn busy(&self) -> f64 {
        self.programs.iter().map(|program| program.cycles * program.motion.duration()).sum::<f64>() / HOUR
    }
}

impl ToolAnswer {
    /// Errors of the joints at all positions.
    pub fn mapped(&self) -> Tool<'_> {
        Tool { places: &self.places, sorted: &self.sorted, field: &self.field }
    }
}
