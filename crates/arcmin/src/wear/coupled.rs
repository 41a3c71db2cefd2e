//! Wear coupled to the load sharing: the worn flank moves the load, the load moves the wear.

use super::Exposure;
use super::deposit::{FlankArc, spread_on_pin};
use super::film::{boundary_share, film_ratio};
use super::smoothing::ContactAverage;
use crate::contact::PinContact;
use crate::geometry::Relief;
use crate::load::closed_form::ClosedFormError;
use crate::load::{LoadError, Meshing, ShareLoad};
use crate::machine::{DutyPoint, Machine, PartWear, PinMounting};
use crate::units::{UM, wrap_angle};

/// Why wear could not be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WearError {
    #[error("wear: {0}")]
    Load(#[from] LoadError),
    #[error("wear: {0}")]
    ClosedForm(#[from] ClosedFormError),
    #[error("nothing wears: the duty has no torque, no speed, or the wear coefficient is zero")]
    NoWear,
    #[error(
        "the target is not reached: {reached_um:.2} µm after an exposure of {exposure:.3e} s/Pa; the flank wears too slowly there, give a shallower depth"
    )]
    TargetNotReached { reached_um: f64, exposure: f64 },
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
    /// Largest increment of the depth per update in m.
    pub depth_increment: f64,
}

impl Default for CoupledOptions {
    fn default() -> CoupledOptions {
        CoupledOptions { flank_points: 720, pin_points: 1440, crank_positions: 15, depth_increment: 0.08 * UM }
    }
}

/// Worn surfaces at one exposure.
#[derive(Debug, Clone, PartialEq)]
pub struct WearSnapshot {
    /// x = ∫ k dt in s/Pa.
    pub exposure: f64,
    /// Depth lost by the flank as a function of the meshing angle.
    pub flank: Relief,
    /// Depth lost by the pins as a function of the pin angle.
    pub pin: Relief,
    /// The same as the contact sees them: averaged over its width.
    flank_seen: Relief,
    pin_seen: Relief,
}

impl WearSnapshot {
    fn unworn(options: &CoupledOptions) -> WearSnapshot {
        let flank = Relief::from_samples(vec![0.0; options.flank_points]);
        let pin = Relief::from_samples(vec![0.0; options.pin_points]);
        WearSnapshot { exposure: 0.0, flank_seen: flank.clone(), pin_seen: pin.clone(), flank, pin }
    }

    /// Depth of the flank averaged over the width of the contact: what load sharing and dynamics use.
    pub fn flank_seen_by_contact(&self) -> &Relief {
        &self.flank_seen
    }

    /// Depth of the pins averaged over the width of the contact.
    pub fn pin_seen_by_contact(&self) -> &Relief {
        &self.pin_seen
    }

    /// Meshing of a machine with these worn surfaces.
    pub fn meshing(&self, machine: &Machine) -> Meshing {
        let mut meshing = machine.meshing(&self.flank_seen);
        meshing.set_pin_relief(self.pin_seen.clone());
        meshing
    }
}

/// The running computation: advance it in exposure and read snapshots.
#[derive(Debug)]
pub struct CoupledWear<'a, S: ShareLoad = Meshing> {
    machine: &'a Machine,
    options: CoupledOptions,
    arc: FlankArc,
    average: ContactAverage,
    meshing: S,
    designed: Relief,
    state: WearSnapshot,
    updates: usize,
    /// Last solution per duty row and crank position: where the next one starts.
    starts: Vec<Option<S::Start>>,
}

/// Depth rates per unit of exposure.
struct Rates {
    flank: Vec<f64>,
    pin: Vec<f64>,
}

impl Rates {
    fn largest(&self) -> f64 {
        self.flank.iter().chain(&self.pin).copied().fold(0.0, f64::max)
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
        let state = WearSnapshot::unworn(&options);
        let profile = machine.profile();
        let arc = FlankArc::new(&profile, options.flank_points);
        CoupledWear {
            average: ContactAverage::new(machine, &profile, &arc, options.pin_points),
            arc,
            meshing,
            designed: machine.designed_relief(),
            starts: vec![None; machine.duty.len() * options.crank_positions],
            machine,
            options,
            state,
            updates: 0,
        }
    }

