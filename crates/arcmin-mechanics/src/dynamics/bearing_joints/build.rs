//! Assembly of the machine: bodies, joints, pins.

use std::sync::Arc;

use super::labels::{
    CARRIER, CRANK_BENDING, CRANK_SUPPORT, GEARS, HOUSING, INPUT_SHAFT, MAIN_BEARING_CLEARANCE, PIN_RING,
    TURNING_ARM,
};
use super::layout::{Degrees, Layout};
use super::shaft::Shaft;
use super::{BearingJoints, JointSettings};
use crate::contact::{PinContacts, Sliding};
use crate::dynamics::gear_mesh::{GearMesh, MESH_COORDINATES};
use crate::dynamics::mechanism::{
    Arm, Bending, BoreMode, Designed, Frame, Gears, Input, Joint, Journal, LOSS_TIME, Losses, MainPair,
    Mechanism, Modes, OutsideForces, PinRing, Resistance, RollingBearing, SLOPES, Support, Torsion,
};
use crate::dynamics::{DynamicsError, ElasticDiscs, ElasticHousing, OutputLoad, Reducer};
use crate::fem::carrier::RIM_COORDINATES;
use crate::geometry::{Vec2, quarter_turn, unit};
use crate::machine::{BoreError, EccentricError, Kinematics, Machine, ManufacturingErrors, RunOut};

/// All inputs for the construction of joints.
struct Parts<'a> {
    machine: &'a Machine,
    settings: &'a JointSettings,
    kinematics: &'a Kinematics,
    layout: &'a Layout,
    loss_time: f64,
}

/// Numbers of the rolling bearings and gear meshes among the joints.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Bearings {
    /// Turning-arm bearings, for each crankshaft and disc.
    pub turning_arms: Vec<Vec<usize>>,
    /// Crank supports, for each crankshaft and end.
    pub supports: Vec<Vec<usize>>,
    /// Gear meshes, for each crankshaft.
    pub gears: Vec<usize>,
    /// The support that represents the main bearings.
    pub main: usize,
}

impl BearingJoints {
    pub(super) fn build(
        machine: &Machine,
        settings: &JointSettings,
        input: Input,
        load: OutputLoad,
        drag: f64,
    ) -> Result<BearingJoints, DynamicsError> {
        load.validate()?;
        validate(machine, settings, drag)?;
        let kinematics = machine.kinematics();
        let (scale, discs) = (settings.stiffness_scale, machine.disc_count);
        let stage = &machine.gear_stage;
        let free_input = matches!(&input, Input::Driven(drive) if drive.leaves_sun_free());
        let degrees = Degrees {
            // An elastic carrier includes its own torsion.
            flange: settings.carrier.is_none() && (machine.carrier.torsional_stiffness * scale).is_finite(),
            input_shaft: (stage.input_torsional_stiffness * scale).is_finite(),
            free_input,
            seats: settings.carrier.is_some(),
            housing_modes: settings.housing.as_ref().map_or(0, ElasticHousing::count),
            tilt: settings.tilt.is_some(),
        };
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
        let elastic = if settings.damped { elastic } else { elastic.map(ElasticDiscs::undamped) };
        let modes = (0..discs).map(|j| elastic.as_ref().map_or(0, |elastic| elastic.mode_count(j))).collect();
        let layout = Layout::new(
            machine,
            &kinematics,
            (modes, ElasticDiscs::scale(machine.ring.pin_circle_radius, machine.disc.mass)),
            degrees,
            (0..machine.crankshafts.count)
                .map(|k| bore(machine, settings.errors.carrier_bores.get(k), crank_place(machine, k)))
                .collect(),
        );
        let loss_time = if settings.damped { LOSS_TIME } else { 0.0 };
        let parts = Parts { machine, settings, kinematics: &kinematics, layout: &layout, loss_time };
        let (joints, bearings) = parts.joints();
        let rings = parts.rings(elastic);
        let resistance = Resistance {
            drag: drag + machine.friction.seal_drag,
            drag_speed: (0.01 * machine.rated.input_speed / kinematics.ratio()).abs().max(1e-6),
            oil: (layout.sun_angle(), machine.friction.oil_drag),
        };
        let (coordinates, flanges) = (layout.coordinates().clone(), layout.flanges(&kinematics));
        let mut mechanism = Mechanism::with_pins(coordinates, joints, rings, flanges, resistance)?;
        mechanism.set_input(input);
        mechanism.set_output_load(load);
        let mut model = BearingJoints {
            mechanism,
            bearings,
            has_errors: !settings.errors.is_zero(),
            rated: machine.rated.torque.abs(),
            layout,
            kinematics,
        };
        model.set_part_wear(settings.part_wear);
        Ok(model)
    }
}

