//! Foot points of several pins, computed in parallel lanes.

use super::foot::{LAST_STEP, Place, ROOT_ZONE_COS};
use super::{Foot, Profile, Vec2};

/// Number of pins searched at a time. The compiler keeps them in vector registers: two to a register on the
/// baseline of x86-64, four with AVX.
pub const LANES: usize = 4;

type Lanes = [f64; LANES];

/// Written out because calls of `std::array::from_fn` are not always inlined.
#[inline(always)]
fn lanes(value: impl Fn(usize) -> f64) -> Lanes {
    [value(0), value(1), value(2), value(3)]
}

/// A vector per pin.
#[derive(Clone, Copy)]
struct Vectors {
    x: Lanes,
    y: Lanes,
}

impl Vectors {
    #[inline(always)]
    fn of(vectors: &[Vec2; LANES]) -> Vectors {
        Vectors { x: lanes(|l| vectors[l].x), y: lanes(|l| vectors[l].y) }
    }

    /// Rotated by x ≤ 0.1 rad: series of sine and cosine, with errors below 1e-16.
    #[inline(always)]
    fn turned(&self, x: &Lanes) -> Vectors {
        let q = lanes(|l| x[l] * x[l]);
        let sin = lanes(|l| {
            x[l] * (1.0
                + q[l]
                    * (-1.0 / 6.0 + q[l] * (1.0 / 120.0 + q[l] * (-1.0 / 5040.0 + q[l] * (1.0 / 362_880.0)))))
        });
        let cos = lanes(|l| {
            1.0 + q[l]
                * (-0.5
                    + q[l]
                        * (1.0 / 24.0
                            + q[l] * (-1.0 / 720.0 + q[l] * (1.0 / 40_320.0 + q[l] * (-1.0 / 3_628_800.0)))))
        });
        Vectors {
            x: lanes(|l| self.x[l] * cos[l] - self.y[l] * sin[l]),
            y: lanes(|l| self.x[l] * sin[l] + self.y[l] * cos[l]),
        }
    }
}

/// Present state of the search for every pin: τ with e(τ) and e(z τ).
#[derive(Clone, Copy)]
struct Places {
    tau: Lanes,
    e: Vectors,
    ez: Vectors,
}

/// The trace under every pin: the pin centre from c(τ), c′ and c″.
struct Trace {
    off: Vectors,
    c1: Vectors,
    c2: Vectors,
}

/// One step of every pin's search.
struct Step {
    places: Places,
    /// z times the step.
    size: Lanes,
    /// Whether the step is accepted.
    good: [bool; LANES],
}

impl Profile {
    /// [`Profile::foot_from`] for several pins that share e(z·guess): two steps of Chebyshev's method for all
    /// of them together. Pins for which these do not converge, or which are near a root, are searched
    /// individually. `visit` is called with the feet of the first `count` pins in turn.
    #[inline]
    pub(crate) fn feet_from(
        &self,
        (p, guess, e): (&[Vec2; LANES], &Lanes, &[Vec2; LANES]),
        ez: Vec2,
        count: usize,
        mut visit: impl FnMut(usize, &Foot),
    ) {
        if let Some(tip) = &self.tip {
            (0..LANES.min(count)).for_each(|l| visit(l, &self.foot_below_tip(p[l], tip, guess[l])));
            return;
        }
        let pins = Vectors::of(p);
        let start =
            Places { tau: *guess, e: Vectors::of(e), ez: Vectors { x: [ez.x; LANES], y: [ez.y; LANES] } };
        let first = self.steps(&pins, &start);
        let second = self.steps(&pins, &first.places);
        let Places { tau, e: at, ez: at_z } = &second.places;
        let Trace { off, c1, c2 } = self.trace_under(&pins, &second.places);
        let per_speed = lanes(|l| 1.0 / (c1.x[l] * c1.x[l] + c1.y[l] * c1.y[l]).sqrt());
        let normal = Vectors { x: lanes(|l| c1.y[l] * per_speed[l]), y: lanes(|l| -c1.x[l] * per_speed[l]) };
        let distance = lanes(|l| off.x[l] * normal.x[l] + off.y[l] * normal.y[l]);
        let cos = lanes(|l| at.x[l] * at_z.x[l] + at.y[l] * at_z.y[l]);
        let sin = lanes(|l| at.y[l] * at_z.x[l] - at.x[l] * at_z.y[l]);
        let curvature =
            lanes(|l| (c1.y[l] * c2.x[l] - c1.x[l] * c2.y[l]) * per_speed[l] * per_speed[l] * per_speed[l]);
        for l in 0..LANES.min(count) {
            let home = first.good[l]
                && second.good[l]
                && second.size[l].abs() < LAST_STEP
                && cos[l] <= ROOT_ZONE_COS;
            if home {
                let foot = Foot {
                    tau: tau[l],
                    distance: distance[l],
                    normal: Vec2::new(normal.x[l], normal.y[l]),
                    cos_meshing: cos[l],
                    sin_meshing: sin[l],
                    trace_curvature: curvature[l],
                    at_tip: false,
                    place: Place {
                        tau: tau[l],
                        shared: true,
                        e: Vec2::new(at.x[l], at.y[l]),
                        ez: Vec2::new(at_z.x[l], at_z.y[l]),
                    },
                };
                visit(l, &foot);
            } else {
                visit(l, &self.foot_from(p[l], guess[l], e[l], ez));
            }
        }
    }

