//! Designs and their keys.

use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};

use arcmin::analyses::stage::AnyDesign as Read;
use arcmin::design::{KeyEntry, Kind, Value};
use arcmin::templates::{self, DRIVES, TEMPLATES};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyList, PyMapping};

use crate::errors;
use crate::flank::Flank;
use crate::inputs::{Given, given, key_object, key_value};

/// A design file: keys with units in their names, read and checked as a whole.
///
/// ``design["crankshafts.eccentricity_mm"]`` is a value in the unit of its key;
/// ``design["crankshafts.eccentricity_mm"] = 1.4`` sets it, with the same checks, message and hint as for a
/// file. Rows of lists are numbered from 0: ``design["duty[0].share"]``. ``None`` removes a key, so that its
/// default applies. Comments and layout of the file are kept (:meth:`to_toml`).
#[pyclass(module = "arcmin", frozen, mapping, weakref)]
pub struct Design {
    read: RwLock<Arc<Read>>,
    /// Directory of the file, to which the paths of other files are relative.
    directory: PathBuf,
}

/// A key of a design with the properties of its declaration.
#[pyclass(module = "arcmin", frozen, get_all)]
pub struct Key {
    /// Dotted path, such as ``duty[0].share``.
    path: String,
    /// Unit for readers; empty for values without one.
    unit: &'static str,
    /// Smallest and largest number allowed, or None.
    range: Option<(f64, f64)>,
    /// Value of a key that is not in the file.
    default: Py<PyAny>,
    /// Whether the section must contain it.
    required: bool,
    /// The allowed words with their meanings, or None.
    choices: Option<Vec<(&'static str, &'static str)>>,
    /// Meaning of the key.
    documentation: String,
    /// Value in this design.
    value: Py<PyAny>,
    /// Whether the file contains it.
    written: bool,
}

#[pymethods]
impl Key {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        Ok(format!("<Key {} = {}{unit}: {}>", self.path, self.value.bind(py).repr()?, self.documentation))
    }
}

impl Design {
    fn of(read: Read, directory: PathBuf) -> Design {
        Design { read: RwLock::new(Arc::new(read)), directory }
    }

    /// The present design, which later changes do not affect.
    pub fn now(&self) -> Arc<Read> {
        self.read.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// An independent design with the same keys.
    pub fn copied(&self) -> Design {
        Design { read: RwLock::new(self.now()), directory: self.directory.clone() }
    }

    pub fn directory(&self) -> &Path {
        &self.directory
    }

    fn set(&self, read: Read) {
        *self.read.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(read);
    }

    fn with(&self, py: Python<'_>, changes: Vec<(String, Value)>) -> PyResult<Read> {
        let now = self.now();
        py.detach(|| now.with_all(changes)).map_err(|error| errors::design(py, &error))
    }
}

/// Shipped designs of all families.
fn shipped() -> impl Iterator<Item = templates::Template> {
    TEMPLATES.into_iter().chain(DRIVES)
}

/// A mapping is expanded to its keys, a list of mappings to its rows.
fn flatten(
    path: &str,
    value: &Bound<'_, PyAny>,
    out: &mut Vec<(String, Value)>,
    depth: usize,
) -> PyResult<()> {
    let wrong = |_| {
        let class =
            value.get_type().fully_qualified_name().map_or_else(|_| String::new(), |name| name.to_string());
        let message = format!("`{path}` takes a number, text, list or mapping, not a {class}");
        errors::value(value.py(), path, &message, false)
    };
    if depth > 8 {
        return Err(errors::value(value.py(), path, "the mappings are nested without end", false));
    }
    match given(value).map_err(wrong)? {
        Given::Table(table) => {
            for (name, inner) in items(&table)? {
                flatten(&format!("{path}.{name}"), &inner, out, depth + 1)?;
            }
            Ok(())
        }
        Given::List(rows) if !rows.is_empty() && rows.iter().all(|row| row.cast::<PyMapping>().is_ok()) => {
            out.push((path.to_owned(), Value::LeftOut));
            for (index, row) in rows.iter().enumerate() {
                flatten(&format!("{path}[{index}]"), row, out, depth + 1)?;
            }
            Ok(())
        }
        plain => {
            out.push((path.to_owned(), key_value(path, plain)?));
            Ok(())
        }
    }
}

fn items<'py>(table: &Bound<'py, PyMapping>) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    let mut items = Vec::new();
    for pair in table.items()?.iter() {
        let (name, value) = pair.extract::<(Bound<'py, PyAny>, Bound<'py, PyAny>)>()?;
        let name = name.extract::<String>().map_err(|_| {
            let class = name.get_type().name().map_or_else(|_| String::new(), |name| name.to_string());
            PyTypeError::new_err(format!("a key is a text like \"ring.pin_radius_mm\", not a {class}"))
        })?;
        items.push((name, value));
    }
    Ok(items)
}

