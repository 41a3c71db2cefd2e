//! Sample points in the unit cube; each follows from (seed, number) only.

mod trajectories;

use sobol_burley::parts::{hash as burley_hash, owen_scramble_rev, sobol_rev};

use super::distribution::{Distribution, Value};
use super::stream::{Purpose, Stream};
use super::{StudyError, stream};

/// Points of the Sobol sequence, and dimensions, for which direction numbers exist (Joe & Kuo 2008 as kept by
/// `sobol_burley`).
const SOBOL_POINTS: u64 = 1 << 16;
const SOBOL_DIMENSIONS: usize = 256;
/// Strata are stored as a table of 32-bit numbers, at most 400 MB.
const STRATA: u64 = 100_000_000;

/// How points are chosen.
#[derive(Debug, Clone, PartialEq)]
pub enum Layout {
    /// Every combination of `levels[d]` levels of each dimension, the last one running fastest.
    Grid {
        /// Levels of each dimension.
        levels: Vec<usize>,
    },
    /// Entry k of every list together: no combinations.
    Cases {
        /// Entries of every list.
        count: usize,
    },
    /// Given points of the unit cube, for instance of a search.
    Points(std::sync::Arc<Vec<Vec<f64>>>),
    /// Independent of each other.
    Random,
    /// One in each of n equal strata of every dimension (McKay, Beckman & Conover 1979).
    LatinHypercube,
    /// Owen-scrambled Sobol sequence (Burley 2020): even in all projections; best with a power of two.
    Sobol,
    /// `samples` trajectories in a grid of `levels` (even), one step in each dimension (Morris 1991).
    Morris {
        /// Levels of the grid, an even number.
        levels: usize,
    },
    /// `samples` base points A, each with every column taken from B in turn, and B (Saltelli 2010): the
    /// layout of SALib, with `second_order` also B with columns of A.
    Saltelli {
        /// Whether shares of pairs can be computed.
        second_order: bool,
    },
    /// `samples` random machines, each as drawn and again for every dimension with that one alone tightened by
    /// `share`: the effect of tightening on the same machines.
    Tighten {
        /// Share by which the spread is reduced, between 0 and 1.
        share: f64,
    },
}

/// One row of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Place in the unit cube.
    pub unit: Vec<f64>,
    /// The dimension whose spread is reduced in this row, and by which share.
    pub tightened: Option<(usize, f64)>,
}

/// The rows of a study as points: how many there are, and each one by its number.
#[derive(Debug, Clone)]
pub struct Sampling {
    layout: Layout,
    factors: Vec<Distribution>,
    samples: u64,
    seed: u64,
    /// For a Latin hypercube: the stratum of each sample in each dimension.
    strata: Vec<Vec<u32>>,
}

