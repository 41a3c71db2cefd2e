//! Contributions to the gaps between pins and flank.

use super::PinRing;
use crate::contact::{DiscPose, DiscVelocity, PinContact, PinContacts};
use crate::dynamics::mechanism::Cause;
use crate::dynamics::mechanism::joints::{Nominal, State};
use crate::geometry::{Relief, Vec2, unit};

/// Designed relief of the flank, which is distinguished from wear and errors.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct Designed {
    pub relief: Relief,
    /// Offsets of the flank in m.
    pub equidistant: f64,
    pub radial: f64,
}

/// The unworn contacts of a disc in the same pose, its displacement (x, y, θ) from the nominal position, and
/// those of its pins, if any.
struct UnwornContacts<'a> {
    ring: &'a PinContacts,
    unworn: Vec<PinContact>,
    moved: [f64; 3],
    pins: Vec<Vec2>,
}

impl UnwornContacts<'_> {
    /// Change of a gap on the displacement of disc and pin back to the nominal position.
    fn change_to_nominal(&self, pin: usize, gradient: [f64; 3]) -> f64 {
        let mut moved = self.moved;
        if let Some(shift) = self.pins.get(pin) {
            moved[0] -= shift.x;
            moved[1] -= shift.y;
        }
        -gradient.iter().zip(&moved).map(|(g, d)| g * d).sum::<f64>()
    }

    /// Gap in m of the unworn surfaces in the nominal position, extrapolated along its tangent.
    fn unworn_gap(&self, contact: &PinContact) -> f64 {
        let unworn = &self.unworn[contact.pin];
        unworn.gap + self.change_to_nominal(contact.pin, unworn.gradient)
    }

    /// Wear depth of the flank and of the pin in m, extrapolated in the same way.
    fn of(&self, contact: &PinContact) -> [f64; 2] {
        let round = contact.round_gradient();
        let pin = self.ring.pin_depth(contact);
        let turned = std::array::from_fn(|i| contact.gradient[i] - round[i]);
        let worn_pin = pin + self.change_to_nominal(contact.pin, turned);
        [contact.gap - pin + self.change_to_nominal(contact.pin, round) - self.unworn_gap(contact), worn_pin]
    }
}

impl PinRing {
    /// Work of the pins' forces on their gaps and elastic approaches, by cause. The displacements of the two
    /// slices of a tilted disc differ, so that the gap of each is extrapolated separately; for an elastic disc
    /// the tilt affects the approach only.
    pub(super) fn work_of_gaps(&self, at: State<'_>, nominal: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        let slices: Vec<UnwornContacts<'_>> = match &self.elastic {
            Some(_) => vec![self.unworn_contacts(at, self.disc_state(at).0, nominal)],
            None => {
                self.slices(at).iter().map(|slice| self.unworn_contacts(at, slice.pose, nominal)).collect()
            }
        };
        let profile = self.contacts.profile();
        let k1 = profile.short_width_coefficient();
        let (circle, radius) = (
            profile.pin_circle_radius - self.designed.radial,
            profile.pin_radius - self.designed.equidistant,
        );
        let pins = self.contacts.pins();
        self.visit_loaded(at, |slice, contact, force, work| {
            let lost = &slices[slice];
            add(Cause::ELASTIC, work);
            let [flank, pin] = lost.of(contact);
            add(Cause::FLANK_WEAR, force * flank);
            add(Cause::PIN_WEAR, force * pin);
            let cos = contact.meshing_angle.cos();
            let offsets = self.designed.equidistant
                - self.designed.radial * (1.0 - k1 * cos) / profile.speed_factor(cos);
            let modification = self.designed.relief.at(contact.meshing_angle).depth + offsets;
            add(Cause::FLANK_MODIFICATION, force * modification);
            let mut made = 0.0;
            if nominal.has_errors {
                let pin = &pins[contact.pin];
                let moved = pin.centre
                    - circle * unit(std::f64::consts::TAU * contact.pin as f64 / pins.len() as f64);
                let error = self.contacts.flank_error_depth(contact);
                made = contact.normal.dot(&moved) + radius - pin.radius + error;
                add(Cause::MANUFACTURING_ERRORS, force * made);
            }
            add(Cause::CURVATURE, force * (lost.unworn_gap(contact) - modification - made));
        });
    }

    /// Wear of flank and pins in the nominal position of the disc, extrapolated from its present position along
    /// the tangents of the gaps.
    fn unworn_contacts(&self, at: State<'_>, pose: DiscPose, nominal: Nominal<'_>) -> UnwornContacts<'_> {
        let rest = vec![0.0; nominal.q.len()];
        let (from, _) = self.disc_state(State { q: nominal.q, v: &rest });
        let pins = self.pin_displacements(at.q);
        let mut unworn = self.contacts.clone();
        unworn.set_relief(self.designed.relief.clone());
        unworn.set_pin_relief(Relief::uniform(0.0));
        let moved = pose.centre - from.centre;
        UnwornContacts {
            ring: &self.contacts,
            unworn: unworn.displaced_contacts(pose, DiscVelocity::REST, &pins),
            moved: [moved.x, moved.y, pose.angle - from.angle],
            pins,
        }
    }
}
