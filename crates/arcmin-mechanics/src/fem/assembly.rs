//! Global stiffness and mass matrices with bores held or tied to rigid spiders.

use std::convert::Infallible;

use faer::{MatMut, MatRef};

use super::elements::{mass_t6, mass_tet10, stiffness_t6, stiffness_tet10};
use super::{ElementKind, FemError, Mesh};
use crate::geometry::Vec2;
use crate::materials::Material;

/// Marks a displacement that is held at zero.
pub const HELD: usize = usize::MAX;

/// Support of a bore's surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoreTie {
    /// A free surface.
    Free,
    /// Every component of every node is zero.
    Clamped,
    /// A rigid spider in the plane: the nodes follow a master at the bore's centre with two translations and a
    /// rotation; the axial displacement is free.
    Spider {
        /// Both translations of the master.
        translation: MasterMotion,
        /// Rotation of the master.
        rotation: MasterMotion,
    },
}

/// Treatment of a degree of freedom of a spider's master.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MasterMotion {
    /// Zero.
    Held,
    /// A normal unknown.
    Free,
    /// An unknown numbered last, which a reduction retains as an interface coordinate.
    Retained,
}

/// A bore of the mesh and its tie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TiedBore {
    /// Index of the curve in the plane mesh.
    pub boundary: usize,
    /// Axis of the bore, m.
    pub centre: Vec2,
    /// m.
    pub radius: f64,
    /// Support of its surface.
    pub tie: BoreTie,
}

/// Each nodal displacement as a combination of at most two unknowns: u = Σ coefficient × unknown.
#[derive(Debug, Clone)]
pub struct DofMap {
    /// Number of unknowns; the retained ones are the last `retained`.
    pub count: usize,
    /// Number of unknowns that a reduction retains.
    pub retained: usize,
    dimension: usize,
    terms: Vec<[(usize, f64); 2]>,
    /// Unknowns x, y, θ of each bore's master; [`HELD`] where there is none.
    masters: Vec<[usize; 3]>,
}

const NOTHING: [(usize, f64); 2] = [(HELD, 0.0), (HELD, 0.0)];

impl DofMap {
    /// Numbers the unknowns. Rotations of masters are measured as displacement at the bore's radius (m),
    /// which keeps the matrices well scaled.
    pub fn new(mesh: &Mesh, bores: &[TiedBore]) -> DofMap {
        let dimension = mesh.kind.dimension();
        let mut owner: Vec<Option<usize>> = vec![None; mesh.nodes.len()];
        for (index, bore) in bores.iter().enumerate().filter(|(_, bore)| bore.tie != BoreTie::Free) {
            for node in mesh.columns_of(&mesh.plane.nodes_of(bore.boundary)) {
                owner[node] = Some(index);
            }
        }
        let on_middle_plane = |node: usize| mesh.half_width && node < mesh.plane.nodes.len();
        let mut terms = vec![NOTHING; mesh.nodes.len() * dimension];
        let mut count = 0;
        let mut next = || {
            count += 1;
            count - 1
        };
        for node in 0..mesh.nodes.len() {
            for component in 0..dimension {
                let tied = match owner[node].map(|bore| bores[bore].tie) {
                    None | Some(BoreTie::Free) => false,
                    Some(BoreTie::Clamped) => true,
                    Some(BoreTie::Spider { .. }) => component < 2,
                };
                let held = component == 2 && on_middle_plane(node);
                if !tied && !held {
                    terms[node * dimension + component] = [(next(), 1.0), (HELD, 0.0)];
                }
            }
        }
        let mut masters = vec![[HELD; 3]; bores.len()];
        let mut retained = 0;
        for wanted in [MasterMotion::Free, MasterMotion::Retained] {
            for (master, bore) in masters.iter_mut().zip(bores) {
                let BoreTie::Spider { translation, rotation } = bore.tie else { continue };
                for (coordinate, motion) in master.iter_mut().zip([translation, translation, rotation]) {
                    if motion == wanted {
                        *coordinate = next();
                        retained += usize::from(wanted == MasterMotion::Retained);
                    }
                }
            }
        }
        for (node, owner) in owner.iter().enumerate() {
            let Some(index) = *owner else { continue };
            let (bore, master) = (&bores[index], masters[index]);
            if let BoreTie::Spider { .. } = bore.tie {
                let arm = (Vec2::new(mesh.nodes[node][0], mesh.nodes[node][1]) - bore.centre) / bore.radius;
                terms[node * dimension] = [(master[0], 1.0), (master[2], -arm.y)];
                terms[node * dimension + 1] = [(master[1], 1.0), (master[2], arm.x)];
            }
        }
        DofMap { count, retained, dimension, terms, masters }
    }

