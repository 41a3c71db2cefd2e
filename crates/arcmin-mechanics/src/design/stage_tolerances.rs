//! Tolerances of drives of eccentrics.

use super::StageProcess;
use super::schema::{At, default, section};
use crate::machine::{StageOffsets, StageTolerances};
use crate::units::{ARCMIN, UM};

/// A section of widths, its values in SI units, and every width by its key.
macro_rules! widths_of {
    ($(#[doc = $doc:literal])* $Name:ident: $($(#[doc = $of_key:literal])* $key:ident: $field:ident in $unit:ident, up to $most:literal;)*) => {
        section! {
            $(#[doc = $doc])*
            pub struct $Name {
                $($(#[doc = $of_key])* $key: f64 => default(0.0, 0.0, $most),)*
            }
        }

        impl $Name {
            /// Every width by its key in the design file, with its unit.
            pub const WIDTHS: &'static [StageWidth] = &[$(StageWidth {
                key: stringify!($key),
                unit: $unit,
                of: |tolerances| &mut tolerances.$field,
            },)*];

            /// In SI units; missing widths are those of the processes.
            fn resolve(&self, process: Option<&StageProcess>) -> StageTolerances {
                let width = |given: &At<f64>, key: &str| match (given.span.is_some(), process) {
                    (false, Some(process)) => process.tolerance(key),
                    _ => **given,
                };
                StageTolerances {
                    $($field: width(&self.$key, stringify!($key)) * $unit,)*
                    offsets: process.map_or_else(StageOffsets::default, StageProcess::remaining),
                    ..StageTolerances::default()
                }
            }

            /// Tolerances of the file in SI units; without the section those of the processes; `None` without
            /// either.
            pub(super) fn of(section: Option<&$Name>, process: Option<&StageProcess>) -> Option<StageTolerances> {
                match (section, process) {
                    (Some(section), _) => Some(section.resolve(process)),
                    (None, Some(process)) => {
                        let mut tolerances =
                            StageTolerances { offsets: process.remaining(), ..StageTolerances::default() };
                        $(tolerances.$field = process.tolerance(stringify!($key)) * $unit;)*
                        Some(tolerances)
                    }
                    (None, None) => None,
                }
            }
        }
    };
}

/// The sections of all families, from the widths of rings and flanks, of eccentrics, of output pins, and of second steps.
macro_rules! widths {
    (ring { $($ring:tt)* } eccentric { $($eccentric:tt)* } output { $($output:tt)* } step { $($step:tt)* }) => {
        widths_of! {
            /// Tolerances from which single stages are drawn with `--errors drawn --seed N`, as `[tolerances]`
            /// of RV reducers: ± widths, each three standard deviations of a normal distribution that is
            /// truncated there. The directions of run-outs are random.
            StageTolerancesSection: $($ring)* $($eccentric)* $($output)*
        }

        widths_of! {
            /// Tolerances from which drives of two rings are drawn, as `[tolerances]` of single stages: the
            /// ring at rest, the steps in it and the eccentrics.
            TwoRingTolerancesSection: $($ring)* $($eccentric)*
        }

        widths_of! {
            /// Tolerances of the second ring and the steps in it.
            SecondTolerancesSection: $($ring)* $($step)*
        }
    };
}

/// One width of [`StageTolerances`].
pub struct StageWidth {
    /// Key in the section of tolerances, with its unit at the end.
    pub key: &'static str,
    /// In m or rad.
    pub unit: f64,
    /// Field of the tolerances that the key sets.
    pub of: fn(&mut StageTolerances) -> &mut f64,
}

widths! {
    ring {
        /// Place of every ring pin, radial and tangential.
        pin_position_um: pin_position in UM, up to 500.0;
        /// Radius of every ring pin.
        pin_radius_um: pin_radius in UM, up to 500.0;
        /// Radius of the pin circle.
        pin_circle_radius_um: pin_circle_radius in UM, up to 500.0;
        /// Centre of the pin circle against the axis of input and output.
        pin_circle_offset_um: pin_circle_offset in UM, up to 500.0;
        /// Depth of all flanks of a drive in common: setting of the cut.
        flank_offset_um: flank_offset in UM, up to 500.0;
        /// Radial run-out of every flank against the bore of its disc.
        flank_run_out_um: flank_run_out in UM, up to 500.0;
        /// Cumulative pitch of every flank, spread over the orders 2 to 7 of the disc.
        flank_pitch_um: flank_pitch in UM, up to 500.0;
        /// Profile error that all lobes of a disc have in common: a wave along every lobe.
        flank_profile_um: flank_profile in UM, up to 500.0;
    }
    eccentric {
        /// Eccentricity of every eccentric.
        eccentricity_um: eccentricity in UM, up to 500.0;
        /// Phase of every eccentric.
        eccentric_phase_arcmin: eccentric_phase in ARCMIN, up to 600.0;
        /// Diametral clearance of every eccentric bearing, with its seats.
        eccentric_clearance_um: eccentric_clearance in UM, up to 500.0;
    }
    output {
        /// Radius of the circle of the output pins.
        output_pin_circle_radius_um: output_pin_circle_radius in UM, up to 500.0;
        /// Place of every output pin in its plate, radial and tangential.
        output_pin_position_um: output_pin_position in UM, up to 500.0;
        /// Radius of every output pin or roller.
        output_pin_radius_um: output_pin_radius in UM, up to 500.0;
        /// Place of every hole for an output pin, radial and tangential.
        bore_position_um: bore_position in UM, up to 500.0;
        /// Diameter of every hole for an output pin.
        bore_diameter_um: bore_diameter in UM, up to 500.0;
        /// Diameter of all holes for output pins of a drive in common: setting of the cut.
        bore_offset_um: bore_offset in UM, up to 500.0;
    }
    step {
        /// Rotation of every flank relative to that of the first step, as an arc length at its lobes.
        flank_turn_um: flank_turn in UM, up to 500.0;
    }
}
