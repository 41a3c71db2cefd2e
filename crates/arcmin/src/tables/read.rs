use super::column::{Column, Fit, Holds, Name, Order};
use super::error::{TableError, TableErrorKind, UnitKind, shown};
use super::number::{Malformed, Marks};
use super::{text, unit};

/// How much is read at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    pub bytes: usize,
    pub rows: usize,
    pub columns: usize,
}

impl Default for Limits {
    /// 512 MiB, ten million rows, 1024 columns.
    fn default() -> Limits {
        Limits { bytes: 512 << 20, rows: 10_000_000, columns: 1024 }
    }
}

/// What a table must look like.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    columns: Vec<Column>,
    others: bool,
    limits: Limits,
}

/// Columns that were read, with the line of every row.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    file: String,
    header_line: usize,
    lines: Vec<u32>,
    columns: Vec<(&'static str, Cells)>,
}

#[derive(Debug, Clone, PartialEq)]
enum Cells {
    /// Gaps are NaN inside; [`Table::numbers`] never gives them out.
    Numbers(Vec<f64>, bool),
    Words(Vec<String>),
}

/// A column of the file that is wanted: its place in the row, what it is, the factor to the wanted unit.
struct Source {
    field: usize,
    column: usize,
    factor: f64,
    written: String,
}

impl Form {
    /// Tables of these columns and no others.
    pub fn new(columns: &[Column]) -> Form {
        Form { columns: columns.to_vec(), others: false, limits: Limits::default() }
    }

    /// Columns that nothing is known of are passed over, as in the logs of machines.
    pub fn with_others(self) -> Form {
        Form { others: true, ..self }
    }

    pub fn with_limits(self, limits: Limits) -> Form {
        Form { limits, ..self }
    }

    /// Reads a table; `file` serves messages only.
    ///
    /// Memory: one copy of the text, eight bytes for every number that is wanted and four for every row.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line and a remedy.
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
        let clean = text::without_comments(&text)?;
        drop(text);
        let (header_line, separator, body) = header_of(&clean)?;
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(separator)
            .has_headers(false)
            .flexible(true)
            .terminator(csv::Terminator::Any(b'\n'))
            .from_reader(body.as_bytes());
        let mut record = csv::StringRecord::new();
        // Every record ends with its line, so the line after it, less one, is its own. (The position of a
        // record is that of the empty lines before it.)
        let next = |reader: &mut csv::Reader<&[u8]>, record: &mut csv::StringRecord| {
            let more = reader.read_record(record).map_err(|_| (header_line, TableErrorKind::NotText))?;
            let line = header_line + reader.position().line() as usize - 2;
            Ok::<_, (usize, TableErrorKind)>(more.then_some(line))
        };
        next(&mut reader, &mut record)?;
        let names: Vec<String> = record.iter().map(|name| name.trim().to_owned()).collect();
        let sources = self.sources(&names, &shown(first_line(body))).map_err(|kind| (header_line, kind))?;