    /// Every displacement of a node that belongs to an element is an unknown, except the components in `held`.
    pub fn of_body(mesh: &Mesh, held: &[[bool; 3]]) -> DofMap {
        let dimension = mesh.kind.dimension();
        let mut used = vec![false; mesh.nodes.len()];
        mesh.connectivity.iter().for_each(|node| used[*node] = true);
        let mut terms = vec![NOTHING; mesh.nodes.len() * dimension];
        let mut count = 0;
        for node in (0..mesh.nodes.len()).filter(|node| used[*node]) {
            for component in (0..dimension).filter(|component| !held[node][*component]) {
                terms[node * dimension + component] = [(count, 1.0), (HELD, 0.0)];
                count += 1;
            }
        }
        DofMap { count, retained: 0, dimension, terms, masters: Vec::new() }
    }

    /// A displacement component of a node in terms of the unknowns; entries of [`HELD`] vanish.
    pub fn terms(&self, node: usize, component: usize) -> [(usize, f64); 2] {
        self.terms[node * self.dimension + component]
    }

    /// Displacement of every node for a vector of unknowns.
    pub fn expand(&self, unknowns: &[f64]) -> Vec<[f64; 3]> {
        self.terms
            .chunks_exact(self.dimension)
            .map(|node| {
                let mut u = [0.0; 3];
                for (value, terms) in u.iter_mut().zip(node) {
                    *value =
                        terms.iter().filter(|(dof, _)| *dof != HELD).map(|(dof, c)| c * unknowns[*dof]).sum();
                }
                u
            })
            .collect()
    }

    /// Adds a nodal force to a vector of generalised forces.
    pub fn add_force(&self, forces: &mut [f64], node: usize, component: usize, force: f64) {
        for (dof, coefficient) in self.terms(node, component).into_iter().filter(|(dof, _)| *dof != HELD) {
            forces[dof] += coefficient * force;
        }
    }

    /// The vector of unknowns of a displacement field given at free nodes (without spiders): for patch tests.
    pub fn sample(&self, mesh: &Mesh, field: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<f64> {
        let mut unknowns = vec![0.0; self.count];
        for (node, terms) in self.terms.chunks_exact(self.dimension).enumerate() {
            let u = field(mesh.nodes[node]);
            for (component, [(dof, _), (other, _)]) in terms.iter().enumerate() {
                if *dof != HELD && *other == HELD {
                    unknowns[*dof] = u[component];
                }
            }
        }
        unknowns
    }
}

impl DofMap {
    /// The vector of unknowns of a rigid motion in the plane with rates (x, y, θ): θ about the origin.
    pub fn rigid_motion(&self, mesh: &Mesh, bores: &[TiedBore], rates: [f64; 3]) -> Vec<f64> {
        let [x, y, turn] = rates;
        let mut unknowns = self.sample(mesh, |p| [x - turn * p[1], y + turn * p[0], 0.0]);
        for (bore, master) in bores.iter().zip(&self.masters) {
            let motion = [x - turn * bore.centre.y, y + turn * bore.centre.x, turn * bore.radius];
            for (dof, value) in master.iter().zip(motion).filter(|(dof, _)| **dof != HELD) {
                unknowns[*dof] = value;
            }
        }
        unknowns
    }
}

/// A symmetric sparse matrix: its lower triangle with the diagonal, column by column, rows ascending.
#[derive(Debug, Clone)]
pub struct SymmetricMatrix {
    /// Number of rows and columns.
    pub order: usize,
    /// Index of the first entry of every column in `rows` and `values`, and their length at the end.
    pub column_start: Vec<usize>,
    /// Row of every entry.
    pub rows: Vec<usize>,
    /// Values of the entries, N/m or kg.
    pub values: Vec<f64>,
}

impl SymmetricMatrix {
    /// y = A x for several columns.
    pub fn multiply(&self, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>) {
        y.fill(0.0);
        for k in 0..x.ncols() {
            let (Some(x), Some(y)) =
                (x.col(k).try_as_col_major(), y.as_mut().col_mut(k).try_as_col_major_mut())
            else {
                unreachable!("column-major matrices only");
            };
            self.add_product(x.as_slice(), y.as_slice_mut());
        }
    }

