//! Programs of a robot file: readings of a table, or motion between poses at the pace of the axes.

use super::{Result, RobotFile};
use crate::analyses::{AnalysisError, Host, Origin};
use crate::design::{At, InputFile, Section};
use crate::robot::arm::Arm;
use crate::robot::file::{PoseSection, ProgramSection};
use crate::robot::life::degrees;
use crate::robot::motion::{Motion, Pace, Stop, through};
use crate::tables::{Column, Form};
use crate::units::{DEG, HOUR};

/// A program with its motion.
#[derive(Debug, Clone)]
pub struct Program {
    /// Name for tables and reports.
    pub name: String,
    /// Angles, speeds and accelerations over its time.
    pub motion: Motion,
    /// Cycles per hour of the robot, including the share of the program.
    pub cycles: f64,
    /// Samples at the end of rests at test poses.
    pub tests: Vec<usize>,
}

/// Smallest duration of a rest in a table that counts as a pose, s.
const REST: f64 = 0.1;

impl RobotFile {
    /// All programs with their motion, which must be within the limits of the axes.
    ///
    /// # Errors
    /// Tables that cannot be read, invalid poses, limits that are exceeded.
    pub fn programs(&self, arm: &Arm, host: &dyn Host) -> Result<Vec<Program>> {
        if self.program.is_empty() {
            let hint = "add [[program]] with a file, or with poses";
            return Err(self.wrong("the robot has no program", None, hint));
        }
        let shares: f64 = self.program.iter().map(|program| *program.share).sum();
        if shares > 1.0 + 1e-9 {
            let message = format!("the shares of the programs add up to {shares}");
            let hint = "they are shares of the planned hours: 1 at most";
            return Err(self.wrong(message, self.program[0].share.span.clone(), hint));
        }
        if let Some(late) = self.overhaul_h.iter().find(|hours| **hours > *self.planned_hours) {
            let message = format!("an overhaul at {late} h lies after the planned {} h", *self.planned_hours);
            return Err(self.wrong(
                message,
                self.overhaul_h.span.clone(),
                "ask about hours up to planned_hours",
            ));
        }
        self.program.iter().map(|section| self.program(section, arm, host)).collect()
    }

    fn program(&self, section: &At<Section<ProgramSection>>, arm: &Arm, host: &dyn Host) -> Result<Program> {
        let name = section.name.value.clone();
        let (motion, tests) = match (&*section.file, &section.pose[..]) {
            (Some(file), []) => {
                let motion = self.readings(file, *section.smoothing_ms * 1e-3, arm, host)?;
                let tests = rests(&motion);
                (motion, tests)
            }
            (None, poses) if !poses.is_empty() => self.visits(section, poses, arm)?,
            _ => {
                let message = format!("the program \"{name}\" needs a file or poses, one of both");
                let hint = "add file = \"…\", or [[program.pose]] with angles_deg";
                return Err(self.wrong(message, section.span.clone(), hint));
            }
        };
        let most = HOUR / motion.duration();
        if *section.cycles_per_hour > most * (1.0 + 1e-9) {
            let message = format!(
                "the program \"{name}\" takes {:.4} s and cannot run {} times an hour",
                motion.duration(),
                *section.cycles_per_hour
            );
            let hint = format!("{} times is the most", (most * 10.0).floor() / 10.0);
            return Err(self.wrong(message, section.cycles_per_hour.span.clone(), hint));
        }
        Ok(Program { name, motion, cycles: *section.cycles_per_hour * *section.share, tests })
    }

