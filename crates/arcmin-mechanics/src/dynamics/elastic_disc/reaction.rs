//! Forces of pins and elasticity on a disc, and the sum of its matrices.

use faer::{Accum, MatMut, MatRef};

use crate::contact::{ContactForce, DiscVelocity, PinContact};
use crate::kernels::product;

/// Forces on (x, y, θ), the modes of a disc, those of the housing and the slopes of a disc that tilts, with their
/// tangents, matrices row by row.
#[derive(Debug, Clone, Default)]
pub(in crate::dynamics) struct ElasticReaction {
    pub force: Vec<f64>,
    /// −∂Q/∂(x, y, θ, q, η, σ).
    pub stiffness: Vec<f64>,
    pub damping: Vec<f64>,
    pub stored: f64,
    pub dissipation: f64,
    pub onset_rate: f64,
}

impl ElasticReaction {
    /// Adds damping and sliding friction of a contact: `row` is −∂s/∂z, `push` the effect of a unit of its
    /// force on the coordinates, `slope` the derivative of the friction force with respect to speed.
    pub(super) fn add_damping(
        &mut self,
        here: &ContactForce,
        (row, push): (&[f64], &[f64]),
        slope: f64,
        contact: &PinContact,
        (hessian, velocity): (&[[f64; 3]; 3], DiscVelocity),
    ) {
        let width = row.len();
        if here.damping != 0.0 {
            for (line, push) in self.damping.chunks_exact_mut(width).zip(push) {
                line.iter_mut().zip(row).for_each(|(entry, row)| *entry += here.damping * push * row);
            }
        }
        let v = [velocity.centre.x, velocity.centre.y, velocity.angle];
        for a in 0..3 {
            let rate_slope = hessian[a][0] * v[0] + hessian[a][1] * v[1] + hessian[a][2] * v[2];
            for b in 0..3 {
                self.stiffness[b * width + a] += here.damping * rate_slope * push[b];
                self.damping[a * width + b] += here.force * slope * contact.along[a] * contact.along[b];
            }
        }
    }
}

/// A sum Σ aᵀ b of rows, formed at once: one product of two matrices takes a quarter of the time of as many outer
/// products.
pub(super) struct Products {
    width: usize,
    left: Vec<f64>,
    right: Vec<f64>,
}

impl Products {
    pub fn new(width: usize) -> Products {
        Products { width, left: Vec::new(), right: Vec::new() }
    }

    /// Adds one pair of rows, each written into zeros.
    pub fn push(&mut self, left: impl FnOnce(&mut [f64]), right: impl FnOnce(&mut [f64])) {
        let at = self.left.len();
        self.left.resize(at + self.width, 0.0);
        self.right.resize(at + self.width, 0.0);
        left(&mut self.left[at..]);
        right(&mut self.right[at..]);
    }

    /// Adds rows that stand one after the other.
    pub fn extend(&mut self, left: &[f64], right: &[f64]) {
        self.left.extend_from_slice(left);
        self.right.extend_from_slice(right);
    }

    /// Adds the sum to a matrix given row by row.
    pub fn add_to(&self, matrix: &mut [f64]) {
        let (width, count) = (self.width, self.left.len() / self.width);
        product(
            MatMut::from_row_major_slice_mut(matrix, width, width),
            Accum::Add,
            MatRef::from_row_major_slice(&self.left, count, width).transpose(),
            MatRef::from_row_major_slice(&self.right, count, width),
            1.0,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_sums_of_outer_products() {
        let mut products = Products::new(2);
        products.push(|row| row[0] = 2.0, |row| row.copy_from_slice(&[3.0, 5.0]));
        products.extend(&[1.0, -1.0, 0.0, 4.0], &[1.0, 2.0, 0.5, 0.25]);
        let mut matrix = vec![100.0, 0.0, 0.0, 0.0];
        products.add_to(&mut matrix);
        assert_eq!(matrix, [107.0, 12.0, 1.0, -1.0]);
    }
}
