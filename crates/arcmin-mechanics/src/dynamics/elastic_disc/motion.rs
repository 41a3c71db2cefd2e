//! How a disc moves: its frame, its modes, those of the housing, its tilt.

use crate::contact::{DiscPose, DiscVelocity};
use crate::dynamics::ElasticHousing;
use crate::geometry::Vec2;

/// How a disc moves: its frame and its modes.
#[derive(Clone, Copy)]
pub(in crate::dynamics) struct DiscMotion<'a> {
    pub pose: DiscPose,
    pub velocity: DiscVelocity,
    /// q in m·√kg and its rate.
    pub modes: &'a [f64],
    pub rates: &'a [f64],
    /// How the pins move in an elastic housing.
    pub housing: Option<HousingMotion<'a>>,
    /// How the disc tilts, where it may.
    pub tilt: Option<DiscTilt>,
}

/// A disc that tilts against its pins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::dynamics) struct DiscTilt {
    /// ∂(x, y)/∂z of the disc in the frame of the ring.
    pub slope: Vec2,
    /// Where the two slices that stand for the width are, over and under the middle: B/√12 in m.
    pub reach: f64,
}

impl DiscTilt {
    /// Contribution of the tilt to the approach (m) of the upper slice of a contact.
    pub fn skew(&self, gradient: [f64; 3]) -> f64 {
        -self.reach * (gradient[0] * self.slope.x + gradient[1] * self.slope.y)
    }

    /// Force (N, N·m) of a couple on (x, y, θ): the normals by which it presses turn with the disc.
    pub(super) fn by_pose(&self, couple: f64, hessian: &[[f64; 3]; 3]) -> [f64; 3] {
        hessian.map(|row| couple * self.reach * (row[0] * self.slope.x + row[1] * self.slope.y))
    }
}

impl DiscMotion<'_> {
    /// Writes derivatives with respect to (x, y, θ), modes of the disc aside, into a row over (x, y, θ, q, η): a pin
    /// that moves is a disc that moves the other way.
    pub(super) fn expand(&self, disc: usize, pin: usize, by_pose: [f64; 3], row: &mut [f64]) {
        row[..3].copy_from_slice(&by_pose);
        if let Some(pins) = self.housing {
            let ways = pins.rows(disc, pin, by_pose);
            row[3 + self.modes.len()..].iter_mut().zip(ways).for_each(|(entry, way)| *entry = way);
        }
    }

    /// Number of coordinates: (x, y, θ), modes of disc and housing, slopes.
    pub(super) fn width(&self) -> usize {
        let pins = self.housing.map_or(0, |pins| pins.modes.len());
        3 + self.modes.len() + pins + if self.tilt.is_some() { 2 } else { 0 }
    }
}

/// Modes of an elastic housing, which move its pins.
#[derive(Clone, Copy)]
pub(in crate::dynamics) struct HousingMotion<'a> {
    pub housing: &'a ElasticHousing,
    pub modes: &'a [f64],
    pub rates: &'a [f64],
}

impl HousingMotion<'_> {
    /// Derivatives with respect to the modes of what has the derivatives `by_pose` with respect to (x, y, θ)
    /// of the disc: a pin that moves is a disc that moves the other way.
    pub fn rows(&self, disc: usize, pin: usize, by_pose: [f64; 3]) -> impl Iterator<Item = f64> + '_ {
        let shapes = self.housing.shapes(disc, pin).iter();
        shapes.map(move |shape| -(by_pose[0] * shape.x + by_pose[1] * shape.y))
    }
}
