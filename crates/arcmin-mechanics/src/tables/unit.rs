//! Units of columns.

/// Dimension of a unit; columns are converted within one dimension only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dimension {
    Length,
    Angle,
    AngularSpeed,
    AngularAcceleration,
    Time,
    Force,
    Torque,
    Pressure,
    Current,
    Mass,
    Temperature,
    Power,
    Share,
}

/// A unit: its suffix in a key (`torque_n_m`), its form in brackets (`torque [N·m]`), its size in SI.
#[derive(Debug)]
pub(super) struct Unit {
    pub dimension: Dimension,
    pub endings: &'static [&'static str],
    pub written: &'static [&'static str],
    pub size: f64,
}

use crate::units::{ARCMIN, ARCSEC, DEG, RPM};
use Dimension::*;
use std::f64::consts::TAU;

const fn unit(
    dimension: Dimension,
    endings: &'static [&'static str],
    written: &'static [&'static str],
    size: f64,
) -> Unit {
    Unit { dimension, endings, written, size }
}

/// Bracketed forms are compared with case: `mN` and `MN` differ by nine powers of ten.
const UNITS: &[Unit] = &[
    unit(Length, &["m"], &["m"], 1.0),
    unit(Length, &["mm"], &["mm"], 1e-3),
    unit(Length, &["um"], &["um", "µm", "μm"], 1e-6),
    unit(Angle, &["rad"], &["rad"], 1.0),
    unit(Angle, &["mrad"], &["mrad"], 1e-3),
    unit(Angle, &["deg", "degree", "degrees"], &["°", "Grad", "º"], DEG),
    unit(Angle, &["arcmin"], &["arcmin", "'", "′"], ARCMIN),
    unit(Angle, &["arcsec"], &["arcsec", "″"], ARCSEC),
    unit(Angle, &["turns", "turn", "rev", "revs"], &["U"], TAU),
    unit(AngularSpeed, &["rad_s", "rad_per_s"], &["rad/s", "rad*s^-1", "rad s^-1"], 1.0),
    unit(AngularSpeed, &["deg_s", "deg_per_s"], &["deg/s", "°/s", "º/s", "Grad/s", "degrees/s"], DEG),
    unit(
        AngularSpeed,
        &["rpm", "rev_min", "rev_per_min"],
        &["1/min", "min-1", "min^-1", "min⁻¹", "U/min", "r/min", "rev/min"],
        RPM,
    ),
    unit(
        AngularSpeed,
        &["rev_s", "rev_per_s", "turns_s", "turns_per_s", "rps"],
        &["rev/s", "U/s", "r/s"],
        TAU,
    ),
    unit(AngularAcceleration, &["rad_s2", "rad_per_s2"], &["rad/s2", "rad/s²"], 1.0),
    unit(Time, &["s", "sec", "seconds"], &["Sekunden"], 1.0),
    unit(Time, &["ms"], &["ms"], 1e-3),
    unit(Time, &["us"], &["µs", "μs"], 1e-6),
    unit(Time, &["ns"], &[], 1e-9),
    unit(Time, &["100ns"], &["100 ns"], 1e-7),
    unit(Time, &["min"], &["min"], 60.0),
    unit(Time, &["h", "hours"], &["h"], 3600.0),
    unit(Force, &["n"], &["N"], 1.0),
    unit(Force, &["kn"], &["kN"], 1e3),
    unit(Torque, &["n_m", "nm"], &["N·m", "N⋅m", "Nm", "N m", "N.m", "N*m", "N-m"], 1.0),
    unit(Torque, &["n_mm", "nmm"], &["N·mm", "Nmm", "N mm"], 1e-3),
    unit(Torque, &["mn_m"], &["mN·m", "mNm"], 1e-3),
    unit(Torque, &["kn_m", "knm"], &["kN·m", "kNm"], 1e3),
    unit(Pressure, &["pa"], &["Pa"], 1.0),
    unit(Pressure, &["mpa"], &["MPa", "N/mm2", "N/mm²"], 1e6),
    unit(Pressure, &["gpa"], &["GPa"], 1e9),
    unit(Current, &["a", "arms"], &["A", "Arms", "A_rms"], 1.0),
    unit(Current, &["ma"], &["mA"], 1e-3),
    unit(Mass, &["kg"], &["kg"], 1.0),
    unit(Mass, &["g"], &["g"], 1e-3),
    unit(Temperature, &["degc"], &["°C", "degC"], 1.0),
    unit(Power, &["w"], &["W"], 1.0),
    unit(Power, &["kw"], &["kW"], 1e3),
    unit(Share, &["percent"], &["%"], 1e-2),
];

/// The unit with the suffix `text` of a key, such as `n_m`.
pub(super) fn by_ending(text: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|unit| unit.endings.contains(&text))
}

/// The unit written `text` in brackets.
pub(super) fn by_writing(text: &str) -> Option<&'static Unit> {
    let ending = || by_ending(text).or_else(|| unit_in_capitals(text));
    UNITS.iter().find(|unit| unit.written.contains(&text)).or_else(ending)
}

/// `RPM`, `Deg`: suffixes of three letters or more, whose case does not change the prefix.
fn unit_in_capitals(text: &str) -> Option<&'static Unit> {
    let small = text.to_lowercase();
    if small.len() < 3 || small.starts_with('m') { None } else { by_ending(&small) }
}

/// The unit in a field of a row of units: `Nm`, `[Nm]`, `(s)`, `Nm (Torque)`.
pub(super) fn of_field(field: &str) -> Option<&'static str> {
    let field = field.trim();
    let inside = field.strip_prefix(['[', '(']).and_then(|field| field.strip_suffix([']', ')']));
    let before = || field.split_once(" (").map(|(before, _)| before.trim());
    [inside.map(str::trim), Some(field), before()]
        .into_iter()
        .flatten()
        .find_map(by_writing)
        .map(|unit| unit.endings[0])
}

/// Splits a key into quantity and unit: (`input_speed`, rad/s) of `input_speed_rad_s`.
pub(super) fn split(key: &str) -> (&str, Option<&'static Unit>) {
    // The longest suffix is used: `_n_m` is not metre.
    let starts = key.match_indices('_').map(|(at, _)| at);
    for at in starts {
        if let Some(unit) = by_ending(&key[at + 1..]) {
            return (&key[..at], Some(unit));
        }
    }
    (key, None)
}

/// Suffixes of the same dimension, for a remedy.
pub(super) fn endings_of(dimension: Dimension) -> String {
    let all: Vec<String> = UNITS
        .iter()
        .filter(|unit| unit.dimension == dimension)
        .map(|unit| format!("_{}", unit.endings[0]))
        .collect();
    all.join(", ")
}
