//! Rows of balls or rollers with five degrees of freedom, and the pair of main bearings of two rows.

use nalgebra::{SMatrix, SVector};

use super::DynamicsError;
use super::mechanism::{AXIAL, ElementLoad, ROW, RingPose, RollingBearing, SLOPE};
use crate::machine::{Machine, MainRows};

/// Displacement (x, y, z in m, φ_x, φ_y in rad) of the inner relative to the outer ring, or the corresponding
/// load on the inner ring (N, N·m), referred to the middle of the pair.
pub type RingVector = SVector<f64, 5>;

/// Elastic energy of a bearing, its gradient (the load on the inner ring) and Hessian (the stiffness).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingState {
    /// Elastic energy, J.
    pub stored: f64,
    /// Load on the inner ring, N and N·m.
    pub load: RingVector,
    /// ∂(load)/∂(displacement), N/m, N/rad and N·m/rad.
    pub stiffness: SMatrix<f64, 5, 5>,
}

/// The five coordinates among the variables of a bearing, each with its sign: the slope is (φ_y, −φ_x).
const VARIABLES: [(usize, f64); 5] = [(0, 1.0), (1, 1.0), (AXIAL, 1.0), (SLOPE + 1, -1.0), (SLOPE, 1.0)];

impl RollingBearing {
    fn ring_pose(displacement: &RingVector) -> RingPose {
        let [x, y, axial, about_x, about_y] = displacement.data.0[0];
        RingPose { shift: [x, y], slope: Some([about_y, -about_x]), axial, ..RingPose::default() }
    }

    /// Energy, load and stiffness of a row at a displacement.
    pub fn react(&self, displacement: &RingVector) -> RingState {
        let state = self.react_at::<ROW>(&RollingBearing::ring_pose(displacement), true);
        RingState {
            stored: state.stored,
            load: RingVector::from(VARIABLES.map(|(at, sign)| sign * state.gradient[at])),
            stiffness: SMatrix::from_fn(|i, j| {
                let [(row, of_row), (column, of_column)] = [VARIABLES[i], VARIABLES[j]];
                of_row * of_column * state.hessian[row][column]
            }),
        }
    }

    /// Load of every element of a row at a displacement.
    pub fn elements(&self, displacement: &RingVector) -> Vec<ElementLoad> {
        self.loads(RollingBearing::ring_pose(displacement)).collect()
    }
}

/// Two rows in opposed arrangement between carrier (inner rings) and housing.
#[derive(Debug, Clone, PartialEq)]
pub struct MainBearings {
    /// At the output and at the input end.
    pub rows: [RollingBearing; 2],
}

/// Equilibrium of the pair under a load.
#[derive(Debug, Clone, PartialEq)]
pub struct MainBalance {
    /// Displacement of the carrier with the inner rings relative to the housing.
    pub displacement: RingVector,
    /// Energy, load and stiffness of the pair there.
    pub state: RingState,
    /// Elements of both rows.
    pub elements: [Vec<ElementLoad>; 2],
}

const ITERATIONS: usize = 200;
/// Relative to the load, or to the internal force of a preloaded pair.
const TOLERANCE: f64 = 1e-10;

impl MainBearings {
    /// The main bearings of a machine at its temperature.
    pub fn of(machine: &Machine) -> MainBearings {
        let mut pair = machine.solids.main_rows.clone();
        pair.preload += machine.thermal.preload_growth(machine);
        MainBearings::new(&pair)
    }

    /// The same with elements `factor` times stiffer.
    pub fn stiffened(mut self, factor: f64) -> MainBearings {
        self.rows.iter_mut().for_each(|row| row.stiffness *= factor);
        self
    }

    /// The pair as designed with its preload, each row at half the spacing from the middle.
    pub fn new(pair: &MainRows) -> MainBearings {
        let height = 0.5 * pair.spacing;
        // Back to back, contact lines diverge: the upper row supports the inner ring against downward motion.
        let facing = if pair.back_to_back { -1.0 } else { 1.0 };
        let row = |side: f64| RollingBearing::row(&pair.row, side * height, side * facing, pair.preload);
        MainBearings { rows: [row(1.0), row(-1.0)] }
    }

    /// Both rows together.
    pub fn react(&self, displacement: &RingVector) -> RingState {
        let (first, second) = (self.rows[0].react(displacement), self.rows[1].react(displacement));
        RingState {
            stored: first.stored + second.stored,
            load: first.load + second.load,
            stiffness: first.stiffness + second.stiffness,
        }
    }

