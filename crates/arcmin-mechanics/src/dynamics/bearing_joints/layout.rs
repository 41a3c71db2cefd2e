use crate::dynamics::mechanism::{
    Arm, Axis, Body, BodyId, Coordinates, Flanges, NominalMotion, Registry, Turn, range_of,
};
use crate::fem::carrier::SEAT_COORDINATES;
use crate::machine::{FixedMember, Kinematics, Machine};
use crate::units::ARCMIN;

/// The bodies of a reducer with the numbers of their coordinates.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    pub cranks: usize,
    pub discs: usize,
    at_rest: FixedMember,
    coordinates: Coordinates,
    /// For each crankshaft: (x, y) of the shaft at both supports and at every disc.
    stations: Vec<Vec<[usize; 2]>>,
    crank_angles: Vec<usize>,
    /// For each disc: (x, y, θ) and its modes, consecutively.
    disc_axes: Vec<Vec<usize>>,
    sun: [usize; 2],
    /// (x, y, θ) of the carrier at the crankshafts.
    carrier: [usize; 3],
    /// Angle of the carrier's flange, which differs from that of the carrier if this is torsionally elastic.
    flange: usize,
    housing: [usize; 3],
    /// Angle of the sun.
    sun_angle: usize,
    /// Angle of the input, which is that of the sun if the input shaft is rigid.
    input: usize,
    /// Bores of the carrier.
    pub carrier_bores: Vec<Arm>,
    /// For each crankshaft and end: coordinates of an elastic carrier's seat, in the carrier's frame.
    pub seats: Vec<[Vec<usize>; 2]>,
    housing_modes: Vec<usize>,
    /// Coordinates of tilt, if the model has any.
    tilt: Option<TiltCoordinates>,
}

/// Coordinates of bodies that tilt relative to the housing.
#[derive(Debug, Clone, PartialEq)]
struct TiltCoordinates {
    /// (φ_x, φ_y, z) of the carrier.
    carrier: [usize; 3],
    /// For each crankshaft: slopes (∂x/∂z, ∂y/∂z) at both supports and at every disc.
    shafts: Vec<Vec<[usize; 2]>>,
    /// Slopes of every disc.
    discs: Vec<[usize; 2]>,
}

/// Degrees of freedom of bodies relative to their neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Degrees {
    /// Rotation of the carrier's flange relative to the carrier.
    pub flange: bool,
    /// Rotation of the sun relative to the input.
    pub input_shaft: bool,
    /// Whether the input is driven by a torque instead of being prescribed.
    pub free_input: bool,
    /// Displacements of the crank seats relative to the carrier.
    pub seats: bool,
    /// Modes of the housing.
    pub housing_modes: usize,
    /// Tilt of carrier, crankshafts and discs relative to the housing.
    pub tilt: bool,
}

