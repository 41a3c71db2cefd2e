//! Heat dissipation of a drive of eccentrics.

use super::schema::{default, optional, section};
use crate::machine::StageThermal;

section! {
    /// Heat of drives of eccentrics, for the temperature that `check` compares with the softening temperatures
    /// of the materials. Forces and gaps are those of the dimensions as drawn.
    pub struct StageThermalSection {
        /// Temperature around the drive.
        ambient_c: f64 => default(20.0, -60.0, 80.0),
        /// Heat transfer of the surface, radiation included; still air 10 to 20.
        heat_transfer_w_m2_k: f64 => default(15.0, 0.1, 1e4),
        /// Surface that dissipates heat. Left out: a closed cylinder with a wall of 0.12 of its outer radius
        /// outside of the ring pins, twice as long as the discs together.
        surface_m2: Option<f64> => optional(1e-5, 100.0),
        /// Heat that flows into the mounting per kelvin above the surroundings. A plastic mounting conducts
        /// hardly any.
        mounting_conductance_w_k: f64 => default(0.0, 0.0, 1e5),
        /// Heat of a motor or other sources in the housing, in addition to the losses of the drive.
        motor_heat_w: f64 => default(0.0, 0.0, 1e5),
        /// Thermal expansion of the housing. Left out: that of the discs.
        housing_expansion_um_per_m_k: Option<f64> => optional(0.1, 300.0),
    }
}

impl StageThermalSection {
    pub(super) fn resolve(&self) -> StageThermal {
        StageThermal {
            ambient: *self.ambient_c,
            transfer: *self.heat_transfer_w_m2_k,
            surface: *self.surface_m2,
            mounting: *self.mounting_conductance_w_k,
            other_heat: *self.motor_heat_w,
            housing_expansion: self.housing_expansion_um_per_m_k.map(|um| um * 1e-6),
        }
    }
}
