//! Figure 8 of Tao2024 and the load sharing over the crank turn.

use super::{LifePage, WornFlank};
use crate::load::closed_form::{self, ClosedForm};
use crate::machine::Machine;
use crate::report::{Annotation, Axis, Block, Colour, Plot, Series, Style, Tone, compact, significant};
use crate::units::{ARCMIN, DEG, UM};

/// The uniform depth and the closed form there, for the paper's figures.
pub(super) struct StudyLoad {
    pub hours: f64,
    pub depth: f64,
    pub solution: ClosedForm,
}

/// Closed forms at the study's depths; a level without solution is left out (the study's own table shows it).
pub(super) fn study_loads(life: &LifePage) -> Vec<StudyLoad> {
    life.study
        .iter()
        .filter_map(|row| {
            let depth = row.max_depth_um * UM;
            let solution = closed_form::solve(life.machine, life.machine.rated.torque.abs(), depth).ok()?;
            Some(StudyLoad { hours: row.hours, depth, solution })
        })
        .collect()
}

/// Force at any |φ| (rad) by the closed form's own law: F_max (l/l_max − Δ/δ_max) where positive.
pub(super) fn closed_form_force(machine: &Machine, load: &StudyLoad, phi: f64) -> f64 {
    let mut profile = machine.profile();
    profile.pin_circle_radius = machine.ring.pin_circle_radius;
    let cut = &machine.disc.modification;
    let gap = closed_form::initial_gap(
        profile.short_width_coefficient(),
        cut.equidistant_offset + load.depth,
        cut.radial_offset,
        phi,
    );
    let share = profile.lever_arm(phi) / profile.largest_lever_arm() - gap / load.solution.max_approach;
    load.solution.max_force * share.max(0.0)
}

pub(super) fn blocks(life: &LifePage) -> Vec<Block> {
    let mut blocks = Vec::new();
    let study = study_loads(life);
    if study.len() > 1 {
        blocks.push(Block::Plot(study_forces(life, &study)));
    }
    if !life.flanks.is_empty() {
        blocks.push(Block::Plot(equilibrium_forces(life)));
        blocks.push(Block::Plot(if life.errors.is_some() {
            pins_around_the_ring(life)
        } else {
            one_pin_over_a_turn(life)
        }));
        blocks.push(Block::Plot(pressure(life)));
        blocks.push(Block::Plot(loaded_error(life)));
    }
    blocks.push(Block::Note(
        Tone::Neutral,
        "The closed form of the handbook gives each disc 0.55 of the torque and measures all forces by one line of deformation. The equilibrium \
         solves for the pose at which the real gaps carry the torque, input locked; part of the torque then goes through the gear stage, so \
         that its forces are lower."
            .into(),
    ));
    blocks
}

fn study_forces(life: &LifePage, study: &[StudyLoad]) -> Plot {
    let mut plot = Plot::new(
        "Contact force in the paper's study (closed form)",
        Axis::new("Meshing angle |φ|", "°").between(0.0, 180.0),
        Axis::new("Contact force", "N").from_zero(),
    )
    .half();
    let last = (study.len() - 1) as f64;
    for (index, load) in study.iter().enumerate() {
        let points = (0..=360).map(|half| {
            let phi = f64::from(half) * 0.5;
            (phi, closed_form_force(life.machine, load, phi * DEG))
        });
        plot.series
            .push(Series::line(hours_and_depth(load), points).coloured(Colour::Ordered(index as f64 / last)));
    }
    let (first, final_load) = (&study[0], &study[study.len() - 1]);
    plot.note = format!(
        "Figure 8 of [Tao2024]: forces rise and fewer pairs carry as the uniform depth grows, from {} N on {} pairs to {} N on {}. The paper's \
         printed formula for the first force has the pin radius where the pin circle radius belongs; with that misprint it would be {} N.",
        significant(first.solution.max_force, 4),
        first.solution.loaded_pairs(),
        significant(final_load.solution.max_force, 4),
        final_load.solution.loaded_pairs(),
        significant(
            closed_form::first_max_force(life.machine, life.machine.rated.torque.abs())
                * life.machine.ring.pin_circle_radius
                / life.machine.ring.pin_radius,
            4
        )
    );
    plot
}

