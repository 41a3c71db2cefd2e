use std::f64::consts::{PI, TAU};

/// Removed depth and its derivatives with respect to the meshing angle.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DepthSample {
    /// Depth w in m, measured along the flank normal, positive into the metal.
    pub depth: f64,
    /// dw/dφ in m/rad.
    pub slope: f64,
    /// d²w/dφ² in m/rad².
    pub bend: f64,
}

/// Depth of metal removed from the flank by wear or modification, the same on every lobe, as a function of the
/// signed meshing angle φ ∈ (−π, π].
///
/// Stored at equidistant angles and interpolated by a periodic cubic spline, so that the depth and its first
/// two derivatives are continuous. Positive and negative φ are the two flanks of a tooth space; they meet at
/// the root (φ = 0) and at the tip (φ = ±π).
#[derive(Debug, Clone, PartialEq)]
pub struct Relief {
    values: Vec<f64>,
    /// Second derivatives of the spline with respect to φ.
    bends: Vec<f64>,
    /// Distance of the grid points in rad, its inverse, and a sixth of its square.
    step: f64,
    per_step: f64,
    sixth: f64,
}

impl Relief {
    /// The same depth (m) everywhere: the worn profile of Tao2024, eq. (24).
    pub fn uniform(depth: f64) -> Relief {
        Relief::with_bends(vec![depth], vec![0.0])
    }

    /// From depths (m) at φ_i = −π + 2π i/n, i = 0…n−1.
    pub fn from_samples(depths: Vec<f64>) -> Relief {
        if depths.len() < 4 {
            return Relief::uniform(depths.first().copied().unwrap_or(0.0));
        }
        let bends = periodic_spline_bends(&depths);
        Relief::with_bends(depths, bends)
    }

    /// A free form through pairs of meshing angle (rad, increasing within one turn) and depth (m), closed
    /// around the tooth: a cubic interpolation without overshoot, sampled every half degree.
    pub fn through(points: &[[f64; 2]]) -> Relief {
        Relief::from_samples(Relief::grid(720).map(|phi| between(points, phi)).collect())
    }

    fn with_bends(values: Vec<f64>, bends: Vec<f64>) -> Relief {
        let count = values.len() as f64;
        let step = TAU / count;
        Relief { values, bends, step, per_step: count / TAU, sixth: step * step / 6.0 }
    }

    /// Meshing angles of the samples for a grid of `count` points.
    pub fn grid(count: usize) -> impl ExactSizeIterator<Item = f64> + Clone {
        (0..count).map(move |i| -PI + TAU * i as f64 / count as f64)
    }

    /// Depths at the grid points in m.
    pub fn samples(&self) -> &[f64] {
        &self.values
    }

    /// Control points of the spline as a sum of B-splines: it is convex where their polygon is.
    pub(super) fn control_points(&self) -> Vec<f64> {
        let weight = self.step * self.step / 6.0;
        self.values.iter().zip(&self.bends).map(|(value, bend)| value - weight * bend).collect()
    }

    /// The spline with these control points (m) at φ_i = −π + 2π i/n. It passes near the points, not through
    /// them, so that it does not oscillate beside an edge, and is convex where they are.
    pub(crate) fn from_control_points(points: &[f64]) -> Relief {
        let (values, bends) = (0..points.len()).map(|i| at_control_point(points, i)).unzip();
        Relief::with_bends(values, bends)
    }

    /// The spline with other control points; samples at unchanged control points are kept.
    pub(super) fn with_control_points(&self, before: &[f64], after: &[f64]) -> Relief {
        let n = after.len();
        let (mut values, mut bends) = (self.values.clone(), self.bends.clone());
        for i in 0..n {
            let near = [(i + n - 1) % n, i, (i + 1) % n];
            if near.iter().any(|j| before[*j] != after[*j]) {
                (values[i], bends[i]) = at_control_point(after, i);
            }
        }
        Relief::with_bends(values, bends)
    }

    /// Whether the depth is the same everywhere by construction.
    pub fn is_uniform(&self) -> bool {
        self.values.len() == 1
    }

    /// Whether no metal is removed at all.
    pub fn is_zero(&self) -> bool {
        self.values.iter().all(|depth| *depth == 0.0)
    }

