use super::labels::Part;
use crate::dynamics::{Balance, Columns, Contact, Contacts, DenseLinearisation, RoundSupport};

/// One spring-like element: energy with gradient and Hessian with respect to the listed coordinates.
pub struct Element<'a> {
    /// Part to which its compliance is assigned.
    pub part: Part,
    /// Numbers of the coordinates that it acts on.
    pub index: &'a [usize],
    /// ∂(energy)/∂(coordinate) in the order of `index`: minus its forces, N or N·m.
    pub gradient: &'a [f64],
    /// Second derivatives of the energy, row by row.
    pub hessian: &'a [f64],
    /// Elastic energy, J.
    pub stored: f64,
}

/// Receives all elements of the model at one state.
pub trait Sink {
    /// Receives one spring-like element.
    fn element(&mut self, element: &Element<'_>);

    /// Receives velocity-dependent forces: `force[i]` on coordinate `index[i]`, matrix −∂(force)/∂(velocity)
    /// row by row.
    fn damper(&mut self, index: &[usize], force: &[f64], matrix: &[f64], dissipation: f64);

    /// Whether Hessians of elements and derivatives of friction are required; if not, they may be empty.
    fn takes_stiffness(&self) -> bool {
        true
    }

    /// Whether the matrices of dampers are required.
    fn takes_damping(&self) -> bool {
        true
    }

    /// Receives derivatives of friction and damping by position: −∂(force)/∂(coordinate) row by row.
    fn friction_slope(&mut self, _index: &[usize], _matrix: &[f64]) {}

    /// Receives the onset rate (1/s) of open contacts.
    fn onset(&mut self, _rate: f64) {}

    /// Single contacts that are required: then [`Sink::contact`] receives each loaded or nearly closed one.
    fn contact_request(&self) -> Option<ContactRequest> {
        None
    }

    /// Whether Hessians of elements are required for a coordinate; if not, they may omit it.
    fn searches(&self, _coordinate: usize) -> bool {
        true
    }

    /// Stiffness of an element for coordinates that are unknowns of the solver, row by row.
    fn stiffness(&mut self, index: &[usize], matrix: &[f64]) {
        self.friction_slope(index, matrix);
    }

    /// A contact whose force is also part of an element or damper. If single contacts are required, Hessians of
    /// elements do not contain the contact stiffness along the gaps, and the matrices of dampers do not contain
    /// friction if its [interval](ContactRequest::slip_interval) is given.
    fn contact(&mut self, _contact: &Contact<'_>) {}

    /// A shaft in a hole with clearance, whose force is also part of an element.
    fn round_support(&mut self, _support: RoundSupport) {}
}

/// Contacts that a search for static equilibrium requires.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactRequest {
    /// Gap in m up to which open contacts are required.
    pub reach: f64,
    /// Time in s over which displacements since the last equilibrium determine the velocities for friction;
    /// `None` if velocities are given.
    pub slip_interval: Option<f64>,
}

/// Sums forces, and tangents if there is a matrix for them. Coordinates from number `size` on are held or
/// prescribed; the torque on a prescribed input is stored separately.
pub struct Assembly<'a> {
    pub force: &'a mut [f64],
    pub linearisation: Option<&'a mut DenseLinearisation>,
    pub size: usize,
    pub input: usize,
    /// Torque of the machine on a prescribed input in N·m.
    pub prescribed_torque: f64,
    pub balance: Balance,
    /// Receiver of single contacts, if required, and the columns of the linearisation.
    pub contacts: Option<(ContactRequest, &'a mut Contacts, &'a Columns)>,
}