pub(super) fn hours_and_depth(load: &StudyLoad) -> String {
    format!("{:.0} h, {} µm", load.hours, compact(load.depth / UM, 2))
}

fn ordered(index: usize, count: usize) -> Colour {
    Colour::Ordered(if count > 1 { index as f64 / (count - 1) as f64 } else { 0.0 })
}

fn state_name(worn: &WornFlank) -> String {
    if worn.hours == 0.0 { "new".to_owned() } else { format!("{:.0} h", worn.hours) }
}

/// Force on a flank point against |φ|, from all crank positions and discs.
fn equilibrium_forces(life: &LifePage) -> Plot {
    let mut plot = Plot::new(
        "Contact force as predicted (equilibrium, coupled wear)",
        Axis::new("Meshing angle |φ|", "°").between(0.0, 180.0),
        Axis::new("Contact force", "N").from_zero(),
    )
    .half()
    .noted(
        "Wear takes the load off the flank where it slides most and moves it towards the root, where it slides least: growth slows down by \
         itself. The uniform depth of the paper's study leaves this out.",
    );
    if life.errors.is_some() {
        plot.note.push_str(" With manufacturing errors: of one disc, mean of all pins over the whole ring.");
    }
    for (index, worn) in life.flanks.iter().enumerate() {
        let side = life.loaded_side();
        let mut points: Vec<(f64, f64)> = worn
            .forces
            .iter()
            .filter(|force| force.meshing_angle * side >= 0.0)
            .map(|force| ((force.meshing_angle * side) / DEG, force.force))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|a, b| (a.0 - b.0).abs() < 1e-6);
        plot.series.push(Series::line(state_name(worn), points).coloured(ordered(index, life.flanks.len())));
    }
    plot
}

/// Force of pin 0 over one crank turn: the pattern of one pin pitch carried from pin to pin.
fn one_pin_over_a_turn(life: &LifePage) -> Plot {
    let mut plot = Plot::new(
        "Load on one pin over the crank turn",
        Axis::new("Crank angle", "°").between(0.0, 360.0),
        Axis::new("Contact force", "N").from_zero(),
    )
    .half()
    .noted(
        "Pin at 0° of the ring; every other pin sees the same, one pin pitch later. The discs take turns.",
    );
    let pins = life.machine.ring.pin_count;
    for (state, style) in [
        (life.flanks.first(), Style::Line),
        (life.flanks.last().filter(|_| life.flanks.len() > 1), Style::Dashed),
    ] {
        let Some(worn) = state else { continue };
        let steps = worn.cycle.positions.len();
        let discs = worn.cycle.positions.first().map_or(0, |position| position.discs.len());
        for disc in 0..discs {
            let points = (0..=pins * steps).map(|step| {
                // A later pitch shows on pin 0 what an earlier pin number shows now.
                let (pitch, within) = (step / steps, step % steps);
                let pin = (pins - pitch % pins) % pins;
                let force = worn.cycle.positions[within].discs[disc]
                    .iter()
                    .find(|contact| contact.pin == pin)
                    .map_or(0.0, |contact| contact.force);
                (360.0 * step as f64 / (pins * steps) as f64, force)
            });
            let name = format!("disc {}, {}", disc + 1, state_name(worn));
            plot.series.push(Series::new(name, style, points).coloured(Colour::Palette([0, 4, 2][disc % 3])));
        }
    }
    plot
}

