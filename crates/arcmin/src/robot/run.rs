//! The whole way from the robot file to the answers.

use std::sync::OnceLock;

use super::answers::{End, Overhaul, ToolLimit, ages};
use super::arm::{Arm, Body};
use super::compensation::{Remaining, remaining};
use super::figures::{Figure, Figures, Sorted, Tool};
use super::file::{Compensation, JointSection};
use super::joint::JointModel;
use super::kept::KeptJoint;
use super::life::{JointDuty, hash, mounted};
use super::loads::{Course, beyond, duty};
use super::models::models;
use super::population::Population;
use super::reach::{Reach, reach};
use super::read::{Program, Reducer, RobotFile};
use super::tool::{Field, Places};
use super::variants::{VariantAnswer, variants};
use crate::analyses::stage::AnyDesign;
use crate::analyses::{AnalysisError, Host};
use crate::design::InputFile;
use crate::exchange::JointRating;
use crate::scene::Solid;
use crate::study::{Shard, Store};
use crate::units::{DEG, HOUR, MM};

/// Options beside the robot file.
#[derive(Debug, Clone, Default)]
pub struct RobotOptions {
    /// Loads and duties alone, without lives.
    pub loads: bool,
    /// `lives.json` of an earlier run: its joints, their hours scaled by what wears them, in place of lives computed.
    pub lives: Option<InputFile>,
}

/// A reducer of an axis and what the programs ask of it.
#[derive(Debug, Clone)]
pub struct JointAnswer {
    pub axis: String,
    /// Name of its design.
    pub design_name: String,
    pub ratio: f64,
    /// N·m.
    pub rated: f64,
    pub duty: JointDuty,
    /// N·m at the motor's shaft, root mean square and largest; none without lives.
    pub motor: Option<(f64, f64)>,
    /// The design with the joint's duty, as text; none of a table.
    pub design_text: Option<String>,
    /// The bearing that lasts shortest and its L10 in hours of the robot.
    pub bearing: Option<(String, f64)>,
    /// Where its life comes from.
    pub source: Source,
}

/// Where the life of a joint comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    Computed,
    Table,
    /// An earlier run, hours scaled.
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

/// Gain by an overhaul of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OverhaulGain {
    pub overhaul: Overhaul,
    /// When a limit is left then; none within the planned hours.
    pub end: Option<f64>,
    /// Pose accuracy and repeatability at the planned hours, m.
    pub position: f64,
    pub repeatability: f64,
}

/// How an axis acts on the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lever {
    /// Largest distance of the tool from the axis over the test poses, m.
    pub lever: f64,
    /// Change of pose accuracy and repeatability at the planned hours for each rad that the axis is off less, and its
    /// lost motion is less: m/rad.
    pub position: f64,
    pub repeatability: f64,
}

/// The tool over the hours.
#[derive(Debug)]
pub struct ToolAnswer {
    pub joints: Vec<JointModel>,
    pub places: Places,
    pub sorted: Sorted,
    pub field: Field,
    /// Hours of the robot and its figures.
    pub figures: Vec<(f64, Figures)>,
    /// The first limit left within the planned hours.
    pub end: Option<End>,
    pub overhauls: Vec<OverhaulGain>,
    /// Fewest overhauls, and whether there are surely none fewer; none where there is no plan.
    pub plan: Option<(Vec<Overhaul>, bool)>,
    pub levers: Vec<Lever>,
    pub remaining: Vec<Remaining>,
    pub variants: Vec<VariantAnswer>,
    pub reach: Reach,
    pub population: Option<Population>,
}

/// The answer to a robot file.
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
    /// h.
    pub planned: f64,
    /// Compensation by the controller that the figures are for.
    pub compensates: Compensation,
    /// Programs with their motion.
    pub programs: Vec<Program>,
    /// Postures and loads along every program.
    pub courses: Vec<Course>,
    /// Reducers with their duties, from the base.
    pub joints: Vec<JointAnswer>,
    /// Limits of the tool.
    pub limits: Vec<ToolLimit>,
    /// None where loads alone were asked for.
    pub tool: Option<ToolAnswer>,
    /// The first limit left within the planned hours.
    pub end: Option<End>,
    /// Assumptions and inputs beyond the measured range, as sentences.
    pub notes: Vec<String>,
    /// Filled when they are asked for.
    pub(super) tables: OnceLock<Vec<crate::results::Table>>,
    /// Simple shapes of a URDF's links, of the base first; none of a table of axes.
    pub(super) visuals: Vec<Vec<Solid>>,
    /// For `lives.json`.
    pub(super) kept: Vec<KeptJoint>,
    /// Seeds of drawn robots; empty where none are drawn.
    pub seeds: Vec<u64>,
    /// Wall seconds of the stages.
    pub stages: Vec<(&'static str, f64)>,
}

