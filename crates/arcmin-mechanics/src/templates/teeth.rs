//! Teeth of the gear stage of a scaled machine.

use super::ScaleError;

/// Numbers of teeth of sun and planet for a ratio and a number of pins: with clearance between the planets, a
/// number of sun teeth divisible by that of the planets if possible, and a sum near the template's.
pub(super) fn teeth(ratio: f64, pins: f64, sum: f64, cranks: f64) -> Result<(u32, u32), ScaleError> {
    /// Clearance between the tips of neighbouring planets, as a part of their distance.
    const APART: f64 = 0.985;
    let wanted = (ratio - 1.0) / pins;
    let mut best: Option<((u32, u32), f64)> = None;
    let (mut nearest, mut touching) = ((f64::INFINITY, 0.0), false);
    for sun in 8..=60_u32 {
        let planet = (wanted * f64::from(sun)).round();
        if !(8.0..=400.0).contains(&planet) {
            continue;
        }
        let found = 1.0 + pins * planet / f64::from(sun);
        let error = (found / ratio - 1.0).abs();
        if error < nearest.0 {
            nearest = (error, found);
        }
        // Ratios are given with few digits; a design file has the same tolerance.
        if !(error < 4e-4) {
            continue;
        }
        if (planet + 2.0) / (f64::from(sun) + planet) > APART * (std::f64::consts::PI / cranks).sin() {
            touching = true;
            continue;
        }
        let matched = if f64::from(sun) % cranks == 0.0 { 0.0 } else { 40.0 };
        let cost = (f64::from(sun) + planet - sum).abs() + matched;
        if best.is_none_or(|(_, least)| cost < least) {
            best = Some(((sun, planet as u32), cost));
        }
    }
    match best {
        Some((pair, _)) => Ok(pair),
        None if touching => Err(ScaleError::Planets { ratio, cranks }),
        None => Err(ScaleError::Teeth { ratio, pins, nearest: nearest.1 }),
    }
}
