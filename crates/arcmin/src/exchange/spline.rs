//! Cubic splines through an outline.

use super::outline::Outline;
use crate::geometry::{Vec2, cross};

/// A cubic B-spline: control points and knots, each knot with its multiplicity.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicSpline {
    /// Control points, m.
    pub control: Vec<Vec2>,
    /// Knots with their multiplicities, increasing.
    pub knots: Vec<(f64, usize)>,
}

/// A spline along an outline from one parameter to another.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedSpline {
    /// The whole curve.
    pub spline: CubicSpline,
    /// The same curve in parts with a few sections, end to end.
    pub parts: Vec<CubicSpline>,
    /// Bound of its distance from the outline in m.
    pub deviation: f64,
}

/// Largest number of sections in a part, and smallest number of parts. Readers integrate over a face or an edge
/// with a Gauss rule of limited order: with a whole flank as one face, the volume of a disc in OpenCascade has
/// an error of up to 0.4 %, with these parts of about 1e-6.
const SPANS: usize = 6;
const PARTS: usize = 4;
/// Sine of the smallest angle between two splines that is a corner.
const CORNER: f64 = 1e-6;
/// Samples per section at which the deviation is computed.
const SAMPLES: usize = 16;

impl FittedSpline {
    /// Interpolating spline with continuous curvature through points of the outline, over arc length, with the
    /// outline's tangents at both ends. Sections are halved until each is within `tolerance`.
    ///
    /// The deviation e of a section is computed at sixteen points, normal to the outline. Between them it can
    /// exceed the larger neighbour by δ²/8 max|e″|, where e″ is the difference of curvatures, for which twice
    /// the larger value of both ends is used. The bound is [`FittedSpline::deviation`].
    pub fn along(outline: &Outline, from: f64, to: f64, tolerance: f64) -> FittedSpline {
        let mut nodes: Vec<f64> = (0..=6).map(|i| from + (to - from) * f64::from(i) / 6.0).collect();
        // 6 · 2^12 sections per flank are finer than a nanometre for any regular flank.
        let mut rounds = 12;
        loop {
            let pieces = Pieces::through(outline, &nodes);
            let errors: Vec<f64> =
                (0..nodes.len() - 1).map(|i| pieces.deviation(outline, &nodes, i)).collect();
            let deviation = errors.iter().copied().fold(0.0, f64::max);
            if deviation <= tolerance || rounds == 0 {
                return FittedSpline { spline: pieces.spline(), parts: pieces.parts(), deviation };
            }
            rounds -= 1;
            let mut finer = vec![from];
            for (index, pair) in nodes.windows(2).enumerate() {
                if errors[index] > tolerance {
                    finer.push(0.5 * (pair[0] + pair[1]));
                }
                finer.push(pair[1]);
            }
            nodes = finer;
        }
    }
}

struct Pieces {
    arc: Vec<f64>,
    points: Vec<Vec2>,
    slopes: Vec<Vec2>,
}

impl Pieces {
    fn through(outline: &Outline, nodes: &[f64]) -> Pieces {
        let mut arc = vec![0.0];
        for pair in nodes.windows(2) {
            arc.push(arc[arc.len() - 1] + outline.length(pair[0], pair[1]));
        }
        let on: Vec<_> = nodes.iter().map(|tau| outline.at(*tau)).collect();
        let points: Vec<Vec2> = on.iter().map(|p| p.place).collect();
        // m_{i−1}/h_{i−1} + 2 (1/h_{i−1} + 1/h_i) m_i + m_{i+1}/h_i = 3 (Δ_{i−1}/h²_{i−1} + Δ_i/h²_i).
        let n = nodes.len();
        let mut slopes: Vec<Vec2> = on.iter().map(|p| p.tangent).collect();
        let h: Vec<f64> = arc.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mut upper = vec![0.0; n];
        let mut right = slopes.clone();
        for i in 1..n - 1 {
            let (a, c) = (1.0 / h[i - 1], 1.0 / h[i]);
            let load = 3.0 * ((points[i] - points[i - 1]) * a * a + (points[i + 1] - points[i]) * c * c);
            let pivot = 2.0 * (a + c) - a * upper[i - 1];
            upper[i] = c / pivot;
            right[i] = (load - a * right[i - 1]) / pivot;
        }
        for i in (1..n - 1).rev() {
            slopes[i] = right[i] - upper[i] * slopes[i + 1];
        }
        Pieces { arc, points, slopes }
    }

    /// Point, first and second derivative of a section at its parameter x in [0, 1].
    fn at(&self, piece: usize, x: f64) -> (Vec2, Vec2, Vec2) {
        let h = self.arc[piece + 1] - self.arc[piece];
        let (p0, p1) = (self.points[piece], self.points[piece + 1]);
        let (m0, m1) = (self.slopes[piece] * h, self.slopes[piece + 1] * h);
        let d = p1 - p0;
        let (b, c) = (3.0 * d - 2.0 * m0 - m1, m0 + m1 - 2.0 * d);
        (
            p0 + x * (m0 + x * (b + x * c)),
            (m0 + x * (2.0 * b + 3.0 * x * c)) / h,
            (2.0 * b + 6.0 * x * c) / (h * h),
        )
    }

