//! Tables, summary and terminal lines of a finished run.

use std::time::Duration;

use arcmin::dynamics::{DynamicsError, Model, Reducer, RunResult, StartSpread};
use arcmin::rig::name_orders;
use arcmin::units::{ARCMIN, DEG, UM};
use serde_json::{Value, json};

use super::Case;
use crate::commands::rig::orders_summary;
use crate::failure::Failure;
use crate::run::{Run, Table};

pub(super) fn write(
    run: &mut Run,
    case: &Case,
    model: &Model,
    result: &RunResult,
    spread: Option<&StartSpread>,
    failed: Option<&DynamicsError>,
    wall: Duration,
) -> Result<Value, Failure> {
    let mut series =
        Table::new(&["time_s", "input_speed_deg_s", "output_speed_deg_s", "load_n_m", "te_arcmin"]);
    for row in &result.series {
        series.row(&[
            row.time.into(),
            (row.input_speed / DEG).into(),
            (row.output_speed / DEG).into(),
            row.load.into(),
            (row.transmission_error / ARCMIN).into(),
        ]);
    }
    run.table("timeseries.csv", series)?;
    let mut forces = Table::new(&["time_s", "largest_pin_force_n", "loaded_pins", "mesh_force_n"]);
    for row in &result.forces {
        let f = row.forces;
        forces.row(&[row.time.into(), f.largest_pin_force.into(), f.loaded_pins.into(), f.mesh_force.into()]);
    }
    run.table("forces.csv", forces)?;
    match &result.spectrum {
        Some(lines) => {
            let mut table = Table::new(&["order", "amplitude_arcmin"]);
            for line in lines {
                table.row(&[line.order.into(), (line.amplitude / ARCMIN).into()]);
            }
            run.table("spectrum.csv", table)?;
        }
        // One from an earlier run would be taken for this one's.
        None => drop(std::fs::remove_file(run.path("spectrum.csv"))),
    }
    let te = result.statistics.map(|te| {
        json!({
            "mean_arcmin": te.mean / ARCMIN,
            "mean_abs_arcmin": te.mean_abs / ARCMIN,
            "max_abs_arcmin": te.max_abs / ARCMIN,
            "peak_to_peak_arcmin": te.peak_to_peak / ARCMIN,
            "rms_arcmin": te.rms / ARCMIN,
            "lowest_arcmin": te.lowest / ARCMIN,
            "highest_arcmin": te.highest / ARCMIN,
            "window_s": te.duration,
        })
    });
    let spread_json = spread.map(|spread| {
        json!({
            "starts": spread.runs.len(),
            "chaotic": spread.is_chaotic(),
            "mean_spread_arcmin": spread.mean / ARCMIN,
            "rms_spread_arcmin": spread.rms / ARCMIN,
            "band_arcmin": spread.band / ARCMIN,
        })
    });
    let orders = result
        .spectrum
        .as_ref()
        .map(|lines| orders_summary(&name_orders(lines, case.machine, 2 * lines.len(), 8)));
    let energy = &result.energy;
    let mut summary = json!({
        "ratio": model.ratio(),
        "mean_ratio": result.mean_ratio,
        "wear_um": case.worn.deepest / UM,
        "hours": case.hours,
        "facet_mm": case.facet_mm,
        "errors": case.deviations.summary(),
        "complete": failed.is_none(),
        "reached_s": result.reached,
        "te": te,
        "orders": orders,
        "perturbed_starts": spread_json,
        "solver": {
            "steps": result.counts.accepted,
            "rejected_steps": result.counts.rejected,
            "evaluations": result.counts.evaluations,
            "wall_s": wall.as_secs_f64(),
            "energy_residual": energy.residual(),
        },
        "energy": {
            "input_j": energy.input, "load_j": energy.load, "dissipated_j": energy.dissipated,
            "stored_j": energy.current, "turnover_j": energy.turnover,
        },
        "largest_pin_force_n": result.forces.iter().map(|f| f.forces.largest_pin_force).fold(0.0, f64::max),
    });
    if let (Some(error), Value::Object(map)) = (failed, &mut summary) {
        map.insert("error".to_owned(), json!(error.to_string()));
    }
    if let Some(te) = result.statistics {
        run.say(&format!(
            "TE  mean {:+.4}'   mean |TE| {:.4}'   max |TE| {:.4}'   peak to peak {:.4}'   RMS {:.4}'",
            te.mean / ARCMIN,
            te.mean_abs / ARCMIN,
            te.max_abs / ARCMIN,
            te.peak_to_peak / ARCMIN,
            te.rms / ARCMIN
        ));
    }
    if let Some(spread) = spread {
        run.say(&format!(
            "{} perturbed starts: mean spreads over {:.4}', RMS over {:.4}', all within ±{:.4}'",
            spread.runs.len(),
            spread.mean / ARCMIN,
            spread.rms / ARCMIN,
            spread.band / ARCMIN
        ));
        if spread.is_chaotic() {
            run.say("the unloaded machine rattles chaotically: its mean is no result, band and RMS are; --drag-nm 5 gives a well-defined mean");
        }
    }
    run.say(&format!(
        "{} steps in {:.2} s, energy residual {:.1e}",
        result.counts.accepted,
        wall.as_secs_f64(),
        energy.residual()
    ));
    Ok(summary)
}
