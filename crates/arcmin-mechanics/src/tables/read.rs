use super::column::{Column, Order};
use super::error::{TableError, TableErrorKind, shown};
use super::head::Head;
use super::naming::Naming;
use super::number::Marks;
use super::sources::first_names;
use super::table::{Cells, Read, Table};
use super::{instrument, text};

/// Limits of size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Size of the file.
    pub bytes: usize,
    /// Rows below the header.
    pub rows: usize,
    /// Names in the header.
    pub columns: usize,
}

impl Default for Limits {
    /// 512 MiB, ten million rows, 1024 columns.
    fn default() -> Limits {
        Limits { bytes: 512 << 20, rows: 10_000_000, columns: 1024 }
    }
}

/// Specification of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    pub(super) columns: Vec<Column>,
    pub(super) others: bool,
    pub(super) limits: Limits,
    pub(super) naming: Naming,
    pub(super) nameable: bool,
}

impl Form {
    /// Tables with these columns only.
    pub fn new(columns: &[Column]) -> Form {
        Form {
            columns: columns.to_vec(),
            others: false,
            limits: Limits::default(),
            naming: Naming::default(),
            nameable: false,
        }
    }

    /// Unknown columns are skipped, as in the logs of machines.
    pub fn with_others(self) -> Form {
        Form { others: true, ..self }
    }

    /// Columns named by the user (`--columns`); this option is mentioned if a column is missing.
    pub fn naming(self, naming: &Naming) -> Form {
        Form { naming: naming.clone(), nameable: true, ..self }
    }

    /// Limits other than those for files of users.
    pub fn with_limits(self, limits: Limits) -> Form {
        Form { limits, ..self }
    }

    /// Reads a table; `file` is used in messages only.
    ///
    /// Memory: one copy of the text, eight bytes for every number that is read and four for every row.
    ///
    /// # Errors
    /// The first error, with its line and a remedy.
    pub fn read(&self, bytes: &[u8], file: &str) -> Result<Table, TableError> {
        self.read_inner(bytes, file).map_err(|(line, kind)| TableError {
            file: shown(file),
            line: (line > 0).then_some(line),
            kind,
        })
    }

    fn read_inner(&self, bytes: &[u8], file: &str) -> Result<Table, (usize, TableErrorKind)> {
        if bytes.len() > self.limits.bytes {
            let what = format!("a file of {} bytes", bytes.len());
            return Err((0, TableErrorKind::TooLarge { what, limit: self.limits.bytes }));
        }
        let text = text::decode(bytes).map_err(|kind| (0, kind))?;
        if let Some((line, code)) = text::control_character(&text) {
            return Err((line, TableErrorKind::ControlCharacter(code)));
        }
        let clean = text::without_comments(&text, self.naming.skip_lines)?;
        // A last line without line end may be incomplete.
        let open = if text.ends_with('\n') { 0 } else { text.matches('\n').count() + 1 };
        drop(text);
        let Head { line: header_line, separator, names, mut sources, body_line, body, mut notes, proposal } =
            self.head(&clean)?;
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(if separator == b' ' { b'\t' } else { separator })
            .has_headers(false)
            .flexible(true)
            .terminator(csv::Terminator::Any(b'\n'))
            .from_reader(body.as_bytes());
        let mut record = csv::StringRecord::new();
        // Every record ends with its line, so its line is that of the next record minus one. (The position of a
        // record is that of the empty lines before it.)
        let next = |reader: &mut csv::Reader<&[u8]>, record: &mut csv::StringRecord| {
            let more = reader.read_record(record).map_err(|_| (header_line, TableErrorKind::NotText))?;
            let line = body_line + reader.position().line() as usize - 2;
            Ok::<_, (usize, TableErrorKind)>(more.then_some(line))
        };
        let mut cells: Vec<Cells> = sources
            .iter()
            .map(|source| match self.columns[source.column].is_number() {
                true => Cells::Numbers(Vec::new(), false),
                false => Cells::Words(Vec::new()),
            })
            .collect();
        let mut lines: Vec<u32> = Vec::new();
        let mut marks = Marks::default();
        let mut index = IndexColumn::of(&names, self.others);
        let mut end = End::of(&names, clean.cut, open);
        while let Some(line) = next(&mut reader, &mut record)? {
            let count = record.len();
            if record.iter().all(|field| field.trim().is_empty()) && count == names.len() {
                continue;
            }
            if end.is_cut(&record, line, lines.len()) {
                break;
            }
            if count != names.len() && !end.lacks_comment(count) {
                let (header, found, separator) = (names.len(), count, char::from(separator));
                return Err((line, TableErrorKind::FieldCount { header, found, separator }));
            }
            // Programs that append to a file repeat the names.
            if !lines.is_empty() && record.iter().zip(&names).all(|(field, name)| field.trim() == name) {
                notes.push(format!("line {line} repeats the names and is skipped"));
                continue;
            }
            if lines.len() == self.limits.rows {
                let what = "the number of rows".to_owned();
                return Err((line, TableErrorKind::TooLarge { what, limit: self.limits.rows }));
            }
            index.check(&record).map_err(|kind| (line, kind))?;
            for (source, cells) in sources.iter_mut().zip(&mut cells) {
                let field = record.get(source.field).unwrap_or_default().trim();
                let column = &self.columns[source.column];
                match cells {
                    Cells::Words(words) => words.push(field.to_owned()),
                    Cells::Numbers(_, gaps) if field.is_empty() && column.blanks => {
                        *gaps = true;
                        push(cells, f64::NAN);
                    }
                    Cells::Numbers(numbers, _) => {
                        let value = source
                            .number(field, line, column, separator == b',', &mut marks)
                            .and_then(|value| in_order(column, value, numbers.last()))
                            .map_err(|kind| (line, kind))?;
                        numbers.push(value);
                    }
                }
            }
            lines.push(u32::try_from(line).unwrap_or(u32::MAX));
        }
        notes.extend(end.cut.map(|line| format!("the last line, {line}, is incomplete and left out")));
        if lines.is_empty() {
            return Err((header_line, TableErrorKind::NoRows));
        }
        if let Some((line, field)) = marks.comma {
            if let Some(point) = marks.point {
                return Err((line, TableErrorKind::MixedMarks { point }));
            }
            // With semicolons as separators the comma is a decimal comma.
            if !marks.decimal_for_sure && !matches!(separator, b';' | b' ') {
                return Err((line, TableErrorKind::AmbiguousComma { field: shown(&field) }));
            }
        }
        let columns = sources.into_iter().zip(cells).map(|(source, cells)| Read {
            name: self.columns[source.column].name,
            written: source.written,
            meant: source.meant,
            cells,
        });
        let columns = columns.collect();
        let names = first_names(&names);
        Ok(Table { file: shown(file), header_line, lines, columns, names, proposal, notes })
    }
}

