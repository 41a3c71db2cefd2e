//! Contacts on one elastic disc: each approach depends on all forces.

mod descent;

use std::sync::Arc;

use rayon::prelude::*;

use super::{DiscModel, DiscShape, FemError, FlankCompliance, FlexibleSettings, ReducedDisc, Stencil};
use crate::contact::{LineContact, TiltedLine};

/// The reduced discs of a drive. Discs that are the same part, mounted turned, share one reduction.
#[derive(Debug, Clone)]
pub struct FlexibleDiscs {
    /// Reduced disc and the angle to add to τ to come from the disc's own flank to that of the reduction.
    discs: Vec<(Arc<ReducedDisc>, f64)>,
}

impl FlexibleDiscs {
    /// Reduces every different disc; `settings` chooses mesh and modes for a shape.
    ///
    /// # Errors
    /// [`FemError`] of the first disc that cannot be meshed or reduced.
    pub fn reduce(
        shapes: Vec<DiscShape>,
        settings: impl Fn(&DiscShape) -> FlexibleSettings + Sync,
    ) -> Result<FlexibleDiscs, FemError> {
        FlexibleDiscs::with(shapes, |shape| Ok(DiscModel::new(shape.clone(), settings(shape))?.reduce()?.0))
    }

    /// As [`FlexibleDiscs::reduce`], with a function for the reduction of each different shape (which may use a
    /// cache); different shapes are reduced in parallel.
    ///
    /// # Errors
    /// Errors of `reduce`.
    pub fn with<E: Send>(
        shapes: Vec<DiscShape>,
        reduce: impl Fn(&DiscShape) -> Result<ReducedDisc, E> + Sync,
    ) -> Result<FlexibleDiscs, E> {
        let mut different: Vec<DiscShape> = Vec::new();
        let places: Vec<(usize, f64)> = shapes
            .into_iter()
            .map(|shape| {
                let same =
                    different.iter().enumerate().find_map(|(i, other)| Some((i, shape.turned_onto(other)?)));
                same.unwrap_or_else(|| {
                    different.push(shape);
                    (different.len() - 1, 0.0)
                })
            })
            .collect();
        let reduced: Vec<Arc<ReducedDisc>> =
            different.par_iter().map(|shape| reduce(shape).map(Arc::new)).collect::<Result<_, E>>()?;
        Ok(FlexibleDiscs { discs: places.into_iter().map(|(i, turn)| (reduced[i].clone(), turn)).collect() })
    }

    /// The discs of several drives, one after the other.
    pub fn joined<'a>(drives: impl IntoIterator<Item = &'a FlexibleDiscs>) -> FlexibleDiscs {
        FlexibleDiscs { discs: drives.into_iter().flat_map(|drive| drive.discs.iter().cloned()).collect() }
    }

    /// Discs of the drive.
    pub fn count(&self) -> usize {
        self.discs.len()
    }

    /// Reduction of a disc; equal discs share one.
    pub fn reduced(&self, disc: usize) -> &ReducedDisc {
        &self.discs[disc].0
    }

    /// Whether two discs share a reduction.
    pub fn is_shared(&self, disc: usize, other: usize) -> bool {
        Arc::ptr_eq(&self.discs[disc].0, &self.discs[other].0)
    }

    /// Angle in rad by which a disc must be turned to cover the one that was reduced.
    pub fn turn(&self, disc: usize) -> f64 {
        self.discs[disc].1
    }

    /// The place τ of a disc's flank on its reduction.
    #[inline]
    pub fn stencil(&self, disc: usize, tau: f64) -> Stencil {
        let (reduced, turn) = &self.discs[disc];
        reduced.stations.stencil(tau + turn)
    }

    /// As [`FlexibleDiscs::stencil`], for derivatives with respect to τ.
    #[inline]
    pub fn slope_stencil(&self, disc: usize, tau: f64) -> Stencil {
        let (reduced, turn) = &self.discs[disc];
        reduced.stations.slope_stencil(tau + turn)
    }

    /// As [`FlexibleDiscs::stencil`], for second derivatives with respect to τ.
    pub fn bend_stencil(&self, disc: usize, tau: f64) -> Stencil {
        let (reduced, turn) = &self.discs[disc];
        reduced.stations.bend_stencil(tau + turn)
    }

    /// Depth in m at which the displacement of a flank of a disc is read.
    pub fn reading_depth(&self, disc: usize) -> f64 {
        self.reduced(disc).reading_depth
    }
}

