//! Model of a joint for the arm: errors of its output at every age.

use crate::exchange::{JointExport, JointState, RunningFriction, TransmissionWaves};

use super::memory::Loop;

/// The reducer after some hours in motion.
#[derive(Debug, Clone)]
pub struct AgedJoint {
    /// Age in hours in motion.
    pub hours: f64,
    /// Wind-up against torque with hysteresis and memory.
    pub curve: Loop,
    /// External torques on the output (N·m), increasing, with the waves of the transmission error under each.
    waves: Vec<(f64, TransmissionWaves)>,
    /// Lost motion as computed by `rig`, rad.
    pub lost_motion: f64,
    /// Torsional stiffness, N·m/rad.
    pub stiffness: f64,
    /// Friction during motion.
    pub friction: RunningFriction,
}

impl AgedJoint {
    /// `None` if the result of the test bench is not a loop.
    pub fn of(state: &JointState, rated: f64) -> Option<AgedJoint> {
        // A torque against the motion has the sign opposite to its direction.
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

    /// External torques on the output in N·m, with the waves of the transmission error under each.
    pub fn waves(&self) -> &[(f64, TransmissionWaves)] {
        &self.waves
    }

    /// Transmission error without its mean in rad at an output angle (rad) under an external torque on the
    /// output (N·m): interpolated between the computed curves, which depend on the loaded flanks.
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

/// Tilt of the output in its bearings under a moment.
#[derive(Debug, Clone, PartialEq)]
pub enum Leaning {
    /// No tilt.
    Rigid,
    /// Moment stiffness, N·m/rad.
    Stiffness(f64),
    /// Moments in N·m and tilts in rad, both increasing from 0.
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
    /// Rated torque, N·m.
    pub rated: f64,
    /// The reducer at its ages, in increasing order.
    pub ages: Vec<AgedJoint>,
    /// Tilt of the output under the moment of the load.
    pub leaning: Leaning,
    /// Position of the middle of its bearings along the axis from the origin of the link, m.
    pub bearings: f64,
    /// Drag between output and fixed member, N·m.
    pub drag: f64,
    /// Moment of inertia at the input, kg·m².
    pub motor_inertia: f64,
    /// Output angle in rad at a joint angle of 0.
    pub offset: f64,
}

impl JointModel {
    /// Ages from an export; `None` if the loop of an age is not a loop.
    pub fn ages_of(export: &JointExport) -> Option<Vec<AgedJoint>> {
        export.states.iter().map(|state| AgedJoint::of(state, export.rated_torque_n_m)).collect()
    }

    /// Torque of the motor in N·m at its own shaft for a torque at the link (N·m), speed (rad/s) and
    /// acceleration (rad/s²) of the joint, including friction of the running reducer and the acceleration of
    /// the rotor.
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

    /// A quantity at an age in hours in motion, interpolated between the computed ages.
    pub fn between(&self, hours: f64, of: impl Fn(&AgedJoint) -> f64) -> f64 {
        let measured: Vec<f64> = self.ages.iter().map(|age| age.hours).collect();
        let ([a, b], share) = neighbours(&measured, hours);
        let (a, b) = (of(&self.ages[a]), of(&self.ages[b]));
        a + share * (b - a)
    }
}

/// The two ages (h, increasing) between which these hours lie, and the fraction of the interval. Beyond the
/// last age, for variants with faster wear, the last interval is extrapolated; a single age is used for all
/// hours.
pub(super) fn neighbours(ages: &[f64], hours: f64) -> ([usize; 2], f64) {
    let upper = ages.partition_point(|age| *age <= hours * (1.0 + 1e-12)).min(ages.len() - 1);
    match upper.checked_sub(1) {
        None => ([0, 0], 0.0),
        Some(lower) => ([lower, upper], (hours - ages[lower]) / (ages[upper] - ages[lower])),
    }
}
