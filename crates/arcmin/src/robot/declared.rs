//! Tables and figures of a robot, each declared once.

use super::compensation::{Entry, WaveEntry};
use super::figures::Figures;
use super::run::{Robot, ToolAnswer};
use super::tool::Kind;
use crate::analyses::Attachment;
use crate::design::Choice;
use crate::exchange::DutyRow;
use crate::results::{
    Declared, PLAIN, Quantity, SummaryOf, Table, TableOf, Value, decimals, digits, quantities as q, quantity,
};
use crate::units::{ARCMIN, DEG, MM, RPM};

/// Description of the command in one line.
pub const ABOUT: &str =
    "Tool error of a robot over the life of its joints, and which reducer to overhaul when";

const JOINT: Quantity = quantity("joint", PLAIN, "Name of the axis.");
const ROBOT_HOURS: Quantity = quantity("hours", decimals(0), "Hours of the robot by the clock.");
const POSITION: Quantity = quantity(
    "position_error_mm",
    decimals(3),
    "Largest distance of a test pose, as the program reaches it, from where it should be (AP of ISO 9283).",
);
const REPEATABILITY: Quantity = quantity(
    "repeatability_mm",
    decimals(3),
    "Repeatability l̄ + 3 S of a test pose approached from thirty sides, the largest of all (RP of ISO 9283, but \
         from all sides).",
);
const ORIENTATION: Quantity = quantity(
    "orientation_error_deg",
    decimals(4),
    "Largest turn of the tool at a test pose from where it should be.",
);
const DIRECTIONS: Quantity = quantity(
    "directional_variation_mm",
    decimals(3),
    "Largest distance between places that a test pose is reached at from ± x, ± y, ± z (vAP of ISO 9283).",
);
const DISTANCE: Quantity = quantity(
    "distance_error_mm",
    decimals(3),
    "Largest error of the distance between test poses that follow each other (AD of ISO 9283).",
);
const PATH: Quantity = quantity(
    "path_error_mm",
    decimals(3),
    "Largest distance of the tool from the commanded path at right angles to it (AT of ISO 9283, one pass).",
);

struct JointRow {
    joint: String,
    hours: f64,
    motion_hours: f64,
    torque_rms: f64,
    lost_motion: f64,
    stiffness: f64,
    shares: [f64; 4],
    repeatability: f64,
}

const JOINTS: TableOf<JointRow> = TableOf {
    name: "joints",
    what: "Every joint at every age, and what it adds at the tool",
    columns: || {
        vec![
            JOINT.of(|r: &JointRow| r.joint.clone().into()),
            ROBOT_HOURS.of(|r| r.hours.into()),
            quantity("motion_h", decimals(0), "Hours in which the joint moved until then.")
                .of(|r| r.motion_hours.into()),
            quantity(
                "torque_rms_n_m",
                decimals(1),
                "Root mean square of the torque on the link over the programs.",
            )
            .of(|r| r.torque_rms.into()),
            quantity("lost_motion_arcmin", decimals(3), "Lost motion of the reducer, as `rig` measures it.")
                .of(|r| (r.lost_motion / ARCMIN).into()),
            quantity("stiffness_n_m_per_arcmin", decimals(1), "Torsional stiffness of the reducer, as `rig` \
                 measures it.")
                .of(|r| (r.stiffness * ARCMIN).into()),
            quantity(
                "share_at_tool_mm",
                decimals(4),
                "Share of the joint in the pose accuracy: its displacement of the tool along the deviation of \
                     the worst test pose. The shares of all joints add up to `position_error_mm`.",
            )
            .of(|r| (r.shares.iter().sum::<f64>() / MM).into()),
            quantity("lost_motion_share_mm", decimals(4), "The part of the share that is lost motion: the place \
                 in the hysteresis loop.")
                .of(|r| (r.shares[0] / MM).into()),
            quantity("wind_up_share_mm", decimals(4), "The part that is elastic wind-up, less what the \
                 controller makes up for.")
                .of(|r| (r.shares[1] / MM).into()),
            quantity("transmission_error_share_mm", decimals(4), "The part that is transmission error.")
                .of(|r| (r.shares[2] / MM).into()),
            quantity("tilt_share_mm", decimals(4), "The part that is tilt of the output bearings.")
                .of(|r| (r.shares[3] / MM).into()),
            quantity("repeatability_alone_mm", decimals(4), "Repeatability at the worst pose if this joint alone \
                 were off.")
                .of(|r| (r.repeatability / MM).into()),
        ]
    },
};

