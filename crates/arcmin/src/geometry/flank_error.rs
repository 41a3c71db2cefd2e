/// Metal missing on the flank as harmonics of the angle on the disc: run-out is order 1, a profile error common to all lobes is order z_c.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FlankError {
    pub harmonics: Vec<FlankHarmonic>,
}

/// amplitude × cos(order × (τ − phase)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlankHarmonic {
    pub order: usize,
    /// m.
    pub amplitude: f64,
    /// rad.
    pub phase: f64,
}

impl FlankError {
    /// Missing metal in m at the angle τ (rad) on the disc.
    pub fn depth(&self, tau: f64) -> f64 {
        self.harmonics.iter().map(|h| h.amplitude * (h.order as f64 * (tau - h.phase)).cos()).sum()
    }

    /// Its derivative in m/rad.
    pub fn slope(&self, tau: f64) -> f64 {
        self.harmonics.iter().map(|h| -h.amplitude * h.order as f64 * (h.order as f64 * (tau - h.phase)).sin()).sum()
    }

    /// A bound from below in m.
    pub fn shallowest(&self) -> f64 {
        -self.harmonics.iter().map(|h| h.amplitude.abs()).sum::<f64>()
    }

    pub fn is_zero(&self) -> bool {
        self.harmonics.iter().all(|h| h.amplitude == 0.0)
    }
}
