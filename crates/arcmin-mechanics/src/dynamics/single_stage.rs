//! Cycloidal drives of a single stage as mechanisms.

mod meshing;

pub use meshing::StageMeshing;

use std::f64::consts::TAU;

use super::DynamicsError;
use super::eccentrics::{
    Assembly, EccentricJoints, OUTPUT_PINS, StageParts, Three, housing, plane_body, require_stiffness, three,
};
use super::mechanism::{Arm, BodyId, Flanges, HolePins, LOSS_TIME, NominalMotion, Registry, Turn};
use crate::geometry::{quarter_turn, unit};
use crate::machine::{Around, OutputPins, SingleStage};
use crate::units::ARCMIN;

impl SingleStage {
    /// Builds bodies and joints, the input held and without load.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for values without meaning.
    pub fn joints(&self) -> Result<EccentricJoints, DynamicsError> {
        self.validate()?;
        let ratio = self.ratio();
        let mut bodies = Registry::default();
        let discs = self.add_discs(&mut bodies, [1.0, 1.0 / ratio], ARCMIN);
        let place = self.place_scale();
        let output = NominalMotion::turning(1.0 / ratio);
        let output = bodies.add(plane_body(self.output, [place, ARCMIN], true, output));
        let input = NominalMotion::turning(1.0);
        let input = bodies.add(plane_body(self.input, [place, ratio.abs() * ARCMIN], false, input));
        let rest = bodies.add(housing(0.0));
        let coordinates = bodies.number();
        let at = |body| three(&coordinates, body);
        let (output, input, rest) = (at(output), at(input), at(rest));
        let discs: Vec<Three> = discs.into_iter().map(at).collect();
        let mut assembly = Assembly::default();
        assembly.support(input, rest, self.input_support);
        assembly.support(output, rest, self.output_support);
        self.connect(&mut assembly, &discs, [input, output, rest], 1.0, false);
        let flanges = Flanges { input: input[2], output: output[2], phase: discs[0][2], ratio };
        assembly.finish(coordinates, flanges)
    }

    /// The same with the output pins at rest: the ring is the output and turns with the input, i = z_p/m, and the discs shift without
    /// turning. Seen from the ring all bodies move as in [`SingleStage::joints`]; joints see nothing but motions against each other,
    /// so the bearings of input and output pins are those in the ring.
    ///
    /// # Errors
    /// As there.
    pub fn driven_housing(&self) -> Result<EccentricJoints, DynamicsError> {
        self.validate()?;
        let ratio = self.profile.pins_per_turn();
        let mut bodies = Registry::default();
        let discs = self.add_discs(&mut bodies, [1.0, 0.0], ARCMIN);
        let place = self.place_scale();
        let ring = NominalMotion::turning(1.0 / ratio);
        let ring = bodies.add(plane_body(self.ring_body, [place, ARCMIN], true, ring));
        let input = NominalMotion::turning(1.0);
        let input = bodies.add(plane_body(self.input, [place, ratio * ARCMIN], false, input));
        let pins = bodies.add(housing(0.0));
        let coordinates = bodies.number();
        let at = |body| three(&coordinates, body);
        let (ring, input, pins) = (at(ring), at(input), at(pins));
        let discs: Vec<Three> = discs.into_iter().map(at).collect();
        let mut assembly = Assembly::default();
        assembly.support(input, ring, self.input_support);
        assembly.support(ring, pins, self.output_support);
        // Against the ring the eccentrics turn z_c/z_p times as fast as against the output pins.
        self.connect(&mut assembly, &discs, [input, pins, ring], 1.0 - 1.0 / ratio, true);
        let flanges = Flanges { input: input[2], output: ring[2], phase: discs[0][2], ratio };
        assembly.finish(coordinates, flanges)
    }

    /// One unit of error of a place, in m.
    pub(super) fn place_scale(&self) -> f64 {
        self.output_pins.circle_radius * ARCMIN
    }

    /// Registers the discs; per turn of the input their eccentrics and they themselves turn so much. `scale` (rad) is that of
    /// their turn.
    pub(super) fn add_discs(
        &self,
        bodies: &mut Registry,
        [eccentric, disc]: [f64; 2],
        scale: f64,
    ) -> Vec<BodyId> {
        let add = |j: usize| {
            let arm = Arm { radius: self.profile.eccentricity, phase: self.phases[j] };
            let turn = Turn { per_input: disc, offset: self.mounting(j) };
            let nominal = NominalMotion { place: Some((arm, Turn::of(eccentric))), turn: Some(turn) };
            bodies.add(plane_body(self.disc, [self.place_scale(), scale], true, nominal))
        };
        (0..self.phases.len()).map(add).collect()
    }

