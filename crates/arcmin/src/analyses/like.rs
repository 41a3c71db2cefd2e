//! First model of a machine from its data sheet: scaled, then fitted on the test bench.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use super::{AnalysisError, Host};
use crate::checks::{Severity, check_design};
use crate::design::Design;
use crate::fidelity::has_room;
use crate::machine::OutputForces;
use crate::progress::Progress;
use crate::rig::main_bearing_load;
use crate::templates::{DataSheet, ScaleError, Scaled, Template, Tuning};
use crate::units::{ARCMIN, UM};

/// A fitted model with the result of the fit.
#[derive(Debug, Clone)]
pub struct Like {
    /// Design file of the model.
    pub text: String,
    /// One sentence each; also in the head of the text.
    pub notes: Vec<String>,
}

/// Bodies on the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bodies {
    /// The diameters of the crankshafts are fitted to the stiffness.
    Elastic,
    /// The torsional stiffness of the carrier is fitted; thicker crankshafts are used if the other parts are too
    /// compliant.
    Rigid,
}

/// Relative accuracy of the calibration, and rounds of it.
const ACCURACY: f64 = 0.015;
const ROUNDS: usize = 6;
/// Relative difference up to which a figure counts as reached.
const REACHED: f64 = 0.03;
/// Largest clearance in µm in a fit.
const MOST_CLEARANCE_UM: f64 = 200.0;
/// Range of preloads of the main bearings in µm.
const PRELOAD_UM: (f64, f64) = (0.05, 60.0);
/// Range of the factor of the crankshafts.
const CRANKS: (f64, f64) = (0.7, 2.2);
/// Exponent of the factor of the crankshafts in the first guess of the stiffness.
const FIRST_POWER: f64 = 2.0;

/// Host that computes only the requested results and keeps condensed bodies in memory.
struct Quiet<'a> {
    host: &'a dyn Host,
    wanted: &'static [&'static str],
    kept: &'a Mutex<HashMap<String, Vec<u8>>>,
}

impl Progress for Quiet<'_> {
    fn report(&self, _stage: &str, _share: f64) {}

    fn is_cancelled(&self) -> bool {
        self.host.is_cancelled()
    }
}

impl Host for Quiet<'_> {
    fn needs(&self, result: &str) -> bool {
        self.wanted.contains(&result)
    }

    fn cached(&self, name: &str) -> Option<Vec<u8>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).get(name).cloned()
    }

    fn cache(&self, name: &str, bytes: &[u8]) {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).insert(name.to_owned(), bytes.to_vec());
    }
}

/// Results of `rig`.
#[derive(Debug, Clone, Copy)]
struct Found {
    /// N·m/arcmin.
    stiffness: f64,
    /// arcmin.
    lost_motion: f64,
    /// N·m at the input; `None` if not requested.
    starting: Option<f64>,
    /// N·m at the output.
    back_driving: Option<f64>,
}

/// The scaled machine and its bench, for the fit.
struct Bench<'a> {
    scaled: &'a Scaled,
    host: &'a dyn Host,
    kept: Mutex<HashMap<String, Vec<u8>>>,
}

