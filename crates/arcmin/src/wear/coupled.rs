//! Wear coupled to the load sharing: the worn flank moves the load, the load moves the wear.

use super::Exposure;
use super::deposit::{FlankArc, spread_on_pin};
use super::smoothing::ContactAverage;
use crate::contact::PinContact;
use crate::geometry::Relief;
use crate::load::closed_form::ClosedFormError;
use crate::load::{LoadError, Meshing, ShareLoad};
use crate::machine::{DutyPoint, Machine, PartWear, PinMounting};
use crate::tribology::film::{entrainment_speed, film_ratio};
use crate::tribology::{Local, LocalRate};
use crate::units::{UM, wrap_angle};

/// Why wear could not be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WearError {
    #[error("wear: {0}")]
    Load(#[from] LoadError),
    #[error("wear: {0}")]
    ClosedForm(#[from] ClosedFormError),
    #[error(
        "nothing wears: the duty has no torque, no speed, the wear coefficient is zero, or no pressure exceeds the threshold of the wear law"
    )]
    NoWear,
    #[error("the wear law depends on time, but it is not told which time belongs to an exposure")]
    NoClock,
    #[error(
        "a running-in cannot be fitted to a wear law that depends on time itself; leave one of the two out"
    )]
    RunningInOfTimeLaw,
    #[error(
        "the target is not reached: {reached_um:.2} µm after an exposure of {exposure:.3e} s/Pa; the flank wears too slowly there, give a shallower depth"
    )]
    TargetNotReached { reached_um: f64, exposure: f64 },
    #[error(
        "no wear coefficient was found that agrees with its own course in time: the last, {coefficient:.3e} 1/Pa, misses by {misfit_percent:.1} %"
    )]
    CoefficientNotFound { coefficient: f64, misfit_percent: f64 },
    #[error(
        "wear runs away: after an exposure of {exposure:.3e} s/Pa flank or pin have lost {depth_um:.0} µm, and nothing is left that the model could follow"
    )]
    RunsAway { exposure: f64, depth_um: f64 },
    #[error(
        "wear runs away: after {hours:.4} h flank or pin have lost {depth_um:.0} µm, and nothing is left that the model could follow"
    )]
    RunsAwayAt { hours: f64, depth_um: f64 },
    #[error("stopped")]
    Stopped,
}

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
    /// By how much Euler's and Heun's method may differ after an update, anywhere, in m. It is the error of the
    /// former; that of the latter, which is taken, is smaller.
    pub tolerance: f64,
}

impl Default for CoupledOptions {
    fn default() -> CoupledOptions {
        CoupledOptions {
            flank_points: 720,
            pin_points: 1440,
            crank_positions: 15,
            depth_increment: 0.2 * UM,
            tolerance: 0.01 * UM,
        }
    }
}

impl CoupledOptions {
    /// For a computation whose updates are the points of a curve that is read by straight lines: so close that
    /// the lines leave less than the updates.
    pub(super) fn for_curves(self) -> CoupledOptions {
        CoupledOptions { depth_increment: self.depth_increment.min(0.08 * UM), ..self }
    }
}

/// Worn surfaces at one exposure.
///
/// One flank serves all lobes of a disc, since every lobe meets every pin within a turn of the output. Where
/// all discs are alike it serves all of them, and one pin all pins; with manufacturing errors that tell them
/// apart there is a flank per disc, and per disc every pin.
#[derive(Debug, Clone, PartialEq)]
pub struct WearSnapshot {
    /// x = ∫ k dt in s/Pa.
    pub exposure: f64,
    /// Depth lost by the flank as a function of the meshing angle: of all discs, or per disc.
    pub flanks: Vec<Relief>,
    /// Depth lost by the pins as a function of the pin angle: of all pins, or pin by pin for the first disc,
    /// then the next.
    pub pins: Vec<Relief>,
    /// The same as the contact sees them: averaged over its width.
    flanks_seen: Vec<Relief>,
    pins_seen: Vec<Relief>,
}

