//! Manufacturing processes of parts, each with its tolerances and systematic deviations.

use super::field::Choice;
use super::schema::{default_flag, optional, section};
use crate::machine::StageOffsets;
use crate::units::UM;

/// Manufacturing process of a part. In proposed drives it is that of the discs; pins, rollers and bearings are
/// purchased parts of hardened steel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Process {
    /// PLA, printed from molten filament.
    PrintedFdm,
    /// PA12, laser-sintered from powder.
    PrintedSls,
    /// Aluminium 7075-T6, milled.
    Milled,
    /// Hardened 100Cr6, cut by wire.
    WireEdm,
    /// Hardened 100Cr6, ground.
    Ground,
}

impl Choice for Process {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("printed-fdm", "PLA, molten filament"),
        ("printed-sls", "PA12, laser-sintered powder"),
        ("milled", "aluminium 7075-T6"),
        ("wire-edm", "hardened 100Cr6, cut by wire"),
        ("ground", "hardened 100Cr6, ground"),
    ];
    const VALUES: &'static [Process] =
        &[Process::PrintedFdm, Process::PrintedSls, Process::Milled, Process::WireEdm, Process::Ground];
}

section! {
    /// Manufacturing processes of the parts of a single stage. A tolerance missing in `[tolerances]` is that of
    /// the part's process. Systematic deviations are common to all drives: the sizes of drawn drives scatter
    /// about them, and `check` reports their effect. Results of drives without errors use the sizes of this
    /// file.
    pub struct ProcessSection {
        /// Process of the discs: their flanks and holes.
        disc: Option<Process> => optional(0.0, 0.0),
        /// Process of the ring with the seats of its pins.
        ring: Option<Process> => optional(0.0, 0.0),
        /// Process of the eccentrics.
        eccentric: Option<Process> => optional(0.0, 0.0),
        /// Process of the plates with the seats of the output pins.
        output: Option<Process> => optional(0.0, 0.0),
        /// Systematic deviation of the diameter of the output pins' holes; positive: larger. Left out: by the
        /// process of the discs.
        hole_diameter_um: Option<f64> => optional(-2000.0, 2000.0),
        /// Systematic depth of metal missing on all flanks; negative: excess metal. Left out: by the process of the discs.
        flank_um: Option<f64> => optional(-1000.0, 1000.0),
        /// Projection of the first layer of a printed disc from flank and holes (elephant foot). It closes gaps
        /// as if the whole width projected. If the edge is chamfered, give 0 and subtract the chamfer from
        /// `disc.width_mm`. Left out: by the process of the discs.
        elephant_foot_um: Option<f64> => optional(0.0, 1000.0),
        /// Systematic deviation of the radius of the pin circle; positive: larger. Left out: by the process of the ring.
        pin_circle_radius_um: Option<f64> => optional(-1000.0, 1000.0),
        /// Change of the diametral clearance of the eccentric bearings by their seats; negative: they press them. Left
        /// out: 0.
        eccentric_clearance_um: Option<f64> => optional(-1000.0, 1000.0),
        /// Whether drawing or slicer compensate for the systematic deviations, so that the mean sizes of the
        /// parts are those of this file.
        compensated: bool => default_flag(false),
    }

    /// Manufacturing processes of the parts of a drive of two rings, as `[process]` of single stages: discs
    /// with both steps, ring at rest, eccentrics. Systematic deviations are those of the steps in the ring at
    /// rest.
    pub struct TwoRingProcessSection {
        /// Process of the flanks of the discs, the same for both steps.
        disc: Option<Process> => optional(0.0, 0.0),
        /// Process of the ring at rest with the seats of its pins.
        ring: Option<Process> => optional(0.0, 0.0),
        /// Process of the eccentrics.
        eccentric: Option<Process> => optional(0.0, 0.0),
        /// Systematic depth of metal missing on the flanks of the steps in the ring at rest; negative: excess
        /// metal. Left out: by the process of the discs.
        flank_um: Option<f64> => optional(-1000.0, 1000.0),
        /// Projection of the first layer of a printed disc from the flank of the step in the ring at rest
        /// (elephant foot), as if the whole width projected. Left out: by the process of the discs, which are
        /// printed with this step on the bed. Give 0 if the other step is on the bed.
        elephant_foot_um: Option<f64> => optional(0.0, 1000.0),
        /// Systematic deviation of the radius of the pin circle of the ring at rest; positive: larger. Left
        /// out: by the process of the ring.
        pin_circle_radius_um: Option<f64> => optional(-1000.0, 1000.0),
        /// Change of the diametral clearance of the eccentric bearings by their seats; negative: they press them. Left
        /// out: 0.
        eccentric_clearance_um: Option<f64> => optional(-1000.0, 1000.0),
        /// Whether drawing or slicer compensate for the systematic deviations of both steps and rings, so that
        /// the mean sizes of the parts are those of this file.
        compensated: bool => default_flag(false),
    }

    /// Process of the second ring and systematic deviations of the steps in it; the tolerances of these steps
    /// are those of `process.disc`.
    pub struct SecondProcessSection {
        /// Process of the second ring with the seats of its pins.
        ring: Option<Process> => optional(0.0, 0.0),
        /// Systematic depth of metal missing on the flanks of these steps; negative: excess metal. Left out: by
        /// the process of the discs.
        flank_um: Option<f64> => optional(-1000.0, 1000.0),
        /// Projection of the first layer of a printed disc from the flank of this step. Left out: 0, because
        /// the other step is on the bed.
        elephant_foot_um: Option<f64> => optional(0.0, 1000.0),
        /// Systematic deviation of the radius of the second ring's pin circle; positive: larger. Left out: by
        /// the process of the ring.
        pin_circle_radius_um: Option<f64> => optional(-1000.0, 1000.0),
    }
}

