//! Effect of elastic bodies on the bearings: their coordinates displace the bores and deform their rims.

use super::assembly::Sink;
use crate::fem::BoreWay;
use crate::fem::carrier::RIM_WAYS;
use crate::geometry::Vec2;

/// A coordinate of a body that displaces the bore of a bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoreMode {
    /// Number of the coordinate.
    pub at: usize,
    /// Displacement of the bore centre per unit of the coordinate.
    pub by: Vec2,
    /// Ovalisation of the rim per unit of the coordinate.
    pub rim: [f64; RIM_WAYS],
    /// Whether that displacement rotates with the body or is fixed in space.
    pub turns: bool,
}

impl BoreMode {
    /// A mode of the body itself.
    pub fn of_body(at: usize, way: BoreWay) -> BoreMode {
        BoreMode { at, by: way.centre, rim: way.rim, turns: true }
    }

    /// One coordinate of a seat (`fem::carrier::SEAT_COORDINATES`).
    pub fn of_seat(axis: usize, at: usize) -> BoreMode {
        let one = |a: usize| if a == axis { 1.0 } else { 0.0 };
        let way = BoreWay { centre: Vec2::new(one(0), one(1)), rim: std::array::from_fn(|r| one(2 + r)) };
        BoreMode::of_body(at, way)
    }
}

/// Passes on dampers of a bearing whose body (coordinates 3 and 4 of six) also has modes: a force on the body's
/// position acts on a mode by its displacement of the bore.
pub(in crate::dynamics) struct WithModes<'a> {
    pub sink: &'a mut dyn Sink,
    /// Displacements in the housing frame.
    pub modes: &'a [BoreMode],
}

/// Coordinates of the body's position among those of a bearing.
const PLACE: [usize; 2] = [3, 4];

impl WithModes<'_> {
    fn index(&self, index: &[usize]) -> Vec<usize> {
        index.iter().copied().chain(self.modes.iter().map(|mode| mode.at)).collect()
    }

    fn vector(&self, vector: &[f64]) -> Vec<f64> {
        vector
            .iter()
            .copied()
            .chain(
                self.modes
                    .iter()
                    .map(|BoreMode { by, .. }| by.x * vector[PLACE[0]] + by.y * vector[PLACE[1]]),
            )
            .collect()
    }

    /// One contiguous vector, row by row: it is needed for every bearing in every evaluation.
    fn matrix(&self, matrix: &[f64], own: usize) -> Vec<f64> {
        let width = own + self.modes.len();
        let mut wide = vec![0.0; width * width];
        for (into, row) in wide.chunks_exact_mut(width).zip(matrix.chunks_exact(own)) {
            into[..own].copy_from_slice(row);
            for (entry, BoreMode { by, .. }) in into[own..].iter_mut().zip(self.modes) {
                *entry = by.x * row[PLACE[0]] + by.y * row[PLACE[1]];
            }
        }
        let (of_body, of_modes) = wide.split_at_mut(own * width);
        let [x, y] = PLACE.map(|at| &of_body[at * width..][..width]);
        for (into, BoreMode { by, .. }) in of_modes.chunks_exact_mut(width).zip(self.modes) {
            into.iter_mut().zip(x.iter().zip(y)).for_each(|(entry, (x, y))| *entry = by.x * x + by.y * y);
        }
        wide
    }
}

impl WithModes<'_> {
    pub fn damper(&mut self, index: &[usize], force: &[f64], matrix: &[f64], dissipation: f64) {
        if self.modes.is_empty() {
            return self.sink.damper(index, force, matrix, dissipation);
        }
        let matrix = if self.sink.takes_damping() { self.matrix(matrix, index.len()) } else { Vec::new() };
        self.sink.damper(&self.index(index), &self.vector(force), &matrix, dissipation);
    }
}
