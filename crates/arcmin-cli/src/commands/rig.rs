use std::path::PathBuf;
use std::time::Instant;

use arcmin::dynamics::{JointSettings, order_spectrum};
use arcmin::life::{PartsPoint, lost_motion_causes, worn_settings};
use arcmin::machine::{Friction, Machine};
use arcmin::report::Provenance;
use arcmin::report::rig::{RigPage, RigState};
use arcmin::rig::{
    ASSUMED_FRICTION, ErrorCurve, NamedOrder, TransmissionSettings, bearing_loads, efficiency_map,
    evaluate_loop, hysteresis_loop, name_orders, running_torques, stiffness_split, transmission_error_curves,
};
use arcmin::units::ARCMIN;
use serde_json::{Value, json};

use super::deviations::Deviations;
use super::joints::Joints;
use crate::failure::Failure;
use crate::run::{Common, Run, Verdict};

mod measured;
mod results;

#[derive(Debug, clap::Args)]
#[command(
    long_about = "Virtual test bench: every body free in its bearings, no inertia. Input locked, output torque cycled to ± rated: hysteresis loop, lost motion \
                  (mid-points at ± 3 %), backlash (width at zero torque), torsional stiffness (50–100 % of rated torque); then one output turn in both \
                  directions, held lightly and at rated torque; efficiency, running torques, bearing loads and lives.\n\n\
                  hysteresis.csv: torque_n_m, angle_arcmin, branch. spectrum.csv: order, amplitude_arcmin (rated torque, forward).\n\
                  te.csv: output_angle_deg, te_arcmin, direction, torque_n_m. stiffness.csv, bearings.csv, bearing_forces.csv, efficiency.csv, \
                  lost_motion_causes.csv; errors.csv with manufacturing errors.\n\n\
                  A design without friction is tested with assumed coefficients, and the run says so; --frictionless switches that off.",
    after_help = "Examples:\n  arcmin rig my-reducer.toml\n  arcmin rig my-reducer.toml --hours 2000\n  arcmin rig my-reducer.toml --flexible\n  arcmin rig my-reducer.toml --measured loop.csv"
)]
pub struct Options {
    #[command(flatten)]
    common: Common,
    /// Flanks and pins as the coupled wear prediction leaves them after H hours at the design's duty; the new
    /// machine is tested as well.
    #[arg(long, value_name = "H", value_parser = crate::run::hours)]
    hours: Option<f64>,
    /// A measured curve, evaluated by the same code and drawn over ours; may be given several times. A loop
    /// has the columns torque_n_m, angle_arcmin, branch (falling or rising); a transmission error has
    /// output_angle_deg, te_arcmin and, if several, direction, torque_n_m.
    #[arg(long, value_name = "CSV")]
    measured: Vec<PathBuf>,
    /// Crank positions at which the loop is run.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=360))]
    positions: u16,
    /// Positions over the output turn.
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(64..=65536))]
    te_positions: u32,
    #[command(flatten)]
    deviations: super::deviations::Options,
    /// Elastic discs (finite elements), their bores moved by the bearings.
    #[arg(long)]
    flexible: bool,
    #[command(flatten)]
    elastic: super::elastic::Options,
    /// No friction, even where the design gives none and some would be assumed.
    #[arg(long)]
    frictionless: bool,
}

pub fn run(options: Options) -> Result<Verdict, Failure> {
    let started = Instant::now();
    let mut run = Run::start("rig", &options.common)?;
    let mut machine = run.design.machine();
    let assumed = assume_friction(&mut machine, options.frictionless);
    if assumed {
        run.say("friction: assumed (flank 0.06, bearings 0.002, gear mesh 0.06, seals 4 N·m): the design gives none");
    }
    let deviations = Deviations::with_joints(
        &mut run,
        &options.common.design,
        &machine,
        &options.deviations,
        Joints::Bearings,
    )?;
    let discs = options
        .flexible
        .then(|| super::elastic::in_bearings(&run, &machine, &options.elastic))
        .transpose()?;
    let as_made =
        JointSettings { errors: deviations.errors.clone(), discs: discs.clone(), ..JointSettings::default() };
    let measured = measured::read(&options.measured, &machine)?;
    let new = test(&run, &machine, &as_made, 0.0, &options)?;
    let worn = match options.hours {
        Some(hours) if hours > 0.0 => {
            let worn = worn_settings(&machine, hours).map_err(Failure::compute("compute the wear"))?;
            let worn = JointSettings { errors: deviations.errors.clone(), discs: discs.clone(), ..worn };
            let causes =
                lost_motion_causes(&machine, &worn).map_err(Failure::compute("split the lost motion"))?;
            Some((test(&run, &machine, &worn, hours, &options)?, causes))
        }
        _ => None,
    };
    let new_causes =
        lost_motion_causes(&machine, &as_made).map_err(Failure::compute("split the lost motion"))?;
    let (worn, worn_causes) = worn.unzip();
    let causes: Vec<(f64, &PartsPoint)> = [
        (0.0, new_causes.as_ref()),
        (options.hours.unwrap_or(0.0), worn_causes.as_ref().and_then(Option::as_ref)),
    ]
    .into_iter()
    .filter_map(|(hours, point)| Some((hours, point?)))
    .collect();
    if !causes.is_empty() {
        run.table("lost_motion_causes.csv", super::causes::table(causes.iter().copied()))?;
    }
    let state = worn.as_ref().unwrap_or(&new);
    results::write(&mut run, state)?;
    let page = RigPage {
        machine: &machine,
        provenance: Provenance {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            design_hash: run.design.hash(),
            command: std::env::args().skip(1).collect::<Vec<_>>().join(" "),
            seeds: deviations.seeds(),
        },
        new: &new,
        worn: worn.as_ref(),
        measured: measured.as_ref(),
        errors: deviations.sentence(),
        friction_assumed: assumed,
    };
    let mut page = page.page();
    if let Some((hours, point)) = causes.last() {
        page.sections.insert(1, super::causes::shares(*hours, point));
    }
    if let Some(discs) = discs {
        // Literature stays last.
        let last = page.sections.len().saturating_sub(1);
        page.sections
            .insert(last, super::elastic::section(&machine, &options.elastic, discs.discs().clone())?);
    }
    run.file("report.html", page.render().as_bytes())?;
    let figure = |state: &RigState| {
        json!({
            "hours": state.hours,
            "lost_motion_arcmin": state.lost_motion() / ARCMIN,
            "backlash_arcmin": state.backlash() / ARCMIN,
            "stiffness_nm_per_arcmin": state.stiffness() * ARCMIN,
            "soft_stiffness_nm_per_arcmin": state.soft_stiffness() * ARCMIN,
            "efficiency": state.efficiency.rated,
        })
    };
    let Value::Object(mut summary) = figure(state) else { unreachable!("an object") };
    summary.insert("new".to_owned(), figure(&new));
    summary.insert("errors".to_owned(), deviations.summary());
    summary.insert("elastic_discs".to_owned(), json!(options.flexible));
    summary.insert("friction_assumed".to_owned(), json!(assumed));
    summary.insert("no_load_running_torque_n_m".to_owned(), json!(state.torques.no_load));
    summary.insert("starting_torque_n_m".to_owned(), json!(state.torques.starting));
    summary.insert("back_driving_torque_n_m".to_owned(), json!(state.torques.back_driving));
    summary.insert("transmission_error".to_owned(), curves_summary(&state.curves));
    summary.insert("orders".to_owned(), orders_summary(&state.orders));
    if let Some(measured) = &measured {
        summary.insert("measured".to_owned(), measured::summary(measured));
    }
    summary.insert(
        "lost_motion_causes".to_owned(),
        causes.last().map_or(Value::Null, |(_, point)| super::causes::summary(point)),
    );
    summary.insert("wall_s".to_owned(), json!(started.elapsed().as_secs_f64()));
    run.say(&results::terminal(&new, worn.as_ref(), measured.as_ref()));
    if let Some((_, point)) = causes.last() {
        run.say(&format!("{}, friction aside", super::causes::say(point)));
    }
    run.finish(Value::Object(summary))?;
    Ok(Verdict::Fine)
}

