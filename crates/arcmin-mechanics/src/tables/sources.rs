//! Assignment of the fields of a row to columns.

use super::column::{Column, Fit, Holds, Name};
use super::error::{TableErrorKind, UnitKind, shown};
use super::number::{Malformed, Marks};
use super::read::Form;
use super::{instrument, stamp, unit};

/// A column of the file that is read: its field in the row, the column, and the factor to the required unit.
pub(super) struct Source {
    pub field: usize,
    pub column: usize,
    /// `None`: the unit follows from the size of the first number.
    factor: Option<f64>,
    pub written: String,
    pub meant: String,
}

impl Form {
    /// Assignment of the fields of a row to columns; `units` are those of a row of units.
    pub(super) fn sources(
        &self,
        names: &[String],
        units: &[Option<String>],
        labelled: bool,
        line: &str,
    ) -> Result<Vec<Source>, TableErrorKind> {
        if names.len() > self.limits.columns {
            let what = format!("a header of {} columns", names.len());
            return Err(TableErrorKind::TooLarge { what, limit: self.limits.columns });
        }
        if names.iter().any(|name| is_no_name(name)) {
            return Err(TableErrorKind::NoHeader { found: line.to_owned(), valid: self.valid_names() });
        }
        let renamed = self.naming.renamed(names)?;
        let conventional =
            if self.others { instrument::meant(names, labelled) } else { vec![None; names.len()] };
        let mut sources: Vec<Source> = Vec::new();
        for (field, written) in names.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
            let Some(given) = &renamed[field] else { continue };
            let by_user = given != written;
            let meant = if by_user { given } else { conventional[field].as_ref().unwrap_or(written) };
            // A name given by the user has priority.
            let overruled = !by_user
                && renamed.iter().zip(names).any(|(given, name)| {
                    given.as_ref().is_some_and(|given| given != name && self.same_column(given, written))
                });
            if overruled {
                continue;
            }
            if let Some((column, factor)) =
                self.column_of(written, meant, units[field].as_deref(), by_user)?
            {
                if let Some(first) = sources.iter().find(|source| source.column == column) {
                    return Err(TableErrorKind::Twice {
                        first: first.written.clone(),
                        second: shown(written),
                    });
                }
                sources.push(Source { field, column, factor, written: shown(written), meant: shown(meant) });
            }
        }
        for (index, column) in self.columns.iter().enumerate().filter(|(_, column)| column.required) {
            if !sources.iter().any(|source| source.column == index) {
                let proposal = self.proposal(names, units, &sources);
                return Err(TableErrorKind::Missing {
                    name: column.name.to_owned(),
                    rows: None,
                    found: found(&first_names(names), &proposal),
                });
            }
        }
        Ok(sources)
    }

    /// Proposed names for rows without names.
    fn valid_names(&self) -> String {
        let by_number: Vec<String> = self
            .columns
            .iter()
            .take(2)
            .enumerate()
            .map(|(at, column)| format!("{}={}", at + 1, column.name))
            .collect();
        match self.nameable {
            true => {
                format!("{}; or give them by number: --columns \"{}\"", self.valid(), by_number.join(","))
            }
            false => self.valid(),
        }
    }

    fn valid(&self) -> String {
        self.columns.iter().map(|column| column.name).collect::<Vec<_>>().join(", ")
    }

    /// Whether a name is one of the columns, with or without its unit.
    pub(super) fn has_column(&self, name: &str) -> bool {
        let name = Name::new(name);
        self.columns.iter().any(|column| name.fits(column) != Fit::No)
    }

    fn same_column(&self, one: &str, other: &str) -> bool {
        let (one, other) = (Name::new(one), Name::new(other));
        self.columns.iter().any(|column| one.fits(column) != Fit::No && other.fits(column) != Fit::No)
    }

    /// The matching column, and the factor to its unit; `None` for a field that is skipped.
    fn column_of(
        &self,
        written: &str,
        meant: &str,
        unit: Option<&str>,
        by_user: bool,
    ) -> Result<Option<(usize, Option<f64>)>, TableErrorKind> {
        let name = Name::new(meant);
        let fits_of = |name: &Name| {
            let fits = self.columns.iter().map(|column| name.fits(column)).enumerate();
            // A column with this very unit has priority over one of another dimension: `angle_deg` and
            // `angle_h`.
            let mut fits: Vec<(usize, Fit)> = fits.filter(|(_, fit)| *fit != Fit::No).collect();
            fits.sort_by_key(|(_, fit)| !matches!(fit, Fit::Yes(_)));
            fits.into_iter().next()
        };
        let mut fit = fits_of(&name);
        if let Some((_, Fit::NoUnit)) = fit {
            // The unit may be in the name replaced by the user, or below the names.
            let own = Name::new(written);
            if let Some(unit) = own.unit().filter(|_| by_user).or(unit) {
                fit = fits_of(&name.clone().with_unit(unit));
            }
        } else if let (Some((column, Fit::Yes(factor))), Some(unit)) = (fit, unit) {
            let bare = Name::new(self.columns[column].quantity()).with_unit(unit);
            let differs = |other: f64| (other / factor - 1.0).abs() > 1e-9;
            if let Fit::Yes(other) = bare.fits(&self.columns[column])
                && differs(other)
            {
                return Err(TableErrorKind::TwoUnits { name: shown(written), unit: unit.to_owned() });
            }
        }
        let name = shown(if by_user { meant } else { written });
        let (column, fit) = match fit {
            Some(fit) => fit,
            None if by_user => return Err(TableErrorKind::NotAsked { name, valid: self.valid() }),
            None if self.others => return Ok(None),
            None => return Err(TableErrorKind::Unknown { name, valid: self.valid() }),
        };
        let column_of_form = &self.columns[column];
        let quantity = column_of_form.quantity();
        match (fit, column_of_form.dimension()) {
            (Fit::Yes(factor), _) => Ok(Some((column, Some(factor)))),
            (Fit::NoUnit, _) if column_of_form.holds == Holds::Stamps => Ok(Some((column, None))),
            (Fit::NoUnit, Some(dimension)) => {
                Err(TableErrorKind::NoUnit { name, quantity, dimension: UnitKind(dimension) })
            }
            (Fit::WrongUnit(dimension), _) => {
                Err(TableErrorKind::WrongUnit { name, quantity, dimension: UnitKind(dimension) })
            }
            _ => Err(TableErrorKind::Unknown { name, valid: self.valid() }),
        }
    }

    /// `theirs=ours` for columns of the file that are not read but may be intended, by the dimension of their
    /// units or as states of a joint.
    pub(super) fn proposal(&self, names: &[String], units: &[Option<String>], sources: &[Source]) -> String {
        if !self.nameable {
            return String::new();
        }
        let ros = names.iter().any(|name| name.contains("header.") || name.starts_with("field."));
        let mut proposed: Vec<(usize, String)> = Vec::new();
        for (field, written) in names.iter().enumerate() {
            if written.contains(',') || sources.iter().any(|source| source.field == field) {
                continue;
            }
            let name = Name::new(written);
            let unit = name.unit().or(units.get(field).and_then(|unit| unit.as_deref()));
            let (ours, dimension) =
                match (instrument::joint_state(written, ros), unit.and_then(unit::by_writing)) {
                    (Some((ours, _)), _) => (Some(ours), None),
                    (None, Some(unit)) => (None, Some(unit)),
                    (None, None) => continue,
                };
            let column = self.columns.iter().position(|column| match (ours, dimension) {
                (Some(ours), _) => matches!(Name::new(ours).fits(column), Fit::Yes(_)),
                (None, Some(unit)) => column.dimension() == Some(unit.dimension),
                _ => false,
            });
            let Some(column) = column else { continue };
            let taken = sources.iter().any(|source| source.column == column);
            if taken || proposed.iter().any(|(other, _)| *other == column) {
                continue;
            }
            let ours: String = match dimension {
                Some(unit) => format!("{}_{}", self.columns[column].quantity(), unit.endings[0]),
                None => ours.unwrap_or_default().to_owned(),
            };
            proposed.push((column, format!("{}={ours}", shown(written))));
        }
        proposed.into_iter().map(|(_, pair)| pair).collect::<Vec<_>>().join(",")
    }
}

