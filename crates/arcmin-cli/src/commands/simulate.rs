use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use arcmin::contact::ContactLaw;
use arcmin::dynamics::{
    BearingJoints, Checkpoint, Drive, DynamicsError, FlexibleJoints, IdealJoints, JointSettings, OutputLoad, Reducer, Run as Motion, RunPlan,
    RunResult, StartSpread, StepControl, TimeTable,
    spread_over_starts,
};
use arcmin::geometry::Relief;
use arcmin::machine::Machine;
use arcmin::units::{ARCMIN, DEG, HOUR, UM};
use arcmin::life::worn_settings;
use arcmin::wear::{CoupledOptions, CoupledWear};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::joints::Joints;
use crate::failure::Failure;
use crate::run::{Common, Run, Table, Verdict, write_file};

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
    /// Depth removed from the whole flank in µm.
    #[arg(long, value_name = "X", conflicts_with = "hours", value_parser = crate::run::depth_um)]
    wear_um: Option<f64>,
    /// Flanks and pins as the coupled wear prediction leaves them after H hours at the design's duty.
    #[arg(long, value_name = "H", value_parser = crate::run::hours)]
    hours: Option<f64>,
    /// External torque at the output.
    #[arg(long, value_enum, default_value = "none")]
    load: LoadKind,
    /// Torque or amplitude of the load in N·m, positive against positive output motion [default: the rated torque].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    torque_nm: Option<f64>,
    /// Period of the sinusoidal load in s.
    #[arg(long, value_name = "T", default_value_t = 0.3)]
    period_s: f64,
    /// Rows of the load: CSV with a header; for `table` and `stepped` time_s,torque_n_m, for `duty-cycle` duration_s,torque_n_m.
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
    /// Rows of the drive: CSV with a header; for `speed-table` time_s,speed_rpm, for `torque-table` time_s,torque_n_m at the motor.
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
/// Stiffness of one pin of the RV-40E-81 at half its rated torque, as published comparisons use it, in N/m.
const LINEAR_STIFFNESS: f64 = 2.85e8;
const CHECKPOINT: &str = "checkpoint.json";

pub fn run(options: Options) -> Result<Verdict, Failure> {
    let run = Run::start("simulate", &options.common)?;
    let mut machine = run.design.machine();
    if let Some(law) = contact_law(&options)? {
        machine.contact_law = law;
    }
    let worn = worn_surfaces(&options, &machine)?;
    let drive = drive(&options, &machine)?;
    let load = load(&options, &machine)?;
    let invalid = Failure::compute("set up the simulation");
    let plan = plan(&options);
    let unloaded = options.load == LoadKind::None && options.drag_nm == 0.0 && machine.friction.seal_drag == 0.0;
    match (options.model, options.joints) {
        (Model::Rigid, Joints::Bearings) => {
            let pin_wear = worn.pin.clone().unwrap_or_else(|| Relief::uniform(0.0));
            let part_wear = match options.hours {
                Some(hours) if machine.wear.parts.any() => worn_settings(&machine, hours).map_err(Failure::compute("compute the wear"))?.part_wear,
                _ => arcmin::machine::PartWear::default(),
            };
            let settings = JointSettings { flank_wear: worn.flank.clone(), pin_wear, part_wear, ..JointSettings::default() };
            let model = BearingJoints::new(&machine, &settings, drive, load, options.drag_nm).map_err(invalid)?;
            execute(run, &options, &model, model.output_index(), plan, unloaded, &worn)
        }
        (Model::Flexible, Joints::Bearings) => Err(Failure::Usage {
            message: "flexible discs do not run in bearings yet".to_owned(),
            help: "choose --model rigid --joints bearings, or --model flexible --joints ideal".to_owned(),
        }),
        (Model::Rigid, Joints::Ideal) => {
            let mut model = IdealJoints::new(&machine, &worn.flank, drive, load, options.drag_nm).map_err(invalid)?;
            if let Some(pin) = &worn.pin {
                model.set_pin_wear(pin);
            }
            execute(run, &options, &model, IdealJoints::OUTPUT, plan, unloaded, &worn)
        }
        (Model::Flexible, Joints::Ideal) => {
            run.progress().report("reducing the discs", 0.0);
            let discs = super::elastic::discs(&machine, &options.elastic, &run.path("."))?;
            let elastic = options.elastic.dynamics();
            let mut model = FlexibleJoints::new(&machine, discs, &worn.flank, drive, load, options.drag_nm, elastic).map_err(invalid)?;
            if let Some(pin) = &worn.pin {
                model.set_pin_wear(pin);
            }
            execute(run, &options, &model, IdealJoints::OUTPUT, plan, unloaded, &worn)
        }
    }
}

