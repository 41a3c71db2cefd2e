//! Random designs that pass every check: a generator for property tests and surveys.
//!
//! Sizes go from robot wrists to excavator drives; every kind of modification, clearance, duty, wear law and
//! both members at rest are drawn. Numbers follow the trade (roller sizes from the bores, modules from the
//! crank circle), so that most draws are sound; the checks decide.

use std::fmt::Write as _;

use arcmin::checks::{Severity, check, worst};
use arcmin::design::Design;
use rand::{RngExt as _, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A random stream with the distributions that designs are drawn from.
struct Draw(Pcg64Mcg);

impl Draw {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// Even in the logarithm.
    fn decades(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    fn count(&mut self, low: usize, high: usize) -> usize {
        low + (self.0.random::<f64>() * (high - low + 1) as f64) as usize
    }

    fn chance(&mut self, share: f64) -> bool {
        self.0.random::<f64>() < share
    }

    fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.count(0, values.len() - 1)]
    }
}

/// The first sound design of a seed's stream, and how many were thrown away.
pub fn sound_design(seed: u64) -> (Design, usize) {
    let mut draw = Draw(Pcg64Mcg::seed_from_u64(seed));
    for tries in 0.. {
        let text = design_text(&mut draw, seed);
        if let Ok(design) = Design::parse(&text, "random.toml")
            && worst(&check(&design.machine())) < Severity::Error
        {
            return (design, tries);
        }
    }
    unreachable!("an endless stream")
}

