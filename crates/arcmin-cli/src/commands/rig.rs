use std::path::{Path, PathBuf};
use std::time::Instant;

use arcmin::dynamics::{JointSettings, order_spectrum};
use arcmin::machine::{Friction, Machine};
use arcmin::report::rig::{RigPage, RigState};
use arcmin::report::Provenance;
use arcmin::rig::{
    ASSUMED_FRICTION, Branch, LoopPoint, TransmissionSettings, bearing_loads, efficiency_map, evaluate_loop, hysteresis_loop, name_orders, running_torques,
    stiffness_split, transmission_error_curves,
};
use arcmin::units::{ARCMIN, DEG};
use arcmin::life::{PartsPoint, lost_motion_causes, worn_settings};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::run::{Cell, Common, Run, Table, Verdict};

#[derive(Debug, clap::Args)]
#[command(
    long_about = "Virtual test bench: every body free in its bearings, no inertia. Input locked, output torque cycled to ± rated: hysteresis loop, lost motion \
                  (mid-points at ± 3 %), backlash (width at zero torque), torsional stiffness (50–100 % of rated torque); then one output turn in both \
                  directions, held lightly and at rated torque; efficiency, running torques, bearing loads and lives.\n\n\
                  hysteresis.csv: torque_n_m, angle_arcmin, branch. spectrum.csv: order, amplitude_arcmin (rated torque, forward).\n\
                  te.csv: output_angle_deg, te_arcmin, direction, torque_n_m. stiffness.csv, bearings.csv, efficiency.csv, lost_motion_causes.csv.\n\n\
                  A design without friction is tested with assumed coefficients, and the run says so; --frictionless switches that off.",
    after_help = "Examples:\n  arcmin rig my-reducer.toml\n  arcmin rig my-reducer.toml --hours 2000\n  arcmin rig my-reducer.toml --measured loop.csv"
)]
pub struct Options {
    #[command(flatten)]
    common: Common,
    /// Flanks and pins as the coupled wear prediction leaves them after H hours at the design's duty; the new machine is tested as well.
    #[arg(long, value_name = "H", value_parser = crate::run::hours)]
    hours: Option<f64>,
    /// A measured loop, CSV with the columns torque_n_m, angle_arcmin, branch (falling or rising): evaluated by the same code.
    #[arg(long, value_name = "CSV")]
    measured: Option<PathBuf>,
    /// Crank positions at which the loop is run.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=360))]
    positions: u16,
    /// Positions over the output turn.
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(64..=65536))]
    te_positions: u32,
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
    let new = test(&run, &machine, &JointSettings::default(), 0.0, &options)?;
    let worn = match options.hours {
        Some(hours) if hours > 0.0 => {
            let settings = worn_settings(&machine, hours).map_err(Failure::compute("compute the wear"))?;
            let causes = lost_motion_causes(&machine, &settings).map_err(Failure::compute("split the lost motion"))?;
            Some((test(&run, &machine, &settings, hours, &options)?, causes))
        }
        _ => None,
    };
    let new_causes = lost_motion_causes(&machine, &JointSettings::default()).map_err(Failure::compute("split the lost motion"))?;
    let (worn, worn_causes) = worn.unzip();
    let causes: Vec<(f64, &PartsPoint)> = [(0.0, new_causes.as_ref()), (options.hours.unwrap_or(0.0), worn_causes.as_ref().and_then(Option::as_ref))]
        .into_iter()
        .filter_map(|(hours, point)| Some((hours, point?)))
        .collect();
    if !causes.is_empty() {
        run.table("lost_motion_causes.csv", super::causes::table(causes.iter().copied()))?;
    }
    let state = worn.as_ref().unwrap_or(&new);
    let measured = options.measured.as_deref().map(read_loop).transpose()?;
    let measured_figures =
        measured.as_ref().map(|points| evaluate_loop(points, machine.rated.torque.abs())).transpose().map_err(Failure::compute("evaluate the measured loop"))?;
    tables(&mut run, state)?;
    let page = RigPage {
        machine: &machine,
        provenance: Provenance {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            design_hash: run.design.hash(),
            command: std::env::args().skip(1).collect::<Vec<_>>().join(" "),
            seeds: Vec::new(),
        },
        new: &new,
        worn: worn.as_ref(),
        measured: measured.as_deref().zip(measured_figures),
        friction_assumed: assumed,
    };
    let mut page = page.page();
    if let Some((hours, point)) = causes.last() {
        page.sections.insert(1, super::causes::shares(*hours, point));
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
    summary.insert("friction_assumed".to_owned(), json!(assumed));
    summary.insert("no_load_running_torque_n_m".to_owned(), json!(state.torques.no_load));
    summary.insert("starting_torque_n_m".to_owned(), json!(state.torques.starting));
    summary.insert("back_driving_torque_n_m".to_owned(), json!(state.torques.back_driving));
    summary.insert(
        "transmission_error".to_owned(),
        json!(
            state
                .curves
                .iter()
                .map(|c| json!({ "direction": c.direction, "torque_n_m": c.torque, "mean_arcmin": c.mean() / ARCMIN, "peak_to_peak_arcmin": c.peak_to_peak() / ARCMIN }))
                .collect::<Vec<_>>()
        ),
    );
    summary.insert("orders".to_owned(), json!(state.orders.iter().map(|o| json!({ "order": o.order, "amplitude_arcmin": o.amplitude / ARCMIN, "cause": o.cause })).collect::<Vec<_>>()));
    if let Some(m) = measured_figures {
        summary.insert(
            "measured".to_owned(),
            json!({ "lost_motion_arcmin": m.lost_motion / ARCMIN, "backlash_arcmin": m.backlash / ARCMIN, "stiffness_nm_per_arcmin": m.stiffness * ARCMIN }),
        );
    }
    summary.insert("lost_motion_causes".to_owned(), causes.last().map_or(Value::Null, |(_, point)| super::causes::summary(point)));
    summary.insert("wall_s".to_owned(), json!(started.elapsed().as_secs_f64()));
    run.say(&terminal_table(&new, worn.as_ref(), measured_figures.as_ref()));
    if let Some((_, point)) = causes.last() {
        run.say(&format!("{}, friction aside", super::causes::say(point)));
    }
    run.finish(Value::Object(summary))?;
    Ok(Verdict::Fine)
}

