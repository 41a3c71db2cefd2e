//! Drives of eccentrics, discs and rings of pins of all families as mechanisms.

mod held;
mod two_ring;
mod two_stage;

pub use held::HeldDrive;

use std::ops::{Deref, DerefMut, Range};
use std::sync::Arc;

use super::mechanism::{
    Arm, Axis, Body, BodyId, BoreMode, Cause, Coordinates, Designed, Flanges, HolePinLoad, HolePins, Input,
    Joint, JointWear, Journal, LOSS_TIME, Losses, Mechanism, NominalMotion, Part, PinRing, PlayLabel,
    Resistance, RollingBearing, State, Support, Turn, range_of,
};
use super::{Drive, DynamicsError, ElasticDiscs, OutputLoad, Reducer};
use crate::contact::{Damping, Pin, PinContact, PinContacts, Sliding};
use crate::geometry::{FlankError, Relief, quarter_turn, unit};
use crate::machine::{EccentricError, PartWear, RingMesh, RollerBearing, RunOut, StageErrors, StageFriction};

/// Bearings of discs on eccentrics.
const ECCENTRIC: PlayLabel = PlayLabel {
    part: Part::new("eccentric bearings"),
    play: Cause::new("eccentric_clearance", "clearance of the eccentric bearings, new"),
    wear: Cause::new("eccentric_wear", "wear of the eccentric bearings"),
};
/// Output pins in the holes of discs.
pub(super) const OUTPUT_PINS: Part = Part::new("output pins");
/// Bearings of shafts in the housing.
const SHAFTS: Part = Part::new("bearings of the shafts");

/// Friction torque of each part of a stage in N·m, at the input relative to the ring.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StageLosses {
    /// Ring pins that slide on flanks.
    pub ring: f64,
    /// Output pins or their rollers in the holes of the discs.
    pub output: f64,
    /// Eccentric bearings.
    pub eccentric: f64,
}

impl StageLosses {
    /// Sum of all parts, N·m.
    pub fn total(&self) -> f64 {
        self.ring + self.output + self.eccentric
    }

    /// Adds a part of others.
    pub fn add(&mut self, part: f64, other: &StageLosses) {
        self.ring += part * other.ring;
        self.output += part * other.output;
        self.eccentric += part * other.eccentric;
    }
}

/// Numbers in the drive of rings, eccentric bearings and output pins of one stage: one per disc, or none.
#[derive(Debug, Clone)]
pub struct StageParts {
    /// Rings of pins.
    pub rings: Range<usize>,
    /// Eccentric bearings.
    pub eccentrics: Range<usize>,
    /// Output pins; empty for a stage without them.
    pub output_pins: Range<usize>,
    /// Absolute turns per turn of the input: of a disc relative to the ring, of an eccentric relative to its
    /// disc.
    pub(super) disc_turns: f64,
    pub(super) eccentric_turns: f64,
}

/// Bodies and joints of a drive. Coordinates are absolute positions (m) and angles (rad).
#[derive(Debug, Clone)]
pub struct EccentricJoints {
    mechanism: Mechanism,
    /// Numbers of the eccentric bearings among the joints, and their mean radii in m.
    eccentrics: Vec<(usize, f64)>,
    /// Numbers of the output pins among the joints, and these themselves.
    output_pins: Vec<(usize, HolePins)>,
    stages: Vec<StageParts>,
}

impl Deref for EccentricJoints {
    type Target = Mechanism;

    fn deref(&self) -> &Mechanism {
        &self.mechanism
    }
}

impl DerefMut for EccentricJoints {
    fn deref_mut(&mut self) -> &mut Mechanism {
        &mut self.mechanism
    }
}

/// (x, y, θ) of a body among the coordinates.
pub(super) type Three = [usize; 3];

pub(super) fn three(coordinates: &Coordinates, body: BodyId) -> Three {
    std::array::from_fn(|axis| coordinates.of(body)[axis])
}

/// A disc among the coordinates.
#[derive(Debug, Clone)]
pub(super) struct DiscAt {
    pub place: Three,
    /// Its modes; none of a rigid disc.
    pub modes: Range<usize>,
}

impl DiscAt {
    pub fn of(coordinates: &Coordinates, body: BodyId) -> DiscAt {
        DiscAt { place: three(coordinates, body), modes: range_of(&coordinates.of(body)[3..]) }
    }
}

/// A body in the plane: mass (kg) and moment of inertia (kg·m²), scales of its position (m) and rotation (rad),
/// and whether its rotation is free.
pub(super) fn plane_body(
    (mass, inertia): (f64, f64),
    [place, turn]: [f64; 2],
    turns: bool,
    nominal: NominalMotion,
) -> Body {
    let place = Axis { mass, scale: place, free: true };
    let turn = Axis { mass: inertia, scale: turn, free: turns };
    Body { axes: vec![place, place, turn], has_place: true, nominal }
}

