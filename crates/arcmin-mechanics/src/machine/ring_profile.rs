//! The contour of a ring whose teeth are arcs in one piece with it.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::assumed::WALL;
use super::{PinMounting, RingMesh};
use crate::geometry::{Outline, Segment, Vec2, turned, unit};

/// A ring cut as one part: arcs of the pins' radius on the pin circle, joined by roots that the lobes do not
/// reach. The flank of the disc is the envelope of the arcs, so that they are its conjugate (Litvin and Feng
/// 1996).
///
/// Lobes touch an arc up to asin K₁ from its innermost point: every normal of the flank passes through the
/// pitch point, e z_p/m from the centre of the ring, and has its largest inclination at cos φ = K₁, where it is
/// tangent to that circle. Flanks that end at their tips before that point touch less. Beyond the contact an
/// arc continues to the root, or from its widest point in a straight line outwards; overlapping arcs end at
/// their intersection.
#[derive(Debug, Clone, PartialEq)]
pub struct RingProfile {
    /// Around the opening, counter-clockwise, the metal outside.
    pub opening: Outline,
    /// m.
    pub outer_radius: f64,
    /// Half angle (rad) of an arc, from its innermost point to its end.
    pub arc: f64,
    /// Half angle (rad) of the part of an arc that flanks touch.
    pub touched: f64,
}

/// Distance between the roots and the outermost positions of the lobe tips, as a fraction of the eccentricity;
/// an assumption.
const ROOT: f64 = 0.25;

impl RingMesh {
    /// The contour of the ring; `None` for separate pins.
    pub fn ring_profile(&self) -> Option<RingProfile> {
        (self.mounting == PinMounting::OnePiece).then(|| self.contour())
    }

