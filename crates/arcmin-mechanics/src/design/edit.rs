//! Access to designs by keys: list and read keys, and derive changed designs.

use std::sync::{Arc, OnceLock};

use super::error::{DesignErrorKind, Source};
use super::field::SectionValue;
use super::path::{self, Step};
use super::schema::{Key, Kind, Presence, SectionSchema};
use super::tree::{Branch, Entry, Item, Node};
use super::value::{Value, material_branch};
use super::{
    Design, DesignError, DesignSections, StageDesign, StageSections, TwoRingDesign, TwoRingSections,
    TwoStageDesign, TwoStageSections,
};
use crate::materials::Material;

/// A key of a design with its declaration and its value.
#[derive(Debug, Clone)]
pub struct KeyEntry {
    /// Dotted path with row numbers from 0, such as `duty[0].share`.
    pub path: String,
    /// Unit as written for readers; empty for dimensionless keys.
    pub unit: &'static str,
    /// Least and largest number accepted, for numbers, counts and lists of them.
    pub range: Option<[f64; 2]>,
    /// Default of the key; [`Value::LeftOut`] if it has none.
    pub default: Value,
    /// Whether the key is mandatory in its section.
    pub required: bool,
    /// Kind of value that the key takes.
    pub kind: Kind,
    /// Meaning in Markdown on one line.
    pub documentation: String,
    /// Value in this design.
    pub value: Value,
    /// Whether the value is written in the file.
    pub written: bool,
}

/// A design file of any family as read, with the changes made since.
#[derive(Debug, Clone)]
pub(super) struct Written {
    tree: Branch,
    pub base: Arc<Base>,
    /// Differences from the base.
    pub changes: Vec<Change>,
    /// The changed text, created on first use.
    text: OnceLock<String>,
}

/// The text that a design was read from.
#[derive(Debug)]
pub(super) struct Base {
    pub text: String,
    file_name: String,
    tree: Branch,
}

/// A design of one family, created and checked from a changed file.
pub(super) trait OfWritten: Sized {
    /// On an error the changed file is returned with it.
    fn of_written(written: Written) -> Result<Self, (Box<DesignError>, Written)>;
}

impl Written {
    /// # Errors
    /// Text that is not TOML.
    pub fn parse(text: &str, file_name: &str) -> Result<Written, Box<DesignError>> {
        let tree = super::field::parse(&Source { text, file_name, title: super::TITLE })?;
        let base = Base { text: text.to_owned(), file_name: file_name.to_owned(), tree: tree.clone() };
        Ok(Written { tree, base: Arc::new(base), changes: Vec::new(), text: OnceLock::new() })
    }

    pub fn tree(&self) -> &Branch {
        &self.tree
    }

    /// The changed tree, if there are changes.
    pub fn changed_from(&self) -> Option<&Branch> {
        (!self.changes.is_empty()).then_some(&self.base.tree)
    }

    pub fn text(&self) -> &str {
        if self.changes.is_empty() {
            return &self.base.text;
        }
        self.text.get_or_init(|| super::text::edited(&self.base.text, &self.changes))
    }

    pub fn file_name(&self) -> &str {
        &self.base.file_name
    }

