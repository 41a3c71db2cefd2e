//! Terminal and report of a life.

use super::verdict::{LimitKind, about};
use super::{Life, declared, figures, limits};
#[cfg(test)]
use crate::analyses::Outcome;
use crate::analyses::wear::stations;
use crate::analyses::{TextBlock, causes};
use crate::checks::{Finding, Severity, worst};
use crate::fidelity::Joints;
use crate::report::{
    Block, Column, KeyFigure, Page, Provenance, Section, Table, Tone, Verdict, capitalised, compact,
    findings_table, literature, significant,
};
use crate::units::{ARCMIN, HOUR};

const COLUMNS: &[&str] = &[
    "hours",
    "max_depth_um",
    "play_arcmin",
    "lost_motion_arcmin",
    "te_loaded_arcmin",
    "ste_max_arcmin",
    "dte_max_arcmin",
    "max_force_n",
    "max_pressure_mpa",
];

pub(super) fn text_blocks(life: &Life) -> Vec<TextBlock> {
    let verdict = &life.verdict;
    let mut blocks = vec![
        TextBlock::line(format!("{}: {}", life.machine.name, life.fidelity.sentence())),
        TextBlock::line(format!("{} {}", verdict.mark(), verdict.headline())),
        TextBlock::Table(limits::text(verdict, life.with_elastic_bodies.judged())),
    ];
    blocks.extend(limits::notes(life).into_iter().chain(limits::about_bodies(life)).map(TextBlock::line));
    blocks.push(TextBlock::line(""));
    let table = declared::life_table(life, &life.ages);
    blocks.push(TextBlock::columns(&table, &shown_columns(life), shown_rows(life)));
    blocks.extend(limits::places(life).map(TextBlock::line));
    blocks.push(TextBlock::line(""));
    blocks
        .extend(life.causes_over_hours().last().map(|at| causes::text_blocks(at, None)).unwrap_or_default());
    if !life.advice.is_empty() {
        blocks.push(TextBlock::line("what to change first:"));
        blocks.extend(life.advice.iter().map(|advice| TextBlock::line(format!("  {}", advice.text))));
    }
    if let Some(text) = rattling(life) {
        blocks.push(TextBlock::line(text));
    }
    blocks
}

/// Ages in the table: new, the simulated ages, the end; without simulations some intermediate points.
fn shown_rows(life: &Life) -> Vec<usize> {
    match life.ages.is_empty() {
        true => stations(life.prediction.points.len(), 7).collect(),
        false => life.ages.iter().map(|age| age.point).collect(),
    }
}

fn shown_columns(life: &Life) -> Vec<&'static str> {
    let simulated = !life.ages.is_empty();
    COLUMNS.iter().copied().filter(|key| simulated || !key.contains("te_max")).collect()
}

/// Warning about an undamped run without load.
fn rattling(life: &Life) -> Option<String> {
    let undamped = !life.ages.is_empty() && super::ages::rattles(&life.machine);
    undamped.then(|| {
        "STE: without load and drag the output rattles freely within its play; its mean depends on the start, so \
         that mean and largest error are those of one run, the play is the machine's."
            .to_owned()
    })
}

pub(in crate::analyses) fn findings_section(findings: &[Finding]) -> Section {
    let block = match worst(findings) {
        Severity::Info => Block::Text(format!("All {} checks of the design are passed.", findings.len())),
        _ => findings_table(findings),
    };
    Section::new("findings", "Findings on the design", vec![block])
}

