//! A first model of a machine known from its data sheet: scaled, then calibrated on the test bench.

use rayon::prelude::*;

use super::{AnalysisError, Host};
use crate::design::Design;
use crate::dynamics::JointSettings;
use crate::rig::{LoopFigures, evaluate_loop, hysteresis_loop};
use crate::templates::{DataSheet, Scaled, Template};
use crate::units::{ARCMIN, UM};

/// A calibrated model and how far the calibration reached.
#[derive(Debug, Clone)]
pub struct Like {
    pub text: String,
    /// One sentence each; also in the head of the text.
    pub notes: Vec<String>,
}

/// Relative accuracy of the calibration, and rounds of it: figures answer nearly linearly.
const ACCURACY: f64 = 0.005;
const ROUNDS: usize = 8;
/// Largest clearance in µm that a calibration may ask for.
const MOST_CLEARANCE_UM: f64 = 200.0;

/// Crank positions, as `rig` takes them by itself.
const POSITIONS: usize = 4;

/// (stiffness in N·m/arcmin, lost motion in arcmin) as `rig` finds them: means over the crank positions.
fn bench(design: &Design) -> Result<(f64, f64), AnalysisError> {
    let (machine, _) = super::rig::with_friction(&design.machine(), false);
    let turn = std::f64::consts::TAU * machine.kinematics().housing_fixed_ratio()
        / (machine.ring.pin_count as f64 - 1.0);
    let all = (0..POSITIONS)
        .into_par_iter()
        .map(|i| hysteresis_loop(&machine, &JointSettings::default(), turn * i as f64 / POSITIONS as f64))
        .map(|points| evaluate_loop(&points?, machine.rated.torque.abs()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(AnalysisError::compute("run the test bench"))?;
    let mean = |of: fn(&LoopFigures) -> f64| all.iter().map(of).sum::<f64>() / POSITIONS as f64;
    Ok((mean(|figures| figures.stiffness) * ARCMIN, mean(|figures| figures.lost_motion) / ARCMIN))
}

/// Scales a template and sets the carrier's torsional stiffness and the turning-arm bearings' clearance so that
/// the bench finds stiffness and lost motion of the data sheet.
///
/// # Errors
/// [`AnalysisError`]: data that no machine has, states without balance.
pub fn like(template: Template, sheet: DataSheet, host: &dyn Host) -> Result<Like, AnalysisError> {
    let scaled = Scaled::new(template, sheet).map_err(|error| {
        AnalysisError::usage(error.to_string(), "correct the data, or take another template")
    })?;
    let design = |clearance: Option<f64>, carrier: Option<f64>| {
        Design::parse(&scaled.text(clearance, carrier, &[]), "the scaled design").map_err(AnalysisError::from)
    };
    let mut clearance = design(None, None)?.machine().bearings.turning_arm.clearance / UM;
    let mut carrier: Option<f64> = None;
    let mut notes = Vec::new();
    let mut too_soft = None;
    let mut too_tight = None;
    for round in 0..ROUNDS {
        host.report("calibrating", round as f64 / ROUNDS as f64);
        if host.is_cancelled() {
            return Err(AnalysisError::Stopped);
        }
        let (stiffness, lost) = bench(&design(Some(clearance), carrier)?)?;
        let mut done = true;
        if let Some(wanted) = sheet.stiffness_n_m_per_arcmin {
            let missing = 1.0 / wanted - 1.0 / stiffness + carrier.map_or(0.0, |k| 1.0 / k);
            done &= (stiffness / wanted - 1.0).abs() < ACCURACY;
            too_soft = (missing <= 0.0).then_some(stiffness);
            carrier = (missing > 0.0).then(|| 1.0 / missing);
            done |= too_soft.is_some() && round > 0;
        }
        if let Some(wanted) = sheet.lost_motion_arcmin {
            done &= (lost / wanted - 1.0).abs() < ACCURACY || too_tight.is_some();
            // Each µm of diametral clearance turns the output by 1 µm over the crankshaft circle.
            let machine = design(Some(clearance), carrier)?.machine();
            let per_um = UM / machine.gear_stage.centre_distance() / ARCMIN;
            let next = (clearance + (wanted - lost) / per_um).clamp(0.0, MOST_CLEARANCE_UM);
            too_tight = (next == clearance && !((lost / wanted - 1.0).abs() < ACCURACY)).then_some(lost);
            if !done || round == 0 {
                clearance = next;
            }
        }
        if done && round > 0 {
            break;
        }
    }
    clearance = (1e4 * clearance).round() / 1e4;
    carrier = carrier.map(|k| (1e4 * k).round() / 1e4);
    let (stiffness, lost) = bench(&design(Some(clearance), carrier)?)?;
    let judge = |what: &str, unit: &str, wanted: Option<f64>, found: f64, cannot: Option<&str>| match wanted {
        None => format!("{what}: not given, not calibrated; the bench finds {found:.3} {unit}."),
        Some(wanted) if (found / wanted - 1.0).abs() < 2.0 * ACCURACY => {
            format!("{what}: {found:.3} {unit} on the bench, {wanted} on the data sheet.")
        }
        Some(wanted) => format!(
            "{what}: {found:.3} {unit} on the bench, {wanted} on the data sheet: not reached, {}.",
            cannot.unwrap_or("the calibration did not settle")
        ),
    };
    let soft = too_soft.map(|_| "the scaled parts are softer by themselves");
    let tight = too_tight.map(|_| "elastic parts and clearance cannot give it");
    notes.push(judge("Stiffness", "N·m/arcmin", sheet.stiffness_n_m_per_arcmin, stiffness, soft));
    notes.push(judge("Lost motion", "arcmin", sheet.lost_motion_arcmin, lost, tight));
    notes.push(
        "The calibration makes two figures right, not the parts: loads, pressures and wear are those of a scaled machine."
            .to_owned(),
    );
    Ok(Like { text: scaled.text(Some(clearance), carrier, &notes), notes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analyses::NoHost;
    use crate::templates::TAO2024;

    /// A data sheet's stiffness and lost motion come back from the bench within 1 %, and a machine stiffer than
    /// its scaled parts says that it is not reached.
    #[test]
    fn the_bench_finds_the_data_sheet() {
        let sheet = DataSheet {
            ratio: 105.0,
            torque: 167.0,
            outer_diameter_mm: Some(145.0),
            stiffness_n_m_per_arcmin: Some(49.0),
            lost_motion_arcmin: Some(0.8),
        };
        let found = like(TAO2024, sheet, &NoHost).unwrap();
        let (stiffness, lost) = bench(&Design::parse(&found.text, "like").unwrap()).unwrap();
        assert!((stiffness / 49.0 - 1.0).abs() < 0.01, "{:?}", found.notes);
        assert!((lost / 0.8 - 1.0).abs() < 0.01, "{:?}", found.notes);
        let hard = DataSheet { stiffness_n_m_per_arcmin: Some(5000.0), lost_motion_arcmin: None, ..sheet };
        let found = like(TAO2024, hard, &NoHost).unwrap();
        assert!(found.notes[0].contains("not reached"), "{:?}", found.notes);
    }
}
