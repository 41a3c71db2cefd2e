//! The design file of two stages in series: the family `two-stage`.

use super::consistency;
use super::drives::{self, PinSections, drive_design};
use super::edit::{OfWritten, Written};
use super::error::Source;
use super::field;
use super::resolve;
use super::resolve_laws;
use super::schema::{At, default_word, optional, section, word};
use super::sections::{DiscSection, RingSection};
use super::service::{
    ContactSection, DutySection, FrictionSection, LimitsSection, LoadSection, OPTIONAL_SECTION, WearSection,
};
use super::single_stage::{UNUSED, unused_keys};
use super::stage_resolve::{StageParts, coefficients, stage, stage_friction};
use super::unknowns::{self, Unknown};
use super::variation::Variations;
use super::{
    DesignError, DriveSection, EccentricSection, Family, OutputPinsSection, ProcessSection, Section,
    StageBearingsSection, StageErrorsSection, StageProcess, StageThermalSection, StageTolerancesSection,
};
use crate::machine::{
    DutyPoint, Limits, SingleStage, StageErrors, StageFriction, StageTolerances, TwoStage, Wear,
};

section! {
    /// The stage at the input. Its output pins are on the shaft with the eccentrics of the other stage.
    pub struct FirstStageSection {
        /// The ring of pins.
        ring: Section<RingSection> => word(),
        /// The cycloid discs.
        disc: Section<DiscSection> => word(),
        /// The eccentrics.
        eccentric: Section<EccentricSection> => word(),
        /// The output pins.
        output_pins: Section<OutputPinsSection> => word(),
        /// Bearings.
        bearings: Section<StageBearingsSection> => word(),
        /// Errors of this stage of one drive. Left out: none.
        errors: Option<Section<StageErrorsSection>> => optional(0.0, 0.0),
        /// Tolerances of this stage. Left out: it is exact.
        tolerances: Option<Section<StageTolerancesSection>> => optional(0.0, 0.0),
        /// Manufacturing processes of the parts of this stage. Left out: no tolerances and no systematic
        /// deviations by process.
        process: Option<Section<ProcessSection>> => optional(0.0, 0.0),
    }

    /// A design file of the family `two-stage`.
    pub struct TwoStageSections {
        /// Name of the design, for reports.
        name: String => word(),
        /// One sentence for reports.
        description: String => default_word(""),
        /// Kind of drive: `family = "two-stage"`.
        drive: Section<DriveSection> => OPTIONAL_SECTION,
        /// The stage at the input.
        first_stage: Section<FirstStageSection> => word(),
        /// The ring of pins of the stage at the output.
        ring: Section<RingSection> => word(),
        /// The cycloid discs of that stage.
        disc: Section<DiscSection> => word(),
        /// The eccentrics of that stage.
        eccentric: Section<EccentricSection> => word(),
        /// The output pins of that stage.
        output_pins: Section<OutputPinsSection> => word(),
        /// Bearings of that stage.
        bearings: Section<StageBearingsSection> => word(),
        /// Friction.
        friction: Section<FrictionSection> => OPTIONAL_SECTION,
        /// Law of the contacts of ring pins with flanks.
        contact: Section<ContactSection> => OPTIONAL_SECTION,
        /// Rated load and speed.
        load: Section<LoadSection> => word(),
        /// Load spectrum. Left out, the drive runs at its rated point.
        duty: Vec<At<Section<DutySection>>> => optional(0.0, 0.0),
        /// Wear, of all rings alike. A coefficient found from a depth is found from that of the flank in the stage at the output.
        wear: Option<Section<WearSection>> => optional(0.0, 0.0),
        /// Heat.
        thermal: Section<StageThermalSection> => OPTIONAL_SECTION,
        /// Limits.
        limits: Section<LimitsSection> => OPTIONAL_SECTION,
        /// Errors of the stage at the output of one drive. Left out: none.
        errors: Option<Section<StageErrorsSection>> => optional(0.0, 0.0),
        /// Manufacturing processes of the parts of the stage at the output. Left out: no tolerances and no
        /// systematic deviations by process.
        process: Option<Section<ProcessSection>> => optional(0.0, 0.0),
        /// Tolerances of the stage at the output from which drives are drawn. If neither stage has tolerances
        /// or a process, no drives can be drawn.
        tolerances: Option<Section<StageTolerancesSection>> => optional(0.0, 0.0),
        /// Values that are not known exactly.
        unknowns: Variations => optional(0.0, 0.0),
    }
}

