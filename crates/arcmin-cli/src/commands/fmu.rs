//! `arcmin export fmu`: the reducer as a co-simulation FMU.

use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};

use arcmin::analyses::joint::{JointOptions, joint, pin_loads};
use arcmin::analyses::multibody::require;
use arcmin::analyses::stage::AnyDesign;
use arcmin::exchange::fmu::{Depth, LoadFlange, ModelDescription, UnitData, instantiation_token};
use arcmin::report::printable;
use clap::{Arg, ArgMatches, Command, value_parser};
use zip::write::SimpleFileOptions;

use super::Ending;
use super::export::{Given, choice, directory, number, out, path};
use super::joint::{ages, failed, fidelity, fidelity_args, mass_args, masses};
use crate::failure::{Failure, Start};
use crate::run::{Cache, Terminal, print_line, write_file};

/// Name of the library in the unit, without its ending.
const IDENTIFIER: &str = "arcmin_fmu";
/// Largest age in hours for which a multibody unit computes the wear.
const MOST_HOURS: f64 = 1e7;

pub fn command() -> Command {
    Command::new("fmu")
        .about("Write the reducer as a functional mock-up unit (FMI 2 or 3, co-simulation)")
        .long_about(
            "Writes one .fmu file.\n\n--model map contains torsion curve, hysteresis, harmonics of the transmission error and \
             losses, computed on the test bench when new and at the given ages; a step takes microseconds. --model multibody \
             contains the model of `arcmin simulate`.\n\nMotor flange: inputs flange_a.phi and flange_a.w (for exact inertia \
             torques also flange_a.a), output flange_a.tau. Load flange: input flange_b.tau, output the motion; with \
             --load-flange motion it is the reverse.\n\nThe unit contains the shared library that `cargo build --release` \
             puts beside this program; --library names another file.",
        )
        .after_help(
            "Examples:\n  arcmin export fmu my-reducer.toml --fmi 3 --hours 6000\n  arcmin export fmu my-reducer.toml \
             --fmi 2 --model multibody --joints ideal",
        )
        .arg(path("DESIGN", "Design file"))
        .arg(choice("fmi", "3", vec!["2", "3"]).help("Version of FMI"))
        .arg(choice("model", "map", vec!["map", "multibody"]).help("Model in the unit"))
        .arg(
            choice("load-flange", "torque", vec!["torque", "motion"])
                .help("Input of the load flange: a torque (the unit includes the inertia of its output), or the motion"),
        )
        .arg(
            Arg::new("hours").long("hours").value_name("HOURS,…").default_value("0").help(
                "Ages in hours of the duty, separated by commas; operating_hours starts at the last one",
            ),
        )
        .arg(choice("joints", "bearings", vec!["bearings", "ideal"]).help("Joints of the multibody model"))
        .args(fidelity_args())
        .arg(number("positions", "5", "Map: number of crank positions for the hysteresis loop"))
        .arg(number("te-positions", "1024", "Map: number of points of the transmission error, as in export joint"))
        .args(mass_args())
        .arg(
            Arg::new("library")
                .long("library")
                .value_name("FILE")
                .value_parser(value_parser!(PathBuf))
                .help("Shared library for the unit [default: the one in the directory of this program]"),
        )
        .arg(out())
}

/// (folder of the platform in FMI 2, in FMI 3, ending of a library), of this program.
fn platform() -> Option<(&'static str, &'static str, &'static str)> {
    Some(match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "x86_64") => ("linux64", "x86_64-linux", ".so"),
        ("linux", "aarch64") => ("aarch64-linux", "aarch64-linux", ".so"),
        ("macos", "x86_64") => ("darwin64", "x86_64-darwin", ".dylib"),
        ("macos", "aarch64") => ("aarch64-darwin", "aarch64-darwin", ".dylib"),
        ("windows", "x86_64") => ("win64", "x86_64-windows", ".dll"),
        _ => return None,
    })
}

