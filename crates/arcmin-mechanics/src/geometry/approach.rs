//! Distance of a worn flank from its trace: the bound by which open pins are passed over.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::foot::Place;
use super::{Profile, Relief, Vec2, unit};
use crate::units::wrap_angle;

/// Places on one lobe at the least.
const PLACES: usize = 720;
/// Share of a lobe by which the flank is continued on either side: as far from its foot a closest point is sought.
const BEYOND: usize = 4;

/// Lower bound of the distance of pin centres from a worn flank, by their feet on the trace.
///
/// A pin centre on the trace at φ has the distance A(φ) = min |c(φ) − f(ψ)| over the places f(ψ) of the worn flank: what
/// is removed at φ, less what the pin gains as it is closest elsewhere. On flanks worn into the shape of the pin that is
/// most of it, and no series about the foot tells it. A pin centre that stands by d off the trace, along the normal of its
/// foot, has a distance between A + d and A + d cos β for d ≥ 0, of at least A + d for d < 0, with the angle β between that
/// normal and the direction of the closest place.
#[derive(Debug, Clone)]
pub(crate) struct Approach {
    /// A in m at φ = −π + 2π i/n, i = 0…n, less what it may lie below the chords in between; one value of an even flank.
    distances: Arc<[f64]>,
    /// The least cos β.
    cosine: f64,
    /// Points c (m) and outward normals of the trace at these places and beyond them: the same for every wear of a flank.
    trace: Arc<[(Vec2, Vec2)]>,
}

impl Approach {
    /// Of a flank without wear.
    pub fn of(profile: &Profile) -> Approach {
        Approach { distances: Arc::new([profile.pin_radius]), cosine: 1.0, trace: Arc::new([]) }
    }

    /// The same flank with this relief.
    #[must_use]
    pub fn with(&self, profile: &Profile, relief: &Relief) -> Approach {
        let trace = self.trace.clone();
        if relief.is_uniform() {
            return Approach {
                distances: Arc::new([profile.pin_radius + relief.samples()[0]]),
                cosine: 1.0,
                trace,
            };
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
        let mut distances: Vec<f64> = (beyond..=beyond + count)
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
                // Between samples the least lies up to an eighth of the second difference below the middle one.
                here - 0.25 * (before - 2.0 * here + after).max(0.0)
            })
            .collect();
        let bends: Vec<f64> = distances.windows(3).map(|d| (d[0] - 2.0 * d[1] + d[2]).max(0.0)).collect();
        for (i, bend) in bends.iter().enumerate() {
            for distance in &mut distances[i..i + 3] {
                *distance -= 0.25 * bend;
            }
        }
        Approach { distances: distances.into(), cosine: cosine.max(0.0), trace }
    }

    /// A at places evenly over one lobe, from the meshing angle −π on; the first also at the end.
    pub fn distances(&self) -> &[f64] {
        &self.distances
    }

    /// Distance (m) of a pin centre that stands by `off` (m) off the trace at a meshing angle, at the least.
    #[inline]
    pub fn at(&self, meshing_angle: f64, off: f64) -> f64 {
        let cells = self.distances.len() - 1;
        if cells == 0 {
            return self.distances[0] + off;
        }
        let x = ((meshing_angle + PI) * (cells as f64 / TAU)).max(0.0);
        let cell = (x as usize).min(cells - 1);
        let share = x - cell as f64;
        let chord = self.distances[cell] + share * (self.distances[cell + 1] - self.distances[cell]);
        chord + self.way(off)
    }

    /// What a way (m) off the trace adds to the distance at the least.
    #[inline]
    pub fn way(&self, off: f64) -> f64 {
        if off > 0.0 { self.cosine * off } else { off }
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
