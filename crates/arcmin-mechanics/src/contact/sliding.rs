use super::ContactSpring;

/// Coulomb friction between flank and pin, regularised: F_t = μ F v/√(v² + v_r²) against the sliding speed v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sliding {
    /// μ. For a pin that turns in its seat, the smaller of the coefficients of flank and seat, because it slides
    /// where friction is smaller.
    pub coefficient: f64,
    /// v_r in m/s.
    pub regularisation_speed: f64,
}

impl Sliding {
    /// (F_t/F, its derivative with respect to the sliding speed).
    pub(crate) fn share(&self, speed: f64) -> (f64, f64) {
        let reach = 1.0 / speed.hypot(self.regularisation_speed);
        (
            self.coefficient * speed * reach,
            self.coefficient * self.regularisation_speed.powi(2) * reach.powi(3),
        )
    }

    /// Friction of a contact with a normal force (N), against the slip over a time interval (s).
    pub(crate) fn slip(&self, force: f64, interval: f64) -> ContactSpring {
        let presliding = self.regularisation_speed * interval;
        ContactSpring::Slip { limit: self.coefficient * force, presliding }
    }
}
