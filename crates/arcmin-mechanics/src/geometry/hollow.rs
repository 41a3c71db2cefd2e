//! Hollows of the flank with a smaller radius of curvature than the pin.

use super::{Profile, Relief};

/// Smallest height (m) by which a filled hollow bulges towards a pin that rests on both its sides, and so the
/// largest error of the gap. The contact then moves continuously from one side to the other instead of jumping.
const SAG: f64 = 1e-9;
/// Upper limit of the relative curvature of filled hollows and pin, as a fraction of that of the unworn flank.
const CLOSEST_FIT: f64 = 0.1;
/// Lower limit of that curvature: this fraction of the relative curvature, for the uncertainty of the grid,
/// plus twice the square of the relief's slope, because the equations are of first order in the slope.
const UNSURE: f64 = 0.01;
/// Number of samples beside an edge within which a spline oscillates.
const RINGING: usize = 8;

/// Flank and pin at the samples of a relief around one lobe; the first sample is repeated at the end.
struct Shape {
    /// Number of the first sample, which lies on the convex hull.
    first: usize,
    /// Arc length along the flank in m.
    arc: Vec<f64>,
    /// Relative curvature of the flank without its relief and the pin, in 1/m.
    relative_curvature: Vec<f64>,
    /// Depth of the relief in m.
    depth: Vec<f64>,
    /// Distance of the flank from the pin in m, except for a linear function of the arc length.
    fall: Vec<f64>,
}

impl Relief {
    /// The relief with filled hollows for a pin of this radius (m): where the radius of curvature of the flank
    /// is smaller than that of the pin, so that the pin rests on two points, the relief is filled up to the
    /// pin. `None` if there are no such hollows.
    ///
    /// Along the arc length s the flank recedes from the pin by H(s), H″ = 1/R_eq + w″, and the gap of a pin
    /// tilted by b is the minimum of H(s) + b s. This minimum is the same for H and for its lower convex hull,
    /// but on the hull there is one point of closest approach only. Filled hollows bulge slightly towards the
    /// pin ([`SAG`], [`UNSURE`]), so that this point, and with it the direction of the force, changes
    /// continuously. Splines with convex control points are convex.
    pub(crate) fn without_hollows(&self, profile: &Profile, pin_radius: f64) -> Option<Relief> {
        let count = self.samples().len();
        if self.is_uniform() {
            return None;
        }
        let original = self.control_points();
        let control = self.without_ringing(&original, &Shape::of(profile, pin_radius, &original)?.concave());
        let shape = Shape::of(profile, pin_radius, &control)?;
        let hollows = chords(&shape.arc, &shape.fall);
        if hollows.is_empty() && control == original {
            return None;
        }
        let mut rounding = vec![0.0_f64; count + 1];
        for [from, to] in hollows {
            let (width, length) = (to - from, shape.arc[to] - shape.arc[from]);
            let curvature = 8.0 * SAG / (length * length);
            let steepness = shape.steepest(from, to).powi(2);
            for i in from.saturating_sub(width)..=(to + width).min(count) {
                let unsure = (UNSURE + 2.0 * steepness) * shape.relative_curvature[i];
                let most = CLOSEST_FIT * shape.relative_curvature[i];
                rounding[i] = (curvature + unsure).min(most).max(rounding[i]);
            }
        }
        let sag = twice_summed(&shape.arc, &rounding);
        let fall: Vec<f64> = shape.fall.iter().zip(&sag).map(|(fall, sag)| fall - sag).collect();
        let mut filled = control.clone();
        for [from, to] in chords(&shape.arc, &fall) {
            let slope = (fall[to] - fall[from]) / (shape.arc[to] - shape.arc[from]);
            for i in from + 1..to {
                let chord = fall[from] + slope * (shape.arc[i] - shape.arc[from]);
                filled[(i + shape.first) % count] -= fall[i] - chord;
            }
        }
        Some(self.with_control_points(&original, &filled))
    }

