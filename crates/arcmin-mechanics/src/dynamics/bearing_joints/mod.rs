//! The machine with real joints: all bodies free in the plane, supported by their bearings.

mod build;
mod causes;
#[cfg(test)]
mod elastic_tests;
#[cfg(test)]
mod error_tests;
mod freeing;
mod interface;
pub mod labels;
mod layout;
mod preload;
mod shaft;
mod sharing;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tilt_tests;

use std::ops::{Deref, DerefMut};

pub use sharing::{BearingMeshing, LostMotionSplit};

use build::Bearings;
use layout::Layout;

use super::mechanism::{BearingState, Input, Mechanism, State, VARIABLES};
use super::{Drive, DynamicsError, ElasticCarrier, ElasticDiscs, ElasticHousing, MainBearings, OutputLoad};
use crate::geometry::Relief;
use crate::machine::{Kinematics, Machine, ManufacturingErrors, OutputForces, PartWear};

/// An output that tilts in its main bearings.
#[derive(Debug, Clone, PartialEq)]
pub struct TiltingOutput {
    /// The two rows of the main bearings that support the output.
    pub rows: MainBearings,
    /// External forces on the output, in the plane of x and the axis.
    pub forces: OutputForces,
}

impl TiltingOutput {
    /// For the main bearings of a machine, with external forces.
    pub fn of(machine: &Machine, forces: OutputForces) -> TiltingOutput {
        TiltingOutput { rows: MainBearings::of(machine), forces }
    }
}

/// Settings of the model in addition to the machine.
#[derive(Debug, Clone)]
pub struct JointSettings {
    /// Effective wear depth of the flanks, m: one for all discs, or one for each disc.
    pub flank_wear: Vec<Relief>,
    /// Wear depth of the pins, m: one for all, or one for each pin of the first disc, then of the next.
    pub pin_wear: Vec<Relief>,
    /// Wear of bearings and gears.
    pub part_wear: PartWear,
    /// Deviations of the machine from its drawing.
    pub errors: ManufacturingErrors,
    /// Elastic discs from [`ElasticDiscs::free`], with deformable bore rims if reduced with them; `None` for
    /// rigid discs.
    pub discs: Option<ElasticDiscs>,
    /// A carrier whose crank seats deform relative to its output face; `None` for a rigid one.
    pub carrier: Option<ElasticCarrier>,
    /// A housing that displaces its pins; requires elastic discs.
    pub housing: Option<ElasticHousing>,
    /// An output that tilts, with its main bearings as rows of rolling elements; with `None` these are one
    /// radial support and the output does not tilt.
    pub tilt: Option<TiltingOutput>,
    /// Factor on the stiffness of bearings, shafts and supports (not of teeth, discs and gears); 1 for the
    /// actual machine.
    pub stiffness_scale: f64,
    /// Whether contacts and meshes are damped; a quasi-static test does not need damping.
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
            tilt: None,
            stiffness_scale: 1.0,
            damped: true,
        }
    }
}

/// Discs, crankshafts, carrier and sun with free positions in the plane, in roller bearings with clearance.
///
/// Coordinates are absolute positions (m) and angles (rad): for each crankshaft (x, y) of the shaft at both
/// supports and at every disc, and its rotation; for each disc (x, y, θ) and its modes, if it is elastic
/// ([`ElasticDiscs`]); (x, y) of the sun; (x, y, θ) of the carrier, or of the housing if that is the output;
/// the rotation of the carrier's flange if its torsional stiffness is given; the rotations of sun and input if
/// they are free. The shaft's mass is concentrated at its stations. All springs are derived from energies, so
/// that forces and tangents are consistent: pins (any contact law, seat compliance in series), turning-arm
/// bearings between eccentric and disc bore, crank supports between shaft and carrier, bending and shear of the
/// shaft, involute meshes with movable centres (shaft torsion in series), main bearings, the sun's support,
/// torsion of carrier and input shaft. Damping of bearings and shafts is proportional to their tangent
/// stiffness.
///
/// Elastic bodies add coordinates of their own: the modes of a disc, which displace its flank and the centres
/// and rims of its bores; the displacements and ovalisations of the carrier's crank seats; the smooth modes of
/// the ring of pins ([`ElasticHousing`]).
///
/// With [`TiltingOutput`] the carrier tilts and moves axially relative to the housing, the crank seats at its two ends
/// move with it, and external forces act on the output. Crankshafts and discs tilt as well: the slopes ∂(x,
/// y)/∂z of every shaft at its supports and at every disc, and of every disc, are coordinates. The load of
/// rollers between tilted rings, and of pins on a tilted disc, varies over their length; it is represented by
/// two slices l/√12 from their middle, which transmit couples between shafts and discs.
///
/// The planet is at the first support. Not modelled: the cage's own motion, spacers beside the discs, the
/// compliance of the carrier's seats under couples.
#[derive(Debug, Clone)]
pub struct BearingJoints {
    mechanism: Mechanism,
    kinematics: Kinematics,
    layout: Layout,
    bearings: Bearings,
    has_errors: bool,
    /// Magnitude of the rated torque in N·m.
    rated: f64,
}

