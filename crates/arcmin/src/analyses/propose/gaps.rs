//! Gaps of a proposed single stage with which few drives of a series jam.

use rayon::prelude::*;

use crate::analyses::stage::{DRIVES, EccentricDrive};
use crate::design::StageDesign;
use crate::machine::{GapChain, StageErrors};
use crate::units::UM;

/// Gaps of a proposed drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaps {
    /// Gap between flank and ring pins, µm.
    pub profile_um: f64,
    /// Radial clearance of output pins in their holes, µm.
    pub hole_um: f64,
}

/// Largest share of drawn drives that jam, an assumption: for one of twenty a part is made again; a smaller share
/// needs more play.
pub(super) const JAM_LIMIT: f64 = 0.05;
/// Gaps increase in steps of this share of the least ones.
const STEP: f64 = 0.05;
/// Largest number of these steps: five times the least gaps.
const MOST_STEPS: usize = 80;

/// A series of drives, drawn from the tolerances of a design.
pub(super) struct Series {
    chain: GapChain,
    /// Errors of those that jam.
    jammed: Vec<Vec<StageErrors>>,
    /// Turn of the output for the gap of the flank and for the clearance of the holes, rad/m.
    play_per_gap: [f64; 2],
}

impl Series {
    /// The drives that `check` draws. `None` without tolerances.
    pub fn of(design: &StageDesign) -> Option<Series> {
        let chain = design.gap_chain();
        let parts = [(design.drive().part_counts(), design.tolerances()?)];
        let jammed = (1..=DRIVES)
            .into_par_iter()
            .map(|seed| StageErrors::draw(&parts, seed, None))
            .filter(|errors| chain.least(errors).is_none())
            .collect();
        let stage = design.drive();
        let play_per_gap = [2.0 / stage.lever(), 2.0 / stage.output_pins.circle_radius];
        Some(Series { chain, jammed, play_per_gap })
    }

    /// Share of the drives that jam.
    pub fn jam_rate(&self) -> f64 {
        self.jammed.len() as f64 / DRIVES as f64
    }

    pub fn keeps_the_limit(&self) -> bool {
        self.jam_rate() <= JAM_LIMIT
    }

    /// Gaps with which at most [`JAM_LIMIT`] of the drives jam, with the least additional play. `None` if even the
    /// largest gaps do not suffice.
    pub fn enough(&self, now: Gaps, least: Gaps) -> Option<Gaps> {
        let steps = [STEP * least.profile_um, STEP * least.hole_um];
        let does = |profile: usize, hole: usize| {
            let off = [profile as f64 * steps[0] * UM, hole as f64 * steps[1] * UM];
            let jam =
                self.jammed.par_iter().filter(|errors| !self.chain.can_be_assembled(errors, off)).count();
            jam as f64 <= JAM_LIMIT * DRIVES as f64
        };
        // The least number of steps of the flank for every clearance of the holes; it does not increase with the
        // clearance.
        let mut best: Option<(f64, Gaps)> = None;
        let mut profile = MOST_STEPS + 1;
        for hole in 0..=MOST_STEPS {
            let play = |profile: usize| {
                profile as f64 * steps[0] * self.play_per_gap[0]
                    + hole as f64 * steps[1] * self.play_per_gap[1]
            };
            if best.is_some_and(|(least, _)| play(0) >= least) {
                break;
            }
            if profile > MOST_STEPS {
                if !does(MOST_STEPS, hole) {
                    continue;
                }
                let (mut fails, mut enough) = (0, MOST_STEPS);
                while enough - fails > 1 {
                    let middle = (enough + fails) / 2;
                    if does(middle, hole) { enough = middle } else { fails = middle }
                }
                profile = enough;
            }
            while profile > 0 && does(profile - 1, hole) {
                profile -= 1;
            }
            if best.is_none_or(|(least, _)| play(profile) < least) {
                let gaps = Gaps {
                    profile_um: now.profile_um + profile as f64 * steps[0],
                    hole_um: now.hole_um + hole as f64 * steps[1],
                };
                best = Some((play(profile), gaps));
            }
        }
        best.map(|(_, gaps)| gaps)
    }
}