/// The column without a name that contains the row numbers of data frames.
struct IndexColumn {
    unnamed: Vec<usize>,
    others: bool,
    last: Option<f64>,
}

impl IndexColumn {
    fn of(names: &[String], others: bool) -> IndexColumn {
        let unnamed = (0..names.len()).filter(|i| names[*i].is_empty()).collect();
        IndexColumn { unnamed, others, last: None }
    }

    /// In the first column increasing whole numbers are skipped, in logs any values.
    fn check(&mut self, record: &csv::StringRecord) -> Result<(), TableErrorKind> {
        for field in &self.unnamed {
            let text = record.get(*field).unwrap_or_default().trim();
            let number = text.parse::<f64>().ok().filter(|number| number.fract() == 0.0);
            let rises = number.is_some_and(|number| self.last.is_none_or(|last| number > last));
            if *field == 0 && (self.others || rises) {
                self.last = number;
            } else if !text.is_empty() {
                return Err(TableErrorKind::Unnamed(field + 1));
            }
        }
        Ok(())
    }
}

/// End of the file.
struct End {
    names: usize,
    may_lack_last: bool,
    /// Line without line end, which may be incomplete; 0 if there is none.
    open: usize,
    /// Smallest number of decimals of the last field in all rows so far.
    decimals: usize,
    cut: Option<usize>,
}

impl End {
    fn of(names: &[String], cut: Option<usize>, open: usize) -> End {
        let may_lack_last = instrument::may_lack_last(names);
        End { names: names.len(), may_lack_last, open, decimals: usize::MAX, cut }
    }

    fn lacks_comment(&self, count: usize) -> bool {
        self.may_lack_last && count + 1 == self.names
    }

    /// Whether this is the last line, without line end, with fewer fields than required or fewer decimals than
    /// every line before.
    fn is_cut(&mut self, record: &csv::StringRecord, line: usize, rows: usize) -> bool {
        let last = record.get(self.names - 1).unwrap_or_default().trim();
        let decimals = last.split_once(['.', ',']).map_or(0, |(_, decimals)| decimals.len());
        if line != self.open || rows == 0 {
            self.decimals = self.decimals.min(decimals);
            return false;
        }
        let short = record.len() < self.names && !self.lacks_comment(record.len());
        let half = rows >= SURE && decimals < self.decimals && self.decimals != usize::MAX;
        if short || half {
            self.cut = Some(line);
        }
        short || half
    }
}

/// Number of rows from which on fewer decimals than in all others are significant.
const SURE: usize = 20;

fn push(cells: &mut Cells, value: f64) {
    if let Cells::Numbers(numbers, _) = cells {
        numbers.push(value);
    }
}

/// Checks range and order of a number in its column.
fn in_order(column: &Column, value: f64, before: Option<&f64>) -> Result<f64, TableErrorKind> {
    let (low, high) = column.within;
    let name = || column.name.to_owned();
    if !(low..=high).contains(&value) {
        return Err(TableErrorKind::OutOfRange { column: name(), value, low, high });
    }
    match (column.order, before) {
        (Order::Rising, Some(before)) if !(value > *before) => {
            Err(TableErrorKind::Order { column: name(), rule: "rise", value, before: *before })
        }
        (Order::NotFalling, Some(before)) if !(value >= *before) => {
            Err(TableErrorKind::Order { column: name(), rule: "not fall", value, before: *before })
        }
        _ => Ok(value),
    }
}
