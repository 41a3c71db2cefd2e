use super::tip::Tip;
use super::{Vec2, cross, quarter_turn, turned, unit};
use crate::units::wrap_angle;

/// The flank of a cycloid disc *as cut*: the envelope of the generating pins.
///
/// With the trace c(τ) = R e(τ) − a e(z τ), e(x) = (cos x, sin x), the flank is f(τ) = c(τ) + r n(τ) with the
/// inward normal n. R, r are the generating pin circle and pin radius: those of the installed ring plus the
/// radial and the equidistant offset. τ runs over [0, 2π) once around the disc; a lobe spans 2π/(z − 1).
///
/// With a tooth difference m the disc has z_c = z − m lobes and turns by −m/z_c per turn of the eccentric. Around each
/// root ρ = 2πk/z_c the trace is c = R e(ρ + t) − a e(ρ + (z/m) t), t = m (τ − ρ): a branch that repeats after m lobes.
/// τ still runs once around the disc and a lobe spans 2π/z_c; the meshing angle is −z_c τ. For m > 1 neighbouring branches
/// cross, and the flank ends below their crossing, at its [`Tip`].
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Number of pins z.
    pub pin_count: usize,
    /// Tooth difference m: the disc has m lobes less than the ring has pins.
    pub tooth_difference: usize,
    /// Generating pin-circle radius R in m.
    pub pin_circle_radius: f64,
    /// Eccentricity a in m.
    pub eccentricity: f64,
    /// Generating pin radius r in m.
    pub pin_radius: f64,
    /// End of the flank; `None` if it is smooth over the tip.
    pub(super) tip: Option<Tip>,
}

impl Profile {
    /// A flank with a tooth difference of 1.
    pub fn new(pin_count: usize, pin_circle_radius: f64, eccentricity: f64, pin_radius: f64) -> Profile {
        Profile { pin_count, tooth_difference: 1, pin_circle_radius, eccentricity, pin_radius, tip: None }
    }

    /// Number of lobes z_c = z_p − m.
    #[inline]
    pub fn lobe_count(&self) -> usize {
        self.pin_count - self.tooth_difference
    }

    /// z_p/m: turns of the eccentric against the disc for one of the disc against the ring, and e z_p/m the pitch radius of
    /// the ring.
    #[inline]
    pub fn pins_per_turn(&self) -> f64 {
        self.pin_count as f64 / self.tooth_difference as f64
    }

    /// z_c/m: turns of the eccentric against the ring for one of the disc, and e z_c/m the pitch radius of the disc.
    #[inline]
    pub fn lobes_per_turn(&self) -> f64 {
        self.lobe_count() as f64 / self.tooth_difference as f64
    }

    /// m R in m: the speed of the trace is m R S per radian of τ.
    #[inline]
    pub(crate) fn circle_speed(&self) -> f64 {
        self.tooth_difference as f64 * self.pin_circle_radius
    }

    /// Directions of the generating pin and of the eccentric at τ, in the frame of the disc.
    #[inline]
    pub fn directions(&self, tau: f64) -> (Vec2, Vec2) {
        let z = self.pin_count as f64;
        if self.tooth_difference == 1 {
            return (unit(tau), unit(z * tau));
        }
        let root = self.root_near(tau);
        let axis = unit(root);
        let offset = tau - root;
        (turned(axis, unit(self.tooth_difference as f64 * offset)), turned(axis, unit(z * offset)))
    }

    /// Parameter of the root nearest to τ.
    #[inline]
    pub(super) fn root_near(&self, tau: f64) -> f64 {
        let pitch = std::f64::consts::TAU / self.lobe_count() as f64;
        pitch * (tau / pitch).round()
    }

    /// Short width (curtate) coefficient K1 = a z_p / (m R_p).
    #[inline]
    pub fn short_width_coefficient(&self) -> f64 {
        self.eccentricity * self.pins_per_turn() / self.pin_circle_radius
    }

    /// Meshing angle φ = −z_c τ in (−π, π]: the angle of the touching pin from the direction of the
    /// eccentric.
    #[inline]
    pub fn meshing_angle(&self, tau: f64) -> f64 {
        wrap_angle(-(self.lobe_count() as f64) * tau)
    }

    /// S(φ) = √(1 + K1² − 2 K1 cos φ); |c′| = m R S.
    #[inline]
    pub fn speed_factor(&self, cos_meshing_angle: f64) -> f64 {
        let k1 = self.short_width_coefficient();
        (1.0 + k1 * k1 - 2.0 * k1 * cos_meshing_angle).sqrt()
    }

    /// Centre of the generating pin, c(τ), in m, also beyond the end of the flank.
    pub fn trace(&self, tau: f64) -> Vec2 {
        let (e, ez) = self.directions(tau);
        self.pin_circle_radius * e - self.eccentricity * ez
    }

