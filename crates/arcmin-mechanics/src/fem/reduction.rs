//! From the full mesh to a few coordinates (Craig & Bampton, AIAA J. 6 (1968) 1313, with attachment modes).
//!
//! With the interface coordinates b (bore centres) apart from the inner unknowns i, u = Ψ b + Φ q: constraint
//! modes Ψ = −K_ii⁻¹ K_ib, and Φ spanned by the fixed-interface normal modes up to a frequency and by the
//! static shapes K_ii⁻¹ f of one unit load on each flank of every tooth. Φ is M-orthonormal and K-diagonal:
//! q̈ + ω² q = Φᵀ f.
//!
//! A few shapes do not resolve a load that moves over a flank, so the static compliance of *every* flank place is
//! stored as well: u_s = Σ_t C_st F_t + … . The compliance of the modes kept in a simulation is subtracted: C − Σ φ
//! φᵀ/ω² (residual flexibility). C_st for s ≠ t reads the surface; C_ss, the displacement of a place under its own
//! load, is evaluated at the depth h: the contact law contains the approach between the surface and that depth, so no
//! compliance counts twice.

use faer::{Accum, Mat};

use super::disc::{DiscModel, Held};
use super::flank::{FlankStations, LOBE_REFINEMENT, NodalWeights, Stencil};
use super::reduced::{FlankCompliance, ReducedDisc};
use super::solve::{ModeRange, symmetric_eigen};
use super::{FemError, MeshQuality};
use crate::kernels::product;

/// Accuracy of the reduced disc relative to the mesh, and quality of the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReductionReport {
    /// Figures of the mesh.
    pub quality: MeshQuality,
    /// Fixed-interface normal modes kept.
    pub normal_modes: usize,
    /// All modes kept, those from flank loads included.
    pub modes: usize,
    /// Lowest held frequency in Hz.
    pub lowest_frequency: f64,
    /// Largest relative error of the interpolated flank compliance halfway between stations, against a load
    /// solved there: own displacement.
    pub own_compliance_error: f64,
    /// The same for the displacement of another tooth, relative to the largest such displacement.
    pub cross_compliance_error: f64,
    /// Share of the own compliance that is missing in the modes (contained in the residual flexibility).
    pub modal_compliance_gap: f64,
}

/// Largest number of normal modes.
const MODE_LIMIT: usize = 60;

impl DiscModel {
    /// Builds the reduced disc.
    ///
    /// # Errors
    /// [`FemError`] if modes do not converge or the reading depth leaves the metal.
    pub fn reduce(&self) -> Result<(ReducedDisc, ReductionReport), FemError> {
        let stations = self.stations();
        let count = stations.count();
        let inner = self.inner_unknowns();
        let surface = self.surface();
        let parameters: Vec<f64> = (0..count).map(|s| stations.parameter(s as f64)).collect();
        let loads: Vec<NodalWeights> = parameters.iter().map(|tau| surface.surface(*tau)).collect();
        let rows: Vec<Vec<(usize, f64)>> = loads.iter().map(|load| self.inner_terms(load)).collect();
        let deep: Vec<Vec<(usize, f64)>> = parameters
            .iter()
            .map(|tau| Ok(self.inner_terms(&surface.at_depth(*tau, self.settings.reading_depth)?)))
            .collect::<Result<_, FemError>>()?;

        let normal =
            self.held_modes(ModeRange::UpTo { frequency: self.settings.mode_frequency, limit: MODE_LIMIT })?;
        let normal_count = normal.eigenvalues.len();
        let attached = attachment_stations(&stations);

        let mut compliance = vec![0.0; count * count];
        let mut own = vec![0.0; count];
        let mut basis: Mat<f64> = Mat::zeros(inner, normal_count + attached.len());
        basis.subcols_mut(0, normal_count).copy_from(&normal.shapes);
        let mut next_attachment = 0;
        self.for_each_solution(&loads, |s, solution| {
            for (t, row) in rows.iter().enumerate() {
                compliance[s * count + t] = read(row, solution);
            }
            own[s] = self.own_displacement(&rows[s], &deep[s], solution);
            if attached.get(next_attachment) == Some(&s) {
                basis.col_as_slice_mut(normal_count + next_attachment).copy_from_slice(solution);
                next_attachment += 1;
            }
        });
        symmetrise(&mut compliance, count);

        // K of the attachment shapes follows from their loads: K_ii a = f.
        let static_energy = |i: usize, j: usize| {
            if j < normal_count {
                if i == j { normal.eigenvalues[i] } else { 0.0 }
            } else {
                read(&rows[attached[j - normal_count]], basis.col_as_slice(i))
            }
        };
        let (eigenvalues, combination) = self.orthonormal_combination(&basis, static_energy)?;
        let mut shapes: Mat<f64> = Mat::zeros(inner, eigenvalues.len());
        product(shapes.as_mut(), Accum::Replace, basis.as_ref(), combination.as_ref(), 1.0);

        let mut compliance = FlankCompliance::new(&stations, compliance, own);
        compliance.refine_own(&self.own_detail(&stations)?);
        let modes = eigenvalues.len();
        let flank = (0..modes)
            .flat_map(|m| {
                stations.coefficients(rows.iter().map(|row| read(row, shapes.col_as_slice(m))).collect())
            })
            .collect();
        let momentum = self.momentum(&shapes);
        let interface = self.interface(&stations, &rows, &shapes)?;
        let reduced = ReducedDisc {
            lobe_count: self.shape.profile.lobe_count(),
            stations: stations.clone(),
            reading_depth: self.settings.reading_depth,
            eigenvalues,
            normal_modes: normal_count,
            flank_modes: flank,
            compliance,
            momentum,
            interface,
        };
        let report = self.report(&reduced, &normal.eigenvalues)?;
        Ok((reduced, report))
    }

