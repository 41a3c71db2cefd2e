//! Tips of lobes: ends of the flank, and pins beyond them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::closest::Closest;
use super::foot::{Place, small_unit};
use super::{Foot, Profile, Relief, Vec2, cross, quarter_turn, turned, unit};
use crate::units::wrap_angle;

/// The tip of a lobe, turned down to a circle.
///
/// The flank is usable from its root to its corner with the tip circle; the land of the lobe extends from
/// corner to corner. With a tooth difference above 1 the flanks of neighbouring tooth spaces meet in the middle
/// of the lobe, and the tip circle lies below that point. The corners are those of the flank as cut; their
/// displacement by relief and wear, which is of the size of the depth, is neglected.
#[derive(Debug, Clone, PartialEq)]
pub struct Tip {
    /// Meshing angle of the corner in rad, and its cosine.
    pub end: f64,
    pub(super) cos_end: f64,
    /// Radius of the tip circle in m.
    pub radius: f64,
    /// Angle of the corner on the disc from the nearest root, in rad.
    pub corner: f64,
    /// Radius in m at which the flanks of neighbouring spaces meet.
    pub meeting: f64,
    /// From the root: directions of pin and eccentric at the end, and the position of the corner in m.
    at_end: [Vec2; 3],
}

/// Reasons why a disc cannot have the given tip.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TipError {
    /// The tip lies outside of the point where neighbouring flanks meet.
    #[error("the flanks of neighbouring spaces meet at a radius of {} mm", .meeting * 1e3)]
    Beyond {
        /// Radius of that point, m.
        meeting: f64,
    },
    /// The tip lies inside of the roots.
    #[error("the roots have a radius of {} mm", .root * 1e3)]
    BelowRoot {
        /// Radius of the roots, m.
        root: f64,
    },
}

/// Default tip circle: below the point where the flanks meet by this fraction of the eccentricity.
const DEFAULT_TIP_CUT: f64 = 0.1;
/// Tolerance of cos φ at the end of a flank, for rounding.
const SAME: f64 = 1e-9;
/// Number of points in the search for the end, and of bisections that refine it.
const PLACES: usize = 1440;
const HALVINGS: usize = 60;
/// A corner has this curvature in 1/m in place of an infinite one.
const CORNER_CURVATURE: f64 = 1e7;
/// Length of flank before its end, in rad of φ, over which the derivative of [`Profile::contact_place`] decreases from 1 to 0:
/// 0.01 to 0.02 mm on discs of 50 to 100 mm, at most the half-width of a loaded contact.
const STOP: f64 = 0.01;
/// Range before the end of the flank in which the closest point of a worn flank may lie beyond the end, in rad
/// of φ.
const BESIDE: f64 = 0.35;

impl Tip {
    /// Whether a meshing angle with this cosine lies on the flank.
    #[inline]
    pub(super) fn is_usable(&self, cos_meshing_angle: f64) -> bool {
        cos_meshing_angle > self.cos_end - SAME
    }

    /// Width (m) of the land of a lobe from corner to corner, on a disc with this number of lobes.
    pub fn land(&self, lobe_count: usize) -> f64 {
        2.0 * self.radius * (PI / lobe_count as f64 - self.corner)
    }

    /// Length of the land per radian of meshing angle, m/rad; on the land the meshing angle continues to 180°.
    pub(super) fn land_per_meshing_angle(&self, lobe_count: usize) -> f64 {
        0.5 * self.land(lobe_count) / (PI - self.end)
    }
}

impl Profile {
    /// The flank with a tooth difference and a tip circle of the given radius (m). By default the circle lies a
    /// tenth of the eccentricity below the point where the flanks meet; with a tooth difference of 1 the
    /// default is a flank without a tip circle, which is smooth over the tip.
    ///
    /// # Errors
    /// [`TipError`] if the circle does not cross the flank.
    pub fn with_teeth(self, tooth_difference: usize, tip_radius: Option<f64>) -> Result<Profile, TipError> {
        let bare = Profile { tooth_difference, tip: None, ..self };
        if tooth_difference == 1 && tip_radius.is_none() {
            return Ok(bare);
        }
        let half_pitch = PI / bare.lobe_count() as f64;
        let point = |phi: f64| bare.cut_point(phi / bare.lobe_count() as f64);
        let angle = |phi: f64| {
            let point = point(phi);
            point.y.atan2(point.x)
        };
        let last = PI * (1.0 - 1e-9);
        let crossing = first_rise(|phi| angle(phi) - half_pitch, last).unwrap_or(last);
        let meeting = point(crossing).norm();
        let radius = tip_radius.unwrap_or(meeting - DEFAULT_TIP_CUT * bare.eccentricity);
        if radius >= meeting {
            return Err(TipError::Beyond { meeting });
        }
        let root = bare.root_radius();
        let end = first_rise(|phi| point(phi).norm() - radius, crossing);
        let end = end.filter(|_| radius > root).ok_or(TipError::BelowRoot { root })?;
        let (offset, corner) = (end / bare.lobe_count() as f64, angle(end));
        let [m, z] = bare.turns();
        let at_end = [unit(m * offset), unit(z * offset), radius * unit(corner)];
        let tip = Tip { end, cos_end: end.cos(), radius, corner, meeting, at_end };
        Ok(Profile { tip: Some(tip), ..bare })
    }

