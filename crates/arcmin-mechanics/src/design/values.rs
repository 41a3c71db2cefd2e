//! Types of values of keys: how each is read, and its value if the key is left out.

use super::error::DesignErrorKind;
use super::field::{Choice, FieldValue, Result, SectionValue, Table, join};
use super::hint;
use super::schema::{At, Key, Kind, Presence};
use super::tree::{Branch, Item, Node};
use super::{InputFile, MaterialTable};
use crate::materials::Material;

impl FieldValue for f64 {
    fn kind() -> Kind {
        Kind::Number
    }

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<f64> {
        let Node::Number(number) = item.node else {
            return Err(table.wrong_type(key, "a number", item));
        };
        table.in_range(key, number, item.span.clone())
    }

    fn absent(key: &Key, table: &Table<'_>) -> Result<f64> {
        match key.rule.presence {
            Presence::Number(number) => Ok(number),
            _ => Err(table.missing(key)),
        }
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        // −0 and 0 are the same design; adding 0 gives both the same text.
        out.push(format!("{path} = {:?}", self + 0.0));
    }
}

impl FieldValue for usize {
    fn kind() -> Kind {
        Kind::Count
    }

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<usize> {
        match item.node {
            Node::Number(number) if !number.is_finite() || number.fract() == 0.0 => {
                Ok(table.in_range(key, number, item.span.clone())? as usize)
            }
            _ => Err(table.wrong_type(key, "a whole number", item)),
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

impl FieldValue for bool {
    fn kind() -> Kind {
        Kind::Flag
    }

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<bool> {
        match item.node {
            Node::Flag(flag) => Ok(flag),
            _ => Err(table.wrong_type(key, "true or false", item)),
        }
    }

    fn absent(key: &Key, table: &Table<'_>) -> Result<bool> {
        match key.rule.presence {
            Presence::Flag(flag) => Ok(flag),
            Presence::Optional => Ok(false),
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

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<String> {
        match &item.node {
            Node::Text(text)
                if !text.trim().is_empty() || !matches!(key.rule.presence, Presence::Required) =>
            {
                Ok(text.to_string())
            }
            Node::Text(_) => Err(table.wrong_type(key, "a text that is not empty", item)),
            _ => Err(table.wrong_type(key, "a text in quotes", item)),
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
    const MAY_BE_ABSENT: bool = true;

    fn kind() -> Kind {
        T::kind()
    }

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<Option<T>> {
        T::read(key, item, table).map(Some)
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

/// Which of the words it is.
pub(super) fn choice(
    words: &[(&'static str, &'static str)],
    key: &Key,
    item: &Item,
    table: &Table<'_>,
) -> Result<usize> {
    let known = || words.iter().map(|word| word.0);
    let Node::Text(text) = &item.node else {
        return Err(table.wrong_type(key, format!("one of {}", hint::quoted(known())), item));
    };
    known().position(|word| word == text.as_ref()).ok_or_else(|| {
        let kind = DesignErrorKind::UnknownChoice { key: key.name.to_owned(), choice: text.to_string() };
        table.source.error(kind, item.span.clone(), Some(hint::for_word(text, known())))
    })
}

impl<T: Choice> FieldValue for T {
    fn kind() -> Kind {
        Kind::Choice(T::WORDS)
    }

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<T> {
        Ok(T::VALUES[choice(T::WORDS, key, item, table)?])
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
        out.push(format!("{path} = {:?}", self.word()));
    }
}

/// A value with the information whether it was written or is the default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stated<T> {
    /// Value in the unit of its key.
    pub value: T,
    /// Whether it is written in the file; otherwise it is the default.
    pub is_written: bool,
}

impl<T: FieldValue> FieldValue for Stated<T> {
    const MAY_BE_ABSENT: bool = T::MAY_BE_ABSENT;

    fn kind() -> Kind {
        T::kind()
    }

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<Stated<T>> {
        Ok(Stated { value: T::read(key, item, table)?, is_written: true })
    }

    fn absent(key: &Key, table: &Table<'_>) -> Result<Stated<T>> {
        Ok(Stated { value: T::absent(key, table)?, is_written: false })
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        self.value.canonical(path, out);
    }
}

impl FieldValue for Material {
    fn kind() -> Kind {
        Kind::Material(MaterialTable::schema())
    }

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<Material> {
        match &item.node {
            Node::Text(name) => Material::by_name(name).ok_or_else(|| {
                let names = Material::known_names();
                let hint = format!(
                    "{}, or give the material itself: {} = {{ youngs_modulus_gpa = 210, poisson_ratio = 0.3, \
                     density_g_cm3 = 7.85 }}",
                    hint::for_word(name, names),
                    key.name
                );
                let kind = DesignErrorKind::UnknownMaterial { name: name.to_string() };
                table.source.error(kind, item.span.clone(), Some(hint))
            }),
            Node::Table(inline) => {
                let inner = table.sub_table(key.name, inline, item.span.clone());
                Ok(MaterialTable::from_table(&inner)?.material())
            }
            _ => Err(table.wrong_type(key, "the name of a material or an inline table", item)),
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
        // Properties of a material given by name are those of the program.
        if Material::by_name(&self.name).as_ref() != Some(self) {
            let limits = [self.yield_strength, self.softening_temperature, self.thermal_expansion];
            for (name, value) in
                ["yield_strength", "softening_temperature", "thermal_expansion"].iter().zip(limits)
            {
                out.extend(value.map(|value| format!("{path}.{name} = {value:?}")));
            }
        }
    }
}

/// A section within a section.
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
        Kind::Section(T::schema())
    }

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<Section<T>> {
        match &item.node {
            Node::Table(inner) => {
                T::from_table(&table.sub_table(key.name, inner, item.span.clone())).map(Section)
            }
            _ => Err(table.wrong_type(key, format!("a section, [{}]", join(&table.path(), key.name)), item)),
        }
    }

    fn absent(key: &Key, table: &Table<'_>) -> Result<Section<T>> {
        if key.rule.presence == Presence::Required {
            return Err(table.missing_section(key));
        }
        T::from_table(&table.sub_table(key.name, &Branch::default(), table.span.clone())).map(Section)
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
        Kind::Sections(T::schema())
    }

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<Self> {
        let expected = || format!("a list of tables, [[{}]]", join(&table.path(), key.name));
        let Node::List(rows) = &item.node else {
            return Err(table.wrong_type(key, expected(), item));
        };
        rows.iter()
            .enumerate()
            .map(|(index, row)| match &row.node {
                Node::Table(inner) => {
                    let inner = table.row_table(key.name, index, inner, row.span.clone());
                    Ok(At { value: Section(T::from_table(&inner)?), span: Some(row.span.clone()) })
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

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<Self> {
        let no_pairs = |item: &Item| table.wrong_type(key, "a list of pairs of numbers", item);
        let Node::List(rows) = &item.node else { return Err(no_pairs(item)) };
        rows.iter()
            .map(|row| {
                let Node::List(pair) = &row.node else { return Err(no_pairs(row)) };
                let [first, second] = &pair[..] else { return Err(no_pairs(row)) };
                let mut numbers = [0.0; 2];
                for (number, written) in numbers.iter_mut().zip([first, second]) {
                    let Node::Number(value) = written.node else { return Err(no_pairs(written)) };
                    if !value.is_finite() {
                        table.in_range(key, value, written.span.clone())?;
                    }
                    *number = value;
                }
                table.in_range(key, numbers[1], second.span.clone())?;
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

/// A list of numbers, each within the rule's range; a default list is part of the rule.
impl FieldValue for Vec<f64> {
    fn kind() -> Kind {
        Kind::Numbers
    }

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<Self> {
        let Node::List(rows) = &item.node else {
            return Err(table.wrong_type(key, "a list of numbers", item));
        };
        rows.iter()
            .map(|row| match row.node {
                Node::Number(number) => table.in_range(key, number, row.span.clone()),
                _ => Err(table.wrong_type(key, "a list of numbers", row)),
            })
            .collect()
    }

    fn absent(key: &Key, table: &Table<'_>) -> Result<Self> {
        match key.rule.presence {
            Presence::Numbers(numbers) => Ok(numbers.to_vec()),
            Presence::Required => Err(table.missing(key)),
            _ => Ok(Vec::new()),
        }
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        for (index, number) in self.iter().enumerate() {
            out.push(format!("{path}[{index}] = {:?}", number + 0.0));
        }
    }
}

impl FieldValue for Vec<String> {
    fn kind() -> Kind {
        Kind::Texts
    }

    fn read(key: &Key, item: &Item, table: &Table<'_>) -> Result<Self> {
        let Node::List(rows) = &item.node else {
            return Err(table.wrong_type(key, "a list of texts", item));
        };
        rows.iter()
            .map(|row| match &row.node {
                Node::Text(text) => Ok(text.to_string()),
                _ => Err(table.wrong_type(key, "a list of texts", row)),
            })
            .collect()
    }

    fn absent(key: &Key, table: &Table<'_>) -> Result<Self> {
        match key.rule.presence {
            Presence::Required => Err(table.missing(key)),
            _ => Ok(Vec::new()),
        }
    }

    fn canonical(&self, path: &str, out: &mut Vec<String>) {
        for (index, text) in self.iter().enumerate() {
            out.push(format!("{path}[{index}] = {text:?}"));
        }
    }
}
