//! Conversion of the sections of a stage of a drive of eccentrics to SI units, with checks for contradictions.

use std::f64::consts::TAU;

use super::consistency::{self, Place, contradiction};
use super::error::Source;
use super::resolve;
use super::resolve_laws::law;
use super::schema::At;
use super::sections::{DiscSection, ModificationSection, RingSection};
use super::service::{ContactSection, FrictionSection, RollerBearingSection};
use super::single_stage::{EccentricSection, OutputPinsSection, PinSupport, StageBearingsSection};
use super::solids::Section as Solid;
use super::{DesignError, Section};
use crate::contact::{ContactLaw, LineContact};
use crate::geometry::Profile;
use crate::machine::{
    Bore, OutputPins, PinBeam, PinMounting, RingMesh, SingleStage, StageErrors, StageFriction,
};
use crate::materials::Material;
use crate::units::{MM, UM};

/// Sections of one stage, with its rated torque in N·m.
pub(super) struct StageParts<'a> {
    pub ring: &'a RingSection,
    pub disc: &'a DiscSection,
    pub eccentric: &'a EccentricSection,
    pub output_pins: &'a Section<OutputPinsSection>,
    pub bearings: &'a StageBearingsSection,
    pub contact: &'a At<Section<ContactSection>>,
    pub rated: f64,
}

/// Cut of a disc: modification of its flank, and tip diameter.
pub(super) type Cut<'a> = (&'a ModificationSection, &'a At<Option<f64>>);

/// Flank and ring, free of contradictions.
pub(super) fn ring_mesh(
    ring: &RingSection,
    (modification, tip_diameter): Cut<'_>,
    eccentricity: &At<f64>,
    (material, width): (&Material, f64),
    contact: &At<Section<ContactSection>>,
    source: &Source,
) -> Result<RingMesh, Box<DesignError>> {
    consistency::free_form(modification, source)?;
    let cut = resolve::modification(modification);
    let (circle, pin_radius) = (*ring.pin_circle_radius_mm * MM, *ring.pin_radius_mm * MM);
    let mut profile = Profile::new(
        *ring.pin_count,
        circle + cut.radial_offset,
        **eccentricity * MM,
        pin_radius + cut.equidistant_offset,
    );
    profile.tooth_difference = ring.tooth_difference.unwrap_or(1);
    consistency::flank(&profile, ring, modification, &eccentricity.span, source)?;
    let profile = consistency::tip(profile, tip_diameter, source)?;
    if *ring.pin_mounting == PinMounting::OnePiece && *ring.seat_compliance_um_per_kn > 0.0 {
        let place = &ring.seat_compliance_um_per_kn.span;
        let message = "a ring of one piece has no pin seats, so that it has no seat compliance".to_owned();
        return Err(contradiction(source, place, message, "leave seat_compliance_um_per_kn out"));
    }
    let contact_law = law(&contact.law, &contact.span, &contact.parameters(), source)?;
    Ok(RingMesh {
        contact: LineContact::new(contact_law, material, &ring.material, width, pin_radius)
            .with_seat_compliance(*ring.seat_compliance_um_per_kn * UM / 1e3),
        relief: cut.relief(&profile),
        profile,
        ring_circle_radius: circle,
        ring_pin_radius: pin_radius,
        mounting: *ring.pin_mounting,
    })
}

/// Rejects keys that only discs of RV reducers have.
pub(super) fn round_openings(disc: &DiscSection, source: &Source) -> Result<(), Box<DesignError>> {
    if *disc.centre_hole_diameter_mm > 0.0 {
        let message = "a single stage has its eccentric bearing in the centre of the disc".to_owned();
        let place = &disc.centre_hole_diameter_mm.span;
        return Err(contradiction(source, place, message, "leave centre_hole_diameter_mm out"));
    }
    for (key, place) in [("window_rim_mm", &disc.window_rim_mm.span), ("windows", &disc.windows.span)] {
        if place.is_some() {
            let message = format!("`{key}` describes windows for the pillars of an RV reducer");
            return Err(contradiction(source, place, message, "describe round holes by [[disc.holes]]"));
        }
    }
    Ok(())
}