/// Largest torque of a reducer for a moment, as a multiple of the rated one: usual in catalogues of RV reducers.
const MOMENTARY: f64 = 5.0;

/// A joint before its life.
pub(super) struct Before<'a> {
    pub section: &'a JointSection,
    /// A design as mounted.
    pub reducer: Reducer,
    pub design_name: String,
    pub ratio: f64,
    pub rated: f64,
    /// Largest torque allowed for a moment, N·m.
    pub allowed: f64,
    pub duty: JointDuty,
}

impl Before<'_> {
    pub fn design(&self) -> Option<&AnyDesign> {
        match &self.reducer {
            Reducer::Design(design) => Some(design),
            Reducer::Table(_) => None,
        }
    }

    /// Whether it differs from robot to robot of a population.
    pub fn is_drawn(&self) -> bool {
        self.design().is_some_and(AnyDesign::has_tolerances)
    }

    /// The design with the duty of the joint over the planned hours of the robot; as it is where the joint never turns.
    pub fn on_duty(
        &self,
        design: &AnyDesign,
        planned: f64,
        moments_in_wear: bool,
    ) -> Result<AnyDesign, AnalysisError> {
        match self.duty.rows.is_empty() {
            true => Ok(design.clone()),
            false => self.duty.put_on(design, planned * self.duty.moving, moments_in_wear),
        }
    }
}

/// Requirements of a robot file on its joints: all that is known before their lives.
pub struct Loaded<'a> {
    pub(super) file: &'a RobotFile,
    /// Without payload.
    pub(super) bare: Arm,
    pub(super) payload: Body,
    pub(super) arm: Arm,
    visuals: Vec<Vec<Solid>>,
    pub(super) programs: Vec<Program>,
    pub(super) courses: Vec<Course>,
    pub(super) before: Vec<Before<'a>>,
    notes: Vec<String>,
}

impl Loaded<'_> {
    /// Reads the files that a robot file names and finds the loads.
    ///
    /// # Errors
    /// [`AnalysisError`]: files that cannot be read, limits that programs do not keep.
    pub fn of<'a>(file: &'a RobotFile, host: &dyn Host) -> Result<Loaded<'a>, AnalysisError> {
        let (bare, payload) = file.arm(host)?;
        let arm = bare.carrying(&payload);
        let visuals = file.visuals(host)?;
        let sections = file.joints(&arm)?;
        let programs = file.programs(&arm, host)?;
        host.report("inverse dynamics", 0.0);
        let courses: Vec<Course> = programs.iter().map(|program| Course::of(&arm, program)).collect();
        let mut notes = Vec::new();
        let mut before = Vec::with_capacity(arm.count());
        for (axis, section) in sections.iter().enumerate() {
            before.push(joint_before(file, section, (&arm, axis), (&programs, &courses), host, &mut notes)?);
        }
        Ok(Loaded { file, bare, payload, arm, visuals, programs, courses, before, notes })
    }

    /// Hours in motion of every joint for each hour of the robot.
    pub(super) fn moving(&self) -> Vec<f64> {
        self.before.iter().map(|joint| joint.duty.moving).collect()
    }

    /// Places along the programs.
    pub(super) fn places(&self) -> Places {
        Places::of(&self.arm, &self.programs, &self.courses, *self.file.controller.approach_mm * MM)
    }
}

/// Answers a robot file. Drawn robots are kept in `parts`, which shards that ran elsewhere may have filled.
///
/// # Errors
/// [`AnalysisError`]: files that cannot be read, limits that programs do not keep, lives that cannot be found.
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

/// Wall seconds of the stages.
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

