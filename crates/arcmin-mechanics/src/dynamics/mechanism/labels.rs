//! Names for the compliance and lost motion of joints. Joints receive them at construction; those of one kind
//! of machine are defined in its module.

/// Location of compliance, with its name in tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Part(&'static str);

impl Part {
    /// Contacts of flanks and pins.
    pub const TEETH: Part = Part("cycloid teeth and pins");
    /// Pins in their grooves.
    pub const PIN_SEAT: Part = Part("pin seats");
    /// Elastic discs.
    pub const DISC: Part = Part("cycloid discs");

    /// A part with its name in tables.
    pub const fn new(name: &'static str) -> Part {
        Part(name)
    }

    /// Name in tables.
    pub fn name(self) -> &'static str {
        self.0
    }
}

/// Cause of lost motion, with its key for columns and its name in tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Cause {
    key: &'static str,
    name: &'static str,
}

impl Cause {
    /// Wear depth of the disc flanks.
    pub const FLANK_WEAR: Cause = Cause::new("flank_wear", "wear of the disc flanks");
    /// Wear depth of the pins.
    pub const PIN_WEAR: Cause = Cause::new("pin_wear", "wear of the pins");
    /// Gaps by the modification of the flanks.
    pub const FLANK_MODIFICATION: Cause = Cause::new("flank_modification", "modification of the flanks");
    /// Second-order effect of displacements within clearances, of either sign: contacts move towards the root,
    /// where the direction of normals changes, and cranks lead the discs on circles.
    pub const CURVATURE: Cause = Cause::new("curvature", "curvature of flanks and crank paths");
    /// Elastic approaches at ±3 % of rated torque.
    pub const ELASTIC: Cause = Cause::new("elastic", "elastic, at ±3 % of rated torque");
    /// Change of gaps by manufacturing errors, of either sign.
    pub const MANUFACTURING_ERRORS: Cause = Cause::new("manufacturing_errors", "manufacturing errors");

    /// A cause with its key for columns and its name in tables.
    pub const fn new(key: &'static str, name: &'static str) -> Cause {
        Cause { key, name }
    }

    /// Name in tables.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// Key for columns.
    pub fn key(self) -> &'static str {
        self.key
    }
}

/// Names of a joint with clearance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlayLabel {
    /// Name of its compliance.
    pub part: Part,
    /// Name of its clearance when new.
    pub play: Cause,
    /// Name of the increase of the clearance by wear.
    pub wear: Cause,
}
