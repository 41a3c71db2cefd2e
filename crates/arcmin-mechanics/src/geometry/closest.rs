use super::foot::Place;
use super::{Foot, Profile, Relief, Vec2, cross, quarter_turn};

/// Closest approach of a pin to a worn flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
    /// Parameter τ of the flank point in rad.
    pub tau: f64,
    /// Its meshing angle φ in rad, (−π, π].
    pub meshing_angle: f64,
    /// Gap in m.
    pub gap: f64,
    /// Gradient of the gap with respect to the pin centre (disc frame): the line of action, from flank to
    /// pin.
    pub normal: Vec2,
    /// Curvature of the worn flank in 1/m, positive where concave.
    pub flank_curvature: f64,
    /// Relative curvature 1/R_eq of the worn surfaces in 1/m; its lower limit is a tenth of the value without
    /// the waves of the relief.
    pub relative_curvature: f64,
}

/// A step (rad of φ) after which the trace is continued by its Taylor series instead of being evaluated again.
const LAST_STEP: f64 = 2e-4;
/// Error (rad of φ) at which the iteration ends: the distance has an error of its square, the normal one in its
/// last digits. After one step of [`LAST_STEP`] the error is the square of that step on a smooth flank, but
/// much larger where the curvature of the relief changes within a step of its grid and the flank has nearly the
/// shape of the pin.
const SETTLED: f64 = LAST_STEP * LAST_STEP;
/// Steps of Newton's method before the closest point is enclosed.
const QUICK_STEPS: usize = 8;
/// Longest step towards the closest point while it is not enclosed, in rad of φ.
const LONGEST_STEP: f64 = 0.1;
/// Lower limit of the relative curvature, as a fraction of that without the waves of the depth.
const LEAST_CURVATURE: f64 = 0.1;
/// Error of a bracketed closest point, in rad of φ.
const CLOSE: f64 = 1e-10;

impl Profile {
    /// Closest point of the flank f(τ) − w(τ) n(τ) to a pin of radius `pin_radius` at `p`, started at the
    /// foot on the unworn flank.
    ///
    /// With q = c − (r + w) n the distance |p − q| is stationary where off·t = w_s (off·n + r + w), off = p −
    /// c, t the tangent and w_s the slope of the depth along the flank. Solved by Newton's method: the first
    /// step needs only the foot and the depth there, the last one uses the Taylor series of the trace. If it
    /// does not converge, the point is bracketed between two points with slopes of opposite sign.
    pub fn closest_on_worn(&self, p: Vec2, foot: &Foot, relief: &Relief, pin_radius: f64) -> Closest {
        if let Some(tip) = &self.tip
            && let Some(closest) = self.closest_at_tip(p, foot, tip, relief, pin_radius)
        {
            return closest;
        }
        let (lobes, turns) = (self.lobe_count() as f64, self.turns());
        let bounded = |step: f64| step.clamp(-LONGEST_STEP / lobes, LONGEST_STEP / lobes);
        let mut place = foot.place.moved(bounded(self.first_step(foot, relief, pin_radius)), turns);
        let (mut before, mut after) = (f64::NAN, f64::NAN);
        for _ in 0..QUICK_STEPS {
            let here = self.worn_at(place, relief);
            let station = Station::new(p, &here);
            let step = -station.slope / station.slope_by_tau;
            if (step * lobes).abs() < LAST_STEP && station.slope_by_tau < 0.0 {
                let next = place.moved(step, turns);
                let there = self.worn_on(here.trace.moved(step), next.tau, relief);
                let left = Station::new(p, &there);
                if (left.slope * lobes).abs() < SETTLED * left.slope_by_tau.abs() {
                    return Closest::on(p, next, &there, pin_radius);
                }
            }
            *(if station.slope > 0.0 { &mut before } else { &mut after }) = place.tau;
            place = place.moved(bounded(station.step(pin_radius)), turns);
        }
        let ends = if before >= after { [f64::NAN; 2] } else { [before, after] };
        self.closest_between(p, ends, place, relief, pin_radius)
    }

