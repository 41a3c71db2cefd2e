//! Figures 9 and 10 of Tao2024: sliding distance and worn depth along the flank, and the depth over hours.

use super::load::{StudyLoad, closed_form_force, hours_and_depth, study_loads};
use super::{LifePage, LifeRow};
use crate::geometry::Relief;
use crate::report::{Axis, Block, Colour, Plot, Series, Style, significant};
use crate::units::{DEG, UM};

const ANGLES: i32 = 360;

fn angles_deg() -> impl Iterator<Item = f64> {
    (0..=ANGLES).map(|i| 180.0 * f64::from(i) / f64::from(ANGLES))
}

fn meshing_angle() -> Axis {
    Axis::new("Meshing angle |φ|", "°").between(0.0, 180.0)
}

pub(super) fn blocks(life: &LifePage) -> Vec<Block> {
    let mut blocks = vec![Block::Plot(depth_over_hours(life))];
    let study = study_loads(life);
    if !life.flanks.is_empty() {
        blocks.push(Block::Plot(predicted_depth(life)));
    }
    if study.len() > 1 {
        blocks.push(Block::Plot(study_depth(life, &study)));
        blocks.push(Block::Plot(sliding_distance(life, &study)));
    }
    blocks
}

fn depth_over_hours(life: &LifePage) -> Plot {
    let depths = |rows: &[LifeRow]| rows.iter().map(|row| (row.hours, row.max_depth_um)).collect::<Vec<_>>();
    let mut plot = Plot::new(
        "Deepest wear over running time",
        Axis::new("Running time", "h"),
        Axis::new("Largest depth", "µm").from_zero(),
    )
    .half()
    .with(Series::line("predicted (coupled)", depths(life.prediction)).strong().coloured(Colour::Palette(0)));
    plot.note = format!(
        "Wear law [Archard1953] with k = {} 1/Pa",
        significant(life.prediction_coefficient_per_pa, 3)
    );
    if life.study.len() > 1 {
        plot.series.push(
            Series::new("paper's study (uniform depth)", Style::LineMarkers, depths(life.study))
                .coloured(Colour::Palette(1)),
        );
        plot.note.push_str(&format!(
            "; the study grows a uniform depth at the rate of its worst point with k = {} 1/Pa. The two coefficients are calibrated separately, \
             so the curves compare shapes, not machines",
            significant(life.study_coefficient_per_pa, 3)
        ));
    }
    plot.note.push('.');
    plot
}

/// Depth of the loaded flank at the hours of the snapshots, and of the other flank where it wears too.
fn predicted_depth(life: &LifePage) -> Plot {
    let mut plot = Plot::new(
        "Wear along the flank as predicted (coupled)",
        meshing_angle(),
        Axis::new("Worn depth", "µm").from_zero(),
    )
    .half();
    let side = life.loaded_side();
    let on_side = |flank: &Relief, side: f64| {
        angles_deg().map(|phi| (phi, flank.at(side * phi * DEG).depth / UM)).collect::<Vec<_>>()
    };
    let last = life.flanks.len().saturating_sub(1).max(1) as f64;
    for (index, worn) in life.flanks.iter().enumerate().filter(|(_, worn)| !worn.flank.is_zero()) {
        plot.series.push(
            Series::line(format!("{:.0} h", worn.hours), on_side(worn.flank, side))
                .coloured(Colour::Ordered(index as f64 / last)),
        );
    }
    if let Some(worn) = life.flanks.last().filter(|worn| !worn.flank.is_zero()) {
        let other = on_side(worn.flank, -side);
        let deepest = other.iter().map(|point| point.1).fold(0.0, f64::max);
        // Beyond the contact width next to the root, the other flank wears only if the duty reverses.
        if deepest > 0.2 * worn.flank.deepest().0 / UM {
            plot.series.push(
                Series::new(format!("other flank, {:.0} h", worn.hours), Style::Dashed, other)
                    .coloured(Colour::Reference),
            );
        }
        plot.note = format!(
            "Figure 10 of [Tao2024], with load sharing solved again as the flank changes: {} µm at most, at {:.0}°.",
            significant(worn.flank.deepest().0 / UM, 3),
            (worn.flank.deepest().1 / DEG).abs()
        );
    }
    plot
}

/// Distribution behind the study's uniform depth: dw(φ) = F ξ / max(F ξ) dh, integrated by the trapezoidal
/// rule over the study's levels.
fn study_depth(life: &LifePage, study: &[StudyLoad]) -> Plot {
    let profile = life.machine.profile();
    let shares: Vec<Vec<f64>> = study
        .iter()
        .map(|load| {
            let at = |phi: f64| {
                closed_form_force(life.machine, load, phi * DEG) * profile.specific_sliding((phi * DEG).cos())
            };
            let largest = angles_deg().map(at).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
            angles_deg().map(|phi| at(phi) / largest).collect()
        })
        .collect();
    let mut plot = Plot::new("Wear along the flank in the paper's study", meshing_angle(), Axis::new("Worn depth", "µm").from_zero()).half().noted(
        "Figure 10 of [Tao2024] from the closed-form forces and exact sliding. The paper takes the largest value of each curve as a uniform \
             depth for the next level.",
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
fn sliding_distance(life: &LifePage, study: &[StudyLoad]) -> Plot {
    let profile = life.machine.profile();
    let contact = life.machine.line_contact();
    let mut plot = Plot::new("Sliding distance of one pass", meshing_angle(), Axis::new("Sliding distance", "µm").from_zero()).half().noted(
        "Figure 9 of [Tao2024]: contact width times specific sliding, 2·b·ξ. The paper's curve falls to zero near 35° and peaks at 6° and 100°; \
         with exact kinematics the sliding at the inflection is not zero (ξ = 0.92 for its RV-40E-81), because only the curvature changes \
         its sign there, not the sliding speed.",
    );
    for (level, load) in study.iter().enumerate() {
        let points = angles_deg().map(|phi| {
            let cos = (phi * DEG).cos();
            let radius = 1.0 / profile.relative_curvature(cos, life.machine.ring.pin_radius);
            let force = closed_form_force(life.machine, load, phi * DEG);
            (phi, 2.0 * contact.half_width(force, radius) * profile.specific_sliding(cos) / UM)
        });
        plot.series.push(
            Series::line(hours_and_depth(load), points)
                .coloured(Colour::Ordered(level as f64 / (study.len() - 1) as f64)),
        );
    }
    plot
}
