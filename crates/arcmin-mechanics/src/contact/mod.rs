//! Contact of cycloid flank and pins: force laws and the ring of contacts on one disc.

mod conformal;
mod facets;
mod law;
mod leaning;
mod pin_contact;
mod ring;
mod rolling;
mod search;
mod sliding;
mod spring;
mod worn_pin;

pub use conformal::ConformalSeat;
pub use facets::MeshContact;
pub use law::{ContactForce, ContactLaw, ContactLawName, Damping, LineContact};
pub use leaning::LeaningLine;
pub(crate) use leaning::slice_height;
pub use pin_contact::PinContact;
pub use ring::{DiscPose, DiscVelocity, Pin, PinContacts, Reaction, TOLERABLE_DEPTH};
pub use rolling::Rolling;
pub use search::Moved;
pub use sliding::Sliding;
pub use spring::{ContactSpring, Pressed};