/// The housing, at rest, its axes at an angle (rad).
pub(super) fn housing(angle: f64) -> Body {
    let still = Axis { mass: 0.0, scale: 1.0, free: false };
    let turn = Turn { per_input: 0.0, offset: angle };
    Body { axes: vec![still; 3], has_place: true, nominal: NominalMotion { place: None, turn: Some(turn) } }
}

/// Parts of a drive before assembly, which follows when the coordinates are numbered.
#[derive(Debug, Default)]
pub(super) struct Assembly {
    pub joints: Vec<Box<dyn Joint>>,
    pub rings: Vec<PinRing>,
    pub eccentrics: Vec<(usize, f64)>,
    pub output_pins: Vec<(usize, HolePins)>,
    pub stages: Vec<StageParts>,
    /// Elastic discs, counted as the rings.
    pub elastic: Option<Arc<ElasticDiscs>>,
}

impl Assembly {
    /// Parts of a drive with rigid or elastic discs.
    pub fn new(discs: Option<&ElasticDiscs>) -> Assembly {
        Assembly { elastic: discs.cloned().map(Arc::new), ..Assembly::default() }
    }

    /// Motions of a bore of a disc by its modes.
    pub fn bore_modes(&self, disc: &DiscAt, number: usize, bore: usize) -> Vec<BoreMode> {
        let modes = self.elastic.iter().flat_map(|discs| {
            disc.modes.clone().enumerate().map(|(mode, at)| (at, discs.bore(number, mode, bore)))
        });
        modes.map(|(at, motion)| BoreMode::of_body(at, motion)).collect()
    }

    /// Bearings (N/m) of a shaft in the housing.
    pub fn support(&mut self, [x, y, turn]: Three, housing: Three, stiffness: f64) {
        self.joints.push(Box::new(Support {
            part: SHAFTS,
            cause: None,
            index: [x, y, turn, housing[0], housing[1]],
            stiffness,
            clearance: 0.0,
            seat: Arm::default(),
            loss_time: LOSS_TIME,
        }));
    }

    /// The bearing of a disc on its eccentric, with the errors of the disc of that number.
    pub fn eccentric(
        &mut self,
        shaft: Three,
        disc: Three,
        modes: Vec<BoreMode>,
        arm: Arm,
        (bearing, errors, number): (&RollerBearing, &StageErrors, usize),
    ) {
        let EccentricError { eccentricity, phase } = errors.eccentric(number);
        let arm = Arm { radius: arm.radius + eccentricity, phase: arm.phase + phase };
        let sliding = Sliding { coefficient: 0.0, regularisation_speed: 0.0 };
        let mut law = RollingBearing::radial(bearing, 1.0);
        law.widen(errors.eccentric_clearance(number));
        self.eccentrics.push((self.joints.len(), 0.5 * bearing.pitch_diameter));
        self.joints.push(Box::new(Journal {
            label: ECCENTRIC,
            law,
            index: [shaft[0], shaft[1], shaft[2], disc[0], disc[1], disc[2]],
            arm,
            bore: Arm::default(),
            modes,
            has_rim: false,
            slopes: None,
            worn: 0.0,
            losses: Losses { time: LOSS_TIME, sliding },
        }));
    }

    pub fn holes(&mut self, pins: HolePins) {
        self.output_pins.push((self.joints.len(), pins.clone()));
        self.joints.push(Box::new(pins));
    }

    /// The mechanism of all joints added, with two shafts as its flanges.
    pub fn finish(
        self,
        coordinates: Coordinates,
        flanges: Flanges,
    ) -> Result<EccentricJoints, DynamicsError> {
        let Assembly { joints, rings, eccentrics, output_pins, stages, .. } = self;
        let mechanism = Mechanism::with_pins(coordinates, joints, rings, flanges, Resistance::none())?;
        Ok(EccentricJoints { mechanism, eccentrics, output_pins, stages })
    }
}

impl RingMesh {
    /// The pins of the ring with their errors, the first one with this number among the errors; the body with
    /// the ring is rotated by an angle (rad) relative to that with the centre of the pin circle.
    pub(super) fn pins_as_made(&self, errors: &StageErrors, first: usize, turned_by: f64) -> Vec<Pin> {
        let RunOut { amplitude, phase } = errors.pin_circle_offset;
        let nominal = self.pins().into_iter().enumerate();
        let made = nominal.map(|(number, pin)| {
            let (outward, error) = (pin.centre / pin.centre.norm(), errors.pin(first + number));
            Pin {
                centre: pin.centre
                    + error.radial * outward
                    + error.tangential * quarter_turn(outward)
                    + amplitude * unit(phase - turned_by),
                radius: pin.radius + error.radius,
            }
        });
        made.collect()
    }

