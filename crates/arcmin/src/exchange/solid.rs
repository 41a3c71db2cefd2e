//! Boundaries of solids as STEP entities.

use super::step::Step;
use super::trimmed;
use crate::geometry::{Vec2, unit};
use crate::units::MM;

/// Volume in m³ and surface in m² of a part, from closed forms and the exact edge.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidFigures {
    /// Name of the part as in the file.
    pub name: String,
    /// Volume, m³.
    pub volume: f64,
    /// Surface, m².
    pub surface: f64,
}

/// A vertex: its entity and its position, in m.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vertex {
    pub id: usize,
    pub place: [f64; 3],
}

/// A closed sequence of edges, each with whether its direction is that of the loop.
pub(super) type Loop = Vec<(usize, bool)>;

/// Length in mm as a STEP real.
pub(super) fn real(metres: f64) -> String {
    number(metres / MM, 9)
}

/// A STEP real always has a point.
pub(super) fn number(value: f64, decimals: usize) -> String {
    let text = trimmed(value, decimals);
    if text.contains('.') { text } else { text + "." }
}

impl Step {
    pub(super) fn point(&mut self, place: [f64; 3]) -> usize {
        let [x, y, z] = place.map(real);
        self.add(&format!("CARTESIAN_POINT('',({x},{y},{z}))"))
    }

    pub(super) fn direction(&mut self, towards: [f64; 3]) -> usize {
        let [x, y, z] = towards.map(|c| number(c, 15));
        self.add(&format!("DIRECTION('',({x},{y},{z}))"))
    }

    pub(super) fn placement(&mut self, place: [f64; 3], axis: [f64; 3], x: [f64; 3]) -> usize {
        let (place, axis, x) = (self.point(place), self.direction(axis), self.direction(x));
        self.add(&format!("AXIS2_PLACEMENT_3D('',#{place},#{axis},#{x})"))
    }

    pub(super) fn vertex(&mut self, place: [f64; 3]) -> Vertex {
        let point = self.point(place);
        Vertex { id: self.add(&format!("VERTEX_POINT('',#{point})")), place }
    }

    pub(super) fn edge(&mut self, from: Vertex, to: Vertex, curve: usize) -> usize {
        self.add(&format!("EDGE_CURVE('',#{},#{},#{curve},.T.)", from.id, to.id))
    }

    /// A straight edge between vertices, parallel to the axis.
    pub(super) fn upright(&mut self, from: Vertex, to: Vertex) -> usize {
        let point = self.point(from.place);
        let up = self.direction([0.0, 0.0, 1.0]);
        let vector = self.add(&format!("VECTOR('',#{up},1.)"));
        let line = self.add(&format!("LINE('',#{point},#{vector})"));
        self.edge(from, to, line)
    }

    fn face_loop(&mut self, edges: &Loop, outer: bool) -> usize {
        let oriented: Vec<usize> = edges
            .iter()
            .map(|(edge, along)| {
                let sense = if *along { "T" } else { "F" };
                self.add(&format!("ORIENTED_EDGE('',*,*,#{edge},.{sense}.)"))
            })
            .collect();
        let edge_loop = self.add(&format!("EDGE_LOOP('',({}))", references(&oriented)));
        let kind = if outer { "FACE_OUTER_BOUND" } else { "FACE_BOUND" };
        self.add(&format!("{kind}('',#{edge_loop},.T.)"))
    }

    /// A face whose first loop is the outer one; `same`: whether its normal is that of the surface.
    pub(super) fn face(&mut self, name: &str, surface: usize, loops: &[Loop], same: bool) -> usize {
        let bounds: Vec<usize> =
            loops.iter().enumerate().map(|(index, edges)| self.face_loop(edges, index == 0)).collect();
        let sense = if same { "T" } else { "F" };
        self.add(&format!("ADVANCED_FACE('{name}',({}),#{surface},.{sense}.)", references(&bounds)))
    }

    /// A plane perpendicular to the axis, with its normal up or down.
    pub(super) fn level(&mut self, z: f64, up: bool) -> usize {
        let axis = self.placement([0.0, 0.0, z], [0.0, 0.0, if up { 1.0 } else { -1.0 }], [1.0, 0.0, 0.0]);
        self.add(&format!("PLANE('',#{axis})"))
    }

