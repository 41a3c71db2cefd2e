use crate::geometry::FlankError;

/// Deviations of one real machine from its drawing; everything zero for the nominal machine. Lists may be shorter than the machine has
/// parts: what is not listed has no error.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ManufacturingErrors {
    /// Added to every pin's distance from the centre, m.
    pub pin_circle_radius: f64,
    /// Added to every pin's radius, m.
    pub pin_radius: f64,
    /// Centre of the pin circle against the axis of main bearings and sun; it stands still with the housing.
    pub pin_circle_offset: RunOut,
    /// Per pin.
    pub pins: Vec<PinError>,
    /// Per disc.
    pub discs: Vec<DiscError>,
    /// Per crankshaft and disc.
    pub eccentrics: Vec<Vec<EccentricError>>,
    /// Bores for the crank supports in the carrier, per crankshaft.
    pub carrier_bores: Vec<BoreError>,
    /// Journals of the crank supports against the axis of the shaft, per crankshaft.
    pub journals: Vec<RunOut>,
    /// Gear of the planet against the axis of its crankshaft, per crankshaft.
    pub planets: Vec<RunOut>,
    /// Seats of the main bearings on the carrier against the axis of its bores.
    pub carrier: RunOut,
    pub sun: RunOut,
}

/// Place and size of one pin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PinError {
    /// Outward, m.
    pub radial: f64,
    /// Counter-clockwise, m.
    pub tangential: f64,
    /// Added to its radius, m.
    pub radius: f64,
}

/// One disc.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DiscError {
    /// Flank against the disc's axis.
    pub flank: FlankError,
    /// Per crankshaft.
    pub bores: Vec<BoreError>,
}

/// Position and size of a bore.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BoreError {
    /// Away from the centre of the part, m.
    pub radial: f64,
    /// Counter-clockwise, m.
    pub tangential: f64,
    /// Added to its diameter, m: widens the clearance of the bearing in it.
    pub diameter: f64,
}

/// One eccentric.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EccentricError {
    /// Added to the eccentricity, m.
    pub eccentricity: f64,
    /// Added to its phase, rad.
    pub phase: f64,
}

/// An axis that is off by `amplitude` (m) at the angle `phase` (rad) of the part.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RunOut {
    pub amplitude: f64,
    pub phase: f64,
}