    /// The displacement under a load, by Newton's method on the energy with monotonic decrease.
    ///
    /// # Errors
    /// [`DynamicsError::InvalidValue`] if the rows cannot support the load (excessive clearance).
    pub fn balance(&self, load: &RingVector) -> Result<MainBalance, DynamicsError> {
        let mut at = RingVector::zeros();
        let still = self.react(&at);
        let own = self.rows[0].react(&at).load.norm();
        let radius = self.rows[0].pitch_radius;
        // Moments are converted to forces at the pitch circle.
        let size = |f: &RingVector| f.fixed_rows::<3>(0).norm() + f.fixed_rows::<2>(3).norm() / radius;
        let scale = size(load).max(own).max(1e-6);
        let mut state = still;
        let mut residual = size(&(load - state.load));
        // A pair with clearance has no contact initially: a spring far softer than any contact moves it into
        // contact.
        let lead = 1e-6
            * self.rows[0].stiffness.powf(1.0 / self.rows[0].exponent)
            * scale.powf(1.0 - 1.0 / self.rows[0].exponent);
        for _ in 0..ITERATIONS {
            if residual <= TOLERANCE * scale {
                let elements = [0, 1].map(|row| self.rows[row].elements(&at));
                return Ok(MainBalance { displacement: at, state, elements });
            }
            let soft = if residual > 1e-3 * scale { lead } else { 0.0 };
            let mut tangent = state.stiffness;
            (0..5).for_each(|i| tangent[(i, i)] += soft * if i < 3 { 1.0 } else { radius * radius });
            let Some(step) = tangent.lu().solve(&(load - state.load)) else { break };
            let energy = |s: &RingState, q: &RingVector| s.stored - load.dot(q);
            let before = energy(&state, &at);
            let mut share = 1.0;
            loop {
                let next = at + share * step;
                let there = self.react(&next);
                let left = size(&(load - there.load));
                let lower = energy(&there, &next) <= before + 1e-14 * before.abs();
                if lower || left < residual || share < 1e-6 {
                    (at, state, residual) = (next, there, left);
                    break;
                }
                share *= 0.5;
            }
        }
        Err(DynamicsError::InvalidValue {
            name: "load on the main bearings",
            value: size(load),
            unit: "N",
            requirement: "has no equilibrium: the rows have too much clearance or too little stiffness",
        })
    }
}

impl MainBalance {
    /// dM/dφ in N·m/rad for tilts about x and y, with all other displacements free.
    pub fn moment_stiffness(&self) -> [f64; 2] {
        let follow = self.state.stiffness.try_inverse();
        [3, 4].map(|axis| follow.map_or(0.0, |inverse| 1.0 / inverse[(axis, axis)]))
    }

