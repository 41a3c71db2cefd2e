//! Largest force and largest pressure of a machine, independent of the sampled positions.
//!
//! Both are maxima over the crank angle, which a few dozen positions may miss. The neighbourhoods of the largest
//! values are therefore sampled again, half a step to either side, and half of that again. The pressure varies with
//! the square root of the curvature. Waves of 0.01 µm, left on a flank by the steps of the wear, change the curvature
//! by a tenth; it is therefore averaged over twice the width of the contact.

use crate::contact::LineContact;
use crate::geometry::Profile;
use crate::load::{Cycle, CycleContact, LoadSharing, ShareLoad};
use crate::machine::CrankAngle;

/// Half of the width of the flank over which curvature is averaged, in half-widths of the contact.
const HALF_WIDTHS: f64 = 2.0;
/// Least half-width of the average in rad of the meshing angle: two steps of the grid of worn flanks.
const LEAST_REACH: f64 = 2.0 * std::f64::consts::TAU / 720.0;
/// Largest half-width: beyond it the curvature of the flank itself changes.
const LARGEST_REACH: f64 = 6.0 * std::f64::consts::PI / 180.0;
/// Number of crank positions whose neighbourhood is sampled, and number of halvings of the step there.
const REFINED: usize = 2;
const HALVINGS: usize = 4;

/// The most heavily loaded contacts of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Extremes {
    /// Place of the largest force.
    pub largest_force: CycleContact,
    /// Place of the largest pressure, possibly at another pin.
    pub largest_pressure: CycleContact,
    /// Standard deviation in Pa of single pressures about the averaged one, around the place of the largest pressure.
    pub scatter: f64,
}

/// Curvatures sampled along the flanks.
struct Curvatures<'a> {
    profile: &'a Profile,
    contact: &'a LineContact,
    /// Per flank (meshing angle in rad, relative curvature in 1/m), in the order of the angles.
    flanks: Vec<Vec<(f64, f64)>>,
}

impl<'a> Curvatures<'a> {
    /// Curvatures at all loaded contacts of a cycle; one flank for all discs if their loads are alike.
    fn of(cycle: &Cycle, profile: &'a Profile, contact: &'a LineContact, alike: bool) -> Curvatures<'a> {
        let discs = cycle.positions.first().map_or(1, |position| position.discs.len().max(1));
        let mut read = vec![Vec::new(); if alike { 1 } else { discs }];
        for position in &cycle.positions {
            for (disc, pins) in position.discs.iter().enumerate() {
                let loaded = pins.iter().filter(|pin| pin.force > 0.0);
                let flank = disc % read.len();
                read[flank].extend(loaded.map(|pin| (pin.meshing_angle, pin.relative_curvature)));
            }
        }
        read.iter_mut().for_each(|flank| flank.sort_by(|a, b| a.0.total_cmp(&b.0)));
        Curvatures { profile, contact, flanks: read }
    }

    /// Samples around a place, within the averaging width of a contact of this force.
    fn around(&self, disc: usize, angle: f64, force: f64, curvature: f64) -> &[(f64, f64)] {
        let flank = &self.flanks[disc % self.flanks.len()];
        let width = HALF_WIDTHS * self.contact.half_width(force, 1.0 / curvature);
        let per_angle = self.profile.flank_length_per_meshing_angle(angle.cos());
        let reach = (width / per_angle).clamp(LEAST_REACH, LARGEST_REACH);
        let from = flank.partition_point(|(at, _)| *at < angle - reach);
        let to = flank.partition_point(|(at, _)| *at <= angle + reach);
        &flank[from..to]
    }

    /// The contacts of a position, each with the pressure of its mean curvature.
    fn spots(&self, position: &LoadSharing) -> Vec<CycleContact> {
        let discs = position.discs.iter().enumerate();
        let pins = discs.flat_map(|(disc, pins)| pins.iter().map(move |pin| (disc, pin)));
        pins.filter(|(_, pin)| pin.force > 0.0)
            .map(|(disc, pin)| {
                let read = self.around(disc, pin.meshing_angle, pin.force, pin.relative_curvature);
                let mean = mean(read).unwrap_or(pin.relative_curvature);
                CycleContact {
                    meshing_angle: pin.meshing_angle,
                    force: pin.force,
                    pressure: self.contact.pressure(pin.force, 1.0 / mean),
                    disc,
                    pin: pin.pin,
                }
            })
            .collect()
    }

    /// Relative standard deviation of single pressures around a place: half of that of the curvatures about a
    /// parabola fitted to their logarithms, which represents the curvature of the flank itself.
    fn scatter(&self, spot: &CycleContact, curvature: f64) -> f64 {
        let read = self.around(spot.disc, spot.meshing_angle, spot.force, curvature);
        let mut rest: Vec<f64> = read.iter().map(|(_, curvature)| curvature.ln()).collect();
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for power in 0..3 {
            let mut next: Vec<f64> =
                read.iter().map(|(at, _)| ((at - spot.meshing_angle) / LARGEST_REACH).powi(power)).collect();
            basis.iter().for_each(|other| remove_component(&mut next, other));
            remove_component(&mut rest, &next);
            basis.push(next);
        }
        let square: f64 = rest.iter().map(|rest| rest * rest).sum();
        if read.len() > 3 { 0.5 * (square / (read.len() - 3) as f64).sqrt() } else { 0.0 }
    }
}

