use std::path::PathBuf;

use arcmin::geometry::Relief;
use arcmin::units::{ARCMIN, ARCSEC, HOUR, UM};
use arcmin::wear::CoupledOptions;
use arcmin::wear::calibrate::{Observation, Observed, fit_and_predict};
use serde_json::json;

use super::deviations::Deviations;
use super::joints::{Joints, bearing_meshing};
use crate::failure::Failure;
use crate::run::{Cell, Common, Run, Table, Verdict};

#[derive(Debug, clap::Args)]
#[command(
    long_about = "Fits the wear coefficient k of the coupled prediction to observations, by least squares of the relative residuals.\n\n\
                  With --joints bearings and --errors the observations are those of one real machine.\n\n\
                  DATA.csv has a header and one observation a line: hours, and depth_um (largest depth of a flank) or lost_motion_arcmin or \
                  lost_motion_arcsec (increase of the lost motion since new). An empty field is no observation. The running-in of the design is kept.\n\n\
                  calibration.csv: hours, quantity, observed, predicted, residual_percent, use (fitted or predicted).",
    after_help = "Examples:\n  arcmin calibrate my-reducer.toml measured.csv\n  arcmin calibrate my-reducer.toml measured.csv --fit-until-h 600\n  \
                  arcmin calibrate my-reducer.toml measured.csv --running-in-h 150\n\nmeasured.csv:\n  hours,lost_motion_arcsec\n  600,10.64\n  1550,12.92"
)]
pub struct Options {
    #[command(flatten)]
    common: Common,
    /// Observations.
    #[arg(value_name = "DATA.csv")]
    data: PathBuf,
    /// Fit the observations up to this time only, and set the prediction beside the later ones.
    #[arg(long, value_name = "H", value_parser = crate::run::hours)]
    fit_until_h: Option<f64>,
    /// Fit a second coefficient, the factor of a running-in with this time constant, in place of the design's
    /// running-in.
    #[arg(long, value_name = "T", value_parser = crate::run::hours)]
    running_in_h: Option<f64>,
    /// Joints between the bodies: those of the load sharing, and what the lost motion is that of.
    #[arg(long, value_enum, default_value = "ideal")]
    joints: Joints,
    #[command(flatten)]
    deviations: super::deviations::Options,
}

