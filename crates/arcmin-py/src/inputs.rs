//! Conversion between Python values and those of keys and options.

use arcmin::design::{Key, Kind, SectionSchema, Value};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyMapping, PySequence, PyString};
use serde_json::Value as Json;

use crate::errors;

/// Kinds of Python values, whatever class they have.
pub enum Given<'py> {
    None,
    Flag(bool),
    Number(f64),
    Text(String),
    List(Vec<Bound<'py, PyAny>>),
    Table(Bound<'py, PyMapping>),
}

/// Larger than any list in a design; a lazy sequence can be longer than memory.
const MOST_ENTRIES: usize = 1_000_000;

/// Accepts any number including NumPy's, any text or path, any sequence, any mapping.
///
/// # Errors
/// `TypeError` for anything else, with the name of its class.
pub fn given<'py>(value: &Bound<'py, PyAny>) -> PyResult<Given<'py>> {
    let py = value.py();
    if value.is_none() {
        return Ok(Given::None);
    }
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(Given::Flag(flag.is_true()));
    }
    if value.cast::<PyFloat>().is_ok() || value.cast::<PyInt>().is_ok() {
        return value.extract().map(Given::Number).or_else(|error| too_large(py, error, value));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Given::Text(text.to_str()?.to_owned()));
    }
    if value.hasattr("__fspath__")? {
        let path = py.import("os")?.call_method1("fspath", (value,))?;
        return match path.cast::<PyString>() {
            Ok(text) => Ok(Given::Text(text.to_str()?.to_owned())),
            Err(_) => Err(PyTypeError::new_err("a path must be text, not bytes")),
        };
    }
    // Arrays and numbers of NumPy are converted to those of Python: their booleans are not `bool`.
    if value.hasattr("tolist")? && value.hasattr("dtype")? {
        let plain = value.call_method0("tolist")?;
        if !plain.is(value) && !plain.hasattr("dtype")? {
            return given(&plain);
        }
    }
    if let Ok(table) = value.cast::<PyMapping>() {
        return Ok(Given::Table(table.clone()));
    }
    let is_bytes = value.hasattr("decode")?;
    if let (Ok(list), false) = (value.cast::<PySequence>(), is_bytes) {
        let length = list.len()?;
        if length > MOST_ENTRIES {
            let message = format!("a list of {length} entries is longer than any value here");
            return Err(PyTypeError::new_err(message));
        }
        return (0..length).map(|index| list.get_item(index)).collect::<PyResult<_>>().map(Given::List);
    }
    if !is_bytes && (value.hasattr("__float__")? || value.hasattr("__index__")?) {
        return value.extract().map(Given::Number);
    }
    let class = value.get_type().fully_qualified_name()?;
    Err(PyTypeError::new_err(format!("a value cannot be a {class}: give a number, text, list or mapping")))
}

/// A whole number beyond the range of doubles, which no key allows.
fn too_large<'py>(py: Python<'py>, error: PyErr, value: &Bound<'py, PyAny>) -> PyResult<Given<'py>> {
    if error.is_instance_of::<pyo3::exceptions::PyOverflowError>(py) {
        let sign = if value.lt(0)? { -1.0 } else { 1.0 };
        return Ok(Given::Number(sign * f64::INFINITY));
    }
    Err(error)
}

/// A value for a key of a design.
///
/// # Errors
/// `TypeError` for types that no key allows.
pub fn key_value(path: &str, given: Given<'_>) -> PyResult<Value> {
    Ok(match given {
        Given::None => Value::LeftOut,
        Given::Flag(flag) => Value::Flag(flag),
        Given::Number(number) => Value::Number(number),
        Given::Text(text) => Value::Text(text),
        Given::List(items) => list(path, &items)?,
        Given::Table(table) => {
            return Err(errors::value(
                table.py(),
                path,
                &format!("`{path}` cannot be a mapping here"),
                false,
            ));
        }
    })
}

fn list(path: &str, items: &[Bound<'_, PyAny>]) -> PyResult<Value> {
    let (mut numbers, mut texts, mut pairs) = (Vec::new(), Vec::new(), Vec::new());
    for item in items {
        match given(item)? {
            Given::Number(number) => numbers.push(number),
            Given::Text(text) => texts.push(text),
            Given::List(pair) if pair.len() == 2 => match (given(&pair[0])?, given(&pair[1])?) {
                (Given::Number(first), Given::Number(second)) => pairs.push([first, second]),
                _ => return Err(mixed(item.py(), path)),
            },
            _ => return Err(mixed(item.py(), path)),
        }
    }
    match (numbers.len(), texts.len(), pairs.len()) {
        (_, 0, 0) => Ok(Value::Numbers(numbers)),
        (0, _, 0) => Ok(Value::Texts(texts)),
        (0, 0, _) => Ok(Value::Pairs(pairs)),
        _ => Err(mixed(items[0].py(), path)),
    }
}

fn mixed(py: Python<'_>, path: &str) -> PyErr {
    let message = format!("`{path}` takes a list of numbers, of pairs of numbers, or of texts");
    errors::value(py, path, &message, false)
}

/// A key's value for Python: numbers, texts, lists of them, `None` if it is not set.
pub fn key_object<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::LeftOut => py.None().into_bound(py),
        Value::Number(number) => number.into_pyobject(py)?.into_any(),
        Value::Count(count) => count.into_pyobject(py)?.into_any(),
        Value::Text(text) => text.into_pyobject(py)?.into_any(),
        Value::Flag(flag) => PyBool::new(py, *flag).to_owned().into_any(),
        Value::Pairs(pairs) => PyList::new(py, pairs.iter().map(|[a, b]| (*a, *b)))?.into_any(),
        Value::Numbers(numbers) => PyList::new(py, numbers)?.into_any(),
        Value::Texts(texts) => PyList::new(py, texts)?.into_any(),
        // Its parts are keys of their own.
        Value::Material(material) => material.name.as_str().into_pyobject(py)?.into_any(),
    })
}

