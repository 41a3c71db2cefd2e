//! Loads on the flank and displacements read from it.

use super::boundary::FlankArc;
use super::elements::{gradient_edge, shape_edge, shape_t6, shape_tet10};
use super::quadrature::{LINE_4, TRIANGLE_6};
use super::{DofMap, ElementKind, FemError, Mesh};
use crate::geometry::{Profile, Vec2};

/// Places around the flank, the same on every lobe and the first at its root, at equal steps of a length
/// blended from arc length and meshing angle.
#[derive(Debug, Clone)]
pub struct FlankStations {
    arc: FlankArc,
    lobes: usize,
    per_lobe: usize,
}

/// A place on the flank as four stations with B-spline weights, and the same on the finer grid of one lobe.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stencil {
    pub(super) stations: [(usize, f64); 4],
    pub(super) lobe: [(usize, f64); 4],
}

/// Grid cells of the finer lobe grid per station.
pub(super) const LOBE_REFINEMENT: usize = 4;

impl FlankStations {
    /// Stations with the same number on every lobe of a flank.
    pub fn new(profile: &Profile, per_lobe: usize) -> FlankStations {
        FlankStations {
            arc: FlankArc::blended_with_meshing_angle(profile),
            lobes: profile.lobe_count(),
            per_lobe,
        }
    }

    /// Stations on the whole flank.
    pub fn count(&self) -> usize {
        self.lobes * self.per_lobe
    }

    /// Stations on one lobe.
    pub fn per_lobe(&self) -> usize {
        self.per_lobe
    }

    /// Trace parameter τ of a station; half numbers are midpoints between stations.
    pub fn parameter(&self, station: f64) -> f64 {
        self.arc.parameter(station * self.arc.lobe_length() / self.per_lobe as f64)
    }

    /// Distance between two stations in m of the blended length.
    pub fn spacing(&self) -> f64 {
        self.arc.lobe_length() / self.per_lobe as f64
    }

    /// Cubic B-spline in that length: twice continuously differentiable, fourth order. The weights go with
    /// coefficients, which [`FlankStations::coefficients`] finds from values at the stations.
    pub fn stencil(&self, tau: f64) -> Stencil {
        let x = self.arc.arc(tau) / self.spacing();
        Stencil {
            stations: spline_weights(x, self.count()),
            lobe: spline_weights(x * LOBE_REFINEMENT as f64, self.per_lobe * LOBE_REFINEMENT),
        }
    }

    /// The stencil that gives derivatives with respect to τ.
    pub fn slope_stencil(&self, tau: f64) -> Stencil {
        let x = self.arc.arc(tau) / self.spacing();
        let rate = self.arc.rate(tau) / self.spacing();
        let finer = LOBE_REFINEMENT as f64;
        Stencil {
            stations: spline_slopes(x, self.count(), rate),
            lobe: spline_slopes(x * finer, self.per_lobe * LOBE_REFINEMENT, rate * finer),
        }
    }
}

impl FlankStations {
    /// The stencil that gives second derivatives with respect to τ: φ″(x) (dx/dτ)² + φ′(x) d²x/dτ².
    pub fn bend_stencil(&self, tau: f64) -> Stencil {
        let x = self.arc.arc(tau) / self.spacing();
        let rate = |tau: f64| self.arc.rate(tau) / self.spacing();
        // The blend of arc length and meshing angle is smooth: a difference over a thousandth of a cell is exact to 1e-6.
        let step = 1e-3 / rate(tau);
        let (rate, change) = (rate(tau), (rate(tau + step) - rate(tau - step)) / (2.0 * step));
        let finer = LOBE_REFINEMENT as f64;
        let both = |x: f64, count: usize, finer: f64| {
            let mut bends = spline_bends(x * finer, count, (finer * rate).powi(2));
            let slopes = spline_slopes(x * finer, count, finer * change);
            bends.iter_mut().zip(slopes).for_each(|(bend, slope)| bend.1 += slope.1);
            bends
        };
        Stencil {
            stations: both(x, self.count(), 1.0),
            lobe: both(x, self.per_lobe * LOBE_REFINEMENT, finer),
        }
    }
}

/// Second derivatives of the weights with respect to x, times `rate`.
fn spline_bends(x: f64, count: usize, rate: f64) -> [(usize, f64); 4] {
    at_stations(x, count, |t, u| [rate * u, rate * (3.0 * t - 2.0), rate * (3.0 * u - 2.0), rate * t])
}

