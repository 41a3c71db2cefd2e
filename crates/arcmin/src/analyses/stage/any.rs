//! Designs of any family: keys, options and results of their analyses.

use super::keys::main_of;
use super::{ALL, EccentricDrive, TWO_RING, TWO_STAGE, names, not_for, of};
use crate::analyses::{Analysis, AnalysisError, Host, NormalOptions, Outcome, identity};
use crate::checks::{Finding, check_design};
use crate::design::{
    Design, DesignError, Family, KeyEntry, MeasuredFlank, SectionSchema, StageDesign, TwoRingDesign,
    TwoStageDesign, Unknown, Value,
};
use crate::exchange::{DesignedFlank, DimensionedDesign, JointRating};
use crate::geometry::{Profile, Relief};
use crate::machine::{DutyPoint, Limits, RingMesh};
use crate::results::Declared;
use crate::scene::{self, Scene};

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

    /// As [`identity`](crate::analyses::identity()).
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

impl From<Design> for AnyDesign {
    fn from(design: Design) -> AnyDesign {
        AnyDesign::Rv(Box::new(design))
    }
}

/// Designs are equal if their files are.
impl PartialEq for AnyDesign {
    fn eq(&self, other: &AnyDesign) -> bool {
        self.text() == other.text()
    }
}

