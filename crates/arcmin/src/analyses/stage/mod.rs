//! Analyses of single stages (family `eccentric`) and of other drives of eccentrics, under the names of those of RV
//! reducers.

mod any;
mod band;
mod bearings;
pub mod calibrate;
pub mod contact;
#[cfg(test)]
mod difference_tests;
mod drive;
mod entries;
mod findings;
pub mod flanks;
pub mod joint;
#[cfg(test)]
mod joint_tests;
mod keys;
pub mod life;
pub mod made;
#[cfg(test)]
mod made_tests;
mod meshing;
#[cfg(test)]
mod motion_tests;
pub(super) mod offsets;
mod play;
pub mod rig;
#[cfg(test)]
mod ring_tests;
#[cfg(test)]
mod series_tests;
pub mod simulate;
#[cfg(test)]
mod start_tests;
pub mod strength;
#[cfg(test)]
mod tests;
pub mod wear;
#[cfg(test)]
mod wear_tests;
mod worn;

pub use any::AnyDesign;
pub use drive::{EccentricDrive, Efficiency};
pub(super) use entries::{made_entries, strength_entries};
use keys::{PartKeys, RING, StageKeys};
pub(super) use made::DRIVES;
use meshing::Rests;
#[cfg(test)]
pub(crate) use meshing::{followers, rings};
pub use play::Play;
pub(super) use play::{HasPlay, play_entries, play_sentence, play_table};
pub use strength::Strength;

use super::{Analysis, AnalysisError, Host, NormalOptions, Outcome, check, profile};
use crate::design::{Choice, Family, OptionSet, SectionSchema, StageDesign, TwoRingDesign, TwoStageDesign};
use crate::machine::{Limits, RingPartner};
use crate::results::Declared;

/// An analysis of drives `D`.
pub struct DriveAnalysis<D: 'static> {
    /// Word of the command.
    pub name: &'static str,
    family: Family,
    run: fn(&D, &str, &str, &dyn Host) -> Result<Box<dyn Outcome>, AnalysisError>,
    normal: fn(&str, &str) -> Result<NormalOptions, AnalysisError>,
    /// Documentation of its options.
    pub options: fn() -> &'static SectionSchema,
    /// Documentation of its results.
    pub results: fn() -> Declared,
}

/// Declares the analyses of a family: name, module with its options, tables, summary, and function.
macro_rules! drive_analyses {
    ($(#[$doc:meta])* $ALL:ident: $Design:ident, $of:literal;
     $($name:literal: $module:ident, $tables:expr, $summary:expr, $run:expr;)*) => {
        $(#[$doc])*
        pub static $ALL: &[DriveAnalysis<$Design>] = &[$(DriveAnalysis {
            name: $name,
            family: <$Design as EccentricDrive>::FAMILY,
            run: |design, options, origin, host| {
                Ok(Box::new($run(design, &$module::Options::parse(options, origin)?, host)?))
            },
            normal: |options, origin| Ok(NormalOptions::of(&$module::Options::parse(options, origin)?)),
            options: <$module::Options as OptionSet>::schema,
            results: || Declared {
                analysis: concat!($name, " of ", $of),
                about: $module::ABOUT,
                tables: $tables,
                summary: $summary.quantities(),
            },
        },)*];
    };
}

drive_analyses! {
    /// Analyses of single stages.
    ALL: StageDesign, "a single stage";
    "check": check, check::drive_tables(), check::summary_of::<StageDesign>(), run_check;
    "profile": profile, profile::tables(), profile::SUMMARY, run_profile;
    "contact": contact, contact::tables::<StageDesign>(), contact::summary::<StageDesign>(), contact::run;
    "wear": wear, wear::tables::<StageDesign>(), wear::summary::<StageDesign>(), wear::run;
    "calibrate": calibrate, calibrate::tables(), calibrate::SUMMARY, calibrate::run;
    "rig": rig, rig::tables(), rig::summary::<StageDesign>(), rig::run;
    "simulate": simulate, simulate::tables(), simulate::SUMMARY, simulate::run;
    "life": life, life::tables::<StageDesign>(), life::summary::<StageDesign>(), life::run;
}

drive_analyses! {
    /// Analyses of drives of two rings.
    TWO_RING: TwoRingDesign, "a drive of two rings";
    "check": check, check::drive_tables(), check::summary_of::<TwoRingDesign>(), run_check;
    "profile": profile, flanks::tables::<TwoRingDesign>(), flanks::summary::<TwoRingDesign>(), flanks::run;
    "contact": contact, contact::tables::<TwoRingDesign>(), contact::summary::<TwoRingDesign>(), contact::run;
    "wear": wear, wear::tables::<TwoRingDesign>(), wear::summary::<TwoRingDesign>(), wear::run;
    "calibrate": calibrate, calibrate::tables(), calibrate::SUMMARY, calibrate::run;
    "rig": rig, rig::tables(), rig::summary::<TwoRingDesign>(), rig::run;
    "simulate": simulate, simulate::tables(), simulate::SUMMARY, simulate::run;
    "life": life, life::tables::<TwoRingDesign>(), life::summary::<TwoRingDesign>(), life::run;
}

drive_analyses! {
    /// Analyses of two stages in series.
    TWO_STAGE: TwoStageDesign, "a drive of two stages";
    "check": check, check::drive_tables(), check::summary_of::<TwoStageDesign>(), run_check;
    "profile": profile, flanks::tables::<TwoStageDesign>(), flanks::summary::<TwoStageDesign>(), flanks::run;
    "contact": contact, contact::tables::<TwoStageDesign>(), contact::summary::<TwoStageDesign>(), contact::run;
    "wear": wear, wear::tables::<TwoStageDesign>(), wear::summary::<TwoStageDesign>(), wear::run;
    "calibrate": calibrate, calibrate::tables(), calibrate::SUMMARY, calibrate::run;
    "rig": rig, rig::tables(), rig::summary::<TwoStageDesign>(), rig::run;
    "simulate": simulate, simulate::tables(), simulate::SUMMARY, simulate::run;
    "life": life, life::tables::<TwoStageDesign>(), life::summary::<TwoStageDesign>(), life::run;
}

/// Documentation of the results of all families but RV reducers.
pub fn declared() -> Vec<Declared> {
    let single = ALL.iter().map(|analysis| (analysis.results)());
    let two_ring = TWO_RING.iter().map(|analysis| (analysis.results)());
    let two_stage = TWO_STAGE.iter().map(|analysis| (analysis.results)());
    single.chain(two_ring).chain(two_stage).collect()
}

fn run_check<D: EccentricDrive>(
    design: &D,
    options: &check::Options,
    _: &dyn Host,
) -> Result<check::Check, AnalysisError> {
    Ok(check::Check::of_drive(design, options))
}

fn run_profile(
    design: &StageDesign,
    options: &profile::Options,
    _: &dyn Host,
) -> Result<profile::FlankProfile, AnalysisError> {
    let (stage, name) = (design.drive(), design.name.value.clone());
    Ok(profile::flank(stage.profile.clone(), &stage.relief, design.ratio(), name, options))
}

fn of<D>(
    all: &'static [DriveAnalysis<D>],
    analysis: &Analysis,
) -> Result<&'static DriveAnalysis<D>, AnalysisError> {
    let known = all.iter().find(|known| known.name == analysis.name);
    known.ok_or_else(|| not_for(analysis.name, all[0].family, &names(all)))
}

fn names<D>(all: &[DriveAnalysis<D>]) -> Vec<&'static str> {
    all.iter().map(|known| known.name).collect()
}