    pub fn source(&self) -> Source<'_> {
        Source { text: &self.base.text, file_name: &self.base.file_name, title: super::TITLE }
    }

    fn keys(&self, schema: &'static SectionSchema) -> Vec<KeyEntry> {
        let mut out = Vec::new();
        list(schema, Some(&self.tree), true, "", &mut out);
        out
    }

    fn get(&self, schema: &'static SectionSchema, path: &str) -> Result<Value, Box<DesignError>> {
        let source = self.source();
        let target = path::find(path, "", schema, &source)?;
        if !target.is_value() {
            let hint = format!("`{path}` is a section: give one of its keys");
            return Err(source.error_at_path(no_value(path), path, hint));
        }
        look_up(schema, Some(&self.tree), &target.steps, true).map_err(|rows| no_row(path, rows, &source))
    }

    fn with_all<D: OfWritten, P: AsRef<str>, V: Into<Value>>(
        &self,
        schema: &'static SectionSchema,
        changes: impl IntoIterator<Item = (P, V)>,
    ) -> Result<D, Box<DesignError>> {
        let source = self.source();
        let mut tree = self.tree.clone();
        let mut all = self.changes.to_vec();
        for (path, value) in changes {
            let (path, value) = (path.as_ref(), value.into());
            let written = value.to_string();
            let target = path::find(path, &written, schema, &source)?;
            let node = value.node();
            if node.is_some() && (target.row || !target.is_value()) {
                let hint = format!("`{path}` is a section: set its keys, or leave it out as a whole");
                return Err(source.error_at_path(no_value(path), path, hint));
            }
            set(&mut tree, &target.steps, node.as_ref()).map_err(|rows| no_row(path, rows, &source))?;
            all.push(Change {
                steps: target.steps,
                whole: matches!((target.key.kind)(), Kind::Count),
                value,
            });
        }
        let changed = Written { tree, base: self.base.clone(), changes: all, text: OnceLock::new() };
        D::of_written(changed).map_err(|(error, changed)| {
            // Errors are reported as for a file, with their place in the changed text.
            let again = Written::parse(changed.text(), changed.file_name()).map(D::of_written);
            match again {
                Err(error) | Ok(Err((error, _))) => error,
                Ok(Ok(_)) => Box::new(DesignError { place: None, ..*error }),
            }
        })
    }
}

/// Access by keys, the same for all families.
macro_rules! by_keys {
    ($Design:ident, $Sections:ident) => {
        impl $Design {
            /// Every key of the design, in the order of the reference, including those of optional sections
            /// that the file does not contain (their value is [`Value::LeftOut`]); rows of lists that the file
            /// contains.
            pub fn keys(&self) -> Vec<KeyEntry> {
                self.written.keys($Sections::schema())
            }

            /// The value of a key in its unit, from the file or by default.
            ///
            /// # Errors
            /// A path without a value, with the nearest valid one as hint.
            pub fn get(&self, path: &str) -> Result<Value, Box<DesignError>> {
                self.written.get($Sections::schema(), path)
            }

            /// The design with several keys set together, in this order, for keys that must be consistent, such
            /// as `ring.pin_count` and `disc.lobe_count`. See [`Design::with`].
            ///
            /// # Errors
            /// As [`Design::with`].
            pub fn with_all<P: AsRef<str>, V: Into<Value>>(
                &self,
                changes: impl IntoIterator<Item = (P, V)>,
            ) -> Result<$Design, Box<DesignError>> {
                self.written.with_all($Sections::schema(), changes)
            }
        }
    };
}

by_keys!(Design, DesignSections);
by_keys!(StageDesign, StageSections);
by_keys!(TwoRingDesign, TwoRingSections);
by_keys!(TwoStageDesign, TwoStageSections);

impl Design {
    /// The design with one key changed; sweeps, tolerances and optimisations use this.
    ///
    /// It is read and checked exactly as if the file had the new value; masses and inertias that are not in the
    /// file are computed again, those in the file are kept (see [`Design::stale_masses`]). [`Value::LeftOut`]
    /// removes a key. Comments and layout of the text are kept ([`Design::text`]).
    ///
    /// ```
    /// # extern crate arcmin_mechanics as arcmin;
    /// use arcmin::design::Value;
    /// let design = arcmin::templates::design("rv-40e-81").unwrap();
    /// assert_eq!(design.get("crankshafts.eccentricity_mm")?, Value::Number(1.3));
    /// assert_eq!(design.get("duty[0].share")?, Value::Number(1.0));
    /// let wider = design.with("disc.width_mm", 9.5)?;
    /// assert_eq!(wider.get("disc.width_mm")?, 9.5.into());
    /// assert!(wider.text().contains("width_mm = 9.5 "));
    /// let error = design.with("disc.widht_mm", 9.5).unwrap_err();
    /// assert_eq!(error.hint(), Some("did you mean `disc.width_mm`?"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// An unknown path, with the nearest one as hint; a value that is not allowed in a file either, with the
    /// same message, place (in the changed text) and hint.
    pub fn with(&self, path: &str, value: impl Into<Value>) -> Result<Design, Box<DesignError>> {
        self.with_all([(path, value)])
    }
}

