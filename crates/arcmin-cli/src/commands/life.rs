use std::time::Instant;

use arcmin::checks::{self, Severity};
use arcmin::dynamics::{
    DynamicsError, JointSettings, RunResult, StudySettings, TransmissionErrorStudy,
    flexible_transmission_error_study, transmission_error_study,
};
use arcmin::fem::FlexibleDiscs;
use arcmin::geometry::Relief;
use arcmin::life::{
    LifeOptions, LifePoint, PaperStudy, PartsPoint, Prediction, paper_depths, paper_study, predict,
    predict_made, predict_with,
};
use arcmin::machine::{Machine, ManufacturingErrors};
use arcmin::report::life::{LifePage, LifeRow, MeanAndMax, RunTrace, WornFlank};
use arcmin::report::{Provenance, Section};
use arcmin::units::{ARCMIN, DEG, HOUR, MPA, UM};
use arcmin::wear::WearError;
use serde_json::{Map, Value, json};

use super::deviations::Deviations;
use super::joints::{Joints, bearing_meshing};
use crate::failure::Failure;
use crate::run::{Cell, Common, Run, Table, Verdict};

use series::Spread;

mod series;

#[derive(Debug, clap::Args)]
#[command(
    long_about = "The main job: how the accuracy of the reducer decays with running hours, and what limits it.\n\n\
                  Predicts the wear of the flanks coupled to the load sharing, evaluates play, lost motion, transmission error, forces and pressures over \
                  the service life, and finds the hours until the limit of the design. Beside it stands the study of Tao2024: uniform depths 0, 10, …, \
                  60 µm with the static and dynamic transmission error of the multibody model (STE, DTE).\n\n\
                  report.html opens offline in any browser. life_coupled.csv holds the prediction, life.csv the study (same columns), \
                  lost_motion_causes.csv the lost motion of the whole machine with its bearings by cause; profiles of the \
                  worn flank are in wear.csv.\n\n\
                  With bearings, manufacturing errors act on wear and accuracy: those of the design's [errors], or a machine drawn from its [tolerances] \
                  (--errors drawn --seed S, listed in errors.csv). --machines N follows a series of N such machines: series.csv (hours, lost motion without \
                  errors, least, 10 %, median, 90 %, largest) and machines.csv (one row per seed).",
    after_help = "Examples:\n  arcmin life my-reducer.toml\n  arcmin life my-reducer.toml --quasi-static        without the multibody runs, in a blink\n  \
                  arcmin life my-reducer.toml --flexible            with elastic discs as well\n  \
                  arcmin life my-reducer.toml --joints bearings     the prediction with the machine in its bearings\n  \
                  arcmin life my-reducer.toml --joints bearings --errors drawn --machines 20     how far machines of a series spread"
)]
pub struct Options {
    #[command(flatten)]
    common: Common,
    /// Leave out the multibody runs (STE and DTE).
    #[arg(long)]
    quasi_static: bool,
    /// Elastic discs (finite elements): the prediction shares the load on them, and the study shows their
    /// static and dynamic transmission error at every wear level as well: some ten seconds.
    #[arg(long, conflicts_with = "quasi_static")]
    flexible: bool,
    /// Joints of the prediction; the study of Tao2024 keeps ideal joints.
    #[arg(long, value_enum, default_value = "ideal")]
    joints: Joints,
    #[command(flatten)]
    deviations: super::deviations::Options,
    #[command(flatten)]
    elastic: super::elastic::Options,
    /// With --joints bearings --errors drawn: follow N machines as well, drawn with the seed and those after
    /// it, and show how far they spread. Some ten seconds of a core for each.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=1000))]
    machines: Option<u32>,
    /// Times between new and the end of the service life.
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u32).range(2..=1000))]
    points: u32,
}

/// Wall seconds of the stages; prediction and study run side by side, so that they do not add up to the
/// whole.
#[derive(Default)]
struct Clock(Map<String, Value>);

impl Clock {
    fn time<T>(&mut self, stage: &str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.0.insert(stage.to_owned(), json!(start.elapsed().as_secs_f64()));
        result
    }
}

