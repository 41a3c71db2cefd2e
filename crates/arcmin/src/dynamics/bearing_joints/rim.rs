//! Outer raceways that go out of round under their rollers.

use std::f64::consts::TAU;

use super::{BearingState, RadialBearing};
use crate::fem::carrier::{RIM_ORDER, RIM_WAYS};
use crate::geometry::{Vec2, turned, unit};

/// Coordinates of a rim: expansion, then cosine and sine of the orders 2 to [`RIM_ORDER`].
pub(super) const RIM: usize = RIM_WAYS;
/// Displacement of the inner ring (x, y), angle of the cage, angle of the rim's body, ways of the rim, slope of the
/// inner against the outer ring (x, y).
pub(super) const VARIABLES: usize = 4 + RIM + 2;
pub(super) const CAGE: usize = 2;
pub(super) const BODY: usize = 3;
pub(super) const WAYS: usize = 4;
pub(super) const SLOPE: usize = WAYS + RIM;

/// A rim at one state: w(ψ) = w₀ + Σ_n a_n cos n(ψ − χ) + b_n sin n(ψ − χ) outward, in m, χ the angle of its
/// zero.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct OutOfRound {
    pub angle: f64,
    pub ways: [f64; RIM],
}

impl OutOfRound {
    /// Shapes in the direction e(ψ − χ) with their first and second derivatives.
    fn shapes(direction: Vec2) -> [[f64; RIM]; 3] {
        let mut shapes = [[0.0; RIM]; 3];
        shapes[0][0] = 1.0;
        let mut multiple = direction;
        for order in 2..=RIM_ORDER {
            let n = order as f64;
            multiple = turned(multiple, direction);
            let (sin, cos) = (multiple.y, multiple.x);
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
        self.sum(&OutOfRound::shapes(unit(angle - self.angle))[0])
    }
}

/// How the rings of a bearing stand to each other.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Stand {
    /// Displacement of the inner ring in m.
    pub shift: [f64; 2],
    /// rad.
    pub cage: f64,
    /// The outer raceway, where it is not round.
    pub rim: Option<OutOfRound>,
    /// ∂(shift)/∂z along the axis, where the rings lean against each other.
    pub slope: Option<[f64; 2]>,
}

/// Energy of a bearing in a rim or with rings that lean, gradient and Hessian over [`VARIABLES`].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct StandState {
    pub stored: f64,
    pub gradient: [f64; VARIABLES],
    pub hessian: [[f64; VARIABLES]; VARIABLES],
    pub largest_element: f64,
    pub loaded: usize,
}

impl StandState {
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

    /// Adds `force` w and its tangent `stiffness` w wᵀ, if any, for the gradient w of an approach.
    fn add(&mut self, force: f64, stiffness: Option<f64>, way: &[f64; VARIABLES]) {
        for a in 0..VARIABLES {
            self.gradient[a] += force * way[a];
        }
        let Some(stiffness) = stiffness else { return };
        for a in 0..VARIABLES {
            let share = stiffness * way[a];
            for b in 0..VARIABLES {
                self.hessian[a][b] += share * way[b];
            }
        }
    }

    fn add_bend(&mut self, a: usize, b: usize, value: f64) {
        self.hessian[a][b] += value;
        if a != b {
            self.hessian[b][a] += value;
        }
    }
}

/// A slice of a roller: what it bears of the roller's stiffness, and where it is, in units of [`RadialBearing::reach`].
type Slice = (f64, f64);
/// Rings that do not lean press rollers alike along their length; those that do by the law of the mean of two places
/// l/√12 from the middle (Gauss), right to second order in the lean.
const STRAIGHT: &[Slice] = &[(1.0, 0.0)];
const LEANING: &[Slice] = &[(0.5, -1.0), (0.5, 1.0)];

impl Stand {
    fn slices(&self) -> &'static [Slice] {
        if self.slope.is_some() { LEANING } else { STRAIGHT }
    }
}

