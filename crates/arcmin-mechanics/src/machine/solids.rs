//! Solids of carrier and housing: the few dimensions that finite elements need in addition to those of the
//! mechanism.
//!
//! Dimensions that a design does not give are scaled from the pin circle by the rules stated at each field.
//! These rules are assumptions about reducers of this kind, not dimensions of any manufacturer.

use super::{BearingSet, CycloidDisc, Kinematics, PinRing, RollerBearing, RollerKind};
use crate::geometry::Sector;
use crate::materials::Material;

/// Part of a face that is clamped to the neighbouring structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Hold {
    /// The whole face: a stiff flange with many bolts.
    Face,
    /// Only around the bolts (housing) or over the pillars (carrier).
    Bolts,
}

/// The carrier: two equal plates, joined by pillars that pass through the windows of the discs. The input end
/// lies at z = 0, the output face at the far end.
#[derive(Debug, Clone, PartialEq)]
pub struct CarrierSolid {
    /// Outer radius of the plates in m. Assumed: that of the pin circle.
    pub plate_radius: f64,
    /// Radius of the bore through both plates in m. Assumed: that of the discs' centre hole (0.3 R_p without
    /// one), but at least 0.04 R_p away from the crank seats.
    pub centre_bore_radius: f64,
    /// Radius of the seats of the crank supports' outer rings in m. Assumed: raceway radius plus 0.04 R_p for
    /// the ring.
    pub crank_seat_radius: f64,
    /// Thickness of each plate in m. Assumed: each support sits in the middle of its plate.
    pub plate_thickness: f64,
    /// Distance between the plates in m. Assumed: the discs, a tenth of their width apart and from the plates.
    pub gap: f64,
    /// Sections of the pillars. Assumed: one between every two crankshafts, its window offset inwards by the
    /// eccentricity plus 0.02 R_p on all sides, and 0.04 R_p away from the crank seats.
    pub pillars: Vec<Sector>,
    /// Clamped part of the output face. Assumed: all of it.
    pub hold: Hold,
}

/// The housing: a ring with half-round grooves for the pins between the seats of the two main bearings, and a
/// flange with bolts around the pins. Spans the carrier in z.
#[derive(Debug, Clone, PartialEq)]
pub struct HousingSolid {
    /// Material. Assumed: QT450, the cast iron of Tao2024.
    pub material: Material,
    /// Diametral clearance of the pins in their grooves in m. Assumed: a thousandth of the pins' diameter.
    pub groove_clearance: f64,
    /// Outer radius of the ring in m. Assumed: 1.25 R_p.
    pub body_radius: f64,
    /// Radius of the main bearings' seats in m. Assumed: 0.12 R_p of bearing around the plates.
    pub seat_radius: f64,
    /// Outer radius of the flange in m; that of the ring for none. Assumed: 1.48 R_p, the outer diameter of
    /// 190 mm that catalogues give for a pin circle of 128 mm.
    pub flange_radius: f64,
    /// Thickness of the flange, which sits around the pins, in m. Assumed: as long as the pins.
    pub flange_thickness: f64,
    /// Circle of the bolts in m. Assumed: the middle of the flange.
    pub bolt_circle_radius: f64,
    /// Number of bolts. Assumed: 16.
    pub bolt_count: usize,
    /// Angle of the first bolt in rad. Assumed: 0, where the first pin is.
    pub first_bolt_angle: f64,
    /// Radius of the clamped face around one bolt in m. Assumed: 0.09 R_p.
    pub bolt_face_radius: f64,
    /// Clamped part of the flange. Assumed: around the bolts.
    pub hold: Hold,
}

/// The pair of main bearings as two equal rows, for tilt, moments and axial forces.
#[derive(Debug, Clone, PartialEq)]
pub struct MainRows {
    /// One row. Assumed: balls with 0.6 of the space between plate and seat as diameter, contact angle 40°, 90
    /// % of the circle filled.
    pub row: RollerBearing,
    /// Distance of the rows in m. Assumed: from the middle of one plate to that of the other.
    pub spacing: f64,
    /// Axial preload approach of each row in m; negative is clearance. Assumed: 5 µm.
    pub preload: f64,
    /// Arrangement: contact lines diverge towards the axis (O) or converge between the rows (X). Assumed: O.
    pub back_to_back: bool,
}

