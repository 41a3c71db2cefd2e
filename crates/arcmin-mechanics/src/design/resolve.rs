//! Conversion of a design to a machine in SI units.

use super::consistency::Place;
use super::error::Source;
use super::resolve_laws::{law, wear};
use super::solids::{self, Section as Solid};
use super::{
    At, ContactSection, DesignError, DesignSections, DiscSection, DutySection, LimitsSection, LoadSection,
    ModificationSection, RollerBearingSection, Section,
};
use crate::contact::Damping;
use crate::geometry::{Profile, Relief};
use crate::machine::*;
use crate::units::{ARCMIN, DEG, HOUR, MM, MPA, RPM, UM};

/// N/m in one N/µm.
const N_PER_UM: f64 = 1e6;
/// Creates the machine and checks the remaining contradictions between keys.
pub(super) fn machine(design: &DesignSections, source: &Source) -> Result<Machine, Box<DesignError>> {
    let ring = ring(design);
    let gear_stage = gear_stage(design);
    let disc = disc(design);
    let bearings = bearings(design);
    let crankshafts = crankshafts(design);
    let (rated, duty) = duty(&design.load, &design.duty);
    let solids = super::bodies::solids(design, &ring, &disc, &gear_stage, &bearings);
    Ok(Machine {
        name: design.name.value.clone(),
        ring,
        disc,
        disc_count: *design.disc.count,
        crankshafts,
        gear_stage,
        carrier: Carrier {
            mass: *design.carrier.mass_kg,
            inertia: *design.carrier.inertia_kg_m2,
            material: design.carrier.material.value.clone(),
            torsional_stiffness: design
                .carrier
                .torsional_stiffness_n_m_per_arcmin
                .map_or(f64::INFINITY, |stiffness| stiffness / ARCMIN),
        },
        housing: housing(design),
        thermal: super::bodies::thermal(design, &solids),
        solids,
        fixed_member: *design.fixed_member,
        bearings,
        friction: friction(design),
        contact_law: law(&design.contact.law, &design.contact.span, &design.contact.parameters(), source)?,
        contact_damping: damping(&design.contact),
        rated,
        duty,
        wear: wear(design, source)?,
        limits: limits(&design.limits),
    })
}

/// The rated point and the load spectrum.
pub(super) fn duty(load: &LoadSection, duty: &[At<Section<DutySection>>]) -> (DutyPoint, Vec<DutyPoint>) {
    let rated = DutyPoint {
        torque: *load.rated_torque_n_m,
        input_speed: *load.input_speed_rpm * RPM,
        share: 1.0,
        forces: OutputForces::default(),
    };
    if duty.is_empty() {
        return (rated, vec![rated]);
    }
    // The sum of rounded shares is scaled to 1.
    let whole: f64 = duty.iter().map(|row| *row.share).sum();
    let row = |row: &DutySection| DutyPoint {
        torque: *row.torque_n_m,
        input_speed: *row.input_speed_rpm * RPM,
        share: if (whole - 1.0).abs() > 1e-12 { *row.share / whole } else { *row.share },
        forces: OutputForces { moment: *row.moment_n_m, axial: *row.axial_n, radial: *row.radial_n },
    };
    (rated, duty.iter().map(|at| row(at)).collect())
}

/// Damping of pins on flanks.
pub(super) fn damping(contact: &ContactSection) -> Damping {
    Damping { coefficient: *contact.damping_n_s_per_m, ramp_depth: *contact.damping_depth_um * UM }
}

pub(super) fn limits(limits: &LimitsSection) -> Limits {
    Limits {
        lost_motion: *limits.lost_motion_arcmin * ARCMIN,
        contact_pressure: *limits.contact_pressure_mpa * MPA,
        service_life: *limits.service_life_h * HOUR,
        transmission_error: limits.transmission_error_arcmin.map(|limit| limit * ARCMIN),
        backlash: limits.backlash_arcmin.map(|limit| limit * ARCMIN),
        start_stop_torque: *limits.start_stop_torque_n_m,
        emergency_torque: *limits.emergency_torque_n_m,
        output_speed: limits.output_speed_rpm.map(|limit| limit * RPM),
        catalogue_life: limits.catalogue_life_h.map(|limit| limit * HOUR),
        contact_endurance: limits.contact_endurance_mpa.map(|limit| limit * MPA),
    }
}

fn ring(design: &DesignSections) -> PinRing {
    let ring = &design.ring;
    PinRing {
        pin_count: *ring.pin_count,
        pin_circle_radius: *ring.pin_circle_radius_mm * MM,
        pin_radius: *ring.pin_radius_mm * MM,
        material: ring.material.value.clone(),
        mounting: *ring.pin_mounting,
        seat_compliance: *ring.seat_compliance_um_per_kn * UM / 1e3,
    }
}

