//! The study file: declared and read like a design, with the same messages.

use crate::design::schema::{default_flag, section};
use crate::design::tree::Node;
use crate::design::variation::{NORMAL_CUT, Variation, Variations, Varied};
use crate::design::{
    At, Choice, Design, DesignError, DesignErrorKind, InputFile, Kind as KeyKind, Section, Source,
    Value as DesignValue, default, optional, word,
};

use super::plan::{Factor, Kept, Kind, Plan, Setting};
use super::sampling::Layout;
use super::{Distribution, StudyError};
use crate::analyses::{self, Analysis, AnalysisError};
use crate::results::Format;

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
        /// What results are allowed to be: for yield and capability, and as constraints.
        limits: Vec<At<Section<LimitSection>>> => optional(0.0, 0.0),
        /// What it costs to make a key vary less.
        costs: Vec<At<Section<CostSection>>> => optional(0.0, 0.0),
    }

    /// How machines are chosen.
    pub struct MethodSection {
        /// The way.
        kind: MethodName => word(),
        /// Machines; for `morris` trajectories, for `saltelli` base points, for `tighten` machines before
        /// tightening. A grid has as many as it has.
        samples: usize => default(100.0, 1.0, 1e9),
        /// Seed of everything that is drawn.
        seed: usize => default(1.0, 0.0, 9e15),
        /// Levels of every range for `grid` and `morris`; even for `morris`.
        levels: usize => default(4.0, 2.0, 1e6),
        /// Whether `saltelli` takes the rows for interactions of two.
        second_order: bool => default_flag(false),
        /// Share by which `tighten` makes a spread less.
        share: f64 => default(0.1, 1e-6, 1.0),
        /// Confidence of all intervals.
        confidence: f64 => default(0.95, 0.5, 0.9999),
    }

    /// What a result is allowed to be.
    pub struct LimitSection {
        /// Key of the result, one of `results`.
        result: String => word(),
        /// Least value allowed.
        low: Option<f64> => optional(f64::NEG_INFINITY, f64::INFINITY),
        /// Largest value allowed.
        high: Option<f64> => optional(f64::NEG_INFINITY, f64::INFINITY),
    }

    /// What it costs to make a key vary less.
    pub struct CostSection {
        /// Path of the key, of `[vary]` or of the design's `[tolerances]`.
        key: String => word(),
        /// Cost of one unit of the key less, in any currency.
        per_unit: f64 => default(1.0, 1e-12, 1e12),
    }
}

/// Ways of choosing machines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MethodName {
    Grid,
    Random,
    LatinHypercube,
    Sobol,
    Morris,
    Saltelli,
    Tighten,
}

impl Choice for MethodName {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("grid", "every combination of levels"),
        ("random", "independent of each other"),
        ("latin-hypercube", "one in each equal part of every range"),
        ("sobol", "a scrambled Sobol sequence: evenest, best with a power of two"),
        ("morris", "trajectories of elementary effects: which of many keys matter"),
        ("saltelli", "first and total shares of the variance (Sobol indices)"),
        ("tighten", "each machine again with one spread less: what to tighten first"),
    ];
    const VALUES: &'static [MethodName] = &[
        MethodName::Grid,
        MethodName::Random,
        MethodName::LatinHypercube,
        MethodName::Sobol,
        MethodName::Morris,
        MethodName::Saltelli,
        MethodName::Tighten,
    ];
}

/// A study file as read; it does not know its design yet.
#[derive(Debug, Clone)]
pub struct StudyFile {
    sections: StudySections,
    text: String,
    file_name: String,
    /// Options of the analysis as TOML, at the lines of the study file.
    options: String,
    /// Names of the options given, each with its place.
    given: Vec<(String, std::ops::Range<usize>)>,
}

impl std::ops::Deref for StudyFile {
    type Target = StudySections;

    fn deref(&self) -> &StudySections {
        &self.sections
    }
}

const TITLE: &str = "the study file";