impl Layout {
    /// Registers all bodies. `modes` contains the number of modes of every disc, `mode_scale` their unit of
    /// error; the other units are one arc minute at the output, for displacements at the radius of the
    /// crankshafts, and for angles.
    pub fn new(
        machine: &Machine,
        kinematics: &Kinematics,
        (modes, mode_scale): (Vec<usize>, f64),
        degrees: Degrees,
        carrier_bores: Vec<Arm>,
    ) -> Layout {
        let (at_rest, discs) = (machine.fixed_member, modes.len());
        let cranks = &machine.crankshafts;
        let place_scale = machine.gear_stage.centre_distance() * ARCMIN;
        let axis = |mass: f64, scale: f64, free: bool| Axis { mass, scale, free };
        let place = |mass: f64, free: bool| [axis(mass, place_scale, free); 2];
        let mut registry = Registry::default();
        let nominal = Nominal::new(at_rest, kinematics);
        // Shaft stations come first, which keeps the fill of the elimination small.
        let count = discs + 2;
        // Slopes rotate in the plane as displacements do.
        let slopes = |across: f64| Body {
            axes: vec![axis(across, ARCMIN, true); 2],
            has_place: true,
            nominal: NominalMotion::default(),
        };
        let slices = if degrees.tilt { count } else { 0 };
        let shafts: Vec<(Vec<BodyId>, Vec<BodyId>, BodyId)> = carrier_bores
            .iter()
            .map(|bore| {
                let mass = cranks.mass / count as f64;
                let station = Body {
                    axes: place(mass, true).to_vec(),
                    has_place: true,
                    nominal: NominalMotion::carried(*bore, nominal.carrier),
                };
                let stations = (0..count).map(|_| registry.add(station.clone())).collect();
                // About a diameter, with a length equal to the diameter: an assumption, relevant for vibrations
                // only.
                let across = mass * (3.0 / 16.0 + 1.0 / 12.0) * cranks.shaft_diameter.powi(2);
                let slopes = (0..slices).map(|_| registry.add(slopes(across))).collect();
                let turn = axis(cranks.inertia, kinematics.lobe_count * ARCMIN, true);
                (stations, slopes, registry.add_turn(turn, NominalMotion::turning(nominal.crank)))
            })
            .collect();
        let disc_bodies: Vec<BodyId> = modes
            .iter()
            .enumerate()
            .map(|(j, count)| {
                let mut axes = place(machine.disc.mass, true).to_vec();
                axes.push(axis(machine.disc.inertia, ARCMIN, true));
                axes.extend(vec![axis(1.0, mode_scale, true); *count]);
                registry.add(Body { axes, has_place: true, nominal: nominal.disc(kinematics, j) })
            })
            .collect();
        // Half of the moment of inertia about the axis, as for a thin body about a diameter.
        let disc_slopes: Vec<BodyId> = (0..if degrees.tilt { discs } else { 0 })
            .map(|_| registry.add(slopes(0.5 * machine.disc.inertia)))
            .collect();
        // Masses that vibrate with a seat or a pin: a quarter of the carrier's mass distributed over its seats,
        // a fifth of that for the ovalisation, half of the housing's mass for the pins. Assumptions.
        let seat_mass = 0.25 * machine.carrier.mass / (2 * cranks.count) as f64;
        let row = |mass: f64, scale: f64, count: usize| Body {
            axes: vec![axis(mass, scale, true); count],
            has_place: false,
            nominal: NominalMotion::default(),
        };
        let seat_bodies: Vec<[BodyId; 2]> = (0..if degrees.seats { cranks.count } else { 0 })
            .map(|_| {
                [0, 1].map(|_| {
                    let mut seat = row(0.2 * seat_mass, place_scale, SEAT_COORDINATES);
                    seat.axes[..2].copy_from_slice(&place(seat_mass, true));
                    registry.add(seat)
                })
            })
            .collect();
        // Modes of unit length over all pins of all discs.
        let places = (discs * machine.ring.pin_count) as f64;
        let ring_body = (degrees.housing_modes > 0).then(|| {
            let (mass, scale) = (0.5 * machine.housing.mass / places, place_scale * places.sqrt());
            registry.add(row(mass, scale, degrees.housing_modes))
        });
        let tilt_body = degrees.tilt.then(|| {
            let mut body = slopes(0.5 * machine.carrier.inertia);
            body.axes.push(axis(machine.carrier.mass, place_scale, true));
            registry.add(body)
        });
        let sun = registry.add(Body {
            axes: place(sun_mass(machine), true).to_vec(),
            has_place: true,
            nominal: NominalMotion::default(),
        });
        let carrier_moves = at_rest == FixedMember::Housing;
        let add_carrier = |registry: &mut Registry| {
            // Half of an elastic carrier's inertia is assigned to its flange.
            let halves = if degrees.flange { 0.5 } else { 1.0 };
            let turn = axis(halves * machine.carrier.inertia, ARCMIN, carrier_moves);
            let turning = NominalMotion::turning(nominal.carrier);
            let mut axes = place(machine.carrier.mass, carrier_moves).to_vec();
            axes.push(Axis { free: carrier_moves || degrees.flange, ..turn });
            let carrier = registry.add(Body { axes, has_place: true, nominal: turning });
            (carrier, degrees.flange.then(|| registry.add_turn(turn, turning)))
        };
        let add_housing = |registry: &mut Registry| {
            let mut axes = place(machine.housing.mass, !carrier_moves).to_vec();
            axes.push(axis(machine.housing.inertia, ARCMIN, !carrier_moves));
            registry.add(Body { axes, has_place: true, nominal: NominalMotion::turning(nominal.housing) })
        };
        let ((carrier, flange), housing) = if carrier_moves {
            let carrier = add_carrier(&mut registry);
            (carrier, add_housing(&mut registry))
        } else {
            let housing = add_housing(&mut registry);
            (add_carrier(&mut registry), housing)
        };
        let stage = &machine.gear_stage;
        let turn = |mass: f64, free: bool| axis(mass, kinematics.housing_fixed_ratio().abs() * ARCMIN, free);
        let sun_turn = NominalMotion::turning(1.0);
        let (sun_angle, input) = if degrees.input_shaft {
            let sun = registry.add_turn(turn(stage.sun_inertia, true), sun_turn);
            (sun, registry.add_turn(turn(stage.motor_inertia, degrees.free_input), sun_turn))
        } else {
            let input = registry.add_turn(turn(stage.motor_inertia, degrees.free_input), sun_turn);
            registry.add_mass(input, 0, stage.sun_inertia);
            (input, input)
        };
        let coordinates = registry.number();
        let two = |body: BodyId| [coordinates.of(body)[0], coordinates.of(body)[1]];
        let three =
            |body: BodyId| [coordinates.of(body)[0], coordinates.of(body)[1], coordinates.of(body)[2]];
        let one = |body: BodyId| coordinates.of(body)[0];
        let carrier = three(carrier);
        Layout {
            cranks: shafts.len(),
            discs,
            at_rest,
            stations: shafts.iter().map(|(list, ..)| list.iter().map(|body| two(*body)).collect()).collect(),
            crank_angles: shafts.iter().map(|(.., turn)| one(*turn)).collect(),
            disc_axes: disc_bodies.iter().map(|body| coordinates.of(*body).to_vec()).collect(),
            sun: two(sun),
            flange: flange.map_or(carrier[2], one),
            carrier,
            housing: three(housing),
            sun_angle: one(sun_angle),
            input: one(input),
            carrier_bores,
            seats: seat_bodies.iter().map(|ends| ends.map(|end| coordinates.of(end).to_vec())).collect(),
            tilt: tilt_body.map(|carrier| TiltCoordinates {
                carrier: three(carrier),
                shafts: shafts
                    .iter()
                    .map(|(_, list, _)| list.iter().map(|body| two(*body)).collect())
                    .collect(),
                discs: disc_slopes.iter().map(|body| two(*body)).collect(),
            }),
            housing_modes: ring_body.map_or_else(Vec::new, |body| coordinates.of(body).to_vec()),
            coordinates,
        }
    }

