//! How a machine in balance yields, and easier machines on the way to a hard one.

use super::BearingJoints;
use crate::contact::Sliding;
use crate::dynamics::{Linearisation, System, Weights};

/// Squares of 10 and 100 rad/s: inertia of a body at such a pace is some 1e-6 and 1e-4 of any contact's stiffness.
const SLOW: [f64; 2] = [1e2, 1e4];

impl BearingJoints {
    /// dq/dT per unit of torque applied at the output (rad/(N·m), m/(N·m)), friction left aside. A body that no
    /// contact holds, in the middle of its clearance, takes no force, but its place is not defined by
    /// stiffness; its inertia then keeps it where it is. `None` where not even the output is held.
    pub(crate) fn motion_per_torque(&self, position: &[f64]) -> Option<Vec<f64>> {
        let n = position.len();
        let rest = vec![0.0; n];
        let mut force = vec![0.0; n];
        let mut linearisation = self.linearisation();
        self.evaluate(0.0, position, &rest, &mut force, &mut linearisation);
        let output = self.output_index();
        [0.0, SLOW[0], SLOW[1]].into_iter().find_map(|mass| {
            let mut motion = vec![0.0; n];
            motion[output] = 1.0;
            let weights = Weights { mass, damping: 0.0, stiffness: 1.0 };
            linearisation.solve(self.mass(), weights, &mut motion).ok()?;
            (motion[output] > 0.0 && motion[output] < LOOSE).then_some(motion)
        })
    }

    /// The same machine with all friction and drag multiplied by `share`.
    pub(crate) fn with_friction(&self, share: f64) -> BearingJoints {
        let mut model = self.clone();
        for ring in &mut model.rings {
            let less = |sliding: &Sliding| Sliding { coefficient: share * sliding.coefficient, ..*sliding };
            let sliding = ring.sliding().map(less);
            ring.set_sliding(sliding);
        }
        model.joints.iter_mut().for_each(|joint| joint.scale_friction(share));
        model.drag *= share;
        model.oil_drag *= share;
        model
    }

    /// Size of the rated torque in N·m.
    pub(crate) fn rated_torque(&self) -> f64 {
        self.rated
    }

    /// Constant torque at the output in N·m.
    pub(crate) fn constant_load(&self) -> f64 {
        self.load.torque(0.0)
    }
}

/// Turn in rad/(N·m) of an output that nothing holds.
const LOOSE: f64 = 1.0;
