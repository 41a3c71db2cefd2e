//! The solids of carrier and housing and the windows of the disc, from the design and the rules for missing
//! values.

use super::consistency::contradiction;
use super::error::Source;
use super::service::Arrangement;
use super::{DesignError, DesignSections};
use crate::geometry::Sector;
use crate::machine::{
    BearingSet, CycloidDisc, GearStage, MainRows, PinRing, Solids, SolidsBasis, Thermal, WindowRoom,
    arm_conductance,
};
use crate::tribology::Oil;
use crate::units::{DEG, MM, UM};

/// Windows of a disc in the design: one by one, or by the metal around them.
pub(super) fn windows(design: &DesignSections) -> Vec<Sector> {
    if let Some(rim) = *design.disc.window_rim_mm {
        return window_room(design, rim * MM).windows();
    }
    let section = |window: &super::WindowSection, index: usize| Sector {
        inner_radius: *window.inner_radius_mm * MM,
        outer_radius: *window.outer_radius_mm * MM,
        centre_angle: *window.angle_deg * DEG + std::f64::consts::TAU * index as f64 / *window.count as f64,
        half_angle: 0.5 * *window.width_deg * DEG,
        corner_radius: *window.corner_radius_mm * MM,
    };
    let all = design.disc.windows.iter();
    all.flat_map(|window| (0..*window.count).map(move |index| section(window, index))).collect()
}

fn window_room(design: &DesignSections, rim: f64) -> WindowRoom {
    let (ring, disc, gear, cranks) = (&design.ring, &design.disc, &design.gear_stage, &design.crankshafts);
    WindowRoom {
        pin_circle_radius: *ring.pin_circle_radius_mm * MM,
        root_radius: (*ring.pin_circle_radius_mm - *ring.pin_radius_mm - *cranks.eccentricity_mm) * MM,
        centre_hole_radius: 0.5 * *disc.centre_hole_diameter_mm * MM,
        crank_bore_radius: super::resolve::crank_bore_radius(design),
        crank_circle: 0.5 * *gear.module_mm * (*gear.sun_teeth + *gear.planet_teeth) as f64 * MM,
        crank_count: *cranks.count,
        first_angle: *cranks.first_angle_deg * DEG,
        rim,
    }
}

/// Windows that are not valid, for which no mass can be computed.
pub(super) fn check(design: &DesignSections, source: &Source) -> Result<(), Box<DesignError>> {
    if let Some(rim) = *design.disc.window_rim_mm {
        let span = &design.disc.window_rim_mm.span;
        if !design.disc.windows.is_empty() {
            return Err(contradiction(
                source,
                span,
                "windows are given twice: one by one in [[disc.windows]], and by the metal around them"
                    .to_owned(),
                "leave one of the two out",
            ));
        }
        if !window_room(design, rim * MM).windows().iter().all(Sector::is_sound) {
            return Err(contradiction(
                source,
                span,
                format!(
                    "{rim} mm of metal to root circle, crank bores and centre hole leave no room for a window"
                ),
                "a smaller window_rim_mm, centre hole or crank bore, or fewer crankshafts",
            ));
        }
    }
    let unsound = |window: &&super::At<super::Section<super::WindowSection>>| {
        let sector = Sector {
            inner_radius: *window.inner_radius_mm,
            outer_radius: *window.outer_radius_mm,
            centre_angle: 0.0,
            half_angle: 0.5 * *window.width_deg * DEG,
            corner_radius: *window.corner_radius_mm,
        };
        !sector.is_sound()
    };
    match design.disc.windows.iter().find(unsound) {
        Some(window) => Err(contradiction(
            source,
            &window.corner_radius_mm.span,
            "radii, width and corners of this window contradict each other".to_owned(),
            "the outer radius is the larger one; two corners must fit on every side",
        )),
        None => Ok(()),
    }
}

