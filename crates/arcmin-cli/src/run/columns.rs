//! Reading of columns of numbers from CSV files, with the place of whatever is wrong.

use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// A CSV file with a header: lines that begin with # and empty lines are passed over, the columns may stand
/// in any order.
pub struct Columns {
    path: PathBuf,
    header: Vec<String>,
    header_line: usize,
    /// Line in the file, counted from 1, and its fields.
    rows: Vec<(usize, Vec<String>)>,
    help: &'static str,
}

impl Columns {
    /// `help` shows what such a file looks like.
    pub fn read(path: &Path, help: &'static str) -> Result<Columns, Failure> {
        let text =
            std::fs::read_to_string(path).map_err(|cause| Failure::Read { path: path.to_owned(), cause })?;
        let fields = |line: &str| -> Vec<String> {
            line.split(',').map(|field| field.trim().trim_matches('"').to_owned()).collect()
        };
        // Spreadsheets put a byte-order mark in front.
        let text = text.trim_start_matches('\u{feff}');
        let mut lines = text
            .lines()
            .enumerate()
            .filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'))
            .map(|(index, line)| (index + 1, fields(line)));
        let (header_line, header) = lines.next().unwrap_or((1, Vec::new()));
        let columns = Columns { path: path.to_owned(), header, header_line, rows: lines.collect(), help };
        if columns.rows.is_empty() {
            return Err(columns.wrong(columns.header_line, "there are no rows below the header"));
        }
        Ok(columns)
    }

    pub fn has(&self, name: &str) -> bool {
        self.header.iter().any(|column| column == name)
    }

    pub fn wrong(&self, line: usize, what: &str) -> Failure {
        Failure::Usage {
            message: format!("{}, line {line}: {what}", self.path.display()),
            help: self.help.to_owned(),
        }
    }

    pub fn line_of_header(&self) -> usize {
        self.header_line
    }

    /// Line of a row, both counted as a user does: rows from 0, lines from 1.
    pub fn line(&self, row: usize) -> usize {
        self.rows.get(row).map_or(self.header_line, |row| row.0)
    }

    pub fn words(&self, name: &str) -> Result<Vec<&str>, Failure> {
        let Some(column) = self.header.iter().position(|header| header == name) else {
            let semicolons = self.header.len() == 1 && self.header[0].contains(';');
            let what = if semicolons {
                "the columns must be separated by commas".to_owned()
            } else {
                format!("there is no column {name}")
            };
            return Err(self.wrong(self.header_line, &what));
        };
        if let Some((line, _)) = self.rows.iter().find(|(_, fields)| fields.len() <= column) {
            return Err(self.wrong(*line, &format!("the row ends before the column {name}")));
        }
        Ok(self.rows.iter().map(|(_, fields)| fields[column].as_str()).collect())
    }

    pub fn numbers(&self, name: &str) -> Result<Vec<f64>, Failure> {
        let words = self.words(name)?;
        words
            .iter()
            .enumerate()
            .map(|(row, word)| match word.parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(number),
                _ => {
                    Err(self
                        .wrong(self.line(row), &format!("\"{word}\" in the column {name} is not a number")))
                }
            })
            .collect()
    }
}
