mod contacts;
mod forces;
mod motion;
mod reaction;
mod rolling;
mod split;

use std::sync::Arc;

use contacts::{DiscContacts, REACH};
pub(super) use motion::{DiscMotion, DiscTilt, HousingMotion};
pub(super) use reaction::ElasticReaction;
use reaction::Products;
pub(super) use split::DiscSplit;

use super::DynamicsError;
use super::system::FlankPlace;
use crate::contact::{PinContact, PinContacts};
use crate::fem::{BoreMotion, DiscShape, FlankCompliance, FlankModes, FlexibleDiscs, FreeModes};
use crate::geometry::{turned, unit};
use crate::machine::Machine;
use crate::materials::Material;

/// Options of elastic discs beyond rigid ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlexibleOptions {
    /// Held modes up to this frequency in Hz are coordinates; the compliance of the others acts without
    /// inertia.
    pub mode_frequency: f64,
    /// ζ of every mode.
    pub damping_ratio: f64,
}

impl Default for FlexibleOptions {
    /// The three lowest held modes of an RV-40E's disc; bolted and fitted steel parts damp about 2 %.
    fn default() -> Self {
        FlexibleOptions { mode_frequency: 20e3, damping_ratio: 0.02 }
    }
}

impl FlexibleOptions {
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for damping or frequencies without meaning.
    pub fn validate(&self) -> Result<(), DynamicsError> {
        let check = DynamicsError::require;
        check(
            self.damping_ratio >= 0.0 && self.damping_ratio < 1.0,
            "modal damping ratio",
            self.damping_ratio,
            "",
            "must lie in [0, 1)",
        )?;
        check(self.mode_frequency >= 0.0, "mode frequency", self.mode_frequency, "Hz", "must not be negative")
    }
}

/// Data shared by equal discs.
#[derive(Debug)]
struct Body {
    modes: FlankModes,
    /// Displacement of every bore per unit of a mode in the frame of the reduction, mode after mode; empty if
    /// the bores are held.
    bores: Vec<BoreMotion>,
    /// Whether the rims of the bores are deformable (ovalisation).
    rims: bool,
    /// Static compliance of the flank in addition to the modes, with held bores.
    residual: FlankCompliance,
    /// Largest outward displacement of the flank: per unit of each mode, and in m/N by the residual compliance.
    peaks: Vec<f64>,
    largest_lift: f64,
}

impl Body {
    /// Discs held at their bores.
    fn held(modes: FlankModes, residual: FlankCompliance) -> Body {
        let peaks = (0..modes.count()).map(|mode| modes.peak(mode)).collect();
        let largest_lift = residual.largest_lift();
        Body { peaks, largest_lift, modes, bores: Vec::new(), rims: false, residual }
    }

    /// Discs whose bores are free.
    fn free(free: FreeModes, count: usize, residual: FlankCompliance) -> Body {
        let bores = (0..free.flank.count()).flat_map(|mode| (0..count).map(move |bore| (mode, bore)));
        let bores = bores.map(|(mode, bore)| free.bore(mode, bore)).collect();
        Body { bores, rims: free.rims, ..Body::held(free.flank, residual) }
    }
}

/// Elastic discs in contact with pins and in bearings.
///
/// A disc is a frame (centre, angle) with modes relative to it, u = Φ q. The flank is displaced by u_i =
/// φ(τ_i)·q + Σ_j C^res_ij F_j along its inward normal: by the modes that are coordinates, and by the static
/// compliance of all others. Contacts are searched on the analytic (worn) flank; their approach s_i = −gap_i −
/// φ_i·q is the argument of the coupled contact law. There are thus neither facets nor a second contact
/// stiffness, and the frequencies of omitted modes do not limit the step. Forces are the gradient of the stored
/// energy U = min over F of Σ W_i(δ_i, R_i) + ½ FᵀC^res F, plus ½ ω² q²; modal damping 2 ζ ω q̇.
///
/// With ideal joints the frame is that of the bores, and the modes are those of the disc held at its bores. In
/// bearings the frame is that of the mean axes and the modes are those of the free disc. They displace the bore
/// centres and, on discs reduced with [`BoreInterface::Rims`](crate::fem::BoreInterface::Rims), ovalise the
/// rims; the kinetic energy is ½ m v² + ½ J θ̇² + ½ q̇². Mass and moment of inertia of the rigid motion are
/// those of the machine, those of the modes are from the mesh.
///
/// Not modelled: Coriolis and centrifugal forces of the deformation, the tangential displacement of the flank.
#[derive(Debug, Clone)]
pub struct ElasticDiscs {
    discs: FlexibleDiscs,
    bodies: Vec<Arc<Body>>,
    /// Displacements of the bores disc by disc in the disc's own frame: mode after mode, bores in the order of
    /// the shape.
    bores: Vec<Vec<BoreMotion>>,
    damping_ratio: f64,
}

