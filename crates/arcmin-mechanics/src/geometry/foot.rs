use super::{Profile, Vec2, cross, unit};

/// The point of the trace nearest to a pin centre, on the flank that the pin can touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    /// Parameter of the trace in rad.
    pub tau: f64,
    /// Signed distance (p − c(τ))·n_out of the pin centre from the trace in m; negative inside the metal.
    pub distance: f64,
    /// Outward unit normal in the disc frame.
    pub normal: Vec2,
    /// cos φ of the foot.
    pub cos_meshing: f64,
    /// sin φ of the foot.
    pub sin_meshing: f64,
    /// Curvature of the trace 1/ρ0 at the foot in 1/m, positive where concave.
    pub trace_curvature: f64,
    /// Whether the pin is beyond the end of the flank, near the corner or the land of a tip. Then the distance
    /// is that from the corner or land less the generating pin radius, the normal points from there to the pin,
    /// and the curvature is that of the path of a pin rolling around it; τ and φ are those of the end.
    pub at_tip: bool,
    pub(super) place: Place,
}

impl Foot {
    /// e(τ).
    #[inline]
    pub(crate) fn direction(&self) -> Vec2 {
        if self.place.shared { self.place.e } else { unit(self.tau) }
    }
}

/// Below this |φ| the trace has such a small radius of curvature (0.07 mm at the root of an RV-40E) that a pin
/// 10 µm off its nominal position has two local minima of the distance, and Newton's method may converge to the
/// wrong one. There the foot is searched within a bracket.
pub(super) const ROOT_ZONE_COS: f64 = 0.94;
/// Last step (rad of z τ) of the iteration: convergence is cubic, so that the remaining error is of order step³
/// ≲ 1e-12. The distance, which is stationary in τ, would allow a larger value, but the depth of a worn flank
/// is evaluated at τ and must be continuous.
pub(super) const LAST_STEP: f64 = 1e-4;
/// The same for a step of Newton's method, whose error is of order step² times the ratio of the flank's size to
/// its smallest radius of curvature.
const LAST_NEWTON_STEP: f64 = 1e-8;

/// Directions of pin and eccentric at τ: e(τ) and e(z τ) for a tooth difference of 1. They are updated with τ,
/// so that small steps need no new sine or cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub tau: f64,
    pub e: Vec2,
    pub ez: Vec2,
    /// Whether the direction of the pin equals e(τ).
    pub shared: bool,
}

/// Rotations of pin and eccentric per rotation of τ: m and z_p.
pub(super) type Turns = [f64; 2];

impl Place {
    #[inline]
    pub fn moved(self, step: f64, [m, z]: Turns) -> Place {
        Place {
            tau: self.tau + step,
            e: super::turned(self.e, small_unit(m * step)),
            ez: super::turned(self.ez, small_unit(z * step)),
            shared: self.shared,
        }
    }
}

/// e(x); for small x from its series, whose error is below 1e-16 for |x| ≤ 0.1.
#[inline]
pub(super) fn small_unit(x: f64) -> Vec2 {
    let q = x * x;
    if q < 1e-6 {
        return Vec2::new(
            1.0 + q * (-0.5 + q * (1.0 / 24.0)),
            x * (1.0 + q * (-1.0 / 6.0 + q * (1.0 / 120.0))),
        );
    }
    if q > 0.01 {
        return unit(x);
    }
    let sin = x * (1.0 + q * (-1.0 / 6.0 + q * (1.0 / 120.0 + q * (-1.0 / 5040.0 + q * (1.0 / 362_880.0)))));
    let cos = 1.0
        + q * (-0.5
            + q * (1.0 / 24.0 + q * (-1.0 / 720.0 + q * (1.0 / 40_320.0 + q * (-1.0 / 3_628_800.0)))));
    Vec2::new(cos, sin)
}

/// D = (p − c(τ))·c′(τ), D′ and D″.
struct Slopes {
    value: f64,
    slope: f64,
    bend: f64,
}

impl Profile {
    /// Foot of the pin centre `p` (disc frame, m) on the trace, started at parameter `guess`.
    ///
    /// Solves D = (p − c(τ))·c′(τ) = 0. Away from the roots by Chebyshev's method, −D/D′ (1 + D D″/2D′²) per
    /// step. Near a root, and wherever this does not contract, the foot is bracketed on the half lobe on the
    /// pin's side of the root's axis. On that half lobe the solution is unique: the evolute of its concave part
    /// lies on the other side of the axis, that of its convex part millimetres deep inside the disc.
    ///
    /// For a flank that ends at a tip, the foot is searched on the half lobe of the root nearest to the pin,
    /// independent of the guess.
    pub fn foot(&self, p: Vec2, guess: f64) -> Foot {
        self.foot_from(p, guess, unit(guess), unit(self.pin_count as f64 * guess))
    }

