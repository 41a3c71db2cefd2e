//! Design files of drives of eccentrics: the parts that their families share.

use super::consistency::contradiction;
use super::error::Source;
use super::sections::RingSection;
use super::single_stage::OutputPinsSection;
use super::tree::Branch;
use super::{Choice, DesignError, Family};
use crate::machine::PinMounting;

/// Sections of the rings of a drive by their paths, and its output pins.
pub(super) type PinSections<'a> = (Vec<(&'static str, &'a RingSection)>, Vec<&'a OutputPinsSection>);

/// Removes the keys of pin seats that have no meaning in a drive: a ring of one piece has no pin seats and hence no
/// seat compliance, and pins slide in their seats only if those of a ring spin or output pins have rollers.
pub(super) fn without_seats(keys: &mut Vec<String>, (rings, pins): PinSections<'_>) {
    let mut absent: Vec<String> = rings
        .iter()
        .filter(|(_, ring)| *ring.pin_mounting == PinMounting::OnePiece)
        .map(|(path, _)| format!("{path}.seat_compliance_um_per_kn"))
        .collect();
    let spins = rings.iter().any(|(_, ring)| *ring.pin_mounting == PinMounting::Spinning);
    if !spins && !pins.iter().any(|pins| pins.has_rollers()) {
        absent.push("friction.pin_seat_coefficient".to_owned());
    }
    keys.retain(|key| !absent.contains(key));
}

/// Refuses a file of another family.
pub(super) fn require(family: Family, tree: &Branch, source: &Source) -> Result<(), Box<DesignError>> {
    if Family::of(tree) == family {
        return Ok(());
    }
    let place = tree.at(&["drive", "family"]).map(|item| item.span.clone());
    let message = format!("a {} has the family \"{}\"", family.drive(), family.word());
    Err(contradiction(source, &place, message, "read drives of other families from files of their own"))
}

/// A design as written, of a family with the sections `load`, `duty`, `wear`, `limits` and `friction`;
/// `resolve` converts it to a drive in SI units. `bearings` are the sections of all eccentric bearings, `pins`
/// those of rings and output pins, `given` the errors of one drive: of its stage, or stage by stage.
macro_rules! drive_design {
    ($(#[doc = $doc:literal])* $Design:ident, $Sections:ident, $Drive:ty, $Errors:ty, $family:expr, $resolve:expr, $bearings:expr, $pins:expr, $given:expr) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone)]
        pub struct $Design {
            sections: $Sections,
            drive: $Drive,
            /// Wear of flanks, pins and eccentric bearings, if the file contains it.
            wear: Option<Wear>,
            /// Errors given individually, if the file contains them.
            errors: Option<$Errors>,
            unused: Vec<&'static str>,
            unknowns: Vec<Unknown>,
            pub(super) written: Written,
        }

        impl OfWritten for $Design {
            fn of_written(written: Written) -> Result<$Design, (Box<DesignError>, Written)> {
                let (source, tree) = (written.source(), written.tree());
                let read = || {
                    drives::require($family, tree, &source)?;
                    let sections: $Sections = field::read(tree, &source)?;
                    let located = |error| field::with_path(error, tree);
                    consistency::duty(&sections.duty, &sections.load, &source).map_err(located)?;
                    let drive = $resolve(&sections, &source).map_err(located)?;
                    let kinds = $bearings(&sections);
                    let wear = sections.wear.as_ref();
                    let wear = wear.map(|wear| resolve_laws::stage_wear(wear, &kinds, &source)).transpose();
                    let wear = wear.map_err(located)?;
                    let errors = $given(&sections, &drive, &source).map_err(located)?;
                    let unknowns =
                        unknowns::unknowns(&sections.unknowns, &$Sections::SCHEMA, tree, &source);
                    let unknowns = unknowns.map_err(located)?;
                    Ok((sections, drive, wear, errors, unknowns))
                };
                match read() {
                    Ok((sections, drive, wear, errors, unknowns)) => {
                        let unused = unused_keys(tree, &UNUSED, &sections.load, &sections.duty);
                        Ok($Design { sections, drive, wear, errors, unused, unknowns, written })
                    }
                    Err(error) => Err((error, written)),
                }
            }
        }

        impl std::ops::Deref for $Design {
            type Target = $Sections;

            fn deref(&self) -> &$Sections {
                &self.sections
            }
        }

        impl $Design {
            /// Reads a design file; `file_name` is used in messages only.
            ///
            /// # Errors The first error, as [`Design::parse`](super::Design::parse).
            pub fn parse(text: &str, file_name: &str) -> Result<$Design, Box<DesignError>> {
                $Design::of_written(Written::parse(text, file_name)?).map_err(|(error, _)| error)
            }

            /// As [`Design::text`](super::Design::text).
            pub fn text(&self) -> &str {
                self.written.text()
            }

            /// As [`Design::file_name`](super::Design::file_name).
            pub fn file_name(&self) -> &str {
                self.written.file_name()
            }

            /// The drive in SI units.
            pub fn drive(&self) -> &$Drive {
                &self.drive
            }

            /// Errors of one drive, if the file contains them.
            pub fn given_errors(&self) -> Option<$Errors> {
                self.errors.clone()
            }

            /// The same drive with deviations from its drawing.
            #[must_use]
            pub fn made(&self, errors: $Errors) -> $Design {
                let mut made = self.clone();
                made.drive.set_errors(errors);
                made
            }

            /// Rated output torque (N·m) and input speed (rad/s).
            pub fn rated(&self) -> DutyPoint {
                resolve::duty(&self.load, &self.duty).0
            }

            /// Load spectrum; the rated point if the file contains none.
            pub fn duty_points(&self) -> Vec<DutyPoint> {
                resolve::duty(&self.load, &self.duty).1
            }

            /// Wear of flanks, pins and eccentric bearings, if the file contains it.
            pub fn wear(&self) -> Option<&Wear> {
                self.wear.as_ref()
            }

            /// Limits for checks and lives, in SI units.
            pub fn limits(&self) -> Limits {
                resolve::limits(&self.sections.limits)
            }

            /// As [`Design::unknowns`](super::Design::unknowns).
            pub fn unknowns(&self) -> Vec<Unknown> {
                self.unknowns.clone()
            }

            /// Heat dissipation of the drive.
            pub fn thermal(&self) -> $crate::machine::StageThermal {
                self.sections.thermal.resolve()
            }

            /// Damping of ring pins on flanks.
            pub fn contact_damping(&self) -> crate::contact::Damping {
                resolve::damping(&self.contact)
            }

            /// As [`Design::canonical`](super::Design::canonical).
            pub fn canonical(&self) -> String {
                super::canonical(&self.sections)
            }

            /// As [`Design::defaulted`](super::Design::defaulted).
            pub fn defaulted(&self) -> Vec<String> {
                let mut keys = super::defaulted(&self.sections);
                keys.retain(|key| !UNUSED.iter().any(|unused| key.starts_with(unused)));
                drives::without_seats(&mut keys, $pins(&self.sections));
                keys
            }

            /// Keys and sections of the file that no analysis of this family uses.
            pub fn unused(&self) -> &[&'static str] {
                &self.unused
            }

            /// SHA-256 of the canonical text as 64 hexadecimal digits.
            pub fn hash(&self) -> String {
                super::hash(&self.canonical())
            }
        }
    };
}
pub(super) use drive_design;
