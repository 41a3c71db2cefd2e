//! Search for the line with the names of the columns and for their units.

use std::borrow::Cow;

use super::column::Name;
use super::error::{TableErrorKind, shown};
use super::naming::Naming;
use super::read::Form;
use super::sources::{Source, first_names};
use super::text::Clean;
use super::{instrument, stamp, text, unit};

/// The names of a table and the text of its rows.
pub(super) struct Head<'a> {
    /// Line of the names, or of the first row if there are none.
    pub line: usize,
    pub separator: u8,
    pub names: Vec<String>,
    pub sources: Vec<Source>,
    /// Line of the first line of the body.
    pub body_line: usize,
    pub body: Cow<'a, str>,
    /// Messages on the lines that were skipped.
    pub notes: Vec<String>,
    /// Columns that are not read but may be intended.
    pub proposal: String,
}

type Problem = (usize, TableErrorKind);

/// A line that is not empty: its number and the start of its text.
#[derive(Clone, Copy)]
struct Line<'a> {
    number: usize,
    start: usize,
    text: &'a str,
}

impl<'a> Line<'a> {
    fn fields(&self, separator: u8) -> Vec<String> {
        if separator == b' ' {
            return self.text.split_whitespace().map(str::to_owned).collect();
        }
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(separator)
            .has_headers(false)
            .flexible(true)
            .from_reader(self.text.as_bytes());
        let mut record = csv::StringRecord::new();
        let _ = reader.read_record(&mut record);
        record.iter().map(|field| field.trim().to_owned()).collect()
    }

    /// Whether it begins with a number or a time and less than half of its fields are words.
    fn is_row(&self) -> bool {
        let separator = text::separator(self.text).unwrap_or(b';');
        let blanks = separator == b',' && !self.text.contains(',');
        let fields = self.fields(if blanks { b' ' } else { separator });
        let filled = fields.iter().filter(|field| !field.is_empty()).count();
        let numbers = fields.iter().filter(|field| is_number(field)).count();
        fields.first().is_some_and(|field| field.is_empty() || is_number(field))
            && numbers > 0
            && 2 * numbers >= filled
    }
}

fn is_number(field: &str) -> bool {
    field.replace(',', ".").parse::<f64>().is_ok_and(f64::is_finite) || stamp::seconds(field).is_some()
}

/// Number of lines searched for names.
const LONGEST_HEAD: usize = 1000;

/// Lines up to the first row, and the separator of a `sep=` line.
struct Above<'a> {
    lines: Vec<Line<'a>>,
    /// Index of the first row, or the number of lines if there is none.
    row: usize,
    separator_line: Option<u8>,
}

impl<'a> Above<'a> {
    fn of(clean: &'a str) -> Result<Above<'a>, Problem> {
        let mut separator_line = None;
        let mut lines: Vec<Line<'a>> = Vec::new();
        let mut start = 0;
        for (index, text) in clean.split('\n').enumerate() {
            let line = Line { number: index + 1, start, text };
            start += text.len() + 1;
            let trimmed = text.trim().trim_matches('"');
            if trimmed.is_empty() {
                continue;
            }
            if let Some(separator) =
                trimmed.strip_prefix("sep=").filter(|_| lines.is_empty() && separator_line.is_none())
            {
                separator_line = Some(match separator {
                    ";" => b';',
                    "," => b',',
                    // Trimming has removed a tab.
                    "" | "\t" => b'\t',
                    _ => {
                        let found = shown(trimmed);
                        let kind = TableErrorKind::MixedSeparators { found, kinds: shown(separator) };
                        return Err((line.number, kind));
                    }
                });
                continue;
            }
            lines.push(line);
            // Two consecutive rows: a single one may be part of the head.
            let count = lines.len();
            let row = count.checked_sub(2).filter(|before| lines[*before].is_row());
            if let Some(row) = row.filter(|_| line.is_row()) {
                return Ok(Above { lines, row, separator_line });
            }
            if count == LONGEST_HEAD {
                break;
            }
        }
        if lines.is_empty() {
            return Err((0, TableErrorKind::Empty));
        }
        let row = lines.iter().position(Line::is_row).unwrap_or(lines.len());
        // If the file has a single row, it is the last line.
        let row = if row + 1 == lines.len() { row } else { lines.len() };
        Ok(Above { lines, row, separator_line })
    }
}

impl Above<'_> {
    /// Separator and number of fields of the first row.
    fn of_row(&self) -> Option<(u8, usize)> {
        let row = self.lines.get(self.row)?;
        let separator = self.separator_line.or_else(|| text::separator(row.text).ok()).unwrap_or(b';');
        let separator = if separator == b',' && !row.text.contains(',') { b' ' } else { separator };
        Some((separator, row.fields(separator).len()))
    }

