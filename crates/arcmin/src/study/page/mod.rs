//! The page of a study.

mod causes;
mod figures;
mod grid;
mod limits;
mod search;
mod terminal;

pub use search::SearchReport;

use super::file::Study;
use super::judge::{Judged, JudgedResult, SHARES};
use super::part::Cell;
use super::statistics::{Interval, Yield};
use super::{Distribution, Kind, Plan, Rows, Setting, StudyError};
use crate::design::{Choice, unit_of};
use crate::report::{
    Axis, Block, Column, DesignTemplate, KeyFigure, Page, Provenance, SampleColumn, Samples, Section, Table,
    Tone, Verdict, compact, significant,
};
use crate::results::in_words;

/// Largest number of results with histograms, distributions and rankings.
const RESULTS_DRAWN: usize = 8;
/// Largest number of columns of results side by side.
const RESULTS_ACROSS: usize = 4;
/// Keys of a ranking.
const RANKED: usize = 12;

/// Contents of a page.
#[derive(Debug)]
pub struct StudyReport<'a> {
    /// Name of the study, in the head of the page.
    pub title: String,
    /// Topic of the page.
    pub subtitle: String,
    /// Factors, sampling and results kept.
    pub plan: &'a Plan,
    /// Rows that are there.
    pub rows: &'a Rows,
    /// Findings from these rows.
    pub judged: &'a Judged,
    /// The design that copying a sample writes; its columns count those of [`Plan::columns`].
    pub template: DesignTemplate,
    /// Goals (true: to be minimised) for the Pareto front.
    pub goals: Vec<(String, bool)>,
}

/// A key as words.
pub(in crate::study) fn words_of(key: &str) -> String {
    named(key).0
}

/// Name and unit of a key.
fn named(key: &str) -> (String, &'static str) {
    let (group, name) = key.rsplit_once('.').map_or(("", key), |(group, name)| (group, name));
    let (stem, unit) = unit_of(name).unwrap_or((name, ""));
    // The name already contains the unit.
    let unit = if name.starts_with("hours_to_") || name == "hours" { "h" } else { unit };
    let stem = in_words(stem);
    (if group.is_empty() { stem } else { format!("{} {stem}", group.replace('_', " ")) }, unit)
}

fn axis(key: &str) -> Axis {
    let (label, unit) = named(key);
    Axis::new(label, unit)
}

fn ends(interval: &Interval, digits: usize) -> String {
    let end = |end: Option<f64>| end.map_or("–".to_owned(), |x| shown(x, digits));
    format!("{} … {}", end(interval.low), end(interval.high))
}

/// The same with its unit, and a mark if the interval contains zero: no effect is proved.
fn effect(interval: &Interval, digits: usize, unit: &str) -> String {
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let mark = if interval.contains(0.0) { "; contains zero: not significant" } else { "" };
    format!("{}{unit}{mark}", ends(interval, digits))
}

/// Lives beyond the search are infinite.
fn shown(value: f64, digits: usize) -> String {
    if value == f64::INFINITY { "∞".to_owned() } else { significant(value, digits) }
}

fn percent(share: f64) -> String {
    format!("{} %", compact(100.0 * share, 3))
}

fn interval_in_percent(interval: &Interval) -> String {
    let percent = Interval { low: interval.low.map(|x| 100.0 * x), high: interval.high.map(|x| 100.0 * x) };
    effect(&percent, 2, "%")
}

impl Study {
    /// Results of the rows.
    ///
    /// # Errors
    /// [`StudyError::Statistic`] if there are no rows.
    pub fn judge(&self, rows: &Rows) -> Result<Judged, StudyError> {
        let batch = |number: u64| self.batch_of(number).unwrap_or(0);
        let batch: Option<&dyn Fn(u64) -> u64> = if self.batches.is_some() { Some(&batch) } else { None };
        super::judge::judge(&self.plan, rows, &self.limits, self.confidence, batch)
    }

