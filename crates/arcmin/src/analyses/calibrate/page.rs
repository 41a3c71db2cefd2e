//! Terminal and report of a calibration.

use super::declared::{CALIBRATION, LIMITS, LIVES};
use super::limits::rounded;
use super::{Calibration, CurvePoint, MachineLife, NewIs, ReadingError, Remaining, Row};
use crate::analyses::TextBlock;
use crate::analyses::life::LimitKind;
use crate::report::{
    Annotation, Axis, Block, Colour, Column, KeyFigure, Page, Plot, Provenance, Section, Series, Style,
    Table, Tone, Verdict, capitalised, compact, significant,
};
use crate::units::{ARCMIN, HOUR, UM};
use crate::wear::{CONFIDENCE, Estimate, Measured, Parameter};

/// Largest number of rows in the terminal; the file contains all.
const SHOWN: usize = 24;
/// Largest number of machines distinguished in one figure.
const MACHINES: usize = 6;

pub(in crate::analyses) fn text_blocks(calibrated: &Calibration) -> Vec<TextBlock> {
    let table = CALIBRATION.fill(&calibrated.rows);
    let several = calibrated.rows.iter().any(|row| !row.observed.machine.is_empty());
    let columns = ["machine", "hours", "quantity", "observed", "predicted", "residual_percent", "use"];
    let columns = if several { &columns[..] } else { &columns[1..] };
    let mut blocks: Vec<TextBlock> = answers(calibrated).into_iter().map(TextBlock::Line).collect();
    blocks.push(TextBlock::line(format!("\n{}: {}", calibrated.name, calibrated.physics)));
    blocks.push(TextBlock::columns(&table, columns, 0..table.rows().min(SHOWN)));
    if table.rows() > SHOWN {
        blocks.push(TextBlock::line(format!("… {} more in calibration.csv", table.rows() - SHOWN)));
    }
    blocks.extend(calibrated.fit.estimates.iter().filter_map(band).map(TextBlock::Line));
    blocks.extend(calibrated.lives.iter().take(MACHINES + 1).map(|life| TextBlock::line(new_of(life))));
    blocks.extend(calibrated.test().map(TextBlock::Line));
    blocks.extend(calibrated.cautions().into_iter().map(|text| TextBlock::line(format!("careful: {text}"))));
    blocks.push(TextBlock::line(format!("\n{}\n", calibrated.keys())));
    blocks
}

/// Remaining hours of the limits: the selected one first, then the others of the same machine, then those of the
/// other machines.
fn answers(calibrated: &Calibration) -> Vec<String> {
    let selected = calibrated.headline_limit();
    let several = calibrated.lives.len() > 2;
    let words = |limit: &Remaining| {
        let who = match &limit.machine {
            Some(name) if several => format!("{name}: "),
            None if several => "the design: ".to_owned(),
            _ => String::new(),
        };
        format!("{who}{}", limit.sentence())
    };
    let name = &selected.machine;
    let own = calibrated.limits.iter().filter(|limit| limit.machine == *name && *limit != selected);
    // For the other machines only the lost motion, in which they differ.
    let others = calibrated
        .limits
        .iter()
        .filter(|limit| limit.machine != *name && several && limit.kind == LimitKind::LostMotion);
    std::iter::once(selected).chain(own).chain(others.take(MACHINES)).map(words).collect()
}

/// The value of a new machine in words.
fn new_of(life: &MachineLife) -> String {
    let new = significant(life.new / ARCMIN, 3);
    match (&life.name, life.new_is) {
        (None, _) => format!("the design predicts {new} arcmin of lost motion when new"),
        (Some(name), NewIs::Fitted) => format!("{name} (lost motion when new {new} arcmin, fitted)"),
        (Some(name), NewIs::Given) => format!("{name} (lost motion when new {new} arcmin, as given)"),
        (Some(name), NewIs::Assumed) => format!("{name} (lost motion when new {new} arcmin, by the design)"),
    }
}