        let mut cells: Vec<Cells> = sources
            .iter()
            .map(|source| match self.columns[source.column].holds {
                Holds::Numbers => Cells::Numbers(Vec::new(), false),
                Holds::Words => Cells::Words(Vec::new()),
            })
            .collect();
        let mut lines: Vec<u32> = Vec::new();
        let mut marks = Marks::default();
        let unnamed: Vec<usize> = (0..names.len()).filter(|i| names[*i].is_empty()).collect();
        while let Some(line) = next(&mut reader, &mut record)? {
            if record.iter().all(|field| field.trim().is_empty()) && record.len() == names.len() {
                continue;
            }
            if record.len() != names.len() {
                let (header, found, separator) = (names.len(), record.len(), char::from(separator));
                return Err((line, TableErrorKind::FieldCount { header, found, separator }));
            }
            if lines.len() == self.limits.rows {
                let what = "the number of rows".to_owned();
                return Err((line, TableErrorKind::TooLarge { what, limit: self.limits.rows }));
            }
            if let Some(field) = unnamed.iter().find(|field| !record[**field].trim().is_empty()) {
                return Err((line, TableErrorKind::Unnamed(field + 1)));
            }
            for (source, cells) in sources.iter().zip(&mut cells) {
                let field = record[source.field].trim();
                let column = &self.columns[source.column];
                match cells {
                    Cells::Words(words) => words.push(field.to_owned()),
                    Cells::Numbers(_, gaps) if field.is_empty() && column.blanks => {
                        *gaps = true;
                        push(cells, f64::NAN);
                    }
                    Cells::Numbers(numbers, _) => {
                        let value = source
                            .number(field, line, separator == b',', &mut marks)
                            .and_then(|value| in_order(column, value, numbers.last()))
                            .map_err(|kind| (line, kind))?;
                        numbers.push(value);
                    }
                }
            }
            lines.push(u32::try_from(line).unwrap_or(u32::MAX));
        }
        if lines.is_empty() {
            return Err((header_line, TableErrorKind::NoRows));
        }
        if let Some((line, field)) = marks.comma {
            if let Some(point) = marks.point {
                return Err((line, TableErrorKind::MixedMarks { point }));
            }
            // Who separates by semicolons does so because the comma is taken by the decimals.
            if !marks.decimal_for_sure && separator != b';' {
                return Err((line, TableErrorKind::AmbiguousComma { field: shown(&field) }));
            }
        }
        let columns = sources
            .iter()
            .zip(cells)
            .map(|(source, cells)| (self.columns[source.column].name, cells))
            .collect();
        Ok(Table { file: shown(file), header_line, lines, columns })
    }

    /// Which field of a row is which column.
    fn sources(&self, names: &[String], line: &str) -> Result<Vec<Source>, TableErrorKind> {
        if names.len() > self.limits.columns {
            let what = format!("a header of {} columns", names.len());
            return Err(TableErrorKind::TooLarge { what, limit: self.limits.columns });
        }
        let is_number = |name: &String| name.starts_with(|c: char| c.is_ascii_digit() || "+-.,".contains(c));
        let wanted = || self.columns.iter().map(|column| column.name).collect::<Vec<_>>().join(", ");
        if names.iter().any(is_number) {
            return Err(TableErrorKind::NoHeader { found: line.to_owned(), wanted: wanted() });
        }
        let mut sources: Vec<Source> = Vec::new();
        for (field, written) in names.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
            let name = Name::new(written);
            let fits = self.columns.iter().map(|column| name.fits(column)).enumerate();
            // A column of that very unit goes before one of another dimension: `angle_deg` and `angle_h`.
            let mut fits: Vec<(usize, Fit)> = fits.filter(|(_, fit)| *fit != Fit::No).collect();
            fits.sort_by_key(|(_, fit)| !matches!(fit, Fit::Yes(_)));
            let shown_name = shown(written);
            match fits.first() {
                None if self.others => {}
                None => return Err(TableErrorKind::Unknown { name: shown_name, wanted: wanted() }),
                Some((column, Fit::Yes(factor))) => {
                    if let Some(first) = sources.iter().find(|source| source.column == *column) {
                        return Err(TableErrorKind::Twice {
                            first: first.written.clone(),
                            second: shown_name,
                        });
                    }
                    sources.push(Source { field, column: *column, factor: *factor, written: shown_name });
                }
                Some((column, fit)) => {
                    let column = &self.columns[*column];
                    let quantity = column.quantity();
                    let dimension = unit::split(column.name).1.map(|unit| unit.dimension);
                    return Err(match (fit, dimension) {
                        (Fit::NoUnit, Some(dimension)) => TableErrorKind::NoUnit {
                            name: shown_name,
                            quantity,
                            dimension: UnitKind(dimension),
                        },
                        (Fit::WrongUnit(dimension), _) => TableErrorKind::WrongUnit {
                            name: shown_name,
                            quantity,
                            dimension: UnitKind(*dimension),
                        },
                        _ => TableErrorKind::Unknown { name: shown_name, wanted: wanted() },
                    });
                }
            }
        }
        for (index, column) in self.columns.iter().enumerate().filter(|(_, column)| column.required) {
            if !sources.iter().any(|source| source.column == index) {
                let found: Vec<String> = names.iter().take(20).map(|name| shown(name)).collect();
                return Err(TableErrorKind::Missing {
                    name: column.name.to_owned(),
                    found: found.join(", "),
                });
            }
        }
        Ok(sources)
    }
}

fn push(cells: &mut Cells, value: f64) {
    if let Cells::Numbers(numbers, _) = cells {
        numbers.push(value);
    }
}

fn first_line(text: &str) -> &str {
    text.split('\n').next().unwrap_or("")
}

