//! Closed curves that bound a plane section: circles, polygons, flanks, outlines.

use std::f64::consts::TAU;

use crate::geometry::{Outline, Profile, Vec2, unit};

/// A closed boundary curve p(t), run through counter-clockwise for t in [0, period).
#[derive(Debug, Clone, PartialEq)]
pub enum Boundary {
    /// t is the angle about the centre.
    Circle {
        /// m.
        centre: Vec2,
        /// m.
        radius: f64,
    },
    /// t counts corners: t = i + s is the point at share s of the edge from corner i to corner i + 1.
    Polygon(Vec<Vec2>),
    /// The flank of a cycloid disc; t is the trace parameter τ.
    Flank(Profile),
    /// Lines and arcs; t counts segments as it does corners of a polygon.
    Outline(Outline),
}

impl Boundary {
    /// Range of t after which the curve closes.
    pub fn period(&self) -> f64 {
        match self {
            Boundary::Circle { .. } | Boundary::Flank(_) => TAU,
            Boundary::Polygon(corners) => corners.len() as f64,
            Boundary::Outline(outline) => outline.segments.len() as f64,
        }
    }

    /// The point p(t), m.
    pub fn point(&self, t: f64) -> Vec2 {
        match self {
            Boundary::Circle { centre, radius } => centre + *radius * unit(t),
            Boundary::Polygon(corners) => {
                let t = t.rem_euclid(corners.len() as f64);
                let i = (t.floor() as usize).min(corners.len() - 1);
                let s = t - i as f64;
                corners[i] * (1.0 - s) + corners[(i + 1) % corners.len()] * s
            }
            Boundary::Flank(profile) => profile.flank_point(t),
            Boundary::Outline(outline) => outline.point(t),
        }
    }

    /// Parameters of boundary nodes at distances of about `size` (m) of arc length over the closed curve, the
    /// same on every lobe or edge.
    pub fn sample(&self, size: f64) -> Vec<f64> {
        match self {
            Boundary::Circle { radius, .. } => {
                let count = ((TAU * radius / size).ceil() as usize).max(12);
                (0..count).map(|i| TAU * i as f64 / count as f64).collect()
            }
            Boundary::Polygon(corners) => {
                let mut parameters = Vec::new();
                for i in 0..corners.len() {
                    let length = (corners[(i + 1) % corners.len()] - corners[i]).norm();
                    let count = ((length / size).round() as usize).max(1);
                    parameters.extend((0..count).map(|k| i as f64 + k as f64 / count as f64));
                }
                parameters
            }
            Boundary::Flank(profile) => {
                let arc = FlankArc::new(profile);
                arc.nodes(((arc.lobe_length() / size).ceil() as usize).max(8))
            }
            Boundary::Outline(outline) => outline.sample(size),
        }
    }

    /// The point halfway between two neighbouring parameters on the true curve, in arc length, because a T6
    /// edge whose mid-side node is not in the middle is mapped nonuniformly.
    pub fn midpoint(&self, from: f64, to: f64) -> (f64, Vec2) {
        let to = if to <= from { to + self.period() } else { to };
        let mut t = 0.5 * (from + to);
        if let Boundary::Flank(_) = self {
            let (a, b) = (self.point(from), self.point(to));
            let (mut low, mut high) = (from, to);
            for _ in 0..40 {
                let p = self.point(t);
                if (p - a).norm_squared() < (p - b).norm_squared() {
                    low = t;
                } else {
                    high = t;
                }
                t = 0.5 * (low + high);
            }
        }
        (t, self.point(t))
    }
}

/// A length along one lobe of the flank against the trace parameter τ in [0, 2π/z_c), tabulated.
///
/// The flank is slow in τ away from the root and fast at it (there its curvature radius is 40 times that of
/// the trace), so equidistant τ would leave the roots coarse.
#[derive(Debug, Clone)]
pub struct FlankArc {
    pitch: f64,
    /// Length in m at equidistant τ of one lobe, and its derivative there per cell: a cubic between two points,
    /// because forces that contain the derivative of the length must be continuous.
    length: Vec<f64>,
    increase: Vec<f64>,
}

impl FlankArc {
    /// Arc length of the flank.
    pub fn new(profile: &Profile) -> FlankArc {
        FlankArc::with_rate(profile, |cos| profile.flank_length_per_meshing_angle(cos))
    }

    /// Half arc length, half meshing angle (scaled to the same length per lobe). The flank's normal, and with
    /// it the compliance, changes rapidly between root and shoulder, where the meshing angle resolves it;
    /// elsewhere it is smooth in arc length.
    pub fn blended_with_meshing_angle(profile: &Profile) -> FlankArc {
        let per_angle = FlankArc::new(profile).lobe_length() / TAU;
        FlankArc::with_rate(profile, |cos| 0.5 * (profile.flank_length_per_meshing_angle(cos) + per_angle))
    }

