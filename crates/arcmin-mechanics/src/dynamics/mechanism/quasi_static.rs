//! Quasi-static motion of a mechanism: prescribed velocities determine friction, inertia is neglected.

use std::borrow::Cow;

use super::{ContactRequest, Mechanism};
use crate::dynamics::{Balance, DenseLinearisation, ElasticCoordinates, Evaluation, FlankPlace, System};

/// Velocities that determine friction.
#[derive(Debug, Clone)]
pub(crate) enum Motion<'a> {
    /// Given velocities in m/s or rad/s: steady running.
    Running(Vec<f64>),
    /// (q − q_before)/Δt: a slow change of load over a time interval (s) from the previous state.
    Creeping { from: &'a [f64], interval: f64 },
}

/// A mechanism in such a motion, for the solver of static equilibrium.
pub(crate) struct QuasiStatic<'a> {
    pub mechanism: &'a Mechanism,
    pub motion: Motion<'a>,
}

impl QuasiStatic<'_> {
    fn velocity(&self, position: &[f64]) -> Cow<'_, [f64]> {
        match &self.motion {
            Motion::Running(velocity) => Cow::Borrowed(velocity),
            Motion::Creeping { from, interval } => {
                position.iter().zip(*from).map(|(q, q0)| (q - q0) / interval).collect()
            }
        }
    }
}

impl System for QuasiStatic<'_> {
    fn linearisation(&self) -> DenseLinearisation {
        self.mechanism.linearisation()
    }

    fn mass(&self) -> &[f64] {
        self.mechanism.mass()
    }

    fn scale(&self) -> &[f64] {
        self.mechanism.scale()
    }

    fn evaluate(
        &self,
        time: f64,
        position: &[f64],
        _: &[f64],
        force: &mut [f64],
        linearisation: &mut DenseLinearisation,
    ) -> Balance {
        self.mechanism.evaluate(time, position, &self.velocity(position), force, linearisation)
    }

    fn evaluate_statics(&self, time: f64, position: &[f64], reach: f64, evaluation: &mut Evaluation) {
        let slip_interval = match self.motion {
            Motion::Running(_) => None,
            Motion::Creeping { interval, .. } => Some(interval),
        };
        let wanted = ContactRequest { reach, slip_interval };
        self.mechanism.evaluate_in_motion(time, position, &self.velocity(position), wanted, evaluation);
    }

    fn elastic(&self) -> Option<&ElasticCoordinates> {
        self.mechanism.elastic()
    }

    fn flank_compliance(&self, of: &FlankPlace, force: &FlankPlace) -> f64 {
        self.mechanism.flank_compliance(of, force)
    }

    fn crank_angle(&self, position: &[f64]) -> f64 {
        self.mechanism.crank_angle(position)
    }
}