fn changes(given: &Bound<'_, PyAny>) -> PyResult<Vec<(String, Value)>> {
    let Ok(table) = given.cast::<PyMapping>() else {
        let class = given.get_type().name()?.to_string();
        return Err(PyTypeError::new_err(format!("changes are a mapping of keys to values, not a {class}")));
    };
    let mut out = Vec::new();
    for (path, value) in items(table)? {
        flatten(&path, &value, &mut out, 0)?;
    }
    Ok(out)
}

#[pymethods]
impl Design {
    /// Reads a design file.
    ///
    /// Raises DesignError (key, line, column, hint) for a file that cannot be used, OSError for one that
    /// cannot be read.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Design> {
        let bytes = std::fs::read(&path).map_err(|cause| {
            PyErr::from(std::io::Error::new(cause.kind(), format!("cannot read {}: {cause}", path.display())))
        })?;
        let text = arcmin::tables::text_of(&bytes).map_err(|kind| {
            let message = format!("cannot read {}: {kind}; save it as UTF-8", path.display());
            pyo3::exceptions::PyUnicodeError::new_err(message)
        })?;
        let directory = path.parent().unwrap_or(Path::new("")).to_owned();
        let directory = std::path::absolute(&directory).unwrap_or(directory);
        Design::from_text(py, &text, &path.display().to_string(), directory)
    }

    /// Reads a design from its text; `name` only serves messages.
    #[staticmethod]
    #[pyo3(signature = (text, name = "the design"))]
    fn parse(py: Python<'_>, text: &str, name: &str) -> PyResult<Design> {
        let directory = std::env::current_dir().unwrap_or_default();
        Design::from_text(py, text, name, directory)
    }

    /// A shipped design, as written by `arcmin new`; :meth:`templates` lists the names.
    #[staticmethod]
    #[pyo3(signature = (name = "rv-40e"))]
    fn template(py: Python<'_>, name: &str) -> PyResult<Design> {
        let Some(template) = templates::find(name).or_else(|| templates::find_drive(name)) else {
            let names = shipped().map(|template| template.name).collect::<Vec<_>>().join(", ");
            let message = format!("there is no template \"{name}\"; templates are {names}");
            return Err(errors::value(py, name, &message, false));
        };
        Design::parse(py, template.text, template.file)
    }

    /// Names of the shipped designs, each with one line of description.
    #[staticmethod]
    fn templates(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let all = PyDict::new(py);
        for template in shipped() {
            all.set_item(template.name, template.summary)?;
        }
        Ok(all)
    }

    #[staticmethod]
    fn _restored(py: Python<'_>, text: &str, name: &str, directory: PathBuf) -> PyResult<Design> {
        Design::from_text(py, text, name, directory)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String, PathBuf))> {
        let make = py.get_type::<Design>().getattr("_restored")?;
        let now = self.now();
        Ok((make, (now.to_toml(), now.file_name().to_owned(), self.directory.clone())))
    }

    /// Name of the design, for reports.
    #[getter]
    fn name(&self) -> String {
        self.now().name().to_owned()
    }

    /// Name of the file from which it was read.
    #[getter]
    fn file_name(&self) -> String {
        self.now().file_name().to_owned()
    }

    /// SHA-256 over all values including defaults, independent of layout and comments, as 64 hexadecimal
    /// digits.
    #[getter]
    fn hash(&self) -> String {
        self.now().hash()
    }

    /// The first twelve digits of the hash.
    #[getter]
    fn short_hash(&self) -> String {
        self.now().short_hash()
    }

    /// The text of the design file with all changes.
    fn to_toml(&self) -> String {
        self.now().to_toml()
    }

    /// Keys that are not in the file, whose defaults apply.
    fn defaulted(&self) -> Vec<String> {
        self.now().defaulted()
    }

    /// Paths of all keys, in the order of the reference.
    fn keys(&self, py: Python<'_>) -> Vec<String> {
        let now = self.now();
        py.detach(|| now.keys().into_iter().map(|entry| entry.path).collect())
    }

    /// Values of all keys, in the order of :meth:`keys`.
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let now = self.now();
        now.keys().iter().map(|entry| object(py, &now, &entry.path, &entry.value)).collect()
    }

    /// Paths and values of all keys.
    fn items<'py>(&self, py: Python<'py>) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
        let now = self.now();
        let one = |entry: KeyEntry| Ok((entry.path.clone(), object(py, &now, &entry.path, &entry.value)?));
        now.keys().into_iter().map(one).collect()
    }

    /// Describes a key: unit, range, default, documentation.
    fn describe(&self, py: Python<'_>, path: &str) -> PyResult<Key> {
        let now = self.now();
        let known = now.keys().into_iter().find(|entry| entry.path == path);
        let Some(entry) = known else {
            now.get(path).map_err(|error| errors::design(py, &error))?;
            let message = format!("`{path}` is part of a value: ask for the whole");
            return Err(errors::value(py, path, &message, false));
        };
        let choices = match entry.kind {
            Kind::Choice(words) => Some(words.to_vec()),
            _ => None,
        };
        Ok(Key {
            default: key_object(py, &entry.default)?.unbind(),
            value: object(py, &now, &entry.path, &entry.value)?.unbind(),
            unit: entry.unit,
            range: entry.range.map(|[low, high]| (low, high)),
            required: entry.required,
            documentation: entry.documentation,
            written: entry.written,
            path: entry.path,
            choices,
        })
    }

    /// The value of a key, or of a default if there is no such key.
    #[pyo3(signature = (path, default = None))]
    fn get<'py>(
        &self,
        py: Python<'py>,
        path: &str,
        default: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        match self.__getitem__(py, path) {
            Err(error) if error.is_instance_of::<pyo3::exceptions::PyKeyError>(py) => {
                Ok(default.unwrap_or_else(|| py.None().into_bound(py)))
            }
            other => other,
        }
    }

    /// A design with these keys set together; this one is not changed.
    ///
    /// For keys that depend on each other, such as ``ring.pin_count`` and ``disc.lobe_count``, and for sweeps:
    /// ``design.replace({"disc.width_mm": 9.5})``.
    fn replace(&self, py: Python<'_>, changes: &Bound<'_, PyAny>) -> PyResult<Design> {
        Ok(Design::of(self.with(py, self::changes(changes)?)?, self.directory.clone()))
    }

    /// Sets these keys together, in place.
    fn update(&self, py: Python<'_>, changes: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set(self.with(py, self::changes(changes)?)?);
        Ok(())
    }

    /// An independent design with the same keys.
    fn copy(&self) -> Design {
        self.copied()
    }

    fn __copy__(&self) -> Design {
        self.copied()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Design {
        self.copied()
    }

    /// Geometry of the flank of its disc, less the depth `wear_um` everywhere.
    #[pyo3(signature = (*, wear_um = 0.0))]
    fn flank(&self, py: Python<'_>, wear_um: f64) -> PyResult<Flank> {
        Flank::of(py, &self.now(), wear_um)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, path: &str) -> PyResult<Bound<'py, PyAny>> {
        let now = self.now();
        match now.get(path) {
            Ok(value) => object(py, &now, path, &value),
            Err(error) => match section(py, &now, path)? {
                Some(section) => Ok(section),
                None => Err(errors::design(py, &error)),
            },
        }
    }

    fn __setitem__(&self, py: Python<'_>, path: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let mut changes = Vec::new();
        flatten(path, value, &mut changes, 0)?;
        self.set(self.with(py, changes)?);
        Ok(())
    }

    fn __delitem__(&self, py: Python<'_>, path: &str) -> PyResult<()> {
        self.set(self.with(py, vec![(path.to_owned(), Value::LeftOut)])?);
        Ok(())
    }

    fn __contains__(&self, path: &Bound<'_, PyAny>) -> bool {
        path.extract::<&str>().is_ok_and(|path| self.now().get(path).is_ok())
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        PyList::new(py, self.keys(py))?.try_iter()
    }

    fn __len__(&self) -> usize {
        self.now().keys().len()
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Design>().is_ok_and(|other| *self.now() == *other.get().now())
    }

    fn __repr__(&self) -> String {
        let now = self.now();
        format!("<Design {:?} {}>", now.name(), now.short_hash())
    }
}

