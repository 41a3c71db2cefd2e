use serde::{Deserialize, Serialize};

use super::{Balance, DenseLinearisation, DynamicsError};

/// A torque set from outside at one instant: torque + rate × (t − since).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct GivenTorque {
    /// s.
    pub since: f64,
    /// N·m.
    pub torque: f64,
    /// N·m/s.
    pub rate: f64,
}

impl GivenTorque {
    /// Constant from time 0.
    pub fn constant(torque: f64) -> GivenTorque {
        GivenTorque { torque, ..GivenTorque::default() }
    }

    /// Torque in N·m at a time in s.
    pub fn at(&self, time: f64) -> f64 {
        self.torque + self.rate * (time - self.since)
    }

    pub(super) fn validate(&self, name: &'static str) -> Result<(), DynamicsError> {
        let finite = self.since.is_finite() && self.torque.is_finite() && self.rate.is_finite();
        DynamicsError::require(finite, name, self.torque, "N·m", "must be finite, and so must its rate")
    }
}

/// A motion set from outside at one instant: angle + speed × x + acceleration × x²/2 with x = t − since.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct GivenMotion {
    /// s.
    pub since: f64,
    /// rad.
    pub angle: f64,
    /// rad/s.
    pub speed: f64,
    /// rad/s².
    pub acceleration: f64,
}

impl GivenMotion {
    /// Angle in rad and speed in rad/s.
    pub fn at(&self, time: f64) -> (f64, f64) {
        let x = time - self.since;
        (self.angle + x * (self.speed + 0.5 * self.acceleration * x), self.speed + self.acceleration * x)
    }

    pub(super) fn validate(&self, name: &'static str) -> Result<(), DynamicsError> {
        let finite = [self.since, self.angle, self.speed, self.acceleration].iter().all(|x| x.is_finite());
        DynamicsError::require(finite, name, self.angle, "rad", "must be finite, and so must its rates")
    }

    /// The same angle, at rest.
    pub(super) fn stopped(&self) -> GivenMotion {
        GivenMotion { speed: 0.0, acceleration: 0.0, ..*self }
    }

    /// Prescribes this motion for an output with the moment of inertia `inertia` (kg·m²). The torque of the
    /// machine in excess of that of the output's acceleration is transmitted to the outside. If there is a
    /// linearisation, the column of the coordinate in it is set as well.
    pub(super) fn impose(
        &self,
        time: f64,
        coordinate: usize,
        inertia: f64,
        force: &mut [f64],
        linearisation: Option<(&mut DenseLinearisation, usize)>,
        balance: &mut Balance,
    ) {
        let own = inertia * self.acceleration;
        balance.load_torque = force[coordinate] - own;
        balance.load_power = balance.load_torque * self.at(time).1;
        force[coordinate] = own;
        if let Some((linearisation, column)) = linearisation {
            linearisation.hold(column);
        }
    }
}

/// Input values set from outside, valid from the present time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum MotorInput {
    /// The input continues from its present angle at this speed (rad/s) and acceleration (rad/s²).
    Speed {
        /// rad/s, counter-clockwise positive.
        speed: f64,
        /// rad/s².
        acceleration: f64,
    },
    /// The input is set to this angle (rad) and continues from there. An angle different from the present one
    /// is a jump, which the contacts follow immediately.
    Angle {
        /// rad, counter-clockwise positive.
        angle: f64,
        /// rad/s.
        speed: f64,
        /// rad/s².
        acceleration: f64,
    },
    /// A motor torque (N·m) and its rate (N·m/s), on the inertia of motor and sun.
    Torque {
        /// N·m, counter-clockwise positive.
        torque: f64,
        /// N·m/s.
        rate: f64,
    },
}

/// Output values set from outside, valid from the present time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum LoadInput {
    /// A torque (N·m), positive against positive motion, and its rate (N·m/s).
    Torque {
        /// N·m, positive against positive motion.
        torque: f64,
        /// N·m/s.
        rate: f64,
    },
    /// The output continues from its present angle at this speed (rad/s) and acceleration (rad/s²); its torque
    /// is a result.
    Speed {
        /// rad/s, counter-clockwise positive.
        speed: f64,
        /// rad/s².
        acceleration: f64,
    },
    /// The output is set to this angle (rad) and continues from there.
    Angle {
        /// rad, counter-clockwise positive.
        angle: f64,
        /// rad/s.
        speed: f64,
        /// rad/s².
        acceleration: f64,
    },
}