fn curves_summary(curves: &[ErrorCurve]) -> Value {
    let one = |c: &ErrorCurve| json!({ "direction": c.direction, "torque_n_m": c.torque, "mean_arcmin": c.mean() / ARCMIN, "peak_to_peak_arcmin": c.peak_to_peak() / ARCMIN });
    curves.iter().map(one).collect()
}

pub(super) fn orders_summary(orders: &[NamedOrder]) -> Value {
    orders
        .iter()
        .map(|o| json!({ "order": o.order, "amplitude_arcmin": o.amplitude / ARCMIN, "cause": o.cause }))
        .collect()
}

/// Puts in the assumed friction where the design has none at all; tells whether it did.
fn assume_friction(machine: &mut Machine, frictionless: bool) -> bool {
    let f = &machine.friction;
    let none = [f.flank, f.pin_seat, f.bearing, f.gear_mesh, f.seal_drag, f.oil_drag]
        .iter()
        .all(|value| *value == 0.0);
    if frictionless {
        machine.friction =
            Friction { regularisation_speed: machine.friction.regularisation_speed, ..Friction::default() };
        return false;
    }
    if none {
        machine.friction =
            Friction { regularisation_speed: machine.friction.regularisation_speed, ..ASSUMED_FRICTION };
    }
    none
}

/// All tests of one state of the machine.
fn test(
    run: &Run,
    machine: &Machine,
    settings: &JointSettings,
    hours: f64,
    options: &Options,
) -> Result<RigState, Failure> {
    use rayon::prelude::*;
    let failure = || Failure::compute("run the test bench");
    let ratio = machine.kinematics().housing_fixed_ratio();
    let turn = std::f64::consts::TAU * ratio / (machine.ring.pin_count as f64 - 1.0);
    let suns: Vec<f64> =
        (0..options.positions).map(|i| turn * f64::from(i) / f64::from(options.positions)).collect();
    run.progress().report("hysteresis loops", 0.0);
    let loops = suns
        .par_iter()
        .map(|sun| hysteresis_loop(machine, settings, *sun))
        .collect::<Result<Vec<_>, _>>()
        .map_err(failure())?;
    let rated = machine.rated.torque.abs();
    let figures = loops
        .iter()
        .map(|points| evaluate_loop(points, rated))
        .collect::<Result<Vec<_>, _>>()
        .map_err(failure())?;
    let split = stiffness_split(machine, settings, suns[0]).map_err(failure())?;
    run.progress().report("transmission error", 0.4);
    let test = TransmissionSettings {
        positions: options.te_positions as usize,
        ..TransmissionSettings::new(machine)
    };
    let curves = transmission_error_curves(machine, settings, test).map_err(failure())?;
    let spectrum = curves.get(2).and_then(|curve| order_spectrum(&curve.points)).unwrap_or_default();
    run.progress().report("efficiency", 0.8);
    let efficiency = efficiency_map(machine, settings).map_err(failure())?;
    let torques = running_torques(machine, settings).map_err(failure())?;
    let bearings = bearing_loads(machine, settings, 72).map_err(failure())?;
    Ok(RigState {
        hours,
        loops,
        figures,
        split,
        curves,
        orders: name_orders(&spectrum, machine, test.positions, 8),
        spectrum,
        efficiency,
        torques,
        bearings,
    })
}
