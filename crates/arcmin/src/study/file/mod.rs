//! The study file: declared and read like a design, with the same messages.

mod build;
mod method;
#[cfg(test)]
mod tests;

pub use build::{Batches, Study};
pub use method::{Aim, MethodName};

use crate::design::schema::{default_flag, section};
use crate::design::tree::Node;
use crate::design::variation::Variations;
use crate::design::{
    At, DesignError, DesignErrorKind, InputFile, Section, Source, default, default_word, optional, word,
};

use super::statistics::Limits;
use crate::fidelity::LARGEST_SEED;

section! {
    /// A study file. Beside the keys below, the section `[options]` holds options of the analysis, named as
    /// on the command line.
    pub struct StudySections {
        /// Design file, relative to this file.
        design: InputFile => word(),
        /// Analysis that every machine goes through: `contact`, `rig`, `life`, …
        analysis: String => word(),
        /// Results to keep: keys of the analysis' summary, or `table.column` for a column of one of its
        /// tables, which is kept as a curve.
        results: Vec<String> => word(),
        /// Whether every machine is drawn from the design's `[tolerances]`.
        tolerances: bool => default_flag(false),
        /// Whether the design's `[unknowns]` vary as well.
        unknowns: bool => default_flag(false),
        /// Keys of the design that vary, by their path in quotation marks.
        vary: Variations => optional(0.0, 0.0),
        /// How machines are chosen.
        method: Section<MethodSection> => word(),
        /// Allowed values of results: for yield and capability, and as constraints.
        limits: Vec<At<Section<LimitSection>>> => optional(0.0, 0.0),
        /// Costs of reducing the spread of keys.
        costs: Vec<At<Section<CostSection>>> => optional(0.0, 0.0),
        /// Goals of `optimise`: one or two.
        goals: Vec<At<Section<GoalSection>>> => optional(0.0, 0.0),
        /// Batches that machines are drawn in. Left out: every machine is drawn on its own.
        batches: Option<Section<BatchSection>> => optional(0.0, 0.0),
    }

    /// How machines are chosen.
    pub struct MethodSection {
        /// The way.
        kind: MethodName => word(),
        /// Machines; for `morris` trajectories, for `saltelli` base points, for `tighten` machines before
        /// tightening. A grid has as many as it has.
        samples: usize => default(100.0, 1.0, 1e9),
        /// Seed of everything that is drawn.
        seed: usize => default(1.0, 0.0, LARGEST_SEED),
        /// Levels of every range for `grid` and `morris`; even for `morris`.
        levels: usize => default(4.0, 2.0, 1e6),
        /// Whether `saltelli` computes the rows for interactions of two keys.
        second_order: bool => default_flag(false),
        /// Share by which `tighten` reduces a tolerance.
        share: f64 => default(0.1, 1e-6, 1.0),
        /// Confidence of all intervals.
        confidence: f64 => default(0.95, 0.5, 0.9999),
        /// Samples per part; a part is written at once, and shards consist of parts. Left out: 8 for up to 16 384
        /// samples, otherwise more.
        samples_per_part: Option<usize> => optional(1.0, 1e6),
        /// Generations that `optimise` computes at most.
        generations: usize => default(60.0, 1.0, 100_000.0),
        /// Designs of a generation. Left out: by the number of keys that are searched.
        population: Option<usize> => optional(4.0, 100_000.0),
        /// First step of the search as a share of every range.
        step: f64 => default(0.25, 1e-6, 1.0),
        /// Number of machines for each design of `optimise`, if machines differ. Left out: 20, or one if they do not
        /// differ.
        machines: Option<usize> => optional(1.0, 1e6),
        /// Number of new machines for the final check of the best designs, if machines differ.
        check_machines: usize => default(93.0, 0.0, 1e6),
    }

    /// Allowed values of a result.
    pub struct LimitSection {
        /// Key of the result, one of `results`.
        result: String => word(),
        /// Least value allowed.
        low: Option<f64> => optional(f64::NEG_INFINITY, f64::INFINITY),
        /// Largest value allowed.
        high: Option<f64> => optional(f64::NEG_INFINITY, f64::INFINITY),
        /// Share of machines that must keep the limit in `optimise`.
        share: f64 => default(0.95, 1e-3, 1.0),
    }

    /// A goal of `optimise`.
    pub struct GoalSection {
        /// Key of the result, one of `results`.
        result: String => word(),
        /// Direction of improvement.
        aim: Aim => default_word("smallest"),
        /// Quantile of the goal: share of machines whose value is at least as good, if machines differ.
        share: f64 => default(0.95, 1e-3, 1.0),
    }

    /// Machines of one batch have part of their errors in common, since they are made in one set-up.
    pub struct BatchSection {
        /// Machines in a batch.
        machines: usize => default(20.0, 2.0, 1e6),
        /// Share of the variance of every tolerance that lies between batches.
        share: f64 => default(0.5, 1e-6, 1.0),
    }

    /// Cost of reducing the spread of a key.
    pub struct CostSection {
        /// Path of the key, of `[vary]` or of the design's `[tolerances]`.
        key: String => word(),
        /// Cost per unit of the reduction, in any currency.
        per_unit: f64 => default(1.0, 1e-12, 1e12),
    }
}

