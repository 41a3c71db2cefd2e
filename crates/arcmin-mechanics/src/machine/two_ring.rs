//! The drive of two rings in SI units, with its closed forms.

use super::{Bore, PartCounts, RingMesh, RollerBearing, StageErrors, StageFriction};

/// A cycloidal drive of two rings. Stepped discs run on eccentrics in the middle of the input shaft; one step
/// of a disc meshes with a fixed ring, the other with the output ring. There are no output pins.
///
/// All stepped discs are equal. Where there are several, each meshes with its own row of pins of the first
/// ring, which is rotated relative to the row of the first disc ([`TwoRing::row`]).
#[derive(Debug, Clone, PartialEq)]
pub struct TwoRing {
    /// Mesh with the fixed ring, and with the output ring.
    pub meshes: [RingMesh; 2],
    /// Face widths of the two steps in m.
    pub widths: [f64; 2],
    /// Angles of the eccentrics on the shaft in rad, one for each stepped disc.
    pub phases: Vec<f64>,
    /// Bearing between eccentric and stepped disc.
    pub eccentric: RollerBearing,
    /// Round openings through both steps: the bore of the eccentric bearing, others.
    pub openings: Vec<Bore>,
    /// Radial stiffness of the bearings of the input shaft, N/m.
    pub input_support: f64,
    /// Radial stiffness of the bearings of the output, N/m.
    pub output_support: f64,
    /// Mass in kg and moment of inertia in kg·m² of a stepped disc.
    pub disc: (f64, f64),
    /// Deviations of the drive from its drawing. First: the fixed ring with its pins row by row, the steps in
    /// it and the eccentrics; second: the output ring and its steps.
    pub errors: [StageErrors; 2],
}

impl TwoRing {
    /// z_c/m of either ring with its tooth difference m: turns of the eccentric per turn of the disc relative
    /// to that ring.
    pub(crate) fn lobes_per_turn(&self) -> [f64; 2] {
        self.meshes.each_ref().map(|mesh| mesh.profile.lobes_per_turn())
    }

    /// Turns of the input for one of the output. The disc rolls in the first ring, θ_d = −φ/n_1 with n = z_c/m, and the second
    /// ring on the disc, θ_d − θ = −(φ − θ)/n_2: θ = φ (n_1 − n_2)/(n_1 (n_2 + 1)), where n_2 + 1 = z_p2/m_2.
    pub fn ratio(&self) -> f64 {
        let [first, second] = self.lobes_per_turn();
        first * (second + 1.0) / (first - second)
    }

    /// Sets the deviations of the drive from its drawing, ring by ring.
    pub fn set_errors(&mut self, errors: [StageErrors; 2]) {
        self.errors = errors;
    }

    /// Number of parts that have errors, ring by ring.
    pub fn part_counts(&self) -> [PartCounts; 2] {
        let discs = self.phases.len();
        [0, 1].map(|k| {
            let profile = &self.meshes[k].profile;
            // Each disc has its own row of pins in the fixed ring.
            let rows = if k == 0 { discs } else { 1 };
            PartCounts {
                discs,
                ring_pins: rows * profile.pin_count,
                lobes: profile.lobe_count(),
                output_pins: 0,
            }
        })
    }

    /// z_c2/z_p2: rotation of the output per rotation of a disc whose centre is held.
    pub fn per_disc(&self) -> f64 {
        let profile = &self.meshes[1].profile;
        profile.lobe_count() as f64 / profile.pin_count as f64
    }

    /// Angle (rad) by which the row of pins of a disc in the first ring is ahead of the row of the first disc.
    /// With the phase p of its eccentric the second ring requires a disc angle of −p/n_2, and a first ring
    /// rotated by α one of α − (p − α)/n_1, n = z_c/m.
    pub fn row(&self, disc: usize) -> f64 {
        let [first, second] = self.lobes_per_turn();
        self.phases[disc] * (second - first) / (second * (first + 1.0))
    }