pub(super) fn page(life: &Life) -> Page {
    let machine = &life.machine;
    let notes = limits::notes(life).into_iter().chain(limits::about_bodies(life));
    let words: Vec<String> = notes.chain(limits::places(life)).collect();
    let of_bearings =
        "Loads of the new machine over a turn of the crankshafts, rows of the duty by their damage [ISO281].";
    let mut sections = vec![
        Section::new(
            "limits",
            "Limits",
            limits::blocks(life, life.with_elastic_bodies.judged(), &words, of_bearings),
        ),
        Section::new("accuracy", "Accuracy over life", figures::accuracy(life)),
        causes::section(&life.causes_over_hours()),
        Section::new("wear", "Wear", figures::wear(life)),
        Section::new("load", "Load sharing", figures::load(life)),
    ];
    if let Some(at) = life.causes_over_hours().last() {
        sections[2].blocks.push(causes::shares(at, None));
    }
    if !life.ages.is_empty() {
        sections.push(Section::new(
            "simulation",
            "Transmission error in motion",
            figures::motion(life, rattling(life)),
        ));
    }
    sections.push(Section::new("mechanism", "Mechanism and contact forces", figures::mechanism(life)));
    sections.extend(life.elastic.clone());
    sections.push(findings_section(&life.findings));
    let code = Block::Code { title: "Design".to_owned(), text: life.design_text.clone() };
    sections.push(Section::new("design", "Design as used", vec![code]));
    let cited = ["Archard1953", "Johnson1985", "Harris2006", "ISO281", "ISO76", "GBT40731"];
    sections.push(literature(&cited));
    Page {
        title: machine.name.clone(),
        subtitle: format!("Accuracy over {} h of service", compact(machine.limits.service_life / HOUR, 4)),
        provenance: Provenance::default(),
        verdict: verdict(life),
        sections,
    }
}

fn verdict(life: &Life) -> Verdict {
    let judged = &life.verdict;
    let mut verdict = Verdict::new(judged.tone(), judged.headline());
    let service = judged.service_h;
    let (new, end) = (life.first(), life.last());
    let allowed = life.machine.limits.lost_motion / ARCMIN;
    let lost = |point: &crate::life::LifePoint| significant(point.lost_motion.arcmin(), 3);
    let kept = |kind: LimitKind| judged.limit(kind).is_none_or(|limit| limit.is_kept(service));
    let planned = format!("{service:.0} h planned");
    verdict.figures = vec![
        match judged.limited_by() {
            Some(limit) => {
                let band = limit.band.as_ref().filter(|band| !band.is_point());
                let band = band.map_or_else(String::new, |band| format!("{}; ", band.words()));
                let note = match limit.kind {
                    LimitKind::BearingLife => {
                        format!("{band}L10, {}; {planned}", limit.place.as_deref().unwrap_or_default())
                    }
                    kind => format!("{band}until {} ends it; {planned}", kind.name()),
                };
                KeyFigure::new("Life", about(limit.hours.unwrap_or(0.0)), "h", note)
                    .kept(limit.is_kept(service))
            }
            None => KeyFigure::new("Life", format!("> {}", about(judged.searched_h)), "h", planned),
        },
        KeyFigure::new(
            "Lost motion, new",
            lost(new),
            "arcmin",
            "the whole machine in its bearings, at ±3 % of rated torque",
        )
        .kept(new.lost_motion.arcmin() <= allowed),
        KeyFigure::new(
            format!("After {:.0} h", end.hours()),
            lost(end),
            "arcmin",
            format!("lost motion; {} arcmin allowed", compact(allowed, 3)),
        )
        .kept(kept(LimitKind::LostMotion)),
    ];
    // If bearings end the life, the first figure contains it already.
    let is_shown = judged.limited_by().is_some_and(|limit| limit.kind == LimitKind::BearingLife);
    if let Some(worst) = life.bearings.worst().filter(|_| !is_shown) {
        let note = format!("L10, {}; all bearings together {} h", worst.name, about(life.bearings.system_h));
        verdict.figures.push(
            KeyFigure::new("Shortest bearing life", about(worst.life_h), "h", note)
                .kept(kept(LimitKind::BearingLife)),
        );
    }
    if let Some(pressure) = judged.limit(LimitKind::ContactPressure) {
        let note = format!("over the whole life; {} MPa allowed", compact(pressure.allowed, 4));
        let mut tile =
            KeyFigure::new("Largest contact pressure", significant(pressure.value, 4), "MPa", note)
                .kept(pressure.is_kept(service));
        if let Some(worn_in) = pressure.worn_in_h {
            tile.tone = Tone::Caution;
            tile.note.push_str(&format!(", exceeded only during running-in of about {} h", about(worn_in)));
        }
        verdict.figures.push(tile);
    }
    verdict.answers = answers(life);
    verdict.summary = summary(life, &verdict);
    verdict
}

