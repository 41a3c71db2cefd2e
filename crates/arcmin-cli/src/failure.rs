use std::io::{IsTerminal, Write};
use std::path::PathBuf;

use arcmin::analyses::AnalysisError;
use arcmin::checks::Finding;
use arcmin::design::{DesignError, DesignErrorKind, Presence, SectionSchema};
use arcmin::report::is_hidden;
use arcmin::templates::{DRIVES, TEMPLATES, Template};
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, NamedSource, SourceCode};

use crate::arguments::long_name;
use crate::run::visible;

/// Reason why a command has failed.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    #[error("{}", .error.kind)]
    Design { error: Box<DesignError>, source_code: NamedSource<String> },
    #[error("{}", analysis_message(.error, *.options, .finding.as_deref()))]
    Analysis {
        error: AnalysisError,
        options: Option<&'static SectionSchema>,
        /// The first error finding of the design, as the probable cause.
        finding: Option<Box<Finding>>,
    },
    #[error("cannot read {}: {cause}", .path.display())]
    Read {
        path: PathBuf,
        cause: std::io::Error,
        /// The command that writes such a file, if the file does not exist.
        start: Start,
    },
    #[error("cannot write {}: {cause}", .path.display())]
    Write { path: PathBuf, cause: std::io::Error },
    #[error("{} exists already", .path.display())]
    Exists { path: PathBuf },
    #[error("there is no template \"{name}\"")]
    UnknownTemplate { name: String },
    #[error("cannot start the threads: {cause}")]
    Threads { cause: String },
    #[error("cannot write JSON: {cause}")]
    Json { cause: String },
    #[error("the study cannot continue: {cause}")]
    Study { cause: String },
    #[error("stopped before the end; the last checkpoint is kept")]
    Ended,
    #[error("{reason}; results computed before are kept")]
    Unfinished { reason: String },
    #[error("{message}")]
    Usage { message: String, help: String },
}

/// Error findings of a geometry without rolling of the pins: the text of the finding explains more than that of
/// the solver.
const NO_FLANK: [&str; 2] = ["undercut", "root-conformity"];

/// Message in the words of the command line: a string of TOML is the text as typed.
fn analysis_message(
    error: &AnalysisError,
    options: Option<&SectionSchema>,
    finding: Option<&Finding>,
) -> String {
    match error {
        AnalysisError::Compute { task, cause } => match finding {
            // Such a flank has no contact that can be computed.
            Some(finding) if NO_FLANK.contains(&finding.code) => {
                format!("could not {task}: {} ({})", finding.message, finding.code)
            }
            _ => format!("could not {task}: {cause}"),
        },
        AnalysisError::Design(error) => {
            let text = error.kind.to_string();
            let text = match &error.kind {
                DesignErrorKind::WrongType { .. } => text.split(", but here is").next().unwrap_or_default(),
                _ => &text,
            };
            as_typed(text, options)
        }
        AnalysisError::Usage { message, .. } => as_typed(message, options),
        error => error.to_string(),
    }
}

/// A text of the library with its options written as on the command line: `load_file` and `joints = ideal`
/// become `--load-file` and `--joints ideal`.
fn as_typed(text: &str, options: Option<&SectionSchema>) -> String {
    let mut typed = text.to_owned();
    let keys = options.map_or(&[][..], |options| options.keys);
    for key in
        keys.iter().filter(|key| !matches!(key.rule.presence, Presence::Required | Presence::Positional))
    {
        let option = format!("--{}", long_name(key.name));
        typed = typed.replace(&format!("`{}`", key.name), &option);
        typed = typed.replace(&format!("{} = ", key.name), &format!("{option} "));
        typed = typed.replace(&format!("({})", key.name), &format!("({option})"));
        if key.name.contains('_') {
            let is_name = |c: char| c.is_alphanumeric() || c == '_';
            let at = typed.find(key.name).filter(|at| {
                let after = typed[at + key.name.len()..].chars().next();
                !typed[..*at].ends_with(is_name) && !after.is_some_and(is_name)
            });
            if let Some(at) = at {
                typed.replace_range(at..at + key.name.len(), &option);
            }
        }
    }
    typed
}

/// The command that writes a missing file.
#[derive(Debug, Clone, Copy)]
pub enum Start {
    Design,
    Study,
    Robot,
    Elsewhere,
}

impl Start {
    fn help(self) -> &'static str {
        match self {
            Start::Design => "`arcmin new FILE` writes a design file to start from",
            Start::Study => "`arcmin study new FILE` writes a study file to start from",
            Start::Robot => "`arcmin robot new FILE` writes a robot file to start from",
            Start::Elsewhere => "check its name and path",
        }
    }
}

