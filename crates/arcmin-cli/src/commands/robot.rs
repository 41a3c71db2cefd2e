//! `arcmin robot`: error of the tool of a robot over the life of its reducers.

use std::path::{Path, PathBuf};

use arcmin::analyses::{AnalysisError, Outcome};
use arcmin::design::{Design, InputFile};
use arcmin::report::Provenance;
use arcmin::robot::{Loaded, Robot, RobotFile, RobotOptions, example, run as answer};
use arcmin::study::{Plan, Shard, collect};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use serde_json::json;

use super::Ending;
use super::study::{self, broken, common, engines, shard, shard_of};
use crate::arguments::{of_a_run, take_threads};
use crate::failure::{Failure, Start};
use crate::run::{
    Cache, Parts, Results, Terminal, print_line, read_bounded, terminal_text, text_of, write_file,
};

const GUIDE: &str = "\
The robot file (TOML) describes the arm (URDF or a table of axes), the reducer of every joint, the load of the hand,
programs (joint angles over time, or poses visited), planned hours and limits at the tool.

Inverse dynamics gives torque and speed of every joint, which are its duty; the wear of every reducer follows from its
duty. At every age the errors of the joints (hysteresis, wind-up, transmission error, tilt of the output bearings) are
mapped to the tool. Results: figures of ISO 9283 by joint and cause; hours until a limit is exceeded and the joint that
causes it; the gain of an overhaul and the plan with the fewest overhauls; a compensation table for the controller.

Lives of joints are kept in the cache. A joint with the same duty is not computed again, and a stopped run continues
with the joints that are missing. The drawn robots of a [population] are a study: each is written to parts/ when it is
computed, and shards of them can run on other machines.";

const EXAMPLES: &str = "Examples:
  arcmin robot new arm.toml                write a six-axis example with its designs
  arcmin robot arm.toml                    run it
  arcmin robot arm.toml --loads            torques and duties only
  arcmin robot other.toml --lives out/arm/robot/lives.json
                                           another program with joint lives of an earlier run, scaled
  arcmin robot run arm.toml --shard 3/20 --out shared/arm
                                           one shard of the drawn robots of a population
  arcmin robot submit arm.toml --engine hq --out shared/arm
                                           all shards on an engine, then the report";

pub fn command() -> Command {
    let new = Command::new("new")
        .about("Write a commented robot file and the designs it names")
        .arg(
            Arg::new("FILE")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("Robot file to write; its designs are written beside it"),
        )
        .arg(Arg::new("force").long("force").action(ArgAction::SetTrue).help("Overwrite existing files"));
    let run = Command::new("run")
        .about("Compute one shard of the drawn robots and keep it in parts/")
        .args([robot_file(), shard()]);
    // Shards use the cache of the user who runs them.
    let submit = common(engines::command("robot", "arm.toml").arg(robot_file()))
        .mut_arg("out", |out| out.help(OUT))
        .mut_arg("force", |force| force.help(FORCE))
        .mut_arg("threads", |threads| threads.help("Number of threads for the report [default: all cores]"));
    let command = Command::new("robot")
        .about(arcmin::robot::declared().about)
        .long_about(format!("{}.\n\n{GUIDE}", arcmin::robot::declared().about))
        .after_help(EXAMPLES)
        .args_conflicts_with_subcommands(true)
        .subcommand_negates_reqs(true)
        .arg(robot_file())
        .arg(
            Arg::new("loads")
                .long("loads")
                .action(ArgAction::SetTrue)
                .help("Compute loads and duties of the joints only, without their lives"),
        )
        .arg(
            Arg::new("lives")
                .long("lives")
                .value_name("FILE")
                .conflicts_with("loads")
                .help("lives.json of an earlier run: use its joint lives, with hours scaled by the wear of the new program"),
        );
    of_a_run(command, OUT, FORCE).subcommand(new).subcommand(of_a_run(run, OUT, FORCE)).subcommand(submit)
}

