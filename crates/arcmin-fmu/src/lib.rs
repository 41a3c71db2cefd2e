//! The shared library inside of arcmin's FMUs: co-simulation by FMI 2.0 and 3.0, every function of the headers.
//!
//! It reads the design and its maps from the unit's resources, keeps all state in the instance, and lets no
//! panic cross the interface: the instance then refuses further calls.

// C decides what comes in: every function of the interface takes raw pointers, and its name is not ours.
#![allow(non_snake_case, clippy::missing_safety_doc)]

mod fmi2;
mod fmi3;
mod instance;
mod plant;
mod raw;
#[cfg(test)]
mod tests;
