//! Triangulation of plane sections with nodes on their true boundary curves.

use std::collections::HashMap;

use spade::{AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation};

use super::symmetry::Mirrors;
use super::{Boundary, FemError};
use crate::geometry::{Vec2, cross};

/// A plane region: one outer curve and any number of holes, each with its edge length.
#[derive(Debug, Clone)]
pub struct PlaneDomain {
    /// The outer curve first, then the holes: (curve, edge length in m, rows of nodes parallel to the curve).
    pub boundaries: Vec<(Boundary, f64, usize)>,
    /// Largest edge length in the interior in m.
    pub interior_size: f64,
}

/// Edge lengths of a disc's mesh in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshSizes {
    /// Along the flank.
    pub flank: f64,
    /// Rows of nodes parallel to the flank: a fine layer down to the depth at which displacements are
    /// evaluated.
    pub flank_rows: usize,
    /// Along the bores of the crankshafts.
    pub bore: f64,
    /// Along holes and windows.
    pub hole: f64,
    /// Largest in the interior.
    pub interior: f64,
}

/// One edge of a boundary curve after meshing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundaryEdge {
    /// Index of the curve in [`PlaneDomain::boundaries`].
    pub boundary: usize,
    /// First node, last node, mid-side node; the metal is on the left for the outer curve, on the right for
    /// holes.
    pub nodes: [usize; 3],
    /// Curve parameters of these three; the last node's is larger than the first's.
    pub parameters: [f64; 3],
}

/// Six-node triangles (T6) of a plane region; mid-side nodes of boundary edges lie on the true curve.
#[derive(Debug, Clone)]
pub struct PlaneMesh {
    /// m.
    pub nodes: Vec<Vec2>,
    /// Number of corner nodes; they come first.
    pub corner_count: usize,
    /// Corners counter-clockwise, then the mid-side nodes of edges 0–1, 1–2, 2–0.
    pub triangles: Vec<[usize; 6]>,
    /// Ordered along each curve, curve after curve.
    pub boundary_edges: Vec<BoundaryEdge>,
}

/// Smallest angle required of the triangulation in degrees. Ruppert's refinement terminates in practice up to
/// about 30°; the fixed boundary nodes may reduce it by a few degrees in places.
const ANGLE_LIMIT_DEG: f64 = 27.0;

impl PlaneMesh {
    /// Constrained Delaunay triangulation with Ruppert refinement (spade), graded by the spacing of the
    /// boundary nodes.
    ///
    /// # Errors
    /// [`FemError::Mesh`] if boundary curves intersect or the refinement does not terminate.
    pub fn triangulate(domain: &PlaneDomain) -> Result<PlaneMesh, FemError> {
        let Triangulated { nodes, corners, curves } = triangulated(domain, Mirrors::None, true)?;
        PlaneMesh::with_mid_sides(nodes, &corners, domain, &curves)
    }

    /// The same for a domain with curves inside the material, such as the section of a pillar on a plate: edges
    /// of the mesh follow every curve, and `keep` decides from the curves around a triangle (bit k: inside
    /// curve k) whether it is material. Returns these bits for every triangle in addition to the mesh.
    ///
    /// # Errors
    /// As [`PlaneMesh::triangulate`], and for more than 64 curves.
    pub fn triangulate_regions(
        domain: &PlaneDomain,
        keep: impl Fn(u64) -> bool,
    ) -> Result<(PlaneMesh, Vec<u64>), FemError> {
        PlaneMesh::triangulate_part(domain, Mirrors::None, keep)
    }

    /// [`PlaneMesh::triangulate_regions`] of the symmetric part of a domain.
    ///
    /// # Errors
    /// As there.
    pub fn triangulate_part(
        domain: &PlaneDomain,
        mirrors: Mirrors,
        keep: impl Fn(u64) -> bool,
    ) -> Result<(PlaneMesh, Vec<u64>), FemError> {
        if domain.boundaries.len() > 64 {
            return Err(FemError::Mesh { reason: "more than 64 curves in one section".to_owned() });
        }
        let Triangulated { nodes, corners, curves } = triangulated(domain, mirrors, false)?;
        let polygons: Vec<Vec<Vec2>> = domain
            .boundaries
            .iter()
            .zip(&curves)
            .map(|((boundary, ..), curve)| curve.parameters.iter().map(|t| boundary.point(*t)).collect())
            .collect();
        let regions = |corners: &[usize; 3]| {
            let centre = corners.iter().map(|node| nodes[*node]).sum::<Vec2>() / 3.0;
            let bit = |(k, polygon): (usize, &Vec<Vec2>)| u64::from(encloses(polygon, centre)) << k;
            polygons.iter().enumerate().map(bit).sum::<u64>()
        };
        let (kept, bits): (Vec<[usize; 3]>, Vec<u64>) = corners
            .iter()
            .map(|corners| (*corners, regions(corners)))
            .filter(|(_, bits)| keep(*bits))
            .unzip();
        Ok((PlaneMesh::with_mid_sides(nodes, &kept, domain, &curves)?, bits))
    }

