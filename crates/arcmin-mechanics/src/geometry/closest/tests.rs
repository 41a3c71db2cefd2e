use super::*;
use crate::geometry::{WornOffset, unit};

#[test]
fn slope_along_the_flank_has_the_derivative_that_newton_uses() {
    let profile = Profile::new(40, 64e-3, 1.3e-3, 3e-3);
    let relief = Relief::from_samples(
        Relief::grid(720).map(|phi| 1e-5 * (1.3 + (2.0 * phi).sin() + 0.2 * (9.0 * phi).cos())).collect(),
    );
    let at = |tau: f64| Place { tau, e: unit(tau), ez: unit(40.0 * tau), shared: true };
    for i in 0..60 {
        let tau = 0.4 + 0.0027 * i as f64;
        let p = profile.trace(tau) + crate::geometry::Vec2::new(2e-5, -1e-5);
        let station = |tau: f64| Station::new(p, &profile.worn_at(at(tau), &relief));
        let slope = |tau: f64| station(tau).slope;
        let h = 1e-7;
        let difference = (slope(tau + h) - slope(tau - h)) / (2.0 * h);
        let exact = station(tau).slope_by_tau;
        // The difference quotient has rounding of 1e-16/h and the third derivative's h².
        assert!((difference / exact - 1.0).abs() < 1e-5, "{tau}: {difference} {exact}");
    }
}

/// The bracketed closest point agrees with Newton's method where this converges. On a flank with such waves
/// that the distance has several minima, it is one of them: no neighbouring point is nearer.
#[test]
fn the_bracketed_closest_point_is_a_minimum_of_the_distance() {
    let profile = Profile::new(40, 64e-3, 1.3e-3, 3e-3);
    let depth = |wave: f64| {
        let at = move |phi: f64| 1e-5 * (1.3 + (2.0 * phi).sin() + wave * (60.0 * phi).cos());
        Relief::from_samples(Relief::grid(720).map(at).collect())
    };
    for (wave, several) in [(0.0, false), (0.3, true)] {
        let relief = depth(wave);
        let mut differ = 0;
        for i in 0..400 {
            let tau = 0.4 + 0.0004 * f64::from(i);
            let p = profile.trace(tau) + 2e-5 * unit(f64::from(i));
            let foot = profile.foot(p, tau);
            let enclosed = profile.closest_between(p, [f64::NAN; 2], foot.place, &relief, 3e-3);
            let free = profile.closest_on_worn(p, &foot, &relief, 3e-3);
            differ += usize::from((enclosed.gap - free.gap).abs() > 1e-12);
            for closest in [&enclosed, &free] {
                let gap = |tau: f64| {
                    let place = Place { tau, e: unit(tau), ez: unit(40.0 * tau), shared: true };
                    profile.worn_at(place, &relief).reach(p).norm() - 3e-3
                };
                for side in [-1e-5, 1e-5] {
                    let beside = gap(closest.tau + side);
                    assert!(beside >= closest.gap - 1e-15, "{tau}: {} {beside}", closest.gap);
                }
            }
        }
        assert_eq!(differ > 0, several, "{differ} of 400");
    }
}

#[test]
fn designed_curvature_has_its_rate() {
    let profile = Profile::new(40, 64e-3, 1.3e-3, 3e-3);
    let at = |phi: f64| {
        let trace = profile.trace_curvature(phi.cos());
        let rate = profile.designed_curvature_rate(phi.sin(), profile.speed_factor(phi.cos()), trace);
        let bend = profile.designed_curvature_bend(
            crate::geometry::unit(phi),
            profile.speed_factor(phi.cos()),
            trace,
        );
        (profile.designed_curvature(trace, 3.001e-3), rate, bend)
    };
    for i in 0..90 {
        let phi = -3.1 + 0.07 * f64::from(i);
        let (value, rate, bend) = at(phi);
        let exact = profile.relative_curvature(phi.cos(), 3.001e-3);
        assert!((value / exact - 1.0).abs() < 1e-12, "{phi}");
        let h = 1e-5;
        // φ falls with τ.
        let difference = -39.0 * (at(phi + h).0 - at(phi - h).0) / (2.0 * h);
        assert!((rate - difference).abs() < 1e-6 * (rate.abs() + 1e4), "{phi}: {rate} {difference}");
        let difference = -39.0 * (at(phi + h).1 - at(phi - h).1) / (2.0 * h);
        assert!((bend - difference).abs() < 1e-6 * (bend.abs() + 1e6), "{phi}: {bend} {difference}");
    }
}

