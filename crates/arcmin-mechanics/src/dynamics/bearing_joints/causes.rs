//! Output error by cause in a state of balance: virtual work with the forces of that very balance.

use super::BearingJoints;
use super::build::Bearings;
use super::labels::CAUSES;
use crate::dynamics::System;
use crate::dynamics::mechanism::{Cause, JointWear, Nominal, State};
use crate::load::LOST_MOTION_SHARE;
use crate::units::ARCMIN;
use crate::wear::PartLoads;

/// rad; work that is left of a balance and would turn the lightly loaded output by less is not looked at.
const UNSEEN: f64 = 1e-3 * ARCMIN;
/// Half of the width of a jump, in units of scale: 1e-3' of angles, some 0.01 µm of places.
const JUMP_WIDTH: f64 = 1e-3;
/// Where a jump is looked for, as shares of [`JUMP_WIDTH`], some 0.01 µm, and halvings of the way until both its
/// sides are known. Where contacts jump, a balance may lie a micrometre further along an edge than the search went.
const REACHES: [f64; 6] = [1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0];
const BISECTIONS: usize = 30;

/// Jumps mixed in at most.
const MOST_JUMPS: usize = 20;

impl BearingJoints {
    /// Work (N·m·rad) of the forces of a balance on the gap or the elastic approach of every joint, sorted by
    /// cause.
    ///
    /// The forces F_e of all joints balance the torque T at the output, so for small displacements T φ = Σ
    /// F_e u_e, and each u_e is the gap that was there plus the elastic approach: causes add up to the whole
    /// but for terms of second order in the displacements. Wear is counted at the nominal place, back along the
    /// tangents of the gaps: near the root a contact goes a long way along a worn flank or pin until it carries,
    /// to other depths than where it was. What the unworn gaps miss of their nominal value that way, half their
    /// second derivative, is a cause of its own, and so is what a joint's forces do on the straight way from the
    /// nominal place beyond the work on its gaps: cranks go in circles, and a contact that rolls to another
    /// curvature is pulled along the flank. In a machine whose pins press without load each of the two may be a
    /// good part of the lost motion, and they nearly cancel. Exact for springs: Q δ = (n + 1) U of a roller, 2 U of
    /// linear springs. Manufacturing errors do the work of F_e on what they displace in the nominal place; where
    /// they press parts together without load, elastic work and theirs are large and nearly cancel.
    ///
    /// Where a pin stands at a jump, in a place of a worn flank that it touches on one side or the other, the
    /// forces of either side alone balance nothing: it bears on both, so that they do.
    pub fn causes(&self, position: &[f64]) -> [f64; CAUSES.len()] {
        let mut causes = self.causes_of_one_side(position);
        // Work of the joints less that of the load.
        let missing = causes.iter().sum::<f64>() + self.constant_load() * self.output_error(position);
        if missing.abs() <= UNSEEN * LOST_MOTION_SHARE * self.rated_torque() {
            return causes;
        }
        causes.fill(0.0);
        for (place, share) in self.sides_of_jumps(position) {
            let one = self.causes_of_one_side(&place);
            causes.iter_mut().zip(one).for_each(|(sum, cause)| *sum += share * cause);
        }
        causes
    }

    /// Places around this balance, and their shares in one that leaves no forces. It is the balance by itself, unless
    /// forces jump there.
    ///
    /// The least convex combination of forces, by Gilbert's method (SIAM J. Control 4 (1966) 61): what is left points
    /// to the next jump, and the force behind it is mixed in by the share that leaves the least.
    fn sides_of_jumps(&self, position: &[f64]) -> Vec<(Vec<f64>, f64)> {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let rest = vec![0.0; position.len()];
        // As works along one unit of scale each, which compare.
        let works = |place: &[f64]| -> Vec<f64> {
            let mut force = rest.clone();
            self.evaluate_forces(0.0, place, &rest, &mut force);
            force.iter().zip(self.scale()).map(|(force, scale)| force * scale).collect()
        };
        let nominal = self.nominal_position_at(self.held_input());
        let way: Vec<f64> = position
            .iter()
            .zip(&nominal)
            .zip(self.scale())
            .map(|((q, from), scale)| (q - from) / scale)
            .collect();
        let unseen = UNSEEN * LOST_MOTION_SHARE * self.rated_torque();
        let (mut sides, mut left) = (vec![(position.to_vec(), 1.0)], works(position));
        let mut from = position.to_vec();
        for round in 0..MOST_JUMPS {
            if dot(&left, &way).abs() <= unseen {
                break;
            }
            let size = dot(&left, &left).sqrt();
            let place = |reach: f64| -> Vec<f64> {
                let steps =
                    left.iter().zip(self.scale()).map(|(work, scale)| JUMP_WIDTH * work / size * scale);
                from.iter().zip(steps).map(|(q, step)| q + reach * step).collect()
            };
            // The next jump on the way: behind it there may be others.
            let turns_back = |reach: &f64| dot(&works(&place(*reach)), &left) <= 0.0;
            let Some(mut far) = REACHES.into_iter().find(turns_back) else { break };
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
            add(Cause::CURVATURE, joint.work_on_the_way(at, nominal.q) - counted);
        }
        causes
    }

    /// Loads of bearings and gears at a balance, means of all of a kind.
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

    /// Replaces what tilts and pulls an output that leans.
    pub(super) fn set_output_forces(&mut self, forces: crate::machine::OutputForces) {
        self.joints.iter_mut().for_each(|joint| joint.set_output_forces(forces));
    }

    /// Replaces what bearings and gears have lost.
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
