//! The design file: TOML in trade units, read with the place of every value, and turned into a [`Machine`] in
//! SI units.
//!
//! Every key is declared once, with its range and its documentation, in the sections below; reader, reference
//! and hash are derived from this declaration. A file that cannot be used gives a [`DesignError`] with line,
//! text and remedy.

mod bodies;
mod consistency;
mod deviations;
mod drives;
mod edit;
#[cfg(test)]
mod edit_tests;
mod error;
#[doc(hidden)]
pub mod field;
mod hint;
mod json_schema;
mod manufacturing;
mod option_values;
#[doc(hidden)]
pub mod options;
mod path;
mod process;
mod reference;
mod resolve;
mod resolve_laws;
#[doc(hidden)]
pub mod schema;
mod sections;
mod service;
mod single_stage;
mod solids;
mod stage_errors;
mod stage_resolve;
mod stage_thermal;
mod stage_tolerances;
#[cfg(test)]
mod tests;
mod text;
#[doc(hidden)]
pub mod tree;
mod two_ring;
mod two_stage;
mod unknowns;
mod value;
mod values;
pub mod variation;

pub use deviations::MeasuredFlank;
pub use edit::KeyEntry;
pub use error::{DesignError, DesignErrorKind, TextPlace};

#[doc(hidden)]
pub use crate::options;
pub use field::Choice;
pub use field::FieldValue;
pub use json_schema::json_schema;
pub use manufacturing::*;
pub use option_values::InputFile;
pub use options::{OptionReader, OptionSet};
pub use process::{Process, ProcessSection, SecondProcessSection, StageProcess, TwoRingProcessSection};
pub use reference::markdown as reference_of_keys;
pub use reference::section as reference_of_section;
pub use resolve::StaleMass;
pub use schema::unit_of;
pub use schema::{At, Key, Kind, Presence, Rule, SectionSchema};
pub use schema::{default, default_word, optional, positional, word};
pub use sections::*;
pub use service::*;
pub use single_stage::{
    EccentricSection, OutputPinsSection, PinSupport, StageBearingsSection, StageDesign, StageMember,
    StageSections,
};
pub use stage_errors::{
    HoleErrorSection, SecondErrorsSection, StageEccentricErrorSection, StageErrorsSection,
    TwoRingErrorsSection,
};
pub use stage_thermal::StageThermalSection;
pub use stage_tolerances::{
    SecondTolerancesSection, StageTolerancesSection, StageWidth, TwoRingTolerancesSection,
};
pub use two_ring::{SecondDiscSection, TwoRingDesign, TwoRingSections};
pub use two_stage::{FirstStageSection, TwoStageDesign, TwoStageSections};
pub use unknowns::Unknown;
pub use value::Value;
pub use values::{Section, Stated};

pub use error::Source;

use edit::{OfWritten, Written};
use field::SectionValue;
use schema::section;
use sha2::{Digest, Sha256};
use tree::Branch;
use variation::Variations;

use crate::machine::{FixedMember, Machine, ManufacturingErrors, Tolerances};

section! {
    /// Which kind of drive the file describes.
    pub struct DriveSection {
        /// Family of the drive. Each has sections of its own.
        family: Family => default_word("rv"),
    }

    /// A design file.
    pub struct DesignSections {
        /// Name of the design, for reports.
        name: String => word(),
        /// One sentence for reports.
        description: String => default_word(""),
        /// Kind of drive.
        drive: Section<DriveSection> => OPTIONAL_SECTION,
        /// Member at rest.
        fixed_member: FixedMember => default_word("housing"),
        /// The ring of pins.
        ring: Section<RingSection> => word(),
        /// The cycloid discs.
        disc: Section<DiscSection> => word(),
        /// The crankshafts.
        crankshafts: Section<CrankshaftSection> => word(),
        /// Sun and planets.
        gear_stage: Section<GearStageSection> => word(),
        /// The carrier.
        carrier: Section<CarrierSection> => word(),
        /// The housing.
        housing: Section<HousingSection> => OPTIONAL_SECTION,
        /// Bearings and supports.
        bearings: Section<BearingsSection> => word(),
        /// Friction.
        friction: Section<FrictionSection> => OPTIONAL_SECTION,
        /// Temperature, oil and cooling.
        thermal: Section<ThermalSection> => OPTIONAL_SECTION,
        /// Law of the tooth contacts.
        contact: Section<ContactSection> => OPTIONAL_SECTION,
        /// Rated load and speed.
        load: Section<LoadSection> => word(),
        /// Load spectrum. Left out, the machine runs at its rated point.
        duty: Vec<At<Section<DutySection>>> => optional(0.0, 0.0),
        /// Wear.
        wear: Section<WearSection> => word(),
        /// Limits.
        limits: Section<LimitsSection> => OPTIONAL_SECTION,
        /// Manufacturing errors given one by one. Left out: none.
        errors: Option<Section<ErrorsSection>> => optional(0.0, 0.0),
        /// Tolerances from which machines are drawn. Left out: no machines can be drawn.
        tolerances: Option<Section<TolerancesSection>> => optional(0.0, 0.0),
        /// Uncertain values: paths of keys in quotation marks, such as `"bearings.turning_arm.clearance_um" = {
        /// low = 2, high = 12 }`, `{ factor = 3 }` or `{ mean = 8, deviation = 2 }`. The value of the key must
        /// lie inside. A study can vary them all.
        unknowns: Variations => optional(0.0, 0.0),
    }
}

