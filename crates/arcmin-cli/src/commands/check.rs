use arcmin::checks::{Finding, Severity, check_design, worst};
use serde_json::json;

use crate::failure::Failure;
use crate::run::{Common, Run, Table, Verdict};

#[derive(Debug, clap::Args)]
#[command(
    long_about = "Judges a design. Each finding has a code, a value and a limit; warnings and errors also say why they matter and what to change.\n\n\
                  findings.csv and summary.json hold all of them. The exit status is 1 if there is an error finding.",
    after_help = "Examples:\n  arcmin check my-reducer.toml\n  arcmin check my-reducer.toml --explain"
)]
pub struct Options {
    #[command(flatten)]
    common: Common,
    /// Explain every check, passed ones included.
    #[arg(long)]
    explain: bool,
}

pub fn run(options: Options) -> Result<Verdict, Failure> {
    let mut run = Run::start("check", &options.common)?;
    let findings = check_design(&run.design);
    let mut table = Table::new(&["code", "severity", "value", "limit", "unit", "message", "why", "change"]);
    for finding in &findings {
        table.row(&[
            finding.code.into(),
            finding.severity.word().into(),
            finding.value.into(),
            finding.limit.into(),
            finding.unit.into(),
            finding.message.as_str().into(),
            finding.why.into(),
            finding.change.into(),
        ]);
    }
    run.table("findings.csv", table)?;
    for finding in &findings {
        run.say(&line(finding));
        if options.explain || finding.severity > Severity::Info {
            run.say(&format!("           why: {}\n           change: {}", finding.why, finding.change));
        }
    }
    let count = |severity| findings.iter().filter(|finding| finding.severity == severity).count();
    let (errors, warnings) = (count(Severity::Error), count(Severity::Warning));
    run.say(&format!("{} checks: {errors} errors, {warnings} warnings", findings.len()));
    let listed: Vec<_> = findings
        .iter()
        .map(|finding| {
            json!({
                "code": finding.code, "severity": finding.severity.word(), "message": finding.message, "value": finding.value,
                "limit": finding.limit, "unit": finding.unit, "why": finding.why, "change": finding.change,
            })
        })
        .collect();
    run.finish(json!({ "errors": errors, "warnings": warnings, "findings": listed }))?;
    Ok(if worst(&findings) == Severity::Error { Verdict::ErrorFindings } else { Verdict::Fine })
}

fn line(finding: &Finding) -> String {
    let mark = match finding.severity {
        Severity::Info => "ok     ",
        Severity::Warning => "WARNING",
        Severity::Error => "ERROR  ",
    };
    format!("{mark}  {}: {}", finding.code, finding.message)
}
