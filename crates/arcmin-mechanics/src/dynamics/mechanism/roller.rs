use std::f64::consts::{PI, TAU};

use super::rim::{OutOfRound, RIM};
use crate::contact::{ContactSpring, Pressed, slice_height};
use crate::geometry::{Vec2, turned, unit};
use crate::machine::{RollerBearing, RollerKind};

/// Row of rolling elements between two rings: Q = K δ^n for each element, summed over the elements at their
/// angles.
///
/// At the angle ψ the radial approach of inner and outer ring is u_r = (u + h σ)·e(ψ) − c/2 − w(ψ), the axial
/// one a = s (z − R σ·e(ψ)) + p, relative to first contact, for a displacement u, z (m) and a slope σ of the
/// inner relative to the outer ring, diametral clearance c, deviation w of the raceway from a circle, height h
/// of the row above the origin, pitch radius R, axial preload p, and s = ±1 the direction of its contacts, 0 if
/// the ring is axially free.
///
/// Rollers have a constant contact angle α: δ = u_r cos α + a sin α; n = 10/9, K = 3.73e4 l^(8/9) in N and mm,
/// inner and outer raceway in series (Harris, Rolling Bearing Analysis). If the rings are tilted, the approach
/// varies along the roller: δ + t σ·e(ψ) at the coordinate t along the roller; the force is the mean of two
/// slices. Balls: n = 3/2, K of two point contacts in series (Hamrock and Dowson's approximation). Axially
/// loaded balls run in grooves whose centres are A = (f_i + f_o − 1) d apart at the contact angle α (Jones
/// 1960; Harris, ch. 7): δ = √((A sin α + a)² + (A cos α + u_r)²) − A, and the contact angle changes with the
/// load; for other balls it is constant.
///
/// The cage rotates with both rings, ψ = w θ_inner + (1 − w) θ_outer with w = (1 − d cos α/D)/2. Forces and
/// torques are derivatives of the energy Σ K δ^(n+1)/(n + 1).
///
/// Not modelled: roller crowning, centrifugal force and gyroscopic moment.
#[derive(Debug, Clone, PartialEq)]
pub struct RollingBearing {
    pub(in crate::dynamics) count: usize,
    /// K in N/m^n.
    pub(in crate::dynamics) stiffness: f64,
    pub(in crate::dynamics) exponent: f64,
    pub(in crate::dynamics) half_clearance: f64,
    /// Half the diametral clearance of the drawing, m.
    pub(in crate::dynamics) drawn_half_clearance: f64,
    /// Cosine and sine of the contact angle.
    pub(in crate::dynamics) contact: Vec2,
    /// A in m; `None` if the contact angle is constant.
    groove_distance: Option<f64>,
    /// w: weight of the inner ring in the rotation of the cage.
    pub(in crate::dynamics) inner_share: f64,
    /// R in m, at which friction acts.
    pub(in crate::dynamics) pitch_radius: f64,
    /// Distance in m from the middle of a roller to the two slices that represent its length: t = l/√12 for an
    /// axially loaded ring, times cos α for an axially free one; 0 for a ball.
    pub(in crate::dynamics) reach: f64,
    height: f64,
    facing: f64,
    pub(in crate::dynamics) preload: f64,
}

/// Variables of a bearing: displacement of the inner ring (x, y), angle of the cage, slope of the inner
/// relative to the outer ring (x, y), axial displacement, angle of the rim's body, coordinates of the rim's
/// ovalisation. A state with fewer variables has the first of them.
pub(in crate::dynamics) const CAGE: usize = 2;
pub(in crate::dynamics) const SLOPE: usize = 3;
pub(in crate::dynamics) const AXIAL: usize = 5;
pub(in crate::dynamics) const BODY: usize = 6;
pub(in crate::dynamics) const OVALITY: usize = 7;
/// Number of variables of rings that stay parallel, that tilt, that tilt and move axially, and of all.
pub(in crate::dynamics) const PARALLEL: usize = SLOPE;
pub(in crate::dynamics) const TILT: usize = AXIAL;
pub(in crate::dynamics) const ROW: usize = BODY;
pub(in crate::dynamics) const VARIABLES: usize = OVALITY + RIM;

