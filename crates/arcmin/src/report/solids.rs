//! The drive as solids in three dimensions, with forces and worn flanks.

use serde::Serialize;

use super::Mechanism;
use crate::contact::LineContact;
use crate::geometry::Relief;
use crate::load::Cycle;
use crate::scene::Scene;
use crate::units::{DEG, MPA, UM};

/// A drive as solids where the browser draws such, and elsewhere as the drawing `instead`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Solids {
    /// Heading of the figure.
    pub title: String,
    /// Text below the figure.
    #[serde(skip)]
    pub note: String,
    /// Bodies, rings and motion of the drive.
    pub scene: Scene,
    /// To choose from, for instance new and after some hours.
    pub states: Vec<SolidState>,
    /// Drawing for browsers without WebGL; `None` for text alone.
    pub instead: Option<Mechanism>,
}

/// A state of a drive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SolidState {
    /// Name to choose the state by.
    pub label: String,
    /// Worn off the flank in each ring, as [`depths`]; rings that are not worn have none.
    pub depth_um: Vec<Vec<f64>>,
    /// [`positions`] in each ring.
    pub rings: Vec<Vec<Position>>,
}

/// The forces at one crank angle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Position {
    /// Transmission error at this crank angle under load.
    pub te_arcmin: f64,
    /// Disc, pin, force in N, pressure in MPa.
    pub contacts: Vec<(usize, usize, f64, f64)>,
}

/// Depths in µm evenly from −180° to 180° of meshing angle.
pub fn depths(worn: &Relief) -> Vec<f64> {
    const POINTS: usize = 181;
    let at = |i: usize| (-180.0 + 360.0 * i as f64 / (POINTS - 1) as f64) * DEG;
    // A tenth of a nanometre is finer than a picture can show.
    let rounded = |depth: f64| (depth / UM * 1e4).round() / 1e4;
    (0..POINTS).map(|i| rounded(worn.at(at(i)).depth)).collect()
}

/// Contacts that carry at the positions of a cycle over one pin pitch; forces in tenths of a newton.
pub fn positions(cycle: &Cycle, law: LineContact) -> Vec<Position> {
    let of_position = |position: &crate::load::LoadSharing| {
        let contacts = position.discs.iter().enumerate().flat_map(|(disc, contacts)| {
            contacts.iter().filter(|c| c.force > 0.0).map(move |c| {
                let pressure = law.pressure(c.force, 1.0 / c.relative_curvature) / MPA;
                (disc, c.pin, (c.force * 10.0).round() / 10.0, pressure.round())
            })
        });
        Position { te_arcmin: position.output_error.arcmin(), contacts: contacts.collect() }
    };
    cycle.positions.iter().map(of_position).collect()
}
