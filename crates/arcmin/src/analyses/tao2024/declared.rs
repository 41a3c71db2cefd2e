//! Table and figures of the paper's study.

use super::{Level, MeanAndMax, Tao2024};
use crate::analyses::Host;
use crate::fidelity::Fidelity;
use crate::results::{
    Column, DeclaredTable, PLAIN, SummaryOf, Table, TableOf, Value, decimals, quantities as q, quantity,
};
use crate::units::{MPA, UM};

type Of = (&'static str, &'static str, fn(&Level) -> Option<MeanAndMax>, fn(MeanAndMax) -> f64);

const ERRORS: [Of; 8] = [
    ("ste_rigid_mean_arcmin", "Mean of |TE| without load, rigid discs.", Level::ste_rigid, |te| te.mean),
    ("ste_rigid_max_arcmin", "Largest |TE| without load, rigid discs.", Level::ste_rigid, |te| te.max),
    (
        "dte_rigid_mean_arcmin",
        "Mean of |TE| under the sinusoidal load, rigid discs.",
        Level::dte_rigid,
        |te| te.mean,
    ),
    (
        "dte_rigid_max_arcmin",
        "Largest |TE| under the sinusoidal load, rigid discs.",
        Level::dte_rigid,
        |te| te.max,
    ),
    ("ste_flexible_mean_arcmin", "Mean of |TE| without load, elastic discs.", Level::ste_flexible, |te| {
        te.mean
    }),
    ("ste_flexible_max_arcmin", "Largest |TE| without load, elastic discs.", Level::ste_flexible, |te| {
        te.max
    }),
    (
        "dte_flexible_mean_arcmin",
        "Mean of |TE| under the sinusoidal load, elastic discs.",
        Level::dte_flexible,
        |te| te.mean,
    ),
    (
        "dte_flexible_max_arcmin",
        "Largest |TE| under the sinusoidal load, elastic discs.",
        Level::dte_flexible,
        |te| te.max,
    ),
];

const STUDY: TableOf<Level> = TableOf {
    name: "tao2024",
    what: "One row per uniform depth; hours by the paper's wear rule",
    columns: || {
        let mut columns = vec![
            q::HOURS.of(|l: &Level| l.hours.into()),
            q::MAX_DEPTH.of(|l| (l.depth / UM).into()),
            q::PLAY.of(|l| l.travel.play.arcmin().into()),
            q::TE_NO_LOAD.of(|l| l.travel.no_load_error.arcmin().into()),
            q::TE_LOADED.of(|l| l.accuracy.loaded_error.arcmin().into()),
        ];
        columns.extend(ERRORS.iter().enumerate().map(|(index, (key, what, _, _))| {
            Column::numbered(quantity(key, decimals(3), what), index, |level: &Level, index| {
                let (_, _, of, part) = ERRORS[index];
                Value::from(of(level).map(part))
            })
        }));
        columns.extend([
            q::MAX_FORCE.of(|l: &Level| l.accuracy.max_force.into()),
            q::MAX_PRESSURE.of(|l| (l.accuracy.max_pressure / MPA).into()),
            q::LOADED_PAIRS.of(|l| l.accuracy.loaded_pairs.into()),
            quantity("closed_form_force_n", decimals(1), "Largest force of the paper's closed form.")
                .of(|l| l.handbook.as_ref().map(|solution| solution.max_force).into()),
            quantity("closed_form_pairs", PLAIN, "Loaded pairs of the paper's closed form.")
                .of(|l| l.handbook.as_ref().map(|solution| solution.loaded_pairs()).into()),
        ]);
        columns
    },
};

/// Whether results of the multibody runs are needed.
pub(super) fn needs_runs(host: &dyn Host) -> bool {
    let of_runs = |key: &&str| key.starts_with("ste_") || key.starts_with("dte_");
    let columns: Vec<&str> = (STUDY.columns)().iter().map(|column| column.quantity.key).collect();
    let summary: Vec<&str> = SUMMARY.quantities().iter().map(|quantity| quantity.key).collect();
    columns.iter().filter(|key| of_runs(key)).any(|key| host.needs(&format!("{}.{key}", STUDY.name)))
        || summary.iter().filter(|key| of_runs(key)).any(|key| host.needs(key))
        || host.needs("report")
}

pub(crate) fn tables() -> Vec<DeclaredTable> {
    vec![STUDY.into()]
}

pub(super) fn fill(study: &Tao2024) -> Vec<Table> {
    vec![STUDY.fill(&study.levels)]
}

pub(crate) const SUMMARY: SummaryOf<Tao2024> = SummaryOf {
    entries: || {
        let mut entries = vec![
            q::RATIO.of(|o: &Tao2024| o.machine.kinematics().ratio().into()),
            q::HOURS.of(|o| o.last().and_then(|level| level.hours).into()),
            q::MAX_DEPTH.of(|o| o.last().map(Level::depth_um).into()),
            q::PLAY.of(|o| o.last().map(|level| level.travel.play.arcmin()).into()),
            q::TE_LOADED.of(|o| o.last().map(|level| level.accuracy.loaded_error.arcmin()).into()),
            q::WEAR_COEFFICIENT.of(|o| o.coefficient.into()),
            quantity("closed_form_settles", PLAIN, "Whether the paper's closed form finds its hours.")
                .of(|o| o.unsettled.is_none().into()),
        ];
        entries.extend(Fidelity::entries());
        entries
    },
};

impl Tao2024 {
    fn last(&self) -> Option<&Level> {
        self.levels.last()
    }
}
