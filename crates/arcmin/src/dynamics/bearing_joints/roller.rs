use std::f64::consts::{PI, TAU};

use crate::contact::slice_height;
use crate::contact::{ContactSpring, Pressed};
use crate::geometry::{Vec2, turned, unit};
use crate::machine::{RollerBearing, RollerKind};

/// Radial rolling bearing: Q = K δ^n per rolling element, summed over the elements at their angles.
///
/// An element at the angle ψ_i is squeezed by δ_i = cos α (u·e(ψ_i) − c/2) for a displacement u (m) of the
/// inner against the outer ring, diametral clearance c and contact angle α. Rollers and needles: n = 10/9, K
/// = 3.73e4 l^(8/9) in N and mm, inner and outer raceway in series (Harris, Rolling Bearing Analysis). Balls:
/// n = 3/2, K of two point contacts in series (Hamrock and Dowson's approximation). The cage turns with both
/// rings, ψ = w θ_inner + (1 − w) θ_outer with w = (1 − d cos α/D)/2, so forces and torques derive from one
/// energy.
///
/// Rings may lean against each other: rollers are then pressed otherwise at one end than at the other. Balls follow.
///
/// Not modelled: axial load, roller crowning, centrifugal force.
#[derive(Debug, Clone, PartialEq)]
pub struct RadialBearing {
    pub(super) count: usize,
    /// K in N/m^n.
    pub(super) stiffness: f64,
    pub(super) exponent: f64,
    pub(super) half_clearance: f64,
    /// The same as drawn, m.
    pub(super) drawn_half_clearance: f64,
    pub(super) contact_cosine: f64,
    /// w: how far the cage follows the inner ring.
    pub(super) inner_share: f64,
    /// Mean radius in m, on which friction acts.
    pub(super) mean_radius: f64,
    /// Where the two slices of a roller that stand for its length sit from its middle: l/√12 in m, 0 of a ball.
    pub(super) reach: f64,
}

/// Energy of one bearing as a function of (u_x, u_y, ψ), with gradient and Hessian.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BearingState {
    /// J.
    pub stored: f64,
    /// ∂U/∂(u_x, u_y, ψ): minus the force (N) on the inner ring and minus the torque (N·m) on the cage.
    pub gradient: [f64; 3],
    pub hessian: [[f64; 3]; 3],
    /// Largest force on one rolling element, normal to the raceway, in N.
    pub largest_element: f64,
    /// Rolling elements that carry.
    pub loaded: usize,
}

/// K of one element between both raceways in N/m^n, and n.
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
    const GROOVE: f64 = 0.52;
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

/// A rolling element that carries: its approach (m) and force (N) along the line of contact, and both outwards.
struct Loaded {
    approach: f64,
    force: f64,
    radial: Pressed,
}

impl RadialBearing {
    /// `scale` multiplies the stiffness; 1 for the bearing as it is.
    pub fn new(bearing: &RollerBearing, scale: f64) -> RadialBearing {
        let (stiffness, exponent) = element_stiffness(bearing);
        let cosine = bearing.contact_angle.cos();
        RadialBearing {
            count: bearing.roller_count,
            stiffness: scale * stiffness,
            exponent,
            half_clearance: 0.5 * bearing.clearance,
            drawn_half_clearance: 0.5 * bearing.clearance,
            contact_cosine: cosine,
            inner_share: 0.5 * (1.0 - bearing.roller_diameter * cosine / bearing.pitch_diameter),
            mean_radius: 0.5 * bearing.pitch_diameter,
            reach: match bearing.kind {
                RollerKind::Ball => 0.0,
                RollerKind::Cylindrical | RollerKind::Tapered => slice_height(bearing.roller_length),
            },
        }
    }

    /// Adds to the diametral clearance (m), such as a bore that is too large.
    pub fn widen(&mut self, clearance: f64) {
        self.half_clearance += 0.5 * clearance;
    }

    /// State at the displacement u (m) of the inner ring and the cage angle ψ (rad).
    pub fn react(&self, u: [f64; 2], cage: f64) -> BearingState {
        let mut state = BearingState::default();
        for (e, along, across) in self.elements(u, cage) {
            if let Some(Loaded { approach, force, radial: Pressed { force: radial, stiffness: k } }) =
                self.loaded(along)
            {
                let slope = [e.x, e.y, across];
                for i in 0..3 {
                    state.gradient[i] += radial * slope[i];
                    for j in 0..3 {
                        state.hessian[i][j] += k * slope[i] * slope[j];
                    }
                }
                state.hessian[0][2] -= radial * e.y;
                state.hessian[2][0] -= radial * e.y;
                state.hessian[1][2] += radial * e.x;
                state.hessian[2][1] += radial * e.x;
                state.hessian[2][2] -= radial * along;
                state.stored += force * approach / (self.exponent + 1.0);
                state.largest_element = state.largest_element.max(force);
                state.loaded += 1;
            }
        }
        state
    }

    /// Radial stiffness of one element that gives way by a micrometre, in N/m; it hardly depends on that.
    pub(super) fn stiffness_of_an_element(&self) -> f64 {
        let cosine = self.contact_cosine;
        cosine * cosine * self.exponent * self.stiffness * 1e-6_f64.powf(self.exponent - 1.0)
    }

