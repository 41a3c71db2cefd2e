//! The command line, generated from the options declared in the library.

use arcmin::analyses::{ALL, Analysis};
use arcmin::design::{Key, Kind, Presence};
use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};

use crate::commands;
use crate::failure::Failure;

const ABOUT: &str = "Accuracy, wear and dynamics of RV (cycloidal) reducers, from one design file";

const HELP: &str = "\
Start here:
  arcmin new my-reducer.toml        write a commented design file (an RV-40E-81)
  arcmin check my-reducer.toml      check it; findings state what to change
  arcmin life my-reducer.toml       predict its accuracy over life: tables and a report

Every analysis writes its tables, report.html and summary.json to out/<design>/<command>, or to the directory given
with --out. `arcmin keys` explains the keys of the design file, `arcmin keys --results` every result.
Exit status: 0 success, 1 the design has error findings, 2 the computation failed or the usage is wrong.";

/// The whole command.
pub fn command() -> Command {
    let mut command = Command::new("arcmin")
        .version(env!("CARGO_PKG_VERSION"))
        .about(ABOUT)
        .after_help(HELP)
        .max_term_width(110)
        .subcommand_required(true)
        .arg_required_else_help(true)
        .subcommand(commands::new::command())
        .subcommand(commands::keys::command());
    for analysis in ALL {
        command = command.subcommand(of_analysis(analysis));
    }
    command
        .subcommand(commands::explore::command())
        .subcommand(commands::study::command())
        .subcommand(commands::robot::command())
        .subcommand(commands::export::command())
        .subcommand(commands::import::command())
        .subcommand(commands::shell::completions())
        .subcommand(commands::shell::man())
}

fn of_analysis(analysis: &'static Analysis) -> Command {
    let declared = (analysis.results)();
    let mut guide = analysis.guide.to_owned();
    guide.push_str("\n\nResults:");
    for table in &declared.tables {
        let columns: Vec<&str> = table.columns.iter().map(|column| column.key).collect();
        guide.push_str(&format!("\n  {}.csv: {}.\n    {}", table.name, table.what, columns.join(", ")));
    }
    let mut command = Command::new(analysis.name)
        .about(analysis.about)
        .long_about(guide)
        .after_help(format!("Examples:\n  {}", analysis.examples.join("\n  ")))
        .arg(
            Arg::new("DESIGN")
                .required(true)
                .value_parser(value_parser!(std::path::PathBuf))
                .help("Design file (TOML); `arcmin new` writes one"),
        );
    for key in (analysis.options)().keys {
        command = command.arg(of_option(key));
    }
    if analysis.name == "check" {
        let help = "Write the findings as JSON to standard output; write no files";
        command = command.arg(flag("json", help)).arg(
            Arg::new("drawing")
                .long("drawing")
                .value_name("FILE.svg")
                .value_parser(value_parser!(std::path::PathBuf))
                .help("Write a drawing of the drive whose dimension lines carry the keys of the design"),
        );
    }
    if analysis.name == "life" {
        let help = "Compute the band from whole lives of machines drawn from the design's [unknowns]";
        command = command.arg(flag("band", help)).arg(
            Arg::new("band-machines")
                .long("band-machines")
                .value_name("N")
                .value_parser(value_parser!(u64).range(2..=1_000_000))
                .default_value("93")
                .requires("band")
                .help("Number of machines for --band; the range of 93 machines contains 95 % of all with 95 % confidence"),
        );
    }
    let common = "Common options";
    of_a_run(
        command.next_help_heading(common),
        "Directory for the results [default: out/<design>/<command>]",
        "Overwrite the results of another design",
    )
}

/// Adds the arguments of all runs of one machine or robot: directories of results and caches, threads, quiet.
pub fn of_a_run(command: Command, out: &'static str, force: &'static str) -> Command {
    command
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .value_parser(value_parser!(std::path::PathBuf))
                .help(out),
        )
        .arg(
            Arg::new("cache")
                .long("cache")
                .value_name("DIR")
                .value_parser(value_parser!(std::path::PathBuf))
                .help(
                    "Directory for reduced elastic bodies and other results that later runs reuse \
                     [default: the user's cache, such as ~/.cache/arcmin]",
                ),
        )
        .arg(
            Arg::new("threads")
                .long("threads")
                .value_name("N")
                .value_parser(value_parser!(u16).range(1..=1024))
                .help("Number of threads; results do not depend on it [default: all cores]"),
        )
        .arg(flag("force", force))
        .arg(flag("quiet", "Print nothing but errors").short('q'))
}