impl MainRows {
    /// By the rules stated at the fields.
    pub(crate) fn assumed(carrier: &CarrierSolid, housing: &HousingSolid) -> MainRows {
        let pitch_diameter = carrier.plate_radius + housing.seat_radius;
        let roller_diameter = 0.6 * (housing.seat_radius - carrier.plate_radius);
        let count = (0.9 * std::f64::consts::PI * pitch_diameter / roller_diameter).floor().max(3.0);
        MainRows {
            row: RollerBearing {
                kind: RollerKind::Ball,
                roller_count: count as usize,
                roller_diameter,
                roller_length: roller_diameter,
                pitch_diameter,
                contact_angle: 40.0 * crate::units::DEG,
                clearance: 0.0,
                dynamic_load_rating: None,
            },
            spacing: carrier.gap + carrier.plate_thickness,
            preload: 5.0 * crate::units::UM,
            back_to_back: true,
        }
    }
}

/// Carrier and housing as solids, and the disc's windows for the carrier's pillars.
#[derive(Debug, Clone, PartialEq)]
pub struct Solids {
    /// Plates and pillars.
    pub carrier: CarrierSolid,
    /// Ring with pin grooves and flange.
    pub housing: HousingSolid,
    /// Rows of the main bearings between carrier and housing.
    pub main_rows: MainRows,
    /// Windows by the assumptions for the pillars. A disc has those of its design, which may be none.
    pub windows: Vec<Sector>,
}

/// Dimensions from which the rules scale.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SolidsBasis<'a> {
    pub(crate) ring: &'a PinRing,
    pub(crate) disc: &'a CycloidDisc,
    pub(crate) disc_count: usize,
    pub(crate) crank_count: usize,
    pub(crate) crank_circle: f64,
    pub(crate) first_angle: f64,
    pub(crate) eccentricity: f64,
    /// Width of metal around the windows, if the design gives it, m.
    pub(crate) window_rim: Option<f64>,
    pub(crate) bearings: &'a BearingSet,
}

/// Parts around the windows of a disc, all in m and rad.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WindowRoom {
    pub(crate) pin_circle_radius: f64,
    /// Root radius of the flank: R_p − r_p − a.
    pub(crate) root_radius: f64,
    /// Radius of the centre hole, 0 for none.
    pub(crate) centre_hole_radius: f64,
    pub(crate) crank_bore_radius: f64,
    pub(crate) crank_circle: f64,
    pub(crate) crank_count: usize,
    pub(crate) first_angle: f64,
    /// Width of metal to root circle, crank bores and centre hole.
    pub(crate) rim: f64,
}

/// Default corner radius of windows and width of metal around them, as fractions of R_p.
const WINDOW_CORNER: f64 = 0.08;

impl WindowRoom {
    /// One window between every two crankshafts, with corners of 0.08 R_p; without a centre hole their inner
    /// radius is at least 0.3 R_p. If there is no space for a window, [`Sector::is_sound`] is false.
    pub fn windows(&self) -> Vec<Sector> {
        let pitch = std::f64::consts::PI / self.crank_count as f64;
        let sector = |k: usize| Sector {
            inner_radius: centre_hole(self.centre_hole_radius, self.pin_circle_radius) + self.rim,
            outer_radius: self.root_radius - self.rim,
            centre_angle: Kinematics::crankshaft_angle(self.first_angle, k, self.crank_count) + pitch,
            half_angle: pitch - beside(self.crank_bore_radius + self.rim, self.crank_circle),
            corner_radius: WINDOW_CORNER * self.pin_circle_radius,
        };
        (0..self.crank_count).map(sector).collect()
    }
}

/// Half the angle subtended by a circle of this radius on the circle of the crankshafts, rad.
fn beside(radius: f64, crank_circle: f64) -> f64 {
    (radius / crank_circle).min(1.0).asin()
}

fn centre_hole(radius: f64, pin_circle_radius: f64) -> f64 {
    if radius > 0.0 { radius } else { 0.3 * pin_circle_radius }
}

