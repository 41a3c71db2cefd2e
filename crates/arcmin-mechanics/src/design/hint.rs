//! Remedies: the text to write instead.

use super::error::DesignErrorKind;
use super::schema::{Key, Kind, SectionSchema, UNIT_SUFFIXES, unit_suffix};

/// Error and hint for an unknown key of a section; `written` is its value.
pub(super) fn for_unknown_key(
    key: &str,
    written: &str,
    schema: &SectionSchema,
    root: &SectionSchema,
    title: &str,
) -> (DesignErrorKind, String) {
    let named = || key.to_owned();
    // A key without its unit: pin_radius = 3.
    if let Some(right) =
        schema.keys.iter().find(|known| unit_suffix(known.name).is_some_and(|(stem, _)| stem == key))
    {
        let unit = right.unit();
        let hint = format!(
            "units are part of the keys: write `{} = {written}` if {written} is in {unit}",
            right.name
        );
        return (DesignErrorKind::MissingUnit { key: named() }, hint);
    }
    // A key with another unit: pin_radius_m = 0.003.
    if let Some((stem, unit)) = unit_suffix(key)
        && let Some(right) = schema.keys.iter().find(|known| {
            known.name == stem
                || unit_suffix(known.name)
                    .is_some_and(|(known_stem, _)| known_stem == stem || known_stem == strip_all_units(key))
        })
    {
        let hint = match right.unit() {
            "" => format!("it has no unit here: write `{}`", right.name),
            right_unit => format!("convert the value from {unit} to {right_unit} and write `{}`", right.name),
        };
        return (DesignErrorKind::WrongUnit { key: named() }, hint);
    }
    let unknown = DesignErrorKind::UnknownKey { key: named(), section: title.to_owned() };
    let elsewhere = std::iter::once((String::new(), root))
        .chain(sections_of(root, ""))
        .find(|(_, section)| section.keys.iter().any(|known| known.name == key));
    let close = closest(key, schema.keys.iter().map(|known| known.name));
    // Part of a name: `torque` or `torque_n_m` for `rated_torque_n_m`.
    let stem = |name: &str| unit_suffix(name).map_or(name.to_owned(), |(stem, _)| stem.to_owned());
    let (word, mut longer) = (stem(key), schema.keys.iter().map(|known| known.name));
    let longer = longer.find(|name| stem(name).split('_').any(|part| part == word));
    let hint = match (close, elsewhere) {
        (None, None) if longer.is_some() => format!("did you mean `{}`?", longer.unwrap_or_default()),
        (None, Some((path, _))) if longer.is_some() => {
            format!("did you mean `{}`? `{key}` belongs to [{path}]", longer.unwrap_or_default())
        }
        (_, Some((path, _))) if path.is_empty() => {
            "it belongs to the top of the file, before the first section".to_owned()
        }
        (_, Some((path, _))) => format!("it belongs to [{path}]"),
        (Some(close), None) => format!("did you mean `{close}`?"),
        (None, None) => format!(
            "the keys here are {}",
            schema.keys.iter().map(|known| known.name).collect::<Vec<_>>().join(", ")
        ),
    };
    (unknown, hint)
}

/// Hint for a text such as `3 mm` or `3,0` in place of a number.
pub(super) fn for_number_in_words(key: &Key, text: &str) -> Option<String> {
    let text = text.trim();
    let end = text.find(|c: char| !(c.is_ascii_digit() || "+-.,".contains(c))).unwrap_or(text.len());
    let (digits, unit) = (text[..end].replace(',', "."), text[end..].trim());
    let number: f64 = digits.parse().ok()?;
    let wanted = key.unit();
    Some(match unit {
        "" => format!("write a decimal point: {} = {}", key.name, plain(number)),
        unit if unit == wanted || wanted.is_empty() => {
            format!("the unit is part of the key: {} = {}", key.name, plain(number))
        }
        unit => format!(
            "convert the value from {} to {wanted}, which is part of the key, and write the number alone",
            crate::tables::shown(unit)
        ),
    })
}

/// Hint for a value of another type: the type and range of the key.
pub(super) fn for_type(key: &Key) -> Option<String> {
    let (low, high) = (key.rule.low, key.rule.high);
    let unit = if key.unit().is_empty() { String::new() } else { format!(" {}", key.unit()) };
    let range = match (low.is_finite(), high.is_finite()) {
        (true, true) => format!(" from {} to {}{unit}", plain(low), plain(high)),
        (true, false) => format!(" of {}{unit} or more", plain(low)),
        (false, true) => format!(" of {}{unit} or less", plain(high)),
        (false, false) => String::new(),
    };
    match (key.kind)() {
        Kind::Count if high - low == 1.0 => {
            Some(format!("write {name} = {low} or {name} = {high}", name = key.name))
        }
        Kind::Count => Some(format!("write a whole number{range}")),
        Kind::Number => Some(format!("write a number{range}")),
        Kind::Flag => Some(format!("write {name} = true or {name} = false", name = key.name)),
        Kind::Text | Kind::File => Some(format!("write {} = \"…\"", key.name)),
        _ => None,
    }
}

