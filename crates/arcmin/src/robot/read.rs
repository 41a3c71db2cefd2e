//! A robot file as read. The modules below build its arm and its programs.

mod arm;
mod programs;

pub use programs::Program;

use std::ops::Range;

use super::arm::Arm;
use super::file::{JointSection, RobotSections};
use crate::analyses::stage::AnyDesign;
use crate::analyses::{AnalysisError, Host, Origin};
use crate::design::{DesignError, DesignErrorKind, Family, InputFile, Source};
use crate::exchange::JointExport;
use crate::tables::text_of;

type Result<T> = std::result::Result<T, AnalysisError>;

/// Title of a robot file in messages.
const TITLE: &str = "the robot file";

/// A robot file as read.
#[derive(Debug, Clone)]
pub struct RobotFile {
    sections: RobotSections,
    text: String,
    file_name: String,
}

impl std::ops::Deref for RobotFile {
    type Target = RobotSections;

    fn deref(&self) -> &RobotSections {
        &self.sections
    }
}

/// Source of a reducer's data.
#[derive(Debug, Clone)]
pub enum Reducer {
    Design(Box<AnyDesign>),
    Table(Box<JointExport>),
}

impl RobotFile {
    /// Reads a robot file; `file_name` is used in messages only.
    ///
    /// # Errors
    /// All unknown keys; otherwise the first value that is missing, of the wrong type or out of range.
    pub fn parse(text: &str, file_name: &str) -> std::result::Result<RobotFile, Box<DesignError>> {
        let source = Source { text, file_name, title: TITLE };
        let tree = crate::design::field::parse(&source)?;
        let sections: RobotSections = crate::design::field::read(&tree, &source)?;
        Ok(RobotFile { sections, text: text.to_owned(), file_name: file_name.to_owned() })
    }

    /// Text of the file as it was read.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Name of the file as given by the caller.
    pub fn file_name(&self) -> &str {
        &self.file_name
    }

    /// All values that affect results, independent of layout and comments.
    pub fn canonical(&self) -> String {
        use crate::design::field::SectionValue;
        let mut lines = Vec::new();
        self.sections.canonical_fields("", &mut lines);
        lines.retain(|line| !line.starts_with("description = "));
        lines.join("\n")
    }

    pub(super) fn wrong(
        &self,
        message: impl Into<String>,
        span: Option<Range<usize>>,
        hint: impl Into<String>,
    ) -> AnalysisError {
        let source = Source { text: &self.text, file_name: &self.file_name, title: TITLE };
        let kind = DesignErrorKind::Contradiction { message: message.into() };
        source.error(kind, span.unwrap_or(0..0), Some(hint.into())).into()
    }

    fn names<'a>(&self, arm: &'a Arm) -> Vec<&'a str> {
        arm.axes.iter().map(|axis| &axis.name[..]).collect()
    }

    /// The section of each axis.
    ///
    /// # Errors
    /// An axis without a section.
    pub fn joints(&self, arm: &Arm) -> Result<Vec<&JointSection>> {
        arm.axes
            .iter()
            .map(|axis| {
                let found = self.joint.iter().find(|section| *section.axis.value == axis.name);
                found.map(|section| &section.value.0).ok_or_else(|| {
                    let message = format!("the axis \"{}\" has no reducer", axis.name);
                    let hint = "add [[joint]] with axis = \"…\" and design = \"…\" (or table = \"…\")";
                    self.wrong(message, None, hint)
                })
            })
            .collect()
    }

    /// Design or table of a joint.
    ///
    /// # Errors
    /// Files that cannot be read; neither of the two, or both.
    pub fn reducer(&self, section: &JointSection, host: &dyn Host) -> Result<Reducer> {
        let input = |file: &InputFile, line: Option<usize>, message: String, help: &str| {
            AnalysisError::Input { file: file.0.clone(), line, message, help: help.to_owned() }
        };
        match (&*section.design, &*section.table) {
            (Some(file), None) => {
                let bytes = host.read(file, Origin::Design)?;
                let text = text_of(&bytes)
                    .map_err(|kind| input(file, None, kind.to_string(), "save it as UTF-8"))?;
                // An error of the design refers to its own file, whose text is not in the robot file.
                let design = AnyDesign::parse(&text, &file.0).map_err(|error| {
                    let help = error.hint().unwrap_or("run `arcmin check` on this design");
                    input(file, error.line(), error.kind.to_string(), help)
                })?;
                if let (Some(_), false) = (*section.mounting, design.family() == Family::Rv) {
                    let message = format!("a {} has the mounting of its design", design.family().drive());
                    let hint = "remove `mounting`; the fixed member of a single stage is `fixed_member` in its design";
                    return Err(self.wrong(message, section.mounting.span.clone(), hint));
                }
                Ok(Reducer::Design(Box::new(design)))
            }
            (None, Some(file)) => {
                let bytes = host.read(file, Origin::Design)?;
                let text = String::from_utf8_lossy(&bytes);
                let export = JointExport::from_json(&text).map_err(|error| {
                    let help = "give the joint.json that `arcmin export joint` writes";
                    input(file, Some(error.line()), format!("no table of a joint: {error}"), help)
                })?;
                if section.mounting.is_some() {
                    let message = "a table contains the mounting of the joint at its export";
                    let hint = "remove `mounting`, or give the design";
                    return Err(self.wrong(message, section.mounting.span.clone(), hint));
                }
                Ok(Reducer::Table(Box::new(export)))
            }
            (None, None) => {
                let message = format!("the joint \"{}\" has neither design nor table", *section.axis);
                Err(self.wrong(message, section.axis.span.clone(), "add design = \"…\", or table = \"…\""))
            }
            (Some(_), Some(_)) => {
                let message = format!("the joint \"{}\" has a design and a table", *section.axis);
                Err(self.wrong(message, section.table.span.clone(), "keep one of them"))
            }
        }
    }
}