    /// Outward unit normal at τ: shared by trace and flank, radial on the land of a tip.
    pub fn outward_normal(&self, tau: f64) -> Vec2 {
        match self.on_land(tau) {
            Some((_, angle)) => unit(angle),
            None => self.trace_normal(tau),
        }
    }

    /// Outward unit normal of the trace at τ.
    pub(super) fn trace_normal(&self, tau: f64) -> Vec2 {
        let z = self.pin_count as f64;
        let (e, ez) = self.directions(tau);
        let tangent = quarter_turn(self.circle_speed() * e - self.eccentricity * z * ez);
        -quarter_turn(tangent).normalize()
    }

    /// Angle ψ on a nominally placed pin at which the contact of meshing angle φ lies: from the pin's place
    /// on the ring to the normal of the flank, in rad.
    pub fn pin_angle(&self, meshing_angle: f64) -> f64 {
        let tau = -meshing_angle / self.lobe_count() as f64;
        let (place, normal) = (self.directions(tau).0, self.trace_normal(tau));
        cross(place, normal).atan2(place.dot(&normal))
    }

    /// Point of the edge of the disc at τ in m: of the flank, f(τ) = c(τ) − r n_out(τ), or of the land of its tip.
    pub fn flank_point(&self, tau: f64) -> Vec2 {
        match self.on_land(tau) {
            Some((radius, angle)) => radius * unit(angle),
            None => self.cut_point(tau),
        }
    }

    /// Point of the parallel of the trace, also beyond the end of the flank.
    pub(super) fn cut_point(&self, tau: f64) -> Vec2 {
        self.trace(tau) - self.pin_radius * self.trace_normal(tau)
    }

    /// Lever arm of the normal force about the disc centre, l(φ) = a (z_c/m) sin φ / S in m, signed like φ.
    pub fn lever_arm(&self, meshing_angle: f64) -> f64 {
        let (sin, cos) = meshing_angle.sin_cos();
        self.eccentricity * self.lobes_per_turn() * sin / self.speed_factor(cos)
    }

    /// Largest lever arm, reached at cos φ = K1 (for K1 < 1): the base radius a z_c/m of the disc, in m.
    pub fn largest_lever_arm(&self) -> f64 {
        self.eccentricity * self.lobes_per_turn()
    }

    /// Curvature of the trace 1/ρ0 in 1/m, positive where it is concave seen from the pin:
    /// ρ0 = R S³ / (K1 (1+z_p/m) cos φ − (1 + (z_p/m) K1²)).
    #[inline]
    pub fn trace_curvature(&self, cos_meshing_angle: f64) -> f64 {
        let k1 = self.short_width_coefficient();
        let z = self.pins_per_turn();
        let s = self.speed_factor(cos_meshing_angle);
        (k1 * (1.0 + z) * cos_meshing_angle - (1.0 + z * k1 * k1)) / (self.pin_circle_radius * s * s * s)
    }

    /// Curvature radius of the flank ρ = ρ0 + r in m, positive where concave, ±∞ at the inflection.
    pub fn flank_curvature_radius(&self, cos_meshing_angle: f64) -> f64 {
        1.0 / self.flank_curvature(cos_meshing_angle)
    }

    /// Meshing angle of the inflection, cos φ = (1 + z K1²)/(K1 (1 + z)) with z = z_p/m, or `None` if the flank has
    /// none.
    pub fn inflection(&self) -> Option<f64> {
        let k1 = self.short_width_coefficient();
        let z = self.pins_per_turn();
        let cos = (1.0 + z * k1 * k1) / (k1 * (1.0 + z));
        (cos.abs() <= 1.0 && self.is_usable(cos)).then(|| cos.acos())
    }

    /// Radius of the disc at its roots in m: R − a − r of the generating pins.
    pub fn root_radius(&self) -> f64 {
        self.pin_circle_radius - self.eccentricity - self.pin_radius
    }

    /// Sharpest convex place of the trace: (|ρ0| in m, meshing angle in rad).
    ///
    /// The disc is free of undercut while |ρ0| there exceeds the generating pin radius; the difference is the
    /// smallest convex radius of the flank. dρ0/dφ = 0 has the closed form
    /// cos φ = (K1² (2z − 1) − (z − 2)) / (K1 (z + 1)) with z = z_p/m; the end of the flank, or the tip φ = 180°, is the
    /// other candidate.
    pub fn sharpest_convex_trace(&self) -> (f64, f64) {
        match self.largest_trace_curvature() {
            (curvature, at) if curvature > 0.0 => (1.0 / curvature, at),
            _ => (f64::INFINITY, std::f64::consts::PI),
        }
    }

