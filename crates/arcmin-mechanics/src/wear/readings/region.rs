//! Boundary of the confidence region of readings: S(θ, N) = S_min + σ² t².

use nalgebra::{DMatrix, DVector};

use super::model::Truth;
use super::{Place, Search};

/// Number of directions in which the boundary is computed, for every machine. A band is the range of a result
/// over the boundary; the directions underestimate it by 1 − cos of half the angle between neighbours, 0.5 % of
/// its width in a plane.
const DIRECTIONS: usize = 32;
/// Largest ratio of the longest to the shortest half axis; beyond it the parameters count as not
/// distinguishable.
const LONGEST: f64 = 1e4;

impl Search<'_> {
    /// Points of the boundary: of the parameters alone, or with the lost motion when new of each machine in
    /// turn.
    ///
    /// In directions that are uniformly distributed for a paraboloid S, at the distance where S exceeds
    /// `allowed`, or at the bounds of the parameters.
    pub(super) fn edge(&self, best: &Place, open: &[usize], allowed: f64) -> Vec<Truth> {
        let machines: Vec<Option<usize>> = self.model.machines().map(Some).collect();
        let machines = if machines.is_empty() { vec![None] } else { machines };
        machines.into_iter().flat_map(|machine| self.edge_with(best, open, machine, allowed)).collect()
    }

    fn edge_with(&self, best: &Place, open: &[usize], machine: Option<usize>, allowed: f64) -> Vec<Truth> {
        let count = open.len() + usize::from(machine.is_some());
        // The last coordinate is the shift divided by the scale of the machine's readings.
        let truth = |at: &DVector<f64>| {
            let mut place = *best;
            for (index, by) in open.iter().zip(at.iter()) {
                place[*index] += by;
            }
            let shift = machine.map(|machine| (machine, at[count - 1] * self.model.scale(machine)));
            (Truth { law: self.law(&place), shift }, place)
        };
        let inside = |at: &DVector<f64>| {
            let (truth, place) = truth(at);
            let growth = self.model.growth;
            let latest = self.alone.iter().map(|(_, time)| *time).fold(0.0, f64::max);
            let believable = open.iter().filter(|index| **index > 0).all(|index| {
                let (low, high) = self.bounds[*index];
                (low..=high).contains(&place[*index])
            });
            let misfit: f64 = self.model.residuals(&truth).iter().map(|r| r * r).sum();
            believable && growth.covers(truth.law.at(latest)) && misfit <= allowed
        };
        let residuals = |at: DVector<f64>| DVector::from_vec(self.model.residuals(&truth(&at).0));
        let columns: Vec<DVector<f64>> = (0..count)
            .map(|index| {
                let step = 1e-3;
                let along = |by: f64| DVector::from_fn(count, |i, _| if i == index { by } else { 0.0 });
                (residuals(along(step)) - residuals(along(-step))) / (2.0 * step)
            })
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        let axes = (jacobian.transpose() * &jacobian).symmetric_eigen();
        let steepest = axes.eigenvalues.max().max(f64::MIN_POSITIVE);
        let lengths = axes.eigenvalues.map(|value| 1.0 / value.max(steepest / (LONGEST * LONGEST)).sqrt());
        directions(count)
            .into_iter()
            .filter_map(|direction| {
                let along = &axes.eigenvectors * direction.component_mul(&lengths);
                let mut far = 1e-3 * allowed.sqrt().max(1e-12);
                while inside(&(&along * far)) {
                    far *= 2.0;
                    if !far.is_finite() {
                        return None;
                    }
                }
                let (mut near, mut far) = (0.0, far);
                for _ in 0..50 {
                    let middle = 0.5 * (near + far);
                    if inside(&(&along * middle)) { near = middle } else { far = middle }
                }
                Some(truth(&(along * near)).0)
            })
            .collect()
    }
}

/// Unit vectors: uniformly on a circle; in more dimensions normal deviates along a Weyl sequence, with their
/// opposites.
fn directions(count: usize) -> Vec<DVector<f64>> {
    use std::f64::consts::{PI, TAU};
    match count {
        1 => [1.0, -1.0].map(|x| DVector::from_element(1, x)).into(),
        2 => (0..DIRECTIONS)
            .map(|i| {
                let angle = TAU * i as f64 / DIRECTIONS as f64;
                DVector::from_vec(vec![angle.cos(), angle.sin()])
            })
            .collect(),
        _ => (1..=4 * DIRECTIONS)
            .flat_map(|i| {
                // Box–Muller transform of multiples of square roots of primes, which are uniformly distributed.
                let part = |prime: f64| (i as f64 * prime.sqrt()).fract();
                let radius = |prime: f64| (-2.0 * (1.0 - part(prime)).ln()).sqrt();
                let normal = |k: usize| {
                    let (a, b) = [(2.0, 3.0), (5.0, 7.0)][k / 2 % 2];
                    let turn = if k.is_multiple_of(2) { 0.0 } else { 0.5 * PI };
                    radius(a) * (TAU * part(b) - turn).cos()
                };
                let vector = DVector::from_fn(count, |k, _| normal(k)).normalize();
                [vector.clone(), -vector]
            })
            .collect(),
    }
}
