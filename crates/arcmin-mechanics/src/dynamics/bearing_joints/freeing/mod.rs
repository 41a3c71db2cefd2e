//! The relief that removes the load of a machine whose pins interfere with the flanks, from the positions of
//! the bodies that the gaps allow without forces.

mod quadratic_program;

use self::quadratic_program::{Limits, Penalties};
use super::{BearingJoints, BearingMeshing};
use crate::dynamics::System;
use crate::dynamics::mechanism::{Distance, Limit, PIN};
use crate::machine::CrankAngle;

/// Remaining decrease of the cost at which a search ends, in units of the system's scale: 1e-12 m.
const TOLERANCE: f64 = 1e-7;
/// Decrease that may be missed because of the error of the gaps' gradients: 1e-10 m.
const NOISE: f64 = 1e-5;
/// Penalty of an overlap of a pin by one unit, about 12 µm, in units of relief. Pins with at most the load of
/// about 1e-5 of the rated torque count as unloaded; the same compliance of the joints allows for errors that
/// cause load even without pins.
const LIMIT: f64 = 2e4;
/// Penalty of a step: ½ ρ |d|². Initial and smallest value.
const STEP_PENALTY: (f64, f64) = (1e-3, 1e-5);
/// Ratio of actual to predicted decrease below which a step is rejected.
const KEPT: f64 = 0.1;
const MOST_STEPS: usize = 20;
/// Gaps below this value (m) are included as constraints.
const WINDOW: f64 = 150e-6;

/// The constraints linearised at one position, in units of the system's scale.
struct Linear {
    limits: Limits,
    /// Relief at which the position has the smallest cost, and that cost.
    relief: f64,
    cost: f64,
}

/// Constraints of one kind, row by row, and the remaining gap of each.
#[derive(Default)]
struct Rows {
    slopes: Vec<f64>,
    values: Vec<f64>,
}

/// State of a search for the position of smallest relief.
struct Search<'a> {
    model: &'a BearingJoints,
    /// Column of every free coordinate; `None` for held ones.
    columns: Vec<Option<usize>>,
    width: usize,
    /// Unit of lengths in m.
    unit: f64,
}

