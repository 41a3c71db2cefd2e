//! Lost motion by cause in tables, summaries, terminal and reports of all analyses.

use std::sync::LazyLock;

use super::{TextBlock, TextTable};
use crate::dynamics::labels::CAUSES;
use crate::dynamics::{Cause, LostMotionSplit};
use crate::life::PartsPoint;
use crate::report::{Block, Section, Shares, Tone, in_decimals, lost_motion_causes};
use crate::results::{Column, Quantity, TableOf, Value, decimals, quantities as q, quantity};
use crate::units::{ARCMIN, UM};

/// The causes at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CausesAt {
    /// Running hours since new.
    pub hours: f64,
    /// Lost motion by cause and compliance by part.
    pub point: PartsPoint,
}

/// Outcomes with the causes in their summary.
pub(crate) trait HasCauses {
    fn causes(&self) -> Option<&PartsPoint>;
}

/// The part of one cause, as a column and as an entry of a summary.
struct Declared {
    column: Quantity,
    entry: Quantity,
}

static DECLARED: LazyLock<Vec<Declared>> = LazyLock::new(|| {
    let declared = |cause: &Cause| {
        let what = format!("Part of the lost motion of the whole machine: {}.", cause.name()).leak();
        let column = quantity(format!("{}_arcmin", cause.key()).leak(), decimals(4), what);
        let key = format!("lost_motion_causes.{}_arcmin", cause.key()).leak();
        Declared { column, entry: column.named(key) }
    };
    CAUSES.iter().map(declared).collect()
});

const RESIDUAL: Quantity = quantity(
    "residual_arcmin",
    decimals(4),
    "Unexplained remainder: lost motion less the sum of its causes.",
);

/// `lost_motion_causes.csv`.
pub(crate) const TABLE: TableOf<CausesAt> = TableOf {
    name: "lost_motion_causes",
    what: "One row per time: lost motion of the whole machine by cause",
    columns: || {
        let mut columns = vec![
            q::HOURS.of(|at: &CausesAt| at.hours.into()),
            q::LOST_MOTION.of(|at| (at.point.lost_motion.whole / ARCMIN).into()),
        ];
        columns.extend(DECLARED.iter().enumerate().map(|(index, declared)| {
            Column::numbered(declared.column, index, |at: &CausesAt, index| {
                (at.point.lost_motion.causes[index] / ARCMIN).into()
            })
        }));
        columns.extend([
            RESIDUAL.of(|at: &CausesAt| (at.point.lost_motion.residual() / ARCMIN).into()),
            quantity(
                "turning_arm_clearance_growth_um",
                decimals(3),
                "Growth of the diametral clearance of the turning-arm bearings by wear.",
            )
            .of(|at| (at.point.wear.turning_arm / UM).into()),
            quantity(
                "crank_support_clearance_growth_um",
                decimals(3),
                "Growth of the diametral clearance of the crank supports by wear.",
            )
            .of(|at| (at.point.wear.crank_support / UM).into()),
            quantity("gear_gap_growth_um", decimals(3), "Growth of the backlash of one gear mesh by wear.")
                .of(|at| ((at.point.wear.gears[0] + at.point.wear.gears[1]) / UM).into()),
        ]);
        columns
    },
};

/// Entries of a summary, below `lost_motion_causes`.
pub(crate) fn entries<O: HasCauses>() -> Vec<Column<O>> {
    let mut entries = vec![
        q::LOST_MOTION
            .named("lost_motion_causes.whole_arcmin")
            .of(|outcome: &O| Value::from(outcome.causes().map(|point| point.lost_motion.whole / ARCMIN))),
    ];
    entries.extend(DECLARED.iter().enumerate().map(|(index, declared)| {
        Column::numbered(declared.entry, index, |outcome: &O, index| {
            Value::from(outcome.causes().map(|point| point.lost_motion.causes[index] / ARCMIN))
        })
    }));
    entries.push(
        RESIDUAL.named("lost_motion_causes.residual_arcmin").of(|outcome: &O| {
            Value::from(outcome.causes().map(|point| point.lost_motion.residual() / ARCMIN))
        }),
    );
    entries
}

