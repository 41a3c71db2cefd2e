use arcmin::dynamics::{BearingMeshing, ElasticDiscs, JointSettings};
use arcmin::machine::{Machine, ManufacturingErrors};

use crate::failure::Failure;

/// How the bodies are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Joints {
    /// Without clearance and compliance.
    Ideal,
    /// Every body free in its bearings.
    Bearings,
}

impl Joints {
    pub fn word(self) -> &'static str {
        match self {
            Joints::Ideal => "ideal",
            Joints::Bearings => "bearings",
        }
    }
}

/// Refuses what only the equilibrium of forces can do where another method is chosen in its place, by an
/// option.
pub fn refuse_beyond(method: &str, option: &str, joints: Joints, flexible: bool) -> Result<(), Failure> {
    let (what, own) = match (joints, flexible) {
        (_, true) => ("elastic discs", "--flexible"),
        (Joints::Bearings, false) => ("bearings", "--joints"),
        (Joints::Ideal, false) => return Ok(()),
    };
    Err(Failure::Usage {
        message: format!("{method} knows no {what}"),
        help: format!("leave {own} or {option} out"),
    })
}

/// Load sharing with bearings, new surfaces, on rigid or elastic discs.
pub fn bearing_meshing(
    machine: &Machine,
    errors: &ManufacturingErrors,
    discs: Option<ElasticDiscs>,
) -> Result<BearingMeshing, Failure> {
    BearingMeshing::new(machine, &JointSettings { errors: errors.clone(), discs, ..JointSettings::default() })
        .map_err(|error| Failure::Usage {
            message: error.to_string(),
            help: "ideal joints (--joints ideal) take every machine".to_owned(),
        })
}
