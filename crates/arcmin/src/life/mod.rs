//! Accuracy over life: the prediction of one machine, and the paper's study of uniform depths.

mod accuracy;
mod course;
mod courses;
mod extremes;
mod growth;
mod parts;
mod predict;
mod stage;
mod tao2024;
mod whole;

pub(crate) use accuracy::most_loaded;
pub use accuracy::{Accuracy, Travel, accuracy, travel};
pub use course::{Course, MachineCourse, OtherParts, WornState, worn_after};
pub use courses::{Courses, OutputFactors, Rings};
pub use growth::GrowingRings;
pub(crate) use parts::lost_motion_of;
pub use parts::{PartsFollower, PartsPoint, lost_motion_causes};
pub use predict::{LifeOptions, LifePoint, Prediction, RunAway, predict, predict_courses};
pub(crate) use predict::{STATES_IN_A_ROW, crossing};
pub use stage::{StageFollower, StageParts};
pub use tao2024::{PaperStudy, paper_depths, paper_study};
pub use whole::{MachineInBearings, WholeDrive};