    /// In a head with several lines the number of names equals the number of fields of the rows.
    fn as_many_fields(&self, at: usize, names: &[String]) -> Result<(), Problem> {
        let Some((separator, found)) = self.of_row().filter(|_| self.row > at + 1) else { return Ok(()) };
        let header = names.len();
        if found == header || (instrument::may_lack_last(names) && found + 1 == header) {
            return Ok(());
        }
        let kind = TableErrorKind::FieldCount { header, found, separator: char::from(separator) };
        Err((self.lines[self.row].number, kind))
    }
}

impl Form {
    /// Finds the line of the names: the first one that contains all mandatory columns.
    pub(super) fn head<'a>(&self, clean: &'a Clean) -> Result<Head<'a>, Problem> {
        let above = Above::of(&clean.text)?;
        let first = self.head_at(&above, 0, clean);
        let problem = match first {
            Ok(head) => return Ok(head),
            Err(problem) => problem,
        };
        for at in 1..above.row {
            if let Ok(head) = self.head_at(&above, at, clean) {
                return Ok(head);
            }
        }
        if above.row == 0 {
            return self.head_without_names(&above, clean).unwrap_or(Err(problem));
        }
        Err(self.nearest(&above).unwrap_or(problem))
    }

    fn head_at<'a>(&self, above: &Above<'a>, at: usize, clean: &'a Clean) -> Result<Head<'a>, Problem> {
        let line = above.lines[at];
        let problem = |kind| (line.number, kind);
        let separator = match above.separator_line {
            Some(separator) => separator,
            // Numbers in place of names are reported as such, whatever lines are between.
            None if !line.text.chars().any(|c| c.is_alphabetic() && !matches!(c, 'e' | 'E')) => b',',
            None => match text::separator(line.text).map_err(problem)? {
                b',' if !line.text.contains(',') && separated_by_blanks(above, at) => b' ',
                separator => separator,
            },
        };
        let names = line.fields(separator);
        above.as_many_fields(at, &names)?;
        let Units { units, line: units_line, labelled } = Units::around(above, at, separator, names.len());
        let sources = self.sources(&names, &units, labelled, &shown(line.text)).map_err(problem)?;
        let proposal = self.proposal(&names, &units, &sources);
        let mut notes = Vec::new();
        if at > 0 {
            notes.push(format!("the names are in line {}; the lines above are skipped", line.number));
        }
        // Between the names and the rows only units and similar lines are skipped.
        let next = match units_line {
            Some(below) if below > at => {
                let end = if above.row > below { above.row } else { below + 1 };
                let (from, to) = (above.lines[at + 1].number, above.lines[end - 1].number);
                notes.push(match from == to {
                    true => format!("line {from} is taken as the units"),
                    false => format!("lines {from} to {to} between names and rows are skipped"),
                });
                above.lines.get(end).copied()
            }
            _ => None,
        };
        let (body_line, start) = match next {
            Some(next) => (next.number, next.start),
            None => (line.number + 1, (line.start + line.text.len() + 1).min(clean.text.len())),
        };
        let body = body(&clean.text[start..], separator);
        Ok(Head { line: line.number, separator, names, sources, body_line, body, notes, proposal })
    }

    /// Rows without a line of names: the names may be in a comment above, or are given by the user by number.
    fn head_without_names<'a>(
        &self,
        above: &Above<'a>,
        clean: &'a Clean,
    ) -> Option<Result<Head<'a>, Problem>> {
        let row = above.lines[0];
        let separator_line = above.separator_line.or_else(|| text::separator(row.text).ok());
        let separator = match separator_line? {
            b',' if !row.text.contains(',') && row.text.trim().contains(char::is_whitespace) => b' ',
            separator => separator,
        };
        let count = row.fields(separator).len();
        let body = body(&clean.text[row.start..], separator);
        let head = |line, names, sources, notes| {
            let proposal = String::new();
            Ok(Head { line, separator, names, sources, body_line: row.number, body, notes, proposal })
        };
        if let Some((line, comment)) = &clean.comment {
            let line_of_names = Line { number: *line, start: 0, text: comment };
            for names in [separator, b' ', b',', b';', b'\t'].map(|separator| line_of_names.fields(separator))
            {
                if names.len() == count
                    && let Ok(sources) = self.sources(&names, &vec![None; count], false, comment)
                {
                    let notes = vec![format!("the names are those of the comment in line {line}")];
                    return Some(head(*line, names, sources, notes));
                }
            }
        }
        let by_number = |pair: &(String, Option<String>)| pair.0.parse::<usize>().is_ok();
        if self.naming.pairs.is_empty() || !self.naming.pairs.iter().all(by_number) {
            return None;
        }
        let names: Vec<String> = (1..=count).map(|number| format!("column {number}")).collect();
        match self.sources(&names, &vec![None; count], false, &shown(row.text)) {
            Ok(sources) => Some(head(row.number, names, sources, Vec::new())),
            Err(kind) => Some(Err((row.number, kind))),
        }
    }

    /// The error for the line most similar to names: the one with most known names, or the first with as many
    /// fields as the rows.
    /// as many fields as the rows.
    fn nearest(&self, above: &Above<'_>) -> Option<Problem> {
        let row = above.lines.get(above.row)?;
        if above.row < 2 {
            return None;
        }
        let read = |at: usize| {
            let separator = above.separator_line.or_else(|| text::separator(above.lines[at].text).ok())?;
            let names = above.lines[at].fields(separator);
            let units = Units::around(above, at, separator, names.len());
            (Some(names.len()) == above.of_row().map(|row| row.1)).then_some((at, names, units))
        };
        let candidates: Vec<_> = (0..above.row).filter_map(read).collect();
        // A line with all names given by the user has priority.
        let known = |names: &[String]| {
            let given = !self.naming.pairs.is_empty() && self.naming.renamed(names).is_ok();
            (given, names.iter().filter(|name| self.has_column(name)).count())
        };
        let most = candidates.iter().map(|candidate| known(&candidate.1)).max()?;
        let (at, names, units) = candidates.into_iter().find(|candidate| known(&candidate.1) == most)?;
        let kind = match self.sources(&names, &units.units, units.labelled, &shown(above.lines[at].text)) {
            Err(TableErrorKind::Missing { name, found, .. }) => {
                TableErrorKind::Missing { name, rows: Some(row.number), found }
            }
            Err(kind) => kind,
            Ok(_) => return None,
        };
        Some((above.lines[at].number, kind))
    }
}

