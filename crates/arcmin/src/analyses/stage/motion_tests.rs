//! Drives of eccentrics in time against their states of rest.

use super::simulate;
use super::{EccentricDrive, rig};
use crate::analyses::{NoHost, Outcome};
use crate::design::{StageDesign, TwoRingDesign, TwoStageDesign};
use crate::templates::{NEMA17_19, TWO_RING_225, TWO_STAGE_500};
use crate::units::ARCMIN;

fn options(text: &str) -> simulate::Options {
    simulate::Options::parse(text, "options").unwrap()
}

/// A slow drive under a constant load passes through its states of rest: the same mean error, and no energy is lost but
/// in dampers.
fn is_that_of_the_bench<D: EccentricDrive>(design: &D) {
    let slow = options("load = \"constant\"\nspeed_rpm = 600\nrise_s = 0.02\nend_s = 0.32\ntolerance = 1e-3");
    let run = simulate::run(design, &slow, &NoHost).unwrap();
    let statistics = run.motion.result.statistics.unwrap();
    let bench = rig::Options::parse("positions = 1\nte_positions = 60", "options").unwrap();
    let rest = rig::run(design, &bench, &NoHost).unwrap();
    let mean = rest.errors.iter().map(|[_, error]| *error).sum::<f64>() / rest.errors.len() as f64;
    assert!((statistics.mean - mean).abs() < 0.01 * mean.abs(), "{} {mean}", statistics.mean);
    assert!((run.motion.result.mean_ratio.unwrap() / design.ratio() - 1.0).abs() < 1e-3);
    let energy = run.motion.result.energy;
    assert!(
        energy.residual() < 1e-5 && energy.load * design.ratio() > 0.0 && energy.dissipated > 0.0,
        "{energy:?}"
    );
}

#[test]
fn slow_motion_passes_through_states_of_rest() {
    is_that_of_the_bench(&StageDesign::parse(NEMA17_19.text, "stage").unwrap());
    is_that_of_the_bench(&TwoRingDesign::parse(TWO_RING_225.text, "rings").unwrap());
    is_that_of_the_bench(&TwoStageDesign::parse(TWO_STAGE_500.text, "stages").unwrap());
}

#[test]
fn driven_housings_and_ages_without_wear_are_refused() {
    let text = NEMA17_19.text;
    let design = StageDesign::parse(text, "stage").unwrap();
    let turned = design.with_all([("fixed_member", "output")]).unwrap();
    let said = simulate::run(&turned, &options(""), &NoHost).unwrap_err().to_string();
    assert!(said.contains("driven housing"), "{said}");
    let worn =
        simulate::run(&design, &options("hours = 500\nload = \"constant\"\nend_s = 0.15"), &NoHost).unwrap();
    let new = simulate::run(&design, &options("load = \"constant\"\nend_s = 0.15"), &NoHost).unwrap();
    let mean = |run: &simulate::StageMotion| run.motion.result.statistics.unwrap().mean_abs / ARCMIN;
    assert!(mean(&worn) > mean(&new), "{} {}", mean(&worn), mean(&new));
    assert_eq!(worn.summary().number("hours"), Some(500.0));
}
