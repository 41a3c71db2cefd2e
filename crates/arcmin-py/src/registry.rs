//! Description of the analyses as data, from which functions, stubs and documentation of the package are
//! generated.

use arcmin::analyses::ALL;
use arcmin::design::{Key, Kind, Presence};
use arcmin::results::Quantity;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// All analyses: name, summary, guide, options and results.
#[pyfunction]
pub fn analyses(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let all = PyList::empty(py);
    for analysis in ALL {
        let declared = (analysis.results)();
        let entry = PyDict::new(py);
        entry.set_item("name", analysis.name)?;
        entry.set_item("about", analysis.about)?;
        entry.set_item("guide", analysis.guide)?;
        entry.set_item("options", each(py, (analysis.options)().keys, option)?)?;
        entry.set_item("summary", each(py, &declared.summary, quantity)?)?;
        let tables = PyList::empty(py);
        for table in &declared.tables {
            let entry = PyDict::new(py);
            entry.set_item("name", table.name)?;
            entry.set_item("what", table.what)?;
            entry.set_item("columns", each(py, &table.columns, quantity)?)?;
            tables.append(entry)?;
        }
        entry.set_item("tables", tables)?;
        all.append(entry)?;
    }
    Ok(all)
}

fn each<'py, T>(
    py: Python<'py>,
    of: &[T],
    make: fn(Python<'py>, &T) -> PyResult<Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for one in of {
        list.append(make(py, one)?)?;
    }
    Ok(list)
}

fn option<'py>(py: Python<'py>, key: &Key) -> PyResult<Bound<'py, PyDict>> {
    let entry = PyDict::new(py);
    entry.set_item("name", key.name)?;
    entry.set_item("documentation", key.doc.split_whitespace().collect::<Vec<_>>().join(" "))?;
    entry.set_item("unit", key.unit())?;
    entry.set_item("required", key.rule.presence == Presence::Required)?;
    let positional = matches!(key.rule.presence, Presence::Required | Presence::Positional);
    entry.set_item("positional", positional)?;
    let (kind, choices) = match (key.kind)() {
        Kind::Number => ("number", None),
        Kind::Count => ("count", None),
        Kind::Flag => ("flag", None),
        Kind::File => ("file", None),
        Kind::Files => ("files", None),
        Kind::Choice(words) => ("choice", Some(words.to_vec())),
        Kind::Texts => ("texts", None),
        Kind::Numbers => ("numbers", None),
        _ => ("text", None),
    };
    entry.set_item("kind", kind)?;
    entry.set_item("choices", choices)?;
    let numeric = matches!((key.kind)(), Kind::Number | Kind::Count);
    entry.set_item("range", numeric.then_some((key.rule.low, key.rule.high)))?;
    match (key.rule.presence, (key.kind)()) {
        (Presence::Number(number), Kind::Count) => entry.set_item("default", number as u64)?,
        (Presence::Number(number), _) => entry.set_item("default", number)?,
        (Presence::Word(word), _) => entry.set_item("default", word)?,
        (Presence::Flag(flag), _) => entry.set_item("default", flag)?,
        (_, Kind::Flag) => entry.set_item("default", false)?,
        _ => entry.set_item("default", py.None())?,
    }
    Ok(entry)
}

fn quantity<'py>(py: Python<'py>, quantity: &Quantity) -> PyResult<Bound<'py, PyDict>> {
    let entry = PyDict::new(py);
    entry.set_item("key", quantity.key)?;
    entry.set_item("unit", quantity.unit())?;
    entry.set_item("what", quantity.what.split_whitespace().collect::<Vec<_>>().join(" "))?;
    Ok(entry)
}
