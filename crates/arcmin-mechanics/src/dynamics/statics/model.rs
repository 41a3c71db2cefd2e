//! Model of the machine at one position: linearised gaps, exact force laws, all other forces by their tangent.

use super::compliance::Compliance;
use crate::contact::Pressed;
use crate::dynamics::system::{Evaluation, RoundSupport};
use crate::dynamics::{DenseLinearisation, System, Weights};

/// Limit of Newton steps on one model. A model with n contacts that open or close needs fewer than n.
const NEWTON_STEPS: usize = 60;
/// Tolerance of the solution of the model relative to the forces at its position; the change of position has a
/// larger effect.
const EXACTNESS: f64 = 1e-3;
/// A line search ends when the slope along the step has decreased to this fraction; values between 0.01 and 0.9
/// are equivalent.
const SLOPE_LEFT: f64 = 0.5;
/// Smallest distance of a trial from either end of the bracket of a line search, relative to the bracket.
const NEAR_END: f64 = 0.1;
/// Proximal term relative to the largest work of the forces along one unit of scale. It affects only bodies
/// without stiffness, whose displacement it limits to a hundred thousand units of scale.
const PROXIMAL: f64 = 1e-5;
/// Lower limit of the proximal term relative to the largest stiffness, for the rounding of the factors.
const ROUNDING: f64 = 1e-13;
/// Multiples of the largest stiffness that are added to a Newton matrix that is not positive definite, in
/// increasing order until it is (Nocedal and Wright 2006, algorithm 3.3): from rounding to dominance.
const ADDED: [f64; 8] = [0.0, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 1.0, 100.0];
/// Stiffness of the penalty beyond the trust region relative to that which balances the largest force within
/// it: steps exceed the region by a tenth.
const FENCE: f64 = 10.0;

/// Residual after a step d: R(d) = Q − K_s d + Σ P_i (F_i − F_i⁰) − (proximal term) d.
///
/// The gap of contact i is x_i = g_i + G_i d + b_i + Σ_j C_ij (h_j − F_j⁰), where h are the forces under which
/// elastic bodies deform. The compliance C = G_e K_e⁻¹ G_eᵀ is that of their coordinates, with the constant
/// stiffness K_e, plus that of a flank between its contacts; b = G_e K_e⁻¹ Q_e is the displacement by the
/// residual on these coordinates. If h = F the elastic coordinates are in equilibrium, so that they need not be
/// unknowns.
#[derive(Debug, Clone, Default)]
pub(super) struct Model {
    /// Scales of the unknown coordinates.
    scale: Vec<f64>,
    force: Vec<f64>,
    matrix: DenseLinearisation,
    /// Sum over the contacts that depend on the same columns.
    block: Vec<f64>,
    contacts: Vec<Gap>,
    stiffness: Vec<f64>,
    supports: Vec<[f64; 2]>,
    compliance: Compliance,
    /// R without the proximal term and the penalty, and with them.
    bare: Vec<f64>,
    left: Vec<f64>,
    /// d, its Newton step, and d during a line search.
    moved: Vec<f64>,
    newton: Vec<f64>,
    trial: Vec<f64>,
}

/// Gap of one contact in the model.
#[derive(Debug, Clone, Copy)]
struct Gap {
    /// Initial value g + b, and present x.
    initial: f64,
    now: f64,
    /// Change of x along the present Newton step.
    change: f64,
    /// F⁰, and the present force law.
    initial_force: f64,
    pressed: Pressed,
}

/// Limits of a step: a stiffness on every coordinate, and an additional one beyond the trust region.
struct Bounds {
    proximal: f64,
    reach: f64,
    fence: f64,
}

impl Bounds {
    fn force(&self, scale: f64, d: f64) -> f64 {
        let beyond = (d.abs() - self.reach * scale).max(0.0);
        (self.proximal * d + self.fence * beyond.copysign(d)) / (scale * scale)
    }

    fn stiffness(&self, scale: f64, d: f64) -> f64 {
        let fence = if d.abs() > self.reach * scale { self.fence } else { 0.0 };
        (self.proximal + fence) / (scale * scale)
    }
}

/// A minimum of the model.
pub(super) struct Solution {
    /// Whether it lies within the trust region.
    pub is_inside: bool,
    /// Number of loaded contacts.
    pub pressed: usize,
    /// Work of the residual along one unit of scale, relative to that at the initial position.
    pub inexactness: f64,
    /// Largest residual in N or N·m.
    pub residual: f64,
}

