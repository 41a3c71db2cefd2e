//! Closed outlines of straight lines and circular arcs: windows, pillars, grooves.

use std::f64::consts::{FRAC_PI_2, PI};

use super::{Vec2, cross, unit};

/// A piece of an outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Segment {
    /// A straight piece.
    Line {
        /// Beginning, m.
        from: Vec2,
        /// End, m.
        to: Vec2,
    },
    /// From the angle `start` (rad) about `centre` by `sweep` (rad), counter-clockwise where positive.
    Arc {
        /// m.
        centre: Vec2,
        /// m.
        radius: f64,
        /// Direction of the beginning from the centre, rad.
        start: f64,
        /// Angle from beginning to end, rad.
        sweep: f64,
    },
}

impl Segment {
    /// The point at a share s in [0, 1] of the length.
    pub fn point(&self, s: f64) -> Vec2 {
        match self {
            Segment::Line { from, to } => from * (1.0 - s) + to * s,
            Segment::Arc { centre, radius, start, sweep } => centre + *radius * unit(start + s * sweep),
        }
    }

    /// m.
    pub fn length(&self) -> f64 {
        match self {
            Segment::Line { from, to } => (to - from).norm(),
            Segment::Arc { radius, sweep, .. } => radius * sweep.abs(),
        }
    }

    /// Shortest distance of a point in m.
    pub fn distance(&self, point: Vec2) -> f64 {
        match self {
            Segment::Line { from, to } => {
                let along = to - from;
                let s = ((point - from).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                (from + s * along - point).norm()
            }
            Segment::Arc { centre, radius, start, sweep } => {
                let arm = point - centre;
                let turn = (arm.y.atan2(arm.x) - start) * sweep.signum();
                if turn.rem_euclid(2.0 * PI) <= sweep.abs() {
                    (arm.norm() - radius).abs()
                } else {
                    (self.point(0.0) - point).norm().min((self.point(1.0) - point).norm())
                }
            }
        }
    }

    /// Number of crossings of a ray from a point along +x with the segment, whose ends have the heights `ends`.
    /// A monotonically rising or falling piece includes one of its ends; neighbours use the same height for
    /// their common end, so that a ray through it crosses once or not at all.
    fn crossings(&self, point: Vec2, ends: [f64; 2]) -> usize {
        let spans = |a: f64, b: f64| (a > point.y) != (b > point.y);
        match self {
            Segment::Line { from, to } => {
                let x = from.x + (point.y - from.y) / (to.y - from.y) * (to.x - from.x);
                usize::from(spans(ends[0], ends[1]) && point.x < x)
            }
            Segment::Arc { centre, radius, start, sweep } => {
                // Split where the tangent is horizontal, at π/2 + kπ: each part lies on one side of the centre.
                let (low, high) = (start.min(start + sweep), start.max(start + sweep));
                let [first, last] = if *sweep < 0.0 { [ends[1], ends[0]] } else { ends };
                let from = ((low - FRAC_PI_2) / PI).ceil() as i64;
                let cuts =
                    (from..).map(|k| (k, k as f64 * PI + FRAC_PI_2)).take_while(|(_, angle)| *angle < high);
                let top = |k: i64| centre.y + if k % 2 == 0 { *radius } else { -radius };
                let pieces = cuts.map(|(k, angle)| (angle, top(k))).chain([(high, last)]);
                let half = (radius * radius - (point.y - centre.y).powi(2)).max(0.0).sqrt();
                let (mut count, mut before) = (0, (low, first));
                for end in pieces {
                    let side = (0.5 * (before.0 + end.0)).cos().signum();
                    let crosses = spans(before.1, end.1) && point.x < centre.x + side * half;
                    count += usize::from(crosses);
                    before = end;
                }
                count
            }
        }
    }

    /// Area (m²) swept by the radius vector from the origin and its polar moment (m⁴): exact for lines, Gauss's
    /// rule on parts of at most 15° for arcs.
    fn sweep(&self) -> (f64, f64) {
        match self {
            Segment::Line { from, to } => {
                let c = cross(*from, *to);
                (0.5 * c, c / 12.0 * (from.norm_squared() + from.dot(to) + to.norm_squared()))
            }
            Segment::Arc { centre, radius, start, sweep } => {
                let pieces = (sweep.abs() / 0.26).ceil().max(1.0);
                let step = sweep / pieces;
                let mut sum = (0.0, 0.0);
                for i in 0..pieces as usize {
                    for (x, w) in [(-0.6, 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6, 5.0 / 18.0)] {
                        let x = 0.5 + 0.5 * x * (5.0_f64 / 3.0).sqrt();
                        let e = unit(start + step * (i as f64 + x));
                        let p = centre + *radius * e;
                        let area = 0.5 * w * step * radius * p.dot(&e);
                        sum.0 += area;
                        sum.1 += 0.5 * area * p.norm_squared();
                    }
                }
                sum
            }
        }
    }
}

/// A closed curve, traversed counter-clockwise; its segments join end to end.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// Pieces in order; the end of each is the beginning of the next.
    pub segments: Vec<Segment>,
}

