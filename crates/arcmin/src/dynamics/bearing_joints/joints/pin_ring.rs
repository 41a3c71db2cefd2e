//! The pins on one disc: ring, or housing, and disc hold each other through them.

mod gaps;

use std::ops::Range;
use std::sync::Arc;

use super::{Cause, Distance, Element, Joint, Limit, Nominal, Part, Pressed, Sink, State};
use crate::contact::{DiscPose, DiscVelocity, Moved, PinContact, PinContacts, Reaction, Sliding};
use crate::dynamics::elastic_disc::{DiscMotion, DiscSplit, HousingMotion};
use crate::dynamics::{ElasticDiscs, ElasticHousing, ForceSummary};
use crate::geometry::{Vec2, quarter_turn, turned, unit};

pub(in super::super) use gaps::Designed;

/// About how stiff a pin is on a flank, in N/m.
pub(in super::super) const PIN: f64 = 2e8;

/// Modes of an elastic body, and the coordinates that they are.
#[derive(Debug, Clone)]
pub(in super::super) struct Modes<T> {
    pub body: Arc<T>,
    pub at: Range<usize>,
}

/// The pins on one disc, and the disc's own elasticity where it has any.
#[derive(Debug, Clone)]
pub(in super::super) struct PinRing {
    pub contacts: PinContacts,
    /// Number of the disc.
    pub disc: usize,
    /// Coordinates (x, y, θ) of the disc, then of the housing.
    pub place: [usize; 6],
    /// Whether the ring moves with the housing.
    pub moves: bool,
    pub elastic: Option<Modes<ElasticDiscs>>,
    /// A housing that moves its pins.
    pub housing: Option<Modes<ElasticHousing>>,
    pub designed: Designed,
}

/// ∂(x, y, θ of the disc in the ring)/∂(coordinates), row by row.
type Seen = [[f64; 6]; 3];

/// Forces on (x, y, θ in the ring, modes of disc and housing) with −∂Q/∂q and −∂Q/∂q̇, row by row.
struct Forces<'a> {
    force: &'a [f64],
    stiffness: &'a [f64],
    damping: &'a [f64],
    /// Stored energy in J, dissipation in W, rate in 1/s at which contacts close.
    powers: [f64; 3],
}

impl PinRing {
    /// Place and motion of the disc in the frame of the ring: c = R(−θ_h) (C − H), θ = θ_j − θ_h.
    fn disc_state(&self, at: State<'_>) -> (DiscPose, DiscVelocity) {
        let State { q, v } = at;
        let [x, y, angle, hx, hy, turn] = self.place;
        if !self.moves {
            return (
                DiscPose { centre: Vec2::new(q[x], q[y]), angle: q[angle] },
                DiscVelocity { centre: Vec2::new(v[x], v[y]), angle: v[angle] },
            );
        }
        let pose = DiscPose {
            centre: turned(Vec2::new(q[x] - q[hx], q[y] - q[hy]), unit(-q[turn])),
            angle: q[angle] - q[turn],
        };
        let rate = self.place.map(|i| v[i]);
        let [vx, vy, spin] =
            self.seen(pose, q).map(|row| row.iter().zip(&rate).map(|(s, v)| s * v).sum::<f64>());
        (pose, DiscVelocity { centre: Vec2::new(vx, vy), angle: spin })
    }

    fn seen(&self, pose: DiscPose, q: &[f64]) -> Seen {
        let (sin, cos) = q[self.place[5]].sin_cos();
        let c = quarter_turn(pose.centre);
        [
            [cos, sin, 0.0, -cos, -sin, -c.x],
            [-sin, cos, 0.0, sin, -cos, -c.y],
            [0.0, 0.0, 1.0, 0.0, 0.0, -1.0],
        ]
    }

