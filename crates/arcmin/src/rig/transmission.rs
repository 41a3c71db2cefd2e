use std::f64::consts::TAU;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::RigError;
use super::settle::run;
use crate::dynamics::{BearingJoints, JointSettings};
use crate::machine::Machine;
use crate::progress::{Progress, Silent};

/// How one output turn is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransmissionSettings {
    /// Positions over the turn.
    pub positions: usize,
    /// Torque in N·m that holds the flanks in the no-load test.
    pub holding_torque: f64,
}

impl TransmissionSettings {
    /// 1 % of the rated torque holds the flanks; 1024 positions resolve orders up to several times the pin
    /// count.
    pub fn new(machine: &Machine) -> TransmissionSettings {
        TransmissionSettings { positions: 1024, holding_torque: 0.01 * machine.rated.torque.abs() }
    }
}

/// Transmission error over one output turn at low speed.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorCurve {
    /// +1 or −1: sense of rotation.
    pub direction: f64,
    /// N·m, against the motion.
    pub torque: f64,
    /// (nominal output angle, θ_out − θ_s/i) in rad, in the order of the test; the last closes the turn.
    pub points: Vec<(f64, f64)>,
}

impl ErrorCurve {
    /// A curve from a real bench: (output angle, error) in rad in the order of the test, at a torque (N·m).
    /// Its direction is that of the angles.
    ///
    /// # Errors
    /// [`RigError::BadCurve`] for fewer than eight points or angles that turn back.
    pub fn measured(points: Vec<(f64, f64)>, torque: f64) -> Result<ErrorCurve, RigError> {
        let (Some(first), Some(last)) = (points.first(), points.last()) else {
            return Err(RigError::BadCurve("it has no points"));
        };
        let direction = if last.0 >= first.0 { 1.0 } else { -1.0 };
        if points.len() < 8 {
            return Err(RigError::BadCurve("it has fewer than eight points"));
        }
        if points.windows(2).any(|pair| !((pair[1].0 - pair[0].0) * direction > 0.0)) {
            return Err(RigError::BadCurve("its output angles do not proceed in one direction"));
        }
        Ok(ErrorCurve { direction, torque, points })
    }

    pub fn mean(&self) -> f64 {
        let n = self.points.len().saturating_sub(1).max(1);
        self.points.iter().take(n).map(|p| p.1).sum::<f64>() / n as f64
    }

    pub fn peak_to_peak(&self) -> f64 {
        let fold = |start: f64, pick: fn(f64, f64) -> f64| self.points.iter().map(|p| p.1).fold(start, pick);
        fold(f64::NEG_INFINITY, f64::max) - fold(f64::INFINITY, f64::min)
    }
}

/// One output turn of `positions` steps in the direction ±1 with a torque (N·m) against the motion.
///
/// # Errors
/// [`RigError`] where a balance cannot be found.
pub fn error_curve(
    machine: &Machine,
    settings: &JointSettings,
    positions: usize,
    direction: f64,
    torque: f64,
) -> Result<ErrorCurve, RigError> {
    // Nobody stops a silent one.
    let whole = error_curve_until(machine, settings, positions, (direction, torque), &mut || false)?;
    whole.ok_or(RigError::BadCurve("it was stopped"))
}

/// [`error_curve`]; `None` where `stops`, asked before every place, says so.
fn error_curve_until(
    machine: &Machine,
    settings: &JointSettings,
    positions: usize,
    (direction, torque): (f64, f64),
    stops: &mut dyn FnMut() -> bool,
) -> Result<Option<ErrorCurve>, RigError> {
    let settings = JointSettings { damped: false, ..settings.clone() };
    let mut model = BearingJoints::held(machine, &settings)?;
    let ratio = model.kinematics().ratio();
    let speed = direction * ratio.signum() * machine.rated.input_speed.abs();
    // One turn of the crankshafts before, the same pins carried: the start is the balance of then, and as far from it
    // as the place before this one is from the place before that one.
    let per_turn = (positions as f64 / model.kinematics().lobe_count).round().max(1.0) as usize;
    let mut deviations: Vec<Vec<f64>> = Vec::with_capacity(positions + 2);
    let mut points = Vec::with_capacity(positions + 1);
    for i in 0..=positions {
        if stops() {
            return Ok(None);
        }
        let output = direction * TAU * i as f64 / positions as f64;
        let sun = ratio * output;
        model.hold_sun(sun, speed);
        let nominal = model.nominal_position_at(sun);
        let velocity = model.nominal_velocity_at(sun, speed);
        let deviation = |q: &[f64]| -> Vec<f64> { q.iter().zip(&nominal).map(|(q, n)| q - n).collect() };
        if deviations.is_empty() {
            // Into the flank with a good part of the load first.
            model.set_load(direction * machine.rated.torque.abs().max(torque));
            let q = run(&model, &nominal, velocity.clone())?;
            deviations.push(deviation(&q));
        }
        model.set_load(direction * torque);
        let last = deviations.len() - 1;
        let start: Vec<f64> = if last < per_turn {
            nominal.iter().zip(&deviations[last]).map(|(n, d)| n + d).collect()
        } else {
            let (now, then) = (&deviations[last], &deviations[last - per_turn]);
            let next = &deviations[last + 1 - per_turn];
            (0..nominal.len()).map(|j| nominal[j] + next[j] + (now[j] - then[j])).collect()
        };
        let q = run(&model, &start, velocity)?;
        points.push((output, model.output_error(&q)));
        deviations.push(deviation(&q));
    }
    Ok(Some(ErrorCurve { direction, torque, points }))
}

/// Transmission error of one output turn in both directions, held lightly and at rated torque: four curves in
/// that order.
///
/// # Errors
/// [`RigError`] where a balance cannot be found.
pub fn transmission_error_curves(
    machine: &Machine,
    settings: &JointSettings,
    test: TransmissionSettings,
) -> Result<Vec<ErrorCurve>, RigError> {
    let curves = watched_error_curves(machine, settings, test, true, &Silent)?;
    curves.ok_or(RigError::BadCurve("it was stopped"))
}

/// [`transmission_error_curves`], or forward at rated torque alone; `None` when `progress` was cancelled.
pub(super) fn watched_error_curves(
    machine: &Machine,
    settings: &JointSettings,
    test: TransmissionSettings,
    every_curve: bool,
    progress: &dyn Progress,
) -> Result<Option<Vec<ErrorCurve>>, RigError> {
    use rayon::prelude::*;
    let rated = machine.rated.torque.abs();
    let mut cases =
        vec![(1.0, test.holding_torque), (-1.0, test.holding_torque), (1.0, rated), (-1.0, rated)];
    cases.retain(|case| every_curve || *case == (1.0, rated));
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