    /// Largest convex curvature −1/ρ0 of the trace in 1/m and the meshing angle there in rad; negative where the
    /// trace is hollow up to the end of the flank.
    ///
    /// The flank is free of undercut while it stays below 1/r of the generating pins, which a hollow trace does for
    /// pins of any radius.
    pub fn largest_trace_curvature(&self) -> (f64, f64) {
        let k1 = self.short_width_coefficient();
        let z = self.pins_per_turn();
        let last = self.tip.as_ref().map_or(-1.0, |tip| tip.cos_end);
        let cos = ((k1 * k1 * (2.0 * z - 1.0) - (z - 2.0)) / (k1 * (z + 1.0))).clamp(last, 1.0);
        let candidates = [cos, last];
        candidates
            .into_iter()
            .map(|cos| (-self.trace_curvature(cos), cos.acos()))
            .fold((f64::NEG_INFINITY, 0.0), |most, one| if one.0 > most.0 { one } else { most })
    }

    /// Curvature of the flank 1/ρ in 1/m, positive where concave; finite at the inflection. Beyond the end of the flank
    /// that of the land.
    #[inline]
    pub fn flank_curvature(&self, cos_meshing_angle: f64) -> f64 {
        if let Some(tip) = self.tip.as_ref().filter(|tip| !tip.is_usable(cos_meshing_angle)) {
            return -1.0 / tip.radius;
        }
        let trace = self.trace_curvature(cos_meshing_angle);
        trace / (1.0 + self.pin_radius * trace)
    }

    /// Relative curvature 1/R_eq = 1/r − 1/ρ in 1/m of the flank and an installed pin of radius r.
    ///
    /// The pin is convex; the flank subtracts where it is concave (ρ > 0) and adds where it is convex (ρ <
    /// 0). For r equal to the generating radius this is R_eq = r |ρ0 + r| / |ρ0|.
    pub fn relative_curvature(&self, cos_meshing_angle: f64, installed_pin_radius: f64) -> f64 {
        1.0 / installed_pin_radius - self.flank_curvature(cos_meshing_angle)
    }

    /// Specific sliding of the disc flank, ξ = |v_s|/|v_c|: sliding speed over the speed of the contact along
    /// the flank.
    ///
    /// v_s = (R S − r) ω, v_c = R S |1 + r/ρ0| ω. At an undercut-free flank v_c never vanishes.
    pub fn specific_sliding(&self, cos_meshing_angle: f64) -> f64 {
        let rs = self.pin_circle_radius * self.speed_factor(cos_meshing_angle);
        (rs - self.pin_radius).abs()
            / (rs * (1.0 + self.pin_radius * self.trace_curvature(cos_meshing_angle)).abs())
    }

    /// Arc length of the edge per radian of meshing angle, |df/dφ| in m/rad.
    #[inline]
    pub fn flank_length_per_meshing_angle(&self, cos_meshing_angle: f64) -> f64 {
        if let Some(tip) = self.tip.as_ref().filter(|tip| !tip.is_usable(cos_meshing_angle)) {
            return tip.land_per_meshing_angle(self.lobe_count());
        }
        let rs = self.circle_speed() * self.speed_factor(cos_meshing_angle);
        rs * (1.0 + self.pin_radius * self.trace_curvature(cos_meshing_angle)).abs()
            / self.lobe_count() as f64
    }

    /// c, c′ and c″ of the trace from its [`directions`](Profile::directions): the fast path of the foot-point search.
    #[inline]
    pub fn trace_derivatives(&self, e: Vec2, ez: Vec2) -> (Vec2, Vec2, Vec2) {
        let (m, az) = (self.tooth_difference as f64, self.eccentricity * self.pin_count as f64);
        let turning = m * self.pin_circle_radius;
        let c = self.pin_circle_radius * e - self.eccentricity * ez;
        let c1 = quarter_turn(turning * e - az * ez);
        let c2 = az * self.pin_count as f64 * ez - m * turning * e;
        (c, c1, c2)
    }

    /// c‴ of the trace from its directions.
    #[inline]
    pub fn trace_third_derivative(&self, e: Vec2, ez: Vec2) -> Vec2 {
        let (m, z) = (self.tooth_difference as f64, self.pin_count as f64);
        -quarter_turn(m * m * m * self.pin_circle_radius * e - self.eccentricity * z * z * z * ez)
    }

    /// c⁗ of the trace from its directions.
    #[inline]
    pub(super) fn trace_fourth_derivative(&self, e: Vec2, ez: Vec2) -> Vec2 {
        let (m2, z2) = (
            (self.tooth_difference * self.tooth_difference) as f64,
            (self.pin_count * self.pin_count) as f64,
        );
        m2 * m2 * self.pin_circle_radius * e - self.eccentricity * z2 * z2 * ez
    }

