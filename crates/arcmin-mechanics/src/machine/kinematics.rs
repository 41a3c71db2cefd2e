use std::f64::consts::TAU;

use super::{FixedMember, Machine};
use crate::contact::DiscPose;
use crate::geometry::unit;
use crate::units::HOUR;

/// Ratios, phases and nominal poses of a machine.
///
/// Gear stage: z_1(θ_s − θ_o) + z_2(θ_k − θ_o) = 0. Nominal rolling: θ_o = −θ_k/z_c. Disc j: centre a e(θ_k +
/// α_j), angle θ_o + δ_j with δ_j = −α_j/z_c.
#[derive(Debug, Clone, PartialEq)]
pub struct Kinematics {
    /// z_1.
    pub sun_teeth: f64,
    /// z_2.
    pub planet_teeth: f64,
    /// z_c, the pins less one.
    pub lobe_count: f64,
    /// z_p.
    pub pin_count: f64,
    /// m.
    pub eccentricity: f64,
    /// Phases α_j of the eccentrics in rad.
    pub phases: Vec<f64>,
    fixed_member: FixedMember,
}

impl Kinematics {
    pub(super) fn new(machine: &Machine) -> Kinematics {
        let discs = machine.disc_count;
        Kinematics {
            sun_teeth: machine.gear_stage.sun_teeth as f64,
            planet_teeth: machine.gear_stage.planet_teeth as f64,
            lobe_count: machine.ring.pin_count as f64 - 1.0,
            pin_count: machine.ring.pin_count as f64,
            eccentricity: machine.crankshafts.eccentricity,
            phases: (0..discs).map(|j| TAU * j as f64 / discs as f64).collect(),
            fixed_member: machine.fixed_member,
        }
    }

    /// i = θ_s/θ_o with the housing fixed: 1 + z_p z_2/z_1. With the carrier fixed (output = housing): 1 − i.
    pub fn ratio(&self) -> f64 {
        let housing_fixed = self.housing_fixed_ratio();
        match self.fixed_member {
            FixedMember::Housing => housing_fixed,
            FixedMember::Carrier => 1.0 - housing_fixed,
        }
    }

    /// i with the housing fixed, whatever member is fixed in service: the ratio of all relative motion.
    pub fn housing_fixed_ratio(&self) -> f64 {
        1.0 + self.pin_count * self.planet_teeth / self.sun_teeth
    }

    /// Rotation of the discs relative to the ring per rotation of the output with the input locked: 1, or −1 if
    /// the housing is the output.
    pub fn disc_per_output_locked(&self) -> f64 {
        match self.fixed_member {
            FixedMember::Housing => 1.0,
            FixedMember::Carrier => -1.0,
        }
    }

    /// Rotation of the crankshafts relative to the ring per rotation of the output with the input locked:
    /// (z_1 + z_2)/z_2. With the carrier fixed the crankshafts do not rotate and the ring does: −1.
    pub fn crank_per_output_locked(&self) -> f64 {
        match self.fixed_member {
            FixedMember::Housing => (self.sun_teeth + self.planet_teeth) / self.planet_teeth,
            FixedMember::Carrier => -1.0,
        }
    }

    /// Factor from a rotation of the disc within its clearance to the rotation of the output with the input
    /// locked: 1/(1 + (z_1+z_2)/(z_2 z_c)); with the carrier fixed z_c/z_p.
    pub fn locked_play_factor(&self) -> f64 {
        1.0 / (1.0 + self.crank_per_output_locked().abs() / self.lobe_count)
    }

    /// δ_j = −α_j/z_c: angle at which disc j is cut against the carrier.
    pub fn mounting_angle(&self, disc: usize) -> f64 {
        -self.phases[disc] / self.lobe_count
    }

    /// Pose of a disc for a crank angle θ_k and an output angle θ_o in rad, ideal joints.
    pub fn disc_pose(&self, disc: usize, crank_angle: f64, output_angle: f64) -> DiscPose {
        DiscPose {
            centre: self.eccentricity * unit(crank_angle + self.phases[disc]),
            angle: output_angle + self.mounting_angle(disc),
        }
    }

    /// θ_o of nominal rolling.
    pub fn nominal_output_angle(&self, crank_angle: f64) -> f64 {
        -crank_angle / self.lobe_count
    }

    /// Speeds in rad/s for an input speed θ̇_s, relative to the ring: (output, crankshaft absolute,
    /// crankshaft relative to disc and carrier).
    ///
    /// With the carrier fixed the input speed relative to the ring is θ̇_s − θ̇_housing.
    pub fn speeds(&self, input_speed: f64) -> (f64, f64, f64) {
        let relative_input = match self.fixed_member {
            FixedMember::Housing => input_speed,
            FixedMember::Carrier => input_speed - input_speed / self.ratio(),
        };
        let output = relative_input / self.housing_fixed_ratio();
        let crank = -self.lobe_count * output;
        (output, crank, crank - output)
    }

    /// Passes of a flank point through its contact per hour: turns of the crankshaft relative to the disc.
    pub fn passes_per_hour(&self, input_speed: f64) -> f64 {
        self.speeds(input_speed).2.abs() / TAU * HOUR
    }

    /// Crank angle over which the pattern of pins and discs repeats in rad.
    pub fn pattern_period(&self) -> f64 {
        TAU / self.pin_count
    }

    /// Whether all discs have the same pattern of contacts with a phase shift: their phases are whole multiples
    /// of the pin pitch.
    pub fn discs_have_equal_patterns(&self) -> bool {
        self.phases.iter().all(|phase| {
            let pitches = phase / self.pattern_period();
            (pitches - pitches.round()).abs() < 1e-9
        })
    }

    /// Angle γ_k of crankshaft k on the carrier, given that of the first.
    pub fn crankshaft_angle(first: f64, index: usize, count: usize) -> f64 {
        first + TAU * index as f64 / count as f64
    }
}
