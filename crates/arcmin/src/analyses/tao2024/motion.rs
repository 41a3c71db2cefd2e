//! Figures 11 to 19 of Tao2024: simulated runs, and transmission error against hours beside the paper's numbers.

use super::paper::*;
use super::{Level, MeanAndMax, Tao2024};
use crate::dynamics::{RunResult, Sample, StudyPoint};
use crate::report::{
    Annotation, Axis, Block, Colour, Plot, Series, Style, Table, Tone, Width, compact, significant, thinned,
};
use crate::units::{ARCMIN, DEG};

pub(super) fn blocks(life: &Tao2024) -> Vec<Block> {
    let mut blocks = Vec::new();
    // The paper shows its runs at 10 µm.
    let level = life.levels.get(1).or(life.levels.last());
    let trace = |runs: Option<&StudyPoint>, of: fn(&StudyPoint) -> &RunResult| {
        runs.and_then(|runs| Trace::new(of(runs), level.map_or(0.0, Level::depth_um)))
    };
    let (rigid, flexible) =
        (level.and_then(|level| level.rigid.as_ref()), level.and_then(|level| level.flexible.as_ref()));
    let runs = [
        (trace(rigid, |p| &p.no_load), "Rigid discs without load", "Figures 11 and 12", RunKind::Static),
        (trace(rigid, |p| &p.loaded), "Rigid discs with sinusoidal load", "Figures 13–15", RunKind::Dynamic),
        (
            trace(flexible, |p| &p.no_load),
            "Elastic discs without load",
            "Figures 16 and 17",
            RunKind::Flexible,
        ),
        (trace(flexible, |p| &p.loaded), "Elastic discs with sinusoidal load", "", RunKind::FlexibleDynamic),
    ];
    let figures_of = |figures: &str| {
        if figures.is_empty() {
            "Not in [Tao2024].".to_owned()
        } else {
            format!("[Tao2024] shows it in {figures}.")
        }
    };
    let has = |value: fn(&Level) -> bool| life.levels.iter().any(value);
    if has(|row| row.ste_rigid().is_some() || row.dte_rigid().is_some()) {
        blocks.push(Block::Plot(rigid_over_life(life)));
    }
    if has(|row| row.ste_flexible().is_some()) {
        blocks.push(Block::Plot(flexible_over_life(life)));
        blocks.push(Block::Plot(loaded_over_life(life)));
    }
    if is_its_machine(&life.machine) && life.coefficient.is_some() && !blocks.is_empty() {
        blocks.push(Block::Table(comparison(life)));
        blocks.extend(differences(life).into_iter().map(|text| Block::Note(Tone::Neutral, text)));
    }
    for (run, title, figures, kind) in runs {
        let Some(run) = run else { continue };
        let figures = &figures_of(figures);
        blocks.push(Block::Heading(format!("{title}, {} µm uniform wear", compact(run.wear_um, 3))));
        blocks.push(Block::Plot(speeds(title, figures, &run, life.machine.kinematics().ratio())));
        let mut error = error(title, figures, &run, kind, is_its_machine(&life.machine));
        if let Some(load) = load(title, figures, &run) {
            blocks.push(Block::Plot(load));
            error.width = Width::Full;
        }
        blocks.push(Block::Plot(error));
    }
    blocks
}

/// One simulated run in trade units; equal lengths.
struct Trace {
    wear_um: f64,
    time_s: Vec<f64>,
    input_speed_deg_s: Vec<f64>,
    output_speed_deg_s: Vec<f64>,
    load_n_m: Vec<f64>,
    te_arcmin: Vec<f64>,
    /// Start of the steady part, from which the statistics are taken.
    steady_from_s: f64,
    te: MeanAndMax,
}

impl Trace {
    fn new(result: &RunResult, wear_um: f64) -> Option<Trace> {
        let column = |of: fn(&Sample) -> f64| result.series.iter().map(of).collect();
        Some(Trace {
            wear_um,
            time_s: column(|sample| sample.time),
            input_speed_deg_s: column(|sample| sample.input_speed / DEG),
            output_speed_deg_s: column(|sample| sample.output_speed / DEG),
            load_n_m: column(|sample| sample.load),
            te_arcmin: column(|sample| sample.transmission_error / ARCMIN),
            steady_from_s: result.reached - result.statistics?.duration,
            te: MeanAndMax::of(result)?,
        })
    }
}