    /// Motion of the disc in the ring, modes included.
    fn motion<'a>(&'a self, at: State<'a>) -> DiscMotion<'a> {
        let (pose, velocity) = self.disc_state(at);
        let modes = self.elastic.as_ref().map_or(0..0, |modes| modes.at.clone());
        let housing = self.housing.as_ref().map(|Modes { body, at: range }| HousingMotion {
            housing: body,
            modes: &at.q[range.clone()],
            rates: &at.v[range.clone()],
        });
        DiscMotion { pose, velocity, modes: &at.q[modes.clone()], rates: &at.v[modes], housing }
    }

    /// Ways of the pins in an elastic housing, in m; none in a rigid one.
    fn pin_ways(&self, q: &[f64]) -> Vec<Vec2> {
        let ways = |modes: &Modes<ElasticHousing>| modes.body.ways(self.disc, &q[modes.at.clone()]);
        self.housing.as_ref().map_or_else(Vec::new, ways)
    }

    /// Coordinates beside the place of the disc that the pins act on: its own modes, those of the housing.
    fn modes(&self) -> impl Iterator<Item = usize> {
        let disc = self.elastic.as_ref().map_or(0..0, |modes| modes.at.clone());
        disc.chain(self.housing.as_ref().map_or(0..0, |modes| modes.at.clone()))
    }

    /// What the disc does to its pins: (pin, force in N in the frame of the ring), friction aside. It is the
    /// opposite of what they do to the disc.
    pub fn pin_forces(&self, at: State<'_>) -> Vec<(usize, Vec2)> {
        if let Some(Modes { body, .. }) = &self.elastic {
            return body.pin_forces(self.disc, &self.contacts, self.motion(at));
        }
        let mut forces = Vec::new();
        let (pose, rate) = self.disc_state(at);
        self.contacts.visit(pose, rate, false, |contact| {
            if contact.force > 0.0 {
                let rolling = self.contacts.rolling_force(contact);
                let on_disc = |a: usize| contact.force * contact.gradient[a] + rolling[a];
                forces.push((contact.pin, -Vec2::new(on_disc(0), on_disc(1))));
            }
        });
        forces
    }

    /// State of every pin.
    pub fn all(&self, at: State<'_>) -> Vec<PinContact> {
        match &self.elastic {
            Some(Modes { body, .. }) => body.pin_contacts(self.disc, &self.contacts, self.motion(at)),
            None => {
                let (pose, rate) = self.disc_state(at);
                self.contacts.contacts(pose, rate)
            }
        }
    }

    /// State of the pins that carry.
    pub fn loaded(&self, at: State<'_>) -> Vec<PinContact> {
        let mut loaded = Vec::new();
        self.visit_loaded(at, |contact, force, _| {
            let mut contact = *contact;
            contact.force = force;
            loaded.push(contact);
        });
        loaded
    }

    /// Calls `visit` for every pin that carries, with its force (N) and its approach (m) on the disc as its
    /// modes have bent it: elastic work F s, the neighbours' included.
    fn visit_loaded(&self, at: State<'_>, mut visit: impl FnMut(&PinContact, f64, f64)) {
        let Some(Modes { body, .. }) = &self.elastic else {
            let (pose, rate) = self.disc_state(at);
            self.contacts.visit(pose, rate, false, |contact| {
                if contact.force > 0.0 {
                    visit(contact, contact.force, -contact.gap);
                }
            });
            return;
        };
        let state = body.contacts(self.disc, &self.contacts, self.motion(at));
        for ((contact, coupled), force) in state.contacts.iter().zip(&state.coupled).zip(&state.forces.force)
        {
            if *force > 0.0 {
                visit(contact, *force, coupled.approach);
            }
        }
    }

