//! Results, each declared once.
//!
//! A [`Quantity`] has a key that ends in its unit, a description and a format. A [`Column`] adds the access to its
//! value in a row; a [`TableOf`] is a list of columns and a [`SummaryOf`] a list of entries, whose dotted keys nest.
//! From these declarations come the header and the cells of a CSV file, `summary.json`, the columns of a terminal or
//! report table, and the reference of results. A new column is one row in a declaration; header and cell therefore
//! always agree.
//!
//! ```
//! use arcmin::results::{TableOf, decimals, quantity};
//!
//! struct Row { hours: f64, depth: f64 }
//!
//! const WEAR: TableOf<Row> = TableOf {
//!     name: "wear",
//!     what: "Depth lost against running hours",
//!     columns: || vec![
//!         quantity("hours", decimals(0), "Running hours since new.").of(|row: &Row| row.hours.into()),
//!         quantity("depth_um", decimals(2), "Depth lost.").of(|row: &Row| (row.depth * 1e6).into()),
//!     ],
//! };
//! let table = WEAR.fill([Row { hours: 10.0, depth: 2e-6 }].iter());
//! assert_eq!(table.to_csv(), "hours,depth_um\n10,2\n");
//! ```

mod csv;
pub(crate) mod quantities;
mod reference;
mod summary;
mod table;

pub use reference::{Declared, DeclaredTable, markdown as reference_of_results};
pub use summary::{Summary, SummaryOf};
pub use table::{Cells, Column, Table, TableColumn, TableOf};

use crate::design::unit_of;

/// One value of a result.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number in the unit of its key; null in JSON where it is not finite.
    Number(f64),
    /// A whole number of zero or more.
    Count(u64),
    /// A word or a text.
    Word(String),
    /// Yes or no.
    Flag(bool),
    /// Not computed, or not defined (the radius of a straight flank).
    Absent,
    /// A list, in a summary only.
    List(Vec<Value>),
    /// Named values, in a summary only.
    Record(Vec<(&'static str, Value)>),
}

/// A quantity that is computed: its name, its meaning, its format.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    /// Name with the unit at its end. In a summary a dot is nesting.
    pub key: &'static str,
    /// Format for texts.
    pub format: Format,
    /// Meaning in one sentence; how to read it, in further ones.
    pub what: &'static str,
}

/// Format of a number in texts; files contain all digits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Format {
    /// Digits behind the decimal point.
    Decimals(usize),
    /// Significant digits.
    Significant(usize),
    /// Unchanged: words, counts.
    Plain,
}

/// See [`Format::Decimals`].
pub const fn decimals(digits: usize) -> Format {
    Format::Decimals(digits)
}

/// See [`Format::Significant`].
pub const fn digits(digits: usize) -> Format {
    Format::Significant(digits)
}

/// See [`Format::Plain`].
pub const PLAIN: Format = Format::Plain;

/// Declares a quantity.
pub const fn quantity(key: &'static str, format: Format, what: &'static str) -> Quantity {
    Quantity { key, format, what }
}

/// A name of a key as words, abbreviations in capitals: `te_rated_peak_to_peak` is "TE rated peak to peak".
pub fn in_words(stem: &str) -> String {
    let words = stem.split('_').map(|word| match word {
        "te" => "TE",
        "ste" => "STE",
        "dte" => "DTE",
        "l10" => "L10",
        word => word,
    });
    words.collect::<Vec<_>>().join(" ")
}

impl Quantity {
    /// Unit as a reader writes it; empty for pure numbers, counts and words.
    pub fn unit(&self) -> &'static str {
        let name = self.key.rsplit('.').next().unwrap_or(self.key);
        // The name already contains the unit.
        if name.starts_with("hours_to_") { "h" } else { unit_of(name).map_or("", |(_, unit)| unit) }
    }

    /// The key without path and unit, as words: `max_force_n` is "max force".
    pub fn label(&self) -> String {
        let name = self.key.rsplit('.').next().unwrap_or(self.key);
        in_words(unit_of(name).map_or(name, |(stem, _)| stem))
    }

    /// The first sentence of the description.
    pub fn sentence(&self) -> &'static str {
        self.what.split_once(". ").map_or(self.what, |(first, _)| first)
    }

    /// A column that reads this quantity from a row.
    pub const fn of<R>(self, value: fn(&R) -> Value) -> Column<R> {
        Column::new(self, value)
    }

    /// The same quantity under another key: part of a group (`new.lost_motion_arcmin`).
    pub const fn named(self, key: &'static str) -> Quantity {
        Quantity { key, ..self }
    }

    /// The same quantity shown in another format.
    pub const fn with(self, format: Format) -> Quantity {
        Quantity { format, ..self }
    }

    /// The value in the format for texts, without unit.
    pub fn show(&self, value: &Value) -> String {
        match (value, self.format) {
            (Value::Number(number), _) if !number.is_finite() => "–".to_owned(),
            (Value::Number(number), Format::Decimals(digits)) => crate::report::in_decimals(*number, digits),
            (Value::Number(number), Format::Significant(digits)) => {
                crate::report::significant(*number, digits)
            }
            (Value::Number(number), Format::Plain) => crate::report::compact(*number, 6),
            (Value::Count(count), _) => count.to_string(),
            (Value::Word(word), _) => word.clone(),
            (Value::Flag(flag), _) => if *flag { "yes" } else { "no" }.to_owned(),
            (Value::Absent, _) => "–".to_owned(),
            (Value::List(values), _) => {
                values.iter().map(|value| self.show(value)).collect::<Vec<_>>().join(", ")
            }
            (Value::Record(fields), _) => format!("{} values", fields.len()),
        }
    }
}

impl Value {
    /// The value as JSON; numbers that are not finite are null.
    pub fn to_json(&self) -> serde_json::Value {
        use serde_json::Value as Json;
        match self {
            Value::Number(number) => serde_json::Number::from_f64(*number).map_or(Json::Null, Json::Number),
            Value::Count(count) => Json::from(*count),
            Value::Word(word) => Json::from(word.as_str()),
            Value::Flag(flag) => Json::from(*flag),
            Value::Absent => Json::Null,
            Value::List(values) => values.iter().map(Value::to_json).collect(),
            Value::Record(fields) => {
                Json::Object(fields.iter().map(|(key, value)| ((*key).to_owned(), value.to_json())).collect())
            }
        }
    }

    /// A list from anything that turns into values.
    pub fn list<T: Into<Value>>(values: impl IntoIterator<Item = T>) -> Value {
        Value::List(values.into_iter().map(Into::into).collect())
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Value {
        Value::Number(number)
    }
}

impl From<usize> for Value {
    fn from(count: usize) -> Value {
        Value::Count(count as u64)
    }
}

impl From<u64> for Value {
    fn from(count: u64) -> Value {
        Value::Count(count)
    }
}

impl From<bool> for Value {
    fn from(flag: bool) -> Value {
        Value::Flag(flag)
    }
}

impl From<&str> for Value {
    fn from(word: &str) -> Value {
        Value::Word(word.to_owned())
    }
}

impl From<String> for Value {
    fn from(word: String) -> Value {
        Value::Word(word)
    }
}

impl<T: Into<Value>> From<Option<T>> for Value {
    fn from(value: Option<T>) -> Value {
        value.map_or(Value::Absent, Into::into)
    }
}
