//! The four analyses of one design by library calls, as the commands make them.

use arcmin::analyses::AnalysisError;
use arcmin::design::Design;
use arcmin::dynamics::{BearingMeshing, JointSettings};
use arcmin::fidelity::{Fidelity, Joints};
use arcmin::geometry::Relief;
use arcmin::life::{LifeOptions, PartsPoint, predict};
use arcmin::load::ShareLoad;
use arcmin::machine::ManufacturingErrors;
use arcmin::progress::Silent;
use arcmin::rig;
use arcmin::wear::calibrate::coupled_exposure;
use arcmin::wear::{CoupledOptions, CoupledWear, WearError};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Analysis {
    Contact,
    Wear,
    Life,
    Rig,
    Drawn,
}

impl Analysis {
    pub const ALL: [Analysis; 5] =
        [Analysis::Contact, Analysis::Wear, Analysis::Life, Analysis::Rig, Analysis::Drawn];

    pub fn word(self) -> &'static str {
        match self {
            Analysis::Contact => "contact",
            Analysis::Wear => "wear",
            Analysis::Life => "life",
            Analysis::Rig => "rig",
            Analysis::Drawn => "drawn",
        }
    }
}

/// Outcome of a run.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    Result,
    /// An end that has a name: wear that runs away, a target out of reach.
    Finding(String),
    Failed(String),
}

fn all_finite(values: &[f64]) -> Result<(), String> {
    if values.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(format!("not finite: {values:?}")) }
}

/// Runs one analysis; every number of interest must be finite.
pub fn run(design: &Design, analysis: Analysis) -> Outcome {
    let result = match analysis {
        Analysis::Contact => contact(design),
        Analysis::Wear => wear(design),
        Analysis::Life => life(design),
        Analysis::Rig => bench(design, ManufacturingErrors::default()),
        Analysis::Drawn => match design.drawing_tolerances() {
            Some(tolerances) => bench(design, ManufacturingErrors::draw(&design.machine(), &tolerances, 1)),
            None => Ok(()),
        },
    };
    match result {
        Ok(()) => Outcome::Result,
        Err(Failure::Named(text)) => Outcome::Finding(text),
        Err(Failure::Failed(text)) => Outcome::Failed(text),
    }
}

enum Failure {
    Named(String),
    Failed(String),
}

impl From<String> for Failure {
    fn from(text: String) -> Failure {
        Failure::Failed(text)
    }
}

impl From<WearError> for Failure {
    fn from(error: WearError) -> Failure {
        match error {
            WearError::RunsAway { .. }
            | WearError::RunsAwayAt { .. }
            | WearError::TargetNotReached { .. } => Failure::Named(error.to_string()),
            error => Failure::Failed(error.to_string()),
        }
    }
}

fn text(error: impl std::fmt::Display) -> Failure {
    Failure::Failed(error.to_string())
}

fn contact(design: &Design) -> Result<(), Failure> {
    let machine = design.machine();
    let cycle = machine.meshing(&Relief::uniform(0.0)).cycle(machine.rated().torque, 36).map_err(text)?;
    all_finite(&[
        cycle.max_force(),
        cycle.mean_play().arcmin(),
        cycle.mean_error().arcmin(),
        cycle.max_preload(),
    ])?;
    let mut bearings = BearingMeshing::new(&machine, &JointSettings::default()).map_err(text)?;
    let cycle = bearings.whole_cycle(machine.rated().torque, 12).map_err(text)?;
    all_finite(&[cycle.max_force(), cycle.mean_play().arcmin(), cycle.mean_error().arcmin()])?;
    Ok(())
}

fn wear(design: &Design) -> Result<(), Failure> {
    let machine = design.machine();
    let options = CoupledOptions::default();
    let meshing = machine.meshing(&Relief::uniform(0.0));
    let exposure = coupled_exposure(&machine, meshing.clone(), options)?;
    let mut wear = CoupledWear::with(&machine, meshing, options);
    wear.advance_to(exposure.at(machine.limits().service_life))?;
    let depth = wear.state().flank().deepest().0;
    let cycle = wear.meshing_mut().whole_cycle(machine.rated().torque, 36).map_err(text)?;
    all_finite(&[depth, cycle.max_force(), cycle.mean_play().arcmin()])?;
    Ok(())
}

fn life(design: &Design) -> Result<(), Failure> {
    let machine = design.machine();
    let fidelity = Fidelity { joints: Joints::Bearings, ..Fidelity::ideal() };
    let options = LifeOptions { intervals: 6, crank_positions: 12, ..LifeOptions::default() };
    let prediction = match predict(&machine, &fidelity, options, &Silent, |_| ()) {
        Ok(prediction) => prediction,
        Err(error @ AnalysisError::Stopped) => return Err(text(error)),
        Err(error) => {
            let words = chain(&error);
            return Err(match words.contains("runs away") || words.contains("not reached") {
                true => Failure::Named(words),
                false => Failure::Failed(words),
            });
        }
    };
    for point in &prediction.points {
        let accuracy = &point.accuracy;
        let play = point.travel.map_or(f64::NAN, |travel| travel.play.arcmin());
        all_finite(&[accuracy.max_force, play, point.lost_motion.arcmin()])?;
        let Some(PartsPoint { lost_motion: split, .. }) = point.causes else {
            return Err(Failure::Failed("no causes".to_owned()));
        };
        if !(split.residual().abs() <= 0.02 * split.whole.abs()) {
            return Err(Failure::Failed(format!("causes leave {} of {}", split.residual(), split.whole)));
        }
    }
    match prediction.runs_away {
        Some(end) => Err(Failure::Named(format!("wear runs away at {:.0} h", end.hours))),
        None => Ok(()),
    }
}

/// An error with its causes.
fn chain(error: &dyn std::error::Error) -> String {
    std::iter::successors(Some(error), |error| error.source())
        .map(ToString::to_string)
        .collect::<Vec<_>>()
        .join(": ")
}

fn bench(design: &Design, errors: ManufacturingErrors) -> Result<(), Failure> {
    let machine = design.machine();
    let settings = JointSettings { errors, ..JointSettings::default() };
    let points = rig::hysteresis_loop(&machine, &settings, 0.0).map_err(text)?;
    let figures = rig::evaluate_loop(&points, machine.rated().torque.abs()).map_err(text)?;
    all_finite(&[figures.lost_motion, figures.backlash, figures.stiffness, figures.work])?;
    let split = rig::stiffness_split(&machine, &settings, 0.0).map_err(text)?;
    all_finite(&[split.whole])?;
    let test = rig::TransmissionSettings { positions: 64, ..rig::TransmissionSettings::new(&machine) };
    let curves = rig::transmission_error_curves(&machine, &settings, test).map_err(text)?;
    curves.iter().try_for_each(|curve| all_finite(&[curve.mean(), curve.peak_to_peak()]))?;
    let map = rig::efficiency_map(&machine, &settings).map_err(text)?;
    all_finite(&[map.rated])?;
    rig::running_torques(&machine, &settings).map_err(text)?;
    rig::bearing_loads(&machine, &settings, 12).map_err(text)?;
    Ok(())
}
