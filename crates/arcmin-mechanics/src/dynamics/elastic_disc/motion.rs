//! Motion of a disc: its frame, its modes, those of the housing, its tilt.

use crate::contact::{DiscPose, DiscVelocity};
use crate::dynamics::ElasticHousing;
use crate::geometry::Vec2;

/// Motion of a disc: frame and modes.
#[derive(Clone, Copy)]
pub(in crate::dynamics) struct DiscMotion<'a> {
    pub pose: DiscPose,
    pub velocity: DiscVelocity,
    /// q in m·√kg and its rate.
    pub modes: &'a [f64],
    pub rates: &'a [f64],
    /// Motion of the pins in an elastic housing.
    pub housing: Option<HousingMotion<'a>>,
    /// Tilt of the disc, if the model includes it.
    pub tilt: Option<DiscTilt>,
}

/// Tilt of a disc relative to its pins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::dynamics) struct DiscTilt {
    /// ∂(x, y)/∂z of the disc in the frame of the ring.
    pub slope: Vec2,
    /// Distance of the two slices that represent the width from the middle: B/√12 in m.
    pub reach: f64,
}

impl DiscTilt {
    /// Contribution of the tilt to the approach (m) of the upper slice of a contact.
    pub fn skew(&self, gradient: [f64; 3]) -> f64 {
        -self.reach * (gradient[0] * self.slope.x + gradient[1] * self.slope.y)
    }

    /// Force (N, N·m) of a couple on (x, y, θ), because the contact normals rotate with the disc.
    pub(super) fn by_pose(&self, couple: f64, hessian: &[[f64; 3]; 3]) -> [f64; 3] {
        hessian.map(|row| couple * self.reach * (row[0] * self.slope.x + row[1] * self.slope.y))
    }
}

impl DiscMotion<'_> {
    /// Writes derivatives with respect to (x, y, θ) into a row over (x, y, θ, q, η), except those of q: a
    /// displacement of a pin acts like the opposite displacement of the disc.
    pub(super) fn expand(&self, disc: usize, pin: usize, by_pose: [f64; 3], row: &mut [f64]) {
        row[..3].copy_from_slice(&by_pose);
        if let Some(pins) = self.housing {
            let rows = pins.rows(disc, pin, by_pose);
            row[3 + self.modes.len()..].iter_mut().zip(rows).for_each(|(entry, value)| *entry = value);
        }
    }

    /// Number of coordinates: (x, y, θ), modes of disc and housing, slopes.
    pub(super) fn width(&self) -> usize {
        let pins = self.housing.map_or(0, |pins| pins.modes.len());
        3 + self.modes.len() + pins + if self.tilt.is_some() { 2 } else { 0 }
    }
}

/// Modes of an elastic housing, which displace its pins.
#[derive(Clone, Copy)]
pub(in crate::dynamics) struct HousingMotion<'a> {
    pub housing: &'a ElasticHousing,
    pub modes: &'a [f64],
    pub rates: &'a [f64],
}

impl HousingMotion<'_> {
    /// Derivatives with respect to the modes of a quantity with the derivatives `by_pose` with respect to (x,
    /// y, θ) of the disc: a displacement of a pin acts like the opposite displacement of the disc.
    pub fn rows(&self, disc: usize, pin: usize, by_pose: [f64; 3]) -> impl Iterator<Item = f64> + '_ {
        let shapes = self.housing.shapes(disc, pin).iter();
        shapes.map(move |shape| -(by_pose[0] * shape.x + by_pose[1] * shape.y))
    }
}
