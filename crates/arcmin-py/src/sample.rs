//! Points of a study, for tools with statistics of their own.

use arcmin::study::sampling::{Layout, Sampling};
use arcmin::study::{Distribution, Value};
use numpy::PyArray2;
use numpy::ndarray::Array2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors;

fn distribution(py: Python<'_>, name: &str, given: &Bound<'_, PyDict>) -> PyResult<Distribution> {
    let number = |key: &str| given.get_item(key)?.map(|value| value.extract::<f64>()).transpose();
    let mut keys: Vec<String> = given.keys().extract()?;
    keys.sort();
    let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
    let missing = || errors::value(py, name, &format!("`{name}` lacks a number"), true);
    match keys[..] {
        ["high", "low"] => {
            let (low, high) = (number("low")?.ok_or_else(missing)?, number("high")?.ok_or_else(missing)?);
            Ok(Distribution::Uniform { low, high })
        }
        ["high", "log", "low"] => {
            let (low, high) = (number("low")?.ok_or_else(missing)?, number("high")?.ok_or_else(missing)?);
            Ok(Distribution::LogUniform { low, high })
        }
        ["deviation", "mean"] | ["deviation", "limit", "mean"] => {
            let (mean, deviation) =
                (number("mean")?.ok_or_else(missing)?, number("deviation")?.ok_or_else(missing)?);
            Ok(Distribution::Normal { mean, deviation, limit: number("limit")? })
        }
        _ => {
            let message = format!(
                "`{name}` varies by low and high (and log = True), or mean and deviation (and limit), not {}",
                keys.join(", ")
            );
            Err(errors::value(py, name, &message, true))
        }
    }
}

/// Points of a study: an array of shape (rows, factors), in the order of the factors.
///
/// `factors` are names with their distributions: ``{"low": 0, "high": 20}`` (with ``"log": True`` uniform in
/// the logarithm) or ``{"mean": 8.75, "deviation": 0.05}``. `kind` is "random", "latin-hypercube", "sobol"
/// (Owen-scrambled), "morris" (trajectories) or "saltelli" (the layout for SALib's Sobol analysis;
/// ``second_order`` as there). Point k depends on seed and k only (for a Latin hypercube also on the number of
/// samples), as in `arcmin study`.
#[pyfunction]
#[pyo3(signature = (
    factors, samples, *, kind = "latin-hypercube", seed = 1, levels = 4, second_order = false
))]
pub fn sample<'py>(
    py: Python<'py>,
    factors: &Bound<'py, PyDict>,
    samples: u64,
    kind: &str,
    seed: u64,
    levels: usize,
    second_order: bool,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let layout = match kind {
        "random" => Layout::Random,
        "latin-hypercube" => Layout::LatinHypercube,
        "sobol" => Layout::Sobol,
        "morris" => Layout::Morris { levels },
        "saltelli" => Layout::Saltelli { second_order },
        other => {
            let message =
                format!("`kind` is random, latin-hypercube, sobol, morris or saltelli, not \"{other}\"");
            return Err(errors::value(py, "kind", &message, true));
        }
    };
    let mut distributions = Vec::new();
    for (name, given) in factors {
        let name: String = name.extract()?;
        let given = given.cast::<PyDict>().map_err(|_| {
            let message = format!("`{name}` takes a dictionary such as {{\"low\": 0, \"high\": 1}}");
            errors::value(py, &name, &message, true)
        })?;
        distributions.push(distribution(py, &name, given)?);
    }
    let columns = distributions.len();
    let wrong = |message: String| errors::value(py, "samples", &message, true);
    let too_many = || wrong(format!("{samples} samples are more than a call gives ({MOST_VALUES} values)"));
    if samples.saturating_mul(columns as u64) > MOST_VALUES {
        return Err(too_many());
    }
    let sampling = Sampling::new(layout, distributions, samples, seed).map_err(|e| wrong(e.to_string()))?;
    if sampling.rows().saturating_mul(columns as u64) > MOST_VALUES {
        return Err(too_many());
    }
    let rows = sampling.rows() as usize;
    let values = py.detach(|| {
        let mut values = Vec::with_capacity(rows * columns);
        for row in 0..rows {
            let point = sampling.point(row as u64);
            values.extend(sampling.values(&point).into_iter().map(|value| match value {
                Value::Number(number) => number,
                Value::Entry(index) => index as f64,
                Value::Seed(seed) => seed as f64,
            }));
        }
        values
    });
    let array = Array2::from_shape_vec((rows, columns), values).map_err(|e| wrong(e.to_string()))?;
    Ok(PyArray2::from_owned_array(py, array))
}

/// Half a gigabyte of numbers.
const MOST_VALUES: u64 = 1 << 26;
