//! Wear of output pins, holes and eccentric bearings of drives of eccentrics, in addition to that of flanks and ring pins.

use std::f64::consts::TAU;

use super::OtherParts;
use crate::dynamics::StageMeshing;
use crate::geometry::Relief;
use crate::load::ShareLoad;
use crate::machine::{DutyPoint, OutputPins, PartWear, RollerBearing, RollingWear};
use crate::wear::parts::clearance_rate;
use crate::wear::{Exposure, WearCase, WearError, WearSnapshot};

/// Wearing parts other than flanks and ring pins: the eccentric bearings, and the output pins in their holes, if there
/// are any.
#[derive(Debug, Clone)]
pub struct StageParts {
    /// Bearing between eccentric and disc.
    pub eccentric: RollerBearing,
    /// e in m.
    pub eccentricity: f64,
    /// Output pins in holes of the discs; `None` for a stage without them.
    pub output_pins: Option<OutputPins>,
    /// Rollers on the output pins.
    pub has_rollers: bool,
    /// Turns of an eccentric relative to its disc for one turn of the input.
    pub turns: f64,
    /// Angle (rad) of the input relative to the ring for one turn of an eccentric in its disc: the period of ring and
    /// output pins.
    pub period: f64,
}

/// Wear of output pins, their holes and the eccentric bearings.
///
/// A hole moves around its pin on a circle of radius e with the speed of the eccentric relative to its disc, and the
/// contact revolves around both. Every direction α of hole and pin therefore slides by e dα once per turn, and its
/// depth grows by k F e/(B r) per turn with the force F in this direction. The direction of the force is fixed to the
/// disc and to the pins: under a constant torque a pin is loaded in one half of all directions, so depths are half
/// sines with a maximum of π times the mean.
///
/// A roller rolls in its hole and slides on its pin by r_pin/r_w of the distance. Its bore rotates relative to the
/// load and wears evenly.
///
/// Discs have the coefficient of the flanks, pins and rollers `pin_ratio` times it. The law is Archard's; other laws
/// and the film apply to flanks and ring pins only.
#[derive(Debug)]
pub struct StageFollower {
    meshing: StageMeshing,
    case: WearCase,
    exposure: Exposure,
    parts: StageParts,
    time: f64,
    wear: PartWear,
}

/// Mean wear rates in a static equilibrium.
struct Rates {
    /// Rates of output pins and holes in m per s/Pa, of bearings in m/s.
    depths: PartWear,
    /// Largest approach (m) of an output pin to its hole.
    approach: f64,
}

/// Positions over the period of ring and output pins, one turn of an eccentric in its disc.
const POSITIONS: usize = 36;
/// Largest depth of output pin and hole together between two updates, as a share of the approach of the most heavily
/// loaded of them. Above twice the approach the explicit integration would be unstable.
const STEP: f64 = 0.25;

impl StageFollower {
    /// The follower of a new drive.
    pub fn new(
        parts: StageParts,
        case: WearCase,
        meshing: StageMeshing,
        exposure: Exposure,
    ) -> StageFollower {
        let wear = PartWear::default();
        StageFollower { meshing, case, exposure, parts, time: 0.0, wear }
    }

    fn slides(&self) -> bool {
        self.parts.output_pins.is_some() && (!self.parts.has_rollers || self.case.wear.pin_ratio > 0.0)
    }

    fn rates(&mut self) -> Result<Rates, WearError> {
        let mut rates = Rates { depths: PartWear::default(), approach: 0.0 };
        let law = self.case.wear.parts.turning_arm;
        let StageParts { output_pins, eccentricity: e, period, .. } = self.parts;
        let (discs, width) = (self.case.disc_count, self.case.disc_width);
        for &DutyPoint { torque, input_speed, share, .. } in self.case.duty.iter().filter(|row| row.wears()) {
            let relative = input_speed.abs() * self.parts.turns;
            let weight = share / POSITIONS as f64;
            let mut start: Option<Vec<f64>> = None;
            for position in 0..POSITIONS {
                let angle = self.meshing.position(period, position, POSITIONS);
                let (place, _) = self.meshing.rest(angle, torque, start.as_deref())?;
                let joints = self.meshing.joints();
                for (disc, pins) in (0..discs).flat_map(|disc| output_pins.map(|pins| (disc, pins))) {
                    let per_hole = weight / (pins.count * discs) as f64;
                    let loaded = joints.output_pin_loads(disc, &place).into_iter();
                    for pin in loaded.filter(|pin| pin.force > 0.0) {
                        rates.approach = rates.approach.max(-pin.gap);
                        let area = per_hole * pin.force * e * relative / width;
                        let pin_area = self.case.wear.pin_ratio * area;
                        rates.depths.output_pins.deposit(pin.around, pin_area, pins.radius);
                        if self.parts.has_rollers {
                            rates.depths.rollers += pin_area / (TAU * pins.radius);
                        } else {
                            rates.depths.holes.deposit(pin.around, area, pins.hole_radius(e));
                        }
                    }
                }
                if let Some(RollingWear { coefficient, slip }) = law {
                    let forces = joints.eccentric_roller_sum(&place);
                    rates.depths.turning_arm +=
                        weight * coefficient * clearance_rate(&self.parts.eccentric, slip, forces, relative);
                }
                start = Some(self.meshing.deviation(angle, &place));
            }
        }
        Ok(rates)
    }
}

impl OtherParts for StageFollower {
    fn wear_at_all(&self) -> bool {
        self.slides() || self.case.wear.parts.turning_arm.is_some()
    }

    fn set_surfaces(&mut self, surfaces: &WearSnapshot) {
        surfaces.apply_to(&self.case.designed, &mut self.meshing);
    }

    fn advance(&mut self, time: f64) -> Result<(), WearError> {
        let end = self.time + time;
        while self.time < end {
            let Rates { depths, approach } = self.rates()?;
            let (exposed, target) = (self.exposure.at(self.time), self.exposure.at(end));
            let depth = depths.hole_clearance().deepest() * (target - exposed);
            let steps = (depth / (STEP * approach)).ceil();
            let next = if steps > 1.0 {
                self.exposure.time_at(exposed + (target - exposed) / steps).min(end)
            } else {
                end
            };
            let by_time = PartWear { turning_arm: depths.turning_arm, ..PartWear::default() };
            let by_exposure = PartWear { turning_arm: 0.0, ..depths };
            let exposure = self.exposure.at(next) - exposed;
            self.wear = self.wear.plus(&by_time, next - self.time).plus(&by_exposure, exposure);
            self.time = next;
            self.meshing.set_part_wear(&self.wear);
        }
        Ok(())
    }

    fn wear(&self) -> PartWear {
        self.wear
    }

    fn set_other_surfaces(&mut self, ring: usize, designed: &Relief, surfaces: &WearSnapshot) {
        surfaces.apply_to_other_ring(ring, designed, &mut self.meshing);
    }
}

#[cfg(test)]
mod tests;
