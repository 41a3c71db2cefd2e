use super::{Local, LocalRate};

/// dh/dt = k p_1 ((p − p_t)/p_1)^m |v_s| above the threshold p_t, zero below it, times the share of the load
/// carried by asperities in mixed lubrication.
///
/// m = 1 and p_t = 0 is Archard's law. With an exponent above 1 wear grows more than proportionally with the
/// pressure, and below the threshold the surface sustains the pressure without wear: elastic asperity contact
/// and shakedown (Johnson 1985, §9), or the "zero wear" of Bayer, Clinton, Nelson & Schumacher (Wear 5, 1962,
/// 378). Neither number is known for a pairing in advance; both are given by the user. p_1 = 1 GPa
/// (`UNIT_PRESSURE`) only determines the unit of k: k is the coefficient of Archard's law with the same rate at
/// p_t + p_1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PressurePower {
    /// m.
    pub exponent: f64,
    /// p_t in Pa.
    pub threshold: f64,
}

/// p_1 in Pa: of the order of the Hertz pressures of a loaded flank. A choice of unit, no property.
pub const UNIT_PRESSURE: f64 = 1e9;

impl LocalRate for PressurePower {
    fn rate(&self, at: &Local) -> f64 {
        let above = ((at.pressure - self.threshold) / UNIT_PRESSURE).max(0.0);
        UNIT_PRESSURE * above.powf(self.exponent) * at.sliding * at.boundary_share()
    }

    fn threshold(&self) -> f64 {
        self.threshold
    }
}
