use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use arcmin::contact::MeshContact;
use arcmin::dynamics::{
    BearingJoints, Checkpoint, DynamicsError, FlexibleJoints, IdealJoints, JointSettings,
    Model as MovingModel, Run as Motion, RunPlan, StepControl, spread_over_starts,
};
use arcmin::fem::boundary::FlankArc;
use arcmin::life::worn_settings;
use arcmin::machine::PartWear;
use arcmin::units::{HOUR, MM, UM};
use arcmin::wear::{CoupledOptions, WornSurfaces};
use serde::{Deserialize, Serialize};

use self::inputs::{contact_law, drive, load};
use super::deviations::Deviations;
use super::joints::Joints;
use crate::failure::Failure;
use crate::run::{Common, Run, Verdict, write_file};

mod inputs;
mod results;

#[derive(Debug, clap::Args)]
#[command(
    long_about = "Integrates the equations of motion of the reducer in time and reports its transmission error θ_out − θ_s/i.\n\n\
                  timeseries.csv: time_s, input_speed_deg_s, output_speed_deg_s, load_n_m, te_arcmin.\n\
                  forces.csv: time_s, largest_pin_force_n, loaded_pins, mesh_force_n.\n\
                  spectrum.csv: order, amplitude_arcmin, in orders of the output turn, from runs of at least one full turn.\n\
                  Statistics are taken from --window-start-s on. Without load and drag the machine rattles in its clearance and the mean is no result: \
                  the run says so and reports the spread over perturbed starts.\n\n\
                  A long run writes checkpoint.json beside its results; Ctrl-C keeps it, and --resume goes on from there.",
    after_help = "Examples:\n  arcmin simulate my-reducer.toml --wear-um 10\n  \
                  arcmin simulate my-reducer.toml --hours 2000 --load sine --torque-nm 412 --period-s 0.3\n  \
                  arcmin simulate my-reducer.toml --load constant --end-s 3.5 --drag-nm 5"
)]
pub struct Options {
    #[command(flatten)]
    common: Common,
    /// Cycloid discs: rigid, or elastic by finite elements.
    #[arg(long, value_enum, default_value = "rigid")]
    model: Model,
    /// Joints between the bodies.
    #[arg(long, value_enum, default_value = "ideal")]
    joints: Joints,
    /// What the pins touch: the smooth flank, or what a mesh of linear elements leaves of it.
    #[arg(long, value_enum, default_value = "smooth")]
    flank: Flank,
    /// Edge length of that mesh in mm.
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = facet_mm)]
    facet_mm: f64,
    /// Depth removed from the whole flank in µm.
    #[arg(long, value_name = "X", conflicts_with = "hours", value_parser = crate::run::depth_um)]
    wear_um: Option<f64>,
    /// Flanks and pins as the coupled wear prediction leaves them after H hours at the design's duty.
    #[arg(long, value_name = "H", value_parser = crate::run::hours)]
    hours: Option<f64>,
    /// External torque at the output.
    #[arg(long, value_enum, default_value = "none")]
    load: LoadKind,
    /// Torque or amplitude of the load in N·m, positive against positive output motion [default: the rated
    /// torque].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    torque_nm: Option<f64>,
    /// Period of the sinusoidal load in s.
    #[arg(long, value_name = "T", default_value_t = 0.3)]
    period_s: f64,
    /// Rows of the load: CSV with a header; for `table` and `stepped` time_s,torque_n_m, for `duty-cycle`
    /// duration_s,torque_n_m.
    #[arg(long, value_name = "CSV", required_if_eq_any([("load", "table"), ("load", "stepped"), ("load", "duty-cycle")]))]
    load_file: Option<PathBuf>,
    /// Steady drag torque at the output in N·m, against the motion.
    #[arg(long, value_name = "T", default_value_t = 0.0)]
    drag_nm: f64,
    /// How the input is driven.
    #[arg(long, value_enum, default_value = "speed")]
    drive: DriveKind,
    /// Input speed in rpm [default: the rated speed].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    speed_rpm: Option<f64>,
    /// Time within which speed or angle law reach their full value, in s.
    #[arg(long, value_name = "T", default_value_t = 0.1)]
    rise_s: f64,
    /// Rows of the drive: CSV with a header; for `speed-table` time_s,speed_rpm, for `torque-table`
    /// time_s,torque_n_m at the motor.
    #[arg(long, value_name = "CSV", required_if_eq_any([("drive", "speed-table"), ("drive", "torque-table")]))]
    drive_file: Option<PathBuf>,
    /// Gain of the governed motor in N·m·s/rad.
    #[arg(long, value_name = "G", default_value_t = 0.5)]
    gain: f64,
    /// Length of the run in s.
    #[arg(long, value_name = "T", default_value_t = 0.8)]
    end_s: f64,
    /// Start of the window for the statistics in s [default: the rise time of the drive].
    #[arg(long, value_name = "T")]
    window_start_s: Option<f64>,
    /// Interval of timeseries.csv in s.
    #[arg(long, value_name = "T", default_value_t = 2e-4)]
    sample_s: f64,
    /// Contact law of flank and pins [default: the design's].
    #[arg(long, value_name = "LAW", value_enum)]
    contact: Option<Law>,
    /// Stiffness of the linear law (N/m, default 2.85e8) or of the impact function (N/m^e).
    #[arg(long, value_name = "K")]
    contact_stiffness: Option<f64>,
    /// Exponent of the impact function.
    #[arg(long, value_name = "E", default_value_t = 1.1)]
    contact_exponent: f64,
    /// Local error per step, in arcmin at the output.
    #[arg(long, value_name = "X", default_value_t = StepControl::default().tolerance)]
    tolerance: f64,
    /// Constant time step in s instead of error control.
    #[arg(long, value_name = "H")]
    fixed_step_s: Option<f64>,
    /// Perturbed starts of an unloaded run without drag, for its spread.
    #[arg(long, value_name = "N", default_value_t = 4)]
    starts: usize,
    #[command(flatten)]
    deviations: super::deviations::Options,
    #[command(flatten)]
    elastic: super::elastic::Options,
    /// Go on from the checkpoint in the output directory.
    #[arg(long)]
    resume: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Model {
    /// Rigid discs.
    Rigid,
    /// Elastic discs: finite elements reduced to modes and flank compliances.
    Flexible,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Flank {
    /// The worn flank itself.
    Smooth,
    /// Straight edges from node to node.
    Faceted,
    /// The nodes alone.
    Nodes,
}

fn facet_mm(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.02..=5.0).contains(&value) => Ok(value),
        _ => Err("give the edge length in mm, from 0.02 to 5".to_owned()),
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum LoadKind {
    None,
    Constant,
    /// Torque × sin(2π t/period).
    Sine,
    /// Straight lines between the rows of a file.
    Table,
    /// Each torque holds from its time on.
    Stepped,
    /// Phases that repeat.
    DutyCycle,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum DriveKind {
    /// The speed rises smoothly and never overshoots.
    Speed,
    /// The angle law of Tao2024, ω t STEP(t): the speed overshoots to 1.69 ω.
    Angle,
    /// Speed from a file.
    SpeedTable,
    /// Motor torque from a file on the inertia of motor and sun.
    TorqueTable,
    /// Motor inertia with a torque proportional to the error of speed.
    Governed,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Law {
    /// Hertzian line contact (Johnson).
    LineHertz,
    Linear,
    Palmgren,
    /// Eq. (6) of Tao2024.
    Tao2024,
    /// F = k δ^e with step-wise damping.
    Impact,
}

/// What a checkpoint belongs to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct SavedRun {
    design_hash: String,
    /// Debug form of all options that change the motion.
    settings: String,
    checkpoint: Checkpoint,
}

/// A run shorter than this is not worth a checkpoint.
const CHECKPOINT_INTERVAL: Duration = Duration::from_secs(10);
const CHECKPOINT: &str = "checkpoint.json";

pub fn run(options: Options) -> Result<Verdict, Failure> {
    let mut run = Run::start("simulate", &options.common)?;
    let mut machine = run.design.machine();
    if let Some(law) = contact_law(&options)? {
        machine.contact_law = law;
    }
    let worn = match options.hours {
        Some(hours) => machine
            .worn_surfaces(hours * HOUR, CoupledOptions::default())
            .map_err(Failure::compute("compute the wear"))?,
        None => WornSurfaces::uniform(options.wear_um.unwrap_or(0.0) * UM),
    };
    let deviations = Deviations::with_joints(
        &mut run,
        &options.common.design,
        &machine,
        &options.deviations,
        options.joints,
    )?;
    let drive = drive(&options, &machine)?;
    let load = load(&options, &machine)?;
    let invalid = Failure::compute("set up the simulation");
    let plan = plan(&options);
    let facets = match options.flank {
        Flank::Smooth => None,
        Flank::Faceted => Some(MeshContact::Edges),
        Flank::Nodes => Some(MeshContact::Nodes),
    }
    .map(|contact| {
        let arc = FlankArc::new(&machine.profile());
        // Whole edges to a lobe, four at least.
        (contact, arc.nodes(((arc.lobe_length() / (options.facet_mm * MM)).round() as usize).max(4)))
    });
    let unloaded =
        options.load == LoadKind::None && options.drag_nm == 0.0 && machine.friction.seal_drag == 0.0;
    if facets.is_some() && options.joints == Joints::Bearings {
        return Err(Failure::Usage {
            message: "faceted flanks do not run in bearings".to_owned(),
            help: "choose --joints ideal, or --flank smooth".to_owned(),
        });
    }
    let facet_mm = facets.is_some().then_some(options.facet_mm);
    let case = Case {
        machine: &machine,
        hours: options.hours,
        facet_mm,
        unloaded,
        worn: &worn,
        deviations: &deviations,
    };
    match (options.model, options.joints) {
        (discs, Joints::Bearings) => {
            let discs = (discs == Model::Flexible)
                .then(|| super::elastic::in_bearings(&run, &machine, &options.elastic))
                .transpose()?;
            let part_wear = match options.hours {
                Some(hours) if machine.wear.parts.any() => {
                    worn_settings(&machine, hours).map_err(Failure::compute("compute the wear"))?.part_wear
                }
                _ => PartWear::default(),
            };
            let errors = deviations.errors.clone();
            let settings = JointSettings {
                flank_wear: worn.flank.clone(),
                pin_wear: worn.pin.clone(),
                part_wear,
                errors,
                discs,
                ..JointSettings::default()
            };
            let model =
                BearingJoints::new(&machine, &settings, drive, load, options.drag_nm).map_err(invalid)?;
            execute(run, &options, model.into(), plan, &case)
        }
        (Model::Rigid, Joints::Ideal) => {
            let mut model =
                IdealJoints::new(&machine, &worn.flank, drive, load, options.drag_nm).map_err(invalid)?;
            if !worn.pin.is_zero() {
                model.set_pin_wear(&worn.pin);
            }
            facets.iter().for_each(|(contact, nodes)| model.set_facets(*contact, nodes));
            execute(run, &options, model.into(), plan, &case)
        }
        (Model::Flexible, Joints::Ideal) => {
            run.progress().report("reducing the discs", 0.0);
            let discs = super::elastic::discs(&machine, &options.elastic, &run.path("."))?;
            let elastic = options.elastic.dynamics();
            let mut model =
                FlexibleJoints::new(&machine, discs, &worn.flank, drive, load, options.drag_nm, elastic)
                    .map_err(invalid)?;
            if !worn.pin.is_zero() {
                model.set_pin_wear(&worn.pin);
            }
            facets.iter().for_each(|(contact, nodes)| model.set_facets(*contact, nodes));
            execute(run, &options, model.into(), plan, &case)
        }
    }
}

/// What a run is about, beside its model.
struct Case<'a> {
    machine: &'a arcmin::machine::Machine,
    hours: Option<f64>,
    /// Edge length of a faceted flank.
    facet_mm: Option<f64>,
    /// Neither load nor drag: the machine rattles.
    unloaded: bool,
    worn: &'a WornSurfaces,
    deviations: &'a Deviations,
}

fn plan(options: &Options) -> RunPlan {
    let control = StepControl {
        tolerance: options.tolerance,
        fixed_step: options.fixed_step_s,
        ..StepControl::default()
    };
    RunPlan {
        end: options.end_s,
        window_start: options.window_start_s.unwrap_or(options.rise_s),
        sample_interval: options.sample_s,
        force_interval: (5.0 * options.sample_s).max(1e-3),
        control,
    }
}

/// Runs a model to its end, or to Ctrl-C, and writes everything.
fn execute(
    mut run: Run,
    options: &Options,
    model: MovingModel,
    plan: RunPlan,
    case: &Case,
) -> Result<Verdict, Failure> {
    let started = Instant::now();
    let first = Motion::new(model, plan, run.progress()).map_err(setup)?;
    let saved = SavedRun {
        design_hash: run.design.hash(),
        settings: settings(options),
        checkpoint: first.checkpoint(),
    };
    let path = run.path(CHECKPOINT);
    let mut motion = if options.resume { resume(first.model().clone(), &path, &saved)? } else { first };
    let mut last_save = Instant::now();
    let save = |motion: &Motion| {
        let saved = SavedRun { checkpoint: motion.checkpoint(), ..saved.clone() };
        let text = serde_json::to_vec(&saved).map_err(Failure::compute("write the checkpoint"))?;
        write_file(&path, &text)
    };
    let mut failed = None;
    while !motion.is_finished() && failed.is_none() {
        if run.progress().is_cancelled() {
            save(&motion)?;
            return Err(Failure::Interrupted { time: motion.time(), path });
        }
        if last_save.elapsed() > CHECKPOINT_INTERVAL {
            save(&motion)?;
            last_save = Instant::now();
        }
        failed = match motion.proceed(500, run.progress()) {
            Err(DynamicsError::Cancelled { .. }) => continue,
            outcome => outcome.err(),
        };
        run.progress().report("simulating", motion.time() / plan.end);
    }
    let result = motion.result();
    let spread = if case.unloaded && failed.is_none() && options.starts > 0 {
        run.progress().report("perturbed starts", 0.0);
        Some(spread_over_starts(motion.model(), plan, options.starts, run.progress()).map_err(setup)?)
    } else {
        None
    };
    let summary = results::write(
        &mut run,
        case,
        motion.model(),
        &result,
        spread.as_ref(),
        failed.as_ref(),
        started.elapsed(),
    )?;
    run.finish(summary)?;
    // A finished run needs no checkpoint; one that cannot be removed does no harm.
    let _ = std::fs::remove_file(&path);
    match failed {
        Some(error) => Err(Failure::compute("finish the simulation; what was computed is kept")(error)),
        None => Ok(Verdict::Fine),
    }
}

fn setup(error: DynamicsError) -> Failure {
    Failure::compute("start the simulation")(error)
}

fn settings(options: &Options) -> String {
    let Options {
        model,
        joints,
        wear_um,
        hours,
        load,
        torque_nm,
        period_s,
        load_file,
        drag_nm,
        drive,
        speed_rpm,
        rise_s,
        ..
    } = options;
    let elastic = &options.elastic;
    let Options {
        drive_file,
        gain,
        end_s,
        window_start_s,
        sample_s,
        contact,
        contact_stiffness,
        contact_exponent,
        tolerance,
        ..
    } = options;
    format!(
        "{:?}",
        (
            (model, joints, wear_um, hours, load, torque_nm, period_s, load_file, drag_nm, drive, speed_rpm),
            (
                rise_s,
                drive_file,
                gain,
                end_s,
                window_start_s,
                sample_s,
                contact,
                contact_stiffness,
                contact_exponent,
                tolerance,
                options.fixed_step_s
            ),
            (elastic.element, elastic.bores, elastic.mode_frequency_hz, elastic.damping_ratio),
            (options.flank, options.facet_mm, options.deviations.errors, options.deviations.seed)
        )
    )
}

fn resume(model: MovingModel, path: &Path, expected: &SavedRun) -> Result<Motion, Failure> {
    let bytes = std::fs::read(path).map_err(|cause| Failure::Read { path: path.to_owned(), cause })?;
    let saved: SavedRun = serde_json::from_slice(&bytes).map_err(Failure::compute("read the checkpoint"))?;
    if saved.design_hash != expected.design_hash || saved.settings != expected.settings {
        return Err(Failure::Usage {
            message: format!("{} belongs to a run of another design or with other options", path.display()),
            help: "repeat the options of that run, or start afresh without --resume".to_owned(),
        });
    }
    Motion::resume(model, saved.checkpoint).map_err(setup)
}