/// Angle of a crankshaft on the carrier in rad.
fn crank_place(machine: &Machine, k: usize) -> f64 {
    Kinematics::crankshaft_angle(machine.crankshafts.first_angle, k, machine.crankshafts.count)
}

/// Centre of a bore at an angle (rad) of its body, including its error.
fn bore(machine: &Machine, error: Option<&BoreError>, angle: f64) -> Arm {
    let (radius, error) = (machine.gear_stage.centre_distance(), error.copied().unwrap_or_default());
    Arm::new((radius + error.radial) * unit(angle) + error.tangential * quarter_turn(unit(angle)))
}

fn run_out(list: &[RunOut], k: usize) -> RunOut {
    list.get(k).copied().unwrap_or_default()
}

impl Parts<'_> {
    fn errors(&self) -> &ManufacturingErrors {
        &self.settings.errors
    }

    fn losses(&self, coefficient: f64) -> Losses {
        let regularisation_speed = self.machine.friction.regularisation_speed;
        Losses { time: self.loss_time, sliding: Sliding { coefficient, regularisation_speed } }
    }

    /// All joints, in the order in which their forces are summed.
    fn joints(&self) -> (Vec<Box<dyn Joint>>, Bearings) {
        let (machine, layout) = (self.machine, self.layout);
        let (scale, loss_time) = (self.settings.stiffness_scale, self.loss_time);
        let shaft = Shaft::new(machine, scale, layout.tilt().is_some());
        let mut joints: Vec<Box<dyn Joint>> = Vec::new();
        let mut add = |joint: Box<dyn Joint>| {
            joints.push(joint);
            joints.len() - 1
        };
        let mut bearings = Bearings::default();
        for k in 0..layout.cranks {
            bearings.supports.push((0..2).map(|end| add(Box::new(self.crank_support(k, end)))).collect());
            let arms = (0..layout.discs).map(|j| add(Box::new(self.turning_arm(k, j))));
            bearings.turning_arms.push(arms.collect());
            let places = layout.stations(k).iter().chain(layout.shaft_slopes(k).into_iter().flatten());
            let index = [0, 1].map(|axis| places.clone().map(|place| place[axis]).collect());
            let laws = (&shaft.departures[..], &shaft.stiffness[..]);
            add(Box::new(Bending::new(CRANK_BENDING, index, shaft.stations, laws, loss_time)));
            bearings.gears.push(add(Box::new(self.gears(k, shaft.torsion))));
        }
        let ([cx, cy, carrier], [hx, hy, _], sun) = (layout.carrier(), layout.housing(), layout.sun());
        let seat = self.errors().carrier;
        let seat = Arm { radius: seat.amplitude, phase: seat.phase };
        if let (Some(tilt), Some([about_x, about_y, z])) = (&self.settings.tilt, layout.tilt()) {
            bearings.main = add(Box::new(MainPair {
                part: HOUSING,
                rows: tilt.rows.clone().stiffened(scale),
                index: [cx, cy, carrier, hx, hy, about_x, about_y, z],
                seat,
                loss_time,
            }));
            let (on, sense) = if layout.housing_moves() { ([hx, hy], -1.0) } else { ([cx, cy], 1.0) };
            let index = [on[0], on[1], about_x, about_y, z];
            add(Box::new(OutsideForces::new(HOUSING, index, sense, tilt.forces)));
        } else {
            bearings.main = add(Box::new(Support {
                part: HOUSING,
                cause: Some(MAIN_BEARING_CLEARANCE),
                index: [cx, cy, carrier, hx, hy],
                stiffness: machine.bearings.main.radial * scale,
                clearance: 0.5 * machine.bearings.main.clearance,
                seat,
                loss_time,
            }));
        }
        add(Box::new(Support {
            part: GEARS.part,
            cause: None,
            index: [sun, sun + 1, layout.sun_angle(), hx, hy],
            stiffness: machine.bearings.sun.radial * scale,
            clearance: 0.0,
            seat: Arm { radius: 0.0, phase: 0.0 },
            loss_time,
        }));
        if let Some(carrier) = &self.settings.carrier {
            add(Box::new(Frame {
                part: CARRIER,
                index: layout.seats.iter().flatten().flatten().copied().collect(),
                stiffness: carrier.stiffness().iter().map(|k| k * scale).collect(),
                loss_time,
            }));
        }
        if let Some(housing) = &self.settings.housing {
            let n = housing.count();
            let mut stiffness = vec![0.0; n * n];
            housing.stiffness().enumerate().for_each(|(m, k)| stiffness[m * (n + 1)] = k * scale);
            let index = layout.housing_modes().collect();
            add(Box::new(Frame { part: PIN_RING, index, stiffness, loss_time }));
        }
        if let Some(flange) = layout.flange() {
            add(Box::new(Torsion {
                part: CARRIER,
                index: [carrier, flange],
                stiffness: machine.carrier.torsional_stiffness * scale,
                loss_time,
            }));
        }
        if layout.input() != layout.sun_angle() {
            add(Box::new(Torsion {
                part: INPUT_SHAFT,
                index: [layout.input(), layout.sun_angle()],
                stiffness: machine.gear_stage.input_torsional_stiffness * scale,
                loss_time,
            }));
        }
        (joints, bearings)
    }

    /// The pins, disc by disc.
    fn rings(&self, elastic: Option<ElasticDiscs>) -> Vec<PinRing> {
        let (machine, layout) = (self.machine, self.layout);
        let elastic = elastic.map(Arc::new);
        let housing = self.settings.housing.clone().map(Arc::new);
        let ring = |disc: usize| {
            let (at, [x, y, angle]) = (layout.disc(disc), layout.housing());
            let modification = &machine.disc.modification;
            PinRing {
                contacts: pins(machine, self.settings, disc),
                disc,
                place: [at, at + 1, at + 2, x, y, angle],
                moves: layout.housing_moves(),
                elastic: elastic.clone().map(|body| Modes { body, at: layout.modes(disc) }),
                housing: housing.clone().map(|body| Modes { body, at: layout.housing_modes() }),
                slopes: layout.disc_slopes(disc),
                designed: Designed {
                    relief: machine.designed_relief(),
                    equidistant: modification.equidistant_offset,
                    radial: modification.radial_offset,
                },
            }
        };
        (0..layout.discs).map(ring).collect()
    }

    fn crank_support(&self, k: usize, end: usize) -> Journal {
        let (layout, errors) = (self.layout, self.errors());
        let (at, [cx, cy, carrier]) = (layout.support(k, end), layout.carrier());
        let mut law =
            RollingBearing::radial(&self.machine.bearings.crank_support, self.settings.stiffness_scale);
        law.widen(errors.carrier_bores.get(k).map_or(0.0, |bore| bore.diameter));
        let RunOut { amplitude, phase } = run_out(&errors.journals, k);
        Journal {
            label: CRANK_SUPPORT,
            law,
            index: [at, at + 1, layout.crank_angle(k), cx, cy, carrier],
            arm: Arm { radius: amplitude, phase },
            bore: layout.carrier_bores[k],
            modes: self.seat_modes(k, end),
            has_rim: !layout.seats.is_empty(),
            slopes: self.slopes(k, end, |layout| {
                let [about_x, about_y, _] = layout.tilt()?;
                Some([(about_y, Vec2::new(1.0, 0.0)), (about_x, Vec2::new(0.0, -1.0))])
            }),
            worn: 0.0,
            losses: self.losses(self.machine.friction.bearing),
        }
    }

    /// Coordinates of the tilt of a shaft at one of its stations relative to a body, with the slope of the body
    /// per unit of its own coordinates.
    fn slopes(
        &self,
        k: usize,
        station: usize,
        of_body: impl Fn(&Layout) -> Option<[(usize, Vec2); 2]>,
    ) -> Option<[(usize, Vec2); SLOPES]> {
        let [x, y] = self.layout.shaft_slopes(k)?[station];
        let [a, b] = of_body(self.layout)?;
        Some([(x, Vec2::new(1.0, 0.0)), (y, Vec2::new(0.0, 1.0)), (a.0, -a.1), (b.0, -b.1)])
    }

    /// Displacements of a crank seat on the carrier: its own coordinates, and the tilt of a carrier whose main
    /// bearings are in the middle between the supports.
    fn seat_modes(&self, k: usize, end: usize) -> Vec<BoreMode> {
        let mut modes = Vec::new();
        if let Some([about_x, about_y, _]) = self.layout.tilt() {
            let height = (end as f64 - 0.5) * self.machine.bearings.crank_support_span;
            let shifts = [(about_x, Vec2::new(0.0, -height)), (about_y, Vec2::new(height, 0.0))];
            modes.extend(shifts.map(|(at, by)| BoreMode {
                at,
                by,
                rim: [0.0; RIM_COORDINATES],
                turns: false,
            }));
        }
        if let Some(ends) = self.layout.seats.get(k) {
            modes.extend(ends[end].iter().enumerate().map(|(axis, at)| BoreMode::of_seat(axis, *at)));
        }
        modes
    }

    fn turning_arm(&self, k: usize, j: usize) -> Journal {
        let (layout, errors) = (self.layout, self.errors());
        let (at, disc) = (layout.disc_station(k, j), layout.disc(j));
        let error = errors.discs.get(j).and_then(|disc| disc.bores.get(k));
        let mut law =
            RollingBearing::radial(&self.machine.bearings.turning_arm, self.settings.stiffness_scale);
        law.widen(error.map_or(0.0, |bore| bore.diameter));
        let EccentricError { eccentricity, phase } =
            errors.eccentrics.get(k).and_then(|list| list.get(j)).copied().unwrap_or_default();
        // The disc's angle is that of its flank; the bores are therefore rotated by minus the mounting angle.
        let mounting = self.kinematics.mounting_angle(j);
        let angle = crank_place(self.machine, k) - mounting;
        let discs = self.settings.discs.as_ref();
        let modes = discs.map_or_else(Vec::new, |discs| {
            layout.modes(j).enumerate().map(|(m, at)| BoreMode::of_body(at, discs.bore(j, m, k))).collect()
        });
        Journal {
            label: TURNING_ARM,
            law,
            index: [at, at + 1, layout.crank_angle(k), disc, disc + 1, disc + 2],
            arm: Arm {
                radius: self.machine.crankshafts.eccentricity + eccentricity,
                phase: self.kinematics.phases[j] + phase,
            },
            bore: bore(self.machine, error, angle),
            modes,
            has_rim: discs.is_some_and(ElasticDiscs::have_rims),
            slopes: self.slopes(k, 2 + j, |layout| {
                let [x, y] = layout.disc_slopes(j)?;
                Some([(x, Vec2::new(1.0, 0.0)), (y, Vec2::new(0.0, 1.0))])
            }),
            worn: 0.0,
            losses: self.losses(self.machine.friction.bearing),
        }
    }

    fn gears(&self, k: usize, torsion: f64) -> Gears {
        let (layout, errors, stage) = (self.layout, self.errors(), &self.machine.gear_stage);
        let mut law = GearMesh::new(self.machine, k, torsion);
        if !self.settings.damped {
            law.damping = 0.0;
        }
        let planet = run_out(&errors.planets, k);
        law.planet_run_out = (planet.amplitude, planet.phase);
        law.sun_run_out = (errors.sun.amplitude, errors.sun.phase);
        let (sun, planet) = (layout.sun(), layout.support(k, 0));
        let index: [usize; MESH_COORDINATES] = [
            sun,
            sun + 1,
            layout.sun_angle(),
            planet,
            planet + 1,
            layout.crank_angle(k),
            layout.carrier()[2],
        ];
        Gears {
            label: GEARS,
            law,
            index,
            losses: self.losses(self.machine.friction.gear_mesh),
            // Mean distance of the contact from the pitch point: a quarter of a path of contact of 1.6 base
            // pitches.
            sliding: 0.4 * std::f64::consts::PI * stage.module * stage.pressure_angle.cos(),
        }
    }
}

