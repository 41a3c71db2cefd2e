mod inputs;
mod saved;

pub use saved::SimulationState;

use serde::{Deserialize, Serialize};

use super::integrator::hermite;
use super::{
    Balance, Drive, DynamicsError, EnergyAccount, ForceSummary, Integrator, IntegratorState, Model, Node,
    OutputLoad, Reducer, StepControl, StepCounts, System, continue_from_larger_loads,
};
use crate::progress::Progress;

/// A machine in motion that owns its model and has inputs from outside.
///
/// Inputs are values: motor angle, speed or torque ([`Simulation::set_motor`]), torque or motion of the output
/// ([`Simulation::set_load`]). They are valid from the present time until they are set again; functions of time
/// ([`Drive`], [`OutputLoad`]) with which the model was built remain in effect. [`Simulation::advance_to`] uses
/// adaptive steps of its own. The last step may end beyond the requested time; results there are interpolated
/// by the cubic through both ends. When an input changes, the machine returns to the state before that step.
/// Results are therefore independent, bit by bit, of the times at which they are requested.
///
/// ```
/// # extern crate arcmin_mechanics as arcmin;
/// use arcmin::dynamics::*;
/// use arcmin::progress::Silent;
/// # fn main() -> Result<(), DynamicsError> {
/// let machine = arcmin::templates::tao2024();
/// let drive = Drive::GivenMotion(GivenMotion::default());
/// let load = OutputLoad::GivenTorque(GivenTorque::constant(100.0));
/// let wear = arcmin::geometry::Relief::uniform(10e-6);
/// let model = IdealJoints::new(&machine, &wear, drive, load, 5.0)?;
/// let mut simulation = Simulation::from_rest(model, StepControl::default(), &Silent)?;
/// simulation.set_motor(MotorInput::Speed { speed: 0.0, acceleration: 1500.0 })?;
/// simulation.advance_to(0.01, &Silent)?;
/// simulation.set_load(LoadInput::Torque { torque: 412.0, rate: 0.0 })?;
/// simulation.advance_to(0.02, &Silent)?;
/// assert!((simulation.outputs()?.input_speed - 30.0).abs() < 1e-9);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Simulation {
    integrator: Integrator<Model>,
    /// Requested time; the integrator may be beyond it by less than its last step.
    time: f64,
    /// State at the beginning of that step.
    before: Option<IntegratorState>,
}

/// State of the machine at one instant. Angles and torques are counter-clockwise positive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Outputs {
    /// s.
    pub time: f64,
    /// Angle of the input in rad: the sun, or the motor behind an elastic shaft.
    pub input_angle: f64,
    /// rad/s.
    pub input_speed: f64,
    /// Output angle, rad.
    pub output_angle: f64,
    /// Output speed, rad/s.
    pub output_speed: f64,
    /// θ_out − θ_in/i in rad; negative where the output lags behind a positive motion.
    pub transmission_error: f64,
    /// θ_in − i θ_out in rad: the twist between the flanges referred to the motor, by clearances and elastic
    /// deformation.
    pub wind_up: f64,
    /// Torque of the motor at the input flange, N·m.
    pub input_torque: f64,
    /// Torque transmitted by the output flange, N·m; positive against positive motion. If the motion of the
    /// output is prescribed, it is the torque absorbed from outside, including that of the output's own
    /// inertia.
    pub output_torque: f64,
    /// Pins, pressures and meshes.
    pub forces: ForceSummary,
    /// Powers in W and elastic energy in J.
    pub balance: Balance,
    /// Kinetic energy in J.
    pub kinetic_energy: f64,
    /// Energy supplied, delivered and dissipated since the start, in J.
    pub energy: EnergyAccount,
}

/// Largest |transmission error| in rad for a start with both flanges prescribed: with a larger one the pins
/// would be in other tooth spaces.
const LARGEST_START_ERROR: f64 = 0.02;

