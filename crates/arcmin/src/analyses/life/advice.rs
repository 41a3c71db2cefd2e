//! Advice from sensitivities: change of the quantity that ends the life first by changes of keys of the design.

use rayon::prelude::*;

use super::bearings::{self, lives_in_friction};
use super::verdict::{LifeVerdict, Limit, LimitKind, about};
use crate::analyses::{AnalysisError, Host};
use crate::design::{Design, Value};
use crate::fidelity::{Fidelity, MachineMeshing};
use crate::life::{LifePoint, Prediction, lost_motion_of, most_loaded};
use crate::load::{Cycle, LoadError, ShareLoad};
use crate::machine::Machine;
use crate::report::{compact, significant};
use crate::rig::dynamic_load_rating;
use crate::units::{ARCMIN, MPA};

/// One change with its gain.
#[derive(Debug, Clone, PartialEq)]
pub struct Advice {
    /// Key of the design.
    pub key: &'static str,
    /// Value now, in the unit of the key.
    pub from: f64,
    /// Value after a realistic change.
    pub to: f64,
    /// The quantity that ends the life first, now, in the unit of its kind.
    pub before: f64,
    /// The same quantity after the change.
    pub after: f64,
    /// The same as a sentence.
    pub text: String,
}

/// A key that may be changed, with a realistic change.
struct Lever {
    key: &'static str,
    words: &'static str,
    unit: &'static str,
    /// Factor on the present value.
    factor: f64,
    /// Sign of the change of the wear depth in given hours with the value: 1, −1, or 0 for no effect.
    wear: f64,
}

impl Lever {
    /// The changed value: counts by one, all others by their factor.
    fn to(&self, from: f64) -> f64 {
        if self.key == COUNT { from + 1.0 } else { from * self.factor }
    }
}

const fn lever(key: &'static str, words: &'static str, unit: &'static str, factor: f64, wear: f64) -> Lever {
    Lever { key, words, unit, factor, wear }
}

/// Accuracy: clearances one class closer, stiffer parts, less wear.
const ACCURACY: &[Lever] = &[
    lever("bearings.turning_arm.clearance_um", "turning-arm clearance", "µm", 0.6, 0.0),
    lever("bearings.crank_support.clearance_um", "clearance of the crank supports", "µm", 0.6, 0.0),
    lever("bearings.main.clearance_um", "clearance of the main bearings", "µm", 0.6, 0.0),
    lever("bearings.turning_arm.roller_length_mm", "length of the turning-arm rollers", "mm", 1.15, 0.0),
    lever("bearings.crank_support.roller_length_mm", "length of the support rollers", "mm", 1.15, 0.0),
    lever("gear_stage.backlash_um", "backlash of the gears", "µm", 0.6, 0.0),
    lever("gear_stage.mesh_stiffness_n_per_um", "stiffness of the gear meshes", "N/µm", 1.25, 0.0),
    lever("disc.modification.equidistant_offset_um", "equidistant offset", "µm", 0.6, 0.0),
    lever("disc.modification.radial_offset_um", "radial offset", "µm", 0.6, 0.0),
    lever("disc.width_mm", "disc width", "mm", 1.15, -1.0),
    lever("wear.coupled.coefficient_mm2_per_n", "wear coefficient (lubricant, surface)", "mm²/N", 0.5, 1.0),
];

/// The ripple under load depends on the load.
const LESS_TORQUE: &[Lever] = &[lever("load.rated_torque_n_m", "rated torque", "N·m", 0.9, 0.0)];

/// The key that is counted.
const COUNT: &str = "crankshafts.count";

/// Bearing life: larger ratings, lower loads.
const LIFE: &[Lever] = &[
    lever("bearings.turning_arm.roller_length_mm", "length of the turning-arm rollers", "mm", 1.15, 0.0),
    lever("bearings.turning_arm.dynamic_load_rating_kn", "load rating of the turning arms", "kN", 1.15, 0.0),
    lever("bearings.turning_arm.clearance_um", "turning-arm clearance", "µm", 0.6, 0.0),
    lever("bearings.crank_support.roller_length_mm", "length of the support rollers", "mm", 1.15, 0.0),
    lever(
        "bearings.crank_support.dynamic_load_rating_kn",
        "load rating of the crank supports",
        "kN",
        1.15,
        0.0,
    ),
    lever("bearings.crank_support_span_mm", "span of the crank supports", "mm", 1.15, 0.0),
    lever(COUNT, "crankshafts", "", 1.0, 0.0),
    lever("load.rated_torque_n_m", "torque of the duty", "N·m", 0.9, 0.0),
    lever("load.input_speed_rpm", "input speed of the duty", "rpm", 0.9, 0.0),
];

