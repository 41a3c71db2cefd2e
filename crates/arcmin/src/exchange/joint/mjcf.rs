//! MuJoCo.

use std::fmt::Write as _;

use super::{JointExport, JointState, escaped, number};
use crate::units::ARCMIN;

/// Text at the head of the file.
const HEAD: &str = "Copy the bodies of one age and its tendons. Your motor acts on hinge 'drive', as torque at the \
                    output\n       (motor torque x ratio); 'gear' is wind-up and backlash. Elements 'slip' need MuJoCo 4 \
                    (springyield): without\n       them the joint has no hysteresis but is right otherwise. Units: rad, N m, \
                    kg m2, s.\n       The damping of 'gear' acts while all slip elements stick; larger oscillations of an \
                    arm are damped by these\n       elements. Numeric 'friction': constant, viscous, mean and difference of \
                    the friction per motor torque, relaxation;\n       'slip': slip torque and its growth per elastic torque \
                    of each element. joint_mujoco.py updates both with the load.";

impl JointExport {
    /// A model for MuJoCo 4 with two nested bodies for each age: a rotor on the hinge `drive`, with the parts
    /// before the elastic element as armature, and the flange on the hinge `gear` for wind-up and backlash.
    /// Fixed tendons over the gear hinge are its springs: for each section of the torsion curve of either side
    /// one that acts beyond a length (`springlength`), and for each slip element one that yields
    /// (`springyield`).
    ///
    /// MuJoCo integrates springs explicitly. The inertia of the flange alone is too small for the time step of
    /// a robot; therefore the wind-up has an armature that represents the arm. If a step would require one
    /// above the load of the export, the integrator `discrete` is used instead, which integrates springs
    /// implicitly and damps their oscillations.
    pub fn mjcf(&self) -> String {
        let mut text = String::new();
        let name = self.identifier();
        let _ = writeln!(text, "<mujoco model=\"{name}\">");
        for line in self.stamps() {
            let _ = writeln!(text, "  <!-- {} -->", escaped(&line));
        }
        let _ = writeln!(text, "  <!-- {HEAD} -->\n  <compiler angle=\"radian\"/>");
        let _ = writeln!(
            text,
            "  <option timestep=\"{}\" integrator=\"{}\" gravity=\"0 0 0\"/>",
            number(self.timestep_s),
            if self.steps_explicitly() { "implicitfast" } else { "discrete" }
        );
        text.push_str("  <custom>\n");
        for state in &self.states {
            self.numerics(&mut text, state);
        }
        text.push_str("  </custom>\n  <worldbody>\n");
        for (index, state) in self.states.iter().enumerate() {
            self.body(&mut text, index, state);
        }
        text.push_str("  </worldbody>\n  <tendon>\n");
        for state in &self.states {
            self.tendons(&mut text, state);
        }
        text.push_str("  </tendon>\n  <actuator>\n");
        for state in &self.states {
            let label = state.label();
            let _ = writeln!(text, "    <motor name=\"motor_{label}\" joint=\"drive_{label}\"/>");
        }
        text.push_str("  </actuator>\n  <sensor>\n");
        for state in &self.states {
            let label = state.label();
            let _ = writeln!(text, "    <jointpos name=\"wind_up_{label}\" joint=\"gear_{label}\"/>");
        }
        text.push_str("  </sensor>\n</mujoco>\n");
        text
    }

    /// Python module that updates the load-dependent friction of the loaded model in every step.
    pub fn mujoco_python(&self) -> String {
        let stamps = self.stamps().into_iter().take(2);
        let head: String = stamps.map(|line| format!("# {}\n", line.replace('\n', " "))).collect();
        head + include_str!("mujoco.py")
    }

    /// Whether all ages can be integrated explicitly with at most the load of the export.
    fn steps_explicitly(&self) -> bool {
        self.states.iter().all(|state| state.inertia_for(self.timestep_s) <= self.load_inertia_kg_m2)
    }

    fn numerics(&self, text: &mut String, state: &JointState) {
        let (label, friction) = (state.label(), &state.friction);
        let values = [
            friction.coulomb_n_m,
            friction.viscous_n_m_s_per_rad,
            friction.load_mean,
            friction.load_difference,
            friction.relaxation_rad,
        ];
        let mut numeric = |name: &str, values: Vec<f64>| {
            let data: Vec<String> = values.into_iter().map(number).collect();
            let _ = writeln!(text, "    <numeric name=\"{name}_{label}\" data=\"{}\"/>", data.join(" "));
        };
        numeric("friction", values.to_vec());
        let slips = state.slipping().flat_map(|(element, _)| [element.torque_n_m, element.torque_per_load]);
        let slips: Vec<f64> = slips.collect();
        // MuJoCo does not accept an empty numeric; a loop without hysteresis has no slip elements.
        if !slips.is_empty() {
            numeric("slip", slips);
        }
    }

