//! A drive as moving solids, for its picture. Lengths in mm, angles in degrees, all relative to the fixed ring
//! of pins; the driving angle is that of the crankshafts, or of the input shaft of a drive of eccentrics. Also
//! an arm of such drives, as solids on its axes.

mod arm;
mod rv;
mod shapes;
mod stage;
#[cfg(test)]
mod tests;
mod two_ring;

use serde::Serialize;

use crate::contact::DiscPose;
use crate::geometry::unit;
use crate::units::{DEG, MM};

pub use arm::{ArmScene, Frame, Link, Solid};
pub use rv::of_machine;
pub use shapes::Shape;
pub use stage::{of_stage, of_two_stages};
pub use two_ring::of_two_rings;

/// Script of the motion of a drive. A page loads [`three`] first, then this script and the next four in this order. A
/// drive needs the first three of them, an arm all.
pub const MOTION: &str = include_str!("assets/motion.js");
/// Script of camera and input.
pub const SPACE: &str = include_str!("assets/space.js");
/// Script of `class View`, which draws a drive.
pub const VIEW: &str = include_str!("assets/view.js");
/// Script of the motion of an arm.
pub const KINEMATICS: &str = include_str!("assets/kinematics.js");
/// Script of `class ArmView`, which draws an arm.
pub const ARM_VIEW: &str = include_str!("assets/armview.js");

/// The part of three.js that these scripts use, with its licence.
pub fn three() -> String {
    const LICENCE: &str = include_str!("assets/three/LICENSE");
    const THREE: &str = include_str!("assets/three/three.min.js");
    format!("/* three.js\n{LICENCE}*/\n{THREE}")
}

/// The solids of a drive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scene {
    /// Parts that move as a whole.
    pub bodies: Vec<Body>,
    /// Rings of pins with the flanks in them, from the input.
    pub rings: Vec<Ring>,
    /// Name of the angle that turns the scene: "Crank angle", or "Eccentric angle" of drives without crankshafts. It is
    /// called crank angle in these fields.
    pub angle_name: &'static str,
    /// Turns of the crank angle after which all eccentrics have the same position.
    pub turns: usize,
    /// Rotation of the whole picture per crank angle that keeps the fixed member at rest.
    pub frame_rate: f64,
    /// Turn of the input per crank angle, against the ring.
    pub input_rate: f64,
    /// Turn of the output per crank angle, against the ring.
    pub output_rate: f64,
    /// From the first face to the last.
    pub length_mm: f64,
    /// Outer radius of all bodies.
    pub radius_mm: f64,
    /// Statement of the sizes that are not part of the design and drawn by rules.
    pub assumed: String,
}

/// A body that moves as a whole.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Body {
    /// Identity in the scene.
    pub id: String,
    /// Name for readers.
    pub name: String,
    /// Kind by which it is coloured and hidden.
    pub kind: Kind,
    /// Number of the ring that it belongs to.
    pub ring: Option<usize>,
    /// Number of the disc in that ring.
    pub disc: Option<usize>,
    /// Number of its crankshaft, where there are several.
    pub crankshaft: Option<usize>,
    /// Whether it lags with the output under load.
    pub with_output: bool,
    /// Displacement along the axis in the exploded view, mm.
    pub apart_mm: f64,
    /// Sections of the design that describe it.
    pub keys: Vec<&'static str>,
    /// Nominal motion in the plane.
    pub motion: Motion,
    /// Solids of the body in its own coordinates.
    pub shapes: Vec<Shape>,
}

/// Kind of a body: bodies of one kind have the same colour and are hidden together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Housing around the pins.
    Housing,
    /// Pins of a ring: separate, or the teeth of a ring of one piece.
    Pins,
    /// Cycloid discs.
    Disc,
    /// Shafts with their eccentrics.
    Shaft,
    /// Rolling elements of bearings.
    Rollers,
    /// Carrier or output flange.
    Carrier,
    /// Sun and planets.
    Gear,
    /// Output pins with their rollers.
    OutputPins,
    /// A ring of pins that turns.
    OutputRing,
}

