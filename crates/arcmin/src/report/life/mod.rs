//! The page of `arcmin life`: accuracy against running hours, with the figures of Tao2024 beside it.
//!
//! [`LifePage`] lends the results; what is not computed yet is left out of it and then out of the page.
//! All numbers here are in the trade units that their names carry.

mod accuracy;
mod flank;
mod load;
mod simulation;
mod verdict;
mod wear;

#[cfg(test)]
mod tests;

use crate::checks::{Finding, Severity};
use crate::dynamics::StartSpread;
use crate::geometry::Relief;
use crate::load::{Cycle, FlankForce, PinLoad};
use crate::machine::Machine;
use crate::units::{ARCMIN, HOUR};

use super::{
    Block, Page, Provenance, Section,
};

/// One row of accuracy over life, the columns of `life.csv`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LifeRow {
    pub hours: f64,
    pub max_depth_um: f64,
    /// One-sided, at the output, input locked, no load.
    pub play_arcmin: f64,
    pub te_no_load_arcmin: Option<f64>,
    pub te_loaded_arcmin: f64,
    pub max_force_n: f64,
    pub max_pressure_mpa: f64,
    pub loaded_pairs: f64,
    pub lost_motion_arcmin: Option<f64>,
    /// Of the machine with its bearings, where they are modelled beside contacts with ideal joints.
    pub machine_lost_motion_arcmin: Option<f64>,
    pub ste_rigid: Option<MeanAndMax>,
    pub dte_rigid: Option<MeanAndMax>,
    pub ste_flexible: Option<MeanAndMax>,
    pub dte_flexible: Option<MeanAndMax>,
}

/// Mean and maximum of |TE| over the steady part of a simulated run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanAndMax {
    pub mean_arcmin: f64,
    pub max_arcmin: f64,
}

/// The worn flank at one time, and the loads it then carries at rated torque.
#[derive(Debug, Clone, Copy)]
pub struct WornFlank<'a> {
    pub hours: f64,
    pub flank: &'a Relief,
    /// Over one pin pitch.
    pub cycle: &'a Cycle,
    /// Forces by meshing angle, of all pins alike or their mean, and the largest.
    pub forces: &'a [FlankForce],
    pub peaks: &'a [FlankForce],
    /// What every pin bears, where they do not bear the same.
    pub pins: &'a [PinLoad],
}

/// One simulated run for a time-series figure; equal lengths.
#[derive(Debug, Clone, Copy)]
pub struct RunTrace<'a> {
    pub wear_um: f64,
    pub time_s: &'a [f64],
    pub input_speed_deg_s: &'a [f64],
    pub output_speed_deg_s: &'a [f64],
    pub load_n_m: &'a [f64],
    pub te_arcmin: &'a [f64],
    /// Start of the steady part, from which the statistics are taken.
    pub steady_from_s: f64,
    pub mean_abs_arcmin: f64,
    pub max_abs_arcmin: f64,
}

/// Results of a life computation, lent for rendering.
#[derive(Debug, Clone)]
pub struct LifePage<'a> {
    pub machine: &'a Machine,
    pub provenance: Provenance,
    pub design_name: &'a str,
    pub design_text: &'a str,
    /// Whether the rows of the prediction are of the contacts with ideal joints; else of the machine with its
    /// bearings.
    pub contacts_alone: bool,
    /// The manufacturing errors that the prediction has, in a sentence.
    pub errors: Option<String>,
    /// The coupled prediction, in the order of hours; the first row is the new machine.
    pub prediction: &'a [LifeRow],
    /// Flank and loads at some of these hours, the first new, the last at the end of the service life.
    pub flanks: &'a [WornFlank<'a>],
    /// Until the lost motion of the prediction reaches its limit; `None` if that lies beyond what was
    /// computed.
    pub hours_to_limit: Option<f64>,
    /// How far the limit was looked for.
    pub searched_hours: f64,
    pub prediction_coefficient_per_pa: f64,
    /// The paper's study: uniform depths 0, 10, …, 60 µm.
    pub study: &'a [LifeRow],
    pub study_coefficient_per_pa: f64,
    pub ste_rigid_run: Option<RunTrace<'a>>,
    pub dte_rigid_run: Option<RunTrace<'a>>,
    pub ste_flexible_run: Option<RunTrace<'a>>,
    pub dte_flexible_run: Option<RunTrace<'a>>,
    /// How the static runs depend on where in the play they start, at the points of the study; empty if not
    /// asked for.
    pub ste_starts: Vec<Option<&'a StartSpread>>,
    /// Verdicts on the design; those that are mere facts are not shown.
    pub findings: &'a [Finding],
    /// What the user can change, best first; a default sentence is written when empty.
    pub advice: Vec<String>,
    /// Further sections between the simulation and the design as used: test bench, flexible disc.
    pub more: Vec<Section>,
}

impl LifePage<'_> {
    /// The page, ready to be rendered.
    pub fn page(&self) -> Page {
        let name = &self.machine.name;
        let mut sections =
            vec![Section::new("mechanism", "Mechanism and contact forces", self.mechanism_blocks())];
        sections.push(Section::new("accuracy", "Accuracy over life", accuracy::blocks(self)));
        sections.push(Section::new("flank", "Tooth flank", flank::blocks(self)));
        sections.push(Section::new("load", "Load sharing", load::blocks(self)));
        sections.push(Section::new("wear", "Wear", wear::blocks(self)));
        let simulation = simulation::blocks(self);
        if !simulation.is_empty() {
            sections.push(Section::new("simulation", "Simulated transmission error", simulation));
        }
        sections.extend(self.more.iter().cloned());
        if !self.findings.is_empty() {
            let block = match crate::checks::worst(self.findings) {
                Severity::Info => {
                    Block::Text(format!("All {} checks of the design are passed.", self.findings.len()))
                }
                _ => super::findings_table(self.findings),
            };
            sections.push(Section::new("findings", "Findings on the design", vec![block]));
        }
        sections.push(Section::new(
            "design",
            "Design as used",
            vec![Block::Code { title: self.design_name.to_owned(), text: self.design_text.to_owned() }],
        ));
        sections.push(Section::new(
            "literature",
            "Literature",
            vec![Block::References(super::references_to(&["Tao2024", "Archard1953", "Johnson1985", "Harris2006"]))],
        ));
        Page {
            title: name.clone(),
            subtitle: format!("Accuracy over {} h of service", super::compact(self.service_hours(), 4)),
            provenance: self.provenance.clone(),
            verdict: verdict::verdict(self),
            sections,
        }
    }

    fn service_hours(&self) -> f64 {
        self.machine.limits.service_life / HOUR
    }

    fn limit_arcmin(&self) -> f64 {
        self.machine.limits.lost_motion / ARCMIN
    }

    /// Sign of the meshing angles that carry the rated torque: positive torque loads the negative ones.
    fn loaded_side(&self) -> f64 {
        if self.machine.rated.torque < 0.0 { 1.0 } else { -1.0 }
    }

    fn mechanism_blocks(&self) -> Vec<Block> {
        let states = match self.flanks {
            [] => Vec::new(),
            [only] => vec![("new".to_owned(), only.cycle)],
            [first, .., last] => {
                vec![("new".to_owned(), first.cycle), (format!("{:.0} h", last.hours), last.cycle)]
            }
        };
        let mut drawing = super::mechanism(self.machine, &states);
        if let Some(errors) = &self.errors {
            drawing.note.push_str(&format!(
                " {errors} They are too small to be drawn; the forces are those of the first pin pitch, repeated, while each pin bears differently (see load sharing)."
            ));
        }
        vec![Block::Mechanism(drawing)]
    }
}