impl Sampling {
    /// # Errors
    /// [`StudyError::Distribution`] of a factor, [`StudyError::Sampling`] if the layout cannot hold so many
    /// samples or dimensions, or there is nothing to vary.
    pub fn new(
        layout: Layout,
        factors: Vec<Distribution>,
        samples: u64,
        seed: u64,
    ) -> Result<Sampling, StudyError> {
        let no = |reason: String| Err(StudyError::Sampling { reason });
        factors.iter().try_for_each(Distribution::validate)?;
        let dimensions = factors.len();
        if dimensions == 0 {
            return no("nothing varies".into());
        }
        let counts_itself = matches!(layout, Layout::Grid { .. } | Layout::Cases { .. } | Layout::Points(_));
        if samples == 0 && !counts_itself {
            return no("the number of samples is 0".into());
        }
        let sobol_dimensions = match &layout {
            Layout::Sobol => dimensions,
            Layout::Saltelli { .. } => 2 * dimensions,
            _ => 0,
        };
        match &layout {
            Layout::Grid { levels } if levels.len() != dimensions || levels.contains(&0) => {
                return no(format!(
                    "a grid of {dimensions} dimensions needs as many numbers of levels, 1 or more"
                ));
            }
            Layout::Grid { levels }
                if levels.iter().try_fold(1_u64, |all, n| all.checked_mul(*n as u64)).is_none() =>
            {
                return no("the grid has too many points".into());
            }
            Layout::Cases { count }
                if factors
                    .iter()
                    .any(|factor| !matches!(factor, Distribution::List { count: n } if n == count)) =>
            {
                return no("cases need lists of the same length".into());
            }
            Layout::Points(points) if points.iter().any(|point| point.len() != dimensions) => {
                return no(format!("a point does not have {dimensions} coordinates"));
            }
            Layout::Morris { levels } if *levels < 2 || levels % 2 == 1 => {
                return no(format!("trajectories need an even number of levels, 2 or more, not {levels}"));
            }
            Layout::Tighten { share } if !(*share > 0.0 && *share <= 1.0) => {
                return no(format!("the share to tighten by must lie in 0 … 1, not {share}"));
            }
            Layout::LatinHypercube if samples.saturating_mul(dimensions as u64) > STRATA => {
                return no(format!(
                    "a Latin hypercube of {samples} samples in {dimensions} dimensions is too \
                     large; take `random`"
                ));
            }
            _ => {}
        }
        if sobol_dimensions > SOBOL_DIMENSIONS || (sobol_dimensions > 0 && samples > SOBOL_POINTS) {
            return no(format!(
                "the Sobol sequence has {SOBOL_POINTS} points in {SOBOL_DIMENSIONS} dimensions, \
                 not {samples} in {sobol_dimensions}; take `random` or `latin-hypercube`"
            ));
        }
        let strata = match layout {
            Layout::LatinHypercube => (0..dimensions)
                .map(|dimension| {
                    let mut strata: Vec<u32> = (0..samples as u32).collect();
                    Stream::new(seed, Purpose::Strata, dimension as u64).shuffle(&mut strata);
                    strata
                })
                .collect(),
            _ => Vec::new(),
        };
        let sampling = Sampling { layout, factors, samples, seed, strata };
        if sampling.samples.checked_mul(sampling.rows_per_sample()).is_none() {
            return no(format!("{samples} samples give too many rows"));
        }
        Ok(sampling)
    }

    /// Layout of the points.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Seed that every point follows from.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Distributions, dimension by dimension.
    pub fn factors(&self) -> &[Distribution] {
        &self.factors
    }

    /// Rows of one group: trajectory, base point or machine; 1 for independent rows.
    pub fn rows_per_sample(&self) -> u64 {
        let dimensions = self.factors.len() as u64;
        match self.layout {
            Layout::Morris { .. } | Layout::Tighten { .. } => dimensions + 1,
            Layout::Saltelli { second_order: false } => dimensions + 2,
            Layout::Saltelli { second_order: true } => 2 * dimensions + 2,
            _ => 1,
        }
    }

    /// Rows in all.
    pub fn rows(&self) -> u64 {
        match &self.layout {
            Layout::Grid { levels } => levels.iter().map(|n| *n as u64).product(),
            Layout::Cases { count } => *count as u64,
            Layout::Points(points) => points.len() as u64,
            _ => self.samples * self.rows_per_sample(),
        }
    }

    /// Whether a row is a draw from the distributions of all factors, so that quantiles and yields are meaningful.
    /// Points of a grid or a trajectory, rows with exchanged columns and tightened rows are not.
    pub fn is_sample(&self, row: u64) -> bool {
        let (within, last) = (row % self.rows_per_sample(), self.rows_per_sample() - 1);
        match self.layout {
            Layout::Grid { .. } | Layout::Cases { .. } | Layout::Points(_) | Layout::Morris { .. } => false,
            Layout::Random | Layout::LatinHypercube | Layout::Sobol => true,
            Layout::Saltelli { .. } => within == 0 || within == last,
            Layout::Tighten { .. } => within == 0,
        }
    }

