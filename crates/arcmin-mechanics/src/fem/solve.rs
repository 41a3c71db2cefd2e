//! Sparse Cholesky factors, static solutions and lowest modes. Everything here runs on the calling thread.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::cholesky::{
    LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Accum, Conj, Mat, MatMut, MatRef, Par, Side};

use super::{FemError, SymmetricMatrix};
use crate::kernels::{cleared, product};

/// A = P L Lᵀ Pᵀ of a symmetric positive definite matrix (approximate minimum degree ordering, supernodal,
/// faer).
pub struct Cholesky {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
}

impl Cholesky {
    /// # Errors
    /// [`FemError::Factorisation`] if the matrix is not positive definite (a body not held, a node without an
    /// element).
    pub fn new(matrix: &SymmetricMatrix) -> Result<Cholesky, FemError> {
        let n = matrix.order;
        let failed = |reason: String| FemError::Factorisation { unknowns: n, reason };
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &matrix.column_start, None, &matrix.rows);
        let symbolic =
            factorize_symbolic_cholesky(pattern, Side::Lower, SymmetricOrdering::Amd, Default::default())
                .map_err(|error| failed(format!("{error:?}")))?;
        let mut values = vec![0.0; symbolic.len_val()];
        let mut memory =
            MemBuffer::try_new(symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()))
                .map_err(|_| failed("out of memory".to_owned()))?;
        let a = SparseColMatRef::new(pattern, &matrix.values);
        let factorised = cleared(|| {
            let factor = symbolic.factorize_numeric_llt(
                &mut values,
                a,
                Side::Lower,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            );
            factor.is_ok()
        });
        if !factorised {
            return Err(failed("it is not positive definite; the body may not be held".to_owned()));
        }
        Ok(Cholesky { symbolic, values })
    }

    /// Entries of L.
    pub fn fill(&self) -> usize {
        self.values.len()
    }

    /// As [`Inverse::solve`].
    pub fn solve(&self, b: MatMut<'_, f64>) {
        let mut memory = MemBuffer::new(self.symbolic.solve_in_place_scratch::<f64>(b.ncols(), Par::Seq));
        let factor = LltRef::new(&self.symbolic, &self.values);
        cleared(|| factor.solve_in_place_with_conj(Conj::No, b, Par::Seq, MemStack::new(&mut memory)));
    }
}

/// The inverse of a stiffness, for any support of the body.
pub trait Inverse {
    /// Overwrites the columns of `b` with A⁻¹ b.
    fn solve(&self, b: MatMut<'_, f64>);
}

impl Inverse for Cholesky {
    fn solve(&self, b: MatMut<'_, f64>) {
        Cholesky::solve(self, b);
    }
}

/// Vibration modes K x = ω² M x: M-orthonormal shapes, ω² ascending.
#[derive(Debug, Clone)]
pub struct Modes {
    /// ω² in rad²/s².
    pub eigenvalues: Vec<f64>,
    /// One column per mode, in unknowns.
    pub shapes: Mat<f64>,
}

impl Modes {
    /// Natural frequencies in Hz.
    pub fn frequencies(&self) -> Vec<f64> {
        self.eigenvalues.iter().map(|l| l.max(0.0).sqrt() / std::f64::consts::TAU).collect()
    }
}

/// Block size: multiple right-hand sides cost little more than one, and multiplicities up to this number are found
/// reliably.
const BLOCK: usize = 6;
/// Residual of a mode relative to its shifted eigenvalue at which it counts as converged; the error of ω² is
/// its square.
const MODE_TOLERANCE: f64 = 1e-7;

/// Part of the spectrum to be computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ModeRange {
    /// This number of lowest modes.
    Count(usize),
    /// All up to a frequency in Hz, but no more than `limit`.
    UpTo {
        /// Hz.
        frequency: f64,
        /// Largest number of modes.
        limit: usize,
    },
}