pub(super) fn solids(
    design: &DesignSections,
    ring: &PinRing,
    disc: &CycloidDisc,
    gear_stage: &GearStage,
    bearings: &BearingSet,
) -> Solids {
    let mut solids = Solids::assumed(&SolidsBasis {
        ring,
        disc,
        disc_count: *design.disc.count,
        crank_count: *design.crankshafts.count,
        crank_circle: gear_stage.centre_distance(),
        first_angle: *design.crankshafts.first_angle_deg * DEG,
        eccentricity: *design.crankshafts.eccentricity_mm * MM,
        window_rim: design.disc.window_rim_mm.map(|rim| rim * MM),
        bearings,
    });
    let set = |to: &mut f64, given: Option<f64>, unit: f64| *to = given.map_or(*to, |value| value * unit);
    let given = &design.carrier.solid;
    let carrier = &mut solids.carrier;
    set(&mut carrier.plate_radius, *given.plate_diameter_mm, 0.5 * MM);
    set(&mut carrier.centre_bore_radius, *given.centre_bore_diameter_mm, 0.5 * MM);
    set(&mut carrier.crank_seat_radius, *given.crank_seat_diameter_mm, 0.5 * MM);
    set(&mut carrier.plate_thickness, *given.plate_thickness_mm, MM);
    for pillar in &mut carrier.pillars {
        set(&mut pillar.inner_radius, *given.pillar_inner_radius_mm, MM);
        set(&mut pillar.outer_radius, *given.pillar_outer_radius_mm, MM);
        set(&mut pillar.half_angle, *given.pillar_width_deg, 0.5 * DEG);
        set(&mut pillar.corner_radius, *given.pillar_corner_radius_mm, MM);
    }
    carrier.hold = given.hold.unwrap_or(carrier.hold);
    // The seats in the housing go with the plates, the bolts with the flange.
    let r = ring.pin_circle_radius;
    let given = &design.housing.solid;
    let housing = &mut solids.housing;
    housing.seat_radius = (solids.carrier.plate_radius + 0.12 * r).max(housing.seat_radius);
    set(&mut housing.groove_clearance, *given.groove_clearance_um, UM);
    set(&mut housing.body_radius, *given.body_diameter_mm, 0.5 * MM);
    set(&mut housing.seat_radius, *given.seat_diameter_mm, 0.5 * MM);
    set(&mut housing.flange_radius, *given.flange_diameter_mm, 0.5 * MM);
    set(&mut housing.flange_thickness, *given.flange_thickness_mm, MM);
    housing.bolt_circle_radius = 0.5 * (housing.body_radius + housing.flange_radius);
    set(&mut housing.bolt_circle_radius, *given.bolt_circle_diameter_mm, 0.5 * MM);
    set(&mut housing.first_bolt_angle, *given.first_bolt_angle_deg, DEG);
    set(&mut housing.bolt_face_radius, *given.bolt_face_diameter_mm, 0.5 * MM);
    housing.bolt_count = given.bolt_count.unwrap_or(housing.bolt_count);
    housing.hold = given.hold.unwrap_or(housing.hold);
    if let Some(material) = &given.material.value {
        housing.material = material.clone();
    }
    solids.main_rows = main_rows(design, &solids);
    solids
}

fn main_rows(design: &DesignSections, solids: &Solids) -> MainRows {
    let mut rows = MainRows::assumed(&solids.carrier, &solids.housing);
    let given = &design.bearings.main.rows;
    let set = |to: &mut f64, given: Option<f64>, unit: f64| *to = given.map_or(*to, |value| value * unit);
    let row = &mut rows.row;
    row.kind = given.kind.unwrap_or(row.kind);
    row.roller_count = given.roller_count.unwrap_or(row.roller_count);
    set(&mut row.roller_diameter, *given.roller_diameter_mm, MM);
    row.roller_length = row.roller_diameter;
    set(&mut row.roller_length, *given.roller_length_mm, MM);
    set(&mut row.pitch_diameter, *given.pitch_diameter_mm, MM);
    set(&mut row.contact_angle, *given.contact_angle_deg, DEG);
    row.dynamic_load_rating = given.dynamic_load_rating_kn.map(|rating| rating * 1e3);
    set(&mut rows.spacing, *given.spacing_mm, MM);
    set(&mut rows.preload, *given.preload_um, UM);
    rows.back_to_back = given.arrangement.unwrap_or(Arrangement::BackToBack) == Arrangement::BackToBack;
    rows
}

/// Temperature, oil and cooling; the surface is that of the housing where none is given.
pub(super) fn thermal(design: &DesignSections, solids: &Solids) -> Thermal {
    let given = &design.thermal;
    let mut oil = Oil::grade(*given.iso_vg);
    if let Some(viscosity) = *given.viscosity_100c_mm2_s {
        oil.at_100c = viscosity * MM * MM;
    }
    let (carrier, housing) = (&solids.carrier, &solids.housing);
    let length = carrier.gap + 2.0 * carrier.plate_thickness;
    let rounds = 2.0 * std::f64::consts::PI * housing.body_radius.max(housing.flange_radius) * length;
    let ends = 2.0 * std::f64::consts::PI * housing.flange_radius.powi(2);
    Thermal {
        temperature: *given.temperature_c,
        internal_excess: *given.internal_excess_k,
        steel_expansion: *given.steel_expansion_um_per_m_k * UM,
        housing_expansion: *given.housing_expansion_um_per_m_k * UM,
        oil,
        pressure_viscosity: *given.pressure_viscosity_per_gpa * 1e-9,
        roughness: *given.roughness_um * UM,
        ambient: *given.ambient_c,
        transfer: *given.heat_transfer_w_m2_k,
        surface: given.surface_m2.unwrap_or(rounds + ends),
        mounting: given
            .mounting_conductance_w_k
            .unwrap_or_else(|| arm_conductance(2.0 * housing.flange_radius, *given.heat_transfer_w_m2_k)),
    }
}
