//! A rate-independent model of wind-up and hysteresis, fitted to loops of the test bench.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use crate::rig::{Branch, LoopPoint};

/// Torsion curve in three linear sections, as in catalogues: dead band, then K₁ up to T₁, K₂ up to T₂, K₃
/// beyond.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TorsionCurve {
    /// Half of the dead band in rad, zero or more.
    pub half_gap_rad: f64,
    /// T₁ and T₂ in N·m.
    pub torques_n_m: [f64; 2],
    /// K₁, K₂, K₃ in N·m/rad, not decreasing.
    pub stiffness_n_m_per_rad: [f64; 3],
    /// Residual of the fit in the mean of both branches, root mean square, rad.
    pub residual_rad: f64,
}

impl TorsionCurve {
    /// Least squares on the mid-line of a loop between `low` (fraction of the largest torque below which the
    /// flanks may not be in contact, and at which lost motion is defined) and the largest torque. T₁ and T₂ are
    /// those of a grid with the smallest residual; only stiffening curves are accepted. `None` for a loop with
    /// too few points.
    pub fn fit(points: &[LoopPoint], rated: f64, low: f64) -> Option<TorsionCurve> {
        TorsionCurve::of_line(&mid_line(points, rated, low), rated)
    }

    fn of_line(line: &[(f64, [f64; 2])], rated: f64) -> Option<TorsionCurve> {
        let line: Vec<(f64, f64)> = line.iter().map(|(t, [up, down])| (*t, 0.5 * (up + down))).collect();
        if line.len() < 6 {
            return None;
        }
        let mut best: Option<TorsionCurve> = None;
        for first in 1..16 {
            for second in first + 1..20 {
                let at = [f64::from(first) * 0.05 * rated, f64::from(second) * 0.05 * rated];
                for pieces in [1, 2, 3] {
                    let Some(curve) = TorsionCurve::through(&line, at, pieces, None) else { continue };
                    if best.is_none_or(|best| curve.residual_rad < best.residual_rad * (1.0 - 1e-9)) {
                        best = Some(curve);
                    }
                }
            }
        }
        best
    }

    /// With given corners and number of different stiffnesses, and half of a dead band (rad) or the best one;
    /// `None` if the curve does not stiffen.
    fn through(
        line: &[(f64, f64)],
        at: [f64; 2],
        pieces: usize,
        half_gap: Option<f64>,
    ) -> Option<TorsionCurve> {
        let mut straight = Straight::through(line, at, pieces, half_gap)?;
        if straight.offset < 0.0 {
            // Preloaded: no dead band, and the curve passes through zero.
            straight = Straight::through(line, at, pieces, Some(0.0))?;
        }
        straight.stiffens().then(|| TorsionCurve {
            half_gap_rad: straight.offset,
            torques_n_m: at,
            stiffness_n_m_per_rad: straight.compliance.map(|c| 1.0 / c),
            residual_rad: straight.left,
        })
    }

    /// Wind-up in rad at T₁ and T₂, including the dead band.
    pub fn corners(&self) -> [f64; 2] {
        let [k1, k2, _] = self.stiffness_n_m_per_rad;
        let first = self.half_gap_rad + self.torques_n_m[0] / k1;
        [first, first + (self.torques_n_m[1] - self.torques_n_m[0]) / k2]
    }

    /// Torque in N·m at a wind-up in rad.
    pub fn torque(&self, wind_up: f64) -> f64 {
        let [k1, k2, k3] = self.stiffness_n_m_per_rad;
        let [first, second] = self.corners();
        let x = wind_up.abs();
        let size = k1 * (x - self.half_gap_rad).max(0.0)
            + (k2 - k1) * (x - first).max(0.0)
            + (k3 - k2) * (x - second).max(0.0);
        size.copysign(wind_up)
    }

    /// Elastic energy in J at a wind-up in rad.
    pub fn energy(&self, wind_up: f64) -> f64 {
        let [k1, k2, k3] = self.stiffness_n_m_per_rad;
        let [first, second] = self.corners();
        let beyond = |from: f64| (wind_up.abs() - from).max(0.0).powi(2);
        0.5 * (k1 * beyond(self.half_gap_rad) + (k2 - k1) * beyond(first) + (k3 - k2) * beyond(second))
    }

