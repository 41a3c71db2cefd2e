//! The pins on one disc: contacts between ring, or housing, and disc.

mod gaps;
mod slices;

use std::ops::Range;
use std::sync::Arc;

use super::{Cause, ContactRequest, Distance, Element, Joint, Limit, Nominal, Part, Sink, State};
use crate::contact::{
    ContactSpring, DiscPose, DiscVelocity, Displacements, PinContact, PinContacts, Pressed, Sliding,
    slice_height,
};
use crate::dynamics::elastic_disc::{DiscMotion, DiscSplit, DiscTilt, HousingMotion};
use crate::dynamics::{Contact, ElasticDiscs, ElasticHousing, FlankPlace, ForceSummary};
use crate::geometry::{Vec2, quarter_turn, turned, unit};

pub(in crate::dynamics) use gaps::Designed;
use slices::Slice;

/// Typical stiffness of a pin on a flank, in N/m.
pub(in crate::dynamics) const PIN: f64 = 2e8;

/// Modes of an elastic body, and the numbers of their coordinates.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct Modes<T> {
    pub body: Arc<T>,
    pub at: Range<usize>,
}

/// The pins on one disc, and the disc's own elasticity if it has any.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct PinRing {
    pub contacts: PinContacts,
    /// Number of the disc.
    pub disc: usize,
    /// Coordinates (x, y, θ) of the disc, then of the housing.
    pub place: [usize; 6],
    /// Whether the ring moves with the housing.
    pub moves: bool,
    pub elastic: Option<Modes<ElasticDiscs>>,
    /// An elastic housing, which displaces its pins.
    pub housing: Option<Modes<ElasticHousing>>,
    /// Slopes (∂x/∂z, ∂y/∂z) of a disc that tilts.
    pub slopes: Option<[usize; 2]>,
    pub designed: Designed,
}

/// ∂(x, y, θ of the disc in the ring)/∂(coordinates), row by row.
type PoseJacobian = [[f64; 6]; 3];

/// Components of (x, y, θ in the ring, modes, slopes) that a coordinate changes, with factors.
struct Motion {
    moves: [(usize, f64); 5],
    count: usize,
}

impl Motion {
    fn of(moves: &[(usize, f64)]) -> Motion {
        let mut motion = Motion { moves: [(0, 0.0); 5], count: moves.len() };
        motion.moves[..moves.len()].copy_from_slice(moves);
        motion
    }

    fn list(&self) -> &[(usize, f64)] {
        &self.moves[..self.count]
    }
}

/// A contact over (x, y, θ in the ring, modes of disc and housing, slopes in the ring).
pub(in crate::dynamics) struct RingContact<'a> {
    pub gap: f64,
    pub gradient: &'a [f64],
    /// Direction of its force: the gradient, without friction.
    pub push: &'a [f64],
    pub spring: ContactSpring,
    pub pressed: Pressed,
    pub place: Option<FlankPlace>,
}

/// Transforms contacts to the coordinates of the mechanism.
struct ToMechanism<'a> {
    index: Vec<usize>,
    /// Effects of the coordinates for a moving ring.
    motions: Vec<Motion>,
    gradient: Vec<f64>,
    push: Vec<f64>,
    sink: &'a mut dyn Sink,
}

impl ToMechanism<'_> {
    fn add(&mut self, contact: &RingContact<'_>) {
        let RingContact { gap, gradient, push, spring, pressed, place } = *contact;
        let ToMechanism { index, motions, gradient: by_gap, push: by_force, sink } = self;
        if motions.is_empty() {
            return sink.contact(&Contact { index, gradient, push, gap, spring, pressed, place });
        }
        let along = |row: &[f64], into: &mut Vec<f64>| {
            into.clear();
            let by = |motion: &Motion| motion.list().iter().map(|(a, g)| g * row[*a]).sum::<f64>();
            into.extend(motions.iter().map(by));
        };
        along(gradient, by_gap);
        along(push, by_force);
        sink.contact(&Contact { index, gradient: by_gap, push: by_force, gap, spring, pressed, place });
    }
}

