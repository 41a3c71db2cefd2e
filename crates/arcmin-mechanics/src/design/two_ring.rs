//! The design file of a drive of two rings: the family `two-ring`.

use std::f64::consts::TAU;

use super::consistency::{self, contradiction};
use super::drives::{self, PinSections, drive_design};
use super::edit::{OfWritten, Written};
use super::error::Source;
use super::field;
use super::process;
use super::resolve;
use super::resolve_laws;
use super::schema::{At, default_word, optional, required, section, word};
use super::sections::{DiscSection, ModificationSection, RingSection, SECTION_OR_DEFAULTS};
use super::service::{
    ContactSection, DutySection, FrictionSection, LimitsSection, LoadSection, OPTIONAL_SECTION, WearSection,
};
use super::single_stage::{UNUSED, unused_keys};
use super::solids::Section as Solid;
use super::stage_resolve::{Cut, coefficients, eccentric_bore, ring_mesh, round_openings, stage_friction};
use super::unknowns::{self, Unknown};
use super::variation::Variations;
use super::{
    DesignError, DriveSection, EccentricSection, Family, SecondErrorsSection, SecondProcessSection,
    SecondTolerancesSection, Section, StageBearingsSection, StageProcess, StageThermalSection,
    TwoRingErrorsSection, TwoRingProcessSection, TwoRingTolerancesSection,
};
use crate::geometry::Profile;
use crate::machine::{
    Bore, DutyPoint, Limits, RingMesh, StageErrors, StageFriction, StageTolerances, TwoRing, Wear,
};
use crate::units::MM;

section! {
    /// The step of the discs in the second ring, in one piece with `[disc]` and of its material.
    pub struct SecondDiscSection {
        /// Number of lobes z_c2. May be left out; if given, it must be less than the pins of the second ring by its tooth
        /// difference.
        lobe_count: Option<usize> => optional(3.0, 399.0),
        /// Diameter of the tip circle of this step, after turning. Left out: as of the other step.
        tip_diameter_mm: Option<f64> => optional(1.0, 4000.0),
        /// Face width of this step.
        width_mm: f64 => required(0.5, 500.0),
        /// Metal ground off the theoretical flank of this step on purpose.
        modification: Section<ModificationSection> => SECTION_OR_DEFAULTS,
    }

    /// A design file of the family `two-ring`.
    pub struct TwoRingSections {
        /// Name of the design, for reports.
        name: String => word(),
        /// One sentence for reports.
        description: String => default_word(""),
        /// Kind of drive: `family = "two-ring"`.
        drive: Section<DriveSection> => OPTIONAL_SECTION,
        /// The ring at rest.
        ring: Section<RingSection> => word(),
        /// The stepped discs: number, material, openings through both steps, and the step in the ring at rest. Mass and
        /// moment of inertia are those of both steps together.
        disc: Section<DiscSection> => word(),
        /// The ring that is the output.
        second_ring: Section<RingSection> => word(),
        /// The step in the second ring.
        second_disc: Section<SecondDiscSection> => word(),
        /// The eccentrics.
        eccentric: Section<EccentricSection> => word(),
        /// Bearings.
        bearings: Section<StageBearingsSection> => word(),
        /// Friction.
        friction: Section<FrictionSection> => OPTIONAL_SECTION,
        /// Law of the contacts of pins with flanks.
        contact: Section<ContactSection> => OPTIONAL_SECTION,
        /// Rated load and speed.
        load: Section<LoadSection> => word(),
        /// Load spectrum. Left out, the drive runs at its rated point.
        duty: Vec<At<Section<DutySection>>> => optional(0.0, 0.0),
        /// Wear, of all rings alike. A coefficient found from a depth is found from that of the flank in the ring at rest.
        wear: Option<Section<WearSection>> => optional(0.0, 0.0),
        /// Heat.
        thermal: Section<StageThermalSection> => OPTIONAL_SECTION,
        /// Limits.
        limits: Section<LimitsSection> => OPTIONAL_SECTION,
        /// Errors of one drive: of the ring at rest, the steps in it and the eccentrics. Left out: none.
        errors: Option<Section<TwoRingErrorsSection>> => optional(0.0, 0.0),
        /// Errors of the second ring and the steps in it. Left out: none.
        second_errors: Option<Section<SecondErrorsSection>> => optional(0.0, 0.0),
        /// Manufacturing processes of the parts. Left out: no tolerances and no systematic deviations by
        /// process.
        process: Option<Section<TwoRingProcessSection>> => optional(0.0, 0.0),
        /// Manufacturing process of the second ring. Left out: no tolerances and no systematic deviations by
        /// process.
        second_process: Option<Section<SecondProcessSection>> => optional(0.0, 0.0),
        /// Tolerances from which drives are drawn: of the ring at rest, the steps in it and the eccentrics.
        /// Without any of these four sections no drives can be drawn.
        tolerances: Option<Section<TwoRingTolerancesSection>> => optional(0.0, 0.0),
        /// Tolerances of the second ring and the steps in it. Left out: those of the processes; without a
        /// process the parts are exact.
        second_tolerances: Option<Section<SecondTolerancesSection>> => optional(0.0, 0.0),
        /// Values that are not known exactly.
        unknowns: Variations => optional(0.0, 0.0),
    }
}

drive_design! {
    /// A drive of two rings as written, free of contradictions.
    TwoRingDesign, TwoRingSections, TwoRing, [StageErrors; 2], Family::TwoRing, two_ring,
    |sections: &TwoRingSections| [*sections.bearings.eccentric.kind],
    pin_sections, given
}

