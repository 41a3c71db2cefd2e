use std::ops::Range;

use faer::linalg::solvers::{PartialPivLu, Solve};
use serde::{Deserialize, Serialize};

use crate::contact::{ContactSpring, Pressed};
use crate::fem::Stencil;
use crate::geometry::Vec2;
use crate::kernels::cleared;

/// A mechanical system in second-order form, M q̈ = Q(q, q̇, t) with a constant diagonal mass matrix M.
///
/// All force laws of a model live behind this trait; the time [`Integrator`](super::Integrator) and the
/// static solver ([`solve_equilibrium`](super::statics::solve_equilibrium), q̇ = 0) use the very same ones.
/// Coordinates may mix metres and radians.
pub trait System {
    /// A linearisation of the right size, zero.
    fn linearisation(&self) -> DenseLinearisation;

    /// One for a search at rest, which asks for no damping: systems that can leave it out do.
    fn linearisation_at_rest(&self) -> DenseLinearisation {
        self.linearisation()
    }

    /// Diagonal of M in kg or kg·m², one entry per coordinate.
    fn mass(&self) -> &[f64];

    /// Change of each coordinate (m or rad) that counts as one unit of error. Tolerances are multiples of it.
    fn scale(&self) -> &[f64];

    /// Generalised forces Q (N or N·m) at time t (s), positions q and velocities v, with their linearisation
    /// and powers.
    fn evaluate(
        &self,
        time: f64,
        position: &[f64],
        velocity: &[f64],
        force: &mut [f64],
        linearisation: &mut DenseLinearisation,
    ) -> Balance;

    /// The forces alone, for a search that knows the tangent well enough; the balance is that of
    /// [`System::evaluate`].
    fn evaluate_forces(&self, time: f64, position: &[f64], velocity: &[f64], force: &mut [f64]) -> Balance {
        self.evaluate(time, position, velocity, force, &mut self.linearisation_at_rest())
    }

    /// Forces, tangent and single contacts at one place at rest: what the static solver asks for. By default a system
    /// without contacts.
    fn look(&self, time: f64, position: &[f64], _reach: f64, look: &mut Look) {
        look.contacts.clear();
        let (rest, mut tangent) = (vec![0.0; position.len()], self.linearisation_at_rest());
        self.evaluate(time, position, &rest, &mut look.force, &mut tangent);
        look.smooth.take_rows(&tangent, look.columns.searched());
    }

    /// Coordinates that have a constant stiffness of their own and act on nothing but through contacts, if any.
    fn elastic(&self) -> Option<&ElasticCoordinates> {
        None
    }

    /// Displacement (m) of one contact on an elastic flank against another one's force (N) on it, in m/N.
    fn flank_compliance(&self, _of: &FlankPlace, _force: &FlankPlace) -> f64 {
        0.0
    }

    /// The first time after `time` at which the prescribed motion or load has a jump or a kink. Steps end
    /// there.
    fn next_breakpoint(&self, _time: f64) -> Option<f64> {
        None
    }

    /// Angle of the crankshafts in rad: error messages name it.
    fn crank_angle(&self, position: &[f64]) -> f64;

    fn size(&self) -> usize {
        self.mass().len()
    }
}

/// A contact between two bodies: its gap to first order in the displacement, and its law.
#[derive(Debug, Clone, Copy)]
pub struct Contact<'a> {
    /// Coordinates that the gap depends on, those held or prescribed included, and its gradient by them.
    pub index: &'a [usize],
    pub gradient: &'a [f64],
    /// What a unit of its force does to the same coordinates: the gradient, and the friction that goes with it.
    pub push: &'a [f64],
    /// m; negative where the bodies press. On an elastic flank what is left after the flank has given way.
    pub gap: f64,
    pub spring: ContactSpring,
    /// What the law makes of the gap.
    pub pressed: Pressed,
    /// Where it stands on an elastic flank, whose contacts make each other give way.
    pub place: Option<FlankPlace>,
}

impl<'a> Contact<'a> {
    /// Without friction, off elastic flanks.
    pub fn new(index: &'a [usize], gradient: &'a [f64], gap: f64, spring: ContactSpring) -> Contact<'a> {
        Contact { index, gradient, push: gradient, gap, spring, pressed: spring.at(-gap), place: None }
    }
}

