//! The machine about one place: gaps to first order, force laws exact, everything else by its tangent; what gives way
//! linearly is eliminated.

use std::ops::Range;

use crate::contact::{ContactSpring, Pressed};
use crate::dynamics::system::{ElasticCoordinates, FlankPlace, Look, RoundSupport};
use crate::dynamics::{DenseLinearisation, System, Weights};

/// Newton steps on one model. A model with n contacts that open or close needs fewer than n.
const NEWTON_STEPS: usize = 60;
/// How exactly the model is solved, as a share of the forces at its place: the next place changes them by more.
const EXACTNESS: f64 = 1e-3;
/// A line search ends when the slope along the step has fallen to this share; between 0.01 and 0.9 it makes no difference.
const SLOPE_LEFT: f64 = 0.5;
/// The proximal term against the largest work of the forces along one unit of scale: it matters for bodies that hang
/// loose alone, and lets these go a hundred thousand units of scale under the load.
const PROXIMAL: f64 = 1e-5;
/// The least of it against the largest stiffness: the rounding of the factors.
const ROUNDING: f64 = 1e-13;
/// Growth of the proximal term where the model is not convex, and how often.
const GROWTH: (f64, usize) = (4.0, 30);
/// Stiffness of the fence against what takes up the largest force within the reach: steps go a tenth of it beyond.
const FENCE: f64 = 10.0;

/// Forces left after a step d from a place: R(d) = Q − K_s d + Σ P_i (F_i − F_i⁰) − (proximal term) d.
///
/// The gap of contact i is x_i = g_i + G_i d + b_i + Σ_j C_ij (h_j − F_j⁰) where elastic bodies give way under forces h:
/// C = G_e K_e⁻¹ G_eᵀ from their coordinates, whose stiffness K_e is constant, plus the compliance of a flank between
/// its contacts; b = G_e K_e⁻¹ Q_e takes up what is unbalanced on these coordinates. Where h = F the elastic
/// coordinates are in balance, so they are not searched for.
pub(super) struct Model {
    /// Of every coordinate its number among those that are searched for.
    columns: Vec<Option<usize>>,
    /// These coordinates, and their scale.
    searched: Vec<usize>,
    scale: Vec<f64>,
    /// K_s.
    smooth: DenseLinearisation,
    matrix: DenseLinearisation,
    /// Q on the coordinates searched for; displacement K_e⁻¹ Q_e of the elastic ones, and the work of Q_e there.
    force: Vec<f64>,
    given_way: Vec<f64>,
    elastic_work: f64,
    index: Vec<usize>,
    gradient: Vec<f64>,
    push: Vec<f64>,
    contacts: Vec<Linearised>,
    /// Whether forces push along other ways than the gaps': then no energy tells whether the model is convex.
    has_friction: bool,
    supports: Vec<Support>,
    /// Parts of the gradients by elastic coordinates.
    elastic_index: Vec<usize>,
    elastic_gradient: Vec<f64>,
    /// Contacts on elastic bodies, C row by row over them, and h.
    coupled: Vec<usize>,
    compliance: Vec<f64>,
    load: Vec<f64>,
    /// R without the proximal term and the fence, and with them.
    bare: Vec<f64>,
    left: Vec<f64>,
}

/// One contact with its part of the gradients.
struct Linearised {
    range: Range<usize>,
    elastic: Range<usize>,
    place: Option<FlankPlace>,
    /// g + b, and x.
    begin_gap: f64,
    gap: f64,
    spring: ContactSpring,
    /// At the place, and at the last step.
    begin: Pressed,
    now: Pressed,
    /// Change of x along the present Newton step.
    change: f64,
}

/// A round support with its part of the gradients.
struct Support {
    index: Vec<usize>,
    gradient: Vec<[f64; 2]>,
    at: RoundSupport,
    begin: [f64; 2],
}