    fn with_mid_sides(
        positions: Vec<Vec2>,
        corners: &[[usize; 3]],
        domain: &PlaneDomain,
        curves: &[Curve],
    ) -> Result<PlaneMesh, FemError> {
        // Nodes outside the material (a row in a thin bridge may leave it) belong to no triangle and are
        // removed.
        let mut used = vec![false; positions.len()];
        corners.iter().flatten().for_each(|node| used[*node] = true);
        let mut new_index = vec![usize::MAX; positions.len()];
        let mut nodes: Vec<Vec2> = Vec::new();
        for (old, position) in positions.iter().enumerate().filter(|(old, _)| used[*old]) {
            new_index[old] = nodes.len();
            nodes.push(*position);
        }
        let corner_count = nodes.len();
        let mut mid_sides: HashMap<(usize, usize), usize> = HashMap::new();
        let mut boundary_edges = Vec::new();
        for (index, ((boundary, ..), curve)) in domain.boundaries.iter().zip(curves).enumerate() {
            for (nodes_of_edge, [from, to]) in &curve.edges {
                let [a, b] = nodes_of_edge.map(|node| new_index[node]);
                if a == usize::MAX || b == usize::MAX {
                    return Err(FemError::Mesh {
                        reason: "a boundary node lies outside of the material".to_owned(),
                    });
                }
                let (t, point) = boundary.midpoint(*from, *to);
                mid_sides.insert((a.min(b), a.max(b)), nodes.len());
                boundary_edges.push(BoundaryEdge {
                    boundary: index,
                    nodes: [a, b, nodes.len()],
                    parameters: [*from, *to, t],
                });
                nodes.push(point);
            }
        }
        let mut triangles = Vec::with_capacity(corners.len());
        for triangle in corners {
            let [a, b, c] = triangle.map(|node| new_index[node]);
            let [b, c] = if cross(nodes[b] - nodes[a], nodes[c] - nodes[a]) > 0.0 { [b, c] } else { [c, b] };
            let mut mid = |a: usize, b: usize| {
                *mid_sides.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    nodes.push(0.5 * (nodes[a] + nodes[b]));
                    nodes.len() - 1
                })
            };
            triangles.push([a, b, c, mid(a, b), mid(b, c), mid(c, a)]);
        }
        Ok(PlaneMesh { nodes, corner_count, triangles, boundary_edges })
    }

    /// The edges of one boundary curve, in order.
    pub fn edges_of(&self, boundary: usize) -> impl Iterator<Item = &BoundaryEdge> {
        self.boundary_edges.iter().filter(move |edge| edge.boundary == boundary)
    }

    /// Nodes of one boundary curve: corners and mid-sides, and finally the ends of a curve that a mirror cuts.
    pub fn nodes_of(&self, boundary: usize) -> Vec<usize> {
        let mut nodes: Vec<usize> =
            self.edges_of(boundary).flat_map(|edge| [edge.nodes[0], edge.nodes[2]]).collect();
        let begins: std::collections::HashSet<usize> = nodes.iter().copied().collect();
        nodes.extend(self.edges_of(boundary).map(|edge| edge.nodes[1]).filter(|node| !begins.contains(node)));
        nodes
    }

    /// The triangle (by straight corners) that contains a point, with area coordinates of corners 0 and 1.
    pub fn locate(&self, point: Vec2) -> Option<(usize, [f64; 2])> {
        let tolerance = 1e-9;
        self.triangles.iter().enumerate().find_map(|(index, triangle)| {
            let [a, b, c] = [0, 1, 2].map(|i| self.nodes[triangle[i]]);
            let area = cross(b - a, c - a);
            let l0 = cross(b - point, c - point) / area;
            let l1 = cross(c - point, a - point) / area;
            (l0 > -tolerance && l1 > -tolerance && 1.0 - l0 - l1 > -tolerance).then_some((index, [l0, l1]))
        })
    }
}

/// Corner nodes, triangles, and the curves.
struct Triangulated {
    nodes: Vec<Vec2>,
    corners: Vec<[usize; 3]>,
    curves: Vec<Curve>,
}

/// A boundary curve as a sequence of points.
struct Curve {
    /// Parameters over the whole curve, including mirrored parts.
    parameters: Vec<f64>,
    /// Nodes and parameters of the ends of the meshed edges, in order.
    edges: Vec<([usize; 2], [f64; 2])>,
}