/// Where a contact stands on an elastic flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankPlace {
    pub disc: usize,
    pub stencil: Stencil,
}

/// What the static solver sees of a system at one place.
#[derive(Debug, Clone, Default)]
pub struct Look {
    /// Q in N or N·m, over all coordinates.
    pub force: Vec<f64>,
    /// −∂Q/∂q without the stiffness of the contacts along their gaps, over the coordinates that are searched for.
    pub smooth: DenseLinearisation,
    pub contacts: Contacts,
    pub columns: Columns,
}

impl Look {
    /// For a system with one coordinate held, if any.
    pub fn new<S: System + ?Sized>(system: &S, held: Option<usize>) -> Look {
        let mut look = Look::default();
        look.fit(system, held);
        look
    }

    /// Makes room for a system with one coordinate held, if any.
    pub fn fit<S: System + ?Sized>(&mut self, system: &S, held: Option<usize>) {
        self.columns.fit(system, held);
        self.force.clear();
        self.force.resize(system.size(), 0.0);
        self.smooth.fit(self.columns.searched.len());
        self.contacts.clear();
    }
}

/// Which coordinates a search for a state of rest moves: all but a held one and the
/// [elastic](System::elastic) ones, which follow the forces of the contacts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Columns {
    of: Vec<Column>,
    searched: Vec<usize>,
}

/// Where a coordinate is in the matrices of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Searched(usize),
    Elastic,
    Held,
}

impl Columns {
    fn fit<S: System + ?Sized>(&mut self, system: &S, held: Option<usize>) {
        let Columns { of, searched } = self;
        of.clear();
        searched.clear();
        let elastic = system.elastic();
        of.extend((0..system.size()).map(|i| {
            if Some(i) == held {
                Column::Held
            } else if elastic.is_some_and(|elastic| elastic.has(i)) {
                Column::Elastic
            } else {
                searched.push(i);
                Column::Searched(searched.len() - 1)
            }
        }));
    }

    /// Coordinates that are searched for, in the order of their columns.
    pub fn searched(&self) -> &[usize] {
        &self.searched
    }

    /// Column of a coordinate; `None` where it is held, prescribed or elastic.
    #[inline]
    pub fn column(&self, coordinate: usize) -> Option<usize> {
        match self.of.get(coordinate) {
            Some(Column::Searched(column)) => Some(*column),
            _ => None,
        }
    }
}

/// Contacts at one place, with their gradients over the columns that are searched for.
#[derive(Debug, Clone, Default)]
pub struct Contacts {
    pub(super) index: Vec<usize>,
    pub(super) gradient: Vec<f64>,
    pub(super) push: Vec<f64>,
    pub(super) list: Vec<OneContact>,
    /// Gradients by elastic coordinates.
    pub(super) elastic_index: Vec<usize>,
    pub(super) elastic_gradient: Vec<f64>,
    pub(super) places: Vec<ElasticPlace>,
    pub(super) supports: Vec<RoundSupport>,
    /// Whether forces push along other ways than the gaps'.
    pub(super) has_friction: bool,
}

/// A contact in the list of all.
#[derive(Debug, Clone)]
pub(super) struct OneContact {
    pub range: Range<usize>,
    pub gap: f64,
    pub spring: ContactSpring,
    pub pressed: Pressed,
    /// Number of the place on an elastic body where it bears.
    pub place: Option<usize>,
}

impl OneContact {
    /// Whether it can open: not friction.
    pub fn is_gap(&self) -> bool {
        !matches!(self.spring, ContactSpring::Slip { .. })
    }
}

/// A place on an elastic body. Contacts that move it alike, such as the slices of a roller, bear on the same one.
#[derive(Debug, Clone)]
pub(super) struct ElasticPlace {
    /// Its part of the gradients by elastic coordinates.
    pub elastic: Range<usize>,
    pub flank: Option<FlankPlace>,
    /// Contacts that bear there: one after the other in the list, with the same columns.
    pub contacts: Range<usize>,
}

impl Contacts {
    pub fn clear(&mut self) {
        self.index.clear();
        self.gradient.clear();
        self.push.clear();
        self.list.clear();
        self.elastic_index.clear();
        self.elastic_gradient.clear();
        self.places.clear();
        self.supports.clear();
        self.has_friction = false;
    }