    /// y += A x.
    pub fn add_product(&self, x: &[f64], y: &mut [f64]) {
        for column in 0..self.order {
            let range = self.column_start[column]..self.column_start[column + 1];
            let xc = x[column];
            let mut sum = 0.0;
            for (row, value) in self.rows[range.clone()].iter().zip(&self.values[range]) {
                if *row == column {
                    sum += value * xc;
                } else {
                    y[*row] += value * xc;
                    sum += value * x[*row];
                }
            }
            y[column] += sum;
        }
    }

    /// A x.
    pub fn product(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; self.order];
        self.add_product(x, &mut y);
        y
    }

    /// The leading block of the first `order` rows and columns.
    pub fn leading(&self, order: usize) -> SymmetricMatrix {
        let mut block =
            SymmetricMatrix { order, column_start: vec![0], rows: Vec::new(), values: Vec::new() };
        for column in 0..order {
            for k in self.column_start[column]..self.column_start[column + 1] {
                if self.rows[k] < order {
                    block.rows.push(self.rows[k]);
                    block.values.push(self.values[k]);
                }
            }
            block.column_start.push(block.rows.len());
        }
        block
    }

    /// A + σ B for a matrix of the same pattern.
    pub fn shifted(&self, sigma: f64, other: &SymmetricMatrix) -> SymmetricMatrix {
        let mut sum = self.clone();
        sum.values.iter_mut().zip(&other.values).for_each(|(a, b)| *a += sigma * b);
        sum
    }
}

/// Stiffness in N/m.
///
/// # Errors
/// [`FemError::InvertedElement`] where an element's Jacobian determinant is not positive.
pub fn stiffness(mesh: &Mesh, material: &Material, map: &DofMap) -> Result<SymmetricMatrix, FemError> {
    let size = mesh.kind.nodes_per_element() * mesh.kind.dimension();
    assemble(mesh, map, |element| {
        let (k, determinant) = match mesh.kind {
            ElementKind::T6 => {
                let (k, determinant) =
                    stiffness_t6(&mesh.element_nodes::<6>(element), material, mesh.thickness);
                (k.to_vec(), determinant)
            }
            ElementKind::Tet10 => {
                let (k, determinant) = stiffness_tet10(&mesh.element_nodes::<10>(element), material);
                (k.to_vec(), determinant)
            }
        };
        if determinant.is_nan() || determinant <= 0.0 {
            return Err(FemError::InvertedElement { element, determinant });
        }
        Ok(move |i: usize, j: usize| k[i * size + j])
    })
}

/// Consistent mass in kg, on the pattern of the [`stiffness`].
pub fn mass(mesh: &Mesh, material: &Material, map: &DofMap) -> SymmetricMatrix {
    let (npe, dimension) = (mesh.kind.nodes_per_element(), mesh.kind.dimension());
    let Ok(mass) = assemble(mesh, map, |element| {
        let density = material.density;
        let m = match mesh.kind {
            ElementKind::T6 => mass_t6(&mesh.element_nodes::<6>(element), density, mesh.thickness).to_vec(),
            ElementKind::Tet10 => mass_tet10(&mesh.element_nodes::<10>(element), density).to_vec(),
        };
        // An acceleration along an axis causes a force along that axis only.
        Ok::<_, Infallible>(move |i: usize, j: usize| {
            if i % dimension == j % dimension { m[i / dimension * npe + j / dimension] } else { 0.0 }
        })
    });
    mass
}