impl<'a> Search<'a> {
    fn new(model: &'a BearingJoints, start: &[f64]) -> Search<'a> {
        let layout = &model.layout;
        let mut columns = vec![Some(0); layout.size()];
        let (place, _) = model.full(0.0, start, &vec![0.0; start.len()]);
        for joint in model.elements() {
            joint.limits(&place, WINDOW, &mut |limit| {
                if let Limit::Held(at) = limit {
                    columns[at] = None;
                }
            });
        }
        let mut width = 0;
        for column in columns.iter_mut().flatten() {
            *column = width;
            width += 1;
        }
        let unit = model.scale()[layout.disc(0)];
        Search { model, columns, width: width + 1, unit }
    }

    /// A distance in units, weighted by its stiffness relative to that of a pin, and its gradient over the
    /// columns.
    fn row(&self, distance: &Distance<'_>, rows: &mut Rows) {
        let weight = (distance.stiffness / PIN).sqrt() / self.unit;
        let start = rows.slopes.len();
        rows.slopes.resize(start + self.width, 0.0);
        for (at, slope) in distance.index.iter().zip(distance.gradient) {
            if let Some(Some(column)) = self.columns.get(*at) {
                rows.slopes[start + column] += weight * slope * self.model.scale()[*at];
            }
        }
        rows.values.push(weight * distance.value);
    }

    fn linear(&self, position: &[f64]) -> Linear {
        let (q, _) = self.model.full(0.0, position, &vec![0.0; position.len()]);
        let [mut held, mut gaps, mut pins] = [(); 3].map(|()| Rows::default());
        for joint in self.model.elements() {
            joint.limits(&q, WINDOW, &mut |limit| match limit {
                Limit::Held(_) => {}
                Limit::Bond(distance) => self.row(&distance, &mut held),
                Limit::Gap(distance) => self.row(&distance, &mut gaps),
                Limit::Pin(distance) => {
                    self.row(&distance, &mut pins);
                    // The relief is the last column.
                    if let Some(last) = pins.slopes.last_mut() {
                        *last = 1.0;
                    }
                }
            });
        }
        let relief = cheapest_relief(&pins.values);
        let (bonds, joints) = (held.values.len(), held.values.len() + gaps.values.len());
        let values = [held.values, gaps.values, pins.values].concat();
        let all = [held.slopes, gaps.slopes, pins.slopes].concat();
        let bounds = values.iter().map(|value| -value).collect();
        let limits = Limits { width: self.width, bonds, rows: all, bounds };
        let rooms = values.iter().enumerate().map(|(i, room)| room + if i < joints { 0.0 } else { relief });
        let cost = limits.cost(rooms, LIMIT) + relief;
        Linear { limits, relief, cost }
    }

    /// The step from a position, and the predicted cost there.
    fn step(&self, linear: &Linear, step_penalty: f64) -> Option<(Vec<f64>, f64)> {
        let mut direction = vec![0.0; self.width];
        direction[self.width - 1] = -1.0;
        let limits = &linear.limits;
        let step = limits.best(&direction, Penalties { step: step_penalty, limit: LIMIT })?;
        let rooms = (0..limits.bounds.len()).map(|i| limits.room(i, &step));
        let predicted = limits.cost(rooms, LIMIT) + step[self.width - 1];
        Some((step, predicted))
    }

    fn moved(&self, position: &[f64], step: &[f64]) -> Vec<f64> {
        let columns = self.columns.iter().zip(self.model.scale());
        position
            .iter()
            .zip(columns)
            .map(|(q, (column, scale))| q + column.map_or(0.0, |column| scale * step[column]))
            .collect()
    }

    /// Successive linearisation of the constraints, with a penalty on long steps that increases if the actual
    /// decrease is below the prediction.
    fn seek(&self, start: &[f64]) -> Option<f64> {
        let mut position = start.to_vec();
        let mut here = self.linear(&position);
        // The penalty of the next step, and the smallest one at which predictions are accurate here.
        let (mut penalty, mut least) = STEP_PENALTY;
        for _ in 0..MOST_STEPS {
            let (step, predicted) = self.step(&here, penalty)?;
            let gain = here.cost - predicted;
            // Short steps under a large penalty are no measure of the remaining decrease.
            let is_last = gain <= TOLERANCE && penalty <= least;
            if is_last && penalty <= STEP_PENALTY.0 {
                return Some((here.relief * self.unit).max(0.0));
            }
            if is_last {
                return None;
            }
            if gain <= TOLERANCE {
                penalty = (0.01 * penalty).max(least);
                continue;
            }
            let next = self.moved(&position, &step);
            let there = self.linear(&next);
            if here.cost - there.cost >= KEPT * gain {
                (position, here) = (next, there);
                least = STEP_PENALTY.1;
                penalty = (0.1 * penalty).max(least);
            } else if gain <= NOISE && penalty <= STEP_PENALTY.0 {
                return Some((here.relief * self.unit).max(0.0));
            } else {
                penalty *= 10.0;
                least = penalty;
            }
        }
        None
    }
}

/// The relief r that minimises r + ½ κ Σ max(0, −(g + r))² over gaps g, in units.
fn cheapest_relief(gaps: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = gaps.iter().map(|gap| -gap).collect();
    sorted.sort_by(|a, b| b.total_cmp(a));
    // With the n deepest ones active, Σ (o − r) = 1/κ.
    let mut sum = 0.0;
    let mut relief = 0.0;
    for (n, overlap) in sorted.iter().enumerate() {
        if n > 0 && *overlap <= relief {
            break;
        }
        sum += overlap;
        relief = (sum - 1.0 / LIMIT) / (n + 1) as f64;
    }
    relief
}

impl BearingMeshing {
    /// The smallest uniform relief (m) of all flanks without overlap of pins at a crank angle, from a nearby
    /// position; `None` if the steps converge too slowly along curved constraints.
    pub(super) fn least_relief(&mut self, crank: CrankAngle, start: &[f64]) -> Option<f64> {
        self.model.hold_sun(self.sun(crank), 0.0);
        Search::new(&self.model, start).seek(start)
    }
}

#[cfg(test)]
mod tests;
