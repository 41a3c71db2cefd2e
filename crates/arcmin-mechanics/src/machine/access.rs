//! Read access to a machine, and the two assumptions that may be changed on it.

use super::{
    BearingSet, Carrier, Crankshafts, CycloidDisc, DutyPoint, FixedMember, Friction, GearStage, Housing,
    Limits, Machine, PinRing, Wear,
};
use crate::contact::{ContactLaw, Damping};

/// An assumption that is outside of its valid range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name} = {value}: {requirement}")]
pub struct InvalidAssumption {
    /// Quantity, as words of the message.
    pub name: &'static str,
    /// Value given.
    pub value: f64,
    /// Condition that it breaks, as words of the message.
    pub requirement: &'static str,
}

fn require(
    holds: bool,
    name: &'static str,
    value: f64,
    requirement: &'static str,
) -> Result<(), InvalidAssumption> {
    // A comparison with NaN is false, so NaN never passes.
    if holds { Ok(()) } else { Err(InvalidAssumption { name, value, requirement }) }
}

impl Machine {
    /// Name of the design.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The ring of pins in the housing.
    pub fn ring(&self) -> &PinRing {
        &self.ring
    }

    /// One of the discs, which are all alike but for the phase of their eccentric.
    pub fn disc(&self) -> &CycloidDisc {
        &self.disc
    }

    /// Number of discs.
    pub fn disc_count(&self) -> usize {
        self.disc_count
    }

    /// The crankshafts, each with its planet.
    pub fn crankshafts(&self) -> &Crankshafts {
        &self.crankshafts
    }

    /// Sun and planets.
    pub fn gear_stage(&self) -> &GearStage {
        &self.gear_stage
    }

    /// The carrier with the output shaft.
    pub fn carrier(&self) -> &Carrier {
        &self.carrier
    }

    /// The housing with its pins.
    pub fn housing(&self) -> &Housing {
        &self.housing
    }

    /// The fixed member.
    pub fn fixed_member(&self) -> FixedMember {
        self.fixed_member
    }

    /// Bearings and supports.
    pub fn bearings(&self) -> &BearingSet {
        &self.bearings
    }

    /// Friction coefficients and losses.
    pub fn friction(&self) -> &Friction {
        &self.friction
    }

    /// Elastic law of the contacts between flank and pin.
    pub fn contact_law(&self) -> ContactLaw {
        self.contact_law
    }

    /// Damping of the same contacts.
    pub fn contact_damping(&self) -> Damping {
        self.contact_damping
    }

    /// Rated operating point: output torque in N·m, input speed in rad/s.
    pub fn rated(&self) -> DutyPoint {
        self.rated
    }

    /// Load spectrum; its shares add up to 1.
    pub fn duty(&self) -> &[DutyPoint] {
        &self.duty
    }

    /// Laws of wear of flank, pins, bearings and gears.
    pub fn wear(&self) -> &Wear {
        &self.wear
    }

    /// Limits set by the user.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// The machine with other friction coefficients, for test benches of designs that give none. The
    /// regularisation speed of friction remains that of the machine, because it is a numerical parameter.
    ///
    /// # Errors
    /// A coefficient or loss that is negative or not finite.
    pub fn with_friction(&self, friction: Friction) -> Result<Machine, InvalidAssumption> {
        for (name, value) in [
            ("friction of the flanks", friction.flank),
            ("friction of the pin seats", friction.pin_seat),
            ("friction of the bearings", friction.bearing),
            ("friction of the gear meshes", friction.gear_mesh),
            ("drag of the seals", friction.seal_drag),
            ("drag of the oil", friction.oil_drag),
            ("drag of the bearings", friction.bearing_drag),
            ("preload of the crank supports", friction.crank_support_preload),
        ] {
            require(value >= 0.0 && value.is_finite(), name, value, "must not be negative")?;
        }
        let friction = Friction { regularisation_speed: self.friction.regularisation_speed, ..friction };
        Ok(Machine { friction, ..self.clone() })
    }

    /// The machine with another elastic law of its tooth contacts.
    ///
    /// # Errors
    /// A stiffness that is not positive, or an exponent below 1, for which the derivative of the force at first
    /// touch would be infinite.
    pub fn with_contact_law(&self, law: ContactLaw) -> Result<Machine, InvalidAssumption> {
        let positive = |stiffness: f64| {
            require(
                stiffness > 0.0 && stiffness.is_finite(),
                "stiffness of the contact law",
                stiffness,
                "must be positive",
            )
        };
        if let ContactLaw::Linear { stiffness } | ContactLaw::Impact { stiffness, .. } = law {
            positive(stiffness)?;
        }
        if let ContactLaw::Impact { exponent, .. } = law {
            let name = "exponent of the contact law";
            require(exponent >= 1.0 && exponent.is_finite(), name, exponent, "must be 1 or more")?;
        }
        Ok(Machine { contact_law: law, ..self.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::templates::tao2024;

    #[test]
    fn assumptions_keep_the_requirements_of_all_solvers() {
        let machine = tao2024();
        let rough = Friction { flank: 0.05, regularisation_speed: f64::NAN, ..Friction::default() };
        let changed = machine.with_friction(rough).unwrap();
        assert_eq!(changed.friction().flank, 0.05);
        assert_eq!(changed.friction().regularisation_speed, machine.friction().regularisation_speed);
        assert_eq!(Machine { friction: *machine.friction(), ..changed }, machine);
        for wrong in [-0.1, f64::NAN, f64::INFINITY] {
            assert!(machine.with_friction(Friction { seal_drag: wrong, ..Friction::default() }).is_err());
            assert!(machine.with_contact_law(ContactLaw::Linear { stiffness: wrong }).is_err());
        }
        assert!(machine.with_contact_law(ContactLaw::Impact { stiffness: 1e9, exponent: 0.5 }).is_err());
        let linear = ContactLaw::Linear { stiffness: 2.85e8 };
        assert_eq!(machine.with_contact_law(linear).unwrap().contact_law(), linear);
    }
}
