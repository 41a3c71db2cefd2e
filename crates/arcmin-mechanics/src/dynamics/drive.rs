use serde::{Deserialize, Serialize};

use super::{DynamicsError, GivenMotion, GivenTorque, MotorInput, TimeTable};

/// Drive of the input: a function of time, or values set from outside during the simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Drive {
    /// θ̇_s = ω STEP(t, 0, 0, T, 1): the speed rises smoothly to ω (rad/s) within T (s) and never exceeds it.
    SpeedLaw {
        /// ω in rad/s, counter-clockwise positive.
        speed: f64,
        /// T in s.
        rise_time: f64,
    },
    /// θ_s = ω t STEP(t, 0, 0, T, 1), the law of Tao2024: its speed overshoots to 1.6875 ω at 3T/4.
    AngleLaw {
        /// ω in rad/s, counter-clockwise positive.
        speed: f64,
        /// T in s.
        rise_time: f64,
    },
    /// Speed (rad/s) from a table: ramps, or a measured run.
    SpeedTable(TimeTable),
    /// A motor with free sun: torque (N·m) from a table acts on the inertia of motor and sun.
    TorqueTable(TimeTable),
    /// A motor with free sun whose torque is gain × (reference speed − θ̇_s); gain in N·m·s/rad, reference as
    /// in the speed law.
    Governed {
        /// Reference speed at the end of its rise, rad/s.
        speed: f64,
        /// T of the reference speed in s.
        rise_time: f64,
        /// Torque per difference of speeds, N·m·s/rad.
        gain: f64,
    },
    /// Motion set from outside ([`Simulation::set_motor`](super::Simulation::set_motor)).
    GivenMotion(GivenMotion),
    /// A motor with free sun whose torque is set from outside.
    GivenTorque(GivenTorque),
}

/// Prescribed motion of the input.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct InputMotion {
    /// rad.
    pub angle: f64,
    /// rad/s.
    pub speed: f64,
}

/// Haversine-like cubic step STEP(x, 0, 0, 1, 1) = x² (3 − 2x), its slope and its integral from 0.
fn step(x: f64) -> (f64, f64, f64) {
    if x <= 0.0 {
        (0.0, 0.0, 0.0)
    } else if x >= 1.0 {
        (1.0, 0.0, x - 0.5)
    } else {
        (x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x), x * x * x * (1.0 - 0.5 * x))
    }
}

fn speed_law(speed: f64, rise_time: f64, time: f64) -> InputMotion {
    let (value, _, integral) = step(time / rise_time);
    InputMotion { angle: speed * rise_time * integral, speed: speed * value }
}

impl Drive {
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for speeds, times or gains without meaning.
    pub fn validate(&self) -> Result<(), DynamicsError> {
        let check = DynamicsError::require;
        match *self {
            Drive::SpeedLaw { speed, rise_time }
            | Drive::AngleLaw { speed, rise_time }
            | Drive::Governed { speed, rise_time, .. } => {
                check(speed.is_finite(), "input speed", speed, "rad/s", "must be finite")?;
                check(
                    rise_time > 0.0 && rise_time.is_finite(),
                    "rise time",
                    rise_time,
                    "s",
                    "must be positive",
                )?;
            }
            Drive::SpeedTable(_) | Drive::TorqueTable(_) => {}
            Drive::GivenMotion(motion) => motion.validate("input angle")?,
            Drive::GivenTorque(torque) => torque.validate("motor torque")?,
        }
        if let Drive::Governed { gain, .. } = *self {
            check(gain > 0.0 && gain.is_finite(), "governor gain", gain, "N·m·s/rad", "must be positive")?;
        }
        Ok(())
    }

    /// Whether the sun's angle is a coordinate of the motion rather than prescribed.
    pub fn leaves_sun_free(&self) -> bool {
        matches!(self, Drive::TorqueTable(_) | Drive::Governed { .. } | Drive::GivenTorque(_))
    }

    /// Prescribed angle and speed at `time` (s); zero for a free sun.
    pub fn motion(&self, time: f64) -> InputMotion {
        match self {
            Drive::SpeedLaw { speed, rise_time } => speed_law(*speed, *rise_time, time),
            Drive::AngleLaw { speed, rise_time } => {
                let (value, slope, _) = step(time / rise_time);
                InputMotion { angle: speed * time * value, speed: speed * (value + time / rise_time * slope) }
            }
            Drive::SpeedTable(table) => InputMotion { angle: table.integral(time), speed: table.value(time) },
            Drive::GivenMotion(given) => {
                let (angle, speed) = given.at(time);
                InputMotion { angle, speed }
            }
            Drive::TorqueTable(_) | Drive::Governed { .. } | Drive::GivenTorque(_) => InputMotion::default(),
        }
    }

    /// Input values of this law for an interval that begins at `time` (s) and lasts `interval` (s), for a
    /// simulation with inputs from outside: the angle of a prescribed input with the mean speed of the
    /// interval, or the torque in its middle. `speed` (rad/s) is that of a free input.
    pub fn input(&self, time: f64, interval: f64, speed: f64) -> MotorInput {
        if self.leaves_sun_free() {
            return MotorInput::Torque { torque: self.torque(time + 0.5 * interval, speed).0, rate: 0.0 };
        }
        let (from, to) = (self.motion(time), self.motion(time + interval));
        let acceleration = (to.speed - from.speed) / interval;
        let speed = (to.angle - from.angle) / interval - 0.5 * acceleration * interval;
        MotorInput::Angle { angle: from.angle, speed, acceleration }
    }

    /// Motor torque in N·m on a free sun turning with `speed` (rad/s), and −∂(torque)/∂(speed).
    pub fn torque(&self, time: f64, speed: f64) -> (f64, f64) {
        match self {
            Drive::TorqueTable(table) => (table.value(time), 0.0),
            Drive::GivenTorque(given) => (given.at(time), 0.0),
            Drive::Governed { speed: reference, rise_time, gain } => {
                (gain * (speed_law(*reference, *rise_time, time).speed - speed), *gain)
            }
            _ => (0.0, 0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::DEG;

    #[test]
    fn speed_is_the_derivative_of_the_angle() {
        let table = TimeTable::new("speed", &[(0.0, 0.0), (0.05, 100.0), (0.2, 50.0)]).unwrap();
        let drives = [
            Drive::SpeedLaw { speed: 157.0, rise_time: 0.1 },
            Drive::AngleLaw { speed: 157.0, rise_time: 0.1 },
            Drive::SpeedTable(table),
        ];
        for drive in drives {
            for i in 1..60 {
                let t = 0.00333 * i as f64;
                let h = 1e-6;
                let slope = (drive.motion(t + h).angle - drive.motion(t - h).angle) / (2.0 * h);
                assert!((slope - drive.motion(t).speed).abs() < 1e-2, "{drive:?} {t}");
            }
        }
    }

    /// The angle law of Tao2024, 9000·t·STEP(t, 0, 0, 0.1, 1) degrees, overshoots to 15 187 °/s; the speed
    /// law never exceeds 9000.
    #[test]
    fn val_overshoot_of_the_angle_law() {
        let largest =
            |drive: Drive| (0..=2000).map(|i| drive.motion(1e-4 * i as f64).speed / DEG).fold(0.0, f64::max);
        assert!((largest(Drive::AngleLaw { speed: 9000.0 * DEG, rise_time: 0.1 }) - 15187.5).abs() < 0.1);
        assert!((largest(Drive::SpeedLaw { speed: 9000.0 * DEG, rise_time: 0.1 }) - 9000.0).abs() < 1e-9);
    }
}
