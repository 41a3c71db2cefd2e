//! Accuracy, pressure and loaded pairs against hours, and the tables behind them.

use super::{LifePage, LifeRow, MeanAndMax};
use crate::report::{
    Annotation, Axis, Block, Colour, Column, Plot, Series, Style, Table, Tone, compact, significant,
};

pub(super) fn blocks(life: &LifePage) -> Vec<Block> {
    let mut blocks = vec![Block::Plot(angles(life))];
    if life.prediction.iter().any(|row| row.max_pressure_mpa > 0.0) {
        blocks.push(Block::Plot(pressure(life)));
        blocks.push(Block::Plot(pairs(life)));
    }
    blocks.push(Block::Table(table("Prediction (coupled wear)", life.prediction)));
    if !life.study.is_empty() {
        blocks.push(Block::Table(Table {
            note: "The paper's study: uniform depths, hours by its own wear rule. Signs: a lagging output is negative.".into(),
            ..table("The paper's study", life.study)
        }));
    }
    blocks
}

fn hours() -> Axis {
    Axis::new("Running time", "h")
}

fn over_hours<F: Fn(&LifeRow) -> Option<f64>>(rows: &[LifeRow], value: F) -> Vec<(f64, f64)> {
    rows.iter().map(|row| (row.hours, value(row).unwrap_or(f64::NAN))).collect()
}

fn angles(life: &LifePage) -> Plot {
    let mut plot = Plot::new(
        "Accuracy over running time",
        hours(),
        Axis::new("Angle at the output", "arcmin").from_zero(),
    );
    let rows = life.prediction;
    let machine = rows.iter().any(|row| row.machine_lost_motion_arcmin.is_some());
    if machine {
        let series = Series::line(
            "lost motion of the machine at ±3 % torque",
            over_hours(rows, |row| row.machine_lost_motion_arcmin),
        );
        plot.series.push(series.strong().coloured(Colour::Palette(0)));
    }
    if life.contacts_alone && rows.iter().any(|row| row.lost_motion_arcmin.is_some()) {
        let series =
            Series::line("lost motion of the contacts alone", over_hours(rows, |row| row.lost_motion_arcmin));
        plot.series.push(if machine {
            series.coloured(Colour::Palette(3))
        } else {
            series.strong().coloured(Colour::Palette(0))
        });
    }
    plot.series.push(
        Series::line("play, one-sided", over_hours(rows, |row| Some(row.play_arcmin)))
            .coloured(Colour::Palette(2)),
    );
    plot.series.push(
        Series::line(
            "transmission error at rated torque, size of its mean",
            over_hours(rows, |row| Some(row.te_loaded_arcmin.abs())),
        )
        .coloured(Colour::Palette(1)),
    );
    let limit = life.limit_arcmin();
    plot.limit_at(limit, format!("limit {} arcmin lost motion", compact(limit, 3)));
    // Far beyond the computed life it would only squeeze the curves.
    if let Some(at) = life.hours_to_limit.filter(|at| rows.last().is_some_and(|row| *at <= 1.1 * row.hours)) {
        plot.annotations.push(Annotation::Vertical {
            at,
            label: format!("limit reached, {at:.0} h"),
            tone: Tone::Bad,
        });
    }
    let scope = match (machine, life.contacts_alone) {
        (_, false) => "Prediction with coupled wear, all of it with the bearings and gears of the design.",
        (true, true) => {
            "Prediction with coupled wear. The machine's lost motion includes the bearings and gears of the design, all else is of the contacts of discs and pins alone."
        }
        (false, true) => {
            "Prediction with coupled wear, from the contacts of discs and pins alone; bearings and gears add theirs."
        }
    };
    plot.note = format!(
        "{scope} While the machine turns and is loaded one way, wear lets the output lag by a nearly constant angle, which no one notices; it shows when the \
         torque reverses, as lost motion."
    );
    life.errors.iter().for_each(|errors| plot.note.push_str(&format!(" {errors}")));
    plot
}

fn pressure(life: &LifePage) -> Plot {
    let mut plot =
        Plot::new("Largest contact pressure", hours(), Axis::new("Pressure", "MPa").from_zero()).half().with(
            Series::line("predicted", over_hours(life.prediction, |row| Some(row.max_pressure_mpa)))
                .strong()
                .coloured(Colour::Palette(0)),
        );
    if life.study.len() > 1 {
        plot.series.push(
            Series::new(
                "paper's study",
                Style::LineMarkers,
                over_hours(life.study, |row| (row.max_pressure_mpa > 0.0).then_some(row.max_pressure_mpa)),
            )
            .coloured(Colour::Palette(1)),
        );
    }
    let limit = life.machine.limits.contact_pressure * 1e-6;
    plot.limit_at(limit, format!("allowed {} MPa", compact(limit, 4)));
    plot
}

