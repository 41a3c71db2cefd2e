//! The handbook method as Tao2024 uses it (eqs. 5–10): forces in proportion to rigid approach, reduced by the
//! initial gaps.
//!
//! Valid while the rotation to first contact leaves no negative gap; [`ClosedForm::smallest_gap`] tells.
//! Angles here are |φ|.

use crate::contact::{ContactLaw, LineContact};
use crate::machine::Machine;

/// One tooth pair of the closed form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosedFormPair {
    /// |φ| in rad.
    pub meshing_angle: f64,
    /// Normal force in N.
    pub force: f64,
    /// Initial gap Δ after rotation to first contact, in m.
    pub initial_gap: f64,
}

/// Solution of the closed form for one disc.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedForm {
    /// Pairs at φ = 360°/z_p, 2·360°/z_p, … below 180°.
    pub pairs: Vec<ClosedFormPair>,
    /// Largest force on the deformation line, F_max, in N (at the largest lever arm).
    pub max_force: f64,
    /// Approach at F_max in m.
    pub max_approach: f64,
}

/// The iteration did not settle.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ClosedFormError {
    #[error(
        "the closed form of the load sharing did not settle in {iterations} iterations (largest force {max_force:.6e} N); use the equilibrium method"
    )]
    NotConverged { iterations: usize, max_force: f64 },
    #[error("the closed form needs a positive torque, not {0} N·m")]
    BadTorque(f64),
    #[error(
        "the closed form needs a curtate flank, K1 = a z_p/R_p below 1, not {0:.4}; use a smaller eccentricity or a larger pin circle"
    )]
    NotCurtate(f64),
}

/// F_max0 = 2.2 T/(K1 z_c R_p), the first guess of the handbook for two discs. The paper prints the pin
/// radius for R_p, which gives 21 times more.
pub fn first_max_force(machine: &Machine, torque: f64) -> f64 {
    let profile = machine.profile();
    2.2 * torque
        / (profile.short_width_coefficient() * profile.lobe_count() as f64 * machine.ring.pin_circle_radius)
}

/// Gap after rotation to first contact of a disc cut with both offsets, in m: Δ(φ) = Δr_p (1 − sin φ/S) −
/// ΔR_p (1 − K1 cos φ − √(1−K1²) sin φ)/S. First order in the offsets; for curtate flanks, K1 < 1.
pub fn initial_gap(
    short_width_coefficient: f64,
    equidistant_offset: f64,
    radial_offset: f64,
    meshing_angle: f64,
) -> f64 {
    let k1 = short_width_coefficient;
    let (sin, cos) = meshing_angle.sin_cos();
    let s = (1.0 + k1 * k1 - 2.0 * k1 * cos).sqrt();
    equidistant_offset * (1.0 - sin / s) - radial_offset * (1.0 - k1 * cos - (1.0 - k1 * k1).sqrt() * sin) / s
}

/// Solves the closed form for the output torque T in N·m, uniform wear `depth` (m) on top of the
/// modification.
///
/// T_c = 0.55 T per disc (for two discs; 1.1 T/n in general), F_max = T_c / Σ (l_i/l_max − Δ_i/δ_max) l_i
/// over the pairs where the bracket is positive, iterated with δ_max(F_max) from the paper's eq. (6) (with
/// the Hertz half-width for R_eq = r_p) until F_max settles to 1e-12.
///
/// # Errors
/// [`ClosedFormError`] when the torque is not positive or F_max does not settle.
pub fn solve(machine: &Machine, torque: f64, depth: f64) -> Result<ClosedForm, ClosedFormError> {
    if !(torque > 0.0 && torque.is_finite()) {
        return Err(ClosedFormError::BadTorque(torque));
    }
    // The closed form describes the ring as installed; the offsets enter through Δ.
    let mut profile = machine.profile();
    profile.pin_circle_radius = machine.ring.pin_circle_radius;
    let k1 = profile.short_width_coefficient();
    if !(k1 < 1.0) {
        return Err(ClosedFormError::NotCurtate(k1));
    }
    let cut = &machine.disc.modification;
    let law = LineContact::new(
        ContactLaw::Tao2024,
        &machine.disc.material,
        &machine.ring.material,
        machine.disc.width,
        machine.ring.pin_radius,
    );
    let disc_torque = 1.1 * torque / machine.disc_count as f64;
    let count = machine.ring.pin_count;
    let angles: Vec<f64> = (1..)
        .map(|i| std::f64::consts::TAU * i as f64 / count as f64)
        .take_while(|phi| *phi < std::f64::consts::PI - 1e-9)
        .collect();
    let levers: Vec<f64> = angles.iter().map(|phi| profile.lever_arm(*phi)).collect();
    let gaps: Vec<f64> = angles
        .iter()
        .map(|phi| initial_gap(k1, cut.equidistant_offset + depth, cut.radial_offset, *phi))
        .collect();
    let longest = profile.largest_lever_arm();

    const ITERATIONS: usize = 500;
    let mut max_force = first_max_force(machine, torque);
    for _ in 0..ITERATIONS {
        let max_approach = law.approach(max_force, machine.ring.pin_radius);
        let shares: Vec<f64> = levers
            .iter()
            .zip(&gaps)
            .map(|(lever, gap)| (lever / longest - gap / max_approach).max(0.0))
            .collect();
        let sum: f64 = shares.iter().zip(&levers).map(|(share, lever)| share * lever).sum();
        if sum <= 0.0 {
            // The approach guessed closes no gap at all: more force is needed.
            max_force *= 2.0;
            continue;
        }
        let next = disc_torque / sum;
        let settled = (next / max_force - 1.0).abs() < 1e-13;
        // A pair that drops out raises F_max, which brings it back: half steps keep that from cycling.
        max_force = if settled { next } else { 0.5 * (max_force + next) };
        if settled {
            let pairs = angles
                .iter()
                .zip(shares.iter().zip(&gaps))
                .map(|(angle, (share, gap))| ClosedFormPair {
                    meshing_angle: *angle,
                    force: max_force * share,
                    initial_gap: *gap,
                })
                .collect();
            return Ok(ClosedForm { pairs, max_force, max_approach });
        }
    }
    Err(ClosedFormError::NotConverged { iterations: ITERATIONS, max_force })
}

impl ClosedForm {
    /// Number of pairs that carry force.
    pub fn loaded_pairs(&self) -> usize {
        self.pairs.iter().filter(|pair| pair.force > 0.0).count()
    }

    /// Smallest initial gap in m; negative means that the two offsets break the assumption of the method.
    pub fn smallest_gap(&self) -> f64 {
        self.pairs.iter().map(|pair| pair.initial_gap).fold(f64::INFINITY, f64::min)
    }
}