impl Deref for BearingJoints {
    type Target = Mechanism;

    fn deref(&self) -> &Mechanism {
        &self.mechanism
    }
}

impl DerefMut for BearingJoints {
    fn deref_mut(&mut self) -> &mut Mechanism {
        &mut self.mechanism
    }
}

impl BearingJoints {
    /// Builds the model; `drag` is a steady torque (N·m) at the output against its motion, in addition to the
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

    /// The model with the sun held, for static analyses; load and sun angle are set later.
    ///
    /// # Errors
    /// As [`BearingJoints::new`].
    pub fn held(machine: &Machine, settings: &JointSettings) -> Result<BearingJoints, DynamicsError> {
        BearingJoints::build(machine, settings, Input::Held { angle: 0.0, speed: 0.0 }, OutputLoad::None, 0.0)
    }

    /// The bodies and joints without the interface of an RV reducer.
    pub fn into_mechanism(self) -> Mechanism {
        self.mechanism
    }

    /// Coordinates (x, y, θ) of a disc.
    #[cfg(test)]
    pub(super) fn disc_place(&self, disc: usize) -> [usize; 3] {
        let at = self.layout.disc(disc);
        [at, at + 1, at + 2]
    }

    /// Ratios, phases and nominal poses of the machine.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// Holds the sun at an angle (rad); the speed (rad/s) is used for friction only.
    pub fn hold_sun(&mut self, angle: f64, speed: f64) {
        self.mechanism.hold_input(angle, speed);
    }

    /// The same machine with all friction and drag multiplied by `share`.
    pub(crate) fn with_friction(&self, share: f64) -> BearingJoints {
        let mut model = self.clone();
        model.scale_friction(share);
        model
    }

    /// Magnitude of the rated torque in N·m.
    pub(crate) fn rated_torque(&self) -> f64 {
        self.rated
    }

    /// Angle of the nominal carrier in rad at a sun angle.
    pub(crate) fn carrier_angle_at(&self, sun: f64) -> f64 {
        if self.layout.housing_moves() { 0.0 } else { sun / self.kinematics.ratio() }
    }

    /// Force (N) on the inner ring, and rolling element forces of a bearing.
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

    /// Rolling elements of a turning-arm bearing: angular position (rad) in the frame of the coordinates, and
    /// radial force (N) on the disc.
    pub fn turning_arm_elements(&self, crankshaft: usize, disc: usize, position: &[f64]) -> Vec<(f64, f64)> {
        let (q, _) = self.full(0.0, position, &vec![0.0; position.len()]);
        let bearing = self.joints[self.bearings.turning_arms[crankshaft][disc]].bearing();
        bearing.map_or_else(Vec::new, |bearing| bearing.radial_element_forces(&q))
    }

    /// Force (N) on the inner ring and rolling element forces of a crank support; `end` is 0 (planet side) or 1.
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

    /// The loaded pins of every disc.
    pub(crate) fn loaded_pin_contacts(&self, position: &[f64]) -> Vec<Vec<crate::contact::PinContact>> {
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        self.rings.iter().map(|ring| ring.loaded(State { q: &q, v: &v })).collect()
    }

    /// [`BearingJoints::pin_contacts`] of every disc.
    pub(crate) fn all_pin_contacts(&self, position: &[f64]) -> Vec<Vec<crate::contact::PinContact>> {
        (0..self.rings.len()).map(|disc| self.pin_contacts(disc, position)).collect()
    }
}