pub fn run(options: Options) -> Result<Verdict, Failure> {
    let mut run = Run::start("life", &options.common)?;
    let machine = run.design.machine();
    let deviations = Deviations::with_joints(
        &mut run,
        &options.common.design,
        &machine,
        &options.deviations,
        options.joints,
    )?;
    let drawn = options.machines.map(|count| deviations.series(&run, &machine, count)).transpose()?;
    let mut clock = Clock::default();
    let findings = clock.time("check", || checks::check(&machine));
    let settings = LifeOptions { intervals: options.points as usize, ..LifeOptions::default() };
    // The prediction follows the wear step by step; the runs of the study fill the other cores meanwhile.
    let (mut wear_clock, mut study_clock) = (Clock::default(), Clock::default());
    let discs = if options.flexible {
        run.progress().report("reducing the discs", 0.0);
        Some(clock.time("reduction", || super::elastic::discs(&machine, &options.elastic, &run.path(".")))?)
    } else {
        None
    };
    // The machine as a whole stands in its bearings whatever the joints of the prediction; bores tied to one
    // spider leave its discs rigid.
    let moves = options.elastic.bores == super::elastic::Bores::PerBore || options.joints == Joints::Bearings;
    let free = discs
        .as_ref()
        .filter(|_| moves)
        .map(|discs| super::elastic::free(&machine, discs.clone(), &options.elastic))
        .transpose()?;
    let whole = JointSettings { discs: free, ..JointSettings::default() };
    let made = |errors: &ManufacturingErrors| {
        (options.joints == Joints::Bearings)
            .then(|| bearing_meshing(&machine, errors, whole.discs.clone()))
            .transpose()
    };
    let bearings = made(&ManufacturingErrors::default())?.zip(made(&deviations.errors)?);
    let nominal = bearings.as_ref().map(|(nominal, _)| nominal.clone());
    let (prediction, study) = rayon::join(
        || {
            wear_clock.time("wear", || {
                match (bearings, &discs) {
                    (Some((nominal, made)), _) => {
                        predict_made(&machine, nominal, made, settings, run.progress())
                    }
                    (None, Some(discs)) => {
                        let meshing = machine.flexible_meshing(&Relief::uniform(0.0), discs.clone());
                        predict_with(&machine, meshing, &whole, settings, run.progress())
                    }
                    (None, None) => predict(&machine, settings, run.progress()),
                }
                .map_err(wear_failure)
            })
        },
        || paper_study_with_runs(&run, &options, discs.as_ref(), &machine, settings, &mut study_clock),
    );
    let (prediction, (study, simulated, elastic)) = (prediction?, study?);
    clock.0.append(&mut wear_clock.0);
    clock.0.append(&mut study_clock.0);

    let spread = match drawn.zip(nominal) {
        Some((drawn, nominal)) => Some(clock.time("series", || {
            Spread::compute(&run, &machine, nominal, whole.discs.as_ref(), &drawn, settings)
        })?),
        None => None,
    };

    let prediction_rows: Vec<LifeRow> = prediction.points.iter().map(|point| row(point, None)).collect();
    let mut study_rows: Vec<LifeRow> = study
        .points
        .iter()
        .enumerate()
        .map(|(level, point)| row(point, simulated.as_ref().map(|s| &s.points[level])))
        .collect();
    for (row, point) in study_rows.iter_mut().zip(elastic.iter().flat_map(|(study, _)| &study.points)) {
        (row.ste_flexible, row.dte_flexible) = (mean_and_max(&point.no_load), mean_and_max(&point.loaded));
    }
    run.table("life.csv", table(&study_rows, &study.points))?;
    run.table("life_coupled.csv", table(&prediction_rows, &prediction.points))?;
    run.table("wear.csv", profiles(&prediction))?;
    let parts: Vec<(f64, &PartsPoint)> =
        prediction.points.iter().filter_map(|point| Some((point.hours, point.parts.as_ref()?))).collect();
    if !parts.is_empty() {
        run.table("lost_motion_causes.csv", super::causes::table(parts.iter().copied()))?;
    }
    let limit = machine.limits.lost_motion / ARCMIN;
    let section = spread.as_ref().map(|spread| spread.section(limit));
    if let Some(spread) = &spread {
        spread.tables(&mut run)?;
    }
    let design_name = options.common.design.display().to_string();
    let report = clock.time("report", || {
        render(
            &run,
            &design_name,
            &machine,
            options.joints,
            &deviations,
            &prediction,
            &study,
            simulated.as_ref(),
            elastic.as_ref(),
            &prediction_rows,
            &study_rows,
            &findings,
            &parts,
            section,
        )
    });
    run.file("report.html", report.as_bytes())?;

    say(&run, &machine, &prediction, &prediction_rows, &study_rows, &findings, options.joints);
    if let Some((hours, point)) = parts.last() {
        run.say(&format!("\nafter {hours:.0} h, {}", super::causes::say(point)));
    }
    if let Some(spread) = &spread {
        run.say(&spread.terminal(limit));
    }
    let last = &prediction_rows[prediction_rows.len() - 1];
    run.finish(json!({
        "ratio": machine.kinematics().ratio(),
        "joints": options.joints.word(),
        "errors": deviations.summary(),
        "series": spread.as_ref().map(Spread::summary),
        "elastic_prediction": options.flexible,
        "hours_to_limit": prediction.hours_to_limit,
        "hours_to_limit_searched": prediction.searched_hours,
        "hours_to_limit_paper_study": study.hours_to_limit,
        "limit_lost_motion_arcmin": machine.limits.lost_motion / ARCMIN,
        "service_life_h": machine.limits.service_life / HOUR,
        "max_depth_um": last.max_depth_um,
        "max_depth_at_deg": prediction.points[prediction.points.len() - 1].max_depth_at.abs() / DEG,
        "play_arcmin": last.play_arcmin,
        "lost_motion_arcmin": last.lost_motion_arcmin,
        "machine_lost_motion_arcmin": last.machine_lost_motion_arcmin,
        "te_loaded_arcmin": last.te_loaded_arcmin,
        "lost_motion_causes": parts.last().map(|(_, point)| super::causes::summary(point)),
        "max_force_n": last.max_force_n,
        "max_pressure_mpa": last.max_pressure_mpa,
        "loaded_pairs": last.loaded_pairs,
        "wear_coefficient_per_pa": prediction.exposure.coefficient,
        "wear_coefficient_paper_per_pa": study.wear.exposure.coefficient,
        "flank_updates": prediction.updates,
        "error_findings": findings.iter().filter(|finding| finding.severity == Severity::Error).count(),
        "stages": clock.0,
    }))?;
    Ok(if checks::worst(&findings) == Severity::Error { Verdict::ErrorFindings } else { Verdict::Fine })
}

