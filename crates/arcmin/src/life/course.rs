//! Wear of flanks, pins, bearings and gears over running hours, computed together.

use super::PartsFollower;
use crate::analyses::AnalysisError;
use crate::dynamics::JointSettings;
use crate::fidelity::{Fidelity, MachineMeshing};
use crate::geometry::Relief;
use crate::load::ShareLoad;
use crate::machine::{Machine, PartWear};
use crate::progress::Progress;
use crate::units::HOUR;
use crate::wear::calibrate::coupled_exposure;
use crate::wear::{CoupledOptions, CoupledWear, Exposure, WearCase, WearError, WearSnapshot};

/// The machine after some hours of its duty.
#[derive(Debug, Clone, PartialEq)]
pub struct WornState {
    /// Running hours since new.
    pub hours: f64,
    /// Wear of flanks and pins.
    pub surfaces: WearSnapshot,
    /// Wear of bearings and gears.
    pub part_wear: PartWear,
}

impl WornState {
    /// The new machine.
    pub fn new() -> WornState {
        WornState::uniform(0.0)
    }

    /// A uniform depth (m) removed from every flank; pins, bearings and gears as new.
    pub fn uniform(depth: f64) -> WornState {
        WornState { hours: 0.0, surfaces: WearSnapshot::uniform(depth), part_wear: PartWear::default() }
    }

    /// Largest depth lost by a flank, in m.
    pub fn deepest(&self) -> f64 {
        self.surfaces.flank().deepest().0
    }

    /// Applies the present state to joints: wear of the surfaces in addition to the modification of the design, and
    /// wear of the parts.
    pub fn apply_to<S: ShareLoad>(&self, designed: &Relief, joints: &mut S) {
        self.surfaces.apply_to(designed, joints);
        joints.set_part_wear(&self.part_wear);
    }

    /// Settings of the multibody model with this wear in place of its own.
    pub fn on(&self, settings: JointSettings) -> JointSettings {
        JointSettings {
            flank_wear: self.surfaces.effective_flanks().to_vec(),
            pin_wear: self.surfaces.effective_pins().to_vec(),
            part_wear: self.part_wear,
            ..settings
        }
    }

    /// Effective flank and pin of the first disc, averaged over the contact width.
    pub fn first(&self) -> (&Relief, &Relief) {
        (self.surfaces.effective_flank(), self.surfaces.effective_pin())
    }
}

impl Default for WornState {
    fn default() -> WornState {
        WornState::new()
    }
}

/// Intervals of the service life. At their ends the wear of flanks and pins is passed to the computation of bearings
/// and gears and vice versa, and between the rings of a drive of two rings. The number is the same for every
/// analysis, so that "after H hours" is one state; twice as many intervals change the growth of the clearances by
/// less than 1 % (tested).
const INTERVALS: usize = 30;

/// Wear of parts other than flanks and pins, on the drive with its present surfaces.
pub trait OtherParts {
    /// Whether any of these parts wears.
    fn wear_at_all(&self) -> bool;

    /// Updates the surfaces of flanks and pins.
    fn set_surfaces(&mut self, surfaces: &WearSnapshot);

    /// Advances the wear of these parts by `time` (s) at the loads of the present state.
    ///
    /// # Errors
    /// [`WearError::Load`] where no balance is found.
    fn advance(&mut self, time: f64) -> Result<(), WearError>;

    /// Wear of these parts since new.
    fn wear(&self) -> PartWear;

    /// Updates the surfaces of another ring of the same drive, given by its number.
    fn set_other_surfaces(&mut self, _ring: usize, _designed: &Relief, _surfaces: &WearSnapshot) {}
}

/// Only flanks and pins wear.
impl OtherParts for () {
    fn wear_at_all(&self) -> bool {
        false
    }

    fn set_surfaces(&mut self, _: &WearSnapshot) {}

    fn advance(&mut self, _: f64) -> Result<(), WearError> {
        Ok(())
    }

    fn wear(&self) -> PartWear {
        PartWear::default()
    }
}

