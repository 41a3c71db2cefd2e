//! One declaration per section of a file is the source of the reader, of the reference chapter of the book and
//! of the hash.

use std::ops::{Deref, Range};

/// A value as written in the file, with its place; defaults have none.
#[derive(Debug, Clone, PartialEq)]
pub struct At<T> {
    pub value: T,
    /// Bytes of the value in the text, `None` for a default; 0..0 for a value set by a program
    /// ([`Design::with`](crate::design::Design::with)).
    pub span: Option<Range<usize>>,
}

impl<T> Deref for At<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

/// Whether a key is mandatory, or its default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Presence {
    Required,
    Optional,
    /// As `Optional`; in a command it is a positional argument.
    Positional,
    Number(f64),
    Word(&'static str),
    Flag(bool),
    Numbers(&'static [f64]),
}

/// Presence of a key and the closed range of its numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    pub presence: Presence,
    pub low: f64,
    pub high: f64,
}

/// The key is mandatory; its numbers are in `low..=high`.
pub const fn required(low: f64, high: f64) -> Rule {
    Rule { presence: Presence::Required, low, high }
}

/// The key may be left out, with a meaning of its own.
pub const fn optional(low: f64, high: f64) -> Rule {
    Rule { presence: Presence::Optional, low, high }
}

/// An option that may be left out; a positional argument of a command.
pub const fn positional() -> Rule {
    Rule { presence: Presence::Positional, low: 0.0, high: 0.0 }
}

/// The key may be left out and has the default `number`.
pub const fn default(number: f64, low: f64, high: f64) -> Rule {
    Rule { presence: Presence::Number(number), low, high }
}

/// A mandatory text, choice or material.
pub const fn word() -> Rule {
    required(0.0, 0.0)
}

/// A text, choice or material with a default.
pub const fn default_word(word: &'static str) -> Rule {
    Rule { presence: Presence::Word(word), low: 0.0, high: 0.0 }
}

/// A switch with the default `flag`.
pub const fn default_flag(flag: bool) -> Rule {
    Rule { presence: Presence::Flag(flag), low: 0.0, high: 0.0 }
}

/// A list of numbers in `low..=high` with the default `numbers`.
pub const fn default_numbers(numbers: &'static [f64], low: f64, high: f64) -> Rule {
    Rule { presence: Presence::Numbers(numbers), low, high }
}

/// One key of a section.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    pub name: &'static str,
    /// Meaning in Markdown.
    pub doc: &'static str,
    pub rule: Rule,
    pub kind: fn() -> Kind,
    /// Whether a missing key has no value at all.
    pub may_be_absent: bool,
}