fn wear_failure(error: WearError) -> Failure {
    match error {
        WearError::Stopped => Failure::Cancelled,
        error => Failure::compute("predict the wear")(error),
    }
}

type Elastic = (TransmissionErrorStudy, Section);

/// The paper's study and what was asked for of its multibody runs: with rigid and with elastic discs.
fn paper_study_with_runs(
    run: &Run,
    options: &Options,
    discs: Option<&FlexibleDiscs>,
    machine: &Machine,
    settings: LifeOptions,
    clock: &mut Clock,
) -> Result<(PaperStudy, Option<TransmissionErrorStudy>, Option<Elastic>), Failure> {
    let study =
        clock.time("study", || paper_study(machine, &paper_depths(), settings)).map_err(wear_failure)?;
    let rigid = if options.quasi_static {
        None
    } else {
        Some(clock.time("rigid", || simulate(run, machine, &study))?)
    };
    let elastic = discs
        .map(|discs| clock.time("flexible", || simulate_elastic(run, options, discs, machine, &study)))
        .transpose()?;
    Ok((study, rigid, elastic))
}

fn simulate(run: &Run, machine: &Machine, study: &PaperStudy) -> Result<TransmissionErrorStudy, Failure> {
    let wear: Vec<_> = study.points.iter().map(|point| point.flank.clone()).collect();
    transmission_error_study(machine, &wear, &StudySettings::tao2024(machine), run.progress()).map_err(
        |error| {
            if run.progress().is_cancelled() {
                Failure::Cancelled
            } else {
                Failure::compute("simulate the transmission error")(error)
            }
        },
    )
}