    /// Hands on what acts on (x, y, θ in the ring, modes) as forces on coordinates.
    fn hand_on(&self, pose: DiscPose, q: &[f64], forces: &Forces<'_>, sink: &mut dyn Sink) {
        let Forces { force, stiffness, damping, powers: [stored, dissipation, onset_rate] } = *forces;
        sink.onset(onset_rate);
        if self.moves {
            return self.hand_on_of_moving_ring(pose, q, forces, sink);
        }
        let index: Vec<usize> = self.place[..3].iter().copied().chain(self.modes()).collect();
        let gradient: Vec<f64> = force.iter().map(|force| -force).collect();
        let element =
            Element { part: Part::Teeth, index: &index, gradient: &gradient, hessian: stiffness, stored };
        sink.element(&element);
        sink.damper(&index, &vec![0.0; force.len()], damping, dissipation);
    }

    /// Q = Gᵀ f with G from [`Self::seen`], modes seen as they are, and its tangent Gᵀ K G − (∂Gᵀ/∂q) f where that is
    /// asked for.
    fn hand_on_of_moving_ring(&self, pose: DiscPose, q: &[f64], forces: &Forces<'_>, sink: &mut dyn Sink) {
        let Forces { force, stiffness, damping, powers: [stored, dissipation, _] } = *forces;
        let seen = self.seen(pose, q);
        // (what a coordinate moves and by how much).
        let places = (0..6).map(|i| [(0, seen[0][i]), (1, seen[1][i]), (2, seen[2][i])]);
        let modes = (3..force.len()).map(|m| [(m, 1.0), (0, 0.0), (0, 0.0)]);
        let motions: Vec<[(usize, f64); 3]> = places.chain(modes).collect();
        let (own, width) = (force.len(), motions.len());
        let through = |m: &[f64]| -> Vec<f64> {
            if m.is_empty() {
                return Vec::new();
            }
            let mut seen = vec![0.0; width * width];
            for (i, by_row) in motions.iter().enumerate() {
                for (j, by_column) in motions.iter().enumerate() {
                    let column = |a: usize| by_column.iter().map(|(b, h)| m[a * own + b] * h).sum::<f64>();
                    seen[i * width + j] = by_row.iter().map(|(a, g)| g * column(*a)).sum();
                }
            }
            seen
        };
        let mut hessian = through(stiffness);
        let gradient: Vec<f64> =
            motions.iter().map(|by_row| -by_row.iter().map(|(a, g)| g * force[*a]).sum::<f64>()).collect();
        let index: Vec<usize> = self.place.iter().copied().chain(self.modes()).collect();
        // J R f: how the force on the disc turns with the housing.
        let turning = quarter_turn(turned(Vec2::new(force[0], force[1]), unit(q[self.place[5]])));
        if !hessian.is_empty() {
            for (i, value) in [(0, turning.x), (1, turning.y), (3, -turning.x), (4, -turning.y)] {
                hessian[i * width + 5] -= value;
                hessian[5 * width + i] -= value;
            }
            hessian[5 * width + 5] += force[0] * pose.centre.x + force[1] * pose.centre.y;
        }
        let element =
            Element { part: Part::Teeth, index: &index, gradient: &gradient, hessian: &hessian, stored };
        sink.element(&element);
        sink.damper(&index, &vec![0.0; width], &through(damping), dissipation);
    }
}

