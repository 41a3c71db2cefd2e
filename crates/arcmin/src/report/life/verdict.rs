//! The first screen: how accurate, how long, what limits it, what to change.

use super::LifePage;
use crate::report::{KeyFigure, Tone, Verdict, compact, significant};
use crate::units::{DEG, MPA};

/// A limit reached within this part beyond the service life is worth a warning: wear coefficients are not
/// known better.
const NARROW: f64 = 1.2;

pub(super) fn verdict(life: &LifePage) -> Verdict {
    let (Some(new), Some(end)) = (life.prediction.first(), life.prediction.last()) else {
        return Verdict::new(Tone::Neutral, "Nothing was predicted.");
    };
    let service = life.service_hours();
    let limit = life.limit_arcmin();
    let computed = life.searched_hours;
    // The row at the end of the planned life, which the prediction may run beyond.
    let worn = life.prediction.iter().rfind(|row| row.hours <= service * (1.0 + 1e-9)).unwrap_or(end);
    let (tone, headline) = match life.hours_to_limit {
        Some(hours) if hours < service => (
            Tone::Bad,
            format!(
                "Reaches its limit of {} arcmin lost motion after {:.0} h, before the planned {:.0} h.",
                compact(limit, 3),
                hours,
                service
            ),
        ),
        Some(hours) if hours < NARROW * service => (
            Tone::Caution,
            format!(
                "Keeps its {} arcmin of lost motion for the planned {:.0} h, but only just: {:.0} h.",
                compact(limit, 3),
                service,
                hours
            ),
        ),
        Some(hours) => (
            Tone::Good,
            format!(
                "Keeps its {} arcmin of lost motion for {:.0} h; {:.0} h are planned.",
                compact(limit, 3),
                hours,
                service
            ),
        ),
        None if computed < service * (1.0 - 1e-9) => (
            Tone::Caution,
            format!(
                "Stays within {} arcmin of lost motion for the {computed:.0} h that could be computed; {service:.0} h are planned.",
                compact(limit, 3)
            ),
        ),
        None => (
            Tone::Good,
            format!(
                "Keeps its {} arcmin of lost motion for all {:.0} h computed.",
                compact(limit, 3),
                computed
            ),
        ),
    };
    let pressure_limit = life.machine.limits.contact_pressure / MPA;
    let largest_pressure = life.prediction.iter().map(|row| row.max_pressure_mpa).fold(0.0, f64::max);
    let pressure_tone = if largest_pressure > pressure_limit { Tone::Bad } else { Tone::Neutral };
    let figure = |label: &str, value: String, unit: &str, note: String, tone: Tone| KeyFigure {
        label: label.into(),
        value,
        unit: unit.into(),
        note,
        tone,
    };
    let contacts = |row: &super::LifeRow| row.lost_motion_arcmin.unwrap_or(2.0 * row.play_arcmin);
    let lost = |row: &super::LifeRow| row.machine_lost_motion_arcmin.unwrap_or(contacts(row));
    let lost_kind = match (new.machine_lost_motion_arcmin, new.lost_motion_arcmin) {
        (Some(_), _) if !life.contacts_alone => {
            "lost motion at ±3 % of rated torque, bearings and gears as in the design".to_owned()
        }
        (Some(_), _) => {
            format!(
                "lost motion at ±3 % of rated torque, bearings and gears as in the design; tooth contacts alone {} arcmin",
                significant(contacts(new), 3)
            )
        }
        (None, Some(_)) => "lost motion at ±3 % of rated torque, tooth contacts alone".to_owned(),
        (None, None) => "play of both flanks, tooth contacts alone".to_owned(),
    };
    let figures = vec![
        figure(
            "Accuracy now (new)",
            significant(lost(new), 3),
            "arcmin",
            format!("{lost_kind}; loaded transmission error {} arcmin", significant(new.te_loaded_arcmin, 3)),
            Tone::Neutral,
        ),
        figure(
            &format!("After {:.0} h", worn.hours),
            significant(lost(worn), 3),
            "arcmin",
            format!(
                "{} arcmin allowed; of this the wear {} arcmin; loaded transmission error {} arcmin",
                compact(limit, 3),
                significant(lost(worn) - lost(new), 3),
                significant(worn.te_loaded_arcmin, 3)
            ),
            if lost(worn) > limit { Tone::Bad } else { Tone::Good },
        ),
        match life.hours_to_limit {
            Some(hours) => figure(
                "Hours to the limit",
                format!("{hours:.0}"),
                "h",
                format!("{service:.0} h planned"),
                tone,
            ),
            None => figure(
                "Hours to the limit",
                format!("> {computed:.0}"),
                "h",
                format!("{service:.0} h planned; computed to {computed:.0} h"),
                tone,
            ),
        },
        figure(
            "Largest contact pressure",
            significant(largest_pressure, 4),
            "MPa",
            format!(
                "{} MPa allowed; largest force {} N",
                compact(pressure_limit, 4),
                significant(worn.max_force_n, 3)
            ),
            pressure_tone,
        ),
    ];
    let mut answers = vec![("What limits it".to_owned(), limiting(life, largest_pressure, pressure_limit))];
    let advice = if life.advice.is_empty() { vec![default_advice(life)] } else { life.advice.clone() };
    answers.extend(advice.into_iter().map(|text| ("What to change".to_owned(), text)));
    let mut summary = format!("{}: {}\n", life.machine.name, headline);
    for key in &figures {
        summary.push_str(&format!("- {}: {} {} ({})\n", key.label, key.value, key.unit, key.note));
    }
    for (question, answer) in &answers {
        summary.push_str(&format!("- {question}: {answer}\n"));
    }
    summary.push_str(&format!(
        "- Wear coefficient: {} 1/Pa ({} mm²/N)\n- arcmin {}, design {}\n- {}\n",
        significant(life.prediction_coefficient_per_pa, 3),
        significant(life.prediction_coefficient_per_pa * 1e6, 3),
        life.provenance.version,
        life.provenance.design_hash,
        life.provenance.command
    ));
    Verdict { figures, answers, summary, ..Verdict::new(tone, headline) }
}

