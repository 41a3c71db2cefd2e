//! Outer raceways that go out of round under their rollers.

use std::f64::consts::TAU;

use super::{BearingState, RadialBearing};
use crate::fem::carrier::{RIM_ORDER, SEAT_COORDINATES};
use crate::geometry::unit;

/// Coordinates of a rim: expansion, then cosine and sine of the orders 2 to [`RIM_ORDER`].
pub(super) const RIM: usize = SEAT_COORDINATES - 2;
/// Displacement of the inner ring (x, y), angle of the cage, angle of the rim's body, ways of the rim.
pub(super) const VARIABLES: usize = 4 + RIM;
const CAGE: usize = 2;
const BODY: usize = 3;
const WAYS: usize = 4;

/// A rim's coordinates among those of the model, and the angle of its zero on the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rim {
    pub coordinates: [usize; RIM],
    /// rad.
    pub phase: f64,
}

/// A rim at one state: w(ψ) = w₀ + Σ_n a_n cos n(ψ − χ) + b_n sin n(ψ − χ) outward, in m, χ the angle of its
/// zero.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct OutOfRound {
    pub angle: f64,
    pub ways: [f64; RIM],
}

impl OutOfRound {
    /// Shapes at the angle ψ with their first and second derivatives.
    fn shapes(&self, angle: f64) -> [[f64; RIM]; 3] {
        let mut shapes = [[0.0; RIM]; 3];
        shapes[0][0] = 1.0;
        for order in 2..=RIM_ORDER {
            let n = order as f64;
            let (sin, cos) = (n * (angle - self.angle)).sin_cos();
            let at = 2 * order - 3;
            (shapes[0][at], shapes[0][at + 1]) = (cos, sin);
            (shapes[1][at], shapes[1][at + 1]) = (-n * sin, n * cos);
            (shapes[2][at], shapes[2][at + 1]) = (-n * n * cos, -n * n * sin);
        }
        shapes
    }

    fn sum(&self, shapes: &[f64; RIM]) -> f64 {
        self.ways.iter().zip(shapes).map(|(way, shape)| way * shape).sum()
    }

    /// w at ψ in m.
    pub fn at(&self, angle: f64) -> f64 {
        self.sum(&self.shapes(angle)[0])
    }
}

/// Energy of a bearing in a rim, gradient and Hessian over [`VARIABLES`].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RimState {
    pub stored: f64,
    pub gradient: [f64; VARIABLES],
    pub hessian: [[f64; VARIABLES]; VARIABLES],
    pub largest_element: f64,
    pub loaded: usize,
}

impl RimState {
    /// What a round bearing in the same state would say.
    pub fn plain(&self) -> BearingState {
        let mut state = BearingState {
            stored: self.stored,
            largest_element: self.largest_element,
            loaded: self.loaded,
            ..BearingState::default()
        };
        for i in 0..3 {
            state.gradient[i] = self.gradient[i];
            state.hessian[i].copy_from_slice(&self.hessian[i][..3]);
        }
        state
    }
}

