//! Tables and figures of the life of a machine.

use std::ops::Deref;

use super::ages::Age;
use super::band::Band;
use super::undecided::Undecided;
use super::verdict::LimitKind;
use super::{DriveLife, Life, bearings};
use crate::analyses::Host;
use crate::analyses::causes::{self, CausesAt, HasCauses};
use crate::analyses::{errors_table, wear};
use crate::dynamics::ErrorStatistics;
use crate::fidelity::Fidelity;
use crate::life::{Accuracy, LifePoint, PartsPoint, Travel};
use crate::load::CycleContact;
use crate::machine::OutputAngle;
use crate::results::{
    Column, DeclaredTable, PLAIN, Quantity, SummaryOf, Table, TableOf, Value, decimals, digits,
    quantities as q, quantity,
};
use crate::units::{ARCMIN, DEG, HOUR, MPA, UM};

/// One time of the prediction, in trade units, with the multibody runs if there are any.
#[derive(Debug, Clone)]
pub(in crate::analyses) struct Row {
    hours: f64,
    max_depth_um: f64,
    lost_motion_arcmin: f64,
    contact_lost_motion_arcmin: Option<f64>,
    te_loaded_arcmin: f64,
    /// STE and DTE.
    te: [Option<ErrorStatistics>; 2],
    max_force_n: f64,
    max_pressure_mpa: f64,
    loaded_pairs: f64,
    peak_to_peak_arcmin: f64,
    max_depth_at_deg: Option<f64>,
    max_pin_depth_um: f64,
    travel: Option<Travel>,
}

/// Results that need the load-free travel, as figures and as columns of `life`.
const OF_TRAVEL: &[&str] =
    &["play_arcmin", "te_no_load_arcmin", "free_travel_arcmin", "preload_n", "preload_friction_n_m"];
/// Those that need the multibody runs.
const OF_RUNS: &[&str] = &["ste_mean_arcmin", "ste_max_arcmin", "dte_mean_arcmin", "dte_max_arcmin"];
/// Those that need the search for the limit beyond the service life.
const OF_SEARCH: &[&str] =
    &["hours_to_limit", "hours_to_lost_motion_limit", "searched_h", "verdict", "advice"];

/// Whether one of these is needed, in the summary or as a column of `life`.
fn any_needed(host: &dyn Host, results: &[&str]) -> bool {
    results.iter().any(|result| host.needs(result) || host.needs(&format!("life.{result}")))
        || host.needs("report")
}

pub(super) fn needs_travel(host: &dyn Host) -> bool {
    any_needed(host, OF_TRAVEL)
}

pub(super) fn needs_runs(host: &dyn Host) -> bool {
    any_needed(host, OF_RUNS)
}

pub(super) fn needs_search(host: &dyn Host) -> bool {
    any_needed(host, OF_SEARCH)
}

impl Row {
    pub fn new(point: &LifePoint, age: Option<&Age>) -> Row {
        let accuracy = &point.accuracy;
        Row {
            hours: point.hours(),
            max_depth_um: accuracy.max_depth / UM,
            lost_motion_arcmin: point.lost_motion.arcmin(),
            contact_lost_motion_arcmin: point.contact_lost_motion.map(OutputAngle::arcmin),
            te_loaded_arcmin: accuracy.loaded_error.arcmin(),
            te: age.map_or([None, None], Age::statistics),
            max_force_n: accuracy.max_force,
            max_pressure_mpa: accuracy.max_pressure / MPA,
            loaded_pairs: accuracy.loaded_pairs,
            peak_to_peak_arcmin: accuracy.loaded_peak_to_peak.arcmin(),
            max_depth_at_deg: accuracy.max_depth_at.map(|at| at.abs() / DEG),
            max_pin_depth_um: point.state.surfaces.pin().deepest().0 / UM,
            travel: point.travel,
        }
    }

