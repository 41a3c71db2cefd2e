//! `arcmin study`: many machines, on this machine or on an engine for shards.

mod band;
pub(super) mod engines;
mod new;
mod question;
mod search;

pub use band::Lives;

use std::path::{Path, PathBuf};

use arcmin::analyses::stage::AnyDesign;
use arcmin::analyses::{Quiet, by_name};
use arcmin::design::Choice;
use arcmin::report::Page;
use arcmin::study::{Done, Plan, Row, Rows, Shard, Study, StudyFile, Watch, collect, run as run_shard};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use serde_json::{Map, Value, json};

use super::Ending;
use crate::failure::{Failure, Start};
use crate::run::{
    Cache, Parts, Results, SampleBar, Terminal, print_line, read_any_design, terminal_text, text_of,
    write_file,
};

const GUIDE: &str = "\
A study computes many machines. The study file (TOML) names a design, an analysis with its options, the keys that
vary, the method of sampling, and the results to keep.

Results: samples.csv (one machine a row), summary.json (statistics with intervals) and report.html. Every machine is
written to parts/ when it is computed; after a stop or a kill the same command continues with the missing ones. Sample k
depends only on the seed and on k, so every distribution of the work gives the same rows.";

const EXAMPLES: &str = "Examples:
  arcmin study new yield my-study.toml       write a commented study file to start from
  arcmin study my-study.toml                 run it on this machine
  arcmin study tighten my-reducer.toml       run a template on a design directly
  arcmin study run my-study.toml --shard 3/50 --out shared/study
  arcmin study collect my-study.toml --out shared/study
  arcmin study submit my-study.toml --engine slurm --shards 50 --out shared/study";

pub fn command() -> Command {
    let with = |command: Command| common(command.arg(file(true)));
    // The directory of a planned study contains the name of its file.
    let planned = |command: Command| {
        common(command.arg(file(false).help("Study file [default: the one planned in --out]")))
    };
    Command::new("study")
        .about("Compute many machines: sweeps, tolerances, unknowns, sensitivity, optimisation")
        .long_about(GUIDE)
        .after_help(EXAMPLES)
        .args_conflicts_with_subcommands(true)
        .subcommand_negates_reqs(true)
        .subcommand_help_heading("Steps")
        .arg(file(true))
        .arg(out())
        .arg(threads())
        .arg(force())
        .arg(quiet())
        .subcommand(new::command())
        .subcommands(question::commands())
        .subcommand(with(Command::new("plan").about("Choose the samples and write plan.csv and plan.json")))
        .subcommand(planned(
            Command::new("run").about("Compute one shard of the samples and keep it in parts/").arg(shard()),
        ))
        .subcommand(planned(engines::command("study", "my-study.toml")))
        .subcommand(planned(
            Command::new("collect")
                .about("Write samples.csv, summary.json and report.html from the parts computed so far"),
        ))
}

pub(super) fn common(command: Command) -> Command {
    command.arg(out()).arg(threads()).arg(force()).arg(quiet())
}

fn file(required: bool) -> Arg {
    Arg::new("STUDY")
        .required(required)
        .value_parser(value_parser!(PathBuf))
        .help("Study file (TOML); `arcmin study new` writes one")
}

pub(super) fn shard() -> Arg {
    Arg::new("shard")
        .long("shard")
        .value_name("I/N")
        .default_value("1/1")
        .value_parser(|text: &str| Shard::parse(text).ok_or("write I/N with I from 1 to N, such as 3/50"))
        .help("Number of the shard, of how many shards")
}

/// The shard given by the argument [`shard`].
pub(super) fn shard_of(matches: &ArgMatches) -> Shard {
    matches.get_one::<Shard>("shard").copied().unwrap_or(Shard::WHOLE)
}

fn out() -> Arg {
    Arg::new("out")
        .long("out")
        .value_name("DIR")
        .value_parser(value_parser!(PathBuf))
        .help("Directory for the results [default: out/<study>]")
}

fn threads() -> Arg {
    Arg::new("threads")
        .long("threads")
        .value_name("N")
        .value_parser(value_parser!(u16).range(1..=1024))
        .help("Number of samples computed at once; results do not depend on it [default: all cores]")
}

fn force() -> Arg {
    Arg::new("force").long("force").action(ArgAction::SetTrue).help("Overwrite the results of another design")
}

