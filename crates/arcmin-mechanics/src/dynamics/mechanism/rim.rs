//! Outer raceways that are ovalised by their rollers.

use crate::fem::carrier::{RIM_COORDINATES, RIM_ORDER};
use crate::geometry::{Vec2, turned, unit};

/// Coordinates of a rim: expansion, then cosine and sine of the orders 2 to [`RIM_ORDER`].
pub(in crate::dynamics) const RIM: usize = RIM_COORDINATES;

/// A rim at one state: w(ψ) = w₀ + Σ_n a_n cos n(ψ − χ) + b_n sin n(ψ − χ) outward, in m, with the angle χ of
/// its origin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(in crate::dynamics) struct OutOfRound {
    pub angle: f64,
    pub amplitudes: [f64; RIM],
}

impl OutOfRound {
    /// Shape functions in the direction e(ψ − χ) with their first and second derivatives.
    #[inline]
    pub(in crate::dynamics) fn shapes(direction: Vec2) -> [[f64; RIM]; 3] {
        let mut shapes = [[0.0; RIM]; 3];
        shapes[0][0] = 1.0;
        let mut multiple = direction;
        for order in 2..=RIM_ORDER {
            let n = order as f64;
            multiple = turned(multiple, direction);
            let (sin, cos) = (multiple.y, multiple.x);
            let at = 2 * order - 3;
            (shapes[0][at], shapes[0][at + 1]) = (cos, sin);
            (shapes[1][at], shapes[1][at + 1]) = (-n * sin, n * cos);
            (shapes[2][at], shapes[2][at + 1]) = (-n * n * cos, -n * n * sin);
        }
        shapes
    }

    #[inline]
    pub(in crate::dynamics) fn sum(&self, shapes: &[f64; RIM]) -> f64 {
        self.amplitudes.iter().zip(shapes).map(|(amplitude, shape)| amplitude * shape).sum()
    }

    /// w at ψ in m.
    pub fn at(&self, angle: f64) -> f64 {
        self.sum(&OutOfRound::shapes(unit(angle - self.angle))[0])
    }
}