    fn travel(&self, of: fn(&Travel) -> f64) -> Value {
        Value::from(self.travel.as_ref().map(of))
    }

    fn te(&self, loaded: bool, of: fn(&ErrorStatistics) -> f64) -> Value {
        Value::from(self.te[usize::from(loaded)].map(|statistics| of(&statistics) / ARCMIN))
    }
}

const STE_MEAN: Quantity = quantity(
    "ste_mean_arcmin",
    decimals(3),
    "Mean of |TE| of the multibody run without load, in the same fidelity. Without drag the output rattles within \
         its play, and this mean depends on the start; only the range is reproducible.",
);
const STE_MAX: Quantity =
    quantity("ste_max_arcmin", decimals(3), "Largest |TE| of the multibody run without load.");
const DTE_MEAN: Quantity = quantity(
    "dte_mean_arcmin",
    decimals(3),
    "Mean of |TE| of the multibody run under a sinusoidal load of the rated torque, period 0.3 s.",
);
const DTE_MAX: Quantity =
    quantity("dte_max_arcmin", decimals(3), "Largest |TE| of the multibody run under the sinusoidal load.");

pub(in crate::analyses) const LIFE: TableOf<Row> = TableOf {
    name: "life",
    what: "One row per time of the life; STE and DTE at five of these times",
    columns: || {
        vec![
            q::HOURS.of(|r: &Row| r.hours.into()),
            q::MAX_DEPTH.of(|r| r.max_depth_um.into()),
            q::PLAY.of(|r| r.travel(|t| t.play.arcmin())),
            q::LOST_MOTION.of(|r| r.lost_motion_arcmin.into()),
            q::CONTACT_LOST_MOTION.of(|r| r.contact_lost_motion_arcmin.into()),
            q::TE_NO_LOAD.of(|r| r.travel(|t| t.no_load_error.arcmin())),
            q::TE_LOADED.of(|r| r.te_loaded_arcmin.into()),
            STE_MEAN.of(|r| r.te(false, |s| s.mean_abs)),
            STE_MAX.of(|r| r.te(false, |s| s.max_abs)),
            DTE_MEAN.of(|r| r.te(true, |s| s.mean_abs)),
            DTE_MAX.of(|r| r.te(true, |s| s.max_abs)),
            q::MAX_FORCE.of(|r| r.max_force_n.into()),
            q::MAX_PRESSURE.of(|r| r.max_pressure_mpa.into()),
            q::LOADED_PAIRS.of(|r| r.loaded_pairs.into()),
            q::FREE_TRAVEL.of(|r| r.travel(|t| t.free_travel.arcmin())),
            q::TE_LOADED_PEAK_TO_PEAK.of(|r| r.peak_to_peak_arcmin.into()),
            q::MAX_DEPTH_AT.of(|r| r.max_depth_at_deg.into()),
            q::MAX_PIN_DEPTH.of(|r| r.max_pin_depth_um.into()),
            q::PRELOAD.of(|r| r.travel(|t| t.preload)),
            q::PRELOAD_FRICTION.of(|r| r.travel(|t| t.preload_friction)),
        ]
    },
};

pub(crate) fn tables() -> Vec<DeclaredTable> {
    vec![
        LIFE.into(),
        wear::WEAR_TABLE.into(),
        causes::TABLE.into(),
        bearings::TABLE.into(),
        errors_table::TABLE.into(),
    ]
}

pub(super) fn fill(life: &Life) -> Vec<Table> {
    let points = life.prediction.points.iter();
    let places: Vec<_> =
        points.flat_map(|point| wear::places(&life.profile, &point.state, &point.accuracy)).collect();
    let mut tables = vec![
        life_table(life, &life.ages),
        wear::WEAR_TABLE.fill(&places),
        causes::TABLE.fill(&life.causes_over_hours()),
        bearings::TABLE.fill(&life.bearings.bearings),
    ];
    tables.extend(errors_table::table(&life.fidelity));
    tables
}

