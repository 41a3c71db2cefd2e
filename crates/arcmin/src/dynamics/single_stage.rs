//! Cycloidal drives of a single stage as mechanisms.

mod meshing;

pub use meshing::StageMeshing;

use std::f64::consts::TAU;
use std::ops::{Deref, DerefMut};

use super::DynamicsError;
use super::mechanism::{
    Arm, Axis, Body, Designed, Flanges, HolePins, Joint, Journal, Losses, Mechanism, NominalMotion, Part,
    PinRing, Place, Registry, Resistance, RollingBearing, State, Support, Turn,
};
use crate::contact::{Pin, PinContact, PinContacts};
use crate::geometry::{quarter_turn, unit};
use crate::machine::{EccentricError, Friction, OutputPins, RunOut, SingleStage, StageFriction};
use crate::units::ARCMIN;

/// Torque in N·m at the input, seen from the ring, that friction takes in each part.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StageLosses {
    pub ring: f64,
    pub output: f64,
    pub eccentric: f64,
}

impl StageLosses {
    pub fn total(&self) -> f64 {
        self.ring + self.output + self.eccentric
    }
}

/// A [`SingleStage`] as bodies and joints. Coordinates are absolute places (m) and angles (rad) of input shaft, discs and
/// output.
#[derive(Debug, Clone)]
pub struct SingleStageJoints {
    mechanism: Mechanism,
    /// Numbers of the eccentric bearings among the joints, a disc each.
    eccentrics: Vec<usize>,
    /// Mean radius of these bearings in m.
    eccentric_radius: f64,
    output_pins: Vec<HolePins>,
}

impl Deref for SingleStageJoints {
    type Target = Mechanism;

    fn deref(&self) -> &Mechanism {
        &self.mechanism
    }
}

impl DerefMut for SingleStageJoints {
    fn deref_mut(&mut self) -> &mut Mechanism {
        &mut self.mechanism
    }
}

