//! Wear of flanks and pins by Archard's law.
//!
//! A point of the flank loses dh/dt = k p |v_s| while the contact passes over it; integrated over one pass
//! this is Δh = k (F/B) ξ with the specific sliding ξ = |v_s|/|v_c|: the half-width cancels. [`paper`] is the
//! study of Tao2024 (one uniform depth), [`coupled`] lets the worn flank change the load sharing.

pub mod calibrate;
pub mod coupled;
mod deposit;
mod exposure;
mod film;
pub mod paper;
pub mod parts;
mod smoothing;

pub use coupled::{CoupledOptions, CoupledWear, WearError, WearSnapshot};
pub use deposit::FlankArc;
pub use exposure::Exposure;
pub use film::film_ratio;
pub use parts::PartLoads;

#[cfg(test)]
mod error_tests;
#[cfg(test)]
mod tests;
