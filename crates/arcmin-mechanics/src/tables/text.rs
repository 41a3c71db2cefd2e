//! Conversion of bytes to lines of text.

use super::error::TableErrorKind;

/// Text of a file: UTF-8 with or without byte-order mark, UTF-16, else Latin-1; line ends as `\n`.
pub fn decode(bytes: &[u8]) -> Result<String, TableErrorKind> {
    let text = match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => {
            str::from_utf8(rest).map_err(|_| TableErrorKind::NotText)?.to_owned()
        }
        [0xff, 0xfe, rest @ ..] => sixteen(rest, u16::from_le_bytes)?,
        [0xfe, 0xff, rest @ ..] => sixteen(rest, u16::from_be_bytes)?,
        // In UTF-16 one of the two bytes of the first letters is zero.
        [a, 0, b, 0, ..] if *a > 0 && *b > 0 => sixteen(bytes, u16::from_le_bytes)?,
        [0, a, 0, b, ..] if *a > 0 && *b > 0 => sixteen(bytes, u16::from_be_bytes)?,
        _ => match str::from_utf8(bytes) {
            Ok(text) => text.to_owned(),
            // Cut within the last letter.
            Err(error) if error.error_len().is_none() && error.valid_up_to() > 0 => {
                String::from_utf8_lossy(&bytes[..error.valid_up_to()]).into_owned()
            }
            // Bytes from 0x80 to 0x9f are letters in some code pages and control characters in Latin-1.
            Err(_) if bytes.iter().all(|byte| !(0x80..0xa0).contains(byte)) => {
                bytes.iter().map(|byte| char::from(*byte)).collect()
            }
            Err(_) => return Err(TableErrorKind::NotText),
        },
    };
    Ok(if text.contains('\r') { text.replace("\r\n", "\n").replace('\r', "\n") } else { text })
}

/// Text of a design or another file that is not a table: UTF-8 with its line ends, otherwise as for tables:
/// UTF-16 or Latin-1, line ends as `\n`.
///
/// # Errors
/// [`TableErrorKind::NotText`].
pub fn text_of(bytes: &[u8]) -> Result<String, TableErrorKind> {
    match str::from_utf8(bytes) {
        Ok(text) if !text.contains('\0') => Ok(text.strip_prefix('\u{feff}').unwrap_or(text).to_owned()),
        // A table may be incomplete, a design may not.
        _ if matches!(bytes, [0xff, 0xfe, ..] | [0xfe, 0xff, ..]) && !bytes.len().is_multiple_of(2) => {
            Err(TableErrorKind::NotText)
        }
        _ => decode(bytes),
    }
}

/// A single last byte is the rest of a letter at which the file was cut.
fn sixteen(bytes: &[u8], read: fn([u8; 2]) -> u16) -> Result<String, TableErrorKind> {
    let units = bytes.chunks_exact(2).map(|pair| read([pair[0], pair[1]]));
    char::decode_utf16(units).collect::<Result<String, _>>().map_err(|_| TableErrorKind::NotText)
}

/// The first control character except tab and line end, with its line.
pub fn control_character(text: &str) -> Option<(usize, u32)> {
    let at = text.char_indices().find(|(_, c)| c.is_control() && !matches!(c, '\t' | '\n'))?;
    Some((text[..at.0].bytes().filter(|byte| *byte == b'\n').count() + 1, at.1 as u32))
}

/// Lines of a file with comments and skipped lines replaced by empty ones, so that line numbers are kept.
pub(super) struct Clean {
    pub text: String,
    /// The last comment above the table, with its line: some programs write the names into it.
    pub comment: Option<(usize, String)>,
    /// Line of an unclosed quote at which the file was cut; it is replaced as well.
    pub cut: Option<usize>,
}

/// # Errors
/// A line with an unclosed quote.
pub(super) fn without_comments(text: &str, skip: usize) -> Result<Clean, (usize, TableErrorKind)> {
    let mut clean = String::with_capacity(text.len() + 1);
    let (mut comment, mut cut, mut begun) = (None, None, false);
    let mut lines = text.split('\n').enumerate().peekable();
    while let Some((index, line)) = lines.next() {
        let trimmed = line.trim();
        if index < skip || trimmed.is_empty() {
            // The line is dropped entirely.
        } else if let Some(words) = trimmed.strip_prefix('#') {
            if !begun {
                comment = Some((index + 1, words.trim_start_matches('#').trim().to_owned()));
            }
        } else if line.bytes().filter(|byte| *byte == b'"').count() % 2 == 0 {
            clean.push_str(line);
            begun = true;
        } else if begun && lines.peek().is_none() {
            cut = Some(index + 1);
        } else {
            return Err((index + 1, TableErrorKind::OpenQuote));
        }
        clean.push('\n');
    }
    Ok(Clean { text: clean, comment, cut })
}

/// Separator of the fields of a line: the only kind of comma, semicolon and tab outside quotes and brackets; a
/// line without one is a single field.
pub(super) fn separator(line: &str) -> Result<u8, TableErrorKind> {
    let (mut quoted, mut depth) = (false, 0_usize);
    let mut found = Vec::new();
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            '(' | '[' if !quoted => depth += 1,
            ')' | ']' if !quoted => depth = depth.saturating_sub(1),
            ',' | ';' | '\t' if !quoted && depth == 0 && !found.contains(&c) => found.push(c),
            _ => {}
        }
    }
    match found[..] {
        [] => Ok(b','),
        [one] => Ok(one as u8),
        _ => {
            let names = found.iter().map(|c| match c {
                ',' => "comma",
                ';' => "semicolon",
                _ => "tab",
            });
            Err(TableErrorKind::MixedSeparators {
                found: super::shown(line),
                kinds: names.collect::<Vec<_>>().join(", "),
            })
        }
    }
}