impl StudyFile {
    /// Reads a study file; `file_name` only serves messages.
    ///
    /// # Errors
    /// Unknown keys, all at once; otherwise the first value that is missing, ill-typed, out of range or
    /// contradicts another one.
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
            given = branch.entries.iter().map(|e| (e.key.to_string(), e.key_span.clone())).collect();
            let spans =
                branch.entries.iter().map(|e| (e.key_span.start, e.item.span.end.max(e.key_span.end)));
            let (first, last) =
                spans.fold((usize::MAX, 0), |(first, last), (start, end)| (first.min(start), last.max(end)));
            // What is not an option becomes blank, so that messages about options name lines of this file.
            let blank = |(at, c): (usize, char)| match c {
                '\n' => "\n".to_owned(),
                c if (first..last).contains(&at) => c.to_string(),
                c => " ".repeat(c.len_utf8()),
            };
            options = text.char_indices().map(blank).collect();
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
                let message = format!("the limits of `{result}` leave nothing to keep to");
                return Err(self.wrong(message, limit.span.clone(), "give `low`, `high`, or both in order"));
            }
        }
        let drawn = *self.tolerances && self.given.iter().any(|(key, _)| key == "errors" || key == "seed");
        if drawn {
            let span = self.given.iter().find(|(key, _)| key == "errors" || key == "seed");
            let message = "machines are drawn, so `errors` and `seed` are not options here".to_owned();
            let hint = "take them out, or set `tolerances = false`";
            return Err(self.wrong(message, span.map(|(_, span)| span.clone()), hint));
        }
        Ok(())
    }

    /// The plan of this study for its design, and how each row is computed. `identity` is what
    /// [`analyses::identity`] gives for design, analysis and options.
    ///
    /// # Errors
    /// Paths that lead to no value, ranges that cannot be, unknown analyses, options and results; layouts
    /// that cannot hold what varies.
    pub fn study(&self, design: &Design, identity: &str) -> Result<Study, AnalysisError> {
        let analysis = analyses::by_name(&self.analysis).ok_or_else(|| {
            let names = analyses::ALL.iter().map(|analysis| analysis.name).collect::<Vec<_>>().join(", ");
            let message = format!("no analysis is called \"{}\"", *self.analysis);
            self.wrong(message, self.analysis.span.clone(), &format!("there are {names}"))
        })?;
        analysis.normal_options(&self.options, &self.file_name)?;
        let schema = (analysis.options)();
        if *self.tolerances {
            if !["errors", "seed"].iter().all(|name| schema.keys.iter().any(|key| key.name == *name)) {
                let message = format!("`{}` knows no drawn machines", analysis.name);
                return Err(self
                    .wrong(message, self.tolerances.span.clone(), "set `tolerances = false`")
                    .into());
            }
            if design.drawing_tolerances().is_none() {
                let message = "the design gives no tolerances to draw machines from".to_owned();
                let hint = "add [tolerances] to the design, or set `tolerances = false`";
                return Err(self.wrong(message, self.tolerances.span.clone(), hint).into());
            }
        }
        let kept = self.kept(analysis)?;
        let mut factors: Vec<Factor> =
            self.vary.0.iter().map(|varied| self.factor(varied, design)).collect::<Result<_, _>>()?;
        if *self.unknowns {
            for unknown in design.unknowns() {
                if factors.iter().all(|factor| factor.path != unknown.path) {
                    let distribution = distribution(&unknown.variation, unknown.nominal)
                        .map_err(|why| self.wrong(why, self.unknowns.span.clone(), "correct the design"))?;
                    factors.push(Factor::number(unknown.path, unknown.unit, distribution));
                }
            }
        }
        let method = &self.method;
        if *self.tolerances {
            factors.push(Factor::drawn());
            if *method.kind == MethodName::Tighten {
                self.add_tolerances(design, &mut factors);
            }
        }
        for cost in &*self.costs.value {
            let Some(factor) = factors.iter_mut().find(|factor| factor.path == *cost.key.value) else {
                let message = format!("`{}` costs something but does not vary", *cost.key);
                return Err(self.wrong(message, cost.key.span.clone(), "name a key that varies").into());
            };
            factor.cost = Some(*cost.per_unit);
        }
        let levels = |factor: &Factor| match factor.distribution {
            Distribution::List { count } => count,
            _ => *method.levels,
        };
        let layout = match *method.kind {
            MethodName::Grid => Layout::Grid { levels: factors.iter().map(levels).collect() },
            MethodName::Random => Layout::Random,
            MethodName::LatinHypercube => Layout::LatinHypercube,
            MethodName::Sobol => Layout::Sobol,
            MethodName::Morris => Layout::Morris { levels: *method.levels },
            MethodName::Saltelli => Layout::Saltelli { second_order: *method.second_order },
            MethodName::Tighten => Layout::Tighten { share: *method.share },
        };
        let refused = |error: StudyError| {
            self.wrong(error.to_string(), method.span.clone(), "change [method], or what varies")
        };
        let plan = Plan::new(identity, factors, layout, *method.samples as u64, *method.seed as u64, kept)
            .map_err(refused)?;
        Ok(Study {
            plan,
            // A key that varies may leave the range in which it is said to be unknown.
            design: design.with("unknowns", DesignValue::LeftOut)?,
            analysis,
            options: self.options.clone(),
            origin: self.file_name.clone(),
        })
    }

    /// Options as the analysis reads them, for [`analyses::identity`].
    pub fn options(&self) -> &str {
        &self.options
    }

    fn kept(&self, analysis: &Analysis) -> Result<Vec<Kept>, Box<DesignError>> {
        let declared = (analysis.results)();
        let curves: Vec<String> = declared
            .tables
            .iter()
            .flat_map(|table| table.columns.iter().map(|column| format!("{}.{}", table.name, column.key)))
            .collect();
        let one = |key: &String| {
            if let Some(quantity) = declared.summary.iter().find(|quantity| quantity.key == key) {
                let plain = quantity.format == Format::Plain && quantity.unit().is_empty();
                return Ok(Kept { key: key.clone(), kind: if plain { Kind::Word } else { Kind::Number } });
            }
            if curves.contains(key) {
                return Ok(Kept { key: key.clone(), kind: Kind::Curve });
            }
            let all =
                declared.summary.iter().map(|quantity| quantity.key).chain(curves.iter().map(|c| c.as_str()));
            let near = all
                .map(|known| (strsim::damerau_levenshtein(known, key), known))
                .min()
                .filter(|(distance, _)| *distance <= 3 + key.len() / 4);
            let hint = near.map_or_else(
                || format!("`arcmin keys --results` lists the results of `{}`", analysis.name),
                |(_, near)| format!("did you mean `{near}`?"),
            );
            let message = format!("`{}` has no result `{key}`", analysis.name);
            Err(self.wrong(message, self.results.span.clone(), &hint))
        };
        self.results.iter().map(one).collect()
    }

    fn factor(&self, varied: &Varied, design: &Design) -> Result<Factor, Box<DesignError>> {
        let at = |why: String, hint: &str| self.wrong(why, Some(varied.span.clone()), hint);
        let path = &varied.path;
        let value = design.get(path).map_err(|error| {
            self.source().error(error.kind.clone(), varied.path_span.clone(), error.hint.clone())
        })?;
        if let Variation::OneOf(values) = &varied.variation {
            let entries: Option<Vec<Setting>> = values.iter().map(setting).collect();
            let entries = entries.ok_or_else(|| {
                at(format!("`{path}` cannot take one of these"), "numbers, words, true, false")
            })?;
            for value in values {
                if let Err(error) = design.with("unknowns", DesignValue::LeftOut)?.with(path, value.clone())
                    && !matches!(error.kind, DesignErrorKind::Contradiction { .. })
                {
                    return Err(at(error.kind.to_string(), error.hint.as_deref().unwrap_or_default()));
                }
            }
            return Ok(Factor::one_of(path.clone(), entries));
        }
        let keys = design.keys();
        let entry = keys.iter().find(|entry| entry.path == *path);
        let whole = entry.is_some_and(|entry| matches!(entry.kind, KeyKind::Count));
        let nominal = value.as_number();
        if nominal.is_none()
            && !matches!(entry, Some(entry) if matches!(entry.kind, KeyKind::Number | KeyKind::Count))
        {
            return Err(at(
                format!("`{path}` is no number, so it has no range"),
                "give a list of its values",
            ));
        }
        let needs_nominal =
            matches!(varied.variation, Variation::Factor { .. } | Variation::Normal { mean: None, .. });
        let nominal = match nominal {
            Some(nominal) => nominal,
            None if !needs_nominal => 0.0,
            None => {
                let why = format!("`{path}` has no value in the design to vary about");
                return Err(at(why, "give `low` and `high`, or `mean` and `deviation`"));
            }
        };
        let distribution =
            distribution(&varied.variation, nominal).map_err(|why| at(why, "give `low` and `high`"))?;
        if let (Some([low, high]), Some(ends)) = (entry.and_then(|entry| entry.range), bounds(&distribution))
            && (ends[0] < low || ends[1] > high)
        {
            let why = format!("`{path}` would vary from {} to {}", ends[0], ends[1]);
            return Err(at(why, &format!("{low} to {high} are believable")));
        }
        let unit = entry.map_or("", |entry| entry.unit);
        Ok(Factor { whole, ..Factor::number(path.clone(), unit, distribution) })
    }

    /// Each width of the design's tolerances, to be made less in its turn.
    fn add_tolerances(&self, design: &Design, factors: &mut Vec<Factor>) {
        for entry in design.keys() {
            if let Some(width) = entry.value.as_number()
                && entry.path.starts_with("tolerances.")
                && width > 0.0
                && factors.iter().all(|factor| factor.path != entry.path)
            {
                factors.push(Factor::number(entry.path, entry.unit, Distribution::Tolerance { width }));
            }
        }
    }
}