impl Assembly<'_> {
    pub fn add_force(&mut self, coordinate: usize, value: f64) {
        if coordinate < self.size {
            self.force[coordinate] += value;
        } else if coordinate == self.input {
            self.prescribed_torque += value;
        }
    }

    /// Adds a matrix given row by row to the rows of the linearisation selected by `row`, for all pairs of its
    /// coordinates.
    fn scatter(
        &mut self,
        index: &[usize],
        matrix: &[f64],
        row: fn(&mut DenseLinearisation, usize) -> &mut [f64],
    ) {
        let Some(linearisation) = self.linearisation.as_deref_mut() else { return };
        let columns = self.contacts.as_ref().map(|(_, _, columns)| *columns);
        let size = self.size;
        let column = |at: usize| match columns {
            Some(columns) => columns.column(at),
            None => (at < size).then_some(at),
        };
        for (at, line) in index.iter().zip(matrix.chunks_exact(index.len())) {
            let Some(at) = column(*at) else { continue };
            let into = row(linearisation, at);
            for (i, entry) in index.iter().zip(line) {
                // A linearisation at rest has no damping matrix.
                if let Some(into) = column(*i).and_then(|column| into.get_mut(column)) {
                    *into += entry;
                }
            }
        }
    }
}

impl Sink for Assembly<'_> {
    fn element(&mut self, element: &Element<'_>) {
        for (i, row) in element.index.iter().enumerate() {
            self.add_force(*row, -element.gradient[i]);
        }
        self.scatter(element.index, element.hessian, DenseLinearisation::stiffness_row);
        self.balance.stored += element.stored;
    }

    fn damper(&mut self, index: &[usize], force: &[f64], matrix: &[f64], dissipation: f64) {
        for (i, row) in index.iter().enumerate() {
            self.add_force(*row, force[i]);
        }
        match self.contacts.as_ref().map(|(wanted, ..)| wanted.slip_interval) {
            None => self.scatter(index, matrix, DenseLinearisation::damping_row),
            Some(None) => {}
            Some(Some(interval)) => {
                let per_displacement: Vec<f64> = matrix.iter().map(|c| c / interval).collect();
                self.scatter(index, &per_displacement, DenseLinearisation::stiffness_row);
            }
        }
        self.balance.dissipation += dissipation;
    }

    fn contact_request(&self) -> Option<ContactRequest> {
        self.contacts.as_ref().map(|(wanted, ..)| *wanted)
    }

    fn searches(&self, coordinate: usize) -> bool {
        self.contacts.as_ref().is_none_or(|(_, _, columns)| columns.column(coordinate).is_some())
    }

    fn contact(&mut self, contact: &Contact<'_>) {
        if let Some((_, contacts, columns)) = &mut self.contacts {
            contacts.push(contact, columns);
        }
    }

    fn round_support(&mut self, support: RoundSupport) {
        if let Some((_, contacts, columns)) = &mut self.contacts {
            contacts.push_support(support, columns);
        }
    }

    fn takes_stiffness(&self) -> bool {
        self.linearisation.is_some()
    }

    fn takes_damping(&self) -> bool {
        match &self.contacts {
            Some((wanted, ..)) => wanted.slip_interval.is_some(),
            None => self.linearisation.as_ref().is_some_and(|linearisation| linearisation.takes_damping()),
        }
    }

    fn friction_slope(&mut self, index: &[usize], matrix: &[f64]) {
        self.scatter(index, matrix, DenseLinearisation::stiffness_row);
    }

    fn onset(&mut self, rate: f64) {
        self.balance.onset_rate = self.balance.onset_rate.max(rate);
    }
}

/// Tangent compliance of each part along one motion g of all coordinates: gᵀ K_part g.
pub struct Split<'a> {
    /// Motion of all coordinates, including held ones.
    pub motion: &'a [f64],
    pub add: &'a mut dyn FnMut(Part, f64),
}

impl Sink for Split<'_> {
    fn element(&mut self, element: &Element<'_>) {
        let n = element.index.len();
        let g = |i: usize| self.motion[element.index[i]];
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                sum += g(i) * element.hessian[i * n + j] * g(j);
            }
        }
        (self.add)(element.part, sum);
    }

    fn damper(&mut self, _: &[usize], _: &[f64], _: &[f64], _: f64) {}
}
