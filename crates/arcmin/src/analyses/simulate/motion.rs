//! A run in time of a drive of any family: drive, load, integration and recording.

use serde::{Deserialize, Serialize};

use crate::analyses::{AnalysisError, Host};
use crate::design::{Choice, InputFile, default, default_word, optional, options};
use crate::dynamics::{
    Checkpoint, DynamicsError, Model, Reducer, Run, RunPlan, RunResult, StartSpread, StepControl,
    spread_over_starts,
};

options! {
    /// Drive and load, and the integration of the motion.
    pub struct MotionOptions {
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

/// A run.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Length, window and intervals.
    pub plan: RunPlan,
    /// Series, statistics and energy.
    pub result: RunResult,
    /// Turns of the input for one turn of the output; negative if they turn in opposite directions.
    pub ratio: f64,
    /// Spread over perturbed starts of an unloaded drive without drag.
    pub spread: Option<StartSpread>,
    /// Reason if the run was interrupted; the results until then are kept.
    pub broke_off: Option<String>,
    /// Seconds of the computation, if the host has a clock.
    pub wall: f64,
    /// Notes about the files of drive and load.
    pub notes: Vec<String>,
}

/// Results that have a run.
pub(crate) trait HasMotion {
    fn motion(&self) -> &Motion;
}

/// Contents of a checkpoint.
#[derive(Serialize, Deserialize)]
struct Saved {
    checkpoint: Checkpoint,
}

/// Integrates the motion of a model with its drive and load; `own_drag` (N·m) acts on the output in addition to the
/// drag of the options.
///
/// # Errors
/// As [`simulate`](super::run).
pub(crate) fn run(
    model: impl Into<Model>,
    options: &MotionOptions,
    own_drag: f64,
    notes: Vec<String>,
    host: &dyn Host,
) -> Result<Motion, AnalysisError> {
    let model = model.into();
    let (ratio, plan, started) = (model.ratio(), plan(options), host.seconds());
    let mut motion = if options.resume {
        let saved: Saved = serde_json::from_slice(&host.checkpoint()?)
            .map_err(AnalysisError::compute("read the checkpoint"))?;
        Run::resume(model, saved.checkpoint).map_err(dynamics("go on from the checkpoint"))?
    } else {
        Run::new(model, plan, host).map_err(dynamics("start the simulation"))?
    };
    let broke_off = integrate(&mut motion, plan, host)?;
    let unloaded = options.load == LoadKind::None && options.drag_nm == 0.0 && own_drag == 0.0;
    let needs_spread = host.needs("perturbed_starts") || host.needs("report");
    let spread = if unloaded && broke_off.is_none() && options.starts > 0 && needs_spread {
        let spread = spread_over_starts(motion.model(), plan, options.starts, host);
        Some(spread.map_err(dynamics("simulate perturbed starts"))?)
    } else {
        None
    };
    Ok(Motion {
        result: motion.result(),
        wall: host.seconds() - started,
        notes,
        plan,
        ratio,
        spread,
        broke_off,
    })
}

/// Runs to the end; returns the reason if the run was interrupted.
fn integrate(motion: &mut Run, plan: RunPlan, host: &dyn Host) -> Result<Option<String>, AnalysisError> {
    let save = |motion: &Run| {
        let bytes = serde_json::to_vec(&Saved { checkpoint: motion.checkpoint() })
            .map_err(AnalysisError::compute("write the checkpoint"))?;
        host.keep_checkpoint(&bytes)
    };
    while !motion.is_finished() {
        if host.checkpoint_is_due() {
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

fn plan(options: &MotionOptions) -> RunPlan {
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

/// An error of the dynamics, possibly that the run was stopped.
pub(crate) fn dynamics(task: &'static str) -> impl FnOnce(DynamicsError) -> AnalysisError {
    move |error| match error {
        DynamicsError::Cancelled { .. } => AnalysisError::Stopped,
        error => AnalysisError::compute(task)(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_those_of_the_run() {
        let options = MotionOptions::parse("", "options").unwrap();
        assert_eq!(plan(&options), RunPlan::default());
    }
}
