//! Keys of design files of any family, listed and changed by their text: what an editor of designs needs.

use super::edit::{Change, KeyEntry, list, no_row, no_value, set};
use super::error::Source;
use super::field::{self, SectionValue};
use super::path;
use super::schema::{Kind, SectionSchema};
use super::value::Value;
use super::{DesignError, DesignSections, Family, StageSections, TITLE, text};

fn schema(family: Family) -> &'static SectionSchema {
    match family {
        Family::Rv => DesignSections::schema(),
        Family::Eccentric => StageSections::schema(),
    }
}

/// As [`Design::keys`](super::Design::keys), of a file of any family; `file_name` only serves messages.
///
/// # Errors
/// What is not TOML.
pub fn keys(text: &str, file_name: &str) -> Result<Vec<KeyEntry>, Box<DesignError>> {
    let tree = field::parse(&Source { text, file_name, title: TITLE })?;
    let mut out = Vec::new();
    list(schema(Family::of(&tree)), Some(&tree), true, "", &mut out);
    Ok(out)
}

/// The text of a design file of any family with one key set, comments and layout kept. Whether the new text is a design
/// is for its reader to say.
///
/// ```
/// let text = arcmin::templates::NEMA17_19.text;
/// let wider = arcmin::design::with_key(text, "nema17-19.toml", "disc.width_mm", 6.0.into())?;
/// assert!(wider.contains("width_mm = 6\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// What is not TOML; a path that leads to no value, with the nearest one as hint.
pub fn with_key(
    file_text: &str,
    file_name: &str,
    path: &str,
    value: Value,
) -> Result<String, Box<DesignError>> {
    let source = Source { text: file_text, file_name, title: TITLE };
    let mut tree = field::parse(&source)?;
    let target = path::find(path, &value.to_string(), schema(Family::of(&tree)), &source)?;
    let node = value.node();
    if node.is_some() && (target.row || !target.is_value()) {
        let hint = format!("`{path}` is a section: set its keys, or leave it out as a whole");
        return Err(source.error_at_path(no_value(path), path, hint));
    }
    set(&mut tree, &target.steps, node.as_ref()).map_err(|rows| no_row(path, rows, &source))?;
    let whole = matches!((target.key.kind)(), Kind::Count);
    Ok(text::edited(file_text, &[Change { steps: target.steps, whole, value }]))
}
