//! One verdict over all limits of a machine, each with the hours for which it is kept.

use super::band::Band;
use super::undecided::Undecided;
use crate::report::{Tone, capitalised, compact, significant};
use crate::results::Value;

/// Limits that can end a life.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitKind {
    /// Lost motion of the whole machine.
    LostMotion,
    /// Hertz pressure between pin and flank.
    ContactPressure,
    /// Rating life of a bearing at the duty.
    BearingLife,
    /// Transmission error at rated torque, peak to peak.
    TransmissionError,
    /// Travel at no load.
    Backlash,
    /// Largest torque of the duty.
    StartStopTorque,
    /// Hertz pressure at the emergency torque.
    EmergencyTorque,
    /// Largest output speed of the duty.
    OutputSpeed,
    /// Rating life at rated torque and 15 rpm.
    CatalogueLife,
    /// Wear that has run away.
    Wear,
    /// Fatigue of flanks and pins by pressure and passes.
    ContactFatigue,
    /// Error findings of the design.
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

    /// Whether it is computed over the service life only.
    pub(super) fn ends_with_service(self) -> bool {
        matches!(
            self,
            LimitKind::ContactPressure
                | LimitKind::TransmissionError
                | LimitKind::Backlash
                | LimitKind::ContactFatigue
        )
    }

    /// Name for texts.
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

/// One limit with the result of the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// The limit.
    pub kind: LimitKind,
    /// Which part, where there are several.
    pub place: Option<String>,
    /// Value found, in the unit of the kind.
    pub value: f64,
    /// Value allowed, in the unit of the kind.
    pub allowed: f64,
    /// Standard deviation of single values about this one, if they scatter.
    pub scatter: Option<f64>,
    /// Hours for which it is kept; `None` beyond the computed hours.
    pub hours: Option<f64>,
    /// Hours of running-in, if the limit is exceeded only during running-in: this does not end the life.
    pub worn_in_h: Option<f64>,
    /// Range of the hours for the uncertainty of the inputs.
    pub band: Option<Band>,
}

/// The verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct LifeVerdict {
    /// In the order of the kinds.
    pub limits: Vec<Limit>,
    /// Planned hours of service.
    pub service_h: f64,
    /// Hours up to which the limit of lost motion was searched.
    pub searched_h: f64,
    /// Range of the hours to the first of all limits for the uncertainty of the inputs.
    pub band: Option<Band>,
    /// Limits that are kept with only one of rigid and elastic bodies.
    pub undecided: Vec<Undecided>,
}

/// A limit reached within this share beyond the service life gives a warning: wear coefficients and rating lives are
/// not known more exactly.
const NARROW: f64 = 1.2;
/// Hertz pressure of rollers at which the permanent dent is a ten-thousandth of their diameter (ISO 76).
pub(super) const STATIC_PRESSURE: f64 = 4000.0;

/// Hours rounded to two digits: 4885 is 4900.
pub(crate) fn about(hours: f64) -> String {
    let unit = 10_f64.powf((hours.max(1.0).log10().floor() - 1.0).max(0.0));
    format!("{:.0}", (hours / unit).round() * unit)
}

impl Limit {
    /// A limit that is kept over all computed hours.
    pub(super) fn new(kind: LimitKind, value: f64, allowed: f64) -> Limit {
        Limit { kind, place: None, value, allowed, scatter: None, hours: None, worn_in_h: None, band: None }
    }

    pub(super) fn lasting(self, hours: Option<f64>) -> Limit {
        Limit { hours, ..self }
    }

    /// Whether it is kept for the planned hours.
    pub fn is_kept(&self, service_h: f64) -> bool {
        self.hours.is_none_or(|hours| hours >= service_h * (1.0 - 1e-9))
    }