/// Forces on (x, y, θ in the ring, modes of disc and housing, slopes in the ring) with −∂Q/∂q and −∂Q/∂q̇, row by
/// row.
struct Forces<'a> {
    force: &'a [f64],
    stiffness: &'a [f64],
    damping: &'a [f64],
    /// Stored energy in J, dissipation in W, onset rate of contacts in 1/s.
    powers: [f64; 3],
}

impl PinRing {
    /// Pose and velocity of the disc in the frame of the ring: c = R(−θ_h) (C − H), θ = θ_j − θ_h.
    pub(in crate::dynamics) fn disc_state(&self, at: State<'_>) -> (DiscPose, DiscVelocity) {
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
            self.pose_jacobian(pose, q).map(|row| row.iter().zip(&rate).map(|(s, v)| s * v).sum::<f64>());
        (pose, DiscVelocity { centre: Vec2::new(vx, vy), angle: spin })
    }

    fn pose_jacobian(&self, pose: DiscPose, q: &[f64]) -> PoseJacobian {
        let (sin, cos) = q[self.place[5]].sin_cos();
        let c = quarter_turn(pose.centre);
        [
            [cos, sin, 0.0, -cos, -sin, -c.x],
            [-sin, cos, 0.0, sin, -cos, -c.y],
            [0.0, 0.0, 1.0, 0.0, 0.0, -1.0],
        ]
    }

    /// Slope of a tilted disc, in the frame of the ring.
    fn slope(&self, q: &[f64]) -> Option<Vec2> {
        let [x, y] = self.slopes?;
        let slope = Vec2::new(q[x], q[y]);
        Some(if self.moves { turned(slope, unit(-q[self.place[5]])) } else { slope })
    }

    /// Rate of that slope.
    fn slope_rate(&self, State { q, v }: State<'_>, slope: Vec2) -> Vec2 {
        let [x, y] = self.slopes.unwrap_or_default();
        let (rate, turn) = (Vec2::new(v[x], v[y]), self.place[5]);
        if self.moves { turned(rate, unit(-q[turn])) - v[turn] * quarter_turn(slope) } else { rate }
    }

    /// Distance from the middle of the two slices that represent the width of a disc: B/√12 in m.
    fn reach(&self) -> f64 {
        slice_height(self.contacts.contact().width)
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
        let tilt = self.slope(at.q).map(|slope| DiscTilt { slope, reach: self.reach() });
        DiscMotion { pose, velocity, modes: &at.q[modes.clone()], rates: &at.v[modes], housing, tilt }
    }

    /// Displacements of the pins in an elastic housing, in m; none in a rigid one.
    fn pin_displacements(&self, q: &[f64]) -> Vec<Vec2> {
        let displacements =
            |modes: &Modes<ElasticHousing>| modes.body.pin_displacements(self.disc, &q[modes.at.clone()]);
        self.housing.as_ref().map_or_else(Vec::new, displacements)
    }

    /// Coordinates on which the pins act in addition to the position of the disc: its own modes, those of the
    /// housing, slopes.
    fn others(&self) -> impl Iterator<Item = usize> {
        let disc = self.elastic.as_ref().map_or(0..0, |modes| modes.at.clone());
        let housing = self.housing.as_ref().map_or(0..0, |modes| modes.at.clone());
        disc.chain(housing).chain(self.slopes.into_iter().flatten())
    }

    /// Forces of the disc on its pins without friction: (pin, force in N in the frame of the ring). They are
    /// opposite to the forces on the disc.
    pub fn pin_forces(&self, at: State<'_>) -> Vec<(usize, Vec2)> {
        if let Some(Modes { body, .. }) = &self.elastic {
            return body.pin_forces(self.disc, &self.contacts, self.motion(at));
        }
        let mut forces = Vec::new();
        for Slice { share, pose, velocity, .. } in self.slices(at) {
            self.contacts.visit(pose, velocity, false, |contact| {
                if contact.force > 0.0 {
                    let rolling = self.contacts.energy_terms(contact).force;
                    let on_disc = |a: usize| share * (contact.force * contact.gradient[a] + rolling[a]);
                    forces.push((contact.pin, -Vec2::new(on_disc(0), on_disc(1))));
                }
            });
        }
        forces
    }

