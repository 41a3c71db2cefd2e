//! Deviations of one real machine: given individually, or drawn from tolerances.

use super::Section;
use super::field::Choice;
use super::schema::{At, default, optional, required, section, word};
use super::sections::SECTION_OR_DEFAULTS;
use crate::geometry::FlankDirection;

section! {
    /// Manufacturing errors of one machine, used with bearings (`rig`, and every command with `--joints
    /// bearings`). Pins, discs and crankshafts are counted from 1; parts that are not listed have no error.
    pub struct ErrorsSection {
        /// Added to the radius of the pin circle.
        pin_circle_radius_um: f64 => default(0.0, -500.0, 500.0),
        /// Added to the radius of every pin.
        pin_radius_um: f64 => default(0.0, -500.0, 500.0),
        /// Centre of the pin circle against the axis of main bearings and sun; the phase is an angle in the
        /// housing.
        pin_circle_offset: Section<RunOutSection> => SECTION_OR_DEFAULTS,
        /// Single pins.
        pins: Vec<At<Section<PinErrorSection>>> => optional(0.0, 0.0),
        /// Flanks as harmonics.
        flanks: Vec<At<Section<FlankErrorSection>>> => optional(0.0, 0.0),
        /// Flanks as measured.
        measured_flanks: Vec<At<Section<MeasuredFlankSection>>> => optional(0.0, 0.0),
        /// Bores of the discs.
        disc_bores: Vec<At<Section<DiscBoreSection>>> => optional(0.0, 0.0),
        /// Eccentrics.
        eccentrics: Vec<At<Section<EccentricErrorSection>>> => optional(0.0, 0.0),
        /// Bores of the carrier.
        carrier_bores: Vec<At<Section<CarrierBoreSection>>> => optional(0.0, 0.0),
        /// Journals of the crank supports against the axis of their shaft.
        journals: Vec<At<Section<ShaftRunOutSection>>> => optional(0.0, 0.0),
        /// Gears of the planets against the axis of their shaft.
        planets: Vec<At<Section<ShaftRunOutSection>>> => optional(0.0, 0.0),
        /// Seats of the main bearings on the carrier against the axis of its bores.
        carrier: Section<RunOutSection> => SECTION_OR_DEFAULTS,
        /// Gear of the sun against its axis.
        sun: Section<RunOutSection> => SECTION_OR_DEFAULTS,
    }

    /// An axis that is off.
    pub struct RunOutSection {
        /// Distance of the axes: half of the reading of a dial gauge over a turn.
        amplitude_um: f64 => default(0.0, 0.0, 500.0),
        /// Angle on the part towards which the axis is off.
        phase_deg: f64 => default(0.0, -360.0, 360.0),
    }

    /// An axis on one crankshaft that is off.
    pub struct ShaftRunOutSection {
        /// Number of the crankshaft.
        crankshaft: usize => required(1.0, 6.0),
        /// Distance of the axes: half of the reading of a dial gauge over a turn.
        amplitude_um: f64 => required(0.0, 500.0),
        /// Angle on the shaft towards which the axis is off; 0 is the eccentric of disc 1.
        phase_deg: f64 => default(0.0, -360.0, 360.0),
    }

    /// Place and size of one pin.
    pub struct PinErrorSection {
        /// Number of the pin; pin 1 lies on the x axis, the others follow counter-clockwise.
        pin: usize => required(1.0, 2400.0),
        /// Outward.
        radial_um: f64 => default(0.0, -500.0, 500.0),
        /// Counter-clockwise.
        tangential_um: f64 => default(0.0, -500.0, 500.0),
        /// Added to its radius.
        radius_um: f64 => default(0.0, -500.0, 500.0),
    }

    /// One harmonic around a disc's flank: amplitude × cos(order × (τ − phase)) at the angle τ on the disc.
    pub struct FlankErrorSection {
        /// Number of the disc.
        disc: usize => required(1.0, 6.0),
        /// Direction of the deviation.
        kind: FlankDirection => word(),
        /// Waves around the disc; 0 is the same depth everywhere.
        order: usize => required(0.0, 4000.0),
        /// Amplitude.
        amplitude_um: f64 => required(-500.0, 500.0),
        /// Angle on the disc of a crest; 0 is a root of the flank, on the x axis of disc 1.
        phase_deg: f64 => default(0.0, -360.0, 360.0),
    }

    /// A flank measured around the whole disc.
    pub struct MeasuredFlankSection {
        /// Number of the disc.
        disc: usize => required(1.0, 6.0),
        /// CSV file in the directory of the design file with the columns `angle_deg` (on the disc, rising; 0 is
        /// a root of the flank) and `depth_um` (missing metal along the normal). It needs four points per lobe
        /// or more and is resampled to 32, each the mean over its step.
        file: String => word(),
    }

    /// One eccentric.
    pub struct EccentricErrorSection {
        /// Number of the crankshaft.
        crankshaft: usize => required(1.0, 6.0),
        /// Number of the disc on it.
        disc: usize => required(1.0, 6.0),
        /// Added to the eccentricity.
        eccentricity_um: f64 => default(0.0, -500.0, 500.0),
        /// Added to its phase on the shaft.
        phase_arcmin: f64 => default(0.0, -600.0, 600.0),
    }

    /// Tolerances from which machines are drawn with `--errors drawn --seed N`: ± widths, each three standard
    /// deviations of a normal distribution that is truncated there. The directions of run-outs are random.
    pub struct TolerancesSection {
        /// Place of every pin, radial and tangential.
        pin_position_um: f64 => default(0.0, 0.0, 500.0),
        /// Radius of every pin.
        pin_radius_um: f64 => default(0.0, 0.0, 500.0),
        /// Radius of the pin circle.
        pin_circle_radius_um: f64 => default(0.0, 0.0, 500.0),
        /// Centre of the pin circle.
        pin_circle_offset_um: f64 => default(0.0, 0.0, 500.0),
        /// Eccentricity of every eccentric.
        eccentricity_um: f64 => default(0.0, 0.0, 500.0),
        /// Phase of every eccentric.
        eccentric_phase_arcmin: f64 => default(0.0, 0.0, 600.0),
        /// Place of every bore in discs and carrier, radial and tangential.
        bore_position_um: f64 => default(0.0, 0.0, 500.0),
        /// Diameter of every bore in discs and carrier.
        bore_diameter_um: f64 => default(0.0, 0.0, 500.0),
        /// Radial run-out of every flank.
        flank_run_out_um: f64 => default(0.0, 0.0, 500.0),
        /// Cumulative pitch of every flank, spread over the orders 2 to 7 of the disc.
        flank_pitch_um: f64 => default(0.0, 0.0, 500.0),
        /// Profile error that all lobes of a disc have in common.
        flank_profile_um: f64 => default(0.0, 0.0, 500.0),
        /// Journals of the crankshafts.
        journal_run_out_um: f64 => default(0.0, 0.0, 500.0),
        /// Gears of the planets.
        planet_run_out_um: f64 => default(0.0, 0.0, 500.0),
        /// Seats of the main bearings on the carrier.
        carrier_run_out_um: f64 => default(0.0, 0.0, 500.0),
        /// Gear of the sun.
        sun_run_out_um: f64 => default(0.0, 0.0, 500.0),
    }
}

