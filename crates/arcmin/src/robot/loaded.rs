//! A robot without the lives of its joints: its arm, its programs, and the loads and duty of every axis.

use super::arm::{Arm, Body};
use super::file::JointSection;
use super::life::{JointDuty, mounted};
use super::loads::{Course, beyond, duty};
use super::read::{Program, Reducer, RobotFile};
use super::tool::Places;
use crate::analyses::stage::AnyDesign;
use crate::analyses::{AnalysisError, Host};
use crate::exchange::JointRating;
use crate::scene::Solid;
use crate::units::MM;

/// Ratio of the largest momentary torque of a reducer to the rated one: a common value in catalogues of RV
/// reducers.
const MOMENTARY: f64 = 5.0;

/// A joint before its life.
pub(super) struct Before<'a> {
    pub section: &'a JointSection,
    /// A design as mounted.
    pub reducer: Reducer,
    pub design_name: String,
    pub ratio: f64,
    pub rated: f64,
    /// Largest torque allowed for a moment, N·m.
    pub allowed: f64,
    pub duty: JointDuty,
}

impl Before<'_> {
    pub fn design(&self) -> Option<&AnyDesign> {
        match &self.reducer {
            Reducer::Design(design) => Some(design),
            Reducer::Table(_) => None,
        }
    }

    /// Whether it varies between the robots of a population.
    pub fn is_drawn(&self) -> bool {
        self.design().is_some_and(AnyDesign::has_tolerances)
    }

    /// The design with the duty of the joint over the planned hours of the robot; unchanged if the joint does
    /// not move.
    pub fn on_duty(
        &self,
        design: &AnyDesign,
        planned: f64,
        moments_in_wear: bool,
    ) -> Result<AnyDesign, AnalysisError> {
        match self.duty.rows.is_empty() {
            true => Ok(design.clone()),
            false => self.duty.apply_to(design, planned * self.duty.moving, moments_in_wear),
        }
    }
}

/// All data of a robot file on its joints that are known without their lives.
pub struct Loaded<'a> {
    pub(super) file: &'a RobotFile,
    /// Without payload.
    pub(super) bare: Arm,
    pub(super) payload: Body,
    pub(super) arm: Arm,
    pub(super) visuals: Vec<Vec<Solid>>,
    pub(super) programs: Vec<Program>,
    pub(super) courses: Vec<Course>,
    pub(super) before: Vec<Before<'a>>,
    pub(super) notes: Vec<String>,
}

impl Loaded<'_> {
    /// Reads the files of a robot file and computes the loads.
    ///
    /// # Errors
    /// [`AnalysisError`]: files that cannot be read, limits that programs violate.
    pub fn of<'a>(file: &'a RobotFile, host: &dyn Host) -> Result<Loaded<'a>, AnalysisError> {
        let (bare, payload) = file.arm(host)?;
        let arm = bare.carrying(&payload);
        let visuals = file.visuals(host)?;
        let sections = file.joints(&arm)?;
        let programs = file.programs(&arm, host)?;
        host.report("inverse dynamics", 0.0);
        let courses: Vec<Course> = programs.iter().map(|program| Course::of(&arm, program)).collect();
        let mut notes = Vec::new();
        let mut before = Vec::with_capacity(arm.count());
        for (axis, section) in sections.iter().enumerate() {
            before.push(joint_before(file, section, (&arm, axis), (&programs, &courses), host, &mut notes)?);
        }
        Ok(Loaded { file, bare, payload, arm, visuals, programs, courses, before, notes })
    }

    /// Hours in motion of every joint for each hour of the robot.
    pub(super) fn moving(&self) -> Vec<f64> {
        self.before.iter().map(|joint| joint.duty.moving).collect()
    }

    /// Positions along the programs.
    pub(super) fn places(&self) -> Places {
        Places::of(&self.arm, &self.programs, &self.courses, *self.file.controller.approach_mm * MM)
    }
}

fn joint_before<'a>(
    file: &RobotFile,
    section: &'a JointSection,
    (arm, axis): (&Arm, usize),
    (programs, courses): (&[Program], &[Course]),
    host: &dyn Host,
    notes: &mut Vec<String>,
) -> Result<Before<'a>, AnalysisError> {
    let mut reducer = file.reducer(section, host)?;
    let (design_name, ratio, rated) = match &mut reducer {
        Reducer::Design(design) => {
            **design = mounted(design, *section.mounting, *section.motor_inertia_kg_m2)?;
            let JointRating { ratio, torque, .. } = design.joint_rating();
            (design.name().to_owned(), ratio, torque)
        }
        Reducer::Table(export) => (export.design_name.clone(), export.ratio, export.rated_torque_n_m),
    };
    let name = &arm.axes[axis].name;
    let given = arm.axes[axis].torque;
    let allowed = if given.is_finite() { given } else { MOMENTARY * rated };
    if let Some((program, sample, torque)) = beyond(programs, courses, axis, allowed) {
        let program = &programs[program];
        let message = format!(
            "the program \"{}\" asks the axis \"{name}\" for {torque:.0} N·m at {:.3} s; {allowed:.0} N·m are allowed",
            program.name, program.motion.time[sample]
        );
        let hint = match given.is_finite() {
            true => "slow the program down, take a lighter payload, or correct the limit",
            false => {
                "five times the rated torque is usual for a moment: slow the program down, take a larger reducer, or \
                 set torque_limit_n_m"
            }
        };
        return Err(file.wrong(message, section.axis.span.clone(), hint));
    }
    let bearings = MM * *section.bearings_mm;
    let duty = duty(programs, courses, axis, (bearings, ratio, *file.model.duty_rows));
    if duty.torque_peak > rated {
        notes.push(format!(
            "{name}: up to {:.0} N·m, rated {rated:.0} N·m; beyond ± rated torque the hysteresis loop goes on straight",
            duty.torque_peak
        ));
    }
    Ok(Before { section, reducer, design_name, ratio, rated, allowed, duty })
}
