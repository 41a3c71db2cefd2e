//! Updates of flanks with nearly the shape of their pins: long steps by a stabilised explicit method.

use super::rates::Rates;
use super::{CoupledWear, UNCHECKED_UPDATES, WearSnapshot};
use crate::load::ShareLoad;

/// Ratio of the largest increment to the step of Heun's method above which a flank counts as stiff.
const STIFF: f64 = 3.0;
/// Largest number of stages, each one evaluation of the contacts, in one step.
const MOST_STAGES: usize = 9;
/// Fraction of the largest stable step, which is estimated from Heun's next step. Between 0.5 and 1 neither
/// cost nor result changes significantly.
const SAFETY: f64 = 0.8;
/// Steps that remove more than this multiple of the largest increment are rejected.
const TOO_MUCH: f64 = 2.0;

/// State of the step size where the flanks are stiff.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stiffness {
    /// Exposure of the next step by Heun's method.
    short: f64,
    /// Exposure of the next long step.
    long: f64,
    /// Long steps left before the next step by Heun's method.
    left: usize,
}

impl<S: ShareLoad> CoupledWear<S> {
    /// Called where the step is limited by contacts that lose their force within an update: `short` is the
    /// exposure of Heun's next step, `largest` the largest rate of its last.
    pub(super) fn estimate_stiffness(&mut self, depth: f64, short: f64, largest: f64) {
        let long = self.long_increment(depth) / largest;
        let stiff = long > STIFF * short;
        self.stiffness = stiff.then_some(Stiffness { short, long, left: UNCHECKED_UPDATES });
    }

    /// Largest increment of a long step in m. The method is of first order, so that it stays below those of
    /// Heun's method.
    fn long_increment(&self, depth: f64) -> f64 {
        let [increment, share] = self.options.few_places;
        self.largest_increment(depth).min(increment.max(share * depth))
    }

    /// One long step by the Runge–Kutta–Legendre method (RKL1; Meyer, Balsara and Aslam, J. Comput. Phys. 257
    /// (2014) 594): with s stages it is stable up to (s² + s)/2 times the step of Euler's method. `None` if
    /// flanks are not stiff, a load sharing fails, or the increment would be too large.
    ///
    /// A contact with a flank that has nearly the shape of the pin loses its force within 0.04 µm of wear.
    /// Explicit steps much longer than that oscillate, and implicit ones need the derivatives of all contacts
    /// by each other. Here the stages damp the oscillations. All rates have positive weights, so that no depth
    /// decreases, and each stage uses other positions of the pins.
    pub(super) fn update_by_stages(&mut self, before: &WearSnapshot, depth: f64, target: f64) -> Option<f64> {
        let Stiffness { short, long, left } = self.stiffness.take()?;
        let first = self.rates(before).ok()?;
        if !(first.largest() > 0.0) {
            return None;
        }
        let reach = |stages: usize| SAFETY * 0.5 * (stages * (stages + 1)) as f64 * short;
        let wanted = long.min(reach(MOST_STAGES));
        let step = super::equal_last_steps(target - before.exposure, wanted);
        let stages = (2..MOST_STAGES).find(|stages| reach(*stages) >= step).unwrap_or(MOST_STAGES);
        // Fraction of the step after a number of stages: j (j + 1)/(s (s + 1)).
        let gone = |stage: usize| (stage * (stage + 1)) as f64 / (stages * (stages + 1)) as f64;
        // Removal so far, and before the last stage, over the whole step.
        let mut mean = Rates::sum(&[(&first, gone(1))]);
        let mut mean_before = Rates::sum(&[(&first, 0.0)]);
        for stage in 2..=stages {
            let mut state = self.advanced(before, &[(&mean, step)]);
            state.exposure = before.exposure + step * gone(stage - 1);
            self.places += 1;
            let rates = self.rates(&state).ok()?;
            let j = stage as f64;
            let (now, then) = ((2.0 * j - 1.0) / j, (1.0 - j) / j);
            let next = Rates::sum(&[(&mean, now), (&mean_before, then), (&rates, now * gone(1))]);
            mean_before = std::mem::replace(&mut mean, next);
        }
        let (most, removed) = (self.long_increment(depth), step * mean.largest());
        if !(removed <= TOO_MUCH * most) {
            return None;
        }
        self.state = self.advanced(before, &[(&mean, step)]);
        if left > 1 {
            let next = step * (0.9 * most / removed).clamp(0.3, 2.0);
            // A step shortened by the target does not limit the next one.
            let long = if step < wanted { next.max(long) } else { next };
            self.stiffness = Some(Stiffness { short, long, left: left - 1 });
        }
        Some(step)
    }
}

#[cfg(test)]
mod tests {
    use super::super::CoupledOptions;
    use super::*;
    use crate::design::Design;
    use crate::units::UM;

    /// A small ring whose flanks wear into its 68 pins: the stabilised method agrees with Heun's method and
    /// needs a third of its updates.
    #[test]
    fn long_steps_lead_where_short_ones_do() {
        let path =
            concat!(env!("CARGO_MANIFEST_DIR"), "/../arcmin/tests/designs/small_ring_wearing_deep.toml");
        let machine = Design::parse(&std::fs::read_to_string(path).unwrap(), path).unwrap().machine();
        let options = CoupledOptions { crank_positions: 9, ..CoupledOptions::default() };
        let mut both = CoupledWear::new(&machine, options).at_any_play();
        both.advance_until(f64::MAX, |state| state.flank().deepest().0 > 18.0 * UM).unwrap();
        let mut short = CoupledWear::new(&machine, options).at_any_play();
        let (mut both_updates, start) = (both.updates(), both.state().clone());
        // Both from the same worn machine.
        for wear in [&mut both, &mut short] {
            (wear.state, wear.stiffness, wear.step, wear.recent) = (start.clone(), None, None, None);
        }
        let target = 1.25 * start.exposure;
        both.advance_to(target).unwrap();
        both_updates = both.updates() - both_updates;
        while short.state.exposure < target {
            short.stiffness = None;
            short.update(target).unwrap();
        }
        assert!(3 * both_updates < short.updates(), "{both_updates} {}", short.updates());
        let (deepest, _) = short.state.flank().deepest();
        let gained = deepest - start.flank().deepest().0;
        assert!(gained > 2.0 * UM, "{gained}");
        assert!((both.state.flank().deepest().0 - deepest).abs() < 0.05 * gained);
        let (mut off, mut sum) = (0.0, 0.0);
        let depths = both.state.flank().samples().iter().zip(short.state.flank().samples());
        for ((long, short), before) in depths.zip(start.flank().samples()) {
            assert!(long >= before);
            off += (long - short).abs();
            sum += short - before;
        }
        assert!(off < 0.05 * sum, "{off:e} {sum:e}");
    }
}