    /// A disc with its flank error and these pins of a ring, which is fixed or moves.
    pub(super) fn ring(
        &self,
        pins: Vec<Pin>,
        error: Option<&FlankError>,
        disc: usize,
        at: Three,
        ring: Three,
        moves: bool,
    ) -> PinRing {
        let mut contacts = PinContacts::new(self.profile.clone(), pins, self.relief.clone(), self.contact);
        contacts.set_conservative(true);
        if let Some(error) = error {
            contacts.set_flank_error(error.clone());
        }
        PinRing {
            contacts,
            disc,
            place: [at[0], at[1], at[2], ring[0], ring[1], ring[2]],
            moves,
            elastic: None,
            housing: None,
            slopes: None,
            designed: Designed {
                relief: self.relief.clone(),
                equidistant: self.profile.pin_radius - self.ring_pin_radius,
                radial: self.profile.pin_circle_radius - self.ring_circle_radius,
            },
        }
    }

    pub(super) fn validate(&self) -> Result<(), DynamicsError> {
        let k1 = self.profile.short_width_coefficient();
        DynamicsError::require(
            k1 > 0.0 && k1 < 1.0,
            "short-width coefficient e z_p/(m R)",
            k1,
            "",
            "must lie between 0 and 1: at 1 the flank has a cusp",
        )
    }
}