    pub fn coordinates(&self) -> &Coordinates {
        &self.coordinates
    }

    /// Number of x of the shaft at a support.
    pub fn support(&self, k: usize, end: usize) -> usize {
        self.stations[k][end][0]
    }

    /// Numbers of (x, y) of all stations of a shaft: both supports, then the discs.
    pub fn stations(&self, k: usize) -> &[[usize; 2]] {
        &self.stations[k]
    }

    /// Number of x of the shaft at disc j.
    pub fn disc_station(&self, k: usize, j: usize) -> usize {
        self.stations[k][2 + j][0]
    }

    pub fn crank_angle(&self, k: usize) -> usize {
        self.crank_angles[k]
    }

    /// Number of x of disc j.
    pub fn disc(&self, j: usize) -> usize {
        self.disc_axes[j][0]
    }

    /// Numbers of the modes of disc j.
    pub fn modes(&self, j: usize) -> std::ops::Range<usize> {
        range_of(&self.disc_axes[j][3..])
    }

    /// Numbers of the modes of an elastic housing.
    pub fn housing_modes(&self) -> std::ops::Range<usize> {
        range_of(&self.housing_modes)
    }

    /// Numbers of (φ_x, φ_y, z) of a carrier that tilts relative to the housing.
    pub fn tilt(&self) -> Option<[usize; 3]> {
        self.tilt.as_ref().map(|tilt| tilt.carrier)
    }