/// Removes the component of a vector along another one.
fn remove_component(vector: &mut [f64], other: &[f64]) {
    let square: f64 = other.iter().map(|x| x * x).sum();
    if square > 0.0 {
        let part = vector.iter().zip(other).map(|(a, b)| a * b).sum::<f64>() / square;
        vector.iter_mut().zip(other).for_each(|(a, b)| *a -= part * b);
    }
}

fn mean(read: &[(f64, f64)]) -> Option<f64> {
    (!read.is_empty()).then(|| read.iter().map(|(_, curvature)| curvature).sum::<f64>() / read.len() as f64)
}

/// The place with the largest value of a measure.
fn largest(spots: &[CycleContact], measure: fn(&CycleContact) -> f64) -> CycleContact {
    spots.iter().copied().max_by(|a, b| measure(a).total_cmp(&measure(b))).unwrap_or_default()
}

/// The most heavily loaded contacts of a machine under a torque; `cycle` contains positions over one full period. An
/// intermediate position without equilibrium is skipped.
pub(super) fn extremes<S: ShareLoad>(meshing: &mut S, torque: f64, cycle: &Cycle) -> Extremes {
    let (profile, contact) = (meshing.contacts().profile().clone(), *meshing.contacts().contact());
    let curvatures = Curvatures::of(cycle, &profile, &contact, meshing.discs_alike());
    let spots: Vec<Vec<CycleContact>> =
        cycle.positions.iter().map(|position| curvatures.spots(position)).collect();
    let mut refine = |measure: fn(&CycleContact) -> f64| {
        let tops: Vec<CycleContact> = spots.iter().map(|spots| largest(spots, measure)).collect();
        let mut found = largest(&tops, measure);
        for place in peaks(&tops, measure).into_iter().take(REFINED) {
            let from = cycle.positions[place].crank_angle.radians();
            let step = cycle.period / cycle.positions.len() as f64;
            let refined = |angle: f64, start: &mut Option<S::Start>| {
                let crank = CrankAngle::from_radians(angle);
                let (sharing, next) = meshing.share(crank, torque, start.as_ref()).ok()?;
                *start = Some(next);
                Some(largest(&curvatures.spots(&sharing), measure))
            };
            let top = climb((from, tops[place]), step, measure, refined);
            if measure(&top) > measure(&found) {
                found = top;
            }
        }
        found
    };
    let (largest_force, largest_pressure) = (refine(|spot| spot.force), refine(|spot| spot.pressure));
    let curvature = profile.relative_curvature(largest_pressure.meshing_angle.cos(), profile.pin_radius);
    let scatter =
        largest_pressure.pressure * curvatures.scatter(&largest_pressure, curvature.max(f64::MIN_POSITIVE));
    Extremes { largest_force, largest_pressure, scatter }
}

