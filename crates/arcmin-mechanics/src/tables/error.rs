use super::unit::{self, Dimension};

/// Why a table cannot be read: the line, the reason, and what to do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{file}{place}: {kind}", place = place(*.line))]
pub struct TableError {
    /// Name of the file, for the message only.
    pub file: String,
    /// Line counted from 1; `None` if it is about the file.
    pub line: Option<usize>,
    /// Fault with the names and numbers of its message.
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
    /// The file holds no line with text.
    #[error("there is no text in the file")]
    Empty,
    /// The bytes are no text in a known encoding.
    #[error("the file is neither UTF-8 nor Latin-1 nor UTF-16 text")]
    NotText,
    /// Code of a control character, which no text table holds.
    #[error("there is a control character (code {0})")]
    ControlCharacter(u32),
    /// A quotation mark has no partner on its line.
    #[error("a quote is opened but not closed on its line")]
    OpenQuote,
    /// The table exceeds a limit of [`Form::with_limits`](super::Form::with_limits).
    #[error("{what} is more than is read ({limit})")]
    TooLarge {
        /// Thing that there is too much of, as words of the message.
        what: String,
        /// Largest number accepted: bytes, rows or columns.
        limit: usize,
    },
    /// Numbers stand where the header should be.
    #[error("the first line \"{found}\" holds numbers, where the names of the columns belong")]
    NoHeader {
        /// First line of the file.
        found: String,
        /// Names of the columns, as a header would have them.
        wanted: String,
    },
    /// The header can be split in more than one way.
    #[error("the header \"{found}\" holds more than one kind of separator ({kinds})")]
    MixedSeparators {
        /// Header, shortened.
        found: String,
        /// Separators found in it.
        kinds: String,
    },
    /// A row has more or fewer fields than the header has names.
    #[error("the header names {header} columns, but here are {found} fields")]
    FieldCount {
        /// Names in the header.
        header: usize,
        /// Fields in the row.
        found: usize,
        /// Separator at which the row was split.
        separator: char,
    },
    /// A header stands alone.
    #[error("there are no rows below the header")]
    NoRows,
    /// Number of a column without a name that holds values, counted from 1.
    #[error("column {0} has no name")]
    Unnamed(usize),
    /// Two columns of the file mean the same quantity.
    #[error("the columns \"{first}\" and \"{second}\" are the same")]
    Twice {
        /// Name of the one on the left.
        first: String,
        /// Name of the one on the right.
        second: String,
    },
    /// A name in the header is none of those known.
    #[error("nothing is known of a column \"{name}\"")]
    Unknown {
        /// Name in the file.
        name: String,
        /// Columns that are known.
        wanted: String,
    },
    /// A column that is needed is not in the file.
    #[error("there is no column {name}{}", above(*.rows))]
    Missing {
        /// Name of the column.
        name: String,
        /// Line of the first row, where more than the names stands above it.
        rows: Option<usize>,
        /// The columns that the file has, and which of them may be meant.
        found: String,
    },
    /// A name that the caller assigned to a column is not in the file.
    #[error("there is no column \"{name}\" to take as another")]
    NotInFile {
        /// Name that the caller gave.
        name: String,
        /// First names of the file.
        found: String,
    },
    /// A column was assigned to a name that the form does not have.
    #[error("no column is called \"{name}\" here")]
    NotAsked {
        /// Name that the caller gave.
        name: String,
        /// Columns that are known.
        wanted: String,
    },
    /// Name and row of units contradict each other.
    #[error("the column \"{name}\" is in another unit than {unit}, which the row of units says")]
    TwoUnits {
        /// Name of the column with its unit.
        name: String,
        /// Unit in the row of units.
        unit: String,
    },
    /// A column of a physical quantity has a name without unit.
    #[error("the column \"{name}\" does not say its unit")]
    NoUnit {
        /// Name in the file.
        name: String,
        /// Name of the column without its unit.
        quantity: &'static str,
        /// Dimension that decides which units are offered.
        dimension: UnitKind,
    },
    /// The unit of a column measures something else.
    #[error("the unit of the column \"{name}\" is not one of those for {quantity}")]
    WrongUnit {
        /// Name in the file.
        name: String,
        /// Name of the column without its unit.
        quantity: &'static str,
        /// Dimension that decides which units are offered.
        dimension: UnitKind,
    },
    /// A field is empty where a value is needed.
    #[error("the field of column {column} is empty")]
    Blank {
        /// Name of the column.
        column: String,
    },
    /// A field is no number.
    #[error("\"{field}\" in column {column} is not a finite number")]
    NotANumber {
        /// Name of the column.
        column: String,
        /// Text of the field, shortened.
        field: String,
    },
    /// A field of a column of times is neither number nor date.
    #[error("\"{field}\" in column {column} is neither a number nor a date with the time of day")]
    NotADate {
        /// Name of the column.
        column: String,
        /// Text of the field, shortened.
        field: String,
    },
    /// A field such as 078: most likely the decimals of the field before it.
    #[error("\"{field}\" in column {column} begins with a zero that no number begins with")]
    LeadingZero {
        /// Name of the column.
        column: String,
        /// Text of the field, shortened.
        field: String,
    },
    /// A number has separators between its thousands.
    #[error("\"{field}\" in column {column} groups thousands")]
    Grouped {
        /// Name of the column.
        column: String,
        /// Text of the field, shortened.
        field: String,
    },
    /// Decimal points and decimal commas in one file.
    #[error("numbers have a comma here but a point in line {point}")]
    MixedMarks {
        /// Line with a decimal point, counted from 1.
        point: usize,
    },
    /// A comma that may be a decimal comma or group thousands, with nothing else in the file to tell.
    #[error("the comma of \"{field}\" may be a decimal comma or group thousands")]
    AmbiguousComma {
        /// Text of the field, shortened.
        field: String,
    },
    /// A number is outside of the range of its column.
    #[error("{} in column {column} is out of the allowed range {} to {}", plain(*.value), plain(*.low), plain(*.high))]
    OutOfRange {
        /// Name of the column.
        column: String,
        /// Number, in the unit that the column was asked for in.
        value: f64,
        /// Least value accepted, in the same unit.
        low: f64,
        /// Largest value accepted, in the same unit.
        high: f64,
    },
    /// The values of a column are not in their order.
    #[error("{column} must {rule}, but {value} follows {before}")]
    Order {
        /// Name of the column.
        column: String,
        /// Order asked for: "rise" or "not fall".
        rule: &'static str,
        /// Value out of order.
        value: f64,
        /// Value of the row before.
        before: f64,
    },
    /// Errors that a command finds in columns that were read.
    #[error("{message}")]
    Content {
        /// Fault in one sentence.
        message: String,
        /// Advice in one sentence.
        remedy: String,
    },
}

