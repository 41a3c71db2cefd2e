//! Bands of the hours for the uncertainty of the inputs of a design: first-order sensitivities of every
//! limit.
//!
//! Each input of `[unknowns]` alone is set to either end of its range. The effect on the machine in a few of its
//! states is computed with the same force laws and interpolated linearly. A thousand samples of all inputs give the
//! distribution of the hours of each limit. Wear is computed once: with s times the rate of wear the state after H
//! hours equals the present one after s H. The effect of a changed load sharing on the shape of the worn flank is of
//! second order and neglected; beyond the computed hours lost motion grows at its last rate. `arcmin life --band`
//! computes complete lives instead.

use rayon::prelude::*;

use super::bearings::lives_in_friction;
use super::record::{History, Record, at};
use super::verdict::{LimitKind, about};
use crate::analyses::rig::with_friction;
use crate::analyses::{AnalysisError, Host};
use crate::checks::{Finding, Severity};
use crate::design::variation::Distribution;
use crate::design::{Design, Unknown, Value as Written};
use crate::fidelity::Fidelity;
use crate::life::{LifeOptions, Prediction, WornState};
use crate::load::{Cycle, ShareLoad};
use crate::machine::{Machine, WearCoefficient};
use crate::results::Value;
use crate::units::{ARCMIN, MPA};
use crate::wear::{CoupledOptions, CoupledWear};

/// Share of the distribution beyond either end of a band.
const TAIL: f64 = 0.05;
const DRAWS: u64 = 1000;
/// Crank positions for lost motion, loads and bearings: only differences matter.
const LIGHT: usize = 12;
const LOADED: usize = 18;
/// Width of a band, as a logarithm of hours, below which an input has no effect.
const NOTHING: f64 = 0.01;

/// Range of the hours.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// Lower end in h of the range of nine of ten machines within the ranges of the inputs; `None` beyond the
    /// computed hours.
    pub low: Option<f64>,
    /// Upper end in h of that range; `None` beyond the computed hours.
    pub high: Option<f64>,
    /// Key of the input with the largest influence on the hours.
    pub hangs_on: Option<String>,
    /// Computed hours.
    furthest_h: f64,
}

impl Band {
    /// Whether both ends are equal when rounded to two digits.
    pub fn is_point(&self) -> bool {
        match (self.low, self.high) {
            (Some(low), Some(high)) => about(low) == about(high),
            (low, high) => low.is_none() && high.is_none(),
        }
    }

    /// "3100 to 7400 h".
    pub fn words(&self) -> String {
        match (self.low, self.high) {
            (Some(low), Some(high)) => format!("{} to {} h", about(low), about(high)),
            (Some(low), None) => format!("{} to more than {} h", about(low), about(self.furthest_h)),
            (None, _) => format!("more than {} h", about(self.furthest_h)),
        }
    }

    /// `[low, high]`, null beyond the computed hours.
    pub(super) fn value(&self) -> Value {
        Value::List(vec![self.low.into(), self.high.into()])
    }
}

/// Effects of one input at one end of its range.
#[derive(Debug, Clone, PartialEq, Default)]
struct Effect {
    /// In each state: changes of lost motion, transmission error and backlash in arcmin, and the logarithm of the
    /// ratio of pressures.
    lost_motion: Vec<f64>,
    transmission_error: Vec<f64>,
    backlash: Vec<f64>,
    pressure: Vec<f64>,
    /// Logarithms of the ratios of the rate of wear and of the shortest bearing life.
    wear: f64,
    bearing: f64,
}

impl Effect {
    fn add(&mut self, share: f64, other: &Effect) {
        let fields = |effect: &Effect| -> [Vec<f64>; 4] {
            [
                effect.lost_motion.clone(),
                effect.transmission_error.clone(),
                effect.backlash.clone(),
                effect.pressure.clone(),
            ]
        };
        let mut sums = fields(self);
        for (sum, more) in sums.iter_mut().zip(fields(other)) {
            sum.resize(sum.len().max(more.len()), 0.0);
            sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += share * more);
        }
        let [lost_motion, transmission_error, backlash, pressure] = sums;
        let (wear, bearing) = (self.wear + share * other.wear, self.bearing + share * other.bearing);
        *self = Effect { lost_motion, transmission_error, backlash, pressure, wear, bearing };
    }
}

/// An input with its effects at the low and at the high end of its range.
#[derive(Debug, Clone)]
struct Input {
    unknown: Unknown,
    /// Whether it is a count, so that values between are rounded.
    is_counted: bool,
    ends: [Effect; 2],
}

