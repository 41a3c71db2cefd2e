//! An instance of a unit, independent of the version of the interface.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use arcmin::exchange::fmu::{Kind, MapInputs, Role, START_LOCAL_ERROR, Variable, references as r, variables};
use serde::{Deserialize, Serialize};

use crate::plant::{Outputs, Parameters, Plant, Resources, SavedPlant};

/// Status of a call; numbers as in both headers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(i32)]
pub enum Status {
    Ok = 0,
    Discard = 2,
    Error = 3,
    Fatal = 4,
}

/// State of an instance in its life cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    Instantiated,
    Initialisation,
    /// FMI 3 only: values of parameters that are not fixed; there are none, so that it has no effect.
    Configuration,
    Step,
    Terminated,
}

/// Reason why a call is refused.
#[derive(Debug)]
pub struct Refusal {
    pub status: Status,
    pub message: String,
}

impl Refusal {
    pub fn error(message: impl Into<String>) -> Refusal {
        Refusal { status: Status::Error, message: message.into() }
    }

    /// A step that cannot be computed; the state is unchanged.
    pub fn discard(message: impl Into<String>) -> Refusal {
        Refusal { status: Status::Discard, message: message.into() }
    }
}

/// Values set by the importer; a part of every saved state.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Given {
    parameters: Parameters,
    /// Whether accelerations are used if they are set.
    use_acceleration: bool,
    motor: [f64; 3],
    load_torque: [f64; 2],
    load_motion: [f64; 3],
    /// Whether the acceleration of motor and load was ever set to a value other than 0: importers write 0 to
    /// inputs without connection.
    acceleration_is_given: [bool; 2],
    /// Speeds of motor and load at the last communication point and the length of that step.
    last: Option<([f64; 2], f64)>,
}

impl Given {
    /// Sets the acceleration of the motor (0) or of the load (1).
    fn accelerate(&mut self, flange: usize, value: f64) {
        let motion = if flange == 0 { &mut self.motor } else { &mut self.load_motion };
        motion[2] = value;
        self.acceleration_is_given[flange] |= value != 0.0;
    }
}

/// A saved state of an instance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedInstance {
    token: String,
    phase: Phase,
    given: Given,
    start: f64,
    time: f64,
    outputs: Outputs,
    plant: Option<SavedPlant>,
}

type Log = Box<dyn Fn(Status, &str)>;

/// One unit of an importer; instances share no data.
pub struct Instance {
    log: Log,
    pub logging: bool,
    resources: Resources,
    variables: Vec<Variable>,
    phase: Phase,
    given: Given,
    start: f64,
    time: f64,
    plant: Option<Plant>,
    outputs: Outputs,
    /// Set after a panic: all calls are refused.
    broken: bool,
}

/// A real value, input or output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Number {
    Real(f64),
    Integer(i32),
    Boolean(bool),
}

impl Instance {
    /// Reads the resources and compares the token.
    pub fn new(token: &str, resources: &Path, logging: bool, log: Log) -> Option<Instance> {
        let read =
            catch_unwind(|| Resources::read(resources)).unwrap_or_else(|_| Err("a fault of the unit".into()));
        let resources = match read {
            Ok(resources) => resources,
            Err(message) => {
                log(Status::Error, &message);
                return None;
            }
        };
        if resources.unit.instantiation_token != token {
            log(Status::Error, "the instantiation token is not that of this unit");
            return None;
        }
        let unit = &resources.unit;
        Some(Instance {
            log,
            logging,
            variables: variables(unit.depth, unit.load_flange),
            phase: Phase::Instantiated,
            given: Instance::fresh(&resources),
            start: 0.0,
            time: 0.0,
            plant: None,
            outputs: Outputs::default(),
            broken: false,
            resources,
        })
    }

    fn fresh(resources: &Resources) -> Given {
        let unit = &resources.unit;
        Given {
            parameters: Parameters {
                hours: unit.start_hours,
                seed: unit.start_seed,
                friction: true,
                local_error: START_LOCAL_ERROR,
            },
            use_acceleration: true,
            motor: [0.0; 3],
            load_torque: [0.0; 2],
            load_motion: [0.0; 3],
            acceleration_is_given: [false; 2],
            last: None,
        }
    }

