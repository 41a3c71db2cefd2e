//! `arcmin study submit` and `arcmin robot submit`: shards as processes on this machine, or on an engine.
//!
//! An engine only starts `arcmin study run --shard i/N` or `arcmin robot run`. If a worker, the scheduler or the machine
//! fails, the stored parts remain in the directory, and the next submission computes the missing ones.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::process::{Child, Command as Process, Stdio};
use std::time::Duration;

use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};

use super::broken;
use crate::failure::{Failure, Start};
use crate::run::{is_stopped, print_line, write_file};

/// Default number of shards: enough for a cluster, with a minute or more per shard in most studies.
const SHARDS: u64 = 64;
/// Number of starts of a shard that ends with an error.
const TRIES: u32 = 3;

/// `submit` of `study` or `robot`, with a file by this name in the examples.
pub fn command(of: &str, file: &str) -> Command {
    Command::new("submit")
        .about("Compute all shards on an engine: local processes, HyperQueue, Slurm or Dask")
        .long_about(format!(
            "Computes all shards on an engine, then reports.\n\nThe engine local starts processes on this machine. \
             The engines hq, slurm and dask write a script to DIR/submit, which may be edited, and run it if the command of \
             the engine is installed: hq, sbatch, or python3 with dask.distributed. Every job runs `arcmin {of} \
             run --shard I/N`; all machines need access to the directory.\n\nAn optimisation is submitted \
             generation by generation."
        ))
        .after_help(format!(
            "Examples:\n  arcmin {of} submit {file} --engine local --workers 8\n  \
             arcmin {of} submit {file} --engine slurm --shards 200 --out /shared/{of} --print"
        ))
        .arg(
            Arg::new("engine")
                .long("engine")
                .default_value("local")
                .value_parser(PossibleValuesParser::new(["local", "hq", "slurm", "dask"]))
                .help("Engine that runs the shards"),
        )
        .arg(
            Arg::new("shards")
                .long("shards")
                .value_name("N")
                .value_parser(value_parser!(u64).range(1..=1_000_000))
                .help("Number of shards [default: 64, or the number of parts if smaller]"),
        )
        .arg(
            Arg::new("workers")
                .long("workers")
                .value_name("N")
                .value_parser(value_parser!(u16).range(1..=4096))
                .help("Number of processes at once (local, and dask on this machine) [default: all cores]"),
        )
        .arg(
            Arg::new("address")
                .long("address")
                .value_name("HOST:PORT")
                .help("Address of a running Dask scheduler"),
        )
        .arg(Arg::new("print").long("print").action(ArgAction::SetTrue).help("Write the script without running it"))
}

/// Task of an engine.
pub struct Shards<'a> {
    /// Words between `arcmin` and the file: for a shard, and for the report after all shards.
    pub run: &'static str,
    pub report: &'static str,
    pub file: &'a Path,
    pub out: &'a Path,
    /// Number of parts in which shards are computed.
    pub parts: u64,
    /// Times that all shards are submitted: once, or once a generation.
    pub stages: u64,
    /// Whether nothing is left to compute.
    pub is_complete: &'a dyn Fn() -> Result<bool, Failure>,
}

