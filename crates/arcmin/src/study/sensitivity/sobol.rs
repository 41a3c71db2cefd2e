//! First and total shares of the variance (Saltelli 2010).

use super::{Estimate, StudyError, require};
use crate::study::statistics::Bootstrap;

/// Shares of the variance of a result.
#[derive(Debug, Clone, PartialEq)]
pub struct Indices {
    /// S: reduction of the variance if this dimension alone is known.
    pub first: Vec<Estimate>,
    /// S_T: remaining variance if all other dimensions are known; S_T − S is interaction.
    pub total: Vec<Estimate>,
    /// (i, j, S_ij) for i < j, where the layout has the rows for it.
    pub second: Vec<(usize, usize, Estimate)>,
    /// Base points used.
    pub used: usize,
    /// Base points left out because a row of theirs has no result.
    pub left_out: usize,
    /// Variance of the result over the base points A and B.
    pub variance: f64,
}

/// Results of the rows of one base point: A, A with columns of B, B with columns of A, B.
struct Base<'a>(&'a [f64], usize);

impl Base<'_> {
    fn a(&self) -> f64 {
        self.0[0]
    }
    fn b(&self) -> f64 {
        self.0[self.0.len() - 1]
    }
    fn ab(&self, dimension: usize) -> f64 {
        self.0[1 + dimension]
    }
    fn ba(&self, dimension: usize) -> f64 {
        self.0[1 + self.1 + dimension]
    }
}

/// First-order, total and, where the layout allows it, second-order indices from rows laid out by
/// [`Layout::Saltelli`](crate::study::sampling::Layout::Saltelli), with the estimators of SALib 1.6: with results
/// minus their mean over all rows and divided by their deviation,
///
/// S_i = ⟨B (AB_i − A)⟩/V, S_Ti = ⟨(A − AB_i)²⟩/2V (Saltelli et al. 2010; Jansen 1999), S_ij = ⟨BA_i AB_j − A
/// B⟩/V − S_i − S_j (Saltelli 2002), V the variance of A and B together. Intervals are percentiles of base
/// points drawn again.
///
/// # Errors
/// [`StudyError::Statistic`] if the results are not whole base points, one is not finite, or fewer than two
/// base points are complete.
pub fn sobol(
    results: &[Option<f64>],
    dimensions: usize,
    second_order: bool,
    bootstrap: Bootstrap,
) -> Result<Indices, StudyError> {
    let step = if second_order { 2 * dimensions + 2 } else { dimensions + 2 };
    require(dimensions > 0, "nothing varies")?;
    require(!results.is_empty() && results.len().is_multiple_of(step), "the rows are not whole base points")?;
    require(results.iter().flatten().all(|y| y.is_finite()), "a result is not finite")?;
    let complete: Vec<Vec<f64>> =
        results.chunks(step).filter_map(|rows| rows.iter().copied().collect()).collect();
    let left_out = results.len() / step - complete.len();
    require(complete.len() >= 2, "fewer than two base points are complete")?;
    let count = (complete.len() * step) as f64;
    let mean = complete.iter().flatten().sum::<f64>() / count;
    let deviation = (complete.iter().flatten().map(|y| (y - mean).powi(2)).sum::<f64>() / count).sqrt();
    // A constant result has zero indices.
    let scale = if deviation > 0.0 { deviation } else { 1.0 };
    let rows: Vec<Vec<f64>> =
        complete.iter().map(|rows| rows.iter().map(|y| (y - mean) / scale).collect()).collect();
    let bases: Vec<Base> = rows.iter().map(|row| Base(row, dimensions)).collect();
    let pairs: Vec<(usize, usize)> = if second_order {
        (0..dimensions).flat_map(|i| (i + 1..dimensions).map(move |j| (i, j))).collect()
    } else {
        Vec::new()
    };
    let every: Vec<usize> = (0..bases.len()).collect();
    let values = numbers(&bases, &every, dimensions, &pairs);
    let intervals = bootstrap.intervals(bases.len(), |drawn| numbers(&bases, drawn, dimensions, &pairs))?;
    let mut estimates =
        values.into_iter().zip(intervals).map(|(value, interval)| Estimate { value, interval });
    let first = estimates.by_ref().take(dimensions).collect();
    let total = estimates.by_ref().take(dimensions).collect();
    let second = pairs.into_iter().zip(estimates).map(|((i, j), estimate)| (i, j, estimate)).collect();
    let variance = variance_of(&bases, &every) * scale * scale;
    Ok(Indices { first, total, second, used: bases.len(), left_out, variance })
}

