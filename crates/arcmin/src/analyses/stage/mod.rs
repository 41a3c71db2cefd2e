//! Analyses of single stages (family `eccentric`) and of other drives of eccentrics, by the names that they have for RV
//! reducers.

mod any;
mod bearings;
pub mod calibrate;
pub mod contact;
#[cfg(test)]
mod difference_tests;
mod drive;
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

pub use drive::{EccentricDrive, Efficiency};
use keys::{ECCENTRIC, OUTPUT, OfParts, PartKeys, RING, StageKeys};
pub(super) use made::DRIVES;
use made::MadePlay;
use meshing::Rests;
#[cfg(test)]
pub(crate) use meshing::{followers, rings};
pub use strength::Strength;

use super::{Analysis, AnalysisError, Host, NormalOptions, Outcome, check, identity, profile};
use crate::design::{
    Choice, Design, DesignError, Family, OptionSet, SectionSchema, StageDesign, TwoRingDesign, TwoStageDesign,
};
use crate::machine::{Limits, RingPartner};
use crate::report::{Block, Column as Head, Table};
use crate::results::{Column, Declared, PLAIN, Value, decimals, digits, quantity};
use crate::units::{ARCMIN, UM};

/// A design of any family.
#[derive(Debug, Clone)]
pub enum AnyDesign {
    /// RV reducer.
    Rv(Box<Design>),
    /// Single stage.
    Eccentric(Box<StageDesign>),
    /// Drive of two rings.
    TwoRing(Box<TwoRingDesign>),
    /// Drive of two stages.
    TwoStage(Box<TwoStageDesign>),
}

impl AnyDesign {
    /// Reads a design file of any family; `file_name` only serves messages.
    ///
    /// # Errors
    /// As [`Design::parse`].
    pub fn parse(text: &str, file_name: &str) -> Result<AnyDesign, Box<DesignError>> {
        Ok(match Family::of_text(text, file_name)? {
            Family::Rv => AnyDesign::Rv(Box::new(Design::parse(text, file_name)?)),
            Family::Eccentric => AnyDesign::Eccentric(Box::new(StageDesign::parse(text, file_name)?)),
            Family::TwoRing => AnyDesign::TwoRing(Box::new(TwoRingDesign::parse(text, file_name)?)),
            Family::TwoStage => AnyDesign::TwoStage(Box::new(TwoStageDesign::parse(text, file_name)?)),
        })
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
            AnyDesign::Eccentric(design) => (of(ALL, analysis)?.run)(design, options, origin, host),
            AnyDesign::TwoRing(design) => (of(TWO_RING, analysis)?.run)(design, options, origin, host),
            AnyDesign::TwoStage(design) => (of(TWO_STAGE, analysis)?.run)(design, options, origin, host),
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
        if let AnyDesign::Rv(design) = self {
            return identity::identity(analysis, design, options, origin, host);
        }
        let normal = self.normal_options(analysis, options, origin)?;
        identity::identity_of(analysis.name, &self.canonical(), &normal, Vec::new(), host)
    }
}

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

/// Declares what a family is asked: name, module with its options, tables, summary, and the function that answers.
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

