//! A grid over one key as curves, over two as maps.

use super::{RESULTS_DRAWN, StudyReport, axis, named};
use crate::report::{Axis, Block, HeatMap, Plot, Series, Style, Width, compact};
use crate::study::judge::JudgedResult;
use crate::study::part::Record;
use crate::study::sampling::Layout;
use crate::study::{Factor, Setting};

/// A key of the grid: its place in the plan, and its values in order.
struct Key<'a> {
    factor: &'a Factor,
    index: usize,
    /// Values of numbers; positions of words in their list.
    values: Vec<f64>,
    words: Vec<String>,
}

impl Key<'_> {
    /// Position of a setting.
    fn place(&self, setting: &Setting) -> Option<f64> {
        match setting {
            Setting::Number(number) => Some(*number),
            Setting::Seed(_) => None,
            other => {
                let word = written(other);
                self.words.iter().position(|known| *known == word).map(|place| place as f64)
            }
        }
    }

    fn axis(&self) -> Axis {
        Axis::new(self.factor.path.clone(), self.factor.unit.clone())
    }

    /// A value with its unit, as the name of a curve.
    fn shown(&self, value: f64) -> String {
        match self.words.get(value as usize) {
            Some(word) if !self.words.is_empty() => word.clone(),
            _ => format!("{} {}", compact(value, 4), self.factor.unit).trim_end().to_owned(),
        }
    }
}

fn written(setting: &Setting) -> String {
    match setting {
        Setting::Word(word) => word.clone(),
        Setting::Flag(flag) => flag.to_string(),
        Setting::Number(number) => compact(*number, 6),
        Setting::Seed(seed) => seed.to_string(),
    }
}

