//! Cycloidal drives of a single stage as mechanisms.

use std::f64::consts::TAU;
use std::ops::{Deref, DerefMut};

use super::DynamicsError;
use super::mechanism::{
    Arm, Axis, Body, Designed, Flanges, HolePins, Joint, Journal, Losses, Mechanism, NominalMotion, Part,
    PinRing, Place, Registry, Resistance, RollingBearing, State, Support, Turn,
};
use crate::contact::{LineContact, Pin, PinContact, PinContacts};
use crate::geometry::{Profile, Relief, Vec2, unit};
use crate::machine::{Friction, RollerBearing};
use crate::units::ARCMIN;

/// Pins of the output in holes of the discs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputPins {
    pub count: usize,
    /// R_w in m.
    pub circle_radius: f64,
    /// r_w in m: of the roller, or of a pin without one.
    pub radius: f64,
    /// δ in m: a hole has the radius r_w + e + δ.
    pub hole_clearance: f64,
}

/// A cycloidal drive of one stage: eccentrics in the middle of the input shaft, discs, a ring of pins at rest, and output
/// pins in holes of the discs. The output turns against the input, i = −z_c.
///
/// Bodies are rigid but for their contacts; the input shaft may shift in its bearings, but not bend. Output pins and
/// their holes have no friction.
#[derive(Debug, Clone, PartialEq)]
pub struct SingleStage {
    /// The flank as cut.
    pub profile: Profile,
    /// Circle and radius of the pins of the ring as installed, m.
    pub ring_circle_radius: f64,
    pub ring_pin_radius: f64,
    /// Angles of the eccentrics on the shaft in rad, a disc each.
    pub phases: Vec<f64>,
    /// Law of contact of a pin with a flank.
    pub contact: LineContact,
    /// What is taken off the flank, m.
    pub relief: Relief,
    /// Bearing between eccentric and disc.
    pub eccentric: RollerBearing,
    pub output_pins: OutputPins,
    /// Of an output pin on each of the discs in N/m: pin, roller and hole in series.
    pub output_pin_stiffness: Vec<f64>,
    /// Radial stiffness of the bearings of input shaft and output, N/m.
    pub input_support: f64,
    pub output_support: f64,
    /// kg and kg·m² of a disc.
    pub disc: (f64, f64),
    /// The same of the input shaft.
    pub input: (f64, f64),
    /// The same of the output.
    pub output: (f64, f64),
}

/// A [`SingleStage`] as bodies and joints. Coordinates are absolute places (m) and angles (rad) of input shaft, discs and
/// output.
#[derive(Debug, Clone)]
pub struct SingleStageJoints {
    mechanism: Mechanism,
    /// Numbers of the eccentric bearings among the joints, a disc each.
    eccentrics: Vec<usize>,
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

/// Two-sided play at the output in rad with the input held, as the sum of what single gaps let the output turn.
///
/// The sum is a lower bound: with all gaps open a disc also shifts along its eccentric, which gave a tenth more in a drive of
/// 19 : 1 with 8 output pins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlayChain {
    /// Of the gap between flank and pins, 2 Δ/(e z_c).
    pub ring: f64,
    /// Of the radial clearance c of the eccentric bearing, 2 c/(e z_c).
    pub eccentric_bearing: f64,
    /// Of the output pins in their holes, 2 δ/R_w where one of them stands across the eccentric; up to 1/cos(π/z_w) times
    /// as much elsewhere.
    pub output: f64,
}

impl PlayChain {
    pub fn total(&self) -> f64 {
        self.ring + self.eccentric_bearing + self.output
    }
}

/// Places of a flank at which the play is looked for.
const STOPS: usize = 2000;

impl SingleStage {
    /// Turns of the input for one of the output: −z_c.
    pub fn ratio(&self) -> f64 {
        -(self.profile.lobe_count() as f64)
    }

    /// e z_c in m: torque of a disc per force across its eccentric.
    fn lever(&self) -> f64 {
        self.profile.eccentricity * self.profile.lobe_count() as f64
    }

    /// Gap (m) of the flank at a meshing angle in the nominal place: what the cut is larger by, and what is taken off.
    pub fn gap(&self, meshing_angle: f64) -> f64 {
        let (equidistant, radial) = (
            self.profile.pin_radius - self.ring_pin_radius,
            self.profile.pin_circle_radius - self.ring_circle_radius,
        );
        let normal = self.profile.pin_angle(meshing_angle);
        equidistant - radial * normal.cos() + self.relief.at(meshing_angle).depth
    }

