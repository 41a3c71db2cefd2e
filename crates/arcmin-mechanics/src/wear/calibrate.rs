//! Calibration of the wear coefficient on observed depths or lost motion.

use super::Exposure;
use super::WearCase;
use super::WearError;
use super::coupled::{CoupledOptions, CoupledWear};
use crate::geometry::Relief;
use crate::load::{ShareLoad, lost_motion};
use crate::machine::{Machine, RunningIn, WearCoefficient};
use crate::units::UM;

/// One observation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Running time in s.
    pub time: f64,
    /// Quantity observed and its value.
    pub value: Observed,
}

/// A measured amount of wear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Observed {
    /// Largest depth lost by the flank in m.
    Depth(f64),
    /// Increase of the lost motion since new in rad.
    LostMotionIncrease(f64),
}

/// A fitted coefficient with its residuals.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// Fitted coefficient over time.
    pub exposure: Exposure,
    /// Predicted value for each observation, fitted ones first, in the unit of the observation.
    pub predicted: Vec<f64>,
    /// Root mean square of the relative residuals of the fitted observations.
    pub relative_rms: f64,
}

/// Depth and increase of lost motion against exposure, computed once for every k.
#[derive(Debug, Clone)]
pub struct WearCurve {
    exposures: Vec<f64>,
    depths: Vec<f64>,
    lost_motions: Vec<f64>,
}

/// Crank positions for one value of the lost motion. With ideal joints it repeats for every pin pitch; the
/// number of six is a compromise between speed and ripple, not part of the theory.
pub(super) const LOST_MOTION_POSITIONS: usize = 6;

