//! Tables of the tool: its figures, test poses, paths and reach, and the robots of a population.

use super::{DIRECTIONS, DISTANCE, ORIENTATION, PATH, POSITION, REPEATABILITY, ROBOT_HOURS};
use crate::results::{PLAIN, Table, TableOf, Value, decimals, quantity};
use crate::robot::figures::Figures;
use crate::robot::population::Population;
use crate::robot::reach::ReachPoint;
use crate::robot::run::{Robot, ToolAnswer};
use crate::robot::tool::Kind;
use crate::units::{DEG, MM};

pub(super) struct ToolRow(f64, Figures);

pub(super) const TOOL: TableOf<ToolRow> = TableOf {
    name: "tool",
    what: "Tool error over the hours, with all reducers of the same age",
    columns: || {
        vec![
            ROBOT_HOURS.of(|r: &ToolRow| r.0.into()),
            POSITION.of(|r| (r.1.position / MM).into()),
            ORIENTATION.of(|r| (r.1.orientation / DEG).into()),
            REPEATABILITY.of(|r| (r.1.repeatability / MM).into()),
            DIRECTIONS.of(|r| (r.1.directions / MM).into()),
            DISTANCE.of(|r| (r.1.distance / MM).into()),
            PATH.of(|r| (r.1.path / MM).into()),
        ]
    },
};

pub(super) struct PoseRow {
    program: String,
    pose: usize,
    time: f64,
    hours: f64,
    place: [f64; 3],
    off: [f64; 3],
    turn: f64,
    repeatability: f64,
}

pub(super) const POSES: TableOf<PoseRow> = TableOf {
    name: "poses",
    what: "Test poses as the programs reach them, at every age",
    columns: || {
        vec![
            quantity("program", PLAIN, "Name of the program.").of(|r: &PoseRow| r.program.clone().into()),
            quantity("pose", PLAIN, "Test pose, counted from 1.").of(|r| (r.pose + 1).into()),
            quantity("time_s", decimals(3), "Time of the pose from the beginning of the program.")
                .of(|r| r.time.into()),
            ROBOT_HOURS.of(|r| r.hours.into()),
            quantity("x_mm", decimals(1), "Commanded place of the tool in the frame of the base.")
                .of(|r| (r.place[0] / MM).into()),
            quantity("y_mm", decimals(1), "The same, y.").of(|r| (r.place[1] / MM).into()),
            quantity("z_mm", decimals(1), "The same, z.").of(|r| (r.place[2] / MM).into()),
            quantity("error_x_mm", decimals(4), "Reached less commanded place, x.")
                .of(|r| (r.off[0] / MM).into()),
            quantity("error_y_mm", decimals(4), "The same, y.").of(|r| (r.off[1] / MM).into()),
            quantity("error_z_mm", decimals(4), "The same, z.").of(|r| (r.off[2] / MM).into()),
            quantity("turn_deg", decimals(4), "Rotation of the tool error.").of(|r| (r.turn / DEG).into()),
            REPEATABILITY.of(|r| (r.repeatability / MM).into()),
        ]
    },
};

pub(super) struct PathRow {
    program: String,
    time: f64,
    place: [f64; 3],
    new: [f64; 3],
    end: [f64; 3],
}

pub(super) const PATHS: TableOf<PathRow> = TableOf {
    name: "path",
    what: "The tool along the programs, new and at the planned hours",
    columns: || {
        vec![
            quantity("program", PLAIN, "Name of the program.").of(|r: &PathRow| r.program.clone().into()),
            quantity("time_s", decimals(3), "From the beginning of the program.").of(|r| r.time.into()),
            quantity("x_mm", decimals(2), "Commanded place of the tool.").of(|r| (r.place[0] / MM).into()),
            quantity("y_mm", decimals(2), "The same, y.").of(|r| (r.place[1] / MM).into()),
            quantity("z_mm", decimals(2), "The same, z.").of(|r| (r.place[2] / MM).into()),
            quantity("new_error_x_mm", decimals(4), "Reached less commanded place of the new robot, x.")
                .of(|r| (r.new[0] / MM).into()),
            quantity("new_error_y_mm", decimals(4), "The same, y.").of(|r| (r.new[1] / MM).into()),
            quantity("new_error_z_mm", decimals(4), "The same, z.").of(|r| (r.new[2] / MM).into()),
            quantity("error_x_mm", decimals(4), "Reached less commanded place at the planned hours, x.")
                .of(|r| (r.end[0] / MM).into()),
            quantity("error_y_mm", decimals(4), "The same, y.").of(|r| (r.end[1] / MM).into()),
            quantity("error_z_mm", decimals(4), "The same, z.").of(|r| (r.end[2] / MM).into()),
        ]
    },
};

