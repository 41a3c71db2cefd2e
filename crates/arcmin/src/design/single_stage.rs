//! The design file of a single stage: the family `eccentric`.

use std::f64::consts::TAU;
use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::consistency::{self, contradiction};
use super::error::Source;
use super::field::{self, Choice, SectionValue};
use super::resolve;
use super::resolve_laws::law;
use super::schema::{At, default, default_word, optional, required, section, word};
use super::sections::{DiscSection, RingSection};
use super::service::{
    ContactSection, DutySection, FrictionSection, LimitsSection, LoadSection, OPTIONAL_SECTION,
    RollerBearingSection, WearSection,
};
use super::solids::Section as Solid;
use super::tree::Branch;
use super::variation::Variations;
use super::{DesignError, DriveSection, Section, TITLE, TolerancesSection};
use crate::contact::{ContactLaw, LineContact};
use crate::geometry::{Profile, Relief};
use crate::machine::{Bore, DutyPoint, Limits, OutputPins, PinMounting, SingleStage, StageFriction};
use crate::materials::Material;
use crate::units::{MM, UM};

section! {
    /// Eccentrics in the middle of the input shaft, one per disc, spread equally over one turn.
    pub struct EccentricSection {
        /// Eccentricity e.
        eccentricity_mm: f64 => required(0.02, 100.0),
    }

    /// Pins of the output in holes of the discs.
    pub struct OutputPinsSection {
        /// Number of pins z_w, a hole each in every disc.
        count: usize => required(3.0, 60.0),
        /// Radius R_w of the circle through their axes.
        circle_radius_mm: f64 => required(1.0, 2000.0),
        /// Radius of a pin.
        pin_radius_mm: f64 => required(0.1, 200.0),
        /// Radius r_w of the roller on a pin. Equal to the radius of the pin: the pin slides in the hole.
        roller_radius_mm: f64 => required(0.1, 200.0),
        /// Radial clearance δ: a hole has the radius r_w + e + δ.
        hole_clearance_um: f64 => default(0.0, 0.0, 2000.0),
        /// Where the pins are held.
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
        /// Limits.
        limits: Section<LimitsSection> => OPTIONAL_SECTION,
        /// Tolerances.
        tolerances: Option<Section<TolerancesSection>> => optional(0.0, 0.0),
        /// What is not known exactly.
        unknowns: Variations => optional(0.0, 0.0),
    }
}

/// Where output pins are held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PinSupport {
    OneEnd,
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
    Ring,
    Output,
}

impl Choice for StageMember {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("ring", "ring at rest, the output pins turn: ratio −z_c"),
        ("output", "output pins at rest, the ring turns with the load: ratio z_p"),
    ];
    const VALUES: &'static [StageMember] = &[StageMember::Ring, StageMember::Output];
}

/// A single stage as written, free of contradictions.
#[derive(Debug, Clone)]
pub struct StageDesign {
    sections: StageSections,
    stage: SingleStage,
    text: Arc<str>,
}

impl std::ops::Deref for StageDesign {
    type Target = StageSections;

    fn deref(&self) -> &StageSections {
        &self.sections
    }
}

impl StageDesign {
    /// Reads a design file; `file_name` only serves messages.
    ///
    /// # Errors
    /// The first thing that is wrong, as [`Design::parse`](super::Design::parse).
    pub fn parse(text: &str, file_name: &str) -> Result<StageDesign, Box<DesignError>> {
        let source = Source { text, file_name, title: TITLE };
        let tree = field::parse(&source)?;
        let sections: StageSections = field::read(&tree, &source)?;
        let stage = stage(&sections, &source).map_err(|error| field::with_path(error, &tree))?;
        Ok(StageDesign { sections, stage, text: text.into() })
    }

    /// The text as read.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The drive in SI units, its ring at rest.
    pub fn stage(&self) -> &SingleStage {
        &self.stage
    }

    /// Rated output torque (N·m) and input speed (rad/s).
    pub fn rated(&self) -> DutyPoint {
        resolve::duty(&self.load, &self.duty).0
    }

    /// Load spectrum; the rated point where the file gives none.
    pub fn duty_points(&self) -> Vec<DutyPoint> {
        resolve::duty(&self.load, &self.duty).1
    }

    pub fn limits(&self) -> Limits {
        resolve::limits(&self.sections.limits)
    }

    /// Coefficients of friction, and whether they are assumed because the file gives none.
    pub fn friction(&self) -> (StageFriction, bool) {
        let given = &self.sections.friction;
        let assumed = given.span.is_none();
        let [flank, seat, bearing] = if assumed {
            ASSUMED_FRICTION
        } else {
            [*given.flank_coefficient, *given.pin_seat_coefficient, *given.bearing_coefficient]
        };
        let pins = &self.output_pins;
        let has_rollers = *pins.roller_radius_mm > *pins.pin_radius_mm;
        let friction = StageFriction {
            ring: if *self.ring.pin_mounting == PinMounting::Spinning { flank.min(seat) } else { flank },
            output: if has_rollers { seat } else { flank },
            pin_over_roller: *pins.pin_radius_mm / *pins.roller_radius_mm,
            bearing,
        };
        (friction, assumed)
    }

