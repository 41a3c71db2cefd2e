//! Shares of the variance by a linear fit of the results.

use nalgebra::{DMatrix, DVector};

use super::{Estimate, StudyError, require};
use crate::study::statistics::Bootstrap;

/// Shares of the variance by a linear fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Linear {
    /// Standardised coefficients b_i s(x_i)/s(y); their sign is the direction.
    pub coefficients: Vec<f64>,
    /// Their squares over the sum of the squares, times R²: the share of the variance for each.
    pub shares: Vec<Estimate>,
    /// Share of the variance explained by the linear fit, R²; the shares are meaningful if it is near one.
    pub r_squared: f64,
    /// Rows with results.
    pub rows: usize,
}

/// Linear fit of the results by least squares. For any samples, preferably independent ones (random, Latin
/// hypercube, Sobol sequence); curvature and interaction reduce R². `inputs` are rows of the varied quantities;
/// a dimension without variation has no share.
///
/// # Errors
/// [`StudyError::Statistic`] if there are not as many results as rows, one is not finite, or fewer complete
/// rows than dimensions + 2.
pub fn linear(
    inputs: &[Vec<f64>],
    results: &[Option<f64>],
    bootstrap: Bootstrap,
) -> Result<Linear, StudyError> {
    require(inputs.len() == results.len(), "there are not as many results as rows")?;
    require(results.iter().flatten().all(|y| y.is_finite()), "a result is not finite")?;
    require(inputs.iter().flatten().all(|x| x.is_finite()), "an input is not finite")?;
    let rows: Vec<(&[f64], f64)> =
        inputs.iter().zip(results).filter_map(|(x, y)| y.map(|y| (x.as_slice(), y))).collect();
    let dimensions = inputs.first().map_or(0, Vec::len);
    require(dimensions > 0, "nothing varies")?;
    require(rows.len() >= dimensions + 2, "there are too few rows for the number of dimensions")?;
    let every: Vec<usize> = (0..rows.len()).collect();
    let (coefficients, r_squared) = fit(&rows, &every, dimensions);
    let share = |coefficients: &[f64], r_squared: f64| -> Vec<f64> {
        let sum: f64 = coefficients.iter().map(|b| b * b).sum();
        coefficients.iter().map(|b| if sum > 0.0 { r_squared * b * b / sum } else { 0.0 }).collect()
    };
    let values = share(&coefficients, r_squared);
    let intervals = bootstrap.intervals(rows.len(), |drawn| {
        let (coefficients, r_squared) = fit(&rows, drawn, dimensions);
        share(&coefficients, r_squared)
    })?;
    let shares =
        values.into_iter().zip(intervals).map(|(value, interval)| Estimate { value, interval }).collect();
    Ok(Linear { coefficients, shares, r_squared, rows: rows.len() })
}

/// Standardised coefficients and R².
fn fit(rows: &[(&[f64], f64)], drawn: &[usize], dimensions: usize) -> (Vec<f64>, f64) {
    let n = drawn.len() as f64;
    let standard = |of: &dyn Fn(usize) -> f64| -> (f64, f64) {
        let mean = drawn.iter().map(|k| of(*k)).sum::<f64>() / n;
        let deviation = (drawn.iter().map(|k| (of(*k) - mean).powi(2)).sum::<f64>() / n).sqrt();
        // Values that vary by rounding alone count as constant.
        (mean, if deviation > 1e-13 * mean.abs() { 1.0 / deviation } else { 0.0 })
    };
    let y = standard(&|k| rows[k].1);
    if y.1 == 0.0 {
        return (vec![0.0; dimensions], 0.0);
    }
    let x: Vec<(f64, f64)> = (0..dimensions).map(|d| standard(&|k| rows[k].0[d])).collect();
    // Normal equations of standardised columns: the correlation matrix; the pseudo-inverse omits constant
    // columns.
    let mut correlation = DMatrix::<f64>::zeros(dimensions, dimensions);
    let mut right = DVector::<f64>::zeros(dimensions);
    let mut scaled = vec![0.0; dimensions];
    for k in drawn {
        for d in 0..dimensions {
            scaled[d] = (rows[*k].0[d] - x[d].0) * x[d].1;
        }
        let value = (rows[*k].1 - y.0) * y.1;
        for i in 0..dimensions {
            right[i] += scaled[i] * value / n;
            for j in 0..=i {
                correlation[(i, j)] += scaled[i] * scaled[j] / n;
            }
        }
    }
    correlation.fill_upper_triangle_with_lower_triangle();
    let svd = correlation.svd(true, true);
    let Ok(coefficients) = svd.solve(&right, 1e-10) else { return (vec![0.0; dimensions], 0.0) };
    let r_squared = coefficients.dot(&right).clamp(0.0, 1.0);
    (coefficients.iter().copied().collect(), r_squared)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::{Purpose, Stream};

    fn inputs(count: u64) -> Vec<Vec<f64>> {
        (0..count)
            .map(|k| {
                let mut stream = Stream::new(6, Purpose::Points, k);
                vec![stream.normal(), 2.0 * stream.normal(), stream.unit(), 5.0]
            })
            .collect()
    }

    /// y = 3a + b with deviations 1 and 2: shares 9/13 and 4/13; exact up to the sample's own deviations.
    #[test]
    fn shares_of_a_plane() {
        let x = inputs(2000);
        let y: Vec<Option<f64>> = x.iter().map(|x| Some(3.0 * x[0] + x[1] - 7.0)).collect();
        let fit = linear(&x, &y, Bootstrap::default()).unwrap();
        assert!((fit.r_squared - 1.0).abs() < 1e-10);
        assert!(fit.shares[0].interval.contains(9.0 / 13.0) && fit.shares[1].interval.contains(4.0 / 13.0));
        assert!(fit.shares[2].value < 1e-10 && fit.shares[3].value == 0.0);
        assert!(fit.coefficients[0] > 0.8 && fit.coefficients[1] > 0.5);
    }

    /// The square of a symmetric variable has no linear part: R² is small.
    #[test]
    fn curvature_reduces_r_squared() {
        let x = inputs(2000);
        let y: Vec<Option<f64>> = x.iter().map(|x| Some(x[0] * x[0])).collect();
        assert!(linear(&x, &y, Bootstrap::default()).unwrap().r_squared < 0.02);
        assert!(linear(&x[..5], &y[..5], Bootstrap::default()).is_err());
    }
}