fn joint_before<'a>(
    file: &RobotFile,
    section: &'a JointSection,
    (arm, axis): (&Arm, usize),
    (programs, courses): (&[Program], &[Course]),
    host: &dyn Host,
    notes: &mut Vec<String>,
) -> Result<Before<'a>, AnalysisError> {
    let mut reducer = file.reducer(section, host)?;
    let (design_name, ratio, rated) = match &mut reducer {
        Reducer::Design(design) => {
            **design = mounted(design, *section.mounting, *section.motor_inertia_kg_m2)?;
            let JointRating { ratio, torque, .. } = design.joint_rating();
            (design.name().to_owned(), ratio, torque)
        }
        Reducer::Table(export) => (export.design_name.clone(), export.ratio, export.rated_torque_n_m),
    };
    let name = &arm.axes[axis].name;
    let given = arm.axes[axis].torque;
    let allowed = if given.is_finite() { given } else { MOMENTARY * rated };
    if let Some((program, sample, torque)) = beyond(programs, courses, axis, allowed) {
        let program = &programs[program];
        let message = format!(
            "the program \"{}\" asks the axis \"{name}\" for {torque:.0} N·m at {:.3} s; {allowed:.0} N·m are allowed",
            program.name, program.motion.time[sample]
        );
        let hint = match given.is_finite() {
            true => "slow the program down, take a lighter payload, or correct the limit",
            false => {
                "five times the rated torque is usual for a moment: slow the program down, take a larger reducer, or \
                 set torque_limit_n_m"
            }
        };
        return Err(file.wrong(message, section.axis.span.clone(), hint));
    }
    let bearings = MM * *section.bearings_mm;
    let duty = duty(programs, courses, axis, (bearings, ratio, *file.model.duty_rows));
    if duty.torque_peak > rated {
        notes.push(format!(
            "{name}: up to {:.0} N·m, rated {rated:.0} N·m; beyond ± rated torque the hysteresis loop goes on straight",
            duty.torque_peak
        ));
    }
    Ok(Before { section, reducer, design_name, ratio, rated, allowed, duty })
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

/// Gains by the overhaul of each axis at the hours asked about, or where none are when the first limit is reached.
fn overhauls(
    tool: &Tool<'_>,
    limits: &[ToolLimit],
    (planned, end): (f64, Option<End>),
    asked: &[f64],
) -> Vec<OverhaulGain> {
    let until = end.map(|end| end.hours);
    let hours = if asked.is_empty() { vec![until.unwrap_or(0.5 * planned)] } else { asked.to_vec() };
    let each =
        hours.iter().flat_map(|hours| (0..tool.field.axes()).map(|axis| Overhaul { axis, hours: *hours }));
    each.map(|overhaul| {
        let then = ages(tool.field.axes(), planned, &[overhaul]);
        // An overhaul after a limit has been left comes too late for it.
        let late = until.filter(|until| *until < overhaul.hours);
        let after = || tool.end(limits, &[overhaul], (overhaul.hours, planned)).map(|end| end.hours);
        OverhaulGain {
            overhaul,
            end: late.or_else(after),
            position: tool.figure(Figure::Position, &then),
            repeatability: tool.figure(Figure::Repeatability, &then),
        }
    })
    .collect()
}

/// By differences: what the figure is without the axis, for each rad that it is off on average.
fn levers(tool: &Tool<'_>, planned: f64) -> Vec<Lever> {
    let hours = vec![planned; tool.field.axes()];
    let (visit, size) = tool.worst_visit(&hours);
    let moved = tool.field.tool(tool.places, &hours, visit)[0];
    let along = if size > 0.0 { moved / size } else { moved };
    let alone = tool.repeatability_by_axis(&hours);
    let (pose, _) = tool.worst_pose(&hours);
    (0..tool.field.axes())
        .map(|axis| {
            let at = |place: usize| {
                let posture = &tool.places.places[place].posture;
                posture.moved_by(axis, &posture.axes[axis], 0.0)[0]
            };
            let lever = tool.sorted.visits.iter().map(|(place, _)| at(*place).norm()).fold(0.0, f64::max);
            let approaches = &tool.sorted.approaches[pose];
            let turns: Vec<f64> = approaches
                .iter()
                .map(|place| tool.field.at(axis, planned, *place).about.iter().sum::<f64>())
                .collect();
            let spread = turns.iter().copied().fold(f64::NEG_INFINITY, f64::max)
                - turns.iter().copied().fold(f64::INFINITY, f64::min);
            Lever {
                lever,
                position: at(visit).dot(&along).abs(),
                repeatability: if spread > 0.0 { alone[axis] / spread } else { 0.0 },
            }
        })
        .collect()
}

impl Robot {
    /// Hours until the first limit is left.
    pub fn hours_to_limit(&self) -> Option<f64> {
        self.end.map(|end| end.hours)
    }

    /// Share of the hours in which a program runs.
    pub fn busy(&self) -> f64 {
        self.programs.iter().map(|program| program.cycles * program.motion.duration()).sum::<f64>() / HOUR
    }
}

impl ToolAnswer {
    /// Errors of the joints at all places.
    pub fn mapped(&self) -> Tool<'_> {
        Tool { places: &self.places, sorted: &self.sorted, field: &self.field }
    }
}
