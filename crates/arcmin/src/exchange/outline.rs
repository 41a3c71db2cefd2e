use std::f64::consts::{PI, TAU};

use super::ExchangeError;
use crate::geometry::{DepthSample, Profile, Relief, Vec2, cross, quarter_turn, turned, unit};

/// The edge of a disc for export: the exact flank less a relief, offset outwards.
///
/// Described by one lobe from root to root; the others are rotated copies. With h(τ) = r + w(φ(τ)), the trace
/// c, its unit tangent T and outward normal n, the edge without offset is P = c − h n, and P′ = (s − h θ′) T −
/// h′ n, where s = |c′| and θ′ is the rotation of the tangent per τ. The offset by d adds d N with the normal N
/// of P itself, so that a worn flank is offset from its worn shape.
///
/// If the flank ends at a tip, the edge continues from its corner to that of the other flank of the lobe: on a
/// circle, or, if the reliefs of the two differ, on a curve whose radius is linear in the angle.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    profile: Profile,
    relief: Relief,
    offset: f64,
    course: Course,
}

/// The curve on which points of an outline lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Course {
    /// The edge.
    Edge,
    /// The flanks of the tooth space around the root nearest to τ, also beyond their ends.
    Flank,
    /// The land of the lobe at τ, also beyond its corners.
    Land,
}

/// A point of an outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutlinePoint {
    /// Parameter around the disc in rad.
    pub tau: f64,
    /// Position, m.
    pub place: Vec2,
    /// Unit tangent, counter-clockwise around the disc.
    pub tangent: Vec2,
    /// |dP/dτ| in m/rad.
    pub speed: f64,
    /// Curvature in 1/m, positive where the edge turns left (convex).
    pub curvature: f64,
}

impl OutlinePoint {
    /// Unit normal out of the metal of the disc.
    pub fn outward_normal(&self) -> Vec2 {
        -quarter_turn(self.tangent)
    }
}

/// Samples per lobe for the checks of regularity and of the tool path.
const CHECKED: usize = 2048;

impl Outline {
    /// The flank `profile` less `relief`, offset outwards by `offset` (m, inwards if negative).
    ///
    /// # Errors
    /// [`ExchangeError::Undercut`] if a tool of the radius |offset| on the outline would cut into the flank, or
    /// if the flank itself is not regular.
    pub fn new(profile: Profile, relief: Relief, offset: f64) -> Result<Outline, ExchangeError> {
        if profile.tip().is_some() && offset != 0.0 {
            return Err(ExchangeError::OffsetOfTips);
        }
        let bare = Outline { profile, relief, offset: 0.0, course: Course::Edge };
        let outline = Outline { offset, ..bare.clone() };
        let step = outline.lobe_pitch() / CHECKED as f64;
        let flank: Vec<OutlinePoint> = (0..CHECKED).map(|i| bare.at(i as f64 * step)).collect();
        let undercut = |tau: f64, radius: f64| ExchangeError::Undercut {
            meshing_angle: outline.profile.meshing_angle(tau),
            offset,
            radius,
        };
        for point in flank.iter().filter(|point| !outline.profile.is_on_land(point.tau)) {
            let along = point.tangent.dot(&quarter_turn(outline.profile.trace(point.tau)));
            if !(along > 0.0) || !point.curvature.is_finite() {
                return Err(undercut(point.tau, 0.0));
            }
            if !(1.0 + offset * point.curvature > 1e-9) {
                return Err(undercut(point.tau, 1.0 / point.curvature.abs()));
            }
        }
        // The tool's circle around each point of its path must be clear of the whole flank; it is sufficient to
        // check two neighbouring lobes on either side.
        let reach = offset.abs();
        let lobes = outline.profile.lobe_count() as i64;
        let around: Vec<Vec2> = (-2..=2_i64)
            .filter(|lobe| lobe.abs() < lobes)
            .flat_map(|lobe| {
                let turn = unit(outline.lobe_pitch() * lobe as f64);
                flank.iter().step_by(4).map(move |point| turned(point.place, turn))
            })
            .collect();
        if reach > 0.0 {
            for point in flank.iter().step_by(8) {
                let centre = point.place + offset * point.outward_normal();
                let nearest =
                    around.iter().map(|p| (p - centre).norm_squared()).fold(f64::INFINITY, f64::min);
                if nearest.sqrt() < reach * (1.0 - 1e-6) - 1e-9 {
                    return Err(undercut(point.tau, nearest.sqrt()));
                }
            }
        }
        Ok(outline)
    }

