//! Duty and limits by which a life is judged, of a drive of any family.

use crate::machine::{DutyPoint, Limits, Machine};
use crate::wear::{WearCase, depth_past_use};
use std::f64::consts::TAU;

/// Duty and limits of a drive, with the speeds that go with them.
#[derive(Debug, Clone)]
pub struct Demands {
    /// Limits of the design.
    pub limits: Limits,
    /// N·m.
    pub rated_torque: f64,
    /// Load spectrum, torques at the output.
    pub duty: Vec<DutyPoint>,
    /// Speed of the output relative to the ring, over that of the input.
    pub output_per_input: f64,
    /// Passes of a place of a flank through its contact per turn of the input: turns of the eccentric relative to the
    /// disc.
    pub passes_per_turn: f64,
    /// Depth (m) of flank or pin at which the wear counts as run away.
    pub past_use: f64,
}

impl Demands {
    /// Those of an RV reducer.
    pub fn of(machine: &Machine) -> Demands {
        let (output, _, relative) = machine.kinematics().speeds(1.0);
        Demands {
            limits: machine.limits,
            rated_torque: machine.rated.torque,
            duty: machine.duty.clone(),
            output_per_input: output,
            passes_per_turn: relative.abs(),
            past_use: depth_past_use(&WearCase::from(machine)),
        }
    }

    /// Speed of the output in rad/s at a row of the duty.
    pub fn output_speed(&self, row: &DutyPoint) -> f64 {
        (row.input_speed * self.output_per_input).abs()
    }

    /// Passes of a place of a flank through its contact per second at a row of the duty.
    pub fn passes_per_second(&self, row: &DutyPoint) -> f64 {
        row.input_speed.abs() / TAU * self.passes_per_turn
    }

    /// Share of the duty in which the input is at rest.
    pub fn rest_share(&self) -> f64 {
        self.duty.iter().filter(|row| row.input_speed == 0.0).map(|row| row.share).sum()
    }
}
