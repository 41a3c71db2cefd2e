//! Errors of one single stage, given one by one.

use super::deviations::{Numbers, run_out, slot};
use super::error::Source;
use super::manufacturing::{FlankErrorSection, PinErrorSection, RunOutSection};
use super::schema::{At, default, optional, required, section};
use super::sections::SECTION_OR_DEFAULTS;
use super::{DesignError, Section};
use crate::geometry::{FlankError, FlankHarmonic};
use crate::machine::{BoreError, EccentricError, PinError, StageErrors};
use crate::units::{ARCMIN, DEG, UM};

section! {
    /// Manufacturing errors of one single stage, used by `contact` and `rig`. Pins and discs are counted from 1; what is not
    /// listed has no error.
    pub struct StageErrorsSection {
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
    /// In SI units, for so many discs, ring pins and output pins.
    ///
    /// # Errors
    /// Parts that do not exist or are given twice.
    pub(super) fn resolve(
        &self,
        discs: usize,
        [ring_pins, output_pins]: [usize; 2],
        source: &Source,
    ) -> Result<StageErrors, Box<DesignError>> {
        let mut all = StageErrors {
            pin_circle_radius: *self.pin_circle_radius_um * UM,
            pin_radius: *self.pin_radius_um * UM,
            pin_circle_offset: run_out(&self.pin_circle_offset),
            output_pin_circle_radius: *self.output_pin_circle_radius_um * UM,
            output_pin_radius: *self.output_pin_radius_um * UM,
            ..StageErrors::default()
        };
        for (rows, list, count, what) in [
            (&self.pins, &mut all.pins, ring_pins, "pin"),
            (&self.output_pins, &mut all.output_pins, output_pins, "output pin"),
        ] {
            let mut seen = Numbers::new(source);
            for row in rows.iter() {
                let pin = seen.one(&row.pin, count, what)?;
                seen.once((pin, 0), &row.pin.span, &format!("{what} {}", pin + 1))?;
                *slot(list, pin) = PinError {
                    radial: *row.radial_um * UM,
                    tangential: *row.tangential_um * UM,
                    radius: *row.radius_um * UM,
                };
            }
        }
        for row in self.flanks.iter() {
            let disc = Numbers::new(source).one(&row.disc, discs, "disc")?;
            slot::<FlankError>(&mut all.flanks, disc).harmonics.push(FlankHarmonic {
                order: *row.order,
                amplitude: *row.amplitude_um * UM,
                phase: *row.phase_deg * DEG,
                direction: *row.kind,
            });
        }
        let mut seen = Numbers::new(source);
        for row in self.eccentrics.iter() {
            let disc = seen.one(&row.disc, discs, "disc")?;
            seen.once((disc, 0), &row.disc.span, &format!("the eccentric of disc {}", disc + 1))?;
            *slot(&mut all.eccentrics, disc) =
                EccentricError { eccentricity: *row.eccentricity_um * UM, phase: *row.phase_arcmin * ARCMIN };
            *slot(&mut all.eccentric_clearances, disc) = *row.clearance_um * UM;
        }
        let mut seen = Numbers::new(source);
        for row in self.holes.iter() {
            let disc = seen.one(&row.disc, discs, "disc")?;
            let pin = seen.one(&row.pin, output_pins, "output pin")?;
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
