//! What makes up an output error in a state of balance: virtual work with the forces of that very balance.

use super::BearingJoints;
use super::assembly::{Element, Part, Sink};
use crate::contact::{DiscPose, DiscVelocity, PinContact, PinContacts};
use crate::geometry::{Relief, unit};
use crate::wear::PartLoads;

/// Where lost motion comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Cause {
    FlankWear,
    PinWear,
    FlankModification,
    /// Contacts come nearer to the root on their way through all clearances, where normals turn: of second
    /// order in the way, of either sign.
    FlankCurvature,
    TurningArmClearance,
    TurningArmWear,
    CrankSupportClearance,
    CrankSupportWear,
    GearBacklash,
    GearWear,
    MainBearingClearance,
    Elastic,
    /// Gaps opened (or, negative, closed) by manufacturing errors.
    ManufacturingErrors,
}

impl Cause {
    pub const ALL: [Cause; 13] = [
        Cause::FlankWear,
        Cause::PinWear,
        Cause::FlankModification,
        Cause::FlankCurvature,
        Cause::TurningArmClearance,
        Cause::TurningArmWear,
        Cause::CrankSupportClearance,
        Cause::CrankSupportWear,
        Cause::GearBacklash,
        Cause::GearWear,
        Cause::MainBearingClearance,
        Cause::Elastic,
        Cause::ManufacturingErrors,
    ];

    /// Words for tables.
    pub fn name(self) -> &'static str {
        match self {
            Cause::FlankWear => "wear of the disc flanks",
            Cause::PinWear => "wear of the pins",
            Cause::FlankModification => "modification of the flanks",
            Cause::FlankCurvature => "curvature of the flanks on the way",
            Cause::TurningArmClearance => "clearance of the turning-arm bearings, new",
            Cause::TurningArmWear => "wear of the turning-arm bearings",
            Cause::CrankSupportClearance => "clearance of the crank supports, new",
            Cause::CrankSupportWear => "wear of the crank supports",
            Cause::GearBacklash => "backlash of the gears, new",
            Cause::GearWear => "wear of the gears",
            Cause::MainBearingClearance => "clearance of the main bearings",
            Cause::Elastic => "elastic, at ±3 % of rated torque",
            Cause::ManufacturingErrors => "manufacturing errors",
        }
    }

    /// Word for columns and keys.
    pub fn key(self) -> &'static str {
        match self {
            Cause::FlankWear => "flank_wear",
            Cause::PinWear => "pin_wear",
            Cause::FlankModification => "flank_modification",
            Cause::FlankCurvature => "flank_curvature",
            Cause::TurningArmClearance => "turning_arm_clearance",
            Cause::TurningArmWear => "turning_arm_wear",
            Cause::CrankSupportClearance => "crank_support_clearance",
            Cause::CrankSupportWear => "crank_support_wear",
            Cause::GearBacklash => "gear_backlash",
            Cause::GearWear => "gear_wear",
            Cause::MainBearingClearance => "main_bearing_clearance",
            Cause::Elastic => "elastic",
            Cause::ManufacturingErrors => "manufacturing_errors",
        }
    }
}

/// The unworn contacts of a disc in the same pose, and its way (x, y, θ) from the nominal place.
struct Lost<'a> {
    ring: &'a PinContacts,
    unworn: Vec<PinContact>,
    moved: [f64; 3],
}

impl Lost<'_> {
    /// Change of a gap on the way back to the nominal place.
    fn back(&self, gradient: [f64; 3]) -> f64 {
        -gradient.iter().zip(&self.moved).map(|(g, d)| g * d).sum::<f64>()
    }

    /// Gap in m of the unworn surfaces back along its tangent.
    fn unworn_gap(&self, contact: &PinContact) -> f64 {
        let unworn = &self.unworn[contact.pin];
        unworn.gap + self.back(unworn.gradient)
    }

    /// Metal lost by the flank and by the pin in m, back along the tangents.
    fn of(&self, contact: &PinContact) -> [f64; 2] {
        let round = contact.round_gradient();
        let pin = self.ring.pin_depth(contact);
        let worn_pin = pin + self.back(std::array::from_fn(|i| contact.gradient[i] - round[i]));
        [contact.gap - pin + self.back(round) - self.unworn_gap(contact), worn_pin]
    }
}