    /// Number of contacts that press.
    pub fn pressed(&self) -> usize {
        let closed = self.list.iter().filter(|contact| contact.gap < 0.0 && contact.is_gap()).count();
        closed + self.supports.iter().filter(|support| support.presses(support.shift)).count()
    }

    pub fn push(&mut self, contact: &Contact<'_>, columns: &Columns) {
        let (start, elastic_start) = (self.index.len(), self.elastic_index.len());
        for ((i, g), p) in contact.index.iter().zip(contact.gradient).zip(contact.push) {
            match columns.of.get(*i) {
                Some(Column::Searched(column)) => {
                    self.index.push(*column);
                    self.gradient.push(*g);
                    self.push.push(*p);
                    self.has_friction |= g != p;
                }
                Some(Column::Elastic) => {
                    self.elastic_index.push(*i);
                    self.elastic_gradient.push(*g);
                }
                // Held or prescribed.
                Some(Column::Held) | None => {}
            }
        }
        let (range, elastic) = (start..self.index.len(), elastic_start..self.elastic_index.len());
        let is_elastic = !elastic.is_empty() || contact.place.is_some();
        let place = is_elastic.then(|| self.place(&range, elastic, contact.place));
        let Contact { gap, spring, pressed, .. } = *contact;
        self.list.push(OneContact { range, gap, spring, pressed, place });
    }

    /// Number of the place of the contact that comes next.
    fn place(&mut self, range: &Range<usize>, elastic: Range<usize>, flank: Option<FlankPlace>) -> usize {
        let next = self.list.len();
        if let Some(last) = self.places.last_mut()
            && last.contacts.end == next
            && last.flank == flank
            && self.index[self.list[next - 1].range.clone()] == self.index[range.clone()]
            && self.elastic_index[last.elastic.clone()] == self.elastic_index[elastic.clone()]
            && self.elastic_gradient[last.elastic.clone()] == self.elastic_gradient[elastic.clone()]
        {
            last.contacts.end += 1;
            self.elastic_index.truncate(elastic.start);
            self.elastic_gradient.truncate(elastic.start);
        } else {
            self.places.push(ElasticPlace { elastic, flank, contacts: next..next + 1 });
        }
        self.places.len() - 1
    }

    /// Adds a shaft in a hole with clearance; coordinates that are not searched for do not move it.
    pub fn push_support(&mut self, support: RoundSupport, columns: &Columns) {
        let rows = support.index.iter().zip(&support.gradient);
        let (index, gradient) = rows.filter_map(|(i, row)| Some((columns.column(*i)?, *row))).unzip();
        self.supports.push(RoundSupport { index, gradient, ..support });
    }
}

/// A shaft in a round hole with clearance: F = k (|u| − c) u/|u| beyond the clearance, convex in u but as sharply bent as
/// the clearance is small, so that it is a law of two components rather than a gap.
#[derive(Debug, Clone, PartialEq)]
pub struct RoundSupport {
    pub index: Vec<usize>,
    /// ∂u/∂(coordinate).
    pub gradient: Vec<[f64; 2]>,
    /// u in m.
    pub shift: [f64; 2],
    /// k in N/m and c in m.
    pub stiffness: f64,
    pub clearance: f64,
}

impl RoundSupport {
    pub fn presses(&self, shift: [f64; 2]) -> bool {
        shift[0].hypot(shift[1]) > self.clearance
    }

    /// F in N.
    pub fn force(&self, shift: [f64; 2]) -> [f64; 2] {
        let distance = shift[0].hypot(shift[1]);
        let share =
            if distance > self.clearance { self.stiffness * (1.0 - self.clearance / distance) } else { 0.0 };
        shift.map(|u| share * u)
    }

    /// ∂F/∂u by its two directions, along and across the displacement; in N/m.
    pub fn stiffness(&self, shift: [f64; 2]) -> impl Iterator<Item = (f64, Vec2)> {
        let distance = shift[0].hypot(shift[1]);
        let presses = distance > self.clearance;
        let along = Vec2::new(shift[0], shift[1]) / distance.max(f64::MIN_POSITIVE);
        let across = self.stiffness * (1.0 - self.clearance / distance.max(f64::MIN_POSITIVE));
        let both = [(self.stiffness, along), (across, crate::geometry::quarter_turn(along))];
        both.into_iter().filter(move |_| presses)
    }
}