    /// The closest point within a bracket, from `place`: the distance decreases at its lower end and increases
    /// at its upper end. Newton's method, with bisection if a step leaves the bracket or converges slowly. An
    /// unknown end is NaN; it is found by steps in the direction of decreasing distance. If the flank is worn
    /// to the shape of the pin, the distance is nearly constant and the closest point far from the foot; on a
    /// wavy flank Newton's method may cycle.
    #[cold]
    pub(super) fn closest_between(
        &self,
        p: Vec2,
        [mut low, mut high]: [f64; 2],
        mut place: Place,
        relief: &Relief,
        pin_radius: f64,
    ) -> Closest {
        let (lobes, turns) = (self.lobe_count() as f64, self.turns());
        let mut earlier = f64::INFINITY;
        // Bisection alone needs thirty steps.
        for _ in 0..100 {
            let station = Station::new(p, &self.worn_at(place, relief));
            *(if station.slope > 0.0 { &mut low } else { &mut high }) = place.tau;
            let step = -station.slope / station.slope_by_tau;
            if (step * lobes).abs() < CLOSE || (high - low) * lobes < CLOSE {
                break;
            }
            let next = place.tau + step;
            let good = low < next && next < high && step.abs() < 0.5 * earlier;
            let next = match (good, 0.5 * (low + high)) {
                (true, _) => next,
                (false, middle) if middle.is_nan() => {
                    place.tau + LONGEST_STEP.copysign(station.slope) / lobes
                }
                (false, middle) => middle,
            };
            earlier = (next - place.tau).abs();
            place = place.moved(next - place.tau, turns);
        }
        Closest::on(p, place, &self.worn_at(place, relief), pin_radius)
    }

    /// The first step of [`Profile::closest_on_worn`] in rad of τ.
    #[inline]
    fn first_step(&self, foot: &Foot, relief: &Relief, pin_radius: f64) -> f64 {
        if foot.at_tip { 0.0 } else { self.station_at_foot(foot, relief).step(pin_radius) }
    }

    /// Relative curvature in 1/m of the flank as designed against a pin, from the curvature of the trace.
    #[inline]
    pub(crate) fn designed_curvature(&self, trace_curvature: f64, pin_radius: f64) -> f64 {
        1.0 / pin_radius - trace_curvature / (1.0 + self.pin_radius * trace_curvature)
    }

    /// Its derivative by τ, in 1/(m rad), from sin φ and the speed factor as well.
    #[inline]
    pub(crate) fn designed_curvature_rate(&self, sin_meshing: f64, factor: f64, trace_curvature: f64) -> f64 {
        let stretch = 1.0 + self.pin_radius * trace_curvature;
        -self.trace_curvature_rate(sin_meshing, factor, trace_curvature) / (stretch * stretch)
    }

    /// The second derivative by τ, in 1/(m rad²), from e(φ), the speed factor and the curvature of the trace.
    pub(crate) fn designed_curvature_bend(&self, meshing: Vec2, factor: f64, trace_curvature: f64) -> f64 {
        let (z, lobes, k1) = (self.pins_per_turn(), self.lobe_count() as f64, self.short_width_coefficient());
        let (cos, sin) = (meshing.x, meshing.y);
        let rate = self.trace_curvature_rate(sin, factor, trace_curvature);
        let factor_rate = self.speed_factor_rate(sin, factor);
        let shape = (1.0 + z) / (self.pin_circle_radius * factor);
        let turning = shape + 3.0 * trace_curvature;
        let turning_rate = -shape * factor_rate / factor + 3.0 * rate;
        let bend = lobes * k1 / (factor * factor)
            * (sin * (turning_rate - 2.0 * turning * factor_rate / factor) - lobes * cos * turning);
        let stretch = 1.0 + self.pin_radius * trace_curvature;
        (2.0 * self.pin_radius * rate * rate / stretch - bend) / (stretch * stretch)
    }

    /// dS/dτ, from sin φ and S.
    #[inline]
    pub(crate) fn speed_factor_rate(&self, sin_meshing: f64, factor: f64) -> f64 {
        -(self.lobe_count() as f64) * self.short_width_coefficient() * sin_meshing / factor
    }

    /// Derivative by τ of the trace's curvature in 1/(m rad), for the given curvature and speed factor.
    #[inline]
    pub(crate) fn trace_curvature_rate(&self, sin_meshing: f64, factor: f64, curvature: f64) -> f64 {
        let (z, lobes) = (self.pins_per_turn(), self.lobe_count() as f64);
        let turning = (1.0 + z) / (self.pin_circle_radius * factor) + 3.0 * curvature;
        lobes * self.short_width_coefficient() * sin_meshing * turning / (factor * factor)
    }