impl ElasticDiscs {
    /// Discs held at their bores.
    ///
    /// # Errors
    /// As [`FlexibleOptions::validate`].
    pub fn held(discs: FlexibleDiscs, options: FlexibleOptions) -> Result<ElasticDiscs, DynamicsError> {
        let bodies = bodies(&discs, options, |_, reduced, count| {
            Ok(Body::held(reduced.held_modes(count), reduced.residual_compliance(count)))
        })?;
        let bores = vec![Vec::new(); discs.count()];
        Ok(ElasticDiscs { bodies, bores, damping_ratio: options.damping_ratio, discs })
    }

    /// Discs of these shapes with free bore centres, for bearings and pins.
    ///
    /// # Errors
    /// As [`FlexibleOptions::validate`], and [`DynamicsError::ElasticDisc`] for discs reduced with one spider
    /// for all bores.
    pub fn free(
        shapes: &[DiscShape],
        discs: FlexibleDiscs,
        options: FlexibleOptions,
    ) -> Result<ElasticDiscs, DynamicsError> {
        let bodies = bodies(&discs, options, |disc, reduced, modes| {
            let count = shapes[disc].bores.len();
            Ok(Body::free(reduced.free_modes(modes)?, count, reduced.residual_compliance(modes)))
        })?;
        let bores = (0..discs.count())
            .map(|disc| {
                let first = (0..disc).find(|other| discs.is_shared(disc, *other)).unwrap_or(disc);
                let (turn, count) = (discs.turn(disc), shapes[disc].bores.len());
                // After rotation to the reduced disc, a bore may coincide with another one.
                let covered: Vec<usize> = (0..count)
                    .map(|k| {
                        let place = turned(shapes[disc].bores[k].centre, unit(turn));
                        let distance = |other: &usize| (shapes[first].bores[*other].centre - place).norm();
                        (0..count).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(k)
                    })
                    .collect();
                let body = &bodies[disc];
                (0..body.modes.count())
                    .flat_map(|mode| covered.iter().map(move |k| body.bores[mode * count + k].turned(-turn)))
                    .collect()
            })
            .collect();
        Ok(ElasticDiscs { bodies, bores, damping_ratio: options.damping_ratio, discs })
    }

    /// The discs of several stages as those of one drive, stage after stage; `None` for rigid discs.
    pub fn joined(stages: &[ElasticDiscs]) -> Option<ElasticDiscs> {
        let damping_ratio = stages.first()?.damping_ratio;
        let discs = FlexibleDiscs::joined(stages.iter().map(|stage| &stage.discs));
        let bodies = stages.iter().flat_map(|stage| stage.bodies.iter().cloned()).collect();
        let bores = stages.iter().flat_map(|stage| stage.bores.iter().cloned()).collect();
        Some(ElasticDiscs { discs, bodies, bores, damping_ratio })
    }

    /// The same discs without modal damping, for quasi-static tests: there damping would be a force with a
    /// phase lag.
    pub fn undamped(self) -> ElasticDiscs {
        ElasticDiscs { damping_ratio: 0.0, ..self }
    }

    /// Sets contact law and search range of the pins for an elastic disc of a material. A flank whose
    /// displacement is read at a depth has a contact law of its own; the search range includes the outward
    /// displacement of the flank under a sum of forces (N).
    pub(super) fn prepare_ring(&self, ring: &mut PinContacts, disc: usize, material: &Material, forces: f64) {
        let lift = self.bodies[disc].largest_lift * forces;
        let law = ring.contact().at_disc_depth(material, self.discs.reading_depth(disc));
        ring.set_elastic(law, REACH + lift);
    }

    /// As [`ElasticDiscs::prepare_ring`] of a machine under its rated torque.
    pub(super) fn prepare_ring_of(&self, ring: &mut PinContacts, disc: usize, machine: &Machine) {
        // Σ F of half the pins, F = F₁ sin on average, with Σ F l = T/discs about a lever of e z_c.
        let kinematics = machine.kinematics();
        let lever = kinematics.eccentricity * kinematics.lobe_count * self.count() as f64;
        let forces = 4.0 * machine.rated.torque.abs() / (std::f64::consts::PI * lever);
        self.prepare_ring(ring, disc, &machine.disc.material, forces);
    }

    /// Discs of the drive.
    pub fn count(&self) -> usize {
        self.discs.count()
    }