fn pin_sections(sections: &TwoRingSections) -> PinSections<'_> {
    (vec![("ring", &sections.ring), ("second_ring", &sections.second_ring)], Vec::new())
}

/// Errors of one drive, if the file contains any.
fn given(
    sections: &TwoRingSections,
    drive: &TwoRing,
    source: &Source,
) -> Result<Option<[StageErrors; 2]>, Box<DesignError>> {
    let counts = drive.part_counts();
    let first = sections.errors.value.as_ref().map(|errors| errors.resolve(counts[0], source)).transpose()?;
    let second = sections.second_errors.value.as_ref();
    let second = second.map(|errors| errors.resolve(counts[1], source)).transpose()?;
    Ok((first.is_some() || second.is_some()).then(|| [first, second].map(Option::unwrap_or_default)))
}

impl TwoRingDesign {
    /// Tolerances from which drives are drawn, ring by ring, if the file contains them.
    pub fn tolerances(&self) -> Option<[StageTolerances; 2]> {
        let [first, second] = match self.processes() {
            Some(both) => both.map(Some),
            None => [None; 2],
        };
        let first = TwoRingTolerancesSection::of(self.sections.tolerances.value.as_deref(), first.as_ref());
        let given = self.sections.second_tolerances.value.as_deref();
        let second = SecondTolerancesSection::of(given, second.as_ref());
        (first.is_some() || second.is_some()).then(|| [first, second].map(Option::unwrap_or_default))
    }

    /// Processes of the parts of either ring and the steps in it, if the file contains any.
    pub fn processes(&self) -> Option<[StageProcess; 2]> {
        process::of_two_rings(
            self.sections.process.value.as_deref(),
            self.sections.second_process.value.as_deref(),
        )
    }

    /// Coefficients of friction of either ring, and whether they are assumed because the file gives none.
    pub fn friction(&self) -> ([StageFriction; 2], bool) {
        let (coefficients, assumed) = coefficients(&self.sections.friction);
        ([&self.ring, &self.second_ring].map(|ring| stage_friction(coefficients, ring, None)), assumed)
    }
}

fn two_ring(design: &TwoRingSections, source: &Source) -> Result<TwoRing, Box<DesignError>> {
    let (disc, step) = (&design.disc, &design.second_disc);
    consistency::lobes(&design.ring, &disc.lobe_count, source)?;
    consistency::lobes(&design.second_ring, &step.lobe_count, source)?;
    consistency::roller_bearing("eccentric", &design.bearings.eccentric, source)?;
    let pins = &design.second_ring.pin_count;
    let [first, second] = [&design.ring, &design.second_ring].map(|ring| ring.tooth_difference.unwrap_or(1));
    if **pins * first == *design.ring.pin_count * second {
        let message = match first == second {
            true => format!("two rings of {} pins each do not turn against each other", **pins),
            false => format!(
                "rings of {} and {} pins with tooth differences of {first} and {second} do not turn against each other",
                *design.ring.pin_count, **pins
            ),
        };
        let hint = "the ratio is z_c1 z_p2/(z_c1 m_2 − z_c2 m_1) with tooth differences m, 1 where they are left out: change the \
                    number of pins of a ring";
        return Err(contradiction(source, &pins.span, message, hint));
    }
    round_openings(disc, source)?;
    let eccentricity = &design.eccentric.eccentricity_mm;
    let mesh = |ring: &RingSection, (modification, tip): Cut<'_>, width: f64| -> Result<RingMesh, _> {
        ring_mesh(ring, (modification, tip), eccentricity, (&disc.material, width), &design.contact, source)
    };
    let widths = [*disc.width_mm * MM, *step.width_mm * MM];
    let meshes = [
        mesh(&design.ring, (&disc.modification, &disc.tip_diameter_mm), widths[0])?,
        mesh(&design.second_ring, (&step.modification, &step.tip_diameter_mm), widths[1])?,
    ];
    let others = resolve::holes(disc).into_iter().enumerate();
    let openings: Vec<_> = std::iter::once(eccentric_bore(disc, &design.bearings.eccentric))
        .chain(others.map(|(index, (hole, place))| (format!("hole {}", index + 1), hole, place)))
        .collect();
    for mesh in &meshes {
        consistency::bores(&mesh.profile, &openings, source)?;
    }
    let openings: Vec<Bore> = openings.into_iter().map(|(_, opening, _)| opening).collect();
    let solid = |profile: &Profile| {
        openings.iter().fold(Solid::inside_flank(profile), |solid, opening| solid.without(opening))
    };
    let steps = [0, 1].map(|k| (disc.material.density * widths[k], solid(&meshes[k].profile)));
    let mass = steps.iter().map(|(per_area, solid)| per_area * solid.area).sum();
    let inertia = steps.iter().map(|(per_area, solid)| per_area * solid.polar_moment).sum();
    Ok(TwoRing {
        meshes,
        widths,
        phases: (0..*disc.count).map(|j| TAU * j as f64 / *disc.count as f64).collect(),
        eccentric: resolve::roller(&design.bearings.eccentric),
        openings,
        input_support: *design.bearings.input_radial_stiffness_n_per_um * 1e6,
        output_support: *design.bearings.output_radial_stiffness_n_per_um * 1e6,
        disc: (disc.mass_kg.unwrap_or(mass), disc.inertia_kg_m2.unwrap_or(inertia)),
        errors: Default::default(),
    })
}