/// Lowest modes by a block Lanczos iteration on (K + σM)⁻¹ M with full reorthogonalisation in the M inner
/// product.
///
/// `factor` is that of K + σM with σ ≥ 0 in rad²/s²; σ > 0 is needed to factorise a free body. ω² = 1/θ − σ for
/// the Ritz values θ. Source: Grimes, Lewis & Simon, SIAM J. Matrix Anal. 15 (1994) 228.
///
/// # Errors
/// [`FemError::Modes`] if the required modes do not converge.
pub fn lowest_modes(
    mass: &SymmetricMatrix,
    factor: &dyn Inverse,
    sigma: f64,
    range: ModeRange,
) -> Result<Modes, FemError> {
    let n = mass.order;
    let required = match range {
        ModeRange::Count(count) => count.min(n),
        ModeRange::UpTo { limit, .. } => limit.min(n),
    };
    // Close eigenvalues, such as the pairs of a ring, need more vectors.
    let most = (4 * required + 20 * BLOCK).min(n);
    // The basis V, and M V as well, which saves all but one product with M per step.
    let mut basis: Mat<f64> = Mat::zeros(n, most);
    let mut weighted_basis: Mat<f64> = Mat::zeros(n, most);
    let mut projected: Mat<f64> = Mat::zeros(most, most);
    let mut block = starting_block(n);
    let mut weighted = Mat::zeros(n, BLOCK);
    mass.multiply(block.as_ref(), weighted.as_mut());
    orthonormalise(&mut block, &mut weighted);
    let mut size = 0;
    loop {
        let columns = BLOCK.min(most - size);
        let filled = size + columns;
        basis.subcols_mut(size, columns).copy_from(block.subcols(0, columns));
        weighted_basis.subcols_mut(size, columns).copy_from(weighted.subcols(0, columns));
        // w = A⁻¹ M v; T is Vᵀ M w, and w is then M-orthogonalised to V.
        let mut next = weighted.clone();
        factor.solve(next.as_mut());
        mass.multiply(next.as_ref(), weighted.as_mut());
        for _ in 0..2 {
            let mut coefficients: Mat<f64> = Mat::zeros(filled, BLOCK);
            let known = weighted_basis.subcols(0, filled);
            product(coefficients.as_mut(), Accum::Replace, known.transpose(), next.as_ref(), 1.0);
            product(next.as_mut(), Accum::Add, basis.subcols(0, filled), coefficients.as_ref(), -1.0);
            product(weighted.as_mut(), Accum::Add, known, coefficients.as_ref(), -1.0);
            for i in 0..filled {
                for j in 0..columns {
                    projected[(i, size + j)] += coefficients[(i, j)];
                }
            }
        }
        for i in 0..filled {
            for j in 0..columns {
                projected[(size + j, i)] = projected[(i, size + j)];
            }
        }
        let remainder = orthonormalise(&mut next, &mut weighted);
        size = filled;
        let (theta, vectors) = symmetric_eigen(projected.submatrix(0, 0, size, size))?;
        // Ritz values are in ascending order; the largest θ are the lowest modes. The residual of a Ritz pair
        // follows from its components in the last block.
        let mut found = 0;
        while found < size.min(required) {
            let index = size - 1 - found;
            let residual = (0..BLOCK)
                .map(|i| {
                    (0..columns)
                        .map(|j| remainder[(i, j)] * vectors[(size - columns + j, index)])
                        .sum::<f64>()
                        .powi(2)
                })
                .sum::<f64>()
                .sqrt();
            if residual > MODE_TOLERANCE * theta[index] {
                break;
            }
            found += 1;
        }
        let value = |k: usize| 1.0 / theta[size - 1 - k] - sigma;
        let enough = match range {
            ModeRange::Count(_) => found == required,
            // One converged mode beyond the limit proves that none below it is missing.
            ModeRange::UpTo { frequency, .. } => {
                found == required
                    || (found > 0 && value(found - 1) > (std::f64::consts::TAU * frequency).powi(2))
            }
        };
        if enough {
            let keep = match range {
                ModeRange::Count(_) => required,
                ModeRange::UpTo { frequency, .. } => {
                    (0..found).filter(|k| value(*k) <= (std::f64::consts::TAU * frequency).powi(2)).count()
                }
            };
            let chosen = Mat::from_fn(size, keep, |i, k| vectors[(i, size - 1 - k)]);
            let mut shapes = Mat::zeros(n, keep);
            product(shapes.as_mut(), Accum::Replace, basis.subcols(0, size), chosen.as_ref(), 1.0);
            return Ok(Modes { eigenvalues: (0..keep).map(value).collect(), shapes });
        }
        if size == most {
            return Err(FemError::Modes { found, required, vectors: size });
        }
        block = next;
    }
}

