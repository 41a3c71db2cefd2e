//! The machine about one place: gaps to first order, force laws exact, everything else by its tangent.

use super::compliance::Compliance;
use crate::contact::Pressed;
use crate::dynamics::system::{Look, RoundSupport};
use crate::dynamics::{DenseLinearisation, System, Weights};

/// Newton steps on one model. A model with n contacts that open or close needs fewer than n.
const NEWTON_STEPS: usize = 60;
/// How exactly the model is solved, as a share of the forces at its place: the next place changes them by more.
const EXACTNESS: f64 = 1e-3;
/// A line search ends when the slope along the step has fallen to this share; between 0.01 and 0.9 it makes no difference.
const SLOPE_LEFT: f64 = 0.5;
/// Least distance of a trial from either end of the bracket of a line search, as a share of the bracket.
const NEAR_END: f64 = 0.1;
/// The proximal term against the largest work of the forces along one unit of scale: it matters for bodies that hang
/// loose alone, and lets these go a hundred thousand units of scale under the load.
const PROXIMAL: f64 = 1e-5;
/// The least of it against the largest stiffness: the rounding of the factors.
const ROUNDING: f64 = 1e-13;
/// Multiples of the largest stiffness that are added to a Newton matrix that is not positive definite, one after the
/// other until it is (Nocedal and Wright 2006, algorithm 3.3): from rounding to what outweighs all.
const ADDED: [f64; 8] = [0.0, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 1.0, 100.0];
/// Stiffness of the fence against what takes up the largest force within the reach: steps go a tenth of it beyond.
const FENCE: f64 = 10.0;

/// Forces left after a step d from a place: R(d) = Q − K_s d + Σ P_i (F_i − F_i⁰) − (proximal term) d.
///
/// The gap of contact i is x_i = g_i + G_i d + b_i + Σ_j C_ij (h_j − F_j⁰) where elastic bodies give way under forces h
/// on them: C = G_e K_e⁻¹ G_eᵀ from their coordinates, whose stiffness K_e is constant, plus the compliance of a flank
/// between its contacts; b = G_e K_e⁻¹ Q_e takes up what is unbalanced on these coordinates. Where h = F the elastic
/// coordinates are in balance, so they are not searched for.
#[derive(Debug, Clone, Default)]
pub(super) struct Model {
    /// Of the coordinates searched for.
    scale: Vec<f64>,
    force: Vec<f64>,
    matrix: DenseLinearisation,
    /// Sum over the contacts that move the same columns.
    block: Vec<f64>,
    contacts: Vec<Gap>,
    stiffness: Vec<f64>,
    supports: Vec<[f64; 2]>,
    compliance: Compliance,
    /// R without the proximal term and the fence, and with them.
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
    /// g + b, and x.
    begin: f64,
    now: f64,
    /// Change of x along the present Newton step.
    change: f64,
    /// F⁰, and what presses now.
    begin_force: f64,
    pressed: Pressed,
}