/// `life.csv`.
pub(super) fn life_table(life: &DriveLife, ages: &[Age]) -> Table {
    let points = life.prediction.points.iter().enumerate();
    let row = |(index, point)| Row::new(point, ages.iter().find(|age| age.point == index));
    LIFE.fill(&points.map(row).collect::<Vec<Row>>())
}

pub(crate) const SUMMARY: SummaryOf<Life> = SummaryOf {
    entries: || {
        let mut entries = entries();
        entries.extend(vec![
            STE_MEAN.of(|o: &Life| o.last_te(false, |s| s.mean_abs)),
            STE_MAX.of(|o| o.last_te(false, |s| s.max_abs)),
            DTE_MEAN.of(|o| o.last_te(true, |s| s.mean_abs)),
            DTE_MAX.of(|o| o.last_te(true, |s| s.max_abs)),
            quantity(
                "bearing_life_without_friction_h",
                decimals(0),
                "Shortest L10 of the bearings without the assumed friction; absent if the design gives its friction.",
            )
            .of(|o| o.bearings.assumed_friction.map(|assumed| assumed.without_h).into()),
            quantity("advice", PLAIN, "Keys to change first, with the gain for the limit reached first.")
                .of(|o| Value::list(o.advice.iter().map(|advice| advice.text.clone()))),
            quantity("advice_keys", PLAIN, "Keys of the design that `advice` changes, in its order.")
                .of(|o| Value::list(o.advice.iter().map(|advice| advice.key.to_owned()))),
        ]);
        entries.extend(causes::entries());
        entries.extend(Fidelity::entries());
        entries
    },
};

