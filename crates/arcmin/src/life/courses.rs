//! Drives with several rings of pins: one course for every ring, advanced together.

use super::{Accuracy, Course, OtherParts, Travel, WornState, accuracy, travel};
use crate::load::ShareLoad;
use crate::machine::OutputAngle;
use crate::progress::Progress;
use crate::wear::{WearCase, WearError};

/// Factors from the results of one ring to the output of the drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputFactors {
    /// Error and play at the output relative to those of this ring: 1 over the ratio of the stages behind it; 0 if
    /// the result of another ring already contains them.
    pub error: f64,
    /// Friction torque at the output relative to that at the disc.
    pub friction: f64,
}

impl OutputFactors {
    /// The only ring of a drive.
    pub const ONE_RING: OutputFactors = OutputFactors { error: 1.0, friction: 1.0 };
}

/// The rings of a drive, for evaluation in states of wear.
#[derive(Debug, Clone)]
pub struct Rings<S> {
    /// Geometry, duty and laws of wear, ring by ring.
    pub cases: Vec<WearCase>,
    /// Load sharing on the present surfaces, ring by ring.
    pub meshings: Vec<S>,
    /// Factors to the output of the drive, ring by ring.
    pub factors: Vec<OutputFactors>,
}

impl<S: ShareLoad> Rings<S> {
    /// Applies the states of all rings.
    pub fn set_states(&mut self, states: &[WornState]) {
        for (ring, meshing) in self.meshings.iter_mut().enumerate() {
            states[ring].apply_to(&self.cases[ring].designed, meshing);
            for other in (0..states.len()).filter(|other| *other != ring) {
                states[other].surfaces.apply_to_other_ring(other, &self.cases[other].designed, meshing);
            }
        }
    }

    /// Loads and depths of every ring; errors and travel are those of the drive.
    ///
    /// # Errors
    /// [`WearError::Load`] where no balance is found.
    pub fn evaluate(
        &mut self,
        states: &[WornState],
        crank_positions: usize,
        with_travel: bool,
    ) -> Result<Vec<(Accuracy, Option<Travel>)>, WearError> {
        self.set_states(states);
        let mut found = Vec::with_capacity(states.len());
        for ((case, meshing), state) in self.cases.iter().zip(&mut self.meshings).zip(states) {
            let flank = state.surfaces.flank();
            let accuracy = accuracy(case, meshing, flank, state.hours, crank_positions)?;
            let travel = with_travel.then(|| travel(case, meshing, crank_positions)).transpose()?;
            found.push((accuracy, travel));
        }
        self.sum_over_rings(&mut found);
        Ok(found)
    }

    /// Errors of rings in series add up; so do their peaks, since their periods have no common multiple of practical
    /// length.
    fn sum_over_rings(&self, found: &mut [(Accuracy, Option<Travel>)]) {
        let sum = |of: &dyn Fn(&Accuracy, &OutputFactors) -> f64| {
            OutputAngle::from_radians(
                found.iter().zip(&self.factors).map(|((a, _), factors)| of(a, factors)).sum(),
            )
        };
        let error = sum(&|a, factors| factors.error * a.loaded_error.radians());
        let peak_to_peak = sum(&|a, factors| factors.error.abs() * a.loaded_peak_to_peak.radians());
        let travels: Option<Vec<Travel>> = found.iter().map(|(_, travel)| *travel).collect();
        let whole = travels.map(|travels| {
            let each = || travels.iter().zip(&self.factors);
            let sum = |of: &dyn Fn(&Travel, &OutputFactors) -> f64| {
                OutputAngle::from_radians(each().map(|(travel, factors)| of(travel, factors)).sum())
            };
            Travel {
                play: sum(&|t, factors| factors.error.abs() * t.play.radians()),
                free_travel: sum(&|t, factors| factors.error.abs() * t.free_travel.radians()),
                no_load_error: sum(&|t, factors| factors.error * t.no_load_error.radians()),
                preload: travels.iter().map(|travel| travel.preload).fold(0.0, f64::max),
                preload_friction: each()
                    .map(|(travel, factors)| factors.friction * travel.preload_friction)
                    .sum(),
            }
        });
        for (accuracy, travel) in found {
            accuracy.loaded_error = error;
            accuracy.loaded_peak_to_peak = peak_to_peak;
            *travel = whole;
        }
    }
}

