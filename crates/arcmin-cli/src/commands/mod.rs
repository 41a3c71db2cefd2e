//! Commands: one file for all analyses, one file for each of the others.

mod analysis;
pub mod explore;
pub mod export;
mod fmu;
pub mod import;
mod joint;
pub mod keys;
pub mod new;
pub mod robot;
pub mod shell;
pub mod study;

use clap::ArgMatches;

use crate::failure::Failure;

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    Fine,
    /// The design has findings of level ERROR.
    ErrorFindings,
}

impl Ending {
    pub fn exit_status(self) -> u8 {
        match self {
            Ending::Fine => 0,
            Ending::ErrorFindings => 1,
        }
    }
}

/// Runs the command of the command line.
pub fn run(matches: &ArgMatches) -> Result<Ending, Failure> {
    match matches.subcommand() {
        Some(("new", matches)) => new::run(matches),
        Some(("keys", matches)) => keys::run(matches),
        Some(("explore", matches)) => explore::run(matches),
        Some(("robot", matches)) => robot::run(matches),
        Some(("study", matches)) => study::run(matches),
        Some(("export", matches)) => export::run(matches),
        Some(("import", matches)) => import::run(matches),
        Some(("completions", matches)) => shell::run_completions(matches),
        Some(("man", matches)) => shell::run_man(matches),
        Some((name, matches)) => match arcmin::analyses::by_name(name) {
            Some(analysis) => analysis::run(analysis, matches),
            None => unreachable!("clap accepts known commands only"),
        },
        None => unreachable!("clap requires a command"),
    }
}