/// One contact of the coupled solution.
#[derive(Debug, Clone, Copy)]
pub struct CoupledContact {
    /// Weights of the stations of the flank at this place.
    pub place: Stencil,
    /// Approach s in m if the disc were rigid (less the modal displacement, if any).
    pub approach: f64,
    /// R_eq in m.
    pub equivalent_radius: f64,
    /// Change of the approach by a tilted disc at the two slices of the line, with opposite signs, m.
    pub skew: f64,
}

impl CoupledContact {
    /// The contact law at this contact.
    #[inline]
    pub(crate) fn line<'a>(&self, law: &'a LineContact) -> TiltedLine<'a> {
        TiltedLine { law, equivalent_radius: self.equivalent_radius, skew: self.skew }
    }

    /// Approach in m of the most loaded slice.
    pub(crate) fn deepest(&self) -> f64 {
        self.approach + self.skew.abs()
    }
}

/// Forces of all contacts on one disc: F_i = f(δ_i) with δ_i = s_i − Σ_j C_ij F_j.
///
/// Solved by Newton's method on F; open contacts need no special treatment, since f(δ ≤ 0) = 0 (a semismooth
/// Newton method). C is positive definite and f increases monotonically, so that the solution is unique: it is
/// the minimum of a convex energy.
#[derive(Debug, Clone, Default)]
pub struct CoupledForces {
    /// N.
    pub force: Vec<f64>,
    /// Local approach δ in m; negative where open.
    pub local: Vec<f64>,
    /// f′(δ) in N/m, 0 where open.
    pub local_stiffness: Vec<f64>,
    /// Elastic energy of the flexibility, ½ Fᵀ C F, in J.
    pub flexural_energy: f64,
    compliance: Vec<f64>,
    /// U with UᵀU = f′⁻¹ + C over the closed contacts, by rows, and these contacts. Updates by whole rows of U allow
    /// vector instructions.
    factor: Vec<f64>,
    active: Vec<usize>,
    rhs: Vec<f64>,
}

/// Newton's method takes three to six iterations; after twenty it cycles.
const MAX_ITERATIONS: usize = 20;
/// Rounding of approaches of 1e-6 m permits 1e-10; the forces converge far below the tolerance of any equilibrium.
const TOLERANCE: f64 = 1e-11;
/// Convergence is quadratic: a step from a residual below this is the last one.
const LAST_STEP: f64 = 2e-6;

impl CoupledForces {
    /// Solves for the forces. Returns whether the iteration converged.
    pub fn solve(
        &mut self,
        law: &LineContact,
        compliance: &FlankCompliance,
        contacts: &[CoupledContact],
    ) -> bool {
        self.set_compliance(compliance, contacts);
        self.seed(law, contacts);
        let settled = self.newton(law, contacts) || self.descend(law, contacts);
        self.flexural_energy = 0.5 * (0..contacts.len()).map(|i| self.force[i] * self.bent(i)).sum::<f64>();
        settled
    }

    /// Newton's method from the present forces. Returns whether it converged.
    fn newton(&mut self, law: &LineContact, contacts: &[CoupledContact]) -> bool {
        let n = contacts.len();
        let mut step = vec![0.0; n];
        for _ in 0..MAX_ITERATIONS {
            let (largest, residual) = self.evaluate(law, contacts, &mut step);
            if residual <= TOLERANCE * largest {
                self.factorise(n);
                return true;
            }
            let unchanged = self.newton_step(&mut step, n);
            for i in 0..n {
                self.force[i] = (self.force[i] + step[i]).max(0.0);
            }
            if residual <= LAST_STEP * largest && unchanged {
                self.local = (0..n).map(|i| contacts[i].approach - self.bent(i)).collect();
                return true;
            }
        }
        false
    }

