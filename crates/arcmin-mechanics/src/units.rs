//! Conversion factors for input and output. Internally all values are in SI units: metre, newton, second,
//! radian, pascal.

/// Metres per millimetre.
pub const MM: f64 = 1e-3;
/// Metres per micrometre.
pub const UM: f64 = 1e-6;
/// Pascals per megapascal.
pub const MPA: f64 = 1e6;
/// Seconds per hour.
pub const HOUR: f64 = 3600.0;
/// Radians per degree.
pub const DEG: f64 = std::f64::consts::PI / 180.0;
/// Radians per minute of arc.
pub const ARCMIN: f64 = DEG / 60.0;
/// Radians per second of arc.
pub const ARCSEC: f64 = ARCMIN / 60.0;
/// Radians per second in one revolution per minute.
pub const RPM: f64 = std::f64::consts::PI / 30.0;

/// Wraps an angle into (−π, π].
#[inline]
pub fn wrap_angle(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    // Rounding by truncation: `round` is a function call on the baseline instruction set, and this is in the
    // innermost loop.
    let turns = angle * (1.0 / turn);
    let wrapped = angle - turn * (turns + 0.5_f64.copysign(turns)) as i64 as f64;
    if wrapped <= -std::f64::consts::PI { wrapped + turn } else { wrapped }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn wrapping_keeps_the_half_open_interval() {
        assert_eq!(wrap_angle(PI), PI);
        assert_eq!(wrap_angle(-PI), PI);
        assert!((wrap_angle(7.0 * PI + 0.25) - (0.25 - PI)).abs() < 1e-12);
    }
}