/// Bounds of a step: a stiffness on every coordinate, and beyond the reach another.
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
    /// Whether it lies within the fence.
    pub is_inside: bool,
    /// Contacts that press there.
    pub pressed: usize,
    /// Work of the forces that the model leaves there along one unit of scale, as a share of that at the place.
    pub inexactness: f64,
    /// Largest force that the model leaves there, in N or N·m.
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
    /// Makes room for a system.
    pub fn fit<S: System>(&mut self, system: &S, look: &Look) {
        let searched = look.columns.searched();
        self.scale.clear();
        self.scale.extend(searched.iter().map(|i| system.scale()[*i]));
        self.matrix.fit(searched.len());
        let Model { force, bare, left, moved, newton, trial, .. } = self;
        for vector in [force, bare, left, moved, newton, trial] {
            vector.clear();
            vector.resize(searched.len(), 0.0);
        }
    }

    /// Fills `step`, over all coordinates, with the minimum of the model at an evaluated place, within the reach. Contacts
    /// are known within the sight only, so a search that leaves it ends there. `None` where no step goes along the
    /// forces.
    pub fn solve<S: System>(
        &mut self,
        system: &S,
        look: &Look,
        (reach, sight): (f64, f64),
        step: &mut [f64],
    ) -> Option<Solution> {
        self.take(system, look);
        let unit_work = work(&self.force, &self.scale).max(self.compliance.work);
        let along = self.scale.iter().enumerate().map(|(i, s)| look.smooth.stiffness(i, i) * s * s);
        let least = PROXIMAL * unit_work + ROUNDING * along.fold(0.0, f64::max);
        let bounds = Bounds { proximal: least, reach, fence: FENCE * unit_work / reach };
        self.minimise(system, look, &bounds, sight, unit_work)?;
        step.fill(0.0);
        look.columns.searched().iter().zip(&self.moved).for_each(|(i, d)| step[*i] = *d);
        self.compliance.spread(system, &look.contacts, step);
        let is_inside = self.is_within(reach.min(sight));
        let residual = self.bare.iter().fold(0.0, |most: f64, left| most.max(left.abs()));
        let gaps = self.contacts.iter().zip(&look.contacts.list);
        let closed = gaps.filter(|(gap, contact)| gap.now < 0.0 && contact.is_gap()).count();
        let supports = look.contacts.supports.iter();
        let pressed =
            closed + supports.filter(|support| support.presses(shift(support, &self.moved))).count();
        let inexactness = self.unbalanced_work() / unit_work;
        Some(Solution { is_inside, pressed, inexactness, residual })
    }

    fn take<S: System>(&mut self, system: &S, look: &Look) {
        let of_column = look.columns.searched().iter().map(|i| look.force[*i]);
        self.force.iter_mut().zip(of_column).for_each(|(force, of)| *force = of);
        self.compliance.take(system, look);
        self.supports.clear();
        self.supports.extend(look.contacts.supports.iter().map(|support| support.force(support.shift)));
        self.contacts.clear();
        for contact in &look.contacts.list {
            let given_way = contact.place.map_or(0.0, |place| self.compliance.places[place].given_way);
            let begin = contact.gap + given_way;
            let pressed = contact.pressed;
            if let Some(place) = contact.place {
                self.compliance.places[place].begin += pressed.force;
            }
            let begin_force = pressed.force;
            self.contacts.push(Gap { begin, now: begin, change: 0.0, begin_force, pressed });
        }
    }

    /// To the place itself.
    fn go_back(&mut self, look: &Look) {
        self.moved.fill(0.0);
        self.contacts.iter_mut().for_each(|gap| (gap.now, gap.change) = (gap.begin, 0.0));
        let places = self.compliance.places.iter_mut();
        places.for_each(|place| (place.load, place.unbalanced) = (place.begin, 0.0));
        let bends = self.compliance.work > 0.0;
        if bends || self.contacts.iter().any(|gap| gap.pressed.force != gap.begin_force) {
            self.trial.fill(0.0);
            self.evaluate(look, 0.0, &Bounds { proximal: 0.0, reach: f64::INFINITY, fence: 0.0 });
        } else {
            self.left.copy_from_slice(&self.force);
        }
    }

    /// Forces left after the step `trial`, a share of the Newton step away, and how the contacts press there.
    fn evaluate(&mut self, look: &Look, share: f64, bounds: &Bounds) {
        let Model { bare, left, contacts, compliance, trial, force, scale, .. } = self;
        look.smooth.multiply(trial, bare);
        bare.iter_mut().zip(force.iter()).for_each(|(left, force)| *left = force - *left);
        let all = &look.contacts;
        compliance.places.iter_mut().for_each(|place| place.unbalanced = -place.load);
        for (gap, contact) in contacts.iter_mut().zip(&all.list) {
            gap.pressed = contact.spring.at(-(gap.now + share * gap.change));
            if let Some(place) = contact.place {
                compliance.places[place].unbalanced += gap.pressed.force;
            }
            let push = gap.pressed.force - gap.begin_force;
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

    /// Matrix of a Newton step from `moved`, without what holds steps back, and in `newton` its right-hand side.
    fn assemble<S: System>(&mut self, system: &S, look: &Look) -> Option<()> {
        let Model { matrix, contacts, stiffness, compliance, newton, moved, block, .. } = self;
        let all = &look.contacts;
        // Contacts of one bearing or ring follow one another and move the same columns.
        let mut alike: &[usize] = &[];
        block.clear();
        matrix.copy_stiffness(&look.smooth);
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
            for (stiffness, way) in support.stiffness(shift(support, moved)) {
                let along: Vec<f64> =
                    support.gradient.iter().map(|row| way.x * row[0] + way.y * row[1]).collect();
                matrix.add_outer(&support.index, &along, &along, stiffness);
            }
        }
        compliance.condense(system, all, stiffness, matrix, newton)
    }

    /// Semismooth Newton method with an exact line search for a zero of the slope along the step: beyond the reach the fence
    /// turns every slope. Where the tangent is concave along some way, as preload makes it, the matrix is made positive
    /// definite for that step alone. `None` where no step goes along the forces.
    fn minimise<S: System>(
        &mut self,
        system: &S,
        look: &Look,
        bounds: &Bounds,
        sight: f64,
        unit_work: f64,
    ) -> Option<()> {
        self.go_back(look);
        for _ in 0..NEWTON_STEPS {
            let is_beyond = sight < bounds.reach && !self.is_within(sight);
            if is_beyond || self.unbalanced_work() <= EXACTNESS * unit_work {
                break;
            }
            let slope = |model: &Model, share: f64| {
                let places = model.compliance.places.iter();
                let elastic =
                    places.map(|at| (at.unbalanced - share * at.more_load) * at.change).sum::<f64>();
                dot(&model.left, &model.newton) + elastic
            };
            let first = ADDED.into_iter().find_map(|added| {
                self.newton_step(system, look, bounds, added)?;
                Some(slope(self, 0.0)).filter(|first| *first > 0.0)
            })?;
            // Line search on the slope: the share is doubled until the slope changes sign, then found by the secant.
            let (mut low, mut high, mut share) = ([0.0, first], None, 1.0_f64);
            for _ in 0..f64::MANTISSA_DIGITS {
                let ways = self.moved.iter().zip(&self.newton);
                self.trial.iter_mut().zip(ways).for_each(|(trial, (d, way))| *trial = d + share * way);
                self.evaluate(look, share, bounds);
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
                    // A slope that is not finite gives no secant: the trial nearest to the lower end is taken.
                    let part = if part > NEAR_END { part.min(1.0 - NEAR_END) } else { NEAR_END };
                    low[0] + part * (end - low[0])
                });
            }
            self.moved.copy_from_slice(&self.trial);
            self.contacts.iter_mut().for_each(|gap| gap.now += share * gap.change);
            for place in &mut self.compliance.places {
                place.load += share * place.more_load;
                place.unbalanced -= share * place.more_load;
            }
        }
        Some(())
    }

    fn is_within(&self, reach: f64) -> bool {
        self.moved.iter().zip(&self.scale).all(|(d, s)| d.abs() <= reach * s)
    }

    /// Largest work of the forces left along one unit of scale, those between contacts and elastic bodies included.
    fn unbalanced_work(&self) -> f64 {
        let unit = self.scale.iter().copied().fold(f64::INFINITY, f64::min);
        let places = self.compliance.places.iter();
        let elastic = places.fold(0.0, |most: f64, place| most.max(place.unbalanced.abs())) * unit;
        work(&self.left, &self.scale).max(elastic)
    }

    /// One Newton step d in `newton`, with the change of the forces on elastic bodies and of every gap; `added` as in
    /// [`ADDED`].
    fn newton_step<S: System>(&mut self, system: &S, look: &Look, bounds: &Bounds, added: f64) -> Option<()> {
        self.newton.copy_from_slice(&self.left);
        self.assemble(system, look)?;
        let Model { matrix, newton, scale, moved, contacts, compliance, .. } = self;
        let largest = |most: f64, (i, s): (usize, &f64)| most.max(matrix.stiffness(i, i) * s * s);
        let more = added * scale.iter().enumerate().fold(0.0, largest);
        for (i, (d, scale)) in moved.iter().zip(scale.iter()).enumerate() {
            matrix.add_stiffness(i, i, bounds.stiffness(*scale, *d) + more / (scale * scale));
        }
        let weights = Weights { mass: 0.0, damping: 0.0, stiffness: 1.0 };
        let is_solved = if look.contacts.has_friction {
            matrix.solve(scale, weights, newton).is_ok()
        } else {
            matrix.solve_positive(newton)
        };
        if !is_solved {
            return None;
        }
        compliance.respond(newton);
        for (gap, contact) in contacts.iter_mut().zip(&look.contacts.list) {
            let (index, range) = (&look.contacts.index, contact.range.clone());
            let terms = index[range.clone()].iter().zip(&look.contacts.gradient[range]);
            let by_bodies: f64 = terms.map(|(i, g)| g * newton[*i]).sum();
            gap.change = by_bodies + contact.place.map_or(0.0, |place| compliance.places[place].change);
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
