//! Wear of bearings and gears: laws and what they have taken off.

/// What parts beyond flank and pins have lost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PartWear {
    /// Growth of the diametral clearance of the turning-arm bearings in m.
    pub turning_arm: f64,
    /// Growth of the diametral clearance of the crank supports in m.
    pub crank_support: f64,
    /// Growth of the gap of every sun–planet mesh along its line of action in m: of the tooth sides on which
    /// the sun drives counter-clockwise, and of the others.
    pub gears: [f64; 2],
}

impl PartWear {
    /// This wear and `time` times the rates.
    pub fn plus(&self, rates: &PartWear, time: f64) -> PartWear {
        PartWear {
            turning_arm: self.turning_arm + time * rates.turning_arm,
            crank_support: self.crank_support + time * rates.crank_support,
            gears: [self.gears[0] + time * rates.gears[0], self.gears[1] + time * rates.gears[1]],
        }
    }

    pub fn is_zero(&self) -> bool {
        *self == PartWear::default()
    }
}

/// Wear laws of bearings and gears; nothing wears by default, as no coefficient is known for all machines.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PartWearLaws {
    pub turning_arm: Option<RollingWear>,
    pub crank_support: Option<RollingWear>,
    /// k of the teeth of the sun and of the planets in 1/Pa.
    pub sun: f64,
    pub planet: f64,
}

impl PartWearLaws {
    pub fn any(&self) -> bool {
        self.turning_arm.is_some() || self.crank_support.is_some() || self.sun > 0.0 || self.planet > 0.0
    }
}

/// Wear of a rolling bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RollingWear {
    /// k in 1/Pa.
    pub coefficient: f64,
    /// Sliding distance per rolled distance.
    pub slip: f64,
}
