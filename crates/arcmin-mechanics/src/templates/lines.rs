//! The lines of a shipped design.

/// A number of a shipped design by its path.
pub(super) fn number(text: &str, path: &str) -> Option<f64> {
    let (section, key) = path.rsplit_once('.')?;
    lines(text).find(|line| line.section == section && line.key == Some(key))?.value.parse().ok()
}

/// A line of a design file.
pub(super) struct Line<'a> {
    pub raw: &'a str,
    /// Name without brackets; empty before the first section.
    pub section: &'a str,
    pub key: Option<&'a str>,
    pub value: &'a str,
    pub comment: &'a str,
}

/// The lines of a shipped design: one key per line, followed by a comment.
pub(super) fn lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    let mut section = "";
    text.lines().map(move |raw| {
        let code = raw.trim();
        if code.starts_with('[') {
            section = code.split('#').next().unwrap_or("").trim().trim_matches(['[', ']']);
            return Line { raw, section, key: None, value: "", comment: "" };
        }
        let comment_at = comment_of(code);
        let (body, comment) = match comment_at {
            Some(at) => (code[..at].trim(), code[at + 1..].trim()),
            None => (code, ""),
        };
        match body.split_once(" = ") {
            Some((key, value)) => Line { raw, section, key: Some(key.trim()), value: value.trim(), comment },
            None => Line { raw, section, key: None, value: "", comment },
        }
    })
}

/// Start of a comment: the first # outside quotation marks.
fn comment_of(code: &str) -> Option<usize> {
    let mut quoted = false;
    code.char_indices()
        .find(|(_, c)| {
            quoted ^= *c == '"';
            *c == '#' && !quoted
        })
        .map(|(at, _)| at)
}
