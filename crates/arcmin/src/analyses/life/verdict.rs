//! One verdict over all limits of a machine, each with the hours for which it is kept.

use super::bearings::{BearingLives, catalogue_life_at_duty};
use super::fatigue::fatigue;
use crate::checks::{CONTACT_PRESSURE, Finding, Severity};
use crate::life::{LifePoint, Prediction};
use crate::machine::Machine;
use crate::report::{Tone, compact, significant};
use crate::results::Value;
use crate::units::{ARCMIN, HOUR, MPA, RPM, UM};
use crate::wear::depth_past_use;

/// What can end a life.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitKind {
    LostMotion,
    ContactPressure,
    BearingLife,
    TransmissionError,
    Backlash,
    StartStopTorque,
    EmergencyTorque,
    OutputSpeed,
    CatalogueLife,
    Wear,
    ContactFatigue,
    Findings,
}

impl LimitKind {
    /// Word of the summary.
    pub fn key(self) -> &'static str {
        match self {
            LimitKind::LostMotion => "lost_motion",
            LimitKind::ContactPressure => "contact_pressure",
            LimitKind::BearingLife => "bearing_life",
            LimitKind::TransmissionError => "transmission_error",
            LimitKind::Backlash => "backlash",
            LimitKind::StartStopTorque => "start_stop_torque",
            LimitKind::EmergencyTorque => "emergency_torque",
            LimitKind::OutputSpeed => "output_speed",
            LimitKind::CatalogueLife => "catalogue_life",
            LimitKind::Wear => "wear",
            LimitKind::ContactFatigue => "contact_fatigue",
            LimitKind::Findings => "findings",
        }
    }

    /// Words for a reader.
    pub fn name(self) -> &'static str {
        match self {
            LimitKind::LostMotion => "lost motion",
            LimitKind::ContactPressure => "contact pressure",
            LimitKind::BearingLife => "bearing life",
            LimitKind::TransmissionError => "transmission error",
            LimitKind::Backlash => "backlash",
            LimitKind::StartStopTorque => "start–stop torque",
            LimitKind::EmergencyTorque => "emergency torque",
            LimitKind::OutputSpeed => "output speed",
            LimitKind::CatalogueLife => "catalogue life",
            LimitKind::Wear => "wear",
            LimitKind::ContactFatigue => "fatigue of flanks and pins",
            LimitKind::Findings => "error findings",
        }
    }

    /// Unit of value and allowed value.
    pub fn unit(self) -> &'static str {
        match self {
            LimitKind::LostMotion | LimitKind::TransmissionError | LimitKind::Backlash => "arcmin",
            LimitKind::ContactPressure | LimitKind::EmergencyTorque => "MPa",
            LimitKind::BearingLife | LimitKind::CatalogueLife => "h",
            LimitKind::StartStopTorque => "N·m",
            LimitKind::Wear => "µm",
            LimitKind::OutputSpeed => "rpm",
            LimitKind::ContactFatigue | LimitKind::Findings => "",
        }
    }
}

/// One limit and how the machine stands to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    pub kind: LimitKind,
    /// Which part, where there are several.
    pub place: Option<String>,
    /// What was found and what is allowed, in the unit of the kind.
    pub value: f64,
    pub allowed: f64,
    /// Hours for which it is kept; `None` if it is for as long as was computed.
    pub hours: Option<f64>,
    /// Exceeded only before contacts have worn in: that does not end the life.
    pub transient: bool,
}

/// The verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct LifeVerdict {
    /// In the order of the kinds.
    pub limits: Vec<Limit>,
    pub service_h: f64,
    /// How far the limit of lost motion was looked for.
    pub searched_h: f64,
}

/// Contacts are worn in by this share of the service life at the latest: what is exceeded only before is
/// transient.
const WORN_IN: f64 = 0.2;
/// A limit reached within this part beyond the service life is worth a warning: wear coefficients and rating
/// lives are not known better.
const NARROW: f64 = 1.2;
/// Hertz pressure of rollers at which the permanent dent is a ten-thousandth of their diameter (ISO 76).
pub(super) const STATIC_PRESSURE: f64 = 4000.0;

