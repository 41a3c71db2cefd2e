//! Torques of the unloaded machine: running, starting, back-driving.

use super::RigError;
use super::efficiency::{Bench, SPEEDS};
use crate::dynamics::{BearingDrag, JointSettings};
use crate::machine::{Friction, Machine, REFERENCE_C};

/// Torques without load.
#[derive(Debug, Clone, PartialEq)]
pub struct RunningTorques {
    /// At the input, running at rated speed without load, N·m.
    pub no_load: f64,
    /// The same over the input speed: rad/s, N·m.
    pub over_speed: Vec<(f64, f64)>,
    /// At the input, to start without load, N·m.
    pub starting: f64,
    /// At the output, to turn the free input backwards, N·m; infinite where it locks.
    pub back_driving: f64,
}

/// Torques of the unloaded machine. Without load means 1 % of the rated torque taken off again along the line
/// through 1 % and 2 %, as bodies that hang free in their clearance have no definite place.
///
/// # Errors
/// [`RigError`] where a balance cannot be found.
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
        bench.tune(machine, settings, share * speed, 0.01 * rated)?;
        over_speed.push((share * speed, line(&mut bench, share * speed, 1.0)?.0));
    }
    let slow = 0.2 * speed;
    let mut bench = Bench::new(&Machine { friction: at_start(machine, slow)?, ..machine.clone() }, settings)?;
    let (starting, _) = line(&mut bench, slow, 1.0)?;
    // Output driving: the load pushes along the motion, the input torque falls to zero.
    let (offset, slope) = line(&mut bench, slow, -1.0)?;
    let back_driving = if slope < 0.0 { offset / -slope } else { f64::INFINITY };
    Ok(RunningTorques { no_load, over_speed, starting, back_driving })
}

/// Friction of a machine that starts, as torques of one that turns at `slow`, fast enough for Coulomb friction to be
/// fully developed: no drag of the oil, no film where a temperature is given, bearings at their starting moment.
fn at_start(machine: &Machine, slow: f64) -> Result<Friction, RigError> {
    let celsius = machine.thermal.temperature;
    let bare = celsius.map_or(machine.friction, |celsius| {
        machine.friction_at(celsius, 1e-9 * slow, machine.rated.torque).friction
    });
    let drag = BearingDrag::of(machine, celsius.unwrap_or(REFERENCE_C), 0.0)?;
    Ok(drag.added_to(Friction { oil_drag: 0.0, ..bare }, slow))
}
