//! Tables and figures of a robot, each declared once.

mod joints;
mod remedies;
mod summary;
mod tool;

use joints::{DUTY, JOINTS, LOADS, MOTION};
use remedies::{COMPENSATION, LEVERS, OVERHAULS, PLAN, REMAINS, VARIANTS, WAVES};
pub use summary::SUMMARY;
use tool::{PATHS, POPULATION, POSES, REACH, TOOL, population_table, reach_table};

use super::kept;
use super::run::Robot;
use crate::analyses::{AnalysisError, Attachment};
use crate::results::{Declared, PLAIN, Quantity, Table, decimals, quantity};

/// Description of the command in one line.
pub const ABOUT: &str =
    "Tool error of a robot over the life of its joints, and which reducer to overhaul when";

const JOINT: Quantity = quantity("joint", PLAIN, "Name of the axis.");
const ROBOT_HOURS: Quantity = quantity("hours", decimals(0), "Hours of the robot by the clock.");
const POSITION: Quantity = quantity(
    "position_error_mm",
    decimals(3),
    "Largest distance between commanded and reached position of a test pose in the program (AP of ISO 9283).",
);
const REPEATABILITY: Quantity = quantity(
    "repeatability_mm",
    decimals(3),
    "Largest repeatability l̄ + 3 S of a test pose, approached from thirty directions (RP of ISO 9283, but from all \
         sides).",
);
const ORIENTATION: Quantity = quantity(
    "orientation_error_deg",
    decimals(4),
    "Largest rotation of the tool at a test pose from its commanded orientation.",
);
const DIRECTIONS: Quantity = quantity(
    "directional_variation_mm",
    decimals(3),
    "Largest distance between the positions of a test pose reached from ± x, ± y and ± z (vAP of ISO 9283).",
);
const DISTANCE: Quantity = quantity(
    "distance_error_mm",
    decimals(3),
    "Largest error of the distance between consecutive test poses (AD of ISO 9283).",
);
const PATH: Quantity = quantity(
    "path_error_mm",
    decimals(3),
    "Largest distance of the tool from the commanded path at right angles to it (AT of ISO 9283, one pass).",
);

/// Documentation of all results.
pub fn declared() -> Declared {
    Declared {
        analysis: "robot",
        about: ABOUT,
        tables: vec![
            JOINTS.into(),
            TOOL.into(),
            POSES.into(),
            LOADS.into(),
            DUTY.into(),
            MOTION.into(),
            PATHS.into(),
            OVERHAULS.into(),
            PLAN.into(),
            LEVERS.into(),
            COMPENSATION.into(),
            WAVES.into(),
            REMAINS.into(),
            VARIANTS.into(),
            REACH.into(),
            POPULATION.into(),
        ],
        summary: SUMMARY.quantities(),
    }
}

impl Robot {
    /// All tables.
    pub fn tables(&self) -> &[Table] {
        self.tables.get_or_init(|| self.fill_tables())
    }

    /// A table by its name.
    pub fn table(&self, name: &str) -> Option<&Table> {
        self.tables().iter().find(|table| table.name == name)
    }

    fn fill_tables(&self) -> Vec<Table> {
        let mut tables = Vec::new();
        if let Some(tool) = &self.tool {
            tables.extend([
                self.joint_table(tool),
                self.tool_table(tool),
                self.pose_table(tool),
                self.path_table(tool),
                self.overhaul_table(tool),
                self.lever_table(tool),
                self.compensation_table(tool),
                self.wave_table(tool),
                self.remains_table(tool),
                reach_table(tool),
            ]);
            tables.extend(self.plan_table());
            tables.extend(self.variant_table(tool));
            tables.extend(tool.population.as_ref().map(population_table));
        }
        tables.extend([self.load_table(), self.duty_table(), self.motion_table()]);
        tables
    }

    /// Designs with their duties, and the lives for other runs.
    ///
    /// # Errors
    /// Numbers that JSON cannot hold.
    pub fn attachments(&self) -> Result<Vec<Attachment>, AnalysisError> {
        let mut files = Vec::new();
        for (index, joint) in self.joints.iter().enumerate() {
            if let Some(text) = &joint.design_text {
                let name = format!("joint-{}.toml", index + 1);
                files.push(Attachment { name, bytes: text.clone().into_bytes() });
            }
        }
        if self.tool.is_some() && !self.kept.is_empty() {
            files.push(Attachment { name: "lives.json".to_owned(), bytes: kept::write(&self.kept)? });
        }
        Ok(files)
    }
}
