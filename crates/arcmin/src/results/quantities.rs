//! Quantities of several tables and summaries, each with one name and one meaning.

use super::{PLAIN, Quantity, decimals, digits, quantity};

pub const HOURS: Quantity = quantity("hours", decimals(0), "Running hours since new.");

pub const RATIO: Quantity = quantity(
    "ratio",
    digits(6),
    "Ratio of input to output speed; negative if they turn in opposite directions.",
);

pub const DISC: Quantity =
    quantity("disc", PLAIN, "Cycloid disc, counted from 0; empty where all discs are alike.");

pub const PIN: Quantity = quantity("pin", PLAIN, "Pin of the ring, counted from 0 at the x axis.");

pub const CRANK_ANGLE: Quantity =
    quantity("crank_angle_deg", decimals(2), "Angle of the crankshafts in the frame of the housing.");

pub const ROLLER: Quantity = quantity("roller", digits(3), "Rolling element, counted from 0.");
pub const ROLLER_DIRECTION: Quantity = quantity(
    "direction_deg",
    decimals(3),
    "Direction from the middle of the eccentric to the rolling element in the frame of the ring, from 0 to 360.",
);
pub const ROLLER_FORCE: Quantity =
    quantity("force_n", decimals(2), "Radial force of the rolling element on the disc.");

pub const MESHING_ANGLE: Quantity = quantity(
    "meshing_angle_deg",
    decimals(2),
    "Meshing angle: angle of the pin from the direction of the eccentric, in (−180, 180]. Negative angles \
     carry a positive torque.",
);

pub const MAX_DEPTH: Quantity = quantity(
    "max_depth_um",
    decimals(2),
    "Largest wear depth of a flank; if discs differ, of the flank with the deepest wear.",
);

pub const MAX_DEPTH_AT: Quantity = quantity(
    "max_depth_at_deg",
    decimals(1),
    "Size |φ| of the meshing angle of the deepest wear; empty without wear.",
);

pub const MAX_PIN_DEPTH: Quantity = quantity("max_pin_depth_um", decimals(2), "Largest wear depth of a pin.");

pub const PRELOAD: Quantity =
    quantity("preload_n", decimals(1), "Largest force of a pin without load; 0 with play.");
pub const PRELOAD_FRICTION: Quantity = quantity(
    "preload_friction_n_m",
    decimals(3),
    "Friction torque at the output due to the preload, with the flank friction of the design; mean over the cycle.",
);
pub const PLAY: Quantity = quantity(
    "play_arcmin",
    decimals(3),
    "One-sided play at the output with the input locked, no load, mean over one full period. \
     Negative with interference: minus the least relief that removes the preload, as an angle.",
);

pub const FREE_TRAVEL: Quantity = quantity(
    "free_travel_arcmin",
    decimals(3),
    "Travel of the output at no load from one flank to the other, input locked.",
);

pub const TE_NO_LOAD: Quantity = quantity(
    "te_no_load_arcmin",
    decimals(3),
    "Mean output error θ_out − θ_in/i at first contact of the flank that carries the rated torque. Negative: the \
         output lags.",
);

pub const TE_LOADED: Quantity = quantity(
    "te_loaded_arcmin",
    decimals(3),
    "Mean output error θ_out − θ_in/i under load, input locked: play and elastic wind-up. Negative: the \
     output lags.",
);

pub const TE_LOADED_PEAK_TO_PEAK: Quantity = quantity(
    "te_loaded_peak_to_peak_arcmin",
    decimals(4),
    "Peak to peak of the output error under load over one full period.",
);

pub const LOST_MOTION: Quantity = quantity(
    "lost_motion_arcmin",
    decimals(3),
    "Lost motion of the whole machine in its bearings: output angle between −3 % and +3 % of rated torque, \
     input locked; with friction the middle of the loop. The limit of lost motion applies to this value.",
);

pub const CONTACT_LOST_MOTION: Quantity = quantity(
    "contact_lost_motion_arcmin",
    decimals(3),
    "Lost motion of the tooth contacts alone, with ideal joints.",
);

pub const MAX_FORCE: Quantity = quantity(
    "max_force_n",
    decimals(0),
    "Largest force of one pin on one disc over one full period. Over a life, at the largest torque of rating \
     and duty.",
);

pub const MAX_PRESSURE: Quantity = quantity(
    "max_pressure_mpa",
    decimals(0),
    "Largest Hertz pressure between pin and flank over one full period. Over a life, at the largest torque of \
     rating and duty; largest force and largest pressure occur at different pins.",
);

pub const LOADED_PAIRS: Quantity =
    quantity("loaded_pairs", decimals(1), "Mean number of pins that carry force on one disc.");

pub const TORSIONAL_STIFFNESS: Quantity = quantity(
    "torsional_stiffness_n_m_per_arcmin",
    decimals(0),
    "Tangent stiffness at the output, input locked, mean over the cycle. With ideal joints that of the teeth alone.",
);

