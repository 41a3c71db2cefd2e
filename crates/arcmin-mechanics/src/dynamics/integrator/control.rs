use serde::{Deserialize, Serialize};

use crate::dynamics::DynamicsError;

/// Parameters of the step size control.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StepControl {
    /// Local error per step, in units of [`System::scale`](crate::dynamics::System::scale).
    pub tolerance: f64,
    /// Constant step in s instead of error control. Steps still end at breakpoints.
    pub fixed_step: Option<f64>,
    /// First step, s.
    pub first_step: f64,
    /// Largest step, s.
    pub largest_step: f64,
    /// Smallest step, s; if a shorter one would be needed, the integration fails.
    pub smallest_step: f64,
    /// s: an error of velocity counts as the error of position that it causes over this time (or over the step,
    /// if longer).
    pub velocity_time: f64,
    /// ρ∞ of the generalised-α method in [0, 1]: ratio of amplitudes per step for motions much faster than the
    /// step. 1 is the trapezoidal rule.
    pub spectral_radius: f64,
}

impl Default for StepControl {
    fn default() -> Self {
        StepControl {
            tolerance: 5e-5,
            fixed_step: None,
            first_step: 1e-7,
            largest_step: 1e-4,
            smallest_step: 1e-13,
            velocity_time: 1e-4,
            spectral_radius: 0.9,
        }
    }
}

impl StepControl {
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for steps and tolerances that are not positive or not consistent.
    pub fn validate(&self) -> Result<(), DynamicsError> {
        let check = DynamicsError::require;
        check(
            self.tolerance > 0.0 && self.tolerance < 1.0,
            "tolerance",
            self.tolerance,
            "",
            "must lie between 0 and 1",
        )?;
        check(self.smallest_step > 0.0, "smallest step", self.smallest_step, "s", "must be positive")?;
        check(
            self.largest_step > self.smallest_step && self.largest_step.is_finite(),
            "largest step",
            self.largest_step,
            "s",
            "must exceed the smallest",
        )?;
        check(
            self.first_step >= self.smallest_step,
            "first step",
            self.first_step,
            "s",
            "must not be below the smallest",
        )?;
        check(
            (0.0..=1.0).contains(&self.spectral_radius),
            "spectral radius",
            self.spectral_radius,
            "",
            "must lie between 0 and 1",
        )?;
        if let Some(step) = self.fixed_step {
            check(
                step > self.smallest_step && step.is_finite(),
                "fixed step",
                step,
                "s",
                "must be positive and above the smallest step",
            )?;
        }
        Ok(())
    }
}
