use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::{Deserialize, Serialize};

use super::{Outcome, mirrored};
use crate::study::StudyError;
use crate::study::stream::{Purpose, Stream};

/// Covariance matrix adaptation evolution strategy (Hansen 2016, *The CMA Evolution Strategy: A Tutorial*,
/// arXiv 1604.00772, with its default parameters and negative weights), for one goal in the unit cube.
///
/// Bounds: the search is unbounded; a point outside is evaluated at its mirror image inside. Constraints enter as a
/// multiple of what is exceeded, added to the goal; the multiplier of each rises where it is exceeded on average and
/// falls where it is kept with room (an augmented Lagrangian with the generation's mean for the mean of the search:
/// Atamna, Auger & Hansen 2017). Designs that failed rank last.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CmaEs {
    seed: u64,
    generation: u64,
    population: usize,
    mean: Vec<f64>,
    /// σ
    step: f64,
    /// C by columns.
    covariance: Vec<f64>,
    path_step: Vec<f64>,
    path_covariance: Vec<f64>,
    penalty: Penalty,
    best: Option<(Vec<f64>, Outcome)>,
}

/// λ and μ of the augmented Lagrangian, one of each for every constraint.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
struct Penalty {
    multipliers: Vec<f64>,
    weights: Vec<f64>,
    last_mean: Vec<f64>,
    last_goal: f64,
}

/// Constants that follow from dimension and population.
struct Parameters {
    /// Weights of all ranks; those of the worse half are negative.
    weights: Vec<f64>,
    parents: usize,
    effective: f64,
    c_step: f64,
    damping: f64,
    c_covariance: f64,
    c_one: f64,
    c_rank: f64,
    /// E‖N(0, I)‖
    length: f64,
}

impl Parameters {
    /// Equations 49–58 of the tutorial.
    fn of(n: f64, population: usize) -> Parameters {
        let raw: Vec<f64> =
            (1..=population).map(|i| ((population as f64 + 1.0) / 2.0).ln() - (i as f64).ln()).collect();
        let parents = population / 2;
        let sums = |w: &[f64]| (w.iter().sum::<f64>(), w.iter().map(|w| w * w).sum::<f64>());
        let ((sum, squares), (sum_minus, squares_minus)) = (sums(&raw[..parents]), sums(&raw[parents..]));
        let effective = sum * sum / squares;
        let effective_minus = sum_minus * sum_minus / squares_minus;
        let c_step = (effective + 2.0) / (n + effective + 5.0);
        let damping = 1.0 + 2.0 * (((effective - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + c_step;
        let c_covariance = (4.0 + effective / n) / (n + 4.0 + 2.0 * effective / n);
        let c_one = 2.0 / ((n + 1.3).powi(2) + effective);
        let c_rank = (2.0 * (0.25 + effective + 1.0 / effective - 2.0) / ((n + 2.0).powi(2) + effective))
            .min(1.0 - c_one);
        let limit = (1.0 + c_one / c_rank)
            .min(1.0 + 2.0 * effective_minus / (effective + 2.0))
            .min((1.0 - c_one - c_rank) / (n * c_rank));
        let weights =
            raw.iter().map(|w| if *w >= 0.0 { w / sum } else { limit * w / sum_minus.abs() }).collect();
        let length = n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));
        Parameters { weights, parents, effective, c_step, damping, c_covariance, c_one, c_rank, length }
    }
}

/// C = B D² Bᵀ of one generation, and its draws.
struct Draws {
    vectors: DMatrix<f64>,
    deviations: DVector<f64>,
    /// y = B D z of every member.
    steps: Vec<DVector<f64>>,
}

impl CmaEs {
    /// Starts at `start` (in the unit cube) with a standard deviation of `step` in every dimension; 0.3
    /// searches the whole cube. `population` of `None` takes 4 + ⌊3 ln n⌋.
    ///
    /// # Errors
    /// [`StudyError::Search`] for an empty or outlying start, a step that is not positive or a population
    /// below 4.
    pub fn new(start: &[f64], step: f64, population: Option<usize>, seed: u64) -> Result<CmaEs, StudyError> {
        let no = |reason: &str| Err(StudyError::Search { reason: reason.into() });
        let n = start.len();
        if n == 0 || !start.iter().all(|x| (0.0..=1.0).contains(x)) {
            return no("the start is outside the searched space");
        }
        if !(step > 0.0 && step.is_finite()) {
            return no("the first step must be positive");
        }
        let population = population.unwrap_or(4 + (3.0 * (n as f64).ln()) as usize);
        if population < 4 {
            return no("a population needs four members at least");
        }
        let mut covariance = vec![0.0; n * n];
        covariance.iter_mut().step_by(n + 1).for_each(|c| *c = 1.0);
        Ok(CmaEs {
            seed,
            generation: 0,
            population,
            mean: start.to_vec(),
            step,
            covariance,
            path_step: vec![0.0; n],
            path_covariance: vec![0.0; n],
            penalty: Penalty::default(),
            best: None,
        })
    }