    /// dT/dφ in N·m/rad; 0 inside the dead band.
    pub fn slope(&self, wind_up: f64) -> f64 {
        let [first, second] = self.corners();
        let x = wind_up.abs();
        let piece = if x > second {
            2
        } else if x > first {
            1
        } else if x > self.half_gap_rad {
            0
        } else {
            return 0.0;
        };
        self.stiffness_n_m_per_rad[piece]
    }
}

/// Least-squares fit by linear sections between given corners, without constraints of sign.
struct Straight {
    /// Angle in rad extrapolated to zero torque.
    offset: f64,
    /// Compliance in rad/(N·m) of each section.
    compliance: [f64; 3],
    /// Residual, root mean square, rad.
    left: f64,
}

impl Straight {
    /// With a number of different compliances, and a given offset or the best one.
    fn through(line: &[(f64, f64)], at: [f64; 2], pieces: usize, offset: Option<f64>) -> Option<Straight> {
        let limits = [at[0], at[1], f64::INFINITY];
        let length = |torque: f64, piece: usize| {
            let from = if piece == 0 { 0.0 } else { limits[piece - 1] };
            (torque.min(limits[piece]) - from).max(0.0)
        };
        // Sections beyond the last different one have its stiffness.
        let group = |piece: usize| piece.min(pieces - 1);
        let free = usize::from(offset.is_none());
        let matrix = DMatrix::from_fn(line.len(), pieces + free, |row, column| {
            if column < free {
                1.0
            } else {
                (0..3).filter(|p| group(*p) == column - free).map(|p| length(line[row].0, p)).sum()
            }
        });
        let given = offset.unwrap_or(0.0);
        let angles = DVector::from_iterator(line.len(), line.iter().map(|point| point.1 - given));
        // The first torque is the one at which lost motion is defined: its weight equals that of all others
        // together.
        let mut weighted = matrix.clone();
        weighted.row_mut(0).scale_mut(line.len() as f64);
        let solution = (weighted.transpose() * &matrix).lu().solve(&(weighted.transpose() * &angles))?;
        Some(Straight {
            offset: offset.unwrap_or(solution[0]),
            compliance: [0, 1, 2].map(|piece| solution[free + group(piece)]),
            left: (&matrix * &solution - &angles).norm() / (line.len() as f64).sqrt(),
        })
    }

    fn stiffens(&self) -> bool {
        let [c1, c2, c3] = self.compliance;
        c3 > 0.0 && c1 >= c2 && c2 >= c3
    }
}

/// (torque, angle for positive and for negative torque) of the mean of both branches, for torques from `low` ×
/// rated; all values are positive if the wind-up has the sign of the torque.
fn mid_line(points: &[LoopPoint], rated: f64, low: f64) -> Vec<(f64, [f64; 2])> {
    let of = |branch: Branch, torque: f64| {
        points.iter().find(|p| p.branch == branch && p.torque == torque).map(|p| p.angle)
    };
    let mut line: Vec<(f64, [f64; 2])> = points
        .iter()
        .filter(|p| p.branch == Branch::Falling && p.torque >= low * rated * (1.0 - 1e-9))
        .filter_map(|p| {
            let up = of(Branch::Falling, p.torque)? + of(Branch::Rising, p.torque)?;
            let down = of(Branch::Falling, -p.torque)? + of(Branch::Rising, -p.torque)?;
            Some((p.torque, [0.5 * up, -0.5 * down]))
        })
        .collect();
    line.sort_by(|a, b| a.0.total_cmp(&b.0));
    line
}

/// A spring with a slider: it sticks, then slips.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SlipElement {
    /// Wind-up in rad from the middle of its range at which it slips.
    pub slip_rad: f64,
    /// Torque in N·m at which it slips, without load.
    pub torque_n_m: f64,
    /// Increase of that torque per N·m of elastic torque.
    pub torque_per_load: f64,
}

impl SlipElement {
    /// Torque in N·m at which it slips under an elastic torque in N·m.
    pub fn torque(&self, elastic: f64) -> f64 {
        self.torque_n_m + self.torque_per_load * elastic.abs()
    }
}

