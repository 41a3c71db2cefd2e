//! Terminal and report of the bench.

use super::Rig;
use super::declared::{FIGURES, measured};
use crate::analyses::Outcome;
use crate::analyses::{TextBlock, TextTable, causes};
use crate::machine::OutputForces;
use crate::report::rig::{RigPage, assumed_coefficients};
use crate::report::{Page, Provenance, Section, capitalised, significant};
use crate::results::Value;
use crate::rig::{MeasuredOnBench, NamedOrder};
use crate::units::{ARCMIN, RPM};

const FURTHER: &[&str] = &[
    "te_rated_peak_to_peak_arcmin",
    "te_held_peak_to_peak_arcmin",
    "max_force_n",
    "max_pressure_mpa",
    "efficiency",
    "no_load_running_torque_n_m",
    "no_load_at_output_n_m",
    "starting_torque_n_m",
    "back_driving_torque_n_m",
    "shortest_bearing_life_h",
    "main_bearings.moment_stiffness_n_m_per_arcmin",
];

/// Results if the design gives a temperature.
const WARM: &[&str] = &[
    "thermal.film_ratio",
    "thermal.flank_friction",
    "thermal.loss_w",
    "thermal.steady_c",
    "thermal.convection_w",
    "thermal.conduction_w",
];
/// Surface temperature that makers of these reducers allow, °C.
const SURFACE_LIMIT_C: f64 = 60.0;

/// Results if external forces are given.
const UNDER_FORCES: &[&str] =
    &["main_bearings.tilt_arcmin", "main_bearings.largest_element_force_n", "main_bearings.l10_h"];

pub(super) fn text_blocks(rig: &Rig) -> Vec<TextBlock> {
    let mut blocks = vec![TextBlock::line(format!("{}: {}", rig.machine.name, rig.fidelity.sentence()))];
    if rig.friction_assumed {
        let assumed = assumed_coefficients(&rig.machine);
        blocks.push(TextBlock::line(format!("friction is assumed ({assumed}): the design gives none")));
    }
    let mut header = vec![String::new(), "new".to_owned()];
    header.extend(rig.worn.as_ref().map(|(state, _)| format!("{:.0} h", state.hours)));
    if rig.measured.is_some() {
        header.push("measured".to_owned());
    }
    let rows = FIGURES.iter().enumerate().map(|(index, figure)| {
        let show = |value: f64| figure.quantity.show(&Value::Number(value));
        let mut row = vec![
            format!("{} {}", figure.quantity.label(), figure.quantity.unit()),
            show((figure.of)(&rig.new)),
        ];
        row.extend(rig.worn.as_ref().map(|(state, _)| show((figure.of)(state))));
        if rig.measured.is_some() {
            let shown = |(value, uncertainty)| format!("{} ± {}", show(value), significant(uncertainty, 2));
            row.push(measured(rig, index).map_or(String::new(), shown));
        }
        row
    });
    blocks.push(TextBlock::Table(TextTable { header, rows: rows.collect() }));
    blocks.extend(rig.measured.iter().flat_map(measured_blocks));
    blocks.push(TextBlock::figures(&rig.summary(), FURTHER));
    if let Some(heat) = &rig.state().heat {
        blocks.push(TextBlock::figures(&rig.summary(), WARM));
        if heat.steady.is_none_or(|steady| steady.temperature > SURFACE_LIMIT_C) {
            blocks.push(TextBlock::line(format!(
                "in steady running at rated torque and speed the surface exceeds {SURFACE_LIMIT_C} °C, the limit of \
                     makers: rests, cooling or less \
                 speed are needed"
            )));
        }
    }
    blocks.extend(efficiencies(rig));
    if rig.main_bearings.forces != OutputForces::default() {
        blocks.push(TextBlock::figures(&rig.summary(), UNDER_FORCES));
    }
    if let Some(at) = rig.causes_at().last() {
        blocks.extend(causes::text_blocks(at, Some(rig.state().lost_motion())));
    }
    blocks
}

/// Measured transmission errors, and corrections of the rows of measured curves.
fn measured_blocks(bench: &MeasuredOnBench) -> Vec<TextBlock> {
    let arcmin = |angle: f64| significant(angle / ARCMIN, 3);
    let mut blocks = Vec::new();
    for measured in &bench.curves {
        let way = if measured.curve.direction > 0.0 { "forward" } else { "backward" };
        blocks.push(TextBlock::line(format!(
            "measured transmission error, {way}, {} N·m: {} ± {} arcmin peak to peak",
            significant(measured.curve.torque, 3),
            arcmin(measured.peak_to_peak),
            significant(measured.peak_to_peak_uncertainty / ARCMIN, 2)
        )));
    }
    if !bench.orders.is_empty() {
        let order = |(named, uncertainty): &(NamedOrder, f64)| {
            let doubt = significant(uncertainty / ARCMIN, 2);
            format!("{} ({} ± {doubt} arcmin)", named.order, arcmin(named.amplitude))
        };
        let orders: Vec<String> = bench.orders.iter().take(4).map(order).collect();
        blocks.push(TextBlock::line(format!("strongest measured orders: {}", orders.join(", "))));
    }
    blocks.extend(bench.remarks.iter().map(|remark| TextBlock::line(remark.clone())));
    blocks
}

/// Torques whose efficiency the terminal shows, by their place in the map: from 10 % of the rated one.
const SHOWN: std::ops::Range<usize> = 1..7;

/// Running torque without load and efficiency, speed by speed, as catalogues print them.
fn efficiencies(rig: &Rig) -> Option<TextBlock> {
    let (map, torques) = (rig.state().efficiency.as_ref()?, rig.state().torques.as_ref()?);
    let ratio = rig.machine.kinematics().ratio().abs();
    let mut header: Vec<String> =
        ["input rpm", "output rpm", "no load N·m", "at output N·m"].map(str::to_owned).to_vec();
    let torque = |torque: &f64| format!("{} N·m %", significant(*torque, 3));
    header.extend(map.torques.get(SHOWN)?.iter().map(torque));
    let row = |((speed, efficiency), (_, no_load)): ((&f64, &Vec<f64>), &(f64, f64))| {
        let mut row = vec![
            format!("{:.0}", speed / RPM),
            significant(speed / RPM / ratio, 3),
            significant(*no_load, 3),
            significant(no_load * ratio, 3),
        ];
        row.extend(efficiency[SHOWN].iter().map(|e| format!("{:.1}", 100.0 * e)));
        row
    };
    let rows = map.speeds.iter().zip(&map.efficiency).zip(&torques.over_speed).map(row).collect();
    Some(TextBlock::Table(TextTable { header, rows }))
}

pub(super) fn page(rig: &Rig) -> Page {
    let mut page = RigPage {
        machine: &rig.machine,
        provenance: Provenance::default(),
        new: &rig.new,
        worn: rig.worn.as_ref().map(|(state, _)| state),
        measured: rig.measured.as_ref(),
        errors: (!rig.fidelity.errors.is_zero())
            .then(|| format!("{}.", capitalised(&rig.fidelity.sentence()))),
        friction_assumed: rig.friction_assumed,
    }
    .page();
    page.verdict.answers.push(("Which physics".to_owned(), rig.fidelity.sentence()));
    if let Some(at) = rig.causes_at().last() {
        let shares = causes::shares(at, Some(rig.state().lost_motion()));
        let section = Section::new("causes", "Lost motion by cause", vec![shares]);
        page.sections.insert(1, section);
    }
    page
}