impl WearSnapshot {
    fn unworn(options: &CoupledOptions, flanks: usize, pins: usize) -> WearSnapshot {
        let flanks = vec![Relief::from_samples(vec![0.0; options.flank_points]); flanks];
        let pins = vec![Relief::from_samples(vec![0.0; options.pin_points]); pins];
        WearSnapshot { exposure: 0.0, flanks_seen: flanks.clone(), pins_seen: pins.clone(), flanks, pins }
    }

    /// The same depth (m) off every flank, pins as new.
    pub fn uniform(depth: f64) -> WearSnapshot {
        let (flanks, pins) = (vec![Relief::uniform(depth)], vec![Relief::uniform(0.0)]);
        WearSnapshot { exposure: 0.0, flanks_seen: flanks.clone(), pins_seen: pins.clone(), flanks, pins }
    }

    /// The flank that has lost most.
    pub fn flank(&self) -> &Relief {
        deepest(&self.flanks)
    }

    /// The pin that has lost most.
    pub fn pin(&self) -> &Relief {
        deepest(&self.pins)
    }

    /// Depth of the (first) flank averaged over the width of the contact: what load sharing and dynamics use.
    pub fn flank_seen_by_contact(&self) -> &Relief {
        &self.flanks_seen[0]
    }

    /// Depths of the flanks averaged over the width of the contact: of all discs, or per disc.
    pub fn flanks_seen_by_contact(&self) -> &[Relief] {
        &self.flanks_seen
    }

    /// Depths of the pins averaged over the width of the contact: of all pins, or pin by pin for the first
    /// disc, then the next.
    pub fn pins_seen_by_contact(&self) -> &[Relief] {
        &self.pins_seen
    }

    /// Depth of the (first) pin averaged over the width of the contact.
    pub fn pin_seen_by_contact(&self) -> &Relief {
        &self.pins_seen[0]
    }

    /// What the contact sees of one pin of a ring of `count` as it meets a disc.
    fn pin_seen(&self, disc: usize, pin: usize, count: usize) -> &Relief {
        &self.pins_seen[if self.pins_seen.len() == 1 { 0 } else { disc * count + pin }]
    }

    /// Puts the worn surfaces, as the contact sees them, on top of the designed relief.
    pub fn put_on<S: ShareLoad>(&self, designed: &Relief, meshing: &mut S) {
        let flanks = self.flanks_seen.iter().map(|flank| designed.plus(flank)).collect();
        meshing.set_surfaces(flanks, self.pins_seen.clone());
    }

    /// Meshing of a machine with these worn surfaces.
    pub fn meshing(&self, machine: &Machine) -> Meshing {
        let mut meshing = machine.meshing(self.flank_seen_by_contact());
        meshing.set_pin_relief(self.pin_seen_by_contact().clone());
        meshing
    }
}

fn runs_away(exposure: f64, depth: f64) -> WearError {
    WearError::RunsAway { exposure, depth_um: depth / UM }
}

/// Depth over pin radius at which flank or pin are gone.
pub(crate) const WORN_OUT: f64 = 0.25;
/// Depth over pin radius from which on a load sharing that is not found means that wear has run away.
const RUN_AWAY: f64 = 0.02;
/// Largest increment of the depth per update, and its tolerance, as shares of the depth reached: they take over
/// from those of [`CoupledOptions`] beyond 25 and 20 µm.
const STEP_SHARE: f64 = 1e-2;
const TOLERANCE_SHARE: f64 = 5e-4;
/// Largest increment, in m, where it takes many pitches to repeat: an update then sees few of the places, and larger
/// ones leave waves on the flank (their least curvature and the need of more positions are tested).
const FEW_PLACES_INCREMENT: f64 = 0.08 * UM;
/// Sets of crank positions: a Fibonacci number, so that the golden section spreads them evenly. Thirteen of them are
/// too few for machines with errors of single pins.
const ROUNDS: usize = 987;
/// The first update takes off this much at most, in m, and no step that fails is made smaller.
const FIRST_INCREMENT: f64 = 0.08 * UM;
const LEAST_INCREMENT: f64 = 0.01 * UM;

/// Of several with the same depth the first.
fn deepest(reliefs: &[Relief]) -> &Relief {
    reliefs[1..].iter().fold(&reliefs[0], |deepest, other| {
        if other.deepest().0 > deepest.deepest().0 { other } else { deepest }
    })
}

