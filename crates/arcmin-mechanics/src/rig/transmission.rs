use std::f64::consts::TAU;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::RigError;
use super::settle::run;
use crate::dynamics::{BearingJoints, JointSettings, Reducer};
use crate::machine::Machine;
use crate::progress::{Progress, Silent};

/// Settings for the transmission error of one output turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransmissionSettings {
    /// Positions over the turn.
    pub positions: usize,
    /// Torque in N·m that keeps the flanks in contact in the no-load test.
    pub holding_torque: f64,
}

impl TransmissionSettings {
    /// A torque of 1 % of the rated one keeps the flanks in contact; 1024 positions resolve orders up to
    /// several times the number of pins.
    pub fn new(machine: &Machine) -> TransmissionSettings {
        TransmissionSettings { positions: 1024, holding_torque: 0.01 * machine.rated.torque.abs() }
    }
}

/// Transmission error over one output turn at low speed.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorCurve {
    /// Sense of rotation, +1 or −1.
    pub direction: f64,
    /// Torque in N·m against the motion.
    pub torque: f64,
    /// (nominal output angle, θ_out − θ_s/i) in rad, in the order of the test; the last point is one turn after
    /// the first.
    pub points: Vec<(f64, f64)>,
    /// Largest force (N) and pressure (Pa) of the pins, if they are evaluated.
    pub pins: Option<PinLoads>,
}

/// Largest loads of all pins over a turn.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PinLoads {
    /// Force in N.
    pub force: f64,
    /// Hertz pressure in Pa.
    pub pressure: f64,
}

impl ErrorCurve {
    /// Mean over the turn in rad; first and last point count as one.
    pub fn mean(&self) -> f64 {
        let n = self.points.len().saturating_sub(1).max(1);
        self.points.iter().take(n).map(|p| p.1).sum::<f64>() / n as f64
    }

    /// Largest minus smallest error, rad.
    pub fn peak_to_peak(&self) -> f64 {
        let fold = |start: f64, pick: fn(f64, f64) -> f64| self.points.iter().map(|p| p.1).fold(start, pick);
        fold(f64::NEG_INFINITY, f64::max) - fold(f64::INFINITY, f64::min)
    }
}

/// The transmission error over one output turn of `positions` steps in the direction ±1 with a torque (N·m)
/// against the motion.
///
/// # Errors
/// [`RigError`] where no equilibrium is found.
pub fn error_curve(
    machine: &Machine,
    settings: &JointSettings,
    positions: usize,
    direction: f64,
    torque: f64,
) -> Result<ErrorCurve, RigError> {
    // Without progress reports the curve cannot be cancelled.
    let case = Case { direction, torque, with_pin_loads: false };
    let whole = error_curve_until(machine, settings, positions, case, &mut || false)?;
    whole.ok_or(RigError::BadCurve("it was stopped"))
}

/// Conditions of one curve.
#[derive(Debug, Clone, Copy)]
struct Case {
    /// Sense of rotation, +1 or −1.
    direction: f64,
    /// Torque in N·m against the motion.
    torque: f64,
    /// Whether the loads of the pins are evaluated.
    with_pin_loads: bool,
}

