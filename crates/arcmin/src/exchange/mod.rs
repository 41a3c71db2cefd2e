//! Exchange with other programs: export of profiles and solids for CAD and CAM and of joints for simulations,
//! import of measured flanks and logs of joints. Input and output are texts, not files.
//!
//! * [`ProfileExport`]: DXF, STEP, STL, 3MF, CSV and SVG of disc, pins, crankshafts and their assembly;
//! * [`DimensionedDesign`]: a drawing in SVG whose dimension lines contain the keys of the design;
//! * [`JointExport`]: MuJoCo, URDF, SDF, Modelica, Simscape, JSON of the reducer as a joint;
//! * [`import_flank`]: pose and deviations of a measured flank from its points, and keys of the design;
//! * [`import_duty`]: a joint's log to a load spectrum.
//!
//! Every export contains program version, design hash and deviation; the same design gives the same bytes in
//! every run.

mod crankshaft;
mod dimensions;
mod disc_solid;
mod drawing;
mod duty;
#[cfg(test)]
mod duty_field_tests;
#[cfg(test)]
mod duty_tests;
mod dxf;
mod fit;
mod flank;
#[cfg(test)]
mod flank_tests;
pub mod fmu;
mod joint;
mod mesh;
#[cfg(test)]
mod mesh_tests;
mod meshed;
mod outline;
mod pages;
mod points;
mod profile;
mod solid;
mod spline;
mod split;
mod step;
#[cfg(test)]
mod tests;

pub use dimensions::DimensionedDesign;
pub use duty::{DutyImport, DutyImportOptions, DutyRow, JointRating, Reduction, import_duty, reduce_duty};
pub use dxf::Contour;
pub use fit::{FlankFit, Outlier};
pub use flank::{DesignedFlank, FlankImport, FlankImportOptions, FlankTarget, import_flank};
pub use joint::{
    Hysteresis, JointBench, JointDrive, JointExport, JointInertia, JointState, RunningFriction, SlipElement,
    TorsionCurve, TransmissionWaves, Wave,
};
pub use mesh::Mesh;
pub use meshed::{Body, Placement};
pub use outline::{Outline, OutlinePoint, OutlineTable};
pub use points::{PointFormat, PointSet, read_points};
pub use profile::{Flank, Parts, ProfileExport, ProfileOptions};
pub use solid::SolidFigures;
pub use spline::{CubicSpline, FittedSpline};
pub use split::FlankSplit;

use crate::tables::TableError;
use crate::units::{DEG, MM, UM};

/// Reasons why an import or export fails.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExchangeError {
    /// An offset along the normal exceeds the radius of curvature of the flank.
    #[error(
        "an offset of {:.1} µm undercuts the flank at the meshing angle {:.1}°, where its radius is {:.4} mm",
        .offset / UM, .meshing_angle / DEG, .radius / MM
    )]
    Undercut {
        /// Meshing angle of the smallest radius of curvature, rad.
        meshing_angle: f64,
        /// Requested offset, m.
        offset: f64,
        /// Radius of curvature there, m.
        radius: f64,
    },
    /// A tool path with offset around turned-down tips is requested.
    #[error("offset tool paths are not available for lobes with a tip circle, whose edge has corners")]
    OffsetOfTips,
    /// An option is outside of its range.
    #[error("{what} of {value} is out of range; the range is {low} to {high}")]
    Option {
        /// Quantity with its unit, in words for the message.
        what: &'static str,
        /// Value given.
        value: f64,
        /// Smallest value allowed.
        low: f64,
        /// Largest value allowed.
        high: f64,
    },
    /// Chords or splines do not meet the required deviation.
    #[error("the deviation stays at {:.4} µm, above the tolerance of {:.4} µm", .reached / UM, .tolerance / UM)]
    Tolerance {
        /// Deviation reached, m.
        reached: f64,
        /// Deviation allowed, m.
        tolerance: f64,
    },
    /// A disc number that does not exist.
    #[error("there is no disc {disc}: the design has {count}")]
    NoDisc {
        /// Requested disc, counted from 0.
        disc: usize,
        /// Number of discs of the drive.
        count: usize,
    },
    /// A part that does not exist in the drive or cannot be made from its design; the message.
    #[error("{0}")]
    NoPart(&'static str),
    /// A table cannot be read.
    #[error("{0}")]
    Table(#[from] TableError),
    /// A file of points cannot be read.
    #[error("{file}, line {line}: {message}")]
    Points {
        /// Name of the file.
        file: String,
        /// Line, counted from 1.
        line: usize,
        /// Fault in one sentence.
        message: String,
        /// Advice in one sentence.
        remedy: String,
    },
    /// Points or readings do not determine the required values.
    #[error("{message}")]
    Fit {
        /// Fault in one sentence.
        message: String,
        /// Advice in one sentence.
        remedy: String,
    },
}

impl ExchangeError {
    /// Remedy as a sentence.
    pub fn remedy(&self) -> String {
        match self {
            ExchangeError::Undercut { .. } => "use a thinner wire, a smaller wheel, or less stock".into(),
            ExchangeError::OffsetOfTips => {
                "set the offset to 0, and use the offset of the machine's program".into()
            }
            ExchangeError::Option { .. } => "choose a value in this range".into(),
            ExchangeError::Tolerance { .. } => "allow a larger tolerance".into(),
            ExchangeError::NoDisc { .. } => "count the discs from 1".into(),
            ExchangeError::NoPart(_) => {
                "omit --parts, or choose `discs`, `pin` of a ring of pins, `ring` of a ring of one piece"
                    .into()
            }
            ExchangeError::Table(error) => error.remedy(),
            ExchangeError::Points { remedy, .. } | ExchangeError::Fit { remedy, .. } => remedy.clone(),
        }
    }
}

/// Stamp of every export.
#[derive(Debug, Clone, PartialEq)]
pub struct Stamp {
    /// Version of the program.
    pub version: String,
    /// Name from the design file.
    pub design_name: String,
    /// [`crate::design::Design::short_hash`].
    pub design_hash: String,
}

impl Stamp {
    /// The stamp of this version of the program.
    pub fn of(design: &crate::design::Design) -> Stamp {
        Stamp::named(&design.name, &design.hash())
    }

    /// The stamp of a design with this name and full hash.
    pub(crate) fn named(name: &str, hash: &str) -> Stamp {
        Stamp {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            // It is used in comments of source text and must therefore not contain line breaks.
            design_name: crate::report::printable(name),
            design_hash: hash[..12].to_owned(),
        }
    }
}

/// Millimetres with at most nine decimals, without trailing zeros: a resolution of a picometre, without
/// exponents.
fn millimetres(metres: f64) -> String {
    trimmed(metres / MM, 9)
}

fn trimmed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if matches!(text, "-0" | "") { "0".to_owned() } else { text.to_owned() }
}