/// One key that differs from the original text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Change {
    pub steps: Vec<Step>,
    /// Whether it is a count, written without a fraction.
    pub whole: bool,
    pub value: Value,
}

fn no_value(path: &str) -> DesignErrorKind {
    DesignErrorKind::Contradiction { message: format!("`{path}` is not a single value") }
}

fn no_row(path: &str, rows: usize, source: &Source<'_>) -> Box<DesignError> {
    let message = format!("`{path}` does not exist: the design has {rows} of these rows, counted from 0");
    let hint = format!(
        "write {0}, or [{rows}] with all its required keys to add one",
        match rows {
            0 => "no row".to_owned(),
            _ => format!("a number from 0 to {}", rows - 1),
        }
    );
    source.error_at_path(DesignErrorKind::Contradiction { message }, path, hint)
}

/// Default of a key that is missing in an existing section.
fn default(key: &Key) -> Value {
    match (key.rule.presence, (key.kind)()) {
        (Presence::Number(number), Kind::Count) => Value::Count(number as usize),
        (Presence::Number(number), _) => Value::Number(number),
        (Presence::Word(word), _) => Value::Text(word.to_owned()),
        (Presence::Flag(flag), _) => Value::Flag(flag),
        (Presence::Numbers(numbers), _) => Value::Numbers(numbers.to_vec()),
        (Presence::Optional, Kind::Pairs) => Value::Pairs(Vec::new()),
        (Presence::Optional, Kind::Texts | Kind::Files) => Value::Texts(Vec::new()),
        (Presence::Optional | Presence::Positional | Presence::Required, _) => Value::LeftOut,
    }
}

/// The value at the end of the path; `there` is true if the section exists, written or by default. The error is
/// the number of rows of a list that has no such row.
pub(super) fn look_up(
    schema: &SectionSchema,
    branch: Option<&Branch>,
    steps: &[Step],
    there: bool,
) -> Result<Value, usize> {
    let [Step::Key(name), rest @ ..] = steps else { return Ok(Value::LeftOut) };
    let Some(key) = schema.keys.iter().find(|key| key.name == name) else { return Ok(Value::LeftOut) };
    let item = branch.and_then(|branch| branch.get(name));
    match ((key.kind)(), item.map(|item| &item.node), rest) {
        (kind, Some(node), []) => Ok(Value::of(node, kind)),
        (_, None, []) => Ok(if there { default(key) } else { Value::LeftOut }),
        (Kind::Section(inner) | Kind::Material(inner), Some(Node::Table(branch)), _) => {
            look_up(inner, Some(branch), rest, there)
        }
        (Kind::Section(inner), _, _) => look_up(inner, None, rest, there && !key.may_be_absent),
        (Kind::Material(inner), Some(Node::Text(name)), _) => {
            let named = Material::by_name(name).map(|material| material_branch(&material));
            look_up(inner, named.as_ref(), rest, named.is_some())
        }
        (Kind::Sections(inner), rows, [Step::Row(row), rest @ ..]) => {
            let rows = match rows {
                Some(Node::List(rows)) => &rows[..],
                _ => &[],
            };
            match rows.get(*row).map(|item| &item.node) {
                Some(Node::Table(branch)) => look_up(inner, Some(branch), rest, there),
                _ => Err(rows.len()),
            }
        }
        _ => Ok(Value::LeftOut),
    }
}