fn quiet() -> Arg {
    Arg::new("quiet").long("quiet").short('q').action(ArgAction::SetTrue).help("Print nothing but errors")
}

fn use_threads(matches: &ArgMatches) -> Result<(), Failure> {
    if let Some(threads) = matches.get_one::<u16>("threads") {
        let pool = rayon::ThreadPoolBuilder::new().num_threads((*threads).into()).build_global();
        pool.map_err(|cause| Failure::Threads { cause: cause.to_string() })?;
    }
    Ok(())
}

pub fn run(matches: &ArgMatches) -> Result<Ending, Failure> {
    match matches.subcommand() {
        Some(("new", matches)) => new::run(matches),
        Some((name, matches)) if question::template(name).is_some() => question::run(name, matches),
        Some(("submit", matches)) => Job::of(matches)?.submit(matches),
        Some(("plan", matches)) => Job::of(matches)?.plan(),
        Some(("run", matches)) => Job::of(matches)?.shard(shard_of(matches)),
        Some(("collect", matches)) => Job::of(matches)?.collect(),
        _ => Job::of(matches)?.whole(),
    }
}

const PLAN: &str = "plan.json";

/// A study with its files and directories.
struct Job {
    path: PathBuf,
    design_path: PathBuf,
    study: Study,
    out: PathBuf,
    force: bool,
    quiet: bool,
}

impl Job {
    fn of(matches: &ArgMatches) -> Result<Job, Failure> {
        let given = matches.get_one::<PathBuf>("STUDY");
        let path = match (given, matches.get_one::<PathBuf>("out")) {
            (Some(path), _) => path.clone(),
            (None, Some(out)) => planned_in(out)?,
            (None, None) => {
                let message = "the study file is missing".to_owned();
                let help = "name the file, or give --out with the directory of a planned study".to_owned();
                return Err(Failure::Usage { message, help });
            }
        };
        let path = &path;
        use_threads(matches)?;
        let out = matches
            .get_one::<PathBuf>("out")
            .cloned()
            .unwrap_or_else(|| Path::new("out").join(path.file_stem().unwrap_or(path.as_os_str())));
        Job::at(path, out, matches)
    }

    /// The study of a file with results in `out`.
    fn at(path: &Path, out: PathBuf, matches: &ArgMatches) -> Result<Job, Failure> {
        let (design_path, study) = read(path, &out)?;
        let (force, quiet) = (matches.get_flag("force"), matches.get_flag("quiet"));
        Ok(Job { path: path.to_owned(), design_path, study, out, force, quiet })
    }

    fn parts(&self) -> Parts {
        Parts::new(&self.out.join("parts"))
    }

    /// Computes the missing rows on this machine, then writes the report.
    fn whole(&self) -> Result<Ending, Failure> {
        let results = Results::prepare_for(&self.out, self.study.design.name(), self.force)?;
        let cancelled = match &self.study.search {
            Some(search) => self.search(search)?,
            None => self.compute(&self.study.plan, "samples", Shard::WHOLE)?,
        };
        match self.report(results) {
            // A study stopped before its first sample has no rows; the error is then the stop, not the usage.
            Ok(()) | Err(Failure::Usage { .. }) if cancelled => Err(self.stopped()),
            reported => reported.map(|()| Ending::Fine),
        }
    }

    fn shard(&self, shard: Shard) -> Result<Ending, Failure> {
        let cancelled = match &self.study.search {
            Some(search) => self.search_stage(search, shard)?,
            None => self.compute(&self.study.plan, "samples", shard)?,
        };
        if cancelled { Err(self.stopped()) } else { Ok(Ending::Fine) }
    }

    fn submit(&self, matches: &ArgMatches) -> Result<Ending, Failure> {
        let plan = &self.study.plan;
        let is_complete = || match &self.study.search {
            Some(search) => Ok(self.standing(search)?.next.is_none()),
            None => Ok(collect(plan, &self.parts()).map_err(broken)?.is_complete()),
        };
        let shards = engines::Shards {
            run: "study run",
            report: "study collect",
            file: &self.path,
            out: &self.out,
            parts: plan.parts(),
            stages: self.study.search.as_ref().map_or(1, |search| search.generations + 2),
            is_complete: &is_complete,
        };
        if engines::run(&shards, matches)? { self.collect() } else { Ok(Ending::Fine) }
    }

