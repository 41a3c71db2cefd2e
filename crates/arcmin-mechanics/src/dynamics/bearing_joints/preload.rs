//! Preload: pins pressed without load in a machine with bearings, and the relief that would free them.

use super::BearingMeshing;
use crate::geometry::Relief;
use crate::load::{LoadError, Preload};
use crate::machine::CrankAngle;

/// Share of the pin forces under a small torque below which those without load are none.
const NO_PRELOAD: f64 = 1e-2;
/// The relief that frees is known when two secants differ by no more than this share of it, or no more is missing.
const RELIEF_TOLERANCE: f64 = 1e-3;
/// A relief in m that nobody notices: some 1e-6' of play.
const LEAST_RELIEF: f64 = 1e-11;
/// Share of the force (its 0.9th power) that is none: what the balances leave of it.
const NOTHING: f64 = 1e-4;
/// Share of the way to where the secant vanishes.
const MOST_OF_THE_WAY: f64 = 0.97;
/// The first trial, as a share of what the contact that presses most has given way by; and of what freed the machine
/// as it stood a little earlier.
const FIRST_SHARE: f64 = 0.5;
const KNOWN_SHARE: f64 = 0.9;
const LARGEST_ITERATION_COUNT: usize = 30;

/// How the search for the freeing relief ended.
#[derive(Debug, Clone)]
pub(super) struct Freed {
    /// In m.
    relief: f64,
    /// [`straight`] of the force without relief.
    whole: f64,
    /// The last relief in m under which a pin pressed, and the deviation there.
    last: (f64, Vec<f64>),
}

/// Nearly a straight line over the relief: force of line contact grows about as the 1.1th power of the approach.
fn straight(force: f64) -> f64 {
    force.powf(0.9)
}

impl BearingMeshing {
    /// The load-free balance of a machine whose pins press without load, and how they do; `None` where it is
    /// free. `ends` are the deviations of the balances under ±`torque` (N·m), a small one: half-way between
    /// them no pin of a free machine touches.
    pub(super) fn load_free(
        &mut self,
        crank: CrankAngle,
        ends: [&Vec<f64>; 2],
        torque: f64,
    ) -> Result<Option<(Vec<f64>, Preload)>, LoadError> {
        let least = self.least_preload(torque);
        let middle: Vec<f64> = ends[0].iter().zip(ends[1]).map(|(a, b)| 0.5 * (a + b)).collect();
        let place = self.place(crank, &middle);
        if self.preload(&place).force <= least {
            return Ok(None);
        }
        let (position, _) = self.balance_again(crank, 0.0, Some(&middle))?;
        let preload = self.preload(&position);
        Ok((preload.force > least).then_some((position, preload)))
    }

    /// The load-free balance, if pins still press in it; `None` too where none was found at this place before, for
    /// then nothing pressed as the machine stood a little earlier, and wear does not tighten it.
    pub(super) fn still_pressed(
        &mut self,
        crank: CrankAngle,
        torque: f64,
    ) -> Result<Option<(Vec<f64>, Preload)>, LoadError> {
        if !self.knows(crank, 0.0) {
            return Ok(None);
        }
        let (position, _) = self.balance_again(crank, 0.0, None)?;
        let preload = self.preload(&position);
        Ok((preload.force > self.least_preload(torque)).then_some((position, preload)))
    }

    /// Force of a pin in N below which it does not press, as `torque` (N·m) is small.
    fn least_preload(&self, torque: f64) -> f64 {
        let kinematics = self.model.kinematics();
        NO_PRELOAD * torque / (kinematics.eccentricity * kinematics.lobe_count)
    }

    fn preload(&self, position: &[f64]) -> Preload {
        Preload::of(&self.model.loaded_pin_contacts(position), &self.model.rings[0].contacts)
    }