/// [`error_curve`]; `None` as soon as `stops`, called before every position, returns true.
fn error_curve_until(
    machine: &Machine,
    settings: &JointSettings,
    positions: usize,
    Case { direction, torque, with_pin_loads }: Case,
    stops: &mut dyn FnMut() -> bool,
) -> Result<Option<ErrorCurve>, RigError> {
    let settings = JointSettings { damped: false, ..settings.clone() };
    let mut model = BearingJoints::held(machine, &settings)?;
    let ratio = model.kinematics().ratio();
    let speed = direction * ratio.signum() * machine.rated.input_speed.abs();
    // In the frame of its carrier, a machine without errors repeats its state after one turn of the crankshafts
    // relative to the carrier; with errors, the discs meet the same pins after one turn of the crankshafts in
    // space.
    let nominal_machine = settings.errors.is_zero();
    let kinematics = model.kinematics();
    let repeats = if nominal_machine { kinematics.pin_count } else { kinematics.lobe_count };
    let mut before = Before::new(positions as f64 / repeats);
    let mut points = Vec::with_capacity(positions + 1);
    let mut pins = with_pin_loads.then(PinLoads::default);
    for i in 0..=positions {
        if stops() {
            return Ok(None);
        }
        let output = direction * TAU * i as f64 / positions as f64;
        let sun = ratio * output;
        model.hold_sun(sun, speed);
        let nominal = model.nominal_position_at(sun);
        let velocity = model.nominal_velocity_at(sun, speed);
        let carrier = if nominal_machine { model.carrier_angle_at(sun) } else { 0.0 };
        let deviation = |model: &BearingJoints, q: &[f64]| -> Vec<f64> {
            let mut deviation: Vec<f64> = q.iter().zip(&nominal).map(|(q, n)| q - n).collect();
            model.rotate_displacements(&mut deviation, -carrier);
            deviation
        };
        if before.is_empty() {
            // Contacts are closed at the larger one of rated torque and `torque` first.
            model.set_load(direction * machine.rated.torque.abs().max(torque));
            let q = run(&model, &nominal, velocity.clone())?;
            before.push(deviation(&model, &q));
        }
        model.set_load(direction * torque);
        let mut start = before.next();
        model.rotate_displacements(&mut start, carrier);
        start.iter_mut().zip(&nominal).for_each(|(q, n)| *q += n);
        let q = run(&model, &start, velocity.clone())?;
        if let Some(PinLoads { force, pressure }) = &mut pins {
            let here = model.forces(0.0, &q, &velocity);
            *force = force.max(here.largest_pin_force);
            *pressure = pressure.max(here.largest_pin_pressure);
        }
        points.push((output, model.output_error(&q)));
        before.push(deviation(&model, &q));
    }
    Ok(Some(ErrorCurve { direction, torque, points, pins }))
}

/// Deviations from the nominal position at the previous positions, in the frame of the carrier.
struct Before {
    /// Number of positions after which the state repeats.
    period: f64,
    deviations: Vec<Vec<f64>>,
    /// The number of positions back that is nearest to a whole number of periods, and its distance from it in
    /// positions.
    whole: (usize, f64),
}

/// Two positions whose distance differs from whole periods by less than this (in positions) have similar
/// states; one position is two or three pins.
const SIMILAR_PHASE: f64 = 0.15;

impl Before {
    fn new(period: f64) -> Before {
        Before { period, deviations: Vec::new(), whole: (0, SIMILAR_PHASE) }
    }

    fn is_empty(&self) -> bool {
        self.deviations.is_empty()
    }

    fn push(&mut self, deviation: Vec<f64>) {
        let back = self.deviations.len();
        if back > 0 {
            let periods = back as f64 / self.period;
            let off = (periods - periods.round()).abs() * self.period;
            if off < self.whole.1 * (1.0 - 1e-9) {
                self.whole = (back, off);
            }
        }
        self.deviations.push(deviation);
    }

    /// Prediction of the next position: the one after the similar earlier position, shifted by the difference
    /// between the last position and that earlier one. A pin passes within less than a position, so that
    /// interpolation between positions is inaccurate; it is used only until a computed position is at whole
    /// periods within the tolerance.
    fn next(&self) -> Vec<f64> {
        let last = self.deviations.len() - 1;
        let now = &self.deviations[last];
        let predicted = |then: &[f64], next: &[f64]| -> Vec<f64> {
            now.iter().zip(next.iter().zip(then)).map(|(now, (next, then))| next + (now - then)).collect()
        };
        if let (back @ 1.., _) = self.whole {
            return predicted(&self.deviations[last - back], &self.deviations[last + 1 - back]);
        }
        match (self.at(last as f64 - self.period), self.at((last + 1) as f64 - self.period)) {
            (Some(then), Some(next)) => predicted(&then, &next),
            _ => now.clone(),
        }
    }

