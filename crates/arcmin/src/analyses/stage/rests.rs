use crate::analyses::AnalysisError;
use crate::design::StageDesign;
use crate::dynamics::{
    DynamicsError, EquilibriumControl, SingleStageJoints, by_larger_loads, solve_equilibrium_unless,
};
use crate::progress::Progress;

/// States of rest of a single stage, each from the one before.
pub(super) struct Rests<'a> {
    pub joints: SingleStageJoints,
    rated: f64,
    /// Of the ring at rest over the torque at the output.
    factor: f64,
    place: Option<(f64, Vec<f64>)>,
    progress: &'a dyn Progress,
}

/// Steps of 1e-7′ at the output, forces of 1e-9 N: as the bench of RV reducers.
const CONTROL: EquilibriumControl = EquilibriumControl { tolerance: 1e-7, force_tolerance: 1e-9, held: None };

impl<'a> Rests<'a> {
    pub fn new(design: &StageDesign, progress: &'a dyn Progress) -> Result<Rests<'a>, AnalysisError> {
        let joints =
            design.stage().joints().map_err(AnalysisError::compute("build the drive from its design"))?;
        let rated = design.rated().torque.abs() * design.seen_from_ring();
        Ok(Rests { joints, rated, factor: design.seen_from_ring(), place: None, progress })
    }

    /// The state with the input held at an angle (rad) against the ring, under an output torque in N·m that opposes
    /// positive motion.
    pub fn at(&mut self, angle: f64, torque: f64) -> Result<Vec<f64>, AnalysisError> {
        let (joints, progress) = (&mut self.joints, self.progress);
        joints.hold_input(angle, 0.0);
        let nominal = joints.nominal_position_at(angle);
        let start: Vec<f64> = match self.place.take() {
            Some((before, place)) => {
                let moved = nominal.iter().zip(joints.nominal_position_at(before));
                place.iter().zip(moved).map(|(q, (now, then))| q + now - then).collect()
            }
            None => nominal.clone(),
        };
        let mut find = |load: f64, start: &[f64]| {
            joints.set_load(load);
            let cancelled = || progress.is_cancelled();
            solve_equilibrium_unless(&**joints, 0.0, start, CONTROL, &cancelled).map(|found| found.position)
        };
        let load = torque * self.factor;
        let found = match find(load, &start) {
            Err(DynamicsError::NoEquilibrium { .. }) => {
                by_larger_loads(load, self.rated, |load, near| find(load, near.unwrap_or(&nominal)))
            }
            found => found,
        };
        let place = found.map_err(|error| match error {
            DynamicsError::Cancelled { .. } => AnalysisError::Stopped,
            error => AnalysisError::compute("find a state of rest")(error),
        })?;
        self.place = Some((angle, place.clone()));
        Ok(place)
    }

    /// Angle in rad of the output against its nominal one.
    pub fn output_error(&self, place: &[f64]) -> f64 {
        self.factor * self.joints.output_error(place)
    }
}