    /// (C F)_i in m.
    fn bent(&self, i: usize) -> f64 {
        let n = self.force.len();
        self.compliance[i * n..(i + 1) * n].iter().zip(&self.force).map(|(c, f)| c * f).sum()
    }

    /// First guess: the law replaced by its secant at the approach without the other forces, (c + C) F = s over
    /// all contacts with positive approach.
    fn seed(&mut self, law: &LineContact, contacts: &[CoupledContact]) {
        let n = contacts.len();
        self.force.clear();
        self.force.resize(n, 0.0);
        self.local.resize(n, 0.0);
        self.local_stiffness.clear();
        self.local_stiffness.resize(n, 0.0);
        self.active.clear();
        for (i, contact) in contacts.iter().enumerate().filter(|(_, contact)| contact.approach > 0.0) {
            let force = contact.line(law).force(contact.approach).0;
            if force > 0.0 {
                self.active.push(i);
                self.local_stiffness[i] = force / contact.approach;
            }
        }
        self.factorise(n);
        let mut rhs = std::mem::take(&mut self.rhs);
        rhs.clear();
        rhs.extend(self.active.iter().map(|i| contacts[*i].approach));
        self.back_substitute(&mut rhs);
        for (i, force) in self.active.iter().zip(&rhs) {
            self.force[*i] = force.max(0.0);
        }
        self.rhs = rhs;
    }

    /// Residuals f(δ) − F in `step`, the closed contacts in `active`; returns the largest force and the
    /// largest residual.
    fn evaluate(&mut self, law: &LineContact, contacts: &[CoupledContact], step: &mut [f64]) -> (f64, f64) {
        let (mut largest, mut residual) = (0.0_f64, 0.0_f64);
        self.active.clear();
        for (i, contact) in contacts.iter().enumerate() {
            self.local[i] = contact.approach - self.bent(i);
            let (f, k) = contact.line(law).force(self.local[i]);
            self.local_stiffness[i] = k;
            step[i] = f - self.force[i];
            largest = largest.max(f.max(self.force[i]));
            residual = residual.max(step[i].abs());
            if k > 0.0 {
                self.active.push(i);
            }
        }
        (largest, residual)
    }

    fn set_compliance(&mut self, compliance: &FlankCompliance, contacts: &[CoupledContact]) {
        let n = contacts.len();
        self.compliance.resize(n * n, 0.0);
        for i in 0..n {
            self.compliance[i * n + i] = compliance.own(&contacts[i].place);
            for j in 0..i {
                let c = compliance.cross(&contacts[i].place, &contacts[j].place);
                self.compliance[i * n + j] = c;
                self.compliance[j * n + i] = c;
            }
        }
    }

    /// Step of F: open contacts lose their force; for the closed ones (f′⁻¹ + C_aa) ΔF_a = r_a/f′_a − C_ao
    /// ΔF_o. Returns whether none of the open ones had a force.
    fn newton_step(&mut self, step: &mut [f64], n: usize) -> bool {
        let mut open_moves = false;
        for i in 0..n {
            if self.local_stiffness[i] <= 0.0 {
                step[i] = -self.force[i];
                open_moves |= self.force[i] != 0.0;
            }
        }
        let mut rhs = std::mem::take(&mut self.rhs);
        rhs.clear();
        for i in &self.active {
            let mut value = step[*i] / self.local_stiffness[*i];
            if open_moves {
                value -= (0..n)
                    .filter(|j| self.local_stiffness[*j] <= 0.0)
                    .map(|j| self.compliance[i * n + j] * step[j])
                    .sum::<f64>();
            }
            rhs.push(value);
        }
        self.factorise(n);
        self.back_substitute(&mut rhs);
        for (k, i) in self.active.iter().enumerate() {
            step[*i] = rhs[k];
        }
        self.rhs = rhs;
        !open_moves
    }

