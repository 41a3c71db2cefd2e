//! Errors of the library as the exceptions of `arcmin._errors`.

use arcmin::analyses::AnalysisError;
use arcmin::analyses::stage::AnyDesign;
use arcmin::checks::Severity;
use arcmin::design::{DesignError, DesignErrorKind};
use arcmin::dynamics::DynamicsError;
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple, PyType};

/// One exception class of `arcmin._errors`, with the named details.
fn raised(py: Python<'_>, class: &'static str, message: &str, details: &Bound<'_, PyDict>) -> PyErr {
    static MODULE: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
    let make = || -> PyResult<PyErr> {
        let module =
            MODULE.get_or_try_init(py, || Ok::<_, PyErr>(py.import("arcmin._errors")?.unbind()))?.bind(py);
        let class = module.getattr(class)?.cast_into::<PyType>()?;
        let value = class.call(PyTuple::new(py, [message])?, Some(details))?;
        Ok(PyErr::from_value(value))
    };
    // Only a broken installation can cause another error here, which is then raised.
    make().unwrap_or_else(|error| error)
}

macro_rules! details {
    ($py:expr, $($name:literal: $value:expr),* $(,)?) => {{
        let details = PyDict::new($py);
        // Names and plain values always fit into a dictionary.
        $(let _ = details.set_item($name, $value);)*
        details
    }};
}

/// An error of a design file or of a key.
pub fn design(py: Python<'_>, error: &DesignError) -> PyErr {
    let others: Vec<(Option<usize>, String, Option<&str>)> =
        error.others.iter().map(|other| (other.line(), other.kind.to_string(), other.hint())).collect();
    let details = details!(py,
        "key": error.key(),
        "line": error.line(),
        "column": error.column(),
        "hint": error.hint(),
        "file": &error.file_name,
        "others": others,
    );
    let class = match error.kind {
        DesignErrorKind::UnknownKey { .. } => "UnknownKeyError",
        _ => "DesignError",
    };
    raised(py, class, &error.kind.to_string(), &details)
}

/// An invalid option; its position in the text that was generated from the call is of no use.
fn option(py: Python<'_>, message: &str, key: Option<&str>, hint: Option<&str>) -> PyErr {
    raised(py, "OptionError", message, &details!(py, "key": key, "hint": hint))
}

/// An error of an analysis of this design.
pub fn analysis(py: Python<'_>, error: &AnalysisError, of: Option<&AnyDesign>) -> PyErr {
    match error {
        AnalysisError::Design(inner) => option(py, &inner.kind.to_string(), inner.key(), inner.hint()),
        AnalysisError::Usage { message, help } => option(py, message, None, Some(help)),
        AnalysisError::Input { file, line, message, help } => {
            raised(py, "InputError", message, &details!(py, "file": file, "line": *line, "hint": help))
        }
        AnalysisError::Compute { .. } => compute(py, &error.to_string(), of),
        AnalysisError::Stopped | AnalysisError::Interrupted { .. } => {
            PyKeyboardInterrupt::new_err(error.to_string())
        }
    }
}

/// A computation without a result; error findings of the design are the first cause to check.
pub fn compute(py: Python<'_>, message: &str, of: Option<&AnyDesign>) -> PyErr {
    let findings: Vec<String> = of
        .map(AnyDesign::findings)
        .unwrap_or_default()
        .into_iter()
        .filter(|finding| finding.severity == Severity::Error)
        .map(|finding| format!("{}: {}", finding.code, finding.message))
        .collect();
    raised(py, "ComputeError", message, &details!(py, "findings": findings))
}

/// An error of a stepwise simulation.
pub fn dynamics(py: Python<'_>, error: &DynamicsError) -> PyErr {
    match error {
        DynamicsError::InvalidValue { .. } | DynamicsError::WrongInput { .. } => {
            option(py, &error.to_string(), None, None)
        }
        error => compute(py, &error.to_string(), None),
    }
}

/// A value of the wrong kind for an option or a key.
pub fn value(py: Python<'_>, key: &str, message: &str, is_option: bool) -> PyErr {
    let class = if is_option { "OptionError" } else { "DesignError" };
    raised(py, class, message, &details!(py, "key": key))
}

/// A panic of the library, which is a bug.
pub fn panic(cause: &(dyn std::any::Any + Send)) -> PyErr {
    let text = cause
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| cause.downcast_ref::<String>().cloned())
        .unwrap_or_default();
    PyRuntimeError::new_err(format!("internal error of arcmin, which is a bug: {text}"))
}