/// A sentence about a parameter with its band; `None` without a band.
fn band(estimate: &Estimate) -> Option<String> {
    let (unit, name) = match estimate.parameter {
        Parameter::Coefficient => (1.0, "1/Pa"),
        Parameter::Factor => (1.0, ""),
        Parameter::Duration => (HOUR, "h"),
    };
    let amount = |value: f64| match estimate.parameter {
        Parameter::Coefficient => format!("{:.3e}", value / unit),
        _ => compact(value / unit, 4),
    };
    let range = match (estimate.low, estimate.high) {
        (Some(low), Some(high)) => format!("{} to {}", amount(low), amount(high)),
        (Some(low), None) => format!("{} or more", amount(low)),
        (None, Some(high)) => format!("{} or less", amount(high)),
        (None, None) => return None,
    };
    let percent = 100.0 * CONFIDENCE;
    let name = if name.is_empty() { String::new() } else { format!(" {name}") };
    Some(format!("{percent:.0} % band: {} {range}{name}", estimate.parameter.name()))
}

pub(in crate::analyses) fn page(calibrated: &Calibration) -> Page {
    let cautions = calibrated.cautions();
    let careful = calibrated.test().is_some() || !cautions.is_empty();
    let selected = calibrated.headline_limit();
    let tone = match selected.left() {
        Some(0.0) => Tone::Bad,
        _ if careful => Tone::Caution,
        _ => Tone::Good,
    };
    let mut sentences = answers(calibrated).into_iter();
    let headline = sentences.next().map_or(String::new(), |text| sentence_of(&text));
    let mut verdict = Verdict::new(tone, headline);
    verdict.figures = figures(calibrated);
    let others: Vec<String> = sentences.map(|text| sentence_of(&text)).collect();
    if !others.is_empty() {
        verdict.answers.push(("The other limits".to_owned(), others.join(" ")));
    }
    verdict.answers.push((
        "How well it fits".to_owned(),
        format!(
            "With the wear coefficient {:.3e} 1/Pa the residuals are {:.1} % of the readings (root mean square).",
            calibrated.fit.law.coefficient,
            100.0 * calibrated.fit.relative_rms
        ),
    ));
    let careful: Vec<String> = calibrated.test().into_iter().chain(cautions).collect();
    if !careful.is_empty() {
        let sentences: Vec<String> = careful.iter().map(|text| sentence_of(text)).collect();
        verdict.answers.push(("Caution".to_owned(), sentences.join(" ")));
    }
    verdict.answers.push(("Which physics".to_owned(), sentence_of(&calibrated.physics)));
    let mut blocks = Vec::new();
    blocks.extend(depth_plot(calibrated).map(Block::Plot));
    blocks.push(Block::Plot(lost_motion_plot(calibrated)));
    blocks.push(Block::Table(readings_table(calibrated)));
    let estimates: Vec<String> = calibrated.fit.estimates.iter().filter_map(band).collect();
    let mut life = vec![Block::Table(limits_table(calibrated)), Block::Table(lives_table(calibrated))];
    if !estimates.is_empty() {
        life.push(Block::Text(format!(
            "{}. Bands are those of the profile likelihood, from {}.",
            estimates.join("; "),
            match calibrated.reading_error {
                ReadingError::Scatter => "the scatter of the readings",
                ReadingError::Given(_) => "the reading error given",
                ReadingError::Assumed(_) => "an assumed reading error",
            }
        )));
    }
    life.push(Block::Code { title: "For the design file".to_owned(), text: calibrated.keys() });
    Page {
        title: calibrated.name.clone(),
        subtitle: "Calibration of the wear".to_owned(),
        provenance: Provenance::default(),
        verdict,
        sections: vec![
            Section::new("fit", "Readings and fit", blocks),
            Section::new("life", "Remaining life", life),
        ],
    }
}

/// With a capital and a full stop.
fn sentence_of(text: &str) -> String {
    format!("{}.", capitalised(text).trim_end_matches('.'))
}

