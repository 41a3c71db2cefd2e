//! `arcmin export` and `arcmin import`: to and from other tools.

use std::path::{Path, PathBuf};

use arcmin::analyses::stage::AnyDesign;
use arcmin::design::Design;
use arcmin::exchange::{
    Contour, DutyImport, DutyImportOptions, ExchangeError, Flank, FlankImportOptions, FlankTarget, Parts,
    ProfileExport, ProfileOptions, Stamp, import_duty, import_flank,
};
use arcmin::fidelity::Fidelity;
use arcmin::geometry::Relief;
use arcmin::life::worn_after;
use arcmin::report::{Page, compact};
use arcmin::tables::Naming;
use arcmin::units::{DEG, MM, RPM, UM};
use clap::{Arg, ArgMatches, Command, value_parser};

use super::Ending;
use super::fmu::pack;
use crate::failure::{Failure, Start};
use crate::run::{
    Cache, LARGEST_TABLE, Terminal, read_any_design, read_bounded, read_design, say, write_file,
};

pub fn export() -> Command {
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
        .arg(choice("parts", "discs", vec!["discs", "pin", "crankshaft", "assembly"]).help("Parts in a file of solids"))
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

pub fn import() -> Command {
    let flank = Command::new("flank")
        .about("Fit measured points of a flank and write them as keys of the design")
        .after_help(
            "Examples:\n  arcmin import flank my-reducer.toml points.csv --probe-radius-mm 1 --as harmonics",
        )
        .arg(path("DESIGN", "Design file"))
        .arg(path("POINTS", "Points: CSV x,y[,nx,ny], an XYZIJK list, or VDA-FS"))
        .arg(number("disc", "1", "Number of the measured disc, from 1"))
        .arg(number("probe-radius-mm", "0", "Radius of the probe in mm, if the points are its centres"))
        .arg(
            choice("as", "measured", vec!["measured", "harmonics", "modification"])
                .help("Keys that describe the deviations"),
        )
        .arg(
            Arg::new("centred")
                .long("centred")
                .action(clap::ArgAction::SetTrue)
                .help("The origin of the file is the axis of the disc, so run-out is kept"),
        )
        .arg(out());
    let duty = Command::new("duty")
        .about("Reduce the log of a robot joint to a load spectrum of the design")
        .long_about(
            "Reduces the log of a joint to rows of [[duty]]. Columns are identified by name and unit: time; torque \
             at the output (output_torque_n_m) or at the motor (motor_torque_n_m), or motor current; speed or angle of \
             output or motor. Angles that restart after a turn are joined. A reading holds until the next one. Rest is \
             separated from the noise of the log. The command prints every assumption and every row or column that it ignores.",
        )
        .after_help(
            "Examples:\n  arcmin import duty my-reducer.toml joint-3.csv --torque-constant 0.21\n  arcmin import \
             duty my-reducer.toml trace.csv --columns \"J3_ActTorque=motor_torque,J3_ActVelo=motor_speed\" \
             --efficiency 0.85",
        )
        .arg(path("DESIGN", "Design file"))
        .arg(path("LOG", "Log: time, torque or current, speed or angle"))
        .arg(number_left_out("torque-constant", "Torque constant of the motor in N·m/A"))
        .arg(number("efficiency", "1", "Efficiency of the gears, for driving and for driven motion"))
        .arg(number(
            "rotor-inertia",
            "0",
            "Moment of inertia of the rotor in kg·m²; its acceleration torque is subtracted from the motor torque",
        ))
        .arg(
            number_left_out("rest-speed", "Output speed in rpm below which the joint is at rest [default: from the noise of the log]")
                .visible_alias("rest-speed-rpm"),
        )
        .arg(
            number_left_out(
                "largest-gap",
                "Longest time in s for which a reading holds; longer intervals are gaps [default: 20 times the usual \
                 interval, or one hour in a log recorded on change]",
            )
            .visible_alias("largest-gap-s"),
        )
        .arg(number("rows", "50", "Largest number of rows in the spectrum"))
        .arg(columns())
        .arg(skip_lines())
        .arg(out());
    Command::new("import")
        .about("Convert measured flanks and logs to keys of the design")
        .after_help("Examples:\n  arcmin import flank my-reducer.toml points.csv\n  arcmin import duty my-reducer.toml joint-3.csv")
        .subcommand_required(true)
        .subcommand(flank)
        .subcommand(duty)
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

/// A number that has no default.
fn number_left_out(name: &'static str, help: &'static str) -> Arg {
    Arg::new(name)
        .long(name)
        .value_name("X")
        .allow_negative_numbers(true)
        .value_parser(value_parser!(f64))
        .help(help)
}

fn columns() -> Arg {
    Arg::new("columns").long("columns").value_name("HEADING=NAME,…").action(clap::ArgAction::Append).help(
        "Meaning of columns with other names: HEADING=motor_speed_rpm, by number 3=torque_n_m; HEADING=- ignores \
         a column",
    )
}

fn skip_lines() -> Arg {
    Arg::new("skip-lines")
        .long("skip-lines")
        .value_name("N")
        .default_value("0")
        .value_parser(value_parser!(usize))
        .help("Number of lines before the column names")
}

/// How the user names columns.
fn naming(matches: &ArgMatches) -> Result<Naming, Failure> {
    let given: Vec<&str> =
        matches.get_many::<String>("columns").unwrap_or_default().map(String::as_str).collect();
    let naming = Naming::parse(&given.join(",")).map_err(|what| Failure::Usage {
        message: format!("--columns: {what}"),
        help: "write --columns HEADING=NAME,HEADING=NAME, such as --columns Speed=motor_speed_rpm".to_owned(),
    })?;
    Ok(naming.skipping(matches.get_one("skip-lines").copied().unwrap_or(0)))
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

fn failed(error: ExchangeError) -> Failure {
    Failure::Usage { help: error.remedy(), message: error.to_string() }
}

/// The directory asked for, or the usual one; it is made.
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

    pub fn design(&self) -> Result<(PathBuf, Design), Failure> {
        let path = self.file("DESIGN");
        let design = read_design(&path)?;
        Ok((path, design))
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.0.get_one(name).cloned().unwrap_or_default()
    }

    /// A finite number in a range, which the error names.
    pub fn within(&self, name: &str, low: f64, high: f64) -> Result<f64, Failure> {
        let value = self.number(name);
        if (low..=high).contains(&value) {
            return Ok(value);
        }
        let message = format!("--{name} is out of range");
        Err(Failure::Usage { message, help: format!("the allowed range is {low} to {high}") })
    }
}

pub fn run_export(matches: &ArgMatches) -> Result<Ending, Failure> {
    match matches.subcommand() {
        Some(("profile", matches)) => run_profile(matches),
        Some(("joint", matches)) => super::joint::run(matches),
        Some(("fmu", matches)) => super::fmu::run(matches),
        _ => unreachable!("clap knows what is exported"),
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
            AnyDesign::Eccentric(_) => {
                return Err(Failure::Usage {
                    message: "the wear of single stages is not computed".to_owned(),
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
    let export = match &design {
        AnyDesign::Rv(design) => ProfileExport::new(&design.machine(), Stamp::of(design), options),
        AnyDesign::Eccentric(design) => ProfileExport::of_stage(design, options),
    }
    .map_err(failed)?;
    let crank_angle = given.within("crank-deg", -3600.0, 3600.0)? * DEG;
    let parts = match given.word("parts") {
        "pin" => Parts::Pin,
        "crankshaft" => Parts::Crankshaft,
        "assembly" => Parts::Assembly { crank_angle },
        _ => Parts::Discs,
    };
    let format = given.word("format");
    let file = out.join(format!("profile.{format}"));
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
    say(&format!(
        "{}: chords within {:.3} µm, splines within {:.3} µm of the exact flank",
        file.display(),
        export.polyline_deviation() / UM,
        export.spline_deviation() / UM
    ))?;
    Ok(Ending::Fine)
}

/// What the flank of a disc has lost.
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

pub fn run_import(matches: &ArgMatches) -> Result<Ending, Failure> {
    match matches.subcommand() {
        Some(("flank", matches)) => run_flank(matches),
        Some(("duty", matches)) => run_duty(matches),
        _ => unreachable!("clap knows what is imported"),
    }
}

fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    read_bounded(path, LARGEST_TABLE).map_err(|cause| Failure::Read {
        path: path.to_owned(),
        cause,
        start: Start::Elsewhere,
    })
}

fn run_flank(matches: &ArgMatches) -> Result<Ending, Failure> {
    let given = Given(matches);
    let (path, design) = given.design()?;
    let points = given.file("POINTS");
    let disc = given.within("disc", 1.0, 6.0)? as usize - 1;
    let target = match given.word("as") {
        "harmonics" => FlankTarget::Harmonics { disc },
        "modification" => FlankTarget::Modification,
        _ => FlankTarget::MeasuredFlank { disc, file: "measured-flank.csv".to_owned() },
    };
    let options = FlankImportOptions {
        target,
        probe_radius: given.number("probe-radius-mm") * MM,
        origin_is_axis: matches.get_flag("centred"),
    };
    let found = import_flank(&design.machine(), &read(&points)?, &points.display().to_string(), &options)
        .map_err(failed)?;
    let out = directory(matches, &path, "import")?;
    let fit = &found.fit;
    say(&format!(
        "{} points: rotation {:.4}°, centre ({:.4}, {:.4}) mm, offset {:.3} µm, standard deviation {:.3} µm, {} outliers",
        found.points.points.len(),
        fit.rotation / DEG,
        fit.centre.x / MM,
        fit.centre.y / MM,
        fit.offset / UM,
        fit.deviation / UM,
        fit.outliers.len()
    ))?;
    for outlier in fit.outliers.iter().take(10) {
        say(&format!("  line {}: deviation {:.2} µm", outlier.line, outlier.distance / UM))?;
    }
    if let Some(csv) = &found.csv {
        write_file(&out.join("measured-flank.csv"), csv.as_bytes())?;
    }
    write_file(&out.join("flank.toml"), found.toml.as_bytes())?;
    let page = found.page(design.machine().name(), &name_of(&points));
    write_page(&out.join("flank.html"), page, &design)?;
    say(&format!(
        "keys for the design in {}, deviations in {}:\n{}",
        out.join("flank.toml").display(),
        out.join("flank.html").display(),
        found.toml.trim_end()
    ))?;
    Ok(Ending::Fine)
}

fn run_duty(matches: &ArgMatches) -> Result<Ending, Failure> {
    let given = Given(matches);
    let (path, design) = given.design()?;
    let log = given.file("LOG");
    let number = |name: &str| matches.get_one::<f64>(name).copied();
    let options = DutyImportOptions {
        torque_constant: number("torque-constant"),
        gear_efficiency: given.number("efficiency"),
        rotor_inertia: given.number("rotor-inertia"),
        rest_speed: number("rest-speed").map(|rpm| rpm * RPM),
        largest_gap: number("largest-gap"),
        rows: given.within("rows", 1.0, 1000.0)? as usize,
        naming: naming(matches)?,
        ..DutyImportOptions::default()
    };
    let found =
        import_duty(&design.machine(), &read(&log)?, &log.display().to_string(), &options).map_err(failed)?;
    let out = directory(matches, &path, "import")?;
    let r = &found.reduction;
    for note in &found.notes {
        say(&format!("{}: {note}", name_of(&log)))?;
    }
    say(&format!(
        "{:.1} s in {} readings, {:.1} s at rest (below {} rpm at the output), {} starts, {} reversals",
        found.duration,
        found.readings,
        found.at_rest,
        compact(found.rest_speed / RPM, 3),
        found.starts,
        found.reversals,
    ))?;
    say(&format!(
        "{:.4} h in motion, {:.4} h at rest: 1000 h in motion (hours of the program) are {} h by the clock",
        (found.duration - found.at_rest) / 3600.0,
        found.at_rest / 3600.0,
        found.clock_hours()
    ))?;
    say(&format!(
        "peak {:.1} N·m, {:.2} rpm at the output\n{} rows: wear {:+.2} %, equivalent bearing load {:+.2} %, bearing \
         life {:+.2} % against the log",
        found.peak_torque.0,
        found.peak_speed.0 / RPM,
        found.rows.len(),
        100.0 * r.wear_error,
        100.0 * r.bearing_load_error,
        100.0 * r.life_error
    ))?;
    write_file(&out.join("duty.toml"), found.toml.as_bytes())?;
    let page = found.page(design.machine().name(), &name_of(&log));
    write_page(&out.join("duty.html"), page, &design)?;
    let summary = serde_json::to_vec_pretty(&duty_summary(&found, &design))
        .map_err(|cause| Failure::Json { cause: cause.to_string() })?;
    write_file(&out.join("summary.json"), &summary)?;
    say(&format!(
        "rows for the design in {}, the spectrum in {}, all figures in {}",
        out.join("duty.toml").display(),
        out.join("duty.html").display(),
        out.join("summary.json").display()
    ))?;
    Ok(Ending::Fine)
}

/// What a log says, for programs.
fn duty_summary(found: &DutyImport, design: &Design) -> serde_json::Value {
    let provenance = crate::provenance(&design.hash(), Vec::new());
    let r = &found.reduction;
    serde_json::json!({
        "arcmin_version": provenance.version,
        "design_hash": provenance.design_hash,
        "command": provenance.command,
        "readings": found.readings,
        "recorded_h": found.duration / 3600.0,
        "rest_h": found.at_rest / 3600.0,
        "motion_h": (found.duration - found.at_rest) / 3600.0,
        "gaps_h": found.gaps / 3600.0,
        "rest_speed_rpm": found.rest_speed / RPM,
        "longest_held_s": found.longest_held,
        "starts": found.starts,
        "reversals": found.reversals,
        "output_turns": found.output_turns,
        "peak_torque_n_m": found.peak_torque.0,
        "holding_torque_n_m": found.holding_torque,
        "peak_speed_rpm": found.peak_speed.0 / RPM,
        "mean_speed_rpm": r.mean_speed / RPM,
        "equivalent_torque_n_m": r.equivalent_torque,
        "rows": found.rows.len(),
        "wear_error": r.wear_error,
        "bearing_load_error": r.bearing_load_error,
        "life_error": r.life_error,
        "notes": found.notes,
    })
}

fn name_of(file: &Path) -> String {
    file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

fn write_page(path: &Path, mut page: Page, design: &Design) -> Result<(), Failure> {
    page.provenance = crate::provenance(&design.hash(), Vec::new());
    write_file(path, page.render().as_bytes())
}
