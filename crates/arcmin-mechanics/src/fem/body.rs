//! Elastic bodies extruded layer by layer: stiffness between their seats.
//!
//! A body is defined by a section with all its outlines, layers that are solid in some regions of the section,
//! and held nodes. Other bodies act on its *seats*: parts of a curve over some layers with a traction of given
//! shape. The generalised force F_k scales the traction t_k, and its displacement is the mean u_k = ∫ t_k·u dA
//! per unit of F_k, so that u = C F with a symmetric C = fᵀ K⁻¹ f. No seat is rigid: a rim under rollers may
//! ovalise. Linear elastic, small displacements, Tet10.

use faer::Mat;

use super::assembly::{self, HELD};
use super::elements::{gradient_edge, gradient_t6, shape_edge, shape_t6};
use super::quadrature::{LINE_4, TRIANGLE_6};
use super::solve::{Cholesky, ModeRange, lowest_modes};
use super::{DofMap, ElementKind, FemError, Mesh, MeshQuality};
use crate::geometry::Vec2;
use crate::materials::Material;

/// Shape of a traction on a cylindrical seat, about its axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Traction {
    /// Radial, cos(n(φ − `from`))/(π r w), φ the angle about the axis. n = 1 is a unit force along `from`, its
    /// displacement the mean of the seat in that direction. For n > 1 the displacement is the Fourier
    /// coefficient of the radial displacement, so that a roller's force Q at ψ contributes Q cos(n(ψ −
    /// `from`)).
    Radial {
        /// n from 1.
        order: usize,
        /// Direction in rad about the axis of the seat.
        from: f64,
    },
    /// Radial and uniform, 1/(2π r w): the mean radial displacement.
    Expansion,
    /// Tangential and uniform, 1/(2π r² w): a unit torque, the mean rotation of the seat.
    Twist,
    /// Normal to a groove that extends `reach` to either side of its `bottom`, as from a pin without clearance:
    /// a unit force towards the bottom with a cosine pressure, or `across` the groove with a sine traction,
    /// pressure on one half and tension on the other.
    Groove {
        /// Direction of the bottom in rad about the axis of the groove.
        bottom: f64,
        /// Angle in rad.
        reach: f64,
        /// Whether the force acts across the groove, perpendicular to the direction of the bottom.
        across: bool,
    },
}

impl Traction {
    /// The traction in 1/m² (1/m³ for a torque) at the angle φ, radial and tangential parts.
    fn at(self, angle: f64, radius: f64, width: f64) -> [f64; 2] {
        let area = std::f64::consts::PI * radius * width;
        match self {
            Traction::Radial { order, from } => [(order as f64 * (angle - from)).cos() / area, 0.0],
            Traction::Expansion => [0.5 / area, 0.0],
            Traction::Twist => [0.0, 0.5 / (area * radius)],
            Traction::Groove { bottom, reach, across } => {
                let (sin, cos) = (angle - bottom).sin_cos();
                let lost = 0.5 * (2.0 * reach).sin();
                let (shape, share) = if across { (sin, reach - lost) } else { (cos, reach + lost) };
                [shape / (share * radius * width), 0.0]
            }
        }
    }
}

impl Traction {
    /// The traction at a point of a seat.
    fn around(self, seat: &Seat, point: Vec2, width: f64) -> Vec2 {
        let arm = point - seat.centre;
        let e = arm.normalize();
        let [radial, tangential] = self.at(arm.y.atan2(arm.x), seat.radius, width);
        radial * e + tangential * crate::geometry::quarter_turn(e)
    }
}

/// A loaded cylindrical surface: the edges of a curve between two parameters, over some layers.
#[derive(Debug, Clone, PartialEq)]
pub struct Seat {
    /// Index of the curve in the section.
    pub curve: usize,
    /// Range of curve parameters; the whole curve for infinite ends.
    pub parameters: [f64; 2],
    /// Layers of elements that the seat spans.
    pub layers: std::ops::Range<usize>,
    /// Axis in m.
    pub centre: Vec2,
    /// Radius in m.
    pub radius: f64,
}

impl Seat {
    /// The whole of a curve.
    pub fn around(curve: usize, layers: std::ops::Range<usize>, centre: Vec2, radius: f64) -> Seat {
        Seat { curve, parameters: [f64::NEG_INFINITY, f64::INFINITY], layers, centre, radius }
    }
}

/// Consistent nodal forces of a unit load: (node, component, force).
pub type NodalLoad = Vec<(usize, usize, f64)>;

/// A meshed and factorised body.
pub struct Body {
    /// Mesh of the body or of its symmetric part.
    pub mesh: Mesh,
    /// Bits of the curves around every triangle of the section.
    pub regions: Vec<u64>,
    /// Elastic constants and density.
    pub material: Material,
    map: DofMap,
    factor: Cholesky,
}