/// Relative position of the rings of a bearing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(in crate::dynamics) struct RingPose {
    /// Displacement of the inner ring in m.
    pub shift: [f64; 2],
    /// Angle of the cage, rad.
    pub cage: f64,
    /// ∂(shift)/∂z along the axis, if the rings tilt relative to each other.
    pub slope: Option<[f64; 2]>,
    /// Axial displacement of the inner ring in m.
    pub axial: f64,
    /// The outer raceway, if it is not round.
    pub rim: Option<OutOfRound>,
}

/// Elastic energy of one bearing with gradient and Hessian over its first N variables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingState<const N: usize> {
    /// Elastic energy, J.
    pub stored: f64,
    /// Minus the force (N) on the inner ring, the torque (N·m) on the cage, and correspondingly for the other
    /// variables.
    pub gradient: [f64; N],
    /// Second derivatives of the energy by the same variables: the tangent stiffness.
    pub hessian: [[f64; N]; N],
    /// Largest force on one rolling element, normal to the raceway, in N.
    pub largest_element: f64,
    /// Number of loaded rolling elements.
    pub loaded: usize,
}

impl<const N: usize> Default for BearingState<N> {
    fn default() -> Self {
        let (gradient, hessian) = ([0.0; N], [[0.0; N]; N]);
        BearingState { stored: 0.0, gradient, hessian, largest_element: 0.0, loaded: 0 }
    }
}

/// Adds k w wᵀ to the lower half of a matrix.
#[inline]
fn stiffen<const N: usize>(matrix: &mut [[f64; N]; N], k: f64, w: &[f64; N]) {
    for a in 0..N {
        let share = k * w[a];
        for b in 0..=a {
            matrix[a][b] += share * w[b];
        }
    }
}

/// Load of one rolling element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementLoad {
    /// Angular position, rad.
    pub angle: f64,
    /// N, normal to the raceway.
    pub force: f64,
    /// Cosine and sine of its contact angle.
    pub contact: Vec2,
}

/// Ratio of the groove radius of ball bearings to the ball's diameter, for both raceways.
const GROOVE: f64 = 0.52;

/// K of one element between both raceways in N/m^n, and the exponent n.
pub fn element_stiffness(bearing: &RollerBearing) -> (f64, f64) {
    const MM: f64 = 1e3;
    match bearing.kind {
        RollerKind::Cylindrical | RollerKind::Tapered => {
            let exponent = 10.0 / 9.0;
            (3.73e4 * (bearing.roller_length * MM).powf(8.0 / 9.0) * MM.powf(exponent), exponent)
        }
        RollerKind::Ball => (ball_stiffness(bearing), 1.5),
    }
}

/// Two point contacts in series, steel, groove radius 0.52 d: K = π κ E' √(R ℰ/(4.5 𝓕³)) each (Hamrock and
/// Dowson 1981, with their approximations of the ellipticity κ and the elliptic integrals).
fn ball_stiffness(bearing: &RollerBearing) -> f64 {
    const EFFECTIVE: f64 = 2.0 * 206e9 / (2.0 * (1.0 - 0.09));
    let d = bearing.roller_diameter;
    let gamma = d * bearing.contact_angle.cos() / bearing.pitch_diameter;
    let one = |side: f64| {
        let rolling = 0.5 * d * (1.0 - side * gamma);
        let across = GROOVE * d / (2.0 * GROOVE - 1.0);
        let ratio = across / rolling;
        let radius = 1.0 / (1.0 / rolling + 1.0 / across);
        let kappa = 1.0339 * ratio.powf(0.6360);
        let second = 1.0003 + 0.5968 / ratio;
        let first = 1.5277 + 0.6023 * ratio.ln();
        PI * kappa * EFFECTIVE * (radius * second / (4.5 * first.powi(3))).sqrt()
    };
    let (inner, outer) = (one(1.0), one(-1.0));
    (inner.powf(-2.0 / 3.0) + outer.powf(-2.0 / 3.0)).powf(-1.5)
}