    /// Flank from which the outline is computed.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// Lobes of the flank, z_c.
    pub fn lobe_count(&self) -> usize {
        self.profile.lobe_count()
    }

    /// Angle of one lobe in rad.
    pub fn lobe_pitch(&self) -> f64 {
        TAU / self.lobe_count() as f64
    }

    /// Parameters in the first lobe, from the root at 0 to the next one, at which the edge is not smooth, with
    /// its crest and both ends; increasing.
    pub fn breaks(&self) -> Vec<f64> {
        let pitch = self.lobe_pitch();
        let Some(end) = self.end() else { return vec![0.0, 0.5 * pitch, pitch] };
        vec![0.0, end, 0.5 * pitch, pitch - end, pitch]
    }

    /// Difference of τ between a root and the end of the flank, if it has one.
    fn end(&self) -> Option<f64> {
        Some(self.profile.tip()?.end / self.lobe_count() as f64)
    }

    /// The smooth curve between two of the [`breaks`](Outline::breaks).
    pub fn between(&self, from: f64, to: f64) -> Outline {
        let course = if self.profile.is_on_land(0.5 * (from + to)) { Course::Land } else { Course::Flank };
        Outline { course, ..self.clone() }
    }

    /// The point at τ, for any angle around the disc.
    pub fn at(&self, tau: f64) -> OutlinePoint {
        let on_land = match self.course {
            Course::Edge => self.profile.is_on_land(tau),
            Course::Flank => false,
            Course::Land => true,
        };
        match self.end() {
            Some(end) if on_land => self.on_land(tau, end),
            _ => self.on_flank(tau),
        }
    }

    /// A point on the land between the corners of the lobe at τ: r e(θ), with r and θ linear in τ.
    fn on_land(&self, tau: f64, end: f64) -> OutlinePoint {
        let pitch = self.lobe_pitch();
        let first = (tau / pitch).floor() * pitch;
        let corners = [first + end, first + pitch - end];
        let [from, to] = corners.map(|corner| self.on_flank(corner).place);
        let middle = first + 0.5 * pitch;
        let back = unit(-middle);
        let [(r0, t0), (r1, t1)] = [from, to].map(|corner| {
            let place = turned(corner, back);
            (place.norm(), place.y.atan2(place.x))
        });
        let width = corners[1] - corners[0];
        let share = (tau - corners[0]) / width;
        let (radius, angle) = (r0 + share * (r1 - r0), middle + t0 + share * (t1 - t0));
        let (rise, turn) = ((r1 - r0) / width, (t1 - t0) / width);
        let out = unit(angle);
        let around = quarter_turn(out);
        let first_rate = rise * out + radius * turn * around;
        let second_rate = 2.0 * rise * turn * around - radius * turn * turn * out;
        let speed = first_rate.norm();
        OutlinePoint {
            tau,
            place: radius * out,
            tangent: first_rate / speed,
            speed,
            curvature: cross(first_rate, second_rate) / speed.powi(3),
        }
    }