    /// The same teeth as those of another flank, as cut by these pins.
    pub fn with_pins(&self, pin_circle_radius: f64, pin_radius: f64) -> Profile {
        let bare = Profile { pin_circle_radius, pin_radius, tip: None, ..self.clone() };
        let radius = self.tip.as_ref().map(|tip| tip.radius);
        // Where the other flank does not reach the tip circle, it ends at the point where its own two sides
        // meet.
        bare.clone()
            .with_teeth(self.tooth_difference, radius)
            .unwrap_or_else(|_| bare.clone().with_teeth(self.tooth_difference, None).unwrap_or(bare))
    }

    /// End of the flank; `None` if the flank is smooth over the tip.
    pub fn tip(&self) -> Option<&Tip> {
        self.tip.as_ref()
    }

    /// Largest meshing angle of the flank in rad: 180° if it is smooth over the tip.
    #[inline]
    pub fn last_meshing_angle(&self) -> f64 {
        self.tip.as_ref().map_or(PI, |tip| tip.end)
    }

    /// Its cosine.
    #[inline]
    pub(crate) fn last_cosine(&self) -> f64 {
        self.tip.as_ref().map_or(-1.0, |tip| tip.cos_end)
    }

    /// Whether the flank reaches to a meshing angle with this cosine.
    #[inline]
    pub fn is_usable(&self, cos_meshing_angle: f64) -> bool {
        self.tip.as_ref().is_none_or(|tip| tip.is_usable(cos_meshing_angle))
    }

    /// Ratio of the largest force for equal springs all along the flank up to its end to that for springs up to
    /// 180°: (l_end/l_max) (π/2)/∫ sin²φ/S² dφ, where l_end is the largest lever arm of the flank.
    ///
    /// ∫ sin²φ/S² dφ from 0 to φ is sin φ/(2 K) + (1 + K²) φ/(4 K²) − (1 − K²)/(2 K²) atan((1 + K)/(1 − K) tan(φ/2)), π/2
    /// up to 180°.
    pub fn crowding(&self) -> f64 {
        let Some(tip) = &self.tip else { return 1.0 };
        let k = self.short_width_coefficient();
        let longest =
            if tip.cos_end > k { (self.lever_arm(tip.end) / self.largest_lever_arm()).abs() } else { 1.0 };
        let turn = ((1.0 + k) / (1.0 - k) * (0.5 * tip.end).tan()).atan();
        let integral = tip.end.sin() / (2.0 * k) + (1.0 + k * k) * tip.end / (4.0 * k * k)
            - (1.0 - k * k) * turn / (2.0 * k * k);
        longest * FRAC_PI_2 / integral
    }

    /// Position τ (rad) at which a contact with this foot is evaluated on an elastic flank, and its first two derivatives with
    /// respect to the foot. At the end of a flank the foot stops at the corner. The force −∂U/∂τ ∇τ would jump there, so that
    /// the derivative decreases linearly to 0 before it.
    pub(crate) fn contact_place(&self, tau: f64) -> [f64; 3] {
        let Some(tip) = &self.tip else { return [tau, 1.0, 0.0] };
        let lobes = self.lobe_count() as f64;
        let offset = tau - self.root_near(tau);
        let over = offset.abs() - (tip.end - STOP) / lobes;
        if over <= 0.0 {
            return [tau, 1.0, 0.0];
        }
        // The derivative falls from 1 to 0 over the length.
        let length = STOP / lobes;
        let share = (over / length).min(1.0);
        [
            tau - (0.5 * share * over).copysign(offset),
            1.0 - share,
            if share < 1.0 { -offset.signum() / length } else { 0.0 },
        ]
    }