impl Solids {
    /// Every dimension by its rule.
    ///
    /// Windows: one between every two crankshafts, with a distance of the design's rim or 0.08 R_p from the
    /// centre hole, the crank bores and the root circle of the flank. Pillars: the window offset inwards by the
    /// eccentricity plus 0.02 R_p on all sides, and 0.04 R_p away from the crank seats.
    pub(crate) fn assumed(basis: &SolidsBasis<'_>) -> Solids {
        let r = basis.ring.pin_circle_radius;
        let (disc, bearings) = (basis.disc, basis.bearings);
        let support = &bearings.crank_support;
        let crank_seat_radius = 0.5 * (support.pitch_diameter + support.roller_diameter) + 0.04 * r;
        let hole = centre_hole(disc.centre_hole_radius, r);
        let centre_bore_radius = hole.min(basis.crank_circle - crank_seat_radius - 0.04 * r).max(0.05 * r);
        let discs = basis.disc_count as f64;
        let gap = (1.1 * (discs - 1.0) + 1.0 + 0.2) * disc.width;
        let plate_thickness = (bearings.crank_support_span - gap).max(0.1 * r);
        let pitch = std::f64::consts::PI / basis.crank_count as f64;
        let draw_in = basis.eccentricity + 0.02 * r;
        let room = WindowRoom {
            pin_circle_radius: r,
            root_radius: r - basis.ring.pin_radius - basis.eccentricity,
            centre_hole_radius: disc.centre_hole_radius,
            crank_bore_radius: disc.crank_bore_radius,
            crank_circle: basis.crank_circle,
            crank_count: basis.crank_count,
            first_angle: basis.first_angle,
            rim: basis.window_rim.unwrap_or(WINDOW_CORNER * r),
        };
        let windows = room.windows();
        let pillar = |window: &Sector| {
            let inner_radius = window.inner_radius + draw_in;
            let side = window.half_angle - (draw_in / inner_radius).min(1.0).asin();
            Sector {
                inner_radius,
                outer_radius: window.outer_radius - draw_in,
                half_angle: side.min(pitch - beside(crank_seat_radius + 0.04 * r, basis.crank_circle)),
                corner_radius: (WINDOW_CORNER * r - draw_in).max(0.02 * r),
                ..*window
            }
        };
        let plate_radius = r;
        let (body_radius, flange_radius) = (1.25 * r, 1.48 * r);
        let carrier = CarrierSolid {
            plate_radius,
            centre_bore_radius,
            crank_seat_radius,
            plate_thickness,
            gap,
            pillars: windows.iter().map(pillar).collect(),
            hold: Hold::Face,
        };
        let housing = HousingSolid {
            material: Material::by_name("QT450").unwrap_or_else(|| basis.ring.material.clone()),
            groove_clearance: 2e-3 * basis.ring.pin_radius,
            body_radius,
            seat_radius: (plate_radius + 0.12 * r).max(r + basis.ring.pin_radius + 0.03 * r),
            flange_radius,
            flange_thickness: gap,
            bolt_circle_radius: 0.5 * (body_radius + flange_radius),
            bolt_count: 16,
            first_bolt_angle: 0.0,
            bolt_face_radius: 0.09 * r,
            hold: Hold::Bolts,
        };
        Solids { main_rows: MainRows::assumed(&carrier, &housing), carrier, housing, windows }
    }

    /// Smallest displacement in m of a disc with its windows in the middle position at which a window touches a
    /// pillar, over all pillars; the eccentricity must be smaller. `None` without windows. Each pillar is
    /// compared with the window around its middle.
    pub fn pillar_clearance(&self, windows: &[Sector]) -> Option<f64> {
        let apart = |a: &Sector, b: &Sector| {
            let turn = (a.centre_angle - b.centre_angle).rem_euclid(std::f64::consts::TAU);
            turn.min(std::f64::consts::TAU - turn)
        };
        let own = |pillar: &Sector| {
            windows.iter().min_by(|a, b| apart(pillar, a).total_cmp(&apart(pillar, b))).copied()
        };
        let clearances = self.carrier.pillars.iter().filter_map(|p| own(p).map(|w| p.clearance_in(&w)));
        clearances.min_by(f64::total_cmp)
    }
}
