/// Broyden's updates of a factorised matrix: the corrections since it was formed contain the actual derivative
/// of the residual along them.
///
/// With the inverse H₀ ≈ J⁻¹ and z = H₀ r for the present residual r, the next correction by Broyden's "good"
/// method follows from the corrections s₀ … s_n alone (C. T. Kelley, *Iterative Methods for Linear and
/// Nonlinear Equations*, SIAM 1995, section 7.3),
///
/// z ← z + (s_jᵀ z / s_jᵀ s_j) s_{j+1} for j < n, then s_{n+1} = z / (1 − s_nᵀ z / s_nᵀ s_n).
///
/// Scalar products are of coordinates divided by their scales.
#[derive(Debug, Clone, Default)]
pub(super) struct Secants {
    /// s_j divided by the scales; those beyond `count` are unused memory.
    steps: Vec<Vec<f64>>,
    count: usize,
}

/// Corrections that keep more than this fraction of the last one along its direction are not used for an
/// update: the denominator 1 − s_nᵀ z / s_nᵀ s_n would enlarge them more than twice.
const LARGEST_SHARE: f64 = 0.5;

impl Secants {
    /// Deletes all corrections, for another matrix.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Replaces H₀ r by Broyden's correction, and stores it for the next one.
    pub fn improve(&mut self, correction: &mut [f64], scale: &[f64]) {
        if self.count == self.steps.len() {
            self.steps.push(vec![0.0; scale.len()]);
        }
        let (known, rest) = self.steps.split_at_mut(self.count);
        let z = &mut rest[0];
        z.iter_mut().zip(correction.iter().zip(scale)).for_each(|(z, (x, scale))| *z = x / scale);
        for (j, step) in known.iter().enumerate() {
            let square = dot(step, step);
            let share = if square > 0.0 { dot(step, z) / square } else { 0.0 };
            match known.get(j + 1) {
                Some(next) => z.iter_mut().zip(next).for_each(|(z, next)| *z += share * next),
                None if share <= LARGEST_SHARE => z.iter_mut().for_each(|z| *z /= 1.0 - share),
                None => {}
            }
        }
        correction.iter_mut().zip(z.iter().zip(scale)).for_each(|(x, (z, scale))| *x = z * scale);
        self.count += 1;
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A linear system of n unknowns is solved within 2 n corrections from any regular matrix (D. M. Gay, *SIAM
    /// J. Numer. Anal.* 16 (1979) 623); the same matrix without updates leaves a large residual.
    #[test]
    fn linear_systems_end_within_twice_their_unknowns() {
        let matrix = [[4.0, 0.9, -0.4], [0.3, 3.0, 0.8], [-0.5, 0.7, 5.0]];
        let right = [1.0, -2.0, 3e-3];
        let scale = [1.0, 2.0, 0.5];
        let residual = |x: &[f64; 3]| -> [f64; 3] {
            std::array::from_fn(|i| right[i] - matrix[i].iter().zip(x).map(|(a, x)| a * x).sum::<f64>())
        };
        let solve = |updated: bool| {
            let (mut x, mut secants) = ([0.0; 3], Secants::default());
            for _ in 0..6 {
                let left = residual(&x);
                // The diagonal is used as an outdated matrix.
                let mut z: Vec<f64> = (0..3).map(|i| left[i] / matrix[i][i]).collect();
                if updated {
                    secants.improve(&mut z, &scale);
                }
                (0..3).for_each(|i| x[i] += z[i]);
            }
            residual(&x).iter().fold(0.0_f64, |most, r| most.max(r.abs()))
        };
        assert!(solve(true) < 1e-12, "{}", solve(true));
        assert!(solve(false) > 1e-5, "{}", solve(false));
    }

    /// Zero corrections at a vanishing residual do not cause NaN.
    #[test]
    fn vanishing_corrections_stay_zero() {
        let mut secants = Secants::default();
        for _ in 0..3 {
            let mut z = [0.0, 0.0];
            secants.improve(&mut z, &[1.0, 2.0]);
            assert_eq!(z, [0.0, 0.0]);
        }
    }
}