/// Whether blanks separate the names as they separate the fields of the row below.
fn separated_by_blanks(above: &Above<'_>, at: usize) -> bool {
    let names = above.lines[at].fields(b' ');
    let below = above.lines.get(at + 1).map(|line| line.fields(b' '));
    names.len() > 1
        && below.is_some_and(|below| below.len() == names.len() && below.iter().any(|f| is_number(f)))
}

/// The body with single tabs where blanks separated the fields.
fn body(text: &str, separator: u8) -> Cow<'_, str> {
    if separator != b' ' {
        return Cow::Borrowed(text);
    }
    let mut tabbed = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        for (index, field) in line.split_whitespace().enumerate() {
            tabbed.push_str(if index == 0 { "" } else { "\t" });
            tabbed.push_str(field);
        }
        tabbed.push_str(if line.ends_with('\n') { "\n" } else { "" });
    }
    Cow::Owned(tabbed)
}

/// Units of the columns from a line of units.
struct Units {
    units: Vec<Option<String>>,
    /// Index of that line.
    line: Option<usize>,
    /// Whether the first field of that line is a label for units.
    labelled: bool,
}

impl Units {
    /// The line is below the names, or anywhere above the rows if its first field is a label for units.
    fn around(above: &Above<'_>, at: usize, separator: u8, count: usize) -> Units {
        let read = |line: usize| {
            let fields = above.lines[line].fields(separator);
            let mut units: Vec<Option<String>> =
                fields.iter().map(|field| unit::of_field(field).map(str::to_owned)).collect();
            let labelled = fields.first().is_some_and(|first| {
                let first = first.to_lowercase();
                first.contains("unit") || first.contains("einheit")
            });
            // A label is not a unit of a column.
            if labelled && let Some(first) = units.first_mut() {
                *first = None;
            }
            let holds = units.iter().any(Option::is_some)
                && fields.len() <= count
                && fields.iter().all(|field| !is_number(field));
            units.resize(count, None);
            (holds && (labelled || line > at)).then_some(Units { units, line: Some(line), labelled })
        };
        let none = || Units { units: vec![None; count], line: None, labelled: false };
        (at + 1..above.row).find_map(read).or_else(|| (0..at).rev().find_map(read)).unwrap_or_else(none)
    }
}

impl Naming {
    /// The names given by the user, with the unit of the file where they have none.
    pub(super) fn renamed(&self, names: &[String]) -> Result<Vec<Option<String>>, TableErrorKind> {
        let mut renamed: Vec<Option<String>> = names.iter().cloned().map(Some).collect();
        for (theirs, ours) in &self.pairs {
            let exact = names.iter().position(|name| name == theirs);
            let like = || names.iter().position(|name| Name::new(name).is_like(&Name::new(theirs)));
            let number = || {
                theirs
                    .parse::<usize>()
                    .ok()
                    .and_then(|number| number.checked_sub(1))
                    .filter(|at| *at < names.len())
            };
            let Some(at) = exact.or_else(like).or_else(number) else {
                return Err(TableErrorKind::NotInFile { name: shown(theirs), found: first_names(names) });
            };
            renamed[at] = ours.clone();
        }
        Ok(renamed)
    }
}
