//! Finite element model of a disc from its shape: mesh, matrices, factorisation, exact solutions.

use faer::{Mat, MatMut};

use super::assembly;
use super::flank::{FlankStations, FlankSurface, NodalWeights};
use super::rims::HeldMeans;
use super::solve::{Cholesky, Inverse, ModeRange, Modes, lowest_modes};
use super::{
    DiscElement, DiscShape, DofMap, FemError, FlexibleSettings, Mesh, MeshQuality, PlaneMesh,
    SymmetricMatrix, TiedBore,
};

/// A force on the flank along its inward normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankLoad {
    /// Trace parameter τ.
    pub tau: f64,
    /// N.
    pub force: f64,
}

/// The full finite element model of a disc with its interface held: the reference for reduced ones.
///
/// The matrices are those of the whole width; those of a half-width mesh are doubled.
pub struct DiscModel {
    /// Shape that was meshed.
    pub shape: DiscShape,
    /// Element, sizes and interface of the model.
    pub settings: FlexibleSettings,
    /// Mesh of the disc or of half its width.
    pub mesh: Mesh,
    pub(super) bores: Vec<TiedBore>,
    pub(super) map: DofMap,
    pub(super) stiffness: SymmetricMatrix,
    pub(super) mass: SymmetricMatrix,
    pub(super) held: Held,
    pub(super) inner_mass: SymmetricMatrix,
}

/// K⁻¹ with the interface held.
pub(super) enum Held {
    /// Interface coordinates are separate unknowns, numbered last.
    Unknowns(Cholesky),
    /// They are means of displacements.
    Means(Box<HeldMeans>),
}

impl Inverse for Held {
    fn solve(&self, b: MatMut<'_, f64>) {
        match self {
            Held::Unknowns(factor) => factor.solve(b),
            Held::Means(means) => means.solve(b),
        }
    }
}

/// Number of columns solved together: efficient for dense kernels, limited by memory.
pub(super) const SOLVE_BLOCK: usize = 64;

impl DiscModel {
    /// Meshes, assembles and factorises.
    ///
    /// # Errors
    /// [`FemError`] of the stage that failed.
    pub fn new(shape: DiscShape, settings: FlexibleSettings) -> Result<DiscModel, FemError> {
        let plane = PlaneMesh::triangulate(&shape.domain(&settings.sizes))?;
        let mesh = match settings.element {
            DiscElement::PlaneStress => Mesh::plane_stress(plane, shape.width),
            DiscElement::Solid { layers } => Mesh::extruded(plane, shape.width, layers.max(1), true),
        };
        mesh.check()?;
        let bores = shape.tied_bores(settings.interface.tie());
        let map = DofMap::new(&mesh, &bores);
        let mut stiffness = assembly::stiffness(&mesh, &shape.material, &map)?;
        let mut mass = assembly::mass(&mesh, &shape.material, &map);
        if mesh.half_width {
            stiffness.values.iter_mut().chain(&mut mass.values).for_each(|v| *v *= 2.0);
        }
        let inner = map.count - map.retained;
        let tractions = settings.interface.tractions();
        let held = if tractions.is_empty() {
            Held::Unknowns(Cholesky::new(&stiffness.leading(inner))?)
        } else {
            Held::Means(Box::new(HeldMeans::new(&mesh, &map, &stiffness, &bores, &tractions)?))
        };
        let inner_mass = mass.leading(inner);
        Ok(DiscModel { shape, settings, mesh, bores, map, stiffness, mass, held, inner_mass })
    }

    /// Unknowns with the interface held.
    pub fn inner_unknowns(&self) -> usize {
        self.map.count - self.map.retained
    }

    /// Figures of the mesh.
    pub fn quality(&self) -> MeshQuality {
        self.mesh.quality()
    }

    /// Places of the flank where unit loads are solved for.
    pub fn stations(&self) -> FlankStations {
        FlankStations::new(&self.shape.profile, self.settings.stations_per_lobe)
    }

