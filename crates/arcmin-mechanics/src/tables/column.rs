use super::unit::{self, Dimension};

/// A column of a table with its name, which contains the unit like a key of the design, its type and its range.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    pub(super) name: &'static str,
    pub(super) aliases: &'static [&'static str],
    pub(super) holds: Holds,
    pub(super) required: bool,
    pub(super) blanks: bool,
    pub(super) order: Order,
    pub(super) within: (f64, f64),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Holds {
    Numbers,
    /// Times: numbers, or dates with time of day.
    Stamps,
    Words,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    Any,
    Rising,
    NotFalling,
}

impl Column {
    /// A mandatory column of finite numbers in any order. The unit at the end of the name is that of the
    /// returned numbers.
    pub const fn number(name: &'static str) -> Column {
        Column {
            name,
            aliases: &[],
            holds: Holds::Numbers,
            required: true,
            blanks: false,
            order: Order::Any,
            within: (f64::NEG_INFINITY, f64::INFINITY),
        }
    }

    /// A mandatory column of words.
    pub const fn words(name: &'static str) -> Column {
        Column { holds: Holds::Words, blanks: true, ..Column::number(name) }
    }

    /// Its name with the unit of the returned numbers.
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// The column is optional.
    pub const fn optional(self) -> Column {
        Column { required: false, ..self }
    }

    /// A mandatory column of times: numbers with a unit, numbers without unit counted since 1970 or 1601, whose
    /// unit follows from their size, or dates with time of day.
    pub const fn stamps(name: &'static str) -> Column {
        Column { holds: Holds::Stamps, ..Column::number(name) }
    }

    /// Other names without units with the same meaning.
    pub const fn also(self, aliases: &'static [&'static str]) -> Column {
        Column { aliases, ..self }
    }

    /// Fields may be empty; such a column is read by [`super::Table::gaps`].
    pub const fn with_gaps(self) -> Column {
        Column { blanks: true, ..self }
    }

    /// Each number is larger than the one before.
    pub const fn rising(self) -> Column {
        Column { order: Order::Rising, ..self }
    }

    /// No number is smaller than the one before.
    pub const fn not_falling(self) -> Column {
        Column { order: Order::NotFalling, ..self }
    }

    /// Range of plausible numbers, in the unit of the name.
    pub const fn within(self, low: f64, high: f64) -> Column {
        Column { within: (low, high), ..self }
    }

    /// Whether its fields are stored as numbers.
    pub(super) fn is_number(&self) -> bool {
        self.holds != Holds::Words
    }

    pub(super) fn dimension(&self) -> Option<Dimension> {
        unit::split(self.name).1.map(|unit| unit.dimension)
    }

    pub(super) fn quantity(&self) -> &'static str {
        unit::split(self.name).0
    }
}

/// Match of a name in a header and a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Fit {
    /// Another column.
    No,
    /// This column; its numbers times the factor are in the required unit.
    Yes(f64),
    /// This column without a unit.
    NoUnit,
    /// This column with an unknown unit or a unit of another dimension.
    WrongUnit(Dimension),
}

/// A name of a header in lower case with single underscores, and the text in brackets behind it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Name {
    key: String,
    /// The same with words separated by capitals, as in `MotorTorque`.
    by_capitals: String,
    bracket: Option<String>,
}

impl Name {
    pub(super) fn new(written: &str) -> Name {
        let written = written.trim();
        let (before, bracket) = match written.rfind(['[', '(']) {
            Some(at) if written.ends_with([']', ')']) => {
                let inner = &written[at + 1..];
                let inner = &inner[..inner.len() - 1];
                (&written[..at], Some(inner.trim().to_owned()))
            }
            _ => (written, None),
        };
        let bracket = bracket.filter(|text| !matches!(text.as_str(), "" | "-" | "1"));
        Name { key: key(before, false), by_capitals: key(before, true), bracket }
    }

    /// The same name with a unit from elsewhere, unless it has one in brackets.
    pub(super) fn with_unit(self, unit: &str) -> Name {
        Name { bracket: self.bracket.or_else(|| Some(unit.to_owned())), ..self }
    }

    /// Whether both names are equal except for case and punctuation.
    pub(super) fn is_like(&self, other: &Name) -> bool {
        self.key == other.key && !self.key.is_empty()
    }

    /// The unit in brackets or at the end of the name, as written.
    pub(super) fn unit(&self) -> Option<&str> {
        match &self.bracket {
            Some(bracket) => Some(bracket),
            None => unit::split(&self.key).1.map(|unit| unit.endings[0]),
        }
    }

    pub(super) fn fits(&self, column: &Column) -> Fit {
        let (quantity, wanted) = unit::split(column.name);
        let quantities = || std::iter::once(quantity).chain(column.aliases.iter().copied());
        let keys = [&self.key, &self.by_capitals];
        keys.into_iter()
            .flat_map(|key| quantities().map(move |quantity| self.fits_quantity(key, quantity, wanted)))
            .find(|fit| *fit != Fit::No)
            .unwrap_or(Fit::No)
    }

    fn fits_quantity(&self, key: &str, quantity: &str, wanted: Option<&'static unit::Unit>) -> Fit {
        let Some(rest) = key.strip_prefix(quantity) else { return Fit::No };
        let given = match (rest.strip_prefix('_'), &self.bracket) {
            (None, _) if !rest.is_empty() => return Fit::No,
            (None, None) => None,
            (None, Some(bracket)) => match unit::by_writing(bracket) {
                Some(unit) => Some(unit),
                None => {
                    return match wanted {
                        Some(wanted) => Fit::WrongUnit(wanted.dimension),
                        None => Fit::No,
                    };
                }
            },
            // `torque_limit_n_m` is another quantity than `torque_n_m`; two units in one name are not accepted
            // either.
            (Some(ending), None) => match unit::by_ending(ending) {
                Some(unit) => Some(unit),
                None => return Fit::No,
            },
            (Some(_), Some(_)) => return Fit::No,
        };
        match (given, wanted) {
            (None, None) => Fit::Yes(1.0),
            (None, Some(_)) => Fit::NoUnit,
            (Some(given), Some(wanted)) if given.dimension == wanted.dimension => {
                // With the same unit all bits are kept.
                Fit::Yes(if given.size == wanted.size { 1.0 } else { given.size / wanted.size })
            }
            (Some(_), Some(wanted)) => Fit::WrongUnit(wanted.dimension),
            (Some(given), None) if given.dimension == Dimension::Share => Fit::Yes(given.size),
            (Some(_), None) => Fit::No,
        }
    }
}

/// Lower case, with one underscore for each group of other characters than letters and digits, none at the
/// ends.
fn key(written: &str, capitals_begin_words: bool) -> String {
    let mut key = String::with_capacity(written.len());
    let mut small_before = false;
    for c in written.trim().chars() {
        if c.is_alphanumeric() {
            if capitals_begin_words && small_before && c.is_uppercase() {
                key.push('_');
            }
            key.extend(c.to_lowercase());
        } else if !key.ends_with('_') && !key.is_empty() {
            key.push('_');
        }
        small_before = c.is_lowercase();
    }
    key.truncate(key.trim_end_matches('_').len());
    key
}
