//! The drive as solids in three dimensions, with forces and worn flanks.

use serde::Serialize;

use super::Mechanism;
use crate::contact::LineContact;
use crate::geometry::Relief;
use crate::load::Cycle;
use crate::scene::Scene;
use crate::units::{DEG, MPA, UM};

/// A drive as solids in browsers with WebGL 2, otherwise as the drawing `instead`.
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
    /// Wear depths of the flank in each ring, as [`depths`]; empty for rings without wear.
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

/// Depths in µm evenly from −180° to 180° of meshing angle. Each is the largest depth within half a step of its angle, so
/// that the deepest place is shown even if it is as narrow as the corner of a tip.
pub fn depths(worn: &Relief) -> Vec<f64> {
    const POINTS: usize = 181;
    let angle = |i: usize| (-180.0 + 360.0 * i as f64 / (POINTS - 1) as f64) * DEG;
    let mut deepest: Vec<f64> = (0..POINTS).map(|i| worn.at(angle(i)).depth).collect();
    let samples = worn.samples();
    for (phi, depth) in Relief::grid(samples.len()).zip(samples) {
        let nearest = ((phi / DEG + 180.0) / 360.0 * (POINTS - 1) as f64).round() as usize;
        deepest[nearest] = deepest[nearest].max(*depth);
    }
    // −180° and 180° are the same place.
    let ends = deepest[0].max(deepest[POINTS - 1]);
    (deepest[0], deepest[POINTS - 1]) = (ends, ends);
    // A resolution of 0.1 nm suffices for a picture.
    let rounded = |depth: f64| (depth / UM * 1e4).round() / 1e4;
    deepest.into_iter().map(rounded).collect()
}

/// Loaded contacts at the positions of a cycle over one pin pitch; forces rounded to 0.1 N.
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
