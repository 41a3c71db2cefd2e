use std::f64::consts::{PI, TAU};

use super::*;
use crate::geometry::cross;
use crate::units::DEG;

/// Flanks with a tooth difference of 2: many, few, odd and even numbers of pins, large and small pins; and one
/// with a difference of 1 and a tip circle.
fn flanks() -> Vec<Profile> {
    let with = |pins: usize, circle: f64, k1: f64, pin: f64, tip: Option<f64>, m: usize| {
        let eccentricity = k1 * m as f64 * circle / pins as f64;
        Profile::new(pins, circle, eccentricity, pin).with_teeth(m, tip).unwrap()
    };
    vec![
        with(22, 40e-3, 0.6, 2.5e-3, None, 2),
        with(21, 40e-3, 0.7, 1.5e-3, None, 2),
        with(42, 60e-3, 0.75, 1.5e-3, None, 2),
        with(12, 30e-3, 0.5, 3e-3, None, 2),
        with(30, 45e-3, 0.45, 3.5e-3, None, 2),
        with(20, 17e-3, 0.5, 1.5e-3, Some(15.6e-3), 1),
    ]
}

/// Pins of the ring in the frame of the disc, which is in its nominal position at an angle of the eccentric.
fn pins(profile: &Profile, crank: f64) -> Vec<Vec2> {
    let disc = -crank / profile.lobes_per_turn();
    let centre = profile.eccentricity * unit(crank);
    let place = |i: usize| profile.pin_circle_radius * unit(TAU * i as f64 / profile.pin_count as f64);
    (0..profile.pin_count).map(|i| turned(place(i) - centre, unit(-disc))).collect()
}

/// The edge of the disc as a polygon, fine enough for gaps of a tenth of a micrometre.
fn polygon(profile: &Profile, per_lobe: usize) -> Vec<Vec2> {
    let lobes = profile.lobe_count();
    // Corners are among its points.
    let end = profile.last_meshing_angle() / (PI - 1e-12);
    let at = |lobe: usize, share: f64| profile.flank_point(TAU * (lobe as f64 + 0.5 * share) / lobes as f64);
    let way = |lobe: usize, from: f64, to: f64| {
        (0..per_lobe).map(move |i| at(lobe, from + (to - from) * i as f64 / per_lobe as f64))
    };
    (0..lobes).flat_map(|lobe| way(lobe, -end, end).chain(way(lobe, end, 2.0 - end))).collect()
}

/// Distance of a point from a polygon, negative inside.
fn from_polygon(polygon: &[Vec2], p: Vec2) -> f64 {
    let (mut nearest, mut winding) = (f64::INFINITY, 0.0);
    for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let (side, off) = (b - a, p - a);
        let share = if side.norm_squared() > 0.0 {
            (off.dot(&side) / side.norm_squared()).clamp(0.0, 1.0)
        } else {
            0.0
        };
        nearest = nearest.min((off - share * side).norm());
        winding += cross(a - p, b - p).atan2((a - p).dot(&(b - p)));
    }
    if winding.abs() > PI { -nearest } else { nearest }
}

/// With a tooth difference of 2 every pin lies on the trace of its root as the disc turns by −m/z_c. Over a
/// turn no pin penetrates the disc and every point of the usable flank is touched, by distances from a polygon,
/// which are independent of the search of foot points.
#[test]
fn pins_touch_the_usable_flank_without_penetration() {
    for profile in flanks() {
        let edge = polygon(&profile, 700);
        let mut touched = vec![0.0_f64; 36];
        let end = profile.last_meshing_angle();
        for step in 0..40 {
            let crank = 0.0137 + TAU * step as f64 / 40.0 / profile.pin_count as f64;
            for p in pins(&profile, crank) {
                let gap = from_polygon(&edge, p) - profile.pin_radius;
                assert!(gap > -1e-7, "{} {crank}: {gap:e}", profile.pin_count);
                let foot = profile.foot(p, 0.0);
                let by_foot = foot.distance;
                assert!((by_foot - gap).abs() < 1e-7, "{} {crank}: {by_foot:e} {gap:e}", profile.pin_count);
                // Pins beyond the end of their own branch are clear of the disc.
                assert!(by_foot > -1e-12, "{} {crank}: {by_foot:e}", profile.pin_count);
                if by_foot < 1e-12 {
                    assert!(!foot.at_tip);
                    let share = foot.sin_meshing.atan2(foot.cos_meshing) / end;
                    let cell = ((share + 1.0) * 18.0) as usize;
                    touched[cell.min(35)] += 1.0;
                }
            }
        }
        assert!(touched.iter().all(|count| *count > 0.0), "{} {touched:?}", profile.pin_count);
    }
}

