//! Full matrices and their factorisation.

use faer::linalg::solvers::{PartialPivLu, Solve};

use super::{Singular, Weights};
use crate::kernels::cleared;

/// Full matrices, row by row, with Gaussian elimination; above a number of coordinates by faer's blocks, which
/// are faster there.
#[derive(Debug, Clone, Default)]
pub struct DenseLinearisation {
    size: usize,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    /// The last factors: row by row, with the row exchanges, or those of faer.
    work: Vec<f64>,
    exchanged: Vec<usize>,
    blocks: Option<PartialPivLu<f64>>,
}

/// Number of coordinates from which on blocks are faster.
const LARGE: usize = 96;

impl DenseLinearisation {
    /// Zero matrices for a number of coordinates.
    pub fn new(size: usize) -> DenseLinearisation {
        DenseLinearisation {
            size,
            stiffness: vec![0.0; size * size],
            damping: vec![0.0; size * size],
            work: vec![0.0; size * size],
            exchanged: Vec::with_capacity(size),
            blocks: None,
        }
    }

    /// Adapts the size to a number of coordinates, without damping.
    pub fn fit(&mut self, size: usize) {
        if self.size != size || self.takes_damping() {
            *self = DenseLinearisation::at_rest(size);
        }
    }

    /// Without a damping matrix, which is neither filled nor needed.
    pub fn at_rest(size: usize) -> DenseLinearisation {
        DenseLinearisation { damping: Vec::new(), ..DenseLinearisation::new(size) }
    }

    /// Whether evaluation and factorisation cost several evaluations of the forces.
    pub fn is_large(&self) -> bool {
        self.size >= LARGE
    }

    /// Whether it has a damping matrix.
    pub fn takes_damping(&self) -> bool {
        !self.damping.is_empty()
    }

    /// Sets stiffness and damping to zero.
    pub fn clear(&mut self) {
        self.stiffness.fill(0.0);
        self.damping.fill(0.0);
    }

    /// Adds to −∂Q_row/∂q_column.
    #[inline]
    pub fn add_stiffness(&mut self, row: usize, column: usize, value: f64) {
        self.stiffness[row * self.size + column] += value;
    }

    /// Adds to −∂Q_row/∂q̇_column; without effect if there is no damping matrix.
    #[inline]
    pub fn add_damping(&mut self, row: usize, column: usize, value: f64) {
        if let Some(entry) = self.damping.get_mut(row * self.size + column) {
            *entry += value;
        }
    }

    /// −∂Q_row/∂q of all coordinates.
    #[inline]
    pub fn stiffness_row(&mut self, row: usize) -> &mut [f64] {
        &mut self.stiffness[row * self.size..][..self.size]
    }

    /// The same to read.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.stiffness[row * self.size..][..self.size]
    }

    /// −∂Q_row/∂q̇ of all coordinates.
    #[inline]
    pub fn damping_row(&mut self, row: usize) -> &mut [f64] {
        self.damping.get_mut(row * self.size..(row + 1) * self.size).unwrap_or_default()
    }

    /// Adds the damping matrix times `rate` (1/s) to the stiffness: for velocities that are q times the rate
    /// plus a constant.
    pub fn fold_damping(&mut self, rate: f64) {
        for (stiffness, damping) in self.stiffness.iter_mut().zip(&self.damping) {
            *stiffness += rate * damping;
        }
    }

    /// −∂Q_row/∂q_column.
    pub fn stiffness(&self, row: usize, column: usize) -> f64 {
        self.stiffness[row * self.size + column]
    }

    /// −∂Q_row/∂q̇_column.
    pub fn damping(&self, row: usize, column: usize) -> f64 {
        self.damping[row * self.size + column]
    }
}

impl DenseLinearisation {
    /// Copies the stiffness of another linearisation, without damping.
    pub fn copy_stiffness(&mut self, from: &DenseLinearisation) {
        self.stiffness.copy_from_slice(&from.stiffness);
        self.damping.fill(0.0);
    }

    /// Adds a matrix over the listed coordinates, row by row, to the stiffness.
    pub fn add_block(&mut self, index: &[usize], block: &[f64]) {
        for (row, entries) in index.iter().zip(block.chunks_exact(index.len().max(1))) {
            let line = self.stiffness_row(*row);
            index.iter().zip(entries).for_each(|(column, entry)| line[*column] += entry);
        }
    }

    /// Adds k a bᵀ to the stiffness (k in N/m) for two vectors over the listed coordinates; coordinates from
    /// `size` on do not move and are skipped.
    pub fn add_outer(&mut self, index: &[usize], a: &[f64], b: &[f64], stiffness: f64) {
        for (row, a) in index.iter().zip(a).filter(|(row, _)| **row < self.size) {
            let line = &mut self.stiffness[row * self.size..][..self.size];
            let force = stiffness * a;
            for i in 0..index.len() {
                if let Some(entry) = line.get_mut(index[i]) {
                    *entry += force * b[i];
                }
            }
        }
    }

    /// Holds a coordinate: its row and column are replaced by those of the identity.
    pub fn hold(&mut self, coordinate: usize) {
        let n = self.size;
        for i in 0..n {
            for entry in [coordinate * n + i, i * n + coordinate] {
                self.stiffness[entry] = 0.0;
                self.damping.get_mut(entry).into_iter().for_each(|damping| *damping = 0.0);
            }
        }
        self.stiffness[coordinate * n + coordinate] = 1.0;
    }

    /// K x.
    pub fn multiply(&self, x: &[f64], product: &mut [f64]) {
        for (entry, row) in product.iter_mut().zip(self.stiffness.chunks_exact(self.size)) {
            *entry = dot(row, x);
        }
    }

