//! The log as a heat map.

use super::merge::Sample;
use crate::report::{Axis, HeatMap, Scale, Width};
use crate::units::RPM;

/// Share of the time in motion as a function of output speed and torque, both signed.
pub(super) fn picture(samples: &[Sample], moving: f64) -> HeatMap {
    const COLUMNS: usize = 41;
    const ROWS: usize = 41;
    let reach = |f: fn(&Sample) -> f64| samples.iter().map(|s| f(s).abs()).fold(0.0, f64::max).max(1e-12);
    let (speed, torque) = (reach(|s| s.speed), reach(|s| s.torque));
    // With an odd number, zero is in the middle of a cell.
    let cell = |value: f64, reach: f64, count: usize| {
        (((value / reach + 1.0) * 0.5 * (count - 1) as f64).round() as usize).min(count - 1)
    };
    let mut shares = vec![0.0; COLUMNS * ROWS];
    for s in samples {
        shares[cell(s.torque, torque, ROWS) * COLUMNS + cell(s.speed, speed, COLUMNS)] += s.time / moving;
    }
    let values = |reach: f64, count: usize| -> Vec<f64> {
        (0..count).map(|i| reach * (2.0 * i as f64 / (count - 1) as f64 - 1.0)).collect()
    };
    HeatMap {
        title: "Time in motion over speed and torque".to_owned(),
        x: Axis::new("output speed", "rpm"),
        y: Axis::new("output torque", "N·m"),
        value: Axis { scale: Scale::Log, ..Axis::new("share of the time in motion", "%") },
        x_values: values(speed / RPM, COLUMNS),
        y_values: values(torque, ROWS),
        cells: shares.into_iter().map(|share| (share > 0.0).then_some(100.0 * share)).collect(),
        note:
            "A torque is positive against positive motion; where both have the same sign, the joint drives."
                .to_owned(),
        width: Width::Full,
    }
}