    fn collect(&self) -> Result<Ending, Failure> {
        let results = Results::prepare_for(&self.out, self.study.design.name(), self.force)?;
        self.report(results)?;
        Ok(Ending::Fine)
    }

    fn stopped(&self) -> Failure {
        Failure::Unfinished {
            reason: format!("the study was stopped; `{}` continues from there", crate::command_line()),
        }
    }

    /// Computes the missing rows of a shard; returns whether it was cancelled.
    fn compute(&self, plan: &Plan, what: &str, shard: Shard) -> Result<bool, Failure> {
        let host = Terminal::new(&self.design_path, &self.out, Cache::of_user(&self.out.join("cache")), true);
        let parts = self.parts();
        let all: u64 = shard.parts(plan).map(|part| plan.rows_of(part).count() as u64).sum();
        let bar = SampleBar::new(what, all, self.quiet);
        let compute = |row: &Row| self.study.compute(row, &Quiet(&host));
        let begun = |found: u64| bar.found(found);
        let done =
            run_shard(plan, shard, &parts, &compute, &Watch { begun: &begun, finished: &|_| bar.one_more() })
                .map_err(broken)?;
        drop(bar);
        if !self.quiet && self.study.search.is_none() {
            print_line(&counted("samples", &done))?;
        }
        Ok(done.cancelled)
    }

    fn plan(&self) -> Result<Ending, Failure> {
        let plan = &self.study.plan;
        std::fs::create_dir_all(&self.out)
            .map_err(|cause| Failure::Write { path: self.out.clone(), cause })?;
        write_file(&self.out.join("plan.csv"), plan.to_csv().as_bytes())?;
        let study = std::fs::canonicalize(&self.path).map_err(|cause| Failure::Read {
            path: self.path.clone(),
            cause,
            start: Start::Study,
        })?;
        let manifest = json!({
            "arcmin_version": env!("CARGO_PKG_VERSION"),
            "study": study, "identity": plan.identity(),
            "rows": plan.rows(), "parts": plan.parts(), "rows_per_part": plan.rows_of(0).count(),
            "method": self.study.method.word(),
            "analysis": self.study.analysis.name,
        });
        let text = serde_json::to_string_pretty(&manifest)
            .map_err(|cause| Failure::Json { cause: cause.to_string() })?;
        write_file(&self.out.join(PLAN), format!("{text}\n").as_bytes())?;
        if !self.quiet {
            print_line(&format!(
                "{} samples in {} parts; plan.csv, plan.json in {}\nnext: {}",
                plan.rows(),
                plan.parts(),
                self.out.display(),
                format_args!(
                    "arcmin study run {} --shard 1/{} --out {}",
                    self.path.display(),
                    plan.parts().min(50),
                    self.out.display()
                ),
            ))?;
        }
        Ok(Ending::Fine)
    }

    fn nothing(&self) -> Failure {
        Failure::Usage {
            message: format!("there are no samples in {}", self.out.join("parts").display()),
            help: format!(
                "`arcmin study run {} --shard 1/1 --out {}` computes them; if they are in another directory, give it with --out",
                self.path.display(),
                self.out.display()
            ),
        }
    }

    /// Writes the results of the available rows.
    fn report(&self, mut results: Results) -> Result<(), Failure> {
        if let Some(search) = &self.study.search {
            return self.report_search(search, results);
        }
        let (study, parts) = (&self.study, self.parts());
        let rows: Rows = collect(&study.plan, &parts).map_err(broken)?;
        for (name, reason) in &rows.unusable {
            crate::failure::warn(&format!("parts/{name} is left out: {reason}"));
        }
        if rows.records.is_empty() {
            return Err(self.nothing());
        }
        let judged = study.judge(&rows).map_err(broken)?;
        let report = study.report(&rows, &judged);
        results.file("samples.csv", rows.to_csv(&study.plan).as_bytes())?;
        self.page(&mut results, report.page())?;
        let summary = match judged.to_json(&study.plan) {
            Value::Object(summary) => summary,
            other => Map::from_iter([("judged".to_owned(), other)]),
        };
        self.publish(results, summary, &terminal_text(&report.text_blocks()))
    }

