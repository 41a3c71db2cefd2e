//! Writes a page with every kind of block, filled from closed forms of the RV-40E-81:
//!
//! `cargo run --release -p arcmin --example report_demo -- demo.html`
//!
//! It serves to look at the components when their style changes; the numbers are those of the
//! handbook formulas, not of a solver.

use std::f64::consts::PI;

use arcmin::report::{
    Annotation, Axis, Block, Colour, Column, CrankshaftDrawing, ForceState, GearStageDrawing, HeatMap, Hole,
    KeyFigure, Mechanism, MeshField, MeshPicture, Page, Plot, Provenance, Reference, Section, Series, Shares,
    Style, Table, Tone, Verdict, significant,
};

const PIN_COUNT: usize = 40;
const LOBE_COUNT: usize = 39;
const PIN_CIRCLE_RADIUS_MM: f64 = 64.0;
const PIN_RADIUS_MM: f64 = 3.0;
const ECCENTRICITY_MM: f64 = 1.3;
const WIDTH_MM: f64 = 8.75;
const TORQUE_N_M: f64 = 412.0;
/// a z_p / R_p
const SHORT_WIDTH: f64 = ECCENTRICITY_MM * PIN_COUNT as f64 / PIN_CIRCLE_RADIUS_MM;

fn main() -> std::io::Result<()> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "report_demo.html".into());
    std::fs::write(path, page().render())
}

fn slope_factor(phi: f64) -> f64 {
    (1.0 + SHORT_WIDTH * SHORT_WIDTH - 2.0 * SHORT_WIDTH * phi.cos()).sqrt()
}

/// Lever arm over its maximum: sin φ / S.
fn lever(phi: f64) -> f64 {
    phi.sin() / slope_factor(phi)
}

fn flank_curvature_radius_mm(phi: f64) -> f64 {
    let z = PIN_COUNT as f64;
    PIN_CIRCLE_RADIUS_MM * slope_factor(phi).powi(3)
        / (SHORT_WIDTH * (1.0 + z) * phi.cos() - (1.0 + z * SHORT_WIDTH * SHORT_WIDTH))
        + PIN_RADIUS_MM
}

/// Closed-form forces with an equidistant gap: proportional to lever − gap/δ_max, positive ones only.
fn forces_n(angles: &[f64], wear_um: f64) -> Vec<f64> {
    let lever_max_m = ECCENTRICITY_MM * LOBE_COUNT as f64 * 1e-3;
    let mut largest = 447.0;
    let mut forces = Vec::new();
    for _ in 0..200 {
        let approach_um = 1.5 * largest / 447.0;
        let relative: Vec<f64> = angles
            .iter()
            .map(|&phi| (lever(phi) - wear_um * (1.0 - lever(phi)) / approach_um).max(0.0))
            .collect();
        let sum: f64 = relative.iter().zip(angles).map(|(f, &phi)| f * lever(phi)).sum();
        largest = 0.5 * largest + 0.5 * 0.55 * TORQUE_N_M / lever_max_m / sum;
        forces = relative.iter().map(|f| f * largest).collect();
    }
    forces
}

fn degrees(range: std::ops::RangeInclusive<usize>) -> impl Iterator<Item = f64> {
    range.map(|degree| degree as f64)
}

fn page() -> Page {
    Page {
        title: "RV-40E-81".into(),
        subtitle: "Accuracy over life (demonstration of the report's parts)".into(),
        provenance: Provenance {
            version: env!("CARGO_PKG_VERSION").into(),
            design_hash: "demo".into(),
            command: "cargo run --example report_demo -- demo.html".into(),
            seeds: vec![7],
        },
        verdict: verdict(),
        sections: vec![
            Section::new("mechanism", "Mechanism and contact forces", vec![Block::Mechanism(mechanism())]),
            Section::new("geometry", "Tooth flank and load", geometry()),
            Section::new("life", "Accuracy over life", life()),
            Section::new("machine", "The whole machine", machine()),
            Section::new("mesh", "Flexible disc", vec![Block::Mesh(mesh())]),
            Section::new(
                "design",
                "Design as used",
                vec![Block::Code {
                    title: "rv-40e-81.toml".into(),
                    text: "[cycloid]\nlobe_count = 39\npin_count = 40\neccentricity_mm = 1.3\n# <given by Tao2024 & checked>\n".into(),
                }],
            ),
            Section::new("literature", "Literature", vec![Block::References(references())]),
        ],
    }
}

