//! Wear of parts other than flank and pins: rolling bearings and involute gears, by Archard's law with
//! coefficients of their own.

use crate::machine::{GearStage, Machine, PartWear, RollerBearing, RollingWear};
use std::f64::consts::PI;

/// Loads that cause this wear: means over time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PartLoads {
    /// Sum of the forces (N) on all rollers of one turning-arm bearing, mean of the bearings.
    pub turning_arm: f64,
    /// The same of one crank support.
    pub crank_support: f64,
    /// Tooth force (N) of one sun–planet mesh on the sides named in [`PartWear::gears`].
    pub gears: [f64; 2],
}

/// Increase of the diametral clearance per unit of time and of the wear coefficient, m/s per 1/Pa.
///
/// A roller that rolls a distance dx under the force Q slips by s dx relative to each raceway and removes k Q s
/// dx from either body. Spread uniformly over both raceways and all rollers, with the rolling speed v = ω D (1
/// − γ²)/4 at either contact and γ = d cos α/D, dc/dt = (2/cos α) k s v ΣQ/(π l) · [1/(D − d cos α) + 1/(D + d
/// cos α) + 4/(Z d)]. The first two terms are those of the raceways; a roller wears at both contacts, and its
/// wear counts twice in the clearance.
///
/// `slip` is s, the sliding distance per rolled distance; `forces` is ΣQ in N, `speed` the relative speed ω of
/// the rings in rad/s. Not modelled: nonuniform wear around a ring, contacts of ribs and cage, fatigue.
pub fn clearance_rate(bearing: &RollerBearing, slip: f64, forces: f64, speed: f64) -> f64 {
    let cosine = bearing.contact_angle.cos();
    let (d, pitch) = (bearing.roller_diameter, bearing.pitch_diameter);
    let gamma = d * cosine / pitch;
    let rolling = 0.25 * speed.abs() * pitch * (1.0 - gamma * gamma);
    let surfaces = 1.0 / (pitch * (1.0 - gamma))
        + 1.0 / (pitch * (1.0 + gamma))
        + 4.0 / (bearing.roller_count as f64 * d);
    2.0 / cosine * slip * rolling * forces / (PI * bearing.roller_length) * surfaces
}

/// Rates in m/s under these loads; `relative` is the speed (rad/s) of the crankshafts relative to discs and
/// carrier, `gears` those of sun and planet relative to the carrier. The coefficients are constant: running-in
/// and film apply to flank and pins only.
pub fn rates(machine: &Machine, loads: &PartLoads, relative: f64, gears: [f64; 2]) -> PartWear {
    let (law, bearings) = (&machine.wear.parts, &machine.bearings);
    let rolling = |law: &Option<RollingWear>, bearing: &RollerBearing, forces: f64| {
        law.map_or(0.0, |law| law.coefficient * clearance_rate(bearing, law.slip, forces, relative))
    };
    let gap = |force: f64| {
        let [sun, planet] = mesh_gap_rate(&machine.gear_stage, machine.crankshafts.count, force, gears);
        law.sun * sun + law.planet * planet
    };
    PartWear {
        turning_arm: rolling(&law.turning_arm, &bearings.turning_arm, loads.turning_arm),
        crank_support: rolling(&law.crank_support, &bearings.crank_support, loads.crank_support),
        gears: loads.gears.map(gap),
        ..PartWear::default()
    }
}

/// Path of contact of the sun–planet mesh along the line of action, with coordinates from the pitch point
/// towards the tip of the sun's tooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathOfContact {
    /// Distance of the pitch point from the foot of the sun's base circle, r_b tan α, in m.
    pub sun_foot: f64,
    /// The same to the foot of the planet's base circle, m.
    pub planet_foot: f64,
    /// Coordinate where contact begins, m, negative.
    pub start: f64,
    /// Coordinate where contact ends, m.
    pub end: f64,
    /// p_b = π m cos α in m.
    pub base_pitch: f64,
    /// z_1/z_2.
    pub tooth_ratio: f64,
}

/// Share of the distance to the foot of a base circle that contact comes near to at most: below it teeth are
/// relieved or undercut. An assumption: sliding grows without bound towards the foot (ξ is 9 (1 + z_1/z_2) at 0.9),
/// and tip relief is not in the design.
const NEAREST_FOOT: f64 = 0.9;

