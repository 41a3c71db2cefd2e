//! Python interface of `arcmin`: the analyses, designs and results of the library with Python types. Names,
//! options and results of the analyses are read from the library's registry.
//!
//! Documentation, notebooks and progress bars are written in Python, in `python/arcmin`.

mod design;
mod errors;
mod flank;
mod host;
mod inputs;
mod outcome;
mod registry;
mod sample;
mod simulation;
mod table;
mod work;

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;

/// Runs the `arcmin` command with these words, beginning with the name of the program; returns its exit status.
/// `program` is the file that starts the command, for child processes.
#[pyfunction]
fn run_command(py: Python<'_>, words: Vec<OsString>, program: PathBuf) -> u8 {
    py.detach(|| arcmin_cli::run_command_as(program, words))
}

#[pymodule(gil_used = false)]
fn _arcmin(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(run_command, module)?)?;
    module.add_function(wrap_pyfunction!(registry::analyses, module)?)?;
    module.add_function(wrap_pyfunction!(outcome::run, module)?)?;
    module.add_function(wrap_pyfunction!(sample::sample, module)?)?;
    module.add_class::<design::Design>()?;
    module.add_class::<design::Key>()?;
    module.add_class::<flank::Flank>()?;
    module.add_class::<outcome::Outcome>()?;
    module.add_class::<simulation::Simulation>()?;
    module.add_class::<simulation::State>()?;
    module.add_class::<table::Table>()?;
    Ok(())
}
