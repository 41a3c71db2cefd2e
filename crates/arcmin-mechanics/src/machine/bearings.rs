/// Bearings and supports, used with `--joints bearings`.
#[derive(Debug, Clone, PartialEq)]
pub struct BearingSet {
    /// Between eccentric and disc bore: one for each crankshaft and disc.
    pub turning_arm: RollerBearing,
    /// Between crankshaft and carrier: two for each crankshaft.
    pub crank_support: RollerBearing,
    /// Distance of the two crank supports in m.
    pub crank_support_span: f64,
    /// Between carrier and housing, the pair.
    pub main: SupportStiffness,
    /// Between sun and housing: the input shaft with its own bearing.
    pub sun: SupportStiffness,
}

/// Shape of the rolling elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RollerKind {
    /// Cylindrical rollers and needles, contact angle 0.
    Cylindrical,
    /// Tapered rollers: line contact at an angle.
    Tapered,
    /// Balls: point contact.
    Ball,
}

impl RollerKind {
    /// p in L10 = (C/P)^p 10⁶ turns (ISO 281).
    pub fn life_exponent(self) -> f64 {
        if self == RollerKind::Ball { 3.0 } else { 10.0 / 3.0 }
    }
}

/// A radial rolling bearing from its geometry.
#[derive(Debug, Clone, PartialEq)]
pub struct RollerBearing {
    /// Shape of the rolling elements.
    pub kind: RollerKind,
    /// Rolling elements of one bearing or row.
    pub roller_count: usize,
    /// m.
    pub roller_diameter: f64,
    /// Effective roller length in m (unused for balls).
    pub roller_length: f64,
    /// Pitch diameter in m.
    pub pitch_diameter: f64,
    /// Contact angle in rad.
    pub contact_angle: f64,
    /// Diametral clearance in m; negative is preload.
    pub clearance: f64,
    /// Basic dynamic load rating C in N, if the maker states one; otherwise it is computed (ISO 281).
    pub dynamic_load_rating: Option<f64>,
}

/// Distance in m between the centres of neighbouring rollers, d_m sin(π/Z); neighbours touch if it equals the
/// roller diameter.
pub fn roller_spacing(pitch_diameter: f64, roller_count: usize) -> f64 {
    pitch_diameter * (std::f64::consts::PI / roller_count as f64).sin()
}

/// A linear radial support.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SupportStiffness {
    /// N/m.
    pub radial: f64,
    /// Diametral clearance in m.
    pub clearance: f64,
}
