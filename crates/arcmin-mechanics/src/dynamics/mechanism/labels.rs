//! Names under which compliance and lost motion of joints go.

/// Where compliance sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Part {
    /// Turning-arm bearings, between eccentrics and discs.
    TurningArm,
    /// Crank supports, between crankshafts and carrier.
    CrankSupport,
    /// Crankshafts that bend.
    CrankBending,
    /// Contacts of flanks and pins.
    Teeth,
    /// Pins in their grooves.
    PinSeat,
    /// Of elastic discs.
    Disc,
    /// Tooth contacts of sun and planets.
    GearStage,
    /// Torsion of the input shaft.
    InputShaft,
    /// Carrier between crank supports and output flange.
    Carrier,
    /// Main bearings in the housing.
    Housing,
    /// Of an elastic housing.
    PinRing,
}

impl Part {
    /// All of them, in the order of tables.
    pub const ALL: [Part; 11] = [
        Part::TurningArm,
        Part::CrankSupport,
        Part::CrankBending,
        Part::Teeth,
        Part::PinSeat,
        Part::Disc,
        Part::GearStage,
        Part::InputShaft,
        Part::Carrier,
        Part::Housing,
        Part::PinRing,
    ];

    /// Words for tables.
    pub fn name(self) -> &'static str {
        match self {
            Part::TurningArm => "turning-arm bearings",
            Part::CrankSupport => "crank supports",
            Part::CrankBending => "crankshaft bending",
            Part::Teeth => "cycloid teeth and pins",
            Part::PinSeat => "pin seats",
            Part::Disc => "cycloid discs",
            Part::GearStage => "gear stage",
            Part::InputShaft => "input shaft torsion",
            Part::Carrier => "carrier",
            Part::Housing => "main bearings in the housing",
            Part::PinRing => "housing around the pins",
        }
    }
}

/// Where lost motion comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Cause {
    /// Metal that the flanks of the discs have lost.
    FlankWear,
    /// Metal that the pins have lost.
    PinWear,
    /// Gaps ground into the flanks on purpose.
    FlankModification,
    /// Ways through all clearances are no straight lines: contacts come nearer to the root, where normals turn,
    /// and cranks lead the discs along circles. Of second order in the way, of either sign.
    Curvature,
    /// Clearance of the new turning-arm bearings.
    TurningArmClearance,
    /// Growth of their clearance.
    TurningArmWear,
    /// Clearance of the new crank supports.
    CrankSupportClearance,
    /// Growth of their clearance.
    CrankSupportWear,
    /// Backlash of the new gears.
    GearBacklash,
    /// Growth of their backlash.
    GearWear,
    /// Clearance of the main bearings.
    MainBearingClearance,
    /// Elastic approaches at ±3 % of rated torque.
    Elastic,
    /// Gaps opened (or, negative, closed) by manufacturing errors.
    ManufacturingErrors,
}

impl Cause {
    /// All of them, in the order of tables and of
    /// [`LostMotionSplit::causes`](crate::dynamics::LostMotionSplit::causes).
    pub const ALL: [Cause; 13] = [
        Cause::FlankWear,
        Cause::PinWear,
        Cause::FlankModification,
        Cause::Curvature,
        Cause::TurningArmClearance,
        Cause::TurningArmWear,
        Cause::CrankSupportClearance,
        Cause::CrankSupportWear,
        Cause::GearBacklash,
        Cause::GearWear,
        Cause::MainBearingClearance,
        Cause::Elastic,
        Cause::ManufacturingErrors,
    ];

    /// Words for tables.
    pub fn name(self) -> &'static str {
        match self {
            Cause::FlankWear => "wear of the disc flanks",
            Cause::PinWear => "wear of the pins",
            Cause::FlankModification => "modification of the flanks",
            Cause::Curvature => "curvature of flanks and cranks on the way",
            Cause::TurningArmClearance => "clearance of the turning-arm bearings, new",
            Cause::TurningArmWear => "wear of the turning-arm bearings",
            Cause::CrankSupportClearance => "clearance of the crank supports, new",
            Cause::CrankSupportWear => "wear of the crank supports",
            Cause::GearBacklash => "backlash of the gears, new",
            Cause::GearWear => "wear of the gears",
            Cause::MainBearingClearance => "clearance of the main bearings",
            Cause::Elastic => "elastic, at ±3 % of rated torque",
            Cause::ManufacturingErrors => "manufacturing errors",
        }
    }

    /// Word for columns and keys.
    pub fn key(self) -> &'static str {
        match self {
            Cause::FlankWear => "flank_wear",
            Cause::PinWear => "pin_wear",
            Cause::FlankModification => "flank_modification",
            Cause::Curvature => "curvature",
            Cause::TurningArmClearance => "turning_arm_clearance",
            Cause::TurningArmWear => "turning_arm_wear",
            Cause::CrankSupportClearance => "crank_support_clearance",
            Cause::CrankSupportWear => "crank_support_wear",
            Cause::GearBacklash => "gear_backlash",
            Cause::GearWear => "gear_wear",
            Cause::MainBearingClearance => "main_bearing_clearance",
            Cause::Elastic => "elastic",
            Cause::ManufacturingErrors => "manufacturing_errors",
        }
    }
}
