//! Tables: declared by their columns, filled from rows, kept by column.

use super::{Quantity, Value, csv};

/// A quantity and how to read it from a row.
#[derive(Debug, Clone, Copy)]
pub struct Column<R> {
    /// Name, meaning and format.
    pub quantity: Quantity,
    read: Read<R>,
}

#[derive(Debug, Clone, Copy)]
enum Read<R> {
    One(fn(&R) -> Value),
    /// One of several columns of the same kind: causes, parts, discs.
    Of(usize, fn(&R, usize) -> Value),
}

impl<R> Column<R> {
    /// A column whose cells are read from a row.
    pub const fn new(quantity: Quantity, value: fn(&R) -> Value) -> Column<R> {
        Column { quantity, read: Read::One(value) }
    }

    /// One of several columns with a common access by their number.
    pub const fn numbered(quantity: Quantity, index: usize, value: fn(&R, usize) -> Value) -> Column<R> {
        Column { quantity, read: Read::Of(index, value) }
    }

    /// The value in a row.
    pub fn value(&self, row: &R) -> Value {
        match self.read {
            Read::One(value) => value(row),
            Read::Of(index, value) => value(row, index),
        }
    }
}

/// Declaration of a table whose rows are made from `R`.
#[derive(Debug, Clone, Copy)]
pub struct TableOf<R> {
    /// File name without ending.
    pub name: &'static str,
    /// Meaning of a row.
    pub what: &'static str,
    /// Columns in the order of the file.
    pub columns: fn() -> Vec<Column<R>>,
}

impl<R> TableOf<R> {
    /// The table of these rows.
    pub fn fill<'a>(&self, rows: impl IntoIterator<Item = &'a R>) -> Table
    where
        R: 'a,
    {
        let declared = (self.columns)();
        let mut columns: Vec<TableColumn> = declared
            .iter()
            .map(|column| TableColumn { quantity: column.quantity, cells: Cells::Numbers(Vec::new()) })
            .collect();
        for (index, row) in rows.into_iter().enumerate() {
            for (column, filled) in declared.iter().zip(&mut columns) {
                filled.cells.push(column.value(row), index);
            }
        }
        Table { name: self.name, what: self.what, columns }
    }

    /// The quantities of its columns.
    pub fn quantities(&self) -> Vec<Quantity> {
        (self.columns)().into_iter().map(|column| column.quantity).collect()
    }
}

/// A filled table.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// File name without ending.
    pub name: &'static str,
    /// Meaning of a row.
    pub what: &'static str,
    /// Columns in the order of the file, all of one length.
    pub columns: Vec<TableColumn>,
}

/// A filled column.
#[derive(Debug, Clone, PartialEq)]
pub struct TableColumn {
    /// Name, meaning and format.
    pub quantity: Quantity,
    /// Values from the first row to the last.
    pub cells: Cells,
}

/// The values of a column. Absent numbers are NaN; a column of counts with absent values is a column of numbers.
#[derive(Debug, Clone, PartialEq)]
pub enum Cells {
    /// Numbers in the unit of the quantity.
    Numbers(Vec<f64>),
    /// Whole numbers of zero or more.
    Counts(Vec<u64>),
    /// Words or texts.
    Words(Vec<String>),
}

impl Cells {
    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Cells::Numbers(numbers) => numbers.len(),
            Cells::Counts(counts) => counts.len(),
            Cells::Words(words) => words.len(),
        }
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A cell by its row.
    pub fn value(&self, row: usize) -> Value {
        match self {
            Cells::Numbers(numbers) => match numbers[row] {
                number if number.is_nan() => Value::Absent,
                number => Value::Number(number),
            },
            Cells::Counts(counts) => Value::Count(counts[row]),
            Cells::Words(words) => Value::Word(words[row].clone()),
        }
    }

    /// Appends a cell; `row` cells are there already. The first cells decide the kind of the column.
    fn push(&mut self, value: Value, row: usize) {
        match (&mut *self, value) {
            (Cells::Numbers(numbers), Value::Number(number)) => numbers.push(number),
            (Cells::Numbers(numbers), Value::Absent) => numbers.push(f64::NAN),
            (Cells::Numbers(numbers), Value::Count(count)) if row == 0 => {
                debug_assert!(numbers.is_empty());
                *self = Cells::Counts(vec![count]);
            }
            (Cells::Numbers(numbers), Value::Count(count)) => numbers.push(count as f64),
            (Cells::Counts(counts), Value::Count(count)) => counts.push(count),
            (Cells::Counts(counts), Value::Absent) => {
                let mut numbers: Vec<f64> = counts.iter().map(|count| *count as f64).collect();
                numbers.push(f64::NAN);
                *self = Cells::Numbers(numbers);
            }
            (Cells::Words(words), Value::Absent) => words.push(String::new()),
            (Cells::Words(words), value) => words.push(plain(&value)),
            (_, value) => {
                // A word after absent values: the column becomes one of words.
                let mut words: Vec<String> = (0..row).map(|row| plain(&self.value(row))).collect();
                words.push(plain(&value));
                *self = Cells::Words(words);
            }
        }
    }
}

fn plain(value: &Value) -> String {
    match value {
        Value::Number(number) => csv::shortest(*number),
        Value::Count(count) => count.to_string(),
        Value::Word(word) => word.clone(),
        Value::Flag(flag) => flag.to_string(),
        _ => String::new(),
    }
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.cells.len())
    }

    /// A column by its key.
    pub fn column(&self, key: &str) -> Option<&TableColumn> {
        self.columns.iter().find(|column| column.quantity.key == key)
    }

    /// Numbers of a column by its key.
    pub fn numbers(&self, key: &str) -> Option<&[f64]> {
        match &self.column(key)?.cells {
            Cells::Numbers(numbers) => Some(numbers),
            _ => None,
        }
    }

    /// Name of its CSV file.
    pub fn file_name(&self) -> String {
        format!("{}.csv", self.name)
    }

    /// The table as CSV: units in the header, numbers with the fewest digits that read back to the same
    /// value, absent values as empty fields.
    pub fn to_csv(&self) -> String {
        csv::write(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{PLAIN, quantity};

    struct Row(Value);

    fn filled(values: Vec<Value>) -> Cells {
        const ONE: TableOf<Row> = TableOf {
            name: "one",
            what: "One column",
            columns: || vec![quantity("x", PLAIN, "x").of(|row: &Row| row.0.clone())],
        };
        let rows: Vec<Row> = values.into_iter().map(Row).collect();
        ONE.fill(rows.iter()).columns.remove(0).cells
    }

    #[test]
    fn kinds_follow_from_the_cells() {
        assert_eq!(filled(vec![1usize.into(), 2usize.into()]), Cells::Counts(vec![1, 2]));
        let Cells::Numbers(some) = filled(vec![1usize.into(), Value::Absent]) else { panic!() };
        assert!(some[0] == 1.0 && some[1].is_nan());
        let late = filled(vec![Value::Absent, "a".into(), Value::Absent]);
        assert_eq!(late, Cells::Words(vec![String::new(), "a".into(), String::new()]));
    }
}