    /// On the land of a tip: its radius in m and the angle on the disc in rad.
    pub(super) fn on_land(&self, tau: f64) -> Option<(f64, f64)> {
        let tip = self.tip.as_ref()?;
        let root = self.root_near(tau);
        let offset = tau - root;
        let phi = offset.abs() * self.lobe_count() as f64;
        if tip.is_usable(phi.cos()) {
            return None;
        }
        let share = (phi - tip.end) / (PI - tip.end);
        let angle = tip.corner + share * (PI / self.lobe_count() as f64 - tip.corner);
        Some((tip.radius, root + angle.copysign(offset)))
    }

    /// Parameters τ of `count` (4 at least) points on one lobe, from the root at 0 to the next: equidistant
    /// over the lobe, or over both flanks with their corners, between which the edge is nearly straight.
    pub fn around_lobe(&self, count: usize) -> Vec<f64> {
        let pitch = TAU / self.lobe_count() as f64;
        let Some(tip) = &self.tip else {
            let step = pitch / count as f64;
            return (0..count).map(|i| step * i as f64).collect();
        };
        let (end, rising) = (tip.end / self.lobe_count() as f64, count / 2);
        let falling = count - rising;
        let up = (0..rising).map(|i| end * i as f64 / (rising - 1) as f64);
        up.chain((0..falling).map(|i| pitch - end * (falling - i) as f64 / falling as f64)).collect()
    }

    /// Whether τ lies on the land of a tip.
    pub fn is_on_land(&self, tau: f64) -> bool {
        self.on_land(tau).is_some()
    }

    /// Foot of a pin on the half lobe of its nearest root, or at the corner or the land of its tip. `near` is
    /// the approximate direction of the position on the trace; it changes results by rounding only.
    pub(super) fn foot_below_tip(&self, p: Vec2, tip: &Tip, near: f64) -> Foot {
        let root = self.root_near(p.y.atan2(p.x));
        let axis = unit(root);
        let [m, z] = self.turns();
        let shared = self.tooth_difference == 1;
        let root_place = Place { tau: root, e: axis, ez: axis, shared };
        let across = p.dot(&quarter_turn(axis));
        if across == 0.0 {
            return self.foot_at(p, root_place);
        }
        let side = 1.0_f64.copysign(across);
        let offset = tip.end / self.lobe_count() as f64;
        let end = self.end_beside(root, axis, side, tip);
        if side * self.slope_of_distance(p, end) > 0.0 {
            let (off, curvature) = self.off_tip(p, axis, side, tip);
            return Foot {
                distance: off.norm() - self.pin_radius,
                normal: off.normalize(),
                trace_curvature: curvature,
                at_tip: true,
                ..self.foot_at(p, end)
            };
        }
        let at = |offset: f64| Place {
            tau: root + side * offset,
            e: turned(axis, unit(side * m * offset)),
            ez: turned(axis, unit(side * z * offset)),
            shared,
        };
        let ends = if side > 0.0 { [root, end.tau] } else { [end.tau, root] };
        // For a pin in its nominal position the foot has the direction of the pin. If that direction is outside
        // of the half lobe, the direction of the actual pin position is the first guess.
        let nominal = side * wrap_angle(near - root) / m;
        let guess = match nominal > 0.0 && nominal < offset {
            true => nominal,
            false => (across.atan2(p.dot(&axis)) * side / m).clamp(0.02 * offset, 0.98 * offset),
        };
        self.enclosed_foot(p, at(guess), ends)
    }

    /// The end of the flank on one side of a root.
    fn end_beside(&self, root: f64, axis: Vec2, side: f64, tip: &Tip) -> Place {
        let on = |direction: Vec2| turned(axis, Vec2::new(direction.x, side * direction.y));
        let [e, ez, _] = tip.at_end;
        let shared = self.tooth_difference == 1;
        Place { tau: root + side * tip.end / self.lobe_count() as f64, e: on(e), ez: on(ez), shared }
    }

    /// Vector (m) from the corner on one side of a root, or from the land beyond it, to a pin beyond the end of the flank, and
    /// the curvature (1/m) of the path of a pin that rolls around it.
    fn off_tip(&self, p: Vec2, axis: Vec2, side: f64, tip: &Tip) -> (Vec2, f64) {
        let [.., corner] = tip.at_end;
        let corner = turned(axis, Vec2::new(corner.x, side * corner.y));
        match is_farther(p, corner, axis) {
            true => (p - tip.radius * p.normalize(), -1.0 / (tip.radius + self.pin_radius)),
            false => (p - corner, -1.0 / self.pin_radius),
        }
    }

