use super::{Local, LocalRate};

/// Archard's law (Archard 1953, J. Appl. Phys. 24, 981): dh/dt = k p |v_s|, in mixed lubrication times the
/// share of the load that asperities carry.
///
/// Over one pass of a contact this is Δh = k (F/B) ξ with the specific sliding ξ: the width cancels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Archard;

impl LocalRate for Archard {
    fn rate(&self, at: &Local) -> f64 {
        at.pressure * at.sliding * at.boundary_share()
    }

    /// ∫p dx = F/B in closed form.
    fn section_rate(&self, line_load: f64, _half_width: f64, at: &Local) -> f64 {
        line_load * at.sliding * at.boundary_share()
    }
}
