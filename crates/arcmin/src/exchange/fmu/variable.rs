//! The variables of a unit.

use super::{Depth, LoadFlange};
use crate::units::ARCMIN;

/// Type of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A floating-point number.
    Real,
    /// A whole number.
    Integer,
    /// True or false.
    Boolean,
}

/// Causality of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Set by the importer at any time.
    Input,
    /// Computed by the unit.
    Output,
    /// Set before the start.
    Parameter,
}

/// A variable; its value reference is its number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variable {
    /// Number by which FMI reads and sets it.
    pub reference: u32,
    /// Name in the model description.
    pub name: &'static str,
    /// Type of its values.
    pub kind: Kind,
    /// Whether it is set or computed.
    pub role: Role,
    /// Unit of its values in FMI's notation; empty without one.
    pub unit: &'static str,
    /// Unit to show it in; empty for the same.
    pub display_unit: &'static str,
    /// Meaning in one sentence.
    pub description: &'static str,
}

/// Value references.
pub mod references {
    /// Time, s: the independent variable.
    pub const TIME: u32 = 0;
    /// Angle of the motor flange, rad.
    pub const A_PHI: u32 = 1;
    /// Speed of the motor flange, rad/s.
    pub const A_W: u32 = 2;
    /// Acceleration of the motor flange, rad/s².
    pub const A_A: u32 = 3;
    /// Torque at the motor flange, N·m.
    pub const A_TAU: u32 = 4;
    /// Torque on the load flange, N·m.
    pub const B_TAU: u32 = 5;
    /// Angle of the load flange, rad.
    pub const B_PHI: u32 = 6;
    /// Speed of the load flange, rad/s.
    pub const B_W: u32 = 7;
    /// Acceleration of the load flange, rad/s².
    pub const B_A: u32 = 8;
    /// Transmission error, rad.
    pub const TRANSMISSION_ERROR: u32 = 9;
    /// Wind-up of the output, rad.
    pub const WIND_UP: u32 = 10;
    /// Largest force of a pin, N.
    pub const PIN_FORCE: u32 = 11;
    /// Largest Hertz pressure of a pin, Pa.
    pub const PIN_PRESSURE: u32 = 12;
    /// Lost power, W.
    pub const LOSS: u32 = 13;
    /// Residual of the energy balance, without unit.
    pub const BALANCE: u32 = 14;
    /// Age, h.
    pub const HOURS: u32 = 20;
    /// Seed of the machine.
    pub const SEED: u32 = 21;
    /// Whether there is friction.
    pub const FRICTION: u32 = 22;
    /// Local error of a step, rad.
    pub const LOCAL_ERROR: u32 = 23;
    /// Whether accelerations that are set are used.
    pub const USE_ACCELERATION: u32 = 24;
}

/// Initial value of the local error of a step in rad for a multibody unit, that of `arcmin simulate`, and its
/// limits.
pub const START_LOCAL_ERROR: f64 = 5e-5 * ARCMIN;
pub(super) const LOCAL_ERRORS: [f64; 2] = [1e-9 * ARCMIN, 0.1 * ARCMIN];

/// All variables of a unit except the independent one.
pub fn variables(depth: Depth, load: LoadFlange) -> Vec<Variable> {
    use references as r;
    let real = |reference, name, role, unit, display_unit, description| Variable {
        reference,
        name,
        kind: Kind::Real,
        role,
        unit,
        display_unit,
        description,
    };
    let (tau, motion) = match load {
        LoadFlange::Torque => (Role::Input, Role::Output),
        LoadFlange::Motion => (Role::Output, Role::Input),
    };
    let wind_up = match depth {
        Depth::Map => {
            "flange_a.phi/ratio plus the waves of the transmission error, less flange_b.phi: elastic twist and backlash"
        }
        Depth::Multibody => "flange_a.phi/ratio less flange_b.phi: twist, play and waves together",
    };
    let pins = match depth {
        Depth::Map => "Largest force of a pin on a disc, from the load sharing at the torque",
        Depth::Multibody => "Largest force of a pin on a disc",
    };
    let seed = Variable {
        reference: r::SEED,
        name: "seed",
        kind: Kind::Integer,
        role: Role::Parameter,
        unit: "",
        display_unit: "",
        description: match depth {
            Depth::Map => "Seed of the machine for which the maps were computed; it cannot be changed",
            Depth::Multibody => {
                "Machine drawn from the tolerances with this seed; 0: the errors of the design"
            }
        },
    };
    let friction = Variable {
        reference: r::FRICTION,
        name: "friction_on",
        kind: Kind::Boolean,
        role: Role::Parameter,
        unit: "",
        display_unit: "",
        description: "Whether there is friction",
    };
    let use_acceleration = Variable {
        reference: r::USE_ACCELERATION,
        name: "use_acceleration",
        kind: Kind::Boolean,
        role: Role::Parameter,
        unit: "",
        display_unit: "",
        description: "Whether accelerations that are set are used; false if the importer has none",
    };
    let mut all = vec![
        real(r::A_PHI, "flange_a.phi", Role::Input, "rad", "deg", "Angle of the motor flange"),
        real(r::A_W, "flange_a.w", Role::Input, "rad/s", "rpm", "Speed of the motor flange"),
        real(
            r::A_A,
            "flange_a.a",
            Role::Input,
            "rad/s2",
            "",
            "Acceleration of the motor flange; as long as it is never set to anything but 0, the change of flange_a.w \
             over the step before, which is also taken where use_acceleration is false",
        ),
        real(r::A_TAU, "flange_a.tau", Role::Output, "N.m", "", "Torque at the motor flange for this motion"),
        real(
            r::B_TAU,
            "flange_b.tau",
            tau,
            "N.m",
            "",
            match load {
                LoadFlange::Torque => "Torque on the load flange, positive along positive motion",
                LoadFlange::Motion => "Torque at the load flange for this motion",
            },
        ),
        real(r::B_PHI, "flange_b.phi", motion, "rad", "deg", "Angle of the load flange"),
        real(r::B_W, "flange_b.w", motion, "rad/s", "rpm", "Speed of the load flange"),
        real(
            r::B_A,
            "flange_b.a",
            motion,
            "rad/s2",
            "",
            match load {
                LoadFlange::Torque => "Acceleration of the load flange",
                LoadFlange::Motion => "Acceleration of the load flange; if it is not set, as with flange_a.a",
            },
        ),
        real(
            r::TRANSMISSION_ERROR,
            "transmission_error",
            Role::Output,
            "rad",
            "arcmin",
            "flange_b.phi less flange_a.phi/ratio",
        ),
        real(r::WIND_UP, "wind_up", Role::Output, "rad", "arcmin", wind_up),
        real(r::PIN_FORCE, "pin_force", Role::Output, "N", "", pins),
        real(
            r::PIN_PRESSURE,
            "pin_pressure",
            Role::Output,
            "Pa",
            "MPa",
            "Largest pressure between pin and disc",
        ),
        real(r::LOSS, "loss_power", Role::Output, "W", "", "Power lost"),
        real(
            r::BALANCE,
            "energy_balance",
            Role::Output,
            "1",
            "",
            "Residual of the energy balance since the start relative to the transmitted energy",
        ),
        real(r::HOURS, "operating_hours", Role::Parameter, "h", "", "Hours at the design's duty"),
        seed,
        friction,
        use_acceleration,
    ];
    if depth == Depth::Multibody {
        all.push(real(
            r::LOCAL_ERROR,
            "local_error",
            Role::Parameter,
            "rad",
            "arcmin",
            "Local error of a step of the time integration, at the output: --tolerance of `arcmin simulate`",
        ));
    }
    all
}