impl Design {
    fn from_text(py: Python<'_>, text: &str, name: &str, directory: PathBuf) -> PyResult<Design> {
        let read = py.detach(|| Read::parse(text, name)).map_err(|error| errors::design(py, &error))?;
        Ok(Design::of(read, directory))
    }
}

/// A value; for a material with properties of its own, these.
fn object<'py>(py: Python<'py>, design: &Read, path: &str, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    let Value::Material(_) = value else { return key_object(py, value) };
    let parts = PyDict::new(py);
    for part in ["name", "youngs_modulus_gpa", "poisson_ratio", "density_g_cm3"] {
        let value = design.get(&format!("{path}.{part}")).map_err(|error| errors::design(py, &error))?;
        parts.set_item(part, key_object(py, &value)?)?;
    }
    Ok(parts.into_any())
}

/// A section as a dictionary of its keys, a list of sections as a list of dictionaries; `None` for other paths.
fn section<'py>(py: Python<'py>, design: &Read, path: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
    let inside = PyDict::new(py);
    let mut rows: Vec<Bound<'py, PyDict>> = Vec::new();
    for entry in design.keys() {
        let Some(rest) = entry.path.strip_prefix(path) else { continue };
        if entry.value == Value::LeftOut {
            continue;
        }
        let value = object(py, design, &entry.path, &entry.value)?;
        if let Some(name) = rest.strip_prefix('.') {
            put(&inside, name, &value)?;
        } else if let Some((index, name)) = rest.strip_prefix('[').and_then(|rest| rest.split_once("].")) {
            let Ok(index) = index.parse::<usize>() else { continue };
            while rows.len() <= index {
                rows.push(PyDict::new(py));
            }
            put(&rows[index], name, &value)?;
        }
    }
    Ok(match (rows.is_empty(), inside.is_empty()) {
        (false, _) => Some(PyList::new(py, rows)?.into_any()),
        (true, false) => Some(inside.into_any()),
        (true, true) => None,
    })
}

/// Stores a value under its dotted name.
fn put<'py>(into: &Bound<'py, PyDict>, name: &str, value: &Bound<'py, PyAny>) -> PyResult<()> {
    let Some((first, rest)) = name.split_once('.') else { return into.set_item(name, value) };
    let inner = match into.get_item(first)? {
        Some(inner) => inner.cast_into::<PyDict>()?,
        None => {
            let inner = PyDict::new(into.py());
            into.set_item(first, &inner)?;
            inner
        }
    };
    put(&inner, rest, value)
}