/// Sums stored energies per part.
struct Stored([f64; Part::ALL.len()]);

impl Sink for Stored {
    fn element(&mut self, element: &Element<'_>) {
        self.0[element.part as usize] += element.stored;
    }

    fn damper(&mut self, _: &[usize], _: &[f64], _: &[f64], _: f64) {}
}

impl BearingJoints {
    /// Work (N·m·rad) of the forces of a balance on the gap or the elastic approach of every joint, sorted by
    /// cause.
    ///
    /// The forces F_e of all joints balance the torque T at the output, so for small displacements T φ = Σ
    /// F_e u_e, and each u_e is the gap that was there plus the elastic approach: causes add up to the whole
    /// but for terms of second order in the displacements of bearings. Wear is counted at the nominal place,
    /// back along the tangents of the gaps: near the root a contact goes a long way along a worn flank or pin
    /// until it carries, to other depths than where it was. What the unworn gaps miss of their nominal value
    /// that way, half their second derivative, is a cause of its own. Exact for springs: Q δ = (n + 1) U of a
    /// roller, 2 U of linear springs. Manufacturing errors do the work of F_e on what they displace in the
    /// nominal place; where they press parts together without load, elastic work and theirs are large and
    /// nearly cancel.
    pub fn causes(&self, position: &[f64]) -> [f64; Cause::ALL.len()] {
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        let mut causes = [0.0; Cause::ALL.len()];
        let mut add = |cause: Cause, work: f64| causes[cause as usize] += work;
        let nominal = self.has_errors.then(|| {
            let nominal = self.nominal_position_at(self.held_sun());
            self.full(0.0, &nominal, &vec![0.0; nominal.len()]).0
        });
        for k in 0..self.layout.cranks {
            let arms = (0..self.layout.discs).map(|j| {
                let made = nominal.as_ref().map(|nominal| self.turning_arm_state(k, j, nominal).0);
                (&self.turning_arms[k][j], self.turning_arm_state(k, j, &q), self.part_wear.turning_arm, made)
            });
            let supports = (0..2).map(|end| {
                let made = nominal.as_ref().map(|nominal| self.support_state(k, end, nominal).0);
                (&self.supports[k], self.support_state(k, end, &q), self.part_wear.crank_support, made)
            });
            let own = [
                (Cause::TurningArmClearance, Cause::TurningArmWear),
                (Cause::CrankSupportClearance, Cause::CrankSupportWear),
            ];
            let all = arms.map(|bearing| (own[0], bearing)).chain(supports.map(|bearing| (own[1], bearing)));
            for ((clearance, wear), (law, (u, cage), worn, made)) in all {
                let state = law.react(u, cage);
                let elastic = (law.exponent + 1.0) * state.stored;
                let gap = state.gradient[0] * u[0] + state.gradient[1] * u[1] - elastic;
                let share =
                    |part: f64| if law.half_clearance == 0.0 { 0.0 } else { part / law.half_clearance };
                add(Cause::Elastic, elastic);
                add(clearance, gap * share(law.drawn_half_clearance));
                add(wear, gap * share(0.5 * worn));
                // Bores made too wide or too narrow.
                add(
                    Cause::ManufacturingErrors,
                    gap * share(law.half_clearance - law.drawn_half_clearance - 0.5 * worn),
                );
                if let Some(made) = made {
                    add(
                        Cause::ManufacturingErrors,
                        -(state.gradient[0] * made[0] + state.gradient[1] * made[1]),
                    );
                }
            }
            let mesh = self.mesh_state(k, &q, &v);
            for side in 0..2 {
                let force = mesh.side_force[side];
                add(Cause::GearBacklash, force * self.meshes[k].half_backlash);
                add(Cause::GearWear, force * self.meshes[k].flank_loss[side]);
                if let Some(nominal) = &nominal {
                    add(Cause::ManufacturingErrors, -force * self.mesh_overlap(k, nominal)[side]);
                }
            }
        }
        let mut stored = Stored([0.0; Part::ALL.len()]);
        self.visit(&q, &v, &mut stored);
        for part in [Part::CrankBending, Part::GearStage, Part::InputShaft, Part::Carrier, Part::Housing] {
            add(Cause::Elastic, 2.0 * stored.0[part as usize]);
        }
        add(Cause::Elastic, self.modal_work(&q));
        let (stiffness, clearance) = self.main;
        let shift = self.main_displacement(&q);
        let force = stiffness * (shift.norm() - clearance).max(0.0);
        add(Cause::MainBearingClearance, force * clearance);
        if let Some(nominal) = nominal.as_ref().filter(|_| force > 0.0) {
            add(Cause::ManufacturingErrors, -force * shift.normalize().dot(&self.main_displacement(nominal)));
        }
        for (j, ring) in self.rings.iter().enumerate() {
            let lost = self.lost(j, self.disc_state(j, &q, &v).0);
            let profile = ring.profile();
            let k1 = profile.short_width_coefficient();
            let (circle, radius) = (
                profile.pin_circle_radius - self.radial_offset,
                profile.pin_radius - self.equidistant_offset,
            );
            self.visit_loaded(j, &q, &v, |contact, force, approach| {
                add(Cause::Elastic, force * approach);
                let [flank, pin] = lost.of(contact);
                add(Cause::FlankWear, force * flank);
                add(Cause::PinWear, force * pin);
                let cos = contact.meshing_angle.cos();
                let offsets = self.equidistant_offset
                    - self.radial_offset * (1.0 - k1 * cos) / profile.speed_factor(cos);
                let modification = self.designed_relief.at(contact.meshing_angle).depth + offsets;
                add(Cause::FlankModification, force * modification);
                let mut made = 0.0;
                if nominal.is_some() {
                    let pin = &ring.pins()[contact.pin];
                    let moved = pin.centre
                        - circle
                            * unit(std::f64::consts::TAU * contact.pin as f64 / ring.pins().len() as f64);
                    made = contact.normal.dot(&moved) + radius - pin.radius + ring.flank_error_depth(contact);
                    add(Cause::ManufacturingErrors, force * made);
                }
                add(Cause::FlankCurvature, force * (lost.unworn_gap(contact) - modification - made));
            });
        }
        causes
    }

