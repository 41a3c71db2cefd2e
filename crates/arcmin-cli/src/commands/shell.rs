//! Description of the command for shells and `man`.

use clap::{Arg, ArgMatches, Command, value_parser};
use clap_complete::Shell;

use super::Ending;
use crate::failure::Failure;
use crate::run::print_bytes;

pub fn completions() -> Command {
    Command::new("completions")
        .about("Print the completion script of a shell")
        .after_help("Examples:\n  arcmin completions bash > /etc/bash_completion.d/arcmin")
        .arg(Arg::new("SHELL").required(true).value_parser(value_parser!(Shell)))
}

pub fn man() -> Command {
    Command::new("man")
        .about("Print the manual page (troff), or write the pages of all commands")
        .after_help("Examples:\n  arcmin man | man -l -\n  arcmin man --out /usr/local/share/man/man1")
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .value_parser(value_parser!(std::path::PathBuf))
                .help("Existing directory for the pages of the command and all its subcommands"),
        )
}

pub fn run_completions(matches: &ArgMatches) -> Result<Ending, Failure> {
    let Some(shell) = matches.get_one::<Shell>("SHELL") else { unreachable!("clap requires a shell") };
    let mut script = Vec::new();
    clap_complete::generate(*shell, &mut crate::arguments::command(), "arcmin", &mut script);
    print_bytes(&script)?;
    Ok(Ending::Fine)
}

pub fn run_man(matches: &ArgMatches) -> Result<Ending, Failure> {
    if let Some(directory) = matches.get_one::<std::path::PathBuf>("out") {
        let failed = |cause| Failure::Write { path: directory.clone(), cause };
        clap_mangen::generate_to(crate::arguments::command(), directory).map_err(failed)?;
        return Ok(Ending::Fine);
    }
    let mut page = Vec::new();
    let write = |cause| Failure::Write { path: "standard output".into(), cause };
    clap_mangen::Man::new(crate::arguments::command()).render(&mut page).map_err(write)?;
    print_bytes(&page)?;
    Ok(Ending::Fine)
}
