//! A reading, or a limit, in one word: `5200h=1.4arcmin`, `lost_motion=2`.

use crate::analyses::AnalysisError;
use crate::analyses::life::LimitKind;
use crate::design::Value;
use crate::units::{ARCMIN, HOUR, UM};
use crate::wear::{Measured, Reading};

const HOW: &str = "write hours and value with its unit: 5200h=1.4arcmin (lost motion as read), \
                   5200h=+0.4arcmin (grown since new), 5200h=12um (depth of the flank)";

/// Words for units with their values in SI; longer words first.
const UNITS: [(&str, bool, f64); 12] = [
    ("arcmin", false, ARCMIN),
    ("arcsec", false, ARCMIN / 60.0),
    ("mrad", false, 1e-3),
    ("deg", false, 60.0 * ARCMIN),
    ("′", false, ARCMIN),
    ("''", false, ARCMIN / 60.0),
    ("'", false, ARCMIN),
    ("″", false, ARCMIN / 60.0),
    ("\"", false, ARCMIN / 60.0),
    ("°", false, 60.0 * ARCMIN),
    ("µm", true, UM),
    ("um", true, UM),
];

/// A number with a decimal point or a decimal comma, as people write it.
fn number(text: &str) -> Option<f64> {
    let text = text.trim().replace(['\u{a0}', '\u{202f}', ' '], "");
    let text = if text.contains('.') { text } else { text.replacen(',', ".", 1) };
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

/// Reads `HOURS=VALUE UNIT` of this machine; a sign in front of the value makes it an increase since new.
///
/// # Errors
/// Refuses text that cannot be read or is no measurement.
pub(super) fn reading(text: &str, machine: usize) -> Result<Reading, AnalysisError> {
    let wrong = |what: &str| AnalysisError::usage(format!("the reading \"{text}\" {what}"), HOW);
    let (hours, value) = text.split_once(['=', ':', '@']).ok_or_else(|| wrong("has no hours"))?;
    let hours = hours.trim().trim_end_matches("hours").trim_end_matches('h');
    let hours = number(hours).ok_or_else(|| wrong("does not begin with hours"))?;
    if !(0.0..=1e7).contains(&hours) {
        return Err(wrong("has hours outside the allowed range 0 to 1e7"));
    }
    let value = value.trim();
    let (digits, is_depth, unit) = UNITS
        .iter()
        .find_map(|(word, is_depth, unit)| Some((value.strip_suffix(word)?, *is_depth, *unit)))
        .or_else(|| Some((value.strip_suffix("μm")?, true, UM)))
        .ok_or_else(|| wrong("has no unit"))?;
    let value = unit * number(digits).ok_or_else(|| wrong("has no number before its unit"))?;
    let since_new = digits.trim_start().starts_with('+');
    let measured = match (is_depth, since_new) {
        (true, _) => Measured::Depth,
        (false, true) => Measured::Increase,
        (false, false) => Measured::LostMotion(machine),
    };
    let believable = if is_depth { 0.0..=1e4 * UM } else { -600.0 * ARCMIN..=600.0 * ARCMIN };
    if !believable.contains(&value) {
        return Err(wrong("is out of range: at most 10 000 µm or ±600 arcmin"));
    }
    if !matches!(measured, Measured::LostMotion(_)) && (hours == 0.0 || value <= 0.0) {
        return Err(wrong("counts from new: it needs hours and more than nothing"));
    }
    Ok(Reading { time: hours * HOUR, measured, value, scale: value })
}

/// Requested limit, and its value if it differs from that of the design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SelectedLimit {
    pub kind: LimitKind,
    pub value: Option<f64>,
}

/// Limits whose end depends on the hours, with the key that sets their value.
const LIMITS: [(LimitKind, &str); 7] = [
    (LimitKind::LostMotion, "limits.lost_motion_arcmin"),
    (LimitKind::ContactPressure, "limits.contact_pressure_mpa"),
    (LimitKind::TransmissionError, "limits.transmission_error_arcmin"),
    (LimitKind::Backlash, "limits.backlash_arcmin"),
    (LimitKind::ContactFatigue, "limits.contact_endurance_mpa"),
    (LimitKind::CatalogueLife, "limits.catalogue_life_h"),
    (LimitKind::BearingLife, ""),
];