impl Failure {
    pub fn design(error: Box<DesignError>, text: &str) -> Failure {
        let source_code = NamedSource::new(visible(&error.file_name), printable(text));
        Failure::Design { error, source_code }
    }

    /// 1 if the design has error findings, which were printed before; otherwise 2.
    pub fn exit_status(&self) -> u8 {
        match self {
            Failure::Analysis { finding: Some(_), error: AnalysisError::Compute { .. }, .. } => 1,
            _ => 2,
        }
    }

    /// Prints to standard error: in colour on a terminal, plain elsewhere.
    pub fn print(&self) {
        let theme = if std::io::stderr().is_terminal() {
            GraphicalTheme::unicode()
        } else {
            GraphicalTheme::unicode_nocolor()
        };
        let handler = GraphicalReportHandler::new_themed(theme).with_width(100).with_links(false);
        let mut text = String::new();
        if handler.render_report(&mut text, &Shown(self)).is_err() {
            text = format!("{}\n", visible(&self.to_string()));
        }
        // Errors are ignored if standard error is closed.
        let _ = std::io::stderr().write_all(text.as_bytes());
    }
}

/// Prints a warning on standard error.
pub fn warn(line: &str) {
    let _ = writeln!(std::io::stderr(), "{}", visible(line));
}

/// A text of the same length in bytes without control characters except line ends and tabs, so that places in
/// it are unchanged.
fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '\n' | '\t' => shown.push(c),
            '\r' if rest.peek() == Some(&'\n') => shown.push(c),
            c if is_hidden(c) => (0..c.len_utf8()).for_each(|_| shown.push('?')),
            c => shown.push(c),
        }
    }
    shown
}

/// A failure as printed: names from files must not send control characters to the terminal.
#[derive(Debug)]
struct Shown<'a>(&'a Failure);

impl std::fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&visible(&self.0.to_string()))
    }
}

impl std::error::Error for Shown<'_> {}

impl Diagnostic for Shown<'_> {
    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        self.0.help().map(|help| Box::new(visible(&help.to_string())) as _)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.0.source_code()
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.0.labels()
    }
}

impl Diagnostic for Failure {
    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        let help = match self {
            Failure::Design { error, .. } => {
                return error.hint.as_ref().map(|hint| Box::new(hint) as Box<dyn std::fmt::Display>);
            }
            Failure::Analysis { error: AnalysisError::Stopped, .. } => "no results were written".to_owned(),
            Failure::Ended | Failure::Analysis { error: AnalysisError::Interrupted { .. }, .. } => {
                "repeat the command with --resume to continue from there".to_owned()
            }
            Failure::Analysis { error: AnalysisError::Compute { .. }, finding: Some(finding), .. } => {
                finding.change.to_owned()
            }
            Failure::Analysis { error, options, .. } => {
                return error.help().map(|help| Box::new(as_typed(&help, *options)) as _);
            }
            Failure::Read { cause, start, .. } if cause.kind() == std::io::ErrorKind::NotFound => {
                start.help().to_owned()
            }
            Failure::Write { cause, .. } => match cause.kind() {
                std::io::ErrorKind::StorageFull
                | std::io::ErrorKind::FileTooLarge
                | std::io::ErrorKind::QuotaExceeded => {
                    "free disk space or choose another directory with --out; files under their final names are \
                     complete, and earlier results are unchanged"
                        .to_owned()
                }
                _ => "choose another directory with --out".to_owned(),
            },
            Failure::Usage { help, .. } => help.clone(),
            Failure::Exists { .. } => "--force overwrites it".to_owned(),
            Failure::UnknownTemplate { .. } => {
                // A line each: a long one would be wrapped within a name, at its hyphen.
                let names = |all: &[Template]| all.iter().map(|one| one.name).collect::<Vec<_>>().join(", ");
                format!("RV reducers: {}\nother drives: {}", names(&TEMPLATES), names(&DRIVES))
            }
            _ => return None,
        };
        Some(Box::new(help))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        match self {
            Failure::Design { source_code, .. } => Some(source_code),
            _ => None,
        }
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        match self {
            Failure::Design { error, .. } => {
                // The title already states the first error.
                let label = |(index, error): (usize, &DesignError)| {
                    let text = match (index, error.hint()) {
                        (0, _) => None,
                        (_, Some(hint)) => Some(format!("{}: {hint}", error.kind)),
                        (_, None) => Some(error.kind.to_string()),
                    };
                    // A label over many lines (a whole section) would hide the message: only its first line is
                    // marked.
                    let first_line = error.text.lines().next().unwrap_or_default().trim_end().len();
                    Some(LabeledSpan::new(text.as_deref().map(visible), error.span()?.start, first_line))
                };
                Some(Box::new(error.all().enumerate().filter_map(label)))
            }
            _ => None,
        }
    }
}
