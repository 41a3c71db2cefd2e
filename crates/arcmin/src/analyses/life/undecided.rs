//! Limits that are kept with only one of rigid and elastic bodies.

use super::verdict::{Limit, LimitKind, about};
use crate::report::significant;
use crate::results::Value;

/// A limit that is kept with only one of rigid and elastic bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Undecided {
    /// The limit.
    pub kind: LimitKind,
    /// The limit with rigid bodies.
    pub rigid: Limit,
    /// The limit with elastic bodies.
    pub elastic: Limit,
}

/// The limits that are kept in only one of two judgements of the same machine.
pub(super) fn undecided(rigid: &[Limit], elastic: &[Limit], service_h: f64) -> Vec<Undecided> {
    let other = |limit: &Limit| elastic.iter().find(|other| other.kind == limit.kind);
    rigid
        .iter()
        .filter_map(|limit| {
            let other = other(limit)?;
            (limit.is_kept(service_h) != other.is_kept(service_h)).then(|| Undecided {
                kind: limit.kind,
                rigid: limit.clone(),
                elastic: other.clone(),
            })
        })
        .collect()
}

impl Undecided {
    /// Why the bodies matter for this limit.
    pub fn why(&self) -> &'static str {
        match self.kind {
            LimitKind::LostMotion => {
                "elastic bodies deform, also at ±3 % of rated torque; with rigid bodies the machine is stiffer than measured \
                 machines"
            }
            LimitKind::ContactPressure | LimitKind::ContactFatigue | LimitKind::EmergencyTorque => {
                "elastic discs bend between their openings and the root circle; a few pins near the root then carry more; \
                 how much depends on the material left there, and no measurement has confirmed either pressure"
            }
            LimitKind::BearingLife => "elastic bodies share the load differently among bearings",
            _ => "elastic bodies share the load differently among the pins",
        }
    }

    /// "lost motion (8800 h with rigid bodies, 890 h with elastic ones)".
    pub fn words(&self) -> String {
        let of = |limit: &Limit| {
            let lasts = match limit.hours {
                Some(hours) if hours <= 0.0 => "from the start".to_owned(),
                Some(hours) => format!("{} h", about(hours)),
                None => "kept".to_owned(),
            };
            match self.kind.unit() {
                "MPa" => format!("{} MPa, {lasts}", significant(limit.value, 3)),
                _ => lasts,
            }
        };
        let (name, rigid, elastic) = (self.kind.name(), of(&self.rigid), of(&self.elastic));
        format!("{name} ({rigid} with rigid bodies, {elastic} with elastic ones)")
    }

    pub(super) fn value(&self) -> Value {
        Value::Record(vec![
            ("limit", self.kind.key().into()),
            ("allowed", self.rigid.allowed.into()),
            ("unit", self.kind.unit().into()),
            ("rigid_value", self.rigid.value.into()),
            ("rigid_hours", self.rigid.hours.into()),
            ("elastic_value", self.elastic.value.into()),
            ("elastic_hours", self.elastic.hours.into()),
            ("why", self.why().into()),
        ])
    }
}
