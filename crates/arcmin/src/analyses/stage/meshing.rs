//! The mechanism of a drive of eccentrics, new and worn, for the analyses.

use std::f64::consts::TAU;

use super::EccentricDrive;
use super::keys::main_of;
use crate::analyses::AnalysisError;
use crate::design::Family;
use crate::dynamics::{EccentricJoints, ElasticDiscs, HeldDrive, StageMeshing};
use crate::geometry::Relief;
use crate::life::{Course, Courses, OutputFactors, Rings, StageFollower, StageParts};
use crate::machine::{
    DutyPoint, OutputForces, PartWear, PinMounting, RingMesh, SingleStage, StageErrors, StageFriction,
    WearCoefficient,
};
use crate::progress::Progress;
use crate::rig::{LoopPoint, eccentric_loop};
#[cfg(test)]
use crate::wear::Exposure;
use crate::wear::calibrate::coupled_exposure;
use crate::wear::{CoupledOptions, CoupledWear, WearCase};

/// One ring of a drive with the other bearing parts of its stage.
pub struct LoadedRing<'a> {
    pub(super) of: OfRing<'a>,
    pub(super) meshing: StageMeshing,
    pub(super) parts: StageParts,
    pub(super) factors: OutputFactors,
    /// As [`WearingRing::passes`].
    pub(super) passes: f64,
}

/// One ring of a drive with the data for its wear.
pub struct WearingRing {
    /// The torques and speeds of its duty are those of its stage.
    pub(super) case: WearCase,
    pub(super) meshing: StageMeshing,
    pub(super) parts: StageParts,
    pub(super) factors: OutputFactors,
    /// Passes of a place of its flank through the contact for one turn of the input of the drive.
    pub(super) passes: f64,
}

/// Data of one ring in addition to those of the drive.
pub(super) struct OfRing<'a> {
    pub mesh: &'a RingMesh,
    pub discs: usize,
    /// m.
    pub width: f64,
    pub pin_mounting: PinMounting,
    /// Coulomb's coefficient between flank and pin.
    pub friction: f64,
    /// Torque and input speed of the stage over those of the drive.
    pub torque: f64,
    pub speed: f64,
    /// Force (N) of a pin with equal springs under a torque of the stage.
    pub largest_force: Box<dyn Fn(f64) -> f64 + 'a>,
    /// Angle at the output of the drive over that of the disc, absolute values.
    pub error: f64,
}

/// The duty of the stage of a ring.
pub(super) fn duty_of(design: &impl EccentricDrive, of: &OfRing<'_>) -> Vec<DutyPoint> {
    let of_stage = |row: DutyPoint| DutyPoint {
        torque: of.torque * row.torque,
        input_speed: of.speed * row.input_speed,
        // Forces on the output are not part of the model.
        forces: OutputForces::default(),
        ..row
    };
    design.duty_points().into_iter().map(of_stage).collect()
}

/// Wearing parts.
///
/// # Errors
/// [`AnalysisError::Usage`] where the design gives no wear.
pub(super) fn wear_case(design: &impl EccentricDrive, of: OfRing<'_>) -> Result<WearCase, AnalysisError> {
    let wear = design.wear().ok_or_else(|| {
        AnalysisError::usage(
            "the design gives no wear coefficient, so its wear cannot be computed",
            "add [wear.coupled] with coefficient_per_pa, or with after_h and depth_um of a drive that was measured",
        )
    })?;
    let duty = duty_of(design, &of);
    Ok(WearCase {
        profile: of.mesh.profile.clone(),
        contact: of.mesh.contact,
        designed: of.mesh.relief.clone(),
        disc_count: of.discs,
        disc_width: of.width,
        pin_radius: of.mesh.ring_pin_radius,
        pin_mounting: of.pin_mounting,
        wear: wear.clone(),
        rated_torque: of.torque * design.rated().torque,
        largest_force: (of.largest_force)(DutyPoint::largest_torque(&duty)),
        duty,
        lost_motion: design.limits().lost_motion / of.error,
        flank_friction: of.friction,
    })
}

/// Wearing parts, other than flank and ring pins, of a single stage with its ring at rest.
pub(super) fn stage_parts(stage: &SingleStage, has_rollers: bool) -> StageParts {
    let (lobes, pins) = (stage.profile.lobe_count() as f64, stage.profile.pin_count as f64);
    StageParts {
        eccentric: stage.eccentric.clone(),
        eccentricity: stage.profile.eccentricity,
        output_pins: Some(stage.output_pins),
        has_rollers,
        turns: 1.0 + 1.0 / stage.profile.lobes_per_turn(),
        period: TAU * lobes / pins,
    }
}

/// The rings, for evaluation in states of wear.
pub(super) fn for_evaluation(rings: Vec<WearingRing>) -> Rings<StageMeshing> {
    Rings {
        factors: rings.iter().map(|ring| ring.factors).collect(),
        cases: rings.iter().map(|ring| ring.case.clone()).collect(),
        meshings: rings.into_iter().map(|ring| ring.meshing).collect(),
    }
}

/// The rings of a new drive, for evaluation in states of wear.
///
/// # Errors
/// As [`EccentricDrive::wearing_rings`].
#[cfg(test)]
pub(crate) fn rings(design: &impl EccentricDrive) -> Result<Rings<StageMeshing>, AnalysisError> {
    Ok(for_evaluation(design.wearing_rings(&[])?))
}