impl Support {
    /// Displacement in m after a step.
    fn shift(&self, step: &[f64]) -> [f64; 2] {
        let mut shift = self.at.shift;
        for (i, row) in self.index.iter().zip(&self.gradient) {
            shift[0] += step[*i] * row[0];
            shift[1] += step[*i] * row[1];
        }
        shift
    }
}

/// What holds steps back: a stiffness on every coordinate, and beyond the reach another.
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
    /// Whether it is that of the model without the fence and with the least proximal term.
    pub is_whole: bool,
    /// Largest force that the model leaves there, in N or N·m.
    pub residual: f64,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Model {
    pub fn new<S: System>(system: &S, held: Option<usize>) -> Model {
        let is_elastic = |i: usize| system.elastic().is_some_and(|elastic| elastic.has(i));
        let searched: Vec<usize> =
            (0..system.size()).filter(|i| Some(*i) != held && !is_elastic(*i)).collect();
        let mut columns = vec![None; system.size()];
        searched.iter().enumerate().for_each(|(column, i)| columns[*i] = Some(column));
        let n = searched.len();
        Model {
            columns,
            scale: searched.iter().map(|i| system.scale()[*i]).collect(),
            searched,
            smooth: DenseLinearisation::at_rest(n),
            matrix: DenseLinearisation::at_rest(n),
            force: vec![0.0; n],
            given_way: Vec::new(),
            elastic_work: 0.0,
            index: Vec::new(),
            gradient: Vec::new(),
            push: Vec::new(),
            contacts: Vec::new(),
            has_friction: false,
            supports: Vec::new(),
            elastic_index: Vec::new(),
            elastic_gradient: Vec::new(),
            coupled: Vec::new(),
            compliance: Vec::new(),
            load: Vec::new(),
            bare: vec![0.0; n],
            left: vec![0.0; n],
        }
    }

    /// Moves to a place that was looked at.
    pub fn take<S: System>(&mut self, system: &S, look: &Look) {
        for (row, i) in self.searched.iter().enumerate() {
            self.force[row] = look.force[*i];
            let from = look.smooth.row(*i);
            let into = self.smooth.stiffness_row(row);
            into.iter_mut().zip(&self.searched).for_each(|(entry, j)| *entry = from[*j]);
        }
        self.index.clear();
        self.gradient.clear();
        self.push.clear();
        self.elastic_index.clear();
        self.elastic_gradient.clear();
        self.contacts.clear();
        self.has_friction = false;
        self.supports.clear();
        self.coupled.clear();
        for support in &look.contacts.supports {
            let rows = support.gradient.iter();
            let free = support
                .index
                .iter()
                .zip(rows)
                .filter_map(|(i, row)| Some((*self.columns.get(*i)?.as_ref()?, *row)));
            let (index, gradient) = free.unzip();
            self.supports.push(Support {
                index,
                gradient,
                at: support.clone(),
                begin: support.force(support.shift),
            });
        }
        let elastic = system.elastic();
        for contact in look.contacts.iter() {
            let (start, elastic_start) = (self.index.len(), self.elastic_index.len());
            for ((i, g), p) in contact.index.iter().zip(contact.gradient).zip(contact.push) {
                match self.columns.get(*i) {
                    Some(Some(column)) => {
                        self.index.push(*column);
                        self.gradient.push(*g);
                        self.push.push(*p);
                    }
                    _ if elastic.is_some_and(|elastic| elastic.has(*i)) => {
                        self.elastic_index.push(*i);
                        self.elastic_gradient.push(*g);
                    }
                    // Held or prescribed.
                    _ => {}
                }
            }
            let begin = contact.spring.at(-contact.gap);
            self.has_friction |= contact.push != contact.gradient;
            let elastic = elastic_start..self.elastic_index.len();
            if !elastic.is_empty() || contact.place.is_some() {
                self.coupled.push(self.contacts.len());
            }
            self.contacts.push(Linearised {
                range: start..self.index.len(),
                elastic,
                place: contact.place,
                begin_gap: contact.gap,
                gap: contact.gap,
                spring: contact.spring,
                begin,
                now: begin,
                change: 0.0,
            });
        }
        self.elastic_work = 0.0;
        if let Some(elastic) = elastic {
            self.take_elastic(system, elastic, look);
        }
    }

    fn take_elastic<S: System>(&mut self, system: &S, elastic: &ElasticCoordinates, look: &Look) {
        let Model { elastic_index, elastic_gradient, contacts, coupled, compliance, given_way, .. } = self;
        let along = |contact: &Linearised, way: &[f64]| -> f64 {
            let terms =
                elastic_index[contact.elastic.clone()].iter().zip(&elastic_gradient[contact.elastic.clone()]);
            terms.map(|(i, g)| g * way[*i]).sum()
        };
        given_way.clear();
        given_way.resize(look.force.len(), 0.0);
        for (i, force) in look.force.iter().enumerate() {
            if elastic.has(i) {
                self.elastic_work = self.elastic_work.max((force * system.scale()[i]).abs());
                elastic.yield_to(i, *force, given_way);
            }
        }
        for number in coupled.iter() {
            contacts[*number].begin_gap += along(&contacts[*number], given_way);
        }
        let count = coupled.len();
        compliance.clear();
        compliance.resize(count * count, 0.0);
        let mut way = vec![0.0; look.force.len()];
        for (a, number) in coupled.iter().enumerate() {
            let one = &contacts[*number];
            way.fill(0.0);
            for at in one.elastic.clone() {
                elastic.yield_to(elastic_index[at], elastic_gradient[at], &mut way);
            }
            for (b, number) in coupled[..=a].iter().enumerate() {
                let other = &contacts[*number];
                let flank = match (&one.place, &other.place) {
                    (Some(one), Some(other)) => system.flank_compliance(one, other),
                    _ => 0.0,
                };
                let entry = along(other, &way) + flank;
                (compliance[a * count + b], compliance[b * count + a]) = (entry, entry);
            }
        }
    }

    fn terms<'a>(
        &'a self,
        contact: &Linearised,
        vector: &'a [f64],
    ) -> impl Iterator<Item = (usize, f64)> + 'a {
        let range = contact.range.clone();
        self.index[range.clone()].iter().copied().zip(vector[range].iter().copied())
    }

    /// Forces left after a step from the place, and how the contacts press there.
    fn evaluate(&mut self, step: &[f64], share: f64, bounds: &Bounds) {
        let mut bare = std::mem::take(&mut self.bare);
        self.smooth.multiply(step, &mut bare);
        bare.iter_mut().zip(&self.force).for_each(|(left, force)| *left = force - *left);
        let mut contacts = std::mem::take(&mut self.contacts);
        for contact in &mut contacts {
            contact.now = contact.spring.at(-(contact.gap + share * contact.change));
            let push = contact.now.force - contact.begin.force;
            if push != 0.0 {
                self.terms(contact, &self.push).for_each(|(i, p)| bare[i] += push * p);
            }
        }
        self.contacts = contacts;
        for support in &self.supports {
            let now = support.at.force(support.shift(step));
            let push = [now[0] - support.begin[0], now[1] - support.begin[1]];
            for (i, row) in support.index.iter().zip(&support.gradient) {
                bare[*i] -= push[0] * row[0] + push[1] * row[1];
            }
        }
        for (i, left) in self.left.iter_mut().enumerate() {
            *left = bare[i] - bounds.force(self.scale[i], step[i]);
        }
        self.bare = bare;
    }

    /// Fills `step`, over all coordinates, with the minimum of the model within the reach. `None` where no proximal term
    /// makes the model convex.
    pub fn solve<S: System>(&mut self, system: &S, reach: f64, step: &mut [f64]) -> Option<Solution> {
        let unit_work = work(&self.force, &self.scale).max(self.elastic_work);
        let stiffest = self
            .scale
            .iter()
            .enumerate()
            .fold(0.0, |m: f64, (i, s)| m.max(self.smooth.stiffness(i, i) * s * s));
        let least = PROXIMAL * unit_work + ROUNDING * stiffest;
        let mut bounds = Bounds { proximal: least, reach, fence: FENCE * unit_work / reach };
        self.convexify(least);
        for _ in 0..GROWTH.1 {
            let mut moved = vec![0.0; self.searched.len()];
            if self.minimise(&mut moved, &bounds, unit_work).is_some() {
                let inside = moved.iter().zip(&self.scale).all(|(d, s)| d.abs() <= reach * s);
                self.spread(system, &moved, step);
                let residual = self.bare.iter().fold(0.0, |most: f64, left| most.max(left.abs()));
                return Some(Solution { is_whole: inside && bounds.proximal == least, residual });
            }
            bounds.proximal *= GROWTH.0;
        }
        None
    }

    /// Where the tangent at the place is concave along some ways, as preload and friction make it, it is made as convex
    /// along these (eigenvectors in units of scale) as it was concave; along all others it stays as it is.
    fn convexify(&mut self, least: f64) {
        for contact in &mut self.contacts {
            (contact.gap, contact.change, contact.now) = (contact.begin_gap, 0.0, contact.begin);
        }
        self.load = self.coupled.iter().map(|number| self.contacts[*number].begin.force).collect();
        let n = self.searched.len();
        let (mut tangent, coupling) =
            (self.tangent(&vec![0.0; n]), Coupling::new(self, &vec![0.0; self.coupled.len()]));
        coupling.condense(self, &mut tangent, &mut vec![0.0; n]);
        let scaled = nalgebra::DMatrix::from_fn(n, n, |i, j| {
            0.5 * (tangent.stiffness(i, j) + tangent.stiffness(j, i)) * self.scale[i] * self.scale[j]
        });
        for (i, scale) in self.scale.iter().enumerate() {
            tangent.add_stiffness(i, i, least / (scale * scale));
        }
        let is_convex = self.has_friction || tangent.is_positive();
        self.matrix = tangent;
        if is_convex {
            return;
        }
        let eigen = nalgebra::SymmetricEigen::new(scaled);
        let all: Vec<usize> = (0..n).collect();
        for (way, value) in eigen.eigenvectors.column_iter().zip(eigen.eigenvalues.iter()) {
            if *value < 0.0 {
                let along: Vec<f64> = way.iter().zip(&self.scale).map(|(v, scale)| v / scale).collect();
                self.smooth.add_outer(&all, &along, &along, -2.0 * value);
            }
        }
    }

    /// Matrix of a Newton step after a step from the place, without what holds steps back.
    fn tangent(&mut self, step: &[f64]) -> DenseLinearisation {
        let mut matrix = std::mem::replace(&mut self.matrix, DenseLinearisation::at_rest(0));
        matrix.copy_stiffness(&self.smooth);
        for contact in self.contacts.iter().filter(|contact| contact.now.stiffness > 0.0) {
            if contact.elastic.is_empty() && contact.place.is_none() {
                let range = contact.range.clone();
                let (push, gradient) = (&self.push[range.clone()], &self.gradient[range.clone()]);
                matrix.add_outer(&self.index[range], push, gradient, contact.now.stiffness);
            }
        }
        for support in &self.supports {
            for (stiffness, way) in support.at.stiffness(support.shift(step)) {
                let along: Vec<f64> =
                    support.gradient.iter().map(|row| way.x * row[0] + way.y * row[1]).collect();
                matrix.add_outer(&support.index, &along, &along, stiffness);
            }
        }
        matrix
    }

    /// Coordinates searched for and elastic ones in one step.
    fn spread<S: System>(&self, system: &S, moved: &[f64], step: &mut [f64]) {
        step.fill(0.0);
        self.searched.iter().zip(moved).for_each(|(i, d)| step[*i] = *d);
        let Some(elastic) = system.elastic() else { return };
        step.iter_mut().zip(&self.given_way).for_each(|(step, way)| *step += way);
        let mut force = vec![0.0; step.len()];
        for (number, load) in self.coupled.iter().zip(&self.load) {
            let contact = &self.contacts[*number];
            let more = load - contact.begin.force;
            for at in contact.elastic.clone() {
                force[self.elastic_index[at]] += more * self.elastic_gradient[at];
            }
        }
        for (i, force) in force.iter().enumerate().filter(|(_, force)| **force != 0.0) {
            elastic.yield_to(i, *force, step);
        }
    }

    /// Semismooth Newton method with an exact line search: the slope along a step falls steadily where the model is
    /// convex, so that its zero lies in a bracket. `None` where it is not: its matrix is not positive definite.
    fn minimise(&mut self, step: &mut [f64], bounds: &Bounds, unit_work: f64) -> Option<()> {
        for contact in &mut self.contacts {
            (contact.gap, contact.change) = (contact.begin_gap, 0.0);
        }
        self.load = self.coupled.iter().map(|number| self.contacts[*number].begin.force).collect();
        self.evaluate(step, 0.0, bounds);
        let unit = self.scale.iter().copied().fold(f64::INFINITY, f64::min);
        let (mut newton, mut trial) = (step.to_vec(), step.to_vec());
        for _ in 0..NEWTON_STEPS {
            let unbalanced = self.unbalanced();
            let elastic = unbalanced.iter().fold(0.0, |most: f64, f| most.max(f.abs())) * unit;
            if work(&self.left, &self.scale).max(elastic) <= EXACTNESS * unit_work {
                break;
            }
            let response = self.newton_step(step, &unbalanced, bounds, &mut newton)?;
            let elastic_slope = self.elastic_slope(&response);
            let slope = |model: &Model, share: f64| {
                let of_elastic = model.coupled.iter().zip(&elastic_slope).zip(&model.load).zip(&response);
                dot(&model.left, &newton)
                    + of_elastic
                        .map(|(((number, way), load), more)| {
                            (model.contacts[*number].now.force - load - share * more) * way
                        })
                        .sum::<f64>()
            };
            let first = slope(self, 0.0);
            if !(first > 0.0) {
                return None;
            }
            let (mut low, mut high, mut share) = (0.0, f64::INFINITY, 1.0_f64);
            // Doubled or halved until rounding.
            for _ in 0..f64::MANTISSA_DIGITS {
                trial.iter_mut().zip(step.iter().zip(&newton)).for_each(|(t, (d, x))| *t = d + share * x);
                self.evaluate(&trial, share, bounds);
                let along = slope(self, share);
                if along.abs() <= SLOPE_LEFT * first {
                    break;
                }
                *(if along > 0.0 { &mut low } else { &mut high }) = share;
                share = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * share };
            }
            step.copy_from_slice(&trial);
            self.contacts.iter_mut().for_each(|contact| contact.gap += share * contact.change);
            self.load.iter_mut().zip(&response).for_each(|(load, more)| *load += share * more);
        }
        Some(())
    }

    /// F − h of the coupled contacts.
    fn unbalanced(&self) -> Vec<f64> {
        let both = self.coupled.iter().zip(&self.load);
        both.map(|(number, load)| self.contacts[*number].now.force - load).collect()
    }

    /// C Δh.
    fn elastic_slope(&self, response: &[f64]) -> Vec<f64> {
        let rows = self.compliance.chunks_exact(response.len().max(1));
        rows.map(|row| dot(row, response)).collect()
    }

    /// One Newton step d in `newton`, and Δh, which it returns; it sets the change of every gap.
    ///
    /// With F + ΔF = h + Δh and ΔF = −k (G d + C Δh): on the pressed contacts (1/k + C) Δh = (F − h)/k − G d − C Δh_o,
    /// on open ones Δh_o = F − h. Put into R(d) = 0 this leaves (K_s + Σ_uncoupled k P Gᵀ + Σ_coupled Pᵀ (1/k + C)⁻¹ G) d.
    fn newton_step(
        &mut self,
        step: &[f64],
        unbalanced: &[f64],
        bounds: &Bounds,
        newton: &mut [f64],
    ) -> Option<Vec<f64>> {
        newton.copy_from_slice(&self.left);
        let mut matrix = self.tangent(step);
        let coupling = Coupling::new(self, unbalanced);
        coupling.condense(self, &mut matrix, newton);
        for (i, (d, scale)) in step.iter().zip(&self.scale).enumerate() {
            matrix.add_stiffness(i, i, bounds.stiffness(*scale, *d));
        }
        let weights = Weights { mass: 0.0, damping: 0.0, stiffness: 1.0 };
        let solved =
            (self.has_friction || matrix.is_positive()) && matrix.solve(&self.scale, weights, newton).is_ok();
        self.matrix = matrix;
        if !solved {
            return None;
        }
        let response = coupling.response(self, newton);
        let by_others = self.elastic_slope(&response);
        let mut contacts = std::mem::take(&mut self.contacts);
        for contact in &mut contacts {
            contact.change = self.terms(contact, &self.gradient).map(|(i, g)| g * newton[i]).sum();
        }
        self.coupled.iter().zip(&by_others).for_each(|(number, way)| contacts[*number].change += way);
        self.contacts = contacts;
        Some(response)
    }
}

