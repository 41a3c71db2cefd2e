//! Load-dependent friction of the running joint, in the parameters of robot simulations.

use serde::{Deserialize, Serialize};

use super::fit::non_negative;
use super::{Hysteresis, SlipElement};
use crate::rig::{LoopPoint, LossLine};

/// Friction of the joint, modelled as one hinge, at the output:
///
/// τ_f = c + v |ω| + μ |τ| z + δ τ z², dz/dt = (ω − |ω| z)/h
///
/// with the motor's torque times the ratio τ (N·m) and the speed of the output ω (rad/s). The state z
/// approximates the sign of the speed and reverses within an angle of about h. If the motor drives, friction is
/// the fraction μ + δ of its torque, if the load drives μ − δ. The four parameters μ, δ, h and v are those that
/// users of MuJoCo have fitted to measurements of strain-wave gears and cycloidal drives in both directions of
/// power (google-deepmind/mujoco, issue 3528, September 2026); c is the friction without load, `frictionloss`
/// of MuJoCo. Without h it is the directional load-dependent model of BAM (Duclusaud et al., arXiv 2410.08650)
/// at running speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RunningFriction {
    /// c in N·m.
    pub coulomb_n_m: f64,
    /// v in N·m·s/rad.
    pub viscous_n_m_s_per_rad: f64,
    /// μ, the mean of both directions of power.
    pub load_mean: f64,
    /// δ, half of their difference.
    pub load_difference: f64,
    /// h in rad: after a reversal z has completed the fraction 1 − 1/e of its change within this angle.
    pub relaxation_rad: f64,
    /// Residual of the model in the friction torques of the bench over speed, torque and direction of power,
    /// root mean square, N·m at the output.
    pub residual_rms_n_m: f64,
    /// The same residual, largest, N·m.
    pub residual_max_n_m: f64,
    /// Residual in the hysteresis loop for rotations within h, root mean square, N·m.
    pub relaxation_residual_rms_n_m: f64,
}

/// Torques of the fit relative to the rated one; the lines of losses are valid for any torque between.
const SHARES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
/// h in rad of a joint without hysteresis.
const SUDDEN: f64 = 1e-9;

/// One equilibrium at the output with positive speed: speed (rad/s), torque of the motor along the motion
/// (N·m), friction (N·m).
struct Balance {
    speed: f64,
    motor: f64,
    friction: f64,
}

fn balances(losses: &[LossLine], ratio: f64, rated: f64) -> Vec<Balance> {
    let ratio = ratio.abs();
    let mut all = Vec::with_capacity(2 * losses.len() * SHARES.len());
    for line in losses {
        let speed = line.input_speed_rad_per_s / ratio;
        for load in SHARES.map(|share| share * rated) {
            let driving = load / line.efficiency[0] + ratio * line.friction_n_m[0];
            let driven = ratio * line.friction_n_m[1] - load * line.efficiency[1];
            all.push(Balance { speed, motor: driving, friction: driving - load });
            // A small load moves the joint only with the motor's help; that range was not computed.
            if driven < 0.0 {
                all.push(Balance { speed, motor: driven, friction: driven + load });
            }
        }
    }
    all
}