fn verdict() -> Verdict {
    let figure = |label: &str, value: f64, unit: &str, note: &str, tone| KeyFigure {
        tone,
        ..KeyFigure::new(label, significant(value, 3), unit, note)
    };
    Verdict {
        figures: vec![
            figure("Transmission error, new", 0.654, "arcmin", "without load, ± half of the band", Tone::Good),
            figure("Lost motion after 7500 h", 0.72, "arcmin", "limit 1.0 arcmin", Tone::Good),
            figure("Hours to the limit", 11200.0, "h", "extrapolated; the study ends at 7500 h", Tone::Caution),
            figure("Contact pressure", 1316.0, "MPa", "at 61°, limit 1500 MPa", Tone::Neutral),
        ],
        answers: vec![
            (
                "What limits it".into(),
                "Wear of the disc flank at 61° meshing angle, where pressure and sliding together are largest [Tao2024].".into(),
            ),
            ("What to change".into(), "A wider disc lowers the wear in proportion; 10 mm instead of 8.75 mm gives 14 % more hours.".into()),
        ],
        summary: "RV-40E-81, arcmin demo\nTransmission error new: 0.654 arcmin\nHours to the limit: 11200 h\n".into(),
        ..Verdict::new(Tone::Good, "Stays below 1 arcmin of lost motion for the whole 7500 h.")
    }
}

fn geometry() -> Vec<Block> {
    let angle = || Axis::new("Meshing angle |φ|", "°").between(0.0, 180.0);
    let mut curvature = Plot::new(
        "Curvature radius of the flank",
        angle(),
        Axis::new("Curvature radius, concave positive", "mm").between(-40.0, 40.0),
    )
    .half()
    .noted("The flank turns from concave to convex at 34.6° (Figure 7 of [Tao2024]).");
    curvature.series.push(Series::line(
        "flank",
        degrees(0..=720).map(|quarter| {
            let phi = quarter / 4.0;
            let radius = flank_curvature_radius_mm(phi.to_radians());
            (phi, if radius.abs() > 200.0 { f64::NAN } else { radius })
        }),
    ));
    curvature.annotations.push(Annotation::Vertical {
        at: 34.644,
        label: "inflection".into(),
        tone: Tone::Neutral,
    });

    let mut force =
        Plot::new("Contact force over the meshing angle", angle(), Axis::new("Force", "N").from_zero())
            .half()
            .noted("With wear fewer pins carry and the largest force rises (Figure 8 of [Tao2024]).");
    let grid: Vec<f64> = degrees(1..=180).collect();
    for step in 0..=6 {
        let wear = f64::from(step) * 10.0;
        let points = grid.iter().map(|&phi| {
            // The curve through all pins: one pin at phi, the others a pitch apart.
            let pitch = 360.0 / PIN_COUNT as f64;
            let angles: Vec<f64> =
                (0..PIN_COUNT / 2).map(|pin| ((phi % pitch) + pin as f64 * pitch).to_radians()).collect();
            (phi, forces_n(&angles, wear / 10.0)[(phi / pitch) as usize % (PIN_COUNT / 2)])
        });
        force.series.push(
            Series::line(format!("{} h", step * 1250), points)
                .coloured(Colour::Ordered(f64::from(step) / 6.0)),
        );
    }
    force.series.push(
        Series::markers("Tao2024", [(36.0, 447.0), (60.0, 402.0), (90.0, 325.0)]).coloured(Colour::Reference),
    );
    vec![
        Block::Text(
            "Closed forms of the flank as cut. The lever arm of the normal force is `a z_c sin φ / S`."
                .into(),
        ),
        Block::Plot(curvature),
        Block::Plot(force),
        Block::Plot(outline()),
        Block::Note(
            Tone::Caution,
            "Pressure is shown for the nominal width of 8.75 mm; edge loading is not modelled.".into(),
        ),
        Block::Table(Table {
            title: "Largest values".into(),
            columns: vec![Column::text("Quantity"), Column::number("Value", "–"), Column::number("At", "°")],
            rows: vec![
                vec!["Lever arm".into(), "50.7 mm".into(), "35.66".into()],
                vec![
                    "Force per width".into(),
                    format!("{} N/mm", significant(447.0 / WIDTH_MM, 3)),
                    "35.7".into(),
                ],
            ],
            note: "Values of one disc under 0.55 of the rated torque.".into(),
        }),
    ]
}

