//! Band of a life within the `[unknowns]` of the design: the study of `life --band`.

use serde_json::{Value as Json, json};

use super::judge::{Judged, JudgedResult, Sensitivity};
use super::page::StudyReport;
use super::{Rows, Study, StudyFile};
use crate::analyses::life::{about, limit_hours};
use crate::analyses::stage::AnyDesign;
use crate::analyses::{AnalysisError, TextBlock};
use crate::analyses::{Host, by_name};
use crate::report::{Block, Page, Section, compact, significant};

/// Machines whose smallest and largest enclose 95 % of all with 95 % confidence (Wilks).
pub const MACHINES: u64 = 93;
const CONFIDENCE: f64 = 0.95;
/// Results of `life` with a band, the headline first: hours to every limit, and related quantities.
const RESULTS: &[&str] = &[
    "hours_to_limit",
    "lost_motion_arcmin",
    "lost_motion_new_arcmin",
    "max_pressure_mpa",
    "max_depth_um",
    "life.lost_motion_arcmin",
];
/// Number of keys of the ranking in texts.
const RANKED_IN_TEXT: usize = 3;
/// Largest share of lives that may end beyond the search; above it the ranking uses the lost motion at the end.
const ONGOING: f64 = 0.2;

/// The study of the lives of a design whose unknowns vary; `options` are those of `life`, without multibody
/// runs.
///
/// # Errors
/// A design without unknowns; options that are wrong.
pub fn study(
    design: &AnyDesign,
    options: &str,
    machines: u64,
    seed: u64,
    host: &dyn Host,
) -> Result<Study, AnalysisError> {
    if design.unknowns().is_empty() {
        return Err(AnalysisError::usage(
            "the design has no [unknowns]",
            "add a section [unknowns]; `arcmin keys unknowns` explains it",
        ));
    }
    let once = |line: &&str| !line.starts_with("quasi_static");
    let options = options.lines().filter(once).collect::<Vec<_>>().join("\n");
    let results = RESULTS.iter().copied().chain(limit_hours().map(|(_, key)| key));
    let results = results.map(|key| format!("{key:?}")).collect::<Vec<_>>().join(", ");
    let text = format!(
        "design = \"design\"\nanalysis = \"life\"\nunknowns = true\nresults = [{results}]\n\n\
         [options]\n{options}\n\
         quasi_static = true\n\n[method]\nkind = \"random\"\nsamples = {machines}\nseed = {seed}\n\
         confidence = {CONFIDENCE}\n"
    );
    let file = StudyFile::parse(&text, "the options")?;
    let identity = match by_name(&file.analysis) {
        Some(analysis) => design.identity(analysis, file.options(), "the options", host)?,
        None => String::new(),
    };
    file.study(design, &identity)
}

/// Statistics of the lives.
pub struct Band<'a> {
    study: &'a Study,
    rows: &'a Rows,
    judged: &'a Judged,
}

impl<'a> Band<'a> {
    /// The band of a study from its available rows.
    pub fn new(study: &'a Study, rows: &'a Rows, judged: &'a Judged) -> Band<'a> {
        Band { study, rows, judged }
    }

    fn result(&self, key: &str) -> Option<&JudgedResult> {
        self.judged.results.iter().find(|result| result.key == key)
    }

    /// Ends of the band of a result: the smallest and the largest value that enclose 95 % with 95 % confidence, or
    /// all values with their confidence.
    fn ends(&self, key: &str) -> Option<(f64, f64)> {
        let spread = self.result(key)?.spread.as_ref()?;
        match &spread.band {
            Some(band) => Some((band.low?, band.high?)),
            None => {
                let values = self.rows.numbers(&self.study.plan, key)?;
                let values = values.into_iter().flatten();
                let ends = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
                (ends.0 <= ends.1).then_some(ends)
            }
        }
    }

    fn searched(&self) -> f64 {
        let searched = self.rows.numbers(&self.study.plan, super::file::SEARCHED).unwrap_or_default();
        searched.into_iter().flatten().fold(0.0, f64::max)
    }

    /// Share of lives that end beyond the search.
    fn ongoing(&self) -> f64 {
        let Some(life) = self.result(LIFE) else { return 1.0 };
        let of = self.rows.records.len() - self.rows.failed();
        life.absent as f64 / (of.max(1)) as f64
    }

    /// The result that ranks the unknowns.
    fn ranked_by(&self) -> &'static str {
        if self.ongoing() > ONGOING { END } else { LIFE }
    }

