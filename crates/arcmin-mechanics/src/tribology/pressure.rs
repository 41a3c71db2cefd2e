use super::{Local, LocalRate};

/// dh/dt = k p_1 ((p − p_t)/p_1)^m |v_s| above the threshold p_t, nothing below it, in mixed lubrication times
/// the share of the load that asperities carry.
///
/// m = 1 and p_t = 0 is Archard's law. An exponent above 1 says that severer contact wears out of proportion,
/// a threshold that the surface bears a pressure for good: elastic asperity contact and shakedown (Johnson
/// 1985, §9), or the "zero wear" of Bayer, Clinton, Nelson & Schumacher (Wear 5, 1962, 378). Neither number
/// is known for a pairing in advance; both are the user's. p_1 = 1 GPa (`UNIT_PRESSURE`) only gives k its
/// unit: k is the coefficient of Archard's law that wears as fast at p_t + p_1.
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
