//! Lives of joints stored from one run for others; the speed of ageing follows from the work that causes wear.

use serde::{Deserialize, Serialize};

use super::joint::AgedJoint;
use super::life::{JointDuty, JointLife, scale_hours, work_in_motion};
use crate::analyses::AnalysisError;
use crate::analyses::stage::AnyDesign;
use crate::design::InputFile;

/// A life with the duty that it was computed for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KeptJoint {
    pub axis: String,
    /// Hash of the design without the duty.
    pub design: String,
    /// Hours in motion for each hour of the robot.
    pub moving: f64,
    /// Σ |T| |ω| t in J for each hour of the robot.
    pub work: f64,
    pub life: JointLife,
}

impl KeptJoint {
    /// Converts the hours of ages to those of another duty.
    pub fn scale(&self, ages: &mut [AgedJoint], duty: &JointDuty) {
        scale_hours(ages, work_in_motion(self.work, self.moving), duty.work_in_motion());
    }
}

/// The file of all lives.
///
/// # Errors
/// Numbers that JSON cannot hold.
pub fn write(joints: &[KeptJoint]) -> Result<Vec<u8>, AnalysisError> {
    serde_json::to_vec(joints).map_err(AnalysisError::compute("write the lives of the joints"))
}

pub fn read(file: &InputFile, bytes: &[u8]) -> Result<Vec<KeptJoint>, AnalysisError> {
    serde_json::from_slice(bytes).map_err(|error| AnalysisError::Input {
        file: file.0.clone(),
        line: Some(error.line()),
        message: format!("no lives of joints: {error}"),
        help: "name the lives.json of an earlier `arcmin robot`".to_owned(),
    })
}

/// The life of an axis with this design.
pub fn of<'a>(
    list: &'a [KeptJoint],
    file: &InputFile,
    axis: &str,
    design: &AnyDesign,
) -> Result<&'a KeptJoint, AnalysisError> {
    let hash = design.hash();
    let same: Vec<&KeptJoint> =
        list.iter().filter(|joint| joint.design == hash && joint.work > 0.0).collect();
    same.iter().find(|joint| joint.axis == axis).or(same.first()).copied().ok_or_else(|| {
        AnalysisError::Input {
            file: file.0.clone(),
            line: None,
            message: format!("the file contains no life of the joint \"{axis}\" with its present design"),
            help: "run once without --lives, and again after every change of a design".to_owned(),
        }
    })
}
