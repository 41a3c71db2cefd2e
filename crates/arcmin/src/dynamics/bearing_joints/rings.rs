//! The discs in the ring of pins, which may turn with the housing.

use super::BearingJoints;
use super::assembly::{Assembly, Part, Split};
use crate::contact::{DiscPose, DiscVelocity, Reaction};
use crate::geometry::{Vec2, quarter_turn};

/// ∂(x, y, θ of the disc in the ring)/∂(coordinates), row by row.
type Seen = [[f64; 6]; 3];

fn turned_back(v: Vec2, angle: f64) -> Vec2 {
    let (sin, cos) = angle.sin_cos();
    Vec2::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x)
}

impl BearingJoints {
    /// Coordinates that place a disc in the ring: its own (x, y, θ) and those of the housing.
    fn ring_index(&self, disc: usize) -> [usize; 6] {
        let at = self.layout.disc(disc);
        let [x, y, angle] = self.layout.housing();
        [at, at + 1, at + 2, x, y, angle]
    }

    /// Place and motion of a disc in the frame of the ring: c = R(−θ_h) (C − H), θ = θ_j − θ_h.
    pub(super) fn disc_state(&self, disc: usize, q: &[f64], v: &[f64]) -> (DiscPose, DiscVelocity) {
        let [x, y, angle, ..] = self.ring_index(disc);
        if !self.layout.housing_moves() {
            return (DiscPose { centre: Vec2::new(q[x], q[y]), angle: q[angle] }, DiscVelocity { centre: Vec2::new(v[x], v[y]), angle: v[angle] });
        }
        let [hx, hy, turn] = self.layout.housing();
        let pose = DiscPose { centre: turned_back(Vec2::new(q[x] - q[hx], q[y] - q[hy]), q[turn]), angle: q[angle] - q[turn] };
        let seen = self.seen_from_ring(pose, q[turn]);
        let rate = self.ring_index(disc).map(|i| v[i]);
        let [vx, vy, spin] = seen.map(|row| row.iter().zip(&rate).map(|(s, v)| s * v).sum::<f64>());
        (pose, DiscVelocity { centre: Vec2::new(vx, vy), angle: spin })
    }

    fn seen_from_ring(&self, pose: DiscPose, turn: f64) -> Seen {
        let (sin, cos) = turn.sin_cos();
        let c = quarter_turn(pose.centre);
        [[cos, sin, 0.0, -cos, -sin, -c.x], [-sin, cos, 0.0, sin, -cos, -c.y], [0.0, 0.0, 1.0, 0.0, 0.0, -1.0]]
    }

    /// Adds what the pins do to disc and housing.
    pub(super) fn add_ring(&self, disc: usize, q: &[f64], v: &[f64], assembly: &mut Assembly<'_>) {
        let (pose, rate) = self.disc_state(disc, q, v);
        let Reaction { force, stiffness, damping, stored, dissipation, onset_rate } = self.rings[disc].react(pose, rate);
        let index = self.ring_index(disc);
        if self.layout.housing_moves() {
            self.add_ring_of_moving_housing(&index, pose, q, (force, stiffness, damping), assembly);
        } else {
            for i in 0..3 {
                assembly.add_force(index[i], force[i]);
                for j in 0..3 {
                    assembly.linearisation.add_stiffness(index[i], index[j], stiffness[i][j]);
                    assembly.linearisation.add_damping(index[i], index[j], damping[i][j]);
                }
            }
        }
        assembly.balance.stored += stored;
        assembly.balance.dissipation += dissipation;
        assembly.balance.onset_rate = assembly.balance.onset_rate.max(onset_rate);
    }

    /// Q = Gᵀ f with G from [`Self::seen_from_ring`], and its tangent Gᵀ K G − (∂Gᵀ/∂q) f.
    fn add_ring_of_moving_housing(
        &self,
        index: &[usize; 6],
        pose: DiscPose,
        q: &[f64],
        (force, stiffness, damping): ([f64; 3], [[f64; 3]; 3], [[f64; 3]; 3]),
        assembly: &mut Assembly<'_>,
    ) {
        let turn = q[index[5]];
        let seen = self.seen_from_ring(pose, turn);
        let (sin, cos) = turn.sin_cos();
        // J R f: how the force on the disc turns with the housing.
        let turning = quarter_turn(Vec2::new(cos * force[0] - sin * force[1], sin * force[0] + cos * force[1]));
        let mut geometric = [[0.0; 6]; 6];
        for (i, value) in [(0, turning.x), (1, turning.y), (3, -turning.x), (4, -turning.y)] {
            geometric[i][5] = -value;
            geometric[5][i] = -value;
        }
        geometric[5][5] = force[0] * pose.centre.x + force[1] * pose.centre.y;
        for i in 0..6 {
            assembly.add_force(index[i], (0..3).map(|a| seen[a][i] * force[a]).sum());
            for j in 0..6 {
                let through = |m: &[[f64; 3]; 3]| -> f64 { (0..3).map(|a| seen[a][i] * (0..3).map(|b| m[a][b] * seen[b][j]).sum::<f64>()).sum() };
                assembly.linearisation.add_stiffness(index[i], index[j], through(&stiffness) + geometric[i][j]);
                assembly.linearisation.add_damping(index[i], index[j], through(&damping));
            }
        }
    }

    pub(super) fn split_rings(&self, q: &[f64], split: &mut Split<'_>) {
        for (j, ring) in self.rings.iter().enumerate() {
            let (pose, _) = self.disc_state(j, q, q);
            let motion = self.ring_index(j).map(|i| split.motion[i]);
            let g = self.seen_from_ring(pose, q[self.layout.housing()[2]]).map(|row| row.iter().zip(&motion).map(|(s, g)| s * g).sum::<f64>());
            let seat = ring.contact().seat_compliance();
            let rest = crate::contact::DiscVelocity::REST;
            let reaction = ring.react(pose, rest);
            let mut whole = 0.0;
            for a in 0..3 {
                for b in 0..3 {
                    whole += g[a] * reaction.stiffness[a][b] * g[b];
                }
            }
            let mut seats = 0.0;
            ring.visit(pose, rest, false, |contact| {
                if contact.force > 0.0 {
                    let rate: f64 = contact.gradient.iter().zip(&g).map(|(s, g)| s * g).sum();
                    seats += contact.stiffness * contact.stiffness * seat * rate * rate;
                }
            });
            split.compliance[Part::Teeth as usize] += whole - seats;
            split.compliance[Part::PinSeat as usize] += seats;
        }
    }
}