    /// Executes a call: refusals are logged, and a panic invalidates the instance instead of ending the
    /// importer.
    pub fn answer(&mut self, call: impl FnOnce(&mut Instance) -> Result<(), Refusal>) -> Status {
        if self.broken {
            return Status::Fatal;
        }
        match catch_unwind(AssertUnwindSafe(|| call(self))) {
            Ok(Ok(())) => Status::Ok,
            Ok(Err(refusal)) => {
                // Errors after which an importer can continue are logged only if logging is enabled.
                if self.logging || refusal.status >= Status::Error {
                    (self.log)(refusal.status, &refusal.message);
                }
                refusal.status
            }
            Err(_) => {
                self.broken = true;
                (self.log)(Status::Fatal, "a fault of the unit; all further calls are refused");
                Status::Fatal
            }
        }
    }

    fn expect(&self, phases: &[Phase], what: &str) -> Result<(), Refusal> {
        if phases.contains(&self.phase) {
            return Ok(());
        }
        Err(Refusal::error(format!("{what} is not allowed in the mode {:?}", self.phase)))
    }

    pub fn phase(&self) -> Phase {
        self.phase
    }

    pub fn time(&self) -> f64 {
        self.time
    }

    pub fn set_start(&mut self, start: f64) -> Result<(), Refusal> {
        self.expect(&[Phase::Instantiated, Phase::Initialisation], "setting the start time")?;
        if !start.is_finite() {
            return Err(Refusal::error("the start time is not finite"));
        }
        (self.start, self.time) = (start, start);
        Ok(())
    }

    pub fn enter_initialisation(&mut self) -> Result<(), Refusal> {
        self.expect(&[Phase::Instantiated], "entering the initialization mode")?;
        self.phase = Phase::Initialisation;
        Ok(())
    }

    pub fn exit_initialisation(&mut self) -> Result<(), Refusal> {
        self.expect(&[Phase::Initialisation], "leaving the initialization mode")?;
        self.build()?;
        self.phase = Phase::Step;
        Ok(())
    }

    /// The configuration modes have no effect: no parameter is tunable or structural.
    pub fn configure(&mut self, enter: bool) -> Result<(), Refusal> {
        if enter {
            self.expect(&[Phase::Instantiated], "the configuration mode")?;
            self.phase = Phase::Configuration;
        } else {
            self.expect(&[Phase::Configuration], "leaving the configuration mode")?;
            self.phase = Phase::Instantiated;
        }
        Ok(())
    }

    /// Creates the model at its start from the present inputs.
    fn build(&mut self) -> Result<(), Refusal> {
        let inputs = self.inputs();
        let plant = Plant::start(&self.resources, self.given.parameters, &inputs).map_err(Refusal::error)?;
        self.outputs = plant.outputs().map_err(Refusal::error)?;
        self.plant = Some(plant);
        Ok(())
    }

    pub fn terminate(&mut self) -> Result<(), Refusal> {
        self.expect(&[Phase::Step, Phase::Initialisation], "terminating")?;
        self.phase = Phase::Terminated;
        Ok(())
    }

    pub fn reset(&mut self) -> Result<(), Refusal> {
        self.phase = Phase::Instantiated;
        self.given = Instance::fresh(&self.resources);
        (self.start, self.time) = (0.0, 0.0);
        self.plant = None;
        self.outputs = Outputs::default();
        Ok(())
    }

    fn inputs(&self) -> MapInputs {
        let given = &self.given;
        let mut motions = [given.motor, given.load_motion];
        for (flange, motion) in motions.iter_mut().enumerate() {
            if !(given.use_acceleration && given.acceleration_is_given[flange]) {
                motion[2] = given.last.map_or(0.0, |(speeds, length)| (motion[1] - speeds[flange]) / length);
            }
        }
        let [motor, load_motion] = motions;
        MapInputs { motor, load_torque: given.load_torque, load_motion }
    }

