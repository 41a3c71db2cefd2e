//! Checks of a design: findings with value, limit, reason and remedy.

use super::stage::made::{MATCHED, MadePlay, TOLERANCES};
use super::stage::strength::FAILURES;
use super::{AnalysisError, Host, Origin, Outcome, TextBlock, inputs, stage};
use crate::checks::{Finding, Severity, check_design, worst};
use crate::design::{Design, InputFile, optional, options};
use crate::report::{Block, Column as Head, Page, Provenance, Section, Tone, Verdict};
use crate::results::{
    DeclaredTable, PLAIN, Summary, SummaryOf, Table, TableOf, Value, digits, quantities as q, quantity,
};

pub(crate) const ABOUT: &str = "Check a design: findings with value, limit, reason and remedy";
pub(crate) const GUIDE: &str = "Checks a design. Each finding has a code, a value and a limit. Warnings and errors also state why \
    they matter and what to change. The exit status is 1 if there is an error finding.";
pub(crate) const EXAMPLES: &[&str] = &[
    "arcmin check my-reducer.toml",
    "arcmin check my-reducer.toml --explain",
    "arcmin check my-reducer.toml --json",
];

options! {
    /// Options of `check`.
    pub struct Options {
        /// Explain all checks, including those that passed.
        explain: bool => optional(0.0, 0.0),
    }
}

/// Findings of a design, the worst first.
#[derive(Debug, Clone)]
pub struct Check {
    /// Verdicts, those without objection included.
    pub findings: Vec<Finding>,
    /// For drives of eccentrics: play by part.
    pub play_chain: Option<stage::Play>,
    /// For drives of eccentrics: strength of the parts.
    pub strength: Option<stage::Strength>,
    declared: SummaryOf<Check>,
    /// For a drive of eccentrics with tolerances: its play as made.
    pub made: Option<MadePlay>,
    name: String,
    explain: bool,
}

const FINDINGS: TableOf<Finding> = TableOf {
    name: "findings",
    what: "One row per check, the worst first",
    columns: || {
        vec![
            quantity("code", PLAIN, "Stable name of the check.").of(|f: &Finding| f.code.into()),
            quantity("severity", PLAIN, "info (passed), warning or error.").of(|f| f.severity.word().into()),
            q::VALUE.with(digits(6)).of(|f| f.value.into()),
            q::LIMIT.with(digits(6)).of(|f| f.limit.into()),
            q::UNIT.of(|f| f.unit.into()),
            quantity("message", PLAIN, "The finding in one sentence.").of(|f| f.message.clone().into()),
            quantity("why", PLAIN, "Why it matters.").of(|f| f.why.into()),
            quantity("change", PLAIN, "What to change.").of(|f| f.change.into()),
        ]
    },
};

pub(crate) const SUMMARY: SummaryOf<Check> = SummaryOf {
    entries: || {
        vec![
            quantity(
                "errors",
                PLAIN,
                "Number of error findings: the drive cannot be made or assembled, or it fails.",
            )
            .of(|o: &Check| o.count(Severity::Error).into()),
            quantity("warnings", PLAIN, "Number of warnings: it runs, but worse than it could.")
                .of(|o| o.count(Severity::Warning).into()),
            quantity("checks", PLAIN, "Number of checks.").of(|o| o.findings.len().into()),
            quantity("findings", PLAIN, "All findings, with the columns of findings.csv.").of(|o| {
                let columns = (FINDINGS.columns)();
                let record = |finding: &Finding| {
                    Value::Record(columns.iter().map(|c| (c.quantity.key, c.value(finding))).collect())
                };
                Value::List(o.findings.iter().map(record).collect())
            }),
        ]
    },
};

/// Summary of a drive of eccentrics.
pub(super) fn summary_of<D: stage::EccentricDrive>() -> SummaryOf<Check> {
    SummaryOf {
        entries: || {
            let parts = [
                (SUMMARY.entries)(),
                stage::play_entries::<Check, D>(),
                stage::strength_entries(),
                stage::made_entries(),
            ];
            parts.into_iter().flatten().collect()
        },
    }
}

pub(crate) fn tables() -> Vec<DeclaredTable> {
    vec![FINDINGS.into()]
}

/// Tables of a drive of eccentrics.
pub fn drive_tables() -> Vec<DeclaredTable> {
    vec![FINDINGS.into(), FAILURES.into(), TOLERANCES.into(), MATCHED.into()]
}

/// Judges a design.
///
/// # Errors
/// None today; the type is that of every analysis.
pub fn run(design: &Design, options: &Options, host: &dyn Host) -> Result<Check, AnalysisError> {
    let mut findings = check_design(design);
    findings.extend(measured_flanks(design, host));
    Ok(Check::of(findings, (None, None, None), SUMMARY, (&design.name, options)))
}

/// Whether the files that the design names exist and are valid; `None` if it names none.
fn measured_flanks(design: &Design, host: &dyn Host) -> Option<Finding> {
    let flanks = design.measured_flanks();
    let lobes = design.machine().ring.pin_count - 1;
    let wrong: Vec<String> = flanks
        .iter()
        .filter_map(|flank| {
            let file = InputFile(flank.file.clone());
            let read = host
                .read(&file, Origin::Design)
                .and_then(|bytes| inputs::measured_flank(&file, &bytes, lobes));
            read.err().map(|error| error.to_string())
        })
        .collect();
    let severity = if wrong.is_empty() { Severity::Info } else { Severity::Error };
    (!flanks.is_empty()).then(|| Finding {
        code: "measured-flanks",
        severity,
        message: match wrong.is_empty() {
            true => format!("measured flanks exist and are valid: {}", flanks.len()),
            false => wrong.join("; "),
        },
        value: wrong.len() as f64,
        limit: 0.0,
        unit: "",
        why: "all computations with the errors of the design need the flanks that it names",
        change: "put the file beside the design file with rows angle_deg,depth_um around the whole disc, or remove \
             it from [errors]",
    })
}

