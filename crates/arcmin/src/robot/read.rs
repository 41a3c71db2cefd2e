//! From the robot file to the arm, its reducers and its programs.

use std::ops::Range;

use nalgebra::{Matrix3, Unit, Vector3};

use super::arm::{Arm, Axis, Body, Pose};
use super::file::{BodySection, JointSection, PoseSection, ProgramSection, RobotSections, UrdfSection};
use super::life::degrees;
use super::motion::{Motion, Pace, Stop, through};
use super::urdf::{self, UrdfError};
use crate::analyses::stage::AnyDesign;
use crate::analyses::{AnalysisError, Host, Origin};
use crate::design::{At, DesignError, DesignErrorKind, Family, InputFile, Section, Source};
use crate::exchange::JointExport;
use crate::scene::Solid;
use crate::tables::{Column, Form, text_of};
use crate::units::{DEG, MM};

type Result<T> = std::result::Result<T, AnalysisError>;

/// Title of a robot file in messages.
const TITLE: &str = "the robot file";

/// A robot file as read.
#[derive(Debug, Clone)]
pub struct RobotFile {
    sections: RobotSections,
    text: String,
    file_name: String,
}

impl std::ops::Deref for RobotFile {
    type Target = RobotSections;

    fn deref(&self) -> &RobotSections {
        &self.sections
    }
}

/// Where a reducer's numbers come from.
#[derive(Debug, Clone)]
pub enum Reducer {
    Design(Box<AnyDesign>),
    Table(Box<JointExport>),
}

/// A program with its motion.
#[derive(Debug, Clone)]
pub struct Program {
    /// Name for tables and reports.
    pub name: String,
    /// Angles, speeds and accelerations over its time.
    pub motion: Motion,
    /// Times in an hour of the robot, its share counted.
    pub cycles: f64,
    /// Samples that end a rest at a test pose.
    pub tests: Vec<usize>,
}

/// Motion that is slower than this share of an hour's end.
const HOUR_S: f64 = 3600.0;
/// Rest in a table that makes a pose of it, s.
const REST: f64 = 0.1;

impl RobotFile {
    /// Reads a robot file; `file_name` only serves messages.
    ///
    /// # Errors
    /// Unknown keys, all at once; otherwise the first value that is missing, ill-typed or out of range.
    pub fn parse(text: &str, file_name: &str) -> std::result::Result<RobotFile, Box<DesignError>> {
        let source = Source { text, file_name, title: TITLE };
        let tree = crate::design::field::parse(&source)?;
        let sections: RobotSections = crate::design::field::read(&tree, &source)?;
        Ok(RobotFile { sections, text: text.to_owned(), file_name: file_name.to_owned() })
    }

    /// Text of the file as it was read.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Name of the file as the caller gave it.
    pub fn file_name(&self) -> &str {
        &self.file_name
    }

    /// Every value that matters, independent of layout and comments.
    pub fn canonical(&self) -> String {
        use crate::design::field::SectionValue;
        let mut lines = Vec::new();
        self.sections.canonical_fields("", &mut lines);
        lines.retain(|line| !line.starts_with("description = "));
        lines.join("\n")
    }

    pub(super) fn wrong(
        &self,
        message: impl Into<String>,
        span: Option<Range<usize>>,
        hint: impl Into<String>,
    ) -> AnalysisError {
        let source = Source { text: &self.text, file_name: &self.file_name, title: TITLE };
        let kind = DesignErrorKind::Contradiction { message: message.into() };
        source.error(kind, span.unwrap_or(0..0), Some(hint.into())).into()
    }

    fn three(&self, list: &At<Vec<f64>>, what: &str) -> Result<[f64; 3]> {
        list.value.clone().try_into().map_err(|_| {
            let message = format!("`{what}` has {} numbers", list.value.len());
            self.wrong(message, list.span.clone(), "write three: x, y, z")
        })
    }

    fn inertia(&self, list: &At<Vec<f64>>) -> Result<Matrix3<f64>> {
        let (xx, yy, zz, xy, xz, yz) = match list.value[..] {
            [xx, yy, zz] => (xx, yy, zz, 0.0, 0.0, 0.0),
            [xx, yy, zz, xy, xz, yz] => (xx, yy, zz, xy, xz, yz),
            _ => {
                let message = format!("`inertia_kg_m2` has {} numbers", list.value.len());
                return Err(self.wrong(
                    message,
                    list.span.clone(),
                    "write xx, yy, zz, or xx, yy, zz, xy, xz, yz",
                ));
            }
        };
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        if inertia.symmetric_eigenvalues().min() < -1e-9 * inertia.norm() {
            let message = "the inertia has a negative principal moment: no body has it";
            return Err(self.wrong(
                message,
                list.span.clone(),
                "check the products of inertia and their signs",
            ));
        }
        Ok(inertia)
    }

