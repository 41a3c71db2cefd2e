//! The machine in steady running, without inertia: friction sees the nominal velocities.

use super::BearingJoints;
use super::assembly::Wanted;
use crate::dynamics::{Balance, DenseLinearisation, ElasticCoordinates, FlankPlace, Look, System};

/// A model whose friction sees given velocities, whatever the solver moves.
pub(super) struct Running<'a> {
    model: &'a BearingJoints,
    velocity: Vec<f64>,
}

impl<'a> Running<'a> {
    /// Around the place of the nominal machine with the sun at an angle (rad) and a speed (rad/s).
    pub(super) fn new(model: &'a BearingJoints, sun: f64, speed: f64) -> Running<'a> {
        Running { model, velocity: model.nominal_velocity_at(sun, speed) }
    }
}

impl System for Running<'_> {
    fn linearisation(&self) -> DenseLinearisation {
        self.model.linearisation()
    }

    fn linearisation_at_rest(&self) -> DenseLinearisation {
        self.model.linearisation_at_rest()
    }

    fn mass(&self) -> &[f64] {
        self.model.mass()
    }

    fn scale(&self) -> &[f64] {
        self.model.scale()
    }

    fn evaluate(
        &self,
        time: f64,
        position: &[f64],
        _: &[f64],
        force: &mut [f64],
        linearisation: &mut DenseLinearisation,
    ) -> Balance {
        self.model.evaluate(time, position, &self.velocity, force, linearisation)
    }

    fn evaluate_forces(&self, time: f64, position: &[f64], _: &[f64], force: &mut [f64]) -> Balance {
        self.model.evaluate_forces(time, position, &self.velocity, force)
    }

    fn look(&self, time: f64, position: &[f64], reach: f64, look: &mut Look) {
        let wanted = Wanted { reach, slip_interval: None };
        self.model.look_in_motion(time, position, &self.velocity, wanted, look);
    }

    fn elastic(&self) -> Option<&ElasticCoordinates> {
        self.model.elastic()
    }

    fn flank_compliance(&self, of: &FlankPlace, force: &FlankPlace) -> f64 {
        self.model.flank_compliance(of, force)
    }

    fn crank_angle(&self, position: &[f64]) -> f64 {
        self.model.crank_angle(position)
    }
}
