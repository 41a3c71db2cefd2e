//! URDF and SDFormat.

use std::fmt::Write as _;

use super::{JointExport, JointState, escaped, number};
use crate::units::ARCMIN;

impl JointExport {
    /// URDF: for each age a drive joint with damping, friction and transmission, and a second joint whose
    /// limits are the dead band. URDF has no element for stiffness, which is given in a comment.
    pub fn urdf(&self) -> String {
        let name = self.identifier();
        let mut text = format!("<?xml version=\"1.0\"?>\n<robot name=\"{name}\">\n");
        for line in self.stamps() {
            let _ = writeln!(text, "  <!-- {} -->", escaped(&line));
        }
        text.push_str("  <!-- URDF has no element for stiffness: see the comment of each age. Units: rad, N m, kg m2, s. -->\n");
        text.push_str("  <link name=\"base\"/>\n");
        let inertia = &self.inertia;
        let link = |text: &mut String, name: &str, mass: f64, about_axis: f64| {
            let across = number(0.5 * about_axis);
            let _ = writeln!(
                text,
                "  <link name=\"{name}\">\n    <inertial>\n      <mass value=\"{}\"/>\n      <inertia ixx=\"{across}\" \
                 ixy=\"0\" ixz=\"0\" iyy=\"{across}\" iyz=\"0\" izz=\"{}\"/>\n    </inertial>\n  </link>",
                number(mass),
                number(about_axis)
            );
        };
        let speed = number(self.rated_input_speed_rad_per_s / self.ratio.abs());
        for state in &self.states {
            let (label, [low, high]) = (state.label(), state.hysteresis.dead_band());
            let _ = writeln!(text, "  <!-- {} -->", self.summary_line(state));
            link(&mut text, &format!("rotor_{label}"), inertia.gear_kg, self.reflected_inertia());
            link(&mut text, &format!("flange_{label}"), inertia.output_kg, inertia.output_kg_m2);
            let _ = writeln!(
                text,
                "  <joint name=\"drive_{label}\" type=\"continuous\">\n    <parent link=\"base\"/>\n    <child \
                 link=\"rotor_{label}\"/>\n    <axis xyz=\"0 0 1\"/>\n    <limit effort=\"{}\" velocity=\"{speed}\"/>\n    \
                 <dynamics damping=\"{}\" friction=\"{}\"/>\n  </joint>",
                number(self.rated_torque_n_m),
                number(state.friction.without_load()[1]),
                number(state.friction.without_load()[0])
            );
            let _ = writeln!(
                text,
                "  <joint name=\"gear_{label}\" type=\"revolute\">\n    <parent link=\"rotor_{label}\"/>\n    <child \
                 link=\"flange_{label}\"/>\n    <axis xyz=\"0 0 1\"/>\n    <limit lower=\"{}\" upper=\"{}\" effort=\"{}\" \
                 velocity=\"{speed}\"/>\n    <dynamics damping=\"0\" friction=\"{}\"/>\n  </joint>",
                number(low),
                number(high),
                number(self.rated_torque_n_m),
                number(state.hysteresis.friction_torque())
            );
            let _ = writeln!(
                text,
                "  <transmission name=\"reducer_{label}\">\n    <type>transmission_interface/SimpleTransmission</type>\n    \
                 <joint name=\"drive_{label}\">\n      <hardwareInterface>hardware_interface/EffortJointInterface\
                 </hardwareInterface>\n    </joint>\n    <actuator name=\"motor_{label}\">\n      \
                 <mechanicalReduction>{}</mechanicalReduction>\n    </actuator>\n  </transmission>",
                number(self.ratio)
            );
        }
        text.push_str("</robot>\n");
        text
    }

