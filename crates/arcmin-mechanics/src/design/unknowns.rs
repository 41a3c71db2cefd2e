//! Uncertain values: keys of the design with their ranges.

use super::consistency::contradiction;
use super::edit::look_up;
use super::error::Source;
use super::field::Result;
use super::hint::plain;
use super::path;
use super::schema::{Key, Kind, SectionSchema};
use super::tree::Branch;
use super::variation::{Distribution, Variation, Variations, Varied};

/// An uncertain value of the design.
#[derive(Debug, Clone, PartialEq)]
pub struct Unknown {
    /// Path of the key.
    pub path: String,
    /// Its unit, empty if dimensionless.
    pub unit: &'static str,
    /// Value in the design.
    pub nominal: f64,
    /// Variation as the design file gives it.
    pub variation: Variation,
    /// Range of the value.
    pub distribution: Distribution,
}

impl Unknown {
    /// Whether the value of the design is in the range, up to rounding.
    pub fn covers_nominal(&self) -> bool {
        let [low, high] = self.distribution.bounds();
        let slack = 1e-12 * self.nominal.abs();
        self.nominal >= low - slack && self.nominal <= high + slack
    }
}

/// All unknowns of a design; each is a numeric key and varies within the range of the key. Those whose key has
/// no number in this design (such as a stiffness that is left out) are skipped.
pub(super) fn unknowns(
    given: &Variations,
    schema: &'static SectionSchema,
    tree: &Branch,
    source: &Source,
) -> Result<Vec<Unknown>> {
    given.0.iter().filter_map(|varied| unknown(varied, schema, tree, source).transpose()).collect()
}

fn unknown(
    varied: &Varied,
    schema: &'static SectionSchema,
    tree: &Branch,
    source: &Source,
) -> Result<Option<Unknown>> {
    let at = |message: String, hint: &str| contradiction(source, &Some(varied.span.clone()), message, hint);
    let path = &varied.path;
    let target = path::find(path, "", schema, source)
        .map_err(|error| source.error(error.kind, varied.path_span.clone(), error.hint))?;
    let numeric = matches!((target.key.kind)(), Kind::Number | Kind::Count) && !target.row;
    let nominal = match look_up(schema, Some(tree), &target.steps, true) {
        Ok(value) if numeric => value.as_number(),
        _ => None,
    };
    let Some(nominal) = nominal else {
        if !numeric {
            return Err(contradiction(
                source,
                &Some(varied.path_span.clone()),
                format!("`{path}` is not a number, so that it cannot be an unknown"),
                "name a key with a number",
            ));
        }
        return Ok(None);
    };
    let relative = matches!(varied.variation, Variation::Factor { .. });
    if relative && nominal == 0.0 {
        // A factor of a value of zero has no effect.
        return Ok(None);
    }
    let distribution = varied
        .variation
        .about(nominal)
        .map_err(|why| at(format!("the variation of `{path}` is not valid"), &why))?;
    let [low, high] = distribution.bounds();
    let Key { rule, .. } = target.key;
    let unit = target.key.unit();
    if low < rule.low || high > rule.high {
        if relative {
            return Ok(None);
        }
        let message =
            format!("`{path}` would vary from {} to {}, which is out of range", plain(low), plain(high));
        let space = if unit.is_empty() { "" } else { " " };
        return Err(at(
            message,
            &format!("the allowed range is {} to {}{space}{unit}", plain(rule.low), plain(rule.high)),
        ));
    }
    let variation = varied.variation.clone();
    Ok(Some(Unknown { path: path.clone(), unit, nominal, variation, distribution }))
}
