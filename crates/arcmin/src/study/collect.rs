use std::fmt::Write;

use super::part::{Cell, Record, decode};
use super::plan::Plan;
use super::run::{Store, setting_cell};

/// The available rows of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    /// In the order of their numbers.
    pub records: Vec<Record>,
    /// Rows that the plan has in all.
    pub of: u64,
    /// Names of parts that cannot be used, with the reason.
    pub unusable: Vec<(String, String)>,
}

/// Reads all available parts.
///
/// # Errors
/// A part cannot be read; with a sentence.
pub fn collect(plan: &Plan, store: &dyn Store) -> Result<Rows, String> {
    let mut rows = Rows { records: Vec::new(), of: plan.rows(), unusable: Vec::new() };
    for part in 0..plan.parts() {
        let name = plan.part_name(part);
        match store.read(&name)?.map(|bytes| decode(plan, part, bytes)) {
            None => {}
            Some(Ok(records)) => rows.records.extend(records),
            Some(Err(error)) => rows.unusable.push((name, error.to_string())),
        }
    }
    Ok(rows)
}

impl Rows {
    /// Rows without results.
    pub fn failed(&self) -> usize {
        self.records.iter().filter(|record| record.failed.is_some()).count()
    }

    /// Whether every row of the plan is there.
    pub fn is_complete(&self) -> bool {
        self.records.len() as u64 == self.of
    }

    /// Numbers of a column by its name, one for each record; `None` where there is none.
    pub fn numbers(&self, plan: &Plan, name: &str) -> Option<Vec<Option<f64>>> {
        let index = plan.columns().iter().position(|(column, _)| *column == name)?;
        Some(self.records.iter().map(|record| as_number(&record.cells[index])).collect())
    }

    /// Numbers of a column in the place of every row of the plan, for statistics that go by the layout: `None` for
    /// rows that failed or are missing.
    pub fn in_place(&self, plan: &Plan, name: &str) -> Option<Vec<Option<f64>>> {
        let index = plan.columns().iter().position(|(column, _)| *column == name)?;
        let mut all = vec![None; usize::try_from(self.of).ok()?];
        for record in &self.records {
            if let Some(place) = usize::try_from(record.number).ok().and_then(|number| all.get_mut(number)) {
                *place = as_number(&record.cells[index]);
            }
        }
        Some(all)
    }

    /// The table as CSV: `sample`, what varies, the results, `failed`. Numbers have the shortest form that reads back
    /// to the same bits, so that equal rows are equal bytes; values of a curve are separated by spaces.
    pub fn to_csv(&self, plan: &Plan) -> String {
        let mut out = String::from("sample");
        for (name, _) in plan.columns() {
            out.push(',');
            push_text(&mut out, name);
        }
        out.push_str(",failed\n");
        for record in &self.records {
            let _ = write!(out, "{}", record.number);
            for cell in &record.cells {
                out.push(',');
                push_cell(&mut out, cell);
            }
            out.push(',');
            push_text(&mut out, record.failed.as_deref().unwrap_or_default());
            out.push('\n');
        }
        out
    }
}

impl Plan {
    /// The rows to compute as CSV: `sample` and what varies.
    pub fn to_csv(&self) -> String {
        let mut out = String::from("sample");
        for factor in self.factors() {
            out.push(',');
            push_text(&mut out, &factor.path);
        }
        out.push('\n');
        for number in 0..self.rows() {
            let _ = write!(out, "{number}");
            for setting in self.row(number).settings {
                out.push(',');
                push_cell(&mut out, &setting_cell(&setting));
            }
            out.push('\n');
        }
        out
    }
}

fn push_cell(out: &mut String, cell: &Cell) {
    match cell {
        Cell::Absent => {}
        Cell::Number(number) => push_number(out, *number),
        Cell::Word(word) => push_text(out, word),
        Cell::Curve(curve) => {
            for (k, number) in curve.iter().enumerate() {
                if k > 0 {
                    out.push(' ');
                }
                push_number(out, *number);
            }
        }
    }
}

/// Converts words that are numbers (counts), and yes and no.
fn as_number(cell: &Cell) -> Option<f64> {
    match cell {
        Cell::Word(word) if word == "true" => Some(1.0),
        Cell::Word(word) if word == "false" => Some(0.0),
        Cell::Word(word) => word.parse().ok().filter(|number: &f64| number.is_finite()),
        cell => cell.number(),
    }
}

fn push_number(out: &mut String, number: f64) {
    // Large and small ones with an exponent.
    let magnitude = number.abs();
    let _ = if number == 0.0 || (1e-5..1e16).contains(&magnitude) {
        write!(out, "{number}")
    } else {
        write!(out, "{number:e}")
    };
}

/// Quoted if it contains a comma, a quotation mark or a line end.
fn push_text(out: &mut String, text: &str) {
    if text.contains([',', '"', '\n', '\r']) {
        let _ = write!(out, "\"{}\"", text.replace('"', "\"\""));
    } else {
        out.push_str(text);
    }
}