impl PathOfContact {
    /// For addenda of one module on both gears, an assumption.
    pub fn new(stage: &GearStage) -> PathOfContact {
        let tan = stage.pressure_angle.tan();
        let (rb1, rb2) = (stage.sun_base_radius(), stage.planet_base_radius());
        let beyond = |pitch_radius: f64, base: f64| {
            ((pitch_radius + stage.module).powi(2) - base * base).sqrt() - base * tan
        };
        let (sun_foot, planet_foot) = (rb1 * tan, rb2 * tan);
        PathOfContact {
            sun_foot,
            planet_foot,
            start: -beyond(stage.planet_pitch_radius(), rb2).min(NEAREST_FOOT * sun_foot),
            end: beyond(stage.sun_pitch_radius(), rb1).min(NEAREST_FOOT * planet_foot),
            base_pitch: PI * stage.module * stage.pressure_angle.cos(),
            tooth_ratio: stage.sun_teeth as f64 / stage.planet_teeth as f64,
        }
    }

    /// Contact ratio ε_α, the mean number of pairs of teeth in contact.
    pub fn contact_ratio(&self) -> f64 {
        (self.end - self.start) / self.base_pitch
    }

    /// Specific sliding |v_1 − v_2|/v of the flanks of sun and planet at the coordinate s: (1 + u)|s|/(r_b1 tan
    /// α + s) and (1 + u)|s|/(u (r_b2 tan α − s)), u = z_1/z_2, speeds in the frame of the carrier.
    pub fn specific_sliding(&self, s: f64) -> [f64; 2] {
        let u = self.tooth_ratio;
        [(1.0 + u) * s.abs() / (self.sun_foot + s), (1.0 + u) * s.abs() / (u * (self.planet_foot - s))]
    }

    /// Number of pairs in contact while one of them is at s.
    fn pairs(&self, s: f64) -> f64 {
        let ahead = ((self.end - s) / self.base_pitch + 1e-12).floor();
        let behind = ((s - self.start) / self.base_pitch + 1e-12).floor();
        1.0 + ahead + behind
    }

    /// (1/p_b) ∫ ξ/n² ds over the path for sun and planet, with n the number of pairs in contact: each pair
    /// carries F/n, and the gap of the mesh increases by the mean depth of the loaded pairs. Closed form for
    /// each section: ∫ s/(A + s) ds = s − A ln(A + s).
    pub fn mean_sliding(&self) -> [f64; 2] {
        let mut cuts = vec![self.start, 0.0, self.end];
        let mut pitch = self.base_pitch;
        while pitch < self.end - self.start {
            cuts.extend([self.start + pitch, self.end - pitch]);
            pitch += self.base_pitch;
        }
        cuts.sort_by(f64::total_cmp);
        let u = self.tooth_ratio;
        let (a, b) = (self.sun_foot, self.planet_foot);
        let on_sun = |s: f64| (1.0 + u) * (s - a * (a + s).ln());
        let on_planet = |s: f64| (1.0 + u) / u * (-s - b * (b - s).ln());
        let mut sums = [0.0; 2];
        for pair in cuts.windows(2) {
            let middle = 0.5 * (pair[0] + pair[1]);
            let weight = middle.signum() / self.pairs(middle).powi(2) / self.base_pitch;
            sums[0] += weight * (on_sun(pair[1]) - on_sun(pair[0]));
            sums[1] += weight * (on_planet(pair[1]) - on_planet(pair[0]));
        }
        sums
    }
}

