//! A system at one place: forces, tangent, contacts, elastic coordinates.

use std::ops::Range;

use super::{DenseLinearisation, System};
use crate::contact::{ContactSpring, Pressed};
use crate::fem::Stencil;
use crate::geometry::Vec2;

/// A contact between two bodies: its gap to first order in the displacement, and its law.
#[derive(Debug, Clone, Copy)]
pub struct Contact<'a> {
    /// Coordinates that the gap depends on, those held or prescribed included.
    pub index: &'a [usize],
    /// ∂(gap)/∂(coordinate) in the order of `index`.
    pub gradient: &'a [f64],
    /// Effect of a unit of its force on the same coordinates: the gradient, and the friction that goes with it.
    pub push: &'a [f64],
    /// m; negative is penetration. On an elastic flank what is left after the flank has given way.
    pub gap: f64,
    /// Law of the force against the approach, −`gap`.
    pub spring: ContactSpring,
    /// Force and stiffness that the law gives for the gap.
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
    /// Disc, counted from 0.
    pub disc: usize,
    /// Weights of the stations of its flank at this place.
    pub stencil: Stencil,
}

/// A system at one place as the static solver needs it.
#[derive(Debug, Clone, Default)]
pub struct Look {
    /// Q in N or N·m, over all coordinates.
    pub force: Vec<f64>,
    /// −∂Q/∂q without the stiffness of the contacts along their gaps, over the coordinates that are searched for.
    pub smooth: DenseLinearisation,
    /// Contacts that press or are near, with their gradients.
    pub contacts: Contacts,
    /// Which coordinates are searched for.
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
    pub(in crate::dynamics) index: Vec<usize>,
    pub(in crate::dynamics) gradient: Vec<f64>,
    pub(in crate::dynamics) push: Vec<f64>,
    pub(in crate::dynamics) list: Vec<OneContact>,
    /// Gradients by elastic coordinates.
    pub(in crate::dynamics) elastic_index: Vec<usize>,
    pub(in crate::dynamics) elastic_gradient: Vec<f64>,
    pub(in crate::dynamics) places: Vec<ElasticPlace>,
    pub(in crate::dynamics) supports: Vec<RoundSupport>,
    /// Whether forces push along other ways than the gaps'.
    pub(in crate::dynamics) has_friction: bool,
}

/// A contact in the list of all.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct OneContact {
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
pub(in crate::dynamics) struct ElasticPlace {
    /// Its part of the gradients by elastic coordinates.
    pub elastic: Range<usize>,
    pub flank: Option<FlankPlace>,
    /// Contacts that bear there: one after the other in the list, with the same columns.
    pub contacts: Range<usize>,
}

impl Contacts {
    /// Takes all contacts and supports out.
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

    /// Adds a contact, with its gradient over the columns that are searched for and the elastic coordinates.
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
    /// Whether a shift (m) exceeds the clearance.
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
    /// No elastic ones among so many coordinates.
    pub fn new(size: usize) -> ElasticCoordinates {
        ElasticCoordinates { member: vec![None; size], groups: Vec::new() }
    }

    /// Whether no coordinate is elastic.
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
    pub fn yield_to(&self, coordinate: usize, force: f64, displacement: &mut [f64]) {
        let Some(Some((group, place))) = self.member.get(coordinate) else { return };
        let ElasticGroup { index, compliance } = &self.groups[*group];
        let column = &compliance[place * index.len()..][..index.len()];
        index.iter().zip(column).for_each(|(i, c)| displacement[*i] += c * force);
    }
}