    /// What flank and pins have lost against a disc, followed back to its nominal place along the tangents of
    /// the gaps.
    fn lost(&self, disc: usize, pose: DiscPose) -> Lost<'_> {
        let nominal = self.nominal_position_at(self.held_sun());
        let (q, v) = self.full(0.0, &nominal, &vec![0.0; nominal.len()]);
        let from = self.disc_state(disc, &q, &v).0;
        let ring = &self.rings[disc];
        let mut unworn = ring.clone();
        unworn.set_relief(self.designed_relief.clone());
        unworn.set_pin_relief(Relief::uniform(0.0));
        let moved = pose.centre - from.centre;
        Lost {
            ring,
            unworn: unworn.contacts(pose, DiscVelocity::REST),
            moved: [moved.x, moved.y, pose.angle - from.angle],
        }
    }

    /// Loads of bearings and gears at a balance, means of all of a kind.
    pub fn part_loads(&self, position: &[f64]) -> PartLoads {
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        let (cranks, discs) = (self.layout.cranks, self.layout.discs);
        let mut loads = PartLoads::default();
        for k in 0..cranks {
            for j in 0..discs {
                let (u, cage) = self.turning_arm_state(k, j, &q);
                loads.turning_arm +=
                    self.turning_arms[k][j].element_forces(u, cage).sum::<f64>() / (cranks * discs) as f64;
            }
            for end in 0..2 {
                let (u, cage) = self.support_state(k, end, &q);
                loads.crank_support +=
                    self.supports[k].element_forces(u, cage).sum::<f64>() / (2 * cranks) as f64;
            }
            let mesh = self.mesh_state(k, &q, &v);
            for side in 0..2 {
                loads.gears[side] += mesh.side_force[side] / cranks as f64;
            }
        }
        loads
    }

    /// Replaces what bearings and gears have lost.
    pub(super) fn set_part_wear(&mut self, wear: crate::machine::PartWear) {
        let (arm, support) = (
            wear.turning_arm - self.part_wear.turning_arm,
            wear.crank_support - self.part_wear.crank_support,
        );
        self.turning_arms.iter_mut().flatten().for_each(|bearing| bearing.widen(arm));
        self.supports.iter_mut().for_each(|bearing| bearing.widen(support));
        self.meshes.iter_mut().for_each(|mesh| mesh.flank_loss = wear.gears);
        self.part_wear = wear;
    }
}
