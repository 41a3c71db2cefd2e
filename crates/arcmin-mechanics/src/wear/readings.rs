//! Evaluation of readings from real machines: wear coefficient, running-in, their confidence bands, and
//! parameters that cannot be distinguished.
//!
//! A reading r of scale s is predicted as p(θ) from the [`Growth`] of the machine; θ consists of the logarithms
//! of the coefficient k and, if fitted, of the factor f and the time constant T of a running-in, k(t) = k (1 +
//! (f − 1) e^(−t/T)). A reading of the lost motion itself is predicted as p = N + g(θ), where N, the lost
//! motion of its machine when new, is fitted with θ ([`Model`]). The fit minimises S(θ, N) = Σ ((p − r)/s)².
//! The confidence region is S ≤ S_min + σ² t²: the profile likelihood, with Student's t for σ² = S_min/(n − p)
//! from the residuals, or the normal quantile for a known reading error (Venzon & Moolgavkar, Appl. Statist. 37
//! (1988) 87). A band is the range of a result on the boundary of that region ([`region`]). A band is open if
//! the region extends to the bounds of a parameter: the readings do not bound it. Correlations are from the
//! inverse of JᵀJ at the minimum.

mod model;
mod region;

use nalgebra::DMatrix;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

pub use self::model::{Measured, Model, New, Reading, Readings, Truth};
use super::calibrate::self_consistent;
use super::{Beyond, Exposure, GrowingDrive, Growth, WearError};
use crate::machine::{RunningIn, Wear};
use crate::progress::Progress;

/// A parameter that can be fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// Steady wear coefficient k, 1/Pa.
    Coefficient,
    /// Ratio of the initial wear coefficient to the steady one.
    Factor,
    /// Time constant of the running-in, s.
    Duration,
}

impl Parameter {
    const ALL: [Parameter; 3] = [Parameter::Coefficient, Parameter::Factor, Parameter::Duration];

    /// Name for texts.
    pub fn name(self) -> &'static str {
        match self {
            Parameter::Coefficient => "wear coefficient",
            Parameter::Factor => "factor of the running-in",
            Parameter::Duration => "duration of the running-in",
        }
    }
}

/// Parameters of the running-in that are fitted in addition to the coefficient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RunningInFit {
    /// None: the running-in of the design is used.
    Kept(Option<RunningIn>),
    /// The factor, for a time constant in s.
    Factor(f64),
    /// Factor and time constant.
    Both,
}

/// A fitted parameter with its band; an end is `None` if the readings do not bound it, both if there are no
/// redundant readings and the reading error is not known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Parameter that was fitted.
    pub parameter: Parameter,
    /// 1/Pa for the coefficient, s for the duration; the factor has no unit.
    pub value: f64,
    /// Lower end of the 95 % band, in the unit of `value`.
    pub low: Option<f64>,
    /// Upper end of the 95 % band, in the unit of `value`.
    pub high: Option<f64>,
}

/// Results of readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Best fit of the coefficient as a function of time.
    pub law: Exposure,
    /// Root mean square of (p − r)/s.
    pub relative_rms: f64,
    /// Fitted parameters with their bands.
    pub estimates: Vec<Estimate>,
    /// Points on the boundary of the confidence region.
    pub ends: Vec<Truth>,
    /// Correlations of two parameters, from −1 to 1.
    pub correlations: Vec<(Parameter, Parameter, f64)>,
    /// Whether bands could be computed.
    pub has_band: bool,
}

/// Confidence level of the bands.
pub const CONFIDENCE: f64 = 0.95;
/// Bounds of the factor of a running-in.
const FACTORS: (f64, f64) = (1.0, 1e4);
/// Correlation above which two parameters count as not distinguishable.
const TIED: f64 = 0.95;

/// Logarithms of coefficient, factor and duration.
type Place = [f64; 3];

struct Search<'a> {
    model: &'a Model<'a>,
    /// Exposures at which each target alone is reached, with its time.
    alone: Vec<(f64, f64)>,
    running_in: RunningInFit,
    /// Bounds of the logarithms.
    bounds: [(f64, f64); 3],
}