/// Processes of the parts of one stage, or of one ring with the steps in it; `None` and 0 for parts that the
/// stage does not have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StageProcess {
    disc: Option<Process>,
    ring: Option<Process>,
    eccentric: Option<Process>,
    output: Option<Process>,
    /// Systematic deviations without compensation.
    pub offsets: StageOffsets,
    /// Whether drawing or slicer take it back.
    pub compensated: bool,
}

/// Part of a stage with a tolerance by its process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Disc,
    Ring,
    Eccentric,
    Output,
}

impl Part {
    /// Of a key of `[tolerances]`.
    fn of(key: &str) -> Part {
        match key {
            key if key.starts_with("pin_") => Part::Ring,
            key if key.starts_with("eccentric") => Part::Eccentric,
            key if key.starts_with("output_") => Part::Output,
            _ => Part::Disc,
        }
    }
}

impl StageProcess {
    /// Tolerance of a key (in its unit) by the process of its part; 0 where none is given.
    pub(super) fn tolerance(&self, key: &str) -> f64 {
        let process = match Part::of(key) {
            Part::Disc => self.disc,
            Part::Ring => self.ring,
            Part::Eccentric => self.eccentric,
            Part::Output => self.output,
        };
        process.map_or(0.0, |process| process.tolerance(key))
    }

    /// Systematic deviations of the parts.
    pub fn remaining(&self) -> StageOffsets {
        if self.compensated { StageOffsets::default() } else { self.offsets }
    }
}

fn in_um(given: Option<f64>, preset: f64) -> f64 {
    given.unwrap_or(preset) * UM
}

impl ProcessSection {
    pub(super) fn resolve(&self) -> StageProcess {
        let [hole, foot] = self.disc.map_or([0.0; 2], Process::systematic);
        StageProcess {
            disc: *self.disc,
            ring: *self.ring,
            eccentric: *self.eccentric,
            output: *self.output,
            offsets: StageOffsets {
                hole_diameter: in_um(*self.hole_diameter_um, hole),
                flank: in_um(*self.flank_um, 0.0),
                elephant_foot: in_um(*self.elephant_foot_um, foot),
                pin_circle_radius: in_um(*self.pin_circle_radius_um, 0.0),
                eccentric_clearance: in_um(*self.eccentric_clearance_um, 0.0),
            },
            compensated: *self.compensated,
        }
    }
}

