//! Free travel of the output with ideal joints and the input locked.

use super::equilibrium::{LARGEST_STEP, MAX_ITERATIONS, Scope};
use super::{FreeTravel, LoadError, Meshing, Preload};
use crate::machine::{CrankAngle, OutputAngle};

/// Step in rad below which the search for the free travel ends.
const LAST_TRAVEL: f64 = 1e-13;
/// Interference below this (m, negative gap) at the nominal position is rounding error.
const OVERLAP_ROUNDING: f64 = -1e-12;
/// Interference in m over which the free travel changes from that of the mechanism just freed to the negative
/// one. Pins near root or tip have almost no lever arm; if these are freed last, the travel jumps to that of
/// the other pins, at an interference near zero where rounding errors and the spline of a worn flank would
/// decide. A hundredth of a micrometre is far below the roughness of any flank.
const FREEING_BAND: f64 = 1e-8;
impl Meshing {
    /// Output error at which the first pin touches when the output turns in `direction` (−1 lag, +1 lead)
    /// from ε = `from`.
    ///
    /// Each step goes to the first contact predicted with gaps, slopes and second derivatives; the gaps are
    /// smooth in ε, so that the convergence is at least quadratic. A bracket prevents cycles between two pins.
    /// `relief` (m) is added to all gaps.
    pub(super) fn first_touch(
        &self,
        nominal_crank: f64,
        direction: f64,
        from: f64,
        relief: f64,
    ) -> Result<f64, LoadError> {
        let k = self.kinematics();
        let bisection = || self.first_touch_by_bisection(nominal_crank, direction, from, relief);
        let half_pitch = std::f64::consts::PI / k.lobe_count;
        // Pins within 0.1° of root or tip have almost no lever arm: they close too slowly to be first, and the
        // rounding error of their gaps would be magnified.
        let least_closing = 1e-2 * k.eccentricity * k.lobe_count;
        let mut error = from;
        let (mut free, mut touching) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut model = self.empty_model();
        for _ in 0..MAX_ITERATIONS {
            self.survey(nominal_crank, error, Scope::Last, &mut model, |_, _| ());
            let Some(step) = model.first_touch(direction, least_closing, relief) else { return bisection() };
            let step = direction * step;
            if (error + direction * step).abs() > half_pitch {
                return bisection();
            }
            if step.abs() < LAST_TRAVEL {
                return Ok(error + direction * step);
            }
            let travel = direction * error;
            if step > 0.0 {
                free = free.max(travel);
            } else {
                touching = touching.min(travel);
            }
            let next = travel + step;
            error = direction * if next > free && next < touching { next } else { 0.5 * (free + touching) };
            if touching - free < 1e-13 {
                return Ok(direction * free);
            }
        }
        bisection()
    }

    /// Output error at which the smallest gap is largest, this gap (m), and there the largest closing rate of
    /// any gap (m/rad) towards lag and lead.
    fn loosest(&self, nominal_crank: f64) -> (f64, f64, [f64; 2]) {
        let half_pitch = std::f64::consts::PI / self.kinematics().lobe_count;
        let mut model = self.empty_model();
        let (mut low, mut high) = (-half_pitch, half_pitch);
        let mut error = 0.0;
        for _ in 0..MAX_ITERATIONS {
            self.survey(nominal_crank, error, Scope::Last, &mut model, |_, _| ());
            if model.smallest().1 > 0.0 {
                low = error;
            } else {
                high = error;
            }
            let next = error + model.loosest(LARGEST_STEP);
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            if (next - error).abs() < LAST_TRAVEL {
                break;
            }
            error = next;
        }
        let closing = [-1.0, 1.0].map(|direction| model.fastest_closing(direction));
        (error, model.smallest().0, closing)
    }

    /// Play of the output at no load with the input locked, in both directions; negative with interference, see
    /// [`FreeTravel`].
    ///
    /// # Errors
    /// [`LoadError::NoContact`] when no pin touches within half a pitch.
    pub fn free_travel(&self, crank_angle: CrankAngle) -> Result<FreeTravel, LoadError> {
        let (mut travel, tight_at) = self.free_angles(crank_angle)?;
        if let Some(place) = tight_at {
            let sharing = self.solve(crank_angle, 0.0, place, Scope::All)?;
            travel.preload = Preload::of(&sharing.discs, self.contacts());
        }
        Ok(travel)
    }

    /// [`Meshing::free_travel`] without the forces of a preload; with interference also the output error at
    /// which it is smallest.
    pub(super) fn free_angles(
        &self,
        crank_angle: CrankAngle,
    ) -> Result<(FreeTravel, Option<f64>), LoadError> {
        let nominal = crank_angle.radians();
        let angles = |lag: f64, lead: f64| FreeTravel {
            lag: OutputAngle::from_radians(lag),
            lead: OutputAngle::from_radians(lead),
            preload: Preload::default(),
        };
        let mut model = self.empty_model();
        self.survey(nominal, 0.0, Scope::Last, &mut model, |_, _| ());
        if model.smallest().0 >= OVERLAP_ROUNDING {
            let lag = self.first_touch(nominal, -1.0, 0.0, 0.0)?;
            return Ok((angles(lag, self.first_touch(nominal, 1.0, 0.0, 0.0)?), None));
        }
        let (place, gap, [to_lag, to_lead]) = self.loosest(nominal);
        let missing = (-gap).max(0.0);
        let tight = (missing / FREEING_BAND).min(1.0);
        let mut ends = [0.0, 0.0];
        if tight < 1.0 {
            for (end, direction) in ends.iter_mut().zip([-1.0, 1.0]) {
                *end = (1.0 - tight) * self.first_touch(nominal, direction, place, missing)?;
            }
        }
        let travel = angles(
            ends[0] + tight * (place + missing / to_lag),
            ends[1] + tight * (place - missing / to_lead),
        );
        Ok((travel, (missing > 0.0).then_some(place)))
    }

    /// The same by increasing steps and bisection on the smallest gap, if the model of the gaps does not
    /// converge.
    fn first_touch_by_bisection(
        &self,
        nominal_crank: f64,
        direction: f64,
        from: f64,
        relief: f64,
    ) -> Result<f64, LoadError> {
        let half_pitch = std::f64::consts::PI / self.kinematics().lobe_count;
        let mut model = self.empty_model();
        let mut touches = |travel: f64| {
            self.survey(nominal_crank, from + direction * travel, Scope::Last, &mut model, |_, _| ());
            model.smallest().0 + relief < 0.0
        };
        let (mut free, mut touching) = (0.0, 0.25 * LARGEST_STEP);
        while !touches(touching) {
            (free, touching) = (touching, 1.25 * touching);
            if free > half_pitch {
                let crank_angle_deg = CrankAngle::from_radians(nominal_crank).degrees();
                return Err(LoadError::NoContact { crank_angle_deg });
            }
        }
        while touching - free > LAST_TRAVEL {
            let middle = 0.5 * (free + touching);
            if touches(middle) { touching = middle } else { free = middle }
        }
        Ok(from + direction * free)
    }
}
