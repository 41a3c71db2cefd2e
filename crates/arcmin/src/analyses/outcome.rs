use std::fmt::Debug;

use crate::report::Page;
use crate::results::{Quantity, Summary, Table, Value};

/// Result of an analysis; owns all its data.
pub trait Outcome: Debug + Send + Sync {
    /// Its values by key.
    fn summary(&self) -> Summary;

    /// Its tables, each a file.
    fn tables(&self) -> Vec<Table>;

    /// Text for the terminal.
    fn text_blocks(&self) -> Vec<TextBlock>;

    /// The report without provenance, which the caller adds.
    fn page(&self) -> Page;

    /// Seeds of everything that was drawn.
    fn seeds(&self) -> Vec<u64> {
        Vec::new()
    }

    /// Further files: a mesh for ParaView.
    fn attachments(&self) -> Result<Vec<Attachment>, super::AnalysisError> {
        Ok(Vec::new())
    }

    /// Reason if it is incomplete; an aborted run keeps its results.
    fn failure(&self) -> Option<String> {
        None
    }

    /// For a downcast to the type of the analysis.
    fn as_any(&self) -> &dyn std::any::Any;
}

/// The result of an analysis in a module with its declarations in `SUMMARY` and `declared` and its texts and
/// report in `page`, computed with one fidelity; further methods in braces.
macro_rules! outcome {
    ($answer:ty { $($more:tt)* }) => {
        impl $crate::fidelity::HasFidelity for $answer {
            fn fidelity(&self) -> &$crate::fidelity::Fidelity {
                &self.fidelity
            }
        }

        impl $crate::analyses::Outcome for $answer {
            fn summary(&self) -> $crate::results::Summary {
                SUMMARY.fill(self)
            }

            fn tables(&self) -> Vec<$crate::results::Table> {
                declared::fill(self)
            }

            fn text_blocks(&self) -> Vec<$crate::analyses::TextBlock> {
                page::text_blocks(self)
            }

            fn page(&self) -> $crate::report::Page {
                page::page(self)
            }

            fn seeds(&self) -> Vec<u64> {
                self.fidelity.seeds()
            }

            fn as_any(&self) -> &dyn std::any::Any {
                self
            }

            $($more)*
        }
    };
}
pub(crate) use outcome;

/// A file that is neither table nor report.
#[derive(Debug, Clone, PartialEq)]
pub struct Attachment {
    /// Name of the file in the result directory.
    pub name: String,
    /// Content of the file.
    pub bytes: Vec<u8>,
}

/// A part of the terminal text.
#[derive(Debug, Clone, PartialEq)]
pub enum TextBlock {
    /// One line without line end.
    Line(String),
    /// Columns set below each other.
    Table(TextTable),
}

/// A small table of text; the first column is set left, the others right.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TextTable {
    /// Heads of the columns.
    pub header: Vec<String>,
    /// Cells row by row, as many as there are heads.
    pub rows: Vec<Vec<String>>,
}

impl TextBlock {
    /// One line from a text.
    pub fn line(text: impl Into<String>) -> TextBlock {
        TextBlock::Line(text.into())
    }

    /// Some columns of a table at some of its rows, named and formatted as declared.
    pub fn columns(table: &Table, keys: &[&str], rows: impl IntoIterator<Item = usize>) -> TextBlock {
        let columns: Vec<_> = keys.iter().filter_map(|key| table.column(key)).collect();
        let header = columns.iter().map(|column| heading(&column.quantity)).collect();
        let row = |row| columns.iter().map(|column| column.quantity.show(&column.cells.value(row))).collect();
        TextBlock::Table(TextTable { header, rows: rows.into_iter().map(row).collect() })
    }

    /// Some figures of a summary, one a row.
    pub fn figures(summary: &Summary, keys: &[&str]) -> TextBlock {
        let row = |key: &&str| {
            let (quantity, value) = summary.entries.iter().find(|(quantity, _)| quantity.key == *key)?;
            (*value != Value::Absent).then(|| vec![heading(quantity), quantity.show(value)])
        };
        TextBlock::Table(TextTable { header: Vec::new(), rows: keys.iter().filter_map(row).collect() })
    }
}

/// Name and unit of a quantity, as the head of a column.
fn heading(quantity: &Quantity) -> String {
    match quantity.unit() {
        "" => quantity.label(),
        unit => format!("{} {unit}", quantity.label()),
    }
}