/// The same runs with elastic discs, and the section of the report about the disc.
fn simulate_elastic(
    run: &Run,
    options: &Options,
    discs: &FlexibleDiscs,
    machine: &Machine,
    study: &PaperStudy,
) -> Result<Elastic, Failure> {
    let wear: Vec<_> = study.points.iter().map(|point| point.flank.clone()).collect();
    let settings = StudySettings { perturbed_starts: 0, ..StudySettings::tao2024(machine) };
    let result = flexible_transmission_error_study(
        machine,
        discs,
        options.elastic.dynamics(),
        &wear,
        &settings,
        run.progress(),
    );
    let study = result.map_err(|error| match error {
        DynamicsError::Cancelled { .. } => Failure::Cancelled,
        error => Failure::compute("simulate the elastic discs")(error),
    })?;
    Ok((study, super::elastic::section(machine, &options.elastic, discs.clone())?))
}

fn mean_and_max(result: &RunResult) -> Option<MeanAndMax> {
    result
        .statistics
        .map(|te| MeanAndMax { mean_arcmin: te.mean_abs / ARCMIN, max_arcmin: te.max_abs / ARCMIN })
}

fn row(point: &LifePoint, simulated: Option<&arcmin::dynamics::StudyPoint>) -> LifeRow {
    LifeRow {
        hours: point.hours,
        max_depth_um: point.max_depth / UM,
        play_arcmin: point.play.arcmin(),
        te_no_load_arcmin: Some(point.no_load_error.arcmin()),
        te_loaded_arcmin: point.loaded_error.arcmin(),
        max_force_n: point.max_force,
        max_pressure_mpa: point.max_pressure / MPA,
        loaded_pairs: point.loaded_pairs,
        lost_motion_arcmin: Some(point.lost_motion.arcmin()),
        machine_lost_motion_arcmin: point.parts.is_some().then(|| point.machine_lost_motion().arcmin()),
        ste_rigid: simulated.and_then(|s| mean_and_max(&s.no_load)),
        dte_rigid: simulated.and_then(|s| mean_and_max(&s.loaded)),
        ste_flexible: None,
        dte_flexible: None,
    }
}

fn table(rows: &[LifeRow], points: &[LifePoint]) -> Table {
    let mut table = Table::new(&[
        "hours",
        "max_depth_um",
        "play_arcmin",
        "te_no_load_arcmin",
        "te_loaded_arcmin",
        "ste_rigid_mean_arcmin",
        "ste_rigid_max_arcmin",
        "dte_rigid_mean_arcmin",
        "dte_rigid_max_arcmin",
        "ste_flexible_mean_arcmin",
        "ste_flexible_max_arcmin",
        "lost_motion_arcmin",
        "dte_flexible_mean_arcmin",
        "dte_flexible_max_arcmin",
        "free_travel_arcmin",
        "te_loaded_peak_to_peak_arcmin",
        "max_depth_at_deg",
        "max_force_n",
        "max_pressure_mpa",
        "loaded_pairs",
    ]);
    for (row, point) in rows.iter().zip(points) {
        let cell = |value: Option<f64>| value.map_or(Cell::Empty, Cell::Number);
        table.row(&[
            row.hours.into(),
            row.max_depth_um.into(),
            row.play_arcmin.into(),
            cell(row.te_no_load_arcmin),
            row.te_loaded_arcmin.into(),
            cell(row.ste_rigid.map(|te| te.mean_arcmin)),
            cell(row.ste_rigid.map(|te| te.max_arcmin)),
            cell(row.dte_rigid.map(|te| te.mean_arcmin)),
            cell(row.dte_rigid.map(|te| te.max_arcmin)),
            cell(row.ste_flexible.map(|te| te.mean_arcmin)),
            cell(row.ste_flexible.map(|te| te.max_arcmin)),
            cell(row.lost_motion_arcmin),
            cell(row.dte_flexible.map(|te| te.mean_arcmin)),
            cell(row.dte_flexible.map(|te| te.max_arcmin)),
            point.free_travel.arcmin().into(),
            point.loaded_peak_to_peak.arcmin().into(),
            (point.max_depth_at.abs() / DEG).into(),
            row.max_force_n.into(),
            row.max_pressure_mpa.into(),
            row.loaded_pairs.into(),
        ]);
    }
    table
}

