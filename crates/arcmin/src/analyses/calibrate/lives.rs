//! Hours to the limit of lost motion of a machine, and lost motion over time.

use super::Row;
use super::limits::{End, Remaining};
use super::observations::{NewIs, Observations};
use crate::analyses::life::LimitKind;
use crate::machine::Limits;
use crate::units::{ARCMIN, HOUR};
use crate::wear::{Fit, Growth, Model, Truth};

/// Points of the curve.
const CURVE_POINTS: usize = 120;

/// Hours for which a machine keeps its limit of lost motion.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineLife {
    /// Name in the file; `None` for the prediction of the design.
    pub name: Option<String>,
    /// Hours of its last reading.
    pub last_h: f64,
    /// Lost motion allowed, in rad.
    pub limit: f64,
    /// Lost motion when new in rad; for the design's prediction its own.
    pub new: f64,
    /// Origin of that value.
    pub new_is: NewIs,
    /// Hours since new to the limit; `None` where the limit is not reached within what was followed.
    pub hours: Option<f64>,
    /// Lower end of their 95 % band.
    pub low: Option<f64>,
    /// Upper end of their 95 % band.
    pub high: Option<f64>,
}

/// Depth in m and increase of lost motion in rad at one time, each with its band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Hours since new.
    pub hours: f64,
    /// Depth at the best fit, and its band.
    pub depth: (f64, Option<(f64, f64)>),
    /// Increase at the best fit, and its band.
    pub increase: (f64, Option<(f64, f64)>),
}

impl MachineLife {
    /// Its limit of lost motion.
    pub(super) fn remaining(&self, searched_h: f64) -> Remaining {
        Remaining {
            kind: LimitKind::LostMotion,
            place: None,
            machine: self.name.clone(),
            allowed: self.limit / ARCMIN,
            now_h: self.last_h,
            searched_h,
            end: End::At { hours: self.hours, low: self.low, high: self.high },
        }
    }
}

/// The design's own prediction, and that of every machine whose lost motion was read.
pub(super) fn lives(
    limits: &Limits,
    new: f64,
    model: &Model<'_>,
    fit: &Fit,
    all: &Observations,
    rows: &[Row],
) -> Vec<MachineLife> {
    let limit = limits.lost_motion;
    let life = |name: Option<String>, last: f64, new_is: NewIs, new_of: &dyn Fn(&Truth) -> f64| {
        let hours = |truth: &Truth| {
            let exposure = model.growth.exposure_at(limit - new_of(truth));
            exposure.map_or(f64::INFINITY, |exposure| truth.law.time_at(exposure)) / HOUR
        };
        let known = |hours: f64| hours.is_finite().then_some(hours);
        let (best, band) = (Truth::best(fit.law), fit.band(hours));
        MachineLife {
            name,
            last_h: last / HOUR,
            limit,
            new: new_of(&best),
            new_is,
            hours: known(hours(&best)),
            low: band.and_then(|(low, _)| known(low)),
            high: band.and_then(|(_, high)| known(high)),
        }
    };
    let last = rows.iter().map(|row| row.observed.reading.time).fold(0.0, f64::max);
    let mut lives = vec![life(None, last, NewIs::Assumed, &|_| new)];
    for number in model.machines() {
        let one = &all.machines[number];
        let of_machine = |truth: &Truth| model.new_of(number, truth);
        lives.push(life(Some(one.shown_name()), one.last, one.new, &of_machine));
    }
    lives
}

/// The prediction over time, up to the last of readings and limit and within the computed wear. The band ends where
/// its fastest wear leaves the computed range.
pub(super) fn curve(growth: &Growth, fit: &Fit, rows: &[Row], lives: &[MachineLife]) -> Vec<CurvePoint> {
    let last = rows.iter().map(|row| row.observed.reading.time / HOUR).fold(0.0, f64::max);
    let limits = lives.iter().filter_map(|life| life.hours).map(|hours| 1.05 * hours);
    let end = limits.filter(|hours| *hours <= 8.0 * last).fold(1.2 * last, f64::max);
    let end = end.min(fit.law.time_at(growth.last()) / HOUR);
    let point = |index: usize| {
        let hours = end * index as f64 / CURVE_POINTS as f64;
        let of = |value: &dyn Fn(f64) -> f64| {
            let at = |truth: &Truth| {
                let exposure = truth.law.at(hours * HOUR);
                if growth.covers(exposure) { value(exposure) } else { f64::INFINITY }
            };
            (value(fit.law.at(hours * HOUR)), fit.band(at).filter(|(_, high)| high.is_finite()))
        };
        CurvePoint { hours, depth: of(&|x| growth.depth(x)), increase: of(&|x| growth.increase(x)) }
    };
    (0..=CURVE_POINTS).map(point).collect()
}