impl Bench<'_> {
    fn design(&self, tuning: &Tuning) -> Result<Design, AnalysisError> {
        Design::parse(&self.scaled.text(tuning, &[]), "the scaled design").map_err(AnalysisError::from)
    }

    fn run(&self, tuning: &Tuning, bodies: Bodies, running: bool) -> Result<Found, AnalysisError> {
        if self.host.is_cancelled() {
            return Err(AnalysisError::Stopped);
        }
        let design = self.design(tuning)?;
        // The bench computes only the requested results: all loops for the first two.
        const WANTED: [&str; 4] = [
            "stiffness_n_m_per_arcmin",
            "lost_motion_arcmin",
            "starting_torque_n_m",
            "back_driving_torque_n_m",
        ];
        let wanted: &'static [&'static str] = if running { &WANTED } else { &WANTED[..2] };
        let host = Quiet { host: self.host, wanted, kept: &self.kept };
        let options = match bodies {
            Bodies::Elastic => "bodies = \"elastic\"\npositions = 3\nte_positions = 64",
            Bodies::Rigid => "te_positions = 64",
        };
        let options = super::rig::Options::parse(options, "new --like")?;
        let state = super::rig::run(&design, &options, &host)?;
        let (new, torques) = (&state.new, state.new.torques.as_ref());
        Ok(Found {
            stiffness: new.stiffness() * ARCMIN,
            lost_motion: new.lost_motion() / ARCMIN,
            starting: torques.map(|torques| torques.starting),
            back_driving: torques.map(|torques| torques.back_driving),
        })
    }

    /// Whether a machine with these crankshafts can be made.
    fn is_sound(&self, crankshafts: f64) -> bool {
        let Ok(design) = self.design(&Tuning { crankshafts, ..Tuning::default() }) else { return false };
        has_room(&design.machine())
            && check_design(&design).iter().all(|finding| finding.severity != Severity::Error)
    }

    /// The widest range of factors about 1 with which a machine can be made.
    fn crank_range(&self) -> (f64, f64) {
        let reach = |step: f64, end: f64| {
            let steps = ((end - 1.0) / step).round() as usize;
            let factors = (1..=steps).map(|k| 1.0 + step * k as f64);
            factors.take_while(|factor| self.is_sound(*factor)).last().unwrap_or(1.0)
        };
        (reach(-0.05, CRANKS.0), reach(0.05, CRANKS.1))
    }

    /// Preload of the rows of the main bearings for a moment stiffness, by bisection within the range of preloads.
    fn preload(&self, wanted: f64) -> Result<(f64, f64), AnalysisError> {
        let stiffness = |preload: f64| -> Result<f64, AnalysisError> {
            let machine = self.design(&Tuning { preload_um: Some(preload), ..Tuning::default() })?.machine();
            let load = main_bearing_load(&machine, OutputForces::default())
                .map_err(AnalysisError::compute("load the main bearings"))?;
            Ok(load.moment_stiffness[0] * ARCMIN)
        };
        let (mut low, mut high) = PRELOAD_UM;
        for _ in 0..40 {
            let middle = (low * high).sqrt();
            if stiffness(middle)? < wanted { low = middle } else { high = middle }
        }
        let preload = (1e3 * (low * high).sqrt()).round() / 1e3;
        Ok((preload, stiffness(preload)?))
    }
}

/// Searches the factor of the crankshafts that gives a stiffness: logarithms, a first power, then secants.
struct CrankSearch {
    wanted: f64,
    range: (f64, f64),
    /// Logarithms of factor and stiffness.
    before: Option<(f64, f64)>,
}

impl CrankSearch {
    fn next(&mut self, factor: f64, stiffness: f64) -> f64 {
        let at = (factor.ln(), stiffness.ln());
        let power = match self.before {
            Some((x, y)) if (at.0 - x).abs() > 1e-6 => ((at.1 - y) / (at.0 - x)).clamp(0.3, 6.0),
            _ => FIRST_POWER,
        };
        self.before = Some(at);
        let next = (at.0 + (self.wanted.ln() - at.1) / power).exp();
        (1e3 * next.clamp(self.range.0, self.range.1)).round() / 1e3
    }
}