#[derive(Clone, Copy, PartialEq)]
enum RunKind {
    Static,
    Dynamic,
    Flexible,
    FlexibleDynamic,
}

/// Input over the ratio and output on one axis, so that they can be compared, and the load where there is
/// one.
fn speeds(title: &str, figures: &str, run: &Trace, ratio: f64) -> Plot {
    let scaled: Vec<f64> = run.input_speed_deg_s.iter().map(|speed| speed / ratio).collect();
    Plot::new(format!("{title}: speeds"), Axis::new("Time", "s"), Axis::new("Speed at the output", "°/s"))
        .half()
        .with(
            Series::line("output", thinned(&run.time_s, &run.output_speed_deg_s))
                .coloured(Colour::Palette(0)),
        )
        .with(
            Series::new(
                format!("input / {}", compact(ratio, 4)),
                Style::Dashed,
                thinned(&run.time_s, &scaled),
            )
            .coloured(Colour::Reference),
        )
        .noted(format!(
            "{figures} Speed of the output, and of the input over the ratio, in °/s. The input turns at {} °/s.",
            compact(run.input_speed_deg_s.last().copied().unwrap_or(0.0), 5)
        ))
}

/// The load on the output, where there is one.
fn load(title: &str, figures: &str, run: &Trace) -> Option<Plot> {
    run.load_n_m.iter().any(|load| *load != 0.0).then(|| {
        Plot::new(format!("{title}: load"), Axis::new("Time", "s"), Axis::new("Load torque", "N·m"))
            .half()
            .with(Series::line("load", thinned(&run.time_s, &run.load_n_m)).coloured(Colour::Palette(1)))
            .noted(format!(
                "{figures} External torque at the output in N·m; positive against positive motion."
            ))
    })
}

fn error(title: &str, figures: &str, run: &Trace, kind: RunKind, papers: bool) -> Plot {
    let mut plot = Plot::new(
        format!("{title}: transmission error"),
        Axis::new("Time", "s"),
        Axis::new("Transmission error", "arcmin"),
    )
    .half()
    .with(
        Series::line("transmission error", thinned(&run.time_s, &run.te_arcmin)).coloured(Colour::Palette(0)),
    );
    plot.note = format!(
        "{figures} From {} s on, the mean of |TE| is {} arcmin and its largest value {} arcmin.",
        compact(run.steady_from_s, 2),
        significant(run.te.mean, 4),
        significant(run.te.max, 4)
    );
    if papers && (run.wear_um - 10.0).abs() < 1e-6 {
        plot.note.push_str(&match kind {
            RunKind::Static => format!(" The paper: mean {STE_MEAN_AT_10_UM} arcmin."),
            RunKind::Dynamic => format!(
                " The paper: mean {DTE_MEAN_AT_10_UM} arcmin, excursions of about {DTE_EXCURSION_AT_10_UM} \
                 arcmin."
            ),
            RunKind::Flexible => format!(
                " The paper: mean {FLEXIBLE_MEAN_AT_10_UM} arcmin, largest about {FLEXIBLE_MAX_AT_10_UM} \
                 arcmin."
            ),
            RunKind::FlexibleDynamic => String::new(),
        });
    }
    if let Some(last) = run.time_s.last() {
        plot.annotations.push(Annotation::Span { from: run.steady_from_s, to: *last, label: String::new() });
    }
    plot
}

/// Hours by the paper's wear rule, or the depth without hours.
fn place(life: &Tao2024, level: &Level) -> f64 {
    if life.coefficient.is_some() { level.hours.unwrap_or(f64::NAN) } else { level.depth_um() }
}

fn places(life: &Tao2024) -> Axis {
    match life.coefficient {
        Some(_) => Axis::new("Running time (paper's wear rule)", "h"),
        None => Axis::new("Uniform depth", "µm"),
    }
}

fn over_hours(
    life: &Tao2024,
    value: impl Fn(&Level) -> Option<MeanAndMax>,
    part: fn(MeanAndMax) -> f64,
) -> Vec<(f64, f64)> {
    life.levels.iter().filter_map(|row| value(row).map(|v| (place(life, row), part(v)))).collect()
}

