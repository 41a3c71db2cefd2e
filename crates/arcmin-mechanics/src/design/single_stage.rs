//! The design file of a single stage: the family `eccentric`.

use super::consistency::{self, contradiction};
use super::drives::{self, PinSections, drive_design};
use super::edit::{OfWritten, Written};
use super::error::Source;
use super::field::{self, Choice};
use super::resolve;
use super::resolve_laws::{self};
use super::schema::{At, default, default_word, optional, required, section, word};
use super::sections::{DiscSection, RingSection};
use super::service::{
    ContactSection, DutySection, FrictionSection, LimitsSection, LoadSection, OPTIONAL_SECTION,
    RollerBearingSection, WearSection,
};
use super::stage_errors::StageErrorsSection;
use super::stage_resolve::{StageParts, coefficients, stage, stage_friction};
use super::stage_thermal::StageThermalSection;
use super::stage_tolerances::StageTolerancesSection;
use super::tree::Branch;
use super::unknowns::{self, Unknown};
use super::variation::Variations;
use super::{DesignError, DriveSection, Family, ProcessSection, Section, StageProcess};
use crate::machine::{
    DutyPoint, Limits, PlayChain, SingleStage, StageErrors, StageFriction, StageTolerances, Wear,
};
use crate::materials::Material;

section! {
    /// Eccentrics in the middle of the input shaft, one per disc, spread equally over one turn.
    pub struct EccentricSection {
        /// Eccentricity e.
        eccentricity_mm: f64 => required(0.02, 100.0),
    }

    /// Pins of the output in holes of the discs.
    pub struct OutputPinsSection {
        /// Number of pins z_w, each with a hole in every disc.
        count: usize => required(3.0, 60.0),
        /// Radius R_w of the circle through their axes.
        circle_radius_mm: f64 => required(1.0, 2000.0),
        /// Radius of a pin.
        pin_radius_mm: f64 => required(0.1, 200.0),
        /// Radius r_w of the roller on a pin. If equal to the radius of the pin, there is no roller and the pin
        /// slides in the hole.
        roller_radius_mm: f64 => required(0.1, 200.0),
        /// Radial clearance δ: a hole has the radius r_w + e + δ.
        hole_clearance_um: f64 => default(0.0, 0.0, 2000.0),
        /// Support of the pins.
        support: PinSupport => default_word("one-end"),
        /// Distance from the plate that holds a pin to the middle of the nearest disc. Left out: half the width of a disc.
        plate_distance_mm: Option<f64> => optional(0.1, 1000.0),
        /// Material of the pins and rollers, by name or inline.
        material: Material => default_word("GCr15"),
    }

    /// Bearings of a single stage.
    pub struct StageBearingsSection {
        /// Bearings between eccentric and disc: one per disc.
        eccentric: Section<RollerBearingSection> => word(),
        /// Radial stiffness of the bearings of the input shaft together.
        input_radial_stiffness_n_per_um: f64 => default(100.0, 0.1, 1e6),
        /// Radial stiffness of the bearings of the output together.
        output_radial_stiffness_n_per_um: f64 => default(200.0, 0.1, 1e6),
    }

    /// A design file of the family `eccentric`.
    pub struct StageSections {
        /// Name of the design, for reports.
        name: String => word(),
        /// One sentence for reports.
        description: String => default_word(""),
        /// Kind of drive: `family = "eccentric"`.
        drive: Section<DriveSection> => OPTIONAL_SECTION,
        /// Member at rest.
        fixed_member: StageMember => default_word("ring"),
        /// The ring of pins.
        ring: Section<RingSection> => word(),
        /// The cycloid discs. The bore of the eccentric bearing is `crank_bore_diameter_mm`.
        disc: Section<DiscSection> => word(),
        /// The eccentrics.
        eccentric: Section<EccentricSection> => word(),
        /// The output pins.
        output_pins: Section<OutputPinsSection> => word(),
        /// Bearings.
        bearings: Section<StageBearingsSection> => word(),
        /// Friction.
        friction: Section<FrictionSection> => OPTIONAL_SECTION,
        /// Law of the contacts of ring pins with flanks.
        contact: Section<ContactSection> => OPTIONAL_SECTION,
        /// Rated load and speed.
        load: Section<LoadSection> => word(),
        /// Load spectrum. Left out, the drive runs at its rated point.
        duty: Vec<At<Section<DutySection>>> => optional(0.0, 0.0),
        /// Wear.
        wear: Option<Section<WearSection>> => optional(0.0, 0.0),
        /// Heat.
        thermal: Section<StageThermalSection> => OPTIONAL_SECTION,
        /// Limits.
        limits: Section<LimitsSection> => OPTIONAL_SECTION,
        /// Errors of one drive. Left out: the nominal drive.
        errors: Option<Section<StageErrorsSection>> => optional(0.0, 0.0),
        /// Manufacturing processes of the parts. Left out: no tolerances and no systematic deviations by
        /// process.
        process: Option<Section<ProcessSection>> => optional(0.0, 0.0),
        /// Tolerances from which drives are drawn. Left out: no drives can be drawn.
        tolerances: Option<Section<StageTolerancesSection>> => optional(0.0, 0.0),
        /// Values that are not known exactly.
        unknowns: Variations => optional(0.0, 0.0),
    }
}