/// Mass in kg and moment of inertia in kg·m² of pins and a ring of cast iron, if the design gives no values:
/// from the pin circle to 1.25 of its radius, 1.25 times as wide as all discs.
fn housing_solid(design: &DesignSections) -> (f64, f64) {
    // EN-GJS-450, the QT450 of Tao2024.
    const CAST_IRON: f64 = 7060.0;
    let ring = ring(design);
    let width = 1.25 * *design.disc.count as f64 * *design.disc.width_mm * MM;
    let (inner, outer) = (ring.pin_circle_radius, 1.25 * ring.pin_circle_radius);
    let pin = solids::cylinder(2.0 * ring.pin_radius, width, ring.material.density);
    let pins = ring.pin_count as f64 * pin.0;
    let (hole, solid) =
        (solids::cylinder(2.0 * inner, width, CAST_IRON), solids::cylinder(2.0 * outer, width, CAST_IRON));
    (pins + solid.0 - hole.0, pins * inner * inner + solid.1 - hole.1)
}

fn housing(design: &DesignSections) -> Housing {
    let solid = housing_solid(design);
    Housing {
        mass: design.housing.mass_kg.unwrap_or(solid.0),
        inertia: design.housing.inertia_kg_m2.unwrap_or(solid.1),
    }
}

/// The flank as ground, in m.
pub(super) fn profile(design: &DesignSections) -> Profile {
    let cut = &design.disc.modification;
    Profile::new(
        *design.ring.pin_count,
        *design.ring.pin_circle_radius_mm * MM + *cut.radial_offset_um * UM,
        *design.crankshafts.eccentricity_mm * MM,
        *design.ring.pin_radius_mm * MM + *cut.equidistant_offset_um * UM,
    )
}

/// All bores and holes of a disc in m and rad, with their names and places in the file.
pub(super) fn bores(design: &DesignSections) -> Vec<(String, Bore, Place)> {
    let disc = &design.disc;
    let gear = &design.gear_stage;
    let crank_circle = 0.5 * *gear.module_mm * (*gear.sun_teeth + *gear.planet_teeth) as f64 * MM;
    let cranks = &design.crankshafts;
    let mut all = Vec::new();
    for index in 0..*cranks.count {
        let centre_angle = Kinematics::crankshaft_angle(*cranks.first_angle_deg * DEG, index, *cranks.count);
        let bore = Bore { radius: crank_bore_radius(design), centre_radius: crank_circle, centre_angle };
        let span = match *disc.crank_bore_diameter_mm {
            Some(_) => disc.crank_bore_diameter_mm.span.clone(),
            None => design.bearings.turning_arm.pitch_diameter_mm.span.clone(),
        };
        all.push((format!("crank bore {}", index + 1), bore, span));
    }
    if *disc.centre_hole_diameter_mm > 0.0 {
        let hole =
            Bore { radius: 0.5 * *disc.centre_hole_diameter_mm * MM, centre_radius: 0.0, centre_angle: 0.0 };
        all.push(("the centre hole".to_owned(), hole, disc.centre_hole_diameter_mm.span.clone()));
    }
    all.extend(
        holes(disc)
            .into_iter()
            .enumerate()
            .map(|(index, (bore, span))| (format!("hole {}", index + 1), bore, span)),
    );
    all
}

/// Radius of the crank bore in m, from the design or that of the outer raceway of the turning-arm bearing.
pub(super) fn crank_bore_radius(design: &DesignSections) -> f64 {
    let bearing = &design.bearings.turning_arm;
    let raceway = *bearing.pitch_diameter_mm + *bearing.roller_diameter_mm;
    0.5 * design.disc.crank_bore_diameter_mm.unwrap_or(raceway) * MM
}

pub(super) fn holes(disc: &DiscSection) -> Vec<(Bore, Place)> {
    let mut all = Vec::new();
    for hole in disc.holes.iter() {
        for index in 0..*hole.count {
            let centre_angle =
                *hole.angle_deg * DEG + std::f64::consts::TAU * index as f64 / *hole.count as f64;
            let bore = Bore {
                radius: 0.5 * *hole.diameter_mm * MM,
                centre_radius: *hole.centre_radius_mm * MM,
                centre_angle,
            };
            all.push((bore, hole.diameter_mm.span.clone()));
        }
    }
    all
}

