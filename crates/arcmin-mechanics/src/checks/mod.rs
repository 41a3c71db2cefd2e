//! Engineering checks of a design that can be computed: the quantity, its value and limit, the reason, and the
//! remedy.
//!
//! A finding does not prevent a computation. Designs that cannot be computed cause a
//! [`crate::design::DesignError`].

mod duty;
mod flank;
mod mechanism;
pub mod sections;
mod strength;
#[cfg(test)]
mod tests;
mod windows;

pub use flank::{Teeth, rim};
pub use mechanism::{balance, ligament, newton_metres};
pub use strength::CONTACT_PRESSURE;

use crate::design::variation::Variations;
use crate::design::{Design, Unknown};
use crate::machine::Machine;

/// Severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The test is passed, or the finding only states a fact.
    Info,
    /// The design can be built and runs, with a disadvantage.
    Warning,
    /// The design cannot be built or assembled, or it fails.
    Error,
}

impl Severity {
    /// Word for reports and files.
    pub fn word(self) -> &'static str {
        match self {
            Severity::Info => "info",
            Severity::Warning => "warning",
            Severity::Error => "error",
        }
    }
}

/// Verdict of one check.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Stable name of the check.
    pub code: &'static str,
    /// Severity of the verdict.
    pub severity: Severity,
    /// The verdict in one sentence, with its numbers.
    pub message: String,
    /// Value found, in `unit`.
    pub value: f64,
    /// Limit for the value, in `unit`.
    pub limit: f64,
    /// Unit of value and limit for readers; empty for numbers without one.
    pub unit: &'static str,
    /// Reason for the limit.
    pub why: &'static str,
    /// Remedy.
    pub change: &'static str,
}

impl Finding {
    /// A warning that has no value and no limit.
    pub fn warning(code: &'static str, message: String, why: &'static str, change: &'static str) -> Finding {
        Finding { code, severity: Severity::Warning, message, value: 0.0, limit: 0.0, unit: "", why, change }
    }
}

/// Runs all checks, in a fixed order.
pub fn check(machine: &Machine) -> Vec<Finding> {
    [
        flank::check(machine),
        mechanism::check(machine),
        windows::check(machine),
        strength::check(machine),
        duty::check(machine),
    ]
    .concat()
}

/// All checks of the machine, and those of its file: keys without a value, for which defaults are used.
pub fn check_design(design: &Design) -> Vec<Finding> {
    let mut findings = check(&design.machine());
    findings.push(defaults(&design.defaulted()));
    findings.extend(stale_masses(design));
    findings.extend(unknowns(&design.unknowns(), &design.unknowns));
    findings
}

/// Keys for which the defaults are used.
pub fn defaults(keys: &[String]) -> Finding {
    Finding {
        code: "defaults",
        severity: Severity::Info,
        message: match keys.len() {
            0 => "every key is given".to_owned(),
            count => format!("{count} keys are left to their defaults: {}", keys.join(", ")),
        },
        value: keys.len() as f64,
        limit: 0.0,
        unit: "",
        why: "a default is an assumption, and results depend on it",
        change: "write the keys with their true values (`arcmin keys` explains each)",
    }
}

/// Rows of [unknowns] that do not fit the design: its value is outside of the range, or the key does not exist.
pub fn unknowns(all: &[Unknown], given: &Variations) -> Option<Finding> {
    let outside = all.iter().filter(|unknown| !unknown.covers_nominal()).map(|unknown| {
        let [low, high] = unknown.distribution.bounds();
        format!("{} is {}, outside of its range from {low} to {high}", unknown.path, unknown.nominal)
    });
    let idle = given
        .0
        .iter()
        .filter(|varied| all.iter().all(|unknown| unknown.path != varied.path))
        .map(|varied| format!("{} has no value that this row could vary", varied.path));
    let list: Vec<String> = outside.chain(idle).collect();
    (!list.is_empty()).then(|| Finding {
        code: "unknowns",
        severity: Severity::Warning,
        message: format!("[unknowns] does not fit the design: {}", list.join("; ")),
        value: list.len() as f64,
        limit: 0.0,
        unit: "",
        why: "a range without the design's own value does not describe this machine",
        change: "correct the range, or remove the row from [unknowns]",
    })
}

/// Given masses that belong to another geometry; `None` for an unchanged design.
fn stale_masses(design: &Design) -> Option<Finding> {
    let stale = design.stale_masses();
    let worst = stale.iter().map(|mass| mass.factor.ln().abs().exp()).reduce(f64::max)?;
    let list: Vec<String> = stale
        .iter()
        .map(|mass| {
            format!("{} = {} (its solid has changed by the factor {:.3})", mass.path, mass.given, mass.factor)
        })
        .collect();
    Some(Finding {
        code: "stale-mass",
        severity: Severity::Warning,
        message: format!("given for another geometry: {}", list.join(", ")),
        value: worst,
        limit: 1.0,
        unit: "",
        why: "a given mass does not change with the geometry; motion is then computed with the mass of the previous geometry",
        change: "remove the key, so that the mass is computed from the solid, or correct it",
    })
}

/// The worst severity among findings.
pub fn worst(findings: &[Finding]) -> Severity {
    findings.iter().map(|finding| finding.severity).max().unwrap_or(Severity::Info)
}

/// `bad` if the value exceeds the limit, otherwise [`Severity::Info`].
pub fn severity_if(broken: bool, bad: Severity) -> Severity {
    if broken { bad } else { Severity::Info }
}