impl StageSections {
    pub(super) fn parts(&self) -> StageParts<'_> {
        StageParts {
            ring: &self.ring,
            disc: &self.disc,
            eccentric: &self.eccentric,
            output_pins: &self.output_pins,
            bearings: &self.bearings,
            contact: &self.contact,
            rated: *self.load.rated_torque_n_m,
        }
    }
}

/// Support of output pins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PinSupport {
    /// In one plate: the pins are cantilevers.
    OneEnd,
    /// In plates on both sides of the discs: the pins are beams clamped at both ends.
    BothEnds,
}

impl Choice for PinSupport {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("one-end", "in one plate: cantilevers"),
        ("both-ends", "in plates on both sides of the discs: beams clamped at both ends"),
    ];
    const VALUES: &'static [PinSupport] = &[PinSupport::OneEnd, PinSupport::BothEnds];
}

/// The member of a single stage that is at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StageMember {
    /// The ring is at rest and the output pins turn; ratio −z_c.
    Ring,
    /// The output pins are at rest and the ring turns with the load; ratio z_p.
    Output,
}

impl OutputPinsSection {
    /// Whether rollers turn on the pins.
    pub(super) fn has_rollers(&self) -> bool {
        *self.roller_radius_mm > *self.pin_radius_mm
    }
}

impl Choice for StageMember {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("ring", "ring at rest, the output pins turn: ratio −z_c"),
        ("output", "output pins at rest, the ring turns with the load: ratio z_p"),
    ];
    const VALUES: &'static [StageMember] = &[StageMember::Ring, StageMember::Output];
}

/// Keys of sections shared with RV reducers that no analysis of a single stage uses.
pub(super) const UNUSED: [&str; 11] = [
    "wear.paper",
    "wear.crank_support",
    "wear.sun",
    "wear.planet",
    "friction.gear_mesh_coefficient",
    "friction.seal_drag_n_m",
    "friction.oil_drag_n_m_s_per_rad",
    "friction.regularisation_speed_mm_s",
    "friction.bearing_drag_factor",
    "friction.crank_support_preload_n",
    "limits.emergency_torque_n_m",
];

/// The same where a row of the duty has it.
const UNUSED_FORCES: &str = "duty: moment_n_m, axial_n, radial_n";

/// Keys of the file among those that are not used.
pub(super) fn unused_keys(
    tree: &Branch,
    keys: &[&'static str],
    load: &LoadSection,
    duty: &[At<Section<DutySection>>],
) -> Vec<&'static str> {
    let is_given = |path: &str| tree.at(&path.split('.').collect::<Vec<_>>()).is_some();
    let mut unused: Vec<&str> = keys.iter().copied().filter(|path| is_given(path)).collect();
    if resolve::duty(load, duty).1.iter().any(|row| !row.forces.is_zero()) {
        unused.push(UNUSED_FORCES);
    }
    unused
}

