//! Text of a study for the terminal.

use super::{StudyReport, effect, ends, interval_in_percent, named, percent, shown};
use crate::analyses::{TextBlock, TextTable};
use crate::report::significant;
use crate::study::judge::{JudgedResult, Sensitivity};

/// Largest number of results with a ranking in the terminal, and of keys in each ranking.
const RANKINGS: usize = 3;
const RANKED: usize = 6;

impl StudyReport<'_> {
    /// Headline, results with their intervals, rankings.
    pub fn text_blocks(&self) -> Vec<TextBlock> {
        let verdict = self.verdict();
        let mut blocks = vec![TextBlock::line(verdict.headline)];
        blocks.extend(
            verdict.answers.iter().map(|(question, answer)| TextBlock::line(format!("{question}: {answer}"))),
        );
        blocks.extend(self.limits_block());
        blocks.push(TextBlock::Table(self.overview()));
        for result in self.judged.results.iter().take(RANKINGS) {
            let rows = self.ranked(result);
            if !rows.is_empty() {
                blocks.push(TextBlock::line(format!("\n{} depends most on", named(&result.key).0)));
                blocks.push(TextBlock::Table(TextTable { header: Vec::new(), rows }));
            }
        }
        blocks
    }

    fn overview(&self) -> TextTable {
        let sampled = self.judged.results.iter().any(|result| result.spread.is_some());
        let header = if sampled {
            vec!["", "unit", "5 %", "50 %", "95 % of machines below", "limit kept by"]
        } else {
            vec!["", "unit", "least", "largest"]
        };
        let row = |result: &JudgedResult| {
            let (label, unit) = named(&result.key);
            let mut row = vec![label, unit.to_owned()];
            let Some(spread) = &result.spread else {
                row.extend(result.range.map(|end| significant(end, 4)));
                return row;
            };
            for share in [0.05, 0.5, 0.95] {
                let quantile = spread.quantiles.iter().find(|quantile| quantile.share == share);
                row.push(quantile.map_or(String::new(), |q| {
                    let interval =
                        if share == 0.95 { format!(" ({})", ends(&q.interval, 4)) } else { String::new() };
                    format!("{}{interval}", shown(q.estimate, 4))
                }));
            }
            row.push(result.kept.map_or(String::new(), |kept| {
                format!("{} ({} … {})", percent(kept.share), percent(kept.low), percent(kept.high))
            }));
            row
        };
        TextTable {
            header: header.into_iter().map(str::to_owned).collect(),
            rows: self.judged.results.iter().map(row).collect(),
        }
    }

    fn ranked(&self, result: &JudgedResult) -> Vec<Vec<String>> {
        let factors = self.plan.factors();
        let unit = named(&result.key).1;
        let mut rows: Vec<(f64, Vec<String>)> = match &result.sensitivity {
            Sensitivity::Morris(effects) => factors
                .iter()
                .zip(effects)
                .map(|(factor, e)| {
                    let text = format!(
                        "μ* {} {unit} ({})",
                        significant(e.mu_star.value, 3),
                        effect(&e.mu_star.interval, 3, unit)
                    );
                    (
                        e.mu_star.value,
                        vec![factor.path.clone(), text, format!("σ {} {unit}", significant(e.sigma, 3))],
                    )
                })
                .collect(),
            Sensitivity::Sobol(indices) => factors
                .iter()
                .zip(indices.first.iter().zip(&indices.total))
                .map(|(factor, (first, total))| {
                    let text =
                        format!("total {} ({})", percent(total.value), interval_in_percent(&total.interval));
                    (total.value, vec![factor.path.clone(), text, format!("alone {}", percent(first.value))])
                })
                .collect(),
            Sensitivity::Tighten(gains) => gains
                .gains
                .iter()
                .filter_map(|gain| {
                    let factor = factors.get(gain.dimension)?;
                    factor.distribution.half_width()?;
                    let gained = &gain.quantile;
                    let text = format!(
                        "gains {} {unit} ({})",
                        significant(gained.value, 3),
                        effect(&gained.interval, 3, unit)
                    );
                    Some((gained.value, vec![factor.path.clone(), text]))
                })
                .collect(),
            Sensitivity::Linear(fit) => factors
                .iter()
                .zip(&fit.shares)
                .filter(|(_, share)| share.value > 0.0)
                .map(|(factor, share)| {
                    let text = format!("{} ({})", percent(share.value), interval_in_percent(&share.interval));
                    (share.value, vec![factor.path.clone(), text])
                })
                .collect(),
            Sensitivity::None(_) => Vec::new(),
        };
        rows.sort_by(|a, b| b.0.total_cmp(&a.0));
        rows.into_iter().take(RANKED).map(|(_, row)| row).collect()
    }
}