fn outline() -> Plot {
    let mut plot = Plot::new("Flank with and without wear", Axis::new("x", "mm"), Axis::new("y", "mm"))
        .noted("Wear drawn ten times larger than computed.");
    plot.equal_scales = true;
    for (name, wear, style) in [("as cut", 0.0, Style::Line), ("worn 60 µm (×10)", 0.6, Style::Dashed)] {
        let points = (-60..=60).map(|step| {
            let [x, y] = flank_point(f64::from(step) * 0.002, wear);
            (y, x)
        });
        plot.series.push(Series::new(name, style, points));
    }
    plot
}

/// c(τ) + (r_p + wear) n(τ).
fn flank_point(tau: f64, wear_mm: f64) -> [f64; 2] {
    let z = PIN_COUNT as f64;
    let centre = [
        PIN_CIRCLE_RADIUS_MM * tau.cos() - ECCENTRICITY_MM * (z * tau).cos(),
        PIN_CIRCLE_RADIUS_MM * tau.sin() - ECCENTRICITY_MM * (z * tau).sin(),
    ];
    let tangent = [
        -PIN_CIRCLE_RADIUS_MM * tau.sin() + ECCENTRICITY_MM * z * (z * tau).sin(),
        PIN_CIRCLE_RADIUS_MM * tau.cos() - ECCENTRICITY_MM * z * (z * tau).cos(),
    ];
    let size = tangent[0].hypot(tangent[1]);
    let depth = PIN_RADIUS_MM + wear_mm;
    [centre[0] - depth * tangent[1] / size, centre[1] + depth * tangent[0] / size]
}

