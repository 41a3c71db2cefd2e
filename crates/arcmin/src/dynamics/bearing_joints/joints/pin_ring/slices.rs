//! A rigid disc against its pins: as a whole where it stands straight, as two slices where it leans.

use super::{PinRing, State};
use crate::contact::{DiscPose, DiscVelocity};

/// One slice of a rigid disc.
#[derive(Clone, Copy)]
pub(super) struct Slice {
    /// Of the disc's width.
    pub share: f64,
    /// Over the disc's middle, m.
    pub height: f64,
    pub pose: DiscPose,
    pub velocity: DiscVelocity,
}

/// What pins do to a rigid disc that leans: on (x, y, θ) and the slopes.
#[derive(Default)]
pub(super) struct LeaningReaction {
    pub force: [f64; 5],
    pub stiffness: [[f64; 5]; 5],
    pub damping: [[f64; 5]; 5],
    /// Stored energy in J, dissipation in W, rate in 1/s at which contacts close.
    pub powers: [f64; 3],
}

/// What moves with (x, y, θ, slopes) of a disc at a height: (which of x, y, θ of the slice, by how much).
fn of_slice(height: f64) -> [(usize, f64); 5] {
    [(0, 1.0), (1, 1.0), (2, 1.0), (0, height), (1, height)]
}

impl PinRing {
    /// Slices of a rigid disc that bear its pins together: share of the force, height over the middle (m), place and
    /// motion. A disc that stands straight is a single one.
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

    pub(super) fn react_of_slices(&self, at: State<'_>) -> LeaningReaction {
        let mut sum = LeaningReaction::default();
        for Slice { share, height, pose, velocity } in self.slices(at) {
            let slice = self.contacts.react(pose, velocity);
            let moves = of_slice(height);
            for (a, (i, by)) in moves.iter().enumerate() {
                sum.force[a] += share * by * slice.force[*i];
                for (b, (j, of)) in moves.iter().enumerate() {
                    sum.stiffness[a][b] += share * by * of * slice.stiffness[*i][*j];
                    sum.damping[a][b] += share * by * of * slice.damping[*i][*j];
                }
            }
            sum.powers[0] += share * slice.stored;
            sum.powers[1] += share * slice.dissipation;
            sum.powers[2] = sum.powers[2].max(slice.onset_rate);
        }
        sum
    }

    /// gᵀ K g of teeth and seats along a motion g of (x, y, θ) and the slopes, if the disc leans.
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