/// The dimension of a column, opaque outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitKind(pub(super) Dimension);

impl TableError {
    /// Remedy in words.
    pub fn remedy(&self) -> String {
        use TableErrorKind::*;
        match &self.kind {
            Empty | NoRows => "give a header with the names of the columns and rows of values below it".into(),
            NotText => "save it as UTF-8 (in a spreadsheet: \"CSV UTF-8\")".into(),
            ControlCharacter(_) => "export the file again as plain text; such characters belong to other formats".into(),
            OpenQuote => "close it on the same line, or write a quote inside of a field twice".into(),
            TooLarge { .. } => "thin the data out, or split the file".into(),
            NoHeader { wanted, .. } => format!("put a line with the names in front: {wanted}"),
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
            Unknown { wanted, .. } => format!("rename or delete it; known columns: {wanted}"),
            Missing { found, .. } => format!("add or rename it; {found}"),
            NotInFile { found, .. } => format!("the file has {found}"),
            NotAsked { wanted, .. } => format!("known columns: {wanted}"),
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

/// A number without hundreds of zeros.
fn plain(number: f64) -> String {
    if number == 0.0 || (1e-3..1e6).contains(&number.abs()) {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}

/// At most forty characters of a field, none of which a terminal acts on.
pub fn shown(field: &str) -> String {
    let mut text: String =
        field.chars().take(40).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if field.chars().nth(40).is_some() {
        text.push('…');
    }
    text
}