fn life() -> Vec<Block> {
    let hours = |step: i32| f64::from(step) * 75.0;
    let mut play = Plot::new(
        "Accuracy over running time",
        Axis::new("Running time", "h"),
        Axis::new("Angle at the output", "arcmin").from_zero(),
    );
    play.series.push(
        Series::band(
            "transmission error band",
            (0..=100).map(|s| {
                let mean = 0.5 + 0.2 * (hours(s) / 7500.0).sqrt();
                (hours(s), mean - 0.08, mean + 0.1)
            }),
        )
        .coloured(Colour::Palette(0)),
    );
    play.series.push(
        Series::line(
            "transmission error",
            (0..=100).map(|s| (hours(s), 0.5 + 0.2 * (hours(s) / 7500.0).sqrt())),
        )
        .coloured(Colour::Palette(0))
        .strong(),
    );
    play.series.push(Series::new(
        "lost motion",
        Style::Step,
        (0..=25).map(|s| (hours(4 * s), 0.72 * (hours(4 * s) / 7500.0).powf(0.4))),
    ));
    play.series
        .push(Series::markers("measured", [(600.0, 0.177), (1550.0, 0.215)]).coloured(Colour::Reference));
    play.limit_at(1.0, "limit 1.0 arcmin");
    let mut spectrum = Plot::new(
        "Orders of the transmission error",
        Axis::new("Order of the output turn", ""),
        Axis::new("Amplitude", "arcmin").from_zero(),
    )
    .half();
    spectrum.series.push(Series::new(
        "rated load",
        Style::Bars,
        [(1.0, 0.12), (3.0, 0.05), (39.0, 0.31), (40.0, 0.22), (78.0, 0.08), (80.0, 0.04), (81.0, 0.06)],
    ));
    spectrum.annotations.push(Annotation::Point { x: 39.0, y: 0.31, label: "z_c: disc profile".into() });
    let mut noisy = Plot::new(
        "Transmission error, 40 000 samples",
        Axis::new("Time", "s"),
        Axis::new("Transmission error", "arcmin"),
    )
    .half();
    noisy.series.push(Series::line(
        "no load",
        (0..40_000).map(|i| {
            let t = f64::from(i) * 2e-5;
            (t, 0.4 * (2.0 * PI * t / 0.3).sin() + 0.1 * (2.0 * PI * 740.0 * t).sin())
        }),
    ));
    vec![Block::Plot(play), Block::Plot(spectrum), Block::Plot(noisy)]
}

fn machine() -> Vec<Block> {
    let torques: Vec<f64> = degrees(1..=20).map(|i| i * 25.0).collect();
    let speeds: Vec<f64> = degrees(1..=16).map(|i| i * 125.0).collect();
    let cells = speeds
        .iter()
        .flat_map(|n| torques.iter().map(move |t| Some(0.93 * t / (t + 18.0 + 0.012 * n))))
        .collect();
    let angle =
        |t: f64, up: f64| t / 108.0 + 0.25 * (t / 30.0).tanh() - up * 0.2 * (1.0 - (t / 412.0).powi(2));
    let mut loop_plot = Plot::new(
        "Hysteresis loop",
        Axis::new("Output torque", "N·m"),
        Axis::new("Output angle, input locked", "arcmin"),
    )
    .half();
    loop_plot.series.push(Series::line(
        "rising",
        (-100..=100).map(|i| (f64::from(i) * 4.12, angle(f64::from(i) * 4.12, 1.0))),
    ));
    loop_plot.series.push(Series::line(
        "falling",
        (-100..=100).rev().map(|i| (f64::from(i) * 4.12, angle(f64::from(i) * 4.12, -1.0))),
    ));
    vec![
        Block::HeatMap(HeatMap {
            title: "Efficiency".into(),
            x: Axis::new("Output torque", "N·m"),
            y: Axis::new("Input speed", "rpm"),
            value: Axis::new("Efficiency", ""),
            x_values: torques,
            y_values: speeds,
            cells,
            note: "Cells reach half-way to their neighbours.".into(),
            width: arcmin::report::Width::Half,
        }),
        Block::Plot(loop_plot),
        Block::Shares(Shares {
            title: "Where the compliance sits".into(),
            unit: "arcmin per 100 N·m".into(),
            rows: vec![
                ("Turning-arm bearings".into(), 0.52, "needle rollers, 5 µm clearance".into()),
                ("Crank bending".into(), 0.21, String::new()),
                ("Tooth contacts".into(), 0.03, String::new()),
            ],
            note: String::new(),
        }),
    ]
}

