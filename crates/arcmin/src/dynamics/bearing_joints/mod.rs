//! The machine with real joints: every body free in the plane, held by its bearings.

mod assembly;
mod causes;
mod elastic;
#[cfg(test)]
mod error_tests;
mod layout;
mod planar_mesh;
mod preload;
mod rings;
mod roller;
mod shaft;
mod sharing;
mod springs;
mod system;
mod tangent;
#[cfg(test)]
mod tests;

pub use assembly::Part;
pub use causes::Cause;
pub use roller::{BearingState, RadialBearing};
pub use sharing::{BearingMeshing, LostMotionSplit};

use assembly::Split;
use layout::{Degrees, Layout};
use planar_mesh::PlanarMesh;
use shaft::Shaft;

use super::{Drive, DynamicsError, ElasticDiscs, OutputLoad};
use crate::contact::{PinContacts, Sliding};
use crate::geometry::{Relief, Vec2, quarter_turn, unit};
use crate::machine::{EccentricError, Friction, Kinematics, Machine, ManufacturingErrors, PartWear, RunOut};

/// What the model takes beside the machine.
#[derive(Debug, Clone)]
pub struct JointSettings {
    /// Metal lost by every flank, as the contact sees it.
    pub flank_wear: Relief,
    /// Metal lost by every pin.
    pub pin_wear: Relief,
    /// What bearings and gears have lost.
    pub part_wear: PartWear,
    pub errors: ManufacturingErrors,
    /// Discs that deform, from [`ElasticDiscs::free`]; rigid ones without.
    pub discs: Option<ElasticDiscs>,
    /// Multiplies the stiffness of bearings, shafts and supports (not of teeth, discs and gears); 1 for the
    /// machine as it is.
    pub stiffness_scale: f64,
    /// Whether contacts and meshes are damped; a slow quasi-static test has no use for damping.
    pub damped: bool,
}