/// Contact pressure: softer contacts, more of them, less force.
const PRESSURE: &[Lever] = &[
    lever("disc.width_mm", "disc width", "mm", 1.15, 0.0),
    lever("ring.pin_radius_mm", "pin radius", "mm", 1.1, 0.0),
    lever("disc.modification.equidistant_offset_um", "equidistant offset", "µm", 0.6, 0.0),
    lever("disc.modification.radial_offset_um", "radial offset", "µm", 0.6, 0.0),
    lever("bearings.turning_arm.clearance_um", "turning-arm clearance", "µm", 0.6, 0.0),
    lever("load.rated_torque_n_m", "torque of rating and duty", "N·m", 0.9, 0.0),
];

/// Share of a realistic change used for the difference quotient.
const SMALL: f64 = 0.05;
/// Changes named.
const NAMED: usize = 3;
/// Crank positions for the sensitivities of bearings: only their order matters.
const ROUGH: usize = 12;
/// Crank positions of the load sharing, as in the prediction.
const POSITIONS: usize = 36;
/// Factor on their number if the full period is the whole ring, as in the prediction.
const RING_POSITIONS: usize = 4;

/// Keys that may be changed for a limit. Limits of the duty and findings have their own remedies.
fn levers(kind: LimitKind) -> Vec<&'static Lever> {
    match kind {
        LimitKind::LostMotion | LimitKind::Backlash => ACCURACY.iter().collect(),
        LimitKind::TransmissionError => ACCURACY.iter().chain(LESS_TORQUE).collect(),
        LimitKind::BearingLife => LIFE.iter().collect(),
        LimitKind::ContactPressure | LimitKind::ContactFatigue => PRESSURE.iter().collect(),
        _ => Vec::new(),
    }
}

/// The limit for which advice is computed: the one that ends the life first, or, if that one states its own remedy,
/// the first of the others that are not kept.
fn subject(verdict: &LifeVerdict) -> Option<(LimitKind, Vec<&'static Lever>)> {
    let Some(first) = verdict.limited_by() else {
        return Some((LimitKind::LostMotion, levers(LimitKind::LostMotion)));
    };
    let hours = |limit: &Limit| limit.hours.unwrap_or(f64::INFINITY);
    let mut others: Vec<&Limit> =
        verdict.limits.iter().filter(|limit| !limit.is_kept(verdict.service_h)).collect();
    others.sort_by(|a, b| hours(a).total_cmp(&hours(b)));
    let all = std::iter::once(first).chain(others);
    all.map(|limit| (limit.kind, levers(limit.kind))).find(|(_, levers)| !levers.is_empty())
}

/// The three best changes for the limit that ends the life first.
///
/// Sensitivities are differences at a twentieth of a realistic change; the three best are computed again with the
/// whole change. Keys whose change gives no valid design are omitted.
///
/// # Errors
/// [`AnalysisError::Stopped`] when the host requests it.
pub(super) fn advise(
    design: &Design,
    fidelity: &Fidelity,
    prediction: &Prediction,
    verdict: &LifeVerdict,
    host: &dyn Host,
) -> Result<Vec<Advice>, AnalysisError> {
    let Some((kind, levers)) = subject(verdict) else { return Ok(Vec::new()) };
    let question = Question { kind, fidelity, prediction };
    let machine = design.machine();
    let (Some(before), Some(rough)) =
        (question.ask(&machine, 0.0, bearings::POSITIONS), question.ask(&machine, 0.0, ROUGH))
    else {
        return Ok(Vec::new());
    };
    let mut slopes: Vec<(&Lever, f64, f64)> = levers
        .into_par_iter()
        .filter_map(|lever| {
            let from = present(design, &machine, lever.key)?;
            if from == 0.0 || host.is_cancelled() {
                return None;
            }
            // A count has no small step.
            let share = if lever.key == COUNT { 1.0 } else { SMALL };
            let small = from + share * (lever.to(from) - from);
            let after = question.with(design, lever, small, ROUGH)?;
            Some((lever, from, kind_sign(kind) * (after - rough) / share))
        })
        .collect();
    slopes.sort_by(|a, b| b.2.total_cmp(&a.2));
    // Some changes are possible in small steps but not as a whole, such as a roller longer than the width of its
    // disc.
    let worth = slopes.into_iter().filter(|(_, _, gain)| *gain > 0.005 * before.abs()).take(2 * NAMED);
    let mut best = Vec::new();
    for (lever, from, _) in worth {
        if best.len() == NAMED || host.is_cancelled() {
            break;
        }
        let to = lever.to(from);
        let Some(after) = question.with(design, lever, to, bearings::POSITIONS) else { continue };
        if kind_sign(kind) * (after - before) > 0.0 {
            let text = sentence(lever, from, to, kind, before, after);
            best.push(Advice { key: lever.key, from, to, before, after, text });
        }
    }
    if host.is_cancelled() { Err(AnalysisError::Stopped) } else { Ok(best) }
}

