//! Effect of changes of the programs: slower, with less payload, fewer cycles, in other poses.

use super::answers::{End, ToolLimit};
use super::arm::{Arm, Body};
use super::figures::{Figures, Sorted, Tool};
use super::file::VariantSection;
use super::joint::JointModel;
use super::life::{degrees, scale_hours};
use super::loaded::Loaded;
use super::loads::{Course, beyond, duty};
use super::read::{Program, RobotFile};
use super::tool::{Field, Places};
use crate::analyses::{AnalysisError, Host};
use crate::units::{DEG, HOUR, MM};

/// Results of the robot with a change. Its joints are those of the robot, with hours scaled by the work that
/// causes wear.
#[derive(Debug, Clone)]
pub struct VariantAnswer {
    pub name: String,
    /// Figures at the planned hours.
    pub figures: Figures,
    pub end: Option<End>,
    /// Cycles per hour of all programs relative to the given ones.
    pub cycles: f64,
    /// Largest ratio of an axis's peak torque to that without the change, with the name of the axis.
    pub hardest: (String, f64),
}

/// All variants of the file.
///
/// # Errors
/// A variant that exceeds the limits of an axis.
pub(super) fn variants(
    loaded: &Loaded<'_>,
    models: &[JointModel],
    limits: &[ToolLimit],
    host: &dyn Host,
) -> Result<Vec<VariantAnswer>, AnalysisError> {
    let Loaded { file, bare, payload, before, .. } = loaded;
    let planned = *file.planned_hours;
    let mut found = Vec::new();
    for (index, section) in file.variant.iter().enumerate() {
        host.report("variants", index as f64 / file.variant.len() as f64);
        if host.is_cancelled() {
            return Err(AnalysisError::Stopped);
        }
        let share = *section.payload_share;
        let arm =
            bare.carrying(&Body { mass: share * payload.mass, inertia: share * payload.inertia, ..*payload });
        let added = added(file, section, &arm)?;
        let mut cycles = (0.0, 0.0);
        let programs: Vec<Program> = loaded
            .programs
            .iter()
            .zip(&*file.program.value)
            .map(|(program, given)| {
                let mut motion = program.motion.at_pace(*section.speed_share);
                for (angles, more) in motion.angle.iter_mut().zip(&added) {
                    angles.iter_mut().for_each(|angle| *angle += more);
                }
                let most = HOUR / motion.duration() * *given.share;
                let now = (program.cycles * *section.cycles_share).min(most);
                cycles = (cycles.0 + now, cycles.1 + program.cycles);
                Program { motion, cycles: now, ..program.clone() }
            })
            .collect();
        for (index, axis) in arm.axes.iter().enumerate() {
            let all = || programs.iter().flat_map(|program| &program.motion.angle[index]);
            if let Some(angle) = all().find(|angle| !axis.reaches(**angle)) {
                let message = format!(
                    "the variant \"{}\" takes the axis \"{}\" to {}°",
                    *section.name,
                    axis.name,
                    degrees(*angle)
                );
                let hint =
                    format!("the axis's range is {}° to {}°", degrees(axis.lower), degrees(axis.upper));
                return Err(file.wrong(message, section.added_deg.span.clone(), hint));
            }
        }
        let courses: Vec<Course> = programs.iter().map(|program| Course::of(&arm, program)).collect();
        let (mut joints, mut moving) = (models.to_vec(), Vec::with_capacity(models.len()));
        let mut hardest = (String::new(), 0.0);
        for (axis, joint) in before.iter().enumerate() {
            let limit = joint.allowed;
            if let Some((_, _, torque)) = beyond(&programs, &courses, axis, limit) {
                let message = format!(
                    "the variant \"{}\" asks the axis \"{}\" for {torque:.0} N·m; {limit:.0} N·m are allowed",
                    *section.name, arm.axes[axis].name
                );
                let hint = "slow the variant down, or take a lighter payload";
                return Err(file.wrong(message, section.name.span.clone(), hint));
            }
            if let Some(speed) =
                programs.iter().find_map(|program| program.motion.too_fast(axis, arm.axes[axis].speed))
            {
                let message = format!(
                    "the variant \"{}\" turns the axis \"{}\" at {}°/s, {}°/s are allowed",
                    *section.name,
                    arm.axes[axis].name,
                    degrees(speed.1),
                    degrees(arm.axes[axis].speed)
                );
                return Err(file.wrong(message, section.speed_share.span.clone(), "slow the variant down"));
            }
            let asked = (MM * *joint.section.bearings_mm, joint.ratio, *file.model.duty_rows);
            let changed = duty(&programs, &courses, axis, asked);
            scale_hours(&mut joints[axis].ages, joint.duty.work_in_motion(), changed.work_in_motion());
            let ratio = changed.torque_peak / joint.duty.torque_peak.max(f64::MIN_POSITIVE);
            if ratio > hardest.1 {
                hardest = (arm.axes[axis].name.clone(), ratio);
            }
            moving.push(changed.moving);
        }
        let places = Places::of(&arm, &programs, &courses, *file.controller.approach_mm * MM);
        let sorted = Sorted::of(&places);
        let field = Field::of(&places, &joints, &moving, *file.controller.compensates);
        let tool = Tool { places: &places, sorted: &sorted, field: &field };
        found.push(VariantAnswer {
            name: section.name.value.clone(),
            figures: tool.figures(&vec![planned; arm.count()]),
            end: tool.end(limits, &[], (0.0, planned)),
            cycles: cycles.0 / cycles.1,
            hardest,
        });
    }
    Ok(found)
}

/// Angles in rad that a variant adds to those of its programs, for each axis.
fn added(file: &RobotFile, section: &VariantSection, arm: &Arm) -> Result<Vec<f64>, AnalysisError> {
    let given = &section.added_deg;
    if given.is_empty() {
        return Ok(vec![0.0; arm.count()]);
    }
    if given.len() != arm.count() {
        let message = format!(
            "`added_deg` of the variant \"{}\" has {} angles, the arm {} axes",
            *section.name,
            given.len(),
            arm.count()
        );
        return Err(file.wrong(
            message,
            given.span.clone(),
            "write one for each axis, 0 where nothing is added",
        ));
    }
    Ok(given.iter().map(|angle| DEG * angle).collect())
}