/// Line of the header, its separator, and the text from it on. A `sep=;` line of spreadsheets goes before.
fn header_of(clean: &str) -> Result<(usize, u8, &str), (usize, TableErrorKind)> {
    let mut rest = clean;
    let mut line = 1;
    let mut told = None;
    while !rest.is_empty() {
        let (first, after) = rest.split_once('\n').unwrap_or((rest, ""));
        let trimmed = first.trim().trim_matches('"');
        if let Some(separator) = trimmed.strip_prefix("sep=").filter(|_| told.is_none()) {
            told = match separator {
                ";" => Some(b';'),
                "," => Some(b','),
                // Trimming has taken a tab away.
                "" | "\t" => Some(b'\t'),
                _ => {
                    let found = shown(trimmed);
                    return Err((line, TableErrorKind::MixedSeparators { found, kinds: shown(separator) }));
                }
            };
        } else if !trimmed.is_empty() {
            let separator = match told {
                Some(separator) => separator,
                // Numbers where names belong are said as that, whatever stands between them.
                None if !first.chars().any(|c| c.is_alphabetic() && !matches!(c, 'e' | 'E')) => b',',
                None => text::separator(first).map_err(|kind| (line, kind))?,
            };
            return Ok((line, separator, rest));
        }
        rest = after;
        line += 1;
    }
    Err((0, TableErrorKind::Empty))
}

impl Source {
    fn number(
        &self,
        field: &str,
        line: usize,
        separated_by_comma: bool,
        marks: &mut Marks,
    ) -> Result<f64, TableErrorKind> {
        let column = || self.written.clone();
        if field.is_empty() {
            return Err(TableErrorKind::Blank { column: column() });
        }
        let value = marks.read(field, line, separated_by_comma).map_err(|malformed| {
            let (column, field) = (column(), shown(field));
            match malformed {
                Malformed::NotANumber => TableErrorKind::NotANumber { column, field },
                Malformed::LeadingZero => TableErrorKind::LeadingZero { column, field },
                Malformed::Grouped => TableErrorKind::Grouped { column, field },
            }
        })?;
        let value = scaled(value, self.factor);
        match value.is_finite() {
            true => Ok(value),
            false => Err(TableErrorKind::NotANumber { column: column(), field: shown(field) }),
        }
    }
}

/// Value times factor; factors such as 1000 and 1/1000 act as whole numbers, which rounds once.
fn scaled(value: f64, factor: f64) -> f64 {
    let near = |x: f64| ((x - x.round()).abs() < 1e-12 * x).then(|| x.round());
    match (near(factor), near(1.0 / factor)) {
        (Some(whole), _) if whole >= 1.0 => value * whole,
        (_, Some(whole)) if whole >= 1.0 => value / whole,
        _ => value * factor,
    }
}

/// Range and order of a number in its column.
fn in_order(column: &Column, value: f64, before: Option<&f64>) -> Result<f64, TableErrorKind> {
    let (low, high) = column.within;
    let name = || column.name.to_owned();
    if !(low..=high).contains(&value) {
        return Err(TableErrorKind::Unbelievable { column: name(), value, low, high });
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

impl Table {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.lines.len()
    }

    /// Never: a table without rows is not read.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// Whether the file has the column.
    pub fn has(&self, name: &str) -> bool {
        self.columns.iter().any(|(column, _)| *column == name)
    }

    /// Line in the file of a row, rows counted from 0 and lines from 1.
    pub fn line(&self, row: usize) -> usize {
        self.lines.get(row).map_or(self.header_line, |line| *line as usize)
    }

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

    /// An error about what a row says, for whoever uses the columns.
    pub fn wrong(&self, row: usize, message: impl Into<String>, remedy: impl Into<String>) -> TableError {
        let kind = TableErrorKind::Content { message: message.into(), remedy: remedy.into() };
        self.error(self.line(row), kind)
    }

    fn cells(&self, name: &str) -> Result<&Cells, TableError> {
        let found = self.columns.iter().find(|(column, _)| *column == name);
        found.map(|(_, cells)| cells).ok_or_else(|| self.missing(name))
    }

    fn missing(&self, name: &str) -> TableError {
        let found: Vec<&str> = self.columns.iter().map(|(column, _)| *column).collect();
        let kind = TableErrorKind::Missing { name: name.to_owned(), found: found.join(", ") };
        self.error(self.header_line, kind)
    }

    fn error(&self, line: usize, kind: TableErrorKind) -> TableError {
        TableError { file: self.file.clone(), line: Some(line), kind }
    }
}
