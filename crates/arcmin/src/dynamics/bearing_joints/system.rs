use super::assembly::{Assembly, Sink};
use super::{BearingJoints, Input};
use crate::contact::{DiscPose, DiscVelocity, Reaction};
use crate::dynamics::{Balance, DenseLinearisation, ForceSummary, Reducer, System};
use crate::geometry::Vec2;

impl BearingJoints {
    /// Coordinates and velocities with a prescribed sun appended.
    pub(super) fn full(&self, time: f64, position: &[f64], velocity: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (mut q, mut v) = (Vec::with_capacity(position.len() + 1), Vec::with_capacity(position.len() + 1));
        q.extend_from_slice(position);
        v.extend_from_slice(velocity);
        if !self.layout.has_free_sun() {
            let (angle, speed) = self.sun_motion(time);
            let (place, rate) = self.sun_rides_on.map_or((0.0, 0.0), |own| (position[own], velocity[own]));
            q.push(angle + place);
            v.push(speed + rate);
        }
        (q, v)
    }

    fn sun_motion(&self, time: f64) -> (f64, f64) {
        match &self.input {
            Input::Held { angle, speed } => (*angle, *speed),
            Input::Driven(drive) => {
                let motion = drive.motion(time);
                (motion.angle, motion.speed)
            }
        }
    }

    pub(super) fn disc_state(&self, disc: usize, q: &[f64], v: &[f64]) -> (DiscPose, DiscVelocity) {
        let at = self.layout.disc(disc);
        let centre = |x: &[f64]| Vec2::new(x[at], x[at + 1]);
        (DiscPose { centre: centre(q), angle: q[at + 2] }, DiscVelocity { centre: centre(v), angle: v[at + 2] })
    }

    /// Everything at one state; returns powers and the torque (N·m) that the drive puts on the sun.
    pub fn evaluate_with_input(
        &self,
        time: f64,
        position: &[f64],
        velocity: &[f64],
        force: &mut [f64],
        linearisation: &mut DenseLinearisation,
    ) -> (Balance, f64) {
        let (q, v) = self.full(time, position, velocity);
        linearisation.clear();
        force.fill(0.0);
        let size = self.layout.size();
        let mut assembly =
            Assembly { force, linearisation, size, sun_rides_on: self.sun_rides_on, prescribed_torque: 0.0, balance: Balance::default() };
        self.visit(&q, &v, &mut assembly);
        for disc in 0..self.layout.discs {
            let (pose, rate) = self.disc_state(disc, &q, &v);
            let Reaction { force: f, stiffness, damping, stored, dissipation, onset_rate } = self.rings[disc].react(pose, rate);
            let at = self.layout.disc(disc);
            for i in 0..3 {
                assembly.add_force(at + i, f[i]);
                for j in 0..3 {
                    assembly.linearisation.add_stiffness(at + i, at + j, stiffness[i][j]);
                    assembly.linearisation.add_damping(at + i, at + j, damping[i][j]);
                }
            }
            assembly.balance.stored += stored;
            assembly.balance.dissipation += dissipation;
            assembly.balance.onset_rate = assembly.balance.onset_rate.max(onset_rate);
        }
        let output = self.layout.output();
        // Where the carrier is at rest the housing turns, the other way round in its own frame.
        let load = self.output_sense() * self.load.torque(time);
        assembly.add_force(output, -load);
        assembly.balance.load_power = load * v[output];
        if self.drag > 0.0 {
            let reach = 1.0 / v[output].hypot(self.drag_speed);
            let torque = self.drag * v[output] * reach;
            let slope = self.drag * self.drag_speed.powi(2) * reach.powi(3);
            assembly.damper(&[output], &[-torque], &[slope], torque * v[output]);
        }
        let sun = self.layout.sun_angle();
        let oil = self.friction.oil_drag;
        // The speed of the sun against what is at rest, and its power.
        let speed = v[sun] - self.sun_rides_on.map_or(0.0, |own| v[own]);
        if oil > 0.0 {
            assembly.drag_on_sun(sun, oil, speed, self.sun_rides_on.is_some());
        }
        let input_torque = match &self.input {
            Input::Driven(drive) if self.layout.has_free_sun() => {
                let (torque, slope) = drive.torque(time, v[sun]);
                assembly.damper(&[sun], &[torque], &[slope], 0.0);
                torque
            }
            _ => -assembly.prescribed_torque,
        };
        assembly.balance.input_power = input_torque * speed;
        (assembly.balance, input_torque)
    }
}

impl System for BearingJoints {
    type Linearisation = DenseLinearisation;

    fn linearisation(&self) -> DenseLinearisation {
        DenseLinearisation::new(self.layout.size())
    }

    fn mass(&self) -> &[f64] {
        &self.mass
    }

    fn scale(&self) -> &[f64] {
        &self.scale
    }

    fn evaluate(&self, time: f64, position: &[f64], velocity: &[f64], force: &mut [f64], linearisation: &mut DenseLinearisation) -> Balance {
        self.evaluate_with_input(time, position, velocity, force, linearisation).0
    }

    fn next_breakpoint(&self, time: f64) -> Option<f64> {
        self.load.next_jump(time)
    }

    fn crank_angle(&self, position: &[f64]) -> f64 {
        position[self.layout.crank_angle(0)]
    }
}

impl Reducer for BearingJoints {
    fn input(&self, time: f64, position: &[f64], velocity: &[f64]) -> (f64, f64) {
        if self.layout.has_free_sun() {
            let sun = self.layout.sun_angle();
            return (position[sun], velocity[sun]);
        }
        self.sun_motion(time)
    }

    fn output(&self, position: &[f64], velocity: &[f64]) -> (f64, f64) {
        (position[self.layout.output()], velocity[self.layout.output()])
    }

    fn ratio(&self) -> f64 {
        self.kinematics.housing_fixed_ratio()
    }

    fn load_torque(&self, time: f64) -> f64 {
        self.load.torque(time)
    }

    fn nominal_position(&self) -> Vec<f64> {
        self.nominal_position_at(0.0)
    }

    fn forces(&self, time: f64, position: &[f64], velocity: &[f64]) -> ForceSummary {
        let (q, v) = self.full(time, position, velocity);
        let mut summary = ForceSummary::default();
        for k in 0..self.meshes.len() {
            summary.mesh_force += self.mesh_state(k, &q, &v).force;
        }
        for disc in 0..self.layout.discs {
            let (pose, rate) = self.disc_state(disc, &q, &v);
            self.rings[disc].visit(pose, rate, false, |contact| {
                if contact.force > 0.0 {
                    summary.loaded_pins += 1;
                    summary.largest_pin_force = summary.largest_pin_force.max(contact.force);
                }
            });
        }
        summary
    }
}
