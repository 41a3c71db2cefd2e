//! Multibody model of a drive of any family, driven by another program: the content of an FMU.

use super::stage::{self, AnyDesign};
use super::{AnalysisError, Host};
use crate::dynamics::{Drive, Model, OutputLoad};
use crate::fidelity::{Fidelity, FidelityOptions};
use crate::life::worn_after;
use crate::machine::Friction;

/// Drive of the model, and its state.
#[derive(Debug, Clone)]
pub struct Driven {
    /// Motion of the input.
    pub drive: Drive,
    /// Torque at the output.
    pub load: OutputLoad,
    /// Age in hours of the duty.
    pub hours: f64,
    /// Whether it has friction; models of drives of eccentrics never have.
    pub friction: bool,
}

/// Whether a drive can be modelled with these options.
///
/// # Errors
/// [`AnalysisError::Usage`] for joints or bodies that the family does not have, and errors that the design does not give.
pub fn require(design: &AnyDesign, options: &FidelityOptions) -> Result<(), AnalysisError> {
    match design {
        AnyDesign::Rv(_) => Ok(()),
        AnyDesign::Eccentric(design) => stage::simulate::require(&**design, options),
        AnyDesign::TwoRing(design) => stage::simulate::require(&**design, options),
        AnyDesign::TwoStage(design) => stage::simulate::require(&**design, options),
    }
}

/// The model.
///
/// # Errors
/// [`AnalysisError`] as [`require`], and where wear or model cannot be computed.
pub fn multibody(
    design: &AnyDesign,
    options: &FidelityOptions,
    driven: Driven,
    host: &dyn Host,
) -> Result<Model, AnalysisError> {
    match design {
        AnyDesign::Rv(design) => {
            let fidelity = Fidelity::resolve(design, options, host)?;
            let mut machine = design.machine();
            let worn = worn_after(&machine, &fidelity, driven.hours, host)?;
            if !driven.friction {
                let without = machine.with_friction(Friction::default());
                machine = without.map_err(AnalysisError::compute("leave the friction out"))?;
            }
            fidelity.model(&machine, &worn, driven.drive, driven.load, 0.0, None)
        }
        AnyDesign::Eccentric(design) => stage::simulate::multibody(&**design, options, driven, host),
        AnyDesign::TwoRing(design) => stage::simulate::multibody(&**design, options, driven, host),
        AnyDesign::TwoStage(design) => stage::simulate::multibody(&**design, options, driven, host),
    }
}
