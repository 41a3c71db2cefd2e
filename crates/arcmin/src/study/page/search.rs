//! The page of a search: best designs compared with the given one.

use serde_json::{Map, Value as Json, json};

use super::{StudyReport, axis, named, percent};
use crate::analyses::stage::AnyDesign;
use crate::analyses::{TextBlock, TextTable};
use crate::design::DesignError;
use crate::report::{
    Axis, Block, Column, KeyFigure, Page, Plot, Provenance, Section, Series, Table, Tone, Verdict,
    significant,
};
use crate::study::optimise::Outcome;
use crate::study::search::{DoneStage, Search, Stage, Standing};
use crate::study::statistics::{clopper_pearson, quantile};
use crate::study::{Plan, Rows, Setting, Study, StudyError};

/// Results of a search.
pub struct SearchReport<'a> {
    study: &'a Study,
    search: &'a Search,
    standing: &'a Standing,
    /// All rows of all stages.
    pub plan: Plan,
    /// Rows of this plan.
    pub rows: Rows,
    /// The given design and the best ones, with the last stage that judges them.
    compared: Vec<Compared>,
}

/// One design of the comparison.
#[derive(Debug)]
struct Compared {
    name: String,
    place: Vec<f64>,
    outcome: Outcome,
    /// Values of every goal and bound, by key, of all its machines in the last stage that has it.
    machines: Vec<(String, Vec<f64>)>,
    failed: usize,
    of: usize,
}

impl Study {
    /// The report of a search; `None` for studies without a search.
    ///
    /// # Errors
    /// [`StudyError`] of the plan of all its rows.
    pub fn search_report<'a>(
        &'a self,
        standing: &'a Standing,
    ) -> Option<Result<SearchReport<'a>, StudyError>> {
        let search = self.search.as_ref()?;
        Some(search.together(standing).map(|(plan, rows)| {
            let compared = compared(search, standing);
            SearchReport { study: self, search, standing, plan, rows, compared }
        }))
    }
}

fn compared(search: &Search, standing: &Standing) -> Vec<Compared> {
    let mut places = vec![search.start.clone()];
    let chosen = search.chosen(&standing.best);
    let one = chosen.len() == 1;
    places.extend(chosen);
    let mut all = Vec::new();
    for (index, place) in places.iter().enumerate() {
        let name = match index {
            0 => "as it stands".to_owned(),
            _ if one => "best".to_owned(),
            index => format!("best {index}"),
        };
        let last = standing.done.iter().rev().find_map(|stage| {
            stage.designs.iter().position(|design| design == place).map(|index| (stage, index))
        });
        let Some((stage, index)) = last else { continue };
        let of = stage.machines as usize;
        let rows = index * of..(index + 1) * of;
        let keys =
            search.goals.iter().map(|goal| &goal.key).chain(search.bounds.iter().map(|bound| &bound.key));
        let mut machines: Vec<(String, Vec<f64>)> = Vec::new();
        for key in keys {
            if machines.iter().all(|(known, _)| known != key) {
                let values = stage.rows.numbers(&stage.plan, key).unwrap_or_default();
                let mut values: Vec<f64> = values[rows.clone()].iter().flatten().copied().collect();
                values.sort_by(f64::total_cmp);
                machines.push((key.clone(), values));
            }
        }
        let failed = stage.rows.records[rows].iter().filter(|record| record.failed.is_some()).count();
        let outcome = stage.outcomes.get(index).cloned().unwrap_or_else(Outcome::failed);
        all.push(Compared { name, place: place.clone(), outcome, machines, failed, of });
    }
    all
}

