//! Meshes of six-node triangles and ten-node tetrahedra, and figures of their quality.

use super::elements::{TET_EDGES, mass_tet10, physical_gradient_t6, physical_gradient_tet10};
use super::quadrature::TETRAHEDRON_15;
use super::{FemError, PlaneMesh};
use crate::geometry::Vec2;

/// Element of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ElementKind {
    /// Plane stress, thickness in [`Mesh::thickness`].
    T6,
    /// Ten-node tetrahedra of a solid.
    Tet10,
}

impl ElementKind {
    /// Corner and mid-side nodes of one element.
    pub fn nodes_per_element(self) -> usize {
        match self {
            ElementKind::T6 => 6,
            ElementKind::Tet10 => 10,
        }
    }

    /// Displacement components per node.
    pub fn dimension(self) -> usize {
        match self {
            ElementKind::T6 => 2,
            ElementKind::Tet10 => 3,
        }
    }
}

/// A finite element mesh, plane or extruded from a plane one.
///
/// Node k of the plane mesh on level l of an extruded mesh has the index l·(plane nodes) + k; levels are half
/// a layer apart.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// Element type of the whole mesh.
    pub kind: ElementKind,
    /// m; z is 0 in plane meshes.
    pub nodes: Vec<[f64; 3]>,
    /// [`ElementKind::nodes_per_element`] entries per element.
    pub connectivity: Vec<usize>,
    /// Face width B in m that the model represents.
    pub thickness: f64,
    /// The plane mesh it came from.
    pub plane: PlaneMesh,
    /// z of the node levels in m; `[0]` for plane meshes.
    pub levels: Vec<f64>,
    /// Whether only the half 0 ≤ z ≤ B/2 is meshed, with u_z = 0 on the middle plane z = 0.
    pub half_width: bool,
}

/// Figures of quality of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshQuality {
    /// Nodes, mid-side ones included.
    pub nodes: usize,
    /// Triangles or tetrahedra.
    pub elements: usize,
    /// Displacement components of all nodes; of a body those that are not held.
    pub unknowns: usize,
    /// Smallest corner angle of the (straight) triangles in degrees.
    pub smallest_angle_deg: f64,
    /// Largest ratio of circumradius to twice the inradius of the (straight) triangles; 1 for equilateral
    /// ones.
    pub largest_aspect: f64,
    /// Smallest over all elements of min det J / max det J over the element's corners; 1 for straight
    /// elements.
    pub smallest_jacobian_ratio: f64,
}

/// Least relative Jacobian determinant at a quadrature point of an element drawn towards an edge. Elements at
/// straight edges have at least 0.035; elements with smaller values give wrong results although they are not
/// inverted.
const FLAT: f64 = 0.005;

impl Mesh {
    /// A plane mesh as it is, for plane stress over a thickness in m.
    pub fn plane_stress(plane: PlaneMesh, thickness: f64) -> Mesh {
        Mesh {
            kind: ElementKind::T6,
            nodes: plane.nodes.iter().map(|p| [p.x, p.y, 0.0]).collect(),
            connectivity: plane.triangles.iter().flatten().copied().collect(),
            thickness,
            plane,
            levels: vec![0.0],
            half_width: false,
        }
    }