impl Outline {
    /// t = i + s is the point at share s of segment i; t is taken modulo the number of segments.
    pub fn point(&self, t: f64) -> Vec2 {
        let t = t.rem_euclid(self.segments.len() as f64);
        let i = (t.floor() as usize).min(self.segments.len() - 1);
        self.segments[i].point(t - i as f64)
    }

    /// Parameters at distances of about `size` (m), at least one per segment and per 50° of an arc.
    pub fn sample(&self, size: f64) -> Vec<f64> {
        let mut parameters = Vec::new();
        for (i, segment) in self.segments.iter().enumerate() {
            let by_angle = match segment {
                Segment::Line { .. } => 1.0,
                Segment::Arc { sweep, .. } => (sweep.abs().to_degrees() / 50.0).ceil(),
            };
            let count = (segment.length() / size).round().max(by_angle).max(1.0) as usize;
            parameters.extend((0..count).map(|k| i as f64 + k as f64 / count as f64));
        }
        parameters
    }

    /// Enclosed area in m².
    pub fn area(&self) -> f64 {
        self.segments.iter().map(|segment| segment.sweep().0).sum()
    }

    /// Polar second moment of the enclosed area about the origin in m⁴.
    pub fn polar_moment(&self) -> f64 {
        self.segments.iter().map(|segment| segment.sweep().1).sum()
    }

    /// Shortest distance of a point from the curve in m.
    pub fn distance(&self, point: Vec2) -> f64 {
        self.segments.iter().map(|segment| segment.distance(point)).fold(f64::INFINITY, f64::min)
    }

    /// Whether a point lies inside: a ray along +x crosses the curve an odd number of times.
    pub fn contains(&self, point: Vec2) -> bool {
        let heights = self.segments.iter().map(|segment| segment.point(0.0).y);
        let ends = heights.clone().zip(heights.cycle().skip(1)).map(|(start, end)| [start, end]);
        self.segments.iter().zip(ends).map(|(segment, ends)| segment.crossings(point, ends)).sum::<usize>()
            % 2
            == 1
    }
}

/// An annular sector with rounded corners about the machine's axis: a window of the disc, the section of a
/// pillar. All in m and rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sector {
    /// Radius of the inner arc.
    pub inner_radius: f64,
    /// Radius of the outer arc.
    pub outer_radius: f64,
    /// Angle of its middle.
    pub centre_angle: f64,
    /// From the middle to either straight side.
    pub half_angle: f64,
    /// Radius of all four corners.
    pub corner_radius: f64,
}

impl Sector {
    /// Whether the radii are compatible: the corners leave a part of every side.
    pub fn is_sound(&self) -> bool {
        let Sector { inner_radius: a, outer_radius: b, half_angle, corner_radius: c, .. } = *self;
        let fits = |r: f64| c < r && (c / r).asin() < half_angle;
        a > 0.0 && b > a && c > 0.0 && half_angle > 0.0 && half_angle < PI && fits(b - c) && fits(a + c) && {
            ((b - c).powi(2) - c * c).sqrt() > ((a + c).powi(2) - c * c).sqrt()
        }
    }

    /// Its outline, counter-clockwise from the outer arc.
    pub fn outline(&self) -> Outline {
        let Sector { inner_radius: a, outer_radius: b, centre_angle: m, half_angle: h, corner_radius: c } =
            *self;
        let (outer, inner) = ((c / (b - c)).asin(), (c / (a + c)).asin());
        let arc =
            |centre: Vec2, radius: f64, start: f64, sweep: f64| Segment::Arc { centre, radius, start, sweep };
        let (far, near) = (((b - c).powi(2) - c * c).sqrt(), ((a + c).powi(2) - c * c).sqrt());
        let side = |sign: f64, from: f64, to: f64| Segment::Line {
            from: from * unit(m + sign * h),
            to: to * unit(m + sign * h),
        };
        Outline {
            segments: vec![
                arc(Vec2::zeros(), b, m - h + outer, 2.0 * (h - outer)),
                arc((b - c) * unit(m + h - outer), c, m + h - outer, FRAC_PI_2 + outer),
                side(1.0, far, near),
                arc((a + c) * unit(m + h - inner), c, m + h + FRAC_PI_2, FRAC_PI_2 - inner),
                arc(Vec2::zeros(), a, m + h - inner, -2.0 * (h - inner)),
                arc((a + c) * unit(m - h + inner), c, m - h + inner + PI, FRAC_PI_2 - inner),
                side(-1.0, near, far),
                arc((b - c) * unit(m - h + outer), c, m - h - FRAC_PI_2, FRAC_PI_2 + outer),
            ],
        }
    }

    /// The same turned about the machine's axis by an angle in rad.
    pub fn turned(&self, angle: f64) -> Sector {
        Sector { centre_angle: self.centre_angle + angle, ..*self }
    }

