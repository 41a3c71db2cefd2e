use arcmin::dynamics::BearingMeshing;
use arcmin::geometry::Relief;
use arcmin::load::{Cycle, PinLoad, ShareLoad, closed_form};
use arcmin::machine::{CrankAngle, Machine, ManufacturingErrors};
use arcmin::units::{DEG, MPA, UM};
use serde_json::{Value, json};

use super::deviations::{Choice, Deviations};
use super::joints::{Joints, bearing_meshing, refuse_beyond};
use crate::failure::Failure;
use crate::run::{Cell, Common, Run, Table, Verdict};

#[derive(Debug, clap::Args)]
#[command(
    long_about = "Shares the output torque among the pins over one turn of the crankshaft, input locked.\n\n\
                  The equilibrium method finds the pose in which all forces and moments vanish, with the real gaps of both flanks; the closed form is \
                  the handbook method of Tao2024 (eqs. 5-10) at one crank position.\n\n\
                  contact.csv: crank_angle_deg, disc, pin (both counted from 0), meshing_angle_deg, force_n, pressure_mpa, half_width_um, gap_um.\n\
                  error.csv: crank_angle_deg, te_loaded_arcmin, torsional_stiffness_nm_per_arcmin. spectrum of the loaded error (ideal joints): harmonics.csv.\n\n\
                  With bearings, manufacturing errors act: those of the design's [errors], or a machine drawn from its [tolerances]. Errors of single pins \
                  repeat after a turn of the output; the figures are those of that whole turn, and pins.csv tells what every pin bears in it (disc, pin, \
                  max_force_n, at_meshing_angle_deg, mean_force_n, loaded_share), while contact.csv shows the first turn of the crankshaft.",
    after_help = "Examples:\n  arcmin contact my-reducer.toml\n  arcmin contact my-reducer.toml --torque-nm 100 --wear-um 10\n  \
                  arcmin contact my-reducer.toml --joints bearings --flexible\n  arcmin contact my-reducer.toml --joints bearings --errors drawn --seed 7\n  \
                  arcmin contact my-reducer.toml --method closed-form"
)]
pub struct Options {
    #[command(flatten)]
    common: Common,
    /// How to share the load.
    #[arg(long, value_enum, default_value = "equilibrium")]
    method: Method,
    /// Joints between the bodies; with bearings the error is that of the whole machine, input locked, and the
    /// discs need not carry alike.
    #[arg(long, value_enum, default_value = "ideal")]
    joints: Joints,
    /// Share the load on elastic discs (finite elements; equilibrium).
    #[arg(long)]
    flexible: bool,
    #[command(flatten)]
    deviations: super::deviations::Options,
    #[command(flatten)]
    elastic: super::elastic::Options,
    /// Output torque in N·m, positive against positive output motion [default: the rated torque].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    torque_nm: Option<f64>,
    /// Depth removed from the whole flank in µm.
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = crate::run::depth_um)]
    wear_um: f64,
    /// Crank positions per turn.
    #[arg(long, value_name = "N", default_value_t = 360, value_parser = clap::value_parser!(u32).range(8..=36_000))]
    positions: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Method {
    /// Force and moment balance with the real gaps.
    Equilibrium,
    /// Handbook method of Tao2024.
    ClosedForm,
}

pub fn run(options: Options) -> Result<Verdict, Failure> {
    let mut run = Run::start("contact", &options.common)?;
    let machine = run.design.machine();
    let torque = options.torque_nm.unwrap_or(machine.rated.torque);
    let mut table = Table::new(&[
        "crank_angle_deg",
        "disc",
        "pin",
        "meshing_angle_deg",
        "force_n",
        "pressure_mpa",
        "half_width_um",
        "gap_um",
    ]);
    if options.method == Method::ClosedForm {
        refuse_beyond("the closed form", "--method", options.joints, options.flexible)?;
    }
    let deviations = Deviations::with_joints(
        &mut run,
        &options.common.design,
        &machine,
        &options.deviations,
        options.joints,
    )?;
    let summary = match options.method {
        Method::Equilibrium => match options.joints {
            Joints::Ideal if options.flexible => {
                let meshing = super::elastic::meshing(&run, &machine, &options.elastic)?;
                equilibrium(&mut run, &options, meshing, &machine, torque, &mut table)?
            }
            Joints::Ideal => equilibrium(
                &mut run,
                &options,
                machine.meshing(&Relief::uniform(0.0)),
                &machine,
                torque,
                &mut table,
            )?,
            Joints::Bearings => {
                let discs = options
                    .flexible
                    .then(|| super::elastic::in_bearings(&run, &machine, &options.elastic))
                    .transpose()?;
                let made = bearing_meshing(&machine, &deviations.errors, discs.clone())?;
                let mut summary = equilibrium(&mut run, &options, made, &machine, torque, &mut table)?;
                if deviations.choice != Choice::None {
                    let drawn = bearing_meshing(&machine, &ManufacturingErrors::default(), discs)?;
                    summary["nominal"] = nominal(&run, &options, drawn, &machine, torque)?;
                }
                summary
            }
        },
        Method::ClosedForm => closed_form(&run, &options, &machine, torque, &mut table)?,
    };
    let mut summary = summary;
    summary["errors"] = deviations.summary();
    run.table("contact.csv", table)?;
    run.finish(summary)?;
    Ok(Verdict::Fine)
}