/// A study file as read, without its design.
#[derive(Debug, Clone)]
pub struct StudyFile {
    sections: StudySections,
    text: String,
    file_name: String,
    /// Options of the analysis as TOML, at the lines of the study file.
    options: String,
    /// Names of the given options, each with its position in the file.
    given: Vec<(String, std::ops::Range<usize>)>,
}

impl std::ops::Deref for StudyFile {
    type Target = StudySections;

    fn deref(&self) -> &StudySections {
        &self.sections
    }
}

const TITLE: &str = "the study file";
/// Result of `life`: the hours up to which ends of life were searched.
pub(in crate::study) const SEARCHED: &str = "searched_h";

impl StudyFile {
    /// Reads a study file; `file_name` is used in messages only.
    ///
    /// # Errors
    /// All unknown keys, otherwise the first value that is missing, of a wrong type, out of range or in
    /// contradiction to another one.
    pub fn parse(text: &str, file_name: &str) -> Result<StudyFile, Box<DesignError>> {
        let source = Source { text, file_name, title: TITLE };
        let mut tree = crate::design::field::parse(&source)?;
        let place = tree.entries.iter().position(|entry| &*entry.key == "options");
        let (mut options, mut given) = (String::new(), Vec::new());
        if let Some(entry) = place.map(|place| tree.entries.remove(place)) {
            let Node::Table(branch) = &entry.item.node else {
                let kind = DesignErrorKind::WrongType {
                    key: "options".into(),
                    expected: "a section, [options]".into(),
                    found: entry.item.kind_name(),
                };
                return Err(source.error(kind, entry.item.span, None));
            };
            given = branch.entries.iter().map(|e| (e.key.replace('-', "_"), e.key_span.clone())).collect();
            let spans =
                branch.entries.iter().map(|e| (e.key_span.start, e.item.span.end.max(e.key_span.end)));
            let (first, last) =
                spans.fold((usize::MAX, 0), |(first, last), (start, end)| (first.min(start), last.max(end)));
            // Other text is blanked, so that messages about options have the lines of this file.
            let blank = |(at, c): (usize, char)| match c {
                '\n' => "\n".to_owned(),
                c if (first..last).contains(&at) => c.to_string(),
                c => " ".repeat(c.len_utf8()),
            };
            options = text.char_indices().map(blank).collect();
            // On the command line words of a name are joined by hyphens.
            for entry in branch.entries.iter().filter(|entry| entry.key.contains('-')) {
                options
                    .replace_range(entry.key_span.clone(), &text[entry.key_span.clone()].replace('-', "_"));
            }
            // Options within braces are separated by commas, which a section is not.
            if text.get(..first).is_some_and(|before| before.trim_end().ends_with('{')) {
                options =
                    separated(&options, &branch.entries.iter().map(|e| e.key_span.start).collect::<Vec<_>>());
            }
        }
        let sections: StudySections = crate::design::field::read(&tree, &source)?;
        let file = StudyFile { sections, text: text.into(), file_name: file_name.into(), options, given };
        file.check()?;
        Ok(file)
    }

