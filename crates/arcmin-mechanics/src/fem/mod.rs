//! Elastic bodies: meshes, finite elements, reduction to a few coordinates.
//!
//! Flow of data: `DiscShape` (outline, bores, width, material) → [`Mesh`] (T6 plane stress or Tet10 through half the
//! width) → [`assembly`] (K, M with bores free, held or tied to rigid spiders) → [`solve`] (sparse Cholesky, modes) →
//! `reduction` (`ReducedDisc`: Craig–Bampton modes and the compliance of every flank place, with the rims of its
//! bores). Carrier and housing are made of layers ([`body`]), meshed by classes of symmetry ([`symmetry`]) and
//! condensed to their seats ([`bodies`]). `load` and `dynamics` use reduced bodies only. `vtu` writes meshes and
//! fields for ParaView.

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
pub use modes::{BoreMotion, FlankModes, FreeModes};
pub use plane::{MeshSizes, PlaneDomain, PlaneMesh};
pub use reduced::{FlankCompliance, Interface, ReducedDisc};
pub use reduction::ReductionReport;
pub use shape::{BoreInterface, DiscElement, DiscShape, FlexibleSettings, RoundHole};
pub use vtu::DeformedPicture;

/// Errors in the steps from a disc's outline to its reduced model.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FemError {
    /// The section cannot be divided into triangles.
    #[error("the outline cannot be meshed: {reason}")]
    Mesh {
        /// Fault of the section or of its dimensions, in words for the message.
        reason: String,
    },
    /// A mid-side node on a curved edge has inverted an element.
    #[error(
        "element {element} is inverted (Jacobian determinant {determinant:.3e}): the mesh is too coarse for its curved edges"
    )]
    InvertedElement {
        /// Number of the element.
        element: usize,
        /// Smallest Jacobian determinant in it, m² or m³.
        determinant: f64,
    },
    /// The matrix is not positive definite, for example because the body is not held.
    #[error("the stiffness matrix of {unknowns} unknowns cannot be factorised: {reason}")]
    Factorisation {
        /// Number of unknowns.
        unknowns: usize,
        /// Reason that the factorisation gives.
        reason: String,
    },
    /// The eigenvalue iteration did not converge.
    #[error("only {found} of {required} modes converged within {vectors} Krylov vectors")]
    Modes {
        /// Modes that converged.
        found: usize,
        /// Number of modes required.
        required: usize,
        /// Krylov vectors used.
        vectors: usize,
    },
    /// A point at which a displacement is evaluated is outside of the material.
    #[error("{what} lies outside the mesh")]
    OutsideMesh {
        /// The point, in words for the message.
        what: String,
    },
    /// Free modes are required, but the bores of the disc are connected rigidly.
    #[error(
        "all bores of the disc are connected by one rigid spider, so that bores have no separate motions: reduce the disc with separate bores"
    )]
    NoInterface,
}
