//! Text in the page: escaping, numbers, inline marks.

use std::fmt::Write;

use super::literature::has_entry;

/// Whether a character is invisible and changes the display of its surroundings: control characters, and marks of the
/// writing direction, with which a name could change the appearance of a line.
pub fn is_hidden(character: char) -> bool {
    character.is_control()
        || matches!(character, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A text of one line with hidden characters replaced by the replacement character.
pub fn printable(text: &str) -> String {
    text.chars().map(|c| if is_hidden(c) { '\u{fffd}' } else { c }).collect()
}

/// Appends `text` with the five characters escaped that mean something in HTML text or attributes; hidden characters,
/// which names in a file may contain, become the replacement character.
pub(super) fn push_escaped(out: &mut String, text: &str) {
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            other if is_hidden(other) && !matches!(other, '\n' | '\t') => out.push('\u{fffd}'),
            other => out.push(other),
        }
    }
}

/// With a capital letter.
pub fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 16);
    push_escaped(&mut out, text);
    out
}

/// Escaped text with `[Key]` linked to a known reference and text between backticks set as code.
pub(super) fn push_inline(out: &mut String, text: &str, reference_keys: &[&str]) {
    let mut rest = text;
    while let Some(at) = rest.find(['[', '`']) {
        let (before, marked) = rest.split_at(at);
        push_escaped(out, before);
        let closing = if marked.starts_with('[') { ']' } else { '`' };
        let inner = marked[1..].find(closing).map(|end| &marked[1..end + 1]);
        match inner {
            Some(key) if closing == ']' && reference_keys.contains(&key) => {
                let _ = write!(out, "<a class=\"cite\" href=\"#ref-{0}\">{0}</a>", escaped(key));
                rest = &marked[key.len() + 2..];
            }
            Some(code) if closing == '`' && !code.is_empty() => {
                let _ = write!(out, "<code>{}</code>", escaped(code));
                rest = &marked[code.len() + 2..];
            }
            _ => {
                debug_assert!(
                    closing != ']' || !inner.is_some_and(has_entry),
                    "the report cites {inner:?} without its entry in the literature"
                );
                push_escaped(out, &marked[..1]);
                rest = &marked[1..];
            }
        }
    }
    push_escaped(out, rest);
}

/// `value` with `digits` significant digits, as an engineer writes it: 0.654, 446.9, 1.316e9.
///
/// Values that are not finite give an en dash, the mark for "no value" in tables.
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let digits = digits.max(1);
    // Uses the exponent form to detect rounding up to the next decade (9.996 → 10.0).
    let exponent_form = format!("{value:.*e}", digits - 1);
    let exponent: i32 =
        exponent_form.rsplit_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0);
    if (-4..6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        exponent_form
    }
}

/// `value` with `digits` digits behind the decimal point, and no minus before a rounded zero.
pub fn in_decimals(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(size) if size.trim_start_matches(['0', '.']).is_empty() => size.to_owned(),
        _ => text,
    }
}

/// As [`significant`] without trailing zeros: a given value such as 412 N·m or 10 µm, not a measured one.
pub fn compact(value: f64, digits: usize) -> String {
    let text = significant(value, digits);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Anchor or file name from a title.
pub(super) fn slug(title: &str) -> String {
    let mut out = String::new();
    for character in title.chars() {
        if character.is_ascii_alphanumeric() {
            out.push(character.to_ascii_lowercase());
        } else if !out.ends_with('-') && !out.is_empty() {
            out.push('-');
        }
    }
    out.truncate(60);
    out.trim_end_matches('-').to_string()
}
