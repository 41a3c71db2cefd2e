//! Tooth geometry of the cycloid disc: the exact flank, its foot points, and the depth of metal removed from
//! it.
//!
//! Frame of this module: the disc's own, origin at the disc centre, angles counter-clockwise. The flank is
//! described by the path of a generating pin's centre (the *trace*, a curtate epitrochoid) and the pin
//! radius.

mod closest;
mod feet;
mod flank_error;
mod foot;
mod hollow;
mod outline;
mod profile;
mod relief;
mod tip;
mod worn_offset;

pub use closest::Closest;
pub(crate) use feet::LANES;
pub(crate) use flank_error::{ErrorFloors, FlankErrorReader};
pub use flank_error::{FlankDataError, FlankDirection, FlankError, FlankHarmonic};
pub use foot::Foot;
pub use outline::{Outline, Sector, Segment};
pub use profile::Profile;
pub use relief::{DepthSample, Relief};
pub use tip::{Tip, TipError};
pub(crate) use worn_offset::WornOffset;

/// A point or a vector in the plane, in metres unless stated otherwise.
pub type Vec2 = nalgebra::Vector2<f64>;

/// (cos x, sin x).
#[inline]
pub fn unit(angle: f64) -> Vec2 {
    let (sin, cos) = angle.sin_cos();
    Vec2::new(cos, sin)
}

/// The vector turned by +90°.
#[inline]
pub fn quarter_turn(v: Vec2) -> Vec2 {
    Vec2::new(-v.y, v.x)
}

/// The vector turned by the angle whose cosine and sine are `rotation`.
#[inline]
pub fn turned(v: Vec2, rotation: Vec2) -> Vec2 {
    Vec2::new(v.x * rotation.x - v.y * rotation.y, v.x * rotation.y + v.y * rotation.x)
}

/// z component of the cross product.
#[inline]
pub fn cross(a: Vec2, b: Vec2) -> f64 {
    a.x * b.y - a.y * b.x
}
