//! Accuracy, wear and dynamics of RV (cycloidal) reducers.
//!
//! Flow of data: a design file becomes a [`machine::Machine`] (SI units,
//! invariants hold); [`load`] shares a torque among the pins, [`wear`] removes metal by a law of
//! [`tribology`], [`life`] turns that into accuracy against hours, [`dynamics`] integrates the equations of
//! motion.
//! The crate uses no files, no clock and no terminal.

#![deny(missing_docs)]

pub use arcmin_mechanics::{
    checks, contact, design, dynamics, fem, geometry, load, machine, materials, named, progress, rig, tables,
    templates, tribology, units, wear,
};

pub mod analyses;
pub mod exchange;
pub mod fidelity;
pub mod life;
pub mod report;
pub mod results;
pub mod robot;
pub mod scene;
pub mod study;

#[cfg(test)]
extern crate self as arcmin;
/// Random sound designs. Their code is shared with the integration tests and names this crate `arcmin`.
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
