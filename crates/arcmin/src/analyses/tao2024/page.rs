//! Terminal and report of the paper's study.

use super::{MeanAndMax, Tao2024, flank, load, motion, paper};
use crate::analyses::{TextBlock, TextTable};
use crate::machine::PinMounting;
use crate::report::{
    Axis, Block, Colour, Column, KeyFigure, Page, Plot, Provenance, Section, Series, Style, Table, Tone,
    Verdict, compact, in_decimals, literature, significant,
};
use crate::units::{MPA, RPM};

fn pair(te: Option<MeanAndMax>) -> String {
    te.map_or("–".to_owned(), |te| format!("{:.3} / {:.3}", te.mean, te.max))
}

fn hours(hours: Option<f64>) -> String {
    hours.map_or("–".to_owned(), |hours| format!("{hours:.0}"))
}

pub(super) fn text_blocks(study: &Tao2024) -> Vec<TextBlock> {
    let mut blocks = vec![TextBlock::line(format!("{}: {}", study.machine.name, headline(study)))];
    let simulated = study.levels.iter().any(|level| level.rigid.is_some());
    let elastic = study.levels.iter().any(|level| level.flexible.is_some());
    let mut header = vec!["hours h", "depth µm", "play ′"];
    if simulated {
        header.extend(["STE mean / max ′", "DTE mean / max ′"]);
    }
    if elastic {
        header.extend(["elastic STE ′", "elastic DTE ′"]);
    }
    let row = |level: &super::Level| {
        let mut row = vec![
            hours(level.hours),
            compact(level.depth_um(), 3),
            in_decimals(level.travel.play.arcmin(), 3),
        ];
        if simulated {
            row.extend([pair(level.ste_rigid()), pair(level.dte_rigid())]);
        }
        if elastic {
            row.extend([pair(level.ste_flexible()), pair(level.dte_flexible())]);
        }
        row
    };
    blocks.push(TextBlock::Table(TextTable {
        header: header.into_iter().map(str::to_owned).collect(),
        rows: study.levels.iter().map(row).collect(),
    }));
    blocks.extend(unsettled(study).map(TextBlock::Line));
    if simulated && chaotic(study) {
        blocks.push(TextBlock::line(
            "STE: undamped rattling is chaotic; where in the play it happens depends on the start, so its mean is \
             no result",
        ));
    }
    blocks
}

fn chaotic(study: &Tao2024) -> bool {
    let spreads = study.levels.iter().filter_map(|level| level.rigid.as_ref()?.spread.as_ref());
    spreads.into_iter().any(|spread| spread.is_chaotic())
}

fn unsettled(study: &Tao2024) -> Option<String> {
    let reason = study.unsettled.as_ref()?;
    Some(format!("no hours: {reason}; depths, play and transmission error do not need it"))
}

fn headline(study: &Tao2024) -> String {
    let Some(last) = study.levels.last() else { return "nothing was studied".to_owned() };
    let play = significant(last.travel.play.arcmin(), 3);
    match last.hours {
        Some(hours) => {
            format!("{:.0} µm off every flank after {hours:.0} h, {play} arcmin of play", last.depth_um())
        }
        None => format!("{:.0} µm off every flank, {play} arcmin of play", last.depth_um()),
    }
}

pub(super) fn page(study: &Tao2024) -> Page {
    let machine = &study.machine;
    let mut sections = vec![
        Section::new("machine", "Machine and model", tables_of_the_paper(study)),
        Section::new("study", "The study", over_the_levels(study)),
        Section::new("flank", "Tooth flank", flank::blocks(study)),
        Section::new("load", "Load sharing and wear", load::blocks(study)),
    ];
    let motion = motion::blocks(study);
    if !motion.is_empty() {
        sections.push(Section::new("simulation", "Simulated transmission error", motion));
    }
    sections.extend(study.elastic.clone());
    sections.push(literature(&["Tao2024", "Archard1953", "Johnson1985"]));
    let mut verdict = Verdict::new(
        if study.unsettled.is_some() { Tone::Caution } else { Tone::Neutral },
        format!("{}.", headline(study)),
    );
    verdict.figures = figures(study);
    verdict.answers.push((
        "Which physics".to_owned(),
        format!(
            "{}. Uniform wear is the paper's assumption; `arcmin life` computes wear and load sharing together.",
            study.fidelity.sentence()
        ),
    ));
    verdict.answers.extend(unsettled(study).map(|text| ("Missing".to_owned(), text)));
    Page {
        title: machine.name.clone(),
        subtitle: "The study of Tao2024".to_owned(),
        provenance: Provenance::default(),
        verdict,
        sections,
    }
}