    pub(super) fn surface(&self) -> FlankSurface<'_> {
        // Well below the reading depth, about an element to either side.
        FlankSurface::new(&self.mesh, &self.shape.profile, 0.5 * self.settings.reading_depth)
    }

    /// Holds the means of its rims, where these are the interface.
    #[cfg(test)]
    pub(super) fn held_means(&self) -> Option<&HeldMeans> {
        match &self.held {
            Held::Means(means) => Some(means),
            Held::Unknowns(_) => None,
        }
    }

    /// Lowest modes with the interface held.
    ///
    /// # Errors
    /// [`FemError::Modes`] if they do not converge.
    pub fn held_modes(&self, range: ModeRange) -> Result<Modes, FemError> {
        lowest_modes(&self.inner_mass, &self.held, 0.0, range)
    }

    /// Lowest modes of the disc with its interface free: three rigid-body modes first.
    ///
    /// # Errors
    /// [`FemError`] if the shifted matrix cannot be factorised or the modes do not converge.
    pub fn free_modes(&self, count: usize) -> Result<Modes, FemError> {
        // Spiders stay in their bores; a shift of (2π·1 kHz)² is far below the first
        // elastic mode.
        let sigma = (std::f64::consts::TAU * 1e3).powi(2);
        let factor = Cholesky::new(&self.stiffness.shifted(sigma, &self.mass))?;
        lowest_modes(&self.mass, &factor, sigma, ModeRange::Count(count))
    }

    /// Unknowns under flank loads, the interface held.
    pub fn deflect(&self, loads: &[FlankLoad]) -> Vec<f64> {
        let surface = self.surface();
        let mut force = vec![0.0; self.map.count];
        for load in loads {
            surface.surface(load.tau).add_force(&self.map, &mut force, load.force);
        }
        let mut solution = Mat::from_fn(self.inner_unknowns(), 1, |i, _| force[i]);
        self.held.solve(solution.as_mut());
        let mut unknowns: Vec<f64> = solution.col(0).iter().copied().collect();
        unknowns.resize(self.map.count, 0.0);
        unknowns
    }

    /// Displacement of every node in m for a vector of unknowns.
    pub fn nodal_displacement(&self, unknowns: &[f64]) -> Vec<[f64; 3]> {
        let mut padded = unknowns.to_vec();
        padded.resize(self.map.count, 0.0);
        self.map.expand(&padded)
    }

    /// Normal displacement (inward, m) at the surface place τ for a vector of unknowns.
    pub fn read_surface(&self, unknowns: &[f64], tau: f64) -> f64 {
        self.surface().surface(tau).read(&self.map, unknowns)
    }

    /// Normal displacement (inward, m) at the reading depth below τ.
    ///
    /// # Errors
    /// [`FemError::OutsideMesh`] if the place is not in the metal.
    pub fn read_at_depth(&self, unknowns: &[f64], tau: f64, depth: f64) -> Result<f64, FemError> {
        Ok(self.surface().at_depth(tau, depth)?.read(&self.map, unknowns))
    }

    /// Solutions for a set of unit loads with the interface held, block by block.
    pub(super) fn for_each_solution(&self, loads: &[NodalWeights], mut visit: impl FnMut(usize, &[f64])) {
        let inner = self.inner_unknowns();
        for (block, chunk) in loads.chunks(SOLVE_BLOCK).enumerate() {
            let mut columns: Mat<f64> = Mat::zeros(inner, chunk.len());
            for (k, load) in chunk.iter().enumerate() {
                // Terms on interface coordinates are held: their force goes into the bearing.
                for (dof, c) in load.terms(&self.map).into_iter().filter(|(dof, _)| *dof < inner) {
                    columns[(dof, k)] += c;
                }
            }
            self.held.solve(columns.as_mut());
            for k in 0..chunk.len() {
                visit(block * SOLVE_BLOCK + k, columns.col_as_slice(k));
            }
        }
    }
}