/// Coordinates of elastic bodies: groups whose stiffness matrix K is constant, kept as K⁻¹.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ElasticCoordinates {
    /// Group of every coordinate and its number in it.
    member: Vec<Option<(usize, usize)>>,
    groups: Vec<ElasticGroup>,
}

#[derive(Debug, Clone, PartialEq)]
struct ElasticGroup {
    index: Vec<usize>,
    /// K⁻¹ row by row.
    compliance: Vec<f64>,
}

impl ElasticCoordinates {
    pub fn new(size: usize) -> ElasticCoordinates {
        ElasticCoordinates { member: vec![None; size], groups: Vec::new() }
    }

    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// Adds a group with its stiffness row by row. A matrix that is not positive definite leaves its coordinates to be
    /// searched like any other.
    pub fn add(&mut self, index: &[usize], stiffness: &[f64]) {
        let matrix = nalgebra::DMatrix::from_row_slice(index.len(), index.len(), stiffness);
        let Some(factor) = matrix.cholesky() else { return };
        for (place, coordinate) in index.iter().enumerate() {
            self.member[*coordinate] = Some((self.groups.len(), place));
        }
        let compliance = factor.inverse().as_slice().to_vec();
        self.groups.push(ElasticGroup { index: index.to_vec(), compliance });
    }

    pub fn has(&self, coordinate: usize) -> bool {
        matches!(self.member.get(coordinate), Some(Some(_)))
    }

    pub fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// Number of the group of an elastic coordinate.
    pub fn group(&self, coordinate: usize) -> Option<usize> {
        Some((*self.member.get(coordinate)?)?.0)
    }

    /// Coordinates of a group.
    pub fn members(&self, group: usize) -> &[usize] {
        &self.groups[group].index
    }

    /// Adds K⁻¹ f for a force on one coordinate to displacements of all of them.
    pub fn yield_to(&self, coordinate: usize, force: f64, displacement: &mut [f64]) {
        let Some(Some((group, place))) = self.member.get(coordinate) else { return };
        let ElasticGroup { index, compliance } = &self.groups[*group];
        let column = &compliance[place * index.len()..][..index.len()];
        index.iter().zip(column).for_each(|(i, c)| displacement[*i] += c * force);
    }
}

/// Factors of mass, damping and stiffness in the matrix of an implicit step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    pub mass: f64,
    pub damping: f64,
    pub stiffness: f64,
}

/// The matrix cannot be inverted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("singular matrix")]
pub struct Singular;

/// Powers, stored energy and torques at the flanges at one state: what the energy balance needs.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Balance {
    /// Power that the drive puts in, in W.
    pub input_power: f64,
    /// Power delivered to the load in W.
    pub load_power: f64,
    /// Power lost in dampers and friction in W, never negative.
    pub dissipation: f64,
    /// Elastic energy in J.
    pub stored: f64,
    /// Torque that the drive puts in at the input, in N·m.
    pub input_torque: f64,
    /// Torque that the output passes on, in N·m; positive against positive motion.
    pub load_torque: f64,
    /// 1/s: the largest rate at which an open contact is closing relative to its gap (plus a tolerable
    /// depth); the step stays below its inverse, so that no contact is entered deeper than tolerable in one
    /// go. 0 where nothing approaches.
    pub onset_rate: f64,
}

/// Full matrices, row by row, with Gaussian elimination; by faer's blocks from so many coordinates on that
/// they pay.
#[derive(Debug, Clone, Default)]
pub struct DenseLinearisation {
    size: usize,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    /// What was factorised last: factors row by row, with the row that each one changed places with, or those of
    /// faer.
    work: Vec<f64>,
    exchanged: Vec<usize>,
    blocks: Option<PartialPivLu<f64>>,
}

/// Coordinates from which on blocks are faster.
pub(super) const LARGE: usize = 96;

