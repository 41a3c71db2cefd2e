use arcmin::geometry::Relief;
use arcmin::life::{LifePoint, accuracy};
use arcmin::load::{FlankForce, ShareLoad, closed_form};
use arcmin::machine::{Machine, ManufacturingErrors};
use arcmin::units::{DEG, HOUR, UM};
use arcmin::wear::calibrate::coupled_exposure;
use arcmin::wear::paper::PaperWear;
use arcmin::wear::{CoupledOptions, CoupledWear, WearError};
use serde_json::{Value, json};

use super::deviations::Deviations;
use super::joints::{Joints, bearing_meshing, refuse_beyond};
use crate::failure::Failure;
use crate::run::{Cell, Common, Run, Table, Verdict};

#[derive(Debug, clap::Args)]
#[command(
    long_about = "Wears flanks (and pins, where the design says so) over the hours of service at the design's duty.\n\n\
                  The coupled mode lets the worn flank change the load sharing: wear slows down by itself. The paper mode is the study of Tao2024: one \
                  uniform depth that grows by the largest k (F/B) xi of all pins.\n\n\
                  wear.csv: hours, meshing_angle_deg, depth_um, force_n, specific_sliding, disc (counted from 0; empty where all discs are alike). wear_history.csv: hours, max_depth_um, max_force_n, \
                  loaded_pairs, play_arcmin (one-sided, at the output, input locked).",
    after_help = "Examples:\n  arcmin wear my-reducer.toml\n  arcmin wear my-reducer.toml --mode paper\n  arcmin wear my-reducer.toml --hours 2000 --points 40"
)]
pub struct Options {
    #[command(flatten)]
    common: Common,
    /// Coupled to the load sharing, or the paper's uniform depth.
    #[arg(long, value_enum, default_value = "coupled")]
    mode: Mode,
    /// Joints between the bodies (coupled mode): with bearings the pins see the forces that clearances and
    /// elastic bearings leave them.
    #[arg(long, value_enum, default_value = "ideal")]
    joints: Joints,
    /// Share the load on elastic discs (finite elements; coupled mode).
    #[arg(long)]
    flexible: bool,
    #[command(flatten)]
    deviations: super::deviations::Options,
    #[command(flatten)]
    elastic: super::elastic::Options,
    /// Hours of service [default: the service life of the design].
    #[arg(long, value_name = "H", value_parser = crate::run::hours)]
    hours: Option<f64>,
    /// Times between new and the end at which results are written.
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    points: u32,
    /// Largest depth worn off between two updates of the flank in µm.
    #[arg(long, value_name = "X", default_value_t = CoupledOptions::default().depth_increment / UM, value_parser = increment_um)]
    increment_um: f64,
}

