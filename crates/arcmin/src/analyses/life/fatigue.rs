//! Fatigue of flanks and pins by their Hertz pressure.

use super::demands::Demands;
use crate::machine::DutyPoint;
use crate::units::HOUR;

/// Number of passes at the endurance pressure.
const ENDURANCE_PASSES: f64 = 5e7;
/// Slopes of the life factor Z_NT of ISO 6336-2 for steels without allowed pitting: from 1.6 at 10⁵ passes to 1 at
/// 5·10⁷, and from there to 0.85 at 10¹⁰.
const STEEP: f64 = 13.222_5;
const FLAT: f64 = 32.601_0;

/// Number of passes to failure at a pressure, N = 5·10⁷ (p_e/p)^m, with m = ln 500/ln 1.6 above the endurance
/// pressure p_e and m = ln 200/ln(1/0.85) below it.
pub(super) fn passes_borne(pressure: f64, endurance: f64) -> f64 {
    let slope = if pressure > endurance { STEEP } else { FLAT };
    ENDURANCE_PASSES * (endurance / pressure).powf(slope)
}

/// Damage per hour by Palmgren and Miner, for the largest pressure at rated torque. In line contact the pressure
/// follows the root of the force, and the force the torque; a flank has one pass at the torque of the duty per turn
/// of the crankshafts relative to the disc, a pin slightly fewer.
pub(super) fn damage_per_hour(demands: &Demands, pressure: f64, endurance: f64) -> f64 {
    let of_row = |row: &DutyPoint| {
        let at_row = pressure * (row.torque / demands.rated_torque).abs().sqrt();
        let passes = row.share * demands.passes_per_second(row) * HOUR;
        if at_row > 0.0 { passes / passes_borne(at_row, endurance) } else { 0.0 }
    };
    demands.duty.iter().map(of_row).sum()
}

/// Damage at the end of a history of (hours, largest pressure in Pa at rated torque), and the hours at which it
/// is 1: beyond the history at its last rate, up to `searched` hours.
pub(super) fn fatigue(
    demands: &Demands,
    history: &[(f64, f64)],
    endurance: f64,
    searched: f64,
) -> (f64, Option<f64>) {
    let rates: Vec<(f64, f64)> = history
        .iter()
        .map(|(hours, pressure)| (*hours, damage_per_hour(demands, *pressure, endurance)))
        .collect();
    let mut damage = 0.0;
    let mut reached = None;
    for pair in rates.windows(2) {
        let ((from, rate), (to, next)) = (pair[0], pair[1]);
        let grown = 0.5 * (rate + next) * (to - from);
        if reached.is_none() && damage + grown >= 1.0 {
            reached = Some(from + (to - from) * (1.0 - damage) / grown);
        }
        damage += grown;
    }
    let beyond = rates.last().map(|(hours, rate)| hours + (1.0 - damage) / rate);
    (damage, reached.or(beyond.filter(|hours| *hours <= searched)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::MPA;

    /// The endurance pressure for 5·10⁷ passes, 1.6 times as much for 10⁵, 0.85 of it for 10¹⁰.
    #[test]
    fn life_factors_are_those_of_the_standard() {
        for (factor, passes) in [(1.0, 5e7), (1.6, 1e5), (0.85, 1e10)] {
            assert!((passes_borne(factor * 1500.0, 1500.0) / passes - 1.0).abs() < 1e-4, "{factor}");
        }
    }

    /// 44 444 passes an hour at the endurance pressure: 5·10⁷ of them take 1125 h, half the torque 2^(32.6/2)
    /// times as long.
    #[test]
    fn constant_pressure_has_a_closed_form() {
        let mut demands = Demands::of(&crate::templates::tao2024());
        let pressure = 1500.0 * MPA;
        let history = [(0.0, pressure), (500.0, pressure), (2000.0, pressure)];
        let (damage, hours) = fatigue(&demands, &history, pressure, 1e4);
        assert!(
            (hours.unwrap() / 1125.0 - 1.0).abs() < 1e-3 && (damage - 2000.0 / 1125.0).abs() < 2e-3,
            "{hours:?}"
        );
        let short = fatigue(&demands, &history[..2], pressure, 1e4).1;
        assert!((short.unwrap() / 1125.0 - 1.0).abs() < 1e-3, "{short:?}");
        demands.duty[0].torque *= 0.5;
        let (half, none) = fatigue(&demands, &history, pressure, 1e4);
        assert!((damage / half / 2.0_f64.powf(0.5 * FLAT) - 1.0).abs() < 1e-9 && none.is_none());
    }
}