    /// cos φ and sin φ from the directions.
    #[inline]
    pub(crate) fn meshing_cos_sin(e: Vec2, ez: Vec2) -> (f64, f64) {
        (e.dot(&ez), -cross(e, ez))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::DEG;

    fn rv_40e() -> Profile {
        Profile::new(40, 64e-3, 1.3e-3, 3e-3)
    }

    /// Closed forms of the RV-40E, computed beforehand by two independent programs; tolerance: the printed
    /// digits.
    #[test]
    fn val_key_figures_of_the_flank() {
        let p = rv_40e();
        assert!((p.short_width_coefficient() - 0.8125).abs() < 1e-12);
        assert!((p.largest_lever_arm() - 50.7e-3).abs() < 1e-12);
        assert!((p.short_width_coefficient().acos() / DEG - 35.659).abs() < 5e-4);
        assert!((p.inflection().unwrap() / DEG - 34.644).abs() < 5e-4);
        let (radius, angle) = p.sharpest_convex_trace();
        assert!((radius * 1e3 - 4.6117).abs() < 5e-5 && (angle / DEG - 64.86).abs() < 5e-3);
        assert!((1e3 / p.trace_curvature(1.0) - 0.0714).abs() < 5e-5);
        for (degrees, expected) in
            [(10.0, 0.044), (34.65, 0.918), (60.0, 2.679), (100.0, 2.272), (150.0, 1.911)]
        {
            let xi = p.specific_sliding((degrees * DEG).cos());
            assert!((xi - expected).abs() < 6e-4, "{degrees}: {xi}");
        }
    }

    #[test]
    fn curvature_and_length_agree_with_differences_of_the_flank() {
        let p = rv_40e();
        for i in 1..200 {
            let tau = 0.37 + i as f64 * 0.003;
            let h = 1e-5;
            let (a, m, b) = (p.flank_point(tau - h), p.flank_point(tau), p.flank_point(tau + h));
            let first = (b - a) / (2.0 * h);
            let second = (a - 2.0 * m + b) / (h * h);
            // Counter-clockwise path: a convex place turns left, a concave one right.
            let curvature = -cross(first, second) / first.norm().powi(3);
            let cos = p.meshing_angle(tau).cos();
            let scale = curvature.abs().max(20.0);
            assert!((curvature - p.flank_curvature(cos)).abs() / scale < 2e-3, "{tau}");
            let length = first.norm() / p.lobe_count() as f64;
            assert!((length / p.flank_length_per_meshing_angle(cos) - 1.0).abs() < 1e-4);
        }
    }

    /// Several public codes subtract the flank's curvature on the convex side as well. That would make the
    /// contact at 60° conformal instead of sharp: 8.5 mm instead of 1.06 mm.
    #[test]
    fn trap_sign_of_curvature_on_the_convex_side() {
        let p = rv_40e();
        let cos = (60.0 * DEG).cos();
        let rho = p.flank_curvature_radius(cos);
        assert!(rho < 0.0);
        let right = 1.0 / p.relative_curvature(cos, 3e-3);
        let rho0 = 1.0 / p.trace_curvature(cos);
        assert!((right - 3e-3 * (rho0 + 3e-3).abs() / rho0.abs()).abs() < 1e-15);
        let wrong = 1.0 / (1.0 / 3e-3 - 1.0 / rho.abs());
        assert!(right < 1.2e-3 && wrong.abs() > 3e-3);
    }

    #[test]
    fn contact_turns_back_on_the_pin_where_the_lever_arm_is_largest() {
        let p = rv_40e();
        // sin ψ = K1 there: the line of action is a tangent of the circle a z_p around the ring's centre.
        let turn = p.short_width_coefficient().acos();
        assert!((p.pin_angle(turn).abs() - p.short_width_coefficient().asin()).abs() < 1e-12);
        assert!((p.pin_angle(turn + 1e-4) - p.pin_angle(turn - 1e-4)).abs() < 1e-9);
        assert!(p.pin_angle(0.0).abs() < 1e-12 && (p.pin_angle(0.5) + p.pin_angle(-0.5)).abs() < 1e-12);
    }

    #[test]
    fn normal_is_perpendicular_and_points_outwards_at_the_tip() {
        let p = rv_40e();
        let tip = std::f64::consts::PI / 39.0;
        assert!((p.outward_normal(tip) - unit(tip)).norm() < 1e-12);
        let h = 1e-6;
        let tangent = (p.trace(0.01 + h) - p.trace(0.01 - h)).normalize();
        assert!(tangent.dot(&p.outward_normal(0.01)).abs() < 1e-8);
    }
}