    /// Lower bounds (m) of the distance of pins from the trace, at the start of their search: the height above
    /// the tangent less the largest effect of the curvature; −∞ where the curvature may change considerably on
    /// the way to the foot. Second result: upper bound of the distance to the foot in rad of τ. For flanks that
    /// are smooth over the tip.
    #[inline]
    pub(crate) fn least_distances(&self, p: &[Vec2; LANES], e: &[Vec2; LANES], ez: Vec2) -> (Lanes, Lanes) {
        let ez = Vectors { x: [ez.x; LANES], y: [ez.y; LANES] };
        let Trace { off, c1, c2 } =
            self.trace_under(&Vectors::of(p), &Places { tau: [0.0; LANES], e: Vectors::of(e), ez });
        let per_speed = lanes(|l| 1.0 / (c1.x[l] * c1.x[l] + c1.y[l] * c1.y[l]).sqrt());
        let height = lanes(|l| (off.x[l] * c1.y[l] - off.y[l] * c1.x[l]) * per_speed[l]);
        let along = lanes(|l| (off.x[l] * c1.x[l] + off.y[l] * c1.y[l]) * per_speed[l]);
        let curvature = lanes(|l| {
            (c1.x[l] * c2.y[l] - c1.y[l] * c2.x[l]).abs() * per_speed[l] * per_speed[l] * per_speed[l]
        });
        let distances = lanes(|l| {
            let steady = curvature[l] * (height[l].abs() + along[l].abs()) < 0.3;
            if steady { height[l] - 2.0 * curvature[l] * along[l] * along[l] } else { f64::NEG_INFINITY }
        });
        // Where the curvature varies little, the foot moves by at most along/(1 − κ height).
        (distances, lanes(|l| 1.5 * along[l].abs() * per_speed[l]))
    }

    /// As [`Profile::trace_derivatives`].
    #[inline(always)]
    fn trace_under(&self, p: &Vectors, at: &Places) -> Trace {
        let (r, a, z) = (self.pin_circle_radius, self.eccentricity, self.pin_count as f64);
        let (az, azz) = (a * z, a * z * z);
        let Places { e, ez, .. } = at;
        Trace {
            off: Vectors {
                x: lanes(|l| p.x[l] - (r * e.x[l] - a * ez.x[l])),
                y: lanes(|l| p.y[l] - (r * e.y[l] - a * ez.y[l])),
            },
            c1: Vectors { x: lanes(|l| az * ez.y[l] - r * e.y[l]), y: lanes(|l| r * e.x[l] - az * ez.x[l]) },
            c2: Vectors {
                x: lanes(|l| azz * ez.x[l] - r * e.x[l]),
                y: lanes(|l| azz * ez.y[l] - r * e.y[l]),
            },
        }
    }

