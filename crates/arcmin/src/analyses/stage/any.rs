//! Designs of any family by their keys, and what their analyses take and give.

use super::{AnyDesign, of};
use crate::analyses::{Analysis, AnalysisError, NormalOptions};
use crate::design::{Design, DesignError, KeyEntry, SectionSchema, Unknown, Value};
use crate::geometry::{Profile, Relief};
use crate::results::Declared;

impl From<Design> for AnyDesign {
    fn from(design: Design) -> AnyDesign {
        AnyDesign::Rv(Box::new(design))
    }
}

/// Designs are equal whose files are.
impl PartialEq for AnyDesign {
    fn eq(&self, other: &AnyDesign) -> bool {
        self.text() == other.text()
    }
}

/// The same method of the design, whatever its family.
macro_rules! each {
    ($any:expr, $design:ident => $answer:expr) => {
        match $any {
            AnyDesign::Rv($design) => $answer,
            AnyDesign::Eccentric($design) => $answer,
        }
    };
}

impl AnyDesign {
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
        match self {
            AnyDesign::Rv(design) => design.with_all(changes).map(AnyDesign::from),
            AnyDesign::Eccentric(design) => {
                design.with_all(changes).map(|design| AnyDesign::Eccentric(Box::new(design)))
            }
        }
    }

    /// Whether drives can be drawn from its tolerances.
    pub fn has_tolerances(&self) -> bool {
        match self {
            AnyDesign::Rv(design) => design.drawing_tolerances().is_some(),
            AnyDesign::Eccentric(design) => design.tolerances().is_some(),
        }
    }

    /// As [`Design::unknowns`]; those of single stages are not used.
    pub fn unknowns(&self) -> Vec<Unknown> {
        match self {
            AnyDesign::Rv(design) => design.unknowns(),
            AnyDesign::Eccentric(_) => Vec::new(),
        }
    }

    /// The RV reducer.
    ///
    /// # Errors
    /// The words of what computes RV reducers only, where it is another drive.
    pub fn rv(&self, what: &str) -> Result<&Design, AnalysisError> {
        match self {
            AnyDesign::Rv(design) => Ok(design),
            AnyDesign::Eccentric(_) => Err(super::rv_only(what)),
        }
    }

    /// The flank of a disc as cut, and what is taken off it.
    pub fn flank(&self) -> (Profile, Relief) {
        match self {
            AnyDesign::Rv(design) => {
                let machine = design.machine();
                (machine.profile(), machine.designed_relief())
            }
            AnyDesign::Eccentric(design) => (design.stage().profile.clone(), design.stage().relief.clone()),
        }
    }

    /// Options that an analysis takes of this family.
    ///
    /// # Errors
    /// Where this family does not have the analysis.
    pub fn options(&self, analysis: &Analysis) -> Result<&'static SectionSchema, AnalysisError> {
        match self {
            AnyDesign::Rv(_) => Ok((analysis.options)()),
            AnyDesign::Eccentric(_) => of(analysis).map(|analysis| (analysis.options)()),
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
            AnyDesign::Eccentric(_) => (of(analysis)?.normal)(options, origin),
        }
    }

    /// Documentation of the results of an analysis.
    ///
    /// # Errors
    /// Where this family does not have the analysis.
    pub fn results(&self, analysis: &Analysis) -> Result<Declared, AnalysisError> {
        match self {
            AnyDesign::Rv(_) => Ok((analysis.results)()),
            AnyDesign::Eccentric(_) => of(analysis).map(|analysis| (analysis.results)()),
        }
    }
}