    fn page(&self, results: &mut Results, mut page: Page) -> Result<(), Failure> {
        page.provenance =
            crate::provenance(&self.study.design.hash(), vec![self.study.plan.sampling().seed()]);
        results.file("report.html", page.render().as_bytes())
    }

    fn publish(&self, results: Results, mut summary: Map<String, Value>, text: &str) -> Result<(), Failure> {
        let study = &self.study;
        let mut put = |key: &str, value: Value| summary.insert(key.to_owned(), value);
        put("analysis", json!(study.analysis.name));
        put("method", json!(study.method.word()));
        put("seed", json!(study.plan.sampling().seed()));
        put("varied", json!(study.plan.factors().iter().map(|factor| &factor.path).collect::<Vec<_>>()));
        put("arcmin_version", json!(env!("CARGO_PKG_VERSION")));
        put("command", json!("study"));
        put("identity", json!(study.plan.identity()));
        put("command_line", json!(crate::typed()));
        let design = &study.design;
        put(
            "design",
            json!({ "name": design.name(), "hash": design.hash(), "short_hash": design.short_hash() }),
        );
        let names = results.publish(summary)?;
        if !self.quiet {
            print_line(text)?;
            print_line(&format!("{} in {}", names.join(", "), self.out.display()))?;
        }
        Ok(())
    }
}

/// The study file that `plan` has stored in a directory.
fn planned_in(out: &Path) -> Result<PathBuf, Failure> {
    let path = out.join(PLAN);
    let bytes = std::fs::read(&path).map_err(|cause| Failure::Usage {
        message: format!("no study is planned in {}: {cause}", out.display()),
        help: "name the study file, or run `arcmin study plan STUDY.toml` with the same --out".to_owned(),
    })?;
    let plan: Value = serde_json::from_slice(&bytes).unwrap_or(Value::Null);
    plan["study"].as_str().map(PathBuf::from).ok_or_else(|| Failure::Usage {
        message: format!("{} does not name a study", path.display()),
        help: "run `arcmin study plan STUDY.toml` again".to_owned(),
    })
}

/// Numbers of rows of a shard: computed, available before, and failed.
pub(super) fn counted(what: &str, done: &Done) -> String {
    let failed = match done.failed {
        0 => String::new(),
        failed => format!(", {failed} of them failed"),
    };
    let found = if done.found > 0 { format!(", {} were computed before", done.found) } else { String::new() };
    format!("{} {what} computed{failed}{found}", done.computed)
}

/// An error that does not come from the study file.
pub(super) fn broken(cause: impl ToString) -> Failure {
    Failure::Study { cause: cause.to_string() }
}

/// Reads a study and its design.
fn read(path: &Path, out: &Path) -> Result<(PathBuf, Study), Failure> {
    let bytes = std::fs::read(path).map_err(|cause| Failure::Read {
        path: path.to_owned(),
        cause,
        start: Start::Study,
    })?;
    let text = text_of(path, &bytes)?;
    let file = StudyFile::parse(&text, &path.display().to_string())
        .map_err(|error| Failure::design(error, &text))?;
    let design_path = path.parent().unwrap_or(Path::new("")).join(&file.design.0);
    let design = read_any_design(&design_path)?;
    let host = Terminal::new(&design_path, out, Cache::of_user(out), true);
    // Errors of the study or the design are shown with the text they were read from.
    let failure = |error: arcmin::analyses::AnalysisError| match error {
        arcmin::analyses::AnalysisError::Design(error) => {
            let of_design = error.file_name == design.file_name();
            Failure::design(error, if of_design { design.text() } else { &text })
        }
        error => Failure::Analysis { error, options: None, finding: None },
    };
    let identity = identity_of(&file, &design, &host).map_err(failure)?;
    let study = file.study(&design, &identity).map_err(failure)?;
    Ok((design_path, study))
}

/// Empty if no analysis has this name; the error is then reported by [`StudyFile::study`].
fn identity_of(
    file: &StudyFile,
    design: &AnyDesign,
    host: &Terminal,
) -> Result<String, arcmin::analyses::AnalysisError> {
    let Some(analysis) = by_name(&file.analysis) else { return Ok(String::new()) };
    design.identity(analysis, file.options(), file.file_name(), host)
}
