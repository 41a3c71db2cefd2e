//! The discs in the ring of pins, which may turn with the housing.

use super::BearingJoints;
use super::assembly::{Assembly, Part, Split};
use crate::contact::{DiscPose, DiscVelocity, PinContact, PinContacts, Reaction};
use crate::dynamics::elastic_disc::{DiscMotion, DiscSplit, HousingMotion};
use crate::geometry::{Vec2, quarter_turn};

/// ∂(x, y, θ of the disc in the ring)/∂(coordinates), row by row.
pub(super) type Seen = [[f64; 6]; 3];

fn turned_back(v: Vec2, angle: f64) -> Vec2 {
    let (sin, cos) = angle.sin_cos();
    Vec2::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x)
}

impl BearingJoints {
    /// Coordinates that place a disc in the ring: its own (x, y, θ) and those of the housing.
    pub(super) fn ring_index(&self, disc: usize) -> [usize; 6] {
        let at = self.layout.disc(disc);
        let [x, y, angle] = self.layout.housing();
        [at, at + 1, at + 2, x, y, angle]
    }

    /// Place and motion of a disc in the frame of the ring: c = R(−θ_h) (C − H), θ = θ_j − θ_h.
    pub(super) fn disc_state(&self, disc: usize, q: &[f64], v: &[f64]) -> (DiscPose, DiscVelocity) {
        let [x, y, angle, ..] = self.ring_index(disc);
        if !self.layout.housing_moves() {
            return (
                DiscPose { centre: Vec2::new(q[x], q[y]), angle: q[angle] },
                DiscVelocity { centre: Vec2::new(v[x], v[y]), angle: v[angle] },
            );
        }
        let [hx, hy, turn] = self.layout.housing();
        let pose = DiscPose {
            centre: turned_back(Vec2::new(q[x] - q[hx], q[y] - q[hy]), q[turn]),
            angle: q[angle] - q[turn],
        };
        let seen = self.seen_from_ring(pose, q[turn]);
        let rate = self.ring_index(disc).map(|i| v[i]);
        let [vx, vy, spin] = seen.map(|row| row.iter().zip(&rate).map(|(s, v)| s * v).sum::<f64>());
        (pose, DiscVelocity { centre: Vec2::new(vx, vy), angle: spin })
    }

    pub(super) fn seen_from_ring(&self, pose: DiscPose, turn: f64) -> Seen {
        let (sin, cos) = turn.sin_cos();
        let c = quarter_turn(pose.centre);
        [
            [cos, sin, 0.0, -cos, -sin, -c.x],
            [-sin, cos, 0.0, sin, -cos, -c.y],
            [0.0, 0.0, 1.0, 0.0, 0.0, -1.0],
        ]
    }