/// Present value of a key; a missing load rating follows from the geometry of the bearing.
fn present(design: &Design, machine: &Machine, key: &str) -> Option<f64> {
    let bearing = match key {
        "bearings.turning_arm.dynamic_load_rating_kn" => Some(&machine.bearings.turning_arm),
        "bearings.crank_support.dynamic_load_rating_kn" => Some(&machine.bearings.crank_support),
        _ => None,
    };
    match (design.get(key).ok()?, bearing) {
        (Value::Number(number), _) => Some(number),
        (Value::Count(count), _) => Some(count as f64),
        (_, Some(bearing)) => Some(dynamic_load_rating(bearing) * 1e-3),
        _ => None,
    }
}

/// +1 if a larger value is better.
fn kind_sign(kind: LimitKind) -> f64 {
    if kind == LimitKind::BearingLife { 1.0 } else { -1.0 }
}

fn sentence(lever: &Lever, from: f64, to: f64, kind: LimitKind, before: f64, after: f64) -> String {
    let amount = |value: f64| match kind {
        LimitKind::BearingLife => about(value),
        LimitKind::ContactPressure | LimitKind::ContactFatigue => significant(value, 4),
        _ => significant(value, 3),
    };
    let unit = if lever.unit.is_empty() { String::new() } else { format!(" {}", lever.unit) };
    let of = match kind {
        LimitKind::BearingLife => "shortest bearing life",
        LimitKind::ContactPressure | LimitKind::ContactFatigue => "largest contact pressure",
        LimitKind::TransmissionError => "largest transmission error over the life, peak to peak",
        LimitKind::Backlash => "backlash at the end of the service life",
        _ => "lost motion at the end of the service life",
    };
    format!(
        "{} {} → {}{unit}: {of} {} → {} {}",
        lever.words,
        compact(from, 3),
        compact(to, 3),
        amount(before),
        amount(after),
        if kind == LimitKind::ContactFatigue { "MPa" } else { kind.unit() }
    )
}

/// Evaluation of the quantity that ends the life first for a changed machine, at low cost.
struct Question<'a> {
    kind: LimitKind,
    fidelity: &'a Fidelity,
    prediction: &'a Prediction,
}

/// [`ShareLoad::loaded_cycle`] or [`ShareLoad::free_cycle`].
type CycleOf = fn(&mut MachineMeshing, f64, usize) -> Result<Cycle, LoadError>;

