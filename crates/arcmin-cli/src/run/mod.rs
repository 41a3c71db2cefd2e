//! What all commands share: reading the design, the output directory, tables, summary, progress.

mod columns;
mod output;
mod progress;
mod table;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use arcmin::design::Design;
use serde_json::{Value, json};

use crate::failure::Failure;
pub use columns::Columns;
pub use output::{say, write_file};
pub use table::{Cell, Table};

/// Options of every command that computes something from a design.
#[derive(Debug, clap::Args)]
pub struct Common {
    /// Design file (TOML); `arcmin new` writes one.
    pub design: PathBuf,
    /// Directory for the results [default: out/<design>/<command>].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Threads to compute with; the results do not depend on it [default: all cores].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
}

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    Fine,
    ErrorFindings,
}

impl Verdict {
    pub fn exit_code(self) -> ExitCode {
        match self {
            Verdict::Fine => ExitCode::SUCCESS,
            Verdict::ErrorFindings => ExitCode::from(1),
        }
    }
}

/// One run of a command on a design.
///
/// Files are staged beside their final names and renamed together by [`Run::finish`], `summary.json` last:
/// whoever finds a summary finds the tables that belong to it, and a run that is killed while it computes
/// leaves the results of the one before.
pub struct Run {
    pub design: Design,
    command: &'static str,
    out: PathBuf,
    quiet: bool,
    staged: Vec<output::Staged>,
    progress: progress::Bar,
}

impl Run {
    /// Reads the design and makes sure that results can be written before anything is computed.
    pub fn start(command: &'static str, common: &Common) -> Result<Run, Failure> {
        let design = read_design(&common.design)?;
        let stem = common.design.file_stem().unwrap_or(common.design.as_os_str());
        let out = common.out.clone().unwrap_or_else(|| Path::new("out").join(stem).join(command));
        output::prepare(&out)?;
        if let Some(threads) = common.threads {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads.into())
                .build_global()
                .map_err(Failure::compute("start the threads"))?;
        }
        Ok(Run {
            design,
            command,
            out,
            quiet: common.quiet,
            staged: Vec::new(),
            progress: progress::Bar::new(common.quiet),
        })
    }

    /// To be handed to long computations: shows a bar where that makes sense and carries Ctrl-C.
    pub fn progress(&self) -> &dyn arcmin::progress::Progress {
        &self.progress
    }

    /// Whether lines for the user are wanted.
    pub fn say(&self, line: &str) {
        if !self.quiet {
            self.progress.clear();
            say(line);
        }
    }

    /// Path of a file in the output directory.
    pub fn path(&self, name: &str) -> PathBuf {
        self.out.join(name)
    }

    /// Stages a table, e.g. `contact.csv`.
    pub fn table(&mut self, name: &str, table: Table) -> Result<(), Failure> {
        self.file(name, table.into_bytes().as_slice())
    }

    /// Stages any other file.
    pub fn file(&mut self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        self.staged.push(output::Staged::write(&self.out, name, bytes)?);
        Ok(())
    }

    /// Adds version, design and command line to the summary, writes it, and gives all files their final
    /// names.
    pub fn finish(mut self, summary: Value) -> Result<(), Failure> {
        let Value::Object(mut summary) = summary else { unreachable!("a summary is an object") };
        self.progress.clear();
        summary.insert("arcmin_version".to_owned(), json!(env!("CARGO_PKG_VERSION")));
        summary.insert("command".to_owned(), json!(self.command));
        summary.insert(
            "command_line".to_owned(),
            json!(
                std::env::args_os()
                    .skip(1)
                    .map(|argument| argument.to_string_lossy().into_owned())
                    .collect::<Vec<_>>()
            ),
        );
        summary.insert("design".to_owned(), json!({ "name": *self.design.name, "hash": self.design.hash(), "short_hash": self.design.short_hash() }));
        let mut text = serde_json::to_string_pretty(&Value::Object(summary))
            .map_err(Failure::compute("write the summary"))?;
        text.push('\n');
        self.file("summary.json", text.as_bytes())?;
        let names: Vec<String> = self.staged.iter().map(|staged| staged.name().to_owned()).collect();
        // From here to the new summary there is none: the old one must not stand beside new tables.
        output::remove(&self.out.join("summary.json"))?;
        for staged in std::mem::take(&mut self.staged) {
            staged.publish()?;
        }
        self.say(&format!("{} in {}", names.join(", "), self.out.display()));
        Ok(())
    }
}

/// Reads and parses a design file.
pub fn read_design(path: &Path) -> Result<Design, Failure> {
    let bytes = std::fs::read(path).map_err(|cause| Failure::Read { path: path.to_owned(), cause })?;
    let text = String::from_utf8(bytes).map_err(|error| Failure::Read {
        path: path.to_owned(),
        cause: std::io::Error::new(std::io::ErrorKind::InvalidData, error),
    })?;
    Design::parse(&text, &path.display().to_string()).map_err(|error| Failure::design(error, &text))
}

/// Running hours on the command line: finite and not negative.
pub fn hours(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(hours) if (0.0..=1e7).contains(&hours) => Ok(hours),
        Ok(_) => Err("running hours lie between 0 and 1e7".to_owned()),
        Err(_) => Err("running hours are a number such as 2000".to_owned()),
    }
}

/// A wear depth on the command line: finite, not negative, no deeper than a flank is believed to survive.
pub fn depth_um(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(depth) if (0.0..=1000.0).contains(&depth) => Ok(depth),
        Ok(_) => Err("a depth lies between 0 and 1000 µm".to_owned()),
        Err(_) => Err("a depth in µm is a number such as 60".to_owned()),
    }
}
