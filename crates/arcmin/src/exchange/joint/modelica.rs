//! Modelica and Simscape.

use std::fmt::Write as _;

use super::{JointExport, JointState, number};
use crate::units::ARCMIN;

/// Efficiencies in Modelica must be positive.
const LEAST_EFFICIENCY: f64 = 1e-3;

fn drivable(row: &[f64; 5]) -> [f64; 5] {
    let [speed, driving, driven, first, second] = *row;
    [speed, driving, driven.max(LEAST_EFFICIENCY), first, second]
}

impl JointExport {
    /// A Modelica package: for each age a record with the parameters of
    /// `Modelica.Mechanics.Rotational.Components.Gearbox`, and a gearbox that uses them.
    pub fn modelica(&self) -> String {
        let name = self.identifier();
        let mut text = String::new();
        for line in self.stamps() {
            let _ = writeln!(text, "// {}", line.replace('\n', " "));
        }
        let _ = writeln!(
            text,
            "package {name} \"Reducer as a joint, from new to worn\"\n  record Parameters \"As \
             Modelica.Mechanics.Rotational.Components.Gearbox takes them\"\n    extends Modelica.Icons.Record;\n    \
             parameter Real ratio \"Transmission ratio flange_a.phi/flange_b.phi\";\n    parameter Real lossTable[:, 5] \
             \"|w_a|, eta_mf1, eta_mf2, |tau_bf1|, |tau_bf2| (at flange_a)\";\n    parameter \
             Modelica.Units.SI.RotationalSpringConstant c \"Stiffness at flange_b\";\n    parameter \
             Real zeta \"Damping ratio of a swing, from the hysteresis\";\n    parameter Modelica.Units.SI.Inertia J_load \
             \"Inertia that the damping d is meant for\";\n    parameter \
             Modelica.Units.SI.RotationalDampingConstant d \"Damping at flange_b: 2*zeta*sqrt(c*J_load)\";\n    parameter \
             Modelica.Units.SI.Angle b \"Total backlash at flange_b\";\n    parameter Modelica.Units.SI.Inertia J_a \
             \"Sun, crankshafts and discs, at flange_a\";\n    parameter Modelica.Units.SI.Inertia J_b \"Output \
             flange\";\n  end Parameters;\n"
        );
        for state in &self.states {
            let label = state.label();
            let rows: Vec<String> =
                self.loss_rows(state).iter().map(|row| drivable(row).map(number).join(", ")).collect();
            if !state.can_be_driven() {
                text.push_str("  // The output cannot drive the input; lossTable has the smallest efficiency that Modelica permits: eta_mf2 = 0.001.\n");
            }
            let _ = writeln!(
                text,
                "  record {label} \"After {} h: lost motion {:.4}', stiffness {} N.m/arcmin\"\n    extends Parameters(\n      \
                 ratio = {},\n      lossTable = [{}],\n      c = {},\n      zeta = {},\n      J_load = {},\n      d = {},\n      b = {},\n      J_a = {},\n      J_b = \
                 {});\n  end {label};\n",
                number(state.hours),
                state.lost_motion_rad / ARCMIN,
                number(state.stiffness_n_m_per_rad * ARCMIN),
                number(self.ratio),
                rows.join(";\n                   "),
                number(state.hysteresis.curve.stiffness_n_m_per_rad[2]),
                number(state.damping_ratio),
                number(self.load_inertia_kg_m2),
                number(self.damping(state)),
                number(2.0 * state.hysteresis.curve.half_gap_rad),
                number(self.inertia.sun_kg_m2 + self.inertia.gear_kg_m2),
                number(self.inertia.output_kg_m2)
            );
        }
        let first = self.states.first().map_or_else(|| "h0".to_owned(), JointState::label);
        let _ = writeln!(
            text,
            "  model Reducer \"Gearbox with the inertias of the reducer\"\n    extends \
             Modelica.Mechanics.Rotational.Interfaces.PartialTwoFlanges;\n    parameter Parameters data = {first}() \"Age\" \
             annotation(choicesAllMatching = true);\n    parameter \
             Modelica.Units.SI.Inertia J_load = data.J_load \"Inertia of what your flange_b moves, for the \
             damping\";\n    Modelica.Mechanics.Rotational.Components.Inertia input_side(J = \
             data.J_a);\n    Modelica.Mechanics.Rotational.Components.Gearbox gearbox(\n      ratio = data.ratio, lossTable = \
             data.lossTable, c = data.c, d = 2*data.zeta*sqrt(data.c*J_load), b = data.b);\n    Modelica.Mechanics.Rotational.Components.Inertia \
             output_side(J = data.J_b);\n  equation\n    connect(flange_a, input_side.flange_a);\n    \
             connect(input_side.flange_b, gearbox.flange_a);\n    connect(gearbox.flange_b, output_side.flange_a);\n    \
             connect(output_side.flange_b, flange_b);\n  end Reducer;\n\n  annotation(uses(Modelica(version = \"4.0.0\")));\n\
             end {name};"
        );
        text
    }

