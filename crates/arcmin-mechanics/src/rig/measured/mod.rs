//! Curves of real benches, evaluated like computed ones, with the uncertainty caused by noise and by the
//! procedure of the test.
//!
//! A measured loop contains a first loading, several cycles, steps at constant torque, noise of torque or
//! angle, and drift, and its signs may differ from ours; a measured transmission error has repeated or noisy
//! angles, may lack its last position and may contain several turns. A [`Remark`] reports each correction.

mod branch;
mod loops;
mod series;
#[cfg(test)]
mod tests;
mod turns;

pub use loops::{LoopRow, MeasuredLoop, read_loops};
pub use turns::{MeasuredCurve, TurnRow, TurnSpectrum, read_turns};

use std::ops::Range;

use super::NamedOrder;
use crate::dynamics::SpectrumLine;

/// Measurements of a real bench, evaluated like computed ones.
#[derive(Debug, Clone, Default)]
pub struct MeasuredOnBench {
    /// Hysteresis loops in the order of their file.
    pub loops: Vec<MeasuredLoop>,
    /// Transmission errors in the order of their file.
    pub curves: Vec<MeasuredCurve>,
    /// Spectrum of the first curve that covers a turn; empty if none does.
    pub spectrum: Vec<SpectrumLine>,
    /// Its strongest orders, each with the half width of its 95 % interval in rad.
    pub orders: Vec<(NamedOrder, f64)>,
    /// Corrections made to the rows before evaluation, in sentences.
    pub remarks: Vec<String>,
}

impl MeasuredOnBench {
    /// Mean of a value over the loops, and the half width of its 95 % interval; `None` without loops.
    ///
    /// Cycles at one position are repetitions: their scatter is uncertainty. Differences between positions are
    /// real.
    pub fn figure(&self, of: fn(&super::LoopFigures) -> f64) -> Option<(f64, f64)> {
        let mut positions: Vec<(usize, Vec<&MeasuredLoop>)> = Vec::new();
        for one in &self.loops {
            match positions.iter_mut().find(|(position, _)| *position == one.position) {
                Some((_, cycles)) => cycles.push(one),
                None => positions.push((one.position, vec![one])),
            }
        }
        let count = positions.len() as f64;
        let (mut sum, mut width) = (0.0, 0.0);
        for (_, cycles) in &positions {
            let n = cycles.len() as f64;
            let mean = cycles.iter().map(|one| of(&one.figures)).sum::<f64>() / n;
            // The uncertainty by curvature and distance of the rows is common to all cycles and does not
            // average out.
            let own = cycles.iter().map(|one| of(&one.uncertainty)).sum::<f64>() / n;
            let spread = cycles.iter().map(|one| (of(&one.figures) - mean).powi(2)).sum::<f64>();
            let between = if n > 1.0 { 2.0 * (spread / (n - 1.0) / n).sqrt() } else { 0.0 };
            sum += mean;
            width += own.max(between);
        }
        (count > 0.0).then(|| (sum / count, (width / count).max(FINEST * (sum / count).abs())))
    }
}

/// Smallest relative uncertainty of a value, however small its noise.
const FINEST: f64 = 1e-4;

/// A correction made to the rows of a file before evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct Remark {
    /// Rows concerned, counted from 0; `None` if all.
    pub rows: Option<Range<usize>>,
    /// A sentence.
    pub text: String,
}

impl Remark {
    fn of_all(text: impl Into<String>) -> Remark {
        Remark { rows: None, text: text.into() }
    }

    fn of_rows(rows: Range<usize>, text: impl Into<String>) -> Remark {
        Remark { rows: Some(rows), text: text.into() }
    }
}

/// Reason why rows are not a loop or a transmission error.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{what}")]
pub struct Unusable {
    /// Row concerned, counted from 0.
    pub row: usize,
    /// Fault in one sentence.
    pub what: String,
    /// Advice in one sentence.
    pub remedy: String,
}

impl Unusable {
    fn at(row: usize, what: impl Into<String>, remedy: impl Into<String>) -> Unusable {
        Unusable { row, what: what.into(), remedy: remedy.into() }
    }
}
