use std::f64::consts::TAU;

use super::RigError;
use super::settle::run;
use crate::dynamics::{BearingJoints, JointSettings, System};
use crate::machine::Machine;

/// Efficiency over output torque and input speed.
#[derive(Debug, Clone, PartialEq)]
pub struct EfficiencyMap {
    /// N·m.
    pub torques: Vec<f64>,
    /// rad/s at the input.
    pub speeds: Vec<f64>,
    /// Row per speed, column per torque.
    pub efficiency: Vec<Vec<f64>>,
    /// At rated torque and speed.
    pub rated: f64,
}

/// Torques without load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunningTorques {
    /// At the input, running at rated speed without load, N·m.
    pub no_load: f64,
    /// At the input, to start without load, N·m.
    pub starting: f64,
    /// At the output, to turn the free input backwards, N·m.
    pub back_driving: f64,
}

/// Crank positions over which torques are averaged.
const POSITIONS: usize = 8;

/// Mean torque (N·m) that the drive puts in at the speed (rad/s) and output torque (N·m), both signed.
fn input_torque(model: &mut BearingJoints, rated: f64, torque: f64, speed: f64) -> Result<f64, RigError> {
    let ratio = model.kinematics().ratio();
    let lobes = model.kinematics().lobe_count;
    // The load opposes the motion of the output, which a carrier at rest turns round.
    let torque = ratio.signum() * torque;
    let mut sum = 0.0;
    for i in 0..POSITIONS {
        let sun = TAU * i as f64 / POSITIONS as f64 * ratio / lobes;
        model.hold_sun(sun, speed);
        let nominal = model.nominal_position_at(sun);
        let velocity = model.nominal_velocity_at(sun, speed);
        model.set_load(rated.copysign(torque));
        let loaded = run(model, &nominal, velocity.clone())?;
        model.set_load(torque);
        let q = run(model, &loaded, velocity.clone())?;
        let mut force = vec![0.0; q.len()];
        let mut linearisation = model.linearisation();
        sum += model.evaluate_with_input(0.0, &q, &velocity, &mut force, &mut linearisation).1;
    }
    Ok(sum / POSITIONS as f64)
}

fn bench(machine: &Machine, settings: &JointSettings) -> Result<BearingJoints, RigError> {
    Ok(BearingJoints::held(machine, &JointSettings { damped: false, ..settings.clone() })?)
}

/// η = T_out/(i T_in), from the balance of the running machine with friction at pins, needles, supports,
/// meshes, seals and oil.
///
/// # Errors
/// [`RigError`] where a balance cannot be found.
pub fn efficiency_map(machine: &Machine, settings: &JointSettings) -> Result<EfficiencyMap, RigError> {
    let mut model = bench(machine, settings)?;
    let rated = machine.rated.torque.abs();
    let ratio = model.kinematics().ratio().abs();
    let speed = machine.rated.input_speed.abs();
    let torques: Vec<f64> = [0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0].map(|share| share * rated).to_vec();
    let speeds: Vec<f64> = [0.1, 0.25, 0.5, 0.75, 1.0, 1.5].map(|share| share * speed).to_vec();
    let mut efficiency = Vec::with_capacity(speeds.len());
    for speed in &speeds {
        let mut row = Vec::with_capacity(torques.len());
        for torque in &torques {
            row.push(torque / (ratio * input_torque(&mut model, rated, *torque, *speed)?));
        }
        efficiency.push(row);
    }
    let at_rated = rated / (ratio * input_torque(&mut model, rated, rated, speed)?);
    Ok(EfficiencyMap { torques, speeds, efficiency, rated: at_rated })
}

/// Torques of the unloaded machine. Without load means 1 % of the rated torque taken off again along the line
/// through 1 % and 2 %, as bodies that hang free in their clearance have no definite place.
///
/// # Errors
/// [`RigError`] where a balance cannot be found.
pub fn running_torques(machine: &Machine, settings: &JointSettings) -> Result<RunningTorques, RigError> {
    let rated = machine.rated.torque.abs();
    let speed = machine.rated.input_speed.abs();
    let line = |model: &mut BearingJoints, speed: f64, side: f64| -> Result<(f64, f64), RigError> {
        let one = input_torque(model, rated, side * 0.01 * rated, speed)?;
        let two = input_torque(model, rated, side * 0.02 * rated, speed)?;
        Ok((2.0 * one - two, (two - one) / (0.01 * rated)))
    };
    let (no_load, _) = line(&mut bench(machine, settings)?, speed, 1.0)?;
    // A machine that starts has no speed for the oil to drag at, yet Coulomb friction is to be fully
    // developed.
    let mut still = machine.clone();
    still.friction.oil_drag = 0.0;
    let mut model = bench(&still, settings)?;
    let slow = 0.2 * speed;
    let (starting, _) = line(&mut model, slow, 1.0)?;
    // Output driving: the load pushes along the motion, the input torque falls to zero.
    let (offset, slope) = line(&mut model, slow, -1.0)?;
    let back_driving = if slope < 0.0 { offset / -slope } else { f64::INFINITY };
    Ok(RunningTorques { no_load, starting, back_driving })
}

/// Losses at one speed as a straight line over the torque.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LossLine {
    pub input_speed_rad_per_s: f64,
    /// Share of the torque that arrives: the motor drives, the load drives.
    pub efficiency: [f64; 2],
    /// Friction torque at the input in N·m that does not depend on the torque, in either case.
    pub friction_n_m: [f64; 2],
    /// Largest distance of a balance from its line, N·m at the input.
    pub left_n_m: f64,
}

/// Lines τ_in = T/(i η₁) + τ₁ (the motor drives) and τ_in = τ₂ − T η₂/i (the load drives) through balances of
/// the running machine between 10 % and 100 % of the rated torque, for some speeds.
///
/// # Errors
/// [`RigError`] where a balance cannot be found.
pub fn loss_lines(machine: &Machine, settings: &JointSettings) -> Result<Vec<LossLine>, RigError> {
    use rayon::prelude::*;
    const SPEEDS: [f64; 4] = [0.1, 0.5, 1.0, 1.5];
    const SHARES: [f64; 3] = [0.1, 0.5, 1.0];
    let rated = machine.rated.torque.abs();
    SPEEDS
        .into_par_iter()
        .map(|share| {
            let mut model = bench(machine, settings)?;
            let ratio = model.kinematics().ratio().abs();
            let speed = share * machine.rated.input_speed.abs();
            let mut line = |side: f64| -> Result<(f64, f64, f64), RigError> {
                let mut points = [(0.0, 0.0); SHARES.len()];
                for (point, share) in points.iter_mut().zip(SHARES) {
                    *point = (share * rated, input_torque(&mut model, rated, side * share * rated, speed)?);
                }
                let n = points.len() as f64;
                let (x, y) = points.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / n, sum.1 + p.1 / n));
                let slope = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>()
                    / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>();
                let left = points.iter().map(|p| (p.1 - y - slope * (p.0 - x)).abs()).fold(0.0, f64::max);
                Ok((slope, y - slope * x, left))
            };
            let (driving, friction, first) = line(1.0)?;
            let (driven, back, second) = line(-1.0)?;
            Ok(LossLine {
                input_speed_rad_per_s: speed,
                efficiency: [1.0 / (driving * ratio), -driven * ratio],
                friction_n_m: [friction, back],
                left_n_m: first.max(second),
            })
        })
        .collect()
}
