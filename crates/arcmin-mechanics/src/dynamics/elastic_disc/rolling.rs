use super::{DiscContacts, DiscMotion, ElasticDiscs, Products};
use crate::contact::{PinContacts, Rolling};
use crate::geometry::Vec2;

/// Displacement of one contact along a deformed flank.
struct Travel {
    rolling: Rolling,
    /// φ′·q + Σ C′ F: slope of the bent flank in m/rad.
    bent: f64,
    /// −∂U/∂τ in N·m/rad.
    pull: f64,
    /// φ′ of the modes.
    turns: Vec<f64>,
    /// C′ of this place under a force on each contact, in m/(N·rad); zero for its own.
    crossed: Vec<f64>,
}

impl ElasticDiscs {
    /// Derivative of the stored energy with respect to the positions of the contacts, −∂U/∂τ_i = F_i φ′_i·q + ½
    /// ∂(FᵀCF)/∂τ_i − ∂W_i/∂ln R · (ln R)′; with it the forces are the gradient of the energy. It acts along
    /// the flank: slope of the deformed flank under the contact force, and work of rolling to another
    /// curvature. It is 1e-3 of the contact force, but near the root a contact is displaced far by a small
    /// motion of the disc, and the tangents with φ′ are 1 % there.
    ///
    /// Adds to the force of each contact on (x, y, θ). Changes `rows` and `pushes` of all contacts, if they are
    /// not empty, by the displacement along the flank; all other terms of the tangent are added to `products`,
    /// if given.
    pub(super) fn add_rolling(
        &self,
        disc: usize,
        ring: &PinContacts,
        state: &DiscContacts,
        motion: DiscMotion<'_>,
        on_pose: &mut [[f64; 3]],
        mut matrices: Option<(&mut [f64], &mut [f64])>,
        mut products: Option<&mut Products>,
    ) {
        let (width, first) = (motion.width(), 3 + motion.modes.len());
        let (mut by_place, mut pushed) = (vec![0.0; width], vec![0.0; width]);
        for (i, contact) in state.contacts.iter().enumerate().filter(|(i, _)| state.forces.force[*i] > 0.0) {
            let Travel { rolling, bent, pull, turns, crossed } =
                self.travel(disc, ring, state, motion.modes, i);
            let own = state.forces.force[i];
            for a in 0..3 {
                on_pose[i][a] += pull * rolling.by_pose[a] + own * rolling.gap_slope[a];
            }
            let Some((rows, pushes)) = &mut matrices else { continue };
            // As in `PinContacts::energy_terms`: change of the force with the curvature and the flank error.
            let by_curvature =
                2.0 * ring.contact().energy_by_log_radius(own) / own * rolling.log_radius_slope;
            let steered: [f64; 3] =
                std::array::from_fn(|a| (bent - by_curvature) * rolling.by_pose[a] + rolling.gap_slope[a]);
            motion.expand(disc, contact.pin, rolling.by_pose, &mut by_place);
            // The approach also changes with the position along the flank.
            motion.expand(disc, contact.pin, steered, &mut pushed);
            for all in [&mut **rows, &mut **pushes] {
                let row = all[i * width..][..width].iter_mut();
                row.zip(&pushed).for_each(|(entry, steered)| *entry += steered);
            }
            // So do those of the other contacts, because C_ij is that of the new position i.
            for (j, slope) in crossed.iter().enumerate().filter(|(_, slope)| **slope != 0.0) {
                for all in [&mut **rows, &mut **pushes] {
                    let row = all[j * width..][..width].iter_mut();
                    row.zip(&by_place).for_each(|(entry, by)| *entry += own * slope * by);
                }
            }
            let Some(products) = products.as_deref_mut() else { continue };
            let bent_by_others = self.bend_with_others(disc, state, i, |j| {
                let mut by_place = vec![0.0; width];
                let contact = &state.contacts[j];
                motion.expand(disc, contact.pin, ring.rolling(contact).by_pose, &mut by_place);
                by_place
            });
            let turn = |row: &mut [f64]| {
                row[3..first].iter_mut().zip(&turns).for_each(|(entry, turn)| *entry = -own * turn);
            };
            let radius =
                ring.contact().energy_by_log_radius(own) * ring.log_radius_bend(&state.contacts[i], &rolling);
            let bend = own * self.bend(disc, state, motion.modes, i) - radius;
            products.push(
                |row| row.copy_from_slice(&by_place),
                |row| row.iter_mut().zip(&by_place).for_each(|(entry, by)| *entry = -bend * by),
            );
            products.push(
                |row| row.copy_from_slice(&by_place),
                |row| row.iter_mut().zip(&bent_by_others).for_each(|(entry, by)| *entry = -own * by),
            );
            let of_place = ring.place_bend(contact, &rolling);
            for (a, row_of_place) in of_place.iter().enumerate() {
                let along: [f64; 3] = std::array::from_fn(|b| if a == b { 1.0 } else { 0.0 });
                let turned = row_of_place.map(|entry| -pull * entry);
                products.push(
                    |row| motion.expand(disc, contact.pin, along, row),
                    |row| motion.expand(disc, contact.pin, turned, row),
                );
            }
            products.push(|row| row.copy_from_slice(&by_place), turn);
            products.push(turn, |row| row.copy_from_slice(&by_place));
        }
    }

