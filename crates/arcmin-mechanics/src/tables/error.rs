use super::unit::{self, Dimension};

/// Reason why a table cannot be read: line, fault and remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{file}{place}: {kind}", place = place(*.line))]
pub struct TableError {
    /// Name of the file, for the message only.
    pub file: String,
    /// Line counted from 1; `None` for the file as a whole.
    pub line: Option<usize>,
    /// Fault with the names and numbers in its message.
    pub kind: TableErrorKind,
}

fn above(rows: Option<usize>) -> String {
    rows.map_or(String::new(), |rows| format!(" above the rows, which begin in line {rows}"))
}

fn place(line: Option<usize>) -> String {
    line.map_or(String::new(), |line| format!(", line {line}"))
}

/// Faults of tables.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TableErrorKind {
    /// The file contains no text.
    #[error("there is no text in the file")]
    Empty,
    /// The bytes are not text in a known encoding.
    #[error("the file is neither UTF-8 nor Latin-1 nor UTF-16 text")]
    NotText,
    /// Code of a control character that is not allowed in a text table.
    #[error("there is a control character (code {0})")]
    ControlCharacter(u32),
    /// A quotation mark is not closed on its line.
    #[error("a quote is opened but not closed on its line")]
    OpenQuote,
    /// The table exceeds a limit of [`Form::with_limits`](super::Form::with_limits).
    #[error("{what} exceeds the limit of {limit}")]
    TooLarge {
        /// Limited quantity as named in the message.
        what: String,
        /// Largest number accepted: bytes, rows or columns.
        limit: usize,
    },
    /// There are numbers in place of the header.
    #[error("the first line \"{found}\" contains numbers instead of the names of the columns")]
    NoHeader {
        /// First line of the file.
        found: String,
        /// Names of the columns of a valid header.
        valid: String,
    },
    /// The header contains more than one kind of separator.
    #[error("the header \"{found}\" holds more than one kind of separator ({kinds})")]
    MixedSeparators {
        /// Header, shortened.
        found: String,
        /// Separators found in it.
        kinds: String,
    },
    /// The number of fields of a row differs from the number of names.
    #[error("the header names {header} columns, but here are {found} fields")]
    FieldCount {
        /// Names in the header.
        header: usize,
        /// Fields in the row.
        found: usize,
        /// Separator of the row.
        separator: char,
    },
    /// The file has a header and no rows.
    #[error("there are no rows below the header")]
    NoRows,
    /// Number of a column with values but without a name, counted from 1.
    #[error("column {0} has no name")]
    Unnamed(usize),
    /// Two columns of the file have the same meaning.
    #[error("the columns \"{first}\" and \"{second}\" are the same")]
    Twice {
        /// Name of the left column.
        first: String,
        /// Name of the right column.
        second: String,
    },
    /// An unknown name in the header.
    #[error("the column \"{name}\" is unknown")]
    Unknown {
        /// Name in the file.
        name: String,
        /// Known columns.
        valid: String,
    },
    /// A mandatory column is missing.
    #[error("there is no column {name}{}", above(*.rows))]
    Missing {
        /// Name of the column.
        name: String,
        /// Line of the first row, if there are more lines than the names above it.
        rows: Option<usize>,
        /// The columns of the file, with candidates for the missing one.
        found: String,
    },
    /// A name that the caller assigned to a column is not in the file.
    #[error("there is no column \"{name}\" to take as another")]
    NotInFile {
        /// Name given by the caller.
        name: String,
        /// First names of the file.
        found: String,
    },
    /// A column was assigned to an unknown name.
    #[error("no column is called \"{name}\" here")]
    NotAsked {
        /// Name given by the caller.
        name: String,
        /// Known columns.
        valid: String,
    },
    /// The units in the name and in the row of units contradict each other.
    #[error("the column \"{name}\" has another unit than {unit} of the row of units")]
    TwoUnits {
        /// Name of the column with its unit.
        name: String,
        /// Unit in the row of units.
        unit: String,
    },
    /// The name of a column of a physical quantity has no unit.
    #[error("the column \"{name}\" has no unit")]
    NoUnit {
        /// Name in the file.
        name: String,
        /// Name of the column without its unit.
        quantity: &'static str,
        /// Dimension of the units in the remedy.
        dimension: UnitKind,
    },
    /// The unit of a column has another dimension.
    #[error("the unit of the column \"{name}\" is not one of those for {quantity}")]
    WrongUnit {
        /// Name in the file.
        name: String,
        /// Name of the column without its unit.
        quantity: &'static str,
        /// Dimension of the units in the remedy.
        dimension: UnitKind,
    },
    /// A mandatory value is empty.
    #[error("the field of column {column} is empty")]
    Blank {
        /// Name of the column.
        column: String,
    },
    /// A field is not a number.
    #[error("\"{field}\" in column {column} is not a finite number")]
    NotANumber {
        /// Name of the column.
        column: String,
        /// Text of the field, shortened.
        field: String,
    },
    /// A field of a column of times is neither a number nor a date.
    #[error("\"{field}\" in column {column} is neither a number nor a date with the time of day")]
    NotADate {
        /// Name of the column.
        column: String,
        /// Text of the field, shortened.
        field: String,
    },
    /// A field such as 078: probably the decimals of the field before it.
    #[error("\"{field}\" in column {column} has a leading zero and is not a number")]
    LeadingZero {
        /// Name of the column.
        column: String,
        /// Text of the field, shortened.
        field: String,
    },
    /// A number has separators of thousands.
    #[error("\"{field}\" in column {column} groups thousands")]
    Grouped {
        /// Name of the column.
        column: String,
        /// Text of the field, shortened.
        field: String,
    },
    /// The file contains both decimal points and decimal commas.
    #[error("numbers have a comma here but a point in line {point}")]
    MixedMarks {
        /// Line with a decimal point, counted from 1.
        point: usize,
    },
    /// A comma may be a decimal comma or a separator of thousands, and no other field of the file decides it.
    #[error("the comma of \"{field}\" may be a decimal comma or group thousands")]
    AmbiguousComma {
        /// Text of the field, shortened.
        field: String,
    },
    /// A number is outside the range of its column.
    #[error("{} in column {column} is out of the allowed range {} to {}", plain(*.value), plain(*.low), plain(*.high))]
    OutOfRange {
        /// Name of the column.
        column: String,
        /// Number, in the required unit of the column.
        value: f64,
        /// Least value accepted, in the same unit.
        low: f64,
        /// Largest value accepted, in the same unit.
        high: f64,
    },
    /// The values of a column are not in the required order.
    #[error("{column} must {rule}, but {value} follows {before}")]
    Order {
        /// Name of the column.
        column: String,
        /// Required order: "rise" or "not fall".
        rule: &'static str,
        /// Value that violates the order.
        value: f64,
        /// Value of the previous row.
        before: f64,
    },
    /// Errors found by a command in columns that were read.
    #[error("{message}")]
    Content {
        /// Fault in one sentence.
        message: String,
        /// Advice in one sentence.
        remedy: String,
    },
}