impl DenseLinearisation {
    pub fn new(size: usize) -> DenseLinearisation {
        DenseLinearisation {
            size,
            stiffness: vec![0.0; size * size],
            damping: vec![0.0; size * size],
            work: vec![0.0; size * size],
            exchanged: Vec::with_capacity(size),
            blocks: None,
        }
    }

    /// Makes room for so many coordinates, at rest.
    pub fn fit(&mut self, size: usize) {
        if self.size != size || self.takes_damping() {
            *self = DenseLinearisation::at_rest(size);
        }
    }

    /// Without damping, which is neither taken nor asked for.
    pub fn at_rest(size: usize) -> DenseLinearisation {
        DenseLinearisation { damping: Vec::new(), ..DenseLinearisation::new(size) }
    }

    /// Whether it takes damping.
    pub fn takes_damping(&self) -> bool {
        !self.damping.is_empty()
    }

    pub fn clear(&mut self) {
        self.stiffness.fill(0.0);
        self.damping.fill(0.0);
    }

    #[inline]
    pub fn add_stiffness(&mut self, row: usize, column: usize, value: f64) {
        self.stiffness[row * self.size + column] += value;
    }

    #[inline]
    pub fn add_damping(&mut self, row: usize, column: usize, value: f64) {
        if let Some(entry) = self.damping.get_mut(row * self.size + column) {
            *entry += value;
        }
    }

    /// −∂Q_row/∂q of all coordinates.
    #[inline]
    pub fn stiffness_row(&mut self, row: usize) -> &mut [f64] {
        &mut self.stiffness[row * self.size..][..self.size]
    }

    /// The same to read.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.stiffness[row * self.size..][..self.size]
    }

    /// −∂Q_row/∂q̇ of all coordinates.
    #[inline]
    pub fn damping_row(&mut self, row: usize) -> &mut [f64] {
        self.damping.get_mut(row * self.size..(row + 1) * self.size).unwrap_or_default()
    }

    /// Adds the damping times `rate` (1/s) to the stiffness: velocities that are q times the rate, less a
    /// constant.
    pub fn fold_damping(&mut self, rate: f64) {
        for (stiffness, damping) in self.stiffness.iter_mut().zip(&self.damping) {
            *stiffness += rate * damping;
        }
    }

    /// −∂Q_row/∂q_column.
    pub fn stiffness(&self, row: usize, column: usize) -> f64 {
        self.stiffness[row * self.size + column]
    }

    /// −∂Q_row/∂q̇_column.
    pub fn damping(&self, row: usize, column: usize) -> f64 {
        self.damping[row * self.size + column]
    }
}

impl DenseLinearisation {
    /// Takes over the stiffness of another, and no damping.
    pub fn copy_stiffness(&mut self, from: &DenseLinearisation) {
        self.stiffness.copy_from_slice(&from.stiffness);
        self.damping.fill(0.0);
    }

    /// Adds k a bᵀ to the stiffness (k in N/m) for two vectors over the coordinates listed; coordinates from the size
    /// on do not move.
    pub fn add_outer(&mut self, index: &[usize], a: &[f64], b: &[f64], stiffness: f64) {
        for (row, a) in index.iter().zip(a).filter(|(row, _)| **row < self.size) {
            let line = &mut self.stiffness[row * self.size..][..self.size];
            let force = stiffness * a;
            for i in 0..index.len() {
                if let Some(entry) = line.get_mut(index[i]) {
                    *entry += force * b[i];
                }
            }
        }
    }

    /// Holds a coordinate: no force moves it, and it moves nothing.
    pub fn hold(&mut self, coordinate: usize) {
        let n = self.size;
        for i in 0..n {
            for entry in [coordinate * n + i, i * n + coordinate] {
                self.stiffness[entry] = 0.0;
                self.damping.get_mut(entry).into_iter().for_each(|damping| *damping = 0.0);
            }
        }
        self.stiffness[coordinate * n + coordinate] = 1.0;
    }

    /// K x.
    pub fn multiply(&self, x: &[f64], product: &mut [f64]) {
        for (entry, row) in product.iter_mut().zip(self.stiffness.chunks_exact(self.size)) {
            *entry = dot(row, x);
        }
    }

