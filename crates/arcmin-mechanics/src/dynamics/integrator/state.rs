//! State of an integrator between steps.

use serde::{Deserialize, Serialize};

use crate::dynamics::{Balance, DynamicsError, Weights};

/// State at one end of a step. Vectors have one entry per coordinate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Node {
    /// s.
    pub time: f64,
    /// m or rad.
    pub position: Vec<f64>,
    /// m/s or rad/s.
    pub velocity: Vec<f64>,
    /// M⁻¹Q: the equations of motion hold exactly at every node.
    pub acceleration: Vec<f64>,
    /// Powers, stored energy and torques at the flanges.
    pub balance: Balance,
}

/// Time integrals of the powers in J.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct EnergyAccount {
    /// Work of the drive on the machine.
    pub input: f64,
    /// Work of the machine on its load.
    pub load: f64,
    /// Work lost in dampers and friction.
    pub dissipated: f64,
    /// ∫ Σ|P| dt over input, load and dissipation.
    pub turnover: f64,
    /// Kinetic and elastic energy at the start.
    pub initial: f64,
    /// Kinetic and elastic energy now.
    pub current: f64,
}

impl EnergyAccount {
    /// Input − load − dissipated − Δ(stored), in J: the energy error of the integration.
    pub fn imbalance(&self) -> f64 {
        self.input - self.load - self.dissipated - (self.current - self.initial)
    }

    /// |imbalance| / ∫ Σ|P| dt.
    pub fn residual(&self) -> f64 {
        if self.turnover > 0.0 { self.imbalance().abs() / self.turnover } else { 0.0 }
    }
}

/// Cost of an integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct StepCounts {
    /// Steps that met the tolerance.
    pub accepted: usize,
    /// Steps that were repeated with a smaller size.
    pub rejected: usize,
    /// Evaluations of the forces.
    pub evaluations: usize,
    /// Evaluations among these with a tangent.
    pub tangents: usize,
}

/// State at which the matrix of Newton's method was evaluated, and weights with which it was factorised, so
/// that it can be formed again.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct MatrixPlace {
    pub time: f64,
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
    pub weights: Weights,
}

impl MatrixPlace {
    pub fn set(&mut self, time: f64, position: &[f64], velocity: &[f64], weights: Weights) {
        (self.time, self.weights) = (time, weights);
        self.position.clear();
        self.position.extend_from_slice(position);
        self.velocity.clear();
        self.velocity.extend_from_slice(velocity);
    }
}

/// Everything that the next step depends on: a run resumed from its serialisation is identical, bit by bit, to
/// the uninterrupted one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IntegratorState {
    /// End of the last accepted step.
    pub current: Node,
    /// Beginning of the last accepted step.
    pub previous: Node,
    /// The auxiliary acceleration a_n of the method, near q̈(t_n + (α_m − α_f) h).
    pub(super) auxiliary: Vec<f64>,
    /// Slope of the accelerations over the last step, for the predictor.
    pub(super) jerk: Vec<f64>,
    /// Matrix at the beginning of the next step.
    pub(super) matrix: Option<MatrixPlace>,
    pub(super) last_step: f64,
    pub(super) next_step: f64,
    /// Work and energy since the start.
    pub energy: EnergyAccount,
    /// Steps and evaluations since the start.
    pub counts: StepCounts,
}

impl IntegratorState {
    pub(super) fn check_size(&self, n: usize) -> Result<(), DynamicsError> {
        let fits =
            |node: &Node| [&node.position, &node.velocity, &node.acceleration].iter().all(|v| v.len() == n);
        if fits(&self.current) && fits(&self.previous) && self.auxiliary.len() == n && self.jerk.len() == n {
            return Ok(());
        }
        Err(DynamicsError::ForeignCheckpoint { reason: "its number of coordinates differs" })
    }

    /// As `clone_from`, without allocation if lengths are equal.
    pub(in crate::dynamics) fn copy_from(&mut self, other: &IntegratorState) {
        for (own, node) in [(&mut self.current, &other.current), (&mut self.previous, &other.previous)] {
            own.time = node.time;
            own.position.clone_from(&node.position);
            own.velocity.clone_from(&node.velocity);
            own.acceleration.clone_from(&node.acceleration);
            own.balance = node.balance;
        }
        self.auxiliary.clone_from(&other.auxiliary);
        self.jerk.clone_from(&other.jerk);
        self.matrix.clone_from(&other.matrix);
        (self.last_step, self.next_step) = (other.last_step, other.next_step);
        (self.energy, self.counts) = (other.energy, other.counts);
    }
}

/// Value and slope at x ∈ [0, 1] of the cubic through two values with slopes over an interval h.
pub(crate) fn hermite(h: f64, x: f64, q0: f64, q1: f64, v0: f64, v1: f64) -> (f64, f64) {
    let rise = q1 - q0;
    let (a, b) = (h * v0 - rise, h * v1 - rise);
    let y = 1.0 - x;
    // Deviation from the chord: x y (a y − b x).
    let deviation = x * y * (a * y - b * x);
    let slope = (y - x) * (a * y - b * x) - x * y * (a + b);
    (q0 + x * rise + deviation, (rise + slope) / h)
}