const OUT: &str = "Directory for the results [default: out/<robot>/robot]";
const FORCE: &str = "Overwrite the results of another robot";

fn robot_file() -> Arg {
    Arg::new("ROBOT")
        .required(true)
        .value_parser(value_parser!(PathBuf))
        .help("Robot file (TOML); `arcmin robot new` writes one")
}

pub fn run(matches: &ArgMatches) -> Result<Ending, Failure> {
    match matches.subcommand() {
        Some(("new", matches)) => write_new(matches),
        Some(("run", matches)) => Job::of(matches)?.shard(shard_of(matches)),
        Some(("submit", matches)) => Job::of(matches)?.submit(matches),
        _ => {
            let options = RobotOptions {
                loads: matches.get_flag("loads"),
                lives: matches.get_one::<String>("lives").map(|name| InputFile(name.clone())),
            };
            Job::of(matches)?.whole(&options)
        }
    }
}

/// A robot file with its places.
struct Job {
    path: PathBuf,
    file: RobotFile,
    out: PathBuf,
    host: Terminal,
    force: bool,
    quiet: bool,
}

impl Job {
    fn of(matches: &ArgMatches) -> Result<Job, Failure> {
        let Some(path) = matches.get_one::<PathBuf>("ROBOT") else { unreachable!("clap requires a robot") };
        take_threads(matches)?;
        let (force, quiet) = (matches.get_flag("force"), matches.get_flag("quiet"));
        let beside = || Path::new("out").join(path.file_stem().unwrap_or(path.as_os_str())).join("robot");
        let out = matches.get_one::<PathBuf>("out").cloned().unwrap_or_else(beside);
        let chosen = matches.try_get_one::<PathBuf>("cache").ok().flatten().map(|chosen| Cache::new(chosen));
        let host = Terminal::new(path, &out, chosen.unwrap_or_else(|| Cache::of_user(&out)), quiet);
        Ok(Job { path: path.clone(), file: read(path)?, out, host, force, quiet })
    }

    fn parts(&self) -> Parts {
        Parts::new(&self.out.join("parts"))
    }

    fn whole(&self, options: &RobotOptions) -> Result<Ending, Failure> {
        let results = Results::prepare_for(&self.out, &self.file.name, self.force)?;
        let robot = answer(&self.file, options, &self.host, &self.parts())
            .map_err(|error| failure(error, &self.file))?;
        self.host.clear();
        publish(&robot, results, self.quiet, &self.out)?;
        Ok(Ending::Fine)
    }

    /// The robot before its lives, and the plan of its population.
    fn population(&self) -> Result<(Loaded<'_>, Plan), Failure> {
        let of_file = |error| failure(error, &self.file);
        let loaded = Loaded::of(&self.file, &self.host).map_err(of_file)?;
        let plan = loaded.population_plan().map_err(of_file)?.ok_or_else(|| Failure::Usage {
            message: format!("{} has no drawn robots", self.path.display()),
            help: "add a section [population] with robots = 20, or use `arcmin robot`".to_owned(),
        })?;
        Ok((loaded, plan))
    }

    fn shard(&self, shard: Shard) -> Result<Ending, Failure> {
        let (loaded, plan) = self.population()?;
        let done = loaded
            .draw(&plan, shard, &self.parts(), &self.host)
            .map_err(|error| failure(error, &self.file))?;
        self.host.clear();
        if !self.quiet {
            print_line(&study::counted("drawn robots", &done))?;
        }
        Ok(Ending::Fine)
    }

    fn submit(&self, matches: &ArgMatches) -> Result<Ending, Failure> {
        let plan = self.population()?.1;
        let is_complete = || Ok(collect(&plan, &self.parts()).map_err(broken)?.is_complete());
        let shards = engines::Shards {
            run: "robot run",
            report: "robot",
            file: &self.path,
            out: &self.out,
            parts: plan.parts(),
            stages: 1,
            is_complete: &is_complete,
        };
        match engines::run(&shards, matches)? {
            true => self.whole(&RobotOptions::default()),
            false => Ok(Ending::Fine),
        }
    }
}

