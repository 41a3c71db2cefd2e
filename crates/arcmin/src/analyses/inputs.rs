//! Files that analyses read, as values of the library.

use super::{AnalysisError, Host, Origin};
use crate::design::InputFile;
use crate::geometry::{FlankDataError, FlankError};
use crate::tables::{Column, Form, Table, TableError};
use crate::units::{DEG, UM};

impl From<TableError> for AnalysisError {
    fn from(error: TableError) -> AnalysisError {
        AnalysisError::Input {
            help: error.remedy(),
            message: error.kind.to_string(),
            line: error.line,
            file: error.file,
        }
    }
}

/// Reads a table that the options name.
pub(crate) fn table(file: &InputFile, form: &Form, host: &dyn Host) -> Result<Table, AnalysisError> {
    Ok(form.read(&host.read(file, Origin::Options)?, &file.0)?)
}

/// A flank measured around the disc.
pub(crate) fn measured_flank(
    file: &InputFile,
    bytes: &[u8],
    lobe_count: usize,
) -> Result<FlankError, AnalysisError> {
    let form =
        Form::new(&[Column::number("angle_deg").rising(), Column::number("depth_um").within(-500.0, 500.0)]);
    let table = form.read(bytes, &file.0)?;
    let (angles, depths) = (table.numbers("angle_deg")?, table.numbers("depth_um")?);
    let points: Vec<(f64, f64)> =
        angles.iter().zip(depths).map(|(angle, depth)| (angle * DEG, depth * UM)).collect();
    FlankError::from_measured(&points, lobe_count).map_err(|error| {
        let (row, what) = match error {
            FlankDataError::NotRising(row) => {
                (row, format!("the angles must rise, but {}° follows {}°", angles[row], angles[row - 1]))
            }
            FlankDataError::MoreThanATurn(row) => {
                (row, format!("{}° lies more than a turn after the first angle, {}°", angles[row], angles[0]))
            }
            FlankDataError::TooCoarse(row, gap, _) => (
                row,
                format!(
                    "a gap of {:.3}° follows; {lobe_count} lobes need a point every {:.3}° at least",
                    gap / DEG,
                    90.0 / lobe_count as f64
                ),
            ),
        };
        table.wrong(row, what, "give rows angle_deg,depth_um around the whole disc").into()
    })
}