/// The sum of the matrices of all elements, each given by its entries in the element's own displacements.
fn assemble<Entry: Fn(usize, usize) -> f64, Error>(
    mesh: &Mesh,
    map: &DofMap,
    of_element: impl Fn(usize) -> Result<Entry, Error>,
) -> Result<SymmetricMatrix, Error> {
    let element_unknowns = element_unknowns(mesh, map);
    let mut matrix = pattern(&element_unknowns, map.count);
    let (npe, dimension) = (mesh.kind.nodes_per_element(), mesh.kind.dimension());
    for (element, unknowns) in element_unknowns.iter().enumerate() {
        let entry = of_element(element)?;
        let nodes = &mesh.connectivity[element * npe..(element + 1) * npe];
        // Unknowns of each local displacement as positions in the element's sorted list.
        let local: Vec<[(usize, f64); 2]> = (0..npe * dimension)
            .map(|i| {
                map.terms(nodes[i / dimension], i % dimension).map(|(dof, c)| {
                    if dof == HELD { (HELD, 0.0) } else { (unknowns.binary_search(&dof).unwrap_or(HELD), c) }
                })
            })
            .collect();
        let count = unknowns.len();
        let mut dense = vec![0.0; count * count];
        for (i, row) in local.iter().enumerate() {
            for (a, ca) in row.iter().filter(|(a, _)| *a != HELD) {
                for (j, column) in local.iter().enumerate() {
                    for (b, cb) in column.iter().filter(|(b, _)| *b != HELD) {
                        dense[b * count + a] += ca * cb * entry(i, j);
                    }
                }
            }
        }
        for (b, column) in unknowns.iter().enumerate() {
            let mut position = matrix.column_start[*column];
            let end = matrix.column_start[*column + 1];
            for (a, row) in unknowns.iter().enumerate().skip(b) {
                position += matrix.rows[position..end].partition_point(|r| r < row);
                matrix.values[position] += dense[b * count + a];
            }
        }
    }
    Ok(matrix)
}

/// The distinct unknowns of every element, ascending.
fn element_unknowns(mesh: &Mesh, map: &DofMap) -> Vec<Vec<usize>> {
    mesh.elements()
        .map(|nodes| {
            let mut unknowns: Vec<usize> = nodes
                .iter()
                .flat_map(|node| (0..mesh.kind.dimension()).flat_map(move |c| map.terms(*node, c)))
                .filter(|(dof, _)| *dof != HELD)
                .map(|(dof, _)| dof)
                .collect();
            unknowns.sort_unstable();
            unknowns.dedup();
            unknowns
        })
        .collect()
}

/// The pattern of the lower triangle, values zero.
fn pattern(element_unknowns: &[Vec<usize>], order: usize) -> SymmetricMatrix {
    let mut start = vec![0usize; order + 1];
    element_unknowns.iter().flatten().for_each(|dof| start[dof + 1] += 1);
    for i in 0..order {
        start[i + 1] += start[i];
    }
    let mut fill = start.clone();
    let mut incident = vec![0usize; start[order]];
    for (element, unknowns) in element_unknowns.iter().enumerate() {
        for dof in unknowns {
            incident[fill[*dof]] = element;
            fill[*dof] += 1;
        }
    }
    let mut column_start = Vec::with_capacity(order + 1);
    column_start.push(0);
    let mut rows: Vec<usize> = Vec::new();
    let mut seen = vec![usize::MAX; order];
    for column in 0..order {
        let first = rows.len();
        for element in &incident[start[column]..start[column + 1]] {
            let unknowns = &element_unknowns[*element];
            for row in &unknowns[unknowns.partition_point(|row| *row < column)..] {
                if seen[*row] != column {
                    seen[*row] = column;
                    rows.push(*row);
                }
            }
        }
        rows[first..].sort_unstable();
        column_start.push(rows.len());
    }
    let values = vec![0.0; rows.len()];
    SymmetricMatrix { order, column_start, rows, values }
}