/// The parameters of a curve's nodes, with an additional one wherever an edge crosses a mirror.
fn cut_at_mirrors(boundary: &Boundary, mut parameters: Vec<f64>, mirrors: Mirrors, near: f64) -> Vec<f64> {
    for component in mirrors.components() {
        let at = |t: f64| boundary.point(t)[*component];
        let ends = parameters.iter().copied().skip(1).chain([parameters[0] + boundary.period()]);
        let cuts: Vec<Option<f64>> = parameters
            .iter()
            .zip(ends)
            .map(|(from, to)| {
                let crosses = at(*from).abs() > near && at(to).abs() > near && at(*from) * at(to) < 0.0;
                crosses.then(|| {
                    let (mut low, mut high) = (*from, to);
                    for _ in 0..60 {
                        let middle = 0.5 * (low + high);
                        if at(middle) * at(*from) > 0.0 { low = middle } else { high = middle }
                    }
                    0.5 * (low + high)
                })
            })
            .collect();
        parameters = parameters.iter().zip(cuts).flat_map(|(t, cut)| [Some(*t), cut]).flatten().collect();
    }
    parameters
}

/// Edges along a mirror: nodes between its intersections with curves and other mirrors, with edge lengths that
/// increase from those of the curves to `interior`.
fn along_mirror(from: Vec2, to: Vec2, sizes: [f64; 2], interior: f64) -> Vec<Vec2> {
    const GROWTH: f64 = 0.5;
    const SAMPLES: usize = 400;
    let length = (to - from).norm();
    let size = |s: f64| {
        let grown = (sizes[0] + GROWTH * s * length).min(sizes[1] + GROWTH * (1.0 - s) * length);
        grown.min(interior)
    };
    // Number of edges from the beginning.
    let counted: Vec<f64> = (0..SAMPLES)
        .scan(0.0, |sum, k| {
            *sum += length / SAMPLES as f64 / size((k as f64 + 0.5) / SAMPLES as f64);
            Some(*sum)
        })
        .collect();
    let count = counted[SAMPLES - 1].round().max(1.0);
    (1..count as usize)
        .map(|k| {
            let wanted = k as f64 / count * counted[SAMPLES - 1];
            let cell = counted.partition_point(|sum| *sum < wanted);
            let before = if cell > 0 { counted[cell - 1] } else { 0.0 };
            let s = (cell as f64 + (wanted - before) / (counted[cell] - before)) / SAMPLES as f64;
            from + s * (to - from)
        })
        .collect()
}

/// Nodes and edges that the triangulation must contain.
#[derive(Default)]
struct Outlines {
    nodes: Vec<Vec2>,
    edges: Vec<[usize; 2]>,
    curves: Vec<Curve>,
}

impl Outlines {
    fn of(domain: &PlaneDomain, mirrors: Mirrors) -> Outlines {
        let mut outlines = Outlines::default();
        let near = 1e-9 * domain.interior_size;
        for (boundary, size, _) in &domain.boundaries {
            outlines.add_curve(boundary, *size, mirrors, near);
        }
        outlines.close_along(mirrors, domain.interior_size);
        outlines
    }

    /// Adds the symmetric part of a curve.
    fn add_curve(&mut self, boundary: &Boundary, size: f64, mirrors: Mirrors, near: f64) {
        let parameters = cut_at_mirrors(boundary, boundary.sample(size), mirrors, near);
        let is_left = |point: Vec2| mirrors.components().iter().all(|component| point[*component] > -near);
        let indices: Vec<Option<usize>> = parameters
            .iter()
            .map(|t| {
                let mut point = boundary.point(*t);
                if !is_left(point) {
                    return None;
                }
                for component in mirrors.components() {
                    if point[*component] < near {
                        point[*component] = 0.0;
                    }
                }
                self.nodes.push(point);
                Some(self.nodes.len() - 1)
            })
            .collect();
        let edges: Vec<([usize; 2], [f64; 2])> = (0..parameters.len())
            .filter_map(|i| {
                let j = (i + 1) % parameters.len();
                let end = if j == 0 { parameters[0] + boundary.period() } else { parameters[j] };
                let edge = ([indices[i]?, indices[j]?], [parameters[i], end]);
                is_left(boundary.midpoint(parameters[i], end).1).then_some(edge)
            })
            .collect();
        self.edges.extend(edges.iter().map(|(ends, _)| *ends));
        self.curves.push(Curve { parameters, edges });
    }