    /// Rotations of pin and eccentric per rotation of τ.
    #[inline]
    pub(super) fn turns(&self) -> Turns {
        [self.tooth_difference as f64, self.pin_count as f64]
    }

    /// [`Profile::foot`] with given e(guess) and e(z·guess); the latter is the same for all pins of the ring.
    #[inline]
    pub(crate) fn foot_from(&self, p: Vec2, guess: f64, e: Vec2, ez: Vec2) -> Foot {
        if let Some(tip) = &self.tip {
            return self.foot_below_tip(p, tip, guess);
        }
        let turns @ [_, z] = self.turns();
        let mut place = Place { tau: guess, e, ez, shared: true };
        for _ in 0..6 {
            if e_dot(&place) > ROOT_ZONE_COS {
                break;
            }
            let Slopes { value, slope, bend } = self.slopes(p, place);
            let per_slope = 1.0 / slope;
            let newton = -value * per_slope;
            let step = newton * (1.0 - 0.5 * newton * bend * per_slope);
            // `slope` is negative at every minimum of the distance. The limit 0.35 is a third of the angle
            // between inflection and tip: larger first steps are rejected, and so are steps that the second
            // derivative changes by more than a third. The comparisons are false for NaN.
            if !(slope < 0.0 && (z * newton).abs() < 0.35 && (step - newton).abs() <= 0.35 * newton.abs()) {
                break;
            }
            place = place.moved(step, turns);
            if (z * step).abs() < LAST_STEP {
                return if e_dot(&place) > ROOT_ZONE_COS {
                    self.bracketed_foot(p, place)
                } else {
                    self.foot_at(p, place)
                };
            }
        }
        self.bracketed_foot(p, place)
    }

    /// Safeguarded search: Newton's method inside a shrinking bracket on the half lobe nearest to the pin.
    fn bracketed_foot(&self, p: Vec2, guess: Place) -> Foot {
        let z = self.pin_count as f64;
        let pitch = std::f64::consts::TAU / self.lobe_count() as f64;
        let root = pitch * (guess.tau / pitch).round();
        // z τ and τ differ by whole turns there.
        let axis = super::turned(guess.e, small_unit(root - guess.tau));
        let root_place = Place { tau: root, e: axis, ez: axis, shared: true };
        // D at the root, where the trace is perpendicular to its axis.
        let side = cross(axis, p) * (self.pin_circle_radius - z * self.eccentricity);
        if side == 0.0 {
            return self.foot_at(p, root_place);
        }
        // D is positive at `low` and negative at `high`.
        let (low, high) = if side > 0.0 { (root, root + 0.5 * pitch) } else { (root - 0.5 * pitch, root) };
        let place = if guess.tau > low && guess.tau < high {
            guess
        } else {
            root_place.moved(0.5 * (low + high) - root, self.turns())
        };
        self.enclosed_foot(p, place, [low, high])
    }

    /// The foot between two positions at which D is positive and negative, started at `place`.
    pub(super) fn enclosed_foot(&self, p: Vec2, mut place: Place, [mut low, mut high]: [f64; 2]) -> Foot {
        let turns @ [_, z] = self.turns();
        let mut tau = place.tau;
        for _ in 0..80 {
            let Slopes { value, slope, bend } = self.slopes(p, place);
            if value > 0.0 {
                low = tau;
            } else {
                high = tau;
            }
            let newton = -value / slope;
            let correction = 0.5 * newton * bend / slope;
            let (step, last_step) = if correction.abs() < 0.35 {
                (newton * (1.0 - correction), LAST_STEP)
            } else {
                (newton, LAST_NEWTON_STEP)
            };
            // An end of the bracket may be the solution within rounding: a step that leaves the bracket by less
            // than 1e-7 rad is accepted.
            let inside = tau + step > low - 1e-7 && tau + step < high + 1e-7;
            let (next, last_step) = if slope < 0.0 && inside {
                (tau + step, 0.1 * last_step)
            } else {
                (0.5 * (low + high), 1e-10)
            };
            let step = next - tau;
            place = place.moved(step, turns);
            if (z * step).abs() < last_step {
                break;
            }
            tau = next;
        }
        self.foot_at(p, place)
    }

    #[inline]
    fn slopes(&self, p: Vec2, place: Place) -> Slopes {
        let (c, c1, c2) = self.trace_derivatives(place.e, place.ez);
        let c3 = self.trace_third_derivative(place.e, place.ez);
        let off = p - c;
        Slopes {
            value: off.dot(&c1),
            slope: off.dot(&c2) - c1.norm_squared(),
            bend: off.dot(&c3) - 3.0 * c1.dot(&c2),
        }
    }