/// Cubic B-spline weights at x on a periodic grid of `count` cells of unit length.
fn spline_weights(x: f64, count: usize) -> [(usize, f64); 4] {
    at_stations(x, count, |t, u| {
        [
            u * u * u / 6.0,
            (4.0 - 3.0 * t * t * (2.0 - t)) / 6.0,
            (4.0 - 3.0 * u * u * (2.0 - u)) / 6.0,
            t * t * t / 6.0,
        ]
    })
}

/// Their derivatives with respect to x, times `rate`.
fn spline_slopes(x: f64, count: usize, rate: f64) -> [(usize, f64); 4] {
    at_stations(x, count, |t, u| {
        [-0.5 * rate * u * u, rate * t * (1.5 * t - 2.0), -rate * u * (1.5 * u - 2.0), 0.5 * rate * t * t]
    })
}

/// Four neighbours of x with weights from its place t = 1 − u in the cell.
#[inline]
fn at_stations(x: f64, count: usize, weights: impl Fn(f64, f64) -> [f64; 4]) -> [(usize, f64); 4] {
    let cell = x.floor();
    let t = x - cell;
    let weights = weights(t, 1.0 - t);
    // Trial states of a solver may turn a disc by any angle, and the conversion saturates.
    let mut index = (cell as isize).saturating_sub(1).rem_euclid(count as isize) as usize;
    weights.map(|weight| {
        let here = index;
        index = if index + 1 == count { 0 } else { index + 1 };
        (here, weight)
    })
}

impl FlankStations {
    /// B-spline coefficients c of a periodic sequence: (c_{s−1} + 4 c_s + c_{s+1})/6 = v_s, by the recursive
    /// filter of Unser (IEEE Signal Processing Magazine 16 (1999) 22). `stride` is the distance of neighbours
    /// in `values`.
    pub(super) fn filter(values: &mut [f64], offset: usize, stride: usize, count: usize) {
        let pole = 3.0_f64.sqrt() - 2.0;
        let at = |s: usize| offset + (s % count) * stride;
        // |pole|^60 is below rounding: the start is exact to that.
        let warm = 60.min(count);
        let mut power = 1.0;
        let mut start = 0.0;
        for k in 0..warm {
            start += power * values[at(count - k)];
            power *= pole;
        }
        values[at(0)] = start;
        for s in 1..count {
            values[at(s)] += pole * values[at(s - 1)];
        }
        // Backwards: c_s = pole (c_{s+1} − y_s), times 6.
        power = pole;
        let mut end = 0.0;
        for k in 0..warm {
            end -= power * values[at(count - 1 + k)];
            power *= pole;
        }
        values[at(count - 1)] = end;
        for s in (0..count - 1).rev() {
            values[at(s)] = pole * (values[at(s + 1)] - values[at(s)]);
        }
        (0..count).for_each(|s| values[at(s)] *= 6.0);
    }

    /// Coefficients of values at the stations.
    pub fn coefficients(&self, values: Vec<f64>) -> Vec<f64> {
        FlankStations::periodic_coefficients(values)
    }

    pub(super) fn periodic_coefficients(mut values: Vec<f64>) -> Vec<f64> {
        let count = values.len();
        FlankStations::filter(&mut values, 0, 1, count);
        values
    }

    /// Values at the stations from coefficients.
    pub(super) fn values(coefficients: &[f64]) -> Vec<f64> {
        let n = coefficients.len();
        (0..n)
            .map(|s| {
                (coefficients[(s + n - 1) % n] + 4.0 * coefficients[s] + coefficients[(s + 1) % n]) / 6.0
            })
            .collect()
    }
}

/// A weighted mean of nodal displacements along one direction: both a unit force (its weights) and a reading
/// (their sum with u).
#[derive(Debug, Clone)]
pub struct NodalWeights {
    /// (node, weight); the weights sum to 1.
    pub nodes: Vec<(usize, f64)>,
    /// Unit direction in the plane.
    pub direction: Vec2,
}

impl NodalWeights {
    /// Adds `scale` times the unit force to generalised forces.
    pub fn add_force(&self, map: &DofMap, forces: &mut [f64], scale: f64) {
        for (node, weight) in &self.nodes {
            map.add_force(forces, *node, 0, scale * weight * self.direction.x);
            map.add_force(forces, *node, 1, scale * weight * self.direction.y);
        }
    }

    /// Mean displacement along the direction.
    pub fn read(&self, map: &DofMap, unknowns: &[f64]) -> f64 {
        self.terms(map).iter().map(|(dof, c)| c * unknowns[*dof]).sum()
    }