/// Local maxima around the turn, the largest first.
fn peaks(tops: &[CycleContact], measure: fn(&CycleContact) -> f64) -> Vec<usize> {
    let count = tops.len();
    let is_peak = |at: &usize| {
        let neighbours = [(at + 1) % count, (at + count - 1) % count];
        neighbours.iter().all(|other| measure(&tops[*at]) >= measure(&tops[*other]))
    };
    let mut peaks: Vec<usize> = (0..count).filter(is_peak).collect();
    peaks.sort_by(|a, b| measure(&tops[*b]).total_cmp(&measure(&tops[*a])));
    peaks
}

/// The largest value near a crank angle (rad), by steps to either side that are halved repeatedly.
fn climb<T>(
    mut best: (f64, CycleContact),
    mut step: f64,
    measure: fn(&CycleContact) -> f64,
    mut evaluate: impl FnMut(f64, &mut Option<T>) -> Option<CycleContact>,
) -> CycleContact {
    let mut start = None;
    for _ in 0..HALVINGS {
        step *= 0.5;
        for angle in [best.0 - step, best.0 + step] {
            let found = evaluate(angle, &mut start);
            if let Some(top) = found.filter(|top| measure(top) > measure(&best.1)) {
                best = (angle, top);
            }
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fidelity::{Fidelity, Joints};
    use crate::geometry::Relief;
    use crate::life::{Course, WornState, worn_after};
    use crate::machine::{Machine, ManufacturingErrors};
    use crate::progress::Silent;
    use crate::random_designs::sound_design;
    use crate::units::{DEG, MPA, UM};
    use crate::wear::CoupledOptions;

    fn in_bearings() -> Fidelity {
        Fidelity { joints: Joints::Bearings, ..Fidelity::ideal() }
    }

    fn drawn(machine: &Machine, seed: u64) -> Fidelity {
        let design = crate::templates::design("tao2024").unwrap();
        let tolerances = design.drawing_tolerances().unwrap();
        in_bearings().with_errors(ManufacturingErrors::draw(machine, &tolerances, seed), seed)
    }

    /// At `count` positions: the extremes, and the largest single pressure.
    fn at(machine: &Machine, fidelity: &Fidelity, state: &WornState, count: usize) -> (Extremes, f64) {
        let mut meshing = fidelity.meshing(machine).unwrap();
        state.apply_to(&machine.designed_relief(), &mut meshing);
        let cycle = meshing.loaded_cycle(machine.rated.torque, count).unwrap();
        let single = cycle.max_pressure(meshing.contacts().contact());
        (extremes(&mut meshing, machine.rated.torque, &cycle), single)
    }

    /// Worn random designs: four times as many crank positions give the same largest force and largest
    /// pressure.
    #[test]
    fn extremes_converge_with_the_number_of_positions() {
        let mut tested = 0;
        for seed in 1..=6 {
            let machine = sound_design(seed).0.machine();
            let fidelity = in_bearings();
            let Ok(state) = worn_after(&machine, &fidelity, 300.0, &Silent) else { continue };
            let (coarse, fine) =
                (at(&machine, &fidelity, &state, 36).0, at(&machine, &fidelity, &state, 144).0);
            let off = |of: fn(&Extremes) -> f64| (of(&coarse) / of(&fine) - 1.0).abs();
            let (force, pressure) = (off(|e| e.largest_force.force), off(|e| e.largest_pressure.pressure));
            assert!(force < 0.05 && pressure < 0.04, "seed {seed}: {force} {pressure} {coarse:?} {fine:?}");
            tested += 1;
        }
        assert!(tested >= 4, "{tested}");
    }

    /// A drawn machine between neighbouring hours: single values jump by several per cent, the estimate hardly
    /// changes.
    #[test]
    fn pressures_of_neighbouring_hours_are_alike() {
        let machine = crate::templates::tao2024();
        let fidelity = drawn(&machine, 1);
        let mut course = Course::new(&machine, &fidelity, CoupledOptions::default()).unwrap();
        let mut history = Vec::new();
        for hours in [1000.0, 1100.0, 1200.0, 1300.0, 1400.0, 1500.0] {
            course.advance_to(hours, &Silent).unwrap();
            let (found, single) = at(&machine, &fidelity, &course.state(), 144);
            history.push((found.largest_pressure.pressure, single, found.scatter));
        }
        let jump = |of: fn(&(f64, f64, f64)) -> f64| {
            history.windows(2).map(|w| (of(&w[1]) / of(&w[0]) - 1.0).abs()).fold(0.0, f64::max)
        };
        let (averaged, single) = (jump(|h| h.0), jump(|h| h.1));
        assert!(averaged < 0.015 && averaged < 0.5 * single, "{averaged} {single} {history:?}");
        // The printed scatter is that of single values.
        assert!(history.iter().all(|h| (h.1 - h.0).abs() < 4.0 * h.2 + 0.02 * h.0), "{history:?}");
    }

    /// Waves of a hundredth of a micrometre, shorter than the contact width, on a flank as designed: they
    /// change the curvature in single pressures, but hardly the estimate.
    #[test]
    fn trap_waves_shorter_than_the_contact_are_no_curvature() {
        let machine = crate::templates::tao2024();
        let waves = |amplitude: f64| {
            let samples = Relief::grid(720).map(|phi| amplitude * (1.0 + (90.0 * phi).sin())).collect();
            let mut meshing = machine.meshing(&Relief::from_samples(samples));
            let cycle = meshing.loaded_cycle(machine.rated.torque, 36).unwrap();
            let single = cycle.max_pressure(meshing.contacts().contact());
            let found = extremes(&mut meshing, machine.rated.torque, &cycle);
            (found.largest_pressure.pressure, single, found.scatter)
        };
        let (plain, wavy) = (waves(0.0), waves(0.01 * UM));
        assert!((plain.0 / plain.1 - 1.0).abs() < 0.01, "{plain:?}");
        // In a contact of 13 µm waves of 120 µm have a fifth of their effect on single values.
        let (averaged, single) = (wavy.0 / plain.0 - 1.0, wavy.1 / plain.1 - 1.0);
        assert!(single > 0.1 && averaged.abs() < 0.25 * single, "{plain:?} {wavy:?}");
        assert!(wavy.2 > 10.0 * MPA && plain.2 < 0.01 * plain.0, "{plain:?} {wavy:?}");
    }

    /// A small torque on wide flanks: the increments of wear are limited by the elastic deformation of the
    /// contacts, so that waves on the flank do not decide which pins are loaded. With a quarter of the step the
    /// largest force is the same.
    #[test]
    fn forces_of_a_lightly_loaded_machine_do_not_depend_on_increments() {
        let mut machine = crate::templates::tao2024();
        machine.rated.torque = 20.0;
        machine.duty[0].torque = 20.0;
        let fidelity = in_bearings();
        let after = |options: CoupledOptions| {
            let mut course = Course::new(&machine, &fidelity, options).unwrap();
            course.advance_to(2000.0, &Silent).unwrap();
            at(&machine, &fidelity, &course.state(), 72).0
        };
        let usual = CoupledOptions::default();
        let [increment, share] = usual.few_places;
        let (coarse, fine) =
            (after(usual), after(CoupledOptions { few_places: [0.1 * increment, 0.1 * share], ..usual }));
        let off = (coarse.largest_force.force / fine.largest_force.force - 1.0).abs();
        assert!(off < 0.08, "{coarse:?} {fine:?}");
        assert!(coarse.largest_force.meshing_angle.abs() < 180.0 * DEG);
    }
}
