use std::fmt;
use std::ops::Range;

/// Why a file cannot be used, with the place in the file.
///
/// A design error means that the question cannot be asked; an engineering verdict on a design that can be
/// computed is a finding of [`crate::checks`] instead.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignError {
    pub kind: DesignErrorKind,
    /// Name of the file as the caller gave it.
    pub file_name: String,
    /// Where in the text it is; `None` for an error of a path or value that no text holds.
    pub place: Option<TextPlace>,
    /// The offending text itself.
    pub text: String,
    /// Remedy: the text to write instead.
    pub hint: Option<String>,
    /// Dotted path of the key, where there is one.
    pub path: Option<String>,
    /// Other errors in the same file, in its order: all unknown keys are reported at once.
    pub others: Vec<DesignError>,
}

/// A place in a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextPlace {
    /// Bytes of the offending text.
    pub span: Range<usize>,
    /// Line, counted from 1.
    pub line: usize,
    /// Column in characters, counted from 1.
    pub column: usize,
}

impl fmt::Display for DesignError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            Some(place) => write!(f, "{}:{}:{}: {}", self.file_name, place.line, place.column, self.kind),
            None => write!(f, "{}: {}", self.file_name, self.kind),
        }
    }
}

impl std::error::Error for DesignError {}

impl DesignError {
    /// Dotted path of the key it is about, such as `duty[0].share`.
    pub fn key(&self) -> Option<&str> {
        self.path.as_deref()
    }

    /// Line in the file, counted from 1.
    pub fn line(&self) -> Option<usize> {
        self.place.as_ref().map(|place| place.line)
    }

    /// Column in characters, counted from 1.
    pub fn column(&self) -> Option<usize> {
        self.place.as_ref().map(|place| place.column)
    }

    /// Bytes of the offending text.
    pub fn span(&self) -> Option<Range<usize>> {
        self.place.as_ref().map(|place| place.span.clone())
    }

    /// Remedy: the text to write instead.
    pub fn hint(&self) -> Option<&str> {
        self.hint.as_deref()
    }

    /// This error and all others of the same file.
    pub fn all(&self) -> impl Iterator<Item = &DesignError> {
        std::iter::once(self).chain(&self.others)
    }
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
    #[error("`{key}` is out of range")]
    OutOfRange { key: String },
    #[error("`{key}` has no choice \"{choice}\"")]
    UnknownChoice { key: String, choice: String },
    #[error("no material is called \"{name}\"")]
    UnknownMaterial { name: String },
    #[error("{message}")]
    Contradiction { message: String },
}

/// The text of a file, its name and what it is, to place errors in it.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    pub text: &'a str,
    pub file_name: &'a str,
    /// Name of the file in messages: "the design file".
    pub title: &'static str,
}

impl Source<'_> {
    pub fn error(&self, kind: DesignErrorKind, span: Range<usize>, hint: Option<String>) -> Box<DesignError> {
        let start = floor_char_boundary(self.text, span.start);
        let end = floor_char_boundary(self.text, span.end).max(start);
        let before = &self.text[..start];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let place = TextPlace {
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            span: start..end,
        };
        Box::new(DesignError {
            kind,
            file_name: self.file_name.to_owned(),
            place: Some(place),
            text: self.text[start..end].to_owned(),
            hint,
            path: None,
            others: Vec::new(),
        })
    }

    /// An error of what stands in no text, about the key with this path.
    pub fn error_at_path(&self, kind: DesignErrorKind, path: &str, hint: String) -> Box<DesignError> {
        Box::new(DesignError {
            kind,
            file_name: self.file_name.to_owned(),
            place: None,
            text: path.to_owned(),
            hint: Some(hint),
            path: Some(path.to_owned()),
            others: Vec::new(),
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
