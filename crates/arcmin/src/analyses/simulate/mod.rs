//! Transmission error of the running machine in time.

/// A closed set of words, each with its meaning.
macro_rules! choice {
    ($(#[doc = $doc:literal])* $Name:ident { $($(#[doc = $meaning:literal])* $Value:ident = $word:literal,)* }) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $Name { $($(#[doc = $meaning])* $Value,)* }

        impl Choice for $Name {
            const WORDS: &'static [(&'static str, &'static str)] =
                &[$(($word, concat!($($meaning),*).trim_ascii()),)*];
            const VALUES: &'static [$Name] = &[$($Name::$Value,)*];
        }
    };
}

mod declared;
mod inputs;
mod page;

pub(crate) use declared::orders_value;
pub use declared::{SUMMARY, tables};

use serde::{Deserialize, Serialize};

use super::{AnalysisError, Attachment, Host, elastic_disc, outcome};
use crate::contact::MeshContact;
use crate::design::{Choice, Design, InputFile, default, default_word, optional, options};
use crate::dynamics::{
    Checkpoint, DynamicsError, Reducer, Run, RunPlan, RunResult, StartSpread, StepControl, spread_over_starts,
};
use crate::fidelity::{Facets, Fidelity, FidelityOptions};
use crate::life::{WornState, worn_after};
use crate::machine::{Machine, OutputForces};
use crate::units::{MM, UM};

pub const ABOUT: &str = "Integrate the equations of motion: transmission error in time";
pub const GUIDE: &str = "Integrates the equations of motion of the reducer in time and reports its transmission error θ_out − \
    θ_in/i, with statistics from the start of the window on. Without load and drag the machine rattles \
    in its clearance and the mean depends on the start; the run then reports the spread over perturbed \
    starts.\n\nA long run writes checkpoints to its result directory. After Ctrl-C, --resume continues \
    from the last one if design, options and input files are the same.";
pub const EXAMPLES: &[&str] = &[
    "arcmin simulate my-reducer.toml --wear-um 10",
    "arcmin simulate my-reducer.toml --hours 2000 --load sine --torque-nm 412 --period-s 0.3",
    "arcmin simulate my-reducer.toml --joints bearings --load constant --end-s 3.5 --drag-nm 5",
];

options! {
    /// Options of `simulate`.
    pub struct Options {
        [fidelity: FidelityOptions]
        /// Geometry of the flank in contact: smooth, or as a mesh of linear elements represents it.
        flank: Flank => default_word("smooth"),
        /// Edge length of the mesh of a faceted flank.
        facet_mm: f64 => default(1.0, 0.02, 5.0),
        /// Uniform wear depth of the whole flank.
        wear_um: Option<f64> => optional(0.0, 1000.0),
        /// Age of the machine in hours of its duty: flanks, pins, bearings and gears are worn accordingly, with the same
        /// model of the machine.
        hours: Option<f64> => optional(0.0, 1e7),
        /// Course of the external torque at the output.
        load: LoadKind => default_word("none"),
        /// Torque or amplitude of the load; positive torque opposes positive output motion. Left out: the rated torque.
        torque_nm: Option<f64> => optional(-1e7, 1e7),
        /// Period of the sinusoidal load.
        period_s: f64 => default(0.3, 1e-4, 1e4),
        /// File of the load. Columns: time_s and torque_n_m (table, stepped), duration_s and torque_n_m (duty-cycle).
        load_file: Option<InputFile> => optional(0.0, 0.0),
        /// Names for columns of load and drive files with other headings: HEADING=time_s,HEADING=torque_n_m, or by number,
        /// 1=time_s,2=torque_n_m.
        columns: String => default_word(""),
        /// Number of lines in load and drive files before the column names.
        skip_lines: usize => default(0.0, 0.0, 1e6),
        /// Constant drag torque at the output, against the motion.
        drag_nm: f64 => default(0.0, 0.0, 1e6),
        /// External tilting moment on the output; needs joints in bearings.
        moment_nm: f64 => default(0.0, 0.0, 1e7),
        /// External axial force on the output, positive out of the machine.
        axial_n: f64 => default(0.0, -1e8, 1e8),
        /// External radial force on the output, in the middle of the main bearings and in the plane of the moment.
        radial_n: f64 => default(0.0, -1e8, 1e8),
        /// Drive of the input.
        drive: DriveKind => default_word("speed"),
        /// Input speed. Left out: the rated speed.
        speed_rpm: Option<f64> => optional(-30000.0, 30000.0),
        /// Rise time of the speed law and the angle law.
        rise_s: f64 => default(0.1, 1e-4, 1e3),
        /// File of the drive. Columns: time_s and speed_rpm (speed-table), time_s and torque_n_m at the motor (torque-table).
        drive_file: Option<InputFile> => optional(0.0, 0.0),
        /// Gain of the speed controller (governed), in N·m·s/rad.
        gain: f64 => default(0.5, 1e-6, 1e6),
        /// Simulated time.
        end_s: f64 => default(0.8, 1e-6, 1e5),
        /// Time from which statistics are taken. Left out: the rise time of the drive.
        window_start_s: Option<f64> => optional(0.0, 1e5),
        /// Sampling interval of timeseries.csv.
        sample_s: f64 => default(2e-4, 1e-7, 10.0),
        /// Contact law of flank and pins. Left out: the design's.
        contact: Option<inputs::Law> => optional(0.0, 0.0),
        /// Stiffness of the linear law in N/m (left out: 2.85e8), or of the impact law in N/m^e.
        contact_stiffness: Option<f64> => optional(1.0, 1e20),
        /// Exponent e of the impact law.
        contact_exponent: f64 => default(1.1, 1.0, 3.0),
        /// Allowed local error of a time step, in arcmin at the output.
        tolerance: f64 => default(5e-5, 1e-10, 1.0),
        /// Constant time step, without error control.
        fixed_step_s: Option<f64> => optional(1e-9, 1e-2),
        /// Number of perturbed starts that give the spread of an unloaded run without drag.
        starts: usize => default(4.0, 0.0, 1000.0),
        /// Continue from the checkpoint in the result directory.
        resume: bool => optional(0.0, 0.0),
    }
}

choice! {
    /// What the pins touch.
    Flank {
        /// the worn flank as computed
        Smooth = "smooth",
        /// straight edges between nodes
        Faceted = "faceted",
        /// contact at the nodes only
        Nodes = "nodes",
    }
}

choice! {
    /// External torque at the output.
    LoadKind {
        /// no load
        None = "none",
        /// constant torque
        Constant = "constant",
        /// torque × sin(2π t/period)
        Sine = "sine",
        /// linear between the rows of a file
        Table = "table",
        /// each torque of a file holds until the next row
        Stepped = "stepped",
        /// the phases of a file, repeated
        DutyCycle = "duty-cycle",
    }
}

choice! {
    /// How the input is driven.
    DriveKind {
        /// speed law with a smooth rise and no overshoot
        Speed = "speed",
        /// angle law of Tao2024, ω t STEP(t); the speed overshoots to 1.69 ω
        Angle = "angle",
        /// speed from a file
        SpeedTable = "speed-table",
        /// motor torque from a file, acting on the inertia of motor and sun
        TorqueTable = "torque-table",
        /// motor inertia with a torque proportional to the speed error
        Governed = "governed",
    }
}

/// A run and what it was about.
#[derive(Debug, Clone)]
pub struct Simulate {
    pub machine: Machine,
    pub fidelity: Fidelity,
    pub worn: WornState,
    pub plan: RunPlan,
    pub result: RunResult,
    pub ratio: f64,
    /// Over perturbed starts, of an unloaded machine without drag.
    pub spread: Option<StartSpread>,
    /// Why the run broke off; what was computed until then is kept.
    pub broke_off: Option<String>,
    /// Edge length in m of a faceted flank.
    pub facet: Option<f64>,
    /// Seconds of the computation, where the host has a clock.
    pub wall: f64,
    /// What is to be said of the files of drive and load.
    pub notes: Vec<String>,
}

/// What a checkpoint holds.
#[derive(Serialize, Deserialize)]
struct Saved {
    checkpoint: Checkpoint,
}

/// Integrates the motion.
///
/// # Errors
/// [`AnalysisError`]; [`AnalysisError::Interrupted`] when the host stops it, after a checkpoint was kept. A run
/// whose integration fails on the way is an outcome with [`Simulate::broke_off`].
pub fn run(design: &Design, options: &Options, host: &dyn Host) -> Result<Simulate, AnalysisError> {
    let mut machine = design.machine();
    if let Some(law) = inputs::contact_law(options)? {
        machine.contact_law = law;
    }
    if options.wear_um.is_some() && options.hours.is_some() {
        return Err(AnalysisError::usage(
            "uniform wear (wear_um) and wear by the duty (hours) exclude each other",
            "leave one of them out",
        ));
    }
    let drive = inputs::drive(options, &machine, host)?;
    let load = inputs::load(options, &machine, host)?;
    let notes = [drive.notes, load.notes].concat();
    let mut fidelity = Fidelity::resolve(design, &options.fidelity, host)?;
    let worn = match options.hours {
        Some(hours) => worn_after(&machine, &fidelity, hours, host)?,
        None => WornState::uniform(options.wear_um.unwrap_or(0.0) * UM),
    };
    let forces = OutputForces { moment: options.moment_nm, axial: options.axial_n, radial: options.radial_n };
    fidelity.push_output(&machine, forces)?;
    let size = options.facet_mm * MM;
    let facets = match options.flank {
        Flank::Smooth => None,
        Flank::Faceted => Some(Facets { contact: MeshContact::Edges, size }),
        Flank::Nodes => Some(Facets { contact: MeshContact::Nodes, size }),
    };
    let model = fidelity.model(&machine, &worn, drive.value, load.value, options.drag_nm, facets)?;
    let ratio = model.ratio();
    let plan = plan(options);
    let started = host.seconds();
    let mut motion = if options.resume {
        let saved: Saved = serde_json::from_slice(&host.checkpoint()?)
            .map_err(AnalysisError::compute("read the checkpoint"))?;
        Run::resume(model, saved.checkpoint).map_err(dynamics("go on from the checkpoint"))?
    } else {
        Run::new(model, plan, host).map_err(dynamics("start the simulation"))?
    };
    let broke_off = integrate(&mut motion, plan, host)?;
    let unloaded =
        options.load == LoadKind::None && options.drag_nm == 0.0 && machine.friction.seal_drag == 0.0;
    let wants_spread = host.wants("perturbed_starts") || host.wants("report");
    let spread = if unloaded && broke_off.is_none() && options.starts > 0 && wants_spread {
        let spread = spread_over_starts(motion.model(), plan, options.starts, host);
        Some(spread.map_err(dynamics("simulate perturbed starts"))?)
    } else {
        None
    };
    Ok(Simulate {
        result: motion.result(),
        facet: facets.map(|facets| facets.size),
        wall: host.seconds() - started,
        notes,
        machine,
        fidelity,
        worn,
        plan,
        ratio,
        spread,
        broke_off,
    })
}

/// Runs to the end; why it broke off, if it did.
fn integrate(motion: &mut Run, plan: RunPlan, host: &dyn Host) -> Result<Option<String>, AnalysisError> {
    let save = |motion: &Run| {
        let bytes = serde_json::to_vec(&Saved { checkpoint: motion.checkpoint() })
            .map_err(AnalysisError::compute("write the checkpoint"))?;
        host.keep_checkpoint(&bytes)
    };
    while !motion.is_finished() {
        if host.wants_checkpoint() {
            save(motion)?;
        }
        match motion.proceed(500, host) {
            Ok(()) => {}
            Err(DynamicsError::Cancelled { time }) => {
                save(motion)?;
                return Err(AnalysisError::Interrupted { time_s: time });
            }
            Err(error) => return Ok(Some(format!("the simulation broke off: {error}"))),
        }
        host.report("simulating", motion.time() / plan.end);
    }
    Ok(None)
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

/// An error of the dynamics, which may be that it was stopped.
pub(crate) fn dynamics(task: &'static str) -> impl FnOnce(DynamicsError) -> AnalysisError {
    move |error| match error {
        DynamicsError::Cancelled { .. } => AnalysisError::Stopped,
        error => AnalysisError::compute(task)(error),
    }
}

outcome!(Simulate {
    fn failure(&self) -> Option<String> {
        self.broke_off.clone()
    }

    fn attachments(&self) -> Result<Vec<Attachment>, AnalysisError> {
        elastic_disc::attachments(&self.machine, &self.fidelity)
    }
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_those_of_the_run() {
        let options = Options::parse("", "options").unwrap();
        assert_eq!(plan(&options), RunPlan::default());
    }
}
