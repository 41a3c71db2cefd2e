//! Tables and figures of a calibration.

use std::ops::Deref;

use super::{Calibrated, Calibration, CurvePoint, MachineLife, NewIs, ReadingError, Remaining, Row};
use crate::fidelity::Fidelity;
use crate::results::{
    Column as ResultColumn, DeclaredTable, PLAIN, Quantity, SummaryOf, Table, TableOf, Value, decimals,
    digits, quantities as q, quantity,
};
use crate::units::{ARCMIN, HOUR, UM};
use crate::wear::{CONFIDENCE, Estimate, Parameter};

const MACHINE: Quantity = quantity(
    "machine",
    PLAIN,
    "Name of the machine in the file of readings; empty if the file has no column for it.",
);
const LIMIT_LOW: Quantity =
    quantity("hours_to_lost_motion_limit_low", decimals(0), "Lower end of the 95 % band of these hours.");
const LIMIT_HIGH: Quantity = quantity(
    "hours_to_lost_motion_limit_high",
    decimals(0),
    "Upper end of the 95 % band of these hours; empty if unbounded.",
);

const REMAINING: Quantity =
    quantity("remaining_h", decimals(0), "Hours from the last reading to the limit; 0 if it is exceeded.");
const REMAINING_LOW: Quantity = quantity("remaining_low_h", decimals(0), "Lower end of the 95 % band.");
const REMAINING_HIGH: Quantity =
    quantity("remaining_high_h", decimals(0), "Upper end of the 95 % band; empty where there is none.");

pub(super) const CALIBRATION: TableOf<Row> = TableOf {
    name: "calibration",
    what: "One row per reading, those of the fit first",
    columns: || {
        vec![
            MACHINE
                .of(|r: &Row| r.observed.machine.clone().into()),
            q::HOURS.of(|r| (r.observed.reading.time / HOUR).into()),
            q::QUANTITY.of(|r| r.observed.column().0.into()),
            quantity("observed", digits(5), "Value read, in the unit of the quantity.").of(|r| {
                (r.observed.reading.value / r.observed.column().1).into()
            }),
            quantity("predicted", digits(5), "Predicted value, in the unit of the quantity; empty beyond the \
                 computed growth.")
                .of(|r| r.predicted.map(|value| value / r.observed.column().1).into()),
            quantity("predicted_low", digits(5), "Lower end of the 95 % band of the prediction.")
                .of(|r| r.band.map(|(low, _)| low / r.observed.column().1).into()),
            quantity("predicted_high", digits(5), "Upper end of the 95 % band of the prediction.")
                .of(|r| r.band.map(|(_, high)| high / r.observed.column().1).into()),
            quantity(
                "residual_percent",
                decimals(2),
                "Prediction less reading, in percent of the reading; for readings of lost motion in percent of the \
                     largest growth of their machine.",
            )
            .of(|r| r.residual().map(|residual| 100.0 * residual).into()),
            quantity("use", PLAIN, "fitted, or predicted without a part in the fit.")
                .of(|r| if r.fitted { "fitted" } else { "predicted" }.into()),
        ]
    },
};

const CURVE: TableOf<CurvePoint> = TableOf {
    name: "calibration_curve",
    what: "One row per time: fitted prediction with its 95 % band",
    columns: || {
        vec![
            q::HOURS.of(|p: &CurvePoint| p.hours.into()),
            q::MAX_DEPTH.of(|p| (p.depth.0 / UM).into()),
            quantity("max_depth_low_um", decimals(3), "Lower end of its 95 % band.")
                .of(|p| p.depth.1.map(|(low, _)| low / UM).into()),
            quantity("max_depth_high_um", decimals(3), "Upper end of its 95 % band.")
                .of(|p| p.depth.1.map(|(_, high)| high / UM).into()),
            quantity("lost_motion_increase_arcmin", decimals(4), "Increase of the lost motion since new.")
                .of(|p| (p.increase.0 / ARCMIN).into()),
            quantity("lost_motion_increase_low_arcmin", decimals(4), "Lower end of its band.")
                .of(|p| p.increase.1.map(|(low, _)| low / ARCMIN).into()),
            quantity("lost_motion_increase_high_arcmin", decimals(4), "Upper end of its band.")
                .of(|p| p.increase.1.map(|(_, high)| high / ARCMIN).into()),
        ]
    },
};

