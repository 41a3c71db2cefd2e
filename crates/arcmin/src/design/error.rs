use std::ops::Range;

/// Why a design file cannot be used, with the place in the file.
///
/// A design error means that the question cannot be asked; an engineering verdict on a design that can be
/// computed is a finding of [`crate::checks`] instead.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{file_name}:{line}:{column}: {kind}")]
pub struct DesignError {
    pub kind: DesignErrorKind,
    /// Name of the design file as the caller gave it.
    pub file_name: String,
    /// Bytes of the offending text.
    pub span: Range<usize>,
    /// Line, counted from 1.
    pub line: usize,
    /// Column in characters, counted from 1.
    pub column: usize,
    /// The offending text itself.
    pub text: String,
    /// What to write instead.
    pub hint: Option<String>,
}

/// The kinds of [`DesignError`].
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DesignErrorKind {
    #[error("this is not valid TOML: {message}")]
    Syntax { message: String },
    #[error("unknown key `{key}` in {section}")]
    UnknownKey { key: String, section: String },
    #[error("`{key}` lacks its unit")]
    MissingUnit { key: String },
    #[error("`{key}` has a unit this file does not use")]
    WrongUnit { key: String },
    #[error("{section} lacks the key `{key}`")]
    MissingKey { key: &'static str, section: String },
    #[error("{section} is missing")]
    MissingSection { section: String },
    #[error("`{key}` must be {expected}, but here is {found}")]
    WrongType { key: String, expected: String, found: &'static str },
    #[error("`{key}` is not a finite number")]
    NotFinite { key: String },
    #[error("`{key}` must be positive")]
    NotPositive { key: String },
    #[error("`{key}` must not be negative")]
    Negative { key: String },
    #[error("`{key}` is outside of what this program believes")]
    OutOfRange { key: String },
    #[error("`{key}` does not know the choice \"{choice}\"")]
    UnknownChoice { key: String, choice: String },
    #[error("no material is called \"{name}\"")]
    UnknownMaterial { name: String },
    #[error("{message}")]
    Contradiction { message: String },
}

/// The text of a design file and its name, to place errors in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source<'a> {
    pub text: &'a str,
    pub file_name: &'a str,
}

impl Source<'_> {
    pub fn error(&self, kind: DesignErrorKind, span: Range<usize>, hint: Option<String>) -> Box<DesignError> {
        let start = floor_char_boundary(self.text, span.start);
        let end = floor_char_boundary(self.text, span.end).max(start);
        let before = &self.text[..start];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        Box::new(DesignError {
            kind,
            file_name: self.file_name.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            text: self.text[start..end].to_owned(),
            span: start..end,
            hint,
        })
    }
}

fn floor_char_boundary(text: &str, index: usize) -> usize {
    let mut index = index.min(text.len());
    while !text.is_char_boundary(index) {
        index -= 1;
    }
    index
}