impl RadialBearing {
    /// State at the displacement u (m) of the inner ring and the cage angle ψ (rad) in a rim that gives way:
    /// δ_i = cos α (u·e(ψ_i) − c/2 − w(ψ_i)).
    pub(super) fn react_in_rim(&self, u: [f64; 2], cage: f64, rim: &OutOfRound) -> RimState {
        let mut state = RimState {
            stored: 0.0,
            gradient: [0.0; VARIABLES],
            hessian: [[0.0; VARIABLES]; VARIABLES],
            largest_element: 0.0,
            loaded: 0,
        };
        let cosine = self.contact_cosine;
        for i in 0..self.count {
            let angle = cage + TAU * i as f64 / self.count as f64;
            let e = unit(angle);
            let [shape, slope, curve] = rim.shapes(angle);
            let along = u[0] * e.x + u[1] * e.y;
            let approach = cosine * (along - self.half_clearance - rim.sum(&shape));
            if approach <= 0.0 {
                continue;
            }
            let force = self.stiffness * approach.powf(self.exponent);
            let radial = cosine * force;
            let k = cosine * cosine * self.exponent * force / approach;
            let (turn, bend) = (rim.sum(&slope), rim.sum(&curve));
            let across = -u[0] * e.y + u[1] * e.x;
            let mut way = [0.0; VARIABLES];
            way[..4].copy_from_slice(&[e.x, e.y, across - turn, turn]);
            (0..RIM).for_each(|r| way[WAYS + r] = -shape[r]);
            for a in 0..VARIABLES {
                state.gradient[a] += radial * way[a];
                for b in 0..VARIABLES {
                    state.hessian[a][b] += k * way[a] * way[b];
                }
            }
            let mut add = |a: usize, b: usize, value: f64| {
                state.hessian[a][b] += radial * value;
                if a != b {
                    state.hessian[b][a] += radial * value;
                }
            };
            add(0, CAGE, -e.y);
            add(1, CAGE, e.x);
            add(CAGE, CAGE, -along - bend);
            add(CAGE, BODY, bend);
            add(BODY, BODY, -bend);
            for r in 0..RIM {
                add(WAYS + r, CAGE, -slope[r]);
                add(WAYS + r, BODY, slope[r]);
            }
            state.stored += force * approach / (self.exponent + 1.0);
            state.largest_element = state.largest_element.max(force);
            state.loaded += 1;
        }
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bearing() -> RadialBearing {
        RadialBearing::new(&crate::templates::rv_40e_81().bearings.turning_arm, 1.0)
    }

    /// Gradient and Hessian are differences of the energy in all variables; a round rim changes nothing.
    #[test]
    fn a_rim_derives_from_its_energy() {
        let bearing = bearing();
        let at = |z: &[f64; VARIABLES]| {
            let mut rim = OutOfRound { angle: z[BODY], ..OutOfRound::default() };
            rim.ways.copy_from_slice(&z[WAYS..]);
            bearing.react_in_rim([z[0], z[1]], z[CAGE], &rim)
        };
        let mut z = [11e-6, 7e-6, 0.31, 0.2, 1e-6, 2e-6, -1e-6, 0.7e-6, 0.4e-6, -0.6e-6, 0.3e-6];
        let state = at(&z);
        assert!(state.loaded > 3);
        for a in 0..VARIABLES {
            // Exponent 10/9: elements that just lose contact are smooth enough for differences of 1e-3 of the
            // approach.
            let step = if a == CAGE || a == BODY { 1e-6 } else { 1e-10 };
            let (mut ahead, mut behind) = (z, z);
            ahead[a] += step;
            behind[a] -= step;
            let (ahead, behind) = (at(&ahead), at(&behind));
            let slope = (ahead.stored - behind.stored) / (2.0 * step);
            let scale = state.gradient[a].abs().max(1e-3 * state.gradient[0].abs());
            assert!(
                (slope - state.gradient[a]).abs() < 1e-4 * scale,
                "{a}: {slope:e} {:e}",
                state.gradient[a]
            );
            for b in 0..VARIABLES {
                let slope = (ahead.gradient[b] - behind.gradient[b]) / (2.0 * step);
                let scale = (state.hessian[a][a] * state.hessian[b][b]).abs().sqrt();
                assert!((slope - state.hessian[a][b]).abs() < 1e-3 * scale, "{a} {b}: {slope:e}");
            }
        }
        z[WAYS..].fill(0.0);
        let (round, plain) = (at(&z).plain(), bearing.react([z[0], z[1]], z[CAGE]));
        assert!((round.stored / plain.stored - 1.0).abs() < 1e-12);
        assert!((round.gradient[1] / plain.gradient[1] - 1.0).abs() < 1e-12);
        // Expansion is clearance.
        z[WAYS] = 1e-6;
        let mut wider = bearing.clone();
        wider.widen(2e-6);
        assert!((at(&z).stored / wider.react([z[0], z[1]], z[CAGE]).stored - 1.0).abs() < 1e-12);
    }
}