    /// Largest force on a rolling element, N.
    pub fn largest_element(&self) -> f64 {
        self.elements.iter().flatten().fold(0.0, |most, element| most.max(element.force))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{RollerBearing, RollerKind};

    fn row(kind: RollerKind, count: usize, angle_deg: f64) -> RollerBearing {
        RollerBearing {
            kind,
            roller_count: count,
            roller_diameter: 5e-3,
            roller_length: 5e-3,
            pitch_diameter: 136e-3,
            contact_angle: angle_deg.to_radians(),
            clearance: 0.0,
            dynamic_load_rating: None,
        }
    }

    fn pair(kind: RollerKind, back_to_back: bool) -> MainBearings {
        let rows = MainRows { row: row(kind, 80, 40.0), spacing: 40e-3, preload: 8e-6, back_to_back };
        MainBearings::new(&rows)
    }

    /// Load and stiffness agree with differences of the energy, for balls and rollers, and the stiffness is
    /// symmetric.
    #[test]
    fn loads_derive_from_the_energy() {
        for kind in [RollerKind::Ball, RollerKind::Tapered] {
            let pair = pair(kind, true);
            let at = RingVector::from([3e-6, -2e-6, 1.5e-6, 4e-5, -3e-5]);
            let state = pair.react(&at);
            for i in 0..5 {
                let step = if i < 3 { 1e-10 } else { 1e-9 };
                let (mut ahead, mut behind) = (at, at);
                ahead[i] += step;
                behind[i] -= step;
                let (ahead, behind) = (pair.react(&ahead), pair.react(&behind));
                let load = (ahead.stored - behind.stored) / (2.0 * step);
                let scale = state.load[i].abs().max(1.0);
                assert!(
                    (load - state.load[i]).abs() < 1e-5 * scale,
                    "{kind:?} {i}: {load} {}",
                    state.load[i]
                );
                for j in 0..5 {
                    let k = (ahead.load[j] - behind.load[j]) / (2.0 * step);
                    let scale = (state.stiffness[(i, i)] * state.stiffness[(j, j)]).sqrt();
                    assert!((k - state.stiffness[(j, i)]).abs() < 1e-3 * scale, "{kind:?} {i} {j}: {k:e}");
                    assert!((state.stiffness[(i, j)] - state.stiffness[(j, i)]).abs() < 1e-12 * scale);
                }
            }
        }
    }

    /// Axial load only (Harris, eq. 7.33): F_a/(Z K A^1.5) = sin α (cos α₀/cos α − 1)^1.5, equal for all balls.
    #[test]
    fn val_contact_angle_under_axial_load_agrees_with_harris() {
        let given = row(RollerKind::Ball, 30, 30.0);
        let single = RollingBearing::row(&given, 0.0, 1.0, 0.0);
        let apart = 0.04 * given.roller_diameter;
        for axial in [2e-6, 20e-6, 60e-6] {
            let at = RingVector::from([0.0, 0.0, axial, 0.0, 0.0]);
            let load = single.react(&at).load;
            let contact = single.elements(&at)[7].contact;
            let shape = given.contact_angle.cos() / contact.x - 1.0;
            let expected = 30.0 * single.stiffness * apart.powf(1.5) * contact.y * shape.powf(1.5);
            assert!((load[2] / expected - 1.0).abs() < 1e-9, "{} {expected}", load[2]);
            assert!(load[0].abs() < 1e-9 * load[2] && load[3].abs() < 1e-9 * load[2]);
        }
    }

    /// A radial load on a row without clearance and contact angle: Q_max = 4.37 F/Z of balls, 4.08 F/Z of
    /// rollers (Stribeck, Sjövall's integrals 0.2288 and 0.2453).
    #[test]
    fn val_radial_load_agrees_with_stribeck() {
        for (kind, integral) in [(RollerKind::Ball, 0.2288), (RollerKind::Cylindrical, 0.2453)] {
            let single = RollingBearing::row(&row(kind, 200, 0.0), 0.0, 1.0, 0.0);
            let at = RingVector::from([1e-6, 0.0, 0.0, 0.0, 0.0]);
            let force = single.react(&at).load[0];
            let most = single.elements(&at).iter().fold(0.0_f64, |most, e| most.max(e.force));
            // The elements are discrete; at α = 0 a radial load does not change a ball's contact angle.
            assert!(
                (force / (200.0 * most * integral) - 1.0).abs() < 3e-3,
                "{kind:?} {}",
                force / most / 200.0
            );
        }
    }

    /// Moment stiffness of a preloaded pair: K = 2 · ½ Z k ((R sin α ± h cos α)² + l²/12), + for back to back,
    /// k the tangent stiffness of one contact, exact for rollers of length l; radial K = Z k cos²α, axial 2 Z k
    /// sin²α. The tilt under a moment is moment over stiffness while all elements are loaded.
    #[test]
    fn val_moment_stiffness_of_a_preloaded_pair() {
        for (back_to_back, sign) in [(true, 1.0), (false, -1.0)] {
            let pair = pair(RollerKind::Tapered, back_to_back);
            let balance = pair.balance(&RingVector::zeros()).unwrap();
            let one = &pair.rows[0];
            let (cos, sin) = (one.contact.x, one.contact.y);
            let k = one.exponent * one.stiffness * (one.preload * sin).powf(one.exponent - 1.0);
            let lever = one.pitch_radius * sin + sign * 20e-3 * cos;
            let z = one.count as f64;
            for (found, expected) in [
                (balance.state.stiffness[(3, 3)], z * k * (lever * lever + one.reach * one.reach)),
                (balance.state.stiffness[(0, 0)], z * k * cos * cos),
                (balance.state.stiffness[(2, 2)], 2.0 * z * k * sin * sin),
            ] {
                assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
            }
            let moment = 20.0;
            let tilted = pair.balance(&RingVector::from([0.0, 0.0, 0.0, moment, 0.0])).unwrap();
            let stiffness = balance.moment_stiffness()[0];
            assert!((tilted.displacement[3] * stiffness / moment - 1.0).abs() < 0.02);
        }
    }

    /// The equilibrium reproduces the load, a rotated load rotates the displacement, and for a pair with
    /// clearance the equilibrium is found under axial force and moment.
    #[test]
    fn balances_under_combined_loads() {
        let pair = pair(RollerKind::Ball, true);
        let load = RingVector::from([800.0, 0.0, 3000.0, 0.0, 900.0]);
        let found = pair.balance(&load).unwrap();
        assert!((found.state.load - load).norm() < 1e-6, "{}", found.state.load - load);
        let turned = pair.balance(&RingVector::from([0.0, 800.0, 3000.0, -900.0, 0.0])).unwrap();
        assert!((turned.displacement[3] + found.displacement[4]).abs() < 1e-9 * found.displacement[4].abs());
        assert!((turned.displacement[1] / found.displacement[0] - 1.0).abs() < 1e-9);
        let loose = MainRows {
            row: row(RollerKind::Ball, 80, 40.0),
            spacing: 40e-3,
            preload: -5e-6,
            back_to_back: true,
        };
        let found = MainBearings::new(&loose).balance(&load).unwrap();
        assert!((found.state.load - load).norm() < 1e-5 && found.largest_element() > 0.0);
        // With preload both rows carry a moment: the tilt is smaller.
        let tight = MainBearings::new(&MainRows { preload: 10e-6, ..loose });
        assert!(tight.balance(&load).unwrap().displacement[4].abs() < found.displacement[4].abs());
    }
}