/// Computes all shards; returns whether the report is still to be written.
pub fn run(job: &Shards<'_>, matches: &ArgMatches) -> Result<bool, Failure> {
    let most = job.parts.max(1);
    // For a search, the parts of one generation.
    let shards = matches.get_one::<u64>("shards").copied().unwrap_or(most.min(SHARDS)).max(1);
    let workers = matches.get_one::<u16>("workers").map(|workers| usize::from(*workers));
    let workers = workers.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let engine = matches.get_one::<String>("engine").map_or("local", String::as_str);
    if engine == "local" {
        local(job, shards, workers)?;
        return Ok(true);
    }
    let words = Words::of(job, shards, workers, matches.get_one::<String>("address").cloned())?;
    let (name, text, program) = match engine {
        "hq" => ("hq.sh", words.hq(), "hq"),
        "slurm" => ("slurm.sh", words.slurm(), "sbatch"),
        // A script called dask.py would be imported in place of Dask.
        _ => ("on_dask.py", words.dask(), "python3"),
    };
    let directory = job.out.join("submit");
    std::fs::create_dir_all(&directory).map_err(|cause| Failure::Write { path: directory.clone(), cause })?;
    let script = directory.join(name);
    write_file(&script, text.as_bytes())?;
    let runner = if engine == "dask" { "python3" } else { "bash" };
    let typed = format!("{runner} {}", script.display());
    if matches.get_flag("print") {
        print_line(&format!("{} written; next: {typed}", script.display()))?;
        return Ok(false);
    }
    if !is_there(program) {
        return Err(Failure::Usage {
            message: format!("`{program}` is not installed on this machine"),
            help: format!("run `{typed}` on a machine with `{program}`, or use --engine local"),
        });
    }
    let ended = Process::new(runner).arg(&script).status();
    match ended {
        Ok(status) if status.success() => Ok(false),
        Ok(status) => Err(Failure::Study { cause: format!("`{typed}` ended with {status}") }),
        Err(cause) => Err(Failure::Study { cause: format!("`{typed}` cannot be started: {cause}") }),
    }
}

fn is_there(program: &str) -> bool {
    let paths = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&paths).any(|path| path.join(program).is_file())
}

/// Shards as processes, as many at once as there are workers.
fn local(job: &Shards<'_>, shards: u64, workers: usize) -> Result<(), Failure> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = (cores / workers).max(1);
    while !(job.is_complete)()? {
        let mut waiting: VecDeque<(u64, u32)> = (1..=shards).map(|shard| (shard, 0)).collect();
        let mut running: Vec<(u64, u32, Child)> = Vec::new();
        while !(waiting.is_empty() && running.is_empty()) {
            while running.len() < workers.min(shards as usize)
                && let Some((shard, tries)) = waiting.pop_front()
            {
                running.push((shard, tries, start(job, shard, shards, threads)?));
            }
            std::thread::sleep(Duration::from_millis(20));
            let mut still = Vec::new();
            for (shard, tries, mut child) in running {
                match child.try_wait() {
                    Ok(None) => still.push((shard, tries, child)),
                    Ok(Some(status)) if status.success() => {}
                    Ok(Some(_)) if tries + 1 < TRIES && !is_stopped() => {
                        waiting.push_back((shard, tries + 1))
                    }
                    Ok(Some(status)) => {
                        let message = format!("shard {shard} of {shards} ended with {status}");
                        return Err(Failure::Unfinished { reason: message });
                    }
                    Err(cause) => return Err(broken(cause)),
                }
            }
            running = still;
        }
    }
    Ok(())
}

fn start(job: &Shards<'_>, shard: u64, shards: u64, threads: usize) -> Result<Child, Failure> {
    let program = crate::program().map_err(broken)?;
    let mut process = Process::new(program);
    process.args(job.run.split(' ')).arg(job.file).args(["--shard", &format!("{shard}/{shards}")]);
    process.arg("--out").arg(job.out).args(["--threads", &threads.to_string(), "--quiet"]);
    process.stdin(Stdio::null()).spawn().map_err(broken)
}

/// Values inserted into scripts.
struct Words {
    program: String,
    run: &'static str,
    report: &'static str,
    file: String,
    out: String,
    shards: u64,
    workers: usize,
    /// Times that all shards are submitted: once, or once a generation.
    stages: u64,
    address: Option<String>,
}

