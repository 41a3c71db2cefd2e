//! Files and terminal: reading designs, writing results, progress, Ctrl-C.

mod cache;
mod output;
mod pace;
mod parts;
mod terminal;
mod text;

use std::io::Read;
use std::path::Path;

use arcmin::design::Design;

use crate::failure::Failure;
pub use cache::Cache;
pub use output::{Results, write_file};
pub use parts::{Parts, SampleBar};
pub use terminal::{Terminal, is_checkpointed, is_stopped};
pub use text::{say, say_bytes, say_findings, terminal_text, visible};

/// No design is longer than this, in bytes.
const LARGEST_DESIGN: u64 = 1 << 24;
/// A table longer than this, in bytes, is a mistake, or a device that never ends.
pub const LARGEST_TABLE: u64 = 1 << 30;

/// A file as a whole, unless it is longer than `most` bytes. Pipes have no length that could be asked for.
pub fn read_bounded(path: &Path, most: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(std::io::Error::other(format!("it is longer than {} MB", most >> 20)));
    }
    Ok(bytes)
}

/// Reads and parses a design file.
pub fn read_design(path: &Path) -> Result<Design, Failure> {
    let bytes =
        read_bounded(path, LARGEST_DESIGN).map_err(|cause| Failure::Read { path: path.to_owned(), cause })?;
    let text = String::from_utf8(bytes).map_err(|error| Failure::Read {
        path: path.to_owned(),
        cause: std::io::Error::new(std::io::ErrorKind::InvalidData, error),
    })?;
    Design::parse(&text, &path.display().to_string()).map_err(|error| Failure::design(error, &text))
}
