//! What makes up an output error in a state of balance: virtual work with the forces of that very balance.

use super::BearingJoints;
use super::joints::State;
use crate::contact::{DiscPose, DiscVelocity, PinContact, PinContacts};
use crate::geometry::{Relief, Vec2, unit};
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

/// The unworn contacts of a disc in the same pose, its way (x, y, θ) from the nominal place, and those of its
/// pins, if any.
struct Lost<'a> {
    ring: &'a PinContacts,
    unworn: Vec<PinContact>,
    moved: [f64; 3],
    pins: Vec<Vec2>,
}

impl Lost<'_> {
    /// Change of a gap on the way of disc and pin back to the nominal place.
    fn back(&self, pin: usize, gradient: [f64; 3]) -> f64 {
        let mut moved = self.moved;
        if let Some(way) = self.pins.get(pin) {
            moved[0] -= way.x;
            moved[1] -= way.y;
        }
        -gradient.iter().zip(&moved).map(|(g, d)| g * d).sum::<f64>()
    }

    /// Gap in m of the unworn surfaces back along its tangent.
    fn unworn_gap(&self, contact: &PinContact) -> f64 {
        let unworn = &self.unworn[contact.pin];
        unworn.gap + self.back(contact.pin, unworn.gradient)
    }

    /// Metal lost by the flank and by the pin in m, back along the tangents.
    fn of(&self, contact: &PinContact) -> [f64; 2] {
        let round = contact.round_gradient();
        let pin = self.ring.pin_depth(contact);
        let turned = std::array::from_fn(|i| contact.gradient[i] - round[i]);
        let worn_pin = pin + self.back(contact.pin, turned);
        [contact.gap - pin + self.back(contact.pin, round) - self.unworn_gap(contact), worn_pin]
    }
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
        let at = State { q: &q, v: &v };
        self.joints.iter().for_each(|joint| joint.work(at, nominal.as_deref(), &mut add));
        add(Cause::Elastic, self.modal_work(&q));
        for (j, ring) in self.rings.iter().enumerate() {
            let lost = self.lost(j, self.disc_state(j, &q, &v).0, self.pin_ways(j, &q));
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
    fn lost(&self, disc: usize, pose: DiscPose, pins: Vec<Vec2>) -> Lost<'_> {
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
            unworn: unworn.contacts_moved(pose, DiscVelocity::REST, &pins),
            moved: [moved.x, moved.y, pose.angle - from.angle],
            pins,
        }
    }

    /// Loads of bearings and gears at a balance, means of all of a kind.
    pub fn part_loads(&self, position: &[f64]) -> PartLoads {
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        let mut loads = PartLoads::default();
        self.joints.iter().for_each(|joint| joint.add_loads(State { q: &q, v: &v }, &mut loads));
        loads
    }

    /// Replaces what bearings and gears have lost.
    pub(super) fn set_part_wear(&mut self, wear: crate::machine::PartWear) {
        self.joints.iter_mut().for_each(|joint| joint.set_wear(&wear));
    }
}