impl Input {
    /// Adds the effect of the value at a share (0 to 1) of the distribution.
    fn add_at(&self, share: f64, sum: &mut Effect) {
        let [low, high] = self.unknown.distribution.bounds();
        let logarithmic = matches!(self.unknown.distribution, Distribution::LogUniform { .. });
        let on = |value: f64| if logarithmic { value.ln() } else { value };
        let drawn = self.unknown.distribution.quantile(share);
        let drawn = if self.is_counted { drawn.round() } else { drawn };
        let (value, nominal) = (on(drawn), on(self.unknown.nominal));
        let (end, effect) =
            if value < nominal { (on(low), &self.ends[0]) } else { (on(high), &self.ends[1]) };
        if end != nominal {
            sum.add((value - nominal) / (end - nominal), effect);
        }
    }
}

/// The bands of all limits.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bands {
    /// Of the first of all limits.
    pub first: Band,
    /// In the order of the limits.
    pub limits: Vec<Band>,
}

/// The uncertain inputs with their effects.
#[derive(Debug, Clone)]
pub(super) struct Inputs {
    inputs: Vec<Input>,
    /// Hours of the evaluated states.
    stations: Vec<f64>,
}

impl Inputs {
    /// Sets every input of a design to either end of its range. Bodies are rigid: elastic ones change the hours but
    /// hardly the effects of the inputs, and take much longer.
    ///
    /// # Errors
    /// [`AnalysisError::Stopped`] when the host requests it; errors of the present machine.
    pub fn look(
        design: &Design,
        fidelity: &Fidelity,
        prediction: &Prediction,
        host: &dyn Host,
    ) -> Result<Inputs, AnalysisError> {
        let points = &prediction.points;
        let mut states: Vec<&WornState> = vec![&points[0].state];
        states.extend([points.len() / 2, points.len() - 1].map(|index| &points[index].state));
        states.extend(&prediction.beyond);
        states.dedup_by(|a, b| a.hours == b.hours);
        let rigid = Fidelity { elastic: None, frame: None, ..fidelity.clone() };
        let looked = Look { fidelity: &rigid, states: &states };
        // A separate finding reports ranges that exclude the value of the design.
        let free = design.with("unknowns", Written::LeftOut).unwrap_or_else(|_| design.clone());
        let free = in_friction(&free);
        let machine = free.machine();
        let nominal = looked.at(&machine)?;
        let stations = states.iter().map(|state| state.hours).collect();
        let ends: Vec<(Unknown, f64)> = design
            .unknowns()
            .into_iter()
            .map(|unknown| {
                let own = free.get(&unknown.path).ok().and_then(|value| value.as_number());
                Unknown { nominal: own.unwrap_or(unknown.nominal), ..unknown }
            })
            .flat_map(|unknown| unknown.distribution.bounds().map(|end| (unknown.clone(), end)))
            .collect();
        // An end without a valid design or equilibrium has no effect here; `--band` counts such machines.
        let effects: Vec<Effect> = ends
            .par_iter()
            .map(|(unknown, end)| {
                let moved = free.with(&unknown.path, *end).ok().map(|design| design.machine());
                let found = moved
                    .filter(|moved| !host.is_cancelled() && !rests_alike(moved, &machine))
                    .and_then(|moved| looked.at(&moved).ok());
                found.map_or_else(Effect::default, |found| found.against(&nominal))
            })
            .collect();
        if host.is_cancelled() {
            return Err(AnalysisError::Stopped);
        }
        let inputs = ends.chunks(2).zip(effects.chunks(2));
        let inputs = inputs
            .map(|(ends, effects)| Input {
                is_counted: matches!(free.get(&ends[0].0.path), Ok(crate::design::Value::Count(_))),
                unknown: ends[0].0.clone(),
                ends: [effects[0].clone(), effects[1].clone()],
            })
            .collect();
        Ok(Inputs { inputs, stations })
    }

    /// A record as it would be with these effects.
    fn changed(&self, record: &Record, effect: &Effect) -> Record {
        let mut changed = record.clone();
        let between = |values: &[f64]| -> History {
            self.stations.iter().copied().zip(values.iter().copied()).collect()
        };
        let add = |history: &mut History, values: &[f64], logarithmic: bool| {
            let more = between(values);
            if !more.is_empty() {
                for (hours, value) in history {
                    let more = at(&more, *hours);
                    *value = if logarithmic { *value * more.exp() } else { *value + more };
                }
            }
        };
        add(&mut changed.lost_motion, &effect.lost_motion, false);
        add(&mut changed.transmission_error, &effect.transmission_error, false);
        add(&mut changed.backlash, &effect.backlash, false);
        add(&mut changed.pressure, &effect.pressure, true);
        if let Some((_, life)) = &mut changed.bearing {
            *life *= effect.bearing.exp();
        }
        changed.faster(effect.wear.exp())
    }

