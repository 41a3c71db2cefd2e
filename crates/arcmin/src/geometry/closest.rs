use super::foot::Place;
use super::{Foot, Profile, Relief, Vec2, cross, quarter_turn};

/// Closest approach of a pin to a worn flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
    /// Parameter τ of the flank point in rad.
    pub tau: f64,
    /// Its meshing angle φ in rad, (−π, π], and e(φ).
    pub meshing_angle: f64,
    pub(crate) meshing_unit: Vec2,
    /// Gap in m.
    pub gap: f64,
    /// Gradient of the gap with respect to the pin centre (disc frame): the line of action, from flank to
    /// pin.
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
    /// Half derivative of the squared distance along the flank, over the distance: zero at the closest point;
    /// in m per m.
    slope: f64,
    /// Its derivative with respect to τ in 1/rad.
    slope_by_tau: f64,
    course: Course,
}

/// The last step (rad of φ) when the iteration stops: convergence is quadratic, so that the error left is of
/// order 1e-12.
const LAST_STEP: f64 = 1e-6;

impl Profile {
    /// Closest point of the flank f(τ) − w(τ) n(τ) to a pin of radius `pin_radius` at `p`, started at the
    /// foot on the unworn flank.
    ///
    /// With q = c − (r + w) n the distance |p − q| is stationary where off·t = w_s (off·n + r + w), off = p −
    /// c, t the tangent and w_s the slope of the depth along the flank. Newton's method; where the depth is
    /// so wavy that it does not settle, golden section within ±0.3 rad of φ.
    pub fn closest_on_worn(&self, p: Vec2, foot: &Foot, relief: &Relief, pin_radius: f64) -> Closest {
        let (lobes, z) = (self.lobe_count() as f64, self.pin_count as f64);
        let mut place = foot.place;
        for _ in 0..20 {
            let here = self.station(p, place, relief);
            // Never trust a hollow: a quarter of the unworn curvature keeps the step finite.
            let unworn_curvature = 1.0 / pin_radius - here.course.flank_curvature;
            let bend = here.slope_by_tau.min(-0.25 * unworn_curvature * here.course.length);
            let step = (-here.slope / bend).clamp(-0.1 / lobes, 0.1 / lobes);
            place = place.moved(step, z);
            if (step * lobes).abs() < LAST_STEP {
                return self.station(p, place, relief).closest(place, pin_radius);
            }
        }
        let at = |tau: f64| Place { tau, e: super::unit(tau), ez: super::unit(z * tau) };
        let gap = |tau: f64| self.station(p, at(tau), relief).gap(pin_radius);
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
            if self.station(p, at(middle), relief).slope > 0.0 {
                a = middle;
            } else {
                b = middle;
            }
        }
        let place = at(0.5 * (a + b));
        self.station(p, place, relief).closest(place, pin_radius)
    }

    /// How the worn flank runs at τ, where `meshing` is e(φ).
    pub(crate) fn worn_course(
        &self,
        tau: f64,
        meshing: Vec2,
        relief: &Relief,
        pin_radius: f64,
    ) -> WornCourse {
        if relief.is_uniform() {
            let (z, k1) = (self.pin_count as f64, self.short_width_coefficient());
            let factor = self.speed_factor(meshing.x);
            let speed = self.pin_circle_radius * factor;
            let trace = self.trace_curvature(meshing.x);
            let stretch = 1.0 + (self.pin_radius + relief.samples()[0]) * trace;
            let trace_rate = self.lobe_count() as f64 * k1 * meshing.y * ((1.0 + z) / speed + 3.0 * trace)
                / (factor * factor);
            return WornCourse {
                curvature: trace / stretch,
                length: speed * stretch.abs(),
                relative_curvature_rate: -trace_rate / (stretch * stretch),
            };
        }
        let z = self.pin_count as f64;
        let here = Place { tau, e: super::unit(tau), ez: super::unit(z * tau) };
        let course = self.course(here, relief);
        // So short that it seldom leaves a cell of the depth's spline, whose third derivative jumps between
        // cells.
        let step = 1e-5 / self.lobe_count() as f64;
        let relative = |step: f64| self.course(here.moved(step, z), relief).relative_curvature(pin_radius);
        WornCourse {
            curvature: 1.0 / pin_radius - course.relative_curvature(pin_radius),
            length: course.length.hypot(course.depth_rate),
            relative_curvature_rate: (relative(step) - relative(-step)) / (2.0 * step),
        }
    }

    /// The worn flank f = c − (r + w) n and how it goes on: f′ = A t − w′ n with A = |c′| (1 + (r + w) κ0).
    fn course(&self, place: Place, relief: &Relief) -> Course {
        let (c, c1, c2) = self.trace_derivatives(place.e, place.ez);
        let c3 = self.trace_third_derivative(place.e, place.ez);
        let speed = c1.norm();
        let per_speed = 1.0 / speed;
        let per_speed3 = per_speed * per_speed * per_speed;
        let trace_curvature = -cross(c1, c2) * per_speed3;
        let speed_rate = c1.dot(&c2) * per_speed;
        let trace_curvature_rate =
            -cross(c1, c3) * per_speed3 - 3.0 * trace_curvature * speed_rate * per_speed;
        let lobes = self.lobe_count() as f64;
        let meshing_angle = self.meshing_angle(place.tau);
        let worn = relief.at(meshing_angle);
        // φ falls with τ.
        let depth_rate = -lobes * worn.slope;
        let depth_below_trace = self.pin_radius + worn.depth;
        let stretch = 1.0 + depth_below_trace * trace_curvature;
        let stretch_rate = depth_rate * trace_curvature + depth_below_trace * trace_curvature_rate;
        Course {
            trace: c,
            tangent: c1 * per_speed,
            speed,
            turning: trace_curvature * speed,
            flank_curvature: trace_curvature / stretch,
            depth_below_trace,
            depth_rate,
            depth_bend: lobes * lobes * worn.bend,
            length: speed * stretch.abs(),
            length_rate: (speed_rate * stretch + speed * stretch_rate) * stretch.signum(),
            meshing_angle,
        }
    }

    fn station(&self, p: Vec2, place: Place, relief: &Relief) -> Station {
        let course = self.course(place, relief);
        let Course { tangent, speed, turning, depth_below_trace, depth_rate, length, .. } = course;
        let normal = -quarter_turn(tangent);
        let off = p - course.trace;
        let per_length = 1.0 / length;
        let height = off.dot(&normal) + depth_below_trace;
        let per_height = 1.0 / height;
        let along = off.dot(&tangent);
        let depth_slope = depth_rate * per_length;
        let slope = along * per_height - depth_slope;
        // The tangent turns by κ0 |c′| per τ towards the normal, the normal as much against the tangent.
        let along_rate = turning * (height - depth_below_trace) - speed;
        let height_rate = depth_rate - turning * along;
        let slope_by_tau = (along_rate - along * per_height * height_rate) * per_height
            - (course.depth_bend - depth_slope * course.length_rate) * per_length;
        Station { reach: height * normal + along * tangent, slope, slope_by_tau, course }
    }
}

