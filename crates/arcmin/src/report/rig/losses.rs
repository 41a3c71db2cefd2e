//! Efficiency, torques without load and heat of the running machine.

use crate::machine::Machine;
use crate::report::{Axis, Block, Colour, Column, HeatMap, Plot, Series, Table, Width, compact, significant};
use crate::rig::{EfficiencyMap, HeatBalance, RigState, RunningTorques};
use crate::units::RPM;

pub(super) fn blocks(machine: &Machine, state: &RigState) -> Vec<Block> {
    let (Some(map), Some(torques)) = (&state.efficiency, &state.torques) else { return Vec::new() };
    let mut blocks =
        vec![Block::HeatMap(heat_map(map)), Block::Plot(over_speed(map)), Block::Plot(over_torque(map))];
    blocks.push(Block::Plot(no_load(machine, torques)));
    blocks.push(Block::Table(without_load(machine, torques)));
    blocks.extend(state.heat.as_ref().map(|heat| Block::Table(balance(machine, heat))));
    blocks
}

fn heat_map(map: &EfficiencyMap) -> HeatMap {
    HeatMap {
        title: "Efficiency".into(),
        x: Axis::new("Output torque", "N·m"),
        y: Axis::new("Input speed", "rpm"),
        value: Axis::new("Efficiency", "%"),
        x_values: map.torques.clone(),
        y_values: map.speeds.iter().map(|speed| speed / RPM).collect(),
        cells: map.efficiency.iter().flatten().map(|e| e.is_finite().then_some(100.0 * e)).collect(),
        note: "Output power over input power in % over output torque and input speed, in steady running, with friction at pins, bearings and meshes, seals, oil and lubricant of the bearings.".into(),
        width: Width::Half,
    }
}

fn percent() -> Axis {
    Axis::new("Efficiency", "%")
}

fn over_torque(map: &EfficiencyMap) -> Plot {
    let mut lines =
        Plot::new("Efficiency over torque", Axis::new("Output torque", "N·m").from_zero(), percent())
            .half()
            .noted("Efficiency in % over the output torque in N·m, one line for each input speed. Drag that does not depend on torque has a smaller share at high torque.");
    let count = map.speeds.len().saturating_sub(1).max(1) as f64;
    for (index, (speed, row)) in map.speeds.iter().zip(&map.efficiency).enumerate() {
        let points = map.torques.iter().zip(row).map(|(torque, e)| (*torque, 100.0 * e));
        lines.series.push(
            Series::line(format!("{} rpm", compact(speed / RPM, 4)), points)
                .coloured(Colour::Ordered(index as f64 / count)),
        );
    }
    lines
}

/// As in catalogues: a line for each torque.
fn over_speed(map: &EfficiencyMap) -> Plot {
    let mut lines = Plot::new("Efficiency over speed", Axis::new("Input speed", "rpm").from_zero(), percent())
        .half()
        .noted("Efficiency in % over the input speed in rpm, one line for each output torque. It decreases where the drag of oil and lubricant increases faster than the film reduces the friction of the flanks.");
    let count = map.torques.len().saturating_sub(1).max(1) as f64;
    for (index, torque) in map.torques.iter().enumerate() {
        let points =
            map.speeds.iter().zip(&map.efficiency).map(|(speed, row)| (speed / RPM, 100.0 * row[index]));
        lines.series.push(
            Series::line(format!("{} N·m", significant(*torque, 3)), points)
                .coloured(Colour::Ordered(index as f64 / count)),
        );
    }
    lines
}

fn no_load(machine: &Machine, torques: &RunningTorques) -> Plot {
    let ratio = machine.kinematics().ratio().abs();
    let points = torques.over_speed.iter().map(|(speed, torque)| (speed / RPM / ratio, torque * ratio));
    let mut plot = Plot::new(
        "Running torque without load",
        Axis::new("Output speed", "rpm").from_zero(),
        Axis::new("Torque, referred to the output", "N·m").from_zero(),
    )
    .half()
    .noted(
        "Running torque without load in N·m over the output speed in rpm: torque at the input times the ratio, \
         as in catalogues.",
    );
    plot.series.push(Series::line("without load", points));
    plot
}

fn without_load(machine: &Machine, torques: &RunningTorques) -> Table {
    let ratio = machine.kinematics().ratio().abs();
    let row =
        |name: &str, input: f64| vec![name.to_owned(), significant(input, 3), significant(input * ratio, 3)];
    let back = match torques.back_driving.is_finite() {
        true => significant(torques.back_driving, 3),
        false => "self-locking".into(),
    };
    Table {
        title: "Torques without load".into(),
        columns: vec![
            Column::text("Torque"),
            Column::number("At the input", "N·m"),
            Column::number("Referred to the output", "N·m"),
        ],
        rows: vec![
            row("Running at rated speed", torques.no_load),
            row("Starting", torques.starting),
            vec!["Back-driving, at the output".into(), "–".into(), back],
        ],
        note: "Starting and back-driving torque: without drag of the oil, preloaded bearings at twice their running moment. At the pins static \
               friction equals sliding friction."
            .into(),
    }
}

fn balance(machine: &Machine, heat: &HeatBalance) -> Table {
    let thermal = &machine.thermal;
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    let mut rows = vec![
        row("Viscosity of the oil at the temperature given, mPa·s", significant(heat.viscosity * 1e3, 3)),
        row("Film ratio there, mean of all contacts", significant(heat.film_ratio, 2)),
        row("Friction coefficient of the flanks there", significant(heat.flank_friction, 2)),
        row("Loss there at rated torque and speed, W", significant(heat.loss, 3)),
    ];
    match &heat.steady {
        Some(steady) => rows.extend([
            row("Steady temperature at rated torque and speed, °C", significant(steady.temperature, 3)),
            row("Loss at this temperature, W", significant(steady.loss, 3)),
            row("of it into the air around, W", significant(steady.convection, 3)),
            row("of it into the mounting, W", significant(steady.conduction, 3)),
        ]),
        None => {
            rows.push(row("Steady temperature at rated torque and speed, °C", "none within 200 K".into()))
        }
    }
    Table {
        title: "Heat".into(),
        columns: vec![Column::text("Figure"), Column::number("Value", "")],
        rows,
        note: format!(
            "One temperature stands for oil, housing and flange; surroundings at {} °C. Cooling: {} W/K by the surface, {} W/K by the mounting \
             (`[thermal] mounting_conductance_w_k`).",
            significant(thermal.ambient, 3),
            significant(thermal.transfer * thermal.surface, 3),
            significant(thermal.mounting, 3)
        ),
    }
}
