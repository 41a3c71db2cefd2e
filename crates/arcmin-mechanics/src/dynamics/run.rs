use serde::{Deserialize, Serialize};

use super::simulation::{Instant, Simulation, SimulationState};
use super::spectrum::{SpectrumLine, order_spectrum};
use super::statistics::{ErrorIntegrals, ErrorStatistics};
use super::{DynamicsError, EnergyAccount, ForceSummary, Model, Reducer, StepControl, StepCounts};
use crate::progress::Progress;

/// Plan of a run: length, window of the statistics, intervals of the series.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RunPlan {
    /// Length of the run in s.
    pub end: f64,
    /// Beginning of the window of the statistics, in s.
    pub window_start: f64,
    /// Interval of the time series in s.
    pub sample_interval: f64,
    /// Interval of the force series in s.
    pub force_interval: f64,
    /// Tolerances and limits of the step size.
    pub control: StepControl,
}

impl Default for RunPlan {
    /// The run of Tao2024: 0.8 s, with acceleration in the first 0.1 s.
    fn default() -> Self {
        RunPlan {
            end: 0.8,
            window_start: 0.1,
            sample_interval: 2e-4,
            force_interval: 1e-3,
            control: StepControl::default(),
        }
    }
}

impl RunPlan {
    fn validate(&self) -> Result<(), DynamicsError> {
        let check = DynamicsError::require;
        check(self.end > 0.0 && self.end.is_finite(), "end time", self.end, "s", "must be positive")?;
        check(
            self.window_start >= 0.0,
            "start of the window",
            self.window_start,
            "s",
            "must not be negative",
        )?;
        check(self.sample_interval > 0.0, "sample interval", self.sample_interval, "s", "must be positive")?;
        check(
            self.end / self.sample_interval < 1e8,
            "sample interval",
            self.sample_interval,
            "s",
            "would give more than 1e8 samples",
        )?;
        check(
            self.force_interval >= self.sample_interval,
            "force interval",
            self.force_interval,
            "s",
            "must not be below the sample interval",
        )?;
        self.control.validate()
    }
}

/// One row of the time series.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Time, s.
    pub time: f64,
    /// Input speed, rad/s.
    pub input_speed: f64,
    /// Output speed, rad/s.
    pub output_speed: f64,
    /// Load torque, N·m.
    pub load: f64,
    /// θ_out − θ_s/i in rad.
    pub transmission_error: f64,
    /// Input angle in rad.
    pub input_angle: f64,
}

/// One row of the force series.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ForceSample {
    /// s.
    pub time: f64,
    /// Largest and summed forces at that time.
    pub forces: ForceSummary,
}

/// Results of the run so far.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
struct Record {
    series: Vec<Sample>,
    forces: Vec<ForceSample>,
    integrals: ErrorIntegrals,
    /// Angles (input, output) at the first step inside the window, for the mean ratio.
    window_angles: Option<(f64, f64)>,
}

/// State of the simulation and results so far, from which a run can be continued.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    plan: RunPlan,
    state: SimulationState,
    record: Record,
}

impl Checkpoint {
    /// Time reached, in s.
    pub fn time(&self) -> f64 {
        self.state.time()
    }

    /// Plan that the run was begun with.
    pub fn plan(&self) -> &RunPlan {
        &self.plan
    }
}

/// Results of a run, or of the part computed so far.
#[derive(Debug, Clone, PartialEq)]
pub struct RunResult {
    /// Time series at the interval of the plan.
    pub series: Vec<Sample>,
    /// Force series at its interval.
    pub forces: Vec<ForceSample>,
    /// Statistics over the window; `None` if the run ended before it.
    pub statistics: Option<ErrorStatistics>,
    /// Spectrum in orders of the output rotation; `None` if the window covers less than one turn.
    pub spectrum: Option<Vec<SpectrumLine>>,
    /// Ratio of the changes of θ_s and θ_out over the window.
    pub mean_ratio: Option<f64>,
    /// Work and energy of the whole run.
    pub energy: EnergyAccount,
    /// Steps and evaluations of the whole run.
    pub counts: StepCounts,
    /// Time reached in s.
    pub reached: f64,
}

/// A simulation with recording of results: time series, statistics, spectrum.
#[derive(Debug, Clone)]
pub struct Run {
    plan: RunPlan,
    simulation: Simulation,
    record: Record,
    /// State within the last step, for samples.
    instant: Instant,
}

impl Run {
    /// A run from rest in static equilibrium with the load at time 0.
    ///
    /// # Errors
    /// Values without meaning in the plan, no equilibrium, or [`DynamicsError::Cancelled`].
    pub fn new(
        model: impl Into<Model>,
        plan: RunPlan,
        progress: &dyn Progress,
    ) -> Result<Run, DynamicsError> {
        plan.validate()?;
        Ok(Run::of(Simulation::from_rest(model, plan.control, progress)?, plan))
    }

    /// A run from given coordinates (m, rad) and velocities at time 0.
    ///
    /// # Errors
    /// Values without meaning in the plan.
    pub fn from_state(
        model: impl Into<Model>,
        plan: RunPlan,
        position: &[f64],
        velocity: &[f64],
    ) -> Result<Run, DynamicsError> {
        plan.validate()?;
        Ok(Run::of(Simulation::from_state(model, plan.control, position, velocity)?, plan))
    }

