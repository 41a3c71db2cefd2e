//! Tables of the bench, and its figures for the terminal.

use arcmin::report::rig::{MeasuredOnBench, RigState};
use arcmin::rig::LoopFigures;
use arcmin::units::{ARCMIN, DEG};

use crate::failure::Failure;
use crate::run::{Cell, Run, Table};

pub fn write(run: &mut Run, state: &RigState) -> Result<(), Failure> {
    let mut table = Table::new(&["torque_n_m", "angle_arcmin", "branch", "position"]);
    for (position, points) in state.loops.iter().enumerate() {
        for p in points {
            table.row(&[p.torque.into(), (p.angle / ARCMIN).into(), p.branch.word().into(), position.into()]);
        }
    }
    run.table("hysteresis.csv", table)?;
    let mut table = Table::new(&["order", "amplitude_arcmin"]);
    for line in &state.spectrum {
        table.row(&[line.order.into(), (line.amplitude / ARCMIN).into()]);
    }
    run.table("spectrum.csv", table)?;
    let mut table = Table::new(&["output_angle_deg", "te_arcmin", "direction", "torque_n_m"]);
    for curve in &state.curves {
        for (angle, error) in &curve.points {
            table.row(&[
                (angle / DEG).into(),
                (error / ARCMIN).into(),
                curve.direction.into(),
                curve.torque.into(),
            ]);
        }
    }
    run.table("te.csv", table)?;
    let mut table = Table::new(&["part", "compliance_arcmin_per_nm", "share"]);
    for (part, compliance) in &state.split.parts {
        table.row(&[
            part.name().into(),
            (compliance / ARCMIN).into(),
            (compliance / state.split.whole).into(),
        ]);
    }
    run.table("stiffness.csv", table)?;
    let mut table = Table::new(&[
        "bearing",
        "mean_force_n",
        "largest_element_force_n",
        "equivalent_load_n",
        "rating_n",
        "l10_h",
    ]);
    for b in &state.bearings {
        table.row(&[
            b.name.as_str().into(),
            b.mean_force().into(),
            b.largest_element.into(),
            b.equivalent.into(),
            b.rating.into(),
            b.life_h().into(),
        ]);
    }
    run.table("bearings.csv", table)?;
    let mut table = Table::new(&["crank_angle_deg", "bearing", "force_n"]);
    for b in &state.bearings {
        for (i, force) in b.forces.iter().enumerate() {
            table.row(&[
                (360.0 * i as f64 / b.forces.len() as f64).into(),
                b.name.as_str().into(),
                (*force).into(),
            ]);
        }
    }
    run.table("bearing_forces.csv", table)?;
    let mut table = Table::new(&["input_speed_rpm", "torque_n_m", "efficiency"]);
    for (speed, row) in state.efficiency.speeds.iter().zip(&state.efficiency.efficiency) {
        for (torque, efficiency) in state.efficiency.torques.iter().zip(row) {
            table.row(&[Cell::Number(speed / arcmin::units::RPM), (*torque).into(), (*efficiency).into()]);
        }
    }
    run.table("efficiency.csv", table)
}

pub fn terminal(new: &RigState, worn: Option<&RigState>, measured: Option<&MeasuredOnBench>) -> String {
    let mut table = comfy_table::Table::new();
    let mut header = vec!["".to_owned(), "new".to_owned()];
    if let Some(worn) = worn {
        header.push(format!("{} h", worn.hours));
    }
    if measured.is_some() {
        header.push("measured".to_owned());
    }
    table.set_header(header);
    type Value = fn(&RigState) -> f64;
    type Measured = Option<fn(&LoopFigures) -> f64>;
    let rows: [(&str, Value, Measured); 8] = [
        ("lost motion, arcmin", |s| s.lost_motion() / ARCMIN, Some(|m| m.lost_motion / ARCMIN)),
        ("backlash, arcmin", |s| s.backlash() / ARCMIN, Some(|m| m.backlash / ARCMIN)),
        ("stiffness 50–100 %, N·m/arcmin", |s| s.stiffness() * ARCMIN, Some(|m| m.stiffness * ARCMIN)),
        (
            "stiffness 3–15 %, N·m/arcmin",
            |s| s.soft_stiffness() * ARCMIN,
            Some(|m| m.soft_stiffness * ARCMIN),
        ),
        (
            "TE at rated torque, peak to peak, arcmin",
            |s| s.curves.get(2).map_or(f64::NAN, |c| c.peak_to_peak()) / ARCMIN,
            None,
        ),
        ("efficiency at rated torque", |s| s.efficiency.rated, None),
        ("no-load running torque at the input, N·m", |s| s.torques.no_load, None),
        ("back-driving torque at the output, N·m", |s| s.torques.back_driving, None),
    ];
    for (name, value, of_measured) in rows {
        let mut row = vec![name.to_owned(), format!("{:.3}", value(new))];
        if let Some(worn) = worn {
            row.push(format!("{:.3}", value(worn)));
        }
        if let Some(measured) = measured {
            let read = of_measured.filter(|_| !measured.figures.is_empty()).map(|of| {
                let mean = measured.figures.iter().map(of).sum::<f64>() / measured.figures.len() as f64;
                format!("{mean:.3}")
            });
            row.push(read.unwrap_or_default());
        }
        table.add_row(row);
    }
    table.to_string()
}
