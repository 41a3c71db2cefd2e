//! The fitted values in the form of the design file.

use crate::analyses::stage::AnyDesign;
use crate::design::Value;
use crate::units::HOUR;
use crate::wear::Exposure;

/// Keys that give the coefficient; a design has one of them.
const OTHER_KEYS: [&str; 6] = [
    "coefficient_mm2_per_n",
    "archard_coefficient",
    "hardness_mpa",
    "after_h",
    "depth_um",
    "lost_motion_arcmin",
];

/// The design with the coefficient, comments kept; `None` if the value is out of the range of its key.
pub(super) fn into_design(design: &AnyDesign, law: &Exposure, with_running_in: bool) -> Option<AnyDesign> {
    let mut changes =
        vec![("wear.coupled.coefficient_per_pa".to_owned(), Value::Number(to_digits(law.coefficient)))];
    let written = |path: &str| design.get(path).is_ok_and(|value| value != Value::LeftOut);
    for key in OTHER_KEYS.map(|key| format!("wear.coupled.{key}")).into_iter().filter(|path| written(path)) {
        changes.insert(0, (key, Value::LeftOut));
    }
    if let Some(running_in) = law.running_in.filter(|_| with_running_in) {
        changes.push(("wear.running_in.factor".to_owned(), Value::Number(to_digits(running_in.factor))));
        let hours = to_digits(running_in.duration / HOUR);
        changes.push(("wear.running_in.duration_h".to_owned(), Value::Number(hours)));
    }
    design.with_all(changes).ok()
}

/// The sections of the design file, in place of those that it has.
pub(super) fn sections(law: &Exposure, with_running_in: bool) -> String {
    let k = law.coefficient;
    let mut text = format!(
        "# In place of these sections of the design file; calibrated.toml is the whole file with them.\n\
         [wear.coupled]\ncoefficient_per_pa = {:e}  # {:.3e} mm²/N",
        to_digits(k),
        1e6 * k
    );
    if let Some(running_in) = law.running_in.filter(|_| with_running_in) {
        text.push_str(&format!(
            "\n\n[wear.running_in]\nfactor = {}\nduration_h = {}",
            to_digits(running_in.factor),
            to_digits(running_in.duration / HOUR)
        ));
    }
    text
}

/// Rounds to five digits, more than the accuracy of any of these values.
fn to_digits(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}
