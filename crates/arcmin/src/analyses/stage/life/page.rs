//! Terminal output and report of the life of a drive of eccentrics.

use super::StageLife;
use crate::analyses::TextBlock;
use crate::analyses::life::{LimitKind, about, findings_section, limits};
use crate::analyses::stage::keys::main_of;
use crate::analyses::stage::wear::physics;
use crate::analyses::stage::worn::{self, HasWorn};
use crate::analyses::wear::stations;
use crate::life::LifePoint;
use crate::report::{
    Axis, Block, KeyFigure, Page, Plot, Provenance, Section, Series, Solids, Verdict, compact, literature,
    significant,
};
use crate::units::{ARCMIN, MPA, UM};

const COLUMNS: &[&str] = &[
    "hours",
    "max_depth_um",
    "play_arcmin",
    "lost_motion_arcmin",
    "te_loaded_arcmin",
    "max_force_n",
    "max_pressure_mpa",
];

pub(super) fn text_blocks(life: &StageLife) -> Vec<TextBlock> {
    let verdict = &life.verdict;
    let table = life.declared.1.fill(&life.times());
    let columns: Vec<&str> = COLUMNS.iter().copied().chain(worn::shown(life.facts.stages, life)).collect();
    let mut blocks: Vec<TextBlock> = life.made.text_blocks().into_iter().collect();
    blocks.extend([
        TextBlock::line(format!(
            "{}: {}",
            life.facts.name,
            physics(life.facts.stages, life.facts.ring, &life.made)
        )),
        TextBlock::line(format!("{} {}", verdict.mark(), verdict.headline())),
        TextBlock::Table(limits::text(verdict, None)),
    ]);
    blocks.extend(notes(life).into_iter().map(TextBlock::line));
    blocks.extend([TextBlock::line(""), TextBlock::columns(&table, &columns, stations(table.rows(), 7))]);
    blocks
}

/// Explanations of the table of limits, and of rigid discs if they were chosen.
fn notes(life: &StageLife) -> Vec<String> {
    limits::notes(life).into_iter().chain(life.about_discs.clone()).collect()
}

pub(super) fn page(life: &StageLife) -> Page {
    let (verdict, demanded) = (&life.verdict, &life.demands.limits);
    let mut words = Verdict::new(verdict.tone(), verdict.headline());
    let last = life.last();
    let is_kept = |kind: LimitKind| verdict.limit(kind).is_none_or(|limit| limit.is_kept(verdict.service_h));
    words.figures = vec![
        KeyFigure::new(
            "Lost motion",
            significant(last.lost_motion.arcmin(), 3),
            "arcmin",
            format!(
                "after {:.0} h; new {}, limit {}",
                last.hours(),
                significant(life.first().lost_motion.arcmin(), 3),
                significant(demanded.lost_motion / ARCMIN, 3)
            ),
        )
        .kept(is_kept(LimitKind::LostMotion)),
        KeyFigure::new(
            "First limit",
            verdict.hours_to_limit().map_or("none".to_owned(), about),
            "h",
            verdict.limited_by().map_or("within what was computed", |limit| limit.kind.name()),
        )
        .kept(verdict.ok()),
    ];
    for stage in 0..life.rings.len() {
        let place = if life.rings.len() > 1 { format!(", {}", life.title(stage)) } else { String::new() };
        let depth = significant(life.accuracy(stage).max_depth / UM, 3);
        let note = format!("largest depth lost by a flank{place}");
        words.figures.push(KeyFigure::new("Deepest wear", depth, "µm", note));
    }
    words.answers.push(("Which physics".to_owned(), physics(life.facts.stages, life.facts.ring, &life.made)));
    let over = |title: &str, axis: Axis, rings: &[usize], value: fn(&LifePoint) -> f64, note: &str| {
        let name = axis.label.to_lowercase();
        let mut plot = Plot::new(title, Axis::new("Running time", "h"), axis).noted(note).half();
        for ring in rings {
            let points = life.rings[*ring].1.points.iter();
            let points: Vec<(f64, f64)> = points.map(|point| (point.hours(), value(point))).collect();
            let name = if rings.len() > 1 { life.title(*ring).to_owned() } else { name.clone() };
            plot = plot.with(Series::line(name, points));
        }
        Block::Plot(plot)
    };
    let whole = &[main_of(life.facts.stages)][..];
    let every: Vec<usize> = (0..life.rings.len()).collect();
    let mut accuracy = vec![
        over(
            "Lost motion",
            Axis::new("Lost motion", "arcmin").from_zero(),
            whole,
            |point| point.lost_motion.arcmin(),
            "Lost motion at ±3 % of the rated torque, computed without friction.",
        ),
        over(
            "Play",
            Axis::new("Play", "arcmin").from_zero(),
            whole,
            |point| point.travel.map_or(0.0, |travel| travel.free_travel.arcmin()),
            "Two-sided play at the output without load, input held.",
        ),
        over(
            "Transmission error",
            Axis::new("Error", "arcmin").from_zero(),
            whole,
            |point| point.accuracy.loaded_peak_to_peak.arcmin(),
            "Peak-to-peak transmission error at rated torque over one full period.",
        ),
        over(
            "Largest pressure",
            Axis::new("Pressure", "MPa").from_zero(),
            &every,
            |point| point.accuracy.max_pressure / MPA,
            &format!(
                "Hertz pressure at {}, at the largest torque of rating and duty.",
                life.facts.ring.all_of_ring()
            ),
        ),
        over(
            "Deepest wear",
            Axis::new("Depth", "µm").from_zero(),
            &every,
            |point| point.accuracy.max_depth / UM,
            "Largest depth lost by a flank.",
        ),
    ];
    accuracy.extend(worn::parts_plot(&life.facts, &life.times()));
    let of_bearings = "Loads of the new drive over a turn of the input, without friction, rows of the duty by their damage [ISO281].";
    let solids = Block::Solids(Solids {
        title: life.facts.name.clone(),
        note: format!(
            "Contact forces of static equilibria at {} N·m; the arrows act on the discs, their lines of action meet in the pitch \
             point of each ring. {}",
            compact(life.demands.rated_torque, 4),
            life.scene.assumed
        ),
        scene: life.scene.clone(),
        states: life.pictures.clone(),
        instead: None,
    });
    let code = Block::Code { title: "Design".to_owned(), text: life.design_text.clone() };
    Page {
        title: life.facts.name.clone(),
        subtitle: format!("Life of a {}", life.facts.family.drive()),
        provenance: Provenance::default(),
        verdict: words,
        sections: vec![
            Section::new("limits", "Limits", limits::blocks(life, None, &notes(life), of_bearings)),
            Section::new("accuracy", "Accuracy over life", accuracy),
            Section::new("mechanism", "Mechanism and contact forces", vec![solids]),
            findings_section(&life.findings),
            Section::new("design", "Design as used", vec![code]),
            literature(&["Archard1953", "Johnson1985", "Harris2006", "ISO281"]),
        ],
    }
}
