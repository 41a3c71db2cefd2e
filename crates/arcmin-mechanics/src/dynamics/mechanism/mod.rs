//! Bodies with coordinates and the joints between them: the model of a drive of any kind for the solvers.
//!
//! A [`Mechanism`] does not depend on the kind of machine. Its bodies have axes with mass and scale and a
//! nominal motion, its joints act on coordinates, and three of these are special ([`Flanges`]): input, output,
//! and the phase angle for error messages. Drives are built from it in the neighbouring modules
//! (`bearing_joints`: the RV reducer; `eccentrics`), which also name the parts and causes of their joints.

mod assembly;
mod elastic;
mod joints;
mod labels;
mod quasi_static;
mod registry;
mod rim;
mod roller;
mod system;
mod tangent;
#[cfg(test)]
mod tests;

pub use assembly::{ContactRequest, Element, Sink};
pub use elastic::BoreMode;
pub(in crate::dynamics) use joints::{
    Bending, Designed, Frame, Gears, LOSS_TIME, MainPair, Modes, OutsideForces, PIN, PinRing, RingContact,
    SLOPES,
};
pub use joints::{
    Distance, HolePinLoad, HolePins, Joint, JointWear, Journal, Limit, Losses, Nominal, State, Support,
    Torsion,
};
pub use labels::{Cause, Part, PlayLabel};
pub(crate) use quasi_static::{Motion, QuasiStatic};
pub(in crate::dynamics) use registry::range_of;
pub use registry::{Axis, Body, BodyId, Coordinates, NominalMotion, Registry, Turn};
pub(in crate::dynamics) use roller::{AXIAL, ROW, RingPose, SLOPE, VARIABLES};
pub use roller::{BearingState, ElementLoad, RollingBearing};

use std::ops::Range;

use super::{Drive, DynamicsError, ElasticCoordinates, OutputLoad};
use crate::geometry::{Relief, Vec2, unit};

/// Motion of the input.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// By a function of time, by a motor, or from outside.
    Driven(Drive),
    /// Held at an angle (rad), with a speed (rad/s) that is used for friction only.
    Held {
        /// rad.
        angle: f64,
        /// rad/s.
        speed: f64,
    },
}

/// A point that moves with a body, in polar coordinates of the body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Arm {
    /// Radius, m.
    pub radius: f64,
    /// Angle, rad.
    pub phase: f64,
}

impl Arm {
    /// The arm to a position (x, y) in m on the body.
    pub fn new(place: Vec2) -> Arm {
        Arm { radius: place.norm(), phase: place.y.atan2(place.x) }
    }

    /// Position (m) for an angle of the body in rad.
    pub fn at(&self, angle: f64) -> Vec2 {
        self.radius * unit(angle + self.phase)
    }
}

/// Special coordinates of a mechanism.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flanges {
    /// Angle of the input.
    pub input: usize,
    /// Angle of the output.
    pub output: usize,
    /// Phase angle for error messages.
    pub phase: usize,
    /// Ratio of the rotations of input and output.
    pub ratio: f64,
}

/// Resistance to motion, independent of the loads of the joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resistance {
    /// Steady torque at the output against its motion, N·m…
    pub drag: f64,
    /// …regularised over this speed, rad/s.
    pub drag_speed: f64,
    /// A coordinate, and the viscous torque per speed on it, N·m·s/rad.
    pub oil: (usize, f64),
}

impl Resistance {
    /// No drag and no oil.
    pub fn none() -> Resistance {
        Resistance { drag: 0.0, drag_speed: 1.0, oil: (0, 0.0) }
    }
}

/// Bodies and joints with their drive and load: M q̈ = Q(q, q̇, t).
#[derive(Debug, Clone)]
pub struct Mechanism {
    coordinates: Coordinates,
    /// All joints except pins on flanks.
    pub(in crate::dynamics) joints: Vec<Box<dyn Joint>>,
    /// The pins, disc by disc.
    pub(in crate::dynamics) rings: Vec<PinRing>,
    flanges: Flanges,
    input: Input,
    load: OutputLoad,
    resistance: Resistance,
    elastic: ElasticCoordinates,
    mass: Vec<f64>,
    scale: Vec<f64>,
    /// Values of the coordinates that do not move.
    held: Vec<f64>,
}