/// Positions of the slices that represent a roller, in units of [`RollingBearing::reach`]. Rings without tilt
/// load rollers uniformly along their length; with tilt the law is the mean at two points l/√12 from the middle
/// (Gauss), correct to second order in the tilt.
const WHOLE: &[f64] = &[0.0];
const HALVES: &[f64] = &[-1.0, 1.0];

impl RollingBearing {
    /// A bearing with axially free rings. `scale` multiplies the stiffness; it is 1 for the actual bearing.
    pub fn radial(bearing: &RollerBearing, scale: f64) -> RollingBearing {
        let (stiffness, exponent) = element_stiffness(bearing);
        let contact = unit(bearing.contact_angle);
        RollingBearing {
            count: bearing.roller_count,
            stiffness: scale * stiffness,
            exponent,
            half_clearance: 0.5 * bearing.clearance,
            drawn_half_clearance: 0.5 * bearing.clearance,
            contact,
            groove_distance: None,
            inner_share: 0.5 * (1.0 - bearing.roller_diameter * contact.x / bearing.pitch_diameter),
            pitch_radius: 0.5 * bearing.pitch_diameter,
            reach: match bearing.kind {
                RollerKind::Ball => 0.0,
                RollerKind::Cylindrical | RollerKind::Tapered => {
                    contact.x * slice_height(bearing.roller_length)
                }
            },
            height: 0.0,
            facing: 0.0,
            preload: 0.0,
        }
    }

    /// A row at a height (m) that supports the inner ring axially in the direction `facing` (±1), with the
    /// axial preload approach `preload` (m; negative is clearance), which replaces the diametral clearance.
    pub fn row(row: &RollerBearing, height: f64, facing: f64, preload: f64) -> RollingBearing {
        let groove_distance =
            (row.kind == RollerKind::Ball).then_some((2.0 * GROOVE - 1.0) * row.roller_diameter);
        let facing = facing.signum();
        let radial = RollingBearing::radial(&RollerBearing { clearance: 0.0, ..row.clone() }, 1.0);
        let reach = radial.reach / radial.contact.x;
        RollingBearing { groove_distance, reach, height, facing, preload, ..radial }
    }

    /// Increases the diametral clearance (m), for example because of a bore with a larger diameter.
    pub fn widen(&mut self, clearance: f64) {
        self.half_clearance += 0.5 * clearance;
    }

    /// Radial secant stiffness of one element at an approach of one micrometre, in N/m; it depends on the
    /// approach only slightly.
    pub(in crate::dynamics) fn stiffness_of_an_element(&self) -> f64 {
        self.contact.x.powi(2) * self.exponent * self.stiffness * 1e-6_f64.powf(self.exponent - 1.0)
    }

    /// Force law of one contact of an element: of the whole element, or of one slice if the rings tilt.
    pub(in crate::dynamics) fn spring_at(&self, ring_pose: &RingPose) -> ContactSpring {
        let slices = self.places(ring_pose.slope.is_some()).len();
        ContactSpring::Power { stiffness: self.stiffness / slices as f64, exponent: self.exponent }
    }

    /// Radial stiffness in N/m of a bearing without clearance, with half of its elements loaded.
    pub(in crate::dynamics) fn centring_stiffness(&self) -> f64 {
        0.25 * self.count as f64 * self.stiffness_of_an_element()
    }

    /// Direction e of every rolling element.
    #[inline]
    pub(in crate::dynamics) fn directions(&self, cage: f64) -> impl Iterator<Item = Vec2> + use<> {
        let step = unit(TAU / self.count as f64);
        let mut next = unit(cage);
        (0..self.count).map(move |_| {
            let e = next;
            next = turned(e, step);
            e
        })
    }

    /// δ in the middle of an element for the displacement u·e = `along` of the inner ring, the tilt σ·e and the
    /// axial displacement if there are any, and w = `widened`; its derivatives by u_r and a, which are cosine
    /// and sine of the contact angle, and the curvature 1/s of the distance between the groove centres.
    #[inline]
    fn approach(&self, along: f64, tilting: Option<(f64, f64)>, widened: f64) -> (f64, Vec2, f64) {
        let mut radial = along - self.half_clearance - widened;
        let mut axial = self.preload;
        if let Some((tilt, moved)) = tilting {
            radial += self.height * tilt;
            axial += self.facing * (moved - self.pitch_radius * tilt);
        }
        let Some(apart) = self.groove_distance else {
            return (radial * self.contact.x + axial * self.contact.y, self.contact, 0.0);
        };
        let line = apart * self.contact + Vec2::new(radial, axial);
        let distance = line.norm();
        (distance - apart, line / distance, 1.0 / distance)
    }

