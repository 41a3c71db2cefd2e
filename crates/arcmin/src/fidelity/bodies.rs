//! Elastic carrier and housing of a fidelity: condensed once, then stored in the cache of the host.

use crate::analyses::{AnalysisError, Host};
use crate::dynamics::{ElasticCarrier, ElasticHousing, JointSettings};
use crate::fem::BodyShapes;
use crate::machine::Machine;

/// Elastic bodies other than the discs.
#[derive(Debug, Clone)]
pub struct ElasticFrame {
    /// Plates and pillars between crank seats and output face.
    pub carrier: ElasticCarrier,
    /// Ring of pins, main bearing seats and flange.
    pub housing: ElasticHousing,
}

/// The machine with windows in its discs: those of the design, or those that go with the carrier's pillars
/// where the design has neither windows nor other holes in their place.
pub(super) fn with_windows(machine: &Machine) -> Machine {
    let mut machine = machine.clone();
    if machine.disc.windows.is_empty() && machine.disc.holes.is_empty() {
        machine.disc.windows = machine.solids.windows.clone();
    }
    machine
}

impl ElasticFrame {
    /// Condenses the bodies of a machine, or takes them from the host's cache. A damaged or foreign cache
    /// entry is replaced.
    pub(super) fn reduce(machine: &Machine, host: &dyn Host) -> Result<ElasticFrame, AnalysisError> {
        let shapes = BodyShapes::of(machine);
        let name = format!("bodies-{}.reduced", &shapes.key_hex()[..16]);
        let cached = host.cached(&name).and_then(|bytes| shapes.from_bytes(&bytes).ok());
        let bodies = match cached {
            Some(bodies) => bodies,
            None => {
                if host.is_cancelled() {
                    return Err(AnalysisError::Stopped);
                }
                let bodies = shapes
                    .reduce(host)
                    .map_err(AnalysisError::compute("mesh the elastic carrier and housing"))?;
                host.cache(&name, &shapes.to_bytes(&bodies));
                bodies
            }
        };
        let cranks = machine.crankshafts.count;
        let invalid = || AnalysisError::compute("condense carrier and housing");
        Ok(ElasticFrame {
            carrier: ElasticCarrier::new(&bodies.carrier, cranks).map_err(invalid())?,
            housing: ElasticHousing::new(machine, &bodies.housing)
                .map_err(AnalysisError::compute("take over the elastic housing"))?,
        })
    }

    pub(super) fn on(&self, settings: JointSettings) -> JointSettings {
        JointSettings { carrier: Some(self.carrier.clone()), housing: Some(self.housing.clone()), ..settings }
    }
}
