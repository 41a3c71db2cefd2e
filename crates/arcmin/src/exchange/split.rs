//! Deviations of a measured flank: run-out, pitch, modification, profile.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use crate::geometry::{FlankDirection, FlankHarmonic, Profile, Relief, cross, unit};
use crate::units::wrap_angle;

/// Deviations of a flank, as depths of missing metal.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankSplit {
    /// Radial, cumulative pitch and profile, as harmonics around the disc.
    pub harmonics: Vec<FlankHarmonic>,
    /// Part common to all lobes: coefficients of 1, cos φ, sin φ, cos 2φ, … in m.
    pub modification: Vec<f64>,
    /// Cumulative pitch deviation of each lobe in m, counter-clockwise, on the pitch circle.
    pub pitch: Vec<f64>,
    /// Radial deviation of each lobe in m, outwards.
    pub radial: Vec<f64>,
    /// Standard deviation of the residuals, in m.
    pub rest: f64,
    /// Number of points.
    pub points: usize,
    /// Number of unknowns, less the reduction by the smoothness penalty.
    pub freedom: f64,
}

/// Number of harmonics of the meshing angle in the part common to all lobes: largest, and smallest if there are
/// enough points.
const MOST: usize = 40;
const LEAST: usize = 2;
/// Smallest weight of the curvature penalty relative to all points (it reduces the wave of order 10 by 10⁻³,
/// and that of order 40 by a fifth, if the points resolve them), and number of weights tried, each √10 times
/// the previous one.
const LEAST_SMOOTHNESS: f64 = 5e-8;
const SMOOTHNESSES: usize = 11;
/// Orders of radial deviation and pitch around the disc.
const ORDERS: usize = 3;
/// Orders of the profile around the disc.
const PROFILE: std::ops::RangeInclusive<usize> = 4..=8;

impl FlankSplit {
    /// Depth common to all lobes at the meshing angle φ, in m.
    pub fn common_depth(&self, phi: f64) -> f64 {
        self.modification
            .iter()
            .enumerate()
            .map(|(i, c)| match i {
                0 => *c,
                i if i % 2 == 1 => c * (i.div_ceil(2) as f64 * phi).cos(),
                i => c * ((i / 2) as f64 * phi).sin(),
            })
            .sum()
    }

    /// The part common to all lobes as harmonics around the disc, with the mean depth as order 0.
    pub fn common_harmonics(&self, lobes: usize) -> Vec<FlankHarmonic> {
        let mean = FlankHarmonic {
            order: 0,
            amplitude: self.modification[0],
            phase: 0.0,
            direction: FlankDirection::Normal,
        };
        let wave = |k: usize| {
            let (order, cos, sin) = (k * lobes, self.modification[2 * k - 1], self.modification[2 * k]);
            // φ = −z_c τ: c cos kφ + s sin kφ = A cos(k z_c (τ − phase)).
            let phase = wrap_angle((-sin).atan2(cos)) / order as f64;
            FlankHarmonic { order, amplitude: cos.hypot(sin), phase, direction: FlankDirection::Normal }
        };
        std::iter::once(mean).chain((1..=self.modification.len() / 2).map(wave)).collect()
    }

    /// Smallest and largest depth common to all lobes, in m.
    pub fn common_range(&self) -> (f64, f64) {
        Relief::grid(720)
            .map(|phi| self.common_depth(phi))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), depth| (low.min(depth), high.max(depth)))
    }

    /// Standard deviation of the common depth due to the noise of the points, in m.
    pub fn common_noise(&self) -> f64 {
        self.rest * (self.freedom / self.points as f64).sqrt()
    }

    /// Total cumulative pitch deviation F_p, largest single pitch deviation f_p, and radial run-out F_r, in
    /// m.
    pub fn pitch_and_run_out(&self) -> (f64, f64, f64) {
        let span = |values: &[f64]| {
            let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            high - values.iter().copied().fold(f64::INFINITY, f64::min)
        };
        let count = self.pitch.len();
        let single =
            (0..count).map(|k| (self.pitch[(k + 1) % count] - self.pitch[k]).abs()).fold(0.0, f64::max);
        (span(&self.pitch), single, span(&self.radial))
    }
}

