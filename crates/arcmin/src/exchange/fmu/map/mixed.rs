//! A joint at an age between two given ones: every value is interpolated linearly, with `share` 0 at the first
//! age and 1 at the second.

use crate::exchange::fmu::PinLoadAt;
use crate::exchange::joint::{Hysteresis, SlipElement, TorsionCurve, TransmissionWaves, Wave};
use crate::rig::LossLine;

pub fn mix(a: f64, b: f64, share: f64) -> f64 {
    a + share * (b - a)
}

pub fn mixed_hysteresis(first: &Hysteresis, second: &Hysteresis, share: f64) -> Hysteresis {
    let curve = |a: &TorsionCurve, b: &TorsionCurve| TorsionCurve {
        half_gap_rad: mix(a.half_gap_rad, b.half_gap_rad, share),
        torques_n_m: [0, 1].map(|i| mix(a.torques_n_m[i], b.torques_n_m[i], share)),
        // Compliances are additive and therefore interpolated.
        stiffness_n_m_per_rad: [0, 1, 2]
            .map(|i| 1.0 / mix(1.0 / a.stiffness_n_m_per_rad[i], 1.0 / b.stiffness_n_m_per_rad[i], share)),
        residual_rad: a.residual_rad.max(b.residual_rad),
    };
    Hysteresis {
        curve: curve(&first.curve, &second.curve),
        zero_rad: mix(first.zero_rad, second.zero_rad, share),
        sides: [0, 1].map(|side| curve(&first.sides[side], &second.sides[side])),
        elements: first
            .elements
            .iter()
            .zip(&second.elements)
            .map(|(a, b)| SlipElement {
                slip_rad: mix(a.slip_rad, b.slip_rad, share),
                torque_n_m: mix(a.torque_n_m, b.torque_n_m, share),
                torque_per_load: mix(a.torque_per_load, b.torque_per_load, share),
            })
            .collect(),
        residual_rms_n_m: first.residual_rms_n_m.max(second.residual_rms_n_m),
        residual_max_n_m: first.residual_max_n_m.max(second.residual_max_n_m),
        residual_rms_rad: first.residual_rms_rad.max(second.residual_rms_rad),
    }
}

/// Waves are additive: those of both ages, each with its weight.
pub fn mixed_waves(a: &TransmissionWaves, b: &TransmissionWaves, share: f64) -> TransmissionWaves {
    let scaled = |waves: &TransmissionWaves, by: f64| -> Vec<Wave> {
        let one = |wave: &Wave| Wave { amplitude_rad: by * wave.amplitude_rad, ..*wave };
        waves.waves.iter().map(one).filter(|wave| wave.amplitude_rad > 0.0).collect()
    };
    let waves = [scaled(a, 1.0 - share), scaled(b, share)].concat();
    TransmissionWaves { waves, ..a.clone() }
}

pub fn mixed_losses(a: &LossLine, b: &LossLine, share: f64) -> LossLine {
    let pair = |a: [f64; 2], b: [f64; 2]| [mix(a[0], b[0], share), mix(a[1], b[1], share)];
    LossLine {
        input_speed_rad_per_s: mix(a.input_speed_rad_per_s, b.input_speed_rad_per_s, share),
        efficiency: pair(a.efficiency, b.efficiency),
        friction_n_m: pair(a.friction_n_m, b.friction_n_m),
        left_n_m: a.left_n_m.max(b.left_n_m),
    }
}

pub fn mixed_pins(a: &PinLoadAt, b: &PinLoadAt, share: f64) -> PinLoadAt {
    PinLoadAt {
        torque_n_m: mix(a.torque_n_m, b.torque_n_m, share),
        force_n: mix(a.force_n, b.force_n, share),
        pressure_pa: mix(a.pressure_pa, b.pressure_pa, share),
    }
}