impl Default for JointSettings {
    fn default() -> JointSettings {
        JointSettings {
            flank_wear: Relief::uniform(0.0),
            pin_wear: Relief::uniform(0.0),
            part_wear: PartWear::default(),
            errors: ManufacturingErrors::default(),
            discs: None,
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
/// The planet sits at the first support. Not modelled: tilt and axial motion, elastic rings of bearings, the
/// cage's own motion.
#[derive(Debug, Clone)]
pub struct BearingJoints {
    kinematics: Kinematics,
    layout: Layout,
    rings: Vec<PinContacts>,
    elastic: Option<ElasticDiscs>,
    meshes: Vec<PlanarMesh>,
    shaft: Shaft,
    /// Per crankshaft and disc.
    turning_arms: Vec<Vec<RadialBearing>>,
    /// Per crankshaft.
    supports: Vec<RadialBearing>,
    /// Stiffness, radial clearance, and the seat's place on the carrier.
    main: (f64, f64),
    main_seat: Arm,
    sun_support: f64,
    carrier_torsion: f64,
    input_torsion: f64,
    /// Eccentrics per crankshaft and disc, bores per crankshaft and disc, bores of the carrier, journals.
    eccentrics: Vec<Vec<Arm>>,
    disc_bores: Vec<Vec<Arm>>,
    carrier_bores: Vec<Arm>,
    journals: Vec<Arm>,
    input: Input,
    load: OutputLoad,
    drag: f64,
    drag_speed: f64,
    friction: Friction,
    mesh_sliding: f64,
    loss_time: f64,
    part_wear: PartWear,
    has_errors: bool,
    /// What is taken off the flank on purpose, to tell it from wear.
    designed_relief: Relief,
    equidistant_offset: f64,
    radial_offset: f64,
    mass: Vec<f64>,
    scale: Vec<f64>,
}

/// Ratio of damping to tangent stiffness in bearings and shafts, s. An assumption: a loss factor of 1 % at 1
/// kHz.
const LOSS_TIME: f64 = 2e-6;

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

    fn build(
        machine: &Machine,
        settings: &JointSettings,
        input: Input,
        load: OutputLoad,
        drag: f64,
    ) -> Result<BearingJoints, DynamicsError> {
        load.validate()?;
        validate(machine, settings, drag)?;
        let kinematics = machine.kinematics();
        let errors = &settings.errors;
        let scale = settings.stiffness_scale;
        let (cranks, discs) = (machine.crankshafts.count, machine.disc_count);
        let radius = machine.gear_stage.centre_distance();
        let place = |k: usize| Kinematics::crankshaft_angle(machine.crankshafts.first_angle, k, cranks);
        let bore = |error: Option<&crate::machine::BoreError>, angle: f64| {
            let error = error.copied().unwrap_or_default();
            Arm::new((radius + error.radial) * unit(angle) + error.tangential * quarter_turn(unit(angle)))
        };
        let eccentric_error = |k: usize, j: usize| {
            errors.eccentrics.get(k).and_then(|list| list.get(j)).copied().unwrap_or_default()
        };
        let run_out = |list: &[RunOut], k: usize| list.get(k).copied().unwrap_or_default();
        let disc_bore = |k: usize, j: usize| errors.discs.get(j).and_then(|disc| disc.bores.get(k));
        let shaft = Shaft::new(machine, scale);
        let torsional = machine.carrier.torsional_stiffness * scale;
        let stage = &machine.gear_stage;
        let input_torsion = stage.input_torsional_stiffness * scale;
        let free_input = matches!(&input, Input::Driven(drive) if drive.leaves_sun_free());
        let degrees =
            Degrees { flange: torsional.is_finite(), input_shaft: input_torsion.is_finite(), free_input };
        if free_input && degrees.input_shaft {
            DynamicsError::require(
                stage.motor_inertia > 0.0,
                "moment of inertia of the motor",
                stage.motor_inertia,
                "kg·m²",
                "must be positive behind an elastic input shaft",
            )?;
        }
        let elastic = settings.discs.clone();
        let modes = (0..discs).map(|j| elastic.as_ref().map_or(0, |elastic| elastic.mode_count(j))).collect();
        let layout = Layout::new(cranks, modes, machine.fixed_member, degrees);
        let turning_arm = |k: usize, j: usize| {
            let mut bearing = RadialBearing::new(&machine.bearings.turning_arm, scale);
            bearing.widen(disc_bore(k, j).map_or(0.0, |bore| bore.diameter));
            bearing
        };
        let support = |k: usize| {
            let mut bearing = RadialBearing::new(&machine.bearings.crank_support, scale);
            bearing.widen(errors.carrier_bores.get(k).map_or(0.0, |bore| bore.diameter));
            bearing
        };
        let ratio = kinematics.ratio();
        let mut model = BearingJoints {
            rings: (0..discs).map(|j| ring(machine, settings, j)).collect(),
            meshes: (0..cranks)
                .map(|k| {
                    let mut mesh = PlanarMesh::new(machine, k, shaft.torsion);
                    if !settings.damped {
                        mesh.damping = 0.0;
                    }
                    let planet = run_out(&errors.planets, k);
                    mesh.planet_run_out = (planet.amplitude, planet.phase);
                    mesh.sun_run_out = (errors.sun.amplitude, errors.sun.phase);
                    mesh
                })
                .collect(),
            turning_arms: (0..cranks).map(|k| (0..discs).map(|j| turning_arm(k, j)).collect()).collect(),
            supports: (0..cranks).map(support).collect(),
            main: (machine.bearings.main.radial * scale, 0.5 * machine.bearings.main.clearance),
            main_seat: Arm { radius: errors.carrier.amplitude, phase: errors.carrier.phase },
            sun_support: machine.bearings.sun.radial * scale,
            carrier_torsion: torsional,
            input_torsion,
            eccentrics: (0..cranks)
                .map(|k| {
                    (0..discs)
                        .map(|j| {
                            let EccentricError { eccentricity, phase } = eccentric_error(k, j);
                            Arm {
                                radius: machine.crankshafts.eccentricity + eccentricity,
                                phase: kinematics.phases[j] + phase,
                            }
                        })
                        .collect()
                })
                .collect(),
            disc_bores: (0..cranks)
                .map(|k| {
                    // The disc's own angle zero is that of its flank; the bores are turned back by the
                    // mounting angle.
                    (0..discs)
                        .map(|j| bore(disc_bore(k, j), place(k) - kinematics.mounting_angle(j)))
                        .collect()
                })
                .collect(),
            carrier_bores: (0..cranks).map(|k| bore(errors.carrier_bores.get(k), place(k))).collect(),
            journals: (0..cranks)
                .map(|k| {
                    let RunOut { amplitude, phase } = run_out(&errors.journals, k);
                    Arm { radius: amplitude, phase }
                })
                .collect(),
            mass: layout.mass(machine),
            scale: layout.scale(&kinematics, radius, ElasticDiscs::scale(machine)),
            elastic,
            input,
            load,
            drag: drag + machine.friction.seal_drag,
            drag_speed: (0.01 * machine.rated.input_speed / ratio).abs().max(1e-6),
            friction: machine.friction,
            // Mean distance of the contact from the pitch point: a quarter of a path of contact of 1.6 base
            // pitches.
            mesh_sliding: 0.4 * std::f64::consts::PI * stage.module * stage.pressure_angle.cos(),
            loss_time: if settings.damped { LOSS_TIME } else { 0.0 },
            part_wear: PartWear::default(),
            has_errors: !settings.errors.is_zero(),
            designed_relief: machine.designed_relief(),
            equidistant_offset: machine.disc.modification.equidistant_offset,
            radial_offset: machine.disc.modification.radial_offset,
            shaft,
            layout,
            kinematics,
        };
        model.set_part_wear(settings.part_wear);
        Ok(model)
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
        self.layout.nominal(&self.kinematics, &self.carrier_bores, sun)
    }

    /// Velocities of the nominal machine at a sun angle (rad) and speed (rad/s).
    pub fn nominal_velocity_at(&self, sun: f64, speed: f64) -> Vec<f64> {
        // Nominal motion is smooth: a central difference over 1e-6 rad is exact to rounding.
        let h = 1e-6;
        let (ahead, behind) = (self.nominal_position_at(sun + h), self.nominal_position_at(sun - h));
        ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * h) * speed).collect()
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
        let mut split = Split { motion: &whole, compliance: [0.0; Part::ALL.len()] };
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        self.visit(&q, &v, &mut split);
        self.split_rings(&q, &mut split);
        split.compliance
    }

