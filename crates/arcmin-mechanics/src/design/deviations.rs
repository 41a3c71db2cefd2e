//! Manufacturing errors and tolerances from the design as written to SI units.

use super::consistency::{Place, contradiction};
use super::error::Source;
use super::schema::At;
use super::{DesignError, DesignSections, RunOutSection};
use crate::geometry::FlankHarmonic;
use crate::machine::{
    BoreError, DiscError, EccentricError, ManufacturingErrors, PinError, RunOut, Tolerances,
};
use crate::units::{ARCMIN, DEG, UM};

type Result<T> = std::result::Result<T, Box<DesignError>>;

/// A measured flank; its file is read by callers with access to files.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredFlank {
    /// Counted from 0.
    pub disc: usize,
    /// As written in the design file, relative to it.
    pub file: String,
}

/// Checks that numbers of parts are in range and unique.
pub(super) struct Numbers<'a> {
    source: &'a Source<'a>,
    seen: Vec<(usize, usize)>,
}

impl<'a> Numbers<'a> {
    pub(super) fn new(source: &'a Source<'a>) -> Numbers<'a> {
        Numbers { source, seen: Vec::new() }
    }

    /// Index counted from 0.
    pub(super) fn one(&self, at: &At<usize>, count: usize, what: &str) -> Result<usize> {
        if **at > count {
            let message = format!("{what} {} does not exist: the design has {count}", **at);
            return Err(contradiction(
                self.source,
                &at.span,
                message,
                &format!("write a number from 1 to {count}"),
            ));
        }
        Ok(**at - 1)
    }

    pub(super) fn once(&mut self, key: (usize, usize), place: &Place, what: &str) -> Result<()> {
        if self.seen.contains(&key) {
            return Err(contradiction(
                self.source,
                place,
                format!("{what} is given twice"),
                "give all of its errors in one table",
            ));
        }
        self.seen.push(key);
        Ok(())
    }
}

pub(super) fn slot<T: Default + Clone>(list: &mut Vec<T>, index: usize) -> &mut T {
    if list.len() <= index {
        list.resize(index + 1, T::default());
    }
    &mut list[index]
}

pub(super) fn run_out(section: &RunOutSection) -> RunOut {
    RunOut { amplitude: *section.amplitude_um * UM, phase: *section.phase_deg * DEG }
}

