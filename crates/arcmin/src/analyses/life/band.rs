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

use super::record::{History, Record, at};
use super::verdict::{Limit, LimitKind, about};
use crate::analyses::stage::AnyDesign;
use crate::analyses::{AnalysisError, Host};
use crate::checks::Finding;
use crate::design::Unknown;
use crate::design::variation::Distribution;
use crate::life::LifeOptions;
use crate::results::Value;

/// Share of the distribution beyond either end of a band.
const TAIL: f64 = 0.05;
const DRAWS: u64 = 1000;
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
    pub(super) furthest_h: f64,
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
    /// In each state: changes of lost motion, transmission error and backlash in arcmin, and ring by ring the logarithm of
    /// the ratio of pressures.
    lost_motion: Vec<f64>,
    transmission_error: Vec<f64>,
    backlash: Vec<f64>,
    pressure: Vec<Vec<f64>>,
    /// Logarithms of the ratios of the rate of wear and of the shortest bearing life.
    wear: f64,
    bearing: f64,
}

impl Effect {
    fn add(&mut self, share: f64, other: &Effect) {
        let add = |sum: &mut Vec<f64>, more: &[f64]| {
            sum.resize(sum.len().max(more.len()), 0.0);
            sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += share * more);
        };
        add(&mut self.lost_motion, &other.lost_motion);
        add(&mut self.transmission_error, &other.transmission_error);
        add(&mut self.backlash, &other.backlash);
        self.pressure.resize_with(self.pressure.len().max(other.pressure.len()), Vec::new);
        self.pressure.iter_mut().zip(&other.pressure).for_each(|(sum, more)| add(sum, more));
        self.wear += share * other.wear;
        self.bearing += share * other.bearing;
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
pub(in crate::analyses) struct Bands {
    /// Band of the first of all limits.
    pub first: Band,
    /// Bands in the order of the limits.
    pub limits: Vec<Band>,
}

/// Limits of the records of all rings, always of the same kinds.
pub(in crate::analyses) type LimitsOf<'a> = &'a (dyn Fn(&[Record]) -> Vec<Limit> + Sync);

/// The uncertain inputs with their effects.
#[derive(Debug, Clone)]
pub(in crate::analyses) struct Inputs {
    inputs: Vec<Input>,
    /// Hours of the evaluated states.
    stations: Vec<f64>,
}

impl Inputs {
    /// Sets every input of a design to either end of its range. `free` is the design without `[unknowns]`, `present` its
    /// results in states of wear at the hours of `stations`; `results_of` gives those of others, `None` where they are the same.
    ///
    /// # Errors
    /// [`AnalysisError::Stopped`] when the host requests it.
    pub fn evaluate<S>(
        unknowns: Vec<Unknown>,
        (free, present): (&AnyDesign, &BandResults),
        stations: Vec<f64>,
        results_of: S,
        host: &dyn Host,
    ) -> Result<Inputs, AnalysisError>
    where
        S: Fn(&AnyDesign) -> Result<Option<BandResults>, AnalysisError> + Sync,
    {
        let ends: Vec<(Unknown, f64)> = unknowns
            .into_iter()
            .map(|unknown| {
                let own = free.get(&unknown.path).ok().and_then(|value| value.as_number());
                Unknown { nominal: own.unwrap_or(unknown.nominal), ..unknown }
            })
            .flat_map(|unknown| unknown.distribution.bounds().map(|end| (unknown.clone(), end)))
            .collect();
        // An end without a valid design or equilibrium has no effect here; `--band` counts such drives.
        let effects: Vec<Effect> = ends
            .par_iter()
            .map(|(unknown, end)| {
                let moved = free.with(&unknown.path, *end).ok().filter(|_| !host.is_cancelled());
                let found = moved.and_then(|moved| results_of(&moved).ok().flatten());
                found.map_or_else(Effect::default, |found| found.against(present))
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

    /// The record of a ring as it would be with these effects.
    fn changed(&self, (ring, record): (usize, &Record), effect: &Effect) -> Record {
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
        add(&mut changed.pressure, effect.pressure.get(ring).map_or(&[], Vec::as_slice), true);
        if let Some((_, life)) = &mut changed.bearing {
            *life *= effect.bearing.exp();
        }
        changed.faster(effect.wear.exp())
    }

    /// Bands of the limits of the records of all rings; `None` without `[unknowns]`.
    pub fn bands(&self, records: &[Record], limits_of: LimitsOf<'_>) -> Option<Bands> {
        let Record { searched_h, service_h, .. } = *records.first().filter(|_| !self.inputs.is_empty())?;
        let furthest_h = searched_h.max(LifeOptions::default().search_factor * service_h);
        let records: Vec<Record> =
            records.iter().map(|record| record.clone().continued(furthest_h)).collect();
        let kinds: Vec<LimitKind> = limits_of(&records).iter().map(|limit| limit.kind).collect();
        let hours_with = |effect: &Effect| -> Vec<f64> {
            let changed: Vec<Record> =
                records.iter().enumerate().map(|record| self.changed(record, effect)).collect();
            let limits = limits_of(&changed);
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
            let furthest_h = if over_service { service_h } else { furthest_h };
            Band { low: end(TAIL), high: end(1.0 - TAIL), hangs_on, furthest_h }
        };
        let mut bands: Vec<Band> = (0..draws[0].len()).map(band).collect();
        let mut first = bands.remove(0);
        if first.hangs_on.is_none() {
            first.hangs_on = self.moves_lost_motion_most(service_h);
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

/// Finding if the effects of the inputs cannot be computed: the hours have no band.
pub(in crate::analyses) fn no_band(error: &AnalysisError) -> Finding {
    Finding::warning(
        "bands",
        format!("hours have no band: {error}"),
        "the hours are not known more exactly than the inputs",
        "`--band` computes complete lives, and counts those without a result",
    )
}

/// Results of a drive used for bands.
pub(in crate::analyses) struct BandResults {
    /// In each state, in arcmin.
    pub lost_motion: Vec<f64>,
    pub transmission_error: Vec<f64>,
    /// Empty where the design has no limit.
    pub backlash: Vec<f64>,
    /// Ring by ring in each state, in MPa.
    pub pressure: Vec<Vec<f64>>,
    /// Rate of wear, up to a common factor of all drives.
    pub wear: f64,
    /// Shortest bearing life in h.
    pub bearing: f64,
}

impl BandResults {
    /// No results yet.
    pub fn of_rings(rings: usize) -> BandResults {
        BandResults {
            lost_motion: Vec::new(),
            transmission_error: Vec::new(),
            backlash: Vec::new(),
            pressure: vec![Vec::new(); rings],
            wear: 1.0,
            bearing: 1.0,
        }
    }
}

impl BandResults {
    fn against(&self, nominal: &BandResults) -> Effect {
        let difference = |of: fn(&BandResults) -> &Vec<f64>| -> Vec<f64> {
            of(self).iter().zip(of(nominal)).map(|(a, b)| a - b).collect()
        };
        let ratio = |a: f64, b: f64| if a > 0.0 && b > 0.0 { (a / b).ln() } else { 0.0 };
        let ratios = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| ratio(*a, *b)).collect();
        Effect {
            lost_motion: difference(|results| &results.lost_motion),
            transmission_error: difference(|results| &results.transmission_error),
            backlash: difference(|results| &results.backlash),
            pressure: self.pressure.iter().zip(&nominal.pressure).map(|(a, b)| ratios(a, b)).collect(),
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