/// Entries of the summary for an outcome of any family.
pub(in crate::analyses) fn entries<O: Deref<Target = DriveLife>>() -> Vec<Column<O>> {
    let mut entries = vec![
            q::RATIO.of(|o: &O| o.ratio.into()),
            quantity(
                "verdict.ok",
                PLAIN,
                "Whether every limit is kept for the planned service life; false if a limit is undecided. A study \
                     judges in one fidelity unless it keeps verdict.undecided.",
            )
            .of(|o| o.verdict.ok().into()),
            quantity("verdict.word", PLAIN, "The verdict in a word: kept, not kept, or undecided.")
                .of(|o| o.verdict.word().into()),
            quantity("verdict.limited_by", PLAIN, "The limit that ends the life first.")
                .of(|o| Value::from(o.verdict.limited_by().map(|limit| limit.kind.key()))),
            quantity(
                "verdict.limits",
                PLAIN,
                "Every limit with: its name; the part; computed and allowed value in its unit; scatter of single \
                     values about the computed one; the hours for which it is kept (null: beyond the computed hours); the band [low, high] of these hours for nine of ten machines within [unknowns] (null: beyond the computed hours) and the input with the largest influence; whether it is exceeded only during running-in (transient), and the hours of running-in.",
            )
            .of(|o| o.verdict.value()),
            quantity(
                "verdict.undecided",
                PLAIN,
                "Limits that are kept with only one of rigid and elastic bodies: name, \
                     value and hours with each, and reason. Empty if the options name the bodies.",
            )
            .of(|o| Value::List(o.verdict.undecided.iter().map(Undecided::value).collect())),
            quantity("hours_to_limit", decimals(0), "Hours until the first of all limits is reached.")
                .of(|o| o.verdict.hours_to_limit().into()),
            quantity(
                "hours_band",
                PLAIN,
                "Band [low, high] of hours_to_limit in h for nine of ten machines within [unknowns], by first-order \
                     sensitivities; null beyond the computed hours.",
            )
            .of(|o| o.verdict.band.as_ref().map_or(Value::Absent, Band::value)),
            quantity("hangs_on", PLAIN, "Key of the input with the largest influence on hours_to_limit, to be \
                 measured first.")
                .of(|o| o.verdict.band.as_ref().and_then(|band| band.hangs_on.clone()).into()),
            quantity("rest_share", digits(3), "Share of the duty at rest, included in the hours.")
                .of(|o| o.demands.rest_share().into()),
            q::HOURS_TO_LOST_MOTION_LIMIT.of(|o| o.prediction.hours_to_limit.into()),
            quantity("searched_h", decimals(0), "Hours up to which the limit of lost motion was searched.")
                .of(|o| o.prediction.searched_hours.into()),
            quantity("service_life_h", decimals(0), "Planned service life.")
                .of(|o| (o.demands.limits.service_life / HOUR).into()),
            q::LOST_MOTION.of(|o| o.last().lost_motion.arcmin().into()),
            quantity("lost_motion_new_arcmin", decimals(3), "Lost motion of the whole machine when new.")
                .of(|o| o.first().lost_motion.arcmin().into()),
            quantity("limit_lost_motion_arcmin", decimals(3), "Lost motion that the design allows.")
                .of(|o| (o.demands.limits.lost_motion / ARCMIN).into()),
            q::CONTACT_LOST_MOTION.of(|o| o.last().contact_lost_motion.map(OutputAngle::arcmin).into()),
            q::MAX_DEPTH.of(|o| (o.last().accuracy.max_depth / UM).into()),
            q::MAX_DEPTH_AT.of(|o| o.last().accuracy.max_depth_at.map(|at| at.abs() / DEG).into()),
            q::MAX_PIN_DEPTH.of(|o| (o.last().state.surfaces.pin().deepest().0 / UM).into()),
            q::PLAY.of(|o| o.last().travel.map(|t| t.play.arcmin()).into()),
            q::TE_NO_LOAD.of(|o| o.last().travel.map(|t| t.no_load_error.arcmin()).into()),
            q::TE_LOADED.of(|o| o.last().accuracy.loaded_error.arcmin().into()),
            q::TE_LOADED_PEAK_TO_PEAK.of(|o| o.last().accuracy.loaded_peak_to_peak.arcmin().into()),
            q::PRELOAD.of(|o| o.travel_over_life(|t| t.preload).into()),
            q::PRELOAD_FRICTION.of(|o| o.travel_over_life(|t| t.preload_friction).into()),
            q::MAX_FORCE.of(|o| o.over_life(|point| point.accuracy.max_force).into()),
            q::MAX_PRESSURE.of(|o| (o.over_life(|point| point.accuracy.max_pressure) / MPA).into()),
            q::LOADED_PAIRS.of(|o| o.last().accuracy.loaded_pairs.into()),
            quantity("max_force_at_deg", decimals(1), "Size |φ| of the meshing angle of the largest force.")
                .of(|o| o.at_largest(|a| a.largest_force_at, |s| s.force, |s| s.meshing_angle.abs() / DEG)),
            quantity("pressure_at_max_force_mpa", decimals(0), "Pressure where the force is largest.")
                .of(|o| o.at_largest(|a| a.largest_force_at, |s| s.force, |s| s.pressure / MPA)),
            quantity("max_pressure_at_deg", decimals(1), "Size |φ| of the meshing angle of the largest pressure.")
                .of(|o| o.at_largest(|a| a.largest_pressure_at, |s| s.pressure, |s| s.meshing_angle.abs() / DEG)),
            quantity("force_at_max_pressure_n", decimals(0), "Force where the pressure is largest.")
                .of(|o| o.at_largest(|a| a.largest_pressure_at, |s| s.pressure, |s| s.force)),
            quantity(
                "system_l10_h",
                decimals(0),
                "L10 of all bearings together (Weibull slope 9/8): hours that nine of ten machines run without \
                     failure of a bearing.",
            )
            .of(|o| (!o.bearings.bearings.is_empty()).then_some(o.bearings.system_h).into()),
            quantity(
                "bearing_survival",
                digits(3),
                "Share of machines without failure of a bearing at the end of the service life.",
            )
            .of(|o| {
                let service = o.verdict.service_h;
                (!o.bearings.bearings.is_empty()).then(|| o.bearings.survival(service)).into()
            }),
            q::WEAR_COEFFICIENT.of(|o| o.prediction.exposure.coefficient.into()),
            q::FLANK_UPDATES.of(|o| o.prediction.updates.into()),
            quantity("stages", PLAIN, "Wall seconds of the stages; some run side by side.").of(|o| {
                Value::Record(o.stages.iter().map(|(stage, seconds)| (*stage, (*seconds).into())).collect())
            }),
    ];
    entries.extend(hours_of_limits());
    entries
}