/// A drive at some running hours, and the means to advance it.
pub struct Course<S: ShareLoad, P: OtherParts> {
    wear: CoupledWear<S>,
    parts: P,
    exposure: Exposure,
    hours: f64,
    /// h; intervals are shares of it.
    service_hours: f64,
    intermediate: IntermediateStates,
}

/// An RV reducer at some running hours.
pub type MachineCourse<'a> = Course<MachineMeshing, PartsFollower<'a>>;

/// Intermediate states at equal numbers of updates, a bounded number of them: the results of a machine whose wear
/// runs away before the next station.
#[derive(Debug, Clone)]
struct IntermediateStates {
    states: Vec<WornState>,
    /// Updates from one state to the next, and since the last one.
    every: usize,
    since: usize,
}

/// Least number of stored states after at least as many updates; the largest is twice this number less one.
const LEAST_STATES: usize = 12;

impl IntermediateStates {
    fn new() -> IntermediateStates {
        IntermediateStates { states: Vec::new(), every: 1, since: 0 }
    }

    fn add(&mut self, state: impl FnOnce() -> WornState) {
        self.since += 1;
        if self.since < self.every {
            return;
        }
        self.since = 0;
        self.states.push(state());
        if self.states.len() == 2 * LEAST_STATES {
            self.every *= 2;
            let mut number = 0_usize;
            self.states.retain(|_| {
                number += 1;
                number.is_multiple_of(2)
            });
        }
    }
}

impl<'a> MachineCourse<'a> {
    /// The new machine. The wear coefficient is a property of the design: if it must be calibrated, this is done for
    /// the nominal machine.
    ///
    /// # Errors
    /// [`AnalysisError`] if the machine has no such model, or the calibration fails.
    pub fn new(
        machine: &'a Machine,
        fidelity: &Fidelity,
        options: CoupledOptions,
    ) -> Result<MachineCourse<'a>, AnalysisError> {
        let exposure = coupled_exposure(machine, fidelity.nominal().meshing(machine)?, options)
            .map_err(AnalysisError::wear("find the wear coefficient"))?;
        MachineCourse::with_exposure(machine, fidelity, options, exposure)
    }

    /// The new machine with a given wear coefficient.
    ///
    /// # Errors
    /// As [`MachineCourse::new`].
    pub fn with_exposure(
        machine: &'a Machine,
        fidelity: &Fidelity,
        options: CoupledOptions,
        exposure: Exposure,
    ) -> Result<MachineCourse<'a>, AnalysisError> {
        let wear = CoupledWear::with(machine, fidelity.meshing(machine)?, options);
        let parts = PartsFollower::with(machine, fidelity.in_bearings(machine)?);
        Ok(Course::of(wear, parts, exposure, machine.limits.service_life))
    }
}

impl<S: ShareLoad, P: OtherParts> Course<S, P> {
    /// The new drive; `service_life` in s.
    pub fn of(wear: CoupledWear<S>, parts: P, exposure: Exposure, service_life: f64) -> Course<S, P> {
        Course {
            wear: wear.on_clock(&exposure),
            parts,
            exposure,
            hours: 0.0,
            service_hours: service_life / HOUR,
            intermediate: IntermediateStates::new(),
        }
    }

    /// See [`CoupledWear::allow_waves`].
    pub(super) fn allow_waves(&mut self) {
        self.wear.allow_waves();
    }

    /// Geometry, duty and wear laws of the drive.
    pub fn case(&self) -> &WearCase {
        self.wear.case()
    }

    /// The wear coefficient over time.
    pub fn exposure(&self) -> &Exposure {
        &self.exposure
    }

    /// Planned service life in h.
    pub fn service_hours(&self) -> f64 {
        self.service_hours
    }

    /// Running hours reached.
    pub fn hours(&self) -> f64 {
        self.hours
    }

    /// Updates of the flank so far.
    pub fn updates(&self) -> usize {
        self.wear.updates()
    }

    /// The machine as it is now.
    pub fn state(&self) -> WornState {
        WornState { hours: self.hours, surfaces: self.wear.state().clone(), part_wear: self.parts.wear() }
    }

