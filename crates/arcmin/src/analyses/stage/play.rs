//! Play of a new drive at its output by part: entries of summaries, sentence and table.

use super::EccentricDrive;
use super::keys::{ECCENTRIC, OUTPUT, OfParts, PartKeys, RING, StageKeys};
use crate::report::{Block, Column as Head, Table};
use crate::results::{Column, Value, decimals, quantity};
use crate::units::ARCMIN;

/// Two-sided play at the output by part in rad, input held.
#[derive(Debug, Clone)]
pub struct Play {
    stages: &'static [StageKeys],
    parts: Vec<OfParts>,
}

/// Order in which the parts of a stage are listed.
const IN_ORDER: [usize; 3] = [RING, ECCENTRIC, OUTPUT];

impl Play {
    pub(in crate::analyses) fn of<D: EccentricDrive>(design: &D) -> Play {
        Play { stages: D::STAGES, parts: design.play() }
    }

    /// Sum over parts and stages, rad.
    pub fn total(&self) -> f64 {
        self.parts.iter().flatten().sum()
    }

    /// Play of a part by its number, rad.
    fn part(&self, number: usize) -> f64 {
        self.parts[number / 3][number % 3]
    }
}

/// Parts with their numbers, in the order of the list of plays.
fn parts_in_order(stages: &'static [StageKeys]) -> impl Iterator<Item = (usize, &'static PartKeys)> {
    (0..stages.len()).flat_map(move |k| {
        IN_ORDER.iter().filter_map(move |part| Some((3 * k + part, stages[k].parts[*part].as_ref()?)))
    })
}

/// Results that have a play by part.
pub(in crate::analyses) trait HasPlay {
    fn play(&self) -> Option<&Play>;
}

/// The entries of a summary for the play by part.
pub(in crate::analyses) fn play_entries<O: HasPlay, D: EccentricDrive>() -> Vec<Column<O>> {
    let part = |o: &O, number: usize| Value::from(o.play().map(|play| play.part(number) / ARCMIN));
    let total = quantity(
        "play_chain.total_arcmin",
        decimals(3),
        "Sum of the plays by part of the new drive, a lower bound of its play.",
    );
    parts_in_order(D::STAGES)
        .map(|(number, keys)| Column::numbered(keys.play, number, part))
        .chain([total.of(|o: &O| Value::from(o.play().map(|play| play.total() / ARCMIN)))])
        .collect()
}

pub(in crate::analyses) fn play_sentence(play: &Play) -> String {
    let arcmin = |angle: f64| format!("{:.2}′", angle / ARCMIN);
    let parts: Vec<String> = parts_in_order(play.stages)
        .map(|(number, keys)| format!("{} {}", keys.short, arcmin(play.part(number))))
        .collect();
    format!(
        "play of the new drive at the output, input held: {} = {}",
        arcmin(play.total()),
        parts.join(" + ")
    )
}

pub(in crate::analyses) fn play_table(play: &Play) -> Block {
    let row = |name: &str, value: f64| {
        let share = if play.total() > 0.0 { 100.0 * value / play.total() } else { 0.0 };
        vec![name.to_owned(), format!("{:.3}", value / ARCMIN), format!("{share:.0}")]
    };
    let parts = parts_in_order(play.stages).map(|(number, keys)| row(keys.gap, play.part(number)));
    Block::Table(Table {
        title: "Play of the new drive at the output by part".to_owned(),
        columns: vec![Head::text("Part"), Head::number("Two-sided play", "arcmin"), Head::number("Share", "%")],
        rows: parts.chain([row("together", play.total())]).collect(),
        note: "Input held, nominal dimensions. The sum is a lower bound: with all gaps open a disc also shifts along its \
               eccentric, and output pins give up to 1/cos(π/z_w) more by position."
            .to_owned(),
    })
}
