//! Wear of rings, output pins and eccentric bearings, stage by stage, as columns and figures.

use super::keys::{ECCENTRIC, OUTPUT, StageKeys, WornKeys, main_of};
use super::{EccentricDrive, Facts};
use crate::life::{Accuracy, WornState};
use crate::report::{Axis, Block, Plot, Series};
use crate::results::{Column, Quantity, Value};
use crate::units::{DEG, MPA, UM};

/// Results that contain the wear of all stages, at one time or over a whole history.
pub(super) trait HasWorn {
    /// By the number of the stage.
    fn state(&self, stage: usize) -> &WornState;
    fn accuracy(&self, stage: usize) -> &Accuracy;

    /// Largest of the history.
    fn largest(&self, stage: usize, of: fn(&Accuracy) -> f64) -> f64 {
        of(self.accuracy(stage))
    }
}

/// How a value of a stage is read, by its number.
type OfStage<O> = fn(&O, usize) -> Value;

/// Wear of output pins and eccentric bearings, as far as the stage has them.
fn parts_of<O: HasWorn>(stage: &StageKeys) -> Vec<(Quantity, OfStage<O>)> {
    let WornKeys { output_pins, rollers, holes, eccentric, .. } = &stage.worn;
    let mut all: Vec<(Quantity, OfStage<O>)> = Vec::new();
    if stage.parts[OUTPUT].is_some() {
        all.push((*output_pins, |o, k| (o.state(k).part_wear.output_pins.deepest() / UM).into()));
        all.push((*rollers, |o, k| (o.state(k).part_wear.rollers / UM).into()));
        all.push((*holes, |o, k| (o.state(k).part_wear.holes.deepest() / UM).into()));
    }
    if stage.parts[ECCENTRIC].is_some() {
        all.push((*eccentric, |o, k| (o.state(k).part_wear.turning_arm / UM).into()));
    }
    all
}

/// Columns for the rings other than the main one, whose columns have the keys of RV reducers: wear, forces, and pressures
/// if `with_pressure`. Then for all stages the wear of output pins, holes and eccentric bearings.
pub(super) fn columns<O: HasWorn, D: EccentricDrive>(with_pressure: bool) -> Vec<Column<O>> {
    let mut columns = Vec::new();
    for (k, stage) in D::STAGES.iter().enumerate() {
        if k != main_of(D::STAGES) {
            let (worn, ring) = (&stage.worn, stage.parts[super::RING].as_ref());
            let mut all: Vec<(Quantity, OfStage<O>)> =
                vec![(worn.max_depth, |o, k| (o.accuracy(k).max_depth / UM).into())];
            all.extend(ring.map(|ring| {
                (ring.force, (|o, k| o.largest(k, |accuracy| accuracy.max_force).into()) as OfStage<O>)
            }));
            all.extend(ring.and_then(|ring| ring.pressure).filter(|_| with_pressure).map(|pressure| {
                (pressure, (|o, k| (o.largest(k, |a| a.max_pressure) / MPA).into()) as OfStage<O>)
            }));
            all.push((worn.loaded_pairs, |o, k| o.accuracy(k).loaded_pairs.into()));
            all.push((worn.max_depth_at, |o, k| o.accuracy(k).max_depth_at.map(|at| at.abs() / DEG).into()));
            all.push((worn.max_pin_depth, |o, k| (o.state(k).surfaces.pin().deepest().0 / UM).into()));
            columns.extend(all.into_iter().map(|(quantity, value)| Column::numbered(quantity, k, value)));
        }
        let parts = parts_of(stage).into_iter();
        columns.extend(parts.map(|(quantity, value)| Column::numbered(quantity, k, value)));
    }
    columns
}

/// Keys for the terminal: of the rings other than the main one, and of worn parts.
pub(super) fn shown<O: HasWorn>(stages: &[StageKeys], last: &O) -> Vec<&'static str> {
    let mut keys = Vec::new();
    for (k, stage) in stages.iter().enumerate() {
        if k != main_of(stages) {
            keys.push(stage.worn.max_depth.key);
            keys.extend(stage.parts[super::RING].as_ref().map(|ring| ring.force.key));
        }
        let is_worn = |value: OfStage<O>| matches!(value(last, k), Value::Number(depth) if depth > 0.0);
        let parts = parts_of::<O>(stage).into_iter().filter(|(_, value)| is_worn(*value));
        keys.extend(parts.map(|(quantity, _)| quantity.key));
    }
    keys
}

/// Depths of output pins, rollers and holes and growth of clearances over the hours, where some wear.
pub(super) fn parts_plot<O: HasWorn>(facts: &Facts, rows: &[O]) -> Option<Block> {
    let last = rows.last()?;
    let mut plot = Plot::new(
        format!("Wear beside flanks and {}", facts.ring.all_of_ring()),
        Axis::new("Running time", "h"),
        Axis::new("Depth", "µm").from_zero(),
    )
    .noted("Largest wear depth in µm of output pins, rollers and holes, and growth of the diametral clearance of eccentric bearings in µm, over the running time.")
    .half();
    for (k, stage) in facts.stages.iter().enumerate() {
        for (quantity, value) in parts_of::<O>(stage) {
            let number = |row: &O| match value(row, k) {
                Value::Number(depth) => depth,
                _ => 0.0,
            };
            if number(last) > 0.0 {
                let points = rows.iter().map(|row| (row.state(k).hours, number(row)));
                plot = plot.with(Series::line(quantity.label(), points));
            }
        }
    }
    (!plot.series.is_empty()).then_some(Block::Plot(plot))
}
