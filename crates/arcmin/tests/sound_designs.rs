//! Designs that pass the checks are solved: a few drawn at random, and those that were hard once.

mod support;

use arcmin::design::Design;
use arcmin::dynamics::{BearingMeshing, JointSettings};
use arcmin::geometry::Relief;
use arcmin::load::ShareLoad;
use arcmin::wear::calibrate::coupled_exposure;
use arcmin::wear::paper::PaperWear;
use arcmin::wear::{CoupledOptions, CoupledWear};
use support::run::{Analysis, Outcome, run};

fn design(name: &str) -> Design {
    let path = format!("{}/tests/designs/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    Design::parse(&std::fs::read_to_string(path).unwrap(), name).unwrap()
}

/// Load sharing with ideal joints and with bearings. `examples/survey.rs` runs any number of designs through
/// everything.
#[test]
fn random_sound_designs_share_their_load() {
    for seed in 1..=6 {
        let (design, _) = support::sound_design(seed);
        assert_eq!(run(&design, Analysis::Contact), Outcome::Result, "seed {seed}");
    }
}

#[test]
fn hard_designs_share_their_load() {
    for name in [
        "one_disc_radial_interference",
        "both_offsets_interfere_at_the_tips",
        "small_ring_with_a_wide_gap",
        "ten_pins_four_discs",
    ] {
        assert_eq!(run(&design(name), Analysis::Contact), Outcome::Result, "{name}");
    }
}

/// Whatever the coefficient, a duty without speed wears nothing: a flat life, no error.
#[test]
fn a_duty_without_speed_wears_nothing() {
    let machine = design("duty_without_speed").machine();
    let meshing = machine.meshing(&Relief::uniform(0.0));
    let exposure = coupled_exposure(&machine, meshing.clone(), CoupledOptions::default()).unwrap();
    let mut wear = CoupledWear::with(&machine, meshing, CoupledOptions::default());
    wear.advance_to(exposure.at(machine.limits.service_life)).unwrap();
    assert!(wear.state().flank().is_zero());
    let paper = PaperWear::deep_enough(&machine, 7500.0).unwrap();
    assert_eq!(paper.depth_at(7500.0), 0.0);
}

/// Coefficients ten thousand times too large: an outcome with a name, the state before it kept.
#[test]
fn wear_that_runs_away_says_so() {
    let machine = design("runs_away").machine();
    let wear = PaperWear::deep_enough(&machine, 7500.0).unwrap();
    let (hours, depth) = wear.runs_away.expect("it does not run away");
    assert!(hours > 0.0 && hours < 7500.0 && depth > 100e-6, "{hours} {depth}");
    assert!((wear.depth_at(hours) / depth - 1.0).abs() < 1e-9);
    assert_eq!(wear.depth_at(0.0), 0.0);
}

/// Preload of a machine with bearings that nothing but the teeth yields in is that of ideal joints; the
/// clearance of real bearings takes a part of it up.
#[test]
fn val_bearings_and_ideal_joints_agree_on_interference() {
    let mut machine = arcmin::templates::rv_40e_81();
    machine.disc.modification.equidistant_offset = -8e-6;
    let ideal = machine.meshing(&Relief::uniform(0.0)).cycle(412.0, 6).unwrap().mean_play().arcmin();
    let mut bearings = BearingMeshing::new(&machine, &JointSettings::default()).unwrap();
    let real = bearings.whole_cycle(412.0, 6).unwrap();
    assert!(real.mean_play().arcmin() < 0.0 && real.max_preload() > 1000.0);
    assert!((real.mean_play().arcmin() / ideal - 1.0).abs() < 0.02, "{} {ideal}", real.mean_play().arcmin());
}

/// A hysteresis loop of designs whose bodies hang loose, with friction.
#[test]
fn hard_designs_run_on_the_test_bench() {
    for name in [
        "one_disc_loose_in_its_bearings",
        "four_crankshafts_wide_clearance",
        "carrier_at_rest_with_clearances",
        "ten_pins_four_discs",
    ] {
        let machine = design(name).machine();
        let points = arcmin::rig::hysteresis_loop(&machine, &JointSettings::default(), 0.0)
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let figures = arcmin::rig::evaluate_loop(&points, machine.rated.torque.abs()).unwrap();
        assert!(figures.stiffness > 0.0 && figures.lost_motion > 0.0, "{name}: {figures:?}");
        assert!(figures.work > -1e-9, "{name}: {figures:?}");
    }
}
