//! Evaluation of a system at one position: forces, tangent, contacts, elastic coordinates.

use std::ops::Range;

use super::{DenseLinearisation, System};
use crate::contact::{ContactSpring, Pressed};
use crate::fem::Stencil;
use crate::geometry::Vec2;

/// A contact between two bodies: its gap linearised in the displacement, and its force law.
#[derive(Debug, Clone, Copy)]
pub struct Contact<'a> {
    /// Coordinates that the gap depends on, including held or prescribed ones.
    pub index: &'a [usize],
    /// ∂(gap)/∂(coordinate) in the order of `index`.
    pub gradient: &'a [f64],
    /// Effect of a unit of its force on the same coordinates: the gradient, plus the friction proportional to
    /// the force.
    pub push: &'a [f64],
    /// m; negative is penetration. For an elastic flank the gap after its deformation.
    pub gap: f64,
    /// Law of the force against the approach, −`gap`.
    pub spring: ContactSpring,
    /// Force and stiffness of the law at this gap.
    pub pressed: Pressed,
    /// Position on an elastic flank, whose contacts deform it at each other's positions.
    pub place: Option<FlankPlace>,
}

impl<'a> Contact<'a> {
    /// A contact without friction and not on an elastic flank.
    pub fn new(index: &'a [usize], gradient: &'a [f64], gap: f64, spring: ContactSpring) -> Contact<'a> {
        Contact { index, gradient, push: gradient, gap, spring, pressed: spring.at(-gap), place: None }
    }
}

/// Position of a contact on an elastic flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankPlace {
    /// Disc, counted from 0.
    pub disc: usize,
    /// Weights of the stations of its flank for this position.
    pub stencil: Stencil,
}

/// Evaluation of a system at one position, for the static solver.
#[derive(Debug, Clone, Default)]
pub struct Evaluation {
    /// Q in N or N·m, over all coordinates.
    pub force: Vec<f64>,
    /// −∂Q/∂q without the contact stiffness along the gaps, over the unknown coordinates.
    pub smooth: DenseLinearisation,
    /// Contacts that are loaded or nearly closed, with their gradients.
    pub contacts: Contacts,
    /// The unknown coordinates.
    pub columns: Columns,
}

impl Evaluation {
    /// For a system with at most one held coordinate.
    pub fn new<S: System + ?Sized>(system: &S, held: Option<usize>) -> Evaluation {
        let mut evaluation = Evaluation::default();
        evaluation.fit(system, held);
        evaluation
    }

    /// Adapts the memory to a system with at most one held coordinate.
    pub fn fit<S: System + ?Sized>(&mut self, system: &S, held: Option<usize>) {
        self.columns.fit(system, held);
        self.force.clear();
        self.force.resize(system.size(), 0.0);
        self.smooth.fit(self.columns.searched.len());
        self.contacts.clear();
    }
}

/// Unknown coordinates of a search for static equilibrium: all except a held one and the
/// [elastic](System::elastic) ones, which follow from the contact forces.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Columns {
    of: Vec<Column>,
    searched: Vec<usize>,
}

/// Position of a coordinate in the matrices of a search.
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

    /// The unknown coordinates in the order of their columns.
    pub fn searched(&self) -> &[usize] {
        &self.searched
    }

    /// Column of a coordinate; `None` if it is held, prescribed or elastic.
    #[inline]
    pub fn column(&self, coordinate: usize) -> Option<usize> {
        match self.of.get(coordinate) {
            Some(Column::Searched(column)) => Some(*column),
            _ => None,
        }
    }
}

/// Contacts at one position, with their gradients over the unknown columns.
#[derive(Debug, Clone, Default)]
pub struct Contacts {
    pub(in crate::dynamics) index: Vec<usize>,
    pub(in crate::dynamics) gradient: Vec<f64>,
    pub(in crate::dynamics) push: Vec<f64>,
    pub(in crate::dynamics) list: Vec<ListedContact>,
    /// Gradients by elastic coordinates.
    pub(in crate::dynamics) elastic_index: Vec<usize>,
    pub(in crate::dynamics) elastic_gradient: Vec<f64>,
    pub(in crate::dynamics) places: Vec<ElasticPoint>,
    pub(in crate::dynamics) supports: Vec<RoundSupport>,
    /// Whether forces have directions other than the gradients of the gaps.
    pub(in crate::dynamics) has_friction: bool,
}

/// A contact in the list.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct ListedContact {
    pub range: Range<usize>,
    pub gap: f64,
    pub spring: ContactSpring,
    pub pressed: Pressed,
    /// Number of its contact point on an elastic body.
    pub place: Option<usize>,
}

impl ListedContact {
    /// Whether it is a gap, which can open; friction cannot.
    pub fn is_gap(&self) -> bool {
        !matches!(self.spring, ContactSpring::Slip { .. })
    }
}

