//! The page of `arcmin life`: accuracy against running hours, with the figures of Tao2024 beside it.
//!
//! [`LifePage`] lends the results; what is not computed yet is left out of it and then out of the page.
//! All numbers here are in the trade units that their names carry.

mod accuracy;
mod flank;
mod literature;
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
use crate::units::{ARCMIN, DEG, HOUR};

use super::{
    Block, Column, CrankshaftDrawing, ForceState, GearStageDrawing, Hole, Mechanism, Page, Provenance,
    Section, Table,
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
                _ => findings_table(self.findings),
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
            vec![Block::References(literature::references())],
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
        let mut drawing = mechanism(self.machine, &states);
        if let Some(errors) = &self.errors {
            drawing.note.push_str(&format!(
                " {errors} They are too small to be drawn; the forces are those of the first pin pitch, repeated, while each pin bears differently (see load sharing)."
            ));
        }
        vec![Block::Mechanism(drawing)]
    }
}

/// The drawing of a machine with the forces of load-sharing cycles; positions of each cycle must be
/// equidistant over one pin pitch.
pub fn mechanism(machine: &Machine, states: &[(String, &Cycle)]) -> Mechanism {
    /// Points per lobe: chords stay within 2 µm of the flank of the sizes in use.
    const LOBE_POINTS: usize = 60;
    const MM_PER_M: f64 = 1e3;
    let profile = machine.profile();
    let kinematics = machine.kinematics();
    let lobe = std::f64::consts::TAU / profile.lobe_count() as f64;
    let lobe_mm = (0..LOBE_POINTS)
        .map(|i| {
            let point = profile.flank_point(lobe * i as f64 / LOBE_POINTS as f64);
            [point.x * MM_PER_M, point.y * MM_PER_M]
        })
        .collect();
    let places: Vec<f64> = (0..machine.crankshafts.count)
        .map(|index| {
            crate::machine::Kinematics::crankshaft_angle(
                machine.crankshafts.first_angle,
                index,
                machine.crankshafts.count,
            )
        })
        .collect();
    let circle_radius = machine.gear_stage.centre_distance();
    let hole = |radius: f64, at_radius: f64, angle: f64| Hole {
        x_mm: at_radius * angle.cos() * MM_PER_M,
        y_mm: at_radius * angle.sin() * MM_PER_M,
        radius_mm: radius * MM_PER_M,
    };
    let mut holes: Vec<Hole> =
        places.iter().map(|angle| hole(machine.disc.crank_bore_radius, circle_radius, *angle)).collect();
    holes.push(hole(machine.disc.centre_hole_radius, 0.0, 0.0));
    holes.extend(
        machine.disc.holes.iter().map(|bore| hole(bore.radius, bore.centre_radius, bore.centre_angle)),
    );
    let ring = machine.ring.pin_circle_radius;
    let forces = |cycle: &Cycle| {
        (0..kinematics.phases.len())
            .map(|disc| {
                let row = |contacts: &Vec<crate::contact::PinContact>| {
                    let mut row = vec![0.0; machine.ring.pin_count];
                    for contact in contacts {
                        row[contact.pin] = contact.force;
                    }
                    row
                };
                cycle.positions.iter().filter_map(|position| position.discs.get(disc)).map(row).collect()
            })
            .collect()
    };
    let eccentric_radius = machine.disc.crank_bore_radius
        - machine.bearings.turning_arm.roller_diameter
        - 0.5 * machine.bearings.turning_arm.clearance;
    Mechanism {
        title: format!("{}, seen from the output side", machine.name),
        note: format!(
            "To scale. Contact forces of the load-sharing equilibrium at {} N·m; the arrows act on the disc, their lines of action meet in the \
             pitch point. Elastic approach and wear (micrometres) do not show at this scale. The outer radius of the housing is not part of \
             the design and drawn for the eye.",
            super::compact(machine.rated.torque, 4)
        ),
        pin_circle_radius_mm: ring * MM_PER_M,
        pin_radius_mm: machine.ring.pin_radius * MM_PER_M,
        pin_count: machine.ring.pin_count,
        lobe_count: profile.lobe_count(),
        eccentricity_mm: machine.crankshafts.eccentricity * MM_PER_M,
        housing_outer_radius_mm: (1.08 * ring + 2.0 * machine.ring.pin_radius) * MM_PER_M,
        lobe_mm,
        eccentric_phase_deg: kinematics.phases.iter().map(|phase| phase / DEG).collect(),
        holes,
        crankshafts: CrankshaftDrawing {
            circle_radius_mm: circle_radius * MM_PER_M,
            place_deg: places.iter().map(|angle| angle / DEG).collect(),
            shaft_radius_mm: 0.5 * machine.crankshafts.shaft_diameter * MM_PER_M,
            // A design may leave the bearing out; the eccentric is then drawn as the bore.
            eccentric_radius_mm: if eccentric_radius > 0.0 {
                eccentric_radius
            } else {
                machine.disc.crank_bore_radius
            } * MM_PER_M,
        },
        gear_stage: GearStageDrawing {
            sun_teeth: machine.gear_stage.sun_teeth,
            planet_teeth: machine.gear_stage.planet_teeth,
            sun_pitch_radius_mm: machine.gear_stage.sun_pitch_radius() * MM_PER_M,
            planet_pitch_radius_mm: machine.gear_stage.planet_pitch_radius() * MM_PER_M,
        },
        input_speed_rpm: machine.rated.input_speed / crate::units::RPM,
        states: states
            .iter()
            .map(|(label, cycle)| ForceState { label: label.clone(), force_n: forces(cycle) })
            .collect(),
    }
}

/// Table of the warnings and errors, worst first.
fn findings_table(findings: &[Finding]) -> Block {
    let mut shown: Vec<&Finding> =
        findings.iter().filter(|finding| finding.severity > Severity::Info).collect();
    shown.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let rows = shown
        .iter()
        .map(|finding| {
            let amount = |value: f64| {
                super::compact(value, 4) + if finding.unit.is_empty() { "" } else { " " } + finding.unit
            };
            vec![
                finding.severity.word().to_owned(),
                format!("`{}`", finding.code),
                format!("{} {}", finding.message, finding.why),
                amount(finding.value),
                amount(finding.limit),
                finding.change.to_owned(),
            ]
        })
        .collect();
    Block::Table(Table {
        title: "Warnings and errors".into(),
        columns: vec![
            Column::text("Verdict"),
            Column::text("Code"),
            Column::text("What was found, why it matters"),
            Column::number("Value", ""),
            Column::number("Limit", ""),
            Column::text("What to change"),
        ],
        rows,
        note: format!("{} checks were made; the others are passed.", findings.len()),
    })
}
