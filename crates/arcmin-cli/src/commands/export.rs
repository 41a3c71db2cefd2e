//! `arcmin export`: drawings, solids, joints and FMUs for other tools.

use std::path::{Path, PathBuf};

use arcmin::analyses::stage::AnyDesign;
use arcmin::design::Design;
use arcmin::exchange::{Contour, ExchangeError, Flank, Parts, ProfileExport, ProfileOptions, Stamp};
use arcmin::fidelity::Fidelity;
use arcmin::geometry::Relief;
use arcmin::life::worn_after;
use arcmin::units::{DEG, UM};
use clap::{Arg, ArgMatches, Command, value_parser};

use super::Ending;
use super::fmu::pack;
use crate::failure::Failure;
use crate::run::{Cache, Terminal, print_line, read_any_design, write_file};

pub fn command() -> Command {
    let formats = vec!["dxf", "step", "stl", "3mf", "csv", "svg"];
    let profile = Command::new("profile")
        .about("Write the profile of the disc, the ring of pins and solids for CAD and CAM")
        .long_about(
            "Writes the profile of the disc in millimetres.\n\nFormats: dxf and svg (drawings; dxf with a closed polyline \
             within the tolerance and a closed spline), step (solids of discs, pin, crankshaft or the assembly), stl and 3mf \
             (the same solids as triangles), csv (points). With --disc the file contains this disc only. A drawing of one disc \
             is a contour with its bores, holes and windows, ready for a cutter. Every file states program version, design \
             and deviation.",
        )
        .after_help(
            "Examples:\n  arcmin export profile my-reducer.toml --format dxf\n  arcmin export profile \
             my-reducer.toml --disc 1 --contour spline --offset-um 130\n  arcmin export profile my-reducer.toml \
             --format step --parts assembly --crank-deg 30\n  arcmin export profile my-reducer.toml --format 3mf",
        )
        .arg(path("DESIGN", "Design file"))
        .arg(choice("format", "dxf", formats).help("Format of the file"))
        .arg(
            Arg::new("disc")
                .long("disc")
                .value_name("N")
                .value_parser(value_parser!(u32))
                .help("Number of the disc to write, from 1 [default: all discs]"),
        )
        .arg(
            Arg::new("contour").long("contour").value_parser(["polyline", "spline", "both"]).help(
                "Curve of the flank in a drawing [default: polyline with --disc, otherwise both]",
            ),
        )
        .arg(choice("parts", "discs", vec!["discs", "pin", "ring", "crankshaft", "assembly"]).help("Parts in a file of solids"))
        .arg(number("crank-deg", "0", "Crank angle of the assembly in °"))
        .arg(choice("flank", "modified", vec!["as-cut", "modified"]).help("Flank as cut, or with its modifications"))
        .arg(number("worn-h", "0", "Age in hours of the duty: export the worn flank (machine in bearings)"))
        .arg(number("offset-um", "0", "Outward offset of the flank in µm, for a wire, a wheel or stock"))
        .arg(number("tolerance-um", "1", "Allowed deviation of the polyline in µm; splines keep a fiftieth of it"))
        .arg(out());
    Command::new("export")
        .about("Write the design for other tools: CAD, robot simulators, FMI")
        .after_help(
            "Examples:\n  arcmin export profile my-reducer.toml --format dxf\n  arcmin export joint my-reducer.toml \
             --hours 0,2000,6000\n  arcmin export fmu my-reducer.toml --fmi 3 --hours 6000",
        )
        .subcommand_required(true)
        .subcommand(profile)
        .subcommand(super::joint::command())
        .subcommand(super::fmu::command())
}

pub(super) fn path(name: &'static str, help: &'static str) -> Arg {
    Arg::new(name).required(true).value_parser(value_parser!(PathBuf)).help(help)
}

pub(super) fn number(name: &'static str, default: &'static str, help: &'static str) -> Arg {
    Arg::new(name)
        .long(name)
        .value_name("X")
        .default_value(default)
        .allow_negative_numbers(true)
        .value_parser(value_parser!(f64))
        .help(help)
}

pub(super) fn choice(name: &'static str, default: &'static str, words: Vec<&'static str>) -> Arg {
    Arg::new(name)
        .long(name)
        .default_value(default)
        .value_parser(clap::builder::PossibleValuesParser::new(words))
}

pub(super) fn out() -> Arg {
    Arg::new("out")
        .long("out")
        .value_name("DIR")
        .value_parser(value_parser!(PathBuf))
        .help("Directory for the files [default: out/<design>/export or import]")
}

pub(super) fn failed(error: ExchangeError) -> Failure {
    Failure::Usage { help: error.remedy(), message: error.to_string() }
}

/// The given directory, or the default one; it is created.
pub(super) fn directory(matches: &ArgMatches, design: &Path, what: &str) -> Result<PathBuf, Failure> {
    let usual = || Path::new("out").join(design.file_stem().unwrap_or(design.as_os_str())).join(what);
    let path = matches.get_one::<PathBuf>("out").cloned().unwrap_or_else(usual);
    std::fs::create_dir_all(&path).map_err(|cause| Failure::Write { path: path.clone(), cause })?;
    Ok(path)
}

pub(super) struct Given<'a>(pub &'a ArgMatches);

