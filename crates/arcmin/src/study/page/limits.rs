//! Limits, singly and together.

use super::{StudyReport, named, percent};
use crate::analyses::{TextBlock, TextTable};
use crate::report::{Column, Table, Tone, compact};
use crate::study::limits::{KeptBy, StudyLimit, is_flag};

/// Expected share of machines of a series that keep the limits.
const EXPECTED: f64 = 0.95;

impl KeptBy {
    /// In words: `12 of 33`, or a share with its interval.
    fn shown(&self) -> String {
        match self.share {
            Some(share) => {
                format!("{} ({} … {})", percent(share.share), percent(share.low), percent(share.high))
            }
            None => format!("{} of {}", self.kept, self.of),
        }
    }

    fn mark(&self) -> &'static str {
        if self.kept == self.of { "✓" } else { "✗" }
    }
}

impl StudyLimit {
    /// Allowed value with its unit.
    fn allowed(&self) -> String {
        if is_flag(&self.result) {
            return "over the service life, by the verdict of `life`".to_owned();
        }
        let unit = named(&self.result).1;
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        match (self.limits.low, self.limits.high) {
            (Some(low), Some(high)) => format!("{} to {}{unit}", compact(low, 4), compact(high, 4)),
            (Some(low), None) => format!("at least {}{unit}", compact(low, 4)),
            (None, Some(high)) => format!("at most {}{unit}", compact(high, 4)),
            (None, None) => String::new(),
        }
    }

    fn source(&self) -> &'static str {
        if self.of_design { "design" } else { "study" }
    }
}

impl StudyReport<'_> {
    /// Share of machines that keep all limits, with its tone.
    pub(super) fn headline(&self, some: &str) -> (Tone, String) {
        let limits = &self.judged.limits;
        let Some(together) = limits.together else {
            return (Tone::Neutral, format!("{some}; the kept results cannot judge any limit."));
        };
        let which = match &limits.each[..] {
            [(one, _)] => format!("the limit of {}", one.name),
            all => format!("all {} limits that are judged", all.len()),
        };
        let Some(share) = together.share else {
            let tone = if together.kept == together.of { Tone::Good } else { Tone::Neutral };
            return (tone, format!("{} of {some} keep {which}.", together.kept));
        };
        let tone = if share.low >= EXPECTED {
            Tone::Good
        } else if share.high >= EXPECTED {
            Tone::Caution
        } else {
            Tone::Bad
        };
        let headline = format!(
            "{} of all machines keep {which} ({} to {} with {} confidence, from {some}).",
            percent(share.share),
            percent(share.low),
            percent(share.high),
            percent(self.judged.confidence)
        );
        (tone, headline)
    }

    /// Limits that are not kept, and those that are not judged.
    pub(super) fn limit_answers(&self) -> Vec<(String, String)> {
        let limits = &self.judged.limits;
        let mut answers = Vec::new();
        let broken: Vec<String> = limits
            .each
            .iter()
            .filter(|(_, kept)| kept.kept < kept.of)
            .map(|(limit, kept)| format!("{} ({}): kept by {}", limit.name, limit.allowed(), kept.shown()))
            .collect();
        if !broken.is_empty() {
            answers.push(("Limits that are not always kept".to_owned(), format!("{}.", broken.join("; "))));
        }
        if !limits.unjudged.is_empty() {
            let words: Vec<String> =
                limits.unjudged.iter().map(|(limit, how)| format!("{limit} ({how})")).collect();
            answers.push(("Limits of the design that are not judged".to_owned(), words.join("; ")));
        }
        answers
    }

    fn limit_rows(&self) -> Vec<Vec<String>> {
        let limits = &self.judged.limits;
        let row = |name: &str, allowed: String, source: &str, kept: &KeptBy| {
            vec![name.to_owned(), allowed, source.to_owned(), kept.shown(), kept.mark().to_owned()]
        };
        let mut rows: Vec<Vec<String>> = (limits.each.iter())
            .map(|(limit, kept)| row(&limit.name, limit.allowed(), limit.source(), kept))
            .collect();
        if let Some(together) = limits.together.filter(|_| limits.each.len() > 1) {
            rows.push(row("all together", String::new(), "", &together));
        }
        rows
    }

    pub(super) fn limits_table(&self) -> Option<Table> {
        let rows = self.limit_rows();
        (!rows.is_empty()).then(|| Table {
            title: "Limits, singly and together".into(),
            columns: vec![
                Column::text("Limit"),
                Column::text("Allowed"),
                Column::text("Set by"),
                Column::text("Kept by"),
                Column::text(""),
            ],
            rows,
            note: "Every limit of the design that the kept results can judge, and those of the study file, which \
                 take \
                   before. Failed samples keep none."
                .into(),
        })
    }

    pub(super) fn limits_block(&self) -> Option<TextBlock> {
        let rows = self.limit_rows();
        let header = ["limit", "allowed", "set by", "kept by", ""].map(str::to_owned).to_vec();
        (!rows.is_empty()).then_some(TextBlock::Table(TextTable { header, rows }))
    }
}
