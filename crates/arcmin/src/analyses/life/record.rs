//! Results of a machine over its hours, compared with its limits.

use super::bearings::{BearingLives, catalogue_life_at_duty};
use super::demands::Demands;
use super::fatigue::fatigue;
use super::verdict::{Limit, LimitKind, STATIC_PRESSURE};
use crate::checks::{CONTACT_PRESSURE, Finding, Severity};
use crate::life::{LifePoint, Prediction, RunAway, crossing};
use crate::machine::DutyPoint;
use crate::units::{ARCMIN, HOUR, MPA, RPM, UM};

/// A value over hours.
pub(super) type History = Vec<(f64, f64)>;

/// All quantities with limits. Histories contain (h, value in the unit of the limit).
#[derive(Debug, Clone)]
pub(in crate::analyses) struct Record {
    demands: Demands,
    /// Lost motion of the whole machine, also beyond the service life.
    pub lost_motion: History,
    /// Largest pressure at the largest torque of rating and duty.
    pub pressure: History,
    /// Standard deviation of single pressures about `pressure`, in MPa.
    pub pressure_scatter: f64,
    /// Peak to peak at rated torque.
    pub transmission_error: History,
    /// At the points at which it is computed.
    pub backlash: History,
    /// The bearing with the shortest life, and its L10 in h.
    pub bearing: Option<(String, f64)>,
    /// Largest pressure in MPa at the emergency torque, new and worn, where the design names one.
    emergency_pressure: Option<f64>,
    runs_away: Option<RunAway>,
    /// Codes of the error findings.
    errors: Vec<&'static str>,
    pub service_h: f64,
    /// Hours up to which the limit of lost motion was searched.
    pub searched_h: f64,
}

impl Record {
    pub fn of(
        demands: Demands,
        prediction: &Prediction,
        bearings: &BearingLives,
        findings: &[Finding],
        emergency_pressure: Option<f64>,
    ) -> Record {
        let points = &prediction.points;
        let history = |value: &dyn Fn(&LifePoint) -> f64| -> History {
            points.iter().map(|point| (point.hours(), value(point))).collect()
        };
        let backlash = points
            .iter()
            .filter_map(|point| Some((point.hours(), point.travel?.free_travel.arcmin())))
            .collect();
        Record {
            service_h: demands.limits.service_life / HOUR,
            demands,
            lost_motion: prediction.lost_motion.iter().map(|(h, lost)| (*h, lost / ARCMIN)).collect(),
            pressure: history(&|point| point.accuracy.max_pressure / MPA),
            pressure_scatter: points
                .iter()
                .map(|point| point.accuracy.pressure_scatter / MPA)
                .fold(0.0, f64::max),
            transmission_error: history(&|point| point.accuracy.loaded_peak_to_peak.arcmin()),
            backlash,
            bearing: bearings.worst().map(|worst| (worst.name.clone(), worst.life_h)),
            emergency_pressure: emergency_pressure.map(|pressure| pressure / MPA),
            runs_away: prediction.runs_away,
            // The pressure over the hours has a limit of its own; the finding about the pressure of the new machine
            // is not counted again.
            errors: findings
                .iter()
                .filter(|finding| finding.severity == Severity::Error && finding.code != CONTACT_PRESSURE)
                .map(|finding| finding.code)
                .collect(),
            searched_h: prediction.searched_hours,
        }
    }

    /// The same with the rate of wear multiplied by a factor.
    pub fn faster(&self, factor: f64) -> Record {
        let sooner = |history: &History| history.iter().map(|(hours, x)| (hours / factor, *x)).collect();
        Record {
            lost_motion: sooner(&self.lost_motion),
            pressure: sooner(&self.pressure),
            transmission_error: sooner(&self.transmission_error),
            backlash: sooner(&self.backlash),
            runs_away: self.runs_away.map(|end| RunAway { hours: end.hours / factor, ..end }),
            ..self.clone()
        }
    }

    /// The same with the lost motion continued at its last rate to some hours.
    pub fn continued(mut self, hours: f64) -> Record {
        if let [.., (h0, v0), (h1, v1)] = self.lost_motion[..]
            && hours > h1
            && h1 > h0
            && self.runs_away.is_none()
        {
            self.lost_motion.push((hours, v1 + (v1 - v0).max(0.0) / (h1 - h0) * (hours - h1)));
        }
        self
    }

    /// In the order of the kinds; the same kinds for every machine of one design.
    pub fn limits(&self) -> Vec<Limit> {
        let mut limits = vec![self.lost_motion(), self.contact_pressure()];
        limits.extend(self.bearing_life());
        limits.extend(self.of_the_maker());
        limits.extend(self.runs_away());
        limits.extend(self.errors());
        limits
    }

    fn lost_motion(&self) -> Limit {
        let allowed = self.demands.limits.lost_motion / ARCMIN;
        let hours = crossing(&self.lost_motion, allowed);
        Limit::new(LimitKind::LostMotion, at(&self.lost_motion, self.service_h), allowed).lasting(hours)
    }