impl Given<'_> {
    pub fn number(&self, name: &str) -> f64 {
        self.0.get_one(name).copied().unwrap_or_default()
    }

    pub fn word(&self, name: &str) -> &str {
        self.0.get_one::<String>(name).map_or("", String::as_str)
    }

    pub fn any_design(&self) -> Result<(PathBuf, AnyDesign), Failure> {
        let path = self.file("DESIGN");
        let design = read_any_design(&path)?;
        Ok((path, design))
    }

    /// As [`Given::within`], for an optional argument.
    pub fn within_if_any(&self, name: &str, low: f64, high: f64) -> Result<Option<f64>, Failure> {
        self.0.get_one::<f64>(name).map(|_| self.within(name, low, high)).transpose()
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.0.get_one(name).cloned().unwrap_or_default()
    }

    /// A finite number in a range; the error contains the range.
    pub fn within(&self, name: &str, low: f64, high: f64) -> Result<f64, Failure> {
        let value = self.number(name);
        if (low..=high).contains(&value) {
            return Ok(value);
        }
        let message = format!("--{name} is out of range");
        Err(Failure::Usage { message, help: format!("the allowed range is {low} to {high}") })
    }
}

pub fn run(matches: &ArgMatches) -> Result<Ending, Failure> {
    match matches.subcommand() {
        Some(("profile", matches)) => run_profile(matches),
        Some(("joint", matches)) => super::joint::run(matches),
        Some(("fmu", matches)) => super::fmu::run(matches),
        _ => unreachable!("clap accepts known exports only"),
    }
}

fn run_profile(matches: &ArgMatches) -> Result<Ending, Failure> {
    let given = Given(matches);
    let path = given.file("DESIGN");
    let design = read_any_design(&path)?;
    let hours = given.within("worn-h", 0.0, 1e7)?;
    let out = directory(matches, &path, "export")?;
    let count = match &design {
        AnyDesign::Rv(design) => *design.disc.count,
        AnyDesign::Eccentric(design) => *design.disc.count,
        AnyDesign::TwoRing(design) => *design.disc.count,
        AnyDesign::TwoStage(design) => (*design.disc.count).max(*design.first_stage.disc.count),
    };
    let disc = match matches.get_one::<u32>("disc") {
        Some(disc) if (1..=count).contains(&(*disc as usize)) => Some(*disc as usize - 1),
        Some(disc) => return Err(failed(ExchangeError::NoDisc { disc: *disc as usize, count })),
        None => None,
    };
    let contour = match (matches.get_one::<String>("contour").map(String::as_str), disc) {
        (Some("polyline"), _) | (None, Some(_)) => Contour::Polyline,
        (Some("spline"), _) => Contour::Spline,
        _ => Contour::Both,
    };
    let flank = match (hours > 0.0, given.word("flank")) {
        (true, _) => match &design {
            AnyDesign::Rv(design) => Flank::Worn(worn(design, &path, &out, hours, disc.unwrap_or(0))?),
            other => {
                return Err(Failure::Usage {
                    message: format!("worn flanks of {} are not exported", other.family().drives()),
                    help: "leave --worn-h out".to_owned(),
                });
            }
        },
        (false, "as-cut") => Flank::AsCut,
        (false, _) => Flank::Modified,
    };
    let options = ProfileOptions {
        flank,
        tolerance: given.number("tolerance-um") * UM,
        offset: given.number("offset-um") * UM,
        disc,
    };
    // Drives with two flanks: each in a separate file.
    let exports = match &design {
        AnyDesign::Rv(design) => ProfileExport::new(&design.machine(), Stamp::of(design), options)
            .map(|one| vec![("profile", one)]),
        AnyDesign::Eccentric(design) => {
            ProfileExport::of_stage(design, options).map(|one| vec![("profile", one)])
        }
        AnyDesign::TwoRing(design) => ProfileExport::of_two_rings(design, &options)
            .map(|[first, second]| vec![("profile", first), ("second_profile", second)]),
        AnyDesign::TwoStage(design) => ProfileExport::of_two_stages(design, &options)
            .map(|[first, second]| vec![("first_stage_profile", first), ("profile", second)]),
    }
    .map_err(failed)?;
    let crank_angle = given.within("crank-deg", -3600.0, 3600.0)? * DEG;
    let parts = match given.word("parts") {
        "pin" => Parts::Pin,
        "ring" => Parts::Ring,
        "crankshaft" => Parts::Crankshaft,
        "assembly" => Parts::Assembly { crank_angle },
        _ => Parts::Discs,
    };
    let format = given.word("format");
    for (name, export) in exports {
        let file = out.join(format!("{name}.{format}"));
        let bytes = match format {
            "step" => export.step(parts).map_err(failed)?.into_bytes(),
            "stl" => export.stl(parts).map_err(failed)?,
            "3mf" => {
                let entries = export.three_mf(parts).map_err(failed)?;
                pack(&entries).map_err(|cause| Failure::Write { path: file.clone(), cause })?
            }
            "csv" => export.csv().into_bytes(),
            "svg" => export.svg().into_bytes(),
            _ => export.dxf(contour).into_bytes(),
        };
        write_file(&file, &bytes)?;
        print_line(&format!(
            "{}: chords within {:.3} µm, splines within {:.3} µm of the exact flank",
            file.display(),
            export.polyline_deviation() / UM,
            export.spline_deviation() / UM
        ))?;
    }
    Ok(Ending::Fine)
}

/// Wear of the flank of a disc.
fn worn(design: &Design, path: &Path, out: &Path, hours: f64, disc: usize) -> Result<Relief, Failure> {
    let host = Terminal::new(path, out, Cache::of_user(out), false);
    let options = arcmin::fidelity::FidelityOptions::parse("joints = \"bearings\"", "export");
    let state = options
        .map_err(arcmin::analyses::AnalysisError::from)
        .and_then(|options| Fidelity::resolve(design, &options, &host))
        .and_then(|fidelity| worn_after(&design.machine(), &fidelity, hours, &host))
        .map_err(|error| Failure::Analysis { error, options: None, finding: None })?;
    Ok(state.surfaces.flanks[disc].clone())
}