pub(super) const LIVES: TableOf<MachineLife> = TableOf {
    name: "remaining_life",
    what: "One row per machine: hours to the limit of lost motion; the prediction of the design is first",
    columns: || {
        vec![
            MACHINE.of(|m: &MachineLife| m.name.clone().unwrap_or_default().into()),
            quantity(
                "new_lost_motion_arcmin",
                decimals(3),
                "Lost motion when new: fitted to the readings, given, or computed from the design.",
            )
            .of(|m| (m.new / ARCMIN).into()),
            quantity("last_reading_h", decimals(0), "Hours of its last reading.").of(|m| m.last_h.into()),
            q::HOURS_TO_LOST_MOTION_LIMIT.of(|m| m.hours.into()),
            LIMIT_LOW.of(|m| m.low.into()),
            LIMIT_HIGH.of(|m| m.high.into()),
            REMAINING.of(|m| m.hours.map(|hours| m.left(hours)).into()),
            REMAINING_LOW.of(|m| m.low.map(|hours| m.left(hours)).into()),
            REMAINING_HIGH.of(|m| m.high.map(|hours| m.left(hours)).into()),
        ]
    },
};

pub(super) const LIMITS: TableOf<Remaining> = TableOf {
    name: "remaining_limits",
    what: "One row per machine and limit: hours from its last reading to the limit",
    columns: || {
        vec![
            MACHINE.of(|r: &Remaining| r.machine.clone().unwrap_or_default().into()),
            q::LIMIT.of(|r| r.kind.key().into()),
            quantity("where", PLAIN, "Which part, where there are several.").of(|r| r.place.clone().into()),
            quantity(
                "allowed",
                digits(4),
                "Allowed value, in the given unit; for a rating life the planned hours.",
            )
            .of(|r| r.allowed.into()),
            q::UNIT.of(|r| r.kind.unit().into()),
            quantity("now_h", decimals(0), "Hours of the last reading.").of(|r| r.now_h.into()),
            quantity(
                "reached_h",
                decimals(0),
                "Hours since new at which the limit is reached; for a rating life the hours that nine of ten \
                     bearings reach that run at the last reading. Empty beyond the computed hours.",
            )
            .of(|r| r.hours().into()),
            REMAINING.of(|r| r.left().into()),
            REMAINING_LOW.of(|r| r.band().0.into()),
            REMAINING_HIGH.of(|r| r.band().1.into()),
            quantity("rated_h", decimals(0), "Rating life L10 of a new part, where the limit is one.")
                .of(|r| r.rated().into()),
            quantity("survival_percent", decimals(1), "Share of such parts that run up to the last reading.")
                .of(|r| r.survived_share().map(|share| 100.0 * share).into()),
        ]
    },
};

impl MachineLife {
    /// Hours from the last reading on.
    pub fn left(&self, hours: f64) -> f64 {
        (hours - self.last_h).max(0.0)
    }
}

fn estimate(o: &Calibration, parameter: Parameter) -> Option<&Estimate> {
    o.fit.estimates.iter().find(|estimate| estimate.parameter == parameter)
}

pub(crate) const SUMMARY: SummaryOf<Calibrated> = SummaryOf {
    entries: || {
        let mut entries = entries::<Calibrated>();
        entries.extend(Fidelity::entries());
        entries
    },
};

