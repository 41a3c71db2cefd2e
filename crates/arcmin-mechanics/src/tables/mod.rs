//! Reader for all tables of users: transmission errors, loops, flanks, loads, depths, duties.
//!
//! A table is text with a header. Columns are found by name, in any order, and the name contains the unit:
//! `depth_um`, `depth_mm`, `Depth [µm]` and `depth (mm)` are the same column, converted to the required unit.
//! Accepted are commas, semicolons (spreadsheets in most of Europe) and tabs as separators, decimal commas if
//! commas are not separators, byte-order marks, UTF-16, Latin-1, all kinds of line ends, comments (`#`), the
//! `sep=` line, quotes, empty lines and empty rows.
//!
//! Ambiguous tables are rejected:
//!
//! * more or fewer fields than names in the header: `1,0,078` is never (1, 0);
//! * a header that holds two kinds of separators, or none where the rows hold one;
//! * a file that uses points and commas within numbers, and `1,234` where the comma may group thousands;
//! * a field such as `078` in a file separated by commas: most likely the decimals of the number before;
//! * a column twice, a column whose unit is missing or measures something else, an unknown name.
//!
//! ```
//! # extern crate arcmin_mechanics as arcmin;
//! use arcmin::tables::{Column, Form};
//! let form = Form::new(&[Column::number("time_s").rising(), Column::number("torque_n_m")]);
//! let table = form.read(b"time_ms;torque_n_m\n0;1,5\n20;1,75\n", "log.csv")?;
//! assert_eq!(table.numbers("time_s")?, [0.0, 0.02]);
//! assert_eq!(table.numbers("torque_n_m")?, [1.5, 1.75]);
//! assert!(form.read(b"time_s,torque_n_m\n1,0,078\n", "log.csv").is_err());
//! # Ok::<(), arcmin::tables::TableError>(())
//! ```

mod column;
mod error;
mod head;
mod instrument;
mod naming;
mod number;
mod read;
mod sources;
mod stamp;
mod table;
#[cfg(test)]
mod tests;
pub mod text;
mod unit;

pub use column::Column;
pub use error::shown;
pub use error::{TableError, TableErrorKind, UnitKind};
pub use naming::Naming;
pub use read::{Form, Limits};
pub use table::Table;
pub use text::text_of;
