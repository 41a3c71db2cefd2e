//! What a measured flank deviates by: run-out, pitch, modification, profile.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};

use crate::geometry::{FlankDirection, FlankHarmonic, Profile, Relief, cross, unit};
use crate::units::wrap_angle;

/// Deviations of a flank, as depth of missing metal.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankSplit {
    /// Radial, cumulative pitch and profile, as harmonics around the disc.
    pub harmonics: Vec<FlankHarmonic>,
    /// What all lobes have in common: coefficients of 1, cos φ, sin φ, cos 2φ, … in m.
    pub modification: Vec<f64>,
    /// Cumulative pitch deviation of each lobe in m, counter-clockwise, on the pitch circle.
    pub pitch: Vec<f64>,
    /// Radial deviation of each lobe in m, outwards.
    pub radial: Vec<f64>,
    /// Standard deviation of what none of these explains, in m.
    pub rest: f64,
    /// Points that were split.
    pub points: usize,
}

/// Harmonics of the meshing angle in what all lobes have in common: at most, and at least where points allow.
const MOST: usize = 40;
const LEAST: usize = 2;
/// Orders of radial deviation and pitch around the disc.
const ORDERS: usize = 3;
/// Orders of the profile around the disc.
const PROFILE: std::ops::RangeInclusive<usize> = 4..=8;

impl FlankSplit {
    /// Depth that all lobes have in common at the meshing angle φ, in m.
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

    /// What all lobes have in common as harmonics around the disc, the mean depth as order 0.
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

    /// Least and largest depth that all lobes have in common, in m.
    pub fn common_range(&self) -> (f64, f64) {
        Relief::grid(720)
            .map(|phi| self.common_depth(phi))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), depth| (low.min(depth), high.max(depth)))
    }

    /// Standard deviation of the depth that all lobes have in common, in m, by the noise of the points.
    pub fn common_noise(&self) -> f64 {
        self.rest * (self.modification.len() as f64 / self.points as f64).sqrt()
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

/// Splits depths over τ by least squares into what all lobes share (harmonics of the meshing angle), radial
/// deviation and pitch (orders 1 to 3 around the disc), and profile (orders 4 to 8); then the pitch and the
/// radial deviation of every lobe from what is common to all. `None` if there are too few points.
///
/// As many harmonics are common as the points of all lobes resolve together and stand out of the noise, forty
/// at most: at roots a flank may change within some degrees.
///
/// Radial and pitch are told apart by the flank's normal, which leans to either side of a lobe; of lower
/// orders the profile cannot be told from both together.
pub(super) fn split(profile: &Profile, depths: &[(f64, f64)]) -> Option<FlankSplit> {
    let lobes = profile.lobe_count();
    if depths.len() < 4 * lobes {
        return None;
    }
    let mut places: Vec<f64> = depths.iter().map(|(tau, _)| profile.meshing_angle(*tau)).collect();
    places.sort_by(f64::total_cmp);
    let around = places[0] + TAU - places[places.len() - 1];
    let gap = places.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max);
    // Three unknowns need nine points; those around the disc are twenty-two at most.
    let affordable = (depths.len() / 3).saturating_sub(1 + 4 * ORDERS + 2 * PROFILE.count()) / 2;
    let resolved = ((0.8 * PI / gap) as usize).min(affordable).min(MOST);
    if resolved < LEAST {
        return None;
    }
    let all = split_with(profile, depths, resolved)?;
    let noise = 3.0 * all.rest * (2.0 / depths.len() as f64).sqrt();
    let size = |k: usize| all.modification[2 * k - 1].hypot(all.modification[2 * k]);
    let needed = (LEAST..=resolved).rev().find(|k| size(*k) > noise.max(NOTHING)).unwrap_or(LEAST);
    if needed == resolved { Some(all) } else { split_with(profile, depths, needed) }
}

/// Amplitude in m of which nobody takes notice.
const NOTHING: f64 = 5e-9;

fn split_with(profile: &Profile, depths: &[(f64, f64)], resolved: usize) -> Option<FlankSplit> {
    let lobes = profile.lobe_count();
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
    let solution = matrix.cholesky()?.solve(&load);
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
    let mut square = 0.0;
    // Per lobe: depth − common = −(radial n·e + pitch n·e′), by its own two-by-two least squares.
    let mut sums = vec![[0.0_f64; 5]; lobes];
    for (tau, depth) in depths {
        let row = row(*tau);
        let fitted: f64 = row.iter().zip(solution.iter()).map(|(a, b)| a * b).sum();
        square += (depth - fitted).powi(2);
        let shared: f64 = row[..common].iter().zip(solution.iter()).map(|(a, b)| a * b).sum();
        let normal = profile.outward_normal(*tau);
        let (radial, around) = (normal.dot(&unit(*tau)), cross(unit(*tau), normal));
        // A lobe reaches from root to root.
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
    let rest = (square / (depths.len() - width) as f64).sqrt();
    Some(FlankSplit {
        harmonics,
        modification: solution.iter().take(common).copied().collect(),
        pitch,
        radial,
        rest,
        points: depths.len(),
    })
}