impl Simulation {
    /// Starts at time 0 from rest, in static equilibrium with the load. Prescribed motions count as at rest
    /// until then.
    ///
    /// # Errors
    /// Values without meaning in the control, no equilibrium, or [`DynamicsError::Cancelled`].
    pub fn from_rest(
        model: impl Into<Model>,
        control: StepControl,
        progress: &dyn Progress,
    ) -> Result<Simulation, DynamicsError> {
        let mut model: Model = model.into();
        control.validate()?;
        let (drive, load) = (model.drive().cloned(), model.output_load().clone());
        if let Some(Drive::GivenMotion(motion)) = &drive {
            model.set_drive(Drive::GivenMotion(motion.stopped()));
        }
        if let Some(motion) = load.motion() {
            model.set_output_load(OutputLoad::GivenMotion(motion.stopped()));
            if let (None, Some(Drive::GivenMotion(input))) = (model.free_input(), &drive) {
                let error = motion.at(0.0).0 - input.at(0.0).0 / model.ratio();
                DynamicsError::require(
                    error.abs() < LARGEST_START_ERROR,
                    "difference between output angle and input angle over the ratio",
                    error,
                    "rad",
                    "must be small: the teeth are in mesh",
                )?;
            }
        }
        let torque = load.torque(0.0);
        let rest = match model.rest_position(None, progress) {
            Err(DynamicsError::NoEquilibrium { .. }) if load.motion().is_none() => {
                continue_from_larger_loads(torque, torque.abs(), |torque, near| {
                    model.set_output_load(OutputLoad::Constant { torque });
                    model.rest_position(near, progress)
                })?
            }
            found => found?,
        };
        drive.into_iter().for_each(|drive| model.set_drive(drive));
        model.set_output_load(load);
        let mut velocity = vec![0.0; rest.len()];
        if let Some(motion) = model.output_load().motion() {
            velocity[model.output_index()] = motion.at(0.0).1;
        }
        Simulation::from_state(model, control, &rest, &velocity)
    }

    /// Starts at time 0 from given coordinates (m, rad) and velocities.
    ///
    /// # Errors
    /// Values without meaning in the control, or a state with forces that are not finite.
    pub fn from_state(
        model: impl Into<Model>,
        control: StepControl,
        position: &[f64],
        velocity: &[f64],
    ) -> Result<Simulation, DynamicsError> {
        let integrator = Integrator::new(model.into(), control, 0.0, position, velocity)?;
        Ok(Simulation { integrator, time: 0.0, before: None })
    }

    /// Time reached in s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Equations of motion with their drive and load.
    pub fn model(&self) -> &Model {
        self.integrator.system()
    }

    /// Counts of the time integration.
    pub fn counts(&self) -> StepCounts {
        self.integrator.state().counts
    }

    pub(super) fn integrator(&self) -> &Integrator<Model> {
        &self.integrator
    }

    /// Advances to `time` (s). `progress` is polled for cancellation before every step.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for a time in the past, [`DynamicsError::StepFailed`], or
    /// [`DynamicsError::Cancelled`]; the state remains that of the last accepted step, from which the
    /// simulation can continue.
    pub fn advance_to(&mut self, time: f64, progress: &dyn Progress) -> Result<(), DynamicsError> {
        DynamicsError::require(
            time >= self.time && time.is_finite(),
            "time to reach",
            time,
            "s",
            "must not lie in the past",
        )?;
        while self.integrator.time() < time {
            if progress.is_cancelled() {
                self.time = self.time.max(self.integrator.time());
                return Err(DynamicsError::Cancelled { time: self.time });
            }
            match &mut self.before {
                Some(before) => before.copy_from(self.integrator.state()),
                None => self.before = Some(self.integrator.state().clone()),
            }
            if let Err(error) = self.integrator.advance(f64::INFINITY) {
                self.time = self.time.max(self.integrator.time());
                return Err(error);
            }
        }
        self.time = time;
        Ok(())
    }