/// Sets the number of threads of `--threads`.
///
/// # Errors
/// [`Failure::Threads`] if the system cannot start them.
pub fn take_threads(matches: &ArgMatches) -> Result<(), Failure> {
    let Some(threads) = matches.get_one::<u16>("threads") else { return Ok(()) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads((*threads).into()).build_global();
    pool.map_err(|cause| Failure::Threads { cause: cause.to_string() })
}

fn flag(name: &'static str, help: &'static str) -> Arg {
    Arg::new(name).long(name).action(ArgAction::SetTrue).help(help)
}

/// `torque_nm` is `--torque-nm`.
pub fn long_name(key: &str) -> String {
    key.replace('_', "-")
}

fn of_option(key: &'static Key) -> Arg {
    let doc = key.doc.split_whitespace().collect::<Vec<_>>().join(" ");
    let unit = if key.unit().is_empty() { String::new() } else { format!(" [unit: {}]", key.unit()) };
    let default = match key.rule.presence {
        Presence::Number(number) => format!(" [default: {}]", arcmin::report::compact(number, 6)),
        Presence::Word(word) if !word.is_empty() => format!(" [default: {word}]"),
        _ => String::new(),
    };
    let help = format!("{}{unit}{default}", doc.trim_end_matches('.'));
    let mut arg = Arg::new(key.name).help(help);
    let positional = matches!(key.rule.presence, Presence::Required | Presence::Positional);
    if !positional {
        arg = arg.long(long_name(key.name));
    } else {
        let required = key.rule.presence == Presence::Required;
        arg = arg.required(required).value_name(key.name.to_uppercase());
    }
    match (key.kind)() {
        Kind::Flag => arg.action(ArgAction::SetTrue),
        Kind::Choice(words) => {
            let one = |(word, meaning): &(&'static str, &'static str)| PossibleValue::new(word).help(meaning);
            arg.value_parser(PossibleValuesParser::new(words.iter().map(one))).hide_possible_values(false)
        }
        Kind::Files => arg.action(ArgAction::Append).value_name("FILE"),
        Kind::Texts => arg.action(ArgAction::Append).value_name("TEXT"),
        Kind::File if positional => arg,
        Kind::File => arg.value_name("FILE"),
        Kind::Number | Kind::Count => arg.value_name(value_name(key)).allow_negative_numbers(true),
        _ => arg.value_name("TEXT"),
    }
}

fn value_name(key: &Key) -> &'static str {
    match key.unit() {
        "" => "N",
        "h" => "HOURS",
        "N·m" => "TORQUE",
        "µm" | "mm" => "LENGTH",
        "s" => "TIME",
        _ => "X",
    }
}

/// The given options as TOML for the library.
pub fn options_text(analysis: &Analysis, matches: &ArgMatches) -> String {
    let mut text = String::new();
    for key in (analysis.options)().keys {
        let quoted = |value: &String| toml_text(value);
        let line = match (key.kind)() {
            Kind::Flag if matches.get_flag(key.name) => Some("true".to_owned()),
            Kind::Flag => None,
            Kind::Files | Kind::Texts => matches
                .get_many::<String>(key.name)
                .map(|files| format!("[{}]", files.map(quoted).collect::<Vec<_>>().join(", "))),
            Kind::Number | Kind::Count => matches.get_one::<String>(key.name).map(|word| {
                // Words that are not numbers are passed on as text, which the reader refuses with its own
                // message.
                if word.parse::<f64>().is_ok() { number_text(word) } else { toml_text(word) }
            }),
            _ => matches.get_one::<String>(key.name).map(quoted),
        };
        if let Some(value) = line {
            text.push_str(&format!("{} = {value}\n", key.name));
        }
    }
    text
}

fn toml_text(word: &str) -> String {
    let escape = |c: char| match c {
        '"' => "\\\"".to_owned(),
        '\\' => "\\\\".to_owned(),
        c if c.is_control() => format!("\\u{:04X}", c as u32),
        c => c.to_string(),
    };
    format!("\"{}\"", word.chars().map(escape).collect::<String>())
}

