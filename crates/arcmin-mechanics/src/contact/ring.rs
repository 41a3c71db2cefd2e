use std::sync::Arc;

use super::facets::{Facets, MeshContact};
use super::rolling::EnergyTerms;
use super::sliding::Sliding;
use super::spring::ContactSpring;
use super::{Damping, Displacements, LineContact, PinContact};
use crate::geometry::{ErrorFloors, FlankError, FlankErrorReader, Profile, Relief, Vec2, WornOffset, unit};

/// One installed pin, in the housing frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pin {
    /// Centre in m, errors included.
    pub centre: Vec2,
    /// Radius in m, errors included.
    pub radius: f64,
}

/// Place of a disc in the housing frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiscPose {
    /// Centre in m.
    pub centre: Vec2,
    /// Rotation of the flank, θ_j, in rad: 0 puts the lobe root of τ = 0 on the x axis.
    pub angle: f64,
}

/// Rates of a [`DiscPose`] in m/s and rad/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiscVelocity {
    /// Velocity of the disc's centre in the frame of the housing, m/s.
    pub centre: Vec2,
    /// Angular velocity of the flank, rad/s, counter-clockwise positive.
    pub angle: f64,
}

impl DiscVelocity {
    /// All rates zero.
    pub const REST: DiscVelocity = DiscVelocity { centre: Vec2::new(0.0, 0.0), angle: 0.0 };

    pub(super) fn as_array(&self) -> [f64; 3] {
        [self.centre.x, self.centre.y, self.angle]
    }
}

/// Sum of the contact forces on one disc, about its centre, with its tangents.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reaction {
    /// (F_x, F_y, M) on the disc in N, N, N·m.
    pub force: [f64; 3],
    /// −∂(F_x, F_y, M)/∂(x, y, θ).
    pub stiffness: [[f64; 3]; 3],
    /// −∂(F_x, F_y, M)/∂(ẋ, ẏ, θ̇).
    pub damping: [[f64; 3]; 3],
    /// Elastic energy in J.
    pub stored: f64,
    /// Power lost in contact damping and friction in W.
    pub dissipation: f64,
    /// Largest ratio of closing speed to gap (plus [`TOLERABLE_DEPTH`]) among the open contacts, in 1/s.
    pub onset_rate: f64,
}

/// Depth in m that is added to the gap where [`Reaction::onset_rate`] bounds the time step: an open contact may close by
/// this penetration within one step.
pub const TOLERABLE_DEPTH: f64 = 5e-8;

/// All pins against one disc.
#[derive(Debug, Clone)]
pub struct PinContacts {
    pub(super) profile: Profile,
    pub(super) pins: Vec<Pin>,
    /// e(2π i / z_p): directions of the nominal pin places, where every foot search starts.
    pub(super) directions: Vec<Vec2>,
    pub(super) relief: Relief,
    /// The relief that a pin can follow: narrow hollows are filled (`Relief::without_hollows`).
    pub(super) effective_relief: Relief,
    /// Metal lost by the pins as a function of the angle ψ on the pin: none, one for all pins, or one for
    /// each.
    pub(super) pin_reliefs: Vec<Relief>,
    /// Errors of this disc's flank around its circumference, if any.
    pub(super) flank_error: Option<FlankError>,
    /// The same, ready to be read.
    pub(super) error_reader: Option<FlankErrorReader>,
    /// Lower bounds of the depth of the flank error in m, by sectors.
    pub(super) error_floors: Option<ErrorFloors>,
    pub(super) least_error: f64,
    /// Lower bound of the wear depth of the pins, in m.
    pub(super) shallowest_pin: f64,
    /// Offset of the flank from the trace; shared by copies of a mechanism.
    pub(super) offset: Arc<WornOffset>,
    pub(super) contact: LineContact,
    pub(super) sliding: Option<Sliding>,
    pub(super) conservative: bool,
    /// Pins with a smaller gap than this (m) are always evaluated.
    pub(super) reach: f64,
    /// Straight edges that replace the flank; `None` for the smooth flank.
    pub(super) facets: Option<Facets>,
}

