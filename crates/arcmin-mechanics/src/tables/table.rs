use super::error::{TableError, TableErrorKind};

/// Columns that were read, with the line numbers of the rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub(super) file: String,
    pub(super) header_line: usize,
    pub(super) lines: Vec<u32>,
    pub(super) columns: Vec<Read>,
    pub(super) names: String,
    pub(super) proposal: String,
    pub(super) notes: Vec<String>,
}

/// A column that was read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Read {
    pub name: &'static str,
    /// Name in the file.
    pub written: String,
    /// Name in the file, or the one given by the user.
    pub meant: String,
    pub cells: Cells,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cells {
    /// Gaps are stored as NaN; [`Table::numbers`] never returns them.
    Numbers(Vec<f64>, bool),
    Words(Vec<String>),
}

impl Table {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.lines.len()
    }

    /// Always false: a table without rows is an error.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// Whether the file has the column.
    pub fn has(&self, name: &str) -> bool {
        self.columns.iter().any(|column| column.name == name)
    }

    /// The name of a column in the file, or the one given by [`super::Naming`].
    pub fn meant(&self, name: &str) -> &str {
        self.columns.iter().find(|column| column.name == name).map_or("", |column| &column.meant)
    }

    /// The name of a column in the file.
    pub fn written(&self, name: &str) -> &str {
        self.columns.iter().find(|column| column.name == name).map_or("", |column| &column.written)
    }

    /// All names in the file, at most the first twenty.
    pub fn names(&self) -> &str {
        &self.names
    }

    /// Columns of the file that are not read but have the dimension of a column that may be intended, as a list
    /// of `theirs=ours`; empty if there are none.
    pub fn proposal(&self) -> &str {
        &self.proposal
    }

    /// Messages on rows that were skipped or changed.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Line in the file of a row, rows counted from 0 and lines from 1.
    pub fn line(&self, row: usize) -> usize {
        self.lines.get(row).map_or(self.header_line, |line| *line as usize)
    }

    /// Line of the header, counted from 1.
    pub fn header_line(&self) -> usize {
        self.header_line
    }

    /// A column of numbers without gaps, in the unit of its name.
    ///
    /// # Errors
    /// If the file has no such column, or a field of it is empty.
    pub fn numbers(&self, name: &str) -> Result<&[f64], TableError> {
        match self.cells(name)? {
            Cells::Numbers(numbers, false) => Ok(numbers),
            Cells::Numbers(numbers, true) => {
                let row = numbers.iter().position(|number| number.is_nan()).unwrap_or(0);
                Err(self.error(self.line(row), TableErrorKind::Blank { column: name.to_owned() }))
            }
            Cells::Words(_) => Err(self.missing(name)),
        }
    }

    /// A column of numbers that may have gaps.
    ///
    /// # Errors
    /// If the file has no such column.
    pub fn gaps(&self, name: &str) -> Result<Vec<Option<f64>>, TableError> {
        match self.cells(name)? {
            Cells::Numbers(numbers, _) => {
                Ok(numbers.iter().map(|number| (!number.is_nan()).then_some(*number)).collect())
            }
            Cells::Words(_) => Err(self.missing(name)),
        }
    }

    /// A column of words.
    ///
    /// # Errors
    /// If the file has no such column.
    pub fn words(&self, name: &str) -> Result<&[String], TableError> {
        match self.cells(name)? {
            Cells::Words(words) => Ok(words),
            Cells::Numbers(..) => Err(self.missing(name)),
        }
    }

    /// An error about the content of a row, for users of the columns; a row beyond the last is the header.
    pub fn wrong(&self, row: usize, message: impl Into<String>, remedy: impl Into<String>) -> TableError {
        let kind = TableErrorKind::Content { message: message.into(), remedy: remedy.into() };
        self.error(self.line(row), kind)
    }

    fn cells(&self, name: &str) -> Result<&Cells, TableError> {
        let found = self.columns.iter().find(|column| column.name == name);
        found.map(|column| &column.cells).ok_or_else(|| self.missing(name))
    }

    fn missing(&self, name: &str) -> TableError {
        let kind = TableErrorKind::Missing {
            name: name.to_owned(),
            rows: None,
            found: super::sources::found(&self.names, &self.proposal),
        };
        self.error(self.header_line, kind)
    }

    fn error(&self, line: usize, kind: TableErrorKind) -> TableError {
        TableError { file: self.file.clone(), line: Some(line), kind }
    }
}