/// Share of manufacturing errors in the lost motion, in rad, above which they are assumed to preload parts.
const PRESSED: f64 = 0.02 * ARCMIN;

/// Causes for texts and figures, in arcmin, one value per state; values below `negligible` are omitted. If
/// manufacturing errors press parts together without load, their contribution and the elastic one are many times the
/// sum and nearly cancel; both are then shown as one. Tables and summary list them separately.
fn shown(states: &[&LostMotionSplit], negligible: f64) -> Vec<(String, Vec<f64>)> {
    let pressed = states.iter().any(|split| split.of(Cause::MANUFACTURING_ERRORS) < -PRESSED);
    let of = |cause: Cause| -> Vec<f64> { states.iter().map(|split| split.of(cause) / ARCMIN).collect() };
    CAUSES
        .into_iter()
        .filter(|cause| !(pressed && *cause == Cause::MANUFACTURING_ERRORS))
        .map(|cause| {
            if pressed && cause == Cause::ELASTIC {
                let errors = of(Cause::MANUFACTURING_ERRORS);
                let both = of(cause).into_iter().zip(errors).map(|(elastic, errors)| elastic + errors);
                (format!("{}, and manufacturing errors", cause.name()), both.collect())
            } else {
                (cause.name().to_owned(), of(cause))
            }
        })
        .filter(|(_, values)| values.iter().any(|value| value.abs() > negligible))
        .collect()
}

/// The largest causes of one state in arcmin, the largest first.
pub(crate) fn largest(point: &PartsPoint) -> Vec<(String, f64)> {
    let mut causes: Vec<(String, f64)> =
        shown(&[&point.lost_motion], 1e-3).into_iter().map(|(cause, values)| (cause, values[0])).collect();
    causes.sort_by(|a, b| b.1.total_cmp(&a.1));
    causes
}

/// Difference (arcmin) between the lost motion of the loops of the bench (rad) and the sum of the causes, due to
/// friction.
fn apart(at: &CausesAt, bench: Option<f64>) -> Option<f64> {
    bench.filter(|read| (read - at.point.lost_motion.whole).abs() > 5e-4 * ARCMIN).map(|read| read / ARCMIN)
}

/// For the terminal; `bench` is the lost motion (rad) read from loops with friction, where there are any.
pub(crate) fn text_blocks(at: &CausesAt, bench: Option<f64>) -> Vec<TextBlock> {
    let split = &at.point.lost_motion;
    let row = |cause: String, arcmin: f64| vec![format!("  {cause}"), format!("{}′", in_decimals(arcmin, 3))];
    let mut rows: Vec<Vec<String>> =
        shown(&[split], 5e-4).into_iter().map(|(cause, values)| row(cause, values[0])).collect();
    rows.push(row("not explained".to_owned(), split.residual() / ARCMIN));
    let state = if at.hours > 0.0 { format!("after {:.0} h", at.hours) } else { "new".to_owned() };
    let whole = split.whole / ARCMIN;
    let title = match apart(at, bench) {
        Some(read) => format!(
            "lost motion without friction, {state}: {whole:.3}′ (between the mid-points of the loop, with \
             friction: {read:.3}′)"
        ),
        None => format!("lost motion of the whole machine, {state}: {whole:.3}′"),
    };
    vec![TextBlock::line(title), TextBlock::Table(TextTable { header: Vec::new(), rows })]
}

const MEANING: &str = "without friction, input locked; mean over one full period (a turn of the \
                       crankshafts, with errors of the ring one of the output)";

