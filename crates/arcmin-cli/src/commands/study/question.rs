//! `arcmin study tighten DESIGN`: a template of a study applied to a design directly.

use std::path::{Path, PathBuf};

use arcmin::study::templates::{TEMPLATES, Template};
use clap::{Arg, ArgMatches, Command, value_parser};

use super::{Ending, Job, common, use_threads};
use crate::failure::{Failure, Start};
use crate::run::{print_line, read_any_design, write_file};

/// Name of the study file in the directory of the results.
const FILE: &str = "study.toml";

pub fn template(name: &str) -> Option<&'static Template> {
    TEMPLATES.iter().find(|template| template.name == name)
}

pub fn commands() -> Vec<Command> {
    let command = |template: &'static Template| {
        let about = format!("For one design: {}", template.summary);
        common(
            Command::new(template.name)
                .about(about.clone())
                .long_about(format!(
                    "{about}.\n\nRuns the study template of this name on the design. The study file {FILE} stays in \
                     the result directory; edit it and run it again with `arcmin study`."
                ))
                .after_help(format!("Examples:\n  arcmin study {} my-reducer.toml", template.name))
                .arg(
                    Arg::new("DESIGN")
                        .required(true)
                        .value_parser(value_parser!(PathBuf))
                        .help("Design file (TOML); `arcmin new` writes one"),
                ),
        )
    };
    TEMPLATES.iter().map(command).collect()
}

pub fn run(name: &str, matches: &ArgMatches) -> Result<Ending, Failure> {
    let (Some(template), Some(design)) = (template(name), matches.get_one::<PathBuf>("DESIGN")) else {
        unreachable!("clap requires a design");
    };
    use_threads(matches)?;
    let out = matches.get_one::<PathBuf>("out").cloned().unwrap_or_else(|| {
        Path::new("out").join(design.file_stem().unwrap_or(design.as_os_str())).join(name)
    });
    // The path of the design in the file is relative to the file.
    let whole = std::fs::canonicalize(design).map_err(|cause| Failure::Read {
        path: design.clone(),
        cause,
        start: Start::Design,
    })?;
    std::fs::create_dir_all(&out).map_err(|cause| Failure::Write { path: out.clone(), cause })?;
    let path = out.join(FILE);
    let family = read_any_design(design)?.family();
    write_file(&path, template.about(&whole.display().to_string(), family).as_bytes())?;
    let job = Job::at(&path, out, matches)?;
    if !job.quiet {
        print_line(&format!("{}; the study file is {}", template.summary, path.display()))?;
    }
    job.whole()
}
