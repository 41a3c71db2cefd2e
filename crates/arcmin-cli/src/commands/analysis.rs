//! All analyses in the same way: read the design, print its error findings, run, write results, print the text.

use std::path::{Path, PathBuf};

use arcmin::analyses::{Analysis, AnalysisError, Outcome};
use arcmin::checks::{Finding, Severity};
use arcmin::design::SectionSchema;
use arcmin::study::band::MACHINES;
use clap::ArgMatches;
use serde_json::json;

use super::Ending;
use super::study::Lives;
use crate::arguments::{options_text, take_threads};
use crate::failure::Failure;
use crate::run::{
    Cache, Results, Terminal, is_checkpointed, print_findings, print_line, read_any_design, terminal_text,
    write_file,
};

pub fn run(analysis: &'static Analysis, matches: &ArgMatches) -> Result<Ending, Failure> {
    let Some(path) = matches.get_one::<PathBuf>("DESIGN") else { unreachable!("clap requires a design") };
    let design = read_any_design(path)?;
    take_threads(matches)?;
    let options = options_text(analysis, matches);
    let schema = (analysis.options)();
    let is_check = analysis.name == "check";
    let errors: Vec<Finding> =
        design.findings().into_iter().filter(|finding| finding.severity == Severity::Error).collect();
    let drawing = if is_check { matches.get_one::<PathBuf>("drawing") } else { None };
    if let Some(file) = drawing {
        write_file(file, design.dimension_drawing().as_bytes())?;
    }
    if is_check && matches.get_flag("json") {
        let host = Terminal::new(path, Path::new("."), Cache::of_user(Path::new(".")), true);
        let outcome = answered(design.run(analysis, &options, "the options", &host), schema, &errors)?;
        let text = serde_json::to_string_pretty(&outcome.summary().to_json());
        print_line(&text.map_err(|cause| Failure::Json { cause: cause.to_string() })?)?;
        return Ok(ending_of(found_by_check(outcome.as_ref())));
    }
    let needs_band = analysis.name == "life" && matches.get_flag("band");
    let quiet = matches.get_flag("quiet");
    let out = matches.get_one::<PathBuf>("out").cloned().unwrap_or_else(|| {
        Path::new("out").join(path.file_stem().unwrap_or(path.as_os_str())).join(analysis.name)
    });
    let mut results = Results::prepare_for(&out, design.name(), matches.get_flag("force"))?;
    if !is_check {
        for finding in &errors {
            crate::failure::warn(&format!("ERROR {}: {}", finding.code, finding.message));
        }
    }
    let chosen = matches.get_one::<PathBuf>("cache").map(|chosen| Cache::new(chosen));
    let cache = chosen.unwrap_or_else(|| Cache::of_user(&out));
    let host = Terminal::new(path, &out, cache, quiet);
    let identity = answered(design.identity(analysis, &options, "the options", &host), schema, &errors)?;
    host.set_identity(&identity);
    let outcome = answered(design.run(analysis, &options, "the options", &host), schema, &errors)?;
    host.clear();
    let found = if is_check { found_by_check(outcome.as_ref()) } else { errors.len() };
    let lives = if needs_band {
        let machines = matches.get_one::<u64>("band-machines").copied().unwrap_or(MACHINES);
        Some(Lives::compute(&design, &options, machines, &host, &out, quiet)?)
    } else {
        None
    };

    for table in outcome.tables() {
        results.file(&table.file_name(), table.to_csv().as_bytes())?;
    }
    for attachment in answered(outcome.attachments(), schema, &errors)? {
        results.file(&attachment.name, &attachment.bytes)?;
    }
    let mut page = outcome.page();
    if let Some(lives) = &lives {
        let band = lives.band();
        page.verdict.headline = format!("{} {}", page.verdict.headline, band.sentence());
        page.sections.extend(band.sections());
        results.file("band.csv", lives.csv().as_bytes())?;
    }
    page.provenance = crate::provenance(&design.hash(), outcome.seeds());
    results.file("report.html", page.render().as_bytes())?;
    let mut summary = outcome.summary().to_json();
    summary.insert("arcmin_version".to_owned(), json!(env!("CARGO_PKG_VERSION")));
    summary.insert("command".to_owned(), json!(analysis.name));
    summary.insert("identity".to_owned(), json!(identity));
    summary.insert("command_line".to_owned(), json!(crate::typed()));
    summary.insert(
        "design".to_owned(),
        json!({ "name": design.name(), "hash": design.hash(), "short_hash": &design.hash()[..12] }),
    );
    if let Some(lives) = &lives {
        summary.insert("band".to_owned(), lives.band().to_json());
    }
    summary.insert("error_findings".to_owned(), json!(found));
    let names = results.publish(summary)?;
    host.discard_checkpoint();
    if !quiet {
        let text = terminal_text(&outcome.text_blocks());
        if is_check {
            print_findings(&text)?
        } else {
            print_line(&text)?
        }
        if let Some(lives) = &lives {
            print_line(&terminal_text(&lives.band().text_blocks()))?;
        }
        if let Some(file) = drawing {
            print_line(&format!("drawing in {}", file.display()))?;
        }
        print_line(&format!("{} in {}", names.join(", "), out.display()))?;
    }
    match outcome.failure() {
        Some(reason) => Err(Failure::Unfinished { reason }),
        None => Ok(ending_of(found)),
    }
}

/// Error findings of `check`, including those about the files that a design names.
fn found_by_check(outcome: &dyn Outcome) -> usize {
    outcome.summary().number("errors").map_or(0, |errors| errors as usize)
}

fn ending_of(errors: usize) -> Ending {
    if errors == 0 { Ending::Fine } else { Ending::ErrorFindings }
}

/// An error of an analysis as the command prints it. If the design has error findings, the first one is printed as the
/// probable cause.
fn answered<T>(
    result: Result<T, AnalysisError>,
    options: &'static SectionSchema,
    findings: &[Finding],
) -> Result<T, Failure> {
    result.map_err(|error| {
        if matches!(error, AnalysisError::Stopped) && is_checkpointed() {
            return Failure::Ended;
        }
        let finding = findings.first().cloned().map(Box::new);
        Failure::Analysis { error, options: Some(options), finding }
    })
}