    fn body(&self, section: &BodySection) -> Result<Body> {
        Ok(Body {
            mass: *section.mass_kg,
            centre: MM * Vector3::from(self.three(&section.centre_mm, "centre_mm")?),
            inertia: self.inertia(&section.inertia_kg_m2)?,
        })
    }

    /// Simple shapes of the links of a URDF, of the base first; none of a table of axes.
    ///
    /// # Errors
    /// The error in them, with its line.
    pub(super) fn visuals(&self, host: &dyn Host) -> Result<Vec<Vec<Solid>>> {
        let Some(section) = &*self.urdf else { return Ok(Vec::new()) };
        let text = urdf_text(section, host)?;
        urdf::visuals(&text, &section.base, &section.tip).map_err(|error| in_urdf(section, error))
    }

    /// The arm with its tool, and what it carries.
    ///
    /// # Errors
    /// The error in axes, URDF or payload, with its place.
    pub fn arm(&self, host: &dyn Host) -> Result<(Arm, Body)> {
        let gravity = self.three(&self.gravity_m_s2, "gravity_m_s2")?;
        let mut arm = match (&*self.urdf, &self.axis[..]) {
            (Some(section), []) => {
                let text = urdf_text(section, host)?;
                urdf::read(&text, &section.base, &section.tip, gravity)
                    .map_err(|error| in_urdf(section, error))?
            }
            (None, []) => {
                let hint = "add [urdf] with file = \"…\", or a table of axes [[axis]]";
                return Err(self.wrong("the robot has no axes", None, hint));
            }
            (Some(_), [first, ..]) => {
                let hint = "keep [urdf] or the table of axes";
                return Err(self.wrong("the arm is given twice", first.span.clone(), hint));
            }
            (None, sections) => {
                let mut axes: Vec<Axis> = Vec::new();
                for section in sections {
                    if axes.iter().any(|axis| axis.name == *section.name.value) {
                        let message = format!("two axes are called \"{}\"", *section.name);
                        return Err(self.wrong(message, section.name.span.clone(), "rename one of them"));
                    }
                    let direction = Vector3::from(self.three(&section.direction, "direction")?);
                    let direction = Unit::try_new(direction, 1e-9).ok_or_else(|| {
                        let message = "the axis has no direction";
                        self.wrong(message, section.direction.span.clone(), "write one such as [0, 0, 1]")
                    })?;
                    if !(*section.lower_deg < *section.upper_deg) {
                        let message = format!(
                            "the axis may turn from {}° to {}°",
                            *section.lower_deg, *section.upper_deg
                        );
                        return Err(self.wrong(message, section.lower_deg.span.clone(), "swap them"));
                    }
                    axes.push(Axis {
                        name: section.name.value.clone(),
                        place: Pose::new(
                            self.three(&section.position_mm, "position_mm")?.map(|x| MM * x),
                            self.three(&section.rpy_deg, "rpy_deg")?.map(|x| DEG * x),
                        ),
                        direction,
                        link: Body {
                            mass: *section.mass_kg,
                            centre: MM * Vector3::from(self.three(&section.centre_mm, "centre_mm")?),
                            inertia: self.inertia(&section.inertia_kg_m2)?,
                        },
                        lower: DEG * *section.lower_deg,
                        upper: DEG * *section.upper_deg,
                        speed: section.speed_deg_s.map_or(f64::INFINITY, |speed| DEG * speed),
                        torque: f64::INFINITY,
                    });
                }
                Arm { axes, tool: Pose::identity(), gravity: Vector3::from(gravity) }
            }
        };
        // Tool and payload are given in the frame of the tip, which a URDF may have behind its last axis.
        let tip = arm.tool;
        arm.tool = tip.then(&Pose::new(
            self.three(&self.tool.position_mm, "position_mm")?.map(|x| MM * x),
            self.three(&self.tool.rpy_deg, "rpy_deg")?.map(|x| DEG * x),
        ));
        let payload = match &*self.payload {
            Some(section) => self.body(section)?.seen_from(&tip),
            None => Body::none(),
        };
        for (index, section) in self.joint.iter().enumerate() {
            let Some(axis) = arm.axes.iter_mut().find(|axis| axis.name == *section.axis.value) else {
                let names: Vec<&str> = self.names(&arm);
                let message = format!("no axis is called \"{}\"", *section.axis);
                return Err(self.wrong(
                    message,
                    section.axis.span.clone(),
                    format!("axes are {}", names.join(", ")),
                ));
            };
            if self.joint.iter().take(index).any(|other| *other.axis == *section.axis) {
                let message = format!("the axis \"{}\" has two reducers", *section.axis);
                return Err(self.wrong(message, section.axis.span.clone(), "take one [[joint]] out"));
            }
            axis.speed = section.speed_deg_s.map_or(axis.speed, |speed| DEG * speed);
            axis.torque = section.torque_limit_n_m.unwrap_or(axis.torque);
        }
        Ok((arm, payload))
    }

