//! Manufacturing processes of a proposed single stage: material, clearances, tolerances, walls.

use super::gaps::Gaps;
pub use crate::design::Process;
use crate::design::Value;
use crate::materials::{ALUMINIUM, BEARING_STEEL, Known, PA12, PLA};

/// Sizes that depend on the process.
pub(super) struct Making {
    /// Material of the discs, with its source.
    pub material: Known,
    pub material_source: &'static str,
    /// Largest Hertz pressure, MPa.
    pub pressure_mpa: f64,
    pub pressure_source: &'static str,
    /// The least gaps, with the reason.
    pub gaps: Gaps,
    pub clearance_source: &'static str,
    /// Least wall between openings of a disc and outside of the ring pins, mm.
    pub wall_mm: f64,
    /// Ring of the housing outside of the pins, as a part of the outer diameter.
    pub housing: f64,
    /// Least eccentricity, mm: teeth are 2 e high.
    pub eccentricity_mm: f64,
    /// Least width of a disc, mm.
    pub width_mm: f64,
    /// Largest width of a disc over the outer diameter, an assumption: wide discs are cheap if printed.
    pub widest: f64,
    /// Whether needles may run in the bore of the disc; otherwise only ball bearings are used.
    pub is_hardened: bool,
    /// Radial stiffness of the bearings of input and output in their seats, N/µm.
    pub supports: [f64; 2],
    pub lost_motion_arcmin: f64,
    pub service_life_h: f64,
    /// Wear coefficient in 1/Pa with the ends of its band, and their source.
    pub wear_per_pa: [f64; 3],
    pub wear_source: &'static str,
}

/// Yield of a line contact below its surface: p = 1.67 × yield strength by Tresca, for any ν (Johnson, Contact
/// Mechanics, 1985, section 6.1).
const PLA_PRESSURE_MPA: f64 = 100.0;
const PA12_PRESSURE_MPA: f64 = 80.0;
const ALUMINIUM_PRESSURE_MPA: f64 = 840.0;

const PRINTED: Making = Making {
    material: PLA,
    material_source: "PLA printed solid: E, yield 60 MPa and density of data sheets; Poisson's ratio assumed",
    pressure_mpa: PLA_PRESSURE_MPA,
    pressure_source: "1.67 x yield strength of 60 MPa: a line contact yields under its surface (Johnson 1985, 6.1)",
    gaps: Gaps { profile_um: 100.0, hole_um: 100.0 },
    clearance_source: "printed flanks are drawn with 50 to 200 µm; parts that slide with 100 to 200 µm radial",
    wall_mm: 2.0,
    housing: 0.08,
    eccentricity_mm: 0.5,
    width_mm: 5.0,
    widest: 0.45,
    is_hardened: false,
    supports: [30.0, 50.0],
    lost_motion_arcmin: 120.0,
    service_life_h: 500.0,
    wear_per_pa: [3e-15, 1e-15, 1e-14],
    wear_source: "greased prints, assumed: dry pin-on-disc values (PLA 1e-13 to 4e-13) are at least twenty times \
         too high; calibrate",
};

/// Pins, rollers, and discs that are hardened.
pub(super) const STEEL: &str = BEARING_STEEL.name;

const CUT: Making = Making {
    material: BEARING_STEEL,
    material_source: "through-hardened bearing steel",
    pressure_mpa: 1500.0,
    pressure_source: "assumed: three quarters of the 2000 MPa usual for hardened bearing steel",
    gaps: Gaps { profile_um: 10.0, hole_um: 10.0 },
    clearance_source: "assumed: twice the tolerance of flank and hole, and oil",
    wall_mm: 1.0,
    housing: 0.06,
    eccentricity_mm: 0.1,
    width_mm: 3.0,
    widest: 0.25,
    is_hardened: true,
    supports: [100.0, 200.0],
    lost_motion_arcmin: 20.0,
    service_life_h: 2000.0,
    wear_per_pa: [1e-18, 3e-19, 3e-18],
    wear_source: "lubricated steel, assumed: replace by a measured depth (after_h, depth_um)",
};