    fn contact_pressure(&self) -> Limit {
        let limit = worn_in(&self.pressure, self.demands.limits.contact_pressure / MPA);
        Limit { scatter: Some(self.pressure_scatter), ..limit }
    }

    fn bearing_life(&self) -> Option<Limit> {
        let (name, life) = self.bearing.as_ref()?;
        let limit = Limit::new(LimitKind::BearingLife, *life, self.service_h).lasting(Some(*life));
        Some(Limit { place: Some(name.clone()), ..limit })
    }

    /// Limits that a design may set beyond those that every design has.
    fn of_the_maker(&self) -> Vec<Limit> {
        let limits = &self.demands.limits;
        let over_life = |kind: LimitKind, allowed: Option<f64>, history: &History| {
            let allowed = allowed?;
            let value = history.iter().map(|(_, value)| *value).fold(0.0, f64::max);
            Some(Limit::new(kind, value, allowed).lasting(crossing(history, allowed)))
        };
        let at_once = |kind: LimitKind, allowed: Option<f64>, value: f64| {
            let allowed = allowed?;
            Some(Limit::new(kind, value, allowed).lasting((value > allowed).then_some(0.0)))
        };
        let (demands, duty) = (&self.demands, &self.demands.duty);
        let torque = DutyPoint::largest_torque(duty);
        let speed = duty.iter().map(|row| demands.output_speed(row) / RPM).fold(0.0, f64::max);
        let fatigue = limits.contact_endurance.map(|endurance| {
            let history: History = self.pressure.iter().map(|(h, pressure)| (*h, pressure * MPA)).collect();
            let searched = self.searched_h.max(self.service_h);
            let (value, hours) = fatigue(demands, &history, endurance, searched);
            Limit::new(LimitKind::ContactFatigue, value, 1.0).lasting(hours)
        });
        let catalogue = limits.catalogue_life.and_then(|life| {
            let hours = catalogue_life_at_duty(demands, life / HOUR)?;
            Some(Limit::new(LimitKind::CatalogueLife, hours, self.service_h).lasting(Some(hours)))
        });
        [
            over_life(
                LimitKind::TransmissionError,
                limits.transmission_error.map(|limit| limit / ARCMIN),
                &self.transmission_error,
            ),
            over_life(LimitKind::Backlash, limits.backlash.map(|limit| limit / ARCMIN), &self.backlash),
            at_once(LimitKind::StartStopTorque, limits.start_stop_torque, torque),
            self.emergency_pressure
                .and_then(|pressure| at_once(LimitKind::EmergencyTorque, Some(STATIC_PRESSURE), pressure)),
            at_once(LimitKind::OutputSpeed, limits.output_speed.map(|limit| limit / RPM), speed),
            catalogue,
            fatigue,
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Wear that runs away within the service life.
    fn runs_away(&self) -> Option<Limit> {
        let end = self.runs_away?;
        let allowed = self.demands.past_use / UM;
        Some(Limit::new(LimitKind::Wear, end.depth / UM, allowed).lasting(Some(end.hours)))
    }

    fn errors(&self) -> Option<Limit> {
        let limit = Limit::new(LimitKind::Findings, self.errors.len() as f64, 0.0).lasting(Some(0.0));
        (!self.errors.is_empty()).then(|| Limit { place: Some(self.errors.join(", ")), ..limit })
    }
}

/// A history at some hours by linear interpolation; constant beyond its ends.
pub(super) fn at(history: &[(f64, f64)], hours: f64) -> f64 {
    let next = history.partition_point(|(h, _)| *h < hours);
    match (next.checked_sub(1).map(|before| history[before]), history.get(next)) {
        (Some((h0, v0)), Some((h1, v1))) => v0 + (v1 - v0) * (hours - h0) / (h1 - h0),
        (Some((_, value)), None) | (None, Some(&(_, value))) => value,
        (None, None) => 0.0,
    }
}

/// Scatter of the estimated pressure from one hour to the next (tested). After running-in a pressure above its limit
/// by less than this does not count.
const RESOLUTION: f64 = 0.02;

/// A pressure over hours against its limit. New parts touch at few places with a high pressure, which falls as these
/// places wear. If the pressure exceeds the limit when new, falls below it and stays there, this is running-in and
/// does not end the life.
pub(super) fn worn_in(history: &[(f64, f64)], allowed: f64) -> Limit {
    let value = history.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    let limit = Limit::new(LimitKind::ContactPressure, value, allowed);
    let above = history.iter().take_while(|(_, value)| *value > allowed).count();
    if above > 0
        && let Some(&(h1, v1)) = history.get(above)
        && history[above..].iter().all(|(_, value)| *value <= allowed * (1.0 + RESOLUTION))
    {
        let (h0, v0) = history[above - 1];
        return Limit { worn_in_h: Some(h0 + (h1 - h0) * (v0 - allowed) / (v0 - v1)), ..limit };
    }
    limit.lasting(crossing(history, allowed.next_up()))
}
