//! The integrator of all wear: an explicit method of second order, stabilised where flanks are stiff, with one
//! estimate of its error.
//!
//! A step of h from depths w₀ takes s rates f_j = f(x + c_j h, w_j),
//!
//! w_j = w₀ + h Σ_{i<j} a_ji f_i,  a_ji = ω (2i + 1)(H_j − H_i),  ω = 4/(s² + s − 2),  c_j = ω j (j + 1)/2,
//! w = w₀ + β (w_s − w₀),  β = (s² + s − 2)/(2 (s² + s)),  H_j = 1 + 1/2 + … + 1/j.
//!
//! On f = −λ w each w_j is w₀ times the Legendre polynomial P_j(1 − ω λ h), and w is w₀ times the stability
//! polynomial of the method RKL2 (Meyer, Balsara and Aslam, J. Comput. Phys. 257 (2014) 594): second order,
//! stable up to λ h = (s² + s − 2)/2 and damped all the way there. Two rates are Heun's method. Unlike the
//! recursion of RKL2 this form has positive weights alone (by Christoffel and Darboux), so no rate, however it
//! differs from the others, brings metal back.

use super::WearError;

/// What wears.
pub(super) trait Wearing {
    /// Rates of all depths per unit of exposure. They are means over many positions of the machine; `sample`
    /// numbers the selection of them that is looked at.
    ///
    /// # Errors
    /// [`WearError`] where they are not found.
    fn rates(&mut self, exposure: f64, depths: &[f64], sample: usize) -> Result<Vec<f64>, WearError>;

    /// How much changes of the depths matter where these are the rates, in m.
    fn size(&self, changes: &[f64], rates: &[f64]) -> f64;

    /// Error of one step that is allowed where depths are those, in the measure of `size`.
    fn tolerance(&self, depths: &[f64]) -> f64;
}

/// Next step over the longest one that is expected to hold: a step of the usual size is then hardly ever repeated.
const SAFETY: f64 = 0.9;
/// A step is at most so many times as long as the one before, and not shorter than its inverse: one estimate of an
/// error is not trusted beyond.
const CHANGE: f64 = 5.0;
/// The estimate of the largest λ costs one rate at least, so it is made once in so many steps.
const STEPS_PER_LOOK: usize = 10;
/// The estimate of the largest λ comes from below and ends where it rises by less than so many times.
const STILL_RISING: f64 = 1.2;
/// Over the estimate of the largest λ for the number of rates: a step of two rates leaves waves as they are at the end
/// of its reach and halves them in the middle, and λ differs by half from one selection of positions to another.
const STIFFNESS_SAFETY: f64 = 3.0;
/// Rates of one step at most, a step 54 times as long as two rates would allow: they all are in memory.
const MOST_RATES: usize = 10;

/// Depths with their rates.
#[derive(Debug, Clone)]
struct Point {
    exposure: f64,
    depths: Vec<f64>,
    /// Empty before the first step.
    rates: Vec<f64>,
    /// The selection of positions that they were found at.
    sample: usize,
}

/// The running integration.
#[derive(Debug)]
pub(super) struct Integrator {
    /// Where the last step began.
    before: Option<Point>,
    now: Point,
    /// Exposure of the next step.
    step: Option<f64>,
    /// Error of the last step over the tolerance.
    error: f64,
    steps: usize,
    /// Rates asked for.
    samples: usize,
    /// The largest λ, and the changes of the depths that it belongs to.
    stiffness: f64,
    stiffest: Vec<f64>,
}

impl Integrator {
    pub fn new(count: usize) -> Integrator {
        let now = Point { exposure: 0.0, depths: vec![0.0; count], rates: Vec::new(), sample: 0 };
        Integrator {
            before: None,
            now,
            step: None,
            error: 1.0,
            steps: 0,
            samples: 0,
            stiffness: 0.0,
            stiffest: Vec::new(),
        }
    }

    /// Furthest exposure.
    pub fn exposure(&self) -> f64 {
        self.now.exposure
    }

    /// Depths there.
    pub fn depths(&self) -> &[f64] {
        &self.now.depths
    }

    /// Exposure before the last step.
    pub fn exposure_before(&self) -> f64 {
        self.before.as_ref().map_or(self.now.exposure, |before| before.exposure)
    }

    /// Nothing wears until there; what does from then on is asked anew.
    pub fn rest_until(&mut self, exposure: f64) {
        self.now.exposure = exposure;
        self.now.rates.clear();
        self.before = None;
    }

    pub fn steps(&self) -> usize {
        self.steps
    }