    /// First and second derivative of the distance at the foot on the unworn flank, in closed form, because the
    /// pin centre lies on the normal there.
    #[inline]
    fn station_at_foot(&self, foot: &Foot, relief: &Relief) -> Station {
        let (lobes, k1) = (self.lobe_count() as f64, self.short_width_coefficient());
        let factor = self.speed_factor(foot.cos_meshing);
        let speed = self.circle_speed() * factor;
        let speed_rate = -self.circle_speed() * lobes * k1 * foot.sin_meshing / factor;
        let curvature = foot.trace_curvature;
        let curvature_rate = self.trace_curvature_rate(foot.sin_meshing, factor, curvature);
        let turning = curvature * speed;
        let worn = relief.at(self.meshing_angle(foot.tau));
        let depth = self.pin_radius + worn.depth;
        let (depth_rate, depth_bend) = (-lobes * worn.slope, lobes * lobes * worn.bend);
        let length = speed + depth * turning;
        let length_rate =
            speed_rate + depth_rate * turning + depth * (curvature_rate * speed + curvature * speed_rate);
        let (length, length_rate) = (length.abs(), length_rate * length.signum());
        let slope = -depth_rate / length;
        Station {
            slope,
            slope_by_tau: (turning * foot.distance - speed) / (foot.distance + depth)
                - (depth_bend + slope * length_rate) / length,
            flank_curvature: turning / (speed + depth * turning),
            length,
        }
    }

    /// The trace and its derivatives at one position.
    #[inline]
    fn trace_course(&self, place: Place) -> Trace {
        let (c, c1, c2) = self.trace_derivatives(place.e, place.ez);
        let c3 = self.trace_third_derivative(place.e, place.ez);
        let c4 = self.trace_fourth_derivative(place.e, place.ez);
        let speed = c1.norm();
        let per_speed = 1.0 / speed;
        let per_square = per_speed * per_speed;
        let speed_rate = c1.dot(&c2) * per_speed;
        let speed_bend = (c2.norm_squared() + c1.dot(&c3) - speed_rate * speed_rate) * per_speed;
        // N = −c′ × c″ = κ0 |c′|³, N′ and N″.
        let (n, n1, n2) = (-cross(c1, c2), -cross(c1, c3), -(cross(c2, c3) + cross(c1, c4)));
        let growth = speed_rate * per_speed;
        let turning = n * per_square;
        let turning_rate = n1 * per_square - 2.0 * turning * growth;
        let turning_bend = n2 * per_square
            - 4.0 * n1 * per_square * growth
            - 2.0 * turning * (speed_bend * per_speed - 3.0 * growth * growth);
        Trace {
            c,
            tangent: c1 * per_speed,
            speed,
            speed_rate,
            speed_bend,
            turning,
            turning_rate,
            turning_bend,
        }
    }

    /// Slope of the distance of a pin centre along the worn flank at a position, and the point of the flank
    /// there.
    pub(super) fn worn_end(&self, p: Vec2, place: Place, relief: &Relief) -> (f64, Vec2) {
        let worn = self.worn_at(place, relief);
        (Station::new(p, &worn).slope, p - worn.reach(p))
    }

    /// The worn flank and its derivatives at a position.
    #[inline]
    fn worn_at(&self, place: Place, relief: &Relief) -> Worn {
        self.worn_on(self.trace_course(place), place.tau, relief)
    }

    /// f = c − (r + w) n and its derivatives: f′ = A t − w′ n with A = |c′| (1 + (r + w) κ0).
    #[inline]
    fn worn_on(&self, trace: Trace, tau: f64, relief: &Relief) -> Worn {
        let lobes = self.lobe_count() as f64;
        let meshing_angle = self.meshing_angle(tau);
        let worn = relief.at(meshing_angle);
        // φ decreases with τ.
        let (d, d1, d2) = (self.pin_radius + worn.depth, -lobes * worn.slope, lobes * lobes * worn.bend);
        let Trace { speed, speed_rate, turning, turning_rate, .. } = trace;
        let length = speed + d * turning;
        let length_rate = speed_rate + d1 * turning + d * turning_rate;
        let sign = length.signum();
        Worn {
            trace,
            depth_below_trace: d,
            depth_rate: d1,
            depth_bend: d2,
            sign,
            length: sign * length,
            length_rate: sign * length_rate,
            meshing_angle,
        }
    }
}

impl Closest {
    #[inline]
    fn on(p: Vec2, place: Place, worn: &Worn, pin_radius: f64) -> Closest {
        let reach = worn.reach(p);
        let distance = reach.norm();
        let curvature = worn.curvature();
        let least = LEAST_CURVATURE * (1.0 / pin_radius - worn.flank_curvature());
        Closest {
            tau: place.tau,
            meshing_angle: worn.meshing_angle,
            gap: distance - pin_radius,
            normal: reach / distance,
            flank_curvature: curvature,
            relative_curvature: (1.0 / pin_radius - curvature).max(least),
        }
    }
}

/// The trace at one position, with derivatives by τ in radian.
#[derive(Debug, Clone, Copy)]
struct Trace {
    c: Vec2,
    tangent: Vec2,
    /// |c′| in m/rad with its derivatives.
    speed: f64,
    speed_rate: f64,
    speed_bend: f64,
    /// κ0 |c′|, rotation of the tangent towards the normal per radian of τ, with its derivatives.
    turning: f64,
    turning_rate: f64,
    turning_bend: f64,
}