fn figures(study: &Tao2024) -> Vec<KeyFigure> {
    let Some(last) = study.levels.last() else { return Vec::new() };
    let figure = |label: &str, value: f64, unit: &str, note: &str| {
        KeyFigure::new(label, significant(value, 3), unit, note)
    };
    let mut figures = vec![figure(
        "Play at the last level",
        last.travel.play.arcmin(),
        "arcmin",
        "one-sided, at the output, input locked",
    )];
    figures.extend(
        last.ste_rigid().map(|te| figure("STE, largest", te.max, "arcmin", "without load, rigid discs")),
    );
    figures.extend(
        last.dte_rigid().map(|te| figure("DTE, largest", te.max, "arcmin", "sinusoidal load, rigid discs")),
    );
    figures.extend(study.coefficient.map(|k| figure("Wear coefficient", k, "1/Pa", "of the uniform depth")));
    figures
}

/// Tables 1 to 3: dimensions, materials, bodies and joints.
fn tables_of_the_paper(study: &Tao2024) -> Vec<Block> {
    let machine = &study.machine;
    let papers = paper::is_its_machine(machine);
    let mm = |value: f64| compact(value * 1e3, 5);
    let row = |name: &str, ours: String, unit: &str, paper: &str| {
        vec![name.to_owned(), ours, unit.to_owned(), if papers { paper.to_owned() } else { "–".to_owned() }]
    };
    let dimensions = Table {
        title: "Dimensions and load".to_owned(),
        columns: vec![
            Column::text("Quantity"),
            Column::number("Here", ""),
            Column::text("Unit"),
            Column::number("Tao2024", ""),
        ],
        rows: vec![
            row("Pins", machine.ring.pin_count.to_string(), "", "40"),
            row("Teeth of a disc", (machine.ring.pin_count - 1).to_string(), "", "39"),
            row("Radius of the pin circle", mm(machine.ring.pin_circle_radius), "mm", "64"),
            row("Radius of a pin", mm(machine.ring.pin_radius), "mm", "3"),
            row("Eccentricity", mm(machine.crankshafts.eccentricity), "mm", "1.3"),
            row("Width of a disc", mm(machine.disc.width), "mm", "8.75"),
            row("Ratio", compact(machine.kinematics().ratio(), 5), "", "81"),
            row("Rated torque", compact(machine.rated.torque, 4), "N·m", "412"),
            row("Input speed", compact(machine.rated.input_speed / RPM, 5), "rpm", "1500"),
        ],
        note: "Table 1 of [Tao2024]; further dimensions are those of the design file.".to_owned(),
    };
    let material = |part: &str, material: &crate::materials::Material, paper: &str| {
        vec![
            part.to_owned(),
            material.name.clone(),
            compact(material.youngs_modulus / (1e3 * MPA), 4),
            compact(material.poisson_ratio, 3),
            compact(material.density, 5),
            if papers { paper.to_owned() } else { "–".to_owned() },
        ]
    };
    let materials = Table {
        title: "Materials".to_owned(),
        columns: vec![
            Column::text("Part"),
            Column::text("Material"),
            Column::number("Young's modulus", "GPa"),
            Column::number("Poisson's ratio", ""),
            Column::number("Density", "kg/m³"),
            Column::text("Tao2024"),
        ],
        rows: vec![
            material("Cycloid discs", &machine.disc.material, "GCr15"),
            material("Pins", &machine.ring.material, "GCr15"),
            material("Crankshafts", &machine.crankshafts.material, "GCr15"),
            material("Carrier", &machine.carrier.material, "20CrMnTi"),
        ],
        note: "Table 2 of [Tao2024].".to_owned(),
    };
    let joint = |a: &str, b: &str, how: &str| vec![a.to_owned(), b.to_owned(), how.to_owned()];
    let pins = match machine.ring.mounting {
        PinMounting::Fixed | PinMounting::OnePiece => "pins at rest: flank and pin slide",
        PinMounting::Spinning => "pins turn freely in their seats",
    };
    let joints = Table {
        title: "Bodies and joints of the model".to_owned(),
        columns: vec![Column::text("Body"), Column::text("Against"), Column::text("Joint")],
        rows: vec![
            joint("Sun", "housing", "turns as driven: 0.1 s to speed, then steadily"),
            joint("Planets with crankshafts", "carrier", "turn about fixed axes"),
            joint("Planets", "sun", "gear mesh, elastic, with damping"),
            joint("Cycloid discs", "eccentrics", "turn about them without clearance"),
            joint("Cycloid discs", "pins", "one-sided contact at every pin, with gaps and damping"),
            joint("Pins", "housing", pins),
            joint("Carrier", "housing", "turns about the axis; carries the load"),
        ],
        note: "Table 3 of [Tao2024]: ideal joints, so that play and error come from the contacts alone."
            .to_owned(),
    };
    vec![Block::Table(dimensions), Block::Table(materials), Block::Table(joints)]
}