/// The pins and disc j, with the errors of ring and disc.
fn pins(machine: &Machine, settings: &JointSettings, disc: usize) -> PinContacts {
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
    let seat =
        machine.ring.seat_compliance + settings.housing.as_ref().map_or(0.0, ElasticHousing::seat_compliance);
    let contact = machine.line_contact().with_seat_compliance(seat / settings.stiffness_scale);
    let mut ring = PinContacts::new(
        machine.profile(),
        pins,
        machine.designed_relief().plus(&settings.flank_wear[disc % settings.flank_wear.len()]),
        contact,
    );
    let pins = ring.pins().len();
    match settings.pin_wear.chunks_exact(pins).nth(disc) {
        Some(own) => ring.set_pin_reliefs(own.to_vec()),
        None => ring.set_pin_relief(settings.pin_wear[0].clone()),
    }
    if let Some(error) = errors.discs.get(disc) {
        ring.set_flank_error(error.flank.clone());
    }
    ring.set_damping(settings.damped.then_some(machine.contact_damping));
    ring.set_conservative(true);
    let friction = &machine.friction;
    let coefficient = machine.flank_friction();
    ring.set_sliding(Some(Sliding { coefficient, regularisation_speed: friction.regularisation_speed }));
    if let Some(discs) = &settings.discs {
        discs.prepare_ring_of(&mut ring, disc, machine);
    }
    ring
}

/// Checks of values that do not come from the design, whose own rules are already fulfilled.
fn validate(machine: &Machine, settings: &JointSettings, drag: f64) -> Result<(), DynamicsError> {
    let check = DynamicsError::require;
    if let Some(discs) = &settings.discs {
        discs.require(&vec![machine.crankshafts.count; machine.disc_count])?;
    }
    if let Some(carrier) = &settings.carrier {
        check(
            carrier.crank_count() == machine.crankshafts.count,
            "number of crankshafts of the elastic carrier",
            carrier.crank_count() as f64,
            "",
            "must be that of the machine",
        )?;
    }
    if let Some(housing) = &settings.housing {
        check(
            settings.discs.is_some() && housing.ring() == (machine.disc_count, machine.ring.pin_count),
            "pins of the elastic housing",
            housing.ring().1 as f64,
            "",
            "must be those of the machine, on elastic discs",
        )?;
    }
    check(drag >= 0.0 && drag.is_finite(), "drag torque", drag, "N·m", "must not be negative")?;
    let scale = settings.stiffness_scale;
    check(scale > 0.0 && scale.is_finite(), "stiffness scale", scale, "", "must be positive")
}
