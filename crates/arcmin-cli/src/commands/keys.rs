use clap::{Arg, ArgAction, ArgMatches, Command};

use super::Ending;
use crate::failure::Failure;
use crate::run::print_line;

pub fn command() -> Command {
    Command::new("keys")
        .about("Print the reference of all keys of the design file, or of all results")
        .long_about(
            "Prints every key of the design file with its unit, range, default and meaning, in Markdown. With \
             --results it prints every table, column and figure that the analyses write.",
        )
        .after_help("Examples:\n  arcmin keys | less\n  arcmin keys clearance\n  arcmin keys crankshafts.count\n  arcmin keys --results lost_motion\n  arcmin keys --json-schema > arcmin.schema.json")
        .arg(Arg::new("FILTER").help("Print only lines that contain this text, or the key with this path"))
        .arg(
            Arg::new("results")
                .long("results")
                .action(ArgAction::SetTrue)
                .help("Print the results instead of the keys of the design file"),
        )
        .arg(
            Arg::new("robot")
                .long("robot")
                .action(ArgAction::SetTrue)
                .conflicts_with("results")
                .help("Print the keys of the robot file instead"),
        )
        .arg(
            Arg::new("json-schema")
                .long("json-schema")
                .action(ArgAction::SetTrue)
                .conflicts_with_all(["FILTER", "results", "robot"])
                .help("Print a JSON Schema of the design file, for completion and checks in an editor"),
        )
}

pub fn run(matches: &ArgMatches) -> Result<Ending, Failure> {
    if matches.get_flag("json-schema") {
        print_line(arcmin::design::json_schema().trim_end())?;
        return Ok(Ending::Fine);
    }
    let text = if matches.get_flag("results") {
        let analyses = arcmin::analyses::ALL.iter().map(|analysis| (analysis.results)());
        let stages = arcmin::analyses::stage::declared();
        let declared: Vec<_> = analyses.chain(stages).chain([arcmin::robot::declared()]).collect();
        arcmin::results::reference_of_results(&declared)
    } else if matches.get_flag("robot") {
        arcmin::robot::reference_of_keys()
    } else {
        arcmin::design::reference_of_keys()
    };
    match matches.get_one::<String>("FILTER") {
        None => print_line(text.trim_end())?,
        Some(filter) => {
            let found = filtered(&text, filter);
            if found.is_empty() {
                let message = format!("no line contains \"{filter}\"");
                let part = filter.rsplit('.').next().filter(|part| *part != filter && !part.is_empty());
                let help = match part.filter(|part| !filtered(&text, part).is_empty()) {
                    Some(part) => format!("try its last part: `arcmin keys {part}`"),
                    None => "try a part of the word, or no filter".to_owned(),
                };
                return Err(Failure::Usage { message, help });
            }
            print_line(found.trim_end())?;
        }
    }
    Ok(Ending::Fine)
}

/// Rows of tables that contain the text, and whole sections whose heading contains it, each under its heading. A key by
/// its path, such as `crankshafts.count` or `duty[0].torque_n_m`, is the row of that section.
fn filtered(text: &str, filter: &str) -> String {
    let wanted = filter.to_lowercase();
    let path = wanted.split(']').map(|part| part.split('[').next().unwrap_or_default()).collect::<String>();
    let path = path.rsplit_once('.').map(|(section, key)| (format!("[{section}]"), format!("| `{key}` |")));
    let mut found = String::new();
    let (mut heading, mut shown, mut whole) = ("", false, false);
    for line in text.lines() {
        if line.starts_with("##") {
            (heading, shown, whole) = (line, false, line.to_lowercase().contains(&wanted));
            continue;
        }
        let by_path = path.as_ref().is_some_and(|(section, key)| {
            heading.to_lowercase().contains(section.as_str()) && line.to_lowercase().starts_with(key.as_str())
        });
        let row = line.starts_with("| `") && (by_path || line.to_lowercase().contains(&wanted));
        if row || (whole && !line.is_empty()) {
            if !shown {
                found.push_str(&format!("\n{heading}\n\n"));
                shown = true;
            }
            found.push_str(line);
            found.push('\n');
        }
    }
    found
}