/// The dimension of a column, opaque to other crates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitKind(pub(super) Dimension);

impl TableError {
    /// Remedy as text.
    pub fn remedy(&self) -> String {
        use TableErrorKind::*;
        match &self.kind {
            Empty | NoRows => "give a header with the names of the columns and rows of values below it".into(),
            NotText => "save it as UTF-8 (in a spreadsheet: \"CSV UTF-8\")".into(),
            ControlCharacter(_) => "export the file again as plain text; such characters belong to other formats".into(),
            OpenQuote => "close it on the same line, or write a quote inside of a field twice".into(),
            TooLarge { .. } => "thin the data out, or split the file".into(),
            NoHeader { valid, .. } => format!("put a line with the names in front: {valid}"),
            MixedSeparators { .. } => "separate by one of comma, semicolon and tab, and quote names that contain it".into(),
            FieldCount { header: 1, .. } => "one name, so nothing is separated: write decimal points, or name every column".into(),
            FieldCount { separator: ',', .. } => {
                "if these are decimal commas, separate the fields by semicolons or write decimal points".into()
            }
            FieldCount { separator, .. } => {
                let name = match separator {
                    '\t' => "tabs",
                    ' ' => "blanks",
                    _ => "semicolons",
                };
                format!("give every row as many fields as the header names, separated by {name}")
            }
            Unnamed(_) => "name it, or delete its values".into(),
            Twice { .. } => "keep one of them".into(),
            Unknown { valid, .. } => format!("rename or delete it; known columns: {valid}"),
            Missing { found, .. } => format!("add or rename it; {found}"),
            NotInFile { found, .. } => format!("the file has {found}"),
            NotAsked { valid, .. } => format!("known columns: {valid}"),
            TwoUnits { .. } => "keep the right one of the two".into(),
            NoUnit { quantity, dimension, .. } | WrongUnit { quantity, dimension, .. } => {
                format!("name it {quantity} with one of the endings {}", unit::endings_of(dimension.0))
            }
            Blank { .. } => "write the value, or delete the row".into(),
            NotADate { .. } => "write seconds, or dates such as 2026-03-03T11:20:53.419".into(),
            NotANumber { field, .. } if field.contains([';', '\t', ' ']) => {
                "separate the fields of the rows like the names of the header".into()
            }
            NotANumber { .. } => "write digits with a decimal point, such as 0.078 or 1.5e-3".into(),
            LeadingZero { .. } => {
                "if it belongs to the number before as its decimals, separate fields by semicolons or write decimal points; \
                 else drop the zero"
                    .into()
            }
            Grouped { .. } => "write the number without separators between its thousands".into(),
            MixedMarks { .. } => "use the same decimal mark in the whole file".into(),
            AmbiguousComma { .. } => "write decimal points and no separators of thousands".into(),
            OutOfRange { .. } => "check the unit in the column's name".into(),
            Order { rule: "rise", value, before, .. } if value == before => {
                "keep one row for each value; in the file of a load, two rows at one time are a step".into()
            }
            Order { .. } => "sort the rows, or look for a restart of the recording".into(),
            Content { remedy, .. } => remedy.clone(),
        }
    }
}

/// A number without long series of zeros.
fn plain(number: f64) -> String {
    if number == 0.0 || (1e-3..1e6).contains(&number.abs()) {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}

/// At most forty characters of a field, without control characters of terminals.
pub fn shown(field: &str) -> String {
    let mut text: String =
        field.chars().take(40).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if field.chars().nth(40).is_some() {
        text.push('…');
    }
    text
}