impl StudyReport<'_> {
    /// Curves over one key, maps or families of curves over two; a note where there are more.
    pub(super) fn grid(&self) -> Vec<Block> {
        if !matches!(self.plan.sampling().layout(), Layout::Grid { .. }) {
            return Vec::new();
        }
        let keys: Vec<Key> = (self.plan.factors().iter().enumerate())
            .map(|(index, factor)| self.key(index, factor))
            .filter(|key| key.values.len() > 1)
            .collect();
        let results = || self.judged.results.iter().take(RESULTS_DRAWN);
        match &keys[..] {
            [x] => results().filter_map(|result| self.curves(result, x, None)).map(Block::Plot).collect(),
            [a, b] if a.words.is_empty() && b.words.is_empty() => {
                let maps = results().filter_map(|result| self.map(result, a, b));
                let kept = self.kept_map(a, b);
                maps.chain(kept).map(Block::HeatMap).collect()
            }
            [a, b] => {
                let (x, family) = if a.words.is_empty() { (a, b) } else { (b, a) };
                results().filter_map(|result| self.curves(result, x, Some(family))).map(Block::Plot).collect()
            }
            [] => Vec::new(),
            more => vec![Block::Text(format!(
                "The grid has {} keys: its samples are below, where a range is kept by dragging along an axis.",
                more.len()
            ))],
        }
    }

    fn key<'a>(&self, index: usize, factor: &'a Factor) -> Key<'a> {
        let mut words: Vec<String> = Vec::new();
        let mut values: Vec<f64> = Vec::new();
        for record in &self.rows.records {
            match &self.plan.row(record.number).settings[index] {
                Setting::Number(number) => values.push(*number),
                Setting::Seed(_) => {}
                other => {
                    let word = written(other);
                    if !words.contains(&word) {
                        values.push(words.len() as f64);
                        words.push(word);
                    }
                }
            }
        }
        values.sort_by(f64::total_cmp);
        values.dedup();
        Key { factor, index, values, words }
    }

    /// Places of all rows in these keys, with the value of a result; failed rows have none.
    fn points(&self, result: &str, keys: &[&Key<'_>]) -> Vec<(Vec<f64>, Option<f64>)> {
        let values = self.rows.numbers(self.plan, result).unwrap_or_default();
        let point = |(record, value): (&Record, Option<f64>)| {
            let row = self.plan.row(record.number);
            let places: Option<Vec<f64>> =
                keys.iter().map(|key| key.place(&row.settings[key.index])).collect();
            Some((places?, value.filter(|value| value.is_finite())))
        };
        self.rows.records.iter().zip(values).filter_map(point).collect()
    }

    fn curves(&self, result: &JudgedResult, x: &Key<'_>, family: Option<&Key<'_>>) -> Option<Plot> {
        let label = named(&result.key).0;
        let title = format!("{label} over {}", x.factor.path);
        let mut plot = Plot::new(title, x.axis(), axis(&result.key));
        let mut missing = 0;
        for member in family.map_or(vec![None], |family| family.values.iter().map(|v| Some(*v)).collect()) {
            let keys: Vec<&Key<'_>> = std::iter::once(x).chain(family).collect();
            let mut points: Vec<(f64, f64)> = self
                .points(&result.key, &keys)
                .into_iter()
                .filter(|(places, _)| member.is_none_or(|member| places[1] == member))
                .map(|(places, value)| (places[0], value.unwrap_or(f64::NAN)))
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            missing += points.iter().filter(|point| point.1.is_nan()).count();
            let name = match (family, member) {
                (Some(family), Some(member)) => family.shown(member),
                _ => label.clone(),
            };
            plot = plot.with(Series::new(name, Style::LineMarkers, points));
        }
        for (end, words) in [(result.limits.low, "least allowed"), (result.limits.high, "largest allowed")] {
            if let Some(end) = end {
                plot.limit_at(end, format!("{words}, {} {}", compact(end, 4), named(&result.key).1));
            }
        }
        plot.note = match family {
            Some(family) => {
                format!("{label} of every sample, one line for each value of `{}`.", family.factor.path)
            }
            None => format!("{label} of every sample."),
        };
        if missing > 0 {
            plot.note.push_str(&format!(
                " Gaps: {missing} samples have no value; the reasons are in `samples.csv`."
            ));
        }
        (!plot.series.is_empty()).then_some(plot)
    }

    fn map(&self, result: &JudgedResult, x: &Key<'_>, y: &Key<'_>) -> Option<HeatMap> {
        let (label, unit) = named(&result.key);
        let cells = self.cells(&result.key, x, y, |value| value);
        let limit = match (result.limits.low, result.limits.high) {
            (Some(low), Some(high)) => {
                format!("{} to {} {unit} are allowed. ", compact(low, 4), compact(high, 4))
            }
            (Some(low), None) => format!("At least {} {unit} is allowed. ", compact(low, 4)),
            (None, Some(high)) => format!("At most {} {unit} is allowed. ", compact(high, 4)),
            (None, None) => String::new(),
        };
        let missing = cells.iter().filter(|cell| cell.is_none()).count();
        let gaps = if missing > 0 { format!("{missing} samples have no value.") } else { String::new() };
        (missing < cells.len()).then(|| HeatMap {
            title: format!("{label} over {} and {}", x.factor.path, y.factor.path),
            x: x.axis(),
            y: y.axis(),
            value: axis(&result.key),
            x_values: x.values.clone(),
            y_values: y.values.clone(),
            cells,
            note: format!("{label} of every sample as colour. {limit}{gaps}").trim_end().to_owned(),
            width: Width::Full,
        })
    }

    /// Number of limits that each point does not keep, if any.
    fn kept_map(&self, x: &Key<'_>, y: &Key<'_>) -> Option<HeatMap> {
        let limits = &self.judged.limits;
        if limits.together.is_none_or(|together| together.kept == together.of) {
            return None;
        }
        let mut cells = vec![Some(0.0); x.values.len() * y.values.len()];
        for (limit, _) in &limits.each {
            let of_one = self.cells(&limit.result, x, y, |value| {
                let low = limit.limits.low.is_none_or(|low| value >= low);
                f64::from(u8::from(!(low && limit.limits.high.is_none_or(|high| value <= high))))
            });
            for (cell, broken) in cells.iter_mut().zip(of_one) {
                *cell = cell.zip(broken).map(|(sum, broken)| sum + broken);
            }
        }
        let names: Vec<&str> = limits.each.iter().map(|(limit, _)| limit.name.as_str()).collect();
        Some(HeatMap {
            title: "Limits that are not kept".into(),
            x: x.axis(),
            y: y.axis(),
            value: Axis::new("Limits that are not kept", "").counted(),
            x_values: x.values.clone(),
            y_values: y.values.clone(),
            cells,
            note: format!(
                "Number of limits that a sample exceeds, of: {}. An empty cell has no value.",
                names.join(", ")
            ),
            width: Width::Full,
        })
    }

    fn cells(&self, result: &str, x: &Key<'_>, y: &Key<'_>, of: impl Fn(f64) -> f64) -> Vec<Option<f64>> {
        let mut cells = vec![None; x.values.len() * y.values.len()];
        let known = |key: &Key<'_>, place: f64| key.values.iter().position(|value| *value == place);
        for (places, value) in self.points(result, &[x, y]) {
            if let (Some(ix), Some(iy), Some(value)) = (known(x, places[0]), known(y, places[1]), value) {
                cells[iy * x.values.len() + ix] = Some(of(value));
            }
        }
        cells
    }
}
