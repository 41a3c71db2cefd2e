use super::{Local, LocalRate};

/// Running-in of the place itself: dh/dt = k p |v_s| (1 + (f − 1) e^(−h/d)), in mixed lubrication times the
/// share of the load that asperities carry.
///
/// The peaks of a ground flank are few and carry all of the load; as they are worn off, the real area of contact
/// grows and the rate falls from f times to its steady value. Each place is done with it after some d ln f of its
/// own wear, so the depth d is of the order of the roughness (peak to valley) and can be seen on the profile of a
/// new flank, unlike the time of a running-in. That the rate falls exponentially with the depth is an
/// assumption, the simplest with two numbers; the steady k counts from where the surface has become smooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Smoothing {
    /// f, the rate of the new surface relative to that of the smooth one.
    pub factor: f64,
    /// d in m.
    pub depth: f64,
}

impl LocalRate for Smoothing {
    fn rate(&self, at: &Local) -> f64 {
        let roughness_left = (-at.depth / self.depth).exp();
        at.pressure * at.sliding * at.boundary_share() * (1.0 + (self.factor - 1.0) * roughness_left)
    }
}
