//! Analyses of single stages (family `eccentric`), by the names that they have for RV reducers.

mod any;
pub mod contact;
mod findings;
pub mod life;
pub mod made;
mod meshing;
pub mod rig;
#[cfg(test)]
mod tests;
pub mod wear;

pub use findings::findings;
use made::MadePlay;
use meshing::Rests;

use super::{Analysis, AnalysisError, Host, NormalOptions, Outcome, check, identity, profile};
use crate::checks::{Finding, check_design};
use crate::design::{Choice, Design, DesignError, Family, OptionSet, SectionSchema, StageDesign};
use crate::machine::PlayChain;
use crate::report::{Block, Column as Head, Table};
use crate::results::{Column, Declared, PLAIN, Value, decimals, quantity};
use crate::units::ARCMIN;

/// A design of any family.
#[derive(Debug, Clone)]
pub enum AnyDesign {
    Rv(Box<Design>),
    Eccentric(Box<StageDesign>),
}

impl AnyDesign {
    /// Reads a design file of any family; `file_name` only serves messages.
    ///
    /// # Errors
    /// As [`Design::parse`].
    pub fn parse(text: &str, file_name: &str) -> Result<AnyDesign, Box<DesignError>> {
        match Family::of_text(text, file_name)? {
            Family::Rv => Design::parse(text, file_name).map(|design| AnyDesign::Rv(Box::new(design))),
            Family::Eccentric => {
                StageDesign::parse(text, file_name).map(|design| AnyDesign::Eccentric(Box::new(design)))
            }
        }
    }

    pub fn name(&self) -> &str {
        match self {
            AnyDesign::Rv(design) => &design.name,
            AnyDesign::Eccentric(design) => &design.name,
        }
    }

    /// As [`Design::hash`].
    pub fn hash(&self) -> String {
        match self {
            AnyDesign::Rv(design) => design.hash(),
            AnyDesign::Eccentric(design) => design.hash(),
        }
    }

    /// As [`check_design`].
    pub fn findings(&self) -> Vec<Finding> {
        match self {
            AnyDesign::Rv(design) => check_design(design),
            AnyDesign::Eccentric(design) => findings(design),
        }
    }

    /// As [`Analysis::run`].
    ///
    /// # Errors
    /// As there; and where this family does not have the analysis.
    pub fn run(
        &self,
        analysis: &Analysis,
        options: &str,
        origin: &str,
        host: &dyn Host,
    ) -> Result<Box<dyn Outcome>, AnalysisError> {
        match self {
            AnyDesign::Rv(design) => analysis.run(design, options, origin, host),
            AnyDesign::Eccentric(design) => (of(analysis)?.run)(design, options, origin, host),
        }
    }

    /// As [`identity`](super::identity()).
    ///
    /// # Errors
    /// As there; and where this family does not have the analysis.
    pub fn identity(
        &self,
        analysis: &Analysis,
        options: &str,
        origin: &str,
        host: &dyn Host,
    ) -> Result<String, AnalysisError> {
        match self {
            AnyDesign::Rv(design) => identity::identity(analysis, design, options, origin, host),
            AnyDesign::Eccentric(design) => {
                let normal = (of(analysis)?.normal)(options, origin)?;
                identity::identity_of(analysis.name, &design.canonical(), &normal, Vec::new(), host)
            }
        }
    }
}

/// An analysis of a single stage.
pub struct StageAnalysis {
    pub name: &'static str,
    run: fn(&StageDesign, &str, &str, &dyn Host) -> Result<Box<dyn Outcome>, AnalysisError>,
    normal: fn(&str, &str) -> Result<NormalOptions, AnalysisError>,
    /// Documentation of its options.
    pub options: fn() -> &'static SectionSchema,
    /// Documentation of its results.
    pub results: fn() -> Declared,
}

