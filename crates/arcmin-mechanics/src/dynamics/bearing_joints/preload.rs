//! Preload: pins loaded without external torque in a machine with bearings, and the relief that removes this
//! load.

use super::BearingMeshing;
use crate::geometry::Relief;
use crate::load::{LoadError, Preload};
use crate::machine::CrankAngle;

/// Fraction of the pin forces under a small torque below which those without torque count as zero.
const NO_PRELOAD: f64 = 1e-2;
/// The search for the relief ends if two secants agree within this fraction, or if the remainder is negligible.
const RELIEF_TOLERANCE: f64 = 1e-3;
/// Negligible relief in m: about 1e-6' of backlash.
const LEAST_RELIEF: f64 = 1e-11;
/// Fraction of the force (its 0.9th power) that counts as zero: the tolerance of the equilibria.
const NOTHING: f64 = 1e-4;
/// Fraction of the step to the zero of the secant.
const SECANT_FRACTION: f64 = 0.97;
/// The first trial, as a fraction of the approach of the most loaded contact; and of the relief found for the
/// same machine at a slightly smaller wear.
const FIRST_SHARE: f64 = 0.5;
const KNOWN_SHARE: f64 = 0.9;
const LARGEST_ITERATION_COUNT: usize = 30;

/// Result of the search for the relief without load.
#[derive(Debug, Clone)]
pub(super) struct ReliefWithoutLoad {
    /// Relief in m.
    relief: f64,
    /// [`straight`] of the force without relief.
    whole: f64,
    /// The last relief in m with a loaded pin, and the deviation there.
    last: (f64, Vec<f64>),
}

/// Nearly linear in the relief: the force of a line contact is proportional to the 1.1th power of the approach,
/// approximately.
fn straight(force: f64) -> f64 {
    force.powf(0.9)
}

impl BearingMeshing {
    /// The no-load equilibrium of a machine whose pins are loaded without torque, and the type of that load;
    /// `None` without such load. `ends` are the deviations of the equilibria under ±`torque` (N·m), a small
    /// one: halfway between them a machine with clearance has no loaded pin.
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
        let (position, _) = self.balance_from_last(crank, 0.0, Some(&middle))?;
        let preload = self.preload(&position);
        Ok((preload.force > least).then_some((position, preload)))
    }

    /// The no-load equilibrium if pins are still loaded in it; `None` also if there was none at this position
    /// before, because then no pin was loaded at a slightly smaller wear, and wear only increases the gaps.
    pub(super) fn loaded_equilibrium(
        &mut self,
        crank: CrankAngle,
        torque: f64,
    ) -> Result<Option<(Vec<f64>, Preload)>, LoadError> {
        if !self.has_equilibrium(crank, 0.0) {
            return Ok(None);
        }
        let (position, _) = self.balance_from_last(crank, 0.0, None)?;
        let preload = self.preload(&position);
        Ok((preload.force > self.least_preload(torque)).then_some((position, preload)))
    }

    /// Pin force in N below which a pin counts as unloaded, since `torque` (N·m) is small.
    fn least_preload(&self, torque: f64) -> f64 {
        let kinematics = self.model.kinematics();
        NO_PRELOAD * torque / (kinematics.eccentricity * kinematics.lobe_count)
    }

    fn preload(&self, position: &[f64]) -> Preload {
        Preload::of(&self.model.loaded_pin_contacts(position), &self.model.rings[0].contacts)
    }

    /// Uniform relief of all flanks in m at which the last pin force of the no-load equilibrium vanishes, from
    /// the present equilibrium (`deviation`): the smallest one allowed by the constraints of the bodies, or, if
    /// that search fails, the one found by equilibria under increasing relief.
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

    /// Secant method on the force's 0.9th power: each step goes most of the way to the predicted zero, so that
    /// pins still constrain the bodies, until two predictions agree or the remainder is negligible. If a trial
    /// has no loaded pin, the zero is bracketed.
    fn seek_freeing_relief(
        &mut self,
        base: &[Relief],
        crank: CrankAngle,
        deviation: &[f64],
        preload: Preload,
        least: f64,
    ) -> Result<f64, LoadError> {
        // The last two equilibria with loaded pins: while the active set does not change, displacements are
        // linear in the relief, so that the next equilibrium is extrapolated from them.
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
                // Approach of the contact alone; bearings and shafts add to it.
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
                self.freed.keep(crank, 0.0, ReliefWithoutLoad { relief, whole, last });
                return Ok(relief);
            }
            let next = pressing + SECANT_FRACTION * (vanishes - pressing);
            relief = if next < free { next } else { 0.5 * (pressing + free) };
        }
        Err(LoadError::NotFreed { crank_angle_deg: crank.degrees(), relief, trials: LARGEST_ITERATION_COUNT })
    }
}

/// Linear extrapolation of two deviations at their reliefs, to another one.
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

    /// The relief without load compared with equilibria on either side: with 0.5 % more relief no pin is loaded
    /// without torque, with 1 % less some pin is. Both methods agree. Both shipped designs, with interference
    /// by either offset, nominal and with manufacturing errors.
    #[test]
    fn pins_lose_their_load_at_the_computed_relief() {
        let tolerances = crate::templates::design("tao2024").unwrap().drawing_tolerances().unwrap();
        // Theoretical flanks, so that one offset causes interference at all of them.
        const OTHER: &str = include_str!("../../../../arcmin/tests/designs/rv-80e-two-crankshafts.toml");
        for (name, text, key) in [
            ("tao2024", crate::templates::TAO2024.text, "equidistant_offset_um"),
            ("tao2024", crate::templates::TAO2024.text, "radial_offset_um"),
            ("rv-80e", OTHER, "equidistant_offset_um"),
        ] {
            // A negative equidistant or a positive radial offset causes interference.
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