/// The distance of pins at any position around the disc agrees with that from a polygon of its edge, also next
/// to tips; if several points are near, the one on the side of the pin is used.
#[test]
#[ignore = "long"]
fn feet_are_the_nearest_places_of_the_edge() {
    for profile in flanks() {
        let edge = polygon(&profile, 700);
        let slack = 1.5e-4 * profile.pin_circle_radius;
        for i in 0..700 {
            let tau = 0.31 + 0.0137 * i as f64;
            for off in [-1e-5, 0.0, 2e-5, 1e-4, slack] {
                let beyond =
                    profile.flank_point(tau) + (profile.pin_radius + off) * profile.outward_normal(tau);
                let foot = profile.foot(beyond, 0.0);
                let nearest = from_polygon(&edge, beyond) - profile.pin_radius;
                assert!(
                    (foot.distance - nearest).abs() < 1e-7,
                    "{} {i} {off}: {:e} {nearest:e}",
                    profile.pin_count,
                    foot.distance
                );
            }
        }
    }
}

/// The usable flank ends where the neighbouring flank begins: without a tip circle both meet in the middle of
/// the lobe, with one the corner lies on it.
#[test]
fn flanks_meet_on_the_middle_of_the_lobe() {
    for profile in flanks().into_iter().filter(|profile| profile.tooth_difference == 2) {
        let tip = profile.tip().unwrap();
        let half = PI / profile.lobe_count() as f64;
        let sharp = Profile { tip: None, ..profile.clone() };
        let sharp = sharp.with_teeth(2, Some(tip.meeting * (1.0 - 1e-9))).unwrap();
        let end = sharp.tip().unwrap().end;
        let lobes = profile.lobe_count() as f64;
        // From the root at 0 up, and from the next root down.
        let (up, down) = (sharp.cut_point(end / lobes), sharp.cut_point(TAU / lobes - end / lobes));
        assert!((up - down).norm() < 2e-3 * tip.meeting * 1e-4, "{:e}", (up - down).norm());
        assert!((up.y.atan2(up.x) - half).abs() < 1e-6);
        assert!(((tip.meeting - tip.radius) / profile.eccentricity - DEFAULT_TIP_CUT).abs() < 1e-9);
        let corner = profile.flank_point(tip.end / lobes);
        assert!(
            (corner.norm() - tip.radius).abs() < 1e-12
                && (corner.y.atan2(corner.x) - tip.corner).abs() < 1e-12
        );
        assert!(tip.end > 60.0 * DEG && tip.end < 170.0 * DEG, "{}", tip.end / DEG);
    }
}

/// The share of the flank that is usable, by the closed form and by a sum over its pins.
#[test]
fn crowding_is_the_sum_over_the_pins_of_the_usable_flank() {
    assert!(Profile::new(20, 17e-3, 0.5e-3, 1.5e-3).crowding() == 1.0);
    for profile in flanks() {
        let (count, end) = (200_000, profile.last_meshing_angle());
        let sum = |last: f64| {
            let (mut squares, mut most) = (0.0, 0.0_f64);
            for i in 0..count {
                let phi = last * (i as f64 + 0.5) / count as f64;
                let lever = profile.lever_arm(phi) / profile.largest_lever_arm();
                squares += lever * lever * last / count as f64;
                most = most.max(lever);
            }
            most / squares
        };
        let expected = sum(end) / sum(PI);
        assert!((profile.crowding() / expected - 1.0).abs() < 1e-6, "{} {expected}", profile.crowding());
    }
}

/// The distance of a pin that moves around a tip from one flank to the next, and its normal, are continuous at
/// both corners, with and without wear.
#[test]
fn distance_goes_on_around_a_tip() {
    for profile in flanks() {
        let worn = Relief::from_samples(Relief::grid(360).map(|phi| 2e-5 * (1.0 - phi.cos())).collect());
        let uniform = Relief::uniform(1e-5);
        for relief in [&worn, &uniform] {
            let lobes = profile.lobe_count() as f64;
            let end = profile.last_meshing_angle() / lobes;
            let path = |x: f64| {
                // Along the trace past the end of the flank.
                let tau = end * (0.9 + 0.2 * x);
                profile.trace(tau) + 1e-6 * profile.trace_normal(tau)
            };
            let gap = |p: Vec2| {
                let foot = profile.foot(p, 0.0);
                let closest = profile.closest_to_end(p, &foot, relief, profile.pin_radius);
                closest.map_or_else(
                    || {
                        let closest = profile.closest_on_worn(p, &foot, relief, profile.pin_radius);
                        (closest.gap, closest.normal)
                    },
                    |closest| (closest.gap, closest.normal),
                )
            };
            let count = 4000;
            let mut before = gap(path(0.0));
            let step = (path(1.0) - path(0.0)).norm() / count as f64;
            for i in 1..=count {
                let now = gap(path(i as f64 / count as f64));
                assert!(
                    (now.0 - before.0).abs() < 1.5 * step,
                    "{} {i}: {:e} {:e}",
                    profile.pin_count,
                    now.0,
                    before.0
                );
                assert!((now.1 - before.1).norm() < 0.05, "{} {i}", profile.pin_count);
                before = now;
            }
        }
    }
}