/// Displacement (m) of a support after a step.
fn shift(support: &RoundSupport, step: &[f64]) -> [f64; 2] {
    let mut shift = support.shift;
    for (i, row) in support.index.iter().zip(&support.gradient) {
        shift[0] += step[*i] * row[0];
        shift[1] += step[*i] * row[1];
    }
    shift
}

impl Model {
    /// Adapts the memory to the size of a system.
    pub fn fit<S: System>(&mut self, system: &S, evaluation: &Evaluation) {
        let searched = evaluation.columns.searched();
        self.scale.clear();
        self.scale.extend(searched.iter().map(|i| system.scale()[*i]));
        self.matrix.fit(searched.len());
        let Model { force, bare, left, moved, newton, trial, .. } = self;
        for vector in [force, bare, left, moved, newton, trial] {
            vector.clear();
            vector.resize(searched.len(), 0.0);
        }
    }

    /// Computes `step`, over all coordinates, as the minimum of the model at an evaluated position, within the
    /// trust region. Contacts are included up to the range of the evaluation only, so that a step that exceeds
    /// it ends there. `None` if no descent direction is found.
    pub fn solve<S: System>(
        &mut self,
        system: &S,
        evaluation: &Evaluation,
        (reach, range): (f64, f64),
        step: &mut [f64],
    ) -> Option<Solution> {
        self.set_evaluation(system, evaluation);
        let unit_work = work(&self.force, &self.scale).max(self.compliance.work);
        let along = self.scale.iter().enumerate().map(|(i, s)| evaluation.smooth.stiffness(i, i) * s * s);
        let least = PROXIMAL * unit_work + ROUNDING * along.fold(0.0, f64::max);
        let bounds = Bounds { proximal: least, reach, fence: FENCE * unit_work / reach };
        self.minimise(system, evaluation, &bounds, range, unit_work)?;
        step.fill(0.0);
        evaluation.columns.searched().iter().zip(&self.moved).for_each(|(i, d)| step[*i] = *d);
        self.compliance.add_elastic_displacements(system, &evaluation.contacts, step);
        let is_inside = self.is_within(reach.min(range));
        let residual = self.bare.iter().fold(0.0, |most: f64, left| most.max(left.abs()));
        let gaps = self.contacts.iter().zip(&evaluation.contacts.list);
        let closed = gaps.filter(|(gap, contact)| gap.now < 0.0 && contact.is_gap()).count();
        let supports = evaluation.contacts.supports.iter();
        let pressed =
            closed + supports.filter(|support| support.presses(shift(support, &self.moved))).count();
        let inexactness = self.unbalanced_work() / unit_work;
        Some(Solution { is_inside, pressed, inexactness, residual })
    }

    fn set_evaluation<S: System>(&mut self, system: &S, evaluation: &Evaluation) {
        let of_column = evaluation.columns.searched().iter().map(|i| evaluation.force[*i]);
        self.force.iter_mut().zip(of_column).for_each(|(force, of)| *force = of);
        self.compliance.set_evaluation(system, evaluation);
        self.supports.clear();
        self.supports.extend(evaluation.contacts.supports.iter().map(|support| support.force(support.shift)));
        self.contacts.clear();
        for contact in &evaluation.contacts.list {
            let residual_displacement =
                contact.place.map_or(0.0, |place| self.compliance.places[place].residual_displacement);
            let initial = contact.gap + residual_displacement;
            let pressed = contact.pressed;
            if let Some(place) = contact.place {
                self.compliance.places[place].initial_load += pressed.force;
            }
            let initial_force = pressed.force;
            self.contacts.push(Gap { initial, now: initial, change: 0.0, initial_force, pressed });
        }
    }

    /// Resets the step to zero.
    fn reset_step(&mut self, evaluation: &Evaluation) {
        self.moved.fill(0.0);
        self.contacts.iter_mut().for_each(|gap| (gap.now, gap.change) = (gap.initial, 0.0));
        let places = self.compliance.places.iter_mut();
        places.for_each(|place| (place.load, place.unbalanced) = (place.initial_load, 0.0));
        let bends = self.compliance.work > 0.0;
        if bends || self.contacts.iter().any(|gap| gap.pressed.force != gap.initial_force) {
            self.trial.fill(0.0);
            self.evaluate(evaluation, 0.0, &Bounds { proximal: 0.0, reach: f64::INFINITY, fence: 0.0 });
        } else {
            self.left.copy_from_slice(&self.force);
        }
    }

