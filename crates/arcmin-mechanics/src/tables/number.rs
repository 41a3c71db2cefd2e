//! Numbers as written by people: with decimal point or decimal comma, decided for the whole file.

/// Decimal marks found so far.
#[derive(Debug, Default)]
pub(super) struct Marks {
    /// Line of the first number with a decimal point.
    pub point: Option<usize>,
    /// Line and text of the first number with a comma.
    pub comma: Option<(usize, String)>,
    /// Whether at least one comma cannot be a separator of thousands.
    pub decimal_for_sure: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Malformed {
    NotANumber,
    LeadingZero,
    Grouped,
}

impl Marks {
    /// Reads a trimmed field. `separated_by_comma` makes leading zeros suspect: `1,078` is split into 1 and
    /// 078.
    pub(super) fn read(
        &mut self,
        field: &str,
        line: usize,
        separated_by_comma: bool,
    ) -> Result<f64, Malformed> {
        let bytes = field.as_bytes();
        let (mut commas, mut points) = (0, 0);
        for byte in bytes {
            match byte {
                b',' => commas += 1,
                b'.' => points += 1,
                b'0'..=b'9' | b'+' | b'-' | b'e' | b'E' => {}
                _ => return self.odd(field, line, separated_by_comma),
            }
        }
        if commas + points > 1 {
            return Err(if looks_grouped(field) { Malformed::Grouped } else { Malformed::NotANumber });
        }
        let digits = field.trim_start_matches(['+', '-']).as_bytes();
        let zero_in_front = digits.len() > 1 && digits[0] == b'0' && digits[1].is_ascii_digit();
        let number: f64 = if commas == 1 {
            field.replace(',', ".").parse().map_err(|_| Malformed::NotANumber)?
        } else {
            field.parse().map_err(|_| Malformed::NotANumber)?
        };
        if !number.is_finite() {
            return Err(Malformed::NotANumber);
        }
        if zero_in_front && separated_by_comma {
            return Err(Malformed::LeadingZero);
        }
        if points == 1 {
            self.point.get_or_insert(line);
        }
        if commas == 1 {
            self.decimal_for_sure |= !one_group(digits);
            if self.comma.is_none() {
                self.comma = Some((line, field.to_owned()));
            }
        }
        Ok(number)
    }

    /// The typographic minus is accepted; other non-digits are not.
    fn odd(&mut self, field: &str, line: usize, separated_by_comma: bool) -> Result<f64, Malformed> {
        match field.strip_prefix('\u{2212}') {
            Some(rest) if rest.starts_with(|c: char| c.is_ascii_digit()) => {
                self.read(&format!("-{rest}"), line, separated_by_comma)
            }
            _ if looks_grouped(field) => Err(Malformed::Grouped),
            _ => Err(Malformed::NotANumber),
        }
    }
}

/// One to three digits, a comma, exactly three digits: `1,234`, but not `0,234`.
fn one_group(digits: &[u8]) -> bool {
    let Some(comma) = digits.iter().position(|byte| *byte == b',') else { return false };
    (1..=3).contains(&comma)
        && digits[0] != b'0'
        && digits.len() == comma + 4
        && digits[comma + 1..].iter().all(u8::is_ascii_digit)
}

/// Digits with separators such as `1.234,5`, `1 234` or `1'234`.
fn looks_grouped(field: &str) -> bool {
    let body = field.trim_start_matches(['+', '-']);
    body.starts_with(|c: char| c.is_ascii_digit())
        && body
            .chars()
            .all(|c| c.is_ascii_digit() || matches!(c, ',' | '.' | ' ' | '\'' | '’' | '\u{a0}' | '\u{202f}'))
        && body.contains([',', '.', ' ', '\'', '’', '\u{a0}', '\u{202f}'])
}
