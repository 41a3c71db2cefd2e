//! The `arcmin` command. All computations are in the crate `arcmin`; this crate reads designs, writes files and prints to
//! the terminal. It is a library because the Python package contains the same command.

mod arguments;
mod commands;
mod failure;
mod run;

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::OnceLock;

use failure::Failure;

pub use run::terminal_text;

/// Words typed after the name of the program, for summaries and reports. Under Python they are not those of
/// the operating system.
static TYPED: OnceLock<Vec<String>> = OnceLock::new();
/// Program that starts this command again, if that is not the executable of the process.
static PROGRAM: OnceLock<PathBuf> = OnceLock::new();

/// As [`run_command`], in a process of another program; `program` is the file that starts the command.
pub fn run_command_as(program: PathBuf, arguments: Vec<OsString>) -> u8 {
    // A process runs one command only, as for `TYPED`.
    let _ = PROGRAM.set(program);
    run_command(arguments)
}

/// Runs the command with these arguments, the name of the program first; returns the exit status.
pub fn run_command(arguments: Vec<OsString>) -> u8 {
    let words = arguments.iter().skip(1).map(|word| word.to_string_lossy().into_owned());
    // A process runs one command only; a second one would keep the words of the first.
    let _ = TYPED.set(words.collect());
    let matches = match arguments::command().try_get_matches_from(arguments) {
        Ok(matches) => matches,
        Err(error) => {
            let error = arguments::with_fitting_tip(error, typed());
            return match error.print() {
                // A closed pipe (`arcmin … | head`) is not an error.
                Err(cause) if cause.kind() != std::io::ErrorKind::BrokenPipe && !error.use_stderr() => {
                    let failure = Failure::Write { path: PathBuf::from("standard output"), cause };
                    failure.print();
                    failure.exit_status()
                }
                _ => u8::try_from(error.exit_code()).unwrap_or(2),
            };
        }
    };
    match commands::run(&matches) {
        Ok(ending) => ending.exit_status(),
        Err(failure) => {
            failure.print();
            failure.exit_status()
        }
    }
}

/// Program that starts this command again, for shards of a study.
pub(crate) fn program() -> std::io::Result<PathBuf> {
    PROGRAM.get().map_or_else(std::env::current_exe, |program| Ok(program.clone()))
}

/// The command line as typed.
pub(crate) fn command_line() -> String {
    std::iter::once("arcmin").chain(typed().iter().map(String::as_str)).collect::<Vec<_>>().join(" ")
}

/// Provenance of the numbers of a page; `design_hash` in full.
pub(crate) fn provenance(design_hash: &str, seeds: Vec<u64>) -> arcmin::report::Provenance {
    arcmin::report::Provenance {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        design_hash: design_hash[..12].to_owned(),
        command: command_line(),
        seeds,
    }
}

/// Words typed after the name of the program.
pub(crate) fn typed() -> &'static [String] {
    TYPED.get().map_or(&[], Vec::as_slice)
}