/// The running computation: advance it in exposure and read snapshots.
#[derive(Debug)]
pub struct CoupledWear<'a, S: ShareLoad = Meshing> {
    machine: &'a Machine,
    options: CoupledOptions,
    law: Box<dyn LocalRate>,
    /// Which time belongs to an exposure; only laws that depend on time need it.
    clock: Option<Exposure>,
    arc: FlankArc,
    average: ContactAverage,
    meshing: S,
    designed: Relief,
    state: WearSnapshot,
    updates: usize,
    /// Exposure of the next update as the last one would have it.
    step: Option<f64>,
    /// Last solution per duty row and crank position: where the next one starts.
    starts: Vec<Option<S::Start>>,
}

/// Depth rates per unit of exposure.
struct Rates {
    flanks: Vec<Vec<f64>>,
    pins: Vec<Vec<f64>>,
}

impl Rates {
    fn largest(&self) -> f64 {
        self.flanks.iter().chain(&self.pins).flatten().copied().fold(0.0, f64::max)
    }

    /// Largest difference of two rates anywhere.
    fn largest_difference(&self, other: &Rates) -> f64 {
        let pairs = self.flanks.iter().chain(&self.pins).zip(other.flanks.iter().chain(&other.pins));
        pairs.flat_map(|(a, b)| a.iter().zip(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }
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
        let discs = if meshing.discs_alike() { 1 } else { machine.disc_count };
        // Pins that do not wear need no surface each.
        let pins = if meshing.discs_alike() || machine.wear.pin_ratio == 0.0 {
            1
        } else {
            discs * machine.ring.pin_count
        };
        let state = WearSnapshot::unworn(&options, discs, pins);
        let profile = machine.profile();
        let arc = FlankArc::new(&profile, options.flank_points);
        CoupledWear {
            average: ContactAverage::new(machine, &profile, &arc, options.pin_points),
            arc,
            meshing,
            designed: machine.designed_relief(),
            starts: vec![None; machine.duty.len() * options.crank_positions],
            law: machine.wear.law.local_rate(),
            clock: None,
            machine,
            options,
            state,
            updates: 0,
            step: None,
        }
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
        self.state.put_on(&self.designed, &mut self.meshing);
        &mut self.meshing
    }

    /// Replaces what bearings and gears have lost, for joints that know of it.
    pub fn set_part_wear(&mut self, wear: &PartWear) {
        self.meshing.set_part_wear(wear);
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
    /// Euler's lets it be. Where nothing wears (no torque, no speed), the surfaces stay as they are.
    ///
    /// # Errors
    /// [`WearError`] when a load sharing fails; [`WearError::RunsAway`] when flank or pin have lost a quarter
    /// of the pin's radius, or more than `RUN_AWAY` of it and no load sharing is found any more. The state is
    /// then the last one that held.
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
            let before = self.state.clone();
            let depth = before.flank().deepest().0.max(before.pin().deepest().0);
            if depth > WORN_OUT * self.machine.ring.pin_radius {
                return Err(runs_away(before.exposure, depth));
            }
            let lost = |error: WearError| match error {
                WearError::Load(_) if depth > RUN_AWAY * self.machine.ring.pin_radius => {
                    runs_away(before.exposure, depth)
                }
                error => error,
            };
            let first = self.rates(&before).map_err(&lost)?;
            let largest = first.largest();
            if !(largest > 0.0) {
                // An endless way to a depth that is never reached is another matter.
                if self.updates == 0 && target == f64::MAX {
                    return Err(WearError::NoWear);
                }
                // No speed, no torque, or a law with a threshold that no pressure exceeds any more.
                self.state.exposure = target;
                done(&self.state);
                break;
            }
            let left = target - before.exposure;
            let mut most = self.options.depth_increment;
            if self.meshing.pitches() > 1 {
                most = most.min(FEW_PLACES_INCREMENT);
            }
            let most = most.max(STEP_SHARE * depth) / largest;
            let wanted = self.step.unwrap_or(FIRST_INCREMENT / largest).min(most);
            // Equal last steps instead of one tiny one.
            let planned =
                if left > 2.0 * wanted { wanted } else { (left / (left / wanted).ceil()).min(left) };
            let mut step = planned;
            let tolerance = self.options.tolerance.max(TOLERANCE_SHARE * depth);
            let (second, error) = loop {
                let predicted = self.advanced(&before, &[(&first, step)]);
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
            self.state = self.advanced(&before, &[(&first, 0.5 * step), (&second, 0.5 * step)]);
            let next = step * (0.9 * (tolerance / error).sqrt()).clamp(0.3, 2.0);
            // A step cut short by the target says nothing against a longer one.
            self.step = Some(if step == planned && planned < wanted { next.max(wanted) } else { next });
            if left - step < 1e-12 * target {
                self.state.exposure = target;
            }
            self.updates += 1;
            if done(&self.state) {
                break;
            }
        }
        Ok(())
    }

    /// Mean removal over everything that repeats and the duty: dh/dx = Σ r K/z_c per pin and disc, where r is
    /// the law's rate integrated over the contact (F |v_s|/B by Archard's law) and K spreads it over the Hertz
    /// half-width.
    fn rates(&mut self, state: &WearSnapshot) -> Result<Rates, WearError> {
        let machine = self.machine;
        let time = match &self.clock {
            Some(clock) if self.law.depends_on_time() => clock.time_at(state.exposure),
            None if self.law.depends_on_time() => return Err(WearError::NoClock),
            _ => 0.0,
        };
        state.put_on(&self.designed, &mut self.meshing);
        let reaches: Vec<Vec<f64>> = state
            .pins
            .iter()
            .zip(&state.pins_seen)
            .map(|(pin, seen)| self.average.within_reach(pin, seen))
            .collect();
        let mut flanks = vec![vec![0.0; self.options.flank_points]; state.flanks.len()];
        let mut pins = vec![vec![0.0; self.options.pin_points]; state.pins.len()];
        let count = self.options.crank_positions;
        // The crank positions shift from update to update by the golden section, so that no place of the
        // flank is favoured.
        // After a while they come round again, so that each balance starts from one that it knows.
        let round = self.updates % ROUNDS;
        let offset = (round as f64 * 0.618_033_988_749_894_9).fract();
        // Each fraction of a pitch meets all places of the period within `count` updates.
        let shift = if self.meshing.pitches() > 1 { round % count } else { 0 };
        for (row, duty) in machine.duty.iter().enumerate() {
            if duty.torque == 0.0 || duty.share == 0.0 {
                continue;
            }
            let mut passes: Vec<Vec<Pass>> =
                vec![Vec::with_capacity(count * machine.ring.pin_count); machine.disc_count];
            for index in 0..count {
                let crank = self.meshing.crank_position(index, count, offset, shift);
                let start = &mut self.starts[row * count + (index + shift) % count];
                let (sharing, found) = self.meshing.share(crank, duty.torque, start.as_ref())?;
                *start = Some(found);
                for (disc, (contacts, passes)) in sharing.discs.iter().zip(&mut passes).enumerate() {
                    let flank = &state.flanks[disc % state.flanks.len()];
                    passes.extend(contacts.iter().map(|contact| {
                        let pin = state.pin_seen(disc, contact.pin, machine.ring.pin_count);
                        self.pass(contact, duty, flank, pin, time)
                    }));
                }
            }
            // One flank for all discs takes the mean of them.
            let weight = duty.share / (count * machine.disc_count / flanks.len()) as f64;
            for (disc, passes) in passes.iter_mut().enumerate() {
                // All pins at all positions in the order in which one tooth meets them.
                passes.sort_by(|a, b| a.meshing_angle.total_cmp(&b.meshing_angle));
                let flank = disc % flanks.len();
                self.deposit_on_flank(passes, weight, &mut flanks[flank]);
                if machine.wear.pin_ratio > 0.0 {
                    let own = machine.ring.pin_count;
                    match pins.chunks_exact_mut(own).nth(disc) {
                        Some(pins) => {
                            let own = disc * own..(disc + 1) * own;
                            let seen = (&state.pins_seen[own.clone()], &reaches[own]);
                            self.deposit_on_each_pin(passes, duty.share, pins, seen);
                        }
                        None => self.deposit_on_pins(passes, weight, &mut pins[0], &reaches[0]),
                    }
                }
            }
        }
        for section in flanks.iter_mut().flat_map(|flank| flank.iter_mut().enumerate()) {
            *section.1 /= self.arc.cell_width(section.0);
        }
        let pin_cell = std::f64::consts::TAU * machine.ring.pin_radius / self.options.pin_points as f64;
        for pin in &mut pins {
            match machine.ring.mounting {
                PinMounting::Fixed => pin.iter_mut().for_each(|section| *section /= pin_cell),
                PinMounting::Spinning => {
                    let mean = pin.iter().sum::<f64>() / (pin.len() as f64 * pin_cell);
                    pin.fill(mean);
                }
            }
        }
        Ok(Rates { flanks, pins })
    }

    /// What one contact removes per unit of time from a flank that has lost the depths `flank`, on a pin of
    /// which it sees `pin`. Pins wear in proportion to the flank that they meet.
    fn pass(&self, c: &PinContact, duty: &DutyPoint, flank: &Relief, pin: &Relief, time: f64) -> Pass {
        let machine = self.machine;
        let profile = self.meshing.contacts().profile();
        let contact = self.meshing.contacts().contact();
        let lobes = profile.lobe_count() as f64;
        let (output_speed, _, _) = self.meshing.kinematics().speeds(duty.input_speed);
        let cos = c.meshing_angle.cos();
        let rs = profile.pin_circle_radius * profile.speed_factor(cos);
        let sliding = (rs - machine.ring.pin_radius).abs() * output_speed.abs();
        let radius = 1.0 / c.relative_curvature;
        let half_width = contact.half_width(c.force, radius);
        let removal = if c.force > 0.0 {
            let line_load = c.force / machine.disc.width;
            let film_ratio = machine.wear.lubrication.as_ref().map_or(0.0, |oil| {
                let on_flank = profile.flank_length_per_meshing_angle(cos) * lobes * output_speed.abs();
                let entrainment = entrainment_speed(on_flank, sliding);
                film_ratio(oil, contact.effective_modulus, radius, line_load, entrainment)
            });
            let depth = flank.at(c.meshing_angle).depth;
            let at = Local { pressure: 0.0, sliding, equivalent_radius: radius, film_ratio, depth, time };
            self.law.section_rate(line_load, half_width, &at)
        } else {
            0.0
        };
        Pass {
            pin: c.pin,
            meshing_angle: c.meshing_angle,
            pin_angle: self.average.touching(pin, self.meshing.contacts().pin_angle(c)),
            half_width,
            removal,
        }
    }

    /// Spreads the removal along the path of the contact over the flank, mean of the lobes.
    fn deposit_on_flank(&self, passes: &[Pass], weight: f64, flank: &mut [f64]) {
        let lobes = self.machine.ring.pin_count as f64 - 1.0;
        for (before, pass, after) in neighbours(passes) {
            let ends = (
                halfway(before.meshing_angle, pass.meshing_angle),
                halfway(after.meshing_angle, pass.meshing_angle),
            );
            self.arc.spread(flank, ends.0, ends.1, pass.half_width, weight * pass.removal / lobes);
        }
    }

    /// The same over the pins, mean of them.
    fn deposit_on_pins(&self, passes: &[Pass], weight: f64, pin: &mut [f64], reach: &[f64]) {
        let machine = self.machine;
        let count = machine.ring.pin_count as f64;
        for (before, pass, after) in neighbours(passes) {
            let ends = (halfway(before.pin_angle, pass.pin_angle), halfway(after.pin_angle, pass.pin_angle));
            let amount = machine.wear.pin_ratio * (weight * pass.removal) / count;
            spread_on_pin(pin, reach, machine.ring.pin_radius, ends.0, ends.1, pass.half_width, amount);
        }
    }

    /// The same over every pin by itself. One pin is met at few meshing angles, so its removal is read
    /// between them by straight lines, and the contact goes on the way that it takes on a nominal pin.
    /// `seen` is what the contact sees of each pin, and what it reaches.
    fn deposit_on_each_pin(
        &self,
        passes: &[Pass],
        weight: f64,
        pins: &mut [Vec<f64>],
        seen: (&[Relief], &[Vec<f64>]),
    ) {
        let machine = self.machine;
        let profile = self.meshing.contacts().profile();
        let mut own: Vec<Vec<&Pass>> = vec![Vec::new(); pins.len()];
        passes.iter().for_each(|pass| own[pass.pin].push(pass));
        for ((pin, own), (seen, reach)) in pins.iter_mut().zip(&own).zip(seen.0.iter().zip(seen.1)) {
            for (index, pass) in own.iter().enumerate() {
                let next = own[(index + 1) % own.len()];
                if pass.removal <= 0.0 && next.removal <= 0.0 {
                    continue;
                }
                // A whole turn to itself where it is the only one.
                let way = (next.meshing_angle - pass.meshing_angle).rem_euclid(std::f64::consts::TAU);
                let way = if own.len() == 1 { std::f64::consts::TAU } else { way };
                let pieces = (way / PIN_PIECE).ceil().max(1.0);
                for piece in 0..pieces as usize {
                    let at = |share: f64| pass.meshing_angle + way * (piece as f64 + share) / pieces;
                    let between = (piece as f64 + 0.5) / pieces;
                    let blend = |a: f64, b: f64| a + (b - a) * between;
                    let removal = blend(pass.removal, next.removal);
                    // An unloaded contact has no width; that of its neighbour fades.
                    let half_width = blend(pass.half_width, next.half_width).max(1e-9);
                    let amount =
                        machine.wear.pin_ratio * weight * removal * way / pieces / std::f64::consts::TAU;
                    let touching = |share| self.average.touching(seen, profile.pin_angle(at(share)));
                    let (from, to) = (touching(0.0), touching(1.0));
                    spread_on_pin(pin, reach, machine.ring.pin_radius, from, to, half_width, amount);
                }
            }
        }
    }

    /// State after adding rates times exposure.
    fn advanced(&self, state: &WearSnapshot, parts: &[(&Rates, f64)]) -> WearSnapshot {
        let add = |reliefs: &[Relief], rates: fn(&Rates) -> &Vec<Vec<f64>>| -> Vec<Relief> {
            let one = |(index, relief): (usize, &Relief)| {
                let mut depths = relief.samples().to_vec();
                for (part, step) in parts {
                    for (depth, rate) in depths.iter_mut().zip(&rates(part)[index]) {
                        *depth += rate * step;
                    }
                }
                Relief::from_samples(depths)
            };
            reliefs.iter().enumerate().map(one).collect()
        };
        let (flanks, pins) =
            (add(&state.flanks, |rates| &rates.flanks), add(&state.pins, |rates| &rates.pins));
        WearSnapshot {
            exposure: state.exposure + parts.iter().map(|(_, step)| step).sum::<f64>(),
            flanks_seen: flanks.iter().map(|flank| self.average.flank(flank)).collect(),
            pins_seen: pins.iter().map(|pin| self.average.pin(pin)).collect(),
            flanks,
            pins,
        }
    }
}

/// Loaded passes with those before and after them, all around.
fn neighbours(passes: &[Pass]) -> impl Iterator<Item = (&Pass, &Pass, &Pass)> {
    let count = passes.len();
    let all = passes.iter().enumerate().filter(|(_, pass)| pass.removal > 0.0);
    all.map(move |(index, pass)| (&passes[(index + count - 1) % count], pass, &passes[(index + 1) % count]))
}

fn halfway(other: f64, here: f64) -> f64 {
    here + 0.5 * wrap_angle(other - here)
}

/// Longest piece of meshing angle (rad) on which the removal on a pin is taken as one: an assumption, a third of
/// the 9° between the pins of a usual ring, so that the straight lines between its contacts are followed.
const PIN_PIECE: f64 = 3.0 * std::f64::consts::PI / 180.0;

/// One contact on its way along the flank.
#[derive(Debug, Clone, Copy)]
struct Pass {
    pin: usize,
    meshing_angle: f64,
    pin_angle: f64,
    half_width: f64,
    /// Rate integrated over the width, m²/s per 1/Pa; F/B |v_s| by Archard's law.
    removal: f64,
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
