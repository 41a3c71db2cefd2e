//! Closed surfaces of triangles.

use std::collections::HashMap;
use std::f64::consts::TAU;

use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::crankshaft::Slice;
use crate::geometry::{Outline, Segment, Vec2, unit};
use crate::units::MM;

/// Triangles that bound a solid: every edge belongs to two triangles, which traverse it in opposite directions.
/// Seen from outside, their corners are counter-clockwise.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Coordinates of the vertices, m.
    pub vertices: Vec<[f64; 3]>,
    /// Corners of the triangles as numbers of vertices.
    pub triangles: Vec<[usize; 3]>,
}

/// Vertices by the bits of their coordinates: equal coordinates are the same vertex.
#[derive(Default)]
struct Builder {
    mesh: Mesh,
    known: HashMap<[u64; 3], usize>,
}

impl Builder {
    fn vertex(&mut self, place: Vec2, z: f64) -> usize {
        // Adding 0 makes −0 and 0 the same coordinate.
        let place = [place.x + 0.0, place.y + 0.0, z + 0.0];
        let next = self.mesh.vertices.len();
        let index = *self.known.entry(place.map(f64::to_bits)).or_insert(next);
        if index == next {
            self.mesh.vertices.push(place);
        }
        index
    }

    /// Triangles of a horizontal face, with the normal up or down.
    fn level(&mut self, triangles: &[[Vec2; 3]], z: f64, up: bool) {
        for corners in triangles {
            let [a, b, c] = corners.map(|place| self.vertex(place, z));
            self.mesh.triangles.push(if up { [a, b, c] } else { [a, c, b] });
        }
    }

