//! Worn pins: where a contact is on its pin, and what the pin has lost there.

use super::{PinContact, PinContacts};
use crate::geometry::{DepthSample, Vec2, cross, quarter_turn};

/// ∂ψ/∂(x, y, θ) of the disc in rad/m and rad/rad: the trace's normal turns with the disc, and by −κ/(1 − κ D) per
/// length as the pin centre, at the distance D from a trace of the curvature κ, moves along it. `along` is the
/// tangent of the trace, `arm` the pin centre from the disc centre.
pub(super) fn turn_on_pin(along: Vec2, arm: Vec2, curvature: f64, distance: f64) -> [f64; 3] {
    let turning = curvature / (1.0 - curvature * distance);
    [turning * along.x, turning * along.y, 1.0 + turning * cross(arm, along)]
}

impl PinContact {
    /// ∂(gap)/∂(x, y, θ) without what a worn pin adds.
    pub(crate) fn round_gradient(&self) -> [f64; 3] {
        [-self.normal.x, -self.normal.y, -self.normal.dot(&quarter_turn(self.arm))]
    }
}

impl PinContacts {
    /// ψ in rad: from the pin's own place on the ring to the normal of the trace through the pin centre.
    pub fn pin_angle(&self, contact: &PinContact) -> f64 {
        self.pin_angle_of(contact.pin, contact.foot_normal)
    }

    fn pin_angle_of(&self, pin: usize, foot_normal: Vec2) -> f64 {
        let place = self.directions[pin];
        cross(place, foot_normal).atan2(place.dot(&foot_normal))
    }

    /// Metal lost by the pin where a contact is on it, in m.
    pub fn pin_depth(&self, contact: &PinContact) -> f64 {
        self.worn_pin(contact.pin, contact.foot_normal).map_or(0.0, |worn| worn.depth)
    }

    /// Wear of the pin where the normal of the trace leaves it, as errors of the flank are read.
    ///
    /// The normal of the worn flank differs by the slope of its relief, a few hundredths of a degree, but where the flank
    /// has worn into the shape of the pin it turns with the pin centre a hundred times as fast, and with it what the pin
    /// has lost would change in place of staying what it is about there.
    #[inline]
    pub(super) fn worn_pin(&self, pin: usize, foot_normal: Vec2) -> Option<DepthSample> {
        self.pin_relief(pin).map(|relief| relief.at(self.pin_angle_of(pin, foot_normal)))
    }
}
