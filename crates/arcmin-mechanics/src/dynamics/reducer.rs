use serde::{Deserialize, Serialize};

use super::{Drive, DynamicsError, EquilibriumControl, OutputLoad, System, solve_equilibrium_unless};
use crate::progress::Progress;

/// A [`System`] with input and output: the interface of a reducer for simulations, in addition to the equations
/// of motion.
pub trait Reducer: System {
    /// Angle (rad) and speed (rad/s) of the input: the sun, or the motor behind an elastic shaft.
    fn input(&self, time: f64, position: &[f64], velocity: &[f64]) -> (f64, f64);

    /// Coordinate of the output angle.
    fn output_index(&self) -> usize;

    /// Angle (rad) and speed (rad/s) of the output.
    fn output(&self, position: &[f64], velocity: &[f64]) -> (f64, f64) {
        (position[self.output_index()], velocity[self.output_index()])
    }

    /// i = θ_s/θ_out.
    fn ratio(&self) -> f64;

    /// Drive of the input; `None` if it is held.
    fn drive(&self) -> Option<&Drive>;

    /// Replaces the drive by another one with the same free coordinates.
    fn set_drive(&mut self, drive: Drive);

    /// Load on the output.
    fn output_load(&self) -> &OutputLoad;

    /// Replaces the load on the output.
    fn set_output_load(&mut self, load: OutputLoad);

    /// External torque at the output in N·m; 0 if its motion is prescribed.
    fn load_torque(&self, time: f64) -> f64 {
        self.output_load().torque(time)
    }

    /// Coordinate of an input that is driven by a torque.
    fn free_input(&self) -> Option<usize> {
        None
    }

    /// Coordinates of the nominal machine for an angle of the input in rad.
    fn nominal_position_at(&self, input: f64) -> Vec<f64>;

    /// Coordinates of the nominal pose at time 0, where the search for the first equilibrium starts.
    fn nominal_position(&self) -> Vec<f64> {
        let free = self.free_input().is_some();
        let input = match (self.drive(), self.output_load().motion()) {
            (_, Some(output)) if free => output.at(0.0).0 * self.ratio(),
            (Some(drive), _) => drive.motion(0.0).angle,
            _ => 0.0,
        };
        self.nominal_position_at(input)
    }

    /// Initial state of a run at time 0: static equilibrium with the load, searched from a position `near` it
    /// or from the nominal one. A free input is held until then, because under load it is not in equilibrium by
    /// itself.
    ///
    /// # Errors
    /// [`DynamicsError::NoEquilibrium`]; [`DynamicsError::Cancelled`] if `progress` cancels it.
    fn rest_position(&self, near: Option<&[f64]>, progress: &dyn Progress) -> Result<Vec<f64>, DynamicsError>
    where
        Self: Sized,
    {
        let mut start = near.map_or_else(|| self.nominal_position(), <[f64]>::to_vec);
        let mut held = self.free_input();
        if let Some(motion) = self.output_load().motion() {
            start[self.output_index()] = motion.at(0.0).0;
            held = Some(self.output_index());
        }
        let control = EquilibriumControl { held, ..EquilibriumControl::default() };
        let cancelled = || progress.is_cancelled();
        Ok(solve_equilibrium_unless(self, 0.0, &start, control, &cancelled)?.position)
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
    /// Largest pin force on any disc, N.
    pub largest_pin_force: f64,
    /// Number of loaded pins, over all discs.
    pub loaded_pins: usize,
    /// Largest Hertz pressure between pin and flank, on any disc, in Pa.
    pub largest_pin_pressure: f64,
    /// Force on the line of action in N, sum of all sun–planet meshes.
    pub mesh_force: f64,
}

impl ForceSummary {
    /// Includes a pin with the force (N) and Hertz pressure (Pa) between it and the flank.
    pub(super) fn add_pin(&mut self, force: f64, pressure: f64) {
        if force > 0.0 {
            self.loaded_pins += 1;
            self.largest_pin_force = self.largest_pin_force.max(force);
            self.largest_pin_pressure = self.largest_pin_pressure.max(pressure);
        }
    }
}
