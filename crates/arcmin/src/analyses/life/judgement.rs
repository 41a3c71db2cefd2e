//! Second judgement of the same machine, with elastic bodies.

use super::band::{Band, Inputs, LimitsOf};
use super::bearings::{self, bearing_lives};
use super::demands::Demands;
use super::record::Record;
use super::undecided::{Undecided, undecided};
use super::verdict::Limit;
use super::{Options, emergency_pressure};
use crate::analyses::{AnalysisError, Host};
use crate::checks::Finding;
use crate::design::{Design, Stated};
use crate::fidelity::{DiscBodies, Fidelity, FidelityOptions, FrameBodies, Joints};
use crate::life::{LifeOptions, Prediction, predict};
use crate::machine::Machine;
use crate::wear::CoupledOptions;
use crate::wear::coupled::FOR_TWO_DIGITS;

/// The same machine judged with elastic bodies.
#[derive(Debug, Clone)]
pub struct Judgement {
    /// Wear and accuracy over the hours.
    pub prediction: Prediction,
    /// In the order of the kinds.
    pub limits: Vec<Limit>,
}

/// The judgement with elastic bodies, in addition to the one with rigid bodies.
#[derive(Debug, Clone)]
pub enum WithElasticBodies {
    /// Only one fidelity was requested, or no result that needs both.
    NotAsked,
    /// This machine cannot be judged with elastic bodies; the finding states the reason.
    NoRoom(Finding),
    /// The second judgement.
    Judged(Box<Judgement>),
}

impl WithElasticBodies {
    /// The judgement with elastic bodies, if there is one.
    pub fn judged(&self) -> Option<&Judgement> {
        match self {
            WithElasticBodies::Judged(judgement) => Some(judgement),
            WithElasticBodies::NotAsked | WithElasticBodies::NoRoom(_) => None,
        }
    }

    /// From a second judgement. If it was impossible, the reason is a finding, and the result with rigid bodies remains.
    ///
    /// # Errors
    /// [`AnalysisError::Stopped`] when the host requested it.
    fn of(judged: Result<Judgement, AnalysisError>) -> Result<Self, AnalysisError> {
        match judged {
            Ok(judgement) => Ok(WithElasticBodies::Judged(Box::new(judgement))),
            Err(AnalysisError::Stopped) => Err(AnalysisError::Stopped),
            Err(error) => Ok(WithElasticBodies::NoRoom(no_room(&error))),
        }
    }

    /// Limits that are kept in only one of both judgements.
    pub(super) fn undecided(&self, rigid: &[Limit], service_h: f64) -> Vec<Undecided> {
        self.judged().map_or_else(Vec::new, |judged| undecided(rigid, &judged.limits, service_h))
    }

    /// Adds the reason why the machine was not judged with elastic bodies.
    pub(super) fn note(&self, findings: &mut Vec<Finding>) {
        if let WithElasticBodies::NoRoom(finding) = self {
            findings.push(finding.clone());
        }
    }
}

/// Times between new and the end of the service life: enough to judge the limits.
const INTERVALS: usize = 10;
/// Crank positions at each time; the largest force and pressure are refined in addition.
const POSITIONS: usize = 18;

/// Steps of the wear and times of the second judgement: an update with elastic bodies takes about twenty times as long.
fn second_settings() -> LifeOptions {
    LifeOptions {
        wear: CoupledOptions { few_places: FOR_TWO_DIGITS, ..CoupledOptions::default() },
        intervals: INTERVALS,
        crank_positions: POSITIONS,
        causes: false,
        ..LifeOptions::default()
    }
}

/// Whether both kinds of bodies are needed: the options name none, and the undecided limits are requested.
pub(super) fn needs_both(options: &FidelityOptions, host: &dyn Host) -> bool {
    let open = !options.bodies.is_written
        && options.discs.value == DiscBodies::Rigid
        && options.joints.value == Joints::Bearings;
    open && host.needs("verdict.undecided")
}

/// Judges the machine with elastic bodies.
///
/// # Errors
/// As [`WithElasticBodies::of`].
pub(super) fn judge_elastic(
    design: &Design,
    machine: &Machine,
    options: &Options,
    findings: &[Finding],
    inputs: Option<&Inputs>,
    host: &dyn Host,
) -> Result<WithElasticBodies, AnalysisError> {
    let bodies = Stated { value: FrameBodies::Elastic, is_written: true };
    let words = FidelityOptions { bodies, vtu: false, ..options.fidelity.clone() };
    WithElasticBodies::of(judge(design, machine, &words, findings, inputs, host))
}

fn judge(
    design: &Design,
    machine: &Machine,
    words: &FidelityOptions,
    findings: &[Finding],
    inputs: Option<&Inputs>,
    host: &dyn Host,
) -> Result<Judgement, AnalysisError> {
    let fidelity = Fidelity::resolve(design, words, host)?;
    let settings = LifeOptions { travel: machine.limits.backlash.is_some(), ..second_settings() };
    let prediction = predict(machine, &fidelity, settings, host, |_| ())?;
    let bearings = bearing_lives(machine, &fidelity.joint_settings()?, bearings::POSITIONS)?;
    let emergency = emergency_pressure(machine, &fidelity, &prediction)?;
    let record = Record::of(Demands::of(machine), &prediction, &bearings, findings, emergency);
    let (limits, _) = banded(&[record], &alone, inputs);
    Ok(Judgement { prediction, limits })
}

/// Limits of the only ring.
pub(super) fn alone(records: &[Record]) -> Vec<Limit> {
    records.first().map(Record::limits).unwrap_or_default()
}

/// The limits of the records of all rings with their bands, and the band of the first of them.
pub(in crate::analyses) fn banded(
    records: &[Record],
    limits_of: LimitsOf<'_>,
    inputs: Option<&Inputs>,
) -> (Vec<Limit>, Option<Band>) {
    let limits = limits_of(records);
    let Some(bands) = inputs.and_then(|inputs| inputs.bands(records, limits_of)) else {
        return (limits, None);
    };
    let limits = limits.into_iter().zip(bands.limits);
    let limits = limits.map(|(limit, band)| Limit { band: Some(band), ..limit }).collect();
    (limits, Some(bands.first))
}

fn no_room(error: &AnalysisError) -> Finding {
    Finding::warning(
        "elastic-bodies",
        format!("judged with rigid bodies alone: {error}"),
        "discs, carrier and housing of real machines deform (with stiff crankshafts a machine is about twice as stiff \
         without that), so that lost motion and pressures are underestimated and lives overestimated",
        "give [carrier.solid] and [housing.solid] dimensions that leave room for pillars between the crankshafts \
         (`arcmin keys carrier.solid`), or choose --bodies rigid",
    )
}