/// Hint for a decimal comma, which TOML does not allow; `at` is where the reader stopped.
pub(super) fn for_syntax(text: &str, at: usize) -> Option<String> {
    let start = text.get(..at)?.rfind('\n').map_or(0, |newline| newline + 1);
    let line = text[start..].lines().next()?;
    let value = line.split_once('=')?.1.split('#').next()?.trim();
    let (whole, decimals) = value.split_once(',')?;
    let digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    let sign = whole.trim_start_matches(['+', '-']);
    (digits(sign) && digits(decimals)).then(|| format!("write a decimal point: {whole}.{decimals}"))
}

/// Hint for a number outside its range, often because of a wrong unit.
pub(super) fn for_number(key: &Key, number: f64) -> String {
    let (low, high) = (key.rule.low, key.rule.high);
    let unit = if key.unit().is_empty() { String::new() } else { format!(" {}", key.unit()) };
    let fits = |value: f64| value >= low && value <= high;
    let scaled = match key.unit() {
        "mm" => vec![("µm", 1e-3), ("m", 1e3)],
        "µm" => vec![("m", 1e6), ("mm", 1e3), ("nm", 1e-3)],
        "N·m" => vec![("N·mm", 1e-3), ("kN·m", 1e3)],
        "GPa" => vec![("MPa", 1e-3), ("Pa", 1e-9)],
        "MPa" => vec![("Pa", 1e-6), ("GPa", 1e3)],
        "g/cm³" => vec![("kg/m³", 1e-3)],
        "mm²/N" => vec![("1/Pa", 1e6)],
        "1/Pa" => vec![("mm²/N", 1e-6)],
        "N/µm" => vec![("N/m", 1e-6), ("N/mm", 1e-3)],
        "kg" => vec![("g", 1e-3)],
        "kg·m²" => vec![("kg·mm²", 1e-6), ("kg·cm²", 1e-4)],
        "" if key.name == "share" => vec![("percent", 1e-2)],
        "°" => vec![("rad", 180.0 / std::f64::consts::PI)],
        _ => Vec::new(),
    };
    let range = format!("the allowed range is {} to {}{unit}", plain(low), plain(high));
    match scaled.into_iter().find(|(_, factor)| number > 0.0 && fits(number * factor)) {
        Some((other, factor)) => {
            format!("{range}; if the value is in {other}, write {} = {}", key.name, plain(number * factor))
        }
        None => range,
    }
}

/// Hint for a word that is not among the choices.
pub(super) fn for_word<'a>(word: &str, choices: impl Iterator<Item = &'a str> + Clone) -> String {
    match closest(word, choices.clone()) {
        Some(close) => format!("did you mean \"{close}\"? The choices are {}", quoted(choices)),
        None => format!("the choices are {}", quoted(choices)),
    }
}

pub(super) fn quoted<'a>(words: impl Iterator<Item = &'a str>) -> String {
    words.map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ")
}

/// A number for readers: at most six digits, so that a converted value shows no rounding error.
pub(crate) fn plain(number: f64) -> String {
    let rounded: f64 = format!("{number:.5e}").parse().unwrap_or(number);
    match rounded.abs() {
        size if size != 0.0 && !(1e-4..1e7).contains(&size) => format!("{rounded:e}"),
        _ => format!("{rounded}"),
    }
}

/// All tables of the file with their dotted names.
fn sections_of(schema: &SectionSchema, path: &str) -> Vec<(String, &'static SectionSchema)> {
    let mut found = Vec::new();
    for key in schema.keys {
        if let Kind::Section(inner) | Kind::Sections(inner) = (key.kind)() {
            let path = super::field::join(path, key.name);
            found.push((path.clone(), inner));
            found.extend(sections_of(inner, &path));
        }
    }
    found
}

fn strip_all_units(key: &str) -> &str {
    UNIT_SUFFIXES.iter().find_map(|(suffix, _)| key.strip_suffix(suffix)).unwrap_or(key)
}

/// The nearest word, if the distance by insertions, deletions, replacements and swaps of neighbours is small
/// enough for a typing error.
pub(crate) fn closest<'a>(word: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (word.chars().count() / 3).clamp(1, 4);
    known
        .map(|candidate| (strsim::osa_distance(&word.to_lowercase(), &candidate.to_lowercase()), candidate))
        .filter(|near| near.0 <= limit)
        .min()
        .map(|near| near.1)
}