/// Entries of the summary for a drive of any family.
pub(in crate::analyses) fn entries<O: Deref<Target = Calibration> + 'static>() -> Vec<ResultColumn<O>> {
    vec![
            q::LIMIT.of(|o: &O| o.headline_limit().kind.key().into()),
            quantity(
                "remaining_hours",
                decimals(0),
                "Hours from the last reading to the selected limit, or to the first limit reached; 0 if it is \
                     exceeded; for a rating life the hours that nine of ten bearings reach that run now. Absent if the limit is not reached within the computed hours.",
            )
            .of(|o| o.headline_limit().left().into()),
            quantity(
                "remaining_hours_band",
                PLAIN,
                "Ends of its 95 % band, null where there is none.",
            )
            .of(|o| {
                let (low, high) = o.headline_limit().band();
                match (low, high) {
                    (None, None) => Value::Absent,
                    ends => Value::List(vec![ends.0.into(), ends.1.into()]),
                }
            }),
            quantity("limits", PLAIN, "Every limit, with the columns of remaining_limits.csv.")
                .of(|o| records(&LIMITS, &o.limits)),
            q::WEAR_COEFFICIENT.of(|o| o.fit.law.coefficient.into()),
            quantity("wear_coefficient_mm2_per_n", digits(4), "Wear coefficient in mm²/N.")
                .of(|o| (o.fit.law.coefficient * 1e6).into()),
            quantity(
                "wear_coefficient_low_per_pa",
                digits(4),
                "Lower end of its 95 % band; absent if the readings do not bound it.",
            )
            .of(|o| estimate(o, Parameter::Coefficient).and_then(|e| e.low).into()),
            quantity(
                "wear_coefficient_high_per_pa",
                digits(4),
                "Upper end of its 95 % band; absent if the readings do not bound it.",
            )
            .of(|o| estimate(o, Parameter::Coefficient).and_then(|e| e.high).into()),
            quantity("confidence", PLAIN, "Of all bands.").of(|_| CONFIDENCE.into()),
            quantity("running_in_factor", digits(4), "Factor of a running-in that was fitted.")
                .of(|o| estimate(o, Parameter::Factor).map(|e| e.value).into()),
            quantity("running_in_factor_low", digits(4), "Lower end of its 95 % band.")
                .of(|o| estimate(o, Parameter::Factor).and_then(|e| e.low).into()),
            quantity("running_in_factor_high", digits(4), "Upper end of its 95 % band.")
                .of(|o| estimate(o, Parameter::Factor).and_then(|e| e.high).into()),
            quantity("running_in_duration_h", digits(4), "Time constant of a running-in that was fitted.")
                .of(|o| {
                    let fitted = o.fit.law.running_in.filter(|_| o.fits_running_in());
                    fitted.map(|running_in| running_in.duration / HOUR).into()
                }),
            quantity(
                "running_in_duration_low_h",
                digits(4),
                "Lower end of its 95 % band, where it was fitted.",
            )
            .of(|o| estimate(o, Parameter::Duration).and_then(|e| e.low).map(|s| s / HOUR).into()),
            quantity(
                "running_in_duration_high_h",
                digits(4),
                "Upper end of its 95 % band, where it was fitted.",
            )
            .of(|o| estimate(o, Parameter::Duration).and_then(|e| e.high).map(|s| s / HOUR).into()),
            quantity("reading_error", digits(3), "Error of a reading relative to its scale, given or assumed; \
                 absent if it follows from the scatter.")
                .of(|o| match o.reading_error {
                    ReadingError::Given(error) | ReadingError::Assumed(error) => error.into(),
                    ReadingError::Scatter => Value::Absent,
                }),
            quantity("reading_error_assumed", PLAIN, "Whether it is assumed.")
                .of(|o| matches!(o.reading_error, ReadingError::Assumed(_)).into()),
            quantity("new_assumed", PLAIN, "Whether the lost motion of a machine when new is that of the design \
                 instead of a reading.")
                .of(|o| o.lives.iter().skip(1).any(|life| life.new_is == NewIs::Assumed).into()),
            quantity("fitted", PLAIN, "Readings that took part in the fit.")
                .of(|o| o.rows.iter().filter(|row| row.fitted).count().into()),
            quantity(
                "relative_rms",
                digits(3),
                "Root mean square of the residuals of the fit relative to their scale.",
            )
            .of(|o| o.fit.relative_rms.into()),
            quantity("correlations", PLAIN, "Correlation of every two fitted parameters.").of(|o| {
                let record = |(a, b, correlation): &(Parameter, Parameter, f64)| {
                    Value::Record(vec![
                        ("first", a.name().into()),
                        ("second", b.name().into()),
                        ("correlation", (*correlation).into()),
                    ])
                };
                Value::List(o.fit.correlations.iter().map(record).collect())
            }),
            quantity("cautions", PLAIN, "Parameters that the readings cannot determine, and readings that were not used.")
                .of(|o| Value::List(o.cautions().into_iter().map(Value::from).collect())),
            q::HOURS_TO_LOST_MOTION_LIMIT.of(|o| o.headline_machine().hours.into()),
            LIMIT_LOW.of(|o| o.headline_machine().low.into()),
            LIMIT_HIGH.of(|o| o.headline_machine().high.into()),
            quantity(
                "remaining_life_h",
                decimals(0),
                "Hours from the last reading to the limit of lost motion.",
            )
            .of(|o| o.headline_machine().hours.map(|hours| o.headline_machine().left(hours)).into()),
            quantity("remaining_life_low_h", decimals(0), "Lower end of its 95 % band.")
                .of(|o| o.headline_machine().low.map(|hours| o.headline_machine().left(hours)).into()),
            quantity(
                "remaining_life_high_h",
                decimals(0),
                "Upper end of its 95 % band; absent where there is none.",
            )
            .of(|o| o.headline_machine().high.map(|hours| o.headline_machine().left(hours)).into()),
            quantity("machines", PLAIN, "The rows of remaining_life.csv.").of(|o| records(&LIVES, &o.lives)),
            quantity("observations", PLAIN, "All readings, with the columns of calibration.csv.")
                .of(|o| records(&CALIBRATION, &o.rows)),
        ]
}

/// The rows of a table as records.
fn records<R>(table: &TableOf<R>, rows: &[R]) -> Value {
    let columns = (table.columns)();
    let record = |row: &R| Value::Record(columns.iter().map(|c| (c.quantity.key, c.value(row))).collect());
    Value::List(rows.iter().map(record).collect())
}

pub(crate) fn tables() -> Vec<DeclaredTable> {
    vec![CALIBRATION.into(), CURVE.into(), LIMITS.into(), LIVES.into()]
}

pub(in crate::analyses) fn fill(calibrated: &Calibration) -> Vec<Table> {
    vec![
        CALIBRATION.fill(&calibrated.rows),
        CURVE.fill(&calibrated.curve),
        LIMITS.fill(&calibrated.limits),
        LIVES.fill(&calibrated.lives),
    ]
}