/// Crank positions of the figures of a cycle; where it takes a turn of the output, enough for every pin to
/// meet every disc at many angles.
fn cycle_positions<S: ShareLoad>(meshing: &S) -> usize {
    if meshing.discs_alike() { 72 } else { 720 }
}

/// What the machine without errors would bear.
fn nominal(
    run: &Run,
    options: &Options,
    mut meshing: BearingMeshing,
    machine: &Machine,
    torque: f64,
) -> Result<Value, Failure> {
    meshing.set_relief(machine.designed_relief().plus(&Relief::uniform(options.wear_um * UM)));
    let cycle = meshing.whole_cycle(torque, 72).map_err(Failure::compute("share the load"))?;
    let (force, error) = (cycle.max_force(), cycle.mean_error().arcmin());
    run.say(&format!("without errors: largest force {force:.1} N, loaded transmission error {error:.4}', one-sided play {:.4}'", cycle.mean_play().arcmin()));
    Ok(json!({
        "max_force_n": force,
        "loaded_pairs": cycle.loaded_pairs(),
        "te_loaded_arcmin": error,
        "te_loaded_peak_to_peak_arcmin": cycle.peak_to_peak_error().arcmin(),
        "play_arcmin": cycle.mean_play().arcmin(),
    }))
}

/// pins.csv, and a line about the pins that bear most and least.
fn pins(run: &mut Run, cycle: &Cycle) -> Result<String, Failure> {
    let loads = cycle.pin_loads();
    let mut table =
        Table::new(&["disc", "pin", "max_force_n", "at_meshing_angle_deg", "mean_force_n", "loaded_share"]);
    for load in &loads {
        table.row(&[
            load.disc.into(),
            load.pin.into(),
            load.max_force.into(),
            (load.max_force_at / DEG).into(),
            load.mean_force.into(),
            load.loaded_share.into(),
        ]);
    }
    run.table("pins.csv", table)?;
    let by_mean = |a: &&PinLoad, b: &&PinLoad| a.mean_force.total_cmp(&b.mean_force);
    let (Some(most), Some(least)) = (loads.iter().max_by(by_mean), loads.iter().min_by(by_mean)) else {
        unreachable!("a ring has pins")
    };
    let one = |load: &PinLoad| {
        format!(
            "pin {} on disc {}: {:.1} N in the mean, {:.1} N at most",
            load.pin + 1,
            load.disc + 1,
            load.mean_force,
            load.max_force
        )
    };
    Ok(format!(
        "bears most: {}\nbears least: {} (pins and discs counted from 1 as in the design)",
        one(most),
        one(least)
    ))
}