/// Variance of A and B together, divided by their number.
fn variance_of(bases: &[Base], drawn: &[usize]) -> f64 {
    let n = 2.0 * drawn.len() as f64;
    let mean = drawn.iter().map(|k| bases[*k].a() + bases[*k].b()).sum::<f64>() / n;
    drawn.iter().map(|k| (bases[*k].a() - mean).powi(2) + (bases[*k].b() - mean).powi(2)).sum::<f64>() / n
}

/// S of all, S_T of all, S_ij of the pairs.
fn numbers(bases: &[Base], drawn: &[usize], dimensions: usize, pairs: &[(usize, usize)]) -> Vec<f64> {
    let (n, variance) = (drawn.len() as f64, variance_of(bases, drawn));
    let share = |of: &dyn Fn(&Base) -> f64| {
        let mean = drawn.iter().map(|k| of(&bases[*k])).sum::<f64>() / n;
        if variance > f64::EPSILON { mean / variance } else { 0.0 }
    };
    let first: Vec<f64> = (0..dimensions).map(|d| share(&|p| p.b() * (p.ab(d) - p.a()))).collect();
    let total: Vec<f64> = (0..dimensions).map(|d| share(&|p| 0.5 * (p.a() - p.ab(d)).powi(2))).collect();
    let second: Vec<f64> = pairs
        .iter()
        .map(|(i, j)| share(&|p| p.ba(*i) * p.ab(*j) - p.a() * p.b()) - first[*i] - first[*j])
        .collect();
    [first, total, second].concat()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::study::sampling::{Layout, Sampling};
    use crate::study::{Distribution, Value};

    fn evaluate(second_order: bool, samples: u64, seed: u64) -> Vec<Option<f64>> {
        let factors = vec![Distribution::Uniform { low: -PI, high: PI }; 3];
        let sampling = Sampling::new(Layout::Saltelli { second_order }, factors, samples, seed).unwrap();
        let number = |value: &Value| match value {
            Value::Number(x) => *x,
            other => panic!("{other:?}"),
        };
        (0..sampling.rows())
            .map(|row| {
                let x: Vec<f64> = sampling.values(&sampling.point(row)).iter().map(number).collect();
                Some(x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin())
            })
            .collect()
    }

    /// Ishigami & Homma (1990) with a = 7, b = 0.1: V₁ = (1 + bπ⁴/5)²/2, V₂ = a²/8, V₁₃ = b²π⁸ 8/225.
    fn exact() -> ([f64; 3], [f64; 3], f64, f64) {
        let (v1, v2) = (0.5 * (1.0 + 0.1 * PI.powi(4) / 5.0).powi(2), 49.0 / 8.0);
        let v13 = 0.01 * PI.powi(8) * 8.0 / 225.0;
        let v = v1 + v2 + v13;
        ([v1 / v, v2 / v, 0.0], [(v1 + v13) / v, v2 / v, v13 / v], v13 / v, v)
    }

    #[test]
    fn ishigami_lies_within_the_intervals() {
        let (first, total, both, variance) = exact();
        // As often printed: 0.3139, 0.4424, 0; 0.5576, 0.4424, 0.2437.
        assert!((first[0] - 0.3139).abs() < 5e-5 && (total[2] - 0.2437).abs() < 5e-5);
        let results = evaluate(true, 4096, 3);
        let indices =
            sobol(&results, 3, true, Bootstrap { confidence: 0.99, ..Bootstrap::default() }).unwrap();
        for d in 0..3 {
            assert!(indices.first[d].interval.contains(first[d]), "{d}: {:?} {}", indices.first[d], first[d]);
            assert!(indices.total[d].interval.contains(total[d]), "{d}: {:?} {}", indices.total[d], total[d]);
            // The scrambled sequence does better than its intervals, which assume independent samples.
            assert!((indices.first[d].value - first[d]).abs() < 0.01);
            assert!((indices.total[d].value - total[d]).abs() < 0.01);
        }
        let interaction = indices.second.iter().find(|(i, j, _)| (*i, *j) == (0, 2)).unwrap().2;
        assert!(interaction.interval.contains(both), "{interaction:?} {both}");
        assert!((indices.variance / variance - 1.0).abs() < 0.01);
    }

    #[test]
    fn incomplete_base_points_are_left_out_and_counted() {
        let mut results = evaluate(false, 256, 3);
        results[12] = None;
        results[14] = None;
        results[700] = None;
        let indices = sobol(&results, 3, false, Bootstrap::default()).unwrap();
        assert_eq!((indices.used, indices.left_out), (254, 2));
        assert!(sobol(&results[..7], 3, false, Bootstrap::default()).is_err());
    }

    #[test]
    fn constant_results_have_no_sensitivity() {
        let indices = sobol(&[Some(3.0); 50], 3, false, Bootstrap::default()).unwrap();
        assert!(indices.first.iter().chain(&indices.total).all(|s| s.value == 0.0));
    }
}
