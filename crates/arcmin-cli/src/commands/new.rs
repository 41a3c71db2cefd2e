use std::path::PathBuf;

use arcmin::templates::TEMPLATES;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};

use super::Ending;
use crate::failure::Failure;
use crate::run::{say, write_file};

pub fn command() -> Command {
    let list: String =
        TEMPLATES.iter().map(|template| format!("\n  {:10} {}", template.name, template.summary)).collect();
    Command::new("new")
        .about("Write a commented design file to start from")
        .long_about(format!(
            "Writes a design file that can be run as it is. Its comments say which values its source gives and \
             which are assumed, and why.\n\nTemplates:{list}"
        ))
        .after_help(
            "Examples:\n  arcmin new my-reducer.toml\n  arcmin new rv-80e bigger.toml --force\n  arcmin new --list",
        )
        .arg(
            Arg::new("WHAT")
                .num_args(0..=2)
                .value_names(["TEMPLATE", "FILE"])
                .help("File to write, and before it the template to start from [default: rv-40e-81]"),
        )
        .arg(Arg::new("list").long("list").action(ArgAction::SetTrue).help("List the templates"))
        .arg(
            Arg::new("force")
                .long("force")
                .action(ArgAction::SetTrue)
                .value_parser(value_parser!(bool))
                .help("Overwrite the file if it exists"),
        )
}

pub fn run(matches: &ArgMatches) -> Result<Ending, Failure> {
    if matches.get_flag("list") {
        for template in TEMPLATES {
            say(&format!("{:10} {}", template.name, template.summary))?;
        }
        return Ok(Ending::Fine);
    }
    let words: Vec<&String> = matches.get_many::<String>("WHAT").into_iter().flatten().collect();
    let known = |name: &str| TEMPLATES.iter().find(|template| template.name == name);
    let (template, file) = match words.as_slice() {
        [template, file] => {
            let template =
                known(template).ok_or_else(|| Failure::UnknownTemplate { name: (*template).clone() })?;
            (template, *file)
        }
        [one] if known(one).is_some() => {
            return Err(Failure::Usage {
                message: format!("{one} is a template, and there is no file to write it to"),
                help: format!("`arcmin new {one} {one}.toml` writes {one}.toml"),
            });
        }
        [file] => (&TEMPLATES[0], *file),
        _ => {
            return Err(Failure::Usage {
                message: "there is no file to write".to_owned(),
                help: "`arcmin new my-reducer.toml`, or `arcmin new --list`".to_owned(),
            });
        }
    };
    let path = PathBuf::from(file);
    if path.exists() && !matches.get_flag("force") {
        return Err(Failure::Exists { path });
    }
    write_file(&path, template.text.as_bytes())?;
    say(&format!("{file}: {}\nnext: arcmin check {file}", template.summary))?;
    Ok(Ending::Fine)
}
