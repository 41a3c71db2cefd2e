//! Wear coupled to the load sharing: the worn flank moves the load, the load moves the wear.

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

/// Numerical choices of the coupled prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoupledOptions {
    /// Points on one tooth's flank, both sides together.
    pub flank_points: usize,
    /// Points on the circumference of a pin.
    pub pin_points: usize,
    /// Crank positions per pin pitch at each update of the flank.
    pub crank_positions: usize,
    /// Largest increment of the depth per update in m, in place of a longer one that the tolerance allows.
    pub depth_increment: f64,
    /// The same as a share of the depth reached, where that is more.
    pub increment_share: f64,
    /// By how much Euler's and Heun's method may differ after an update, anywhere, in m. It is the error of the
    /// former; that of the latter, which is taken, is smaller.
    pub tolerance: f64,
    /// Largest increment where it takes many pitches to repeat, in m and as a share of the depth reached: an update then
    /// sees few of the places, and larger ones leave waves on the flank (their least curvature and the need of more
    /// positions are tested).
    pub few_places: [f64; 2],
    /// The same as a share of the approach of the hardest loaded contact, which is small where little load meets wide
    /// flanks: waves that are a part of what contacts give way decide which pins carry.
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
    /// For a computation whose updates are the points of a curve that is read by straight lines: so close that
    /// the lines leave less than the updates.
    pub fn for_curves(self) -> CoupledOptions {
        CoupledOptions { depth_increment: self.depth_increment.min(0.08 * UM), increment_share: 0.05, ..self }
    }
}

fn runs_away(exposure: f64, depth: f64) -> WearError {
    WearError::RunsAway { exposure, depth_um: depth / UM }
}

/// Depth over pin radius at which flank or pin are gone.
pub(crate) const WORN_OUT: f64 = 0.25;
/// Times the limit of lost motion, of `LEAST_LIMIT` at least, that the flanks alone open in a machine past
/// any use: an assumption, so far beyond what anybody runs that no history of interest ends there.
const PAST_USE: f64 = 10.0;
/// rad; a tighter limit is a wish of the application and does not say what a machine can go on with.
const LEAST_LIMIT: f64 = crate::units::ARCMIN;
/// Depth over pin radius from which on a load sharing that is not found means that wear has run away.
const RUN_AWAY: f64 = 0.02;
/// The tolerance as a share of the depth reached, which takes over beyond 30 µm.
const TOLERANCE_SHARE: f64 = 2e-3;
/// An increment is never less than this share of the depth reached for the sake of lightly loaded contacts.
const LIGHT_DEPTH_SHARE: f64 = 2e-3;
/// The first update takes off this much at most, in m: no error of a step is known yet.
const FIRST_INCREMENT: f64 = 0.08 * UM;
/// Updates by the midpoint between two of Heun's method, which alone tells its error.
const UNCHECKED_UPDATES: usize = 5;
/// A step that takes off less than this, in m, is not made smaller where its error is too large.
const LEAST_INCREMENT: f64 = 0.01 * UM;

/// Depth in m of flank or pin at which a machine is past any use: a quarter of the pin's radius is gone, or
/// the flanks have opened `PAST_USE` times the limit of lost motion. A depth h off both flanks lets the output
/// turn by 2 h/l, where l = e z_c/m is the largest lever arm of a pin.
pub fn depth_past_use(case: &WearCase) -> f64 {
    let lost_motion = PAST_USE * case.lost_motion.max(LEAST_LIMIT);
    let open = 0.5 * lost_motion * case.profile.largest_lever_arm();
    open.min(WORN_OUT * case.pin_radius)
}

/// Approach in m of the hardest loaded contact of the new flank at the largest torque of the duty.
fn hardest_approach(case: &WearCase) -> f64 {
    let at = case.profile.short_width_coefficient().min(1.0);
    let curvature = case.profile.relative_curvature(at, case.pin_radius).max(1.0);
    case.contact.approach(case.largest_force, 1.0 / curvature)
}