/// Bound from below of a spline (m), which may undershoot its samples by half their range.
fn undershoot(relief: &Relief) -> f64 {
    let ends = |(low, high): (f64, f64), depth: &f64| (low.min(*depth), high.max(*depth));
    let (low, high) = relief.samples().iter().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
    low - 0.5 * (high - low)
}

impl PinContacts {
    /// Contacts of a flank as cut with the pins of a ring; `relief` is metal removed from the flank along its
    /// normals, m. Pins are not worn and the flank has no error.
    pub fn new(profile: Profile, pins: Vec<Pin>, relief: Relief, contact: LineContact) -> PinContacts {
        let count = profile.pin_count as f64;
        let directions = (0..pins.len()).map(|i| unit(std::f64::consts::TAU * i as f64 / count)).collect();
        let offset = Arc::new(WornOffset::of(&profile));
        let mut contacts = PinContacts {
            profile,
            pins,
            directions,
            relief: Relief::uniform(0.0),
            effective_relief: Relief::uniform(0.0),
            pin_reliefs: Vec::new(),
            flank_error: None,
            error_reader: None,
            error_floors: None,
            least_error: 0.0,
            shallowest_pin: 0.0,
            offset,
            contact,
            sliding: None,
            conservative: false,
            reach: 1e-6,
            facets: None,
        };
        contacts.set_relief(relief);
        contacts
    }

    /// Flank as cut, before any relief.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Places and installed radii of the pins.
    pub fn pins(&self) -> &[Pin] {
        &self.pins
    }

    /// Force law of one pin against the flank.
    pub fn contact(&self) -> &LineContact {
        &self.contact
    }

    /// Metal removed from the flank by design and wear, m over the meshing angle.
    pub fn relief(&self) -> &Relief {
        &self.relief
    }

    /// Replaces the metal removed from the flanks (modifications and wear together).
    pub fn set_relief(&mut self, relief: Relief) {
        let radius = self.pins.iter().map(|pin| pin.radius).fold(0.0, f64::max);
        self.effective_relief =
            relief.without_hollows(&self.profile, radius).unwrap_or_else(|| relief.clone());
        self.relief = relief;
        self.facets = self.facets.take().map(|facets| facets.with_relief(&self.profile, &self.relief));
        self.offset = Arc::new(self.offset.with(&self.profile, &self.effective_relief));
    }

    /// Replaces the flank by straight edges, as in a mesh of linear elements with nodes at the given τ (rad). Such
    /// contacts have R_eq = r_p, that of a pin on a plane. Pin wear and flank errors act as on the smooth flank.
    pub fn set_facets(&mut self, contact: MeshContact, nodes: Vec<f64>) {
        self.facets = Some(Facets::new(contact, nodes, &self.profile, &self.relief));
    }

    pub(super) fn is_faceted(&self) -> bool {
        self.facets.is_some()
    }

    /// Replaces the depth removed from every pin, as a function of the pin angle ψ (rad): the angle from the radius
    /// of the ring through the pin to the flank normal, 0 where the pin faces the centre of the ring.
    pub fn set_pin_relief(&mut self, relief: Relief) {
        self.pin_reliefs = if relief.is_zero() { Vec::new() } else { vec![relief] };
        self.update_bound_of_pins();
    }

    /// The same with one function for each pin.
    pub fn set_pin_reliefs(&mut self, reliefs: Vec<Relief>) {
        debug_assert_eq!(reliefs.len(), self.pins.len());
        self.pin_reliefs = if reliefs.iter().all(Relief::is_zero) { Vec::new() } else { reliefs };
        self.update_bound_of_pins();
    }

    /// Replaces the errors of this disc's flank around its circumference. Their slope along the flank does not turn
    /// the normal: an amplitude of 10 µm at order z_c tilts it by some mrad, which changes the gap in second order
    /// only.
    pub fn set_flank_error(&mut self, error: FlankError) {
        self.flank_error = (!error.is_zero()).then_some(error);
        self.error_reader = self.flank_error.as_ref().map(FlankErrorReader::new);
        self.error_floors = self.flank_error.as_ref().map(|error| error.floors(&self.profile));
        self.least_error = self.flank_error.as_ref().map_or(0.0, FlankError::shallowest);
    }