    /// Computes a communication step. After a failure everything is unchanged.
    pub fn step(&mut self, from: f64, length: f64) -> Result<(), Refusal> {
        self.expect(&[Phase::Step], "a step")?;
        if !(length > 0.0 && length.is_finite() && from.is_finite()) {
            return Err(Refusal::error(format!(
                "a communication step of {length} s from {from} s is not valid"
            )));
        }
        // Importers add up their steps; the rounding error of the sum is accepted.
        if (from - self.time).abs() > 1e-9 * (1.0 + self.time.abs()) {
            return Err(Refusal::error(format!("the unit is at {} s, not at {from} s", self.time)));
        }
        let inputs = self.inputs();
        let end = from + length;
        let Some(plant) = &mut self.plant else { return Err(Refusal::error("the unit is not initialized")) };
        let before = plant.save();
        let moved = plant.advance(&inputs, end - self.start).and_then(|()| plant.outputs());
        match moved {
            Ok(outputs) => {
                self.outputs = outputs;
                self.given.last = Some(([self.given.motor[1], self.given.load_motion[1]], length));
                self.time = end;
                Ok(())
            }
            Err(message) => {
                plant.restore(&before).map_err(Refusal::error)?;
                Err(Refusal::discard(message))
            }
        }
    }

    fn variable(&self, reference: u32) -> Result<Variable, Refusal> {
        self.variables.iter().find(|variable| variable.reference == reference).copied().ok_or_else(|| {
            Refusal::error(format!("there is no variable with the value reference {reference}"))
        })
    }

    /// The value of a variable of a type.
    pub fn get(&self, reference: u32, kind: Kind) -> Result<Number, Refusal> {
        if reference == r::TIME && kind == Kind::Real {
            return Ok(Number::Real(self.time));
        }
        let variable = self.variable(reference)?;
        if variable.kind != kind {
            return Err(Refusal::error(format!("{} is of another type", variable.name)));
        }
        let (given, o) = (&self.given, &self.outputs);
        let from_outside = variable.role == Role::Input;
        Ok(Number::Real(match reference {
            r::SEED => return Ok(Number::Integer(given.parameters.seed)),
            r::FRICTION => return Ok(Number::Boolean(given.parameters.friction)),
            r::USE_ACCELERATION => return Ok(Number::Boolean(given.use_acceleration)),
            r::HOURS => given.parameters.hours,
            r::LOCAL_ERROR => given.parameters.local_error,
            r::A_PHI => given.motor[0],
            r::A_W => given.motor[1],
            r::A_A => given.motor[2],
            r::A_TAU => o.motor_torque,
            r::B_TAU if from_outside => given.load_torque[0],
            r::B_TAU => o.load_torque,
            r::B_PHI | r::B_W | r::B_A if from_outside => given.load_motion[(reference - r::B_PHI) as usize],
            r::B_PHI | r::B_W | r::B_A => o.flange[(reference - r::B_PHI) as usize],
            r::TRANSMISSION_ERROR => o.transmission_error,
            r::WIND_UP => o.wind_up,
            r::PIN_FORCE => o.pin_force,
            r::PIN_PRESSURE => o.pin_pressure,
            r::LOSS => o.loss,
            _ => o.balance,
        }))
    }

    /// Outputs in the initialization mode are those of the start with the present inputs.
    pub fn refresh(&mut self) -> Result<(), Refusal> {
        match self.phase {
            Phase::Initialisation => self.build(),
            _ => Ok(()),
        }
    }

