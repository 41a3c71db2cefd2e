//! Offset of a worn flank from the trace of the pin centres: a lower bound of gaps, by which open pins are skipped.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::foot::Place;
use super::{Profile, Relief, Vec2, unit};
use crate::units::wrap_angle;

/// Least number of points on one lobe.
const PLACES: usize = 720;
/// Fraction of a lobe (its inverse) by which the flank is continued on either side, for closest points beyond
/// its ends.
const BEYOND: usize = 4;
/// Sectors of the meshing angle with a bound of their own.
const SECTORS: usize = 72;
/// Neighbours on either side that count for a sector: 20°, by which the foot can differ from the nominal position.
const NEIGHBOURS: usize = 4;

/// Lower bound of the distance of pin centres from a worn flank, as a function of their feet on the trace.
///
/// The offset A(φ) = min |c(φ) − f(ψ)| is the distance of a point c of the trace from the points f(ψ) of the worn flank. It
/// is the pin radius plus the depth at φ, less the difference by a closest point elsewhere; on flanks worn into the shape
/// of the pin this difference is nearly as large as the depth, and a series about the foot does not describe it. A pin centre
/// at the height d above the trace has a distance of at least A + d cos β for d ≥ 0 and of at least A + d for d < 0, where β
/// is the largest angle between the normal of a foot and the direction from the closest point.
#[derive(Debug, Clone)]
pub(crate) struct WornOffset {
    /// A in m at φ = −π + 2π i/n, i = 0…n, less the amount by which it may lie below the chords; one value if the depth is
    /// uniform.
    offsets: Vec<f64>,
    /// Their minima within ±20° of each sector, and over the lobe, m.
    by_sector: [f64; SECTORS],
    least: f64,
    /// The least cos β.
    cosine: f64,
    /// Points c (m) and outward normals of the trace at these positions and beyond them. They do not depend on the wear.
    trace: Arc<[(Vec2, Vec2)]>,
}

impl WornOffset {
    /// Of a flank without wear.
    pub fn of(profile: &Profile) -> WornOffset {
        WornOffset::new(vec![profile.pin_radius], 1.0, Arc::new([]))
    }

    fn new(offsets: Vec<f64>, cosine: f64, trace: Arc<[(Vec2, Vec2)]>) -> WornOffset {
        let cells = offsets.len() - 1;
        let least = |of: &[f64]| of.iter().copied().fold(f64::INFINITY, f64::min);
        let own: [f64; SECTORS] = std::array::from_fn(|sector| {
            least(&offsets[sector * cells / SECTORS..=(sector + 1) * cells / SECTORS])
        });
        let by_sector = std::array::from_fn(|sector| {
            let near = sector + SECTORS - NEIGHBOURS..=sector + SECTORS + NEIGHBOURS;
            near.map(|i| own[i % SECTORS]).fold(f64::INFINITY, f64::min)
        });
        WornOffset { least: least(&offsets), by_sector, offsets, cosine, trace }
    }

    /// The same flank with this relief.
    #[must_use]
    pub fn with(&self, profile: &Profile, relief: &Relief) -> WornOffset {
        let trace = self.trace.clone();
        if relief.is_uniform() {
            return WornOffset::new(vec![profile.pin_radius + relief.samples()[0]], 1.0, trace);
        }
        let samples = relief.samples();
        let count = samples.len().max(PLACES);
        let (beyond, step) = (count / BEYOND, TAU / count as f64);
        let trace = match trace.len() == count + 2 * beyond + 1 {
            true => trace,
            false => places_of_trace(profile, count, beyond),
        };
        let places: Vec<(Vec2, Vec2, Vec2)> = trace
            .iter()
            .enumerate()
            .map(|(i, (c, normal))| {
                let depth = match count == samples.len() {
                    true => samples[(i + count - beyond) % count],
                    false => relief.at(wrap_angle((i as f64 - beyond as f64) * step - PI)).depth,
                };
                (*c, *normal, c - (profile.pin_radius + depth) * normal)
            })
            .collect();
        let (mut nearest, mut cosine) = (beyond, 1.0_f64);
        let mut offsets: Vec<f64> = (beyond..=beyond + count)
            .map(|i| {
                let (c, normal, _) = places[i];
                let square = |j: usize| (c - places[j].2).norm_squared();
                while nearest + 2 < places.len() && square(nearest + 1) <= square(nearest) {
                    nearest += 1;
                }
                while nearest > 1 && square(nearest - 1) < square(nearest) {
                    nearest -= 1;
                }
                let [before, here, after] = [nearest - 1, nearest, nearest + 1].map(|j| square(j).sqrt());
                cosine = cosine.min(normal.dot(&(c - places[nearest].2)) / here);
                // Between samples the minimum lies at most an eighth of the second difference below the middle one.
                here - 0.25 * (before - 2.0 * here + after).max(0.0)
            })
            .collect();
        let bends: Vec<f64> = offsets.windows(3).map(|d| (d[0] - 2.0 * d[1] + d[2]).max(0.0)).collect();
        for (i, bend) in bends.iter().enumerate() {
            for offset in &mut offsets[i..i + 3] {
                *offset -= 0.25 * bend;
            }
        }
        WornOffset::new(offsets, cosine.max(0.0), trace)
    }

    /// Lower bound (m) of the distance of a pin centre at a height (m) above its foot at a meshing angle.
    #[inline]
    pub fn distance(&self, meshing_angle: f64, height: f64) -> f64 {
        let cells = self.offsets.len() - 1;
        if cells == 0 {
            return self.offsets[0] + height;
        }
        let x = ((meshing_angle + PI) * (cells as f64 / TAU)).max(0.0);
        let cell = (x as usize).min(cells - 1);
        let share = x - cell as f64;
        let chord = self.offsets[cell] + share * (self.offsets[cell + 1] - self.offsets[cell]);
        self.above(chord, height)
    }

    /// As [`WornOffset::distance`] for feet within 20° of a meshing angle in turns from −½ on.
    #[inline]
    pub fn distance_about(&self, turn: f64, height: f64) -> f64 {
        let turn = if turn < 1.0 { turn } else { turn - 1.0 };
        self.above(self.by_sector[((turn * SECTORS as f64) as usize).min(SECTORS - 1)], height)
    }

    /// As [`WornOffset::distance`] for all feet.
    #[inline]
    pub fn least_distance(&self, height: f64) -> f64 {
        self.above(self.least, height)
    }

    #[inline]
    fn above(&self, offset: f64, height: f64) -> f64 {
        offset + if height > 0.0 { self.cosine * height } else { height }
    }
}

/// Points and outward normals of the trace at `count` places over one lobe from φ = −π on, and `beyond` it on either side.
fn places_of_trace(profile: &Profile, count: usize, beyond: usize) -> Arc<[(Vec2, Vec2)]> {
    let step = TAU / count as f64;
    // φ = −z_c τ.
    let lobes = profile.lobe_count() as f64;
    let first = (PI + beyond as f64 * step) / lobes;
    let [m, z] = profile.turns();
    let mut place = Place { tau: first, e: unit(m * first), ez: unit(z * first), shared: false };
    let places = (0..=count + 2 * beyond).map(|_| {
        let (c, c1, _) = profile.trace_derivatives(place.e, place.ez);
        place = place.moved(-step / lobes, [m, z]);
        (c, Vec2::new(c1.y, -c1.x).normalize())
    });
    places.collect()
}
