//! From the study file and its design to the computations.

use super::{MethodName, SEARCHED, StudyFile};
use crate::analyses::stage::AnyDesign;
use crate::analyses::{self, Analysis, AnalysisError};
use crate::design::variation::{NORMAL_CUT, Variation, Varied};
use crate::design::{DesignError, DesignErrorKind, KeyEntry, Kind as KeyKind, Unknown, Value as DesignValue};
use crate::results::{Declared, Format};
use crate::study::limits::{self, StudyLimits};
use crate::study::list_place::ListPlace;
use crate::study::plan::{Factor, Kept, Kind, Plan, Setting};
use crate::study::sampling::Layout;
use crate::study::search::{Bound, Goal, Search, place_of};
use crate::study::{Distribution, StudyError};

impl StudyFile {
    /// The plan of this study for its design, and how each row is computed. `identity` is what
    /// [`analyses::identity`] gives for design, analysis and options.
    ///
    /// # Errors
    /// Paths without a value, invalid ranges, unknown analyses, options and results; layouts that are not
    /// possible for the varied keys.
    pub fn study(&self, design: &AnyDesign, identity: &str) -> Result<Study, AnalysisError> {
        let analysis = analyses::by_name(&self.analysis).ok_or_else(|| {
            let names = analyses::ALL.iter().map(|analysis| analysis.name).collect::<Vec<_>>().join(", ");
            let message = format!("no analysis is called \"{}\"", *self.analysis);
            self.wrong(message, self.analysis.span.clone(), &format!("there are {names}"))
        })?;
        let normal = design.normal_options(analysis, &self.options, &self.file_name)?;
        let schema = design.options(analysis)?;
        let declared = design.results(analysis)?;
        if *self.tolerances {
            if !["errors", "seed"].iter().all(|name| schema.keys.iter().any(|key| key.name == *name)) {
                let message = format!("`{}` does not support drawn machines", analysis.name);
                return Err(self
                    .wrong(message, self.tolerances.span.clone(), "set `tolerances = false`")
                    .into());
            }
            if !design.has_tolerances() {
                let message = "the design gives no tolerances to draw machines from".to_owned();
                let hint = "add [tolerances] to the design, or set `tolerances = false`";
                return Err(self.wrong(message, self.tolerances.span.clone(), hint).into());
            }
            if normal.text.lines().any(|line| line == "joints = \"ideal\"" || line == "joints = ideal") {
                let message = "ideal joints do not support the errors of drawn machines".to_owned();
                let hint = "write joints = \"bearings\" in [options]";
                return Err(self.wrong(message, self.tolerances.span.clone(), hint).into());
            }
        }
        let kept = self.kept(analysis, &declared, design)?;
        let mut factors: Vec<Factor> =
            self.vary.0.iter().map(|varied| self.factor(varied, design)).collect::<Result<_, _>>()?;
        if *self.unknowns {
            for unknown in design.unknowns() {
                if factors.iter().all(|factor| factor.path != unknown.path) {
                    factors.push(self.unknown(unknown, design)?);
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
        let refused = |error: StudyError| {
            self.wrong(error.to_string(), method.span.clone(), "change [method], or what varies")
        };
        // A varied key may leave its range in [unknowns].
        let written = design.clone();
        let design = match design.unknowns().is_empty() {
            true => written.clone(),
            false => design.with("unknowns", DesignValue::LeftOut)?,
        };
        let search = match *method.kind {
            MethodName::Optimise => Some(self.search(&design, identity, &factors, &kept)?),
            _ => None,
        };
        if let Some(search) = &search {
            search.validate().map_err(refused)?;
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
            MethodName::Cases => {
                let count = factors.first().map_or(0, |factor| factor.entries.len());
                Layout::Cases { count }
            }
            MethodName::Optimise => Layout::Random,
        };
        let limits = StudyLimits::of(&self.limits(), analysis, &declared, &design, &kept, &factors);
        let batches = self.batches.value.as_ref();
        let batches = batches.map(|b| Batches { machines: *b.machines as u64, share: *b.share });
        let plan = match &search {
            Some(search) => search.first().map_err(refused)?,
            None => {
                let identity = match batches {
                    Some(batches) => format!("{identity} {batches:?}"),
                    None => identity.to_owned(),
                };
                let (samples, seed) = (*method.samples as u64, *method.seed as u64);
                let plan = Plan::new(&identity, factors, layout, samples, seed, kept).map_err(refused)?;
                match *method.samples_per_part {
                    Some(samples) => plan.with_samples_per_part(samples as u64),
                    None => plan,
                }
            }
        };
        Ok(Study {
            plan,
            search,
            batches,
            written,
            design,
            analysis,
            limits,
            confidence: *method.confidence,
            method: *method.kind,
            options: self.options.clone(),
            origin: self.file_name.clone(),
        })
    }

    /// Ranges and lists are searched; keys with a deviation, drawn errors and unknowns scatter.
    fn search(
        &self,
        design: &AnyDesign,
        identity: &str,
        factors: &[Factor],
        kept: &[Kept],
    ) -> Result<Search, Box<DesignError>> {
        let is_varied = |factor: &Factor| self.vary.0.iter().any(|varied| varied.path == factor.path);
        let scatters = |factor: &Factor| {
            !is_varied(factor)
                || matches!(factor.distribution, Distribution::Normal { .. } | Distribution::Drawn)
        };
        let searched: Vec<usize> = (0..factors.len()).filter(|f| !scatters(&factors[*f])).collect();
        let start = searched.iter().map(|factor| {
            let factor = &factors[*factor];
            place_in(factor, design).ok_or_else(|| {
                let varied = self.vary.0.iter().find(|varied| varied.path == factor.path);
                let message =
                    format!("the value of `{}` in the design is outside the searched range", factor.path);
                let hint =
                    "the search starts from the design as it stands: widen the range, or change the design";
                self.wrong(message, varied.map(|varied| varied.span.clone()), hint)
            })
        });
        let start: Vec<f64> = start.collect::<Result<_, _>>()?;
        let method = &self.method;
        let alike = searched.len() == factors.len();
        Ok(Search {
            goals: self
                .goals
                .iter()
                .map(|goal| Goal {
                    key: goal.result.value.clone(),
                    largest: *goal.aim == super::Aim::Largest,
                    share: Some(*goal.share),
                })
                .collect(),
            bounds: self
                .limits
                .iter()
                .map(|limit| Bound {
                    key: limit.result.value.clone(),
                    low: *limit.low,
                    high: *limit.high,
                    share: *limit.share,
                })
                .collect(),
            start,
            searched,
            machines: if alike { 1 } else { method.machines.value.unwrap_or(20) as u64 },
            check_machines: if alike { 0 } else { *method.check_machines as u64 },
            generations: *method.generations as u64,
            population: *method.population,
            step: *method.step,
            seed: *method.seed as u64,
            factors: factors.to_vec(),
            kept: kept.to_vec(),
            what: identity.to_owned(),
            samples_per_part: method.samples_per_part.value.map(|samples| samples as u64),
        })
    }

    fn kept(
        &self,
        analysis: &Analysis,
        declared: &Declared,
        design: &AnyDesign,
    ) -> Result<Vec<Kept>, Box<DesignError>> {
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
        let mut kept: Vec<Kept> = self.results.iter().map(one).collect::<Result<_, _>>()?;
        // Lives beyond the search are distinguished from missing ones by the searched hours; curves need their hours.
        let mut also = |key: String, kind: Kind| {
            if kept.iter().all(|known| known.key != key) {
                kept.push(Kept { key, kind });
            }
        };
        if *self.method.kind != MethodName::Optimise {
            for kept in limits::kept_besides(analysis, design) {
                also(kept.key, kept.kind);
            }
        }
        let is_life = self.results.iter().any(|key| key.starts_with("hours_to"));
        if is_life && declared.summary.iter().any(|quantity| quantity.key == SEARCHED) {
            also(SEARCHED.to_owned(), Kind::Number);
        }
        for key in &*self.results {
            if let Some((table, _)) = key.rsplit_once('.').filter(|_| curves.contains(key)) {
                let hours = format!("{table}.hours");
                if curves.contains(&hours) {
                    also(hours, Kind::Curve);
                }
            }
        }
        Ok(kept)
    }

    /// An unknown of the design: one of its values, or a number, rounded for counts.
    fn unknown(&self, unknown: Unknown, design: &AnyDesign) -> Result<Factor, Box<DesignError>> {
        if let Variation::OneOf(values) = &unknown.variation {
            return Ok(Factor::one_of(unknown.path, values.iter().filter_map(setting).collect()));
        }
        let distribution = distribution(&unknown.variation, unknown.nominal)
            .map_err(|why| self.wrong(why, self.unknowns.span.clone(), "correct the design"))?;
        let counted = |entry: &KeyEntry| entry.path == unknown.path && matches!(entry.kind, KeyKind::Count);
        let whole = design.keys().iter().any(counted);
        Ok(Factor { whole, ..Factor::number(unknown.path, unknown.unit, distribution) })
    }

    fn factor(&self, varied: &Varied, design: &AnyDesign) -> Result<Factor, Box<DesignError>> {
        let at = |why: String, hint: &str| self.wrong(why, Some(varied.span.clone()), hint);
        let path = &varied.path;
        let place = ListPlace::find(design, path);
        let value = match &place {
            Some(place) => DesignValue::Number(place.number),
            None => design.get(path).map_err(|error| {
                self.source().error(error.kind.clone(), varied.path_span.clone(), error.hint.clone())
            })?,
        };
        let keys = design.keys();
        let list = place.as_ref().map_or(path.as_str(), |place| place.list.as_str());
        let entry = keys.iter().find(|entry| entry.path == list);
        let unit = entry.map_or("", |entry| entry.unit).to_owned();
        if let Variation::OneOf(values) = &varied.variation {
            let entries: Option<Vec<Setting>> = values.iter().map(setting).collect();
            let entries = entries.ok_or_else(|| {
                at(format!("`{path}` cannot take one of these"), "numbers, words, true, false")
            })?;
            for value in values.iter().filter(|_| place.is_none()) {
                if let Err(error) = design.without_unknowns()?.with(path, value.clone())
                    && !matches!(error.kind, DesignErrorKind::Contradiction { .. })
                {
                    return Err(at(error.kind.to_string(), error.hint.as_deref().unwrap_or_default()));
                }
            }
            return Ok(Factor { unit, ..Factor::one_of(path.clone(), entries) });
        }
        let whole = entry.is_some_and(|entry| matches!(entry.kind, KeyKind::Count));
        let nominal = value.as_number();
        if nominal.is_none()
            && !matches!(entry, Some(entry) if matches!(entry.kind, KeyKind::Number | KeyKind::Count))
        {
            return Err(at(
                format!("`{path}` is not a number, so that it has no range"),
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
            return Err(at(why, &format!("the allowed range is {low} to {high}")));
        }
        Ok(Factor { whole, ..Factor::number(path.clone(), unit, distribution) })
    }

    /// Each tolerance of the design, tightened one after the other.
    fn add_tolerances(&self, design: &AnyDesign, factors: &mut Vec<Factor>) {
        for entry in design.keys() {
            if let Some(width) = entry.value.as_number()
                && is_tolerance(&entry.path)
                && width > 0.0
                && factors.iter().all(|factor| factor.path != entry.path)
            {
                factors.push(Factor::number(entry.path, entry.unit, Distribution::Tolerance { width }));
            }
        }
    }
}

/// Whether a key is a width from which machines are drawn, whatever the family: drives of several stages have several sections.
fn is_tolerance(path: &str) -> bool {
    let sections = ["tolerances.", "second_tolerances.", "first_stage.tolerances."];
    sections.iter().any(|section| path.starts_with(section))
}

/// Position of the design in the searched space; `None` outside.
fn place_in(factor: &Factor, design: &AnyDesign) -> Option<f64> {
    if factor.entries.is_empty() {
        return place_of(&factor.distribution, number_at(design, &factor.path)?);
    }
    let own = match ListPlace::find(design, &factor.path) {
        Some(place) => Setting::Number(place.number),
        None => setting(&design.get(&factor.path).ok()?)?,
    };
    let index = factor.entries.iter().position(|entry| *entry == own)?;
    Some((index as f64 + 0.5) / factor.entries.len() as f64)
}

/// The number of a key or of an entry of a list.
fn number_at(design: &AnyDesign, path: &str) -> Option<f64> {
    match ListPlace::find(design, path) {
        Some(place) => Some(place.number),
        None => design.get(path).ok()?.as_number(),
    }
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

/// Batches that machines are drawn in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Batches {
    /// Machines of one batch.
    pub machines: u64,
    /// Share of the variance between batches.
    pub share: f64,
}

/// A study that can be run: its plan, and the data for the computation of its rows.
pub struct Study {
    /// For a search: position of the given design, at which it starts.
    pub plan: Plan,
    /// The search, if there is one.
    pub search: Option<Search>,
    /// Batches; `None` if machines are drawn independently.
    pub batches: Option<Batches>,
    /// The design as written.
    pub(in crate::study) written: AnyDesign,
    /// The design without its `[unknowns]`.
    pub design: AnyDesign,
    /// Analysis that computes every row.
    pub analysis: &'static Analysis,
    /// Limits of the machines.
    pub limits: StudyLimits,
    /// Confidence of all intervals.
    pub confidence: f64,
    /// Method by its name in the file.
    pub method: MethodName,
    options: String,
    origin: String,
}

impl Study {
    pub(in crate::study) fn options(&self) -> &str {
        &self.options
    }

    pub(in crate::study) fn origin(&self) -> &str {
        &self.origin
    }
}