/// Stiffnesses in N/m with their names.
pub(super) fn require_stiffness(
    all: impl IntoIterator<Item = (&'static str, f64)>,
) -> Result<(), DynamicsError> {
    all.into_iter().try_for_each(|(name, value)| {
        DynamicsError::require(value > 0.0 && value.is_finite(), name, value, "N/m", "must be positive")
    })
}

impl EccentricJoints {
    /// Its stages, from the input.
    pub fn stages(&self) -> &[StageParts] {
        &self.stages
    }

    /// The drive in motion, with damping of pins on flanks and a steady torque of drag (N·m) at the output that sets in over
    /// a speed in rad/s.
    pub fn moving(
        self,
        damping: Damping,
        (drag, drag_speed): (f64, f64),
        drive: Drive,
        load: OutputLoad,
    ) -> Mechanism {
        let mut mechanism = self.mechanism;
        mechanism.rings.iter_mut().for_each(|ring| ring.contacts.set_damping(Some(damping)));
        mechanism.set_resistance(Resistance { drag, drag_speed, ..Resistance::none() });
        mechanism.set_input(Input::Driven(drive));
        mechanism.set_output_load(load);
        mechanism
    }

    /// The same with Coulomb friction of ring pins, output pins and eccentric bearings, stage by stage,
    /// regularised over a sliding speed (m/s), without damping.
    fn with_friction(mut self, friction: &[StageFriction], regularisation_speed: f64) -> EccentricJoints {
        self.joints.iter_mut().for_each(|joint| joint.set_loss_time(0.0));
        let sliding = |coefficient| Sliding { coefficient, regularisation_speed };
        let Mechanism { joints, rings, .. } = &mut self.mechanism;
        for (stage, friction) in self.stages.iter().zip(friction) {
            rings[stage.rings.clone()].iter_mut().for_each(|ring| ring.set_friction(sliding(friction.ring)));
            for (number, _) in &self.eccentrics[stage.eccentrics.clone()] {
                joints[*number].set_friction(sliding(friction.bearing));
            }
            // A roller rolls in its hole and slides on its pin, so that the friction has the smaller arm of the
            // pin.
            for (number, _) in &self.output_pins[stage.output_pins.clone()] {
                joints[*number].set_friction(sliding(friction.output * friction.pin_over_roller));
            }
        }
        self
    }

    /// State of every pin of one ring of a disc.
    pub fn pin_contacts(&self, ring: usize, position: &[f64]) -> Vec<PinContact> {
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        self.rings[ring].all(State { q: &q, v: &v })
    }

    /// The output pins on one disc.
    pub fn output_pin_loads(&self, disc: usize, position: &[f64]) -> Vec<HolePinLoad> {
        let (q, _) = self.full(0.0, position, &vec![0.0; position.len()]);
        self.output_pins[disc].1.loads(&q).collect()
    }

    /// Friction torques at a static equilibrium with the input held, stage by stage, for a slow rotation
    /// through it: forces without friction, each multiplied by its coefficient and its sliding distance per
    /// radian. Ring pins slide along the flank; output pins by e times the rotation of the eccentric relative
    /// to its disc, which is 1 + m/z_c times that of the shaft.
    pub fn losses(&self, position: &[f64], friction: &[StageFriction]) -> Vec<StageLosses> {
        let of_stage = |(stage, friction): (&StageParts, &StageFriction)| {
            let mut losses = StageLosses::default();
            for ring in stage.rings.clone() {
                for contact in self.pin_contacts(ring, position) {
                    let distance = self.rings[ring].contacts.sliding_way(&contact) * stage.disc_turns;
                    losses.ring += friction.ring * contact.force * distance;
                }
            }
            for number in stage.output_pins.clone() {
                let distance = stage.eccentric_turns
                    * self.output_pins[number].1.nominal_distance
                    * friction.pin_over_roller;
                for HolePinLoad { force, .. } in self.output_pin_loads(number, position) {
                    losses.output += friction.output * force * distance;
                }
            }
            for number in stage.eccentrics.clone() {
                let (force, radius) = (self.eccentric_force(number, position), self.eccentrics[number].1);
                losses.eccentric += friction.bearing * force * radius * stage.eccentric_turns;
            }
            losses
        };
        self.stages.iter().zip(friction).map(of_stage).collect()
    }

    /// Sets the wear of eccentric bearings, output pins and holes of a stage.
    pub fn set_part_wear(&mut self, stage: usize, wear: &PartWear) {
        let StageParts { eccentrics, output_pins, .. } = self.stages[stage].clone();
        let joints = &mut self.mechanism.joints;
        for (number, _) in &self.eccentrics[eccentrics] {
            joints[*number].set_wear(JointWear::Clearance(wear.turning_arm));
        }
        for (number, pins) in &mut self.output_pins[output_pins] {
            pins.worn = wear.hole_clearance();
            joints[*number].set_wear(JointWear::Holes(pins.worn));
        }
    }

    /// Replaces the metal removed from the flanks (designed relief included) and the ring pins of a stage, m: one relief
    /// for all, or one per disc and, pin by pin, per disc.
    pub fn set_stage_surfaces(&mut self, stage: usize, flanks: &[Relief], pins: &[Relief]) {
        let rings = self.stages[stage].rings.clone();
        self.set_surfaces_of(rings, flanks, pins);
    }

    /// Sets the wear of a stage; the wear of its surfaces is added to the designed relief of the flank.
    pub fn set_stage_wear(&mut self, stage: usize, surfaces: (&[Relief], &[Relief]), parts: &PartWear) {
        self.set_stage_surfaces(stage, surfaces.0, surfaces.1);
        self.set_part_wear(stage, parts);
    }

    /// Sum of the forces (N) on all rollers of an eccentric bearing, mean of the bearings.
    pub fn eccentric_roller_sum(&self, position: &[f64]) -> f64 {
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        let at = State { q: &q, v: &v };
        let sums = self.eccentrics.iter().map(|(number, _)| self.joints[*number].wearing_forces(at)[0]);
        sums.sum::<f64>() / self.eccentrics.len() as f64
    }

    /// Σ F |v| in W of the ring pins of a stage for given coordinate velocities, with the tangential speed v of
    /// the flank relative to the ring.
    pub fn sliding_power(&self, stage: usize, position: &[f64], velocity: &[f64]) -> f64 {
        let (q, v) = self.full(0.0, position, velocity);
        let power = |number: usize| {
            let (_, motion) = self.rings[number].disc_state(State { q: &q, v: &v });
            let sliding =
                |[x, y, turn]: [f64; 3]| x * motion.centre.x + y * motion.centre.y + turn * motion.angle;
            let contacts = self.pin_contacts(number, position).into_iter();
            contacts.map(|contact| contact.force * sliding(contact.along).abs()).sum::<f64>()
        };
        self.stages[stage].rings.clone().map(power).sum()
    }

    /// Σ F |v| in W of the output pins for given coordinate velocities, with the speed v of the pin along the
    /// wall of its hole.
    pub fn output_sliding_power(&self, position: &[f64], velocity: &[f64]) -> f64 {
        let (q, v) = self.full(0.0, position, velocity);
        self.output_pins.iter().map(|(_, pins)| pins.sliding_power(&q, &v)).sum()
    }

    /// Absolute force (N) of one eccentric on its disc.
    pub fn eccentric_force(&self, number: usize, position: &[f64]) -> f64 {
        let (q, _) = self.full(0.0, position, &vec![0.0; position.len()]);
        let state = self.joints[self.eccentrics[number].0].bearing().map(|bearing| bearing.load(&q).0);
        state.map_or(0.0, |state| state.gradient[0].hypot(state.gradient[1]))
    }

    /// Rolling elements of the bearing of one eccentric: direction (rad) in the frame of the ring, and radial force (N) on
    /// the disc.
    pub fn eccentric_roller_forces(&self, number: usize, position: &[f64]) -> Vec<(f64, f64)> {
        let (q, _) = self.full(0.0, position, &vec![0.0; position.len()]);
        let bearing = self.joints[self.eccentrics[number].0].bearing();
        bearing.map_or_else(Vec::new, |bearing| bearing.radial_element_forces(&q))
    }
}

#[cfg(test)]
pub(super) mod tests;
