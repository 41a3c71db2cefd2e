//! Two stages in series in SI units.

use super::{PlayChain, SingleStage, StageErrors};

/// Two single stages: the output of the first is the input shaft of the second. Both rings are at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct TwoStage {
    /// Stage at the input.
    pub first: SingleStage,
    /// Stage at the output; the first stage turns its eccentrics.
    pub second: SingleStage,
}

impl TwoStage {
    /// Turns of the input for one of the output: z_c1 z_c2.
    pub fn ratio(&self) -> f64 {
        self.first.ratio() * self.second.ratio()
    }

    /// Sets the deviations of the drive from its drawing, stage by stage.
    pub fn set_errors(&mut self, errors: [StageErrors; 2]) {
        [self.first.errors, self.second.errors] = errors;
    }

    /// Two-sided backlash of either stage at the output with the input held; that of the first stage is divided
    /// by the ratio of the second.
    pub fn play(&self) -> [PlayChain; 2] {
        let (first, by) = (self.first.play_chain(), self.second.ratio().abs());
        let seen = PlayChain {
            ring: first.ring / by,
            eccentric_bearing: first.eccentric_bearing / by,
            output: first.output / by,
        };
        [seen, self.second.play_chain()]
    }

    /// Torques (N·m) of the two stages for a torque at the output, without friction.
    pub fn torques(&self, torque: f64) -> [f64; 2] {
        [torque / self.second.ratio(), torque]
    }
}
