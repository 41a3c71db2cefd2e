use std::error::Error;

use crate::design::DesignError;
use crate::load::closed_form::ClosedFormError;
use crate::wear::WearError;

/// Error of an analysis.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// An option, or a key of a design, is wrong.
    #[error("{}", .0.kind)]
    Design(#[from] Box<DesignError>),
    /// A file cannot be used; the line is counted from 1.
    #[error("{file}{}: {message}", .line.map_or(String::new(), |line| format!(", line {line}")))]
    Input {
        /// Name of the file.
        file: String,
        /// Line, counted from 1; `None` for the whole file.
        line: Option<usize>,
        /// Fault in one sentence.
        message: String,
        /// Advice in one sentence.
        help: String,
    },
    /// The options contradict each other, or the design.
    #[error("{message}")]
    Usage {
        /// Fault in one sentence.
        message: String,
        /// Advice in one sentence.
        help: String,
    },
    /// A computation has failed.
    #[error("could not {task}: {cause}")]
    Compute {
        /// Task, as words after "could not".
        task: &'static str,
        /// Error of the computation.
        cause: Box<dyn Error + Send + Sync>,
    },
    /// The host cancelled the analysis.
    #[error("stopped before the end")]
    Stopped,
    /// The host cancelled the analysis, and a checkpoint was stored.
    #[error("stopped at t = {time_s:.6} s")]
    Interrupted {
        /// Time reached.
        time_s: f64,
    },
}

impl AnalysisError {
    /// [`AnalysisError::Usage`] from fault and advice.
    pub fn usage(message: impl Into<String>, help: impl Into<String>) -> AnalysisError {
        AnalysisError::Usage { message: message.into(), help: help.into() }
    }

    /// Wraps an error of a solver: `.map_err(AnalysisError::compute("share the load"))`.
    pub fn compute<E: Error + Send + Sync + 'static>(task: &'static str) -> impl FnOnce(E) -> AnalysisError {
        move |cause| AnalysisError::Compute { task, cause: Box::new(cause) }
    }

    /// As [`AnalysisError::compute`] for the wear, which may have been stopped.
    pub(crate) fn wear(task: &'static str) -> impl FnOnce(crate::wear::WearError) -> AnalysisError {
        move |error| match error {
            crate::wear::WearError::Stopped => AnalysisError::Stopped,
            error => AnalysisError::compute(task)(error),
        }
    }

    /// Remedy in words.
    pub fn help(&self) -> Option<String> {
        match self {
            AnalysisError::Design(error) => error.hint.clone(),
            AnalysisError::Input { help, .. } | AnalysisError::Usage { help, .. } => {
                (!help.is_empty()).then(|| help.clone())
            }
            AnalysisError::Interrupted { .. } => {
                Some("repeat the call with resume to continue from the checkpoint".to_owned())
            }
            AnalysisError::Compute { cause, .. } => {
                let in_closed_form = cause.is::<ClosedFormError>()
                    || matches!(cause.downcast_ref(), Some(WearError::ClosedForm(_)));
                in_closed_form.then(|| {
                    "the closed form has no solution for this machine; use the equilibrium of forces: leave out \
                     the method of `contact` or the mode of `wear`"
                        .to_owned()
                })
            }
            AnalysisError::Stopped => None,
        }
    }
}