fn pairs(life: &LifePage) -> Plot {
    let mut plot = Plot::new("Pins that carry, per disc", hours(), Axis::new("Loaded pairs", "").from_zero())
        .half()
        .with(
            Series::line("predicted", over_hours(life.prediction, |row| Some(row.loaded_pairs)))
                .strong()
                .coloured(Colour::Palette(0)),
        );
    if life.study.len() > 1 {
        plot.series.push(
            Series::new(
                "paper's study",
                Style::LineMarkers,
                over_hours(life.study, |row| Some(row.loaded_pairs)),
            )
            .coloured(Colour::Palette(1)),
        );
    }
    plot
}

/// At most this many rows; a prediction has many more steps than anyone reads (all are in the CSV beside the
/// report).
const TABLE_ROWS: usize = 13;

fn table(title: &str, rows: &[LifeRow]) -> Table {
    let stride = rows.len().div_ceil(TABLE_ROWS).max(1);
    let mut shown: Vec<&LifeRow> = rows.iter().step_by(stride).collect();
    if let Some(last) = rows.last().filter(|last| shown.last().is_some_and(|row| row.hours < last.hours)) {
        shown.push(last);
    }
    // Rounding noise of a flank that just touches is no play.
    let optional = |value: Option<f64>| {
        value.map_or_else(
            || "–".to_owned(),
            |value| if value.abs() < 1e-6 { "0".to_owned() } else { significant(value, 3) },
        )
    };
    let angle = |value: f64| if value.abs() < 1e-6 { "0".to_owned() } else { significant(value, 3) };
    let pair = |value: Option<MeanAndMax>| {
        value
            .map_or_else(|| "–".to_owned(), |v| format!("{} / {}", angle(v.mean_arcmin), angle(v.max_arcmin)))
    };
    type Cell<'a> = (Column, Box<dyn Fn(&LifeRow) -> String + 'a>, bool);
    let any = |has: fn(&LifeRow) -> bool| rows.iter().any(has);
    let cells: Vec<Cell> = vec![
        (Column::number("Time", "h"), Box::new(|row| format!("{:.0}", row.hours)), true),
        (Column::number("Deepest wear", "µm"), Box::new(move |row| angle(row.max_depth_um)), true),
        (Column::number("Play", "arcmin"), Box::new(move |row| angle(row.play_arcmin)), true),
        (
            Column::number("Lost motion", "arcmin"),
            Box::new(move |row| optional(row.lost_motion_arcmin)),
            any(|row| row.lost_motion_arcmin.is_some()),
        ),
        (
            Column::number("TE, no load", "arcmin"),
            Box::new(move |row| optional(row.te_no_load_arcmin)),
            any(|row| row.te_no_load_arcmin.is_some()),
        ),
        (Column::number("TE, loaded", "arcmin"), Box::new(move |row| angle(row.te_loaded_arcmin)), true),
        (
            Column::number("Largest force", "N"),
            Box::new(|row| significant(row.max_force_n, 3)),
            any(|row| row.max_force_n > 0.0),
        ),
        (
            Column::number("Pressure", "MPa"),
            Box::new(|row| significant(row.max_pressure_mpa, 4)),
            any(|row| row.max_pressure_mpa > 0.0),
        ),
        (Column::number("Loaded pairs", ""), Box::new(|row| significant(row.loaded_pairs, 3)), true),
        (
            Column::number("STE rigid, mean / max", "arcmin"),
            Box::new(move |row| pair(row.ste_rigid)),
            any(|row| row.ste_rigid.is_some()),
        ),
        (
            Column::number("DTE rigid, mean / max", "arcmin"),
            Box::new(move |row| pair(row.dte_rigid)),
            any(|row| row.dte_rigid.is_some()),
        ),
        (
            Column::number("STE flexible, mean / max", "arcmin"),
            Box::new(move |row| pair(row.ste_flexible)),
            any(|row| row.ste_flexible.is_some()),
        ),
        (
            Column::number("DTE flexible, mean / max", "arcmin"),
            Box::new(move |row| pair(row.dte_flexible)),
            any(|row| row.dte_flexible.is_some()),
        ),
    ];
    let cells: Vec<Cell> = cells.into_iter().filter(|cell| cell.2).collect();
    Table {
        title: title.to_owned(),
        rows: shown.iter().map(|row| cells.iter().map(|(_, text, _)| text(row)).collect()).collect(),
        columns: cells.into_iter().map(|(column, _, _)| column).collect(),
        note: String::new(),
    }
}