/// Least-squares decomposition of depths over τ into the part common to all lobes (harmonics of the meshing
/// angle), radial deviation and pitch (orders 1 to 3 around the disc), and profile (orders 4 to 8); then the
/// pitch and the radial deviation of every lobe from the common part. `None` if there are too few points.
///
/// The common part has forty harmonics, fewer for few points, because at roots a flank may change within some
/// degrees. A penalty on the square of its second derivative keeps it smooth. The weight is found by
/// generalised cross-validation (Golub, Heath, Wahba, Technometrics 21, 1979), so that the curve follows the
/// points as closely as their noise allows and does not oscillate between points that are far apart on every
/// lobe.
///
/// Radial deviation and pitch are distinguished by the flank's normal, whose inclination differs between the
/// two flanks of a lobe; a profile deviation of lower order cannot be distinguished from the two together.
pub(super) fn split(profile: &Profile, depths: &[(f64, f64)]) -> Option<FlankSplit> {
    let lobes = profile.lobe_count();
    if depths.len() < 4 * lobes {
        return None;
    }
    // Three unknowns need nine points; there are at most twenty-two unknowns around the disc.
    let affordable = (depths.len() / 3).saturating_sub(1 + 4 * ORDERS + 2 * PROFILE.count()) / 2;
    let resolved = affordable.min(MOST);
    if resolved < LEAST {
        return None;
    }
    let orders = ORDERS.min((lobes - 1) / 2);
    let profile_orders: Vec<usize> = PROFILE.filter(|order| 2 * order < lobes).collect();
    let width = 1 + 2 * resolved + 4 * orders + 2 * profile_orders.len();
    if depths.len() < 3 * width {
        return None;
    }
    let row = |tau: f64| -> Vec<f64> {
        let phi = profile.meshing_angle(tau);
        let normal = profile.outward_normal(tau);
        let (inwards, around) = (normal.dot(&unit(tau)), -cross(unit(tau), normal));
        let mut row = vec![1.0];
        for k in 1..=resolved {
            let (sin, cos) = (k as f64 * phi).sin_cos();
            row.extend([cos, sin]);
        }
        for order in 1..=orders {
            let (sin, cos) = (order as f64 * tau).sin_cos();
            row.extend([inwards * cos, inwards * sin, around * cos, around * sin]);
        }
        for order in &profile_orders {
            let (sin, cos) = (*order as f64 * tau).sin_cos();
            row.extend([cos, sin]);
        }
        row
    };
    let mut matrix = DMatrix::<f64>::zeros(width, width);
    let mut load = DVector::<f64>::zeros(width);
    for (tau, depth) in depths {
        let row = DVector::from_vec(row(*tau));
        matrix.ger(1.0, &row, &row, 1.0);
        load.axpy(*depth, &row, 1.0);
    }
    let square: f64 = depths.iter().map(|(_, depth)| depth * depth).sum();
    let count = depths.len() as f64;
    let mut best: Option<(f64, f64, DVector<f64>)> = None;
    for step in 0..SMOOTHNESSES {
        let smoothness = LEAST_SMOOTHNESS * 10f64.powf(0.5 * step as f64);
        let mut stiff = matrix.clone();
        for k in 1..=resolved {
            let bend = smoothness * count * (k as f64).powi(4);
            stiff[(2 * k - 1, 2 * k - 1)] += bend;
            stiff[(2 * k, 2 * k)] += bend;
        }
        let Some(factors) = stiff.cholesky() else { continue };
        let solution = factors.solve(&load);
        let freedom = factors.solve(&matrix).trace();
        let off = square - 2.0 * solution.dot(&load) + solution.dot(&(&matrix * &solution));
        let score = off.max(0.0) / (1.0 - freedom / count).powi(2);
        if best.as_ref().is_none_or(|(least, _, _)| score < *least) {
            best = Some((score, freedom, solution));
        }
    }
    let (_, freedom, solution) = best?;
    let common = 1 + 2 * resolved;
    let mut harmonics = Vec::new();
    let mut harmonic = |order: usize, at: usize, direction| {
        let (cos, sin) = (solution[at], solution[at + 1]);
        let phase = wrap_angle(sin.atan2(cos)) / order as f64;
        harmonics.push(FlankHarmonic { order, amplitude: cos.hypot(sin), phase, direction });
    };
    for order in 1..=orders {
        harmonic(order, common + 4 * (order - 1), FlankDirection::Inwards);
        harmonic(order, common + 4 * (order - 1) + 2, FlankDirection::Around);
    }
    for (index, order) in profile_orders.iter().enumerate() {
        harmonic(*order, common + 4 * orders + 2 * index, FlankDirection::Normal);
    }
    let mut off = 0.0;
    // For each lobe: depth − common = −(radial n·e + pitch n·e′), by a least-squares problem of two unknowns.
    let mut sums = vec![[0.0_f64; 5]; lobes];
    for (tau, depth) in depths {
        let row = row(*tau);
        let fitted: f64 = row.iter().zip(solution.iter()).map(|(a, b)| a * b).sum();
        off += (depth - fitted).powi(2);
        let shared: f64 = row[..common].iter().zip(solution.iter()).map(|(a, b)| a * b).sum();
        let normal = profile.outward_normal(*tau);
        let (radial, around) = (normal.dot(&unit(*tau)), cross(unit(*tau), normal));
        // A lobe extends from root to root.
        let lobe = ((tau * lobes as f64 / TAU).floor() as usize).min(lobes - 1);
        let value = shared - depth;
        let s = &mut sums[lobe];
        s[0] += radial * radial;
        s[1] += radial * around;
        s[2] += around * around;
        s[3] += radial * value;
        s[4] += around * value;
    }
    let mut pitch = Vec::with_capacity(lobes);
    let mut radial = Vec::with_capacity(lobes);
    for [a, b, c, x, y] in sums {
        let determinant = a * c - b * b;
        if !(determinant > 1e-6 * a * c) {
            return None;
        }
        radial.push((c * x - b * y) / determinant);
        pitch.push((a * y - b * x) / determinant);
    }
    let mean = pitch.iter().sum::<f64>() / lobes as f64;
    pitch.iter_mut().for_each(|p| *p -= mean);
    let rest = (off / (count - freedom)).sqrt();
    Some(FlankSplit {
        harmonics,
        modification: solution.iter().take(common).copied().collect(),
        pitch,
        radial,
        rest,
        points: depths.len(),
        freedom,
    })
}
