//! Measured points in the formats of measuring machines.

use super::ExchangeError;
use crate::geometry::Vec2;
use crate::tables::{Column, Form, TableError, TableErrorKind, shown, text};
use crate::units::MM;

/// Format of a file of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointFormat {
    /// A table with the columns `x_mm`, `y_mm` and, where known, normals (`nx`, `ny`).
    Table,
    /// A list that begins with XYZIJK and its unit.
    Xyzijk,
    /// VDA-FS 2.0 (DIN 66301): POINT, PSET, MDI.
    VdaFs,
}

/// Points in the plane of the disc.
#[derive(Debug, Clone, PartialEq)]
pub struct PointSet {
    /// Format that the file was recognised as.
    pub format: PointFormat,
    /// Coordinates, m.
    pub points: Vec<Vec2>,
    /// Unit normals, if the file contains any; the fit determines their direction.
    pub normals: Option<Vec<Vec2>>,
    /// Line of each point in the file.
    pub lines: Vec<usize>,
}

/// Largest number of points.
const MOST: usize = 2_000_000;
/// Largest coordinate accepted, in mm.
const REACH: f64 = 1e5;

/// Reads measured points in any of the formats; `file` is used in messages.
///
/// # Errors
/// The fault with line and remedy.
pub fn read_points(bytes: &[u8], file: &str) -> Result<PointSet, ExchangeError> {
    let of_file = |kind: TableErrorKind, line: Option<usize>| TableError { file: shown(file), line, kind };
    let text = text::decode(bytes).map_err(|kind| of_file(kind, None))?;
    if let Some((line, code)) = text::control_character(&text) {
        return Err(of_file(TableErrorKind::ControlCharacter(code), Some(line)).into());
    }
    let first = text.lines().map(str::trim).find(|line| !line.is_empty()).unwrap_or("");
    let reader = Reader { file };
    if first.to_ascii_uppercase().starts_with("XYZIJK") {
        reader.list(&text)
    } else if first.starts_with("$$") || is_vda_statement(first) {
        reader.vda(&text)
    } else {
        drop(text);
        reader.table(bytes)
    }
}

struct Reader<'a> {
    file: &'a str,
}

/// Coordinates with three or six numbers per point, and the line of each.
#[derive(Default)]
struct Collected {
    points: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    lines: Vec<usize>,
}

