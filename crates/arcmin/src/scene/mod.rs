//! A drive as solids that move: what a picture of it is drawn from. Lengths in mm, angles in degrees, all against the
//! ring of pins; the angle that moves everything is that of the crankshafts, or of the input shaft of a single stage.

mod rv;
mod shapes;
mod stage;
#[cfg(test)]
mod tests;

use serde::Serialize;

use crate::contact::DiscPose;
use crate::geometry::unit;
use crate::units::{DEG, MM};

pub use rv::of_machine;
pub use shapes::Shape;
pub use stage::of_stage;

/// The solids of a drive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scene {
    pub bodies: Vec<Body>,
    pub teeth: Teeth,
    /// Turn of the whole picture per crank angle, such that the member at rest stands still.
    pub frame_rate: f64,
    /// Turns of input and output per crank angle, both against the ring.
    pub input_rate: f64,
    pub output_rate: f64,
    /// From the first face to the last.
    pub length_mm: f64,
    pub radius_mm: f64,
    /// What of this is not part of the design and drawn for the eye.
    pub assumed: String,
}

/// A body that moves as a whole.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Body {
    pub id: String,
    pub name: String,
    pub kind: Kind,
    /// Number of the disc that it belongs to.
    pub disc: Option<usize>,
    /// Sections of the design that describe it.
    pub keys: Vec<&'static str>,
    pub motion: Motion,
    pub shapes: Vec<Shape>,
}

/// What a body is: bodies of one kind look alike and are hidden together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    Housing,
    Pins,
    Disc,
    Shaft,
    Rollers,
    Carrier,
    Gear,
    OutputPins,
}

/// Nominal motion: the place is the sum of the arms, the turn grows from `turn_deg`.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Motion {
    pub arms: Vec<Arm>,
    pub turn_deg: f64,
    pub turn_rate: f64,
}

/// An arm of constant length that turns.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Arm {
    pub length_mm: f64,
    pub angle_deg: f64,
    /// Turns per turn of the crank angle.
    pub rate: f64,
}

impl Motion {
    fn turning(turn_rate: f64) -> Motion {
        Motion { turn_rate, ..Motion::default() }
    }

    /// Place (m) and angle (rad) at a crank angle in rad.
    pub fn at(&self, crank: f64) -> DiscPose {
        let arm = |arm: &Arm| arm.length_mm * MM * unit(arm.angle_deg * DEG + arm.rate * crank);
        DiscPose {
            centre: self.arms.iter().map(arm).sum(),
            angle: self.turn_deg * DEG + self.turn_rate * crank,
        }
    }
}

/// Where pins and flanks meet.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Teeth {
    pub pin_count: usize,
    pub pin_circle_radius_mm: f64,
    pub pin_radius_mm: f64,
    pub eccentricity_mm: f64,
    /// Of the eccentrics, a disc each.
    pub phases_deg: Vec<f64>,
    /// Middle of each disc along the axis.
    pub middles_mm: Vec<f64>,
}

fn arm(length: f64, angle: f64, rate: f64) -> Arm {
    Arm { length_mm: length / MM, angle_deg: angle / DEG, rate }
}

/// Turn of a cage per crank angle from those of the inner and outer ring: rolling without slip.
fn cage_rate(pitch_diameter: f64, roller_diameter: f64, inner: f64, outer: f64) -> f64 {
    let (small, large) = (pitch_diameter - roller_diameter, pitch_diameter + roller_diameter);
    0.5 * (inner * small + outer * large) / pitch_diameter
}