    /// One step; `false` where nothing wears.
    ///
    /// A step is as long as its error lets it be: its difference from Euler's method, whose error that is. Rates
    /// within a step are found at other positions than the first one, so the difference holds what a selection of
    /// positions leaves as well. The next step is chosen by a PI control (Gustafsson, ACM Trans.
    /// Math. Softw. 17 (1991) 533) for an error of second order.
    ///
    /// # Errors
    /// [`WearError`] where rates are not found, not even after a step that takes off less than the tolerance.
    pub fn advance(&mut self, wearing: &mut impl Wearing) -> Result<bool, WearError> {
        if self.now.rates.is_empty() {
            self.now.rates = self.ask(wearing, self.now.exposure, &self.now.depths.clone())?;
        }
        let largest = self.now.rates.iter().copied().fold(0.0, f64::max);
        if !(largest > 0.0) {
            return Ok(false);
        }
        let tolerance = wearing.tolerance(&self.now.depths);
        // The first step takes off as much as may be in error.
        let mut step = self.step.unwrap_or(tolerance / largest);
        let mut repeated = false;
        loop {
            if repeated || (self.steps > 0 && self.steps.is_multiple_of(STEPS_PER_LOOK)) {
                self.look_for_stiffness(wearing, tolerance);
            }
            if self.stiffness > 0.0 {
                step = step.min(reach(MOST_RATES) / (STILL_RISING * self.stiffness));
            }
            let error = match self.attempt(wearing, step) {
                Ok((end, changes)) => {
                    if self.stiffest.is_empty() {
                        // Rough as the selections differ.
                        self.stiffest.clone_from(&changes);
                    }
                    let error = wearing.size(&changes, &self.now.rates) / tolerance;
                    if !(error > 1.0) {
                        self.accept(end, step, error, repeated);
                        return Ok(true);
                    }
                    error
                }
                // There is no load sharing beyond.
                Err(WearError::Load(_)) if step * largest > tolerance => f64::INFINITY,
                Err(error) => return Err(error),
            };
            step *= (SAFETY / error.sqrt()).max(1.0 / CHANGE);
            repeated = true;
        }
    }

    fn accept(&mut self, end: Point, step: f64, error: f64, repeated: bool) {
        let error = error.max(f64::EPSILON);
        let longer = SAFETY * error.powf(-0.35) * self.error.powf(0.2);
        let most = if repeated { 1.0 } else { CHANGE };
        self.step = Some(step * longer.clamp(1.0 / CHANGE, most));
        self.error = error;
        self.steps += 1;
        self.before = Some(std::mem::replace(&mut self.now, end));
    }

    fn ask(
        &mut self,
        wearing: &mut impl Wearing,
        exposure: f64,
        depths: &[f64],
    ) -> Result<Vec<f64>, WearError> {
        self.samples += 1;
        wearing.rates(exposure, depths, self.samples - 1)
    }

    /// The end of a step with its rates, and the estimate of its error.
    fn attempt(&mut self, wearing: &mut impl Wearing, step: f64) -> Result<(Point, Vec<f64>), WearError> {
        let count = rates_of_step(STIFFNESS_SAFETY * self.stiffness * step);
        let s = (count * (count + 1)) as f64;
        let omega = 4.0 / (s - 2.0);
        let harmonic = |n: usize| (1..=n).map(|k| 1.0 / k as f64).sum::<f64>();
        let (start, mut rates) = (self.now.exposure, vec![std::mem::take(&mut self.now.rates)]);
        // w_j − w₀.
        let gone = |rates: &[Vec<f64>], j: usize| {
            let weight = |i: usize| step * omega * (2 * i + 1) as f64 * (harmonic(j) - harmonic(i));
            let weighted: Vec<(&Vec<f64>, f64)> =
                rates.iter().enumerate().map(|(i, rates)| (rates, weight(i))).collect();
            let at = |place: usize| weighted.iter().map(|(rates, weight)| weight * rates[place]).sum::<f64>();
            (0..rates[0].len()).map(at).collect::<Vec<f64>>()
        };
        let mut ends = || -> Result<(Point, Vec<f64>), WearError> {
            for j in 1..count {
                let inner = sum(&self.now.depths, &gone(&rates, j), 1.0);
                let exposure = start + step * omega * (j * (j + 1)) as f64 / 2.0;
                self.samples += 1;
                rates.push(wearing.rates(exposure, &inner, self.samples - 1)?);
            }
            let mut removed = gone(&rates, count);
            removed.iter_mut().for_each(|removed| *removed *= (s - 2.0) / (2.0 * s));
            let depths = sum(&self.now.depths, &removed, 1.0);
            self.samples += 1;
            let sample = self.samples - 1;
            let last = wearing.rates(start + step, &depths, sample)?;
            Ok((Point { exposure: start + step, depths, rates: last, sample }, removed))
        };
        let found = ends();
        self.now.rates = rates.swap_remove(0);
        let (end, removed) = found?;
        let changes =
            removed.iter().zip(&self.now.rates).map(|(removed, rate)| removed - step * rate).collect();
        Ok((end, changes))
    }