/// The worn flank at one place as the contact sees it.
pub(crate) struct WornCourse {
    /// κ in 1/m, positive where concave.
    pub curvature: f64,
    /// Arc length in m/rad of τ.
    pub length: f64,
    /// d(1/R_eq)/dτ in 1/(m·rad).
    pub relative_curvature_rate: f64,
}

impl Course {
    /// 1/R_eq in 1/m against a pin. A hollow sharper than the pin would touch at two places; a tenth of the
    /// relative curvature without the waves of the depth keeps the single contact that this model has (it
    /// enters the force only under a logarithm).
    fn relative_curvature(&self, pin_radius: f64) -> f64 {
        let Course { turning, length, length_rate, depth_rate, depth_bend, .. } = self;
        let square = length * length + depth_rate * depth_rate;
        let bends =
            length * (length * turning - depth_bend) + depth_rate * (length_rate + depth_rate * turning);
        let curvature = bends / (square * square.sqrt());
        (1.0 / pin_radius - curvature).max(0.1 * (1.0 / pin_radius - self.flank_curvature))
    }
}

/// The worn flank at one place, per radian of τ.
struct Course {
    /// c, and the unit tangent t of trace and unworn flank.
    trace: Vec2,
    tangent: Vec2,
    /// |c′| in m/rad, and κ0 |c′| by which the tangent turns.
    speed: f64,
    turning: f64,
    /// Curvature of the trace's offset by r + w, without the waves of the depth, in 1/m.
    flank_curvature: f64,
    /// r + w in m, w′ in m/rad, w″ in m/rad².
    depth_below_trace: f64,
    depth_rate: f64,
    depth_bend: f64,
    /// A in m/rad and A′ in m/rad².
    length: f64,
    length_rate: f64,
    meshing_angle: f64,
}

impl Station {
    fn gap(&self, pin_radius: f64) -> f64 {
        self.reach.norm() - pin_radius
    }

    fn closest(&self, place: Place, pin_radius: f64) -> Closest {
        let distance = self.reach.norm();
        let relative_curvature = self.course.relative_curvature(pin_radius);
        let (cos, sin) = Profile::meshing_cos_sin(place.e, place.ez);
        Closest {
            tau: place.tau,
            meshing_angle: self.course.meshing_angle,
            meshing_unit: Vec2::new(cos, sin),
            gap: distance - pin_radius,
            normal: self.reach / distance,
            flank_curvature: 1.0 / pin_radius - relative_curvature,
            relative_curvature,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::unit;

    #[test]
    fn slope_along_the_flank_has_the_derivative_that_newton_uses() {
        let profile =
            Profile { pin_count: 40, pin_circle_radius: 64e-3, eccentricity: 1.3e-3, pin_radius: 3e-3 };
        let relief = Relief::from_samples(
            Relief::grid(720).map(|phi| 1e-5 * (1.3 + (2.0 * phi).sin() + 0.2 * (9.0 * phi).cos())).collect(),
        );
        let at = |tau: f64| Place { tau, e: unit(tau), ez: unit(40.0 * tau) };
        for i in 0..60 {
            let tau = 0.4 + 0.0027 * i as f64;
            let p = profile.trace(tau) + crate::geometry::Vec2::new(2e-5, -1e-5);
            let slope = |tau: f64| profile.station(p, at(tau), &relief).slope;
            let h = 1e-7;
            let difference = (slope(tau + h) - slope(tau - h)) / (2.0 * h);
            let exact = profile.station(p, at(tau), &relief).slope_by_tau;
            // The difference quotient has rounding of 1e-16/h and the third derivative's h².
            assert!((difference / exact - 1.0).abs() < 1e-5, "{tau}: {difference} {exact}");
        }
    }
}
