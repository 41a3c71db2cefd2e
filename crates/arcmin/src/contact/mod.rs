//! Contact of cycloid flank and pins: force laws and the ring of contacts on one disc.

mod law;
mod ring;
mod rolling;

pub use law::{ContactForce, ContactLaw, Damping, LineContact};
pub use ring::{DiscPose, DiscVelocity, Pin, PinContact, PinContacts, Reaction, Sliding, TOLERABLE_DEPTH};
pub use rolling::Rolling;
