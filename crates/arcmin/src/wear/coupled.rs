//! Wear coupled to the load sharing: the worn flank moves the load, the load moves the wear.

use super::integrator::Integrator;
use super::{Exposure, WearError};
use crate::geometry::Relief;
use crate::load::closed_form::first_max_force;
use crate::load::{Meshing, ShareLoad};
use crate::machine::{Machine, PartWear};
use crate::tribology::LocalRate;
use crate::units::UM;

mod rates;
mod snapshot;

use rates::Removal;
pub use snapshot::WearSnapshot;

/// Numerical choices of the coupled prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoupledOptions {
    /// Points on one tooth's flank, both sides together.
    pub flank_points: usize,
    /// Points on the circumference of a pin.
    pub pin_points: usize,
    /// Crank positions per pin pitch at which rates are looked at together.
    pub crank_positions: usize,
    /// Error of one step over the sum of the depth reached and of the approach of the hardest loaded contact: what
    /// is small against the one does not change how far the machine has worn, against the other which pins carry.
    pub tolerance: f64,
}

impl Default for CoupledOptions {
    fn default() -> CoupledOptions {
        CoupledOptions { flank_points: 720, pin_points: 1440, crank_positions: 15, tolerance: TOLERANCE }
    }
}

/// By which depth and play stay within 0.2 % and 1 % of what a tenth of it gives (tested).
pub(crate) const TOLERANCE: f64 = 0.01;
/// Depth over pin radius at which flank or pin are gone.
pub(crate) const WORN_OUT: f64 = 0.25;
/// Times the limit of lost motion, of `LEAST_LIMIT` at least, that the flanks alone open in a machine past
/// any use: an assumption, so far beyond what anybody runs that no history of interest ends there.
const PAST_USE: f64 = 10.0;
/// rad; a tighter limit is a wish of the application and does not say what a machine can go on with.
const LEAST_LIMIT: f64 = crate::units::ARCMIN;
/// Depth over pin radius from which on a load sharing that is not found means that wear has run away, and not that
/// the balance is at fault.
const RUN_AWAY: f64 = 0.02;

/// Depth in m of flank or pin at which a machine is past any use: a quarter of the pin's radius is gone, or
/// the flanks have opened `PAST_USE` times the limit of lost motion. A depth h off both flanks lets the output
/// turn by 2 h/l, where l = e z_c is the largest lever arm of a pin.
pub(crate) fn depth_past_use(machine: &Machine) -> f64 {
    let lost_motion = PAST_USE * machine.limits.lost_motion.max(LEAST_LIMIT);
    let open = 0.5 * lost_motion * machine.profile().largest_lever_arm();
    open.min(WORN_OUT * machine.ring.pin_radius)
}

/// Approach in m of the hardest loaded contact of the new flank at the largest torque of the duty.
fn hardest_approach(machine: &Machine) -> f64 {
    let torque = machine.duty.iter().map(|duty| duty.torque.abs()).fold(0.0, f64::max);
    let profile = machine.profile();
    let at = profile.short_width_coefficient().min(1.0);
    let curvature = profile.relative_curvature(at, machine.ring.pin_radius).max(1.0);
    machine.line_contact().approach(first_max_force(machine, torque), 1.0 / curvature)
}

/// The running computation: advance it in exposure and read snapshots.
#[derive(Debug)]
pub struct CoupledWear<'a, S: ShareLoad = Meshing> {
    removal: Removal<'a, S>,
    integrator: Integrator,
    state: WearSnapshot,
    /// Depth in m at which the machine is past any use.
    past_use: f64,
    /// Exposure at which it was reached.
    end: Option<f64>,
}

