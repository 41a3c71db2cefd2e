//! Cycloidal drives of a single stage as mechanisms.

mod meshing;

pub use meshing::StageMeshing;

use std::f64::consts::TAU;

use super::eccentrics::{
    Assembly, DiscAt, EccentricJoints, OUTPUT_PINS, StageParts, Three, housing, plane_body,
    require_stiffness, three,
};
use super::mechanism::{
    Arm, Axis, BodyId, Flanges, HolePins, LOSS_TIME, Modes, NominalMotion, Registry, Turn,
};
use super::{DynamicsError, ElasticDiscs};
use crate::geometry::{quarter_turn, unit};
use crate::machine::{Around, OutputPins, SingleStage};
use crate::units::ARCMIN;

impl SingleStage {
    /// Builds bodies and joints, the input held and without load.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for values without meaning.
    pub fn joints(&self) -> Result<EccentricJoints, DynamicsError> {
        self.joints_with(None)
    }

    /// The same with elastic discs of the shapes [`DiscShape::all_of_stage`](crate::fem::DiscShape::all_of_stage), reduced with
    /// [`BoreInterface::Means`](crate::fem::BoreInterface::Means): the mean displacement of the rims of bore and holes. The law
    /// of a pin in its hole contains the rest of the displacement of the wall as in a wide plate
    /// ([`OutputPins::hole_depth`]); the bore of the eccentric bearing stays round.
    ///
    /// # Errors
    /// As there.
    pub fn joints_with(&self, elastic: Option<&ElasticDiscs>) -> Result<EccentricJoints, DynamicsError> {
        self.validate()?;
        elastic.map_or(Ok(()), |discs| discs.require(&self.loaded_bores()))?;
        let ratio = self.ratio();
        let mut bodies = Registry::default();
        let discs = self.add_discs(&mut bodies, [1.0, 1.0 / ratio], ARCMIN, (elastic, 0));
        let place = self.place_scale();
        let output = NominalMotion::turning(1.0 / ratio);
        let output = bodies.add(plane_body(self.output, [place, ARCMIN], true, output));
        let input = NominalMotion::turning(1.0);
        let input = bodies.add(plane_body(self.input, [place, ratio.abs() * ARCMIN], false, input));
        let rest = bodies.add(housing(0.0));
        let coordinates = bodies.number();
        let at = |body| three(&coordinates, body);
        let (output, input, rest) = (at(output), at(input), at(rest));
        let discs: Vec<DiscAt> = discs.into_iter().map(|disc| DiscAt::of(&coordinates, disc)).collect();
        let mut assembly = Assembly::new(elastic);
        assembly.support(input, rest, self.input_support);
        assembly.support(output, rest, self.output_support);
        self.connect(&mut assembly, &discs, [input, output, rest], 1.0, false);
        let flanges = Flanges { input: input[2], output: output[2], phase: discs[0].place[2], ratio };
        assembly.finish(coordinates, flanges)
    }

    /// The same with the output pins at rest: the ring is the output and rotates with the input, i = z_p/m, and
    /// the discs translate without rotation. Relative to the ring all bodies move as in
    /// [`SingleStage::joints`]. Joint forces depend on relative motions only, so that the bearings of input and
    /// output pins are those in the ring.
    ///
    /// # Errors
    /// As there.
    pub fn driven_housing(&self, elastic: Option<&ElasticDiscs>) -> Result<EccentricJoints, DynamicsError> {
        self.validate()?;
        elastic.map_or(Ok(()), |discs| discs.require(&self.loaded_bores()))?;
        let ratio = self.profile.pins_per_turn();
        let mut bodies = Registry::default();
        let discs = self.add_discs(&mut bodies, [1.0, 0.0], ARCMIN, (elastic, 0));
        let place = self.place_scale();
        let ring = NominalMotion::turning(1.0 / ratio);
        let ring = bodies.add(plane_body(self.ring_body, [place, ARCMIN], true, ring));
        let input = NominalMotion::turning(1.0);
        let input = bodies.add(plane_body(self.input, [place, ratio * ARCMIN], false, input));
        let pins = bodies.add(housing(0.0));
        let coordinates = bodies.number();
        let at = |body| three(&coordinates, body);
        let (ring, input, pins) = (at(ring), at(input), at(pins));
        let discs: Vec<DiscAt> = discs.into_iter().map(|disc| DiscAt::of(&coordinates, disc)).collect();
        let mut assembly = Assembly::new(elastic);
        assembly.support(input, ring, self.input_support);
        assembly.support(ring, pins, self.output_support);
        // Relative to the ring the eccentrics rotate z_c/z_p times as fast as relative to the output pins.
        self.connect(&mut assembly, &discs, [input, pins, ring], 1.0 - 1.0 / ratio, true);
        let flanges = Flanges { input: input[2], output: ring[2], phase: discs[0].place[2], ratio };
        assembly.finish(coordinates, flanges)
    }