impl Mechanism {
    /// A mechanism of joints over coordinates, with its input held at 0 and without load.
    ///
    /// ```
    /// # extern crate arcmin_mechanics as arcmin;
    /// use arcmin::dynamics::mechanism::{
    ///     Axis, Body, Flanges, Input, Mechanism, NominalMotion, Part, Registry, Resistance, Torsion,
    /// };
    /// use arcmin::dynamics::{EquilibriumControl, solve_equilibrium};
    ///
    /// // Two discs on one axis with a torsion spring between them.
    /// let mut bodies = Registry::default();
    /// let turn = |free| Axis { mass: 1e-3, scale: 1e-4, free };
    /// let output = bodies.add_turn(turn(true), NominalMotion::turning(1.0));
    /// let input = bodies.add_turn(turn(false), NominalMotion::turning(1.0));
    /// let coordinates = bodies.number();
    /// let [output, input] = [output, input].map(|body| coordinates.of(body)[0]);
    /// let spring = Torsion { part: Part::new("shaft"), index: [output, input], stiffness: 500.0, loss_time: 0.0 };
    /// let flanges = Flanges { input, output, phase: output, ratio: 1.0 };
    /// let mut mechanism = Mechanism::new(coordinates, vec![Box::new(spring)], flanges, Resistance::none())?;
    /// mechanism.set_load(2.0);
    /// let rest = solve_equilibrium(&mechanism, 0.0, &[0.0], EquilibriumControl::default())?;
    /// assert!((mechanism.output_error(&rest.position) + 2.0 / 500.0).abs() < 1e-12);
    /// # Ok::<(), arcmin::dynamics::DynamicsError>(())
    /// ```
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] if output or phase are not free coordinates, and for masses, scales,
    /// ratios and resistances outside of their ranges.
    pub fn new(
        coordinates: Coordinates,
        joints: Vec<Box<dyn Joint>>,
        flanges: Flanges,
        resistance: Resistance,
    ) -> Result<Mechanism, DynamicsError> {
        Mechanism::with_pins(coordinates, joints, Vec::new(), flanges, resistance)
    }

    /// As [`Mechanism::new`], with contacts of pins on flanks.
    pub(in crate::dynamics) fn with_pins(
        coordinates: Coordinates,
        joints: Vec<Box<dyn Joint>>,
        rings: Vec<PinRing>,
        flanges: Flanges,
        resistance: Resistance,
    ) -> Result<Mechanism, DynamicsError> {
        let (mass, scale) = (coordinates.mass(), coordinates.scale());
        let mut mechanism = Mechanism {
            elastic: ElasticCoordinates::new(coordinates.size),
            input: Input::Held { angle: 0.0, speed: 0.0 },
            load: OutputLoad::None,
            held: coordinates.nominal_of_all(0.0).split_off(coordinates.size),
            coordinates,
            joints,
            rings,
            flanges,
            resistance,
            mass,
            scale,
        };
        mechanism.validate()?;
        let mut elastic = std::mem::take(&mut mechanism.elastic);
        let add = &mut |index: &[usize], stiffness: &[f64]| elastic.add(index, stiffness);
        mechanism.elements().for_each(|joint| joint.elastic(add));
        mechanism.elastic = elastic;
        Ok(mechanism)
    }

    fn validate(&self) -> Result<(), DynamicsError> {
        let check = DynamicsError::require;
        let Mechanism { coordinates, flanges, resistance, .. } = self;
        for (name, at) in [("output of a mechanism", flanges.output), ("phase of a mechanism", flanges.phase)]
        {
            check(at < coordinates.size, name, at as f64, "", "must be the number of a free coordinate")?;
        }
        let input = flanges.input;
        check(
            input < coordinates.whole,
            "input of a mechanism",
            input as f64,
            "",
            "must be the number of a coordinate",
        )?;
        for mass in &self.mass {
            check(
                *mass >= 0.0 && mass.is_finite(),
                "mass of a coordinate",
                *mass,
                "kg",
                "must not be negative",
            )?;
        }
        for scale in &self.scale {
            check(
                *scale > 0.0 && scale.is_finite(),
                "scale of a coordinate",
                *scale,
                "",
                "must be positive",
            )?;
        }
        let ratio = flanges.ratio;
        check(ratio != 0.0 && ratio.is_finite(), "ratio", ratio, "", "must not be zero")?;
        let Resistance { drag, drag_speed, oil: (_, oil) } = *resistance;
        check(drag >= 0.0 && drag.is_finite(), "drag torque", drag, "N·m", "must not be negative")?;
        check(drag_speed > 0.0, "speed at which drag sets in", drag_speed, "rad/s", "must be positive")?;
        check(oil >= 0.0 && oil.is_finite(), "oil drag", oil, "N·m·s/rad", "must not be negative")
    }

    /// Drives the input, or holds it.
    pub fn set_input(&mut self, input: Input) {
        self.input = input;
    }

    /// Holds the input at an angle (rad); the speed (rad/s) is used for friction only.
    pub fn hold_input(&mut self, angle: f64, speed: f64) {
        self.input = Input::Held { angle, speed };
    }

    /// Constant torque at the output in N·m, positive against positive motion.
    pub(in crate::dynamics) fn set_resistance(&mut self, resistance: Resistance) {
        self.resistance = resistance;
    }

    /// Sets a steady torque at the output, N·m, positive against positive motion.
    pub fn set_load(&mut self, torque: f64) {
        self.load = OutputLoad::Constant { torque };
    }

    /// Constant torque at the output in N·m.
    pub(crate) fn constant_load(&self) -> f64 {
        self.load.torque(0.0)
    }

    /// Bodies with their axes and nominal motion.
    pub fn coordinates(&self) -> &Coordinates {
        &self.coordinates
    }

    /// Coordinates of input and output.
    pub fn flanges(&self) -> Flanges {
        self.flanges
    }

    /// Whether the input is driven by a torque.
    pub fn has_free_input(&self) -> bool {
        self.flanges.input < self.coordinates.size
    }

    /// Index of the output's angle among the coordinates.
    pub fn output_index(&self) -> usize {
        self.flanges.output
    }

    /// Coordinates of the nominal mechanism with the input at an angle in rad.
    pub fn nominal_position_at(&self, input: f64) -> Vec<f64> {
        self.coordinates.nominal(input)
    }

    /// Velocities of the nominal mechanism with the input at an angle (rad) and a speed (rad/s).
    pub fn nominal_velocity_at(&self, input: f64, speed: f64) -> Vec<f64> {
        // Nominal motion is smooth: a central difference over 1e-6 rad is exact to rounding.
        let h = 1e-6;
        let (ahead, behind) = (self.nominal_position_at(input + h), self.nominal_position_at(input - h));
        ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * h) * speed).collect()
    }

    /// Rotates the plane displacement of every body, and the deformation of an elastic ring of pins, by an
    /// angle (rad), in place.
    pub(crate) fn rotate_displacements(&self, displacements: &mut [f64], angle: f64) {
        let (sin, cos) = angle.sin_cos();
        for x in self.coordinates.centres() {
            (displacements[x], displacements[x + 1]) = (
                cos * displacements[x] - sin * displacements[x + 1],
                sin * displacements[x] + cos * displacements[x + 1],
            );
        }
        if let Some(housing) = self.rings.first().and_then(|ring| ring.housing.as_ref()) {
            housing.body.turn(&mut displacements[housing.at.clone()], angle);
        }
    }

    /// Replaces the depth removed from the flanks (including designed relief) and the pins, m: one relief for
    /// all, or one for each disc and one for each pin of each disc.
    pub(crate) fn set_surfaces(&mut self, flanks: &[Relief], pins: &[Relief]) {
        self.set_surfaces_of(0..self.rings.len(), flanks, pins);
    }

    /// The same for some of the rings.
    pub(crate) fn set_surfaces_of(&mut self, rings: Range<usize>, flanks: &[Relief], pins: &[Relief]) {
        for (disc, ring) in self.rings[rings].iter_mut().enumerate() {
            ring.contacts.set_relief(flanks[disc % flanks.len()].clone());
            let count = ring.contacts.pins().len();
            match pins.chunks_exact(count).nth(disc) {
                Some(own) => ring.contacts.set_pin_reliefs(own.to_vec()),
                None => ring.contacts.set_pin_relief(pins[0].clone()),
            }
        }
    }

    /// θ_out − θ_in/i in rad with the input held.
    pub fn output_error(&self, position: &[f64]) -> f64 {
        position[self.flanges.output] - self.held_input() / self.flanges.ratio
    }

    /// Angle (rad) at which the input is held, 0 if it is not held.
    pub(in crate::dynamics) fn held_input(&self) -> f64 {
        match self.input {
            Input::Held { angle, .. } => angle,
            Input::Driven(_) => 0.0,
        }
    }

    /// Tangent compliance in rad/(N·m) of every part along the motion g = dq/dT of all coordinates
    /// (rad/(N·m), m/(N·m)).
    pub fn split(&self, position: &[f64], motion: &[f64]) -> Vec<(Part, f64)> {
        let mut whole = motion.to_vec();
        whole.resize(self.coordinates.whole, 0.0);
        let mut compliance: Vec<(Part, f64)> = Vec::new();
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        let mut add = |part: Part, share: f64| match compliance.iter_mut().find(|(own, _)| *own == part) {
            Some((_, sum)) => *sum += share,
            None => compliance.push((part, share)),
        };
        self.elements().for_each(|joint| joint.split(State { q: &q, v: &v }, &whole, &mut add));
        compliance
    }

    /// All joints, the pins last.
    pub(in crate::dynamics) fn elements(&self) -> impl Iterator<Item = &dyn Joint> {
        self.joints.iter().map(AsRef::as_ref).chain(self.rings.iter().map(|ring| ring as &dyn Joint))
    }

    /// Passes springs, dampers and friction of all joints on to `sink`. `q` and `v` are of all coordinates,
    /// including held or prescribed ones.
    pub(in crate::dynamics) fn visit(&self, q: &[f64], v: &[f64], sink: &mut dyn Sink) {
        self.elements().for_each(|joint| joint.visit(State { q, v }, sink));
    }
}
