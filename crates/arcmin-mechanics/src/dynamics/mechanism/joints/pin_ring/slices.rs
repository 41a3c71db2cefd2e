//! Contacts of a rigid disc with its pins: the whole width for a disc without tilt, two slices for a tilted
//! one.

use super::{ContactRequest, Forces, PinRing, RingContact, State};
use crate::contact::{DiscPose, DiscVelocity, Displacements, PinContact, Pressed, Sliding};

/// One slice of a rigid disc.
#[derive(Clone, Copy)]
pub(super) struct Slice {
    /// Fraction of the disc's width.
    pub share: f64,
    /// Height above the disc's middle, m.
    pub height: f64,
    pub pose: DiscPose,
    pub velocity: DiscVelocity,
}

/// Forces of pins on a rigid disc: on (x, y, θ), and on the slopes if it tilts.
#[derive(Default)]
pub(super) struct RigidReaction {
    pub force: [f64; 5],
    /// Row by row over the first three of them, or over all.
    pub stiffness: [f64; 25],
    pub damping: [f64; 25],
    /// Stored energy in J, dissipation in W, onset rate of contacts in 1/s.
    pub powers: [f64; 3],
}

impl RigidReaction {
    /// Over the first `width` of (x, y, θ, slopes).
    pub fn forces(&self, width: usize) -> Forces<'_> {
        Forces {
            force: &self.force[..width],
            stiffness: &self.stiffness[..width * width],
            damping: &self.damping[..width * width],
            powers: self.powers,
        }
    }
}

impl<'a> RingContact<'a> {
    /// Friction of a loaded contact against the slip over a time interval (s), along the motion that causes it.
    pub fn slip(
        sliding: &Sliding,
        contact: &PinContact,
        force: f64,
        along: &'a [f64],
        interval: f64,
    ) -> RingContact<'a> {
        let gap = contact.sliding_speed * interval;
        let spring = sliding.slip(force, interval);
        RingContact { gap, gradient: along, push: along, spring, pressed: spring.at(-gap), place: None }
    }
}

/// Displacements (x, y, θ) of a slice at a height due to (x, y, θ, slopes) of a disc: (index in x, y, θ of the
/// slice, factor).
fn of_slice(height: f64) -> [(usize, f64); 5] {
    [(0, 1.0), (1, 1.0), (2, 1.0), (0, height), (1, height)]
}

impl PinRing {
    /// Slices that represent a rigid disc: share of the force, height above the middle (m), position and
    /// velocity. A disc without tilt has a single one.
    pub(super) fn slices(&self, at: State<'_>) -> Vec<Slice> {
        let (pose, velocity) = self.disc_state(at);
        let Some(slope) = self.slope(at.q) else {
            return vec![Slice { share: 1.0, height: 0.0, pose, velocity }];
        };
        let rate = self.slope_rate(at, slope);
        let slice = |height: f64| Slice {
            share: 0.5,
            height,
            pose: DiscPose { centre: pose.centre + height * slope, ..pose },
            velocity: DiscVelocity { centre: velocity.centre + height * rate, ..velocity },
        };
        [self.reach(), -self.reach()].map(slice).to_vec()
    }

    /// Forces of the pins on a rigid disc, with its contacts one by one if required.
    pub(super) fn react_of_slices(
        &self,
        at: State<'_>,
        mut wanted: Option<(ContactRequest, &mut dyn FnMut(&RingContact<'_>))>,
    ) -> RigidReaction {
        let mut sum = RigidReaction::default();
        let lift = wanted.as_ref().map_or(0.0, |(wanted, _)| wanted.reach);
        let width = if self.slopes.is_some() { 5 } else { 3 };
        for Slice { share, height, pose, velocity } in self.slices(at) {
            let moves = &of_slice(height)[..width];
            let widened = |row: [f64; 3]| {
                let mut wide = [0.0; 5];
                wide.iter_mut().zip(moves).for_each(|(wide, (i, by))| *wide = by * row[*i]);
                wide
            };
            let moved = Displacements { shifts: &[], lift };
            // Sliding friction that increases with speed is part of its contact if displacements determine the
            // speeds.
            let mut rubbing = [[0.0; 3]; 3];
            let along_gaps = wanted.is_none();
            let slice = self.contacts.react_within(pose, velocity, moved, along_gaps, |contact, gradient| {
                let Some((ContactRequest { slip_interval, .. }, visit_contact)) = &mut wanted else { return };
                let sliding = self.contacts.sliding().filter(|_| contact.force > 0.0);
                let rubs = sliding.map_or(0.0, |sliding| sliding.share(contact.sliding_speed).0);
                let push = widened(std::array::from_fn(|a| gradient[a] - rubs * contact.along[a]));
                visit_contact(&RingContact {
                    gap: contact.gap,
                    gradient: &widened(gradient)[..width],
                    push: &push[..width],
                    spring: self.contacts.spring(contact, share),
                    pressed: Pressed { force: share * contact.elastic, stiffness: share * contact.stiffness },
                    place: None,
                });
                if let (Some(sliding), Some(interval)) = (sliding, *slip_interval) {
                    let slope = sliding.share(contact.sliding_speed).1;
                    for (row, a) in rubbing.iter_mut().zip(contact.along) {
                        row.iter_mut()
                            .zip(contact.along)
                            .for_each(|(sum, b)| *sum += contact.force * slope * a * b);
                    }
                    let along = &widened(contact.along)[..width];
                    visit_contact(&RingContact::slip(
                        sliding,
                        contact,
                        share * contact.force,
                        along,
                        interval,
                    ));
                }
            });
            for (a, (i, by)) in moves.iter().enumerate() {
                sum.force[a] += share * by * slice.force[*i];
                for (b, (j, of)) in moves.iter().enumerate() {
                    sum.stiffness[a * width + b] += share * by * of * slice.stiffness[*i][*j];
                    sum.damping[a * width + b] += share * by * of * (slice.damping[*i][*j] - rubbing[*i][*j]);
                }
            }
            sum.powers[0] += share * slice.stored;
            sum.powers[1] += share * slice.dissipation;
            sum.powers[2] = sum.powers[2].max(slice.onset_rate);
        }
        sum
    }

    /// gᵀ K g of teeth and seats along a motion g of (x, y, θ) and the slopes, if the disc tilts.
    pub(super) fn split_of_rigid_disc(&self, at: State<'_>, g: [f64; 3], slopes: &[f64]) -> (f64, f64) {
        let compliance = self.contacts.contact().seat_compliance();
        let (mut whole, mut seats) = (0.0, 0.0);
        for Slice { share, height, pose, .. } in self.slices(at) {
            let mut g = g;
            g.iter_mut().zip(slopes).for_each(|(g, slope)| *g += height * slope);
            let reaction = self.contacts.react(pose, DiscVelocity::REST);
            for a in 0..3 {
                for b in 0..3 {
                    whole += share * g[a] * reaction.stiffness[a][b] * g[b];
                }
            }
            self.contacts.visit(pose, DiscVelocity::REST, false, |contact| {
                if contact.force > 0.0 {
                    let rate: f64 = contact.gradient.iter().zip(g).map(|(s, g)| s * g).sum();
                    seats += share * contact.stiffness * contact.stiffness * compliance * rate * rate;
                }
            });
        }
        (whole - seats, seats)
    }
}
