use std::error::Error;
use std::io::{IsTerminal, Write};
use std::path::PathBuf;

use arcmin::design::DesignError;
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, NamedSource, SourceCode};

/// Why a command could not do what it was asked for; the exit status is 2.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    #[error("{}", .error.kind)]
    Design { error: Box<DesignError>, source_code: NamedSource<String> },
    #[error("cannot read {}: {cause}", .path.display())]
    Read { path: PathBuf, cause: std::io::Error },
    #[error("cannot write {}: {cause}", .path.display())]
    Write { path: PathBuf, cause: std::io::Error },
    #[error("{} exists already", .path.display())]
    Exists { path: PathBuf },
    #[error("no template is called \"{name}\"")]
    UnknownTemplate { name: String },
    #[error("could not {task}: {cause}")]
    Compute { task: &'static str, cause: Box<dyn Error + Send + Sync> },
    #[error("stopped before the end; nothing was written")]
    Cancelled,
    #[error("stopped at t = {time:.6} s; the checkpoint is {}", .path.display())]
    Interrupted { time: f64, path: PathBuf },
    #[error("{message}")]
    Usage { message: String, help: String },
}

impl Failure {
    pub fn design(error: Box<DesignError>, text: &str) -> Failure {
        let source_code = NamedSource::new(error.file_name.clone(), text.to_owned());
        Failure::Design { error, source_code }
    }

    /// Wraps an error of the library: `.map_err(Failure::compute("share the load"))`.
    pub fn compute<E: Error + Send + Sync + 'static>(task: &'static str) -> impl FnOnce(E) -> Failure {
        move |cause| Failure::Compute { task, cause: Box::new(cause) }
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
        if handler.render_report(&mut text, self).is_err() {
            text = format!("{self}\n");
        }
        // Nobody is left to be told if standard error is closed.
        let _ = std::io::stderr().write_all(text.as_bytes());
    }
}

impl Diagnostic for Failure {
    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        let help = match self {
            Failure::Design { error, .. } => return error.hint.as_ref().map(|hint| Box::new(hint) as Box<dyn std::fmt::Display>),
            Failure::Read { cause, .. } if cause.kind() == std::io::ErrorKind::NotFound => {
                "`arcmin new FILE` writes a design file to start from".to_owned()
            }
            Failure::Write { cause, .. } => match cause.kind() {
                std::io::ErrorKind::StorageFull | std::io::ErrorKind::FileTooLarge | std::io::ErrorKind::QuotaExceeded => {
                    "make room or choose another place with --out; results under final names are complete, earlier ones untouched".to_owned()
                }
                _ => "choose another place with --out".to_owned(),
            },
            Failure::Interrupted { .. } => "the same command with --resume goes on from there".to_owned(),
            Failure::Usage { help, .. } => help.clone(),
            Failure::Exists { .. } => "--force overwrites it".to_owned(),
            Failure::UnknownTemplate { .. } => {
                format!("templates are {}", arcmin::templates::TEMPLATES.map(|template| template.name).join(", "))
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
                // What is wrong first stands in the title already.
                let label = |(index, error): (usize, &DesignError)| {
                    let text = match (index, error.hint()) {
                        (0, _) => None,
                        (_, Some(hint)) => Some(format!("{}: {hint}", error.kind)),
                        (_, None) => Some(error.kind.to_string()),
                    };
                    // A label over many lines (a whole section) would bury the message: mark its first line.
                    let first_line = error.text.lines().next().unwrap_or_default().trim_end().len();
                    Some(LabeledSpan::new(text, error.span()?.start, first_line))
                };
                Some(Box::new(error.all().enumerate().filter_map(label)))
            }
            _ => None,
        }
    }
}