/// Puts in the assumed friction where the design has none at all; tells whether it did.
fn assume_friction(machine: &mut Machine, frictionless: bool) -> bool {
    let f = &machine.friction;
    let none = [f.flank, f.pin_seat, f.bearing, f.gear_mesh, f.seal_drag, f.oil_drag].iter().all(|value| *value == 0.0);
    if frictionless {
        machine.friction = Friction { regularisation_speed: machine.friction.regularisation_speed, ..Friction::default() };
        return false;
    }
    if none {
        machine.friction = Friction { regularisation_speed: machine.friction.regularisation_speed, ..ASSUMED_FRICTION };
    }
    none
}

/// All tests of one state of the machine.
fn test(run: &Run, machine: &Machine, settings: &JointSettings, hours: f64, options: &Options) -> Result<RigState, Failure> {
    use rayon::prelude::*;
    let failure = || Failure::compute("run the test bench");
    let ratio = machine.kinematics().housing_fixed_ratio();
    let turn = std::f64::consts::TAU * ratio / (machine.ring.pin_count as f64 - 1.0);
    let suns: Vec<f64> = (0..options.positions).map(|i| turn * f64::from(i) / f64::from(options.positions)).collect();
    run.progress().report("hysteresis loops", 0.0);
    let loops = suns.par_iter().map(|sun| hysteresis_loop(machine, settings, *sun)).collect::<Result<Vec<_>, _>>().map_err(failure())?;
    let rated = machine.rated.torque.abs();
    let figures = loops.iter().map(|points| evaluate_loop(points, rated)).collect::<Result<Vec<_>, _>>().map_err(failure())?;
    let split = stiffness_split(machine, settings, suns[0]).map_err(failure())?;
    run.progress().report("transmission error", 0.4);
    let test = TransmissionSettings { positions: options.te_positions as usize, ..TransmissionSettings::new(machine) };
    let curves = transmission_error_curves(machine, settings, test).map_err(failure())?;
    let spectrum = curves.get(2).and_then(|curve| order_spectrum(&curve.points)).unwrap_or_default();
    run.progress().report("efficiency", 0.8);
    let efficiency = efficiency_map(machine, settings).map_err(failure())?;
    let torques = running_torques(machine, settings).map_err(failure())?;
    let bearings = bearing_loads(machine, settings, 72).map_err(failure())?;
    Ok(RigState { hours, loops, figures, split, curves, orders: name_orders(&spectrum, machine, 8), spectrum, efficiency, torques, bearings })
}