pub(super) const REACH: TableOf<ReachPoint> = TableOf {
    name: "reach",
    what: "Repeatability over the reach: second and third axis over their ranges, the other axes at their mean angle",
    columns: || {
        vec![
            quantity("radius_mm", decimals(0), "Distance of the tool from the first axis.")
                .of(|r: &ReachPoint| (r.radius / MM).into()),
            quantity("height_mm", decimals(0), "Height of the tool along the first axis.")
                .of(|r| (r.height / MM).into()),
            quantity(
                "new_repeatability_mm",
                decimals(4),
                "Repeatability of the new robot there, from all sides.",
            )
            .of(|r| (r.repeatability[0] / MM).into()),
            quantity("repeatability_mm", decimals(4), "The same at the planned hours.")
                .of(|r| (r.repeatability[1] / MM).into()),
        ]
    },
};

pub(super) struct DrawnRow(usize, Result<[Figures; 2], String>);

impl DrawnRow {
    /// A length of the new robot (`age` 0) or at the planned hours (1) in mm.
    fn length(&self, age: usize, of: fn(&Figures) -> f64) -> Value {
        self.1.as_ref().ok().map(|robot| of(&robot[age]) / MM).into()
    }
}

pub(super) const POPULATION: TableOf<DrawnRow> = TableOf {
    name: "population",
    what: "Robots with drawn reducers",
    columns: || {
        vec![
            quantity("robot", PLAIN, "Counted from 1.").of(|r: &DrawnRow| (r.0 + 1).into()),
            quantity("new_position_error_mm", decimals(3), "Pose accuracy, new.")
                .of(|r| r.length(0, |f| f.position)),
            quantity("new_repeatability_mm", decimals(3), "Repeatability, new.")
                .of(|r| r.length(0, |f| f.repeatability)),
            POSITION.of(|r| r.length(1, |f| f.position)),
            REPEATABILITY.of(|r| r.length(1, |f| f.repeatability)),
            PATH.of(|r| r.length(1, |f| f.path)),
            quantity("failed", PLAIN, "Reason why the robot cannot be computed.")
                .of(|r| r.1.as_ref().err().cloned().into()),
        ]
    },
};

pub(super) fn reach_table(tool: &ToolAnswer) -> Table {
    REACH.fill(tool.reach.points.iter())
}

pub(super) fn population_table(population: &Population) -> Table {
    let robots = population.robots.iter().enumerate();
    let rows: Vec<DrawnRow> = robots.map(|(number, robot)| DrawnRow(number, robot.clone())).collect();
    POPULATION.fill(rows.iter())
}

impl Robot {
    pub(in crate::robot) fn tool_table(&self, tool: &ToolAnswer) -> Table {
        TOOL.fill(tool.figures.iter().map(|(h, f)| ToolRow(*h, *f)).collect::<Vec<_>>().iter())
    }

    pub(super) fn pose_table(&self, tool: &ToolAnswer) -> Table {
        let mapped = tool.mapped();
        let mut rows = Vec::new();
        for (hours, _) in &tool.figures {
            let ages = vec![*hours; self.joints.len()];
            let scatter: Vec<f64> = (0..tool.places.poses)
                .map(|pose| mapped.repeatability_of(pose, |p| tool.field.tool(&tool.places, &ages, p)[0]))
                .collect();
            let mut visits = tool.sorted.visits.iter();
            for program in &self.programs {
                for (place, pose) in visits.by_ref().take(program.tests.len()) {
                    let here = &tool.places.places[*place];
                    let [off, turn] = tool.field.tool(&tool.places, &ages, *place);
                    rows.push(PoseRow {
                        program: program.name.clone(),
                        pose: *pose,
                        time: here.time,
                        hours: *hours,
                        place: here.posture.tool.position.into(),
                        off: off.into(),
                        turn: turn.norm(),
                        repeatability: scatter[*pose],
                    });
                }
            }
        }
        POSES.fill(rows.iter())
    }

    pub(super) fn path_table(&self, tool: &ToolAnswer) -> Table {
        let count = self.joints.len();
        let (new, end) = (vec![0.0; count], vec![self.planned; count]);
        let rows: Vec<PathRow> = tool
            .sorted
            .paths
            .iter()
            .filter_map(|place| {
                let here = &tool.places.places[*place];
                let Kind::Path { program } = here.kind else { return None };
                let off = |ages: &[f64]| tool.field.tool(&tool.places, ages, *place)[0].into();
                Some(PathRow {
                    program: self.programs[program].name.clone(),
                    time: here.time,
                    place: here.posture.tool.position.into(),
                    new: off(&new),
                    end: off(&end),
                })
            })
            .collect();
        PATHS.fill(rows.iter())
    }
}
