/// A CSV table with units in its header. Numbers are written with the fewest digits that read back to the
/// same value, so the bytes depend on the values alone.
pub struct Table {
    text: String,
    columns: usize,
}

/// One field of a row.
#[derive(Debug, Clone, Copy)]
pub enum Cell<'a> {
    Number(f64),
    Count(usize),
    Word(&'a str),
    Empty,
}

impl Table {
    pub fn new(columns: &[&str]) -> Table {
        Table { text: columns.join(",") + "\n", columns: columns.len() }
    }

    /// Appends a row of numbers, counts, words or `Option`s of them.
    pub fn row(&mut self, cells: &[Cell<'_>]) {
        debug_assert_eq!(cells.len(), self.columns, "row and header of a table");
        for (index, cell) in cells.iter().enumerate() {
            if index > 0 {
                self.text.push(',');
            }
            match cell {
                Cell::Number(number) => self.text.push_str(&shortest(*number)),
                Cell::Count(count) => self.text.push_str(&count.to_string()),
                Cell::Word(word) if word.contains([',', '"', '\n', '\r']) => {
                    self.text.push('"');
                    self.text.push_str(&word.replace('"', "\"\""));
                    self.text.push('"');
                }
                Cell::Word(word) => self.text.push_str(word),
                Cell::Empty => {}
            }
        }
        self.text.push('\n');
    }

    pub fn into_bytes(self) -> Vec<u8> {
        self.text.into_bytes()
    }
}

impl From<f64> for Cell<'_> {
    fn from(number: f64) -> Self {
        Cell::Number(number)
    }
}

impl From<usize> for Cell<'_> {
    fn from(count: usize) -> Self {
        Cell::Count(count)
    }
}

impl<'a> From<&'a str> for Cell<'a> {
    fn from(word: &'a str) -> Self {
        Cell::Word(word)
    }
}

impl<'a, T: Into<Cell<'a>>> From<Option<T>> for Cell<'a> {
    fn from(value: Option<T>) -> Self {
        value.map_or(Cell::Empty, Into::into)
    }
}

/// Shortest text that reads back to the same number; very small and very large ones with an exponent.
/// Infinite and undefined values (the radius of a straight flank) are empty fields.
fn shortest(number: f64) -> String {
    match number {
        x if !x.is_finite() => String::new(),
        0.0 => "0".to_owned(),
        x if (1e-5..1e15).contains(&x.abs()) => format!("{x}"),
        x => format!("{x:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_exactly() {
        for number in [1.0 / 3.0, 1e-18, -2.5e30, 64.0, 1e-5, 0.1 + 0.2, f64::MIN_POSITIVE] {
            assert_eq!(shortest(number).parse::<f64>().unwrap(), number);
        }
        assert_eq!(
            [shortest(64.0), shortest(-0.0), shortest(f64::INFINITY), shortest(1.4e-18)],
            ["64", "0", "", "1.4e-18"]
        );
    }

    #[test]
    fn words_with_commas_are_quoted() {
        let mut table = Table::new(&["a", "b", "c"]);
        table.row(&["x, \"y\"".into(), 3usize.into(), None::<f64>.into()]);
        assert_eq!(String::from_utf8(table.into_bytes()).unwrap(), "a,b,c\n\"x, \"\"y\"\"\",3,\n");
    }
}
