//! The robot file: declared and read like a design, with the same messages.

use crate::design::schema::{default_flag, default_numbers, required, section};
use crate::design::{At, Choice, InputFile, Section, default, default_word, optional, word};
use crate::fidelity::{DiscBodies, FrameBodies};
use crate::machine::FixedMember;

section! {
    /// A robot file.
    pub struct RobotSections {
        /// Name of the robot, for reports.
        name: String => word(),
        /// One sentence for reports.
        description: String => default_word(""),
        /// Hours by the clock that the robot is to work.
        planned_hours: f64 => required(1e-2, 1e6),
        /// Hours at which the overhaul of each joint is evaluated. Left out: when the first limit is reached, or half of the
        /// planned hours where none is.
        overhaul_h: Vec<f64> => default_numbers(&[], 0.0, 1e6),
        /// Gravity in the frame of the base, in m/s².
        gravity_m_s2: Vec<f64> => default_numbers(&[0.0, 0.0, -9.80665], -100.0, 100.0),
        /// Arm from a URDF file. Left out: from the table of axes.
        urdf: Option<Section<UrdfSection>> => optional(0.0, 0.0),
        /// Arm as a table of axes, from the base to the flange. Left out: from the URDF file.
        axis: Vec<At<Section<AxisSection>>> => optional(0.0, 0.0),
        /// Tool point in the frame of the last axis, or of the URDF's tip.
        tool: Section<ToolSection> => OPTIONAL_SECTION,
        /// Payload at the flange.
        payload: Option<Section<BodySection>> => optional(0.0, 0.0),
        /// Reducers, one for each axis.
        joint: Vec<At<Section<JointSection>>> => optional(0.0, 0.0),
        /// Programs of the robot.
        program: Vec<At<Section<ProgramSection>>> => optional(0.0, 0.0),
        /// Limits of the tool.
        limits: Section<RobotLimitsSection> => OPTIONAL_SECTION,
        /// Knowledge of the controller about its reducers.
        controller: Section<ControllerSection> => OPTIONAL_SECTION,
        /// Resolution of the joint models.
        model: Section<ModelSection> => OPTIONAL_SECTION,
        /// Changes to compare.
        variant: Vec<At<Section<VariantSection>>> => optional(0.0, 0.0),
        /// Robots whose reducers are drawn from the tolerances of their designs. Left out: none.
        population: Option<Section<PopulationSection>> => optional(0.0, 0.0),
    }

    /// A URDF file.
    pub struct UrdfSection {
        /// The file, relative to this one.
        file: InputFile => word(),
        /// Link that does not move. Left out: the root of the tree.
        base: String => default_word(""),
        /// Link that carries the tool. Left out: the only end of the tree.
        tip: String => default_word(""),
    }

    /// A turning axis and the link behind it.
    pub struct AxisSection {
        /// Its name.
        name: String => word(),
        /// Position of the origin of its frame at angle 0, in the frame of the previous axis.
        position_mm: Vec<f64> => default_numbers(&[0.0, 0.0, 0.0], -1e5, 1e5),
        /// Orientation of its frame at angle 0: roll, pitch and yaw about the fixed axes of the previous frame.
        rpy_deg: Vec<f64> => default_numbers(&[0.0, 0.0, 0.0], -360.0, 360.0),
        /// Direction of the axis in its own frame; angles count by the right-hand rule.
        direction: Vec<f64> => default_numbers(&[0.0, 0.0, 1.0], -1e3, 1e3),
        /// Mass of the link behind it, with the motors on it.
        mass_kg: f64 => required(0.0, 1e5),
        /// Centre of mass in the frame of the axis.
        centre_mm: Vec<f64> => default_numbers(&[0.0, 0.0, 0.0], -1e5, 1e5),
        /// Moments of inertia about the centre of mass: xx, yy, zz, and if they are not 0 xy, xz, yz.
        inertia_kg_m2: Vec<f64> => required(-1e6, 1e6),
        /// Least angle.
        lower_deg: f64 => default(-360.0, -1e5, 1e5),
        /// Largest angle.
        upper_deg: f64 => default(360.0, -1e5, 1e5),
        /// Largest speed. Left out: none, unless the joint names one.
        speed_deg_s: Option<f64> => optional(1e-3, 1e5),
    }

    /// The tool point.
    pub struct ToolSection {
        /// Its position.
        position_mm: Vec<f64> => default_numbers(&[0.0, 0.0, 0.0], -1e5, 1e5),
        /// Its orientation: roll, pitch and yaw.
        rpy_deg: Vec<f64> => default_numbers(&[0.0, 0.0, 0.0], -360.0, 360.0),
    }

    /// A body in the frame of the last axis, or of the URDF's tip.
    pub struct BodySection {
        /// Its mass.
        mass_kg: f64 => required(0.0, 1e5),
        /// Its centre of mass.
        centre_mm: Vec<f64> => default_numbers(&[0.0, 0.0, 0.0], -1e5, 1e5),
        /// Moments of inertia about the centre of mass: xx, yy, zz, and if they are not 0 xy, xz, yz.
        inertia_kg_m2: Vec<f64> => default_numbers(&[0.0, 0.0, 0.0], -1e6, 1e6),
    }

    /// The reducer of an axis.
    pub struct JointSection {
        /// Name of the axis, or of the URDF's joint.
        axis: String => word(),
        /// Design file of a drive of any family, relative to this one.
        design: Option<InputFile> => optional(0.0, 0.0),
        /// In place of a design: `joint.json` of `arcmin export joint`, whose ages are hours in motion.
        table: Option<InputFile> => optional(0.0, 0.0),
        /// Member at rest of an RV reducer. Left out: as the design says.
        mounting: Option<FixedMember> => optional(0.0, 0.0),
        /// Moment of inertia of the motor's rotor at the input. Left out: as the design or the table says.
        motor_inertia_kg_m2: Option<f64> => optional(0.0, 1e3),
        /// Drag between the output flange and the member at rest: seals, grease. Left out: the drag of the seals of the
        /// design of an RV reducer, with assumed friction where it gives none; else none.
        output_drag_n_m: Option<f64> => optional(0.0, 1e5),
        /// Largest torque allowed at the output. Left out: that of the URDF, or five times the rated torque.
        torque_limit_n_m: Option<f64> => optional(1e-6, 1e7),
        /// Largest speed. Left out: that of the axis.
        speed_deg_s: Option<f64> => optional(1e-3, 1e5),
        /// Largest acceleration between poses. Needed where a program visits poses.
        acceleration_deg_s2: Option<f64> => optional(1e-3, 1e6),
        /// Angle of the reducer's output where the joint's angle is 0: the phase of its transmission error.
        output_angle_deg: f64 => default(0.0, -1e5, 1e5),
        /// Middle of the output bearings along the axis from the origin of its frame.
        bearings_mm: f64 => default(0.0, -1e5, 1e5),
        /// Stiffness of the output bearings against tilting. Left out: that of the design of an RV reducer; else they are rigid.
        moment_stiffness_n_m_per_arcmin: Option<f64> => optional(1e-6, 1e9),
    }

    /// A program that the robot repeats.
    pub struct ProgramSection {
        /// Its name.
        name: String => word(),
        /// Table of `time_s` and the angles of all axes, each named as its axis with the unit behind.
        file: Option<InputFile> => optional(0.0, 0.0),
        /// In place of a table: poses visited one after the other and from the last to the first again.
        pose: Vec<At<Section<PoseSection>>> => optional(0.0, 0.0),
        /// Number of runs per hour.
        cycles_per_hour: f64 => required(1e-6, 1e7),
        /// Share of the planned hours in which it runs.
        share: f64 => default(1.0, 1e-9, 1.0),
        /// Speed between poses as a share of what the axes allow.
        speed_share: f64 => default(1.0, 1e-3, 1.0),
        /// Acceleration between poses as a share of what the axes allow.
        acceleration_share: f64 => default(1.0, 1e-3, 1.0),
        /// Time step of the motion between poses.
        step_ms: f64 => default(2.0, 0.1, 100.0),
        /// Speeds and accelerations of a table are those of parabolas through all readings within this time on either
        /// side, through three at least.
        smoothing_ms: f64 => default(8.0, 0.0, 1e4),
    }

    /// A pose at rest.
    pub struct PoseSection {
        /// Angles of all axes in their order.
        angles_deg: Vec<f64> => required(-1e5, 1e5),
        /// Time that it is held.
        hold_s: f64 => default(0.5, 0.0, 1e6),
        /// Whether accuracy counts there.
        test: bool => default_flag(true),
    }

    /// Limits at the tool. Left out: no limit.
    pub struct RobotLimitsSection {
        /// Distance between the commanded and the attained test pose in the program (pose accuracy, ISO 9283).
        position_mm: Option<f64> => optional(1e-6, 1e4),
        /// Rotation error of the tool there.
        orientation_deg: Option<f64> => optional(1e-6, 180.0),
        /// Repeatability of a test pose that is approached from all sides.
        repeatability_mm: Option<f64> => optional(1e-6, 1e4),
        /// Distance of the tool from the path of the program (path accuracy).
        path_mm: Option<f64> => optional(1e-6, 1e4),
    }

    /// The controller.
    pub struct ControllerSection {
        /// Compensation by the controller.
        compensates: Compensation => default_word("stiffness"),
        /// Length of the straight paths on which a test pose is approached from all sides.
        approach_mm: f64 => default(30.0, 1e-2, 1e4),
    }

    /// Resolution of the joint models.
    pub struct ModelSection {
        /// Cycloid discs.
        discs: DiscBodies => default_word("rigid"),
        /// Carrier, housing and rims of the discs of RV reducers.
        bodies: FrameBodies => default_word("rigid"),
        /// Number of ages at which joints are measured, at equal intervals from new to the planned hours.
        ages: usize => default(7.0, 2.0, 31.0),
        /// Number of crank positions of the hysteresis loops.
        positions: usize => default(5.0, 1.0, 360.0),
        /// Number of positions over a turn of the output.
        te_positions: usize => default(1024.0, 64.0, 65536.0),
        /// Largest number of rows of a joint's duty.
        duty_rows: usize => default(12.0, 8.0, 1000.0),
        /// Whether the wear includes the moments on the output bearings; this takes about five times as long.
        moments_in_wear: bool => default_flag(false),
    }

    /// A change to compare. Keys that are left out keep their values.
    pub struct VariantSection {
        /// Its name.
        name: String => word(),
        /// Speed of the programs as a share of their own; cycles per hour decrease with it where they no longer fit.
        speed_share: f64 => default(1.0, 1e-2, 10.0),
        /// Payload as a share of that of the file.
        payload_share: f64 => default(1.0, 0.0, 100.0),
        /// Cycles per hour as a share of those of the file.
        cycles_share: f64 => default(1.0, 1e-6, 100.0),
        /// Angles added to those of the programs, one for each axis: the same work in other poses. Left out: none.
        added_deg: Vec<f64> => default_numbers(&[], -1e5, 1e5),
    }

    /// Robots with drawn reducers.
    pub struct PopulationSection {
        /// How many.
        robots: usize => default(20.0, 2.0, 1e5),
        /// Seed.
        seed: usize => default(1.0, 0.0, 9007199254740991.0),
    }
}