    /// The outcome of the limit, as the beginning of a sentence.
    pub fn sentence(&self) -> String {
        let hours = self.hours_in_words();
        let (value, allowed) = (significant(self.value, 3), compact(self.allowed, 4));
        let unit = self.kind.unit();
        let from_start = self.hours.is_some_and(|hours| hours <= 0.0);
        match self.kind {
            LimitKind::LostMotion | LimitKind::TransmissionError | LimitKind::Backlash if from_start => {
                format!("{} is above {allowed} {unit} from the start", capitalised(self.kind.name()))
            }
            LimitKind::LostMotion => format!("Lost motion reaches {allowed} arcmin after {hours}"),
            LimitKind::ContactPressure if from_start => {
                format!(
                    "Contact pressure is above {allowed} MPa from the start, {} MPa",
                    significant(self.value, 4)
                )
            }
            LimitKind::ContactPressure => {
                format!("Contact pressure exceeds {allowed} MPa after {hours}")
            }
            LimitKind::BearingLife => {
                format!("The bearing “{}” has an L10 of {hours}", self.place.as_deref().unwrap_or(""))
            }
            LimitKind::TransmissionError => {
                format!("Transmission error reaches {allowed} arcmin peak to peak after {hours}")
            }
            LimitKind::Backlash => format!("Backlash reaches {allowed} arcmin after {hours}"),
            LimitKind::StartStopTorque => {
                format!("The duty needs {value} {unit}; {allowed} {unit} are allowed for start and stop")
            }
            LimitKind::EmergencyTorque => {
                format!(
                    "An emergency stop causes {value} {unit} between flanks and pins; {allowed} {unit} are allowed"
                )
            }
            LimitKind::OutputSpeed => {
                format!("The duty turns the output at {value} {unit}; {allowed} {unit} are allowed")
            }
            LimitKind::CatalogueLife => format!("The catalogue life at this duty ends after {hours}"),
            LimitKind::Wear => {
                format!("Wear runs away: the machine is unusable after {hours}, with a depth of {value} µm")
            }
            LimitKind::ContactFatigue => {
                format!("Fatigue of flanks and pins ends the life after {hours} (damage {value} at the end)")
            }
            LimitKind::Findings => {
                format!("The design has error findings: {}", self.place.as_deref().unwrap_or(""))
            }
        }
    }

    /// Its hours with their band: "about 4900 h, 3100 to 7400 h as far as inputs are known".
    fn hours_in_words(&self) -> String {
        let hours = self.hours.map_or_else(|| "more hours than computed".to_owned(), about);
        match &self.band {
            Some(band) if !band.is_point() => format!("about {hours} h ({})", band.words()),
            _ => format!("about {hours} h"),
        }
    }

    /// Whether it is exceeded only during running-in, which does not end the life.
    pub fn is_transient(&self) -> bool {
        self.worn_in_h.is_some()
    }

    fn value(&self) -> Value {
        let band = self.band.as_ref();
        Value::Record(vec![
            ("limit", self.kind.key().into()),
            ("where", self.place.clone().into()),
            ("value", self.value.into()),
            ("allowed", self.allowed.into()),
            ("unit", self.kind.unit().into()),
            ("scatter", self.scatter.into()),
            ("hours", self.hours.into()),
            ("band", band.map_or(Value::Absent, Band::value)),
            ("hangs_on", band.and_then(|band| band.hangs_on.clone()).into()),
            ("transient", self.is_transient().into()),
            ("worn_in_h", self.worn_in_h.into()),
        ])
    }
}

impl LifeVerdict {
    /// Whether every limit is kept for the planned hours, and none is undecided.
    pub fn ok(&self) -> bool {
        self.undecided.is_empty() && self.unkept().next().is_none()
    }

    /// Limits that are not kept, without the undecided ones.
    fn unkept(&self) -> impl Iterator<Item = &Limit> {
        self.limits.iter().filter(|limit| !limit.is_kept(self.service_h) && !self.is_undecided(limit.kind))
    }

    /// Whether rigid and elastic bodies disagree about a limit.
    pub fn is_undecided(&self, kind: LimitKind) -> bool {
        self.undecided.iter().any(|undecided| undecided.kind == kind)
    }

    /// The limit that ends the life first; `None` if none does within the computed hours.
    pub fn limited_by(&self) -> Option<&Limit> {
        let hours = |limit: &&Limit| limit.hours.unwrap_or(f64::INFINITY);
        self.limits
            .iter()
            .filter(|limit| limit.hours.is_some())
            // Findings are last in the list but first in the sentence.
            .rev()
            .min_by(|a, b| hours(a).total_cmp(&hours(b)))
    }

