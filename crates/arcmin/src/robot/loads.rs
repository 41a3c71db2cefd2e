//! Loads of every joint in the programs.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::arm::{Arm, Posture};
use super::joint::JointModel;
use super::life::{JointDuty, Moment};
use super::newton_euler::{AxisLoad, inverse_dynamics};
use super::read::Program;

/// The arm along a program, sample by sample.
#[derive(Debug, Clone)]
pub struct Course {
    pub postures: Vec<Posture>,
    pub loads: Vec<Vec<AxisLoad>>,
}

impl Course {
    pub fn of(arm: &Arm, program: &Program) -> Course {
        let motion = &program.motion;
        let (postures, loads) = (0..motion.len())
            .into_par_iter()
            .map(|sample| {
                let of = |axes: &[Vec<f64>]| axes.iter().map(|axis| axis[sample]).collect::<Vec<f64>>();
                let posture = arm.posture(&motion.angles_at(sample));
                let loads = inverse_dynamics(arm, &posture, &of(&motion.speed), &of(&motion.acceleration));
                (posture, loads)
            })
            .unzip();
        Course { postures, loads }
    }

    /// External moment that tilts the output of an axis, about its bearings, perpendicular to the axis.
    pub fn tilting(&self, sample: usize, axis: usize, bearings: f64) -> Vector3<f64> {
        -self.loads[sample][axis].tilting(&self.postures[sample].axes[axis], bearings)
    }
}

/// Samples of a joint over all programs.
pub fn moments(programs: &[Program], courses: &[Course], axis: usize, bearings: f64) -> Vec<Moment> {
    let mut all = Vec::new();
    for (program, course) in programs.iter().zip(courses) {
        let motion = &program.motion;
        let rest = motion.rest_speed(axis);
        for sample in 0..motion.len() {
            let (load, z) = (&course.loads[sample][axis], &course.postures[sample].axes[axis]);
            let speed = motion.speed[axis][sample];
            all.push(Moment {
                torque: load.torque,
                speed,
                time: motion.weight(sample) * program.cycles,
                moves: speed.abs() > rest,
                tilting: load.tilting(z, bearings).norm(),
                axial: -load.axial(z),
                radial: load.radial(z),
            });
        }
    }
    all
}

/// Root mean square and largest torque of the motor in N·m at its own shaft, over the time of the programs.
pub fn motor_torques(
    programs: &[Program],
    courses: &[Course],
    axis: usize,
    joint: &JointModel,
) -> (f64, f64) {
    let (mut squares, mut time, mut peak) = (0.0, 0.0, 0.0_f64);
    for (program, course) in programs.iter().zip(courses) {
        let motion = &program.motion;
        let rest = motion.rest_speed(axis);
        for sample in 0..motion.len() {
            let speed = motion.speed[axis][sample];
            let speed = if speed.abs() > rest { speed } else { 0.0 };
            let torque = course.loads[sample][axis].torque;
            let motor = joint.motor_torque(torque, speed, motion.acceleration[axis][sample]);
            let weight = motion.weight(sample) * program.cycles;
            squares += motor * motor * weight;
            time += weight;
            peak = peak.max(motor.abs());
        }
    }
    (if time > 0.0 { (squares / time).sqrt() } else { 0.0 }, peak)
}

/// The largest torque of an axis that exceeds the allowed one: program, sample and torque.
pub fn beyond(
    programs: &[Program],
    courses: &[Course],
    axis: usize,
    allowed: f64,
) -> Option<(usize, usize, f64)> {
    let mut worst: Option<(usize, usize, f64)> = None;
    for (index, course) in programs.iter().zip(courses).map(|(_, course)| course).enumerate() {
        for (sample, loads) in course.loads.iter().enumerate() {
            let torque = loads[axis].torque;
            if torque.abs() > allowed && worst.is_none_or(|(_, _, most)| torque.abs() > most.abs()) {
                worst = Some((index, sample, torque));
            }
        }
    }
    worst
}

/// The duty of an axis.
pub fn duty(
    programs: &[Program],
    courses: &[Course],
    axis: usize,
    (bearings, ratio, rows): (f64, f64, usize),
) -> JointDuty {
    JointDuty::of(&moments(programs, courses, axis, bearings), ratio, rows)
}