/// Compliance between interface coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Compliance {
    /// Number of interface coordinates.
    pub count: usize,
    /// C in m/N (or the units of torque and angle), row by row.
    pub values: Vec<f64>,
}

impl Compliance {
    /// Displacement of coordinate i under a unit force on coordinate j.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.values[i * self.count + j]
    }

    /// Displacements of all coordinates under the generalised forces.
    pub fn displacements(&self, forces: &[f64]) -> Vec<f64> {
        self.values
            .chunks_exact(self.count)
            .map(|row| row.iter().zip(forces).map(|(c, f)| c * f).sum())
            .collect()
    }

    /// Elastic energy ½ Fᵀ C F in J.
    pub fn energy(&self, forces: &[f64]) -> f64 {
        0.5 * self.displacements(forces).iter().zip(forces).map(|(u, f)| u * f).sum::<f64>()
    }

    /// The same body of a material `factor` times stiffer.
    pub fn stiffened(&self, factor: f64) -> Compliance {
        Compliance { count: self.count, values: self.values.iter().map(|c| c / factor).collect() }
    }

    /// K = C⁻¹ for the listed coordinates, with zero force on the others; row by row.
    ///
    /// # Errors
    /// [`FemError::Factorisation`] if the listed coordinates depend on each other.
    pub fn stiffness(&self, coordinates: &[usize]) -> Result<Vec<f64>, FemError> {
        let n = coordinates.len();
        let block = nalgebra::DMatrix::from_fn(n, n, |i, j| self.at(coordinates[i], coordinates[j]));
        let inverse = block.cholesky().map(|factor| factor.inverse());
        inverse.map(|inverse| inverse.iter().copied().collect()).ok_or(FemError::Factorisation {
            unknowns: n,
            reason: "interface coordinates depend on each other".to_owned(),
        })
    }
}

impl Body {
    /// Assembles and factorises; `held` lists the displacement components that are zero.
    ///
    /// # Errors
    /// [`FemError`] if an element is inverted or the body is not held.
    pub fn new(
        mesh: Mesh,
        regions: Vec<u64>,
        material: Material,
        held: &[[bool; 3]],
    ) -> Result<Body, FemError> {
        let map = DofMap::of_body(&mesh, held);
        let factor = Cholesky::new(&assembly::stiffness(&mesh, &material, &map)?)?;
        Ok(Body { mesh, regions, material, map, factor })
    }

    /// Quality of the mesh, with the number of unknowns of the factorised system.
    pub fn quality(&self) -> MeshQuality {
        MeshQuality { unknowns: self.map.count, ..self.mesh.quality() }
    }

    /// Consistent nodal forces of a unit load on a seat.
    pub fn load(&self, seat: &Seat, traction: Traction) -> NodalLoad {
        seat_load(&self.mesh, seat, traction)
    }

    fn unknown(&self, node: usize, component: usize) -> Option<usize> {
        let [(dof, _), _] = self.map.terms(node, component);
        (dof != HELD).then_some(dof)
    }

    /// Displacements under unit loads, one column of unknowns each.
    fn respond(&self, loads: &[NodalLoad]) -> Mat<f64> {
        let mut columns: Mat<f64> = Mat::zeros(self.map.count, loads.len());
        for (k, load) in loads.iter().enumerate() {
            for (node, component, force) in load {
                if let Some(dof) = self.unknown(*node, *component) {
                    columns[(dof, k)] += force;
                }
            }
        }
        self.factor.solve(columns.as_mut());
        columns
    }

    fn read(&self, load: &NodalLoad, response: &[f64]) -> f64 {
        load.iter()
            .filter_map(|(node, component, force)| Some(force * response[self.unknown(*node, *component)?]))
            .sum()
    }

    /// C of the loads.
    pub fn compliance(&self, loads: &[NodalLoad]) -> Compliance {
        let all: Vec<usize> = (0..loads.len()).collect();
        let rows = self.rows(loads, &all);
        let count = loads.len();
        let mut values = vec![0.0; count * count];
        for i in 0..count {
            for j in 0..count {
                values[i * count + j] = 0.5 * (rows[i][j] + rows[j][i]);
            }
        }
        Compliance { count, values }
    }

    /// Displacements of all loads' coordinates under some of them, one row each.
    pub fn rows(&self, loads: &[NodalLoad], under: &[usize]) -> Vec<Vec<f64>> {
        const BLOCK: usize = 32;
        let mut rows = Vec::with_capacity(under.len());
        for block in under.chunks(BLOCK) {
            let chosen: Vec<NodalLoad> = block.iter().map(|k| loads[*k].clone()).collect();
            let columns = self.respond(&chosen);
            for k in 0..block.len() {
                rows.push(loads.iter().map(|load| self.read(load, columns.col_as_slice(k))).collect());
            }
        }
        rows
    }