/// Declares the analyses: name, module with its declarations, summary, tables, and the function that answers.
macro_rules! stage_analyses {
    ($($name:literal: $module:ident, $summary:ident, $tables:ident, $run:expr;)*) => {
        /// What single stages are asked.
        pub static ALL: &[StageAnalysis] = &[$(StageAnalysis {
            name: $name,
            run: |design, options, origin, host| {
                Ok(Box::new($run(design, &$module::Options::parse(options, origin)?, host)?))
            },
            normal: |options, origin| Ok(NormalOptions::of(&$module::Options::parse(options, origin)?)),
            options: <$module::Options as OptionSet>::schema,
            results: || Declared {
                analysis: concat!($name, " of a single stage"),
                about: $module::ABOUT,
                tables: $module::$tables(),
                summary: $module::$summary.quantities(),
            },
        },)*];
    };
}

stage_analyses! {
    "check": check, STAGE_SUMMARY, stage_tables, run_check;
    "profile": profile, SUMMARY, tables, run_profile;
    "contact": contact, SUMMARY, tables, contact::run;
    "wear": wear, SUMMARY, tables, wear::run;
    "rig": rig, SUMMARY, tables, rig::run;
    "life": life, SUMMARY, tables, life::run;
}

fn run_check(
    design: &StageDesign,
    options: &check::Options,
    _: &dyn Host,
) -> Result<check::Check, AnalysisError> {
    let (mut findings, made) = (findings(design), MadePlay::of(design));
    findings.extend(made.as_ref().map(MadePlay::finding));
    Ok(check::Check::of(findings, Some((design.play_chain(), made)), &design.name, options))
}

fn run_profile(
    design: &StageDesign,
    options: &profile::Options,
    _: &dyn Host,
) -> Result<profile::FlankProfile, AnalysisError> {
    let (stage, name) = (design.stage(), design.name.value.clone());
    Ok(profile::flank(stage.profile.clone(), &stage.relief, design.ratio(), name, options))
}

fn of(analysis: &Analysis) -> Result<&'static StageAnalysis, AnalysisError> {
    ALL.iter().find(|known| known.name == analysis.name).ok_or_else(|| rv_only(analysis.name))
}

fn rv_only(what: &str) -> AnalysisError {
    AnalysisError::usage(
        format!("`{what}` computes RV reducers only, and the file describes a single stage"),
        format!(
            "single stages are known to the commands {}, study, explore and export profile",
            ALL.iter().map(|known| known.name).collect::<Vec<_>>().join(", ")
        ),
    )
}

/// Joints of a single stage: the words of RV reducers, as far as there are such models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StageJoints {
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
    Rigid,
}

impl Choice for StageBodies {
    const WORDS: &'static [(&'static str, &'static str)] =
        &[("rigid", "discs, shafts and ring are rigid; single stages have no other model")];
    const VALUES: &'static [StageBodies] = &[StageBodies::Rigid];
}

/// Of values over a turn.
fn peak_to_peak(values: impl Iterator<Item = f64>) -> f64 {
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    let [low, high] = values.fold(ends, |[low, high], value| [low.min(value), high.max(value)]);
    high - low
}

/// What has a play by part.
pub(super) trait HasPlay {
    fn play_chain(&self) -> Option<PlayChain>;
}

/// The entries of a summary for the play by part.
pub(super) fn play_entries<O: HasPlay>() -> Vec<Column<O>> {
    vec![
        quantity(
            "play_chain.ring_arcmin",
            decimals(3),
            "Two-sided play at the output by the gap between ring pins and flank, input held: 2Δ/(e z_c) for an even gap Δ.",
        )
        .of(|o: &O| part(o, |play| play.ring)),
        quantity(
            "play_chain.eccentric_bearing_arcmin",
            decimals(3),
            "Two-sided play by the radial clearance c of the eccentric bearing: 2c/(e z_c).",
        )
        .of(|o| part(o, |play| play.eccentric_bearing)),
        quantity(
            "play_chain.output_arcmin",
            decimals(3),
            "Two-sided play by the clearance δ of the output pins in their holes: 2δ/R_w where a pin stands across the eccentric.",
        )
        .of(|o| part(o, |play| play.output)),
        quantity("play_chain.total_arcmin", decimals(3), "Sum of the three: a lower bound of the play.")
            .of(|o| part(o, PlayChain::total)),
    ]
}

