//! Reduction of readings to a few rows.

use crate::units::RPM;

/// A reading: output torque in N·m, output speed in rad/s, and the time in s that it represents.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    pub torque: f64,
    pub speed: f64,
    pub time: f64,
}

/// A row of `[[duty]]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DutyRow {
    /// Output torque in N·m, positive against positive output motion.
    pub torque: f64,
    /// Input speed in rad/s.
    pub input_speed: f64,
    /// Share of the time in motion.
    pub share: f64,
}

/// Relative deviations of the rows from all readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reduction {
    /// Number of readings in motion.
    pub samples: usize,
    /// Relative error of Σ |T|^m |ω| t.
    pub wear_error: f64,
    /// Relative error of the equivalent load (Σ |T|^(10/3) |ω| t / Σ |ω| t)^(3/10).
    pub bearing_load_error: f64,
    /// Relative error of 1/Σ |T|^(10/3) |ω| t, to which the life of bearings is proportional.
    pub life_error: f64,
    /// Equivalent bearing torque of the log in N·m.
    pub equivalent_torque: f64,
    /// Mean |output speed| in motion in rad/s.
    pub mean_speed: f64,
}

/// Exponent of life of roller bearings.
const LIFE: f64 = 10.0 / 3.0;

/// Number of torque cells per group from which rows are formed.
const CELLS: usize = 256;

/// Sums of the readings in a cell, weighted by rotation except for the time.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    time: f64,
    turns: f64,
    /// Σ |T|^m |ω| t and Σ |T|^(10/3) |ω| t.
    wear: f64,
    life: f64,
}

impl Cell {
    fn plus(&self, other: &Cell) -> Cell {
        Cell {
            time: self.time + other.time,
            turns: self.turns + other.turns,
            wear: self.wear + other.wear,
            life: self.life + other.life,
        }
    }

    /// The torque that represents the cell: between the means of both laws, so that the errors of both are
    /// similar.
    fn torque(&self, wear_exponent: f64) -> f64 {
        if !(self.turns > 0.0) {
            return 0.0;
        }
        let mean = (self.wear / self.turns).powf(1.0 / wear_exponent);
        let life = (self.life / self.turns).powf(1.0 / LIFE);
        0.5 * (mean + life)
    }

    /// Errors of the cell in both sums, relative to the total sums.
    fn loss(&self, wear_exponent: f64, all: &Cell) -> f64 {
        let torque = self.torque(wear_exponent);
        let wear = (self.turns * torque.powf(wear_exponent) - self.wear).abs();
        let life = (self.turns * torque.powf(LIFE) - self.life).abs();
        wear / all.wear.max(f64::MIN_POSITIVE) + life / all.life.max(f64::MIN_POSITIVE)
    }
}

/// A group of readings: one sign of torque and of speed, one class of speed.
struct Group {
    signs: (f64, f64),
    cells: Vec<Cell>,
    /// `best[k][i]`: smallest error of the first i cells in k + 1 rows, and the beginning of the last row.
    best: Vec<Vec<(f64, usize)>>,
}

impl Group {
    /// Smallest error with one more row, by dynamic programming over the beginning of the last row.
    fn add_row(&mut self, sums: &[Cell], wear_exponent: f64, all: &Cell) {
        let count = self.cells.len();
        let part = |from: usize, to: usize| {
            let (a, b) = (&sums[from], &sums[to]);
            Cell {
                time: b.time - a.time,
                turns: b.turns - a.turns,
                wear: b.wear - a.wear,
                life: b.life - a.life,
            }
            .loss(wear_exponent, all)
        };
        let row: Vec<(f64, usize)> = (0..=count)
            .map(|to| match self.best.last() {
                None => (if to == 0 { 0.0 } else { part(0, to) }, 0),
                Some(before) => {
                    let options = (0..=to)
                        .map(|from| (before[from].0 + if from == to { 0.0 } else { part(from, to) }, from));
                    options.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 0))
                }
            })
            .collect();
        self.best.push(row);
    }

    fn loss(&self, rows: usize) -> f64 {
        self.best.get(rows - 1).and_then(|best| best.last()).map_or(0.0, |best| best.0)
    }

    /// Bounds of the rows, as ranges of cells.
    fn ranges(&self, rows: usize) -> Vec<std::ops::Range<usize>> {
        let mut end = self.cells.len();
        let mut ranges = Vec::new();
        for k in (0..rows).rev() {
            let from = self.best[k][end].1;
            ranges.push(from..end);
            end = from;
        }
        ranges.into_iter().rev().filter(|range| !range.is_empty()).collect()
    }
}

fn running(cells: &[Cell]) -> Vec<Cell> {
    let mut sums = vec![Cell::default()];
    for cell in cells {
        sums.push(sums[sums.len() - 1].plus(cell));
    }
    sums
}

