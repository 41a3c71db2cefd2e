use std::path::PathBuf;

use arcmin::analyses::like::{Bodies, like};
use arcmin::templates::{self, DataSheet, NEMA17_19, TEMPLATES, Template};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};

use super::Ending;
use crate::failure::Failure;
use crate::run::{Cache, Terminal, say, write_file};

/// Figures of a data sheet.
const SHEET: [(&str, &str); 9] = [
    ("ratio", "Data sheet: ratio"),
    ("torque-nm", "Data sheet: rated torque in N·m"),
    ("outer-diameter-mm", "Data sheet: outer diameter in mm"),
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
        .chain([&NEMA17_19])
        .map(|template| format!("\n  {:10} {}", template.name, template.summary))
        .collect();
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
             Comments state the origin of every value; [unknowns] contains the values that are not known."
        ))
        .after_help(
            "Examples:\n  arcmin new my-reducer.toml\n  arcmin new rv-80e bigger.toml --force\n  arcmin new --list\n  \
             arcmin new --like rv-40e --ratio 105 --torque-nm 167 --outer-diameter-mm 145 \
             --stiffness-nm-per-arcmin 49 --lost-motion-arcmin 0.8 rv-20e.toml",
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
        .args(SHEET.map(|(name, help)| {
            Arg::new(name)
                .long(name)
                .value_name("X")
                .allow_negative_numbers(true)
                .value_parser(value_parser!(f64))
                .requires("like")
                .help(help)
        }))
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

pub fn run(matches: &ArgMatches) -> Result<Ending, Failure> {
    if matches.get_flag("list") {
        for template in TEMPLATES.iter().chain([&NEMA17_19]) {
            say(&format!("{:10} {}", template.name, template.summary))?;
        }
        return Ok(Ending::Fine);
    }
    if let Some(name) = matches.get_one::<String>("like") {
        return run_like(name, matches);
    }
    let words: Vec<&String> = matches.get_many::<String>("WHAT").into_iter().flatten().collect();
    let known = |name: &String| templates::find(name).or_else(|| templates::find_single_stage(name));
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
        // A file that is named after a template holds that one.
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
    say(&format!("{file}: {}\nnext: arcmin check {file}", template.summary))?;
    Ok(Ending::Fine)
}

fn run_like(name: &str, matches: &ArgMatches) -> Result<Ending, Failure> {
    if templates::find_single_stage(name).is_some() {
        return Err(Failure::Usage {
            message: format!("{name} is a single stage; --like scales RV reducers"),
            help: format!("`arcmin new {name} FILE` writes it as it is"),
        });
    }
    let template: &Template =
        templates::find(name).ok_or_else(|| Failure::UnknownTemplate { name: name.to_owned() })?;
    let usage =
        |message: &str, help: &str| Failure::Usage { message: message.to_owned(), help: help.to_owned() };
    let words: Vec<&String> = matches.get_many::<String>("WHAT").into_iter().flatten().collect();
    let [file] = words.as_slice() else {
        return Err(usage(
            "--like needs the name of one file to write",
            "`arcmin new --like rv-40e … my-reducer.toml`",
        ));
    };
    let of = |name: &str| matches.get_one::<f64>(name).copied();
    let (Some(ratio), Some(torque)) = (of("ratio"), of("torque-nm")) else {
        return Err(usage(
            "--like needs ratio and torque",
            "add --ratio and --torque-nm from the data sheet",
        ));
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
    let path = PathBuf::from(file);
    if path.exists() && !matches.get_flag("force") {
        return Err(Failure::Exists { path });
    }
    let here = std::path::Path::new(".");
    let host = Terminal::new(&path, here, Cache::of_user(here), false);
    let found = like(*template, sheet, bodies, &host).map_err(|error| Failure::Analysis {
        error,
        options: None,
        finding: None,
    })?;
    host.clear();
    write_file(&path, found.text.as_bytes())?;
    say(&format!("{file}: scaled from {name}\n{}\nnext: arcmin check {file}", found.notes.join("\n")))?;
    Ok(Ending::Fine)
}
