//! One pin against one disc.

use crate::geometry::{Vec2, cross, quarter_turn};

/// State of one pin's contact. Vectors are in the housing frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PinContact {
    /// Index of the pin, 0…z_p−1.
    pub pin: usize,
    /// Parameter τ of the foot on the trace in rad.
    pub tau: f64,
    /// Meshing angle of the point of closest approach in rad, (−π, π]; positive angles push the disc
    /// clockwise.
    pub meshing_angle: f64,
    /// Gap in m; negative is penetration (elastic approach).
    pub gap: f64,
    /// Rate of approach in m/s.
    pub approach_rate: f64,
    /// Normal force in N.
    pub force: f64,
    /// ∂F/∂δ in N/m.
    pub stiffness: f64,
    /// ∂F/∂δ̇ in N·s/m.
    pub damping: f64,
    /// Elastic part of the normal force in N.
    pub elastic: f64,
    /// Elastic energy in J.
    pub stored: f64,
    /// Speed in m/s at which the disc slides on the pin, along the normal turned by +90°.
    pub sliding_speed: f64,
    /// Friction force in N on the disc along the same direction.
    pub friction: f64,
    /// Outward normal of the flank (from disc to pin).
    pub normal: Vec2,
    /// Pin centre relative to the disc centre in m; the line of action passes through it.
    pub arm: Vec2,
    /// Curvature of the (worn) flank in 1/m, positive where concave.
    pub flank_curvature: f64,
    /// Relative curvature 1/R_eq in 1/m, worn flank included.
    pub relative_curvature: f64,
    /// Relative curvature of the flank as designed in 1/m, from which the contact law takes R_eq.
    pub designed_curvature: f64,
    /// ∂(gap)/∂(x, y, θ) of the disc.
    pub gradient: [f64; 3],
    /// d²w/dψ² in m/rad² of the wear depth of the pin at the contact.
    pub(super) pin_bend: f64,
    /// ∂ψ/∂(x, y, θ) there in rad/m and rad/rad.
    pub(super) pin_turn: [f64; 3],
    /// Displacement of the disc's point of contact along the flank, per (x, y, θ).
    pub along: [f64; 3],
    /// e(φ) and e(τ) of the foot on the trace, and the normal there.
    pub(super) meshing_unit: Vec2,
    pub(super) direction: Vec2,
    pub(super) foot_normal: Vec2,
    /// Distance of the pin centre from the trace there in m, and the curvature of the trace in 1/m.
    pub(super) foot_distance: f64,
    pub(super) trace_curvature: f64,
    /// First two derivatives of τ with respect to the foot: 1 and 0, except near the end of a flank
    /// ([`Profile::contact_place`](crate::geometry::Profile)); both are 0 for pins at the corner or the land of a tip.
    pub(super) place_by_foot: [f64; 2],
    /// Contribution of errors of the flank and of the worn pin to the gap, in m.
    pub(super) read: f64,
}

/// Lower bound of 1 − κ D, which tends to zero where the pin centre approaches the centre of curvature of the flank.
const LEAST_REACH: f64 = 1e-4;

impl PinContact {
    /// Mean of two slices of one contact; position and geometry are those of `self`.
    pub fn mean(&self, other: &PinContact) -> PinContact {
        let mean = |of: fn(&PinContact) -> f64| 0.5 * (of(self) + of(other));
        PinContact {
            gap: mean(|slice| slice.gap),
            approach_rate: mean(|slice| slice.approach_rate),
            force: mean(|slice| slice.force),
            stiffness: mean(|slice| slice.stiffness),
            damping: mean(|slice| slice.damping),
            elastic: mean(|slice| slice.elastic),
            stored: mean(|slice| slice.stored),
            friction: mean(|slice| slice.friction),
            ..*self
        }
    }

    /// ∂²(gap)/∂(x, y, θ)²: −κ/(1 − κ D) T Tᵀ, with D the distance of the pin centre from the flank and T = (t_x,
    /// t_y, t·(k × arm)) its motion along the flank, plus the terms of the turning arm. For a worn pin, d²w/dψ² times
    /// the square of the gradient of ψ is added.
    #[inline]
    pub(crate) fn gap_hessian(&self, pin_radius: f64) -> [[f64; 3]; 3] {
        let (n, arm) = (self.normal, self.arm);
        let t = quarter_turn(n);
        let along = [t.x, t.y, t.dot(&quarter_turn(arm))];
        let turning = self.turning(pin_radius);
        let mut hessian = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                hessian[i][j] = turning * along[i] * along[j];
            }
        }
        if self.pin_bend != 0.0 {
            for i in 0..3 {
                for j in 0..3 {
                    hessian[i][j] += self.pin_bend * self.pin_turn[i] * self.pin_turn[j];
                }
            }
        }
        hessian[0][2] += n.y;
        hessian[2][0] += n.y;
        hessian[1][2] -= n.x;
        hessian[2][1] -= n.x;
        hessian[2][2] -= n.dot(&arm);
        hessian
    }

    /// −κ/(1 − κ D) in 1/m: rotation of the normal per displacement of the pin centre along the flank.
    #[inline]
    fn turning(&self, pin_radius: f64) -> f64 {
        let reach = 1.0 - self.flank_curvature * (self.gap - self.read + pin_radius);
        -self.flank_curvature / reach.max(LEAST_REACH)
    }

    /// jᵀ ∂²(gap)/∂q² j in m/rad² for a motion j = (j_x, j_y, 1) of the disc.
    #[inline]
    pub(crate) fn gap_bend(&self, pin_radius: f64, motion: Vec2) -> f64 {
        let n = self.normal;
        let along = self.along[0] * motion.x + self.along[1] * motion.y + self.along[2] + pin_radius;
        let turning = self.turning(pin_radius);
        let pin_turn = self.pin_turn[0] * motion.x + self.pin_turn[1] * motion.y + self.pin_turn[2];
        turning * along * along + 2.0 * cross(motion, n) - n.dot(&self.arm)
            + self.pin_bend * pin_turn * pin_turn
    }
}