/// Rust accepts more forms of numbers than TOML: `1.`, `.5`, `1e5`, `infinity`.
fn number_text(word: &str) -> String {
    match word.parse::<i64>() {
        Ok(whole) => whole.to_string(),
        Err(_) => match word.parse::<f64>() {
            Ok(number) if number.is_finite() => format!("{number:?}"),
            Ok(number) if number.is_nan() => "nan".to_owned(),
            Ok(number) => if number > 0.0 { "inf" } else { "-inf" }.to_owned(),
            Err(_) => toml_text(word),
        },
    }
}

/// For an unknown option clap proposes the nearest word of any command. Here the message names the commands
/// that have such an option, or explains that an extra word may be meant as the directory of results; words
/// with another beginning are not proposed.
pub fn with_fitting_tip(mut error: clap::Error, typed: &[String]) -> clap::Error {
    let Some(ContextValue::String(unknown)) = error.get(ContextKind::InvalidArg).cloned() else {
        return error;
    };
    if error.kind() != ErrorKind::UnknownArgument {
        return error;
    }
    let proposed = match error.get(ContextKind::SuggestedArg) {
        Some(ContextValue::String(word)) => Some(word.clone()),
        _ => None,
    };
    if proposed.as_ref().is_some_and(|word| word.starts_with(&format!("{unknown}-"))) {
        return error;
    }
    let root = command();
    let (mut here, mut path) = (&root, "arcmin".to_owned());
    for word in typed {
        if let Some(inner) = here.find_subcommand(word) {
            here = inner;
            path.push_str(&format!(" {word}"));
        }
    }
    let tip = match unknown.strip_prefix("--") {
        Some(name) => owners(&root, name),
        None => (!unknown.starts_with('-') && has(here, "out"))
            .then(|| format!("'--out {unknown}' sets the directory for results")),
    };
    let alike = proposed.is_some_and(|word| word.chars().nth(2) == unknown.chars().nth(2));
    if tip.is_none() && alike {
        return error;
    }
    error.remove(ContextKind::SuggestedArg);
    error.remove(ContextKind::Suggested);
    error.insert(ContextKind::Usage, ContextValue::StyledStr(here.clone().bin_name(path).render_usage()));
    if let Some(tip) = tip {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}

fn has(command: &Command, long: &str) -> bool {
    command.get_arguments().any(|argument| argument.get_long() == Some(long))
}

/// Commands with an option of this name, or of this name with its unit.
fn owners(root: &Command, name: &str) -> Option<String> {
    let mut commands: Vec<(String, &Command)> = Vec::new();
    for command in root.get_subcommands() {
        commands.push((command.get_name().to_owned(), command));
        let inner = command
            .get_subcommands()
            .map(|inner| (format!("{} {}", command.get_name(), inner.get_name()), inner));
        commands.extend(inner);
    }
    let longs = || commands.iter().flat_map(|(_, command)| command.get_arguments()).filter_map(Arg::get_long);
    let long = longs()
        .find(|long| *long == name)
        .or_else(|| longs().find(|long| long.strip_prefix(name).is_some_and(|rest| rest.starts_with('-'))))?;
    let names: Vec<&str> =
        commands.iter().filter(|(_, command)| has(command, long)).map(|(path, _)| path.as_str()).collect();
    const MOST_NAMED: usize = 8;
    let of = if names.len() > MOST_NAMED { "most other commands".to_owned() } else { names.join(", ") };
    Some(format!("'--{long}' is an option of {of}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_is_consistent() {
        command().debug_assert();
    }

    #[test]
    fn every_analysis_reads_its_own_defaults() {
        for analysis in ALL {
            let required =
                (analysis.options)().keys.iter().any(|key| key.rule.presence == Presence::Required);
            let arguments: Vec<&str> =
                ["arcmin", analysis.name, "d.toml"].into_iter().chain(required.then_some("x")).collect();
            let matches = command().try_get_matches_from(arguments).unwrap();
            let (_, matches) = matches.subcommand().unwrap();
            analysis.normal_options(&options_text(analysis, matches), "test").unwrap();
        }
    }

    #[test]
    fn numbers_reach_the_reader_as_written() {
        let all = ["1", "-2", "1.", ".5", "1e5", "nan", "-inf", "1_0"].map(number_text);
        assert_eq!(all, ["1", "-2", "1.0", "0.5", "100000.0", "nan", "-inf", "\"1_0\""]);
        assert_eq!(toml_text("a\"\u{1b}\\"), "\"a\\\"\\u001B\\\\\"");
    }
}
