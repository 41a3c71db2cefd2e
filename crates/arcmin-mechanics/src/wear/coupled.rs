//! Wear coupled to the load sharing: the worn flank changes the load sharing, which changes the wear rates.

use std::sync::Arc;

use super::deposit::FlankArc;
use super::smoothing::ContactAverage;
use super::{Exposure, WearCase, WearError};
use crate::geometry::Relief;
use crate::load::{Meshing, ShareLoad};
use crate::machine::{Machine, PartWear};
use crate::tribology::LocalRate;
use crate::units::UM;

mod rates;
mod snapshot;
mod stiff;

use rates::Rates;
pub use snapshot::WearSnapshot;
use stiff::Stiffness;

/// Numerical parameters of the coupled prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoupledOptions {
    /// Points on one tooth's flank, both sides together.
    pub flank_points: usize,
    /// Points on the circumference of a pin.
    pub pin_points: usize,
    /// Crank positions per pin pitch at each update of the flank.
    pub crank_positions: usize,
    /// Upper limit of the depth increment per update in m, in addition to the limit of the tolerance.
    pub depth_increment: f64,
    /// The same as a fraction of the depth reached; the larger of the two applies.
    pub increment_share: f64,
    /// Largest difference between Euler's and Heun's method after an update, anywhere, in m. It is the error of
    /// Euler's method; that of Heun's, whose result is used, is smaller.
    pub tolerance: f64,
    /// Upper limit of the increment for drives that repeat after many pitches, in m and as a fraction of the
    /// depth reached. An update then uses few of the positions, and larger increments cause waves of the flank
    /// (tests check their smallest curvature and the effect of more positions).
    pub few_places: [f64; 2],
    /// The same as a fraction of the approach of the contact with the largest load. With small loads on wide
    /// flanks this approach is small, and waves of a similar size determine which pins carry load.
    pub approach_share: f64,
}

impl Default for CoupledOptions {
    fn default() -> CoupledOptions {
        CoupledOptions {
            flank_points: 720,
            pin_points: 1440,
            crank_positions: 15,
            depth_increment: 0.8 * UM,
            increment_share: 0.01,
            tolerance: 0.06 * UM,
            few_places: [0.08 * UM, 0.02],
            approach_share: 0.15,
        }
    }
}

impl CoupledOptions {
    /// For computations whose updates are the points of a linearly interpolated curve: increments so small that
    /// the error of the interpolation is below that of the updates.
    pub fn for_curves(self) -> CoupledOptions {
        CoupledOptions { depth_increment: self.depth_increment.min(0.08 * UM), increment_share: 0.05, ..self }
    }
}

fn runs_away(exposure: f64, depth: f64) -> WearError {
    WearError::RunsAway { exposure, depth_um: depth / UM }
}

/// Ratio of depth to pin radius at which flank or pin count as worn out.
pub(crate) const WORN_OUT: f64 = 0.25;
/// Ratio to the limit of lost motion, which counts as `LEAST_LIMIT` at least, at which the lost motion by the
/// flanks alone ends the computation: an assumption, larger than any value of practical interest.
const PAST_USE: f64 = 10.0;
/// rad; a tighter limit is a requirement of the application and does not describe the end of use.
const LEAST_LIMIT: f64 = crate::units::ARCMIN;
/// Ratio of depth to pin radius from which on a failed load sharing is reported as runaway wear.
const RUN_AWAY: f64 = 0.02;
/// The tolerance as a fraction of the depth reached, which applies beyond 30 µm.
const TOLERANCE_SHARE: f64 = 2e-3;
/// Lightly loaded contacts do not reduce the increment below this fraction of the depth reached.
const LIGHT_DEPTH_SHARE: f64 = 2e-3;
/// Upper limit of the first increment, in m, for which no error estimate exists.
const FIRST_INCREMENT: f64 = 0.08 * UM;
/// Largest increment, in m and as a fraction of the depth reached, that is sufficient for hours with two digits (tested).
/// The error of the updates still applies.
pub const FOR_TWO_DIGITS: [f64; 2] = [0.4 * UM, 0.06];
/// Number of midpoint updates between two of Heun's method, which alone estimates the error.
const UNCHECKED_UPDATES: usize = 5;
/// Steps with a smaller increment, in m, are not shortened if their error is too large.
const LEAST_INCREMENT: f64 = 0.01 * UM;

