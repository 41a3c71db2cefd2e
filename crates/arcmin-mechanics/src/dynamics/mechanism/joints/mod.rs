//! The joints between the bodies: one file for each kind. The joints of a machine are listed in `build`.

mod bending;
mod frame;
mod gears;
mod hole_pins;
mod journal;
mod main_pair;
mod pin_ring;
mod support;
mod torsion;

use std::fmt::Debug;

pub(in crate::dynamics) use bending::Bending;
pub(in crate::dynamics) use frame::Frame;
pub(in crate::dynamics) use gears::Gears;
pub use hole_pins::{HolePinLoad, HolePins};
pub use journal::Journal;
pub(in crate::dynamics) use journal::SLOPES;
pub(in crate::dynamics) use main_pair::{MainPair, OutsideForces};
pub(in crate::dynamics) use pin_ring::RingContact;
pub(in crate::dynamics) use pin_ring::{Designed, Modes, PIN, PinRing};
pub use support::Support;
pub use torsion::Torsion;

use super::assembly::{ContactRequest, Element, Sink, Split};
use super::labels::{Cause, Part, PlayLabel};
use crate::contact::Sliding;
use crate::dynamics::ForceSummary;
use crate::machine::{Around, OutputForces};

/// Coordinates and velocities of all bodies, including held or prescribed ones.
#[derive(Debug, Clone, Copy)]
pub struct State<'a> {
    /// Coordinates, m or rad.
    pub q: &'a [f64],
    /// Their velocities, m/s or rad/s.
    pub v: &'a [f64],
}

/// State of the nominal machine, without wear, clearance and errors.
#[derive(Debug, Clone, Copy)]
pub struct Nominal<'a> {
    /// All coordinates.
    pub q: &'a [f64],
    /// Whether the machine has manufacturing errors, which change the nominal positions of parts.
    pub has_errors: bool,
}

impl<'a> Nominal<'a> {
    /// The coordinates, if there are errors whose effect is required.
    fn of_errors(self) -> Option<&'a [f64]> {
        self.has_errors.then_some(self.q)
    }
}

/// Constraints on the bodies at a joint without load, to first order in their displacement.
#[derive(Debug, Clone, Copy)]
pub enum Limit<'a> {
    /// A gap, which must not become negative.
    Gap(Distance<'a>),
    /// The same between a pin and a flank, where a relief of the flank increases the gap.
    Pin(Distance<'a>),
    /// A distance that must remain zero.
    Bond(Distance<'a>),
    /// A coordinate that must remain zero.
    Held(usize),
}

/// A length in m or an angle in rad, with its gradient by the listed coordinates, and an estimate of the
/// joint's stiffness against negative values, in N/m or N·m/rad.
#[derive(Debug, Clone, Copy)]
pub struct Distance<'a> {
    /// Numbers of the coordinates that the value depends on.
    pub index: &'a [usize],
    /// ∂(value)/∂(coordinate) in the order of `index`.
    pub gradient: &'a [f64],
    /// m or rad; negative in contact.
    pub value: f64,
    /// N/m or N·m/rad, an estimate.
    pub stiffness: f64,
}

/// Wear of a joint since new.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointWear {
    /// Increase of the diametral clearance of a rolling bearing, m.
    Clearance(f64),
    /// Wear depth of either side of the teeth of gears, m along the line of action.
    ToothSides([f64; 2]),
    /// Total wear depth of pins and their holes, m.
    Holes(Around),
}