    /// Play of the drive as designed. In the ring the pin stops the disc at which the gap Δ is least for its lever l, to
    /// either side: min Δ/l + min Δ/l, which is 2 Δ/(e z_c) where the gap is the same everywhere.
    pub fn play_chain(&self) -> PlayChain {
        let turn = |side: f64| {
            let free = |i: usize| {
                let phi = side * std::f64::consts::PI * (i as f64 + 0.5) / STOPS as f64;
                self.gap(phi).max(0.0) / self.profile.lever_arm(phi).abs()
            };
            (0..STOPS).map(free).fold(f64::INFINITY, f64::min)
        };
        PlayChain {
            ring: turn(1.0) + turn(-1.0),
            eccentric_bearing: self.eccentric.clearance.max(0.0) / self.lever(),
            output: 2.0 * self.output_pins.hole_clearance.max(0.0) / self.output_pins.circle_radius,
        }
    }

    /// Largest force (N) of a pin of the ring where all of one disc's side carry as equal springs, 4 T/(K₁ z_c R) with the
    /// disc's share T of the torque.
    pub fn ring_force(&self, torque: f64) -> f64 {
        let share = torque.abs() / self.phases.len() as f64;
        4.0 * share
            / (self.profile.short_width_coefficient()
                * self.profile.lobe_count() as f64
                * self.profile.pin_circle_radius)
    }

    /// Largest force (N) of an output pin on a disc where half of them carry as equal springs, 4 T/(z_w R_w).
    pub fn output_pin_force(&self, torque: f64) -> f64 {
        let share = torque.abs() / self.phases.len() as f64;
        4.0 * share / (self.output_pins.count as f64 * self.output_pins.circle_radius)
    }

    /// Force (N) of an eccentric bearing where all pins carry as equal springs: T/(e z_c) across the eccentric, and along
    /// it 4 T/(π R_w) of the output pins less what the ring presses. The lines of action of its pins meet in the pitch point,
    /// e z_p from the centre of the ring.
    pub fn eccentric_force(&self, torque: f64) -> f64 {
        let share = torque.abs() / self.phases.len() as f64;
        let pitch_point = Vec2::new(self.profile.eccentricity * self.profile.pin_count as f64, 0.0);
        let (mut squares, mut along) = (0.0, 0.0);
        for i in 0..STOPS {
            let pin = self.ring_circle_radius * unit(0.5 * TAU * (i as f64 + 0.5) / STOPS as f64);
            let normal = (pin - pitch_point).normalize();
            squares += normal.y * normal.y;
            along -= normal.y * normal.x;
        }
        let across = share / self.lever();
        let by_ring = across * along / squares;
        let by_pins = 2.0 * share / (0.25 * TAU * self.output_pins.circle_radius);
        across.hypot(by_pins - by_ring)
    }

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
            joints.push(Box::new(Journal {
                place: Place::TurningArm,
                law: RollingBearing::radial(&self.eccentric, 1.0),
                index: [input[0], input[1], input[2], disc[0], disc[1], disc[2]],
                arm: Arm { radius: e, phase: self.phases[j] },
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
        Ok(SingleStageJoints { mechanism, eccentrics, output_pins })
    }

    /// Angle of a disc against the output: its flank meets the pins for the phase of its eccentric.
    fn mounting(&self, disc: usize) -> f64 {
        self.phases[disc] / self.ratio()
    }

    fn output_joint(&self, disc: usize, output: [usize; 3], [x, y, turn]: [usize; 3]) -> HolePins {
        let OutputPins { count, circle_radius, hole_clearance, .. } = self.output_pins;
        let nominal_distance = self.profile.eccentricity;
        let pairs = (0..count).map(|pin| {
            let at = |phase: f64| Arm { radius: circle_radius, phase };
            let place = TAU * pin as f64 / count as f64;
            [at(place), at(place - self.mounting(disc))]
        });
        HolePins {
            part: Part::Carrier,
            cause: None,
            index: [output[0], output[1], output[2], x, y, turn],
            pairs: pairs.collect(),
            clearance: nominal_distance + hole_clearance,
            nominal_distance,
            stiffness: self.output_pin_stiffness[disc],
        }
    }

    fn ring(&self, disc: usize, [x, y, turn]: [usize; 3], housing: [usize; 3]) -> PinRing {
        let pin_count = self.profile.pin_count;
        let pins = (0..pin_count).map(|pin| Pin {
            centre: self.ring_circle_radius * unit(TAU * pin as f64 / pin_count as f64),
            radius: self.ring_pin_radius,
        });
        let mut contacts =
            PinContacts::new(self.profile.clone(), pins.collect(), self.relief.clone(), self.contact);
        contacts.set_conservative(true);
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

    /// Force (N) of the eccentric on one disc, its size.
    pub fn eccentric_force(&self, disc: usize, position: &[f64]) -> f64 {
        let (q, _) = self.full(0.0, position, &vec![0.0; position.len()]);
        let state = self.joints[self.eccentrics[disc]].bearing().map(|bearing| bearing.load(&q).0);
        state.map_or(0.0, |state| state.gradient[0].hypot(state.gradient[1]))
    }
}

#[cfg(test)]
mod tests;
