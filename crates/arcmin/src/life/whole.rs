//! The whole drive in its bearings, in any state of wear.

use super::{PartsPoint, Rings, WornState};
use crate::dynamics::{BearingMeshing, StageMeshing};
use crate::geometry::Relief;
use crate::load::{ShareLoad, lost_motion};
use crate::machine::{Machine, OutputAngle};
use crate::wear::WearError;

/// A drive of any family whose lost motion without friction is computed in states of wear of its rings.
pub trait WholeDrive: Clone + Send + Sync {
    /// In rad.
    ///
    /// # Errors
    /// [`WearError::Load`] where no balance is found.
    fn lost_motion(&mut self, states: &[WornState]) -> Result<f64, WearError>;

    /// By cause; `None` for a drive whose lost motion is not split.
    ///
    /// # Errors
    /// As [`WholeDrive::lost_motion`].
    fn causes(&mut self, states: &[WornState]) -> Result<Option<PartsPoint>, WearError>;

    /// Lost motion of the tooth contacts alone, all other joints ideal; `None` for a drive without this model.
    ///
    /// # Errors
    /// As [`WholeDrive::lost_motion`].
    fn contact_lost_motion(&self, states: &[WornState]) -> Result<Option<OutputAngle>, WearError>;
}

/// Crank positions over a turn of the crankshafts for lost motion and for rates of wear.
pub(super) const POSITIONS: usize = 12;

/// Crank positions of the mean lost motion, and their number if the full period is the whole ring (a test shows the
/// remaining error).
fn positions<S: ShareLoad>(meshing: &S) -> usize {
    if meshing.discs_alike() { POSITIONS } else { 4 * POSITIONS }
}

/// An RV reducer in its bearings; the equilibria of one state are the starting points of the next.
#[derive(Debug, Clone)]
pub struct MachineInBearings<'a> {
    machine: &'a Machine,
    designed: Relief,
    meshing: BearingMeshing,
}

impl<'a> MachineInBearings<'a> {
    /// The meshing of a machine in its bearings, with the relief of its design.
    pub fn new(machine: &'a Machine, meshing: BearingMeshing) -> MachineInBearings<'a> {
        MachineInBearings { machine, designed: machine.designed_relief(), meshing }
    }

    /// Applies wear, and returns the number of positions for the lost motion.
    fn set_state(&mut self, state: &WornState) -> usize {
        state.surfaces.apply_to(&self.designed, &mut self.meshing);
        self.meshing.set_part_wear(&state.part_wear);
        positions(&self.meshing)
    }

    /// Lost motion by cause.
    ///
    /// # Errors
    /// [`WearError::Load`] where no balance is found.
    pub fn split(&mut self, state: &WornState) -> Result<PartsPoint, WearError> {
        let positions = self.set_state(state);
        let lost_motion = self.meshing.lost_motion_causes(positions, &mut Vec::new())?;
        Ok(PartsPoint { wear: state.part_wear, lost_motion })
    }
}

impl WholeDrive for MachineInBearings<'_> {
    fn lost_motion(&mut self, states: &[WornState]) -> Result<f64, WearError> {
        let positions = self.set_state(&states[0]);
        Ok(self.meshing.lost_motion(positions)?)
    }

    fn causes(&mut self, states: &[WornState]) -> Result<Option<PartsPoint>, WearError> {
        self.split(&states[0]).map(Some)
    }

    fn contact_lost_motion(&self, states: &[WornState]) -> Result<Option<OutputAngle>, WearError> {
        let mut meshing = states[0].surfaces.meshing(self.machine);
        let positions = positions(&meshing);
        Ok(Some(lost_motion(&mut meshing, self.machine.rated.torque, positions)?))
    }
}

/// A drive of eccentrics; contributions of rings in series add up.
impl WholeDrive for Rings<StageMeshing> {
    fn lost_motion(&mut self, states: &[WornState]) -> Result<f64, WearError> {
        self.set_states(states);
        let mut sum = 0.0;
        let rings = self.cases.iter().zip(&mut self.meshings).zip(&self.factors);
        for ((case, meshing), factors) in rings.filter(|(_, factors)| factors.error != 0.0) {
            let positions = positions(meshing);
            sum += factors.error.abs() * lost_motion(meshing, case.rated_torque, positions)?.radians();
        }
        Ok(sum)
    }

    fn causes(&mut self, _: &[WornState]) -> Result<Option<PartsPoint>, WearError> {
        Ok(None)
    }

    fn contact_lost_motion(&self, _: &[WornState]) -> Result<Option<OutputAngle>, WearError> {
        Ok(None)
    }
}