/// A joint: its forces on the bodies that it connects, and the names to which its compliance and clearance are
/// assigned.
///
/// Springs are derived from energies. [`Joint::visit`] passes these on with gradient and Hessian, so that
/// forces, tangents, the split of the compliance and the stored energy have one source.
pub trait Joint: Debug + Send + Sync {
    /// Passes springs, dampers and friction on to `sink`.
    fn visit(&self, at: State<'_>, sink: &mut dyn Sink);

    /// Passes on the constraints of the joint without load; of its gaps at least those below `reach` (m).
    fn limits(&self, q: &[f64], reach: f64, add: &mut dyn FnMut(Limit<'_>));

    /// Passes on the groups of coordinates that have a constant stiffness (row by row) of their own and
    /// interact with others only through contacts.
    fn elastic(&self, _add: &mut dyn FnMut(&[usize], &[f64])) {}

    /// Tangent compliance along a motion g of all coordinates, by part: gᵀ K g.
    fn split(&self, at: State<'_>, motion: &[f64], add: &mut dyn FnMut(Part, f64)) {
        self.visit(at, &mut Split { motion, add });
    }

    /// Work (N·m·rad) of the joint's forces on its gaps and elastic approaches, by cause. For a linear spring
    /// without clearance it is twice the energy.
    fn work(&self, at: State<'_>, _nominal: Nominal<'_>, add: &mut dyn FnMut(Cause, f64)) {
        add(Cause::ELASTIC, 2.0 * self.stored(at));
    }

    /// Work (N·m·rad) of the joint's present forces on the displacement from the coordinates `from`.
    fn work_on_displacement(&self, at: State<'_>, from: &[f64]) -> f64 {
        let mut sum = WorkSum { to: at.q, from, work: 0.0 };
        self.visit(at, &mut sum);
        sum.work
    }

    /// Elastic energy in J.
    fn stored(&self, at: State<'_>) -> f64 {
        let mut stored = Stored(0.0);
        self.visit(at, &mut stored);
        stored.0
    }

    /// Applies wear of the joint's own kind; wear of other kinds has no effect.
    fn set_wear(&mut self, _wear: JointWear) {}

    /// Sets the external forces and moments on the output.
    fn set_output_forces(&mut self, _forces: OutputForces) {}

    /// Multiplies the friction of the joint by a factor.
    fn scale_friction(&mut self, _share: f64) {}

    /// Replaces the friction of the joint.
    fn set_friction(&mut self, _sliding: Sliding) {}

    /// Sets the ratio of damping to tangent stiffness, s.
    fn set_loss_time(&mut self, _time: f64) {}

    /// Forces (N) that cause wear of the joint: for a bearing the sum over all rolling elements, and 0; for
    /// gears those on either side of the teeth.
    fn wearing_forces(&self, _at: State<'_>) -> [f64; 2] {
        [0.0; 2]
    }

    /// Adds the forces of pins and gear meshes.
    fn add_forces(&self, _at: State<'_>, _summary: &mut ForceSummary) {}

    /// The joint as a rolling bearing, if it is one.
    fn bearing(&self) -> Option<&Journal> {
        None
    }

    /// A boxed copy, for `Clone` of boxed joints.
    fn boxed(&self) -> Box<dyn Joint>;
}

impl Clone for Box<dyn Joint> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

/// Damping proportional to a stiffness K, row by row over the listed coordinates: −τ K v with τ in s.
fn damp(index: &[usize], stiffness: &[f64], loss_time: f64, at: State<'_>, sink: &mut dyn Sink) {
    if !(loss_time > 0.0) {
        return;
    }
    let matrix: Vec<f64> = stiffness.iter().map(|k| loss_time * k).collect();
    let along = |row: &[f64]| -> f64 { row.iter().zip(index).map(|(entry, i)| entry * at.v[*i]).sum() };
    let force: Vec<f64> = matrix.chunks_exact(index.len()).map(|row| -along(row)).collect();
    let dissipation = -along(&force);
    sink.damper(index, &force, &matrix, dissipation);
}

/// Sums stored energies.
struct Stored(f64);

impl Sink for Stored {
    fn element(&mut self, element: &Element<'_>) {
        self.0 += element.stored;
    }

    fn damper(&mut self, _: &[usize], _: &[f64], _: &[f64], _: f64) {}
}

/// Sums the work of forces on a displacement of all coordinates.
struct WorkSum<'a> {
    to: &'a [f64],
    from: &'a [f64],
    work: f64,
}

impl Sink for WorkSum<'_> {
    fn element(&mut self, element: &Element<'_>) {
        let slopes = element.index.iter().zip(element.gradient);
        self.work += slopes.map(|(i, slope)| slope * (self.to[*i] - self.from[*i])).sum::<f64>();
    }

    fn damper(&mut self, _: &[usize], _: &[f64], _: &[f64], _: f64) {}

    fn takes_stiffness(&self) -> bool {
        false
    }

    fn takes_damping(&self) -> bool {
        false
    }
}

/// Ratio of damping to tangent stiffness in bearings, shafts and output pins, s. An assumption: a loss factor
/// of 1 % at 1 kHz. Without velocities it has no effect.
pub(in crate::dynamics) const LOSS_TIME: f64 = 2e-6;

/// Losses of joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Losses {
    /// Ratio of damping to tangent stiffness in s.
    pub time: f64,
    /// Coulomb friction.
    pub sliding: Sliding,
}