/// Depth in m of flank or pin at which the use of a machine ends: a quarter of the pin's radius, or `PAST_USE`
/// times the limit of lost motion. A depth h on both flanks gives a rotation of the output of 2 h/l, where l =
/// e z_c/m is the largest lever arm of a pin.
pub fn depth_past_use(case: &WearCase) -> f64 {
    let lost_motion = PAST_USE * case.lost_motion.max(LEAST_LIMIT);
    let open = 0.5 * lost_motion * case.profile.largest_lever_arm();
    open.min(WORN_OUT * case.pin_radius)
}

/// Approach in m of the most loaded contact of the new flank at the largest torque of the duty.
fn largest_approach(case: &WearCase) -> f64 {
    let at = case.profile.short_width_coefficient().min(1.0);
    let curvature = case.profile.relative_curvature(at, case.pin_radius).max(1.0);
    case.contact.approach(case.largest_force, 1.0 / curvature)
}

/// The computation in progress: advances in exposure and returns snapshots.
#[derive(Debug)]
pub struct CoupledWear<S: ShareLoad = Meshing> {
    case: Arc<WearCase>,
    options: CoupledOptions,
    law: Box<dyn LocalRate>,
    /// Relation of time and exposure, needed by laws that depend on time.
    clock: Option<Exposure>,
    arc: FlankArc,
    average: ContactAverage,
    meshing: S,
    state: WearSnapshot,
    /// Depth in m at which the use of the machine ends.
    past_use: f64,
    /// Approach in m of the most loaded contact of the new machine, by the closed form.
    approach: f64,
    updates: usize,
    /// Exposure of the next update, as estimated from the last one.
    step: Option<f64>,
    /// Data for a midpoint update.
    recent: Option<Recent>,
    /// Data for a long step of many stages.
    stiffness: Option<Stiffness>,
    /// Whether waves of the flank do not limit the increments.
    allows_waves: bool,
    /// Number of sets of crank positions used so far, so that every evaluation uses a different one.
    places: usize,
    /// Last solution for each duty row and crank position: start of the next one.
    starts: Vec<Option<S::Start>>,
}

/// Result of the last update, for a midpoint update.
#[derive(Debug)]
struct Recent {
    rates: Rates,
    /// Number of updates left without an error estimate.
    unchecked: usize,
}

/// One step of `wanted`, or the first of two equal steps if the last one would be very small.
fn equal_last_steps(left: f64, wanted: f64) -> f64 {
    if left > 2.0 * wanted { wanted } else { (left / (left / wanted).ceil()).min(left) }
}

impl CoupledWear {
    /// With ideal joints.
    pub fn new(machine: &Machine, options: CoupledOptions) -> CoupledWear {
        CoupledWear::with(machine, machine.meshing(&Relief::uniform(0.0)), options)
    }
}

impl<S: ShareLoad> CoupledWear<S> {
    /// With the joints of `meshing`, whose flanks and pins are set to those of the new machine.
    pub fn with(case: impl Into<WearCase>, meshing: S, options: CoupledOptions) -> CoupledWear<S> {
        let case = case.into();
        let discs = if meshing.discs_alike() { 1 } else { case.disc_count };
        // Pins without wear share one surface.
        let pins =
            if meshing.discs_alike() || case.wear.pin_ratio == 0.0 { 1 } else { discs * case.pin_count() };
        let state = WearSnapshot::unworn(&options, discs, pins);
        let arc = FlankArc::new(&case.profile, options.flank_points);
        CoupledWear {
            average: ContactAverage::new(&case, &arc, options.pin_points),
            arc,
            meshing,
            starts: vec![None; case.duty.len() * options.crank_positions],
            law: case.wear.law.local_rate(),
            clock: None,
            options,
            state,
            past_use: depth_past_use(&case),
            approach: largest_approach(&case),
            case: Arc::new(case),
            updates: 0,
            step: None,
            recent: None,
            stiffness: None,
            allows_waves: false,
            places: 0,
        }
    }

    /// Continues until flank or pin are worn out, independent of the lost motion: for depths that were
    /// measured.
    pub(super) fn at_any_play(mut self) -> Self {
        self.past_use = WORN_OUT * self.case.pin_radius;
        self
    }

