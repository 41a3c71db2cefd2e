//! The search for the best design: [`CmaEs`] for one goal, [`Nsga2`] for two or more.
//!
//! Both give the points of a generation in the unit cube and receive its outcomes. A generation depends only on the
//! state, which can be stored: a search continues where it stopped, and a generation is sharded like any other rows.
//! Existing crates (`cmaes`, `moors`) call the goal function internally and cannot be stopped and resumed between generations.

mod cma;
mod nsga2;
#[cfg(test)]
mod tests;

pub use cma::CmaEs;
pub use nsga2::Nsga2;

use std::cmp::Ordering;

use serde::{Deserialize, Serialize};

/// Results of one design.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Goals to be minimised; empty for a design that could not be computed.
    pub goals: Vec<f64>,
    /// Excess of each constraint in comparable units; ≤ 0 if it is kept.
    pub constraints: Vec<f64>,
}

impl Outcome {
    /// A design that could not be computed is worse than any that could.
    pub fn failed() -> Outcome {
        Outcome { goals: Vec::new(), constraints: Vec::new() }
    }

    /// Sum of the excesses; infinite for a failure and for values that are not finite (a life beyond the search must be
    /// given as a number).
    pub fn violation(&self) -> f64 {
        let sum: f64 = self.constraints.iter().map(|c| if *c <= 0.0 { 0.0 } else { *c }).sum();
        if self.goals.is_empty() || sum.is_nan() || self.goals.iter().any(|g| !g.is_finite()) {
            f64::INFINITY
        } else {
            sum
        }
    }

    /// Whether it was computed and keeps all constraints.
    pub fn is_feasible(&self) -> bool {
        self.violation() == 0.0
    }

    /// Order of Deb (2000), better designs first: designs that keep their constraints by their goals, then the others by their
    /// excess.
    pub fn compare(&self, other: &Outcome) -> Ordering {
        let goals = || match self.goals.partial_cmp(&other.goals) {
            Some(order) if self.is_feasible() => order,
            _ => Ordering::Equal,
        };
        self.violation().total_cmp(&other.violation()).then_with(goals)
    }
}

/// A place outside the unit interval mirrored back into it, as often as needed.
fn mirrored(x: f64) -> f64 {
    let folded = x.rem_euclid(2.0);
    if folded <= 1.0 { folded } else { 2.0 - folded }
}