    /// The element that the displacement u moves by u·e = `along` (m); `None` within the clearance.
    fn loaded(&self, along: f64) -> Option<Loaded> {
        let cosine = self.contact_cosine;
        let approach = cosine * (along - self.half_clearance);
        (approach > 0.0).then(|| {
            let force = self.stiffness * approach.powf(self.exponent);
            let stiffness = cosine * cosine * self.exponent * force / approach;
            Loaded { approach, force, radial: Pressed { force: cosine * force, stiffness } }
        })
    }

    /// How a share of an element presses outwards beyond the clearance.
    pub(super) fn element_spring(&self, share: f64) -> ContactSpring {
        let RadialBearing { stiffness, exponent, contact_cosine: cosine, .. } = *self;
        ContactSpring::Power { stiffness: share * stiffness, exponent, cosine }
    }

    /// Radial stiffness in N/m of a bearing without clearance, half of whose elements carry.
    pub(super) fn centring_stiffness(&self) -> f64 {
        0.25 * self.count as f64 * self.stiffness_of_an_element()
    }

    /// Direction e of every rolling element with u·e (m) and u·∂e/∂ψ (m/rad).
    pub(super) fn elements(&self, u: [f64; 2], cage: f64) -> impl Iterator<Item = (Vec2, f64, f64)> + use<> {
        let step = unit(TAU / self.count as f64);
        let mut next = unit(cage);
        (0..self.count).map(move |_| {
            let e = next;
            next = turned(e, step);
            (e, u[0] * e.x + u[1] * e.y, u[1] * e.x - u[0] * e.y)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turning_arm() -> RollerBearing {
        crate::templates::tao2024().bearings.turning_arm
    }

    /// Harris: two raceways of 8.06e4 l^(8/9) each give 3.73e4 l^(8/9) in series.
    #[test]
    fn raceways_in_series() {
        let one: f64 = 8.06e4;
        let series = (2.0 * one.powf(-0.9)).powf(-10.0 / 9.0);
        assert!((series / 3.73e4 - 1.0).abs() < 2e-3, "{series}");
        let (k, n) = element_stiffness(&turning_arm());
        // 10 µm on an 8 mm roller: 3.73e4 * 8^(8/9) * 0.01^(10/9).
        assert!(
            (k * 1e-5f64.powf(n) / (3.73e4 * 8f64.powf(8.0 / 9.0) * 0.01f64.powf(10.0 / 9.0)) - 1.0).abs()
                < 1e-12
        );
    }

    /// The load integral of Sjövall for line contact without clearance, J_r(0.5) = 0.2453 (Harris, table of
    /// load distribution integrals): F_r = Z Q_max J_r.
    #[test]
    fn val_radial_integral_without_clearance() {
        let mut bearing = turning_arm();
        bearing.clearance = 0.0;
        bearing.roller_count = 200;
        let law = RadialBearing::new(&bearing, 1.0);
        let u = 8e-6;
        let state = law.react([u, 0.0], 0.0);
        let largest = law.stiffness * u.powf(law.exponent);
        let integral = state.gradient[0] / (200.0 * largest);
        // Printed to four digits; the exponent 10/9 in place of 1.08–1.11 changes the third.
        assert!((integral - 0.2453).abs() < 2e-3, "{integral}");
        assert_eq!(state.largest_element, largest);
    }

    #[test]
    fn gradient_and_hessian_derive_from_the_energy() {
        let law = RadialBearing::new(&turning_arm(), 1.0);
        let at = |x: [f64; 3]| law.react([x[0], x[1]], x[2]);
        let x = [6.1e-6, -4.3e-6, 0.37];
        let here = at(x);
        let step = [1e-10, 1e-10, 1e-6];
        for i in 0..3 {
            let shifted = |s: f64| {
                let mut y = x;
                y[i] += s * step[i];
                at(y)
            };
            let (up, down) = (shifted(1.0), shifted(-1.0));
            let slope = (up.stored - down.stored) / (2.0 * step[i]);
            assert!(
                (slope - here.gradient[i]).abs() < 1e-6 * here.gradient[0].abs().max(here.gradient[i].abs()),
                "{slope} {:?}",
                here.gradient
            );
            for j in 0..3 {
                let slope = (up.gradient[j] - down.gradient[j]) / (2.0 * step[i]);
                let size = (here.hessian[i][i] * here.hessian[j][j]).abs().sqrt();
                assert!(
                    (slope - here.hessian[i][j]).abs() < 1e-5 * size,
                    "{i} {j} {slope} {:?}",
                    here.hessian
                );
            }
        }
    }

    /// Deep-groove ball bearings of steel: δ = 4.4e-4 (Q²/D)^(1/3) mm for both contacts with N and mm
    /// (Palmgren), so K = 1.08e5 √D N/mm^1.5.
    #[test]
    fn val_ball_stiffness_is_palmgrens() {
        let bearing = RollerBearing {
            kind: RollerKind::Ball,
            roller_count: 9,
            roller_diameter: 10e-3,
            roller_length: 0.0,
            pitch_diameter: 46e-3,
            contact_angle: 0.0,
            clearance: 0.0,
            dynamic_load_rating: None,
        };
        let (k, n) = element_stiffness(&bearing);
        let palmgren = (4.36e-4f64).powf(-1.5) * 10f64.sqrt() * 1e3f64.powf(1.5);
        assert_eq!(n, 1.5);
        // Palmgren's coefficient is a rounded mean over usual osculations.
        assert!((k / palmgren - 1.0).abs() < 0.15, "{}", k / palmgren);
    }
}
