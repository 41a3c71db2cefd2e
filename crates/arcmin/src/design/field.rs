//! Reading of single values: kind, range and place of each.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};
use written::{integer, number};

use super::error::{DesignErrorKind, Source};
use super::hint;
use super::schema::{At, Key, Kind, Presence, SectionSchema};
use super::{DesignError, InputFile, MaterialTable};
use crate::materials::Material;

type Result<T> = std::result::Result<T, Box<DesignError>>;

/// A table of the file with its place and name.
pub struct Table<'a> {
    pub(super) source: Source<'a>,
    pub(super) table: &'a DeTable<'a>,
    /// Place of the table's header, where missing keys are reported.
    pub(super) span: Range<usize>,
    /// Dotted name; empty for the file as a whole.
    pub(super) path: String,
    /// All sections of the file, to tell where a misplaced key belongs.
    pub(super) root: &'static SectionSchema,
}

/// A type that a key of the design file can have.
pub trait FieldValue: Sized {
    fn kind() -> Kind;

    fn read(key: &Key, value: &Spanned<DeValue<'_>>, table: &Table<'_>) -> Result<Self>;

    /// The value where the key is left out.
    fn absent(key: &Key, table: &Table<'_>) -> Result<Self>;

    /// Appends `path = value` lines that do not depend on how the file is laid out.
    fn canonical(&self, path: &str, out: &mut Vec<String>);

    /// Appends the files that the value names.
    fn files(&self, _out: &mut Vec<InputFile>) {}

    /// Appends `path` if the value is a default that stands for something (not merely absent).
    fn defaulted(&self, key: &Key, written: bool, path: &str, out: &mut Vec<String>) {
        if !written && matches!(key.rule.presence, Presence::Number(_) | Presence::Word(_)) {
            out.push(path.to_owned());
        }
    }
}

/// A section, see the `section!` macro.
pub trait SectionValue: Sized {
    const SCHEMA: &'static SectionSchema;

    fn from_table(table: &Table<'_>) -> Result<Self>;

    fn canonical_fields(&self, path: &str, out: &mut Vec<String>);

    fn defaulted_fields(&self, path: &str, out: &mut Vec<String>);
}

/// A closed set of words.
pub trait Choice: Copy + PartialEq + 'static {
    /// Words and what they stand for.
    const WORDS: &'static [(&'static str, &'static str)];
    const VALUES: &'static [Self];

    /// The word for this value.
    fn word(self) -> &'static str {
        let words = Self::VALUES.iter().zip(Self::WORDS);
        words.into_iter().find(|(value, _)| **value == self).map_or("", |(_, (word, _))| word)
    }
}

pub(super) fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}