struct Worn {
    flank: Relief,
    pin: Option<Relief>,
    deepest: f64,
}

fn worn_surfaces(options: &Options, machine: &Machine) -> Result<Worn, Failure> {
    let Some(hours) = options.hours else {
        let depth = options.wear_um.unwrap_or(0.0) * UM;
        return Ok(Worn { flank: Relief::uniform(depth), pin: None, deepest: depth });
    };
    let failure = || Failure::compute("compute the wear");
    let settings = CoupledOptions::default();
    let exposure = machine.coupled_exposure(settings).map_err(failure())?;
    let mut wear = CoupledWear::new(machine, settings);
    wear.advance_to(exposure.at(hours * HOUR)).map_err(failure())?;
    let state = wear.state();
    Ok(Worn {
        flank: state.flank_seen_by_contact().clone(),
        pin: (!state.pin.is_zero()).then(|| state.pin_seen_by_contact().clone()),
        deepest: state.flank.deepest().0,
    })
}

fn contact_law(options: &Options) -> Result<Option<ContactLaw>, Failure> {
    let stiffness = || {
        options.contact_stiffness.ok_or_else(|| Failure::Usage {
            message: "this contact law has no stiffness of its own".to_owned(),
            help: "give it with --contact-stiffness, e.g. --contact linear --contact-stiffness 2.85e8".to_owned(),
        })
    };
    Ok(match options.contact {
        None => None,
        Some(Law::LineHertz) => Some(ContactLaw::LineHertz),
        Some(Law::Palmgren) => Some(ContactLaw::Palmgren),
        Some(Law::Tao2024) => Some(ContactLaw::Tao2024),
        Some(Law::Linear) => Some(ContactLaw::Linear { stiffness: options.contact_stiffness.unwrap_or(LINEAR_STIFFNESS) }),
        Some(Law::Impact) => Some(ContactLaw::Impact { stiffness: stiffness()?, exponent: options.contact_exponent }),
    })
}

fn drive(options: &Options, machine: &Machine) -> Result<Drive, Failure> {
    let speed = options.speed_rpm.map_or(machine.rated.input_speed, |rpm| rpm * arcmin::units::RPM);
    let rise_time = options.rise_s;
    let table = |unit: f64| read_rows(options.drive_file.as_deref(), "the drive", unit);
    let checked = |rows: Vec<(f64, f64)>| TimeTable::new("drive table", &rows).map_err(Failure::compute("read the drive"));
    Ok(match options.drive {
        DriveKind::Speed => Drive::SpeedLaw { speed, rise_time },
        DriveKind::Angle => Drive::AngleLaw { speed, rise_time },
        DriveKind::SpeedTable => Drive::SpeedTable(checked(table(arcmin::units::RPM)?)?),
        DriveKind::TorqueTable => Drive::TorqueTable(checked(table(1.0)?)?),
        DriveKind::Governed => Drive::Governed { speed, rise_time, gain: options.gain },
    })
}

fn load(options: &Options, machine: &Machine) -> Result<OutputLoad, Failure> {
    let torque = options.torque_nm.unwrap_or(machine.rated.torque);
    let rows = || read_rows(options.load_file.as_deref(), "the load", 1.0);
    Ok(match options.load {
        LoadKind::None => OutputLoad::None,
        LoadKind::Constant => OutputLoad::Constant { torque },
        LoadKind::Sine => OutputLoad::Sine { amplitude: torque, period: options.period_s },
        LoadKind::Table => OutputLoad::Table(TimeTable::new("load table", &rows()?).map_err(Failure::compute("read the load"))?),
        LoadKind::Stepped => OutputLoad::Stepped(rows()?),
        LoadKind::DutyCycle => OutputLoad::DutyCycle(rows()?),
    })
}