impl Joint for PinRing {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let motion = self.motion(at);
        match &self.elastic {
            None => {
                let Reaction { force, stiffness, damping, stored, dissipation, onset_rate } =
                    self.contacts.react(motion.pose, motion.velocity);
                let forces = Forces {
                    force: &force,
                    stiffness: stiffness.as_flattened(),
                    damping: damping.as_flattened(),
                    powers: [stored, dissipation, onset_rate],
                };
                self.hand_on(motion.pose, at.q, &forces, sink);
            }
            Some(Modes { body, .. }) => {
                let reaction = body.react(self.disc, &self.contacts, motion, sink.takes_stiffness());
                let forces = Forces {
                    force: &reaction.force,
                    stiffness: &reaction.stiffness,
                    damping: &reaction.damping,
                    powers: [reaction.stored, reaction.dissipation, reaction.onset_rate],
                };
                self.hand_on(motion.pose, at.q, &forces, sink);
            }
        }
    }

    fn limits(&self, q: &[f64], reach: f64, add: &mut dyn FnMut(Limit<'_>)) {
        self.elastic.iter().flat_map(|modes| modes.at.clone()).for_each(|at| add(Limit::Held(at)));
        let rest = vec![0.0; q.len()];
        let (pose, _) = self.disc_state(State { q, v: &rest });
        let shifts = self.pin_ways(q);
        let moved = Moved { shifts: &shifts, lift: reach };
        let seen = self.moves.then(|| self.seen(pose, q));
        self.contacts.visit_moved(pose, DiscVelocity::REST, false, moved, |contact| {
            let mut pin = |index: &[usize], gradient: &[f64]| {
                let pressed = Pressed { force: contact.force, stiffness: contact.stiffness };
                add(Limit::Pin(Distance { index, gradient, value: contact.gap, stiffness: PIN }, pressed));
            };
            match &seen {
                None => pin(&self.place[..3], &contact.gradient),
                Some(seen) => {
                    let by = |i: usize| (0..3).map(|a| contact.gradient[a] * seen[a][i]).sum();
                    pin(&self.place, &std::array::from_fn::<f64, 6, _>(by));
                }
            }
        });
    }

    fn split(&self, at: State<'_>, motion: &[f64], add: &mut dyn FnMut(Part, f64)) {
        let state = self.motion(at);
        let by_place = self.place.map(|i| motion[i]);
        let g = self.seen(state.pose, at.q).map(|row| row.iter().zip(&by_place).map(|(s, g)| s * g).sum());
        let (teeth, seats) = match &self.elastic {
            None => self.split_of_rigid_disc(state.pose, g),
            Some(Modes { body, .. }) => {
                let whole: Vec<f64> = g.into_iter().chain(self.modes().map(|at| motion[at])).collect();
                let DiscSplit { teeth, seats, disc } = body.split(self.disc, &self.contacts, state, &whole);
                add(Part::Disc, disc);
                (teeth, seats)
            }
        };
        add(Part::Teeth, teeth);
        add(Part::PinSeat, seats);
    }

    fn work(&self, at: State<'_>, nominal: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        if let Some(Modes { body, at: modes }) = &self.elastic {
            add(Cause::Elastic, body.modal_work(self.disc, &at.q[modes.clone()]));
        }
        self.work_of_gaps(at, nominal, add);
    }

    fn scale_friction(&mut self, share: f64) {
        let less = |sliding: &Sliding| Sliding { coefficient: share * sliding.coefficient, ..*sliding };
        let sliding = self.contacts.sliding().map(less);
        self.contacts.set_sliding(sliding);
    }

    fn add_forces(&self, at: State<'_>, summary: &mut ForceSummary) {
        let law = self.contacts.contact();
        self.visit_loaded(at, |contact, force, _| {
            summary.add_pin(force, law.pressure(force, 1.0 / contact.relative_curvature));
        });
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}

impl PinRing {
    /// gᵀ K g of teeth and seats along a motion g of (x, y, θ).
    fn split_of_rigid_disc(&self, pose: DiscPose, g: [f64; 3]) -> (f64, f64) {
        let reaction = self.contacts.react(pose, DiscVelocity::REST);
        let mut whole = 0.0;
        for a in 0..3 {
            for b in 0..3 {
                whole += g[a] * reaction.stiffness[a][b] * g[b];
            }
        }
        let compliance = self.contacts.contact().seat_compliance();
        let mut seats = 0.0;
        self.contacts.visit(pose, DiscVelocity::REST, false, |contact| {
            if contact.force > 0.0 {
                let rate: f64 = contact.gradient.iter().zip(g).map(|(s, g)| s * g).sum();
                seats += contact.stiffness * contact.stiffness * compliance * rate * rate;
            }
        });
        (whole - seats, seats)
    }
}
