//! Tables as comma-separated values.

use super::{Cells, Table};

pub(super) fn write(table: &Table) -> String {
    let header: Vec<&str> = table.columns.iter().map(|column| column.quantity.key).collect();
    let mut text = header.join(",") + "\n";
    for row in 0..table.rows() {
        for (index, column) in table.columns.iter().enumerate() {
            if index > 0 {
                text.push(',');
            }
            match &column.cells {
                Cells::Numbers(numbers) => text.push_str(&shortest(numbers[row])),
                Cells::Counts(counts) => text.push_str(&counts[row].to_string()),
                Cells::Words(words) => push_word(&mut text, &words[row]),
            }
        }
        text.push('\n');
    }
    text
}

fn push_word(text: &mut String, word: &str) {
    if word.contains([',', '"', '\n', '\r']) {
        text.push('"');
        text.push_str(&word.replace('"', "\"\""));
        text.push('"');
    } else {
        text.push_str(word);
    }
}

/// Shortest text that reads back to the same number; very small and very large ones with an exponent.
/// Infinite and undefined values (the radius of a straight flank) are empty fields.
pub(super) fn shortest(number: f64) -> String {
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
        let some = [shortest(64.0), shortest(-0.0), shortest(f64::INFINITY), shortest(1.4e-18)];
        assert_eq!(some, ["64", "0", "", "1.4e-18"]);
    }

    #[test]
    fn words_with_commas_are_quoted() {
        let mut text = String::new();
        push_word(&mut text, "x, \"y\"");
        assert_eq!(text, "\"x, \"\"y\"\"\"");
    }
}