    /// Residual and contact forces after the step `trial`, a fraction of the Newton step further.
    fn evaluate(&mut self, evaluation: &Evaluation, share: f64, bounds: &Bounds) {
        let Model { bare, left, contacts, compliance, trial, force, scale, .. } = self;
        evaluation.smooth.multiply(trial, bare);
        bare.iter_mut().zip(force.iter()).for_each(|(left, force)| *left = force - *left);
        let all = &evaluation.contacts;
        compliance.places.iter_mut().for_each(|place| place.unbalanced = -place.load);
        for (gap, contact) in contacts.iter_mut().zip(&all.list) {
            gap.pressed = contact.spring.at(-(gap.now + share * gap.change));
            if let Some(place) = contact.place {
                compliance.places[place].unbalanced += gap.pressed.force;
            }
            let push = gap.pressed.force - gap.initial_force;
            if push != 0.0 {
                let terms = all.index[contact.range.clone()].iter().zip(&all.push[contact.range.clone()]);
                terms.for_each(|(i, p)| bare[*i] += push * p);
            }
        }
        for (support, begin) in all.supports.iter().zip(&self.supports) {
            let now = support.force(shift(support, trial));
            let push = [now[0] - begin[0], now[1] - begin[1]];
            for (i, row) in support.index.iter().zip(&support.gradient) {
                bare[*i] -= push[0] * row[0] + push[1] * row[1];
            }
        }
        for (i, left) in left.iter_mut().enumerate() {
            *left = bare[i] - bounds.force(scale[i], trial[i]);
        }
    }

    /// Matrix of a Newton step from `moved` without the limits of the step, and its right-hand side in
    /// `newton`.
    fn assemble<S: System>(&mut self, system: &S, evaluation: &Evaluation) -> Option<()> {
        let Model { matrix, contacts, stiffness, compliance, newton, moved, block, .. } = self;
        let all = &evaluation.contacts;
        // Contacts of one bearing or ring are consecutive and depend on the same columns.
        let mut alike: &[usize] = &[];
        block.clear();
        matrix.copy_stiffness(&evaluation.smooth);
        compliance.places.iter_mut().for_each(|place| place.stiffness = 0.0);
        stiffness.clear();
        for (gap, contact) in contacts.iter().zip(&all.list) {
            stiffness.push(gap.pressed.stiffness);
            if !(gap.pressed.stiffness > 0.0) {
                continue;
            }
            if let Some(place) = contact.place {
                compliance.places[place].stiffness += gap.pressed.stiffness;
                continue;
            }
            let range = contact.range.clone();
            let index = &all.index[range.clone()];
            if index != alike {
                matrix.add_block(alike, block);
                alike = index;
                block.clear();
                block.resize(index.len() * index.len(), 0.0);
            }
            let gradient = &all.gradient[range.clone()];
            for (line, push) in block.chunks_exact_mut(index.len().max(1)).zip(&all.push[range]) {
                let force = gap.pressed.stiffness * push;
                line.iter_mut().zip(gradient).for_each(|(entry, g)| *entry += force * g);
            }
        }
        matrix.add_block(alike, block);
        for support in &all.supports {
            for (stiffness, direction) in support.stiffness(shift(support, moved)) {
                let along: Vec<f64> =
                    support.gradient.iter().map(|row| direction.x * row[0] + direction.y * row[1]).collect();
                matrix.add_outer(&support.index, &along, &along, stiffness);
            }
        }
        compliance.condense(system, all, stiffness, matrix, newton)
    }