    /// Whether the ring turns with the load.
    pub fn is_driven_housing(&self) -> bool {
        *self.fixed_member == StageMember::Output
    }

    /// Turns of the input for one of the output: −z_c, or z_p where the output pins are at rest.
    pub fn ratio(&self) -> f64 {
        if self.is_driven_housing() { self.stage.profile.pin_count as f64 } else { self.stage.ratio() }
    }

    /// Angle (rad) and torque at the output over those of the same drive seen from its ring, z_c/z_p with the ring
    /// turning: the input is held to what is at rest, and the pins bear T − T/z_p.
    pub fn seen_from_ring(&self) -> f64 {
        let profile = &self.stage.profile;
        if self.is_driven_housing() { profile.lobe_count() as f64 / profile.pin_count as f64 } else { 1.0 }
    }

    /// As [`Design::canonical`](super::Design::canonical).
    pub fn canonical(&self) -> String {
        let mut lines = Vec::new();
        self.sections.canonical_fields("", &mut lines);
        lines.retain(|line| !line.starts_with("description = "));
        lines.join("\n")
    }

    /// As [`Design::defaulted`](super::Design::defaulted).
    pub fn defaulted(&self) -> Vec<String> {
        let mut keys = Vec::new();
        self.sections.defaulted_fields("", &mut keys);
        keys.retain(|key| key != "description" && !key.starts_with("tolerances."));
        keys
    }

