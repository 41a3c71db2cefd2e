//! Curves from a real bench.

use crate::analyses::{AnalysisError, Host, Origin};
use crate::design::InputFile;
use crate::machine::Machine;
use crate::rig::{
    Branch, LoopRow, MeasuredOnBench, Remark, TurnRow, Unusable, name_orders, read_loops, read_turns,
};
use crate::tables::{Column, Form, Table, TableError, TableErrorKind};
use crate::units::{ARCMIN, DEG};

/// Reads loops and transmission errors and evaluates them like computed ones; `None` without files.
pub(super) fn read(
    files: &[InputFile],
    machine: &Machine,
    host: &dyn Host,
) -> Result<Option<MeasuredOnBench>, AnalysisError> {
    if files.is_empty() {
        return Ok(None);
    }
    let rated = machine.rated.torque.abs();
    let mut bench = MeasuredOnBench::default();
    for file in files {
        let bytes = host.read(file, Origin::Options)?;
        // The columns distinguish the two: a transmission error has a column of this name.
        match curve_form().read(&bytes, &file.0) {
            Ok(table) => curves(&table, &file.0, rated, &mut bench)?,
            Err(error) if is_no_curve(&error) => {
                let table = loop_form().read(&bytes, &file.0).map_err(neither)?;
                loops(&table, &file.0, rated, &mut bench)?;
            }
            Err(error) => return Err(error.into()),
        }
    }
    if let Some(spectrum) = bench.curves.iter().find_map(|curve| curve.spectrum.as_ref()) {
        bench.orders = name_orders(&spectrum.lines, machine, spectrum.places, 8)
            .into_iter()
            .map(|named| (spectrum.uncertainty[named.order], named))
            // Amplitudes within the noise get no cause.
            .filter(|(uncertainty, named)| named.amplitude > *uncertainty)
            .map(|(uncertainty, named)| (named, uncertainty))
            .collect();
        bench.spectrum.clone_from(&spectrum.lines);
    }
    Ok(Some(bench))
}

/// Whether a file has no column of a transmission error.
fn is_no_curve(error: &TableError) -> bool {
    let TableErrorKind::Missing { name, found, .. } = &error.kind else { return false };
    let is_error =
        |name: &str| name == "te" || ["te_", "te ", "te[", "te("].iter().any(|te| name.starts_with(te));
    name == ERROR || !found.to_lowercase().split(", ").any(is_error)
}

/// A file without the columns of a loop may be an incomplete transmission error.
fn neither(error: TableError) -> TableError {
    let TableErrorKind::Missing { name, found, .. } = &error.kind else { return error };
    let kind = TableErrorKind::Content {
        message: format!("there is no column {name} of a loop, and no {ERROR} of a transmission error"),
        remedy: format!(
            "a loop has torque_n_m and angle_arcmin, a transmission error output_angle_deg and {ERROR}; the file \
             has {found}"
        ),
    };
    TableError { kind, ..error }
}

fn loop_form() -> Form {
    Form::new(&[
        Column::number("torque_n_m").within(-1e7, 1e7),
        Column::number("angle_arcmin").also(&["output_angle"]).within(-1e4, 1e4),
        Column::words("branch").optional(),
        Column::words("position").optional(),
        Column::number("time_s").optional(),
    ])
    .with_others()
}

