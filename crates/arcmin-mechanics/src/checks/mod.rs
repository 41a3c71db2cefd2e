//! Engineering verdicts on a design that can be computed: what is tested, with value and limit, why it
//! matters, what to change.
//!
//! A finding never stops a solver. What cannot be computed at all is a [`crate::design::DesignError`].

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

/// How serious a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The test is passed, or the finding only states a fact.
    Info,
    /// It can be built and runs, but worse than it could.
    Warning,
    /// It cannot be built, cannot be assembled, or fails.
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
    /// Gravity of the verdict.
    pub severity: Severity,
    /// The verdict in one sentence, with its numbers.
    pub message: String,
    /// Value found, in `unit`.
    pub value: f64,
    /// Limit that the value is held against, in `unit`.
    pub limit: f64,
    /// Unit of value and limit as a reader sees it; empty for numbers without one.
    pub unit: &'static str,
    /// Why it matters.
    pub why: &'static str,
    /// Remedy.
    pub change: &'static str,
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

/// All checks of the machine, and what only the file can tell: which inputs were left to their defaults.
pub fn check_design(design: &Design) -> Vec<Finding> {
    let mut findings = check(&design.machine());
    findings.push(defaults(&design.defaulted()));
    findings.extend(stale_masses(design));
    findings.extend(unknowns(&design.unknowns(), &design.unknowns));
    findings
}

/// Keys that a file leaves to their defaults.
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
        why: "a default is an assumption; results are no better than the inputs nobody has looked at",
        change: "write the keys with their true values (`arcmin keys` explains each)",
    }
}

/// Unknowns that do not fit the design any more: its value lies outside of their range, or is not there.
pub fn unknowns(all: &[Unknown], given: &Variations) -> Option<Finding> {
    let outside = all.iter().filter(|unknown| !unknown.covers_nominal()).map(|unknown| {
        let [low, high] = unknown.distribution.bounds();
        format!("{} is {}, said to lie from {low} to {high}", unknown.path, unknown.nominal)
    });
    let idle = given
        .0
        .iter()
        .filter(|varied| all.iter().all(|unknown| unknown.path != varied.path))
        .map(|varied| format!("{} has no value here that could vary so", varied.path));
    let list: Vec<String> = outside.chain(idle).collect();
    (!list.is_empty()).then(|| Finding {
        code: "unknowns",
        severity: Severity::Warning,
        message: format!("[unknowns] does not fit the design: {}", list.join("; ")),
        value: list.len() as f64,
        limit: 0.0,
        unit: "",
        why: "a band that leaves out the design's own value says nothing about this machine",
        change: "correct the range, or take the row out of [unknowns]",
    })
}

/// Masses given for another geometry; nothing for a design as it stands in its file.
fn stale_masses(design: &Design) -> Option<Finding> {
    let stale = design.stale_masses();
    let worst = stale.iter().map(|mass| mass.factor.ln().abs().exp()).reduce(f64::max)?;
    let list: Vec<String> = stale
        .iter()
        .map(|mass| {
            format!("{} = {} (its solid is {:.3} times what it was)", mass.path, mass.given, mass.factor)
        })
        .collect();
    Some(Finding {
        code: "stale-mass",
        severity: Severity::Warning,
        message: format!("given for another geometry: {}", list.join(", ")),
        value: worst,
        limit: 1.0,
        unit: "",
        why: "a mass that a design gives stays as it is when the geometry changes; motion is then computed with the old one",
        change: "leave the key out, so that it follows from the solid, or change it along",
    })
}

/// The worst severity among findings.
pub fn worst(findings: &[Finding]) -> Severity {
    findings.iter().map(|finding| finding.severity).max().unwrap_or(Severity::Info)
}

/// `bad` if the value breaks the limit, information otherwise.
pub fn severity_if(broken: bool, bad: Severity) -> Severity {
    if broken { bad } else { Severity::Info }
}
