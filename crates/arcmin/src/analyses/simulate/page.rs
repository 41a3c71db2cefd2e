//! Terminal and report of a run.

use super::{Motion, Simulate};
use crate::analyses::TextBlock;
use crate::machine::RingPartner;
use crate::report::{
    Axis, Block, KeyFigure, Page, Plot, Provenance, Section, Series, Style, Tone, Verdict, significant,
};
use crate::units::{ARCMIN, DEG, UM};

const CHAOTIC: &str = "the motion of the unloaded machine is chaotic: only range and RMS are reproducible, not the \
     mean; a \
                       steady drag (--drag-nm 5) gives a well-defined mean";

pub(super) fn text_blocks(run: &Simulate) -> Vec<TextBlock> {
    text_blocks_of(heading(run), run)
}

/// The heading and the figures of a run.
pub(crate) fn text_blocks_of(heading: String, run: &Motion) -> Vec<TextBlock> {
    let mut blocks = vec![TextBlock::line(heading)];
    blocks.extend(run.notes.iter().map(TextBlock::line));
    if let Some(te) = run.result.statistics {
        blocks.push(TextBlock::line(format!(
            "TE  mean {:+.4}′   mean |TE| {:.4}′   max |TE| {:.4}′   peak to peak {:.4}′   RMS {:.4}′",
            te.mean / ARCMIN,
            te.mean_abs / ARCMIN,
            te.max_abs / ARCMIN,
            te.peak_to_peak / ARCMIN,
            te.rms / ARCMIN
        )));
    }
    // A run that ends before its window has no figures.
    if let Some(spread) = run.spread.as_ref().filter(|spread| !spread.runs.is_empty()) {
        blocks.push(TextBlock::line(format!(
            "{} perturbed starts: mean spreads over {:.4}′, RMS over {:.4}′, all within ±{:.4}′",
            spread.runs.len(),
            spread.mean / ARCMIN,
            spread.rms / ARCMIN,
            spread.band / ARCMIN
        )));
        if spread.is_chaotic() {
            blocks.push(TextBlock::line(CHAOTIC));
        }
    }
    blocks.push(TextBlock::line(format!(
        "{} steps in {:.2} s, energy residual {:.1e}",
        run.result.counts.accepted,
        run.wall,
        run.result.energy.residual()
    )));
    blocks
}

fn heading(run: &Simulate) -> String {
    let state = match (run.worn.hours, run.worn.deepest()) {
        (0.0, 0.0) => "new".to_owned(),
        (0.0, depth) => format!("{} µm off every flank", significant(depth / UM, 3)),
        (hours, _) => format!("after {hours:.0} h"),
    };
    format!("{}: {state}; {}", run.machine.name, run.fidelity.sentence())
}

pub(super) fn page(run: &Simulate) -> Page {
    let state = if run.worn.hours > 0.0 { "worn" } else { "as given" };
    page_of(run.machine.name.clone(), state, (run.fidelity.sentence(), RingPartner::Pins), run)
}

/// The page of a run of a named drive, new or worn, with a sentence about the model and its ring partner.
pub(crate) fn page_of(
    name: String,
    state: &str,
    (physics, ring): (String, RingPartner),
    run: &Motion,
) -> Page {
    let result = &run.result;
    let chaotic = run.spread.as_ref().is_some_and(|spread| spread.is_chaotic());
    let (tone, headline) = match (&run.broke_off, result.statistics) {
        (Some(reason), _) => (Tone::Bad, format!("The run broke off at {:.4} s: {reason}.", result.reached)),
        (None, None) => (Tone::Caution, "The run ended before its window began.".to_owned()),
        (None, Some(te)) => (
            if chaotic { Tone::Caution } else { Tone::Neutral },
            format!("Transmission error within ±{} arcmin.", significant(te.max_abs / ARCMIN, 3)),
        ),
    };
    let mut verdict = Verdict::new(tone, headline);
    if let Some(te) = result.statistics {
        let figure = |label: &str, value: f64, note: &str| {
            KeyFigure::new(label, significant(value / ARCMIN, 3), "arcmin", note)
        };
        verdict.figures = vec![
            figure("Mean", te.mean, "of θ_out − θ_in/i over the window"),
            figure("Mean of |TE|", te.mean_abs, "over the window"),
            figure("Peak to peak", te.peak_to_peak, "in the window"),
            figure("RMS", te.rms, "over the window"),
        ];
    }
    verdict.answers.push(("Which physics".to_owned(), physics));
    if !run.notes.is_empty() {
        verdict.answers.push(("Notes about the files".to_owned(), run.notes.join(". ") + "."));
    }
    if chaotic {
        verdict.answers.push(("Caution".to_owned(), CHAOTIC.to_owned()));
    }
    Page {
        title: name,
        subtitle: format!("Transmission error in time, {state}"),
        provenance: Provenance::default(),
        verdict,
        sections: vec![Section::new("motion", "Motion", blocks(run, ring))],
    }
}

fn blocks(run: &Motion, ring: RingPartner) -> Vec<Block> {
    let result = &run.result;
    // At most as many points as a screen has pixels.
    let stride = (result.series.len() / 4000).max(1);
    let over_time = |title: &str, axis: Axis, name: &str, value: fn(&crate::dynamics::Sample) -> f64| {
        let points = result.series.iter().step_by(stride).map(|s| (s.time, value(s)));
        let line = Series::line(name, points.collect::<Vec<_>>());
        Plot::new(title, Axis::new("Time", "s"), axis).with(line)
    };
    let te = Axis::new("Transmission error", "arcmin");
    let mut blocks = vec![
        Block::Plot(
            over_time("Transmission error", te, "θ_out − θ_in/i", |s| s.transmission_error / ARCMIN)
                .noted("Output angle less input angle over the ratio, in arcmin over time. A negative error is a lag of an output that turns in the positive direction. Statistics are those of the window."),
        ),
        Block::Plot(
            over_time("Output speed", Axis::new("Speed", "°/s"), "output", |s| s.output_speed / DEG)
                .noted("Speed of the output flange in °/s over time.")
                .half(),
        ),
        Block::Plot(
            over_time("Load", Axis::new("Torque", "N·m"), "load", |s| s.load)
                .noted("External torque at the output in N·m over time; positive against positive motion.")
                .half(),
        ),
    ];
    let force = Plot::new(
        format!("Largest {} force", ring.one()),
        Axis::new("Time", "s"),
        Axis::new("Force", "N").from_zero(),
    )
    .with(Series::line(
        format!("largest of all {}", ring.several()),
        result.forces.iter().map(|f| (f.time, f.forces.largest_pin_force)).collect::<Vec<_>>(),
    ))
    .noted(format!("Largest force in N of one {} on one disc at each time.", ring.one()))
    .half();
    blocks.push(Block::Plot(force));
    if let Some(lines) = &result.spectrum {
        let bars = lines.iter().take(400).map(|line| (line.order as f64, line.amplitude / ARCMIN));
        let spectrum = Plot::new(
            "Spectrum",
            Axis::new("Order of the output turn", ""),
            Axis::new("Amplitude", "arcmin"),
        )
        .with(Series::new("TE", Style::Bars, bars.collect::<Vec<_>>()))
        .noted("Amplitude in arcmin of each order of the transmission error; order 1 is one period per turn of the output.")
        .half();
        blocks.push(Block::Plot(spectrum));
    }
    blocks
}