/// The names in a file, at most the first twenty.
pub(super) fn first_names(names: &[String]) -> String {
    names.iter().take(20).map(|name| shown(name)).collect::<Vec<_>>().join(", ")
}

/// Columns of a file, for a remedy.
pub(super) fn found(names: &str, proposal: &str) -> String {
    match proposal {
        "" => format!("the file has {names}"),
        proposal => format!("the file has {names}: assign the columns, such as --columns \"{proposal}\""),
    }
}

/// Begins like a number and contains no letters but those of an exponent.
fn is_no_name(field: &str) -> bool {
    field.starts_with(|c: char| c.is_ascii_digit() || "+-.,".contains(c))
        && !field.chars().any(|c| c.is_alphabetic() && !matches!(c, 'e' | 'E'))
}

impl Source {
    pub(super) fn number(
        &mut self,
        field: &str,
        line: usize,
        column_of_form: &Column,
        separated_by_comma: bool,
        marks: &mut Marks,
    ) -> Result<f64, TableErrorKind> {
        let column = || self.written.clone();
        if field.is_empty() {
            return Err(TableErrorKind::Blank { column: column() });
        }
        if column_of_form.holds == Holds::Stamps && stamp::looks_like(field) {
            // Dates and plain numbers in one column would have different zeros.
            self.factor = Some(*self.factor.get_or_insert(1.0));
            return stamp::seconds(field)
                .ok_or_else(|| TableErrorKind::NotADate { column: column(), field: shown(field) });
        }
        let value = marks.read(field, line, separated_by_comma).map_err(|malformed| {
            let (column, field) = (column(), shown(field));
            match malformed {
                Malformed::NotANumber => TableErrorKind::NotANumber { column, field },
                Malformed::LeadingZero => TableErrorKind::LeadingZero { column, field },
                Malformed::Grouped => TableErrorKind::Grouped { column, field },
            }
        })?;
        let factor = match (self.factor, column_of_form.dimension()) {
            (Some(factor), _) => factor,
            (None, Some(dimension)) => stamp::unit_by_size(value).ok_or_else(|| TableErrorKind::NoUnit {
                name: column(),
                quantity: column_of_form.quantity(),
                dimension: UnitKind(dimension),
            })?,
            (None, None) => 1.0,
        };
        self.factor = Some(factor);
        let value = scaled(value, factor);
        match value.is_finite() {
            true => Ok(value),
            false => Err(TableErrorKind::NotANumber { column: column(), field: shown(field) }),
        }
    }
}

/// Value times factor; factors such as 1000 and 1/1000 are applied as whole numbers, with a single rounding.
fn scaled(value: f64, factor: f64) -> f64 {
    let near = |x: f64| ((x - x.round()).abs() < 1e-12 * x).then(|| x.round());
    match (near(factor), near(1.0 / factor)) {
        (Some(whole), _) if whole >= 1.0 => value * whole,
        (_, Some(whole)) if whole >= 1.0 => value / whole,
        _ => value * factor,
    }
}
