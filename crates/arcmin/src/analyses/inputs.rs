//! Files that analyses read, as values of the library.

use super::AnalysisError;
use crate::design::InputFile;
use crate::geometry::{FlankDataError, FlankError};
use crate::units::{DEG, UM};

/// Columns of a text file, with the place of whatever is wrong.
pub(crate) struct Columns<'a> {
    file: &'a InputFile,
    header: Vec<String>,
    header_line: usize,
    /// Line in the file, counted from 1, and its fields.
    rows: Vec<(usize, Vec<String>)>,
    help: &'static str,
}

impl<'a> Columns<'a> {
    /// `help` shows what such a file looks like.
    pub fn parse(
        file: &'a InputFile,
        bytes: &[u8],
        help: &'static str,
    ) -> Result<Columns<'a>, AnalysisError> {
        let wrong = |message: &str| AnalysisError::Input {
            file: file.0.clone(),
            line: None,
            message: message.to_owned(),
            help: help.to_owned(),
        };
        let text = std::str::from_utf8(bytes).map_err(|_| wrong("this is no text in UTF-8"))?;
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
        let columns = Columns { file, header, header_line, rows: lines.collect(), help };
        if columns.rows.is_empty() {
            return Err(columns.wrong(columns.header_line, "there are no rows below the header"));
        }
        Ok(columns)
    }

    pub fn has(&self, name: &str) -> bool {
        self.header.iter().any(|column| column == name)
    }

    pub fn wrong(&self, line: usize, what: &str) -> AnalysisError {
        AnalysisError::Input {
            file: self.file.0.clone(),
            line: Some(line),
            message: what.to_owned(),
            help: self.help.to_owned(),
        }
    }

    pub fn line_of_header(&self) -> usize {
        self.header_line
    }

    pub fn header(&self) -> &[String] {
        &self.header
    }

    /// Line of a row, both counted as a user does: rows from 0, lines from 1.
    pub fn line(&self, row: usize) -> usize {
        self.rows.get(row).map_or(self.header_line, |row| row.0)
    }

    pub fn words(&self, name: &str) -> Result<Vec<&str>, AnalysisError> {
        let Some(column) = self.header.iter().position(|header| header == name) else {
            return Err(self.wrong(self.header_line, &format!("there is no column {name}")));
        };
        if let Some((line, _)) = self.rows.iter().find(|(_, fields)| fields.len() <= column) {
            return Err(self.wrong(*line, &format!("the row ends before the column {name}")));
        }
        Ok(self.rows.iter().map(|(_, fields)| fields[column].as_str()).collect())
    }

    pub fn numbers(&self, name: &str) -> Result<Vec<f64>, AnalysisError> {
        let words = self.words(name)?;
        let number = |(row, word): (usize, &&str)| match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => {
                let what = format!("\"{word}\" in the column {name} is not a number");
                Err(self.wrong(self.line(row), &what))
            }
        };
        words.iter().enumerate().map(number).collect()
    }
}

/// A flank measured around the disc.
pub(crate) fn measured_flank(
    file: &InputFile,
    bytes: &[u8],
    lobe_count: usize,
) -> Result<FlankError, AnalysisError> {
    let help = "a header angle_deg,depth_um, then lines such as 0.25,-1.3 around the whole disc";
    let columns = Columns::parse(file, bytes, help)?;
    let (angles, depths) = (columns.numbers("angle_deg")?, columns.numbers("depth_um")?);
    if let Some(row) = depths.iter().position(|depth| depth.abs() > 500.0) {
        let what = format!("a depth of {} µm is more than this program believes (500 µm)", depths[row]);
        return Err(columns.wrong(columns.line(row), &what));
    }
    let points: Vec<(f64, f64)> =
        angles.iter().zip(&depths).map(|(angle, depth)| (angle * DEG, depth * UM)).collect();
    FlankError::from_measured(&points, lobe_count).map_err(|error| {
        let (row, what) = match error {
            FlankDataError::NotRising(row) => {
                (row, format!("the angles must rise, but {}° follows {}°", angles[row], angles[row - 1]))
            }
            FlankDataError::MoreThanATurn(row) => {
                (row, format!("{}° lies more than a turn after the first angle, {}°", angles[row], angles[0]))
            }
            FlankDataError::TooCoarse(row, gap, _) => (
                row,
                format!(
                    "a gap of {:.3}° follows; {lobe_count} lobes need a point every {:.3}° at least",
                    gap / DEG,
                    90.0 / lobe_count as f64
                ),
            ),
        };
        columns.wrong(columns.line(row), &what)
    })
}
