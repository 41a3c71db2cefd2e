//! What elastic discs change in the bearings: their modes move the bores.

use super::assembly::{Element, Sink};
use crate::geometry::{Vec2, quarter_turn};

/// A mode that moves one end of a bearing: its coordinate and the displacement of the bore centre per unit of
/// it.
pub(super) type BoreMode = (usize, Vec2);

/// Hands on elements of a bearing whose body, coordinates 3 and 4 of six or more, is moved by modes as well: what
/// acts on the body's place acts on a mode by its displacement of the bore.
pub(super) struct WithModes<'a> {
    pub sink: &'a mut dyn Sink,
    /// Displacements in the housing frame.
    pub modes: &'a [BoreMode],
}

/// Coordinates of the body's place among those of a bearing, and its angle.
const PLACE: [usize; 2] = [3, 4];
const ANGLE: usize = 5;

impl WithModes<'_> {
    fn index(&self, index: &[usize]) -> Vec<usize> {
        index.iter().copied().chain(self.modes.iter().map(|mode| mode.0)).collect()
    }

    fn vector(&self, vector: &[f64]) -> Vec<f64> {
        vector
            .iter()
            .copied()
            .chain(self.modes.iter().map(|(_, by)| by.x * vector[PLACE[0]] + by.y * vector[PLACE[1]]))
            .collect()
    }

    fn matrix(&self, matrix: &[f64], own: usize) -> Vec<f64> {
        let wide: Vec<Vec<f64>> = matrix.chunks_exact(own).map(|row| self.vector(row)).collect();
        let mode = |(_, by): &BoreMode| {
            wide[PLACE[0]].iter().zip(&wide[PLACE[1]]).map(|(x, y)| by.x * x + by.y * y).collect::<Vec<f64>>()
        };
        wide.iter().cloned().chain(self.modes.iter().map(mode)).flatten().collect()
    }
}

impl Sink for WithModes<'_> {
    fn element(&mut self, element: &Element<'_>) {
        if self.modes.is_empty() {
            return self.sink.element(element);
        }
        let own = element.index.len();
        let mut hessian = self.matrix(element.hessian, own);
        let width = own + self.modes.len();
        for (m, (_, by)) in self.modes.iter().enumerate() {
            // The modes' displacement turns with the disc. A force along the place is one against the
            // gradient of the bearing's displacement.
            let across = quarter_turn(*by);
            let turning = element.gradient[PLACE[0]] * across.x + element.gradient[PLACE[1]] * across.y;
            hessian[ANGLE * width + own + m] += turning;
            hessian[(own + m) * width + ANGLE] += turning;
        }
        let gradient = self.vector(element.gradient);
        self.sink.element(&Element {
            part: element.part,
            index: &self.index(element.index),
            gradient: &gradient,
            hessian: &hessian,
            stored: element.stored,
        });
    }

    fn damper(&mut self, index: &[usize], force: &[f64], matrix: &[f64], dissipation: f64) {
        if self.modes.is_empty() {
            return self.sink.damper(index, force, matrix, dissipation);
        }
        self.sink.damper(
            &self.index(index),
            &self.vector(force),
            &self.matrix(matrix, index.len()),
            dissipation,
        );
    }

    fn friction_slope(&mut self, index: &[usize], matrix: &[f64]) {
        if self.modes.is_empty() {
            return self.sink.friction_slope(index, matrix);
        }
        self.sink.friction_slope(&self.index(index), &self.matrix(matrix, index.len()));
    }
}

#[cfg(test)]
mod tests;
