//! The shared library in arcmin's FMUs: co-simulation by FMI 2.0 and 3.0, with every function of the headers.
//!
//! The library reads the design and its maps from the unit's resources and stores all state in the instance. Panics are
//! caught at the interface; after a panic the instance refuses further calls.

// The interface is defined in C: every function takes raw pointers, and its name is given.
#![allow(non_snake_case, clippy::missing_safety_doc)]

mod fmi2;
mod fmi3;
mod instance;
mod plant;
mod raw;
#[cfg(test)]
mod tests;