    /// Lowest natural frequencies in Hz of the held body.
    ///
    /// # Errors
    /// [`FemError::Modes`] if they do not converge.
    pub fn frequencies(&self, count: usize) -> Result<Vec<f64>, FemError> {
        let mass = assembly::mass(&self.mesh, &self.material, &self.map);
        Ok(lowest_modes(&mass, &self.factor, 0.0, ModeRange::Count(count))?.frequencies())
    }

    /// K u for a displacement field given at every node: inner forces, which are zero inside a body under
    /// constant strain.
    #[cfg(test)]
    pub(super) fn inner_forces(&self, field: impl Fn([f64; 3]) -> [f64; 3]) -> (DofMap, Vec<f64>) {
        let unknowns = self.map.sample(&self.mesh, field);
        let stiffness = assembly::stiffness(&self.mesh, &self.material, &self.map).unwrap();
        (self.map.clone(), stiffness.product(&unknowns))
    }
}

/// ∫ N t dA over the faces of the elements on a seat, or over the edges of a plane mesh. Every quadrilateral
/// between two levels consists of two T6 triangles, divided like the elements behind them.
pub(super) fn seat_load(mesh: &Mesh, seat: &Seat, traction: Traction) -> NodalLoad {
    let [low, high] = seat.parameters;
    let edges = mesh.plane.edges_of(seat.curve).filter(|e| e.parameters[2] > low && e.parameters[2] < high);
    let mut load: std::collections::BTreeMap<(usize, usize), f64> = std::collections::BTreeMap::new();
    if mesh.kind == ElementKind::T6 {
        edges.for_each(|edge| add_edge(mesh, seat, traction, edge.nodes, &mut load));
        return load.into_iter().map(|((node, component), force)| (node, component, force)).collect();
    }
    let per_level = mesh.plane.nodes.len();
    let width = mesh.levels[2 * seat.layers.end] - mesh.levels[2 * seat.layers.start];
    for edge in edges {
        let [a, b, middle] = edge.nodes;
        let (first, last) = (a.min(b), a.max(b));
        for layer in seat.layers.clone() {
            let at = |node: usize, half: usize| (2 * layer + half) * per_level + node;
            let (lower, upper) = (0, 2);
            let faces = [
                [
                    at(first, lower),
                    at(last, lower),
                    at(last, upper),
                    at(middle, lower),
                    at(last, 1),
                    at(middle, 1),
                ],
                [
                    at(first, lower),
                    at(last, upper),
                    at(first, upper),
                    at(middle, 1),
                    at(middle, upper),
                    at(first, 1),
                ],
            ];
            for face in faces {
                add_face(mesh, seat, traction, width, &face, &mut load);
            }
        }
    }
    load.into_iter().map(|((node, component), force)| (node, component, force)).collect()
}

/// Nodes: two ends, then the middle.
fn add_edge(
    mesh: &Mesh,
    seat: &Seat,
    traction: Traction,
    nodes: [usize; 3],
    load: &mut std::collections::BTreeMap<(usize, usize), f64>,
) {
    let places = nodes.map(|node| mesh.plane.nodes[node]);
    for (at, weight) in LINE_4 {
        let (shape, slope) = (shape_edge(at), gradient_edge(at));
        let (mut point, mut along) = (Vec2::zeros(), Vec2::zeros());
        for i in 0..3 {
            point += shape[i] * places[i];
            along += slope[i] * places[i];
        }
        let area = weight * along.norm() * mesh.thickness;
        let t = traction.around(seat, point, mesh.thickness);
        for i in 0..3 {
            *load.entry((nodes[i], 0)).or_insert(0.0) += area * shape[i] * t.x;
            *load.entry((nodes[i], 1)).or_insert(0.0) += area * shape[i] * t.y;
        }
    }
}

fn add_face(
    mesh: &Mesh,
    seat: &Seat,
    traction: Traction,
    width: f64,
    face: &[usize; 6],
    load: &mut std::collections::BTreeMap<(usize, usize), f64>,
) {
    let places = face.map(|node| nalgebra::Vector3::from(mesh.nodes[node]));
    for (at, weight) in TRIANGLE_6 {
        let (shape, slope) = (shape_t6(at), gradient_t6(at));
        let mut point = nalgebra::Vector3::zeros();
        let mut along = [nalgebra::Vector3::zeros(); 2];
        for i in 0..6 {
            point += shape[i] * places[i];
            along[0] += slope[i][0] * places[i];
            along[1] += slope[i][1] * places[i];
        }
        let area = weight * along[0].cross(&along[1]).norm();
        let t = traction.around(seat, Vec2::new(point.x, point.y), width);
        for i in 0..6 {
            *load.entry((face[i], 0)).or_insert(0.0) += area * shape[i] * t.x;
            *load.entry((face[i], 1)).or_insert(0.0) += area * shape[i] * t.y;
        }
    }
}
