//! From the joint to the tool: error of a robot's tool point over the life of its reducers.
//!
//! A [`RobotFile`] describes an arm, its reducers and its programs. [`run`] computes the loads of every joint
//! by inverse dynamics, reduces them to its duty, computes the wear of every reducer under this duty, and maps
//! the joint errors at every age to the tool.
//!
//! ```no_run
//! use arcmin::analyses::NoHost;
//! use arcmin::robot::{RobotFile, RobotOptions, run};
//! use arcmin::study::Memory;
//!
//! let file = RobotFile::parse(&std::fs::read_to_string("arm.toml")?, "arm.toml")?;
//! let answer = run(&file, &RobotOptions::default(), &NoHost, &Memory::default())?;
//! println!("{:?}", answer.end);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod answers;
mod arm;
mod compensation;
mod declared;
mod example;
mod figures;
mod file;
mod joint;
mod kept;
mod levers;
mod life;
mod loaded;
mod loads;
mod memory;
mod models;
mod motion;
mod newton_euler;
mod page;
mod picture;
mod population;
mod reach;
mod read;
mod run;
#[cfg(test)]
mod tests;
mod tool;
mod urdf;
mod variants;

pub use answers::{End, Overhaul, ToolLimit};
pub use arm::{Arm, Axis, Body, Pose, Posture};
pub use declared::{SUMMARY, declared};
pub use example::{Example, example};
pub use figures::{Figure, Figures, repeatability};
pub use file::{Compensation, RobotSections, reference_of_keys};
pub use joint::{AgedJoint, JointModel, Leaning};
pub use life::{JointDuty, JointLife};
pub use loaded::Loaded;
pub use memory::{Loop, Standing};
pub use motion::Motion;
pub use newton_euler::{AxisLoad, holding_loads, inverse_dynamics};
pub use read::{Program, RobotFile};
pub use run::{Robot, RobotOptions, run};
pub use tool::CAUSES;
pub use urdf::{UrdfError, read as read_urdf};