/// A drive at some running hours, ring by ring. Rings that share one equilibrium exchange their surfaces at the ends
/// of the intervals.
pub struct Courses<S: ShareLoad, P: OtherParts> {
    rings: Vec<Course<S, P>>,
    factors: Vec<OutputFactors>,
    /// Limit in rad.
    lost_motion: f64,
    /// The ring whose wear has run away.
    ran_away: usize,
}

impl<S: ShareLoad, P: OtherParts> From<Course<S, P>> for Courses<S, P> {
    fn from(course: Course<S, P>) -> Courses<S, P> {
        let lost_motion = course.case().lost_motion;
        Courses { rings: vec![course], factors: vec![OutputFactors::ONE_RING], lost_motion, ran_away: 0 }
    }
}

impl<S: ShareLoad, P: OtherParts> Courses<S, P> {
    /// New rings, each with its factors to the output; `lost_motion` is the limit of the drive in rad.
    pub fn new(rings: Vec<(Course<S, P>, OutputFactors)>, lost_motion: f64) -> Courses<S, P> {
        let (rings, factors) = rings.into_iter().unzip();
        Courses { rings, factors, lost_motion, ran_away: 0 }
    }

    /// See [`CoupledWear::allow_waves`](crate::wear::CoupledWear::allow_waves).
    pub(super) fn allow_waves(&mut self) {
        self.rings.iter_mut().for_each(Course::allow_waves);
    }

    /// Ring by ring.
    pub fn rings(&self) -> &[Course<S, P>] {
        &self.rings
    }

    /// Limit of the lost motion of the drive in rad.
    pub fn lost_motion(&self) -> f64 {
        self.lost_motion
    }

    /// The ring whose wear has run away, if any.
    pub fn ran_away(&self) -> usize {
        self.ran_away
    }

    /// Planned service life in h.
    pub fn service_hours(&self) -> f64 {
        self.rings[0].service_hours()
    }

    /// The present state of the drive, ring by ring.
    pub fn states(&self) -> Vec<WornState> {
        self.rings.iter().map(Course::state).collect()
    }

    /// Goes on to the given hours.
    ///
    /// # Errors
    /// As [`Course::advance_to`].
    pub fn advance_to(&mut self, hours: f64, progress: &dyn Progress) -> Result<(), WearError> {
        while self.rings[0].hours() < hours {
            let next = self.rings[0].next_interval(hours);
            for (number, ring) in self.rings.iter_mut().enumerate() {
                ring.advance_to(next, progress).inspect_err(|_| self.ran_away = number)?;
            }
            self.exchange();
        }
        Ok(())
    }

    fn exchange(&mut self) {
        for other in 0..self.rings.len() {
            let (designed, state) = (self.rings[other].case().designed.clone(), self.rings[other].state());
            let rings = self.rings.iter_mut().enumerate().filter(|(number, _)| *number != other);
            rings.for_each(|(_, ring)| ring.set_other_surfaces(other, &designed, &state.surfaces));
        }
    }

    /// Intermediate states after these hours of a drive whose wear has run away; other rings in their last state.
    pub fn intermediate_states_after(&self, hours: f64) -> Vec<Vec<WornState>> {
        let lost = self.rings[self.ran_away].intermediate_states_after(hours);
        let all = |state: &WornState| {
            let others = self.states().into_iter().map(|other| WornState { hours: state.hours, ..other });
            let mut states: Vec<WornState> = others.collect();
            states[self.ran_away] = state.clone();
            states
        };
        lost.map(all).collect()
    }
}

impl<S: ShareLoad + Clone, P: OtherParts> Courses<S, P> {
    /// The rings in their present state, for evaluation.
    pub fn for_evaluation(&mut self) -> Rings<S> {
        Rings {
            cases: self.rings.iter().map(|ring| ring.case().clone()).collect(),
            meshings: self.rings.iter_mut().map(|ring| ring.meshing().clone()).collect(),
            factors: self.factors.clone(),
        }
    }
}
