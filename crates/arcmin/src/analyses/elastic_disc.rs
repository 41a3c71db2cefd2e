//! Elastic discs in all analyses: a section of the report, and a file for ParaView.

use super::{AnalysisError, Attachment};
use crate::fidelity::Fidelity;
use crate::machine::Machine;
use crate::report::{Section, elastic};

/// Modes in the file for ParaView.
const VTU_MODES: usize = 8;

/// Mesh, deformed shape and natural frequencies; `None` for rigid discs.
///
/// # Errors
/// [`AnalysisError`] where meshing the disc or sharing the load fails.
pub(crate) fn section(machine: &Machine, fidelity: &Fidelity) -> Result<Option<Section>, AnalysisError> {
    let Some(discs) = &fidelity.elastic else { return Ok(None) };
    let (model, sharing) = discs.under_rated_torque(machine)?;
    let frequencies = discs.reduced().reduced(0).frequencies();
    Ok(Some(elastic::section(machine, &model, &frequencies, &sharing)))
}

/// `disc.vtu`, if requested: mesh, displacement and stress under rated torque, lowest modes.
///
/// # Errors
/// [`AnalysisError`] where meshing the disc, sharing the load or finding its modes fails.
pub(crate) fn attachments(machine: &Machine, fidelity: &Fidelity) -> Result<Vec<Attachment>, AnalysisError> {
    let Some(discs) = fidelity.elastic.as_ref().filter(|discs| discs.needs_vtu()) else {
        return Ok(Vec::new());
    };
    let (model, sharing) = discs.under_rated_torque(machine)?;
    let text = model
        .vtu(&sharing.tooth_loads(0), VTU_MODES)
        .map_err(AnalysisError::compute("find the modes of the disc"))?;
    Ok(vec![Attachment { name: "disc.vtu".to_owned(), bytes: text.into_bytes() }])
}
