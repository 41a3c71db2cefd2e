//! Tangent compliance of a machine in equilibrium, and easier problems on the way to a difficult equilibrium.

use super::Mechanism;
use super::joints::Joint;
use crate::dynamics::{DenseLinearisation, System, Weights};

/// Squares of 10 and 100 rad/s: at these frequencies the inertia of a body is about 1e-6 and 1e-4 of any
/// contact stiffness.
const SLOW: [f64; 2] = [1e2, 1e4];

impl Mechanism {
    /// dq/dT per unit of torque at the output (rad/(N·m), m/(N·m)), without friction. A body without contact,
    /// within its clearance, carries no force, but its position has no stiffness; a small inertia keeps it in
    /// place. `None` if the output itself has no stiffness.
    pub(crate) fn motion_per_torque(&self, position: &[f64]) -> Option<Vec<f64>> {
        let mut linearisation = self.linearisation_at_rest();
        self.forces_at_rest(position, &mut linearisation);
        // The tangent of the equilibrium search omits small terms (for example of flank error slopes). For
        // bodies with little stiffness these are decisive.
        self.motion_by(&mut linearisation)
            .or_else(|| self.motion_by(&mut self.tangent_by_differences(position, linearisation)))
    }

    pub(in crate::dynamics) fn motion_by(&self, linearisation: &mut DenseLinearisation) -> Option<Vec<f64>> {
        let output = self.output_index();
        [0.0, SLOW[0], SLOW[1]].into_iter().find_map(|mass| {
            let mut motion = vec![0.0; self.size()];
            motion[output] = 1.0;
            let weights = Weights { mass, damping: 0.0, stiffness: 1.0 };
            linearisation.solve(self.mass(), weights, &mut motion).ok()?;
            (motion[output] > 0.0 && motion[output] < LOOSE).then_some(motion)
        })
    }

    pub(in crate::dynamics) fn forces_at_rest(
        &self,
        position: &[f64],
        linearisation: &mut DenseLinearisation,
    ) -> Vec<f64> {
        let mut force = vec![0.0; position.len()];
        self.evaluate(0.0, position, &vec![0.0; position.len()], &mut force, linearisation);
        force
    }

    /// −∂Q/∂q by central differences, or from `known` for a held coordinate, which does not change any force.
    pub(in crate::dynamics) fn tangent_by_differences(
        &self,
        position: &[f64],
        mut known: DenseLinearisation,
    ) -> DenseLinearisation {
        let mut scratch = self.linearisation_at_rest();
        let mut place = position.to_vec();
        for (column, scale) in self.scale().iter().enumerate() {
            let step = DIFFERENCE * scale;
            let [ahead, behind] = [step, -step].map(|shift| {
                place[column] = position[column] + shift;
                self.forces_at_rest(&place, &mut scratch)
            });
            place[column] = position[column];
            if ahead == behind {
                continue;
            }
            for (row, (ahead, behind)) in ahead.iter().zip(&behind).enumerate() {
                let slope = (behind - ahead) / (2.0 * step);
                known.add_stiffness(row, column, slope - known.stiffness(row, column));
            }
        }
        known
    }

    /// Multiplies all friction and drag by a factor.
    pub(in crate::dynamics) fn scale_friction(&mut self, share: f64) {
        self.joints.iter_mut().for_each(|joint| joint.scale_friction(share));
        self.rings.iter_mut().for_each(|ring| ring.scale_friction(share));
        self.resistance.drag *= share;
        self.resistance.oil.1 *= share;
    }
}

/// Step of differences in units of scale: far above rounding, and below the scale on which contacts change.
const DIFFERENCE: f64 = 1e-5;
/// Compliance in rad/(N·m) above which an output counts as having no stiffness.
const LOOSE: f64 = 1.0;