    pub(super) fn cylinder(&mut self, centre: Vec2, radius: f64, z: f64) -> usize {
        let axis = self.placement([centre.x, centre.y, z], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        self.add(&format!("CYLINDRICAL_SURFACE('',#{axis},{})", real(radius)))
    }

    pub(super) fn solid(&mut self, name: &str, faces: &[usize]) -> usize {
        let shell = self.add(&format!("CLOSED_SHELL('',({}))", references(faces)));
        self.add(&format!("MANIFOLD_SOLID_BREP('{name}',#{shell})"))
    }

    /// A circle perpendicular to the axis as edges between vertices at the given angles, which increase within
    /// one turn.
    pub(super) fn rim(&mut self, centre: Vec2, radius: f64, z: f64, angles: &[(f64, Option<Vertex>)]) -> Rim {
        let vertices: Vec<(f64, Vertex)> = angles
            .iter()
            .map(|(angle, known)| {
                let place = centre + radius * unit(*angle);
                (*angle, known.unwrap_or_else(|| self.vertex([place.x, place.y, z])))
            })
            .collect();
        let axis = self.placement([centre.x, centre.y, z], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        let circle = self.add(&format!("CIRCLE('',#{axis},{})", real(radius)));
        let edges = (0..vertices.len())
            .map(|i| self.edge(vertices[i].1, vertices[(i + 1) % vertices.len()].1, circle))
            .collect();
        Rim { centre, radius, vertices, edges }
    }

    /// The two halves of a cylinder's wall between rims that both have vertices at the two seam angles.
    /// `outside`: whether the material is inside of the cylinder.
    pub(super) fn wall(
        &mut self,
        name: &str,
        low: &Rim,
        high: &Rim,
        z: f64,
        seams: [f64; 2],
        outside: bool,
    ) -> Vec<usize> {
        let surface = self.cylinder(low.centre, low.radius, z);
        let ups = seams.map(|seam| {
            let (from, to) = (low.vertices[low.index(seam)].1, high.vertices[high.index(seam)].1);
            self.upright(from, to)
        });
        (0..2)
            .map(|half| {
                let (from, to) = (seams[half], seams[1 - half]);
                let mut edges: Loop = low.between(from, to).into_iter().map(|edge| (edge, true)).collect();
                edges.push((ups[1 - half], true));
                edges.extend(high.between(from, to).into_iter().rev().map(|edge| (edge, false)));
                edges.push((ups[half], false));
                if !outside {
                    edges = edges.into_iter().rev().map(|(edge, along)| (edge, !along)).collect();
                }
                self.face(name, surface, &[edges], outside)
            })
            .collect()
    }
}

/// A circle's edges; edge i leads counter-clockwise from vertex i to the next.
#[derive(Debug, Clone)]
pub(super) struct Rim {
    pub centre: Vec2,
    pub radius: f64,
    pub vertices: Vec<(f64, Vertex)>,
    pub edges: Vec<usize>,
}

impl Rim {
    fn index(&self, angle: f64) -> usize {
        let off = |i: &usize| crate::units::wrap_angle(self.vertices[*i].0 - angle).abs();
        (0..self.vertices.len()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)
    }

    /// Edges counter-clockwise from one vertex to another.
    fn between(&self, from: f64, to: f64) -> Vec<usize> {
        let (first, last, count) = (self.index(from), self.index(to), self.edges.len());
        let steps = (last + count - first) % count;
        (0..if steps == 0 { count } else { steps }).map(|i| self.edges[(first + i) % count]).collect()
    }

    pub(super) fn all(&self, along: bool) -> Loop {
        let edges = self.edges.iter().map(|edge| (*edge, along));
        if along { edges.collect() } else { edges.rev().collect() }
    }

    /// The sequence of edges inside (or outside) of another circle, counter-clockwise.
    pub(super) fn run(&self, other: &Rim, inside: bool) -> Vec<usize> {
        let count = self.edges.len();
        let is = |i: usize| {
            let (a, b) = (self.vertices[i].0, self.vertices[(i + 1) % count].0);
            let middle = a + 0.5 * (b - a).rem_euclid(std::f64::consts::TAU);
            ((self.centre + self.radius * unit(middle) - other.centre).norm() < other.radius) == inside
        };
        let start = (0..count).find(|i| is(*i) && !is((*i + count - 1) % count)).unwrap_or(0);
        (0..count).map(|i| (start + i) % count).take_while(|i| is(*i)).map(|i| self.edges[i]).collect()
    }
}

pub(super) fn references(ids: &[usize]) -> String {
    ids.iter().map(|id| format!("#{id}")).collect::<Vec<_>>().join(",")
}