    /// Bands of the limits of a record; `None` without `[unknowns]`.
    pub fn bands(&self, record: &Record) -> Option<Bands> {
        if self.inputs.is_empty() {
            return None;
        }
        let furthest_h = record.searched_h.max(LifeOptions::default().search_factor * record.service_h);
        let record = &record.clone().continued(furthest_h);
        let kinds: Vec<LimitKind> = record.limits().iter().map(|limit| limit.kind).collect();
        let hours_with = |effect: &Effect| -> Vec<f64> {
            let limits = self.changed(record, effect).limits();
            let hours: Vec<f64> = limits.iter().map(|limit| limit.hours.unwrap_or(f64::INFINITY)).collect();
            let first = hours.iter().copied().fold(f64::INFINITY, f64::min);
            std::iter::once(first).chain(hours).collect()
        };
        let draws: Vec<Vec<f64>> = (0..DRAWS)
            .into_par_iter()
            .map(|draw| {
                let mut effect = Effect::default();
                for (index, input) in self.inputs.iter().enumerate() {
                    input.add_at(share(draw, index as u64), &mut effect);
                }
                hours_with(&effect)
            })
            .collect();
        // One input alone, at either end of the band.
        let alone: Vec<[Vec<f64>; 2]> = self
            .inputs
            .par_iter()
            .map(|input| {
                [TAIL, 1.0 - TAIL].map(|share| {
                    let mut effect = Effect::default();
                    input.add_at(share, &mut effect);
                    hours_with(&effect)
                })
            })
            .collect();
        let logarithm = |hours: f64| hours.clamp(1.0, furthest_h).ln();
        let band = |limit: usize| {
            let mut hours: Vec<f64> = draws.iter().map(|draw| draw[limit]).collect();
            hours.sort_by(f64::total_cmp);
            let end = |share: f64| {
                let hours = hours[(share * (DRAWS - 1) as f64).round() as usize];
                hours.is_finite().then_some(hours)
            };
            let width =
                |input: &[Vec<f64>; 2]| (logarithm(input[0][limit]) - logarithm(input[1][limit])).abs();
            let widest = alone.iter().map(width).enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
            let hangs_on = widest.filter(|(_, width)| *width > NOTHING).map(|(index, _)| index);
            let hangs_on = hangs_on.map(|index| self.inputs[index].unknown.path.clone());
            // Only lost motion and lives of bearings are known beyond the service life.
            let over_service =
                limit.checked_sub(1).map(|limit| kinds[limit]).is_some_and(LimitKind::ends_with_service);
            let furthest_h = if over_service { record.service_h } else { furthest_h };
            Band { low: end(TAIL), high: end(1.0 - TAIL), hangs_on, furthest_h }
        };
        let mut bands: Vec<Band> = (0..draws[0].len()).map(band).collect();
        let mut first = bands.remove(0);
        if first.hangs_on.is_none() {
            first.hangs_on = self.moves_lost_motion_most(record.service_h);
        }
        Some(Bands { first, limits: bands })
    }

    /// The input with the largest influence on the lost motion at these hours, for a machine that reaches no limit.
    fn moves_lost_motion_most(&self, hours: f64) -> Option<String> {
        let width = |input: &Input| {
            let [low, high] = [0, 1].map(|end| {
                let lost = &input.ends[end].lost_motion;
                let history: History = self.stations.iter().copied().zip(lost.iter().copied()).collect();
                at(&history, hours)
            });
            (high - low).abs()
        };
        let widest = self.inputs.iter().map(|input| (width(input), input));
        let (width, input) = widest.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (width > 0.0).then(|| input.unknown.path.clone())
    }
}

/// The design with the friction in its bearing lives: its own, or the assumed one. Otherwise a single coefficient
/// other than zero would replace all assumed ones.
fn in_friction(design: &Design) -> Design {
    let (rough, assumed) = with_friction(&design.machine(), false);
    if !assumed {
        return design.clone();
    }
    let f = &rough.friction;
    let keys = [
        ("friction.flank_coefficient", f.flank),
        ("friction.pin_seat_coefficient", f.pin_seat),
        ("friction.bearing_coefficient", f.bearing),
        ("friction.gear_mesh_coefficient", f.gear_mesh),
        ("friction.seal_drag_n_m", f.seal_drag),
        ("friction.oil_drag_n_m_s_per_rad", f.oil_drag),
    ];
    design.with_all(keys).unwrap_or_else(|_| design.clone())
}

/// Finding if the effects of the inputs cannot be computed: the hours have no band.
pub(super) fn no_band(error: &AnalysisError) -> Finding {
    Finding {
        code: "bands",
        severity: Severity::Warning,
        message: format!("hours have no band: {error}"),
        value: 0.0,
        limit: 0.0,
        unit: "",
        why: "the hours are not known more exactly than the inputs",
        change: "`--band` computes complete lives, and counts those without a result",
    }
}