/// The shared library: the one given, or the one in the directory of this program, where cargo writes it.
fn library(given: Option<&PathBuf>) -> Result<Vec<u8>, Failure> {
    if let Some(path) = given {
        return std::fs::read(path).map_err(|cause| Failure::Read {
            path: path.clone(),
            cause,
            start: Start::Elsewhere,
        });
    }
    let name = format!("{}{IDENTIFIER}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let beside = std::env::current_exe().ok().and_then(|exe| exe.parent().map(Path::to_owned));
    let places: Vec<PathBuf> =
        beside.iter().flat_map(|place| [place.join(&name), place.join("deps").join(&name)]).collect();
    match places.iter().find_map(|place| std::fs::read(place).ok()) {
        Some(bytes) => Ok(bytes),
        None => Err(Failure::Usage {
            message: format!("the shared library {name} for the unit is not in the directory of this program"),
            help: "in a checkout, `cargo build --release` puts it there; after `cargo install`, build it in a checkout \
                   of the same version and name it with --library target/release/libarcmin_fmu.so"
                .to_owned(),
        }),
    }
}

pub fn run(matches: &ArgMatches) -> Result<Ending, Failure> {
    let given = Given(matches);
    let (path, design) = given.any_design()?;
    let Some((folder2, folder3, ending)) = platform() else {
        return Err(Failure::Usage {
            message: "FMI defines no folder for this platform".to_owned(),
            help: "export on Linux, macOS or Windows on x86-64 or ARM".to_owned(),
        });
    };
    let library = library(matches.get_one("library"))?;
    let out = directory(matches, &path, "export")?;
    let host = Terminal::new(&path, &out, Cache::of_user(&out), false);
    let (unit, files) = unit(&given, &design, &path, &host)?;
    host.clear();
    let description = ModelDescription {
        model_name: design.name().to_owned(),
        model_identifier: IDENTIFIER,
        description: format!("{} (design {})", design.description(), design.short_hash()),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        token: unit.instantiation_token.clone(),
        depth: unit.depth,
        load: unit.load_flange,
        start_hours: unit.start_hours,
        hours: unit.hours,
        start_seed: unit.start_seed,
        step_size: 1e-3,
    };
    let json = serde_json::to_string(&unit).map_err(|cause| Failure::Json { cause: cause.to_string() })?;
    let mut entries: Vec<(String, Vec<u8>)> = Vec::new();
    let three = given.word("fmi") == "3";
    let xml = if three { description.fmi3() } else { description.fmi2() };
    entries.push(("modelDescription.xml".to_owned(), xml.into_bytes()));
    let folder = if three { folder3 } else { folder2 };
    entries.push((format!("binaries/{folder}/{IDENTIFIER}{ending}"), library));
    entries.push(("documentation/index.html".to_owned(), documentation(&description).into_bytes()));
    let licences: [(&str, &str); 2] =
        [("MIT", include_str!("../../LICENSE-MIT")), ("APACHE", include_str!("../../LICENSE-APACHE"))];
    let both = licences.map(|(_, text)| text).join("\n\n");
    entries.push(("documentation/licenses/license.txt".to_owned(), both.into_bytes()));
    if three {
        entries.push((
            "terminalsAndIcons/terminalsAndIcons.xml".to_owned(),
            description.terminals().into_bytes(),
        ));
    }
    entries.push(("resources/design.toml".to_owned(), design.text().as_bytes().to_vec()));
    entries.push(("resources/unit.json".to_owned(), json.into_bytes()));
    entries.extend(files.into_iter().map(|(name, bytes)| (format!("resources/{name}"), bytes)));
    let packed = pack(&entries).map_err(|cause| Failure::Write { path: out.clone(), cause })?;
    let stem = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let file = out.join(format!("{stem}.fmu"));
    write_file(&file, &packed)?;
    print_line(&format!(
        "{}: FMI {}.0, co-simulation, {} model, {:.0} h, {:.1} MB",
        file.display(),
        given.word("fmi"),
        given.word("model"),
        unit.start_hours,
        packed.len() as f64 / 1e6
    ))?;
    Ok(Ending::Fine)
}

/// Resources of the unit beside its design, and the files that the design names.
fn unit(
    given: &Given<'_>,
    design: &AnyDesign,
    path: &Path,
    host: &Terminal,
) -> Result<(UnitData, Vec<(String, Vec<u8>)>), Failure> {
    let asked = ages(given.word("hours"))?;
    let start_hours = asked.last().copied().unwrap_or_default();
    let depth = if given.word("model") == "map" { Depth::Map } else { Depth::Multibody };
    let joints = if depth == Depth::Map { "bearings" } else { given.word("joints") };
    let options = fidelity(given.0, joints)?;
    let seed = given.0.get_one::<u32>("seed").copied().unwrap_or(0);
    let start_seed = i32::try_from(seed).map_err(|_| Failure::Usage {
        message: "--seed is too large for a unit".to_owned(),
        help: "the largest is 2147483647".to_owned(),
    })?;
    let mut text = format!("joints = \"{joints}\"\n");
    if let Some(discs) = given.0.get_one::<String>("discs") {
        text.push_str(&format!("discs = \"{discs}\"\n"));
    }
    let drawn = given.0.get_one::<String>("errors").is_some_and(|word| word == "drawn");
    if let (Some(errors), false) = (given.0.get_one::<String>("errors"), drawn) {
        text.push_str(&format!("errors = \"{errors}\"\n"));
    }
    // A drawn machine needs an explicit seed in the unit; 1 is the default of the other commands.
    let start_seed = if drawn && start_seed == 0 { 1 } else { start_seed };
    if depth == Depth::Multibody {
        require(design, &options).map_err(failed)?;
    }
    let (mut joint_data, mut pins, mut hours) = (None, Vec::new(), [0.0, MOST_HOURS]);
    if depth == Depth::Map {
        let mut all = asked;
        all.push(0.0);
        let options = JointOptions {
            fidelity: options,
            hours: all,
            positions: given.within("positions", 1.0, 360.0)? as usize,
            error_positions: given.within("te-positions", 64.0, 65536.0)? as usize,
            timestep: 1e-3,
            load_inertia: None,
            masses: masses(given)?,
        };
        let found = joint(design, &options, host).map_err(failed)?;
        let of_states: Vec<f64> = found.states.iter().map(|state| state.hours).collect();
        pins = pin_loads(design, &options, &of_states, host).map_err(failed)?;
        hours[1] = of_states.last().copied().unwrap_or_default();
        joint_data = Some(found);
    }
    let mut files = Vec::new();
    for flank in design.measured_flanks() {
        let name = flank.file.clone();
        let plain = Path::new(&name).components().all(|part| matches!(part, std::path::Component::Normal(_)));
        if !plain || matches!(name.as_str(), "design.toml" | "unit.json") {
            return Err(Failure::Usage {
                message: format!("the path {name} of the measured flank cannot be used in the unit"),
                help: "put the file beside the design or into a folder there, and correct the path in the design".to_owned(),
            });
        }
        let place = path.parent().unwrap_or(Path::new(".")).join(&name);
        let bytes = std::fs::read(&place).map_err(|cause| Failure::Read {
            path: place,
            cause,
            start: Start::Elsewhere,
        })?;
        files.push((name, bytes));
    }
    let load_flange =
        if given.word("load-flange") == "motion" { LoadFlange::Motion } else { LoadFlange::Torque };
    let mut unit = UnitData {
        depth,
        load_flange,
        instantiation_token: String::new(),
        fidelity: text,
        hours,
        start_hours,
        start_seed,
        joint: joint_data,
        pins,
    };
    let json = serde_json::to_vec(&unit).map_err(|cause| Failure::Json { cause: cause.to_string() })?;
    let version = env!("CARGO_PKG_VERSION").as_bytes();
    let mut parts: Vec<&[u8]> = vec![version, given.word("fmi").as_bytes(), design.text().as_bytes(), &json];
    parts.extend(files.iter().map(|(_, bytes)| bytes.as_slice()));
    unit.instantiation_token = instantiation_token(&parts);
    Ok((unit, files))
}

/// A zip archive whose bytes depend on its entries only.
pub(super) fn pack(entries: &[(String, Vec<u8>)]) -> std::io::Result<Vec<u8>> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Deflated)
        .last_modified_time(zip::DateTime::default())
        .unix_permissions(0o644);
    for (name, bytes) in entries {
        archive.start_file(name.as_str(), options).map_err(std::io::Error::other)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish().map_err(std::io::Error::other)?.into_inner())
}

fn documentation(unit: &ModelDescription) -> String {
    let escape = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;");
    let rows: String = arcmin::exchange::fmu::variables(unit.depth, unit.load)
        .iter()
        .map(|v| {
            format!("<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n", v.name, v.unit, escape(v.description))
        })
        .collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title></head>\n<body>\n<h1>{0}</h1>\n\
         <p>{1}</p>\n<p>Written by arcmin {2}. Turns count positive against the clock; a torque on a flange is positive \
         along positive motion.</p>\n<table>\n<tr><th>variable</th><th>unit</th><th>meaning</th></tr>\n{rows}</table>\n\
         </body></html>\n",
        escape(&printable(&unit.model_name)),
        escape(&printable(&unit.description)),
        escape(&unit.version)
    )
}