/// The contacts on elastic bodies that press at one state of the model, with the factor of 1/k + C over them.
struct Coupling {
    /// Their numbers among the coupled ones, and all others' Δh.
    pressed: Vec<usize>,
    response: Vec<f64>,
    /// Upper triangle U with UᵀU = 1/k + C, row by row.
    factor: Vec<f64>,
    /// U⁻ᵀ r for the right-hand side r without d.
    offset: Vec<f64>,
    /// U⁻ᵀ G, row by row over the coordinates searched for.
    gradients: Vec<f64>,
}

impl Coupling {
    fn new(model: &Model, unbalanced: &[f64]) -> Coupling {
        let count = model.coupled.len();
        let stiffness = |a: usize| model.contacts[model.coupled[a]].now.stiffness;
        let pressed: Vec<usize> = (0..count).filter(|a| stiffness(*a) > 0.0).collect();
        let mut response = unbalanced.to_vec();
        pressed.iter().for_each(|a| response[*a] = 0.0);
        let (size, width) = (pressed.len(), model.searched.len());
        let mut offset: Vec<f64> = pressed
            .iter()
            .map(|a| unbalanced[*a] / stiffness(*a) - dot(&model.compliance[a * count..][..count], &response))
            .collect();
        let mut factor = vec![0.0; size * size];
        let mut gradients = vec![0.0; size * width];
        for (row, a) in pressed.iter().enumerate() {
            let from = &model.compliance[a * count..][..count];
            pressed.iter().enumerate().for_each(|(column, b)| factor[row * size + column] = from[*b]);
            factor[row * size + row] += 1.0 / stiffness(*a);
            let contact = &model.contacts[model.coupled[*a]];
            model.terms(contact, &model.gradient).for_each(|(i, g)| gradients[row * width + i] += g);
        }
        for row in 0..size {
            let (done, rest) = factor.split_at_mut((row + 1) * size);
            let own = &mut done[row * size + row..];
            let scale = 1.0 / own[0].max(f64::MIN_POSITIVE).sqrt();
            own.iter_mut().for_each(|entry| *entry *= scale);
            for (below, other) in rest.chunks_exact_mut(size).zip(row + 1..) {
                take_off(&mut below[other..], own[other - row], &own[other - row..]);
            }
            // The same elimination on both right-hand sides.
            let (done, rest) = gradients.split_at_mut((row + 1) * width);
            let own_gradient = &mut done[row * width..];
            own_gradient.iter_mut().for_each(|entry| *entry *= scale);
            offset[row] *= scale;
            for (below, other) in rest.chunks_exact_mut(width).zip(row + 1..) {
                take_off(below, own[other - row], own_gradient);
                offset[other] -= own[other - row] * offset[row];
            }
        }
        Coupling { pressed, response, factor, offset, gradients }
    }