    /// Relative displacement of eccentric and bore (m) and cage angle (rad) of a turning-arm bearing.
    fn turning_arm_state(&self, k: usize, j: usize, q: &[f64]) -> ([f64; 2], f64) {
        let (s, t, d) = (self.layout.disc_station(k, j), self.layout.crank_angle(k), self.layout.disc(j));
        let u = Vec2::new(q[s] - q[d], q[s + 1] - q[d + 1]) + self.eccentrics[k][j].at(q[t])
            - self.bore_at(k, j, q);
        let w = self.turning_arms[k][j].inner_share;
        ([u.x, u.y], w * q[t] + (1.0 - w) * q[d + 2])
    }

    fn support_state(&self, k: usize, end: usize, q: &[f64]) -> ([f64; 2], f64) {
        let (s, t, [cx, cy, carrier]) =
            (self.layout.support(k, end), self.layout.crank_angle(k), self.layout.carrier());
        let u = Vec2::new(q[s] - q[cx], q[s + 1] - q[cy]) + self.journals[k].at(q[t])
            - self.carrier_bores[k].at(q[carrier]);
        let w = self.supports[k].inner_share;
        ([u.x, u.y], w * q[t] + (1.0 - w) * q[carrier])
    }

    /// Force (N) on the inner ring and rolling element forces of a turning-arm bearing.
    pub fn turning_arm_load(
        &self,
        crankshaft: usize,
        disc: usize,
        position: &[f64],
    ) -> (BearingState, Vec<f64>) {
        let (q, _) = self.full(0.0, position, &vec![0.0; position.len()]);
        let (u, cage) = self.turning_arm_state(crankshaft, disc, &q);
        let bearing = &self.turning_arms[crankshaft][disc];
        (bearing.react(u, cage), bearing.element_forces(u, cage).collect())
    }