    /// Intermediate states after these hours.
    pub fn intermediate_states_after(&self, hours: f64) -> impl Iterator<Item = &WornState> {
        self.intermediate.states.iter().filter(move |state| state.hours > hours)
    }

    /// Load sharing with the present surfaces.
    pub fn meshing(&mut self) -> &mut S {
        self.wear.meshing_mut()
    }

    /// Updates the surfaces of another ring of the same drive, given by its number.
    pub(super) fn set_other_surfaces(&mut self, ring: usize, designed: &Relief, surfaces: &WearSnapshot) {
        self.wear.set_other_ring(ring, designed, surfaces);
        self.parts.set_other_surfaces(ring, designed, surfaces);
    }

    /// The next end of an interval, `hours` at most.
    pub(super) fn next_interval(&self, hours: f64) -> f64 {
        let interval = self.service_hours / INTERVALS as f64;
        let next = (((self.hours / interval) + 1e-9).floor() + 1.0) * interval;
        next.min(hours)
    }

    /// Goes on to the given hours.
    ///
    /// # Errors
    /// [`WearError`]; `Stopped` when `progress` was cancelled, `RunsAwayAt` when the wear runs away.
    pub fn advance_to(&mut self, hours: f64, progress: &dyn Progress) -> Result<(), WearError> {
        while self.hours < hours {
            let next = self.next_interval(hours);
            if self.parts.wear_at_all() {
                self.parts.set_surfaces(self.wear.state());
                self.parts.advance((next - self.hours) * HOUR)?;
                self.wear.set_part_wear(&self.parts.wear());
            }
            let mut stopped = false;
            let (exposure, parts, intermediate) = (&self.exposure, &self.parts, &mut self.intermediate);
            let goes_on = self.wear.advance_until(exposure.at(next * HOUR), |surfaces| {
                intermediate.add(|| WornState {
                    hours: exposure.time_at(surfaces.exposure) / HOUR,
                    surfaces: surfaces.clone(),
                    part_wear: parts.wear(),
                });
                stopped = progress.is_cancelled();
                stopped
            });
            goes_on.map_err(|error| match error {
                WearError::RunsAway { exposure: reached, depth_um } => {
                    WearError::RunsAwayAt { hours: exposure.time_at(reached) / HOUR, depth_um }
                }
                error => error,
            })?;
            if stopped {
                return Err(WearError::Stopped);
            }
            self.hours = next;
        }
        self.parts.set_surfaces(self.wear.state());
        Ok(())
    }
}

/// The machine after some hours at its duty, in the given fidelity. All analyses use this state.
///
/// # Errors
/// [`AnalysisError`] where no load sharing or no wear coefficient is found, or the host stops it.
pub fn worn_after(
    machine: &Machine,
    fidelity: &Fidelity,
    hours: f64,
    progress: &dyn Progress,
) -> Result<WornState, AnalysisError> {
    if hours == 0.0 {
        return Ok(WornState::new());
    }
    let mut course = MachineCourse::new(machine, fidelity, CoupledOptions::default())?;
    course.advance_to(hours, progress).map_err(AnalysisError::wear("compute the wear"))?;
    Ok(course.state())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For any number of updates between 12 and 24 states are kept at equal numbers of updates, and the last of them
    /// is near the end.
    #[test]
    fn intermediate_states_keep_a_dozen_states_of_any_number() {
        for updates in [5, 12, 23, 24, 100, 1000, 1033] {
            let mut intermediate = IntermediateStates::new();
            for update in 1..=updates {
                intermediate.add(|| WornState { hours: update as f64, ..WornState::new() });
            }
            let hours: Vec<f64> = intermediate.states.iter().map(|state| state.hours).collect();
            assert!(
                hours.len() >= LEAST_STATES.min(updates) && hours.len() < 2 * LEAST_STATES,
                "{updates}: {hours:?}"
            );
            let step = hours[1] - hours[0];
            assert!(hours.windows(2).all(|pair| pair[1] - pair[0] == step), "{updates}: {hours:?}");
            assert!(updates as f64 - hours[hours.len() - 1] < step, "{updates}: {hours:?}");
        }
    }
}
