//! Virtual test bench: the values of makers' catalogues, from the quasi-static model with bearings.
//!
//! Definitions as in GB/T 35089 and GB/T 40731: input locked, output torque cycled to ± rated; lost motion
//! between the mid-points of the two branches at ± 3 % of rated torque; backlash as the width of the loop at
//! zero torque; torsional stiffness as the slope of the branches.

mod bearing_life;
mod bodies;
#[cfg(test)]
mod eccentric_tests;
mod efficiency;
mod heat;
mod hysteresis;
mod main_bearings;
mod measured;
mod no_load;
#[cfg(test)]
mod order_tests;
mod orders;
mod settle;
mod state;
#[cfg(test)]
mod state_tests;
#[cfg(test)]
mod tests;
mod transmission;

pub use crate::load::LOST_MOTION_SHARE;
pub use bearing_life::{BearingLoad, bearing_loads, dynamic_load_rating, rating_life};
pub use bodies::{BodyCompliance, body_compliance};
pub use efficiency::{EfficiencyMap, LossLine, efficiency_map, loss_lines};
pub use efficiency::{LOSS_SHARES, LOSS_SPEEDS};
pub use heat::{HeatBalance, Steady, heat_balance};
pub use hysteresis::shares;
pub use hysteresis::{
    Branch, LoopFigures, LoopPoint, STIFFNESS_WINDOW, StiffnessSplit, eccentric_loop, evaluate_loop,
    hysteresis_loop, stiffness_split,
};
pub use main_bearings::{MainBearingLoad, main_bearing_load};
pub use measured::{
    LoopRow, MeasuredCurve, MeasuredLoop, MeasuredOnBench, Remark, TurnRow, TurnSpectrum, Unusable,
    read_loops, read_turns,
};
pub use no_load::{RunningTorques, running_torques};
pub use orders::{NamedOrder, name_orders};
pub use state::{RigPlan, RigState};
pub use transmission::{
    Curves, ErrorCurve, PinLoads, TransmissionSettings, error_curve, transmission_error_curves,
};

use crate::dynamics::DynamicsError;
use crate::machine::{Friction, Machine};
use crate::tribology::seal_drag;

/// Reason why a test could not be carried out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RigError {
    /// No equilibrium or no motion was found.
    #[error("test bench: {0}")]
    Balance(#[from] DynamicsError),
    /// A body can move without resistance at this position, so that the stiffness is undefined.
    #[error("test bench: the machine has a body without stiffness at rated torque")]
    Loose,
    /// The tests are run to ± rated torque, which is zero.
    #[error("test bench: the rated torque must not be zero")]
    NoTorque,
    /// Fault of a hysteresis loop, as a part of the message.
    #[error("the loop is not usable: {0}")]
    BadLoop(&'static str),
    /// Fault of a transmission error, as a part of the message.
    #[error("the transmission error is not usable: {0}")]
    BadCurve(&'static str),
}

/// Friction assumed where a design gives none: mixed friction with grease on pins that do not turn in their
/// seats, values of the order of ISO/TR 14179 for gear meshes and rolling bearings, one lip seal around the
/// carrier by [`seal_drag`], and a viscous drag of 10⁻⁴ N·m·s on a pin circle of 64 mm radius. The drag scales
/// with the third power of the size, as for parallel faces with a gap proportional to the size (η ω r⁴/gap).
/// These are assumptions, to be replaced by measured values.
pub fn assumed_friction(machine: &Machine) -> Friction {
    Friction {
        flank: 0.06,
        pin_seat: 0.06,
        bearing: 0.002,
        gear_mesh: 0.06,
        seal_drag: seal_drag(2.0 * machine.solids.carrier.plate_radius),
        oil_drag: 1e-4 * (machine.ring.pin_circle_radius / 64e-3).powi(3),
        regularisation_speed: 1e-3,
        ..Friction::default()
    }
}