    /// Hours to the earliest of all limits.
    pub fn hours_to_limit(&self) -> Option<f64> {
        self.limited_by().and_then(|limit| limit.hours)
    }

    /// A limit by its kind; of several the first.
    pub fn limit(&self, kind: LimitKind) -> Option<&Limit> {
        self.limits.iter().find(|limit| limit.kind == kind)
    }

    /// Tone of the verdict: bad if a limit is not kept, caution if one is near, undecided or transient.
    pub fn tone(&self) -> Tone {
        match self.hours_to_limit() {
            _ if self.unkept().next().is_some() => Tone::Bad,
            _ if !self.undecided.is_empty() => Tone::Caution,
            Some(hours) if hours < NARROW * self.service_h => Tone::Caution,
            _ if self.limits.iter().any(Limit::is_transient) => Tone::Caution,
            _ => Tone::Good,
        }
    }

    /// The verdict as a sign in front of its sentence.
    pub fn mark(&self) -> &'static str {
        match self.tone() {
            Tone::Bad => "✕",
            Tone::Caution => "▲",
            _ => "✓",
        }
    }

    /// The verdict in a word.
    pub fn word(&self) -> &'static str {
        match (self.ok(), self.unkept().next()) {
            (true, _) => "kept",
            (false, None) => "undecided",
            (false, Some(_)) => "not kept",
        }
    }

    /// A sentence with the limit that ends the life first, other limits that are not kept, and those that are
    /// undecided.
    pub fn headline(&self) -> String {
        let service = self.service_h;
        let mut unkept: Vec<&Limit> = self.unkept().collect();
        // Findings are last in the list but first in the sentence.
        unkept.reverse();
        unkept.sort_by(|a, b| a.hours.unwrap_or(0.0).total_cmp(&b.hours.unwrap_or(0.0)));
        let mut text = match (unkept.split_first(), self.limited_by()) {
            (Some((first, others)), _) => {
                let mut text = format!("{}; {service:.0} h are planned.", first.sentence());
                if !others.is_empty() {
                    let others: Vec<String> = others.iter().map(|limit| limit.sentence()).collect();
                    text.push_str(&format!(" Also: {}.", others.join("; ")));
                }
                text
            }
            (None, _) if !self.undecided.is_empty() => String::new(),
            (None, Some(limit)) => {
                let (first, hours) = (limit.kind.name(), limit.hours.unwrap_or(service));
                let but = if hours < NARROW * service { ", but only just" } else { "" };
                format!(
                    "Keeps every limit for the planned {service:.0} h{but}; the first to be reached is {first}, \
                     after {}.",
                    limit.hours_in_words()
                )
            }
            (None, None) => format!(
                "Keeps every limit for all {} h computed; {service:.0} h are planned.",
                about(self.searched_h)
            ),
        };
        if !self.undecided.is_empty() {
            let undecided: Vec<String> = self.undecided.iter().map(Undecided::words).collect();
            text.push_str(&format!(" Undecided: {}.", undecided.join("; ")));
        }
        for limit in &self.limits {
            let Some(worn_in) = limit.worn_in_h.filter(|_| !self.is_undecided(limit.kind)) else { continue };
            text.push_str(&format!(
                " {} MPa of contact pressure are above the {} MPa allowed until contacts have worn in, after \
                 about {} h.",
                significant(limit.value, 3),
                compact(limit.allowed, 4),
                about(worn_in)
            ));
        }
        if let Some(band) = self.band.as_ref().filter(|band| !band.is_point()) {
            let range = band.words();
            // `Limit::hours_in_words` puts the range of a limit in parentheses.
            if text.contains(&format!("({range})")) {
                text.push_str(
                    " The range of the first limit follows from the uncertainty of the inputs in [unknowns]",
                );
            } else {
                text.push_str(&format!(
                    " With the uncertainty of the inputs in [unknowns] the first limit is reached after {range}"
                ));
            }
            match &band.hangs_on {
                Some(key) => {
                    text.push_str(&format!("; `{key}` has the largest influence: measure it first."))
                }
                None => text.push('.'),
            }
        }
        text.trim_start().to_owned()
    }

    /// The limits for a summary.
    pub(super) fn value(&self) -> Value {
        Value::List(self.limits.iter().map(Limit::value).collect())
    }
}

#[cfg(test)]
mod tests;