    /// `rate`: length per radian of meshing angle at cos φ.
    fn with_rate(profile: &Profile, rate: impl Fn(f64) -> f64) -> FlankArc {
        let cells = 4000;
        let increase =
            (0..=cells).map(|i| TAU / cells as f64 * rate((TAU * i as f64 / cells as f64).cos())).collect();
        let mut length = Vec::with_capacity(cells + 1);
        let mut sum = 0.0;
        length.push(0.0);
        for i in 0..cells {
            // Midpoint rule on a smooth periodic integrand.
            sum += TAU / cells as f64 * rate((TAU * (i as f64 + 0.5) / cells as f64).cos());
            length.push(sum);
        }
        FlankArc { pitch: TAU / profile.lobe_count() as f64, length, increase }
    }

    /// τ of `per_lobe` nodes on every lobe, the first at its root, equidistant in length.
    pub fn nodes(&self, per_lobe: usize) -> Vec<f64> {
        let lobe: Vec<f64> =
            (0..per_lobe).map(|k| self.parameter(self.lobe_length() * k as f64 / per_lobe as f64)).collect();
        let lobes = (TAU / self.pitch).round() as usize;
        (0..lobes).flat_map(|j| lobe.iter().map(move |tau| tau + self.pitch * j as f64)).collect()
    }

    /// Length of one lobe in m.
    pub fn lobe_length(&self) -> f64 {
        self.length[self.length.len() - 1]
    }

    /// Length from the root τ = 0 in m, for any τ (whole lobes are counted).
    pub fn arc(&self, tau: f64) -> f64 {
        let lobe = (tau / self.pitch).floor();
        let x = (tau / self.pitch - lobe) * (self.length.len() - 1) as f64;
        let i = (x as usize).min(self.length.len() - 2);
        lobe * self.lobe_length() + self.length[i] + self.within(i, x - i as f64).0
    }

    /// Derivative of [`FlankArc::arc`].
    pub fn rate(&self, tau: f64) -> f64 {
        let cells = (self.length.len() - 1) as f64;
        let x = (tau / self.pitch).rem_euclid(1.0) * cells;
        let i = (x as usize).min(self.length.len() - 2);
        self.within(i, x - i as f64).1 * cells / self.pitch
    }

    /// Length from the beginning of a cell at the fraction s of it, and its derivative by s: cubic Hermite
    /// interpolation.
    fn within(&self, cell: usize, s: f64) -> (f64, f64) {
        let whole = self.length[cell + 1] - self.length[cell];
        let (first, last) = (self.increase[cell], self.increase[cell + 1]);
        let (square, cube) = (3.0 * whole - 2.0 * first - last, first + last - 2.0 * whole);
        (s * (first + s * (square + s * cube)), first + s * (2.0 * square + 3.0 * s * cube))
    }

    /// τ at a length from the root τ = 0, for any length.
    pub fn parameter(&self, arc: f64) -> f64 {
        let lobe = (arc / self.lobe_length()).floor();
        let rest = arc - lobe * self.lobe_length();
        let i = self.length.partition_point(|l| *l <= rest).clamp(1, self.length.len() - 1) - 1;
        let rest = rest - self.length[i];
        let mut share = rest / (self.length[i + 1] - self.length[i]);
        // The cubic is nearly linear: two steps of Newton's method are exact to rounding.
        for _ in 0..2 {
            let (length, slope) = self.within(i, share);
            share += (rest - length) / slope;
        }
        self.pitch * (lobe + (i as f64 + share) / (self.length.len() - 1) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Length and parameter are inverse functions of each other, and the length and its derivative are
    /// continuous from cell to cell and across lobes.
    #[test]
    fn arc_is_smooth_and_invertible() {
        let profile = crate::templates::tao2024().profile();
        for arc in [FlankArc::new(&profile), FlankArc::blended_with_meshing_angle(&profile)] {
            let cell = TAU / 39.0 / 4000.0;
            for tau in [1e-4, 0.0123, 0.0803, 1.7, 5.9] {
                assert!((arc.parameter(arc.arc(tau)) - tau).abs() < 1e-12);
                let h = 0.01 * cell;
                let slope = (arc.arc(tau + h) - arc.arc(tau - h)) / (2.0 * h);
                assert!((slope / arc.rate(tau) - 1.0).abs() < 1e-6, "{slope} {}", arc.rate(tau));
            }
            for node in [0.0, 1.0, 17.0, 1999.0, 3999.0, 4000.0, 4001.0].map(|node| node * cell) {
                let (before, after) = (arc.rate(node - 1e-9 * cell), arc.rate(node + 1e-9 * cell));
                assert!((before / after - 1.0).abs() < 1e-9, "{node}: {before} {after}");
            }
        }
    }
}