    /// Extrudes through the width B, or, with `half_width`, from the middle plane to one face.
    ///
    /// Every triangle becomes `layers` prisms, every prism three tetrahedra. Each quadrilateral side is cut by the
    /// diagonal from its lower corner of smaller index, so neighbours are compatible (Dompierre et al. 1999). All
    /// mid-side nodes then fall on the nodes of the plane mesh at whole and half layers.
    pub fn extruded(plane: PlaneMesh, thickness: f64, layers: usize, half_width: bool) -> Mesh {
        let height = if half_width { 0.5 * thickness } else { thickness };
        let bottom = if half_width { 0.0 } else { -0.5 * thickness };
        let level_count = 2 * layers + 1;
        let levels: Vec<f64> =
            (0..level_count).map(|l| bottom + height * l as f64 / (2 * layers) as f64).collect();
        let per_level = plane.nodes.len();
        let nodes = levels.iter().flat_map(|z| plane.nodes.iter().map(move |p| [p.x, p.y, *z])).collect();
        let mut connectivity = Vec::with_capacity(plane.triangles.len() * layers * 30);
        for layer in 0..layers {
            for triangle in &plane.triangles {
                for tetrahedron in split_prism(triangle) {
                    connectivity.extend(
                        tet10_nodes(triangle, tetrahedron)
                            .map(|(node, half)| (2 * layer + half) * per_level + node),
                    );
                }
            }
        }
        Mesh { kind: ElementKind::Tet10, nodes, connectivity, thickness, plane, levels, half_width }
    }

    /// Extrudes a section layer by layer between the heights `cuts` (m, ascending), each of which takes part only
    /// where `present(layer, triangle)`: plate, pillars, plate. Nodes without an element remain in the list to keep
    /// the order of levels; they have no stiffness.
    pub fn layered(plane: PlaneMesh, cuts: &[f64], present: impl Fn(usize, usize) -> bool) -> Mesh {
        let mut levels: Vec<f64> = cuts.windows(2).flat_map(|c| [c[0], 0.5 * (c[0] + c[1])]).collect();
        levels.extend(cuts.last());
        let per_level = plane.nodes.len();
        let nodes = levels.iter().flat_map(|z| plane.nodes.iter().map(move |p| [p.x, p.y, *z])).collect();
        let mut connectivity = Vec::new();
        for layer in 0..cuts.len().saturating_sub(1) {
            for (index, triangle) in plane.triangles.iter().enumerate() {
                if !present(layer, index) {
                    continue;
                }
                for tetrahedron in split_prism(triangle) {
                    connectivity.extend(
                        tet10_nodes(triangle, tetrahedron)
                            .map(|(node, half)| (2 * layer + half) * per_level + node),
                    );
                }
            }
        }
        let thickness = levels.last().unwrap_or(&0.0) - levels.first().unwrap_or(&0.0);
        Mesh { kind: ElementKind::Tet10, nodes, connectivity, thickness, plane, levels, half_width: false }
    }

