use serde::{Deserialize, Serialize};

use super::integrator::hermite;
use super::spectrum::{SpectrumLine, order_spectrum};
use super::statistics::{ErrorIntegrals, ErrorStatistics};
use super::{
    DynamicsError, EnergyAccount, ForceSummary, Integrator, IntegratorState, Reducer, StepControl, StepCounts,
};

/// What to compute and what to write down.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RunPlan {
    /// Length of the run in s.
    pub end: f64,
    /// Statistics are taken from this time on, in s.
    pub window_start: f64,
    /// Interval of the time series in s.
    pub sample_interval: f64,
    /// Interval of the force series in s.
    pub force_interval: f64,
    pub control: StepControl,
}

impl Default for RunPlan {
    /// The run of Tao2024: 0.8 s, of which the first 0.1 s brings the machine up to speed.
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
    /// s.
    pub time: f64,
    /// rad/s.
    pub input_speed: f64,
    /// rad/s.
    pub output_speed: f64,
    /// N·m.
    pub load: f64,
    /// θ_out − θ_s/i in rad.
    pub transmission_error: f64,
    /// Turn of the input in rad.
    pub input_angle: f64,
}

/// One row of the force series.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ForceSample {
    /// s.
    pub time: f64,
    pub forces: ForceSummary,
}

/// What has been written down so far.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
struct Record {
    series: Vec<Sample>,
    forces: Vec<ForceSample>,
    integrals: ErrorIntegrals,
    /// Angles (input, output) at the first step inside the window, for the mean ratio.
    window_angles: Option<(f64, f64)>,
}

/// Everything needed to go on with a run: state of the integrator and what was written down.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    plan: RunPlan,
    state: IntegratorState,
    record: Record,
}

impl Checkpoint {
    /// Time reached, in s.
    pub fn time(&self) -> f64 {
        self.state.current.time
    }

    pub fn plan(&self) -> &RunPlan {
        &self.plan
    }
}

/// Outcome of a run, or of what was computed of it.
#[derive(Debug, Clone, PartialEq)]
pub struct RunResult {
    pub series: Vec<Sample>,
    pub forces: Vec<ForceSample>,
    /// Over the window; `None` if the run ended before it.
    pub statistics: Option<ErrorStatistics>,
    /// In orders of the output turn; `None` if the window covers less than one turn.
    pub spectrum: Option<Vec<SpectrumLine>>,
    /// (θ_s change)/(θ_out change) over the window.
    pub mean_ratio: Option<f64>,
    pub energy: EnergyAccount,
    pub counts: StepCounts,
    /// Time reached in s.
    pub reached: f64,
}

/// A run in progress.
pub struct Run<'m, M: Reducer> {
    model: &'m M,
    plan: RunPlan,
    integrator: Integrator<'m, M>,
    record: Record,
    position: Vec<f64>,
    velocity: Vec<f64>,
}

impl<'m, M: Reducer> Run<'m, M> {
    /// A run from rest in static equilibrium with the load at time 0.
    ///
    /// # Errors
    /// Values without meaning in the plan, or no equilibrium.
    pub fn new(model: &'m M, plan: RunPlan) -> Result<Self, DynamicsError> {
        plan.validate()?;
        let rest = model.rest_position()?;
        Run::from_state(model, plan, &rest, &vec![0.0; rest.len()])
    }

    /// A run from a given state at time 0.
    ///
    /// # Errors
    /// Values without meaning in the plan.
    pub fn from_state(
        model: &'m M,
        plan: RunPlan,
        position: &[f64],
        velocity: &[f64],
    ) -> Result<Self, DynamicsError> {
        plan.validate()?;
        let integrator = Integrator::new(model, plan.control, 0.0, position, velocity)?;
        let n = position.len();
        let mut run = Run {
            model,
            plan,
            integrator,
            record: Record::default(),
            position: vec![0.0; n],
            velocity: vec![0.0; n],
        };
        run.write_samples();
        Ok(run)
    }