/// For the report: the causes stacked over the hours.
pub(crate) fn section(rows: &[CausesAt]) -> Section {
    let states: Vec<&LostMotionSplit> = rows.iter().map(|at| &at.point.lost_motion).collect();
    let series: Vec<(String, Vec<(f64, f64)>)> = shown(&states, 1e-4)
        .into_iter()
        .map(|(cause, values)| (cause, rows.iter().map(|at| at.hours).zip(values).collect()))
        .collect();
    let residual = states.iter().map(|split| (split.residual() / ARCMIN).abs()).fold(0.0, f64::max);
    let note = format!(
        "The machine in its bearings, {MEANING}. The causes follow from virtual work with the forces at ±3 % of \
         rated torque and their sum differs from the whole by at most {residual:.4} arcmin, the tolerance of the equilibria."
    );
    let blocks = vec![lost_motion_causes(&series), Block::Note(Tone::Neutral, note)];
    Section::new("causes", "Lost motion by cause", blocks)
}

/// Contributions of the causes, for the report of one state. `bench` as in [`text_blocks`].
pub(crate) fn shares(at: &CausesAt, bench: Option<f64>) -> Block {
    let split = &at.point.lost_motion;
    let rows =
        shown(&[split], 1e-4).into_iter().map(|(cause, values)| (cause, values[0], String::new())).collect();
    let state = if at.hours > 0.0 { format!("After {:.0} h", at.hours) } else { "New".to_owned() };
    let with_friction = apart(at, bench).map_or(String::new(), |read| {
        format!(" With friction the mid-points of the loop are {read:.4} arcmin apart.")
    });
    let note = format!(
        "{state}, {MEANING}. Whole: {:.4} arcmin; remainder of the sum: {:.4} arcmin.{with_friction}",
        split.whole / ARCMIN,
        // Avoids −0 after rounding.
        (split.residual() / ARCMIN * 1e4).round() / 1e4 + 0.0
    );
    Block::Shares(Shares { title: "Contributions of the causes".into(), unit: "arcmin".into(), rows, note })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::PartWear;

    fn at(causes: impl Fn(Cause) -> f64, whole: f64) -> CausesAt {
        let causes = std::array::from_fn(|index| causes(CAUSES[index]) * ARCMIN);
        let lost_motion = LostMotionSplit { whole: whole * ARCMIN, causes };
        CausesAt { hours: 100.0, point: PartsPoint { wear: PartWear::default(), lost_motion } }
    }

    /// Every cause is a column; causes and residual add up to the whole in each row.
    #[test]
    fn columns_add_up_to_the_whole() {
        let row = at(|cause| 0.01 * cause.key().len() as f64, 1.0);
        let table = TABLE.fill([&row]);
        let cell = |key: &str| table.numbers(key).unwrap()[0];
        let sum: f64 = CAUSES.iter().map(|cause| cell(&format!("{}_arcmin", cause.key()))).sum();
        assert!((sum + cell("residual_arcmin") - cell("lost_motion_arcmin")).abs() < 1e-12);
    }

    /// Errors that press parts together are shown with the elastic work, in the table apart.
    #[test]
    fn pressing_errors_are_shown_with_elasticity() {
        let row = at(
            |cause| match cause {
                Cause::ELASTIC => 5.0,
                Cause::MANUFACTURING_ERRORS => -4.5,
                _ => 0.0,
            },
            0.5,
        );
        let causes = largest(&row.point);
        assert_eq!(causes.len(), 1);
        assert!((causes[0].1 - 0.5).abs() < 1e-12 && causes[0].0.contains("manufacturing errors"));
        assert_eq!(TABLE.fill([&row]).numbers("manufacturing_errors_arcmin").unwrap()[0].round(), -5.0);
    }

    /// Two values of lost motion never appear under one name: if the value of the bench contains friction, both
    /// are given with their definitions.
    #[test]
    fn lost_motion_with_friction_is_distinguished() {
        let row = at(|cause| if cause == Cause::ELASTIC { 0.57 } else { 0.0 }, 0.57);
        let title = |bench: Option<f64>| match text_blocks(&row, bench).remove(0) {
            TextBlock::Line(line) => line,
            other => panic!("{other:?}"),
        };
        let apart = title(Some(0.155 * ARCMIN));
        assert!(apart.contains("without friction") && apart.contains("with friction: 0.155′"), "{apart}");
        for bench in [None, Some(0.57 * ARCMIN)] {
            assert_eq!(title(bench), "lost motion of the whole machine, after 100 h: 0.570′");
        }
    }
}
