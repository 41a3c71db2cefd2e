//! Heat balance of drives of eccentrics.

/// Parameters of the heat transfer from a drive of eccentrics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StageThermal {
    /// °C.
    pub ambient: f64,
    /// Heat transfer of the surface in W/(m²·K), radiation included.
    pub transfer: f64,
    /// m²; `None` where the design gives none.
    pub surface: Option<f64>,
    /// Conductance to the mounting of the drive, W/K above the surroundings.
    pub mounting: f64,
    /// Heat of a motor and other sources in the housing, W.
    pub other_heat: f64,
    /// Thermal expansion of the housing in 1/K; `None`: that of the discs.
    pub housing_expansion: Option<f64>,
}

impl StageThermal {
    /// Conductance in W/K of a surface (m²) and the mounting.
    pub fn cooling(&self, surface: f64) -> f64 {
        self.transfer * surface + self.mounting
    }

    /// Temperature in °C at which a loss in W and the other heat are dissipated by a surface (m²): T_a +
    /// P/(h A + G). One temperature represents all parts; contacts are warmer.
    pub fn temperature(&self, loss: f64, surface: f64) -> f64 {
        self.ambient + (loss + self.other_heat) / self.cooling(surface)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At that temperature the heat dissipated by surface and mounting equals the losses.
    #[test]
    fn heat_leaves_as_it_comes() {
        let thermal = StageThermal {
            ambient: 25.0,
            transfer: 12.0,
            surface: None,
            mounting: 0.2,
            other_heat: 3.0,
            housing_expansion: None,
        };
        let surface = 0.02;
        let celsius = thermal.temperature(1.4, surface);
        let out = 12.0 * surface * (celsius - 25.0) + 0.2 * (celsius - 25.0);
        assert!((out - 4.4).abs() < 1e-12, "{celsius} {out}");
        assert_eq!(StageThermal { other_heat: 0.0, ..thermal }.temperature(0.0, surface), 25.0);
    }
}
