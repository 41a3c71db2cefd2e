//! Rates of the depths of flanks and pins: removal of every contact, distributed along its path.

use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::{CoupledWear, WearError, WearSnapshot};
use crate::contact::PinContact;
use crate::geometry::Relief;
use crate::load::ShareLoad;
use crate::machine::{CrankAngle, DutyPoint, OutputForces, PinMounting};
use crate::tribology::Local;
use crate::tribology::film::{entrainment_speed, film_ratio};
use crate::units::wrap_angle;
use crate::wear::deposit::spread_on_pin;

/// Depth rates per unit of exposure.
#[derive(Debug)]
pub(super) struct Rates {
    flanks: Vec<Vec<f64>>,
    pins: Vec<Vec<f64>>,
}

impl Rates {
    pub(super) fn largest(&self) -> f64 {
        self.flanks.iter().chain(&self.pins).flatten().copied().fold(0.0, f64::max)
    }

    /// Linear combination of rates on the same surfaces.
    pub(super) fn sum(parts: &[(&Rates, f64)]) -> Rates {
        let of = |surfaces: fn(&Rates) -> &Vec<Vec<f64>>| {
            let one = |surface: usize| {
                let mut sum = vec![0.0; surfaces(parts[0].0)[surface].len()];
                for (rates, factor) in parts {
                    sum.iter_mut()
                        .zip(&surfaces(rates)[surface])
                        .for_each(|(sum, rate)| *sum += factor * rate);
                }
                sum
            };
            (0..surfaces(parts[0].0).len()).map(one).collect()
        };
        Rates { flanks: of(|rates| &rates.flanks), pins: of(|rates| &rates.pins) }
    }

