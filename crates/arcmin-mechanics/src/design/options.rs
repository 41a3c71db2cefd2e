//! Options of an analysis: declared like the sections of a design file and read by the same reader, so that
//! study files, command lines and calls from Python have the same values, ranges and messages.

use super::field::Table;
use super::schema::{Key, Presence, SectionSchema};
use super::{DesignError, InputFile};
use crate::design::error::Source;

type Result<T> = std::result::Result<T, Box<DesignError>>;

/// A set of options with documentation and defaults, see the `options!` macro.
pub trait OptionSet: Sized {
    /// Documentation and keys, those of its groups first.
    fn schema() -> &'static SectionSchema;

    /// Reads the options from a table without unknown keys.
    #[doc(hidden)]
    fn take(reader: &mut OptionReader<'_>) -> Result<Self>;

    /// Appends `key = value` for every option, defaults included.
    #[doc(hidden)]
    fn write(&self, out: &mut Vec<String>);

    /// The files that the options name.
    #[doc(hidden)]
    fn files(&self, out: &mut Vec<InputFile>);

    /// Reads options from TOML such as `joints = "bearings"`; `origin` names the text in messages.
    ///
    /// # Errors
    /// The first option that is unknown, of a wrong type or out of range.
    fn parse(text: &str, origin: &str) -> Result<Self> {
        let source = Source { text, file_name: origin, title: "the options" };
        let branch = super::field::parse(&source)?;
        let schema = Self::schema();
        let table = Table::root(&source, &branch, schema);
        table.reject_unknown_keys()?;
        Self::take(&mut OptionReader { table: &table, keys: schema.keys.iter() })
            .map_err(|error| super::field::with_path(error, &branch))
    }

    /// All options with their values, one `key = value` per line, independent of how they were given: a part of
    /// the hash of a run.
    fn canonical(&self) -> String {
        let mut lines = Vec::new();
        self.write(&mut lines);
        lines.join("\n")
    }
}

/// Returns the values of options in the order of their keys.
pub struct OptionReader<'a> {
    pub(super) table: &'a Table<'a>,
    pub(super) keys: std::slice::Iter<'static, Key>,
}

impl OptionReader<'_> {
    #[doc(hidden)]
    pub fn read<T: super::field::FieldValue>(&mut self) -> Result<T> {
        Ok(self.table.read(&mut self.keys)?.value)
    }
}

/// Keys of a group with changed defaults.
#[doc(hidden)]
pub fn with_defaults(schema: &SectionSchema, defaults: &[(&str, Presence)]) -> Vec<Key> {
    let changed = |key: &Key| {
        let presence = defaults.iter().find(|(name, _)| *name == key.name).map(|(_, presence)| *presence);
        let mut key = *key;
        key.rule.presence = presence.unwrap_or(key.rule.presence);
        key
    };
    schema.keys.iter().map(changed).collect()
}

/// Declares options: a struct whose fields are the options, with their documentation, range and default. Groups
/// shared by several analyses come first, in brackets, each with its changed defaults.
#[doc(hidden)]
#[macro_export]
macro_rules! options {
    ($($(#[doc = $doc:literal])* pub struct $Name:ident {
        $([$group:ident : $Group:ty $(, $key:ident = $default:literal)*])*
        $($(#[doc = $field_doc:literal])* $field:ident : $Type:ty => $rule:expr,)*
    })*) => {$(
        $(#[doc = $doc])*
        #[derive(Debug, Clone, PartialEq)]
        pub struct $Name {
            $(#[doc = concat!("Options of the group [`", stringify!($Group), "`].")] pub $group: $Group,)*
            $($(#[doc = $field_doc])* pub $field: $Type,)*
        }

        impl $crate::design::OptionSet for $Name {
            fn schema() -> &'static $crate::design::SectionSchema {
                static SCHEMA: std::sync::LazyLock<$crate::design::SectionSchema> =
                    std::sync::LazyLock::new(|| {
                        let own: Vec<$crate::design::Key> = vec![$($crate::design::Key {
                            name: stringify!($field),
                            doc: concat!($($field_doc, "\n"),*),
                            rule: $rule,
                            kind: <$Type as $crate::design::FieldValue>::kind,
                            may_be_absent: <$Type as $crate::design::FieldValue>::MAY_BE_ABSENT,
                        },)*];
                        let keys = [
                            $($crate::design::options::with_defaults(
                                <$Group as $crate::design::OptionSet>::schema(),
                                &[$((stringify!($key), $crate::design::Presence::Word($default)),)*],
                            ),)*
                            own,
                        ]
                        .concat();
                        $crate::design::SectionSchema { doc: concat!($($doc, "\n"),*), keys: keys.leak() }
                    });
                &SCHEMA
            }

            #[allow(unused_variables)]
            fn take(
                reader: &mut $crate::design::OptionReader<'_>,
            ) -> Result<Self, Box<$crate::design::DesignError>> {
                Ok($Name {
                    $($group: <$Group as $crate::design::OptionSet>::take(reader)?,)*
                    $($field: reader.read()?,)*
                })
            }

            #[allow(unused_variables)]
            fn write(&self, out: &mut Vec<String>) {
                $(<$Group as $crate::design::OptionSet>::write(&self.$group, out);)*
                $($crate::design::FieldValue::canonical(&self.$field, stringify!($field), out);)*
            }

            #[allow(unused_variables)]
            fn files(&self, out: &mut Vec<$crate::design::InputFile>) {
                $(<$Group as $crate::design::OptionSet>::files(&self.$group, out);)*
                $($crate::design::FieldValue::files(&self.$field, out);)*
            }
        }

        impl $Name {
            /// Reads options from TOML such as `joints = "bearings"`.
            ///
            /// # Errors
            /// The first option that is unknown, of a wrong type or out of range.
            pub fn parse(text: &str, origin: &str) -> Result<Self, Box<$crate::design::DesignError>> {
                <$Name as $crate::design::OptionSet>::parse(text, origin)
            }
        }
    )*};
}
