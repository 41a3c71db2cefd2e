use super::{DiscMotion, ElasticDiscs};
use crate::contact::PinContacts;

/// Tangent compliance of a disc and its contacts along one motion.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::dynamics) struct DiscSplit {
    pub teeth: f64,
    pub seats: f64,
    pub disc: f64,
}

impl ElasticDiscs {
    /// Division of gᵀ K g, for a motion g of (x, y, θ, q, η), between pins and disc: with ds = −B g and dF = D
    /// ds the energy of modes and residual compliance changes by ω² g_q² and dFᵀ C dF, that of the seats by c
    /// dF²; the remainder is that of the contacts, including the rotation of their normals.
    pub(in crate::dynamics) fn split(
        &self,
        disc: usize,
        ring: &PinContacts,
        motion: DiscMotion<'_>,
        g: &[f64],
    ) -> DiscSplit {
        let (count, width) = (motion.modes.len(), g.len());
        let stiffness = self.react(disc, ring, motion, true, None).stiffness;
        let whole: f64 =
            (0..width).map(|a| (0..width).map(|b| g[a] * stiffness[a * width + b] * g[b]).sum::<f64>()).sum();
        let state = self.contacts(disc, ring, motion, 0.0);
        let change: Vec<f64> = state
            .contacts
            .iter()
            .enumerate()
            .map(|(i, contact)| {
                let modes: f64 =
                    state.shape[i * count..(i + 1) * count].iter().zip(&g[3..]).map(|(phi, g)| phi * g).sum();
                let pins: f64 = motion.housing.map_or(0.0, |housing| {
                    let rows = housing.rows(disc, contact.pin, contact.gradient);
                    rows.zip(&g[3 + count..]).map(|(row, g)| row * g).sum()
                });
                contact.gradient.iter().zip(g).map(|(s, g)| s * g).sum::<f64>() + modes + pins
            })
            .collect();
        let mut response = change.clone();
        state.forces.respond(&mut response, &mut Vec::new());
        let mut split = DiscSplit { disc: self.modal_work(disc, &g[3..]), ..DiscSplit::default() };
        for i in (0..state.contacts.len()).filter(|i| state.forces.force[*i] > 0.0) {
            let square = response[i] * response[i];
            split.seats += ring.contact().seat_compliance() * square;
            split.disc += change[i] * response[i] - square / state.forces.local_stiffness[i];
        }
        split.teeth = whole - split.seats - split.disc;
        split
    }
}
