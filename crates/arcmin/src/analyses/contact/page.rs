//! Terminal and report of load sharing.

use super::{Answer, Contact, Equilibrium};
use crate::analyses::Outcome;
use crate::analyses::TextBlock;
use crate::load::{FlankForce, PinLoad};
use crate::report::{
    Axis, Block, KeyFigure, Page, Plot, Provenance, Section, Series, Style, Tone, Verdict, significant,
};
use crate::units::{ARCMIN, DEG, MPA};
use std::f64::consts::TAU;

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

pub(super) fn text_blocks(contact: &Contact) -> Vec<TextBlock> {
    let mut blocks = vec![TextBlock::line(heading(contact))];
    match &contact.answer {
        Answer::ClosedForm(answer) => blocks.push(TextBlock::line(answer.sentence())),
        Answer::Equilibrium(answer) => {
            blocks.push(TextBlock::figures(&contact.summary(), FIGURES));
            blocks.extend(ends(answer).into_iter().map(TextBlock::Line));
            if let Some(nominal) = &answer.nominal {
                blocks.push(TextBlock::line(format!(
                    "without errors: largest force {:.1} N, loaded transmission error {:.4}′, one-sided play \
                     {:.4}′",
                    nominal.max_force(),
                    nominal.mean_error().arcmin(),
                    nominal.mean_play().arcmin()
                )));
            }
        }
    }
    blocks
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

/// The pins with the largest and the smallest load, if they differ.
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

/// Number of steps of the meshing angle of which the largest value is shown.
const NOMINAL_STEPS: usize = 180;
/// With errors every pin is loaded differently: a step must contain all pins, otherwise the curve jumps between them.
const STEPS_WITH_ERRORS: usize = 60;

/// The largest value in each of equal steps of the meshing angle, over all pins and discs, where it was met.
fn largest_in_steps(
    forces: &[FlankForce],
    steps: usize,
    value: &dyn Fn(&FlankForce) -> f64,
) -> Vec<(f64, f64)> {
    let step = |force: &FlankForce| ((force.meshing_angle / TAU + 0.5) * steps as f64).floor();
    let largest = |forces: &[FlankForce]| {
        forces
            .iter()
            .map(|force| (force.meshing_angle / DEG, value(force)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
    };
    forces.chunk_by(|a, b| step(a) == step(b)).filter_map(largest).collect()
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
                .noted("Force in N of every pair at one crank position by the handbook method of Tao2024 (eqs. 5–10), with equal loads of all discs.");
            return vec![Block::Plot(plot)];
        }
        Answer::Equilibrium(answer) => answer,
    };
    let law = contact.machine.line_contact();
    let steps = if contact.fidelity.errors.is_zero() { NOMINAL_STEPS } else { STEPS_WITH_ERRORS };
    let forces = answer.cycle.flank_forces();
    let largest = |value: &dyn Fn(&FlankForce) -> f64| largest_in_steps(&forces, steps, value);
    let force = Plot::new("Force along the flank", angle_axis(), Axis::new("Largest force", "N").from_zero())
        .with(Series::line("largest of all pins", largest(&|f| f.force)))
        .noted("Largest force in N of any pin at each meshing angle over one full period.")
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
    .noted("Largest Hertz pressure in MPa at each meshing angle over one full period, with the curvature of the flank there. The limit is that of the design.")
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
    .noted("Error of the output in arcmin under load with the input locked, over the first turn of the crankshafts. A negative error is a lag.")
    .half();
    let stiffness =
        Plot::new("Tangent stiffness", Axis::new("Crank angle", "°"), Axis::new("Stiffness", "N·m/arcmin"))
            .with(Series::line("dT/dφ", over_the_turn(&|s| s.stiffness.unwrap_or(0.0) * ARCMIN)))
            .noted("Slope of torque over output angle in N·m/arcmin: of the teeth alone with ideal joints, of the whole machine with bearings.")
            .half();
    vec![Block::Plot(force), Block::Plot(pressure), Block::Plot(error), Block::Plot(stiffness)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two discs that bear differently, met at angles between each other: one curve over both, not a zigzag.
    #[test]
    fn the_largest_of_all_discs_is_one_curve() {
        let met = |degrees: f64, force: f64| FlankForce {
            meshing_angle: degrees * DEG,
            force,
            relative_curvature: 1.0,
        };
        let forces: Vec<FlankForce> =
            (0..360).map(|i| met(f64::from(i) - 179.5, if i % 2 == 0 { 100.0 } else { 10.0 })).collect();
        let curve = largest_in_steps(&forces, 60, &|f| f.force);
        assert_eq!(curve.len(), 60);
        assert!(curve.iter().all(|point| point.1 == 100.0), "{curve:?}");
    }
}
