//! Files and terminal: reading designs, writing results, progress, Ctrl-C.

mod output;
mod pace;
mod parts;
mod terminal;
mod text;

use std::path::Path;

use arcmin::design::Design;

use crate::failure::Failure;
pub use output::{Results, write_file};
pub use parts::{Parts, SampleBar};
pub use terminal::{Terminal, is_stopped};
pub use text::{say, say_bytes, say_findings, terminal_text, visible};

/// Reads and parses a design file.
pub fn read_design(path: &Path) -> Result<Design, Failure> {
    let bytes = std::fs::read(path).map_err(|cause| Failure::Read { path: path.to_owned(), cause })?;
    let text = String::from_utf8(bytes).map_err(|error| Failure::Read {
        path: path.to_owned(),
        cause: std::io::Error::new(std::io::ErrorKind::InvalidData, error),
    })?;
    Design::parse(&text, &path.display().to_string()).map_err(|error| Failure::design(error, &text))
}