/// Kinds of values of keys.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    Number,
    Count,
    Text,
    /// true or false.
    Flag,
    /// Name of a file.
    File,
    /// Names of files.
    Files,
    /// One of the words, each with its meaning.
    Choice(&'static [(&'static str, &'static str)]),
    /// Name of a material or an inline table with the keys given.
    Material(&'static SectionSchema),
    /// A list of pairs of numbers.
    Pairs,
    /// A list of numbers.
    Numbers,
    /// A list of texts.
    Texts,
    /// A table of paths of keys, each with the variation of its value.
    Variations(&'static SectionSchema),
    /// A table.
    Section(&'static SectionSchema),
    /// A list of tables.
    Sections(&'static SectionSchema),
}

/// Documentation and keys of a section.
#[derive(Debug)]
pub struct SectionSchema {
    pub doc: &'static str,
    pub keys: &'static [Key],
}

impl Key {
    /// Unit of the key by its suffix, as written for readers.
    pub fn unit(&self) -> &'static str {
        unit_of(self.name).map_or("", |(_, unit)| unit)
    }
}

/// Suffixes of units, longest first, with the units as written.
pub(super) const UNIT_SUFFIXES: [(&str, &str); 37] = [
    ("_n_m_per_arcmin", "N·m/arcmin"),
    ("_n_s_per_m", "N·s/m"),
    ("_n_per_mm_e", "N/mm^e"),
    ("_um_per_kn", "µm/kN"),
    ("_n_m_s_per_rad", "N·m·s/rad"),
    ("_mm2_per_n", "mm²/N"),
    ("_n_per_um", "N/µm"),
    ("_per_gpa", "1/GPa"),
    ("_per_pa", "1/Pa"),
    ("_kg_m2", "kg·m²"),
    ("_kg_m3", "kg/m³"),
    ("_g_cm3", "g/cm³"),
    ("_mm_s", "mm/s"),
    ("_pa_s", "Pa·s"),
    ("_mpa_s", "mPa·s"),
    ("_arcmin", "arcmin"),
    ("_arcsec", "arcsec"),
    ("_rad_s2", "rad/s²"),
    ("_rad_s", "rad/s"),
    ("_deg_s2", "°/s²"),
    ("_deg_s", "°/s"),
    ("_m_s2", "m/s²"),
    ("_deg", "°"),
    ("_rad", "rad"),
    ("_rpm", "rpm"),
    ("_n_m", "N·m"),
    ("_mpa", "MPa"),
    ("_gpa", "GPa"),
    ("_pa", "Pa"),
    ("_kn", "kN"),
    ("_mm", "mm"),
    ("_um", "µm"),
    ("_cm", "cm"),
    ("_kg", "kg"),
    ("_m", "m"),
    ("_h", "h"),
    ("_s", "s"),
];

/// Splits a key into its stem and unit.
pub fn unit_suffix(key: &str) -> Option<(&str, &'static str)> {
    UNIT_SUFFIXES.iter().find_map(|(suffix, unit)| Some((key.strip_suffix(suffix)?, *unit)))
}

/// Further units of options and results. They are too short for the hints on misspelt keys of design files.
const SHORT_SUFFIXES: [(&str, &str); 8] = [
    ("_n", "N"),
    ("_j", "J"),
    ("_w", "W"),
    ("_w_k", "W/K"),
    ("_c", "°C"),
    ("_hz", "Hz"),
    ("_nm", "N·m"),
    ("_percent", "%"),
];

/// Splits the key of an option or a result into its stem and unit.
pub fn unit_of(key: &str) -> Option<(&str, &'static str)> {
    let short = |(suffix, unit): &(&str, &'static str)| Some((key.strip_suffix(suffix)?, *unit));
    let is_whole = |(stem, _): &(&str, &str)| !stem.ends_with("_per");
    unit_suffix(key).or_else(|| SHORT_SUFFIXES.iter().find_map(short).filter(is_whole))
}

/// Declares a section: a struct whose fields are the keys of the file, read, documented and hashed alike.
#[doc(hidden)]
#[macro_export]
macro_rules! section {
    ($($(#[doc = $doc:literal])* pub struct $Name:ident { $($(#[doc = $field_doc:literal])* $field:ident : $Type:ty => $rule:expr,)* })*) => {$(
        $(#[doc = $doc])*
        #[derive(Debug, Clone, PartialEq)]
        pub struct $Name {
            $($(#[doc = $field_doc])* pub $field: $crate::design::At<$Type>,)*
        }

        impl $Name {
            /// Documentation and keys of this section.
            pub const SCHEMA: $crate::design::schema::SectionSchema = $crate::design::schema::SectionSchema {
                doc: concat!($($doc, "\n"),*),
                keys: &[$($crate::design::schema::Key {
                    name: stringify!($field),
                    doc: concat!($($field_doc, "\n"),*),
                    rule: $rule,
                    kind: <$Type as $crate::design::field::FieldValue>::kind,
                    may_be_absent: <$Type as $crate::design::field::FieldValue>::MAY_BE_ABSENT,
                },)*],
            };
        }

        impl $crate::design::field::SectionValue for $Name {
            fn schema() -> &'static $crate::design::schema::SectionSchema {
                &$Name::SCHEMA
            }

            fn from_table(table: &$crate::design::field::Table<'_>) -> std::result::Result<Self, Box<$crate::design::DesignError>> {
                let mut keys = $Name::SCHEMA.keys.iter();
                Ok($Name { $($field: table.read(&mut keys)?,)* })
            }

            fn defaulted_fields(&self, path: &str, out: &mut Vec<String>) {
                let mut keys = $Name::SCHEMA.keys.iter();
                $(if let Some(key) = keys.next() {
                    let path = $crate::design::field::join(path, stringify!($field));
                    $crate::design::field::FieldValue::defaulted(&self.$field.value, key, self.$field.span.is_some(), &path, out);
                })*
            }

            fn canonical_fields(&self, path: &str, out: &mut Vec<String>) {
                $($crate::design::field::FieldValue::canonical(&self.$field.value, &$crate::design::field::join(path, stringify!($field)), out);)*
            }
        }
    )*};
}

#[doc(hidden)]
pub use crate::section;
