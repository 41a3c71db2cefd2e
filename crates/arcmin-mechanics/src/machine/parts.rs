use crate::geometry::{Profile, Relief, Sector};
use crate::materials::Material;
use crate::tribology::{Lubrication, WearLaw};

/// The ring of pins in the housing.
#[derive(Debug, Clone, PartialEq)]
pub struct PinRing {
    /// z_p, one more than the lobes of a disc.
    pub pin_count: usize,
    /// R_p in m.
    pub pin_circle_radius: f64,
    /// Installed pin radius r_p in m.
    pub pin_radius: f64,
    /// Material of the pins.
    pub material: Material,
    /// Way in which pins are held, which decides where they slide and wear.
    pub mounting: PinMounting,
    /// Radial compliance of a pin in its seat in m/N; 0 for a rigid seat. Used with bearing joints only, not
    /// with ideal joints.
    pub seat_compliance: f64,
}

/// Ways of holding the pins of a ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PinMounting {
    /// Pins do not turn: they slide on the flank and wear along their own circumference.
    #[default]
    Fixed,
    /// Pins turn freely in their seats.
    Spinning,
    /// Arcs that are one piece with the ring, in place of pins: they slide and wear as fixed pins.
    OnePiece,
}

/// Words for the counterpart of the flanks in the ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RingPartner {
    /// Separate pins or rollers.
    Pins,
    /// Arcs of rings of one piece.
    Teeth,
    /// Rings of both kinds.
    Both,
}

impl RingPartner {
    /// The words for rings in which pins are held in these ways.
    pub fn of(mountings: impl IntoIterator<Item = PinMounting>) -> RingPartner {
        let of_one = |mounting| match mounting {
            PinMounting::OnePiece => RingPartner::Teeth,
            PinMounting::Fixed | PinMounting::Spinning => RingPartner::Pins,
        };
        let all = mountings.into_iter().map(of_one);
        all.reduce(|all, one| if all == one { all } else { RingPartner::Both }).unwrap_or(RingPartner::Pins)
    }

    fn word(self, words: [&'static str; 3]) -> &'static str {
        words[self as usize]
    }

    /// The singular, with the name of the ring.
    pub fn of_ring(self) -> &'static str {
        self.word(["ring pin", "ring tooth", "ring pin or tooth"])
    }

    /// The plural, with the name of the ring.
    pub fn all_of_ring(self) -> &'static str {
        self.word(["ring pins", "ring teeth", "ring pins and teeth"])
    }

    /// The singular without the ring, where this is clear from the context.
    pub fn one(self) -> &'static str {
        self.word(["pin", "ring tooth", "pin or ring tooth"])
    }

    /// The plural without the ring.
    pub fn several(self) -> &'static str {
        self.word(["pins", "ring teeth", "pins and ring teeth"])
    }
}

/// One of the identical discs.
#[derive(Debug, Clone, PartialEq)]
pub struct CycloidDisc {
    /// Face width B in m.
    pub width: f64,
    /// Material of the disc and its flank.
    pub material: Material,
    /// Metal ground off the theoretical flank.
    pub modification: FlankModification,
    /// Bores for the turning-arm bearings, one per crankshaft, on the circle of the crankshafts: radius in m.
    pub crank_bore_radius: f64,
    /// Centre hole radius in m; 0 without one.
    pub centre_hole_radius: f64,
    /// Further holes (windows for carrier pillars, lightening).
    pub holes: Vec<Bore>,
    /// Windows for the carrier's pillars, annular sectors.
    pub windows: Vec<Sector>,
    /// Mass in kg, from the solid or given.
    pub mass: f64,
    /// Moment of inertia about the centre in kg·m², from the solid or given.
    pub inertia: f64,
}

/// A round hole: centre in polar coordinates of the disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bore {
    /// m.
    pub radius: f64,
    /// m.
    pub centre_radius: f64,
    /// rad.
    pub centre_angle: f64,
}

/// Metal ground off the theoretical flank on purpose. Both a positive equidistant and a negative radial
/// offset open the gap.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FlankModification {
    /// Δr_p in m: cut with a larger pin.
    pub equidistant_offset: f64,
    /// ΔR_p in m: cut on another circle.
    pub radial_offset: f64,
    /// Each flank turned into the metal by this angle in rad: depth = angle × lever arm.
    pub rotation: f64,
    /// Depth along the normal over the meshing angle, m; `None` for no free form.
    pub free_form: Option<Relief>,
}

