use super::{PinContact, PinContacts};
use crate::geometry::{Vec2, cross, quarter_turn, turned};

/// Change of a contact's position on flank and pin with the motion of the disc: the terms beyond F ∂g/∂q by which
/// forces are the derivative of the stored energy.
///
/// The energy U(δ, R_eq) of a line contact decreases with sharper curvature, the compliance of an elastic disc varies
/// along its flank, and flank errors are evaluated at the contact. All depend on the foot τ on the trace, which moves
/// smoothly even where the closest point of a worn flank does not. A change of position therefore takes or releases
/// work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rolling {
    /// ∂τ/∂(x, y, θ) of the place, in rad/m and rad/rad.
    pub by_pose: [f64; 3],
    /// d(ln R_eq)/dτ.
    pub log_radius_slope: f64,
    /// Derivative of the gap by the slope of the flank error, which ∂(gap)/∂(x, y, θ) does not contain.
    pub gap_slope: [f64; 3],
}

/// Force (N, N, N·m) on the disc from the stored energy in addition to F ∂g/∂q, and Ĝ − ∂g/∂q.
pub(crate) struct EnergyTerms {
    pub force: [f64; 3],
    pub by_place: [f64; 3],
    /// −∂(force)/∂(x, y, θ) at constant contact force.
    pub stiffness: [[f64; 3]; 3],
}

impl Rolling {
    /// Change of the relative curvature 1/R_eq in 1/m for a motion (x, y, θ) of the disc.
    pub(crate) fn relative_curvature_change(&self, contact: &PinContact, motion: [f64; 3]) -> f64 {
        let travel = self.by_pose[0] * motion[0] + self.by_pose[1] * motion[1] + self.by_pose[2] * motion[2];
        -contact.designed_curvature * self.log_radius_slope * travel
    }
}

impl PinContacts {
    /// Depth of the flank's error at a contact, in m.
    pub fn flank_error_depth(&self, contact: &PinContact) -> f64 {
        self.error_reader.as_ref().map_or(0.0, |error| {
            error.depth(contact.tau, contact.direction, self.profile().outward_normal(contact.tau))
        })
    }

    /// Derivatives of the foot's position for `contact`.
    pub fn rolling(&self, contact: &PinContact) -> Rolling {
        let [slope, _] = contact.place_by_foot;
        if slope == 0.0 {
            return Rolling { by_pose: [0.0; 3], log_radius_slope: 0.0, gap_slope: [0.0; 3] };
        }
        let profile = self.profile();
        let PinContact { trace_curvature: curvature, foot_distance, .. } = *contact;
        let factor = profile.speed_factor(contact.meshing_unit.x);
        // The equivalent radius of facets is the pin radius at every position.
        let log_radius_slope = if self.is_faceted() {
            0.0
        } else {
            let rate = profile.designed_curvature_rate(contact.meshing_unit.y, factor, curvature);
            -rate / contact.designed_curvature
        };
        let error_slope = self.error_reader.as_ref().map_or(0.0, |error| {
            let (x, y) = (contact.meshing_unit.x, contact.meshing_unit.y);
            // e(zτ) from e(τ) and e(−φ).
            let ez = turned(contact.direction, Vec2::new(x, -y));
            error.slope_on(contact.tau, contact.direction, ez, profile)
        });
        // The pin centre moves by −T dz past the trace.
        let t = quarter_turn(contact.foot_normal);
        let speed = profile.circle_speed() * factor;
        let travel = 1.0 / (speed * (1.0 - curvature * foot_distance));
        let [x, y, turn] = [-t.x * travel, -t.y * travel, -cross(contact.arm, t) * travel];
        let gap_slope = [error_slope * x, error_slope * y, error_slope * turn];
        let by_pose = [slope * x, slope * y, slope * turn];
        Rolling { by_pose, log_radius_slope, gap_slope }
    }

