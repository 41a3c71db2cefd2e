//! Deformable rims of the bores of a disc as interface: means of their displacement.
//!
//! Rollers load a rim by tractions f_k, and their approach depends on the means b_k = f_kᵀ u
//! (`Traction::Radial`, `Traction::Expansion`): for each bore the displacement of its centre and the orders of
//! its ovalisation. With a held interface these means are zero, b = 0, by constraint loads Fλ:
//!
//! K u = f + F λ, Fᵀ u = 0.
//!
//! Let R be the rigid motions and S = (K + springs that act on R only)⁻¹. For loads in equilibrium, Rᵀ(f + F λ)
//! = 0, the springs are free of force, u = S (f + F λ) + R a, and the remaining system is small:
//!
//! [FᵀSF FᵀR; RᵀF 0] (λ, a) = −(FᵀS f, Rᵀ f).

use faer::{Accum, Mat, MatMut};
use nalgebra::{DMatrix, DVector};

use super::body::{Seat, Traction, seat_load};
use super::reduction::read;
use super::solve::{Cholesky, Inverse};
use super::{DofMap, FemError, Mesh, SymmetricMatrix, TiedBore};
use crate::kernels::product;

/// Rigid motions in the plane.
const RIGID: usize = 3;

/// K⁻¹ of a disc with held means of its rims.
pub(super) struct HeldMeans {
    /// (K + springs)⁻¹.
    factor: Cholesky,
    /// f_k as sparse columns over the unknowns.
    loads: Vec<Vec<(usize, f64)>>,
    /// Columns S F, then R, over the unknowns. Rotations are measured as displacements at `radius`.
    shapes: Mat<f64>,
    /// Inverse of the small matrix in units of `unit`: λ unit and a are its unknowns.
    small: DMatrix<f64>,
    /// m/N.
    unit: f64,
}

impl HeldMeans {
    /// With the means under these tractions on every bore.
    pub fn new(
        mesh: &Mesh,
        map: &DofMap,
        stiffness: &SymmetricMatrix,
        bores: &[TiedBore],
        tractions: &[Traction],
    ) -> Result<HeldMeans, FemError> {
        let layers = 0..mesh.levels.len().saturating_sub(1) / 2;
        let loads: Vec<Vec<(usize, f64)>> = bores
            .iter()
            .flat_map(|bore| {
                let seat = Seat::around(bore.boundary, layers.clone(), bore.centre, bore.radius);
                tractions.iter().map(move |traction| (seat.clone(), *traction))
            })
            .map(|(seat, traction)| {
                let nodal = seat_load(mesh, &seat, traction);
                nodal.into_iter().map(|(node, axis, f)| (map.terms(node, axis)[0].0, f)).collect()
            })
            .collect();
        let radius = mesh.plane.nodes.iter().fold(0.0_f64, |most, node| most.max(node.norm()));
        let factor = Cholesky::new(&sprung(mesh, map, stiffness, radius))?;
        let count = loads.len();
        let mut shapes: Mat<f64> = Mat::zeros(map.count, count + RIGID);
        for (k, load) in loads.iter().enumerate() {
            load.iter().for_each(|(dof, f)| shapes[(*dof, k)] += f);
        }
        factor.solve(shapes.subcols_mut(0, count));
        let rates = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0 / radius]];
        for (motion, rates) in rates.into_iter().enumerate() {
            let rigid = map.rigid_motion(mesh, bores, rates);
            shapes.col_as_slice_mut(count + motion).copy_from_slice(&rigid);
        }
        let means = DMatrix::from_fn(count, count + RIGID, |i, j| read(&loads[i], shapes.col_as_slice(j)));
        let unit = (0..count).map(|k| means[(k, k)]).sum::<f64>() / count as f64;
        let small = DMatrix::from_fn(count + RIGID, count + RIGID, |i, j| match (i < count, j < count) {
            (true, true) => 0.5 * (means[(i, j)] + means[(j, i)]) / unit,
            (true, false) => means[(i, j)],
            (false, true) => means[(j, i)],
            (false, false) => 0.0,
        });
        let small = small.try_inverse().ok_or_else(|| FemError::Factorisation {
            unknowns: count + RIGID,
            reason: "the means of the rims do not constrain the rigid motions of the disc".to_owned(),
        })?;
        Ok(HeldMeans { factor, loads, shapes, small, unit })
    }

    /// Interface coordinates: the tractions of every bore in turn.
    pub fn count(&self) -> usize {
        self.loads.len()
    }

    /// Springs against rigid motions, and the loads.
    #[cfg(test)]
    pub fn parts(&self) -> (&Cholesky, &[Vec<(usize, f64)>]) {
        (&self.factor, &self.loads)
    }

    /// Displacement of the point of `deep` relative to the surface under a load, caused by the constraint
    /// loads.
    pub fn strain_by_holding(&self, load: &[(usize, f64)], deep: &[(usize, f64)]) -> f64 {
        let count = self.count();
        let along = |terms: &[(usize, f64)]| {
            DVector::from_fn(count + RIGID, |k, _| read(terms, self.shapes.col_as_slice(k)))
        };
        let at = along(load);
        let wanted = DVector::from_fn(count + RIGID, |k, _| -at[k] * if k < count { 1.0 } else { self.unit });
        let mut found = &self.small * wanted;
        found.rows_mut(0, count).scale_mut(1.0 / self.unit);
        found.dot(&(along(deep) - at))
    }

    /// Shapes of minimum energy with one mean equal to 1 and the others to 0, one column each, and the loads
    /// that cause them: K_bb.
    pub fn constraint_modes(&self) -> (Mat<f64>, Vec<f64>) {
        let count = self.count();
        let small = Mat::from_fn(count + RIGID, count, |i, k| {
            self.small[(i, k)] / if i < count { self.unit } else { 1.0 }
        });
        let mut shapes: Mat<f64> = Mat::zeros(self.shapes.nrows(), count);
        product(shapes.as_mut(), Accum::Replace, self.shapes.as_ref(), small.as_ref(), 1.0);
        let stiffness = (0..count * count).map(|at| {
            let (i, j) = (at / count, at % count);
            0.5 * (small[(i, j)] + small[(j, i)])
        });
        (shapes, stiffness.collect())
    }
}

