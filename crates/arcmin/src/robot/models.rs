//! Joints over their lives: from the reducer and the duty of an axis to the ages for which its errors are
//! evaluated.

use rayon::prelude::*;

use super::joint::{AgedJoint, JointModel, Leaning};
use super::kept::{self, KeptJoint};
use super::life::{JointLife, Measured, leaning, live};
use super::loaded::{Before, Loaded};
use super::loads::motor_torques;
use super::read::{Reducer, RobotFile};
use super::run::{JointAnswer, RobotOptions, Source};
use crate::analyses::rig::with_friction;
use crate::analyses::stage::AnyDesign;
use crate::analyses::{AnalysisError, Host, Origin};
use crate::design::Choice;
use crate::exchange::JointExport;
use crate::fidelity::FidelityOptions;
use crate::progress::Counter;
use crate::units::{ARCMIN, DEG, MM};

/// Smallest ratio of the last age to the planned hours.
const ENOUGH: f64 = 0.99;

/// Parameters of the joint computation, from the section [model].
pub(super) fn measured(file: &RobotFile) -> Result<Measured, AnalysisError> {
    let model = &file.model;
    let words = format!(
        "joints = \"bearings\"\ndiscs = {:?}\nbodies = {:?}\n",
        model.discs.word(),
        model.bodies.word()
    );
    Ok(Measured {
        fidelity: FidelityOptions::parse(&words, "the section [model]")?,
        ages: *model.ages,
        positions: *model.positions,
        error_positions: *model.te_positions,
    })
}

/// Adds the name of the joint to an error about its life.
fn of_joint(axis: &str, error: AnalysisError) -> AnalysisError {
    match error {
        AnalysisError::Compute { task, cause } => {
            AnalysisError::Compute { task, cause: format!("{cause} (joint \"{axis}\")").into() }
        }
        AnalysisError::Usage { message, help } => {
            AnalysisError::Usage { message: format!("{message} (joint \"{axis}\")"), help }
        }
        error => error,
    }
}

/// The life of a joint of a design at its duty.
pub(super) fn life_of(
    file: &RobotFile,
    joint: &Before<'_>,
    design: &AnyDesign,
    axis: &str,
    measured: &Measured,
    host: &dyn Host,
) -> Result<JointLife, AnalysisError> {
    let on = joint.on_duty(design, *file.planned_hours, *file.model.moments_in_wear)?;
    live(&on, measured, joint.duty.rows.is_empty(), host).map_err(|error| of_joint(axis, error))
}

/// The lives of all joints; equal designs with equal duty are computed once.
pub(super) fn models(
    loaded: &Loaded<'_>,
    options: &RobotOptions,
    joints: &mut [JointAnswer],
    all: &mut Vec<KeptJoint>,
    host: &dyn Host,
) -> Result<Vec<JointModel>, AnalysisError> {
    let measured = measured(loaded.file)?;
    let earlier = match &options.lives {
        Some(name) => Some((name, kept::read(name, &host.read(name, Origin::Options)?)?)),
        None => None,
    };
    let done = Counter::new("lives of the joints", loaded.before.len(), host);
    let found: Vec<(JointModel, Option<KeptJoint>, Option<(String, f64)>, Source)> = loaded
        .before
        .par_iter()
        .zip(&loaded.arm.axes)
        .map(|(joint, axis)| {
            let name = &axis.name;
            let (source, ages, bearings, motor, kept) = match (&joint.reducer, &earlier) {
                (Reducer::Design(design), Some((file, list))) => {
                    let kept = kept::of(list, file, name, design)?.clone();
                    let mut ages = ages_of(name, &kept.life.export)?;
                    kept.scale(&mut ages, &joint.duty);
                    (Source::Scaled, ages, Vec::new(), kept.life.export.inertia.motor_kg_m2, Some(kept))
                }
                (Reducer::Design(design), None) => {
                    let life = life_of(loaded.file, joint, design, name, &measured, host)?;
                    let (ages, bearings) = (ages_of(name, &life.export)?, life.bearings.clone());
                    let motor = life.export.inertia.motor_kg_m2;
                    let (moving, work) = (joint.duty.moving, joint.duty.work);
                    let kept = KeptJoint { axis: name.clone(), design: design.hash(), moving, work, life };
                    (Source::Computed, ages, bearings, motor, Some(kept))
                }
                (Reducer::Table(export), _) => {
                    let ages = ages_of_table(joint, export, name, *loaded.file.planned_hours)?;
                    (Source::Table, ages, Vec::new(), export.inertia.motor_kg_m2, None)
                }
            };
            let (model, main) = model_of(joint, name, ages, motor)?;
            let shortest = bearings
                .into_iter()
                .chain(main.map(|hours| ("main bearings".to_owned(), hours)))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .map(|(name, hours)| (name, hours / joint.duty.moving));
            Ok(done.after(|| (model, kept, shortest, source)))
        })
        .collect::<Result<_, AnalysisError>>()?;
    let mut models = Vec::with_capacity(found.len());
    for (axis, (model, kept, bearing, source)) in found.into_iter().enumerate() {
        joints[axis].motor = Some(motor_torques(&loaded.programs, &loaded.courses, axis, &model));
        joints[axis].bearing = bearing;
        joints[axis].source = source;
        all.extend(kept);
        models.push(model);
    }
    Ok(models)
}

