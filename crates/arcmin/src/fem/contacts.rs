//! Contacts that share an elastic disc: each one's approach depends on all forces.

use std::sync::Arc;

use super::{DiscModel, DiscShape, FemError, FlankCompliance, FlexibleSettings, ReducedDisc, Stencil};
use crate::contact::LineContact;
use crate::machine::Machine;

/// The reduced discs of a machine. Discs that are the same part, mounted turned, share one reduction.
#[derive(Debug, Clone)]
pub struct FlexibleDiscs {
    /// Reduced disc and the angle to add to τ to come from the disc's own flank to that of the reduction.
    discs: Vec<(Arc<ReducedDisc>, f64)>,
}

impl FlexibleDiscs {
    /// Reduces every different disc of `machine`; `settings` chooses mesh and modes for a shape.
    ///
    /// # Errors
    /// [`FemError`] of the first disc that cannot be meshed or reduced.
    pub fn reduce(machine: &Machine, settings: impl Fn(&DiscShape) -> FlexibleSettings) -> Result<FlexibleDiscs, FemError> {
        FlexibleDiscs::with(machine, |shape| Ok(DiscModel::new(shape.clone(), settings(shape))?.reduce()?.0))
    }

    /// As [`FlexibleDiscs::reduce`], the reduction of each different shape left to the caller (who may keep a cache).
    ///
    /// # Errors
    /// Whatever `reduce` returns.
    pub fn with<E>(machine: &Machine, mut reduce: impl FnMut(&DiscShape) -> Result<ReducedDisc, E>) -> Result<FlexibleDiscs, E> {
        let mut known: Vec<(DiscShape, Arc<ReducedDisc>)> = Vec::new();
        let mut discs = Vec::new();
        for disc in 0..machine.disc_count {
            let shape = DiscShape::of(machine, disc);
            let same = known.iter().find_map(|(other, reduced)| Some((reduced.clone(), shape.turned_onto(other)?)));
            discs.push(match same {
                Some(found) => found,
                None => {
                    let reduced = Arc::new(reduce(&shape)?);
                    known.push((shape, reduced.clone()));
                    (reduced, 0.0)
                }
            });
        }
        Ok(FlexibleDiscs { discs })
    }

    pub fn count(&self) -> usize {
        self.discs.len()
    }

    pub fn reduced(&self, disc: usize) -> &ReducedDisc {
        &self.discs[disc].0
    }