    /// Number of generations evaluated.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Designs of one generation, λ.
    pub fn population(&self) -> usize {
        self.population
    }

    /// The best design so far that keeps its constraints, or the one that breaks them least.
    pub fn best(&self) -> Option<(&[f64], &Outcome)> {
        self.best.as_ref().map(|(place, outcome)| (place.as_slice(), outcome))
    }

    /// Mean of the search, in the unit cube.
    pub fn mean(&self) -> Vec<f64> {
        self.mean.iter().map(|x| mirrored(*x)).collect()
    }

    /// Standard deviation of the search in its widest direction; small after convergence.
    pub fn spread(&self) -> f64 {
        let n = self.mean.len();
        let covariance = DMatrix::from_column_slice(n, n, &self.covariance);
        self.step * SymmetricEigen::new(covariance).eigenvalues.max().max(0.0).sqrt()
    }

    fn draw(&self) -> Draws {
        let n = self.mean.len();
        let eigen = SymmetricEigen::new(DMatrix::from_column_slice(n, n, &self.covariance));
        let largest = eigen.eigenvalues.max();
        let deviations = eigen.eigenvalues.map(|value| value.max(1e-30 * largest).sqrt());
        let first = self.generation.wrapping_mul(self.population as u64);
        let steps = (0..self.population as u64)
            .map(|member| {
                let mut stream = Stream::new(self.seed, Purpose::Generations, first.wrapping_add(member));
                let z = DVector::from_fn(n, |_, _| stream.normal());
                &eigen.eigenvectors * deviations.component_mul(&z)
            })
            .collect();
        Draws { vectors: eigen.eigenvectors, deviations, steps }
    }

    /// Points of the present generation in the unit cube; repeated calls give the same.
    pub fn ask(&self) -> Vec<Vec<f64>> {
        let place = |step: &DVector<f64>| {
            self.mean.iter().zip(step.iter()).map(|(m, y)| mirrored(m + self.step * y)).collect()
        };
        self.draw().steps.iter().map(place).collect()
    }

    /// Receives the outcomes of the generation in its order, and advances to the next.
    ///
    /// # Errors
    /// [`StudyError::Search`] if there are not as many outcomes as members, they differ in their number of
    /// constraints, or have more than one goal.
    pub fn tell(&mut self, outcomes: &[Outcome]) -> Result<(), StudyError> {
        let no = |reason: &str| Err(StudyError::Search { reason: reason.into() });
        if outcomes.len() != self.population {
            return no("the number of outcomes must equal that of the designs of a generation");
        }
        if outcomes.iter().any(|outcome| outcome.goals.len() > 1) {
            return no("this search has one goal");
        }
        let constraints = outcomes.iter().map(|outcome| outcome.constraints.len()).max().unwrap_or(0);
        if outcomes.iter().any(|o| !o.goals.is_empty() && o.constraints.len() != constraints) {
            return no("designs differ in their number of constraints");
        }
        for (place, outcome) in self.ask().into_iter().zip(outcomes) {
            if self.best.as_ref().is_none_or(|(_, best)| outcome.compare(best).is_lt()) {
                self.best = Some((place, outcome.clone()));
            }
        }
        let parameters = Parameters::of(self.mean.len() as f64, self.population);
        self.penalty.adapt(outcomes, &parameters, self.mean.len());
        let order = self.penalty.order(outcomes);
        self.adapt(&order, &parameters);
        self.generation += 1;
        Ok(())
    }

