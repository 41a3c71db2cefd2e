//! `arcmin import`: measured flanks and joint logs.

use std::path::Path;

use arcmin::analyses::stage::AnyDesign;
use arcmin::design::Family;
use arcmin::exchange::{
    DutyImport, DutyImportOptions, FlankImportOptions, FlankTarget, import_duty, import_flank,
};
use arcmin::report::{Page, compact};
use arcmin::tables::Naming;
use arcmin::units::{DEG, MM, RPM, UM};
use clap::{Arg, ArgMatches, Command, value_parser};

use super::Ending;
use super::export::{Given, directory, failed, number, out, path};
use crate::failure::{Failure, Start};
use crate::run::{LARGEST_TABLE, print_line, read_bounded, write_file};

pub fn command() -> Command {
    let flank = Command::new("flank")
        .about("Fit measured points of a flank and write them as keys of the design")
        .after_help(
            "Examples:\n  arcmin import flank my-reducer.toml points.csv --probe-radius-mm 1 --as harmonics",
        )
        .arg(path("DESIGN", "Design file"))
        .arg(path("POINTS", "Points: CSV x,y[,nx,ny], an XYZIJK list, or VDA-FS"))
        .arg(number("disc", "1", "Number of the measured disc, from 1"))
        .arg(number_left_out(
            "stage",
            "Ring or stage of the disc, 1 or 2 from the input, of drives with two [default: that of [disc]]",
        ))
        .arg(number("probe-radius-mm", "0", "Radius of the probe in mm, if the points are its centres"))
        .arg(Arg::new("as").long("as").value_parser(["measured", "harmonics", "modification"]).help(
            "Keys that describe the deviations [default: measured of RV reducers, otherwise harmonics]",
        ))
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

/// Names of columns given by the user.
fn naming(matches: &ArgMatches) -> Result<Naming, Failure> {
    let given: Vec<&str> =
        matches.get_many::<String>("columns").unwrap_or_default().map(String::as_str).collect();
    let naming = Naming::parse(&given.join(",")).map_err(|what| Failure::Usage {
        message: format!("--columns: {what}"),
        help: "write --columns HEADING=NAME,HEADING=NAME, such as --columns Speed=motor_speed_rpm".to_owned(),
    })?;
    Ok(naming.skipping(matches.get_one("skip-lines").copied().unwrap_or(0)))
}

pub fn run(matches: &ArgMatches) -> Result<Ending, Failure> {
    match matches.subcommand() {
        Some(("flank", matches)) => run_flank(matches),
        Some(("duty", matches)) => run_duty(matches),
        _ => unreachable!("clap accepts known imports only"),
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
    let (path, design) = given.any_design()?;
    let points = given.file("POINTS");
    let disc = given.within("disc", 1.0, 6.0)? as usize - 1;
    let stage = given.within_if_any("stage", 1.0, 2.0)?.map(|stage| stage as usize - 1);
    let is_rv = design.family() == Family::Rv;
    let asked = matches.get_one::<String>("as").map(String::as_str);
    if asked == Some("measured") && !is_rv {
        return Err(Failure::Usage {
            message: format!("errors of {} name no measured flanks", design.family().drives()),
            help: "choose --as harmonics or --as modification".to_owned(),
        });
    }
    let target = match asked.unwrap_or(if is_rv { "measured" } else { "harmonics" }) {
        "harmonics" => FlankTarget::Harmonics { disc },
        "modification" => FlankTarget::Modification,
        _ => FlankTarget::MeasuredFlank { disc, file: "measured-flank.csv".to_owned() },
    };
    let options = FlankImportOptions {
        target,
        probe_radius: given.number("probe-radius-mm") * MM,
        origin_is_axis: matches.get_flag("centred"),
    };
    let flank = design.designed_flank(stage).map_err(super::joint::failed)?;
    let found =
        import_flank(flank, &read(&points)?, &points.display().to_string(), &options).map_err(failed)?;
    let out = directory(matches, &path, "import")?;
    let fit = &found.fit;
    print_line(&format!(
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
        print_line(&format!("  line {}: deviation {:.2} µm", outlier.line, outlier.distance / UM))?;
    }
    if let Some(csv) = &found.csv {
        write_file(&out.join("measured-flank.csv"), csv.as_bytes())?;
    }
    write_file(&out.join("flank.toml"), found.toml.as_bytes())?;
    let page = found.page(design.name(), &name_of(&points));
    write_page(&out.join("flank.html"), page, &design)?;
    print_line(&format!(
        "keys for the design in {}, deviations in {}:\n{}",
        out.join("flank.toml").display(),
        out.join("flank.html").display(),
        found.toml.trim_end()
    ))?;
    Ok(Ending::Fine)
}

fn run_duty(matches: &ArgMatches) -> Result<Ending, Failure> {
    let given = Given(matches);
    let (path, design) = given.any_design()?;
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
    let found = import_duty(design.joint_rating(), &read(&log)?, &log.display().to_string(), &options)
        .map_err(failed)?;
    let out = directory(matches, &path, "import")?;
    let r = &found.reduction;
    for note in &found.notes {
        print_line(&format!("{}: {note}", name_of(&log)))?;
    }
    print_line(&format!(
        "{:.1} s in {} readings, {:.1} s at rest (below {} rpm at the output), {} starts, {} reversals",
        found.duration,
        found.readings,
        found.at_rest,
        compact(found.rest_speed / RPM, 3),
        found.starts,
        found.reversals,
    ))?;
    print_line(&format!(
        "{:.4} h in motion, {:.4} h at rest: 1000 h in motion (hours of the program) are {} h by the clock",
        (found.duration - found.at_rest) / 3600.0,
        found.at_rest / 3600.0,
        found.clock_hours()
    ))?;
    print_line(&format!(
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
    let page = found.page(design.name(), &name_of(&log));
    write_page(&out.join("duty.html"), page, &design)?;
    let summary = serde_json::to_vec_pretty(&duty_summary(&found, &design))
        .map_err(|cause| Failure::Json { cause: cause.to_string() })?;
    write_file(&out.join("summary.json"), &summary)?;
    print_line(&format!(
        "rows for the design in {}, the spectrum in {}, all figures in {}",
        out.join("duty.toml").display(),
        out.join("duty.html").display(),
        out.join("summary.json").display()
    ))?;
    Ok(Ending::Fine)
}

/// Summary of a log, for programs.
fn duty_summary(found: &DutyImport, design: &AnyDesign) -> serde_json::Value {
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

fn write_page(path: &Path, mut page: Page, design: &AnyDesign) -> Result<(), Failure> {
    page.provenance = crate::provenance(&design.hash(), Vec::new());
    write_file(path, page.render().as_bytes())
}