    /// Joins the discs with shaft, output pins and ring, which moves or does not; against it the eccentrics turn so much per
    /// turn of the input.
    pub(super) fn connect(
        &self,
        to: &mut Assembly,
        discs: &[Three],
        [shaft, output, ring_body]: [Three; 3],
        per_input: f64,
        moves: bool,
    ) {
        let begin = [to.rings.len(), to.eccentrics.len(), to.output_pins.len()];
        for (j, disc) in discs.iter().enumerate() {
            let arm = Arm { radius: self.profile.eccentricity, phase: self.phases[j] };
            to.eccentric(shaft, *disc, arm, (&self.eccentric, &self.errors, j));
            to.holes(self.output_joint(j, output, *disc));
            let pins = self.pins_as_made(&self.errors, 0, 0.0);
            to.rings.push(self.ring(pins, self.errors.flanks.get(j), j, *disc, ring_body, moves));
        }
        let turns = (per_input / self.ratio()).abs();
        to.stages.push(StageParts {
            rings: begin[0]..to.rings.len(),
            eccentrics: begin[1]..to.eccentrics.len(),
            output_pins: begin[2]..to.output_pins.len(),
            disc_turns: turns,
            eccentric_turns: per_input.abs() + turns,
        });
    }

    fn output_joint(&self, disc: usize, output: [usize; 3], [x, y, turn]: [usize; 3]) -> HolePins {
        let OutputPins { count, circle_radius, hole_clearance, .. } = self.output_pins;
        let nominal_distance = self.profile.eccentricity;
        // An axis that is off by so much along and across its direction.
        let at = |phase: f64, radial: f64, tangential: f64| {
            let along = unit(phase);
            Arm::new((circle_radius + radial) * along + tangential * quarter_turn(along))
        };
        let errors = |pin: usize| (self.errors.output_pin(pin), self.errors.hole(disc, pin));
        let pairs = (0..count).map(|pin| {
            let place = TAU * pin as f64 / count as f64;
            let (own, hole) = errors(pin);
            [
                at(place, own.radial, own.tangential),
                at(place - self.mounting(disc), hole.radial, hole.tangential),
            ]
        });
        let clearances = (0..count).map(|pin| {
            let (own, hole) = errors(pin);
            nominal_distance + hole_clearance + 0.5 * hole.diameter - own.radius
        });
        HolePins {
            part: OUTPUT_PINS,
            cause: None,
            index: [output[0], output[1], output[2], x, y, turn],
            pairs: pairs.collect(),
            clearances: clearances.collect(),
            nominal_distance,
            stiffness: self.output_pin_stiffness[disc],
            loss_time: LOSS_TIME,
            worn: Around::default(),
            radius: self.output_pins.radius,
            sliding: None,
        }
    }

    pub(super) fn validate(&self) -> Result<(), DynamicsError> {
        let check = DynamicsError::require;
        let pins = self.output_pins;
        check(!self.phases.is_empty(), "number of discs", 0.0, "", "must be at least 1")?;
        let (stiffnesses, discs) = (self.output_pin_stiffness.len(), self.phases.len());
        check(
            stiffnesses == discs,
            "number of stiffnesses of output pins",
            stiffnesses as f64,
            "",
            "must be one a disc",
        )?;
        check(pins.count >= 3, "number of output pins", pins.count as f64, "", "must be at least 3")?;
        check(
            pins.circle_radius > 0.0,
            "radius of the output pins' circle",
            pins.circle_radius,
            "m",
            "must be positive",
        )?;
        check(pins.radius > 0.0, "radius of the output pins", pins.radius, "m", "must be positive")?;
        let supports = [
            ("stiffness of the input's bearings", self.input_support),
            ("stiffness of the output's bearings", self.output_support),
        ];
        let pins =
            self.output_pin_stiffness.iter().map(|stiffness| ("stiffness of an output pin", *stiffness));
        require_stiffness(supports.into_iter().chain(pins))?;
        self.mesh.validate()
    }
}

#[cfg(test)]
mod difference_tests;
#[cfg(test)]
pub(super) mod tests;
