//! Reading of tables: their keys, the values of missing keys, and all errors.

use std::ops::Range;

use super::error::{DesignErrorKind, Source};
use super::hint;
use super::schema::{At, Key, Kind, Presence, SectionSchema};
use super::tree::{Branch, Item, Node, number};
use super::values::choice;
use super::{DesignError, InputFile};
use crate::materials::Material;

pub(super) type Result<T> = std::result::Result<T, Box<DesignError>>;

/// A table of the file with its place and name.
pub struct Table<'a> {
    pub(super) source: &'a Source<'a>,
    pub(super) branch: &'a Branch,
    /// Place of the table's header, at which missing keys are reported.
    pub(super) span: Range<usize>,
    /// Name in the enclosing table; empty for the file as a whole.
    pub(super) name: &'a str,
    /// Number in a list of tables.
    pub(super) row: Option<usize>,
    pub(super) parent: Option<&'a Table<'a>>,
    /// All sections of the file, for a hint where a misplaced key belongs.
    pub(super) root: &'static SectionSchema,
}

/// A type that a key of a file can have.
pub trait FieldValue: Sized {
    /// Whether a missing key has no value at all.
    const MAY_BE_ABSENT: bool = false;

    fn kind() -> Kind;

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<Self>;

    /// The value of a missing key.
    fn absent(key: &Key, table: &Table<'_>) -> Result<Self>;

    /// Appends `path = value` lines that do not depend on the layout of the file.
    fn canonical(&self, path: &str, out: &mut Vec<String>);

    /// Appends the files that the value names.
    fn files(&self, _out: &mut Vec<InputFile>) {}

    /// Appends `path` if the value is a default (not merely absent).
    fn defaulted(&self, key: &Key, written: bool, path: &str, out: &mut Vec<String>) {
        if !written
            && !matches!(key.rule.presence, Presence::Required | Presence::Optional | Presence::Positional)
        {
            out.push(path.to_owned());
        }
    }
}

/// A section, see the `section!` macro.
pub trait SectionValue: Sized {
    fn schema() -> &'static SectionSchema;

    fn from_table(table: &Table<'_>) -> Result<Self>;

    fn canonical_fields(&self, path: &str, out: &mut Vec<String>);

    fn defaulted_fields(&self, path: &str, out: &mut Vec<String>);
}

/// A closed set of words.
pub trait Choice: Copy + PartialEq + 'static {
    /// Words with their meaning.
    const WORDS: &'static [(&'static str, &'static str)];
    const VALUES: &'static [Self];

    /// The word for this value.
    fn word(self) -> &'static str {
        let words = Self::VALUES.iter().zip(Self::WORDS);
        words.into_iter().find(|(value, _)| **value == self).map_or("", |(_, (word, _))| word)
    }
}

pub fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}

/// The tree of a text.
///
/// # Errors
/// Text that is not TOML.
pub fn parse(source: &Source<'_>) -> Result<Branch> {
    let parsed = toml::de::DeTable::parse(source.text).map_err(|error| {
        let span = error.span().unwrap_or(0..0);
        let hint = hint::for_syntax(source.text, span.start);
        source.error(DesignErrorKind::Syntax { message: error.message().replace('\n', ", ") }, span, hint)
    })?;
    Ok(Branch::from_toml(parsed.get_ref()))
}

/// Reads a whole file with the keys declared by `T`.
///
/// # Errors
/// The first error: unknown keys, otherwise the first value that is missing, of a wrong type or out of range;
/// all other unknown keys and wrong values are attached to it.
pub fn read<T: SectionValue>(branch: &Branch, source: &Source<'_>) -> Result<T> {
    let table = Table::root(source, branch, T::schema());
    let mut wrong = table.reject_unknown_keys()?;
    T::from_table(&table).map_err(|error| {
        let mut error = with_path(error, branch);
        wrong.retain(|other| other.span() != error.span());
        error.others = wrong;
        error
    })
}