/// The processes ring by ring, if the file contains any. If it contains those of one ring only, the other ring
/// is exact; the discs are common to both.
pub(super) fn of_two_rings(
    both: Option<&TwoRingProcessSection>,
    second: Option<&SecondProcessSection>,
) -> Option<[StageProcess; 2]> {
    if both.is_none() && second.is_none() {
        return None;
    }
    let disc = both.and_then(|both| *both.disc);
    let compensated = both.is_some_and(|both| *both.compensated);
    let [_, foot] = disc.map_or([0.0; 2], Process::systematic);
    let exact = StageProcess {
        disc,
        ring: None,
        eccentric: None,
        output: None,
        offsets: StageOffsets::default(),
        compensated,
    };
    let at_rest = both.map_or(exact, |both| StageProcess {
        ring: *both.ring,
        eccentric: *both.eccentric,
        offsets: StageOffsets {
            flank: in_um(*both.flank_um, 0.0),
            elephant_foot: in_um(*both.elephant_foot_um, foot),
            pin_circle_radius: in_um(*both.pin_circle_radius_um, 0.0),
            eccentric_clearance: in_um(*both.eccentric_clearance_um, 0.0),
            ..StageOffsets::default()
        },
        ..exact
    });
    let turning = second.map_or(exact, |second| StageProcess {
        ring: *second.ring,
        offsets: StageOffsets {
            flank: in_um(*second.flank_um, 0.0),
            elephant_foot: in_um(*second.elephant_foot_um, 0.0),
            pin_circle_radius: in_um(*second.pin_circle_radius_um, 0.0),
            ..StageOffsets::default()
        },
        ..exact
    });
    Some([at_rest, turning])
}

impl Process {
    /// Keys of `[tolerances]` of a single stage with their values.
    pub fn tolerances(self) -> &'static [(&'static str, f64)] {
        match self {
            Process::PrintedFdm | Process::PrintedSls => PRINTED,
            Process::Milled | Process::WireEdm => CUT,
            Process::Ground => GROUND,
        }
    }

    /// Source of these values.
    pub fn tolerances_source(self) -> &'static str {
        match self {
            Process::PrintedFdm => {
                "discs of 80 mm measured within 100 µm, assumed common to all places of a part; for single places half of it, assumed"
            }
            Process::PrintedSls => "assumed: as printed from filament",
            Process::Milled | Process::WireEdm => {
                "in use for milled and wire-cut parts: flank 4, pin 2, hole 4, eccentric 3 µm; others assumed alike"
            }
            Process::Ground => "as in the template rv-40e: grinding, about ISO grade 4",
        }
    }

    fn tolerance(self, key: &str) -> f64 {
        self.tolerances().iter().find(|(name, _)| *name == key).map_or(0.0, |(_, width)| *width)
    }

    /// Deviation of the diameter of holes and projection of the first layer, µm. Holes printed from filament
    /// are 0.2 to 0.4 mm too small; the projection of the first layer is an assumption (chamfers of 0.3 mm are
    /// usual against it). For the other processes no systematic deviation is known.
    fn systematic(self) -> [f64; 2] {
        match self {
            Process::PrintedFdm => [-300.0, 100.0],
            _ => [0.0; 2],
        }
    }
}

const PRINTED: &[(&str, f64)] = &[
    ("pin_position_um", 50.0),
    ("pin_radius_um", 5.0),
    ("pin_circle_radius_um", 100.0),
    ("flank_offset_um", 100.0),
    ("flank_profile_um", 25.0),
    ("flank_run_out_um", 50.0),
    ("eccentricity_um", 50.0),
    ("eccentric_clearance_um", 10.0),
    ("output_pin_position_um", 50.0),
    ("output_pin_radius_um", 5.0),
    ("bore_position_um", 50.0),
    ("bore_offset_um", 100.0),
    ("bore_diameter_um", 50.0),
];

const CUT: &[(&str, f64)] = &[
    ("pin_position_um", 4.0),
    ("pin_radius_um", 2.0),
    ("pin_circle_radius_um", 4.0),
    ("flank_offset_um", 4.0),
    ("flank_profile_um", 4.0),
    ("flank_run_out_um", 4.0),
    ("eccentricity_um", 3.0),
    ("eccentric_clearance_um", 4.0),
    ("output_pin_position_um", 4.0),
    ("output_pin_radius_um", 2.0),
    ("bore_position_um", 4.0),
    ("bore_offset_um", 4.0),
    ("bore_diameter_um", 4.0),
];

const GROUND: &[(&str, f64)] = &[
    ("pin_position_um", 3.0),
    ("pin_radius_um", 1.0),
    ("pin_circle_radius_um", 3.0),
    ("flank_offset_um", 2.0),
    ("flank_profile_um", 2.0),
    ("flank_run_out_um", 4.0),
    ("eccentricity_um", 2.0),
    ("eccentric_clearance_um", 3.0),
    ("output_pin_position_um", 4.0),
    ("output_pin_radius_um", 1.0),
    ("bore_position_um", 4.0),
    ("bore_offset_um", 2.0),
    ("bore_diameter_um", 3.0),
];
