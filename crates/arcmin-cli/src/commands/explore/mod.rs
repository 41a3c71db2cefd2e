//! `arcmin explore`: a design in the browser, computed on this machine.
//!
//! `http` reads requests and refuses foreign ones, `session` holds the tried designs, `work` computes results,
//! `answers` converts them to JSON, `page` creates the page, also as an offline file. The server writes only
//! files that the user saves, beside the design, and reads only the design and files named in it.

mod answers;
mod http;
mod page;
mod routes;
mod session;
#[cfg(test)]
mod tests;
mod work;

use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;

use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};

use super::Ending;
use crate::failure::Failure;
use crate::run::{design_text, print_line};
use http::Guard;
use session::Session;

pub fn command() -> Command {
    Command::new("explore")
        .about("Open a design in the browser: turn the mechanism, change keys, see the effects")
        .long_about(
            "Serves a page on this machine alone and opens it in the browser. The page shows the mechanism in three \
             dimensions with its contact forces, every key of the design as a control, the findings and figures of \
             `check`, `profile`, `contact` and `rig`, and the wear over the hours of `life`. Numbers are those of the \
             commands for the same design.\n\nThe address has a random token; requests without it, and those of other \
             pages, are refused. The server reads the design and the files that it names, and writes only what is saved \
             on the page, beside the design. Ctrl-C ends it.",
        )
        .after_help("Examples:\n  arcmin explore my-reducer.toml\n  arcmin explore my-reducer.toml --port 8080 --no-browser")
        .arg(
            Arg::new("DESIGN")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("Design file (TOML); `arcmin new` writes one"),
        )
        .arg(
            Arg::new("port")
                .long("port")
                .value_name("N")
                .value_parser(value_parser!(u16))
                .default_value("0")
                .hide_default_value(true)
                .help("Port on this machine [default: a free one]"),
        )
        .arg(
            Arg::new("no-browser")
                .long("no-browser")
                .action(ArgAction::SetTrue)
                .help("Print the address and do not open a browser"),
        )
}

pub fn run(matches: &ArgMatches) -> Result<Ending, Failure> {
    let Some(path) = matches.get_one::<PathBuf>("DESIGN") else { unreachable!("clap requires a design") };
    let port = matches.get_one::<u16>("port").copied().unwrap_or(0);
    let (text, name) = design_text(path)?;
    let session = Session::open(path, text.clone(), name).map_err(|error| Failure::design(error, &text))?;
    let usage = |message: String, help: &str| Failure::Usage { message, help: help.to_owned() };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|cause| {
        usage(format!("cannot listen on port {port}: {cause}"), "choose another one with --port")
    })?;
    let address = listener
        .local_addr()
        .map_err(|cause| usage(format!("cannot listen: {cause}"), "choose a port with --port"))?;
    let guard = Guard::new(address.port())
        .map_err(|cause| usage(format!("the system gives no random numbers: {cause}"), "try again"))?;
    let address = guard.address();
    print_line(&address)?;
    if !matches.get_flag("no-browser") {
        open_in_browser(&address);
    }
    let session = Arc::new(session);
    session.start();
    http::serve(&listener, Arc::new(guard), move |request, stream| routes::answer(&session, request, stream));
    Ok(Ending::Fine)
}

/// Opens the address in the default browser; without a desktop the user opens it.
fn open_in_browser(address: &str) {
    let (program, arguments): (&str, &[&str]) = if cfg!(windows) {
        ("rundll32", &["url.dll,FileProtocolHandler"])
    } else if cfg!(target_os = "macos") {
        ("open", &[])
    } else {
        ("xdg-open", &[])
    };
    let mut command = std::process::Command::new(program);
    let quiet = std::process::Stdio::null;
    let _ = command.args(arguments).arg(address).stdin(quiet()).stdout(quiet()).stderr(quiet()).spawn();
}