    fn body(&self, text: &mut String, index: usize, state: &JointState) {
        let label = state.label();
        let curve = &state.hysteresis.curve;
        let friction = &state.friction;
        let arcmin = |rad: f64| format!("{:.4}", rad / ARCMIN);
        let per_arcmin = |k: f64| format!("{:.2}", k * ARCMIN);
        let own = self.inertia.output_kg_m2;
        let needed = state.inertia_for(self.timestep_s);
        let stand_in = if self.steps_explicitly() { f64::max(0.0, needed - own) } else { 0.0 };
        let _ = writeln!(
            text,
            "    <!-- After {} h: lost motion {}', backlash {}', stiffness {} N m/arcmin (as `arcmin rig` \
             measures them);\n         fit: dead band {}', K1 K2 K3 = {}, {}, {} N m/arcmin up to T1 = {} and T2 = \
             {} N m;\n         hysteresis fitted within {} N m (rms), {} N m at most. Running: efficiency {} at \
             rated load,\n         friction without load {} N m at rated speed; friction that grows with load fitted \
             within {} N m (rms), {} N m\n         at most.",
            number(state.hours),
            arcmin(state.lost_motion_rad),
            arcmin(state.backlash_rad),
            per_arcmin(state.stiffness_n_m_per_rad),
            arcmin(2.0 * curve.half_gap_rad),
            per_arcmin(curve.stiffness_n_m_per_rad[0]),
            per_arcmin(curve.stiffness_n_m_per_rad[1]),
            per_arcmin(curve.stiffness_n_m_per_rad[2]),
            number(curve.torques_n_m[0]),
            number(curve.torques_n_m[1]),
            number(state.hysteresis.residual_rms_n_m),
            number(state.hysteresis.residual_max_n_m),
            number(state.efficiency),
            number(state.running_friction(self.ratio)),
            number(friction.residual_rms_n_m),
            number(friction.residual_max_n_m),
        );
        if stand_in > 0.0 {
            let _ = writeln!(
                text,
                "         The armature of 'gear' stands in for your arm: a step of {} s needs {} kg m2 there. Set it \
                 to 0 where arm J\n         and motor side M give J M / (J + M) above that (M = {} kg m2, or any \
                 where the motor is held).",
                number(self.timestep_s),
                number(needed),
                number(self.reflected_inertia())
            );
        }
        text.push_str("    -->\n");
        let reach = self.reach(state);
        let radius = 0.5;
        let _ = writeln!(
            text,
            "    <body name=\"rotor_{label}\" pos=\"{} 0 0\">\n      <!-- Crankshafts and discs; what turns is the \
             armature of the hinge. -->\n      <inertial pos=\"0 0 0\" mass=\"{}\" diaginertia=\"1e-6 1e-6 \
             1e-6\"/>\n      <joint name=\"drive_{label}\" type=\"hinge\" axis=\"0 0 1\" armature=\"{}\" \
             frictionloss=\"{}\" damping=\"{}\"/>",
            number(radius * index as f64),
            number(self.inertia.gear_kg),
            number(self.reflected_inertia()),
            number(friction.without_load()[0]),
            number(friction.without_load()[1])
        );
        // A flange with the given mass and inertia; the other two moments are those of a flat disc.
        let across = number(0.5 * own);
        let _ = writeln!(
            text,
            "      <body name=\"flange_{label}\">\n        <inertial pos=\"0 0 0\" mass=\"{}\" diaginertia=\"{across} \
             {across} {}\"/>\n        <joint name=\"gear_{label}\" type=\"hinge\" axis=\"0 0 1\" limited=\"true\" \
             range=\"{} {}\" armature=\"{}\" damping=\"{}\"/>\n        <geom type=\"cylinder\" size=\"0.1 0.02\" \
             mass=\"0\" contype=\"0\" conaffinity=\"0\"/>\n      </body>\n    </body>",
            number(self.inertia.output_kg),
            number(own),
            number(-reach),
            number(reach),
            number(stand_in),
            number(state.rest_damping(own + stand_in))
        );
    }

    /// Range in rad of the gear hinge, beyond any reasonable load.
    fn reach(&self, state: &JointState) -> f64 {
        let curve = &state.hysteresis.curve;
        state.hysteresis.zero_rad.abs()
            + 4.0 * curve.corners()[1]
            + 2.0 * self.rated_torque_n_m / curve.stiffness_n_m_per_rad[2]
    }

    /// Springs of one age. The springs of a stiffening torsion curve act in parallel; each is slack up to its
    /// corner, and on the entire other side.
    fn tendons(&self, text: &mut String, state: &JointState) {
        let label = state.label();
        let slack = 2.0 * self.reach(state);
        let zero = state.hysteresis.zero_rad;
        for (curve, side) in state.hysteresis.sides.iter().zip(["up", "down"]) {
            let [k1, k2, k3] = curve.stiffness_n_m_per_rad;
            let [first, second] = curve.corners();
            let pieces = [(curve.half_gap_rad, k1), (first, k2 - k1), (second, k3 - k2)];
            for (index, (from, stiffness)) in pieces.into_iter().enumerate().filter(|(_, (_, k))| *k > 0.0) {
                let [low, high] = if side == "up" { [-slack, zero + from] } else { [zero - from, slack] };
                let _ = writeln!(
                    text,
                    "    <fixed name=\"{side}{}_{label}\" springlength=\"{} {}\" stiffness=\"{}\"><joint \
                     joint=\"gear_{label}\" coef=\"1\"/></fixed>",
                    index + 1,
                    number(low),
                    number(high),
                    number(stiffness)
                );
            }
        }
        for (index, (element, torque)) in state.slipping().enumerate() {
            let _ = writeln!(
                text,
                "    <fixed name=\"slip{}_{label}\" springlength=\"0 0\" stiffness=\"{}\" springyield=\"{}\"><joint \
                 joint=\"gear_{label}\" coef=\"1\"/></fixed>",
                index + 1,
                number(torque / element.slip_rad),
                number(element.slip_rad)
            );
        }
    }
}