    /// (key, share of the variance), the largest first.
    pub fn ranking(&self) -> Vec<(&str, f64)> {
        let Some(Sensitivity::Linear(fit)) = self.result(self.ranked_by()).map(|result| &result.sensitivity)
        else {
            return Vec::new();
        };
        let factors = self.study.plan.factors().iter().map(|factor| factor.path.as_str());
        let mut ranking: Vec<(&str, f64)> = factors.zip(fit.shares.iter().map(|share| share.value)).collect();
        ranking.sort_by(|a, b| b.1.total_cmp(&a.1));
        ranking
    }

    /// "3100 to 7400 h" of a result in hours; absent ones are beyond the computed hours.
    fn hours(&self, key: &str) -> Option<String> {
        let searched = about(self.searched());
        let hours =
            |hours: f64| if hours.is_finite() { about(hours) } else { format!("more than {searched}") };
        self.ends(key).map(|(low, high)| format!("{} to {} h", hours(low), hours(high)))
    }

    /// The result in a sentence.
    pub fn sentence(&self) -> String {
        let life = match self.hours(LIFE) {
            Some(hours) => format!("reaches the first of its limits after {hours}"),
            None if self.searched() > 0.0 => {
                format!("stays within its limits for more than {} h", about(self.searched()))
            }
            None => "has no result".to_owned(),
        };
        let what = if self.ranked_by() == LIFE { "that" } else { "the lost motion's spread" };
        let ranking = self.ranking();
        let share = |share: f64| format!("{} %", significant(100.0 * share, 2));
        let causes = match ranking.first() {
            Some((key, first)) if *first > 0.0 => {
                format!("; measure `{key}` first, which makes {} of {what}", share(*first))
            }
            _ => String::new(),
        };
        let count = self.rows.records.len();
        let failed = match self.rows.failed() {
            0 => String::new(),
            failed => format!(", {failed} of which have no result"),
        };
        format!(
            "Within the ranges of [unknowns] the machine {life}{causes} (95 % of the machines, with {} \
             confidence, from {count} machines{failed}).",
            self.confidence()
        )
    }

    /// Confidence that the band contains 95 %.
    fn confidence(&self) -> String {
        let band = self
            .result(END)
            .and_then(|result| result.spread.as_ref())
            .and_then(|spread| spread.band.as_ref());
        match band {
            Some(band) => format!("{} %", compact(100.0 * band.confidence, 3)),
            None => {
                let count = self.rows.records.len() - self.rows.failed();
                let attained = super::statistics::attained_confidence(count, 0.95);
                format!("{} %", significant(100.0 * attained, 2))
            }
        }
    }

    /// Text for the terminal.
    pub fn text_blocks(&self) -> Vec<TextBlock> {
        let mut blocks = vec![TextBlock::line(self.sentence())];
        let in_words: Vec<String> = self
            .ranking()
            .into_iter()
            .take(RANKED_IN_TEXT)
            .filter(|(_, share)| *share > 0.01)
            .map(|(key, share)| format!("{key} ({} %)", significant(100.0 * share, 2)))
            .collect();
        if !in_words.is_empty() {
            blocks.push(TextBlock::line(format!("measure first: {}", in_words.join(", "))));
        }
        let each = limit_hours().filter_map(|(kind, key)| Some((kind, self.hours(key)?)));
        blocks.extend(each.map(|(kind, hours)| TextBlock::line(format!("  {}: {hours}", kind.name()))));
        blocks
    }

    /// Sections of the report of the life: results with their bands, bands over the hours, ranking.
    pub fn sections(&self) -> Vec<Section> {
        let report: StudyReport = self.study.report(self.rows, self.judged);
        let Page { sections, .. } = report.page();
        let mut blocks = vec![Block::Text(self.sentence())];
        for section in sections {
            if ["results", "bands", "causes"].contains(&section.id.as_str()) {
                blocks.extend(section.blocks);
            }
        }
        vec![Section::new("unknowns", "How sure this is", blocks)]
    }