fn figures(calibrated: &Calibration) -> Vec<KeyFigure> {
    let k = calibrated.fit.law.coefficient;
    let range = calibrated.fit.estimates.first().and_then(band);
    let mut figures = vec![KeyFigure::new(
        "Wear coefficient",
        significant(k * 1e6, 4),
        "mm²/N",
        format!("{k:.4e} 1/Pa, of Archard's law{}", range.map_or(String::new(), |text| format!("; {text}"))),
    )];
    for limit in calibrated.its_limits().take(3) {
        let (value, kept) = match (limit.left(), limit.is_over()) {
            (_, true) => ("over".to_owned(), false),
            (Some(left), false) => (rounded(left), true),
            (None, false) => (format!("> {}", rounded((limit.searched_h - limit.now_h).max(0.0))), true),
        };
        let unit = if limit.is_over() { "" } else { "h" };
        let note = sentence_of(&limit.sentence());
        let label = format!("Remaining: {}", limit.kind.name());
        figures.insert(figures.len() - 1, KeyFigure::new(label, value, unit, note).kept(kept));
    }
    figures
}

fn hours() -> Axis {
    Axis::new("Running time", "h").from_zero()
}

/// The fitted curve with its band.
fn predicted(
    plot: Plot,
    curve: &[CurvePoint],
    unit: f64,
    of: fn(&CurvePoint) -> (f64, Option<(f64, f64)>),
) -> Plot {
    let bands = curve.iter().filter_map(|point| {
        let (low, high) = of(point).1?;
        Some((point.hours, low / unit, high / unit))
    });
    let bands: Vec<_> = bands.collect();
    let line = curve.iter().map(|point| (point.hours, of(point).0 / unit));
    let mut plot = plot;
    if !bands.is_empty() {
        plot = plot.with(Series::band("95 % band", bands).coloured(Colour::Palette(0)));
    }
    plot.with(Series::line("fitted prediction", line).coloured(Colour::Palette(0)))
}