impl Words {
    fn of(job: &Shards<'_>, shards: u64, workers: usize, address: Option<String>) -> Result<Words, Failure> {
        let refused = |cause| Failure::Write { path: job.out.to_owned(), cause };
        std::fs::create_dir_all(job.out).map_err(refused)?;
        // Scripts run in other directories: paths must be absolute.
        let whole = |path: &Path| -> Result<String, Failure> {
            let full = std::fs::canonicalize(path).map_err(|cause| Failure::Read {
                path: path.to_owned(),
                cause,
                start: Start::Study,
            })?;
            Ok(full.display().to_string())
        };
        let program: PathBuf = crate::program().map_err(broken)?;
        Ok(Words {
            program: whole(&program)?,
            run: job.run,
            report: job.report,
            file: whole(job.file)?,
            out: whole(job.out)?,
            shards,
            workers,
            stages: job.stages,
            address,
        })
    }

    fn shell(word: &str) -> String {
        format!("'{}'", word.replace('\'', "'\\''"))
    }

    fn hq(&self) -> String {
        self.filled(HQ, Words::shell)
    }

    fn slurm(&self) -> String {
        self.filled(SLURM, Words::shell)
    }

    fn dask(&self) -> String {
        self.filled(DASK, Words::python)
    }

    fn python(word: &str) -> String {
        serde_json::Value::String(word.to_owned()).to_string()
    }

    fn filled(&self, script: &str, quoted: fn(&str) -> String) -> String {
        let address = self.address.as_deref().map_or("None".to_owned(), quoted);
        script
            .replace("{arcmin}", &quoted(&self.program))
            .replace("{run}", self.run)
            .replace("{report}", self.report)
            .replace("{file}", &quoted(&self.file))
            .replace("{out}", &quoted(&self.out))
            .replace("{shards}", &self.shards.to_string())
            .replace("{workers}", &self.workers.to_string())
            .replace("{stages}", &self.stages.to_string())
            .replace("{address}", &address)
    }
}

const HQ: &str = include_str!("hq.sh");
const SLURM: &str = include_str!("slurm.sh");
const DASK: &str = include_str!("dask.py");

#[cfg(test)]
mod tests {
    use super::*;

    fn words() -> Words {
        Words {
            program: "/opt/it's/arcmin".into(),
            run: "study run",
            report: "study collect",
            file: "/home/a b/study.toml".into(),
            out: "/shared/out".into(),
            shards: 50,
            workers: 4,
            stages: 3,
            address: None,
        }
    }

    /// Every script names the shard as its engine counts it, quotes what a shell would split, and leaves no
    /// place unfilled.
    #[test]
    fn scripts_follow_the_conventions_of_engines() {
        let hq = words().hq();
        assert!(hq.contains("hq submit --array \"1-$shards\"") && hq.contains("$HQ_TASK_ID/$2"), "{hq}");
        assert!(hq.contains("arcmin='/opt/it'\\''s/arcmin'\nfile='/home/a b/study.toml'"), "{hq}");
        assert!(hq.contains("for stage in $(seq 3)") && hq.contains("%{TASK_ID}"), "{hq}");
        let slurm = words().slurm();
        assert!(slurm.contains("--array=\"1-$shards\"") && slurm.contains("$SLURM_ARRAY_TASK_ID/$shards"));
        assert!(slurm.contains("--dependency=\"afterany:${job%%;*}\"") && slurm.contains("study collect"));
        let dask = words().dask();
        assert!(
            dask.contains("FILE = \"/home/a b/study.toml\"") && dask.contains("ADDRESS = None"),
            "{dask}"
        );
        assert!(
            ["{arcmin}", "{run}", "{report}", "{file}", "{out}", "{shards}"]
                .iter()
                .all(|place| !dask.contains(place))
        );
    }

    /// A shell reads them.
    #[cfg(unix)]
    #[test]
    fn scripts_are_shell() {
        for text in [words().hq(), words().slurm()] {
            let mut shell = Process::new("bash").args(["-n"]).stdin(Stdio::piped()).spawn().unwrap();
            std::io::Write::write_all(&mut shell.stdin.take().unwrap(), text.as_bytes()).unwrap();
            assert!(shell.wait().unwrap().success(), "{text}");
        }
    }
}