    /// Largest absolute difference of two rates.
    pub(super) fn largest_difference(&self, other: &Rates) -> f64 {
        let pairs = self.flanks.iter().chain(&self.pins).zip(other.flanks.iter().chain(&other.pins));
        pairs.flat_map(|(a, b)| a.iter().zip(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }
}

impl<S: ShareLoad> CoupledWear<S> {
    /// Mean rate of depth of the flanks per unit of exposure for these surfaces, in m per s/Pa.
    ///
    /// # Errors
    /// [`WearError`] when a load sharing fails.
    pub fn mean_rate(&mut self, state: &WearSnapshot) -> Result<f64, WearError> {
        let rates = self.rates(state)?;
        let count: usize = rates.flanks.iter().map(Vec::len).sum();
        Ok(rates.flanks.iter().flatten().sum::<f64>() / count.max(1) as f64)
    }

    /// Mean removal over one full period and the duty: dh/dx = Σ r K/z_c over pins and discs, where r is the
    /// law's rate integrated over the contact (F |v_s|/B by Archard's law) and the kernel K distributes it over
    /// the Hertz half-width.
    pub(super) fn rates(&mut self, state: &WearSnapshot) -> Result<Rates, WearError> {
        let case = Arc::clone(&self.case);
        let time = match &self.clock {
            Some(clock) if self.law.depends_on_time() => clock.time_at(state.exposure),
            None if self.law.depends_on_time() => return Err(WearError::NoClock),
            _ => 0.0,
        };
        state.apply_to(&self.case.designed, &mut self.meshing);
        let reaches: Vec<Vec<f64>> = state
            .pins
            .iter()
            .zip(&state.effective_pins)
            .map(|(pin, seen)| self.average.within_reach(pin, seen))
            .collect();
        let mut flanks = vec![vec![0.0; self.options.flank_points]; state.flanks.len()];
        let mut pins = vec![vec![0.0; self.options.pin_points]; state.pins.len()];
        let count = self.options.crank_positions;
        // The crank positions are shifted from update to update by the golden section, so that all points of
        // the flank have equal weight.
        let offset = (self.places as f64 * 0.618_033_988_749_894_9).fract();
        // Each fraction of a pitch is combined with all positions of the period within `count` sets of
        // positions. Successive fractions use every second position, so that forces that depend on the position
        // cause waves of half the length, which are below the contact width. Where errors make pins different,
        // the combination of pins and positions matters as much, and this has no advantage.
        let stride = if self.meshing.discs_alike() && count % 2 == 1 { 2 } else { 1 };
        let (sets, several) = (self.places % count, self.meshing.pitches() > 1);
        let place = |index: usize| if several { stride * (index + sets) % count } else { index };
        let tasks: Vec<Task> = (case.duty.iter().enumerate())
            .filter(|(_, duty)| duty.wears())
            .flat_map(|(row, duty)| (0..count).map(move |index| (row, duty, index)))
            .map(|(row, &DutyPoint { torque, forces, .. }, index)| {
                let shift = (place(index) + count - index) % count;
                let crank = self.meshing.crank_position(index, count, offset, shift);
                Task { crank, torque, forces, slot: row * count + place(index) }
            })
            .collect();
        let mut found = self.pin_contacts(&tasks)?.into_iter();
        for duty in case.duty.iter().filter(|duty| duty.wears()) {
            let mut passes: Vec<Vec<Pass>> =
                vec![Vec::with_capacity(count * case.pin_count()); case.disc_count];
            for discs in found.by_ref().take(count) {
                for (disc, (contacts, passes)) in discs.iter().zip(&mut passes).enumerate() {
                    let flank = &state.flanks[disc % state.flanks.len()];
                    passes.extend(contacts.iter().map(|contact| {
                        let pin = state.effective_pin_of(disc, contact.pin, case.pin_count());
                        self.pass(contact, duty, flank, pin, time)
                    }));
                }
            }
            // If one flank represents all discs, it has their mean rate.
            let weight = duty.share / (count * case.disc_count / flanks.len()) as f64;
            for (disc, passes) in passes.iter_mut().enumerate() {
                // All pins at all positions in the order of their contact with one tooth.
                passes.sort_by(|a, b| a.meshing_angle.total_cmp(&b.meshing_angle));
                let flank = disc % flanks.len();
                self.deposit_on_flank(passes, weight, &mut flanks[flank]);
                if case.wear.pin_ratio > 0.0 {
                    let own = case.pin_count();
                    match pins.chunks_exact_mut(own).nth(disc) {
                        Some(pins) => {
                            let own = disc * own..(disc + 1) * own;
                            let seen = (&state.effective_pins[own.clone()], &reaches[own]);
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
        let pin_cell = std::f64::consts::TAU * case.pin_radius / self.options.pin_points as f64;
        for pin in &mut pins {
            match case.pin_mounting {
                PinMounting::Fixed | PinMounting::OnePiece => {
                    pin.iter_mut().for_each(|section| *section /= pin_cell)
                }
                PinMounting::Spinning => {
                    let mean = pin.iter().sum::<f64>() / (pin.len() as f64 * pin_cell);
                    pin.fill(mean);
                }
            }
        }
        Ok(Rates { flanks, pins })
    }

    /// The contacts of every disc for all `tasks`, each started from the last solution at its position. Threads
    /// process them in any order, each with its own meshing; results do not depend on the order.
    fn pin_contacts(&mut self, tasks: &[Task]) -> Result<Vec<Vec<Vec<PinContact>>>, WearError> {
        let (starts, tilts) = (&self.starts, DutyPoint::any_tilts(&self.case.duty));
        let solve_near = |meshing: &mut S, task: &Task, start: Option<&S::Start>| {
            if tilts {
                meshing.set_output_forces(task.forces);
            }
            meshing.pin_contacts(task.crank, task.torque, starts[task.slot].as_ref().or(start))
        };
        // New positions start from the solution of the first one.
        let first = match tasks.first().filter(|task| starts[task.slot].is_none()) {
            Some(task) => Some(solve_near(&mut self.meshing, task, None)?.1),
            None => None,
        };
        let solve = |meshing: &mut S, task: &Task| solve_near(meshing, task, first.as_ref());
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

    /// Rate of the depth that one contact removes from a flank with the wear depths `flank` and a pin with the
    /// effective depth `pin`. The rate of pins is proportional to that of the flank.
    fn pass(&self, c: &PinContact, duty: &DutyPoint, flank: &Relief, pin: &Relief, time: f64) -> Pass {
        let case = &self.case;
        let contacts = self.meshing.contacts();
        let (profile, contact) = (contacts.profile(), contacts.contact());
        let lobes = profile.lobes_per_turn();
        let disc_speed = self.meshing.disc_speed(duty.input_speed).abs();
        let cos = c.meshing_angle.cos();
        let sliding = contacts.sliding_way(c) * disc_speed;
        let radius = 1.0 / c.relative_curvature;
        let half_width = contact.half_width(c.force, radius);
        let removal = if c.force > 0.0 {
            let line_load = c.force / case.disc_width;
            let film_ratio = case.wear.lubrication.as_ref().map_or(0.0, |oil| {
                let on_flank = profile.flank_length_per_meshing_angle(cos) * lobes * disc_speed;
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
            pin_angle: self.average.touching(pin, contacts.pin_angle(c)),
            half_width,
            removal,
        }
    }

    /// Distributes the removal along the path of the contact over the flank, as the mean of the lobes.
    fn deposit_on_flank(&self, passes: &[Pass], weight: f64, flank: &mut [f64]) {
        let lobes = self.case.profile.lobe_count() as f64;
        // The path of a contact ends at the end of the flank.
        let last = self.case.profile.last_meshing_angle();
        let has_tip = self.case.profile.tip().is_some();
        let on_flank = |end: f64, at: f64| match has_tip {
            true => (at + crate::units::wrap_angle(end - at)).clamp(-last, last),
            false => end,
        };
        for (before, pass, after) in neighbours(passes) {
            let ends = (
                on_flank(halfway(before.meshing_angle, pass.meshing_angle), pass.meshing_angle),
                on_flank(halfway(after.meshing_angle, pass.meshing_angle), pass.meshing_angle),
            );
            self.arc.spread(flank, ends.0, ends.1, pass.half_width, weight * pass.removal / lobes);
        }
    }

    /// The same over the pins, as their mean.
    fn deposit_on_pins(&self, passes: &[Pass], weight: f64, pin: &mut [f64], reach: &[f64]) {
        let case = &self.case;
        let count = case.pin_count() as f64;
        for (before, pass, after) in neighbours(passes) {
            let ends = (halfway(before.pin_angle, pass.pin_angle), halfway(after.pin_angle, pass.pin_angle));
            let amount = case.wear.pin_ratio * (weight * pass.removal) / count;
            spread_on_pin(pin, reach, case.pin_radius, ends.0, ends.1, pass.half_width, amount);
        }
    }

    /// The same for every pin separately. One pin has contact at few meshing angles, so that its removal is
    /// interpolated linearly between them, with the path of the contact on a nominal pin. `seen` is the
    /// effective depth of each pin, and the fraction within reach.
    fn deposit_on_each_pin(
        &self,
        passes: &[Pass],
        weight: f64,
        pins: &mut [Vec<f64>],
        seen: (&[Relief], &[Vec<f64>]),
    ) {
        let case = &self.case;
        let profile = self.meshing.contacts().profile();
        let mut own: Vec<Vec<&Pass>> = vec![Vec::new(); pins.len()];
        passes.iter().for_each(|pass| own[pass.pin].push(pass));
        for ((pin, own), (seen, reach)) in pins.iter_mut().zip(&own).zip(seen.0.iter().zip(seen.1)) {
            for (index, pass) in own.iter().enumerate() {
                let next = own[(index + 1) % own.len()];
                if pass.removal <= 0.0 && next.removal <= 0.0 {
                    continue;
                }
                // A whole turn if it is the only one.
                let way = (next.meshing_angle - pass.meshing_angle).rem_euclid(std::f64::consts::TAU);
                let way = if own.len() == 1 { std::f64::consts::TAU } else { way };
                let pieces = (way / PIN_PIECE).ceil().max(1.0);
                for piece in 0..pieces as usize {
                    let at = |share: f64| pass.meshing_angle + way * (piece as f64 + share) / pieces;
                    let between = (piece as f64 + 0.5) / pieces;
                    let blend = |a: f64, b: f64| a + (b - a) * between;
                    let removal = blend(pass.removal, next.removal);
                    // An unloaded contact has zero width; the width is interpolated towards that of its
                    // neighbour.
                    let half_width = blend(pass.half_width, next.half_width).max(1e-9);
                    let amount =
                        case.wear.pin_ratio * weight * removal * way / pieces / std::f64::consts::TAU;
                    let touching = |share| self.average.touching(seen, profile.pin_angle(at(share)));
                    let (from, to) = (touching(0.0), touching(1.0));
                    spread_on_pin(pin, reach, case.pin_radius, from, to, half_width, amount);
                }
            }
        }
    }

    /// State after the addition of rates times exposure.
    pub(super) fn advanced(&self, state: &WearSnapshot, parts: &[(&Rates, f64)]) -> WearSnapshot {
        type OfRates = fn(&Rates) -> &Vec<Vec<f64>>;
        // A surface with its effective depth; a surface without removal is not changed.
        let add =
            |(reliefs, seen): (&[Relief], &[Relief]), rates: OfRates, look: &dyn Fn(&Relief) -> Relief| {
                let one = |(index, (relief, seen)): (usize, (&Relief, &Relief))| {
                    if parts.iter().all(|(part, _)| rates(part)[index].iter().all(|rate| *rate == 0.0)) {
                        return (relief.clone(), seen.clone());
                    }
                    let mut depths = relief.samples().to_vec();
                    for (part, step) in parts {
                        for (depth, rate) in depths.iter_mut().zip(&rates(part)[index]) {
                            *depth += rate * step;
                        }
                    }
                    let worn = Relief::from_samples(depths);
                    let seen = look(&worn);
                    (worn, seen)
                };
                reliefs.iter().zip(seen).enumerate().map(one).unzip()
            };
        let (flanks, effective_flanks) =
            add((&state.flanks, &state.effective_flanks), |rates| &rates.flanks, &|flank| {
                self.average.flank(flank)
            });
        let (pins, effective_pins) =
            add((&state.pins, &state.effective_pins), |rates| &rates.pins, &|pin| self.average.pin(pin));
        let exposure = state.exposure + parts.iter().map(|(_, step)| step).sum::<f64>();
        WearSnapshot { exposure, effective_flanks, effective_pins, flanks, pins }
    }
}

/// Loaded passes with their predecessors and successors, cyclically.
fn neighbours(passes: &[Pass]) -> impl Iterator<Item = (&Pass, &Pass, &Pass)> {
    let count = passes.len();
    let all = passes.iter().enumerate().filter(|(_, pass)| pass.removal > 0.0);
    all.map(move |(index, pass)| (&passes[(index + count - 1) % count], pass, &passes[(index + 1) % count]))
}

fn halfway(other: f64, here: f64) -> f64 {
    here + 0.5 * wrap_angle(other - here)
}

/// Longest interval of meshing angle (rad) within which the removal on a pin is taken as constant: an
/// assumption, a third of the 9° between the pins of a usual ring, so that the linear interpolation between
/// contacts is resolved.
const PIN_PIECE: f64 = 3.0 * std::f64::consts::PI / 180.0;

/// A position whose load sharing is to be computed.
struct Task {
    crank: CrankAngle,
    torque: f64,
    /// Forces and moments on the output at this row of the duty.
    forces: OutputForces,
    /// Index of its last solution.
    slot: usize,
}

/// One contact on its path along the flank.
#[derive(Debug, Clone, Copy)]
struct Pass {
    pin: usize,
    meshing_angle: f64,
    pin_angle: f64,
    half_width: f64,
    /// Rate integrated over the width, m²/s per 1/Pa; F/B |v_s| by Archard's law.
    removal: f64,
}