    /// Sets the relation of time and exposure. Laws that depend on time need it; it has no effect on others.
    pub fn on_clock(mut self, clock: &Exposure) -> Self {
        self.clock = Some(*clock);
        self
    }

    /// Replaces the machine's wear law by another one.
    pub fn with_law(mut self, law: Box<dyn LocalRate>) -> Self {
        self.law = law;
        self
    }

    /// Lengthens the updates of drives that repeat after many pitches, for which the waves of the flank that this causes do
    /// not matter.
    pub fn allow_waves(&mut self) {
        self.allows_waves = true;
    }

    /// The joints, with the present surfaces.
    pub fn meshing_mut(&mut self) -> &mut S {
        self.state.apply_to(&self.case.designed, &mut self.meshing);
        &mut self.meshing
    }

    /// Sets the wear of bearings and gears, for joints that include it.
    pub fn set_part_wear(&mut self, wear: &PartWear) {
        self.meshing.set_part_wear(wear);
    }

    /// Sets the surfaces of another ring of the drive, for joints that include it.
    pub fn set_other_ring(&mut self, ring: usize, designed: &Relief, surfaces: &WearSnapshot) {
        surfaces.apply_to_other_ring(ring, designed, &mut self.meshing);
    }

    /// The drive with its laws of wear.
    pub fn case(&self) -> &WearCase {
        &self.case
    }

    /// Present surfaces.
    pub fn state(&self) -> &WearSnapshot {
        &self.state
    }

    /// Updates of the flank done so far.
    pub fn updates(&self) -> usize {
        self.updates
    }

    /// Advances to the exposure `target` (s/Pa) by Heun's method, with steps limited by the difference from
    /// Euler's method. If the step is limited by the number of positions in an update, five of six updates use
    /// the midpoint extrapolated with the last rates, with one evaluation of the contacts instead of two. If it
    /// is limited by contacts of nearly equal shape, five of six are long steps of many stages. Without wear
    /// (no torque, no speed) the surfaces do not change.
    ///
    /// # Errors
    /// [`WearError`] when a load sharing fails; [`WearError::RunsAway`] when flank or pin have lost
    /// `depth_past_use`, or more than `RUN_AWAY` of the pin's radius and no load sharing is found any more.
    /// The state is then the last one that held.
    pub fn advance_to(&mut self, target: f64) -> Result<(), WearError> {
        self.advance_until(target, |_| false)
    }

    /// Advances until `done` returns true or the exposure `target` is reached; `done` is called with the state
    /// after each update.
    ///
    /// # Errors
    /// As [`CoupledWear::advance_to`].
    pub fn advance_until(
        &mut self,
        target: f64,
        mut done: impl FnMut(&WearSnapshot) -> bool,
    ) -> Result<(), WearError> {
        while self.state.exposure < target {
            let wears = self.update(target)?;
            if done(&self.state) || !wears {
                break;
            }
        }
        Ok(())
    }

    /// One update of the surfaces, to `target` at most; `false` without wear, when the surfaces do not change.
    fn update(&mut self, target: f64) -> Result<bool, WearError> {
        let before = self.state.clone();
        let depth = before.flank().deepest().0.max(before.pin().deepest().0);
        if depth > self.past_use {
            return Err(runs_away(before.exposure, depth));
        }
        let quick = self
            .update_by_midpoint(&before, depth, target)
            .or_else(|| self.update_by_stages(&before, depth, target));
        let step = match quick {
            None => self.update_by_heun(&before, depth, target)?,
            step => step,
        };
        let Some(step) = step else { return Ok(false) };
        if target - before.exposure - step < 1e-12 * target {
            self.state.exposure = target;
        }
        self.updates += 1;
        self.places += 1;
        Ok(true)
    }

    /// The update with the rates at the midpoint, extrapolated with those of the last update; `None` if an
    /// error estimate is due, or if a load sharing fails there: Heun's method then tries shorter steps.
    fn update_by_midpoint(&mut self, before: &WearSnapshot, depth: f64, target: f64) -> Option<f64> {
        let Recent { rates: last, unchecked } = self.recent.take()?;
        let largest = last.largest();
        if unchecked == 0 || !(largest > 0.0) {
            return None;
        }
        let step = equal_last_steps(target - before.exposure, self.next_step(depth, largest));
        let halfway = self.advanced(before, &[(&last, 0.5 * step)]);
        let rates = self.rates(&halfway).ok()?;
        self.state = self.advanced(before, &[(&rates, step)]);
        self.recent = Some(Recent { rates, unchecked: unchecked - 1 });
        Some(step)
    }