    /// As a sparse row over the unknowns.
    pub fn terms(&self, map: &DofMap) -> Vec<(usize, f64)> {
        let mut terms = Vec::with_capacity(2 * self.nodes.len());
        for (node, weight) in &self.nodes {
            for (component, share) in [(0, self.direction.x), (1, self.direction.y)] {
                terms.extend(
                    map.terms(*node, component)
                        .into_iter()
                        .filter(|(dof, _)| *dof != super::assembly::HELD)
                        .map(|(dof, c)| (dof, c * weight * share)),
                );
            }
        }
        terms
    }
}

/// Finds load and reading operators on one mesh of a disc.
pub struct FlankSurface<'a> {
    mesh: &'a Mesh,
    profile: &'a Profile,
    arc: FlankArc,
    /// Half the width of the patch over which a unit load is spread, m of arc.
    patch: f64,
    /// Arc positions of the flank edges' first nodes.
    edge_arcs: Vec<f64>,
}

impl<'a> FlankSurface<'a> {
    /// `patch`: half width of the loaded patch in m; about an edge length.
    pub fn new(mesh: &'a Mesh, profile: &'a Profile, patch: f64) -> FlankSurface<'a> {
        let arc = FlankArc::new(profile);
        let edge_arcs = mesh.plane.edges_of(0).map(|edge| arc.arc(edge.parameters[0])).collect();
        FlankSurface { mesh, profile, arc, patch, edge_arcs }
    }

    fn inward(&self, tau: f64) -> Vec2 {
        -self.profile.outward_normal(tau)
    }

    /// Unit force along the inward normal at τ, spread with a cos² over the patch and evenly through the
    /// width. The same weights read the mean normal displacement of the patch.
    pub fn surface(&self, tau: f64) -> NodalWeights {
        let edges: Vec<_> = self.mesh.plane.edges_of(0).collect();
        let perimeter = self.arc.lobe_length() * self.profile.lobe_count() as f64;
        let centre = self.arc.arc(tau).rem_euclid(perimeter);
        let mut weights: std::collections::BTreeMap<usize, f64> = std::collections::BTreeMap::new();
        // From the edge holding the far end of the patch onwards.
        let start =
            self.edge_arcs.partition_point(|arc| *arc <= (centre - self.patch).rem_euclid(perimeter)).max(1)
                - 1;
        for step in 0..edges.len() {
            let edge = edges[(start + step) % edges.len()];
            let offset =
                |t: f64| (self.arc.arc(t) - centre + 0.5 * perimeter).rem_euclid(perimeter) - 0.5 * perimeter;
            if offset(edge.parameters[0]) > self.patch {
                break;
            }
            let places = edge.nodes.map(|n| self.mesh.plane.nodes[n]);
            // At share x of the edge: density times line element, or nothing outside the patch.
            let density = |x: f64| {
                let t: f64 = shape_edge(x).iter().zip(edge.parameters).map(|(n, t)| n * t).sum();
                let s = offset(t) / self.patch;
                let slope: Vec2 = gradient_edge(x).iter().zip(places).map(|(n, p)| *n * p).sum();
                if s.abs() < 1.0 {
                    (0.5 * std::f64::consts::PI * s).cos().powi(2) * slope.norm()
                } else {
                    0.0
                }
            };
            match self.mesh.kind {
                ElementKind::T6 => {
                    for (x, w) in LINE_4 {
                        for (node, n) in edge.nodes.into_iter().zip(shape_edge(x)) {
                            *weights.entry(node).or_default() += w * density(x) * n;
                        }
                    }
                }
                ElementKind::Tet10 => {
                    for layer in 0..(self.mesh.levels.len() - 1) / 2 {
                        for face in side_faces(edge.nodes) {
                            for (at, w) in TRIANGLE_6 {
                                let shape = shape_t6(at);
                                let corners = [at[0], at[1], 1.0 - at[0] - at[1]];
                                let x: f64 = (0..3).map(|i| corners[i] * face.share[i]).sum();
                                for ((node, half), n) in face.nodes.iter().zip(shape) {
                                    let node = (2 * layer + half) * self.mesh.plane.nodes.len() + node;
                                    *weights.entry(node).or_default() += w * density(x) * n;
                                }
                            }
                        }
                    }
                }
            }
        }
        let total: f64 = weights.values().sum();
        NodalWeights {
            nodes: weights.into_iter().map(|(node, weight)| (node, weight / total)).collect(),
            direction: self.inward(tau),
        }
    }

    /// Displacement along the inward normal at depth h below the flank place τ, the mean through the width.
    ///
    /// # Errors
    /// [`FemError::OutsideMesh`] if that place is not in the metal.
    pub fn at_depth(&self, tau: f64, depth: f64) -> Result<NodalWeights, FemError> {
        let direction = self.inward(tau);
        let point = self.profile.flank_point(tau) + depth * direction;
        let outside = || FemError::OutsideMesh {
            what: format!("the place {:.3} mm below the flank at τ = {:.3}°", depth * 1e3, tau.to_degrees()),
        };
        let (triangle, [l0, l1]) = self.mesh.plane.locate(point).ok_or_else(outside)?;
        let corners = self.mesh.plane.triangles[triangle];
        let nodes = match self.mesh.kind {
            ElementKind::T6 => corners.into_iter().zip(shape_t6([l0, l1])).collect(),
            ElementKind::Tet10 => {
                let layers = (self.mesh.levels.len() - 1) / 2;
                let mut nodes = Vec::new();
                for layer in 0..layers {
                    for (z, weight) in LINE_4 {
                        let (element, at) = self
                            .tetrahedron_at(layer, triangle, [l0, l1, 1.0 - l0 - l1], z)
                            .ok_or_else(outside)?;
                        let connectivity = &self.mesh.connectivity[10 * element..10 * element + 10];
                        nodes.extend(
                            connectivity
                                .iter()
                                .copied()
                                .zip(shape_tet10(at).map(|n| n * weight / layers as f64)),
                        );
                    }
                }
                nodes
            }
        };
        Ok(NodalWeights { nodes, direction })
    }

    /// The tetrahedron of a prism and the volume coordinates in it at area coordinates and share z of the
    /// layer's height.
    fn tetrahedron_at(
        &self,
        layer: usize,
        triangle: usize,
        area: [f64; 3],
        z: f64,
    ) -> Option<(usize, [f64; 3])> {
        let per_level = self.mesh.plane.nodes.len();
        let corners = self.mesh.plane.triangles[triangle];
        self.mesh.prism_elements(layer, triangle).find_map(|element| {
            // Corner k of the tetrahedron in prism coordinates (area coordinate 0, 1, height).
            let place = |k: usize| {
                let node = self.mesh.connectivity[10 * element + k];
                let (level, plane) = (node / per_level, node % per_level);
                let mut p = [0.0, 0.0, (level - 2 * layer) as f64 / 2.0];
                for i in 0..2 {
                    p[i] = f64::from(u8::from(plane == corners[i]));
                }
                nalgebra::Vector3::from(p)
            };
            let base = place(0);
            let matrix =
                nalgebra::Matrix3::from_columns(&[place(1) - base, place(2) - base, place(3) - base]);
            let l = matrix.try_inverse()? * (nalgebra::Vector3::new(area[0], area[1], z) - base);
            let inside = l.iter().all(|v| *v > -1e-9) && l.sum() < 1.0 + 1e-9;
            inside.then_some((element, [l.x, l.y, l.z]))
        })
    }
}