/// Fits the chosen parameters. `reading_error`: standard deviation of a reading over its scale, where known.
pub fn fit_readings(model: &Model<'_>, running_in: RunningInFit, reading_error: Option<f64>) -> Fit {
    let search = Search::new(model, running_in);
    let open = search.open();
    let start = search.bounds.map(|(low, high)| 0.5 * (low + high));
    let (best, least) = search.least(start, &open);
    let (known, unknown) = model.counted();
    let spare = known.saturating_sub(unknown + open.len());
    let allowance = match reading_error {
        Some(error) => Some((error * quantile(None)).powi(2)),
        None if spare > 0 => Some(least / spare as f64 * quantile(Some(spare as f64)).powi(2)),
        None => None,
    };
    let mut ends = Vec::new();
    let estimates: Vec<Estimate> = open
        .iter()
        .map(|index| {
            let mut end = |sign: f64| {
                let (place, is_bound) = search.end(best, *index, sign, least + allowance?)?;
                ends.push(Truth::best(search.law(&place)));
                (!is_bound).then(|| place[*index].exp())
            };
            let (low, high) = (end(-1.0), end(1.0));
            Estimate { parameter: Parameter::ALL[*index], value: best[*index].exp(), low, high }
        })
        .collect();
    if let Some(allowance) = allowance {
        ends.extend(search.edge(&best, &open, least + allowance));
    }
    Fit {
        law: search.law(&best),
        relative_rms: (least / known.max(1) as f64).sqrt(),
        estimates,
        ends,
        correlations: search.correlations(&best, &open),
        has_band: allowance.is_some(),
    }
}

/// Two-sided quantile at [`CONFIDENCE`]: of Student's t, or of the normal distribution.
fn quantile(freedom: Option<f64>) -> f64 {
    let at = 0.5 * (1.0 + CONFIDENCE);
    let student = freedom.and_then(|freedom| StudentsT::new(0.0, 1.0, freedom).ok());
    match student {
        Some(student) => student.inverse_cdf(at),
        None => Normal::standard().inverse_cdf(at),
    }
}

