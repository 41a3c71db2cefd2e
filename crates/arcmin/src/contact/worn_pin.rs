//! Worn pins: where a contact is on its pin, and what the pin has lost there.

use super::{PinContact, PinContacts};
use crate::geometry::{DepthSample, Vec2, cross, quarter_turn};

/// ∂ψ/∂(x, y, θ) of the disc in rad/m and rad/rad: the flank's normal turns with the disc, and by −κ/(1 − κ
/// D) per length as the pin centre, at the distance D from a flank of the curvature κ, moves along it.
/// `along` is the flank's tangent, `arm` the pin centre from the disc centre.
pub(super) fn turn_on_pin(along: Vec2, arm: Vec2, flank_curvature: f64, distance: f64) -> [f64; 3] {
    let turning = flank_curvature / (1.0 - flank_curvature * distance);
    [turning * along.x, turning * along.y, 1.0 + turning * cross(arm, along)]
}

impl PinContact {
    /// ∂(gap)/∂(x, y, θ) without what a worn pin adds.
    pub(crate) fn round_gradient(&self) -> [f64; 3] {
        [-self.normal.x, -self.normal.y, -self.normal.dot(&quarter_turn(self.arm))]
    }
}

impl PinContacts {
    /// ψ in rad: from the pin's own place on the ring to the line from the flank through the pin centre.
    pub fn pin_angle(&self, contact: &PinContact) -> f64 {
        self.pin_angle_of(contact.pin, contact.normal)
    }

    fn pin_angle_of(&self, pin: usize, normal: Vec2) -> f64 {
        let place = self.directions[pin];
        cross(place, normal).atan2(place.dot(&normal))
    }

    /// Metal lost by the pin where a contact's line of action leaves it, in m.
    pub fn pin_depth(&self, contact: &PinContact) -> f64 {
        self.worn_pin(contact.pin, contact.normal).map_or(0.0, |worn| worn.depth)
    }

    /// What the pin has lost where the flank's normal leaves it.
    ///
    /// The gap grows by the depth there, and so its gradient by the slope times the turn of the normal. The
    /// closest point itself stays that of a round pin: the pin hardly wears but at the edge of its zone,
    /// where two contacts could stand side by side and the closest point would jump between them.
    #[inline]
    pub(super) fn worn_pin(&self, pin: usize, normal: Vec2) -> Option<DepthSample> {
        self.pin_relief(pin).map(|relief| relief.at(self.pin_angle_of(pin, normal)))
    }
}