impl Table<'_> {
    /// The table as an engineer would call it.
    pub fn title(&self) -> String {
        if self.path.is_empty() { "the design file".to_owned() } else { format!("[{}]", self.path) }
    }

    /// Reads the next key of a section.
    pub fn read<T: FieldValue>(&self, keys: &mut std::slice::Iter<'_, Key>) -> Result<At<T>> {
        // `keys` and the fields of the struct come from the same declaration, so they run out together.
        let Some(key) = keys.next() else { unreachable!("a section has as many keys as fields") };
        match self.table.get(key.name) {
            Some(value) => Ok(At { value: T::read(key, value, self)?, span: Some(value.span()) }),
            None => Ok(At { value: T::absent(key, self)?, span: None }),
        }
    }

    /// The first key in the order of the file that the section does not have is an error.
    pub fn reject_unknown_keys(&self, schema: &SectionSchema) -> Result<()> {
        let unknown = self
            .table
            .iter()
            .filter(|(key, _)| schema.keys.iter().all(|known| known.name != key.get_ref().as_ref()));
        let Some((key, value)) = unknown.min_by_key(|(key, _)| key.span().start) else {
            return Ok(());
        };
        let written = self.source.text.get(value.span()).unwrap_or_default();
        let (kind, hint) = hint::for_unknown_key(key.get_ref(), written, schema, self.root, &self.title());
        Err(self.source.error(kind, key.span(), Some(hint)))
    }

    pub fn sub_table<'b>(&'b self, name: &str, table: &'b DeTable<'b>, span: Range<usize>) -> Table<'b> {
        Table { source: self.source, table, span, path: join(&self.path, name), root: self.root }
    }

    pub(super) fn wrong_type(
        &self,
        key: &Key,
        expected: impl Into<String>,
        value: &Spanned<DeValue<'_>>,
    ) -> Box<DesignError> {
        let kind = DesignErrorKind::WrongType {
            key: key.name.to_owned(),
            expected: expected.into(),
            found: kind_name(value.get_ref()),
        };
        let hint = match value.get_ref() {
            DeValue::String(text) if number(text).is_some() => {
                Some(format!("write the number without quotes: {} = {text}", key.name))
            }
            _ => None,
        };
        self.source.error(kind, value.span(), hint)
    }

    pub(super) fn missing(&self, key: &Key) -> Box<DesignError> {
        let section = self.title();
        let hint = format!("add `{} = …`: {}", key.name, first_sentence(key.doc));
        self.source.error(
            DesignErrorKind::MissingKey { key: key.name, section },
            self.span.clone(),
            Some(hint),
        )
    }

    fn in_range(&self, key: &Key, number: f64, span: Range<usize>) -> Result<f64> {
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

fn kind_name(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

pub(super) fn first_sentence(doc: &str) -> String {
    let text = doc.split_whitespace().collect::<Vec<_>>().join(" ");
    let end = text.find(". ").unwrap_or_else(|| text.trim_end_matches('.').len());
    text[..end].to_owned()
}

/// Numbers of TOML, whose parser leaves them as text.
mod written {
    pub fn number(text: &str) -> Option<f64> {
        text.replace('_', "").parse().ok()
    }

    pub fn integer(text: &str, radix: u32) -> Option<i64> {
        i64::from_str_radix(&text.replace('_', ""), radix).ok()
    }
}

fn as_number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => number(float.as_str()),
        DeValue::Integer(whole) if whole.radix() == 10 => number(whole.as_str()),
        DeValue::Integer(whole) => integer(whole.as_str(), whole.radix()).map(|whole| whole as f64),
        _ => None,
    }
}

impl FieldValue for f64 {
    fn kind() -> Kind {
        Kind::Number
    }

    fn read(key: &Key, value: &Spanned<DeValue<'_>>, table: &Table<'_>) -> Result<f64> {
        let Some(number) = as_number(value.get_ref()) else {
            return Err(table.wrong_type(key, "a number", value));
        };
        table.in_range(key, number, value.span())
    }

    fn absent(key: &Key, table: &Table<'_>) -> Result<f64> {
        match key.rule.presence {
            Presence::Number(number) => Ok(number),
            _ => Err(table.missing(key)),
        }
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        // −0 and 0 are the same design; adding 0 makes them the same text.
        out.push(format!("{path} = {:?}", self + 0.0));
    }
}

impl FieldValue for usize {
    fn kind() -> Kind {
        Kind::Count
    }

    fn read(key: &Key, value: &Spanned<DeValue<'_>>, table: &Table<'_>) -> Result<usize> {
        let whole = match value.get_ref() {
            DeValue::Integer(_) | DeValue::Float(_) => as_number(value.get_ref()),
            _ => None,
        };
        match whole {
            Some(number) if !number.is_finite() || number.fract() == 0.0 => {
                Ok(table.in_range(key, number, value.span())? as usize)
            }
            _ => Err(table.wrong_type(key, "a whole number", value)),
        }
    }

    fn absent(key: &Key, table: &Table<'_>) -> Result<usize> {
        match key.rule.presence {
            Presence::Number(number) => Ok(number as usize),
            _ => Err(table.missing(key)),
        }
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        out.push(format!("{path} = {self}"));
    }
}

impl FieldValue for String {
    fn kind() -> Kind {
        Kind::Text
    }

    fn read(key: &Key, value: &Spanned<DeValue<'_>>, table: &Table<'_>) -> Result<String> {
        match value.get_ref() {
            DeValue::String(text)
                if !text.trim().is_empty() || !matches!(key.rule.presence, Presence::Required) =>
            {
                Ok(text.to_string())
            }
            DeValue::String(_) => Err(table.wrong_type(key, "a text that is not empty", value)),
            _ => Err(table.wrong_type(key, "a text in quotes", value)),
        }
    }