    /// The same of a crank support; `end` is 0 (planet side) or 1.
    pub fn support_load(&self, crankshaft: usize, end: usize, position: &[f64]) -> (BearingState, Vec<f64>) {
        let (q, _) = self.full(0.0, position, &vec![0.0; position.len()]);
        let (u, cage) = self.support_state(crankshaft, end, &q);
        let bearing = &self.supports[crankshaft];
        (bearing.react(u, cage), bearing.element_forces(u, cage).collect())
    }

    /// State of every pin on one disc.
    pub fn pin_contacts(&self, disc: usize, position: &[f64]) -> Vec<crate::contact::PinContact> {
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        self.ring_contacts(disc, &q, &v)
    }
}

/// The pins against disc j, with the errors of ring and disc.
fn ring(machine: &Machine, settings: &JointSettings, disc: usize) -> PinContacts {
    let errors = &settings.errors;
    let mut pins = machine.pins();
    for (i, pin) in pins.iter_mut().enumerate() {
        let own = errors.pins.get(i).copied().unwrap_or_default();
        let outward = pin.centre.normalize();
        let RunOut { amplitude, phase } = errors.pin_circle_offset;
        pin.centre += (errors.pin_circle_radius + own.radial) * outward
            + own.tangential * quarter_turn(outward)
            + amplitude * unit(phase);
        pin.radius += errors.pin_radius + own.radius;
    }
    let contact =
        machine.line_contact().with_seat_compliance(machine.ring.seat_compliance / settings.stiffness_scale);
    let mut ring = PinContacts::new(
        machine.profile(),
        pins,
        machine.designed_relief().plus(&settings.flank_wear),
        contact,
    );
    ring.set_pin_relief(settings.pin_wear.clone());
    if let Some(error) = errors.discs.get(disc) {
        ring.set_flank_error(error.flank.clone());
    }
    ring.set_damping(settings.damped.then_some(machine.contact_damping));
    ring.set_conservative(true);
    let friction = &machine.friction;
    let coefficient = machine.flank_friction();
    ring.set_sliding(Some(Sliding { coefficient, regularisation_speed: friction.regularisation_speed }));
    if let Some(discs) = &settings.discs {
        discs.take_over(&mut ring, machine);
    }
    ring
}

fn validate(machine: &Machine, settings: &JointSettings, drag: f64) -> Result<(), DynamicsError> {
    let check = DynamicsError::require;
    if let Some(discs) = &settings.discs {
        check(
            discs.count() == machine.disc_count,
            "number of elastic discs",
            discs.count() as f64,
            "",
            "must be that of the machine's discs",
        )?;
    }
    check(drag >= 0.0 && drag.is_finite(), "drag torque", drag, "N·m", "must not be negative")?;
    let positive = [
        ("stiffness scale", settings.stiffness_scale, ""),
        ("mesh stiffness", machine.gear_stage.mesh_stiffness, "N/m"),
        ("radial stiffness of the main bearings", machine.bearings.main.radial, "N/m"),
        ("radial stiffness of the sun's support", machine.bearings.sun.radial, "N/m"),
        ("mass of a crankshaft", machine.crankshafts.mass, "kg"),
        ("inertia of a crankshaft", machine.crankshafts.inertia, "kg·m²"),
        ("mass of a disc", machine.disc.mass, "kg"),
        ("inertia of a disc", machine.disc.inertia, "kg·m²"),
        ("mass of the carrier", machine.carrier.mass, "kg"),
        ("inertia of the carrier", machine.carrier.inertia, "kg·m²"),
        ("mass of the housing", machine.housing.mass, "kg"),
        ("inertia of the housing", machine.housing.inertia, "kg·m²"),
        ("span of the crank supports", machine.bearings.crank_support_span, "m"),
        ("diameter of the crankshaft", machine.crankshafts.shaft_diameter, "m"),
        ("regularisation speed of the friction", machine.friction.regularisation_speed, "m/s"),
    ];
    for (name, value, unit) in positive {
        check(value > 0.0 && value.is_finite(), name, value, unit, "must be positive")?;
    }
    for (name, value) in [
        ("torsional stiffness of the carrier", machine.carrier.torsional_stiffness),
        ("torsional stiffness of the input shaft", machine.gear_stage.input_torsional_stiffness),
    ] {
        check(value > 0.0, name, value, "N·m/rad", "must be positive")?;
    }
    Ok(())
}
