//! Errors of one drive of eccentrics, given individually.

use super::deviations::{Numbers, run_out, slot};
use super::error::Source;
use super::manufacturing::{FlankErrorSection, PinErrorSection, RunOutSection};
use super::schema::{At, default, optional, required, section};
use super::sections::SECTION_OR_DEFAULTS;
use super::{DesignError, Section};
use crate::geometry::{FlankError, FlankHarmonic};
use crate::machine::{BoreError, EccentricError, PartCounts, PinError, StageErrors};
use crate::units::{ARCMIN, DEG, UM};

type Result<T> = std::result::Result<T, Box<DesignError>>;

/// Sections of errors of one ring and the flanks in it, and of further parts of the stage.
macro_rules! errors_of_rings {
    ($($(#[doc = $doc:literal])* $Name:ident { $($more:tt)* })*) => {$(
        section! {
            $(#[doc = $doc])*
            pub struct $Name {
                /// Added to the radius of the pin circle.
                pin_circle_radius_um: f64 => default(0.0, -500.0, 500.0),
                /// Added to the radius of every ring pin.
                pin_radius_um: f64 => default(0.0, -500.0, 500.0),
                /// Centre of the pin circle against the axis of input and output.
                pin_circle_offset: Section<RunOutSection> => SECTION_OR_DEFAULTS,
                /// Single ring pins.
                pins: Vec<At<Section<PinErrorSection>>> => optional(0.0, 0.0),
                /// Flanks as harmonics.
                flanks: Vec<At<Section<FlankErrorSection>>> => optional(0.0, 0.0),
                $($more)*
            }
        }

        impl $Name {
            /// Errors of ring and flanks in SI units.
            fn of_ring(&self, counts: PartCounts, source: &Source) -> Result<StageErrors> {
                let mut all = StageErrors {
                    pin_circle_radius: *self.pin_circle_radius_um * UM,
                    pin_radius: *self.pin_radius_um * UM,
                    pin_circle_offset: run_out(&self.pin_circle_offset),
                    ..StageErrors::default()
                };
                pins(&self.pins, &mut all.pins, (counts.ring_pins, "pin"), source)?;
                flanks(&self.flanks, &mut all.flanks, counts.discs, source)?;
                Ok(all)
            }
        }
    )*};
}

errors_of_rings! {
    /// Manufacturing errors of one single stage, used by `contact`, `wear`, `rig`, `simulate` and `life`. Pins
    /// and discs are counted from 1; parts that are not listed have no error.
    StageErrorsSection {
        /// Eccentrics and their bearings.
        eccentrics: Vec<At<Section<StageEccentricErrorSection>>> => optional(0.0, 0.0),
        /// Added to the radius of the circle of the output pins.
        output_pin_circle_radius_um: f64 => default(0.0, -500.0, 500.0),
        /// Added to the radius of every output pin or roller.
        output_pin_radius_um: f64 => default(0.0, -500.0, 500.0),
        /// Single output pins; the radius is that of the roller.
        output_pins: Vec<At<Section<PinErrorSection>>> => optional(0.0, 0.0),
        /// Holes for the output pins.
        holes: Vec<At<Section<HoleErrorSection>>> => optional(0.0, 0.0),
    }

    /// Manufacturing errors of one drive of two rings, used by `contact`, `wear`, `rig`, `simulate` and `life`:
    /// the ring at rest, the steps in it and the eccentrics. With several discs, each has its own pins in this
    /// ring, numbered consecutively from disc to disc.
    TwoRingErrorsSection {
        /// Eccentrics and their bearings.
        eccentrics: Vec<At<Section<StageEccentricErrorSection>>> => optional(0.0, 0.0),
    }

    /// Manufacturing errors of the second ring and of the steps in it. A rotation of a flank relative to that
    /// of the first step is the harmonic of order 0 of the kind `around`.
    SecondErrorsSection {}
}

section! {
    /// One eccentric and its bearing.
    pub struct StageEccentricErrorSection {
        /// Number of the disc on it.
        disc: usize => required(1.0, 6.0),
        /// Added to the eccentricity.
        eccentricity_um: f64 => default(0.0, -500.0, 500.0),
        /// Added to its phase on the shaft.
        phase_arcmin: f64 => default(0.0, -600.0, 600.0),
        /// Added to the diametral clearance of its bearing.
        clearance_um: f64 => default(0.0, -500.0, 500.0),
    }

    /// Place and size of the hole for an output pin.
    pub struct HoleErrorSection {
        /// Number of the disc.
        disc: usize => required(1.0, 6.0),
        /// Number of the output pin.
        pin: usize => required(1.0, 60.0),
        /// Away from the centre of the disc.
        radial_um: f64 => default(0.0, -500.0, 500.0),
        /// Counter-clockwise.
        tangential_um: f64 => default(0.0, -500.0, 500.0),
        /// Added to the diameter.
        diameter_um: f64 => default(0.0, -500.0, 500.0),
    }
}

impl StageErrorsSection {
    /// In SI units.
    ///
    /// # Errors
    /// Parts that do not exist or are given twice.
    pub(super) fn resolve(&self, counts: PartCounts, source: &Source) -> Result<StageErrors> {
        let mut all = StageErrors {
            output_pin_circle_radius: *self.output_pin_circle_radius_um * UM,
            output_pin_radius: *self.output_pin_radius_um * UM,
            ..self.of_ring(counts, source)?
        };
        pins(&self.output_pins, &mut all.output_pins, (counts.output_pins, "output pin"), source)?;
        eccentrics(&self.eccentrics, &mut all, counts.discs, source)?;
        let mut seen = Numbers::new(source);
        for row in self.holes.iter() {
            let disc = seen.one(&row.disc, counts.discs, "disc")?;
            let pin = seen.one(&row.pin, counts.output_pins, "output pin")?;
            let what = format!("the hole of disc {} for output pin {}", disc + 1, pin + 1);
            seen.once((disc, pin), &row.disc.span, &what)?;
            *slot(slot::<Vec<BoreError>>(&mut all.holes, disc), pin) = BoreError {
                radial: *row.radial_um * UM,
                tangential: *row.tangential_um * UM,
                diameter: *row.diameter_um * UM,
            };
        }
        Ok(all)
    }
}

impl TwoRingErrorsSection {
    /// As [`StageErrorsSection::resolve`].
    ///
    /// # Errors
    /// As there.
    pub(super) fn resolve(&self, counts: PartCounts, source: &Source) -> Result<StageErrors> {
        let mut all = self.of_ring(counts, source)?;
        eccentrics(&self.eccentrics, &mut all, counts.discs, source)?;
        Ok(all)
    }
}

impl SecondErrorsSection {
    /// As [`StageErrorsSection::resolve`].
    ///
    /// # Errors
    /// As there.
    pub(super) fn resolve(&self, counts: PartCounts, source: &Source) -> Result<StageErrors> {
        self.of_ring(counts, source)
    }
}

/// Errors of single pins, with the number of pins and their name in messages.
fn pins(
    rows: &[At<Section<PinErrorSection>>],
    list: &mut Vec<PinError>,
    (count, what): (usize, &str),
    source: &Source,
) -> Result<()> {
    let mut seen = Numbers::new(source);
    for row in rows {
        let pin = seen.one(&row.pin, count, what)?;
        seen.once((pin, 0), &row.pin.span, &format!("{what} {}", pin + 1))?;
        *slot(list, pin) = PinError {
            radial: *row.radial_um * UM,
            tangential: *row.tangential_um * UM,
            radius: *row.radius_um * UM,
        };
    }
    Ok(())
}

fn flanks(
    rows: &[At<Section<FlankErrorSection>>],
    list: &mut Vec<FlankError>,
    discs: usize,
    source: &Source,
) -> Result<()> {
    for row in rows {
        let disc = Numbers::new(source).one(&row.disc, discs, "disc")?;
        slot::<FlankError>(list, disc).harmonics.push(FlankHarmonic {
            order: *row.order,
            amplitude: *row.amplitude_um * UM,
            phase: *row.phase_deg * DEG,
            direction: *row.kind,
        });
    }
    Ok(())
}

fn eccentrics(
    rows: &[At<Section<StageEccentricErrorSection>>],
    all: &mut StageErrors,
    discs: usize,
    source: &Source,
) -> Result<()> {
    let mut seen = Numbers::new(source);
    for row in rows {
        let disc = seen.one(&row.disc, discs, "disc")?;
        seen.once((disc, 0), &row.disc.span, &format!("the eccentric of disc {}", disc + 1))?;
        *slot(&mut all.eccentrics, disc) =
            EccentricError { eccentricity: *row.eccentricity_um * UM, phase: *row.phase_arcmin * ARCMIN };
        *slot(&mut all.eccentric_clearances, disc) = *row.clearance_um * UM;
    }
    Ok(())
}