    /// Sets the damping of every contact; none at first.
    pub fn set_damping(&mut self, damping: Option<Damping>) {
        self.contact.damping = damping;
    }

    /// Sets the contact law and the reach for an elastic disc: `reach` is the distance (m) by which its flank may
    /// move towards a pin in addition to [`Displacements::lift`](super::Displacements).
    pub(crate) fn set_elastic(&mut self, law: LineContact, reach: f64) {
        (self.contact, self.reach) = (law, reach);
    }

    /// Pins with a gap (m) below this value plus [`Displacements::lift`](super::Displacements) are evaluated.
    pub(crate) fn reach(&self) -> f64 {
        self.reach
    }

    /// Whether reactions include the terms by which they are the gradient of the stored energy
    /// ([`Rolling`](super::Rolling)), about 2.5e-4 of the rated torque; initially not. Without them a mechanism gains
    /// or loses energy over each turn.
    pub fn set_conservative(&mut self, conservative: bool) {
        self.conservative = conservative;
    }

    #[inline]
    pub(super) fn pin_relief(&self, pin: usize) -> Option<&Relief> {
        match self.pin_reliefs.as_slice() {
            [] => None,
            [all] => Some(all),
            each => each.get(pin),
        }
    }

    pub(crate) fn sliding(&self) -> Option<&Sliding> {
        self.sliding.as_ref()
    }

    /// Sets the friction between flank and pins; none at first.
    pub fn set_sliding(&mut self, sliding: Option<Sliding>) {
        self.sliding = sliding.filter(|sliding| sliding.coefficient > 0.0);
    }

    fn update_bound_of_pins(&mut self) {
        self.shallowest_pin = self.pin_reliefs.iter().map(undershoot).reduce(f64::min).unwrap_or(0.0);
    }

    /// Sliding distance (m) of the disc on the pin per radian of its rotation relative to the ring, in nominal motion
    /// from the pose of the contact. The disc's centre C orbits the centre of the ring z_c/m times as fast as the
    /// disc turns, in the opposite sense. The instantaneous centre of rotation is therefore P = (z_p/m) C, and the
    /// disc slides by |(x − P)·n| at the point of contact x = C + arm − r_p n. For a disc in its nominal pose this is
    /// |R S − r_p|; if the disc has turned by ε within a gap, the contact is displaced by (z_c/m) ε.
    pub fn sliding_way(&self, contact: &PinContact) -> f64 {
        let pin = &self.pins[contact.pin];
        let centre = pin.centre - contact.arm;
        let pole = self.profile.pins_per_turn() * centre;
        let touched = centre + contact.arm - pin.radius * contact.normal;
        (touched - pole).dot(&contact.normal).abs()
    }

    /// Sums the contacts that carry force; a lower bound of the gap excludes pins that cannot touch.
    pub fn react(&self, pose: DiscPose, velocity: DiscVelocity) -> Reaction {
        self.react_within(pose, velocity, Displacements::default(), true, |_, _| ())
    }

    /// As [`PinContacts::react`]. Calls `visit` for every contact that presses or has a gap below [`Displacements::lift`], with
    /// the gradient Ĝ by which its force changes: dF = −k Ĝ·dq. With `along_gaps` the stiffness includes the contact
    /// stiffness along the gaps.
    pub(crate) fn react_within(
        &self,
        pose: DiscPose,
        velocity: DiscVelocity,
        moved: Displacements<'_>,
        along_gaps: bool,
        mut visit: impl FnMut(&PinContact, [f64; 3]),
    ) -> Reaction {
        let mut reaction = Reaction::default();
        let rolls = self.rolls();
        self.visit_displaced(pose, velocity, false, moved, |contact| {
            let radius = self.pins[contact.pin].radius;
            let mut gradient = contact.gradient;
            if rolls && contact.elastic > 0.0 {
                let EnergyTerms { force, by_place, stiffness } = self.energy_terms(contact);
                for i in 0..3 {
                    reaction.force[i] += force[i];
                    gradient[i] += by_place[i];
                    (0..3).for_each(|j| reaction.stiffness[i][j] += stiffness[i][j]);
                }
            }
            let mut added = *contact;
            if !along_gaps {
                added.stiffness = 0.0;
            }
            reaction.add(&added, gradient, velocity, radius, self.sliding.as_ref());
            visit(contact, gradient);
        });
        reaction
    }

