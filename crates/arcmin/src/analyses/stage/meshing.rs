//! The mechanism of a single stage as analyses ask it.

use super::EccentricDrive;
use crate::analyses::AnalysisError;
use crate::design::StageDesign;
use crate::dynamics::{EccentricJoints, HeldDrive, StageMeshing};
use crate::life::{Course, StageFollower};
use crate::machine::{DutyPoint, OutputForces};
use crate::progress::Progress;
use crate::units::MM;
use crate::wear::calibrate::coupled_exposure;
use crate::wear::{CoupledOptions, CoupledWear, Exposure, WearCase};

/// The new drive.
///
/// # Errors
/// [`AnalysisError::Compute`] for values without meaning.
pub(super) fn meshing(design: &StageDesign) -> Result<StageMeshing, AnalysisError> {
    StageMeshing::new(design.stage(), design.rated().torque, design.seen_from_ring())
        .map_err(AnalysisError::compute("build the drive from its design"))
}

/// What wears.
///
/// # Errors
/// [`AnalysisError::Usage`] where the design gives no wear.
fn wear_case(design: &StageDesign) -> Result<WearCase, AnalysisError> {
    let wear = design.wear().ok_or_else(|| {
        AnalysisError::usage(
            "the design gives no wear coefficient, so its wear cannot be computed",
            "add [wear.coupled] with coefficient_per_pa, or with after_h and depth_um of a drive that was measured",
        )
    })?;
    let (stage, rated) = (design.stage(), design.rated());
    // Forces on the output are not part of the model.
    let duty =
        design.duty_points().into_iter().map(|row| DutyPoint { forces: OutputForces::default(), ..row });
    let duty: Vec<DutyPoint> = duty.collect();
    Ok(WearCase {
        profile: stage.profile.clone(),
        contact: stage.contact,
        designed: stage.relief.clone(),
        disc_count: stage.phases.len(),
        disc_width: *design.disc.width_mm * MM,
        pin_radius: stage.ring_pin_radius,
        pin_mounting: *design.ring.pin_mounting,
        wear: wear.clone(),
        rated_torque: rated.torque,
        largest_force: stage.ring_force(DutyPoint::largest_torque(&duty) * design.seen_from_ring()),
        duty,
        lost_motion: design.limits().lost_motion,
        flank_friction: design.friction().0.ring,
    })
}

/// What wears beside flanks and ring pins.
///
/// # Errors
/// As [`wear_case`].
pub(crate) fn follower(design: &StageDesign, exposure: Exposure) -> Result<StageFollower, AnalysisError> {
    let (case, meshing, turns) = (wear_case(design)?, meshing(design)?, design.eccentric_turns());
    Ok(StageFollower::new(design.stage().clone(), case, meshing, exposure, design.has_rollers(), turns))
}

/// The drive on its way through its hours.
///
/// # Errors
/// As [`wear_case`]; where the calibration of the coefficient finds no answer.
pub(super) fn course(
    design: &StageDesign,
    options: CoupledOptions,
) -> Result<Course<StageMeshing, StageFollower>, AnalysisError> {
    let (case, meshing) = (wear_case(design)?, meshing(design)?);
    let exposure = coupled_exposure(case.clone(), meshing.clone(), options)
        .map_err(AnalysisError::wear("find the wear coefficient"))?;
    let service_life = design.limits().service_life;
    let parts = follower(design, exposure)?;
    Ok(Course::of(CoupledWear::with(case, meshing, options), parts, exposure, service_life))
}

/// The drive after some hours of its duty.
///
/// # Errors
/// As [`course`]; [`AnalysisError::Stopped`] where the host says so.
pub(super) fn worn(
    design: &StageDesign,
    hours: f64,
    progress: &dyn Progress,
) -> Result<StageMeshing, AnalysisError> {
    let mut meshing = meshing(design)?;
    if hours > 0.0 {
        let mut course = course(design, CoupledOptions::default())?;
        course.advance_to(hours, progress).map_err(AnalysisError::wear("compute the wear"))?;
        course.state().put_on(&design.stage().relief, &mut meshing);
    }
    Ok(meshing)
}

/// States of rest, each from the one before.
pub(super) struct Rests<'a> {
    held: HeldDrive,
    start: Option<Vec<f64>>,
    progress: &'a dyn Progress,
}

impl<'a> Rests<'a> {
    /// Of a drive after some hours of its duty.
    ///
    /// # Errors
    /// As [`EccentricDrive::held`].
    pub fn new(
        design: &impl EccentricDrive,
        hours: f64,
        progress: &'a dyn Progress,
    ) -> Result<Rests<'a>, AnalysisError> {
        Ok(Rests { held: design.held(hours, progress)?, start: None, progress })
    }

    /// The state with the input held at an angle (rad) against the ring, under an output torque in N·m that opposes
    /// positive motion.
    ///
    /// # Errors
    /// [`AnalysisError`] where none is found, or the host stops it.
    pub fn at(&mut self, angle: f64, torque: f64) -> Result<Vec<f64>, AnalysisError> {
        if self.progress.is_cancelled() {
            return Err(AnalysisError::Stopped);
        }
        let found = self.held.rest(angle, torque, self.start.as_deref());
        let (place, _) = found.map_err(AnalysisError::compute("find a state of rest"))?;
        self.start = Some(self.held.deviation(angle, &place));
        Ok(place)
    }

    pub fn joints(&self) -> &EccentricJoints {
        self.held.joints()
    }

    /// Angle in rad of the output against its nominal one, in the state found last.
    pub fn output_error(&self, place: &[f64]) -> f64 {
        self.held.output_error(place)
    }
}
