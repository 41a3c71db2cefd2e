//! What wear asks of a ring of pins.

use super::ring::{DiscPose, DiscVelocity, PinContact, PinContacts};

/// One pin on its way along the flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassingPin {
    /// Index of the pin, 0…z_p−1.
    pub pin: usize,
    /// Meshing angle in rad, (−π, π].
    pub meshing_angle: f64,
    /// ψ on the pin in rad, as [`PinContacts::pin_angle`].
    pub pin_angle: f64,
    /// Normal force in N.
    pub force: f64,
    /// Relative curvature 1/R_eq in 1/m, worn flank included; 0 without force.
    pub relative_curvature: f64,
}

impl PassingPin {
    /// Of a contact of this ring.
    pub fn of(contact: &PinContact, ring: &PinContacts) -> PassingPin {
        PassingPin {
            pin: contact.pin,
            meshing_angle: contact.meshing_angle,
            pin_angle: ring.pin_angle(contact),
            force: contact.force,
            relative_curvature: if contact.force > 0.0 { contact.relative_curvature } else { 0.0 },
        }
    }
}

impl PinContacts {
    /// All pins on a rigid disc at rest, in their order. Of those that certainly have a gap nothing is needed but where
    /// they are, between which loaded ones spread what they remove: as on a nominal disc in this place, some degrees
    /// off where the trace bends most. Against the feet themselves hours of drawn machines move by 0.05 %.
    pub fn passing(&self, pose: DiscPose) -> Vec<PassingPin> {
        let pitch = std::f64::consts::TAU / self.pins.len() as f64;
        let mut passing: Vec<PassingPin> = (0..self.pins.len())
            .map(|pin| {
                let meshing_angle = self.profile.meshing_angle(pitch * pin as f64 - pose.angle);
                let pin_angle = self.profile.pin_angle(meshing_angle);
                PassingPin { pin, meshing_angle, pin_angle, force: 0.0, relative_curvature: 0.0 }
            })
            .collect();
        self.visit(pose, DiscVelocity::REST, false, |contact| {
            passing[contact.pin] = PassingPin::of(contact, self);
        });
        passing
    }
}