    /// One step of the integrator that ends at `until` (s) or before.
    pub(super) fn step(&mut self, until: f64) -> Result<(), DynamicsError> {
        self.integrator.advance(until)?;
        self.time = self.integrator.time();
        self.before = None;
        Ok(())
    }

    /// Returns the integrator to the present time if its last step ended beyond it.
    fn return_to_present(&mut self) -> Result<(), DynamicsError> {
        if let Some(before) = self.before.take()
            && self.integrator.time() > self.time
        {
            self.integrator.set_state(&before)?;
            while self.integrator.time() < self.time {
                self.integrator.advance(self.time)?;
            }
        }
        Ok(())
    }

    /// State at the present time, interpolated within the last step.
    fn node(&self) -> Instant {
        let (old, new) = (self.integrator.previous(), self.integrator.current());
        let mut instant = Instant::of(new);
        if self.time != new.time {
            instant.time = self.time;
            instant.set(old, new);
        }
        instant
    }

    /// State of the machine at the present time.
    ///
    /// # Errors
    /// [`DynamicsError::StepFailed`] for forces that are not finite.
    pub fn outputs(&self) -> Result<Outputs, DynamicsError> {
        let model = self.model();
        let Instant { time, position, velocity } = self.node();
        let mut force = vec![0.0; position.len()];
        let balance = model.evaluate(time, &position, &velocity, &mut force, &mut model.linearisation());
        let (input_angle, input_speed) = model.input(time, &position, &velocity);
        let (output_angle, output_speed) = model.output(&position, &velocity);
        let kinetic_energy = velocity.iter().zip(model.mass()).map(|(v, m)| 0.5 * m * v * v).sum::<f64>();
        let mut energy = self.integrator.state().energy;
        if let Some(before) = self.before.as_ref().filter(|_| self.integrator.time() > time) {
            energy = before.energy;
            let (old, new) = (&before.current, self.integrator.current());
            let (h, x) = (new.time - old.time, time - old.time);
            // As in the integrator, powers are linear within a step.
            let part = |f: fn(&Balance) -> f64| {
                x * (f(&old.balance) + 0.5 * (x / h) * (f(&new.balance) - f(&old.balance)))
            };
            energy.input += part(|balance| balance.input_power);
            energy.load += part(|balance| balance.load_power);
            energy.dissipated += part(|balance| balance.dissipation);
            energy.turnover +=
                part(|balance| balance.input_power.abs() + balance.load_power.abs() + balance.dissipation);
            energy.current = kinetic_energy + balance.stored;
        }
        Ok(Outputs {
            time,
            input_angle,
            input_speed,
            output_angle,
            output_speed,
            transmission_error: output_angle - input_angle / model.ratio(),
            wind_up: input_angle - model.ratio() * output_angle,
            input_torque: balance.input_torque,
            output_torque: balance.load_torque,
            forces: model.forces(time, &position, &velocity),
            balance,
            kinetic_energy,
            energy,
        })
    }
}

/// Coordinates and velocities at one time.
#[derive(Debug, Clone)]
pub(super) struct Instant {
    pub time: f64,
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
}

impl Instant {
    /// The state at one end of a step.
    pub fn of(node: &Node) -> Instant {
        Instant { time: node.time, position: node.position.clone(), velocity: node.velocity.clone() }
    }

    /// Interpolates the state at its time between the two ends of a step by Hermite's cubic.
    pub fn set(&mut self, old: &Node, new: &Node) {
        let h = new.time - old.time;
        if h <= 0.0 {
            self.position.copy_from_slice(&new.position);
            self.velocity.copy_from_slice(&new.velocity);
            return;
        }
        let x = (self.time - old.time) / h;
        for i in 0..self.position.len() {
            (self.position[i], self.velocity[i]) =
                hermite(h, x, old.position[i], new.position[i], old.velocity[i], new.velocity[i]);
        }
    }

    fn output(&self, model: &Model) -> (f64, f64) {
        model.output(&self.position, &self.velocity)
    }
}

#[cfg(test)]
mod tests;