/// Increase of the gap of one sun–planet mesh along its line of action per unit of time and of the wear
/// coefficients of sun and planet, m/s per 1/Pa.
///
/// Δh = k (F/b) ξ per pass, as for the cycloid flank. A tooth of the sun meets every planet once per turn
/// relative to the carrier, a tooth of a planet meets the sun once per turn of the planet. `force` is the tooth
/// force F in N, `speeds` those of sun and planet relative to the carrier in rad/s.
pub fn mesh_gap_rate(stage: &GearStage, planets: usize, force: f64, speeds: [f64; 2]) -> [f64; 2] {
    let sliding = PathOfContact::new(stage).mean_sliding();
    let line_load = force / stage.face_width;
    [
        planets as f64 * speeds[0].abs() / (2.0 * PI) * line_load * sliding[0],
        speeds[1].abs() / (2.0 * PI) * line_load * sliding[1],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Independent derivation: passes of rollers over one point of each surface, Δh = k (Q/l) s per pass.
    #[test]
    fn clearance_grows_by_the_passes_of_the_rollers() {
        let bearing = crate::templates::tao2024().bearings.crank_support;
        let (slip, forces, speed) = (0.01, 5000.0, 70.0);
        let (z, d, cosine) =
            (bearing.roller_count as f64, bearing.roller_diameter, bearing.contact_angle.cos());
        let gamma = d * cosine / bearing.pitch_diameter;
        let per_pass = slip * forces / z / bearing.roller_length;
        // Rollers pass a point of the inner ring at the rate ω (1 + γ)/2, of the outer at ω (1 − γ)/2; a roller
        // rotates at ω (D/d cos α)(1 − γ²)/2 cos α about its axis and touches both rings once per turn.
        let inner = z * speed * 0.5 * (1.0 + gamma) / (2.0 * PI) * per_pass;
        let outer = z * speed * 0.5 * (1.0 - gamma) / (2.0 * PI) * per_pass;
        let roller =
            2.0 * speed * 0.5 * bearing.pitch_diameter / d * (1.0 - gamma * gamma) / (2.0 * PI) * per_pass;
        let expected = 2.0 / cosine * (inner + outer + 2.0 * roller);
        let rate = clearance_rate(&bearing, slip, forces, speed);
        assert!((rate / expected - 1.0).abs() < 1e-12, "{rate} {expected}");
    }

    /// Specific sliding from the arc lengths of two involutes in mesh, ρ²/(2 r_b); its mean by summation over
    /// mesh positions.
    #[test]
    fn sliding_of_the_gears_agrees_with_rolling_two_involutes() {
        let stage = crate::templates::tao2024().gear_stage;
        let path = PathOfContact::new(&stage);
        let (r1, r2) = (stage.sun_base_radius(), stage.planet_base_radius());
        let arcs =
            |s: f64| ((path.sun_foot + s).powi(2) / (2.0 * r1), -(path.planet_foot - s).powi(2) / (2.0 * r2));
        let h = 1e-9;
        for s in [0.7 * path.start, 0.2 * path.start, 0.4 * path.end, 0.95 * path.end] {
            let (ahead, behind) = (arcs(s + h), arcs(s - h));
            let (on_sun, on_planet) = (ahead.0 - behind.0, ahead.1 - behind.1);
            let sliding = (on_sun - on_planet).abs();
            let found = path.specific_sliding(s);
            assert!(
                (found[0] / (sliding / on_sun) - 1.0).abs() < 1e-6
                    && (found[1] / (sliding / on_planet) - 1.0).abs() < 1e-6,
                "{s}"
            );
        }
        assert!((1.2..1.8).contains(&path.contact_ratio()), "{}", path.contact_ratio());
        // All pairs at 20 000 positions of the mesh.
        let n = 20_000;
        let mut sums = [0.0; 2];
        for i in 0..n {
            let first = path.start + path.base_pitch * (f64::from(i) + 0.5) / f64::from(n);
            let places: Vec<f64> =
                (0..4).map(|j| first + path.base_pitch * f64::from(j)).filter(|s| *s < path.end).collect();
            for s in &places {
                for (sum, sliding) in sums.iter_mut().zip(path.specific_sliding(*s)) {
                    *sum += sliding / (places.len() as f64).powi(2) / f64::from(n);
                }
            }
        }
        for (sum, closed) in sums.iter().zip(path.mean_sliding()) {
            assert!((sum / closed - 1.0).abs() < 1e-3, "{sum} {closed}");
        }
    }

    /// There is no sliding at the pitch point.
    #[test]
    fn pitch_point_does_not_wear() {
        let path = PathOfContact::new(&crate::templates::tao2024().gear_stage);
        assert_eq!(path.specific_sliding(0.0), [0.0, 0.0]);
    }
}
