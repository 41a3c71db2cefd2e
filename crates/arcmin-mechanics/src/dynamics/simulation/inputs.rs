//! Motor and load of a simulation, set from the present time.

use super::Simulation;
use crate::dynamics::{
    Drive, DynamicsError, GivenMotion, GivenTorque, LoadInput, MotorInput, OutputLoad, Reducer,
};

impl Simulation {
    /// Sets the motor from the present time.
    ///
    /// # Errors
    /// [`DynamicsError::WrongInput`] for a motion if the model has a free input, or a torque if it has none;
    /// [`DynamicsError::InvalidValue`] for numbers that are not finite.
    pub fn set_motor(&mut self, input: MotorInput) -> Result<(), DynamicsError> {
        let since = self.time;
        let Some(old) = self.model().drive() else {
            return Err(DynamicsError::WrongInput { reason: "the input of this model is held" });
        };
        let free = old.leaves_sun_free();
        let motion = |angle: f64, speed: f64, acceleration: f64| match old {
            // A continuation of the same motion is not a change.
            Drive::GivenMotion(old) if continues_motion(old, since, angle, speed, acceleration) => {
                Drive::GivenMotion(*old)
            }
            _ => Drive::GivenMotion(GivenMotion { since, angle, speed, acceleration }),
        };
        let new = match input {
            MotorInput::Torque { torque, rate } if free => match old {
                Drive::GivenTorque(old) if continues_torque(old, since, torque, rate) => {
                    Drive::GivenTorque(*old)
                }
                _ => Drive::GivenTorque(GivenTorque { since, torque, rate }),
            },
            MotorInput::Angle { angle, speed, acceleration } if !free => motion(angle, speed, acceleration),
            MotorInput::Speed { speed, acceleration } if !free => {
                motion(old.motion(since).angle, speed, acceleration)
            }
            MotorInput::Torque { .. } => {
                return Err(DynamicsError::WrongInput {
                    reason: "the motion of the motor is prescribed; build the model with Drive::GivenTorque",
                });
            }
            _ => {
                return Err(DynamicsError::WrongInput {
                    reason: "the torque of the motor is prescribed; build the model with Drive::GivenMotion",
                });
            }
        };
        new.validate()?;
        if new == *old {
            return Ok(());
        }
        self.return_to_present()?;
        let before = self.integrator.state().energy.current;
        self.integrator.system_mut().set_drive(new);
        self.integrator.restart()?;
        let work = self.integrator.state().energy.current - before;
        self.integrator.book(work, 0.0);
        Ok(())
    }

    /// Sets the torque or motion of the output from the present time.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for numbers that are not finite.
    pub fn set_load(&mut self, input: LoadInput) -> Result<(), DynamicsError> {
        let since = self.time;
        let old = self.model().output_load();
        let motion = |angle: f64, speed: f64, acceleration: f64| match old {
            OutputLoad::GivenMotion(old) if continues_motion(old, since, angle, speed, acceleration) => {
                OutputLoad::GivenMotion(*old)
            }
            _ => OutputLoad::GivenMotion(GivenMotion { since, angle, speed, acceleration }),
        };
        let new = match input {
            LoadInput::Torque { torque, rate } => match old {
                OutputLoad::GivenTorque(old) if continues_torque(old, since, torque, rate) => {
                    OutputLoad::GivenTorque(*old)
                }
                _ => OutputLoad::GivenTorque(GivenTorque { since, torque, rate }),
            },
            LoadInput::Angle { angle, speed, acceleration } => motion(angle, speed, acceleration),
            LoadInput::Speed { speed, acceleration } => {
                let angle =
                    old.motion().map_or_else(|| self.node().output(self.model()).0, |m| m.at(since).0);
                motion(angle, speed, acceleration)
            }
        };
        new.validate()?;
        if new == *old {
            return Ok(());
        }
        self.return_to_present()?;
        let before = self.integrator.state().energy.current;
        let output = self.model().output_index();
        if let Some((angle, speed)) = new.motion().map(|motion| motion.at(since)) {
            self.integrator.displace(output, angle, speed);
        }
        self.integrator.system_mut().set_output_load(new);
        self.integrator.restart()?;
        let work = self.integrator.state().energy.current - before;
        self.integrator.book(0.0, -work);
        Ok(())
    }
}

/// Whether a torque set now continues the old one.
fn continues_torque(old: &GivenTorque, now: f64, torque: f64, rate: f64) -> bool {
    old.at(now) == torque && old.rate == rate
}

/// The same for a motion.
fn continues_motion(old: &GivenMotion, now: f64, angle: f64, speed: f64, acceleration: f64) -> bool {
    old.at(now) == (angle, speed) && old.acceleration == acceleration
}