    /// SHA-256 of [`StageDesign::canonical`] as 64 hexadecimal digits.
    pub fn hash(&self) -> String {
        Sha256::digest(self.canonical().as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

/// What commands say that know RV reducers alone.
pub(super) fn not_yet(tree: &Branch, source: &Source) -> Box<DesignError> {
    let message = "this command computes RV reducers only, and the file describes a single stage (family \"eccentric\")";
    let place = tree.at(&["drive", "family"]).map(|item| item.span.clone());
    let hint = "single stages are known to `arcmin check`, `profile`, `contact`, `rig` and `export profile`";
    field::with_path(contradiction(source, &place, message.to_owned(), hint), tree)
}

fn stage(design: &StageSections, source: &Source) -> Result<SingleStage, Box<DesignError>> {
    let (ring, disc) = (&design.ring, &design.disc);
    consistency::teeth(ring, disc, source)?;
    consistency::free_form(&disc.modification, source)?;
    consistency::roller_bearing("eccentric", &design.bearings.eccentric, source)?;
    consistency::duty(&design.duty, &design.load, source)?;
    let cut = resolve::modification(&disc.modification);
    let (circle, pin_radius) = (*ring.pin_circle_radius_mm * MM, *ring.pin_radius_mm * MM);
    let profile = Profile {
        pin_count: *ring.pin_count,
        pin_circle_radius: circle + cut.radial_offset,
        eccentricity: *design.eccentric.eccentricity_mm * MM,
        pin_radius: pin_radius + cut.equidistant_offset,
    };
    consistency::flank(&profile, ring, &disc.modification, &design.eccentric.eccentricity_mm.span, source)?;
    if *disc.centre_hole_diameter_mm > 0.0 {
        let message = "a single stage has its eccentric bearing in the centre of the disc".to_owned();
        let place = &disc.centre_hole_diameter_mm.span;
        return Err(contradiction(source, place, message, "leave centre_hole_diameter_mm out"));
    }
    if disc.window_rim_mm.is_some() {
        let message = "window_rim_mm describes windows between the crankshafts of an RV reducer".to_owned();
        return Err(contradiction(source, &disc.window_rim_mm.span, message, "leave it out"));
    }
    let pins = &design.output_pins;
    if *pins.roller_radius_mm < *pins.pin_radius_mm {
        let message = format!(
            "a roller of {} mm radius does not go over a pin of {} mm",
            *pins.roller_radius_mm, *pins.pin_radius_mm
        );
        let hint = "equal radii describe pins without rollers";
        return Err(contradiction(source, &pins.roller_radius_mm.span, message, hint));
    }
    let width = *disc.width_mm * MM;
    let output_pins = OutputPins {
        count: *pins.count,
        circle_radius: *pins.circle_radius_mm * MM,
        radius: *pins.roller_radius_mm * MM,
        hole_clearance: *pins.hole_clearance_um * UM,
    };
    let rated = *design.load.rated_torque_n_m;
    let contact_law = law(&design.contact.law, &design.contact.span, &design.contact.parameters(), source)?;
    let mut stage = SingleStage {
        phases: (0..*disc.count).map(|j| TAU * j as f64 / *disc.count as f64).collect(),
        contact: LineContact::new(contact_law, &disc.material, &ring.material, width, pin_radius)
            .with_seat_compliance(*ring.seat_compliance_um_per_kn * UM / 1e3),
        relief: designed_relief(&profile, &cut),
        profile,
        ring_circle_radius: circle,
        ring_pin_radius: pin_radius,
        eccentric: resolve::roller(&design.bearings.eccentric),
        output_pins,
        output_pin_stiffness: Vec::new(),
        input_support: *design.bearings.input_radial_stiffness_n_per_um * 1e6,
        output_support: *design.bearings.output_radial_stiffness_n_per_um * 1e6,
        disc: (1.0, 1.0),
        input: (1.0, 1.0),
        output: (1.0, 1.0),
    };
    let solid = disc_solid(design, &stage);
    stage.disc = (disc.mass_kg.unwrap_or(solid.0), disc.inertia_kg_m2.unwrap_or(solid.1));
    // States of rest do not depend on the masses of shaft and output.
    (stage.input, stage.output) = (stage.disc, stage.disc);
    stage.output_pin_stiffness =
        (0..*disc.count).map(|j| output_pin_stiffness(design, &stage, j, rated)).collect();
    Ok(stage)
}

/// Relief on purpose beyond the two offsets.
fn designed_relief(profile: &Profile, cut: &crate::machine::FlankModification) -> Relief {
    if cut.rotation == 0.0 && cut.free_form.is_none() {
        return Relief::uniform(0.0);
    }
    let turned = Relief::grid(720).map(|phi| cut.rotation * profile.lever_arm(phi).abs()).collect();
    let turned = Relief::from_samples(turned);
    cut.free_form.as_ref().map_or(turned.clone(), |free| turned.plus(free))
}

/// Holes of the output pins and the bore of the eccentric bearing, m and rad.
pub(crate) fn openings(design: &StageSections, stage: &SingleStage) -> Vec<Bore> {
    let bearing = &stage.eccentric;
    let raceway = 0.5 * (bearing.pitch_diameter + bearing.roller_diameter);
    let bore = design.disc.crank_bore_diameter_mm.map_or(raceway, |diameter| 0.5 * diameter * MM);
    let pins = &stage.output_pins;
    let hole = |index: usize| Bore {
        radius: pins.radius + stage.profile.eccentricity + pins.hole_clearance,
        centre_radius: pins.circle_radius,
        centre_angle: TAU * index as f64 / pins.count as f64,
    };
    std::iter::once(Bore { radius: bore, centre_radius: 0.0, centre_angle: 0.0 })
        .chain((0..pins.count).map(hole))
        .collect()
}

fn disc_solid(design: &StageSections, stage: &SingleStage) -> (f64, f64) {
    let solid = openings(design, stage)
        .iter()
        .fold(Solid::inside_flank(&stage.profile), |solid, bore| solid.without(bore));
    let mass_per_area = design.disc.material.density * (*design.disc.width_mm * MM);
    // Openings that overlap are a finding; a mass is positive all the same.
    (mass_per_area * solid.area.max(1e-9), mass_per_area * solid.polar_moment.max(1e-15))
}

/// Of flanks, of pins in their seats and rollers on their pins, of rolling bearings: grease, as for RV reducers.
const ASSUMED_FRICTION: [f64; 3] = [0.06, 0.06, 0.002];

/// Shear coefficient of a round section (Cowper 1966 for ν = 0.3).
const SHEAR: f64 = 0.9;

/// Stiffness in N/m of one output pin at a disc: the pin as a Timoshenko beam, in series with the line contact of roller
/// and hole, its secant at the largest force of equal springs under the rated torque.
///
/// What a force on one disc bends the pin at another disc is left out.
fn output_pin_stiffness(design: &StageSections, stage: &SingleStage, disc: usize, rated: f64) -> f64 {
    let pins = &design.output_pins;
    let (width, radius) = (*design.disc.width_mm * MM, *pins.pin_radius_mm * MM);
    let first = pins.plate_distance_mm.map_or(0.5 * width, |distance| distance * MM);
    let a = first + disc as f64 * width;
    let material = &pins.material;
    let (area, second) =
        (std::f64::consts::PI * radius.powi(2), 0.25 * std::f64::consts::PI * radius.powi(4));
    let bending = material.youngs_modulus * second;
    let shear = SHEAR * area * material.youngs_modulus / (2.0 * (1.0 + material.poisson_ratio));
    let beam = match *pins.support {
        PinSupport::OneEnd => a.powi(3) / (3.0 * bending) + a / shear,
        PinSupport::BothEnds => {
            let span = 2.0 * first + (*design.disc.count - 1) as f64 * width;
            let b = span - a;
            (a * b).powi(3) / (3.0 * bending * span.powi(3)) + a * b / (span * shear)
        }
    };
    let hole = stage.output_pins.radius + stage.profile.eccentricity + stage.output_pins.hole_clearance;
    let equivalent = hole * stage.output_pins.radius / (hole - stage.output_pins.radius);
    let force = stage.output_pin_force(rated);
    1.0 / (beam + output_contact(design).approach(force, equivalent) / force)
}

/// The line contact of a roller of the output with its hole.
pub(crate) fn output_contact(design: &StageSections) -> LineContact {
    LineContact::new(
        ContactLaw::LineHertz,
        &design.disc.material,
        &design.output_pins.material,
        *design.disc.width_mm * MM,
        *design.output_pins.roller_radius_mm * MM,
    )
}