impl Inverse for HeldMeans {
    fn solve(&self, mut b: MatMut<'_, f64>) {
        let count = self.count();
        let rigid = self.shapes.subcols(count, RIGID);
        let mut moments: Mat<f64> = Mat::zeros(RIGID, b.ncols());
        product(moments.as_mut(), Accum::Replace, rigid.transpose(), b.as_ref(), 1.0);
        self.factor.solve(b.as_mut());
        let mut held: Mat<f64> = Mat::zeros(count + RIGID, b.ncols());
        for k in 0..b.ncols() {
            let mean = |load: &[(usize, f64)]| load.iter().map(|(dof, f)| f * b[(*dof, k)]).sum::<f64>();
            let wanted = DVector::from_fn(count + RIGID, |i, _| match self.loads.get(i) {
                Some(load) => -mean(load),
                None => -self.unit * moments[(i - count, k)],
            });
            let found = &self.small * wanted;
            for i in 0..count + RIGID {
                held[(i, k)] = found[i] / if i < count { self.unit } else { 1.0 };
            }
        }
        product(b.as_mut(), Accum::Add, self.shapes.as_ref(), held.as_ref(), 1.0);
    }
}

/// The stiffness with springs at two distant nodes, which act on the three rigid motions only.
fn sprung(mesh: &Mesh, map: &DofMap, stiffness: &SymmetricMatrix, radius: f64) -> SymmetricMatrix {
    let mut sprung = stiffness.clone();
    let near = |x: f64| {
        let distance = |node: &usize| (mesh.plane.nodes[*node] - crate::geometry::Vec2::new(x, 0.0)).norm();
        (0..mesh.plane.corner_count).min_by(|m, n| distance(m).total_cmp(&distance(n))).unwrap_or(0)
    };
    let (ahead, behind) = (near(radius), near(-radius));
    for (node, axis) in [(ahead, 0), (ahead, 1), (behind, 1)] {
        // The diagonal comes first in its column. Any stiffness like those around it will do.
        let diagonal = sprung.column_start[map.terms(node, axis)[0].0];
        sprung.values[diagonal] *= 2.0;
    }
    sprung
}