/// Play and loaded error over the levels, and the table of all of them.
fn over_the_levels(study: &Tao2024) -> Vec<Block> {
    let depth = Axis::new("Uniform depth", "µm");
    let line = |value: &dyn Fn(&super::Level) -> f64| -> Vec<(f64, f64)> {
        study.levels.iter().map(|level| (level.depth_um(), value(level))).collect()
    };
    let angles = Plot::new(
        "Play and loaded error",
        depth.clone(),
        Axis::new("Angle at the output", "arcmin").from_zero(),
    )
    .half()
    .with(
        Series::new("play, one-sided", Style::LineMarkers, line(&|l| l.travel.play.arcmin()))
            .coloured(Colour::Palette(2)),
    )
    .with(
        Series::new(
            "size of the error at rated torque",
            Style::LineMarkers,
            line(&|l| l.accuracy.loaded_error.arcmin().abs()),
        )
        .coloured(Colour::Palette(1)),
    )
    .noted("Play and output error in arcmin, quasi-static with the input locked. The play is proportional to the uniform depth.");
    let forces = Plot::new("Largest force", depth, Axis::new("Force", "N").from_zero())
        .half()
        .with(
            Series::new("equilibrium", Style::LineMarkers, line(&|l| l.accuracy.max_force))
                .coloured(Colour::Palette(0)),
        )
        .with(
            Series::new(
                "closed form",
                Style::Dashed,
                line(&|l| l.handbook.as_ref().map_or(f64::NAN, |solution| solution.max_force)),
            )
            .coloured(Colour::Palette(1)),
        )
        .noted(
            "Largest force in N of one pin on one disc at rated torque, by equilibrium and by the closed form.",
        );
    let mut columns = vec![
        Column::number("Time", "h"),
        Column::number("Depth", "µm"),
        Column::number("Play", "arcmin"),
        Column::number("Loaded TE", "arcmin"),
        Column::number("Largest force", "N"),
    ];
    for (name, has) in [
        ("STE rigid, mean / max", study.levels.iter().any(|l| l.rigid.is_some())),
        ("DTE rigid, mean / max", study.levels.iter().any(|l| l.rigid.is_some())),
        ("STE elastic, mean / max", study.levels.iter().any(|l| l.flexible.is_some())),
        ("DTE elastic, mean / max", study.levels.iter().any(|l| l.flexible.is_some())),
    ] {
        if has {
            columns.push(Column::number(name, "arcmin"));
        }
    }
    let row = |level: &super::Level| {
        let mut row = vec![
            hours(level.hours),
            compact(level.depth_um(), 3),
            in_decimals(level.travel.play.arcmin(), 3),
            in_decimals(level.accuracy.loaded_error.arcmin(), 3),
            significant(level.accuracy.max_force, 3),
        ];
        if level.rigid.is_some() {
            row.extend([pair(level.ste_rigid()), pair(level.dte_rigid())]);
        }
        if level.flexible.is_some() {
            row.extend([pair(level.ste_flexible()), pair(level.dte_flexible())]);
        }
        row
    };
    let table = Table {
        title: "All levels".to_owned(),
        columns,
        rows: study.levels.iter().map(row).collect(),
        note: "Hours by the paper's wear rule. An output that lags is negative.".to_owned(),
    };
    vec![Block::Plot(angles), Block::Plot(forces), Block::Table(table)]
}
