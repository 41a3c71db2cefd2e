//! Errors that a controller can compensate, and those that remain.

use super::figures::{Figures, Sorted, Tool};
use super::file::Compensation;
use super::joint::JointModel;
use super::tool::{Field, Places};
use crate::design::Choice;

/// The tool at the planned hours under one kind of compensation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Remaining {
    pub compensates: Compensation,
    pub new: Figures,
    pub end: Figures,
}

/// All kinds, new and at the planned hours.
pub fn remaining(
    places: &Places,
    sorted: &Sorted,
    joints: &[JointModel],
    moving: &[f64],
    planned: f64,
) -> Vec<Remaining> {
    Compensation::VALUES
        .iter()
        .map(|compensates| {
            let field = Field::of(places, joints, moving, *compensates);
            let tool = Tool { places, sorted, field: &field };
            let at = |hours: f64| tool.figures(&vec![hours; joints.len()]);
            Remaining { compensates: *compensates, new: at(0.0), end: at(planned) }
        })
        .collect()
}

/// One row of the compensation table.
#[derive(Debug, Clone)]
pub struct Entry {
    pub joint: String,
    /// Hours of the robot.
    pub hours: f64,
    /// External torque on the output, N·m.
    pub torque: f64,
    pub rises: bool,
    /// Error, rad.
    pub error: f64,
}

/// Torques of the table relative to the rated one.
const SHARES: [f64; 15] =
    [-1.0, -0.75, -0.5, -0.25, -0.1, -0.03, -0.01, 0.0, 0.01, 0.03, 0.1, 0.25, 0.5, 0.75, 1.0];

/// Mean error of every joint over load and direction, at the computed ages.
pub fn table(joints: &[JointModel], moving: &[f64]) -> Vec<Entry> {
    let mut entries = Vec::new();
    for (joint, moving) in joints.iter().zip(moving) {
        for age in &joint.ages {
            for rises in [true, false] {
                for share in SHARES {
                    let torque = share * joint.rated;
                    entries.push(Entry {
                        joint: joint.axis.clone(),
                        hours: if *moving > 0.0 { age.hours / moving } else { 0.0 },
                        torque,
                        rises,
                        error: age.curve.branch(rises, torque),
                    });
                }
            }
        }
    }
    entries
}

/// One wave of the transmission error, for compensation.
#[derive(Debug, Clone)]
pub struct WaveEntry {
    pub joint: String,
    pub hours: f64,
    /// External torque on the output, N·m.
    pub torque: f64,
    pub order: f64,
    /// Amplitude and phase in rad of cos(order × joint angle + phase).
    pub amplitude: f64,
    pub phase: f64,
}

pub fn waves(joints: &[JointModel], moving: &[f64]) -> Vec<WaveEntry> {
    let mut entries = Vec::new();
    for (joint, moving) in joints.iter().zip(moving) {
        for age in &joint.ages {
            for (torque, waves) in age.waves() {
                for wave in &waves.waves {
                    entries.push(WaveEntry {
                        joint: joint.axis.clone(),
                        hours: if *moving > 0.0 { age.hours / moving } else { 0.0 },
                        torque: *torque,
                        order: wave.order,
                        amplitude: wave.amplitude_rad,
                        phase: wave.phase_rad + wave.order * joint.offset,
                    });
                }
            }
        }
    }
    entries
}