    /// Uniform relief of all flanks in m at which the last pin force of the load-free balance vanishes, from
    /// the balance as it is (`deviation`): the least one that the limits of the bodies leave, or, where that search
    /// finds none, the one that balances under ever more relief lead to.
    pub(super) fn freeing_relief(
        &mut self,
        crank: CrankAngle,
        deviation: &[f64],
        preload: Preload,
        torque: f64,
    ) -> Result<f64, LoadError> {
        let start = self.place(crank, deviation);
        if let Some(relief) = self.least_relief(crank, &start) {
            return Ok(relief);
        }
        let least = self.least_preload(torque);
        let base: Vec<Relief> = self.model.rings.iter().map(|ring| ring.contacts.relief().clone()).collect();
        let found = self.seek_freeing_relief(&base, crank, deviation, preload, least);
        for (ring, relief) in self.model.rings.iter_mut().zip(base) {
            ring.contacts.set_relief(relief);
        }
        found
    }

    /// By secants of the force's 0.9th power: each goes most of the way to where the one before says that nothing
    /// presses, so that pins still hold the bodies, until two agree or next to nothing is missing. Where a trial
    /// finds them free, the place is enclosed.
    fn seek_freeing_relief(
        &mut self,
        base: &[Relief],
        crank: CrankAngle,
        deviation: &[f64],
        preload: Preload,
        least: f64,
    ) -> Result<f64, LoadError> {
        // The last two balances in which pins press: the bodies move in proportion to the relief as long as the
        // same contacts bear, so the next balance lies on the straight line through them.
        let mut path = [(0.0, deviation.to_vec()), (0.0, deviation.to_vec())];
        let whole = straight(preload.force);
        let nothing = straight(least).max(NOTHING * whole);
        let (mut pressing, mut force) = (0.0, whole);
        let (mut free, mut vanishes) = (f64::INFINITY, f64::NAN);
        let mut relief = match self.freed.take(crank, 0.0) {
            Some(known) => {
                path[1] = known.last;
                KNOWN_SHARE * known.relief * whole / known.whole
            }
            None => {
                // The contact alone gives way by this much; bearings and shafts give way besides.
                let contact = self.model.rings[0].contacts.contact();
                FIRST_SHARE * contact.approach(preload.force, contact.pin_radius)
            }
        };
        for _ in 0..LARGEST_ITERATION_COUNT {
            for (ring, base) in self.model.rings.iter_mut().zip(base) {
                ring.contacts.set_relief(base.plus(&Relief::uniform(relief)));
            }
            let (position, _) = self.balance_from_afar(crank, 0.0, Some(&along(&path, relief)))?;
            let left = straight(self.preload(&position).force);
            let mut found = None;
            if left <= nothing {
                free = relief;
            } else {
                path.swap(0, 1);
                path[1] = (relief, self.deviation(crank, &position));
                let secant = if left < force {
                    (relief + left * (relief - pressing) / (force - left)).min(4.0 * relief)
                } else {
                    2.0 * relief
                };
                let agrees = (secant - vanishes).abs() <= RELIEF_TOLERANCE * secant;
                let near = secant - relief <= RELIEF_TOLERANCE * secant;
                (pressing, force, vanishes) = (relief, left, secant);
                if (agrees || near) && secant <= (1.0 + RELIEF_TOLERANCE) * free {
                    found = Some(secant);
                }
            }
            if found.is_none()
                && free.is_finite()
                && free - pressing <= (RELIEF_TOLERANCE * free).max(LEAST_RELIEF)
            {
                found = Some(0.5 * (pressing + free));
            }
            if let Some(relief) = found {
                let [_, last] = path;
                self.freed.keep(crank, 0.0, Freed { relief, whole, last });
                return Ok(relief);
            }
            let next = pressing + MOST_OF_THE_WAY * (vanishes - pressing);
            relief = if next < free { next } else { 0.5 * (pressing + free) };
        }
        Err(LoadError::NotFreed { crank_angle_deg: crank.degrees(), relief, trials: LARGEST_ITERATION_COUNT })
    }
}

