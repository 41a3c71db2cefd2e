//! What makes up an output error in a state of balance: virtual work with the forces of that very balance.

use super::BearingJoints;
use super::joints::{Nominal, State};
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
        let nominal = self.nominal_position_at(self.held_sun());
        let nominal = self.full(0.0, &nominal, &vec![0.0; nominal.len()]).0;
        let nominal = Nominal { q: &nominal, has_errors: self.has_errors };
        self.elements().for_each(|joint| joint.work(State { q: &q, v: &v }, nominal, &mut add));
        causes
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
