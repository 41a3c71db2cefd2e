//! The `arcmin` command. Questions and answers live in the `arcmin` crate; this crate reads designs, writes
//! files and talks to the terminal.

mod arguments;
mod commands;
mod failure;
mod run;

use std::process::ExitCode;

fn main() -> ExitCode {
    let matches = arguments::command().get_matches();
    match commands::run(&matches) {
        Ok(ending) => ending.exit_code(),
        Err(failure) => {
            failure.print();
            failure.exit_code()
        }
    }
}