fn plan(options: &Options) -> RunPlan {
    let control = StepControl { tolerance: options.tolerance, fixed_step: options.fixed_step_s, ..StepControl::default() };
    RunPlan {
        end: options.end_s,
        window_start: options.window_start_s.unwrap_or(options.rise_s),
        sample_interval: options.sample_s,
        force_interval: (5.0 * options.sample_s).max(1e-3),
        control,
    }
}

/// Reads two columns of numbers under one header row; the second is multiplied by `unit`.
fn read_rows(path: Option<&Path>, what: &str, unit: f64) -> Result<Vec<(f64, f64)>, Failure> {
    let Some(path) = path else {
        return Err(Failure::Usage { message: format!("{what} needs a file"), help: "see --load-file and --drive-file".to_owned() });
    };
    let text = std::fs::read_to_string(path).map_err(|cause| Failure::Read { path: path.to_owned(), cause })?;
    let mut rows = Vec::new();
    for (index, line) in text.lines().enumerate().skip(1).filter(|(_, line)| !line.trim().is_empty()) {
        let mut fields = line.split(',').map(|field| field.trim().parse::<f64>());
        match (fields.next(), fields.next()) {
            (Some(Ok(time)), Some(Ok(value))) => rows.push((time, value * unit)),
            _ => {
                return Err(Failure::Usage {
                    message: format!("{}, line {}: \"{line}\" does not hold two numbers", path.display(), index + 1),
                    help: "a header line, then lines such as 0.1,412".to_owned(),
                });
            }
        }
    }
    Ok(rows)
}

/// Runs a model to its end, or to Ctrl-C, and writes everything.
fn execute<M: Reducer + Sync>(
    mut run: Run,
    options: &Options,
    model: &M,
    output_index: usize,
    plan: RunPlan,
    unloaded: bool,
    worn: &Worn,
) -> Result<Verdict, Failure> {
    let started = Instant::now();
    let saved = SavedRun { design_hash: run.design.hash(), settings: settings(options), checkpoint: Motion::new(model, plan).map_err(setup)?.checkpoint() };
    let path = run.path(CHECKPOINT);
    let mut motion = if options.resume { resume(model, &path, &saved)? } else { Motion::new(model, plan).map_err(setup)? };
    let mut last_save = Instant::now();
    let save = |motion: &Motion<M>| {
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
        failed = motion.proceed(500).err();
        run.progress().report("simulating", motion.time() / plan.end);
    }
    let result = motion.result();
    let spread = if unloaded && failed.is_none() && options.starts > 0 {
        run.progress().report("perturbed starts", 0.0);
        Some(spread_over_starts(model, plan, output_index, options.starts).map_err(setup)?)
    } else {
        None
    };
    let summary = write(&mut run, options, model, &result, spread.as_ref(), failed.as_ref(), worn, started.elapsed())?;
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
    let Options { model, joints, wear_um, hours, load, torque_nm, period_s, load_file, drag_nm, drive, speed_rpm, rise_s, .. } = options;
    let elastic = &options.elastic;
    let Options { drive_file, gain, end_s, window_start_s, sample_s, contact, contact_stiffness, contact_exponent, tolerance, .. } = options;
    format!(
        "{:?}",
        (
            (model, joints, wear_um, hours, load, torque_nm, period_s, load_file, drag_nm, drive, speed_rpm),
            (rise_s, drive_file, gain, end_s, window_start_s, sample_s, contact, contact_stiffness, contact_exponent, tolerance, options.fixed_step_s),
            (elastic.element, elastic.bores, elastic.mode_frequency_hz, elastic.damping_ratio)
        )
    )
}

fn resume<'m, M: Reducer>(model: &'m M, path: &Path, expected: &SavedRun) -> Result<Motion<'m, M>, Failure> {
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