/// Maxwell-slip model: T = G(φ) + Σ (a_j + b_j |G(φ)|) z_j, where G is the torsion curve of the side of φ, and
/// each z_j follows φ/d_j but is limited to ±1. It is rate-independent, and its loops close after every
/// reversal (return-point memory).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hysteresis {
    /// The mean of both sides, as in catalogues.
    pub curve: TorsionCurve,
    /// Middle of the dead band in rad; not 0 if the wear of the two sides differs.
    pub zero_rad: f64,
    /// Torsion curves for positive and for negative torque, relative to that middle; corners and dead band are
    /// those of the mean.
    pub sides: [TorsionCurve; 2],
    /// Elements of the hysteresis, in the order of their slip distances d_j.
    pub elements: Vec<SlipElement>,
    /// Residual of the model in the loop's torque at its angles, root mean square, N·m.
    pub residual_rms_n_m: f64,
    /// The same residual, largest, N·m.
    pub residual_max_n_m: f64,
    /// The same outside of the dead band as an angle, rad.
    pub residual_rms_rad: f64,
}

/// Largest and smallest slip relative to the elastic wind-up at rated torque, and their number.
const LARGEST_SLIP: f64 = 0.12;
const SMALLEST_SLIP: f64 = 0.004;
const ELEMENTS: usize = 6;
/// Number of fits, each to the line as corrected after the one before. The one with the smallest residual is taken: since
/// corners lie on a grid, the residual does not decrease every time.
const FITS: usize = 6;
/// Sweeps of the non-negative least squares; its matrix has a dozen columns.
const SWEEPS: usize = 4000;

impl Hysteresis {
    /// Fits a loop from + to − rated torque and back: the torsion curve of its mid-line, and the torques of slip
    /// elements on a grid of slips by non-negative least squares.
    ///
    /// Near the tips both branches meet, so that the mid-line of the loop is not the elastic curve. The mid-line of the
    /// model's own loop deviates from it in the same way: this deviation is subtracted from the line, and the fit is repeated.
    pub fn fit(points: &[LoopPoint], rated: f64, low: f64) -> Option<Hysteresis> {
        let measured = mid_line(points, rated, low);
        let mut line = measured.clone();
        let mut best: Option<Hysteresis> = None;
        for _ in 0..FITS {
            // A corrected line may no longer stiffen.
            let Some(model) = Hysteresis::about(&line, points, rated) else { break };
            let own = mid_line(&model.loop_at(points), rated, low);
            for ((line, measured), own) in line.iter_mut().zip(&measured).zip(&own) {
                (0..2).for_each(|side| line.1[side] += measured.1[side] - own.1[side]);
            }
            if best.as_ref().is_none_or(|best| model.residual_rms_n_m < best.residual_rms_n_m) {
                best = Some(model);
            }
        }
        best
    }