impl WearCurve {
    /// Integrates the coupled prediction, with a clock if the law depends on time, until `enough` returns true
    /// for (exposure, depth, increase of lost motion). The last is 0 unless it is required.
    ///
    /// # Errors
    /// [`WearError`], `TargetNotReached` after 100 000 updates.
    pub fn until<S: ShareLoad>(
        case: &WearCase,
        meshing: S,
        options: CoupledOptions,
        clock: &Exposure,
        with_lost_motion: bool,
        mut enough: impl FnMut(f64, f64, f64) -> bool,
    ) -> Result<WearCurve, WearError> {
        let mut wear =
            CoupledWear::with(case.clone(), meshing, options.for_curves()).on_clock(clock).at_any_play();
        // Takes as long as the wear itself, so that it is computed only if required.
        let lost = |wear: &mut CoupledWear<S>| match with_lost_motion {
            true => Ok(lost_motion(wear.meshing_mut(), case.rated_torque, LOST_MOTION_POSITIONS)?.radians()),
            false => Ok::<f64, WearError>(0.0),
        };
        let new = lost(&mut wear)?;
        let mut curve = WearCurve { exposures: vec![0.0], depths: vec![0.0], lost_motions: vec![0.0] };
        loop {
            wear.advance_until(f64::MAX, |_| true)?;
            let state = wear.state();
            if state.exposure == f64::MAX {
                // The wear of a law with a threshold has ended before.
                return Err(WearError::TargetNotReached {
                    reached_um: state.flank().deepest().0 / UM,
                    exposure: curve.last(),
                });
            }
            let lost = lost(&mut wear)? - new;
            let state = wear.state();
            curve.exposures.push(state.exposure);
            curve.depths.push(state.flank().deepest().0);
            curve.lost_motions.push(lost);
            if enough(state.exposure, state.flank().deepest().0, lost) {
                return Ok(curve);
            }
            if wear.updates() > 100_000 {
                return Err(WearError::TargetNotReached {
                    reached_um: state.flank().deepest().0 / UM,
                    exposure: state.exposure,
                });
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

/// Fits k by least squares of the relative residuals over all observations; the machine's running-in is not
/// changed. Ideal joints.
///
/// # Errors
/// [`WearError`].
pub fn fit(
    machine: &Machine,
    options: CoupledOptions,
    observations: &[Observation],
) -> Result<Calibration, WearError> {
    fit_with(machine, machine.meshing(&Relief::uniform(0.0)), options, observations)
}

/// [`fit`] with the joints of `meshing`.
///
/// # Errors
/// [`WearError`].
pub fn fit_with<S: ShareLoad + Clone>(
    case: impl Into<WearCase>,
    meshing: S,
    options: CoupledOptions,
    observations: &[Observation],
) -> Result<Calibration, WearError> {
    fit_and_predict(case, meshing, options, observations, &[], None)
}

/// Fits k on some observations and predicts others, which are not used in the fit. With `running_in_duration`
/// (s) the factor of a running-in with that time constant, from 1 to 10⁴, is fitted as well and replaces that
/// of the machine.
///
/// For a law that depends on time itself the curve depends on k: k is iterated until the fit on its own curve
/// reproduces it.
///
/// # Errors
/// [`WearError`].
pub fn fit_and_predict<S: ShareLoad + Clone>(
    case: impl Into<WearCase>,
    meshing: S,
    options: CoupledOptions,
    fitted: &[Observation],
    others: &[Observation],
    running_in_duration: Option<f64>,
) -> Result<Calibration, WearError> {
    let case = case.into();
    let on_clock = |coefficient: f64| {
        let clock = Exposure::new(coefficient, &case.wear);
        fit_on_clock(&case, meshing.clone(), options, fitted, others, running_in_duration, &clock)
    };
    if !case.wear.law.local_rate().depends_on_time() {
        return on_clock(1.0);
    }
    if running_in_duration.is_some() {
        return Err(WearError::RunningInOfTimeLaw);
    }
    // Infinite coefficient, at which no time passes: the law of the new machine.
    let first = on_clock(f64::INFINITY)?.exposure.coefficient;
    let coefficient = self_consistent(first, |k| Ok(on_clock(k)?.exposure.coefficient))?;
    on_clock(coefficient)
}

/// The k with `fitted(k)` = k from a first guess, to 1e-9. `fitted` decreases with k, because with a larger k
/// less time passes in which the law slows down. Regula falsi in the logarithms with halved weight of the
/// retained end (Illinois method).
pub(super) fn self_consistent(
    first: f64,
    mut fitted: impl FnMut(f64) -> Result<f64, WearError>,
) -> Result<f64, WearError> {
    let mut misfit = |logarithm: f64| Ok::<f64, WearError>(fitted(logarithm.exp())?.ln() - logarithm);
    let mut a = first.ln();
    let mut at_a = misfit(a)?;
    let mut b = a + at_a;
    let mut at_b = misfit(b)?;
    for _ in 0..60 {
        if at_b.abs() <= 1e-9 {
            return Ok(b.exp());
        }
        let next = b - at_b * (b - a) / (at_b - at_a);
        if !next.is_finite() {
            break;
        }
        let at_next = misfit(next)?;
        if at_next * at_b < 0.0 {
            (a, at_a) = (b, at_b);
        } else {
            at_a *= 0.5;
        }
        (b, at_b) = (next, at_next);
    }
    Err(WearError::CoefficientNotFound { coefficient: b.exp(), misfit_percent: 100.0 * at_b.abs() })
}

fn fit_on_clock<S: ShareLoad>(
    case: &WearCase,
    meshing: S,
    options: CoupledOptions,
    fitted: &[Observation],
    others: &[Observation],
    running_in_duration: Option<f64>,
    clock: &Exposure,
) -> Result<Calibration, WearError> {
    let own = case.wear.running_in;
    let own = if running_in_duration.is_some() { None } else { own };
    // The exposure at which each observation alone is reached bounds the common clock: a running-in reduces it
    // at later times.
    let latest = fitted.iter().chain(others).map(|o| o.time).fold(0.0, f64::max);
    let equivalent = |time: f64| Exposure::equivalent_time(own, time);
    let mut alone: Vec<Option<f64>> = vec![None; fitted.len()];
    let of_lost_motion = |o: &Observation| matches!(o.value, Observed::LostMotionIncrease(_));
    let lost_motion = fitted.iter().chain(others).any(of_lost_motion);
    let curve = WearCurve::until(case, meshing, options, clock, lost_motion, |exposure, depth, lost| {
        for (found, observation) in alone.iter_mut().zip(fitted) {
            let reached = match observation.value {
                Observed::Depth(target) => depth >= target,
                Observed::LostMotionIncrease(target) => lost >= target,
            };
            if reached && found.is_none() {
                *found = Some(exposure);
            }
        }
        alone.iter().zip(fitted).all(|(found, o)| {
            found.is_some_and(|x| exposure >= 1.01 * x / equivalent(o.time) * equivalent(latest))
        })
    })?;
    let reached: Vec<f64> = alone.into_iter().flatten().collect();
    let running_in_of =
        |factor: f64| running_in_duration.map(|duration| RunningIn { factor, duration }).or(own);
    let mut best = curve.best_coefficient(fitted, &reached, running_in_of(1.0));
    let mut running_in = running_in_of(1.0);
    if running_in_duration.is_some() {
        let misfit =
            |logarithm: f64| curve.best_coefficient(fitted, &reached, running_in_of(logarithm.exp())).1;
        let (steps, top) = (80, 1e4_f64.ln());
        let place = |step: usize| top * step as f64 / steps as f64;
        let nearest = (0..=steps).min_by(|a, b| misfit(place(*a)).total_cmp(&misfit(place(*b)))).unwrap_or(0);
        let logarithm = golden(place(nearest.saturating_sub(1)), place((nearest + 1).min(steps)), misfit);
        running_in = running_in_of(logarithm.exp());
        best = curve.best_coefficient(fitted, &reached, running_in);
    }
    let (coefficient, misfit) = best;
    let predicted = fitted
        .iter()
        .chain(others)
        .map(|o| {
            curve.value(
                o.value,
                (coefficient * Exposure::equivalent_time(running_in, o.time)).min(curve.last()),
            )
        })
        .collect();
    Ok(Calibration { exposure: Exposure { coefficient, running_in }, predicted, relative_rms: misfit.sqrt() })
}

/// Minimum point between a and b by golden section search.
fn golden(mut a: f64, mut b: f64, value: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..100 {
        let (c, d) = (b - 0.618_034 * (b - a), a + 0.618_034 * (b - a));
        if value(c) < value(d) { b = d } else { a = c }
    }
    0.5 * (a + b)
}

impl WearCurve {
    /// k with the smallest mean square of the relative residuals, and that mean square. `reached` holds the
    /// exposures of each observation alone.
    fn best_coefficient(
        &self,
        observations: &[Observation],
        reached: &[f64],
        running_in: Option<RunningIn>,
    ) -> (f64, f64) {
        let times: Vec<f64> =
            observations.iter().map(|o| Exposure::equivalent_time(running_in, o.time)).collect();
        let alone = || reached.iter().zip(&times).map(|(x, time)| x / time);
        let misfit = |k: f64| {
            let residual = |(o, time): (&Observation, &f64)| {
                (self.value(o.value, (k * time).min(self.last())) / o.value.target() - 1.0).powi(2)
            };
            observations.iter().zip(&times).map(residual).sum::<f64>() / observations.len() as f64
        };
        let k =
            golden(0.9 * alone().fold(f64::INFINITY, f64::min), 1.001 * alone().fold(0.0, f64::max), misfit);
        (k, misfit(k))
    }
}

/// Exposure curve of a machine with its coupled coefficient, calibrated on the coupled prediction with the
/// joints of `meshing` if required; zero if the duty causes no wear.
///
/// # Errors
/// [`WearError`] when the prediction fails or the target is out of reach.
pub fn coupled_exposure<S: ShareLoad + Clone>(
    case: impl Into<WearCase>,
    meshing: S,
    options: CoupledOptions,
) -> Result<Exposure, WearError> {
    let case = case.into();
    let observation = match case.wear.coupled {
        WearCoefficient::Given(k) => return Ok(Exposure::new(k, &case.wear)),
        WearCoefficient::Calibrated { time, depth } => Observation { time, value: Observed::Depth(depth) },
        WearCoefficient::CalibratedLostMotion { time, increase } => {
            Observation { time, value: Observed::LostMotionIncrease(increase) }
        }
    };
    match fit_with(case.clone(), meshing, options, &[observation]) {
        Ok(calibration) => Ok(calibration.exposure),
        // A duty without loaded motion causes no wear at any coefficient.
        Err(WearError::NoWear) => Ok(Exposure::new(0.0, &case.wear)),
        Err(error) => Err(error),
    }
}