    fn on_flank(&self, tau: f64) -> OutlinePoint {
        let lobes = self.lobe_count() as f64;
        let ((e, ez), trace) = (self.profile.directions(tau), self.profile.trace(tau));
        let (_, c1, c2) = self.profile.trace_derivatives(e, ez);
        let c3 = self.profile.trace_third_derivative(e, ez);
        let phi = -(lobes * tau).rem_euclid(TAU);
        let DepthSample { depth, slope, bend } = self.relief.at(if phi <= -PI { phi + TAU } else { phi });
        let (h, h1, h2) = (self.profile.pin_radius + depth, -lobes * slope, lobes * lobes * bend);
        let s = c1.norm();
        let tangent = c1 / s;
        let normal = -quarter_turn(tangent);
        let s1 = c1.dot(&c2) / s;
        let turn = cross(c1, c2) / (s * s);
        let turn1 = cross(c1, c3) / (s * s) - 2.0 * cross(c1, c2) * s1 / (s * s * s);
        // T′ = −θ′ n and n′ = θ′ T.
        let first = (s - h * turn) * tangent - h1 * normal;
        let second = (s1 - 2.0 * h1 * turn - h * turn1) * tangent - ((s - h * turn) * turn + h2) * normal;
        let bare_speed = first.norm();
        let bare_curvature = cross(first, second) / bare_speed.powi(3);
        let own_tangent = first / bare_speed;
        let own_normal = -quarter_turn(own_tangent);
        let stretch = 1.0 + self.offset * bare_curvature;
        OutlinePoint {
            tau,
            place: trace - h * normal + self.offset * own_normal,
            tangent: own_tangent,
            speed: bare_speed * stretch,
            curvature: bare_curvature / stretch,
        }
    }

    /// Meshing angle at τ in (−π, π].
    pub fn meshing_angle(&self, tau: f64) -> f64 {
        self.profile.meshing_angle(tau)
    }

    fn area_and_length_by_parts(&self) -> (f64, f64) {
        let breaks = self.breaks();
        let parts = breaks.windows(2).map(|pair| {
            let course = self.between(pair[0], pair[1]);
            let area = |p: &OutlinePoint| 0.5 * cross(p.place, p.tangent) * p.speed;
            [course.integral(pair[0], pair[1], area), course.length(pair[0], pair[1])]
        });
        let lobes = self.lobe_count() as f64;
        parts.fold((0.0, 0.0), |sum, [area, length]| (sum.0 + lobes * area, sum.1 + lobes * length))
    }

    /// Arc length in m from τ0 to τ1.
    pub fn length(&self, from: f64, to: f64) -> f64 {
        self.integral(from, to, |p| p.speed)
    }