impl RunningFriction {
    /// Least squares with non-negative parameters, over the lines of losses and one loop of the bench;
    /// `constant`: with the friction c, otherwise with the four parameters only.
    pub fn fit(
        losses: &[LossLine],
        (hysteresis, points): (&Hysteresis, &[LoopPoint]),
        ratio: f64,
        rated: f64,
        constant: bool,
    ) -> RunningFriction {
        let all = balances(losses, ratio, rated);
        let column = |of: &dyn Fn(&Balance) -> f64| all.iter().map(of).collect::<Vec<f64>>();
        // Columns are scaled to the same size, so that sweeps over single weights converge.
        let fastest = all.iter().map(|b| b.speed).fold(f64::MIN_POSITIVE, f64::max);
        let columns = [
            column(&|_| f64::from(u8::from(constant))),
            column(&|b| b.speed / fastest),
            column(&|b| b.motor.max(0.0) / rated),
            column(&|b| (-b.motor).max(0.0) / rated),
        ];
        let target = column(&|b| b.friction);
        let weights = non_negative(&columns, &target);
        let left: Vec<f64> = (0..all.len())
            .map(|row| target[row] - columns.iter().zip(&weights).map(|(c, w)| c[row] * w).sum::<f64>())
            .collect();
        let (driving, driven) = (weights[2] / rated, weights[3] / rated);
        let (relaxation_rad, relaxation_residual_rms_n_m) = relaxation(hysteresis, points, rated);
        RunningFriction {
            coulomb_n_m: weights[0],
            viscous_n_m_s_per_rad: weights[1] / fastest,
            load_mean: 0.5 * (driving + driven),
            load_difference: 0.5 * (driving - driven),
            relaxation_rad,
            residual_rms_n_m: root_mean_square(&left),
            residual_max_n_m: left.iter().fold(0.0, |most: f64, x| most.max(x.abs())),
            relaxation_residual_rms_n_m,
        }
    }

    /// Constant in N·m and viscous friction in N·m·s/rad of the joint driven by a motor without load, for
    /// programs without load-dependent friction: the motor's torque is then the friction itself, τ = (c + v
    /// ω)/(1 − μ − δ).
    pub fn without_load(&self) -> [f64; 2] {
        let own = 1.0 - self.load_mean - self.load_difference;
        [self.coulomb_n_m / own, self.viscous_n_m_s_per_rad / own]
    }

    /// Friction in N·m against a positive speed of the output (rad/s), with the motor's torque along it (N·m
    /// at the output).
    pub fn torque(&self, speed: f64, motor: f64) -> f64 {
        self.coulomb_n_m
            + self.viscous_n_m_s_per_rad * speed
            + self.load_mean * motor.abs()
            + self.load_difference * motor
    }
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// h and the residual of the loop. After a reversal the elements of the hysteresis change linearly, each within
/// 2 d_j; an exponential with h = Σ T_j d_j/Σ T_j has the same work (T_j: slip torque at half the rated load).
/// The loop is then T − G(φ) = (a + b |G|) z with non-negative a and b.
fn relaxation(hysteresis: &Hysteresis, points: &[LoopPoint], rated: f64) -> (f64, f64) {
    let held = |e: &SlipElement| e.torque(0.5 * rated);
    let all: f64 = hysteresis.elements.iter().map(held).sum();
    let bent: f64 = hysteresis.elements.iter().map(|e| held(e) * e.slip_rad).sum();
    // Without hysteresis the sign changes immediately.
    let h = if all > 0.0 { bent / all } else { SUDDEN };
    let elastic: Vec<f64> = points.iter().map(|p| hysteresis.elastic(p.angle)).collect();
    let target: Vec<f64> = points.iter().zip(&elastic).map(|(p, g)| p.torque - g).collect();
    let (mut z, mut last) = (0.0, points.first().map_or(0.0, |p| p.angle));
    let mut states = vec![0.0; points.len()];
    // The second cycle does not depend on the initial state.
    for _ in 0..2 {
        for (point, state) in points.iter().zip(&mut states) {
            let change = point.angle - last;
            let sign = if change < 0.0 { -1.0 } else { 1.0 };
            z = sign + (z - sign) * (-change.abs() / h).exp();
            last = point.angle;
            *state = z;
        }
    }
    let loaded: Vec<f64> = states.iter().zip(&elastic).map(|(z, g)| z * g.abs() / rated).collect();
    let columns = [states, loaded];
    let weights = non_negative(&columns, &target);
    let rest: Vec<f64> = (0..target.len())
        .map(|row| target[row] - columns.iter().zip(&weights).map(|(c, w)| c[row] * w).sum::<f64>())
        .collect();
    (h, root_mean_square(&rest))
}
