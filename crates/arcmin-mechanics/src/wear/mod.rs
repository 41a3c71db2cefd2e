//! Wear of flanks and pins by a local law.
//!
//! At a point of the flank dh/dt = k · rate while the contact passes over it, with the rate of one of the laws
//! of [`tribology`](crate::tribology). For Archard's law, integrated over one pass, this is Δh = k (F/B) ξ with
//! the specific sliding ξ = |v_s|/|v_c|. [`paper`] is the study of Tao2024 (one uniform depth); in [`coupled`]
//! the worn flank changes the load sharing.

pub mod calibrate;
mod case;
pub mod coupled;
mod deposit;
mod error;
mod exposure;
mod growth;
pub mod paper;
pub mod parts;
mod readings;
mod smoothing;

pub use case::WearCase;
pub use coupled::depth_past_use;
pub use coupled::{CoupledOptions, CoupledWear, WearSnapshot};
pub use deposit::FlankArc;
pub use error::WearError;
pub use exposure::Exposure;
pub use growth::{Beyond, GrowingDrive, GrowingRing, Grown, Growth, Target};
pub use parts::PartLoads;
pub use readings::{
    CONFIDENCE, Estimate, Fit, FitPlan, Measured, Model, New, Parameter, Reading, Readings, RunningInFit,
    Truth, fit_readings, follow_and_fit,
};

#[cfg(test)]
mod error_tests;
#[cfg(test)]
mod tests;
