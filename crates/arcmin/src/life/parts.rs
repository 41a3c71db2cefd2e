//! What the whole machine with its bearings makes of worn surfaces: lost motion by cause, and the wear of bearings and gears.

use crate::dynamics::{BearingMeshing, JointSettings, LostMotionSplit};
use crate::geometry::Relief;
use crate::load::ShareLoad;
use crate::machine::{Machine, PartWear};
use crate::wear::{WearError, WearSnapshot};

/// The machine with bearings at one time of its life.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartsPoint {
    /// What bearings and gears have lost.
    pub wear: PartWear,
    /// Frictionless lost motion of the whole machine at ±3 % of rated torque, by cause.
    pub lost_motion: LostMotionSplit,
}

/// Follows bearings and gears beside the wear of flanks and pins; `None` in place of it for a machine that is not modelled with bearings (fixed carrier).
///
/// Their clearance grows at the rate found at the beginning of each interval: loads on rollers hardly depend on some micrometres of clearance, so halving the
/// intervals changes little (a test shows it).
#[derive(Debug)]
pub struct PartsFollower<'a> {
    machine: &'a Machine,
    meshing: BearingMeshing,
    designed: Relief,
    wear: PartWear,
    starts: Vec<Vec<f64>>,
}

/// Crank positions over a turn of the crankshafts for lost motion and for rates.
pub(super) const POSITIONS: usize = 12;

impl<'a> PartsFollower<'a> {
    pub fn new(machine: &'a Machine) -> Option<PartsFollower<'a>> {
        let meshing = BearingMeshing::new(machine, &JointSettings::default()).ok()?;
        Some(PartsFollower { machine, meshing, designed: machine.designed_relief(), wear: PartWear::default(), starts: Vec::new() })
    }

    pub fn wear(&self) -> &PartWear {
        &self.wear
    }

    /// Takes over the surfaces of flanks and pins.
    pub fn see(&mut self, surfaces: &WearSnapshot) {
        self.meshing.set_relief(self.designed.plus(surfaces.flank_seen_by_contact()));
        self.meshing.set_pin_relief(surfaces.pin_seen_by_contact().clone());
    }

    /// Lost motion by cause with the surfaces and the part wear reached.
    ///
    /// # Errors
    /// [`WearError::Load`] where no balance is found.
    pub fn point(&mut self) -> Result<PartsPoint, WearError> {
        Ok(PartsPoint { wear: self.wear, lost_motion: self.meshing.lost_motion_causes(POSITIONS, &mut self.starts)? })
    }

    /// Wears bearings and gears for `time` (s) at the loads of the present state.
    ///
    /// # Errors
    /// [`WearError::Load`] where no balance is found.
    pub fn advance(&mut self, time: f64) -> Result<(), WearError> {
        let rates = self.meshing.part_wear_rates(self.machine, POSITIONS)?;
        self.wear = self.wear.plus(&rates, time);
        self.meshing.set_part_wear(&self.wear);
        Ok(())
    }
}