impl<'a> Search<'a> {
    fn new(model: &'a Model<'a>, running_in: RunningInFit) -> Search<'a> {
        let alone: Vec<(f64, f64)> = (model.growth.alone().iter())
            .zip(model.readings.targets())
            .map(|(exposure, target)| (*exposure, target.time))
            .collect();
        let times = alone.iter().map(|(_, time)| *time);
        let (first, last) = times.fold((f64::INFINITY, 0.0_f64), |(a, b), t| (a.min(t), b.max(t)));
        let duration = match running_in {
            RunningInFit::Factor(duration) => (duration.ln(), duration.ln()),
            _ => ((0.02 * first).ln(), (10.0 * last).ln()),
        };
        let factor = (FACTORS.0.ln(), FACTORS.1.ln());
        let mut search = Search { model, alone, running_in, bounds: [(0.0, 0.0), factor, duration] };
        // The coefficient lies between those of the single readings; a running-in reduces it.
        let plain = [0.0, 0.0, duration.0];
        let (low, high) = search.coefficients(&plain);
        let lower = if search.open().len() > 1 { FACTORS.1 } else { 1.0 };
        search.bounds[0] = ((low / lower).ln(), high.ln());
        search
    }

    /// Indices of the fitted parameters, the coefficient first.
    fn open(&self) -> Vec<usize> {
        match self.running_in {
            RunningInFit::Kept(_) => vec![0],
            RunningInFit::Factor(_) => vec![0, 1],
            RunningInFit::Both => vec![0, 1, 2],
        }
    }

    fn running_in_at(&self, place: &Place) -> Option<RunningIn> {
        match self.running_in {
            RunningInFit::Kept(own) => own,
            _ => Some(RunningIn { factor: place[1].exp(), duration: place[2].exp() }),
        }
    }

    fn law(&self, place: &Place) -> Exposure {
        Exposure { coefficient: place[0].exp(), running_in: self.running_in_at(place) }
    }

    /// Smallest and largest coefficient of the single readings, with this running-in.
    fn coefficients(&self, place: &Place) -> (f64, f64) {
        let running_in = self.running_in_at(place);
        let (low, high) = (self.alone.iter())
            .map(|(exposure, time)| exposure / Exposure::equivalent_time(running_in, *time))
            .fold((f64::INFINITY, 0.0_f64), |(a, b), k| (a.min(k), b.max(k)));
        // The growth between two readings depends on its distribution in time, and both have errors.
        if self.model.counted().1 > 0 { (0.1 * low, 10.0 * high) } else { (0.9 * low, 1.001 * high) }
    }

    fn residuals(&self, place: &Place) -> Vec<f64> {
        self.model.residuals(&Truth::best(self.law(place)))
    }

    fn misfit(&self, place: &Place) -> f64 {
        self.residuals(place).iter().map(|r| r * r).sum()
    }

    /// Minimum over the `open` parameters, the last of them in the outermost loop: a scan and a golden section
    /// search, so that the result does not depend on a start value.
    fn least(&self, place: Place, open: &[usize]) -> (Place, f64) {
        let Some((outer, inner)) = open.split_last() else { return (place, self.misfit(&place)) };
        let at = |x: f64| {
            let mut place = place;
            place[*outer] = x;
            self.least(place, inner)
        };
        let (low, high) = match outer {
            0 => {
                let (low, high) = self.coefficients(&place);
                (low.ln(), high.ln())
            }
            index => self.bounds[*index],
        };
        let steps = 24;
        let scanned = |step: usize| low + (high - low) * step as f64 / steps as f64;
        let all: Vec<(Place, f64)> = (0..=steps).map(|step| at(scanned(step))).collect();
        let nearest = (0..=steps).min_by(|a, b| all[*a].1.total_cmp(&all[*b].1)).unwrap_or(0);
        let (mut a, mut b) = (scanned(nearest.saturating_sub(1)), scanned((nearest + 1).min(steps)));
        let mut best = all[nearest];
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let (mut c, mut d) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
        let (mut at_c, mut at_d) = (at(c), at(d));
        for _ in 0..42 {
            if at_c.1 < at_d.1 {
                (b, d, at_d) = (d, c, at_c);
                c = b - GOLDEN * (b - a);
                at_c = at(c);
            } else {
                (a, c, at_c) = (c, d, at_d);
                d = a + GOLDEN * (b - a);
                at_d = at(d);
            }
            for candidate in [at_c, at_d] {
                if candidate.1 < best.1 {
                    best = candidate;
                }
            }
        }
        best
    }

    /// Point at which the profile of one parameter exceeds `allowed` on one side, and whether it is a bound of
    /// the parameter; `None` for a coefficient that the readings do not bound.
    fn end(&self, best: Place, index: usize, sign: f64, allowed: f64) -> Option<(Place, bool)> {
        let others: Vec<usize> = self.open().into_iter().filter(|open| *open != index).collect();
        let profile = |x: f64| {
            let mut place = best;
            place[index] = x;
            self.least(place, &others)
        };
        let bound = match (index, sign > 0.0) {
            // There are no data beyond the computed growth.
            (0, true) => {
                let latest = self.alone.iter().map(|(_, time)| *time).fold(0.0, f64::max);
                (self.model.growth.last() / latest).ln()
            }
            (0, false) => self.bounds[0].0.min(best[0]) - 7.0,
            (_, true) => self.bounds[index].1,
            (_, false) => self.bounds[index].0,
        };
        let mut inside = best[index];
        let mut step = 1e-3;
        let mut outside = loop {
            let next = inside + sign * step;
            if sign * (next - bound) >= 0.0 {
                let at_bound = profile(bound);
                if at_bound.1 <= allowed {
                    return (index != 0).then_some((at_bound.0, true));
                }
                break bound;
            }
            if profile(next).1 > allowed {
                break next;
            }
            (inside, step) = (next, 2.0 * step);
        };
        for _ in 0..30 {
            let middle = 0.5 * (inside + outside);
            if profile(middle).1 > allowed { outside = middle } else { inside = middle }
        }
        Some((profile(inside).0, false))
    }

    /// From the inverse of JᵀJ; parameters without effect have a correlation of 1 with all others.
    fn correlations(&self, best: &Place, open: &[usize]) -> Vec<(Parameter, Parameter, f64)> {
        let columns: Vec<Vec<f64>> = open
            .iter()
            .map(|index| {
                let moved = |by: f64| {
                    let mut place = *best;
                    place[*index] += by;
                    self.residuals(&place)
                };
                let step = 0.01;
                moved(step).iter().zip(moved(-step)).map(|(a, b)| (a - b) / (2.0 * step)).collect()
            })
            .collect();
        let normal = DMatrix::from_fn(open.len(), open.len(), |i, j| {
            columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum::<f64>()
        });
        let covariance = normal.try_inverse();
        let mut all = Vec::new();
        for i in 0..open.len() {
            for j in 0..i {
                let correlation = covariance
                    .as_ref()
                    .map(|c| c[(i, j)] / (c[(i, i)] * c[(j, j)]).sqrt())
                    .filter(|correlation| correlation.is_finite())
                    .unwrap_or(1.0);
                all.push((Parameter::ALL[open[j]], Parameter::ALL[open[i]], correlation.clamp(-1.0, 1.0)));
            }
        }
        all
    }
}