    /// U⁻¹ x, in place.
    fn back(&self, x: &mut [f64]) {
        let size = self.pressed.len();
        for row in (0..size).rev() {
            let own = &self.factor[row * size + row..][..size - row];
            x[row] = (x[row] - dot(&own[1..], &x[row + 1..])) / own[0];
        }
    }

    /// Adds Gᵀ (1/k + C)⁻¹ G to the matrix and Δh without d to the forces. Friction pushes along other directions than
    /// the gradients: what it adds goes by rows.
    fn condense(&self, model: &Model, matrix: &mut DenseLinearisation, force: &mut [f64]) {
        let width = model.searched.len();
        if self.response.is_empty() {
            return;
        }
        for row in self.gradients.chunks_exact(width) {
            for (i, a) in row.iter().enumerate().filter(|(_, a)| **a != 0.0) {
                let line = matrix.stiffness_row(i);
                line.iter_mut().zip(row).for_each(|(entry, b)| *entry += a * b);
            }
        }
        let mut whole = self.offset.clone();
        self.back(&mut whole);
        let mut response = self.response.clone();
        self.pressed.iter().zip(&whole).for_each(|(a, more)| response[*a] = *more);
        // R holds P (F − F⁰) already; F + ΔF = h + Δh.
        for ((number, more), load) in model.coupled.iter().zip(&response).zip(&model.load) {
            let contact = &model.contacts[*number];
            let more = load + more - contact.now.force;
            model.terms(contact, &model.push).for_each(|(i, p)| force[i] += more * p);
        }
        self.add_friction(model, matrix);
    }

