//! Functional mock-up units: their description, and the map model of the fast one.
//!
//! The library that an importer loads is the crate `arcmin-fmu`; it uses the same table of variables as the
//! model description written here.

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
    /// Torsion curve, hysteresis, waves of the transmission error, friction: microseconds per step.
    Map,
    /// The multibody model of `arcmin simulate`.
    Multibody,
}

/// Variables of the load flange.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LoadFlange {
    /// Torque in, motion out: the unit contains the inertia of its output.
    Torque,
    /// Motion in, torque out: the model of the arm contains the inertia.
    Motion,
}

/// Largest force and pressure of a pin at a torque.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PinLoadAt {
    /// Torque at the output, N·m.
    pub torque_n_m: f64,
    /// Largest force on a pin, N.
    pub force_n: f64,
    /// Largest Hertz pressure between pin and flank, Pa.
    pub pressure_pa: f64,
}

/// Resources of a unit in addition to the design, as `unit.json`.
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
    /// Smallest and largest age covered by the maps, in hours.
    pub hours: [f64; 2],
    /// Initial age in hours.
    pub start_hours: f64,
    /// Initial seed; 0 for the errors of the design.
    pub start_seed: i32,
    /// Maps by age; `None` in the multibody unit.
    pub joint: Option<JointExport>,
    /// Pin loads by age, in the order of the joint's states.
    pub pins: Vec<Vec<PinLoadAt>>,
}
