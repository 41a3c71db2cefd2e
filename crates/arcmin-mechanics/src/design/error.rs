use std::fmt;
use std::ops::Range;

/// Reason why a file cannot be used, with the place in the file.
///
/// A design error means that nothing can be computed; the engineering assessment of a design that can be
/// computed is a finding of [`crate::checks`].
#[derive(Debug, Clone, PartialEq)]
pub struct DesignError {
    /// Kind of the error, without its place.
    pub kind: DesignErrorKind,
    /// Name of the file as given by the caller.
    pub file_name: String,
    /// Place in the text; `None` for an error of a path or value that is in no text.
    pub place: Option<TextPlace>,
    /// The erroneous text.
    pub text: String,
    /// Remedy: the text to write instead.
    pub hint: Option<String>,
    /// Dotted path of the key, if there is one.
    pub path: Option<String>,
    /// Other errors in the same file, in its order: all unknown keys are reported at once.
    pub others: Vec<DesignError>,
}

/// A place in a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextPlace {
    /// Bytes of the erroneous text.
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
    /// Dotted path of the key concerned, such as `duty[0].share`.
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

    /// Bytes of the erroneous text.
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
    /// The text is not valid TOML.
    #[error("this is not valid TOML: {message}")]
    Syntax {
        /// Message of the TOML reader, on one line.
        message: String,
    },
    /// An unknown key of a section.
    #[error("unknown key `{key}` in {section}")]
    UnknownKey {
        /// Key as written.
        key: String,
        /// Section as named in the message.
        section: String,
    },
    /// A known key without its unit.
    #[error("`{key}` lacks its unit")]
    MissingUnit {
        /// Key as written.
        key: String,
    },
    /// A key with the ending of another unit.
    #[error("`{key}` has a unit this file does not use")]
    WrongUnit {
        /// Key as written.
        key: String,
    },
    /// A mandatory key is missing.
    #[error("{section} lacks the key `{key}`")]
    MissingKey {
        /// Key with its unit.
        key: &'static str,
        /// Section as named in the message.
        section: String,
    },
    /// A mandatory section is missing.
    #[error("{section} is missing")]
    MissingSection {
        /// Section as named in the message.
        section: String,
    },
    /// A value of another type than the key takes.
    #[error("`{key}` must be {expected}, but here is {found}")]
    WrongType {
        /// Key as written.
        key: String,
        /// Expected type as named in the message.
        expected: String,
        /// Type of the value as named in the message.
        found: &'static str,
    },
    /// A number that is infinite or not a number (NaN).
    #[error("`{key}` is not a finite number")]
    NotFinite {
        /// Key as written.
        key: String,
    },
    /// Zero or a negative number for a key that must be positive.
    #[error("`{key}` must be positive")]
    NotPositive {
        /// Key as written.
        key: String,
    },
    /// A negative number for a key that must not be negative.
    #[error("`{key}` must not be negative")]
    Negative {
        /// Key as written.
        key: String,
    },
    /// A number outside the range of the key.
    #[error("`{key}` is out of range")]
    OutOfRange {
        /// Key as written.
        key: String,
    },
    /// A word that is not among the choices of the key.
    #[error("`{key}` has no choice \"{choice}\"")]
    UnknownChoice {
        /// Key as written.
        key: String,
        /// Word in the file.
        choice: String,
    },
    /// An unknown name of a material.
    #[error("no material is called \"{name}\"")]
    UnknownMaterial {
        /// Name in the file.
        name: String,
    },
    /// Values that are valid one by one but contradict each other.
    #[error("{message}")]
    Contradiction {
        /// Contradiction in one sentence.
        message: String,
    },
}

/// The text of a file with its name and title, for the places of errors in it.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// Whole text of the file.
    pub text: &'a str,
    /// Name of the file as given by the caller, for messages only.
    pub file_name: &'a str,
    /// Title of the file in messages: "the design file".
    pub title: &'static str,
}

impl Source<'_> {
    /// An error at a range of bytes of the text, with line and column of its start.
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

    /// An error without a place in a text, about the key with this path.
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
