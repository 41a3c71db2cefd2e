//! Terminal and report of wear.

use super::declared::HISTORY;
use super::{Mode, Wear, WearOverHours};
use crate::analyses::TextBlock;
use crate::geometry::Relief;
use crate::machine::RingPartner;
use crate::report::{
    Axis, Block, Colour, KeyFigure, Page, Plot, Provenance, Section, Series, Tone, Verdict, significant,
};
use crate::units::{DEG, UM};

pub(in crate::analyses) const COLUMNS: &[&str] = &[
    "hours",
    "max_depth_um",
    "max_depth_at_deg",
    "play_arcmin",
    "te_loaded_arcmin",
    "max_force_n",
    "loaded_pairs",
];

/// At most `most` indices of `count`, equidistant, with the first and the last among them.
pub(crate) fn stations(count: usize, most: usize) -> impl Iterator<Item = usize> {
    let last = count.saturating_sub(1);
    let shown = most.saturating_sub(1).min(last).max(1);
    (0..=shown).map(move |index| last * index / shown).take(count)
}

/// Largest depth of one ring in words.
pub(in crate::analyses) fn depth_of(wear: &WearOverHours) -> String {
    let last = wear.last();
    let depth = significant(last.accuracy.max_depth / UM, 3);
    let Some(angle) = last.worst_angle().map(|at| at / DEG) else { return "no metal lost".to_owned() };
    match wear.mode {
        Mode::Coupled => format!("{depth} µm at {angle:.0}° meshing angle"),
        Mode::Tao2024 => format!("{depth} µm everywhere, set by the pin at {angle:.0}°"),
    }
}

/// `how` describes the depth of wear of the flanks.
fn headline(wear: &WearOverHours, how: &str, ring: RingPartner) -> String {
    let last = wear.last();
    let play = last.travel.play.arcmin();
    let now = format!("After {:.0} h: {how}, one-sided play {play:.3}′.", last.hours());
    match wear.runs_away {
        Some(end) => format!(
            "Wear runs away at {} h: the depth of flank or {} is {:.0} µm, and the drive is unusable. {now}",
            significant(end.hours, 3),
            ring.one(),
            end.depth / UM
        ),
        None => now,
    }
}

pub(super) fn text_blocks(wear: &Wear) -> Vec<TextBlock> {
    let table = HISTORY.fill(&wear.stations);
    let shown = TextBlock::columns(&table, COLUMNS, stations(table.rows(), 7));
    text_blocks_of(wear, (&wear.fidelity.sentence(), RingPartner::Pins), &depth_of(wear), shown)
}

/// `physics` describes the model in a sentence, `ring` is the partner of the discs, `how` describes the depth
/// of wear of the flanks, `history` contains some hours.
pub(in crate::analyses) fn text_blocks_of(
    wear: &WearOverHours,
    (physics, ring): (&str, RingPartner),
    how: &str,
    history: TextBlock,
) -> Vec<TextBlock> {
    let k = wear.exposure.coefficient;
    vec![
        TextBlock::line(format!("{}: {physics}", wear.name)),
        history,
        TextBlock::line(format!("{} k = {k:.3e} 1/Pa = {:.3e} mm²/N", headline(wear, how, ring), k * 1e6)),
    ]
}

pub(super) fn page(wear: &Wear) -> Page {
    page_of(wear, (&wear.fidelity.sentence(), RingPartner::Pins), &depth_of(wear))
}

/// As [`text_blocks_of`].
pub(in crate::analyses) fn page_of(
    wear: &WearOverHours,
    (physics, ring): (&str, RingPartner),
    how: &str,
) -> Page {
    let last = wear.last();
    let tone = if wear.runs_away.is_some() { Tone::Bad } else { Tone::Neutral };
    let mut verdict = Verdict::new(tone, headline(wear, how, ring));
    let figure = |label: &str, value: f64, unit: &str, note: &str| {
        KeyFigure::new(label, significant(value, 3), unit, note)
    };
    verdict.figures = vec![
        figure("Deepest wear", last.accuracy.max_depth / UM, "µm", "largest depth lost by a flank"),
        figure("Play", last.travel.play.arcmin(), "arcmin", "one-sided, at the output, input locked"),
        figure(
            "Largest force",
            last.max_force(),
            "N",
            &format!("of one {} on one disc at rated torque", ring.one()),
        ),
    ];
    verdict.answers.push(("Which physics".to_owned(), physics.to_owned()));
    let over = |title: &str, axis: Axis, value: &dyn Fn(&super::Station) -> f64, note: &str| {
        let points: Vec<(f64, f64)> = wear.stations.iter().map(|s| (s.hours(), value(s))).collect();
        let name = axis.label.to_lowercase();
        Plot::new(title, Axis::new("Running time", "h"), axis)
            .with(Series::line(name, points))
            .noted(note)
            .half()
    };
    let mut flank = Plot::new(
        "Depth along the flank",
        Axis::new("Meshing angle", "°").between(-180.0, 180.0),
        Axis::new("Depth", "µm").from_zero(),
    )
    .noted(match wear.profile.tip() {
        None => "Wear depth in µm along the flank of the disc with the deepest wear, at several times.".to_owned(),
        Some(tip) => format!(
            "Wear depth in µm along the flank of the disc with the deepest wear, at several times. The flank ends at the corners of the tip, at ±{:.1}°.",
            tip.end / DEG
        ),
    });
    let count = wear.stations.len();
    for index in stations(count, 6) {
        let station = &wear.stations[index];
        let depths = station.state.surfaces.flank().samples();
        let points: Vec<(f64, f64)> =
            Relief::grid(depths.len()).zip(depths).map(|(phi, depth)| (phi / DEG, depth / UM)).collect();
        let colour = Colour::Ordered(index as f64 / count.saturating_sub(1).max(1) as f64);
        flank.series.push(Series::line(format!("{:.0} h", station.hours()), points).coloured(colour));
    }
    let blocks = vec![
        Block::Plot(flank),
        Block::Plot(over(
            "Deepest wear",
            Axis::new("Depth", "µm").from_zero(),
            &|s| s.accuracy.max_depth / UM,
            "Largest wear depth of a flank over the running time.",
        )),
        Block::Plot(over(
            "Play",
            Axis::new("Play", "arcmin"),
            &|s| s.travel.play.arcmin(),
            "One-sided play at the output without load, input locked. Negative values are interference.",
        )),
        Block::Plot(over(
            "Largest force",
            Axis::new("Force", "N").from_zero(),
            &|s| s.max_force(),
            &format!("Largest force of one {} on one disc at rated torque.", ring.one()),
        )),
    ];
    Page {
        title: wear.name.clone(),
        subtitle: "Wear of the flanks".to_owned(),
        provenance: Provenance::default(),
        verdict,
        sections: vec![Section::new("wear", "Wear", blocks)],
    }
}
