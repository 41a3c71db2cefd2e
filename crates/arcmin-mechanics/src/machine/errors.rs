use super::Machine;
use crate::geometry::FlankError;

/// Deviations of one real machine from its drawing; all zero for the nominal machine. Lists may be shorter than
/// the machine has parts: parts without an entry have no error.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ManufacturingErrors {
    /// Added to every pin's distance from the centre, m.
    pub pin_circle_radius: f64,
    /// Added to every pin's radius, m.
    pub pin_radius: f64,
    /// Centre of the pin circle relative to the axis of main bearings and sun; fixed to the housing.
    pub pin_circle_offset: RunOut,
    /// For each pin.
    pub pins: Vec<PinError>,
    /// For each disc.
    pub discs: Vec<DiscError>,
    /// For each crankshaft and disc.
    pub eccentrics: Vec<Vec<EccentricError>>,
    /// Bores for the crank supports in the carrier, for each crankshaft.
    pub carrier_bores: Vec<BoreError>,
    /// Journals of the crank supports relative to the axis of the shaft, for each crankshaft.
    pub journals: Vec<RunOut>,
    /// Gear of the planet relative to the axis of its crankshaft, for each crankshaft.
    pub planets: Vec<RunOut>,
    /// Seats of the main bearings on the carrier relative to the axis of its bores.
    pub carrier: RunOut,
    /// Run-out of the sun against its axis of rotation.
    pub sun: RunOut,
}

impl ManufacturingErrors {
    /// Whether the machine is the nominal one.
    pub fn is_zero(&self) -> bool {
        self.only_sizes_of_the_ring() && self.pin_circle_radius == 0.0 && self.pin_radius == 0.0
    }

    /// Whether all discs go through the same states one after the other: the only errors are those of the pin
    /// circle radius and of the radius of all pins.
    pub fn discs_alike(&self) -> bool {
        self.only_sizes_of_the_ring()
    }

    fn only_sizes_of_the_ring(&self) -> bool {
        let centred = |run_out: &RunOut| run_out.amplitude == 0.0;
        let bored = |bore: &BoreError| *bore == BoreError::default();
        [self.pin_circle_offset, self.carrier, self.sun]
            .iter()
            .chain(&self.journals)
            .chain(&self.planets)
            .all(centred)
            && self.pins.iter().all(|pin| *pin == PinError::default())
            && self.discs.iter().all(|disc| disc.flank.is_zero() && disc.bores.iter().all(bored))
            && self.carrier_bores.iter().all(bored)
            && self.eccentrics.iter().flatten().all(|eccentric| *eccentric == EccentricError::default())
    }

    /// Turns of the crankshafts relative to the carrier after which all positions repeat.
    ///
    /// One turn for errors of discs, crankshafts, planets and carrier: after it the carrier has advanced by one
    /// pin pitch relative to a ring of equal pins. z_p turns, one turn of the output, if the pins of the ring
    /// differ. The sun returns to its position relative to the carrier after z_1/gcd(z_1, z_2) turns; this
    /// number is included if it has a run-out.
    pub fn crank_turns(&self, machine: &Machine) -> usize {
        let stage = &machine.gear_stage;
        let ring = self.pin_circle_offset.amplitude != 0.0
            || self.pins.iter().any(|pin| *pin != PinError::default());
        let around = if ring { machine.ring.pin_count } else { 1 };
        let sun = if self.sun.amplitude != 0.0 {
            stage.sun_teeth / gcd(stage.sun_teeth, stage.planet_teeth)
        } else {
            1
        };
        around / gcd(around, sun) * sun
    }
}

/// Greatest common divisor; 1 if both are 0.
pub fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a.max(1) } else { gcd(b, a % b) }
}

/// Errors of position and size of one pin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PinError {
    /// Radial displacement, outwards positive, m.
    pub radial: f64,
    /// Tangential displacement, counter-clockwise positive, m.
    pub tangential: f64,
    /// Added to its radius, m.
    pub radius: f64,
}

/// Errors of one disc.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DiscError {
    /// Error of the flank relative to the disc's axis.
    pub flank: FlankError,
    /// Errors of the bores, for each crankshaft.
    pub bores: Vec<BoreError>,
}

/// Errors of position and size of a bore.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BoreError {
    /// Radial displacement, away from the centre of the part, m.
    pub radial: f64,
    /// Tangential displacement, counter-clockwise positive, m.
    pub tangential: f64,
    /// Added to its diameter, m; increases the clearance of the bearing in it.
    pub diameter: f64,
}

/// Errors of one eccentric.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EccentricError {
    /// Added to the eccentricity, m.
    pub eccentricity: f64,
    /// Added to its phase, rad.
    pub phase: f64,
}

/// Offset of an axis by `amplitude` (m) in the direction `phase` (rad) of the part.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RunOut {
    /// m, zero or more.
    pub amplitude: f64,
    /// rad, counter-clockwise on the part.
    pub phase: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whole turns of the crankshafts in the carrier, compared with the angles of sun and ring relative to the
    /// carrier.
    #[test]
    fn everything_repeats_after_these_turns() {
        let mut machine = crate::templates::tao2024();
        (machine.gear_stage.sun_teeth, machine.gear_stage.planet_teeth) = (16, 36);
        let one = RunOut { amplitude: 1e-6, phase: 0.3 };
        let pin = PinError { radial: 1e-6, ..PinError::default() };
        let cases = [
            (ManufacturingErrors::default(), 1, true),
            (
                ManufacturingErrors {
                    pin_circle_radius: 1e-6,
                    pin_radius: 1e-6,
                    ..ManufacturingErrors::default()
                },
                1,
                true,
            ),
            (
                ManufacturingErrors { carrier: one, planets: vec![one], ..ManufacturingErrors::default() },
                1,
                false,
            ),
            (ManufacturingErrors { sun: one, ..ManufacturingErrors::default() }, 4, false),
            (
                ManufacturingErrors {
                    pins: vec![PinError::default(), pin],
                    ..ManufacturingErrors::default()
                },
                40,
                false,
            ),
            (
                ManufacturingErrors { pin_circle_offset: one, sun: one, ..ManufacturingErrors::default() },
                40,
                false,
            ),
        ];
        for (errors, turns, alike) in cases {
            assert_eq!((errors.crank_turns(&machine), errors.discs_alike()), (turns, alike), "{errors:?}");
            // Turns of the sun against the carrier, and of the carrier against the ring in pin pitches: whole
            // numbers.
            let sun = turns as f64 * 36.0 / 16.0;
            assert!(errors.sun.amplitude == 0.0 || sun.fract() == 0.0, "{sun}");
        }
        machine.ring.pin_count = 30;
        let both = ManufacturingErrors { pin_circle_offset: one, sun: one, ..ManufacturingErrors::default() };
        assert_eq!(both.crank_turns(&machine), 60);
        assert!(ManufacturingErrors::default().is_zero() && !both.is_zero());
    }
}