    /// The update by Heun's method with its error estimate; `None` without wear.
    fn update_by_heun(
        &mut self,
        before: &WearSnapshot,
        depth: f64,
        target: f64,
    ) -> Result<Option<f64>, WearError> {
        let pin_radius = self.case.pin_radius;
        let lost = |error: WearError| match error {
            WearError::Load(_) if depth > RUN_AWAY * pin_radius => runs_away(before.exposure, depth),
            error => error,
        };
        let first = self.rates(before).map_err(&lost)?;
        let largest = first.largest();
        if !(largest > 0.0) {
            // Without a finite target the computation would not end.
            if self.updates == 0 && target == f64::MAX {
                return Err(WearError::NoWear);
            }
            // No speed, no torque, or a law with a threshold that no pressure exceeds any more.
            self.state.exposure = target;
            return Ok(None);
        }
        let wanted = self.next_step(depth, largest);
        let planned = equal_last_steps(target - before.exposure, wanted);
        let mut step = planned;
        let tolerance = self.options.tolerance.max(TOLERANCE_SHARE * depth);
        let (second, error) = loop {
            let predicted = self.advanced(before, &[(&first, step)]);
            let may_shrink = step * largest > LEAST_INCREMENT;
            match self.rates(&predicted) {
                Err(WearError::Load(_)) if may_shrink => step *= 0.25,
                Err(error) => return Err(lost(error)),
                Ok(second) => {
                    let error = 0.5 * step * first.largest_difference(&second);
                    if !(error > 2.0 * tolerance && may_shrink) {
                        break (second, error);
                    }
                    step *= (0.9 * (tolerance / error).sqrt()).max(0.2);
                }
            }
        };
        self.state = self.advanced(before, &[(&first, 0.5 * step), (&second, 0.5 * step)]);
        let growth = 0.9 * (tolerance / error).sqrt();
        let next = step * growth.clamp(0.3, 2.0);
        // A step shortened by the target does not limit the next one.
        self.step = Some(if step == planned && planned < wanted { next.max(wanted) } else { next });
        let bound = self.largest_increment(depth) / largest;
        let taken = Rates::sum(&[(&first, 0.5), (&second, 0.5)]).largest();
        self.estimate_stiffness(depth, self.next_step(depth, largest), taken);
        // The limit is not the error but the number of positions in an update.
        if self.meshing.pitches() > 1 && step * growth > bound {
            self.recent = Some(Recent { rates: second, unchecked: UNCHECKED_UPDATES });
        }
        Ok(Some(step))
    }

    /// Exposure of the next update by the last estimate and the largest increment.
    fn next_step(&self, depth: f64, largest: f64) -> f64 {
        let step = self.step.unwrap_or(FIRST_INCREMENT / largest);
        step.min(self.largest_increment(depth) / largest)
    }

    /// Largest increment of an update for the largest wear depth `depth`, both in m.
    fn largest_increment(&self, depth: f64) -> f64 {
        let most = self.options.depth_increment.max(self.options.increment_share * depth);
        if self.meshing.pitches() > 1 && self.allows_waves {
            FOR_TWO_DIGITS[0].max(FOR_TWO_DIGITS[1] * depth)
        } else if self.meshing.pitches() > 1 {
            let [increment, share] = self.options.few_places;
            let light = (self.options.approach_share * self.approach)
                .max(LIGHT_DEPTH_SHARE * depth)
                .max(LEAST_INCREMENT);
            most.min(increment.max(share * depth)).min(light)
        } else {
            most
        }
    }
}

impl Machine {
    /// Exposure curve of this machine with its coupled coefficient, calibrated on the coupled prediction if
    /// required. Ideal joints.
    ///
    /// # Errors
    /// [`WearError`] when the prediction fails or the target is out of reach.
    pub fn coupled_exposure(&self, options: CoupledOptions) -> Result<Exposure, WearError> {
        super::calibrate::coupled_exposure(self, self.meshing(&Relief::uniform(0.0)), options)
    }
}
