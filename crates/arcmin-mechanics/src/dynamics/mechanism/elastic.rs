//! Effect of elastic bodies on the bearings: their coordinates displace the bores and deform their rims.

use smallvec::SmallVec;

use super::assembly::Sink;
use crate::fem::BoreMotion;
use crate::fem::carrier::RIM_COORDINATES;
use crate::geometry::Vec2;

/// A coordinate of a body that displaces the bore of a bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoreMode {
    /// Number of the coordinate.
    pub at: usize,
    /// Displacement of the bore centre per unit of the coordinate.
    pub by: Vec2,
    /// Ovalisation of the rim per unit of the coordinate.
    pub rim: [f64; RIM_COORDINATES],
    /// Whether that displacement rotates with the body or is fixed in space.
    pub turns: bool,
}

impl BoreMode {
    /// A mode of the body itself.
    pub fn of_body(at: usize, motion: BoreMotion) -> BoreMode {
        BoreMode { at, by: motion.centre, rim: motion.rim, turns: true }
    }

    /// One coordinate of a seat (`fem::carrier::SEAT_COORDINATES`).
    pub fn of_seat(axis: usize, at: usize) -> BoreMode {
        let one = |a: usize| if a == axis { 1.0 } else { 0.0 };
        let motion =
            BoreMotion { centre: Vec2::new(one(0), one(1)), rim: std::array::from_fn(|r| one(2 + r)) };
        BoreMode::of_body(at, motion)
    }
}

/// Extends dampers of a bearing by the modes of its body (coordinates 3 and 4 of six): a force on the body's
/// position acts on a mode by the modal displacement of the bore.
pub(in crate::dynamics) struct WithModes<'a> {
    pub sink: &'a mut dyn Sink,
    /// Displacements in the housing frame.
    pub modes: &'a [BoreMode],
}

/// Coordinates of the position of the body with bores or holes among those of a joint, after those of the other body.
const PLACE: [usize; 2] = [3, 4];

/// Derivatives with respect to modes that displace a bore by these vectors, from those with respect to both bodies: a
/// displacement of the bore acts like one of its body.
pub(in crate::dynamics) fn along_displacements(
    row: &[f64],
    displacements: impl Iterator<Item = Vec2>,
) -> impl Iterator<Item = f64> {
    let [x, y] = PLACE.map(|at| row[at]);
    displacements.map(move |displacement| displacement.x * x + displacement.y * y)
}

/// Adds a matrix over the `own` coordinates of a joint to one over these and the modes.
pub(in crate::dynamics) fn add_with_modes(
    matrix: &[f64],
    own: usize,
    displacements: impl Iterator<Item = Vec2> + Clone,
    into: &mut [f64],
) {
    let width = own + displacements.clone().count();
    let mut add = |at: usize, row: &[f64]| {
        let (bodies, modes) = into[at * width..][..width].split_at_mut(own);
        bodies.iter_mut().zip(row).for_each(|(sum, entry)| *sum += entry);
        modes
            .iter_mut()
            .zip(along_displacements(row, displacements.clone()))
            .for_each(|(sum, entry)| *sum += entry);
    };
    matrix.chunks_exact(own).enumerate().for_each(|(at, row)| add(at, row));
    let [x, y] = PLACE.map(|at| &matrix[at * own..][..own]);
    for (mode, displacement) in displacements.clone().enumerate() {
        let row: SmallVec<[f64; 10]> =
            x.iter().zip(y).map(|(x, y)| displacement.x * x + displacement.y * y).collect();
        add(own + mode, &row);
    }
}

impl WithModes<'_> {
    fn index(&self, index: &[usize]) -> Vec<usize> {
        index.iter().copied().chain(self.modes.iter().map(|mode| mode.at)).collect()
    }

    fn displacements(&self) -> impl Iterator<Item = Vec2> + Clone + '_ {
        self.modes.iter().map(|mode| mode.by)
    }

    pub fn damper(&mut self, index: &[usize], force: &[f64], matrix: &[f64], dissipation: f64) {
        if self.modes.is_empty() {
            return self.sink.damper(index, force, matrix, dissipation);
        }
        let (own, width) = (index.len(), index.len() + self.modes.len());
        let mut wide = vec![0.0; if self.sink.takes_damping() { width * width } else { 0 }];
        if self.sink.takes_damping() {
            add_with_modes(matrix, own, self.displacements(), &mut wide);
        }
        let force: Vec<f64> =
            force.iter().copied().chain(along_displacements(force, self.displacements())).collect();
        self.sink.damper(&self.index(index), &force, &wide, dissipation);
    }
}
