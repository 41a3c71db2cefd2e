//! Growth of the wear of a drive of eccentrics for a fit of its coefficient: flanks and pins of all rings, output pins and
//! holes, side by side in exposure.

use super::{OtherParts, Rings, StageFollower, WholeDrive, WornState};
use crate::dynamics::StageMeshing;
use crate::wear::{CoupledOptions, CoupledWear, Exposure, GrowingDrive, WearError};

/// One ring with the other wearing parts of its stage.
struct GrowingRing {
    wear: CoupledWear<StageMeshing>,
    parts: StageFollower,
}

/// All rings of a drive. Each step is one update of the flank of the measured ring; the other rings advance to the
/// same exposure. Then the rings exchange their surfaces, as in [`Courses`](super::Courses) at the ends of the
/// intervals.
///
/// Eccentric bearings have their own coefficient and wear by time; here they remain as new.
pub struct GrowingRings {
    rings: Vec<GrowingRing>,
    whole: Rings<StageMeshing>,
    leader: usize,
    /// The ring that advances.
    advancing: usize,
    exposure: f64,
}

impl GrowingRings {
    /// New rings with the other wearing parts of each stage, with a clock if the law depends on time. The depth is
    /// that of ring `leader`.
    pub fn new(
        whole: Rings<StageMeshing>,
        parts: Vec<StageFollower>,
        leader: usize,
        clock: &Exposure,
    ) -> GrowingRings {
        let options = CoupledOptions::default().for_curves();
        let rings = whole.cases.iter().zip(&whole.meshings).zip(parts).map(|((case, meshing), parts)| {
            let wear = CoupledWear::with(case.clone(), meshing.clone(), options).on_clock(clock);
            GrowingRing { wear, parts }
        });
        GrowingRings { rings: rings.collect(), whole, leader, advancing: leader, exposure: 0.0 }
    }

    fn states(&self) -> Vec<WornState> {
        let state = |ring: &GrowingRing| WornState {
            hours: 0.0,
            surfaces: ring.wear.state().clone(),
            part_wear: ring.parts.wear(),
        };
        self.rings.iter().map(state).collect()
    }

    fn exchange(&mut self) {
        for other in 0..self.rings.len() {
            let ring = &self.rings[other].wear;
            let (designed, surfaces) = (ring.case().designed.clone(), ring.state().clone());
            let rings = self.rings.iter_mut().enumerate().filter(|(number, _)| *number != other);
            for (_, ring) in rings {
                ring.wear.set_other_ring(other, &designed, &surfaces);
                ring.parts.set_other_surfaces(other, &designed, &surfaces);
            }
        }
    }
}

impl GrowingDrive for GrowingRings {
    fn step(&mut self) -> Result<(), WearError> {
        let from = self.exposure;
        self.advancing = self.leader;
        self.rings[self.leader].wear.advance_until(f64::MAX, |_| true)?;
        self.exposure = self.rings[self.leader].wear.state().exposure;
        if self.exposure == f64::MAX {
            return Ok(());
        }
        let (to, leader) = (self.exposure, self.leader);
        for (number, ring) in self.rings.iter_mut().enumerate() {
            if number != leader {
                self.advancing = number;
                ring.wear.advance_to(to)?;
            }
            if ring.parts.wear_at_all() {
                // With a wear coefficient of 1 the other parts use exposures as times.
                ring.parts.set_surfaces(ring.wear.state());
                ring.parts.advance(to - from)?;
                ring.wear.set_part_wear(&ring.parts.wear());
            }
        }
        self.exchange();
        Ok(())
    }

    fn exposure(&self) -> f64 {
        self.exposure
    }

    fn depth(&self) -> f64 {
        self.rings[self.leader].wear.state().flank().deepest().0
    }

    fn lost_motion(&mut self) -> Result<f64, WearError> {
        let states = self.states();
        self.whole.lost_motion(&states)
    }

    fn updates(&self) -> usize {
        self.rings[self.leader].wear.updates()
    }

    fn ran_away(&self) -> String {
        match self.rings.len() {
            1 => String::new(),
            count => format!(" of ring {} of {count} from the input", self.advancing + 1),
        }
    }
}
