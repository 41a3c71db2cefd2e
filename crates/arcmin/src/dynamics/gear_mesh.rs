use crate::contact::Damping;
use crate::geometry::{Vec2, unit};
use crate::machine::Machine;

/// Involute meshes of the sun with all planets, which share one deflection as the planets' centres sit on a
/// rigid carrier.
///
/// Deflection along the line of action: e = r_b1 (θ_s − θ_c) + r_b2 (θ_k − θ_c). Each mesh is a spring
/// k (1 + ε cos(z_1 (θ_s − θ_c) + z_1 γ_p)) with damper and backlash j: free while |e| < j/2.
#[derive(Debug, Clone)]
pub struct GearMesh {
    planets: f64,
    stiffness: f64,
    variation: f64,
    damping: f64,
    half_backlash: f64,
    sun_teeth: f64,
    /// Σ e(z_1 γ_p): how the stiffness variations of the meshes add up.
    phase_sum: Vec2,
    pub sun_base_radius: f64,
    pub planet_base_radius: f64,
}

/// Force along the line of action of all meshes together, with tangents and energy.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MeshForce {
    /// N, positive where the sun's tooth drives.
    pub force: f64,
    /// ∂F/∂e in N/m and ∂F/∂ė in N·s/m.
    pub stiffness: f64,
    pub damping: f64,
    /// J.
    pub stored: f64,
    /// W.
    pub dissipation: f64,
    /// ∂F/∂σ in N/rad, ∂U/∂σ in N·m and ∂²U/∂σ² in N·m/rad for the mesh phase σ = θ_s − θ_c.
    pub force_by_phase: f64,
    pub torque: f64,
    pub torque_by_phase: f64,
}

/// Depth over which damping sets in behind a backlash, m. Without it the force would jump on contact.
const DAMPING_RAMP: f64 = 1e-6;

impl GearMesh {
    pub fn new(machine: &Machine) -> GearMesh {
        let stage = &machine.gear_stage;
        let count = machine.crankshafts.count;
        let teeth = stage.sun_teeth as f64;
        GearMesh {
            planets: count as f64,
            stiffness: stage.mesh_stiffness,
            variation: stage.mesh_stiffness_variation,
            damping: stage.mesh_damping,
            half_backlash: 0.5 * stage.backlash,
            sun_teeth: teeth,
            phase_sum: (0..count)
                .map(|k| {
                    unit(
                        teeth
                            * crate::machine::Kinematics::crankshaft_angle(
                                machine.crankshafts.first_angle,
                                k,
                                count,
                            ),
                    )
                })
                .sum(),
            sun_base_radius: stage.sun_base_radius(),
            planet_base_radius: stage.planet_base_radius(),
        }
    }

    /// Forces at deflection e (m), its rate ė (m/s) and mesh phase σ (rad).
    pub fn react(&self, deflection: f64, rate: f64, phase: f64) -> MeshForce {
        // Signed deflection beyond the backlash.
        let overlap = if deflection.abs() <= self.half_backlash {
            return MeshForce::default();
        } else {
            deflection - self.half_backlash.copysign(deflection)
        };
        // Sum of the stiffnesses and its first two derivatives with respect to σ.
        let (mut k, mut k1, mut k2) = (self.planets * self.stiffness, 0.0, 0.0);
        if self.variation != 0.0 {
            let wave = unit(self.sun_teeth * phase);
            let amplitude = self.stiffness * self.variation;
            let (cos, sin) = (
                wave.x * self.phase_sum.x - wave.y * self.phase_sum.y,
                wave.y * self.phase_sum.x + wave.x * self.phase_sum.y,
            );
            k += amplitude * cos;
            k1 = -amplitude * self.sun_teeth * sin;
            k2 = -amplitude * self.sun_teeth * self.sun_teeth * cos;
        }
        let (mut damping, mut damping_slope) = (self.planets * self.damping, 0.0);
        if self.half_backlash > 0.0 {
            let ramp = Damping { coefficient: damping, ramp_depth: DAMPING_RAMP };
            let x = (overlap.abs() / ramp.ramp_depth).min(1.0);
            damping = ramp.coefficient * x * x * (3.0 - 2.0 * x);
            damping_slope = if x < 1.0 {
                ramp.coefficient * 6.0 * x * (1.0 - x) / ramp.ramp_depth * overlap.signum()
            } else {
                0.0
            };
        }
        let elastic = k * overlap;
        let stored = 0.5 * k * overlap * overlap;
        let force = elastic + damping * rate;
        let (torque, torque_by_phase) = (0.5 * k1 * overlap * overlap, 0.5 * k2 * overlap * overlap);
        if self.half_backlash > 0.0 && force * overlap <= 0.0 {
            // Oil between parting flanks does not pull them together.
            return MeshForce {
                stored,
                dissipation: -elastic * rate,
                torque,
                torque_by_phase,
                ..MeshForce::default()
            };
        }
        MeshForce {
            force,
            stiffness: k + damping_slope * rate,
            damping,
            stored,
            dissipation: damping * rate * rate,
            force_by_phase: k1 * overlap,
            torque,
            torque_by_phase,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(backlash: f64, variation: f64) -> GearMesh {
        let mut machine = crate::templates::tao2024();
        machine.gear_stage.backlash = backlash;
        machine.gear_stage.mesh_stiffness_variation = variation;
        GearMesh::new(&machine)
    }

    #[test]
    fn backlash_is_free_and_damping_never_pulls() {
        let mesh = mesh(20e-6, 0.0);
        assert_eq!(mesh.react(9e-6, 1.0, 0.0), MeshForce::default());
        assert!((mesh.react(12e-6, 0.0, 0.0).force - 2.0 * 2e8 * 2e-6).abs() < 1e-6);
        assert!((mesh.react(-12e-6, 0.0, 0.0).force + 2.0 * 2e8 * 2e-6).abs() < 1e-6);
        assert_eq!(mesh.react(12e-6, -10.0, 0.0).force, 0.0);
        assert_eq!(mesh.react(-12e-6, 10.0, 0.0).force, 0.0);
    }

    /// Force and phase torque are the two derivatives of one energy, and the tangents are theirs.
    #[test]
    fn force_and_torque_derive_from_the_energy() {
        let mesh = mesh(4e-6, 0.2);
        let h = 1e-9;
        for (deflection, phase) in [(5e-6, 0.1), (-6e-6, 0.33), (9e-6, 1.234)] {
            let here = mesh.react(deflection, 0.0, phase);
            let by_deflection = |f: fn(&MeshForce) -> f64| {
                (f(&mesh.react(deflection + h, 0.0, phase)) - f(&mesh.react(deflection - h, 0.0, phase)))
                    / (2.0 * h)
            };
            let g = 1e-6;
            let by_phase = |f: fn(&MeshForce) -> f64| {
                (f(&mesh.react(deflection, 0.0, phase + g)) - f(&mesh.react(deflection, 0.0, phase - g)))
                    / (2.0 * g)
            };
            let close = |a: f64, b: f64, scale: f64| assert!((a - b).abs() < 1e-5 * scale, "{a} {b}");
            close(by_deflection(|m| m.stored), here.force, 1e3);
            close(by_deflection(|m| m.force), here.stiffness, 4e8);
            close(by_deflection(|m| m.torque), here.force_by_phase, 1e4);
            close(by_phase(|m| m.stored), here.torque, 1e-2);
            close(by_phase(|m| m.torque), here.torque_by_phase, 1.0);
        }
    }
}
