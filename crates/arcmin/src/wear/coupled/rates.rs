//! How fast flanks and pins lose depth: the removal of every contact, spread over what it passes.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::{CoupledOptions, WearError, WearSnapshot};
use crate::contact::PinContact;
use crate::geometry::Relief;
use crate::load::ShareLoad;
use crate::machine::{CrankAngle, DutyPoint, Machine, OutputForces, PinMounting};
use crate::tribology::film::{entrainment_speed, film_ratio};
use crate::tribology::{Local, LocalRate};
use crate::units::wrap_angle;
use crate::wear::Exposure;
use crate::wear::deposit::{FlankArc, spread_on_pin};
use crate::wear::integrator::Wearing;
use crate::wear::smoothing::ContactAverage;

/// What contacts take off flanks and pins.
#[derive(Debug)]
pub(super) struct Removal<'a, S: ShareLoad> {
    pub machine: &'a Machine,
    options: CoupledOptions,
    pub law: Box<dyn LocalRate>,
    /// Which time belongs to an exposure; only laws that depend on time need it.
    pub clock: Option<Exposure>,
    arc: FlankArc,
    average: ContactAverage,
    pub meshing: S,
    pub designed: Relief,
    flanks: usize,
    pins: usize,
    /// Approach in m of the hardest loaded contact of the new machine, by the closed form.
    approach: f64,
    /// Last solution per duty row and crank position: where the next one starts.
    starts: Vec<Option<S::Start>>,
    pub evaluations: usize,
}

impl<S: ShareLoad> Wearing for Removal<'_, S> {
    fn rates(&mut self, exposure: f64, depths: &[f64], sample: usize) -> Result<Vec<f64>, WearError> {
        let state = self.surfaces(exposure, depths);
        self.rates_on(&state, sample)
    }

    /// The root mean square over the metal that comes off the surface that changes most, averaged over the width of
    /// the contact as load sharing sees it. The largest anywhere would be that of a few contacts, which other
    /// selections of positions take off elsewhere.
    fn size(&self, changes: &[f64], rates: &[f64]) -> f64 {
        let mean_square = |(seen, rates): (Vec<f64>, &[f64])| {
            let squares: f64 = seen.iter().zip(rates).map(|(change, rate)| rate * change * change).sum();
            if squares > 0.0 { squares / rates.iter().sum::<f64>() } else { 0.0 }
        };
        let (flanks, pins) = changes.split_at(self.flank_places());
        let flanks = flanks.chunks(self.options.flank_points).map(|flank| self.average.on_flank(flank));
        let pins = pins.chunks(self.options.pin_points).map(|pin| self.average.on_pin(pin));
        let (of_flanks, of_pins) = rates.split_at(self.flank_places());
        let rates =
            of_flanks.chunks(self.options.flank_points).chain(of_pins.chunks(self.options.pin_points));
        flanks.chain(pins).zip(rates).map(mean_square).fold(0.0, f64::max).sqrt()
    }

    fn tolerance(&self, depths: &[f64]) -> f64 {
        self.options.tolerance * (self.approach + super::largest(depths))
    }
}