impl RadialBearing {
    /// State of a bearing whose outer ring may be out of round and whose rings may lean:
    /// δ_i(z) = cos α (u·e(ψ_i) + z σ·e(ψ_i) − c/2 − w(ψ_i)), σ the slope. The Hessian stays zero where no tangents are
    /// asked for.
    pub(super) fn react_at(&self, stand: &Stand, tangents: bool) -> StandState {
        let mut state = StandState {
            stored: 0.0,
            gradient: [0.0; VARIABLES],
            hessian: [[0.0; VARIABLES]; VARIABLES],
            largest_element: 0.0,
            loaded: 0,
        };
        let (cosine, u, rim) = (self.contact_cosine, stand.shift, stand.rim.unwrap_or_default());
        let slope = stand.slope.unwrap_or_default();
        let (step, on_body) = (unit(TAU / self.count as f64), unit(-rim.angle));
        let mut next = unit(stand.cage);
        for _ in 0..self.count {
            let e = next;
            next = turned(e, step);
            let [along, across] = [u[0] * e.x + u[1] * e.y, u[1] * e.x - u[0] * e.y];
            let [tilt, turn_of_tilt] = [slope[0] * e.x + slope[1] * e.y, slope[1] * e.x - slope[0] * e.y];
            let lift = self.reach * tilt.abs();
            // A round rim has no ways; whether it has is not asked per element.
            let farthest = along + lift - self.half_clearance;
            if stand.rim.is_none() && farthest <= 0.0 {
                continue;
            }
            let [shape, bend, curve] = OutOfRound::shapes(turned(e, on_body));
            let gap = self.half_clearance + rim.sum(&shape);
            if along + lift <= gap {
                continue;
            }
            let (turn_of_rim, curve_of_rim) = (rim.sum(&bend), rim.sum(&curve));
            let mut way = [0.0; VARIABLES];
            (0..RIM).for_each(|r| way[WAYS + r] = -shape[r]);
            let (mut whole, mut by_tilt, mut element) = (0.0, 0.0, 0.0);
            for (share, side) in stand.slices() {
                let z = side * self.reach;
                let approach = cosine * (along + z * tilt - gap);
                if approach <= 0.0 {
                    continue;
                }
                let force = share * self.stiffness * approach.powf(self.exponent);
                let radial = cosine * force;
                let k = tangents.then(|| cosine * cosine * self.exponent * force / approach);
                way[..4].copy_from_slice(&[e.x, e.y, across + z * turn_of_tilt - turn_of_rim, turn_of_rim]);
                (way[SLOPE], way[SLOPE + 1]) = (z * e.x, z * e.y);
                state.add(radial, k, &way);
                whole += radial;
                by_tilt += z * radial;
                element += force;
                state.stored += force * approach / (self.exponent + 1.0);
            }
            state.largest_element = state.largest_element.max(element);
            state.loaded += 1;
            if !tangents {
                continue;
            }
            let mut add = |a: usize, b: usize, value: f64| state.add_bend(a, b, value);
            add(0, CAGE, -whole * e.y);
            add(1, CAGE, whole * e.x);
            add(CAGE, CAGE, -whole * (along + curve_of_rim) - by_tilt * tilt);
            add(CAGE, BODY, whole * curve_of_rim);
            add(BODY, BODY, -whole * curve_of_rim);
            for r in 0..RIM {
                add(WAYS + r, CAGE, -whole * bend[r]);
                add(WAYS + r, BODY, whole * bend[r]);
            }
            add(SLOPE, CAGE, -by_tilt * e.y);
            add(SLOPE + 1, CAGE, by_tilt * e.x);
        }
        state
    }

