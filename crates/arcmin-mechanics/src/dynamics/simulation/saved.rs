//! Saved states of a simulation.

use serde::{Deserialize, Serialize};

use super::Simulation;
use crate::dynamics::{
    Drive, DynamicsError, Integrator, IntegratorState, Model, OutputLoad, Reducer, StepControl, System,
};

/// A saved simulation: with the same model it continues identically to an uninterrupted one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SimulationState {
    /// Kind of the model, its number of coordinates, and its masses.
    kind: u8,
    mass: Vec<f64>,
    control: StepControl,
    time: f64,
    drive: Option<Drive>,
    load: OutputLoad,
    state: IntegratorState,
    before: Option<IntegratorState>,
}

impl SimulationState {
    /// Time reached in s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// As bytes, without loss of precision.
    ///
    /// # Errors
    /// [`DynamicsError::ForeignCheckpoint`] if memory allocation fails.
    pub fn to_bytes(&self) -> Result<Vec<u8>, DynamicsError> {
        postcard::to_allocvec(self)
            .map_err(|_| DynamicsError::ForeignCheckpoint { reason: "it cannot be written" })
    }

    /// # Errors
    /// [`DynamicsError::ForeignCheckpoint`] for bytes that are not a saved state.
    pub fn from_bytes(bytes: &[u8]) -> Result<SimulationState, DynamicsError> {
        postcard::from_bytes(bytes)
            .map_err(|_| DynamicsError::ForeignCheckpoint { reason: "these bytes are not a saved state" })
    }
}

impl Simulation {
    /// State from which the simulation can be continued, without the model itself.
    pub fn save(&self) -> SimulationState {
        SimulationState {
            kind: self.model().kind(),
            mass: self.model().mass().to_vec(),
            control: self.integrator.control(),
            time: self.time,
            drive: self.model().drive().cloned(),
            load: self.model().output_load().clone(),
            state: self.integrator.state().clone(),
            before: self.before.clone(),
        }
    }

    /// Returns, or advances, to a saved state of the same model, including its inputs and functions of time.
    ///
    /// # Errors
    /// [`DynamicsError::ForeignCheckpoint`] if it belongs to another model.
    pub fn restore(&mut self, saved: &SimulationState) -> Result<(), DynamicsError> {
        let foreign = |reason: &'static str| Err(DynamicsError::ForeignCheckpoint { reason });
        let model = self.model();
        if saved.kind != model.kind() {
            return foreign("the kind of its joints or discs differs");
        }
        if saved.mass != model.mass() {
            return foreign("the masses of its bodies differ");
        }
        let free = |drive: Option<&Drive>| drive.map(Drive::leaves_sun_free);
        if free(saved.drive.as_ref()) != free(model.drive()) {
            return foreign("the kind of its drive differs");
        }
        saved.drive.as_ref().map_or(Ok(()), Drive::validate)?;
        saved.load.validate()?;
        let mut model = model.clone();
        saved.drive.iter().for_each(|drive| model.set_drive(drive.clone()));
        model.set_output_load(saved.load.clone());
        self.integrator = Integrator::resume(model, saved.control, saved.state.clone())?;
        self.time = saved.time;
        self.before.clone_from(&saved.before);
        Ok(())
    }

    /// A simulation of `model` from a saved state.
    ///
    /// # Errors
    /// As [`Simulation::restore`].
    pub fn resume(model: impl Into<Model>, saved: &SimulationState) -> Result<Simulation, DynamicsError> {
        let integrator = Integrator::resume(model.into(), saved.control, saved.state.clone())?;
        let mut simulation = Simulation { integrator, time: saved.time, before: None };
        simulation.restore(saved)?;
        Ok(simulation)
    }
}
