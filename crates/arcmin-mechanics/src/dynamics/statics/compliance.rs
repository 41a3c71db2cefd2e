//! Compliance of contacts on elastic bodies: condensation C = G_e K_e⁻¹ G_eᵀ to the contact points, so that the
//! coordinates of elastic bodies are not unknowns.

use faer::linalg::solvers::Solve;
use faer::{Accum, Mat, MatMut, MatRef, Side};

use crate::dynamics::system::{Contacts, ElasticCoordinates, Evaluation};
use crate::dynamics::{DenseLinearisation, System};
use crate::kernels::{cleared, product};

/// One [contact point](crate::dynamics::system::ElasticPoint) at a state of the model.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PointState {
    /// F⁰, the force at the point in the initial state of the model, and h, the force under which the bodies
    /// are deformed now; in N.
    pub initial_load: f64,
    pub load: f64,
    /// Displacement b by the residual on the elastic coordinates in the initial state, m.
    pub residual_displacement: f64,
    /// F − h in N, and K = Σ k of its contacts in N/m.
    pub unbalanced: f64,
    pub stiffness: f64,
    /// Δh in N of a Newton step, and the resulting displacement C Δh in m.
    pub load_step: f64,
    pub displacement_step: f64,
}

/// Contact points connected by elastic bodies, and the columns on which their contacts depend.
#[derive(Debug, Clone, Default)]
struct Block {
    places: Vec<usize>,
    columns: Vec<usize>,
    /// Coordinates of the bodies, and the gradients of the contact points by these, row by row.
    coordinates: Vec<usize>,
    gradients: Vec<f64>,
    /// C row by row over the contact points, for the rows computed so far.
    compliance: Vec<f64>,
    known: Vec<bool>,
    /// Numbers in the block of loaded points, ā and p̄ over the columns row by row, and (1/K + C)⁻¹ ā column by
    /// column.
    pressed: Vec<usize>,
    means: Vec<f64>,
    pushes: Vec<f64>,
    response: Vec<f64>,
    /// Δh for a step of zero.
    offset: Vec<f64>,
}

/// Compliance between the contacts of one evaluation.
#[derive(Debug, Clone, Default)]
pub(super) struct Compliance {
    pub places: Vec<PointState>,
    blocks: Vec<Block>,
    /// K_e⁻¹ Q_e over all coordinates, and the largest work of Q_e along one unit of scale.
    pub residual_displacement: Vec<f64>,
    pub work: f64,
    displacement: Vec<f64>,
    mean: Vec<f64>,
}

/// Derivative of a contact point's displacement along a displacement of the elastic coordinates.
fn along(contacts: &Contacts, place: usize, displacement: &[f64]) -> f64 {
    let range = contacts.places[place].elastic.clone();
    let terms = contacts.elastic_index[range.clone()].iter().zip(&contacts.elastic_gradient[range]);
    terms.map(|(i, g)| g * displacement[*i]).sum()
}

impl Compliance {
    /// Changes to another evaluation. Compliances are computed for loaded points.
    pub fn set_evaluation<S: System>(&mut self, system: &S, evaluation: &Evaluation) {
        let contacts = &evaluation.contacts;
        let count = contacts.places.len();
        self.places.clear();
        self.places.resize(count, PointState::default());
        self.work = 0.0;
        self.residual_displacement.clear();
        self.residual_displacement.resize(evaluation.force.len(), 0.0);
        self.displacement.resize(evaluation.force.len(), 0.0);
        let elastic = system.elastic();
        for (i, force) in evaluation.force.iter().enumerate() {
            if let Some(elastic) = elastic.filter(|elastic| elastic.has(i)) {
                self.work = self.work.max((force * system.scale()[i]).abs());
                elastic.add_displacements(i, *force, &mut self.residual_displacement);
            }
        }
        for (number, place) in self.places.iter_mut().enumerate() {
            place.residual_displacement = along(contacts, number, &self.residual_displacement);
        }
        self.connect(contacts, elastic);
    }

