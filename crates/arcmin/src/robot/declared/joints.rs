//! Tables of the joints: their loads and duties, their motion, and their share in the tool error.

use super::{JOINT, ROBOT_HOURS};
use crate::exchange::DutyRow;
use crate::results::{PLAIN, Table, TableOf, decimals, digits, quantities as q, quantity};
use crate::robot::run::{JointAnswer, Robot, ToolAnswer};
use crate::units::{ARCMIN, DEG, MM, RPM};

pub(super) struct JointRow {
    joint: String,
    hours: f64,
    motion_hours: f64,
    torque_rms: f64,
    lost_motion: f64,
    stiffness: f64,
    shares: [f64; 4],
    repeatability: f64,
}

pub(super) const JOINTS: TableOf<JointRow> = TableOf {
    name: "joints",
    what: "Every joint at every age, with its share in the tool error",
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
            quantity("lost_motion_share_mm", decimals(4), "Part of the share due to lost motion (angle in the \
                 hysteresis loop less its elastic part).")
                .of(|r| (r.shares[0] / MM).into()),
            quantity("wind_up_share_mm", decimals(4), "Part of the share due to elastic wind-up, less the \
                 compensation by the controller.")
                .of(|r| (r.shares[1] / MM).into()),
            quantity("transmission_error_share_mm", decimals(4), "Part of the share due to transmission error.")
                .of(|r| (r.shares[2] / MM).into()),
            quantity("tilt_share_mm", decimals(4), "Part of the share due to tilt of the output bearings.")
                .of(|r| (r.shares[3] / MM).into()),
            quantity("repeatability_alone_mm", decimals(4), "Repeatability at the worst pose with the errors of \
                 this joint alone.")
                .of(|r| (r.repeatability / MM).into()),
        ]
    },
};

pub(super) const LOADS: TableOf<JointAnswer> = TableOf {
    name: "loads",
    what: "Loads of every joint by the programs",
    columns: || {
        vec![
            JOINT.of(|r: &JointAnswer| r.axis.clone().into()),
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
                "Root mean square of the motor torque: load, friction of the new reducer, inertia of the rotor.",
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
                "Difference between the rows of the duty and the programs in Σ |T| |ω| t.",
            )
            .of(|r| r.duty.reduction.map(|x| 100.0 * x.wear_error).into()),
            quantity(
                "bearing_load_error_percent",
                digits(2),
                "The same for the equivalent load of the bearings.",
            )
            .of(|r| r.duty.reduction.map(|x| 100.0 * x.bearing_load_error).into()),
            quantity(
                "life_source",
                PLAIN,
                "Source of the life: computed, a table, or scaled from an earlier run.",
            )
            .of(|r| r.source.word().into()),
            quantity("bearing", PLAIN, "Bearing with the shortest life.")
                .of(|r| r.bearing.as_ref().map(|b| b.0.clone()).into()),
            quantity("bearing_l10_h", decimals(0), "Its L10 in hours of the robot.")
                .of(|r| r.bearing.as_ref().map(|b| b.1).into()),
        ]
    },
};

pub(super) const DUTY: TableOf<(String, DutyRow)> = TableOf {
    name: "duty",
    what: "Rows of every joint's duty",
    columns: || {
        vec![
            JOINT.of(|r: &(String, DutyRow)| r.0.clone().into()),
            quantity(
                "torque_n_m",
                decimals(1),
                "Torque on the link; positive torque drives positive motion.",
            )
            .of(|r| r.1.torque.into()),
            quantity("input_speed_rpm", decimals(1), "Speed of the motor.")
                .of(|r| (r.1.input_speed / RPM).into()),
            quantity("share", digits(4), "Share of the time in motion.").of(|r| r.1.share.into()),
        ]
    },
};

pub(super) struct MotionRow {
    program: String,
    time: f64,
    joint: String,
    values: [f64; 7],
}

pub(super) const MOTION: TableOf<MotionRow> = TableOf {
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

impl Robot {
    pub(super) fn load_table(&self) -> Table {
        LOADS.fill(self.joints.iter())
    }

    pub(super) fn duty_table(&self) -> Table {
        let rows: Vec<(String, DutyRow)> = self
            .joints
            .iter()
            .flat_map(|joint| joint.duty.rows.iter().map(|row| (joint.axis.clone(), *row)))
            .collect();
        DUTY.fill(rows.iter())
    }

    pub(super) fn motion_table(&self) -> Table {
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

    pub(in crate::robot) fn joint_table(&self, tool: &ToolAnswer) -> Table {
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
}
