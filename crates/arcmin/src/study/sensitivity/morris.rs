//! Elementary effects along trajectories (Morris 1991).

use super::{Estimate, StudyError, require};
use crate::study::statistics::Bootstrap;

/// Elementary effects of one dimension: changes of the result per whole range of the dimension.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effects {
    /// Mean; near zero with a large μ* if the sign of the effect depends on the point.
    pub mu: f64,
    /// Mean of the magnitudes (Campolongo, Cariboni & Saltelli 2007): the size of the effect.
    pub mu_star: Estimate,
    /// Standard deviation: dependence of the effect on the point, by curvature or interaction.
    pub sigma: f64,
    /// Trajectories whose step in this dimension could be computed.
    pub steps: usize,
}

/// μ, μ* and σ of every dimension from rows laid out in trajectories (Morris 1991): the change of the result
/// over each step divided by δ = p/(2(p − 1)), signed by the direction of the step.
///
/// `units` are points in the unit cube, `results` the values there, `None` for failed rows: both steps at such
/// a row are left out.
///
/// # Errors
/// [`StudyError::Statistic`] if rows and results are not whole trajectories of one step in each dimension, a
/// result is not finite, or fewer than two steps of a dimension could be computed.
pub fn morris(
    units: &[Vec<f64>],
    results: &[Option<f64>],
    levels: usize,
    bootstrap: Bootstrap,
) -> Result<Vec<Effects>, StudyError> {
    require(units.len() == results.len(), "there are not as many results as rows")?;
    require(results.iter().flatten().all(|y| y.is_finite()), "a result is not finite")?;
    let dimensions = units.first().map_or(0, Vec::len);
    require(
        dimensions > 0 && units.len().is_multiple_of(dimensions + 1),
        "the rows are not whole trajectories",
    )?;
    require(levels >= 2, "trajectories need two levels")?;
    let delta = levels as f64 / (2.0 * (levels as f64 - 1.0));
    let mut effects = vec![Vec::new(); dimensions];
    for (places, values) in units.chunks(dimensions + 1).zip(results.chunks(dimensions + 1)) {
        for (place, value) in places.windows(2).zip(values.windows(2)) {
            let mut changed = (0..dimensions).filter(|d| place[0][*d] != place[1][*d]);
            let (Some(dimension), None) = (changed.next(), changed.next()) else {
                return require(false, "a step of a trajectory is not one of one dimension")
                    .map(|()| Vec::new());
            };
            if let (Some(from), Some(to)) = (value[0], value[1]) {
                let sign = (place[1][dimension] - place[0][dimension]).signum();
                effects[dimension].push(sign * (to - from) / delta);
            }
        }
    }
    effects.iter().map(|effects| statistics(effects, bootstrap)).collect()
}

fn statistics(effects: &[f64], bootstrap: Bootstrap) -> Result<Effects, StudyError> {
    require(effects.len() >= 2, "fewer than two steps of a dimension could be computed")?;
    let n = effects.len() as f64;
    let mu = effects.iter().sum::<f64>() / n;
    let sigma = (effects.iter().map(|e| (e - mu).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let star = |indices: &mut dyn Iterator<Item = usize>| indices.map(|k| effects[k].abs()).sum::<f64>() / n;
    let interval = bootstrap.intervals(effects.len(), |drawn| vec![star(&mut drawn.iter().copied())])?[0];
    Ok(Effects {
        mu,
        mu_star: Estimate { value: star(&mut (0..effects.len())), interval },
        sigma,
        steps: effects.len(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Distribution;
    use crate::study::sampling::{Layout, Sampling};

    fn rows(dimensions: usize, trajectories: u64) -> Vec<Vec<f64>> {
        let factors = vec![Distribution::Uniform { low: 0.0, high: 1.0 }; dimensions];
        let sampling = Sampling::new(Layout::Morris { levels: 4 }, factors, trajectories, 5).unwrap();
        (0..sampling.rows()).map(|row| sampling.point(row).unit).collect()
    }

    /// A plane has its slopes as effects, everywhere; a product of two has σ.
    #[test]
    fn effects_of_a_plane_are_its_slopes() {
        let units = rows(3, 10);
        let y: Vec<Option<f64>> = units.iter().map(|u| Some(4.0 + 3.0 * u[0] - 2.0 * u[1])).collect();
        let effects = morris(&units, &y, 4, Bootstrap::default()).unwrap();
        for (effect, slope) in effects.iter().zip([3.0, -2.0, 0.0_f64]) {
            assert!((effect.mu - slope).abs() < 1e-12 && (effect.mu_star.value - slope.abs()).abs() < 1e-12);
            assert!(effect.sigma < 1e-12 && effect.steps == 10);
        }
        let product: Vec<Option<f64>> = units.iter().map(|u| Some(u[0] * u[1])).collect();
        let effects = morris(&units, &product, 4, Bootstrap::default()).unwrap();
        assert!(effects[0].sigma > 0.1 && effects[2].mu_star.value == 0.0);
    }

    #[test]
    fn failed_rows_take_their_steps_with_them() {
        let units = rows(3, 10);
        let mut y: Vec<Option<f64>> = units.iter().map(|u| Some(3.0 * u[0] + u[1])).collect();
        y[1] = None;
        let effects = morris(&units, &y, 4, Bootstrap::default()).unwrap();
        assert_eq!(effects.iter().map(|e| e.steps).sum::<usize>(), 28);
        assert!((effects[0].mu - 3.0).abs() < 1e-12);
        assert!(morris(&units[..7], &y[..7], 4, Bootstrap::default()).is_err());
        y[0] = Some(f64::NAN);
        assert!(morris(&units, &y, 4, Bootstrap::default()).is_err());
    }
}
