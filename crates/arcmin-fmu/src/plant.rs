//! Contents of a unit: the map, or the multibody model.

use std::path::{Path, PathBuf};

use arcmin::analyses::multibody::Driven;
use arcmin::analyses::stage::AnyDesign;
use arcmin::analyses::{AnalysisError, Host, Origin};
use arcmin::design::InputFile;
use arcmin::dynamics::{
    Drive, GivenMotion, GivenTorque, LoadInput, Model, MotorInput, OutputLoad, Simulation, SimulationState,
    StepControl,
};
use arcmin::exchange::fmu::{Depth, LoadFlange, MapInputs, MapModel, MapState, UnitData};
use arcmin::fidelity::FidelityOptions;
use arcmin::progress::{Progress, Silent};
use arcmin::units::ARCMIN;
use serde::{Deserialize, Serialize};

/// Parameters of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    pub hours: f64,
    pub seed: i32,
    pub friction: bool,
    /// Local error of a step at the output in rad; multibody units only.
    pub local_error: f64,
}

/// External inputs.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Outputs {
    pub motor_torque: f64,
    pub load_torque: f64,
    pub flange: [f64; 3],
    pub transmission_error: f64,
    pub wind_up: f64,
    pub pin_force: f64,
    pub pin_pressure: f64,
    pub loss: f64,
    pub balance: f64,
}

/// Content of a unit's resources.
#[derive(Debug, Clone)]
pub struct Resources {
    pub unit: UnitData,
    design: AnyDesign,
    directory: PathBuf,
}

impl Resources {
    /// Reads `unit.json` and `design.toml`.
    pub fn read(directory: &Path) -> Result<Resources, String> {
        let text = |name: &str| {
            let path = directory.join(name);
            std::fs::read_to_string(&path).map_err(|cause| format!("cannot read {}: {cause}", path.display()))
        };
        let unit =
            serde_json::from_str(&text("unit.json")?).map_err(|cause| format!("unit.json: {cause}"))?;
        let design =
            AnyDesign::parse(&text("design.toml")?, "design.toml").map_err(|error| error.to_string())?;
        Ok(Resources { unit, design, directory: directory.to_owned() })
    }
}

/// Files named in the design are in the resources.
struct InResources<'a>(&'a Path);

impl Progress for InResources<'_> {
    fn report(&self, stage: &str, share: f64) {
        Silent.report(stage, share);
    }

    fn is_cancelled(&self) -> bool {
        false
    }
}

impl Host for InResources<'_> {
    fn read(&self, file: &InputFile, _: Origin) -> Result<Vec<u8>, AnalysisError> {
        std::fs::read(self.0.join(&file.0)).map_err(|cause| AnalysisError::Input {
            file: file.0.clone(),
            line: None,
            message: format!("cannot be read from the unit's resources: {cause}"),
            help: "export the unit again".to_owned(),
        })
    }
}

/// The running model. The multibody model uses the time since its own start.
#[derive(Debug, Clone)]
pub enum Plant {
    Map { model: Box<MapModel>, state: MapState },
    Multibody { simulation: Box<Simulation>, load: LoadFlange, acceleration: f64 },
}

/// A saved state of a plant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum SavedPlant {
    Map(MapState),
    Multibody { state: SimulationState, acceleration: f64 },
}

fn message<E: std::fmt::Display>(error: E) -> String {
    error.to_string()
}

impl Plant {
    /// The model at rest at its start.
    pub fn start(resources: &Resources, with: Parameters, inputs: &MapInputs) -> Result<Plant, String> {
        match resources.unit.depth {
            Depth::Map => {
                let model = map(resources, with)?;
                let state = model.start(inputs).map_err(message)?;
                Ok(Plant::Map { model: Box::new(model), state })
            }
            Depth::Multibody => {
                let model = multibody(resources, with, inputs)?;
                let control = StepControl { tolerance: with.local_error / ARCMIN, ..StepControl::default() };
                let simulation = Simulation::from_rest(model, control, &Silent).map_err(message)?;
                let load = resources.unit.load_flange;
                Ok(Plant::Multibody { simulation: Box::new(simulation), load, acceleration: 0.0 })
            }
        }
    }

    /// The model in a saved state.
    pub fn resume(resources: &Resources, with: Parameters, saved: &SavedPlant) -> Result<Plant, String> {
        match (resources.unit.depth, saved) {
            (Depth::Map, SavedPlant::Map(state)) => {
                Ok(Plant::Map { model: Box::new(map(resources, with)?), state: state.clone() })
            }
            (Depth::Multibody, SavedPlant::Multibody { state, acceleration }) => {
                let model = multibody(resources, with, &MapInputs::default())?;
                let simulation = Box::new(Simulation::resume(model, state).map_err(message)?);
                let load = resources.unit.load_flange;
                Ok(Plant::Multibody { simulation, load, acceleration: *acceleration })
            }
            _ => Err("the saved state belongs to another unit".to_owned()),
        }
    }