/// Readings as markers, by machine if there are few, and with separate markers for those not fitted.
fn marks(mut plot: Plot, rows: &[&Row], value: impl Fn(&Row) -> f64) -> Plot {
    let mut names: Vec<&str> = rows.iter().map(|row| row.observed.machine.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let apart = names.len() > 1 && names.len() <= MACHINES;
    let groups: Vec<Option<&str>> = if apart { names.into_iter().map(Some).collect() } else { vec![None] };
    for (index, group) in groups.into_iter().enumerate() {
        for fitted in [true, false] {
            let points: Vec<(f64, f64)> = rows
                .iter()
                .filter(|row| row.fitted == fitted && group.is_none_or(|name| row.observed.machine == name))
                .map(|row| (row.observed.reading.time / HOUR, value(row)))
                .collect();
            if points.is_empty() {
                continue;
            }
            let name = match (group, fitted) {
                (Some(name), true) => name.to_owned(),
                (Some(name), false) => format!("{name}, not fitted"),
                (None, true) => "readings".to_owned(),
                (None, false) => "readings, not fitted".to_owned(),
            };
            let colour = if fitted { Colour::Palette(1 + index as u8) } else { Colour::Reference };
            plot = plot.with(Series::new(name, Style::Markers, points).coloured(colour));
        }
    }
    plot
}

fn depth_plot(calibrated: &Calibration) -> Option<Plot> {
    let rows: Vec<&Row> =
        calibrated.rows.iter().filter(|row| row.observed.reading.measured == Measured::Depth).collect();
    if rows.is_empty() {
        return None;
    }
    let plot = Plot::new("Largest depth of a flank", hours(), Axis::new("Depth", "µm").from_zero()).noted(
        "Largest wear depth in µm by the coupled prediction with the fitted coefficient, and the readings.",
    );
    let plot = predicted(plot, &calibrated.curve, UM, |point| point.depth);
    Some(marks(plot, &rows, |row| row.observed.reading.value / UM))
}

fn lost_motion_plot(calibrated: &Calibration) -> Plot {
    let rows: Vec<&Row> =
        calibrated.rows.iter().filter(|row| row.observed.reading.measured != Measured::Depth).collect();
    let mut note = "Growth of the lost motion since new in arcmin by the coupled prediction with the fitted \
         coefficient"
        .to_owned();
    note.push_str(if rows.is_empty() { "; the readings are depths." } else { ", and the readings." });
    if rows.iter().any(|row| matches!(row.observed.reading.measured, Measured::LostMotion(_))) {
        note.push_str(
            "  From readings of the lost motion the value of their machine when new is subtracted.",
        );
    }
    let plot = Plot::new(
        "Growth of the lost motion",
        hours(),
        Axis::new("Increase of the lost motion since new", "arcmin").from_zero(),
    )
    .noted(note);
    let plot = predicted(plot, &calibrated.curve, ARCMIN, |point| point.increase);
    let curve = &calibrated.curve;
    let mut plot = marks(plot, &rows, |row| row.since_new(&calibrated.lives) / ARCMIN);
    // The limit is shown for a single machine only; for many machines the lines would cover the figure.
    if let [life] | [_, life] = &calibrated.lives[..] {
        let limit = calibrated.limits_of_design.lost_motion;
        let left = (limit - life.new) / ARCMIN;
        let highest = curve.last().map_or(0.0, |point| point.increase.0) / ARCMIN;
        if left > 0.0 && left < 2.0 * highest {
            plot.limit_at(left, format!("limit of {} arcmin reached", compact(limit / ARCMIN, 4)));
        }
        let end = curve.last().map_or(0.0, |point| point.hours);
        if let Some(at) = life.hours.filter(|at| *at > 0.0 && *at <= end) {
            let label = format!("{at:.0} h");
            plot.annotations.push(Annotation::Vertical { at, label, tone: Tone::Bad });
        }
    }
    plot
}

/// The head of a declared table as that of a report.
fn headed(table: &crate::results::Table, title: &str, note: &str) -> Table {
    let words = ["machine", "quantity", "use", "limit", "where", "unit"];
    let head = |column: &crate::results::TableColumn| {
        let quantity = &column.quantity;
        if words.contains(&quantity.key) {
            Column::text(sentence_of(&quantity.label()).trim_end_matches('.'))
        } else {
            Column::number(sentence_of(&quantity.label()).trim_end_matches('.'), quantity.unit())
        }
    };
    let row = |row: usize| table.columns.iter().map(|c| c.quantity.show(&c.cells.value(row))).collect();
    Table {
        title: title.to_owned(),
        columns: table.columns.iter().map(head).collect(),
        rows: (0..table.rows().min(10 * SHOWN)).map(row).collect(),
        note: note.to_owned(),
    }
}

fn readings_table(calibrated: &Calibration) -> Table {
    let mut table =
        headed(&CALIBRATION.fill(&calibrated.rows), "Readings", "All of them are in `calibration.csv`.");
    // The machines have no names.
    if calibrated.rows.iter().all(|row| row.observed.machine.is_empty()) {
        table.columns.remove(0);
        table.rows.iter_mut().for_each(|row| drop(row.remove(0)));
    }
    table
}

fn limits_table(calibrated: &Calibration) -> Table {
    let own: Vec<Remaining> = calibrated.its_limits().cloned().collect();
    let mut table = headed(
        &LIMITS.fill(&own),
        "How long each limit is kept",
        "Hours from the last reading. For a rating life: the hours that nine of ten reach of the parts that run now \
         (Weibull, slope 9/8). Pressure and transmission error follow the prediction with the coefficient fitted. \
         All machines are in `remaining_limits.csv`.",
    );
    table.columns.remove(0);
    for (row, limit) in table.rows.iter_mut().zip(&own) {
        row.remove(0);
        row[0] = limit.kind.name().to_owned();
    }
    table
}

fn lives_table(calibrated: &Calibration) -> Table {
    let mut table = headed(
        &LIVES.fill(&calibrated.lives),
        "Hours to the limit of lost motion",
        "With the growth fitted. For a machine with readings of the lost motion the growth is added to its value when new. An empty \
         field is a limit that is not reached within the computed growth.",
    );
    for row in &mut table.rows {
        if row[0].is_empty() || row[0] == "–" {
            row[0] = "the design".to_owned();
        }
    }
    table
}