impl Making {
    /// The material of the discs in a design file, with its values where they depend on the print.
    pub(super) fn disc_text(&self) -> String {
        match self.material.is_plastic {
            true => Value::from(self.material.material()).to_string(),
            false => format!("\"{}\"", self.material.name),
        }
    }
}

/// Sizes that depend on the process, in addition to its tolerances.
pub(super) trait Makes {
    fn making(self) -> Making;
}

impl Makes for Process {
    fn making(self) -> Making {
        match self {
            Process::PrintedFdm => PRINTED,
            Process::PrintedSls => Making {
                material: PA12,
                material_source: "sintered PA12: E, yield 48 MPa and density of data sheets; Poisson's ratio assumed",
                pressure_mpa: PA12_PRESSURE_MPA,
                pressure_source: "1.67 x yield strength of 48 MPa: a line contact yields under its surface (Johnson 1985, 6.1)",
                clearance_source: "assumed: as printed from filament",
                ..PRINTED
            },
            Process::Milled => Making {
                material: ALUMINIUM,
                material_source: "aluminium 7075-T6: yield 503 MPa, handbooks",
                pressure_mpa: ALUMINIUM_PRESSURE_MPA,
                pressure_source: "1.67 x yield strength of 503 MPa: a line contact yields under its surface (Johnson 1985, 6.1)",
                wall_mm: 1.5,
                eccentricity_mm: 0.2,
                is_hardened: false,
                wear_per_pa: [1e-17, 1e-18, 1e-16],
                wear_source: "assumed, ten times that of lubricated steel, without data on greased aluminium in such drives; calibrate",
                ..CUT
            },
            Process::WireEdm => CUT,
            Process::Ground => Making {
                gaps: Gaps { profile_um: 5.0, hole_um: 5.0 },
                lost_motion_arcmin: 10.0,
                service_life_h: 6000.0,
                ..CUT
            },
        }
    }
}

/// Diameters of dowel pins in mm (ISO 8734).
pub(super) const DOWELS_MM: [f64; 13] = [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0];

/// Output pins in mm: diameter of the pin, outer diameter of the bush on it (ISO 3547); thin pins slide.
pub(super) const OUTPUT_PINS_MM: [[f64; 2]; 12] = [
    [1.5, 1.5],
    [2.0, 2.0],
    [2.5, 2.5],
    [3.0, 4.5],
    [4.0, 5.5],
    [5.0, 7.0],
    [6.0, 8.0],
    [8.0, 10.0],
    [10.0, 12.0],
    [12.0, 14.0],
    [16.0, 18.0],
    [20.0, 23.0],
];