    /// Takes over the rows and columns listed from the stiffness of a larger matrix.
    pub fn take_rows(&mut self, from: &DenseLinearisation, index: &[usize]) {
        for (row, i) in index.iter().enumerate() {
            let from = from.row(*i);
            self.stiffness_row(row).iter_mut().zip(index).for_each(|(entry, j)| *entry = from[*j]);
        }
    }

    /// Solves K x = rhs in place for a symmetric K by Cholesky's factorisation UᵀU, of which it reads the upper half.
    /// `false`, and `rhs` unchanged, where K is not positive definite.
    pub fn solve_positive(&mut self, rhs: &mut [f64]) -> bool {
        let (n, a) = (self.size, &mut self.work);
        a.copy_from_slice(&self.stiffness);
        for i in 0..n {
            let (done, rest) = a.split_at_mut((i + 1) * n);
            let own = &mut done[i * n + i..];
            if !(own[0] > 0.0) {
                return false;
            }
            let scale = 1.0 / own[0].sqrt();
            own.iter_mut().for_each(|entry| *entry *= scale);
            for (row, other) in rest.chunks_exact_mut(n).zip(i + 1..) {
                let share = own[other - i];
                if share != 0.0 {
                    let entries = row[other..].iter_mut().zip(&own[other - i..]);
                    entries.for_each(|(entry, of_own)| *entry -= share * of_own);
                }
            }
        }
        for row in 0..n {
            let entries = &a[row * n + row..][..n - row];
            let x = rhs[row] / entries[0];
            rhs[row] = x;
            rhs[row + 1..].iter_mut().zip(&entries[1..]).for_each(|(rhs, entry)| *rhs -= x * entry);
        }
        for row in (0..n).rev() {
            let entries = &a[row * n + row..][..n - row];
            rhs[row] = (rhs[row] - dot(&entries[1..], &rhs[row + 1..])) / entries[0];
        }
        true
    }

    /// Solves (M m + C d + K s) x = rhs in place, where (m, d, s) are the weights.
    ///
    /// # Errors
    /// [`Singular`] if the matrix has no inverse or holds a value that is not finite.
    pub fn solve(&mut self, mass: &[f64], weights: Weights, rhs: &mut [f64]) -> Result<(), Singular> {
        let n = self.size;
        let a = &mut self.work;
        if weights.damping == 0.0 && weights.stiffness == 1.0 {
            a.copy_from_slice(&self.stiffness);
        } else if weights.damping == 0.0 {
            a.iter_mut().zip(&self.stiffness).for_each(|(entry, k)| *entry = weights.stiffness * k);
        } else {
            for (entry, (k, c)) in a.iter_mut().zip(self.stiffness.iter().zip(&self.damping)) {
                *entry = weights.stiffness * k + weights.damping * c;
            }
        }
        for i in 0..n {
            a[i * n + i] += weights.mass * mass[i];
        }
        if n >= LARGE {
            let matrix = faer::MatRef::from_row_major_slice(a, n, n);
            self.blocks = Some(cleared(|| matrix.partial_piv_lu()));
        } else {
            self.eliminate()?;
        }
        self.solve_again(rhs)
    }

    /// Solves the system of the last [`DenseLinearisation::solve`] for another right-hand side, whatever has become of
    /// the matrices since.
    ///
    /// # Errors
    /// As there.
    pub fn solve_again(&self, rhs: &mut [f64]) -> Result<(), Singular> {
        let (n, a) = (self.size, &self.work);
        if let Some(factor) = &self.blocks {
            cleared(|| factor.solve_in_place(faer::MatMut::from_column_major_slice_mut(rhs, n, 1)));
        } else {
            for (row, other) in self.exchanged.iter().enumerate() {
                rhs.swap(row, *other);
            }
            for row in 1..n {
                rhs[row] -= dot(&a[row * n..][..row], &rhs[..row]);
            }
            for row in (0..n).rev() {
                let entries = &a[row * n..][..n];
                rhs[row] = (rhs[row] - dot(&entries[row + 1..], &rhs[row + 1..])) / entries[row];
            }
        }
        if rhs.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(Singular) }
    }
}

/// Four sums side by side, which do not wait for each other.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let b = &b[..a.len()];
    let whole = a.len() - a.len() % 4;
    let mut sums = [0.0; 4];
    for first in (0..whole).step_by(4) {
        for lane in 0..4 {
            sums[lane] += a[first + lane] * b[first + lane];
        }
    }
    let rest: f64 = (whole..a.len()).map(|i| a[i] * b[i]).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