    /// The report of rows that were judged.
    pub fn report<'a>(&'a self, rows: &'a Rows, judged: &'a Judged) -> StudyReport<'a> {
        let design = self.design.name();
        StudyReport {
            title: format!("{}: study of {}", design, self.analysis.name),
            subtitle: format!("{} of {} rows, {}", rows.records.len(), rows.of, self.method.word()),
            plan: &self.plan,
            rows,
            judged,
            template: self.template(),
            goals: Vec::new(),
        }
    }
}

impl StudyReport<'_> {
    /// The page, without provenance.
    pub fn page(&self) -> Page {
        let mut sections = vec![Section::new("results", "Results", self.results())];
        let drawn: Vec<&JudgedResult> = self.judged.results.iter().take(RESULTS_DRAWN).collect();
        let grid = self.grid();
        if !grid.is_empty() {
            sections.push(Section::new("grid", "Over what varies", grid));
        }
        let spread: Vec<Block> = drawn.iter().flat_map(|result| self.distribution(result)).collect();
        if !spread.is_empty() {
            sections.push(Section::new("spread", "How results are spread", spread));
        }
        let bands = self.bands();
        if !bands.is_empty() {
            sections.push(Section::new("bands", "Over the hours", bands));
        }
        let ranks: Vec<Block> = drawn.iter().flat_map(|result| self.ranking(result)).collect();
        if !ranks.is_empty() {
            sections.push(Section::new("causes", "Inputs with the largest influence", ranks));
        }
        let papers: Vec<Block> = drawn.iter().filter_map(|result| self.paper(result)).collect();
        if !papers.is_empty() {
            sections.push(Section::new("paper", "Probability paper", papers));
        }
        if let Some(front) = self.front() {
            sections.push(Section::new("front", "Best compromises", vec![Block::Plot(front)]));
        }
        sections.push(Section::new("samples", "Every sample", vec![Block::Samples(self.samples())]));
        Page {
            title: self.title.clone(),
            subtitle: self.subtitle.clone(),
            provenance: Provenance::default(),
            verdict: self.verdict(),
            sections,
        }
    }

    fn verdict(&self) -> Verdict {
        let judged = self.judged;
        let some = if (judged.rows as u64) < judged.of {
            format!("{} of {} samples", judged.rows, judged.of)
        } else {
            format!("{} samples", judged.rows)
        };
        let confidence = percent(judged.confidence);
        let (mut tone, mut headline) = self.headline(&some);
        let mut first = None;
        if let Some(answer) = self.tighten_answer() {
            first = Some(("Limits".to_owned(), std::mem::replace(&mut headline, answer)));
            tone = Tone::Neutral;
        }
        let mut verdict = Verdict::new(tone, headline);
        verdict.answers.extend(first);
        verdict.answers.extend(self.limit_answers());
        for result in judged.results.iter().take(4) {
            let (label, unit) = named(&result.key);
            let Some(spread) = &result.spread else { continue };
            let Some(high) = spread.quantiles.iter().find(|q| q.share == 0.95) else { continue };
            verdict.figures.push(KeyFigure::new(
                format!("{label}, 95 % of machines below"),
                shown(high.estimate, 3),
                unit,
                format!("{} {unit} with {confidence} confidence", ends(&high.interval, 3)),
            ));
        }
        let with_band = |share: &Yield| {
            let (low, high) = (percent(share.low), percent(share.high));
            format!("{} of {}: {} ({low} to {high})", share.kept, share.of, percent(share.share))
        };
        if judged.failed.kept > 0 {
            let most = judged
                .reasons
                .first()
                .map_or(String::new(), |(why, count)| format!("; {count} of them: {why}"));
            let question = "Cannot be assembled or computed".to_owned();
            verdict.answers.push((question, format!("{}{most}", with_band(&judged.failed))));
        }
        if let Some(tight) = judged.tight.filter(|tight| tight.kept > 0) {
            verdict
                .answers
                .push(("Have no play when turned by hand (preloaded or jammed)".into(), with_band(&tight)));
        }
        for result in judged.results.iter().take(4) {
            if let Some(batches) = &result.batches {
                let question = format!("{}: part of the variance between batches", named(&result.key).0);
                let answer = format!(
                    "{} ({}), {} batches; equivalent to {} independent machines",
                    percent(batches.share),
                    interval_in_percent(&batches.interval),
                    batches.batches,
                    significant(batches.effective, 3)
                );
                verdict.answers.push((question, answer));
            }
        }
        verdict
    }

    /// Tables with one column per result, at most as many columns as fit on a screen, and notes on them.
    fn results(&self) -> Vec<Block> {
        let tables =
            self.judged.results.chunks(RESULTS_ACROSS).map(|results| Block::Table(self.table(results)));
        let limits = self.limits_table().map(Block::Table);
        limits.into_iter().chain(tables).chain([self.caveat()]).collect()
    }

    fn table(&self, results: &[JudgedResult]) -> Table {
        let mut columns = vec![Column::text("")];
        columns.extend(results.iter().map(|result| {
            let (label, unit) = named(&result.key);
            Column::number(label, unit)
        }));
        let mut rows: Vec<Vec<String>> = Vec::new();
        let mut row = |name: String, cell: &dyn Fn(&JudgedResult) -> Option<String>| {
            let cells: Vec<Option<String>> = results.iter().map(cell).collect();
            if cells.iter().any(Option::is_some) {
                let cells = cells.into_iter().map(|cell| cell.unwrap_or_else(|| "–".to_owned()));
                rows.push(std::iter::once(name).chain(cells).collect());
            }
        };
        row("values".into(), &|result| Some(result.count.to_string()));
        for (name, end) in [("least", 0), ("largest", 1)] {
            row(name.into(), &|result| result.spread.is_none().then(|| significant(result.range[end], 4)));
        }
        row("mean".into(), &|result| Some(significant(result.spread.as_ref()?.mean, 4)));
        row("standard deviation".into(), &|result| Some(significant(result.spread.as_ref()?.deviation, 3)));
        for share in SHARES {
            row(format!("P{:.0}", 100.0 * share), &|result| {
                let quantile = result.spread.as_ref()?.quantiles.iter().find(|q| q.share == share)?;
                Some(format!("{} ({})", shown(quantile.estimate, 4), ends(&quantile.interval, 4)))
            });
        }
        row("95 % of machines within".into(), &|result| {
            Some(
                result
                    .spread
                    .as_ref()?
                    .band
                    .as_ref()
                    .map_or("too few".into(), |band| ends(&Interval { low: band.low, high: band.high }, 4)),
            )
        });
        row("limit kept by".into(), &|result| {
            let kept = result.kept?;
            Some(format!("{} ({} … {})", percent(kept.share), percent(kept.low), percent(kept.high)))
        });
        row("Cpk".into(), &|result| {
            let capability = result.capability?;
            Some(format!("{} ({})", significant(capability.cpk, 3), ends(&capability.cpk_interval, 3)))
        });
        row("B10 life".into(), &|result| {
            let fit = result.weibull.as_ref()?;
            let interval = fit.life_interval(0.1, self.judged.confidence);
            let interval = interval.map_or(String::new(), |interval| format!(" ({})", ends(&interval, 3)));
            Some(format!("{}{interval}", significant(fit.life(0.1), 3)))
        });
        if results.iter().all(|result| result.spread.is_none()) {
            return Table { title: "Results".into(), columns, rows, note: String::new() };
        }
        Table {
            title: "Results with their intervals".into(),
            columns,
            rows,
            note: format!(
                "In parentheses: intervals of {} confidence for this number of samples; for quantiles \
                 from order statistics whatever the distribution, of shares by Clopper and Pearson, of Cpk by \
                 Bissell (it means something for normal values only), of lives by the likelihood ratio.",
                percent(self.judged.confidence)
            ),
        }
    }

    fn caveat(&self) -> Block {
        if self.judged.results.iter().any(|result| result.spread.is_some()) {
            Block::Text("Failed samples have no values; for limits they count as not kept.".into())
        } else {
            let text = "The samples of this study are not drawn from the distribution of machines, so quantiles and \
                        yields are not given.";
            Block::Note(Tone::Neutral, text.into())
        }
    }

    /// Values of samples in order.
    fn sorted(&self, key: &str) -> Vec<f64> {
        let values = self.rows.numbers(self.plan, key).unwrap_or_default();
        let sampled = self.rows.records.iter().zip(values).filter_map(|(record, value)| {
            self.plan.sampling().is_sample(record.number).then_some(value).flatten()
        });
        let mut sorted: Vec<f64> = sampled.filter(|value| value.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        sorted
    }

    fn samples(&self) -> Samples {
        let columns = self.plan.columns();
        let records = &self.rows.records;
        let factors = self.plan.factors().len();
        // Curves are not shown one by one; their columns remain empty so that column numbers agree.
        let column = |(index, (name, kind)): (usize, &(&str, Kind))| {
            let mut words: Vec<String> = Vec::new();
            let values = match kind {
                Kind::Number => records.iter().map(|record| record.cells[index].number()).collect(),
                Kind::Curve => vec![None; records.len()],
                Kind::Word => {
                    let mut place = |cell: &Cell| match cell {
                        Cell::Word(word) => Some(match words.iter().position(|known| known == word) {
                            Some(place) => place as f64,
                            None => {
                                words.push(word.clone());
                                (words.len() - 1) as f64
                            }
                        }),
                        _ => None,
                    };
                    records.iter().map(|record| place(&record.cells[index])).collect()
                }
            };
            let judged = self.judged.results.iter().find(|result| result.key == *name);
            let factor = self.plan.factors().get(index);
            SampleColumn {
                name: (*name).to_owned(),
                unit: factor.map_or_else(|| named(name).1.to_owned(), |factor| factor.unit.clone()),
                result: index >= factors,
                words,
                low: judged.and_then(|result| result.limits.low),
                high: judged.and_then(|result| result.limits.high),
                logarithmic: factor
                    .is_some_and(|f| matches!(f.distribution, Distribution::LogUniform { .. })),
                values,
            }
        };
        let failed = records.iter().enumerate().filter_map(|(at, record)| Some((at, record.failed.clone()?)));
        Samples {
            title: "Every sample and its design".into(),
            note: "Drag along an axis to keep the samples within a range; pick one by its number, in the \
                   matrix, or with the arrow keys on the lines, and copy its design. `arcmin study` computes \
                   any sample again to the last bit; copied \
                   values have seven digits."
                .into(),
            columns: columns.iter().enumerate().map(column).collect(),
            numbers: records.iter().map(|record| record.number).collect(),
            failed: failed.collect(),
            design: self.template.clone(),
        }
    }
}

impl Study {
    /// The design file with places for the values of rows.
    pub fn template(&self) -> DesignTemplate {
        self.template_of(&self.plan)
    }

    /// The same for rows of a plan with the same factors.
    fn template_of(&self, plan: &Plan) -> DesignTemplate {
        let factors = plan.factors();
        let (row, last) = (plan.row(0), plan.rows().min(1000));
        let Ok(base) = self.design_of(&row) else { return DesignTemplate::default() };
        let other = |column: usize| {
            // Another value of this column from another row, all others as in the first.
            (1..last).find_map(|number| {
                let mut changed = row.clone();
                let setting = plan.row(number).settings.get(column)?.clone();
                if changed.settings[column] == setting || matches!(setting, Setting::Seed(_)) {
                    return None;
                }
                changed.settings[column] = setting;
                self.design_of(&changed).ok().map(|design| design.to_toml())
            })
        };
        let mut template = DesignTemplate::find(base.text(), factors.len(), other);
        template.seed = factors.iter().position(|factor| matches!(factor.distribution, Distribution::Drawn));
        template
    }
}