impl<'a, S: ShareLoad> Removal<'a, S> {
    pub fn new(machine: &'a Machine, meshing: S, options: CoupledOptions) -> Removal<'a, S> {
        let flanks = if meshing.discs_alike() { 1 } else { machine.disc_count };
        // Pins that do not wear need no surface each.
        let alike = meshing.discs_alike() || machine.wear.pin_ratio == 0.0;
        let pins = if alike { 1 } else { flanks * machine.ring.pin_count };
        let profile = machine.profile();
        let arc = FlankArc::new(&profile, options.flank_points);
        Removal {
            average: ContactAverage::new(machine, &profile, &arc, options.pin_points),
            arc,
            meshing,
            designed: machine.designed_relief(),
            starts: vec![None; machine.duty.len() * options.crank_positions],
            law: machine.wear.law.local_rate(),
            clock: None,
            machine,
            options,
            flanks,
            pins,
            approach: super::hardest_approach(machine),
            evaluations: 0,
        }
    }

    /// Places of all flanks, and then of all pins, whose depths are followed.
    pub fn count(&self) -> usize {
        self.flank_places() + self.pins * self.options.pin_points
    }

    pub fn flank_places(&self) -> usize {
        self.flanks * self.options.flank_points
    }

    /// Surfaces with these depths.
    pub fn surfaces(&self, exposure: f64, depths: &[f64]) -> WearSnapshot {
        let (flanks, pins) = depths.split_at(self.flank_places());
        let reliefs = |depths: &[f64], points: usize| -> Vec<Relief> {
            depths.chunks(points).map(|depths| Relief::from_samples(depths.to_vec())).collect()
        };
        let flanks = reliefs(flanks, self.options.flank_points);
        let pins = reliefs(pins, self.options.pin_points);
        let flanks_seen = flanks.iter().map(|flank| self.average.flank(flank)).collect();
        let pins_seen = pins.iter().map(|pin| self.average.pin(pin)).collect();
        WearSnapshot { exposure, flanks, pins, flanks_seen, pins_seen }
    }

    /// Mean removal over everything that repeats and the duty: dh/dx = Σ r K/z_c per pin and disc, where r is
    /// the law's rate integrated over the contact (F |v_s|/B by Archard's law) and K spreads it over the Hertz
    /// half-width. `sample` numbers the selection of positions.
    pub fn rates_on(&mut self, state: &WearSnapshot, sample: usize) -> Result<Vec<f64>, WearError> {
        self.evaluations += 1;
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
        // The crank positions shift from sample to sample by the golden section, so that no place of the
        // flank is favoured.
        let offset = (sample as f64 * 0.618_033_988_749_894_9).fract();
        // Each fraction of a pitch meets all places of the period within `count` sets of positions. Neighbouring
        // fractions meet every other place, so that forces that change with the place leave waves half as long, which
        // contacts average over. Where errors tell pins apart, it counts as much which pins a place meets, and that
        // gains nothing.
        let stride = if self.meshing.discs_alike() && count % 2 == 1 { 2 } else { 1 };
        let (sets, several) = (sample % count, self.meshing.pitches() > 1);
        let place = |index: usize| if several { stride * (index + sets) % count } else { index };
        let tasks: Vec<Task> = (machine.duty.iter().enumerate())
            .filter(|(_, duty)| duty.wears())
            .flat_map(|(row, duty)| (0..count).map(move |index| (row, duty, index)))
            .map(|(row, &DutyPoint { torque, forces, .. }, index)| {
                let shift = (place(index) + count - index) % count;
                let crank = self.meshing.crank_position(index, count, offset, shift);
                Task { crank, torque, forces, slot: row * count + place(index) }
            })
            .collect();
        let mut found = self.pin_contacts(&tasks)?.into_iter();
        for duty in machine.duty.iter().filter(|duty| duty.wears()) {
            let mut passes: Vec<Vec<Pass>> =
                vec![Vec::with_capacity(count * machine.ring.pin_count); machine.disc_count];
            for discs in found.by_ref().take(count) {
                for (disc, (contacts, passes)) in discs.iter().zip(&mut passes).enumerate() {
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
        Ok(flanks.into_iter().chain(pins).flatten().collect())
    }

    /// The pins of every disc at all `tasks`, each started from the last solution at its place. Threads take them as
    /// they come, each with a meshing of its own; no result depends on which.
    fn pin_contacts(&mut self, tasks: &[Task]) -> Result<Vec<Vec<Vec<PinContact>>>, WearError> {
        let (starts, tilts) = (&self.starts, self.machine.duty_tilts());
        let solve = |meshing: &mut S, task: &Task| {
            if tilts {
                meshing.set_output_forces(task.forces);
            }
            meshing.pin_contacts(task.crank, task.torque, starts[task.slot].as_ref())
        };
        // One thread needs no copy.
        let found: Vec<_> = if rayon::current_num_threads() == 1 {
            tasks.iter().map(|task| solve(&mut self.meshing, task)).collect()
        } else {
            let (meshing, idle) = (&self.meshing, Mutex::new(Vec::new()));
            let idle = || idle.lock().unwrap_or_else(PoisonError::into_inner);
            let ask = |task: &Task| {
                let taken = idle().pop();
                let mut own = taken.unwrap_or_else(|| meshing.twin());
                let found = solve(&mut own, task);
                idle().push(own);
                found
            };
            tasks.par_iter().with_max_len(1).map(ask).collect()
        };
        if tilts {
            self.meshing.set_output_forces(OutputForces::default());
        }
        let mut contacts = Vec::with_capacity(tasks.len());
        for (task, found) in tasks.iter().zip(found) {
            let (discs, start) = found?;
            self.starts[task.slot] = Some(start);
            contacts.push(discs);
        }
        Ok(contacts)
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

/// A load sharing to be found.
struct Task {
    crank: CrankAngle,
    torque: f64,
    /// What tilts and pulls the output meanwhile.
    forces: OutputForces,
    /// Where its last solution is kept.
    slot: usize,
}

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
