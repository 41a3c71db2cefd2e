//! Properties of a drive that wear and accuracy depend on.

use crate::contact::LineContact;
use crate::geometry::{Profile, Relief};
use crate::load::closed_form::first_max_force;
use crate::machine::{DutyPoint, Machine, PinMounting, Wear};

/// Geometry, duty and wear laws of flanks and pins of a drive of any family.
#[derive(Debug, Clone)]
pub struct WearCase {
    /// The flank as cut.
    pub profile: Profile,
    /// Law of contact of a pin with a flank.
    pub contact: LineContact,
    /// Relief of the flank by design, m.
    pub designed: Relief,
    /// Discs that share the torque.
    pub disc_count: usize,
    /// Face width of a disc, m.
    pub disc_width: f64,
    /// Radius of the pins as installed, m.
    pub pin_radius: f64,
    /// Whether pins turn in their seats, which determines the distribution of their wear.
    pub pin_mounting: PinMounting,
    /// Laws and coefficients of wear.
    pub wear: Wear,
    /// Rated torque at the output, N·m.
    pub rated_torque: f64,
    /// Load spectrum, torques at the output.
    pub duty: Vec<DutyPoint>,
    /// Largest force (N) on a pin at the largest torque of the duty, by the closed form with equal springs.
    pub largest_force: f64,
    /// Limit of the lost motion in rad.
    pub lost_motion: f64,
    /// Coulomb coefficient between flank and pin.
    pub flank_friction: f64,
}

impl WearCase {
    /// Pins of the ring, z_p.
    pub fn pin_count(&self) -> usize {
        self.profile.pin_count
    }
}

impl From<&Machine> for WearCase {
    fn from(machine: &Machine) -> WearCase {
        WearCase {
            profile: machine.profile(),
            contact: machine.line_contact(),
            designed: machine.designed_relief(),
            disc_count: machine.disc_count,
            disc_width: machine.disc.width,
            pin_radius: machine.ring.pin_radius,
            pin_mounting: machine.ring.mounting,
            wear: machine.wear.clone(),
            rated_torque: machine.rated.torque,
            duty: machine.duty.clone(),
            largest_force: first_max_force(machine, DutyPoint::largest_torque(&machine.duty)),
            lost_motion: machine.limits.lost_motion,
            flank_friction: machine.flank_friction(),
        }
    }
}