/// Mass in kg and moment of inertia in kg·m² of one disc as a solid.
fn disc_solid(design: &DesignSections) -> (f64, f64) {
    let disc = &design.disc;
    let solid = bores(design)
        .iter()
        .fold(Solid::inside_flank(&profile(design)), |solid, (_, bore, _)| solid.without(bore));
    let solid =
        super::bodies::windows(design).iter().fold(solid, |solid, window| solid.without_window(window));
    let mass_per_area = disc.material.density * (*disc.width_mm * MM);
    (mass_per_area * solid.area, mass_per_area * solid.polar_moment)
}

fn disc(design: &DesignSections) -> CycloidDisc {
    let disc = &design.disc;
    let solid = disc_solid(design);
    CycloidDisc {
        width: *disc.width_mm * MM,
        material: disc.material.value.clone(),
        modification: modification(&disc.modification),
        crank_bore_radius: crank_bore_radius(design),
        centre_hole_radius: 0.5 * *disc.centre_hole_diameter_mm * MM,
        holes: holes(disc).into_iter().map(|(bore, _)| bore).collect(),
        windows: super::bodies::windows(design),
        mass: disc.mass_kg.unwrap_or(solid.0),
        inertia: disc.inertia_kg_m2.unwrap_or(solid.1),
    }
}

pub(super) fn modification(section: &ModificationSection) -> FlankModification {
    let points: Vec<[f64; 2]> =
        section.free_form_deg_um.iter().map(|[angle, depth]| [angle * DEG, depth * UM]).collect();
    FlankModification {
        equidistant_offset: *section.equidistant_offset_um * UM,
        radial_offset: *section.radial_offset_um * UM,
        rotation: *section.rotation_arcmin * ARCMIN,
        free_form: (!points.is_empty()).then(|| Relief::through(&points)),
    }
}

/// Mass in kg and moment of inertia in kg·m² of one crankshaft with its planet, from cylinders.
fn crankshaft_solid(design: &DesignSections) -> (f64, f64) {
    let section = &design.crankshafts;
    let (gear_stage, bearings) = (gear_stage(design), bearings(design));
    let eccentricity = *section.eccentricity_mm * MM;
    let shaft_diameter = *section.shaft_diameter_mm * MM;
    let disc_width = *design.disc.width_mm * MM;
    let density = section.material.density;
    let discs = *design.disc.count as f64;
    let shaft = solids::cylinder(shaft_diameter, bearings.crank_support_span, density);
    let eccentric_diameter = bearings.turning_arm.pitch_diameter - bearings.turning_arm.roller_diameter;
    // The eccentrics are rings around the shaft: their contribution, with the parallel-axis term of the
    // eccentricity.
    let eccentric = solids::cylinder(eccentric_diameter, disc_width, density);
    let core = solids::cylinder(shaft_diameter, disc_width, density);
    let added = (eccentric.0 - core.0).max(0.0);
    let added_inertia = (eccentric.1 - core.1).max(0.0) + eccentric.0 * eccentricity * eccentricity;
    let planet = solids::cylinder(2.0 * gear_stage.planet_pitch_radius(), gear_stage.face_width, density);
    (shaft.0 + discs * added + planet.0, shaft.1 + discs * added_inertia + planet.1)
}

fn crankshafts(design: &DesignSections) -> Crankshafts {
    let section = &design.crankshafts;
    let solid = crankshaft_solid(design);
    Crankshafts {
        count: *section.count,
        eccentricity: *section.eccentricity_mm * MM,
        first_angle: *section.first_angle_deg * DEG,
        mass: section.mass_kg.unwrap_or(solid.0),
        inertia: section.inertia_kg_m2.unwrap_or(solid.1),
        shaft_diameter: *section.shaft_diameter_mm * MM,
        material: section.material.value.clone(),
    }
}

/// A mass or moment of inertia in the file for a geometry that has been changed since.
#[derive(Debug, Clone, PartialEq)]
pub struct StaleMass {
    /// Path of the key.
    pub path: &'static str,
    /// The value given, in the unit of the key.
    pub given: f64,
    /// Ratio of the mass (inertia) of the changed solid to that of the original one; the value for the changed
    /// geometry is `given` times this.
    pub factor: f64,
}

/// Relative change of a solid's mass above which a given mass is reported as stale.
const STALE: f64 = 1e-3;

/// Masses with the same value in `design` and `base` although the solids differ.
pub(super) fn stale_masses(base: &DesignSections, design: &DesignSections) -> Vec<StaleMass> {
    let (before, now) = (given_masses(base), given_masses(design));
    let stale =
        now.into_iter().zip(before).filter_map(|((path, given, solid), (_, given_before, solid_before))| {
            let (given, factor) = (given?, solid / solid_before);
            (Some(given) == given_before && (factor - 1.0).abs() > STALE).then_some(StaleMass {
                path,
                given,
                factor,
            })
        });
    stale.collect()
}

