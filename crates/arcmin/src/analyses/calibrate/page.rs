//! Terminal and report of a calibration.

use super::declared::{CALIBRATION, LIVES};
use super::{Calibrated, CurvePoint, MachineLife, Row};
use crate::analyses::Said;
use crate::report::{
    Annotation, Axis, Block, Colour, Column, KeyFigure, Page, Plot, Provenance, Section, Series, Style,
    Table, Tone, Verdict, capitalised, compact, significant,
};
use crate::units::{ARCMIN, HOUR, UM};
use crate::wear::{CONFIDENCE, Estimate, Measured, Parameter};

/// Rows that a terminal shows; the file has all.
const SHOWN: usize = 24;
/// Machines that a reader can tell apart in one figure.
const MACHINES: usize = 6;

pub(super) fn said(calibrated: &Calibrated) -> Vec<Said> {
    let table = CALIBRATION.fill(&calibrated.rows);
    let several = calibrated.rows.iter().any(|row| !row.observed.machine.is_empty());
    let columns = ["machine", "hours", "quantity", "observed", "predicted", "residual_percent", "use"];
    let columns = if several { &columns[..] } else { &columns[1..] };
    let mut said = vec![
        Said::line(format!("{}: {}", calibrated.machine.name, calibrated.fidelity.sentence())),
        Said::columns(&table, columns, 0..table.rows().min(SHOWN)),
    ];
    if table.rows() > SHOWN {
        said.push(Said::line(format!("… {} more in calibration.csv", table.rows() - SHOWN)));
    }
    said.push(Said::line(calibrated.keys()));
    said.extend(calibrated.fit.estimates.iter().filter_map(band).map(Said::Line));
    said.extend(
        calibrated.lives.iter().take(MACHINES + 1).map(|life| Said::line(sentence(life, calibrated))),
    );
    said.extend(calibrated.test().map(Said::Line));
    said.extend(calibrated.cautions().into_iter().map(|text| Said::line(format!("careful: {text}"))));
    said
}

/// A parameter with its band in words; nothing where no band could be given.
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

/// How long a machine lasts, in words.
fn sentence(life: &MachineLife, calibrated: &Calibrated) -> String {
    let limit = compact(calibrated.machine.limits.lost_motion / ARCMIN, 4);
    let who = match &life.name {
        Some(name) => format!("{name} (lost motion when new {} arcmin)", significant(life.new / ARCMIN, 3)),
        None => format!("the design (predicted {} arcmin when new)", significant(life.new / ARCMIN, 3)),
    };
    let Some(hours) = life.hours else {
        return format!("{who} keeps {limit} arcmin for all {:.0} h followed", calibrated.followed_h);
    };
    if hours <= 0.0 {
        return format!("{who} does not keep {limit} arcmin even when new");
    }
    let range = match (life.low, life.high) {
        (Some(low), Some(high)) => format!(" ({low:.0} to {high:.0} h)"),
        (Some(low), None) => format!(" ({low:.0} h at least)"),
        _ => String::new(),
    };
    let left = life.left(hours);
    format!("{who} reaches {limit} arcmin after {hours:.0} h{range}; {left:.0} h after the last reading")
}

pub(super) fn page(calibrated: &Calibrated) -> Page {
    let k = calibrated.fit.law.coefficient;
    let cautions = calibrated.cautions();
    let careful = calibrated.test().is_some() || !cautions.is_empty();
    let mut verdict = Verdict::new(
        if careful { Tone::Caution } else { Tone::Good },
        format!("k = {k:.3e} 1/Pa fits within {:.1} %.", 100.0 * calibrated.fit.relative_rms),
    );
    verdict.figures = figures(calibrated);
    let careful: Vec<String> = calibrated.test().into_iter().chain(cautions).collect();
    if !careful.is_empty() {
        let sentences: Vec<String> = careful.iter().map(|text| sentence_of(text)).collect();
        verdict.answers.push(("What to be careful with".to_owned(), sentences.join(" ")));
    }
    verdict.answers.push(("Which physics".to_owned(), sentence_of(&calibrated.fidelity.sentence())));
    let mut blocks = Vec::new();
    blocks.extend(depth_plot(calibrated).map(Block::Plot));
    blocks.push(Block::Plot(lost_motion_plot(calibrated)));
    blocks.push(Block::Table(readings_table(calibrated)));
    let estimates: Vec<String> = calibrated.fit.estimates.iter().filter_map(band).collect();
    let mut life = vec![Block::Table(lives_table(calibrated))];
    if !estimates.is_empty() {
        life.push(Block::Text(format!(
            "{}. Bands are those of the profile likelihood, from the {}.",
            estimates.join("; "),
            if calibrated.rows.len() > calibrated.fit.estimates.len() {
                "readings"
            } else {
                "reading error given"
            }
        )));
    }
    life.push(Block::Code { title: "For the design file".to_owned(), text: calibrated.keys() });
    Page {
        title: calibrated.machine.name.clone(),
        subtitle: "Calibration of the wear".to_owned(),
        provenance: Provenance::default(),
        verdict,
        sections: vec![
            Section::new("fit", "Readings and fit", blocks),
            Section::new("life", "What follows", life),
        ],
    }
}