    /// The vertical wall along a closed polygon, with the material on its left.
    fn wall(&mut self, polygon: &[Vec2], low: f64, high: f64) {
        for (index, from) in polygon.iter().enumerate() {
            let to = polygon[(index + 1) % polygon.len()];
            let [a, b] = [*from, to].map(|place| self.vertex(place, low));
            let [c, d] = [to, *from].map(|place| self.vertex(place, high));
            self.mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
}

impl Mesh {
    /// The prism over a region between two heights: its outer polygon and holes, all counter-clockwise. `None`
    /// if polygons intersect.
    pub fn prism(outer: &[Vec2], holes: &[Vec<Vec2>], low: f64, high: f64) -> Option<Mesh> {
        let polygons: Vec<&[Vec2]> = std::iter::once(outer).chain(holes.iter().map(Vec::as_slice)).collect();
        let inside = |point: Vec2| polygons.iter().filter(|polygon| contains(polygon, point)).count() == 1;
        let region: Vec<[Vec2; 3]> =
            triangulated(&polygons)?.into_iter().filter(|triangle| inside(centre(triangle))).collect();
        let mut builder = Builder::default();
        builder.level(&region, low, false);
        builder.level(&region, high, true);
        builder.wall(outer, low, high);
        for hole in holes {
            let backwards: Vec<Vec2> = hole.iter().rev().copied().collect();
            builder.wall(&backwards, low, high);
        }
        Some(builder.mesh)
    }

    /// A stack of cylinders whose chords are within a tolerance (m). If two neighbouring circles nearly touch,
    /// chords are shortened until they do not intersect; `None` if this fails.
    pub(super) fn stack(slices: &[Slice], tolerance: f64) -> Option<Mesh> {
        const ROUNDS: i32 = 12;
        (0..ROUNDS).find_map(|round| Mesh::stacked(slices, tolerance * 0.5_f64.powi(round)))
    }

    fn stacked(slices: &[Slice], tolerance: f64) -> Option<Mesh> {
        // At the intersection of neighbouring circles both polygons have the same corner, as do all others
        // whose circles intersect at the same point within rounding.
        let mut known: Vec<Vec2> = Vec::new();
        let mut same = |place: Vec2| {
            let near = known.iter().copied().find(|other| (other - place).norm() < SAME);
            near.unwrap_or_else(|| {
                known.push(place);
                place
            })
        };
        let crossings: Vec<Vec<Vec2>> = slices
            .windows(2)
            .map(|pair| crossings(&pair[0], &pair[1]).into_iter().map(&mut same).collect())
            .collect();
        let none = Vec::new();
        let polygons: Vec<Vec<Vec2>> = slices
            .iter()
            .enumerate()
            .map(|(index, slice)| {
                let below = index.checked_sub(1).map_or(&none, |meeting| &crossings[meeting]);
                let above = crossings.get(index).unwrap_or(&none);
                let corners: Vec<Vec2> = below.iter().chain(above).copied().collect();
                circle_with(slice.centre, slice.radius, tolerance, &corners)
            })
            .collect();
        let mut builder = Builder::default();
        for (slice, polygon) in slices.iter().zip(&polygons) {
            builder.wall(polygon, slice.from, slice.to);
        }
        for (index, pair) in polygons.windows(2).enumerate() {
            let level = slices[index].to;
            for triangle in triangulated(&[&pair[0], &pair[1]])? {
                let place = centre(&triangle);
                match (contains(&pair[0], place), contains(&pair[1], place)) {
                    (true, false) => builder.level(&[triangle], level, true),
                    (false, true) => builder.level(&[triangle], level, false),
                    _ => {}
                }
            }
        }
        for (end, up) in [(0, false), (slices.len() - 1, true)] {
            let polygon = &polygons[end];
            let z = if up { slices[end].to } else { slices[end].from };
            let cover = triangulated(&[polygon])?.into_iter().filter(|t| contains(polygon, centre(t)));
            builder.level(&cover.collect::<Vec<_>>(), z, up);
        }
        Some(builder.mesh)
    }

    /// The mesh rotated about the axis and translated.
    pub fn placed(&self, angle: f64, place: [f64; 3]) -> Mesh {
        let turn = unit(angle);
        let vertices = self
            .vertices
            .iter()
            .map(|v| {
                let turned = crate::geometry::turned(Vec2::new(v[0], v[1]), turn);
                [turned.x + place[0], turned.y + place[1], v[2] + place[2]]
            })
            .collect();
        Mesh { vertices, triangles: self.triangles.clone() }
    }

    /// Enclosed volume in m³: Σ a · (b × c)/6.
    pub fn volume(&self) -> f64 {
        let corner = |index: usize| nalgebra::Vector3::from(self.vertices[index]);
        let sum = |t: &[usize; 3]| corner(t[0]).dot(&corner(t[1]).cross(&corner(t[2])));
        self.triangles.iter().map(sum).sum::<f64>() / 6.0
    }
}

/// Corners of a circle whose chords are within a tolerance, counter-clockwise.
pub(super) fn circle(centre: Vec2, radius: f64, tolerance: f64) -> Vec<Vec2> {
    circle_with(centre, radius, tolerance, &[])
}

/// The same with further corners, which lie on the circle.
fn circle_with(centre: Vec2, radius: f64, tolerance: f64, further: &[Vec2]) -> Vec<Vec2> {
    let count = chords(radius, TAU, tolerance).max(LEAST_CHORDS);
    let mut corners: Vec<(f64, Vec2)> = (0..count)
        .map(|i| TAU * i as f64 / count as f64)
        .map(|angle| (angle, centre + radius * unit(angle)))
        .collect();
    // A regular corner too close to an additional one is omitted.
    let near = 0.25 * TAU / count as f64;
    for (index, place) in further.iter().enumerate() {
        if further[..index].contains(place) {
            continue;
        }
        let arm = place - centre;
        let angle = arm.y.atan2(arm.x).rem_euclid(TAU);
        corners.retain(|(other, corner)| {
            further.contains(corner) || crate::units::wrap_angle(other - angle).abs() > near
        });
        corners.push((angle, *place));
    }
    corners.sort_by(|a, b| a.0.total_cmp(&b.0));
    corners.into_iter().map(|(_, place)| place).collect()
}

/// Intersections closer to each other than this (m) are identical.
const SAME: f64 = 1e-9;
/// Smallest number of chords of a circle.
const LEAST_CHORDS: usize = 12;

/// Number of chords of an arc within a tolerance: r (1 − cos(α/2)) ≤ t.
fn chords(radius: f64, sweep: f64, tolerance: f64) -> usize {
    let largest = 2.0 * (1.0 - tolerance / radius).clamp(-1.0, 1.0).acos();
    // A thousandth of the tolerance is reserved for rounding.
    (sweep.abs() / (0.9995 * largest).max(1e-6)).ceil().max(1.0) as usize
}

/// Corners of a closed curve of lines and arcs within a tolerance.
pub(super) fn corners(outline: &Outline, tolerance: f64) -> Vec<Vec2> {
    let of = |segment: &Segment| {
        let count = match segment {
            Segment::Line { .. } => 1,
            Segment::Arc { radius, sweep, .. } => chords(*radius, *sweep, tolerance)
                .max((sweep.abs() / (TAU / LEAST_CHORDS as f64)).ceil() as usize),
        };
        (0..count).map(|i| segment.point(i as f64 / count as f64)).collect::<Vec<Vec2>>()
    };
    outline.segments.iter().flat_map(of).collect()
}

/// Intersections of the circles of two slices.
fn crossings(a: &Slice, b: &Slice) -> Vec<Vec2> {
    let between = b.centre - a.centre;
    let d = between.norm();
    if d + a.radius.min(b.radius) <= a.radius.max(b.radius) {
        return Vec::new();
    }
    let towards = between.y.atan2(between.x);
    let cosine = (d * d + a.radius * a.radius - b.radius * b.radius) / (2.0 * d * a.radius);
    let half = cosine.clamp(-1.0, 1.0).acos();
    [towards - half, towards + half].map(|angle| a.centre + a.radius * unit(angle)).to_vec()
}

fn centre(triangle: &[Vec2; 3]) -> Vec2 {
    (triangle[0] + triangle[1] + triangle[2]) / 3.0
}

/// Whether a point lies inside of a polygon, by the crossings of a ray.
fn contains(polygon: &[Vec2], point: Vec2) -> bool {
    let mut inside = false;
    for (index, a) in polygon.iter().enumerate() {
        let b = polygon[(index + 1) % polygon.len()];
        if (a.y > point.y) != (b.y > point.y) && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x) {
            inside = !inside;
        }
    }
    inside
}

/// A corner with its position in m; the triangulation uses mm.
struct Corner(Vec2);

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.0.x / MM, self.0.y / MM)
    }
}

/// Counter-clockwise triangles of the convex hull of closed polygons that contain all edges of the polygons;
/// `None` if edges intersect.
fn triangulated(polygons: &[&[Vec2]]) -> Option<Vec<[Vec2; 3]>> {
    let mut mesh: ConstrainedDelaunayTriangulation<Corner> = ConstrainedDelaunayTriangulation::new();
    for polygon in polygons {
        let corners: Option<Vec<FixedVertexHandle>> =
            polygon.iter().map(|place| mesh.insert(Corner(*place)).ok()).collect();
        let corners = corners?;
        for (index, from) in corners.iter().enumerate() {
            let to = corners[(index + 1) % corners.len()];
            if *from == to || !mesh.can_add_constraint(*from, to) {
                return None;
            }
            mesh.add_constraint(*from, to);
        }
    }
    Some(mesh.inner_faces().map(|face| face.vertices().map(|vertex| vertex.data().0)).collect())
}
