//! Drives of eccentrics as made: one drive with its errors, and the play of many.

mod play;

pub(in crate::analyses) use play::{DRIVES, MATCHED, TOLERANCES, in_arcmin};
pub use play::{MadePlay, Matched, Overlaps, Plays, ToleranceShare};

use super::EccentricDrive;
use crate::analyses::{AnalysisError, Said};
use crate::design::{Choice, StageWidth, default, optional, options};
use crate::fidelity::{DiscBodies, ErrorSource, FidelityOptions, FrameBodies, Joints, LARGEST_SEED};
use crate::machine::{Batch, PartCounts, StageErrors, StageTolerances};
use crate::results::{Column, Value, quantities as q};

options! {
    /// Errors of one drive.
    pub struct MadeOptions {
        /// Manufacturing errors. Left out: the errors of the design's section `errors`, if it has one.
        errors: Option<ErrorSource> => optional(0.0, 0.0),
        /// Seed of the drive drawn with errors = drawn. Left out: 1.
        seed: Option<usize> => optional(0.0, LARGEST_SEED),
        /// Seed of the batch of the drawn drive. Drives of one batch share a part of their errors.
        batch_seed: Option<usize> => optional(0.0, LARGEST_SEED),
        /// Share of the variance of every tolerance that is common to one batch, 0 to 1.
        batch_share: f64 => default(0.5, 0.0, 1.0),
    }
}

impl Default for MadeOptions {
    fn default() -> MadeOptions {
        MadeOptions { errors: None, seed: None, batch_seed: None, batch_share: 0.5 }
    }
}

impl MadeOptions {
    /// From the options of RV reducers.
    ///
    /// # Errors
    /// [`AnalysisError::Usage`] for joints and bodies that drives of eccentrics do not have.
    pub(in crate::analyses) fn of_fidelity(given: &FidelityOptions) -> Result<MadeOptions, AnalysisError> {
        if given.joints.value == Joints::Ideal {
            return Err(AnalysisError::usage(
                "drives of eccentrics have no model in ideal joints",
                "choose joints = bearings",
            ));
        }
        if given.discs != DiscBodies::Rigid || given.bodies.value != FrameBodies::Rigid {
            return Err(AnalysisError::usage(
                "discs and other bodies of drives of eccentrics are rigid",
                "leave out --discs",
            ));
        }
        Ok(MadeOptions {
            errors: given.errors,
            seed: given.seed,
            batch_seed: given.batch_seed,
            batch_share: given.batch_share,
        })
    }
}

/// Source of the errors of a drive.
#[derive(Debug, Clone, Copy)]
pub struct Errors {
    /// Origin of the errors.
    pub source: ErrorSource,
    /// Seed of a drawn drive.
    pub seed: Option<u64>,
}

/// A drive with its errors.
pub struct Made<D> {
    /// Design with the errors in it.
    pub design: D,
    /// Which errors these are.
    pub errors: Errors,
}

/// Results of a drive with errors.
pub(super) trait HasErrors {
    fn errors(&self) -> Errors;
}

/// The entries of a summary for them.
pub(super) fn error_entries<O: HasErrors>() -> Vec<Column<O>> {
    vec![
        q::ERRORS_SOURCE.of(|o: &O| o.errors().source.word().into()),
        q::ERRORS_SEED.of(|o| Value::from(o.errors().seed)),
    ]
}

/// The widths of one section of a design file.
pub struct SectionOfWidths {
    /// Path of the section.
    pub section: &'static str,
    /// The stage whose errors they are.
    pub stage: usize,
    /// Widths with their keys.
    pub widths: &'static [StageWidth],
}

/// Parts and tolerances of the drawn drives, stage by stage.
type Drawn = Vec<(PartCounts, StageTolerances)>;

fn drawn(design: &impl EccentricDrive) -> Option<Drawn> {
    Some(design.part_counts().into_iter().zip(design.tolerances()?).collect())
}

impl<D: EccentricDrive> Made<D> {
    /// # Errors
    /// [`AnalysisError::Usage`] where the design does not give what the options ask for.
    pub fn of(design: &D, options: &MadeOptions) -> Result<Self, AnalysisError> {
        let given = design.given_errors();
        let source = options.errors.unwrap_or(match given {
            Some(_) => ErrorSource::Given,
            None => ErrorSource::None,
        });
        if options.seed.is_some() && source != ErrorSource::Drawn {
            return Err(AnalysisError::usage(
                "a seed needs drawn errors",
                "add errors = drawn, or remove the seed",
            ));
        }
        let seed = (source == ErrorSource::Drawn).then_some(options.seed.unwrap_or(1) as u64);
        let errors = match (source, seed) {
            (ErrorSource::Given, _) => given.ok_or_else(|| {
                AnalysisError::usage(
                    "the design gives no manufacturing errors",
                    "add a section [errors]; the chapter on design files lists its keys",
                )
            })?,
            (ErrorSource::Drawn, Some(seed)) => {
                let drawn = drawn(design).ok_or_else(|| {
                    AnalysisError::usage(
                        "the design gives no tolerances to draw from",
                        "add a section [tolerances]; the chapter on design files lists its keys",
                    )
                })?;
                let batch =
                    options.batch_seed.map(|seed| Batch { seed: seed as u64, share: options.batch_share });
                StageErrors::draw(&drawn, seed, batch)
            }
            _ => vec![StageErrors::default(); D::STAGES.len()],
        };
        Ok(Made { design: design.with_errors(errors), errors: Errors { source, seed } })
    }
}

impl Errors {
    /// Which errors it has, if any.
    pub fn words(&self) -> Option<String> {
        match (self.source, self.seed) {
            (ErrorSource::Given, _) => Some("drive with the manufacturing errors of the design".to_owned()),
            (_, Some(seed)) => Some(format!("drive drawn from the tolerances with seed {seed}")),
            _ => None,
        }
    }

    /// Which errors it has as a line for a terminal, if any.
    pub fn said(&self) -> Option<Said> {
        self.words().map(Said::line)
    }
}
