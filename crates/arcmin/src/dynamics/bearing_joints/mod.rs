//! The machine with real joints: every body free in the plane, held by its bearings.

mod assembly;
mod build;
mod causes;
mod elastic;
#[cfg(test)]
mod error_tests;
mod freeing;
mod interface;
mod joints;
mod layout;
mod preload;
mod registry;
mod rim;
mod roller;
mod running;
mod shaft;
mod sharing;
mod system;
mod tangent;
#[cfg(test)]
mod tests;

pub use assembly::Part;
pub(crate) use assembly::Wanted;
pub use causes::Cause;
pub(super) use joints::Shown;
pub(super) use roller::{AXIAL, ROW, SLOPE, Stand};
pub use roller::{BearingState, ElementLoad, RollingBearing};
pub use sharing::{BearingMeshing, LostMotionSplit};

use assembly::Sink;
use build::Bearings;
use joints::{Joint, PinRing, State};
use layout::Layout;
use roller::VARIABLES;

use super::{
    Drive, DynamicsError, ElasticCarrier, ElasticCoordinates, ElasticDiscs, ElasticHousing, MainBearings,
    OutputLoad,
};
use crate::geometry::{Relief, Vec2, unit};
use crate::machine::{Kinematics, Machine, ManufacturingErrors, OutputForces, PartWear};

/// An output that leans in its main bearings.
#[derive(Debug, Clone, PartialEq)]
pub struct Lean {
    pub rows: MainBearings,
    /// What acts on the output from outside, in the plane of x and the axis.
    pub forces: OutputForces,
}

impl Lean {
    /// In the main bearings of a machine, under forces from outside.
    pub fn of(machine: &Machine, forces: OutputForces) -> Lean {
        Lean { rows: MainBearings::of(machine), forces }
    }
}

/// What the model takes beside the machine.
#[derive(Debug, Clone)]
pub struct JointSettings {
    /// Metal lost by the flanks, as the contact sees it: one for all discs, or one per disc.
    pub flank_wear: Vec<Relief>,
    /// Metal lost by the pins: one for all, or pin by pin for the first disc, then for the next.
    pub pin_wear: Vec<Relief>,
    /// What bearings and gears have lost.
    pub part_wear: PartWear,
    pub errors: ManufacturingErrors,
    /// Discs that deform, from [`ElasticDiscs::free`], with their bores' rims where they were reduced so; rigid ones
    /// without.
    pub discs: Option<ElasticDiscs>,
    /// A carrier whose crank seats give way against its output face; a rigid one without.
    pub carrier: Option<ElasticCarrier>,
    /// A housing that moves its pins; goes with elastic discs.
    pub housing: Option<ElasticHousing>,
    /// An output that leans, its main bearings as rows of rolling elements; without, they are one radial support
    /// and the output stands straight.
    pub lean: Option<Lean>,
    /// Multiplies the stiffness of bearings, shafts and supports (not of teeth, discs and gears); 1 for the
    /// machine as it is.
    pub stiffness_scale: f64,
    /// Whether contacts and meshes are damped; a slow quasi-static test has no use for damping.
    pub damped: bool,
}

impl Default for JointSettings {
    fn default() -> JointSettings {
        JointSettings {
            flank_wear: vec![Relief::uniform(0.0)],
            pin_wear: vec![Relief::uniform(0.0)],
            part_wear: PartWear::default(),
            errors: ManufacturingErrors::default(),
            discs: None,
            carrier: None,
            housing: None,
            lean: None,
            stiffness_scale: 1.0,
            damped: true,
        }
    }
}

/// How the sun moves.
#[derive(Debug, Clone, PartialEq)]
enum Input {
    Driven(Drive),
    /// At an angle (rad) with a speed (rad/s) that only friction sees.
    Held {
        angle: f64,
        speed: f64,
    },
}

/// A centre that goes round with a body: place in polar coordinates of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Arm {
    radius: f64,
    phase: f64,
}

impl Arm {
    fn new(place: Vec2) -> Arm {
        Arm { radius: place.norm(), phase: place.y.atan2(place.x) }
    }

    fn at(&self, angle: f64) -> Vec2 {
        self.radius * unit(angle + self.phase)
    }
}