    fn of(simulation: Simulation, plan: RunPlan) -> Run {
        let instant = Instant::of(simulation.integrator().current());
        let mut run = Run { plan, simulation, record: Record::default(), instant };
        run.write_samples();
        run
    }

    /// Continues from a checkpoint, identically to the bit to an uninterrupted run.
    ///
    /// # Errors
    /// [`DynamicsError::ForeignCheckpoint`] if the checkpoint does not fit the model.
    pub fn resume(model: impl Into<Model>, checkpoint: Checkpoint) -> Result<Run, DynamicsError> {
        let Checkpoint { plan, state, record } = checkpoint;
        plan.validate()?;
        let simulation = Simulation::resume(model, &state)?;
        let instant = Instant::of(simulation.integrator().current());
        Ok(Run { plan, simulation, record, instant })
    }

    /// Checkpoint from which the run can be continued identically to the bit.
    pub fn checkpoint(&self) -> Checkpoint {
        Checkpoint { plan: self.plan, state: self.simulation.save(), record: self.record.clone() }
    }

    /// Equations of motion with their drive and load.
    pub fn model(&self) -> &Model {
        self.simulation.model()
    }

    /// Time reached in s.
    pub fn time(&self) -> f64 {
        self.simulation.time()
    }

    /// Whether the end of the plan is reached.
    pub fn is_finished(&self) -> bool {
        self.time() >= self.plan.end
    }

    /// Takes up to `steps` steps; `progress` is polled for cancellation before each.
    ///
    /// # Errors
    /// [`DynamicsError::StepFailed`] or [`DynamicsError::Cancelled`]; the results so far remain available, and
    /// the run can be continued.
    pub fn proceed(&mut self, steps: usize, progress: &dyn Progress) -> Result<(), DynamicsError> {
        for _ in 0..steps {
            if self.is_finished() {
                break;
            }
            if progress.is_cancelled() {
                return Err(DynamicsError::Cancelled { time: self.time() });
            }
            self.simulation.step(self.plan.end)?;
            self.write_step();
        }
        Ok(())
    }

    /// Runs to the end.
    ///
    /// # Errors
    /// As [`Run::proceed`].
    pub fn finish(&mut self, progress: &dyn Progress) -> Result<(), DynamicsError> {
        while !self.is_finished() {
            self.proceed(10_000, progress)?;
        }
        Ok(())
    }

    /// Interpolates the state within the last step.
    fn interpolate(&mut self, time: f64) {
        self.instant.time = time;
        let integrator = self.simulation.integrator();
        self.instant.set(integrator.previous(), integrator.current());
    }

    fn error_at(&mut self, time: f64) -> f64 {
        self.interpolate(time);
        let Instant { position, velocity, .. } = &self.instant;
        self.model().transmission_error(time, position, velocity)
    }

    fn write_step(&mut self) {
        let integrator = self.simulation.integrator();
        let (start, end) = (integrator.previous().time, integrator.current().time);
        if end > self.plan.window_start && end > start {
            let from = start.max(self.plan.window_start);
            let values = [self.error_at(from), self.error_at(0.5 * (from + end)), self.error_at(end)];
            self.record.integrals.add(end - from, values);
            if self.record.window_angles.is_none() {
                self.interpolate(from);
                let (model, Instant { position, velocity, .. }) = (self.model(), &self.instant);
                let input = model.input(from, position, velocity).0;
                self.record.window_angles = Some((input, model.output(position, velocity).0));
            }
        }
        self.write_samples();
    }

    fn write_samples(&mut self) {
        let end = self.simulation.integrator().current().time;
        loop {
            let time = self.record.series.len() as f64 * self.plan.sample_interval;
            if time > end {
                break;
            }
            self.interpolate(time);
            let (model, Instant { position, velocity, .. }) = (self.model(), &self.instant);
            let (input_angle, input_speed) = model.input(time, position, velocity);
            let (output_angle, output_speed) = model.output(position, velocity);
            let sample = Sample {
                time,
                input_speed,
                output_speed,
                load: model.load_torque(time),
                transmission_error: output_angle - input_angle / model.ratio(),
                input_angle,
            };
            self.record.series.push(sample);
        }
        loop {
            let time = self.record.forces.len() as f64 * self.plan.force_interval;
            if time > end {
                break;
            }
            self.interpolate(time);
            let Instant { position, velocity, .. } = &self.instant;
            let forces = self.model().forces(time, position, velocity);
            self.record.forces.push(ForceSample { time, forces });
        }
    }

    /// Results computed so far.
    pub fn result(&self) -> RunResult {
        let (model, state) = (self.model(), self.simulation.integrator().state());
        let window: Vec<(f64, f64)> = self
            .record
            .series
            .iter()
            .filter(|sample| sample.time >= self.plan.window_start)
            .map(|sample| (sample.input_angle / model.ratio(), sample.transmission_error))
            .collect();
        let current = &state.current;
        let mean_ratio = self.record.window_angles.map(|(input, output)| {
            let input_now = model.input(current.time, &current.position, &current.velocity).0;
            (input_now - input) / (model.output(&current.position, &current.velocity).0 - output)
        });
        RunResult {
            series: self.record.series.clone(),
            forces: self.record.forces.clone(),
            statistics: self.record.integrals.statistics(),
            spectrum: order_spectrum(&window),
            mean_ratio: mean_ratio.filter(|ratio| ratio.is_finite()),
            energy: state.energy,
            counts: state.counts,
            reached: current.time,
        }
    }
}
