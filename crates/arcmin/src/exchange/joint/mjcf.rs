//! MuJoCo.

use std::fmt::Write as _;

use super::{JointExport, JointState, escaped, number};
use crate::units::ARCMIN;

impl JointExport {
    /// A model for MuJoCo 4 that holds one body for each age. Each body has two hinges at one place: `drive`
    /// with what turns before the elastic part as armature, and `gear` for wind-up and backlash. Fixed tendons
    /// over the gear hinge are its springs: one that pulls beyond a length (`springlength`) for each piece of the
    /// torsion curve of either side, and one that yields (`springyield`) for each slip element.
    pub fn mjcf(&self) -> String {
        let mut text = String::new();
        let name = self.identifier();
        let _ = writeln!(text, "<mujoco model=\"{name}\">");
        for line in self.stamps() {
            let _ = writeln!(text, "  <!-- {} -->", escaped(&line));
        }
        let _ = writeln!(
            text,
            "  <!-- Copy the body of one age and its tendons. Hinge 'drive' is where your motor acts, as torque at \
             the output\n       (motor torque x {}); 'gear' is wind-up and backlash. Elements 'slip' need MuJoCo 4 \
             (springyield): without\n       them the joint has no hysteresis but is right otherwise. The gear's \
             damping is chosen for the time step;\n       with a smaller one divide it alike. Units: rad, N m, kg \
             m2, s. -->",
            number(self.ratio)
        );
        let _ = writeln!(text, "  <compiler angle=\"radian\"/>");
        let _ = writeln!(
            text,
            "  <option timestep=\"{}\" integrator=\"implicitfast\" gravity=\"0 0 0\"/>",
            number(self.timestep_s)
        );
        text.push_str("  <worldbody>\n");
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

    fn body(&self, text: &mut String, index: usize, state: &JointState) {
        let label = state.label();
        let curve = &state.hysteresis.curve;
        let arcmin = |rad: f64| format!("{:.4}", rad / ARCMIN);
        let per_arcmin = |k: f64| format!("{:.2}", k * ARCMIN);
        let _ = writeln!(
            text,
            "    <!-- After {} h: lost motion {}', backlash {}', stiffness {} N m/arcmin (as `arcmin rig` \
             measures them);\n         fit: dead band {}', K1 K2 K3 = {}, {}, {} N m/arcmin up to T1 = {} and T2 = \
             {} N m;\n         hysteresis fitted within {} N m (rms), {} N m at most. Running: efficiency {} at \
             rated load,\n         friction without load {} N m. -->",
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
        );
        let reach = self.reach(state);
        let radius = 0.5;
        // A flange of the given mass and inertia; the other two moments are those of a flat disc.
        let across = 0.5 * self.inertia.output_kg_m2;
        let _ = writeln!(
            text,
            "    <body name=\"flange_{label}\" pos=\"{} 0 0\">\n      <inertial pos=\"0 0 0\" mass=\"{}\" \
             diaginertia=\"{} {} {}\"/>",
            number(radius * index as f64),
            number(self.inertia.output_kg),
            number(across),
            number(across),
            number(self.inertia.output_kg_m2)
        );
        let _ = writeln!(
            text,
            "      <joint name=\"drive_{label}\" type=\"hinge\" axis=\"0 0 1\" armature=\"{}\" frictionloss=\"{}\"/>",
            number(self.reflected_inertia()),
            number(state.running_friction(self.ratio))
        );
        let _ = writeln!(
            text,
            "      <joint name=\"gear_{label}\" type=\"hinge\" axis=\"0 0 1\" limited=\"true\" range=\"{} {}\" \
             armature=\"0\" damping=\"{}\"/>",
            number(-reach),
            number(reach),
            number(state.damping(self.timestep_s))
        );
        let _ = writeln!(
            text,
            "      <geom type=\"cylinder\" size=\"0.1 0.02\" mass=\"0\" contype=\"0\" conaffinity=\"0\"/>\n    </body>"
        );
    }

    /// Range in rad of the gear hinge, which no sensible load leaves.
    fn reach(&self, state: &JointState) -> f64 {
        let curve = &state.hysteresis.curve;
        state.hysteresis.zero_rad.abs()
            + 4.0 * curve.corners()[1]
            + 2.0 * self.rated_torque_n_m / curve.stiffness_n_m_per_rad[2]
    }

    /// Springs of one age. The springs of a torsion curve that stiffens add up; each is slack up to its corner, and
    /// on the whole other side.
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
        let elements = state.hysteresis.elements.iter().map(|element| (element, state.slip_torque(element)));
        for (index, (element, torque)) in elements.filter(|(_, torque)| *torque > 0.0).enumerate() {
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