    /// Control points of the spline. Beside an edge that is too sharp for the grid the spline oscillates, with
    /// control points alternately above and below the samples; there the samples replace them. `concave` are
    /// the samples around which this is done.
    fn without_ringing(&self, control: &[f64], concave: &[usize]) -> Vec<f64> {
        let (count, samples) = (control.len(), self.samples());
        let off = |i: usize| control[i % count] - samples[i % count];
        let mut steady = control.to_vec();
        for place in concave {
            for i in place + count - RINGING..=place + count + RINGING {
                if off(i) * off(i - 1) < 0.0 && off(i) * off(i + 1) < 0.0 {
                    steady[i % count] = samples[i % count];
                }
            }
        }
        steady
    }
}

impl Shape {
    /// `None` if the flank is undercut.
    fn of(profile: &Profile, pin_radius: f64, depths: &[f64]) -> Option<Shape> {
        let count = depths.len();
        let step = std::f64::consts::TAU / count as f64;
        let per_lobe = step * profile.circle_speed() / profile.lobe_count() as f64;
        let mut steps = Vec::with_capacity(count);
        let mut relative_curvature = Vec::with_capacity(count);
        for (phi, depth) in Relief::grid(count).zip(depths) {
            // Beyond the end of the flank its values at the end are used.
            let cos = phi.cos().max(profile.last_cosine());
            let curvature = profile.trace_curvature(cos);
            let stretch = 1.0 + (profile.pin_radius + depth) * curvature;
            if stretch <= 0.0 {
                return None;
            }
            steps.push(per_lobe * profile.speed_factor(cos) * stretch);
            relative_curvature.push(1.0 / pin_radius - curvature / stretch);
        }
        let around = |first: usize, turns: usize| -> [Vec<f64>; 4] {
            let turned = |values: &[f64]| (0..=turns * count).map(|i| values[(first + i) % count]).collect();
            let [steps, curvatures, depths]: [Vec<f64>; 3] =
                [turned(&steps), turned(&relative_curvature), turned(depths)];
            let mut sum = 0.0;
            let on = steps.windows(2).map(|pair| {
                sum += 0.5 * (pair[0] + pair[1]);
                sum
            });
            let arc: Vec<f64> = std::iter::once(0.0).chain(on).collect();
            let fall = twice_summed(&arc, &curvatures).iter().zip(&depths).map(|(p, w)| p + w).collect();
            [arc, curvatures, depths, fall]
        };
        // The lobe is cut at a corner of the hull, found on the middle one of three lobes.
        let [arc, .., fall] = around(0, 3);
        let first = hull(&arc, &fall).into_iter().find(|corner| *corner >= count)? % count;
        let [arc, relative_curvature, depth, fall] = around(first, 1);
        Some(Shape { first, arc, relative_curvature, depth, fall })
    }

    /// Largest slope of the relief between two samples.
    fn steepest(&self, from: usize, to: usize) -> f64 {
        let (arc, depth) = (&self.arc, &self.depth);
        (from..to).map(|i| ((depth[i + 1] - depth[i]) / (arc[i + 1] - arc[i])).abs()).fold(0.0, f64::max)
    }

    /// Numbers of the samples at which the radius of curvature of the hollow flank is below that of the pin.
    fn concave(&self) -> Vec<usize> {
        let (arc, fall) = (&self.arc, &self.fall);
        let slope = |i: usize| (fall[i + 1] - fall[i]) / (arc[i + 1] - arc[i]);
        let inner = 1..arc.len() - 1;
        inner.filter(|i| slope(*i) < slope(i - 1)).map(|i| i + self.first).collect()
    }
}

/// The function with the given second derivative, except for a linear function.
fn twice_summed(arc: &[f64], bend: &[f64]) -> Vec<f64> {
    let mut slope = 0.0;
    let mut value = 0.0;
    let mut values = Vec::with_capacity(arc.len());
    for i in 0..arc.len() {
        values.push(value);
        if i + 1 < arc.len() {
            // The second derivative of a sample holds up to half the distance to its neighbours.
            let before = if i == 0 { 0.0 } else { arc[i] - arc[i - 1] };
            let after = arc[i + 1] - arc[i];
            slope += 0.5 * (before + after) * bend[i];
            value += slope * after;
        }
    }
    values
}

