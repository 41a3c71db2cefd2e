use faer::Mat;

use super::disc::DiscModel;
use super::reduced::Interface;
use super::reduction::read;
use super::{FemError, FlankStations};

impl DiscModel {
    /// Constraint modes and the matrices of the interface coordinates.
    pub(super) fn interface(
        &self,
        stations: &FlankStations,
        rows: &[Vec<(usize, f64)>],
        shapes: &Mat<f64>,
    ) -> Result<Interface, FemError> {
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
            stiffness: pairs()
                .map(|(a, b)| k_interface[(a, b)] + dot(k_inner.col_as_slice(a), constraint.col_as_slice(b)))
                .collect(),
            mass: pairs().map(|(a, b)| dot(&full[a], &weighted[b])).collect(),
            coupling: (0..count)
                .flat_map(|b| (0..shapes.ncols()).map(move |m| (b, m)))
                .map(|(b, m)| dot(shapes.col_as_slice(m), &weighted[b]))
                .collect(),
            flank: (0..count)
                .flat_map(|b| {
                    stations
                        .coefficients(rows.iter().map(|row| read(row, constraint.col_as_slice(b))).collect())
                })
                .collect(),
        })
    }
}