/// The joint with its ages, and the life of its main bearings in hours in motion.
pub(super) fn model_of(
    joint: &Before<'_>,
    axis: &str,
    ages: Vec<AgedJoint>,
    motor: f64,
) -> Result<(JointModel, Option<f64>), AnalysisError> {
    let (leaning, main) = leaning_of(joint).map_err(|error| of_joint(axis, error))?;
    let model = JointModel {
        axis: axis.to_owned(),
        design: joint.design_name.clone(),
        ratio: joint.ratio,
        rated: joint.rated,
        ages,
        leaning,
        bearings: MM * *joint.section.bearings_mm,
        drag: drag_of(joint),
        motor_inertia: joint.section.motor_inertia_kg_m2.unwrap_or(motor),
        offset: DEG * *joint.section.output_angle_deg,
    };
    Ok((model, main))
}

/// Ages of a table, which must extend to the planned hours of the robot.
pub(super) fn ages_of_table(
    joint: &Before<'_>,
    export: &JointExport,
    axis: &str,
    planned: f64,
) -> Result<Vec<AgedJoint>, AnalysisError> {
    let ages = ages_of(axis, export)?;
    let (last, needed) = (ages.last().map_or(0.0, |age| age.hours), planned * joint.duty.moving);
    if last < ENOUGH * needed {
        return Err(AnalysisError::usage(
            format!(
                "the table of the joint \"{axis}\" ends at {last} h in motion; {planned} h of the robot are {needed:.0}"
            ),
            format!("`arcmin export joint` its design with --hours 0,…,{:.0}", needed.ceil()),
        ));
    }
    Ok(ages)
}

pub(super) fn ages_of(axis: &str, export: &JointExport) -> Result<Vec<AgedJoint>, AnalysisError> {
    JointModel::ages_of(export).filter(|ages| !ages.is_empty()).ok_or_else(|| {
        AnalysisError::usage(
            format!("the hysteresis loop of the joint \"{axis}\" does not run from + to − and back"),
            "check it with `arcmin rig`, or export the table again",
        )
    })
}

fn leaning_of(joint: &Before<'_>) -> Result<(Leaning, Option<f64>), AnalysisError> {
    let given = *joint.section.moment_stiffness_n_m_per_arcmin;
    let Some(AnyDesign::Rv(design)) = joint.design() else {
        return Ok((given.map_or(Leaning::Rigid, |k| Leaning::Stiffness(k / ARCMIN)), None));
    };
    let (curve, life) = leaning(design, &joint.duty, 3.0 * joint.duty.forces.moment)?;
    Ok((given.map_or(Leaning::Curve(curve), |k| Leaning::Stiffness(k / ARCMIN)), life))
}

fn drag_of(joint: &Before<'_>) -> f64 {
    // For drives of eccentrics the drag of seals is not modelled.
    let of_design = || match joint.design() {
        Some(AnyDesign::Rv(design)) => with_friction(&design.machine(), false).0.friction.seal_drag,
        _ => 0.0,
    };
    joint.section.output_drag_n_m.unwrap_or_else(of_design)
}