fn read(path: &Path) -> Result<RobotFile, Failure> {
    const LARGEST: u64 = 1 << 24;
    let bytes = read_bounded(path, LARGEST).map_err(|cause| Failure::Read {
        path: path.to_owned(),
        cause,
        start: Start::Robot,
    })?;
    let text = text_of(path, &bytes)?;
    let name = path.display().to_string();
    RobotFile::parse(&text, &name).map_err(|error| match Design::parse(&text, &name) {
        Ok(_) => Failure::Usage {
            message: format!("{name} is the design of a reducer, not a robot"),
            help: "`arcmin robot new FILE` writes a robot file; its [[joint]] sections name designs"
                .to_owned(),
        },
        Err(_) => Failure::design(error, &text),
    })
}

/// Errors of the robot file are shown with its text. Finished work is kept: lives of joints in the cache, drawn robots
/// in parts.
fn failure(error: AnalysisError, file: &RobotFile) -> Failure {
    match error {
        AnalysisError::Stopped => Failure::Unfinished {
            reason: format!("stopped; `{}` continues from there", crate::command_line()),
        },
        AnalysisError::Design(error) if error.file_name == file.file_name() => {
            Failure::design(error, file.text())
        }
        error => Failure::Analysis { error, options: None, finding: None },
    }
}

fn publish(robot: &Robot, mut results: Results, quiet: bool, out: &Path) -> Result<(), Failure> {
    for table in Robot::tables(robot) {
        results.file(&table.file_name(), table.to_csv().as_bytes())?;
    }
    let attachments =
        robot.attachments().map_err(|error| Failure::Analysis { error, options: None, finding: None })?;
    for attachment in attachments {
        results.file(&attachment.name, &attachment.bytes)?;
    }
    let short = robot.hash.get(..12).unwrap_or_default().to_owned();
    let mut page = robot.page();
    page.provenance = Provenance {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        design_hash: short.clone(),
        command: crate::command_line(),
        seeds: robot.seeds.clone(),
    };
    results.file("report.html", page.render().as_bytes())?;
    let mut summary = robot.summary().to_json();
    summary.insert("arcmin_version".to_owned(), json!(env!("CARGO_PKG_VERSION")));
    summary.insert("command".to_owned(), json!("robot"));
    summary.insert("command_line".to_owned(), json!(crate::typed()));
    summary
        .insert("design".to_owned(), json!({ "name": robot.name, "hash": robot.hash, "short_hash": short }));
    let names = results.publish(summary)?;
    if !quiet {
        print_line(&terminal_text(&robot.text_blocks()))?;
        print_line(&format!("{} in {}", names.join(", "), out.display()))?;
    }
    Ok(())
}

fn write_new(matches: &ArgMatches) -> Result<Ending, Failure> {
    let Some(path) = matches.get_one::<PathBuf>("FILE") else { unreachable!("clap requires a file") };
    let force = matches.get_flag("force");
    let example = example();
    let beside = path.parent().unwrap_or(Path::new(""));
    let mut files = vec![(path.clone(), example.text)];
    files.extend(example.designs.iter().map(|(name, text)| (beside.join(name), *text)));
    for (path, text) in &files {
        // An existing design with the same text is not an error.
        let same = std::fs::read(path).is_ok_and(|there| there == text.as_bytes());
        if path.exists() && !same && !force {
            return Err(Failure::Exists { path: path.clone() });
        }
    }
    for (path, text) in &files {
        write_file(path, text.as_bytes())?;
    }
    let names: Vec<String> = files[1..].iter().map(|(path, _)| path.display().to_string()).collect();
    print_line(&format!(
        "{}: six-axis arm for 20 kg, with {}\nnext: arcmin robot {}",
        path.display(),
        names.join(", "),
        path.display()
    ))?;
    Ok(Ending::Fine)
}
