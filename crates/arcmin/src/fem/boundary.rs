use std::f64::consts::TAU;

use crate::geometry::{Profile, Vec2, unit};

/// A closed boundary curve p(t), run through counter-clockwise for t in [0, period).
#[derive(Debug, Clone, PartialEq)]
pub enum Boundary {
    /// t is the angle about the centre.
    Circle { centre: Vec2, radius: f64 },
    /// t counts corners: t = i + s is the point at share s of the edge from corner i to corner i + 1.
    Polygon(Vec<Vec2>),
    /// The flank of a cycloid disc; t is the trace parameter τ.
    Flank(Profile),
}

impl Boundary {
    pub fn period(&self) -> f64 {
        match self {
            Boundary::Circle { .. } | Boundary::Flank(_) => TAU,
            Boundary::Polygon(corners) => corners.len() as f64,
        }
    }

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
        }
    }

    /// Parameters of boundary nodes about `size` (m) apart in arc length, one full turn, the same on every lobe or edge.
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
        }
    }

    /// The point halfway between two neighbouring parameters, on the true curve: halfway in arc length, since a T6 edge whose
    /// mid-side node is off the middle maps its points unevenly.
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
/// The flank is slow in τ away from the root and fast at it (there its curvature radius is 40 times that of the trace),
/// so equidistant τ would leave the roots coarse.
#[derive(Debug, Clone)]
pub struct FlankArc {
    pitch: f64,
    /// Length in m at equidistant τ of one lobe.
    length: Vec<f64>,
}

impl FlankArc {
    /// Arc length of the flank.
    pub fn new(profile: &Profile) -> FlankArc {
        FlankArc::with_rate(profile, |cos| profile.flank_length_per_meshing_angle(cos))
    }

    /// Half arc length, half meshing angle (scaled to the same length per lobe). The flank's normal and with it the compliance turn fast
    /// between root and shoulder, where the meshing angle resolves it; the rest is smooth in arc length.
    pub fn blended_with_meshing_angle(profile: &Profile) -> FlankArc {
        let per_angle = FlankArc::new(profile).lobe_length() / TAU;
        FlankArc::with_rate(profile, |cos| 0.5 * (profile.flank_length_per_meshing_angle(cos) + per_angle))
    }

    /// `rate`: length per radian of meshing angle at cos φ.
    fn with_rate(profile: &Profile, rate: impl Fn(f64) -> f64) -> FlankArc {
        let cells = 4000;
        let mut length = Vec::with_capacity(cells + 1);
        let mut sum = 0.0;
        length.push(0.0);
        for i in 0..cells {
            // Midpoint rule on a smooth periodic integrand.
            sum += TAU / cells as f64 * rate((TAU * (i as f64 + 0.5) / cells as f64).cos());
            length.push(sum);
        }
        FlankArc { pitch: TAU / profile.lobe_count() as f64, length }
    }

    /// τ of `per_lobe` nodes on every lobe, the first at its root, equidistant in length.
    pub fn nodes(&self, per_lobe: usize) -> Vec<f64> {
        let lobe: Vec<f64> = (0..per_lobe).map(|k| self.parameter(self.lobe_length() * k as f64 / per_lobe as f64)).collect();
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
        lobe * self.lobe_length() + self.length[i] + (x - i as f64) * (self.length[i + 1] - self.length[i])
    }

    /// Derivative of [`FlankArc::arc`], as tabulated: constant within a cell.
    pub fn rate(&self, tau: f64) -> f64 {
        let cells = (self.length.len() - 1) as f64;
        let i = ((tau / self.pitch).rem_euclid(1.0) * cells) as usize;
        let i = i.min(self.length.len() - 2);
        (self.length[i + 1] - self.length[i]) * cells / self.pitch
    }

    /// τ at a length from the root τ = 0, for any length.
    pub fn parameter(&self, arc: f64) -> f64 {
        let lobe = (arc / self.lobe_length()).floor();
        let rest = arc - lobe * self.lobe_length();
        let i = self.length.partition_point(|l| *l <= rest).clamp(1, self.length.len() - 1) - 1;
        let share = (rest - self.length[i]) / (self.length[i + 1] - self.length[i]);
        self.pitch * (lobe + (i as f64 + share) / (self.length.len() - 1) as f64)
    }
}