    /// With the torsion curve of a line (torque, angle for positive and for negative torque).
    fn about(line: &[(f64, [f64; 2])], points: &[LoopPoint], rated: f64) -> Option<Hysteresis> {
        let curve = TorsionCurve::of_line(line, rated)?;
        let (zero, sides) = sides(line, &curve)?;
        let elastic_turn = curve.corners()[1] - curve.half_gap_rad
            + (rated - curve.torques_n_m[1]).max(0.0) / curve.stiffness_n_m_per_rad[2];
        let step = (SMALLEST_SLIP / LARGEST_SLIP).powf(1.0 / (ELEMENTS - 1) as f64);
        let slips: Vec<f64> =
            (0..ELEMENTS).map(|j| elastic_turn * LARGEST_SLIP * step.powi(j as i32)).collect();
        // Two cycles of the loop: after the first the state does not depend on the initial one.
        let mut states = vec![0.0; slips.len()];
        let mut last = points.first()?.angle;
        let mut rows = Vec::with_capacity(points.len());
        for turn in 0..2 {
            for point in points {
                for (state, slip) in states.iter_mut().zip(&slips) {
                    *state = (*state + (point.angle - last) / slip).clamp(-1.0, 1.0);
                }
                last = point.angle;
                if turn == 1 {
                    rows.push(states.clone());
                }
            }
        }
        let mut model = Hysteresis {
            curve,
            zero_rad: zero,
            sides,
            elements: Vec::new(),
            residual_rms_n_m: 0.0,
            residual_max_n_m: 0.0,
            residual_rms_rad: 0.0,
        };
        let elastic: Vec<f64> = points.iter().map(|p| model.elastic(p.angle)).collect();
        let target: Vec<f64> = points.iter().zip(&elastic).map(|(p, g)| p.torque - g).collect();
        let columns: Vec<Vec<f64>> = (0..2 * slips.len())
            .map(|c| {
                let j = c / 2;
                let load = |row: usize| if c % 2 == 0 { 1.0 } else { elastic[row].abs() / rated };
                rows.iter().enumerate().map(|(row, states)| load(row) * states[j]).collect()
            })
            .collect();
        // If both branches are equal, the residual of the torsion curve is not hysteresis.
        let weights = match has_width(points, elastic_turn) {
            true => non_negative(&columns, &target),
            false => vec![0.0; columns.len()],
        };
        let left: Vec<f64> = (0..target.len())
            .map(|row| target[row] - columns.iter().zip(&weights).map(|(c, w)| c[row] * w).sum::<f64>())
            .collect();
        let rms =
            |values: &[f64]| (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt();
        let angles: Vec<f64> = points
            .iter()
            .zip(&left)
            .filter_map(|(p, left)| match model.slope(p.angle) {
                0.0 => None,
                slope => Some(left / slope),
            })
            .collect();
        model.elements = slips
            .iter()
            .zip(weights.chunks(2))
            .map(|(slip, pair)| SlipElement {
                slip_rad: *slip,
                torque_n_m: pair[0],
                torque_per_load: pair[1] / rated,
            })
            .collect();
        model.residual_rms_n_m = rms(&left);
        model.residual_max_n_m = left.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        model.residual_rms_rad = rms(&angles);
        Some(model)
    }

    /// The torsion curve of the side to which a wind-up in rad belongs.
    fn side(&self, wind_up: f64) -> &TorsionCurve {
        &self.sides[usize::from(wind_up < self.zero_rad)]
    }

    /// Torque in N·m of the torsion curves alone at a wind-up in rad.
    pub fn elastic(&self, wind_up: f64) -> f64 {
        self.side(wind_up).torque(wind_up - self.zero_rad)
    }

    /// Elastic energy in J at a wind-up in rad, without that of slip elements.
    pub fn energy(&self, wind_up: f64) -> f64 {
        self.side(wind_up).energy(wind_up - self.zero_rad)
    }

    /// Stiffness in N·m/rad of the torsion curves at a wind-up in rad; 0 inside the dead band.
    pub fn slope(&self, wind_up: f64) -> f64 {
        self.side(wind_up).slope(wind_up - self.zero_rad)
    }

    /// Ends of the dead band, wind-up in rad.
    pub fn dead_band(&self) -> [f64; 2] {
        [-1.0, 1.0].map(|side| self.zero_rad + side * self.curve.half_gap_rad)
    }

    /// Largest stiffness in N·m/rad of the torsion curves.
    pub fn stiffest(&self) -> f64 {
        self.sides.iter().map(|side| side.stiffness_n_m_per_rad[2]).fold(0.0, f64::max)
    }

    /// Stiffness in N·m/rad immediately after a reversal under an elastic torque (N·m): that of the stiffest section
    /// and of all elements, which stick.
    pub fn stuck_stiffness(&self, elastic: f64) -> f64 {
        let stuck = self.elements.iter().map(|element| element.torque(elastic) / element.slip_rad);
        self.stiffest() + stuck.sum::<f64>()
    }

    /// Torque in N·m at a wind-up (rad) with the elements in these states.
    pub fn torque(&self, wind_up: f64, states: &[f64]) -> f64 {
        let elastic = self.elastic(wind_up);
        elastic + self.slip_torque(elastic, states)
    }

    /// Torque of the elements in N·m at this elastic torque (N·m).
    pub fn slip_torque(&self, elastic: f64, states: &[f64]) -> f64 {
        self.elements.iter().zip(states).map(|(element, z)| element.torque(elastic) * z).sum()
    }

    /// Updates the states for a change of wind-up in rad.
    pub fn follow(&self, states: &mut [f64], change: f64) {
        for (state, element) in states.iter_mut().zip(&self.elements) {
            *state = (*state + change / element.slip_rad).clamp(-1.0, 1.0);
        }
    }

    /// Total torque of the elements in N·m without load.
    pub fn friction_torque(&self) -> f64 {
        self.elements.iter().map(|element| element.torque_n_m).sum()
    }

    /// The quasi-static loop of the model at given torques: the wind-up at which the model has the torque
    /// (bisection; the torque does not decrease with the wind-up).
    pub fn loop_at(&self, points: &[LoopPoint]) -> Vec<LoopPoint> {
        let mut states = vec![0.0; self.elements.len()];
        let mut angle = 0.0;
        let mut run = |torque: f64| {
            let reach = self.reach(torque.abs());
            let (mut low, mut high) = (-reach, reach);
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                let mut moved = states.clone();
                self.follow(&mut moved, middle - angle);
                if self.torque(middle, &moved) < torque { low = middle } else { high = middle }
            }
            let next = 0.5 * (low + high);
            self.follow(&mut states, next - angle);
            angle = next;
            next
        };
        for point in points {
            run(point.torque);
        }
        points.iter().map(|p| LoopPoint { angle: run(p.torque), ..*p }).collect()
    }