/// Straight line through two deviations at their reliefs, at another one.
fn along([(r0, q0), (r1, q1)]: &[(f64, Vec<f64>); 2], relief: f64) -> Vec<f64> {
    let share = if r1 > r0 { (relief - r1) / (r1 - r0) } else { 0.0 };
    q0.iter().zip(q1).map(|(a, b)| b + share * (b - a)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::JointSettings;
    use crate::dynamics::BearingMeshing;
    use crate::geometry::Relief;
    use crate::load::ShareLoad;
    use crate::machine::ManufacturingErrors;

    /// The relief that frees, held against balances on either side: relieved by 0.5 % more nothing presses without
    /// load, by 1 % less some pin does. Both ways to it agree. Both shipped designs, tight by either offset, nominal
    /// and with errors of manufacture.
    #[test]
    fn a_little_more_relief_frees_and_a_little_less_does_not() {
        let tolerances = crate::templates::design("tao2024").unwrap().drawing_tolerances().unwrap();
        // Theoretical flanks, so that one offset alone makes all of them tight.
        const OTHER: &str = include_str!("../../../../arcmin/tests/designs/rv-80e-two-crankshafts.toml");
        for (name, text, key) in [
            ("tao2024", crate::templates::TAO2024.text, "equidistant_offset_um"),
            ("tao2024", crate::templates::TAO2024.text, "radial_offset_um"),
            ("rv-80e", OTHER, "equidistant_offset_um"),
        ] {
            // Interference is a negative equidistant and a positive radial offset.
            let tight = if key == "radial_offset_um" { 12.0 } else { -12.0 };
            let design = crate::design::Design::parse(text, name).unwrap();
            let machine = design.with(&format!("disc.modification.{key}"), tight).unwrap().machine();
            for seed in [None, Some(3)] {
                let errors = seed.map_or_else(ManufacturingErrors::default, |seed| {
                    ManufacturingErrors::draw(&machine, &tolerances, seed)
                });
                let settings = JointSettings { errors, ..JointSettings::default() };
                let mut meshing = BearingMeshing::new(&machine, &settings).unwrap();
                let small = 1e-4 * machine.rated.torque;
                let base: Vec<Relief> =
                    meshing.model.rings.iter().map(|ring| ring.contacts.relief().clone()).collect();
                for index in 0..3 {
                    let crank = meshing.crank_position(index, 3, 0.0, 0);
                    let ends = [1.0, -1.0].map(|sign| {
                        let (position, _) = meshing.balance(crank, sign * small, None).unwrap();
                        meshing.deviation(crank, &position)
                    });
                    let (position, preload) =
                        meshing.load_free(crank, [&ends[0], &ends[1]], small).unwrap().unwrap();
                    let deviation = meshing.deviation(crank, &position);
                    let relief = meshing.freeing_relief(crank, &deviation, preload, small).unwrap();
                    let least = meshing.least_preload(small);
                    let by_secants =
                        meshing.seek_freeing_relief(&base, crank, &deviation, preload, least).unwrap();
                    assert!(
                        (by_secants / relief - 1.0).abs() < 5e-3,
                        "{name} {key} {seed:?} {index}: {relief:e} m from limits, {by_secants:e} m by secants"
                    );
                    let mut left = |share: f64| {
                        for (ring, base) in meshing.model.rings.iter_mut().zip(&base) {
                            ring.contacts.set_relief(base.plus(&Relief::uniform(share * relief)));
                        }
                        let (position, _) = meshing.balance(crank, 0.0, Some(&deviation)).unwrap();
                        let left = meshing.preload(&position).force;
                        for (ring, base) in meshing.model.rings.iter_mut().zip(&base) {
                            ring.contacts.set_relief(base.clone());
                        }
                        left
                    };
                    let (less, more) = (left(0.99), left(1.005));
                    let place = format!("{name} {key} {seed:?} {index}: {relief:e} m, {} N", preload.force);
                    let nothing = 1e-4 * preload.force;
                    assert!(
                        less > nothing && more < nothing,
                        "{place}: {less} N with less, {more} N with more"
                    );
                }
            }
        }
    }
}