    /// The largest λ by the power method, on depths less by the tolerance, at the positions of the present rates:
    /// contacts that have just lost their force take it up again there, which they do not on larger depths. Where there
    /// is no load sharing, λ stays as it was.
    fn look_for_stiffness(&mut self, wearing: &mut impl Wearing, tolerance: f64) {
        let length = |changes: &[f64]| changes.iter().map(|change| change * change).sum::<f64>().sqrt();
        let now = &self.now;
        if length(&self.stiffest) == 0.0 {
            self.stiffest.clone_from(&now.rates);
        }
        let mut known = 0.0;
        loop {
            let largest = self.stiffest.iter().fold(0.0_f64, |most, change| most.max(change.abs()));
            if largest == 0.0 {
                return;
            }
            let share = tolerance / largest;
            let moved = sum(&now.depths, &self.stiffest, -share);
            let Ok(rates) = wearing.rates(now.exposure, &moved, now.sample) else { return };
            let changes: Vec<f64> = rates.iter().zip(&now.rates).map(|(there, here)| there - here).collect();
            self.stiffness = length(&changes) / (share * length(&self.stiffest));
            self.stiffest = changes;
            if self.stiffness <= STILL_RISING * known {
                self.stiffness = self.stiffness.max(known);
                return;
            }
            known = self.stiffness;
        }
    }

    /// Depths at an exposure within the last step: cubic with the rates at both ends for slopes, which are limited
    /// so that no metal comes back (Fritsch and Carlson, SIAM J. Numer. Anal. 17 (1980) 238).
    pub fn at(&self, exposure: f64) -> Vec<f64> {
        let Some(before) = self.before.as_ref().filter(|_| exposure < self.now.exposure) else {
            return self.now.depths.clone();
        };
        let step = self.now.exposure - before.exposure;
        let t = (exposure - before.exposure) / step;
        let rates = before.rates.iter().zip(&self.now.rates);
        let between = |((from, to), (first, last)): ((&f64, &f64), (&f64, &f64))| {
            let gained = to - from;
            let slope = |rate: &f64| (step * rate).min(3.0 * gained);
            from + t * t * (3.0 - 2.0 * t) * gained
                + t * (1.0 - t) * ((1.0 - t) * slope(first) - t * slope(last))
        };
        before.depths.iter().zip(&self.now.depths).zip(rates).map(between).collect()
    }
}

/// The fewest rates by which a step with the largest λ h = `stiffness` is stable.
fn rates_of_step(stiffness: f64) -> usize {
    (2..MOST_RATES).find(|count| reach(*count) >= stiffness).unwrap_or(MOST_RATES)
}

/// The largest λ h at which a step of so many rates is stable.
fn reach(count: usize) -> f64 {
    (count * count + count - 2) as f64 / 2.0
}