/// A triangle on the side of a prism: six nodes as (plane node, half layers up) and the share of the edge at
/// its corners.
struct SideFace {
    nodes: [(usize, usize); 6],
    share: [f64; 3],
}

/// The two triangles over a plane edge (first, last, middle node); the diagonal starts at the lower corner of
/// smaller index.
fn side_faces([a, b, m]: [usize; 3]) -> [SideFace; 2] {
    let (p, q, x) = if a < b { (a, b, [0.0, 1.0]) } else { (b, a, [1.0, 0.0]) };
    [
        SideFace { nodes: [(p, 0), (q, 0), (q, 2), (m, 0), (q, 1), (m, 1)], share: [x[0], x[1], x[1]] },
        SideFace { nodes: [(p, 0), (q, 2), (p, 2), (m, 1), (m, 2), (p, 1)], share: [x[0], x[1], x[0]] },
    ]
}

#[cfg(test)]
mod tests {
    use super::spline_weights;

    /// Weights of any finite place add up to 1, also where whole numbers have no more digits.
    #[test]
    fn weights_exist_at_any_place() {
        for x in [0.0, 39.999, -1e-9, -7.3, 1e9, -1e18, -1e300, 1e300] {
            let weights = spline_weights(x, 40);
            assert!(weights.iter().all(|(station, _)| *station < 40), "{x}");
            assert!((weights.iter().map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-12, "{x}");
        }
    }
}
