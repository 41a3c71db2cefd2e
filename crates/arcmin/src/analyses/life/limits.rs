//! The limits of a machine in words and tables, for terminal and report.

use super::band::Band;
use super::verdict::{LifeVerdict, Limit, LimitKind, about};
use super::{BearingLives, DriveLife, Judgement, Life, WithElasticBodies};
use crate::analyses::TextTable;
use crate::life::LifePoint;
use crate::load::CycleContact;
use crate::report::{Block, Column, Table, compact, significant};
use crate::units::{DEG, MPA};

/// A value in the unit of its limit.
fn amount(limit: &Limit) -> String {
    let (unit, value) = (limit.kind.unit(), limit.value);
    match unit {
        "" if limit.kind == LimitKind::ContactFatigue => format!("damage {}", significant(value, 3)),
        "" => format!("{value:.0}"),
        "h" => format!("{} h", about(value)),
        _ => match limit.scatter.filter(|scatter| *scatter > 0.005 * value) {
            Some(scatter) => format!("{} ± {} {unit}", significant(value, 3), significant(scatter, 1)),
            None => format!("{} {unit}", significant(value, 3)),
        },
    }
}

fn lasts(limit: &Limit, verdict: &LifeVerdict) -> String {
    match limit.hours {
        Some(hours) => format!("{} h", about(hours)),
        None if limit.kind == LimitKind::LostMotion => format!("> {} h", about(verdict.searched_h)),
        None => format!("> {} h", about(verdict.service_h)),
    }
}

fn has_bands(verdict: &LifeVerdict) -> bool {
    verdict.limits.iter().any(|limit| limit.band.is_some())
}

/// Head of the columns, `true` where they are set left.
fn columns(verdict: &LifeVerdict, elastic: Option<&Judgement>) -> Vec<(&'static str, bool)> {
    let mut columns = vec![("limit", true), ("found", false), ("allowed", false), ("lasts", false)];
    if has_bands(verdict) {
        columns.push(("90 % band", false));
    }
    if elastic.is_some() {
        columns.extend([("with elastic bodies", false), ("lasts", false)]);
    }
    columns.push(("", true));
    columns
}

/// A row of the table: value found, value allowed, and how long it lasts.
fn row(limit: &Limit, verdict: &LifeVerdict, elastic: Option<&Judgement>) -> Vec<String> {
    let judged = match (limit.is_kept(verdict.service_h), limit.is_transient()) {
        _ if verdict.is_undecided(limit.kind) => "undecided",
        (false, _) => "not kept",
        (true, true) => "exceeded until worn in",
        (true, false) => "kept",
    };
    let name = match &limit.place {
        Some(place) => format!("{}: {place}", limit.kind.name()),
        None => limit.kind.name().to_owned(),
    };
    let allowed = format!("{} {}", compact(limit.allowed, 4), limit.kind.unit()).trim().to_owned();
    let mut row = vec![name, amount(limit), allowed, lasts(limit, verdict)];
    if has_bands(verdict) {
        let band = limit.band.as_ref().filter(|band| !band.is_point());
        row.push(band.map_or_else(String::new, Band::words));
    }
    if let Some(elastic) = elastic {
        let other = elastic.limits.iter().find(|other| other.kind == limit.kind);
        row.extend(
            other.map_or_else(
                || [String::new(), String::new()],
                |other| [amount(other), lasts(other, verdict)],
            ),
        );
    }
    row.push(judged.to_owned());
    row
}

/// For a terminal.
pub(in crate::analyses) fn text(verdict: &LifeVerdict, elastic: Option<&Judgement>) -> TextTable {
    TextTable {
        header: columns(verdict, elastic).into_iter().map(|(head, _)| head.to_owned()).collect(),
        rows: verdict.limits.iter().map(|limit| row(limit, verdict, elastic)).collect(),
    }
}

/// Table for a report, with a note on the meaning of its values.
fn table(verdict: &LifeVerdict, elastic: Option<&Judgement>, note: &str) -> Block {
    let column = |(head, left): (&'static str, bool)| match (head, left) {
        ("", _) => Column::text("Verdict"),
        (head, true) => Column::text(crate::report::capitalised(head)),
        (head, false) => Column::number(crate::report::capitalised(head), ""),
    };
    Block::Table(Table {
        title: "Every limit and how long it is kept".to_owned(),
        columns: columns(verdict, elastic).into_iter().map(column).collect(),
        rows: verdict.limits.iter().map(|limit| row(limit, verdict, elastic)).collect(),
        note: note.into(),
    })
}

/// Rating lives for a report.
fn bearings_table(lives: &BearingLives, note: &str) -> Block {
    let bearings = lives.bearings.iter().map(|b| {
        vec![b.name.clone(), significant(b.equivalent, 4), significant(b.rating, 4), about(b.life_h)]
    });
    Block::Table(Table {
        title: "Rating life of the bearings".to_owned(),
        columns: vec![
            Column::text("Bearing"),
            Column::number("Equivalent load", "N"),
            Column::number("Load rating C", "N"),
            Column::number("L10", "h"),
        ],
        rows: bearings.collect(),
        note: note.into(),
    })
}