fn mechanism() -> Mechanism {
    let tau_of = |step: usize| 2.0 * PI / LOBE_COUNT as f64 * step as f64 / 48.0;
    let table = |wear: f64, phase: f64| {
        let steps = 12;
        (0..steps)
            .map(|step| {
                let crank = phase + 2.0 * PI / PIN_COUNT as f64 * step as f64 / steps as f64;
                let angles: Vec<f64> =
                    (0..PIN_COUNT).map(|pin| 2.0 * PI * pin as f64 / PIN_COUNT as f64 - crank).collect();
                // Positive torque loads the flanks at negative meshing angles.
                let mirrored: Vec<f64> = angles.iter().map(|phi| -phi).collect();
                forces_n(&mirrored, wear)
            })
            .collect::<Vec<_>>()
    };
    let state = |label: &str, wear| ForceState {
        label: label.into(),
        force_n: vec![table(wear, 0.0), table(wear, PI)],
    };
    let hole = |x_mm, y_mm, radius_mm| Hole { x_mm, y_mm, radius_mm };
    Mechanism {
        title: "RV-40E-81, seen from the output side".into(),
        note: "To scale. Forces of the handbook's closed form at 412 N·m; displacements of micrometres do not show.".into(),
        pin_circle_radius_mm: PIN_CIRCLE_RADIUS_MM,
        pin_radius_mm: PIN_RADIUS_MM,
        pin_count: PIN_COUNT,
        lobe_count: LOBE_COUNT,
        eccentricity_mm: ECCENTRICITY_MM,
        housing_outer_radius_mm: 76.0,
        lobe_mm: (0..48).map(|step| flank_point(tau_of(step), 0.0)).collect(),
        eccentric_phase_deg: vec![0.0, 180.0],
        holes: vec![hole(0.0, 40.5, 13.5), hole(0.0, -40.5, 13.5), hole(0.0, 0.0, 20.0)],
        crankshafts: CrankshaftDrawing { circle_radius_mm: 40.5, place_deg: vec![90.0, 270.0], shaft_radius_mm: 7.5, eccentric_radius_mm: 9.0 },
        gear_stage: GearStageDrawing { sun_teeth: 18, planet_teeth: 36, sun_pitch_radius_mm: 13.5, planet_pitch_radius_mm: 27.0 },
        input_speed_rpm: 1500.0,
        states: vec![state("new", 0.0), state("7500 h", 4.0)],
    }
}

fn mesh() -> MeshPicture {
    let (rings, sectors) = (8_u32, 72_u32);
    let mut picture = MeshPicture {
        title: "Ring under a cosine load".into(),
        note: "A structured mesh with a made-up displacement.".into(),
        nodes_mm: Vec::new(),
        triangles: Vec::new(),
        displacement_um: Vec::new(),
        field: None,
    };
    let mut values = Vec::new();
    for ring in 0..=rings {
        for sector in 0..sectors {
            let (radius, angle) =
                (20.0 + 5.0 * f64::from(ring), 2.0 * PI * f64::from(sector) / f64::from(sectors));
            let bulge = 0.3 * (2.0 * angle).cos() * radius / 60.0;
            picture.nodes_mm.push([radius * angle.cos(), radius * angle.sin()]);
            picture.displacement_um.push([bulge * angle.cos(), bulge * angle.sin()]);
            values.push(bulge.abs());
            if ring < rings {
                let node = |r: u32, s: u32| r * sectors + s % sectors;
                picture.triangles.push([
                    node(ring, sector),
                    node(ring + 1, sector),
                    node(ring + 1, sector + 1),
                ]);
                picture.triangles.push([
                    node(ring, sector),
                    node(ring + 1, sector + 1),
                    node(ring, sector + 1),
                ]);
            }
        }
    }
    picture.field = Some(MeshField { label: "displacement".into(), unit: "µm".into(), values });
    picture
}

fn references() -> Vec<Reference> {
    vec![Reference {
        key: "Tao2024".into(),
        citation: "Tao, Y.; Liu, H.; Wu, M.; Zheng, N.; Pei, J. The Effect of Cycloid Gear Wear on the Transmission Accuracy of the RV Reducer. Machines 2024, 12(8), 511.".into(),
        doi: Some("10.3390/machines12080511".into()),
        used_for: "Wear law, closed-form load sharing, comparison values.".into(),
    }]
}
