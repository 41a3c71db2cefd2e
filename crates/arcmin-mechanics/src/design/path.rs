//! Keys by dotted path: `ring.pin_radius_mm`, `duty[0].share`, `disc.material.youngs_modulus_gpa`.

use super::DesignError;
use super::error::{DesignErrorKind, Source};
use super::hint;
use super::schema::{Key, Kind, SectionSchema};

/// One step of a path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Step {
    Key(String),
    /// Row of a list of tables, from 0.
    Row(usize),
}

/// Target of a path.
#[derive(Debug, Clone)]
pub(super) struct Target {
    pub steps: Vec<Step>,
    /// The last key of the path.
    pub key: &'static Key,
    /// Whether the path ends at a row of the key's list.
    pub row: bool,
}

impl Target {
    /// Whether it is a value, not a section or a list of sections.
    pub fn is_value(&self) -> bool {
        !matches!((self.key.kind)(), Kind::Section(_) | Kind::Sections(_) | Kind::Variations(_))
    }
}

/// Splits a path into its steps; `None` if it is not valid.
fn steps(path: &str) -> Option<Vec<Step>> {
    let mut steps = Vec::new();
    let mut rest = path;
    loop {
        let name_end;
        if let Some(quoted) = rest.strip_prefix('"') {
            name_end = quoted.find('"')? + 2;
            steps.push(Step::Key(rest[1..name_end - 1].to_owned()));
        } else {
            name_end = rest.find(['.', '[']).unwrap_or(rest.len());
            if name_end == 0 {
                return None;
            }
            steps.push(Step::Key(rest[..name_end].to_owned()));
        }
        rest = &rest[name_end..];
        if let Some(row) = rest.strip_prefix('[') {
            let end = row.find(']')?;
            steps.push(Step::Row(row[..end].parse().ok()?));
            rest = &row[end + 1..];
        }
        match rest.strip_prefix('.') {
            Some(more) => rest = more,
            None if rest.is_empty() => return Some(steps),
            None => return None,
        }
    }
}

/// Finds the target of the path among the keys of a file; `written` is the value to be set.
///
/// # Errors
/// A path without target, with the nearest valid one as hint.
pub(super) fn find(
    path: &str,
    written: &str,
    root: &'static SectionSchema,
    source: &Source<'_>,
) -> Result<Target, Box<DesignError>> {
    let unknown = |hint: String| {
        let kind = DesignErrorKind::UnknownKey { key: path.to_owned(), section: source.title.to_owned() };
        source.error_at_path(kind, path, hint)
    };
    let Some(steps) = steps(path) else {
        return Err(unknown("a path is like `ring.pin_radius_mm` or `duty[0].share`".to_owned()));
    };
    let mut schema = Some(root);
    let mut found: Option<(&'static Key, bool)> = None;
    for step in &steps {
        match (step, schema, found) {
            (Step::Key(name), Some(inner), _) => {
                let Some(key) = inner.keys.iter().find(|key| key.name == name) else {
                    return Err(nowhere(path, name, written, inner, root, source));
                };
                schema = match (key.kind)() {
                    Kind::Section(inner) | Kind::Material(inner) => Some(inner),
                    _ => None,
                };
                found = Some((key, false));
            }
            // Paths of keys are not restricted here; the reader checks them.
            (Step::Key(_), None, Some((key, false))) if matches!((key.kind)(), Kind::Variations(_)) => {}
            (Step::Row(_), None, Some((key, false))) if matches!((key.kind)(), Kind::Sections(_)) => {
                if let Kind::Sections(inner) = (key.kind)() {
                    schema = Some(inner);
                }
                found = Some((key, true));
            }
            (_, _, Some((key, _))) if matches!((key.kind)(), Kind::Sections(_)) => {
                return Err(unknown(format!(
                    "`{0}` is a list: write `{0}[0]`, `{0}[1]`, … for its rows",
                    key.name
                )));
            }
            (_, _, found) => {
                let name = found.map_or("", |(key, _)| key.name);
                return Err(unknown(format!("`{name}` is not a section")));
            }
        }
    }
    match found {
        Some((key, row)) => Ok(Target { steps, key, row }),
        None => Err(unknown("a path is like `ring.pin_radius_mm` or `duty[0].share`".to_owned())),
    }
}

/// The error for a path whose key `name` does not exist in `schema`.
fn nowhere(
    path: &str,
    name: &str,
    written: &str,
    schema: &'static SectionSchema,
    root: &'static SectionSchema,
    source: &Source<'_>,
) -> Box<DesignError> {
    let written = if written.is_empty() { "…" } else { written };
    let (kind, hint) = hint::for_unknown_key(name, written, schema, root, source.title);
    let kind = match kind {
        DesignErrorKind::MissingUnit { .. } => DesignErrorKind::MissingUnit { key: path.to_owned() },
        DesignErrorKind::WrongUnit { .. } => DesignErrorKind::WrongUnit { key: path.to_owned() },
        _ => {
            let all = all_paths(root);
            let last = path.rsplit('.').next().unwrap_or(path);
            let same_key = all.iter().find(|known| known.rsplit('.').next() == Some(last));
            let near = hint::closest(path, all.iter().map(String::as_str));
            let hint = match (near, same_key) {
                (Some(near), _) => format!("did you mean `{near}`?"),
                (None, Some(same)) => format!("did you mean `{same}`?"),
                (None, None) => hint,
            };
            let kind = DesignErrorKind::UnknownKey { key: path.to_owned(), section: source.title.to_owned() };
            return source.error_at_path(kind, path, hint);
        }
    };
    source.error_at_path(kind, path, hint)
}

/// The paths of all values that a file can contain, with the first row for each list.
fn all_paths(schema: &SectionSchema) -> Vec<String> {
    let mut paths = Vec::new();
    for key in schema.keys {
        let inner = |schema: &SectionSchema, prefix: &str| {
            all_paths(schema).into_iter().map(|path| format!("{prefix}.{path}")).collect::<Vec<_>>()
        };
        match (key.kind)() {
            Kind::Section(schema) => paths.extend(inner(schema, key.name)),
            Kind::Sections(schema) => paths.extend(inner(schema, &format!("{}[0]", key.name))),
            Kind::Material(schema) => {
                paths.push(key.name.to_owned());
                paths.extend(inner(schema, key.name));
            }
            Kind::Variations(_) => {}
            _ => paths.push(key.name.to_owned()),
        }
    }
    paths
}