/// Depth along the flank at every point of the prediction; of each disc (counted from 0) where they differ.
fn profiles(prediction: &Prediction) -> Table {
    let mut table = Table::new(&["hours", "meshing_angle_deg", "depth_um", "disc"]);
    for (point, surfaces) in prediction.points.iter().zip(&prediction.surfaces) {
        for (disc, flank) in surfaces.flanks.iter().enumerate() {
            let disc = (surfaces.flanks.len() > 1).then_some(disc);
            for (phi, depth) in Relief::grid(flank.samples().len()).zip(flank.samples()) {
                table.row(&[point.hours.into(), (phi / DEG).into(), (depth / UM).into(), disc.into()]);
            }
        }
    }
    table
}

/// Columns of a simulated run in trade units.
struct Trace {
    time_s: Vec<f64>,
    input_speed_deg_s: Vec<f64>,
    output_speed_deg_s: Vec<f64>,
    load_n_m: Vec<f64>,
    te_arcmin: Vec<f64>,
    statistics: MeanAndMax,
    wear_um: f64,
}

impl Trace {
    fn new(result: &RunResult, wear_um: f64) -> Option<Trace> {
        let column = |value: fn(&arcmin::dynamics::Sample) -> f64| result.series.iter().map(value).collect();
        Some(Trace {
            time_s: column(|s| s.time),
            input_speed_deg_s: column(|s| s.input_speed / DEG),
            output_speed_deg_s: column(|s| s.output_speed / DEG),
            load_n_m: column(|s| s.load),
            te_arcmin: column(|s| s.transmission_error / ARCMIN),
            statistics: mean_and_max(result)?,
            wear_um,
        })
    }

    fn lend(&self) -> RunTrace<'_> {
        RunTrace {
            wear_um: self.wear_um,
            time_s: &self.time_s,
            input_speed_deg_s: &self.input_speed_deg_s,
            output_speed_deg_s: &self.output_speed_deg_s,
            load_n_m: &self.load_n_m,
            te_arcmin: &self.te_arcmin,
            steady_from_s: 0.1,
            mean_abs_arcmin: self.statistics.mean_arcmin,
            max_abs_arcmin: self.statistics.max_arcmin,
        }
    }
}

fn render(
    run: &Run,
    design_name: &str,
    machine: &Machine,
    joints: Joints,
    deviations: &Deviations,
    prediction: &Prediction,
    study: &PaperStudy,
    simulated: Option<&TransmissionErrorStudy>,
    elastic: Option<&(TransmissionErrorStudy, Section)>,
    prediction_rows: &[LifeRow],
    study_rows: &[LifeRow],
    findings: &[checks::Finding],
    parts: &[(f64, &PartsPoint)],
    series: Option<Section>,
) -> String {
    // New, four stations on the way, and the end: as many curves as a reader can tell apart.
    let intervals = prediction.points.len() - 1;
    let stations = 5.min(intervals);
    let flanks: Vec<WornFlank> = (0..=stations)
        .map(|station| &prediction.points[intervals * station / stations])
        .map(|point| WornFlank {
            hours: point.hours,
            flank: &point.flank,
            cycle: &point.cycle,
            forces: &point.flank_forces[0],
            peaks: &point.flank_peaks,
            pins: &point.pin_loads,
        })
        .collect();
    // The paper shows its runs at 10 µm.
    let level = 1.min(study.points.len() - 1);
    let trace = |pick: fn(&arcmin::dynamics::StudyPoint) -> &RunResult| {
        simulated.and_then(|s| Trace::new(pick(&s.points[level]), study.points[level].max_depth / UM))
    };
    let flexible = |pick: fn(&arcmin::dynamics::StudyPoint) -> &RunResult| {
        elastic.and_then(|(s, _)| Trace::new(pick(&s.points[level]), study.points[level].max_depth / UM))
    };
    let (flexible_ste, flexible_dte) = (flexible(|point| &point.no_load), flexible(|point| &point.loaded));
    let (ste, dte) = (trace(|point| &point.no_load), trace(|point| &point.loaded));
    LifePage {
        machine,
        provenance: Provenance {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            design_hash: run.design.short_hash(),
            command: std::iter::once("arcmin".to_owned())
                .chain(std::env::args().skip(1))
                .collect::<Vec<_>>()
                .join(" "),
            seeds: deviations.seeds(),
        },
        design_name,
        design_text: run.design.text(),
        contacts_alone: joints == Joints::Ideal,
        errors: deviations.sentence(),
        prediction: prediction_rows,
        flanks: &flanks,
        hours_to_limit: prediction.hours_to_limit,
        searched_hours: prediction.searched_hours,
        prediction_coefficient_per_pa: prediction.exposure.coefficient,
        study: study_rows,
        study_coefficient_per_pa: study.wear.exposure.coefficient,
        ste_rigid_run: ste.as_ref().map(Trace::lend),
        dte_rigid_run: dte.as_ref().map(Trace::lend),
        ste_flexible_run: flexible_ste.as_ref().map(Trace::lend),
        dte_flexible_run: flexible_dte.as_ref().map(Trace::lend),
        ste_starts: simulated
            .map_or_else(Vec::new, |s| s.points.iter().map(|point| point.spread.as_ref()).collect()),
        findings,
        advice: Vec::new(),
        more: series
            .into_iter()
            .chain((!parts.is_empty()).then(|| super::causes::section(parts)))
            .chain(elastic.iter().map(|(_, section)| section.clone()))
            .collect(),
    }
    .page()
    .render()
}