    /// Object `band` of `summary.json`.
    pub fn to_json(&self) -> Json {
        let one = |key: &str| {
            let (low, high) = self.ends(key)?;
            let end = |x: f64| if x.is_finite() { json!(x) } else { Json::Null };
            let median = self.result(key)?.spread.as_ref()?.quantiles.iter().find(|q| q.share == 0.5);
            let median = median.map_or(Json::Null, |q| end(q.estimate));
            Some((key.to_owned(), json!({ "low": end(low), "median": median, "high": end(high) })))
        };
        let keys = self.judged.results.iter().map(|result| result.key.as_str());
        let keys = keys.filter(|key| *key != super::file::SEARCHED);
        let ranked = |(key, share): (&str, f64)| json!({ "key": key, "share": share });
        let ranking: Vec<Json> = self.ranking().into_iter().map(ranked).collect();
        json!({
            "sentence": self.sentence(),
            "machines": self.rows.records.len(), "failed": self.rows.failed(),
            "coverage": 0.95, "confidence": CONFIDENCE,
            "searched_h": self.searched(),
            "results": keys.filter_map(one).collect::<serde_json::Map<_, _>>(),
            "ranked_by": self.ranked_by(),
            "ranking": ranking,
        })
    }
}

const LIFE: &str = "hours_to_limit";
const END: &str = "lost_motion_arcmin";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analyses::NoHost;
    use crate::study::part::{Cell, Record};

    /// Rows as a study would have them, lives spread evenly by the wear coefficient alone.
    fn rows(study: &Study, life: impl Fn(f64) -> Option<f64>) -> Rows {
        let plan = &study.plan;
        let columns = plan.columns();
        let wear = columns.iter().position(|(name, _)| name.contains("wear.coupled")).unwrap();
        let records = (0..plan.rows())
            .map(|number| {
                let unit = plan.sampling().point(number).unit;
                let cells = columns
                    .iter()
                    .enumerate()
                    .map(|(index, (name, _))| match *name {
                        _ if index < unit.len() => Cell::Number(unit[index]),
                        "hours_to_limit" => life(unit[wear]).map_or(Cell::Absent, Cell::Number),
                        "lost_motion_arcmin" => Cell::Number(0.5 + unit[wear]),
                        "searched_h" => Cell::Number(30_000.0),
                        _ => Cell::Absent,
                    })
                    .collect();
                Record { number, cells, failed: None }
            })
            .collect();
        Rows { records, of: plan.rows(), unusable: Vec::new() }
    }

    #[test]
    fn the_verdict_is_worded_by_the_band() {
        let design: AnyDesign = crate::templates::design("tao2024").unwrap().into();
        let study = study(&design, "points = 6\nquasi_static = true", MACHINES, 1, &NoHost).unwrap();
        assert_eq!(study.plan.rows(), 93);
        assert!(study.plan.factors().len() > 20);
        let in_words = |life: &dyn Fn(f64) -> Option<f64>| {
            let rows = rows(&study, life);
            let judged = study.judge(&rows).unwrap();
            let band = Band::new(&study, &rows, &judged);
            (band.sentence(), band.to_json(), band.text_blocks().len())
        };
        let wear =
            study.plan.factors().iter().position(|factor| factor.path.contains("wear.coupled")).unwrap();
        let units = (0..93).map(|row| study.plan.sampling().point(row).unit[wear]);
        let (least, most) = units.fold((1.0_f64, 0.0_f64), |(a, b), u| (a.min(u), b.max(u)));
        let (sentence, json, blocks) = in_words(&|u| Some(6000.0 + 8000.0 * u));
        let expected = [least, most].map(|u| about(6000.0 + 8000.0 * u));
        assert!(
            sentence.contains(&format!("first of its limits after {} to {} h", expected[0], expected[1])),
            "{sentence}"
        );
        assert!(
            sentence
                .contains("measure `wear.coupled.coefficient_mm2_per_n` first, which makes 100 % of that"),
            "{sentence}"
        );
        assert!(sentence.contains("with 95 % confidence, from 93 machines") && blocks == 2, "{sentence}");
        let ends = &json["results"]["hours_to_limit"];
        assert_eq!(ends["low"].as_f64().unwrap(), 6000.0 + 8000.0 * least);
        assert_eq!(ends["high"].as_f64().unwrap(), 6000.0 + 8000.0 * most);
        // Some go on beyond the search: the upper end is open.
        let (sentence, json, _) = in_words(&|u| (u < 0.9).then_some(6000.0 + 8000.0 * u));
        assert!(sentence.contains("to more than 30000 h"), "{sentence}");
        assert!(json["results"]["hours_to_limit"]["high"].is_null());
        // None ends.
        let (sentence, json, _) = in_words(&|_| None);
        assert!(
            sentence.contains("stays within its limits for more than 30000 h")
                && json["ranked_by"] == "lost_motion_arcmin",
            "{sentence}"
        );
        let known = design.without_unknowns().unwrap();
        assert!(super::study(&known, "", 9, 1, &NoHost).is_err());
    }
}