    /// The joints, with the surfaces reached.
    pub fn meshing_mut(&mut self) -> &mut S {
        self.meshing.set_relief(self.designed.plus(&self.state.flank_seen));
        self.meshing.set_pin_relief(self.state.pin_seen.clone());
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

    /// Advances to the exposure `target` (s/Pa) by Heun's method, the steps bounded by the depth increment.
    ///
    /// # Errors
    /// [`WearError`] when a load sharing fails or nothing wears.
    pub fn advance_to(&mut self, target: f64) -> Result<(), WearError> {
        self.advance_until(target, |_| false)
    }

    /// Advances until `done` says so or the exposure `target` is reached; `done` sees the state after each update.
    ///
    /// # Errors
    /// As [`CoupledWear::advance_to`].
    pub fn advance_until(&mut self, target: f64, mut done: impl FnMut(&WearSnapshot) -> bool) -> Result<(), WearError> {
        while self.state.exposure < target {
            let before = self.state.clone();
            let first = self.rates(&before)?;
            let largest = first.largest();
            if !(largest > 0.0) {
                return Err(WearError::NoWear);
            }
            let left = target - before.exposure;
            let most = self.options.depth_increment / largest;
            // Equal last steps instead of one tiny one.
            let step = if left > 2.0 * most { most } else { (left / (left / most).ceil()).min(left) };
            let predicted = self.advanced(&before, &[(&first, step)]);
            let second = self.rates(&predicted)?;
            self.state = self.advanced(&before, &[(&first, 0.5 * step), (&second, 0.5 * step)]);
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

    /// Mean removal over one pattern of crank positions and the duty: dh/dx = Σ F |v_s| K/(B z_c) per pin and disc, where K spreads each contact over its
    /// Hertz half-width.
    fn rates(&mut self, state: &WearSnapshot) -> Result<Rates, WearError> {
        let machine = self.machine;
        self.meshing.set_relief(self.designed.plus(&state.flank_seen));
        self.meshing.set_pin_relief(state.pin_seen.clone());
        let mut flank = vec![0.0; self.options.flank_points];
        let mut pin = vec![0.0; self.options.pin_points];
        let count = self.options.crank_positions;
        // The crank positions shift from update to update by the golden section, so that no place of the flank is favoured.
        let offset = (self.updates as f64 * 0.618_033_988_749_894_9).fract();
        // Each fraction of a pitch meets all places of the period within `count` updates.
        let shift = if self.meshing.pitches() > 1 { self.updates % count } else { 0 };
        for (row, duty) in machine.duty.iter().enumerate() {
            if duty.torque == 0.0 || duty.share == 0.0 {
                continue;
            }
            let mut passes: Vec<Vec<Pass>> = vec![Vec::with_capacity(count * machine.ring.pin_count); machine.disc_count];
            for index in 0..count {
                let crank = self.meshing.crank_position(index, count, offset, shift);
                let start = &mut self.starts[row * count + (index + shift) % count];
                let (sharing, found) = self.meshing.share(crank, duty.torque, start.as_ref())?;
                *start = Some(found);
                for (contacts, passes) in sharing.discs.iter().zip(&mut passes) {
                    passes.extend(contacts.iter().map(|contact| self.pass(contact, duty)));
                }
            }
            let weight = duty.share / (count * machine.disc_count) as f64;
            for passes in &mut passes {
                // All pins at all positions in the order in which one tooth meets them.
                passes.sort_by(|a, b| a.meshing_angle.total_cmp(&b.meshing_angle));
                self.deposit(passes, weight, &mut flank, &mut pin);
            }
        }
        for (cell, section) in flank.iter_mut().enumerate() {
            *section /= self.arc.cell_width(cell);
        }
        let pin_cell = std::f64::consts::TAU * machine.ring.pin_radius / pin.len() as f64;
        match machine.ring.mounting {
            PinMounting::Fixed => pin.iter_mut().for_each(|section| *section /= pin_cell),
            PinMounting::Spinning => {
                let mean = pin.iter().sum::<f64>() / (pin.len() as f64 * pin_cell);
                pin.fill(mean);
            }
        }
        Ok(Rates { flank, pin })
    }

    /// What one contact removes per unit of time.
    fn pass(&self, c: &PinContact, duty: &DutyPoint) -> Pass {
        let machine = self.machine;
        let profile = self.meshing.contacts().profile();
        let contact = self.meshing.contacts().contact();
        let lobes = profile.lobe_count() as f64;
        let (output_speed, _, _) = self.meshing.kinematics().speeds(duty.input_speed);
        let cos = c.meshing_angle.cos();
        let rs = profile.pin_circle_radius * profile.speed_factor(cos);
        let sliding = (rs - machine.ring.pin_radius).abs() * output_speed.abs();
        let radius = 1.0 / c.relative_curvature;
        let line_load = c.force / machine.disc.width;
        let mut removal = line_load * sliding;
        if let Some(oil) = machine.wear.lubrication.as_ref().filter(|_| c.force > 0.0) {
            // Speeds of the surfaces relative to the contact: v_c of the flank, v_c − v_s of the pin. The film never stops building up
            // entirely (the contact has a width), hence the lower bound.
            let on_flank = profile.flank_length_per_meshing_angle(cos) * lobes * output_speed.abs();
            let entrainment = 0.5 * (2.0 * on_flank - sliding).abs().max(1e-3 * sliding);
            removal *= boundary_share(film_ratio(oil, contact.effective_modulus, radius, line_load, entrainment));
        }
        Pass {
            meshing_angle: c.meshing_angle,
            pin_angle: self.meshing.contacts().pin_angle(c),
            half_width: contact.half_width(c.force, radius),
            removal,
        }
    }

    /// Spreads the removal along the path of the contact over flank (mean of the lobes) and pin (mean of the pins).
    fn deposit(&self, passes: &[Pass], weight: f64, flank: &mut [f64], pin: &mut [f64]) {
        let machine = self.machine;
        let count = passes.len();
        let (lobes, pins) = (machine.ring.pin_count as f64 - 1.0, machine.ring.pin_count as f64);
        for (index, pass) in passes.iter().enumerate().filter(|(_, pass)| pass.removal > 0.0) {
            let (before, after) = (&passes[(index + count - 1) % count], &passes[(index + 1) % count]);
            let halfway = |other: f64, here: f64| here + 0.5 * wrap_angle(other - here);
            let removal = weight * pass.removal;
            let ends = (halfway(before.meshing_angle, pass.meshing_angle), halfway(after.meshing_angle, pass.meshing_angle));
            self.arc.spread(flank, ends.0, ends.1, pass.half_width, removal / lobes);
            if machine.wear.pin_ratio > 0.0 {
                let ends = (halfway(before.pin_angle, pass.pin_angle), halfway(after.pin_angle, pass.pin_angle));
                spread_on_pin(pin, machine.ring.pin_radius, ends.0, ends.1, pass.half_width, machine.wear.pin_ratio * removal / pins);
            }
        }
    }

    /// State after adding rates times exposure.
    fn advanced(&self, state: &WearSnapshot, parts: &[(&Rates, f64)]) -> WearSnapshot {
        let add = |relief: &Relief, rates: fn(&Rates) -> &Vec<f64>| {
            let mut depths = relief.samples().to_vec();
            for (part, step) in parts {
                for (depth, rate) in depths.iter_mut().zip(rates(part)) {
                    *depth += rate * step;
                }
            }
            Relief::from_samples(depths)
        };
        let (flank, pin) = (add(&state.flank, |rates| &rates.flank), add(&state.pin, |rates| &rates.pin));
        WearSnapshot {
            exposure: state.exposure + parts.iter().map(|(_, step)| step).sum::<f64>(),
            flank_seen: self.average.flank(&flank),
            pin_seen: self.average.pin(&pin),
            flank,
            pin,
        }
    }
}

/// One contact on its way along the flank.
#[derive(Debug, Clone, Copy)]
struct Pass {
    meshing_angle: f64,
    pin_angle: f64,
    half_width: f64,
    /// F/B |v_s| in W/m, times the boundary share of the film.
    removal: f64,
}

impl Machine {
    /// Exposure curve of this machine from its coupled coefficient, calibrated on the coupled prediction where asked for. Ideal joints.
    ///
    /// # Errors
    /// [`WearError`] when the prediction fails or the target is out of reach.
    pub fn coupled_exposure(&self, options: CoupledOptions) -> Result<Exposure, WearError> {
        super::calibrate::coupled_exposure(self, self.meshing(&Relief::uniform(0.0)), options)
    }
}