/// What the verdict is about.
pub(super) struct Judged<'a> {
    pub machine: &'a Machine,
    pub prediction: &'a Prediction,
    pub bearings: &'a BearingLives,
    pub findings: &'a [Finding],
    /// Largest pressure in Pa at the emergency torque, new and worn, where the design names one.
    pub emergency_pressure: Option<f64>,
}

impl Judged<'_> {
    pub(super) fn verdict(&self) -> LifeVerdict {
        let service_h = self.machine.limits.service_life / HOUR;
        let mut limits = vec![self.lost_motion(), self.contact_pressure(service_h)];
        limits.extend(self.bearing_life(service_h));
        limits.extend(self.of_the_maker(service_h));
        limits.extend(self.runs_away());
        limits.extend(errors(self.findings));
        LifeVerdict { limits, service_h, searched_h: self.prediction.searched_hours }
    }

    fn lost_motion(&self) -> Limit {
        Limit {
            kind: LimitKind::LostMotion,
            place: None,
            value: self.last().lost_motion.arcmin(),
            allowed: self.machine.limits.lost_motion / ARCMIN,
            hours: self.prediction.hours_to_limit,
            transient: false,
        }
    }

    fn last(&self) -> &LifePoint {
        // A prediction has the new machine at least.
        &self.prediction.points[self.prediction.points.len() - 1]
    }

    fn history(&self, value: impl Fn(&LifePoint) -> f64) -> Vec<(f64, f64)> {
        self.prediction.points.iter().map(|point| (point.hours(), value(point))).collect()
    }

    /// Of the points of which it is known.
    fn free_travel(&self) -> Vec<(f64, f64)> {
        let points = self.prediction.points.iter();
        points.filter_map(|point| Some((point.hours(), point.travel?.free_travel.arcmin()))).collect()
    }

    fn contact_pressure(&self, service_h: f64) -> Limit {
        let history = self.history(|point| point.accuracy.max_pressure / MPA);
        let allowed = self.machine.limits.contact_pressure / MPA;
        Limit { kind: LimitKind::ContactPressure, ..worn_in(&history, allowed, service_h) }
    }

    fn bearing_life(&self, service_h: f64) -> Option<Limit> {
        let worst = self.bearings.worst()?;
        Some(Limit {
            kind: LimitKind::BearingLife,
            place: Some(worst.name.clone()),
            value: worst.life_h,
            allowed: service_h,
            hours: Some(worst.life_h),
            transient: false,
        })
    }

    /// What a design may set beyond the limits that every design has.
    fn of_the_maker(&self, service_h: f64) -> Vec<Limit> {
        let limits = &self.machine.limits;
        let over_life = |kind: LimitKind, allowed: Option<f64>, history: Vec<(f64, f64)>| {
            allowed.map(|allowed| Limit {
                kind,
                place: None,
                value: history.iter().map(|(_, value)| *value).fold(0.0, f64::max),
                allowed,
                hours: crate::life::crossing(&history, allowed),
                transient: false,
            })
        };
        let at_once = |kind: LimitKind, allowed: Option<f64>, value: f64| {
            allowed.map(|allowed| Limit {
                kind,
                place: None,
                value,
                allowed,
                hours: (value > allowed).then_some(0.0),
                transient: false,
            })
        };
        let kinematics = self.machine.kinematics();
        let duty = &self.machine.duty;
        let torque = duty.iter().map(|row| row.torque.abs()).fold(0.0, f64::max);
        let speed =
            duty.iter().map(|row| (kinematics.speeds(row.input_speed).0 / RPM).abs()).fold(0.0, f64::max);
        let fatigue = limits.contact_endurance.map(|endurance| {
            let history = self.history(|point| point.accuracy.max_pressure);
            let (value, hours) =
                fatigue(self.machine, &history, endurance, self.prediction.searched_hours.max(service_h));
            let kind = LimitKind::ContactFatigue;
            Limit { kind, place: None, value, allowed: 1.0, hours, transient: false }
        });
        let catalogue = limits.catalogue_life.and_then(|life| {
            let hours = catalogue_life_at_duty(self.machine, life / HOUR)?;
            Some(Limit {
                kind: LimitKind::CatalogueLife,
                place: None,
                value: hours,
                allowed: service_h,
                hours: Some(hours),
                transient: false,
            })
        });
        [
            over_life(
                LimitKind::TransmissionError,
                limits.transmission_error.map(|limit| limit / ARCMIN),
                self.history(|point| point.accuracy.loaded_peak_to_peak.arcmin()),
            ),
            over_life(LimitKind::Backlash, limits.backlash.map(|limit| limit / ARCMIN), self.free_travel()),
            at_once(LimitKind::StartStopTorque, limits.start_stop_torque, torque),
            self.emergency_pressure.and_then(|pressure| {
                at_once(LimitKind::EmergencyTorque, Some(STATIC_PRESSURE), pressure / MPA)
            }),
            at_once(LimitKind::OutputSpeed, limits.output_speed.map(|limit| limit / RPM), speed),
            catalogue,
            fatigue,
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Wear that has left a machine past any use within the service life.
    fn runs_away(&self) -> Option<Limit> {
        self.prediction.runs_away.map(|end| Limit {
            kind: LimitKind::Wear,
            place: None,
            value: end.depth / UM,
            allowed: depth_past_use(self.machine) / UM,
            hours: Some(end.hours),
            transient: false,
        })
    }
}

/// Errors of the checks. How long the pressure stays below its limit is a limit of its own, so what the checks say of
/// the new machine's is not counted again.
fn errors(findings: &[Finding]) -> Option<Limit> {
    let errors: Vec<&str> = findings
        .iter()
        .filter(|finding| finding.severity == Severity::Error && finding.code != CONTACT_PRESSURE)
        .map(|finding| finding.code)
        .collect();
    (!errors.is_empty()).then(|| Limit {
        kind: LimitKind::Findings,
        place: Some(errors.join(", ")),
        value: errors.len() as f64,
        allowed: 0.0,
        hours: Some(0.0),
        transient: false,
    })
}

/// A value over hours against what is allowed: when it is exceeded for good, and whether it was before
/// contacts have worn in only.
fn worn_in(history: &[(f64, f64)], allowed: f64, service_h: f64) -> Limit {
    let value = history.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    let last_above = history.iter().rposition(|(_, value)| *value > allowed);
    let transient = last_above.is_some_and(|last| {
        last + 1 < history.len()
            && history[last].0 <= WORN_IN * service_h
            && history[..=last].iter().all(|(_, value)| *value > allowed)
    });
    let hours = if transient { None } else { crate::life::crossing(history, allowed.next_up()) };
    Limit { kind: LimitKind::ContactPressure, place: None, value, allowed, hours, transient }
}

impl Limit {
    /// Whether it is kept for the planned hours.
    pub fn is_kept(&self, service_h: f64) -> bool {
        self.hours.is_none_or(|hours| hours >= service_h * (1.0 - 1e-9))
    }

    /// What happens to it, as the beginning of a sentence.
    pub fn sentence(&self) -> String {
        let hours = self.hours.unwrap_or(f64::INFINITY);
        let (value, allowed) = (significant(self.value, 3), compact(self.allowed, 4));
        let unit = self.kind.unit();
        match self.kind {
            LimitKind::LostMotion => format!("Lost motion reaches {allowed} arcmin after {hours:.0} h"),
            LimitKind::ContactPressure if hours <= 0.0 => {
                format!(
                    "Contact pressure is above {allowed} MPa from the start, {} MPa",
                    significant(self.value, 4)
                )
            }
            LimitKind::ContactPressure => {
                format!("Contact pressure exceeds {allowed} MPa after {hours:.0} h")
            }
            LimitKind::BearingLife => {
                format!("The bearing “{}” lasts {hours:.0} h (L10)", self.place.as_deref().unwrap_or(""))
            }
            LimitKind::TransmissionError => {
                format!("Transmission error reaches {allowed} arcmin peak to peak after {hours:.0} h")
            }
            LimitKind::Backlash => format!("Backlash reaches {allowed} arcmin after {hours:.0} h"),
            LimitKind::StartStopTorque => {
                format!("The duty asks for {value} {unit}, more than the {allowed} {unit} of start and stop")
            }
            LimitKind::EmergencyTorque => {
                format!(
                    "An emergency stop presses flanks and pins with {value} {unit}, {allowed} {unit} allowed"
                )
            }
            LimitKind::OutputSpeed => {
                format!("The duty turns the output at {value} {unit}, {allowed} {unit} allowed")
            }
            LimitKind::CatalogueLife => format!("The catalogue's life at this duty ends after {hours:.0} h"),
            LimitKind::Wear => {
                format!("Wear runs away: the machine is past any use, {value} µm deep, after {hours:.1} h")
            }
            LimitKind::ContactFatigue => {
                format!("Flanks and pins are tired after {hours:.0} h (damage {value} by the end)")
            }
            LimitKind::Findings => {
                format!("The design has error findings: {}", self.place.as_deref().unwrap_or(""))
            }
        }
    }

    fn value(&self) -> Value {
        Value::Record(vec![
            ("limit", self.kind.key().into()),
            ("where", self.place.clone().into()),
            ("value", self.value.into()),
            ("allowed", self.allowed.into()),
            ("unit", self.kind.unit().into()),
            ("hours", self.hours.into()),
            ("transient", self.transient.into()),
        ])
    }
}

impl LifeVerdict {
    /// Whether every limit is kept for the planned hours.
    pub fn ok(&self) -> bool {
        self.limits.iter().all(|limit| limit.is_kept(self.service_h))
    }

    /// The limit that ends the life first; `None` if none does within what was computed.
    pub fn limited_by(&self) -> Option<&Limit> {
        let hours = |limit: &&Limit| limit.hours.unwrap_or(f64::INFINITY);
        self.limits
            .iter()
            .filter(|limit| limit.hours.is_some())
            // Findings come last but speak first.
            .rev()
            .min_by(|a, b| hours(a).total_cmp(&hours(b)))
    }

    /// Hours to the earliest of all limits.
    pub fn hours_to_limit(&self) -> Option<f64> {
        self.limited_by().and_then(|limit| limit.hours)
    }

    pub fn limit(&self, kind: LimitKind) -> Option<&Limit> {
        self.limits.iter().find(|limit| limit.kind == kind)
    }

    pub fn tone(&self) -> Tone {
        match self.hours_to_limit() {
            _ if !self.ok() => Tone::Bad,
            Some(hours) if hours < NARROW * self.service_h => Tone::Caution,
            _ if self.limits.iter().any(|limit| limit.transient) => Tone::Caution,
            _ => Tone::Good,
        }
    }

    /// What ends the life first, in a sentence, and what is not kept beside it.
    pub fn headline(&self) -> String {
        let service = self.service_h;
        let mut text = match self.limited_by() {
            Some(limit) if !limit.is_kept(service) => {
                format!("{}; {service:.0} h are planned.", limit.sentence())
            }
            Some(limit) => {
                let first = limit.kind.name();
                let hours = limit.hours.unwrap_or(service);
                let but = if hours < NARROW * service { ", but only just" } else { "" };
                format!(
                    "Keeps every limit for the planned {service:.0} h{but}; the first to be reached is {first}, \
                     after {hours:.0} h."
                )
            }
            None => format!(
                "Keeps every limit for all {:.0} h computed; {service:.0} h are planned.",
                self.searched_h
            ),
        };
        let first = self.limited_by().map(|limit| limit.kind);
        let others: Vec<String> = self
            .limits
            .iter()
            .filter(|limit| Some(limit.kind) != first && !limit.is_kept(service))
            .map(|limit| limit.sentence())
            .collect();
        if !others.is_empty() {
            text.push_str(&format!(" Also: {}.", others.join("; ")));
        }
        for limit in self.limits.iter().filter(|limit| limit.transient) {
            text.push_str(&format!(
                " {} MPa of contact pressure are above the {} MPa allowed until contacts have worn in.",
                significant(limit.value, 4),
                compact(limit.allowed, 4)
            ));
        }
        text
    }

    /// The limits for a summary.
    pub(super) fn value(&self) -> Value {
        Value::List(self.limits.iter().map(Limit::value).collect())
    }
}

#[cfg(test)]
mod tests;