    /// Divides the contact points into blocks that are not connected by elastic bodies.
    fn connect(&mut self, contacts: &Contacts, elastic: Option<&ElasticCoordinates>) {
        let group = |coordinate: usize| elastic.and_then(|elastic| elastic.group(coordinate));
        let count = elastic.map_or(0, ElasticCoordinates::group_count);
        let mut parent: Vec<usize> = (0..=count).collect();
        fn root(parent: &mut [usize], mut of: usize) -> usize {
            while parent[of] != of {
                parent[of] = parent[parent[of]];
                of = parent[of];
            }
            of
        }
        // Points on a flank without coordinates of its own belong to the last group.
        let first_group = |place: usize| {
            let range = contacts.places[place].elastic.clone();
            contacts.elastic_index[range].first().and_then(|i| group(*i)).unwrap_or(count)
        };
        let mut before = 0..0;
        for place in &contacts.places {
            let index = &contacts.elastic_index[place.elastic.clone()];
            if index == &contacts.elastic_index[before.clone()] {
                continue;
            }
            before = place.elastic.clone();
            let groups: Vec<usize> = index.iter().filter_map(|i| group(*i)).collect();
            for pair in groups.windows(2).filter(|pair| pair[0] != pair[1]) {
                let (one, other) = (root(&mut parent, pair[0]), root(&mut parent, pair[1]));
                parent[one] = other;
            }
        }
        self.blocks.clear();
        let mut block_of = vec![None; parent.len()];
        for place in 0..contacts.places.len() {
            let block = *block_of[root(&mut parent, first_group(place))].get_or_insert_with(|| {
                self.blocks.push(Block::default());
                self.blocks.len() - 1
            });
            self.blocks[block].places.push(place);
        }
        let mut position = vec![0; self.residual_displacement.len()];
        for block in &mut self.blocks {
            for place in &block.places {
                let first = contacts.places[*place].contacts.start;
                block.columns.extend_from_slice(&contacts.index[contacts.list[first].range.clone()]);
            }
            block.columns.sort_unstable();
            block.columns.dedup();
            let mut groups: Vec<usize> = Vec::new();
            for place in &block.places {
                let index = &contacts.elastic_index[contacts.places[*place].elastic.clone()];
                groups.extend(index.iter().filter_map(|i| group(*i)));
            }
            groups.sort_unstable();
            groups.dedup();
            let members = groups.iter().zip(elastic.iter().cycle()).flat_map(|(group, e)| e.members(*group));
            block.coordinates.extend(members);
            block.coordinates.iter().enumerate().for_each(|(at, i)| position[*i] = at);
            let (count, width) = (block.places.len(), block.coordinates.len());
            block.gradients.resize(count * width, 0.0);
            for (row, place) in block.gradients.chunks_exact_mut(width.max(1)).zip(&block.places) {
                let range = contacts.places[*place].elastic.clone();
                let terms =
                    contacts.elastic_index[range.clone()].iter().zip(&contacts.elastic_gradient[range]);
                terms.for_each(|(i, g)| row[position[*i]] += g);
            }
            block.compliance.resize(count * count, 0.0);
            block.known.resize(count, false);
        }
    }

    /// Computes the rows of C for the loaded points of a block.
    fn compute_rows<S: System>(&mut self, system: &S, contacts: &Contacts, block: usize) {
        let Compliance { blocks, displacement, .. } = self;
        let Block { places, coordinates, gradients, compliance, known, pressed, .. } = &mut blocks[block];
        let new: Vec<usize> = pressed.iter().copied().filter(|row| !known[*row]).collect();
        if new.is_empty() {
            return;
        }
        let (count, width) = (places.len(), coordinates.len());
        let mut found = vec![0.0; new.len() * count];
        if let Some(elastic) = system.elastic() {
            // K_e⁻¹ g of every new point, one after the other.
            let mut displacements = Vec::with_capacity(new.len() * width);
            for row in &new {
                let place = &contacts.places[places[*row]];
                for at in place.elastic.clone() {
                    elastic.add_displacements(
                        contacts.elastic_index[at],
                        contacts.elastic_gradient[at],
                        displacement,
                    );
                }
                displacements.extend(coordinates.iter().map(|i| std::mem::take(&mut displacement[*i])));
            }
            product(
                MatMut::from_row_major_slice_mut(&mut found, new.len(), count),
                Accum::Replace,
                MatRef::from_row_major_slice(&displacements, new.len(), width),
                MatRef::from_row_major_slice(gradients, count, width).transpose(),
                1.0,
            );
        }
        for (row, found) in new.iter().zip(found.chunks_exact_mut(count)) {
            known[*row] = true;
            if let Some(one) = &contacts.places[places[*row]].flank {
                for (entry, other) in found.iter_mut().zip(places.iter()) {
                    let flank = contacts.places[*other].flank.as_ref();
                    *entry += flank.map_or(0.0, |other| system.flank_compliance(other, one));
                }
            }
            compliance[row * count..][..count].copy_from_slice(found);
        }
    }

