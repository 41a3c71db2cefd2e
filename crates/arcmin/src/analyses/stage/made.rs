//! Drives of eccentrics as made: one drive with its errors, and the play of many.

mod play;

pub(in crate::analyses) use play::{DRIVES, MATCHED, TOLERANCES, in_arcmin};
pub use play::{MadePlay, Matched, Overlaps, Plays, ToleranceShare};

use super::EccentricDrive;
use super::keys::{StageKeys, has_output_pins};
use crate::analyses::{AnalysisError, Host, TextBlock};
use crate::checks::Finding;
use crate::design::{Choice, StageWidth, Stated, default, default_word, optional, options};
use crate::dynamics::ElasticDiscs;
use crate::fidelity::{
    DiscBodies, ErrorSource, FidelityOptions, FrameBodies, Joints, LARGEST_SEED, stage_discs,
};
use crate::machine::{Batch, PartCounts, StageErrors, StageTolerances};
use crate::results::{Column, Value, quantities as q};

options! {
    /// Discs and errors of one drive.
    pub struct MadeOptions {
        /// Model of the cycloid discs. Left out: elastic in `life`, `wear`, `rig` and `calibrate`, where the drive has a model of
        /// elastic discs and they leave room for a mesh.
        discs: Stated<DiscBodies> => default_word("rigid"),
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
        let discs = Stated { value: DiscBodies::Rigid, is_written: false };
        MadeOptions { discs, errors: None, seed: None, batch_seed: None, batch_share: 0.5 }
    }
}

impl MadeOptions {
    /// The same with these discs.
    pub(in crate::analyses) fn with_discs(&self, discs: DiscBodies) -> MadeOptions {
        MadeOptions { discs: Stated { value: discs, is_written: true }, ..*self }
    }

    /// Whether rigid discs were chosen for a drive that has a model of elastic ones.
    pub(super) fn rigid_by_choice<D: EccentricDrive>(&self) -> bool {
        self.discs.is_written && self.discs.value == DiscBodies::Rigid && has_output_pins(D::STAGES)
    }

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
        if given.bodies.value != FrameBodies::Rigid {
            return Err(AnalysisError::usage(
                "bodies of drives of eccentrics are rigid, except for their discs and output pins",
                "leave out --bodies; --discs elastic has elastic discs",
            ));
        }
        Ok(MadeOptions {
            discs: given.discs,
            errors: given.errors,
            seed: given.seed,
            batch_seed: given.batch_seed,
            batch_share: given.batch_share,
        })
    }
}

/// Discs of a drive, and source of its errors.
#[derive(Debug, Clone)]
pub struct StageFidelity {
    /// Whether its discs are elastic.
    pub elastic_discs: bool,
    /// Why they are rigid although elastic ones are the default.
    pub no_room: Option<Finding>,
    /// Origin of the errors.
    pub source: ErrorSource,
    /// Seed of a drawn drive.
    pub seed: Option<u64>,
}

/// A drive with its errors and its discs.
pub struct Made<D> {
    /// Design with the errors in it.
    pub design: D,
    /// Elastic discs, stage by stage; empty with rigid ones.
    pub discs: Vec<ElasticDiscs>,
    /// Whether the discs are elastic, and which errors these are.
    pub fidelity: StageFidelity,
}

/// Results of a drive as made.
pub(super) trait HasStageFidelity {
    fn fidelity(&self) -> &StageFidelity;
}