impl SingleStage {
    /// Builds bodies and joints, the input held and without load.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] for values without meaning.
    pub fn joints(&self) -> Result<SingleStageJoints, DynamicsError> {
        self.validate()?;
        let (e, ratio) = (self.profile.eccentricity, self.ratio());
        let mut bodies = Registry::default();
        let place_scale = self.output_pins.circle_radius * ARCMIN;
        let body = |(mass, inertia): (f64, f64), scale: f64, turns: bool, nominal: NominalMotion| {
            let place = Axis { mass, scale: place_scale, free: true };
            let turn = Axis { mass: inertia, scale, free: turns };
            Body { axes: vec![place, place, turn], has_place: true, nominal }
        };
        let discs: Vec<_> = (0..self.phases.len())
            .map(|j| {
                let arm = Arm { radius: e, phase: self.phases[j] };
                let turn = Turn { per_input: 1.0 / ratio, offset: self.mounting(j) };
                let nominal = NominalMotion { place: Some((arm, Turn::of(1.0))), turn: Some(turn) };
                bodies.add(body(self.disc, ARCMIN, true, nominal))
            })
            .collect();
        let output = bodies.add(body(self.output, ARCMIN, true, NominalMotion::turning(1.0 / ratio)));
        let input = bodies.add(body(self.input, ratio.abs() * ARCMIN, false, NominalMotion::turning(1.0)));
        let still = Axis { mass: 0.0, scale: 1.0, free: false };
        let housing =
            bodies.add(Body { axes: vec![still; 3], has_place: true, nominal: NominalMotion::default() });
        let coordinates = bodies.number();
        let three = |body| -> [usize; 3] { std::array::from_fn(|axis| coordinates.of(body)[axis]) };
        let (output, input, housing) = (three(output), three(input), three(housing));
        let discs: Vec<[usize; 3]> = discs.into_iter().map(three).collect();
        let losses = Losses { time: 0.0, friction: Friction::default() };
        let support = |[x, y, turn]: [usize; 3], stiffness: f64| Support {
            part: Part::Housing,
            cause: None,
            index: [x, y, turn, housing[0], housing[1]],
            stiffness,
            clearance: 0.0,
            seat: Arm::default(),
            loss_time: 0.0,
        };
        let mut joints: Vec<Box<dyn Joint>> = vec![
            Box::new(support(input, self.input_support)),
            Box::new(support(output, self.output_support)),
        ];
        let (mut eccentrics, mut output_pins) = (Vec::new(), Vec::new());
        for (j, disc) in discs.iter().enumerate() {
            eccentrics.push(joints.len());
            let mut law = RollingBearing::radial(&self.eccentric, 1.0);
            law.widen(self.errors.eccentric_clearance(j));
            let EccentricError { eccentricity, phase } = self.errors.eccentric(j);
            joints.push(Box::new(Journal {
                place: Place::TurningArm,
                law,
                index: [input[0], input[1], input[2], disc[0], disc[1], disc[2]],
                arm: Arm { radius: e + eccentricity, phase: self.phases[j] + phase },
                bore: Arm::default(),
                modes: Vec::new(),
                has_rim: false,
                slopes: None,
                worn: 0.0,
                alike: discs.len(),
                losses,
            }));
            output_pins.push(self.output_joint(j, output, *disc));
            joints.push(Box::new(output_pins[j].clone()));
        }
        let rings = discs.iter().enumerate().map(|(j, disc)| self.ring(j, *disc, housing)).collect();
        let flanges = Flanges { input: input[2], output: output[2], phase: discs[0][2], ratio };
        let mechanism = Mechanism::with_pins(coordinates, joints, rings, flanges, Resistance::none())?;
        let eccentric_radius = 0.5 * self.eccentric.pitch_diameter;
        Ok(SingleStageJoints { mechanism, eccentrics, eccentric_radius, output_pins })
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
            part: Part::Carrier,
            cause: None,
            index: [output[0], output[1], output[2], x, y, turn],
            pairs: pairs.collect(),
            clearances: clearances.collect(),
            nominal_distance,
            stiffness: self.output_pin_stiffness[disc],
        }
    }

    fn ring(&self, disc: usize, [x, y, turn]: [usize; 3], housing: [usize; 3]) -> PinRing {
        let pin_count = self.profile.pin_count;
        let RunOut { amplitude, phase } = self.errors.pin_circle_offset;
        let pins = (0..pin_count).map(|pin| {
            let (outward, error) = (unit(TAU * pin as f64 / pin_count as f64), self.errors.pin(pin));
            Pin {
                centre: (self.ring_circle_radius + error.radial) * outward
                    + error.tangential * quarter_turn(outward)
                    + amplitude * unit(phase),
                radius: self.ring_pin_radius + error.radius,
            }
        });
        let mut contacts =
            PinContacts::new(self.profile.clone(), pins.collect(), self.relief.clone(), self.contact);
        contacts.set_conservative(true);
        if let Some(error) = self.errors.flanks.get(disc) {
            contacts.set_flank_error(error.clone());
        }
        PinRing {
            contacts,
            disc,
            place: [x, y, turn, housing[0], housing[1], housing[2]],
            moves: false,
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

    fn validate(&self) -> Result<(), DynamicsError> {
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
        for (name, value) in [
            ("stiffness of the input's bearings", self.input_support),
            ("stiffness of the output's bearings", self.output_support),
        ]
        .into_iter()
        .chain(self.output_pin_stiffness.iter().map(|stiffness| ("stiffness of an output pin", *stiffness)))
        {
            check(value > 0.0 && value.is_finite(), name, value, "N/m", "must be positive")?;
        }
        let k1 = self.profile.short_width_coefficient();
        check(
            k1 > 0.0 && k1 < 1.0,
            "short-width coefficient e z_p/R",
            k1,
            "",
            "must lie between 0 and 1: at 1 the flank has a cusp",
        )
    }
}

impl SingleStageJoints {
    /// State of every pin of the ring on one disc.
    pub fn pin_contacts(&self, disc: usize, position: &[f64]) -> Vec<PinContact> {
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        self.rings[disc].all(State { q: &q, v: &v })
    }

    /// Forces (N) of the output pins on one disc, direction (rad) from hole to pin, gap left (m).
    pub fn output_pin_loads(&self, disc: usize, position: &[f64]) -> Vec<(f64, f64, f64)> {
        let (q, _) = self.full(0.0, position, &vec![0.0; position.len()]);
        self.output_pins[disc].loads(&q).collect()
    }

    /// What friction takes in a state of rest with the input held at an angle (rad), as the drive turns through it: forces
    /// without friction, each times its coefficient and its way per turn. Ring pins slide as the flank passes them, output
    /// pins by e (1 + 1/z_c) times the turn of the input, the eccentric bearing turns by 1 + 1/z_c of it.
    pub fn losses(&self, position: &[f64], angle: f64, friction: &StageFriction) -> StageLosses {
        let velocity = self.nominal_velocity_at(angle, 1.0);
        let slower = 1.0 - 1.0 / self.flanges().ratio;
        let mut losses = StageLosses::default();
        for disc in 0..self.eccentrics.len() {
            let place = self.rings[disc].place;
            for contact in self.pin_contacts(disc, position) {
                let sliding: f64 = (0..3).map(|axis| contact.along[axis] * velocity[place[axis]]).sum();
                losses.ring += friction.ring * contact.force * sliding.abs();
            }
            let (pins, way) = (&self.output_pins[disc], slower * friction.pin_over_roller);
            for (force, ..) in self.output_pin_loads(disc, position) {
                losses.output += friction.output * force * pins.nominal_distance * way;
            }
            let force = self.eccentric_force(disc, position);
            losses.eccentric += friction.bearing * force * self.eccentric_radius * slower;
        }
        losses
    }

    /// Force (N) of the eccentric on one disc, its size.
    pub fn eccentric_force(&self, disc: usize, position: &[f64]) -> f64 {
        let (q, _) = self.full(0.0, position, &vec![0.0; position.len()]);
        let state = self.joints[self.eccentrics[disc]].bearing().map(|bearing| bearing.load(&q).0);
        state.map_or(0.0, |state| state.gradient[0].hypot(state.gradient[1]))
    }
}

#[cfg(test)]
mod tests;