    /// Numbers of the slopes (x, y) of a tilting shaft at its stations.
    pub fn shaft_slopes(&self, k: usize) -> Option<&[[usize; 2]]> {
        self.tilt.as_ref().map(|tilt| tilt.shafts[k].as_slice())
    }

    /// Numbers of the slopes (x, y) of a tilting disc.
    pub fn disc_slopes(&self, j: usize) -> Option<[usize; 2]> {
        self.tilt.as_ref().map(|tilt| tilt.discs[j])
    }

    /// Number of x of the sun.
    pub fn sun(&self) -> usize {
        self.sun[0]
    }

    pub fn carrier(&self) -> [usize; 3] {
        self.carrier
    }

    pub fn housing(&self) -> [usize; 3] {
        self.housing
    }

    pub fn housing_moves(&self) -> bool {
        self.at_rest == FixedMember::Carrier
    }

    /// Number of the angle of the carrier's flange, if it differs from that of the carrier.
    pub fn flange(&self) -> Option<usize> {
        (self.flange != self.carrier[2]).then_some(self.flange)
    }

    /// Number of the angle of the output.
    pub fn output(&self) -> usize {
        match self.at_rest {
            FixedMember::Housing => self.flange,
            FixedMember::Carrier => self.housing[2],
        }
    }

    pub fn sun_angle(&self) -> usize {
        self.sun_angle
    }

    pub fn input(&self) -> usize {
        self.input
    }

    /// Number of free coordinates.
    pub fn size(&self) -> usize {
        self.coordinates.size
    }

    /// The special coordinates of a mechanism.
    pub fn flanges(&self, kinematics: &Kinematics) -> Flanges {
        let (input, output, phase) = (self.input, self.output(), self.crank_angles[0]);
        Flanges { input, output, phase, ratio: kinematics.ratio() }
    }
}

/// Rotations of the bodies of a reducer without clearance and load, per rotation of the sun.
struct Nominal {
    carrier: f64,
    housing: f64,
    crank: f64,
}

impl Nominal {
    fn new(at_rest: FixedMember, kinematics: &Kinematics) -> Nominal {
        let output = 1.0 / kinematics.ratio();
        let (carrier, housing) = match at_rest {
            FixedMember::Housing => (output, 0.0),
            FixedMember::Carrier => (0.0, output),
        };
        Nominal { carrier, housing, crank: housing - kinematics.lobe_count * (carrier - housing) }
    }

    /// Motion of a disc: translation by the cranks, rotation with the carrier.
    fn disc(&self, kinematics: &Kinematics, disc: usize) -> NominalMotion {
        let arm = Arm { radius: kinematics.eccentricity, phase: kinematics.phases[disc] };
        let turn = Turn { per_input: self.carrier, offset: kinematics.mounting_angle(disc) };
        NominalMotion { place: Some((arm, Turn::of(self.crank))), turn: Some(turn) }
    }
}

/// Mass in kg of the sun as a steel cylinder of twice its face width: an assumption, relevant for vibrations
/// only.
fn sun_mass(machine: &Machine) -> f64 {
    let stage = &machine.gear_stage;
    let radius = stage.sun_pitch_radius();
    let mass = machine.crankshafts.material.density
        * std::f64::consts::PI
        * radius
        * radius
        * 2.0
        * stage.face_width;
    mass.max(1e-3)
}