    /// Row number `row`, from 0; it does not depend on rows computed before. Meant for rows below
    /// [`Sampling::rows`].
    pub fn point(&self, row: u64) -> Point {
        let dimensions = self.factors.len();
        let (sample, within) = (row / self.rows_per_sample(), (row % self.rows_per_sample()) as usize);
        let plain = |unit: Vec<f64>| Point { unit, tightened: None };
        match &self.layout {
            Layout::Grid { levels } => plain(self.grid_point(levels, row)),
            Layout::Cases { count } => plain(vec![(row as f64 + 0.5) / *count as f64; dimensions]),
            // A row beyond the last does not belong to the plan.
            Layout::Points(points) => {
                plain(usize::try_from(row).ok().and_then(|row| points.get(row)).cloned().unwrap_or_default())
            }
            Layout::Random => plain(self.random_point(sample)),
            Layout::LatinHypercube => {
                let mut stream = Stream::new(self.seed, Purpose::Points, sample);
                let stratum = |strata: &Vec<u32>| f64::from(strata[sample as usize % strata.len()]);
                plain(
                    self.strata
                        .iter()
                        .map(|strata| (stratum(strata) + stream.unit()) / self.samples as f64)
                        .collect(),
                )
            }
            Layout::Sobol => plain((0..dimensions).map(|d| self.sobol(sample, d)).collect()),
            Layout::Morris { levels } => {
                let steps = trajectories::point(self.seed, sample, within, dimensions, *levels);
                plain(
                    steps
                        .into_iter()
                        .zip(&self.factors)
                        .map(|(step, factor)| factor.level(step, *levels))
                        .collect(),
                )
            }
            Layout::Saltelli { second_order } => {
                plain((0..dimensions).map(|d| self.saltelli(sample, within, d, *second_order)).collect())
            }
            Layout::Tighten { share } => Point {
                unit: self.random_point(sample),
                tightened: within.checked_sub(1).map(|dimension| (dimension, *share)),
            },
        }
    }

    /// Values of the varied quantities at a point. Tightening of a drawn machine is done when it is drawn.
    pub fn values(&self, point: &Point) -> Vec<Value> {
        let mut values: Vec<Value> =
            self.factors.iter().zip(&point.unit).map(|(factor, u)| factor.at(*u)).collect();
        if let Some((dimension, share)) = point.tightened {
            values[dimension] = self.factors[dimension].tightened(values[dimension], share);
        }
        values
    }

    fn grid_point(&self, levels: &[usize], row: u64) -> Vec<f64> {
        let mut rest = row;
        let mut unit: Vec<f64> = levels
            .iter()
            .zip(&self.factors)
            .rev()
            .map(|(levels, factor)| {
                let index = rest % *levels as u64;
                rest /= *levels as u64;
                factor.level(index as usize, *levels)
            })
            .collect();
        unit.reverse();
        unit
    }

    fn random_point(&self, sample: u64) -> Vec<f64> {
        let mut stream = Stream::new(self.seed, Purpose::Points, sample);
        self.factors.iter().map(|_| stream.unit()).collect()
    }

    /// Coordinate `dimension` of point `index` of the scrambled sequence, at the middle of its 2⁻³² cell:
    /// never 0 or 1.
    fn sobol(&self, index: u64, dimension: usize) -> f64 {
        let scramble =
            |what: u64| burley_hash(stream::hash(&[self.seed, Purpose::Scramble as u64, what]) as u32);
        // A shuffle of the order that keeps aligned blocks of 2^m points together (Burley 2020, § 3).
        let shuffled = owen_scramble_rev((index as u32).reverse_bits(), scramble(u64::MAX));
        let bits = owen_scramble_rev(sobol_rev(shuffled, dimension as u32), scramble(dimension as u64));
        (f64::from(bits.reverse_bits()) + 0.5) / (1_u64 << 32) as f64
    }

    /// A in the first dimensions of the sequence, B in the others.
    fn saltelli(&self, sample: u64, within: usize, dimension: usize, second_order: bool) -> f64 {
        let count = self.factors.len();
        let (a, b) = (dimension, dimension + count);
        let last = if second_order { 2 * count + 1 } else { count + 1 };
        let column = match within {
            0 => a,
            row if row == last => b,
            row if row <= count => {
                if row == dimension + 1 {
                    b
                } else {
                    a
                }
            }
            row => {
                if row == dimension + 1 + count {
                    a
                } else {
                    b
                }
            }
        };
        self.sobol(sample, column)
    }
}

#[cfg(test)]
mod tests;
