//! Output error by cause in static equilibrium: virtual work with the forces of that equilibrium.

use super::BearingJoints;
use super::build::Bearings;
use super::labels::CAUSES;
use crate::dynamics::System;
use crate::dynamics::mechanism::{Cause, JointWear, Nominal, State};
use crate::load::LOST_MOTION_SHARE;
use crate::units::ARCMIN;
use crate::wear::PartLoads;

/// rad; residual work that corresponds to a smaller rotation of the lightly loaded output is neglected.
const NEGLIGIBLE: f64 = 1e-3 * ARCMIN;
/// Half of the width of a jump of forces, in units of scale: 1e-3' for angles, about 0.01 µm for displacements.
const JUMP_WIDTH: f64 = 1e-3;
/// Distances at which a jump is searched, as multiples of [`JUMP_WIDTH`], and number of bisections until both
/// its sides are known. If contacts jump, the equilibrium may be a micrometre beyond the end of the search,
/// along an edge.
const JUMP_DISTANCES: [f64; 6] = [1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0];
const BISECTIONS: usize = 30;

/// Largest number of jumps in the combination.
const MOST_JUMPS: usize = 20;

impl BearingJoints {
    /// Work (N·m·rad) of the forces of an equilibrium on the gap or the elastic approach of every joint, sorted
    /// by cause.
    ///
    /// The forces F_e of all joints balance the torque T at the output, so that for small displacements T φ = Σ
    /// F_e u_e, where each u_e is the initial gap plus the elastic approach: the causes add up to the whole
    /// except for terms of second order in the displacements.
    ///
    /// Wear is evaluated at the nominal position, extrapolated along the tangents of the gaps: near the root a
    /// contact moves far along a worn flank or pin until it is loaded, to depths different from the initial
    /// one. The difference between the unworn gaps extrapolated in this way and their nominal value, half their
    /// second derivative, is a separate cause. So is the work of a joint's forces on the straight displacement
    /// from the nominal position in excess of the work on its gaps: cranks move on circles, and a contact that
    /// moves to another curvature has a force along the flank. In a machine whose pins are loaded without
    /// torque each of the two may be a considerable part of the lost motion, and they nearly cancel.
    ///
    /// Exact for springs: Q δ = (n + 1) U for a roller, 2 U for linear springs. The work of manufacturing
    /// errors is that of F_e on the displacements by the errors in the nominal position; if they cause load
    /// without torque, elastic work and theirs are large and nearly cancel.
    ///
    /// If a pin is at a jump, between two contact points on a worn flank, the forces of either side alone are
    /// not in equilibrium: it touches both, and their combination is.
    pub fn causes(&self, position: &[f64]) -> [f64; CAUSES.len()] {
        let mut causes = self.causes_of_one_side(position);
        // Work of the joints less that of the load.
        let missing = causes.iter().sum::<f64>() + self.constant_load() * self.output_error(position);
        if missing.abs() <= NEGLIGIBLE * LOST_MOTION_SHARE * self.rated_torque() {
            return causes;
        }
        causes.fill(0.0);
        for (place, share) in self.sides_of_jumps(position) {
            let one = self.causes_of_one_side(&place);
            causes.iter_mut().zip(one).for_each(|(sum, cause)| *sum += share * cause);
        }
        causes
    }