    /// Two-sided backlash at the output in rad with the input held, by single clearances: those in the first
    /// and the second ring, 2 Δ m/(e z_c) times z_c2/z_p2, and the radial clearance c of the eccentric bearing,
    /// 2 c/(e |i|), which transmits T/(e i) perpendicular to the eccentric. The sum is a lower bound, because
    /// with gaps in the rings a disc also shifts along its eccentric.
    pub fn play(&self) -> [f64; 3] {
        let [first, second] = self.meshes.each_ref().map(|mesh| mesh.free_turn() * self.per_disc());
        let eccentricity = self.meshes[0].profile.eccentricity;
        [first, second, self.eccentric.clearance.max(0.0) / (eccentricity * self.ratio().abs())]
    }

    /// Moment (N·m) of either ring about the centre of a disc, T z_c2/z_p2 for the disc's share T; the two have
    /// opposite senses.
    fn moment(&self, torque: f64) -> f64 {
        torque.abs() / self.phases.len() as f64 * self.per_disc()
    }

    /// Largest forces (N) on a pin of either ring if all pins on one side of a disc act as equal springs: 4
    /// M/(K₁ z_c R) with the moment M = T z_c2/z_p2 of a disc, which for the second ring is 4 T/(K₁ z_p R);
    /// larger on flanks that end before their tips.
    pub fn ring_forces(&self, torque: f64) -> [f64; 2] {
        self.meshes.each_ref().map(|mesh| mesh.pin_force(self.moment(torque)))
    }

    /// Force (N) on an eccentric bearing for equal springs: T/(e i) perpendicular to the eccentric; along it
    /// the sum of both ring forces.
    pub fn eccentric_force(&self, torque: f64) -> f64 {
        let moment = self.moment(torque);
        let [first, second] = self.meshes.each_ref().map(|mesh| moment / mesh.lever());
        let along = first * self.meshes[0].slant() + second * self.meshes[1].slant();
        (first - second).hypot(along)
    }

    /// Couple (N·m) that tilts a stepped disc: the forces of the two rings act at a distance of half the sum of
    /// the widths, each M m/(e z_c) √(1 + s²) with s the ratio of its components along and perpendicular to the
    /// eccentric. The plane model does not include this couple.
    pub fn leaning_couple(&self, torque: f64) -> f64 {
        let moment = self.moment(torque);
        let across = self.meshes.each_ref().map(|mesh| moment / mesh.lever());
        let along = [across[0] * self.meshes[0].slant(), -across[1] * self.meshes[1].slant()];
        let mean = [0.5 * (across[0] + across[1]), 0.5 * (along[0] + along[1])];
        0.5 * (self.widths[0] + self.widths[1]) * mean[0].hypot(mean[1])
    }

    /// Turns per turn of the input, absolute values: of a disc relative to the first and the second ring, and
    /// of an eccentric in its disc.
    pub fn turns(&self) -> [f64; 3] {
        let [first, second] = self.lobes_per_turn();
        [1.0 / first, (1.0 - 1.0 / self.ratio()) / second, 1.0 + 1.0 / first]
    }

    /// Efficiency for equal springs, to first order in the coefficients of friction: η = 1/(1 + |i| Σ M_i/T).
    /// For pins the friction moment is μ Σ F s, for the eccentric bearings μ F d/2, each times its turns per
    /// turn of the input. |i| increases with z², the losses of a ring decrease with 1/z, so that drives of
    /// large ratio have the largest losses.
    pub fn efficiency(&self, torque: f64, friction: &[StageFriction; 2]) -> f64 {
        let discs = self.phases.len() as f64;
        let [first, second, eccentric] = self.turns();
        let ring =
            |k: usize, turns: f64| friction[k].ring * self.moment(torque) * self.meshes[k].sliding() * turns;
        let bearing = friction[0].bearing
            * self.eccentric_force(torque)
            * 0.5
            * self.eccentric.pitch_diameter
            * eccentric;
        let lost = discs * (ring(0, first) + ring(1, second) + bearing);
        1.0 / (1.0 + self.ratio().abs() * lost / torque.abs())
    }
}