/// Discs, crankshafts, carrier and sun free in the plane, in roller bearings with clearance.
///
/// Coordinates are absolute places (m) and angles (rad): per crankshaft the shaft at both supports and at
/// every disc (x, y) and its turn; per disc (x, y, θ) and its modes, if it is elastic ([`ElasticDiscs`]); sun
/// (x, y); carrier (x, y, θ), or housing where that is the output; the carrier's flange where its torsion is
/// given; the turn of sun and input where they are free. The shaft's mass sits at its stations. All springs
/// derive from energies, so forces and tangents agree: pins (any contact law, seat compliance in series),
/// turning-arm bearings between eccentric and disc bore, crank supports between shaft and carrier, bending
/// and shear of the shaft, involute meshes with moving centres (shaft torsion in series), main bearings, the
/// sun's support, torsion of carrier and input shaft. Bearings and shafts are damped in proportion to their
/// tangent stiffness.
///
/// Elastic bodies add coordinates of their own, body by body: the modes of a disc, which move the places of its flank and
/// the centres and rims of its bores; the ways of the carrier's crank seats and their going out of round; the smooth
/// modes of the ring of pins ([`ElasticHousing`]).
///
/// With [`Lean`] the carrier leans and moves along its axis against the housing: the crank seats at its two ends
/// go with it, and forces from outside act on the output. Crankshafts and discs lean as well: slopes ∂(x, y)/∂z of
/// every shaft at its supports and at every disc, and of every disc, are coordinates. Rollers between rings that lean
/// against each other and pins on a disc that leans are pressed otherwise at one end than at the other; as the mean of
/// two slices l/√12 from their middle they hold the shafts and the discs by couples.
///
/// The planet sits at the first support. Not modelled: the cage's own motion, spacers beside the discs, how seats in
/// the carrier give way to couples.
#[derive(Debug, Clone)]
pub struct BearingJoints {
    kinematics: Kinematics,
    layout: Layout,
    /// Everything between the bodies but the pins.
    joints: Vec<Box<dyn Joint>>,
    /// The pins, disc by disc.
    rings: Vec<PinRing>,
    bearings: Bearings,
    input: Input,
    load: OutputLoad,
    drag: f64,
    drag_speed: f64,
    /// N·m·s/rad at the sun.
    oil_drag: f64,
    has_errors: bool,
    elastic: ElasticCoordinates,
    mass: Vec<f64>,
    scale: Vec<f64>,
    /// Size of the rated torque in N·m.
    rated: f64,
}

impl BearingJoints {
    /// Builds the model; `drag` is a steady torque (N·m) at the output against its motion, on top of the
    /// machine's seal drag.
    ///
    /// # Errors
    /// [`DynamicsError`] for values without meaning.
    pub fn new(
        machine: &Machine,
        settings: &JointSettings,
        drive: Drive,
        load: OutputLoad,
        drag: f64,
    ) -> Result<BearingJoints, DynamicsError> {
        drive.validate()?;
        BearingJoints::build(machine, settings, Input::Driven(drive), load, drag)
    }

    /// The model with the sun held, for static questions; load and sun angle are set later.
    ///
    /// # Errors
    /// As [`BearingJoints::new`].
    pub fn held(machine: &Machine, settings: &JointSettings) -> Result<BearingJoints, DynamicsError> {
        BearingJoints::build(machine, settings, Input::Held { angle: 0.0, speed: 0.0 }, OutputLoad::None, 0.0)
    }

    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Holds the sun at an angle (rad); friction sees the speed (rad/s).
    pub fn hold_sun(&mut self, angle: f64, speed: f64) {
        self.input = Input::Held { angle, speed };
    }

    /// Constant torque at the output in N·m, positive against positive motion.
    pub fn set_load(&mut self, torque: f64) {
        self.load = OutputLoad::Constant { torque };
    }

    /// Index of the output's angle among the coordinates.
    pub fn output_index(&self) -> usize {
        self.layout.output()
    }

    /// Coordinates of the nominal machine at a sun angle in rad.
    pub fn nominal_position_at(&self, sun: f64) -> Vec<f64> {
        self.layout.nominal(&self.kinematics, sun)
    }

