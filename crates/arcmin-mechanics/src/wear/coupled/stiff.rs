//! Updates on flanks that fit their pins closely: long steps by many looks at the contacts.

use super::rates::Rates;
use super::{CoupledWear, UNCHECKED_UPDATES, WearSnapshot};
use crate::load::ShareLoad;

/// So many steps of Heun's method to the largest increment make a flank stiff.
const STIFF: f64 = 3.0;
/// Looks at the contacts in one step at most.
const MOST_LOOKS: usize = 9;
/// Share taken of the longest stable step, whose measure, Heun's next step, is a rough one. Between 0.5 and 1
/// neither the cost nor what comes off changes to speak of.
const SAFETY: f64 = 0.8;
/// A step that takes off so many times the largest increment is not taken.
const TOO_MUCH: f64 = 2.0;

/// Steps that Heun's method could not take, for the stiff method.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stiffness {
    /// Exposure of the step that Heun's method would take next.
    short: f64,
    /// Exposure of the next long step.
    long: f64,
    /// Long steps left until a step is computed by Heun's method again.
    left: usize,
}

impl<S: ShareLoad> CoupledWear<S> {
    /// Set where contacts that lose their force within an update bind its length: `short` is the exposure of
    /// Heun's next step, `largest` the largest rate of its last.
    pub(super) fn look_for_stiffness(&mut self, depth: f64, short: f64, largest: f64) {
        let long = self.long_increment(depth) / largest;
        let stiff = long > STIFF * short;
        self.stiffness = stiff.then_some(Stiffness { short, long, left: UNCHECKED_UPDATES });
    }

    /// Largest increment of a long step in m. It is of first order, so it stays below those of Heun's method.
    fn long_increment(&self, depth: f64) -> f64 {
        let [increment, share] = self.options.few_places;
        self.largest_increment(depth).min(increment.max(share * depth))
    }

    /// One long step, by the stabilised method of Runge, Kutta and Legendre (RKL1; Meyer, Balsara and Aslam,
    /// J. Comput. Phys. 257 (2014) 594): with s looks at the contacts it is stable up to (s² + s)/2 times the
    /// step of Euler's method. `None` where flanks are not stiff, no load sharing is found on the way, or too
    /// much would come off.
    ///
    /// A contact that a flank fits closely loses its force while it loses some 0.04 µm. Explicit steps much
    /// longer than that swing to and fro, and implicit ones would need to know how all contacts act on each
    /// other. Here the looks are short steps of their own, whose swings die out. All rates enter with
    /// positive weights, so none brings metal back, and each look meets other places of the pins.
    pub(super) fn update_by_many_looks(
        &mut self,
        before: &WearSnapshot,
        depth: f64,
        target: f64,
    ) -> Option<f64> {
        let Stiffness { short, long, left } = self.stiffness.take()?;
        let first = self.rates(before).ok()?;
        if !(first.largest() > 0.0) {
            return None;
        }
        let reach = |looks: usize| SAFETY * 0.5 * (looks * (looks + 1)) as f64 * short;
        let wanted = long.min(reach(MOST_LOOKS));
        let step = super::equal_last_steps(target - before.exposure, wanted);
        let looks = (2..MOST_LOOKS).find(|looks| reach(*looks) >= step).unwrap_or(MOST_LOOKS);
        // Share of the step after so many looks: j (j + 1)/(s (s + 1)).
        let gone = |look: usize| (look * (look + 1)) as f64 / (looks * (looks + 1)) as f64;
        // Removal so far, and before the last look, over the whole step.
        let mut mean = Rates::sum(&[(&first, gone(1))]);
        let mut mean_before = Rates::sum(&[(&first, 0.0)]);
        for look in 2..=looks {
            let mut state = self.advanced(before, &[(&mean, step)]);
            state.exposure = before.exposure + step * gone(look - 1);
            self.places += 1;
            let rates = self.rates(&state).ok()?;
            let j = look as f64;
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
            // A step cut short by the target says nothing against a longer one.
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

    /// A small ring whose flanks wear into its 68 pins: steps of many looks lead where Heun's alone lead,
    /// with a third of the updates.
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
