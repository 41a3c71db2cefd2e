//! Torques of the unloaded machine: running, starting, back-driving.

use super::RigError;
use super::efficiency::{Bench, SPEEDS};
use crate::dynamics::{BearingDrag, JointSettings};
use crate::machine::{Friction, Machine, REFERENCE_C};

/// Torques without load.
#[derive(Debug, Clone, PartialEq)]
pub struct RunningTorques {
    /// Torque at the input without load at rated speed, N·m.
    pub no_load: f64,
    /// The same over the input speed: pairs of rad/s and N·m.
    pub over_speed: Vec<(f64, f64)>,
    /// Starting torque at the input without load, N·m.
    pub starting: f64,
    /// Back-driving torque at the output with free input, N·m; infinite if the drive is self-locking.
    pub back_driving: f64,
}

/// Torques of the unloaded machine. They are extrapolated to zero load along the line through 1 % and 2 % of
/// the rated torque, since bodies within their clearance have no unique equilibrium.
///
/// # Errors
/// [`RigError`] where no equilibrium is found.
pub fn running_torques(machine: &Machine, settings: &JointSettings) -> Result<RunningTorques, RigError> {
    let rated = machine.rated.torque.abs();
    let speed = machine.rated.input_speed.abs();
    let line = |bench: &mut Bench, speed: f64, side: f64| -> Result<(f64, f64), RigError> {
        let one = bench.input_torque(rated, side * 0.01 * rated, speed)?;
        let two = bench.input_torque(rated, side * 0.02 * rated, speed)?;
        Ok((2.0 * one - two, (two - one) / (0.01 * rated)))
    };
    let mut bench = Bench::at(machine, settings, speed, 0.01 * rated)?;
    let (no_load, _) = line(&mut bench, speed, 1.0)?;
    let mut over_speed = Vec::with_capacity(SPEEDS.len());
    for share in SPEEDS {
        bench.set_operating_point(machine, settings, share * speed, 0.01 * rated)?;
        over_speed.push((share * speed, line(&mut bench, share * speed, 1.0)?.0));
    }
    let slow = 0.2 * speed;
    let mut bench = Bench::new(&Machine { friction: at_start(machine, slow)?, ..machine.clone() }, settings)?;
    let (starting, _) = line(&mut bench, slow, 1.0)?;
    // Driven at the output: the load acts along the motion, and the input torque goes to zero.
    let (offset, slope) = line(&mut bench, slow, -1.0)?;
    let back_driving = if slope < 0.0 { offset / -slope } else { f64::INFINITY };
    Ok(RunningTorques { no_load, over_speed, starting, back_driving })
}

/// Friction at the start, as that of a machine that runs at `slow`, fast enough for full Coulomb friction: no
/// drag of the oil, no film where a temperature is given, bearings with their starting moment.
fn at_start(machine: &Machine, slow: f64) -> Result<Friction, RigError> {
    let celsius = machine.thermal.temperature;
    let bare = celsius.map_or(machine.friction, |celsius| {
        machine.friction_at(celsius, 1e-9 * slow, machine.rated.torque).friction
    });
    let drag = BearingDrag::of(machine, celsius.unwrap_or(REFERENCE_C), 0.0)?;
    Ok(drag.added_to(Friction { oil_drag: 0.0, ..bare }, slow))
}