/// Entries of an inline table on lines of their own: the comma before each key becomes the end of a line.
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

fn setting(value: &DesignValue) -> Option<Setting> {
    match value {
        DesignValue::Number(number) => Some(Setting::Number(*number)),
        DesignValue::Count(count) => Some(Setting::Number(*count as f64)),
        DesignValue::Text(text) => Some(Setting::Word(text.clone())),
        DesignValue::Flag(flag) => Some(Setting::Flag(*flag)),
        _ => None,
    }
}

fn distribution(variation: &Variation, nominal: f64) -> Result<Distribution, String> {
    use crate::design::variation::Distribution as Written;
    Ok(match variation.about(nominal)? {
        Written::Uniform { low, high } => Distribution::Uniform { low, high },
        Written::LogUniform { low, high } => Distribution::LogUniform { low, high },
        Written::Normal { mean, deviation } => {
            Distribution::Normal { mean, deviation, limit: Some(NORMAL_CUT) }
        }
        Written::OneOf(_) => return Err("a list of values has no distribution".to_owned()),
    })
}

fn bounds(distribution: &Distribution) -> Option<[f64; 2]> {
    match *distribution {
        Distribution::Uniform { low, high } | Distribution::LogUniform { low, high } => Some([low, high]),
        Distribution::Normal { mean, deviation, limit: Some(limit) } => {
            Some([mean - limit * deviation, mean + limit * deviation])
        }
        _ => None,
    }
}

/// A study that can be run: its plan, and what its rows are computed by.
pub struct Study {
    pub plan: Plan,
    pub design: Design,
    pub analysis: &'static Analysis,
    options: String,
    origin: String,
}

impl Study {
    pub(super) fn options(&self) -> &str {
        &self.options
    }

    pub(super) fn origin(&self) -> &str {
        &self.origin
    }
}