impl Question<'_> {
    fn with(&self, design: &Design, lever: &Lever, value: f64, positions: usize) -> Option<f64> {
        let from = present(design, &design.machine(), lever.key)?;
        // The elastic discs and bodies were reduced with their present bores.
        let reduced = self.fidelity.elastic.is_some() || self.fidelity.frame.is_some();
        if lever.key == COUNT && reduced {
            return None;
        }
        let mut machine = design.with(lever.key, value).ok()?.machine();
        // The duty consists of rows, or is the rated point.
        let scale = value / from;
        match lever.key {
            "load.rated_torque_n_m" if self.kind == LimitKind::BearingLife => {
                let rated = design.machine();
                machine.duty = rated.duty;
                machine.duty.iter_mut().for_each(|row| row.torque *= scale);
                machine.rated.torque = rated.rated.torque;
            }
            "load.rated_torque_n_m" => {
                machine.duty = design.machine().duty;
                machine.duty.iter_mut().for_each(|row| row.torque *= scale);
            }
            "load.input_speed_rpm" => {
                machine.duty = design.machine().duty;
                machine.duty.iter_mut().for_each(|row| row.input_speed *= scale);
            }
            _ => {}
        }
        self.ask(&machine, lever.wear * scale.ln(), positions)
    }

    /// `rate`: logarithm of the factor on the rate of wear. With s times the rate the state after H hours equals the
    /// present one after s H.
    fn ask(&self, machine: &Machine, rate: f64, positions: usize) -> Option<f64> {
        match self.kind {
            LimitKind::BearingLife => {
                let settings = self.fidelity.joint_settings().ok()?;
                Some(lives_in_friction(machine, &settings, positions).ok()?.worst()?.life_h)
            }
            LimitKind::ContactPressure | LimitKind::ContactFatigue => {
                let point = self.worst(|point| point.accuracy.max_pressure)?;
                let mut meshing = self.fidelity.meshing(machine).ok()?;
                point.state.apply_to(&machine.designed_relief(), &mut meshing);
                let found = most_loaded(&mut meshing, machine.largest_signed_torque(), POSITIONS).ok()?;
                Some(found.largest_pressure.pressure / MPA)
            }
            LimitKind::TransmissionError => {
                let value = |point: &LifePoint| point.accuracy.loaded_peak_to_peak.arcmin();
                // Less wear helps if the maximum occurs by wear, not if it is that of the new machine.
                let worst = self.worst(value)?;
                let end = self.prediction.points.last()?;
                let (point, rest) =
                    if std::ptr::eq(worst, end) { self.worn(rate, value)? } else { (worst, 0.0) };
                let cycle = self.cycle(machine, point, ShareLoad::loaded_cycle)?;
                Some(cycle.peak_to_peak_error().arcmin() + rest)
            }
            LimitKind::Backlash => {
                let travel =
                    |point: &LifePoint| point.travel.map_or(0.0, |travel| travel.free_travel.arcmin());
                let (point, rest) = self.worn(rate, travel)?;
                let cycle = self.cycle(machine, point, ShareLoad::free_cycle)?;
                Some(cycle.mean_free_travel().arcmin() + rest)
            }
            _ => {
                let joints = self.fidelity.in_bearings(machine).ok()?;
                let (point, rest) = self.worn(rate, |point| point.lost_motion.arcmin())?;
                let lost = lost_motion_of(machine, joints, &point.state).ok()? / ARCMIN;
                Some(lost + rest)
            }
        }
    }

    /// The point of the prediction at which a value is largest.
    fn worst(&self, value: impl Fn(&LifePoint) -> f64) -> Option<&LifePoint> {
        self.prediction.points.iter().max_by(|a, b| value(a).total_cmp(&value(b)))
    }

    /// One full period at rated torque of a changed machine with the surfaces of a point, at the crank positions of
    /// the prediction.
    fn cycle(&self, machine: &Machine, point: &LifePoint, of: CycleOf) -> Option<Cycle> {
        let mut meshing = self.fidelity.meshing(machine).ok()?;
        point.state.apply_to(&machine.designed_relief(), &mut meshing);
        let positions = if meshing.discs_alike() { POSITIONS } else { RING_POSITIONS * POSITIONS };
        of(&mut meshing, machine.rated.torque, positions).ok()
    }

    /// The point of the prediction nearest to a wear, and the growth of a value of the present machine from there.
    fn worn(&self, rate: f64, value: impl Fn(&LifePoint) -> f64) -> Option<(&LifePoint, f64)> {
        let points = &self.prediction.points;
        let end = points.last()?.hours();
        let hours = end * rate.exp();
        let at = points.partition_point(|point| point.hours() < hours).min(points.len() - 1);
        let (here, before) = (&points[at], &points[at.saturating_sub(1)]);
        let width = here.hours() - before.hours();
        let slope = if width > 0.0 { (value(here) - value(before)) / width } else { 0.0 };
        Some((here, slope * (hours - here.hours())))
    }
}
