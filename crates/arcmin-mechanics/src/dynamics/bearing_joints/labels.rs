//! Names of the parts of an RV reducer and of the causes of its lost motion.

use crate::dynamics::mechanism::{Cause, Part, PlayLabel};

/// Turning-arm bearings, between eccentrics and discs.
pub const TURNING_ARM: PlayLabel = PlayLabel {
    part: Part::new("turning-arm bearings"),
    play: Cause::new("turning_arm_clearance", "clearance of the turning-arm bearings, new"),
    wear: Cause::new("turning_arm_wear", "wear of the turning-arm bearings"),
};
/// Crank supports, between crankshafts and carrier.
pub const CRANK_SUPPORT: PlayLabel = PlayLabel {
    part: Part::new("crank supports"),
    play: Cause::new("crank_support_clearance", "clearance of the crank supports, new"),
    wear: Cause::new("crank_support_wear", "wear of the crank supports"),
};
/// Tooth contacts of sun and planets.
pub const GEARS: PlayLabel = PlayLabel {
    part: Part::new("gear stage"),
    play: Cause::new("gear_backlash", "backlash of the gears, new"),
    wear: Cause::new("gear_wear", "wear of the gears"),
};
/// Bending of the crankshafts.
pub const CRANK_BENDING: Part = Part::new("crankshaft bending");
/// Torsion of the input shaft.
pub const INPUT_SHAFT: Part = Part::new("input shaft torsion");
/// Carrier, between crank supports and output flange.
pub const CARRIER: Part = Part::new("carrier");
/// Main bearings in the housing.
pub const HOUSING: Part = Part::new("main bearings in the housing");
/// An elastic housing.
pub const PIN_RING: Part = Part::new("housing around the pins");
/// Clearance of the main bearings.
pub const MAIN_BEARING_CLEARANCE: Cause =
    Cause::new("main_bearing_clearance", "clearance of the main bearings");

/// All parts, in the order of tables.
pub const PARTS: [Part; 11] = [
    TURNING_ARM.part,
    CRANK_SUPPORT.part,
    CRANK_BENDING,
    Part::TEETH,
    Part::PIN_SEAT,
    Part::DISC,
    GEARS.part,
    INPUT_SHAFT,
    CARRIER,
    HOUSING,
    PIN_RING,
];

/// All causes, in the order of tables and of [`LostMotionSplit::causes`](crate::dynamics::LostMotionSplit::causes).
pub const CAUSES: [Cause; 13] = [
    Cause::FLANK_WEAR,
    Cause::PIN_WEAR,
    Cause::FLANK_MODIFICATION,
    Cause::CURVATURE,
    TURNING_ARM.play,
    TURNING_ARM.wear,
    CRANK_SUPPORT.play,
    CRANK_SUPPORT.wear,
    GEARS.play,
    GEARS.wear,
    MAIN_BEARING_CLEARANCE,
    Cause::ELASTIC,
    Cause::MANUFACTURING_ERRORS,
];