    /// Edges along the mirrors, from curve to curve.
    fn close_along(&mut self, mirrors: Mirrors, interior: f64) {
        let mut spacing = vec![f64::INFINITY; self.nodes.len()];
        for [a, b] in &self.edges {
            let length = (self.nodes[*a] - self.nodes[*b]).norm();
            [*a, *b].into_iter().for_each(|node| spacing[node] = spacing[node].min(length));
        }
        // Both mirrors intersect on the axis.
        if mirrors == Mirrors::Both {
            self.nodes.push(Vec2::zeros());
            spacing.push(interior);
        }
        for component in mirrors.components() {
            let along = 1 - component;
            let mut on: Vec<usize> =
                (0..spacing.len()).filter(|node| self.nodes[*node][*component] == 0.0).collect();
            on.sort_by(|a, b| self.nodes[*a][along].total_cmp(&self.nodes[*b][along]));
            for pair in on.windows(2) {
                let [from, to] = [pair[0], pair[1]];
                let sizes = [spacing[from], spacing[to]];
                let between = along_mirror(self.nodes[from], self.nodes[to], sizes, interior);
                let mut last = from;
                for node in between {
                    self.edges.push([last, self.nodes.len()]);
                    last = self.nodes.len();
                    self.nodes.push(node);
                }
                self.edges.push([last, to]);
            }
        }
    }
}

/// `holes`: whether material and holes alternate from curve to curve inwards, with holes left empty.
fn triangulated(domain: &PlaneDomain, mirrors: Mirrors, holes: bool) -> Result<Triangulated, FemError> {
    let Outlines { nodes, edges, curves } = Outlines::of(domain, mirrors);
    let mut points: Vec<Point2<f64>> = nodes.into_iter().map(to_point).collect();
    let boundary_count = points.len();
    for (index, ((boundary, size, rows), curve)) in domain.boundaries.iter().zip(&curves).enumerate() {
        let inward = if index == 0 { 1.0 } else { -1.0 };
        for row in 1..=*rows {
            points.extend(parallel_row(boundary, &curve.parameters, *size, row, inward));
        }
    }
    let mut conflict = false;
    let mut triangulation =
        ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(points, edges, |_| {
            conflict = true
        })
        .map_err(|error| FemError::Mesh { reason: error.to_string() })?;
    if conflict || triangulation.num_vertices() < boundary_count {
        return Err(FemError::Mesh { reason: "boundary curves touch or cross each other".to_owned() });
    }
    let parameters = RefinementParameters::<f64>::new()
        .exclude_outer_faces(holes)
        .keep_constraint_edges()
        .with_angle_limit(AngleLimit::from_deg(ANGLE_LIMIT_DEG))
        .with_max_allowed_area(0.45 * domain.interior_size * domain.interior_size)
        .with_max_additional_vertices(40 * boundary_count + 100_000);
    let refined = triangulation.refine(parameters);
    if !refined.refinement_complete {
        return Err(FemError::Mesh {
            reason:
                "the refinement does not terminate; boundary spacing and interior size may be incompatible"
                    .to_owned(),
        });
    }
    let mut outside = vec![false; triangulation.num_all_faces()];
    for face in &refined.excluded_faces {
        outside[face.index()] = true;
    }
    let corners: Vec<[usize; 3]> = triangulation
        .inner_faces()
        .filter(|face| !outside[face.fix().index()])
        .map(|face| face.vertices().map(|vertex| vertex.fix().index()))
        .collect();
    let nodes: Vec<Vec2> =
        triangulation.vertices().map(|vertex| Vec2::new(vertex.position().x, vertex.position().y)).collect();
    Ok(Triangulated { nodes, corners, curves })
}

/// Whether a point lies inside a polygon (crossings of a ray).
fn encloses(polygon: &[Vec2], point: Vec2) -> bool {
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let crossings = edges.filter(|(a, b)| {
        (a.y > point.y) != (b.y > point.y) && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossings.count() % 2 == 1
}

/// Nodes displaced by half an edge, row by row at the height of equilateral triangles into the material;
/// thinned where they are dense (convex tips).
fn parallel_row(
    boundary: &Boundary,
    parameters: &[f64],
    size: f64,
    row: usize,
    inward: f64,
) -> Vec<Point2<f64>> {
    let count = parameters.len();
    let depth = row as f64 * 0.85 * size;
    let mut nodes: Vec<Vec2> = Vec::new();
    for i in 0..count {
        let end = if i + 1 == count { parameters[0] + boundary.period() } else { parameters[i + 1] };
        let t = if row % 2 == 1 { 0.5 * (parameters[i] + end) } else { parameters[i] };
        let step = 1e-6 * (end - parameters[i]);
        let tangent = (boundary.point(t + step) - boundary.point(t - step)).normalize();
        let point = boundary.point(t) + inward * depth * Vec2::new(-tangent.y, tangent.x);
        let crowded = |other: Option<&Vec2>| other.is_some_and(|other| (point - other).norm() < 0.6 * size);
        if !crowded(nodes.last()) && !crowded(nodes.first()) {
            nodes.push(point);
        }
    }
    nodes.into_iter().map(to_point).collect()
}

fn to_point(v: Vec2) -> Point2<f64> {
    Point2::new(v.x, v.y)
}