pub fn run(options: Options) -> Result<Verdict, Failure> {
    let mut run = Run::start("calibrate", &options.common)?;
    let machine = run.design.machine();
    let deviations = Deviations::with_joints(
        &mut run,
        &options.common.design,
        &machine,
        &options.deviations,
        options.joints,
    )?;
    let observations = read(&options.data)?;
    let until = options.fit_until_h.unwrap_or(f64::INFINITY) * HOUR;
    let (fitted, others): (Vec<Observation>, Vec<Observation>) =
        observations.into_iter().partition(|o| o.time <= until * (1.0 + 1e-9));
    if fitted.is_empty() {
        return Err(Failure::Usage {
            message: format!("{}: no observation up to {} h", options.data.display(), until / HOUR),
            help: "choose a later --fit-until-h".to_owned(),
        });
    }
    let duration = options.running_in_h.map(|hours| hours * HOUR);
    let settings = CoupledOptions::default();
    let calibration = match options.joints {
        Joints::Ideal => fit_and_predict(
            &machine,
            machine.meshing(&Relief::uniform(0.0)),
            settings,
            &fitted,
            &others,
            duration,
        ),
        Joints::Bearings => fit_and_predict(
            &machine,
            bearing_meshing(&machine, &deviations.errors, None)?,
            settings,
            &fitted,
            &others,
            duration,
        ),
    }
    .map_err(Failure::compute("fit the wear coefficient"))?;
    let k = calibration.exposure.coefficient;
    let mut table = Table::new(&["hours", "quantity", "observed", "predicted", "residual_percent", "use"]);
    let mut rows = Vec::new();
    run.say("     hours   quantity                 observed  predicted  residual");
    for (index, (observation, predicted)) in
        fitted.iter().chain(&others).zip(&calibration.predicted).enumerate()
    {
        let (quantity, observed, unit) = match observation.value {
            Observed::Depth(depth) => ("depth_um", depth, UM),
            Observed::LostMotionIncrease(increase) => ("lost_motion_arcmin", increase, ARCMIN),
        };
        let residual = 100.0 * (predicted / observed - 1.0);
        let hours = observation.time / HOUR;
        let used = if index < fitted.len() { "fitted" } else { "predicted" };
        table.row(&[
            hours.into(),
            Cell::Word(quantity),
            (observed / unit).into(),
            (predicted / unit).into(),
            residual.into(),
            Cell::Word(used),
        ]);
        rows.push(json!({ "hours": hours, "quantity": quantity, "observed": observed / unit, "predicted": predicted / unit, "use": used }));
        run.say(&format!(
            "{hours:10.1}   {quantity:22} {:10.4} {:10.4} {residual:+8.2} %   {used}",
            observed / unit,
            predicted / unit
        ));
    }
    run.table("calibration.csv", table)?;
    run.say(&format!(
        "k = {k:.4e} 1/Pa; in the design file, under [wear.coupled]:\n  coefficient_per_pa = {k:.4e}"
    ));
    let running_in = calibration.exposure.running_in.filter(|_| duration.is_some());
    if let Some(running_in) = running_in {
        let (factor, hours) = (running_in.factor, running_in.duration / HOUR);
        run.say(&format!("and under [wear.running_in]:\n  factor = {factor:.4}\n  duration_h = {hours}"));
    }
    let coefficients = 1 + usize::from(duration.is_some());
    if fitted.len() <= coefficients {
        run.say(&format!(
            "{} fix{} {coefficients} coefficient{} and test{} nothing{}",
            if fitted.len() == 1 {
                "One observation".to_owned()
            } else {
                format!("{} observations", fitted.len())
            },
            if fitted.len() == 1 { "es" } else { "" },
            if coefficients == 1 { "" } else { "s" },
            if fitted.len() == 1 { "s" } else { "" },
            if others.is_empty() { ": another one would." } else { "; those predicted do." }
        ));
    }
    run.finish(json!({
        "wear_coefficient_per_pa": k,
        "wear_coefficient_mm2_per_n": k * 1e6,
        "joints": options.joints.word(),
        "errors": deviations.summary(),
        "running_in_factor": running_in.map(|r| r.factor),
        "running_in_duration_h": running_in.map(|r| r.duration / HOUR),
        "observations": rows,
        "fitted": fitted.len(),
        "relative_rms": calibration.relative_rms,
    }))?;
    Ok(Verdict::Fine)
}

fn read(path: &PathBuf) -> Result<Vec<Observation>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|cause| Failure::Read { path: path.clone(), cause })?;
    let usage = |message: String| Failure::Usage {
        message: format!("{}: {message}", path.display()),
        help: "a header `hours,depth_um` or `hours,lost_motion_arcsec`, then lines such as 600,10.64"
            .to_owned(),
    };
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let header: Vec<&str> =
        lines.next().map(|(_, line)| line.split(',').map(str::trim).collect()).unwrap_or_default();
    let Some(hours_column) = header.iter().position(|name| *name == "hours") else {
        return Err(usage("no column `hours`".to_owned()));
    };
    let mut observations = Vec::new();
    for (column, name) in header.iter().enumerate() {
        if !["hours", "depth_um", "lost_motion_arcmin", "lost_motion_arcsec"].contains(name) {
            return Err(usage(format!("column {} is called `{name}`", column + 1)));
        }
    }
    for (index, line) in lines {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        if fields.len() != header.len() {
            return Err(usage(format!(
                "line {} has {} fields, the header has {}",
                index + 1,
                fields.len(),
                header.len()
            )));
        }
        let number = |field: &str| match field.parse::<f64>() {
            Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
            _ => Err(usage(format!("line {}: \"{field}\" is not a positive number", index + 1))),
        };
        let time = number(fields[hours_column])? * HOUR;
        for (name, field) in
            header.iter().zip(&fields).filter(|(name, field)| **name != "hours" && !field.is_empty())
        {
            let value = number(field)?;
            let value = match *name {
                "depth_um" => Observed::Depth(value * UM),
                "lost_motion_arcmin" => Observed::LostMotionIncrease(value * ARCMIN),
                _ => Observed::LostMotionIncrease(value * ARCSEC),
            };
            observations.push(Observation { time, value });
        }
    }
    if observations.is_empty() {
        return Err(usage("no observation".to_owned()));
    }
    Ok(observations)
}