/// The terminal's table: a handful of rows of the prediction, the study, the verdict.
fn say(
    run: &Run,
    machine: &Machine,
    prediction: &Prediction,
    rows: &[LifeRow],
    study: &[LifeRow],
    findings: &[checks::Finding],
    joints: Joints,
) {
    run.say(&format!(
        "{}: accuracy over {:.0} h, wear coupled to the load",
        machine.name,
        machine.limits.service_life / HOUR
    ));
    run.say("                                  lost motion '                         largest");
    run.say("   hours   depth µm   play '   contacts   machine   loaded TE '   force N   pairs");
    let angle = |arcmin: Option<f64>| arcmin.map_or("–".to_owned(), |arcmin| format!("{arcmin:.3}"));
    let intervals = rows.len() - 1;
    let stations = 6.min(intervals);
    for row in (0..=stations).map(|station| &rows[intervals * station / stations]) {
        run.say(&format!(
            "{:8.0} {:10.2} {:8.3} {:>10} {:>9} {:13.3} {:9.0} {:7.1}",
            row.hours,
            row.max_depth_um,
            row.play_arcmin,
            if joints == Joints::Ideal { angle(row.lost_motion_arcmin) } else { angle(None) },
            angle(
                row.machine_lost_motion_arcmin.or(row.lost_motion_arcmin.filter(|_| joints != Joints::Ideal))
            ),
            row.te_loaded_arcmin,
            row.max_force_n,
            row.loaded_pairs
        ));
    }
    run.say("\nstudy of Tao2024 (uniform depth)");
    let elastic = study.iter().any(|row| row.ste_flexible.is_some());
    let heading = "   hours   depth µm   play '   STE mean/max '   DTE mean/max '";
    run.say(&format!("{heading}{}", if elastic { "  elastic: STE           DTE" } else { "" }));
    for row in study {
        let pair = |te: Option<MeanAndMax>| {
            te.map_or("        –       ".to_owned(), |te| {
                format!("{:7.3}/{:<8.3}", te.mean_arcmin, te.max_arcmin)
            })
        };
        let rigid = format!(
            "{:8.0} {:10.1} {:8.3} {} {}",
            row.hours,
            row.max_depth_um,
            row.play_arcmin,
            pair(row.ste_rigid),
            pair(row.dte_rigid)
        );
        run.say(&if elastic {
            format!("{rigid} {} {}", pair(row.ste_flexible), pair(row.dte_flexible))
        } else {
            rigid
        });
    }
    let limit = machine.limits.lost_motion / ARCMIN;
    let whose = if joints == Joints::Ideal && rows.iter().all(|row| row.machine_lost_motion_arcmin.is_none())
    {
        "contacts"
    } else {
        "machine"
    };
    run.say(&match prediction.hours_to_limit {
        Some(hours) => {
            format!("\nlost motion of the {whose} reaches its limit of {limit:.2}' after {hours:.0} h")
        }
        None => format!(
            "\nlost motion of the {whose} stays below its limit of {limit:.2}' for {:.0} h at least",
            prediction.searched_hours
        ),
    });
    let count = |severity: Severity| findings.iter().filter(|finding| finding.severity == severity).count();
    if count(Severity::Error) + count(Severity::Warning) > 0 {
        run.say(&format!(
            "{} error and {} warning findings: see `arcmin check`",
            count(Severity::Error),
            count(Severity::Warning)
        ));
    }
}
