use std::path::{Path, PathBuf};

use arcmin::analyses::AnalysisError;
use arcmin::analyses::like::{Bodies, like};
use arcmin::analyses::propose::{Demand, Process, propose};
use arcmin::analyses::stage::AnyDesign;
use arcmin::design::Choice;
use arcmin::templates::{self, DRIVES, DataSheet, TEMPLATES, Template};
use clap::{Arg, ArgAction, ArgGroup, ArgMatches, Command, value_parser};

use super::Ending;
use crate::failure::Failure;
use crate::run::{Cache, Terminal, print_line, write_file};

/// Figures required for a scaled and for a proposed drive.
const SIZE: [(&str, &str); 3] = [
    ("ratio", "Ratio, of the data sheet or required"),
    ("torque-nm", "Rated torque in N·m, likewise"),
    ("outer-diameter-mm", "Outer diameter in mm, likewise"),
];

/// Further figures of a data sheet.
const SHEET: [(&str, &str); 6] = [
    ("stiffness-nm-per-arcmin", "Data sheet: torsional stiffness in N·m/arcmin"),
    ("lost-motion-arcmin", "Data sheet: lost motion in arcmin"),
    ("crankshafts", "Data sheet: number of crankshafts [default: that of the template]"),
    ("moment-stiffness-nm-per-arcmin", "Data sheet: moment stiffness of the main bearings in N·m/arcmin"),
    ("starting-torque-nm", "Data sheet: starting torque at the input without load, in N·m"),
    ("back-driving-torque-nm", "Data sheet: back-driving torque at the output, in N·m"),
];