impl FlankModification {
    /// Relief ground on purpose beyond the two offsets: rotation and free form.
    pub(crate) fn relief(&self, profile: &Profile) -> Relief {
        if self.rotation == 0.0 && self.free_form.is_none() {
            return Relief::uniform(0.0);
        }
        let turned = Relief::grid(720).map(|phi| self.rotation * profile.lever_arm(phi).abs()).collect();
        let turned = Relief::from_samples(turned);
        self.free_form.as_ref().map_or(turned.clone(), |free| turned.plus(free))
    }
}

/// The crankshafts, each with its planet gear.
#[derive(Debug, Clone, PartialEq)]
pub struct Crankshafts {
    /// Crankshafts of the machine, equally spaced.
    pub count: usize,
    /// Eccentricity a in m.
    pub eccentricity: f64,
    /// Angle γ_0 of the first crankshaft on the carrier in rad; the others follow equally spaced.
    pub first_angle: f64,
    /// Mass of one crankshaft with planet in kg.
    pub mass: f64,
    /// Moment of inertia of one crankshaft with planet about its axis in kg·m².
    pub inertia: f64,
    /// Shaft diameter between the supports in m (bending and torsion).
    pub shaft_diameter: f64,
    /// Material of shaft and eccentrics.
    pub material: Material,
}

/// Sun and planets.
#[derive(Debug, Clone, PartialEq)]
pub struct GearStage {
    /// z_1.
    pub sun_teeth: usize,
    /// z_2.
    pub planet_teeth: usize,
    /// Module in m.
    pub module: f64,
    /// Transverse pressure angle in rad.
    pub pressure_angle: f64,
    /// Mean mesh stiffness per planet in N/m along the line of action.
    pub mesh_stiffness: f64,
    /// Relative amplitude of the stiffness variation over the mesh cycle (first harmonic), 0 for constant.
    pub mesh_stiffness_variation: f64,
    /// Mesh damping per planet in N·s/m.
    pub mesh_damping: f64,
    /// Backlash along the line of action in m.
    pub backlash: f64,
    /// Moment of inertia of sun and input shaft in kg·m².
    pub sun_inertia: f64,
    /// Moment of inertia of the motor at the input in kg·m².
    pub motor_inertia: f64,
    /// Torsional stiffness between input and sun in N·m/rad; infinite where not given. Used with bearing joints
    /// only, not with ideal joints.
    pub input_torsional_stiffness: f64,
    /// Face width in m (wear of the gear flanks).
    pub face_width: f64,
}

impl GearStage {
    /// m z_1/2 in m.
    pub fn sun_pitch_radius(&self) -> f64 {
        0.5 * self.module * self.sun_teeth as f64
    }

    /// m z_2/2 in m.
    pub fn planet_pitch_radius(&self) -> f64 {
        0.5 * self.module * self.planet_teeth as f64
    }

    /// Radius R_c of the crankshaft circle: the centre distance of the gear stage, in m.
    pub fn centre_distance(&self) -> f64 {
        self.sun_pitch_radius() + self.planet_pitch_radius()
    }

    /// m z_1 cos α/2 in m.
    pub fn sun_base_radius(&self) -> f64 {
        self.sun_pitch_radius() * self.pressure_angle.cos()
    }

    /// m z_2 cos α/2 in m.
    pub fn planet_base_radius(&self) -> f64 {
        self.planet_pitch_radius() * self.pressure_angle.cos()
    }
}

/// Carrier: rigid disc and output shaft in one.
#[derive(Debug, Clone, PartialEq)]
pub struct Carrier {
    /// kg.
    pub mass: f64,
    /// kg·m², about the machine's axis, without the crankshafts.
    pub inertia: f64,
    /// Material of plates and pillars.
    pub material: Material,
    /// Torsional stiffness between crank supports and output flange in N·m/rad; infinite where not given.
    pub torsional_stiffness: f64,
}

/// Housing with the ring of pins. It moves where the carrier is at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Housing {
    /// kg, pins included.
    pub mass: f64,
    /// kg·m², about the machine's axis.
    pub inertia: f64,
}

/// Members that can be fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FixedMember {
    /// Housing fixed, carrier is the output.
    #[default]
    Housing,
    /// Carrier fixed, housing is the output.
    Carrier,
}