/// Options of a call as TOML, for the reader of the library.
///
/// # Errors
/// `OptionError` for types that no option allows; names and ranges are checked by the reader of the library.
pub fn options_text(schema: &SectionSchema, options: &Bound<'_, PyDict>) -> PyResult<String> {
    let mut text = String::new();
    for (name, value) in options {
        let name: String = name.extract()?;
        let key = schema.keys.iter().find(|key| key.name == name);
        let given = given(&value).map_err(|_| no_option(&value, &name, key))?;
        if let Some(written) = option_text(&name, key, given, &value)? {
            // Names that are not valid as bare keys of TOML are quoted.
            text.push_str(&format!("{} = {written}\n", bare_or_quoted(&name)));
        }
    }
    Ok(text)
}

fn option_text(
    name: &str,
    key: Option<&Key>,
    given: Given<'_>,
    value: &Bound<'_, PyAny>,
) -> PyResult<Option<String>> {
    Ok(match given {
        Given::None => None,
        Given::Flag(flag) => Some(flag.to_string()),
        Given::Number(number) => Some(number_text(number)),
        Given::Text(word) => Some(quoted(&word)),
        Given::List(items) => {
            let mut words = Vec::new();
            for item in &items {
                let given = self::given(item).map_err(|_| no_option(value, name, key))?;
                match given {
                    Given::Table(_) | Given::List(_) | Given::None => {
                        return Err(no_option(value, name, key));
                    }
                    given => words.extend(option_text(name, key, given, item)?),
                }
            }
            Some(format!("[{}]", words.join(", ")))
        }
        Given::Table(_) => return Err(no_option(value, name, key)),
    })
}

fn no_option(value: &Bound<'_, PyAny>, name: &str, key: Option<&Key>) -> PyErr {
    let takes = match key.map(|key| (key.kind)()) {
        Some(Kind::Number) => "a number",
        Some(Kind::Count) => "a whole number",
        Some(Kind::Flag) => "True or False",
        Some(Kind::File | Kind::Files) => "the name of a file, or its columns",
        Some(_) => "a text",
        None => "a number, a text or a list",
    };
    let class =
        value.get_type().fully_qualified_name().map_or_else(|_| String::new(), |name| name.to_string());
    errors::value(value.py(), name, &format!("`{name}` takes {takes}, not a {class}"), true)
}

fn number_text(number: f64) -> String {
    match number {
        x if x.is_nan() => "nan".to_owned(),
        x if x.is_infinite() => if x > 0.0 { "inf" } else { "-inf" }.to_owned(),
        x => format!("{x:?}"),
    }
}

fn bare_or_quoted(name: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(is_bare) { name.to_owned() } else { quoted(name) }
}

fn quoted(word: &str) -> String {
    let mut text = String::from("\"");
    for c in word.chars() {
        match c {
            '"' => text.push_str("\\\""),
            '\\' => text.push_str("\\\\"),
            c if c.is_control() => text.push_str(&format!("\\u{:04X}", c as u32)),
            c => text.push(c),
        }
    }
    text.push('"');
    text
}

/// JSON as dictionaries, lists and plain values.
pub fn json_object<'py>(py: Python<'py>, json: &Json) -> PyResult<Bound<'py, PyAny>> {
    Ok(match json {
        Json::Null => py.None().into_bound(py),
        Json::Bool(flag) => PyBool::new(py, *flag).to_owned().into_any(),
        Json::Number(number) => match (number.as_u64(), number.as_i64()) {
            (Some(count), _) => count.into_pyobject(py)?.into_any(),
            (_, Some(count)) => count.into_pyobject(py)?.into_any(),
            _ => number.as_f64().into_pyobject(py)?,
        },
        Json::String(text) => text.into_pyobject(py)?.into_any(),
        Json::Array(items) => {
            let list = PyList::empty(py);
            for item in items {
                list.append(json_object(py, item)?)?;
            }
            list.into_any()
        }
        Json::Object(entries) => {
            let dict = PyDict::new(py);
            for (key, value) in entries {
                dict.set_item(key, json_object(py, value)?)?;
            }
            dict.into_any()
        }
    })
}