impl<'a> CoupledWear<'a> {
    /// With ideal joints.
    pub fn new(machine: &'a Machine, options: CoupledOptions) -> CoupledWear<'a> {
        CoupledWear::with(machine, machine.meshing(&Relief::uniform(0.0)), options)
    }
}

impl<'a, S: ShareLoad> CoupledWear<'a, S> {
    /// With the joints of `meshing`, whose flanks and pins become those of the new machine.
    pub fn with(machine: &'a Machine, meshing: S, options: CoupledOptions) -> CoupledWear<'a, S> {
        let removal = Removal::new(machine, meshing, options);
        CoupledWear {
            state: removal.surfaces(0.0, &vec![0.0; removal.count()]),
            integrator: Integrator::new(removal.count()),
            removal,
            past_use: depth_past_use(machine),
            end: None,
        }
    }

    /// Goes on until flank or pin are gone, whatever play that leaves: for depths that were measured.
    pub(super) fn at_any_play(mut self) -> Self {
        self.past_use = WORN_OUT * self.removal.machine.ring.pin_radius;
        self
    }

    /// With the time that belongs to every exposure. Laws that depend on time need it, others take no notice.
    pub fn on_clock(mut self, clock: &Exposure) -> Self {
        self.removal.clock = Some(*clock);
        self
    }

    /// With a law of the caller's own in place of the machine's.
    pub fn with_law(mut self, law: Box<dyn LocalRate>) -> Self {
        self.removal.law = law;
        self
    }

    /// The joints, with the surfaces reached.
    pub fn meshing_mut(&mut self) -> &mut S {
        self.state.put_on(&self.removal.designed, &mut self.removal.meshing);
        &mut self.removal.meshing
    }

    /// Replaces what bearings and gears have lost, for joints that know of it, from the next step on.
    pub fn set_part_wear(&mut self, wear: &PartWear) {
        self.removal.meshing.set_part_wear(wear);
    }

    /// Surfaces reached.
    pub fn state(&self) -> &WearSnapshot {
        &self.state
    }

    /// Steps done so far.
    pub fn updates(&self) -> usize {
        self.integrator.steps()
    }

    /// Rates of all surfaces found so far: the measure of the effort.
    pub fn evaluations(&self) -> usize {
        self.removal.evaluations
    }

    /// Mean depth that the flanks lose per unit of exposure at these surfaces, in m per s/Pa.
    ///
    /// # Errors
    /// [`WearError`] when a load sharing fails.
    pub(crate) fn mean_rate(&mut self, state: &WearSnapshot) -> Result<f64, WearError> {
        let rates = self.removal.rates_on(state, 0)?;
        let count = self.removal.flank_places();
        Ok(rates[..count].iter().sum::<f64>() / count as f64)
    }

    /// Advances to the exposure `target` (s/Pa). Steps are as long as their error lets them be, wherever the target
    /// is; the state there is read between their ends. Where nothing wears (no torque, no speed), the surfaces stay
    /// as they are.
    ///
    /// # Errors
    /// [`WearError`] when a load sharing fails; [`WearError::RunsAway`] where flank or pin have lost
    /// `depth_past_use`, or more than `RUN_AWAY` of the pin's radius and no load sharing is found any more.
    /// The state is then the last one that held.
    pub fn advance_to(&mut self, target: f64) -> Result<(), WearError> {
        self.advance_until(target, |_| false)
    }

    /// Advances until `done` says so or the exposure `target` is reached; `done` sees the state after each
    /// step, the last of which may end beyond the target.
    ///
    /// # Errors
    /// As [`CoupledWear::advance_to`].
    pub fn advance_until(
        &mut self,
        target: f64,
        mut done: impl FnMut(&WearSnapshot) -> bool,
    ) -> Result<(), WearError> {
        while self.state.exposure < target {
            let reached = self.end.unwrap_or(self.integrator.exposure());
            if target <= reached {
                self.state = self.at(target);
                break;
            }
            if self.end.is_some() {
                self.state = self.at(reached);
                return Err(self.runs_away());
            }
            match self.integrator.advance(&mut self.removal) {
                Ok(true) => {}
                // An endless way to a depth that is never reached is another matter.
                Ok(false) if self.integrator.steps() == 0 && target == f64::MAX => {
                    return Err(WearError::NoWear);
                }
                // No speed, no torque, or a law with a threshold that no pressure exceeds any more.
                Ok(false) => {
                    self.integrator.rest_until(target);
                    continue;
                }
                Err(error) => {
                    self.state = self.at(reached);
                    let worn_out = self.depth(reached) > RUN_AWAY * self.removal.machine.ring.pin_radius;
                    let lost = matches!(error, WearError::Load(_)) && worn_out;
                    return Err(if lost { self.runs_away() } else { error });
                }
            }
            self.look_for_the_end();
            let state = self.at(self.end.unwrap_or(self.integrator.exposure()));
            if done(&state) {
                self.state = state;
                break;
            }
        }
        Ok(())
    }

    /// State at an exposure within the last step.
    fn at(&self, exposure: f64) -> WearSnapshot {
        self.removal.surfaces(exposure, &self.integrator.at(exposure))
    }

    fn depth(&self, exposure: f64) -> f64 {
        largest(&self.integrator.at(exposure))
    }

    fn runs_away(&self) -> WearError {
        let exposure = self.state.exposure;
        WearError::RunsAway { exposure, depth_um: self.depth(exposure) / UM }
    }

    /// Where the last step has gone past any use, if it has.
    fn look_for_the_end(&mut self) {
        if largest(self.integrator.depths()) <= self.past_use {
            return;
        }
        let (mut low, mut high) = (self.integrator.exposure_before(), self.integrator.exposure());
        // To rounding.
        for _ in 0..f64::MANTISSA_DIGITS {
            let middle = 0.5 * (low + high);
            if self.depth(middle) > self.past_use { high = middle } else { low = middle }
        }
        self.end = Some(high);
    }
}

fn largest(depths: &[f64]) -> f64 {
    depths.iter().copied().fold(0.0, f64::max)
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
