//! Static equilibria and energy balances for the tests of all drives of eccentrics.

use super::*;
use crate::dynamics::{EquilibriumControl, System, solve_equilibrium};

const CONTROL: EquilibriumControl = EquilibriumControl { tolerance: 1e-9, force_tolerance: 1e-9, held: None };

/// Coordinates of the static equilibrium under a torque with the input at an angle.
pub fn rest(joints: &mut EccentricJoints, angle: f64, torque: f64) -> Vec<f64> {
    joints.hold_input(angle, 0.0);
    joints.set_load(torque);
    let start = joints.nominal_position_at(angle);
    solve_equilibrium(&**joints, 0.0, &start, CONTROL).unwrap().position
}

/// Largest differences of forces and tangents from central differences of the stored energy and of the forces.
pub struct Differences {
    /// Of a force over one unit of scale of its coordinate, J.
    pub work: f64,
    /// Of a force over its own stiffness times that unit.
    pub force: f64,
    /// Of an entry of the tangent over the geometric mean of both stiffnesses.
    pub tangent: f64,
}

/// At rest with these coordinates under the torque that is set.
pub fn differences(joints: &EccentricJoints, q: &[f64], torque: f64) -> Differences {
    let (n, still) = (q.len(), vec![0.0; q.len()]);
    let (mut force, mut tangent) = (vec![0.0; n], joints.linearisation());
    joints.evaluate(0.0, q, &still, &mut force, &mut tangent);
    let mut largest = Differences { work: 0.0, force: 0.0, tangent: 0.0 };
    for i in 0..n {
        let scale = joints.scale()[i];
        let step = 1e-4 * scale;
        let at = |by: f64| {
            let mut q = q.to_vec();
            q[i] += by;
            let mut force = vec![0.0; n];
            let stored = joints.evaluate_forces(0.0, &q, &still, &mut force).stored;
            (stored, force)
        };
        let (ahead, behind) = (at(step), at(-step));
        let load = if i == joints.output_index() { torque } else { 0.0 };
        let off = ((behind.0 - ahead.0) / (2.0 * step) - load - force[i]).abs();
        largest.work = largest.work.max(off * scale);
        largest.force = largest.force.max(off / (tangent.stiffness(i, i) * scale));
        for j in 0..n {
            let slope = (behind.1[j] - ahead.1[j]) / (2.0 * step);
            let size = (tangent.stiffness(i, i) * tangent.stiffness(j, j)).abs().sqrt();
            largest.tangent = largest.tangent.max((slope - tangent.stiffness(j, i)).abs() / size);
        }
    }
    largest
}

/// At every angle the input work is the output work plus the change of stored energy: M dφ = T dθ + dU.
pub fn work_in_is_work_out(mut joints: EccentricJoints, torque: f64) {
    let (positions, step, mean) = (36, 1e-4, torque / joints.flanges().ratio);
    for position in 0..positions {
        let angle = 0.011 + std::f64::consts::TAU * position as f64 / positions as f64;
        let [behind, here, ahead] = [angle - step, angle, angle + step].map(|angle| {
            let q = rest(&mut joints, angle, torque);
            let (still, mut force) = (vec![0.0; q.len()], vec![0.0; joints.size()]);
            let (balance, input) = joints.evaluate_with_input(0.0, &q, &still, &mut force, None);
            (torque * q[joints.output_index()] + balance.stored, input)
        });
        let work = (ahead.0 - behind.0) / (2.0 * step);
        assert!((here.1 - work).abs() < 1e-5 * mean.abs(), "{angle}: {} {work} {mean}", here.1);
    }
}
