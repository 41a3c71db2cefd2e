//! Elastic bodies: meshes, finite elements, reduction to a few coordinates.
//!
//! The data's way: `DiscShape` (outline, bores, width, material) → [`Mesh`] (T6 plane stress or Tet10 through
//! half the width) → [`assembly`] (K, M with bores free, held or tied to rigid spiders) → [`solve`]
//! (sparse Cholesky, modes) → `reduction` (`ReducedDisc`: Craig–Bampton modes and the compliance of every flank
//! place, with the rims of its bores). Carrier and housing are [`body`] made of layers, [`symmetry`] parts of them, condensed to
//! their seats in [`bodies`]. `load` and `dynamics` only ever see what is reduced. `vtu` writes meshes and fields for
//! ParaView.

pub mod assembly;
pub mod bodies;
pub mod body;
#[cfg(test)]
mod body_tests;
pub mod boundary;
pub mod cache;
pub mod carrier;
pub mod contacts;
pub mod disc;
pub mod elements;
pub mod flank;
pub mod housing;
mod interface;
pub mod mesh;
mod modes;
pub mod plane;
pub mod quadrature;
mod reduced;
pub mod reduction;
mod rims;
pub mod shape;
pub mod solve;
mod stress;
pub mod symmetry;
#[cfg(test)]
pub(crate) mod tests;
#[cfg(test)]
mod verification;
pub mod vtu;

pub use assembly::{BoreTie, DofMap, MasterMotion, SymmetricMatrix, TiedBore};
pub use bodies::{BodyShapes, ElasticBodies};
pub use body::{Body, Compliance, NodalLoad, Seat, Traction};
pub use boundary::Boundary;
pub use cache::{CacheError, CacheKey};
pub use carrier::CarrierShape;
pub use contacts::{CoupledContact, CoupledForces, FlexibleDiscs};
pub use disc::{DiscModel, FlankLoad};
pub use flank::{FlankStations, Stencil};
pub use housing::HousingShape;
pub use mesh::{ElementKind, Mesh, MeshQuality};
pub use modes::{BoreWay, FlankModes, FreeModes};
pub use plane::{MeshSizes, PlaneDomain, PlaneMesh};
pub use reduced::{FlankCompliance, Interface, ReducedDisc};
pub use reduction::ReductionReport;
pub use shape::{BoreInterface, DiscElement, DiscShape, FlexibleSettings, RoundHole};
pub use vtu::DeformedPicture;

/// Errors between a disc's outline and its reduced model.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FemError {
    #[error("the outline cannot be meshed: {reason}")]
    Mesh { reason: String },
    #[error(
        "element {element} is inverted (Jacobian determinant {determinant:.3e}): the mesh is too coarse for its curved edges"
    )]
    InvertedElement { element: usize, determinant: f64 },
    #[error("the stiffness matrix of {unknowns} unknowns cannot be factorised: {reason}")]
    Factorisation { unknowns: usize, reason: String },
    #[error("only {found} of {wanted} modes converged within {vectors} Krylov vectors")]
    Modes { found: usize, wanted: usize, vectors: usize },
    #[error("{what} lies outside the mesh")]
    OutsideMesh { what: String },
    #[error(
        "one rigid spider ties all bores of the disc, so that none moves by itself: reduce it with its bores apart"
    )]
    NoInterface,
}
