//! The whole export as JSON, and tables for controllers.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::{Hysteresis, JointExport, JointState, number};
use crate::units::ARCMIN;

impl JointExport {
    /// All values with their meanings and sources; can be read by [`JointExport::from_json`].
    ///
    /// # Errors
    /// [`serde_json::Error`] for numbers that JSON cannot hold.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        let mut value = serde_json::to_value(self)?;
        if let Value::Object(map) = &mut value {
            map.insert("meaning".into(), meaning());
            map.insert("catalogue".into(), self.states.iter().map(|state| self.catalogue(state)).collect());
        }
        Ok(serde_json::to_string_pretty(&value)? + "\n")
    }

    /// Reads the output of [`JointExport::json`].
    ///
    /// # Errors
    /// [`serde_json::Error`] for other text.
    pub fn from_json(text: &str) -> Result<JointExport, serde_json::Error> {
        serde_json::from_str(text)
    }

    /// One age in the units of catalogues.
    fn catalogue(&self, state: &JointState) -> Value {
        let Hysteresis { curve, .. } = &state.hysteresis;
        let per_arcmin = curve.stiffness_n_m_per_rad.map(|k| k * ARCMIN);
        let stiffness = |side: usize| state.hysteresis.sides[side].stiffness_n_m_per_rad.map(|k| k * ARCMIN);
        json!({
            "hours": state.hours,
            "lost_motion_arcmin": state.lost_motion_rad / ARCMIN,
            "backlash_arcmin": state.backlash_rad / ARCMIN,
            "stiffness_n_m_per_arcmin": state.stiffness_n_m_per_rad * ARCMIN,
            "hysteresis_width_arcmin": state.hysteresis_width_rad / ARCMIN,
            "hysteresis_loss_j": state.hysteresis_loss_j,
            "k1_n_m_per_arcmin": per_arcmin[0],
            "k2_n_m_per_arcmin": per_arcmin[1],
            "k3_n_m_per_arcmin": per_arcmin[2],
            "t1_n_m": curve.torques_n_m[0],
            "t2_n_m": curve.torques_n_m[1],
            "dead_band_arcmin": 2.0 * curve.half_gap_rad / ARCMIN,
            "middle_of_dead_band_arcmin": state.hysteresis.zero_rad / ARCMIN,
            "k1_k2_k3_positive_torque_n_m_per_arcmin": stiffness(0),
            "k1_k2_k3_negative_torque_n_m_per_arcmin": stiffness(1),
            "fit_residual_arcmin": curve.residual_rad / ARCMIN,
            "hysteresis_residual_rms_n_m": state.hysteresis.residual_rms_n_m,
            "damping_ratio": state.damping_ratio,
            "damping_at_load_inertia_n_m_s_per_rad": self.damping(state),
            "hysteresis_residual_max_n_m": state.hysteresis.residual_max_n_m,
            "hysteresis_residual_rms_arcmin": state.hysteresis.residual_rms_rad / ARCMIN,
            "transmission_error_rated_peak_to_peak_arcmin": state
                .transmission_error
                .iter()
                .filter(|curve| curve.direction > 0.0)
                .max_by(|a, b| a.torque_n_m.total_cmp(&b.torque_n_m))
                .map(|curve| curve.peak_to_peak_rad / ARCMIN),
            "efficiency": state.efficiency,
            "no_load_torque_at_output_n_m": state.running_friction(self.ratio),
            "viscous_friction_at_output_n_m_s_per_rad": state.friction.without_load()[1],
            "back_driving_torque_n_m": state.back_driving_torque_n_m,
        })
    }

    /// Torque against wind-up on both branches and without hysteresis, for a controller's table.
    pub fn wind_up_table(&self) -> String {
        let mut text = String::from("hours,branch,torque_n_m,wind_up_arcmin,wind_up_model_arcmin\n");
        for state in &self.states {
            let points = state.loop_points();
            for (point, model) in points.iter().zip(state.hysteresis.loop_at(&points)) {
                let _ = writeln!(
                    text,
                    "{},{},{},{},{}",
                    number(state.hours),
                    point.branch.word(),
                    number(point.torque),
                    number(point.angle / ARCMIN),
                    number(model.angle / ARCMIN)
                );
            }
        }
        text
    }

    /// Waves of the transmission error over torque and direction.
    pub fn wave_table(&self) -> String {
        let mut text = String::from("hours,direction,torque_n_m,order,amplitude_arcmin,phase_deg\n");
        for state in &self.states {
            for curve in &state.transmission_error {
                for wave in &curve.waves {
                    let _ = writeln!(
                        text,
                        "{},{},{},{},{},{}",
                        number(state.hours),
                        number(curve.direction),
                        number(curve.torque_n_m),
                        wave.order,
                        number(wave.amplitude_rad / ARCMIN),
                        number(wave.phase_rad.to_degrees())
                    );
                }
            }
        }
        text
    }

    /// Losses over speed: efficiency and friction torque of either direction of power.
    pub fn loss_table(&self) -> String {
        let mut text = String::from(
            "hours,input_speed_rad_per_s,efficiency_motor_drives,efficiency_load_drives,friction_motor_drives_n_m,\
             friction_load_drives_n_m\n",
        );
        for state in &self.states {
            for row in self.loss_rows(state) {
                let _ = writeln!(text, "{},{}", number(state.hours), row.map(number).join(","));
            }
        }
        text
    }
}

fn meaning() -> Value {
    json!({
        "units": "SI in keys that end in _rad, _n_m, _kg_m2, _s; arcmin and degrees according to the key",
        "wind_up": "turn of the output flange against input/ratio, input held; positive along positive torque",
        "hysteresis": "T = G(phi) + sum_j (torque_n_m + torque_per_load |G(phi)|) z_j; z_j += d phi / slip_rad, kept \
                       within -1 and 1; G is the torsion curve of the side (the first of sides where phi is above \
                       zero_rad, else the second) at phi - zero_rad: 0 within half_gap_rad, then K1 up to T1, K2 up \
                       to T2, K3 beyond; curve is the mean of both sides",
        "transmission_error": "theta_out - theta_in/ratio = mean + sum amplitude cos(order theta_out + phase)",
        "losses": "input torque = torque / (ratio efficiency) + friction where the motor drives, torque efficiency / \
                   ratio - friction where the load drives; straight lines through the bench's efficiencies",
        "friction": "of the joint as one hinge, at the output: tau_f = coulomb_n_m + viscous_n_m_s_per_rad |w| + load_mean \
                     |tau| z + load_difference tau z^2 with the torque tau of the motor times ratio, the speed w of the output \
                     and dz/dt = (w - |w| z)/relaxation_rad; residual_*: residuals of the torques of `losses` over speed, \
                     torque and direction of power; relaxation_residual_rms_n_m: of the hysteresis loop. \
                     friction_without_constant: the same with coulomb_n_m = 0, four parameters as in issue 3528 of \
                     google-deepmind/mujoco",
        "damping_ratio": "of a free oscillation about half of the rated torque, released at three quarters, from the \
                          hysteresis; equivalent to a damper of 2 damping_ratio sqrt(K3 load_inertia_kg_m2)",
        "source": "hysteresis loop, transmission error, efficiency and running torques of `arcmin rig` at this age; \
                   wear of the duty before as in `arcmin life`",
    })
}