fn tables(run: &mut Run, state: &RigState) -> Result<(), Failure> {
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
            table.row(&[(angle / DEG).into(), (error / ARCMIN).into(), curve.direction.into(), curve.torque.into()]);
        }
    }
    run.table("te.csv", table)?;
    let mut table = Table::new(&["part", "compliance_arcmin_per_nm", "share"]);
    for (part, compliance) in &state.split.parts {
        table.row(&[part.name().into(), (compliance / ARCMIN).into(), (compliance / state.split.whole).into()]);
    }
    run.table("stiffness.csv", table)?;
    let mut table = Table::new(&["bearing", "mean_force_n", "largest_element_force_n", "equivalent_load_n", "rating_n", "l10_h"]);
    for b in &state.bearings {
        table.row(&[b.name.as_str().into(), b.mean_force().into(), b.largest_element.into(), b.equivalent.into(), b.rating.into(), b.life_h().into()]);
    }
    run.table("bearings.csv", table)?;
    let mut table = Table::new(&["input_speed_rpm", "torque_n_m", "efficiency"]);
    for (speed, row) in state.efficiency.speeds.iter().zip(&state.efficiency.efficiency) {
        for (torque, efficiency) in state.efficiency.torques.iter().zip(row) {
            table.row(&[Cell::Number(speed / arcmin::units::RPM), (*torque).into(), (*efficiency).into()]);
        }
    }
    run.table("efficiency.csv", table)
}

fn terminal_table(new: &RigState, worn: Option<&RigState>, measured: Option<&arcmin::rig::LoopFigures>) -> String {
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
    type Measured = Option<fn(&arcmin::rig::LoopFigures) -> f64>;
    let rows: [(&str, Value, Measured); 8] = [
        ("lost motion, arcmin", |s| s.lost_motion() / ARCMIN, Some(|m| m.lost_motion / ARCMIN)),
        ("backlash, arcmin", |s| s.backlash() / ARCMIN, Some(|m| m.backlash / ARCMIN)),
        ("stiffness 50–100 %, N·m/arcmin", |s| s.stiffness() * ARCMIN, Some(|m| m.stiffness * ARCMIN)),
        ("stiffness 3–15 %, N·m/arcmin", |s| s.soft_stiffness() * ARCMIN, Some(|m| m.soft_stiffness * ARCMIN)),
        ("TE at rated torque, peak to peak, arcmin", |s| s.curves.get(2).map_or(f64::NAN, |c| c.peak_to_peak()) / ARCMIN, None),
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
            row.push(of_measured.map_or(String::new(), |of| format!("{:.3}", of(measured))));
        }
        table.add_row(row);
    }
    table.to_string()
}

/// Reads a measured loop; the columns may stand in any order.
fn read_loop(path: &Path) -> Result<Vec<LoopPoint>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|cause| Failure::Read { path: path.to_owned(), cause })?;
    let wrong = |line: usize, what: &str| Failure::Usage {
        message: format!("{}, line {line}: {what}", path.display()),
        help: "a header torque_n_m,angle_arcmin,branch, then lines such as 12.4,0.31,falling".to_owned(),
    };
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let header: Vec<&str> = lines.next().map(|(_, line)| line.split(',').map(str::trim).collect()).unwrap_or_default();
    let column = |name: &str| header.iter().position(|h| *h == name).ok_or_else(|| wrong(1, &format!("no column {name}")));
    let (torque, angle, branch) = (column("torque_n_m")?, column("angle_arcmin")?, column("branch")?);
    let mut points = Vec::new();
    for (index, line) in lines {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let number = |column: usize| fields.get(column).and_then(|f| f.parse::<f64>().ok()).filter(|x| x.is_finite());
        let branch = match fields.get(branch) {
            Some(&"falling") => Branch::Falling,
            Some(&"rising") => Branch::Rising,
            _ => return Err(wrong(index + 1, "the branch is neither falling nor rising")),
        };
        match (number(torque), number(angle)) {
            (Some(torque), Some(angle)) => points.push(LoopPoint { torque, angle: angle * ARCMIN, branch }),
            _ => return Err(wrong(index + 1, "torque and angle are not numbers")),
        }
    }
    Ok(points)
}