    /// Largest depth at a grid point and the meshing angle there.
    pub fn deepest(&self) -> (f64, f64) {
        let (index, depth) = self
            .values
            .iter()
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(b.1))
            .map(|(index, depth)| (index, *depth))
            .unwrap_or((0, 0.0));
        (depth, -PI + TAU * index as f64 / self.values.len() as f64)
    }

    /// Sum of two reliefs on the finer of the two grids.
    pub fn plus(&self, other: &Relief) -> Relief {
        let (fine, coarse) =
            if self.values.len() >= other.values.len() { (self, other) } else { (other, self) };
        if coarse.is_uniform() && coarse.is_zero() {
            return fine.clone();
        }
        let sum = Relief::grid(fine.values.len())
            .zip(&fine.values)
            .map(|(phi, depth)| depth + coarse.at(phi).depth)
            .collect::<Vec<_>>();
        Relief::from_samples(sum)
    }

    /// Depth, slope and bend at the meshing angle φ in (−π, π].
    #[inline]
    pub fn at(&self, meshing_angle: f64) -> DepthSample {
        let n = self.values.len();
        if n == 1 {
            return DepthSample { depth: self.values[0], ..DepthSample::default() };
        }
        let h = self.step;
        // Truncation instead of `floor` and a remainder: this is the innermost loop, and φ lies within one
        // turn.
        let x = ((meshing_angle + PI) * self.per_step).max(0.0);
        let cell = x as usize;
        let t = x - cell as f64;
        let left = if cell < n { cell } else { cell % n };
        let right = if left + 1 == n { 0 } else { left + 1 };
        let (y0, y1, m0, m1) = (self.values[left], self.values[right], self.bends[left], self.bends[right]);
        let s = 1.0 - t;
        DepthSample {
            depth: s * y0 + t * y1 + self.sixth * ((s * s * s - s) * m0 + (t * t * t - t) * m1),
            slope: (y1 - y0) * self.per_step
                + h / 6.0 * ((3.0 * t * t - 1.0) * m1 - (3.0 * s * s - 1.0) * m0),
            bend: s * m0 + t * m1,
        }
    }
}

/// Depth at the meshing angle φ from points with increasing angles, closed around the tooth: cubic Hermite
/// interpolation with the slopes of Fritsch and Butland (harmonic mean), which does not overshoot the points.
fn between(points: &[[f64; 2]], phi: f64) -> f64 {
    let count = points.len() as isize;
    let at = |index: isize| {
        let [angle, depth] = points[index.rem_euclid(count) as usize];
        [angle + index.div_euclid(count) as f64 * TAU, depth]
    };
    let secant = |index: isize| {
        let ([x0, y0], [x1, y1]) = (at(index), at(index + 1));
        (y1 - y0) / (x1 - x0)
    };
    let slope = |index: isize| {
        let (before, after) = (secant(index - 1), secant(index));
        if before * after > 0.0 { 2.0 * before * after / (before + after) } else { 0.0 }
    };
    let left = points.iter().rposition(|point| point[0] <= phi).map_or(-1, |index| index as isize);
    let ([x0, y0], [x1, y1]) = (at(left), at(left + 1));
    let h = x1 - x0;
    let t = (phi - x0) / h;
    let s = 1.0 - t;
    y0 * s * s * (1.0 + 2.0 * t)
        + y1 * t * t * (1.0 + 2.0 * s)
        + h * s * t * (s * slope(left) - t * slope(left + 1))
}

/// Depth (m) and second derivative (m/rad²) of the spline with these control points at grid point `i`.
fn at_control_point(points: &[f64], i: usize) -> (f64, f64) {
    let n = points.len();
    let step = TAU / n as f64;
    let second = points[(i + n - 1) % n] - 2.0 * points[i] + points[(i + 1) % n];
    (points[i] + second / 6.0, second / (step * step))
}