    /// U of f′⁻¹ + C over the active contacts.
    fn factorise(&mut self, n: usize) {
        let count = self.active.len();
        self.factor.resize(count * count, 0.0);
        for (row, i) in self.factor.chunks_exact_mut(count.max(1)).zip(&self.active) {
            let from = &self.compliance[i * n..(i + 1) * n];
            row.iter_mut().zip(&self.active).for_each(|(entry, j)| *entry = from[*j]);
        }
        for (a, i) in self.active.iter().enumerate() {
            self.factor[a * count + a] += 1.0 / self.local_stiffness[*i];
        }
        for a in 0..count {
            let (done, rest) = self.factor.split_at_mut((a + 1) * count);
            let row = &mut done[a * count + a..];
            let scale = 1.0 / row[0].max(f64::MIN_POSITIVE).sqrt();
            row.iter_mut().for_each(|entry| *entry *= scale);
            for (below, b) in rest.chunks_exact_mut(count).zip(a + 1..) {
                subtract_scaled(&mut below[b..], row[b - a], &row[b - a..]);
            }
        }
    }

    /// Row a of U from its diagonal on.
    fn row(&self, a: usize) -> &[f64] {
        let count = self.active.len();
        &self.factor[a * count + a..(a + 1) * count]
    }

    /// Solves with the factor, in place: one entry per active contact.
    fn back_substitute(&self, rhs: &mut [f64]) {
        let count = self.active.len();
        for a in 0..count {
            let row = self.row(a);
            rhs[a] /= row[0];
            let value = rhs[a];
            subtract_scaled(&mut rhs[a + 1..], value, &row[1..]);
        }
        for a in (0..count).rev() {
            let row = self.row(a);
            let sum: f64 = row[1..].iter().zip(&rhs[a + 1..]).map(|(u, x)| u * x).sum();
            rhs[a] = (rhs[a] - sum) / row[0];
        }
    }

    /// [`CoupledForces::respond`] for `width` changes at once, contact by contact.
    pub fn respond_to_all(&self, changes: &mut [f64], width: usize) {
        let count = self.active.len();
        let mut rows: Vec<f64> = Vec::with_capacity(count * width);
        self.active.iter().for_each(|i| rows.extend_from_slice(&changes[i * width..][..width]));
        for a in 0..count {
            let factors = self.row(a);
            let (done, rest) = rows.split_at_mut((a + 1) * width);
            let row = &mut done[a * width..];
            row.iter_mut().for_each(|entry| *entry /= factors[0]);
            for (other, factor) in rest.chunks_exact_mut(width).zip(&factors[1..]) {
                subtract_scaled(other, *factor, row);
            }
        }
        for a in (0..count).rev() {
            let factors = self.row(a);
            let (before, after) = rows.split_at_mut((a + 1) * width);
            let row = &mut before[a * width..];
            for (other, factor) in after.chunks_exact(width).zip(&factors[1..]) {
                subtract_scaled(row, *factor, other);
            }
            row.iter_mut().for_each(|entry| *entry /= factors[0]);
        }
        changes.fill(0.0);
        for (i, row) in self.active.iter().zip(rows.chunks_exact(width)) {
            changes[i * width..][..width].copy_from_slice(row);
        }
    }

    /// Change of the forces, dF = D ds with D = (f′⁻¹ + C)⁻¹ over the closed contacts, for changes ds of the
    /// approaches; in place, n entries.
    pub fn respond(&self, change: &mut [f64], scratch: &mut Vec<f64>) {
        scratch.clear();
        scratch.extend(self.active.iter().map(|i| change[*i]));
        self.back_substitute(scratch);
        change.fill(0.0);
        for (i, value) in self.active.iter().zip(scratch.iter()) {
            change[*i] = *value;
        }
    }
}

/// row − factor · other.
#[inline]
fn subtract_scaled(row: &mut [f64], factor: f64, other: &[f64]) {
    row.iter_mut().zip(other).for_each(|(entry, other)| *entry -= factor * other);
}