    fn absent(key: &Key, table: &Table<'_>) -> Result<String> {
        match key.rule.presence {
            Presence::Word(word) => Ok(word.to_owned()),
            _ => Err(table.missing(key)),
        }
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        out.push(format!("{path} = {self:?}"));
    }
}

impl<T: FieldValue> FieldValue for Option<T> {
    fn kind() -> Kind {
        T::kind()
    }

    fn read(key: &Key, value: &Spanned<DeValue<'_>>, table: &Table<'_>) -> Result<Option<T>> {
        T::read(key, value, table).map(Some)
    }

    fn absent(_: &Key, _: &Table<'_>) -> Result<Option<T>> {
        Ok(None)
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        if let Some(value) = self {
            value.canonical(path, out);
        }
    }

    fn files(&self, out: &mut Vec<InputFile>) {
        if let Some(value) = self {
            value.files(out);
        }
    }

    fn defaulted(&self, key: &Key, written: bool, path: &str, out: &mut Vec<String>) {
        if let Some(value) = self {
            value.defaulted(key, written, path, out);
        }
    }
}

impl<T: Choice> FieldValue for T {
    fn kind() -> Kind {
        Kind::Choice(T::WORDS)
    }

    fn read(key: &Key, value: &Spanned<DeValue<'_>>, table: &Table<'_>) -> Result<T> {
        let DeValue::String(text) = value.get_ref() else {
            return Err(table.wrong_type(
                key,
                format!("one of {}", hint::quoted(T::WORDS.iter().map(|word| word.0))),
                value,
            ));
        };
        match T::WORDS.iter().position(|(word, _)| *word == text.as_ref()) {
            Some(index) => Ok(T::VALUES[index]),
            None => {
                let kind =
                    DesignErrorKind::UnknownChoice { key: key.name.to_owned(), choice: text.to_string() };
                let hint = hint::for_word(text, T::WORDS.iter().map(|word| word.0));
                Err(table.source.error(kind, value.span(), Some(hint)))
            }
        }
    }

    fn absent(key: &Key, table: &Table<'_>) -> Result<T> {
        let Presence::Word(default) = key.rule.presence else {
            return Err(table.missing(key));
        };
        T::WORDS
            .iter()
            .position(|(word, _)| *word == default)
            .map(|index| T::VALUES[index])
            .ok_or_else(|| table.missing(key))
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        let word = T::VALUES.iter().position(|value| value == self).map_or("", |index| T::WORDS[index].0);
        out.push(format!("{path} = {word:?}"));
    }
}

impl FieldValue for Material {
    fn kind() -> Kind {
        Kind::Material(MaterialTable::SCHEMA.keys)
    }

    fn read(key: &Key, value: &Spanned<DeValue<'_>>, table: &Table<'_>) -> Result<Material> {
        match value.get_ref() {
            DeValue::String(name) => Material::by_name(name).ok_or_else(|| {
                let names = Material::known_names();
                let hint = format!(
                    "{}, or give the material itself: {} = {{ youngs_modulus_gpa = 210, poisson_ratio = 0.3, density_g_cm3 = 7.85 }}",
                    hint::for_word(name, names),
                    key.name
                );
                table.source.error(DesignErrorKind::UnknownMaterial { name: name.to_string() }, value.span(), Some(hint))
            }),
            DeValue::Table(inline) => Ok(MaterialTable::from_table(&table.sub_table(key.name, inline, value.span()))?.material()),
            _ => Err(table.wrong_type(key, "the name of a material or an inline table", value)),
        }
    }

    fn absent(key: &Key, table: &Table<'_>) -> Result<Material> {
        match key.rule.presence {
            Presence::Word(word) => Material::by_name(word).ok_or_else(|| table.missing(key)),
            _ => Err(table.missing(key)),
        }
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        out.push(format!(
            "{path} = {:?} {:?} {:?} {:?}",
            self.name, self.youngs_modulus, self.poisson_ratio, self.density
        ));
    }
}