macro_rules! hours_of_limits {
    ($($kind:ident: $key:literal,)*) => {
        /// Keys of the hours for which each limit is kept that a machine may have.
        pub(crate) fn limit_hours() -> impl Iterator<Item = (LimitKind, &'static str)> {
            let lost_motion = (LimitKind::LostMotion, q::HOURS_TO_LOST_MOTION_LIMIT.key);
            [lost_motion, $((LimitKind::$kind, $key)),*].into_iter()
        }

        fn hours_of_limits<O: Deref<Target = DriveLife>>() -> Vec<Column<O>> {
            vec![$(quantity($key, decimals(0), HOURS_OF_LIMIT).of(|o: &O| {
                o.verdict.limit(LimitKind::$kind).and_then(|limit| limit.hours).into()
            })),*]
        }
    };
}

const HOURS_OF_LIMIT: &str = "Hours for which this limit is kept; absent beyond the computed hours or without such \
     a limit.";

hours_of_limits! {
    ContactPressure: "hours_to_contact_pressure_limit",
    BearingLife: "hours_to_bearing_life_limit",
    TransmissionError: "hours_to_transmission_error_limit",
    Backlash: "hours_to_backlash_limit",
    CatalogueLife: "hours_to_catalogue_life_limit",
    ContactFatigue: "hours_to_contact_fatigue_limit",
    EmergencyTorque: "hours_to_emergency_torque_limit",
    Wear: "hours_to_wear_limit",
}

impl Life {
    pub(super) fn causes_over_hours(&self) -> Vec<CausesAt> {
        let at = |point: &LifePoint| Some(CausesAt { hours: point.hours(), point: point.causes? });
        self.prediction.points.iter().filter_map(at).collect()
    }

    fn last_te(&self, loaded: bool, of: fn(&ErrorStatistics) -> f64) -> Value {
        let statistics = self.ages.last().and_then(|age| age.statistics()[usize::from(loaded)]);
        Value::from(statistics.map(|statistics| of(&statistics) / ARCMIN))
    }
}

impl DriveLife {
    /// Largest value over the times; `None` without free travel.
    fn travel_over_life(&self, of: impl Fn(&Travel) -> f64) -> Option<f64> {
        self.prediction.points.iter().filter_map(|point| point.travel.as_ref().map(&of)).reduce(f64::max)
    }

    /// Another value at the place of the whole life where `size` is largest.
    fn at_largest(
        &self,
        place: fn(&Accuracy) -> CycleContact,
        size: fn(&CycleContact) -> f64,
        value: fn(&CycleContact) -> f64,
    ) -> Value {
        let places = self.prediction.points.iter().map(|point| place(&point.accuracy));
        let largest = places.max_by(|a, b| size(a).total_cmp(&size(b)));
        Value::from(largest.map(|spot| value(&spot)))
    }

    fn over_life(&self, of: impl Fn(&LifePoint) -> f64) -> f64 {
        self.prediction.points.iter().map(of).fold(0.0, f64::max)
    }
}

impl HasCauses for Life {
    fn causes(&self) -> Option<&PartsPoint> {
        self.last().causes.as_ref()
    }
}
