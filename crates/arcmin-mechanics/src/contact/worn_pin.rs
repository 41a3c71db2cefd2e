//! Worn pins: position of a contact on its pin, and depth of wear there.

use super::{PinContact, PinContacts};
use crate::geometry::{DepthSample, Vec2, cross, quarter_turn};

/// ∂ψ/∂(x, y, θ) of the disc in rad/m and rad/rad: the normal of the trace turns with the disc, and by −κ/(1 − κ D)
/// per displacement of the pin centre along the trace, at the distance D from a trace of curvature κ. `along` is the
/// tangent of the trace, `arm` the pin centre relative to the disc centre.
pub(super) fn turn_on_pin(along: Vec2, arm: Vec2, curvature: f64, distance: f64) -> [f64; 3] {
    let turning = curvature / (1.0 - curvature * distance);
    [turning * along.x, turning * along.y, 1.0 + turning * cross(arm, along)]
}

impl PinContact {
    /// ∂(gap)/∂(x, y, θ) without the term of pin wear.
    pub(crate) fn round_gradient(&self) -> [f64; 3] {
        [-self.normal.x, -self.normal.y, -self.normal.dot(&quarter_turn(self.arm))]
    }
}

impl PinContacts {
    /// ψ in rad: from the radius of the ring through the pin to the normal of the trace through the pin centre.
    pub fn pin_angle(&self, contact: &PinContact) -> f64 {
        self.pin_angle_of(contact.pin, contact.foot_normal)
    }

    fn pin_angle_of(&self, pin: usize, foot_normal: Vec2) -> f64 {
        let place = self.directions[pin];
        cross(place, foot_normal).atan2(place.dot(&foot_normal))
    }

    /// Wear depth of the pin at the contact, in m.
    pub fn pin_depth(&self, contact: &PinContact) -> f64 {
        self.worn_pin(contact.pin, contact.foot_normal).map_or(0.0, |worn| worn.depth)
    }

    /// Wear of the pin at the normal of the trace; flank errors are evaluated there too.
    ///
    /// The normal of the worn flank differs by the slope of its relief, a few hundredths of a degree. Where the flank
    /// has worn to nearly the shape of the pin, however, it turns with the pin centre a hundred times as fast, and
    /// the depth of pin wear would vary although it is nearly constant there.
    #[inline]
    pub(super) fn worn_pin(&self, pin: usize, foot_normal: Vec2) -> Option<DepthSample> {
        self.pin_relief(pin).map(|relief| relief.at(self.pin_angle_of(pin, foot_normal)))
    }
}