    /// Displacement of a place under its own load, evaluated at the depth of `deep`: the contact law contains the
    /// approach above it. Displacements by pressures on the rims are evaluated at the surface, like those of all
    /// other loads; this includes the loads that hold the rims, which correspond to the pressures of rollers in the
    /// machine. Over a bore the two differ by 6 %.
    fn own_displacement(&self, load: &[(usize, f64)], deep: &[(usize, f64)], solution: &[f64]) -> f64 {
        let held = match &self.held {
            Held::Means(means) => means.strain_by_holding(load, deep),
            Held::Unknowns(_) => 0.0,
        };
        read(deep, solution) - held
    }

    /// Own displacements between the stations of one lobe.
    fn own_detail(&self, stations: &FlankStations) -> Result<Vec<(usize, Stencil, f64)>, FemError> {
        let surface = self.surface();
        let lobe = self.lobe_far_from_bores();
        let fine = LOBE_REFINEMENT * stations.per_lobe();
        let places: Vec<(usize, f64)> = (0..fine)
            .filter(|k| k % LOBE_REFINEMENT != 0)
            .map(|k| {
                (
                    k,
                    stations
                        .parameter((lobe * stations.per_lobe()) as f64 + k as f64 / LOBE_REFINEMENT as f64),
                )
            })
            .collect();
        let loads: Vec<NodalWeights> = places.iter().map(|(_, tau)| surface.surface(*tau)).collect();
        let deep: Vec<_> = places
            .iter()
            .map(|(_, tau)| Ok(self.inner_terms(&surface.at_depth(*tau, self.settings.reading_depth)?)))
            .collect::<Result<_, FemError>>()?;
        let mut exact = Vec::with_capacity(places.len());
        self.for_each_solution(&loads, |k, solution| {
            let (index, tau) = places[k];
            let own = self.own_displacement(&self.inner_terms(&loads[k]), &deep[k], solution);
            exact.push((index, stations.stencil(tau), own));
        });
        Ok(exact)
    }

    /// A lobe that is not over a thin wall next to a bore.
    fn lobe_far_from_bores(&self) -> usize {
        let pitch = std::f64::consts::TAU / self.shape.profile.lobe_count() as f64;
        let clearance = |lobe: usize| {
            let tip = self.shape.profile.flank_point((lobe as f64 + 0.5) * pitch);
            self.shape
                .bores
                .iter()
                .chain(&self.shape.holes)
                .map(|hole| (tip - hole.centre).norm() - hole.radius)
                .chain(self.shape.windows.iter().map(|window| window.outline().distance(tip)))
                .fold(f64::INFINITY, f64::min)
        };
        (0..self.shape.profile.lobe_count())
            .max_by(|a, b| clearance(*a).total_cmp(&clearance(*b)))
            .unwrap_or(0)
    }

    fn inner_terms(&self, weights: &NodalWeights) -> Vec<(usize, f64)> {
        let inner = self.inner_unknowns();
        weights.terms(&self.map).into_iter().filter(|(dof, _)| *dof < inner).collect()
    }

    /// Solves the small eigenproblem of the shapes in `basis`: (ω² ascending, combination matrix).
    fn orthonormal_combination(
        &self,
        basis: &Mat<f64>,
        stiffness: impl Fn(usize, usize) -> f64,
    ) -> Result<(Vec<f64>, Mat<f64>), FemError> {
        let n = basis.ncols();
        let mut weighted: Mat<f64> = Mat::zeros(basis.nrows(), n);
        self.inner_mass.multiply(basis.as_ref(), weighted.as_mut());
        let mut m: Mat<f64> = Mat::zeros(n, n);
        product(m.as_mut(), Accum::Replace, basis.transpose(), weighted.as_ref(), 1.0);
        // Shapes scaled to unit mass, then whitened; directions that others already span are dropped.
        let scale: Vec<f64> = (0..n).map(|i| 1.0 / m[(i, i)].sqrt()).collect();
        let scaled = Mat::from_fn(n, n, |i, j| 0.5 * (m[(i, j)] + m[(j, i)]) * scale[i] * scale[j]);
        let (values, vectors) = symmetric_eigen(scaled.as_ref())?;
        let kept: Vec<usize> = (0..n).filter(|k| values[*k] > 1e-9).collect();
        let whitening =
            Mat::from_fn(n, kept.len(), |i, k| scale[i] * vectors[(i, kept[k])] / values[kept[k]].sqrt());
        let k = Mat::from_fn(n, n, |i, j| stiffness(i.min(j), i.max(j)));
        let mut half: Mat<f64> = Mat::zeros(n, kept.len());
        product(half.as_mut(), Accum::Replace, k.as_ref(), whitening.as_ref(), 1.0);
        let mut projected: Mat<f64> = Mat::zeros(kept.len(), kept.len());
        product(projected.as_mut(), Accum::Replace, whitening.transpose(), half.as_ref(), 1.0);
        let symmetric =
            Mat::from_fn(kept.len(), kept.len(), |i, j| 0.5 * (projected[(i, j)] + projected[(j, i)]));
        let (eigenvalues, rotation) = symmetric_eigen(symmetric.as_ref())?;
        let mut combination: Mat<f64> = Mat::zeros(n, kept.len());
        product(combination.as_mut(), Accum::Replace, whitening.as_ref(), rotation.as_ref(), 1.0);
        Ok((eigenvalues, combination))
    }