fn limiting(life: &LifePage, pressure: f64, pressure_limit: f64) -> String {
    let worst = life.flanks.last().filter(|worn| !worn.flank.is_zero()).map(|worn| worn.flank.deepest());
    let wear = match worst {
        Some((depth, angle)) => format!(
            "Wear of the cycloid disc's flank: {} µm at {:.0}° meshing angle after {:.0} h, where force and sliding together are largest.",
            significant(depth * 1e6, 3),
            (angle / DEG).abs(),
            life.flanks.last().map_or(0.0, |worn| worn.hours)
        ),
        None => "Wear of the cycloid disc's flank.".to_owned(),
    };
    let ends = (
        life.prediction.first().and_then(|row| row.machine_lost_motion_arcmin),
        life.prediction.last().and_then(|row| row.machine_lost_motion_arcmin),
    );
    let wear = match ends {
        (Some(new), Some(worn)) if new > worn - new => format!(
            "Of {} arcmin lost motion {} are there from the start: clearance and elasticity of bearings and gears (see lost motion by cause). Wear adds the rest. {wear}",
            significant(worn, 3),
            significant(new, 3)
        ),
        _ => wear,
    };
    if pressure > pressure_limit {
        format!(
            "The contact pressure of {} MPa exceeds the {} MPa allowed. {wear}",
            significant(pressure, 4),
            compact(pressure_limit, 4)
        )
    } else {
        wear
    }
}

/// Holds for every design: depth per pass is k (F/B) ξ, so that width, torque and coefficient act in
/// proportion at first.
fn default_advice(life: &LifePage) -> String {
    format!(
        "Depth per pass is k·(F/B)·ξ: a disc wider than {} mm or a lower torque slows wear in proportion; so does a lower wear coefficient \
         (lubricant, surface). The coefficient is the least certain input: calibrate it with one measured lost motion.",
        compact(life.machine.disc.width * 1e3, 3)
    )
}