/// Second derivatives of the periodic cubic spline through equidistant values: m_{i−1} + 4 m_i + m_{i+1} = 6
/// Δ²y/h², solved by the Sherman–Morrison form of the cyclic Thomas algorithm.
fn periodic_spline_bends(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let h = TAU / n as f64;
    let right = |i: usize| if i + 1 == n { 0 } else { i + 1 };
    let left = |i: usize| if i == 0 { n - 1 } else { i - 1 };
    let load: Vec<f64> =
        (0..n).map(|i| 6.0 * (values[right(i)] - 2.0 * values[i] + values[left(i)]) / (h * h)).collect();
    // Cyclic system = tridiagonal (corners moved to the ends with γ = −4) + rank one.
    let gamma = -4.0;
    let diagonal = |i: usize| match i {
        0 => 4.0 - gamma,
        i if i + 1 == n => 4.0 - 1.0 / gamma,
        _ => 4.0,
    };
    let solve = |rhs: &[f64]| {
        let mut c = vec![0.0; n];
        let mut x = vec![0.0; n];
        let mut pivot = diagonal(0);
        x[0] = rhs[0] / pivot;
        for i in 1..n {
            c[i] = 1.0 / pivot;
            pivot = diagonal(i) - c[i];
            x[i] = (rhs[i] - x[i - 1]) / pivot;
        }
        for i in (0..n - 1).rev() {
            x[i] -= c[i + 1] * x[i + 1];
        }
        x
    };
    let mut corner = vec![0.0; n];
    corner[0] = gamma;
    corner[n - 1] = 1.0;
    let y = solve(&load);
    let q = solve(&corner);
    let factor = (y[0] + y[n - 1] / gamma) / (1.0 + q[0] + q[n - 1] / gamma);
    y.iter().zip(&q).map(|(y, q)| y - factor * q).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spline_reproduces_a_smooth_periodic_depth_to_fourth_order() {
        let exact = |phi: f64| 1e-5 * (1.0 + (phi).sin() + 0.3 * (3.0 * phi).cos());
        let error = |n: usize| {
            let relief = Relief::from_samples(Relief::grid(n).map(exact).collect());
            (0..997)
                .map(|i| -PI + TAU * (i as f64 + 0.37) / 997.0)
                .map(|phi| (relief.at(phi).depth - exact(phi)).abs())
                .fold(0.0, f64::max)
        };
        let order = (error(40) / error(80)).log2();
        assert!((order - 4.0).abs() < 0.2, "order {order}");
    }

    #[test]
    fn slope_and_bend_are_the_derivatives_of_the_depth() {
        let relief = Relief::from_samples(Relief::grid(90).map(|phi| 1e-5 * (phi.cos() + 1.0)).collect());
        for i in 0..50 {
            let phi = -3.1 + 0.123 * i as f64;
            let h = 1e-5;
            let (a, m, b) = (relief.at(phi - h), relief.at(phi), relief.at(phi + h));
            assert!(((b.depth - a.depth) / (2.0 * h) - m.slope).abs() < 1e-12);
            assert!(((b.slope - a.slope) / (2.0 * h) - m.bend).abs() < 1e-9);
        }
    }

    /// Beside the edge between two arcs the spline through the samples oscillates. The spline with these values
    /// as control points has the curvature of the arcs from one cell on, and deviates from them by no more than
    /// the edge does within its cell.
    #[test]
    fn trap_a_spline_through_an_edge_oscillates() {
        let arcs = |phi: f64| 1e-5 * (phi.abs() - 1.5).powi(2);
        let samples: Vec<f64> = Relief::grid(360).map(arcs).collect();
        let least_bend = |relief: &Relief| {
            let beside = (4..60).map(|i| 0.25 * TAU / 360.0 * f64::from(i));
            beside.map(|phi| relief.at(phi).bend).fold(f64::INFINITY, f64::min)
        };
        assert!(least_bend(&Relief::from_samples(samples.clone())) < -1e-5);
        let near = Relief::from_control_points(&samples);
        assert!((least_bend(&near) / 2e-5 - 1.0).abs() < 1e-6, "{}", least_bend(&near));
        for i in 0..3600 {
            let phi = -3.1 + 6.2 * f64::from(i) / 3600.0;
            let off = (near.at(phi).depth - arcs(phi)).abs();
            assert!(off < 1.1e-5 * TAU / 360.0, "{phi}: {off:e}");
        }
    }

    #[test]
    fn uniform_depth_is_flat() {
        assert_eq!(Relief::uniform(6e-5).at(1.0), DepthSample { depth: 6e-5, slope: 0.0, bend: 0.0 });
    }
}