    /// State of every pin.
    pub fn all(&self, at: State<'_>) -> Vec<PinContact> {
        match &self.elastic {
            Some(Modes { body, .. }) => body.pin_contacts(self.disc, &self.contacts, self.motion(at)),
            None => {
                let slices = self.slices(at).into_iter();
                let all = slices.map(|slice| self.contacts.contacts(slice.pose, slice.velocity));
                let mean = |one: Vec<PinContact>, other: Vec<PinContact>| {
                    one.iter().zip(&other).map(|(one, other)| one.mean(other)).collect()
                };
                all.reduce(mean).unwrap_or_default()
            }
        }
    }

    /// State of the loaded pins.
    pub fn loaded(&self, at: State<'_>) -> Vec<PinContact> {
        let mut loaded: Vec<PinContact> = Vec::new();
        self.visit_loaded(at, |slice, contact, force, _| {
            // Contact of the first slice; the other slices act on the same pins.
            let known = if slice == 0 { None } else { loaded.iter_mut().find(|one| one.pin == contact.pin) };
            match known {
                Some(one) => one.force += force,
                None => {
                    let mut contact = *contact;
                    contact.force = force;
                    loaded.push(contact);
                }
            }
        });
        loaded
    }

    /// Calls `visit` for every loaded pin, slice by slice of a rigid disc, with the number of the slice, the
    /// force (N), and its work (N·m) on the approach to the disc deformed by its modes: F s, including the
    /// deformation by neighbouring pins.
    fn visit_loaded(&self, at: State<'_>, mut visit: impl FnMut(usize, &PinContact, f64, f64)) {
        let Some(Modes { body, .. }) = &self.elastic else {
            for (i, Slice { share, pose, velocity, .. }) in self.slices(at).into_iter().enumerate() {
                self.contacts.visit(pose, velocity, false, |contact| {
                    if contact.force > 0.0 {
                        let force = share * contact.force;
                        visit(i, contact, force, -force * contact.gap);
                    }
                });
            }
            return;
        };
        let state = body.contacts(self.disc, &self.contacts, self.motion(at), 0.0);
        for (i, (contact, coupled)) in state.contacts.iter().zip(&state.coupled).enumerate() {
            let (force, local) = (state.forces.force[i], state.forces.local[i]);
            if force > 0.0 {
                let couple = coupled.line(self.contacts.contact()).couple(local).0;
                visit(0, contact, force, force * coupled.approach + couple * coupled.skew);
            }
        }
    }

    /// Passes on forces on (x, y, θ in the ring, modes) as forces on coordinates.
    fn add_forces(&self, pose: DiscPose, q: &[f64], forces: &Forces<'_>, sink: &mut dyn Sink) {
        let Forces { force, stiffness, damping, powers: [stored, dissipation, onset_rate] } = *forces;
        sink.onset(onset_rate);
        if self.moves {
            return self.add_forces_of_moving_ring(pose, q, forces, sink);
        }
        let index: Vec<usize> = self.place[..3].iter().copied().chain(self.others()).collect();
        let gradient: Vec<f64> = force.iter().map(|force| -force).collect();
        let element =
            Element { part: Part::TEETH, index: &index, gradient: &gradient, hessian: stiffness, stored };
        sink.element(&element);
        sink.damper(&index, &vec![0.0; force.len()], damping, dissipation);
    }

    /// Effects of the coordinates (x, y, θ) of disc and housing, then of the others, on the `own` coordinates
    /// in a moving ring.
    fn motions(&self, pose: DiscPose, q: &[f64], own: usize) -> Vec<Motion> {
        let seen = self.pose_jacobian(pose, q);
        let slopes = if self.slopes.is_some() { own - 2..own } else { own..own };
        let places = (0..6).map(|i| Motion::of(&[(0, seen[0][i]), (1, seen[1][i]), (2, seen[2][i])]));
        let modes = (3..slopes.start).map(|m| Motion::of(&[(m, 1.0)]));
        let mut motions: Vec<Motion> = places.chain(modes).collect();
        if !slopes.is_empty() {
            let (x, y) = (slopes.start, slopes.start + 1);
            let (sin, cos) = q[self.place[5]].sin_cos();
            motions.extend([Motion::of(&[(x, cos), (y, -sin)]), Motion::of(&[(x, sin), (y, cos)])]);
            // In the frame of a rotating ring a slope rotates backwards.
            let back = -quarter_turn(self.slope(q).unwrap_or_default());
            let [a, b, c] = [0, 1, 2].map(|a| (a, seen[a][5]));
            motions[5] = Motion::of(&[a, b, c, (x, back.x), (y, back.y)]);
        }
        motions
    }

