//! A joint as the arm feels it: what its output is off at every age.

use crate::exchange::{JointExport, JointState, RunningFriction, TransmissionWaves};

use super::memory::Loop;

/// The reducer after some hours in motion.
#[derive(Debug, Clone)]
pub struct AgedJoint {
    /// In motion.
    pub hours: f64,
    /// Wind-up over torque with the memory of its hysteresis.
    pub curve: Loop,
    /// Torque on the output from outside (N·m), rising, each with the waves measured under it.
    waves: Vec<(f64, TransmissionWaves)>,
    /// As `rig` measures it, rad.
    pub lost_motion: f64,
    /// N·m/rad.
    pub stiffness: f64,
    /// Friction while the joint turns.
    pub friction: RunningFriction,
}

impl AgedJoint {
    /// `None` where the loop of the bench is no loop.
    pub fn of(state: &JointState, rated: f64) -> Option<AgedJoint> {
        // A torque against the motion is from outside, against its direction.
        let mut waves: Vec<(f64, TransmissionWaves)> = state
            .transmission_error
            .iter()
            .map(|waves| (-waves.direction * waves.torque_n_m, waves.clone()))
            .collect();
        waves.sort_by(|a, b| a.0.total_cmp(&b.0));
        Some(AgedJoint {
            hours: state.hours,
            curve: Loop::new(&state.torsion_loop, rated)?,
            waves,
            lost_motion: state.lost_motion_rad,
            stiffness: state.stiffness_n_m_per_rad,
            friction: state.friction,
        })
    }

    /// Torques on the output from outside in N·m, each with the waves measured under it.
    pub fn waves(&self) -> &[(f64, TransmissionWaves)] {
        &self.waves
    }

    /// Transmission error without its mean in rad at an output angle (rad) under a torque on the output from outside
    /// (N·m): between the curves measured, which tell the flanks apart that carry.
    pub fn transmission_error(&self, angle: f64, torque: f64) -> f64 {
        let upper = self.waves.partition_point(|(at, _)| *at < torque);
        match (upper.checked_sub(1).map(|i| &self.waves[i]), self.waves.get(upper)) {
            (Some((low, below)), Some((high, above))) => {
                let share = (torque - low) / (high - low);
                (1.0 - share) * below.at(angle) + share * above.at(angle)
            }
            (Some((_, one)), None) | (None, Some((_, one))) => one.at(angle),
            (None, None) => 0.0,
        }
    }
}

/// How the output leans in its bearings under a moment.
#[derive(Debug, Clone, PartialEq)]
pub enum Leaning {
    /// The output does not lean.
    Rigid,
    /// N·m/rad.
    Stiffness(f64),
    /// Moment in N·m and tilt in rad, both rising from 0.
    Curve(Vec<(f64, f64)>),
}

impl Leaning {
    /// Tilt in rad under a moment in N·m.
    pub fn tilt(&self, moment: f64) -> f64 {
        match self {
            Leaning::Rigid => 0.0,
            Leaning::Stiffness(stiffness) => moment / stiffness,
            Leaning::Curve(points) => {
                let last = points.len() - 1;
                let upper = points.partition_point(|(at, _)| *at <= moment).clamp(1, last);
                let ((a, low), (b, high)) = (points[upper - 1], points[upper]);
                low + (moment - a) / (b - a) * (high - low)
            }
        }
    }
}

/// The reducer of an axis over its life.
#[derive(Debug, Clone)]
pub struct JointModel {
    /// Name of the axis.
    pub axis: String,
    /// Name of its design.
    pub design: String,
    /// Turns of the input for one turn of the output; negative if they turn in opposite directions.
    pub ratio: f64,
    /// N·m.
    pub rated: f64,
    /// The youngest first.
    pub ages: Vec<AgedJoint>,
    /// Tilt of the output under the moment of the load.
    pub leaning: Leaning,
    /// Middle of its bearings along the axis from the origin of the link, m.
    pub bearings: f64,
    /// N·m between output and member at rest.
    pub drag: f64,
    /// kg·m² at the input.
    pub motor_inertia: f64,
    /// Output angle in rad where the joint's angle is 0.
    pub offset: f64,
}

impl JointModel {
    /// Ages from an export; `None` for an age whose loop is none.
    pub fn ages_of(export: &JointExport) -> Option<Vec<AgedJoint>> {
        export.states.iter().map(|state| AgedJoint::of(state, export.rated_torque_n_m)).collect()
    }

    /// Torque of the motor in N·m at its own shaft for a torque at the link (N·m), speed (rad/s) and acceleration
    /// (rad/s²) of the joint: friction of the running reducer, and what speeds up the rotor.
    pub fn motor_torque(&self, torque: f64, speed: f64, acceleration: f64) -> f64 {
        let friction = self.ages.first().map(|age| age.friction);
        let sign = if speed < 0.0 { -1.0 } else { 1.0 };
        let along = match friction {
            Some(f) if speed != 0.0 => {
                let own = torque * sign + f.coulomb_n_m + f.viscous_n_m_s_per_rad * speed.abs();
                // τ_f = c + v |ω| + μ |τ| + δ τ with the motor's torque τ along the motion.
                let part = if own >= 0.0 {
                    1.0 - f.load_mean - f.load_difference
                } else {
                    1.0 + f.load_mean - f.load_difference
                };
                sign * own / part
            }
            _ => torque,
        };
        along / self.ratio + self.motor_inertia * self.ratio * acceleration
    }

    /// A figure after these hours in motion, between the ages measured.
    pub fn between(&self, hours: f64, of: impl Fn(&AgedJoint) -> f64) -> f64 {
        let measured: Vec<f64> = self.ages.iter().map(|age| age.hours).collect();
        let ([a, b], share) = neighbours(&measured, hours);
        let (a, b) = (of(&self.ages[a]), of(&self.ages[b]));
        a + share * (b - a)
    }
}

/// The two ages (h, rising) between which these hours lie, and their share of the way from the one to the other. Beyond
/// the last age, where a variant wears faster, it goes on as between the last two; a single age stands for all.
pub(super) fn neighbours(ages: &[f64], hours: f64) -> ([usize; 2], f64) {
    let upper = ages.partition_point(|age| *age <= hours * (1.0 + 1e-12)).min(ages.len() - 1);
    match upper.checked_sub(1) {
        None => ([0, 0], 0.0),
        Some(lower) => ([lower, upper], (hours - ages[lower]) / (ages[upper] - ages[lower])),
    }
}