fn write<M: Reducer>(
    run: &mut Run,
    options: &Options,
    model: &M,
    result: &RunResult,
    spread: Option<&StartSpread>,
    failed: Option<&DynamicsError>,
    worn: &Worn,
    wall: Duration,
) -> Result<Value, Failure> {
    let mut series = Table::new(&["time_s", "input_speed_deg_s", "output_speed_deg_s", "load_n_m", "te_arcmin"]);
    for row in &result.series {
        series.row(&[
            row.time.into(),
            (row.input_speed / DEG).into(),
            (row.output_speed / DEG).into(),
            row.load.into(),
            (row.transmission_error / ARCMIN).into(),
        ]);
    }
    run.table("timeseries.csv", series)?;
    let mut forces = Table::new(&["time_s", "largest_pin_force_n", "loaded_pins", "mesh_force_n"]);
    for row in &result.forces {
        let f = row.forces;
        forces.row(&[row.time.into(), f.largest_pin_force.into(), f.loaded_pins.into(), f.mesh_force.into()]);
    }
    run.table("forces.csv", forces)?;
    match &result.spectrum {
        Some(lines) => {
            let mut table = Table::new(&["order", "amplitude_arcmin"]);
            for line in lines {
                table.row(&[line.order.into(), (line.amplitude / ARCMIN).into()]);
            }
            run.table("spectrum.csv", table)?;
        }
        // One from an earlier run would be taken for this one's.
        None => drop(std::fs::remove_file(run.path("spectrum.csv"))),
    }
    let te = result.statistics.map(|te| {
        json!({
            "mean_arcmin": te.mean / ARCMIN,
            "mean_abs_arcmin": te.mean_abs / ARCMIN,
            "max_abs_arcmin": te.max_abs / ARCMIN,
            "peak_to_peak_arcmin": te.peak_to_peak / ARCMIN,
            "rms_arcmin": te.rms / ARCMIN,
            "lowest_arcmin": te.lowest / ARCMIN,
            "highest_arcmin": te.highest / ARCMIN,
            "window_s": te.duration,
        })
    });
    let spread_json = spread.map(|spread| {
        json!({
            "starts": spread.runs.len(),
            "chaotic": spread.is_chaotic(),
            "mean_spread_arcmin": spread.mean / ARCMIN,
            "rms_spread_arcmin": spread.rms / ARCMIN,
            "band_arcmin": spread.band / ARCMIN,
        })
    });
    let energy = &result.energy;
    let mut summary = json!({
        "ratio": model.ratio(),
        "mean_ratio": result.mean_ratio,
        "wear_um": worn.deepest / UM,
        "hours": options.hours,
        "complete": failed.is_none(),
        "reached_s": result.reached,
        "te": te,
        "perturbed_starts": spread_json,
        "solver": {
            "steps": result.counts.accepted,
            "rejected_steps": result.counts.rejected,
            "evaluations": result.counts.evaluations,
            "wall_s": wall.as_secs_f64(),
            "energy_residual": energy.residual(),
        },
        "energy": {
            "input_j": energy.input, "load_j": energy.load, "dissipated_j": energy.dissipated,
            "stored_j": energy.current, "turnover_j": energy.turnover,
        },
        "largest_pin_force_n": result.forces.iter().map(|f| f.forces.largest_pin_force).fold(0.0, f64::max),
    });
    if let (Some(error), Value::Object(map)) = (failed, &mut summary) {
        map.insert("error".to_owned(), json!(error.to_string()));
    }
    if let Some(te) = result.statistics {
        run.say(&format!(
            "TE  mean {:+.4}'   mean |TE| {:.4}'   max |TE| {:.4}'   peak to peak {:.4}'   RMS {:.4}'",
            te.mean / ARCMIN,
            te.mean_abs / ARCMIN,
            te.max_abs / ARCMIN,
            te.peak_to_peak / ARCMIN,
            te.rms / ARCMIN
        ));
    }
    if let Some(spread) = spread {
        run.say(&format!(
            "{} perturbed starts: mean spreads over {:.4}', RMS over {:.4}', all within ±{:.4}'",
            spread.runs.len(),
            spread.mean / ARCMIN,
            spread.rms / ARCMIN,
            spread.band / ARCMIN
        ));
        if spread.is_chaotic() {
            run.say("the unloaded machine rattles chaotically: its mean is no result, band and RMS are; --drag-nm 5 gives a well-defined mean");
        }
    }
    run.say(&format!(
        "{} steps in {:.2} s, energy residual {:.1e}",
        result.counts.accepted,
        wall.as_secs_f64(),
        energy.residual()
    ));
    Ok(summary)
}