    /// Φᵀ M r for the rigid motions r = (x, y, turn about the disc centre) of the disc with its interface.
    fn momentum(&self, shapes: &Mat<f64>) -> [Vec<f64>; 3] {
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|rates| {
            let rigid = self.map.rigid_motion(&self.mesh, &self.bores, rates);
            let weighted = self.mass.product(&rigid);
            (0..shapes.ncols())
                .map(|m| shapes.col_as_slice(m).iter().zip(&weighted).map(|(a, b)| a * b).sum())
                .collect()
        })
    }

    fn report(&self, reduced: &ReducedDisc, normal: &[f64]) -> Result<ReductionReport, FemError> {
        let stations = &reduced.stations;
        let per_lobe = stations.per_lobe();
        // Halfway places of one lobe, each on another lobe so that cross displacements are met as well.
        let step = (reduced.lobe_count / per_lobe).max(1);
        let places: Vec<f64> = (0..per_lobe)
            .map(|k| stations.parameter((k * step % reduced.lobe_count * per_lobe + k) as f64 + 0.5))
            .collect();
        let surface = self.surface();
        let loads: Vec<NodalWeights> = places.iter().map(|tau| surface.surface(*tau)).collect();
        let rows: Vec<_> = loads.iter().map(|load| self.inner_terms(load)).collect();
        let deep: Vec<_> = places
            .iter()
            .map(|tau| Ok(self.inner_terms(&surface.at_depth(*tau, reduced.reading_depth)?)))
            .collect::<Result<_, FemError>>()?;
        let (mut own_error, mut cross_error, mut largest_cross, mut gap) =
            (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
        self.for_each_solution(&loads, |a, solution| {
            let exact = self.own_displacement(&rows[a], &deep[a], solution);
            let stencil = stations.stencil(places[a]);
            own_error = own_error.max((reduced.compliance.own(&stencil) / exact - 1.0).abs());
            let modal: f64 = (0..reduced.eigenvalues.len())
                .map(|m| reduced.mode_at(m, &stencil).powi(2) / reduced.eigenvalues[m])
                .sum();
            gap = gap.max((1.0 - modal / exact).abs());
            for (b, row) in rows.iter().enumerate().filter(|(b, _)| *b != a) {
                let exact = read(row, solution);
                largest_cross = largest_cross.max(exact.abs());
                cross_error = cross_error
                    .max((reduced.compliance.cross(&stencil, &stations.stencil(places[b])) - exact).abs());
            }
        });
        Ok(ReductionReport {
            quality: self.quality(),
            normal_modes: reduced.normal_modes,
            modes: reduced.eigenvalues.len(),
            lowest_frequency: normal.first().map_or(0.0, |l| l.sqrt() / std::f64::consts::TAU),
            own_compliance_error: own_error,
            cross_compliance_error: cross_error / largest_cross,
            modal_compliance_gap: gap,
        })
    }
}

/// Σ c u over a sparse row.
pub(super) fn read(row: &[(usize, f64)], unknowns: &[f64]) -> f64 {
    row.iter().map(|(dof, c)| c * unknowns[*dof]).sum()
}

/// One station on each flank of every tooth: a quarter and three quarters of a lobe's arc from the root.
fn attachment_stations(stations: &FlankStations) -> Vec<usize> {
    let per_lobe = stations.per_lobe();
    let places = [per_lobe / 4, per_lobe - per_lobe / 4];
    (0..stations.count() / per_lobe).flat_map(|lobe| places.map(|k| lobe * per_lobe + k)).collect()
}

/// Takes the mean of both triangles: they differ by rounding only.
fn symmetrise(matrix: &mut [f64], n: usize) {
    for i in 0..n {
        for j in 0..i {
            let mean = 0.5 * (matrix[i * n + j] + matrix[j * n + i]);
            matrix[i * n + j] = mean;
            matrix[j * n + i] = mean;
        }
    }
}
