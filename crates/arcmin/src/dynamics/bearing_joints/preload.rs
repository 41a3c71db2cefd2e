//! What presses the pins of a machine with bearings without load, and the relief that would free it.

use super::BearingMeshing;
use crate::geometry::Relief;
use crate::load::{LoadError, Preload};
use crate::machine::CrankAngle;

/// Share of the pin forces under a small torque below which those without load are none.
const NO_PRELOAD: f64 = 1e-2;
/// The relief that frees is known when a step changes it by less than this share; force that is left likewise.
const RELIEF_TOLERANCE: f64 = 1e-3;
/// Force of line contact grows about as the 1.1th power of the approach: its 0.9th is nearly a straight line.
const STRAIGHT: f64 = 0.9;
/// Share of the way to where the secant vanishes.
const MOST_OF_THE_WAY: f64 = 0.9;
const LARGEST_ITERATION_COUNT: usize = 30;

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
        let kinematics = self.model.kinematics();
        let least = NO_PRELOAD * torque / (kinematics.eccentricity * kinematics.lobe_count);
        let middle: Vec<f64> = ends[0].iter().zip(ends[1]).map(|(a, b)| 0.5 * (a + b)).collect();
        let place = self.place(crank, &middle);
        if self.preload(&place).force <= least {
            return Ok(None);
        }
        let (position, _) = self.balance_again(crank, 0.0, Some(&middle))?;
        let preload = self.preload(&position);
        Ok((preload.force > least).then_some((position, preload)))
    }

    fn preload(&self, position: &[f64]) -> Preload {
        let discs: Vec<_> =
            (0..self.model.rings.len()).map(|disc| self.model.pin_contacts(disc, position)).collect();
        Preload::of(&discs, &self.model.rings[0])
    }

    /// Uniform relief of all flanks in m at which the last pin force of the load-free balance vanishes, from
    /// the balance as it is (`deviation`). Secants of the force's 0.9th power: each goes most of the way to where
    /// the one before says that nothing presses, so that pins still hold the bodies, until two agree. Where a
    /// trial finds them free, the place is enclosed.
    pub(super) fn freeing_relief(
        &mut self,
        crank: CrankAngle,
        deviation: &[f64],
        preload: Preload,
    ) -> Result<f64, LoadError> {
        let base: Vec<Relief> = self.model.rings.iter().map(|ring| ring.relief().clone()).collect();
        let found = self.seek_freeing_relief(&base, crank, deviation, preload);
        for (ring, relief) in self.model.rings.iter_mut().zip(base) {
            ring.set_relief(relief);
        }
        found
    }

    fn seek_freeing_relief(
        &mut self,
        base: &[Relief],
        crank: CrankAngle,
        deviation: &[f64],
        preload: Preload,
    ) -> Result<f64, LoadError> {
        let mut start = deviation.to_vec();
        let straight = |force: f64| force.powf(STRAIGHT);
        // The contact alone gives way by this much; bearings and shafts give way besides.
        let contact = self.model.rings[0].contact();
        let first = contact.approach(preload.force, contact.pin_radius);
        let (mut pressing, mut force) = (0.0, straight(preload.force));
        let whole = force;
        let (mut free, mut vanishes) = (f64::INFINITY, f64::NAN);
        let mut relief = first;
        for _ in 0..LARGEST_ITERATION_COUNT {
            for (ring, base) in self.model.rings.iter_mut().zip(base) {
                ring.set_relief(base.plus(&Relief::uniform(relief)));
            }
            let (position, _) = self.balance_from_afar(crank, 0.0, Some(&start))?;
            let left = straight(self.preload(&position).force);
            if left <= RELIEF_TOLERANCE * whole {
                free = relief;
            } else {
                start = self.deviation(crank, &position);
                let secant = if left < force {
                    (relief + left * (relief - pressing) / (force - left)).min(4.0 * relief)
                } else {
                    2.0 * relief
                };
                let agrees = (secant - vanishes).abs() <= RELIEF_TOLERANCE * secant;
                (pressing, force, vanishes) = (relief, left, secant);
                if agrees && secant <= free {
                    return Ok(secant);
                }
            }
            if free.is_finite() && free - pressing <= RELIEF_TOLERANCE * free {
                return Ok(0.5 * (pressing + free));
            }
            let next = pressing + MOST_OF_THE_WAY * (vanishes - pressing);
            relief = if next < free { next } else { 0.5 * (pressing + free) };
        }
        Ok(relief)
    }
}
