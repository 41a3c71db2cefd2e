use super::{CoupledOptions, CoupledWear, WearError};
use crate::geometry::Relief;
use crate::machine::Machine;

/// Flanks and pins as service leaves them, as a contact of some width sees them.
#[derive(Debug, Clone, PartialEq)]
pub struct WornSurfaces {
    /// Metal lost by every flank.
    pub flank: Relief,
    /// Metal lost by every pin.
    pub pin: Relief,
    /// Deepest point of the flank in m.
    pub deepest: f64,
}

impl WornSurfaces {
    /// The same depth (m) all over the flank, and pins as new.
    pub fn uniform(depth: f64) -> WornSurfaces {
        WornSurfaces { flank: Relief::uniform(depth), pin: Relief::uniform(0.0), deepest: depth }
    }
}

impl Machine {
    /// Coupled wear after a running time (s) at the machine's duty.
    ///
    /// # Errors
    /// [`WearError`] where the load cannot be shared or the flank wears out before.
    pub fn worn_surfaces(&self, time: f64, options: CoupledOptions) -> Result<WornSurfaces, WearError> {
        let exposure = self.coupled_exposure(options)?;
        let mut wear = CoupledWear::new(self, options);
        wear.advance_to(exposure.at(time))?;
        let state = wear.state();
        Ok(WornSurfaces {
            flank: state.flank_seen_by_contact().clone(),
            pin: state.pin_seen_by_contact().clone(),
            deepest: state.flank().deepest().0,
        })
    }
}
