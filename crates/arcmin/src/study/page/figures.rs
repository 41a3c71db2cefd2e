//! How results are spread: histograms, empirical distributions, bands over life, probability paper, fronts.

use super::{StudyReport, axis, named, percent};
use crate::report::{Annotation, Axis, Block, Plot, Series, Style, Tone, significant};
use crate::study::Kind;
use crate::study::judge::{JudgedResult, is_life};
use crate::study::part::Cell;
use crate::study::statistics::{Life, Limits, PaperScale, ecdf, probability_paper, quantile};

impl StudyReport<'_> {
    pub(super) fn distribution(&self, result: &JudgedResult) -> Vec<Block> {
        let sorted = self.sorted(&result.key);
        if sorted.len() < 5 || sorted[0] == sorted[sorted.len() - 1] {
            return Vec::new();
        }
        let label = named(&result.key).0;
        let annotate = |plot: &mut Plot| {
            for (at, name) in [(result.limits.low, "least allowed"), (result.limits.high, "largest allowed")]
            {
                if let Some(at) = at {
                    plot.annotations.push(Annotation::Vertical { at, label: name.into(), tone: Tone::Bad });
                }
            }
        };
        let mut histogram = Plot::new(
            format!("{label}: histogram"),
            axis(&result.key),
            Axis::new("Machines", "").from_zero(),
        )
        .half();
        histogram.series.push(Series::new("machines", Style::Step, bins(&sorted)));
        histogram.note = format!(
            "Number of machines in intervals of equal width, of {} machines with a value.",
            sorted.len()
        );
        annotate(&mut histogram);
        let mut shares = Plot::new(
            format!("{label}: share below"),
            axis(&result.key),
            Axis::new("Share of machines", "%").between(0.0, 100.0),
        )
        .half();
        // Lives that have not ended are longer than any that have.
        let ongoing = if is_life(&result.key) { result.absent } else { 0 };
        let mut all = sorted.clone();
        all.resize(sorted.len() + ongoing, f64::INFINITY);
        let steps = ecdf(&all);
        // A page needs no more steps than it has pixels.
        let every = steps.len().div_ceil(600);
        let thinned =
            steps.iter().step_by(every).chain(steps.last()).map(|(value, share)| (*value, 100.0 * share));
        shares.series.push(Series::new("machines", Style::Step, thinned));
        annotate(&mut shares);
        shares.note = "Share of the machines in % with at most this value.".to_owned();
        if ongoing > 0 {
            shares.note.push_str(&format!(
                " {ongoing} machines reach no limit and count as longer lives than all others."
            ));
        }
        if let Some(kept) = result.kept {
            shares.note.push_str(&format!(
                " {} of {} machines keep the limits: {} ({} to {}).",
                kept.kept,
                kept.of,
                percent(kept.share),
                percent(kept.low),
                percent(kept.high)
            ));
        }
        vec![Block::Plot(histogram), Block::Plot(shares)]
    }

    /// Curves of a table over its hours, as bands.
    pub(super) fn bands(&self) -> Vec<Block> {
        let columns = self.plan.columns();
        let curves = |index: usize| {
            self.rows.records.iter().filter_map(move |record| match &record.cells[index] {
                Cell::Curve(curve) if self.plan.sampling().is_sample(record.number) => Some(curve),
                _ => None,
            })
        };
        let place =
            |name: &str| columns.iter().position(|(column, kind)| *column == name && *kind == Kind::Curve);
        let mut blocks = Vec::new();
        for (index, (name, kind)) in columns.iter().enumerate() {
            let Some((table, column)) = name.rsplit_once('.') else { continue };
            let hours_name = format!("{table}.hours");
            let Some(hours) = place(&hours_name).filter(|_| *kind == Kind::Curve && column != "hours") else {
                continue;
            };
            let Some(hours) = curves(hours).next() else { continue };
            let mut levels: [Vec<(f64, f64)>; 3] = Default::default();
            for (k, hour) in hours.iter().enumerate() {
                let mut values: Vec<f64> = curves(index)
                    .filter(|c| c.len() == hours.len())
                    .map(|c| c[k])
                    .filter(|x| x.is_finite())
                    .collect();
                values.sort_by(f64::total_cmp);
                for (level, share) in levels.iter_mut().zip([0.05, 0.5, 0.95]) {
                    if let Ok(q) = quantile(&values, share, self.judged.confidence) {
                        level.push((*hour, q.estimate));
                    }
                }
            }
            let [low, middle, high] = levels;
            if middle.len() < 2 {
                continue;
            }
            let label = named(name).0;
            let both = low.iter().zip(&high).map(|((hour, low), (_, high))| (*hour, *low, *high));
            let plot = Plot::new(format!("{label} over life"), Axis::new("Running time", "h"), axis(name))
                .with(Series::band("5 % to 95 % of machines", both))
                .with(Series::line("median", middle).strong())
                .noted("Median of the machines and the range from the 5 % to the 95 % quantile at each running time.");
            blocks.push(Block::Plot(plot));
        }
        blocks
    }

    pub(super) fn paper(&self, result: &JudgedResult) -> Option<Block> {
        let sorted = self.sorted(&result.key);
        let weibull = result.weibull.as_ref();
        if sorted.len() < 5 || (weibull.is_none() && result.limits == (Limits { low: None, high: None })) {
            return None;
        }
        let scale = if weibull.is_some() { PaperScale::Weibull } else { PaperScale::Normal };
        let lives: Vec<Life> = match weibull {
            Some(fit) => fit.lives().to_vec(),
            None => sorted.iter().map(|value| Life { hours: *value, ended: true }).collect(),
        };
        let points = probability_paper(&lives, self.judged.confidence).ok()?;
        let every = points.len().div_ceil(400);
        let thinned: Vec<_> = points.iter().step_by(every).collect();
        let (label, unit) = named(&result.key);
        let mut x = Axis::new(label.clone(), unit);
        if scale == PaperScale::Weibull {
            x = x.logarithmic();
        }
        let name = match scale {
            PaperScale::Weibull => "ln(−ln(1 − F))",
            PaperScale::Normal => "Standard normal deviate",
        };
        let mut plot = Plot::new(
            format!("{label} on {} paper", if weibull.is_some() { "Weibull" } else { "normal" }),
            x,
            Axis::new(name, ""),
        )
        .with(Series::band(
            "interval of the ranks",
            thinned.iter().map(|p| (p.value, scale.height(p.low), scale.height(p.high))),
        ))
        .with(Series::markers(
            "machines (median ranks)",
            thinned.iter().map(|p| (p.value, scale.height(p.share))),
        ));
        let line = |share: f64| match (weibull, &result.spread) {
            (Some(fit), _) => Some((fit.life(share), scale.height(share))),
            (None, Some(spread)) => {
                let height = scale.height(share);
                Some((spread.mean + spread.deviation * height, height))
            }
            _ => None,
        };
        let fitted = if weibull.is_some() {
            "fitted (maximum likelihood)"
        } else {
            "mean and deviation of the sample"
        };
        plot = plot.with(Series::line(fitted, [0.01, 0.1, 0.5, 0.9, 0.99].into_iter().filter_map(line)));
        for share in [0.1, 0.5, 0.9] {
            let label = format!("{} %", significant(100.0 * share, 2));
            plot.annotations.push(Annotation::Horizontal {
                at: scale.height(share),
                label,
                tone: Tone::Neutral,
            });
        }
        Some(Block::Plot(plot.noted("Probability plot of the machines with the interval of their ranks. The distribution fits where the points follow the line.")))
    }

    /// The Pareto front of two goals.
    pub(super) fn front(&self) -> Option<Plot> {
        let [(across, small_across), (up, small_up)] = &self.goals[..] else { return None };
        let (xs, ys) = (self.rows.numbers(self.plan, across)?, self.rows.numbers(self.plan, up)?);
        let points: Vec<(f64, f64)> = xs.into_iter().zip(ys).filter_map(|(x, y)| Some((x?, y?))).collect();
        let sign = |small: bool| if small { 1.0 } else { -1.0 };
        let mut sorted = points.clone();
        sorted.sort_by(|a, b| {
            let first = (sign(*small_across) * a.0).total_cmp(&(sign(*small_across) * b.0));
            first.then((sign(*small_up) * a.1).total_cmp(&(sign(*small_up) * b.1)))
        });
        let mut front: Vec<(f64, f64)> = Vec::new();
        for point in sorted {
            if front.last().is_none_or(|last| sign(*small_up) * point.1 < sign(*small_up) * last.1) {
                front.push(point);
            }
        }
        let every = points.len().div_ceil(2000).max(1);
        let plot = Plot::new(format!("{} and {}", named(across).0, named(up).0), axis(across), axis(up));
        Some(
            plot.with(Series::markers("samples", points.into_iter().step_by(every)))
                .with(Series::new("Pareto front", Style::LineMarkers, front).strong())
                .noted("Both objectives of every sample. For a sample on the Pareto front no other one is better in both objectives."),
        )
    }
}

/// Edges and counts of bars of equal width (Freedman & Diaconis 1981), as steps that start and end at zero.
fn bins(sorted: &[f64]) -> Vec<(f64, f64)> {
    let n = sorted.len();
    let (low, high) = (sorted[0], sorted[n - 1]);
    let middle_half = sorted[(3 * (n - 1)) / 4] - sorted[(n - 1) / 4];
    let width = 2.0 * middle_half / (n as f64).cbrt();
    let count = if width > 0.0 { ((high - low) / width).ceil().clamp(5.0, 60.0) as usize } else { 10 };
    let mut counts = vec![0_usize; count];
    for value in sorted {
        let place = (value - low) / (high - low) * count as f64;
        counts[(place as usize).min(count - 1)] += 1;
    }
    let edge = |k: usize| low + (high - low) * k as f64 / count as f64;
    let bars = counts.iter().enumerate().map(|(k, many)| (edge(k), *many as f64));
    std::iter::once((low, 0.0)).chain(bars).chain([(high, 0.0)]).collect()
}