    fn travel(&self, disc: usize, ring: &PinContacts, state: &DiscContacts, q: &[f64], i: usize) -> Travel {
        let (body, forces, contact) = (&self.bodies[disc], &state.forces.force, &state.contacts[i]);
        let slope = self.discs.slope_stencil(disc, contact.tau);
        let rolling = ring.rolling(contact);
        let cross = |j: usize| {
            if j == i { 0.0 } else { body.residual.cross(&slope, &state.coupled[j].place) }
        };
        let crossed: Vec<f64> = (0..forces.len()).map(cross).collect();
        let others: f64 = forces.iter().zip(&crossed).map(|(force, slope)| force * slope).sum();
        let turns: Vec<f64> = (0..q.len()).map(|m| body.modes.at(m, &slope)).collect();
        let mut bent = forces[i] * body.residual.own(&slope) + others;
        q.iter().zip(&turns).for_each(|(q, turn)| bent += q * turn);
        let pull = forces[i] * (bent - 0.5 * forces[i] * body.residual.own(&slope))
            - ring.contact().energy_by_log_radius(forces[i]) * rolling.log_radius_slope;
        Travel { rolling, bent, pull, turns, crossed }
    }

    /// Second derivative of the bent flank with the place of one contact at constant forces, in m/rad².
    fn bend(&self, disc: usize, state: &DiscContacts, q: &[f64], i: usize) -> f64 {
        let (body, forces) = (&self.bodies[disc], &state.forces.force);
        let place = self.discs.bend_stencil(disc, state.contacts[i].tau);
        let others = (0..forces.len()).filter(|j| *j != i && forces[*j] > 0.0);
        let crossed: f64 =
            others.map(|j| forces[j] * body.residual.cross(&place, &state.coupled[j].place)).sum();
        let modal: f64 = q.iter().enumerate().map(|(m, q)| q * body.modes.at(m, &place)).sum();
        modal + crossed + 0.5 * forces[i] * body.residual.own(&place)
    }

    /// Σ_j F_j ∂²C_ij/∂τ_i∂τ_j ∂τ_j/∂z over the loaded contacts j ≠ i, in m/rad per unit of z.
    fn bend_with_others(
        &self,
        disc: usize,
        state: &DiscContacts,
        i: usize,
        by_place: impl Fn(usize) -> Vec<f64>,
    ) -> Vec<f64> {
        let (body, forces) = (&self.bodies[disc], &state.forces.force);
        let slope = |j: usize| self.discs.slope_stencil(disc, state.contacts[j].tau);
        let here = slope(i);
        let mut sum = Vec::new();
        for j in (0..forces.len()).filter(|j| *j != i && forces[*j] > 0.0) {
            let factor = forces[j] * body.residual.cross(&here, &slope(j));
            let by = by_place(j);
            sum.resize(by.len(), 0.0);
            sum.iter_mut().zip(&by).for_each(|(sum, by)| *sum += factor * by);
        }
        sum
    }

    /// Forces of the disc on its pins without friction: (pin, force in N in the frame of the ring).
    pub(in crate::dynamics) fn pin_forces(
        &self,
        disc: usize,
        ring: &PinContacts,
        motion: DiscMotion<'_>,
    ) -> Vec<(usize, Vec2)> {
        let state = self.contacts(disc, ring, motion, 0.0);
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