/// Sections for bores: which one, and the three deviations that all bores have.
macro_rules! bores {
    ($($(#[doc = $doc:literal])* $Name:ident { $($which:tt)* })*) => {$(
        section! {
            $(#[doc = $doc])*
            pub struct $Name {
                $($which)*
                /// Away from the centre of the part.
                radial_um: f64 => default(0.0, -500.0, 500.0),
                /// Counter-clockwise.
                tangential_um: f64 => default(0.0, -500.0, 500.0),
                /// Added to the diameter: widens the clearance of the bearing in it.
                diameter_um: f64 => default(0.0, -100.0, 500.0),
            }
        }
    )*};
}

bores! {
    /// Place and size of a bore for a turning-arm bearing.
    DiscBoreSection {
        /// Number of the disc.
        disc: usize => required(1.0, 6.0),
        /// Number of the crankshaft.
        crankshaft: usize => required(1.0, 6.0),
    }
    /// Place and size of the bores for the supports of a crankshaft.
    CarrierBoreSection {
        /// Number of the crankshaft.
        crankshaft: usize => required(1.0, 6.0),
    }
}

impl Choice for FlankDirection {
    const WORDS: &'static [(&'static str, &'static str)] = &[
        ("radial", "flank displaced towards the centre of the disc; order 1 is its radial run-out"),
        ("pitch", "flank displaced counter-clockwise: cumulative pitch"),
        ("profile", "depth along the normal; a multiple of the lobes is common to all of them"),
    ];
    const VALUES: &'static [FlankDirection] =
        &[FlankDirection::Inwards, FlankDirection::Around, FlankDirection::Normal];
}