    /// Goes on from a checkpoint, bit by bit as if there had been no break.
    ///
    /// # Errors
    /// [`DynamicsError::ForeignCheckpoint`] if the checkpoint does not fit the model.
    pub fn resume(model: &'m M, checkpoint: Checkpoint) -> Result<Self, DynamicsError> {
        let Checkpoint { plan, state, record } = checkpoint;
        plan.validate()?;
        let integrator = Integrator::resume(model, plan.control, state)?;
        let n = model.size();
        Ok(Run { model, plan, integrator, record, position: vec![0.0; n], velocity: vec![0.0; n] })
    }

    pub fn checkpoint(&self) -> Checkpoint {
        Checkpoint { plan: self.plan, state: self.integrator.state().clone(), record: self.record.clone() }
    }

    /// Time reached in s.
    pub fn time(&self) -> f64 {
        self.integrator.time()
    }

    pub fn is_finished(&self) -> bool {
        self.time() >= self.plan.end
    }

    /// Takes up to `steps` steps.
    ///
    /// # Errors
    /// [`DynamicsError::StepFailed`]; what was computed so far stays available.
    pub fn proceed(&mut self, steps: usize) -> Result<(), DynamicsError> {
        for _ in 0..steps {
            if self.is_finished() {
                break;
            }
            self.integrator.advance(self.plan.end)?;
            self.write_step();
        }
        Ok(())
    }

    /// Runs to the end.
    ///
    /// # Errors
    /// As [`Run::proceed`].
    pub fn finish(&mut self) -> Result<(), DynamicsError> {
        while !self.is_finished() {
            self.proceed(10_000)?;
        }
        Ok(())
    }

    /// State inside the last step.
    fn interpolate(&mut self, time: f64) {
        let (old, new) = (self.integrator.previous(), self.integrator.current());
        let h = new.time - old.time;
        if h <= 0.0 {
            self.position.copy_from_slice(&new.position);
            self.velocity.copy_from_slice(&new.velocity);
            return;
        }
        let x = (time - old.time) / h;
        for i in 0..self.position.len() {
            (self.position[i], self.velocity[i]) =
                hermite(h, x, old.position[i], new.position[i], old.velocity[i], new.velocity[i]);
        }
    }

    fn error_at(&mut self, time: f64) -> f64 {
        self.interpolate(time);
        self.model.transmission_error(time, &self.position, &self.velocity)
    }

    fn write_step(&mut self) {
        let (start, end) = (self.integrator.previous().time, self.integrator.current().time);
        if end > self.plan.window_start && end > start {
            let from = start.max(self.plan.window_start);
            let values = [self.error_at(from), self.error_at(0.5 * (from + end)), self.error_at(end)];
            self.record.integrals.add(end - from, values);
            if self.record.window_angles.is_none() {
                self.interpolate(from);
                let input = self.model.input(from, &self.position, &self.velocity).0;
                self.record.window_angles =
                    Some((input, self.model.output(&self.position, &self.velocity).0));
            }
        }
        self.write_samples();
    }

    fn write_samples(&mut self) {
        let end = self.integrator.current().time;
        loop {
            let time = self.record.series.len() as f64 * self.plan.sample_interval;
            if time > end {
                break;
            }
            self.interpolate(time);
            let (input_angle, input_speed) = self.model.input(time, &self.position, &self.velocity);
            let (output_angle, output_speed) = self.model.output(&self.position, &self.velocity);
            self.record.series.push(Sample {
                time,
                input_speed,
                output_speed,
                load: self.model.load_torque(time),
                transmission_error: output_angle - input_angle / self.model.ratio(),
                input_angle,
            });
        }
        loop {
            let time = self.record.forces.len() as f64 * self.plan.force_interval;
            if time > end {
                break;
            }
            self.interpolate(time);
            self.record
                .forces
                .push(ForceSample { time, forces: self.model.forces(time, &self.position, &self.velocity) });
        }
    }

    /// Results of what was computed so far.
    pub fn result(&self) -> RunResult {
        let state = self.integrator.state();
        let window: Vec<(f64, f64)> = self
            .record
            .series
            .iter()
            .filter(|sample| sample.time >= self.plan.window_start)
            .map(|sample| (sample.input_angle / self.model.ratio(), sample.transmission_error))
            .collect();
        let current = &state.current;
        let mean_ratio = self.record.window_angles.map(|(input, output)| {
            let input_now = self.model.input(current.time, &current.position, &current.velocity).0;
            (input_now - input) / (self.model.output(&current.position, &current.velocity).0 - output)
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