    /// Rows (P − G) of (1/k + C)⁻¹ G.
    fn add_friction(&self, model: &Model, matrix: &mut DenseLinearisation) {
        let (size, width) = (self.pressed.len(), model.searched.len());
        let differs = |contact: &Linearised| {
            let range = contact.range.clone();
            model.push[range.clone()] != model.gradient[range]
        };
        if !self.pressed.iter().any(|a| differs(&model.contacts[model.coupled[*a]])) {
            return;
        }
        let mut column = vec![0.0; size];
        for j in 0..width {
            (0..size).for_each(|row| column[row] = self.gradients[row * width + j]);
            self.back(&mut column);
            for (a, stiffness) in self.pressed.iter().zip(&column) {
                let contact = &model.contacts[model.coupled[*a]];
                let both = model.terms(contact, &model.push).zip(model.terms(contact, &model.gradient));
                for ((i, p), (_, g)) in both {
                    matrix.add_stiffness(i, j, (p - g) * stiffness);
                }
            }
        }
    }

    /// Δh for a step d.
    fn response(&self, model: &Model, d: &[f64]) -> Vec<f64> {
        let width = model.searched.len();
        let rows = self.gradients.chunks_exact(width.max(1));
        let mut pressed: Vec<f64> =
            self.offset.iter().zip(rows).map(|(offset, row)| offset - dot(row, d)).collect();
        self.back(&mut pressed);
        let mut response = self.response.clone();
        self.pressed.iter().zip(&pressed).for_each(|(a, more)| response[*a] = *more);
        response
    }
}

/// row − factor · other.
#[inline]
fn take_off(row: &mut [f64], factor: f64, other: &[f64]) {
    row.iter_mut().zip(other).for_each(|(entry, other)| *entry -= factor * other);
}

/// Largest work of forces along one unit of scale.
fn work(force: &[f64], scale: &[f64]) -> f64 {
    force.iter().zip(scale).fold(0.0, |m: f64, (f, s)| m.max((f * s).abs()))
}