    /// Copies the listed rows and columns from the stiffness of a larger matrix.
    pub fn take_rows(&mut self, from: &DenseLinearisation, index: &[usize]) {
        for (row, i) in index.iter().enumerate() {
            let from = from.row(*i);
            self.stiffness_row(row).iter_mut().zip(index).for_each(|(entry, j)| *entry = from[*j]);
        }
    }

    /// Solves K x = rhs in place for a symmetric K by Cholesky factorisation UᵀU of its upper half. Returns
    /// `false`, with `rhs` unchanged, if K is not positive definite.
    pub fn solve_positive(&mut self, rhs: &mut [f64]) -> bool {
        let (n, a) = (self.size, &mut self.work);
        a.copy_from_slice(&self.stiffness);
        for i in 0..n {
            let (done, rest) = a.split_at_mut((i + 1) * n);
            let own = &mut done[i * n + i..];
            if !(own[0] > 0.0) {
                return false;
            }
            let scale = 1.0 / own[0].sqrt();
            own.iter_mut().for_each(|entry| *entry *= scale);
            for (row, other) in rest.chunks_exact_mut(n).zip(i + 1..) {
                let share = own[other - i];
                if share != 0.0 {
                    let entries = row[other..].iter_mut().zip(&own[other - i..]);
                    entries.for_each(|(entry, of_own)| *entry -= share * of_own);
                }
            }
        }
        for row in 0..n {
            let entries = &a[row * n + row..][..n - row];
            let x = rhs[row] / entries[0];
            rhs[row] = x;
            rhs[row + 1..].iter_mut().zip(&entries[1..]).for_each(|(rhs, entry)| *rhs -= x * entry);
        }
        for row in (0..n).rev() {
            let entries = &a[row * n + row..][..n - row];
            rhs[row] = (rhs[row] - dot(&entries[1..], &rhs[row + 1..])) / entries[0];
        }
        true
    }

    /// Solves (M m + C d + K s) x = rhs in place, where (m, d, s) are the weights.
    ///
    /// # Errors
    /// [`Singular`] if the matrix has no inverse or contains a value that is not finite.
    pub fn solve(&mut self, mass: &[f64], weights: Weights, rhs: &mut [f64]) -> Result<(), Singular> {
        let n = self.size;
        let a = &mut self.work;
        if weights.damping == 0.0 && weights.stiffness == 1.0 {
            a.copy_from_slice(&self.stiffness);
        } else if weights.damping == 0.0 {
            a.iter_mut().zip(&self.stiffness).for_each(|(entry, k)| *entry = weights.stiffness * k);
        } else {
            for (entry, (k, c)) in a.iter_mut().zip(self.stiffness.iter().zip(&self.damping)) {
                *entry = weights.stiffness * k + weights.damping * c;
            }
        }
        for i in 0..n {
            a[i * n + i] += weights.mass * mass[i];
        }
        if n >= LARGE {
            let matrix = faer::MatRef::from_row_major_slice(a, n, n);
            self.blocks = Some(cleared(|| matrix.partial_piv_lu()));
        } else {
            self.eliminate()?;
        }
        self.solve_again(rhs)
    }

    /// Solves the system of the last [`DenseLinearisation::solve`] for another right-hand side, independent of
    /// later changes of the matrices.
    ///
    /// # Errors
    /// As there.
    pub fn solve_again(&self, rhs: &mut [f64]) -> Result<(), Singular> {
        let (n, a) = (self.size, &self.work);
        if let Some(factor) = &self.blocks {
            cleared(|| factor.solve_in_place(faer::MatMut::from_column_major_slice_mut(rhs, n, 1)));
        } else {
            for (row, other) in self.exchanged.iter().enumerate() {
                rhs.swap(row, *other);
            }
            for row in 1..n {
                rhs[row] -= dot(&a[row * n..][..row], &rhs[..row]);
            }
            for row in (0..n).rev() {
                let entries = &a[row * n..][..n];
                rhs[row] = (rhs[row] - dot(&entries[row + 1..], &rhs[row + 1..])) / entries[row];
            }
        }
        if rhs.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(Singular) }
    }
}

/// Four independent partial sums, so that additions overlap.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let b = &b[..a.len()];
    let whole = a.len() - a.len() % 4;
    let mut sums = [0.0; 4];
    for first in (0..whole).step_by(4) {
        for lane in 0..4 {
            sums[lane] += a[first + lane] * b[first + lane];
        }
    }
    let rest: f64 = (whole..a.len()).map(|i| a[i] * b[i]).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

impl DenseLinearisation {
    /// Gaussian elimination of the matrix in `work`: the factors of every column are stored below the diagonal
    /// and exchanged with their rows.
    fn eliminate(&mut self) -> Result<(), Singular> {
        let (n, a) = (self.size, &mut self.work);
        self.exchanged.clear();
        for column in 0..n {
            let mut pivot = column;
            for row in column + 1..n {
                if a[row * n + column].abs() > a[pivot * n + column].abs() {
                    pivot = row;
                }
            }
            let largest = a[pivot * n + column];
            if !(largest.abs() > 0.0 && largest.is_finite()) {
                return Err(Singular);
            }
            self.exchanged.push(pivot);
            if pivot != column {
                for k in 0..n {
                    a.swap(column * n + k, pivot * n + k);
                }
            }
            // Slices of known length, so that the compiler can use vector instructions.
            let (above, below) = a.split_at_mut((column + 1) * n);
            let pivot_row = &above[column * n + column + 1..];
            for row in below.chunks_exact_mut(n) {
                let factor = row[column] / largest;
                row[column] = factor;
                if factor != 0.0 {
                    let rest = &mut row[column + 1..];
                    let pivot_row = &pivot_row[..rest.len()];
                    for k in 0..rest.len() {
                        rest[k] -= factor * pivot_row[k];
                    }
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