    /// Semismooth Newton method with an exact line search for a zero of the slope along the step; beyond the
    /// trust region the penalty makes every slope positive. If the tangent is concave in some direction, as
    /// under preload, the matrix is made positive definite for that step only. `None` if no descent direction
    /// is found.
    fn minimise<S: System>(
        &mut self,
        system: &S,
        evaluation: &Evaluation,
        bounds: &Bounds,
        range: f64,
        unit_work: f64,
    ) -> Option<()> {
        self.reset_step(evaluation);
        for _ in 0..NEWTON_STEPS {
            let is_beyond = range < bounds.reach && !self.is_within(range);
            if is_beyond || self.unbalanced_work() <= EXACTNESS * unit_work {
                break;
            }
            let slope = |model: &Model, share: f64| {
                let places = model.compliance.places.iter();
                let elastic = places
                    .map(|at| (at.unbalanced - share * at.load_step) * at.displacement_step)
                    .sum::<f64>();
                dot(&model.left, &model.newton) + elastic
            };
            let first = ADDED.into_iter().find_map(|added| {
                self.newton_step(system, evaluation, bounds, added)?;
                Some(slope(self, 0.0)).filter(|first| *first > 0.0)
            })?;
            // Line search on the slope: the fraction is doubled until the slope changes sign, then found by the
            // secant method.
            let (mut low, mut high, mut share) = ([0.0, first], None, 1.0_f64);
            for _ in 0..f64::MANTISSA_DIGITS {
                let steps = self.moved.iter().zip(&self.newton);
                self.trial.iter_mut().zip(steps).for_each(|(trial, (d, newton))| *trial = d + share * newton);
                self.evaluate(evaluation, share, bounds);
                let along = slope(self, share);
                if along.abs() <= SLOPE_LEFT * first {
                    break;
                }
                if along > 0.0 {
                    low = [share, along];
                } else {
                    high = Some([share, along]);
                }
                share = high.map_or(2.0 * share, |[end, against]| {
                    let part = low[1] / (low[1] - against);
                    // If a slope is not finite the secant is undefined: the trial nearest to the lower end is
                    // used.
                    let part = if part > NEAR_END { part.min(1.0 - NEAR_END) } else { NEAR_END };
                    low[0] + part * (end - low[0])
                });
            }
            self.moved.copy_from_slice(&self.trial);
            self.contacts.iter_mut().for_each(|gap| gap.now += share * gap.change);
            for place in &mut self.compliance.places {
                place.load += share * place.load_step;
                place.unbalanced -= share * place.load_step;
            }
        }
        Some(())
    }

    fn is_within(&self, reach: f64) -> bool {
        self.moved.iter().zip(&self.scale).all(|(d, s)| d.abs() <= reach * s)
    }

    /// Largest work of the residual along one unit of scale, including that between contacts and elastic
    /// bodies.
    fn unbalanced_work(&self) -> f64 {
        let unit = self.scale.iter().copied().fold(f64::INFINITY, f64::min);
        let places = self.compliance.places.iter();
        let elastic = places.fold(0.0, |most: f64, place| most.max(place.unbalanced.abs())) * unit;
        work(&self.left, &self.scale).max(elastic)
    }

    /// One Newton step d in `newton`, with the change of the forces on elastic bodies and of every gap; `added`
    /// as in [`ADDED`].
    fn newton_step<S: System>(
        &mut self,
        system: &S,
        evaluation: &Evaluation,
        bounds: &Bounds,
        added: f64,
    ) -> Option<()> {
        self.newton.copy_from_slice(&self.left);
        self.assemble(system, evaluation)?;
        let Model { matrix, newton, scale, moved, contacts, compliance, .. } = self;
        let largest = |most: f64, (i, s): (usize, &f64)| most.max(matrix.stiffness(i, i) * s * s);
        let more = added * scale.iter().enumerate().fold(0.0, largest);
        for (i, (d, scale)) in moved.iter().zip(scale.iter()).enumerate() {
            matrix.add_stiffness(i, i, bounds.stiffness(*scale, *d) + more / (scale * scale));
        }
        let weights = Weights { mass: 0.0, damping: 0.0, stiffness: 1.0 };
        let is_solved = if evaluation.contacts.has_friction {
            matrix.solve(scale, weights, newton).is_ok()
        } else {
            matrix.solve_positive(newton)
        };
        if !is_solved {
            return None;
        }
        compliance.respond(newton);
        for (gap, contact) in contacts.iter_mut().zip(&evaluation.contacts.list) {
            let (index, range) = (&evaluation.contacts.index, contact.range.clone());
            let terms = index[range.clone()].iter().zip(&evaluation.contacts.gradient[range]);
            let by_bodies: f64 = terms.map(|(i, g)| g * newton[*i]).sum();
            gap.change =
                by_bodies + contact.place.map_or(0.0, |place| compliance.places[place].displacement_step);
        }
        Some(())
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Largest work of forces along one unit of scale.
fn work(force: &[f64], scale: &[f64]) -> f64 {
    force.iter().zip(scale).fold(0.0, |m: f64, (f, s)| m.max((f * s).abs()))
}