/// Friction coefficients and losses; all zero for the frictionless machine.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Friction {
    /// Coulomb coefficient between flank and pin.
    pub flank: f64,
    /// Coulomb coefficient between pin and seat.
    pub pin_seat: f64,
    /// Rolling friction coefficient of the bearings, on the mean bearing radius.
    pub bearing: f64,
    /// Coulomb coefficient of the gear meshes.
    pub gear_mesh: f64,
    /// Constant drag torque of seals at the output in N·m.
    pub seal_drag: f64,
    /// Viscous drag at the input in N·m·s/rad.
    pub oil_drag: f64,
    /// Sliding speed over which Coulomb friction is regularised in m/s.
    pub regularisation_speed: f64,
    /// Factor on Palmgren's published drag of lubricant and preload in the bearings.
    pub bearing_drag: f64,
    /// Axial force in N that presses each crank support together.
    pub crank_support_preload: f64,
}

impl Friction {
    /// Whether bearings have drag without load.
    pub fn bearings_drag(&self) -> bool {
        self.bearing_drag > 0.0 || self.crank_support_preload > 0.0
    }
}

/// Forces and moments on the output in addition to the torque, referred to the middle of the main bearings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OutputForces {
    /// N·m, tilting.
    pub moment: f64,
    /// N, along the axis out of the machine.
    pub axial: f64,
    /// N, across it, in the plane of the moment.
    pub radial: f64,
}

impl OutputForces {
    /// Whether the torque is the only load.
    pub fn is_zero(&self) -> bool {
        *self == OutputForces::default()
    }
}

/// An operating point with its share of the running time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DutyPoint {
    /// Output torque in N·m, positive against positive (counter-clockwise) output motion.
    pub torque: f64,
    /// Input speed in rad/s, signed.
    pub input_speed: f64,
    /// Share of the running time, the shares of a spectrum sum to 1.
    pub share: f64,
    /// Forces and moments on the output meanwhile.
    pub forces: OutputForces,
}

impl DutyPoint {
    /// Whether parts wear at this point: wear needs torque and speed.
    pub fn wears(&self) -> bool {
        self.torque != 0.0 && self.input_speed != 0.0 && self.share > 0.0
    }

    /// Whether a row of a duty has forces or moments in addition to the torque.
    pub fn any_tilts(duty: &[DutyPoint]) -> bool {
        duty.iter().any(|row| !row.forces.is_zero())
    }

    /// Largest size of a torque of a duty in N·m.
    pub fn largest_torque(duty: &[DutyPoint]) -> f64 {
        duty.iter().map(|row| row.torque.abs()).fold(0.0, f64::max)
    }

    /// The torque of largest magnitude of rating and duty in N·m, with its sign; that of the rating where
    /// several are equal.
    pub fn largest_signed_torque(rated: f64, duty: &[DutyPoint]) -> f64 {
        let harder = |most: f64, torque: f64| if torque.abs() > most.abs() { torque } else { most };
        duty.iter().map(|row| row.torque).fold(rated, harder)
    }
}

/// Wear of flanks, pins, bearings and gears.
#[derive(Debug, Clone, PartialEq)]
pub struct Wear {
    /// Local rate of flanks and pins per unit of the coefficient k.
    pub law: WearLaw,
    /// Coefficient of the coupled prediction.
    pub coupled: WearCoefficient,
    /// Coefficient of the paper's uniform-depth study.
    pub paper: WearCoefficient,
    /// Faster wear at the beginning; `None` for a constant coefficient.
    pub running_in: Option<RunningIn>,
    /// Pin wear coefficient relative to that of the disc.
    pub pin_ratio: f64,
    /// Film between flank and pin that reduces wear; `None` for boundary lubrication throughout.
    pub lubrication: Option<Lubrication>,
    /// Bearings and gears.
    pub parts: super::PartWearLaws,
}

/// Form in which the wear coefficient k is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WearCoefficient {
    /// k in 1/Pa.
    Given(f64),
    /// k such that the deepest point has a wear depth of `depth` (m) after `time` (s) at the machine's duty.
    Calibrated {
        /// s.
        time: f64,
        /// m.
        depth: f64,
    },
    /// k such that the lost motion has grown by `increase` (rad) after `time` (s).
    CalibratedLostMotion {
        /// s.
        time: f64,
        /// rad.
        increase: f64,
    },
}

/// k(t) = k (1 + (factor − 1) e^(−t/duration)): faster wear during running-in.
///
/// The exponential is an assumption, the simplest transition with two parameters. Neither factor nor time is
/// known for all machines, so that a design without these keys has no running-in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunningIn {
    /// Ratio of the initial to the steady coefficient.
    pub factor: f64,
    /// s.
    pub duration: f64,
}