/// Kinds of drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// RV reducer: sun and planets drive crankshafts whose eccentrics move discs in a ring of pins; the
    /// output is the carrier or the housing.
    Rv,
    /// Single stage: eccentrics on the input shaft, discs in one ring of pins, output pins in holes of the
    /// discs.
    Eccentric,
    /// Stepped discs on eccentrics of the input shaft, with one profile in a ring at rest and one in the ring
    /// of the output.
    TwoRing,
    /// Two single stages in series: the output of the first turns the eccentrics of the second.
    TwoStage,
}

impl Choice for Family {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("rv", "RV reducer: sun and planets drive crankshafts around the centre"),
        ("eccentric", "single stage: eccentrics on the input shaft, output pins in holes of the discs"),
        ("two-ring", "stepped discs in a ring at rest and in a second ring, which is the output"),
        ("two-stage", "two single stages in series"),
    ];
    const VALUES: &'static [Family] = &[Family::Rv, Family::Eccentric, Family::TwoRing, Family::TwoStage];
}

impl Family {
    /// The family of the text of a design file.
    pub fn of_text(text: &str, file_name: &str) -> Result<Family, Box<DesignError>> {
        field::parse(&Source { text, file_name, title: TITLE }).map(|tree| Family::of(&tree))
    }

    /// The family of a design file, as far as it can be read.
    fn of(tree: &Branch) -> Family {
        match tree.at(&["drive", "family"]).map(|item| &item.node) {
            Some(tree::Node::Text(word)) => {
                Family::VALUES.iter().copied().find(|family| **word == *family.word()).unwrap_or(Family::Rv)
            }
            _ => Family::Rv,
        }
    }

    /// Name of a drive of this family.
    pub fn drive(self) -> &'static str {
        match self {
            Family::Rv => "RV reducer",
            Family::Eccentric => "single stage",
            Family::TwoRing => "drive of two rings",
            Family::TwoStage => "drive of two stages",
        }
    }

    /// Plural of the name.
    pub fn drives(self) -> &'static str {
        match self {
            Family::Rv => "RV reducers",
            Family::Eccentric => "single stages",
            Family::TwoRing => "drives of two rings",
            Family::TwoStage => "drives of two stages",
        }
    }
}

/// Title of a design file in messages.
const TITLE: &str = "the design file";

/// A design as written: values in trade units with their places in the file, free of contradictions.
#[derive(Debug, Clone)]
pub struct Design {
    sections: DesignSections,
    machine: Machine,
    errors: Option<ManufacturingErrors>,
    written: Written,
    unknowns: Vec<Unknown>,
}

/// Designs are equal if their files are.
impl PartialEq for Design {
    fn eq(&self, other: &Design) -> bool {
        self.text() == other.text()
    }
}

impl std::ops::Deref for Design {
    type Target = DesignSections;

    fn deref(&self) -> &DesignSections {
        &self.sections
    }
}

impl Design {
    /// Reads a design file; `file_name` is used in messages only.
    ///
    /// # Errors
    /// The first error: syntax, unknown keys, missing values or values of a wrong type, numbers that are not
    /// finite or out of range, values that contradict each other.
    pub fn parse(text: &str, file_name: &str) -> Result<Design, Box<DesignError>> {
        Design::of_written(Written::parse(text, file_name)?).map_err(|(error, _)| error)
    }
}