/// Scales a template and fits it to a data sheet, so that `rig` gives its figures.
///
/// With elastic bodies the diameter of the crankshafts is fitted to the stiffness. The torsional compliance of the
/// carrier, which only rigid bodies use, is fitted afterwards; no compliance counts twice. The clearance of the
/// turning-arm bearings is fitted to the lost motion, the drag of the seals to the starting or back-driving torque,
/// the preload of the main bearings to the moment stiffness.
///
/// # Errors
/// [`AnalysisError`]: data without a possible machine, states without equilibrium.
pub fn like(
    template: Template,
    sheet: DataSheet,
    bodies: Bodies,
    host: &dyn Host,
) -> Result<Like, AnalysisError> {
    let scaled = Scaled::new(template, sheet).map_err(|error| {
        let help = match error {
            ScaleError::Planets { .. } => "give fewer crankshafts",
            _ => "correct the data, or take another template",
        };
        AnalysisError::usage(error.to_string(), help)
    })?;
    let bench = Bench { scaled: &scaled, host, kept: Mutex::default() };
    let mut notes = Vec::new();
    let mut tuning = Tuning::default();
    if let Some(wanted) = sheet.moment_stiffness_n_m_per_arcmin {
        let (preload, found) = bench.preload(wanted)?;
        tuning.preload_um = Some(preload);
        notes.push(judge(
            "Moment stiffness",
            "N·m/arcmin",
            "",
            Some(wanted),
            found,
            "the balls are too soft or too stiff",
        ));
    }
    let mut found = calibrate(&bench, &sheet, bodies, &mut tuning)?;
    let torques = torques(&bench, &sheet, &mut tuning)?;
    if tuning.seal_drag.is_some() && sheet.lost_motion_arcmin.is_some() {
        // Drag of the seals affects the lost motion.
        found = calibrate(&bench, &sheet, bodies, &mut tuning)?;
    }
    let with = match bodies {
        Bodies::Elastic => " with elastic bodies",
        Bodies::Rigid => " with rigid bodies",
    };
    let why = "no crankshafts that fit into the discs have this stiffness";
    notes.push(judge("Stiffness", "N·m/arcmin", with, sheet.stiffness_n_m_per_arcmin, found.stiffness, why));
    let why = "no clearance of the turning-arm bearings gives it: the parts of elasticity, flanks or seals are too large or too small";
    notes.push(judge("Lost motion", "arcmin", with, sheet.lost_motion_arcmin, found.lost_motion, why));
    if let (Some(wanted), Some(starting)) = (sheet.starting_torque_n_m, torques.starting) {
        let why = "the torque without seals is as large already";
        notes.push(judge("Starting torque", "N·m at the input", "", Some(wanted), starting, why));
    }
    if let (Some(wanted), Some(back_driving)) = (sheet.back_driving_torque_n_m, torques.back_driving) {
        let why =
            "the seals are fitted to the starting torque, or the torque without seals is as large already";
        notes.push(judge("Back-driving torque", "N·m at the output", "", Some(wanted), back_driving, why));
    }
    if bodies == Bodies::Elastic {
        let mut rigid = bench.run(&tuning, Bodies::Rigid, false)?;
        // Fitted for rigid bodies, which are stiffer than the data sheet; elastic bodies do not use it.
        let wanted =
            sheet.stiffness_n_m_per_arcmin.filter(|wanted| rigid.stiffness > (1.0 + ACCURACY) * wanted);
        if let Some(wanted) = wanted {
            tuning.carrier = Some((1e4 / (1.0 / wanted - 1.0 / rigid.stiffness)).round() / 1e4);
            rigid = bench.run(&tuning, Bodies::Rigid, false)?;
        }
        notes.push(format!(
            "With rigid bodies the bench gives {:.4} N·m/arcmin and {:.3} arcmin.",
            rigid.stiffness, rigid.lost_motion
        ));
    }
    notes.push(
        "The fit makes single figures correct, not the parts: loads, pressures and wear are those of a scaled \
             machine."
            .to_owned(),
    );
    Ok(Like { text: scaled.text(&tuning, &notes), notes })
}

/// Fits crankshafts or carrier, and clearance; returns the figures of the result.
fn calibrate(
    bench: &Bench<'_>,
    sheet: &DataSheet,
    bodies: Bodies,
    tuning: &mut Tuning,
) -> Result<Found, AnalysisError> {
    let machine = bench.design(tuning)?.machine();
    // Each µm of diametral clearance turns the output by 1 µm over the crankshaft circle.
    let per_um = UM / machine.gear_stage.centre_distance() / ARCMIN;
    let mut clearance = machine.bearings.turning_arm.clearance / UM;
    let near =
        |wanted: Option<f64>, found: f64| wanted.is_none_or(|wanted| (found / wanted - 1.0).abs() < ACCURACY);
    let mut found = bench.run(tuning, bodies, false)?;
    let open = sheet.stiffness_n_m_per_arcmin.filter(|wanted| !near(Some(*wanted), found.stiffness));
    let mut search = open.map(|wanted| CrankSearch { wanted, range: bench.crank_range(), before: None });
    for round in 0..ROUNDS {
        bench.host.report("calibrating", round as f64 / ROUNDS as f64);
        let mut next = *tuning;
        if let Some(search) = &mut search
            && !near(Some(search.wanted), found.stiffness)
        {
            let missing =
                1.0 / search.wanted - 1.0 / found.stiffness + tuning.carrier.map_or(0.0, f64::recip);
            if bodies == Bodies::Rigid && missing > 0.0 && tuning.crankshafts == 1.0 {
                next.carrier = Some((1e4 / missing).round() / 1e4);
            } else {
                next.carrier = None;
                next.crankshafts = search.next(tuning.crankshafts, found.stiffness);
            }
        }
        if let Some(wanted) = sheet.lost_motion_arcmin
            && !near(Some(wanted), found.lost_motion)
        {
            clearance = (clearance + (wanted - found.lost_motion) / per_um).clamp(0.0, MOST_CLEARANCE_UM);
            next.clearance_um = Some((1e3 * clearance).round() / 1e3);
        }
        if next == *tuning {
            break;
        }
        *tuning = next;
        found = bench.run(tuning, bodies, false)?;
    }
    Ok(found)
}