/// The words of what a family is not asked; `names` are the analyses that it is asked.
fn not_for(what: &str, family: Family, names: &[&str]) -> AnalysisError {
    AnalysisError::usage(
        format!("`{what}` computes RV reducers only, and the file describes a {}", family.drive()),
        format!(
            "{} are known to the commands {}, study, explore, robot, import and export",
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
    /// Against what the discs of each stage run.
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

    /// Name of a part by its number among those of all stages.
    fn name_of(&self, number: usize, part: &PartKeys) -> &'static str {
        match (number % 3, self.rings[number / 3]) {
            (RING, RingPartner::Teeth) => part.tooth,
            _ => part.name,
        }
    }
}

/// Parts of all stages with their numbers: 3 times that of the stage, and that in the stage.
fn parts(stages: &'static [StageKeys]) -> impl Iterator<Item = (usize, &'static PartKeys)> {
    let of_stage = |(k, stage): (usize, &'static StageKeys)| {
        let parts = stage.parts.iter().enumerate();
        parts.filter_map(move |(part, keys)| Some((3 * k + part, keys.as_ref()?)))
    };
    stages.iter().enumerate().flat_map(of_stage)
}

/// Joints of a single stage: the words of RV reducers, as far as there are such models.
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
    /// Rigid but for their contacts.
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

/// Two-sided play at the output by part in rad, input held.
#[derive(Debug, Clone)]
pub struct Play {
    stages: &'static [StageKeys],
    parts: Vec<OfParts>,
}

/// In which order the parts of a stage are named.
const IN_ORDER: [usize; 3] = [RING, ECCENTRIC, OUTPUT];

impl Play {
    pub(super) fn of<D: EccentricDrive>(design: &D) -> Play {
        Play { stages: D::STAGES, parts: design.play() }
    }

    /// Sum over parts and stages, rad.
    pub fn total(&self) -> f64 {
        self.parts.iter().flatten().sum()
    }

    /// Of a part by its number.
    fn part(&self, number: usize) -> f64 {
        self.parts[number / 3][number % 3]
    }
}

/// Parts with their numbers, in the order in which a play is told.
fn told(stages: &'static [StageKeys]) -> impl Iterator<Item = (usize, &'static PartKeys)> {
    (0..stages.len()).flat_map(move |k| {
        IN_ORDER.iter().filter_map(move |part| Some((3 * k + part, stages[k].parts[*part].as_ref()?)))
    })
}

/// Results that have a play by part.
pub(super) trait HasPlay {
    fn play(&self) -> Option<&Play>;
}

/// The entries of a summary for the play by part.
pub(super) fn play_entries<O: HasPlay, D: EccentricDrive>() -> Vec<Column<O>> {
    let part = |o: &O, number: usize| Value::from(o.play().map(|play| play.part(number) / ARCMIN));
    let total = quantity(
        "play_chain.total_arcmin",
        decimals(3),
        "Sum of the play by part of the new drive: a lower bound of its play.",
    );
    told(D::STAGES)
        .map(|(number, keys)| Column::numbered(keys.play, number, part))
        .chain([total.of(|o: &O| Value::from(o.play().map(|play| play.total() / ARCMIN)))])
        .collect()
}

/// The entries of a summary for what parts bear, empty where it is not known.
pub(super) fn strength_entries() -> Vec<Column<check::Check>> {
    fn heat(outcome: &check::Check, of: fn(&strength::HeatBalance) -> f64) -> Value {
        let heat = outcome.strength.as_ref().and_then(|strength| strength.heat.as_ref().ok());
        Value::from(heat.map(of))
    }
    vec![
        quantity(
            "strength.first",
            PLAIN,
            "The part that yields first as the torque rises, and how it is loaded.",
        )
        .of(|o: &check::Check| {
            let first = o.strength.as_ref().and_then(|strength| strength.order().into_iter().next());
            Value::from(first.map(|first| first.borne.bearing.words(first.borne.ring).join(", ")))
        }),
        quantity("strength.first_torque_n_m", digits(4), "Output torque at which it yields.").of(|o| {
            let first = o.strength.as_ref().and_then(|strength| strength.order().into_iter().next());
            Value::from(first.and_then(|first| first.torque))
        }),
        quantity(
            "strength.order",
            PLAIN,
            "All parts in the order in which they yield, with the columns of strength.csv.",
        )
        .of(|o| o.strength.as_ref().map_or(Value::List(Vec::new()), strength::Strength::order_value)),
        quantity("heat.loss_w", digits(4), "Mean loss over the duty, without a motor.")
            .of(|o| heat(o, |heat| heat.loss)),
        quantity(
            "heat.temperature_c",
            decimals(1),
            "Temperature at which this loss and that of a motor leave the surface, by [thermal].",
        )
        .of(|o| heat(o, |heat| heat.temperature)),
    ]
}

/// The entries of a summary for the play as made, empty where the design gives no tolerances.
pub(super) fn made_entries() -> Vec<Column<check::Check>> {
    fn in_um(outcome: &check::Check, share: f64) -> Value {
        let depth = outcome.made.as_ref().and_then(|made| made.overlaps.quantile(share));
        Value::from(depth.map(|depth| depth / UM))
    }
    fn made(outcome: &check::Check, of: fn(&MadePlay) -> Option<f64>) -> Value {
        made::in_arcmin(outcome.made.as_ref().and_then(of))
    }
    vec![
        quantity(
            "play_as_made.nominal_arcmin",
            decimals(3),
            "Two-sided play of the drive without errors, the least over a turn of the output, by the gaps of all contacts.",
        )
        .of(|o| made(o, |made| made.nominal)),
        quantity(
            "play_as_made.systematic_arcmin",
            decimals(3),
            "The same with the systematic deviations of [process], without scatter. Empty where there are none, and where the drive then jams.",
        )
        .of(|o| made(o, |made| made.systematic.flatten())),
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
            "play_as_made.overlap_median_um",
            decimals(2),
            "Depth that would have to come off all flanks and walls of holes alike for a drive that jams to go together: half of these drives need more.",
        )
        .of(|o| in_um(o, 0.5)),
        quantity("play_as_made.overlap_high_um", decimals(2), "5 % of the drives that jam need more.")
            .of(|o| in_um(o, 0.95)),
        quantity(
            "play_as_made.overlap_place",
            PLAIN,
            "Where most of them overlap: ring pins (ring teeth of a ring of one piece), output pins, or both where neither alone is enough.",
        )
        .of(|o| {
            let found = o.made.as_ref().and_then(|made| Some((made.overlaps.place()?.0, made.ring)));
            Value::from(found.map(|(place, ring)| place.words(ring)))
        }),
        quantity(
            "play_as_made.tighten_first",
            PLAIN,
            "The tolerance without which most of the variance of the play goes.",
        )
        .of(|o| {
            let first = o.made.as_ref().and_then(|made| made.tolerances.first());
            Value::from(first.map(made::ToleranceShare::path))
        }),
    ]
}

pub(super) fn play_sentence(play: &Play) -> String {
    let arcmin = |angle: f64| format!("{:.2}′", angle / ARCMIN);
    let parts: Vec<String> = told(play.stages)
        .map(|(number, keys)| format!("{} {}", keys.short, arcmin(play.part(number))))
        .collect();
    format!(
        "play of the new drive at the output, input held: {} = {}",
        arcmin(play.total()),
        parts.join(" + ")
    )
}

pub(super) fn play_table(play: &Play) -> Block {
    let row = |name: &str, value: f64| {
        let share = if play.total() > 0.0 { 100.0 * value / play.total() } else { 0.0 };
        vec![name.to_owned(), format!("{:.3}", value / ARCMIN), format!("{share:.0}")]
    };
    let parts = told(play.stages).map(|(number, keys)| row(keys.gap, play.part(number)));
    Block::Table(Table {
        title: "Play of the new drive at the output by part".to_owned(),
        columns: vec![Head::text("Part"), Head::number("Two-sided play", "arcmin"), Head::number("Share", "%")],
        rows: parts.chain([row("together", play.total())]).collect(),
        note: "Input held, nominal dimensions. The sum is a lower bound: with all gaps open a disc also shifts along its \
               eccentric, and output pins give up to 1/cos(π/z_w) more by position."
            .to_owned(),
    })
}