    /// Draws the mid-side nodes of all edges that leave a sharp edge of the solid, whose nodes are marked, to a
    /// quarter of their length from it. Displacements of such elements contain √r, the behaviour of a solid at the
    /// rim of a clamped face (r^½ except for an oscillation next to the rim) and at a reentrant right angle
    /// (r^0.545); there the energy error of other elements is of first order in their size. In walls hardly wider
    /// than an element the result becomes worse, since quadratic bending is lost. Nodes of elements that would be
    /// inverted or flattened are drawn less far. Sources: Henshell & Shaw, Int. J. Numer. Meth. Eng. 9 (1975) 495;
    /// Barsoum, ibid. 10 (1976) 25; exponents: Williams, J. Appl. Mech. 19 (1952) 526.
    #[must_use]
    pub fn drawn_towards(self, sharp: &[bool]) -> Mesh {
        let mut share = vec![0.5; self.nodes.len()];
        let mut drawn = self.clone();
        // (element, drawn mid-side nodes with the ends of their edges, the sharp one first).
        let mut touched: Vec<(usize, Vec<[usize; 3]>)> = Vec::new();
        for (index, element) in self.elements().enumerate() {
            let edges = TET_EDGES.into_iter().enumerate().filter_map(|(k, edge)| {
                let [first, last] = edge.map(|corner| element[corner]);
                match [sharp[first], sharp[last]] {
                    [true, false] => Some([first, element[4 + k], last]),
                    [false, true] => Some([last, element[4 + k], first]),
                    _ => None,
                }
            });
            let edges: Vec<[usize; 3]> = edges.collect();
            edges.iter().for_each(|[_, middle, _]| share[*middle] = 0.25);
            touched.extend((!edges.is_empty()).then_some((index, edges)));
        }
        // Far enough: a share of 0.499 or more is the middle.
        for _ in 0..9 {
            for [near, middle, far] in touched.iter().flat_map(|(_, edges)| edges) {
                // The place on the parabola through all three, so that a curved edge stays on its curve.
                let s = share[*middle];
                let shape = [(1.0 - s) * (1.0 - 2.0 * s), 4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)];
                let places = [near, middle, far].map(|node| self.nodes[*node]);
                drawn.nodes[*middle] = [0, 1, 2].map(|c| (0..3).map(|i| shape[i] * places[i][c]).sum());
            }
            let flat = |element: usize| {
                let [after, before] = [&drawn, &self].map(|mesh| mesh.element_nodes::<10>(element));
                TETRAHEDRON_15.iter().any(|(at, _)| {
                    let [after, before] =
                        [&after, &before].map(|nodes| physical_gradient_tet10(nodes, *at).1);
                    after.is_nan() || after <= FLAT * before
                })
            };
            let bad: std::collections::BTreeSet<usize> = touched
                .iter()
                .filter(|(element, _)| flat(*element))
                .flat_map(|(_, edges)| edges.iter().map(|[_, middle, _]| *middle))
                .collect();
            if bad.is_empty() {
                return drawn;
            }
            bad.into_iter().for_each(|node| share[node] += 0.5 * (0.5 - share[node]));
        }
        self
    }

    /// Triangles or tetrahedra.
    pub fn element_count(&self) -> usize {
        self.connectivity.len() / self.kind.nodes_per_element()
    }

    /// Nodes of every element, corners first.
    pub fn elements(&self) -> impl Iterator<Item = &[usize]> {
        self.connectivity.chunks_exact(self.kind.nodes_per_element())
    }

    /// Positions of an element's nodes; `N` is the number of nodes of the mesh's element kind.
    pub fn element_nodes<const N: usize>(&self, element: usize) -> [[f64; 3]; N] {
        std::array::from_fn(|i| self.nodes[self.connectivity[element * N + i]])
    }

    /// All nodes above (on) a set of plane nodes, level by level.
    pub fn columns_of(&self, plane_nodes: &[usize]) -> Vec<usize> {
        let per_level = self.plane.nodes.len();
        (0..self.levels.len())
            .flat_map(|level| plane_nodes.iter().map(move |node| level * per_level + node))
            .collect()
    }

    /// Angles, aspects and Jacobians over all elements.
    pub fn quality(&self) -> MeshQuality {
        let mut smallest_angle = f64::INFINITY;
        let mut largest_aspect = 0.0_f64;
        for triangle in &self.plane.triangles {
            let p: [Vec2; 3] = [0, 1, 2].map(|i| self.plane.nodes[triangle[i]]);
            let sides = [0, 1, 2].map(|i| (p[(i + 2) % 3] - p[(i + 1) % 3]).norm());
            let [a, b, c] = sides;
            for i in 0..3 {
                let (o, s, t) = (sides[i], sides[(i + 1) % 3], sides[(i + 2) % 3]);
                smallest_angle =
                    smallest_angle.min(((s * s + t * t - o * o) / (2.0 * s * t)).clamp(-1.0, 1.0).acos());
            }
            largest_aspect = largest_aspect.max(a * b * c / ((b + c - a) * (c + a - b) * (a + b - c)));
        }
        let smallest_jacobian_ratio =
            (0..self.element_count()).map(|e| self.jacobian_ratio(e)).fold(f64::INFINITY, f64::min);
        MeshQuality {
            nodes: self.nodes.len(),
            elements: self.element_count(),
            unknowns: self.nodes.len() * self.kind.dimension(),
            smallest_angle_deg: smallest_angle.to_degrees(),
            largest_aspect,
            smallest_jacobian_ratio,
        }
    }

    fn jacobian_ratio(&self, element: usize) -> f64 {
        let determinants: Vec<f64> = match self.kind {
            ElementKind::T6 => {
                let nodes = self.element_nodes::<6>(element);
                [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]
                    .iter()
                    .map(|at| physical_gradient_t6(&nodes, *at).1)
                    .collect()
            }
            ElementKind::Tet10 => {
                let nodes = self.element_nodes::<10>(element);
                [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]
                    .iter()
                    .map(|at| physical_gradient_tet10(&nodes, *at).1)
                    .collect()
            }
        };
        let (low, high) =
            determinants.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), d| (l.min(*d), h.max(*d)));
        low / high
    }

    /// Mass in kg of a mesh of tetrahedra with this density in kg/m³, that of held nodes included.
    pub fn mass(&self, density: f64) -> f64 {
        let of_element = |e| mass_tet10(&self.element_nodes::<10>(e), density).iter().sum::<f64>();
        (0..self.element_count()).map(of_element).sum()
    }

    /// The tetrahedra above plane triangle `triangle` in `layer`.
    pub fn prism_elements(&self, layer: usize, triangle: usize) -> std::ops::Range<usize> {
        let first = 3 * (layer * self.plane.triangles.len() + triangle);
        first..first + 3
    }

    /// Checks every element at its corners.
    ///
    /// # Errors
    /// [`FemError::InvertedElement`] if a curved mid-side node has turned an element inside out.
    pub fn check(&self) -> Result<(), FemError> {
        match (0..self.element_count())
            .map(|e| (e, self.jacobian_ratio(e)))
            .find(|(_, ratio)| ratio.is_nan() || *ratio <= 0.0)
        {
            Some((element, determinant)) => Err(FemError::InvertedElement { element, determinant }),
            None => Ok(()),
        }
    }
}