    /// A wind-up at which the model has more than this torque (N·m), and at whose opposite it has less than its
    /// negative.
    pub fn reach(&self, torque: f64) -> f64 {
        let all = torque + 2.0 * self.friction_torque();
        let slips: f64 = self.elements.iter().map(|element| element.slip_rad).sum();
        let softest =
            self.sides.iter().map(|side| side.stiffness_n_m_per_rad[0]).fold(f64::INFINITY, f64::min);
        self.zero_rad.abs() + self.curve.half_gap_rad + all / softest * 1.5 + slips
    }
}

/// Fraction of the elastic wind-up at rated torque below which two branches count as equal.
const SAME: f64 = 1e-9;

/// Whether the branches of a loop differ anywhere, relative to its elastic wind-up in rad.
fn has_width(points: &[LoopPoint], elastic: f64) -> bool {
    let falling = points.iter().filter(|p| p.branch == Branch::Falling);
    let rising = points.iter().filter(|p| p.branch == Branch::Rising).rev();
    falling.zip(rising).any(|(a, b)| a.torque != b.torque || (a.angle - b.angle).abs() > SAME * elastic)
}

/// The middle between both sides, and the curve of each relative to it, with dead band and corners of the mean;
/// if a side does not stiffen at these corners, with fewer sections.
fn sides(line: &[(f64, [f64; 2])], mean: &TorsionCurve) -> Option<(f64, [TorsionCurve; 2])> {
    let of = |side: usize, from: f64| -> Vec<(f64, f64)> {
        line.iter().map(|(torque, angles)| (*torque, angles[side] - from)).collect()
    };
    let offset = |side: usize| {
        let line = of(side, 0.0);
        let fits = |pieces: &usize| Straight::through(&line, mean.torques_n_m, *pieces, None);
        let straight = [3, 2, 1].iter().filter_map(fits).find(Straight::stiffens)?;
        Some(straight.offset)
    };
    let zero = 0.5 * (offset(0)? - offset(1)?);
    let curve = |side: usize| {
        let line = of(side, if side == 0 { zero } else { -zero });
        let fit = |pieces| TorsionCurve::through(&line, mean.torques_n_m, pieces, Some(mean.half_gap_rad));
        [3, 2, 1].into_iter().find_map(fit)
    };
    Some((zero, [curve(0)?, curve(1)?]))
}

/// min |A w − b| with w ≥ 0, one weight at a time (the matrix is small, and no step increases the residual).
pub(super) fn non_negative(columns: &[Vec<f64>], target: &[f64]) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let squares: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
    let mut weights = vec![0.0; columns.len()];
    let mut left = target.to_vec();
    for _ in 0..SWEEPS {
        for (c, column) in columns.iter().enumerate() {
            if squares[c] <= 0.0 {
                continue;
            }
            let new = f64::max(0.0, weights[c] + dot(column, &left) / squares[c]);
            let change = new - weights[c];
            if change != 0.0 {
                left.iter_mut().zip(column).for_each(|(l, x)| *l -= change * x);
                weights[c] = new;
            }
        }
    }
    weights
}