    fn deviation(&self, outline: &Outline, nodes: &[f64], piece: usize) -> f64 {
        let (from, to) = (nodes[piece], nodes[piece + 1]);
        let spacing = (self.arc[piece + 1] - self.arc[piece]) / SAMPLES as f64;
        let samples: Vec<(f64, f64)> = (0..=SAMPLES)
            .map(|i| {
                let x = i as f64 / SAMPLES as f64;
                let (place, d1, d2) = self.at(piece, x);
                // Newton's method for the foot on the outline; the error of the start is less than a section.
                let mut tau = from + (to - from) * x;
                for _ in 0..8 {
                    let p = outline.at(tau);
                    tau += (place - p.place).dot(&p.tangent) / p.speed;
                }
                let p = outline.at(tau);
                let curvature = cross(d1, d2) / d1.norm().powi(3);
                ((place - p.place).norm(), (curvature - p.curvature).abs())
            })
            .collect();
        samples
            .windows(2)
            .map(|pair| pair[0].0.max(pair[1].0) + spacing * spacing / 4.0 * pair[0].1.max(pair[1].1))
            .fold(0.0, f64::max)
    }

    /// The same curve as several splines with approximately equal numbers of sections.
    fn parts(&self) -> Vec<CubicSpline> {
        let pieces = self.arc.len() - 1;
        let count = pieces.div_ceil(SPANS).max(PARTS).min(pieces);
        (0..count)
            .map(|part| {
                let nodes = part * pieces / count..(part + 1) * pieces / count + 1;
                let from = self.arc[nodes.start];
                Pieces {
                    arc: self.arc[nodes.clone()].iter().map(|arc| arc - from).collect(),
                    points: self.points[nodes.clone()].to_vec(),
                    slopes: self.slopes[nodes].to_vec(),
                }
                .spline()
            })
            .collect()
    }

    /// De Boor points by blossoming: the point of the knots (t_i, t_{i+1}, t_{i+2}) is (1 − u) b_1 + u b_2 with
    /// the inner Bézier points of section i and u = (t_{i+2} − t_i)/(t_{i+1} − t_i).
    fn spline(&self) -> CubicSpline {
        let last = self.arc.len() - 1;
        let inner = |i: usize| {
            let h = self.arc[i + 1] - self.arc[i];
            (self.points[i] + h / 3.0 * self.slopes[i], self.points[i + 1] - h / 3.0 * self.slopes[i + 1])
        };
        let mut control = vec![self.points[0], inner(0).0];
        for i in 0..last - 1 {
            let (b1, b2) = inner(i);
            let u = (self.arc[i + 2] - self.arc[i]) / (self.arc[i + 1] - self.arc[i]);
            control.push((1.0 - u) * b1 + u * b2);
        }
        control.push(inner(last - 1).1);
        control.push(self.points[last]);
        let multiplicity = |i: usize| if i == 0 || i == last { 4 } else { 1 };
        CubicSpline {
            control,
            knots: self.arc.iter().enumerate().map(|(i, t)| (*t, multiplicity(i))).collect(),
        }
    }
}

impl CubicSpline {
    /// The spline rotated about the origin.
    pub fn turned(&self, rotation: Vec2) -> CubicSpline {
        let control = self.control.iter().map(|p| crate::geometry::turned(*p, rotation)).collect();
        CubicSpline { control, knots: self.knots.clone() }
    }

    /// This spline followed by `next`, which begins at its end. If the directions agree, the knot between them
    /// is double, so that the tangent is continuous with the speed of the arc length; at a corner it is triple.
    pub fn joined(&self, next: &CubicSpline) -> CubicSpline {
        let mut control = self.control.clone();
        let leg = |from: Vec2, to: Vec2| (to - from).try_normalize(0.0).unwrap_or_default();
        let turn = match (control.as_slice(), next.control.as_slice()) {
            ([.., before, end], [_, after, ..]) => cross(leg(*before, *end), leg(*end, *after)).abs(),
            _ => 0.0,
        };
        let is_corner = turn > CORNER;
        // At a double knot the common end point is not a control point.
        if !is_corner {
            control.pop();
        }
        control.extend(&next.control[1..]);
        let mut knots = self.knots.clone();
        let end = knots.last().map_or(0.0, |knot| knot.0);
        if let Some(last) = knots.last_mut() {
            last.1 = if is_corner { 3 } else { 2 };
        }
        knots.extend(next.knots[1..].iter().map(|(t, m)| (t + end, *m)));
        CubicSpline { control, knots }
    }

    /// Knots repeated by their multiplicities.
    pub fn flat_knots(&self) -> Vec<f64> {
        self.knots.iter().flat_map(|(t, m)| std::iter::repeat_n(*t, *m)).collect()
    }
}