/// Fits the drag of the seals to the starting or back-driving torque of the data sheet.
fn torques(bench: &Bench<'_>, sheet: &DataSheet, tuning: &mut Tuning) -> Result<Found, AnalysisError> {
    let mut found = Found { stiffness: 0.0, lost_motion: 0.0, starting: None, back_driving: None };
    if sheet.starting_torque_n_m.is_none() && sheet.back_driving_torque_n_m.is_none() {
        return Ok(found);
    }
    let ratio = bench.scaled.ratio();
    for _ in 0..4 {
        found = bench.run(tuning, Bodies::Rigid, true)?;
        let missing = match (sheet.starting_torque_n_m, sheet.back_driving_torque_n_m) {
            (Some(wanted), _) => {
                found.starting.map(|starting| ((wanted - starting) * ratio, starting / wanted))
            }
            (None, Some(wanted)) => found.back_driving.map(|back| (wanted - back, back / wanted)),
            (None, None) => None,
        };
        let Some((missing, share)) = missing.filter(|(missing, _)| missing.is_finite()) else { break };
        let (tested, _) = super::rig::with_friction(&bench.design(tuning)?.machine(), false);
        let seals = tested.friction.seal_drag;
        let next = (1e4 * (seals + missing).max(0.0)).round() / 1e4;
        if (share - 1.0).abs() < ACCURACY || next == seals {
            break;
        }
        tuning.seal_drag = Some(next);
    }
    Ok(found)
}

/// Compares a result of the bench with the data sheet; states the reason if a figure is not reached.
fn judge(what: &str, unit: &str, with: &str, wanted: Option<f64>, found: f64, cannot: &str) -> String {
    match wanted {
        None => format!("{what}: not given, not fitted; the bench gives {found:.4} {unit}{with}."),
        Some(wanted) if (found / wanted - 1.0).abs() < REACHED => {
            format!("{what}: {found:.4} {unit} on the bench{with}, {wanted} on the data sheet.")
        }
        Some(wanted) => format!(
            "{what}: {found:.4} {unit} on the bench{with}, {wanted} on the data sheet: not reached, {cannot}."
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analyses::NoHost;
    use crate::templates::TAO2024;

    /// The bench reproduces the figures of a data sheet, each by another part. If the stiffness exceeds that of the scaled parts,
    /// the note states that it is not reached.
    #[test]
    fn the_bench_finds_the_data_sheet() {
        let sheet = DataSheet {
            ratio: 105.0,
            torque: 167.0,
            outer_diameter_mm: Some(145.0),
            stiffness_n_m_per_arcmin: Some(49.0),
            lost_motion_arcmin: Some(0.8),
            moment_stiffness_n_m_per_arcmin: Some(372.0),
            back_driving_torque_n_m: Some(3.0),
            ..DataSheet::default()
        };
        let found = like(TAO2024, sheet, Bodies::Rigid, &NoHost).unwrap();
        assert!(found.notes.iter().all(|note| !note.contains("not reached")), "{:?}", found.notes);
        let design = Design::parse(&found.text, "like").unwrap();
        let rig = super::super::by_name("rig").unwrap();
        let summary = rig.run(&design, "te_positions = 64", "test", &NoHost).unwrap().summary().to_json();
        let number = |key: &str| summary[key].as_f64().unwrap();
        assert!((number("stiffness_n_m_per_arcmin") / 49.0 - 1.0).abs() < REACHED, "{:?}", found.notes);
        assert!((number("lost_motion_arcmin") / 0.8 - 1.0).abs() < REACHED, "{:?}", found.notes);
        assert!((number("back_driving_torque_n_m") / 3.0 - 1.0).abs() < REACHED, "{:?}", found.notes);
        let moment = summary["main_bearings"]["moment_stiffness_n_m_per_arcmin"].as_f64().unwrap();
        assert!((moment / 372.0 - 1.0).abs() < REACHED, "{moment}");
        let hard = DataSheet {
            stiffness_n_m_per_arcmin: Some(5000.0),
            lost_motion_arcmin: None,
            back_driving_torque_n_m: None,
            ..sheet
        };
        let found = like(TAO2024, hard, Bodies::Rigid, &NoHost).unwrap();
        assert!(found.notes[1].contains("not reached"), "{:?}", found.notes);
    }
}