/// A stage in SI units.
pub(super) fn stage(design: &StageParts<'_>, source: &Source) -> Result<SingleStage, Box<DesignError>> {
    let (ring, disc) = (design.ring, design.disc);
    consistency::lobes(ring, &disc.lobe_count, source)?;
    consistency::roller_bearing("eccentric", &design.bearings.eccentric, source)?;
    let width = *disc.width_mm * MM;
    let eccentricity = &design.eccentric.eccentricity_mm;
    let mesh = ring_mesh(
        ring,
        (&disc.modification, &disc.tip_diameter_mm),
        eccentricity,
        (&disc.material, width),
        design.contact,
        source,
    )?;
    let profile = &mesh.profile;
    round_openings(disc, source)?;
    let pins = &design.output_pins;
    if *pins.roller_radius_mm < *pins.pin_radius_mm {
        let message = format!(
            "a roller of {} mm radius does not go over a pin of {} mm",
            *pins.roller_radius_mm, *pins.pin_radius_mm
        );
        let hint = "equal radii describe pins without rollers";
        return Err(contradiction(source, &pins.roller_radius_mm.span, message, hint));
    }
    let output_pins = OutputPins {
        count: *pins.count,
        circle_radius: *pins.circle_radius_mm * MM,
        radius: *pins.roller_radius_mm * MM,
        hole_clearance: *pins.hole_clearance_um * UM,
    };
    let openings = openings(design, &output_pins, profile.eccentricity);
    consistency::bores(profile, &openings, source)?;
    let openings: Vec<Bore> = openings.into_iter().map(|(_, opening, _)| opening).collect();
    let solid = openings.iter().fold(Solid::inside_flank(profile), |solid, opening| solid.without(opening));
    let mass_per_area = disc.material.density * width;
    let mass = disc.mass_kg.unwrap_or(mass_per_area * solid.area);
    let inertia = disc.inertia_kg_m2.unwrap_or(mass_per_area * solid.polar_moment);
    let (law_of_holes, roller_radius) = (ContactLaw::LineHertz, output_pins.radius);
    let eccentric = resolve::roller(&design.bearings.eccentric);
    let stack = *disc.count as f64 * width;
    let mut stage = SingleStage {
        phases: (0..*disc.count).map(|j| TAU * j as f64 / *disc.count as f64).collect(),
        // As wide as the discs together.
        input: eccentric.shaft(stack),
        output: output_pins.plates(stack),
        ring_body: mesh.ring_body(stack),
        mesh,
        eccentric,
        output_pins,
        output_contact: LineContact::new(law_of_holes, &disc.material, &pins.material, width, roller_radius),
        pin_beam: pin_beam(design),
        output_pin_stiffness: Vec::new(),
        openings,
        input_support: *design.bearings.input_radial_stiffness_n_per_um * 1e6,
        output_support: *design.bearings.output_radial_stiffness_n_per_um * 1e6,
        disc_material: disc.material.value.clone(),
        disc: (mass, inertia),
        errors: StageErrors::default(),
    };
    stage.output_pin_stiffness =
        (0..*disc.count).map(|j| output_pin_stiffness(design.rated, &stage, j)).collect();
    Ok(stage)
}

/// Bore of the eccentric bearing in the centre of a disc, with its name and place in the file.
pub(super) fn eccentric_bore(disc: &DiscSection, bearing: &RollerBearingSection) -> (String, Bore, Place) {
    let raceway = *bearing.pitch_diameter_mm + *bearing.roller_diameter_mm;
    let radius = 0.5 * disc.crank_bore_diameter_mm.unwrap_or(raceway) * MM;
    let place = disc.crank_bore_diameter_mm.span.clone().or(bearing.pitch_diameter_mm.span.clone());
    let bore = Bore { radius, centre_radius: 0.0, centre_angle: 0.0 };
    ("the bore of the eccentric bearing".to_owned(), bore, place)
}

