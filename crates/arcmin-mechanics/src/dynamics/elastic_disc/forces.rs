//! Forces of pins and elasticity on a disc, their tangents, and the contacts one by one.

use super::{DiscContacts, DiscMotion, ElasticDiscs, ElasticReaction, Products};
use crate::contact::{ContactSpring, PinContact, PinContacts, TOLERABLE_DEPTH};
use crate::dynamics::mechanism::{ContactRequest, RingContact};
use crate::dynamics::system::FlankPlace;
use crate::fem::CoupledContact;

impl ElasticDiscs {
    /// Forces of pins and elasticity on a disc with their matrices, which are empty without `tangents`. If
    /// single contacts are requested, the receiver in `wanted` gets them, and the stiffness over (x, y, θ) does
    /// not contain theirs along the gaps.
    pub(in crate::dynamics) fn react(
        &self,
        disc: usize,
        ring: &PinContacts,
        motion: DiscMotion<'_>,
        tangents: bool,
        mut wanted: Option<(ContactRequest, &mut dyn FnMut(&RingContact<'_>))>,
    ) -> ElasticReaction {
        let count = motion.modes.len();
        let (first, width) = (3 + count, motion.width());
        let reach = wanted.as_ref().map_or(0.0, |(wanted, _)| wanted.reach);
        let interval = wanted.as_ref().and_then(|(wanted, _)| wanted.slip_interval);
        let state = self.contacts(disc, ring, motion, reach);
        let n = state.contacts.len();
        let matrix = || vec![0.0; if tangents { width * width } else { 0 }];
        let mut reaction = ElasticReaction {
            force: vec![0.0; width],
            stiffness: matrix(),
            damping: matrix(),
            stored: state.forces.flexural_energy,
            ..ElasticReaction::default()
        };
        let law = ring.contact();
        // Rows −∂s/∂z, and the effect of each force on the coordinates including friction; not required for
        // forces alone.
        let has_rows = tangents || wanted.is_some();
        let size = if has_rows { n * width } else { 0 };
        let (mut rows, mut pushes) = (vec![0.0; size], vec![0.0; size]);
        let mut gain = vec![0.0; n];
        // Force (N, N·m) of each contact on (x, y, θ).
        let mut on_pose = vec![[0.0; 3]; n];
        let mut products = Products::new(width);
        let (mut along_tilt, mut turning) = (vec![0.0; width], vec![0.0; width]);
        for (i, contact) in state.contacts.iter().enumerate() {
            let (local, rate) = (state.forces.local[i], state.rate[i]);
            let line = state.coupled[i].line(law);
            let here = line.damped_force(local, rate);
            if local <= 0.0 && rate > 0.0 {
                reaction.onset_rate = reaction.onset_rate.max(rate / (TOLERABLE_DEPTH - local));
            }
            reaction.stored += here.stored;
            reaction.dissipation += (here.force - here.elastic) * rate;
            if has_rows {
                let row = &mut rows[i * width..(i + 1) * width];
                motion.expand(disc, contact.pin, contact.gradient, row);
                row[3..first].copy_from_slice(&state.shape[i * count..(i + 1) * count]);
            }
            if here.force <= 0.0 {
                continue;
            }
            gain[i] = here.stiffness / state.forces.local_stiffness[i];
            let (share, slope) =
                ring.sliding().map_or((0.0, 0.0), |sliding| sliding.share(contact.sliding_speed));
            reaction.dissipation += share * here.force * contact.sliding_speed;
            on_pose[i] = contact.gradient.map(|gradient| here.force * gradient);
            (0..3).for_each(|a| reaction.force[a] -= share * here.force * contact.along[a]);
            let shape = &state.shape[i * count..(i + 1) * count];
            reaction.force[3..first].iter_mut().zip(shape).for_each(|(sum, phi)| *sum += here.force * phi);
            if has_rows {
                let (row, push) = (&rows[i * width..][..width], &mut pushes[i * width..][..width]);
                push.copy_from_slice(row);
                push.iter_mut().zip(contact.along).for_each(|(push, along)| *push -= share * along);
            }
            let hessian = || contact.gap_hessian(ring.pins()[contact.pin].radius);
            if let Some(tilt) = motion.tilt {
                let (couple, across) = line.couple(local);
                let hessian = hessian();
                // −∂ε/∂z: the normal, along which the tilt changes the approach, rotates with the disc.
                let turn = tilt.by_pose(1.0, &hessian);
                (0..3).for_each(|a| on_pose[i][a] += couple * turn[a]);
                (0..2)
                    .for_each(|a| reaction.force[width - 2 + a] += couple * tilt.reach * contact.gradient[a]);
                if tangents {
                    motion.expand(disc, contact.pin, turn, &mut along_tilt);
                    (0..2).for_each(|a| along_tilt[width - 2 + a] = tilt.reach * contact.gradient[a]);
                    // −∂²ε/∂(slope)∂z.
                    for a in 0..2 {
                        motion.expand(disc, contact.pin, hessian[a], &mut turning);
                        for (i, turn) in turning[..width - 2].iter().enumerate() {
                            let value = couple * tilt.reach * turn;
                            reaction.stiffness[(width - 2 + a) * width + i] -= value;
                            reaction.stiffness[i * width + width - 2 + a] -= value;
                        }
                    }
                }
                if tangents && wanted.is_none() && across > 0.0 {
                    // With F(δ, ε) and the couple M(δ, ε): dF = k (dδ + r dε) and dM = r dF + (k − r² k) dε,
                    // where r = (∂F/∂ε)/k, so that the skew counts as an approach of r and the force as a
                    // couple of r. The stiffness of single contacts is added by their receiver.
                    let ratio = line.cross(local) / across;
                    let (row, push) = (&mut rows[i * width..][..width], &mut pushes[i * width..][..width]);
                    for (i, along) in along_tilt.iter().enumerate() {
                        row[i] += ratio * along;
                        push[i] += ratio * along;
                    }
                    let apart = across - ratio * ratio * across;
                    products.push(
                        |row| row.copy_from_slice(&along_tilt),
                        |row| row.iter_mut().zip(&along_tilt).for_each(|(row, along)| *row = apart * along),
                    );
                }
            }
            if wanted.is_some() {
                let hessian = hessian();
                for a in 0..3 {
                    for b in 0..3 {
                        reaction.stiffness[a * width + b] -= here.force * hessian[a][b];
                    }
                }
                continue;
            }
            if !tangents {
                continue;
            }
            let hessian = hessian();
            let (row, push) = (&rows[i * width..][..width], &pushes[i * width..][..width]);
            reaction.add_damping(&here, (row, push), slope, contact, (&hessian, motion.velocity));
            // A displacement of the pin rotates the normal like an opposite displacement of the disc.
            for a in 0..3 {
                let along: [f64; 3] = std::array::from_fn(|b| if a == b { 1.0 } else { 0.0 });
                let turning = hessian[a].map(|entry| -here.force * entry);
                products.push(
                    |row| motion.expand(disc, contact.pin, along, row),
                    |row| motion.expand(disc, contact.pin, turning, row),
                );
            }
        }
        let whole = tangents && wanted.is_none();
        let matrices = has_rows.then_some((&mut rows[..], &mut pushes[..]));
        let summed = whole.then_some(&mut products);
        self.add_rolling(disc, ring, &state, motion, &mut on_pose, matrices, summed);
        let mut expanded = vec![0.0; width];
        for (contact, on_pose) in
            state.contacts.iter().zip(on_pose).filter(|(_, on_pose)| *on_pose != [0.0; 3])
        {
            motion.expand(disc, contact.pin, on_pose, &mut expanded);
            reaction.force.iter_mut().zip(&expanded).for_each(|(sum, force)| *sum += force);
        }
        if let Some((_, visit)) = &mut wanted {
            self.visit_contacts(disc, ring, &state, motion, (&rows, &pushes), interval, visit);
        }
        if whole {
            // −∂Q/∂z = Pᵀ (∂F/∂s) B, with ∂F/∂s = gain D.
            state.forces.respond_to_all(&mut rows, width);
            for (row, gain) in rows.chunks_exact_mut(width).zip(&gain) {
                row.iter_mut().for_each(|entry| *entry *= gain);
            }
            products.extend(&pushes, &rows);
            products.add_to(&mut reaction.stiffness);
        }
        self.add_modal_forces(disc, motion, &mut reaction);
        reaction
    }

    /// Calls `visit` for each contact, for each of two slices if the disc tilts.
    fn visit_contacts(
        &self,
        disc: usize,
        ring: &PinContacts,
        state: &DiscContacts,
        motion: DiscMotion<'_>,
        (rows, pushes): (&[f64], &[f64]),
        interval: Option<f64>,
        visit: &mut dyn FnMut(&RingContact<'_>),
    ) {
        let (count, width) = (motion.modes.len(), motion.width());
        let law = *ring.contact();
        let mut show =
            |contact: &PinContact, coupled: &CoupledContact, local: f64, row: &[f64], push: &[f64]| {
                let place = Some(FlankPlace { disc, stencil: coupled.place });
                let radius = coupled.equivalent_radius;
                let Some(tilt) = motion.tilt else {
                    let spring = ContactSpring::Line { law, radius, share: 1.0 };
                    let pressed = spring.at(local);
                    return visit(&RingContact { gap: -local, gradient: row, push, spring, pressed, place });
                };
                let mut along = vec![0.0; width];
                let hessian = contact.gap_hessian(ring.pins()[contact.pin].radius);
                motion.expand(disc, contact.pin, tilt.by_pose(1.0, &hessian), &mut along);
                (0..2).for_each(|a| along[width - 2 + a] = tilt.reach * contact.gradient[a]);
                for side in [1.0, -1.0] {
                    let spring = ContactSpring::Line { law, radius, share: 0.5 };
                    let leaned = |row: &[f64]| {
                        row.iter().zip(&along).map(|(row, along)| row + side * along).collect::<Vec<f64>>()
                    };
                    let (gradient, push) = (&leaned(row), &leaned(push));
                    let approach = local + side * coupled.skew;
                    let pressed = spring.at(approach);
                    visit(&RingContact { gap: -approach, gradient, push, spring, pressed, place });
                }
            };
        for (i, contact) in state.contacts.iter().enumerate() {
            let (row, push) = (&rows[i * width..][..width], &pushes[i * width..][..width]);
            let push = if state.forces.force[i] > 0.0 { push } else { row };
            show(contact, &state.coupled[i], state.forces.local[i], row, push);
        }
        let mut row = vec![0.0; width];
        for (i, contact) in state.near.iter().enumerate() {
            row.fill(0.0);
            motion.expand(disc, contact.pin, contact.gradient, &mut row);
            row[3..3 + count].copy_from_slice(&state.near_shapes[i * count..][..count]);
            let coupled = &state.near_coupled[i];
            show(
                contact,
                coupled,
                coupled.approach - state.bent_at(&self.bodies[disc].residual, coupled),
                &row,
                &row,
            );
        }
        if let (Some(sliding), Some(interval)) = (ring.sliding(), interval) {
            for (contact, force) in
                state.contacts.iter().zip(&state.forces.force).filter(|(_, force)| **force > 0.0)
            {
                row.fill(0.0);
                row[..3].copy_from_slice(&contact.along);
                visit(&RingContact::slip(sliding, contact, *force, &row, interval));
            }
        }
    }

    fn add_modal_forces(&self, disc: usize, motion: DiscMotion<'_>, reaction: &mut ElasticReaction) {
        let width = reaction.force.len();
        for (m, square) in self.bodies[disc].modes.eigenvalues.iter().enumerate() {
            let damping = 2.0 * self.damping_ratio * square.sqrt();
            let (q, rate) = (motion.modes[m], motion.rates[m]);
            reaction.stored += 0.5 * square * q * q;
            reaction.dissipation += damping * rate * rate;
            reaction.force[3 + m] -= square * q + damping * rate;
            if !reaction.stiffness.is_empty() {
                let diagonal = (3 + m) * (width + 1);
                reaction.stiffness[diagonal] += square;
                reaction.damping[diagonal] += damping;
            }
        }
    }
}
