use faer::Mat;

use super::disc::{DiscModel, Held};
use super::reduced::Interface;
use super::reduction::read;
use super::solve::Cholesky;
use super::{FemError, FlankStations};

impl DiscModel {
    /// Constraint modes and the matrices of the interface coordinates.
    pub(super) fn interface(
        &self,
        stations: &FlankStations,
        rows: &[Vec<(usize, f64)>],
        shapes: &Mat<f64>,
    ) -> Result<Interface, FemError> {
        let (full, stiffness) = match &self.held {
            Held::Means(means) => {
                let (shapes, stiffness) = means.constraint_modes();
                ((0..means.count()).map(|b| shapes.col_as_slice(b).to_vec()).collect(), stiffness)
            }
            Held::Unknowns(_) if self.map.retained == 0 => return Ok(Interface::default()),
            Held::Unknowns(factor) => self.constraint_modes(factor),
        };
        let count = full.len();
        let weighted: Vec<Vec<f64>> = full.iter().map(|shape| self.mass.product(shape)).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let pairs = || (0..count).flat_map(|a| (0..count).map(move |b| (a, b)));
        Ok(Interface {
            count,
            per_bore: count / self.bores.len(),
            stiffness,
            mass: pairs().map(|(a, b)| dot(&full[a], &weighted[b])).collect(),
            coupling: (0..count)
                .flat_map(|b| (0..shapes.ncols()).map(move |m| (b, m)))
                .map(|(b, m)| dot(shapes.col_as_slice(m), &weighted[b]))
                .collect(),
            flank: full
                .iter()
                .flat_map(|shape| stations.coefficients(rows.iter().map(|row| read(row, shape)).collect()))
                .collect(),
        })
    }

    /// Shapes −K_ii⁻¹ K_ib with 1 at the interface, and K_bb + K_bi Ψ row by row, where interface coordinates
    /// are unknowns.
    fn constraint_modes(&self, factor: &Cholesky) -> (Vec<Vec<f64>>, Vec<f64>) {
        let (count, inner) = (self.map.retained, self.inner_unknowns());
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
        factor.solve(constraint.as_mut());
        let full = (0..count)
            .map(|b| {
                let mut shape = constraint.col_as_slice(b).to_vec();
                shape.extend((0..count).map(|k| f64::from(u8::from(k == b))));
                shape
            })
            .collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let pairs = (0..count).flat_map(|a| (0..count).map(move |b| (a, b)));
        let stiffness = pairs
            .map(|(a, b)| k_interface[(a, b)] + dot(k_inner.col_as_slice(a), constraint.col_as_slice(b)))
            .collect();
        (full, stiffness)
    }
}