/// That bore, the holes of the output pins and other holes, in m and rad, with names and places in the file.
fn openings(design: &StageParts<'_>, pins: &OutputPins, eccentricity: f64) -> Vec<(String, Bore, Place)> {
    let hole = |index: usize| {
        let centre_angle = TAU * index as f64 / pins.count as f64;
        let radius = pins.hole_radius(eccentricity);
        let hole = Bore { radius, centre_radius: pins.circle_radius, centre_angle };
        let place = design.output_pins.circle_radius_mm.span.clone();
        (format!("the hole of output pin {}", index + 1), hole, place)
    };
    let others = resolve::holes(design.disc).into_iter().enumerate();
    std::iter::once(eccentric_bore(design.disc, &design.bearings.eccentric))
        .chain((0..pins.count).map(hole))
        .chain(others.map(|(index, (hole, place))| (format!("hole {}", index + 1), hole, place)))
        .collect()
}

/// Friction coefficients of flanks, of pins in seats and rollers on pins, and of rolling bearings; and whether
/// they are assumed.
pub(super) fn coefficients(given: &At<Section<FrictionSection>>) -> ([f64; 3], bool) {
    let assumed = given.span.is_none();
    let coefficients = if assumed {
        ASSUMED_FRICTION
    } else {
        [*given.flank_coefficient, *given.pin_seat_coefficient, *given.bearing_coefficient]
    };
    (coefficients, assumed)
}

/// Friction of a stage by these coefficients; spinning ring pins slide on the surface with the smaller
/// coefficient.
pub(super) fn stage_friction(
    [flank, seat, bearing]: [f64; 3],
    ring: &RingSection,
    pins: Option<&OutputPinsSection>,
) -> StageFriction {
    let has_rollers = pins.is_some_and(OutputPinsSection::has_rollers);
    StageFriction {
        ring: if *ring.pin_mounting == PinMounting::Spinning { flank.min(seat) } else { flank },
        output: if has_rollers { seat } else { flank },
        pin_over_roller: pins.map_or(1.0, |pins| *pins.pin_radius_mm / *pins.roller_radius_mm),
        bearing,
    }
}

/// Friction coefficients with grease, as for RV reducers: flanks; pins in seats and rollers on pins; rolling
/// bearings.
const ASSUMED_FRICTION: [f64; 3] = [0.06, 0.06, 0.002];

/// An output pin as a beam.
fn pin_beam(design: &StageParts<'_>) -> PinBeam {
    let (pins, width, discs) = (&design.output_pins, *design.disc.width_mm * MM, *design.disc.count);
    let first = pins.plate_distance_mm.map_or(0.5 * width, |distance| distance * MM);
    PinBeam {
        radius: *pins.pin_radius_mm * MM,
        places: (0..discs).map(|disc| first + disc as f64 * width).collect(),
        span: match *pins.support {
            PinSupport::OneEnd => None,
            PinSupport::BothEnds => Some(2.0 * first + (discs - 1) as f64 * width),
        },
        material: pins.material.value.clone(),
    }
}

/// Stiffness in N/m of one output pin at a disc: the pin as a Timoshenko beam, in series with the line contact of roller
/// and hole, its secant at the largest force of equal springs under the rated torque.
///
/// Not modelled: the deflection of a pin at one disc by the force of another disc.
fn output_pin_stiffness(rated: f64, stage: &SingleStage, disc: usize) -> f64 {
    let equivalent = stage.output_pins.equivalent_radius(stage.profile.eccentricity);
    let force = stage.output_pin_force(rated);
    1.0 / (stage.pin_beam.compliance(disc) + stage.output_contact.approach(force, equivalent) / force)
}
