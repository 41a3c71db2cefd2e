//! Figures 8 to 10 of Tao2024: forces, sliding distance and worn depth along the flank.

use super::Tao2024;
use crate::load::closed_form::{self, ClosedForm};
use crate::machine::Machine;
use crate::report::{Axis, Block, Colour, Plot, Series, Style, Tone, compact, significant};
use crate::units::{DEG, UM};

/// A uniform depth at which the closed form converges.
struct StudyLoad<'a> {
    hours: Option<f64>,
    depth: f64,
    solution: &'a ClosedForm,
}

fn loads(study: &Tao2024) -> Vec<StudyLoad<'_>> {
    let levels = study.levels.iter();
    levels
        .filter_map(|level| {
            Some(StudyLoad { hours: level.hours, depth: level.depth, solution: level.handbook.as_ref()? })
        })
        .collect()
}

/// Force at any |φ| (rad) by the closed form's own law: F_max (l/l_max − Δ/δ_max) where positive.
fn closed_form_force(machine: &Machine, load: &StudyLoad<'_>, phi: f64) -> f64 {
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

pub(super) fn blocks(study: &Tao2024) -> Vec<Block> {
    let loads = loads(study);
    let mut blocks = Vec::new();
    if loads.len() > 1 {
        blocks.push(Block::Plot(study_forces(study, &loads)));
        blocks.push(Block::Plot(sliding_distance(study, &loads)));
        blocks.push(Block::Plot(study_depth(study, &loads)));
    }
    if study.coefficient.is_some() {
        blocks.push(Block::Plot(depth_over_hours(study)));
    }
    blocks.push(Block::Note(
        Tone::Neutral,
        format!(
            "The closed form of the handbook gives each of two discs 0.55 of the torque ({} N·m here) and measures all \
             forces by one line of deformation. The equilibrium solves for the pose at which the real gaps carry the \
             torque, input locked; part of the torque then goes through the gear stage, so that its forces are lower.",
            significant(closed_form::disc_torque(study.machine.rated.torque.abs(), study.machine.disc_count), 4)
        ),
    ));
    blocks
}

fn depth_over_hours(study: &Tao2024) -> Plot {
    let points = study.levels.iter().filter_map(|level| Some((level.hours?, level.depth / UM)));
    Plot::new(
        "Uniform depth over the hours",
        Axis::new("Running time", "h"),
        Axis::new("Depth", "µm").from_zero(),
    )
    .half()
    .with(Series::new("paper's wear rule", Style::LineMarkers, points))
    .noted(format!(
        "Uniform wear depth in µm over the running time in h. It grows at the rate of the worst point of the flank, with k = {} 1/Pa [Archard1953].",
        study.coefficient.map_or("–".to_owned(), |k| significant(k, 3))
    ))
}

const ANGLES: i32 = 360;

fn angles_deg() -> impl Iterator<Item = f64> {
    (0..=ANGLES).map(|i| 180.0 * f64::from(i) / f64::from(ANGLES))
}

fn meshing_angle() -> Axis {
    Axis::new("Meshing angle |φ|", "°").between(0.0, 180.0)
}

fn study_forces(life: &Tao2024, study: &[StudyLoad<'_>]) -> Plot {
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
            (phi, closed_form_force(&life.machine, load, phi * DEG))
        });
        plot.series
            .push(Series::line(hours_and_depth(load), points).coloured(Colour::Ordered(index as f64 / last)));
    }
    let (first, final_load) = (&study[0], &study[study.len() - 1]);
    plot.note = format!(
        "[Tao2024] shows it in Figure 8: as the uniform depth grows, the largest force rises from {} N on {} loaded pairs to {} N on {}. The formula \
         printed in the paper for the first force has the pin radius in place of the pin circle radius and would give {} N.",
        significant(first.solution.max_force, 4),
        first.solution.loaded_pairs(),
        significant(final_load.solution.max_force, 4),
        final_load.solution.loaded_pairs(),
        significant(
            closed_form::first_max_force(&life.machine, life.machine.rated.torque.abs())
                * life.machine.ring.pin_circle_radius
                / life.machine.ring.pin_radius,
            4
        )
    );
    plot
}

fn hours_and_depth(load: &StudyLoad<'_>) -> String {
    let depth = compact(load.depth / UM, 2);
    load.hours.map_or(format!("{depth} µm"), |hours| format!("{hours:.0} h, {depth} µm"))
}

/// Distribution behind the study's uniform depth: dw(φ) = F ξ / max(F ξ) dh, integrated by the trapezoidal
/// rule over the study's levels.
fn study_depth(life: &Tao2024, study: &[StudyLoad<'_>]) -> Plot {
    let profile = life.machine.profile();
    let shares: Vec<Vec<f64>> = study
        .iter()
        .map(|load| {
            let at = |phi: f64| {
                closed_form_force(&life.machine, load, phi * DEG)
                    * profile.specific_sliding((phi * DEG).cos())
            };
            let largest = angles_deg().map(at).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
            angles_deg().map(|phi| at(phi) / largest).collect()
        })
        .collect();
    let mut plot = Plot::new("Wear along the flank in the paper's study", meshing_angle(), Axis::new("Worn depth", "µm").from_zero()).half().noted(
        "Wear depth in µm along the flank, by closed-form forces with exact sliding. [Tao2024] shows it in Figure 10 and takes the largest value of each curve as the uniform \
             depth of the next level.",
    );
    let mut depth = vec![0.0; shares[0].len()];
    for level in 1..study.len() {
        let step = (study[level].depth - study[level - 1].depth) / UM;
        for (index, value) in depth.iter_mut().enumerate() {
            *value += 0.5 * step * (shares[level - 1][index] + shares[level][index]);
        }
        plot.series.push(
            Series::line(hours_and_depth(&study[level]), angles_deg().zip(depth.iter().copied()))
                .coloured(Colour::Ordered((level - 1) as f64 / (study.len() - 2).max(1) as f64)),
        );
    }
    plot
}

/// s = 2 b ξ per pass.
fn sliding_distance(life: &Tao2024, study: &[StudyLoad<'_>]) -> Plot {
    let profile = life.machine.profile();
    let contact = life.machine.line_contact();
    let mut plot = Plot::new("Sliding distance of one pass", meshing_angle(), Axis::new("Sliding distance", "µm").from_zero()).half().noted(
        "Contact width times specific sliding, 2·b·ξ, in µm; Figure 9 of [Tao2024]. The paper's curve falls to zero near 35° and peaks at 6° and 100°; \
         with exact kinematics the sliding at the inflection is not zero (ξ = 0.92 for its RV-40E-81): the curvature changes its sign \
         there, the sliding speed does not.",
    );
    for (level, load) in study.iter().enumerate() {
        let points = angles_deg().map(|phi| {
            let cos = (phi * DEG).cos();
            let radius = 1.0 / profile.relative_curvature(cos, life.machine.ring.pin_radius);
            let force = closed_form_force(&life.machine, load, phi * DEG);
            (phi, 2.0 * contact.half_width(force, radius) * profile.specific_sliding(cos) / UM)
        });
        plot.series.push(
            Series::line(hours_and_depth(load), points)
                .coloured(Colour::Ordered(level as f64 / (study.len() - 1) as f64)),
        );
    }
    plot
}
