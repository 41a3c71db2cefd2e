//! The study of Tao2024 on any design: uniform depths, static and dynamic transmission error, every figure of the
//! paper beside the computed one.

mod declared;
mod flank;
mod load;
mod motion;
mod page;
mod paper;
#[cfg(test)]
mod tests;

pub(crate) use declared::{SUMMARY, tables};

use super::simulate::dynamics;
use super::{AnalysisError, Attachment, Host, elastic_disc, outcome};
use crate::design::{Design, default, optional, options};
use crate::dynamics::{
    RunResult, StudyPoint, StudySettings, TransmissionErrorStudy, flexible_transmission_error_study,
    transmission_error_study,
};
use crate::fidelity::{Fidelity, FidelityOptions, Joints};
use crate::geometry::Relief;
use crate::life::{Accuracy, PaperStudy, Travel, paper_depths, paper_study};
use crate::load::closed_form::{self, ClosedForm};
use crate::machine::Machine;
use crate::report::Section;
use crate::units::{ARCMIN, UM};

pub(crate) const ABOUT: &str =
    "Repeat the study of Tao2024: uniform wear, static and dynamic transmission error";
pub(crate) const GUIDE: &str = "Repeats the study of Tao, Liu, Wu, Zheng and Pei (Machines 2024, 12(8), 511) for any design: flanks \
    with uniform wear of 0, 10, …, 60 µm, hours by the wear rule of the paper, and the multibody model \
    without load (STE) and under a sinusoidal load (DTE), with rigid discs and, with --discs elastic, \
    elastic ones. The report contains Figures 4 and 7 to 19 and Tables 1 to 3 with the numbers of the \
    paper beside ours.\n\nJoints are ideal, as in the paper. For the wear of a machine in bearings use \
    `arcmin life`.";
pub(crate) const EXAMPLES: &[&str] =
    &["arcmin tao2024 my-reducer.toml", "arcmin tao2024 my-reducer.toml --discs elastic"];

options! {
    /// Options of `tao2024`.
    pub struct Options {
        [fidelity: FidelityOptions]
        /// Number of perturbed starts that give the spread of every run without load.
        starts: usize => default(4.0, 0.0, 1000.0),
        /// Leave out the multibody runs (STE and DTE).
        quasi_static: bool => optional(0.0, 0.0),
    }
}

/// Crank positions at which accuracy is evaluated.
const POSITIONS: usize = 36;

/// The study.
#[derive(Debug, Clone)]
pub struct Tao2024 {
    /// Machine of the study, joints ideal.
    pub machine: Machine,
    /// Joints, bodies and errors.
    pub fidelity: Fidelity,
    /// Wear levels from new on.
    pub levels: Vec<Level>,
    /// Wear coefficient in 1/Pa; `None` if the closed form did not converge.
    pub coefficient: Option<f64>,
    /// Reason if there are no hours.
    pub unsettled: Option<String>,
    elastic: Option<Section>,
}

/// One uniform depth.
#[derive(Debug, Clone)]
pub struct Level {
    /// By the paper's wear rule, in h.
    pub hours: Option<f64>,
    /// In m.
    pub depth: f64,
    /// Errors under load, forces and pressures.
    pub accuracy: Accuracy,
    /// Free travel and play.
    pub travel: Travel,
    /// Load sharing in closed form, if it converges.
    pub handbook: Option<ClosedForm>,
    /// Multibody runs with rigid discs.
    pub rigid: Option<StudyPoint>,
    /// Multibody runs with elastic discs.
    pub flexible: Option<StudyPoint>,
}

/// Mean and maximum of |TE| over the steady part of a run, in arcmin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanAndMax {
    /// Mean of |TE|.
    pub mean: f64,
    /// Largest |TE|.
    pub max: f64,
}

impl MeanAndMax {
    fn of(result: &RunResult) -> Option<MeanAndMax> {
        result.statistics.map(|te| MeanAndMax { mean: te.mean_abs / ARCMIN, max: te.max_abs / ARCMIN })
    }
}

impl Level {
    /// Uniform depth in µm.
    pub fn depth_um(&self) -> f64 {
        self.depth / UM
    }