/// Whether two machines are the same in static equilibrium: masses and damping have an effect in motion only.
fn rests_alike(a: &Machine, b: &Machine) -> bool {
    let mut a = a.clone();
    a.disc.mass = b.disc.mass;
    a.disc.inertia = b.disc.inertia;
    (a.crankshafts.mass, a.crankshafts.inertia) = (b.crankshafts.mass, b.crankshafts.inertia);
    (a.carrier.mass, a.carrier.inertia) = (b.carrier.mass, b.carrier.inertia);
    a.housing = b.housing;
    a.gear_stage.mesh_damping = b.gear_stage.mesh_damping;
    a.gear_stage.sun_inertia = b.gear_stage.sun_inertia;
    a.gear_stage.motor_inertia = b.gear_stage.motor_inertia;
    a.contact_damping = b.contact_damping;
    // Rigid bodies have no use for the others.
    a.solids.carrier = b.solids.carrier.clone();
    a.solids.housing = b.solids.housing.clone();
    a == *b
}

/// States in which machines are evaluated.
struct Look<'a> {
    fidelity: &'a Fidelity,
    states: &'a [&'a WornState],
}

/// Results of a machine used for bands.
struct Seen {
    lost_motion: Vec<f64>,
    transmission_error: Vec<f64>,
    backlash: Vec<f64>,
    pressure: Vec<f64>,
    /// Mean wear rate of the flanks, up to a common factor of all machines.
    wear: f64,
    bearing: f64,
}

impl Look<'_> {
    fn at(&self, machine: &Machine) -> Result<Seen, AnalysisError> {
        let failed = || AnalysisError::compute("look how far the inputs move the life");
        let mut in_bearings = self.fidelity.in_bearings(machine)?;
        let mut meshing = self.fidelity.meshing(machine)?;
        let contact = machine.line_contact();
        let mut seen = Seen {
            lost_motion: Vec::new(),
            transmission_error: Vec::new(),
            backlash: Vec::new(),
            pressure: Vec::new(),
            wear: 1.0,
            bearing: 1.0,
        };
        for state in self.states {
            state.put_on(&machine.designed_relief(), &mut in_bearings);
            seen.lost_motion.push(in_bearings.lost_motion(LIGHT).map_err(failed())? / ARCMIN);
            state.put_on(&machine.designed_relief(), &mut meshing);
            let cycle: Cycle = meshing.loaded_cycle(machine.hardest_torque(), LOADED).map_err(failed())?;
            seen.pressure.push(cycle.max_pressure(&contact) / MPA);
            seen.transmission_error.push(cycle.peak_to_peak_error().arcmin());
            if machine.limits.backlash.is_some() {
                let free = meshing.free_cycle(machine.rated.torque, LIGHT).map_err(failed())?;
                seen.backlash.push(free.mean_free_travel().arcmin());
            }
        }
        // A calibrated coefficient gives the same wear for any other inputs.
        if let WearCoefficient::Given(coefficient) = machine.wear.coupled {
            let middle = &self.states[self.states.len() / 2].surfaces;
            let joints = self.fidelity.meshing(machine)?;
            let rate = CoupledWear::with(machine, joints, CoupledOptions::default())
                .mean_rate(middle)
                .map_err(AnalysisError::wear("look how far the inputs move the wear"))?;
            seen.wear = coefficient * rate;
        }
        let settings = self.fidelity.joint_settings()?;
        if let Some(worst) = lives_in_friction(machine, &settings, LIGHT)?.worst() {
            seen.bearing = worst.life_h;
        }
        Ok(seen)
    }
}

impl Seen {
    fn against(&self, nominal: &Seen) -> Effect {
        let difference = |of: fn(&Seen) -> &Vec<f64>| -> Vec<f64> {
            of(self).iter().zip(of(nominal)).map(|(a, b)| a - b).collect()
        };
        let ratio = |a: f64, b: f64| if a > 0.0 && b > 0.0 { (a / b).ln() } else { 0.0 };
        Effect {
            lost_motion: difference(|seen| &seen.lost_motion),
            transmission_error: difference(|seen| &seen.transmission_error),
            backlash: difference(|seen| &seen.backlash),
            pressure: self.pressure.iter().zip(&nominal.pressure).map(|(a, b)| ratio(*a, *b)).collect(),
            wear: ratio(self.wear, nominal.wear),
            bearing: ratio(self.bearing, nominal.bearing),
        }
    }
}

/// A number from 0 to 1 that depends only on draw and input (SplitMix64; Steele, Lea, Flood 2014).
fn share(draw: u64, input: u64) -> f64 {
    let mut z = (draw << 16 | input).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}