pub const TORQUE: Quantity =
    quantity("torque_n_m", decimals(1), "Output torque; positive against positive output motion.");

pub const FORCE: Quantity = quantity(
    "force_n",
    decimals(1),
    "Force between pin and flank. At one crank position in contact.csv; in wear.csv the mean over one full period \
         at this place of the flank; in turning_arm_rollers.csv the radial force of the rolling element on the disc.",
);

pub const PRESSURE: Quantity =
    quantity("pressure_mpa", decimals(0), "Largest Hertz pressure in the contact.");

pub const WEAR_UM: Quantity =
    quantity("wear_um", decimals(2), "Uniform depth removed from the flank before the computation.");

pub const WEAR_COEFFICIENT: Quantity = quantity(
    "wear_coefficient_per_pa",
    digits(4),
    "Wear coefficient k of Archard's law, depth per pass Δh = k (F/B) ξ. In mm²/N it is 10⁶ times this.",
);

pub const ORDER: Quantity = quantity("order", digits(5), "Order: periods per turn of the output.");

pub const AMPLITUDE: Quantity = quantity("amplitude_arcmin", digits(3), "Amplitude of the line.");

pub const SPECIFIC_SLIDING: Quantity = quantity(
    "specific_sliding",
    digits(4),
    "Specific sliding ξ on the disc: sliding speed over the speed of the contact along the flank.",
);

pub const JOINTS: Quantity = quantity("joints", PLAIN, "Joints between the bodies: ideal or bearings.");

pub const DISCS: Quantity = quantity("discs", PLAIN, "Cycloid discs: rigid or elastic.");

pub const BODIES: Quantity =
    quantity("bodies", PLAIN, "Carrier, housing, crank seats and the rims of the discs: rigid or elastic.");

pub const ERRORS_SOURCE: Quantity = quantity(
    "errors.source",
    PLAIN,
    "Manufacturing errors: given in the design, drawn from its tolerances, or none.",
);

pub const ERRORS_SEED: Quantity = quantity("errors.seed", PLAIN, "Seed of the machine drawn.");

pub const METHOD: Quantity = quantity("method", PLAIN, "How the load is shared: equilibrium or closed-form.");

pub const TIME: Quantity = quantity("time_s", decimals(4), "Time since the start of the run.");

pub const LARGEST_PIN_FORCE: Quantity = quantity(
    "largest_pin_force_n",
    decimals(1),
    "Largest force of one pin on one disc in the running machine.",
);

pub const FLANK_UPDATES: Quantity =
    quantity("flank_updates", PLAIN, "Updates of the flank: steps of the coupled computation.");

pub const VALUE: Quantity = quantity("value", digits(4), "The value found, in the unit given.");

pub const LIMIT: Quantity = quantity("limit", PLAIN, "Name of the limit; in findings its value.");

pub const UNIT: Quantity = quantity("unit", PLAIN, "Unit of the value and of the limit.");

pub const TE: Quantity =
    quantity("te_arcmin", decimals(4), "Transmission error θ_out − θ_in/i. Negative: the output lags.");

pub const ORDERS: Quantity =
    quantity("orders", PLAIN, "Largest spectral lines of the transmission error with their likely causes.");

pub const PART: Quantity = quantity("part", PLAIN, "Part of the machine.");

pub const EFFICIENCY: Quantity = quantity(
    "efficiency",
    decimals(3),
    "Output power over input power in steady motion. In a summary at rated torque and speed.",
);

pub const BACKLASH: Quantity = quantity(
    "backlash_arcmin",
    decimals(3),
    "Width of the hysteresis loop at zero torque: both sides, friction included.",
);

pub const STIFFNESS: Quantity = quantity(
    "stiffness_n_m_per_arcmin",
    decimals(1),
    "Torsional stiffness b/a: slope of the loop between 50 and 100 % of rated torque, input locked.",
);

pub const SOFT_STIFFNESS: Quantity = quantity(
    "soft_stiffness_n_m_per_arcmin",
    decimals(1),
    "Slope of the loop between 3 and 15 % of rated torque (K1 of makers' torsion curves).",
);

pub const MIDDLE_STIFFNESS: Quantity = quantity(
    "middle_stiffness_n_m_per_arcmin",
    decimals(1),
    "Slope of the loop between 15 and 50 % of rated torque (K2; `stiffness_n_m_per_arcmin` is K3).",
);

pub const QUANTITY: Quantity = quantity("quantity", PLAIN, "Quantity of the row.");

pub const BEARING: Quantity = quantity("bearing", PLAIN, "Kind and place of the bearing.");

pub const HOURS_TO_LOST_MOTION_LIMIT: Quantity = quantity(
    "hours_to_lost_motion_limit",
    decimals(0),
    "Hours until the lost motion of the whole machine reaches its limit.",
);