    fn visits(
        &self,
        section: &ProgramSection,
        poses: &[At<Section<PoseSection>>],
        arm: &Arm,
    ) -> Result<(Motion, Vec<usize>)> {
        let mut stops = Vec::with_capacity(poses.len());
        for (index, pose) in poses.iter().enumerate() {
            if pose.angles_deg.len() != arm.count() {
                let message = format!(
                    "pose {} has {} angles, the arm {} axes",
                    index + 1,
                    pose.angles_deg.len(),
                    arm.count()
                );
                let hint = format!("one for each of {}", self.names(arm).join(", "));
                return Err(self.wrong(message, pose.angles_deg.span.clone(), hint));
            }
            let angles: Vec<f64> = pose.angles_deg.iter().map(|angle| DEG * angle).collect();
            for (axis, angle) in arm.axes.iter().zip(&angles) {
                if !axis.reaches(*angle) {
                    let message = format!(
                        "pose {} takes the axis \"{}\" to {}°",
                        index + 1,
                        axis.name,
                        degrees(*angle)
                    );
                    let hint =
                        format!("the axis's range is {}° to {}°", degrees(axis.lower), degrees(axis.upper));
                    return Err(self.wrong(message, pose.angles_deg.span.clone(), hint));
                }
            }
            stops.push(Stop { angles, hold: *pose.hold_s });
        }
        if stops.windows(2).all(|pair| pair[0].angles == pair[1].angles) {
            let message = format!("the program \"{}\" never moves", *section.name);
            return Err(self.wrong(message, section.name.span.clone(), "give two different poses at least"));
        }
        let joints = self.joints(arm)?;
        let mut paces = Vec::with_capacity(arm.count());
        for (axis, joint) in arm.axes.iter().zip(&joints) {
            let Some(acceleration) = *joint.acceleration_deg_s2 else {
                let message = format!(
                    "the program \"{}\" visits poses, and the joint \"{}\" has no acceleration",
                    *section.name, axis.name
                );
                return Err(self.wrong(message, joint.axis.span.clone(), "add acceleration_deg_s2 = …"));
            };
            if !axis.speed.is_finite() {
                let message = format!(
                    "the program \"{}\" visits poses, and the joint \"{}\" has no speed",
                    *section.name, axis.name
                );
                return Err(self.wrong(message, joint.axis.span.clone(), "add speed_deg_s = …"));
            }
            paces.push(Pace {
                speed: *section.speed_share * axis.speed,
                acceleration: *section.acceleration_share * DEG * acceleration,
            });
        }
        let (motion, ends) = through(&stops, &paces, 1e-3 * *section.step_ms);
        let tests = ends.into_iter().zip(poses).filter(|(_, pose)| *pose.test).map(|(end, _)| end).collect();
        Ok((motion, tests))
    }

    fn readings(&self, file: &InputFile, window: f64, arm: &Arm, host: &dyn Host) -> Result<Motion> {
        let bytes = host.read(file, Origin::Design)?;
        let names: Vec<&'static str> = arm.axes.iter().map(|axis| column(&axis.name)).collect();
        let mut columns = vec![Column::number("time_s").rising()];
        columns.extend(names.iter().map(|name| Column::number(name)));
        let table = Form::new(&columns).read(&bytes, &file.0)?;
        let time = table.numbers("time_s")?.to_vec();
        if time.len() < 3 {
            return Err(table
                .wrong(0, "a program of fewer than three readings", "give the motion in steps of some ms")
                .into());
        }
        let mut angles = Vec::with_capacity(names.len());
        for (axis, name) in arm.axes.iter().zip(&names) {
            let degrees_read = table.numbers(name)?;
            let wrong = |row: usize, message: String, remedy: String| {
                AnalysisError::from(table.wrong(row, message, remedy))
            };
            if let Some(row) = degrees_read.iter().position(|angle| !axis.reaches(DEG * angle)) {
                return Err(wrong(
                    row,
                    format!("the axis \"{}\" goes to {}°", axis.name, degrees_read[row]),
                    format!("the axis's range is {}° to {}°", degrees(axis.lower), degrees(axis.upper)),
                ));
            }
            angles.push(degrees_read.iter().map(|angle| DEG * angle).collect());
        }
        let motion = Motion::of_readings(time, angles, window);
        for (index, axis) in arm.axes.iter().enumerate() {
            if let Some((row, speed)) = motion.too_fast(index, axis.speed) {
                let message = format!(
                    "the axis \"{}\" turns at {}°/s, {}°/s are allowed",
                    axis.name,
                    degrees(speed),
                    degrees(axis.speed)
                );
                return Err(table
                    .wrong(row, message, "slow the program down there, or correct the limit")
                    .into());
            }
        }
        Ok(motion)
    }
}

/// Name of an axis as the column of a table: `axis 1` is `axis_1_deg`. The names are kept until the end of the
/// process; an arm has a dozen at most.
fn column(axis: &str) -> &'static str {
    let mut name = String::with_capacity(axis.len() + 4);
    for c in axis.chars() {
        if c.is_alphanumeric() {
            name.extend(c.to_lowercase());
        } else if !name.ends_with('_') && !name.is_empty() {
            name.push('_');
        }
    }
    Box::leak(format!("{}_deg", name.trim_end_matches('_')).into_boxed_str())
}

/// Ends of rests in a table; if there are none, five equidistant samples.
fn rests(motion: &Motion) -> Vec<usize> {
    let mut found: Vec<usize> = Vec::new();
    let mut since: Option<usize> = None;
    for (sample, rests) in motion.rests().into_iter().enumerate() {
        if rests {
            since.get_or_insert(sample);
        }
        let ends = since.filter(|_| !rests || sample + 1 == motion.len());
        if let Some(from) = ends {
            let to = if rests { sample } else { sample - 1 };
            if motion.time[to] - motion.time[from] >= REST {
                found.push(to);
            }
            since = None;
        }
    }
    if found.is_empty() {
        found.extend((1..=5).map(|part| part * (motion.len() - 1) / 5));
    }
    found
}