/// Deep groove ball bearings: bore, outer diameter, width in mm (ISO 15, series 18, 19 and 10; miniature ones with shields).
pub(super) const BALL_BEARINGS_MM: [(&str, [f64; 3]); 62] = [
    ("683ZZ", [3.0, 7.0, 3.0]),
    ("623", [3.0, 10.0, 4.0]),
    ("684ZZ", [4.0, 9.0, 4.0]),
    ("624", [4.0, 13.0, 5.0]),
    ("685ZZ", [5.0, 11.0, 5.0]),
    ("625", [5.0, 16.0, 5.0]),
    ("686ZZ", [6.0, 13.0, 5.0]),
    ("626", [6.0, 19.0, 6.0]),
    ("687ZZ", [7.0, 14.0, 5.0]),
    ("688ZZ", [8.0, 16.0, 5.0]),
    ("608", [8.0, 22.0, 7.0]),
    ("689ZZ", [9.0, 17.0, 5.0]),
    ("6800", [10.0, 19.0, 5.0]),
    ("6900", [10.0, 22.0, 6.0]),
    ("6000", [10.0, 26.0, 8.0]),
    ("6801", [12.0, 21.0, 5.0]),
    ("6901", [12.0, 24.0, 6.0]),
    ("6001", [12.0, 28.0, 8.0]),
    ("6802", [15.0, 24.0, 5.0]),
    ("6902", [15.0, 28.0, 7.0]),
    ("6002", [15.0, 32.0, 9.0]),
    ("6803", [17.0, 26.0, 5.0]),
    ("6903", [17.0, 30.0, 7.0]),
    ("6003", [17.0, 35.0, 10.0]),
    ("6804", [20.0, 32.0, 7.0]),
    ("6904", [20.0, 37.0, 9.0]),
    ("6004", [20.0, 42.0, 12.0]),
    ("6805", [25.0, 37.0, 7.0]),
    ("6905", [25.0, 42.0, 9.0]),
    ("6005", [25.0, 47.0, 12.0]),
    ("6806", [30.0, 42.0, 7.0]),
    ("6906", [30.0, 47.0, 9.0]),
    ("6006", [30.0, 55.0, 13.0]),
    ("6807", [35.0, 47.0, 7.0]),
    ("6907", [35.0, 55.0, 10.0]),
    ("6007", [35.0, 62.0, 14.0]),
    ("6808", [40.0, 52.0, 7.0]),
    ("6908", [40.0, 62.0, 12.0]),
    ("6008", [40.0, 68.0, 15.0]),
    ("6809", [45.0, 58.0, 7.0]),
    ("6909", [45.0, 68.0, 12.0]),
    ("6009", [45.0, 75.0, 16.0]),
    ("6810", [50.0, 65.0, 7.0]),
    ("6910", [50.0, 72.0, 12.0]),
    ("6010", [50.0, 80.0, 16.0]),
    ("6811", [55.0, 72.0, 9.0]),
    ("6911", [55.0, 80.0, 13.0]),
    ("6011", [55.0, 90.0, 18.0]),
    ("6812", [60.0, 78.0, 10.0]),
    ("6912", [60.0, 85.0, 13.0]),
    ("6012", [60.0, 95.0, 18.0]),
    ("6814", [70.0, 90.0, 10.0]),
    ("6914", [70.0, 100.0, 16.0]),
    ("6014", [70.0, 110.0, 20.0]),
    ("6816", [80.0, 100.0, 10.0]),
    ("6916", [80.0, 110.0, 16.0]),
    ("6016", [80.0, 125.0, 22.0]),
    ("6818", [90.0, 115.0, 13.0]),
    ("6918", [90.0, 125.0, 18.0]),
    ("6018", [90.0, 140.0, 24.0]),
    ("6820", [100.0, 125.0, 13.0]),
    ("6020", [100.0, 150.0, 24.0]),
];

/// Needle cages in mm: inner and outer raceway, width (ISO 3030).
pub(super) const NEEDLE_CAGES_MM: [[f64; 3]; 25] = [
    [5.0, 8.0, 8.0],
    [6.0, 9.0, 8.0],
    [7.0, 10.0, 8.0],
    [8.0, 11.0, 8.0],
    [9.0, 12.0, 10.0],
    [10.0, 13.0, 10.0],
    [12.0, 15.0, 10.0],
    [14.0, 18.0, 10.0],
    [15.0, 19.0, 10.0],
    [16.0, 20.0, 10.0],
    [17.0, 21.0, 10.0],
    [18.0, 22.0, 10.0],
    [20.0, 24.0, 10.0],
    [22.0, 26.0, 10.0],
    [25.0, 29.0, 10.0],
    [28.0, 33.0, 13.0],
    [30.0, 35.0, 13.0],
    [32.0, 37.0, 13.0],
    [35.0, 40.0, 13.0],
    [40.0, 45.0, 13.0],
    [45.0, 50.0, 17.0],
    [50.0, 55.0, 20.0],
    [55.0, 60.0, 20.0],
    [60.0, 65.0, 20.0],
    [65.0, 70.0, 20.0],
];