    /// Lower bound (m) of the distance of a pin at `p` from a flank with a tip, as [`Profile::least_distances`]
    /// for other flanks; e(`near`) is the direction of its nominal position. Beyond the end of the flank it is
    /// the distance from the corner or the land less the pin radius. Otherwise it is the height above the trace
    /// at e(`near`), less twice the effect of the curvature over the distance along the trace; −∞ where this
    /// distance is not short compared with the radius of curvature.
    pub(crate) fn least_distance_below_tip(&self, p: Vec2, tip: &Tip, near: f64, e: Vec2) -> f64 {
        let root = self.root_near(near);
        let axis = turned(e, small_unit(root - near));
        let side = 1.0_f64.copysign(cross(axis, p));
        let end = self.end_beside(root, axis, side, tip);
        let (c, c1, _) = self.trace_derivatives(end.e, end.ez);
        if side * (p - c).dot(&c1) > 0.0 {
            return self.off_tip(p, axis, side, tip).0.norm() - self.pin_radius;
        }
        let ez = turned(axis, unit(self.pins_per_turn() * (near - root)));
        let (c, c1, c2) = self.trace_derivatives(e, ez);
        let (off, per_speed) = (p - c, 1.0 / c1.norm());
        let (height, along) = (cross(off, c1) * per_speed, off.dot(&c1) * per_speed);
        let curvature = cross(c1, c2).abs() * per_speed.powi(3);
        let steady = curvature * (height.abs() + along.abs()) < 0.3;
        if steady { height - 2.0 * curvature * along * along } else { f64::NEG_INFINITY }
    }

    /// The closest point of a worn flank near its end: on the last part of the flank, at its corner, or on the
    /// land. `None` if the foot is farther from the end.
    pub(super) fn closest_at_tip(
        &self,
        p: Vec2,
        foot: &Foot,
        tip: &Tip,
        relief: &Relief,
        pin_radius: f64,
    ) -> Option<Closest> {
        let lobes = self.lobe_count() as f64;
        let root = self.root_near(foot.tau);
        let offset = foot.tau - root;
        if tip.end - offset.abs() * lobes > BESIDE {
            return None;
        }
        let side = 1.0_f64.copysign(offset);
        let end = foot.place.moved(root + side * tip.end / lobes - foot.tau, self.turns());
        let (slope, corner) = self.worn_end(p, end, relief);
        if side * slope <= 0.0 {
            let ends = if side > 0.0 { [f64::NAN, end.tau] } else { [end.tau, f64::NAN] };
            return Some(self.closest_between(p, ends, foot.place, relief, pin_radius));
        }
        // The land is lowered by the wear depth at the corner of this side.
        let (gap, normal, flank_curvature) = match is_farther(p, corner, unit(root)) {
            true => (p.norm() - corner.norm(), p.normalize(), -1.0 / corner.norm()),
            false => ((p - corner).norm(), (p - corner).normalize(), -CORNER_CURVATURE),
        };
        Some(Closest {
            tau: end.tau,
            meshing_angle: -side * tip.end,
            gap: gap - pin_radius,
            normal,
            flank_curvature,
            relative_curvature: self.relative_curvature(tip.cos_end, pin_radius),
        })
    }

    /// Point of contact of a pin whose foot is beyond the end of an evenly worn flank: the corner, displaced by
    /// the depth along the flank normal, or the land.
    pub(crate) fn closest_to_end(
        &self,
        p: Vec2,
        foot: &Foot,
        relief: &Relief,
        pin_radius: f64,
    ) -> Option<Closest> {
        let tip = self.tip.as_ref().filter(|_| foot.at_tip)?;
        self.closest_at_tip(p, foot, tip, relief, pin_radius)
    }
}

/// Whether a point has a larger angle from its root than the corner, on either side.
fn is_farther(p: Vec2, corner: Vec2, axis: Vec2) -> bool {
    let seen = |place: Vec2| Vec2::new(place.dot(&axis), cross(axis, place).abs());
    cross(seen(corner), seen(p)) > 0.0
}

/// The smallest angle between 0 and `last` at which a function rises from negative values to 0.
fn first_rise(of: impl Fn(f64) -> f64, last: f64) -> Option<f64> {
    let at = |i: usize| last * i as f64 / PLACES as f64;
    let above = (1..=PLACES).find(|i| of(at(*i)) >= 0.0)?;
    let (mut low, mut high) = (at(above - 1), at(above));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if of(middle) < 0.0 { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests;