impl DenseLinearisation {
    /// Gaussian elimination of what is in `work`: the factors of every column are left below the diagonal, and change
    /// places with their rows.
    fn eliminate(&mut self) -> Result<(), Singular> {
        let (n, a) = (self.size, &mut self.work);
        self.exchanged.clear();
        for column in 0..n {
            let mut pivot = column;
            for row in column + 1..n {
                if a[row * n + column].abs() > a[pivot * n + column].abs() {
                    pivot = row;
                }
            }
            let largest = a[pivot * n + column];
            if !(largest.abs() > 0.0 && largest.is_finite()) {
                return Err(Singular);
            }
            self.exchanged.push(pivot);
            if pivot != column {
                for k in 0..n {
                    a.swap(column * n + k, pivot * n + k);
                }
            }
            // Slices of known length, so that the compiler takes several entries of a row at once.
            let (above, below) = a.split_at_mut((column + 1) * n);
            let pivot_row = &above[column * n + column + 1..];
            for row in below.chunks_exact_mut(n) {
                let factor = row[column] / largest;
                row[column] = factor;
                if factor != 0.0 {
                    let rest = &mut row[column + 1..];
                    let pivot_row = &pivot_row[..rest.len()];
                    for k in 0..rest.len() {
                        rest[k] -= factor * pivot_row[k];
                    }
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elimination_pivots_and_agrees_with_nalgebra() {
        [5, LARGE].into_iter().for_each(agrees_with_nalgebra);
    }

    fn agrees_with_nalgebra(n: usize) {
        let mut lin = DenseLinearisation::new(n);
        let mut matrix = nalgebra::DMatrix::<f64>::zeros(n, n);
        let mass: Vec<f64> = [1.0, 2.0, 0.5, 0.0, 3.0].into_iter().cycle().take(n).collect();
        for i in 0..n {
            for j in 0..n {
                // A zero on the diagonal forces a row exchange.
                let k = if i == j { 0.0 } else { ((i * j * 7 + i + j * 3) as f64).sin() };
                let c = ((i * i + 2 * i * j) as f64).cos();
                lin.add_stiffness(i, j, k);
                lin.add_damping(i, j, c);
                matrix[(i, j)] = 2.0 * k + 0.5 * c + if i == j { 3.0 * mass[i] } else { 0.0 };
            }
        }
        let rhs: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
        let mut x = rhs.clone();
        lin.solve(&mass, Weights { mass: 3.0, damping: 0.5, stiffness: 2.0 }, &mut x).unwrap();
        let rhs = nalgebra::DVector::from_vec(rhs);
        let left = (&matrix * nalgebra::DVector::from_vec(x.clone()) - &rhs).norm();
        assert!(left < 1e-12 * rhs.norm(), "{n}: {left:e}");
        // The same factors for another right-hand side, whatever the matrices hold by then.
        lin.clear();
        let mut again: Vec<f64> = x.iter().rev().copied().collect();
        lin.solve_again(&mut again).unwrap();
        let reversed = nalgebra::DVector::from_iterator(n, x.iter().rev().copied());
        let left = (&matrix * nalgebra::DVector::from_vec(again) - &reversed).norm();
        assert!(left < 1e-12 * reversed.norm(), "{n}: {left:e}");
        let expected = matrix.lu().solve(&rhs).unwrap();
        for i in 0..n {
            assert!((x[i] - expected[i]).abs() < 1e-12 * expected.norm(), "{n} {i}");
        }
    }

    #[test]
    fn singular_matrix_is_reported() {
        for n in [2, LARGE] {
            let mut lin = DenseLinearisation::new(n);
            let weights = Weights { mass: 0.0, damping: 0.0, stiffness: 1.0 };
            let mut rhs = vec![1.0; n];
            assert_eq!(lin.solve(&vec![1.0; n], weights, &mut rhs), Err(Singular));
            lin.add_stiffness(0, 0, f64::NAN);
            assert_eq!(lin.solve(&vec![1.0; n], weights, &mut vec![1.0; n]), Err(Singular));
        }
    }
}
