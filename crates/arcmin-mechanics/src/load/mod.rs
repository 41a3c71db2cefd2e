//! Sharing a torque among the pins.
//!
//! [`closed_form`] is the handbook method of Tao2024 (eqs. 5–10); [`Meshing`] solves for static equilibrium,
//! with the real gaps, both flanks and any number of discs.

pub mod closed_form;
mod cycle;
mod equilibrium;
mod flexible;
mod gap_model;
mod share;
mod travel;

pub use cycle::{Cycle, CycleContact, FlankForce, HarmonicError, PinLoad};
#[cfg(test)]
mod preload_tests;
#[cfg(test)]
mod tests;

pub use equilibrium::{FreeTravel, LoadError, LoadSharing, Meshing, Preload};
pub use flexible::FlexibleMeshing;
pub(crate) use share::turn_position;
pub use share::{LOST_MOTION_SHARE, ShareLoad, lost_motion};
