//! An arm as solids on its axes. Lengths in mm, in the frames of the links.

use serde::Serialize;

/// A serial arm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ArmScene {
    /// Solids of the base, in its frame.
    pub base: Vec<Solid>,
    /// From the base.
    pub links: Vec<Link>,
    /// Whether links are shells with the joints inside, which are drawn transparent.
    pub shells: bool,
    /// In the frame of the last link.
    pub tool_mm: [f64; 3],
}

/// A link behind its axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Link {
    /// Name of the axis.
    pub name: String,
    /// Pose at angle 0 in the frame of the previous link.
    pub frame: Frame,
    /// Direction of the axis in its own frame, a unit vector.
    pub axis: [f64; 3],
    /// The reducer.
    pub joint: Solid,
    /// Solids of the link in its own frame.
    pub solids: Vec<Solid>,
}

/// Place and orientation in another frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Frame {
    /// Origin.
    pub position_mm: [f64; 3],
    /// By rows.
    pub rotation: [f64; 9],
}

/// A simple solid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Solid {
    /// A round bar between two points of its axis.
    Cylinder {
        /// Middle of the first face.
        from_mm: [f64; 3],
        /// Middle of the last face.
        to_mm: [f64; 3],
        /// Radius of the bar.
        radius_mm: f64,
    },
    /// About the middle of its frame.
    Block {
        /// Place of its middle and directions of its edges.
        frame: Frame,
        /// Lengths of the edges along x, y and z.
        size_mm: [f64; 3],
    },
    /// A ball.
    Ball {
        /// Its middle.
        at_mm: [f64; 3],
        /// Its radius.
        radius_mm: f64,
    },
}