impl SearchReport<'_> {
    /// The best designs as files, the best one first; names without ending.
    ///
    /// # Errors
    /// Values that contradict each other.
    pub fn designs(&self) -> Result<Vec<(String, AnyDesign)>, Box<DesignError>> {
        let best = self.compared.iter().skip(1);
        best.map(|compared| {
            let name = compared.name.replace(' ', "-");
            let design = match self.search.row_of(self.standing, &compared.place) {
                Some(number) => self.study.file_of(&self.plan.row(number))?,
                None => self.study.design.clone(),
            };
            Ok((name, design))
        })
        .collect()
    }

    /// The stage of new machines, if it is computed.
    fn check(&self) -> Option<&DoneStage> {
        self.standing.done.last().filter(|stage| stage.stage == Stage::Check)
    }

    fn complete(&self) -> bool {
        self.standing.next.is_none()
    }

    /// Value of a goal for a design.
    fn goal(&self, compared: &Compared, goal: usize) -> f64 {
        compared.outcome.goals.get(goal).map_or(f64::NAN, |small| self.search.goals[goal].value(*small))
    }

    fn generations(&self) -> u64 {
        self.standing.done.iter().filter(|stage| matches!(stage.stage, Stage::Generation(_))).count() as u64
    }

    fn headline(&self) -> (Tone, String) {
        let generations = self.generations();
        let so_far = if self.complete() { "" } else { " so far; the search is not over" };
        let (Some(start), Some(best)) = (self.compared.first(), self.compared.get(1)) else {
            return (Tone::Neutral, format!("The search has started: {generations} generations{so_far}."));
        };
        let goals = self.search.goals.iter().enumerate().map(|(index, goal)| {
            let (label, unit) = named(&goal.key);
            let (from, to) = (self.goal(start, index), self.goal(best, index));
            format!("{label} {} → {} {unit}", significant(from, 4), significant(to, 4)).trim_end().to_owned()
        });
        let goals = goals.collect::<Vec<_>>().join(", ");
        let kept = match (best.outcome.is_feasible(), self.check()) {
            (true, _) => "all limits kept",
            (false, None) => "but it does not keep all limits, and no tried design does",
            (false, Some(_)) => "but it does not keep all limits on new machines, and no checked design does",
        };
        let tone = if best.outcome.is_feasible() { Tone::Good } else { Tone::Bad };
        let count = match self.standing.best.len() {
            0 | 1 => String::new(),
            count => format!("; the best of {count} compromises for the first goal"),
        };
        (tone, format!("{goals}{count}, {kept}, after {generations} generations{so_far}."))
    }

    /// Text for the terminal.
    pub fn text_blocks(&self) -> Vec<TextBlock> {
        let mut blocks = vec![TextBlock::line(self.headline().1)];
        let header =
            std::iter::once(String::new()).chain(self.compared.iter().map(|c| c.name.clone())).collect();
        blocks.push(TextBlock::Table(TextTable { header, rows: self.comparison() }));
        blocks
    }

    /// Goals, bounds and searched keys, a column for each design.
    fn comparison(&self) -> Vec<Vec<String>> {
        let mut rows = Vec::new();
        for (index, goal) in self.search.goals.iter().enumerate() {
            let (label, unit) = named(&goal.key);
            let words = goal.words(self.search.machines);
            let mut row = vec![[format!("goal: {label} {unit}"), words].join(", ")];
            row[0] = row[0].trim_end_matches([',', ' ']).replace(" ,", ",");
            row.extend(self.compared.iter().map(|c| significant(self.goal(c, index), 4)));
            rows.push(row);
        }
        for bound in &self.search.bounds {
            let (label, unit) = named(&bound.key);
            let ends = [(bound.low, "≥"), (bound.high, "≤")];
            for (at, (limit, sign)) in ends.iter().filter_map(|(l, s)| Some(((*l)?, *s))).enumerate() {
                let share = percent(bound.share);
                let who =
                    if self.search.machines > 1 { format!(", {share} of machines") } else { String::new() };
                let mut row = vec![format!("limit: {label} {sign} {} {unit}{who}", significant(limit, 4))];
                row.extend(self.compared.iter().map(|c| {
                    let values = c.machines.iter().find(|(key, _)| *key == bound.key);
                    let deciding = values.map_or(Vec::new(), |(_, values)| bound.deciding(values));
                    deciding.get(at).map_or("–".to_owned(), |value| significant(*value, 4))
                }));
                rows.push(row);
            }
        }
        for (k, factor) in self.search.searched.iter().enumerate() {
            let factor = &self.search.factors[*factor];
            let mut row = vec![format!("{} {}", factor.path, factor.unit).trim_end().to_owned()];
            row.extend(self.compared.iter().map(|c| self.setting(c, k)));
            rows.push(row);
        }
        let mut failed = vec!["machines without result".to_owned()];
        failed.extend(self.compared.iter().map(|c| format!("{} of {}", c.failed, c.of)));
        rows.push(failed);
        rows
    }

    /// Value of a searched key; for the given design that of its file.
    fn setting(&self, compared: &Compared, searched: usize) -> String {
        let factor = self.search.searched[searched];
        let row = self.search.row_of(self.standing, &compared.place).map(|number| self.plan.row(number));
        match row.as_ref().and_then(|row| row.settings.get(factor)) {
            Some(Setting::Number(number)) => significant(*number, 4),
            Some(Setting::Word(word)) => word.clone(),
            Some(Setting::Flag(flag)) => flag.to_string(),
            _ => "–".to_owned(),
        }
    }

    /// The best and the middle design of every generation that keeps its limits, for one goal.
    fn course(&self) -> Option<Plot> {
        let [goal] = &self.search.goals[..] else { return None };
        let generations = self.standing.done.iter().filter_map(|stage| match stage.stage {
            Stage::Generation(number) => Some((number as f64, stage)),
            _ => None,
        });
        let feasible = |stage: &DoneStage| {
            let mut goals: Vec<f64> = stage
                .outcomes
                .iter()
                .filter(|outcome| outcome.is_feasible())
                .map(|outcome| goal.value(outcome.goals[0]))
                .collect();
            goals.sort_by(f64::total_cmp);
            if goal.largest {
                goals.reverse();
            }
            goals
        };
        let courses: Vec<(f64, Vec<f64>)> = generations
            .map(|(number, stage)| (number, feasible(stage)))
            .filter(|(_, g)| !g.is_empty())
            .collect();
        if courses.is_empty() {
            return None;
        }
        let mut plot = Plot::new("The search", Axis::new("Generation", "").counted(), axis(&goal.key));
        let best = courses.iter().map(|(number, goals)| (*number, goals[0]));
        plot.series.push(Series::line("best of the generation", best).strong());
        let middle = courses.iter().map(|(number, goals)| (*number, goals[goals.len() / 2]));
        plot.series.push(Series::line("median of the generation", middle));
        Some(plot.noted("Objective of the best and of the median design of each generation, among designs that fulfil all limits."))
    }

    fn comparison_table(&self) -> Table {
        let mut columns = vec![Column::text("")];
        columns.extend(self.compared.iter().map(|compared| Column::number(compared.name.clone(), "")));
        let Search { machines, check_machines, ref goals, .. } = *self.search;
        let note = match self.check() {
            _ if machines == 1 => "Every design is computed once: machines do not differ.".to_owned(),
            None => format!("Judged by the {machines} machines of the search."),
            Some(check) => {
                let fresh = format!(
                    "Judged by {check_machines} new machines that were not used in the search; the search used \
                         {machines}."
                );
                match (goals.len(), check.designs.len() - 1) {
                    (1, count) => format!(
                        "{fresh} Designs checked beside that as it stands: {count}, the best of the search at several \
                         distances from the limits."
                    ),
                    _ => fresh,
                }
            }
        };
        Table { title: "Results".into(), columns, rows: self.comparison(), note }
    }

    /// The page, without provenance.
    ///
    /// # Errors
    /// [`StudyError`] where the rows cannot be judged.
    pub fn page(&self) -> Result<Page, StudyError> {
        let study = self.study;
        let judged =
            super::super::judge::judge(&self.plan, &self.rows, &study.limits, study.confidence, None)?;
        let goals = self.search.goals.iter().map(|goal| (goal.key.clone(), !goal.largest)).collect();
        let all = StudyReport {
            title: String::new(),
            subtitle: String::new(),
            plan: &self.plan,
            rows: &self.rows,
            judged: &judged,
            template: study.template_of(&self.plan),
            goals,
        };
        let (tone, headline) = self.headline();
        let mut verdict = Verdict::new(tone, headline);
        if let Some(best) = self.compared.get(1) {
            for (index, goal) in self.search.goals.iter().enumerate() {
                let (label, unit) = named(&goal.key);
                let label = [label, goal.words(self.search.machines)].join(", ");
                let note = self.compared.first().map_or(String::new(), |start| {
                    format!("as it stands: {}", significant(self.goal(start, index), 4))
                });
                let value = significant(self.goal(best, index), 4);
                verdict.figures.push(KeyFigure {
                    tone,
                    ..KeyFigure::new(label.trim_end_matches(", "), value, unit, note)
                });
            }
        }
        let mut found = vec![Block::Table(self.comparison_table())];
        found.extend(self.course().map(Block::Plot));
        let mut sections = vec![Section::new("found", "Results", found)];
        if let Some(front) = all.front() {
            sections.push(Section::new("front", "Best compromises", vec![Block::Plot(front)]));
        }
        let shares = self.distributions();
        if !shares.is_empty() {
            sections.push(Section::new("machines", "Machines of the best design", shares));
        }
        for (name, design) in self.designs().unwrap_or_default() {
            let text = design.text().to_owned();
            let block = Block::Code { title: format!("{name}.toml"), text };
            sections.push(Section::new(name.clone(), format!("Design: {name}"), vec![block]));
        }
        sections.push(Section::new("samples", "Every sample", vec![Block::Samples(all.samples())]));
        Ok(Page {
            title: format!("{}: search by {}", study.design.name(), study.analysis.name),
            subtitle: format!("{} rows in {} generations", self.rows.records.len(), self.generations()),
            provenance: Provenance::default(),
            verdict,
            sections,
        })
    }

    /// Shares of machines below, before and after.
    fn distributions(&self) -> Vec<Block> {
        let Some(best) = self.compared.get(1).filter(|best| best.of > 4) else { return Vec::new() };
        let mut blocks = Vec::new();
        for (key, values) in &best.machines {
            let mut plot = Plot::new(
                format!("{}: share of machines below", named(key).0),
                axis(key),
                Axis::new("Share of machines", "%").between(0.0, 100.0),
            )
            .half();
            let steps = |values: &[f64]| -> Vec<(f64, f64)> {
                let n = values.len() as f64;
                values.iter().enumerate().map(|(k, value)| (*value, 100.0 * (k + 1) as f64 / n)).collect()
            };
            plot = plot.with(Series::line("best", steps(values)).strong());
            let start = self.compared.first().and_then(|start| start.machines.iter().find(|(k, _)| k == key));
            if let Some((_, values)) = start {
                plot = plot.with(Series::line("as it stands", steps(values)));
            }
            blocks.push(Block::Plot(plot.noted(format!(
                "Share of {} drawn machines in % with at most this value: the best design of the search and the design \
                 as it stands.",
                best.of
            ))));
        }
        blocks
    }

    /// `summary.json`.
    pub fn to_json(&self) -> Map<String, Json> {
        let confidence = self.study.confidence;
        let one = |compared: &Compared| {
            let goals: Map<String, Json> = (0..self.search.goals.len())
                .map(|index| (self.search.goals[index].key.clone(), json!(self.goal(compared, index))))
                .collect();
            let machines: Map<String, Json> = compared
                .machines
                .iter()
                .map(|(key, values)| {
                    let quantiles: Vec<Json> = [0.05, 0.5, 0.95]
                        .into_iter()
                        .filter_map(|share| quantile(values, share, confidence).ok())
                        .map(|q| {
                            let ends = [q.interval.low, q.interval.high];
                            json!({ "share": q.share, "value": q.estimate, "interval": ends })
                        })
                        .collect();
                    (key.clone(), Json::Array(quantiles))
                })
                .collect();
            let bounds: Vec<Json> = self
                .search
                .bounds
                .iter()
                .filter_map(|bound| {
                    let (_, values) = compared.machines.iter().find(|(key, _)| *key == bound.key)?;
                    let kept = values.iter().filter(|value| {
                        bound.low.is_none_or(|low| **value >= low)
                            && bound.high.is_none_or(|high| **value <= high)
                    });
                    let share = clopper_pearson(kept.count() as u64, compared.of as u64, confidence).ok()?;
                    Some(json!({
                        "result": bound.key, "low": bound.low, "high": bound.high, "share": bound.share,
                        "kept": share.kept, "of": share.of, "interval": [share.low, share.high],
                    }))
                })
                .collect();
            let values: Map<String, Json> = (0..self.search.searched.len())
                .map(|k| {
                    let path = self.search.factors[self.search.searched[k]].path.clone();
                    let row = self
                        .search
                        .row_of(self.standing, &compared.place)
                        .map(|number| self.plan.row(number));
                    let value = row.and_then(|row| row.settings.get(self.search.searched[k]).cloned());
                    let value = match value {
                        Some(Setting::Number(number)) => json!(number),
                        Some(Setting::Word(word)) => json!(word),
                        Some(Setting::Flag(flag)) => json!(flag),
                        _ => Json::Null,
                    };
                    (path, value)
                })
                .collect();
            json!({
                "name": compared.name, "goals": goals, "keeps_limits": compared.outcome.is_feasible(),
                "values": values, "machines": compared.of, "failed": compared.failed,
                "quantiles": machines, "limits": bounds,
            })
        };
        let mut summary = Map::new();
        let mut put = |key: &str, value: Json| summary.insert(key.to_owned(), value);
        put("rows", json!(self.rows.records.len()));
        put("of", json!(self.rows.of));
        put("generations", json!(self.generations()));
        put("complete", json!(self.complete()));
        put("feasible", json!(self.standing.feasible));
        put("start", self.compared.first().map_or(Json::Null, one));
        put("best", self.compared.get(1).map_or(Json::Null, one));
        put("compared", Json::Array(self.compared.iter().skip(1).map(one).collect()));
        let front = self.standing.best.iter().map(|(_, outcome)| {
            let goals = self.search.goals.iter().zip(&outcome.goals);
            goals.map(|(goal, small)| (goal.key.clone(), json!(goal.value(*small)))).collect::<Map<_, _>>()
        });
        put("front", json!(front.collect::<Vec<_>>()));
        summary
    }

    /// `generations.csv`: every design of the search, with the values of its goals and the amount by which its
    /// limits are exceeded.
    pub fn generations_csv(&self) -> String {
        let mut out = String::from("stage,design,first_sample,machines");
        for goal in &self.search.goals {
            out.push_str(&format!(",{}", goal.key));
        }
        out.push_str(",exceeded\n");
        let mut first = 0;
        for stage in &self.standing.done {
            for (index, outcome) in stage.outcomes.iter().enumerate() {
                let sample = first + index as u64 * stage.machines;
                out.push_str(&format!("{},{index},{sample},{}", stage.stage.name(), stage.machines));
                for (goal, small) in self.search.goals.iter().zip(&outcome.goals) {
                    let value = goal.value(*small);
                    out.push_str(&if value.is_finite() { format!(",{value}") } else { ",".to_owned() });
                }
                let exceeded = outcome.violation();
                out.push_str(&if exceeded.is_finite() { format!(",{exceeded}\n") } else { ",\n".to_owned() });
            }
            first += stage.plan.rows();
        }
        out
    }
}
