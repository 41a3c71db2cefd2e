//! Drives of eccentrics in time against their static equilibria.

use super::simulate;
use super::{EccentricDrive, rig};
use crate::analyses::{NoHost, Outcome};
use crate::design::{StageDesign, TwoRingDesign, TwoStageDesign};
use crate::dynamics::{EquilibriumControl, solve_equilibrium};
use crate::templates::{NEMA17_19, PRINTED_15, STEEL_59, TWO_RING_225, TWO_STAGE_500};
use crate::units::ARCMIN;

fn options(text: &str) -> simulate::Options {
    simulate::Options::parse(text, "options").unwrap()
}

/// A slow drive under a constant load passes through its static equilibria: the same mean error, and no energy is lost but
/// in dampers.
fn is_that_of_the_bench<D: EccentricDrive>(design: &D) {
    let slow = options("load = \"constant\"\nspeed_rpm = 600\nrise_s = 0.02\nend_s = 0.32\ntolerance = 1e-3");
    let run = simulate::run(design, &slow, &NoHost).unwrap();
    let statistics = run.motion.result.statistics.unwrap();
    let bench =
        rig::Options::parse("discs = \"rigid\"\npositions = 1\nte_positions = 60", "options").unwrap();
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
#[ignore = "long"]
fn slow_motion_passes_through_states_of_rest() {
    for template in [NEMA17_19, PRINTED_15, STEEL_59] {
        is_that_of_the_bench(&StageDesign::parse(template.text, template.file).unwrap());
    }
    is_that_of_the_bench(&TwoRingDesign::parse(TWO_RING_225.text, "rings").unwrap());
    is_that_of_the_bench(&TwoStageDesign::parse(TWO_STAGE_500.text, "stages").unwrap());
}

/// The same drive with the ring at rest and with the output pins at rest. With the same angle of the input against the ring and
/// the same torque on the output pins, relative positions and forces are the same.
#[test]
fn a_driven_housing_has_the_states_of_rest_of_its_ring() {
    let design = StageDesign::parse(NEMA17_19.text, "stage").unwrap();
    let turned = design.with_all([("fixed_member", "output")]).unwrap();
    let (mut held, mut driven) = (design.new_drive(&[]).unwrap(), turned.moving(&[]).unwrap());
    let pins = 20.0;
    for (angle, torque) in [(0.3, 3.0), (1.7, -2.0), (40.0, 0.6)] {
        driven.hold_input(angle, 0.0);
        driven.set_load(torque);
        let start = driven.nominal_position_at(angle);
        let control = EquilibriumControl { tolerance: 1e-9, force_tolerance: 1e-9, held: None };
        let place = solve_equilibrium(&*driven, 0.0, &start, control).unwrap().position;
        let ring = place[driven.output_index()];
        // The torque on the output pins is the sum of the torques of ring and input. It varies with the position about z_c/z_p
        // of that of the ring.
        let (still, mut force) = (vec![0.0; place.len()], vec![0.0; place.len()]);
        let (_, input) = driven.evaluate_with_input(0.0, &place, &still, &mut force, None);
        assert!((input * pins / torque - 1.0).abs() < 0.1, "{input}");
        let (seen, _) = held.rest(angle - ring, input - torque, None).unwrap();
        let output = seen[held.joints().output_index()];
        assert!((output + ring).abs() < 1e-9, "{output} {ring}");
        for disc in 0..2 {
            let [one, other] = [(held.joints(), &seen), (&driven, &place)].map(|(joints, place)| {
                joints.pin_contacts(disc, place).into_iter().map(|contact| contact.force)
            });
            let most = one.clone().fold(0.0, f64::max);
            for (one, other) in one.zip(other) {
                assert!((one - other).abs() < 1e-5 * most, "{one} {other} of {most}");
            }
            let [one, other] = [(held.joints(), &seen), (&driven, &place)]
                .map(|(joints, place)| joints.eccentric_force(disc, place));
            assert!((one / other - 1.0).abs() < 1e-5, "{one} {other}");
        }
    }
}

#[test]
fn driven_housings_pass_through_states_of_rest() {
    let design = StageDesign::parse(NEMA17_19.text, "stage").unwrap();
    is_that_of_the_bench(&design.with_all([("fixed_member", "output")]).unwrap());
}

#[test]
fn worn_drives_move() {
    let design = StageDesign::parse(NEMA17_19.text, "stage").unwrap();
    let worn =
        simulate::run(&design, &options("hours = 500\nload = \"constant\"\nend_s = 0.15"), &NoHost).unwrap();
    let new = simulate::run(&design, &options("load = \"constant\"\nend_s = 0.15"), &NoHost).unwrap();
    let mean = |run: &simulate::StageMotion| run.motion.result.statistics.unwrap().mean_abs / ARCMIN;
    assert!(mean(&worn) > mean(&new), "{} {}", mean(&worn), mean(&new));
    assert_eq!(worn.summary().number("hours"), Some(500.0));
}