/// Explanations of the numbers of the table, a sentence each.
pub(in crate::analyses) fn notes(life: &DriveLife) -> Vec<String> {
    let mut notes = Vec::new();
    let (bearings, service) = (&life.bearings, life.verdict.service_h);
    if bearings.bearings.len() > 1 {
        let all = match bearings.bearings.len() {
            2 => "both bearings".to_owned(),
            count => format!("all {count} bearings"),
        };
        notes.push(format!(
            "{all} together: L10 of the system {} h (Weibull slope 9/8); after {service:.0} h no bearing has \
             failed in {:.0} of 100 machines. This is not a limit: catalogues state the L10 of one bearing.",
            about(bearings.system_h),
            100.0 * bearings.survival(service)
        ));
    }
    if let Some(assumed) = bearings.assumed_friction {
        notes.push(format!(
            "bearing lives include an assumed friction coefficient of {} on the flanks, because the design gives none; \
             without friction the shortest is {} h.",
            compact(assumed.flank, 3),
            about(assumed.without_h)
        ));
    }
    let rest = life.demands.rest_share();
    if rest > 0.0 {
        let hours = life.verdict.hours_to_limit().unwrap_or(service);
        notes.push(format!(
            "hours are clock hours of the duty, rest included; in {} of {} h the machine moves.",
            about((1.0 - rest) * hours),
            about(hours)
        ));
    } else {
        notes.push("hours are hours in motion, because the duty has no row with speed 0.".to_owned());
    }
    notes
}

/// Results of both judgements and why they disagree on limits, or the meaning of rigid bodies that were chosen.
pub(super) fn about_bodies(life: &Life) -> Vec<String> {
    let both = match &life.with_elastic_bodies {
        WithElasticBodies::Judged(elastic) => {
            let lag = |point: &LifePoint| point.accuracy.loaded_error.arcmin().abs();
            let (rigid, soft) = (lag(life.first()), lag(&elastic.prediction.points[0]));
            Some(format!(
                "at rated torque the output of the new machine lags by {} arcmin with rigid bodies and by {} arcmin with \
                 elastic bodies, {} times as much. The stiffness of measured machines agrees with elastic bodies.",
                significant(rigid, 3),
                significant(soft, 3),
                significant(soft / rigid, 2)
            ))
        }
        WithElasticBodies::NoRoom(finding) => Some(finding.message.clone()),
        WithElasticBodies::NotAsked => (life.bodies_are_chosen && life.fidelity.frame.is_none()).then(|| {
            "rigid bodies were chosen. Discs, carrier and housing of real machines deform; with stiff crankshafts a machine \
             is about twice as stiff without that. Without --bodies the verdict uses rigid and elastic bodies and states by \
             how much they differ."
                .to_owned()
        }),
    };
    let undecided = life.verdict.undecided.iter();
    both.into_iter()
        .chain(undecided.map(|one| format!("{} is undecided: {}.", one.kind.name(), one.why())))
        .collect()
}

/// Places of the largest force and the largest pressure, new and at the end; they can be at different pins.
pub(super) fn places(life: &Life) -> impl Iterator<Item = String> {
    let at = |spot: &CycleContact| format!("{:.1}°", (spot.meshing_angle / DEG).abs());
    let one = |name: &str, point: &LifePoint| {
        let (force, pressure) = (&point.accuracy.largest_force_at, &point.accuracy.largest_pressure_at);
        format!(
            "{name}: largest force {} N at {} (pressure there {} MPa); largest pressure {} MPa at {} (force there {} N)",
            significant(force.force, 3),
            at(force),
            significant(force.pressure / MPA, 3),
            significant(pressure.pressure / MPA, 3),
            at(pressure),
            significant(pressure.force, 3),
        )
    };
    let (new, end) = (life.first(), life.last());
    let of = |point: &LifePoint| (point.accuracy.max_force, point.accuracy.max_pressure);
    let ((force_new, pressure_new), (force_end, pressure_end)) = (of(new), of(end));
    let parts = (force_end > 1.1 * force_new && pressure_end < 0.9 * pressure_new).then(|| {
        "the largest force increases while the largest pressure decreases: flanks wear where they slide, and the load \
         moves to the root, which slides and wears little and has nearly the curvature of the pin."
            .to_owned()
    });
    [Some(one("new", new)), Some(one(&format!("after {:.0} h", end.hours()), end)), parts]
        .into_iter()
        .flatten()
}

/// The limits with these explanations, and the bearings, for a report.
pub(in crate::analyses) fn blocks(
    life: &DriveLife,
    elastic: Option<&Judgement>,
    words: &[String],
    of_bearings: &str,
) -> Vec<Block> {
    let band = match has_bands(&life.verdict) {
        true => "; the band contains nine of ten machines within `[unknowns]`, by first-order sensitivities",
        false => "",
    };
    let note = format!(
        "Lost motion at the end of the planned life, pressure over all of it at the largest torque of rating and duty, \
         bearings by [ISO281] at the design's duty. Hours are rounded to two digits{band}. Further limits can be set in \
         `[limits]`."
    );
    let limits = table(&life.verdict, elastic, &note);
    let bearings = bearings_table(&life.bearings, of_bearings);
    let words: Vec<String> = words.iter().map(|note| capitalised_sentence(note)).collect();
    vec![limits, Block::Text(words.join(" ")), bearings]
}

/// With a capital letter in front and a full stop behind.
fn capitalised_sentence(text: &str) -> String {
    let text = crate::report::capitalised(text);
    if text.ends_with('.') { text } else { format!("{text}.") }
}