impl Fit {
    /// Parameters that the readings cannot determine, one sentence each.
    pub fn untold(&self) -> Vec<String> {
        let mut untold = Vec::new();
        if !self.has_band {
            untold.push(
                "the fit has no confidence band, because there are not more readings than parameters; give more \
                 readings, or their error (reading_error_percent)"
                    .to_owned(),
            );
        } else {
            for estimate in &self.estimates {
                let which = match (estimate.low, estimate.high) {
                    (None, None) => "no bound",
                    (None, _) => "no lower bound",
                    (_, None) => "no upper bound",
                    _ => continue,
                };
                untold.push(format!("the readings set {which} to the {}", estimate.parameter.name()));
            }
        }
        for (a, b, correlation) in self.correlations.iter().filter(|(_, _, c)| c.abs() > TIED) {
            untold.push(format!(
                "{} and {} cannot be distinguished (correlation {correlation:.3}): a change of one compensates the other",
                a.name(),
                b.name()
            ));
        }
        untold
    }

    /// Range of a result over the confidence region; `None` if there is no region, or the coefficient is not
    /// bounded.
    pub fn band(&self, of: impl Fn(&Truth) -> f64) -> Option<(f64, f64)> {
        let coefficient = self.estimates.first()?;
        coefficient.low.and(coefficient.high)?;
        let best = [Truth::best(self.law)];
        let values = self.ends.iter().chain(&best).map(of);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        Some((low, high))
    }
}

/// Parameters to be fitted to readings, and range of the growth beyond them.
#[derive(Debug, Clone)]
pub struct FitPlan {
    /// Parameters of the running-in that are fitted or kept.
    pub running_in: RunningInFit,
    /// Standard deviation of a reading over its scale, where known.
    pub reading_error: Option<f64>,
    /// Growth that is required past the last reading.
    pub beyond: Beyond,
}

/// Computes the growth of a machine and fits the readings to it. For a law that depends on time the growth
/// depends on the coefficient: the coefficient is iterated until the fit with its own growth reproduces it.
///
/// # Errors
/// [`WearError`].
pub fn follow_and_fit<D: GrowingDrive>(
    wear: &Wear,
    mut new_on: impl FnMut(&Exposure) -> D,
    readings: &Readings,
    plan: &FitPlan,
    progress: &dyn Progress,
) -> Result<(Growth, Fit), WearError> {
    let targets = readings.targets();
    let mut on_clock = |coefficient: f64| {
        let mut drive = new_on(&Exposure::new(coefficient, wear));
        let growth = Growth::follow(&mut drive, &targets, &plan.beyond, progress)?;
        let fit = fit_readings(&Model::new(&growth, readings), plan.running_in, plan.reading_error);
        Ok::<_, WearError>((growth, fit))
    };
    if !wear.law.local_rate().depends_on_time() {
        return on_clock(1.0);
    }
    if !matches!(plan.running_in, RunningInFit::Kept(_)) {
        return Err(WearError::RunningInOfTimeLaw);
    }
    // Infinite coefficient, at which no time passes: the law of the new machine.
    let first = on_clock(f64::INFINITY)?.1.law.coefficient;
    let coefficient = self_consistent(first, |k| Ok(on_clock(k)?.1.law.coefficient))?;
    on_clock(coefficient)
}

#[cfg(test)]
mod tests;