    /// SDFormat 1.10: for each age a model with the drive, and a joint whose limits are the dead band, with K₃
    /// as the stiffness of its stops and the damping of [`JointExport::damping`].
    pub fn sdf(&self) -> String {
        let mut text = String::from("<?xml version=\"1.0\"?>\n<sdf version=\"1.10\">\n");
        for line in self.stamps() {
            let _ = writeln!(text, "  <!-- {} -->", escaped(&line));
        }
        let name = self.identifier();
        let _ = writeln!(text, "  <world name=\"{name}\">");
        for state in &self.states {
            self.sdf_model(&mut text, state);
        }
        text.push_str("  </world>\n</sdf>\n");
        text
    }

    fn sdf_model(&self, text: &mut String, state: &JointState) {
        let (name, label) = (self.identifier(), state.label());
        let inertia = &self.inertia;
        let [low, high] = state.hysteresis.dead_band();
        let link = |name: &str, mass: f64, about_axis: f64| {
            let across = number(0.5 * about_axis);
            format!(
                "      <link name=\"{name}\">\n        <inertial>\n          <mass>{}</mass>\n          <inertia>\
                 <ixx>{across}</ixx><iyy>{across}</iyy><izz>{}</izz><ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia>\n        \
                 </inertial>\n      </link>\n",
                number(mass),
                number(about_axis)
            )
        };
        let _ =
            writeln!(text, "    <!-- {} -->\n    <model name=\"{name}_{label}\">", self.summary_line(state));
        text.push_str(&link("rotor", inertia.gear_kg, self.reflected_inertia()));
        text.push_str(&link("flange", inertia.output_kg, inertia.output_kg_m2));
        let speed = number(self.rated_input_speed_rad_per_s / self.ratio.abs());
        let _ = write!(
            text,
            "      <joint name=\"drive\" type=\"revolute\">\n        <parent>world</parent>\n        <child>rotor</child>\n        \
             <axis>\n          <xyz>0 0 1</xyz>\n          <limit><lower>-1e16</lower><upper>1e16</upper>\
             <effort>{}</effort><velocity>{speed}</velocity></limit>\n          <dynamics><damping>{}</damping>\
             <friction>{}</friction></dynamics>\n        </axis>\n      </joint>\n",
            number(self.rated_torque_n_m),
            number(state.friction.without_load()[1]),
            number(state.friction.without_load()[0])
        );
        let _ = write!(
            text,
            "      <joint name=\"gear\" type=\"revolute\">\n        <parent>rotor</parent>\n        <child>flange</child>\n        \
             <axis>\n          <xyz>0 0 1</xyz>\n          <limit><lower>{}</lower><upper>{}</upper><effort>{}</effort>\
             <velocity>{speed}</velocity><stiffness>{}</stiffness><dissipation>{}</dissipation></limit>\n          \
             <dynamics><damping>0</damping><friction>{}</friction></dynamics>\n        </axis>\n      </joint>\n    \
             </model>\n",
            number(low),
            number(high),
            number(self.rated_torque_n_m),
            number(state.hysteresis.curve.stiffness_n_m_per_rad[2]),
            number(self.damping(state)),
            number(state.hysteresis.friction_torque())
        );
    }

    /// One age in one sentence, for comments.
    fn summary_line(&self, state: &JointState) -> String {
        let curve = &state.hysteresis.curve;
        let k = curve.stiffness_n_m_per_rad.map(|k| number(k * ARCMIN));
        format!(
            "After {} h: lost motion {:.4}', backlash {:.4}', stiffness {} N m/arcmin; K1 K2 K3 = {}, {}, {} N m/arcmin \
             with T1 = {}, T2 = {} N m; efficiency {} at rated load",
            number(state.hours),
            state.lost_motion_rad / ARCMIN,
            state.backlash_rad / ARCMIN,
            number(state.stiffness_n_m_per_rad * ARCMIN),
            k[0],
            k[1],
            k[2],
            number(curve.torques_n_m[0]),
            number(curve.torques_n_m[1]),
            number(state.efficiency)
        )
    }
}
