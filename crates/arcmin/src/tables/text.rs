//! From bytes to lines of text.

use super::error::TableErrorKind;

/// Text of a file: UTF-8 with or without byte-order mark, UTF-16 with one, else Latin-1; line ends as `\n`.
pub(crate) fn decode(bytes: &[u8]) -> Result<String, TableErrorKind> {
    let sixteen = |bytes: &[u8], read: fn([u8; 2]) -> u16| {
        if !bytes.len().is_multiple_of(2) {
            return Err(TableErrorKind::NotText);
        }
        let units = bytes.chunks_exact(2).map(|pair| read([pair[0], pair[1]]));
        char::decode_utf16(units).collect::<Result<String, _>>().map_err(|_| TableErrorKind::NotText)
    };
    let text = match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => {
            str::from_utf8(rest).map_err(|_| TableErrorKind::NotText)?.to_owned()
        }
        [0xff, 0xfe, rest @ ..] => sixteen(rest, u16::from_le_bytes)?,
        [0xfe, 0xff, rest @ ..] => sixteen(rest, u16::from_be_bytes)?,
        _ => match str::from_utf8(bytes) {
            Ok(text) => text.to_owned(),
            // Bytes from 0x80 to 0x9f are letters in some code pages and control characters in Latin-1.
            Err(_) if bytes.iter().all(|byte| !(0x80..0xa0).contains(byte)) => {
                bytes.iter().map(|byte| char::from(*byte)).collect()
            }
            Err(_) => return Err(TableErrorKind::NotText),
        },
    };
    Ok(if text.contains('\r') { text.replace("\r\n", "\n").replace('\r', "\n") } else { text })
}

/// The first control character but tab and line end, with its line.
pub(crate) fn control_character(text: &str) -> Option<(usize, u32)> {
    let at = text.char_indices().find(|(_, c)| c.is_control() && !matches!(c, '\t' | '\n'))?;
    Some((text[..at.0].bytes().filter(|byte| *byte == b'\n').count() + 1, at.1 as u32))
}

/// Blanks comments out, so that lines keep their numbers; a line with an open quote is an error.
pub(super) fn without_comments(text: &str) -> Result<String, (usize, TableErrorKind)> {
    let mut clean = String::with_capacity(text.len() + 1);
    for (index, line) in text.split('\n').enumerate() {
        if !line.trim_start().starts_with('#') && !line.trim().is_empty() {
            if line.bytes().filter(|byte| *byte == b'"').count() % 2 != 0 {
                return Err((index + 1, TableErrorKind::OpenQuote));
            }
            clean.push_str(line);
        }
        clean.push('\n');
    }
    Ok(clean)
}

/// The separator of a header: the one kind of comma, semicolon and tab that stands outside of quotes and
/// brackets. A header without any is one column.
pub(super) fn separator(header: &str) -> Result<u8, TableErrorKind> {
    let (mut quoted, mut depth) = (false, 0_usize);
    let mut found = Vec::new();
    for c in header.chars() {
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
                found: super::shown(header),
                kinds: names.collect::<Vec<_>>().join(", "),
            })
        }
    }
}