impl Trace {
    #[inline]
    fn normal(&self) -> Vec2 {
        -quarter_turn(self.tangent)
    }

    /// The trace at a small distance `way` (rad of τ), by Taylor series: c to third order, the rest to second.
    /// The relative errors are below 1e-9 for [`LAST_STEP`].
    #[inline]
    fn moved(&self, way: f64) -> Trace {
        let Trace { c, tangent, speed, speed_rate, speed_bend, turning, turning_rate, turning_bend } = *self;
        let half = 0.5 * way * way;
        let third = half * way / 3.0;
        let along = speed * way + speed_rate * half + (speed_bend - speed * turning * turning) * third;
        let across = speed * turning * half + (2.0 * speed_rate * turning + speed * turning_rate) * third;
        let turn = turning * way + turning_rate * half + turning_bend * third;
        let (cos, sin) = (1.0 - 0.5 * turn * turn, turn - turn * turn * turn / 6.0);
        Trace {
            c: c + along * tangent + across * self.normal(),
            tangent: cos * tangent + sin * self.normal(),
            speed: speed + speed_rate * way + speed_bend * half,
            speed_rate: speed_rate + speed_bend * way,
            turning: turning + turning_rate * way + turning_bend * half,
            turning_rate: turning_rate + turning_bend * way,
            ..*self
        }
    }
}

/// The worn flank at one position, with derivatives by τ in radian.
struct Worn {
    trace: Trace,
    /// r + w in m, w′ in m/rad, w″ in m/rad².
    depth_below_trace: f64,
    depth_rate: f64,
    depth_bend: f64,
    /// −1 where the direction of the flank is reversed.
    sign: f64,
    /// |A| in m/rad with its derivative.
    length: f64,
    length_rate: f64,
    meshing_angle: f64,
}

impl Worn {
    /// Curvature in 1/m of the trace's offset by r + w, without the slope and curvature of the relief.
    #[inline]
    fn flank_curvature(&self) -> f64 {
        self.sign * self.trace.turning / self.length
    }

    /// Vector from the worn flank point to `p`.
    #[inline]
    fn reach(&self, p: Vec2) -> Vec2 {
        let off = p - self.trace.c;
        off + self.depth_below_trace * self.trace.normal()
    }

    /// Curvature in 1/m, positive where concave.
    #[inline]
    fn curvature(&self) -> f64 {
        let Worn { length, length_rate, depth_rate, depth_bend, .. } = self;
        let turning = self.trace.turning;
        let bends =
            length * (length * turning - depth_bend) + depth_rate * (length_rate + depth_rate * turning);
        let square = length * length + depth_rate * depth_rate;
        bends / (square * square.sqrt())
    }
}

/// Derivatives of the distance between a pin centre and the worn flank at one position.
struct Station {
    /// Half derivative of the squared distance along the flank, over the distance: zero at the closest point;
    /// in m per m.
    slope: f64,
    /// Its derivative with respect to τ in 1/rad.
    slope_by_tau: f64,
    /// As in [`Worn`].
    flank_curvature: f64,
    length: f64,
}

impl Station {
    /// The step of Newton's method in rad of τ.
    #[inline]
    fn step(&self, pin_radius: f64) -> f64 {
        // A quarter of the unworn relative curvature is the lower limit, so that the step remains finite in
        // hollows.
        let unworn = 1.0 / pin_radius - self.flank_curvature;
        -self.slope / self.slope_by_tau.min(-0.25 * unworn * self.length)
    }

    #[inline]
    fn new(p: Vec2, worn: &Worn) -> Station {
        let Worn { depth_below_trace, depth_rate, depth_bend, length, length_rate, .. } = *worn;
        let Trace { c, tangent, speed, turning, .. } = worn.trace;
        let normal = worn.trace.normal();
        let off = p - c;
        let per_length = 1.0 / length;
        let height = off.dot(&normal) + depth_below_trace;
        let per_height = 1.0 / height;
        let along = off.dot(&tangent);
        let depth_slope = depth_rate * per_length;
        let slope = along * per_height - depth_slope;
        // The tangent turns towards the normal by κ0 |c′| per radian of τ, the normal against the tangent by
        // the same angle.
        let along_rate = turning * (height - depth_below_trace) - speed;
        let height_rate = depth_rate - turning * along;
        let slope_by_tau = (along_rate - along * per_height * height_rate) * per_height
            - (depth_bend - depth_slope * length_rate) * per_length;
        Station { slope, slope_by_tau, flank_curvature: worn.flank_curvature(), length }
    }
}

#[cfg(test)]
mod tests;