    /// Smallest distance in m between this pillar and the edge of the window around it in the middle position;
    /// negative where the pillar extends beyond the window. From a fine sampling of the pillar and the exact
    /// window.
    pub fn clearance_in(&self, window: &Sector) -> f64 {
        let (own, around) = (self.outline(), window.outline());
        let mut smallest = f64::INFINITY;
        for t in own.sample(0.002 * self.outer_radius) {
            let point = own.point(t);
            let sign = if around.contains(point) { 1.0 } else { -1.0 };
            smallest = smallest.min(sign * around.distance(point));
        }
        smallest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sector() -> Sector {
        Sector {
            inner_radius: 25e-3,
            outer_radius: 53e-3,
            centre_angle: 0.4,
            half_angle: 0.9,
            corner_radius: 4e-3,
        }
    }

    /// Segments join with common tangents, and the polygon through them has the same area and moment.
    #[test]
    fn a_sector_closes_and_has_the_area_of_its_polygon() {
        let outline = sector().outline();
        assert!(sector().is_sound());
        for (i, segment) in outline.segments.iter().enumerate() {
            let next = &outline.segments[(i + 1) % outline.segments.len()];
            assert!((segment.point(1.0) - next.point(0.0)).norm() < 1e-15, "segment {i}");
            let h = 1e-6;
            let before = (segment.point(1.0) - segment.point(1.0 - h)).normalize();
            let after = (next.point(h) - next.point(0.0)).normalize();
            assert!((before - after).norm() < 1e-4, "segment {i}: {before} {after}");
        }
        let points: Vec<Vec2> = (0..80_000).map(|k| outline.point(k as f64 * 1e-4)).collect();
        let (mut area, mut moment) = (0.0, 0.0);
        for (p, q) in points.iter().zip(points.iter().cycle().skip(1)) {
            let c = cross(*p, *q);
            area += 0.5 * c;
            moment += c / 12.0 * (p.norm_squared() + p.dot(q) + q.norm_squared());
        }
        assert!((outline.area() / area - 1.0).abs() < 1e-8, "{} {area}", outline.area());
        assert!((outline.polar_moment() / moment - 1.0).abs() < 1e-8);
        // Nearly sharp: β (b² − a²).
        let sharp = Sector { corner_radius: 1e-7, ..sector() };
        let exact = 0.9 * (53e-3f64.powi(2) - 25e-3f64.powi(2));
        assert!((sharp.outline().area() / exact - 1.0).abs() < 1e-8);
    }

    /// `contains` agrees with the winding number of a fine polygon, also on rays through ends and extremes of
    /// the pieces.
    #[test]
    fn inside_is_where_the_curve_winds_around() {
        for turn in [0.0, 0.4, 1.3, 2.9, -2.2] {
            let outline = Sector { centre_angle: turn, ..sector() }.outline();
            let polygon: Vec<Vec2> = (0..1000).map(|k| outline.point(f64::from(k) * 8e-3)).collect();
            let winding = |point: Vec2| {
                let arms = polygon.iter().map(|p| p - point);
                let turns = arms.clone().zip(arms.cycle().skip(1)).map(|(a, b)| cross(a, b).atan2(a.dot(&b)));
                (turns.sum::<f64>() / (2.0 * PI)).round() as i32
            };
            let heights = outline.segments.iter().flat_map(|segment| match segment {
                Segment::Line { from, .. } => vec![from.y],
                Segment::Arc { centre, radius, .. } => {
                    vec![segment.point(0.0).y, centre.y + radius, centre.y - radius, centre.y]
                }
            });
            let rows = heights.chain((-30..30).map(|i| f64::from(i) * 2.1e-3));
            let points = rows.flat_map(|y| (-30..30).map(move |i| Vec2::new(f64::from(i) * 2.03e-3, y)));
            let mut inside = 0;
            for point in points.filter(|point| outline.distance(*point) > 1e-5) {
                assert_eq!(outline.contains(point), winding(point) == 1, "{turn}: {point}");
                inside += usize::from(outline.contains(point));
            }
            assert!(inside > 100, "{inside}");
        }
    }

    /// A pillar whose outline is offset inwards by w on all sides (concentric corners) has the distance w from
    /// its window.
    #[test]
    fn clearance_of_a_parallel_pillar_is_its_offset() {
        let w = 2e-3;
        let window = sector();
        let middle = 0.5 * (window.inner_radius + window.outer_radius);
        let pillar = Sector {
            inner_radius: window.inner_radius + w,
            outer_radius: window.outer_radius - w,
            half_angle: window.half_angle - 1.2 * w / middle,
            corner_radius: window.corner_radius - w,
            ..window
        };
        let clearance = pillar.clearance_in(&window);
        assert!(clearance > 0.6 * w && clearance < w * (1.0 + 1e-9), "{clearance}");
        // Moved past the window's edge it sticks out.
        let turned = Sector { centre_angle: pillar.centre_angle + 0.2, ..pillar };
        assert!(turned.clearance_in(&window) < 0.0);
        assert!(window.outline().contains(39e-3 * unit(0.4)) && !window.outline().contains(Vec2::zeros()));
    }
}