/// Corners of the three tetrahedra of a prism as (corner of the triangle, 0 = bottom, 1 = top).
///
/// With the corners sorted by index a < b < c the cuts a₀–b₁, a₀–c₁, b₀–c₁ give a₀a₁b₁c₁, a₀b₀b₁c₁, a₀b₀c₀c₁.
fn split_prism(triangle: &[usize; 6]) -> [[(usize, usize); 4]; 3] {
    let mut order = [0, 1, 2];
    order.sort_by_key(|i| triangle[*i]);
    let [a, b, c] = order;
    let even = matches!(order, [0, 1, 2] | [1, 2, 0] | [2, 0, 1]);
    let tetrahedra = [
        [(a, 0), (a, 1), (b, 1), (c, 1)],
        [(a, 0), (b, 0), (b, 1), (c, 1)],
        [(a, 0), (b, 0), (c, 0), (c, 1)],
    ];
    // For a counter-clockwise a, b, c the first and the last are right-handed, the middle one is not.
    let swap = [!even, even, !even];
    let mut result = tetrahedra;
    for (tetrahedron, swap) in result.iter_mut().zip(swap) {
        if swap {
            tetrahedron.swap(2, 3);
        }
    }
    result
}

/// Ten nodes as (plane node, half layers above the layer's bottom).
fn tet10_nodes(triangle: &[usize; 6], corners: [(usize, usize); 4]) -> [(usize, usize); 10] {
    let mut nodes = [(0, 0); 10];
    for (node, (corner, top)) in nodes.iter_mut().zip(corners) {
        *node = (triangle[corner], 2 * top);
    }
    for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
        let ((p, top_p), (q, top_q)) = (corners[i], corners[j]);
        let plane = match (p.min(q), p.max(q)) {
            (p, q) if p == q => triangle[p],
            (0, 1) => triangle[3],
            (1, 2) => triangle[4],
            _ => triangle[5],
        };
        nodes[4 + k] = (plane, top_p + top_q);
    }
    nodes
}