/// Flanks ring by ring with their sections of errors and of the disc, and the number of the one whose keys have no
/// prefix.
fn designed_flanks<D: EccentricDrive>(
    design: &D,
    sections: &[[&'static str; 2]],
) -> (Vec<DesignedFlank>, usize) {
    let rings = design.meshes().into_iter().zip(design.part_counts()).zip(sections);
    let flanks = rings.map(|((mesh, counts), keys)| DesignedFlank::in_ring(&mesh, counts.discs, *keys));
    (flanks.collect(), main_of(D::STAGES))
}

/// Calls the same method of the design of any family.
macro_rules! each {
    ($any:expr, $design:ident => $answer:expr) => {
        match $any {
            AnyDesign::Rv($design) => $answer,
            AnyDesign::Eccentric($design) => $answer,
            AnyDesign::TwoRing($design) => $answer,
            AnyDesign::TwoStage($design) => $answer,
        }
    };
}

impl AnyDesign {
    /// Name from the design file.
    pub fn name(&self) -> &str {
        each!(self, design => &design.name)
    }

    /// Description from the design file; empty without one.
    pub fn description(&self) -> &str {
        each!(self, design => &design.description)
    }

    /// Measured flanks, each a file beside the design file; only RV reducers have them.
    pub fn measured_flanks(&self) -> Vec<MeasuredFlank> {
        match self {
            AnyDesign::Rv(design) => design.measured_flanks(),
            _ => Vec::new(),
        }
    }

    /// Kind of the drive.
    pub fn family(&self) -> Family {
        match self {
            AnyDesign::Rv(_) => Family::Rv,
            AnyDesign::Eccentric(_) => Family::Eccentric,
            AnyDesign::TwoRing(_) => Family::TwoRing,
            AnyDesign::TwoStage(_) => Family::TwoStage,
        }
    }

    /// As [`Design::hash`].
    pub fn hash(&self) -> String {
        each!(self, design => design.hash())
    }

    /// As [`Design::canonical`].
    pub fn canonical(&self) -> String {
        each!(self, design => design.canonical())
    }

    /// As [`check_design`].
    pub fn findings(&self) -> Vec<Finding> {
        match self {
            AnyDesign::Rv(design) => check_design(design),
            AnyDesign::Eccentric(design) => design.findings(),
            AnyDesign::TwoRing(design) => design.findings(),
            AnyDesign::TwoStage(design) => design.findings(),
        }
    }

    /// Limits in SI units.
    pub fn limits(&self) -> Limits {
        match self {
            AnyDesign::Rv(design) => *design.machine().limits(),
            AnyDesign::Eccentric(design) => design.limits(),
            AnyDesign::TwoRing(design) => design.limits(),
            AnyDesign::TwoStage(design) => design.limits(),
        }
    }

    /// As [`Design::text`].
    pub fn text(&self) -> &str {
        each!(self, design => design.text())
    }

    /// As [`Design::to_toml`].
    pub fn to_toml(&self) -> String {
        self.text().to_owned()
    }

    /// As [`Design::file_name`].
    pub fn file_name(&self) -> &str {
        each!(self, design => design.file_name())
    }

    /// As [`Design::short_hash`].
    pub fn short_hash(&self) -> String {
        self.hash()[..12].to_owned()
    }

    /// As [`Design::defaulted`].
    pub fn defaulted(&self) -> Vec<String> {
        each!(self, design => design.defaulted())
    }

    /// As [`Design::keys`].
    pub fn keys(&self) -> Vec<KeyEntry> {
        each!(self, design => design.keys())
    }

    /// As [`Design::get`].
    ///
    /// # Errors
    /// As there.
    pub fn get(&self, path: &str) -> Result<Value, Box<DesignError>> {
        each!(self, design => design.get(path))
    }

    /// As [`Design::with`]. The family stays: to change `drive.family` is an error.
    ///
    /// # Errors
    /// As there.
    pub fn with(&self, path: &str, value: impl Into<Value>) -> Result<AnyDesign, Box<DesignError>> {
        self.with_all([(path, value)])
    }

    /// As [`Design::with_all`].
    ///
    /// # Errors
    /// As there.
    pub fn with_all<P: AsRef<str>, V: Into<Value>>(
        &self,
        changes: impl IntoIterator<Item = (P, V)>,
    ) -> Result<AnyDesign, Box<DesignError>> {
        Ok(match self {
            AnyDesign::Rv(design) => AnyDesign::Rv(Box::new(design.with_all(changes)?)),
            AnyDesign::Eccentric(design) => AnyDesign::Eccentric(Box::new(design.with_all(changes)?)),
            AnyDesign::TwoRing(design) => AnyDesign::TwoRing(Box::new(design.with_all(changes)?)),
            AnyDesign::TwoStage(design) => AnyDesign::TwoStage(Box::new(design.with_all(changes)?)),
        })
    }

    /// Whether drives can be drawn from its tolerances.
    pub fn has_tolerances(&self) -> bool {
        match self {
            AnyDesign::Rv(design) => design.drawing_tolerances().is_some(),
            AnyDesign::Eccentric(design) => design.tolerances().is_some(),
            AnyDesign::TwoRing(design) => design.tolerances().is_some(),
            AnyDesign::TwoStage(design) => design.tolerances().is_some(),
        }
    }

    /// As [`Design::unknowns`].
    pub fn unknowns(&self) -> Vec<Unknown> {
        each!(self, design => design.unknowns())
    }

    /// The same without `[unknowns]`.
    ///
    /// # Errors
    /// As [`Design::with`].
    pub fn without_unknowns(&self) -> Result<AnyDesign, Box<DesignError>> {
        self.with("unknowns", Value::LeftOut)
    }

    /// The RV reducer.
    ///
    /// # Errors
    /// The error of a computation for RV reducers only, for another drive.
    pub fn rv(&self, what: &str) -> Result<&Design, AnalysisError> {
        match self {
            AnyDesign::Rv(design) => Ok(design),
            _ => Err(self.for_rv_only(what)),
        }
    }

    /// The error for an analysis that this family does not have.
    fn for_rv_only(&self, what: &str) -> AnalysisError {
        let names = match self {
            AnyDesign::Rv(_) => Vec::new(),
            AnyDesign::Eccentric(_) => names(ALL),
            AnyDesign::TwoRing(_) => names(TWO_RING),
            AnyDesign::TwoStage(_) => names(TWO_STAGE),
        };
        not_for(what, self.family(), &names)
    }

    /// The flank of a disc as cut, and its relief: for two rings the flank in the ring at rest, for two stages that
    /// of the stage at the output.
    pub fn flank(&self) -> (Profile, Relief) {
        let of_mesh = |mesh: &RingMesh| (mesh.profile.clone(), mesh.relief.clone());
        match self {
            AnyDesign::Rv(design) => {
                let machine = design.machine();
                (machine.profile(), machine.designed_relief())
            }
            AnyDesign::Eccentric(design) => of_mesh(&design.drive().mesh),
            AnyDesign::TwoRing(design) => of_mesh(&design.drive().meshes[0]),
            AnyDesign::TwoStage(design) => of_mesh(&design.drive().second.mesh),
        }
    }

    /// The flank of a measured disc, in a ring or stage by its number from the input; by default that of `[disc]`.
    ///
    /// # Errors
    /// [`AnalysisError::Usage`] for a ring or stage that the drive does not have.
    pub fn designed_flank(&self, stage: Option<usize>) -> Result<DesignedFlank, AnalysisError> {
        let (mut flanks, main) = match self {
            AnyDesign::Rv(design) => (vec![DesignedFlank::from(&design.machine())], 0),
            AnyDesign::Eccentric(design) => designed_flanks(&**design, &[["errors", "disc"]]),
            AnyDesign::TwoRing(design) => {
                designed_flanks(&**design, &[["errors", "disc"], ["second_errors", "second_disc"]])
            }
            AnyDesign::TwoStage(design) => {
                designed_flanks(&**design, &[["first_stage.errors", "first_stage.disc"], ["errors", "disc"]])
            }
        };
        let number = stage.unwrap_or(main);
        if number >= flanks.len() {
            let message = format!("a {} has no ring or stage {}", self.family().drive(), number + 1);
            return Err(AnalysisError::usage(message, format!("the last is {}", flanks.len())));
        }
        Ok(flanks.swap_remove(number))
    }

    /// Rating as a joint.
    pub fn joint_rating(&self) -> JointRating {
        let of = |ratio: f64, rated: DutyPoint| JointRating {
            ratio,
            torque: rated.torque.abs(),
            input_speed: rated.input_speed.abs(),
        };
        match self {
            AnyDesign::Rv(design) => JointRating::from(&design.machine()),
            AnyDesign::Eccentric(design) => of(EccentricDrive::ratio(&**design), design.rated()),
            AnyDesign::TwoRing(design) => of(EccentricDrive::ratio(&**design), design.rated()),
            AnyDesign::TwoStage(design) => of(EccentricDrive::ratio(&**design), design.rated()),
        }
    }

    /// A drawing in SVG whose dimension lines are labelled with keys and values of the design.
    pub fn dimension_drawing(&self) -> String {
        each!(self, design => design.dimension_drawing())
    }

    /// The drive as solids that move.
    pub fn scene(&self) -> Scene {
        match self {
            AnyDesign::Rv(design) => scene::of_machine(&design.machine()),
            AnyDesign::Eccentric(design) => scene::of_stage(design),
            AnyDesign::TwoRing(design) => scene::of_two_rings(design),
            AnyDesign::TwoStage(design) => scene::of_two_stages(design),
        }
    }

    /// Options that an analysis takes of this family.
    ///
    /// # Errors
    /// [`AnalysisError`] if this family does not have the analysis.
    pub fn options(&self, analysis: &Analysis) -> Result<&'static SectionSchema, AnalysisError> {
        match self {
            AnyDesign::Rv(_) => Ok((analysis.options)()),
            AnyDesign::Eccentric(_) => of(ALL, analysis).map(|analysis| (analysis.options)()),
            AnyDesign::TwoRing(_) => of(TWO_RING, analysis).map(|analysis| (analysis.options)()),
            AnyDesign::TwoStage(_) => of(TWO_STAGE, analysis).map(|analysis| (analysis.options)()),
        }
    }

    /// As [`Analysis::normal_options`].
    ///
    /// # Errors
    /// As there; and where this family does not have the analysis.
    pub fn normal_options(
        &self,
        analysis: &Analysis,
        options: &str,
        origin: &str,
    ) -> Result<NormalOptions, AnalysisError> {
        match self {
            AnyDesign::Rv(_) => analysis.normal_options(options, origin),
            AnyDesign::Eccentric(_) => (of(ALL, analysis)?.normal)(options, origin),
            AnyDesign::TwoRing(_) => (of(TWO_RING, analysis)?.normal)(options, origin),
            AnyDesign::TwoStage(_) => (of(TWO_STAGE, analysis)?.normal)(options, origin),
        }
    }

    /// Documentation of the results of an analysis.
    ///
    /// # Errors
    /// [`AnalysisError`] if this family does not have the analysis.
    pub fn results(&self, analysis: &Analysis) -> Result<Declared, AnalysisError> {
        match self {
            AnyDesign::Rv(_) => Ok((analysis.results)()),
            AnyDesign::Eccentric(_) => of(ALL, analysis).map(|analysis| (analysis.results)()),
            AnyDesign::TwoRing(_) => of(TWO_RING, analysis).map(|analysis| (analysis.results)()),
            AnyDesign::TwoStage(_) => of(TWO_STAGE, analysis).map(|analysis| (analysis.results)()),
        }
    }
}