impl Check {
    /// Judges a drive of eccentrics.
    pub(super) fn of_drive<D: stage::EccentricDrive>(design: &D, options: &Options) -> Check {
        let (strength, made) = (stage::Strength::of(design), MadePlay::of(design));
        let mut findings = design.findings_with(&strength);
        findings.extend(made.as_ref().map(MadePlay::finding));
        findings.extend(stage::offsets::findings(design, made.as_ref()));
        let found = (Some(stage::Play::of(design)), Some(strength), made);
        Check::of(findings, found, summary_of::<D>(), (design.name(), options))
    }

    fn of(
        mut findings: Vec<Finding>,
        (play_chain, strength, made): (Option<stage::Play>, Option<stage::Strength>, Option<MadePlay>),
        declared: SummaryOf<Check>,
        (name, options): (&str, &Options),
    ) -> Check {
        findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
        Check {
            findings,
            play_chain,
            strength,
            made,
            declared,
            name: name.to_owned(),
            explain: options.explain,
        }
    }

    fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|finding| finding.severity == severity).count()
    }

    /// Numbers of checks, errors and warnings, in a sentence.
    fn sentence(&self) -> String {
        let (errors, warnings) = (self.count(Severity::Error), self.count(Severity::Warning));
        let many = |count: usize, word: &str| format!("{count} {word}{}", if count == 1 { "" } else { "s" });
        format!(
            "{}: {}, {}",
            many(self.findings.len(), "check"),
            many(errors, "error"),
            many(warnings, "warning")
        )
    }
}

impl stage::HasPlay for Check {
    fn play(&self) -> Option<&stage::Play> {
        self.play_chain.as_ref()
    }
}

impl Outcome for Check {
    fn summary(&self) -> Summary {
        self.declared.fill(self)
    }

    fn tables(&self) -> Vec<Table> {
        let mut tables = vec![FINDINGS.fill(&self.findings)];
        tables.extend(self.strength.iter().map(|strength| FAILURES.fill(&strength.order())));
        if let Some(made) = &self.made {
            tables.extend([TOLERANCES.fill(&made.tolerances), MATCHED.fill(&made.matched)]);
        }
        tables
    }

    fn text_blocks(&self) -> Vec<TextBlock> {
        let mut blocks = Vec::new();
        for finding in &self.findings {
            let mark = match finding.severity {
                Severity::Info => "ok     ",
                Severity::Warning => "WARNING",
                Severity::Error => "ERROR  ",
            };
            blocks.push(TextBlock::line(format!("{mark}  {}: {}", finding.code, finding.message)));
            if self.explain || finding.severity > Severity::Info {
                blocks.push(TextBlock::line(format!("           why: {}", finding.why)));
                blocks.push(TextBlock::line(format!("           change: {}", finding.change)));
            }
        }
        blocks.extend(self.play_chain.iter().map(|play| TextBlock::line(stage::play_sentence(play))));
        blocks.extend(self.made.iter().flat_map(MadePlay::text_blocks));
        blocks.push(TextBlock::line(self.sentence()));
        blocks
    }

    fn page(&self) -> Page {
        let tone = match worst(&self.findings) {
            Severity::Error => Tone::Bad,
            Severity::Warning => Tone::Caution,
            Severity::Info => Tone::Good,
        };
        let (wrong, passed): (Vec<&Finding>, Vec<&Finding>) =
            self.findings.iter().partition(|finding| finding.severity > Severity::Info);
        let mut blocks = Vec::new();
        if !wrong.is_empty() {
            let row = |f: &&Finding| {
                vec![
                    f.severity.word().to_uppercase(),
                    f.code.to_owned(),
                    f.message.clone(),
                    f.why.into(),
                    f.change.into(),
                ]
            };
            blocks.push(Block::Table(crate::report::Table {
                title: "Warnings and errors".to_owned(),
                columns: ["Severity", "Check", "Finding", "Why it matters", "What to change"]
                    .map(Head::text)
                    .into(),
                rows: wrong.iter().map(row).collect(),
                note: "Worst first. All checks are in `findings.csv`.".to_owned(),
            }));
        }
        let row = |f: &&Finding| vec![f.code.to_owned(), f.message.clone()];
        blocks.push(Block::Table(crate::report::Table {
            title: "Passed checks".to_owned(),
            columns: ["Check", "Finding"].map(Head::text).into(),
            rows: passed.iter().map(row).collect(),
            note: "`arcmin check --explain` states the reason for every check.".to_owned(),
        }));
        let mut verdict = Verdict::new(tone, format!("{}.", self.sentence()));
        if let Some(first) = wrong.first() {
            verdict.answers.push((format!("First of all: {}", first.code), first.message.clone()));
            verdict.answers.push(("What to change".to_owned(), first.change.to_owned()));
        }
        Page {
            title: self.name.clone(),
            subtitle: "Is the design sound?".to_owned(),
            provenance: Provenance::default(),
            verdict,
            sections: self
                .play_chain
                .iter()
                .map(|play| {
                    let made = self.made.iter().flat_map(MadePlay::blocks);
                    Section::new("play", "Play", [stage::play_table(play)].into_iter().chain(made).collect())
                })
                .chain([Section::new("findings", "Findings", blocks)])
                .collect(),
        }
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
