//! Keys and names of the parts of drives of eccentrics, family by family.

use crate::results::{Quantity, decimals, quantity};

/// Keys and names of one part of a stage.
#[derive(Debug)]
pub struct PartKeys {
    /// Names in texts: of the part, of the part in a ring of one piece, and short for sums of play.
    pub name: &'static str,
    pub tooth: &'static str,
    pub short: &'static str,
    /// Name of the gap that causes the play.
    pub gap: &'static str,
    pub force: Quantity,
    /// Largest pressure; `None` for bearings.
    pub pressure: Option<Quantity>,
    pub closed_form: Quantity,
    pub loss: Quantity,
    pub play: Quantity,
}

/// Parts of a stage by their numbers.
pub const RING: usize = 0;
pub const OUTPUT: usize = 1;
pub const ECCENTRIC: usize = 2;

/// A value for every part of a stage; 0 for those that it does not have.
pub type OfParts = [f64; 3];

/// Keys of one stage.
#[derive(Debug)]
pub struct StageKeys {
    /// For readers.
    pub name: &'static str,
    /// Table of its flank, and keys of that.
    pub profile: &'static str,
    pub flank: [&'static str; 4],
    /// Tables of its ring pins, of its output pins and of the rolling elements of its eccentric bearings.
    pub contact: &'static str,
    pub output_pins: &'static str,
    pub eccentric_rollers: &'static str,
    /// Table of the depths along its flank, and keys of its wear.
    pub wear: &'static str,
    pub worn: WornKeys,
    /// Ring, output pins, eccentric bearings; `None` for parts that the stage does not have.
    pub parts: [Option<PartKeys>; 3],
}

/// Wear of ring, output pins and eccentric bearings of a stage.
#[derive(Debug)]
pub struct WornKeys {
    pub max_depth: Quantity,
    pub max_depth_at: Quantity,
    pub max_pin_depth: Quantity,
    pub loaded_pairs: Quantity,
    pub output_pins: Quantity,
    pub rollers: Quantity,
    pub holes: Quantity,
    pub eccentric: Quantity,
}

/// The stage whose keys have no prefix.
pub(super) fn main_of(stages: &[StageKeys]) -> usize {
    stages.iter().position(|stage| stage.profile == "profile").unwrap_or(0)
}

/// Columns of wear: prefix of the keys, place of the ring, name of the stage in front of parts.
macro_rules! worn {
    ($key:literal, $place:literal, $stage:literal) => {
        WornKeys {
            max_depth: quantity(
                concat!($key, "max_depth_um"),
                decimals(2),
                concat!("Largest wear depth of a flank", $place, "."),
            ),
            max_depth_at: quantity(
                concat!($key, "max_depth_at_deg"),
                decimals(1),
                concat!(
                    "Size |φ| of the meshing angle of the deepest wear of the flank",
                    $place,
                    "; empty without wear."
                ),
            ),
            max_pin_depth: quantity(
                concat!($key, "max_pin_depth_um"),
                decimals(2),
                concat!("Largest wear depth of a pin", $place, "."),
            ),
            loaded_pairs: quantity(
                concat!($key, "loaded_pairs"),
                decimals(1),
                concat!("Mean number of pins that carry force on one disc", $place, "."),
            ),
            output_pins: quantity(
                concat!($key, "output_pin_depth_um"),
                decimals(3),
                concat!("Largest wear depth of the ", $stage, "output pins, mean of the pins."),
            ),
            rollers: quantity(
                concat!($key, "roller_depth_um"),
                decimals(3),
                concat!("Wear depth of the bores of the rollers on the ", $stage, "output pins."),
            ),
            holes: quantity(
                concat!($key, "hole_depth_um"),
                decimals(3),
                concat!(
                    "Largest wear depth of the holes of the ",
                    $stage,
                    "output pins, mean of holes and discs."
                ),
            ),
            eccentric: quantity(
                concat!($key, "eccentric_clearance_growth_um"),
                decimals(3),
                concat!("Growth of the diametral clearance of the ", $stage, "eccentric bearings by wear."),
            ),
        }
    };
}

/// Keys of a flank, as those of [`profile::SUMMARY`](crate::analyses::profile::SUMMARY).
macro_rules! flank {
    ($key:literal) => {
        [
            concat!($key, "short_width_coefficient"),
            concat!($key, "inflection_deg"),
            concat!($key, "min_convex_flank_radius_mm"),
            concat!($key, "min_convex_flank_radius_at_deg"),
        ]
    };
}

/// Ring pins: prefix of the keys, name of a pin, of the ring, sentence of the play.
macro_rules! ring {
    ($key:literal, $pin:literal, $tooth:literal, $ring:literal, $play:literal, $closed:literal) => {
        Some(PartKeys {
            name: $pin,
            tooth: $tooth,
            short: $ring,
            gap: concat!("gap of the flank, ", $ring),
            force: quantity(
                concat!($key, "max_force_n"),
                decimals(0),
                concat!("Largest force of a ", $pin, "."),
            ),
            pressure: Some(quantity(
                concat!($key, "max_pressure_mpa"),
                decimals(0),
                concat!("Largest Hertz pressure between a ", $pin, " and a flank."),
            )),
            closed_form: quantity(
                concat!("closed_form.", $key, "ring_pin_force_n"),
                decimals(1),
                concat!(
                    "Largest force of a ",
                    $pin,
                    " if all pins of one side carry as equal springs, ",
                    $closed,
                    "."
                ),
            ),
            loss: quantity(
                concat!("loss_shares.", $key, "ring"),
                decimals(3),
                concat!("Share of the losses between pins and flanks, ", $ring, "."),
            ),
            play: quantity(
                concat!("play_chain.", $key, "ring_arcmin"),
                decimals(3),
                concat!(
                    "Two-sided play at the output by the gap Δ of the flank, input held, ",
                    $ring,
                    ": ",
                    $play,
                    "."
                ),
            ),
        })
    };
}

macro_rules! output_pins {
    ($key:literal, $stage:literal, $play:literal) => {
        Some(PartKeys {
            name: concat!($stage, "output pin"),
            tooth: concat!($stage, "output pin"),
            short: concat!($stage, "output pins"),
            gap: concat!("clearance of the ", $stage, "output pins in their holes"),
            force: quantity(
                concat!($key, "max_output_pin_force_n"),
                decimals(1),
                concat!("Largest force of the ", $stage, "output pins on a disc."),
            ),
            pressure: Some(quantity(
                concat!($key, "max_output_pin_pressure_mpa"),
                decimals(0),
                concat!("Largest Hertz pressure between ", $stage, "output pins or their rollers and holes."),
            )),
            closed_form: quantity(
                concat!("closed_form.", $key, "output_pin_force_n"),
                decimals(1),
                concat!(
                    "Largest force of the ",
                    $stage,
                    "output pins if half of them carry as equal springs, 4T/(z_w R_w)."
                ),
            ),
            loss: quantity(
                concat!("loss_shares.", $key, "output_pins"),
                decimals(3),
                concat!(
                    "Share of the losses between ",
                    $stage,
                    "output pins and holes, or of rollers on their pins."
                ),
            ),
            play: quantity(
                concat!("play_chain.", $key, "output_arcmin"),
                decimals(3),
                concat!(
                    "Two-sided play by the clearance δ of the ",
                    $stage,
                    "output pins in their holes: ",
                    $play,
                    " for a pin across the eccentric."
                ),
            ),
        })
    };
}

macro_rules! eccentric {
    ($key:literal, $stage:literal, $play:literal, $closed:literal) => {
        Some(PartKeys {
            name: concat!($stage, "eccentric bearing"),
            tooth: concat!($stage, "eccentric bearing"),
            short: concat!($stage, "eccentric bearing"),
            gap: concat!("clearance of the ", $stage, "eccentric bearing"),
            force: quantity(
                concat!($key, "eccentric_bearing_force_n"),
                decimals(1),
                concat!("Largest force of the ", $stage, "eccentric bearings."),
            ),
            pressure: None,
            closed_form: quantity(
                concat!("closed_form.", $key, "eccentric_bearing_force_n"),
                decimals(1),
                concat!("Force of the ", $stage, "eccentric bearings with equal springs: ", $closed, "."),
            ),
            loss: quantity(
                concat!("loss_shares.", $key, "eccentric_bearings"),
                decimals(3),
                concat!("Share of the losses of the ", $stage, "eccentric bearings."),
            ),
            play: quantity(
                concat!("play_chain.", $key, "eccentric_bearing_arcmin"),
                decimals(3),
                concat!(
                    "Two-sided play by the radial clearance c of the ",
                    $stage,
                    "eccentric bearing: ",
                    $play,
                    "."
                ),
            ),
        })
    };
}

/// Family by family, its stages from the input.
pub(super) static SINGLE: [StageKeys; 1] = [StageKeys {
    name: "stage",
    profile: "profile",
    flank: flank!(""),
    contact: "contact",
    output_pins: "output_pins",
    eccentric_rollers: "eccentric_rollers",
    wear: "wear",
    worn: worn!("", "", ""),
    parts: [
        ring!(
            "",
            "ring pin",
            "ring tooth",
            "ring",
            "2Δ m/(e z_c) for an even gap",
            "4T/(K1 z_c R) with the torque T of a disc"
        ),
        output_pins!("", "", "2δ/R_w"),
        eccentric!(
            "",
            "",
            "2c m/(e z_c)",
            "T m/(e z_c) across the eccentric, 4T/(π R_w) less the radial force of the ring along it"
        ),
    ],
}];

pub(super) static TWO_RING: [StageKeys; 2] = [
    StageKeys {
        name: "first ring",
        profile: "profile",
        flank: flank!(""),
        contact: "contact",
        output_pins: "",
        eccentric_rollers: "eccentric_rollers",
        wear: "wear",
        worn: worn!("", " in the first ring", ""),
        parts: [
            ring!(
                "",
                "pin of the first ring",
                "tooth of the first ring",
                "first ring",
                "2Δ/(e z_c1) z_c2/z_p2 for an even gap",
                "4M/(K1 z_c1 R) with the moment M = T z_c2/z_p2 of a disc"
            ),
            None,
            eccentric!(
                "",
                "",
                "2c/(e |i|)",
                "T/(e i) across the eccentric, the radial forces of both rings along it"
            ),
        ],
    },
    StageKeys {
        name: "second ring",
        profile: "second_profile",
        flank: flank!("second_"),
        contact: "second_contact",
        output_pins: "",
        eccentric_rollers: "second_eccentric_rollers",
        wear: "second_wear",
        worn: worn!("second_", " in the second ring", ""),
        parts: [
            ring!(
                "second_",
                "pin of the second ring",
                "tooth of the second ring",
                "second ring",
                "2Δ/(e z_p2) for an even gap",
                "4T/(K1 z_p2 R) with the torque T of a disc"
            ),
            None,
            None,
        ],
    },
];

pub(super) static TWO_STAGE: [StageKeys; 2] = [
    StageKeys {
        name: "first stage",
        profile: "first_stage_profile",
        flank: flank!("first_stage_"),
        contact: "first_stage_contact",
        output_pins: "first_stage_output_pins",
        eccentric_rollers: "first_stage_eccentric_rollers",
        wear: "first_stage_wear",
        worn: worn!("first_stage_", " of the first stage", "first-stage "),
        parts: [
            ring!(
                "first_stage_",
                "first-stage ring pin",
                "first-stage ring tooth",
                "first-stage ring",
                "2Δ m/(e z_c) over the ratio of the second stage",
                "4T/(K1 z_c R) with the torque T of a disc"
            ),
            output_pins!("first_stage_", "first-stage ", "2δ/R_w over the ratio of the second stage"),
            eccentric!(
                "first_stage_",
                "first-stage ",
                "2c m/(e z_c) over the ratio of the second stage",
                "as that of a single stage"
            ),
        ],
    },
    StageKeys {
        name: "second stage",
        profile: "profile",
        flank: flank!(""),
        contact: "contact",
        output_pins: "output_pins",
        eccentric_rollers: "eccentric_rollers",
        wear: "wear",
        worn: worn!("", " of the second stage", "second-stage "),
        parts: [
            ring!(
                "",
                "second-stage ring pin",
                "second-stage ring tooth",
                "second-stage ring",
                "2Δ m/(e z_c) for an even gap",
                "4T/(K1 z_c R) with the torque T of a disc"
            ),
            output_pins!("", "second-stage ", "2δ/R_w"),
            eccentric!("", "second-stage ", "2c m/(e z_c)", "as that of a single stage"),
        ],
    },
];

/// Whether a drive of these stages has output pins in holes of its discs.
pub(super) fn has_output_pins(stages: &[StageKeys]) -> bool {
    stages.iter().any(|stage| stage.parts[OUTPUT].is_some())
}