    /// Motion of a disc in the ring, its modes included.
    pub(super) fn disc_motion<'a>(&'a self, disc: usize, q: &'a [f64], v: &'a [f64]) -> DiscMotion<'a> {
        let (pose, velocity) = self.disc_state(disc, q, v);
        let at = self.layout.modes(disc);
        let housing = self.housing.as_ref().map(|housing| {
            let at = self.layout.housing_modes();
            HousingMotion { housing, modes: &q[at.clone()], rates: &v[at] }
        });
        DiscMotion { pose, velocity, modes: &q[at.clone()], rates: &v[at], housing }
    }

    /// Ways of the pins on one disc in an elastic housing, in m; none in a rigid one.
    pub(super) fn pin_ways(&self, disc: usize, q: &[f64]) -> Vec<Vec2> {
        self.housing
            .as_ref()
            .map_or_else(Vec::new, |housing| housing.ways(disc, &q[self.layout.housing_modes()]))
    }

    /// Coordinates beside the place of a disc that its pins act on: its own modes, those of the housing.
    fn ring_modes(&self, disc: usize) -> impl Iterator<Item = usize> {
        self.layout.modes(disc).chain(self.layout.housing_modes())
    }

    /// What a disc does to its pins: (pin, force in N in the frame of the ring), friction aside. It is the
    /// opposite of what they do to the disc.
    pub(super) fn pin_forces(&self, disc: usize, q: &[f64], v: &[f64]) -> Vec<(usize, Vec2)> {
        match &self.elastic {
            Some(discs) => discs.pin_forces(disc, &self.rings[disc], self.disc_motion(disc, q, v)),
            None => {
                let (pose, rate) = self.disc_state(disc, q, v);
                let mut forces = Vec::new();
                self.rings[disc].visit(pose, rate, false, |contact| {
                    if contact.force > 0.0 {
                        let rolling = self.rings[disc].rolling_force(contact);
                        let on_disc = |a: usize| contact.force * contact.gradient[a] + rolling[a];
                        forces.push((contact.pin, -Vec2::new(on_disc(0), on_disc(1))));
                    }
                });
                forces
            }
        }
    }

    /// Adds what the pins do to disc and housing, and what an elastic disc does to itself.
    pub(super) fn add_ring(&self, disc: usize, q: &[f64], v: &[f64], assembly: &mut Assembly<'_>) {
        let motion = self.disc_motion(disc, q, v);
        match &self.elastic {
            None => {
                let Reaction { force, stiffness, damping, stored, dissipation, onset_rate } =
                    self.rings[disc].react(motion.pose, motion.velocity);
                self.add_reaction(
                    disc,
                    motion.pose,
                    q,
                    (&force, stiffness.as_flattened(), damping.as_flattened()),
                    assembly,
                );
                assembly.add_powers(stored, dissipation, onset_rate);
            }
            Some(discs) => {
                let reaction = discs.react(disc, &self.rings[disc], motion);
                self.add_reaction(
                    disc,
                    motion.pose,
                    q,
                    (&reaction.force, &reaction.stiffness, &reaction.damping),
                    assembly,
                );
                assembly.add_powers(reaction.stored, reaction.dissipation, reaction.onset_rate);
            }
        }
    }

    /// Adds forces on (x, y, θ in the ring, modes of disc and housing) and their tangents, row by row.
    fn add_reaction(
        &self,
        disc: usize,
        pose: DiscPose,
        q: &[f64],
        (force, stiffness, damping): (&[f64], &[f64], &[f64]),
        assembly: &mut Assembly<'_>,
    ) {
        if self.layout.housing_moves() {
            return self.add_reaction_of_moving_housing(disc, pose, q, (force, stiffness, damping), assembly);
        }
        let (place, width) = (self.layout.disc(disc), force.len());
        let index: Vec<usize> = (place..place + 3).chain(self.ring_modes(disc)).collect();
        for i in 0..width {
            assembly.add_force(index[i], force[i]);
            for j in 0..width {
                assembly.linearisation.add_stiffness(index[i], index[j], stiffness[i * width + j]);
                assembly.linearisation.add_damping(index[i], index[j], damping[i * width + j]);
            }
        }
    }

    /// Q = Gᵀ f with G from [`Self::seen_from_ring`], modes seen as they are, and its tangent Gᵀ K G −
    /// (∂Gᵀ/∂q) f.
    fn add_reaction_of_moving_housing(
        &self,
        disc: usize,
        pose: DiscPose,
        q: &[f64],
        (force, stiffness, damping): (&[f64], &[f64], &[f64]),
        assembly: &mut Assembly<'_>,
    ) {
        let place = self.ring_index(disc);
        let turn = q[place[5]];
        let seen = self.seen_from_ring(pose, turn);
        let (sin, cos) = turn.sin_cos();
        // J R f: how the force on the disc turns with the housing.
        let turning =
            quarter_turn(Vec2::new(cos * force[0] - sin * force[1], sin * force[0] + cos * force[1]));
        for (i, value) in [(0, turning.x), (1, turning.y), (3, -turning.x), (4, -turning.y)] {
            assembly.linearisation.add_stiffness(place[i], place[5], -value);
            assembly.linearisation.add_stiffness(place[5], place[i], -value);
        }
        assembly.linearisation.add_stiffness(
            place[5],
            place[5],
            force[0] * pose.centre.x + force[1] * pose.centre.y,
        );
        let width = force.len();
        // (coordinate, what it moves and by how much).
        let places = (0..6).map(|i| (place[i], [(0, seen[0][i]), (1, seen[1][i]), (2, seen[2][i])]));
        let modes = self.ring_modes(disc).enumerate().map(|(m, at)| (at, [(3 + m, 1.0), (0, 0.0), (0, 0.0)]));
        let motions: Vec<(usize, [(usize, f64); 3])> = places.chain(modes).collect();
        for (row, by_row) in &motions {
            assembly.add_force(*row, by_row.iter().map(|(a, g)| g * force[*a]).sum());
            for (column, by_column) in &motions {
                let through = |m: &[f64]| -> f64 {
                    by_row
                        .iter()
                        .map(|(a, g)| g * by_column.iter().map(|(b, h)| m[a * width + b] * h).sum::<f64>())
                        .sum()
                };
                assembly.linearisation.add_stiffness(*row, *column, through(stiffness));
                assembly.linearisation.add_damping(*row, *column, through(damping));
            }
        }
    }

    /// The rings' part of the compliance along a motion.
    pub(super) fn split_rings(&self, q: &[f64], split: &mut Split<'_>) {
        let rest = vec![0.0; q.len()];
        for (j, ring) in self.rings.iter().enumerate() {
            let state = self.disc_motion(j, q, &rest);
            let motion = self.ring_index(j).map(|i| split.motion[i]);
            let seen = self.seen_from_ring(state.pose, q[self.layout.housing()[2]]);
            let g = seen.map(|row| row.iter().zip(&motion).map(|(s, g)| s * g).sum::<f64>());
            match &self.elastic {
                None => {
                    let (teeth, seats) = rigid_split(ring, state.pose, &g);
                    split.compliance[Part::Teeth as usize] += teeth;
                    split.compliance[Part::PinSeat as usize] += seats;
                }
                Some(discs) => {
                    let modes = self.ring_modes(j).map(|at| split.motion[at]);
                    let whole: Vec<f64> = g.iter().copied().chain(modes).collect();
                    let DiscSplit { teeth, seats, disc } = discs.split(j, ring, state, &whole);
                    split.compliance[Part::Teeth as usize] += teeth;
                    split.compliance[Part::PinSeat as usize] += seats;
                    split.compliance[Part::Disc as usize] += disc;
                }
            }
        }
    }

    /// State of every pin on a disc at all coordinates and velocities.
    pub(super) fn ring_contacts(&self, disc: usize, q: &[f64], v: &[f64]) -> Vec<PinContact> {
        match &self.elastic {
            Some(discs) => discs.pin_contacts(disc, &self.rings[disc], self.disc_motion(disc, q, v)),
            None => {
                let (pose, rate) = self.disc_state(disc, q, v);
                self.rings[disc].contacts(pose, rate)
            }
        }
    }

    /// Calls `visit` for every pin that carries, with its force (N) and its approach (m) on the disc as its
    /// modes have bent it: elastic work F s, the neighbours' included.
    pub(super) fn visit_loaded(
        &self,
        disc: usize,
        q: &[f64],
        v: &[f64],
        mut visit: impl FnMut(&PinContact, f64, f64),
    ) {
        match &self.elastic {
            Some(discs) => {
                let state = discs.contacts(disc, &self.rings[disc], self.disc_motion(disc, q, v));
                for ((contact, coupled), force) in
                    state.contacts.iter().zip(&state.coupled).zip(&state.forces.force)
                {
                    if *force > 0.0 {
                        visit(contact, *force, coupled.approach);
                    }
                }
            }
            None => {
                let (pose, rate) = self.disc_state(disc, q, v);
                self.rings[disc].visit(pose, rate, false, |contact| {
                    if contact.force > 0.0 {
                        visit(contact, contact.force, -contact.gap);
                    }
                });
            }
        }
    }
}

/// gᵀ K g of teeth and seats of a rigid disc along a motion g of (x, y, θ).
fn rigid_split(ring: &PinContacts, pose: crate::contact::DiscPose, g: &[f64]) -> (f64, f64) {
    let reaction = ring.react(pose, DiscVelocity::REST);
    let mut whole = 0.0;
    for a in 0..3 {
        for b in 0..3 {
            whole += g[a] * reaction.stiffness[a][b] * g[b];
        }
    }
    let mut seats = 0.0;
    ring.visit(pose, DiscVelocity::REST, false, |contact| {
        if contact.force > 0.0 {
            let rate: f64 = contact.gradient.iter().zip(g).map(|(s, g)| s * g).sum();
            seats += contact.stiffness * contact.stiffness * ring.contact().seat_compliance() * rate * rate;
        }
    });
    (whole - seats, seats)
}