/// Between the samples of the depth: the curvature compared with three points of the worn flank, and the Taylor
/// series of the trace with a new evaluation.
#[test]
fn derivatives_along_the_worn_flank_agree_with_its_points() {
    let profile = Profile::new(40, 64e-3, 1.3e-3, 3e-3);
    let relief = Relief::from_samples(
        Relief::grid(720).map(|phi| 1e-5 * (1.3 + (2.0 * phi).sin() + 0.2 * (9.0 * phi).cos())).collect(),
    );
    let at =
        |tau: f64| profile.worn_at(Place { tau, e: unit(tau), ez: unit(40.0 * tau), shared: true }, &relief);
    let point = |tau: f64| {
        let here = at(tau);
        here.trace.c - here.depth_below_trace * here.trace.normal()
    };
    for i in 0..120 {
        let tau = 0.41 + 0.0027 * f64::from(i);
        let h = 2e-6;
        let (a, m, b) = (point(tau - h), point(tau), point(tau + h));
        let (first, second) = ((b - a) / (2.0 * h), (b - 2.0 * m + a) / (h * h));
        let expected = -cross(first, second) / first.norm().powi(3);
        let here = at(tau);
        let scale = expected.abs().max(50.0);
        assert!((here.curvature() - expected).abs() < 2e-3 * scale, "{tau}: {expected}");
        let way = 4e-6;
        let (carried, there) = (here.trace.moved(way), at(tau + way).trace);
        assert!((carried.c - there.c).norm() < 1e-16, "{tau}");
        assert!((carried.tangent - there.tangent).norm() < 1e-10, "{tau}");
        let size = there.turning.abs() + 40.0;
        assert!((carried.turning - there.turning).abs() < 1e-7 * size, "{tau}");
        assert!((carried.speed / there.speed - 1.0).abs() < 1e-9, "{tau}");
    }
}

impl Profile {
    /// Wear by a pin with a radius larger by a fraction, with its centre at a depth (m) inside of the trace at
    /// a meshing angle (rad): around this angle the flank has the shape of the pin.
    pub(crate) fn bedded(&self, phi: f64, depth: f64, wider: f64) -> Relief {
        let lobes = self.lobe_count() as f64;
        let at = |phi: f64| (self.trace(-phi / lobes), self.outward_normal(-phi / lobes));
        let (c, n) = at(phi);
        let (centre, radius) = (c - depth * n, (1.0 + wider) * self.pin_radius);
        let worn = |phi: f64| {
            let (c, n) = at(phi);
            let off = c - centre;
            let height = off.dot(&n);
            let room = radius * radius - off.norm_squared() + height * height;
            (height + room.max(0.0).sqrt() - self.pin_radius).max(0.0)
        };
        Relief::from_samples(Relief::grid(720).map(worn).collect())
    }
}

/// On a flank worn to the shape of the pin the closest point is found at any distance from the foot, and the
/// gap is not below its bound by the offset of the flank; compared with the smallest distance of many points.
#[test]
fn closest_places_far_from_the_foot_are_found() {
    let mut farthest = 0.0_f64;
    for profile in [Profile::new(21, 26e-3, 0.75e-3, 2e-3), Profile::new(40, 64e-3, 1.3e-3, 3e-3)] {
        let (lobes, radius) = (profile.lobe_count() as f64, profile.pin_radius);
        for (phi, depth, wider) in [(0.7, 60e-6, 0.01), (0.9, 25e-6, 0.01), (-0.8, 40e-6, 0.03)] {
            let relief = profile.bedded(phi, depth, wider);
            let seen = relief.without_hollows(&profile, radius).unwrap_or(relief);
            let offset = WornOffset::of(&profile).with(&profile, &seen);
            for i in -40..40 {
                // Loaded or nearly loaded pins around the one whose shape the flank has.
                let (c, n) = (profile.trace(-phi / lobes), profile.outward_normal(-phi / lobes));
                let along = 0.009 * wider * radius * f64::from(i);
                let p = c - (depth + wider * radius + 1e-7 * f64::from(i % 8)) * n + along * quarter_turn(n);
                let foot = profile.foot(p, -phi / lobes);
                let closest = profile.closest_on_worn(p, &foot, &seen, radius);
                let gap = |tau: f64| {
                    let place = foot.place.moved(tau - foot.tau, profile.turns());
                    profile.worn_at(place, &seen).reach(p).norm() - radius
                };
                let least = (-1000..=1000).map(|k| gap(foot.tau + 1e-3 * f64::from(k) / lobes));
                let least = least.fold(f64::INFINITY, f64::min);
                assert!(closest.gap < least + 1e-15, "{phi} {i}: {:e} {least:e}", closest.gap);
                let start =
                    foot.place.moved(0.4_f64.copysign(closest.tau - foot.tau) / lobes, profile.turns());
                let enclosed = profile.closest_between(p, [f64::NAN; 2], start, &seen, radius);
                assert!((enclosed.gap - closest.gap).abs() < 1e-15, "{phi} {i}: {:e}", enclosed.gap);
                let bound = offset.distance(profile.meshing_angle(foot.tau), foot.distance) - radius;
                assert!(bound < closest.gap + 1e-15, "{phi} {i}: {bound:e} {:e}", closest.gap);
                farthest = farthest.max(((closest.tau - foot.tau) * lobes).abs());
            }
        }
    }
    println!("{farthest}");
    assert!(farthest > 0.2, "{farthest}");
}