const INTRODUCTION: &str = "\
# The robot file

What `arcmin robot` reads ([From the joint to the tool](robot.md)): [TOML](https://toml.io), as the design file, with the \
units in the keys. `arcmin robot new FILE` writes a complete file to start from.

This chapter is the output of `arcmin keys --robot`.
";

/// The chapter on the keys of the robot file, in Markdown.
pub fn reference_of_keys() -> String {
    let mut out = INTRODUCTION.to_owned();
    crate::design::reference_of_section(&mut out, &RobotSections::SCHEMA, "", "Top of the file");
    out
}

const OPTIONAL_SECTION: crate::design::Rule = optional(0.0, 0.0);

/// Kinds of compensation by a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compensation {
    /// The controller commands the pose as if the joints were rigid.
    None,
    /// It subtracts the mean wind-up and tilt of the new joints under the actual load.
    Stiffness,
    /// It subtracts the table of the new joints: load, direction, transmission error.
    Table,
}

impl Choice for Compensation {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("none", "nothing: deviations from the commanded pose"),
        ("stiffness", "mean wind-up and tilt of the new joints under the load at hand"),
        ("table", "the compensation table of the new joints: load, direction, transmission error"),
    ];
    const VALUES: &'static [Compensation] =
        &[Compensation::None, Compensation::Stiffness, Compensation::Table];
}
