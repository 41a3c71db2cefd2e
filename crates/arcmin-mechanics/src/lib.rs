//! Mechanics of cycloidal reducers: the lower half of the library `arcmin`, which hands all of it on.
//!
//! A design file becomes a [`machine::Machine`] (SI units, invariants hold); [`load`] shares a torque among the pins,
//! [`wear`] removes metal by a law of [`tribology`], [`fem`] gives the compliance of elastic bodies, [`dynamics`] finds
//! static equilibria and integrates the equations of motion, [`rig`] measures the machine on a virtual test bench.
//! The crate touches no file, no clock and no terminal.

#![deny(missing_docs)]

pub mod checks;
pub mod contact;
pub mod design;
pub mod dynamics;
pub mod fem;
pub mod geometry;
mod kernels;
pub mod load;
pub mod machine;
pub mod materials;
pub mod named;
pub mod progress;
#[cfg(test)]
mod property_tests;
pub mod rig;
pub mod tables;
pub mod templates;
pub mod tribology;
pub mod units;
pub mod wear;

/// Random valid designs; they refer to the library by its public name.
#[cfg(test)]
extern crate self as arcmin;
#[cfg(test)]
#[allow(dead_code)]
#[path = "../../arcmin/tests/support/mod.rs"]
mod random_designs;

/// Examples of the package's first page, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