    /// Without load, rigid discs.
    pub fn ste_rigid(&self) -> Option<MeanAndMax> {
        MeanAndMax::of(&self.rigid.as_ref()?.no_load)
    }

    /// Under load, rigid discs.
    pub fn dte_rigid(&self) -> Option<MeanAndMax> {
        MeanAndMax::of(&self.rigid.as_ref()?.loaded)
    }

    /// Without load, elastic discs.
    pub fn ste_flexible(&self) -> Option<MeanAndMax> {
        MeanAndMax::of(&self.flexible.as_ref()?.no_load)
    }

    /// Under load, elastic discs.
    pub fn dte_flexible(&self) -> Option<MeanAndMax> {
        MeanAndMax::of(&self.flexible.as_ref()?.loaded)
    }
}

/// Repeats the study.
///
/// # Errors
/// [`AnalysisError`] where no load sharing is found or the host stops it. If the closed form does not converge, the
/// hours and the figures that need it are missing, which the report states.
pub fn run(design: &Design, options: &Options, host: &dyn Host) -> Result<Tao2024, AnalysisError> {
    if options.fidelity.joints.value == Joints::Bearings {
        return Err(AnalysisError::usage(
            "the study of Tao2024 supports ideal joints only",
            "leave joints out; for the machine in bearings use `arcmin life`",
        ));
    }
    let machine = design.machine();
    let fidelity = Fidelity::resolve(design, &options.fidelity, host)?;
    let depths = paper_depths();
    let study = paper_study(&machine, &depths, POSITIONS).map_err(AnalysisError::wear("share the load"))?;
    let wear: Vec<Relief> = depths.iter().map(|depth| Relief::uniform(*depth)).collect();
    let (rigid, flexible) = if options.quasi_static || !declared::needs_runs(host) {
        (None, None)
    } else {
        let settings = StudySettings { perturbed_starts: options.starts, ..StudySettings::tao2024(&machine) };
        let rigid = transmission_error_study(&machine, &wear, &settings, host)
            .map_err(dynamics("simulate the transmission error"))?;
        (Some(rigid), simulate_elastic(&machine, &fidelity, &wear, &settings, host)?)
    };
    let elastic = elastic_disc::section(&machine, &fidelity)?;
    Ok(assemble(machine, fidelity, study, rigid, flexible, elastic))
}

fn simulate_elastic(
    machine: &Machine,
    fidelity: &Fidelity,
    wear: &[Relief],
    settings: &StudySettings,
    host: &dyn Host,
) -> Result<Option<TransmissionErrorStudy>, AnalysisError> {
    let Some(elastic) = &fidelity.elastic else { return Ok(None) };
    let settings = StudySettings { perturbed_starts: 0, ..settings.clone() };
    let (discs, modes) = (elastic.reduced(), elastic.dynamics());
    flexible_transmission_error_study(machine, discs, modes, wear, &settings, host)
        .map(Some)
        .map_err(dynamics("simulate the elastic discs"))
}

fn assemble(
    machine: Machine,
    fidelity: Fidelity,
    study: PaperStudy,
    rigid: Option<TransmissionErrorStudy>,
    flexible: Option<TransmissionErrorStudy>,
    elastic: Option<Section>,
) -> Tao2024 {
    let mut rigid = rigid.map(|study| study.points.into_iter());
    let mut flexible = flexible.map(|study| study.points.into_iter());
    let levels = study
        .points
        .into_iter()
        .map(|(depth, accuracy, travel)| Level {
            hours: study.wear.as_ref().ok().map(|_| accuracy.hours),
            depth,
            handbook: closed_form::solve(&machine, machine.rated.torque.abs(), depth).ok(),
            accuracy,
            travel,
            rigid: rigid.as_mut().and_then(Iterator::next),
            flexible: flexible.as_mut().and_then(Iterator::next),
        })
        .collect();
    let (coefficient, unsettled) = match study.wear {
        Ok(wear) => (Some(wear.exposure.coefficient), None),
        Err(error) => (None, Some(error.to_string())),
    };
    Tao2024 { machine, fidelity, levels, coefficient, unsettled, elastic }
}

outcome!(Tao2024 {
    fn attachments(&self) -> Result<Vec<Attachment>, AnalysisError> {
        elastic_disc::attachments(&self.machine, &self.fidelity)
    }
});