/// Adds the path of the key at the place of the error.
pub fn with_path(mut error: Box<DesignError>, branch: &Branch) -> Box<DesignError> {
    if error.path.is_none()
        && let Some(span) = error.span().filter(|span| !span.is_empty())
    {
        error.path = branch.path_at(&span);
    }
    error
}

impl<'a> Table<'a> {
    /// The file as a whole.
    pub(super) fn root(
        source: &'a Source<'a>,
        branch: &'a Branch,
        root: &'static SectionSchema,
    ) -> Table<'a> {
        Table { source, branch, span: 0..0, name: "", row: None, parent: None, root }
    }

    /// All unknown keys are one error, with all wrong values attached; without unknown keys the wrong values.
    pub(super) fn reject_unknown_keys(&self) -> Result<Vec<DesignError>> {
        let (mut unknown, mut wrong) = (Vec::new(), Vec::new());
        self.collect_wrong(self.root, &mut unknown, &mut wrong);
        let by_place =
            |errors: &mut Vec<DesignError>| errors.sort_by_key(|error| error.span().map(|span| span.start));
        by_place(&mut unknown);
        by_place(&mut wrong);
        if unknown.is_empty() {
            return Ok(wrong);
        }
        let mut first = unknown.remove(0);
        unknown.append(&mut wrong);
        by_place(&mut unknown);
        first.others = unknown;
        Err(Box::new(first))
    }

    /// Dotted name without numbers of rows, as in the header of the table.
    pub(super) fn path(&self) -> String {
        self.parent.map_or_else(String::new, |parent| join(&parent.path(), self.name))
    }

    /// Dotted name with the numbers of rows.
    pub(super) fn address(&self) -> String {
        let Some(parent) = self.parent else { return String::new() };
        let name = join(&parent.address(), self.name);
        self.row.map_or(name.clone(), |row| format!("{name}[{row}]"))
    }

    /// Name of the table in messages.
    pub(super) fn title(&self) -> String {
        if self.parent.is_none() { self.source.title.to_owned() } else { format!("[{}]", self.path()) }
    }

    /// Reads the next key of a section.
    pub fn read<T: FieldValue>(&self, keys: &mut std::slice::Iter<'_, Key>) -> Result<At<T>> {
        // `keys` and the fields of the struct come from the same declaration, so that their numbers are equal.
        let Some(key) = keys.next() else { unreachable!("a section has as many keys as fields") };
        match self.branch.get(key.name) {
            Some(item) => Ok(At { value: T::read(key, item, self)?, span: Some(item.span.clone()) }),
            None => Ok(At { value: T::absent(key, self)?, span: None }),
        }
    }

    /// All unknown keys of this table and of the tables within it, and all values that the schema rejects.
    fn collect_wrong(
        &self,
        schema: &SectionSchema,
        unknown: &mut Vec<DesignError>,
        wrong: &mut Vec<DesignError>,
    ) {
        for entry in &self.branch.entries {
            let Some(key) = schema.keys.iter().find(|known| known.name == &*entry.key) else {
                let written = self.source.text.get(entry.item.span.clone()).unwrap_or_default();
                let (kind, hint) =
                    hint::for_unknown_key(&entry.key, written, schema, self.root, &self.title());
                let mut error = self.source.error(kind, entry.key_span.clone(), Some(hint));
                error.path = Some(join(&self.address(), &entry.key));
                unknown.push(*error);
                continue;
            };
            match ((key.kind)(), &entry.item.node) {
                (Kind::Section(inner) | Kind::Material(inner), Node::Table(branch)) => {
                    let inside = self.sub_table(key.name, branch, entry.item.span.clone());
                    inside.collect_wrong(inner, unknown, wrong);
                }
                (Kind::Sections(inner), Node::List(rows)) => {
                    for (index, row) in rows.iter().enumerate() {
                        if let Node::Table(branch) = &row.node {
                            self.row_table(key.name, index, branch, row.span.clone())
                                .collect_wrong(inner, unknown, wrong);
                        }
                    }
                }
                (Kind::Variations(inner), Node::Table(paths)) => {
                    let section = self.sub_table(key.name, paths, entry.item.span.clone());
                    for path in &paths.entries {
                        if let Node::Table(branch) = &path.item.node {
                            let name = super::tree::quoted_key(&path.key);
                            section
                                .sub_table(&name, branch, path.item.span.clone())
                                .collect_wrong(inner, unknown, wrong);
                        }
                    }
                }
                (kind, _) => {
                    let error = match kind {
                        Kind::Number => f64::read(key, &entry.item, self).err(),
                        Kind::Count => usize::read(key, &entry.item, self).err(),
                        Kind::Flag => bool::read(key, &entry.item, self).err(),
                        Kind::Text => String::read(key, &entry.item, self).err(),
                        Kind::Choice(words) => choice(words, key, &entry.item, self).err(),
                        Kind::Material(_) => Material::read(key, &entry.item, self).err(),
                        _ => None,
                    };
                    if let Some(mut error) = error {
                        error.path = Some(join(&self.address(), key.name));
                        wrong.push(*error);
                    }
                }
            }
        }
    }

    pub(super) fn sub_table<'b>(
        &'b self,
        name: &'b str,
        branch: &'b Branch,
        span: Range<usize>,
    ) -> Table<'b> {
        Table { source: self.source, branch, span, name, row: None, parent: Some(self), root: self.root }
    }

    pub(super) fn row_table<'b>(
        &'b self,
        name: &'b str,
        row: usize,
        branch: &'b Branch,
        span: Range<usize>,
    ) -> Table<'b> {
        Table { row: Some(row), ..self.sub_table(name, branch, span) }
    }

    pub(super) fn wrong_type(&self, key: &Key, expected: impl Into<String>, item: &Item) -> Box<DesignError> {
        let kind = DesignErrorKind::WrongType {
            key: key.name.to_owned(),
            expected: expected.into(),
            found: item.kind_name(),
        };
        let hint = match &item.node {
            Node::Text(text) if number(text).is_some() => {
                Some(format!("write the number without quotes: {} = {text}", key.name))
            }
            Node::Text(text) => hint::for_number_in_words(key, text).or_else(|| hint::for_type(key)),
            _ => hint::for_type(key),
        };
        self.source.error(kind, item.span.clone(), hint)
    }

    pub(super) fn missing(&self, key: &Key) -> Box<DesignError> {
        let section = self.title();
        let hint = format!("add `{} = …`: {}", key.name, first_sentence(key.doc));
        let kind = DesignErrorKind::MissingKey { key: key.name, section };
        let mut error = self.source.error(kind, self.span.clone(), Some(hint));
        error.path = Some(join(&self.address(), key.name));
        error
    }

    pub(super) fn missing_section(&self, key: &Key) -> Box<DesignError> {
        let section = format!("the section [{}]", join(&self.path(), key.name));
        let hint = format!("add it: {}", first_sentence(key.doc));
        let kind = DesignErrorKind::MissingSection { section };
        let mut error = self.source.error(kind, self.span.clone(), Some(hint));
        error.path = Some(join(&self.address(), key.name));
        error
    }

    pub(super) fn in_range(&self, key: &Key, number: f64, span: Range<usize>) -> Result<f64> {
        let name = || key.name.to_owned();
        if !number.is_finite() {
            return Err(self.source.error(
                DesignErrorKind::NotFinite { key: name() },
                span,
                Some("write a finite number".to_owned()),
            ));
        }
        let rule = key.rule;
        if number >= rule.low && number <= rule.high {
            return Ok(number);
        }
        let kind = match number {
            x if x <= 0.0 && rule.low > 0.0 => DesignErrorKind::NotPositive { key: name() },
            x if x < 0.0 && rule.low == 0.0 => DesignErrorKind::Negative { key: name() },
            _ => DesignErrorKind::OutOfRange { key: name() },
        };
        Err(self.source.error(kind, span, Some(hint::for_number(key, number))))
    }
}

pub fn first_sentence(doc: &str) -> String {
    let text = doc.split_whitespace().collect::<Vec<_>>().join(" ");
    let end = text.find(". ").unwrap_or_else(|| text.trim_end_matches('.').len());
    text[..end].to_owned()
}