    /// Sets an input or a parameter.
    pub fn set(&mut self, reference: u32, value: Number) -> Result<(), Refusal> {
        let variable = self.variable(reference)?;
        let kind = match value {
            Number::Real(_) => Kind::Real,
            Number::Integer(_) => Kind::Integer,
            Number::Boolean(_) => Kind::Boolean,
        };
        if variable.kind != kind {
            return Err(Refusal::error(format!("{} is of another type", variable.name)));
        }
        if matches!(value, Number::Real(value) if !value.is_finite()) {
            return Err(Refusal::error(format!("{} is not finite", variable.name)));
        }
        let early = matches!(self.phase, Phase::Instantiated | Phase::Initialisation | Phase::Configuration);
        match variable.role {
            Role::Output => return Err(Refusal::error(format!("{} is an output", variable.name))),
            Role::Parameter if !early => {
                return Err(Refusal::error(format!(
                    "{} is fixed once the unit is initialized",
                    variable.name
                )));
            }
            Role::Input if self.phase == Phase::Terminated => {
                return Err(Refusal::error("the unit is terminated"));
            }
            _ => {}
        }
        let given = &mut self.given;
        match (reference, value) {
            (r::HOURS, Number::Real(hours)) => given.parameters.hours = hours,
            (r::LOCAL_ERROR, Number::Real(error)) => given.parameters.local_error = error,
            (r::SEED, Number::Integer(seed)) if seed >= 0 => given.parameters.seed = seed,
            (r::SEED, _) => return Err(Refusal::error("a seed is not negative")),
            (r::FRICTION, Number::Boolean(friction)) => given.parameters.friction = friction,
            (r::USE_ACCELERATION, Number::Boolean(used)) => given.use_acceleration = used,
            (r::A_PHI, Number::Real(value)) => given.motor[0] = value,
            (r::A_W, Number::Real(value)) => given.motor[1] = value,
            (r::A_A, Number::Real(value)) => given.accelerate(0, value),
            (r::B_A, Number::Real(value)) => given.accelerate(1, value),
            (r::B_TAU, Number::Real(value)) => given.load_torque = [value, 0.0],
            (_, Number::Real(value)) => given.load_motion[(reference - r::B_PHI) as usize] = value,
            _ => {}
        }
        Ok(())
    }

    /// First derivative of an input with respect to time, which holds over the next step: FMI 2.
    pub fn set_derivative(&mut self, reference: u32, order: i32, value: f64) -> Result<(), Refusal> {
        let variable = self.variable(reference)?;
        if variable.role != Role::Input || variable.kind != Kind::Real {
            return Err(Refusal::error(format!("{} is no input that changes", variable.name)));
        }
        if order != 1 || !value.is_finite() {
            return Err(Refusal::error("only finite first derivatives are supported"));
        }
        let given = &mut self.given;
        match reference {
            r::A_W => given.accelerate(0, value),
            r::B_TAU => given.load_torque[1] = value,
            r::B_W => given.accelerate(1, value),
            // The derivative of an angle is its speed, that of an acceleration is not used.
            _ => {}
        }
        Ok(())
    }

    pub fn save(&self) -> SavedInstance {
        SavedInstance {
            token: self.resources.unit.instantiation_token.clone(),
            phase: self.phase,
            given: self.given,
            start: self.start,
            time: self.time,
            outputs: self.outputs,
            plant: self.plant.as_ref().map(Plant::save),
        }
    }

    /// Restores a saved state, of this instance or another one of the same unit.
    pub fn restore(&mut self, saved: &SavedInstance) -> Result<(), Refusal> {
        if saved.token != self.resources.unit.instantiation_token {
            return Err(Refusal::error("the saved state belongs to another unit"));
        }
        let same = self.given.parameters == saved.given.parameters;
        self.plant = match (&saved.plant, self.plant.take()) {
            (None, _) => None,
            (Some(state), Some(mut plant)) if same => {
                plant.restore(state).map_err(Refusal::error)?;
                Some(plant)
            }
            (Some(state), _) => {
                let with = saved.given.parameters;
                Some(Plant::resume(&self.resources, with, state).map_err(Refusal::error)?)
            }
        };
        self.phase = saved.phase;
        self.given = saved.given;
        (self.start, self.time) = (saved.start, saved.time);
        self.outputs = saved.outputs;
        Ok(())
    }
}

impl SavedInstance {
    pub fn to_bytes(&self) -> Result<Vec<u8>, Refusal> {
        postcard::to_allocvec(self)
            .map_err(|error| Refusal::error(format!("the state cannot be written: {error}")))
    }

    pub fn from_bytes(bytes: &[u8]) -> Result<SavedInstance, Refusal> {
        postcard::from_bytes(bytes).map_err(|_| Refusal::error("these bytes are no saved state"))
    }
}
