use super::LineContact;

/// Elastic law of one contact: normal force as a function of the approach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactSpring {
    /// F = k δ.
    Linear {
        /// k in N/m.
        stiffness: f64,
    },
    /// F = K δ^n: a rolling element.
    Power {
        /// K in N/mⁿ.
        stiffness: f64,
        /// n, without unit.
        exponent: f64,
    },
    /// A share of the length of a pin on a flank, with the equivalent radius in m.
    Line {
        /// Force law of the whole length of the pin.
        law: LineContact,
        /// R_eq in m.
        radius: f64,
        /// Part of the pin's length, 0 to 1.
        share: f64,
    },
    /// Regularised Coulomb friction F = L δ/√(δ² + r²) against a slip −δ: it acts in both senses.
    Slip {
        /// L in N.
        limit: f64,
        /// r in m.
        presliding: f64,
    },
}

/// Force in N and tangent stiffness in N/m of a contact; both zero while it is open. Friction is never open.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pressed {
    /// N, in the sense in which the bodies press.
    pub force: f64,
    /// ∂(force)/∂(approach), N/m.
    pub stiffness: f64,
}

impl ContactSpring {
    /// At the approach δ in m, negative while the contact is open.
    #[inline]
    pub fn at(&self, approach: f64) -> Pressed {
        if let ContactSpring::Slip { limit, presliding } = *self {
            let reach = 1.0 / approach.hypot(presliding);
            let stiffness = limit * presliding * presliding * reach.powi(3);
            return Pressed { force: limit * approach * reach, stiffness };
        }
        if !(approach > 0.0) {
            return Pressed::default();
        }
        match *self {
            ContactSpring::Slip { .. } => Pressed::default(),
            ContactSpring::Linear { stiffness } => Pressed { force: stiffness * approach, stiffness },
            ContactSpring::Power { stiffness, exponent } => {
                let force = stiffness * approach.powf(exponent);
                Pressed { force, stiffness: exponent * force / approach }
            }
            ContactSpring::Line { ref law, radius, share } => {
                let (force, stiffness) = law.force(approach, radius);
                Pressed { force: share * force, stiffness: share * stiffness }
            }
        }
    }
}