    /// Whether two discs share a reduction.
    pub fn is_shared(&self, disc: usize, other: usize) -> bool {
        Arc::ptr_eq(&self.discs[disc].0, &self.discs[other].0)
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

    /// The machine's contact law with the disc's own approach read at the reduction's depth.
    pub fn line_contact(&self, machine: &Machine) -> LineContact {
        let depth = self.discs.first().map_or(2.0 * machine.ring.pin_radius, |(reduced, _)| reduced.reading_depth);
        LineContact::with_disc_depth(
            machine.contact_law,
            &machine.disc.material,
            &machine.ring.material,
            machine.disc.width,
            machine.ring.pin_radius,
            depth,
        )
    }
}

/// One contact as it enters the coupled solution.
#[derive(Debug, Clone, Copy)]
pub struct CoupledContact {
    pub place: Stencil,
    /// Approach s in m if the disc were rigid (modal displacement, if any, already taken off).
    pub approach: f64,
    /// R_eq in m.
    pub equivalent_radius: f64,
}

/// Forces of all contacts on one disc: F_i = f(δ_i) with δ_i = s_i − Σ_j C_ij F_j.
///
/// Solved by Newton's method on F; contacts that open drop out and come back by themselves, as f(δ ≤ 0) = 0 (a semismooth Newton method). C is positive
/// definite and f rises, so the solution is unique: it is the minimum of a convex energy.
#[derive(Debug, Clone, Default)]
pub struct CoupledForces {
    /// N.
    pub force: Vec<f64>,
    /// Local approach δ in m; negative where open.
    pub local: Vec<f64>,
    /// f′(δ) in N/m, 0 where open.
    pub local_stiffness: Vec<f64>,
    /// D = ∂F/∂s = (f′⁻¹ + C)⁻¹ in N/m, n × n, rows and columns of open contacts zero.
    pub stiffness: Vec<f64>,
    /// Elastic energy of the flexibility, ½ Fᵀ C F, in J.
    pub flexural_energy: f64,
    compliance: Vec<f64>,
    factor: Vec<f64>,
    active: Vec<usize>,
}

const MAX_ITERATIONS: usize = 60;
/// Rounding of approaches of 1e-6 m allows 1e-10; forces settle far below the tolerance of any equilibrium.
const TOLERANCE: f64 = 1e-11;

impl CoupledForces {
    /// Solves for the forces. Returns whether the iteration settled.
    pub fn solve(&mut self, law: &LineContact, compliance: &FlankCompliance, contacts: &[CoupledContact]) -> bool {
        let n = contacts.len();
        self.set_compliance(compliance, contacts);
        let seed = |c: &CoupledContact| 0.6 * law.force(c.approach, c.equivalent_radius).0;
        self.force.clear();
        self.force.extend(contacts.iter().map(seed));
        self.local.resize(n, 0.0);
        self.local_stiffness.resize(n, 0.0);
        let mut step = vec![0.0; n];
        let mut settled = false;
        for _ in 0..MAX_ITERATIONS {
            let mut largest = 0.0_f64;
            let mut residual = 0.0_f64;
            self.active.clear();
            for i in 0..n {
                let bent: f64 = self.compliance[i * n..(i + 1) * n].iter().zip(&self.force).map(|(c, f)| c * f).sum();
                self.local[i] = contacts[i].approach - bent;
                let (f, k) = law.force(self.local[i], contacts[i].equivalent_radius);
                self.local_stiffness[i] = k;
                step[i] = f - self.force[i];
                largest = largest.max(f.max(self.force[i]));
                residual = residual.max(step[i].abs());
                if k > 0.0 {
                    self.active.push(i);
                }
            }
            if residual <= TOLERANCE * largest {
                settled = true;
                break;
            }
            self.newton_step(&mut step, n);
            for i in 0..n {
                self.force[i] = (self.force[i] + step[i]).max(0.0);
            }
        }
        self.finish(n);
        settled
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

    /// Step of F: open contacts lose their force, for the closed ones (f′⁻¹ + C_aa) ΔF_a = r_a/f′_a − C_ao ΔF_o.
    fn newton_step(&mut self, step: &mut [f64], n: usize) {
        for i in 0..n {
            if self.local_stiffness[i] <= 0.0 {
                step[i] = -self.force[i];
            }
        }
        let count = self.active.len();
        let mut rhs: Vec<f64> = self
            .active
            .iter()
            .map(|i| {
                let open: f64 = (0..n).filter(|j| self.local_stiffness[*j] <= 0.0).map(|j| self.compliance[i * n + j] * step[j]).sum();
                step[*i] / self.local_stiffness[*i] - open
            })
            .collect();
        self.factorise(n);
        self.back_substitute(&mut rhs, count);
        for (k, i) in self.active.iter().enumerate() {
            step[*i] = rhs[k];
        }
    }

    /// Cholesky factor of f′⁻¹ + C over the active contacts, by rows.
    fn factorise(&mut self, n: usize) {
        let count = self.active.len();
        self.factor.resize(count * count, 0.0);
        for a in 0..count {
            for b in 0..=a {
                let (i, j) = (self.active[a], self.active[b]);
                let mut sum = self.compliance[i * n + j];
                if a == b {
                    sum += 1.0 / self.local_stiffness[i];
                }
                for k in 0..b {
                    sum -= self.factor[a * count + k] * self.factor[b * count + k];
                }
                self.factor[a * count + b] = if a == b { sum.max(f64::MIN_POSITIVE).sqrt() } else { sum / self.factor[b * count + b] };
            }
        }
    }

    fn back_substitute(&self, rhs: &mut [f64], count: usize) {
        for a in 0..count {
            let sum: f64 = (0..a).map(|k| self.factor[a * count + k] * rhs[k]).sum();
            rhs[a] = (rhs[a] - sum) / self.factor[a * count + a];
        }
        for a in (0..count).rev() {
            let sum: f64 = (a + 1..count).map(|k| self.factor[k * count + a] * rhs[k]).sum();
            rhs[a] = (rhs[a] - sum) / self.factor[a * count + a];
        }
    }

    fn finish(&mut self, n: usize) {
        self.factorise(n);
        let count = self.active.len();
        self.stiffness.clear();
        self.stiffness.resize(n * n, 0.0);
        let mut column = vec![0.0; count];
        for b in 0..count {
            column.fill(0.0);
            column[b] = 1.0;
            self.back_substitute(&mut column, count);
            for (a, value) in column.iter().enumerate() {
                self.stiffness[self.active[a] * n + self.active[b]] = *value;
            }
        }
        self.flexural_energy = 0.5
            * (0..n)
                .map(|i| self.force[i] * self.compliance[i * n..(i + 1) * n].iter().zip(&self.force).map(|(c, f)| c * f).sum::<f64>())
                .sum::<f64>();
    }
}