drive_design! {
    /// A single stage as written, free of contradictions. [`StageDesign::drive`] has its ring at rest, also for
    /// a design whose ring rotates with the load.
    StageDesign, StageSections, SingleStage, StageErrors, Family::Eccentric,
    |sections: &StageSections, source: &Source| stage(&sections.parts(), source),
    |sections: &StageSections| [*sections.bearings.eccentric.kind],
    pin_sections, given
}

fn pin_sections(sections: &StageSections) -> PinSections<'_> {
    (vec![("ring", &sections.ring)], vec![&sections.output_pins])
}

fn given(
    sections: &StageSections,
    stage: &SingleStage,
    source: &Source,
) -> Result<Option<StageErrors>, Box<DesignError>> {
    let errors = sections.errors.value.as_ref();
    errors.map(|section| section.resolve(stage.part_counts(), source)).transpose()
}

impl StageDesign {
    /// Tolerances from which drives are drawn, if the file contains tolerances or processes.
    pub fn tolerances(&self) -> Option<StageTolerances> {
        let process = self.process();
        StageTolerancesSection::of(self.sections.tolerances.value.as_deref(), process.as_ref())
    }

    /// Processes of its parts, if the file contains them.
    pub fn process(&self) -> Option<StageProcess> {
        self.sections.process.value.as_ref().map(|section| section.resolve())
    }

    /// Coefficients of friction, and whether they are assumed because the file gives none.
    pub fn friction(&self) -> (StageFriction, bool) {
        let (coefficients, assumed) = coefficients(&self.sections.friction);
        let friction = stage_friction(coefficients, &self.ring, Some(&self.output_pins));
        (friction, assumed)
    }

    /// Whether there are rollers on the output pins.
    pub fn has_rollers(&self) -> bool {
        *self.output_pins.roller_radius_mm > *self.output_pins.pin_radius_mm
    }

    /// Whether the ring turns with the load.
    pub fn is_driven_housing(&self) -> bool {
        *self.fixed_member == StageMember::Output
    }

    /// Turns of the input for one of the output: −z_c/m, or z_p/m where the output pins are at rest, m the tooth difference.
    pub fn ratio(&self) -> f64 {
        if self.is_driven_housing() { self.drive.profile.pins_per_turn() } else { self.drive.ratio() }
    }

    /// Play at the output by part, input held.
    pub fn play_chain(&self) -> PlayChain {
        let (play, factor) = (self.drive.play_chain(), self.ratio_to_ring());
        PlayChain {
            ring: factor * play.ring,
            eccentric_bearing: factor * play.eccentric_bearing,
            output: factor * play.output,
        }
    }

    /// Ratio of angle (and of torque) at the output to those relative to the ring: z_c/z_p with rotating ring,
    /// because the input is held relative to the member at rest, and the torque of the output pins is T − T
    /// m/z_p; otherwise 1.
    pub fn ratio_to_ring(&self) -> f64 {
        let profile = &self.drive.profile;
        if self.is_driven_housing() { profile.lobe_count() as f64 / profile.pin_count as f64 } else { 1.0 }
    }

    /// Turns of the eccentrics relative to their discs per turn of the input: 1 + m/z_c, or 1 if the output is
    /// at rest and the discs do not rotate.
    pub fn eccentric_turns(&self) -> f64 {
        if self.is_driven_housing() { 1.0 } else { 1.0 + 1.0 / self.drive.profile.lobes_per_turn() }
    }
}

/// Error of commands that support RV reducers only.
pub(super) fn not_yet(tree: &Branch, source: &Source, family: Family) -> Box<DesignError> {
    let message = format!(
        "this command computes RV reducers only, and the file describes a {} (family \"{}\")",
        family.drive(),
        family.word()
    );
    let place = tree.at(&["drive", "family"]).map(|item| item.span.clone());
    let hint = format!(
        "{} are supported by `arcmin check`, `profile`, `contact`, `wear`, `calibrate`, `rig`, `simulate`, `life`, `study`, `explore`, `robot`, `import` and `export`",
        family.drives()
    );
    field::with_path(contradiction(source, &place, message, &hint), tree)
}