    /// Velocities of the nominal machine at a sun angle (rad) and speed (rad/s).
    pub fn nominal_velocity_at(&self, sun: f64, speed: f64) -> Vec<f64> {
        // Nominal motion is smooth: a central difference over 1e-6 rad is exact to rounding.
        let h = 1e-6;
        let (ahead, behind) = (self.nominal_position_at(sun + h), self.nominal_position_at(sun - h));
        ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * h) * speed).collect()
    }

    /// Angle of the nominal carrier in rad at a sun angle.
    pub(crate) fn carrier_angle_at(&self, sun: f64) -> f64 {
        if self.layout.housing_moves() { 0.0 } else { sun / self.kinematics.ratio() }
    }

    /// Turns what is a way in the plane of every body, and how an elastic housing gives way, by an angle (rad), in place.
    pub(crate) fn turn_ways(&self, ways: &mut [f64], angle: f64) {
        let (sin, cos) = angle.sin_cos();
        for x in self.layout.centres() {
            (ways[x], ways[x + 1]) = (cos * ways[x] - sin * ways[x + 1], sin * ways[x] + cos * ways[x + 1]);
        }
        if let Some(housing) = self.rings.first().and_then(|ring| ring.housing.as_ref()) {
            housing.body.turn(&mut ways[housing.at.clone()], angle);
        }
    }

    /// θ_out − θ_in/i in rad with the input held; for a carrier at rest θ_out is the turn of the housing and
    /// i the ratio of that case.
    pub fn output_error(&self, position: &[f64]) -> f64 {
        position[self.layout.output()] - self.held_sun() / self.kinematics.ratio()
    }

    /// Angle at which the sun is held, 0 where it is not.
    fn held_sun(&self) -> f64 {
        match self.input {
            Input::Held { angle, .. } => angle,
            Input::Driven(_) => 0.0,
        }
    }

    /// Tangent compliance in rad/(N·m) of every part along the motion g = dq/dT of all coordinates
    /// (rad/(N·m), m/(N·m)).
    pub fn split(&self, position: &[f64], motion: &[f64]) -> [f64; Part::ALL.len()] {
        let mut whole = motion.to_vec();
        whole.resize(self.layout.whole(), 0.0);
        let mut compliance = [0.0; Part::ALL.len()];
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        let mut add = |part: Part, share: f64| compliance[part as usize] += share;
        self.elements().for_each(|joint| joint.split(State { q: &q, v: &v }, &whole, &mut add));
        compliance
    }

    /// All joints, the pins last.
    fn elements(&self) -> impl Iterator<Item = &dyn Joint> {
        self.joints.iter().map(AsRef::as_ref).chain(self.rings.iter().map(|ring| ring as &dyn Joint))
    }

    /// Hands all springs, dampers and frictions to `sink`. `q` and `v` are of all coordinates, those held or
    /// prescribed included.
    fn visit(&self, q: &[f64], v: &[f64], sink: &mut dyn Sink) {
        self.elements().for_each(|joint| joint.visit(State { q, v }, sink));
    }

    /// Force (N) on the inner ring and rolling element forces of a bearing.
    fn bearing_load(&self, joint: usize, position: &[f64]) -> (BearingState<VARIABLES>, Vec<f64>) {
        let (q, _) = self.full(0.0, position, &vec![0.0; position.len()]);
        self.joints[joint].bearing().map(|bearing| bearing.load(&q)).unwrap_or_default()
    }

    /// Force (N) on the inner ring and rolling element forces of a turning-arm bearing.
    pub fn turning_arm_load(
        &self,
        crankshaft: usize,
        disc: usize,
        position: &[f64],
    ) -> (BearingState<VARIABLES>, Vec<f64>) {
        self.bearing_load(self.bearings.turning_arms[crankshaft][disc], position)
    }

    /// The same of a crank support; `end` is 0 (planet side) or 1.
    pub fn support_load(
        &self,
        crankshaft: usize,
        end: usize,
        position: &[f64],
    ) -> (BearingState<VARIABLES>, Vec<f64>) {
        self.bearing_load(self.bearings.supports[crankshaft][end], position)
    }

    /// State of every pin on one disc.
    pub fn pin_contacts(&self, disc: usize, position: &[f64]) -> Vec<crate::contact::PinContact> {
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        self.rings[disc].all(State { q: &q, v: &v })
    }

    /// The pins that carry, of every disc.
    pub(crate) fn loaded_pin_contacts(&self, position: &[f64]) -> Vec<Vec<crate::contact::PinContact>> {
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        self.rings.iter().map(|ring| ring.loaded(State { q: &q, v: &v })).collect()
    }

    /// [`BearingJoints::pin_contacts`] of every disc.
    pub(crate) fn all_pin_contacts(&self, position: &[f64]) -> Vec<Vec<crate::contact::PinContact>> {
        (0..self.rings.len()).map(|disc| self.pin_contacts(disc, position)).collect()
    }
}
