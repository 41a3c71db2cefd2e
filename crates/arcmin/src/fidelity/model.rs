//! The multibody model of a fidelity.

use super::{Fidelity, Joints};
use crate::analyses::AnalysisError;
use crate::contact::MeshContact;
use crate::dynamics::{BearingDrag, BearingJoints, Drive, FlexibleJoints, IdealJoints, Model, OutputLoad};
use crate::fem::boundary::FlankArc;
use crate::life::WornState;
use crate::machine::Machine;

/// Error of a flank meshed with linear elements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facets {
    /// Edges or nodes alone.
    pub contact: MeshContact,
    /// Edge length in m.
    pub size: f64,
}

impl Fidelity {
    /// The machine in motion, worn; `drag` is a steady torque (N·m) at the output against its motion.
    ///
    /// # Errors
    /// [`AnalysisError`] for invalid combinations and values.
    pub fn model(
        &self,
        machine: &Machine,
        worn: &WornState,
        drive: Drive,
        load: OutputLoad,
        drag: f64,
        facets: Option<Facets>,
    ) -> Result<Model, AnalysisError> {
        let invalid = || AnalysisError::compute("set up the simulation");
        // Drag of the bearings at rated speed; it varies little with the speed of a run.
        let machine = &BearingDrag::at_rated(machine).map_err(invalid())?;
        let (flank, pin) = worn.first();
        let nodes = facets.map(|facets| {
            let arc = FlankArc::new(&machine.profile());
            // Whole edges to a lobe, four at least.
            (facets.contact, arc.nodes(((arc.lobe_length() / facets.size).round() as usize).max(4)))
        });
        Ok(match (self.joints, &self.elastic) {
            (Joints::Bearings, _) => {
                if facets.is_some() {
                    return Err(AnalysisError::usage(
                        "faceted flanks are supported with ideal joints only",
                        "choose joints = ideal, or flank = smooth",
                    ));
                }
                let settings = worn.on(self.joint_settings()?);
                BearingJoints::new(machine, &settings, drive, load, drag).map_err(invalid())?.into()
            }
            (Joints::Ideal, None) => {
                let mut model = IdealJoints::new(machine, flank, drive, load, drag).map_err(invalid())?;
                if !pin.is_zero() {
                    model.set_pin_wear(pin);
                }
                nodes.iter().for_each(|(contact, nodes)| model.set_facets(*contact, nodes));
                model.into()
            }
            (Joints::Ideal, Some(elastic)) => {
                let discs = elastic.reduced().clone();
                let modes = elastic.dynamics();
                let mut model =
                    FlexibleJoints::new(machine, discs, flank, drive, load, drag, modes).map_err(invalid())?;
                if !pin.is_zero() {
                    model.set_pin_wear(pin);
                }
                nodes.iter().for_each(|(contact, nodes)| model.set_facets(*contact, nodes));
                model.into()
            }
        })
    }
}