    fn source(&self) -> Source<'_> {
        Source { text: &self.text, file_name: &self.file_name, title: TITLE }
    }

    fn wrong(&self, message: String, span: Option<std::ops::Range<usize>>, hint: &str) -> Box<DesignError> {
        let kind = DesignErrorKind::Contradiction { message };
        self.source().error(kind, span.unwrap_or(0..0), Some(hint.to_owned()))
    }

    fn check(&self) -> Result<(), Box<DesignError>> {
        if self.results.is_empty() {
            let hint = "name keys of the analysis' summary; `arcmin keys --results` lists them";
            return Err(self.wrong("no result is to be kept".into(), self.results.span.clone(), hint));
        }
        let known: Vec<&str> = self.results.iter().map(String::as_str).collect();
        for limit in &*self.limits.value {
            let result = limit.result.as_str();
            if !known.contains(&result) {
                let message = format!("`{result}` has a limit but is not kept");
                return Err(self.wrong(message, limit.result.span.clone(), "add it to `results`"));
            }
            let (low, high) = (*limit.low, *limit.high);
            if low.is_none() && high.is_none() || matches!((low, high), (Some(a), Some(b)) if !(a < b)) {
                let message = format!("the limits of `{result}` exclude all values");
                return Err(self.wrong(message, limit.span.clone(), "give `low`, `high`, or both in order"));
            }
        }
        let is_search = *self.method.kind == MethodName::Optimise;
        for goal in &*self.goals.value {
            if !known.contains(&goal.result.as_str()) {
                let message = format!("`{}` is a goal but is not kept", *goal.result);
                return Err(self.wrong(message, goal.result.span.clone(), "add it to `results`"));
            }
        }
        if is_search != matches!(self.goals.value.len(), 1 | 2) {
            let message =
                if is_search { "`optimise` needs one goal or two" } else { "only `optimise` has goals" };
            let hint = "write [[goals]] with `result` and `aim`, and kind = \"optimise\"";
            return Err(self.wrong(message.to_owned(), self.method.kind.span.clone(), hint));
        }
        if let Some(batches) = self.batches.value.as_ref().filter(|_| !*self.tolerances || is_search) {
            let message = "batches need drawn machines, and this study has none".to_owned();
            return Err(self.wrong(
                message,
                batches.share.span.clone(),
                "set `tolerances = true`, or remove them",
            ));
        }
        let drawn = *self.tolerances && self.given.iter().any(|(key, _)| key == "errors" || key == "seed");
        if drawn {
            let span = self.given.iter().find(|(key, _)| key == "errors" || key == "seed");
            let message = "machines are drawn, so `errors` and `seed` are not options here".to_owned();
            let hint = "remove them, or set `tolerances = false`";
            return Err(self.wrong(message, span.map(|(_, span)| span.clone()), hint));
        }
        Ok(())
    }

    /// Name of the file as given to [`StudyFile::parse`].
    pub fn file_name(&self) -> &str {
        &self.file_name
    }

    /// Allowed values of results, by their keys.
    pub fn limits(&self) -> Vec<(String, Limits)> {
        let limits = self.limits.value.iter();
        limits
            .map(|limit| (limit.result.value.clone(), Limits { low: *limit.low, high: *limit.high }))
            .collect()
    }

    /// Options as the analysis reads them, for [`identity`](crate::analyses::identity).
    pub fn options(&self) -> &str {
        &self.options
    }
}

/// Entries of an inline table on separate lines: the comma before each key is replaced by a line end.
fn separated(options: &str, keys: &[usize]) -> String {
    let mut text = options.as_bytes().to_vec();
    for key in keys {
        if let Some(comma) = text[..*key].iter().rposition(|byte| !byte.is_ascii_whitespace())
            && text[comma] == b','
        {
            text[comma] = b'\n';
        }
    }
    String::from_utf8_lossy(&text).into_owned()
}