/// Rows with the exact number of turns and the smallest errors of wear and bearing life for at most `rows`
/// rows.
///
/// Readings are divided into groups by the signs of torque and speed and by the speed (below and above the
/// median over the rotation of the output). In each group a histogram over |T| is divided into rows with the
/// smallest sum of both errors; rows are added one by one to the group with the largest improvement, until all
/// are used or the error is a tenth of a permille.
pub(super) fn reduce(
    samples: &[Sample],
    rows: usize,
    wear_exponent: f64,
    ratio: f64,
) -> (Vec<DutyRow>, Reduction) {
    let peak = samples.iter().map(|s| s.torque.abs()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let cell_of = |s: &Sample| {
        let turns = s.speed.abs() * s.time;
        let torque = s.torque.abs();
        Cell {
            time: s.time,
            turns,
            wear: torque.powf(wear_exponent) * turns,
            life: torque.powf(LIFE) * turns,
        }
    };
    let median = median_speed(samples);
    let mut groups: Vec<Group> = Vec::new();
    for signs in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        for fast in [false, true] {
            let mut cells = vec![Cell::default(); CELLS];
            let sign = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
            for s in samples
                .iter()
                .filter(|s| (sign(s.torque), sign(s.speed)) == signs && (s.speed.abs() > median) == fast)
            {
                let index = ((s.torque.abs() / peak * CELLS as f64) as usize).min(CELLS - 1);
                cells[index] = cells[index].plus(&cell_of(s));
            }
            cells.retain(|cell| cell.time > 0.0);
            if !cells.is_empty() {
                groups.push(Group { signs, cells, best: Vec::new() });
            }
        }
    }
    let all = samples.iter().map(cell_of).fold(Cell::default(), |sum, cell| sum.plus(&cell));
    let sums: Vec<Vec<Cell>> = groups.iter().map(|group| running(&group.cells)).collect();
    for (group, sums) in groups.iter_mut().zip(&sums) {
        group.add_row(sums, wear_exponent, &all);
        group.add_row(sums, wear_exponent, &all);
    }
    let mut counts = vec![1_usize; groups.len()];
    while counts.iter().sum::<usize>() < rows {
        let left: f64 = groups.iter().zip(&counts).map(|(group, count)| group.loss(*count)).sum();
        let gain = |i: usize| groups[i].loss(counts[i]) - groups[i].loss(counts[i] + 1);
        let Some(best) = (0..groups.len()).max_by(|a, b| gain(*a).total_cmp(&gain(*b))) else { break };
        if left < 1e-4 || !(gain(best) > 0.0) {
            break;
        }
        counts[best] += 1;
        groups[best].add_row(&sums[best], wear_exponent, &all);
    }
    let mut duty = Vec::new();
    for (group, count) in groups.iter().zip(&counts) {
        for range in group.ranges(*count) {
            let cell = group.cells[range].iter().fold(Cell::default(), |sum, cell| sum.plus(cell));
            // In the precision in which they are written.
            let digits = |x: f64| (x * 1e6).round() / 1e6;
            duty.push(DutyRow {
                torque: digits(group.signs.0 * cell.torque(wear_exponent)),
                input_speed: digits(group.signs.1 * cell.turns / cell.time * ratio / RPM) * RPM,
                share: (cell.time / all.time * 1e12).round() / 1e12,
            });
        }
    }
    // Rows below the smallest share allowed in a design, and remainders of rounding.
    duty.retain(|row| row.share >= 1e-8);
    let rest = 1.0 - duty.iter().map(|row| row.share).sum::<f64>();
    if let Some(longest) = duty.iter_mut().max_by(|a, b| a.share.total_cmp(&b.share)) {
        longest.share += rest;
    }
    let reduction = measure(&duty, &all, samples.len(), wear_exponent, ratio);
    (duty, reduction)
}

/// Wear and life of the rows as written, compared with the sums of the readings.
fn measure(rows: &[DutyRow], all: &Cell, samples: usize, wear_exponent: f64, ratio: f64) -> Reduction {
    let sum = |power: f64| -> f64 {
        rows.iter()
            .map(|row| row.torque.abs().powf(power) * (row.input_speed / ratio).abs() * row.share * all.time)
            .sum()
    };
    let (wear, life, turns) = (sum(wear_exponent), sum(LIFE), sum(0.0));
    let load = |life: f64, turns: f64| (life / turns).powf(1.0 / LIFE);
    Reduction {
        samples,
        wear_error: wear / all.wear - 1.0,
        bearing_load_error: load(life, turns) / load(all.life, all.turns) - 1.0,
        life_error: all.life / life - 1.0,
        equivalent_torque: load(all.life, all.turns),
        mean_speed: all.turns / all.time,
    }
}

/// The median of the speed over the rotation of the output.
fn median_speed(samples: &[Sample]) -> f64 {
    let fastest = samples.iter().map(|s| s.speed.abs()).fold(0.0, f64::max);
    let mut turns = [0.0; 256];
    for s in samples {
        turns[((s.speed.abs() / fastest * 256.0) as usize).min(255)] += s.speed.abs() * s.time;
    }
    let half = 0.5 * turns.iter().sum::<f64>();
    let mut sum = 0.0;
    for (index, part) in turns.iter().enumerate() {
        sum += part;
        if sum >= half {
            return fastest * (index + 1) as f64 / 256.0;
        }
    }
    fastest
}