    fn names<'a>(&self, arm: &'a Arm) -> Vec<&'a str> {
        arm.axes.iter().map(|axis| &axis.name[..]).collect()
    }

    /// The section of each axis.
    ///
    /// # Errors
    /// An axis without one.
    pub fn joints(&self, arm: &Arm) -> Result<Vec<&JointSection>> {
        arm.axes
            .iter()
            .map(|axis| {
                let found = self.joint.iter().find(|section| *section.axis.value == axis.name);
                found.map(|section| &section.value.0).ok_or_else(|| {
                    let message = format!("the axis \"{}\" has no reducer", axis.name);
                    let hint = "add [[joint]] with axis = \"…\" and design = \"…\" (or table = \"…\")";
                    self.wrong(message, None, hint)
                })
            })
            .collect()
    }

    /// Design or table of a joint.
    ///
    /// # Errors
    /// Files that cannot be read; neither of both, or both.
    pub fn reducer(&self, section: &JointSection, host: &dyn Host) -> Result<Reducer> {
        let input = |file: &InputFile, line: Option<usize>, message: String, help: &str| {
            AnalysisError::Input { file: file.0.clone(), line, message, help: help.to_owned() }
        };
        match (&*section.design, &*section.table) {
            (Some(file), None) => {
                let bytes = host.read(file, Origin::Design)?;
                let text = text_of(&bytes)
                    .map_err(|kind| input(file, None, kind.to_string(), "save it as UTF-8"))?;
                // An error of the design is one of its file, whose text the robot file does not hold.
                let design = AnyDesign::parse(&text, &file.0).map_err(|error| {
                    let help = error.hint().unwrap_or("`arcmin check` of this design says more");
                    input(file, error.line(), error.kind.to_string(), help)
                })?;
                if let (Some(_), false) = (*section.mounting, design.family() == Family::Rv) {
                    let message = format!("a {} is mounted as its design says", design.family().drive());
                    let hint = "take `mounting` out; `fixed_member` in the design of a single stage says what is at rest";
                    return Err(self.wrong(message, section.mounting.span.clone(), hint));
                }
                Ok(Reducer::Design(Box::new(design)))
            }
            (None, Some(file)) => {
                let bytes = host.read(file, Origin::Design)?;
                let text = String::from_utf8_lossy(&bytes);
                let export = JointExport::from_json(&text).map_err(|error| {
                    let help = "name the joint.json that `arcmin export joint` writes";
                    input(file, Some(error.line()), format!("no table of a joint: {error}"), help)
                })?;
                if section.mounting.is_some() {
                    let message = "a table is of the joint as it was mounted when it was exported";
                    let hint = "take `mounting` out, or name the design";
                    return Err(self.wrong(message, section.mounting.span.clone(), hint));
                }
                Ok(Reducer::Table(Box::new(export)))
            }
            (None, None) => {
                let message = format!("the joint \"{}\" has neither design nor table", *section.axis);
                Err(self.wrong(message, section.axis.span.clone(), "add design = \"…\", or table = \"…\""))
            }
            (Some(_), Some(_)) => {
                let message = format!("the joint \"{}\" has a design and a table", *section.axis);
                Err(self.wrong(message, section.table.span.clone(), "keep one of them"))
            }
        }
    }

    /// All programs with their motion, within the limits of the axes.
    ///
    /// # Errors
    /// Tables that cannot be read, poses that do not fit, limits that are not kept.
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
        let most = HOUR_S / motion.duration();
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
                        format!("it may turn from {}° to {}°", degrees(axis.lower), degrees(axis.upper));
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
                    format!("it may turn from {}° to {}°", degrees(axis.lower), degrees(axis.upper)),
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

fn urdf_text(section: &UrdfSection, host: &dyn Host) -> Result<String> {
    let bytes = host.read(&section.file, Origin::Design)?;
    let text = text_of(&bytes).map_err(|kind| AnalysisError::Input {
        file: section.file.0.clone(),
        line: None,
        message: kind.to_string(),
        help: "save it as UTF-8".to_owned(),
    })?;
    Ok(text.to_string())
}

fn in_urdf(section: &UrdfSection, error: UrdfError) -> AnalysisError {
    AnalysisError::Input {
        file: section.file.0.clone(),
        line: Some(error.line),
        message: error.message,
        help: error.remedy,
    }
}

/// Name of an axis as the column of a table: `axis 1` is `axis_1_deg`. Columns are named for as long as the program
/// runs, and an arm has a dozen at most.
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

/// Ends of rests in a table; where there are none, five samples evenly many apart.
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