    /// Adds the contribution of contacts on elastic bodies to the matrix and the right-hand side of a Newton
    /// step. `None` if 1/K + C is not positive definite.
    ///
    /// At a point with the forces F = Σ F_i of its contacts, ΔF_i = −k_i (G_i d + C Δh) and F + ΔF = h + Δh.
    /// With K = Σ k, ā = Σ k G/K and p̄ = Σ k P/K this is (1/K + C) Δh = (F − h)/K − ā d − C Δh_o at the loaded
    /// points, with Δh_o = F − h at open ones. The contribution to the matrix is p̄ᵀ (1/K + C)⁻¹ ā + Σ k P (G −
    /// ā)ᵀ of the points.
    pub fn condense<S: System>(
        &mut self,
        system: &S,
        contacts: &Contacts,
        stiffness: &[f64],
        matrix: &mut DenseLinearisation,
        force: &mut [f64],
    ) -> Option<()> {
        (0..self.blocks.len())
            .try_for_each(|block| self.condense_block(system, contacts, block, stiffness, matrix, force))
    }

    fn condense_block<S: System>(
        &mut self,
        system: &S,
        contacts: &Contacts,
        number: usize,
        stiffness: &[f64],
        matrix: &mut DenseLinearisation,
        force: &mut [f64],
    ) -> Option<()> {
        let block = &mut self.blocks[number];
        block.pressed.clear();
        for (row, place) in block.places.iter().enumerate() {
            let state = &mut self.places[*place];
            state.load_step = state.unbalanced;
            if state.stiffness > 0.0 || state.unbalanced != 0.0 {
                block.pressed.push(row);
            }
        }
        self.compute_rows(system, contacts, number);
        let (places, block) = (&self.places, &mut self.blocks[number]);
        let open: Vec<usize> =
            block.pressed.iter().copied().filter(|at| places[block.places[*at]].stiffness <= 0.0).collect();
        block.pressed.retain(|at| places[block.places[*at]].stiffness > 0.0);
        let count = block.places.len();
        let (size, width) = (block.pressed.len(), block.columns.len());
        // ā, p̄ and the right-hand side for a step of zero.
        block.means.clear();
        block.means.resize(size * width, 0.0);
        block.pushes.clear();
        block.pushes.resize(if contacts.has_friction { size * width } else { 0 }, 0.0);
        block.offset.clear();
        for (row, at) in block.pressed.iter().copied().enumerate() {
            let place = block.places[at];
            let PointState { stiffness: whole, unbalanced, .. } = places[place];
            let range = contacts.places[place].contacts.clone();
            let index = &contacts.index[contacts.list[range.start].range.clone()];
            let (mean, columns) = (&mut self.mean, &block.columns);
            let mut add_mean = |of: &[f64], into: &mut [f64]| {
                mean.clear();
                mean.resize(index.len(), 0.0);
                for contact in range.clone().filter(|contact| stiffness[*contact] > 0.0) {
                    let share = stiffness[contact] / whole;
                    let from = &of[contacts.list[contact].range.clone()];
                    mean.iter_mut().zip(from).for_each(|(mean, g)| *mean += share * g);
                }
                for (column, mean) in index.iter().zip(mean.iter()) {
                    // All columns belong to the points.
                    let Ok(at) = columns.binary_search(column) else { continue };
                    into[at] += mean;
                }
            };
            if contacts.has_friction {
                add_mean(&contacts.push, &mut block.pushes[row * width..][..width]);
            }
            add_mean(&contacts.gradient, &mut block.means[row * width..][..width]);
            for contact in range.clone().filter(|contact| range.len() > 1 && stiffness[*contact] > 0.0) {
                let own = contacts.list[contact].range.clone();
                let apart = mean.iter_mut().zip(&contacts.gradient[own.clone()]);
                let apart: Vec<f64> = apart.map(|(mean, g)| g - *mean).collect();
                matrix.add_outer(index, &contacts.push[own], &apart, stiffness[contact]);
            }
            let of_row = &block.compliance[at * count..][..count];
            let by_open: f64 =
                open.iter().map(|other| of_row[*other] * places[block.places[*other]].unbalanced).sum();
            block.offset.push(unbalanced / whole - by_open);
        }
        let pressed = &block.pressed;
        let whole = Mat::from_fn(size, size, |row, column| {
            let own = if row == column { 1.0 / places[block.places[pressed[row]]].stiffness } else { 0.0 };
            block.compliance[pressed[row] * count + pressed[column]] + own
        });
        // C is positive semidefinite except for rounding, which is far below 1/K.
        let factor = cleared(|| whole.llt(Side::Lower)).ok()?;
        // The last column is Δh for a step of zero.
        block.response.clear();
        for column in 0..width {
            block.response.extend((0..size).map(|row| block.means[row * width + column]));
        }
        block.response.extend_from_slice(&block.offset);
        let response = MatMut::from_column_major_slice_mut(&mut block.response, size, width + 1);
        cleared(|| factor.solve_in_place(response));
        // R already contains P (F − F⁰); F + ΔF = h + Δh.
        for (row, at) in block.pressed.iter().enumerate() {
            let more = &mut block.response[width * size + row];
            block.offset[row] = *more;
            *more -= places[block.places[*at]].unbalanced;
        }
        let mut more = Mat::<f64>::zeros(width, width + 1);
        let pushes = MatRef::from_row_major_slice(block.pushes(), size, width);
        let response = MatRef::from_column_major_slice(&block.response, size, width + 1);
        product(more.as_mut(), Accum::Replace, pushes.transpose(), response, 1.0);
        for (at, i) in block.columns.iter().enumerate() {
            force[*i] += more[(at, width)];
            let line = matrix.stiffness_row(*i);
            block.columns.iter().enumerate().for_each(|(other, j)| line[*j] += more[(at, other)]);
        }
        Some(())
    }