/// The running computation: advance it in exposure and read snapshots.
#[derive(Debug)]
pub struct CoupledWear<S: ShareLoad = Meshing> {
    case: Arc<WearCase>,
    options: CoupledOptions,
    law: Box<dyn LocalRate>,
    /// Which time belongs to an exposure; only laws that depend on time need it.
    clock: Option<Exposure>,
    arc: FlankArc,
    average: ContactAverage,
    meshing: S,
    state: WearSnapshot,
    /// Depth in m at which the machine is past any use.
    past_use: f64,
    /// Approach in m of the hardest loaded contact of the new machine, by the closed form.
    approach: f64,
    updates: usize,
    /// Exposure of the next update as the last one would have it.
    step: Option<f64>,
    /// Where the next update may go by the midpoint.
    recent: Option<Recent>,
    /// Where the next update may go by many looks.
    stiffness: Option<Stiffness>,
    /// Sets of crank positions used up: no two looks of different updates meet the same.
    places: usize,
    /// Last solution per duty row and crank position: where the next one starts.
    starts: Vec<Option<S::Start>>,
}

/// Remainder of the last update for one by the midpoint.
#[derive(Debug)]
struct Recent {
    rates: Rates,
    /// Updates that need no look at their error.
    unchecked: usize,
}

/// One step of `wanted`, or the first of equal ones to the end where one of two would be tiny.
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
    /// With the joints of `meshing`, whose flanks and pins become those of the new machine.
    pub fn with(case: impl Into<WearCase>, meshing: S, options: CoupledOptions) -> CoupledWear<S> {
        let case = case.into();
        let discs = if meshing.discs_alike() { 1 } else { case.disc_count };
        // Pins that do not wear need no surface each.
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
            approach: hardest_approach(&case),
            case: Arc::new(case),
            updates: 0,
            step: None,
            recent: None,
            stiffness: None,
            places: 0,
        }
    }

    /// Goes on until flank or pin are gone, whatever play that leaves: for depths that were measured.
    pub(super) fn at_any_play(mut self) -> Self {
        self.past_use = WORN_OUT * self.case.pin_radius;
        self
    }

    /// With the time that belongs to every exposure. Laws that depend on time need it, others take no notice.
    pub fn on_clock(mut self, clock: &Exposure) -> Self {
        self.clock = Some(*clock);
        self
    }

    /// With a law of the caller's own in place of the machine's.
    pub fn with_law(mut self, law: Box<dyn LocalRate>) -> Self {
        self.law = law;
        self
    }

    /// The joints, with the surfaces reached.
    pub fn meshing_mut(&mut self) -> &mut S {
        self.state.put_on(&self.case.designed, &mut self.meshing);
        &mut self.meshing
    }

    /// Replaces what bearings and gears have lost, for joints that know of it.
    pub fn set_part_wear(&mut self, wear: &PartWear) {
        self.meshing.set_part_wear(wear);
    }

    /// Replaces the surfaces of another ring of the drive, for joints that know of it.
    pub fn see_other(&mut self, ring: usize, designed: &Relief, surfaces: &WearSnapshot) {
        surfaces.put_on_other(ring, designed, &mut self.meshing);
    }

    /// The drive that wears.
    pub fn case(&self) -> &WearCase {
        &self.case
    }

    /// Surfaces reached.
    pub fn state(&self) -> &WearSnapshot {
        &self.state
    }

    /// Updates of the flank done so far.
    pub fn updates(&self) -> usize {
        self.updates
    }

    /// Advances to the exposure `target` (s/Pa) by Heun's method, each step as long as its difference from
    /// Euler's lets it be. Where the places that an update sees bind the step, five in six updates go by the midpoint
    /// to which the rates of the last one lead, with one look at the contacts in place of two. Where contacts
    /// that fit closely bind it, five in six are long steps of many looks. Where nothing wears (no torque, no
    /// speed), the surfaces stay as they are.
    ///
    /// # Errors
    /// [`WearError`] when a load sharing fails; [`WearError::RunsAway`] when flank or pin have lost
    /// `depth_past_use`, or more than `RUN_AWAY` of the pin's radius and no load sharing is found any more.
    /// The state is then the last one that held.
    pub fn advance_to(&mut self, target: f64) -> Result<(), WearError> {
        self.advance_until(target, |_| false)
    }

    /// Advances until `done` says so or the exposure `target` is reached; `done` sees the state after each
    /// update.
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

    /// One update of the surfaces, to `target` at most; `false` when nothing wears, which leaves them as they are.
    fn update(&mut self, target: f64) -> Result<bool, WearError> {
        let before = self.state.clone();
        let depth = before.flank().deepest().0.max(before.pin().deepest().0);
        if depth > self.past_use {
            return Err(runs_away(before.exposure, depth));
        }
        let quick = self
            .update_by_midpoint(&before, depth, target)
            .or_else(|| self.update_by_many_looks(&before, depth, target));
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

    /// The update by the rates halfway, where those of the last update lead; `None` where its error is due to be
    /// looked at, or no load sharing is found there: Heun's method tries shorter steps.
    fn update_by_midpoint(&mut self, before: &WearSnapshot, depth: f64, target: f64) -> Option<f64> {
        let Recent { rates: last, unchecked } = self.recent.take()?;
        let largest = last.largest();
        if unchecked == 0 || !(largest > 0.0) {
            return None;
        }
        let step = equal_last_steps(target - before.exposure, self.wanted_step(depth, largest));
        let halfway = self.advanced(before, &[(&last, 0.5 * step)]);
        let rates = self.rates(&halfway).ok()?;
        self.state = self.advanced(before, &[(&rates, step)]);
        self.recent = Some(Recent { rates, unchecked: unchecked - 1 });
        Some(step)
    }

    /// The update by Heun's method with its estimate of the error; `None` when nothing wears.
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
            // An endless way to a depth that is never reached is another matter.
            if self.updates == 0 && target == f64::MAX {
                return Err(WearError::NoWear);
            }
            // No speed, no torque, or a law with a threshold that no pressure exceeds any more.
            self.state.exposure = target;
            return Ok(None);
        }
        let wanted = self.wanted_step(depth, largest);
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
        // A step cut short by the target says nothing against a longer one.
        self.step = Some(if step == planned && planned < wanted { next.max(wanted) } else { next });
        let bound = self.largest_increment(depth) / largest;
        let taken = Rates::sum(&[(&first, 0.5), (&second, 0.5)]).largest();
        self.look_for_stiffness(depth, self.wanted_step(depth, largest), taken);
        // Not the error, but the places that an update sees.
        if self.meshing.pitches() > 1 && step * growth > bound {
            self.recent = Some(Recent { rates: second, unchecked: UNCHECKED_UPDATES });
        }
        Ok(Some(step))
    }

    /// Exposure of the next update, where the last one and the largest increment have their way.
    fn wanted_step(&self, depth: f64, largest: f64) -> f64 {
        let step = self.step.unwrap_or(FIRST_INCREMENT / largest);
        step.min(self.largest_increment(depth) / largest)
    }

    /// Largest increment of an update where the deepest place has lost `depth`, both in m.
    fn largest_increment(&self, depth: f64) -> f64 {
        let most = self.options.depth_increment.max(self.options.increment_share * depth);
        if self.meshing.pitches() > 1 {
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
    /// Exposure curve of this machine from its coupled coefficient, calibrated on the coupled prediction
    /// where asked for. Ideal joints.
    ///
    /// # Errors
    /// [`WearError`] when the prediction fails or the target is out of reach.
    pub fn coupled_exposure(&self, options: CoupledOptions) -> Result<Exposure, WearError> {
        super::calibrate::coupled_exposure(self, self.meshing(&Relief::uniform(0.0)), options)
    }
}