    /// D at a place.
    pub(super) fn slope_of_distance(&self, p: Vec2, place: Place) -> f64 {
        self.slopes(p, place).value
    }

    #[inline]
    pub(super) fn foot_at(&self, p: Vec2, place: Place) -> Foot {
        let (c, c1, c2) = self.trace_derivatives(place.e, place.ez);
        let per_speed = 1.0 / c1.norm();
        let normal = Vec2::new(c1.y, -c1.x) * per_speed;
        let (cos_meshing, sin_meshing) = Profile::meshing_cos_sin(place.e, place.ez);
        Foot {
            tau: place.tau,
            distance: (p - c).dot(&normal),
            normal,
            cos_meshing,
            sin_meshing,
            trace_curvature: -cross(c1, c2) * per_speed * per_speed * per_speed,
            at_tip: false,
            place,
        }
    }
}

fn e_dot(place: &Place) -> f64 {
    place.e.dot(&place.ez)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rv_40e() -> Profile {
        Profile::new(40, 64e-3, 1.3e-3, 3e-3)
    }

    /// Smallest |p − c(τ)| over the half lobe on the pin's side, by dense sampling and golden section: slow
    /// and independent.
    fn nearest_by_sampling(profile: &Profile, p: Vec2, root: f64, side: f64) -> f64 {
        let half = std::f64::consts::PI / 39.0;
        let distance = |tau: f64| (p - profile.trace(tau)).norm();
        let best = (0..=4000)
            .map(|i| root + side * half * i as f64 / 4000.0)
            .min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
            .unwrap();
        let (mut a, mut b) = (best - half / 4000.0, best + half / 4000.0);
        for _ in 0..100 {
            let (c, d) = (b - 0.618 * (b - a), a + 0.618 * (b - a));
            if distance(c) < distance(d) { b = d } else { a = c }
        }
        0.5 * (a + b)
    }

    #[test]
    fn foot_of_a_point_put_off_the_trace_is_recovered_everywhere() {
        let profile = rv_40e();
        for i in 0..2000 {
            let tau = 1.0 + i as f64 * 1e-4;
            for distance in [-6e-5, -1e-6, 0.0, 2e-6, 5e-5] {
                let p = profile.trace(tau) + distance * profile.outward_normal(tau);
                for error in [-0.008, -0.003, 0.0, 0.004, 0.008] {
                    let foot = profile.foot(p, tau + error);
                    assert!(
                        (foot.distance - distance).abs() < 1e-13,
                        "{tau} {distance} {error}: {}",
                        foot.distance
                    );
                }
            }
        }
    }

    /// Without load and with 60 µm of wear the disc has a play of ±3.9′, which moves a pin by ±73 µm along the
    /// ring, while the radius of curvature of the trace at the root is 71 µm. If clearances also let the disc
    /// recede by 10 µm, the distance has two minima: Newton's method without a bracket, started at the nominal
    /// foot, converges to the wrong flank, to the maximum between them, or to another lobe. The bracketed
    /// search agrees with sampling.
    #[test]
    fn trap_plain_newton_takes_the_wrong_flank_at_the_root() {
        let profile = rv_40e();
        let z = profile.pin_count as f64;
        let root = std::f64::consts::TAU / 39.0 * 3.0;
        let axis = super::super::quarter_turn(unit(root));
        let mut newton_failures = 0;
        for i in 0..=120 {
            // φ of the nominal place within ±20°.
            let tau = root + (i as f64 - 60.0) / 60.0 * 20.0 * crate::units::DEG / 39.0;
            for along in [-73e-6, -60e-6, 60e-6, 73e-6] {
                for outward in [-20e-6, 0.0, 20e-6, 40e-6, 60e-6] {
                    let p = profile.trace(tau)
                        + along * super::super::quarter_turn(unit(tau))
                        + outward * unit(tau);
                    let side = (p - profile.trace(root)).dot(&axis).signum();
                    let nearest = (p - profile.trace(nearest_by_sampling(&profile, p, root, side))).norm();
                    let foot = profile.foot(p, tau);
                    assert!((foot.distance.abs() - nearest).abs() < 1e-11, "{i} {along} {outward}");
                    let mut plain = tau;
                    for _ in 0..50 {
                        let (c, c1, c2) = profile.trace_derivatives(unit(plain), unit(z * plain));
                        plain -= (p - c).dot(&c1) / ((p - c).dot(&c2) - c1.norm_squared());
                    }
                    let settled = (p - profile.trace(plain)).norm();
                    // Not `>=`: a NaN of Newton's method counts as a failure too.
                    if !((settled - nearest).abs() < 1e-9) {
                        newton_failures += 1;
                    }
                }
            }
        }
        assert!(newton_failures >= 10, "the trap has gone: {newton_failures}");
    }
}