/// With a capital and a full stop.
fn sentence_of(text: &str) -> String {
    format!("{}.", capitalised(text).trim_end_matches('.'))
}

fn figures(calibrated: &Calibrated) -> Vec<KeyFigure> {
    let k = calibrated.fit.law.coefficient;
    let range = calibrated.fit.estimates.first().and_then(band);
    let mut figures = vec![KeyFigure::new(
        "Wear coefficient",
        significant(k * 1e6, 4),
        "mm²/N",
        format!("{k:.4e} 1/Pa, of Archard's law{}", range.map_or(String::new(), |text| format!("; {text}"))),
    )];
    for life in calibrated.lives.iter().rev().take(2).rev() {
        let label = match &life.name {
            Some(name) => format!("Life of {name}"),
            None => "Life of the design".to_owned(),
        };
        let limit = compact(calibrated.machine.limits.lost_motion / ARCMIN, 4);
        let service = calibrated.machine.limits.service_life / HOUR;
        let (value, kept) = match life.hours {
            Some(hours) => (format!("{hours:.0}"), hours >= service),
            None => (format!("> {:.0}", calibrated.followed_h), true),
        };
        let band = match (life.low, life.high) {
            (Some(low), Some(high)) => format!("{low:.0} to {high:.0} h; "),
            (Some(low), None) => format!("{low:.0} h at least; "),
            _ => String::new(),
        };
        let note = format!("{band}until {limit} arcmin of lost motion; {service:.0} h planned");
        figures.push(KeyFigure::new(label, value, "h", note).kept(kept));
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

/// Readings as marks: machine by machine where they can be told apart, those not fitted for themselves.
fn marks(mut plot: Plot, calibrated: &Calibrated, rows: &[&Row], value: impl Fn(&Row) -> f64) -> Plot {
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
    let _ = calibrated;
    plot
}

fn depth_plot(calibrated: &Calibrated) -> Option<Plot> {
    let rows: Vec<&Row> =
        calibrated.rows.iter().filter(|row| row.observed.reading.measured == Measured::Depth).collect();
    if rows.is_empty() {
        return None;
    }
    let plot = Plot::new("Largest depth of a flank", hours(), Axis::new("Depth", "µm").from_zero())
        .noted("The coupled prediction with the coefficient fitted, beside the readings.");
    let plot = predicted(plot, &calibrated.curve, UM, |point| point.depth);
    Some(marks(plot, calibrated, &rows, |row| row.observed.reading.value / UM))
}

fn lost_motion_plot(calibrated: &Calibrated) -> Plot {
    let rows: Vec<&Row> =
        calibrated.rows.iter().filter(|row| row.observed.reading.measured != Measured::Depth).collect();
    let mut note = "The coupled prediction with the coefficient fitted".to_owned();
    note.push_str(if rows.is_empty() {
        ": what the depths make of the lost motion."
    } else {
        ", beside the readings."
    });
    if rows.iter().any(|row| matches!(row.observed.reading.measured, Measured::Since(_))) {
        note.push_str(
            " Readings of the lost motion itself stand as growth since new: what had grown before the first of a \
             machine is the fit's.",
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
    let mut plot = marks(plot, calibrated, &rows, |row| row.since_new(curve) / ARCMIN);
    // One line is a limit; one for each of many machines would be a fence.
    if let [life] | [_, life] = &calibrated.lives[..] {
        let limit = calibrated.machine.limits.lost_motion;
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
    let words = ["machine", "quantity", "use"];
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

fn readings_table(calibrated: &Calibrated) -> Table {
    headed(&CALIBRATION.fill(&calibrated.rows), "Readings", "All of them are in `calibration.csv`.")
}

fn lives_table(calibrated: &Calibrated) -> Table {
    let mut table = headed(
        &LIVES.fill(&calibrated.lives),
        "How long the limit of lost motion is kept",
        "With the growth fitted. A machine whose lost motion was read starts from its own first reading, taken back to \
         new; an empty field is a limit that is not reached within what was followed.",
    );
    for row in &mut table.rows {
        if row[0].is_empty() || row[0] == "–" {
            row[0] = "the design".to_owned();
        }
    }
    table
}
