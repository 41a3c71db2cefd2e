use super::{DiscContacts, DiscMotion, ElasticDiscs, ElasticReaction};
use crate::contact::{PinContacts, Rolling};
use crate::geometry::Vec2;

/// How one contact travels along a flank that is bent.
struct Travel {
    rolling: Rolling,
    /// φ′·q + Σ C′ F: slope of the bent flank in m/rad.
    bent: f64,
    /// −∂U/∂τ in N·m/rad.
    pull: f64,
    /// φ′ of the modes.
    turns: Vec<f64>,
}

impl ElasticDiscs {
    /// What makes the forces the gradient of the stored energy: its derivative with the places of the
    /// contacts, −∂U/∂τ_i = F_i φ′_i·q + ½ ∂(FᵀCF)/∂τ_i − ∂W_i/∂ln R · (ln R)′. It acts along the flank: the
    /// slope of the deformed flank under the contact force, and the work of rolling to another curvature. It
    /// is 1e-3 of the contact force, but near the root a contact travels far for little motion of the disc:
    /// the tangents that go with φ′ are a per cent there. Those of the curvature are left out, as on the
    /// rigid disc.
    pub(super) fn add_rolling(
        &self,
        disc: usize,
        ring: &PinContacts,
        state: &DiscContacts,
        motion: DiscMotion<'_>,
        (rows, pushes): (&mut [f64], &mut [f64]),
        reaction: &mut ElasticReaction,
    ) {
        let width = reaction.force.len();
        let first = 3 + motion.modes.len();
        for (i, contact) in state.contacts.iter().enumerate().filter(|(i, _)| state.forces.force[*i] > 0.0) {
            let Travel { rolling, bent, pull, turns } = self.travel(disc, ring, state, motion.modes, i);
            let force = state.forces.force[i];
            let push: [f64; 3] =
                std::array::from_fn(|a| pull * rolling.by_pose[a] + force * rolling.gap_slope[a]);
            let mut by_place = rolling.by_pose.to_vec();
            let mut pushed = push.to_vec();
            by_place.resize(first, 0.0);
            pushed.resize(first, 0.0);
            if let Some(pins) = motion.housing {
                by_place.extend(pins.rows(disc, contact.pin, rolling.by_pose));
                pushed.extend(pins.rows(disc, contact.pin, push));
            }
            for a in (0..3).chain(first..width) {
                for (m, turn) in turns.iter().enumerate() {
                    let coupling = force * turn * by_place[a];
                    reaction.stiffness[a * width + 3 + m] -= coupling;
                    reaction.stiffness[(3 + m) * width + a] -= coupling;
                }
                reaction.force[a] += pushed[a];
                // The approach changes with the place as well.
                rows[i * width + a] += bent * by_place[a];
                pushes[i * width + a] += bent * by_place[a];
            }
        }
    }

    fn travel(&self, disc: usize, ring: &PinContacts, state: &DiscContacts, q: &[f64], i: usize) -> Travel {
        let (body, forces, contact) = (&self.bodies[disc], &state.forces.force, &state.contacts[i]);
        let slope = self.discs.slope_stencil(disc, contact.tau);
        let rolling = ring.rolling(contact);
        let others: f64 = (0..forces.len())
            .filter(|j| *j != i && forces[*j] > 0.0)
            .map(|j| forces[j] * body.residual.cross(&slope, &state.coupled[j].place))
            .sum();
        let turns: Vec<f64> = (0..q.len()).map(|m| body.modes.at(m, &slope)).collect();
        let mut bent = forces[i] * body.residual.own(&slope) + others;
        q.iter().zip(&turns).for_each(|(q, turn)| bent += q * turn);
        let pull = forces[i] * (bent - 0.5 * forces[i] * body.residual.own(&slope))
            - ring.contact().energy_by_log_radius(forces[i]) * rolling.log_radius_slope;
        Travel { rolling, bent, pull, turns }
    }

    /// What the disc does to its pins: (pin, force in N in the frame of the ring), friction aside.
    pub(in crate::dynamics) fn pin_forces(
        &self,
        disc: usize,
        ring: &PinContacts,
        motion: DiscMotion<'_>,
    ) -> Vec<(usize, Vec2)> {
        let state = self.contacts(disc, ring, motion);
        let loaded = (0..state.contacts.len()).filter(|i| state.forces.force[*i] > 0.0);
        loaded
            .map(|i| {
                let (contact, force) = (&state.contacts[i], state.forces.force[i]);
                let Travel { rolling, pull, .. } = self.travel(disc, ring, &state, motion.modes, i);
                let on_disc = |a: usize| {
                    force * contact.gradient[a] + pull * rolling.by_pose[a] + force * rolling.gap_slope[a]
                };
                (contact.pin, -Vec2::new(on_disc(0), on_disc(1)))
            })
            .collect()
    }
}
