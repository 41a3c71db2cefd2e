//! Masses and moments of inertia of the joint's parts.

use serde::{Deserialize, Serialize};

use crate::dynamics::{BearingJoints, DynamicsError, JointSettings, System};
use crate::machine::{FixedMember, Machine};

/// Moments of inertia in kg·m², masses in kg.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct JointInertia {
    /// Motor at the input, as given by the design.
    pub motor_kg_m2: f64,
    /// Input shaft with sun at the input, as given by the design.
    pub sun_kg_m2: f64,
    /// Crankshafts and discs, referred to the input.
    pub gear_kg_m2: f64,
    /// The output flange with all parts that rotate with it, at the output.
    pub output_kg_m2: f64,
    /// The part with the output flange: the carrier, or the housing if the carrier is fixed.
    pub output_kg: f64,
    /// Crankshafts and discs, which move with the carrier.
    pub gear_kg: f64,
}

impl JointInertia {
    /// From the kinetic energy ½ Σ m v² of the nominal motion at unit speed of the input.
    ///
    /// # Errors
    /// [`DynamicsError`] if no model of the machine can be built.
    pub fn of(machine: &Machine) -> Result<JointInertia, DynamicsError> {
        let model = BearingJoints::held(machine, &JointSettings::default())?;
        let velocity = model.nominal_velocity_at(0.0, 1.0);
        let output = model.output_index();
        let whole: f64 = velocity.iter().zip(model.mass()).map(|(v, m)| m * v * v).sum();
        let own = model.mass()[output];
        Ok(JointInertia {
            motor_kg_m2: machine.gear_stage.motor_inertia,
            sun_kg_m2: machine.gear_stage.sun_inertia,
            gear_kg_m2: whole - own * velocity[output] * velocity[output],
            output_kg_m2: own,
            output_kg: match machine.fixed_member() {
                FixedMember::Housing => machine.carrier.mass,
                FixedMember::Carrier => machine.housing.mass,
            },
            gear_kg: machine.crankshafts.count as f64 * machine.crankshafts.mass
                + machine.disc_count as f64 * machine.disc.mass,
        })
    }
}