    /// Bores of every disc that are loaded by joints: that of the eccentric bearing and one per output pin.
    pub(super) fn loaded_bores(&self) -> Vec<usize> {
        vec![1 + self.output_pins.count; self.phases.len()]
    }

    /// One unit of error of a place, in m.
    pub(super) fn place_scale(&self) -> f64 {
        self.output_pins.circle_radius * ARCMIN
    }

    /// Registers the discs. The turns are rotations of eccentrics and discs per rotation of the input; `scale`
    /// (rad) is that of the discs' rotation. Elastic discs have modes; the number is that of the first disc
    /// among them.
    pub(super) fn add_discs(
        &self,
        bodies: &mut Registry,
        [eccentric, disc]: [f64; 2],
        scale: f64,
        (elastic, first): (Option<&ElasticDiscs>, usize),
    ) -> Vec<BodyId> {
        let add = |j: usize| {
            let modes = elastic.map_or(0, |discs| discs.mode_count(first + j));
            let mode_scale = ElasticDiscs::scale(self.ring_circle_radius, self.disc.0);
            let arm = Arm { radius: self.profile.eccentricity, phase: self.phases[j] };
            let turn = Turn { per_input: disc, offset: self.mounting(j) };
            let nominal = NominalMotion { place: Some((arm, Turn::of(eccentric))), turn: Some(turn) };
            let mut body = plane_body(self.disc, [self.place_scale(), scale], true, nominal);
            body.axes.extend(vec![Axis { mass: 1.0, scale: mode_scale, free: true }; modes]);
            bodies.add(body)
        };
        (0..self.phases.len()).map(add).collect()
    }

    /// Connects the discs with shaft, output pins and ring, which is fixed or moves; the eccentric turns are
    /// relative to the ring, per turn of the input.
    pub(super) fn connect(
        &self,
        to: &mut Assembly,
        discs: &[DiscAt],
        [shaft, output, ring_body]: [Three; 3],
        per_input: f64,
        moves: bool,
    ) {
        let begin = [to.rings.len(), to.eccentrics.len(), to.output_pins.len()];
        for (j, disc) in discs.iter().enumerate() {
            let arm = Arm { radius: self.profile.eccentricity, phase: self.phases[j] };
            let number = to.rings.len();
            let modes = to.bore_modes(disc, number, 0);
            to.eccentric(shaft, disc.place, modes, arm, (&self.eccentric, &self.errors, j));
            to.holes(self.output_joint(to, j, number, output, disc));
            let pins = self.pins_as_made(&self.errors, 0, 0.0);
            let error = self.errors.flanks.get(j);
            let mut ring = self.ring(pins, error, number, disc.place, ring_body, moves);
            if let Some(discs) = &to.elastic {
                discs.prepare_ring(&mut ring.contacts, number, &self.disc_material, 0.0);
                ring.elastic = Some(Modes { body: discs.clone(), at: disc.modes.clone() });
            }
            to.rings.push(ring);
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

    /// The output pins on disc `disc`, with its number among all elastic discs.
    fn output_joint(
        &self,
        of: &Assembly,
        disc: usize,
        number: usize,
        output: Three,
        DiscAt { place: [x, y, turn], modes }: &DiscAt,
    ) -> HolePins {
        let OutputPins { count, circle_radius, hole_clearance, .. } = self.output_pins;
        let nominal_distance = self.profile.eccentricity;
        // An axis displaced by these amounts along and across its direction.
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
        let mut compliance = 1.0 / self.output_pin_stiffness[disc];
        let mut displacements = Vec::new();
        if let Some(discs) = &of.elastic {
            let depth = self.output_pins.hole_depth(nominal_distance, self.disc_material.poisson_ratio);
            compliance += self.output_contact.compliance_to_depth(&self.disc_material, depth);
            displacements.extend(
                (0..count).flat_map(|pin| {
                    (0..modes.len()).map(move |mode| discs.bore(number, mode, 1 + pin).centre)
                }),
            );
        }
        HolePins {
            part: OUTPUT_PINS,
            cause: None,
            index: [output[0], output[1], output[2], *x, *y, *turn],
            modes: modes.clone(),
            displacements,
            pairs: pairs.collect(),
            clearances: clearances.collect(),
            nominal_distance,
            stiffness: 1.0 / compliance,
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
pub(super) mod elastic_tests;
#[cfg(test)]
pub(super) mod tests;
