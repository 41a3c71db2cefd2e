//! Figures 4 and 7 of Tao2024: the flank with and without wear, and its curvature radius.

use super::Tao2024;
use crate::geometry::{Profile, Relief};
use crate::report::{Annotation, Axis, Block, Colour, Plot, Series, Style, Tone, compact, significant};
use crate::units::{DEG, UM};

/// Magnifications of the drawn wear; the largest with a regular outline is used.
const ENLARGEMENTS: [f64; 8] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0];

pub(super) fn blocks(study: &Tao2024) -> Vec<Block> {
    vec![Block::Plot(outline(study)), Block::Plot(curvature(study)), Block::Plot(sliding(study))]
}

fn outline(study: &Tao2024) -> Plot {
    let profile = study.machine.profile();
    let deepest = study.levels.last().map_or(0.0, |level| level.depth).max(1e-12);
    // An offset by the sharpest convex radius would draw a corner.
    let drawable =
        0.8 * (profile.sharpest_convex_trace().0 - profile.pin_radius).max(0.1 * profile.pin_radius);
    let enlargement =
        ENLARGEMENTS.iter().copied().rfind(|factor| factor * deepest <= drawable).unwrap_or(1.0);
    let mut plot = Plot::new("Tooth flank with and without wear", Axis::new("Along the pitch", "mm"), Axis::new("Radius from the disc centre", "mm"))
        .noted(format!(
            "One tooth space and half a tooth to each side, without pins; [Tao2024] shows it in Figure 4. Wear is magnified {enlargement:.0} times."
        ));
    plot.equal_scales = true;
    plot.series.push(Series::line("as cut", worn_outline(&profile, &Relief::uniform(0.0), 0.0)));
    if let Some(level) = study.levels.last().filter(|level| level.depth > 0.0) {
        let name = format!("uniform {} µm (×{enlargement:.0})", compact(level.depth / UM, 3));
        let outline = worn_outline(&profile, &Relief::uniform(level.depth), enlargement);
        plot.series.push(Series::new(name, Style::Dashed, outline).coloured(Colour::Palette(1)));
    }
    plot
}

/// One pitch either side of the root at τ = 0, turned so that the root looks up.
fn worn_outline(profile: &Profile, relief: &Relief, enlargement: f64) -> Vec<(f64, f64)> {
    const POINTS: i32 = 400;
    let pitch = std::f64::consts::TAU / profile.lobe_count() as f64;
    (-POINTS..=POINTS)
        .map(|i| {
            let tau = pitch * f64::from(i) / f64::from(POINTS);
            let depth = enlargement * relief.at(profile.meshing_angle(tau)).depth;
            let point = profile.flank_point(tau) - depth * profile.outward_normal(tau);
            (-point.y * 1e3, point.x * 1e3)
        })
        .collect()
}

fn meshing_angle() -> Axis {
    Axis::new("Meshing angle |φ|", "°").between(0.0, 180.0)
}

fn curvature(study: &Tao2024) -> Plot {
    let profile = study.machine.profile();
    let (sharpest_trace, at) = profile.sharpest_convex_trace();
    let sharpest = sharpest_trace - profile.pin_radius;
    let shown = (8.0 * profile.pin_radius * 1e3).max(4.0 * sharpest.abs() * 1e3);
    let mut plot = Plot::new(
        "Curvature radius of the flank",
        meshing_angle(),
        Axis::new("Curvature radius, concave positive", "mm").between(-shown, shown),
    )
    .half()
    .with(Series::line(
        "flank",
        (0..=1800).map(|tenth| {
            let phi = f64::from(tenth) * 0.1;
            let radius = profile.flank_curvature_radius((phi * DEG).cos()) * 1e3;
            // A gap at the inflection, where the radius passes through infinity.
            (phi, if radius.abs() > 3.0 * shown { f64::NAN } else { radius })
        }),
    ));
    plot.note = format!(
        "[Tao2024] shows it in Figure 7. The sharpest convex place has a radius of {} mm at {:.1}°.",
        significant(sharpest * 1e3, 3),
        at / DEG
    );
    if let Some(inflection) = profile.inflection() {
        plot.note.push_str(&format!(
            " The flank turns from concave to convex at {:.2}°; the value in the paper is “around 35°” for its RV-40E-81, whose exact value is 34.64°.",
            inflection / DEG
        ));
        plot.annotations.push(Annotation::Vertical {
            at: inflection / DEG,
            label: "inflection".into(),
            tone: Tone::Neutral,
        });
    }
    plot
}

fn sliding(study: &Tao2024) -> Plot {
    let profile = study.machine.profile();
    Plot::new("Specific sliding of the disc flank", meshing_angle(), Axis::new("Sliding per length of flank, ξ", "").from_zero())
        .half()
        .with(Series::line(
            "flank",
            (0..=900).map(|fifth| {
                let phi = f64::from(fifth) * 0.2;
                (phi, profile.specific_sliding((phi * DEG).cos()))
            }),
        ))
        .noted(
            "Sliding speed over the speed of the contact along the flank; the depth per pass is k·(F/B)·ξ, so the flank wears most where force times ξ is largest.",
        )
}