fn equilibrium<S: ShareLoad>(
    run: &mut Run,
    options: &Options,
    mut meshing: S,
    machine: &Machine,
    torque: f64,
    table: &mut Table,
) -> Result<Value, Failure> {
    meshing.set_relief(machine.designed_relief().plus(&Relief::uniform(options.wear_um * UM)));
    let contact = meshing.contacts().contact().clone();
    let mut errors =
        Table::new(&["crank_angle_deg", "te_loaded_arcmin", "torsional_stiffness_nm_per_arcmin"]);
    let mut start = None;
    for index in 0..options.positions {
        let crank = CrankAngle::from_degrees(360.0 * f64::from(index) / f64::from(options.positions));
        let (sharing, found) =
            meshing.share(crank, torque, start.as_ref()).map_err(Failure::compute("share the load"))?;
        for (disc, pins) in sharing.discs.iter().enumerate() {
            for c in pins {
                let radius = 1.0 / c.relative_curvature;
                table.row(&[
                    crank.degrees().into(),
                    disc.into(),
                    c.pin.into(),
                    (c.meshing_angle / DEG).into(),
                    c.force.into(),
                    (contact.pressure(c.force, radius) / MPA).into(),
                    (contact.half_width(c.force, radius) / UM).into(),
                    (c.gap / UM).into(),
                ]);
            }
        }
        errors.row(&[
            crank.degrees().into(),
            sharing.output_error.arcmin().into(),
            (sharing.stiffness * arcmin::units::ARCMIN).into(),
        ]);
        start = Some(found);
    }
    run.table("error.csv", errors)?;
    // With ideal joints the pattern repeats every pin pitch: one pitch, finely, gives the figures of the
    // cycle; with bearings a turn of the crankshafts, with errors of the ring a turn of the output.
    let positions = cycle_positions(&meshing);
    let cycle = meshing.whole_cycle(torque, positions).map_err(Failure::compute("share the load"))?;
    let of_pins = if meshing.discs_alike() { None } else { Some(pins(run, &cycle)?) };
    if meshing.pitches() == 1 {
        let mut harmonics = Table::new(&["order", "amplitude_arcmin"]);
        let kinematics = meshing.kinematics();
        for harmonic in cycle.harmonics(kinematics.lobe_count, kinematics.pin_count) {
            harmonics.row(&[harmonic.order.into(), (harmonic.amplitude / arcmin::units::ARCMIN).into()]);
        }
        run.table("harmonics.csv", harmonics)?;
    }
    let shares: Vec<f64> = (0..machine.disc_count).map(|disc| cycle.disc_share(disc)).collect();
    let stiffness = cycle.positions.iter().map(|p| p.stiffness).sum::<f64>() / cycle.positions.len() as f64
        * arcmin::units::ARCMIN;
    run.say(&format!(
        "largest force {:.1} N   {:.1} loaded pairs per disc   largest pressure {:.0} MPa\n\
         loaded transmission error {:.4}' (peak to peak {:.4}')   one-sided play {:.4}'   stiffness{} {:.0} N·m/arcmin\n\
         torque per disc: {}",
        cycle.max_force(),
        cycle.loaded_pairs(),
        cycle.max_pressure(&contact) / MPA,
        cycle.mean_error().arcmin(),
        cycle.peak_to_peak_error().arcmin(),
        cycle.mean_play().arcmin(),
        if options.joints == Joints::Ideal { " of the teeth" } else { "" },
        stiffness,
        shares.iter().map(|share| format!("{share:.4} T")).collect::<Vec<_>>().join(", ")
    ));
    of_pins.iter().for_each(|line| run.say(line));
    Ok(json!({
        "method": "equilibrium",
        "joints": options.joints.word(),
        "elastic_discs": options.flexible,
        "disc_torque_shares": shares,
        "torque_n_m": torque,
        "wear_um": options.wear_um,
        "mean_over": {
            "crank_positions": positions,
            "pin_pitches": meshing.pitches(),
        },
        "max_force_n": cycle.max_force(),
        "loaded_pairs": cycle.loaded_pairs(),
        "max_pressure_mpa": cycle.max_pressure(&contact) / MPA,
        "te_loaded_arcmin": cycle.mean_error().arcmin(),
        "te_loaded_peak_to_peak_arcmin": cycle.peak_to_peak_error().arcmin(),
        "play_arcmin": cycle.mean_play().arcmin(),
        "free_travel_arcmin": cycle.mean_free_travel().arcmin(),
        "torsional_stiffness_nm_per_arcmin": stiffness,
        "largest_torque_residual_n_m": cycle.positions.iter().map(|p| p.residual.abs()).fold(0.0, f64::max),
    }))
}

/// Both discs carry the same; the loaded flank has the sign of the torque's meshing angles.
fn closed_form(
    run: &Run,
    options: &Options,
    machine: &Machine,
    torque: f64,
    table: &mut Table,
) -> Result<Value, Failure> {
    let solution = closed_form::solve(machine, torque.abs(), options.wear_um * UM)
        .map_err(Failure::compute("share the load"))?;
    let profile = machine.profile();
    let contact = machine.line_contact();
    let side = if torque < 0.0 { 1.0 } else { -1.0 };
    let mut max_pressure = 0.0f64;
    for disc in 0..machine.disc_count {
        for (index, pair) in solution.pairs.iter().enumerate() {
            let radius = 1.0 / profile.relative_curvature(pair.meshing_angle.cos(), machine.ring.pin_radius);
            let pressure = contact.pressure(pair.force, radius);
            max_pressure = max_pressure.max(pressure);
            // Pins are counted around the ring from the eccentric, towards the loaded side.
            let pin = if side > 0.0 { index + 1 } else { machine.ring.pin_count - 1 - index };
            table.row(&[
                Cell::Number(0.0),
                disc.into(),
                pin.into(),
                (side * pair.meshing_angle / DEG).into(),
                pair.force.into(),
                (pressure / MPA).into(),
                (contact.half_width(pair.force, radius) / UM).into(),
                (pair.initial_gap / UM).into(),
            ]);
        }
    }
    let largest = solution.pairs.iter().map(|pair| pair.force).fold(0.0, f64::max);
    run.say(&format!(
        "closed form: F_max {:.2} N at the largest lever arm, largest pair {largest:.2} N, {} loaded pairs, largest pressure {:.0} MPa",
        solution.max_force,
        solution.loaded_pairs(),
        max_pressure / MPA
    ));
    // Play by the equilibrium's geometry: the closed form has none.
    let cycle = machine
        .meshing(&Relief::uniform(options.wear_um * UM))
        .cycle(torque, 36)
        .map_err(Failure::compute("share the load"))?;
    Ok(json!({
        "method": "closed-form",
        "torque_n_m": torque,
        "wear_um": options.wear_um,
        "max_force_n": solution.max_force,
        "max_pair_force_n": largest,
        "first_guess_max_force_n": closed_form::first_max_force(machine, torque.abs()),
        "loaded_pairs": solution.loaded_pairs(),
        "max_pressure_mpa": max_pressure / MPA,
        "max_approach_um": solution.max_approach / UM,
        "smallest_initial_gap_um": solution.smallest_gap() / UM,
        "te_loaded_arcmin": Value::Null,
        "play_arcmin": cycle.mean_play().arcmin(),
    }))
}