/// Wearing parts, other than flanks and ring pins, of a new drive, ring by ring.
///
/// # Errors
/// As [`EccentricDrive::wearing_rings`].
#[cfg(test)]
pub(crate) fn followers(
    design: &impl EccentricDrive,
    exposure: Exposure,
) -> Result<Vec<StageFollower>, AnalysisError> {
    let follower = |ring: WearingRing| StageFollower::new(ring.parts, ring.case, ring.meshing, exposure);
    Ok(design.wearing_rings(&[])?.into_iter().map(follower).collect())
}

/// The drive at some running hours. All rings have one wear coefficient; if it must be calibrated, this uses the ring
/// whose keys have no prefix.
///
/// # Errors
/// As [`EccentricDrive::wearing_rings`]; if the calibration of the coefficient fails.
pub(super) fn courses<D: EccentricDrive>(
    design: &D,
    discs: &[ElasticDiscs],
    options: CoupledOptions,
) -> Result<Courses<StageMeshing, StageFollower>, AnalysisError> {
    let rings = design.wearing_rings(discs)?;
    let main = &rings[main_of(D::STAGES)];
    if rings.len() > 1 && matches!(main.case.wear.coupled, WearCoefficient::CalibratedLostMotion { .. }) {
        let drive = D::FAMILY.drive();
        return Err(AnalysisError::usage(
            format!("the wear coefficient of a {drive} cannot be calibrated to its lost motion"),
            format!(
                "both of its {} contribute to it: give after_h and depth_um of the flank in [disc], or \
                     coefficient_per_pa",
                if D::FAMILY == Family::TwoRing { "rings" } else { "stages" }
            ),
        ));
    }
    // The coefficient is that of the nominal drive, independent of the errors of this one.
    let nominal = design.with_errors(vec![StageErrors::default(); D::STAGES.len()]);
    let meshing = nominal.wearing_rings(discs)?.swap_remove(main_of(D::STAGES)).meshing;
    let exposure = coupled_exposure(main.case.clone(), meshing, options)
        .map_err(AnalysisError::wear("find the wear coefficient"))?;
    let service_life = design.limits().service_life;
    let course = |ring: WearingRing| {
        let WearingRing { case, meshing, parts, factors, .. } = ring;
        let parts = StageFollower::new(parts, case.clone(), meshing.clone(), exposure);
        (Course::of(CoupledWear::with(case, meshing, options), parts, exposure, service_life), factors)
    };
    Ok(Courses::new(rings.into_iter().map(course).collect(), design.limits().lost_motion))
}

/// Computes the wear of a new drive over some hours of its duty; `set_stage_wear` receives every stage, its surfaces and its parts.
///
/// # Errors
/// As [`courses`]; [`AnalysisError::Stopped`] when the host requests it.
pub(super) fn wear_down<D: EccentricDrive>(
    design: &D,
    discs: &[ElasticDiscs],
    hours: f64,
    progress: &dyn Progress,
    mut set_stage_wear: impl FnMut(usize, (&[Relief], &[Relief]), &PartWear),
) -> Result<(), AnalysisError> {
    if hours > 0.0 {
        let mut courses = courses(design, discs, CoupledOptions::default())?;
        courses.advance_to(hours, progress).map_err(AnalysisError::wear("compute the wear"))?;
        for (stage, (state, mesh)) in courses.states().iter().zip(design.meshes()).enumerate() {
            let surfaces = &state.surfaces;
            let flanks = surfaces.effective_flanks().iter().map(|flank| mesh.relief.plus(flank));
            let flanks: Vec<Relief> = flanks.collect();
            set_stage_wear(stage, (&flanks, surfaces.effective_pins()), &state.part_wear);
        }
    }
    Ok(())
}

/// Static equilibria, each from the one before.
pub(super) struct Rests<'a> {
    held: HeldDrive,
    start: Option<Vec<f64>>,
    progress: &'a dyn Progress,
}

impl<'a> Rests<'a> {
    /// States of a drive after some hours of its duty.
    ///
    /// # Errors
    /// As [`EccentricDrive::held`].
    pub fn new(
        design: &impl EccentricDrive,
        discs: &[ElasticDiscs],
        hours: f64,
        progress: &'a dyn Progress,
    ) -> Result<Rests<'a>, AnalysisError> {
        Ok(Rests { held: design.held(discs, hours, progress)?, start: None, progress })
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
        let (place, _) = found.map_err(AnalysisError::compute("find a static equilibrium"))?;
        self.start = Some(self.held.deviation(angle, &place));
        Ok(place)
    }

    /// The torque cycle to ± rated and back with the input held at an angle (rad), with friction stage by stage.
    ///
    /// # Errors
    /// [`AnalysisError`] where a balance is not found, or the host stops it.
    pub fn cycle(&self, angle: f64, friction: &[StageFriction]) -> Result<Vec<LoopPoint>, AnalysisError> {
        if self.progress.is_cancelled() {
            return Err(AnalysisError::Stopped);
        }
        eccentric_loop(&self.held, friction, angle).map_err(AnalysisError::compute("cycle the torque"))
    }

    pub fn joints(&self) -> &EccentricJoints {
        self.held.joints()
    }

    /// Angle in rad of the output less its nominal angle, in the last equilibrium.
    pub fn output_error(&self, place: &[f64]) -> f64 {
        self.held.output_error(place)
    }
}
