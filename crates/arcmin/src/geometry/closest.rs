use super::foot::Place;
use super::{Foot, Profile, Relief, Vec2, cross, quarter_turn};

/// Closest approach of a pin to a worn flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
    /// Parameter τ of the flank point in rad.
    pub tau: f64,
    /// Its meshing angle in rad, (−π, π].
    pub meshing_angle: f64,
    /// Gap in m.
    pub gap: f64,
    /// Gradient of the gap with respect to the pin centre (disc frame): the line of action, from flank to pin.
    pub normal: Vec2,
    /// Curvature of the worn flank in 1/m, positive where concave.
    pub flank_curvature: f64,
    /// Relative curvature 1/R_eq of the worn surfaces in 1/m.
    pub relative_curvature: f64,
}

/// Everything at one place of the worn flank.
struct Station {
    /// Vector from the worn flank point to the pin centre.
    reach: Vec2,
    /// Half derivative of the squared distance along the flank, over the distance: zero at the closest point; in m per m.
    slope: f64,
    /// Its own derivative: the relative curvature in 1/m, and that of the unworn pair.
    worn_curvature: f64,
    unworn_curvature: f64,
    /// Arc length of the flank per τ in m/rad.
    length: f64,
    meshing_angle: f64,
}

/// The last step (rad of φ) when the iteration stops; convergence is quadratic.
const LAST_STEP: f64 = 1e-11;

impl Profile {
    /// Closest point of the flank f(τ) − w(τ) n(τ) to a pin of radius `pin_radius` at `p`, started at the foot on the unworn flank.
    ///
    /// With q = c − (r + w) n the distance |p − q| is stationary where off·t = w_s (off·n + r + w), off = p − c, t the tangent and w_s the slope of the depth
    /// along the flank. Newton's method, then secants; where the depth is so wavy that it does not settle, golden section within ±0.3 rad of φ.
    pub fn closest_on_worn(&self, p: Vec2, foot: &Foot, relief: &Relief, pin_radius: f64) -> Closest {
        let (lobes, z) = (self.lobe_count() as f64, self.pin_count as f64);
        let mut place = foot.place;
        let mut before: Option<(f64, f64)> = None;
        let mut last_step = 1.0;
        for _ in 0..20 {
            let here = self.station(p, place, relief, pin_radius);
            // Never trust a hollow: a quarter of the unworn curvature keeps the step finite.
            let stiffest = -here.worn_curvature.max(0.25 * here.unworn_curvature) * here.length;
            // From the second station on the secant knows what the formula leaves out (how the flank's length changes with φ).
            let bend = before
                .map(|(tau, slope)| (here.slope - slope) / (place.tau - tau))
                .filter(|bend| *bend < 0.3 * stiffest && *bend > 3.0 * stiffest)
                .unwrap_or(stiffest);
            let step = (-here.slope / bend).clamp(-0.1 / lobes, 0.1 / lobes);
            before = Some((place.tau, here.slope));
            place = place.moved(step, z);
            // A secant leaves an error of the order of the product of its last two steps.
            if (step * lobes).abs() * last_step < LAST_STEP {
                return self.station(p, place, relief, pin_radius).closest(place, pin_radius);
            }
            last_step = (step * lobes).abs();
        }
        let at = |tau: f64| Place { tau, e: super::unit(tau), ez: super::unit(z * tau) };
        let gap = |tau: f64| self.station(p, at(tau), relief, pin_radius).gap(pin_radius);
        let (mut a, mut b) = (foot.tau - 0.3 / lobes, foot.tau + 0.3 / lobes);
        while b - a > 1e-6 / lobes {
            let (c, d) = (b - 0.618_033_988_75 * (b - a), a + 0.618_033_988_75 * (b - a));
            if gap(c) < gap(d) {
                b = d;
            } else {
                a = c;
            }
        }
        // The smallest distance is flat; its derivative changes sign sharply.
        (a, b) = (a - 1e-5 / lobes, b + 1e-5 / lobes);
        for _ in 0..45 {
            let middle = 0.5 * (a + b);
            if self.station(p, at(middle), relief, pin_radius).slope > 0.0 {
                a = middle;
            } else {
                b = middle;
            }
        }
        let place = at(0.5 * (a + b));
        self.station(p, place, relief, pin_radius).closest(place, pin_radius)
    }

    fn station(&self, p: Vec2, place: Place, relief: &Relief, pin_radius: f64) -> Station {
        let (c, c1, c2) = self.trace_derivatives(place.e, place.ez);
        let speed = c1.norm();
        let tangent = c1 / speed;
        let normal = -quarter_turn(tangent);
        let off = p - c;
        let trace_curvature = -cross(c1, c2) / (speed * speed * speed);
        let meshing_angle = self.meshing_angle(place.tau);
        let worn = relief.at(meshing_angle);
        let depth_below_trace = self.pin_radius + worn.depth;
        // The worn flank is an offset of the trace by r + w: so long is it per τ, so curved is it before its own waves.
        let stretch = 1.0 + depth_below_trace * trace_curvature;
        let length = speed * stretch.abs();
        let per_angle = length / self.lobe_count() as f64;
        let height = off.dot(&normal) + depth_below_trace;
        let along = off.dot(&tangent);
        let reach = height * normal + along * tangent;
        // φ falls where the contact moves along the tangent.
        let (w_x, w_xx) = (-worn.slope / per_angle, worn.bend / (per_angle * per_angle));
        let unworn_curvature = 1.0 / pin_radius - trace_curvature / stretch;
        let slope = along / height - w_x;
        Station { reach, slope, worn_curvature: unworn_curvature + w_xx, unworn_curvature, length, meshing_angle }
    }
}

impl Station {
    fn gap(&self, pin_radius: f64) -> f64 {
        self.reach.norm() - pin_radius
    }

    fn closest(&self, place: Place, pin_radius: f64) -> Closest {
        let distance = self.reach.norm();
        let line = self.reach / distance;
        Closest {
            tau: place.tau,
            meshing_angle: self.meshing_angle,
            gap: self.gap(pin_radius),
            normal: line,
            flank_curvature: 1.0 / pin_radius - self.worn_curvature,
            // A hollow sharper than the pin would touch at two places; a tenth of the unworn curvature keeps the single contact that
            // this model has (it enters the force only under a logarithm).
            relative_curvature: self.worn_curvature.max(0.1 * self.unworn_curvature),
        }
    }
}
