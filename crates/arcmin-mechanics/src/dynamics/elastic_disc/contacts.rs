//! Search of the contacts on a flank that is displaced by modes and contact forces.

use super::{DiscMotion, ElasticDiscs};
use crate::contact::{Displacements, PinContact, PinContacts};
use crate::fem::{CoupledContact, CoupledForces, FlankCompliance};

/// Contacts of one disc at one state.
#[derive(Default)]
pub(in crate::dynamics) struct DiscContacts {
    /// As on the rigid disc; force and stiffness are not valid.
    pub contacts: Vec<PinContact>,
    /// Rate of s in m/s.
    pub rate: Vec<f64>,
    /// φ_i of the modes, contact by contact.
    pub shape: Vec<f64>,
    pub coupled: Vec<CoupledContact>,
    pub forces: CoupledForces,
    /// Other open contacts with a gap below the requested one, with their mode shapes.
    pub near: Vec<PinContact>,
    pub near_shapes: Vec<f64>,
    pub near_coupled: Vec<CoupledContact>,
}

impl DiscContacts {
    /// With memory for a number of contacts on a disc with a number of modes.
    fn with_room(contacts: usize, modes: usize) -> DiscContacts {
        DiscContacts {
            contacts: Vec::with_capacity(contacts),
            rate: Vec::with_capacity(contacts),
            shape: Vec::with_capacity(contacts * modes),
            coupled: Vec::with_capacity(contacts),
            ..DiscContacts::default()
        }
    }

    fn push(&mut self, contact: PinContact, rate: f64, shape: &[f64], coupled: CoupledContact) {
        self.contacts.push(contact);
        self.rate.push(rate);
        self.shape.extend_from_slice(shape);
        self.coupled.push(coupled);
    }

    fn keep_near(&mut self, near: DiscContacts, reach: f64) {
        for (i, contact) in near.contacts.iter().enumerate() {
            let is_among = self.contacts.iter().any(|c| c.pin == contact.pin);
            if -near.coupled[i].deepest() < reach && !is_among {
                self.near.push(*contact);
                self.near_shapes.extend_from_slice(near.shape_of(i));
                self.near_coupled.push(near.coupled[i]);
            }
        }
    }

    fn shape_of(&self, contact: usize) -> &[f64] {
        let count = self.shape.len() / self.contacts.len();
        &self.shape[contact * count..(contact + 1) * count]
    }

    /// Displacement (m) of a place that is not one of the contacts.
    pub fn bent_at(&self, compliance: &FlankCompliance, at: &CoupledContact) -> f64 {
        self.bent(compliance, self.contacts.len(), at)
    }

    /// Displacement (m) of a place under the forces of the first `count` contacts.
    fn bent(&self, compliance: &FlankCompliance, count: usize, at: &CoupledContact) -> f64 {
        let forces = self.forces.force[..count].iter().zip(&self.coupled);
        forces.map(|(force, contact)| force * compliance.cross(&at.place, &contact.place)).sum()
    }
}

/// A pin with a larger gap (m) on the flank displaced by the modes is examined again with the displacement by
/// the contact forces.
const NEAR: f64 = 1e-6;
/// Search range of pins in m, added to the displacement of the flank by modes and forces.
pub(super) const REACH: f64 = 5e-6;

impl ElasticDiscs {
    /// Contacts that are loaded or nearly closed, with their coupled forces; `ring` has been
    /// [prepared](ElasticDiscs::prepare_ring). All loaded pins are found, for any displacement of the flank by
    /// modes and forces.
    pub(in crate::dynamics) fn contacts(
        &self,
        disc: usize,
        ring: &PinContacts,
        motion: DiscMotion<'_>,
        reach: f64,
    ) -> DiscContacts {
        let body = &self.bodies[disc];
        let by_modes: f64 = motion.modes.iter().zip(&body.peaks).map(|(q, peak)| q.abs() * peak).sum();
        let mut by_forces = 0.0;
        loop {
            let state = self.contacts_within(disc, ring, motion, by_modes + by_forces, reach);
            let needed = body.largest_lift * state.forces.force.iter().sum::<f64>();
            // NaN forces end the loop; the caller rejects them.
            if !(needed > by_forces + ring.reach()) {
                return state;
            }
            by_forces = 2.0 * needed;
        }
    }

    /// The same among the pins that a flank displaced by at most `lift` (m) and `REACH` may touch.
    fn contacts_within(
        &self,
        disc: usize,
        ring: &PinContacts,
        motion: DiscMotion<'_>,
        lift: f64,
        reach: f64,
    ) -> DiscContacts {
        let body = &self.bodies[disc];
        let room = || DiscContacts::with_room(ring.pins().len(), motion.modes.len());
        let (mut state, mut near) = (room(), room());
        let (shifts, speeds) = motion.housing.map_or_else(Default::default, |pins| {
            (
                pins.housing.pin_displacements(disc, pins.modes),
                pins.housing.pin_displacements(disc, pins.rates),
            )
        });
        let moved = Displacements { shifts: &shifts, lift: lift.max(reach) };
        let mut shape = vec![0.0; motion.modes.len()];
        ring.visit_displaced(motion.pose, motion.velocity, false, moved, |contact| {
            let place = self.discs.stencil(disc, contact.tau);
            let (mut approach, mut rate) = (-contact.gap, contact.approach_rate);
            if let Some(speed) = speeds.get(contact.pin) {
                rate += contact.gradient[0] * speed.x + contact.gradient[1] * speed.y;
            }
            for (m, phi) in shape.iter_mut().enumerate() {
                *phi = body.modes.at(m, &place);
                approach -= *phi * motion.modes[m];
                rate -= *phi * motion.rates[m];
            }
            let equivalent_radius = 1.0 / contact.designed_curvature;
            let skew = motion.tilt.map_or(0.0, |tilt| tilt.skew(contact.gradient));
            let coupled = CoupledContact { place, approach, equivalent_radius, skew };
            let near = if coupled.deepest() < -NEAR { &mut near } else { &mut state };
            near.push(*contact, rate, &shape, coupled);
        });
        loop {
            // If this iteration does not converge, its residual remains in the Newton iteration of the time
            // step, which rejects the step.
            state.forces.solve(ring.contact(), &body.residual, &state.coupled);
            let lift = body.largest_lift * state.forces.force.iter().sum::<f64>();
            let before = state.contacts.len();
            for (i, contact) in near.coupled.iter().enumerate() {
                let known = || state.contacts.iter().any(|c| c.pin == near.contacts[i].pin);
                if contact.deepest() + lift > 0.0
                    && contact.deepest() > state.bent(&body.residual, before, contact)
                    && !known()
                {
                    state.push(near.contacts[i], near.rate[i], near.shape_of(i), *contact);
                }
            }
            if state.contacts.len() == before {
                if reach > 0.0 {
                    state.keep_near(near, reach);
                }
                return state;
            }
        }
    }
}