fn design_text(draw: &mut Draw, seed: u64) -> String {
    let pins = draw.count(8, 120);
    let short_width = draw.between(0.3, 0.98);
    let circle = draw.decades(25.0, 250.0);
    let eccentricity = short_width * circle / pins as f64;
    let pitch = 2.0 * circle * (std::f64::consts::PI / pins as f64).sin();
    let pin_radius = draw.between(0.12, 0.42) * pitch;
    let discs = draw.count(1, 4);
    let cranks = draw.count(2, 4);
    let width = draw.between(0.08, 0.25) * circle / (discs as f64).sqrt();
    let span = discs as f64 * width * draw.between(1.1, 1.8);
    // Gear stage: the crankshafts stand at half the pin circle or a little more.
    let crank_circle = draw.between(0.45, 0.62) * circle;
    let (sun, planet) = (cranks * draw.count(4, 12), draw.count(17, 60));
    let module = 2.0 * crank_circle / (sun + planet) as f64;
    let bore = draw.between(0.22, 0.34) * circle;
    let roller = bore * draw.between(0.1, 0.17);
    let rollers = ((0.85 * std::f64::consts::PI * (bore - roller)) / roller) as usize;
    let torque =
        draw.decades(0.02, 1.0) * (circle / 64.0).powi(2) * width / 8.75 * 412.0 * discs as f64 / 2.0;
    let speed = draw.between(500.0, 2500.0);
    let clearance = |draw: &mut Draw, high: f64| if draw.chance(0.4) { 0.0 } else { draw.between(0.0, high) };
    let mut text = format!(
        "name = \"random {seed}\"\nfixed_member = \"{}\"\n",
        draw.one_of(&["housing", "housing", "carrier"])
    );
    let mut add = |part: std::fmt::Arguments<'_>| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{part}");
    };
    add(format_args!(
        "[ring]\npin_count = {pins}\npin_circle_radius_mm = {circle}\npin_radius_mm = {pin_radius}\n\
         material = \"GCr15\"\npin_mounting = \"{}\"\nseat_compliance_um_per_kn = {}",
        draw.one_of(&["fixed", "spinning"]),
        if draw.chance(0.7) { 0.0 } else { draw.between(0.0, 2.0) }
    ));
    add(format_args!(
        "[disc]\ncount = {discs}\nwidth_mm = {width}\nmaterial = \"GCr15\"\ncrank_bore_diameter_mm = {bore}\n\
         centre_hole_diameter_mm = {}",
        0.4 * crank_circle
    ));
    add(format_args!("[disc.modification]"));
    match draw.count(0, 4) {
        0 => {}
        1 => add(format_args!("equidistant_offset_um = {}", draw.between(-6.0, 40.0))),
        2 => add(format_args!("radial_offset_um = {}", draw.between(-40.0, 6.0))),
        3 => add(format_args!("rotation_arcmin = {}", draw.between(0.0, 2.0))),
        _ => add(format_args!(
            "equidistant_offset_um = {}\nradial_offset_um = {}\nrotation_arcmin = {}",
            draw.between(-10.0, 60.0),
            draw.between(-60.0, 10.0),
            draw.between(0.0, 1.0)
        )),
    }
    add(format_args!(
        "[crankshafts]\ncount = {cranks}\neccentricity_mm = {eccentricity}\nfirst_angle_deg = 90\n\
         shaft_diameter_mm = {}\nmaterial = \"GCr15\"",
        bore - 2.0 * roller
    ));
    add(format_args!(
        "[gear_stage]\nsun_teeth = {sun}\nplanet_teeth = {planet}\nmodule_mm = {module}\n\
         pressure_angle_deg = {}\nface_width_mm = {width}\nmesh_stiffness_n_per_um = {}\n\
         mesh_stiffness_variation = {}\nbacklash_um = {}\nsun_inertia_kg_m2 = 1e-5\nmotor_inertia_kg_m2 = 2e-4",
        draw.one_of(&[20.0, 25.0, 30.0]),
        15.0 * width,
        draw.one_of(&[0.0, 0.1]),
        clearance(draw, 50.0)
    ));
    add(format_args!(
        "[carrier]\nmass_kg = {}\ninertia_kg_m2 = {}\nmaterial = \"20CrMnTi\"",
        2.5 * (circle / 64.0).powi(3),
        5e-3 * (circle / 64.0).powi(5)
    ));
    if draw.chance(0.3) {
        add(format_args!("torsional_stiffness_n_m_per_arcmin = {}", 1.5 * torque * draw.between(0.5, 2.0)));
    }
    add(format_args!("[bearings]\ncrank_support_span_mm = {span}"));
    add(format_args!(
        "[bearings.turning_arm]\nkind = \"cylindrical\"\nroller_count = {rollers}\nroller_diameter_mm = {roller}\n\
         roller_length_mm = {}\npitch_diameter_mm = {}\nclearance_um = {}",
        0.9 * width,
        bore - roller,
        clearance(draw, 40.0)
    ));
    let kind = draw.one_of(&["tapered", "cylindrical", "ball"]);
    add(format_args!(
        "[bearings.crank_support]\nkind = \"{kind}\"\nroller_count = {}\nroller_diameter_mm = {roller}\n\
         pitch_diameter_mm = {bore}\ncontact_angle_deg = {}\nclearance_um = {}",
        rollers * 9 / 10,
        draw.one_of(&[0.0, 12.0]),
        clearance(draw, 25.0)
    ));
    if kind != "ball" {
        add(format_args!("roller_length_mm = {}", width.min(3.0 * roller)));
    }
    add(format_args!(
        "[bearings.main]\nradial_stiffness_n_per_um = {}\nclearance_um = {}",
        draw.between(0.5, 2.0) * 8.0 * circle,
        if draw.chance(0.7) { 0.0 } else { draw.between(0.0, 10.0) }
    ));
    let rubs = draw.chance(0.7);
    let rub = |draw: &mut Draw, high: f64| if rubs { draw.between(0.0, high) } else { 0.0 };
    add(format_args!(
        "[friction]\nflank_coefficient = {}\npin_seat_coefficient = {}\nbearing_coefficient = {}\n\
         gear_mesh_coefficient = {}\nseal_drag_n_m = {}",
        rub(draw, 0.1),
        rub(draw, 0.1),
        rub(draw, 0.003),
        rub(draw, 0.08),
        rub(draw, 0.01 * torque)
    ));
    let laws = ["law = \"line-hertz\""; 4];
    let law = draw.one_of(&[laws[0], laws[1], laws[2], "law = \"palmgren\"", "law = \"tao2024\""]);
    add(format_args!("[contact]\n{law}\n[load]\nrated_torque_n_m = {torque}\ninput_speed_rpm = {speed}"));
    let rows = draw.count(0, 4);
    for _ in 0..rows {
        add(format_args!(
            "[[duty]]\ntorque_n_m = {}\ninput_speed_rpm = {}\nshare = {}",
            torque * draw.one_of(&[1.0, -1.0, 0.5, -0.6, 1.5, 0.0]),
            speed * draw.one_of(&[1.0, -0.7, 0.3, 0.0]),
            1.0 / rows as f64
        ));
    }
    add(format_args!("[wear]\npin_ratio = {}", draw.one_of(&[0.0, 0.0, 1.0, 1.5])));
    match draw.count(0, 3) {
        0 => add(format_args!(
            "[wear.coupled]\nafter_h = {}\ndepth_um = {}",
            draw.between(500.0, 8000.0),
            draw.decades(0.3, 30.0)
        )),
        1 => add(format_args!(
            "[wear.coupled]\nafter_h = {}\nlost_motion_arcmin = {}",
            draw.between(500.0, 8000.0),
            draw.decades(0.02, 0.5)
        )),
        _ => add(format_args!("[wear.coupled]\ncoefficient_mm2_per_n = {}", draw.decades(1e-14, 3e-11))),
    }
    if draw.chance(0.3) {
        add(format_args!(
            "[wear.lubrication]\nviscosity_mpa_s = {}\nroughness_um = 0.1",
            draw.between(5.0, 300.0)
        ));
    }
    if draw.chance(0.3) {
        add(format_args!(
            "[wear.turning_arm]\ncoefficient_mm2_per_n = {}\nslip = 0.01",
            draw.decades(1e-16, 1e-13)
        ));
    }
    add(format_args!("[limits]\nlost_motion_arcmin = 1\nservice_life_h = 7500"));
    add(format_args!(
        "[tolerances]\npin_position_um = 3\npin_radius_um = 1\neccentricity_um = 2\nbore_position_um = 4\n\
         flank_run_out_um = 4\nflank_pitch_um = 3\njournal_run_out_um = 2"
    ));
    text
}
