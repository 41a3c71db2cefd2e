//! An arm that moves along its programs, with the error of its tool.

use serde::Serialize;

use crate::scene::ArmScene;

/// An arm in three dimensions in browsers with WebGL 2, otherwise as lines.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ArmPicture {
    /// Heading of the figure.
    pub title: String,
    /// Text below the figure.
    #[serde(skip)]
    pub note: String,
    /// Solids on the axes.
    pub arm: ArmScene,
    /// Programs to choose from.
    pub programs: Vec<ArmProgram>,
    /// Ages to choose from.
    pub hours: Vec<f64>,
    /// Share of every joint at every age, at the test pose with the largest error.
    pub shares_um: Vec<Vec<f64>>,
    /// Initial magnification of errors.
    pub magnified: f64,
}

/// Moments of a program.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ArmProgram {
    /// Name to choose it by.
    pub name: String,
    /// Times of its moments.
    pub time_s: Vec<f64>,
    /// Angles of all joints, moment by moment.
    pub angles_deg: Vec<f64>,
    /// States of the arm, one per age.
    pub states: Vec<ArmState>,
}

/// An arm of one age along a program.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ArmState {
    /// Reached less commanded place of the tool, three numbers of every moment.
    pub error_um: Vec<f64>,
    /// Share of every joint along that error, moment by moment.
    pub share_um: Vec<f64>,
}