impl OfWritten for Design {
    fn of_written(written: Written) -> Result<Design, (Box<DesignError>, Written)> {
        let (source, tree) = (written.source(), written.tree());
        let read = || {
            let family = Family::of(tree);
            if family != Family::Rv {
                return Err(single_stage::not_yet(tree, &source, family));
            }
            let sections: DesignSections = field::read(tree, &source)?;
            let located = |error| field::with_path(error, tree);
            consistency::check(&sections, &source).map_err(located)?;
            let machine = resolve::machine(&sections, &source).map_err(located)?;
            let errors = deviations::errors(&sections, &source).map_err(located)?;
            let unknowns = unknowns::unknowns(&sections.unknowns, &DesignSections::SCHEMA, tree, &source)
                .map_err(located)?;
            Ok((sections, machine, errors, unknowns))
        };
        match read() {
            Ok((sections, machine, errors, unknowns)) => {
                Ok(Design { sections, machine, errors, written, unknowns })
            }
            Err(error) => Err((error, written)),
        }
    }
}

impl Design {
    /// The text of the design file with all changes; comments and layout are kept.
    pub fn text(&self) -> &str {
        self.written.text()
    }

    /// [`Design::text`] as an owned text.
    pub fn to_toml(&self) -> String {
        self.text().to_owned()
    }

    /// Name of the file as given to [`Design::parse`].
    pub fn file_name(&self) -> &str {
        self.written.file_name()
    }

    /// The design in SI units.
    pub fn machine(&self) -> Machine {
        self.machine.clone()
    }

    /// Manufacturing errors given one by one, without the flanks of [`Design::measured_flanks`]; `None` if the
    /// file contains none.
    pub fn given_errors(&self) -> Option<ManufacturingErrors> {
        self.errors.clone()
    }

    /// Measured flanks, each a file in the directory of the design file.
    pub fn measured_flanks(&self) -> Vec<MeasuredFlank> {
        deviations::measured_flanks(&self.sections)
    }

    /// Tolerances from which machines are drawn, in SI units; `None` if the file contains none.
    pub fn drawing_tolerances(&self) -> Option<Tolerances> {
        deviations::tolerances(&self.sections)
    }

    /// Uncertain values from the section `[unknowns]` of the design, in the order of the file. A study that
    /// varies one of these keys itself removes the section first: `design.with("unknowns", Value::LeftOut)`.
    pub fn unknowns(&self) -> Vec<Unknown> {
        self.unknowns.clone()
    }

    /// Masses and moments of inertia in the file that no longer fit, because the geometry has been changed
    /// since by [`Design::with`]. Those not in the file are computed from the geometry.
    pub fn stale_masses(&self) -> Vec<StaleMass> {
        let Some(base) = self.written.changed_from() else { return Vec::new() };
        let read = field::read::<DesignSections>(base, &self.written.source());
        read.map_or_else(|_| Vec::new(), |base| resolve::stale_masses(&base, &self.sections))
    }

    /// Every value that affects results, defaults included, one `section.key = value` per line: independent of
    /// layout, comments and order.
    pub fn canonical(&self) -> String {
        canonical(&self.sections)
    }

    /// Dotted keys that have their defaults. Keys whose absence means that a part or effect does not exist are
    /// not included.
    pub fn defaulted(&self) -> Vec<String> {
        defaulted(&self.sections)
    }

    /// SHA-256 of [`Design::canonical`] as 64 hexadecimal digits.
    pub fn hash(&self) -> String {
        hash(&self.canonical())
    }

    /// The first twelve digits of [`Design::hash`], for outputs.
    pub fn short_hash(&self) -> String {
        self.hash()[..12].to_owned()
    }
}

/// [`Design::canonical`] of the sections of any family.
fn canonical(sections: &impl SectionValue) -> String {
    let mut lines = Vec::new();
    sections.canonical_fields("", &mut lines);
    // Designs from before the introduction of families keep their hash.
    lines.retain(|line| !line.starts_with("description = ") && line != "drive.family = \"rv\"");
    lines.join("\n")
}

/// [`Design::defaulted`] of the sections of any family.
fn defaulted(sections: &impl SectionValue) -> Vec<String> {
    let mut keys = Vec::new();
    sections.defaulted_fields("", &mut keys);
    // An error or a tolerance that is not listed is zero, which is not an assumption.
    keys.retain(|key| {
        let stands_for_nothing = key == "description" || key == "drive.family";
        let of_drive = key.strip_prefix("first_stage.").or(key.strip_prefix("second_")).unwrap_or(key);
        !stands_for_nothing && !of_drive.starts_with("errors.") && !of_drive.starts_with("tolerances.")
    });
    keys
}

/// SHA-256 as 64 hexadecimal digits.
fn hash(canonical: &str) -> String {
    Sha256::digest(canonical.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}