    /// Interpolation between positions by a cubic through the four nearest ones.
    fn at(&self, place: f64) -> Option<Vec<f64>> {
        let first = (place.floor() - 1.0).min(self.deviations.len() as f64 - 4.0);
        if first < 0.0 {
            return None;
        }
        let x = place - first;
        let weights = [0.0, 1.0, 2.0, 3.0].map(|i| {
            [0.0, 1.0, 2.0, 3.0].iter().filter(|j| **j != i).map(|j| (x - j) / (i - j)).product::<f64>()
        });
        let rows = &self.deviations[first as usize..first as usize + 4];
        let sum = |k: usize| weights.iter().zip(rows).map(|(weight, row)| weight * row[k]).sum();
        Some((0..rows[0].len()).map(sum).collect())
    }
}

/// Transmission error of one output turn in both directions, at light load and at rated torque: four curves,
/// light load first.
///
/// # Errors
/// [`RigError`] where no equilibrium is found.
pub fn transmission_error_curves(
    machine: &Machine,
    settings: &JointSettings,
    test: TransmissionSettings,
) -> Result<Vec<ErrorCurve>, RigError> {
    let curves = error_curves_with_progress(machine, settings, test, (Curves::Every, false), &Silent)?;
    curves.ok_or(RigError::BadCurve("it was stopped"))
}

/// Which transmission errors the bench measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Curves {
    /// None.
    Nothing,
    /// Forward at rated torque only.
    Rated,
    /// Forward, at light load and at rated torque.
    Forward,
    /// Forward and backward at light load, forward and backward at rated torque.
    Every,
}

/// [`transmission_error_curves`], or a part of them; `pins` selects the loads of the pins forward at rated
/// torque. `None` when `progress` was cancelled.
pub(super) fn error_curves_with_progress(
    machine: &Machine,
    settings: &JointSettings,
    test: TransmissionSettings,
    (curves, pins): (Curves, bool),
    progress: &dyn Progress,
) -> Result<Option<Vec<ErrorCurve>>, RigError> {
    use rayon::prelude::*;
    let rated = machine.rated.torque.abs();
    let under = |torque, direction| Case { direction, torque, with_pin_loads: false };
    let [held, held_back] = [1.0, -1.0].map(|direction| under(test.holding_torque, direction));
    let (forward, backward) = (Case { with_pin_loads: pins, ..under(rated, 1.0) }, under(rated, -1.0));
    let cases = match curves {
        Curves::Nothing => Vec::new(),
        Curves::Rated => vec![forward],
        Curves::Forward => vec![held, forward],
        Curves::Every => vec![held, held_back, forward, backward],
    };
    let done = AtomicUsize::new(0);
    let whole = (cases.len() * (test.positions + 1)) as f64;
    cases
        .into_par_iter()
        .map(|case| {
            error_curve_until(machine, settings, test.positions, case, &mut || {
                let share = done.fetch_add(1, Ordering::Relaxed) as f64 / whole;
                progress.report("transmission error", share);
                progress.is_cancelled()
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values with a period that is not a whole number of positions and a drift: the prediction is far better
    /// than the last value. Within the first period the prediction is the last value.
    #[test]
    fn periodic_values_are_predicted() {
        let (period, drift) = (26.256, 0.003);
        let wave = |i: usize| (std::f64::consts::TAU * i as f64 / period).sin();
        let mut before = Before::new(period);
        let (mut far, mut last) = (0.0_f64, 0.0_f64);
        for i in 0..100 {
            let here = [wave(i) + drift * i as f64, 2.0 * wave(i + 5)];
            if i > 0 {
                let next = before.next();
                if i < 27 {
                    assert_eq!(next[0], wave(i - 1) + drift * (i - 1) as f64);
                } else if i > 31 {
                    far = far.max((next[0] - here[0]).abs()).max((next[1] - here[1]).abs());
                    last = last.max((here[0] - (wave(i - 1) + drift * (i - 1) as f64)).abs());
                }
            }
            before.push(here.to_vec());
        }
        assert!(far < 5e-4 && last > 0.2, "{far} {last}");
    }
}