    /// Terms from the displacement of a loaded contact along its flank.
    ///
    /// With U(δ, R) and δ = −g, Q = −∂U/∂q = F (∇g + e′ ∇τ) − U_R ∇ln R, and dF = −k Ĝ·dq with Ĝ = ∇g + e′ ∇τ −
    /// (∂δ/∂ln R at constant force) ∇ln R; for δ = F (α − β ln F R) U_R = ½ β F², and that derivative is −β F, so that
    /// Ĝ = ∇g + e′ ∇τ − (2 U_R/F) ∇ln R.
    pub(crate) fn energy_terms(&self, contact: &PinContact) -> EnergyTerms {
        let rolling = self.rolling(contact);
        let energy_rate = self.contact().energy_by_log_radius(contact.elastic) * rolling.log_radius_slope;
        let force = std::array::from_fn(|i| {
            contact.elastic * rolling.gap_slope[i] - energy_rate * rolling.by_pose[i]
        });
        let per_force = 2.0 * energy_rate / contact.elastic;
        let by_place = std::array::from_fn(|i| rolling.gap_slope[i] - per_force * rolling.by_pose[i]);
        let stiffness =
            if energy_rate == 0.0 { [[0.0; 3]; 3] } else { self.bend_of_radius(contact, &rolling) };
        EnergyTerms { force, by_place, stiffness }
    }

    /// U_R ∇²ln R with ∇²ln R = (ln R)″ ∇τ ∇τᵀ + (ln R)′ ∇²τ.
    fn bend_of_radius(&self, contact: &PinContact, rolling: &Rolling) -> [[f64; 3]; 3] {
        let energy = self.contact().energy_by_log_radius(contact.elastic);
        let (bend, place) = (self.log_radius_bend(contact, rolling), rolling.by_pose);
        let of_place = self.place_bend(contact, rolling);
        let entry =
            |i: usize, j: usize| bend * place[i] * place[j] + rolling.log_radius_slope * of_place[i][j];
        std::array::from_fn(|i| std::array::from_fn(|j| energy * entry(i, j)))
    }

    /// (ln R_eq)″ by τ.
    pub(crate) fn log_radius_bend(&self, contact: &PinContact, rolling: &Rolling) -> f64 {
        if self.is_faceted() || contact.place_by_foot[0] == 0.0 {
            return 0.0;
        }
        let profile = self.profile();
        let (meshing, curvature) = (contact.meshing_unit, contact.trace_curvature);
        let bend = profile.designed_curvature_bend(meshing, profile.speed_factor(meshing.x), curvature);
        rolling.log_radius_slope.powi(2) - bend / contact.designed_curvature
    }

    /// ∇²τ of the foot over (x, y, θ).
    ///
    /// With the motion w = −dC − dθ J a of the pin centre against the disc (a from the disc's centre), T and n tangent
    /// and normal of the trace, κ its curvature, D the distance of the pin centre and v = |c′|, dτ = T·w/(v (1 − κ D));
    /// differentiated once more, with dn = −κ T ds, dT = κ n ds and dD = n·w,
    /// ∇²τ = −(v′/v − κ′ D/(1 − κ D)) ∇τ ∇τᵀ + κ/(1 − κ D) (∇τ Nᵀ + N ∇τᵀ) + (n dθᵀ + dθ nᵀ + (n·J a) dθ dθᵀ)/(v (1 − κ D)),
    /// N = ∂(n·w).
    pub(crate) fn place_bend(&self, contact: &PinContact, rolling: &Rolling) -> [[f64; 3]; 3] {
        let [slope, bend] = contact.place_by_foot;
        if slope == 0.0 {
            return [[0.0; 3]; 3];
        }
        let profile = self.profile();
        let PinContact { trace_curvature: curvature, foot_distance: distance, foot_normal: n, arm, .. } =
            *contact;
        let meshing = contact.meshing_unit;
        let factor = profile.speed_factor(meshing.x);
        let reach = 1.0 - curvature * distance;
        let curvature_rate = profile.trace_curvature_rate(meshing.y, factor, curvature);
        let along = curvature_rate * distance / reach - profile.speed_factor_rate(meshing.y, factor) / factor;
        let (mixed, turned) = (curvature / reach, 1.0 / (profile.circle_speed() * factor * reach));
        let lever = n.dot(&quarter_turn(arm));
        // With the foot f: ∇²τ(f) = τ′ ∇²f + τ″ ∇f ∇fᵀ.
        let foot = rolling.by_pose.map(|by| by / slope);
        let (across, turn) = ([-n.x, -n.y, -lever], [n.x, n.y, 0.5 * lever]);
        let unit = |i: usize| if i == 2 { 1.0 } else { 0.0 };
        let entry = |i: usize, j: usize| {
            let of_foot = along * foot[i] * foot[j]
                + mixed * (foot[i] * across[j] + across[i] * foot[j])
                + turned * (turn[i] * unit(j) + unit(i) * turn[j]);
            slope * of_foot + bend * foot[i] * foot[j]
        };
        std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
    }
}
