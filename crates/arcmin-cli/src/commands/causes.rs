//! Lost motion by cause, as `life` and `rig` write it.

use arcmin::dynamics::{Cause, LostMotionSplit};
use arcmin::life::PartsPoint;
use arcmin::report::{Block, Section, Shares, Tone, lost_motion_causes};
use arcmin::units::{ARCMIN, UM};
use serde_json::{Map, Value, json};

use crate::run::{Cell, Table};

/// One row per time: hours, the whole, every cause, the residual, and what bearings and gears have lost.
pub fn table<'a>(rows: impl Iterator<Item = (f64, &'a PartsPoint)>) -> Table {
    let causes: Vec<String> = Cause::ALL.iter().map(|cause| format!("{}_arcmin", cause.key())).collect();
    let mut header = vec!["hours", "lost_motion_arcmin"];
    header.extend(causes.iter().map(String::as_str));
    header.extend([
        "residual_arcmin",
        "turning_arm_clearance_growth_um",
        "crank_support_clearance_growth_um",
        "gear_gap_growth_um",
    ]);
    let mut table = Table::new(&header);
    for (hours, point) in rows {
        let split = &point.lost_motion;
        let mut cells = vec![hours.into(), (split.whole / ARCMIN).into()];
        cells.extend(split.causes.iter().map(|cause| Cell::Number(cause / ARCMIN)));
        cells.push((split.residual() / ARCMIN).into());
        let wear = &point.wear;
        cells.extend(
            [wear.turning_arm, wear.crank_support, wear.gears[0] + wear.gears[1]]
                .map(|growth| Cell::Number(growth / UM)),
        );
        table.row(&cells);
    }
    table
}

/// For the summary: the whole, every cause that is there, the residual.
pub fn summary(point: &PartsPoint) -> Value {
    let split = &point.lost_motion;
    let mut map = Map::new();
    map.insert("whole_arcmin".to_owned(), json!(split.whole / ARCMIN));
    for cause in Cause::ALL {
        map.insert(format!("{}_arcmin", cause.key()), json!(split.of(cause) / ARCMIN));
    }
    map.insert("residual_arcmin".to_owned(), json!(split.residual() / ARCMIN));
    Value::Object(map)
}

/// Causes as a reader wants them, in arcmin, one value per state; none below `negligible`. Errors that press
/// parts together without load take as much as the elastic work gives, many times the whole: the two are
/// shown as one then. Tables and summary keep them apart.
fn shown(states: &[&LostMotionSplit], negligible: f64) -> Vec<(String, Vec<f64>)> {
    let pressed = states.iter().any(|split| split.of(Cause::ManufacturingErrors) < -PRESSED);
    let of = |cause: Cause| -> Vec<f64> { states.iter().map(|split| split.of(cause) / ARCMIN).collect() };
    Cause::ALL
        .into_iter()
        .filter(|cause| !(pressed && *cause == Cause::ManufacturingErrors))
        .map(|cause| {
            if pressed && cause == Cause::Elastic {
                let both = of(cause)
                    .into_iter()
                    .zip(of(Cause::ManufacturingErrors))
                    .map(|(elastic, errors)| elastic + errors);
                (format!("{}, and manufacturing errors", cause.name()), both.collect())
            } else {
                (cause.name().to_owned(), of(cause))
            }
        })
        .filter(|(_, values)| values.iter().any(|value| value.abs() > negligible))
        .collect()
}

/// What manufacturing errors take of the lost motion, in rad, from where on they are taken to press parts
/// together.
const PRESSED: f64 = 0.02 * ARCMIN;

/// For the report: the causes stacked over the hours.
pub fn section(rows: &[(f64, &PartsPoint)]) -> Section {
    let states: Vec<&LostMotionSplit> = rows.iter().map(|(_, point)| &point.lost_motion).collect();
    let series: Vec<(String, Vec<(f64, f64)>)> = shown(&states, 1e-4)
        .into_iter()
        .map(|(cause, values)| (cause, rows.iter().map(|(hours, _)| *hours).zip(values).collect()))
        .collect();
    let residual =
        rows.iter().map(|(_, point)| (point.lost_motion.residual() / ARCMIN).abs()).fold(0.0, f64::max);
    let note = format!(
        "The machine with its bearings, without friction, input locked; mean over all places that repeat (a turn of the crankshafts, with errors of the ring one of the output). The causes follow from virtual work with the forces \
         at ±3 % of rated torque and leave at most {residual:.4} arcmin of the whole unexplained: terms of second order in the displacements."
    );
    Section::new(
        "causes",
        "Lost motion of the whole machine",
        vec![lost_motion_causes(&series), Block::Note(Tone::Neutral, note)],
    )
}

/// For the report of one state: which cause gives how much.
pub fn shares(hours: f64, point: &PartsPoint) -> Section {
    let split = &point.lost_motion;
    let rows =
        shown(&[split], 1e-4).into_iter().map(|(cause, values)| (cause, values[0], String::new())).collect();
    let note = format!(
        "After {hours:.0} h, friction aside, mean over all places that repeat (a turn of the crankshafts, with errors of the ring one of the output). Of {:.4} arcmin in all {:+.4} arcmin are left unexplained (terms of second \
         order in the displacements).",
        split.whole / ARCMIN,
        split.residual() / ARCMIN
    );
    Section::new(
        "causes",
        "Lost motion by cause",
        vec![Block::Shares(Shares {
            title: "Which cause gives how much".into(),
            unit: "arcmin".into(),
            rows,
            note,
        })],
    )
}

/// For the terminal.
pub fn say(point: &PartsPoint) -> String {
    let split = &point.lost_motion;
    let mut text = format!("lost motion of the whole machine {:.3}':", split.whole / ARCMIN);
    for (cause, values) in shown(&[split], 5e-4) {
        text.push_str(&format!("\n  {cause:62} {:.3}'", values[0]));
    }
    text.push_str(&format!("\n  {:62} {:+.4}'", "not explained", split.residual() / ARCMIN));
    text
}
