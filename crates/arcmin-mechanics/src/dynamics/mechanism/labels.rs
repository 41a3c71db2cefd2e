//! Names under which compliance and lost motion of joints go. Joints take them when they are constructed; those of one
//! kind of machine stand beside it.

/// Where compliance sits, by its words for tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Part(&'static str);

impl Part {
    /// Contacts of flanks and pins.
    pub const TEETH: Part = Part("cycloid teeth and pins");
    /// Pins in their grooves.
    pub const PIN_SEAT: Part = Part("pin seats");
    /// Elastic discs.
    pub const DISC: Part = Part("cycloid discs");

    /// A part by its words for tables.
    pub const fn new(name: &'static str) -> Part {
        Part(name)
    }

    /// Words for tables.
    pub fn name(self) -> &'static str {
        self.0
    }
}

/// Where lost motion comes from, by its word for columns and its words for tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Cause {
    key: &'static str,
    name: &'static str,
}

impl Cause {
    /// Metal that the flanks of the discs have lost.
    pub const FLANK_WEAR: Cause = Cause::new("flank_wear", "wear of the disc flanks");
    /// Metal that the pins have lost.
    pub const PIN_WEAR: Cause = Cause::new("pin_wear", "wear of the pins");
    /// Gaps ground into the flanks on purpose.
    pub const FLANK_MODIFICATION: Cause = Cause::new("flank_modification", "modification of the flanks");
    /// Ways through all clearances are no straight lines: contacts come nearer to the root, where normals turn,
    /// and cranks lead the discs along circles. Of second order in the way, of either sign.
    pub const CURVATURE: Cause = Cause::new("curvature", "curvature of flanks and cranks on the way");
    /// Elastic approaches at ±3 % of rated torque.
    pub const ELASTIC: Cause = Cause::new("elastic", "elastic, at ±3 % of rated torque");
    /// Gaps opened (or, negative, closed) by manufacturing errors.
    pub const MANUFACTURING_ERRORS: Cause = Cause::new("manufacturing_errors", "manufacturing errors");

    /// A cause by its word for columns and its words for tables.
    pub const fn new(key: &'static str, name: &'static str) -> Cause {
        Cause { key, name }
    }

    /// Words for tables.
    pub fn name(self) -> &'static str {
        self.name
    }

    /// Word for columns and keys.
    pub fn key(self) -> &'static str {
        self.key
    }
}

/// Names of a joint with play.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlayLabel {
    /// Of its compliance.
    pub part: Part,
    /// Of its play as new.
    pub play: Cause,
    /// Of what wear adds to the play.
    pub wear: Cause,
}