    /// Positions along an element (m) that represent its length.
    #[inline]
    fn places(&self, tilts: bool) -> &'static [f64] {
        if tilts && self.reach > 0.0 { HALVES } else { WHOLE }
    }

    /// Force (N) of one of `slices` slices of an element, and its derivative (N/m).
    #[inline]
    fn press(&self, approach: f64, slices: usize) -> (f64, f64) {
        let force = self.stiffness / slices as f64 * approach.powf(self.exponent);
        (force, self.exponent * force / approach)
    }

    /// The state for a relative position over the first N variables, which must include all of its own. The
    /// Hessian is zero if no tangents are required.
    pub(in crate::dynamics) fn react_at<const N: usize>(
        &self,
        ring_pose: &RingPose,
        tangents: bool,
    ) -> BearingState<N> {
        let (mut state, along_gaps) = self.react_within(ring_pose, tangents, 0.0, |_, _, _| ());
        let entries = state.hessian.as_flattened_mut().iter_mut().zip(along_gaps.as_flattened());
        entries.for_each(|(entry, along)| *entry += along);
        state
    }

    /// As [`RollingBearing::react_at`]. Calls `visit` for every element, or slice of one, that is loaded or has a
    /// gap below `reach` (m), with its approach in m, the gradient of that, and its force law. The contact
    /// stiffness along these approaches is not in the Hessian of the state but in the second matrix.
    #[inline]
    pub(in crate::dynamics) fn react_within<const N: usize>(
        &self,
        ring_pose: &RingPose,
        tangents: bool,
        reach: f64,
        mut visit: impl FnMut(f64, &[f64; N], Pressed),
    ) -> (BearingState<N>, [[f64; N]; N]) {
        assert!(N > SLOPE || ring_pose.slope.is_none(), "variables of the slope");
        assert!(N > BODY || ring_pose.rim.is_none(), "variables of the rim");
        let (mut state, mut along_gaps) = (BearingState::default(), [[0.0; N]; N]);
        let (u, slope) = (ring_pose.shift, ring_pose.slope.unwrap_or_default());
        let rim = ring_pose.rim.unwrap_or_default();
        let on_body = if N > BODY { unit(-rim.angle) } else { Vec2::zeros() };
        let places = if N > SLOPE { self.places(ring_pose.slope.is_some()) } else { WHOLE };
        for e in self.directions(ring_pose.cage) {
            let along = u[0] * e.x + u[1] * e.y;
            let tilt = if N > SLOPE { slope[0] * e.x + slope[1] * e.y } else { 0.0 };
            let tilting = (N > SLOPE).then_some((tilt, ring_pose.axial));
            let farthest = if N > SLOPE { self.reach * tilt.abs() } else { 0.0 };
            let [shape, bend, curve] =
                if N > BODY { OutOfRound::shapes(turned(e, on_body)) } else { [[0.0; RIM]; 3] };
            let along_rim = |by: &[f64; RIM]| if N > BODY { rim.sum(by) } else { 0.0 };
            let (middle, contact, curvature) = self.approach(along, tilting, along_rim(&shape));
            if !(middle + farthest > -reach) {
                continue;
            }
            let (turn_of_rim, curve_of_rim) = (along_rim(&bend), along_rim(&curve));
            let across = u[1] * e.x - u[0] * e.y;
            let turn_of_tilt = if N > SLOPE { slope[1] * e.x - slope[0] * e.y } else { 0.0 };
            // Lever arm of the slope at the middle of the element, for a contact in the direction `by`.
            let arm = |by: Vec2| by.x * self.height - by.y * self.facing * self.pitch_radius;
            // Gradient of `by` · (u_r, a) + `place` σ·e.
            let gradient_of = |by: Vec2, place: f64| {
                let arm = arm(by) + place;
                let mut gradient = [0.0; N];
                (gradient[0], gradient[1]) = (by.x * e.x, by.x * e.y);
                gradient[CAGE] = by.x * (across - turn_of_rim) + arm * turn_of_tilt;
                if N > SLOPE {
                    (gradient[SLOPE], gradient[SLOPE + 1]) = (arm * e.x, arm * e.y);
                }
                if N > AXIAL {
                    gradient[AXIAL] = by.y * self.facing;
                }
                if N > BODY {
                    gradient[BODY] = by.x * turn_of_rim;
                    (0..RIM).for_each(|r| gradient[OVALITY + r] = -by.x * shape[r]);
                }
                gradient
            };
            let (mut element, mut couple) = (0.0, 0.0);
            for place in places.iter().map(|side| side * self.reach) {
                let approach = middle + place * tilt;
                if !(approach > -reach) {
                    continue;
                }
                let gradient = gradient_of(contact, place);
                if !(approach > 0.0) {
                    visit(approach, &gradient, Pressed::default());
                    continue;
                }
                let (force, stiffness) = self.press(approach, places.len());
                visit(approach, &gradient, Pressed { force, stiffness });
                (0..N).for_each(|a| state.gradient[a] += force * gradient[a]);
                if tangents {
                    stiffen(&mut along_gaps, stiffness, &gradient);
                }
                element += force;
                couple += force * place;
                state.stored += force * approach / (self.exponent + 1.0);
            }
            state.largest_element = state.largest_element.max(element);
            state.loaded += usize::from(element > 0.0);
            if !(tangents && element > 0.0) {
                continue;
            }
            if curvature > 0.0 {
                let across = gradient_of(Vec2::new(contact.y, -contact.x), 0.0);
                stiffen(&mut state.hessian, element * curvature, &across);
            }
            // Contribution of a rotation of the element to its force on ring and rim, and to its couple on the
            // slope.
            let (whole, couple) = (element * contact.x, couple + element * arm(contact));
            let into = &mut state.hessian;
            into[CAGE][0] -= whole * e.y;
            into[CAGE][1] += whole * e.x;
            into[CAGE][CAGE] -= whole * (along + curve_of_rim) + couple * tilt;
            if N > SLOPE {
                into[SLOPE][CAGE] -= couple * e.y;
                into[SLOPE + 1][CAGE] += couple * e.x;
            }
            if N > BODY {
                into[BODY][CAGE] += whole * curve_of_rim;
                into[BODY][BODY] -= whole * curve_of_rim;
                for r in 0..RIM {
                    into[OVALITY + r][CAGE] -= whole * bend[r];
                    into[OVALITY + r][BODY] += whole * bend[r];
                }
            }
        }
        for matrix in [&mut state.hessian, &mut along_gaps] {
            for a in 0..N {
                (0..a).for_each(|b| matrix[b][a] = matrix[a][b]);
            }
        }
        (state, along_gaps)
    }

    /// Loads of all elements.
    pub(in crate::dynamics) fn loads(&self, ring_pose: RingPose) -> impl Iterator<Item = ElementLoad> + '_ {
        let places = self.places(ring_pose.slope.is_some());
        let (u, slope) = (ring_pose.shift, ring_pose.slope.unwrap_or_default());
        self.directions(ring_pose.cage).enumerate().map(move |(i, e)| {
            let angle = ring_pose.cage + TAU * i as f64 / self.count as f64;
            let widened = ring_pose.rim.map_or(0.0, |rim| rim.at(angle));
            let (along, tilt) = (u[0] * e.x + u[1] * e.y, slope[0] * e.x + slope[1] * e.y);
            let (middle, contact, _) = self.approach(along, Some((tilt, ring_pose.axial)), widened);
            let approaches = places.iter().map(|side| middle + side * self.reach * tilt);
            let pressed = approaches.filter(|approach| *approach > 0.0);
            ElementLoad { angle, force: pressed.map(|at| self.press(at, places.len()).0).sum(), contact }
        })
    }
}

#[cfg(test)]
mod tests;
