//! Terminal and report of load sharing.

use super::{Answer, Contact, Equilibrium};
use crate::analyses::Outcome;
use crate::analyses::Said;
use crate::load::{FlankForce, PinLoad};
use crate::report::{
    Axis, Block, KeyFigure, Page, Plot, Provenance, Section, Series, Style, Tone, Verdict, significant,
};
use crate::units::{ARCMIN, DEG, MPA};

const FIGURES: &[&str] = &[
    "max_force_n",
    "max_pressure_mpa",
    "loaded_pairs",
    "te_loaded_arcmin",
    "te_loaded_peak_to_peak_arcmin",
    "play_arcmin",
    "torsional_stiffness_n_m_per_arcmin",
    "disc_torque_shares",
];

pub(super) fn said(contact: &Contact) -> Vec<Said> {
    let mut said = vec![Said::line(heading(contact))];
    match &contact.answer {
        Answer::ClosedForm(answer) => said.push(Said::line(answer.sentence())),
        Answer::Equilibrium(answer) => {
            said.push(Said::figures(&contact.summary(), FIGURES));
            said.extend(ends(answer).into_iter().map(Said::Line));
            if let Some(nominal) = &answer.nominal {
                said.push(Said::line(format!(
                    "without errors: largest force {:.1} N, loaded transmission error {:.4}′, one-sided play \
                     {:.4}′",
                    nominal.max_force(),
                    nominal.mean_error().arcmin(),
                    nominal.mean_play().arcmin()
                )));
            }
        }
    }
    said
}

fn heading(contact: &Contact) -> String {
    let state = match (contact.worn.hours, contact.worn.deepest()) {
        (0.0, 0.0) => "new".to_owned(),
        (0.0, depth) => format!("{} µm off every flank", significant(depth * 1e6, 3)),
        (hours, _) => format!("after {hours:.0} h"),
    };
    let (name, torque) = (&contact.machine.name, contact.torque);
    let friction = match &contact.friction {
        None => String::new(),
        Some((f, assumed)) => format!(
            ", running with {}friction (flank {}, bearings {}, gear mesh {})",
            if *assumed { "assumed " } else { "" },
            f.flank,
            f.bearing,
            f.gear_mesh
        ),
    };
    format!("{name}: {torque} N·m, {state}{friction}; {}", contact.fidelity.sentence())
}

/// The pins that bear most and least, where they differ.
fn ends(answer: &Equilibrium) -> Vec<String> {
    let by_mean = |a: &&PinLoad, b: &&PinLoad| a.mean_force.total_cmp(&b.mean_force);
    let one = |load: &PinLoad| {
        let (pin, disc) = (load.pin + 1, load.disc + 1);
        let (mean, max) = (load.mean_force, load.max_force);
        format!("pin {pin} on disc {disc}: {mean:.1} N in the mean, {max:.1} N at most")
    };
    let most = answer.pins.iter().max_by(by_mean).map(|load| format!("bears most: {}", one(load)));
    let least =
        answer.pins.iter().min_by(by_mean).map(|load| {
            format!("bears least: {} (pins and discs counted from 1 as in the design)", one(load))
        });
    most.into_iter().chain(least).collect()
}

pub(super) fn page(contact: &Contact) -> Page {
    let machine = &contact.machine;
    let summary = contact.summary();
    let pressure = summary.number("max_pressure_mpa").unwrap_or(f64::NAN);
    let allowed = machine.limits.contact_pressure / MPA;
    let tone = if pressure > allowed { Tone::Bad } else { Tone::Neutral };
    let headline = format!(
        "{} N at most on one pin, {} MPa; {} MPa allowed.",
        significant(contact.max_force(), 4),
        significant(pressure, 4),
        significant(allowed, 4)
    );
    let mut verdict = Verdict::new(tone, headline);
    let figure = |(quantity, value): &(crate::results::Quantity, crate::results::Value)| {
        KeyFigure::new(quantity.label(), quantity.show(value), quantity.unit(), quantity.sentence())
    };
    let keys = ["max_force_n", "te_loaded_arcmin", "play_arcmin", "torsional_stiffness_n_m_per_arcmin"];
    verdict.figures = summary
        .entries
        .iter()
        .filter(|(quantity, value)| keys.contains(&quantity.key) && *value != crate::results::Value::Absent)
        .map(figure)
        .collect();
    verdict.answers.push(("Which physics".to_owned(), contact.fidelity.sentence()));
    Page {
        title: machine.name.clone(),
        subtitle: "Load sharing".to_owned(),
        provenance: Provenance::default(),
        verdict,
        sections: vec![Section::new("load", "Load sharing", blocks(contact))],
    }
}

fn angle_axis() -> Axis {
    Axis::new("Meshing angle", "°").between(-180.0, 180.0)
}

fn blocks(contact: &Contact) -> Vec<Block> {
    let answer = match &contact.answer {
        Answer::ClosedForm(answer) => {
            let forces = Series::new("closed form", Style::Markers, answer.degrees());
            let plot = Plot::new("Force of every pair", angle_axis(), Axis::new("Force", "N").from_zero())
                .with(forces)
                .noted("Handbook method of Tao2024 (eqs. 5–10) at one crank position, every disc alike.");
            return vec![Block::Plot(plot)];
        }
        Answer::Equilibrium(answer) => answer,
    };
    let law = contact.machine.line_contact();
    let cells = 180;
    let forces: Vec<FlankForce> =
        (0..contact.machine.disc_count).flat_map(|disc| answer.cycle.flank_cells(disc, cells).1).collect();
    let largest = |value: &dyn Fn(&FlankForce) -> f64| {
        let mut points: Vec<(f64, f64)> = forces.iter().map(|f| (f.meshing_angle / DEG, value(f))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let force = Plot::new("Force along the flank", angle_axis(), Axis::new("Largest force", "N").from_zero())
        .with(Series::line("largest of all pins", largest(&|f| f.force)))
        .noted("Largest force of any pin at each meshing angle, over everything that repeats.")
        .half();
    let mut pressure = Plot::new(
        "Pressure along the flank",
        angle_axis(),
        Axis::new("Largest Hertz pressure", "MPa").from_zero(),
    )
    .with(Series::line(
        "largest of all pins",
        largest(&|f| law.pressure(f.force, 1.0 / f.relative_curvature) / MPA),
    ))
    .noted("With the curvature of the flank at that place; the limit is that of the design.")
    .half();
    pressure.limit_at(
        contact.machine.limits.contact_pressure / MPA,
        format!("{} MPa allowed", significant(contact.machine.limits.contact_pressure / MPA, 4)),
    );
    let over_the_turn = |value: &dyn Fn(&crate::load::LoadSharing) -> f64| {
        answer.turn.iter().map(|s| (s.crank_angle.degrees(), value(s))).collect::<Vec<_>>()
    };
    let error = Plot::new(
        "Loaded transmission error",
        Axis::new("Crank angle", "°"),
        Axis::new("Output error", "arcmin"),
    )
    .with(Series::line("θ_out − θ_in/i", over_the_turn(&|s| s.output_error.arcmin())))
    .noted("Input locked, first turn of the crankshafts. Negative: the output lags.")
    .half();
    let stiffness =
        Plot::new("Tangent stiffness", Axis::new("Crank angle", "°"), Axis::new("Stiffness", "N·m/arcmin"))
            .with(Series::line("dT/dφ", over_the_turn(&|s| s.stiffness * ARCMIN)))
            .noted("Of the teeth alone with ideal joints, of the whole machine in bearings.")
            .half();
    vec![Block::Plot(force), Block::Plot(pressure), Block::Plot(error), Block::Plot(stiffness)]
}
