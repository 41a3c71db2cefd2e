//! Files and terminal: reading designs, writing results, progress, Ctrl-C.

mod cache;
mod output;
mod pace;
mod parts;
mod terminal;
mod text;

use std::io::Read;
use std::path::Path;

use arcmin::analyses::stage::AnyDesign;

use crate::failure::{Failure, Start};
pub use cache::Cache;
pub use output::{Results, write_file};
pub use parts::{Parts, SampleBar};
pub use terminal::{Terminal, is_checkpointed, is_stopped};
pub use text::{print_bytes, print_findings, print_line, terminal_text, visible};

/// Largest size of a design file in bytes.
const LARGEST_DESIGN: u64 = 1 << 24;
/// Largest size of a table in bytes; anything longer is an error, or a device without end.
pub const LARGEST_TABLE: u64 = 1 << 30;

/// A whole file, unless it is longer than `most` bytes. Pipes have no known length.
pub fn read_bounded(path: &Path, most: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(std::io::Error::other(format!("it is longer than {} MB", most >> 20)));
    }
    Ok(bytes)
}

/// Text of a file in UTF-8, UTF-16 or Latin-1.
pub fn text_of(path: &Path, bytes: &[u8]) -> Result<String, Failure> {
    arcmin::tables::text_of(bytes).map_err(|kind| Failure::Usage {
        message: format!("cannot read {}: {kind}", path.display()),
        help: "save it as UTF-8".to_owned(),
    })
}

/// Reads and parses a design file of any family.
pub fn read_any_design(path: &Path) -> Result<AnyDesign, Failure> {
    let (text, name) = design_text(path)?;
    AnyDesign::parse(&text, &name).map_err(|error| Failure::design(error, &text))
}

/// Text of a design file, and its name in messages.
pub fn design_text(path: &Path) -> Result<(String, String), Failure> {
    let bytes = read_bounded(path, LARGEST_DESIGN).map_err(|cause| Failure::Read {
        path: path.to_owned(),
        cause,
        start: Start::Design,
    })?;
    Ok((text_of(path, &bytes)?, path.display().to_string()))
}