/// Whether a point is farther from its nearest root than a corner.
fn farther(profile: &Profile, p: Vec2, corner: Vec2) -> bool {
    is_farther(p, corner, unit(profile.root_near(corner.y.atan2(corner.x) * 0.9)))
}

/// Near the end of a worn flank the gap agrees with a sampling of the worn flank up to its end.
#[test]
fn worn_flanks_end_at_their_worn_corner() {
    for profile in flanks() {
        let relief =
            Relief::from_samples(Relief::grid(720).map(|phi| 3e-5 * (1.0 + (2.0 * phi).sin())).collect());
        let lobes = profile.lobe_count() as f64;
        let tip = profile.tip().unwrap();
        let point = |phi: f64| {
            let tau = -phi / lobes;
            profile.cut_point(tau) - relief.at(phi).depth * profile.trace_normal(tau)
        };
        for side in [-1.0, 1.0] {
            let samples: Vec<Vec2> =
                (0..=40_000).map(|i| point(side * tip.end * i as f64 / 40_000.0)).collect();
            for i in 0..60 {
                let tau = -side * (tip.end + 0.01 * (i as f64 - 40.0)) / lobes;
                let p = profile.trace(tau) + 1e-5 * profile.trace_normal(tau);
                let foot = profile.foot(p, 0.0);
                let found = profile.closest_on_worn(p, &foot, &relief, profile.pin_radius).gap;
                // Farther out the land or the other flank of the lobe is nearer.
                if farther(&profile, p, samples[40_000]) {
                    continue;
                }
                let nearest =
                    samples.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min) - profile.pin_radius;
                assert!(
                    (found - nearest).abs() < 2e-9,
                    "{} {side} {i}: {found:e} {nearest:e} ",
                    profile.pin_count
                );
            }
        }
    }
}

/// Derivatives of the trace by τ, and the curvature in closed form, by differences.
#[test]
fn derivatives_of_the_trace_hold_for_a_tooth_difference_of_two() {
    for profile in flanks() {
        for i in 0..40 {
            // Away from the angles where the nearest root changes.
            let tau = 0.2 + 0.1 * i as f64;
            if profile.is_on_land(tau) {
                continue;
            }
            let (h, at) = (1e-5, |tau: f64| profile.trace(tau));
            let (e, ez) = profile.directions(tau);
            let (c, c1, c2) = profile.trace_derivatives(e, ez);
            let size = profile.pin_circle_radius;
            assert!((c - at(tau)).norm() < 1e-15);
            let first = (at(tau + h) - at(tau - h)) / (2.0 * h);
            assert!((first - c1).norm() < 1e-6 * size);
            let second = (at(tau + h) - 2.0 * at(tau) + at(tau - h)) / (h * h);
            assert!((second - c2).norm() < 1e-3 * size * profile.pin_count as f64);
            let by = |of: &dyn Fn(Vec2, Vec2) -> Vec2| {
                let (e0, z0) = profile.directions(tau - h);
                let (e1, z1) = profile.directions(tau + h);
                (of(e1, z1) - of(e0, z0)) / (2.0 * h)
            };
            let third = profile.trace_third_derivative(e, ez);
            assert!((by(&|e, z| profile.trace_derivatives(e, z).2) - third).norm() < 1e-6 * third.norm());
            let fourth = profile.trace_fourth_derivative(e, ez);
            assert!(
                (by(&|e, z| profile.trace_third_derivative(e, z)) - fourth).norm() < 1e-6 * fourth.norm()
            );
            let cos = profile.meshing_angle(tau).cos();
            assert!((c1.norm() / (profile.circle_speed() * profile.speed_factor(cos)) - 1.0).abs() < 1e-12);
            let curvature = -cross(c1, c2) / c1.norm().powi(3);
            assert!((profile.trace_curvature(cos) - curvature).abs() < 1e-9 * (curvature.abs() + 1.0 / size));
            let (e, n) = (profile.flank_point(tau), profile.outward_normal(tau));
            let lever = cross(e, -n);
            let phi = profile.meshing_angle(tau);
            assert!((lever + profile.lever_arm(phi)).abs() < 1e-12, "{lever} {}", profile.lever_arm(phi));
        }
    }
}

/// Tip circles that do not cross the flank are refused; the error has the radius that bounds them.
#[test]
fn circles_off_the_flank_are_refused() {
    let flank = || Profile::new(22, 40e-3, 2e-3, 2.5e-3);
    assert!(
        matches!(flank().with_teeth(2, Some(45e-3)), Err(TipError::Beyond { meeting }) if meeting < 40e-3)
    );
    assert!(
        matches!(flank().with_teeth(2, Some(30e-3)), Err(TipError::BelowRoot { root }) if (root - 35.5e-3).abs() < 1e-12)
    );
    assert!(flank().with_teeth(1, None).unwrap().tip().is_none());
}
