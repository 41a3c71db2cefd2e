//! Runs of analyses, and their results.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use arcmin::analyses::{AnalysisError, Outcome as Answer, by_name};
use arcmin::checks::Severity;
use arcmin::report::{Block, Page, Provenance};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};
use serde_json::{Value as Json, json};

use crate::design::Design;
use crate::host::{ORIGIN, PyHost, Question};
use crate::table::Table;
use crate::{errors, inputs, work};

/// Result of an analysis, the data of ``arcmin.Result``.
#[pyclass(module = "arcmin", frozen)]
pub struct Outcome {
    question: Arc<Question>,
    host: Arc<PyHost>,
    answer: Arc<dyn Answer>,
    tables: OnceLock<Py<PyList>>,
}

/// Runs the analysis with this name.
///
/// `options` are those of the command, `files` the contents of files by the names used in the options;
/// `threads` is the number of threads for its parallel parts; `progress` is called with stage and share (0…1)
/// from the calling thread. The interpreter lock is released during the computation.
#[pyfunction]
#[pyo3(signature = (name, design, options, files, threads = None, progress = None))]
pub fn run(
    py: Python<'_>,
    name: &str,
    design: &Bound<'_, Design>,
    options: &Bound<'_, PyDict>,
    files: HashMap<String, Vec<u8>>,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Outcome> {
    let Some(analysis) = by_name(name) else {
        return Err(PyValueError::new_err(format!("there is no analysis \"{name}\"")));
    };
    let now = design.get().now();
    let schema = now.options(analysis).map_err(|error| errors::analysis(py, &error, None))?;
    let options = inputs::options_text(schema, options)?;
    let question = Arc::new(Question { analysis, design: now, options });
    let host = Arc::new(PyHost::new(design.get().directory(), files).about(question.clone()));
    let (asked, hears) = (question.clone(), host.clone());
    let answer = work::wait_for(py, &host, threads, progress, move || {
        asked.design.run(asked.analysis, &asked.options, ORIGIN, &*hears)
    })?
    .map_err(|error| errors::analysis(py, &error, Some(&question.design)))?;
    Ok(Outcome { question, host, answer: answer.into(), tables: OnceLock::new() })
}

impl Outcome {
    /// Longer work on the result: drawing its page, writing a mesh.
    fn compute<T: Send + 'static>(
        &self,
        py: Python<'_>,
        what: impl FnOnce(&dyn Answer) -> Result<T, AnalysisError> + Send + 'static,
    ) -> PyResult<T> {
        let answer = self.answer.clone();
        let host = Arc::new(PyHost::default());
        work::wait_for(py, &host, None, None, move || what(&*answer))?
            .map_err(|error| errors::analysis(py, &error, Some(&self.question.design)))
    }
}

/// The plot for notebooks: the first of the page.
fn main_plot(page: &Page) -> Json {
    let blocks = page.sections.iter().flat_map(|section| &section.blocks);
    let plot = blocks.into_iter().find_map(|block| match block {
        Block::Plot(plot) => Some(plot),
        _ => None,
    });
    plot.map_or(Json::Null, |plot| serde_json::to_value(plot).unwrap_or(Json::Null))
}

#[pymethods]
impl Outcome {
    /// Name of the command.
    #[getter]
    fn analysis(&self) -> &'static str {
        self.question.analysis.name
    }

    /// Its results, nested as in `summary.json`.
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let question = &self.question;
        let mut summary = self.compute(py, |answer| Ok(answer.summary().to_json()))?;
        let identity = self.host.identity().map_err(|error| errors::analysis(py, &error, None))?;
        let findings = question.design.findings();
        let errors = findings.iter().filter(|finding| finding.severity == Severity::Error).count();
        let design = &question.design;
        summary.insert("arcmin_version".to_owned(), json!(env!("CARGO_PKG_VERSION")));
        summary.insert("command".to_owned(), json!(question.analysis.name));
        summary.insert("identity".to_owned(), json!(identity));
        summary.insert(
            "design".to_owned(),
            json!({ "name": design.name(), "hash": design.hash(), "short_hash": design.short_hash() }),
        );
        summary.insert("error_findings".to_owned(), json!(errors));
        inputs::json_object(py, &Json::Object(summary))
    }

    /// Its tables.
    fn tables(&self, py: Python<'_>) -> PyResult<Py<PyList>> {
        if let Some(tables) = self.tables.get() {
            return Ok(tables.clone_ref(py));
        }
        let filled = self.compute(py, |answer| Ok(answer.tables()))?;
        let made = PyList::new(
            py,
            filled
                .into_iter()
                .map(Table::of)
                .map(|table| Py::new(py, table))
                .collect::<PyResult<Vec<_>>>()?,
        )?;
        Ok(self.tables.get_or_init(|| made.unbind()).clone_ref(py))
    }

    /// Reason why it was not completed, or None.
    #[getter]
    fn failure(&self) -> Option<String> {
        self.answer.failure()
    }

    /// Text printed by the command.
    fn text(&self, py: Python<'_>) -> PyResult<String> {
        self.compute(py, |answer| Ok(arcmin_cli::terminal_text(&answer.text_blocks())))
    }

    /// The report as one HTML page; `call` is the text of the call.
    fn html(&self, py: Python<'_>, call: String) -> PyResult<String> {
        let design_hash = self.question.design.short_hash();
        self.compute(py, move |answer| {
            let mut page = answer.page();
            page.provenance = Provenance {
                version: env!("CARGO_PKG_VERSION").to_owned(),
                design_hash,
                command: call,
                seeds: answer.seeds(),
            };
            Ok(page.render())
        })
    }

    /// Headline, key results and main plot, for notebooks.
    fn glance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let glance = self.compute(py, |answer| {
            let page = answer.page();
            let figures: Vec<Json> = page
                .verdict
                .figures
                .iter()
                .map(|figure| {
                    json!({ "label": figure.label, "value": figure.value, "unit": figure.unit,
                            "note": figure.note, "tone": figure.tone })
                })
                .collect();
            Ok(json!({
                "title": page.title,
                "subtitle": page.subtitle,
                "headline": page.verdict.headline,
                "tone": page.verdict.tone,
                "figures": figures,
                "answers": page.verdict.answers,
                "plot": main_plot(&page),
            }))
        })?;
        inputs::json_object(py, &glance)
    }

    /// Further files by name: a mesh for ParaView.
    fn attachments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for attachment in self.compute(py, |answer| answer.attachments())? {
            all.set_item(attachment.name, PyBytes::new(py, &attachment.bytes))?;
        }
        Ok(all)
    }
}
