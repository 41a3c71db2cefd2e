use std::path::PathBuf;

use arcmin::units::{ARCMIN, ARCSEC, HOUR, UM};
use arcmin::wear::CoupledOptions;
use arcmin::wear::calibrate::{Observation, Observed, fit};
use serde_json::json;

use crate::failure::Failure;
use crate::run::{Cell, Common, Run, Table, Verdict};

#[derive(Debug, clap::Args)]
#[command(
    long_about = "Fits the wear coefficient k of the coupled prediction to observations, by least squares of the relative residuals.\n\n\
                  DATA.csv has a header and one observation a line: hours, and depth_um (largest depth of a flank) or lost_motion_arcmin or \
                  lost_motion_arcsec (increase of the lost motion since new). An empty field is no observation. The running-in of the design is kept.\n\n\
                  calibration.csv: hours, quantity, observed, predicted, residual_percent.",
    after_help = "Examples:\n  arcmin calibrate my-reducer.toml measured.csv\n\nmeasured.csv:\n  hours,lost_motion_arcsec\n  600,10.64\n  1550,12.92"
)]
pub struct Options {
    #[command(flatten)]
    common: Common,
    /// Observations.
    #[arg(value_name = "DATA.csv")]
    data: PathBuf,
}

pub fn run(options: Options) -> Result<Verdict, Failure> {
    let mut run = Run::start("calibrate", &options.common)?;
    let machine = run.design.machine();
    let observations = read(&options.data)?;
    let calibration = fit(&machine, CoupledOptions::default(), &observations).map_err(Failure::compute("fit the wear coefficient"))?;
    let k = calibration.exposure.coefficient;
    let mut table = Table::new(&["hours", "quantity", "observed", "predicted", "residual_percent"]);
    run.say("     hours   quantity                 observed  predicted  residual");
    for (observation, predicted) in observations.iter().zip(&calibration.predicted) {
        let (quantity, observed, unit) = match observation.value {
            Observed::Depth(depth) => ("depth_um", depth, UM),
            Observed::LostMotionIncrease(increase) => ("lost_motion_arcmin", increase, ARCMIN),
        };
        let residual = 100.0 * (predicted / observed - 1.0);
        let hours = observation.time / HOUR;
        table.row(&[hours.into(), Cell::Word(quantity), (observed / unit).into(), (predicted / unit).into(), residual.into()]);
        run.say(&format!("{hours:10.1}   {quantity:22} {:10.4} {:10.4} {residual:+8.2} %", observed / unit, predicted / unit));
    }
    run.table("calibration.csv", table)?;
    run.say(&format!("k = {k:.4e} 1/Pa; in the design file, under [wear.coupled]:\n  coefficient_per_pa = {k:.4e}"));
    if observations.len() == 1 {
        run.say("One observation fixes k and tests nothing: a second one would.");
    }
    run.finish(json!({
        "wear_coefficient_per_pa": k,
        "wear_coefficient_mm2_per_n": k * 1e6,
        "observations": observations.len(),
        "relative_rms": calibration.relative_rms,
    }))?;
    Ok(Verdict::Fine)
}

fn read(path: &PathBuf) -> Result<Vec<Observation>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|cause| Failure::Read { path: path.clone(), cause })?;
    let usage = |message: String| Failure::Usage {
        message: format!("{}: {message}", path.display()),
        help: "a header `hours,depth_um` or `hours,lost_motion_arcsec`, then lines such as 600,10.64".to_owned(),
    };
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let header: Vec<&str> = lines.next().map(|(_, line)| line.split(',').map(str::trim).collect()).unwrap_or_default();
    let Some(hours_column) = header.iter().position(|name| *name == "hours") else { return Err(usage("no column `hours`".to_owned())) };
    let mut observations = Vec::new();
    for (column, name) in header.iter().enumerate() {
        if !["hours", "depth_um", "lost_motion_arcmin", "lost_motion_arcsec"].contains(name) {
            return Err(usage(format!("column {} is called `{name}`", column + 1)));
        }
    }
    for (index, line) in lines {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        if fields.len() != header.len() {
            return Err(usage(format!("line {} has {} fields, the header has {}", index + 1, fields.len(), header.len())));
        }
        let number = |field: &str| match field.parse::<f64>() {
            Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
            _ => Err(usage(format!("line {}: \"{field}\" is not a positive number", index + 1))),
        };
        let time = number(fields[hours_column])? * HOUR;
        for (name, field) in header.iter().zip(&fields).filter(|(name, field)| **name != "hours" && !field.is_empty()) {
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
