//! Figures of the test bench, in the order in which they are read.

use super::{MeasuredOnBench, RigState};
use crate::report::{
    Annotation, Axis, Block, Colour, Column, Plot, Series, Shares, Style, Table, Tone, compact, significant,
};
use crate::rig::{Branch, ErrorCurve, LOST_MOTION_SHARE, LoopFigures, LoopPoint, STIFFNESS_WINDOW};
use crate::units::ARCMIN;

/// Loops of a machine in one state, with their figures.
pub(crate) struct Loops<'a> {
    /// Name of the state.
    pub name: String,
    /// One loop per crank position.
    pub loops: &'a [Vec<LoopPoint>],
    /// In the same order.
    pub figures: &'a [LoopFigures],
}

/// Loops to ± rated torque (N·m) of every state and the measured one: whole, and near zero torque.
pub(crate) fn hysteresis(rated: f64, states: &[Loops<'_>], measured: Option<&MeasuredOnBench>) -> Vec<Block> {
    let build = |title: &str, window: f64, note: String| {
        let axis = Axis::new("Output torque, input locked", "N·m").between(-window, window);
        let mut plot = Plot::new(title, axis, Axis::new("Angle of the output", "arcmin")).half().noted(note);
        // Both branches in one series in the order of the test; points outside the window are gaps.
        let points = |one: &[LoopPoint], shift: f64| -> Vec<(f64, f64)> {
            let shifted = |p: &LoopPoint| {
                if p.torque.abs() <= 1.0001 * window { (p.angle + shift) / ARCMIN } else { f64::NAN }
            };
            one.iter().map(|p| (p.torque.clamp(-window, window), shifted(p))).collect()
        };
        for (index, state) in states.iter().enumerate() {
            if let Some(one) = state.loops.first() {
                plot.series.push(
                    Series::line(state.name.clone(), points(one, 0.0))
                        .coloured(Colour::Palette(index as u8))
                        .strong(),
                );
            }
        }
        if let (Some(measured), Some(state)) = (measured.and_then(|m| m.loops.first()), states.last()) {
            // A measured angle has an arbitrary zero: it is shifted to the middle of the computed loop.
            let middle = |one: &[LoopPoint]| middle(one, rated);
            let shift = state.loops.first().map_or(0.0, |one| middle(one)) - middle(&measured.points);
            let every = measured.rows.len().div_ceil(MOST_MARKERS);
            let rows: Vec<LoopPoint> = measured.rows.iter().step_by(every).copied().collect();
            plot.series.push(Series::markers("measured", points(&rows, shift)).coloured(Colour::Reference));
        }
        plot
    };
    let (low, high) = (STIFFNESS_WINDOW.0 * rated, STIFFNESS_WINDOW.1 * rated);
    let count = states.last().map_or(0, |state| state.figures.len());
    let mut whole = build(
        "Hysteresis loop",
        1.05 * rated,
        format!(
            "Output angle in arcmin over output torque in N·m with the input locked, at the first of {count} positions of the input. The torsional stiffness is the slope within the shaded ranges, {} to {} N·m.",
            compact(low, 4),
            compact(high, 4)
        ),
    );
    for (from, to) in [(-high, -low), (low, high)] {
        whole.annotations.push(Annotation::Span { from, to, label: String::new() });
    }
    let reading = LOST_MOTION_SHARE * rated;
    let mut close = build(
        "The same near zero torque",
        3.0 * reading,
        "Output angle in arcmin over output torque in N·m with the input locked, near zero torque. Lost motion is the angle between the mid-points of both branches at +3 % and at −3 % of the rated torque. Backlash \
         is the width of the loop at zero torque [GBT35089]."
            .into(),
    );
    for (at, label) in [(-reading, "−3 %"), (reading, "+3 %")] {
        close.annotations.push(Annotation::Vertical { at, label: label.into(), tone: Tone::Neutral });
    }
    vec![Block::Plot(whole), Block::Plot(close)]
}

/// Rows of a measured loop that are drawn.
const MOST_MARKERS: usize = 1500;

/// Mean angle of both branches at ± 3 % of rated torque, rad.
fn middle(points: &[LoopPoint], rated: f64) -> f64 {
    let mut sum = 0.0;
    let mut count = 0;
    for branch in [Branch::Falling, Branch::Rising] {
        let one: Vec<&LoopPoint> = points.iter().filter(|p| p.branch == branch).collect();
        for target in [-LOST_MOTION_SHARE * rated, LOST_MOTION_SHARE * rated] {
            if let Some(near) =
                one.iter().min_by(|a, b| (a.torque - target).abs().total_cmp(&(b.torque - target).abs()))
            {
                sum += near.angle;
                count += 1;
            }
        }
    }
    sum / f64::from(count.max(1))
}

/// Places of a measured transmission error that are drawn.
const MOST_PLACES: usize = 20_000;

/// Figures of the loops, with their spread over the crank positions.
pub(crate) fn loop_figures(states: &[Loops<'_>], measured: Option<&MeasuredOnBench>) -> Block {
    let mut columns = vec![Column::text("Figure")];
    columns.extend(states.iter().map(|state| Column::number(state.name.clone(), "")));
    let measured = measured.filter(|m| !m.loops.is_empty());
    columns.extend(measured.map(|_| Column::number("measured", "")));
    let rows: [(&str, f64, fn(&LoopFigures) -> f64); 6] = [
        ("Lost motion, arcmin", 1.0 / ARCMIN, |f| f.lost_motion),
        ("Backlash, arcmin", 1.0 / ARCMIN, |f| f.backlash),
        ("Torsional stiffness 50–100 %, N·m/arcmin", ARCMIN, |f| f.stiffness),
        ("Torsional stiffness 3–15 %, N·m/arcmin", ARCMIN, |f| f.soft_stiffness),
        ("Torsional stiffness 15–50 %, N·m/arcmin", ARCMIN, |f| f.middle_stiffness),
        ("Work lost in one loop, J", 1.0, |f| f.work.abs()),
    ];
    let cell = |figures: &[LoopFigures], unit: f64, of: fn(&LoopFigures) -> f64| {
        let values: Vec<f64> = figures.iter().map(|f| unit * of(f)).collect();
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let (low, high) =
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let (mean, low, high) = (significant(mean, 3), significant(low, 3), significant(high, 3));
        if low == high { mean } else { format!("{mean} ({low} to {high})") }
    };
    Block::Table(Table {
        title: "Read from the loops".into(),
        columns,
        rows: rows
            .into_iter()
            .map(|(name, unit, of)| {
                let mut row = vec![name.to_owned()];
                row.extend(states.iter().map(|state| cell(state.figures, unit, of)));
                row.extend(measured.and_then(|m| m.figure(of)).map(|(value, uncertainty)| {
                    let value = unit * value;
                    // The sign of the work depends on the direction of the loop.
                    let value = if name.starts_with("Work") { value.abs() } else { value };
                    format!("{} ± {}", significant(value, 3), significant(unit * uncertainty, 2))
                }));
                row
            })
            .collect(),
        note: "Mean over the positions of the input, with the lowest and the highest value in brackets. Measured \
             loops are read by the same code; ± is the half width of \
               the 95 % interval from noise, repetitions and spacing of the measured points."
            .into(),
    })
}

pub(super) fn stiffness_split(state: &RigState) -> Block {
    let split = &state.split;
    // Rigid parts have no compliance and are omitted.
    let there = split.parts.iter().filter(|(_, compliance)| *compliance > 1e-6 * split.whole);
    // The block adds the shares.
    let rows = there.map(|(part, c)| (part.name().to_owned(), 1e3 * c / ARCMIN, String::new())).collect();
    let rigid: Vec<&str> =
        split.parts.iter().filter(|(_, c)| *c <= 1e-6 * split.whole).map(|(part, _)| part.name()).collect();
    let rigid = if rigid.is_empty() {
        String::new()
    } else {
        format!(" Rigid or without effect here: {}.", rigid.join(", "))
    };
    let sum: f64 = split.parts.iter().map(|part| part.1).sum();
    let at = match split.positions {
        1 => "at the first crank position".to_owned(),
        count => format!("in the mean of {count} crank positions"),
    };
    Block::Shares(Shares {
        title: "Compliance by parts, 50 to 100 % of rated torque".into(),
        unit: "arcmin per kN·m".into(),
        rows,
        note: format!(
            "Share of each part in the elastic energy gᵀKg of the motion per unit torque {at}, without friction. The parts add up to {} % of the \
             compliance between two balances, {} N·m/arcmin.{rigid}",
            significant(100.0 * sum / split.whole, 4),
            significant(ARCMIN / split.whole, 4)
        ),
    })
}

pub(super) fn transmission(state: &RigState, measured: Option<&MeasuredOnBench>) -> Vec<Block> {
    let mut plot = Plot::new(
        "Transmission error of one output turn, about its mean",
        Axis::new("Output angle", "°").between(0.0, 360.0),
        Axis::new("θ_out − θ_in/i", "arcmin"),
    );
    let name = |c: &ErrorCurve| {
        let way = if c.direction > 0.0 { "forward" } else { "backward" };
        format!("{way}, {} N·m", significant(c.torque, 3))
    };
    let about_mean = |c: &ErrorCurve| -> Vec<(f64, f64)> {
        let (mean, first) = (c.mean(), c.points.first().map_or(0.0, |p| p.0));
        c.points
            .iter()
            .map(|(angle, error)| ((angle - first).to_degrees().abs(), (error - mean) / ARCMIN))
            .collect()
    };
    let row = |c: &ErrorCurve| {
        vec![name(c), significant(c.mean() / ARCMIN, 3), significant(c.peak_to_peak() / ARCMIN, 3)]
    };
    let mut rows = Vec::new();
    for (index, curve) in state.curves.iter().enumerate() {
        // The curves at rated torque are hidden initially.
        let mut series = Series::line(name(curve), about_mean(curve)).coloured(Colour::Palette(index as u8));
        series.hidden = index >= 2;
        plot.series.push(series);
        rows.push(row(curve));
    }
    let measured = measured.filter(|m| !m.curves.is_empty());
    for one in measured.iter().flat_map(|m| &m.curves) {
        let name = format!("measured, {}", name(&one.curve));
        let every = one.curve.points.len().div_ceil(MOST_PLACES);
        let line = about_mean(&one.curve).into_iter().step_by(every);
        plot.series.push(Series::line(name.clone(), line).coloured(Colour::Reference).strong());
        let (value, uncertainty) = (one.peak_to_peak / ARCMIN, one.peak_to_peak_uncertainty / ARCMIN);
        let shown = format!("{} ± {}", significant(value, 3), significant(uncertainty, 2));
        rows.push(vec![name, "–".into(), shown]);
    }
    plot.note =
        "Output angle less input angle over the ratio, less its mean, in arcmin over one turn of the output; every curve begins at its first angle. Click the legend to show the curves at rated torque."
            .into();
    let values = Table {
        title: "Transmission error".into(),
        columns: vec![Column::text("Test"), Column::number("Mean", "arcmin"), Column::number("Peak to peak", "arcmin")],
        rows,
        note: "The mean contains the wind-up under load and half of the lost motion; the mean of a measured curve has no reference. ± is the half width of the 95 % \
               interval; the peak to peak of a measured turn does not contain its noise."
            .into(),
    };
    let mut spectrum = Plot::new(
        "Spectrum, forward",
        Axis::new("Order of the output turn", ""),
        Axis::new("Amplitude", "arcmin").from_zero(),
    );
    let last = state.orders.iter().map(|o| o.order).fold(200, usize::max);
    let bars = |lines: &[crate::dynamics::SpectrumLine]| -> Vec<(f64, f64)> {
        lines
            .iter()
            .filter(|line| (1..=last + 20).contains(&line.order))
            .map(|line| (line.order as f64, line.amplitude / ARCMIN))
            .collect()
    };
    spectrum.series.push(Series::new("computed", Style::Bars, bars(&state.spectrum)));
    if let Some(m) = measured.filter(|m| !m.spectrum.is_empty()) {
        spectrum
            .series
            .push(Series::new("measured", Style::Bars, bars(&m.spectrum)).coloured(Colour::Reference));
    }
    spectrum.note =
        "Amplitude in arcmin of each order of the transmission error at rated torque, forward; order 1 is one period per turn of the output. A measured curve is shown at its own torque.".into();
    for named in state.orders.iter().take(4) {
        spectrum.annotations.push(Annotation::Point {
            x: named.order as f64,
            y: named.amplitude / ARCMIN,
            label: named.order.to_string(),
        });
    }
    let arcsec = |angle: f64, digits: usize| significant(60.0 * angle / ARCMIN, digits);
    let table = |title: &str, orders: &[(crate::rig::NamedOrder, Option<f64>)], note: &str| {
        let amplitude = |(o, uncertainty): &(crate::rig::NamedOrder, Option<f64>)| match uncertainty {
            Some(uncertainty) => format!("{} ± {}", arcsec(o.amplitude, 3), arcsec(*uncertainty, 2)),
            None => arcsec(o.amplitude, 3),
        };
        Block::Table(Table {
            title: title.into(),
            columns: vec![
                Column::number("Order", ""),
                Column::number("Amplitude", "arcsec"),
                Column::text("Likely causes"),
            ],
            rows: orders
                .iter()
                .map(|o| vec![o.0.order.to_string(), amplitude(o), o.0.cause.clone()])
                .collect(),
            note: note.into(),
        })
    };
    let mut blocks = vec![
        Block::Plot(plot),
        Block::Table(values),
        Block::Plot(spectrum),
        table(
            "Strongest orders",
            &state.orders.iter().map(|order| (order.clone(), None)).collect::<Vec<_>>(),
            "One turn resolves whole orders only: where several causes share an order, all are named. With the housing at rest, errors of the ring \
             lie at multiples of z_c; errors that rotate with carrier, discs and shafts lie at multiples of z_p.",
        ),
    ];
    if let Some(m) = measured.filter(|m| !m.orders.is_empty()) {
        blocks.push(table(
            "Strongest orders, measured",
            &m.orders.iter().map(|(order, doubt)| (order.clone(), Some(*doubt))).collect::<Vec<_>>(),
            "Of the first measured curve that covers a whole turn. ± is the half width of the 95 % interval, from the noise between the orders.",
        ));
    }
    blocks
}

pub(super) fn bearings(state: &RigState) -> Vec<Block> {
    let axis = Axis::new("Turn of the crankshaft", "°").between(0.0, 360.0);
    let mut plot =
        Plot::new("Bearing forces at rated torque", axis, Axis::new("Radial force", "N").from_zero());
    for bearing in &state.bearings {
        let step = 360.0 / bearing.forces.len().max(1) as f64;
        // The first point again at the end of the turn.
        let points = bearing
            .forces
            .iter()
            .chain(bearing.forces.first())
            .enumerate()
            .map(|(i, f)| (step * i as f64, *f));
        plot.series.push(Series::line(bearing.name.clone(), points));
    }
    plot.note = "Radial force in N on every bearing at rated torque over one turn of the crankshaft relative to the carrier. Opposite bearings carry the same force half a turn apart.".into();
    let row = |b: &crate::rig::BearingLoad| {
        let largest = b.forces.iter().fold(0.0, |a: f64, f| a.max(*f));
        let mut cells = vec![b.name.clone()];
        cells.extend(
            [b.mean_force(), largest, b.largest_element, b.equivalent, b.rating / 1e3, b.life_h()]
                .map(|value| significant(value, 3)),
        );
        cells
    };
    let table = Table {
        title: "Basic rating life".into(),
        columns: vec![
            Column::text("Bearing"),
            Column::number("Mean force", "N"),
            Column::number("Largest force", "N"),
            Column::number("Largest roller", "N"),
            Column::number("Equivalent load P", "N"),
            Column::number("Rating C", "kN"),
            Column::number("L10h", "h"),
        ],
        rows: state.bearings.iter().map(row).collect(),
        note: "[ISO281], at rated torque and speed throughout, without the axial load of tapered rollers and without life modification factors."
            .into(),
    };
    vec![Block::Plot(plot), Block::Table(table)]
}
