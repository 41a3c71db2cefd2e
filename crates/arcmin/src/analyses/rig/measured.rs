//! Curves from a real bench.

use crate::analyses::{AnalysisError, Host, Origin};
use crate::design::InputFile;
use crate::dynamics::order_spectrum;
use crate::machine::Machine;
use crate::rig::{Branch, ErrorCurve, LoopPoint, MeasuredOnBench, evaluate_loop, name_orders};
use crate::tables::{Column, Form, Table};
use crate::units::{ARCMIN, DEG};

/// Reads loops and transmission errors and evaluates them as the computed ones are; `None` without files.
pub(super) fn read(
    files: &[InputFile],
    machine: &Machine,
    host: &dyn Host,
) -> Result<Option<MeasuredOnBench>, AnalysisError> {
    if files.is_empty() {
        return Ok(None);
    }
    let mut bench = MeasuredOnBench::default();
    for file in files {
        let bytes = host.read(file, Origin::Options)?;
        // The columns tell which of the two it is; the error of the better guess is the one to show.
        if String::from_utf8_lossy(&bytes[..bytes.len().min(4096)]).to_lowercase().contains("branch") {
            bench.loops.extend(loops(&loop_form().read(&bytes, &file.0)?)?);
        } else {
            bench.curves.extend(curves(&curve_form().read(&bytes, &file.0)?)?);
        }
    }
    let rated = machine.rated.torque.abs();
    bench.figures = bench
        .loops
        .iter()
        .map(|points| evaluate_loop(points, rated))
        .collect::<Result<Vec<_>, _>>()
        .map_err(AnalysisError::compute("evaluate the measured loop"))?;
    for curve in &bench.curves {
        if let Some(spectrum) = order_spectrum(&curve.points) {
            bench.orders = name_orders(&spectrum, machine, curve.points.len() - 1, 8);
            bench.spectrum = spectrum;
            break;
        }
    }
    Ok(Some(bench))
}

fn loop_form() -> Form {
    Form::new(&[
        Column::number("torque_n_m").within(-1e7, 1e7),
        Column::number("angle_arcmin").within(-1e4, 1e4),
        Column::words("branch"),
        Column::words("position").optional(),
    ])
}

fn loops(table: &Table) -> Result<Vec<Vec<LoopPoint>>, AnalysisError> {
    let (torques, angles) = (table.numbers("torque_n_m")?, table.numbers("angle_arcmin")?);
    let branches = table.words("branch")?;
    let positions = if table.has("position") { Some(table.words("position")?) } else { None };
    let mut loops: Vec<(&str, Vec<LoopPoint>)> = Vec::new();
    for row in 0..table.len() {
        let branch = match branches[row].as_str() {
            "falling" => Branch::Falling,
            "rising" => Branch::Rising,
            other => {
                let what = format!("the branch is \"{}\"", crate::tables::shown(other));
                return Err(table.wrong(row, what, "write falling or rising").into());
            }
        };
        let position = positions.map_or("", |positions| positions[row].as_str());
        let point = LoopPoint { torque: torques[row], angle: angles[row] * ARCMIN, branch };
        match loops.last_mut() {
            Some((last, points)) if *last == position => points.push(point),
            _ => loops.push((position, vec![point])),
        }
    }
    Ok(loops.into_iter().map(|(_, points)| points).collect())
}

fn curve_form() -> Form {
    // A thousand turns either way; beyond them the angles of a long log have lost their digits.
    Form::new(&[
        Column::number("output_angle_deg").within(-3.6e5, 3.6e5),
        Column::number("te_arcmin").within(-1e4, 1e4),
        Column::number("direction").optional().within(-1.0, 1.0),
        Column::number("torque_n_m").optional().within(-1e7, 1e7),
    ])
}

fn curves(table: &Table) -> Result<Vec<ErrorCurve>, AnalysisError> {
    let (angles, errors) = (table.numbers("output_angle_deg")?, table.numbers("te_arcmin")?);
    let optional = |name: &str| match table.has(name) {
        true => table.numbers(name).map(<[f64]>::to_vec),
        false => Ok(vec![0.0; table.len()]),
    };
    let (directions, torques) = (optional("direction")?, optional("torque_n_m")?);
    let mut curves = Vec::new();
    let mut start = 0;
    for row in 1..=table.len() {
        let ends =
            row == table.len() || directions[row] != directions[start] || torques[row] != torques[start];
        if ends {
            let points = (start..row).map(|i| (angles[i] * DEG, errors[i] * ARCMIN)).collect();
            let curve = ErrorCurve::measured(points, torques[start]).map_err(|error| {
                let what = format!("the curve that begins here: {error}");
                table.wrong(start, what, "give angles that rise or fall, with an error that changes")
            })?;
            curves.push(curve);
            start = row;
        }
    }
    Ok(curves)
}