    /// All data that determine the further results.
    pub fn save(&self) -> SavedPlant {
        match self {
            Plant::Map { state, .. } => SavedPlant::Map(state.clone()),
            Plant::Multibody { simulation, acceleration, .. } => {
                SavedPlant::Multibody { state: simulation.save(), acceleration: *acceleration }
            }
        }
    }

    /// Restores a state of the same model, earlier or later.
    pub fn restore(&mut self, saved: &SavedPlant) -> Result<(), String> {
        match (self, saved) {
            (Plant::Map { state, .. }, SavedPlant::Map(saved)) => {
                state.clone_from(saved);
                Ok(())
            }
            (
                Plant::Multibody { simulation, acceleration, .. },
                SavedPlant::Multibody { state, acceleration: a },
            ) => {
                simulation.restore(state).map_err(message)?;
                *acceleration = *a;
                Ok(())
            }
            _ => Err("the saved state belongs to another unit".to_owned()),
        }
    }

    /// Advances to a time in s since the start with inputs given at the present time.
    pub fn advance(&mut self, inputs: &MapInputs, time: f64) -> Result<(), String> {
        match self {
            Plant::Map { model, state } => model.advance(state, inputs, time).map_err(message),
            Plant::Multibody { simulation, load, acceleration } => {
                let [angle, speed, given] = inputs.motor;
                let motor = MotorInput::Angle { angle, speed, acceleration: given };
                simulation.set_motor(motor).map_err(message)?;
                let input = match load {
                    // The model counts a load that opposes the motion as positive.
                    LoadFlange::Torque => {
                        LoadInput::Torque { torque: -inputs.load_torque[0], rate: -inputs.load_torque[1] }
                    }
                    LoadFlange::Motion => {
                        let [angle, speed, acceleration] = inputs.load_motion;
                        LoadInput::Angle { angle, speed, acceleration }
                    }
                };
                simulation.set_load(input).map_err(message)?;
                let before = simulation.outputs().map_err(message)?;
                simulation.advance_to(time, &Silent).map_err(message)?;
                let after = simulation.outputs().map_err(message)?;
                if after.time > before.time {
                    *acceleration = (after.output_speed - before.output_speed) / (after.time - before.time);
                }
                Ok(())
            }
        }
    }

    pub fn outputs(&self) -> Result<Outputs, String> {
        match self {
            Plant::Map { model, state } => {
                let o = model.outputs(state);
                Ok(Outputs {
                    motor_torque: o.motor_torque,
                    load_torque: o.load_torque,
                    flange: o.flange,
                    transmission_error: o.transmission_error,
                    wind_up: o.wind_up,
                    pin_force: o.pin_force,
                    pin_pressure: o.pin_pressure,
                    loss: o.loss,
                    balance: o.balance,
                })
            }
            Plant::Multibody { simulation, acceleration, .. } => {
                let o = simulation.outputs().map_err(message)?;
                let flange = [o.output_angle, o.output_speed, *acceleration];
                Ok(Outputs {
                    motor_torque: o.input_torque,
                    load_torque: -o.output_torque,
                    flange,
                    transmission_error: o.transmission_error,
                    wind_up: -o.transmission_error,
                    pin_force: o.forces.largest_pin_force,
                    pin_pressure: o.forces.largest_pin_pressure,
                    loss: o.balance.dissipation,
                    balance: o.energy.residual(),
                })
            }
        }
    }
}

fn map(resources: &Resources, with: Parameters) -> Result<MapModel, String> {
    let unit = &resources.unit;
    if with.seed != unit.start_seed {
        return Err(format!(
            "seed {}: the maps of this unit are those of the machine with seed {}; export another unit for this seed",
            with.seed, unit.start_seed
        ));
    }
    let joint = unit.joint.as_ref().ok_or("unit.json has no maps")?;
    MapModel::at(joint, &unit.pins, with.hours, unit.load_flange, with.friction).map_err(message)
}

fn multibody(resources: &Resources, with: Parameters, inputs: &MapInputs) -> Result<Model, String> {
    let unit = &resources.unit;
    let host = InResources(&resources.directory);
    let mut options = unit.fidelity.clone();
    if with.seed > 0 {
        options.push_str(&format!("errors = \"drawn\"\nseed = {}\n", with.seed));
    }
    let options = FidelityOptions::parse(&options, "unit.json").map_err(message)?;
    if !(unit.hours[0]..=unit.hours[1]).contains(&with.hours) {
        return Err(format!(
            "operating_hours {} is outside of {} to {}",
            with.hours, unit.hours[0], unit.hours[1]
        ));
    }
    let motion =
        |[angle, speed, acceleration]: [f64; 3]| GivenMotion { since: 0.0, angle, speed, acceleration };
    let load = match unit.load_flange {
        LoadFlange::Torque => OutputLoad::GivenTorque(GivenTorque::constant(-inputs.load_torque[0])),
        LoadFlange::Motion => OutputLoad::GivenMotion(motion(inputs.load_motion)),
    };
    let drive = Drive::GivenMotion(motion(inputs.motor));
    let driven = Driven { drive, load, hours: with.hours, friction: with.friction };
    arcmin::analyses::multibody::multibody(&resources.design, &options, driven, &host).map_err(message)
}
