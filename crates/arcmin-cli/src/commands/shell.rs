//! What a shell and `man` want to know about the command.

use clap::{Arg, ArgMatches, Command, value_parser};
use clap_complete::Shell;

use super::Ending;
use crate::failure::Failure;
use crate::run::say_bytes;

pub fn completions() -> Command {
    Command::new("completions")
        .about("Print the completion script of a shell")
        .after_help("Examples:\n  arcmin completions bash > /etc/bash_completion.d/arcmin")
        .arg(Arg::new("SHELL").required(true).value_parser(value_parser!(Shell)))
}

pub fn man() -> Command {
    Command::new("man")
        .about("Print the manual page (troff)")
        .after_help("Examples:\n  arcmin man | man -l -")
}

pub fn run_completions(matches: &ArgMatches) -> Result<Ending, Failure> {
    let Some(shell) = matches.get_one::<Shell>("SHELL") else { unreachable!("clap asks for a shell") };
    let mut script = Vec::new();
    clap_complete::generate(*shell, &mut crate::arguments::command(), "arcmin", &mut script);
    say_bytes(&script)?;
    Ok(Ending::Fine)
}

pub fn run_man() -> Result<Ending, Failure> {
    let mut page = Vec::new();
    let write = |cause| Failure::Write { path: "standard output".into(), cause };
    clap_mangen::Man::new(crate::arguments::command()).render(&mut page).map_err(write)?;
    say_bytes(&page)?;
    Ok(Ending::Fine)
}