    #[inline(always)]
    fn steps(&self, p: &Vectors, at: &Places) -> Step {
        let (r, z) = (self.pin_circle_radius, self.pin_count as f64);
        let azzz = self.eccentricity * z * z * z;
        let Places { tau, e, ez } = at;
        let Trace { off, c1, c2 } = self.trace_under(p, at);
        let c3 =
            Vectors { x: lanes(|l| r * e.y[l] - azzz * ez.y[l]), y: lanes(|l| azzz * ez.x[l] - r * e.x[l]) };
        let value = lanes(|l| off.x[l] * c1.x[l] + off.y[l] * c1.y[l]);
        let slope =
            lanes(|l| off.x[l] * c2.x[l] + off.y[l] * c2.y[l] - (c1.x[l] * c1.x[l] + c1.y[l] * c1.y[l]));
        let bend = lanes(|l| {
            off.x[l] * c3.x[l] + off.y[l] * c3.y[l] - 3.0 * (c1.x[l] * c2.x[l] + c1.y[l] * c2.y[l])
        });
        let per_slope = lanes(|l| 1.0 / slope[l]);
        let newton = lanes(|l| -value[l] * per_slope[l]);
        let correction = lanes(|l| 0.5 * newton[l] * bend[l] * per_slope[l]);
        let step = lanes(|l| newton[l] * (1.0 - correction[l]));
        let size = lanes(|l| z * step[l]);
        // As for a single pin, but with 0.1 rad, the range of the series of sine and cosine. False for NaN.
        let good = |l: usize| slope[l] < 0.0 && size[l].abs() < 0.1 && correction[l].abs() <= 0.35;
        Step {
            places: Places { tau: lanes(|l| tau[l] + step[l]), e: e.turned(&step), ez: ez.turned(&size) },
            size,
            good: [good(0), good(1), good(2), good(3)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::unit;

    /// For any four neighbouring pins of a ring, near their nominal positions and away from them, including
    /// roots and tips: the same result as the search of single pins.
    #[test]
    fn feet_in_lanes_agree_with_single_searches() {
        let profile = Profile::new(40, 64e-3, 1.3e-3, 3e-3);
        for off in [0.0, 1e-7, 3e-6, 60e-6, 5e-4] {
            for index in 0..200 {
                let turn = 0.31 * index as f64;
                let ez = unit(-40.0 * turn);
                let guess: [f64; LANES] =
                    std::array::from_fn(|l| std::f64::consts::TAU * (index + l) as f64 / 40.0 - turn);
                let e = guess.map(unit);
                let p: [Vec2; LANES] = std::array::from_fn(|l| {
                    profile.trace(guess[l]) + off * unit(0.7 * (index + 3 * l) as f64)
                });
                profile.feet_from((&p, &guess, &e), ez, LANES, |l, foot| {
                    let alone = profile.foot_from(p[l], guess[l], e[l], ez);
                    assert!(
                        (foot.tau - alone.tau).abs() < 1e-12,
                        "{off} {index} {l}: {} {}",
                        foot.tau,
                        alone.tau
                    );
                    assert!(
                        (foot.distance - alone.distance).abs() < 1e-15,
                        "{off} {index} {l}: {} {}",
                        foot.distance,
                        alone.distance
                    );
                    // Effects of the same dτ: normals turn by κ |c′| dτ; the curvature increases from 0 to
                    // 14/mm within 0.01 rad.
                    let turn = 1e-12 * (1.0 + 0.12 * alone.trace_curvature.abs());
                    assert!((foot.normal - alone.normal).norm() < turn, "{off} {index} {l}");
                    assert!((foot.trace_curvature - alone.trace_curvature).abs() < 1e-6, "{off} {index} {l}");
                    assert!(
                        (foot.sin_meshing - alone.sin_meshing).abs() < 1e-10
                            && (foot.cos_meshing - alone.cos_meshing).abs() < 1e-10
                    );
                });
            }
        }
    }
}