    /// Q_i of all elements, whole ones, with the angles (rad) where they stand.
    pub(super) fn element_forces_at(&self, stand: Stand) -> impl Iterator<Item = (f64, f64)> + '_ {
        (0..self.count).map(move |i| {
            let angle = stand.cage + TAU * i as f64 / self.count as f64;
            let (e, u) = (unit(angle), stand.shift);
            let gap = self.half_clearance + stand.rim.map_or(0.0, |rim| rim.at(angle));
            let tilt = stand.slope.map_or(0.0, |slope| slope[0] * e.x + slope[1] * e.y);
            let slices = stand.slices().iter().map(|(share, side)| {
                let approach =
                    self.contact_cosine * (u[0] * e.x + u[1] * e.y + side * self.reach * tilt - gap);
                if approach > 0.0 { share * self.stiffness * approach.powf(self.exponent) } else { 0.0 }
            });
            (angle, slices.sum())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bearing() -> RadialBearing {
        RadialBearing::new(&crate::templates::tao2024().bearings.turning_arm, 1.0)
    }

    /// Gradient and Hessian are differences of the energy in all variables; a round rim changes nothing, and so do rings
    /// that do not lean.
    #[test]
    fn a_rim_derives_from_its_energy() {
        let bearing = bearing();
        let at = |z: &[f64; VARIABLES]| {
            let mut rim = OutOfRound { angle: z[BODY], ..OutOfRound::default() };
            rim.ways.copy_from_slice(&z[WAYS..SLOPE]);
            let slope = Some([z[SLOPE], z[SLOPE + 1]]);
            bearing.react_at(&Stand { shift: [z[0], z[1]], cage: z[CAGE], rim: Some(rim), slope }, true)
        };
        let mut z = [11e-6, 7e-6, 0.31, 0.2, 1e-6, 2e-6, -1e-6, 0.7e-6, 0.4e-6, -0.6e-6, 0.3e-6, 4e-4, -7e-4];
        let state = at(&z);
        assert!(state.loaded > 3);
        for a in 0..VARIABLES {
            // Exponent 10/9: elements that just lose contact are smooth enough for differences of 1e-3 of the
            // approach.
            let step = match a {
                CAGE | BODY => 1e-6,
                SLOPE.. => 1e-8,
                _ => 1e-10,
            };
            let (mut ahead, mut behind) = (z, z);
            ahead[a] += step;
            behind[a] -= step;
            let (ahead, behind) = (at(&ahead), at(&behind));
            let slope = (ahead.stored - behind.stored) / (2.0 * step);
            let unit = if a < SLOPE { 1.0 } else { bearing.reach };
            let scale = state.gradient[a].abs().max(1e-3 * unit * state.gradient[0].abs());
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

    /// Gradients of a bearing whose rings lean, with rollers as two slices and as forty, and the forces and couples that
    /// both are to be measured by.
    fn two_and_forty(bearing: &RadialBearing, shift: [f64; 2], slope: [f64; 2]) -> [[f64; 4]; 2] {
        let stand = Stand { shift, cage: 0.4, slope: Some(slope), ..Stand::default() };
        let two = bearing.react_at(&stand, true).gradient;
        let length = bearing.reach * 12.0_f64.sqrt();
        let mut forty = [0.0; 4];
        for i in 0..40 {
            let z = length * ((f64::from(i) + 0.5) / 40.0 - 0.5);
            let u = [shift[0] + z * slope[0], shift[1] + z * slope[1]];
            let slice = bearing.react(u, 0.4).gradient;
            (0..2).for_each(|a| forty[a] += slice[a] / 40.0);
            (0..2).for_each(|a| forty[2 + a] += z * slice[a] / 40.0);
        }
        [[two[0], two[1], two[SLOPE], two[SLOPE + 1]], forty]
    }

    fn assert_alike([two, forty]: [[f64; 4]; 2], of_force: f64, of_couple: f64) {
        let (force, couple) = (forty[0].hypot(forty[1]), forty[2].hypot(forty[3]));
        for (a, allowed) in
            [of_force * force, of_force * force, of_couple * couple, of_couple * couple].iter().enumerate()
        {
            assert!((two[a] - forty[a]).abs() < *allowed, "{two:?} {forty:?}");
        }
    }

    /// A roller as two slices bears what it bears as forty: force and couple of bearings whose rings lean so far that the
    /// ends of rollers are pressed up to half as much again.
    #[test]
    fn val_two_slices_of_a_roller_are_as_good_as_forty() {
        for (shift, slope) in
            [([9e-6, 5e-6], [3e-4, -2e-4]), ([12e-6, 0.0], [0.0, 4e-4]), ([8e-6, -3e-6], [-1e-4, 1e-4])]
        {
            assert_alike(two_and_forty(&bearing(), shift, slope), 2e-3, 0.02);
        }
    }

    /// In turning arms of random machines: within 0.3 % of the force and 5 % of the couple where rings lean so far that
    /// ends of rollers are pressed a sixth more. Where ends are pressed half as much again and others lifted off, two
    /// slices are 1 and 10 % apart from forty.
    #[test]
    fn val_two_slices_in_other_machines() {
        let random = (1..=20).map(|seed| crate::random_designs::sound_design(seed).0.machine());
        let rollers = random
            .chain([crate::templates::tao2024(), crate::templates::design("rv-80e").unwrap().machine()])
            .map(|machine| RadialBearing::new(&machine.bearings.turning_arm, 1.0))
            .filter(|bearing| bearing.reach > 0.0);
        let mut seen = 0;
        for bearing in rollers {
            let length = bearing.reach * 12.0_f64.sqrt();
            for (direction, lean, [of_force, of_couple]) in [
                (-0.4, [-0.3, 0.2], [3e-3, 0.05]),
                (0.0, [0.0, 0.3], [3e-3, 0.05]),
                (0.5, [0.8, -0.6], [0.012, 0.1]),
                (0.0, [0.0, 1.0], [0.012, 0.1]),
            ] {
                let pressed = 6e-6;
                let shift = unit(direction) * (bearing.half_clearance.max(0.0) + pressed);
                let shift = [shift.x, shift.y];
                let slope = lean.map(|share| share * pressed / length);
                assert_alike(two_and_forty(&bearing, shift, slope), of_force, of_couple);
                seen += 1;
            }
        }
        assert!(seen > 30, "{seen}");
    }
}