/// Errors given one by one, in SI units, without measured flanks.
pub(super) fn errors(design: &DesignSections, source: &Source) -> Result<Option<ManufacturingErrors>> {
    let Some(section) = design.errors.value.as_ref() else { return Ok(None) };
    let (pins, discs, cranks) = (*design.ring.pin_count, *design.disc.count, *design.crankshafts.count);
    let mut all = ManufacturingErrors {
        pin_circle_radius: *section.pin_circle_radius_um * UM,
        pin_radius: *section.pin_radius_um * UM,
        pin_circle_offset: run_out(&section.pin_circle_offset),
        carrier: run_out(&section.carrier),
        sun: run_out(&section.sun),
        ..ManufacturingErrors::default()
    };
    let numbers = || Numbers::new(source);
    let mut seen = numbers();
    for row in section.pins.iter() {
        let pin = seen.one(&row.pin, pins, "pin")?;
        seen.once((pin, 0), &row.pin.span, &format!("pin {}", pin + 1))?;
        *slot(&mut all.pins, pin) = PinError {
            radial: *row.radial_um * UM,
            tangential: *row.tangential_um * UM,
            radius: *row.radius_um * UM,
        };
    }
    for row in section.flanks.iter() {
        let disc = numbers().one(&row.disc, discs, "disc")?;
        slot::<DiscError>(&mut all.discs, disc).flank.harmonics.push(FlankHarmonic {
            order: *row.order,
            amplitude: *row.amplitude_um * UM,
            phase: *row.phase_deg * DEG,
            direction: *row.kind,
        });
    }
    let mut seen = numbers();
    for row in section.measured_flanks.iter() {
        let disc = seen.one(&row.disc, discs, "disc")?;
        seen.once((disc, 0), &row.disc.span, &format!("the measured flank of disc {}", disc + 1))?;
    }
    let mut seen = numbers();
    for row in section.disc_bores.iter() {
        let (disc, crank) =
            (seen.one(&row.disc, discs, "disc")?, seen.one(&row.crankshaft, cranks, "crankshaft")?);
        seen.once(
            (disc, crank),
            &row.disc.span,
            &format!("the bore of disc {} for crankshaft {}", disc + 1, crank + 1),
        )?;
        *slot(&mut slot::<DiscError>(&mut all.discs, disc).bores, crank) = BoreError {
            radial: *row.radial_um * UM,
            tangential: *row.tangential_um * UM,
            diameter: *row.diameter_um * UM,
        };
    }
    let mut seen = numbers();
    for row in section.eccentrics.iter() {
        let (disc, crank) =
            (seen.one(&row.disc, discs, "disc")?, seen.one(&row.crankshaft, cranks, "crankshaft")?);
        seen.once(
            (disc, crank),
            &row.crankshaft.span,
            &format!("the eccentric of disc {} on crankshaft {}", disc + 1, crank + 1),
        )?;
        *slot(slot::<Vec<EccentricError>>(&mut all.eccentrics, crank), disc) =
            EccentricError { eccentricity: *row.eccentricity_um * UM, phase: *row.phase_arcmin * ARCMIN };
    }
    let mut seen = numbers();
    for row in section.carrier_bores.iter() {
        let crank = seen.one(&row.crankshaft, cranks, "crankshaft")?;
        seen.once(
            (crank, 0),
            &row.crankshaft.span,
            &format!("the carrier's bore for crankshaft {}", crank + 1),
        )?;
        *slot(&mut all.carrier_bores, crank) = BoreError {
            radial: *row.radial_um * UM,
            tangential: *row.tangential_um * UM,
            diameter: *row.diameter_um * UM,
        };
    }
    for (rows, list, what) in
        [(&section.journals, &mut all.journals, "journal"), (&section.planets, &mut all.planets, "planet")]
    {
        let mut seen = numbers();
        for row in rows.iter() {
            let crank = seen.one(&row.crankshaft, cranks, "crankshaft")?;
            seen.once((crank, 0), &row.crankshaft.span, &format!("the {what} of crankshaft {}", crank + 1))?;
            *slot(list, crank) = RunOut { amplitude: *row.amplitude_um * UM, phase: *row.phase_deg * DEG };
        }
    }
    Ok(Some(all))
}

pub(super) fn measured_flanks(design: &DesignSections) -> Vec<MeasuredFlank> {
    let rows = design.errors.value.iter().flat_map(|section| section.measured_flanks.iter());
    rows.map(|row| MeasuredFlank { disc: *row.disc - 1, file: row.file.value.clone() }).collect()
}

pub(super) fn tolerances(design: &DesignSections) -> Option<Tolerances> {
    let section = design.tolerances.value.as_ref()?;
    Some(Tolerances {
        pin_position: *section.pin_position_um * UM,
        pin_radius: *section.pin_radius_um * UM,
        pin_circle_radius: *section.pin_circle_radius_um * UM,
        pin_circle_offset: *section.pin_circle_offset_um * UM,
        eccentricity: *section.eccentricity_um * UM,
        eccentric_phase: *section.eccentric_phase_arcmin * ARCMIN,
        bore_position: *section.bore_position_um * UM,
        bore_diameter: *section.bore_diameter_um * UM,
        flank_run_out: *section.flank_run_out_um * UM,
        flank_pitch: *section.flank_pitch_um * UM,
        flank_profile: *section.flank_profile_um * UM,
        journal_run_out: *section.journal_run_out_um * UM,
        planet_run_out: *section.planet_run_out_um * UM,
        carrier_run_out: *section.carrier_run_out_um * UM,
        sun_run_out: *section.sun_run_out_um * UM,
    })
}