fn hours_at_10_um(life: &Tao2024) -> Option<f64> {
    life.levels.iter().find(|row| (row.depth_um() - 10.0).abs() < 1e-6)?.hours
}

fn paper_points(life: &Tao2024, at_10_um: f64, largest: (f64, f64)) -> Vec<(f64, f64)> {
    let at_10_um = hours_at_10_um(life).map(|hours| (hours, at_10_um));
    // Without computed hours the points of the paper have no position.
    at_10_um.map_or(Vec::new(), |first| vec![first, largest])
}

fn rigid_over_life(life: &Tao2024) -> Plot {
    let mut plot = Plot::new(
        "Rigid discs: transmission error over the study",
        places(life),
        Axis::new("Size of the transmission error", "arcmin").from_zero(),
    )
    .noted(
        "Magnitude of the transmission error in arcmin with rigid discs; Figure 18 of [Tao2024]. Without load the output \
         moves freely within the clearance. The shaded band is the play due to uniform wear.",
    );
    plot.series.push(
        Series::band(
            "geometric clearance",
            life.levels.iter().map(|row| (place(life, row), 0.0, row.travel.play.arcmin())),
        )
        .coloured(Colour::Palette(6)),
    );
    type Quantity = (&'static str, fn(&Level) -> Option<MeanAndMax>, u8);
    let quantities: [Quantity; 2] = [("STE", Level::ste_rigid, 0), ("DTE", Level::dte_rigid, 1)];
    for (name, value, colour) in quantities {
        let means = over_hours(life, value, |v| v.mean);
        if means.is_empty() {
            continue;
        }
        plot.series.push(
            Series::new(format!("{name}, mean"), Style::LineMarkers, means)
                .coloured(Colour::Palette(colour))
                .strong(),
        );
        plot.series.push(
            Series::new(format!("{name}, largest"), Style::Dashed, over_hours(life, value, |v| v.max))
                .coloured(Colour::Palette(colour)),
        );
    }
    let starts: Vec<(f64, f64, f64)> = life
        .levels
        .iter()
        .filter_map(|row| {
            let spread = row.rigid.as_ref().and_then(|runs| runs.spread.as_ref());
            let means = || spread.iter().flat_map(|spread| &spread.runs).map(|run| run.mean_abs / ARCMIN);
            means().next()?;
            Some((place(life, row), means().fold(f64::INFINITY, f64::min), means().fold(0.0, f64::max)))
        })
        .collect();
    if !starts.is_empty() {
        plot.series.push(Series::band("STE means of other starts", starts).coloured(Colour::Palette(3)));
        plot.note.push_str(
            " The second band covers the means of runs from other starting positions within the clearance: \
             undamped rattling is chaotic, so a single mean is no result.",
        );
    }
    if is_its_machine(&life.machine) {
        plot.series.push(
            Series::markers("STE, Tao2024", paper_points(life, STE_MEAN_AT_10_UM, STE_LARGEST))
                .coloured(Colour::Palette(0)),
        );
        plot.series.push(
            Series::markers("DTE, Tao2024", paper_points(life, DTE_MEAN_AT_10_UM, DTE_LARGEST))
                .coloured(Colour::Palette(1)),
        );
    }
    plot
}

fn flexible_over_life(life: &Tao2024) -> Plot {
    let mut plot = Plot::new(
        "Rigid and elastic discs without load over the study",
        places(life),
        Axis::new("Size of the transmission error", "arcmin").from_zero(),
    )
    .noted(
        "Magnitude of the transmission error in arcmin without load; Figure 19 of [Tao2024]. Without load discs do not \
         deform: the means of both models differ only by undamped random rattling.",
    );
    plot.series.push(
        Series::new("rigid, mean", Style::LineMarkers, over_hours(life, |row| row.ste_rigid(), |v| v.mean))
            .coloured(Colour::Palette(0)),
    );
    plot.series.push(
        Series::new(
            "elastic, mean",
            Style::LineMarkers,
            over_hours(life, |row| row.ste_flexible(), |v| v.mean),
        )
        .coloured(Colour::Palette(2)),
    );
    plot.series.push(
        Series::new("elastic, largest", Style::Dashed, over_hours(life, |row| row.ste_flexible(), |v| v.max))
            .coloured(Colour::Palette(2)),
    );
    if is_its_machine(&life.machine) {
        plot.series.push(
            Series::markers("elastic, Tao2024", paper_points(life, FLEXIBLE_MEAN_AT_10_UM, FLEXIBLE_LARGEST))
                .coloured(Colour::Reference),
        );
    }
    plot
}

/// Transmission error under load with rigid and with elastic discs.
fn loaded_over_life(life: &Tao2024) -> Plot {
    let mut plot = Plot::new(
        "Rigid and elastic discs with sinusoidal load over the study",
        places(life),
        Axis::new("Size of the transmission error", "arcmin").from_zero(),
    )
    .noted("Mean and largest |TE| in arcmin under a sinusoidal load with rigid and with elastic discs. [Tao2024] has no such run.");
    type Quantity = (&'static str, fn(&Level) -> Option<MeanAndMax>, u8);
    let quantities: [Quantity; 2] = [("rigid", Level::dte_rigid, 0), ("elastic", Level::dte_flexible, 2)];
    for (name, value, colour) in quantities {
        for (part, style, of) in [
            ("mean", Style::LineMarkers, (|v| v.mean) as fn(MeanAndMax) -> f64),
            ("largest", Style::Dashed, |v| v.max),
        ] {
            plot.series.push(
                Series::new(format!("{name}, {part}"), style, over_hours(life, value, of))
                    .coloured(Colour::Palette(colour)),
            );
        }
    }
    plot
}

/// Value of a study at given hours, linear between its levels.
fn at_hours(points: &[(f64, f64)], hours: f64) -> Option<f64> {
    points.windows(2).find(|pair| pair[0].0 <= hours && hours <= pair[1].0).map(|pair| {
        let part = (hours - pair[0].0) / (pair[1].0 - pair[0].0);
        pair[0].1 + part * (pair[1].1 - pair[0].1)
    })
}

fn comparison(life: &Tao2024) -> Table {
    use crate::report::Column;
    let first = hours_at_10_um(life).unwrap_or(0.0);
    type Row = (&'static str, fn(&Level) -> Option<MeanAndMax>, f64, f64, f64);
    let rows: [Row; 6] = [
        ("STE, rigid, 10 µm", |row| row.ste_rigid(), first, STE_MEAN_AT_10_UM, 0.0),
        ("STE, rigid, 6450 h", |row| row.ste_rigid(), STE_LARGEST.0, STE_LARGEST.1, 0.0),
        ("DTE, rigid, 10 µm", |row| row.dte_rigid(), first, DTE_MEAN_AT_10_UM, DTE_EXCURSION_AT_10_UM),
        ("DTE, rigid, 6450 h", |row| row.dte_rigid(), DTE_LARGEST.0, DTE_LARGEST.1, 0.0),
        (
            "STE, elastic, 10 µm",
            |row| row.ste_flexible(),
            first,
            FLEXIBLE_MEAN_AT_10_UM,
            FLEXIBLE_MAX_AT_10_UM,
        ),
        ("STE, elastic, 7500 h", |row| row.ste_flexible(), FLEXIBLE_LARGEST.0, FLEXIBLE_LARGEST.1, 0.0),
    ];
    let or_dash = |value: f64| if value > 0.0 { format!("{value}") } else { "–".to_owned() };
    let plays: Vec<(f64, f64)> =
        life.levels.iter().map(|row| (place(life, row), row.travel.play.arcmin())).collect();
    let rows = rows
        .iter()
        .filter_map(|(name, value, hours, paper_mean, paper_max)| {
            let mean = at_hours(&over_hours(life, value, |v| v.mean), *hours)?;
            let max = at_hours(&over_hours(life, value, |v| v.max), *hours)?;
            let clearance = at_hours(&plays, *hours)
                .map_or_else(|| "–".to_owned(), |play| format!("±{}", significant(play, 3)));
            Some(vec![
                (*name).to_owned(),
                or_dash(*paper_mean),
                significant(mean, 3),
                or_dash(*paper_max),
                significant(max, 3),
                clearance,
            ])
        })
        .collect();
    Table {
        title: "Beside the paper's numbers".into(),
        columns: vec![
            Column::text("Quantity"),
            Column::number("Mean, Tao2024", "arcmin"),
            Column::number("Mean, here", "arcmin"),
            Column::number("Largest, Tao2024", "arcmin"),
            Column::number("Largest, here", "arcmin"),
            Column::number("Clearance allows", "arcmin"),
        ],
        rows,
        note:
            "Means and maxima of |TE| here; the paper does not say which mean it takes. Its curves are not \
             digitised: only values printed in its text are compared. Values here at 6450 h are interpolated \
             between the levels."
                .into(),
    }
}

/// One sentence on every difference.
fn differences(life: &Tao2024) -> Vec<String> {
    let at = |depth: f64| life.levels.iter().find(|row| (row.depth_um() - depth).abs() < 1e-6);
    let mut texts = Vec::new();
    if let Some(row) = at(10.0).filter(|row| row.ste_rigid().is_some()) {
        texts.push(format!(
            "Without load, rigid: uniform wear of 10 µm lets the output float by ±{} arcmin. Where in this band \
             it rattles depends on the smallest disturbance when nothing damps it, so a mean inside the band, \
             the paper's {STE_MEAN_AT_10_UM} arcmin as well as ours, is not a property of the machine; the band \
             is.",
            significant(row.travel.play.arcmin(), 3)
        ));
    }
    if let Some(row) =
        at(50.0).filter(|row| row.ste_rigid().is_some() && row.travel.play.arcmin() < STE_LARGEST.1)
    {
        texts.push(format!(
            "The paper's {} arcmin at {:.0} h (50 µm) lies outside the ±{} arcmin that this wear allows between \
             rigid teeth. It must contain something other than the worn shape: penetration of a soft contact, \
             the spline or the mesh of the contact curve, or a search that jumps between the two flanks of the \
             root.",
            STE_LARGEST.1,
            STE_LARGEST.0,
            significant(row.travel.play.arcmin(), 3)
        ));
    }
    if let Some(row) = at(10.0)
        .and_then(|row| row.dte_rigid().map(|dte| (row, dte)))
        .filter(|(row, dte)| dte.max > row.travel.play.arcmin())
    {
        let (row, dte) = row;
        texts.push(format!(
            "With the sinusoidal load the teeth are pressed to one flank and then to the other, so that |TE| \
             swings to the clearance plus the contact deflection: {} arcmin here. The paper's excursions of \
             about {DTE_EXCURSION_AT_10_UM} arcmin at 10 µm (clearance ±{} arcmin) would need teeth about {} \
             times softer; its small mean of {DTE_MEAN_AT_10_UM} arcmin is what remains when swings of both \
             signs cancel.",
            significant(dte.max, 3),
            significant(row.travel.play.arcmin(), 3),
            significant(
                (DTE_EXCURSION_AT_10_UM - row.travel.play.arcmin()) / (dte.max - row.travel.play.arcmin()),
                2
            )
        ));
    }
    if let Some(flexible) = at(10.0).and_then(|row| row.ste_flexible()) {
        texts.push(format!(
            "Elastic discs: without load nothing deforms it, so that its clearance is that of the rigid disc \
             and the mean here is {} arcmin. The paper finds {FLEXIBLE_MEAN_AT_10_UM} arcmin and explains it by \
             elasticity. A mesh of linear elements changes the play by as much as the wear studied: contact \
             with its edges takes play away (1 mm jams), contact at its nodes alone adds some (1.3 arcmin at 60 \
             µm and 2 mm). `arcmin simulate --flank faceted` and `--flank nodes` show it; neither reaches the \
             paper's figure.",
            significant(flexible.mean, 3)
        ));
    }
    if let Some((rigid, flexible)) = at(10.0).and_then(|row| Some((row.dte_rigid()?, row.dte_flexible()?))) {
        texts.push(format!(
            "Under the sinusoidal load the elastic disc swings to {} arcmin instead of {}: the difference is \
             the static compliance of its teeth and body.",
            significant(flexible.max, 3),
            significant(rigid.max, 3)
        ));
    }
    texts
}