/// A section inside of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct Section<T>(pub T);

impl<T> std::ops::Deref for Section<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T: SectionValue> FieldValue for Section<T> {
    fn kind() -> Kind {
        Kind::Section(T::SCHEMA)
    }

    fn read(key: &Key, value: &Spanned<DeValue<'_>>, table: &Table<'_>) -> Result<Section<T>> {
        match value.get_ref() {
            DeValue::Table(inner) => {
                T::from_table(&table.sub_table(key.name, inner, value.span())).map(Section)
            }
            _ => Err(table.wrong_type(key, format!("a section, [{}]", join(&table.path, key.name)), value)),
        }
    }

    fn absent(key: &Key, table: &Table<'_>) -> Result<Section<T>> {
        if key.rule.presence == Presence::Required {
            let section = format!("the section [{}]", join(&table.path, key.name));
            let hint = format!("add it: {}", first_sentence(key.doc));
            return Err(table.source.error(
                DesignErrorKind::MissingSection { section },
                table.span.clone(),
                Some(hint),
            ));
        }
        T::from_table(&table.sub_table(key.name, &DeTable::new(), table.span.clone())).map(Section)
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        self.0.canonical_fields(path, out);
    }

    fn defaulted(&self, _: &Key, _: bool, path: &str, out: &mut Vec<String>) {
        self.0.defaulted_fields(path, out);
    }
}

impl<T: SectionValue> FieldValue for Vec<At<Section<T>>> {
    fn kind() -> Kind {
        Kind::Sections(T::SCHEMA)
    }

    fn read(key: &Key, value: &Spanned<DeValue<'_>>, table: &Table<'_>) -> Result<Self> {
        let expected = || format!("a list of tables, [[{}]]", join(&table.path, key.name));
        let DeValue::Array(rows) = value.get_ref() else {
            return Err(table.wrong_type(key, expected(), value));
        };
        rows.iter()
            .map(|row| match row.get_ref() {
                DeValue::Table(inner) => {
                    let inner = table.sub_table(key.name, inner, row.span());
                    Ok(At { value: Section(T::from_table(&inner)?), span: Some(row.span()) })
                }
                _ => Err(table.wrong_type(key, expected(), row)),
            })
            .collect()
    }

    fn absent(_: &Key, _: &Table<'_>) -> Result<Self> {
        Ok(Vec::new())
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        for (index, row) in self.iter().enumerate() {
            row.value.0.canonical_fields(&format!("{path}[{index}]"), out);
        }
    }
}

/// Pairs of numbers, such as the points of a free form; the rule's range holds for the second of each pair.
impl FieldValue for Vec<[f64; 2]> {
    fn kind() -> Kind {
        Kind::Pairs
    }

    fn read(key: &Key, value: &Spanned<DeValue<'_>>, table: &Table<'_>) -> Result<Self> {
        let DeValue::Array(rows) = value.get_ref() else {
            return Err(table.wrong_type(key, "a list of pairs of numbers", value));
        };
        rows.iter()
            .map(|row| {
                let DeValue::Array(pair) = row.get_ref() else {
                    return Err(table.wrong_type(key, "a list of pairs of numbers", row));
                };
                let [first, second] = [0, 1].map(|index| pair.get(index));
                let (Some(first), Some(second), 2) = (first, second, pair.len()) else {
                    return Err(table.wrong_type(key, "a list of pairs of numbers", row));
                };
                let mut numbers = [0.0; 2];
                for (number, written) in numbers.iter_mut().zip([first, second]) {
                    *number = as_number(written.get_ref())
                        .ok_or_else(|| table.wrong_type(key, "a list of pairs of numbers", written))?;
                    if !number.is_finite() {
                        table.in_range(key, *number, written.span())?;
                    }
                }
                table.in_range(key, numbers[1], second.span())?;
                Ok(numbers)
            })
            .collect()
    }

    fn absent(_: &Key, _: &Table<'_>) -> Result<Self> {
        Ok(Vec::new())
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        for (index, [first, second]) in self.iter().enumerate() {
            out.push(format!("{path}[{index}] = {:?} {:?}", first + 0.0, second + 0.0));
        }
    }
}