/// The entries of a summary for them.
pub(super) fn fidelity_entries<O: HasStageFidelity>() -> Vec<Column<O>> {
    vec![
        q::DISCS.of(|o: &O| o.fidelity().discs_word().into()),
        q::ERRORS_SOURCE.of(|o: &O| o.fidelity().source.word().into()),
        q::ERRORS_SEED.of(|o| Value::from(o.fidelity().seed)),
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

/// Elastic discs of a drive, stage by stage. If the options do not name the discs, a drive without a model of elastic ones has
/// rigid ones, and so has a drive whose discs cannot be meshed, with a finding.
fn discs_of<D: EccentricDrive>(
    design: &D,
    options: &MadeOptions,
    host: &dyn Host,
) -> Result<(Vec<ElasticDiscs>, Option<Finding>), AnalysisError> {
    let Stated { value, is_written } = options.discs;
    match value {
        DiscBodies::Rigid => return Ok((Vec::new(), None)),
        DiscBodies::Elastic if !is_written && !has_output_pins(D::STAGES) => return Ok((Vec::new(), None)),
        DiscBodies::Elastic => {}
    }
    match elastic(design, host) {
        Err(error) if !is_written && !matches!(error, AnalysisError::Stopped) => {
            Ok((Vec::new(), Some(no_room(&error))))
        }
        discs => Ok((discs?, None)),
    }
}

fn no_room(error: &AnalysisError) -> Finding {
    Finding::warning(
        "elastic-discs",
        format!("discs are rigid: {error}"),
        "rigid discs are stiffer than real ones, so that lost motion is underestimated and the load of single pins is \
         uncertain",
        "leave more material between the holes, the bore and the flank of the discs, or choose --discs rigid",
    )
}

/// Elastic discs of a drive, stage by stage.
fn elastic(design: &impl EccentricDrive, host: &dyn Host) -> Result<Vec<ElasticDiscs>, AnalysisError> {
    design.disc_shapes()?.into_iter().map(|stage| stage_discs(stage, host)).collect()
}

impl<D: EccentricDrive> Made<D> {
    /// A similar design with the same errors and elastic or rigid discs. Discs of the same shapes are not reduced again.
    ///
    /// # Errors
    /// As [`Made::of`].
    pub fn like(&self, design: &D, options: &MadeOptions, host: &dyn Host) -> Result<Self, AnalysisError> {
        let rigid = Made::of(design, &options.with_discs(DiscBodies::Rigid), host)?;
        let discs = match self.fidelity.elastic_discs {
            false => Vec::new(),
            true if design.disc_shapes()? == self.design.disc_shapes()? => self.discs.clone(),
            true => elastic(design, host)?,
        };
        Ok(Made { discs, fidelity: self.fidelity.clone(), ..rigid })
    }

    /// # Errors
    /// [`AnalysisError::Usage`] if the design lacks the errors or tolerances that the options need; others if discs cannot be reduced.
    pub fn of(design: &D, options: &MadeOptions, host: &dyn Host) -> Result<Self, AnalysisError> {
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
        let (discs, no_room) = discs_of(design, options, host)?;
        let fidelity = StageFidelity { elastic_discs: !discs.is_empty(), no_room, source, seed };
        Ok(Made { design: design.with_errors(errors), discs, fidelity })
    }
}

impl StageFidelity {
    fn discs_word(&self) -> &'static str {
        if self.elastic_discs { DiscBodies::Elastic.word() } else { DiscBodies::Rigid.word() }
    }

    /// Contents of the model of a drive of these stages, in words, with the reason if its discs could not be elastic.
    pub(super) fn model(&self, stages: &[StageKeys]) -> String {
        let bodies = match (self.elastic_discs, has_output_pins(stages)) {
            (true, true) => "elastic discs and output pins, other bodies rigid but for their contacts",
            (true, false) => "elastic discs, other bodies rigid but for their contacts",
            (false, true) => "bodies rigid but for their contacts and output pins",
            (false, false) => "bodies rigid but for their contacts",
        };
        let no_room =
            self.no_room.as_ref().map_or(String::new(), |finding| format!(" ({})", finding.message));
        format!("joints of the whole drive with their clearances, {bodies}{no_room}")
    }

    /// Which errors it has, if any.
    pub fn words(&self) -> Option<String> {
        match (self.source, self.seed) {
            (ErrorSource::Given, _) => Some("drive with the manufacturing errors of the design".to_owned()),
            (_, Some(seed)) => Some(format!("drive drawn from the tolerances with seed {seed}")),
            _ => None,
        }
    }

    /// Which errors it has as a line for a terminal, if any.
    pub fn text_blocks(&self) -> Option<TextBlock> {
        self.words().map(TextBlock::line)
    }
}
