//! Studies: many machines instead of one.
//!
//! [`sampling`] places the samples in the space of the varied keys; sample k depends on (seed, k) only, so that any
//! sharding gives the same rows. [`statistics`] computes quantiles, yield and lives from the rows, always with
//! confidence intervals; [`sensitivity`] computes the influence of the keys; [`optimise`] searches for the best
//! design, one generation at a time.
//!
//! Bits: the streams of random numbers and the places in the unit cube are made of integer and correctly
//! rounded operations, the same on every processor. Values of normal and log-uniform distributions, and all
//! physics, go through logarithms and sines of the system's library, whose last bit may differ from one
//! system to another.

pub mod band;
mod collect;
mod compute;
pub mod distribution;
#[cfg(test)]
mod engine_tests;
mod error;
pub mod file;
pub mod judge;
pub mod limits;
mod list_place;
pub mod optimise;
pub mod page;
pub mod part;
mod plan;
mod run;
pub mod sampling;
pub mod search;
pub mod sensitivity;
pub mod statistics;
mod stream;
pub mod templates;

pub use collect::{Rows, collect};
pub use distribution::{Distribution, Value};
pub use error::StudyError;
pub use file::{Batches, Study, StudyFile};
pub use part::{Cell, Record};
pub use plan::{Factor, Kept, Kind, Plan, Row, Setting};
pub use run::{Compute, Done, Memory, RowError, Shard, Store, Watch, run};
#[cfg(test)]
pub(crate) use stream::Stream;
pub(crate) use stream::{Purpose, hash};
