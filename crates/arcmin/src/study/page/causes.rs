//! Inputs with the largest influence on a result, as ranked bars.

use super::{RANKED, StudyReport, effect, interval_in_percent, named, percent};
use crate::report::{Block, Column, Shares, Table, significant};
use crate::study::judge::{JudgedResult, Sensitivity, TIGHTEN_SHARE};
use crate::study::sampling::Layout;
use crate::study::sensitivity::tighten::{Gain, Gains};
use crate::study::{Distribution, Factor};

impl StudyReport<'_> {
    pub(super) fn ranking(&self, result: &JudgedResult) -> Vec<Block> {
        let (label, unit) = named(&result.key);
        let factors = self.plan.factors();
        let shares = |title: String, unit: &str, mut rows: Vec<(String, f64, String)>, note: String| {
            rows.retain(|(_, value, _)| value.is_finite());
            rows.sort_by(|a, b| b.1.total_cmp(&a.1));
            rows.truncate(RANKED);
            rows.iter_mut().for_each(|row| row.1 = row.1.max(0.0));
            vec![Block::Shares(Shares { title, unit: unit.into(), rows, note })]
        };
        let path = |factor: &Factor| {
            if factor.path == "seed" { "drawn machine".to_owned() } else { factor.path.clone() }
        };
        match &result.sensitivity {
            Sensitivity::Morris(effects) => {
                let rows = factors.iter().zip(effects).map(|(factor, e)| {
                    let sigma = significant(e.sigma, 3);
                    let remark = format!("{}; σ {sigma} {unit}", effect(&e.mu_star.interval, 3, unit));
                    (path(factor), e.mu_star.value, remark)
                });
                let note = "μ*: mean change of the result over the whole range of a key (Morris); σ large against \
                            μ*: the change depends on the other keys or is curved.";
                shares(format!("{label}: elementary effects"), unit, rows.collect(), note.into())
            }
            Sensitivity::Sobol(indices) => {
                let rows = factors.iter().zip(indices.first.iter().zip(&indices.total)).map(
                    |(factor, (first, total))| {
                        let remark = format!(
                            "{}; alone {}",
                            interval_in_percent(&total.interval),
                            percent(first.value)
                        );
                        (path(factor), 100.0 * total.value, remark)
                    },
                );
                let note = format!(
                    "Total Sobol indices: share of the variance that remains if all other keys are known; \
                     “alone” is what knowing this key would take from it. {} base points.",
                    indices.used
                );
                shares(format!("{label}: shares of the variance"), "%", rows.collect(), note)
            }
            Sensitivity::Tighten(gains) => self.tighten_first(&label, unit, gains),
            Sensitivity::Linear(fit) => {
                let rows = factors.iter().zip(fit.shares.iter().zip(&fit.coefficients)).filter_map(
                    |(factor, (share, c))| {
                        let unordered =
                            matches!(factor.distribution, Distribution::Drawn | Distribution::List { .. });
                        let remark = format!(
                            "{}; {}",
                            interval_in_percent(&share.interval),
                            if *c > 0.0 { "rising" } else { "falling" }
                        );
                        (!unordered).then(|| (path(factor), 100.0 * share.value, remark))
                    },
                );
                let note = format!(
                    "Shares of the variance by a plane fitted to {} samples, which explains {} of it; the rest \
                     is drawn, curved, or acts together.",
                    fit.rows,
                    percent(fit.r_squared)
                );
                shares(format!("{label}: shares of the variance"), "%", rows.collect(), note)
            }
            Sensitivity::None(_) => Vec::new(),
        }
    }

    /// The tolerance to tighten first, of those whose gain differs from zero with confidence; `None` for other
    /// studies.
    pub(super) fn tighten_answer(&self) -> Option<String> {
        let answer = |result: &JudgedResult| {
            let Sensitivity::Tighten(gains) = &result.sensitivity else { return None };
            let (label, unit) = named(&result.key);
            let is_significant =
                |gain: &&Gain| gain.quantile.value > 0.0 && !gain.quantile.interval.contains(0.0);
            let of_width = |gain: &Gain| {
                let factor = self.plan.factors().get(gain.dimension)?;
                factor.distribution.half_width().map(|_| factor.path.clone())
            };
            Some(
                match gains.gains.iter().filter(is_significant).find_map(|gain| Some((gain, of_width(gain)?)))
                {
                    Some((gain, path)) => format!(
                        "{label}: {path} first, which gains {} {unit} ({})",
                        significant(gain.quantile.value, 3),
                        effect(&gain.quantile.interval, 3, unit)
                    ),
                    None => format!(
                        "{label}: no gain differs from zero with {} machines; use more samples",
                        gains.used
                    ),
                },
            )
        };
        let answers: Vec<String> = self.judged.results.iter().filter_map(answer).collect();
        (!answers.is_empty()).then(|| format!("To tighten: {}.", answers.join("; ")))
    }

    /// Gain by tightening, per unit of the key or of cost.
    fn tighten_first(&self, label: &str, unit: &str, gains: &Gains) -> Vec<Block> {
        let share = match self.plan.sampling().layout() {
            Layout::Tighten { share } => *share,
            _ => return Vec::new(),
        };
        let row = |gain: &Gain| {
            let factor = self.plan.factors().get(gain.dimension)?;
            let width = factor.distribution.half_width()?;
            let less = share * width;
            let mut row = vec![
                factor.path.clone(),
                format!("{} → {} {}", significant(width, 3), significant(width - less, 3), factor.unit),
                significant(gain.quantile.value, 3),
                effect(&gain.quantile.interval, 3, ""),
                significant(gain.quantile.value / less, 3),
            ];
            row.push(
                factor.cost.map_or("–".into(), |cost| significant(gain.quantile.value / (less * cost), 3)),
            );
            Some(row)
        };
        let rows: Vec<Vec<String>> = gains.gains.iter().filter_map(row).collect();
        let bars = gains.gains.iter().filter_map(|gain| {
            let factor = self.plan.factors().get(gain.dimension)?;
            factor.distribution.half_width()?;
            Some((
                factor.path.clone(),
                gain.quantile.value.max(0.0),
                effect(&gain.quantile.interval, 3, unit),
            ))
        });
        let bars = Shares {
            title: format!("{label}: tighten first"),
            unit: unit.into(),
            rows: bars.take(RANKED).collect(),
            note: format!(
                "Reduction of the {} quantile of the machines when one tolerance is reduced by {}, \
                 on the same {} machines.",
                percent(TIGHTEN_SHARE),
                percent(share),
                gains.used
            ),
        };
        let table = Table {
            title: format!("{label}: tighten first"),
            columns: vec![
                Column::text("Key"),
                Column::text("Tightened"),
                Column::number("Gain", unit),
                Column::number("Interval", unit),
                Column::number("Gain per unit of the key", unit),
                Column::number("Gain per cost", unit),
            ],
            rows,
            note: String::new(),
        };
        vec![Block::Shares(bars), Block::Table(table)]
    }
}