    /// Transforms contacts over (x, y, θ in the ring, modes, slopes) to the coordinates.
    fn to_mechanism<'a>(&self, pose: DiscPose, q: &[f64], sink: &'a mut dyn Sink) -> ToMechanism<'a> {
        let places = if self.moves { &self.place[..] } else { &self.place[..3] };
        let index: Vec<usize> = places.iter().copied().chain(self.others()).collect();
        let motions = if self.moves { self.motions(pose, q, index.len() - 3) } else { Vec::new() };
        ToMechanism { index, motions, gradient: Vec::new(), push: Vec::new(), sink }
    }

    /// Q = Gᵀ f with G from [`Self::pose_jacobian`], modes unchanged, and its tangent Gᵀ K G − (∂Gᵀ/∂q) f if required.
    fn add_forces_of_moving_ring(&self, pose: DiscPose, q: &[f64], forces: &Forces<'_>, sink: &mut dyn Sink) {
        let Forces { force, stiffness, damping, powers: [stored, dissipation, _] } = *forces;
        let (own, width) = (force.len(), force.len() + 3);
        let slopes = if self.slopes.is_some() { own - 2..own } else { own..own };
        let slope = self.slope(q).unwrap_or_default();
        let motions = self.motions(pose, q, own);
        let through = |m: &[f64]| -> Vec<f64> {
            if m.is_empty() {
                return Vec::new();
            }
            let mut seen = vec![0.0; width * width];
            for (i, by_row) in motions.iter().enumerate() {
                for (j, by_column) in motions.iter().enumerate() {
                    let column =
                        |a: usize| by_column.list().iter().map(|(b, h)| m[a * own + b] * h).sum::<f64>();
                    seen[i * width + j] = by_row.list().iter().map(|(a, g)| g * column(*a)).sum();
                }
            }
            seen
        };
        let mut hessian = through(stiffness);
        let gradient: Vec<f64> = motions
            .iter()
            .map(|by_row| -by_row.list().iter().map(|(a, g)| g * force[*a]).sum::<f64>())
            .collect();
        let index: Vec<usize> = self.place.iter().copied().chain(self.others()).collect();
        // J R f: rotation of the force on the disc with the housing, and of the couple on its tilt.
        let turning = |x: f64, y: f64| quarter_turn(turned(Vec2::new(x, y), unit(q[self.place[5]])));
        if !hessian.is_empty() {
            let place = turning(force[0], force[1]);
            let mut turns = vec![(0, place.x), (1, place.y), (3, -place.x), (4, -place.y)];
            let mut back = force[0] * pose.centre.x + force[1] * pose.centre.y;
            if !slopes.is_empty() {
                let couple = [force[slopes.start], force[slopes.start + 1]];
                let tilt = turning(couple[0], couple[1]);
                turns.extend([(width - 2, tilt.x), (width - 1, tilt.y)]);
                back += couple[0] * slope.x + couple[1] * slope.y;
            }
            for (i, value) in turns {
                hessian[i * width + 5] -= value;
                hessian[5 * width + i] -= value;
            }
            hessian[5 * width + 5] += back;
        }
        let element =
            Element { part: Part::TEETH, index: &index, gradient: &gradient, hessian: &hessian, stored };
        sink.element(&element);
        sink.damper(&index, &vec![0.0; width], &through(damping), dissipation);
    }
}

