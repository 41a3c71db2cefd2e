//! Accuracy, wear and dynamics of RV (cycloidal) reducers.
//!
//! The data's way through the crate: a design file becomes a [`machine::Machine`] (SI units,
//! invariants hold); [`load`] shares a torque among the pins, [`wear`] removes metal by a law of
//! [`tribology`], [`life`] turns that into accuracy against hours, [`dynamics`] integrates the equations of
//! motion.
//! The crate touches no file, no clock and no terminal.

pub mod analyses;
pub mod checks;
pub mod contact;
pub mod design;
pub mod dynamics;
pub mod exchange;
pub mod fem;
pub mod fidelity;
pub mod geometry;
mod kernels;
pub mod life;
pub mod load;
pub mod machine;
pub mod materials;
pub mod named;
pub mod progress;
#[cfg(test)]
mod property_tests;
pub mod report;
pub mod results;
pub mod rig;
pub mod robot;
pub mod scene;
pub mod study;
pub mod tables;
pub mod templates;
pub mod tribology;
pub mod units;
pub mod wear;

#[cfg(test)]
extern crate self as arcmin;
/// Random sound designs, which speak of this crate by its name.
#[cfg(test)]
#[allow(dead_code)]
#[path = "../tests/support/mod.rs"]
mod random_designs;

/// Examples of the README and of the book, run as tests.
#[cfg(doctest)]
mod book {
    #[doc = include_str!("../../../README.md")]
    mod readme {}
    #[doc = include_str!("../../../docs/src/tutorial.md")]
    mod tutorial {}
    #[doc = include_str!("../../../docs/src/extending.md")]
    mod extending {}
}