impl Kind {
    /// Displacement along the axis in the exploded view, in lengths of the drive; `disc` counts from the middle of all discs.
    fn apart(self, disc: Option<f64>) -> f64 {
        let own = disc.map_or(0.0, |disc| 0.8 * disc);
        0.55 * match self {
            Kind::Housing | Kind::Pins => 0.0,
            Kind::Disc => own + 0.2,
            Kind::Rollers => disc.map_or(1.6, |_| own - 0.25),
            Kind::Shaft => -1.5,
            Kind::Gear => -2.4,
            Kind::OutputPins => 1.6,
            Kind::Carrier | Kind::OutputRing => 2.4,
        }
    }
}

/// Nominal motion: the place is the sum of the arms, the turn grows from `turn_deg`.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Motion {
    /// Arms that lead to the place of the body.
    pub arms: Vec<Arm>,
    /// Angle of the body at the crank angle 0.
    pub turn_deg: f64,
    /// Turn of the body per crank angle.
    pub turn_rate: f64,
}

/// An arm of constant length that turns.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Arm {
    /// Length of the arm.
    pub length_mm: f64,
    /// Direction of the arm at the crank angle 0.
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

/// A ring with its pins and the flanks in it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ring {
    /// For readers; empty where there is no other.
    pub name: &'static str,
    /// Prefix of its tables and figures in results.
    pub key: &'static str,
    /// Whether its teeth are arcs of one piece with it, in place of pins.
    pub one_piece: bool,
    /// Pins of the ring.
    pub pin_count: usize,
    /// m: the eccentricity times z_p/m is the pitch radius, in which lines of action meet.
    pub tooth_difference: usize,
    /// Radius of the circle of the pin centres.
    pub pin_circle_radius_mm: f64,
    /// Radius of the pins as installed.
    pub pin_radius_mm: f64,
    /// Distance of the eccentrics from their axis.
    pub eccentricity_mm: f64,
    /// Turns of the ring per turn of the crank angle.
    pub rate: f64,
    /// Turns of the eccentrics per turn of the crank angle.
    pub eccentric_rate: f64,
    /// Flanks of the discs that run in it.
    pub flanks: Vec<Flank>,
}

/// The flank of a disc in a ring.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Flank {
    /// Identity of the disc among the bodies.
    pub body: String,
    /// Phase of its eccentric.
    pub phase_deg: f64,
    /// Angle by which the pins in contact with it are ahead of those of the first disc.
    pub row_deg: f64,
    /// Its middle along the axis.
    pub middle_mm: f64,
}

impl Body {
    /// A body that belongs to no disc and is not displaced in the exploded view.
    fn new(
        id: impl Into<String>,
        name: impl Into<String>,
        kind: Kind,
        keys: &[&'static str],
        motion: Motion,
        shapes: Vec<Shape>,
    ) -> Body {
        Body {
            id: id.into(),
            name: name.into(),
            kind,
            ring: None,
            disc: None,
            crankshaft: None,
            with_output: false,
            apart_mm: 0.0,
            keys: keys.to_vec(),
            motion,
            shapes,
        }
    }

    fn of(self, ring: usize, disc: Option<usize>) -> Body {
        Body { ring: Some(ring), disc, ..self }
    }

    fn on(self, crankshaft: usize) -> Body {
        Body { crankshaft: Some(crankshaft), ..self }
    }

    fn with_output(self) -> Body {
        Body { with_output: true, ..self }
    }
}

/// Sets the displacement of each body in the exploded view of a drive of this length (mm) and number of discs,
/// starting at `begin` (mm).
fn take_apart(bodies: &mut [Body], length: f64, discs: usize, begin: f64) {
    let middle = 0.5 * (discs as f64 - 1.0);
    for body in bodies {
        let disc = body.disc.map(|disc| disc as f64 - middle);
        body.apart_mm = begin + length * body.kind.apart(disc);
    }
}

fn arm(length: f64, angle: f64, rate: f64) -> Arm {
    Arm { length_mm: length / MM, angle_deg: angle / DEG, rate }
}

/// Turn of a cage per crank angle from those of the inner and outer ring: rolling without slip.
fn cage_rate(pitch_diameter: f64, roller_diameter: f64, inner: f64, outer: f64) -> f64 {
    let (small, large) = (pitch_diameter - roller_diameter, pitch_diameter + roller_diameter);
    0.5 * (inner * small + outer * large) / pitch_diameter
}