    /// Positions near this equilibrium and their weights in a combination without residual. It is the
    /// equilibrium itself, unless forces jump there.
    ///
    /// The convex combination of forces with the smallest norm, by Gilbert's method (SIAM J. Control 4 (1966)
    /// 61): the residual points to the next jump, and the force beyond it is added with the weight that
    /// minimises the residual.
    fn sides_of_jumps(&self, position: &[f64]) -> Vec<(Vec<f64>, f64)> {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let rest = vec![0.0; position.len()];
        // As works along one unit of scale each, which are comparable.
        let works = |place: &[f64]| -> Vec<f64> {
            let mut force = rest.clone();
            self.evaluate_forces(0.0, place, &rest, &mut force);
            force.iter().zip(self.scale()).map(|(force, scale)| force * scale).collect()
        };
        let nominal = self.nominal_position_at(self.held_input());
        let displacement: Vec<f64> = position
            .iter()
            .zip(&nominal)
            .zip(self.scale())
            .map(|((q, from), scale)| (q - from) / scale)
            .collect();
        let negligible = NEGLIGIBLE * LOST_MOTION_SHARE * self.rated_torque();
        let (mut sides, mut left) = (vec![(position.to_vec(), 1.0)], works(position));
        let mut from = position.to_vec();
        for round in 0..MOST_JUMPS {
            if dot(&left, &displacement).abs() <= negligible {
                break;
            }
            let size = dot(&left, &left).sqrt();
            let place = |reach: f64| -> Vec<f64> {
                let steps =
                    left.iter().zip(self.scale()).map(|(work, scale)| JUMP_WIDTH * work / size * scale);
                from.iter().zip(steps).map(|(q, step)| q + reach * step).collect()
            };
            // The next jump on the way; there may be others beyond it.
            let turns_back = |reach: &f64| dot(&works(&place(*reach)), &left) <= 0.0;
            let Some(mut far) = JUMP_DISTANCES.into_iter().find(turns_back) else { break };
            let mut near = 0.0;
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (near + far);
                if turns_back(&middle) { far = middle } else { near = middle }
            }
            let (near, far) = (place(near), place(far));
            if round == 0 {
                (sides[0].0, left) = (near.clone(), works(&near));
                from = near;
            }
            let beyond = works(&far);
            let across: Vec<f64> = left.iter().zip(&beyond).map(|(left, beyond)| left - beyond).collect();
            let share = (dot(&left, &across) / dot(&across, &across)).clamp(0.0, 1.0);
            left.iter_mut().zip(&across).for_each(|(left, across)| *left -= share * across);
            sides.iter_mut().for_each(|side| side.1 *= 1.0 - share);
            sides.push((far, share));
        }
        sides
    }

    fn causes_of_one_side(&self, position: &[f64]) -> [f64; CAUSES.len()] {
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        let mut causes = [0.0; CAUSES.len()];
        let nominal = self.nominal_position_at(self.held_input());
        let nominal = self.full(0.0, &nominal, &vec![0.0; nominal.len()]).0;
        let nominal = Nominal { q: &nominal, has_errors: self.has_errors };
        let at = State { q: &q, v: &v };
        let mut add = |cause: Cause, work: f64| {
            if let Some(at) = CAUSES.iter().position(|own| *own == cause) {
                causes[at] += work;
            }
        };
        for joint in self.elements() {
            let mut counted = 0.0;
            joint.work(at, nominal, &mut |cause, work| {
                add(cause, work);
                counted += work;
            });
            add(Cause::CURVATURE, joint.work_on_displacement(at, nominal.q) - counted);
        }
        causes
    }

    /// Loads of bearings and gears in an equilibrium, as the means of each kind.
    pub fn part_loads(&self, position: &[f64]) -> PartLoads {
        let (q, v) = self.full(0.0, position, &vec![0.0; position.len()]);
        let Bearings { turning_arms, supports, gears, .. } = &self.bearings;
        let mean = |joints: &[usize]| {
            let mut mean = [0.0; 2];
            for joint in joints {
                let forces = self.joints[*joint].wearing_forces(State { q: &q, v: &v });
                mean.iter_mut().zip(forces).for_each(|(mean, force)| *mean += force / joints.len() as f64);
            }
            mean
        };
        let [turning_arm, crank_support] = [turning_arms, supports].map(|all| mean(&all.concat())[0]);
        PartLoads { turning_arm, crank_support, gears: mean(gears) }
    }

    /// Sets the external forces and moments on a tilting output.
    pub(super) fn set_output_forces(&mut self, forces: crate::machine::OutputForces) {
        self.joints.iter_mut().for_each(|joint| joint.set_output_forces(forces));
    }

    /// Sets the wear of bearings and gears.
    pub(super) fn set_part_wear(&mut self, wear: crate::machine::PartWear) {
        let Bearings { turning_arms, supports, gears, .. } = &self.bearings;
        let mut set = |joints: &[usize], wear: JointWear| {
            joints.iter().for_each(|joint| self.mechanism.joints[*joint].set_wear(wear));
        };
        set(&turning_arms.concat(), JointWear::Clearance(wear.turning_arm));
        set(&supports.concat(), JointWear::Clearance(wear.crank_support));
        set(gears, JointWear::ToothSides(wear.gears));
    }
}