fn list(schema: &SectionSchema, branch: Option<&Branch>, there: bool, prefix: &str, out: &mut Vec<KeyEntry>) {
    for key in schema.keys {
        let path = super::field::join(prefix, key.name);
        let node = branch.and_then(|branch| branch.get(key.name)).map(|item| &item.node);
        let kind = (key.kind)();
        match (kind, node) {
            (Kind::Section(inner), Some(Node::Table(branch))) => list(inner, Some(branch), there, &path, out),
            (Kind::Section(inner), _) => list(inner, None, there && !key.may_be_absent, &path, out),
            (Kind::Sections(inner), Some(Node::List(rows))) => {
                for (index, row) in rows.iter().enumerate() {
                    if let Node::Table(branch) = &row.node {
                        list(inner, Some(branch), there, &format!("{path}[{index}]"), out);
                    }
                }
            }
            (Kind::Sections(_) | Kind::Variations(_), _) => {}
            _ => {
                let value = match node {
                    Some(node) => Value::of(node, kind),
                    None if there => default(key),
                    None => Value::LeftOut,
                };
                let numeric = matches!(kind, Kind::Number | Kind::Count | Kind::Numbers | Kind::Pairs);
                out.push(KeyEntry {
                    path,
                    unit: key.unit(),
                    range: numeric.then_some([key.rule.low, key.rule.high]),
                    default: default(key),
                    required: key.rule.presence == Presence::Required,
                    kind,
                    documentation: key.doc.split_whitespace().collect::<Vec<_>>().join(" "),
                    value,
                    written: node.is_some(),
                });
            }
        }
    }
}

/// Sets the value at the end of the path, or removes it with `None`. The error is the number of rows of a list
/// that has no such row.
fn set(branch: &mut Branch, steps: &[Step], node: Option<&Node>) -> Result<(), usize> {
    let [Step::Key(name), rest @ ..] = steps else { return Ok(()) };
    let place = branch.entries.iter().position(|entry| &*entry.key == name.as_str());
    let index = match (place, node) {
        (Some(index), None) if rest.is_empty() => {
            branch.entries.remove(index);
            return Ok(());
        }
        (Some(index), _) => index,
        (None, None) => return Ok(()),
        (None, Some(_)) => {
            let empty = match rest.first() {
                Some(Step::Row(_)) => Node::List(Arc::default()),
                _ => Node::Table(Arc::default()),
            };
            let item = Item::made(empty);
            branch.entries.push(Entry { key: name.as_str().into(), key_span: 0..0, item });
            branch.entries.len() - 1
        }
    };
    let item = &mut branch.entries[index].item;
    if let (Node::Text(name), false) = (&item.node, rest.is_empty()) {
        // One property of a material that was given by name: the other properties keep their values.
        let parts = Material::by_name(name).map(|material| material_branch(&material)).unwrap_or_default();
        *item = Item::made(Node::Table(Arc::new(parts)));
    }
    match (rest, &mut item.node, node) {
        ([], _, Some(node)) => *item = Item::made(node.clone()),
        ([Step::Row(row)], Node::List(rows), None) => {
            if *row >= rows.len() {
                return Err(rows.len());
            }
            Arc::make_mut(rows).remove(*row);
        }
        ([Step::Row(row), rest @ ..], Node::List(rows), _) => {
            let rows = Arc::make_mut(rows);
            if *row > rows.len() || (node.is_none() && *row == rows.len()) {
                return Err(rows.len());
            }
            if *row == rows.len() {
                rows.push(Item::made(Node::Table(Arc::default())));
            }
            if let Node::Table(inner) = &mut rows[*row].node {
                set(Arc::make_mut(inner), rest, node)?;
            }
        }
        (rest, Node::Table(inner), _) => set(Arc::make_mut(inner), rest, node)?,
        _ => {}
    }
    Ok(())
}