/// A contact point on an elastic body. Contacts with the same effect on the body, such as the slices of a
/// roller, share one.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct ElasticPoint {
    /// Range of its gradients by elastic coordinates.
    pub elastic: Range<usize>,
    pub flank: Option<FlankPlace>,
    /// Its contacts: consecutive in the list, with the same columns.
    pub contacts: Range<usize>,
}

impl Contacts {
    /// Removes all contacts and supports.
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

    /// Number of loaded contacts.
    pub fn pressed(&self) -> usize {
        let closed = self.list.iter().filter(|contact| contact.gap < 0.0 && contact.is_gap()).count();
        closed + self.supports.iter().filter(|support| support.presses(support.shift)).count()
    }

    /// Adds a contact, with its gradient over the unknown columns and the elastic coordinates.
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
                // Held or prescribed coordinate.
                Some(Column::Held) | None => {}
            }
        }
        let (range, elastic) = (start..self.index.len(), elastic_start..self.elastic_index.len());
        let is_elastic = !elastic.is_empty() || contact.place.is_some();
        let place = is_elastic.then(|| self.place(&range, elastic, contact.place));
        let Contact { gap, spring, pressed, .. } = *contact;
        self.list.push(ListedContact { range, gap, spring, pressed, place });
    }

    /// Number of the contact point of the next contact.
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
            self.places.push(ElasticPoint { elastic, flank, contacts: next..next + 1 });
        }
        self.places.len() - 1
    }

    /// Adds a shaft in a hole with clearance; only unknown coordinates displace it.
    pub fn push_support(&mut self, support: RoundSupport, columns: &Columns) {
        let rows = support.index.iter().zip(&support.gradient);
        let (index, gradient) = rows.filter_map(|(i, row)| Some((columns.column(*i)?, *row))).unzip();
        self.supports.push(RoundSupport { index, gradient, ..support });
    }
}

/// A shaft in a round hole with clearance: F = k (|u| − c) u/|u| beyond the clearance. It is convex in u, but
/// for small clearance strongly curved, so that it is treated as a law in two components instead of a gap.
#[derive(Debug, Clone, PartialEq)]
pub struct RoundSupport {
    /// Numbers of the coordinates that u depends on.
    pub index: Vec<usize>,
    /// ∂u/∂(coordinate).
    pub gradient: Vec<[f64; 2]>,
    /// u in m.
    pub shift: [f64; 2],
    /// k in N/m.
    pub stiffness: f64,
    /// c in m, radial.
    pub clearance: f64,
}

impl RoundSupport {
    /// Whether a displacement (m) exceeds the clearance.
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

    /// Eigenvalues of ∂F/∂u with their directions, along and perpendicular to the displacement; in N/m.
    pub fn stiffness(&self, shift: [f64; 2]) -> impl Iterator<Item = (f64, Vec2)> {
        let distance = shift[0].hypot(shift[1]);
        let presses = distance > self.clearance;
        let along = Vec2::new(shift[0], shift[1]) / distance.max(f64::MIN_POSITIVE);
        let across = self.stiffness * (1.0 - self.clearance / distance.max(f64::MIN_POSITIVE));
        let both = [(self.stiffness, along), (across, crate::geometry::quarter_turn(along))];
        both.into_iter().filter(move |_| presses)
    }
}

/// Coordinates of elastic bodies: groups with a constant stiffness matrix K, stored as K⁻¹.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ElasticCoordinates {
    /// For every coordinate its group and its number in the group.
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
    /// Without elastic coordinates, for a number of coordinates.
    pub fn new(size: usize) -> ElasticCoordinates {
        ElasticCoordinates { member: vec![None; size], groups: Vec::new() }
    }

    /// Whether no coordinate is elastic.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// Adds a group with its stiffness, row by row. If the matrix is not positive definite, its coordinates
    /// remain unknowns.
    pub fn add(&mut self, index: &[usize], stiffness: &[f64]) {
        let matrix = nalgebra::DMatrix::from_row_slice(index.len(), index.len(), stiffness);
        let Some(factor) = matrix.cholesky() else { return };
        for (place, coordinate) in index.iter().enumerate() {
            self.member[*coordinate] = Some((self.groups.len(), place));
        }
        let compliance = factor.inverse().as_slice().to_vec();
        self.groups.push(ElasticGroup { index: index.to_vec(), compliance });
    }

    /// Whether a coordinate is elastic.
    pub fn has(&self, coordinate: usize) -> bool {
        matches!(self.member.get(coordinate), Some(Some(_)))
    }

    pub(crate) fn group_count(&self) -> usize {
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
    pub fn add_displacements(&self, coordinate: usize, force: f64, displacement: &mut [f64]) {
        let Some(Some((group, place))) = self.member.get(coordinate) else { return };
        let ElasticGroup { index, compliance } = &self.groups[*group];
        let column = &compliance[place * index.len()..][..index.len()];
        index.iter().zip(column).for_each(|(i, c)| displacement[*i] += c * force);
    }
}