fn answers(life: &Life) -> Vec<(String, String)> {
    let mut answers = Vec::new();
    let (new, end) = (life.first().lost_motion.arcmin(), life.last().lost_motion.arcmin());
    let causes = life.last().causes.as_ref().map(causes::largest).unwrap_or_default();
    let named: Vec<String> =
        causes.iter().take(2).map(|(cause, arcmin)| format!("{cause} {arcmin:.2} arcmin")).collect();
    answers.push((
        "Where the lost motion comes from".to_owned(),
        format!(
            "Of {1} arcmin {0} are present when new and {2} come from wear. Largest causes at the end: {3}.",
            significant(new, 3),
            significant(end, 3),
            significant(end - new, 2),
            named.join(", ")
        ),
    ));
    if !life.advice.is_empty() {
        let texts: Vec<String> =
            life.advice.iter().map(|advice| format!("{}.", capitalised(&advice.text))).collect();
        answers.push(("What to change first".to_owned(), texts.join(" ")));
    }
    answers.push(("Which physics".to_owned(), physics(life)));
    answers
}

/// Sentence about the models used, and about the effect of a finer model where it is known.
fn physics(life: &Life) -> String {
    let mut text = format!("{}.", capitalised(&life.fidelity.sentence()));
    if let Some(contacts) = life.last().contact_lost_motion.filter(|_| life.fidelity.joints == Joints::Ideal)
    {
        let contacts = significant(contacts.arcmin(), 3);
        text.push_str(&format!(
            " Load sharing and wear are computed with ideal joints, lost motion with the whole machine in its bearings \
             (contacts alone: {contacts} arcmin). With `joints = bearings` wear includes the bearings too."
        ));
    }
    if life.fidelity.elastic.is_none() {
        text.push_str(
            " Discs, carrier and housing are rigid except at the contacts; `bodies = elastic` includes their deformation.",
        );
    }
    if life.fidelity.errors.is_zero() {
        text.push_str(" Manufacturing errors are not included; `errors = drawn` computes a machine drawn from the tolerances.");
    }
    text
}

fn summary(life: &Life, verdict: &Verdict) -> String {
    let mut text = format!("{}: {}\n", life.machine.name, verdict.headline);
    for figure in &verdict.figures {
        text.push_str(&format!("- {}: {} {} ({})\n", figure.label, figure.value, figure.unit, figure.note));
    }
    for (question, answer) in &verdict.answers {
        text.push_str(&format!("- {question}: {answer}\n"));
    }
    let k = life.prediction.exposure.coefficient;
    text.push_str(&format!("- Wear coefficient: {k:.3e} 1/Pa ({:.3e} mm²/N)\n", k * 1e6));
    text
}

/// The main columns as a table of the report.
pub(super) fn life_table(life: &Life) -> Table {
    let table = declared::life_table(life, &life.ages);
    let keys = shown_columns(life);
    let columns: Vec<_> = keys.iter().filter_map(|key| table.column(key)).collect();
    let head = |column: &&crate::results::TableColumn| {
        let label = column.quantity.label();
        Column::number(capitalised(&label), column.quantity.unit())
    };
    let row = |row: usize| columns.iter().map(|c| c.quantity.show(&c.cells.value(row))).collect();
    Table {
        title: "The machine over its life".to_owned(),
        rows: shown_rows(life).into_iter().map(row).collect(),
        columns: columns.iter().map(head).collect(),
        note: "Every point is in `life.csv`. Signs: an output that lags is negative.".to_owned(),
    }
}

/// Summary and page use the same word.
#[cfg(test)]
pub(super) fn headline_of(life: &Life) -> (String, Option<String>) {
    let word = life.summary().get("verdict.limited_by").and_then(|value| match value {
        crate::results::Value::Word(word) => Some(word.clone()),
        _ => None,
    });
    (verdict(life).headline, word)
}