/// Eigenvalues (ascending) and eigenvectors of a small dense symmetric matrix.
///
/// # Errors
/// [`FemError::Factorisation`] if the iteration fails, which occurs only for entries that are not finite.
pub fn symmetric_eigen(matrix: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>), FemError> {
    let n = matrix.nrows();
    let failed = |reason: String| FemError::Factorisation { unknowns: n, reason };
    let mut values = faer::diag::Diag::zeros(n);
    let mut vectors = Mat::zeros(n, n);
    let compute = faer::linalg::evd::ComputeEigenvectors::Yes;
    let mut memory = MemBuffer::try_new(faer::linalg::evd::self_adjoint_evd_scratch::<f64>(
        n,
        compute,
        Par::Seq,
        Default::default(),
    ))
    .map_err(|_| failed("out of memory".to_owned()))?;
    let solve = || {
        faer::linalg::evd::self_adjoint_evd(
            matrix,
            values.as_mut(),
            Some(vectors.as_mut()),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        )
    };
    cleared(solve).map_err(|error| failed(format!("{error:?}")))?;
    Ok((values.column_vector().iter().copied().collect(), vectors))
}

/// Deterministic starting vectors without symmetry, so that no mode is orthogonal to them.
fn starting_block(n: usize) -> Mat<f64> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    Mat::from_fn(n, BLOCK, |_, _| {
        // xorshift64*
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        (state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    })
}

/// M-orthonormalises the columns of `block` (with `weighted` = M block kept in step) and returns R of block =
/// Q R.
fn orthonormalise(block: &mut Mat<f64>, weighted: &mut Mat<f64>) -> Mat<f64> {
    let columns = block.ncols();
    let mut r: Mat<f64> = Mat::zeros(columns, columns);
    for j in 0..columns {
        let mut scale_so_far = 1.0;
        for pass in 0..2 {
            for i in 0..j {
                let share = dot(column(weighted, i), column(block, j));
                r[(i, j)] += share * scale_so_far;
                subtract(block, i, j, share);
                subtract(weighted, i, j, share);
            }
            let norm = dot(column(block, j), column(weighted, j)).max(0.0).sqrt();
            scale_so_far *= norm;
            r[(j, j)] = scale_so_far;
            let scale = if norm > 0.0 { 1.0 / norm } else { 0.0 };
            for matrix in [&mut *block, &mut *weighted] {
                column_mut(matrix, j).iter_mut().for_each(|v| *v *= scale);
            }
            if pass == 0 && j == 0 {
                break;
            }
        }
    }
    r
}

fn column(matrix: &Mat<f64>, j: usize) -> &[f64] {
    matrix.col_as_slice(j)
}

fn column_mut(matrix: &mut Mat<f64>, j: usize) -> &mut [f64] {
    matrix.col_as_slice_mut(j)
}

/// column j −= share × column i, i < j.
fn subtract(matrix: &mut Mat<f64>, i: usize, j: usize, share: f64) {
    let (left, mut right) = matrix.as_mut().split_at_col_mut(j);
    let (Some(from), Some(to)) =
        (left.col(i).try_as_col_major(), right.as_mut().col_mut(0).try_as_col_major_mut())
    else {
        unreachable!("an owned matrix is column-major");
    };
    to.as_slice_mut().iter_mut().zip(from.as_slice()).for_each(|(t, f)| *t -= share * f);
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Four partial sums let the compiler vectorise; the order is fixed, so the result is reproducible.
    let mut sums = [0.0; 4];
    let (ca, cb) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = ca.remainder().iter().zip(cb.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in ca.zip(cb) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}
