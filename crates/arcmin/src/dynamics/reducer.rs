use serde::{Deserialize, Serialize};

use super::{DynamicsError, EquilibriumControl, System, solve_equilibrium};

/// A [`System`] that is a reducer: what a run needs to know beyond the equations of motion.
pub trait Reducer: System {
    /// Angle (rad) and speed (rad/s) of the input: the sun, or the motor behind an elastic shaft.
    fn input(&self, time: f64, position: &[f64], velocity: &[f64]) -> (f64, f64);

    /// Angle (rad) and speed (rad/s) of the output.
    fn output(&self, position: &[f64], velocity: &[f64]) -> (f64, f64);

    /// i = θ_s/θ_out.
    fn ratio(&self) -> f64;

    /// External torque at the output in N·m.
    fn load_torque(&self, time: f64) -> f64;

    /// Coordinate of an input that a torque drives.
    fn free_input(&self) -> Option<usize> {
        None
    }

    /// Coordinates of the nominal pose at time 0, where the search for the first equilibrium starts.
    fn nominal_position(&self) -> Vec<f64>;

    /// State of rest at time 0 from which a run starts: static equilibrium with the load. A free input is
    /// held until then: under load nothing else keeps it at rest.
    ///
    /// # Errors
    /// [`DynamicsError::NoEquilibrium`].
    fn rest_position(&self) -> Result<Vec<f64>, DynamicsError>
    where
        Self: Sized,
    {
        let control = EquilibriumControl { held: self.free_input(), ..EquilibriumControl::default() };
        Ok(solve_equilibrium(self, 0.0, &self.nominal_position(), control)?.position)
    }

    /// Largest forces at one state.
    fn forces(&self, time: f64, position: &[f64], velocity: &[f64]) -> ForceSummary;

    /// Transmission error θ_out − θ_s/i in rad; negative where the output lags.
    fn transmission_error(&self, time: f64, position: &[f64], velocity: &[f64]) -> f64 {
        self.output(position, velocity).0 - self.input(time, position, velocity).0 / self.ratio()
    }
}

/// Contact and mesh forces at one instant, in N.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ForceSummary {
    /// Largest pin force on any disc.
    pub largest_pin_force: f64,
    /// Pins that carry force, over all discs.
    pub loaded_pins: usize,
    /// Force on the line of action, all sun–planet meshes together.
    pub mesh_force: f64,
}