drive_design! {
    /// Two stages in series as written, free of contradictions.
    TwoStageDesign, TwoStageSections, TwoStage, [StageErrors; 2], Family::TwoStage, two_stage,
    |sections: &TwoStageSections| {
        [*sections.first_stage.bearings.eccentric.kind, *sections.bearings.eccentric.kind]
    },
    pin_sections, given
}

fn pin_sections(sections: &TwoStageSections) -> PinSections<'_> {
    let first = &sections.first_stage;
    (
        vec![("first_stage.ring", &first.ring), ("ring", &sections.ring)],
        vec![&first.output_pins, &sections.output_pins],
    )
}

/// Errors of one drive, if the file contains any.
fn given(
    sections: &TwoStageSections,
    drive: &TwoStage,
    source: &Source,
) -> Result<Option<[StageErrors; 2]>, Box<DesignError>> {
    let resolve = |section: &Option<Section<StageErrorsSection>>, stage: &SingleStage| {
        section.as_ref().map(|errors| errors.resolve(stage.part_counts(), source)).transpose()
    };
    let first = resolve(&sections.first_stage.errors, &drive.first)?;
    let second = resolve(&sections.errors, &drive.second)?;
    Ok((first.is_some() || second.is_some()).then(|| [first, second].map(Option::unwrap_or_default)))
}

impl TwoStageDesign {
    /// Tolerances from which drives are drawn, stage by stage, if the file contains them.
    pub fn tolerances(&self) -> Option<[StageTolerances; 2]> {
        let [first, second] = self.processes();
        let first = StageTolerancesSection::of(self.first_stage.tolerances.value.as_deref(), first.as_ref());
        let second = StageTolerancesSection::of(self.sections.tolerances.value.as_deref(), second.as_ref());
        (first.is_some() || second.is_some()).then(|| [first, second].map(Option::unwrap_or_default))
    }

    /// Processes of the parts of either stage, if the file contains them.
    pub fn processes(&self) -> [Option<StageProcess>; 2] {
        [&self.first_stage.process, &self.sections.process]
            .map(|section| section.value.as_ref().map(|section| section.resolve()))
    }

    /// Coefficients of friction of either stage, and whether they are assumed because the file gives none.
    pub fn friction(&self) -> ([StageFriction; 2], bool) {
        let (coefficients, assumed) = coefficients(&self.sections.friction);
        let first = &self.first_stage;
        let friction = [(&first.ring, &first.output_pins), (&self.ring, &self.output_pins)]
            .map(|(ring, pins)| stage_friction(coefficients, ring, Some(pins)));
        (friction, assumed)
    }
}

fn two_stage(design: &TwoStageSections, source: &Source) -> Result<TwoStage, Box<DesignError>> {
    let rated = *design.load.rated_torque_n_m;
    let second = stage(
        &StageParts {
            ring: &design.ring,
            disc: &design.disc,
            eccentric: &design.eccentric,
            output_pins: &design.output_pins,
            bearings: &design.bearings,
            contact: &design.contact,
            rated,
        },
        source,
    )?;
    let first = &design.first_stage;
    let first = stage(
        &StageParts {
            ring: &first.ring,
            disc: &first.disc,
            eccentric: &first.eccentric,
            output_pins: &first.output_pins,
            bearings: &first.bearings,
            contact: &design.contact,
            rated: rated / second.ratio().abs(),
        },
        source,
    )?;
    Ok(TwoStage { first, second })
}
