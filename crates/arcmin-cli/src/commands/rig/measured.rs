//! Curves from a real bench.

use std::path::PathBuf;

use arcmin::dynamics::order_spectrum;
use arcmin::machine::Machine;
use arcmin::report::rig::MeasuredOnBench;
use arcmin::rig::{Branch, ErrorCurve, LoopPoint, evaluate_loop, name_orders};
use arcmin::units::{ARCMIN, DEG};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::run::Columns;

const HELP: &str = "a hysteresis loop has the columns torque_n_m, angle_arcmin, branch (falling or rising) and, for several loops, position; a transmission \
                    error has output_angle_deg, te_arcmin and, for several curves, direction and torque_n_m";

/// Reads loops and transmission errors and evaluates them as the computed ones are; `None` without files.
pub fn read(paths: &[PathBuf], machine: &Machine) -> Result<Option<MeasuredOnBench>, Failure> {
    if paths.is_empty() {
        return Ok(None);
    }
    let mut bench = MeasuredOnBench::default();
    for path in paths {
        let columns = Columns::read(path, HELP)?;
        match (columns.has("branch"), columns.has("te_arcmin")) {
            (true, false) => bench.loops.extend(loops(&columns)?),
            (false, true) => bench.curves.extend(curves(&columns)?),
            _ => {
                return Err(columns.wrong(
                    columns.line_of_header(),
                    "this is neither a hysteresis loop nor a transmission error",
                ));
            }
        }
    }
    let rated = machine.rated.torque.abs();
    bench.figures = bench
        .loops
        .iter()
        .map(|points| evaluate_loop(points, rated))
        .collect::<Result<Vec<_>, _>>()
        .map_err(Failure::compute("evaluate the measured loop"))?;
    for curve in &bench.curves {
        if let Some(spectrum) = order_spectrum(&curve.points) {
            bench.orders = name_orders(&spectrum, machine, curve.points.len() - 1, 8);
            bench.spectrum = spectrum;
            break;
        }
    }
    Ok(Some(bench))
}

fn loops(columns: &Columns) -> Result<Vec<Vec<LoopPoint>>, Failure> {
    let (torques, angles, branches) =
        (columns.numbers("torque_n_m")?, columns.numbers("angle_arcmin")?, columns.words("branch")?);
    let positions =
        if columns.has("position") { columns.words("position")? } else { vec![""; torques.len()] };
    let mut loops: Vec<(&str, Vec<LoopPoint>)> = Vec::new();
    for (row, ((torque, angle), (branch, position))) in
        torques.iter().zip(&angles).zip(branches.iter().zip(positions)).enumerate()
    {
        let branch = match *branch {
            "falling" => Branch::Falling,
            "rising" => Branch::Rising,
            other => {
                return Err(columns.wrong(
                    columns.line(row),
                    &format!("the branch is \"{other}\", neither falling nor rising"),
                ));
            }
        };
        let point = LoopPoint { torque: *torque, angle: angle * ARCMIN, branch };
        match loops.last_mut() {
            Some((last, points)) if *last == position => points.push(point),
            _ => loops.push((position, vec![point])),
        }
    }
    Ok(loops.into_iter().map(|(_, points)| points).collect())
}

fn curves(columns: &Columns) -> Result<Vec<ErrorCurve>, Failure> {
    let (angles, errors) = (columns.numbers("output_angle_deg")?, columns.numbers("te_arcmin")?);
    let optional =
        |name: &str| if columns.has(name) { columns.numbers(name) } else { Ok(vec![0.0; angles.len()]) };
    let (directions, torques) = (optional("direction")?, optional("torque_n_m")?);
    let mut curves = Vec::new();
    let mut start = 0;
    for row in 1..=angles.len() {
        let ends =
            row == angles.len() || directions[row] != directions[start] || torques[row] != torques[start];
        if ends {
            let points = (start..row).map(|i| (angles[i] * DEG, errors[i] * ARCMIN)).collect();
            let curve = ErrorCurve::measured(points, torques[start]);
            curves.push(curve.map_err(|error| {
                columns.wrong(columns.line(start), &format!("the curve that begins here: {error}"))
            })?);
            start = row;
        }
    }
    Ok(curves)
}

/// Entry of the summary.
pub fn summary(bench: &MeasuredOnBench) -> Value {
    let mut entry = json!({});
    if !bench.figures.is_empty() {
        let mean = |of: fn(&arcmin::rig::LoopFigures) -> f64| {
            bench.figures.iter().map(of).sum::<f64>() / bench.figures.len() as f64
        };
        entry["lost_motion_arcmin"] = json!(mean(|f| f.lost_motion) / ARCMIN);
        entry["backlash_arcmin"] = json!(mean(|f| f.backlash) / ARCMIN);
        entry["stiffness_nm_per_arcmin"] = json!(mean(|f| f.stiffness) * ARCMIN);
        entry["soft_stiffness_nm_per_arcmin"] = json!(mean(|f| f.soft_stiffness) * ARCMIN);
    }
    if !bench.curves.is_empty() {
        entry["transmission_error"] = super::curves_summary(&bench.curves);
        entry["orders"] = super::orders_summary(&bench.orders);
    }
    entry
}