    /// Checks the number of discs and the numbers of their bores.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for another number of discs or bores.
    pub(super) fn require(&self, bores: &[usize]) -> Result<(), DynamicsError> {
        let check = DynamicsError::require;
        let (own, count) = (self.count(), bores.len());
        check(own == count, "number of elastic discs", own as f64, "", "must be that of the drive")?;
        bores.iter().enumerate().try_for_each(|(disc, bores)| {
            let own = self.bores[disc].len() / self.mode_count(disc).max(1);
            check(own == *bores, "bores of an elastic disc", own as f64, "", "must be those of the drive")
        })
    }

    /// Modes of a disc that are coordinates.
    pub fn mode_count(&self, disc: usize) -> usize {
        self.bodies[disc].modes.count()
    }

    /// The reductions behind.
    pub fn discs(&self) -> &FlexibleDiscs {
        &self.discs
    }

    /// Whether the rims of the bores of every disc are deformable (ovalisation).
    pub(super) fn have_rims(&self) -> bool {
        self.bodies.iter().all(|body| body.rims)
    }

    /// Displacement of a bore per unit of a mode, in the frame of the disc.
    pub(super) fn bore(&self, disc: usize, mode: usize, bore: usize) -> BoreMotion {
        let count = self.bores[disc].len() / self.mode_count(disc).max(1);
        self.bores[disc][mode * count + bore]
    }

    /// Change of a modal coordinate that counts as one unit of error on discs of a radius (m) and a mass (kg): an arcmin at
    /// the flank, φ being of the order 1/√(disc mass).
    pub(super) fn scale(radius: f64, mass: f64) -> f64 {
        radius * crate::units::ARCMIN * mass.sqrt()
    }

    /// State of every pin, in contact or not, in the order of the pins. `gap` includes the displacement of the
    /// flank by the elastic disc: minus the local approach in contact.
    pub(super) fn pin_contacts(
        &self,
        disc: usize,
        ring: &PinContacts,
        motion: DiscMotion<'_>,
    ) -> Vec<PinContact> {
        let state = self.contacts(disc, ring, motion, 0.0);
        let shifts =
            motion.housing.map_or_else(Vec::new, |pins| pins.housing.pin_displacements(disc, pins.modes));
        let mut all = ring.displaced_contacts(motion.pose, motion.velocity, &shifts);
        for contact in &mut all {
            (contact.force, contact.stiffness) = (0.0, 0.0);
            (contact.elastic, contact.stored, contact.friction) = (0.0, 0.0, 0.0);
        }
        for (i, contact) in state.contacts.iter().enumerate() {
            if let Some(entry) = all.iter_mut().find(|entry| entry.pin == contact.pin) {
                let line = state.coupled[i].line(ring.contact());
                let here = line.damped_force(state.forces.local[i], state.rate[i]);
                (entry.force, entry.elastic, entry.stored) = (here.force, here.elastic, here.stored);
                entry.stiffness = state.forces.local_stiffness[i];
                entry.gap = -state.forces.local[i];
                entry.approach_rate = state.rate[i];
                entry.friction = ring
                    .sliding()
                    .map_or(0.0, |sliding| -here.force * sliding.share(contact.sliding_speed).0);
            }
        }
        all
    }

    /// ω² of the modes of a disc in 1/s²: their stiffness, as their mass is one.
    pub(super) fn mode_stiffness(&self, disc: usize) -> &[f64] {
        &self.bodies[disc].modes.eigenvalues
    }

    /// Compliance in m/N: displacement of one place of a flank under a unit force at another, in addition to
    /// that of the modes.
    pub(super) fn flank_compliance(&self, of: &FlankPlace, force: &FlankPlace) -> f64 {
        if of.disc != force.disc {
            return 0.0;
        }
        let residual = &self.bodies[of.disc].residual;
        if of.stencil == force.stencil {
            residual.own(&of.stencil)
        } else {
            residual.cross(&of.stencil, &force.stencil)
        }
    }

    /// Twice the elastic energy of the modes in J.
    pub(super) fn modal_work(&self, disc: usize, q: &[f64]) -> f64 {
        self.bodies[disc].modes.eigenvalues.iter().zip(q).map(|(square, q)| square * q * q).sum()
    }
}

/// One body per different disc.
fn bodies(
    discs: &FlexibleDiscs,
    options: FlexibleOptions,
    body: impl Fn(usize, &crate::fem::ReducedDisc, usize) -> Result<Body, DynamicsError>,
) -> Result<Vec<Arc<Body>>, DynamicsError> {
    options.validate()?;
    let mut bodies: Vec<Arc<Body>> = Vec::new();
    for disc in 0..discs.count() {
        let same = (0..disc).find(|other| discs.is_shared(disc, *other)).map(|other| bodies[other].clone());
        bodies.push(match same {
            Some(body) => body,
            None => {
                let reduced = discs.reduced(disc);
                let count = reduced.modes_up_to(options.mode_frequency);
                Arc::new(body(disc, reduced, count)?)
            }
        });
    }
    Ok(bodies)
}