/// Reads `NAME` or `NAME=VALUE`, the value in the unit of the design's key.
///
/// # Errors
/// An unknown name, an invalid value, or a value for a limit that has none.
pub(super) fn limit(text: &str) -> Result<SelectedLimit, AnalysisError> {
    let (name, value) = text.split_once('=').map_or((text, None), |(name, value)| (name, Some(value)));
    let plain = |name: &str| name.trim().to_lowercase().replace(['-', ' '], "_");
    let names = || LIMITS.map(|(kind, _)| kind.key()).join(", ");
    let found = LIMITS.iter().find(|(kind, key)| {
        let stem = key.trim_start_matches("limits.");
        plain(name) == kind.key() || (!stem.is_empty() && plain(name).trim_start_matches("limits.") == stem)
    });
    let (kind, key) = found.ok_or_else(|| {
        AnalysisError::usage(
            format!("no limit is called \"{}\"", name.trim()),
            format!("there are {}", names()),
        )
    })?;
    let value = value
        .map(|value| {
            let bare = value.trim().trim_end_matches(kind.unit()).trim_end_matches(['\'', '′']);
            let number = number(bare).filter(|number| *number > 0.0 && !key.is_empty());
            number.ok_or_else(|| {
                let help = match key.is_empty() {
                    true => "its rating life follows from the design: leave out the value",
                    false => "write a number in the unit of the design's key, such as lost_motion=2",
                };
                AnalysisError::usage(
                    format!("\"{}\" is not a value of the limit {}", value.trim(), kind.key()),
                    help,
                )
            })
        })
        .transpose()?;
    Ok(SelectedLimit { kind: *kind, value })
}

impl SelectedLimit {
    /// The key of the design for its value, if another value is requested.
    pub fn change(&self) -> Option<(&'static str, Value)> {
        let (_, key) = LIMITS.iter().find(|(kind, _)| *kind == self.kind)?;
        Some((key, Value::Number(self.value?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every way of writing the same reading, and invalid ones.
    #[test]
    fn readings_are_parsed_as_written() {
        let same = [
            "5200h=1.4arcmin",
            "5200=1.4'",
            "5200 h = 1,4 arcmin",
            "5200h=84arcsec",
            "5 200h: 84″",
            "5200h=1.4′",
        ];
        for text in same {
            let read = reading(text, 3).unwrap();
            assert!(
                (read.time / HOUR - 5200.0).abs() < 1e-9 && read.measured == Measured::LostMotion(3),
                "{text}"
            );
            assert!((read.value / ARCMIN - 1.4).abs() < 1e-12, "{text}");
        }
        assert_eq!(reading("600h=+10.64arcsec", 0).unwrap().measured, Measured::Increase);
        let depth = reading("5200h=12µm", 0).unwrap();
        assert!(depth.measured == Measured::Depth && (depth.value / UM - 12.0).abs() < 1e-12);
        for (text, said) in [
            ("1.4arcmin", "has no hours"),
            ("xh=1.4arcmin", "does not begin with hours"),
            ("5200h=1.4", "has no unit"),
            ("5200h=arcmin", "has no number"),
            ("-3h=1.4arcmin", "outside the allowed range 0 to 1e7"),
            ("1e300h=1.4arcmin", "outside the allowed range 0 to 1e7"),
            ("5200h=1e9arcmin", "out of range"),
            ("0h=+0.2arcmin", "counts from new"),
            ("5200h=nanarcmin", "has no number"),
        ] {
            let message = reading(text, 0).unwrap_err().to_string();
            assert!(message.contains(said), "{text}: {message}");
        }
    }

    #[test]
    fn a_limit_is_named_and_may_be_set() {
        let selected = limit("lost_motion=2").unwrap();
        assert_eq!((selected.kind, selected.value), (LimitKind::LostMotion, Some(2.0)));
        let design = crate::templates::design("tao2024").unwrap();
        let set = design.with_all(selected.change()).unwrap().machine().limits.lost_motion;
        assert!((set / ARCMIN - 2.0).abs() < 1e-12);
        for text in [
            "lost-motion=2arcmin",
            "lost_motion_arcmin = 2",
            "limits.lost_motion_arcmin=2′",
            "Lost motion=2,0",
        ] {
            assert_eq!(limit(text).unwrap(), selected, "{text}");
        }
        assert_eq!(limit("bearing_life").unwrap().value, None);
        assert!(limit("bearing_life=3").is_err() && limit("lost_motion=x").is_err());
        assert!(limit("lostmotion").unwrap_err().help().unwrap().contains("lost_motion, contact_pressure"));
    }
}
