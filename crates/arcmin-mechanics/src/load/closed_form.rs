//! The handbook method of Tao2024 (eqs. 5–10): forces proportional to the rigid-body approach minus the initial
//! gaps.
//!
//! Valid while there is no negative gap after rotation to first contact, see [`ClosedForm::smallest_gap`].
//! Angles here are |φ|.

use crate::contact::{ContactLaw, LineContact};
use crate::machine::Machine;
use crate::units::UM;

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

/// Reason why the closed form has no solution.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ClosedFormError {
    /// The iteration of force and deformation did not converge.
    #[error(
        "the closed form of the load sharing did not settle in {iterations} iterations (largest force {max_force:.6e} N)"
    )]
    NotConverged {
        /// Number of iterations.
        iterations: usize,
        /// Largest pin force of the last iteration, N.
        max_force: f64,
    },
    /// The offsets of the flank cause interference without torque, with larger forces than the torque causes.
    #[error(
        "the closed form has no solution: after rotation to first contact the offsets leave a gap of {smallest_gap_um:.2} µm, and the overlap alone bears more than the torque"
    )]
    Overlap {
        /// Smallest gap, negative where flank and pin overlap, µm.
        smallest_gap_um: f64,
    },
    /// Torque, N·m, that is not positive.
    #[error("the closed form needs a positive torque, not {0} N·m")]
    BadTorque(f64),
    /// Short-width coefficient K1 that is not below 1.
    #[error(
        "the closed form needs a curtate flank, K1 = a z_p/R_p below 1, not {0:.4}; use a smaller eccentricity or a larger pin circle"
    )]
    NotCurtate(f64),
}

/// Torque in N·m on the most loaded disc for the output torque T: T/n (1 + 0.1 E_n/E_2), with E_n the mean of
/// the largest of n standard normal deviations.
///
/// The handbook's 0.55 T for two discs is half of the torque plus a tenth for the errors of the discs. A single
/// disc carries T. The additional torque of a disc is its stiffness times its lead over the mean of all; for n
/// discs with equal tolerances the largest lead is proportional to E_n (1/√π for two, 3/(2√π) for three): 1.15
/// T/3 and 1.18 T/4. This extends the handbook, which covers two discs.
pub fn disc_torque(torque: f64, discs: usize) -> f64 {
    let uneven = match discs {
        // The handbook's own factors, without the rounding error of the means.
        0 | 1 => 0.0,
        2 => 0.1,
        3 => 0.15,
        n => 0.1 * std::f64::consts::PI.sqrt() * largest_normal(n),
    };
    (1.0 + uneven) * torque / discs.max(1) as f64
}

/// Mean of the largest of n standard normal deviations, ∫ x dΦ(x)ⁿ = ∫_0^∞ (1 − Φ(x)ⁿ − Φ(−x)ⁿ) dx.
fn largest_normal(n: usize) -> f64 {
    const STEP: f64 = 1e-3;
    const END: usize = 9000;
    let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    let (mut below, mut sum) = (0.5_f64, 0.0);
    let rest = |below: f64| 1.0 - below.powi(n as i32) - (1.0 - below).powi(n as i32);
    for i in 0..END {
        let before = rest(below);
        // Simpson's rule for Φ, the trapezoidal rule for the mean: 1e-8.
        let (a, b) = (STEP * i as f64, STEP * (i + 1) as f64);
        below += STEP / 6.0 * (density(a) + 4.0 * density(0.5 * (a + b)) + density(b));
        sum += 0.5 * STEP * (before + rest(below));
    }
    sum
}

/// First estimate F_max0 = 4 T_c/(K1 z_c R_p), which is 2.2 T/(K1 z_c R_p) with the handbook's two discs. The
/// paper prints the pin radius for R_p, which gives 21 times more.
pub fn first_max_force(machine: &Machine, torque: f64) -> f64 {
    let profile = machine.profile();
    4.0 * disc_torque(torque, machine.disc_count)
        / (profile.short_width_coefficient() * profile.lobe_count() as f64 * machine.ring.pin_circle_radius)
}