    /// Whether forces depend on the position of a contact on its flank.
    pub(crate) fn rolls(&self) -> bool {
        self.conservative && (self.contact.energy_by_log_radius(1.0) > 0.0 || self.flank_error.is_some())
    }

    /// Elastic law of a share of one contact at a fixed position.
    pub(crate) fn spring(&self, contact: &PinContact, share: f64) -> ContactSpring {
        ContactSpring::Line { law: self.contact, radius: 1.0 / contact.designed_curvature, share }
    }

    /// State of every pin, touching or not, in the order of the pins.
    pub fn contacts(&self, pose: DiscPose, velocity: DiscVelocity) -> Vec<PinContact> {
        self.displaced_contacts(pose, velocity, &[])
    }

    /// As [`PinContacts::contacts`], with displaced pins as in [`PinContacts::visit_displaced`].
    pub fn displaced_contacts(
        &self,
        pose: DiscPose,
        velocity: DiscVelocity,
        shifts: &[Vec2],
    ) -> Vec<PinContact> {
        let mut all = Vec::with_capacity(self.pins.len());
        let moved = Displacements { shifts, lift: 0.0 };
        self.visit_displaced(pose, velocity, true, moved, |contact| all.push(*contact));
        all
    }
}

impl Reaction {
    /// Adds Q = F ∂g/∂q and its tangents, including the rotation of the normal. `gradient` is Ĝ with dF = −k Ĝ·dq.
    #[inline]
    fn add(
        &mut self,
        contact: &PinContact,
        gradient: [f64; 3],
        velocity: DiscVelocity,
        pin_radius: f64,
        sliding: Option<&Sliding>,
    ) {
        if contact.force <= 0.0 {
            if contact.gap > 0.0 && contact.approach_rate > 0.0 {
                self.onset_rate =
                    self.onset_rate.max(contact.approach_rate / (contact.gap + TOLERABLE_DEPTH));
            } else {
                // The damping limits the force to zero while the surfaces separate.
                self.stored += contact.stored;
                self.dissipation -= contact.elastic * contact.approach_rate;
            }
            return;
        }
        let g = contact.gradient;
        let hessian = contact.gap_hessian(pin_radius);
        // −∂F/∂q along g: from the change of the gap, and of its rate as the normal turns.
        let mut fall = gradient.map(|g| contact.stiffness * g);
        if contact.damping != 0.0 {
            let v = velocity.as_array();
            for i in 0..3 {
                let rate_slope = hessian[i][0] * v[0] + hessian[i][1] * v[1] + hessian[i][2] * v[2];
                fall[i] += contact.damping * rate_slope;
                for j in 0..3 {
                    self.damping[i][j] += contact.damping * g[i] * g[j];
                }
            }
        }
        for i in 0..3 {
            self.force[i] += contact.force * g[i];
            for j in 0..3 {
                self.stiffness[i][j] += gradient[i] * fall[j] - contact.force * hessian[i][j];
            }
        }
        self.stored += contact.stored;
        self.dissipation += (contact.force - contact.elastic) * contact.approach_rate;
        if let Some(sliding) = sliding {
            // The tangent leaves out the rotation of the sliding direction. This term is smaller than those above by
            // the friction coefficient; Newton's method still converges.
            let (share, slope) = sliding.share(contact.sliding_speed);
            let along = contact.along;
            for i in 0..3 {
                self.force[i] += contact.friction * along[i];
                for j in 0..3 {
                    self.stiffness[i][j] -= share * contact.stiffness * along[i] * gradient[j];
                    self.damping[i][j] +=
                        along[i] * (contact.force * slope * along[j] - share * contact.damping * g[j]);
                }
            }
            self.dissipation -= contact.friction * contact.sliding_speed;
        }
    }
}

#[cfg(test)]
mod tests;