fn loops(table: &Table, file: &str, rated: f64, bench: &mut MeasuredOnBench) -> Result<(), AnalysisError> {
    let (torques, angles) = (table.numbers("torque_n_m")?, table.numbers("angle_arcmin")?);
    let words = |name: &str| if table.has(name) { table.words(name).map(Some) } else { Ok(None) };
    let (branches, positions) = (words("branch")?, words("position")?);
    let mut rows = Vec::with_capacity(table.len());
    for row in 0..table.len() {
        let branch = match branches.map(|branches| branches[row].to_lowercase()).as_deref() {
            None | Some("") => None,
            Some("falling" | "unloading") => Some(Branch::Falling),
            Some("rising" | "loading") => Some(Branch::Rising),
            Some(other) => {
                let what = format!("the branch is \"{}\"", crate::tables::shown(other));
                let remedy = "write falling or rising, or remove the column: the branches are then found from the order of \
                         the torque";
                return Err(table.wrong(row, what, remedy).into());
            }
        };
        rows.push(LoopRow { torque: torques[row], angle: angles[row] * ARCMIN, branch });
    }
    let order = order_in_time(table)?;
    let same = |a: usize, b: usize| positions.is_none_or(|positions| positions[a] == positions[b]);
    let base = bench.loops.last().map_or(0, |last| last.position + 1);
    for (position, group) in order.chunk_by(|a, b| same(*a, *b)).enumerate() {
        let here: Vec<LoopRow> = group.iter().map(|row| rows[*row]).collect();
        let (loops, remarks) = read_loops(&here, rated).map_err(|error| unusable(table, group, error))?;
        bench.loops.extend(loops.into_iter().map(|mut one| {
            one.position = base + position;
            one
        }));
        add_remarks(table, file, group, remarks, bench);
    }
    Ok(())
}

/// Rows in the order of time if it is given, otherwise in the order of the file.
fn order_in_time(table: &Table) -> Result<Vec<usize>, AnalysisError> {
    let mut order: Vec<usize> = (0..table.len()).collect();
    if table.has("time_s") {
        let times = table.numbers("time_s")?;
        order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
    }
    Ok(order)
}

const ERROR: &str = "te_arcmin";

fn curve_form() -> Form {
    // At most a thousand turns either way; beyond them the angles of a long log have too few digits.
    Form::new(&[
        Column::number("output_angle_deg").within(-3.6e5, 3.6e5),
        Column::number(ERROR).also(&["transmission_error"]).within(-1e4, 1e4),
        Column::number("direction").optional().within(-1.0, 1.0),
        Column::number("torque_n_m").optional().within(-1e7, 1e7),
        Column::number("time_s").optional(),
    ])
    .with_others()
}

fn curves(table: &Table, file: &str, rated: f64, bench: &mut MeasuredOnBench) -> Result<(), AnalysisError> {
    let (angles, errors) = (table.numbers("output_angle_deg")?, table.numbers(ERROR)?);
    let optional = |name: &str| if table.has(name) { table.numbers(name).map(Some) } else { Ok(None) };
    let (directions, torques) = (optional("direction")?, optional("torque_n_m")?);
    let order = order_in_time(table)?;
    let row = |row: &usize| TurnRow {
        angle: angles[*row] * DEG,
        error: errors[*row] * ARCMIN,
        direction: directions.map(|directions| directions[*row]),
        torque: torques.map(|torques| torques[*row]),
    };
    let rows: Vec<TurnRow> = order.iter().map(row).collect();
    let (curves, remarks) = read_turns(&rows, rated).map_err(|error| unusable(table, &order, error))?;
    bench.curves.extend(curves);
    add_remarks(table, file, &order, remarks, bench);
    Ok(())
}

fn unusable(table: &Table, rows: &[usize], error: Unusable) -> AnalysisError {
    table.wrong(rows[error.row], error.what, error.remedy).into()
}

/// Adds remarks with the lines of the file.
fn add_remarks(table: &Table, file: &str, rows: &[usize], remarks: Vec<Remark>, bench: &mut MeasuredOnBench) {
    let name = crate::tables::shown(file.rsplit(['/', '\\']).next().unwrap_or(file));
    for Remark { rows: about, text } in remarks {
        let (first, last) = about.map_or((0, rows.len() - 1), |about| (about.start, about.end - 1));
        let (first, last) = (table.line(rows[first]), table.line(rows[last]));
        let place = if first == last { format!("line {first}") } else { format!("lines {first} to {last}") };
        let remark = format!("{name}, {place}: {text}");
        if !bench.remarks.contains(&remark) {
            bench.remarks.push(remark);
        }
    }
}
