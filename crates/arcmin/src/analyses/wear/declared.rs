//! Tables and figures of wear.

use std::ops::Deref;

use super::{Mode, Station, Wear, WearOverHours};
use crate::analyses::errors_table;
use crate::fidelity::Fidelity;
use crate::geometry::{Profile, Relief};
use crate::life::{Accuracy, WornState};
use crate::load::FlankForce;
use crate::results::{
    Column, DeclaredTable, PLAIN, SummaryOf, Table, TableOf, decimals, quantities as q, quantity,
};
use crate::units::{DEG, UM};

/// One place of a flank at one time.
pub(crate) struct Place {
    hours: f64,
    meshing_angle: f64,
    depth: f64,
    force: f64,
    sliding: f64,
    disc: Option<usize>,
}

pub(crate) const WEAR: TableOf<Place> = TableOf {
    name: "wear",
    what: "One row per time and place of the flank",
    columns: || {
        vec![
            q::HOURS.of(|p: &Place| p.hours.into()),
            q::MESHING_ANGLE.of(|p| (p.meshing_angle / DEG).into()),
            quantity("depth_um", decimals(3), "Depth worn off the flank there.")
                .of(|p| (p.depth / UM).into()),
            q::FORCE.of(|p| p.force.into()),
            q::SPECIFIC_SLIDING.of(|p| p.sliding.into()),
            q::DISC.of(|p| p.disc.into()),
        ]
    },
};

pub(in crate::analyses) const HISTORY: TableOf<Station> = TableOf {
    name: "wear_history",
    what: "One row per time: the machine",
    columns: || {
        vec![
            q::HOURS.of(|s: &Station| s.hours().into()),
            q::MAX_DEPTH.of(|s| (s.accuracy.max_depth / UM).into()),
            q::MAX_FORCE.of(|s| s.max_force().into()),
            q::LOADED_PAIRS.of(|s| s.loaded_pairs().into()),
            q::PLAY.of(|s| s.travel.play.arcmin().into()),
            q::MAX_DEPTH_AT.of(|s| s.worst_angle().map(|at| at / DEG).into()),
            q::MAX_PIN_DEPTH.of(|s| (s.state.surfaces.pin().deepest().0 / UM).into()),
            q::TE_LOADED.of(|s| s.accuracy.loaded_error.arcmin().into()),
            q::PRELOAD.of(|s| s.travel.preload.into()),
            q::PRELOAD_FRICTION.of(|s| s.travel.preload_friction.into()),
        ]
    },
};

pub(crate) fn tables() -> Vec<DeclaredTable> {
    vec![WEAR.into(), HISTORY.into(), errors_table::TABLE.into()]
}

/// `wear.csv` and `wear_history.csv`.
pub(super) fn fill(wear: &Wear) -> Vec<Table> {
    let mut rows = Vec::new();
    for station in &wear.stations {
        let Some((solution, _)) = &station.handbook else {
            rows.extend(places(&wear.profile, &station.state, &station.accuracy));
            continue;
        };
        let profile = &wear.profile;
        rows.extend(solution.pairs.iter().map(|pair| Place {
            hours: station.hours(),
            meshing_angle: pair.meshing_angle,
            depth: station.accuracy.max_depth,
            force: pair.force,
            sliding: profile.specific_sliding(pair.meshing_angle.cos()),
            disc: None,
        }));
    }
    let mut tables = vec![WEAR.fill(&rows), HISTORY.fill(&wear.stations)];
    tables.extend(errors_table::table(&wear.fidelity));
    tables
}

/// The flanks of a machine at one time; of each disc where they differ.
pub(crate) fn places(profile: &Profile, state: &WornState, accuracy: &Accuracy) -> Vec<Place> {
    let flanks = &state.surfaces.flanks;
    let mut places = Vec::new();
    for (disc, flank) in flanks.iter().enumerate() {
        // If all discs carry the same load, there is one list of forces for all.
        let forces = accuracy.flank_forces.get(disc).or(accuracy.flank_forces.first());
        let of_disc = (flanks.len() > 1).then_some(disc);
        // Beyond the end of a flank with a tip there is no flank.
        let on_flank = Relief::grid(flank.samples().len()).zip(flank.samples());
        let on_flank = on_flank.filter(|(phi, _)| profile.is_usable(phi.cos()));
        places.extend(on_flank.map(|(phi, depth)| Place {
            hours: accuracy.hours,
            meshing_angle: phi,
            depth: *depth,
            force: forces.map_or(0.0, |forces| force_at(forces, phi)),
            sliding: profile.specific_sliding(phi.cos()),
            disc: of_disc,
        }));
    }
    places
}

/// By straight lines between the contacts, which are sorted by meshing angle.
fn force_at(forces: &[FlankForce], phi: f64) -> f64 {
    let at = forces.partition_point(|force| force.meshing_angle < phi);
    match (forces.get(at.wrapping_sub(1)), forces.get(at)) {
        (Some(a), Some(b)) => {
            a.force
                + (b.force - a.force) * (phi - a.meshing_angle)
                    / (b.meshing_angle - a.meshing_angle).max(1e-12)
        }
        (Some(only), None) | (None, Some(only)) => only.force,
        (None, None) => 0.0,
    }
}

pub(crate) const SUMMARY: SummaryOf<Wear> = SummaryOf {
    entries: || {
        let mut entries = entries();
        entries.extend(Fidelity::entries());
        entries
    },
};

/// Entries of the summary for an outcome of any family.
pub(in crate::analyses) fn entries<O: Deref<Target = WearOverHours>>() -> Vec<Column<O>> {
    vec![
        quantity("mode", PLAIN, "How wear and load are coupled: coupled or tao2024.").of(|o: &O| {
            match o.mode {
                Mode::Coupled => "coupled".into(),
                Mode::Tao2024 => "tao2024".into(),
            }
        }),
        q::HOURS.of(|o| o.last().hours().into()),
        q::MAX_DEPTH.of(|o| (o.last().accuracy.max_depth / UM).into()),
        q::MAX_DEPTH_AT.of(|o| o.last().worst_angle().map(|at| at / DEG).into()),
        q::MAX_PIN_DEPTH.of(|o| (o.last().state.surfaces.pin().deepest().0 / UM).into()),
        q::PLAY.of(|o| o.last().travel.play.arcmin().into()),
        q::PRELOAD.of(|o| o.last().travel.preload.into()),
        q::PRELOAD_FRICTION.of(|o| o.last().travel.preload_friction.into()),
        q::MAX_FORCE.of(|o| o.last().max_force().into()),
        q::LOADED_PAIRS.of(|o| o.last().loaded_pairs().into()),
        q::TE_LOADED.of(|o| o.last().accuracy.loaded_error.arcmin().into()),
        q::WEAR_COEFFICIENT.of(|o| o.exposure.coefficient.into()),
        q::FLANK_UPDATES.of(|o| o.updates.into()),
        quantity(
            "runs_away_h",
            decimals(3),
            "Hours at which wear runs away: the depth of a flank or pin is a quarter of the pin radius, or the play \
                 by the flanks alone is 20 times the limit of lost motion (at least 20′).",
        )
        .of(|o| o.runs_away.map(|end| end.hours).into()),
        quantity("depth_increment_um", decimals(3), "Largest depth between two updates of the flank.")
            .of(|o| (o.increment / UM).into()),
        quantity("hours_to_50_um", decimals(0), "Hours until 50 µm of uniform depth.")
            .of(|o| o.hours_to_50_um.into()),
    ]
}