/// The entries of a summary for the play as made, empty where the design gives no tolerances.
pub(super) fn made_entries() -> Vec<Column<check::Check>> {
    fn made(outcome: &check::Check, of: fn(&MadePlay) -> Option<f64>) -> Value {
        made::in_arcmin(outcome.made.as_ref().and_then(of))
    }
    vec![
        quantity(
            "play_as_made.nominal_arcmin",
            decimals(3),
            "Two-sided play of the drive without errors, the least over a turn of the output, by the gaps of every pin.",
        )
        .of(|o| made(o, |made| made.nominal)),
        quantity(
            "play_as_made.mean_arcmin",
            decimals(3),
            "The same of drives drawn from the tolerances: mean of those that do not jam.",
        )
        .of(|o| made(o, |made| made.drawn.mean())),
        quantity("play_as_made.low_arcmin", decimals(3), "5 % of these drives have less.")
            .of(|o| made(o, |made| made.drawn.quantile(0.05))),
        quantity("play_as_made.high_arcmin", decimals(3), "5 % of these drives have more.")
            .of(|o| made(o, |made| made.drawn.quantile(0.95))),
        quantity(
            "play_as_made.jam_rate",
            decimals(4),
            "Share of the drawn drives that go together by force only: at some position no place of the discs leaves all gaps open.",
        )
        .of(|o| Value::from(o.made.as_ref().map(|made| made.drawn.jam_rate))),
        quantity(
            "play_as_made.tighten_first",
            PLAIN,
            "The tolerance without which most of the variance of the play goes.",
        )
        .of(|o| {
            let first = o.made.as_ref().and_then(|made| made.tolerances.first());
            Value::from(first.map(|one| format!("tolerances.{}", one.key)))
        }),
    ]
}

fn part<O: HasPlay>(outcome: &O, of: fn(&PlayChain) -> f64) -> Value {
    Value::from(outcome.play_chain().map(|play| of(&play) / ARCMIN))
}

const PARTS: [(&str, fn(&PlayChain) -> f64); 4] = [
    ("gap between ring pins and flank", |play| play.ring),
    ("clearance of the eccentric bearing", |play| play.eccentric_bearing),
    ("clearance of the output pins in their holes", |play| play.output),
    ("together", PlayChain::total),
];

pub(super) fn play_sentence(play: &PlayChain) -> String {
    let arcmin = |angle: f64| format!("{:.2}′", angle / ARCMIN);
    format!(
        "play at the output, input held: {} = ring {} + eccentric bearing {} + output pins {}",
        arcmin(play.total()),
        arcmin(play.ring),
        arcmin(play.eccentric_bearing),
        arcmin(play.output)
    )
}

pub(super) fn play_table(play: &PlayChain) -> Block {
    let row = |(name, of): &(&str, fn(&PlayChain) -> f64)| {
        let value = of(play);
        let share = if play.total() > 0.0 { 100.0 * value / play.total() } else { 0.0 };
        vec![(*name).to_owned(), format!("{:.3}", value / ARCMIN), format!("{share:.0}")]
    };
    Block::Table(Table {
        title: "Play at the output by part".to_owned(),
        columns: vec![Head::text("Part"), Head::number("Two-sided play", "arcmin"), Head::number("Share", "%")],
        rows: PARTS.iter().map(row).collect(),
        note: "Input held, nominal dimensions. The sum is a lower bound: with all gaps open a disc also shifts along its \
               eccentric, and the output pins give up to 1/cos(π/z_w) more by position."
            .to_owned(),
    })
}

impl StageDesign {
    /// Play at the output by part, input held.
    pub fn play_chain(&self) -> PlayChain {
        let (play, factor) = (self.stage().play_chain(), self.seen_from_ring());
        PlayChain {
            ring: factor * play.ring,
            eccentric_bearing: factor * play.eccentric_bearing,
            output: factor * play.output,
        }
    }
}