/// Every mass and inertia that a file can give, with that of its solid: in kg and kg·m² if the solid is known,
/// otherwise in proportion to the available space.
fn given_masses(design: &DesignSections) -> [(&'static str, Option<f64>, f64); 9] {
    let (disc, crank, housing) = (disc_solid(design), crankshaft_solid(design), housing_solid(design));
    let carrier = &design.carrier;
    let (radius, span) = (*design.ring.pin_circle_radius_mm, *design.bearings.crank_support_span_mm);
    let bulk = carrier.material.density * radius * radius * span;
    let gear = &design.gear_stage;
    let sun = (*gear.module_mm * *gear.sun_teeth as f64).powi(4) * *gear.face_width_mm;
    [
        ("disc.mass_kg", *design.disc.mass_kg, disc.0),
        ("disc.inertia_kg_m2", *design.disc.inertia_kg_m2, disc.1),
        ("crankshafts.mass_kg", *design.crankshafts.mass_kg, crank.0),
        ("crankshafts.inertia_kg_m2", *design.crankshafts.inertia_kg_m2, crank.1),
        ("housing.mass_kg", *design.housing.mass_kg, housing.0),
        ("housing.inertia_kg_m2", *design.housing.inertia_kg_m2, housing.1),
        ("carrier.mass_kg", Some(*carrier.mass_kg), bulk),
        ("carrier.inertia_kg_m2", Some(*carrier.inertia_kg_m2), bulk * radius * radius),
        ("gear_stage.sun_inertia_kg_m2", Some(*gear.sun_inertia_kg_m2), sun),
    ]
}

fn gear_stage(design: &DesignSections) -> GearStage {
    let gear = &design.gear_stage;
    GearStage {
        sun_teeth: *gear.sun_teeth,
        planet_teeth: *gear.planet_teeth,
        module: *gear.module_mm * MM,
        pressure_angle: *gear.pressure_angle_deg * DEG,
        mesh_stiffness: *gear.mesh_stiffness_n_per_um * N_PER_UM,
        mesh_stiffness_variation: *gear.mesh_stiffness_variation,
        mesh_damping: *gear.mesh_damping_n_s_per_m,
        backlash: *gear.backlash_um * UM,
        sun_inertia: *gear.sun_inertia_kg_m2,
        motor_inertia: *gear.motor_inertia_kg_m2,
        input_torsional_stiffness: gear
            .input_torsional_stiffness_n_m_per_arcmin
            .map_or(f64::INFINITY, |stiffness| stiffness / ARCMIN),
        face_width: *gear.face_width_mm * MM,
    }
}

pub(super) fn roller(bearing: &RollerBearingSection) -> RollerBearing {
    RollerBearing {
        kind: *bearing.kind,
        roller_count: *bearing.roller_count,
        roller_diameter: *bearing.roller_diameter_mm * MM,
        roller_length: bearing.roller_length_mm.unwrap_or(0.0) * MM,
        pitch_diameter: *bearing.pitch_diameter_mm * MM,
        contact_angle: *bearing.contact_angle_deg * DEG,
        clearance: *bearing.clearance_um * UM,
        dynamic_load_rating: bearing.dynamic_load_rating_kn.map(|rating| rating * 1e3),
    }
}

fn bearings(design: &DesignSections) -> BearingSet {
    let bearings = &design.bearings;
    BearingSet {
        turning_arm: roller(&bearings.turning_arm),
        crank_support: roller(&bearings.crank_support),
        crank_support_span: *bearings.crank_support_span_mm * MM,
        main: SupportStiffness {
            radial: *bearings.main.radial_stiffness_n_per_um * N_PER_UM,
            clearance: *bearings.main.clearance_um * UM,
        },
        sun: SupportStiffness { radial: *bearings.sun_radial_stiffness_n_per_um * N_PER_UM, clearance: 0.0 },
    }
}

fn friction(design: &DesignSections) -> Friction {
    let friction = &design.friction;
    Friction {
        flank: *friction.flank_coefficient,
        pin_seat: *friction.pin_seat_coefficient,
        bearing: *friction.bearing_coefficient,
        gear_mesh: *friction.gear_mesh_coefficient,
        seal_drag: *friction.seal_drag_n_m,
        oil_drag: *friction.oil_drag_n_m_s_per_rad,
        regularisation_speed: *friction.regularisation_speed_mm_s * MM,
        bearing_drag: *friction.bearing_drag_factor,
        crank_support_preload: *friction.crank_support_preload_n,
    }
}