    fn contour(&self) -> RingProfile {
        let (count, circle, radius) = (self.profile.pin_count, self.ring_circle_radius, self.ring_pin_radius);
        let (e, half_pitch) = (self.profile.eccentricity, PI / count as f64);
        let tip = self.profile.pin_circle_radius + e - self.profile.pin_radius;
        let crests = e + self.profile.tip().map_or(tip, |tip| tip.radius);
        let root = crests + ROOT * e;
        // Intersection of arc and root, measured from the innermost point: |C + r(−cos ψ, sin ψ)| is the radius
        // of the root.
        let cosine = (circle * circle + radius * radius - root * root) / (2.0 * circle * radius);
        let by_root = cosine.clamp(0.0, 1.0).acos();
        // Intersection with the next arc, at half a pitch.
        let beside = circle * half_pitch.sin();
        let by_next =
            if radius > beside { FRAC_PI_2 - half_pitch - (beside / radius).acos() } else { FRAC_PI_2 };
        let arc = by_root.min(by_next);
        let end = Vec2::new(circle - radius * arc.cos(), radius * arc.sin());
        // A straight line outwards if the arc reaches its widest point before the root.
        let foot = match end.norm() < root - 1e-12 && by_next >= FRAC_PI_2 {
            true => Some(Vec2::new((root * root - radius * radius).sqrt(), radius)),
            false => None,
        };
        let last = foot.unwrap_or(end);
        let (reach, angle) = (last.norm(), last.y.atan2(last.x));
        let mut segments = Vec::with_capacity(4 * count);
        for pin in 0..count {
            let place = TAU * pin as f64 / count as f64;
            let turn = unit(place);
            let at = |p: Vec2| turned(p, turn);
            let mirrored = |p: Vec2| Vec2::new(p.x, -p.y);
            segments
                .extend(foot.map(|foot| Segment::Line { from: at(mirrored(foot)), to: at(mirrored(end)) }));
            segments.push(Segment::Arc {
                centre: circle * turn,
                radius,
                start: place + PI + arc,
                sweep: -2.0 * arc,
            });
            segments.extend(foot.map(|foot| Segment::Line { from: at(end), to: at(foot) }));
            let sweep = 2.0 * (half_pitch - angle);
            if sweep > 1e-9 {
                segments.push(Segment::Arc {
                    centre: Vec2::zeros(),
                    radius: reach,
                    start: place + angle,
                    sweep,
                });
            }
        }
        RingProfile {
            opening: Outline { segments },
            outer_radius: reach.max(circle + radius) / (1.0 - WALL),
            arc,
            // Largest where cos φ = K₁, asin K₁, or at the end of a flank that ends before.
            touched: match self.profile.last_cosine() > self.profile.short_width_coefficient() {
                true => self.profile.pin_angle(self.profile.last_meshing_angle()).abs().min(PI),
                false => self.profile.short_width_coefficient().min(1.0).asin(),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ContactLaw, LineContact};
    use crate::geometry::{Profile, Relief};

    fn mesh(pin_count: usize, pin_circle_radius: f64, pin_radius: f64, k1: f64) -> RingMesh {
        let eccentricity = k1 * pin_circle_radius / pin_count as f64;
        of(Profile::new(pin_count, pin_circle_radius, eccentricity, pin_radius))
    }

    fn of(profile: Profile) -> RingMesh {
        let (pin_circle_radius, pin_radius) = (profile.pin_circle_radius, profile.pin_radius);
        let steel = crate::templates::tao2024().disc.material;
        RingMesh {
            contact: LineContact::new(
                ContactLaw::Linear { stiffness: 1e8 },
                &steel,
                &steel,
                8e-3,
                pin_radius,
            ),
            ring_circle_radius: pin_circle_radius,
            ring_pin_radius: pin_radius,
            profile,
            relief: Relief::uniform(0.0),
            mounting: PinMounting::OnePiece,
        }
    }

    /// The contour is closed and has the area of a polygon of its points; arcs extend beyond their contact; and
    /// over a turn of the eccentric no lobe penetrates the contour, while every arc is touched: for separate
    /// arcs, for arcs with straight sides, and for overlapping arcs.
    #[test]
    fn lobes_touch_only_the_arcs() {
        for (pins, circle, radius, k1) in [
            (20, 0.04, 2.5e-3, 0.6),
            (12, 0.03, 2.0e-3, 0.75),
            (11, 0.03, 9.5e-3, 0.45),
            (40, 0.06, 1e-3, 0.7),
        ] {
            let mesh = mesh(pins, circle, radius, k1);
            let ring = mesh.ring_profile().unwrap();
            let segments = &ring.opening.segments;
            for (segment, next) in segments.iter().zip(segments.iter().cycle().skip(1)) {
                assert!((segment.point(1.0) - next.point(0.0)).norm() < 1e-12, "{pins} {segment:?} {next:?}");
            }
            let points: Vec<Vec2> =
                (0..segments.len() * 400).map(|i| ring.opening.point(i as f64 / 400.0)).collect();
            let polygon: f64 = points
                .iter()
                .zip(points.iter().cycle().skip(1))
                .map(|(a, b)| 0.5 * (a.x * b.y - a.y * b.x))
                .sum();
            assert!((ring.opening.area() / polygon - 1.0).abs() < 1e-5, "{} {polygon}", ring.opening.area());
            assert!(ring.arc > ring.touched, "{pins}: {} {}", ring.arc, ring.touched);
            assert!(points.iter().all(|point| point.norm() < ring.outer_radius));
            let profile = &mesh.profile;
            for step in 0..12 {
                let crank = TAU * step as f64 / 12.0;
                let angle = -crank / profile.lobe_count() as f64;
                let at = |tau: f64| {
                    profile.eccentricity * unit(crank) + turned(profile.flank_point(tau), unit(angle))
                };
                for pin in 0..pins {
                    let place = TAU * pin as f64 / pins as f64;
                    let touched = at(place - angle);
                    let off = (touched - circle * unit(place)).norm() - radius;
                    assert!(off.abs() < 1e-12, "{pins} {crank} {pin}: {off:e}");
                    assert!(ring.opening.distance(touched) < 1e-12, "{pins} {crank} {pin}");
                }
                for i in 0..250 {
                    let place = at(TAU * i as f64 / 250.0);
                    let distance = ring.opening.distance(place);
                    assert!(
                        distance < 1e-8 || ring.opening.contains(place),
                        "{pins} {crank} {i}: {distance}"
                    );
                }
            }
        }
    }

    /// The same with a tooth difference of 2: over a turn no point of the disc, including its corners,
    /// penetrates the contour, and arcs are touched as far as the flank is usable.
    #[test]
    fn lobes_of_two_teeth_stay_within_the_ring() {
        for (pins, circle, radius, k1) in
            [(22, 0.04, 2.2e-3, 0.6), (31, 0.05, 2e-3, 0.7), (16, 0.03, 2.5e-3, 0.5)]
        {
            let profile = Profile::new(pins, circle, k1 * 2.0 * circle / pins as f64, radius);
            let mesh = of(profile.with_teeth(2, None).unwrap());
            let ring = mesh.ring_profile().unwrap();
            assert!(ring.arc > ring.touched);
            let profile = &mesh.profile;
            let places: Vec<f64> = profile.around_lobe(80);
            let mut nearest = f64::INFINITY;
            for step in 0..24 {
                let crank = TAU * step as f64 / 24.0;
                let angle = -crank / profile.lobes_per_turn();
                let at = |tau: f64| {
                    profile.eccentricity * unit(crank) + turned(profile.flank_point(tau), unit(angle))
                };
                for lobe in 0..profile.lobe_count() {
                    for tau in &places {
                        let place = at(TAU * lobe as f64 / profile.lobe_count() as f64 + tau);
                        let distance = ring.opening.distance(place);
                        assert!(
                            distance < 1e-8 || ring.opening.contains(place),
                            "{pins} {crank} {lobe} {distance}"
                        );
                        nearest = nearest.min(distance);
                    }
                }
            }
            assert!(nearest < 1e-5, "{nearest}");
        }
    }

    /// A flank that ends before its largest lever arm touches arcs up to the normal at its end, which passes
    /// through the pitch point.
    #[test]
    fn short_flanks_touch_less_of_an_arc() {
        let whole = Profile::new(22, 0.04, 0.6 * 0.08 / 22.0, 2.2e-3).with_teeth(2, None).unwrap();
        let longest = of(whole.clone()).ring_profile().unwrap().touched;
        assert!((longest - 0.6_f64.asin()).abs() < 1e-12);
        let low = whole.root_radius() + 0.4 * (whole.tip().unwrap().radius - whole.root_radius());
        let short = whole.with_teeth(2, Some(low)).unwrap();
        let (k1, end) = (short.short_width_coefficient(), short.last_meshing_angle());
        assert!(end < k1.acos());
        let touched = of(short).ring_profile().unwrap().touched;
        let closed = (k1 * end.sin()).atan2(1.0 - k1 * end.cos());
        assert!((touched - closed).abs() < 1e-12 && touched < longest, "{touched} {closed}");
    }

    #[test]
    fn separate_pins_have_no_contour() {
        let fixed = RingMesh { mounting: PinMounting::Fixed, ..mesh(20, 0.04, 2.5e-3, 0.6) };
        assert!(fixed.ring_profile().is_none());
    }
}
