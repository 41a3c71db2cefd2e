use super::LineContact;

/// Elastic law of one contact: how hard two bodies press at an approach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactSpring {
    /// F = k δ.
    Linear {
        /// k in N/m.
        stiffness: f64,
    },
    /// F = c K (c δ)^n: a rolling element that presses at an angle to the radius, c its cosine.
    Power { stiffness: f64, exponent: f64, cosine: f64 },
    /// A pin on a flank, with the equivalent radius in m.
    Line { law: LineContact, radius: f64 },
}

/// Force in N and tangent stiffness in N/m of a contact; both zero while it is open.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pressed {
    pub force: f64,
    pub stiffness: f64,
}

impl ContactSpring {
    /// At the approach δ in m, negative while the contact is open.
    #[inline]
    pub fn at(&self, approach: f64) -> Pressed {
        if !(approach > 0.0) {
            return Pressed::default();
        }
        match *self {
            ContactSpring::Linear { stiffness } => Pressed { force: stiffness * approach, stiffness },
            ContactSpring::Power { stiffness, exponent, cosine } => {
                let approach = cosine * approach;
                let force = cosine * stiffness * approach.powf(exponent);
                Pressed { force, stiffness: cosine * exponent * force / approach }
            }
            ContactSpring::Line { ref law, radius } => {
                let (force, stiffness) = law.force(approach, radius);
                Pressed { force, stiffness }
            }
        }
    }
}