/// What each pin bears in the mean over a turn of the output, new and at the end.
fn pins_around_the_ring(life: &LifePage) -> Plot {
    let mut plot = Plot::new("Load on every pin", Axis::new("Pin, counted from the x axis", ""), Axis::new("Mean contact force", "N").from_zero())
        .half()
        .noted("Mean over a turn of the output, of one disc, unloaded times included. Without manufacturing errors all pins would bear the same.");
    for (state, style) in [
        (life.flanks.first(), Style::LineMarkers),
        (life.flanks.last().filter(|_| life.flanks.len() > 1), Style::Dashed),
    ] {
        let Some(worn) = state else { continue };
        for disc in 0..life.machine.disc_count {
            let points = worn
                .pins
                .iter()
                .filter(|load| load.disc == disc)
                .map(|load| ((load.pin + 1) as f64, load.mean_force));
            let name = format!("disc {}, {}", disc + 1, state_name(worn));
            plot.series.push(Series::new(name, style, points).coloured(Colour::Palette([0, 4, 2][disc % 3])));
        }
    }
    plot
}

fn pressure(life: &LifePage) -> Plot {
    let limit = life.machine.limits.contact_pressure * 1e-6;
    let mut plot = Plot::new(
        "Hertz pressure along the flank",
        Axis::new("Meshing angle |φ|", "°").between(0.0, 180.0),
        Axis::new("Largest pressure", "MPa").from_zero(),
    )
    .half()
    .noted("Line contact with the relative curvature of the flank in its state [Johnson1985]. The pressure is largest beyond the largest force, where the flank is sharpest.");
    let contact = life.machine.line_contact();
    let side = life.loaded_side();
    let mut largest = 0.0_f64;
    for (index, worn) in life.flanks.iter().enumerate() {
        let mut points: Vec<(f64, f64)> = worn
            .peaks
            .iter()
            .filter(|force| force.meshing_angle * side >= 0.0)
            .map(|force| {
                (
                    (force.meshing_angle * side) / DEG,
                    contact.pressure(force.force, 1.0 / force.relative_curvature) * 1e-6,
                )
            })
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|a, b| (a.0 - b.0).abs() < 1e-6);
        largest = points.iter().map(|point| point.1).fold(largest, f64::max);
        plot.series.push(Series::line(state_name(worn), points).coloured(ordered(index, life.flanks.len())));
    }
    // A limit far away would only flatten the curves.
    if limit < 2.0 * largest {
        plot.limit_at(limit, format!("allowed {} MPa", compact(limit, 4)));
    }
    plot
}

/// Loaded transmission error over two pin pitches of crank angle.
fn loaded_error(life: &LifePage) -> Plot {
    let mut plot = Plot::new(
        "Loaded transmission error over the crank angle",
        Axis::new("Crank angle", "°"),
        Axis::new("Transmission error less its mean", "arcsec"),
    )
    .half();
    let mut means = Vec::new();
    for (index, worn) in life.flanks.iter().enumerate() {
        let mean = worn.cycle.mean_error().radians();
        let steps = worn.cycle.positions.len();
        means.push(format!("{}: {} arcmin", state_name(worn), significant(mean / ARCMIN, 3)));
        // With manufacturing errors the next pitch is another one.
        let pitches = if life.errors.is_some() { 1 } else { 2 };
        let points = (0..=pitches * steps).filter(|step| pitches > 1 || *step < steps).map(|step| {
            let position = &worn.cycle.positions[step % steps];
            (
                worn.cycle.period / DEG * step as f64 / steps as f64,
                (position.output_error.radians() - mean) / ARCMIN * 60.0,
            )
        });
        plot.series.push(Series::line(state_name(worn), points).coloured(ordered(index, life.flanks.len())));
    }
    plot.annotations.push(Annotation::Vertical {
        at: life.flanks[0].cycle.period / DEG,
        label: "one pin pitch".into(),
        tone: Tone::Neutral,
    });
    plot.note = format!(
        "Quasi-static at rated torque, {}: the ripple is that of pairs entering and leaving. Mean values: {}.",
        if life.contacts_alone { "contacts only" } else { "bearings included" },
        means.join(", ")
    );
    plot
}
