use std::path::{Path, PathBuf};

use arcmin::design::Family;
use arcmin::study::templates::TEMPLATES;
use clap::{Arg, ArgAction, ArgMatches, Command};

use super::Ending;
use crate::failure::Failure;
use crate::run::{print_line, read_any_design, write_file};

pub fn command() -> Command {
    let list: String =
        TEMPLATES.iter().map(|template| format!("\n  {:13} {}", template.name, template.summary)).collect();
    Command::new("new")
        .about("Write a commented study file to start from")
        .long_about(format!("Writes a study file that can be run without changes.\n\nTemplates:{list}"))
        .after_help(
            "Examples:\n  arcmin study new yield my-study.toml\n  \
             arcmin study new optimise my-search.toml --design my-reducer.toml\n  arcmin study new --list",
        )
        .arg(
            Arg::new("WHAT")
                .num_args(0..=2)
                .action(ArgAction::Append)
                .value_names(["TEMPLATE", "FILE"])
                .help("File to write, optionally after the name of a template [default: yield]"),
        )
        .arg(
            Arg::new("design")
                .long("design")
                .value_name("FILE")
                .help("Design of the study, of any family, as a path relative to the study file [default: rv-40e-81.toml]"),
        )
        .arg(Arg::new("list").long("list").action(ArgAction::SetTrue).help("List the templates"))
        .arg(Arg::new("force").long("force").action(ArgAction::SetTrue).help("Overwrite an existing file"))
}

pub fn run(matches: &ArgMatches) -> Result<Ending, Failure> {
    if matches.get_flag("list") {
        for template in TEMPLATES {
            print_line(&format!("{:13} {}", template.name, template.summary))?;
        }
        return Ok(Ending::Fine);
    }
    let usage = |message: String, help: &str| Failure::Usage { message, help: help.to_owned() };
    let words: Vec<&String> = matches.get_many::<String>("WHAT").into_iter().flatten().collect();
    let known = |name: &str| TEMPLATES.iter().find(|template| template.name == name);
    let (template, file) = match words.as_slice() {
        [name, file] => match known(name) {
            Some(template) => (template, *file),
            None => {
                let names = TEMPLATES.map(|template| template.name).join(", ");
                return Err(usage(
                    format!("there is no study template \"{name}\""),
                    &format!("the templates are {names}"),
                ));
            }
        },
        [one] if known(one).is_some() => {
            let help = format!("`arcmin study new {one} {one}.toml` writes {one}.toml");
            return Err(usage(
                format!("{one} is a template; the name of the file to write is missing"),
                &help,
            ));
        }
        [file] => (&TEMPLATES[0], *file),
        _ => {
            let help = "`arcmin study new yield my-study.toml`, or `arcmin study new --list`";
            return Err(usage("the name of the file to write is missing".to_owned(), help));
        }
    };
    let path = PathBuf::from(file);
    if path.exists() && !matches.get_flag("force") {
        return Err(Failure::Exists { path });
    }
    let (text, note) = match matches.get_one::<String>("design") {
        None => (template.text(Family::Rv).to_owned(), String::new()),
        Some(design) => {
            let (family, note) = family_of(&path.parent().unwrap_or(Path::new("")).join(design))?;
            (template.about(design, family), note)
        }
    };
    write_file(&path, text.as_bytes())?;
    print_line(&format!("{file}: {}{note}\nnext: arcmin study {file}", template.summary))?;
    Ok(Ending::Fine)
}

/// Family of a design, and a note if the design does not exist yet and an RV reducer is assumed.
fn family_of(design: &Path) -> Result<(Family, String), Failure> {
    if design.exists() {
        return Ok((read_any_design(design)?.family(), String::new()));
    }
    let note = "does not exist yet; the study has results of RV reducers";
    Ok((Family::Rv, format!("\nnote: {} {note}", design.display())))
}
