use super::unit::{self, Dimension};

/// Why a table cannot be read: the line, the reason, and what to do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{file}{place}: {kind}", place = place(*.line))]
pub struct TableError {
    /// Name of the file, for the message only.
    pub file: String,
    /// Line counted from 1; `None` if it is about the file.
    pub line: Option<usize>,
    pub kind: TableErrorKind,
}

fn above(rows: Option<usize>) -> String {
    rows.map_or(String::new(), |rows| format!(" above the rows, which begin in line {rows}"))
}

fn place(line: Option<usize>) -> String {
    line.map_or(String::new(), |line| format!(", line {line}"))
}

#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TableErrorKind {
    #[error("there is no text in the file")]
    Empty,
    #[error("the file is neither UTF-8 nor Latin-1 nor UTF-16 text")]
    NotText,
    #[error("there is a control character (code {0})")]
    ControlCharacter(u32),
    #[error("a quote is opened but not closed on its line")]
    OpenQuote,
    #[error("{what} is more than is read ({limit})")]
    TooLarge { what: String, limit: usize },
    #[error("the first line \"{found}\" holds numbers, where the names of the columns belong")]
    NoHeader { found: String, wanted: String },
    #[error("the header \"{found}\" holds more than one kind of separator ({kinds})")]
    MixedSeparators { found: String, kinds: String },
    #[error("the header names {header} columns, but here are {found} fields")]
    FieldCount { header: usize, found: usize, separator: char },
    #[error("there are no rows below the header")]
    NoRows,
    #[error("column {0} has no name")]
    Unnamed(usize),
    #[error("the columns \"{first}\" and \"{second}\" are the same")]
    Twice { first: String, second: String },
    #[error("nothing is known of a column \"{name}\"")]
    Unknown { name: String, wanted: String },
    #[error("there is no column {name}{}", above(*.rows))]
    Missing {
        name: String,
        /// Line of the first row, where more than the names stands above it.
        rows: Option<usize>,
        /// The columns that the file has, and which of them may be meant.
        found: String,
    },
    #[error("there is no column \"{name}\" to take as another")]
    NotInFile { name: String, found: String },
    #[error("no column is called \"{name}\" here")]
    NotAsked { name: String, wanted: String },
    #[error("the column \"{name}\" is in another unit than {unit}, which the row of units says")]
    TwoUnits { name: String, unit: String },
    #[error("the column \"{name}\" does not say its unit")]
    NoUnit { name: String, quantity: &'static str, dimension: UnitKind },
    #[error("the unit of the column \"{name}\" is not one of those for {quantity}")]
    WrongUnit { name: String, quantity: &'static str, dimension: UnitKind },
    #[error("the field of column {column} is empty")]
    Blank { column: String },
    #[error("\"{field}\" in column {column} is not a finite number")]
    NotANumber { column: String, field: String },
    #[error("\"{field}\" in column {column} is neither a number nor a date with the time of day")]
    NotADate { column: String, field: String },
    #[error("\"{field}\" in column {column} begins with a zero that no number begins with")]
    LeadingZero { column: String, field: String },
    #[error("\"{field}\" in column {column} groups thousands")]
    Grouped { column: String, field: String },
    #[error("numbers have a comma here but a point in line {point}")]
    MixedMarks { point: usize },
    #[error("the comma of \"{field}\" may be a decimal comma or group thousands")]
    AmbiguousComma { field: String },
    #[error("{} in column {column} is out of the allowed range {} to {}", plain(*.value), plain(*.low), plain(*.high))]
    OutOfRange { column: String, value: f64, low: f64, high: f64 },
    #[error("{column} must {rule}, but {value} follows {before}")]
    Order { column: String, rule: &'static str, value: f64, before: f64 },
    /// Errors that a command finds in columns that were read.
    #[error("{message}")]
    Content { message: String, remedy: String },
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