const LOADS: TableOf<super::run::JointAnswer> = TableOf {
    name: "loads",
    what: "Loads of the programs on every joint",
    columns: || {
        vec![
            JOINT.of(|r: &super::run::JointAnswer| r.axis.clone().into()),
            quantity("design", PLAIN, "Name of its reducer's design.").of(|r| r.design_name.clone().into()),
            q::RATIO.of(|r| r.ratio.into()),
            quantity("rated_torque_n_m", decimals(0), "Rated torque of the reducer.").of(|r| r.rated.into()),
            quantity(
                "torque_rms_n_m",
                decimals(1),
                "Root mean square of the torque on the link over the programs.",
            )
            .of(|r| r.duty.torque_rms.into()),
            quantity("torque_peak_n_m", decimals(1), "Largest torque on the link.")
                .of(|r| r.duty.torque_peak.into()),
            quantity("speed_peak_deg_s", decimals(1), "Largest speed.")
                .of(|r| (r.duty.speed_peak / DEG).into()),
            quantity("moving_share", digits(3), "Hours in motion for each hour of the robot.")
                .of(|r| r.duty.moving.into()),
            quantity(
                "motor_torque_rms_n_m",
                digits(3),
                "Root mean square of the motor's torque: load, friction of the new reducer, its own rotor.",
            )
            .of(|r| r.motor.map(|m| m.0).into()),
            quantity("motor_torque_peak_n_m", digits(3), "Largest torque of the motor.")
                .of(|r| r.motor.map(|m| m.1).into()),
            quantity(
                "tilting_moment_n_m",
                decimals(1),
                "Tilting moment on the output bearings, power mean over the turns with the exponent 10/3.",
            )
            .of(|r| r.duty.forces.moment.into()),
            quantity(
                "axial_force_n",
                decimals(0),
                "Axial force on the output bearings, the same mean; positive out of the link.",
            )
            .of(|r| r.duty.forces.axial.into()),
            quantity("radial_force_n", decimals(0), "Radial force on the output bearings, the same mean.")
                .of(|r| r.duty.forces.radial.into()),
            quantity("duty_rows", PLAIN, "Rows of the joint's duty.").of(|r| r.duty.rows.len().into()),
            quantity(
                "wear_error_percent",
                digits(2),
                "Difference of the rows of the duty from the programs in Σ |T| |ω| t.",
            )
            .of(|r| r.duty.reduction.map(|x| 100.0 * x.wear_error).into()),
            quantity(
                "bearing_load_error_percent",
                digits(2),
                "The same of the equivalent load of the bearings.",
            )
            .of(|r| r.duty.reduction.map(|x| 100.0 * x.bearing_load_error).into()),
            quantity(
                "life_source",
                PLAIN,
                "Where the life comes from: computed, a table, or scaled from an earlier run.",
            )
            .of(|r| r.source.word().into()),
            quantity("bearing", PLAIN, "Bearing that lasts shortest.")
                .of(|r| r.bearing.as_ref().map(|b| b.0.clone()).into()),
            quantity("bearing_l10_h", decimals(0), "Its L10 in hours of the robot.")
                .of(|r| r.bearing.as_ref().map(|b| b.1).into()),
        ]
    },
};

