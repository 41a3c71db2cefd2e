//! The `arcmin` command. Computation lives in the `arcmin` crate; this crate reads designs, writes tables and
//! talks to the terminal.

mod commands;
mod failure;
mod run;

use std::process::ExitCode;

use clap::Parser;

/// Accuracy, wear and dynamics of RV (cycloidal) reducers, from one design file.
#[derive(Debug, Parser)]
#[command(name = "arcmin", version, arg_required_else_help = true, after_help = HELP, max_term_width = 110)]
struct Arguments {
    #[command(subcommand)]
    command: commands::Command,
}

const HELP: &str = "\
Start here:
  arcmin new my-reducer.toml        write a commented design file (an RV-40E-81)
  arcmin check my-reducer.toml      what is wrong with it, and what to change
  arcmin life my-reducer.toml       accuracy over its life, as tables and a report

Every command writes its tables and a summary.json to out/<design>/<command>; --out puts them elsewhere.
Exit status: 0 fine, 1 the design has error findings, 2 could not compute or wrong usage.";

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match arguments.command.run() {
        Ok(verdict) => verdict.exit_code(),
        Err(failure) => {
            failure.print();
            ExitCode::from(2)
        }
    }
}
