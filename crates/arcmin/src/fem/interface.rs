use faer::Mat;

use super::disc::DiscModel;
use super::reduced::Interface;
use super::reduction::read;
use super::solve::symmetric_eigen;
use super::{FemError, FlankStations, ReducedDisc};

impl DiscModel {
    /// Constraint modes and the matrices of the interface coordinates.
    pub(super) fn interface(&self, stations: &FlankStations, rows: &[Vec<(usize, f64)>], shapes: &Mat<f64>) -> Result<Interface, FemError> {
        let count = self.map.retained;
        if count == 0 {
            return Ok(Interface::default());
        }
        let inner = self.inner_unknowns();
        // Columns of K that belong to the interface, from the rows of the lower triangle.
        let mut k_inner: Mat<f64> = Mat::zeros(inner, count);
        let mut k_interface: Mat<f64> = Mat::zeros(count, count);
        for column in 0..self.map.count {
            for k in self.stiffness.column_start[column]..self.stiffness.column_start[column + 1] {
                let (row, value) = (self.stiffness.rows[k], self.stiffness.values[k]);
                if row >= inner && column < inner {
                    k_inner[(column, row - inner)] = value;
                } else if row >= inner {
                    k_interface[(row - inner, column - inner)] = value;
                    k_interface[(column - inner, row - inner)] = value;
                }
            }
        }
        let mut constraint = Mat::from_fn(inner, count, |i, j| -k_inner[(i, j)]);
        self.factor.solve(constraint.as_mut());
        let full: Vec<Vec<f64>> = (0..count)
            .map(|b| {
                let mut shape = constraint.col_as_slice(b).to_vec();
                shape.extend((0..count).map(|k| f64::from(u8::from(k == b))));
                shape
            })
            .collect();
        let weighted: Vec<Vec<f64>> = full.iter().map(|shape| self.mass.product(shape)).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let pairs = || (0..count).flat_map(|a| (0..count).map(move |b| (a, b)));
        Ok(Interface {
            count,
            stiffness: pairs().map(|(a, b)| k_interface[(a, b)] + dot(k_inner.col_as_slice(a), constraint.col_as_slice(b))).collect(),
            mass: pairs().map(|(a, b)| dot(&full[a], &weighted[b])).collect(),
            coupling: (0..count)
                .flat_map(|b| (0..shapes.ncols()).map(move |m| (b, m)))
                .map(|(b, m)| dot(shapes.col_as_slice(m), &weighted[b]))
                .collect(),
            flank: (0..count).flat_map(|b| stations.coefficients(rows.iter().map(|row| read(row, constraint.col_as_slice(b))).collect())).collect(),
        })
    }
}

impl ReducedDisc {
    /// Frequencies in Hz of the reduced disc with its interface free: three zeros, then elastic modes. To be held against
    /// [`DiscModel::free_modes`]. Empty where the interface is one rigid spider.
    ///
    /// # Errors
    /// [`FemError::Factorisation`] if the small eigenproblem cannot be solved.
    pub fn free_frequencies(&self) -> Result<Vec<f64>, FemError> {
        let (nb, nq) = (self.interface.count, self.eigenvalues.len());
        if nb == 0 {
            return Ok(Vec::new());
        }
        let n = nb + nq;
        let mass = Mat::from_fn(n, n, |i, j| match (i < nb, j < nb) {
            (true, true) => self.interface.mass[i * nb + j],
            (true, false) => self.interface.coupling[i * nq + j - nb],
            (false, true) => self.interface.coupling[j * nq + i - nb],
            (false, false) => f64::from(u8::from(i == j)),
        });
        let (values, vectors) = symmetric_eigen(mass.as_ref())?;
        let whitening = Mat::from_fn(n, n, |i, k| vectors[(i, k)] / values[k].sqrt());
        let stiffness = |i: usize, j: usize| match (i < nb, j < nb) {
            (true, true) => self.interface.stiffness[i * nb + j],
            (false, false) if i == j => self.eigenvalues[i - nb],
            _ => 0.0,
        };
        let half = Mat::from_fn(n, n, |i, k| (0..n).map(|j| stiffness(i, j) * whitening[(j, k)]).sum::<f64>());
        let projected = Mat::from_fn(n, n, |i, j| (0..n).map(|k| whitening[(k, i)] * half[(k, j)]).sum::<f64>());
        let symmetric = Mat::from_fn(n, n, |i, j| 0.5 * (projected[(i, j)] + projected[(j, i)]));
        let (eigenvalues, _) = symmetric_eigen(symmetric.as_ref())?;
        Ok(eigenvalues.iter().map(|l| l.max(0.0).sqrt() / std::f64::consts::TAU).collect())
    }
}