fn increment_um(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (1e-3..=1.0).contains(&value) => Ok(value),
        _ => {
            Err("an increment lies between 0.001 and 1 µm; the elastic approach of a contact is about 1.5 µm"
                .to_owned())
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Mode {
    Coupled,
    Paper,
}

/// Crank positions at which accuracy is evaluated.
const POSITIONS: usize = 36;

struct Tables {
    wear: Table,
    history: Table,
}

impl Tables {
    fn new() -> Tables {
        Tables {
            wear: Table::new(&[
                "hours",
                "meshing_angle_deg",
                "depth_um",
                "force_n",
                "specific_sliding",
                "disc",
            ]),
            history: Table::new(&[
                "hours",
                "max_depth_um",
                "max_force_n",
                "loaded_pairs",
                "play_arcmin",
                "max_depth_at_deg",
                "max_pin_depth_um",
                "lost_motion_arcmin",
            ]),
        }
    }

    fn history_row(
        &mut self,
        point: &LifePoint,
        max_force: f64,
        loaded_pairs: f64,
        worst: f64,
        pin_depth: f64,
    ) {
        self.history.row(&[
            point.hours.into(),
            (point.max_depth / UM).into(),
            max_force.into(),
            loaded_pairs.into(),
            point.play.arcmin().into(),
            (worst.abs() / DEG).into(),
            (pin_depth / UM).into(),
            point.lost_motion.arcmin().into(),
        ]);
    }
}

pub fn run(options: Options) -> Result<Verdict, Failure> {
    let mut run = Run::start("wear", &options.common)?;
    let machine = run.design.machine();
    let end = options.hours.unwrap_or(machine.limits.service_life / HOUR);
    let mut tables = Tables::new();
    if options.mode == Mode::Paper {
        refuse_beyond("the paper's study", "--mode", options.joints, options.flexible)?;
    }
    let deviations = Deviations::with_joints(
        &mut run,
        &options.common.design,
        &machine,
        &options.deviations,
        options.joints,
    )?;
    let summary = match options.mode {
        Mode::Coupled => match options.joints {
            Joints::Ideal if options.flexible => {
                let meshing = super::elastic::meshing(&run, &machine, &options.elastic)?;
                coupled(&run, &options, meshing.clone(), meshing, &machine, end, &mut tables)
            }
            Joints::Ideal => {
                let meshing = machine.meshing(&Relief::uniform(0.0));
                coupled(&run, &options, meshing.clone(), meshing, &machine, end, &mut tables)
            }
            Joints::Bearings => {
                let discs = options
                    .flexible
                    .then(|| super::elastic::in_bearings(&run, &machine, &options.elastic))
                    .transpose()?;
                let nominal = bearing_meshing(&machine, &ManufacturingErrors::default(), discs.clone())?;
                coupled(
                    &run,
                    &options,
                    nominal,
                    bearing_meshing(&machine, &deviations.errors, discs)?,
                    &machine,
                    end,
                    &mut tables,
                )
            }
        },
        Mode::Paper => paper(&run, &options, &machine, end, &mut tables),
    };
    let summary = summary.map_err(|error| match error {
        WearError::Stopped => Failure::Cancelled,
        error => Failure::compute("compute the wear")(error),
    })?;
    let mut summary = summary;
    summary["errors"] = deviations.summary();
    run.table("wear.csv", tables.wear)?;
    run.table("wear_history.csv", tables.history)?;
    run.finish(summary)?;
    Ok(Verdict::Fine)
}

/// `nominal` is what the design's wear coefficient is calibrated on, where it is.
fn coupled<S: ShareLoad>(
    run: &Run,
    options: &Options,
    nominal: S,
    meshing: S,
    machine: &Machine,
    end: f64,
    tables: &mut Tables,
) -> Result<Value, WearError> {
    let settings = CoupledOptions { depth_increment: options.increment_um * UM, ..CoupledOptions::default() };
    let exposure = coupled_exposure(machine, nominal, settings)?;
    let profile = machine.profile();
    let mut wear = CoupledWear::with(machine, meshing, settings);
    let mut last = None;
    for index in 0..=options.points {
        let share = f64::from(index) / f64::from(options.points);
        let hours = end * share;
        let mut stopped = false;
        wear.advance_until(exposure.at(hours * HOUR), |_| {
            stopped = run.progress().is_cancelled();
            stopped
        })?;
        if stopped {
            return Err(WearError::Stopped);
        }
        run.progress().report("wear", share);
        let flank = wear.state().flank().clone();
        let point = accuracy(machine, wear.meshing_mut(), &flank, hours, POSITIONS)?;
        let state = wear.state();
        for (disc, flank) in state.flanks.iter().enumerate() {
            let of_disc = (state.flanks.len() > 1).then_some(disc);
            let forces = &point.flank_forces[disc];
            for (phi, depth) in Relief::grid(settings.flank_points).zip(flank.samples()) {
                let sliding = profile.specific_sliding(phi.cos());
                tables.wear.row(&[
                    hours.into(),
                    (phi / DEG).into(),
                    (depth / UM).into(),
                    force_at(forces, phi).into(),
                    sliding.into(),
                    of_disc.into(),
                ]);
            }
        }
        tables.history_row(
            &point,
            point.max_force,
            point.loaded_pairs,
            point.max_depth_at,
            state.pin().deepest().0,
        );
        last = Some(point);
    }
    let Some(last) = last else { unreachable!("at least the new machine is evaluated") };
    run.say(&format!(
        "after {end:.0} h: {:.2} µm at {:.1}°, one-sided play {:.4}', largest force {:.0} N, k = {:.3e} 1/Pa, {} updates of the flank",
        last.max_depth / UM,
        last.max_depth_at.abs() / DEG,
        last.play.arcmin(),
        last.max_force,
        exposure.coefficient,
        wear.updates()
    ));
    Ok(json!({
        "mode": "coupled",
        "joints": options.joints.word(),
        "elastic_discs": options.flexible,
        "hours": end,
        "max_depth_um": last.max_depth / UM,
        "max_depth_at_deg": last.max_depth_at.abs() / DEG,
        "max_pin_depth_um": wear.state().pin().deepest().0 / UM,
        "play_arcmin": last.play.arcmin(),
        "lost_motion_arcmin": last.lost_motion.arcmin(),
        "wear_coefficient_per_pa": exposure.coefficient,
        "flank_updates": wear.updates(),
        "depth_increment_um": options.increment_um,
    }))
}

/// By straight lines between the contacts, which are sorted by meshing angle.
fn force_at(forces: &[FlankForce], phi: f64) -> f64 {
    let at = forces.partition_point(|force| force.meshing_angle < phi);
    match (forces.get(at.wrapping_sub(1)), forces.get(at)) {
        (Some(a), Some(b)) => {
            a.force
                + (b.force - a.force) * (phi - a.meshing_angle)
                    / (b.meshing_angle - a.meshing_angle).max(1e-12)
        }
        (Some(only), None) | (None, Some(only)) => only.force,
        (None, None) => 0.0,
    }
}

fn paper(
    run: &Run,
    options: &Options,
    machine: &Machine,
    end: f64,
    tables: &mut Tables,
) -> Result<Value, WearError> {
    let profile = machine.profile();
    let wear = PaperWear::deep_enough(machine, end)?;
    let mut last = None;
    for index in 0..=options.points {
        let hours = end * f64::from(index) / f64::from(options.points);
        let depth = wear.depth_at(hours).max(0.0);
        let flank = Relief::uniform(depth);
        let point = accuracy(machine, &mut machine.meshing(&flank), &flank, hours, POSITIONS)?;
        let solution = closed_form::solve(machine, machine.rated.torque.abs(), depth)?;
        for pair in &solution.pairs {
            let sliding = profile.specific_sliding(pair.meshing_angle.cos());
            tables.wear.row(&[
                hours.into(),
                (pair.meshing_angle / DEG).into(),
                (depth / UM).into(),
                pair.force.into(),
                sliding.into(),
                Cell::Empty,
            ]);
        }
        let worst = wear.worst_angle_at(depth);
        tables.history_row(&point, solution.max_force, solution.loaded_pairs() as f64, worst, 0.0);
        last = Some((point, worst));
    }
    let Some((last, worst)) = last else { unreachable!("at least the new machine is evaluated") };
    run.say(&format!(
        "after {end:.0} h: {:.2} µm everywhere, set by the pin at {:.1}°, one-sided play {:.4}', k = {:.3e} 1/Pa",
        last.max_depth / UM,
        worst / DEG,
        last.play.arcmin(),
        wear.exposure.coefficient
    ));
    Ok(json!({
        "mode": "paper",
        "hours": end,
        "max_depth_um": last.max_depth / UM,
        "max_depth_at_deg": worst / DEG,
        "play_arcmin": last.play.arcmin(),
        "wear_coefficient_per_pa": wear.exposure.coefficient,
        "hours_to_50_um": wear.hours_at(50.0 * UM),
    }))
}