/// Numbers of the samples at the corners of the lower convex hull.
fn hull(arc: &[f64], values: &[f64]) -> Vec<usize> {
    let mut corners: Vec<usize> = Vec::new();
    for i in 0..arc.len() {
        while let [.., a, b] = corners[..] {
            let chord = (values[i] - values[a]) * (arc[b] - arc[a]);
            if (values[b] - values[a]) * (arc[i] - arc[a]) < chord {
                break;
            }
            corners.pop();
        }
        corners.push(i);
    }
    corners
}

/// The chords of the lower convex hull that span samples, by their ends.
fn chords(arc: &[f64], values: &[f64]) -> Vec<[usize; 2]> {
    let corners = hull(arc, values);
    corners.windows(2).map(|pair| [pair[0], pair[1]]).filter(|[from, to]| to > &(from + 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Vec2, quarter_turn};
    use crate::random_designs::sound_design;
    use crate::units::{DEG, UM};

    /// Width of dents in rad of the meshing angle.
    const DENT: f64 = 0.3;

    struct Hollowed {
        profile: Profile,
        relief: Relief,
        /// Meshing angle of a hollow in rad.
        hollow: f64,
    }

    /// Arc length along the unworn flank in m per rad of φ.
    fn arc_rate(profile: &Profile, phi: f64) -> f64 {
        let per_lobe = profile.pin_circle_radius / profile.lobe_count() as f64;
        let stretch = 1.0 + profile.pin_radius * profile.trace_curvature(phi.cos());
        per_lobe * profile.speed_factor(phi.cos()) * stretch
    }

    impl Hollowed {
        /// Largest depth in m to which a hollow is filled below the chord, by the definition of [`UNSURE`], if
        /// all filled points lie in two hollows.
        fn deepest_sag(&self, seen: &Relief) -> f64 {
            let (old, new) = (self.relief.samples(), seen.samples());
            let filled = old.iter().zip(new).filter(|(old, new)| old != new).count();
            let rate = arc_rate(&self.profile, self.hollow);
            let length = 0.5 * filled as f64 * std::f64::consts::TAU / old.len() as f64 * rate;
            let steps = old.windows(2).map(|pair| (pair[1] - pair[0]).abs());
            let slope = steps.fold(0.0, f64::max) * old.len() as f64 / std::f64::consts::TAU / rate;
            let curvature = self.profile.relative_curvature(self.hollow.cos(), self.profile.pin_radius);
            (UNSURE + 2.0 * slope * slope) * curvature * length * length / 8.0
        }
    }

    /// Flanks with a dent on either side of the root and with the edges of a worn zone, with a smaller radius
    /// of curvature than the pin: on the profile on which this was found first, and on random designs.
    fn hollowed() -> Vec<Hollowed> {
        let found = Profile::new(76, 71.9e-3, 0.714e-3, 2.02e-3);
        let random = (1..=8).map(|seed| sound_design(seed).0.machine().profile());
        let mut all = Vec::new();
        for profile in std::iter::once(found).chain(random) {
            // The depth makes the curvature of the hollow exceed that of the pin by a multiple of the relative
            // curvature.
            let depth = |phi: f64, width: f64, times: f64| {
                let curvature = profile.relative_curvature(phi.cos(), profile.pin_radius);
                times * curvature * (width * arc_rate(&profile, phi)).powi(2)
            };
            let (dent, edge) = (depth(DENT, 0.12, 0.9), depth(0.6, 0.06, 2.4));
            let dents = Relief::grid(720)
                .map(|phi: f64| dent * (-((phi.abs() - DENT) / 0.12).powi(2)).exp())
                .collect();
            let edges = Relief::grid(720)
                .map(|phi: f64| edge * (1.0 - (((phi.abs() - 1.0).abs() - 0.4) / 0.06).tanh()))
                .collect();
            let [dents, edges] = [dents, edges].map(Relief::from_samples);
            all.push(Hollowed { profile: profile.clone(), relief: dents, hollow: DENT });
            all.push(Hollowed { profile, relief: edges, hollow: 0.68 });
        }
        all
    }

    /// Uncertainty of a relief from its grid: a twelfth of its largest second difference, in m.
    fn grain(relief: &Relief) -> f64 {
        let seconds = relief.samples().windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs());
        seconds.fold(0.0, f64::max) / 12.0
    }

    /// Gap between pin and flank by dense sampling around the foot.
    fn gap_by_sampling(profile: &Profile, relief: &Relief, p: Vec2, tau: f64) -> f64 {
        let lobes = profile.lobe_count() as f64;
        let distance = |tau: f64| {
            let depth = relief.at(profile.meshing_angle(tau)).depth;
            let below = (profile.pin_radius + depth) * profile.outward_normal(tau);
            (p - profile.trace(tau) + below).norm()
        };
        let places = (-1500..=1500).map(|i| tau + 0.8 / lobes * f64::from(i) / 1500.0);
        places.map(distance).fold(f64::INFINITY, f64::min) - profile.pin_radius
    }

    /// Where pins are loaded, filling the hollows does not change the gap by more than the sag.
    #[test]
    #[ignore = "long"]
    fn filling_hollows_keeps_the_gap() {
        for hollowed in hollowed() {
            let Hollowed { profile, relief, hollow } = &hollowed;
            let seen = relief.without_hollows(profile, profile.pin_radius).unwrap();
            let sag = hollowed.deepest_sag(&seen);
            let mut filled_at = 0;
            for i in 0..240 {
                let tau = 0.3 - (1.5 * f64::from(i) + 0.17) * DEG / profile.lobe_count() as f64;
                for (press, along) in [(3e-6, 0.0), (0.5e-6, 4e-6), (1e-6, -7e-6), (2e-6, 1e-6)] {
                    let n = profile.outward_normal(tau);
                    let surface = profile.trace(tau) - seen.at(profile.meshing_angle(tau)).depth * n;
                    let p = surface - press * n + along * quarter_turn(n);
                    let foot = profile.foot(p, tau);
                    let gap = profile.closest_on_worn(p, &foot, &seen, profile.pin_radius).gap;
                    let sampled = gap_by_sampling(profile, relief, p, foot.tau);
                    if sampled > 0.0 {
                        continue;
                    }
                    // Deeper penetration makes the sharper contact reach further into a hollow.
                    let tolerance = 10.0 * SAG - 3e-3 * sampled + grain(relief) + sag;
                    assert!(
                        (sampled - gap).abs() < tolerance,
                        "{profile:?} {hollow} {i} {press} {along}: {gap:e} {sampled:e} {tolerance:e}"
                    );
                    let phi = profile.meshing_angle(foot.tau);
                    filled_at += usize::from(seen.at(phi) != relief.at(phi));
                }
            }
            assert!(filled_at > 20, "{profile:?} {hollow}: {filled_at}");
        }
    }

    /// The direction of the force is continuous as a pin passes over a filled hollow, but jumps on the unfilled
    /// flank.
    #[test]
    fn trap_a_pin_jumps_between_the_sides_of_a_hollow() {
        let mut jumps_over_edges = 0;
        for Hollowed { profile, relief, hollow } in hollowed() {
            let tau = (4.0 * std::f64::consts::TAU - hollow) / profile.lobe_count() as f64;
            let seen = relief.without_hollows(&profile, profile.pin_radius).unwrap();
            let n = profile.outward_normal(tau);
            let step = 2.5e-6 * profile.pin_radius;
            let jumps = [&seen, &relief].map(|flank| {
                let pressed = profile.trace(tau) - (flank.at(hollow).depth + 1e-6) * n;
                let direction = |i: i32| {
                    let p = pressed + step * f64::from(i) * quarter_turn(n);
                    profile.closest_on_worn(p, &profile.foot(p, tau), flank, profile.pin_radius).normal
                };
                let directions: Vec<Vec2> = (-8000..8000).map(direction).collect();
                directions.windows(2).filter(|pair| (pair[1] - pair[0]).norm() > 1e-2).count()
            });
            assert_eq!(jumps[0], 0, "{profile:?} {hollow}");
            if hollow == DENT {
                assert!(jumps[1] > 0, "{profile:?}");
            } else {
                jumps_over_edges += jumps[1];
            }
        }
        assert!(jumps_over_edges > 3, "{jumps_over_edges}");
    }

    #[test]
    fn flanks_without_hollows_are_left_alone() {
        for Hollowed { profile, .. } in hollowed() {
            for relief in [
                Relief::uniform(3e-6),
                Relief::from_samples(Relief::grid(720).map(|phi| 2.0 * UM * (2.0 * phi).cos()).collect()),
            ] {
                assert_eq!(relief.without_hollows(&profile, profile.pin_radius), None, "{profile:?}");
            }
        }
    }

    /// Flanks worn in waves of the length of the grid, as coarse wear steps produce them, several times as
    /// curved as the pin: on random designs, with different waves on each.
    fn wavy() -> Vec<(Profile, Relief)> {
        (1..=24)
            .map(|seed| {
                let profile = sound_design(seed).0.machine().profile();
                let middle = -1.4 + 0.11 * seed as f64;
                let depths = Relief::grid(720).enumerate().map(|(i, phi)| {
                    let step = arc_rate(&profile, phi) * std::f64::consts::TAU / 720.0;
                    let fit = profile.relative_curvature(phi.cos(), profile.pin_radius) * step * step;
                    // A sequence without a period.
                    let wave = ((i * i) as f64 * 0.7548 + seed as f64 * 0.569).fract();
                    4.0 * fit * wave * (-((phi - middle) / 0.15).powi(4)).exp()
                });
                let relief = Relief::from_control_points(&depths.collect::<Vec<_>>());
                (profile, relief)
            })
            .collect()
    }

    /// The first sample must lie on the hull: when the search began at the sharpest sample, the hollow beside
    /// it was not filled.
    #[test]
    fn no_hollow_stays_open_beside_the_sample_that_comes_first() {
        for (profile, relief) in wavy() {
            // By the definition, for the whole lobe: 1/R_eq + w″ along the flank, with a tolerance of a
            // twentieth of 1/R_eq for the variation of the arc length between samples.
            let concave = |relief: &Relief| {
                let (depth, count) = (relief.control_points(), relief.samples().len());
                let bend = |(i, phi): (usize, f64)| {
                    let second = depth[(i + count - 1) % count] - 2.0 * depth[i] + depth[(i + 1) % count];
                    let step = arc_rate(&profile, phi) * std::f64::consts::TAU / count as f64;
                    let fit = profile.relative_curvature(phi.cos(), profile.pin_radius);
                    1.0 + second / (step * step * fit)
                };
                Relief::grid(count).enumerate().map(bend).filter(|bend| *bend < -0.05).count()
            };
            assert!(concave(&relief) > 5, "{}", concave(&relief));
            let seen = relief.without_hollows(&profile, profile.pin_radius).unwrap();
            assert_eq!(concave(&seen), 0);
        }
    }

    /// The normal is the gradient of the gap where the flank has nearly the shape of the pin and its curvature
    /// changes from sample to sample, so closest points are converged there.
    #[test]
    fn normals_are_gradients_of_the_gap_on_filled_hollows() {
        for (profile, relief) in wavy() {
            let seen = relief.without_hollows(&profile, profile.pin_radius).unwrap();
            let closest = |p: Vec2, tau: f64| {
                profile.closest_on_worn(p, &profile.foot(p, tau), &seen, profile.pin_radius)
            };
            for i in 0..200 {
                // Penetrations of one micrometre at positions all over the waves.
                let tau = (1.4 - 0.014 * f64::from(i)) / profile.lobe_count() as f64;
                let p = profile.trace(tau) - 1e-6 * profile.outward_normal(tau);
                let here = closest(p, tau);
                let along = quarter_turn(here.normal);
                let h = 1e-9;
                let slope = |along: Vec2| {
                    (closest(p + h * along, tau).gap - closest(p - h * along, tau).gap) / (2.0 * h)
                };
                assert!(
                    (slope(here.normal) - 1.0).abs() < 1e-6 && slope(along).abs() < 1e-5,
                    "{i} {}",
                    slope(along)
                );
            }
        }
    }
}
