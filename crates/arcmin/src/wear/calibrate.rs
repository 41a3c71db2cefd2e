//! Calibration of the wear coefficient on observed depths or lost motion.

use super::Exposure;
use super::coupled::{CoupledOptions, CoupledWear, WearError};
use crate::load::Meshing;
use crate::machine::{CrankAngle, Machine, OutputAngle, WearCoefficient};
use crate::units::UM;

/// One observation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Running time in s.
    pub time: f64,
    pub value: Observed,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Observed {
    /// Largest depth lost by the flank in m.
    Depth(f64),
    /// Increase of the lost motion since new in rad.
    LostMotionIncrease(f64),
}

/// A fitted coefficient with what it leaves.
#[derive(Debug, Clone)]
pub struct Calibration {
    pub exposure: Exposure,
    /// Predicted value per observation, in the unit of the observation.
    pub predicted: Vec<f64>,
    /// Root mean square of the relative residuals.
    pub relative_rms: f64,
}

/// Lost motion of the contacts alone: output errors at −3 % and +3 % of rated torque, mean over the pattern, in rad.
///
/// Without friction both branches of the hysteresis loop coincide, so the mid-points are the branch itself.
///
/// # Errors
/// [`WearError::Load`].
pub fn contact_lost_motion(meshing: &Meshing, rated_torque: f64, positions: usize) -> Result<OutputAngle, WearError> {
    let period = meshing.kinematics().pattern_period();
    let small = 0.03 * rated_torque.abs();
    let mut sum = 0.0;
    for index in 0..positions {
        let crank = CrankAngle::from_radians(period * index as f64 / positions as f64);
        sum += meshing.load_sharing(crank, -small)?.output_error.radians() - meshing.load_sharing(crank, small)?.output_error.radians();
    }
    Ok(OutputAngle::from_radians(sum / positions as f64))
}

/// Depth and lost-motion increase against exposure, computed once; every k reads from it.
#[derive(Debug, Clone)]
pub struct WearCurve {
    exposures: Vec<f64>,
    depths: Vec<f64>,
    lost_motions: Vec<f64>,
}

const LOST_MOTION_POSITIONS: usize = 6;

impl WearCurve {
    /// Follows the coupled prediction until `enough` says of (exposure, depth, lost-motion increase) that it has gone far enough.
    ///
    /// # Errors
    /// [`WearError`], `TargetNotReached` after 100 000 updates.
    pub fn until(machine: &Machine, options: CoupledOptions, mut enough: impl FnMut(f64, f64, f64) -> bool) -> Result<WearCurve, WearError> {
        let mut wear = CoupledWear::new(machine, options);
        let new = contact_lost_motion(&wear.state().meshing(machine), machine.rated.torque, LOST_MOTION_POSITIONS)?.radians();
        let mut curve = WearCurve { exposures: vec![0.0], depths: vec![0.0], lost_motions: vec![0.0] };
        loop {
            wear.advance_until(f64::MAX, |_| true)?;
            let state = wear.state();
            let lost = contact_lost_motion(&state.meshing(machine), machine.rated.torque, LOST_MOTION_POSITIONS)?.radians() - new;
            curve.exposures.push(state.exposure);
            curve.depths.push(state.flank.deepest().0);
            curve.lost_motions.push(lost);
            if enough(state.exposure, state.flank.deepest().0, lost) {
                return Ok(curve);
            }
            if wear.updates() > 100_000 {
                return Err(WearError::TargetNotReached { reached_um: state.flank.deepest().0 / UM, exposure: state.exposure });
            }
        }
    }

    fn value(&self, observed: Observed, exposure: f64) -> f64 {
        let values = match observed {
            Observed::Depth(_) => &self.depths,
            Observed::LostMotionIncrease(_) => &self.lost_motions,
        };
        let right = self.exposures.partition_point(|x| *x < exposure).clamp(1, self.exposures.len() - 1);
        let t = (exposure - self.exposures[right - 1]) / (self.exposures[right] - self.exposures[right - 1]);
        values[right - 1] + t * (values[right] - values[right - 1])
    }

    fn last(&self) -> f64 {
        self.exposures[self.exposures.len() - 1]
    }
}

impl Observed {
    fn target(self) -> f64 {
        match self {
            Observed::Depth(value) | Observed::LostMotionIncrease(value) => value,
        }
    }
}

/// Fits k by least squares of the relative residuals over all observations; the machine's running-in is kept as given.
///
/// # Errors
/// [`WearError`].
pub fn fit(machine: &Machine, options: CoupledOptions, observations: &[Observation]) -> Result<Calibration, WearError> {
    let running_in = machine.wear.running_in;
    let equivalent: Vec<f64> = observations.iter().map(|o| Exposure::equivalent_time(running_in, o.time)).collect();
    // The smallest k that satisfies each observation alone brackets the common one; follow the curve until all are passed with the
    // largest of them.
    let mut alone: Vec<Option<f64>> = vec![None; observations.len()];
    let latest = equivalent.iter().copied().fold(0.0, f64::max);
    let curve = WearCurve::until(machine, options, |exposure, depth, lost| {
        for ((found, observation), time) in alone.iter_mut().zip(observations).zip(&equivalent) {
            let reached = match observation.value {
                Observed::Depth(target) => depth >= target,
                Observed::LostMotionIncrease(target) => lost >= target,
            };
            if reached && found.is_none() {
                *found = Some(exposure / time);
            }
        }
        alone.iter().all(|found| found.is_some_and(|k| exposure >= 1.01 * k * latest))
    })?;
    let ks = alone.iter().flatten();
    let (low, high) = (0.9 * ks.clone().copied().fold(f64::INFINITY, f64::min), ks.copied().fold(0.0, f64::max));
    let predicted =
        |k: f64| -> Vec<f64> { observations.iter().zip(&equivalent).map(|(o, time)| curve.value(o.value, (k * time).min(curve.last()))).collect() };
    let misfit = |k: f64| {
        predicted(k).iter().zip(observations).map(|(value, o)| (value / o.value.target() - 1.0).powi(2)).sum::<f64>() / observations.len() as f64
    };
    let (mut a, mut b) = (low, high * 1.001);
    for _ in 0..200 {
        let (c, d) = (b - 0.618_034 * (b - a), a + 0.618_034 * (b - a));
        if misfit(c) < misfit(d) { b = d } else { a = c }
    }
    let k = 0.5 * (a + b);
    Ok(Calibration { exposure: Exposure { coefficient: k, running_in }, predicted: predicted(k), relative_rms: misfit(k).sqrt() })
}

pub(super) fn coupled_exposure(machine: &Machine, options: CoupledOptions) -> Result<Exposure, WearError> {
    let observation = match machine.wear.coupled {
        WearCoefficient::Given(k) => return Ok(Exposure::new(k, &machine.wear)),
        WearCoefficient::Calibrated { time, depth } => Observation { time, value: Observed::Depth(depth) },
        WearCoefficient::CalibratedLostMotion { time, increase } => Observation { time, value: Observed::LostMotionIncrease(increase) },
    };
    Ok(fit(machine, options, &[observation])?.exposure)
}