/// The error for an analysis that a family does not have; `names` are those that it has.
fn not_for(what: &str, family: Family, names: &[&str]) -> AnalysisError {
    AnalysisError::usage(
        format!("`{what}` is for RV reducers only, and the file describes a {}", family.drive()),
        format!(
            "{} can be used with the commands {}, study, explore, robot, import and export",
            family.drives(),
            names.join(", ")
        ),
    )
}

/// Facts of a drive that its results and reports need.
#[derive(Debug, Clone)]
pub(super) struct Facts {
    name: String,
    family: Family,
    ratio: f64,
    limits: Limits,
    stages: &'static [StageKeys],
    /// Ring partner (pins or teeth) of the discs of each stage.
    rings: Vec<RingPartner>,
    /// The same of all stages together.
    ring: RingPartner,
}

impl Facts {
    fn of<D: EccentricDrive>(design: &D) -> Facts {
        let mountings = || design.meshes().into_iter().map(|mesh| mesh.mounting);
        Facts {
            name: design.name().to_owned(),
            family: D::FAMILY,
            ratio: design.ratio(),
            limits: design.limits(),
            stages: D::STAGES,
            rings: mountings().map(|mounting| RingPartner::of([mounting])).collect(),
            ring: RingPartner::of(mountings()),
        }
    }

    /// Name of a part by its number in all stages.
    fn name_of(&self, number: usize, part: &PartKeys) -> &'static str {
        match (number % 3, self.rings[number / 3]) {
            (RING, RingPartner::Teeth) => part.tooth,
            _ => part.name,
        }
    }
}

/// Parts of all stages with their numbers: 3 × number of the stage + number in the stage.
fn parts(stages: &'static [StageKeys]) -> impl Iterator<Item = (usize, &'static PartKeys)> {
    let of_stage = |(k, stage): (usize, &'static StageKeys)| {
        let parts = stage.parts.iter().enumerate();
        parts.filter_map(move |(part, keys)| Some((3 * k + part, keys.as_ref()?)))
    };
    stages.iter().enumerate().flat_map(of_stage)
}

/// Joints of a single stage, with the words of RV reducers for the available models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StageJoints {
    /// Bearings with clearance, as for RV reducers.
    Bearings,
}

impl Choice for StageJoints {
    const WORDS: &'static [(&'static str, &'static str)] =
        &[("bearings", "all joints with their clearances and compliance; single stages have no other model")];
    const VALUES: &'static [StageJoints] = &[StageJoints::Bearings];
}

/// Bodies of a single stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StageBodies {
    /// Shafts, carrier and ring are rigid.
    Rigid,
}

impl Choice for StageBodies {
    const WORDS: &'static [(&'static str, &'static str)] =
        &[("rigid", "shafts, carrier and ring are rigid; the discs are elastic with discs = elastic")];
    const VALUES: &'static [StageBodies] = &[StageBodies::Rigid];
}

/// Difference of the largest and the smallest value over a turn.
fn peak_to_peak(values: impl Iterator<Item = f64>) -> f64 {
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    let [low, high] = values.fold(ends, |[low, high], value| [low.min(value), high.max(value)]);
    high - low
}