const DUTY: TableOf<(String, DutyRow)> = TableOf {
    name: "duty",
    what: "Rows of every joint's duty",
    columns: || {
        vec![
            JOINT.of(|r: &(String, DutyRow)| r.0.clone().into()),
            quantity(
                "torque_n_m",
                decimals(1),
                "Torque on the link, positive where it drives positive motion.",
            )
            .of(|r| r.1.torque.into()),
            quantity("input_speed_rpm", decimals(1), "Speed of the motor.")
                .of(|r| (r.1.input_speed / RPM).into()),
            quantity("share", digits(4), "Share of the time in motion.").of(|r| r.1.share.into()),
        ]
    },
};

struct ToolRow(f64, Figures);

const TOOL: TableOf<ToolRow> = TableOf {
    name: "tool",
    what: "The tool over the hours, all reducers of one age",
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

struct PoseRow {
    program: String,
    pose: usize,
    time: f64,
    hours: f64,
    place: [f64; 3],
    off: [f64; 3],
    turn: f64,
    repeatability: f64,
}

const POSES: TableOf<PoseRow> = TableOf {
    name: "poses",
    what: "Test poses as the programs reach them, at every age",
    columns: || {
        vec![
            quantity("program", PLAIN, "Name of the program.").of(|r: &PoseRow| r.program.clone().into()),
            quantity("pose", PLAIN, "Test pose, counted from 1.").of(|r| (r.pose + 1).into()),
            quantity("time_s", decimals(3), "When it is looked at, from the beginning of the program.")
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
            quantity("turn_deg", decimals(4), "Turn of the tool.").of(|r| (r.turn / DEG).into()),
            REPEATABILITY.of(|r| (r.repeatability / MM).into()),
        ]
    },
};

struct MotionRow {
    program: String,
    time: f64,
    joint: String,
    values: [f64; 7],
}

const MOTION: TableOf<MotionRow> = TableOf {
    name: "motion",
    what: "Inverse dynamics along the programs, thinned to 2000 times",
    columns: || {
        vec![
            quantity("program", PLAIN, "Name of the program.").of(|r: &MotionRow| r.program.clone().into()),
            quantity("time_s", decimals(3), "From the beginning of the program.").of(|r| r.time.into()),
            JOINT.of(|r| r.joint.clone().into()),
            quantity("angle_rad", digits(6), "Angle.").of(|r| r.values[0].into()),
            quantity("speed_rad_s", digits(6), "Speed.").of(|r| r.values[1].into()),
            quantity("acceleration_rad_s2", digits(6), "Acceleration.").of(|r| r.values[2].into()),
            quantity("torque_n_m", digits(6), "Torque on the link.").of(|r| r.values[3].into()),
            quantity("tilting_moment_n_m", digits(4), "Moment that tilts the output bearings.")
                .of(|r| r.values[4].into()),
            quantity("axial_force_n", digits(4), "Force on the output along the axis from outside.")
                .of(|r| r.values[5].into()),
            quantity("radial_force_n", digits(4), "Force across the axis.").of(|r| r.values[6].into()),
        ]
    },
};

struct PathRow {
    program: String,
    time: f64,
    place: [f64; 3],
    new: [f64; 3],
    end: [f64; 3],
}

const PATHS: TableOf<PathRow> = TableOf {
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

struct OverhaulRow(String, super::run::OverhaulGain, Option<f64>);

const OVERHAULS: TableOf<OverhaulRow> = TableOf {
    name: "overhauls",
    what: "Gain by the overhaul of one reducer",
    columns: || {
        vec![
            JOINT.of(|r: &OverhaulRow| r.0.clone().into()),
            quantity(
                "overhaul_h",
                decimals(0),
                "Hours of the robot at the overhaul: those of `overhaul_h`; \
                 where it is left out, when the first limit is reached, else half of the planned hours.",
            )
            .of(|r| r.1.overhaul.hours.into()),
            quantity(
                "hours_to_limit",
                decimals(0),
                "Hours at which a limit is left then; empty where none is \
                 within the planned hours.",
            )
            .of(|r| r.1.end.into()),
            quantity("gained_h", decimals(0), "Hours gained; up to the planned hours at most.")
                .of(|r| r.2.into()),
            quantity("position_error_mm", decimals(3), "Pose accuracy at the planned hours then.")
                .of(|r| (r.1.position / MM).into()),
            quantity("repeatability_mm", decimals(3), "Repeatability at the planned hours then.")
                .of(|r| (r.1.repeatability / MM).into()),
        ]
    },
};

const PLAN: TableOf<(String, f64)> = TableOf {
    name: "plan",
    what: "Fewest overhauls that keep all limits over the planned hours, in their order",
    columns: || {
        vec![
            quantity("overhaul_h", decimals(0), "Hours of the robot.").of(|r: &(String, f64)| r.1.into()),
            JOINT.of(|r| r.0.clone().into()),
        ]
    },
};

struct LeverRow(String, super::run::Lever);

const LEVERS: TableOf<LeverRow> = TableOf {
    name: "levers",
    what: "Displacement of the tool by an arc-minute of every joint",
    columns: || {
        vec![
            JOINT.of(|r: &LeverRow| r.0.clone().into()),
            quantity("lever_mm", decimals(1), "Largest distance of the tool from the axis at a test pose.")
                .of(|r| (r.1.lever / MM).into()),
            quantity("lever_mm_per_arcmin", decimals(4), "The same for each arc-minute.")
                .of(|r| (r.1.lever * ARCMIN / MM).into()),
            quantity(
                "position_gain_mm_per_arcmin",
                decimals(4),
                "Gain of the pose accuracy at the planned hours \
                 for each arc-minute that the joint is off less.",
            )
            .of(|r| (r.1.position * ARCMIN / MM).into()),
            quantity(
                "repeatability_gain_mm_per_arcmin",
                decimals(4),
                "Repeatability of this joint alone for \
                 each arc-minute between its standings.",
            )
            .of(|r| (r.1.repeatability * ARCMIN / MM).into()),
        ]
    },
};

const COMPENSATION: TableOf<Entry> = TableOf {
    name: "compensation",
    what: "Mean error of every joint over load and direction, for a controller",
    columns: || {
        vec![
            JOINT.of(|r: &Entry| r.joint.clone().into()),
            ROBOT_HOURS.of(|r| r.hours.into()),
            quantity(
                "outer_torque_n_m",
                decimals(1),
                "Torque on the output from outside: the reaction of the torque on the link.",
            )
            .of(|r| r.torque.into()),
            quantity("torque_is", PLAIN, "Whether it was `rising` or `falling`.")
                .of(|r| if r.rises { "rising" } else { "falling" }.into()),
            quantity(
                "error_arcmin",
                decimals(4),
                "Angle of the output against motor angle / ratio: subtract it from the commanded angle.",
            )
            .of(|r| (r.error / ARCMIN).into()),
        ]
    },
};

const WAVES: TableOf<WaveEntry> = TableOf {
    name: "compensation_waves",
    what: "Transmission error of every joint over its angle, as waves, for a controller",
    columns: || {
        vec![
            JOINT.of(|r: &WaveEntry| r.joint.clone().into()),
            ROBOT_HOURS.of(|r| r.hours.into()),
            quantity("outer_torque_n_m", decimals(1), "Torque on the output from outside.")
                .of(|r| r.torque.into()),
            quantity("order", PLAIN, "Waves per turn of the joint.").of(|r| r.order.into()),
            quantity("amplitude_arcmin", digits(4), "Of cos(order × joint angle + phase).")
                .of(|r| (r.amplitude / ARCMIN).into()),
            quantity("phase_deg", decimals(2), "Phase at joint angle 0.").of(|r| (r.phase / DEG).into()),
        ]
    },
};

struct RemainsRow(&'static str, f64, Figures);

const REMAINS: TableOf<RemainsRow> = TableOf {
    name: "remains",
    what: "Remaining errors under each kind of compensation",
    columns: || {
        vec![
            quantity(
                "compensates",
                PLAIN,
                "Compensation by the controller: `none`, `stiffness`, or the whole \
                 `table` of the new joints.",
            )
            .of(|r: &RemainsRow| r.0.into()),
            ROBOT_HOURS.of(|r| r.1.into()),
            POSITION.of(|r| (r.2.position / MM).into()),
            REPEATABILITY.of(|r| (r.2.repeatability / MM).into()),
            PATH.of(|r| (r.2.path / MM).into()),
        ]
    },
};

struct VariantRow(super::variants::VariantAnswer, Option<String>);

const VARIANTS: TableOf<VariantRow> = TableOf {
    name: "variants",
    what: "Gain by changes of the program; hours of their joints are scaled from those of the robot as it is",
    columns: || {
        vec![
            quantity("variant", PLAIN, "Name of the variant.").of(|r: &VariantRow| r.0.name.clone().into()),
            quantity("cycles_share", digits(3), "Cycles an hour as a share of those given.")
                .of(|r| r.0.cycles.into()),
            quantity(
                "torque_share",
                digits(3),
                "Largest torque of the axis that rises most, as a share of the robot's as it is.",
            )
            .of(|r| r.0.hardest.1.into()),
            POSITION.of(|r| (r.0.figures.position / MM).into()),
            REPEATABILITY.of(|r| (r.0.figures.repeatability / MM).into()),
            PATH.of(|r| (r.0.figures.path / MM).into()),
            quantity(
                "hours_to_limit",
                decimals(0),
                "Hours until the first limit is left; empty where none is.",
            )
            .of(|r| r.0.end.map(|end| end.hours).into()),
            quantity("limited_by", PLAIN, "Axis that makes most of it then.").of(|r| r.1.clone().into()),
        ]
    },
};

const REACH: TableOf<super::reach::ReachPoint> = TableOf {
    name: "reach",
    what: "Repeatability over the reach: the second and third axis over their ranges, the others as on average",
    columns: || {
        vec![
            quantity("radius_mm", decimals(0), "Distance of the tool from the first axis.")
                .of(|r: &super::reach::ReachPoint| (r.radius / MM).into()),
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

struct DrawnRow(usize, Result<[Figures; 2], String>);

impl DrawnRow {
    /// In mm of m, new or at the planned hours.
    fn length(&self, age: usize, of: fn(&Figures) -> f64) -> Value {
        self.1.as_ref().ok().map(|robot| of(&robot[age]) / MM).into()
    }
}

const POPULATION: TableOf<DrawnRow> = TableOf {
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
            quantity("failed", PLAIN, "Why the robot cannot be computed.")
                .of(|r| r.1.as_ref().err().cloned().into()),
        ]
    },
};

/// The figures of a robot.
pub const SUMMARY: SummaryOf<Robot> = SummaryOf {
    entries: || {
        vec![
            POSITION.named("tool.position_error_mm").of(|r: &Robot| r.last().map(|f| f.position / MM).into()),
            ORIENTATION
                .named("tool.orientation_error_deg")
                .of(|r| r.last().map(|f| f.orientation / DEG).into()),
            REPEATABILITY
                .named("tool.repeatability_mm")
                .of(|r| r.last().map(|f| f.repeatability / MM).into()),
            DIRECTIONS
                .named("tool.directional_variation_mm")
                .of(|r| r.last().map(|f| f.directions / MM).into()),
            DISTANCE.named("tool.distance_error_mm").of(|r| r.last().map(|f| f.distance / MM).into()),
            PATH.named("tool.path_error_mm").of(|r| r.last().map(|f| f.path / MM).into()),
            quantity("new.position_error_mm", decimals(3), "Pose accuracy of the new robot.")
                .of(|r| r.first().map(|f| f.position / MM).into()),
            quantity("new.repeatability_mm", decimals(3), "Repeatability of the new robot.")
                .of(|r| r.first().map(|f| f.repeatability / MM).into()),
            quantity("new.path_error_mm", decimals(3), "Path accuracy of the new robot.")
                .of(|r| r.first().map(|f| f.path / MM).into()),
            quantity("planned_hours", decimals(0), "Hours that the robot is to work.")
                .of(|r| r.planned.into()),
            quantity(
                "hours_to_limit",
                decimals(0),
                "Hours until the first limit at the tool is left; absent \
                 where none is within the planned hours.",
            )
            .of(|r| r.hours_to_limit().into()),
            quantity("limited_by", PLAIN, "Joint that makes most of the figure then.")
                .of(|r| r.end.map(|end| r.joints[end.axis].axis.clone()).into()),
            quantity("verdict.ok", PLAIN, "Whether the tool keeps all limits over the planned hours.")
                .of(|r| r.tool.as_ref().map(|_| r.end.is_none()).into()),
            quantity("verdict.limited_by", PLAIN, "The figure that leaves its limit first.")
                .of(|r| r.end.map(|end| end.limit.figure.word()).into()),
            quantity(
                "verdict.limits",
                PLAIN,
                "Every limit with its value at the planned hours: `{limit, value, \
                 allowed, hours}`, in mm, orientation in °.",
            )
            .of(Robot::judged),
            quantity("limited_by_cause", PLAIN, "Cause with the largest share of that joint.")
                .of(|r| r.end.map(|end| super::tool::CAUSES[end.cause]).into()),
            quantity(
                "limit",
                PLAIN,
                "Which figure leaves its limit first: position, orientation, repeatability, \
                 path.",
            )
            .of(|r| r.end.map(|end| end.limit.figure.word()).into()),
            quantity(
                "plan.overhauls",
                PLAIN,
                "Fewest overhauls found that keep all limits over the planned \
                 hours; absent where there is no plan or no limit.",
            )
            .of(|r| r.plan().map(|(plan, _)| plan.len()).into()),
            quantity(
                "plan.fewest",
                PLAIN,
                "Whether no plan with fewer exists, as far as reducers only get \
                 worse.",
            )
            .of(|r| r.plan().map(|(_, fewest)| *fewest).into()),
            quantity("overhaul_first", PLAIN, "Joint that the plan overhauls first.").of(|r| {
                r.plan().and_then(|(plan, _)| plan.first()).map(|one| r.joints[one.axis].axis.clone()).into()
            }),
            quantity(
                "bearing_l10_h",
                decimals(0),
                "L10 of the bearing that lasts shortest, in hours of the \
                 robot.",
            )
            .of(|r| r.shortest_bearing().map(|(_, _, hours)| hours).into()),
            quantity("bearing_joint", PLAIN, "Joint that it is in.")
                .of(|r| r.shortest_bearing().map(|(axis, _, _)| axis).into()),
            quantity(
                "population.position_error_mm",
                PLAIN,
                "Pose accuracy at the planned hours that 5 %, 50 % \
                 and 95 % of the drawn robots keep.",
            )
            .of(|r| r.band(|f| f.position / MM)),
            quantity("population.repeatability_mm", PLAIN, "The same of repeatability.")
                .of(|r| r.band(|f| f.repeatability / MM)),
            quantity("compensates", PLAIN, "Compensation by the controller.")
                .of(|r| r.compensates.word().into()),
            quantity("notes", PLAIN, "Inputs beyond the measured range.")
                .of(|r| Value::list(r.notes.iter().cloned())),
            quantity("stages", PLAIN, "Wall seconds of the stages.")
                .of(|r| Value::Record(r.stages.iter().map(|(name, s)| (*name, (*s).into())).collect())),
        ]
    },
};

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
    pub(super) fn first(&self) -> Option<Figures> {
        Some(self.tool.as_ref()?.figures.first()?.1)
    }

    pub(super) fn last(&self) -> Option<Figures> {
        Some(self.tool.as_ref()?.figures.last()?.1)
    }

    pub(super) fn plan(&self) -> Option<&(Vec<super::answers::Overhaul>, bool)> {
        self.tool.as_ref()?.plan.as_ref().filter(|_| !self.limits.is_empty())
    }

    /// Joint, bearing and hours.
    pub(super) fn shortest_bearing(&self) -> Option<(String, String, f64)> {
        let of = |joint: &super::run::JointAnswer| {
            joint.bearing.as_ref().map(|(name, hours)| (joint.axis.clone(), name.clone(), *hours))
        };
        self.joints.iter().filter_map(of).min_by(|a, b| a.2.total_cmp(&b.2))
    }

    fn judged(&self) -> Value {
        let Some(tool) = &self.tool else { return Value::Absent };
        let (mapped, ages) = (tool.mapped(), vec![self.planned; self.joints.len()]);
        let one = |limit: &super::answers::ToolLimit| {
            let unit = if limit.figure == super::figures::Figure::Orientation { DEG } else { MM };
            let end = mapped.end(&[*limit], &[], (0.0, self.planned));
            Value::Record(vec![
                ("limit", limit.figure.word().into()),
                ("value", (mapped.figure(limit.figure, &ages) / unit).into()),
                ("allowed", (limit.allowed / unit).into()),
                ("hours", end.map(|end| end.hours).into()),
            ])
        };
        Value::List(self.limits.iter().map(one).collect())
    }

    fn band(&self, of: fn(&Figures) -> f64) -> Value {
        match self.tool.as_ref().and_then(|tool| tool.population.as_ref()) {
            Some(population) => Value::list([0.05, 0.5, 0.95].map(|share| population.quantile(1, share, of))),
            None => Value::Absent,
        }
    }

    /// All tables.
    pub fn tables(&self) -> &[Table] {
        self.tables.get_or_init(|| self.fill_tables())
    }

    /// A table by its name.
    pub fn table(&self, name: &str) -> Option<&Table> {
        self.tables().iter().find(|table| table.name == name)
    }

    fn fill_tables(&self) -> Vec<Table> {
        let mut tables = vec![LOADS.fill(self.joints.iter()), self.duty_table(), self.motion_table()];
        if let Some(tool) = &self.tool {
            tables.splice(0..0, self.tool_tables(tool));
        }
        tables
    }

    fn duty_table(&self) -> Table {
        let rows: Vec<(String, DutyRow)> = self
            .joints
            .iter()
            .flat_map(|joint| joint.duty.rows.iter().map(|row| (joint.axis.clone(), *row)))
            .collect();
        DUTY.fill(rows.iter())
    }

    fn motion_table(&self) -> Table {
        const TIMES: usize = 2000;
        let mut rows = Vec::new();
        let samples: usize = self.programs.iter().map(|program| program.motion.len()).sum();
        for (program, course) in self.programs.iter().zip(&self.courses) {
            let motion = &program.motion;
            for sample in (0..motion.len()).step_by(samples.div_ceil(TIMES).max(1)) {
                for (axis, joint) in self.joints.iter().enumerate() {
                    let (load, z) = (&course.loads[sample][axis], &course.postures[sample].axes[axis]);
                    let bearings = self.tool.as_ref().map_or(0.0, |tool| tool.joints[axis].bearings);
                    rows.push(MotionRow {
                        program: program.name.clone(),
                        time: motion.time[sample],
                        joint: joint.axis.clone(),
                        values: [
                            motion.angle[axis][sample],
                            motion.speed[axis][sample],
                            motion.acceleration[axis][sample],
                            load.torque,
                            load.tilting(z, bearings).norm(),
                            -load.axial(z),
                            load.radial(z),
                        ],
                    });
                }
            }
        }
        MOTION.fill(rows.iter())
    }

    pub(super) fn joint_table(&self, tool: &ToolAnswer) -> Table {
        let mut rows = Vec::new();
        let mapped = tool.mapped();
        for (hours, _) in &tool.figures {
            let ages = vec![*hours; self.joints.len()];
            let (shares, alone) = (mapped.shares(&ages), mapped.repeatability_by_axis(&ages));
            for (axis, (joint, model)) in self.joints.iter().zip(&tool.joints).enumerate() {
                let moved = hours * joint.duty.moving;
                rows.push(JointRow {
                    joint: joint.axis.clone(),
                    hours: *hours,
                    motion_hours: moved,
                    torque_rms: joint.duty.torque_rms,
                    lost_motion: model.between(moved, |age| age.lost_motion),
                    stiffness: model.between(moved, |age| age.stiffness),
                    shares: shares[axis],
                    repeatability: alone[axis],
                });
            }
        }
        JOINTS.fill(rows.iter())
    }

    pub(super) fn tool_table(&self, tool: &ToolAnswer) -> Table {
        TOOL.fill(tool.figures.iter().map(|(h, f)| ToolRow(*h, *f)).collect::<Vec<_>>().iter())
    }

    fn tool_tables(&self, tool: &ToolAnswer) -> Vec<Table> {
        let name = |axis: usize| self.joints[axis].axis.clone();
        let moving: Vec<f64> = self.joints.iter().map(|joint| joint.duty.moving).collect();
        let until = self.hours_to_limit();
        let overhauls: Vec<OverhaulRow> = tool
            .overhauls
            .iter()
            .map(|gain| {
                let gained = until.map(|until| gain.end.unwrap_or(self.planned) - until);
                OverhaulRow(name(gain.overhaul.axis), *gain, gained)
            })
            .collect();
        let levers: Vec<LeverRow> =
            tool.levers.iter().enumerate().map(|(axis, lever)| LeverRow(name(axis), *lever)).collect();
        let remains: Vec<RemainsRow> = tool
            .remaining
            .iter()
            .flat_map(|kind| {
                let word = kind.compensates.word();
                [RemainsRow(word, 0.0, kind.new), RemainsRow(word, self.planned, kind.end)]
            })
            .collect();
        let mut tables = vec![
            self.joint_table(tool),
            self.tool_table(tool),
            self.pose_table(tool),
            self.path_table(tool),
            OVERHAULS.fill(overhauls.iter()),
            LEVERS.fill(levers.iter()),
            COMPENSATION.fill(super::compensation::table(&tool.joints, &moving).iter()),
            WAVES.fill(super::compensation::waves(&tool.joints, &moving).iter()),
            REMAINS.fill(remains.iter()),
            REACH.fill(tool.reach.points.iter()),
        ];
        if let Some((plan, _)) = self.plan() {
            let rows: Vec<(String, f64)> = plan.iter().map(|one| (name(one.axis), one.hours)).collect();
            tables.push(PLAN.fill(rows.iter()));
        }
        if !tool.variants.is_empty() {
            tables.push(self.variant_table(tool));
        }
        if let Some(population) = &tool.population {
            let rows: Vec<DrawnRow> = population
                .robots
                .iter()
                .enumerate()
                .map(|(number, robot)| DrawnRow(number, robot.clone()))
                .collect();
            tables.push(POPULATION.fill(rows.iter()));
        }
        tables
    }

    pub(super) fn variant_table(&self, tool: &ToolAnswer) -> Table {
        let row = |variant: &super::variants::VariantAnswer| {
            VariantRow(variant.clone(), variant.end.map(|end| self.joints[end.axis].axis.clone()))
        };
        let rows: Vec<VariantRow> = tool.variants.iter().map(row).collect();
        VARIANTS.fill(rows.iter())
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

    fn path_table(&self, tool: &ToolAnswer) -> Table {
        let count = self.joints.len();
        let (new, end) = (vec![0.0; count], vec![self.planned; count]);
        let rows: Vec<PathRow> = tool
            .sorted
            .ways
            .iter()
            .filter_map(|place| {
                let here = &tool.places.places[*place];
                let Kind::Way { program } = here.kind else { return None };
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

    /// Designs with their duties, and the lives for other runs.
    ///
    /// # Errors
    /// Numbers that JSON cannot hold.
    pub fn attachments(&self) -> Result<Vec<Attachment>, crate::analyses::AnalysisError> {
        let mut files = Vec::new();
        for (index, joint) in self.joints.iter().enumerate() {
            if let Some(text) = &joint.design_text {
                let name = format!("joint-{}.toml", index + 1);
                files.push(Attachment { name, bytes: text.clone().into_bytes() });
            }
        }
        if self.tool.is_some() && !self.kept.is_empty() {
            files.push(Attachment { name: "lives.json".to_owned(), bytes: super::kept::write(&self.kept)? });
        }
        Ok(files)
    }
}