/// Gap after rotation to first contact of a disc ground with both offsets, in m: Δ(φ) = Δr_p (1 − sin φ/S) −
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
/// T_c = 0.55 T per disc (for two discs; [`disc_torque`] in general), F_max = T_c / Σ (l_i/l_max − Δ_i/δ_max)
/// l_i over the pairs where the bracket is positive, with δ_max(F_max) from the paper's eq. (6) (with the
/// Hertz half-width for R_eq = r_p). The torque of all pairs rises with F_max, so the solution is unique; it is
/// bracketed and found to 1e-13.
///
/// # Errors
/// [`ClosedFormError`] when the torque is not positive or F_max is not finite.
pub fn solve(machine: &Machine, torque: f64, depth: f64) -> Result<ClosedForm, ClosedFormError> {
    if !(torque > 0.0 && torque.is_finite()) {
        return Err(ClosedFormError::BadTorque(torque));
    }
    // The closed form uses the ring as installed; the offsets are contained in Δ.
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
    let disc_torque = disc_torque(torque, machine.disc_count);
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

    let shares = |max_approach: f64| {
        levers.iter().zip(&gaps).map(move |(lever, gap)| (lever / longest - gap / max_approach).max(0.0))
    };
    let excess = |max_force: f64| {
        let max_approach = law.approach(max_force, machine.ring.pin_radius);
        let sum: f64 = shares(max_approach).zip(&levers).map(|(share, lever)| share * lever).sum();
        max_force * sum - disc_torque
    };
    let first = first_max_force(machine, torque);
    let smallest_gap = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    // With interference the pairs carry torque for any F_max.
    if smallest_gap < 0.0 && excess(LEAST_FORCE * first) > 0.0 {
        return Err(ClosedFormError::Overlap { smallest_gap_um: smallest_gap / UM });
    }
    let max_force = rising_root(first, excess)
        .map_err(|max_force| ClosedFormError::NotConverged { iterations: ITERATIONS, max_force })?;
    let max_approach = law.approach(max_force, machine.ring.pin_radius);
    let pairs = angles
        .iter()
        .zip(shares(max_approach).zip(&gaps))
        .map(|(angle, (share, gap))| ClosedFormPair {
            meshing_angle: *angle,
            force: max_force * share,
            initial_gap: *gap,
        })
        .collect();
    Ok(ClosedForm { pairs, max_force, max_approach })
}

const ITERATIONS: usize = 500;
/// Share of the first estimate below which the largest force counts as zero.
const LEAST_FORCE: f64 = 1e-3;

/// Positive root of an increasing function: bracketing by doubling and halving, then regula falsi with the
/// Illinois modification, and bisection where the bracket does not shrink. Without a root the error is the last
/// argument.
fn rising_root(start: f64, value: impl Fn(f64) -> f64) -> Result<f64, f64> {
    let (mut low, mut high) = (start, start);
    let (mut at_low, mut at_high) = (value(start), value(start));
    let mut iterations = 0..ITERATIONS;
    while at_low > 0.0 || at_high < 0.0 {
        if iterations.next().is_none() || !(at_low.is_finite() && at_high.is_finite()) {
            return Err(high);
        }
        if at_low > 0.0 {
            (high, at_high) = (low, at_low);
            low *= 0.5;
            at_low = value(low);
        } else {
            (low, at_low) = (high, at_high);
            high *= 2.0;
            at_high = value(high);
        }
    }
    let mut last_width = f64::INFINITY;
    for _ in iterations {
        let width = high - low;
        if width <= 1e-14 * high || at_low == 0.0 || at_high == 0.0 {
            return Ok(if at_low.abs() < at_high.abs() { low } else { high });
        }
        let middle = 0.5 * (low + high);
        let secant = low + width * at_low / (at_low - at_high);
        let next = if width < 0.7 * last_width && secant > low && secant < high { secant } else { middle };
        last_width = if next == middle { f64::INFINITY } else { width };
        let at_next = value(next);
        if at_next.is_nan() {
            return Err(next);
        }
        if at_next < 0.0 {
            (low, at_low) = (next, at_next);
            at_high *= 0.5;
        } else {
            (high, at_high) = (next, at_next);
            at_low *= 0.5;
        }
    }
    Err(high)
}

impl ClosedForm {
    /// Number of pairs that carry force.
    pub fn loaded_pairs(&self) -> usize {
        self.pairs.iter().filter(|pair| pair.force > 0.0).count()
    }

    /// Smallest initial gap in m; if it is negative, the offsets violate the assumption of the method.
    pub fn smallest_gap(&self) -> f64 {
        self.pairs.iter().map(|pair| pair.initial_gap).fold(f64::INFINITY, f64::min)
    }
}