pub fn command() -> Command {
    let list: String = TEMPLATES
        .iter()
        .chain(&DRIVES)
        .map(|template| format!("\n  {:13} {}", template.name, template.summary))
        .collect();
    let processes: String =
        Process::WORDS.iter().map(|(word, meaning)| format!("\n  {word:12} {meaning}")).collect();
    Command::new("new")
        .about("Write a commented design file to start from")
        .long_about(format!(
            "Writes a design file that can be run without changes. Its comments give the source of every value, or \
             state that it is assumed, and why.\n\nTemplates:{list}\n\nWith --like the file is a first model of a \
             machine from its data sheet. It is made in two steps.\n\n1. The template is scaled. The scale s of the pin \
             circle is the ratio of the outer diameters, or the cube root of the ratio of the torques T/T0 if that is \
             larger or no diameter is given. Compact machines get a thinner housing, down to an outer diameter of 2.56 \
             pin circle radii. With w = (T/T0)/s³, limited to 0.7 to 1.6:\n  \
             s: radial dimensions, clearances, flank offsets, crankshafts and their bearings, stiffness of supports, damping\n  \
             s w: axial dimensions, mesh stiffness\n  \
             s³ w: masses;  s⁵ w: inertias\n  \
             s²: seals, at most as the torque;  s³: drag of the oil;  cube root of s: tolerances\n\
             Teeth are chosen for the ratio so that the planets clear each other. Values that are not scaled have a comment with \
             the reason.\n\n2. The figures of the data sheet are matched on the test bench, each by one value that data \
             sheets do not give: stiffness by the diameter of the crankshafts (--bodies elastic, the default) or the \
             torsional stiffness of the carrier (--bodies rigid), lost motion by the clearance of the turning-arm bearings, starting \
             or back-driving torque by the seals, moment stiffness by the preload of the main bearings. The command \
             reports figures that it cannot match, with the reason. With elastic bodies this takes about a minute.\n\n\
             Comments state the origin of every value; [unknowns] contains the values that are not known.\n\n\
             With --family eccentric the file is a single stage proposed from ratio, torque and outer diameter. Sizes are \
             standard parts by the rules of the chapter on single stages; the width of the two discs follows from the pressure of \
             pins and holes in static equilibria with all gaps. The command reports the check nearest to its limit and the largest \
             torque of this size. If no drive meets the requirements, it reports the failing check, the shortfall and possible remedies. \
             --tooth-difference 2 proposes a disc with two lobes less than the ring has pins.\n\n\
             Processes of the discs:{processes}"
        ))
        .after_help(
            "Examples:\n  arcmin new my-reducer.toml\n  arcmin new rv-80e bigger.toml --force\n  arcmin new --list\n  \
             arcmin new --like rv-40e --ratio 105 --torque-nm 167 --outer-diameter-mm 145 \
             --stiffness-nm-per-arcmin 49 --lost-motion-arcmin 0.8 rv-20e.toml\n  \
             arcmin new --family eccentric --ratio 15 --torque-nm 8 --outer-diameter-mm 80 --process printed-fdm \
             actuator.toml",
        )
        .arg(
            Arg::new("WHAT")
                .num_args(0..=2)
                .action(ArgAction::Append)
                .value_names(["TEMPLATE", "FILE"])
                .help("File to write, optionally after the name of a template [default: rv-40e]"),
        )
        .arg(
            Arg::new("like")
                .long("like")
                .value_name("TEMPLATE")
                .help("Scale this template to the figures of a data sheet"),
        )
        .arg(
            Arg::new("family")
                .long("family")
                .value_name("FAMILY")
                .value_parser(["eccentric"])
                .help("Propose a drive of this family from ratio, torque and outer diameter"),
        )
        .group(ArgGroup::new("from").args(["like", "family"]))
        .args(SIZE.map(|(name, help)| number(name, help, "from")))
        .args(SHEET.map(|(name, help)| number(name, help, "like")))
        .arg(
            Arg::new("process")
                .long("process")
                .value_name("PROCESS")
                .value_parser(Process::WORDS.iter().map(|(word, _)| *word).collect::<Vec<_>>())
                .requires("family")
                .help("How the discs are made [default: wire-edm]"),
        )
        .arg(
            Arg::new("tooth-difference")
                .long("tooth-difference")
                .value_name("M")
                .value_parser(value_parser!(u8).range(1..=2))
                .requires("family")
                .help("Pins of the ring less lobes of a disc, 1 or 2 [default: 1]"),
        )
        .arg(number("speed-rpm", "Rated input speed in rpm [default: 600]", "family"))
        .arg(
            Arg::new("bodies")
                .long("bodies")
                .value_name("BODIES")
                .value_parser(["elastic", "rigid"])
                .default_value("elastic")
                .help("Bodies for matching on the test bench, as in `arcmin rig --bodies`"),
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

/// A number that needs another argument.
fn number(name: &'static str, help: &'static str, with: &'static str) -> Arg {
    Arg::new(name)
        .long(name)
        .value_name("X")
        .allow_negative_numbers(true)
        .value_parser(value_parser!(f64))
        .requires(with)
        .help(help)
}

pub fn run(matches: &ArgMatches) -> Result<Ending, Failure> {
    if matches.get_flag("list") {
        for template in TEMPLATES.iter().chain(&DRIVES) {
            print_line(&format!("{:13} {}", template.name, template.summary))?;
        }
        return Ok(Ending::Fine);
    }
    if let Some(name) = matches.get_one::<String>("like") {
        return run_like(name, matches);
    }
    if matches.contains_id("family") {
        return run_family(matches);
    }
    let words: Vec<&String> = matches.get_many::<String>("WHAT").into_iter().flatten().collect();
    let known = |name: &String| templates::find(name).or_else(|| templates::find_drive(name));
    let (template, file) = match words.as_slice() {
        [template, file] => {
            let template =
                known(template).ok_or_else(|| Failure::UnknownTemplate { name: (*template).clone() })?;
            (template, *file)
        }
        [one] if known(one).is_some() && !one.ends_with(".toml") => {
            return Err(Failure::Usage {
                message: format!("{one} is a template; the name of the file to write is missing"),
                help: format!("`arcmin new {one} {one}.toml` writes {one}.toml"),
            });
        }
        // A file with the name of a template gets that template.
        [file] => (known(file).unwrap_or(&TEMPLATES[0]), *file),
        _ => {
            return Err(Failure::Usage {
                message: "the name of the file to write is missing".to_owned(),
                help: "`arcmin new my-reducer.toml`, or `arcmin new --list`".to_owned(),
            });
        }
    };
    let path = PathBuf::from(file);
    if path.exists() && !matches.get_flag("force") {
        return Err(Failure::Exists { path });
    }
    write_file(&path, template.text.as_bytes())?;
    print_line(&format!("{file}: {}\nnext: arcmin check {file}", template.summary))?;
    Ok(Ending::Fine)
}

fn run_like(name: &str, matches: &ArgMatches) -> Result<Ending, Failure> {
    if let Some(Ok(design)) =
        templates::find_drive(name).map(|found| AnyDesign::parse(found.text, found.file))
    {
        return Err(Failure::Usage {
            message: format!("{name} is a {}; --like scales RV reducers", design.family().drive()),
            help: format!("`arcmin new {name} FILE` writes it as it is"),
        });
    }
    let template: &Template =
        templates::find(name).ok_or_else(|| Failure::UnknownTemplate { name: name.to_owned() })?;
    let path = one_file("--like", "`arcmin new --like rv-40e … my-reducer.toml`", matches)?;
    let of = |name: &str| matches.get_one::<f64>(name).copied();
    let (Some(ratio), Some(torque)) = (of("ratio"), of("torque-nm")) else {
        return Err(Failure::Usage {
            message: "--like needs ratio and torque".to_owned(),
            help: "add --ratio and --torque-nm from the data sheet".to_owned(),
        });
    };
    let sheet = DataSheet {
        ratio,
        torque,
        outer_diameter_mm: of("outer-diameter-mm"),
        stiffness_n_m_per_arcmin: of("stiffness-nm-per-arcmin"),
        lost_motion_arcmin: of("lost-motion-arcmin"),
        crankshafts: of("crankshafts"),
        moment_stiffness_n_m_per_arcmin: of("moment-stiffness-nm-per-arcmin"),
        starting_torque_n_m: of("starting-torque-nm"),
        back_driving_torque_n_m: of("back-driving-torque-nm"),
    };
    let bodies = match matches.get_one::<String>("bodies").map(String::as_str) {
        Some("rigid") => Bodies::Rigid,
        _ => Bodies::Elastic,
    };
    let found = in_terminal(&path, |host| like(*template, sheet, bodies, host))?;
    write_file(&path, found.text.as_bytes())?;
    let file = path.display();
    print_line(&format!(
        "{file}: scaled from {name}\n{}\nnext: arcmin check {file}",
        found.notes.join("\n")
    ))?;
    Ok(Ending::Fine)
}

fn run_family(matches: &ArgMatches) -> Result<Ending, Failure> {
    let path = one_file("--family", "`arcmin new --family eccentric … my-drive.toml`", matches)?;
    let of = |name: &str| matches.get_one::<f64>(name).copied();
    // Clap requires `--like` only if no given argument excludes it.
    if let Some((name, _)) = SHEET.iter().find(|(name, _)| of(name).is_some()) {
        return Err(Failure::Usage {
            message: format!(
                "--{name} belongs to --like, and --family proposes a drive without a data sheet"
            ),
            help: format!("leave out --{name}"),
        });
    }
    let missing: Vec<String> =
        SIZE.iter().filter(|(name, _)| of(name).is_none()).map(|(name, _)| format!("--{name}")).collect();
    let (Some(ratio), Some(torque), Some(outer_diameter_mm)) =
        (of("ratio"), of("torque-nm"), of("outer-diameter-mm"))
    else {
        return Err(Failure::Usage {
            message: "--family needs ratio, torque and outer diameter".to_owned(),
            help: format!("add {}", missing.join(", ")),
        });
    };
    let word = matches.get_one::<String>("process").map_or(Process::WireEdm.word(), String::as_str);
    let process = Process::VALUES.iter().copied().find(|process| process.word() == word);
    let demand = Demand {
        ratio,
        tooth_difference: matches.get_one::<u8>("tooth-difference").map_or(1, |m| usize::from(*m)),
        torque,
        outer_diameter_mm,
        process: process.unwrap_or(Process::WireEdm),
        speed_rpm: of("speed-rpm").unwrap_or(600.0),
    };
    let found = in_terminal(&path, |host| propose(demand, host))?;
    write_file(&path, found.text.as_bytes())?;
    let file = path.display();
    print_line(&format!(
        "{file}: single stage, discs {word}\n{}\nnext: arcmin check {file}",
        found.notes.join("\n")
    ))?;
    Ok(Ending::Fine)
}

/// The single file that an option writes.
fn one_file(option: &str, example: &str, matches: &ArgMatches) -> Result<PathBuf, Failure> {
    let words: Vec<&String> = matches.get_many::<String>("WHAT").into_iter().flatten().collect();
    let [file] = words.as_slice() else {
        return Err(Failure::Usage {
            message: format!("{option} needs the name of one file to write"),
            help: example.to_owned(),
        });
    };
    let path = PathBuf::from(file);
    if path.exists() && !matches.get_flag("force") {
        return Err(Failure::Exists { path });
    }
    Ok(path)
}

/// Runs a computation that shows its progress in the terminal.
fn in_terminal<T>(
    path: &Path,
    run: impl FnOnce(&Terminal) -> Result<T, AnalysisError>,
) -> Result<T, Failure> {
    let here = Path::new(".");
    let host = Terminal::new(path, here, Cache::of_user(here), false);
    let found = run(&host).map_err(|error| Failure::Analysis { error, options: None, finding: None })?;
    host.clear();
    Ok(found)
}
