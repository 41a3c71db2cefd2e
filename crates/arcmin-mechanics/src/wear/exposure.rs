use crate::machine::{RunningIn, Wear};

/// The wear coefficient integrated over time, x(t) = ∫ k dt in s/Pa.
///
/// k(t) = k (1 + (f − 1) e^(−t/T)) during running-in. If the wear law does not depend on time itself, depth
/// depends on time through x alone, so that one computation in x is valid for every k. For other laws x is
/// still the variable of integration, and the rate uses the corresponding time ([`Exposure::time_at`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Steady coefficient k in 1/Pa.
    pub coefficient: f64,
    /// Faster wear at the beginning; `None` for a constant coefficient.
    pub running_in: Option<RunningIn>,
}

impl Exposure {
    /// A steady coefficient (1/Pa) with the running-in of the design.
    pub fn new(coefficient: f64, wear: &Wear) -> Exposure {
        Exposure { coefficient, running_in: wear.running_in }
    }

    /// x/k: the running time at the steady coefficient that causes the same wear, in s.
    pub fn equivalent_time(running_in: Option<RunningIn>, time: f64) -> f64 {
        match running_in {
            Some(RunningIn { factor, duration }) => {
                time + (factor - 1.0) * duration * -(-time / duration).exp_m1()
            }
            None => time,
        }
    }

    /// x(t) in s/Pa at the time t in s.
    pub fn at(&self, time: f64) -> f64 {
        self.coefficient * Exposure::equivalent_time(self.running_in, time)
    }

    /// Time in s at which the exposure x (s/Pa) is reached, 0 for an infinite coefficient. The inverse of
    /// [`Exposure::at`]; with running-in by bisection to rounding.
    pub fn time_at(&self, exposure: f64) -> f64 {
        if self.coefficient == f64::INFINITY {
            return 0.0;
        }
        let target = exposure / self.coefficient;
        let Some(RunningIn { factor, duration }) = self.running_in else { return target };
        let lead = ((factor - 1.0) * duration).max(0.0);
        let (mut low, mut high) = ((target - lead).max(0.0), target.max(target - (factor - 1.0) * duration));
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if Exposure::equivalent_time(self.running_in, middle) < target {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_and_exposure_are_inverse() {
        for factor in [0.5, 1.0, 8.0] {
            let exposure =
                Exposure { coefficient: 1e-18, running_in: Some(RunningIn { factor, duration: 1e6 }) };
            for time in [0.0, 1e4, 1e6, 3e7] {
                assert!(
                    (exposure.time_at(exposure.at(time)) - time).abs() <= 1e-6 * (time + 1.0),
                    "{factor} {time}"
                );
            }
        }
    }

    #[test]
    fn exposure_is_the_integral_of_the_coefficient() {
        let exposure =
            Exposure { coefficient: 1e-18, running_in: Some(RunningIn { factor: 8.0, duration: 1e6 }) };
        let steps = 10_000;
        let sum: f64 =
            (0..steps).map(|i| 1e-18 * (1.0 + 7.0 * (-(i as f64 + 0.5) * 200.0 / 1e6).exp()) * 200.0).sum();
        assert!((sum / exposure.at(200.0 * steps as f64) - 1.0).abs() < 1e-8);
    }
}