impl Joint for PinRing {
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink) {
        let motion = self.motion(at);
        let wanted = sink.contact_request();
        match &self.elastic {
            None => {
                let width = if self.slopes.is_some() { 5 } else { 3 };
                let sum = match wanted {
                    None => self.react_of_slices(at, None),
                    Some(wanted) => {
                        let mut transform = self.to_mechanism(motion.pose, at.q, sink);
                        self.react_of_slices(at, Some((wanted, &mut |contact| transform.add(contact))))
                    }
                };
                self.add_forces(motion.pose, at.q, &sum.forces(width), sink);
            }
            Some(Modes { body, .. }) => {
                let tangents = sink.takes_stiffness();
                let reaction = match wanted {
                    None => body.react(self.disc, &self.contacts, motion, tangents, None),
                    Some(wanted) => {
                        let mut transform = self.to_mechanism(motion.pose, at.q, sink);
                        let mut visit_contact = |contact: &RingContact<'_>| transform.add(contact);
                        body.react(
                            self.disc,
                            &self.contacts,
                            motion,
                            tangents,
                            Some((wanted, &mut visit_contact)),
                        )
                    }
                };
                let forces = Forces {
                    force: &reaction.force,
                    stiffness: &reaction.stiffness,
                    damping: &reaction.damping,
                    powers: [reaction.stored, reaction.dissipation, reaction.onset_rate],
                };
                self.add_forces(motion.pose, at.q, &forces, sink);
            }
        }
    }

    fn limits(&self, q: &[f64], reach: f64, add: &mut dyn FnMut(Limit<'_>)) {
        self.elastic.iter().flat_map(|modes| modes.at.clone()).for_each(|at| add(Limit::Held(at)));
        self.slopes.iter().flatten().for_each(|at| add(Limit::Held(*at)));
        let rest = vec![0.0; q.len()];
        let (pose, _) = self.disc_state(State { q, v: &rest });
        let shifts = self.pin_displacements(q);
        let moved = Displacements { shifts: &shifts, lift: reach };
        let seen = self.moves.then(|| self.pose_jacobian(pose, q));
        self.contacts.visit_displaced(pose, DiscVelocity::REST, false, moved, |contact| {
            let mut pin = |index: &[usize], gradient: &[f64]| {
                add(Limit::Pin(Distance { index, gradient, value: contact.gap, stiffness: PIN }));
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
        let g = self
            .pose_jacobian(state.pose, at.q)
            .map(|row| row.iter().zip(&by_place).map(|(s, g)| s * g).sum());
        let others: Vec<f64> = self.others().map(|at| motion[at]).collect();
        let (teeth, seats) = match &self.elastic {
            None => self.split_of_rigid_disc(at, g, &others),
            Some(Modes { body, .. }) => {
                let whole: Vec<f64> = g.into_iter().chain(others).collect();
                let DiscSplit { teeth, seats, disc } = body.split(self.disc, &self.contacts, state, &whole);
                add(Part::DISC, disc);
                (teeth, seats)
            }
        };
        add(Part::TEETH, teeth);
        add(Part::PIN_SEAT, seats);
    }

    fn work(&self, at: State<'_>, nominal: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        if let Some(Modes { body, at: modes }) = &self.elastic {
            add(Cause::ELASTIC, body.modal_work(self.disc, &at.q[modes.clone()]));
        }
        self.work_of_gaps(at, nominal, add);
    }

    fn elastic(&self, add: &mut dyn FnMut(&[usize], &[f64])) {
        let Some(Modes { body, at }) = &self.elastic else { return };
        at.clone().zip(body.mode_stiffness(self.disc)).for_each(|(at, stiffness)| add(&[at], &[*stiffness]));
    }

    fn set_friction(&mut self, sliding: Sliding) {
        self.contacts.set_sliding(Some(sliding));
    }

    fn scale_friction(&mut self, share: f64) {
        let less = |sliding: &Sliding| Sliding { coefficient: share * sliding.coefficient, ..*sliding };
        let sliding = self.contacts.sliding().map(less);
        self.contacts.set_sliding(sliding);
    }

    fn add_forces(&self, at: State<'_>, summary: &mut ForceSummary) {
        let law = self.contacts.contact();
        for contact in self.loaded(at) {
            summary.add_pin(contact.force, law.pressure(contact.force, 1.0 / contact.relative_curvature));
        }
    }

    fn boxed(&self) -> Box<dyn Joint> {
        Box::new(self.clone())
    }
}