fn sum(depths: &[f64], changes: &[f64], share: f64) -> Vec<f64> {
    depths.iter().zip(changes).map(|(depth, change)| depth + share * change).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Depths with the rates `rates(exposure, depths, sample)`, all of them as important.
    struct Law<F> {
        rates: F,
        tolerance: f64,
        asked: usize,
    }

    impl<F: FnMut(f64, &[f64], usize) -> Vec<f64>> Wearing for Law<F> {
        fn rates(&mut self, exposure: f64, depths: &[f64], sample: usize) -> Result<Vec<f64>, WearError> {
            self.asked += 1;
            Ok((self.rates)(exposure, depths, sample))
        }

        fn size(&self, changes: &[f64], _: &[f64]) -> f64 {
            changes.iter().fold(0.0, |most, change| most.max(change.abs()))
        }

        fn tolerance(&self, _: &[f64]) -> f64 {
            self.tolerance
        }
    }

    /// Depths at an exposure, and how many steps and rates they took.
    fn worn(
        count: usize,
        to: f64,
        tolerance: f64,
        rates: impl FnMut(f64, &[f64], usize) -> Vec<f64>,
    ) -> (Vec<f64>, usize, usize) {
        let mut law = Law { rates, tolerance, asked: 0 };
        let mut integrator = Integrator::new(count);
        while integrator.exposure() < to {
            assert!(integrator.advance(&mut law).unwrap());
        }
        (integrator.at(to), integrator.steps(), law.asked)
    }

    /// A constant rate is followed exactly, in steps that grow without bound.
    #[test]
    fn a_constant_rate_is_exact() {
        let (depths, steps, _) = worn(2, 1e6, 1e-3, |_, _, _| vec![1.0, 0.5]);
        assert!((depths[0] / 1e6 - 1.0).abs() < 1e-12 && (depths[1] / 0.5e6 - 1.0).abs() < 1e-12);
        assert!(steps < 20, "{steps}");
    }

    /// A pressure that wear takes off, p = e^(−x) and w = 1 − e^(−x), and one that wears in from a law of time: the
    /// error is in proportion to the tolerance over three decades, that of the depths between the steps as well.
    #[test]
    fn the_error_follows_the_tolerance() {
        for (name, rates, depth) in [
            (
                "run-in",
                (|_, w: &[f64], _| vec![1.0 - w[0]]) as fn(f64, &[f64], usize) -> Vec<f64>,
                (|x: f64| 1.0 - (-x).exp()) as fn(f64) -> f64,
            ),
            ("time", |x, _, _| vec![(-x).exp()], |x| 1.0 - (-x).exp()),
            ("depth", |_, w, _| vec![(-w[0]).exp()], |x| x.ln_1p()),
        ] {
            let error = |tolerance: f64| {
                let off = |x: f64| (worn(1, x, tolerance, rates).0[0] - depth(x)).abs();
                (1..=40).map(|i| off(0.1 * f64::from(i))).fold(0.0, f64::max)
            };
            let errors = [1e-3, 1e-4, 1e-5, 1e-6].map(error);
            let order = (errors[0] / errors[3]).log10() / 3.0;
            println!("{name} {errors:?} {order}");
            assert!((0.9..1.1).contains(&order), "{name}: {errors:?}");
        }
    }

    /// Pressures that wear off up to ten thousand times faster than what they follow: Heun's method alone would take 10⁴
    /// steps.
    #[test]
    fn stiff_flanks_wear_in_long_steps() {
        let speeds = [1.0, 100.0, 1e3, 1e4];
        let (depths, steps, asked) = worn(4, 2.0, 1e-3, |x, w, _| {
            speeds.iter().zip(w).map(|(speed, w)| 1.0 + speed * (x - w)).collect()
        });
        for (speed, depth) in speeds.iter().zip(&depths) {
            assert!((depth - 2.0).abs() < 1e-3, "{speed}: {depth}");
        }
        assert!(asked < 6000, "{steps} {asked}");
    }

    /// No metal comes back, whatever the rates are and wherever it is read.
    #[test]
    fn no_metal_comes_back() {
        let mut integrator = Integrator::new(3);
        let rates = |x: f64, w: &[f64], sample: usize| {
            let wave = 1.0 + (7.0 * x + sample as f64 * 2.4).sin();
            vec![wave, (1.0 - 300.0 * (w[1] - x)).max(0.0), if sample.is_multiple_of(3) { 1.0 } else { 0.0 }]
        };
        let mut law = Law { rates, tolerance: 0.05, asked: 0 };
        let mut last = vec![0.0; 3];
        for _ in 0..200 {
            let before = integrator.exposure();
            integrator.advance(&mut law).unwrap();
            for part in 1..=8 {
                let share = f64::from(part) / 8.0;
                let depths = integrator.at(before + share * (integrator.exposure() - before));
                assert!(
                    depths.iter().zip(&last).all(|(now, last)| now >= &(last - 1e-15)),
                    "{depths:?} {last:?}"
                );
                last = depths;
            }
        }
    }

    /// Rates of selections that scatter about their mean: the estimate sees it, and the steps are as short as it asks
    /// for.
    #[test]
    fn the_scatter_of_selections_bounds_the_steps() {
        let scatter = |size: f64| {
            let rates = move |_: f64, _: &[f64], sample: usize| {
                vec![1.0 + size * ((sample as f64 * 0.618_034).fract() - 0.5)]
            };
            let (depths, steps, _) = worn(1, 10.0, 1e-2, rates);
            assert!((depths[0] - 10.0).abs() < 0.05, "{depths:?}");
            steps
        };
        let (little, much) = (scatter(0.1), scatter(1.0));
        assert!(much > 5 * little && much < 20 * little, "{little} {much}");
    }

    /// The weights of a step are positive, add up to the step, and agree with the exact solution to second order.
    #[test]
    fn a_step_is_of_second_order_with_any_number_of_rates() {
        for count in 2..=MOST_RATES {
            let error = |step: f64| {
                let mut law = Law { rates: |_, w: &[f64], _| vec![1.0 - w[0]], tolerance: 1.0, asked: 0 };
                let mut integrator = Integrator::new(1);
                integrator.now.rates = vec![1.0];
                // What asks for so many rates.
                integrator.stiffness = 0.999 * reach(count) / (STIFFNESS_SAFETY * step);
                let (end, _) = integrator.attempt(&mut law, step).unwrap();
                assert_eq!(law.asked, count);
                end.depths[0] - (1.0 - (-step).exp())
            };
            let order = (error(0.02) / error(0.01)).log2();
            assert!((order - 3.0).abs() < 0.05, "{count}: {order}");
        }
    }
}