    /// Equations 39–47 of the tutorial.
    fn adapt(&mut self, order: &[usize], parameters: &Parameters) {
        let n = self.mean.len();
        let draws = self.draw();
        let p = parameters;
        let mut mean_step = DVector::zeros(n);
        for (weight, member) in p.weights[..p.parents].iter().zip(order) {
            mean_step += *weight * &draws.steps[*member];
        }
        for (mean, step) in self.mean.iter_mut().zip(mean_step.iter()) {
            *mean += self.step * step;
        }
        // C^(−1/2) y
        let whiten = |y: &DVector<f64>| {
            &draws.vectors * (draws.vectors.transpose() * y).component_div(&draws.deviations)
        };
        let white = whiten(&mean_step);
        let gain = (p.c_step * (2.0 - p.c_step) * p.effective).sqrt();
        for (path, white) in self.path_step.iter_mut().zip(white.iter()) {
            *path = (1.0 - p.c_step) * *path + gain * white;
        }
        let norm = self.path_step.iter().map(|x| x * x).sum::<f64>().sqrt();
        let settled = (1.0 - (1.0 - p.c_step).powf(2.0 * (self.generation + 1) as f64)).sqrt();
        let stalled = !(norm / settled < (1.4 + 2.0 / (n as f64 + 1.0)) * p.length);
        let gain = if stalled { 0.0 } else { (p.c_covariance * (2.0 - p.c_covariance) * p.effective).sqrt() };
        for (path, step) in self.path_covariance.iter_mut().zip(mean_step.iter()) {
            *path = (1.0 - p.c_covariance) * *path + gain * step;
        }
        let lost = if stalled { p.c_one * p.c_covariance * (2.0 - p.c_covariance) } else { 0.0 };
        let sum: f64 = p.weights.iter().sum();
        let keep = 1.0 + lost - p.c_one - p.c_rank * sum;
        let path = DVector::from_column_slice(&self.path_covariance);
        let mut covariance = DMatrix::from_column_slice(n, n, &self.covariance) * keep;
        covariance += p.c_one * &path * path.transpose();
        for (weight, member) in p.weights.iter().zip(order) {
            let y = &draws.steps[*member];
            // Negative weights must not take more than there is in a direction.
            let weight = if *weight >= 0.0 {
                *weight
            } else {
                weight * n as f64 / whiten(y).norm_squared().max(1e-300)
            };
            covariance += (p.c_rank * weight) * y * y.transpose();
        }
        let covariance = 0.5 * (&covariance + covariance.transpose());
        self.covariance = covariance.as_slice().to_vec();
        // The step cannot grow without end on a plateau, nor below the resolution of the coordinates.
        let growth = ((p.c_step / p.damping) * (norm / p.length - 1.0)).clamp(-1.0, 1.0).exp();
        self.step = (self.step * growth).clamp(1e-15, 1e3);
    }
}

impl Penalty {
    /// Members from the best to the worst by goal and penalty; failures last; ties in the order asked.
    fn order(&self, outcomes: &[Outcome]) -> Vec<usize> {
        let value = |outcome: &Outcome| match outcome.goals.first() {
            Some(goal) if outcome.violation().is_finite() => goal + self.of(&outcome.constraints),
            _ => f64::INFINITY,
        };
        let values: Vec<f64> = outcomes.iter().map(value).collect();
        let mut order: Vec<usize> = (0..outcomes.len()).collect();
        order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
        order
    }

    /// Σ λ g + μ g²/2 where that grows with g, and its least value −λ²/2μ where the constraint is kept with
    /// room.
    fn of(&self, constraints: &[f64]) -> f64 {
        constraints
            .iter()
            .zip(self.multipliers.iter().zip(&self.weights))
            .map(|(g, (multiplier, weight))| {
                if multiplier + weight * g >= 0.0 {
                    multiplier * g + 0.5 * weight * g * g
                } else {
                    -0.5 * multiplier * multiplier / weight
                }
            })
            .sum()
    }

    fn adapt(&mut self, outcomes: &[Outcome], parameters: &Parameters, n: usize) {
        let fine: Vec<&Outcome> = outcomes.iter().filter(|o| o.violation().is_finite()).collect();
        let constraints = fine.first().map_or(0, |outcome| outcome.constraints.len());
        if constraints == 0 {
            return;
        }
        let goals: Vec<f64> = fine.iter().map(|outcome| outcome.goals[0]).collect();
        let spread = |values: &[f64]| {
            let mut sorted = values.to_vec();
            sorted.sort_by(f64::total_cmp);
            sorted[3 * (sorted.len() - 1) / 4] - sorted[(sorted.len() - 1) / 4]
        };
        if self.weights.len() != constraints {
            self.multipliers = vec![0.0; constraints];
            // Goal and penalty of the first generation have about the same spread.
            self.weights = (0..constraints)
                .map(|c| {
                    let values: Vec<f64> = fine.iter().map(|outcome| outcome.constraints[c]).collect();
                    let (goal, own) = (spread(&goals), spread(&values));
                    if goal > 0.0 && own > 0.0 { 2.0 * goal / (n as f64 * own * own) } else { 1.0 }
                })
                .collect();
            self.last_mean = vec![0.0; constraints];
        }
        // Mean over the parents of this generation, for the mean of the search.
        let order = self.order(outcomes);
        let parents = &order[..parameters.parents.min(fine.len())];
        let total: f64 = parameters.weights[..parents.len()].iter().sum();
        let mean = |of: &dyn Fn(&Outcome) -> f64| {
            parents.iter().zip(&parameters.weights).map(|(k, w)| w * of(&outcomes[*k])).sum::<f64>() / total
        };
        let goal = mean(&|outcome| outcome.goals[0]);
        for c in 0..constraints {
            let g = mean(&|outcome| outcome.constraints[c]);
            let change = (g - self.last_mean[c]).abs();
            let (multiplier, weight) = (&mut self.multipliers[c], &mut self.weights[c]);
            // χ of Atamna, Auger & Hansen (2017): a weight too small lets g change too little or the goal too
            // much.
            let penalty_change = (*weight * g * g).abs();
            let goal_change = (goal - self.last_goal).abs();
            let factor = 2.0_f64.powf(1.0 / (4.0 * n as f64));
            if penalty_change < 3.0 * goal_change / n as f64 || 5.0 * change < self.last_mean[c].abs() {
                *weight *= factor;
            } else {
                *weight /= factor;
            }
            // Damping 5 of the multiplier's update.
            *multiplier = (*multiplier + *weight * g / 5.0).max(0.0);
            self.last_mean[c] = g;
        }
        self.last_goal = goal;
    }
}