    /// Rows of a loss table: |speed| at the input in rad/s, efficiency if the motor drives and if the load
    /// drives, friction torque at the input in both cases. At rest the values of the slowest computed line are
    /// used.
    pub(super) fn loss_rows(&self, state: &JointState) -> Vec<[f64; 5]> {
        let row = |speed: f64, line: &crate::rig::LossLine| {
            [speed, line.efficiency[0], line.efficiency[1], line.friction_n_m[0], line.friction_n_m[1]]
        };
        let at_rest = state.losses.first().map(|line| row(0.0, line));
        at_rest
            .into_iter()
            .chain(state.losses.iter().map(|line| row(line.input_speed_rad_per_s, line)))
            .collect()
    }

    /// A MATLAB script with the values of Simscape Driveline blocks for each age, a structure `joint.h2000`.
    pub fn simscape(&self) -> String {
        let mut text = String::new();
        for line in self.stamps() {
            let _ = writeln!(text, "% {}", line.replace('\n', " "));
        }
        text.push_str(
            "% Simple Gear: ratio, efficiency, viscous friction. Rotational Free Play (or Hard Stop) on the follower\n% \
             side: dead band. Torsional Spring-Damper on the follower side: stiffness and damping, which is meant for \
             load_inertia:\n% damping = 2*damping_ratio*sqrt(stiffness*load_inertia). Units: SI.\n",
        );
        for state in &self.states {
            let label = state.label();
            let curve = &state.hysteresis.curve;
            let [low, high] = state.hysteresis.dead_band();
            let list = |values: &[f64]| values.iter().map(|v| number(*v)).collect::<Vec<_>>().join(", ");
            let rows: Vec<String> = self.loss_rows(state).iter().map(|row| list(row)).collect();
            let values = [
                ("hours", number(state.hours)),
                ("ratio", number(self.ratio)),
                ("rated_torque", number(self.rated_torque_n_m)),
                ("efficiency", number(state.efficiency)),
                (
                    "viscous_friction_base",
                    number(state.friction.without_load()[1] / (self.ratio * self.ratio)),
                ),
                ("no_load_torque_base", number(state.no_load_torque_n_m)),
                ("dead_band_upper", number(high)),
                ("dead_band_lower", number(low)),
                ("stiffness", number(curve.stiffness_n_m_per_rad[2])),
                ("damping_ratio", number(state.damping_ratio)),
                ("load_inertia", number(self.load_inertia_kg_m2)),
                // 2 damping_ratio sqrt(stiffness load_inertia); to be recomputed for another load.
                ("damping", number(self.damping(state))),
                ("stiffness_pieces", format!("[{}]", list(&curve.stiffness_n_m_per_rad))),
                ("torques_between_pieces", format!("[{}]", list(&curve.torques_n_m))),
                ("friction_of_gear", number(state.hysteresis.friction_torque())),
                ("lost_motion", number(state.lost_motion_rad)),
                ("inertia_base", number(self.inertia.sun_kg_m2 + self.inertia.gear_kg_m2)),
                ("inertia_follower", number(self.inertia.output_kg_m2)),
                ("loss_table", format!("[{}]", rows.join("; "))),
            ];
            for (key, value) in values {
                let _ = writeln!(text, "joint.{label}.{key} = {value};");
            }
        }
        text
    }
}