    /// Δh and the resulting displacement of every contact point, for a step d.
    pub fn respond(&mut self, step: &[f64]) {
        for block in &self.blocks {
            let count = block.places.len();
            for (row, at) in block.pressed.iter().enumerate() {
                self.places[block.places[*at]].load_step = block.offset[row] - block.along(row, step);
            }
            block.places.iter().for_each(|place| self.places[*place].displacement_step = 0.0);
            for (at, place) in block.places.iter().enumerate() {
                let more = self.places[*place].load_step;
                if more != 0.0 {
                    let row = &block.compliance[at * count..][..count];
                    block
                        .places
                        .iter()
                        .zip(row)
                        .for_each(|(other, c)| self.places[*other].displacement_step += more * c);
                }
            }
        }
    }

    /// Adds the displacements of the elastic coordinates to a step over all coordinates.
    pub fn add_elastic_displacements<S: System>(
        &mut self,
        system: &S,
        contacts: &Contacts,
        step: &mut [f64],
    ) {
        let Some(elastic) = system.elastic() else { return };
        step.iter_mut()
            .zip(&self.residual_displacement)
            .for_each(|(step, displacement)| *step += displacement);
        for (place, state) in contacts.places.iter().zip(&self.places) {
            let more = state.load - state.initial_load;
            for at in place.elastic.clone().filter(|_| more != 0.0) {
                self.displacement[contacts.elastic_index[at]] += more * contacts.elastic_gradient[at];
            }
        }
        for (i, force) in self.displacement.iter_mut().enumerate().filter(|(_, force)| **force != 0.0) {
            elastic.add_displacements(i, std::mem::take(force), step);
        }
    }
}

impl Block {
    /// p̄ row by row.
    fn pushes(&self) -> &[f64] {
        if self.pushes.is_empty() { &self.means } else { &self.pushes }
    }

    /// (1/K + C)⁻¹ ā d of one place.
    fn along(&self, row: usize, step: &[f64]) -> f64 {
        let columns = self.columns.iter().enumerate();
        columns.map(|(at, column)| self.response[at * self.pressed.len() + row] * step[*column]).sum()
    }
}
