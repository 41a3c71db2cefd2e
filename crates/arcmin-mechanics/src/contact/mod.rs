//! Contact of cycloid flank and pins: force laws and the ring of contacts on one disc.

mod conformal;
mod facets;
mod law;
mod pin_contact;
mod ring;
mod rolling;
mod search;
mod sliding;
mod spring;
mod tilted;
mod worn_pin;

pub use conformal::ConformalSeat;
pub use facets::MeshContact;
pub use law::{ContactForce, ContactLaw, ContactLawName, Damping, LineContact};
pub use pin_contact::PinContact;
pub use ring::{DiscPose, DiscVelocity, Pin, PinContacts, Reaction, TOLERABLE_DEPTH};
pub use rolling::Rolling;
pub use search::Displacements;
pub use sliding::Sliding;
pub use spring::{ContactSpring, Pressed};
pub use tilted::TiltedLine;
pub(crate) use tilted::slice_height;
