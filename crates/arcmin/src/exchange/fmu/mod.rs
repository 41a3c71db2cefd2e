//! Functional mock-up units: what one says about itself, and the map model inside of the quick one.
//!
//! The library that an importer loads is the crate `arcmin-fmu`; it and the model description written here use
//! the same table of variables.

mod description;
mod map;
#[cfg(test)]
mod tests;
mod variable;
pub use variable::references;

use serde::{Deserialize, Serialize};

pub use description::{ModelDescription, instantiation_token};
pub use map::{MapInputs, MapModel, MapOutputs, MapState};
pub use variable::{Kind, Role, START_LOCAL_ERROR, Variable, variables};

use super::JointExport;

/// Models inside of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Depth {
    /// Torsion curve, hysteresis, waves of the transmission error, friction: microseconds a step.
    Map,
    /// The multibody model of `arcmin simulate`.
    Multibody,
}

/// Variables of the load flange.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LoadFlange {
    /// Takes a torque, gives the motion: the unit owns the inertia of its output.
    Torque,
    /// Takes the motion, gives the torque: the arm's model owns the inertia.
    Motion,
}

/// Largest force and pressure of a pin at a torque.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PinLoadAt {
    /// Torque at the output.
    pub torque_n_m: f64,
    /// Largest force of a pin.
    pub force_n: f64,
    /// Largest Hertz pressure between pin and flank.
    pub pressure_pa: f64,
}

/// Resources of a unit beside the design, as `unit.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnitData {
    /// Model inside of the unit.
    pub depth: Depth,
    /// Variables of the load flange.
    pub load_flange: LoadFlange,
    /// Token that importer and library compare.
    pub instantiation_token: String,
    /// Options of the multibody model as TOML.
    pub fidelity: String,
    /// Least and largest age that the maps cover, in hours.
    pub hours: [f64; 2],
    /// Age to start with, in hours.
    pub start_hours: f64,
    /// Seed to start with; 0 for the errors of the design.
    pub start_seed: i32,
    /// Maps by age; none in the multibody unit.
    pub joint: Option<JointExport>,
    /// Pin loads by age, in the order of the joint's states.
    pub pins: Vec<Vec<PinLoadAt>>,
}