    /// ∫ f dτ from τ0 to τ1, by the Gauss rule of eight points on sections of at most a 64th of a lobe.
    fn integral(&self, from: f64, to: f64, of: impl Fn(&OutlinePoint) -> f64) -> f64 {
        const NODES: [(f64, f64); 4] = [
            (0.183_434_642_495_649_8, 0.362_683_783_378_362),
            (0.525_532_409_916_329, 0.313_706_645_877_887_3),
            (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
            (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
        ];
        let pieces = ((to - from).abs() / self.lobe_pitch() * 64.0).ceil().max(1.0);
        let half = 0.5 * (to - from) / pieces;
        let mut sum = 0.0;
        for piece in 0..pieces as usize {
            let middle = from + (2 * piece + 1) as f64 * half;
            for (x, weight) in NODES {
                sum += weight * (of(&self.at(middle - x * half)) + of(&self.at(middle + x * half)));
            }
        }
        sum * half
    }

    /// Area in m² and length of the whole edge in m: ½∮(x dy − y dx) and ∮ds by the trapezoidal rule, which
    /// converges exponentially for a smooth edge; for one with tips by Gauss's rule from corner to corner.
    pub fn area_and_length(&self) -> (f64, f64) {
        if self.end().is_some() {
            return self.area_and_length_by_parts();
        }
        let count = 2 * CHECKED;
        let step = self.lobe_pitch() / count as f64;
        let (mut area, mut length) = (0.0, 0.0);
        for i in 0..count {
            let p = self.at(i as f64 * step);
            area += 0.5 * cross(p.place, p.tangent) * p.speed;
            length += p.speed;
        }
        let all = step * self.lobe_count() as f64;
        (area * all, length * all)
    }

    /// Signed distance of a point from the edge in m (outside positive) and the parameter of its foot, by
    /// Newton's method from the nearest sample in `table`.
    pub fn distance(&self, place: Vec2, table: &OutlineTable) -> (f64, f64) {
        let pitch = self.lobe_pitch();
        let lobe = (place.y.atan2(place.x) / pitch).floor();
        let local = turned(place, unit(-lobe * pitch));
        let mut tau = table.nearest(local);
        let on = if self.end().is_some() { &self.between(tau, tau) } else { self };
        for _ in 0..12 {
            let p = on.at(tau);
            let gap = local - p.place;
            // d/dτ of (x − P)·T = −v (1 + κ (N·(x − P))).
            let along = gap.dot(&p.tangent);
            let stretch = 1.0 + p.curvature * gap.dot(&p.outward_normal());
            // Beyond the centre of curvature Newton's method diverges; the step along the arc is then used.
            let step = along / (p.speed * if stretch > 0.2 { stretch } else { 1.0 });
            let step = step.clamp(-table.step, table.step);
            tau += step;
            if step.abs() < 1e-14 {
                break;
            }
        }
        let p = on.at(tau);
        ((local - p.place).dot(&p.outward_normal()), (tau + lobe * pitch).rem_euclid(TAU))
    }

    /// Samples for [`Outline::distance`].
    pub fn table(&self) -> OutlineTable {
        const PER_LOBE: i64 = 256;
        let step = self.lobe_pitch() / PER_LOBE as f64;
        let samples = (-PER_LOBE / 2..PER_LOBE + PER_LOBE / 2)
            .map(|i| (i as f64 * step, self.at(i as f64 * step).place))
            .collect();
        OutlineTable { samples, step }
    }

    /// Parameters τ in [from, to], including the ends, whose chords are within `tolerance` of the edge, and the
    /// bound of the remaining deviation.
    ///
    /// The deviation of a chord over the arc length ℓ is at most max|κ| ℓ²/8. The largest curvature is that on
    /// a grid with sixteen steps per chord, increased by half the difference between neighbours.
    pub fn chords(&self, from: f64, to: f64, tolerance: f64) -> (Vec<f64>, f64) {
        let rough = 512;
        let at = |i: usize, count: usize| from + (to - from) * i as f64 / count as f64;
        let shortest = (0..=rough)
            .map(|i| self.at(at(i, rough)))
            .map(|p| (8.0 * tolerance / p.curvature.abs().max(1e-9)).sqrt() / p.speed)
            .fold(f64::INFINITY, f64::min);
        let count = (((to - from) / shortest * 16.0).ceil() as usize).clamp(rough, 1 << 17);
        let points: Vec<OutlinePoint> = (0..=count).map(|i| self.at(at(i, count))).collect();
        // Bounds of arc length and curvature in each step.
        let step = (to - from) / count as f64;
        let cells: Vec<(f64, f64)> = points
            .windows(2)
            .map(|pair| {
                let (a, b) = (&pair[0], &pair[1]);
                let length = step * (a.speed.max(b.speed) + 0.5 * (a.speed - b.speed).abs());
                let curvature =
                    a.curvature.abs().max(b.curvature.abs()) + 0.5 * (a.curvature - b.curvature).abs();
                (length, curvature)
            })
            .collect();
        let mut chosen = vec![from];
        let (mut length, mut curvature, mut worst) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (index, cell) in cells.iter().enumerate() {
            let (l, k) = (length + cell.0, curvature.max(cell.1));
            if k * l * l / 8.0 > tolerance && length > 0.0 {
                chosen.push(points[index].tau);
                worst = worst.max(curvature * length * length / 8.0);
                (length, curvature) = *cell;
            } else {
                (length, curvature) = (l, k);
            }
        }
        chosen.push(to);
        (chosen, worst.max(curvature * length * length / 8.0))
    }
}

/// Points of an outline over one lobe and half of each neighbour.
#[derive(Debug, Clone, PartialEq)]
pub struct OutlineTable {
    samples: Vec<(f64, Vec2)>,
    step: f64,
}

impl OutlineTable {
    fn nearest(&self, place: Vec2) -> f64 {
        let distance = |i: usize| (self.samples[i].1 - place).norm_squared();
        // Every sixteenth sample first; the lobe is smooth on that scale.
        let rough = (0..self.samples.len()).step_by(16).min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        let centre = rough.unwrap_or(0);
        let range = centre.saturating_sub(16)..(centre + 17).min(self.samples.len());
        let best = range.min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        self.samples[best.unwrap_or(0)].0
    }
}