impl Reader<'_> {
    fn wrong(&self, line: usize, message: impl Into<String>, remedy: impl Into<String>) -> ExchangeError {
        ExchangeError::Points { file: shown(self.file), line, message: message.into(), remedy: remedy.into() }
    }

    fn table(&self, bytes: &[u8]) -> Result<PointSet, ExchangeError> {
        let form = Form::new(&[
            Column::number("x_mm").within(-REACH, REACH),
            Column::number("y_mm").within(-REACH, REACH),
            Column::number("outward_normal_x")
                .also(&["normal_x", "nx", "i"])
                .optional()
                .within(-1.001, 1.001),
            Column::number("outward_normal_y")
                .also(&["normal_y", "ny", "j"])
                .optional()
                .within(-1.001, 1.001),
        ])
        .with_others();
        let table = form.read(bytes, self.file)?;
        let column = |name: &str| -> Result<Option<Vec<f64>>, ExchangeError> {
            Ok(if table.has(name) { Some(table.numbers(name)?.to_vec()) } else { None })
        };
        let (x, y) = (table.numbers("x_mm")?, table.numbers("y_mm")?);
        let normals = match (column("outward_normal_x")?, column("outward_normal_y")?) {
            (Some(x), Some(y)) => Some(x.into_iter().zip(y).map(|(x, y)| [x, y, 0.0]).collect::<Vec<_>>()),
            (None, None) => None,
            _ => {
                let remedy = "give both components or none";
                return Err(self.wrong(
                    table.header_line(),
                    "one component of the normals is missing",
                    remedy,
                ));
            }
        };
        let collected = Collected {
            points: x.iter().zip(y).map(|(x, y)| [*x, *y, 0.0]).collect(),
            normals: normals.unwrap_or_default(),
            lines: (0..table.len()).map(|row| table.line(row)).collect(),
        };
        self.finish(PointFormat::Table, collected)
    }

    /// `XYZIJK METRIC`, then x, y, z, i, j, k in each line, separated by blanks, tabs or commas.
    fn list(&self, text: &str) -> Result<PointSet, ExchangeError> {
        let mut collected = Collected::default();
        let mut unit = None;
        for (index, line) in text.lines().enumerate() {
            let (number, line) = (index + 1, line.trim());
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let Some(unit) = unit else {
                let words: Vec<String> = line.split_whitespace().map(str::to_ascii_uppercase).collect();
                unit = Some(match words.get(1).map(String::as_str) {
                    Some("METRIC" | "MM") => 1.0,
                    Some("INCH" | "IN" | "ENGLISH") => 25.4,
                    _ => {
                        let message = "the first line does not contain the unit";
                        return Err(self.wrong(
                            number,
                            message,
                            "write XYZIJK METRIC (millimetres) or XYZIJK INCH",
                        ));
                    }
                });
                continue;
            };
            let commas = line.contains(',');
            if commas && line.contains(';') {
                let remedy = "write decimal points and one kind of separator";
                return Err(self.wrong(number, "commas and semicolons in one line", remedy));
            }
            let fields: Vec<&str> = line
                .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
                .filter(|field| !field.is_empty())
                .collect();
            if fields.len() != 6 {
                let message = format!("{} numbers where x, y, z, i, j, k belong", fields.len());
                return Err(self.wrong(number, message, "give six numbers a line, with decimal points"));
            }
            let mut values = [0.0; 6];
            for (value, field) in values.iter_mut().zip(&fields) {
                *value = self.number(field, number)?;
            }
            let [x, y, z, i, j, k] = values;
            collected.points.push([x * unit, y * unit, z * unit]);
            collected.normals.push([i, j, k]);
            collected.lines.push(number);
            self.bounded(collected.points.len(), number)?;
        }
        self.finish(PointFormat::Xyzijk, collected)
    }

    /// Statements `NAME = KEYWORD / numbers` over several lines of 80 columns, the last eight of which are a
    /// line number.
    fn vda(&self, text: &str) -> Result<PointSet, ExchangeError> {
        let mut collected = Collected::default();
        let mut open: Option<Statement> = None;
        let mut comments = 0_usize;
        let mut ended = false;
        for (index, line) in text.lines().enumerate() {
            let number = index + 1;
            if comments > 0 {
                comments -= 1;
                continue;
            }
            let Some(body) = columns_of_statement(line) else {
                return Err(self.wrong(
                    number,
                    "a letter outside of ASCII",
                    "VDA-FS permits ASCII only; export again",
                ));
            };
            let body = body.trim();
            if body.is_empty() || body.starts_with("$$") {
                continue;
            }
            let mut rest = body;
            if is_vda_statement(body) {
                if let Some(statement) = open.take() {
                    self.close(statement, &mut collected)?;
                }
                let after = body.split_once('=').map_or("", |pair| pair.1).trim();
                let (keyword, arguments) = after.split_once('/').unwrap_or((after, ""));
                let keyword = keyword.trim().to_ascii_uppercase();
                match keyword.as_str() {
                    "HEADER" => {
                        let lines = self.number(arguments.trim(), number)?;
                        if !(0.0..=10_000.0).contains(&lines) {
                            let remedy = "write the number of comment lines behind HEADER /";
                            return Err(self.wrong(number, "an impossible number of comment lines", remedy));
                        }
                        comments = lines as usize;
                        continue;
                    }
                    "END" => {
                        ended = true;
                        break;
                    }
                    _ => {}
                }
                let kind = match keyword.as_str() {
                    "POINT" => Kind::Point,
                    "PSET" => Kind::Pset,
                    "MDI" => Kind::Mdi,
                    // Curves, surfaces and groups are not measurements.
                    _ => Kind::Other,
                };
                open = Some(Statement { kind, line: number, values: Vec::new(), lines: Vec::new() });
                rest = arguments;
            }
            let Some(statement) = open.as_mut() else {
                return Err(self.wrong(number, "numbers before any statement", "begin with NAME = PSET / …"));
            };
            if statement.kind != Kind::Other {
                for field in rest.split([',', ' ', '\t']).map(str::trim).filter(|field| !field.is_empty()) {
                    statement.values.push(self.number(field, number)?);
                    statement.lines.push(number);
                }
                self.bounded(statement.values.len() / 6, number)?;
            }
        }
        if let Some(statement) = open {
            self.close(statement, &mut collected)?;
        }
        if !ended {
            let last = text.lines().count();
            return Err(self.wrong(
                last,
                "the file ends without an END statement",
                "it is cut off: export it again",
            ));
        }
        self.finish(PointFormat::VdaFs, collected)
    }

    fn close(&self, statement: Statement, collected: &mut Collected) -> Result<(), ExchangeError> {
        let Statement { kind, line, values, lines } = statement;
        let (name, each, values, lines) = match kind {
            Kind::Other => return Ok(()),
            Kind::Point => ("POINT", 3, &values[..], &lines[..]),
            Kind::Pset | Kind::Mdi => {
                let (name, each) = if kind == Kind::Pset { ("PSET", 3) } else { ("MDI", 6) };
                let Some((count, rest)) = values.split_first() else {
                    return Err(self.wrong(
                        line,
                        format!("{name} without numbers"),
                        "write the count, then the points",
                    ));
                };
                if rest.len() as f64 != count * each as f64 {
                    let message = format!("{name} announces {count} points but holds {} numbers", rest.len());
                    return Err(self.wrong(
                        line,
                        message,
                        "each point has its numbers; export the file again",
                    ));
                }
                (name, each, rest, &lines[1..])
            }
        };
        if each == 3 && name == "POINT" && values.len() != 3 {
            return Err(self.wrong(line, "POINT without exactly three numbers", "write x, y, z"));
        }
        for (point, lines) in values.chunks_exact(each).zip(lines.chunks_exact(each)) {
            collected.points.push([point[0], point[1], point[2]]);
            collected.lines.push(lines[0]);
            if each == 6 {
                collected.normals.push([point[3], point[4], point[5]]);
            }
        }
        self.bounded(collected.points.len(), line)
    }

    /// A number with a decimal point; exponents may be written with D.
    fn number(&self, field: &str, line: usize) -> Result<f64, ExchangeError> {
        let plain = field.bytes().all(|byte| byte.is_ascii_digit() || b"+-.eEdD".contains(&byte));
        let number = if plain { field.replace(['d', 'D'], "e").parse::<f64>().ok() } else { None };
        number.filter(|number| number.is_finite() && number.abs() <= 1e9).ok_or_else(|| {
            self.wrong(
                line,
                format!("\"{}\" is not a finite number", shown(field)),
                "write digits with a decimal point, such as 12.345 or 1.2e-3",
            )
        })
    }

    fn bounded(&self, count: usize, line: usize) -> Result<(), ExchangeError> {
        if count <= MOST {
            return Ok(());
        }
        Err(self.wrong(line, format!("more than {MOST} points"), "thin the points out"))
    }

    fn finish(&self, format: PointFormat, collected: Collected) -> Result<PointSet, ExchangeError> {
        let Collected { points, normals, lines } = collected;
        if points.is_empty() {
            return Err(self.wrong(
                1,
                "there are no points in the file",
                "export points (POINT, PSET, MDI, rows)",
            ));
        }
        self.bounded(points.len(), lines[lines.len() - 1])?;
        if let Some(at) = points.iter().position(|p| p.iter().any(|c| c.abs() > REACH)) {
            return Err(self.wrong(lines[at], "a coordinate beyond 100 m", "check the unit: millimetres"));
        }
        // Files that contain points both with and without normals are read without normals.
        let normals = if normals.len() == points.len() { Some(normals) } else { None };
        let mut flat = Vec::new();
        for (index, [i, j, k]) in normals.iter().flatten().enumerate() {
            let size = (i * i + j * j + k * k).sqrt();
            if !(size > 0.5 && size < 2.0) {
                let remedy = "normals are unit vectors; remove them if they are not known";
                return Err(self.wrong(lines[index], "the normal is not a unit vector", remedy));
            }
            if k.abs() > 0.5 * size {
                let remedy = "give points of the flank only, not of the end faces, with z along the axis";
                return Err(self.wrong(lines[index], "a normal along the axis of the disc", remedy));
            }
            flat.push(Vec2::new(*i, *j).normalize());
        }
        Ok(PointSet {
            format,
            points: points.iter().map(|p| Vec2::new(p[0], p[1]) * MM).collect(),
            normals: (!flat.is_empty()).then_some(flat),
            lines,
        })
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Point,
    Pset,
    Mdi,
    Other,
}

struct Statement {
    kind: Kind,
    line: usize,
    values: Vec<f64>,
    lines: Vec<usize>,
}

/// The first 72 columns of a line with a line number in the last eight; `None` for other lines.
fn columns_of_statement(line: &str) -> Option<&str> {
    let line = line.trim_end();
    if !line.is_ascii() {
        return None;
    }
    Some(if line.len() > 72 && line.len() <= 80 { &line[..72] } else { line })
}

/// `NAME = KEYWORD …`.
fn is_vda_statement(line: &str) -> bool {
    let Some((name, rest)) = line.split_once('=') else { return false };
    let name = name.trim();
    !name.is_empty()
        && name.len() <= 8
        && name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && rest.trim_start().starts_with(|c: char| c.is_ascii_alphabetic())
        // The `sep=;` line of spreadsheets is not a statement.
        && !name.eq_ignore_ascii_case("sep")
}
