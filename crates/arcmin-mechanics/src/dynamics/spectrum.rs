use std::f64::consts::TAU;

use rustfft::algorithm::Radix4;
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftDirection};

/// Amplitude of one order of the output rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectrumLine {
    /// Waves per turn of the output.
    pub order: usize,
    /// Amplitude of the wave in rad.
    pub amplitude: f64,
}

/// Spectrum of a transmission error in orders of the output rotation, from pairs (nominal output angle, error)
/// in rad: the amplitudes of [`OrderWaves`] in rad.
pub fn order_spectrum(samples: &[(f64, f64)]) -> Option<Vec<SpectrumLine>> {
    OrderWaves::of(samples).map(|waves| waves.lines())
}

/// Fourier components of a transmission error over a turn of the output.
#[derive(Debug, Clone)]
pub struct OrderWaves {
    /// Transform of the mean turn.
    turn: Vec<Complex64>,
    /// Samples over all turns.
    count: usize,
}

impl OrderWaves {
    /// From pairs (nominal output angle, error) in rad.
    ///
    /// The error is resampled at equal steps of the nominal output angle θ_s/i (cubic Lagrange interpolation),
    /// over the last whole number of turns. `None` if the samples cover less than one turn or the angle does
    /// not change.
    pub fn of(samples: &[(f64, f64)]) -> Option<OrderWaves> {
        let (first, last) = (samples.first()?, samples.last()?);
        let direction = (last.0 - first.0).signum();
        // Rounding must not exclude a run of exactly one turn.
        let turns = ((last.0 - first.0).abs() / TAU + 1e-9).floor();
        if !(turns >= 1.0) || samples.windows(2).any(|pair| (pair[1].0 - pair[0].0) * direction <= 0.0) {
            return None;
        }
        let angles: Vec<f64> = samples.iter().map(|s| direction * s.0).collect();
        let start = angles[angles.len() - 1] - turns * TAU;
        let per_turn = ((samples.len() as f64 / turns) as usize).next_power_of_two().clamp(1024, 1 << 16);
        let count = per_turn * turns as usize;
        // Whole orders are the components that all turns have in common: their transform is that of the mean
        // turn.
        let mut turn = vec![Complex64::default(); per_turn];
        let mut cell = 0;
        for i in 0..count {
            let angle = start + TAU * i as f64 / per_turn as f64;
            while cell + 1 < angles.len() && angles[cell + 1] <= angle {
                cell += 1;
            }
            turn[i % per_turn].re += lagrange(&angles, samples, cell, angle);
        }
        // The number of samples per turn is a power of two, so that the radix-4 transform is sufficient; a
        // planner for any length would be a sixth of the library's code.
        Radix4::new(per_turn, FftDirection::Forward).process(&mut turn);
        Some(OrderWaves { turn, count })
    }

    /// Amplitudes in rad by order.
    pub fn lines(&self) -> Vec<SpectrumLine> {
        let half = &self.turn[..self.turn.len() / 2];
        let line = |(order, line): (usize, &Complex64)| {
            let scale = if order == 0 { 1.0 } else { 2.0 } / self.count as f64;
            SpectrumLine { order, amplitude: scale * line.norm() }
        };
        half.iter().enumerate().map(line).collect()
    }

    /// Peak to peak value over a turn of the sum of some orders, in rad.
    pub fn peak_to_peak(&self, orders: &[usize]) -> f64 {
        let mut turn = vec![Complex64::default(); self.turn.len()];
        for order in orders {
            turn[*order] = self.turn[*order] * (2.0 / self.count as f64);
        }
        Radix4::new(turn.len(), FftDirection::Inverse).process(&mut turn);
        let (low, high) = turn
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z.re), high.max(z.re)));
        high - low
    }
}

fn lagrange(angles: &[f64], samples: &[(f64, f64)], cell: usize, angle: f64) -> f64 {
    let left = cell.saturating_sub(1).min(angles.len().saturating_sub(4));
    let nodes = left..(left + 4).min(angles.len());
    nodes
        .clone()
        .map(|i| {
            let weight: f64 = nodes
                .clone()
                .filter(|j| *j != i)
                .map(|j| (angle - angles[j]) / (angles[i] - angles[j]))
                .product();
            weight * samples[i].1
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_are_found_at_their_order_for_either_direction() {
        for direction in [1.0, -1.0] {
            // 1.7 turns, sampled nonuniformly: the spectrum uses the last whole turn.
            let samples: Vec<(f64, f64)> = (0..20_000)
                .map(|i| {
                    let x = i as f64 / 20_000.0;
                    let angle = 1.7 * TAU * (x + 0.02 * (TAU * x).sin());
                    (direction * angle, 0.3 + 2e-4 * (39.0 * angle).sin() + 1e-4 * (80.0 * angle).cos())
                })
                .collect();
            let lines = order_spectrum(&samples).unwrap();
            assert!((lines[0].amplitude - 0.3).abs() < 1e-9);
            assert!((lines[39].amplitude - 2e-4).abs() < 1e-9);
            assert!((lines[80].amplitude - 1e-4).abs() < 1e-9);
            assert!(lines.iter().filter(|l| ![0, 39, 80].contains(&l.order)).all(|l| l.amplitude < 1e-9));
        }
    }

    #[test]
    fn less_than_a_turn_has_no_spectrum() {
        let samples: Vec<(f64, f64)> = (0..1000).map(|i| (i as f64 * 6e-3, 0.0)).collect();
        assert!(order_spectrum(&samples).is_none());
        assert!(order_spectrum(&[]).is_none());
    }
}
