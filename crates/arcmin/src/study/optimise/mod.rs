//! The search for the best design: [`CmaEs`] for one goal, [`Nsga2`] for two or more.
//!
//! Both are asked for a generation and told what it gave, in the unit cube. A generation depends on the state
//! alone, and the state is a value that can be written down: a search goes on where it stopped, and a
//! generation is sharded like any other rows. The crates that exist (`cmaes`, `moors`) call the goal function
//! themselves and cannot be stopped and resumed in between.

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
    /// To be made small; empty for a design that could not be computed.
    pub goals: Vec<f64>,
    /// How far each constraint is exceeded, in units that make them comparable; ≤ 0 where it is kept.
    pub constraints: Vec<f64>,
}

impl Outcome {
    /// A design that could not be computed is worse than any that could.
    pub fn failed() -> Outcome {
        Outcome { goals: Vec::new(), constraints: Vec::new() }
    }

    /// Sum of what is exceeded; infinite for a failure and for what is not a finite number (a life without
    /// end needs a number to be compared by).
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

    /// The better one is less, in the order of Deb (2000): kept constraints before broken ones, then the goals, the
    /// first one first, or what is broken least.
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
